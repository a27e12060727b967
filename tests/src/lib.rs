//! Tests across real server processes; the program that they start is `tidelock-node`, the coordinator under a name of
//! its own.

pub mod bench;
pub mod doubles;
