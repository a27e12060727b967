//! Tests across real server processes, one module for each topic.
//!
//! All run in one process. A test that changes what the whole process sees (environment, current directory, arithmetic
//! path, panic hook), or that measures time, is a separate program in the folder above.

mod access;
mod bounds;
mod checkpoints;
mod colours;
mod conformance;
mod coupled;
mod exchange;
mod failures;
mod first_steps;
mod hostile;
mod iterated;
mod losses;
mod lying_solvers;
mod many_runs;
mod mutants;
mod python;
mod recordings;
mod reservations;
mod restarts;
mod results;
mod spatial;
mod special_files;
mod stopping;
mod streams;
mod terminal;
mod tidy;
mod trace;
mod validation;
mod view;

use tests::bench::Bench;

/// The coordinator as the tests start it.
const PROGRAM: &str = env!("CARGO_BIN_EXE_tidelock-node");

/// A new folder for one test, with [`PROGRAM`].
fn bench() -> Bench {
    Bench::new(PROGRAM)
}
