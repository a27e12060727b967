//! How shapes are filled: on the lattice, in whole cells between the sides of a box, or in layers along the faces.

use sph::shapes::{Faces, OpenSides, Region, fill_fitted};
use sph::space::{AXIS_NAMES, Space};

use super::lattice::Lattice;
use super::space::SceneSpace;
use crate::case::errors::CaseError;
use crate::case::file::layout::Layout;
use crate::case::file::shape::ShapeTable;
use crate::case::reader::{At, Coordinates};
use crate::quote::quoted;

/// What `layout = "auto"` means for a shape that is neither on the lattice nor a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Otherwise {
    /// Layers along its faces.
    Fitted,
    /// The lattice, with masses such that their sum is that of the shape.
    Scaled,
}

/// Change of the masses that is no more than round-off, in per cent.
const EXACT: f64 = 1e-7;

/// Particles that fill a shape.
#[derive(Debug, Default)]
pub struct Filling<S: Space> {
    /// Where they are \[m\].
    pub positions: Vec<S::Vector>,
    /// Their cells.
    pub cells: Cells,
}

/// Cells of the particles that fill a shape.
#[derive(Debug, Default)]
pub enum Cells {
    /// Squares (cubes) of the lattice that fill the shape exactly.
    #[default]
    Lattice,
    /// Cells in rows between the sides of a box.
    Box {
        /// Volume (area in the plane) of each \[m³\].
        volume: Vec<f64>,
        /// Fewest along a side.
        across: usize,
    },
    /// Cells along the faces.
    Fitted {
        /// Volume (area in the plane) of each \[m³\].
        volume: Vec<f64>,
    },
    /// Cells of the lattice, scaled so that they have the volume of the shape.
    Scaled {
        /// Volume (area in the plane) of each \[m³\].
        volume: Vec<f64>,
    },
}

impl Cells {
    /// Volume (area in the plane) of each cell \[m³\]; `None` for those of the lattice.
    pub fn volume(&self) -> Option<&[f64]> {
        match self {
            Self::Lattice => None,
            Self::Box { volume, .. } | Self::Fitted { volume } | Self::Scaled { volume } => Some(volume),
        }
    }

    /// The same, to be changed with the list of particles.
    pub fn volume_mut(&mut self) -> Option<&mut Vec<f64>> {
        match self {
            Self::Lattice => None,
            Self::Box { volume, .. } | Self::Fitted { volume } | Self::Scaled { volume } => Some(volume),
        }
    }
}

impl<S: Space> Filling<S> {
    /// Volume (area in the plane) of the cell of particle `k` \[m³\], that of the lattice with `spacing` \[m\].
    pub fn volume_of(&self, k: usize, spacing: f64) -> f64 {
        self.cells.volume().map_or_else(|| S::cell_volume(spacing), |volume| volume[k])
    }

    /// Volume (area in the plane) of all cells \[m³\].
    pub fn volume(&self, spacing: f64) -> f64 {
        (0..self.positions.len()).map(|k| self.volume_of(k, spacing)).sum()
    }

    /// Multiplies the volume of each cell by `factor`.
    pub fn scale(&mut self, factor: f64, spacing: f64) {
        match self.cells.volume_mut() {
            Some(volume) => volume.iter_mut().for_each(|volume| *volume *= factor),
            None => {
                let volume = vec![factor * S::cell_volume(spacing); self.positions.len()];
                self.cells = Cells::Scaled { volume };
            }
        }
    }
}

/// What is filled.
pub struct Filled<'a> {
    /// In words, such as ``region `column` ``.
    pub what: &'a str,
    /// Its shape.
    pub shape: &'a At<ShapeTable>,
    /// Particle spacing \[m\].
    pub spacing: f64,
    /// A lattice of its own.
    pub origin: Option<&'a At<Coordinates>>,
    /// As written.
    pub layout: Layout,
    /// What `auto` means.
    pub otherwise: Otherwise,
}

