//! Lost servers: what is said of them, what is kept of them, and when they are not started again.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::{PROGRAM, bench};
use sph::coupling::stage::{Stage, StepStage};
use tests::bench::{children_of, command_line, signal, text, wait_for_checkpoint, wait_for_first_frame};
use tests::doubles::{Double, Wrong, serve};

#[test]
fn servers_that_fall_silent_together_are_both_named_with_what_each_said_last() {
    let bench = bench();
    let case = bench.tank_to(0.4, None);
    let out = bench.path("out");
    let mut run = Command::new(PROGRAM)
        .args(["run", text(&case), "--quiet", "--threads", "1", "--out", text(&out), "--silence", "3"])
        .args(["--max-restarts", "0", "--checkpoint-every-steps", "100"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for_checkpoint(&out);
    let servers: Vec<u32> =
        children_of(run.id()).into_iter().filter(|child| command_line(*child).contains("node-")).collect();
    assert_eq!(servers.len(), 2);
    servers.iter().for_each(|server| signal("STOP", *server));
    let status = run.wait().unwrap();
    let said = std::io::read_to_string(run.stderr.take().unwrap()).unwrap();
    assert_eq!(status.code(), Some(7), "{said}");
    for words in ["lost the fluid solver", "lost the solid solver"] {
        assert!(said.contains(words), "no {words:?} in {said}");
    }
    // Reports come each fraction of a millisecond, other signs of life each second.
    let last: Vec<&str> = said.split("its last sign of life was a report, after ").skip(1).collect();
    assert_eq!(last.len(), 2, "{said}");
    for rest in last {
        let steps: u64 = rest.split_once(" completed steps").unwrap().0.parse().unwrap();
        assert!(steps >= 100, "{said}");
    }
}

#[test]
fn a_server_that_ends_at_the_same_step_each_time_is_not_started_a_third_time_again() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let out = bench.path("out");
    let doomed = env!("CARGO_BIN_EXE_doomed");
    let arguments = ["run", text(&case), "--quiet", "--out", text(&out), "--solid-bin", doomed];
    let words = [
        "lost the solid solver",
        "the process of the solid solver ended by exit status: 3",
        // What it printed, at the end of the message.
        "solid-server-2.log`:\n",
        "\n  this solver ends here",
        "3 times in a row at step 20",
        "not started again",
    ];
    bench.refused(&[&arguments[..], &["--max-restarts", "10"]].concat(), 7, &words);
    let summary = bench.summary("out");
    assert_eq!(summary["restarts"].as_array().unwrap().len(), 2, "{}", summary["restarts"]);
    let log = |name: &str| out.join("logs").join(name).exists();
    assert!(log("solid-server.log") && log("solid-server-2.log") && !log("solid-server-3.log"));
}

#[test]
fn resuming_keeps_the_logs_of_the_first_part_and_replacing_the_results_removes_them() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    bench.run(&case, "out", &[]);
    let logs = bench.path("out/logs");
    let read = |name: &str| std::fs::read_to_string(logs.join(name)).unwrap();
    let first = read("fluid-server.log");
    assert!(first.contains("run ended") && !first.contains('\u{1b}'), "{first:?}");
    let output = bench.call(&["resume", text(&bench.path("out")), "--quiet", "--until", "0.003"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(read("fluid-server.log"), first);
    assert!(read("fluid-server-1.log").contains("run ended"));
    bench.run(&case, "out", &["--force"]);
    assert!(!logs.join("fluid-server-1.log").exists());
    assert_ne!(read("fluid-server.log"), first);
}

#[test]
fn a_server_that_cannot_start_shows_how_it_ended_and_its_log() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    // It says where it listens, and ends.
    let script = bench.write("gone", "#!/bin/sh\necho 'LISTEN 127.0.0.1:9'\necho 'no licence' >&2\nexit 5\n");
    assert!(Command::new("chmod").args(["755", text(&script)]).status().unwrap().success());
    let out = bench.path("out");
    bench.refused(
        &["run", text(&case), "--quiet", "--out", text(&out), "--solid-bin", text(&script)],
        4,
        &["the solid server", "ended before its run began, by exit status: 5", "no licence"],
    );
}

#[test]
fn a_solver_that_hangs_does_not_hold_up_a_run_that_was_given_up() {
    let bench = bench();
    let at = StepStage { step: 12, stage: Stage::Corrector };
    let server = serve(Double(Wrong::Delay(at, Duration::from_secs(60))));
    let address = server.address.to_string();
    let (case, out) = (bench.tank("case.toml", &[]), bench.path("out"));
    let mut run = Command::new(PROGRAM)
        .args(["run", text(&case), "--quiet", "--out", text(&out), "--solid", &address])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    wait_for_first_frame(&out, &mut run, Duration::from_millis(20));
    std::thread::sleep(Duration::from_secs(1));
    let asked = Instant::now();
    signal("INT", run.id());
    std::thread::sleep(Duration::from_millis(200));
    signal("INT", run.id());
    // 20 s for the last word of a solver, 5 s for its server to close the run, and time for all else.
    let mut status = None;
    while status.is_none() && asked.elapsed() < Duration::from_secs(40) {
        std::thread::sleep(Duration::from_millis(50));
        status = run.try_wait().unwrap();
    }
    let status = status.unwrap_or_else(|| {
        run.kill().unwrap();
        run.wait().unwrap()
    });
    assert_eq!(status.code(), Some(8), "after {:?}", asked.elapsed());
    assert!(Path::new(&out).join("summary.json").exists());
}
