//! solid-server
