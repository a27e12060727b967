//! The cases, one file each.

use super::Case;

mod drifting_body;
mod drop;
mod square_patch;
mod taylor_green;

/// All cases, in the order in which they are run.
pub fn all() -> Vec<&'static dyn Case> {
    vec![&drop::Drop, &square_patch::SquarePatch, &taylor_green::TaylorGreen, &drifting_body::DriftingBody]
}
