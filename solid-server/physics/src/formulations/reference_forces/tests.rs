use nalgebra::{Matrix3, Vector3};
use sph::kernel::CubicSpline;
use sph::random::SplitMix64;
use sph::space::domain::Domain;
use sph::space::{Plane, Spatial, Tensor, Vector};

use super::*;

fn open() -> Domain {
    Domain { lower: Vector::new(-9.0, -9.0), upper: Vector::new(9.0, 9.0), periodic: [false; 2] }
}

fn lattice(columns: u32, rows: u32) -> (Vec<Vector>, Reference<Plane>) {
    anchored_lattice(columns, rows, 0)
}

/// A lattice whose first columns are anchored.
fn anchored_lattice(columns: u32, rows: u32, anchored: u32) -> (Vec<Vector>, Reference<Plane>) {
    let position: Vec<Vector> =
        (0..columns * rows).map(|k| Vector::new(f64::from(k % columns), f64::from(k / columns))).collect();
    let volume = vec![1.0; position.len()];
    let held = (0..columns * rows).map(|k| k % columns < anchored).collect();
    let reference = Reference::new(&open(), &position, volume, held, &CubicSpline::new(0.8));
    (position, reference)
}

#[test]
fn linear_maps_are_met_exactly_up_to_corners() {
    let map = Tensor::new(1.2, -0.7, 0.4, 0.9);
    for (columns, rows, anchored) in [(6, 5, 0), (2, 2, 0), (7, 2, 0), (6, 5, 2)] {
        let (position, reference) = anchored_lattice(columns, rows, anchored);
        for i in 0..position.len() {
            let f = reference.deformation_gradient(i, |pair| map * pair.separation);
            assert!((f - map).norm() < 1e-13, "{columns} x {rows}, particle {i}");
        }
    }
}

#[test]
fn a_single_row_turns_without_strain_across() {
    let (_, reference) = lattice(5, 1);
    let (sine, cosine) = 0.8f64.sin_cos();
    let turn = Tensor::new(cosine, -sine, sine, cosine);
    let f = reference.deformation_gradient(2, |pair| turn * pair.separation * 1.5);
    assert!((f - turn * Tensor::new(1.5, 0.0, 0.0, 1.0)).norm() < 1e-13);
    let lonely = lattice(1, 1).1.deformation_gradient(0, |_| Vector::zeros());
    assert_eq!(lonely, Tensor::identity());
}

#[test]
fn forces_are_minus_the_derivative_of_the_energy() {
    derivative_of_the_energy(0);
    // Two anchored columns: forces on the free particles.
    derivative_of_the_energy(2);
}

fn derivative_of_the_energy(anchored: u32) {
    let (mut x, reference) = anchored_lattice(5, 3, anchored);
    for (k, x) in x.iter_mut().enumerate().filter(|(k, _)| !reference.anchored[*k]) {
        *x += Vector::new((1.3 * k as f64).sin(), (2.1 * k as f64).cos()) * 0.1;
    }
    let law = crate::materials::hyperelastic::Hyperelastic::new(
        sph::setup::HyperelasticLaw::NeoHookean,
        &sph::setup::ElasticParameters {
            density: 1.0,
            bulk_modulus: 2.0,
            shear_modulus: 1.0,
            plane: sph::setup::PlaneState::Strain,
        },
    );
    let n = x.len();
    let k = 0.7;
    let deformation = |x: &[Vector]| -> Vec<Tensor> {
        (0..n)
            .map(|i| reference.deformation_gradient(i, |p| reference.separation(&open(), x, i, p)))
            .collect()
    };
    let energy = |x: &[Vector]| -> f64 {
        let f = deformation(x);
        (0..n)
            .filter(|i| !reference.anchored[*i])
            .map(|i| {
                let x_ij = |p: &ReferencePair<Plane>| reference.separation(&open(), x, i, p);
                law.energy_density::<Plane>(&f[i]) + reference.hourglass_energy(i, &f[i], k, x_ij)
            })
            .sum()
    };
    let f = deformation(&x);
    let units = ForceUnits::new(k, 1.0);
    let nominal = |i: usize| law.stress::<Plane>(&f[i]).nominal;
    let pair_tensor: Vec<[f64; 4]> =
        (0..n).map(|i| reference.pair_tensor(i, &f[i], &nominal(i), &units)).collect();
    let on = |i: usize| {
        let x_ij = |p: &ReferencePair<Plane>| reference.separation(&open(), &x, i, p);
        reference.force(i, reference.of(i).iter(), &pair_tensor, &units, x_ij)
    };
    // What the anchors take is what the others lack.
    assert!((0..n).map(on).sum::<Vector>().norm() < 1e-13);
    for i in (0..n).filter(|i| !reference.anchored[*i]) {
        let force = on(i);
        for axis in 0..2 {
            let shifted = |by: f64| {
                let mut x = x.clone();
                x[i][axis] += by;
                energy(&x)
            };
            let slope = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
            // Central difference of an energy of order one.
            assert!((force[axis] + slope).abs() < 1e-8, "particle {i} axis {axis}");
        }
    }
}

