//! Particles at the centroids of their cells: a shape filled in layers along its faces, whatever their slope.
//!
//! The cell of a particle is what lies nearer to it than to any other (Voronoi); moving each particle to the centroid of
//! its cell again and again spreads them evenly (Lloyd 1982). Cells end at the faces, so that the outer layer comes to
//! stand half a spacing inside. Shapes enter as weighted samples of their inside: the same in any number of dimensions.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::thresholds::Thresholds;
use crate::neighbours::CellGrid;
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::tasks;

crate::constants! {
    const SMALLEST_CELL: f64 = 0.5, "packing.smallest_cell",
        "volume of a cell below which its particle is left out, in volumes of a lattice cell [-]";
    const ROUNDS: usize = 3, "packing.rounds",
        "times that particles are added and left out while they spread [-]";
    /// Twice would overshoot.
    const RELAXATION: f64 = 1.5, "packing.relaxation",
        "part of the way to the centroid that a particle moves [-]";
    const AT_REST: f64 = 0.02, "packing.at_rest",
        "distance of all particles from their centroids below which they are spread evenly, in spacings [-]";
    /// Larger ones would mean that the cells are wrong.
    const LARGEST_CORRECTION: f64 = 0.25, "packing.largest_correction",
        "largest relative change of a volume that makes the second moments exact [-]";
}

/// Nearest particles are looked for within this many spacings, in the plane and in space, where there are many more of them.
const REACH: [f64; 2] = [1.6, 1.05];

/// Rounds after which second moments, cells included, are exact to round-off.
const MOMENT_ROUNDS: usize = 6;

/// Eigenvalue over the largest below which particles do not extend in a direction.
const FLAT: f64 = 1e-9;

/// A part of the inside of a shape.
#[derive(Clone, Copy, Debug)]
pub struct Sample<S: Space> {
    /// Where it is \[m\].
    pub position: S::Vector,
    /// Its volume (area in the plane) \[m²\].
    pub volume: f64,
}

/// Particles that fill a shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packing<S: Space> {
    /// Centroids of the cells \[m\].
    pub position: Vec<S::Vector>,
    /// Volumes (areas in the plane) of the cells \[m²\].
    pub volume: Vec<f64>,
}

/// Volume and moments of a shape about its centroid.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments<S: Space> {
    /// Volume (area in the plane) \[m²\].
    pub volume: f64,
    /// Centroid \[m\].
    pub centroid: S::Vector,
    /// ∫ x_a x_b dV about the centroid \[m⁴\], by rows.
    pub second: Vec<f64>,
}

/// What is filled.
#[derive(Clone, Copy, Debug)]
pub struct Interior<'a, S: Space> {
    /// Its inside, as far as particles move.
    pub samples: &'a [Sample<S>],
    /// Width of a sample \[m\].
    pub width: f64,
    /// Particle spacing \[m\].
    pub spacing: f64,
}

/// The share of a sample that belongs to its nearest particle, and the rest to the second.
#[derive(Clone, Copy)]
struct Share {
    first: u32,
    second: u32,
    of_first: f64,
    /// Distance from the first \[m\].
    distance: f64,
}

/// Nothing is near.
const NONE: u32 = u32::MAX;

/// The cell of a particle.
struct Cell<V> {
    volume: f64,
    /// ∫ (x − x_i) dV.
    moment: V,
}

