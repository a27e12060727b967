//! Materials and formulations of solids as a case file writes them.

use serde::Serialize;
use sph::setup::{
    Choice, ElasticParameters, Formulation, FormulationKind, TotalLagrangian, UpdatedLagrangian,
};

use super::Preset;
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, Parameters, Table};
use crate::case::spec::{Kind, SetSpec, TableSpec, Variant, Variants, key};

/// Rows of `material`.
pub static MATERIAL: TableSpec = TableSpec::new(
    "material",
    "Density and two elastic constants, K and G or E and ν.",
    &[
        key(
            "young_modulus_pa",
            Kind::Number(Allowed::POSITIVE),
            "Young's modulus E; a rigid body, for which moduli act in contact alone, takes 1e7 Pa where it names none",
        ),
        key("poisson_ratio", Kind::Number(POISSON), "Poisson's ratio ν; 0.3 for a rigid body that names no moduli"),
    ],
)
.with_set(SetSpec::of::<ElasticParameters>(&[]))
.either_or_none(&[&["young_modulus_pa", "poisson_ratio"], &BULK_SHEAR]);

// Above, the bulk modulus overflows any time step.
const POISSON: Allowed = Allowed::new(
    -1.0,
    0.5,
    (false, false),
    "a number above -1 and below 0.5 (0.49 for nearly incompressible)",
);

/// `material`: two elastic constants, K and G or E and ν, and all other parameters.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct MaterialTable {
    #[serde(flatten)]
    pub parameters: Parameters<ElasticParameters>,
    #[serde(flatten)]
    pub young_poisson: Option<YoungPoisson>,
}

/// E and ν in place of K and G.
#[derive(Clone, Copy, Debug, Serialize)]
#[allow(missing_docs)]
pub struct YoungPoisson {
    pub young_modulus_pa: f64,
    pub poisson_ratio: f64,
}

const BULK_SHEAR: [&str; 2] = ["bulk_modulus_pa", "shear_modulus_pa"];

/// Moduli of a rigid body that names none: they give its contact a stiffness.
const OF_RIGID: YoungPoisson = YoungPoisson { young_modulus_pa: 1e7, poisson_ratio: 0.3 };

impl MaterialTable {
    pub(super) fn read(parent: &mut Table<'_>, is_rigid: bool) -> Self {
        let Some(mut table) = parent.required_table("material") else {
            return Self { parameters: Parameters::unwritten(), young_poisson: None };
        };
        let bulk_shear = BULK_SHEAR.iter().any(|key| table.has(key));
        let young_poisson = ["young_modulus_pa", "poisson_ratio"].iter().any(|key| table.has(key));
        if bulk_shear && young_poisson {
            let error = CaseError::new(table.place(), "names elastic constants of both pairs");
            table.error(error.allowed(
                "either `bulk_modulus_pa` and `shear_modulus_pa`, or `young_modulus_pa` and `poisson_ratio`",
            ));
            table.abandon();
        }
        let young_poisson = match (bulk_shear, young_poisson) {
            (true, _) => None,
            (false, false) if is_rigid => Some(OF_RIGID),
            (false, _) => Some(YoungPoisson::read(&mut table)),
        };
        let (base, derived) = match young_poisson {
            Some(moduli) => (moduli.elastic(), &BULK_SHEAR[..]),
            None => (ElasticParameters::default(), &[][..]),
        };
        let parameters = table.parameters(base, derived);
        table.finish();
        Self { parameters, young_poisson }
    }
}

impl YoungPoisson {
    fn read(table: &mut Table<'_>) -> Self {
        Self {
            young_modulus_pa: table.number("young_modulus_pa").value,
            poisson_ratio: table.number("poisson_ratio").value,
        }
    }

    /// Isotropic elasticity: K = E/(3(1 − 2ν)), G = E/(2(1 + ν)).
    fn elastic(&self) -> ElasticParameters {
        let (e, nu) = (self.young_modulus_pa, self.poisson_ratio);
        ElasticParameters {
            bulk_modulus: e / (3.0 * (1.0 - 2.0 * nu)),
            shear_modulus: e / (2.0 * (1.0 + nu)),
            ..ElasticParameters::default()
        }
    }
}

/// Rows of `formulation`.
pub static FORMULATION: TableSpec =
    TableSpec::new("formulation", "How a body is discretised.", &[]).by(Variants::new(
        "type",
        "how the body is discretised",
        &[
            Variant::new(
                "total-lagrangian",
                "deformation gradient and nominal stress in the reference configuration",
                &[],
            )
            .with_set(SetSpec::of::<TotalLagrangian>(&[(
                "artificial_viscosity_a",
                "0.2 in a case with a fluid, else 0",
            )])),
            Variant::new("updated-lagrangian", "that of the source paper: Eq. (5)-(8), (17), (25)-(26)", &[])
                .with_set(SetSpec::of::<UpdatedLagrangian>(&[("kernel_ratio", "that of `[solid]`")])),
            Variant::new("rigid", "keeps its shape and takes no stress", &[]),
        ],
    )
    .or_else("\"total-lagrangian\"; \"updated-lagrangian\" with the preset \"paper\""));

/// `formulation`.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum FormulationTable {
    TotalLagrangian(Parameters<TotalLagrangian>),
    UpdatedLagrangian(Parameters<UpdatedLagrangian>),
    Rigid,
}

/// What the defaults of a body depend on.
#[derive(Clone, Copy, Debug)]
pub struct BodyDefaults {
    /// Preset of the case.
    pub preset: Preset,
    /// h/Δx of `[solid]` \[-\].
    pub kernel_ratio: f64,
    /// Whether there is a fluid.
    pub is_wet: bool,
}

/// Default artificial viscosity A of a total-Lagrangian body in water \[-\]: pressure waves make it ring. On its own a
/// body conserves energy.
const WET_VISCOSITY: f64 = 0.2;

impl FormulationTable {
    pub(super) fn read(mut table: Table<'_>, defaults: BodyDefaults) -> Self {
        let BodyDefaults { preset, kernel_ratio, is_wet } = defaults;
        let kind = match preset {
            Preset::Paper => FormulationKind::UpdatedLagrangian,
            _ => FormulationKind::TotalLagrangian,
        };
        let read = match table.choice_or("type", FormulationKind::NAMES, kind).value {
            FormulationKind::Rigid => Self::Rigid,
            FormulationKind::TotalLagrangian => {
                let viscosity_a = if is_wet { WET_VISCOSITY } else { 0.0 };
                let base = TotalLagrangian { viscosity_a, ..preset.values() };
                Self::TotalLagrangian(table.parameters(base, &[]))
            }
            FormulationKind::UpdatedLagrangian => {
                let base = UpdatedLagrangian { kernel_ratio, ..preset.values() };
                Self::UpdatedLagrangian(table.parameters(base, &[]))
            }
        };
        table.finish();
        read
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> Formulation {
        match self {
            Self::Rigid => Formulation::Rigid,
            Self::TotalLagrangian(set) => Formulation::TotalLagrangian(set.values()),
            Self::UpdatedLagrangian(set) => Formulation::UpdatedLagrangian(set.values()),
        }
    }
}