impl<S: SceneSpace> Lattice<'_, S> {
    /// Whether the particles of a shape stand in rows along its faces wherever it is laid out: on the lattice, or in a box.
    pub fn fits(&self, filled: &Filled<'_>) -> bool {
        let shape = S::shape(&filled.shape.value);
        let origin = filled.origin.map_or(self.origin, |at| at.value.to::<S>());
        S::box_corners(&shape).is_some()
            || S::is_on_lattice(&shape, &shape.boundary(), filled.spacing, origin, OpenSides::default())
    }

    /// Particles that fill a shape, and what was adjusted in words; none, with an error, when there are too many or none.
    pub fn lay(&mut self, filled: &Filled<'_>, adjusted: &mut Vec<String>) -> Filling<S> {
        let &Filled { what, shape: written, spacing, .. } = filled;
        let shape = S::shape(&written.value);
        if !self.permits(written, &shape, spacing, 0.0) {
            return Filling::default();
        }
        let origin = filled.origin.map_or(self.origin, |at| at.value.to::<S>());
        let faces = shape.boundary();
        if S::is_on_lattice(&shape, &faces, spacing, origin, OpenSides::default()) {
            let positions = self.fill(written, spacing, filled.origin);
            return Filling { positions, cells: Cells::Lattice };
        }
        let corners = S::box_corners(&shape);
        // A lattice of its own says where the rows of a box are to stand.
        let own_rows = filled.layout == Layout::Auto && filled.origin.is_some();
        match (corners, filled.layout, filled.otherwise) {
            (Some(corners), Layout::Auto | Layout::Fitted, _) if !own_rows => {
                self.fill_box(filled, corners, adjusted)
            }
            (None, Layout::Fitted, _) | (None, Layout::Auto, Otherwise::Fitted) => {
                let pieces = written.value.pieces() as f64;
                let steps = S::fitted_steps(&faces, faces.volume(), spacing, pieces);
                if !self.errors.spend(&written.place, steps) {
                    return Filling::default();
                }
                let packing = fill_fitted(&shape, spacing, origin);
                if !self.accept(filled, packing.position.len()) {
                    return Filling::default();
                }
                let cell = S::cell_volume(spacing);
                let relative = packing.volume.iter().map(|volume| volume / cell);
                let (least, most) = relative.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
                let unit = if S::DIMENSIONS == 2 { "Δx²" } else { "Δx³" };
                adjusted.push(format!(
                    "{what}: {} particles in layers along its faces, cells of {least:.2} to {most:.2} {unit}; mass and \
                     second moments are those of the shape",
                    packing.position.len()
                ));
                Filling { positions: packing.position, cells: Cells::Fitted { volume: packing.volume } }
            }
            _ => {
                let positions = self.fill(written, spacing, filled.origin);
                let count = positions.len();
                let volume = faces.volume() / count.max(1) as f64;
                let change = 100.0 * (volume / S::cell_volume(spacing) - 1.0);
                if change.abs() < EXACT {
                    return Filling { positions, cells: Cells::Lattice };
                }
                if count > 0 {
                    adjusted.push(format!(
                        "{what}: masses of its {count} particles scaled by {change:+.2} %, so that their sum is that of \
                         the shape"
                    ));
                }
                Filling { positions, cells: Cells::Scaled { volume: vec![volume; count] } }
            }
        }
    }

    /// Whole cells between the sides of a box that does not fit the lattice.
    fn fill_box(
        &mut self,
        filled: &Filled<'_>,
        (lower, upper): (S::Vector, S::Vector),
        adjusted: &mut Vec<String>,
    ) -> Filling<S> {
        let spacing = filled.spacing;
        let size = upper - lower;
        // Bounded by `permits`.
        let counts: Vec<usize> =
            (0..S::DIMENSIONS).map(|axis| (size[axis] / spacing).round() as usize).collect();
        let count = counts.iter().product();
        if !self.accept(filled, count) {
            return Filling::default();
        }
        let mut cell = size;
        (0..S::DIMENSIONS).for_each(|axis| cell[axis] = size[axis] / counts[axis] as f64);
        // Along x first, then along the other axes.
        let place = |k: usize| {
            let (mut x, mut left) = (lower, k);
            for axis in 0..S::DIMENSIONS {
                x[axis] = lower[axis] + ((left % counts[axis]) as f64 + 0.5) * cell[axis];
                left /= counts[axis];
            }
            x
        };
        let positions: Vec<S::Vector> = (0..count).map(place).collect();
        let changes: Vec<f64> = (0..S::DIMENSIONS).map(|axis| cell[axis] / spacing - 1.0).collect();
        adjusted.push(if changes.iter().all(|change| change.abs() < 1e-6) {
            format!(
                "{}: its particles stand between its own sides, off the lattice of the scene",
                filled.what
            )
        } else {
            let along: Vec<String> = AXIS_NAMES
                .iter()
                .take(S::DIMENSIONS)
                .enumerate()
                .map(|(axis, name)| format!("{:.6} m apart along {name}", cell[axis]))
                .collect();
            let by: Vec<String> = changes.iter().map(|change| format!("{:+.2} %", 100.0 * change)).collect();
            format!(
                "{}: particles {} ({}), so that they fill its sides",
                filled.what,
                in_words(&along),
                by.join(", ")
            )
        });
        let volume = (0..S::DIMENSIONS).map(|axis| cell[axis]).product();
        let across = counts.into_iter().min().unwrap_or_default();
        Filling { positions, cells: Cells::Box { volume: vec![volume; count], across } }
    }

    /// Counts `count` particles in; an error when there are too many or none.
    fn accept(&mut self, filled: &Filled<'_>, count: usize) -> bool {
        if count == 0 {
            let error = CaseError::new(&filled.shape.place, "holds no particle");
            let spacing = filled.spacing;
            self.errors.add(error.hint(format!("make it larger than the particle spacing of {spacing} m")));
        }
        count > 0 && self.take(filled.shape, count)
    }
}

/// `a and b`, or `a, b and c`.
fn in_words(parts: &[String]) -> String {
    match parts {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => parts.concat(),
    }
}

/// ``kind `name` ``.
pub fn named(kind: &str, name: &str) -> String {
    format!("{kind} `{}`", quoted(name))
}
