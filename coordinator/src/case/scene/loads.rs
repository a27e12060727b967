//! Faces of a body's surface that loads act on.

use std::collections::HashSet;

use sph::setup::SurfaceLoad;
use sph::space::Vector;

use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::body::BodyTable;
use crate::case::file::support::LoadTable;
use crate::quote::quoted;

/// Outward directions of a cell's faces.
const SIDES: [(i64, i64); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// The loads of `body`, whose particles of `spacing` \[m\] are at `positions` \[m\].
///
/// A face of a particle's cell is on the surface where no particle of the body stands beyond it; a load takes those whose
/// middle lies in its shape.
pub fn faces(body: &BodyTable, positions: &[Vector], spacing: f64, errors: &ErrorList) -> Vec<SurfaceLoad> {
    if body.loads.is_empty() || positions.is_empty() {
        return Vec::new();
    }
    let origin = positions[0];
    // Whole numbers of cells between particles of one lattice.
    let cell = |x: &Vector| {
        let steps = (x - origin) / spacing;
        (steps.x.round() as i64, steps.y.round() as i64)
    };
    let taken: HashSet<(i64, i64)> = positions.iter().map(cell).collect();
    let exposed: Vec<(usize, Vector)> = positions
        .iter()
        .enumerate()
        .flat_map(|(i, x)| {
            let (column, row) = cell(x);
            let taken = &taken;
            let open = move |side: &(i64, i64)| !taken.contains(&(column + side.0, row + side.1));
            SIDES.into_iter().filter(open).map(move |side| (i, Vector::new(side.0 as f64, side.1 as f64)))
        })
        .collect();
    body.loads.iter().filter_map(|load| of_load(load, &exposed, positions, spacing, errors)).collect()
}

fn of_load(
    load: &LoadTable,
    exposed: &[(usize, Vector)],
    positions: &[Vector],
    spacing: f64,
    errors: &ErrorList,
) -> Option<SurfaceLoad> {
    let (written, law) = (load.shape.as_ref()?, load.to_law()?);
    let shape = written.value.to_shape();
    if !errors.spend(&written.place, exposed.len() as f64 * (2 + written.value.pieces()) as f64) {
        return None;
    }
    let inside = |(i, normal): &&(usize, Vector)| shape.contains(&(positions[*i] + normal * (0.5 * spacing)));
    let taken: Vec<_> = exposed.iter().filter(inside).collect();
    if taken.is_empty() {
        let problem = format!("load `{}` meets no face of the body's surface", quoted(&load.name.value));
        errors.add(
            CaseError::new(&written.place, problem)
                .hint("its shape must contain middles of outer faces of the particles' cells"),
        );
    }
    Some(SurfaceLoad {
        name: load.name.value.clone(),
        law,
        particles: taken.iter().map(|(i, _)| super::index(*i)).collect(),
        areas: taken.iter().map(|(_, normal)| normal * spacing).collect(),
    })
}
