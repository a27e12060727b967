//! Particles across the thin side of a body, and what few of them cost.

use sph::shapes::local_thickness;

use super::filling::Cells;
use super::space::SceneSpace;
use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::body::BodyTable;
use crate::case::file::material::FormulationTable;

/// Bodies with fewer particles across bend far too easily.
const ENOUGH_ACROSS: usize = 6;

/// Bodies with fewer particles across have no bending stiffness at all.
const LEAST_ACROSS: usize = 2;

/// Error of the bending compliance from which a body deserves a warning.
const NOTABLE_ERROR: f64 = 0.05;

/// Bodies with more particles across hardly notice that their faces are staircases.
const ENOUGH_FOR_STAIRS: usize = 16;

/// A body as it is laid out.
pub struct Laid<'a, S: SceneSpace> {
    /// Its shape.
    pub shape: &'a S::Shape,
    /// Its particles \[m\].
    pub positions: &'a [S::Vector],
    /// Their cells.
    pub cells: &'a Cells,
    /// Particle spacing \[m\].
    pub spacing: f64,
}

/// Warns of bodies that are too thin to bend as they should, refuses those without thickness.
///
/// Returns the particles across the thin side of a body that deforms.
pub fn check_thickness<S: SceneSpace>(
    body: &BodyTable,
    laid: &Laid<'_, S>,
    errors: &ErrorList,
    warnings: &mut Vec<String>,
) -> Option<usize> {
    if laid.positions.is_empty() || matches!(body.formulation, FormulationTable::Rigid) {
        return None;
    }
    let across = match laid.cells {
        Cells::Lattice | Cells::Scaled { .. } => particles_across::<S>(laid.positions, laid.spacing),
        Cells::Box { across, .. } => *across,
        Cells::Fitted { .. } => layers_across(laid),
    };
    let stairs = matches!(laid.cells, Cells::Scaled { .. }) && S::box_corners(laid.shape).is_none();
    let name = &body.name;
    if across < LEAST_ACROSS {
        let error = CaseError::new(&name.place, format!("is {across} particle across its thin side"));
        errors.add(
            error
                .value(&name.value)
                .allowed(format!("at least {LEAST_ACROSS}"))
                .hint("use a smaller `solid.particle_spacing_m` or a thicker shape"),
        );
    } else if across < ENOUGH_ACROSS || (stairs && across < ENOUGH_FOR_STAIRS) {
        let compliance = bending_compliance(body, laid.cells, stairs, across);
        let why = if stairs { "its faces are staircases" } else { "too few to resolve its bending" };
        if (compliance - 1.0).abs() > NOTABLE_ERROR {
            warnings.push(format!(
                "body `{}` is about {across} particles across its thin side: {why}; it bends about {compliance:.2} times as \
                 easily as it should",
                name.value
            ));
        }
    }
    Some(across)
}

/// Bending compliance of a body of few particles across over that of its material \[-\], measured at ν = 0.4.
fn bending_compliance(body: &BodyTable, cells: &Cells, stairs: bool, across: usize) -> f64 {
    match (&body.formulation, cells) {
        // The ring of the case `thin_ring` on the lattice: 1.58 at 4 across, 1.19 at 8.
        (FormulationTable::TotalLagrangian(_), _) if stairs => 1.0 + 5.3 / (across as f64).powf(1.6),
        // Static cantilevers in a linear model of the sums: 0.70 at 2 across, 1.02, 1.01 and 1.015 at 3, 4 and 5.
        (FormulationTable::TotalLagrangian(_), _) if across == 2 => 0.7,
        // The same ring in layers: 0.68 at 2 across, 1.07, 1.03 and 1.03 at 3, 4 and 5.
        (FormulationTable::TotalLagrangian(_), Cells::Fitted { .. }) if across == 3 => 1.07,
        (FormulationTable::TotalLagrangian(_), Cells::Fitted { .. }) => 1.03,
        (FormulationTable::TotalLagrangian(_), _) => 1.02,
        // Cantilever of Gray et al. (2001): periods 29 % too long at 6 across, 19 % at 10.
        _ => (1.0 + 1.8 / across as f64).powi(2),
    }
}

/// Layers across the thin side of a body whose particles follow its faces: median over the particles.
fn layers_across<S: SceneSpace>(laid: &Laid<'_, S>) -> usize {
    let spacing = laid.spacing;
    let limit = (ENOUGH_FOR_STAIRS + 1) as f64 * spacing;
    let mut thickness = local_thickness(laid.shape, laid.positions, spacing, limit);
    thickness.sort_by(f64::total_cmp);
    // Whole and small: bounded by the limit.
    (thickness[thickness.len() / 2] / spacing).round() as usize
}

/// Particles across the thin side: median over the particles of the shortest of the rows they stand in.
fn particles_across<S: SceneSpace>(positions: &[S::Vector], spacing: f64) -> usize {
    let mut shortest = row_lengths::<S>(positions, spacing, 0);
    for axis in 1..S::DIMENSIONS {
        for (a, b) in shortest.iter_mut().zip(row_lengths::<S>(positions, spacing, axis)) {
            *a = (*a).min(b);
        }
    }
    shortest.sort_unstable();
    shortest[shortest.len() / 2]
}

/// For every particle the number of particles in its unbroken row along `axis`.
fn row_lengths<S: SceneSpace>(positions: &[S::Vector], spacing: f64, axis: usize) -> Vec<usize> {
    // In the plane but one.
    let others = [(axis + 1) % S::DIMENSIONS, (axis + S::DIMENSIONS - 1) % S::DIMENSIONS];
    let mut order: Vec<usize> = (0..positions.len()).collect();
    let row = |k: usize| others.map(|other| (positions[k][other] / spacing).round());
    let by_row = |a: usize, b: usize| {
        let [a, b] = [row(a), row(b)];
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    };
    order.sort_by(|&a, &b| by_row(a, b).then(positions[a][axis].total_cmp(&positions[b][axis])));
    let mut lengths = vec![0; positions.len()];
    let unbroken = |a: &usize, b: &usize| {
        row(*a) == row(*b) && (positions[*b][axis] - positions[*a][axis]).abs() < 1.5 * spacing
    };
    for run in order.chunk_by(unbroken) {
        for &k in run {
            lengths[k] = run.len();
        }
    }
    lengths
}
