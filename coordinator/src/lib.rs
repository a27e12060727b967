//! coordinator

pub mod output;
