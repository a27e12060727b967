//! Volume of the water from the positions of its particles: how densely they stand, and whether there are holes.

use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};

use super::nodes::Nodes;

sph::constants! {
    /// In the middle of those between which the volume correction fades: below it a particle is at a surface, or the lattice
    /// around it is so stretched that nodes read its gaps.
    const SURROUNDED_EIGENVALUE: f64 = 0.9, "quality.surrounded_eigenvalue",
        "smallest eigenvalue of the moment matrix of a particle that counts as surrounded [-]";
    /// Below it what is left does not stand for the water.
    const LEAST_SURROUNDED: f64 = 0.1, "quality.least_surrounded",
        "share of the water that must be on nodes without a surface for a volume to be read [-]";
    /// That of the volume correction.
    const LEAST_FLUID_CLAIM: f64 = 0.02, "quality.least_fluid_claim",
        "least claim of the water on a node, over that of walls and solids [-]";
    /// That of the volume correction: the first row at a face that nothing touches has 0.68, the second 0.92.
    const LEAST_CLAIM_AROUND_SOLIDS: f64 = 0.85, "quality.least_claim_around_solids",
        "least mean claim around a particle of a solid that counts as surrounded [-]";
    /// A free surface has about N^(1 − 1/d) particles; where edges of walls meet some are not surrounded even so.
    const FULL_RIM: f64 = 0.2, "quality.full_rim",
        "particles of N that nothing surrounds at the start, over N^(1 - 1/d), up to which water fills its container [-]";
}

/// Particles at one time.
pub struct Cloud<S: Space> {
    /// Domain.
    pub domain: Domain<S>,
    /// Kernel of the fluid.
    pub kernel: CubicSpline<S>,
    /// Particle spacing of the fluid \[m\].
    pub spacing: f64,
    /// Positions \[m\]: of the water first, then of walls, then of solids.
    pub position: Vec<S::Vector>,
    /// Volumes \[m³\], in the plane per depth.
    pub volume: Vec<f64>,
    /// Particles of the water.
    pub water: usize,
    /// Particles of solids.
    pub solids: usize,
}

/// What the positions of the water say of its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filling {
    /// How much more volume the densities claim than there is for the water, over the latter \[-\]; `None` when too little
    /// of the water is inside.
    ///
    /// ```text
    /// Σ_n (σ_n − 1) / Σ_n (φ_n − σ_n + 1),   σ_n = Σ_j V_j w_nj / V_n,   φ_n the same over the water
    /// ```
    /// V_j is m/ρ of water, Δx² of walls, m/ρ of solids, w_nj the weight of a particle on a node, V_n the volume of its
    /// cell. Nodes count on which no particle at a surface has a weight, nor one of a solid that is not surrounded, and the
    /// water has some beside walls and solids. In water that fills its container the sum is all that is claimed in excess,
    /// however the particles lie at its walls. A sum at the particles themselves is biased, since their places are not
    /// independent of each other.
    pub excess: Option<f64>,
    /// Whether the water has no free surface.
    pub is_full: bool,
}

impl<S: Space> Cloud<S> {
    /// Reads the volume of the water.
    pub fn filling(&self) -> Filling {
        let Self { domain, kernel, position, volume, water, .. } = self;
        let radius = kernel.support_radius();
        let grid = CellGrid::new(domain, position, radius);
        // Each target is a neighbour of itself.
        let list = grid.list(domain, &position[..*water], position, radius);
        let is_at_surface = |i: usize| {
            let mut moment = S::Tensor::zeros();
            for j in list.of(i).iter().map(|j| *j as usize) {
                let x_ij = domain.separation(&position[i], &position[j]);
                moment -= S::Tensor::outer(&x_ij, &x_ij) * (volume[j] * kernel.gradient_factor(x_ij.norm()));
            }
            let [_, smallest] = S::SymmetricTensor::of(&moment).extremes();
            smallest <= SURROUNDED_EIGENVALUE
        };
        let at_surface: Vec<bool> = (0..*water).map(is_at_surface).collect();
        // Counts far below 2^53.
        let open = at_surface.iter().filter(|at_surface| **at_surface).count() as f64;
        let rim = FULL_RIM * (*water as f64).powf(1.0 - 1.0 / S::DIMENSIONS as f64);
        Filling { excess: self.excess(&at_surface), is_full: open <= rim }
    }

