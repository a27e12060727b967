//! Loads on solids and their supports as a case file writes them.

use serde::Serialize;
use sph::setup::{LoadLaw, Support};
use sph::space::Space;

use super::formula;
use super::run::{AXIS_WORDS, MOTION};
use super::run::{MotionTable, axes};
use super::shape::SHAPE;
use super::shape::ShapeTable;
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, At, Choice, Coordinates, Table, Written};
use crate::case::spec::{Kind, TableSpec, Variables, key};

/// Rows of `[[solid.body.load]]`.
pub static LOAD: TableSpec = TableSpec::new(
    "load",
    "A load on part of the surface of a body.",
    &[
        key("name", Kind::Name, "name of the load"),
        key(
            "shape",
            Kind::Table(&SHAPE),
            "loads the outer cell faces of the body whose centre lies in this shape at the start",
        ),
        key(
            "pressure_pa",
            Kind::Expression(Variables::CoordinatesAndTime),
            "pressure along the current normal; total-Lagrangian bodies only",
        ),
        key(
            "traction_pa",
            Kind::Expressions(Variables::CoordinatesAndTime),
            "force per undeformed area, of given direction",
        ),
    ],
)
.either(&[&["pressure_pa"], &["traction_pa"]]);

/// Rows of `[[solid.body.support]]`.
pub static SUPPORT: TableSpec = TableSpec::new(
    "support",
    "A part of a body that is held or moved, or a point about which a rigid body turns.",
    &[
        key("name", Kind::Name, "name of the support"),
        key("shape", Kind::Table(&SHAPE), "holds the particles of the body inside this shape at the start"),
        key(
            "pivot_m",
            Kind::Vector,
            "in place of `shape` and `held`: a point about which a rigid body turns freely, a hinge in the plane; it may \
             lie off the body",
        ),
        key(
            "held",
            Kind::SomeWords(AXIS_WORDS),
            "held components: all for a clamp, one in the plane for a roller",
        )
        .or_else("all"),
        key("motion", Kind::Table(&MOTION), "prescribed motion of the held components, or of the pivot")
            .or_else("at rest"),
        key("release_time_s", Kind::Number(Allowed::FINITE), "time at which the support ceases to act")
            .or_else("never"),
    ],
)
.either(&[&["shape"], &["pivot_m"]]);

/// `[[solid.body.load]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct LoadTable {
    pub name: At<String>,
    /// Outer faces whose middle lies inside this shape at the start are loaded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    /// Expressions of the coordinates and t.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_pa: Option<At<Written>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traction_pa: Option<Vec<At<Written>>>,
}

impl LoadTable {
    pub(super) fn read(mut table: Table<'_>) -> Self {
        let name = table.name("name");
        let shape = ShapeTable::read(&mut table, "shape");
        let pressure_pa = table.has("pressure_pa").then(|| formula::read(&mut table, "pressure_pa"));
        let traction_pa = formula::read_components(&mut table, "traction_pa");
        if pressure_pa.is_some() == traction_pa.is_some() && table.intact() {
            let error = CaseError::new(table.place(), "does not say what acts");
            table.error(error.allowed("either `pressure_pa` or `traction_pa`"));
        }
        table.finish();
        Self { name, shape, pressure_pa, traction_pa }
    }

    /// Set-up of the solvers; `None` if the table is wrong.
    pub fn to_law<S: Space>(&self) -> Option<LoadLaw<S>> {
        match (&self.pressure_pa, &self.traction_pa) {
            (Some(pressure), None) => Some(LoadLaw::Pressure(pressure.value.text())),
            (None, Some(traction)) => Some(LoadLaw::Traction(formula::texts::<S>(traction))),
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
    /// Point about which a rigid body turns, in place of a shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pivot_m: Option<At<Coordinates>>,
    /// Components that are held: all for a clamp, fewer for a roller, none for a pivot.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub held: Vec<Choice<usize>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_time_s: Option<f64>,
}

impl SupportTable {
    pub(super) fn read(mut table: Table<'_>) -> Self {
        let name = table.name("name");
        let pivot_m = table.has("pivot_m").then(|| table.vector("pivot_m"));
        let is_pivot = pivot_m.is_some();
        for key in ["shape", "held"].into_iter().filter(|key| is_pivot && table.has(key)) {
            let error = CaseError::new(&table.place_of(key), "is given beside `pivot_m`");
            table.error(error.hint("a pivot holds no particles; leave one of them out"));
        }
        // Read all the same, so that they are known keys.
        let shape =
            (!is_pivot || table.has("shape")).then(|| ShapeTable::read(&mut table, "shape")).flatten();
        let axes = axes(table.dimensions);
        let all =
            axes.iter().map(|(word, value)| Choice { word, value: *value, place: table.place().clone() });
        let default = all.collect();
        let mut held = table.words("held", axes);
        if is_pivot {
            held = Some(Vec::new());
        }
        if !is_pivot && held.as_ref().is_some_and(Vec::is_empty) && table.intact() {
            let error = CaseError::new(&table.place_of("held"), "holds no component");
            let words: Vec<String> = axes.iter().map(|(word, _)| format!("\"{word}\"")).collect();
            table.error(error.value("[]").allowed(format!("a list of some of {}", words.join(", "))));
        }
        let motion = MotionTable::read(&mut table);
        let release_time_s = table.optional_number("release_time_s");
        table.finish();
        Self { name, shape, pivot_m, held: held.unwrap_or(default), motion, release_time_s }
    }

    /// Set-up of the solvers.
    pub fn to_setup<S: Space>(&self) -> Support<S> {
        Support {
            name: self.name.value.clone(),
            held: S::per_axis(|axis| self.held.iter().any(|choice| choice.value == axis)),
            motion: self.motion.as_ref().map(MotionTable::to_setup::<S>),
            pivot: self.pivot_m.as_ref().map(|at| at.value.to::<S>()),
            release_time: self.release_time_s,
        }
    }
}
