//! Bodies as a case file writes them.

use serde::Serialize;
use sph::space::Space;
use sph::space::components::Components;

use super::formula;
use super::layout::Layout;
use super::layout::{LATTICE_ORIGIN, LAYOUT};
use super::material::{BodyDefaults, FormulationTable, MaterialTable};
use super::material::{FORMULATION, MATERIAL};
use super::shape::SHAPE;
use super::shape::ShapeTable;
use super::support::{LOAD, SUPPORT};
use super::support::{LoadTable, SupportTable};
use crate::case::reader::{At, Choice, Coordinates, Table, Written};
use crate::case::spec::{Kind, TableSpec, Variables, key};

/// Rows of `[[solid.body]]`.
pub static BODY: TableSpec = TableSpec::new(
    "body",
    "One body.",
    &[
        key("name", Kind::Name, "name of the body"),
        key("shape", Kind::Table(&SHAPE), "the body as it is at the start, undeformed"),
        key("material", Kind::Table(&MATERIAL), "density and elastic constants"),
        key("formulation", Kind::Table(&FORMULATION), "how the body is discretised")
            .or_else("total-lagrangian; updated-lagrangian with the preset `paper`"),
        key("velocity_m_s", Kind::Expressions(Variables::Coordinates), "velocity at the start")
            .or_else("0 along each axis"),
        key(
            SpinKey::KEY,
            Kind::Spin,
            "rotation at the start about the centre of mass, or about the pivot of a support, added to the velocity",
        )
        .or_else("none"),
        LAYOUT,
        LATTICE_ORIGIN,
        key(
            "acceleration_m_s2",
            Kind::Expressions(Variables::CoordinatesAndTime),
            "acceleration of this body only, in addition to `[body_force]`",
        )
        .or_else("none"),
        key("support", Kind::Tables(&SUPPORT), "parts that are held or moved, or a pivot").or_else("none"),
        key("load", Kind::Tables(&LOAD), "loads on its surface").or_else("none"),
    ],
);

/// `[[solid.body]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct BodyTable {
    pub name: At<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    pub material: MaterialTable,
    pub formulation: FormulationTable,
    /// Expressions of the coordinates.
    pub velocity_m_s: Vec<At<Written>>,
    /// Rotation about the centre of mass at the start.
    pub rotation_speed_rad_s: SpinKey,
    pub layout: Choice<Layout>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice_origin_m: Option<At<Coordinates>>,
    /// Expressions of the coordinates and t.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_m_s2: Option<Vec<At<Written>>>,
    #[serde(rename = "support")]
    pub supports: Vec<SupportTable>,
    #[serde(rename = "load")]
    pub loads: Vec<LoadTable>,
    #[serde(skip)]
    pub intact: bool,
}

impl BodyTable {
    pub(super) fn read(mut table: Table<'_>, defaults: BodyDefaults) -> Self {
        let name = table.name("name");
        let shape = ShapeTable::read(&mut table, "shape");
        let formulation = FormulationTable::read(table.table_or_empty("formulation"), defaults);
        let material = MaterialTable::read(&mut table, matches!(formulation, FormulationTable::Rigid));
        let dimensions = table.dimensions;
        let velocity_m_s = formula::read_components(&mut table, "velocity_m_s")
            .unwrap_or_else(|| formula::zeros(dimensions, &table.place_of("velocity_m_s")));
        let rotation_speed_rad_s = SpinKey::read(&mut table);
        let layout = Layout::read(&mut table);
        let lattice_origin_m = table.optional_vector("lattice_origin_m");
        let acceleration_m_s2 = formula::read_components(&mut table, "acceleration_m_s2");
        let supports = table.tables("support").into_iter().map(SupportTable::read).collect();
        let loads = table.tables("load").into_iter().map(LoadTable::read).collect();
        Self {
            name,
            shape,
            material,
            formulation,
            velocity_m_s,
            rotation_speed_rad_s,
            layout,
            lattice_origin_m,
            acceleration_m_s2,
            supports,
            loads,
            intact: table.finish(),
        }
    }

    /// h/Δx of sums in the current configuration; only the updated-Lagrangian body takes such.
    pub fn kernel_ratio(&self) -> Option<f64> {
        match &self.formulation {
            FormulationTable::UpdatedLagrangian(set) => Some(set.kernel_ratio),
            FormulationTable::TotalLagrangian(_) | FormulationTable::Rigid => None,
        }
    }
}

/// `rotation_speed_rad_s`: a number in the plane, a vector in space.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
#[allow(missing_docs)]
pub enum SpinKey {
    Plane(f64),
    Spatial(Coordinates),
}

impl SpinKey {
    const KEY: &'static str = "rotation_speed_rad_s";

    fn read(table: &mut Table<'_>) -> Self {
        match table.dimensions {
            2 => Self::Plane(table.number_or(Self::KEY, 0.0).value),
            dimensions => {
                Self::Spatial(table.vector_or(Self::KEY, Coordinates::repeat(dimensions, 0.0)).value)
            }
        }
    }

    /// The angular velocity \[rad/s\].
    pub fn to<S: Space>(&self) -> S::Spin {
        match self {
            Self::Plane(speed) => S::Spin::of_row(&[*speed]),
            Self::Spatial(vector) => S::Spin::of_row(vector.as_slice()),
        }
        .unwrap_or_default()
    }
}
