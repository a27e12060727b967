//! Coefficients of the fluid that no case sets.

use sph::constants::Constant;
use sph::space::Plane;

use crate::boundary::departures;
use crate::rates::volume_reading;
use crate::report::probes;
use crate::system::thresholds::Thresholds;
use crate::system::{list_limits, walls};
use crate::time::step_control;

/// Coefficients of the fluid that no case sets.
pub fn constants() -> impl Iterator<Item = &'static Constant> {
    const LISTS: &[&[Constant]] = &[
        Plane::LIST,
        volume_reading::CONSTANTS,
        walls::CONSTANTS,
        list_limits::CONSTANTS,
        departures::CONSTANTS,
        step_control::CONSTANTS,
        probes::CONSTANTS,
    ];
    LISTS.iter().copied().flatten()
}