    /// See [`Filling::excess`]; `at_surface` says which particles of the water are not surrounded.
    fn excess(&self, at_surface: &[bool]) -> Option<f64> {
        let Self { domain, kernel, position, volume, water, solids, .. } = self;
        let nodes = Nodes::over(domain, &position[..*water], kernel.smoothing_length());
        let (mut fluid, mut all) = (vec![0.0; nodes.len()], vec![0.0; nodes.len()]);
        for (j, x) in position.iter().enumerate() {
            nodes.for_each(x, |node, weight| {
                let claim = weight * volume[j] / nodes.volume();
                all[node] += claim;
                if j < *water {
                    fluid[node] += claim;
                }
            });
        }
        let is_beside_a_void = |solid: &&S::Vector| {
            let mut around = 0.0;
            nodes.for_each(solid, |node, weight| around += weight * all[node]);
            around < LEAST_CLAIM_AROUND_SOLIDS
        };
        let mut counts = vec![true; nodes.len()];
        let surface = position.iter().zip(at_surface).filter(|(_, at_surface)| **at_surface).map(|(x, _)| x);
        for x in surface.chain(position[position.len() - solids..].iter().filter(is_beside_a_void)) {
            nodes.for_each(x, |node, _| counts[node] = false);
        }
        let (mut excess, mut inside, mut whole) = (0.0, 0.0, 0.0);
        for ((fluid, all), counts) in fluid.iter().zip(&all).zip(counts) {
            whole += fluid;
            if counts && *fluid > LEAST_FLUID_CLAIM * (all - fluid) {
                (excess, inside) = (excess + all - 1.0, inside + fluid);
            }
        }
        (inside > excess.max(0.0) && inside >= LEAST_SURROUNDED * whole).then(|| excess / (inside - excess))
    }

    /// Largest distance from a point of the water to its nearest particle over the spacing \[-\], as seen from points half
    /// a spacing apart; 0.75, about that of a lattice, when it is smaller. For water that fills its container.
    ///
    /// A point belongs to the water when particles lie within six spacings in each direction of each axis, and one of
    /// water is hardly farther than the nearest of all: the inside of walls is hollow.
    pub fn cavity(&self) -> f64 {
        const SMALLEST: f64 = 0.75;
        let Self { domain, spacing, position, water, .. } = self;
        let reach = 6.0 * spacing;
        let grid = CellGrid::new(domain, position, reach);
        let near = CellGrid::new(domain, position, SMALLEST * spacing);
        let mut widest = SMALLEST;
        for points in self.points() {
            let close = near.list(domain, &points, position, SMALLEST * spacing);
            let empty = points.iter().enumerate().filter(|(k, _)| close.of(*k).is_empty()).map(|(_, x)| *x);
            let empty: Vec<S::Vector> = empty.collect();
            let list = grid.list(domain, &empty, position, reach);
            for (k, x) in empty.iter().enumerate() {
                let to = |j: &u32| domain.separation(&position[*j as usize], x);
                let distance = |j: &&u32| to(j).norm();
                let nearest = list.of(k).iter().map(|j| to(j).norm()).fold(f64::INFINITY, f64::min);
                let of_water = list.of(k).iter().filter(|j| (**j as usize) < *water);
                let nearest_water = of_water.map(|j| distance(&j)).fold(f64::INFINITY, f64::min);
                let belongs = nearest_water <= nearest + 2.0 * spacing && nearest / spacing > widest;
                if belongs && is_enclosed::<S>(list.of(k).iter().map(to)) {
                    widest = nearest / spacing;
                }
            }
        }
        widest
    }

    /// Points half a spacing apart over the box of the water, in rows along the first axis.
    fn points(&self) -> impl Iterator<Item = Vec<S::Vector>> {
        let step = 0.5 * self.spacing;
        let (mut lower, mut upper) = (S::Vector::repeat(f64::INFINITY), S::Vector::repeat(f64::NEG_INFINITY));
        for x in &self.position[..self.water] {
            (lower, upper) = (lower.inf(x), upper.sup(x));
        }
        // Bounded by the particles, which fill the box; a box without water has none.
        let counts: Vec<usize> = (0..S::DIMENSIONS)
            .map(|axis| ((upper[axis] - lower[axis]) / step).max(-1.0).floor() as isize + 1)
            .map(|count| usize::try_from(count).unwrap_or(0))
            .collect();
        let rows: usize = counts[1..].iter().product();
        (0..rows).map(move |row| {
            let (mut start, mut rest) = (lower, row);
            for (axis, count) in counts.iter().enumerate().skip(1) {
                start[axis] += step * (rest % count) as f64;
                rest /= count;
            }
            let along = |k: usize| {
                let mut x = start;
                x[0] += step * k as f64;
                x
            };
            (0..counts[0]).map(along).collect()
        })
    }
}

/// Whether there is something within 45° of each direction of each axis.
fn is_enclosed<S: Space>(offsets: impl Iterator<Item = S::Vector>) -> bool {
    let mut found = vec![[false; 2]; S::DIMENSIONS];
    for d in offsets {
        let least = std::f64::consts::FRAC_1_SQRT_2 * d.norm();
        for (axis, found) in found.iter_mut().enumerate() {
            found[0] |= d[axis] >= least;
            found[1] |= -d[axis] >= least;
        }
    }
    found.iter().flatten().all(|found| *found)
}

