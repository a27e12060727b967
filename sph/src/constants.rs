//! Coefficients that no case sets: named, and listed for the header of a run and for `summary.json`.

use crate::coupling::driver::checks::LARGEST_STEP_OVER_LIMIT;
use crate::coupling::fixed_point::FACTORS;
use crate::interface::fluid_regions::LARGEST_ROW;
use crate::laws::equation_of_state::{LARGEST_CAVITY, LARGEST_COMPRESSION};
use crate::laws::repulsion;
use crate::setup::{LEAPFROG_FRACTION, MIDPOINT_FRACTIONS};

/// A coefficient that no case sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    /// Name, dotted from law to coefficient.
    pub name: &'static str,
    /// Value in the unit that `meaning` ends with.
    pub value: f64,
    /// What it does, and its unit.
    pub meaning: &'static str,
}

/// Declares the thresholds of a solver as constants of a trait, their values in the plane, and their list.
#[macro_export]
macro_rules! thresholds {
    ($($(#[$reason:meta])+ $name:ident = $plane:literal, $key:literal, $meaning:literal;)+) => {
        /// Thresholds measured in each space.
        pub trait Thresholds: $crate::space::Space {
            $($(#[$reason])+ const $name: f64;)+

            /// All of them, for the header of a run.
            const LIST: &'static [$crate::constants::Constant] = &[$(
                $crate::constants::Constant { name: $key, value: Self::$name, meaning: $meaning }
            ),+];
        }

        impl Thresholds for $crate::space::Plane {
            $(const $name: f64 = $plane;)+
        }

        /// The thresholds of the plane.
        pub fn constants() -> &'static [$crate::constants::Constant] {
            <$crate::space::Plane as Thresholds>::LIST
        }
    };
}

/// The coefficients of laws that both solvers evaluate, and of the coupling.
pub fn constants() -> &'static [Constant] {
    const fn constant(name: &'static str, value: f64, meaning: &'static str) -> Constant {
        Constant { name, value, meaning }
    }
    const LIST: &[Constant] = &[
        constant(
            "density.largest_compression",
            LARGEST_COMPRESSION,
            "largest relative change of density of a fluid that is valid, and of wall and interface particles in tension [-]",
        ),
        constant(
            "density.largest_cavity",
            LARGEST_CAVITY,
            "largest share of cavities in the volume of a fluid with `tension_limit_pa` [-]",
        ),
        constant(
            "repulsion.distance",
            repulsion::DISTANCE,
            "distance at which close pairs repel, in spacings [-]",
        ),
        constant("repulsion.damping", repulsion::DAMPING, "share of critical damping of that repulsion [-]"),
        constant(
            "time_step.leapfrog",
            LEAPFROG_FRACTION,
            "fraction of h/(c0 + v) that leapfrog takes without the acoustic damper [-]",
        ),
        constant(
            "time_step.midpoint_damped",
            MIDPOINT_FRACTIONS.0,
            "fraction of h/(c0 + v) that the midpoint rule takes where sound is damped [-]",
        ),
        constant("time_step.midpoint", MIDPOINT_FRACTIONS.1, "the same where sound is nearly undamped [-]"),
        constant(
            "time_step.largest_over_limit",
            LARGEST_STEP_OVER_LIMIT,
            "fixed step over the reported limit that ends a run [-]",
        ),
        constant(
            "interface.largest_row",
            LARGEST_ROW as f64,
            "fluid particles around one of a solid above which they count as one region [-]",
        ),
        constant("implicit.smallest_factor", FACTORS.0, "smallest factor of Aitken relaxation [-]"),
        constant("implicit.largest_factor", FACTORS.1, "largest factor of Aitken relaxation [-]"),
    ];
    LIST
}
