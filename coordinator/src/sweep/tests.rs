//! Sweeps of a small case, in threads of this process.

use std::cell::RefCell;
use std::collections::BTreeSet;

use super::*;

/// Water at rest in a box, for a few steps.
const BOX: &str = r#"name = "box"
[domain]
lower_m = [0.0, 0.0]
upper_m = [0.2, 0.2]
[body_force]
gravity_m_s2 = [0.0, -9.81]
[time]
end_time_s = 0.004
step = { type = "adaptive" }
[outputs]
probe_interval_s = 0.001
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
[[probe]]
name = "water"
type = "fluid-sums"
"#;

fn request(folder: &Path, over: &[&str]) -> SweepRequest {
    let case = folder.join("box.toml");
    std::fs::write(&case, BOX).unwrap();
    SweepRequest {
        run: RunRequest {
            case,
            out: Some(folder.join("out")),
            options: RunOptions { threads: Some(1), ..RunOptions::default() },
            ..RunRequest::default()
        },
        axes: over.iter().map(|text| text.parse().unwrap()).collect(),
        figures: vec!["largest water_kinetic_energy_j_per_m".parse().unwrap()],
        ..SweepRequest::default()
    }
}

fn swept(request: &SweepRequest) -> (Joined, Vec<String>) {
    let said = RefCell::new(Vec::new());
    let joined = run(request, |line| said.borrow_mut().push(line.to_owned())).unwrap();
    (joined, said.into_inner())
}

#[test]
fn members_are_made_side_by_side_kept_by_content_and_wrong_ones_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut request =
        request(folder.path(), &["fluid.sound_speed_m_s=20,-5,30", "body_force.gravity_m_s2[1]=-9.81,-5"]);
    request.jobs = 3;
    let (joined, said) = swept(&request);
    let states: Vec<&str> = joined.members.iter().map(|(progress, _)| progress.word()).collect();
    assert_eq!(states, ["finished", "finished", "wrong case", "wrong case", "finished", "finished"]);
    assert!(said[0].contains("sound_speed_m_s=-5") && said[0].contains("above 0"), "{said:?}");
    let table = std::fs::read_to_string(joined.folder.join(TABLE)).unwrap();
    let head = "member,run,state,fluid.sound_speed_m_s,body_force.gravity_m_s2[1],steps,wall_s,";
    assert!(table.starts_with(head), "{table}");
    let text = lines(&joined).join("\n");
    assert!(text.contains("member 3, ") && text.contains("wrong case"), "{text}");
    let page = std::fs::read_to_string(joined.folder.join(PAGE)).unwrap();
    assert!(page.contains("4 of 6 runs are finished") && page.matches("<circle").count() >= 8, "{page}");
    // Less gravity, less motion: the values are those of their own runs.
    let energy: Vec<f64> = joined.members.iter().filter_map(|(_, values)| values[0]).collect();
    assert!(energy[1] < 0.5 * energy[0] && energy[3] < 0.5 * energy[2], "{energy:?}");

    // Another order and one more value: only what is new is run.
    request.axes = ["fluid.sound_speed_m_s=30,40,20", "body_force.gravity_m_s2[1]=-9.81"]
        .map(|text| text.parse().unwrap())
        .into();
    let (again, said) = swept(&request);
    let kept: BTreeSet<bool> =
        said.iter().filter(|line| line.contains("=40")).map(|l| l.ends_with("kept")).collect();
    assert_eq!(kept, BTreeSet::from([false]));
    assert_eq!(said.iter().filter(|line| line.ends_with(": kept")).count(), 2, "{said:?}");
    assert_eq!(again.members[2].1, joined.members[0].1);
    // A change of what they have in common makes all of them others.
    request.run.overrides = vec![Override::new("time.end_time_s", 0.005)];
    let (_, said) = swept(&request);
    assert!(!said.iter().any(|line| line.ends_with(": kept")), "{said:?}");
}

#[test]
fn a_planned_sweep_is_made_member_by_member_and_joined() {
    let folder = tempfile::tempdir().unwrap();
    let mut request = request(folder.path(), &["fluid.sound_speed_m_s=20,30"]);
    request.seeds = vec![1, 2];
    let (out, manifest) = plan(&request, |line| panic!("{line}")).unwrap();
    assert_eq!(manifest.members.len(), 4);
    assert_eq!(manifest.members[1].label, "sound_speed_m_s=20_seed=2");
    let options = &request.run.options;
    // The members need the folder of the case no more.
    std::fs::remove_file(&request.run.case).unwrap();
    let (_, first) = make_member(&out, 2, options, false).unwrap();
    assert!(!first.kept && make_member(&out, 2, options, false).unwrap().1.kept);
    let joined = join(&out).unwrap();
    let states: Vec<&str> = joined.members.iter().map(|(progress, _)| progress.word()).collect();
    assert_eq!(states, ["not run", "finished", "not run", "not run"]);
    for number in [1, 3, 4] {
        make_member(&out, number, options, false).unwrap();
    }
    assert_eq!(join(&out).unwrap().unfinished().count(), 0);
    let recorded =
        std::fs::read_to_string(out.join("members/sound_speed_m_s=30_seed=1/results/case.toml")).unwrap();
    assert!(recorded.contains("# set: fluid.sound_speed_m_s = 30\n# set: run.seed = 1\n"), "{recorded}");
    let message = make_member(&out, 9, options, false).unwrap_err().message;
    assert!(message.contains("members 1 to 4"), "{message}");
}

#[test]
fn a_sweep_that_is_wrong_as_a_whole_is_refused_before_any_run() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |change: &dyn Fn(&mut SweepRequest)| {
        let mut request = request(folder.path(), &["fluid.sound_speed_m_s=20"]);
        change(&mut request);
        run(&request, |_| {}).unwrap_err().message
    };
    let unknown = refused(&|r| r.axes = vec!["fluid.sound_sped_m_s=1,2".parse().unwrap()]);
    assert!(unknown.contains("did you mean `sound_speed_m_s`?"), "{unknown}");
    let column = refused(&|r| r.figures = vec!["last water_mas_kg_per_m".parse().unwrap()]);
    assert!(column.contains("did you mean `water_mass_kg_per_m`?"), "{column}");
    let twice = refused(&|r| r.run.overrides = vec![Override::new("fluid.sound_speed_m_s", 30.0)]);
    assert!(twice.contains("set for all by `--set`"), "{twice}");
}

#[test]
fn labels_say_what_differs() {
    let set = |key: &str, value: &str| Override { key: key.to_owned(), value: value.to_owned() };
    assert_eq!(label(&[]), "case");
    assert_eq!(label(&[set("a.e_pa", "1e5"), set("b.law", "\"linear\"")]), "e_pa=1e5_law=linear");
    // Names of one end, and values that are no names, go by a digest.
    let [a, b] = [["x.e", "y.e"], ["x.e", "z.e"]].map(|keys| label(&keys.map(|key| set(key, "1"))));
    assert!(a.starts_with("e=1_e=1_") && a != b, "{a} {b}");
    assert!(label(&[set("d[1]", "[1, 2]")]).starts_with("d-1-=-1--2-_"));
}