impl<S: Thresholds> Interior<'_, S> {
    /// Volume of a lattice cell \[m²\].
    fn lattice_cell(&self) -> f64 {
        S::cell_volume(self.spacing)
    }

    /// Which particles each sample belongs to.
    ///
    /// One that a boundary between two cells crosses is shared, so that volumes do not jump as particles move.
    fn shares(&self, position: &[S::Vector]) -> Vec<Share> {
        let open =
            Domain::<S> { lower: S::Vector::zeros(), upper: S::Vector::zeros(), periodic: S::splat(false) };
        let grid = CellGrid::new(&open, position, REACH[S::DIMENSIONS - 2] * self.spacing);
        let share = |sample: &Sample<S>| {
            let x = sample.position;
            let mut nearest = [(f64::INFINITY, NONE); 2];
            for range in grid.ranges(grid.cell(&x)).iter().cloned() {
                for &j in &grid.order()[range] {
                    let square = (position[j as usize] - x).norm_squared();
                    if square < nearest[0].0 {
                        nearest = [(square, j), nearest[0]];
                    } else if square < nearest[1].0 {
                        nearest[1] = (square, j);
                    }
                }
            }
            let [(near, first), (far, second)] = nearest;
            let of_first = if second == NONE {
                1.0
            } else {
                let apart = (position[first as usize] - position[second as usize]).norm();
                let to_boundary = (far - near) / (2.0 * apart).max(1e-300);
                (0.5 + to_boundary / self.width).min(1.0)
            };
            Share { first, second, of_first, distance: near.sqrt() }
        };
        tasks::map(self.samples.len(), 64, |k| share(&self.samples[k]))
    }

    fn cells(&self, position: &[S::Vector], shares: &[Share]) -> Vec<Cell<S::Vector>> {
        let mut cells: Vec<Cell<S::Vector>> =
            position.iter().map(|_| Cell { volume: 0.0, moment: S::Vector::zeros() }).collect();
        for (sample, share) in self.samples.iter().zip(shares) {
            let mut add = |k: u32, part: f64| {
                if let Some(cell) = cells.get_mut(k as usize) {
                    cell.volume += sample.volume * part;
                    cell.moment += (sample.position - position[k as usize]) * (sample.volume * part);
                }
            };
            add(share.first, share.of_first);
            add(share.second, 1.0 - share.of_first);
        }
        cells
    }

    /// Adds particles in the holes, the widest first.
    fn fill_holes(&self, position: &mut Vec<S::Vector>, free: &mut Vec<bool>) {
        let hole = S::HOLE * self.spacing;
        let mut holes: Vec<(f64, S::Vector)> = self
            .shares(position)
            .iter()
            .zip(self.samples)
            .filter(|(share, _)| share.distance > hole)
            .map(|(share, sample)| (share.distance, sample.position))
            .collect();
        holes.sort_by(|a, b| b.0.total_cmp(&a.0));
        let known = position.len();
        for (_, x) in holes {
            if position[known..].iter().all(|y| (x - *y).norm() > hole) {
                position.push(x);
                free.push(true);
            }
        }
    }

    /// Spreads the particles that are `free` evenly; the others stay and have the volume of a lattice cell.
    pub fn pack(&self, mut position: Vec<S::Vector>, mut free: Vec<bool>) -> Packing<S> {
        for round in 0..ROUNDS {
            self.fill_holes(&mut position, &mut free);
            for _ in 0..S::SWEEPS as usize {
                let cells = self.cells(&position, &self.shares(&position));
                let mut largest: f64 = 0.0;
                for ((x, cell), _) in position.iter_mut().zip(&cells).zip(&free).filter(|(_, free)| **free) {
                    if cell.volume > 0.0 {
                        let step = cell.moment / cell.volume;
                        largest = largest.max(step.norm());
                        *x += step * RELAXATION;
                    }
                }
                if largest < AT_REST * self.spacing {
                    break;
                }
            }
            if round + 1 < ROUNDS {
                let cells = self.cells(&position, &self.shares(&position));
                let least = SMALLEST_CELL * self.lattice_cell();
                let kept: Vec<bool> =
                    cells.iter().zip(&free).map(|(cell, free)| !free || cell.volume >= least).collect();
                if kept.iter().any(|kept| *kept) {
                    let mut keep = kept.iter();
                    position.retain(|_| keep.next().copied().unwrap_or(true));
                    let mut keep = kept.iter();
                    free.retain(|_| keep.next().copied().unwrap_or(true));
                }
            }
        }
        let cells = self.cells(&position, &self.shares(&position));
        let volume = |(cell, free): (&Cell<S::Vector>, &bool)| {
            if *free { cell.volume } else { self.lattice_cell() }
        };
        let volume = cells.iter().zip(&free).map(volume).collect();
        // The last step ends on the centroid itself, so that moments of the cells are those of the shape.
        for ((x, cell), _) in position.iter_mut().zip(&cells).zip(&free).filter(|(_, free)| **free) {
            if cell.volume > 0.0 {
                *x += cell.moment / cell.volume;
            }
        }
        Packing { position, volume }
    }
}

impl<S: Space> Packing<S> {
    /// Scales the volumes by 1 + a polynomial of second degree in the position, so that volume, centroid and second
    /// moments, with those of the cells about their own centres, are those of the shape.
    ///
    /// The cell of a particle counts as a square (a cube): V^(1 + 2/D)/12 along each axis. A body of too few particles to
    /// have all moments keeps its volume.
    pub fn match_moments(&mut self, exact: &Moments<S>) {
        let n = S::DIMENSIONS;
        let before = self.volume.clone();
        let pairs: Vec<(usize, usize)> = (0..n).flat_map(|a| (a..n).map(move |b| (a, b))).collect();
        let length = exact.volume.powf(1.0 / n as f64);
        let basis = |x: &S::Vector| {
            let r = (*x - exact.centroid) / length;
            let linear = (0..n).map(|a| r[a]);
            let quadratic = pairs.iter().map(|(a, b)| r[*a] * r[*b]);
            DVector::from_iterator(1 + n + pairs.len(), std::iter::once(1.0).chain(linear).chain(quadratic))
        };
        for _ in 0..MOMENT_ROUNDS {
            let mut missing = DVector::zeros(1 + n + pairs.len());
            missing[0] = exact.volume;
            for (k, (a, b)) in pairs.iter().enumerate() {
                missing[1 + n + k] = exact.second[a * n + b] / (length * length);
            }
            let mut matrix = DMatrix::zeros(missing.len(), missing.len());
            for (x, v) in self.position.iter().zip(&self.volume) {
                let phi = basis(x);
                missing -= &phi * *v;
                let own = v.powf(1.0 + 2.0 / n as f64) / 12.0 / (length * length);
                for (k, _) in pairs.iter().enumerate().filter(|(_, (a, b))| a == b) {
                    missing[1 + n + k] -= own;
                }
                matrix += &phi * phi.transpose() * *v;
            }
            let change = pseudo_inverse(matrix) * missing;
            for (x, v) in self.position.iter().zip(&mut self.volume) {
                *v *= 1.0 + change.dot(&basis(x));
            }
        }
        let sound = |(now, then): (&f64, &f64)| (now / then - 1.0).abs() <= LARGEST_CORRECTION;
        if !self.volume.iter().zip(&before).all(sound) {
            self.volume = before;
        }
        let factor = exact.volume / self.volume.iter().sum::<f64>();
        self.volume.iter_mut().for_each(|v| *v *= factor);
    }
}

fn pseudo_inverse(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(matrix);
    let bound = FLAT * eigen.eigenvalues.max();
    let inverse = eigen.eigenvalues.map(|value| if value > bound { 1.0 / value } else { 0.0 });
    &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}
