//! Cases in space.

use sph::setup::FluidSetup;
use sph::space::{Space, Spatial};

use super::*;

type Vector = <Spatial as Space>::Vector;

/// A tank of water with a block on its floor, a free ball, and gravity along -z.
pub(super) const TANK: &str = r#"name = "tank"
[domain]
lower_m = [0.0, 0.0, 0.0]
upper_m = [0.4, 0.2, 0.3]
[body_force]
gravity_m_s2 = [0.0, 0.0, -9.81]
[time]
end_time_s = 0.1
step = { type = "fixed", time_step_s = 1e-4 }
[fluid]
particle_spacing_m = 0.02
rest_density_kg_m3 = 1000.0
sound_speed_m_s = 20.0
[[fluid.region]]
name = "water"
shape = { type = "box", lower_m = [0.0, 0.0, 0.0], upper_m = [0.4, 0.2, 0.1] }
velocity_m_s = ["z", 0.0, 0.0]
[solid]
[[solid.body]]
name = "ball"
shape = { type = "sphere", centre_m = [0.1, 0.1, 0.2], radius_m = 0.06 }
formulation = { type = "rigid" }
rotation_speed_rad_s = [0.0, 0.0, 2.0]
material = { density_kg_m3 = 500.0, young_modulus_pa = 1e6, poisson_ratio = 0.3 }
[[wall]]
name = "box"
type = "container"
open_sides = ["+z"]
[[wall]]
name = "block"
type = "solid"
shape = { type = "box", lower_m = [0.3, 0.06, 0.0], upper_m = [0.38, 0.14, 0.08] }
motion = { angle_rad = "0.1*t^2", axis = [0.0, 0.0, 2.0], pivot_m = [0.34, 0.1, 0.0] }
[[probe]]
name = "gauge"
type = "fluid-point"
at_m = [0.1, 0.1, 0.05]
"#;

fn with(from: &str, to: &str) -> String {
    assert!(TANK.contains(from), "{from}");
    TANK.replacen(from, to, 1)
}

fn fluid(text: &str) -> FluidSetup<Spatial> {
    good(text).fluid_setup().unwrap().spatial().unwrap()
}

#[test]
fn a_case_in_space_is_laid_out() {
    let setup = fluid(TANK);
    // 20 x 10 x 5 less the 4 x 4 x 4 of the block.
    assert_eq!(setup.particles.id.len(), 1000 - 64);
    let mass: f64 = setup.particles.mass.iter().sum();
    assert!((mass / (936.0 * 0.02_f64.powi(3) * 1000.0) - 1.0).abs() < 1e-12, "{mass}");
    assert!(setup.particles.position.iter().zip(&setup.particles.velocity).all(|(x, v)| v.x == x.z));
    let motion = setup.walls[1].motion.as_ref().unwrap();
    assert_eq!((motion.axis, motion.displacement.len()), ([0.0, 0.0, 1.0].into(), 3));
    let solid = good(TANK).solid_setup().unwrap().spatial().unwrap();
    let ball = solid.particles.of_body(0);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.06_f64.powi(3);
    assert!((ball.mass() / (500.0 * volume) - 1.0).abs() < 1e-9, "{}", ball.mass());
    // Of a rotation about z there is no motion along z.
    assert!(solid.particles.velocity.iter().all(|v| v.z == 0.0));
    assert!(solid.particles.velocity.iter().any(|v| v.norm() > 0.08));
}

#[test]
fn faces_that_another_wall_covers_bend_no_normals() {
    let setup = fluid(TANK);
    let block = setup.wall_particles.wall.iter().zip(&setup.wall_particles.position);
    let block = block.zip(&setup.wall_particles.normal).filter(|((wall, _), _)| **wall == 1);
    // In the middle of a side at the foot of the block its face alone is near.
    let foot = block.min_by(|a, b| {
        let far = |x: &Vector| (x - Vector::new(0.3, 0.09, 0.01)).norm();
        far(a.0.1).total_cmp(&far(b.0.1))
    });
    let ((_, position), normal) = foot.unwrap();
    assert!((normal - Vector::new(-1.0, 0.0, 0.0)).norm() < 1e-9, "{normal} at {position}");
}

