//! Set-up of a fluid solver.

use super::{Damping, Outflow, RunSetup, WallParticles, WallSetup};
use crate::laws::artificial_viscosity::ArtificialViscosity;
use crate::space::Vector;

/// Equation of state and pair constants of a fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidConstants {
    /// Rest density ρ₀ \[kg/m³\].
    pub rest_density: f64,
    /// Sound speed c₀ \[m/s\].
    pub sound_speed: f64,
    /// Exponent γ of Eq. (3) \[-\].
    pub exponent: f64,
    /// Dynamic viscosity μ \[Pa s\]; zero leaves the viscous pass out.
    pub dynamic_viscosity: f64,
    /// Smoothing length h \[m\].
    pub smoothing_length: f64,
    /// Particle spacing Δx \[m\].
    pub particle_spacing: f64,
    /// Artificial viscosity A of Eq. (23) \[-\].
    pub viscosity_a: f64,
    /// Artificial viscosity B of Eq. (23) \[-\].
    pub viscosity_b: f64,
    /// λ of Eq. (19) and (24) \[-\].
    pub lambda: f64,
    /// Correction of the kernel gradient.
    pub correction: GradientCorrection,
}

/// Fraction of h/(c₀ + |v|) up to which the midpoint rule runs a violent flow, with sound damped and nearly undamped.
///
/// The rule damps nothing itself. A dam break with A = 1, or with A = 0.1 and the acoustic damper at 0.4, ran at 1.0;
/// with A = 0.1 alone it kept its energy at 0.6, gained 5 % at 0.7 and broke at 0.95.
const MIDPOINT_FRACTIONS: (f64, f64) = (1.0, 0.6);

/// The same for leapfrog without the acoustic damper.
///
/// Sixteen dam breaks thrown against the wall and back to 2 s, at 1.05, gained 0.02 % of their energy on average and 0.1 %
/// at most; at 1.25 one gained 0.6 %, at 1.35 6 %, and at 1.5 it broke.
const LEAPFROG_FRACTION: f64 = 1.2;

impl FluidConstants {
    /// The artificial viscosity of this fluid.
    pub fn artificial_viscosity(&self) -> ArtificialViscosity {
        let linear = self.viscosity_a * self.sound_speed;
        ArtificialViscosity::new(self.smoothing_length, linear, self.viscosity_b, self.lambda)
    }

    /// Acoustic limit of the time step \[s\] at the largest speed `speed` \[m/s\], with the coefficient α of the
    /// acoustic damper.
    ///
    /// ```text
    /// s h/(c₀ + |v|)
    /// leapfrog: s = √(α² + 1.2²) − α
    /// predictor-corrector: s = 1 for A ≥ 0.5 or α ≥ 0.4, else 0.6; at most h/(α c₀)
    /// ```
    /// Leapfrog takes the damper from the start of the step, which is stable for (ωΔt)² (1/4 + α/(2s)) < 1.
    pub fn acoustic_limit(&self, speed: f64, acoustic_damping: f64, scheme: FluidScheme) -> f64 {
        let (h, c0, alpha) = (self.smoothing_length, self.sound_speed, acoustic_damping);
        match scheme {
            FluidScheme::Leapfrog => (alpha.hypot(LEAPFROG_FRACTION) - alpha) * h / (c0 + speed),
            FluidScheme::PredictorCorrector => {
                let (damped, nearly_undamped) = MIDPOINT_FRACTIONS;
                let fraction = if self.viscosity_a >= 0.5 || alpha >= 0.4 { damped } else { nearly_undamped };
                let by_damper = if alpha > 0.0 { h / (alpha * c0) } else { f64::INFINITY };
                by_damper.min(fraction * h / (c0 + speed))
            }
        }
    }
}

/// Correction of the kernel gradient in the fluid's sums (17) and (22).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GradientCorrection {
    /// None, as in the source paper.
    None,
    /// ∇W divided by the lattice moment M, a constant.
    LatticeMoment,
    /// L_i of Eq. (21) in (17), ∇W divided by M in (22).
    Continuity,
    /// L_i of Eq. (21) in (17), p_i L_i + p_j L_j in (22); fluid-solid pairs use M.
    Renormalised,
}

/// Density diffusion of Eq. (18).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DensityDiffusion {
    /// None.
    None,
    /// ψ without the gradient bracket (Molteni & Colagrossi 2009), coefficient δ.
    Plain {
        /// δ \[-\].
        delta: f64,
    },
    /// ψ of Eq. (19) with the renormalised gradients (Marrone 2011), coefficient δ.
    Renormalised {
        /// δ \[-\].
        delta: f64,
    },
}