#[test]
fn the_largest_frequency_is_that_of_a_chain() {
    // A row of unit masses and P = ∂u/∂X: central differences make springs across two spacings, the ends one.
    let (_, reference) = lattice(40, 1);
    let mass = vec![1.0; 40];
    let omega = reference.largest_frequency(&mass, &ForceUnits::new(0.0, 1.0), |gradient| *gradient);
    // Infinite chain of central differences: ω = sin(kΔX) at most 1; the ends stiffen it, at most to 4.
    assert!(omega > 1.0 && omega < 2.0, "{omega}");
}

/// Largest frequency by `rounds` of power iteration from the displacements `u`.
fn by_powers(
    reference: &Reference<Spatial>,
    mass: &[f64],
    units: &ForceUnits,
    stress: &(impl Fn(&Matrix3<f64>) -> Matrix3<f64> + Sync),
    rounds: usize,
) -> f64 {
    let mut random = SplitMix64(7);
    let mut u: Vec<_> = mass.iter().map(|_| Vector3::from_fn(|_, _| random.symmetric())).collect();
    let mut square = 0.0;
    for _ in 0..rounds {
        u = reference.acceleration(&u, mass, units, stress);
        square = u.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
        u.iter_mut().for_each(|u| *u /= square);
    }
    square.sqrt()
}

#[test]
fn the_largest_frequency_of_a_clamped_bar_is_found_for_all_poissons_ratios() {
    let (across, along) = (6, 16);
    let place = |k: usize| Vector3::new(k / (across * across), k / across % across, k % across).cast::<f64>();
    let position: Vec<_> = (0..along * across * across).map(place).collect();
    let held = position.iter().map(|x| x[0] < 3.5).collect();
    let upper = Vector3::repeat(90.0);
    let open = Domain { lower: -upper, upper, periodic: [false; 3] };
    let kernel = CubicSpline::new(0.75);
    let mass = vec![1.0; position.len()];
    let reference = Reference::<Spatial>::new(&open, &position, mass.clone(), held, &kernel);
    for ratio in [0.0, 0.3, 0.4, 0.49] {
        let material = sph::setup::ElasticParameters {
            density: 1.0,
            bulk_modulus: 1.0 / (3.0 * (1.0 - 2.0 * ratio)),
            shear_modulus: 1.0 / (2.0 * (1.0 + ratio)),
            plane: sph::setup::PlaneState::Strain,
        };
        let law = crate::materials::hyperelastic::Hyperelastic::new(
            sph::setup::HyperelasticLaw::NeoHookean,
            &material,
        );
        let units = ForceUnits::new(0.3 / kernel.lattice_moment(1.0), 1.0);
        let stress = |gradient: &Matrix3<f64>| law.linear::<Spatial>(gradient);
        let found = reference.largest_frequency(&mass, &units, stress);
        let expected = by_powers(&reference, &mass, &units, &stress, 1000);
        // The bound of the error that is added makes it too large, by no more than a step may cost.
        assert!(found > 0.9999 * expected && found < 1.01 * expected, "{ratio}: {found} for {expected}");
    }
}