#[test]
fn a_resolved_case_reads_back_as_the_same() {
    for shape in [
        "{ type = \"sphere\", centre_m = [0.1, 0.1, 0.2], radius_m = 0.06 }",
        "{ type = \"cylinder\", from_m = [0.1, 0.1, 0.15], to_m = [0.1, 0.1, 0.25], radius_m = 0.06 }",
        "{ type = \"cone\", from_m = [0.1, 0.1, 0.15], to_m = [0.1, 0.1, 0.27], radius_from_m = 0.06, radius_to_m = 0.0 }",
        "{ type = \"torus\", centre_m = [0.12, 0.1, 0.2], axis = [0, 0, 1], radius_m = 0.06, tube_radius_m = 0.03 }",
        "{ type = \"extrusion\", origin_m = [0.05, 0.05, 0.15], height_m = 0.1, section = { type = \"polygon\", vertices_m = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]] } }",
        "{ type = \"revolution\", origin_m = [0.1, 0.1, 0.15], axis = [0, 0, 1], section = { type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.06, 0.1] } }",
        "{ type = \"placed\", axis = [0, 0, 1], angle_rad = 0.5, by_m = [0.1, 0.1, 0.2], shape = { type = \"box\", lower_m = [-0.05, -0.05, -0.05], upper_m = [0.05, 0.05, 0.05] } }",
        "{ type = \"intersection\", parts = [{ type = \"sphere\", centre_m = [0.1, 0.1, 0.2], radius_m = 0.06 }, { type = \"half-space\", point_m = [0.1, 0.1, 0.2], normal = [0, 0, 1] }] }",
    ] {
        let text = with("{ type = \"sphere\", centre_m = [0.1, 0.1, 0.2], radius_m = 0.06 }", shape);
        let case = good(&text);
        let again = good(&case.resolved_toml());
        assert_eq!(case.solid_setup(), again.solid_setup(), "{shape}");
        assert_eq!(case.fluid_setup(), again.fluid_setup(), "{shape}");
    }
}

#[test]
fn what_belongs_to_the_other_space_is_refused_where_it_stands() {
    for (from, to, needle, words) in [
        (
            "at_m = [0.1, 0.1, 0.05]",
            "at_m = [0.1, 0.1]",
            "[0.1, 0.1]",
            "2 components, in a case of 3 dimensions",
        ),
        (
            "gravity_m_s2 = [0.0, 0.0, -9.81]",
            "gravity_m_s2 = [0.0, -9.81]",
            "[0.0, -9.81]",
            "three finite numbers, [x, y, z]",
        ),
        (
            "velocity_m_s = [\"z\", 0.0, 0.0]",
            "velocity_m_s = [\"z\", 0.0]",
            "[\"z\", 0.0]",
            "all vectors have as many numbers",
        ),
        ("open_sides = [\"+z\"]", "open_sides = [\"top\"]", "\"top\"", "\"-z\", \"+z\""),
        ("axis = [0.0, 0.0, 2.0]", "axis = [0.0, 0.0, 0.0]", "[0.0, 0.0, 0.0], pivot_m", "has no direction"),
    ] {
        let text = with(from, to);
        only_error(&text, needle);
        let report = bad(&text).to_string();
        assert!(report.contains(words), "{report}");
    }
    let circle = with(
        "{ type = \"sphere\", centre_m = [0.1, 0.1, 0.2], radius_m = 0.06 }",
        "{ type = \"circle\", centre_m = [0.1, 0.1], radius_m = 0.06 }",
    );
    let report = bad(&circle).to_string();
    assert!(report.contains("is a shape of the plane, in a case of 3 dimensions"), "{report}");
    assert!(report.contains("\"sphere\""), "{report}");
    let level = with("type = \"fluid-point\"\nat_m = [0.1, 0.1, 0.05]", "type = \"water-level\"\nx_m = 0.1");
    let report = bad(&level).to_string();
    assert!(
        report.contains("is a probe of 2 dimensions, in a case of 3") && report.contains("`gauge`"),
        "{report}"
    );
    // A rotation in space needs an axis.
    let turning = bad(&with("axis = [0.0, 0.0, 2.0], ", "")).to_string();
    assert!(turning.contains("motion.axis`: missing"), "{turning}");
    let plane = bad(&super::TANK.replace("at_m = [0.1, 0.05]", "at_m = [0.1, 0.05, 0.0]")).to_string();
    assert!(plane.contains("3 components, in a case of 2 dimensions"), "{plane}");
}

/// A cube of side 1 about the origin in words, without the facets from `first_missing` on.
fn cube(first_missing: usize) -> String {
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f64 - 0.5);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facets = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    let mut text = String::from("solid cube\n");
    for facet in facets.take(first_missing) {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for k in facet {
            let [x, y, z] = corner(k);
            text.push_str(&format!("vertex {x} {y} {z}\n"));
        }
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid cube\n"
}

#[test]
fn a_surface_from_a_file_is_filled_or_says_what_to_repair() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cube.stl"), cube(12)).unwrap();
    std::fs::write(folder.path().join("open.stl"), cube(11)).unwrap();
    let read = |surface: &str| {
        let placed = format!(
            "{{ type = \"placed\", by_m = [0.1, 0.1, 0.2], shape = {{ type = \"surface\", {surface} }} }}"
        );
        let text = with("{ type = \"sphere\", centre_m = [0.1, 0.1, 0.2], radius_m = 0.06 }", &placed);
        parse(&text, "case.toml", folder.path(), &|_| Err(String::new()))
    };
    let case = read("file = \"cube.stl\", unit = \"dm\"").unwrap_or_else(|errors| panic!("{errors}"));
    let solid = case.solid_setup().unwrap().spatial().unwrap();
    assert!((solid.particles.of_body(0).mass() / 0.5 - 1.0).abs() < 1e-9);
    let refused = |surface: &str, words: &str| {
        let report = read(surface).unwrap_err().to_string();
        assert!(report.contains(words), "{report}");
    };
    refused("file = \"cube.stl\"", "unit`: missing");
    refused("file = \"open.stl\", unit = \"dm\"", "3 open edges");
    refused("file = \"none.stl\", unit = \"dm\"", "no such file");
    assert!(read("file = \"open.stl\", unit = \"dm\", defects = \"accept\"").is_ok());
}

