//! The terms of a case that its parameters switch on, for `check` and the run header.

use sph::setup::ParameterSet;

use super::ActiveTerm;
use crate::case::Case;
use crate::case::file::fluid::DampingTable;
use crate::case::file::material::FormulationTable;
use crate::case::file::solid::ContactTable;

impl Case {
    pub(super) fn active_terms(&self) -> Vec<ActiveTerm> {
        let mut found = Vec::new();
        if let Some(run) = &self.file.run {
            let (seed, fraction) = (run.seed, run.displacement_fraction);
            let text = format!(
                "seed = {seed}: every water particle displaced by at most {fraction} Δx along each axis"
            );
            found.push(ActiveTerm::new("start", text));
        }
        if let Some(fluid) = &self.file.fluid {
            add("fluid", &fluid.parameters.values(), &mut found);
            add_damping("fluid", fluid.damping.as_ref(), &mut found);
        }
        if let Some(k) = self.file.interface.as_ref().and_then(|table| table.repulsion).filter(|k| *k > 0.0) {
            found.push(ActiveTerm::new(
                "interface",
                format!("repulsion = {k}: water lower than 0.6 Δx over solids"),
            ));
        }
        let Some(solid) = &self.file.solid else { return found };
        for body in &solid.bodies {
            let owner = format!("body `{}`", body.name.value);
            match &body.formulation {
                FormulationTable::TotalLagrangian(set) => add(&owner, &set.values(), &mut found),
                FormulationTable::UpdatedLagrangian(set) => add(&owner, &set.values(), &mut found),
                FormulationTable::Rigid => {}
            }
        }
        add_damping("solid", solid.damping.as_ref(), &mut found);
        match &solid.contact {
            ContactTable::Sums => {
                found.push(ActiveTerm::new("contact", "sums: Eq. (22) and section 4.1".to_owned()));
            }
            ContactTable::Repulsion(set) => {
                let mut values = set.values();
                // Water presses in gaps only where the solid's side evaluates the pair law with walls.
                let coupling = self.run_plan().coupling;
                values.wet &= coupling.is_some_and(|coupling| coupling.has_wall_states());
                add("contact", &values, &mut found);
            }
        }
        found
    }
}

/// Adds the parameters of a set that are not at the value that leaves their term out.
fn add(owner: &str, set: &impl ParameterSet, found: &mut Vec<ActiveTerm>) {
    for (spec, value) in set.stated().filter(|(spec, _)| spec.off.is_some() || spec.is_optional) {
        let meaning = spec.meaning();
        let meaning = meaning.split([';', ':']).next().unwrap_or_default();
        found.push(ActiveTerm::new(
            owner,
            format!("{} = {value}: {}", spec.key, meaning.trim_end_matches('.')),
        ));
    }
}

fn add_damping(owner: &str, damping: Option<&DampingTable>, found: &mut Vec<ActiveTerm>) {
    if let Some(DampingTable { rate_per_s, until_s }) = damping {
        let text = format!("damping of the start, k = {rate_per_s} 1/s until {until_s} s");
        found.push(ActiveTerm::new(owner, text));
    }
}
