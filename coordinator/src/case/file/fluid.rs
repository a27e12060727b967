//! The fluid and its regions as a case file writes them.

use serde::Serialize;
use sph::setup::{
    Damping, DensityDiffusion, FluidConstants, FluidScheme, GradientCorrection, OrderControl, ViscousForm,
};
use sph::space::Vector;

use super::formula;
use super::shape::ShapeTable;
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, At, Choice, Table, Written};

/// Particles that may be lost before a run stops.
const LOSS_LIMITS: std::ops::Range<u64> = 0..1_000_000_001;

/// `[fluid]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct FluidTable {
    pub particle_spacing_m: At<f64>,
    pub kernel_ratio: At<f64>,
    pub rest_density_kg_m3: At<f64>,
    pub sound_speed_m_s: At<f64>,
    pub exponent: f64,
    pub dynamic_viscosity_pa_s: f64,
    pub viscous_form: Choice<ViscousForm>,
    pub gradient_correction: Choice<GradientCorrection>,
    pub density_diffusion: Choice<DiffusionKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density_diffusion_delta: Option<f64>,
    pub artificial_viscosity_a: f64,
    pub artificial_viscosity_b: f64,
    pub lambda: f64,
    pub acoustic_damping: f64,
    pub wall_repulsion: f64,
    pub shifting: f64,
    pub tensile_control: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_limit_pa: Option<f64>,
    pub scheme: Choice<FluidScheme>,
    pub lost_particle_limit: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<DampingTable>,
    #[serde(rename = "region")]
    pub regions: Vec<RegionTable>,
    /// Whether spacing and kernel ratio can be relied on.
    #[serde(skip)]
    pub lattice_intact: bool,
    #[serde(skip)]
    pub intact: bool,
}

/// Kinds of density diffusion; all but the first have a coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiffusionKind {
    /// None.
    None,
    /// Without the gradient bracket.
    Plain,
    /// With renormalised gradients.
    Renormalised,
}

const DIFFUSIONS: [(&str, DiffusionKind); 3] = [
    ("renormalised", DiffusionKind::Renormalised),
    ("plain", DiffusionKind::Plain),
    ("none", DiffusionKind::None),
];

const CORRECTIONS: [(&str, GradientCorrection); 4] = [
    ("lattice-moment", GradientCorrection::LatticeMoment),
    ("continuity", GradientCorrection::Continuity),
    ("renormalised", GradientCorrection::Renormalised),
    ("none", GradientCorrection::None),
];

const VISCOUS_FORMS: [(&str, ViscousForm); 2] =
    [("pairwise", ViscousForm::Pairwise), ("stress", ViscousForm::Stress)];

const SCHEMES: [(&str, FluidScheme); 2] =
    [("leapfrog", FluidScheme::Leapfrog), ("predictor-corrector", FluidScheme::PredictorCorrector)];

