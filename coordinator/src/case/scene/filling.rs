//! How shapes are filled: on the lattice, in whole cells between the sides of a box, or in layers along the faces.

use sph::shapes::{FITTED_STEPS, Shape, fill_fitted, is_on_lattice};
use sph::space::Vector;

use super::lattice::Lattice;
use crate::case::errors::CaseError;
use crate::case::file::layout::Layout;
use crate::case::file::shape::ShapeTable;
use crate::case::reader::At;
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
pub struct Filling {
    /// Where they are \[m\].
    pub positions: Vec<Vector>,
    /// Their cells.
    pub cells: Cells,
}

/// Cells of the particles that fill a shape.
#[derive(Debug, Default)]
pub enum Cells {
    /// Squares of the lattice that fill the shape exactly.
    #[default]
    Lattice,
    /// Rectangles in rows and columns between the sides of a box.
    Box {
        /// Area of each \[m²\].
        volume: Vec<f64>,
        /// Fewest along a side.
        across: usize,
    },
    /// Cells along the faces.
    Fitted {
        /// Area of each \[m²\].
        volume: Vec<f64>,
    },
    /// Squares of the lattice, scaled so that they have the area of the shape.
    Scaled {
        /// Area of each \[m²\].
        volume: Vec<f64>,
    },
}

impl Cells {
    /// Area of each cell per particle \[m²\]; `None` for those of the lattice.
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

/// What is filled.
pub struct Filled<'a> {
    /// In words, such as ``region `column` ``.
    pub what: &'a str,
    /// Its shape.
    pub shape: &'a At<ShapeTable>,
    /// Particle spacing \[m\].
    pub spacing: f64,
    /// A lattice of its own.
    pub origin: Option<&'a At<Vector>>,
    /// As written.
    pub layout: Layout,
    /// What `auto` means.
    pub otherwise: Otherwise,
}

impl Lattice<'_> {
    /// Particles that fill a shape, and what was adjusted in words; none, with an error, when there are too many or none.
    pub fn lay(&mut self, filled: &Filled<'_>, adjusted: &mut Vec<String>) -> Filling {
        let &Filled { what, shape: written, spacing, .. } = filled;
        let shape = written.value.to_shape();
        if !self.permits(written, &shape, spacing, 0.0) {
            return Filling::default();
        }
        let origin = filled.origin.map_or(self.origin, |at| at.value);
        let pieces = written.value.pieces() as f64;
        let edges = shape.boundary();
        if is_on_lattice(&edges, spacing, origin, |_, _| false) {
            let positions = self.fill(written, spacing, filled.origin);
            return Filling { positions, cells: Cells::Lattice };
        }
        // A lattice of its own says where the rows of a box are to stand.
        let own_rows = filled.layout == Layout::Auto && filled.origin.is_some();
        match (&shape, filled.layout, filled.otherwise) {
            (Shape::Rectangle { lower, upper }, Layout::Auto | Layout::Fitted, _) if !own_rows => {
                self.fill_box(filled, *lower, *upper, adjusted)
            }
            (_, Layout::Fitted, _) | (_, Layout::Auto, Otherwise::Fitted)
                if !matches!(shape, Shape::Rectangle { .. }) =>
            {
                let steps = FITTED_STEPS + 100.0 * pieces;
                let area = edges.moments().volume / (spacing * spacing);
                if !self.errors.spend(&written.place, area.min(edges.length() / spacing * 12.0) * steps) {
                    return Filling::default();
                }
                let packing = fill_fitted(&shape, spacing, origin);
                if !self.accept(filled, packing.position.len()) {
                    return Filling::default();
                }
                let cell = spacing * spacing;
                let relative = packing.volume.iter().map(|volume| volume / cell);
                let (least, most) = relative.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
                adjusted.push(format!(
                    "{what}: {} particles in layers along its faces, cells of {least:.2} to {most:.2} Δx²; mass and \
                     second moments are those of the shape",
                    packing.position.len()
                ));
                Filling { positions: packing.position, cells: Cells::Fitted { volume: packing.volume } }
            }
            _ => {
                let positions = self.fill(written, spacing, filled.origin);
                let count = positions.len();
                let volume = edges.moments().volume / count.max(1) as f64;
                let change = 100.0 * (volume / (spacing * spacing) - 1.0);
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
        lower: Vector,
        upper: Vector,
        adjusted: &mut Vec<String>,
    ) -> Filling {
        let spacing = filled.spacing;
        let size = upper - lower;
        let counts = size.map(|length| (length / spacing).round());
        // Bounded by `permits`.
        let [columns, rows] = [counts.x as usize, counts.y as usize];
        if !self.accept(filled, columns * rows) {
            return Filling::default();
        }
        let cell = size.component_div(&counts);
        let place = |column: usize, row: usize| {
            lower + Vector::new((column as f64 + 0.5) * cell.x, (row as f64 + 0.5) * cell.y)
        };
        let positions: Vec<Vector> =
            (0..rows).flat_map(|row| (0..columns).map(move |column| place(column, row))).collect();
        let change = cell / spacing - Vector::repeat(1.0);
        adjusted.push(if change.amax() < 1e-6 {
            format!("{}: its particles stand between its own sides, off the lattice of the scene", filled.what)
        } else {
            format!(
                "{}: particles {:.6} m apart along x and {:.6} m along y ({:+.2} %, {:+.2} %), so that they fill its sides",
                filled.what,
                cell.x,
                cell.y,
                100.0 * change.x,
                100.0 * change.y
            )
        });
        let volume = vec![cell.x * cell.y; positions.len()];
        Filling { positions, cells: Cells::Box { volume, across: columns.min(rows) } }
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

/// ``kind `name` ``.
pub fn named(kind: &str, name: &str) -> String {
    format!("{kind} `{}`", quoted(name))
}
