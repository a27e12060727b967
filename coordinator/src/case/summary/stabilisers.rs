//! The stabilisers of a case, for `check` and the run header.

use sph::setup::{Choice, DensityDiffusion};

use super::Stabiliser;
use crate::case::Case;
use crate::case::file::material::FormulationTable;
use crate::case::file::solid::ContactTable;

impl Case {
    pub(super) fn stabilisers(&self) -> Vec<Stabiliser> {
        let mut found = Vec::new();
        let mut add = |owner: &str, text: String| found.push(Stabiliser { owner: owner.to_owned(), text });
        if let Some(fluid) = &self.file.fluid {
            let fluid_table = fluid;
            let fluid = fluid_table.parameters.values();
            if fluid.density_diffusion != DensityDiffusion::None {
                let (word, delta) = (fluid.density_diffusion.name(), fluid.density_diffusion_delta);
                add("fluid", format!("density diffusion {word}, δ = {delta}, Eq. (18)-(20)"));
            }
            let (a, b) = (fluid.viscosity_a, fluid.viscosity_b);
            if a > 0.0 || b > 0.0 {
                add(
                    "fluid",
                    format!("artificial viscosity, A = {a}, B = {b}, λ = {}, Eq. (23)-(24)", fluid.lambda),
                );
            }
            if fluid.acoustic_damping > 0.0 {
                let alpha = fluid.acoustic_damping;
                add("fluid", format!("acoustic damper, a bulk viscosity α ρ c₀ h, α = {alpha}"));
            }
            if fluid.wall_repulsion > 0.0 && !self.file.walls.is_empty() {
                let k = fluid.wall_repulsion;
                add("fluid", format!("repulsion by wall faces closer than Δx/10, k = {k}"));
            }
            if fluid.shifting > 0.0 {
                let c = fluid.shifting;
                add("fluid", format!("particle shifting away from surface and high pressure, C = {c}"));
            }
            if fluid.tensile_control {
                add(
                    "fluid",
                    "tensile control where pressure is negative, down to -ρ0c0²/1000, away from the surface"
                        .into(),
                );
            }
            if let Some(tension) = fluid.tension_limit {
                add("fluid", format!("tension beyond {tension} Pa opens cavities"));
            }
            if let Some(damping) = &fluid_table.damping {
                add(
                    "fluid",
                    format!(
                        "damping of the start, k = {} 1/s until {} s",
                        damping.rate_per_s, damping.until_s
                    ),
                );
            }
        }
        if let Some(k) = self.file.interface.as_ref().and_then(|table| table.repulsion).filter(|k| *k > 0.0) {
            add("interface", format!("repulsion of pairs closer than 0.6 Δx, k = {k}"));
        }
        let Some(solid) = &self.file.solid else { return found };
        for body in &solid.bodies {
            let owner = format!("body `{}`", body.name.value);
            let viscosity = |a: f64, b: f64, lambda: f64| {
                (a > 0.0 || b > 0.0)
                    .then(|| format!("artificial viscosity, A = {a}, B = {b}, λ = {lambda}, Eq. (23)-(24)"))
            };
            let texts = match &body.formulation {
                FormulationTable::UpdatedLagrangian(set) => [
                    viscosity(set.viscosity_a, set.viscosity_b, set.lambda),
                    (set.artificial_stress > 0.0).then(|| {
                        let (stress, exponent) = (set.artificial_stress, set.artificial_stress_exponent);
                        format!("artificial stress, ε = {stress}, n = {exponent}, Eq. (25)-(26)")
                    }),
                ],
                FormulationTable::TotalLagrangian(set) => [
                    viscosity(set.viscosity_a, set.viscosity_b, solid::TOTAL_LAGRANGIAN_LAMBDA),
                    (set.hourglass > 0.0)
                        .then(|| format!("hourglass control, ζ = {} of Young's modulus", set.hourglass)),
                ],
                FormulationTable::Rigid => [None, None],
            };
            texts.into_iter().flatten().for_each(|text| add(&owner, text));
        }
        if let Some(damping) = &solid.damping {
            add(
                "solid",
                format!("damping of the start, k = {} 1/s until {} s", damping.rate_per_s, damping.until_s),
            );
        }
        match &solid.contact {
            ContactTable::Sums => add("contact", "through the sums, Eq. (22) and section 4.1".to_owned()),
            ContactTable::Repulsion(set) => add(
                "contact",
                format!(
                    "repulsion, stiffness {} K, distance {} Δx, damping {} of critical, friction {}",
                    set.stiffness, set.distance, set.damping, set.friction
                ),
            ),
        }
        found
    }
}
