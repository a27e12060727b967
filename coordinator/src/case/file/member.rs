//! Which member of an ensemble a run is, as a case file writes it.

use serde::Serialize;

use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, Table};

/// `[run]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // As for all tables here: the keys name quantity and unit.
pub struct MemberTable {
    /// Decides the displacements.
    pub seed: u64,
    /// Largest displacement of each water particle along each axis as a fraction of the spacing.
    pub displacement_fraction: f64,
}

impl MemberTable {
    /// Default of `displacement_fraction`: far below what a step of refinement moves, far above round-off.
    pub const DEFAULT_DISPLACEMENT: f64 = 0.01;

    /// Reads `run`, which may be left out.
    pub fn read(parent: &mut Table<'_>) -> Option<Self> {
        // Beyond a tenth of the spacing it would be another start, not the same one disturbed.
        const DISPLACEMENT: Allowed =
            Allowed::new(0.0, 0.1, (false, true), "a number above 0 and at most 0.1");
        let mut table = parent.optional_table("run")?;
        // TOML integers have 63 bits.
        let seed = table.optional_count("seed", 0..1 << 62);
        if !table.has("seed") {
            let error = CaseError::new(table.place(), "has no `seed`");
            table.error(error.hint("add `seed = 1`, or leave the table out: then no particle is displaced"));
        }
        let displacement_fraction =
            table.number_or("displacement_fraction", &DISPLACEMENT, Self::DEFAULT_DISPLACEMENT).value;
        table.finish();
        Some(Self { seed: seed.unwrap_or_default(), displacement_fraction })
    }
}
