//! Layers of a box: rows along its edges.

use nalgebra::Vector3;

use crate::shapes::SpatialShape;
use crate::shapes::spatial::Frame;
use crate::tasks;

crate::constants! {
    /// A box of ten spacings or more always fits. The particles of a wall all have one volume.
    const LARGEST_STRETCH: f64 = 0.05, "box_rows.largest_stretch",
        "largest deviation of the distance of rows in the layers of a box from the spacing, in spacings [-]";
}

/// Rows of points along the edges of a box, evenly between its faces, and in layers before or behind them.
pub(super) struct BoxRows {
    /// Coordinates along each axis of the box \[m\], upward.
    rows: [Vec<f64>; 3],
    /// Of a box that is turned or moved.
    frame: Frame,
}

impl BoxRows {
    /// The points for which `keep` holds: upward along z, within a plane along y, within a row along x.
    pub(super) fn points(&self, keep: impl Fn(&Vector3<f64>) -> bool + Sync) -> Vec<Vector3<f64>> {
        let [along_x, along_y, along_z] = &self.rows;
        let plane = |z: &f64| {
            let points = along_y.iter().flat_map(|y| along_x.iter().map(move |x| Vector3::new(*x, *y, *z)));
            points.map(|x| self.frame.point(&x)).filter(&keep).collect::<Vec<_>>()
        };
        tasks::flat_map(along_z.len(), 1, |k| plane(&along_z[k]))
    }
}

/// Rows of `shape` about `spacing` \[m\] apart, and of as many layers `outside`; `None` of what is no box, or one that its rows
/// do not fit.
pub(super) fn rows_of(shape: &SpatialShape, spacing: f64, outside: u32) -> Option<BoxRows> {
    match shape {
        SpatialShape::Box { lower, upper } => {
            let [x, y, z] = [0, 1, 2].map(|axis| rows_between(lower[axis], upper[axis], spacing, outside));
            Some(BoxRows { rows: [x?, y?, z?], frame: Frame::default() })
        }
        SpatialShape::Placed { shape, frame } if matches!(**shape, SpatialShape::Box { .. }) => {
            rows_of(shape, spacing, outside).map(|rows| BoxRows { frame: *frame, ..rows })
        }
        _ => None,
    }
}

/// Coordinates \[m\] of rows between two faces and, of layers `outside`, behind them.
fn rows_between(lower: f64, upper: f64, spacing: f64, outside: u32) -> Option<Vec<f64>> {
    let count = ((upper - lower) / spacing).round();
    let distance = (upper - lower) / count;
    if (distance / spacing - 1.0).abs() > LARGEST_STRETCH || count < 1.0 {
        return None;
    }
    // Whole and small: what is too large was refused before.
    let between = (0..count as u32).map(|k| lower + (f64::from(k) + 0.5) * distance);
    let depth = |k: u32| (f64::from(k) + 0.5) * spacing;
    let below = (0..outside).rev().map(|k| lower - depth(k));
    let above = (0..outside).map(|k| upper + depth(k));
    Some(below.chain(between).chain(above).collect())
}