#[test]
fn gauges_and_fluxes_say_along_which_axis_and_through_what() {
    let point = "type = \"fluid-point\"\nat_m = [0.1, 0.1, 0.05]";
    let gauge = with(point, "type = \"gauge\"\nat_m = [0.1, 0.1, 0.05]\naxis = \"z\"");
    let case = good(&gauge);
    assert_eq!(case.probe_columns()[0], ["gauge_level_m"]);
    let setup = fluid(&gauge);
    let place = Vector::new(0.1, 0.1, 0.05);
    assert_eq!(setup.probes[0].kind, sph::setup::FluidProbeKind::Gauge(place, 2));
    let error = only_error(&gauge.replace("axis = \"z\"", "axis = \"w\""), "\"w\"");
    assert!(error.problem.contains("no axis has this name"), "{error:?}");
    let flux = |second: &str| {
        let corners = "corner_m = [0.1, 0.1, 0.0]\nfirst_m = [0.1, 0.2, 0.0]\nsecond_m = ";
        with(point, &format!("type = \"surface-flux\"\n{corners}{second}"))
    };
    assert_eq!(good(&flux("[0.1, 0.1, 0.1]")).probe_columns()[0], ["gauge_flow_rate_m3_s"]);
    // Outside the domain.
    only_error(&flux("[0.1, 0.1, 0.4]"), "[0.1, 0.1, 0.4]");
    let corners =
        "type = \"surface-flux\"\ncorner_m = [0.1, 0.05]\nfirst_m = [0.1, 0.06]\nsecond_m = [0.1, 0.07]";
    let plane = super::TANK.replacen("type = \"fluid-point\"\nat_m = [0.1, 0.05]", corners, 1);
    assert!(bad(&plane).to_string().contains("use `flow-rate`"));
}

#[test]
fn a_pivot_holds_a_rigid_body_alone() {
    let rigid = "formulation = { type = \"rigid\" }";
    let pivot = "[[solid.body.support]]\nname = \"hinge\"\npivot_m = [0.1, 0.1, 0.05]\n";
    let held = with("[[wall]]\nname = \"box\"", &format!("{pivot}[[wall]]\nname = \"box\""));
    let case = good(&held);
    let support = case.solid_setup().unwrap().spatial().unwrap().bodies[0].supports[0].clone();
    assert_eq!((support.pivot, support.held), (Some(Vector::new(0.1, 0.1, 0.05)), [false; 3]));
    // As resolved it means the same.
    let resolved = good(&case.resolved_toml());
    assert_eq!(resolved.solid_setup(), case.solid_setup());
    let error = only_error(&held.replace(rigid, ""), "[0.1, 0.1, 0.05]");
    assert!(error.problem.contains("not rigid"), "{error:?}");
    let beside = held.replace("pivot_m = [0.1, 0.1, 0.05]", "held = [\"x\"]\npivot_m = [0.1, 0.1, 0.05]");
    assert!(only_error(&beside, "[\"x\"]").problem.contains("beside `pivot_m`"));
    let roller = "[[solid.body.support]]\nname = \"roller\"\nheld = [\"x\"]\nshape = { type = \"sphere\", centre_m = [0.1, 0.1, 0.2], radius_m = 0.02 }\n";
    let two = held.replace(pivot, &format!("{pivot}{roller}"));
    assert!(bad(&two).to_string().contains("beside other supports"));
}

#[test]
fn a_load_acts_on_the_curved_face_of_a_fitted_body() {
    let elastic = with("formulation = { type = \"rigid\" }", "formulation = { type = \"total-lagrangian\" }");
    // Half of the sphere, pressed from above.
    let load = "[[solid.body.load]]\nname = \"cap\"\npressure_pa = \"100\"\nshape = { type = \"box\", lower_m = [0.0, 0.0, 0.2], upper_m = [0.2, 0.2, 0.3] }\n[[wall]]\nname = \"box\"";
    let text = elastic.replacen("[[wall]]\nname = \"box\"", load, 1);
    let setup = good(&text).solid_setup().unwrap().spatial().unwrap();
    let load = &setup.bodies[0].loads[0];
    let sum: Vector = load.areas.iter().sum();
    // The area vectors of a hemisphere sum to those of its base, π R².
    let exact = std::f64::consts::PI * 0.06 * 0.06;
    assert!((sum - Vector::new(0.0, 0.0, exact)).norm() < 0.01 * exact, "{sum} {exact}");
    let upper = |i: &&u32| setup.particles.position[**i as usize].z > 0.19;
    assert_eq!(load.particles.iter().filter(upper).count(), load.particles.len());
}
