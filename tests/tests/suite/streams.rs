//! No program panics, ends or changes its exit code because its output cannot be written.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::{PROGRAM, bench};
use tests::bench::{children_of, digests, soon, text, wait_for_checkpoint, wait_for_first_frame};
use tests::kill::server_of;
use tests::streams::{Broken, Program, Terminal, Which, command};

/// Far more simulated time than a test waits for.
const LONG: (&str, &str) = ("end_time_s = 0.002", "end_time_s = 100.0");

/// Exit code of `program` with broken streams.
fn code(program: &str, arguments: &[&str], which: Which, broken: Broken) -> Option<i32> {
    command(Path::new(program), arguments, which, broken).status().unwrap().code()
}

/// Calls `program` with each of its streams broken in each way: the exit code must be `expected`.
fn every_way(program: &str, arguments: &[&str], expected: i32) {
    for broken in Broken::ALL {
        for which in Which::ALL {
            let code = code(program, arguments, which, broken);
            assert_eq!(code, Some(expected), "{program} {arguments:?}, {which:?} {broken:?}");
        }
    }
}

#[test]
fn no_command_of_the_coordinator_minds() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let wrong = bench.tank("wrong.toml", &[("sound_speed_m_s = 25.0", "sound_speed = 25.0")]);
    let (out, picture) = (bench.path("out"), bench.path("picture.png"));
    let commands: [(&[&str], i32); 17] = [
        (&["--help"], 0),
        (&["--version"], 0),
        (&["run", "--help"], 0),
        (&["run"], 2),
        (&["run", "missing.toml"], 2),
        (&["run", text(&case), "--force", "--out", text(&out)], 0),
        (&["run", text(&case), "--force", "--out", text(&out), "--quiet"], 0),
        (&["resume", "missing"], 3),
        (&["check", text(&case)], 0),
        (&["check", text(&case), "--resolved"], 0),
        (&["check", text(&case), "--picture", text(&picture)], 0),
        (&["check", text(&wrong)], 2),
        (&["conform", "--list"], 0),
        (&["report", "--list"], 0),
        (&["report", "nothing"], 2),
        (&["compare", "missing", "missing"], 2),
        (&["node-fluid", "--listen", "nowhere"], 2),
    ];
    for (arguments, expected) in commands {
        every_way(PROGRAM, arguments, expected);
    }
}

#[test]
fn no_program_of_the_tests_minds() {
    every_way(env!("CARGO_BIN_EXE_validate"), &["--list"], 0);
    every_way(env!("CARGO_BIN_EXE_validate"), &["nothing"], 2);
    every_way(env!("CARGO_BIN_EXE_soak"), &["--minutes", "-1"], 2);
    every_way(env!("CARGO_BIN_EXE_kill"), &["--program", "missing"], 2);
    let turns = ["--before", "missing", "--after", "missing", "case.toml"];
    every_way(env!("CARGO_BIN_EXE_turns"), &turns, 1);
    for program in [env!("CARGO_BIN_EXE_turns"), env!("CARGO_BIN_EXE_fuzz"), env!("CARGO_BIN_EXE_kill")] {
        every_way(program, &["--help"], 0);
    }
    let fuzz = ["--target", "cases", "--count", "3", "--program", PROGRAM];
    for which in Which::ALL {
        assert_eq!(code(env!("CARGO_BIN_EXE_fuzz"), &fuzz, which, Broken::Full), Some(0), "{which:?}");
    }
}

/// A run of `case` into `out` whose error stream is broken, after its first checkpoint.
fn quiet_run(case: &Path, out: &Path, further: &[&str], broken: Broken) -> Program {
    let mut arguments =
        vec!["run", text(case), "--quiet", "--out", text(out), "--checkpoint-every-steps", "20"];
    arguments.extend(further);
    let run = Program::start(&mut command(Path::new(PROGRAM), &arguments, Which::Errors, broken));
    wait_for_checkpoint(out);
    run
}

fn kill(process: u32, signal: &str) {
    assert!(
        Command::new("kill").args([&format!("-{signal}"), &process.to_string()]).status().unwrap().success()
    );
}

#[test]
fn a_lost_server_is_started_again_though_nothing_can_be_printed() {
    for broken in Broken::ALL {
        let bench = bench();
        let case = bench.tank_to(0.05, None);
        let whole = bench.run(&case, "whole", &[]);
        let mut run = quiet_run(&case, &bench.path("out"), &["--max-restarts", "3"], broken);
        kill(server_of(run.id(), "node-solid").unwrap(), "KILL");
        assert_eq!(run.end(), Some(0), "{broken:?}");
        let summary = bench.summary("out");
        assert_eq!(summary["restarts"].as_array().unwrap().len(), 1, "{broken:?}");
        assert_eq!(digests(&summary), digests(&whole));
    }
}

#[test]
fn a_run_stops_at_a_signal_though_nothing_can_be_printed() {
    for broken in Broken::ALL {
        let bench = bench();
        let mut run = quiet_run(&bench.tank("case.toml", &[LONG]), &bench.path("out"), &[], broken);
        run.signal("INT");
        assert_eq!(run.end(), Some(8), "{broken:?}");
        assert_eq!(bench.summary("out")["verdict"], "stopped");
    }
}

