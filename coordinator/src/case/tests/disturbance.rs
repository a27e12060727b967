//! `[run]`: members of an ensemble.

use super::*;

fn displaced(table: &str) -> Vec<sph::space::Vector> {
    let case = good(&tank_with(&[("[domain]", &format!("{table}\n[domain]"))]));
    case.fluid_setup().unwrap().plane().unwrap().particles.position
}

#[test]
fn a_seed_displaces_every_water_particle_a_little_and_nothing_else() {
    let still = displaced("");
    let first = displaced("[run]\nseed = 7");
    // By default at most 0.01 of the spacing of 10 mm along each axis.
    let moves: Vec<f64> = first.iter().zip(&still).map(|(a, b)| (a - b).amax()).collect();
    assert!(moves.iter().all(|by| *by > 0.0 && *by <= 1e-4 * (1.0 + 1e-9)), "{moves:?}");
    // Of hundreds of uniform displacements the largest is near its bound.
    assert!(moves.iter().copied().fold(0.0, f64::max) > 0.9e-4);
    assert_eq!(first, displaced("[run]\nseed = 7"));
    assert_ne!(first, displaced("[run]\nseed = 8"));
    let wide = displaced("[run]\nseed = 7\ndisplacement_fraction = 0.02");
    let ratio = (wide[3] - still[3]).amax() / (first[3] - still[3]).amax();
    // Round-off of positions of 0.1 m against displacements of 1e-4 m.
    assert!((ratio - 2.0).abs() < 1e-9, "{ratio}");
    let [with, without] =
        ["[run]\nseed = 7\n[domain]", "[domain]"].map(|text| good(&tank_with(&[("[domain]", text)])));
    assert_eq!(
        with.solid_setup().unwrap().plane().unwrap().particles,
        without.solid_setup().unwrap().plane().unwrap().particles
    );
    let (with, without) =
        (with.fluid_setup().unwrap().plane().unwrap(), without.fluid_setup().unwrap().plane().unwrap());
    assert_eq!(
        (with.wall_particles, with.particles.density),
        (without.wall_particles, without.particles.density)
    );
}

#[test]
fn the_member_is_in_resolved_case_identity_header_and_parameters() {
    let text = tank_with(&[("[domain]", "[run]\nseed = 7\n[domain]")]);
    let case = good(&text);
    assert!(case.resolved_toml().contains("[run]\nseed = 7\ndisplacement_fraction = 0.01\n"));
    assert_eq!(good(&case.resolved_toml()).resolved_toml(), case.resolved_toml());
    assert_ne!(case.identity(), good(&text.replace("seed = 7", "seed = 8")).identity());
    // Checkpoints of cases without the table stay usable.
    assert!(!good(TANK).identity().contains("[run]"));
    assert!(case.summary().active_terms.iter().any(|term| term.text.contains("seed = 7")));
    assert_eq!(case.parameters()["run.seed"], 7);
}

#[test]
fn wrong_members_are_refused() {
    for (table, needle, problem) in [
        ("[run]\ndisplacement_fraction = 0.02", "[run]", "has no `seed`"),
        ("[run]\nseed = -1", "-1", "out of range"),
        ("[run]\nseed = 1\ndisplacement_fraction = 0.2", "0.2", "out of range"),
        ("[run]\nseed = 1\ndisplacement_fraction = 0.0", "0.0", "out of range"),
    ] {
        let text = tank_with(&[("[domain]", &format!("{table}\n[domain]"))]);
        assert_eq!(only_error(&text, needle).problem, problem, "{table}");
    }
}