/// Set-up of a fluid solver.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidSetup {
    /// Common part.
    pub run: RunSetup,
    /// Constants of the fluid.
    pub constants: FluidConstants,
    /// Density diffusion.
    pub diffusion: DensityDiffusion,
    /// α of the acoustic damper, a bulk viscosity α ρ c₀ h on ∇·v \[-\]; zero leaves it out.
    pub acoustic_damping: f64,
    /// Repulsion by wall faces of particles that come closer than Δx/10 to a face \[-\]; zero leaves it out.
    pub wall_repulsion: f64,
    /// Form of the viscous force.
    pub viscous_form: ViscousForm,
    /// Shifting and tensile control; `None` leaves both out.
    pub order: Option<OrderControl>,
    /// How it is stepped.
    pub scheme: FluidScheme,
    /// Largest tension that the fluid bears \[Pa\], see [`crate::laws::equation_of_state::Tait::bearing`]; `None` for all that
    /// Eq. (3) gives.
    pub tension_limit: Option<f64>,
    /// Linear damping of the start; an account of the ledger.
    pub damping: Option<Damping>,
    /// Names of the fluid regions; `FluidParticles::region` indexes them.
    pub regions: Vec<String>,
    /// Walls; `WallParticles::wall` indexes them.
    pub walls: Vec<WallSetup>,
    /// Fluid particles at the start.
    pub particles: FluidParticles,
    /// Wall particles at the start.
    pub wall_particles: WallParticles,
    /// What to report at probe times.
    pub probes: Vec<FluidProbe>,
    /// Sides of the domain through which particles may leave; other crossings count as lost.
    pub outflow: Outflow,
    /// The run stops when more particles than this are lost.
    pub lost_particle_limit: u64,
}

/// How the fluid goes through the two stages of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluidScheme {
    /// Density is advanced in the predictor and velocity in the corrector, half a step apart: one sum for each.
    Leapfrog,
    /// All rates in both stages, exactly as Eq. (30)-(31).
    PredictorCorrector,
}

/// Form of the viscous force of Eq. (4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViscousForm {
    /// Σ V_j 2μ (dW/dr)/r v_ij (Morris et al. 1997): a pair force that also damps velocities that alternate from
    /// particle to particle.
    Pairwise,
    /// Divergence of the stress of Eq. (4): exactly as the source paper, blind to alternating velocities.
    Stress,
}

/// Control of the order of fluid particles, off at and near the free surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderControl {
    /// Coefficient C of the shifting \[-\] (Lind et al. 2012; Sun et al. 2017).
    pub shifting: f64,
    /// Whether pairs of negative pressure push apart instead of pulling together (Sun et al. 2018).
    pub tensile_control: bool,
}

/// Fluid particles, one entry per particle in each array.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FluidParticles {
    /// Identity, unique among the fluid's particles, ascending.
    pub id: Vec<u32>,
    /// Index of the region.
    pub region: Vec<u32>,
    /// Mass per depth \[kg/m\].
    pub mass: Vec<f64>,
    /// Position \[m\].
    pub position: Vec<Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
}

/// A named quantity of the fluid to report at probe times; columns per kind are fixed by `columns`.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidProbe {
    /// Name of the probe.
    pub name: String,
    /// What it reports.
    pub kind: FluidProbeKind,
}

/// What a fluid probe reports.
#[derive(Clone, Debug, PartialEq)]
pub enum FluidProbeKind {
    /// Shepard-normalised pressure and velocity at a point \[m\].
    Point(Vector),
    /// Highest water at this x \[m\].
    WaterLevel(f64),
    /// 99.5 percentile of x of the connected fluid.
    Front,
    /// Mass, momentum, energies and second moments of a region (index), or of all fluid (`None`).
    Region(Option<u32>),
    /// Force of the fluid on a wall (index) per metre of depth.
    WallForce(u32),
    /// Number of fluid particles inside solids.
    Immersed,
}

impl FluidProbeKind {
    /// Column suffixes `<quantity>_<unit>` in the order in which values are reported.
    pub fn columns(&self) -> &'static [&'static str] {
        match self {
            Self::Point(_) => &["pressure_pa", "velocity_x_m_s", "velocity_y_m_s"],
            Self::WaterLevel(_) => &["level_m"],
            Self::Front => &["front_x_m"],
            Self::Region(_) => &[
                "mass_kg_per_m",
                "momentum_x_kg_per_s",
                "momentum_y_kg_per_s",
                "angular_momentum_kg_m_per_s",
                "kinetic_energy_j_per_m",
                "potential_energy_j_per_m",
                "compression_energy_j_per_m",
                "centre_x_m",
                "centre_y_m",
                "second_moment_xx_m2",
                "second_moment_yy_m2",
                "second_moment_xy_m2",
            ],
            Self::WallForce(_) => &["force_x_n_per_m", "force_y_n_per_m"],
            Self::Immersed => &["immersed_count"],
        }
    }
}
