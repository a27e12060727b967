//! Coefficients that no case sets: named, and listed for the header of a run, `summary.json` and docs/constants.md.
//!
//! Sizes of tasks and skins of neighbour lists are not among them: they change results by round-off alone.

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

/// Declares coefficients of all spaces, and their list `CONSTANTS`.
#[macro_export]
macro_rules! constants {
    ($($(#[$reason:meta])* $visibility:vis const $name:ident: $type:ty = $value:expr, $key:literal, $meaning:literal;)+) => {
        $(
            #[doc = $meaning]
            ///
            $(#[$reason])*
            $visibility const $name: $type = $value;
        )+

        /// The coefficients above, for the header of a run.
        pub(crate) const CONSTANTS: &[$crate::constants::Constant] =
            &[$($crate::constants::Constant { name: $key, value: $name as f64, meaning: $meaning }),+];
    };
}

/// Declares the thresholds of a solver as constants of a trait, their values in the plane and, where they differ, in space,
/// and their list.
///
/// ```text
/// /// Reason of the value.
/// NAME = 0.1, "key", "meaning [unit]";
/// /// Reason of both values.
/// OTHER = 0.3, in space 0.2, "key", "meaning [unit]";
/// ```
#[macro_export]
macro_rules! thresholds {
    (@spatial $plane:literal) => { $plane };
    (@spatial $plane:literal $spatial:literal) => { $spatial };
    ($($(#[$reason:meta])+ $name:ident = $plane:literal, $(in space $spatial:literal,)? $key:literal, $meaning:literal;)+) => {
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

        impl Thresholds for $crate::space::Spatial {
            $(const $name: f64 = $crate::thresholds!(@spatial $plane $($spatial)?);)+
        }
    };
}