#[test]
fn a_run_outlives_its_terminal() {
    let bench = bench();
    let case = bench.tank_to(0.1, None);
    let out = bench.path("out");
    let mut coordinator = Command::new(PROGRAM);
    let (terminal, mut run) = Terminal::start(coordinator.args(["run", text(&case), "--out", text(&out)]));
    // The bar, which needs a terminal; lines would come every ten seconds.
    terminal.wait_for(" of 0.1 s  kinetic ");
    terminal.close();
    assert!(run.child().try_wait().unwrap().is_none(), "the run was over before its terminal closed");
    assert_eq!(run.end(), Some(0));
    assert_eq!(bench.summary("out")["verdict"], "completed");
}

/// Starts the server of `role` with a broken error stream; process and address.
fn server(role: &str, broken: Broken, address: &Path) -> (Program, String) {
    // Every event is logged: each line fails.
    let mut command =
        command(Path::new(PROGRAM), &[&format!("node-{role}"), "--threads", "1"], Which::Errors, broken);
    command.env("RUST_LOG", "trace").stdout(std::fs::File::create(address).unwrap());
    let program = Program::start(&mut command);
    let mut line = String::new();
    soon("the address of the server", || {
        line = std::fs::read_to_string(address).unwrap();
        line.ends_with('\n')
    });
    (program, line.trim_start_matches("LISTEN ").trim().to_owned())
}

#[test]
fn servers_serve_though_their_log_cannot_be_written() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let own = digests(&bench.run(&case, "own", &[]));
    for broken in Broken::ALL {
        let [(mut fluid, fluid_at), (mut solid, solid_at)] =
            ["fluid", "solid"].map(|role| server(role, broken, &bench.path(role)));
        for run in ["first", "second"] {
            let name = format!("{run}-{broken:?}");
            let summary = bench.run(&case, &name, &["--fluid", &fluid_at, "--solid", &solid_at]);
            assert_eq!(digests(&summary), own, "{name}");
        }
        for server in [&mut fluid, &mut solid] {
            server.signal("TERM");
            assert_eq!(server.end(), Some(0), "{broken:?}");
        }
    }
}

#[test]
fn a_report_that_cannot_be_written_leaves_the_exit_code_and_is_made_again() {
    let bench = bench();
    let case = bench.tank_to(0.1, None);
    let mut run = bench.start(&case, "out");
    // In the way of the report: a folder that is not empty.
    let report = bench.path("out").join("report.html");
    std::fs::create_dir_all(report.join("occupied")).unwrap();
    let (status, message) = run.end();
    assert_eq!(status.code(), Some(0), "{message}");
    for words in ["warning: ", "report.html", "tidelock resume"] {
        assert!(message.contains(words), "no {words:?} in {message}");
    }
    assert_eq!(bench.summary("out")["verdict"], "completed");
    std::fs::remove_dir_all(&report).unwrap();
    assert!(bench.call(&["resume", text(&bench.path("out")), "--quiet"]).status.success());
    assert!(report.is_file());
}

#[test]
fn a_report_of_an_absurd_state_leaves_the_exit_code() {
    let bench = bench();
    // Nothing at the start, so that the case is accepted.
    let force = "gravity_m_s2 = [0.0, -9.81]\nacceleration_m_s2 = [\"1e290*t\", \"0\"]";
    let case = bench.coarse(0.01, &[("gravity_m_s2", force)]);
    let out = bench.path("out");
    // Quiet is about progress: why a run has failed is printed.
    let arguments = ["run", text(&case), "--quiet", "--out", text(&out)];
    bench.refused(&arguments, 5, &["error: ", "diverged at step 0", "allowed"]);
    assert!(out.join("report.html").is_file());
}

#[test]
fn a_hangup_stops_a_run_like_a_request_to_end() {
    let bench = bench();
    let case = bench.tank_to(0.1, None);
    bench.run(&case, "whole", &[]);
    let out = bench.path("out");
    // The tests themselves may run where it is ignored.
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP", PROGRAM, "run", text(&case), "--quiet", "--out", text(&out)]);
    let mut run = Program::start(command.stderr(Stdio::piped()));
    wait_for_first_frame(&out, run.child(), Duration::from_millis(5));
    // A terminal that closes sends it by itself and through the shell: twice is no second request.
    run.signal("HUP");
    run.signal("HUP");
    let code = run.end();
    let message = std::io::read_to_string(run.child().stderr.take().unwrap()).unwrap();
    assert_eq!(code, Some(8), "{message}");
    assert!(message.contains("stopping at the next step boundary"), "{message}");
    assert_eq!(bench.summary("out")["verdict"], "stopped");
    assert!(bench.call(&["resume", text(&out), "--quiet"]).status.success());
    assert_eq!(digests(&bench.summary("out")), digests(&bench.summary("whole")));
}

#[test]
fn a_hangup_that_was_ignored_at_the_start_stays_ignored() {
    let bench = bench();
    let case = bench.tank_to(0.1, None);
    let out = bench.path("out");
    // As `nohup` does.
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", PROGRAM, "run", text(&case), "--quiet", "--out"]);
    let mut run = Program::start(shell.arg(&out));
    wait_for_first_frame(&out, run.child(), Duration::from_millis(5));
    for process in children_of(run.id()).into_iter().chain([run.id()]) {
        kill(process, "HUP");
    }
    assert_eq!(run.end(), Some(0));
    assert_eq!(bench.summary("out")["verdict"], "completed");
}