impl FluidTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let particle_spacing_m = table.number("particle_spacing_m", &Allowed::POSITIVE);
        let kernel_ratio = table.number_or("kernel_ratio", &Allowed::KERNEL_RATIO, 1.2);
        let lattice_intact = table.intact();
        let rest_density_kg_m3 = table.number("rest_density_kg_m3", &Allowed::POSITIVE);
        let sound_speed_m_s = table.number("sound_speed_m_s", &Allowed::POSITIVE);
        const EXPONENT: Allowed = Allowed::new(1.0, 20.0, (true, true), 7.0, "a number from 1 to 20");
        // The stable step is by about this factor shorter.
        const DAMPER: Allowed = Allowed::new(0.0, 1e6, (true, true), 0.0, "a number from 0 to 1e6");
        let exponent = table.number_or("exponent", &EXPONENT, 7.0).value;
        let dynamic_viscosity_pa_s =
            table.number_or("dynamic_viscosity_pa_s", &Allowed::NOT_NEGATIVE, 0.0).value;
        let viscous_form = table.choice_or_first("viscous_form", &VISCOUS_FORMS);
        let gradient_correction = table.choice_or_first("gradient_correction", &CORRECTIONS);
        let density_diffusion = table.choice_or_first("density_diffusion", &DIFFUSIONS);
        let density_diffusion_delta = match density_diffusion.value {
            DiffusionKind::None => None,
            _ => Some(table.number_or("density_diffusion_delta", &Allowed::POSITIVE, 0.1).value),
        };
        let artificial_viscosity_a =
            table.number_or("artificial_viscosity_a", &Allowed::NOT_NEGATIVE, 0.1).value;
        let artificial_viscosity_b =
            table.number_or("artificial_viscosity_b", &Allowed::NOT_NEGATIVE, 0.0).value;
        let lambda = table.number_or("lambda", &Allowed::SHARE, 0.01).value;
        let acoustic_damping = table.number_or("acoustic_damping", &DAMPER, 0.0).value;
        let wall_repulsion = table.number_or("wall_repulsion", &Allowed::NOT_NEGATIVE, 1.0).value;
        let shifting = table.number_or("shifting", &Allowed::NOT_NEGATIVE, 0.0).value;
        let tensile_control = table.flag_or("tensile_control", false);
        let scheme = table.choice_or_first("scheme", &SCHEMES);
        if (scheme.value, viscous_form.value) == (FluidScheme::Leapfrog, ViscousForm::Stress) {
            let error = CaseError::new(
                &table.place_of("viscous_form"),
                "the viscous stress of Eq. (4) does not go with leapfrog, which sums no velocity gradient in the corrector",
            );
            table.error(
                error.hint("use `viscous_form = \"pairwise\"`, or `scheme = \"predictor-corrector\"`"),
            );
        }
        let tension_limit_pa = table.optional_number("tension_limit_pa", &Allowed::POSITIVE);
        let lost_particle_limit = table.count_or("lost_particle_limit", LOSS_LIMITS, 0).value;
        let damping = DampingTable::read(&mut table);
        let intact = table.intact();
        let regions = table.tables("region").into_iter().map(RegionTable::read).collect();
        table.finish();
        Self {
            particle_spacing_m,
            kernel_ratio,
            rest_density_kg_m3,
            sound_speed_m_s,
            exponent,
            dynamic_viscosity_pa_s,
            viscous_form,
            gradient_correction,
            density_diffusion,
            density_diffusion_delta,
            artificial_viscosity_a,
            artificial_viscosity_b,
            lambda,
            acoustic_damping,
            wall_repulsion,
            shifting,
            tensile_control,
            scheme,
            tension_limit_pa,
            lost_particle_limit,
            damping,
            regions,
            lattice_intact,
            intact,
        }
    }

    /// Smoothing length h \[m\].
    pub fn smoothing_length(&self) -> f64 {
        self.kernel_ratio.value * self.particle_spacing_m.value
    }

    /// Set-up of the solvers.
    pub fn constants(&self) -> FluidConstants {
        FluidConstants {
            rest_density: self.rest_density_kg_m3.value,
            sound_speed: self.sound_speed_m_s.value,
            exponent: self.exponent,
            dynamic_viscosity: self.dynamic_viscosity_pa_s,
            smoothing_length: self.smoothing_length(),
            particle_spacing: self.particle_spacing_m.value,
            viscosity_a: self.artificial_viscosity_a,
            viscosity_b: self.artificial_viscosity_b,
            lambda: self.lambda,
            correction: self.gradient_correction.value,
        }
    }

    /// Shifting and tensile control, where the case names either.
    pub fn order_control(&self) -> Option<OrderControl> {
        let Self { shifting, tensile_control, .. } = *self;
        (shifting > 0.0 || tensile_control).then_some(OrderControl { shifting, tensile_control })
    }

    /// Density diffusion with its coefficient.
    pub fn diffusion(&self) -> DensityDiffusion {
        match (self.density_diffusion.value, self.density_diffusion_delta) {
            (DiffusionKind::Plain, Some(delta)) => DensityDiffusion::Plain { delta },
            (DiffusionKind::Renormalised, Some(delta)) => DensityDiffusion::Renormalised { delta },
            _ => DensityDiffusion::None,
        }
    }
}

/// `damping`: −k v on all free particles of one side until a time.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct DampingTable {
    pub rate_per_s: f64,
    pub until_s: f64,
}

