//! Parameters and fixed constants of a case, for people and for `summary.json`.

use std::collections::BTreeMap;

use sph::constants::Constant;
use sph::coupling::solver::Role;
use sph::setup::{Choice, ContactLaw, Formulation, ParameterSet, SolidStepping, SubstepCount, Value};

use crate::case::Case;
use crate::case::file::fluid as fluid_file;
use crate::case::file::material::FormulationTable;
use crate::case::file::solid::ContactTable;
use crate::case::scene::{obstacles, overlap, wall};
use crate::case::{limits, relaxation};
use crate::results::quality::{thresholds, volume};

impl Case {
    /// Constants that decide the answer, in words.
    pub(super) fn constants(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(fluid) = &self.file.fluid {
            lines.push(format!("fluid: {}", listed(&fluid.parameters.values())));
        }
        if let Some(solid) = &self.file.solid {
            let stepping = match solid.substeps.to_setup() {
                SolidStepping::StageRule => "advances by the stage rule, Eq. (30)-(31)".to_owned(),
                SolidStepping::Substeps(SubstepCount::Fixed(count)) => {
                    format!("{count} velocity-Verlet sub-steps per step")
                }
                SolidStepping::Substeps(SubstepCount::Automatic) => {
                    "as many velocity-Verlet sub-steps per step as its limit asks for".to_owned()
                }
            };
            lines.push(format!("solid: Δx = {} m, {stepping}", solid.particle_spacing_m.value));
            for body in &solid.bodies {
                let material = body.material.parameters.values();
                let formulation = match &body.formulation {
                    FormulationTable::Rigid => "rigid".to_owned(),
                    FormulationTable::UpdatedLagrangian(set) => {
                        format!("updated-lagrangian, {}", listed(&set.values()))
                    }
                    FormulationTable::TotalLagrangian(set) => {
                        format!("total-lagrangian, {}", listed(&set.values()))
                    }
                };
                lines.push(format!(
                    "body `{}`: {}, c_L = {:.2} m/s, {formulation}",
                    body.name.value,
                    listed(&material),
                    material.longitudinal_speed()
                ));
            }
            lines.push(match &solid.contact {
                ContactTable::Sums => "contact: sums".to_owned(),
                ContactTable::Repulsion(set) => format!("contact: repulsion, {}", listed(&set.values())),
            });
        }
        if let Some(interface) = &self.file.interface {
            lines.push(format!(
                "interface: law {}, margin {} Δx",
                interface.law.word, interface.margin_spacings
            ));
        }
        lines
    }

    /// Coefficients of the laws of this case that no case sets.
    pub fn fixed_constants(&self) -> impl Iterator<Item = &'static Constant> {
        let fluid = self.has(Role::Fluid).then(fluid::constants).into_iter().flatten();
        let solid = self.has(Role::Solid).then(solid::constants).into_iter().flatten();
        let case = [
            overlap::CONSTANTS,
            obstacles::CONSTANTS,
            wall::CONSTANTS,
            limits::CONSTANTS,
            relaxation::CONSTANTS,
            fluid_file::CONSTANTS,
        ];
        let own = case.into_iter().chain([thresholds::CONSTANTS, volume::CONSTANTS]).flatten();
        sph::fixed_constants::fixed_constants().chain(fluid).chain(solid).chain(own)
    }

    /// Every parameter of fluid, bodies and contact by name, such as `fluid.artificial_viscosity_a`.
    pub fn parameters(&self) -> BTreeMap<String, serde_json::Value> {
        let mut all = BTreeMap::new();
        if let Some(run) = &self.file.run {
            all.insert("run.seed".to_owned(), run.seed.into());
            all.insert("run.displacement_fraction".to_owned(), run.displacement_fraction.into());
        }
        if let Some(fluid) = &self.file.fluid {
            list("fluid", &fluid.parameters.values(), &mut all);
        }
        let Some(solid) = &self.file.solid else { return all };
        for body in &solid.bodies {
            let name = &body.name.value;
            let formulation = body.formulation.to_setup();
            list(&format!("body.{name}.material"), &body.material.parameters.values(), &mut all);
            all.insert(format!("body.{name}.formulation"), formulation.kind().name().into());
            match &formulation {
                Formulation::TotalLagrangian(set) => list(&format!("body.{name}"), set, &mut all),
                Formulation::UpdatedLagrangian(set) => list(&format!("body.{name}"), set, &mut all),
                Formulation::Rigid => {}
            }
        }
        let contact = solid.contact.to_setup();
        all.insert("contact".to_owned(), contact.kind().name().into());
        if let ContactLaw::Repulsion(set) = &contact {
            list("contact", set, &mut all);
        }
        all
    }
}

/// Adds the values of a set under `owner`.
fn list(owner: &str, set: &impl ParameterSet, all: &mut BTreeMap<String, serde_json::Value>) {
    for (spec, value) in set.values() {
        let value = match value {
            Value::Number(number) => number.into(),
            Value::Flag(flag) => flag.into(),
            Value::Choice(word) => word.into(),
            Value::Count(count) => count.into(),
        };
        all.insert(format!("{owner}.{}", spec.key), value);
    }
}

/// Keys and values of a set.
fn listed(set: &impl ParameterSet) -> String {
    let values: Vec<String> = set.values().map(|(spec, value)| format!("{} = {value}", spec.key)).collect();
    values.join(", ")
}
