//! Every shipped case runs: two steps with both solvers. In some more steps energy budgets close; the program `energy`
//! goes through all cases.

use tests::first_steps::{LARGEST_ENERGY_RESIDUAL, first_steps};
use tests::source_tree::case_files;

#[test]
fn every_shipped_case_takes_two_steps() {
    let cases = case_files();
    assert!(cases.len() > 50, "{} cases", cases.len());
    for path in cases {
        let sides = first_steps(&path, 2, 1).unwrap();
        assert!(!sides.is_empty(), "{}", path.display());
        for side in sides {
            assert_eq!(side.step, 2, "{}: {side:?}", path.display());
            assert!(side.time > 0.0, "{}: {side:?}", path.display());
        }
    }
}

#[test]
fn energy_budgets_close() {
    let named = ["drifting_body_coarse", "floating_body", "still_water"];
    let cases = case_files();
    let mut seen = 0;
    for path in cases.iter().filter(|path| named.iter().any(|name| path.ends_with(format!("{name}.toml")))) {
        for side in first_steps(path, 150, 1).unwrap() {
            let share = side.energy.residual_share().unwrap();
            assert!(share < LARGEST_ENERGY_RESIDUAL, "{}: {:?}", path.display(), side.role);
            seen += 1;
        }
    }
    assert!(seen >= named.len(), "{seen} sides");
}

/// In the plane and in space, alone and with solids by either kind of coupling, with walls that move, periodic sides and
/// sides through which water may leave.
#[test]
fn the_number_of_parts_of_the_fluid_changes_no_bit() {
    let named = [
        "drifting_body_coarse",
        "floating_body",
        "light_float",
        "paddle_3d",
        "elastic_gate",
        "debris_3d_coarse",
        "taylor_green_3d",
        "still_water_3d",
    ];
    let cases = case_files();
    let mut seen = 0;
    for path in cases.iter().filter(|path| named.iter().any(|name| path.ends_with(format!("{name}.toml")))) {
        let digests = |parts| {
            let sides = first_steps(path, 12, parts).unwrap();
            sides.into_iter().map(|side| (side.role, side.time.to_bits(), side.digest)).collect::<Vec<_>>()
        };
        let one = digests(1);
        for parts in [2, 3, 5, 8] {
            assert_eq!(digests(parts), one, "{} in {parts} parts", path.display());
        }
        seen += 1;
    }
    assert_eq!(seen, named.len());
}