#[cfg(test)]
mod tests {
    use sph::space::{Plane, Vector};

    use super::*;

    /// A periodic square of 20 × 20 particles a metre apart, each of volume `volume`, moved by `at`.
    fn lattice(volume: f64, at: impl Fn(Vector) -> Vector) -> Cloud<Plane> {
        let domain = Domain { lower: Vector::zeros(), upper: Vector::repeat(20.0), periodic: [true; 2] };
        let place = |k: i32| at(Vector::new(f64::from(k % 20) + 0.5, f64::from(k / 20) + 0.5));
        Cloud {
            domain,
            kernel: CubicSpline::new(1.3),
            spacing: 1.0,
            position: (0..400).map(place).collect(),
            volume: vec![volume; 400],
            water: 400,
            solids: 0,
        }
    }

    #[test]
    fn densities_that_claim_one_percent_too_much_volume_read_so() {
        let filling = lattice(1.01, |x| x).filling();
        // The lattice shows on nodes 1.3 spacings apart, but not in their sum.
        assert!((filling.excess.unwrap() - 0.01).abs() < 1e-6, "{filling:?}");
        assert!(filling.is_full);
        // Stretched by a per cent, their densities as before: they claim too little.
        let mut stretched = lattice(1.0, |x| Vector::new(1.01 * x.x, x.y));
        stretched.domain.upper.x *= 1.01;
        let excess = stretched.filling().excess.unwrap();
        assert!((excess - (1.0 / 1.01 - 1.0)).abs() < 1e-6, "{excess}");
    }

    #[test]
    fn a_surface_is_no_error_of_the_volume() {
        let mut open = lattice(1.0, |x| x);
        open.domain.periodic = [false; 2];
        let filling = open.filling();
        // The second row still counts as surrounded and misses some of its outermost neighbours: a few tenths of a
        // percent where it is a fifth of all.
        assert!(filling.excess.unwrap().abs() < 3e-3 && !filling.is_full, "{filling:?}");
        // Nor is it overlooked in a shaft that is thirty times as deep as wide.
        let mut shaft = lattice(1.0, |x| x);
        shaft.domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(5.0, 200.0), periodic: [true, false] };
        let place = |k: i32| Vector::new(f64::from(k % 5) + 0.5, f64::from(k / 5) + 0.5);
        (shaft.position, shaft.volume, shaft.water) = ((0..750).map(place).collect(), vec![1.0; 750], 750);
        assert!(!shaft.filling().is_full);
        // A thread has no inside.
        let mut thread = lattice(1.0, |x| Vector::new(x.x, 0.05 * x.y));
        thread.domain.periodic = [false; 2];
        thread.position.retain(|x| x.y < 0.05);
        (thread.volume, thread.water) = (vec![1.0; thread.position.len()], thread.position.len());
        assert_eq!(thread.filling().excess, None);
    }

    /// Two rows of a solid between water and a void.
    #[test]
    fn a_void_behind_a_solid_is_no_error_of_the_volume() {
        let mut tank = lattice(1.0, |x| x);
        tank.domain.periodic = [false, true];
        // Row by row along x; a surface to the left as well.
        tank.position.sort_by(|a, b| a.x.total_cmp(&b.x));
        tank.position.truncate(300);
        (tank.volume, tank.water, tank.solids) = (vec![1.0; 300], 260, 40);
        let filling = tank.filling();
        // 2e-4 without nodes that have the outermost row, -1.3e-3 with them.
        assert!(filling.excess.unwrap().abs() < 6e-4, "{filling:?}");
    }

    #[test]
    fn a_hole_in_full_water_is_seen_with_its_size_and_the_hollow_of_a_wall_is_not() {
        assert_eq!(lattice(1.0, |x| x).cavity(), 0.75);
        let cut = |cloud: &mut Cloud<Plane>, radius: f64| {
            cloud.position.retain(|x| (x - Vector::repeat(10.0)).norm() > radius);
            (cloud.volume, cloud.water) = (vec![1.0; cloud.position.len()], cloud.position.len());
        };
        let mut torn = lattice(1.0, |x| x);
        cut(&mut torn, 3.0);
        // The nearest left of a circle of 3 about the middle of a cell, (2.5, 2.5) or (3.5, 0.5) away.
        let cavity = torn.cavity();
        assert!((cavity - 3.5355).abs() < 0.3, "{cavity}");
        // The same hole lined with three rows of wall: its inside is not water.
        let mut walled = lattice(1.0, |x| x);
        cut(&mut walled, 6.5);
        let wall = lattice(1.0, |x| x).position.into_iter();
        let wall = wall.filter(|x| (3.4..=6.5).contains(&(x - Vector::repeat(10.0)).norm()));
        walled.position.extend(wall);
        walled.volume = vec![1.0; walled.position.len()];
        assert_eq!(walled.cavity(), 0.75);
    }
}
