//! Frames through the coordinator: relayed, recorded, compared and replayed, with servers as separate processes.

use crate::bench;
use tests::bench::{digests, text};

/// Half-steps of the tank's run: 2 ms in steps of 40 us.
const HALF_STEPS: usize = 100;

#[test]
fn relayed_frames_give_the_bits_of_direct_ones_for_every_kind_of_coupling() {
    let bench = bench();
    let direct = digests(&bench.run(&bench.tank("tank.toml", &[]), "direct", &[]));
    assert_eq!(digests(&bench.run(&bench.tank("tank.toml", &[]), "option", &["--relay"])), direct);
    for kind in ["states", "loads"] {
        let interface = format!("[interface]\npath = \"relay\"\nkind = \"{kind}\"");
        let case = bench.tank(&format!("{kind}.toml"), &[("[interface]", &interface)]);
        let summary = bench.run(&case, kind, &[]);
        assert_eq!(digests(&summary), direct, "{kind}");
        assert_eq!(summary["ledger"]["breaches"], 0);
    }
    let report = |name: &str| std::fs::read_to_string(bench.path(name).join("report.html")).unwrap();
    for relayed in ["option", "states", "loads"] {
        assert!(report(relayed).contains("relayed by the coordinator"), "{relayed}");
    }
    assert!(report("direct").contains("directly between the solvers"));
}

#[test]
fn recordings_of_one_case_are_equal_and_of_another_differ_where_it_begins_to() {
    let bench = bench();
    let record = |name: &str, changes: &[(&str, &str)]| {
        let case = bench.tank(&format!("{name}.toml"), changes);
        let file = bench.path(&format!("{name}.frames"));
        bench.run(&case, name, &["--record", text(&file)]);
        file
    };
    let (first, second) = (record("first", &[]), record("second", &[]));
    let output = bench.call(&["compare", text(&first), text(&second)]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains(&format!("{HALF_STEPS} half-steps, equal")), "{said}");
    // Nothing of the solid's material is felt before its first rates have moved it.
    let softer = record("softer", &[("bulk_modulus_pa = 20e6", "bulk_modulus_pa = 19e6")]);
    bench.refused(
        &["compare", text(&first), text(&softer)],
        10,
        &["step ", "frame of the solid", "particle"],
    );
    let longer = record("longer", &[("end_time_s = 0.002", "end_time_s = 0.003")]);
    let only = format!("after {HALF_STEPS} equal half-steps: only `{}`", longer.display());
    bench.refused(&["compare", text(&first), text(&longer)], 10, &[&only, "step 50 predictor"]);
    bench.refused(&["compare", text(&first), "missing"], 2, &["missing", "cannot be read"]);
    let case = bench.tank("again.toml", &[]);
    bench.run_refused(&case, &["--record", text(&first)], 3, &["first.frames", "exists already"]);
}

#[test]
fn either_side_alone_repeats_the_recorded_run_bit_for_bit() {
    let bench = bench();
    for kind in ["states", "loads"] {
        let case = bench
            .tank(&format!("{kind}.toml"), &[("[interface]", &format!("[interface]\nkind = \"{kind}\""))]);
        let file = bench.path(&format!("{kind}.frames"));
        let recorded = digests(&bench.run(&case, kind, &["--record", text(&file)]));
        for (side, at) in [("fluid", 0), ("solid", 1)] {
            let out = bench.path(&format!("{kind}-{side}"));
            let output =
                bench.call(&["replay", text(&case), text(&file), "--side", side, "--out", text(&out)]);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{kind} {side}: {said}");
            assert!(said.contains(&format!("{HALF_STEPS} frames of the {side} equal")), "{said}");
            let alone = digests(&bench.summary(&format!("{kind}-{side}")));
            assert_eq!(alone[at], recorded[at], "{kind} {side}");
            assert!(alone[1 - at].is_null(), "the partner is played");
        }
    }
}

#[test]
fn a_replay_that_computes_otherwise_is_named_and_another_case_refused() {
    let bench = bench();
    let case = bench.tank("tank.toml", &[]);
    let file = bench.path("frames");
    bench.run(&case, "recorded", &["--record", text(&file), "--arithmetic", "portable"]);
    let replay = |case, further: &[&str], code, words: &[&str]| {
        let out = bench.path("replay");
        let mut arguments =
            vec!["replay", text(case), text(&file), "--quiet", "--force", "--out", text(&out)];
        arguments.extend(further);
        bench.refused(&arguments, code, words);
    };
    if sph::lanes::Arithmetic::all().count() > 1 {
        let other = ["--side", "fluid", "--arithmetic", "avx2"];
        replay(&case, &other, 10, &["does not repeat the recording", "frame of the fluid", "particle"]);
    }
    let softer = bench.tank("softer.toml", &[("bulk_modulus_pa = 20e6", "bulk_modulus_pa = 19e6")]);
    replay(&softer, &["--side", "solid"], 2, &["softer.toml", "give the case that was recorded"]);
    replay(&case, &["--side", "both"], 2, &["must be `fluid` or `solid`"]);
    // Half a recording: the run ends where it does.
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    replay(&case, &["--side", "solid", "--arithmetic", "portable"], 7, &["the recording ends here"]);
}
