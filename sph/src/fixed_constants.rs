//! The list of coefficients in this crate that no case sets.

use crate::constants::Constant;
use crate::coupling::driver::checks;
use crate::coupling::{audit, fixed_point};
use crate::interface::{fluid_regions, pair_law, velocity_gradients};
use crate::laws::{acoustic_relaxation, equation_of_state, repulsion};
use crate::shapes::spatial::faces::{box_rows, layers};
use crate::shapes::surface::{defects, tree, weld};
use crate::shapes::{boundary, fitted, packing, thresholds};
use crate::space::Plane;
use crate::{kernel, setup};

/// Coefficients of laws that both solvers evaluate, and of the coupling.
pub fn fixed_constants() -> impl Iterator<Item = &'static Constant> {
    const LISTS: &[&[Constant]] = &[
        kernel::CONSTANTS,
        equation_of_state::CONSTANTS,
        repulsion::CONSTANTS,
        acoustic_relaxation::CONSTANTS,
        setup::CONSTANTS,
        fluid_regions::CONSTANTS,
        pair_law::CONSTANTS,
        velocity_gradients::CONSTANTS,
        fixed_point::CONSTANTS,
        checks::CONSTANTS,
        audit::CONSTANTS,
        boundary::CONSTANTS,
        fitted::CONSTANTS,
        <Plane as thresholds::Thresholds>::LIST,
        packing::CONSTANTS,
        layers::CONSTANTS,
        box_rows::CONSTANTS,
        weld::CONSTANTS,
        tree::CONSTANTS,
        defects::CONSTANTS,
    ];
    LISTS.iter().copied().flatten()
}
