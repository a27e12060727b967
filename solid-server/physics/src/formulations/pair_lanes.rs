//! The sums of [`SumLaw`] over the particles of one body, four neighbours at a time.

use sph::geometry::Geometry;
use sph::kernel::KernelLanes;
use sph::lanes::{Kernel, Lanes, WIDTH};
use sph::vector::{SymmetricTensor, Tensor, Vector};

use crate::formulations::pair_law::{PairSums, SumLaw};
use crate::neighbours::lists::Rows;
use crate::neighbours::stencil::{splat, vectors};

/// The particles of one body as pairs read them.
#[derive(Clone, Copy)]
pub struct Members<'a> {
    /// Position \[m\].
    pub position: &'a [Vector],
    /// Velocity \[m/s\].
    pub velocity: &'a [Vector],
    /// Mass per depth \[kg/m\].
    pub mass: &'a [f64],
    /// Density \[kg/m³\].
    pub density: &'a [f64],
    /// Cauchy stress \[Pa\].
    pub stress: &'a [SymmetricTensor],
    /// Artificial stress R_i \[m⁵/(kg s²)\].
    pub artificial: &'a [SymmetricTensor],
}

/// Sums over own-body pairs of the particles from `first` on.
pub struct Pairs<'a, G> {
    pub geometry: G,
    pub law: &'a SumLaw,
    pub members: Members<'a>,
    /// Candidates of each particle.
    pub neighbours: &'a Rows,
    pub first: usize,
    pub sums: &'a mut [PairSums],
}

impl<G: Geometry> Kernel for Pairs<'_, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { geometry, law, members, neighbours, first, sums } = self;
        // Loops, since a closure would not be compiled for the path's instructions.
        if law.artificial_stress == 0.0 {
            let law = LawLanes::<L, false>::new(law);
            for (k, sums) in sums.iter_mut().enumerate() {
                *sums = law.sum(geometry, &members, neighbours.of(first + k), first + k);
            }
        } else {
            let law = LawLanes::<L, true>::new(law);
            for (k, sums) in sums.iter_mut().enumerate() {
                *sums = law.sum(geometry, &members, neighbours.of(first + k), first + k);
            }
        }
    }
}

/// [`SumLaw`] in lanes; `ARTIFICIAL` where it has an artificial stress.
struct LawLanes<'a, L, const ARTIFICIAL: bool> {
    law: &'a SumLaw,
    kernel: KernelLanes<L>,
    square_support: f64,
    smoothing_length: L,
    regularisation: L,
    viscosity_a: L,
    viscosity_b: L,
    /// W(0)/W(d₀) \[-\].
    central_nearness: L,
}

/// One particle in all lanes.
struct Own<L> {
    position: [L; 2],
    velocity: [L; 2],
    mass: L,
    density: L,
    stress: [L; 3],
    artificial: [L; 3],
}

/// [`PairSums`] being gathered.
struct Batches<L> {
    force: [L; 2],
    /// By rows.
    gradient: [L; 4],
    /// xx, xy, yy.
    moment: [L; 3],
}

impl<'a, L: Lanes, const ARTIFICIAL: bool> LawLanes<'a, L, ARTIFICIAL> {
    #[inline(always)]
    fn new(law: &'a SumLaw) -> Self {
        let h = law.kernel.smoothing_length();
        Self {
            law,
            kernel: law.pair_kernel.lanes(),
            square_support: law.kernel.support_radius().powi(2),
            smoothing_length: L::splat(h),
            regularisation: L::splat(law.lambda * h * h),
            viscosity_a: L::splat(law.viscosity_a * law.sound_speed),
            viscosity_b: L::splat(law.viscosity_b),
            central_nearness: L::splat(law.central_nearness()),
        }
    }