impl DampingTable {
    /// Reads `damping`, which may be left out.
    pub fn read(parent: &mut Table<'_>) -> Option<Self> {
        let mut table = parent.optional_table("damping")?;
        let read = Self {
            rate_per_s: table.number("rate_per_s", &Allowed::POSITIVE).value,
            until_s: table.number("until_s", &Allowed::FINITE).value,
        };
        table.finish();
        Some(read)
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> Damping {
        Damping { rate: self.rate_per_s, until: self.until_s }
    }
}

/// `[[fluid.region]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct RegionTable {
    pub name: At<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    /// Expressions of x and y.
    pub velocity_m_s: [At<Written>; 2],
    pub start: StartTable,
    /// Particles that would overlap a solid or a wall are left out; otherwise an overlap is an error.
    pub cut_by_solids: bool,
    pub cut_by_walls: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice_origin_m: Option<At<Vector>>,
    /// Largest random displacement along each axis as a fraction of the spacing.
    pub displacement_fraction: f64,
    pub displacement_seed: u64,
    #[serde(skip)]
    pub intact: bool,
}

/// Pressure and density at the start.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum StartTable {
    /// p = 0, rest density.
    Rest,
    /// p = ρ₀g·depth below a level.
    Hydrostatic {
        /// Height of the free surface, measured against gravity.
        surface_m: f64,
        lattice: Choice<HydrostaticLattice>,
    },
    /// Pressure by an expression of x and y.
    Pressure { pressure_pa: At<Written>, particle_mass: Choice<ParticleMass> },
}

/// Where the particles of a hydrostatic start lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HydrostaticLattice {
    /// Rows drawn together by ρ₀/ρ, all particles with rest mass, pressure as the kernel sums balance it: at rest.
    Consistent,
    /// The lattice of a region at rest: particles' volumes do not fill it, and the start rings.
    Uniform,
}

/// Mass of particles that start under pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParticleMass {
    /// ρ Δx²: every particle fills its lattice cell.
    FromDensity,
    /// ρ₀ Δx².
    Rest,
}

#[derive(Clone, Copy)]
enum StartKind {
    Rest,
    Hydrostatic,
    Pressure,
}

impl RegionTable {
    fn read(mut table: Table<'_>) -> Self {
        // Beyond half a spacing particles would change places.
        const DISPLACEMENT: Allowed =
            Allowed::new(0.0, 0.5, (true, false), 0.0, "a number from 0 to below 0.5");
        let name = table.name("name");
        let shape = ShapeTable::read(&mut table, "shape");
        let velocity_m_s = formula::read_pair(&mut table, "velocity_m_s", &["x", "y"])
            .unwrap_or_else(|| formula::zeros(&table.place_of("velocity_m_s")));
        let start = StartTable::read(&mut table);
        let cut_by_solids = table.flag_or("cut_by_solids", true);
        let cut_by_walls = table.flag_or("cut_by_walls", true);
        let lattice_origin_m = table.optional_vector("lattice_origin_m");
        let displacement_fraction = table.number_or("displacement_fraction", &DISPLACEMENT, 0.0).value;
        // TOML integers have 63 bits.
        let displacement_seed = table.count_or("displacement_seed", 0..1 << 62, 1).value;
        Self {
            name,
            shape,
            velocity_m_s,
            start,
            cut_by_solids,
            cut_by_walls,
            lattice_origin_m,
            displacement_fraction,
            displacement_seed,
            intact: table.finish(),
        }
    }
}

impl StartTable {
    fn read(parent: &mut Table<'_>) -> Self {
        let Some(mut table) = parent.optional_table("start") else { return Self::Rest };
        let kinds = [
            ("rest", StartKind::Rest),
            ("hydrostatic", StartKind::Hydrostatic),
            ("pressure", StartKind::Pressure),
        ];
        let read = match table.choice("type", &kinds).map(|choice| choice.value) {
            Some(StartKind::Hydrostatic) => Self::Hydrostatic {
                surface_m: table.number("surface_m", &Allowed::FINITE).value,
                lattice: table.choice_or_first(
                    "lattice",
                    &[
                        ("consistent", HydrostaticLattice::Consistent),
                        ("uniform", HydrostaticLattice::Uniform),
                    ],
                ),
            },
            Some(StartKind::Pressure) => Self::Pressure {
                pressure_pa: formula::read(&mut table, "pressure_pa", &["x", "y"]),
                particle_mass: table.choice_or_first(
                    "particle_mass",
                    &[("from-density", ParticleMass::FromDensity), ("rest", ParticleMass::Rest)],
                ),
            },
            Some(StartKind::Rest) => Self::Rest,
            None => {
                table.abandon();
                Self::Rest
            }
        };
        table.finish();
        read
    }
}
