//! What is constant during a run, checked once.

use sph::body_force::BodyForceField;
use sph::domain::Domain;
use sph::equation_of_state::Tait;
use sph::kernel::{CubicSpline, PairKernel};
use sph::lanes::Arithmetic;
use sph::repulsion::Repulsion;
use sph::setup::{Coupling, Damping, FluidConstants, FluidProbe, FluidScheme, OrderControl, Outflow};

use super::walls::WallModel;

/// What is constant during a run.
#[derive(Clone, Debug)]
pub struct FluidModel {
    /// Box and periodic directions.
    pub domain: Domain,
    /// Constants of the fluid.
    pub constants: FluidConstants,
    /// Pressure of a density, Eq. (3).
    pub equation_of_state: Tait,
    /// Smoothing kernel, Eq. (10)-(11).
    pub kernel: CubicSpline,
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
    /// How it is stepped.
    pub scheme: FluidScheme,
    /// How sums over neighbours are computed.
    pub arithmetic: Arithmetic,
    /// What the gradient pass makes.
    pub passes: Passes,
    /// Body force.
    pub body_force: BodyForceField,
    /// Linear damping of the start.
    pub damping: Option<Damping>,
    /// Names of the regions.
    pub regions: Vec<String>,
    /// Walls.
    pub walls: WallModel,
    /// Probes.
    pub probes: Vec<FluidProbe>,
    /// Open sides.
    pub outflow: Outflow,
    /// Lost particles allowed.
    pub lost_particle_limit: u64,
    /// Repulsion by wall faces.
    pub wall_repulsion: Repulsion,
    /// Shifting and tensile control.
    pub order: Option<OrderControl>,
    /// Facts of the interface.
    pub coupling: Option<Coupling>,
    /// Id of the first wall particle in snapshots: one beyond the fluid's largest.
    pub first_wall_id: u32,
}

/// What the scene needs from the pass over the neighbours before the rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passes {
    /// ∇ρ of Eq. (20), for Eq. (19).
    pub density_gradient: bool,
    /// L_i of Eq. (21) in Eq. (17).
    pub correction: bool,
    /// L_i in Eq. (22) too.
    pub momentum_correction: bool,
    /// Viscous stress of Eq. (4).
    pub viscosity: bool,
    /// Pressure of the acoustic damper.
    pub damper: bool,
    /// Viscous pair force.
    pub pair_viscosity: bool,
    /// Shifting or tensile control.
    pub order: bool,
    /// Leapfrog: the pass makes the density rates, in the predictor alone, and the corrector goes on with the rest.
    pub leapfrog: bool,
}

impl Passes {
    /// Whether the pass is needed at all.
    pub fn any(self) -> bool {
        self.moments() || self.velocity_gradient() || self.order || self.leapfrog
    }

    /// Whether neighbours read results of the pass.
    pub fn shown(self) -> bool {
        self.density_gradient || self.damper || self.order
    }

    /// Whether moments are needed.
    pub fn moments(self) -> bool {
        self.density_gradient || self.correction || self.pair_viscosity
    }

    /// Whether the velocity gradient is needed.
    pub fn velocity_gradient(self) -> bool {
        self.viscosity || self.pair_viscosity || self.damper || self.leapfrog
    }

    /// Whether momentum needs T = −σ·L as a tensor instead of a pressure.
    pub fn tensor(self) -> bool {
        self.momentum_correction || self.viscosity || self.pair_viscosity
    }
}

impl FluidModel {
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
    /// Smoothing length h \[m\].
    pub smoothing_length: f64,
    /// λh² \[m²\].
    pub regularisation: f64,
    /// A c₀ \[m/s\].
    pub viscosity_a: f64,
    /// B \[-\].
    pub viscosity_b: f64,
}