    /// The sums of particle `i` over those of `candidates` that lie within support.
    ///
    /// These alone fill the batches, in the order of the row: when a list was built does not show in the sums.
    #[inline(always)]
    fn sum<G: Geometry>(&self, geometry: G, members: &Members<'_>, candidates: &[u32], i: usize) -> PairSums {
        let (own, zero) = (Own::new(members, i), L::zero());
        let mut sums = Batches { force: [zero; 2], gradient: [zero; 4], moment: [zero; 3] };
        // The particle itself adds nothing. Indices of a body stay below 2^32.
        let nobody = [i as u32; WIDTH];
        let (mut batch, mut filled) = (nobody, 0);
        for j in candidates {
            let d = geometry.separation(&members.position[i], &members.position[*j as usize]);
            if d.norm_squared() < self.square_support {
                batch[filled] = *j;
                filled += 1;
            }
            if filled == WIDTH {
                self.add(geometry, &mut sums, &own, members, batch);
                (batch, filled) = (nobody, 0);
            }
        }
        if filled > 0 {
            self.add(geometry, &mut sums, &own, members, batch);
        }
        sums.total()
    }

    /// Adds four neighbours, Eq. (17), (21), (23)-(26), as [`SumLaw::add_pair`] adds one.
    #[inline(always)]
    fn add<G: Geometry>(
        &self,
        geometry: G,
        sums: &mut Batches<L>,
        own: &Own<L>,
        members: &Members<'_>,
        batch: [u32; WIDTH],
    ) {
        let [x_j, y_j] = vectors::<L>(members.position, batch);
        let (x, y) = (geometry.nearest(own.position[0] - x_j, 0), geometry.nearest(own.position[1] - y_j, 1));
        let [v_xj, v_yj] = vectors::<L>(members.velocity, batch);
        let (v_x, v_y) = (own.velocity[0] - v_xj, own.velocity[1] - v_yj);
        let (mass, density) = (numbers::<L>(members.mass, batch), numbers::<L>(members.density, batch));

        let square = (x * x).plus_product(y, y);
        let (s, slope) = self.kernel.slope(square);
        let gradient_factor = slope / s;
        // All that a pair shares is symmetric in its particles to the last bit, so that forces are opposite.
        let inverse_densities = L::splat(1.0) / (own.density * density);

        let weight = mass * own.density * inverse_densities * gradient_factor;
        let (w_x, w_y) = (weight * x, weight * y);
        let [xx, xy, yx, yy] = &mut sums.gradient;
        *xx = xx.minus_product(v_x, w_x);
        *xy = xy.minus_product(v_x, w_y);
        *yx = yx.minus_product(v_y, w_x);
        *yy = yy.minus_product(v_y, w_y);
        let [xx, xy, yy] = &mut sums.moment;
        *xx = xx.minus_product(x, w_x);
        *xy = xy.minus_product(x, w_y);
        *yy = yy.minus_product(y, w_y);

        // One division for θ and 1/ρ̄.
        let approach = (v_x * x).plus_product(v_y, y).min(L::zero());
        let (regular, density_sum) = (square + self.regularisation, own.density + density);
        let inverse = L::splat(1.0) / (regular * density_sum);
        let theta = self.smoothing_length * approach * (inverse * density_sum);
        let damping = (self.viscosity_b * theta - self.viscosity_a) * theta;
        let viscosity = (damping + damping) * (inverse * regular);

        let [xx, xy, yy] = tensors::<L>(members.stress, batch);
        let [own_xx, own_xy, own_yy] = own.stress;
        let mut law = [
            ((own_xx + xx) * inverse_densities) - viscosity,
            (own_xy + xy) * inverse_densities,
            ((own_yy + yy) * inverse_densities) - viscosity,
        ];
        if ARTIFICIAL {
            let nearness = self.nearness(s);
            let artificial = tensors::<L>(members.artificial, batch);
            for ((law, own), other) in law.iter_mut().zip(own.artificial).zip(artificial) {
                *law = law.plus_product(own + other, nearness);
            }
        }
        let factor = own.mass * mass * gradient_factor;
        let [xx, xy, yy] = law;
        let [f_x, f_y] = &mut sums.force;
        *f_x = f_x.plus_product(factor, (xx * x).plus_product(xy, y));
        *f_y = f_y.plus_product(factor, (xy * x).plus_product(yy, y));
    }

