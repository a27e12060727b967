//! Faces of a body's surface that loads act on.

use std::collections::{BTreeMap, HashSet};

use sph::neighbours::CellGrid;
use sph::setup::SurfaceLoad;
use sph::shapes::Region;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use super::space::SceneSpace;
use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::body::BodyTable;
use crate::case::file::shape::ShapeTable;
use crate::case::file::support::LoadTable;
use crate::case::reader::At;
use crate::quote::quoted;

/// The loads of `body`, whose particles of `spacing` \[m\] are at `positions` \[m\].
///
/// A face of a particle's cell is on the surface where no particle of the body stands beyond it; a load takes those whose
/// middle lies in its shape.
pub fn faces<S: SceneSpace>(
    body: &BodyTable,
    positions: &[S::Vector],
    spacing: f64,
    errors: &ErrorList,
) -> Vec<SurfaceLoad<S>> {
    if body.loads.is_empty() || positions.is_empty() {
        return Vec::new();
    }
    let origin = positions[0];
    // Whole numbers of cells between particles of one lattice; in the plane the third is 0.
    let cell = |x: &S::Vector| {
        let steps = (*x - origin) / spacing;
        let mut cell = [0_i64; 3];
        for (axis, k) in cell.iter_mut().enumerate().take(S::DIMENSIONS) {
            *k = steps[axis].round() as i64;
        }
        cell
    };
    let taken: HashSet<[i64; 3]> = positions.iter().map(cell).collect();
    // Outward along an axis, then against it.
    let sides: Vec<(usize, i64)> = (0..S::DIMENSIONS).flat_map(|axis| [(axis, 1), (axis, -1)]).collect();
    let mut exposed: Vec<(usize, S::Vector)> = Vec::new();
    for (i, x) in positions.iter().enumerate() {
        let own = cell(x);
        for (axis, step) in &sides {
            let mut beyond = own;
            beyond[*axis] += step;
            if !taken.contains(&beyond) {
                let mut normal = S::Vector::zeros();
                normal[*axis] = *step as f64;
                exposed.push((i, normal));
            }
        }
    }
    body.loads.iter().filter_map(|load| of_load::<S>(load, &exposed, positions, spacing, errors)).collect()
}

/// The loads of `body` of `shape`, whose particles, of `spacing` \[m\], do not stand on the lattice.
///
/// Each small piece of the faces whose middle lies in the shape of a load belongs to the nearest particle.
pub fn faces_of<S: SceneSpace>(
    body: &BodyTable,
    shape: &S::Shape,
    positions: &[S::Vector],
    spacing: f64,
    errors: &ErrorList,
) -> Vec<SurfaceLoad<S>> {
    if body.loads.is_empty() || positions.is_empty() {
        return Vec::new();
    }
    let pieces = S::pieces(&shape.boundary(), spacing);
    let open =
        Domain::<S> { lower: S::Vector::zeros(), upper: S::Vector::zeros(), periodic: S::splat(false) };
    let grid = CellGrid::new(&open, positions, 1.5 * spacing);
    let nearest = |x: &S::Vector| {
        let near = grid
            .ranges(grid.cell(x))
            .iter()
            .cloned()
            .flat_map(|range| &grid.order()[range])
            .copied()
            .collect::<Vec<u32>>();
        let distance = |j: &u32| (positions[*j as usize] - *x).norm_squared();
        near.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    body.loads
        .iter()
        .filter_map(|load| {
            let (written, law) = (load.shape.as_ref()?, load.to_law::<S>()?);
            let region = S::shape(&written.value);
            if !errors.spend(&written.place, pieces.len() as f64 * (10 + written.value.pieces()) as f64) {
                return None;
            }
            let mut areas: BTreeMap<u32, S::Vector> = BTreeMap::new();
            for (middle, area) in pieces.iter().filter(|(middle, _)| region.contains(middle)) {
                if let Some(particle) = nearest(middle) {
                    *areas.entry(particle).or_insert_with(S::Vector::zeros) += *area;
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

fn of_load<S: SceneSpace>(
    load: &LoadTable,
    exposed: &[(usize, S::Vector)],
    positions: &[S::Vector],
    spacing: f64,
    errors: &ErrorList,
) -> Option<SurfaceLoad<S>> {
    let (written, law) = (load.shape.as_ref()?, load.to_law::<S>()?);
    let shape = S::shape(&written.value);
    if !errors.spend(&written.place, exposed.len() as f64 * (2 + written.value.pieces()) as f64) {
        return None;
    }
    let inside =
        |(i, normal): &&(usize, S::Vector)| shape.contains(&(positions[*i] + *normal * (0.5 * spacing)));
    let taken: Vec<_> = exposed.iter().filter(inside).collect();
    if taken.is_empty() {
        report_unmet(load, written, errors);
    }
    let area = (1..S::DIMENSIONS).map(|_| spacing).product::<f64>();
    Some(SurfaceLoad {
        name: load.name.value.clone(),
        law,
        particles: taken.iter().map(|(i, _)| super::index(*i)).collect(),
        areas: taken.iter().map(|(_, normal)| *normal * area).collect(),
    })
}
