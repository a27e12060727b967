//! Loads on solids and their supports as a case file writes them.

use serde::Serialize;
use sph::setup::{LoadLaw, Support};

use super::formula;
use super::run::{AXES, MotionTable};
use super::shape::ShapeTable;
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, At, Choice, Table, Written};

/// `[[solid.body.load]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct LoadTable {
    pub name: At<String>,
    /// Outer faces whose middle lies inside this shape at the start are loaded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    /// Expressions of x, y and t.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_pa: Option<At<Written>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traction_pa: Option<[At<Written>; 2]>,
}

impl LoadTable {
    const VARIABLES: [&'static str; 3] = ["x", "y", "t"];

    pub(super) fn read(mut table: Table<'_>) -> Self {
        let name = table.name("name");
        let shape = ShapeTable::read(&mut table, "shape");
        let pressure_pa =
            table.has("pressure_pa").then(|| formula::read(&mut table, "pressure_pa", &Self::VARIABLES));
        let traction_pa = formula::read_pair(&mut table, "traction_pa", &Self::VARIABLES);
        if pressure_pa.is_some() == traction_pa.is_some() && table.intact() {
            let error = CaseError::new(table.place(), "does not say what acts");
            table.error(error.allowed("either `pressure_pa` or `traction_pa`"));
        }
        table.finish();
        Self { name, shape, pressure_pa, traction_pa }
    }

    /// Set-up of the solvers; `None` if the table is wrong.
    pub fn to_law(&self) -> Option<LoadLaw> {
        match (&self.pressure_pa, &self.traction_pa) {
            (Some(pressure), None) => Some(LoadLaw::Pressure(pressure.value.text())),
            (None, Some(traction)) => Some(LoadLaw::Traction(traction.each_ref().map(|w| w.value.text()))),
            _ => None,
        }
    }
}

/// `[[solid.body.support]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct SupportTable {
    pub name: At<String>,
    /// Particles inside this shape at the start are held.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    /// Components that are held: both for a clamp, one for a roller.
    pub held: Vec<Choice<usize>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_time_s: Option<f64>,
}

impl SupportTable {
    pub(super) fn read(mut table: Table<'_>) -> Self {
        let name = table.name("name");
        let shape = ShapeTable::read(&mut table, "shape");
        let both = || {
            let place = table.place().clone();
            AXES.map(|(word, value)| Choice { word, value, place: place.clone() }).to_vec()
        };
        let default = both();
        let held = table.words("held", &AXES);
        if held.as_ref().is_some_and(Vec::is_empty) && table.intact() {
            let error = CaseError::new(&table.place_of("held"), "holds no component");
            table.error(error.value("[]").allowed("[\"x\"], [\"y\"] or [\"x\", \"y\"]"));
        }
        let motion = MotionTable::read(&mut table);
        let release_time_s = table.optional_number("release_time_s", &Allowed::FINITE);
        table.finish();
        Self { name, shape, held: held.unwrap_or(default), motion, release_time_s }
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> Support {
        Support {
            name: self.name.value.clone(),
            held: std::array::from_fn(|axis| self.held.iter().any(|choice| choice.value == axis)),
            motion: self.motion.as_ref().map(MotionTable::to_setup),
            release_time: self.release_time_s,
        }
    }
}