    /// Fⁿ of Eq. (26) \[-\] at s = r/h.
    #[inline(always)]
    fn nearness(&self, s: L) -> L {
        let outer = (L::splat(2.0) - s).max(L::zero());
        let inner = (L::splat(1.0) - s).max(L::zero());
        let value = (L::splat(0.25) * outer * (outer * outer)).minus_product(inner * inner, inner);
        let ratio = self.central_nearness * value;
        if self.law.exponent == 4.0 {
            (ratio * ratio) * (ratio * ratio)
        } else {
            L::from_array(ratio.to_array().map(|ratio| ratio.powf(self.law.exponent)))
        }
    }
}

impl<L: Lanes> Own<L> {
    #[inline(always)]
    fn new(members: &Members<'_>, i: usize) -> Self {
        Self {
            position: splat(&members.position[i]),
            velocity: splat(&members.velocity[i]),
            mass: L::splat(members.mass[i]),
            density: L::splat(members.density[i]),
            stress: splat_tensor(&members.stress[i]),
            artificial: splat_tensor(&members.artificial[i]),
        }
    }
}

impl<L: Lanes> Batches<L> {
    #[inline(always)]
    fn total(self) -> PairSums {
        let [xx, xy, yx, yy] = L::sums(self.gradient);
        let [m_xx, m_xy, m_yy] = self.moment;
        let [f_x, f_y] = self.force;
        let [m_xx, m_xy, m_yy, f_x] = L::sums([m_xx, m_xy, m_yy, f_x]);
        let [f_y, ..] = L::sums([f_y, L::zero(), L::zero(), L::zero()]);
        PairSums {
            force: Vector::new(f_x, f_y),
            gradient: Tensor::new(xx, xy, yx, yy),
            moment: SymmetricTensor { xx: m_xx, yy: m_yy, xy: m_xy },
        }
    }
}

/// Components 11, 12, 22 in each lane.
#[inline(always)]
fn splat_tensor<L: Lanes>(tensor: &SymmetricTensor) -> [L; 3] {
    [L::splat(tensor.xx), L::splat(tensor.xy), L::splat(tensor.yy)]
}

/// Four of `values`.
#[inline(always)]
fn numbers<L: Lanes>(values: &[f64], batch: [u32; WIDTH]) -> L {
    L::from_array(batch.map(|j| values[j as usize]))
}

/// Components 11, 12, 22 of four of `values`.
#[inline(always)]
fn tensors<L: Lanes>(values: &[SymmetricTensor], batch: [u32; WIDTH]) -> [L; 3] {
    let tensors = batch.map(|j| &values[j as usize]);
    [
        L::from_array(tensors.map(|t| t.xx)),
        L::from_array(tensors.map(|t| t.xy)),
        L::from_array(tensors.map(|t| t.yy)),
    ]
}

#[cfg(test)]
mod tests {
    use sph::domain::Domain;
    use sph::geometry::Periodic;
    use sph::lanes::Arithmetic;
    use sph::neighbours::CellGrid;
    use sph::setup::{ElasticMaterial, UpdatedLagrangian};

    use super::*;
    use crate::formulations::pair_law::PairParticle;

    const SMOOTHING_LENGTH: f64 = 1.3;

    /// A displaced lattice of 7 × 5 across the edge of a periodic box, in stress and motion.
    struct Patch {
        domain: Domain,
        law: SumLaw,
        position: Vec<Vector>,
        velocity: Vec<Vector>,
        mass: Vec<f64>,
        density: Vec<f64>,
        stress: Vec<SymmetricTensor>,
        artificial: Vec<SymmetricTensor>,
    }

