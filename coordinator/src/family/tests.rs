//! Families of small runs.

use std::cell::RefCell;
use std::f64::consts::PI;
use std::path::Path;

use super::figures::{Measure, Times};
use super::*;
use crate::case::overrides::Override;

/// Water between two no-slip walls 1 m apart, driven from rest by 0.8 m/s²; it nears a parabola.
const CHANNEL: &str = r#"name = "channel"
[domain]
lower_m = [0.0, -0.5]
upper_m = [0.8, 1.5]
periodic = ["x"]
[body_force]
acceleration_m_s2 = [0.8, 0.0]
[time]
end_time_s = 1.0
step = { type = "fixed", time_step_s = 2e-3 }
[outputs]
probe_interval_s = 0.1
[fluid]
particle_spacing_m = 0.1
sound_speed_m_s = 10.0
dynamic_viscosity_pa_s = 100.0
rest_density_kg_m3 = 1000.0
artificial_viscosity_a = 0.0
# Lattices that stay lattices, so that the errors have one order.
kernel_ratio = 1.2
gradient_correction_share = 0.8
shifting = 0.0
tensile_control = false
volume_correction = 0.0
acoustic_relaxation = 0.0
[[fluid.region]]
name = "water"
shape = { type = "rectangle", lower_m = [0.0, 0.0], upper_m = [0.8, 1.0] }
[[wall]]
name = "lower"
type = "solid"
shape = { type = "rectangle", lower_m = [0.0, -0.4], upper_m = [0.8, 0.0] }
condition = "no-slip"
[[wall]]
name = "upper"
type = "solid"
shape = { type = "rectangle", lower_m = [0.0, 1.0], upper_m = [0.8, 1.4] }
condition = "no-slip"
[[probe]]
name = "water"
type = "fluid-sums"
"#;

/// A request for a family of `text` in `folder`.
fn request(folder: &Path, text: &str) -> FamilyRequest {
    let case = folder.join("case.toml");
    std::fs::write(&case, text).unwrap();
    let mut request = FamilyRequest::default();
    request.run.case = case;
    request.run.out = Some(folder.join("out"));
    request.run.options.threads = Some(1);
    request
}

fn figure(column: &str, measure: Measure) -> Figure {
    Figure { column: column.to_owned(), measure }
}

/// A column of water that falls and strikes a wall.
const SPLASH: &str = r#"name = "splash"
[domain]
lower_m = [0.0, 0.0]
upper_m = [0.3, 0.4]
[body_force]
gravity_m_s2 = [0.0, -9.81]
[time]
end_time_s = 0.35
step = { type = "adaptive" }
[outputs]
probe_interval_s = 0.01
[fluid]
particle_spacing_m = 0.01
sound_speed_m_s = 20.0
rest_density_kg_m3 = 1000.0
artificial_viscosity_a = 0.05
[[fluid.region]]
name = "water"
shape = { type = "rectangle", lower_m = [0.0, 0.0], upper_m = [0.1, 0.15] }
[[wall]]
name = "box"
type = "container"
open_sides = ["top"]
[[probe]]
name = "water"
type = "fluid-sums"
[[probe]]
name = "head"
type = "front"
"#;

/// Momentum of the channel's water at `time` \[N s/m\]: start of plane Poiseuille flow, g = 0.8 m/s², ν = 0.1 m²/s.
fn exact_momentum(time: f64) -> f64 {
    let (g, nu, mass) = (0.8, 0.1, 1000.0 * 0.8);
    let mode = |n: f64| (-n * n * PI * PI * nu * time).exp() / n.powi(4);
    // The sum falls as n⁻⁴ and, at this time, much faster.
    let modes: f64 = [1.0, 3.0, 5.0, 7.0].map(mode).iter().sum();
    mass * (g / (12.0 * nu) - 8.0 * g / (nu * PI.powi(4)) * modes)
}

