//! Constants of a run, checked once.

use sph::coupling::ledger::EnergyAccount;
use sph::kernel::{CubicSpline, PairKernel};
use sph::lanes::Arithmetic;
use sph::laws::acoustic_relaxation::AcousticRelaxation;
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::laws::equation_of_state::Tait;
use sph::laws::repulsion::Repulsion;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{
    Coupling, Damping, DensityDiffusion, FluidParameters, FluidProbeKind, FluidScheme, GradientCorrection,
    OrderControl, Outflow, ViscosityForm,
};
use sph::space::Space;
use sph::space::domain::Domain;

use super::packed_particle::FluidSpace;
use super::walls::WallModel;
use crate::team::Team;

/// Constants of a run.
#[derive(Clone, Debug)]
pub struct FluidModel<S: Space> {
    /// The parts of the fluid, of which this model may be one.
    pub team: Team,
    /// Box and periodic directions.
    pub domain: Domain<S>,
    /// Constants of the fluid.
    pub constants: FluidParameters,
    /// Pressure of a density, Eq. (3).
    pub equation_of_state: Tait,
    /// Acoustic relaxation, if there is any.
    pub acoustic_relaxation: Option<AcousticRelaxation>,
    /// Smoothing kernel, Eq. (10)-(11).
    pub kernel: CubicSpline<S>,
    /// Pair laws among the fluid and toward walls.
    pub law: PairLaw,
    /// Factor on the kernel gradient of own pairs: 1/M or 1 \[-\].
    pub gradient_scale: f64,
    /// Factor on the kernel gradient where L_i is not used though own pairs use it, as toward solids: 1/M or 1 \[-\].
    pub cross_gradient_scale: f64,
    /// δ h c₀ of Eq. (18) \[m²/s\]; zero without diffusion.
    pub diffusion: f64,
    /// α c₀ h of the acoustic damper \[m²/s\]; zero without it.
    pub acoustic_diffusivity: f64,
    /// Time scheme.
    pub scheme: FluidScheme,
    /// Arithmetic path of sums over neighbours.
    pub arithmetic: Arithmetic,
    /// Form of the density diffusion.
    pub diffusion_form: DensityDiffusion,
    /// Form of viscosity.
    pub viscosity: Viscosity,
    /// The part of gravity that has a potential: the domain is not periodic along it \[m/s²\].
    pub falling: S::Vector,
    /// Accounts of the energy budget that the case can have.
    pub energy_accounts: Vec<EnergyAccount>,
    /// Body force.
    pub body_force: BodyForceField<S>,
    /// Linear damping of the start.
    pub damping: Option<Damping>,
    /// Names of the regions.
    pub regions: Vec<String>,
    /// Walls.
    pub walls: WallModel<S>,
    /// Probes.
    pub probes: Vec<Probe<S>>,
    /// Open sides.
    pub outflow: Outflow<S>,
    /// Escaped particles allowed.
    pub escaped_particle_limit: u64,
    /// Repulsion by wall faces.
    pub wall_repulsion: Repulsion,
    /// k of p/(k ρ U²), above which pressure orders the particles \[-\].
    pub ordered_by_pressure: f64,
    /// Shifting, tensile control and volume correction.
    pub regularisation: Option<OrderControl>,
    /// Facts of the interface.
    pub coupling: Option<Coupling>,
    /// Id of the first wall particle in snapshots: one beyond the fluid's largest.
    pub first_wall_id: u32,
}

/// A probe.
#[derive(Clone, Debug)]
pub enum Probe<S: Space> {
    /// Means at a point \[m\].
    Point(S::Vector),
    /// Volume flux through a segment.
    FlowRate(Segment<S>),
    /// Volume flux through a parallelogram.
    SurfaceFlux(Parallelogram<S>),
    /// All others.
    Plain(FluidProbeKind<S>),
}

/// A segment of a line.
#[derive(Clone, Copy, Debug)]
pub struct Segment<S: Space> {
    /// Its middle \[m\].
    pub middle: S::Vector,
    /// Unit vector along it.
    pub along: S::Vector,
    /// Unit vector across it, along which a flux is positive.
    pub normal: S::Vector,
    /// Length \[m\].
    pub length: f64,
}

/// A plane parallelogram in space.
#[derive(Clone, Copy, Debug)]
pub struct Parallelogram<S: Space> {
    /// One of its corners \[m\].
    pub corner: S::Vector,
    /// Edges from there \[m\].
    pub edges: [S::Vector; 2],
    /// The gradients of the coordinates along the edges, which are 1 at their ends \[1/m\].
    pub gradients: [S::Vector; 2],
    /// Unit vector across it, along which a flux is positive.
    pub normal: S::Vector,
    /// Area \[m²\].
    pub area: f64,
}

