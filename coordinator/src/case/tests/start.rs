//! What regions of water are at the start: masses, pressures, velocities, and the balance of a column at rest.

use sph::kernel::CubicSpline;
use sph::laws::equation_of_state::Tait;
use sph::space::Plane;
use sph::space::Vector;
use sph::space::domain::Domain;

use super::*;

/// A column of still water, periodic across, 100 rows of 3 mm deep.
fn column(start: &str, correction: &str) -> Case {
    good(&format!(
        "name = \"column\"
[domain]
lower_m = [0.0, 0.0]
upper_m = [0.03, 0.4]
periodic = [\"x\"]
[body_force]
gravity_m_s2 = [0.0, -9.81]
[time]
end_time_s = 0.1
step = {{ type = \"fixed\", time_step_s = 1e-4 }}
[fluid]
particle_spacing_m = 0.003
rest_density_kg_m3 = 1000.0
sound_speed_m_s = 17.16
kernel_ratio = 1.2
gradient_correction = \"{correction}\"
[[fluid.region]]
name = \"water\"
shape = {{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.03, 0.3] }}
start = {start}
[[wall]]
name = \"floor\"
type = \"container\"
open_sides = [\"top\"]
"
    ))
}

/// Vertical acceleration by Eq. (22) of the particle nearest to `height` [m], over g; 0 is at rest.
fn imbalance(case: &Case, height: f64, moment: f64) -> f64 {
    let setup = case.fluid_setup().unwrap().plane().unwrap();
    let (c, particles) = (&setup.parameters, &setup.particles);
    let kernel = CubicSpline::<Plane>::new(c.smoothing_length());
    let tait = Tait::new(c.rest_density, c.sound_speed, c.exponent);
    let domain: Domain = setup.run.domain;
    let distance = |k: usize| (particles.position[k] - Vector::new(0.015, height)).norm();
    let i = (0..particles.id.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap();
    let (rho_i, p_i) = (particles.density[i], tait.pressure(particles.density[i]));
    let mut acceleration = 0.0;
    for j in 0..particles.id.len() {
        let x_ij = domain.separation(&particles.position[i], &particles.position[j]);
        let (rho_j, p_j) = (particles.density[j], tait.pressure(particles.density[j]));
        let gradient = kernel.gradient(&x_ij, x_ij.norm()) / moment;
        acceleration -= particles.mass[j] * (p_i + p_j) / (rho_i * rho_j) * gradient.y;
    }
    (acceleration - 9.81) / 9.81
}

#[test]
fn the_consistent_hydrostatic_start_is_at_rest_and_the_uniform_one_is_not() {
    let moment = CubicSpline::<Plane>::new(1.2).lattice_moment(1.0);
    let consistent = column("{ type = \"hydrostatic\", surface_m = 0.3 }", "lattice-moment");
    // Ten rows above the floor the sums see no wall. What is left: the lattice moment of slightly compressed rows.
    assert!(imbalance(&consistent, 0.03, moment).abs() < 4e-3, "{}", imbalance(&consistent, 0.03, moment));
    let uniform =
        column("{ type = \"hydrostatic\", surface_m = 0.3, lattice = \"uniform\" }", "lattice-moment");
    // Volumes that do not fill the lattice pull by 2p/(ρc²) = 1.8 %.
    assert!(imbalance(&uniform, 0.03, moment).abs() > 1.2e-2, "{}", imbalance(&uniform, 0.03, moment));
    // Without correction the sums balance p = ρgd/M, which the start takes.
    let uncorrected = column("{ type = \"hydrostatic\", surface_m = 0.3 }", "none");
    assert!(imbalance(&uncorrected, 0.03, 1.0).abs() < 4e-3, "{}", imbalance(&uncorrected, 0.03, 1.0));
}

#[test]
fn a_hydrostatic_start_keeps_the_mass_and_sinks_by_its_compression() {
    let setup = column("{ type = \"hydrostatic\", surface_m = 0.3 }", "lattice-moment")
        .fluid_setup()
        .unwrap()
        .plane()
        .unwrap();
    let mass: f64 = setup.particles.mass.iter().sum();
    assert!((mass - 1000.0 * 0.03 * 0.3).abs() < 1e-9);
    let top = setup.particles.position.iter().map(|x| x.y).fold(0.0, f64::max);
    // Linear estimate: H·ρgH/(2ρc₀²) = 1.50 mm, of which γ = 7 takes 0.04 mm in second order.
    assert!((0.2985 - top - 1.46e-3).abs() < 1e-5, "{top}");
    let lowest =
        setup.particles.position.iter().zip(&setup.particles.density).min_by(|a, b| a.0.y.total_cmp(&b.0.y));
    let pressure = Tait::new(1000.0, 17.16, 7.0).pressure(*lowest.unwrap().1);
    // Depth 298.5 mm in rest volume.
    assert!((pressure - 1000.0 * 9.81 * 0.2985).abs() < 1e-6);
}

#[test]
fn confined_water_stays_in_its_place_and_has_the_mass_of_its_pressure() {
    let particles = |surface: &str| {
        let start = format!("{{ type = \"hydrostatic\", surface_m = {surface} }}");
        column(&start, "lattice-moment").fluid_setup().unwrap().plane().unwrap().particles
    };
    let (tait, height) = (Tait::new(1000.0, 17.16, 7.0), |k: usize| (k as f64 + 0.5) * 3e-3);
    let confined = particles("0.4");
    let mut rows: Vec<_> =
        (0..confined.id.len()).map(|k| (confined.position[k].y, confined.density[k])).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.dedup_by(|a, b| (a.0 - b.0).abs() < 1e-9);
    assert_eq!(rows.len(), 100);
    for (k, (y, _)) in rows.iter().enumerate() {
        assert!((y - height(k)).abs() < 1e-12, "{y}");
    }
    for k in 0..confined.id.len() {
        assert!((confined.mass[k] / confined.density[k] - 9e-6).abs() < 1e-18);
    }
    // Every row carries the weight of those above.
    let pressure = |k: usize| tait.pressure(rows[k].1);
    let above: f64 = (1..100).map(|k| 0.5 * (rows[k - 1].1 + rows[k].1) * 9.81 * 3e-3).sum();
    // Trapezoids of a density that bends by 1e-4 over 100 rows.
    assert!((pressure(0) - pressure(99) - above).abs() < 1e-3, "{} {above}", pressure(0) - pressure(99));
    assert!((pressure(99) / (1000.0 * 9.81 * 0.1015) - 1.0).abs() < 3e-3, "{}", pressure(99));
    // A row that did not fit in is no lid.
    let open = particles("0.302");
    assert!(open.mass.iter().all(|mass| (mass - 9e-3).abs() < 1e-15));
}

#[test]
fn pressure_by_expression_fills_the_cells_or_keeps_the_mass() {
    let start = |mass: &str| {
        format!("{{ type = \"pressure\", pressure_pa = \"1e4*(0.3-y)\", particle_mass = \"{mass}\" }}")
    };
    for (word, constant_volume) in [("from-density", true), ("rest", false)] {
        let particles =
            column(&start(word), "lattice-moment").fluid_setup().unwrap().plane().unwrap().particles;
        let tait = Tait::new(1000.0, 17.16, 7.0);
        for k in 0..particles.id.len() {
            let wanted = 1e4 * (0.3 - particles.position[k].y);
            assert!((tait.pressure(particles.density[k]) - wanted).abs() < 1e-6);
            let volume = particles.mass[k] / particles.density[k];
            assert_eq!((volume - 9e-6).abs() < 1e-15, constant_volume, "{volume}");
        }
    }
}

#[test]
fn displaced_lattices_repeat_with_their_seed() {
    let with = |seed: &str| {
        let text = tank_with(&[(
            "name = \"water\"",
            &format!("name = \"water\"\ndisplacement_fraction = 0.1\ndisplacement_seed = {seed}"),
        )]);
        good(&text).fluid_setup().unwrap().plane().unwrap().particles.position
    };
    let (a, b, c) = (with("7"), with("7"), with("8"));
    assert_eq!(a, b);
    assert_ne!(a, c);
    let rest = good(TANK).fluid_setup().unwrap().plane().unwrap().particles.position;
    let largest = a.iter().zip(&rest).map(|(a, r)| (a - r).amax()).fold(0.0, f64::max);
    assert!((0.9e-3..=1e-3).contains(&largest), "{largest}");
}

#[test]
fn velocities_by_expression_and_rotation() {
    let text = tank_with(&[
        ("name = \"water\"", "name = \"water\"\nvelocity_m_s = [\"-x\", \"2*y\"]"),
        ("name = \"block\"", "name = \"block\"\nvelocity_m_s = [1.5, 0]\nrotation_speed_rad_s = 10.0"),
    ]);
    let case = good(&text);
    let fluid = case.fluid_setup().unwrap().plane().unwrap().particles;
    assert!(fluid.position.iter().zip(&fluid.velocity).all(|(x, v)| *v == Vector::new(-x.x, 2.0 * x.y)));
    let solid = case.solid_setup().unwrap().plane().unwrap().particles;
    let centre = Vector::new(0.08, 0.18);
    for k in 0..36 {
        let r = solid.position[k] - centre;
        let expected = Vector::new(1.5 - 10.0 * r.y, 10.0 * r.x);
        assert!((solid.velocity[k] - expected).norm() < 1e-12);
    }
}
