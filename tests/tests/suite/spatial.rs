//! Whole runs in space: a rigid ball and an elastic beam in water, in every way of running that must not matter.

use std::path::PathBuf;

use crate::bench;
use tests::bench::{Bench, digests, text};
use tests::kill::same_results;

/// Water with a free rigid ball and a clamped elastic post, to `end` \[s\].
fn scene(bench: &Bench, end: f64) -> PathBuf {
    let scene = format!(
        r#"name = "scene"
[domain]
lower_m = [0.0, 0.0, 0.0]
upper_m = [0.4, 0.3, 0.4]
[body_force]
gravity_m_s2 = [0.0, 0.0, -9.81]
[time]
end_time_s = {end}
step = {{ type = "adaptive", factor = 0.6 }}
[outputs]
snapshot_interval_s = 0.01
probe_interval_s = 0.002
[checkpoint]
every_steps = 7
[fluid]
particle_spacing_m = 0.02
rest_density_kg_m3 = 1000.0
sound_speed_m_s = 20.0
[[fluid.region]]
name = "water"
shape = {{ type = "box", lower_m = [0.0, 0.0, 0.0], upper_m = [0.2, 0.3, 0.2] }}
start = {{ type = "hydrostatic", surface_m = 0.2 }}
[solid]
[[solid.body]]
name = "ball"
shape = {{ type = "sphere", centre_m = [0.1, 0.15, 0.18], radius_m = 0.06 }}
material = {{ density_kg_m3 = 600.0, young_modulus_pa = 1e6, poisson_ratio = 0.3 }}
formulation = {{ type = "rigid" }}
rotation_speed_rad_s = [1.0, 2.0, 3.0]
[[solid.body]]
name = "post"
shape = {{ type = "box", lower_m = [0.3, 0.1, -0.06], upper_m = [0.36, 0.2, 0.16] }}
material = {{ density_kg_m3 = 1100.0, young_modulus_pa = 1e6, poisson_ratio = 0.3 }}
[[solid.body.support]]
name = "foot"
shape = {{ type = "box", lower_m = [0.3, 0.1, -0.06], upper_m = [0.36, 0.2, 0.0] }}
[[wall]]
name = "tank"
type = "container"
open_sides = ["+z"]
[[probe]]
name = "ball"
type = "body-motion"
body = "ball"
[[probe]]
name = "tip"
type = "material-point"
body = "post"
at_m = [0.33, 0.15, 0.15]
"#
    );
    bench.write(&format!("scene_{end}.toml"), &scene)
}

#[test]
fn every_way_of_running_in_space_gives_the_same_bits_and_a_balanced_ledger() {
    let bench = bench();
    let case = scene(&bench, 0.03);
    let split = bench.run(&case, "split", &[]);
    assert_eq!(digests(&bench.run(&case, "one", &["--in-process", "--threads", "1"])), digests(&split));
    assert_eq!(digests(&bench.run(&case, "four", &["--threads", "4"])), digests(&split));
    let ledger = &split["ledger"];
    assert_eq!((&split["verdict"], &ledger["breaches"]), (&"completed".into(), &0.into()));
    assert_eq!(split["dimensions"], 3);
    // The turning ball feels the water about all axes.
    let table = std::fs::read_to_string(bench.path("split/ledger.csv")).unwrap();
    let (head, last) = (table.lines().next().unwrap(), table.lines().last().unwrap());
    for column in ["solid_torque_x_n_m", "solid_torque_y_n_m", "solid_torque_z_n_m"] {
        let k = head.split(',').position(|name| name == column).unwrap_or_else(|| panic!("{column}"));
        let torque: f64 = last.split(',').nth(k).unwrap().parse().unwrap();
        assert!(torque != 0.0 && torque.is_finite(), "{column} = {torque}");
    }
    for file in ["report.html", "snapshots/fluid.pvd", "snapshots/solid.pvd"] {
        assert!(bench.path("split").join(file).is_file(), "{file}");
    }
}

#[test]
fn a_run_in_space_goes_on_to_a_later_end_with_the_bits_of_one_run() {
    let bench = bench();
    bench.run(&scene(&bench, 0.03), "whole", &[]);
    // A time of a snapshot, which the steps of the whole run meet too.
    bench.run(&scene(&bench, 0.01), "parts", &["--in-process"]);
    let output = bench.call(&["resume", text(&bench.path("parts")), "--quiet", "--until", "0.03"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    same_results(&bench.path("whole"), &bench.path("parts")).unwrap();
}