#[test]
fn a_channel_converges_to_its_exact_flow() {
    let folder = tempfile::tempdir().unwrap();
    let mut request = request(folder.path(), CHANNEL);
    request.spacings = vec![0.05, 0.1, 0.2 / 3.0];
    request.figures = vec![figure("water_momentum_x_kg_per_s", Measure::At(1.0))];
    let family = run(&request, |_| {}).unwrap();
    let spacings: Vec<f64> = family.members.iter().map(|member| member.place.spacing).collect();
    assert_eq!(spacings, [0.1, 0.2 / 3.0, 0.05]);
    // The fixed step shrinks with the spacing.
    let steps: Vec<u64> = family.members.iter().map(|m| m.outcome.as_ref().unwrap().steps).collect();
    assert_eq!(steps, [500, 750, 1000]);
    let [(Some(10.0), Trend::Converging { order, extrapolated, error })] = family.figures[0].over_spacing[..]
    else {
        panic!("{:?}", family.figures[0])
    };
    let finest = family.figures[0].values[2].spread.unwrap().mean;
    let exact = exact_momentum(1.0);
    let missed = (finest - exact).abs();
    // Sums of second order and faces of first: with 20 particles across the observed order lies at that of the sums.
    assert!((1.0..2.5).contains(&order), "{order}");
    // Extrapolation takes off more than half of the error, 2.4 of 339.9.
    assert!((extrapolated - exact).abs() < 0.5 * missed, "{finest} {extrapolated} {exact}");
    // The estimate has the size of the true error. Where the order still falls it is no bound.
    assert!((0.5..2.0).contains(&(error / missed)), "{finest} {exact} {error}");
}

