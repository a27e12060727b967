//! Bodies as a case file writes them.

use serde::Serialize;
use sph::space::Vector;

use super::formula;
use super::layout::Layout;
use super::material::{BodyDefaults, FormulationTable, MaterialTable};
use super::shape::ShapeTable;
use super::support::{LoadTable, SupportTable};
use crate::case::reader::{Allowed, At, Choice, Table, Written};

/// `[[solid.body]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct BodyTable {
    pub name: At<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    pub material: MaterialTable,
    pub formulation: FormulationTable,
    /// Expressions of x and y.
    pub velocity_m_s: [At<Written>; 2],
    /// Rotation about the centre of mass at the start.
    pub rotation_speed_rad_s: f64,
    pub layout: Choice<Layout>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice_origin_m: Option<At<Vector>>,
    /// Expressions of x, y and t.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_m_s2: Option<[At<Written>; 2]>,
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
        let material = MaterialTable::read(&mut table);
        let formulation = FormulationTable::read(table.table_or_empty("formulation"), defaults);
        let velocity_m_s = formula::read_pair(&mut table, "velocity_m_s", &["x", "y"])
            .unwrap_or_else(|| formula::zeros(&table.place_of("velocity_m_s")));
        let rotation_speed_rad_s = table.number_or("rotation_speed_rad_s", &Allowed::FINITE, 0.0).value;
        let layout = Layout::read(&mut table);
        let lattice_origin_m = table.optional_vector("lattice_origin_m");
        let acceleration_m_s2 = formula::read_pair(&mut table, "acceleration_m_s2", &["x", "y", "t"]);
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
