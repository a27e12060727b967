//! fluid-server
