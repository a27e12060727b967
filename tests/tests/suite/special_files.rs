//! Pipes and devices in the place of files, and files that may not grow.

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::{PROGRAM, bench};
use tests::bench::{soon, text};

#[test]
fn a_device_in_the_place_of_a_token_file_is_not_said_to_be_missing() {
    let bench = bench();
    for (file, words) in [("/dev/zero", "is not a regular file"), ("/nowhere", "no such file")] {
        let keys = format!("[servers]\ntoken_file = {file:?}\n[outputs]");
        let case = bench.tank("case.toml", &[("[outputs]", &keys)]);
        bench.case_refused(&case, &["token_file", words]);
    }
}

/// Runs a command in a shell and waits for its end; fails instead of hanging.
fn within(command: &str, limit: Duration) -> (Option<i32>, String) {
    let mut child = Command::new("bash").args(["-c", command]).stderr(Stdio::piped()).spawn().unwrap();
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > limit {
            drop(child.kill());
            panic!("{command} hangs");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    (status.code(), std::io::read_to_string(child.stderr.take().unwrap()).unwrap())
}

#[test]
fn pipes_in_the_place_of_files_hold_nothing_up() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    bench.run(&case, "out", &["--checkpoint-every-steps", "20"]);
    let out = bench.path("out");
    let pipe = |path: &Path| {
        std::fs::remove_file(path).unwrap();
        assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    // One that is put in the place of each file of the newest checkpoint: the one before is used.
    let newest = out.join("checkpoints/step_000000000050");
    let exec = format!("exec {PROGRAM}");
    for (name, passes) in [
        ("checkpoints/step_000000000050/manifest.json", true),
        ("checkpoints/step_000000000050/fluid.bin", true),
        ("checkpoints/step_000000000050/coordinator.bin", true),
        ("case.toml", false),
        ("probes.csv", false),
        ("run.partial", false),
    ] {
        let path = out.join(name);
        let kept = path.exists().then(|| std::fs::read(&path).unwrap());
        std::fs::write(&path, "").unwrap();
        pipe(&path);
        let command = format!("{exec} resume {} --fluid 127.0.0.1:1 --quiet", text(&out));
        let (code, said) = within(&command, Duration::from_secs(30));
        assert!(matches!(code, Some(2..=4)), "{name}: {said}");
        assert_eq!(said.contains("skipped checkpoint"), passes, "{name}: {said}");
        std::fs::remove_file(&path).unwrap();
        if let Some(kept) = kept {
            std::fs::write(&path, kept).unwrap();
        }
    }
    assert!(newest.exists());
    // A log, which is written.
    pipe(&out.join("logs/fluid-server.log"));
    let again = format!("{exec} run {} --quiet --force --out {}", text(&case), text(&out));
    let (code, said) = within(&again, Duration::from_secs(60));
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("logs/fluid-server.log") && said.contains("is no file"), "{said}");
    std::fs::remove_file(out.join("logs/fluid-server.log")).unwrap();
    // A state to start from.
    pipe(&out.join("final/solid.state"));
    let tank = std::fs::read_to_string(&case).unwrap();
    let next = bench.write("next.toml", &format!("start_from = \"out\"\n{tank}"));
    let (code, said) = within(&format!("{exec} check {}", text(&next)), Duration::from_secs(30));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("solid.state") && said.contains("is not a regular file"), "{said}");
}

#[test]
fn a_server_beyond_the_largest_file_is_not_ended_by_a_signal() {
    let bench = bench();
    let trace = bench.path("trace");
    let limited = format!(
        "ulimit -f 0; exec {PROGRAM} node-fluid --listen 127.0.0.1:0 --threads 1 --trace {}",
        text(&trace)
    );
    let mut command = Command::new("bash");
    command.args(["-c", &limited]).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut server = command.spawn().unwrap();
    let mut line = String::new();
    let mut output = std::io::BufReader::new(server.stdout.take().unwrap());
    std::io::BufRead::read_line(&mut output, &mut line).unwrap();
    assert!(Command::new("kill").args(["-TERM", &server.id().to_string()]).status().unwrap().success());
    let mut status = None;
    soon("the server's end", || {
        status = server.try_wait().unwrap();
        status.is_some()
    });
    let said = std::io::read_to_string(server.stderr.take().unwrap()).unwrap();
    assert!(line.starts_with("LISTEN"), "{line}, {said}");
    assert_eq!(status.unwrap().signal(), None, "{said}");
    assert!(said.contains("the trace is not complete"), "{said}");
}
