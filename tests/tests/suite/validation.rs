//! Short members of the verification suite: each has to meet its goals, and to have the figures that are stored in
//! `tests/reference/regression.toml`. `validate --quick --store` stores new ones.

use tests::validation::runner::{Options, Run};
use tests::validation::{cases, regression, template};

/// Runs the quick members of `name` and checks every goal; `expected` is the least number of goals.
fn meets_its_goals(name: &str, expected: usize) {
    let folder = tempfile::tempdir().unwrap();
    let options =
        Options { out: folder.path().to_path_buf(), threads: Some(1), changes: Vec::new(), reuse: false };
    let case = cases::all().into_iter().find(|case| case.name() == name).unwrap();
    let (mut figures, mut runs, mut differences) = (Vec::new(), Vec::new(), Vec::new());
    let stored = regression::stored().unwrap();
    let series = stored.get(name).unwrap_or_else(|| panic!("no series of `{name}` is stored"));
    for member in case.members().into_iter().filter(|member| member.quick) {
        let run = Run::of(case, member, &options).unwrap();
        let of_run = case.figures(&run).unwrap();
        differences.extend(series.differences(&run.member.label(), &of_run));
        figures.extend(of_run);
        runs.push(run);
    }
    let compared = case.comparison(&runs).unwrap();
    differences.extend(series.differences(regression::COMPARISON, &compared));
    figures.extend(compared);
    assert!(differences.is_empty(), "tolerance {}: {}\n{differences:#?}", series.tolerance, series.reason);
    for figure in &figures {
        assert_ne!(figure.passes(), Some(false), "{figure:?}");
    }
    let judged = figures.iter().filter(|figure| figure.passes().is_some()).count();
    assert!(judged >= expected, "{judged} goals");
}

#[test]
fn a_drop_stretches_as_it_should() {
    meets_its_goals("drop", 3);
}

#[test]
fn a_square_patch_turns_without_voids() {
    meets_its_goals("square_patch", 6);
}

#[test]
fn a_small_dam_break_keeps_its_energy_and_its_particles() {
    meets_its_goals("dam_break", 2);
}

#[test]
fn a_full_tank_that_turns_keeps_its_pressure_and_blocks_meet_without_ringing() {
    meets_its_goals("full_tank", 4);
    meets_its_goals("full_vessel", 3);
    meets_its_goals("full_vessel_3d", 3);
    meets_its_goals("meeting_patches", 2);
}

#[test]
fn the_force_on_a_wall_is_the_momentum_that_a_jet_brings() {
    meets_its_goals("jet", 3);
}

#[test]
fn beams_and_bars_swing_and_bend_as_they_should() {
    let cases = [
        ("cantilever", 2),
        ("static_cantilever", 2),
        ("plate_stiffness", 1),
        ("turek_hron", 1),
        ("elastic_bar", 4),
    ];
    for (name, goals) in cases {
        meets_its_goals(name, goals);
    }
}

#[test]
fn free_solids_keep_momentum_and_energy() {
    for (name, goals) in [("spinning_square", 2), ("spinning_cube", 7), ("rings", 5), ("solid_hard", 2)] {
        meets_its_goals(name, goals);
    }
}

#[test]
fn bodies_slide_rest_and_fold_without_overlap() {
    for (name, goals) in [("incline", 1), ("stack", 7), ("fold", 2)] {
        meets_its_goals(name, goals);
    }
}

#[test]
fn water_rests_in_a_spherical_tank() {
    meets_its_goals("still_water_sphere", 2);
}

#[test]
fn a_thin_plate_separates_two_fluid_regions() {
    meets_its_goals("thin_plate", 11);
}

#[test]
fn a_block_leaves_the_floor_under_its_weight_less_its_buoyancy() {
    meets_its_goals("lift", 3);
}

#[test]
fn flow_without_slip_meets_an_elastic_slab_at_its_face() {
    meets_its_goals("slab", 4);
}

#[test]
fn all_members_have_case_files_and_places_of_their_own() {
    let mut labels = Vec::new();
    for case in cases::all() {
        for member in case.members() {
            let file = template::folder().join(member.file).with_extension("toml");
            let text = template::instantiate(&file, &member.changes).unwrap();
            let (end, last_picture) = end_and_last_picture(&text);
            assert!(last_picture <= end, "{}: a picture at {last_picture} s", member.label());
            labels.push(format!("{}/{}", case.name(), member.label()));
        }
    }
    let count = labels.len();
    labels.sort();
    labels.dedup();
    assert_eq!(labels.len(), count);
}

/// Time of the end and of the last picture \[s\] of a case file.
fn end_and_last_picture(text: &str) -> (f64, f64) {
    let file: toml::Table = text.parse().unwrap();
    // Whole numbers among them.
    let number = |value: &toml::Value| value.to_string().parse::<f64>().unwrap();
    let pictures = file.get("outputs").and_then(|outputs| outputs.get("picture_times_s")?.as_array());
    let times = pictures.into_iter().flatten().map(number);
    (number(&file["time"]["end_time_s"]), times.fold(0.0, f64::max))
}
