//! Which member of an ensemble a run is, as a case file writes it.

use serde::Serialize;

use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, Table};
use crate::case::spec::{Kind, TableSpec, key};

/// Largest seed: integers of TOML have 63 bits.
pub const LARGEST_SEED: u64 = (1 << 62) - 1;

// Beyond a tenth of the spacing it would be another start, not the same one disturbed.
const DISPLACEMENT: Allowed = Allowed::new(0.0, 0.1, (false, true), "a number above 0 and at most 0.1");

/// Rows of `[run]`.
pub static RUN: TableSpec = TableSpec::new(
    "run",
    "A member of an ensemble: the same case, disturbed. Without the table no particle is displaced.",
    &[
        key(
            "seed",
            Kind::Count(0, LARGEST_SEED),
            "decides the displacements: the same ones on any number of threads and any machine",
        ),
        key(
            "displacement_fraction",
            Kind::Number(DISPLACEMENT),
            "displacement of every water particle along each axis, at most this fraction of Δx; masses and densities stay",
        )
        .or(MemberTable::DEFAULT_DISPLACEMENT),
    ],
);

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
        let mut table = parent.optional_table("run")?;
        let seed = table.optional_count("seed");
        if !table.has("seed") {
            let error = CaseError::new(table.place(), "has no `seed`");
            table.error(error.hint("add `seed = 1`, or leave the table out: then no particle is displaced"));
        }
        let displacement_fraction = table.number("displacement_fraction").value;
        table.finish();
        Some(Self { seed: seed.unwrap_or_default(), displacement_fraction })
    }
}
