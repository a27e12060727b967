//! Made-up input, some thousand of each kind; `--bin fuzz` feeds a million.

use std::time::Duration;

use crate::bench;
use tests::fuzz::{Findings, Seeds, Target, fuzz};

/// Seed of the inputs; any other does as well.
const SEED: u64 = 7;

/// Feeds `count` inputs: nothing may panic, hang or take much memory.
fn feeds(target: Target, count: u64) -> Findings {
    let bench = bench();
    let seeds = Seeds::in_bench(&bench, target);
    let found = fuzz(target, &seeds, SEED, 0, count);
    let panics: Vec<_> = found.panics.iter().map(|panic| (panic.number, &panic.text)).collect();
    assert!(panics.is_empty(), "{panics:?}");
    assert_eq!(found.inputs, count);
    // Far above what any takes, far below what a user would take for a hang.
    assert!(found.slowest < Duration::from_secs(20), "{found:?}");
    // A scene of the largest allowed number of particles fits; a length from the input, believed, would not.
    assert!(found.memory_growth < 4 << 30, "{found:?}");
    found
}

fn survives(target: Target, count: u64) {
    let found = feeds(target, count);
    // Some survive the damage, or the seeds were no good input; most do not, or nothing was damaged.
    assert!(found.accepted > 0 && found.accepted < count, "{found:?}");
}

#[test]
fn damaged_case_files_are_refused_in_order() {
    survives(Target::Cases, 1500);
}

#[test]
fn damaged_frames_are_refused_in_order() {
    survives(Target::Frames, 20_000);
}

#[test]
fn damaged_messages_are_refused_in_order() {
    survives(Target::Messages, 5000);
}

#[test]
fn damaged_checkpoints_are_refused_in_order() {
    survives(Target::Checkpoints, 2000);
}

#[test]
fn a_damaged_checkpoint_is_passed_over_and_the_one_before_used() {
    let found = feeds(Target::Stores, 1000);
    // Few changes are none, such as of the white space of a manifest.
    assert!(found.accepted < 100, "{found:?}");
}

#[test]
fn damaged_states_that_fit_their_digest_break_no_solver() {
    survives(Target::Restores, 300);
}

#[test]
fn wrong_command_lines_are_refused_in_order() {
    survives(Target::Commands, 1000);
}
