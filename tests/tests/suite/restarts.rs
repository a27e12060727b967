//! Cases with one side only, runs that start from others, and what a run's results must not depend on.

use std::path::Path;

use crate::bench;
use coordinator::results::state;
use tests::bench::{digests, probe_rows};

/// `text` without what stands from `from` to before `to`, and without the probes of the given names.
fn without(text: &str, from: &str, to: &str, probes: &[&str]) -> String {
    let start = text.find(from).unwrap();
    let end = start + text[start..].find(to).unwrap();
    let mut rest = format!("{}{}", &text[..start], &text[end..]);
    for probe in probes {
        let name = rest.find(&format!("name = \"{probe}\"")).unwrap();
        let start = rest[..name].rfind("[[probe]]").unwrap();
        let end = rest[name..].find("[[probe]]").map_or(rest.len(), |next| name + next);
        rest.replace_range(start..end, "");
    }
    rest
}

#[test]
fn one_sided_cases_run_with_one_server() {
    let bench = bench();
    let whole = std::fs::read_to_string(bench.tank("whole.toml", &[])).unwrap();
    let uncoupled = without(&whole, "[interface]", "[fluid]", &[]);
    let fluid = without(&uncoupled, "[solid]", "[[probe]]", &["tip", "solids"]);
    let solid = without(&uncoupled, "[fluid]", "[solid]", &["gauge", "water"]);
    for (text, here, absent) in [(fluid, "fluid", "solid"), (solid, "solid", "fluid")] {
        let case = bench.write("case.toml", &text);
        let summary = bench.run(&case, here, &[]);
        assert_eq!(summary["verdict"], "completed");
        assert_eq!(summary["steps"], 50);
        assert!(summary[absent].is_null(), "{}", summary[absent]);
        let out = bench.path(here);
        assert!(out.join(format!("logs/{here}-server.log")).exists());
        assert!(!out.join(format!("logs/{absent}-server.log")).exists(), "no {absent} server was started");
        assert!(!out.join(format!("final/{absent}.state")).exists());
        let one = bench.run(&case, &format!("{here}-one"), &["--in-process"]);
        assert_eq!(digests(&one), digests(&summary));
        assert!(digests(&summary).iter().filter(|digest| digest.is_string()).count() == 1);
    }
}

#[test]
fn spare_interface_particles_change_nothing() {
    let bench = bench();
    let case = |margin: &str| {
        bench.tank("case.toml", &[("margin_spacings = 1", &format!("margin_spacings = {margin}"))])
    };
    let few = bench.run(&case("1"), "few", &[]);
    let many = bench.run(&case("8"), "many", &[]);
    for side in ["fluid", "solid"] {
        let sent =
            |summary: &serde_json::Value| summary[side]["counts"]["largest_interface"].as_u64().unwrap();
        assert!(side == "solid" || sent(&many) > sent(&few), "{side}: {} and {}", sent(&few), sent(&many));
    }
    assert_eq!(digests(&few), digests(&many));
}

#[test]
fn a_run_goes_on_from_the_final_state_of_another() {
    // The same particles in another order: round-off of sums over 300 numbers, carried through 25 steps.
    goes_on("predictor-corrector", 1e-9);
}

#[test]
fn leapfrog_starts_again_from_a_final_state_close_to_where_it_would_have_gone() {
    // A final state has the density of the boundary, and no acceleration of the step before; only a checkpoint holds both.
    // Measured: 4e-4 Pa of a stress of 0.1 Pa; pressures are kilopascals.
    goes_on("leapfrog", 1e-3);
}

/// Whether a run of two parts ends where the whole one does, up to `tolerance`.
fn goes_on(scheme: &str, tolerance: f64) {
    let bench = bench();
    // The volume correction remembers its last reading, which only a checkpoint holds.
    let named = format!("[fluid]\nscheme = \"{scheme}\"\nvolume_correction = 0.0");
    let scheme = ("[fluid]", named.as_str());
    let whole = bench.tank("whole.toml", &[scheme]);
    bench.run(&whole, "whole", &[]);
    let half = [scheme, ("end_time_s = 0.002", "end_time_s = 0.001")];
    bench.run(&bench.tank("half.toml", &half), "half", &[]);
    let rest = [
        scheme,
        ("name = \"tank\"", "name = \"rest\"\nstart_from = \"half\""),
        ("end_time_s = 0.002", "start_time_s = 0.001\nend_time_s = 0.002"),
    ];
    let rest = bench.tank("rest.toml", &rest);
    let summary = bench.run(&rest, "rest", &[]);
    assert_eq!(summary["steps"], 25);

    the_state_is_taken_over_bit_for_bit(&rest, &bench.path("half"));
    let [first, last] = probe_rows(&bench.path("rest"));
    let [_, end_of_half] = probe_rows(&bench.path("half"));
    let [_, end_of_whole] = probe_rows(&bench.path("whole"));
    // What the start shows is round-off with either scheme.
    for (ours, theirs, tolerance) in [(first, end_of_half, 1e-13), (last, end_of_whole, tolerance)] {
        for ((name, a), (_, b)) in ours.iter().zip(&theirs) {
            assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{name}: {a:e} and {b:e}");
        }
    }
}

fn the_state_is_taken_over_bit_for_bit(case: &Path, earlier: &Path) {
    let case = coordinator::case::load(case, &state::read).unwrap();
    let (fluid, solid) = (
        case.fluid_setup().unwrap().plane().unwrap().particles,
        case.solid_setup().unwrap().plane().unwrap().particles,
    );
    let flat =
        |vectors: &[sph::space::Vector]| -> Vec<f64> { vectors.iter().flat_map(|v| [v.x, v.y]).collect() };
    let stress: Vec<f64> = solid.deviatoric_stress.iter().flat_map(|s| [s.xx, s.yy, s.xy]).collect();
    for (side, name, ours) in [
        ("fluid", "position", flat(&fluid.position)),
        ("fluid", "velocity", flat(&fluid.velocity)),
        ("fluid", "density", fluid.density),
        ("solid", "position", flat(&solid.position)),
        ("solid", "velocity", flat(&solid.velocity)),
        ("solid", "density", solid.density),
        ("solid", "deviatoric_stress", stress),
    ] {
        let theirs = state::read(&earlier.join(format!("final/{side}.state"))).unwrap();
        let field = theirs.field(name).unwrap();
        let bits = |values: &[f64]| -> Vec<Vec<u64>> {
            let particles = values.chunks(field.components);
            let mut sorted: Vec<Vec<u64>> =
                particles.map(|p| p.iter().map(|v| v.to_bits()).collect()).collect();
            // Whole sets are compared: each run has its own numbers of particles.
            sorted.sort_unstable();
            sorted
        };
        let own: Vec<f64> = match side {
            // The fluid's state holds its walls too.
            "fluid" => members(&theirs, field.components, &field.values, "water"),
            _ => field.values.clone(),
        };
        assert_eq!(bits(&ours), bits(&own), "{side} {name}");
        assert!(own.iter().any(|value| *value != 0.0), "{side} {name} is all zero");
    }
}

/// Values of the particles of one group.
fn members(
    state: &sph::coupling::solver::ParticleFields,
    components: usize,
    values: &[f64],
    group: &str,
) -> Vec<f64> {
    let group = state.group_names.iter().position(|name| name == group).unwrap();
    let pairs = values.chunks(components).zip(&state.group);
    pairs.filter(|(_, of)| **of as usize == group).flat_map(|(values, _)| values.to_vec()).collect()
}
