//! The sums of [`SumLaw`] over the particles of one body, four neighbours at a time.

use sph::kernel::KernelLanes;
use sph::kernel::shape::Spline;
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::space::geometry::Geometry;
use sph::space::{SymmetricTensor, Tensor, Vector};

use crate::formulations::pair_law::{PairSums, SumLaw, fourth_power};
use crate::neighbours::lists::Rows;
use crate::neighbours::stencil::{splat, vectors};

/// The particles of one body as pairs read them.
#[derive(Clone, Copy)]
pub struct BodyArrays<'a> {
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
pub struct PairPass<'a, G> {
    pub geometry: G,
    pub law: &'a SumLaw,
    pub members: BodyArrays<'a>,
    /// Candidates of each particle.
    pub neighbours: &'a Rows,
    pub first: usize,
    pub sums: &'a mut [PairSums],
}

impl<G: Geometry> LanePass for PairPass<'_, G> {
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
    viscosity: ArtificialViscosity<L>,
    /// F of Eq. (26).
    nearness: Spline<L>,
}

/// One particle in all lanes.
struct CentreParticle<L> {
    position: [L; 2],
    velocity: [L; 2],
    mass: L,
    density: L,
    stress: [L; 3],
    artificial: [L; 3],
}

/// [`PairSums`] being gathered.
struct LaneSums<L> {
    force: [L; 2],
    /// By rows.
    gradient: [L; 4],
    /// xx, xy, yy.
    moment: [L; 3],
}

impl<'a, L: Lanes, const ARTIFICIAL: bool> LawLanes<'a, L, ARTIFICIAL> {
    #[inline(always)]
    fn new(law: &'a SumLaw) -> Self {
        Self {
            law,
            kernel: law.pair_kernel.lanes(),
            square_support: law.kernel.support_radius().powi(2),
            viscosity: law.artificial_viscosity().lanes(),
            nearness: law.nearness(),
        }
    }

    /// The sums of particle `i` over those of `candidates` that lie within support.
    ///
    /// These alone fill the batches, in the order of the row: when a list was built does not show in the sums.
    #[inline(always)]
    fn sum<G: Geometry>(
        &self,
        geometry: G,
        members: &BodyArrays<'_>,
        candidates: &[u32],
        i: usize,
    ) -> PairSums {
        let (own, zero) = (CentreParticle::new(members, i), L::zero());
        let mut sums = LaneSums { force: [zero; 2], gradient: [zero; 4], moment: [zero; 3] };
        // The particle itself adds nothing. Indices of a body stay below 2^32.
        let filler = [i as u32; WIDTH];
        let (mut batch, mut filled) = (filler, 0);
        for j in candidates {
            let d = geometry.separation(&members.position[i], &members.position[*j as usize]);
            if d.norm_squared() < self.square_support {
                batch[filled] = *j;
                filled += 1;
            }
            if filled == WIDTH {
                self.add(geometry, &mut sums, &own, members, batch);
                (batch, filled) = (filler, 0);
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
        sums: &mut LaneSums<L>,
        own: &CentreParticle<L>,
        members: &BodyArrays<'_>,
        batch: [u32; WIDTH],
    ) {
        let [x_j, y_j] = vectors::<L>(members.position, batch);
        let [x, y] = geometry.nearest([own.position[0] - x_j, own.position[1] - y_j]);
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

        // Π_ij of Eq. (23), with one division for θ and 1/ρ̄.
        let approach = (v_x * x).plus_product(v_y, y);
        let (regularised, density_sum) = (self.viscosity.regularised(square), own.density + density);
        let inverse = L::splat(1.0) / (regularised * density_sum);
        let damping = self.viscosity.pressure_over_density(approach * (inverse * density_sum));
        let viscosity = (damping + damping) * (inverse * regularised);

        let [xx, xy, yy] = tensors::<L>(members.stress, batch);
        let [own_xx, own_xy, own_yy] = own.stress;
        let mut law = [
            ((own_xx + xx) * inverse_densities) - viscosity,
            (own_xy + xy) * inverse_densities,
            ((own_yy + yy) * inverse_densities) - viscosity,
        ];
        if ARTIFICIAL {
            let nearness = self.power_of_nearness(s);
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
    fn power_of_nearness(&self, s: L) -> L {
        let ratio = self.nearness.at(s);
        if self.law.exponent == 4.0 {
            fourth_power(ratio)
        } else {
            L::from_array(ratio.to_array().map(|ratio| ratio.powf(self.law.exponent)))
        }
    }
}

impl<L: Lanes> CentreParticle<L> {
    #[inline(always)]
    fn new(members: &BodyArrays<'_>, i: usize) -> Self {
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

impl<L: Lanes> LaneSums<L> {
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
mod tests;
