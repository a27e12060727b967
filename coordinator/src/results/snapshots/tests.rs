//! Snapshots of a small case.

use std::fs;

use super::*;

/// Water in a box, a block, and a wall of the name `box`.
const CASE: &str = r#"name = "box"
[domain]
lower_m = [0.0, 0.0]
upper_m = [0.2, 0.2]
[time]
end_time_s = 0.004
step = { type = "adaptive" }
[fluid]
particle_spacing_m = 0.01
sound_speed_m_s = 20.0
rest_density_kg_m3 = 1000.0
[[fluid.region]]
name = "water"
shape = { type = "rectangle", lower_m = [0.0, 0.0], upper_m = [0.2, 0.1] }
[[wall]]
name = "box"
type = "container"
open_sides = ["top"]
"#;

fn case() -> Case {
    crate::case::parse(CASE, "case.toml", Path::new("."), &|_| Err(String::new()))
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Two particles of water and two of the wall, which is at `wall` \[m\].
fn particles(step: u64, wall: f64) -> ParticleFields {
    let field = |name: &str, components: usize, values: Vec<f64>| Field {
        name: name.into(),
        unit: "u".into(),
        components,
        values,
    };
    ParticleFields {
        step,
        time: 0.1 * step as f64,
        id: vec![0, 1, 2, 3],
        group: vec![0, 0, 1, 1],
        group_names: vec!["water".into(), "box".into()],
        fields: vec![
            field("position", 2, vec![0.0, 0.0, 1.0, 0.0, wall, 5.0, wall, 6.0]),
            field("pressure", 1, vec![step as f64, 2.0, 3.0 * step as f64, 4.0]),
            field("mass", 1, vec![0.4, 0.1, 0.1, 0.1]),
            field("density", 1, vec![1000.0; 4]),
        ],
    }
}

fn written(folder: &Path, name: &str) -> String {
    String::from_utf8_lossy(&fs::read(folder.join(name)).unwrap()).into_owned()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn walls_have_files_of_their_own_and_new_ones_only_when_they_move() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    let mut snapshots = Snapshots::create(folder, &case(), &[Role::Fluid]).unwrap();
    for (step, wall) in [(0, 9.0), (1, 9.0), (2, 8.0)] {
        snapshots.write(Role::Fluid, &particles(step, wall)).unwrap();
    }
    let names = files(folder);
    let walls: Vec<&String> = names.iter().filter(|name| name.starts_with("walls_")).collect();
    assert_eq!(walls, ["walls_00000000.vtp", "walls_00000002.vtp"]);
    assert!(names.iter().all(|name| is_ours(name)), "{names:?}");
    let fluid = written(folder, "fluid_00000001.vtp");
    assert!(fluid.contains("NumberOfPoints=\"2\"") && fluid.contains("Name=\"point_radius\""), "{fluid}");
    let wall = written(folder, "walls_00000000.vtp");
    assert!(!wall.contains("pressure") && !wall.contains("TimeValue"), "{wall}");
    // The wall stands at each time of the collection of all, the one that it had then.
    let all = vtk::read_collection(&folder.join(ALL));
    let at = |time: f64| all.iter().filter(|f| f.1 == time).map(|f| f.0.as_str()).collect::<Vec<_>>();
    assert_eq!(at(0.1), ["fluid_00000001.vtp", "walls_00000000.vtp"]);
    assert_eq!(at(0.2), ["fluid_00000002.vtp", "walls_00000002.vtp"]);
}

#[test]
fn a_resumed_series_of_walls_is_that_of_one_that_was_not_stopped() {
    let root = tempfile::tempdir().unwrap();
    let [whole, resumed] = ["whole", "resumed"].map(|name| root.path().join(name));
    let steps = [(0, 9.0), (1, 9.0), (2, 8.0), (3, 8.0)];
    for stop in [1, 2, 3] {
        drop(fs::remove_dir_all(&whole));
        drop(fs::remove_dir_all(&resumed));
        let write = |snapshots: &mut Snapshots, from: u64| {
            for (step, wall) in steps.iter().filter(|(step, _)| *step >= from) {
                snapshots.write(Role::Fluid, &particles(*step, *wall)).unwrap();
            }
        };
        write(&mut Snapshots::create(&whole, &case(), &[Role::Fluid]).unwrap(), 0);
        let mut first = Snapshots::create(&resumed, &case(), &[Role::Fluid]).unwrap();
        write(&mut first, 0);
        let kept = first.files_before(stop);
        let (mut again, missing) = Snapshots::resume(&resumed, &case(), &[Role::Fluid], &kept).unwrap();
        assert!(missing.is_empty());
        write(&mut again, stop);
        assert_eq!(files(&whole), files(&resumed));
        for name in files(&whole) {
            assert_eq!(
                fs::read(whole.join(&name)).unwrap(),
                fs::read(resumed.join(&name)).unwrap(),
                "{name}"
            );
        }
    }
}

#[test]
fn sizes_are_those_of_the_volume() {
    let (water, wall) = split(&particles(0, 9.0), &[false, true]);
    assert_eq!((water.id, wall.id.clone(), wall.group.clone()), (vec![0, 1], vec![2, 3], vec![0, 0]));
    assert_eq!(wall.group_names, ["box"]);
    let sized = with_sizes(&particles(0, 9.0), 0.01, Sizes::Volume);
    // 0.4 kg/m over 1000 kg/m³ is a square of side 0.02 m.
    assert_eq!(sized.field("volume").unwrap().values[0], 4e-4);
    assert!((sized.field("point_radius").unwrap().values[0] - 0.01).abs() < 1e-15);
    let walls = with_sizes(&wall, 0.01, Sizes::Spacing);
    assert!((walls.field("point_radius").unwrap().values[1] - 0.005).abs() < 1e-15);
}

#[test]
fn both_sides_are_shown_at_times_that_both_have() {
    let root = tempfile::tempdir().unwrap();
    let mut snapshots = Snapshots::create(root.path(), &case(), &[Role::Fluid, Role::Solid]).unwrap();
    let solid = ParticleFields { group_names: vec!["a".into(), "b".into()], ..particles(0, 9.0) };
    snapshots.write(Role::Fluid, &particles(0, 9.0)).unwrap();
    assert!(vtk::read_collection(&root.path().join(ALL)).is_empty(), "the solid's has not come");
    snapshots.write(Role::Solid, &solid).unwrap();
    snapshots.write(Role::Fluid, &particles(1, 9.0)).unwrap();
    let names: Vec<String> =
        vtk::read_collection(&root.path().join(ALL)).into_iter().map(|file| file.0).collect();
    assert_eq!(names, ["fluid_00000000.vtp", "solid_00000000.vtp", "walls_00000000.vtp"]);
}
