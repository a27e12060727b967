//! Surfaces of triangles from STL files as a case file names them.

use std::sync::Arc;

use serde::Serialize;
use sph::shapes::Surface;
use sph::shapes::surface::Stl;

use crate::case::errors::CaseError;
use crate::case::files::{LARGEST_SURFACE, read_bytes, resolved};
use crate::case::reader::{Choice, Table};
use crate::quote;

/// Steps of work to read, index and examine a facet, each about a nanosecond.
const FACET_STEPS: f64 = 10_000.0;

/// Bytes of a facet in a binary file, the shorter form.
const FACET_BYTES: u64 = 50;

/// Units of length of a file \[m\].
pub(super) const UNITS: [(&str, f64); 6] =
    [("m", 1.0), ("dm", 0.1), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)];

/// What to do with a surface that is not sound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defects {
    /// They are errors.
    Refuse,
    /// Facets are turned or left out where there is no doubt; what stays is an error.
    Repair,
    /// The same, and the inside is where the surface winds around at least half a time, whatever else is wrong.
    Accept,
}

/// A surface of triangles, the inside of which is the shape.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct SurfaceTable {
    pub file: String,
    pub unit: Choice<f64>,
    pub defects: Choice<Defects>,
    #[serde(skip)]
    pub surface: Arc<Surface>,
}

impl SurfaceTable {
    /// Reads the table and the file; `None` when either is wrong.
    pub(super) fn read(table: &mut Table<'_>) -> Option<Self> {
        let mut file = table.text("file");
        let unit = table.choice("unit", &UNITS);
        let defects = table.choice_or_default(
            "defects",
            &[("refuse", Defects::Refuse), ("repair", Defects::Repair), ("accept", Defects::Accept)],
        );
        let (unit, true) = (unit?, table.intact()) else { return None };
        let path = resolved(table.directory, &file.value);
        // A case written out elsewhere must still find it.
        if let Some(full) = std::path::absolute(&path).ok().and_then(|path| path.to_str().map(str::to_owned))
        {
            file.value = full;
        }
        let bytes = std::fs::metadata(&path).map_or(0, |facts| facts.len().min(LARGEST_SURFACE));
        if !table.errors().spend(&file.place, FACET_STEPS * (bytes / FACET_BYTES) as f64) {
            return None;
        }
        let refuse = |problem: String, hint: &str| {
            table.error(CaseError::new(&file.place, problem).value(&file.value).hint(hint));
        };
        let read = read_bytes(&path, LARGEST_SURFACE).and_then(|bytes| {
            Stl::read(&bytes, unit.value).map_err(|problem| format!("{}: {problem}", quote::path(&path)))
        });
        let mut surface = match read {
            Ok(stl) => stl.surface,
            Err(problem) => {
                refuse(problem, "give an STL file; its path is taken from the case file's folder");
                return None;
            }
        };
        if defects.value != Defects::Refuse {
            surface = surface.repaired().0;
        }
        if defects.value != Defects::Accept {
            let problems = surface.report().problems();
            for problem in &problems {
                refuse(
                    format!("is no sound surface: {problem}"),
                    "mend the surface, or set `defects = \"repair\"` or `defects = \"accept\"`",
                );
            }
            if !problems.is_empty() {
                return None;
            }
        }
        Some(Self { file: file.value, unit, defects, surface: Arc::new(surface) })
    }

    /// Number of primitives that the work for each particle grows with: facets are found by a tree.
    pub(super) fn pieces(&self) -> usize {
        8 * self.surface.facets().max(2).ilog2() as usize
    }
}
