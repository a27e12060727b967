//! Runs that end before their end time, and servers that must not outlive them.

use crate::{PROGRAM, bench};
use tests::bench::{Bench, Running, signal, text};

/// Far more simulated time than a test waits for.
const LONG: (&str, &str) = ("end_time_s = 0.002", "end_time_s = 100.0");

#[test]
fn a_signal_stops_at_a_step_boundary_with_results_complete() {
    for name in ["INT", "TERM"] {
        let bench = bench();
        let mut run = bench.start(&bench.tank("case.toml", &[LONG]), "out");
        assert_eq!(run.servers.len(), 2);
        run.signal(name);
        let (status, message) = run.end();
        assert_eq!(status.code(), Some(8), "{name}: {message}");
        assert!(message.contains("step boundary") && message.contains("complete"), "{message}");
        run.servers_end();

        let summary = bench.summary("out");
        assert_eq!(summary["verdict"], "stopped", "{name}");
        let steps = summary["steps"].as_u64().unwrap();
        assert!(steps > 0);
        // Times are sums of steps of 4e-5 s: round-off of some thousand additions.
        let end = summary["simulated"]["end_s"].as_f64().unwrap();
        assert!((end - 4e-5 * steps as f64).abs() < 1e-9 * end, "{end} s after {steps} steps");
        let out = bench.path("out");
        for file in ["probes.csv", "ledger.csv", "case.toml", "report.html", "snapshots/solid.pvd"] {
            assert!(out.join(file).metadata().unwrap().len() > 0, "{name}: {file}");
        }
        assert!(!out.join("run.partial").exists());
        // Both sides ended at the same step: from these states another run can continue.
        for side in ["fluid", "solid"] {
            let state = coordinator::results::state::read(&out.join(format!("final/{side}.state"))).unwrap();
            assert_eq!(state.step, steps, "{side}");
        }
        let last = std::fs::read_to_string(out.join("ledger.csv")).unwrap();
        assert!(last.lines().last().unwrap().starts_with(&format!("{steps}.0,")), "{name}");
    }
}

#[test]
fn a_signal_to_all_processes_stops_with_a_checkpoint() {
    let bench = bench();
    let mut run = bench.start(&bench.tank("case.toml", &[LONG]), "out");
    // As `scancel --full` does; the servers first.
    run.servers.iter().for_each(|server| signal("TERM", *server));
    run.signal("TERM");
    let (status, message) = run.end();
    assert_eq!(status.code(), Some(8), "{message}");
    run.servers_end();
    assert!(bench.path("out/checkpoints").read_dir().unwrap().count() > 0);
}

#[test]
fn a_second_signal_gives_up_at_once_and_leaves_no_server() {
    let bench = bench();
    let mut run = bench.start(&bench.tank("case.toml", &[LONG]), "out");
    run.signal("INT");
    run.signal("TERM");
    let (status, message) = run.end();
    assert_eq!(status.code(), Some(8), "{message}");
    run.servers_end();
}

#[test]
fn servers_end_with_a_coordinator_that_is_killed() {
    let bench = bench();
    let mut run = bench.start(&bench.tank("case.toml", &[LONG]), "out");
    assert_eq!(run.servers.len(), 2);
    run.signal("KILL");
    run.end();
    run.servers_end();
    assert!(bench.path("out").join("run.partial").exists(), "half a run must not look complete");
    assert!(!bench.path("out").join("summary.json").exists());
    assert!(!bench.path("out").join("probes.csv").exists());
}

/// Starts a long run whose solid server is a program that does not watch its input: it lacks the flag by which the
/// coordinator makes its own servers do so.
fn start_with_another_program(bench: &Bench) -> Running {
    let servers = format!("[servers]\nsolid_command = [{PROGRAM:?}, \"node-solid\"]\n[fluid]");
    bench.start(&bench.tank("case.toml", &[LONG, ("[fluid]", &servers)]), "out")
}

#[test]
fn other_programs_end_with_a_coordinator_that_is_killed_though_they_do_not_watch_it() {
    let bench = bench();
    let mut run = start_with_another_program(&bench);
    // Two servers and the guard of one.
    assert_eq!(run.servers.len(), 3);
    run.signal("KILL");
    run.end();
    run.servers_end();
}

#[test]
fn other_programs_and_their_guards_end_with_the_run() {
    let bench = bench();
    let mut run = start_with_another_program(&bench);
    run.signal("INT");
    let (status, message) = run.end();
    assert_eq!(status.code(), Some(8), "{message}");
    run.servers_end();
    assert_eq!(bench.summary("out")["verdict"], "stopped");
    assert!(message.contains(text(&bench.path("out"))), "{message}");
}
