//! Iterated half-steps in whole runs: bits, checkpoints, recordings, refusals, and what they are for.

use std::path::{Path, PathBuf};

use crate::bench;
use serde_json::Value;
use tests::bench::{Bench, digests, text};
use tests::doubles::{Double, Wrong, serve};
use tests::kill::same_results;

/// Tight enough for several iterations in each step of the tank.
const ITERATE: &str = "[interface]\niterate = { tolerance = 1e-9 }";

/// The scheme whose forces answer to the solid within a step.
const SCHEME: (&str, &str) = ("[fluid]", "[fluid]\nscheme = \"predictor-corrector\"");

fn tank(bench: &Bench, name: &str, changes: &[(&str, &str)]) -> PathBuf {
    let changes: Vec<_> = [("[interface]", ITERATE), SCHEME].iter().chain(changes).copied().collect();
    bench.tank(name, &changes)
}

fn number(summary: &Value, path: &str) -> f64 {
    summary.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {summary:#}"))
}

/// Shares of checks that hold in every iterated run.
fn sound(summary: &Value) {
    assert_eq!(summary["ledger"]["breaches"], 0);
    assert!(number(summary, "/iterations/mean") >= 1.0, "{}", summary["iterations"]);
    assert_eq!(summary["iterations"]["unsettled_steps"], 0);
    // The momentum budget has the accepted iteration alone: the tolerance of the design.
    for check in ["force_imbalance", "torque_imbalance", "fluid_momentum_residual", "solid_momentum_residual"]
    {
        let worst = number(summary, &format!("/ledger/largest_{check}/value"));
        assert!(worst < 1e-12, "{check}: {worst:e}");
    }
}

#[test]
fn two_processes_equal_one_and_a_relay_changes_nothing() {
    let bench = bench();
    // Updated-Lagrangian bodies under the stage rule and in sub-steps, and rigid ones.
    let elastic = "formulation = { type = \"updated-lagrangian\" }";
    for (name, change) in [
        ("stages", ("[solid]", "[solid]")),
        ("substeps", ("[solid]", "[solid]\nsubsteps = 4")),
        ("rigid", (elastic, "formulation = { type = \"rigid\" }")),
    ] {
        let case = tank(&bench, &format!("{name}.toml"), &[change]);
        let split = bench.run(&case, name, &["--threads", "2"]);
        sound(&split);
        let one = bench.run(&case, &format!("{name}-one"), &["--in-process", "--threads", "1"]);
        assert_eq!(digests(&split), digests(&one), "{name}");
        assert_eq!(split["iterations"], one["iterations"], "{name}");
        let relayed = bench.run(&case, &format!("{name}-relay"), &["--relay"]);
        assert_eq!(digests(&split), digests(&relayed), "{name}");
        let report = std::fs::read_to_string(bench.path(name).join("report.html")).unwrap();
        assert!(report.contains("forces agree to 1e-9 of gross"), "{name}");
    }
}

#[test]
fn a_run_goes_on_from_a_checkpoint_with_the_bits_of_one_run() {
    let bench = bench();
    let to = |end: &str| tank(&bench, "tank.toml", &[("end_time_s = 0.002", &format!("end_time_s = {end}"))]);
    sound(&bench.run(&to("0.002"), "whole", &[]));
    bench.run(&to("0.0012"), "parts", &["--in-process"]);
    let out = bench.path("parts");
    let output = bench.call(&["resume", text(&out), "--quiet", "--until", "0.002"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    same_results(&bench.path("whole"), &out).unwrap();
    assert_eq!(bench.summary("parts")["iterations"], bench.summary("whole")["iterations"]);
}

#[test]
fn recordings_hold_all_iterations_and_either_side_repeats_them() {
    let bench = bench();
    let case = tank(&bench, "tank.toml", &[]);
    let record = |case: &Path, name: &str| {
        let file = bench.path(&format!("{name}.frames"));
        (digests(&bench.run(case, name, &["--record", text(&file)])), file)
    };
    let (recorded, file) = record(&case, "first");
    for (side, at) in [("fluid", 0), ("solid", 1)] {
        let out = bench.path(&format!("replay-{side}"));
        let output = bench.call(&["replay", text(&case), text(&file), "--side", side, "--out", text(&out)]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{side}: {said}");
        let frames = said.split(" frames of the").next().and_then(|said| said.split_whitespace().last());
        // 50 steps of a predictor, a corrector and at least one iteration.
        assert!(frames.and_then(|word| word.parse::<u32>().ok()).is_some_and(|n| n >= 150), "{said}");
        assert_eq!(digests(&bench.summary(&format!("replay-{side}")))[at], recorded[at], "{side}");
    }
    let (_, again) = record(&case, "again");
    let output = bench.call(&["compare", text(&file), text(&again)]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && said.contains("100 half-steps, equal"), "{said}");
    let loose =
        bench.tank("loose.toml", &[("[interface]", "[interface]\niterate = { tolerance = 1e-3 }"), SCHEME]);
    let (_, other) = record(&loose, "loose");
    bench.refused(&["compare", text(&file), text(&other)], 10, &["step 0 corrector", "iteration"]);
}

#[test]
fn a_float_that_hops_with_one_exchange_rests_with_iterations() {
    let bench = bench();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/validation/light_float.toml");
    let light = std::fs::read_to_string(shipped).unwrap().replace("end_time_s = 0.5", "end_time_s = 0.1");
    let without =
        |text: &str| text.lines().filter(|line| !line.starts_with("iterate")).collect::<Vec<_>>().join("\n");
    // Twenty-five times as heavy it needs no load.
    let heavy = light.replace("20.0", "500.0").replace("-24*9.81", "0");
    let run = |name: &str, text: &str| {
        let summary = bench.run(&bench.write(&format!("{name}.toml"), text), name, &["--in-process"]);
        let table = std::fs::read_to_string(bench.path(name).join("probes.csv")).unwrap();
        let header: Vec<String> = table.lines().next().unwrap().split(',').map(str::to_owned).collect();
        let column = |name: &str| -> Vec<f64> {
            let k = header.iter().position(|column| column == name).unwrap();
            table.lines().skip(1).map(|line| line.split(',').nth(k).unwrap().parse().unwrap()).collect()
        };
        (summary, column("float_centre_y_m"), column("float_velocity_y_m_s"))
    };
    let fastest = |speeds: &[f64]| speeds.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let (_, _, hopping) = run("one", &without(&light));
    assert!(fastest(&hopping) > 0.1, "{} m/s: one exchange bears this float", fastest(&hopping));
    let (summary, centre, resting) = run("iterated", &light);
    sound(&summary);
    // A hundredth of what the other reaches; water finds its balance at some mm/s.
    assert!(fastest(&resting) < 5e-3, "{} m/s", fastest(&resting));
    // The draught of Archimedes is 20 mm, where it was set; 2 % of it.
    assert!(centre.iter().all(|y| (y - 0.08).abs() < 4e-4), "{centre:?}");
    // Of a body that one exchange bears both make the same motion: forces agree to 1e-6 of some 10 N/m on 1.6 kg/m, which
    // in 0.1 s moves it by some 1e-8 m; a tenth of a micrometre leaves room for what water makes of it.
    let ((_, once, _), (_, iterated, _)) = (run("heavy-one", &without(&heavy)), run("heavy", &heavy));
    let apart = once.iter().zip(&iterated).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let way = once.iter().map(|y| (y - once[0]).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-2 * way && apart > 0.0, "{apart:e} m apart on a way of {way:e} m");
}

#[test]
fn a_limit_too_low_stops_in_words_or_is_counted() {
    let bench = bench();
    let tight = |name: &str, more: &str| {
        let iterate = format!("[interface]\niterate = {{ tolerance = 1e-14, limit = 1{more} }}");
        bench.tank(name, &[("[interface]", &iterate)])
    };
    let words = ["corrector", "after 1 iterations", "1e-14", "unsettled = \"accept\""];
    let stopping = tight("stop.toml", "");
    bench.refused(&["run", text(&stopping), "--quiet", "--out", text(&bench.path("stop"))], 5, &words);
    let summary = bench.run(&tight("accept.toml", ", unsettled = \"accept\""), "accept", &[]);
    assert_eq!((&summary["verdict"], &summary["ledger"]["breaches"]), (&"completed".into(), &0.into()));
    assert!(number(&summary, "/iterations/unsettled_steps") > 0.0);
    assert_eq!(number(&summary, "/iterations/largest"), 1.0);
}

#[test]
fn a_server_that_does_not_iterate_is_refused_before_the_first_step() {
    let bench = bench();
    let server = serve(Double(Wrong::NoIterations));
    let case = tank(&bench, "tank.toml", &[]);
    let address = server.address.to_string();
    bench.run_refused(
        &case,
        &["--solid", &address],
        4,
        &["does not offer implicit coupling", "leave out `interface.iterate`"],
    );
}
