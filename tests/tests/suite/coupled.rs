//! Whole runs through the command line: servers as separate processes against one process.

use std::path::Path;

use crate::bench;
use tests::bench::{Bench, digests, text};

/// Runs `case` in every way that must not matter and compares the digests of all particles.
fn every_way_of_running_agrees(bench: &Bench, case: &Path) {
    let split = bench.run(case, "split", &[]);
    let reference = digests(&split);
    assert_eq!(digests(&bench.run(case, "one", &["--in-process"])), reference);
    for threads in ["1", "2", "4"] {
        let summary = bench.run(case, threads, &["--threads", threads]);
        assert_eq!(digests(&summary), reference, "{threads} threads per server");
    }
    // Strict lock-step grants one step at a time; it changes nothing either.
    assert_eq!(digests(&bench.run(case, "window", &["--window", "1"])), reference);
}

#[test]
fn two_processes_equal_one_process_bit_for_bit_on_any_number_of_threads() {
    let bench = bench();
    every_way_of_running_agrees(&bench, &bench.coarse(0.04, &[]));
}

#[test]
fn the_solid_of_the_source_paper_agrees_bit_for_bit_too() {
    let bench = bench();
    // Updated-Lagrangian bodies under the stage rule, by default.
    every_way_of_running_agrees(&bench, &bench.tank_to(0.02, None));
}

#[test]
fn each_arithmetic_path_agrees_with_itself_and_is_reported() {
    let bench = bench();
    let case = bench.coarse(0.004, &[]);
    let mut of_paths = Vec::new();
    for path in sph::lanes::Arithmetic::all() {
        let option = if path.name() == "f64x4-portable" { "portable" } else { "avx2" };
        let force = ["--arithmetic", option];
        let split = bench.run(&case, &format!("split-{option}"), &force);
        let one = bench.run(&case, &format!("one-{option}"), &["--in-process", force[0], force[1]]);
        assert_eq!(digests(&split), digests(&one), "{option}");
        let report = std::fs::read_to_string(bench.path(&format!("split-{option}/report.html"))).unwrap();
        assert!(report.contains(path.name()), "the report names {}", path.name());
        of_paths.push(digests(&split));
    }
    // Fused products round otherwise: were the digests equal, the option would do nothing.
    assert!(of_paths.windows(2).all(|pair| pair[0] != pair[1]));
    bench.refused(&["run", text(&case), "--arithmetic", "sse"], 2, &["portable", "avx2"]);
}

#[test]
fn loads_and_states_of_one_solid_agree_bit_for_bit() {
    let bench = bench();
    let case = |kind: &str| {
        bench.tank(&format!("{kind}.toml"), &[("[interface]", &format!("[interface]\nkind = \"{kind}\""))])
    };
    // The fluid evaluates the same pairs in the same order for the solid's samples as the solid for itself.
    let states = bench.run(&case("states"), "states", &[]);
    let loads = bench.run(&case("loads"), "loads", &[]);
    assert_eq!(digests(&loads), digests(&states));
    assert_eq!(digests(&bench.run(&case("loads"), "one", &["--in-process"])), digests(&states));
    assert_eq!(loads["ledger"]["breaches"], 0);
    let work = |summary: &serde_json::Value| summary["ledger"]["largest_force_imbalance"]["value"].as_f64();
    // The solid sums the forces on its samples, the fluid those on its particles: two sums of their own.
    assert!(work(&loads).is_some_and(|worst| worst < 1e-12), "{:?}", work(&loads));
}

#[test]
fn loads_do_not_go_with_the_plain_sum() {
    let bench = bench();
    let interface = "[interface]\nkind = \"loads\"\nlaw = \"plain-sum\"";
    let case = bench.tank("case.toml", &[("[interface]", interface)]);
    bench.case_refused(&case, &["interface.kind", "plain-sum", "use the law `wall`"]);
}

#[test]
#[ignore = "takes some minutes; run it by `cargo test --release -p tests -- --ignored`"]
fn the_whole_coarse_case_agrees_bit_for_bit() {
    let bench = bench();
    every_way_of_running_agrees(&bench, &bench.coarse(0.5, &[]));
}

#[test]
fn the_ledger_closes_and_the_results_are_complete() {
    let bench = bench();
    let case = bench.coarse(0.01, &[]);
    let summary = bench.run(&case, "out", &[]);
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
        assert!(summary[side]["peak_memory_bytes_per_particle"].as_f64().unwrap() > 100.0, "{side}");
        assert!(summary[side]["waited_seconds"].as_f64().unwrap() >= 0.0);
        assert_eq!(summary[side]["counts"]["lost"], 0);
    }
    assert!(summary["particle_stages_per_second"].as_f64().unwrap() > 0.0);
    let out = bench.path("out");
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
    let bench = bench();
    let case = bench.coarse(0.001, &[]);
    bench.run(&case, "out", &["--in-process"]);
    let out = bench.path("out");
    let again = bench.call(&["run", text(&case), "--in-process", "--out", text(&out)]);
    assert_eq!(again.status.code(), Some(3));
    let message = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(message.contains("--force"), "{message}");
    bench.run(&case, "out", &["--in-process", "--force"]);
}

#[test]
fn a_run_that_no_server_takes_leaves_the_earlier_one_and_no_recording() {
    let bench = bench();
    let case = bench.coarse(0.001, &[]);
    let before = bench.run(&case, "out", &["--in-process"]);
    let (out, record) = (bench.path("out"), bench.path("frames"));
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let run = ["run", text(&case), "--quiet", "--force", "--out", text(&out), "--solid", &address];
    let refused = [&run[..], &["--relay", "--record", text(&record)]].concat();
    bench.refused(&refused, 4, &[&address, "cannot be reached"]);
    assert_eq!(bench.summary("out"), before);
    assert!(out.join("report.html").exists() && !out.join("run.partial").exists() && !record.exists());
    bench.run(&case, "out", &["--force"]);
    assert!(bench.summary("out") != before);
}

#[test]
fn errors_of_a_case_are_reported_with_place_and_remedy() {
    let bench = bench();
    let case = bench.coarse(0.01, &[("sound_speed_m_s", "sound_sped_m_s = 25.0")]);
    let output = bench.call(&["check", text(&case)]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("sound_speed_m_s") && message.contains("case.toml:"), "{message}");
}

#[test]
fn an_address_without_a_server_is_named() {
    let bench = bench();
    let case = bench.coarse(0.01, &[]);
    // Bound and dropped: the port is free now.
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let out = bench.path("out");
    let arguments = ["run", text(&case), "--quiet", "--out", text(&out), "--solid", &address];
    bench.refused(&arguments, 4, &[&address, "cannot be reached"]);
}
