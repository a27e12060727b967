//! Solids, their materials, supports and contact as a case file writes them.

use serde::Serialize;
use sph::setup::{
    ContactLaw, ElasticMaterial, Formulation, HyperelasticLaw, LoadLaw, SolidStepping, SubstepCount, Support,
    TotalLagrangian, UpdatedLagrangian,
};
use sph::vector::Vector;

use super::fluid::{DampingTable, FluidTable};
use super::formula;
use super::run::{AXES, MotionTable};
use super::shape::ShapeTable;
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, At, Choice, Table, Written};

/// `[solid]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct SolidTable {
    pub particle_spacing_m: At<f64>,
    pub kernel_ratio: At<f64>,
    pub lost_particle_limit: u64,
    pub substeps: SubstepsKey,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<DampingTable>,
    pub contact: ContactTable,
    #[serde(rename = "body")]
    pub bodies: Vec<BodyTable>,
    #[serde(skip)]
    pub intact: bool,
}

impl SolidTable {
    /// Reads the table; the spacing is the fluid's unless it is written.
    pub fn read(mut table: Table<'_>, fluid: Option<&FluidTable>) -> Self {
        let particle_spacing_m = match fluid {
            Some(fluid) => {
                table.number_or("particle_spacing_m", &Allowed::POSITIVE, fluid.particle_spacing_m.value)
            }
            None => table.number("particle_spacing_m", &Allowed::POSITIVE),
        };
        let known_spacing = table.has("particle_spacing_m") || fluid.is_none_or(|fluid| fluid.lattice_intact);
        let kernel_ratio = table.number_or("kernel_ratio", &Allowed::KERNEL_RATIO, 1.3);
        let lost_particle_limit = table.count_or("lost_particle_limit", 0..1_000_000_001, 0).value;
        let damping = DampingTable::read(&mut table);
        let substeps = SubstepsKey::read(&mut table);
        let contact = ContactTable::read(table.table_or_empty("contact"));
        let intact = table.intact() && known_spacing;
        let ratio = kernel_ratio.value;
        let bodies: Vec<BodyTable> =
            table.tables("body").into_iter().map(|body| BodyTable::read(body, ratio)).collect();
        let total = |body: &BodyTable| matches!(body.formulation, FormulationTable::TotalLagrangian { .. });
        let substeps = substeps.unwrap_or(SubstepsKey::Word(if bodies.iter().any(total) {
            SubstepsWord::Auto
        } else {
            SubstepsWord::None
        }));
        table.finish();
        Self {
            particle_spacing_m,
            kernel_ratio,
            lost_particle_limit,
            damping,
            substeps,
            contact,
            bodies,
            intact,
        }
    }

    /// Widest smoothing length of all bodies \[m\].
    pub fn smoothing_length(&self) -> f64 {
        let widest =
            self.bodies.iter().filter_map(BodyTable::kernel_ratio).fold(self.kernel_ratio.value, f64::max);
        widest * self.particle_spacing_m.value
    }
}

/// `substeps`: a number, or how it is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
#[allow(missing_docs)]
pub enum SubstepsKey {
    Count(u32),
    Word(SubstepsWord),
}

/// Words of `substeps`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum SubstepsWord {
    None,
    Auto,
}

impl SubstepsKey {
    fn read(table: &mut Table<'_>) -> Option<Self> {
        const WORDS: [(&str, SubstepsWord); 2] = [("auto", SubstepsWord::Auto), ("none", SubstepsWord::None)];
        let found = table.optional_count_or_word("substeps", 2..10_001, &WORDS)?;
        let count = match found {
            Err(word) => return Some(Self::Word(word.value)),
            Ok(count) => u32::try_from(count).ok()?,
        };
        if count % 2 != 0 {
            let error = CaseError::new(&table.place_of("substeps"), "not an even number").value(count);
            table.error(error.allowed("an even number from 2 to 10000, \"auto\" or \"none\""));
            return None;
        }
        Some(Self::Count(count))
    }

    /// Set-up of the solvers.
    pub fn to_setup(self) -> SolidStepping {
        match self {
            Self::Count(count) => SolidStepping::Substeps(SubstepCount::Fixed(count)),
            Self::Word(SubstepsWord::Auto) => SolidStepping::Substeps(SubstepCount::Automatic),
            Self::Word(SubstepsWord::None) => SolidStepping::StageRule,
        }
    }
}

/// `[solid.contact]`.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "law", rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum ContactTable {
    Repulsion { stiffness: f64, distance: f64, damping: f64, friction: f64, self_contact: bool },
    Sums,
}

impl ContactTable {
    fn read(mut table: Table<'_>) -> Self {
        const DISTANCE: Allowed =
            Allowed::new(0.0, 3.0, (false, true), 1.0, "a number above 0 and at most 3");
        let law = table.choice_or_first("law", &[("repulsion", false), ("sums", true)]);
        let read = match law.value {
            true => Self::Sums,
            false => Self::Repulsion {
                stiffness: table.number_or("stiffness", &Allowed::POSITIVE, 1.0).value,
                distance: table.number_or("distance", &DISTANCE, 1.0).value,
                damping: table.number_or("damping", &Allowed::NOT_NEGATIVE, 0.2).value,
                friction: table.number_or("friction", &Allowed::NOT_NEGATIVE, 0.0).value,
                self_contact: table.flag_or("self_contact", true),
            },
        };
        table.finish();
        read
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> ContactLaw {
        match *self {
            Self::Repulsion { stiffness, distance, damping, friction, self_contact } => {
                ContactLaw::Repulsion { stiffness, distance, damping, friction, self_contact }
            }
            Self::Sums => ContactLaw::Sums,
        }
    }
}

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
    fn read(mut table: Table<'_>, kernel_ratio: f64) -> Self {
        let name = table.name("name");
        let shape = ShapeTable::read(&mut table, "shape");
        let material = MaterialTable::read(&mut table);
        let formulation = FormulationTable::read(table.table_or_empty("formulation"), kernel_ratio);
        let velocity_m_s = formula::read_pair(&mut table, "velocity_m_s", &["x", "y"])
            .unwrap_or_else(|| formula::zeros(&table.place_of("velocity_m_s")));
        let rotation_speed_rad_s = table.number_or("rotation_speed_rad_s", &Allowed::FINITE, 0.0).value;
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
            FormulationTable::UpdatedLagrangian { kernel_ratio, .. } => Some(*kernel_ratio),
            FormulationTable::TotalLagrangian { .. } | FormulationTable::Rigid => None,
        }
    }
}

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
    fn read(parent: &mut Table<'_>) -> Self {
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
    fn read(mut table: Table<'_>, kernel_ratio: f64) -> Self {
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

    fn read(mut table: Table<'_>) -> Self {
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
    fn read(mut table: Table<'_>) -> Self {
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