    impl Patch {
        fn new(artificial_stress: f64, exponent: f64) -> Self {
            let domain = Domain {
                lower: Vector::new(0.0, -9.0),
                upper: Vector::new(12.0, 9.0),
                periodic: [true, false],
            };
            let constants = UpdatedLagrangian {
                smoothing_length: SMOOTHING_LENGTH,
                gradient_correction: true,
                viscosity_a: 1.0,
                viscosity_b: 0.5,
                lambda: 0.01,
                artificial_stress,
                artificial_stress_exponent: exponent,
            };
            let material = ElasticMaterial { density: 2.0, bulk_modulus: 5.0, shear_modulus: 3.0 };
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

        fn members(&self) -> Members<'_> {
            Members {
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
            rows.fill(&CellGrid::new(domain, x, radius).list(domain, x, x, radius, true), |_, _| true);
            rows
        }

        fn sums(&self, arithmetic: Arithmetic, neighbours: &Rows) -> Vec<PairSums> {
            let mut sums = vec![PairSums::default(); self.position.len()];
            arithmetic.run(Pairs {
                geometry: Periodic::new(&self.domain),
                law: &self.law,
                members: self.members(),
                neighbours,
                first: 0,
                sums: &mut sums,
            });
            sums
        }

        fn one_by_one(&self, i: usize, neighbours: &Rows) -> PairSums {
            let particle = |i: usize| PairParticle {
                mass: self.mass[i],
                density: self.density[i],
                velocity: self.velocity[i],
                stress: self.stress[i],
                artificial_stress: self.artificial[i],
            };
            let mut sums = PairSums::default();
            for j in neighbours.of(i).iter().map(|j| *j as usize) {
                let x_ij = self.domain.separation(&self.position[i], &self.position[j]);
                self.law.add_pair(&mut sums, &particle(i), &particle(j), &x_ij);
            }
            sums
        }
    }

    /// With artificial stress by multiplications and by a power, and without.
    fn patches() -> [Patch; 3] {
        [Patch::new(0.3, 4.0), Patch::new(0.3, 2.5), Patch::new(0.0, 4.0)]
    }

    #[test]
    fn sums_four_at_a_time_are_those_one_by_one() {
        for (patch, arithmetic) in
            patches().iter().flat_map(|patch| Arithmetic::all().map(move |a| (patch, a)))
        {
            let rows = patch.rows(2.0 * SMOOTHING_LENGTH);
            for (i, sums) in patch.sums(arithmetic, &rows).iter().enumerate() {
                let expected = patch.one_by_one(i, &rows);
                // Sums of order ten over some twenty pairs.
                assert!(expected.force.norm() > 0.01, "{i}");
                assert!((sums.force - expected.force).norm() < 1e-13, "{i}");
                assert!((sums.gradient - expected.gradient).norm() < 1e-13, "{i}");
                let rest = sums.moment.plus(&expected.moment.scaled(-1.0));
                assert!(rest.xx.abs().max(rest.yy.abs()).max(rest.xy.abs()) < 1e-13, "{i}");
            }
        }
    }

    #[test]
    fn what_a_list_holds_beyond_the_support_does_not_show() {
        for (patch, arithmetic) in
            patches().iter().flat_map(|patch| Arithmetic::all().map(move |a| (patch, a)))
        {
            let (tight, wide) = (patch.rows(2.0 * SMOOTHING_LENGTH), patch.rows(2.5 * SMOOTHING_LENGTH));
            assert!((0..patch.mass.len()).any(|i| tight.of(i).len() != wide.of(i).len()));
            assert_eq!(patch.sums(arithmetic, &tight), patch.sums(arithmetic, &wide));
        }
    }

    #[test]
    fn two_particles_feel_opposite_forces_to_the_last_bit() {
        for (patch, arithmetic) in
            patches().iter().flat_map(|patch| Arithmetic::all().map(move |a| (patch, a)))
        {
            for i in 1..patch.mass.len() {
                let two = patch.only([i - 1, i]);
                let sums = two.sums(arithmetic, &two.rows(2.0 * SMOOTHING_LENGTH));
                assert_eq!(sums[0].force, -sums[1].force, "{i}");
                // At the ends of the lattice's rows they are out of reach.
                assert!(i % 7 == 0 || sums[0].force.norm() > 1e-3, "{i}");
            }
        }
    }
}
