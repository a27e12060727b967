//! Fixed coefficients of laws, for the header of a run.

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
