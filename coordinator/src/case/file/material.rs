//! Materials and formulations of solids as a case file writes them.

use serde::Serialize;
use sph::setup::{ElasticMaterial, Formulation, HyperelasticLaw, TotalLagrangian, UpdatedLagrangian};

use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, Choice, Table};

/// `material`: two elastic constants, K and G or E and ν.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct MaterialTable {
    pub density_kg_m3: f64,
    #[serde(flatten)]
    pub moduli: Moduli,
}

/// The pair of elastic constants that a case names.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
#[allow(missing_docs)]
pub enum Moduli {
    BulkShear { bulk_modulus_pa: f64, shear_modulus_pa: f64 },
    YoungPoisson { young_modulus_pa: f64, poisson_ratio: f64 },
}

impl MaterialTable {
    pub(super) fn read(parent: &mut Table<'_>) -> Self {
        // Above, the bulk modulus overflows any time step.
        const POISSON: Allowed = Allowed::new(
            -1.0,
            0.5,
            (false, false),
            0.0,
            "a number above -1 and below 0.5 (0.49 for nearly incompressible)",
        );
        let fallback = Moduli::BulkShear { bulk_modulus_pa: 1.0, shear_modulus_pa: 1.0 };
        let Some(mut table) = parent.required_table("material") else {
            return Self { density_kg_m3: 1.0, moduli: fallback };
        };
        let density_kg_m3 = table.number("density_kg_m3", &Allowed::POSITIVE).value;
        let bulk_shear = ["bulk_modulus_pa", "shear_modulus_pa"].iter().any(|key| table.has(key));
        let young_poisson = ["young_modulus_pa", "poisson_ratio"].iter().any(|key| table.has(key));
        if bulk_shear && young_poisson {
            let error = CaseError::new(table.place(), "names elastic constants of both pairs");
            table.error(error.allowed(
                "either `bulk_modulus_pa` and `shear_modulus_pa`, or `young_modulus_pa` and `poisson_ratio`",
            ));
            table.abandon();
        }
        let moduli = if bulk_shear {
            Moduli::BulkShear {
                bulk_modulus_pa: table.number("bulk_modulus_pa", &Allowed::POSITIVE).value,
                shear_modulus_pa: table.number("shear_modulus_pa", &Allowed::POSITIVE).value,
            }
        } else {
            Moduli::YoungPoisson {
                young_modulus_pa: table.number("young_modulus_pa", &Allowed::POSITIVE).value,
                poisson_ratio: table.number("poisson_ratio", &POISSON).value,
            }
        };
        table.finish();
        Self { density_kg_m3, moduli }
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> ElasticMaterial {
        let (bulk_modulus, shear_modulus) = match self.moduli {
            Moduli::BulkShear { bulk_modulus_pa, shear_modulus_pa } => (bulk_modulus_pa, shear_modulus_pa),
            // Isotropic elasticity: K = E/(3(1 − 2ν)), G = E/(2(1 + ν)).
            Moduli::YoungPoisson { young_modulus_pa: e, poisson_ratio: nu } => {
                (e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)))
            }
        };
        ElasticMaterial { density: self.density_kg_m3, bulk_modulus, shear_modulus }
    }
}

/// `formulation`.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum FormulationTable {
    UpdatedLagrangian {
        kernel_ratio: f64,
        gradient_correction: bool,
        artificial_viscosity_a: f64,
        artificial_viscosity_b: f64,
        lambda: f64,
        artificial_stress: f64,
        artificial_stress_exponent: f64,
    },
    TotalLagrangian {
        law: Choice<HyperelasticLaw>,
        kernel_ratio: f64,
        hourglass: f64,
        artificial_viscosity_a: f64,
        artificial_viscosity_b: f64,
    },
    Rigid,
}

#[derive(Clone, Copy)]
enum FormulationKind {
    UpdatedLagrangian,
    TotalLagrangian,
    Rigid,
}

