//! Case files that are made to hurt, a share of them; `--bin mutants` checks all.

use std::path::Path;
use std::time::Duration;

use crate::PROGRAM;
use tests::mutants::{Limits, Mutants};

#[test]
fn case_files_that_are_made_to_hurt_are_answered_soon_and_with_little_memory() {
    let mutants = Mutants::new(Path::new(PROGRAM), 23);
    assert!(mutants.count() > 300, "{}", mutants.count());
    // Far above what any takes on a machine of its own; the memory is a limit of the system.
    let limits = Limits { time: Duration::from_secs(20), memory: 500 << 20 };
    let found = mutants.judge(limits, 2, false);
    assert!(found.faults.is_empty(), "{:#?}", found.faults);
    assert_eq!(found.checks.len(), mutants.count());
    // Any program takes that: its memory was seen.
    assert!(found.largest().is_some_and(|check| check.memory > 1 << 20));
    // Some are good, most are not.
    assert!((20..found.checks.len() / 2).contains(&found.accepted()), "{}", found.accepted());
}

#[test]
fn accepted_cases_end_their_runs_in_order() {
    let mutants = Mutants::new(Path::new(PROGRAM), 301);
    let limits = Limits { time: Duration::from_secs(20), memory: 500 << 20 };
    let found = mutants.judge(limits, 2, true);
    assert!(found.faults.is_empty(), "{:#?}", found.faults);
    assert_eq!(found.runs.len(), found.accepted());
}
