//! Sums of a total-Lagrangian body over its fixed neighbours, four at a time.

use sph::geometry::Geometry;
use sph::lanes::{Kernel, Lanes, WIDTH};
use sph::vector::{Tensor, Vector};

use crate::neighbours::reference::ForceUnits;

/// Four neighbours of one particle; what fills the last batch up has no weight.
#[derive(Clone, Copy, Debug)]
struct Batch {
    neighbours: [u32; WIDTH],
    /// a_ij \[-\].
    weight: [f64; WIDTH],
    /// a_ij X_ij \[m\], by axis.
    arm: [[f64; WIDTH]; 2],
}

/// Neighbours of each particle of a body, in batches.
#[derive(Debug)]
pub struct Stencils {
    /// End of each row.
    ends: Vec<u32>,
    batches: Vec<Batch>,
}

/// A neighbour with its weight a_ij \[-\] and reference separation X_ij \[m\].
pub type Neighbour = (u32, f64, Vector);

impl Stencils {
    /// No particles yet.
    pub fn new() -> Self {
        Self { ends: Vec::new(), batches: Vec::new() }
    }

    /// Adds a particle with its neighbours.
    pub fn push(&mut self, mut neighbours: impl Iterator<Item = Neighbour>) {
        // Its own index: a particle that every sum may read.
        let own = self.ends.len() as u32;
        while let Some(first) = neighbours.next() {
            let mut batch = Batch { neighbours: [own; WIDTH], weight: [0.0; WIDTH], arm: [[0.0; WIDTH]; 2] };
            let rest = neighbours.by_ref().take(WIDTH - 1);
            for (lane, (j, weight, separation)) in std::iter::once(first).chain(rest).enumerate() {
                batch.neighbours[lane] = j;
                batch.weight[lane] = weight;
                for axis in 0..2 {
                    batch.arm[axis][lane] = weight * separation[axis];
                }
            }
            self.batches.push(batch);
        }
        // Batches of one body stay far below 2^32.
        self.ends.push(self.batches.len() as u32);
    }

    #[inline(always)]
    fn of(&self, i: usize) -> &[Batch] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.batches[start as usize..self.ends[i] as usize]
    }
}

/// Four rows of `values`.
#[inline(always)]
pub fn vectors<L: Lanes>(values: &[Vector], indices: [u32; WIDTH]) -> [L; 2] {
    let [a, b, c, d] = indices.map(|j| &values[j as usize].data.0[0]);
    L::halves([a, b, c, d])
}

/// x_ij \[m\] of the neighbours of a particle at `own`.
#[inline(always)]
fn separations<L: Lanes, G: Geometry>(
    geometry: G,
    own: &[L; 2],
    position: &[Vector],
    batch: &Batch,
) -> [L; 2] {
    let [x, y] = vectors::<L>(position, batch.neighbours);
    [geometry.nearest(own[0] - x, 0), geometry.nearest(own[1] - y, 1)]
}

/// A vector in each lane.
#[inline(always)]
pub fn splat<L: Lanes>(vector: &Vector) -> [L; 2] {
    [L::splat(vector.x), L::splat(vector.y)]
}

/// Σ_j a_ij x_ij ⊗ X_ij of particles from `first` on.
pub struct Moments<'a, G> {
    pub geometry: G,
    pub stencils: &'a Stencils,
    /// Positions of the whole body \[m\].
    pub position: &'a [Vector],
    pub first: usize,
    pub sums: &'a mut [Tensor],
}

impl<G: Geometry> Kernel for Moments<'_, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (k, sum) in self.sums.iter_mut().enumerate() {
            let i = self.first + k;
            let own = splat(&self.position[i]);
            let mut moments = [L::zero(); 4];
            for batch in self.stencils.of(i) {
                let [x, y] = separations(self.geometry, &own, self.position, batch);
                let arm = batch.arm.map(L::from_array);
                let [xx, yx, xy, yy] = &mut moments;
                *xx = xx.plus_product(x, arm[0]);
                *yx = yx.plus_product(y, arm[0]);
                *xy = xy.plus_product(x, arm[1]);
                *yy = yy.plus_product(y, arm[1]);
            }
            let [xx, yx, xy, yy] = L::sums(moments);
            *sum = Tensor::new(xx, xy, yx, yy);
        }
    }
}

/// The artificial viscosity of Eq. (23)-(24) between material points.
#[derive(Clone, Copy, Debug)]
pub struct Viscosity {
    /// h \[m\].
    pub smoothing_length: f64,
    /// A c_L \[m/s\].
    pub speed: f64,
    /// B \[-\].
    pub quadratic: f64,
    /// ρ₀ \[kg/m³\].
    pub density: f64,
}