impl FormulationTable {
    pub(super) fn read(mut table: Table<'_>, kernel_ratio: f64) -> Self {
        const KINDS: [(&str, FormulationKind); 3] = [
            ("updated-lagrangian", FormulationKind::UpdatedLagrangian),
            ("total-lagrangian", FormulationKind::TotalLagrangian),
            ("rigid", FormulationKind::Rigid),
        ];
        const LAWS: [(&str, HyperelasticLaw); 2] = [
            ("neo-hookean", HyperelasticLaw::NeoHookean),
            ("st-venant-kirchhoff", HyperelasticLaw::StVenantKirchhoff),
        ];
        // Below 0.6 the support does not reach past the nearest neighbours by a margin.
        const STENCIL_RATIO: Allowed = Allowed::new(0.6, 3.0, (true, true), 0.75, "a number from 0.6 to 3");
        const EXPONENT: Allowed =
            Allowed::new(0.0, 20.0, (false, true), 4.0, "a number above 0 and at most 20");
        let read = match table.choice_or_first("type", &KINDS).value {
            FormulationKind::Rigid => Self::Rigid,
            FormulationKind::TotalLagrangian => Self::TotalLagrangian {
                law: table.choice_or_first("law", &LAWS),
                kernel_ratio: table.number_or("kernel_ratio", &STENCIL_RATIO, 0.75).value,
                hourglass: table.number_or("hourglass", &Allowed::NOT_NEGATIVE, 0.3).value,
                artificial_viscosity_a: table
                    .number_or("artificial_viscosity_a", &Allowed::NOT_NEGATIVE, 0.0)
                    .value,
                artificial_viscosity_b: table
                    .number_or("artificial_viscosity_b", &Allowed::NOT_NEGATIVE, 0.0)
                    .value,
            },
            FormulationKind::UpdatedLagrangian => Self::UpdatedLagrangian {
                kernel_ratio: table.number_or("kernel_ratio", &Allowed::KERNEL_RATIO, kernel_ratio).value,
                gradient_correction: table.flag_or("gradient_correction", true),
                artificial_viscosity_a: table
                    .number_or("artificial_viscosity_a", &Allowed::NOT_NEGATIVE, 1.0)
                    .value,
                artificial_viscosity_b: table
                    .number_or("artificial_viscosity_b", &Allowed::NOT_NEGATIVE, 1.0)
                    .value,
                lambda: table.number_or("lambda", &Allowed::SHARE, 0.01).value,
                artificial_stress: table.number_or("artificial_stress", &Allowed::SHARE, 0.3).value,
                artificial_stress_exponent: table
                    .number_or("artificial_stress_exponent", &EXPONENT, 4.0)
                    .value,
            },
        };
        table.finish();
        read
    }

    /// Set-up of the solvers, for particles of `spacing` \[m\].
    pub fn to_setup(&self, spacing: f64) -> Formulation {
        match *self {
            Self::Rigid => Formulation::Rigid,
            Self::TotalLagrangian {
                ref law,
                kernel_ratio,
                hourglass,
                artificial_viscosity_a,
                artificial_viscosity_b,
            } => Formulation::TotalLagrangian(TotalLagrangian {
                smoothing_length: kernel_ratio * spacing,
                law: law.value,
                hourglass,
                viscosity_a: artificial_viscosity_a,
                viscosity_b: artificial_viscosity_b,
            }),
            Self::UpdatedLagrangian {
                kernel_ratio,
                gradient_correction,
                artificial_viscosity_a,
                artificial_viscosity_b,
                lambda,
                artificial_stress,
                artificial_stress_exponent,
            } => Formulation::UpdatedLagrangian(UpdatedLagrangian {
                smoothing_length: kernel_ratio * spacing,
                gradient_correction,
                viscosity_a: artificial_viscosity_a,
                viscosity_b: artificial_viscosity_b,
                lambda,
                artificial_stress,
                artificial_stress_exponent,
            }),
        }
    }
}
