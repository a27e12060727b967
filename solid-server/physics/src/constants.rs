//! Coefficients of solids that no case sets.

use sph::constants::Constant;
use sph::space::Plane;

use crate::boundary::supports;
use crate::contact::{density_field, film, start};
use crate::formulations::{bond_forces, formulation, reference_forces};
use crate::neighbours::material_point;
use crate::report::probes;
use crate::space;
use crate::thresholds::Thresholds;
use crate::time::limits;

/// Coefficients of solids that no case sets.
pub fn constants() -> impl Iterator<Item = &'static Constant> {
    const LISTS: &[&[Constant]] = &[
        Plane::LIST,
        space::CONSTANTS,
        supports::CONSTANTS,
        formulation::CONSTANTS,
        bond_forces::CONSTANTS,
        reference_forces::CONSTANTS,
        density_field::CONSTANTS,
        film::CONSTANTS,
        start::CONSTANTS,
        limits::CONSTANTS,
        material_point::CONSTANTS,
        probes::CONSTANTS,
    ];
    LISTS.iter().copied().flatten()
}