/// λ of Eq. (24) \[-\].
const LAMBDA: f64 = 0.01;

impl Viscosity {
    /// Force on particle i over a_ij x_ij, at r² = `square` \[m²\] and v_ij·x_ij = `approach` \[m²/s\] \[Pa\].
    ///
    /// ```text
    /// ρ₀ (−A c_L θ + B θ²),  θ = h v_ij·x_ij/(x_ij² + λh²) < 0
    /// ```
    #[inline(always)]
    fn factor<L: Lanes>(&self, square: L, approach: L) -> L {
        let h = self.smoothing_length;
        let theta = L::splat(h) * approach.min(L::zero()) / (square + L::splat(LAMBDA * h * h));
        let damping = (L::splat(self.quadratic) * theta - L::splat(self.speed)) * theta;
        L::splat(self.density) * damping
    }

    /// The same of one pair.
    pub fn of_pair(&self, square: f64, approach: f64) -> f64 {
        let h = self.smoothing_length;
        let theta = h * approach.min(0.0) / (square + LAMBDA * h * h);
        self.density * (self.quadratic * theta - self.speed) * theta
    }
}

/// What pair forces of a body read.
#[derive(Clone, Copy)]
pub struct Bonds<'a, G> {
    pub geometry: G,
    pub stencils: &'a Stencils,
    /// Positions of the whole body \[m\].
    pub position: &'a [Vector],
    /// Its velocities \[m/s\].
    pub velocity: &'a [Vector],
    /// Its N of [`crate::neighbours::reference::Reference::shown`] \[-\].
    pub shown: &'a [Tensor],
    pub units: ForceUnits,
    /// None where there is no viscosity, which then costs nothing.
    pub viscosity: Option<Viscosity>,
}

/// Pair forces \[N/m\] on the particles from `first` on.
pub struct Forces<'a, G> {
    pub bonds: &'a Bonds<'a, G>,
    pub first: usize,
    pub forces: &'a mut [Vector],
}

impl<G: Geometry> Kernel for Forces<'_, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { bonds, first, forces } = self;
        for (k, force) in forces.iter_mut().enumerate() {
            *force = match &bonds.viscosity {
                Some(viscosity) => bonds.force::<L, true>(first + k, viscosity),
                None => bonds.force::<L, false>(first + k, &Viscosity::NONE),
            };
        }
    }
}

impl Viscosity {
    const NONE: Self = Self { smoothing_length: 0.0, speed: 0.0, quadratic: 0.0, density: 0.0 };
}

impl<G: Geometry> Bonds<'_, G> {
    #[inline(always)]
    fn force<L: Lanes, const VISCOUS: bool>(&self, i: usize, viscosity: &Viscosity) -> Vector {
        let (own, velocity) = (splat::<L>(&self.position[i]), splat::<L>(&self.velocity[i]));
        let shown = L::splat_each(entries(&self.shown[i]));
        let twice = L::splat(2.0 * self.units.hourglass);
        // Elastic x, y in units of the modulus, viscous x, y.
        let mut sums = [L::zero(); 4];
        for batch in self.stencils.of(i) {
            let [x, y] = separations(self.geometry, &own, self.position, batch);
            let [a, b, c, d] = batch.neighbours.map(|j| entries_of(&self.shown[j as usize]));
            let [xx, yx, xy, yy] = L::columns([a, b, c, d]);
            let ([arm_x, arm_y], weight) = (batch.arm.map(L::from_array), L::from_array(batch.weight));
            // Each pair by itself, so that what rests in its reference cancels to the last bit.
            let x_part = (twice * (weight * x)).plus_product(shown[0] + xx, arm_x);
            let y_part = (twice * (weight * y)).plus_product(shown[1] + yx, arm_x);
            sums[0] = sums[0] + x_part.plus_product(shown[2] + xy, arm_y);
            sums[1] = sums[1] + y_part.plus_product(shown[3] + yy, arm_y);
            if VISCOUS {
                let [v_x, v_y] = vectors::<L>(self.velocity, batch.neighbours);
                let approach = ((velocity[0] - v_x) * x).plus_product(velocity[1] - v_y, y);
                let factor = weight * viscosity.factor((x * x).plus_product(y, y), approach);
                sums[2] = sums[2].plus_product(factor, x);
                sums[3] = sums[3].plus_product(factor, y);
            }
        }
        let [x, y, viscous_x, viscous_y] = L::sums(sums);
        Vector::new(x, y) * -self.units.modulus + Vector::new(viscous_x, viscous_y)
    }
}

