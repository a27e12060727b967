//! Shapes that do not fit the lattice.

use sph::space::Vector;

use super::*;

/// A tank of 0.2 m × 0.3 m with `more` tables, on a lattice of 4 mm.
fn tank(more: &str) -> String {
    format!(
        "name = \"tank\"
[domain]
lower_m = [0.0, 0.0]
upper_m = [0.2, 0.3]
[body_force]
gravity_m_s2 = [0.0, -9.81]
[time]
end_time_s = 0.1
step = {{ type = \"fixed\", time_step_s = 1e-5 }}
[fluid]
particle_spacing_m = 0.004
rest_density_kg_m3 = 1000.0
sound_speed_m_s = 25.0
[[wall]]
name = \"tank\"
type = \"container\"
open_sides = [\"top\"]
{more}"
    )
}

fn mass(case: &Case) -> f64 {
    case.fluid_setup().unwrap().plane().unwrap().particles.mass.iter().sum()
}

#[test]
fn a_column_off_the_lattice_has_its_mass_and_its_sides() {
    // 36.5 spacings wide: the lattice has 36 columns, 1.4 % too few.
    let region = |layout: &str| {
        tank(&format!(
            "[[fluid.region]]
name = \"column\"
shape = {{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.146, 0.12] }}
{layout}"
        ))
    };
    let case = good(&region(""));
    let exact = 1000.0 * 0.146 * 0.12;
    // Round-off of a sum of a thousand masses.
    assert!((mass(&case) / exact - 1.0).abs() < 1e-12);
    let fluid = case.fluid_setup().unwrap().plane().unwrap().particles;
    let right = fluid.position.iter().map(|x| x.x).fold(0.0, f64::max);
    // Half a cell of 0.146/37 m before its side.
    assert!((right - (0.146 - 0.5 * 0.146 / 37.0)).abs() < 1e-12, "{right}");
    let adjusted = case.summary().adjusted;
    assert!(adjusted.len() == 1 && adjusted[0].contains("region `column`"), "{adjusted:?}");
    assert!(adjusted[0].contains("-1.35 %, +0.00 %"), "{adjusted:?}");
    // On the lattice only the masses are adjusted.
    let case = good(&region("layout = \"lattice\""));
    assert!((mass(&case) / exact - 1.0).abs() < 1e-12);
    assert!(case.summary().adjusted[0].contains("scaled by"), "{:?}", case.summary().adjusted);
}

#[test]
fn a_round_region_has_the_mass_of_its_shape() {
    for (layout, words) in [("", "scaled by"), ("layout = \"fitted\"", "in layers along its faces")] {
        let case = good(&tank(&format!(
            "[[fluid.region]]
name = \"drop\"
shape = {{ type = \"circle\", centre_m = [0.1, 0.15], radius_m = 0.05 }}
{layout}"
        )));
        let exact = 1000.0 * std::f64::consts::PI * 0.05 * 0.05;
        assert!((mass(&case) / exact - 1.0).abs() < 1e-11, "{layout}");
        assert!(case.summary().adjusted[0].contains(words), "{:?}", case.summary().adjusted);
    }
}

/// A body of `shape` with `more` keys in an empty tank.
fn body(shape: &str, more: &str) -> Case {
    good(&format!(
        "name = \"body\"
[domain]
lower_m = [-0.2, -0.2]
upper_m = [0.2, 0.2]
[time]
end_time_s = 0.1
step = {{ type = \"fixed\", time_step_s = 1e-6 }}
[solid]
particle_spacing_m = 0.004
[[solid.body]]
name = \"thing\"
shape = {shape}
material = {{ density_kg_m3 = 1000.0, young_modulus_pa = 1e6, poisson_ratio = 0.4 }}
{more}"
    ))
}

#[test]
fn a_round_rigid_body_has_the_mass_and_moment_of_inertia_of_its_shape() {
    let shape = "{ type = \"circle\", centre_m = [0.011, 0.003], radius_m = 0.03 }";
    let case = body(shape, "formulation = { type = \"rigid\" }");
    let setup = case.solid_setup().unwrap().plane().unwrap();
    let thing = setup.particles.of_body(0);
    let area = std::f64::consts::PI * 0.03 * 0.03;
    assert!((thing.mass() / (1000.0 * area) - 1.0).abs() < 1e-12);
    // m r²/2, by round-off of the fit of second moments.
    assert!((thing.inertia() / (1000.0 * area * 0.5 * 0.03 * 0.03) - 1.0).abs() < 1e-9);
}

#[test]
fn a_round_body_turns_about_its_centre_of_mass_at_the_start() {
    let shape = "{ type = \"ring\", centre_m = [0.01, 0.0], inner_radius_m = 0.03, outer_radius_m = 0.05 }";
    let setup = body(shape, "rotation_speed_rad_s = 2.0").solid_setup().unwrap().plane().unwrap();
    let p = &setup.particles;
    let momentum: Vector = p.velocity.iter().zip(&p.mass).map(|(v, m)| v * *m).sum();
    // Round-off beside 2.5 kg/s of the gross.
    assert!(momentum.norm() < 1e-13, "{momentum}");
}

#[test]
fn loads_on_curved_faces_have_their_area() {
    let shape = "{ type = \"circle\", centre_m = [0.0, 0.0], radius_m = 0.05 }";
    let load = "[[solid.body.load]]
name = \"right\"
shape = { type = \"rectangle\", lower_m = [0.0, -0.1], upper_m = [0.1, 0.1] }
pressure_pa = \"100\"";
    let setup = body(shape, load).solid_setup().unwrap().plane().unwrap();
    let load = &setup.bodies[0].loads[0];
    let total: Vector = load.areas.iter().sum();
    // The right half of a circle: 2 r along x. Pieces of a tenth of a spacing end on the border of the load.
    assert!((total - Vector::new(0.1, 0.0)).norm() < 5e-4, "{total}");
    let gross: f64 = load.areas.iter().map(|area| area.norm()).sum();
    assert!((gross / (std::f64::consts::PI * 0.05) - 1.0).abs() < 0.01, "{gross}");
}

#[test]
fn staircases_are_named_with_what_they_cost() {
    let ring = "{ type = \"ring\", centre_m = [0.0, 0.0], inner_radius_m = 0.08, outer_radius_m = 0.112 }";
    let warned = |more: &str| {
        let warnings = body(ring, more).summary().warnings;
        warnings.into_iter().find(|warning| warning.contains("across its thin side"))
    };
    assert_eq!(warned(""), None);
    let stairs = warned("layout = \"lattice\"").unwrap();
    assert!(stairs.contains("staircases") && stairs.contains("1.1"), "{stairs}");
}

#[test]
fn a_wall_off_the_lattice_stands_at_its_face() {
    let text = tank("layout = \"auto\"").replace("upper_m = [0.2, 0.3]", "upper_m = [0.1985, 0.3]");
    let region = "[[fluid.region]]
name = \"water\"
shape = { type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.1985, 0.1] }";
    let setup = good(&format!("{text}\n{region}")).fluid_setup().unwrap().plane().unwrap();
    let right = setup.wall_particles.position.iter().filter(|x| x.x > 0.19 && x.y > 0.0);
    let nearest = right.map(|x| x.x).fold(f64::INFINITY, f64::min);
    assert!((nearest - 0.2005).abs() < 1e-12, "{nearest}");
}

#[test]
fn a_rigid_body_cannot_be_in_plane_stress() {
    let text = "name = \"body\"
[domain]
lower_m = [-0.2, -0.2]
upper_m = [0.2, 0.2]
[time]
end_time_s = 0.1
step = { type = \"fixed\", time_step_s = 1e-6 }
[solid]
particle_spacing_m = 0.004
[[solid.body]]
name = \"thing\"
shape = { type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.04, 0.04] }
material = { density_kg_m3 = 1000.0, young_modulus_pa = 1e6, poisson_ratio = 0.4, plane = \"stress\" }
formulation = { type = \"rigid\" }
";
    let errors = bad(text).to_string();
    assert!(errors.contains("a rigid body bears no stress"), "{errors}");
    let sheet = good(&text.replace("rigid", "total-lagrangian"));
    let speed = sheet.solid_setup().unwrap().plane().unwrap().bodies[0].material.longitudinal_speed();
    // √(E/((1 − ν²) ρ)), to round-off.
    assert!((speed / (1e6_f64 / 0.84 / 1000.0).sqrt() - 1.0).abs() < 1e-12);
}

#[test]
fn a_round_wall_in_a_periodic_domain_has_layers_along_its_face() {
    let periodic = |kind: &str, shape: &str| {
        let text = tank(&format!(
            "[[fluid.region]]
name = \"water\"
shape = {{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.04, 0.04] }}
[[wall]]
name = \"obstacle\"
type = \"{kind}\"
shape = {shape}"
        ));
        let text = text.replace("[0.2, 0.3]\n", "[0.2, 0.3]\nperiodic = [\"x\"]\n");
        let setup = good(&text).fluid_setup().unwrap().plane().unwrap();
        let walls = setup.wall_particles;
        let own = (0..walls.wall.len()).filter(|w| walls.wall[*w] == 1);
        own.map(|w| walls.position[w]).collect::<Vec<Vector>>()
    };
    let (centre, radius) = (Vector::new(0.1, 0.15), 0.03);
    for (kind, first) in [("solid", radius - 0.002), ("container", radius + 0.002)] {
        let circle = periodic(kind, "{ type = \"circle\", centre_m = [0.1, 0.15], radius_m = 0.03 }");
        // A spacing apart, half a spacing behind the face.
        let ring = circle.iter().filter(|x| ((*x - centre).norm() - first).abs() < 1e-5).count();
        assert_eq!(ring, (std::f64::consts::TAU * first / 0.004).round() as usize, "{kind}");
    }
    // Its sides are half a spacing from rows.
    let off = periodic("solid", "{ type = \"rectangle\", lower_m = [0.082, 0.1], upper_m = [0.118, 0.14] }");
    let right = off.iter().map(|x| x.x).fold(0.0, f64::max);
    assert!((right - 0.116).abs() < 1e-9, "{right}");
}
