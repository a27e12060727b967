//! Starts and steps a coupled run.
fn main() {}