/// T_xx, T_yx, T_xy, T_yy of a tensor.
#[inline(always)]
fn entries(tensor: &Tensor) -> [f64; 4] {
    let [[xx, yx], [xy, yy]] = tensor.data.0;
    [xx, yx, xy, yy]
}

/// The same without a copy.
#[inline(always)]
fn entries_of(tensor: &Tensor) -> &[f64; 4] {
    let [entries] = tensor.data.0.as_flattened().as_chunks().0 else { unreachable!("two by two are four") };
    entries
}

#[cfg(test)]
mod tests {
    use sph::domain::Domain;
    use sph::geometry::Periodic;
    use sph::kernel::CubicSpline;
    use sph::lanes::Arithmetic;

    use super::*;
    use crate::neighbours::reference::{Reference, ReferencePair};

    const VISCOSITY: Viscosity =
        Viscosity { smoothing_length: 0.75, speed: 0.3, quadratic: 0.7, density: 1.2 };

    /// A lattice of 7 × 4 across the edge of a periodic box, nothing held.
    struct Patch {
        domain: Domain,
        reference: Reference,
        position: Vec<Vector>,
        velocity: Vec<Vector>,
    }

    impl Patch {
        /// Displaced and moved by `amount` of what may look random.
        fn new(amount: f64) -> Self {
            let domain = Domain {
                lower: Vector::new(0.0, -9.0),
                upper: Vector::new(12.0, 9.0),
                periodic: [true, false],
            };
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

        fn x_ij(&self, i: usize) -> impl Fn(&ReferencePair) -> Vector {
            move |pair| self.domain.separation(&self.position[i], &self.position[pair.neighbour as usize])
        }

        fn shown(&self) -> Vec<Tensor> {
            let entry = |k: usize| (1.9 * k as f64).sin();
            (0..self.position.len())
                .map(|i| Tensor::new(entry(i), entry(i + 40), entry(i + 80), entry(i + 120)))
                .collect()
        }

        fn forces(
            &self,
            arithmetic: Arithmetic,
            shown: &[Tensor],
            viscosity: Option<Viscosity>,
        ) -> Vec<Vector> {
            let bonds = Bonds {
                geometry: Periodic::new(&self.domain),
                stencils: &self.reference.stencils,
                position: &self.position,
                velocity: &self.velocity,
                shown,
                units: ForceUnits::new(1.3, 1.0),
                viscosity,
            };
            let mut forces = vec![Vector::zeros(); self.position.len()];
            arithmetic.run(Forces { bonds: &bonds, first: 0, forces: &mut forces });
            forces
        }
    }

    #[test]
    fn sums_four_at_a_time_are_those_one_by_one() {
        let patch = Patch::new(0.1);
        let n = patch.position.len();
        let shown = patch.shown();
        for arithmetic in Arithmetic::all() {
            let mut found = vec![Tensor::zeros(); n];
            arithmetic.run(Moments {
                geometry: Periodic::new(&patch.domain),
                stencils: &patch.reference.stencils,
                position: &patch.position,
                first: 0,
                sums: &mut found,
            });
            let elastic = patch.forces(arithmetic, &shown, None);
            let both = patch.forces(arithmetic, &shown, Some(VISCOSITY));
            for i in 0..n {
                // Sums of order one over at most eight pairs.
                let f = patch.reference.completed(&patch.domain, &patch.position, i, &found[i]);
                assert!((f - patch.reference.deformation_gradient(i, patch.x_ij(i))).norm() < 1e-14);
                let row = patch.reference.of(i);
                let units = ForceUnits::new(1.3, 1.0);
                let plain = patch.reference.force(i, row.iter(), &shown, &units, patch.x_ij(i));
                assert!((elastic[i] - plain).norm() < 1e-14 * (1.0 + plain.norm()), "{i}");
                let viscous: Vector = row
                    .iter()
                    .map(|pair| {
                        let x_ij = patch.x_ij(i)(pair);
                        let v_ij = patch.velocity[i] - patch.velocity[pair.neighbour as usize];
                        x_ij * (pair.weight * VISCOSITY.of_pair(x_ij.norm_squared(), v_ij.dot(&x_ij)))
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
            let forces = patch.forces(arithmetic, &patch.shown(), Some(VISCOSITY));
            assert!(forces.iter().any(|force| force.norm() > 0.1));
            assert!(forces.iter().sum::<Vector>().norm() < 1e-14 * forces.len() as f64);
            // N = −I of F = I without stress.
            let rest = Patch::new(0.0);
            let shown = vec![-Tensor::identity(); rest.position.len()];
            assert!(rest.forces(arithmetic, &shown, None).iter().all(|force| *force == Vector::zeros()));
        }
    }
}
