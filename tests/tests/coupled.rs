//! Whole runs through the command line: servers as separate processes against one process.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The coarse drifting-body case cut to `end_time` \[s\], with further lines of its top-level tables replaced.
fn short_case(folder: &Path, end_time: f64, replace: &[(&str, &str)]) -> PathBuf {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/drifting_body_coarse.toml");
    let text = std::fs::read_to_string(shipped).unwrap();
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        if line.starts_with("end_time_s") {
            lines.push(format!("end_time_s = {end_time}"));
        } else if let Some((_, new)) = replace.iter().find(|(key, _)| line.starts_with(key)) {
            lines.push((*new).to_owned());
        } else if !line.starts_with("picture_times_s") {
            lines.push(line.to_owned());
        }
    }
    let path = folder.join("case.toml");
    std::fs::write(&path, lines.join("\n")).unwrap();
    path
}

fn coordinator(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tidelock-node")).args(arguments).output().unwrap()
}

/// Runs `case` into `folder/name`; returns the summary.
fn run(case: &Path, folder: &Path, name: &str, further: &[&str]) -> Value {
    let out = folder.join(name);
    let mut arguments = vec!["run", case.to_str().unwrap(), "--quiet", "--out", out.to_str().unwrap()];
    arguments.extend(further);
    let output = coordinator(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap()
}

fn digests(summary: &Value) -> [String; 2] {
    ["/fluid/state_digest", "/solid/state_digest"]
        .map(|pointer| summary.pointer(pointer).and_then(Value::as_str).unwrap().to_owned())
}

#[test]
fn two_processes_equal_one_process_bit_for_bit_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let case = short_case(folder.path(), 0.02, &[]);
    let split = run(&case, folder.path(), "split", &[]);
    let reference = digests(&split);
    assert_eq!(digests(&run(&case, folder.path(), "one", &["--in-process"])), reference);
    for threads in ["1", "2", "4"] {
        let summary = run(&case, folder.path(), threads, &["--threads", threads]);
        assert_eq!(digests(&summary), reference, "{threads} threads per server");
    }
    // Strict lock-step grants one step at a time; it changes nothing either.
    assert_eq!(digests(&run(&case, folder.path(), "window", &["--window", "1"])), reference);
}

#[test]
fn the_ledger_closes_and_the_results_are_complete() {
    let folder = tempfile::tempdir().unwrap();
    let case = short_case(folder.path(), 0.01, &[]);
    let summary = run(&case, folder.path(), "out", &[]);
    assert_eq!(summary["verdict"], "completed");
    assert_eq!(summary["ledger"]["breaches"], 0);
    for check in ["force_imbalance", "torque_imbalance", "fluid_momentum_residual", "solid_momentum_residual"]
    {
        let worst = summary["ledger"][format!("largest_{check}")]["value"].as_f64().unwrap();
        // The tolerance of the design; round-off of some hundred pair forces is a thousand times smaller.
        assert!(worst < 1e-12, "{check}: {worst:e}");
    }
    for side in ["fluid", "solid"] {
        assert!(summary[side]["process"]["peak_memory_bytes"].as_u64().unwrap() > 1 << 20, "{side}");
        assert!(summary[side]["waited_seconds"].as_f64().unwrap() >= 0.0);
        assert_eq!(summary[side]["counts"]["lost"], 0);
    }
    assert!(summary["particle_stages_per_second"].as_f64().unwrap() > 0.0);
    let out = folder.path().join("out");
    for file in
        ["probes.csv", "ledger.csv", "case.toml", "report.html", "final/fluid.state", "final/solid.state"]
    {
        assert!(out.join(file).metadata().unwrap().len() > 0, "{file}");
    }
    assert!(!out.join("run.partial").exists());
    let header = std::fs::read_to_string(out.join("probes.csv")).unwrap();
    assert!(header.starts_with("t_s,"), "{header:.100}");
}

#[test]
fn an_earlier_run_is_not_overwritten_without_the_flag() {
    let folder = tempfile::tempdir().unwrap();
    let case = short_case(folder.path(), 0.001, &[]);
    run(&case, folder.path(), "out", &["--in-process"]);
    let out = folder.path().join("out");
    let again = coordinator(&["run", case.to_str().unwrap(), "--in-process", "--out", out.to_str().unwrap()]);
    assert_eq!(again.status.code(), Some(3));
    let message = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(message.contains("--force"), "{message}");
    run(&case, folder.path(), "out", &["--in-process", "--force"]);
}

#[test]
fn mistakes_of_a_case_are_told_with_place_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let case = short_case(folder.path(), 0.01, &[("sound_speed_m_s", "sound_sped_m_s = 25.0")]);
    let output = coordinator(&["check", case.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("sound_speed_m_s") && message.contains("case.toml:"), "{message}");
}

#[test]
fn an_address_without_a_server_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let case = short_case(folder.path(), 0.01, &[]);
    // Bound and dropped: nobody listens there now.
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let output = coordinator(&["run", case.to_str().unwrap(), "--quiet", "--out", out, "--solid", &address]);
    assert_eq!(output.status.code(), Some(4));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains(&address), "{message}");
}