/// Form of viscosity in Eq. (22).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viscosity {
    /// Not at all.
    Inviscid,
    /// By the stress of Eq. (4).
    Stress,
    /// By a pair force.
    Pairwise,
}

impl<S: FluidSpace> FluidModel<S> {
    /// Whether T of each particle is its pressure times a symmetric tensor, and made of both pair by pair.
    pub fn has_symmetric_tensors(&self) -> bool {
        S::SYMMETRIC_TENSORS && self.has_tensors() && self.viscosity == Viscosity::Inviscid
    }
}

impl<S: Space> FluidModel<S> {
    /// Whether the gradient pass is needed at all.
    pub fn needs_gradient_pass(&self) -> bool {
        self.needs_moments() || self.needs_velocity_gradient() || self.regularises()
    }

    /// Whether neighbours read the rates of strain.
    pub fn has_strain_rates(&self) -> bool {
        self.constants.viscosity_form == ViscosityForm::Residual && self.constants.viscosity_a > 0.0
    }

    /// Whether neighbours read results of the gradient pass.
    pub fn has_neighbour_fields(&self) -> bool {
        self.needs_density_gradient() || self.has_damper() || self.regularises()
    }

    /// Whether moments are needed.
    pub fn needs_moments(&self) -> bool {
        self.needs_density_gradient()
            || self.corrects_continuity()
            || self.viscosity == Viscosity::Pairwise
            || self.has_strain_rates()
    }

    /// Whether the velocity gradient is needed.
    pub fn needs_velocity_gradient(&self) -> bool {
        self.viscosity != Viscosity::Inviscid
            || self.has_damper()
            || self.is_leapfrog()
            || self.has_strain_rates()
    }

    /// Whether momentum needs T = −σ·L as a tensor instead of a pressure.
    pub fn has_tensors(&self) -> bool {
        self.corrects_momentum() || self.viscosity != Viscosity::Inviscid
    }

    /// Whether ∇ρ of Eq. (20) is needed, for Eq. (19).
    pub fn needs_density_gradient(&self) -> bool {
        self.diffusion_form == DensityDiffusion::Renormalised
    }

    /// Whether L_i of Eq. (21) corrects Eq. (17).
    pub fn corrects_continuity(&self) -> bool {
        matches!(self.constants.correction, GradientCorrection::Continuity | GradientCorrection::Renormalised)
    }

    /// Whether L_i corrects Eq. (22) too.
    pub fn corrects_momentum(&self) -> bool {
        self.constants.correction == GradientCorrection::Renormalised
    }

    /// Whether the acoustic damper acts.
    pub fn has_damper(&self) -> bool {
        self.acoustic_diffusivity > 0.0
    }

    /// Whether particles are shifted, or their tension or volume is controlled.
    pub fn regularises(&self) -> bool {
        self.regularisation.is_some()
    }

    /// Whether the volume correction acts.
    pub fn corrects_volume(&self) -> bool {
        self.constants.volume_correction > 0.0
    }

    /// Whether the predictor computes density rates alone, in the gradient pass, and the corrector the other rates.
    pub fn is_leapfrog(&self) -> bool {
        self.scheme == FluidScheme::Leapfrog
    }

    /// Whether the corrector of leapfrog reads velocities that are extrapolated to the middle of the step.
    ///
    /// Physical viscosity needs them for second order. Explicit damping of a rate λ lowers the highest stable frequency, from
    /// 2/Δt to 2 √(1 − λΔt)/Δt with them and 2 √(1 − λΔt/2)/Δt without, and particles at a surface come near it.
    pub fn extrapolates_velocities(&self) -> bool {
        self.is_leapfrog() && !matches!(self.viscosity, Viscosity::Inviscid)
    }

    /// Rate k of the linear damping at `time` \[1/s\].
    pub fn damping_rate(&self, time: f64) -> f64 {
        self.damping.filter(|damping| time < damping.until).map_or(0.0, |damping| damping.rate)
    }

    /// ρ₀ c₀² \[Pa\].
    pub fn bulk_modulus(&self) -> f64 {
        self.constants.rest_density * self.constants.sound_speed * self.constants.sound_speed
    }
}

/// Constants of the pair laws between fluid particles.
#[derive(Clone, Copy, Debug)]
pub struct PairLaw {
    /// Kernel gradient.
    pub kernel: PairKernel,
    /// Artificial viscosity.
    pub viscosity: ArtificialViscosity,
}
