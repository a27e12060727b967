use sph::lanes::Arithmetic;
use sph::neighbours::CellGrid;
use sph::setup::{ElasticParameters, UpdatedLagrangian};
use sph::space::domain::Domain;
use sph::space::geometry::Periodic;
use sph::space::tensors::SpaceSymmetric;
use sph::space::{Plane, Space, SymmetricTensor, Vector};

use super::*;
use crate::formulations::pair_law::PairParticle;

const SMOOTHING_LENGTH: f64 = 1.3;

/// A displaced lattice of 7 × 5 across the edge of a periodic box, in stress and motion.
struct Patch {
    domain: Domain,
    law: SumLaw<Plane>,
    position: Vec<Vector>,
    velocity: Vec<Vector>,
    mass: Vec<f64>,
    density: Vec<f64>,
    stress: Vec<SymmetricTensor>,
    artificial: Vec<SymmetricTensor>,
}

impl Patch {
    fn new(artificial_stress: f64, exponent: f64) -> Self {
        let domain =
            Domain { lower: Vector::new(0.0, -9.0), upper: Vector::new(12.0, 9.0), periodic: [true, false] };
        let constants = UpdatedLagrangian {
            kernel_ratio: SMOOTHING_LENGTH,
            viscosity_b: 0.5,
            artificial_stress,
            artificial_stress_exponent: exponent,
            ..UpdatedLagrangian::default()
        };
        let material = ElasticParameters {
            density: 2.0,
            bulk_modulus: 5.0,
            shear_modulus: 3.0,
            plane: sph::setup::PlaneState::Strain,
        };
        let n = 35;
        let wave = |k: usize, by: f64| (by * k as f64).sin();
        let pair = |k: usize, by: f64| Vector::new(wave(k, by), wave(k, 1.7 * by + 0.3));
        let tensor = |k: usize, by: f64| SymmetricTensor {
            xx: wave(k, by),
            yy: wave(k, by + 0.4),
            xy: wave(k, by + 0.9),
        };
        let lattice = |k: usize| Vector::new((k % 7) as f64 + 9.3, (k / 7) as f64);
        let each = 0..n;
        Self {
            domain,
            law: SumLaw::new(&constants, &material, 1.0),
            position: each.clone().map(|k| domain.wrapped(&(lattice(k) + pair(k, 2.3) * 0.2))).collect(),
            velocity: each.clone().map(|k| pair(k, 3.1)).collect(),
            mass: each.clone().map(|k| 2.0 + 0.3 * wave(k, 1.1)).collect(),
            density: each.clone().map(|k| 2.0 + 0.2 * wave(k, 4.2)).collect(),
            stress: each.clone().map(|k| tensor(k, 1.9)).collect(),
            artificial: each.map(|k| tensor(k, 2.9).scaled(artificial_stress)).collect(),
        }
    }

    /// Two of its particles.
    fn only(&self, pair: [usize; 2]) -> Self {
        fn both<T: Copy>(values: &[T], pair: [usize; 2]) -> Vec<T> {
            pair.map(|k| values[k]).to_vec()
        }
        Self {
            domain: self.domain,
            law: self.law,
            position: both(&self.position, pair),
            velocity: both(&self.velocity, pair),
            mass: both(&self.mass, pair),
            density: both(&self.density, pair),
            stress: both(&self.stress, pair),
            artificial: both(&self.artificial, pair),
        }
    }

    fn members(&self) -> BodyArrays<'_, Plane> {
        BodyArrays {
            position: &self.position,
            velocity: &self.velocity,
            mass: &self.mass,
            density: &self.density,
            stress: &self.stress,
            artificial: &self.artificial,
        }
    }

    /// Candidates within `radius`.
    fn rows(&self, radius: f64) -> Rows {
        let (domain, x) = (&self.domain, &self.position[..]);
        let mut rows = Rows::default();
        rows.fill(&CellGrid::new(domain, x, radius).list_among(domain, x, radius), |_, _| true);
        rows
    }

    fn sums(&self, arithmetic: Arithmetic, neighbours: &Rows) -> Vec<PairSums<Plane>> {
        let mut sums = vec![PairSums::zero(); self.position.len()];
        arithmetic.run(PairPass {
            geometry: Periodic::new(&self.domain),
            law: &self.law,
            members: self.members(),
            neighbours,
            first: 0,
            sums: &mut sums,
        });
        sums
    }

    fn one_by_one(&self, i: usize, neighbours: &Rows) -> PairSums<Plane> {
        let particle = |i: usize| PairParticle {
            mass: self.mass[i],
            density: self.density[i],
            velocity: self.velocity[i].into(),
            stress: Plane::symmetric_components(&self.stress[i]),
            artificial_stress: Plane::symmetric_components(&self.artificial[i]),
        };
        let mut sums = PairSums::zero();
        for j in neighbours.of(i).iter().map(|j| *j as usize) {
            let x_ij = self.domain.separation(&self.position[i], &self.position[j]);
            self.law.add_pair(&mut sums, &particle(i), &particle(j), &x_ij);
        }
        sums
    }
}

/// All components of `sums`.
fn all(sums: &PairSums<Plane>) -> Vec<f64> {
    [&sums.force[..], &sums.gradient, &sums.moment].concat()
}

/// With artificial stress by multiplications and by a power, and without.
fn patches() -> [Patch; 3] {
    [Patch::new(0.3, 4.0), Patch::new(0.3, 2.5), Patch::new(0.0, 4.0)]
}

#[test]
fn sums_four_at_a_time_are_those_one_by_one() {
    for (patch, arithmetic) in patches().iter().flat_map(|patch| Arithmetic::all().map(move |a| (patch, a))) {
        let rows = patch.rows(2.0 * SMOOTHING_LENGTH);
        for (i, sums) in patch.sums(arithmetic, &rows).iter().enumerate() {
            let expected = patch.one_by_one(i, &rows);
            // Sums of order ten over some twenty pairs.
            assert!(Vector::from(expected.force).norm() > 0.01, "{i}");
            let pairs = all(sums).into_iter().zip(all(&expected));
            assert!(
                pairs.map(|(found, expected)| (found - expected).powi(2)).sum::<f64>().sqrt() < 1e-13,
                "{i}"
            );
        }
    }
}

#[test]
fn what_a_list_holds_beyond_the_support_does_not_show() {
    for (patch, arithmetic) in patches().iter().flat_map(|patch| Arithmetic::all().map(move |a| (patch, a))) {
        let (tight, wide) = (patch.rows(2.0 * SMOOTHING_LENGTH), patch.rows(2.5 * SMOOTHING_LENGTH));
        assert!((0..patch.mass.len()).any(|i| tight.of(i).len() != wide.of(i).len()));
        let sums = |rows: &Rows| patch.sums(arithmetic, rows).iter().map(all).collect::<Vec<_>>();
        assert_eq!(sums(&tight), sums(&wide));
    }
}

#[test]
fn two_particles_feel_opposite_forces_to_the_last_bit() {
    for (patch, arithmetic) in patches().iter().flat_map(|patch| Arithmetic::all().map(move |a| (patch, a))) {
        for i in 1..patch.mass.len() {
            let two = patch.only([i - 1, i]);
            let sums = two.sums(arithmetic, &two.rows(2.0 * SMOOTHING_LENGTH));
            assert_eq!(Vector::from(sums[0].force), -Vector::from(sums[1].force), "{i}");
            // At the ends of the lattice's rows they are out of reach.
            assert!(i % 7 == 0 || Vector::from(sums[0].force).norm() > 1e-3, "{i}");
        }
    }
}
