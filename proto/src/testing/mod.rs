//! Equipment of the tests of other crates: made-up input, and a proxy that breaks connections.

pub mod hostile;
pub mod proxy;