#[test]
fn seeds_spread_a_violent_scene_and_finished_members_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut request = request(folder.path(), SPLASH);
    request.seeds = vec![1, 2, 3];
    request.figures = vec![
        figure("water_kinetic_energy_j_per_m", Measure::Mean(Times { from: 0.3, to: 0.35 })),
        figure("head_front_x_m", Measure::Rises(0.2)),
        figure("head_front_x_m", Measure::Rises(5.0)),
    ];
    let lines = RefCell::new(Vec::new());
    let family = run(&request, |line| lines.borrow_mut().push(line.to_owned())).unwrap();
    let spread = family.figures[0].values[0].spread.unwrap();
    assert_eq!((spread.count, family.figures[0].values[0].missing), (3, 0));
    // After the strike runs that differ by 0.01 Δx have parted, and are still runs of one scene.
    let part = spread.deviation.unwrap() / spread.mean;
    assert!((1e-4..0.5).contains(&part), "{part}");
    // Until then they have not: the front moves alike.
    let front = family.figures[1].values[0].spread.unwrap();
    assert!(front.deviation.unwrap() / front.mean < 0.01, "{front:?}");
    // A level that is not reached is no value, and no number is made up.
    assert_eq!((family.figures[2].values[0].missing, family.figures[2].values[0].spread), (3, None));
    assert_eq!(family.figures[0].over_spacing.len() + family.figures[0].over_sound_speed.len(), 0);

    // One more seed: what is finished is kept, with the same figures.
    request.seeds.push(4);
    request.run.options.threads = Some(2);
    lines.borrow_mut().clear();
    let again = run(&request, |line| lines.borrow_mut().push(line.to_owned())).unwrap();
    let kept: Vec<bool> = lines.borrow().iter().map(|line| line.ends_with(": kept")).collect();
    assert_eq!(kept, [true, true, true, false], "{lines:?}");
    for (before, after) in family.members.iter().zip(&again.members) {
        let [before, after] = [before, after].map(|member| &member.outcome.as_ref().unwrap().figures);
        assert_eq!(before, after);
    }
    // Another end time is another run.
    request.run.overrides = vec![Override::new("time.end_time_s", 0.36)];
    request.seeds.truncate(1);
    lines.borrow_mut().clear();
    run(&request, |line| lines.borrow_mut().push(line.to_owned())).unwrap();
    assert!(!lines.borrow()[0].contains("kept"), "{lines:?}");

    let csv = std::fs::read_to_string(folder.path().join("out/members.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().map(|row| row.split(',').nth(3).unwrap()).collect();
    assert_eq!(rows, ["seed", "1"], "{csv}");
    let json = std::fs::read_to_string(folder.path().join("out/family.json")).unwrap();
    assert!(json.contains("\"figure\": \"time [s] at which head_front_x_m rises to 0.2\""), "{json}");
}

#[test]
fn a_member_that_fails_is_named_and_the_others_go_ahead() {
    let folder = tempfile::tempdir().unwrap();
    let mut request = request(folder.path(), CHANNEL);
    request.run.overrides = vec![Override::new("time.end_time_s", 0.01)];
    request.spacings = vec![0.1, 0.07];
    let family = run(&request, |_| {}).unwrap();
    let [good, bad] = &family.members[..] else { panic!() };
    assert!(good.outcome.is_ok());
    let failure = bad.outcome.as_ref().unwrap_err();
    assert!(failure.message.contains("does not divide the period"), "{failure}");
    // All columns, largest, smallest and last, and none of them has a trend.
    let names: Vec<String> = family.figures.iter().map(|result| result.figure.to_string()).collect();
    assert!(names.contains(&"smallest water_mass_kg_per_m".to_owned()), "{names:?}");
    assert!(family.figures.iter().all(|result| result.over_spacing == [(Some(10.0), Trend::TooFew)]));
    let csv = std::fs::read_to_string(folder.path().join("out/members.csv")).unwrap();
    assert!(csv.contains("dx_0.07_c0_10,0.07,10") && csv.contains("does not divide"), "{csv}");
}

#[test]
fn a_wrong_family_is_refused_before_any_run() {
    let folder = tempfile::tempdir().unwrap();
    let good = request(folder.path(), SPLASH);
    let refused = |change: &dyn Fn(&mut FamilyRequest)| {
        let mut request = good.clone();
        change(&mut request);
        run(&request, |line| panic!("{line}")).unwrap_err().message
    };
    assert!(refused(&|r| r.spacings = vec![0.01, -1.0]).contains("spacing -1 m: must be above 0"));
    assert!(refused(&|r| r.sound_speeds = vec![20.0, 20.0]).contains("sound speed 20 m/s is given twice"));
    assert!(refused(&|r| r.seeds = vec![1, 1]).contains("a seed is given twice"));
    let hint = refused(&|r| r.figures = vec![figure("head_front_m", Measure::Last)]);
    assert!(hint.contains("did you mean `head_front_x_m`?"), "{hint}");
    assert!(refused(&|r| r.run.options.trace = Some("trace".into())).contains("files of one run"));
    let wrong = |r: &mut FamilyRequest| r.run.overrides = vec![Override::new("fluid.sound_speed_m_s", -1.0)];
    assert!(refused(&wrong).contains("values set over the file:1"));
}

#[test]
fn sound_and_spacing_change_step_and_solids_as_they_must() {
    let folder = tempfile::tempdir().unwrap();
    let solid = "[solid]\nparticle_spacing_m = 0.05\n[[solid.body]]\nname = \"block\"\nformulation = { type = \"rigid\" }\n\
                 shape = { type = \"rectangle\", lower_m = [0.3, 0.4], upper_m = [0.5, 0.6] }\n\
                 material = { density_kg_m3 = 1000.0, young_modulus_pa = 1e6, poisson_ratio = 0.3 }\n[[wall]]";
    let mut request = request(folder.path(), &CHANNEL.replacen("[[wall]]", solid, 1));
    request.spacings = vec![0.2, 0.1];
    request.sound_speeds = vec![20.0, 10.0, 5.0];
    let plan = Plan::of(&request).unwrap();
    let changes = |spacing, speed| {
        let place = Place { spacing, sound_speed: Some(speed), seed: None };
        let changes = plan.changes(&place).into_iter();
        changes.map(|change| format!("{} = {}", change.key, change.value)).collect::<Vec<_>>()
    };
    assert_eq!(plan.places.len(), 6);
    assert!(changes(0.1, 10.0).is_empty());
    assert_eq!(
        changes(0.2, 20.0),
        ["fluid.particle_spacing_m = 0.2", "solid.particle_spacing_m = 0.1", "fluid.sound_speed_m_s = 20.0",],
        "twice the step by the spacing and half by the sound leave it as it is"
    );
    assert_eq!(changes(0.1, 20.0), ["fluid.sound_speed_m_s = 20.0", "time.step.time_step_s = 0.001"]);
    assert_eq!(changes(0.2, 10.0)[2..], ["time.step.time_step_s = 0.004"]);
    // Slower sound leaves the step.
    assert_eq!(changes(0.1, 5.0), ["fluid.sound_speed_m_s = 5.0"]);
}
