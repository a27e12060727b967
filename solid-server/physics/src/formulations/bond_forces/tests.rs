use sph::kernel::CubicSpline;
use sph::lanes::Arithmetic;
use sph::space::domain::Domain;
use sph::space::geometry::Periodic;
use sph::space::{Plane, Tensor, Vector};

use super::*;
use crate::neighbours::reference::{Reference, ReferencePair};
use crate::neighbours::stencil::MomentPass;

fn viscosity() -> Viscosity {
    Viscosity { law: ArtificialViscosity::new(0.75, 0.3, 0.7, 0.01), density: 1.2 }
}

/// A lattice of 7 × 4 across the edge of a periodic box, nothing held.
struct Patch {
    domain: Domain,
    reference: Reference<Plane>,
    position: Vec<Vector>,
    velocity: Vec<Vector>,
}

impl Patch {
    /// Displaced and moved by `amount` of what may look random.
    fn new(amount: f64) -> Self {
        let domain =
            Domain { lower: Vector::new(0.0, -9.0), upper: Vector::new(12.0, 9.0), periodic: [true, false] };
        let start: Vec<Vector> =
            (0..28).map(|k| Vector::new(f64::from(k % 7) + 9.3, f64::from(k / 7))).collect();
        let start: Vec<Vector> = start.iter().map(|x| domain.wrapped(x)).collect();
        let n = start.len();
        let reference =
            Reference::new(&domain, &start, vec![1.0; n], vec![false; n], &CubicSpline::new(0.75));
        let wave = |k: usize, by: f64| Vector::new((by * k as f64).sin(), (1.7 * by * k as f64).cos());
        let position = start.iter().enumerate().map(|(k, x)| x + wave(k, 2.3) * amount).collect();
        let velocity = (0..n).map(|k| wave(k, 3.1) * amount).collect();
        Self { domain, reference, position, velocity }
    }

    fn x_ij(&self, i: usize) -> impl Fn(&ReferencePair<Plane>) -> Vector {
        move |pair| self.domain.separation(&self.position[i], &self.position[pair.neighbour as usize])
    }

    fn pair_tensor(&self) -> Vec<[f64; 4]> {
        let entry = |k: usize| (1.9 * k as f64).sin();
        (0..self.position.len()).map(|i| [entry(i), entry(i + 40), entry(i + 80), entry(i + 120)]).collect()
    }

    fn forces(
        &self,
        arithmetic: Arithmetic,
        pair_tensor: &[[f64; 4]],
        viscosity: Option<Viscosity>,
    ) -> Vec<Vector> {
        let bonds = Bonds {
            geometry: Periodic::new(&self.domain),
            stencils: &self.reference.stencils,
            position: &self.position,
            velocity: &self.velocity,
            pair_tensor,
            units: ForceUnits::new(1.3, 1.0),
            viscosity,
        };
        let mut forces = vec![Vector::zeros(); self.position.len()];
        let viscous = &mut forces.clone();
        arithmetic.run(ForcePass { bonds: &bonds, first: 0, forces: &mut forces, viscous });
        forces
    }
}

#[test]
fn sums_four_at_a_time_are_those_one_by_one() {
    let patch = Patch::new(0.1);
    let n = patch.position.len();
    let pair_tensor = patch.pair_tensor();
    for arithmetic in Arithmetic::all() {
        let mut found = vec![Tensor::zeros(); n];
        arithmetic.run(MomentPass {
            geometry: Periodic::new(&patch.domain),
            stencils: &patch.reference.stencils,
            position: &patch.position,
            first: 0,
            sums: &mut found,
        });
        let elastic = patch.forces(arithmetic, &pair_tensor, None);
        let both = patch.forces(arithmetic, &pair_tensor, Some(viscosity()));
        for i in 0..n {
            // Sums of order one over at most eight pairs.
            let f = patch.reference.completed(&patch.domain, &patch.position, i, &found[i]);
            assert!((f - patch.reference.deformation_gradient(i, patch.x_ij(i))).norm() < 1e-14);
            let row = patch.reference.of(i);
            let units = ForceUnits::new(1.3, 1.0);
            let plain = patch.reference.force(i, row.iter(), &pair_tensor, &units, patch.x_ij(i));
            assert!((elastic[i] - plain).norm() < 1e-14 * (1.0 + plain.norm()), "{i}");
            let viscous: Vector = row
                .iter()
                .map(|pair| {
                    let x_ij = patch.x_ij(i)(pair);
                    let v_ij = patch.velocity[i] - patch.velocity[pair.neighbour as usize];
                    x_ij * (pair.weight * viscosity().pressure(v_ij.dot(&x_ij), x_ij.norm_squared()))
                })
                .sum();
            assert!(viscous.norm() > 1e-6);
            assert!((both[i] - elastic[i] - viscous).norm() < 1e-14);
        }
    }
}

#[test]
fn pair_forces_are_opposite_and_a_body_at_rest_feels_none() {
    for arithmetic in Arithmetic::all() {
        let patch = Patch::new(0.1);
        let forces = patch.forces(arithmetic, &patch.pair_tensor(), Some(viscosity()));
        assert!(forces.iter().any(|force| force.norm() > 0.1));
        assert!(forces.iter().sum::<Vector>().norm() < 1e-14 * forces.len() as f64);
        // N = −I of F = I without stress.
        let rest = Patch::new(0.0);
        let pair_tensor = vec![[-1.0, 0.0, 0.0, -1.0]; rest.position.len()];
        assert!(rest.forces(arithmetic, &pair_tensor, None).iter().all(|force| *force == Vector::zeros()));
    }
}
