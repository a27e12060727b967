//! Faces of a body's surface that loads act on.

use std::collections::{BTreeMap, HashSet};

use sph::neighbours::CellGrid;
use sph::setup::SurfaceLoad;
use sph::shapes::Shape;
use sph::space::Vector;
use sph::space::domain::Domain;

use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::body::BodyTable;
use crate::case::file::shape::ShapeTable;
use crate::case::file::support::LoadTable;
use crate::case::reader::At;
use crate::quote::quoted;

/// Length of the pieces of a face that does not run along the lattice, in spacings.
const PIECE: f64 = 0.1;

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

/// The loads of `body` of `shape`, whose particles, of `spacing` \[m\], do not stand on the lattice.
///
/// Each short piece of the faces whose middle lies in the shape of a load belongs to the nearest particle.
pub fn faces_of(
    body: &BodyTable,
    shape: &Shape,
    positions: &[Vector],
    spacing: f64,
    errors: &ErrorList,
) -> Vec<SurfaceLoad> {
    if body.loads.is_empty() || positions.is_empty() {
        return Vec::new();
    }
    let pieces = shape.boundary().pieces(PIECE * spacing);
    let open: Domain = Domain { lower: Vector::zeros(), upper: Vector::zeros(), periodic: [false; 2] };
    let grid = CellGrid::new(&open, positions, 1.5 * spacing);
    let nearest = |x: &Vector| {
        let near = grid
            .ranges(grid.cell(x))
            .iter()
            .cloned()
            .flat_map(|range| &grid.order()[range])
            .copied()
            .collect::<Vec<u32>>();
        let distance = |j: &u32| (positions[*j as usize] - x).norm_squared();
        near.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    body.loads
        .iter()
        .filter_map(|load| {
            let (written, law) = (load.shape.as_ref()?, load.to_law()?);
            let region = written.value.to_shape();
            if !errors.spend(&written.place, pieces.len() as f64 * (10 + written.value.pieces()) as f64) {
                return None;
            }
            let mut areas: BTreeMap<u32, Vector> = BTreeMap::new();
            for (middle, area) in pieces.iter().filter(|(middle, _)| region.contains(middle)) {
                if let Some(particle) = nearest(middle) {
                    *areas.entry(particle).or_insert_with(Vector::zeros) += area;
                }
            }
            if areas.is_empty() {
                report_unmet(load, written, errors);
            }
            Some(SurfaceLoad {
                name: load.name.value.clone(),
                law,
                particles: areas.keys().copied().collect(),
                areas: areas.into_values().collect(),
            })
        })
        .collect()
}

/// A load that acts on nothing is an error.
fn report_unmet(load: &LoadTable, written: &At<ShapeTable>, errors: &ErrorList) {
    let problem = format!("load `{}` meets no face of the body's surface", quoted(&load.name.value));
    errors.add(
        CaseError::new(&written.place, problem)
            .hint("its shape must contain middles of outer faces of the particles' cells"),
    );
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
        report_unmet(load, written, errors);
    }
    Some(SurfaceLoad {
        name: load.name.value.clone(),
        law,
        particles: taken.iter().map(|(i, _)| super::index(*i)).collect(),
        areas: taken.iter().map(|(_, normal)| normal * spacing).collect(),
    })
}
