//! What a solver is told before a run: plain data in SI units, mirrored by the set-up messages of the protocol.
//!
//! The coordinator makes these from a case file; nothing in here is checked again by the solvers beyond what the
//! conversion from the wire enforces. In two dimensions masses and forces are per metre of depth.

use crate::domain::Domain;
use crate::vector::{DIMENSIONS, SymmetricTensor, Vector};

/// Set-up that both participants of a run receive alike.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSetup {
    /// Name of the run; every message carries it.
    pub run_id: String,
    /// Box and periodic directions.
    pub domain: Domain,
    /// Steps and end of the run.
    pub time: TimePlan,
    /// Acceleration acting on all matter.
    pub body_force: BodyForce,
    /// When outputs are due.
    pub outputs: OutputPlan,
    /// How ledger checks are acted on.
    pub ledger: LedgerPolicy,
    /// Facts of the interface; `None` when the run has one participant.
    pub coupling: Option<Coupling>,
}

/// Steps and end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimePlan {
    /// Time at which the run starts \[s\].
    pub start_time: f64,
    /// The run ends at the first step boundary at or after this time \[s\].
    pub end_time: f64,
    /// How a step's size is chosen.
    pub step: StepPolicy,
}

/// How a step's size is chosen; both sides apply the same rule to the same bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepPolicy {
    /// Every step has this size \[s\].
    Fixed {
        /// Step size Δt \[s\].
        time_step: f64,
    },
    /// The smaller of both solvers' limits.
    Adaptive {
        /// Fraction of the stated stability limit to use, in (0, 1].
        factor: f64,
        /// Largest step \[s\].
        maximum: f64,
        /// Largest ratio of one step to the one before it, above 1; shrinking is immediate.
        growth: f64,
    },
}

/// When outputs are due: at the first step boundary at or after each multiple of the interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputPlan {
    /// Time between snapshots \[s\]; `None` for the first and last only.
    pub snapshot_interval: Option<f64>,
    /// Time between probe rows \[s\]; `None` for the first and last only.
    pub probe_interval: Option<f64>,
}

/// What to do when a ledger check fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreachAction {
    /// Count and report it, go on.
    Warn,
    /// Stop the run.
    Stop,
}

/// Tolerances of the ledger and what a breach does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LedgerPolicy {
    /// What a breach does.
    pub action: BreachAction,
    /// Largest |F_fluid + F_solid| over gross force, and likewise for torque \[-\].
    pub balance_tolerance: f64,
    /// Largest |ΔP − impulse| over gross impulse of one side \[-\].
    pub momentum_tolerance: f64,
}

impl Default for LedgerPolicy {
    /// Stop at 1e-12 of gross: round-off of sums of some 10⁴ pair forces is near 1e-14.
    fn default() -> Self {
        Self { action: BreachAction::Stop, balance_tolerance: 1e-12, momentum_tolerance: 1e-12 }
    }
}

/// Acceleration acting on all matter: constant gravity plus an optional expression of x, y, t.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyForce {
    /// Constant part g \[m/s²\].
    pub gravity: Vector,
    /// Expressions of `x`, `y`, `t` for the components added to gravity \[m/s²\].
    pub expressions: Option<[String; DIMENSIONS]>,
}

/// Law between fluid particles and interface particles of a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterfaceLaw {
    /// Interface particles act on the fluid as wall particles with the dummy pressure of Eq. (28), and the exact
    /// reaction acts on the solid. Slip.
    Wall,
    /// As `Wall`, with viscous friction against the solid's velocity.
    WallNoSlip,
    /// One sum over all particles whoever owns them, Eq. (17), (22), (25): closest to the document's letter.
    PlainSum,
}

/// Facts of the interface that both sides must hold alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Pair law.
    pub law: InterfaceLaw,
    /// The fluid's constants; they are used for fluid-solid pairs on both sides.
    pub fluid: FluidConstants,
    /// Spacing of the solid's particles \[m\].
    pub solid_spacing: f64,
    /// Repulsion of fluid and solid particles that come closer than 0.6 of their mean spacing \[-\]; zero leaves it out.
    pub repulsion: f64,
    /// Largest distance beyond the support radius at which particles are sent to spare \[m\].
    pub margin: f64,
}

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
/// The rule damps nothing itself. A dam break with A = 1, or with A = 0.1 and the acoustic damper at 0.5, ran at 1.0;
/// with A = 0.1 alone it kept its energy at 0.6, gained 5 % at 0.7 and broke at 0.95.
const STABLE_FRACTIONS: (f64, f64) = (1.0, 0.6);

impl FluidConstants {
    /// Acoustic limit of the time step \[s\] at the largest speed `speed` \[m/s\], with the coefficient α of the
    /// acoustic damper.
    ///
    /// ```text
    /// s h/(c₀ + |v|),  s = 1 for A ≥ 0.5 or α ≥ 0.5, else 0.6
    /// ```
    pub fn acoustic_limit(&self, speed: f64, acoustic_damping: f64) -> f64 {
        let (damped, nearly_undamped) = STABLE_FRACTIONS;
        let fraction = if self.viscosity_a.max(acoustic_damping) >= 0.5 { damped } else { nearly_undamped };
        fraction * self.smoothing_length / (self.sound_speed + speed)
    }
}

/// Correction of the kernel gradient in the fluid's sums (17) and (22).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GradientCorrection {
    /// None: the document's letter.
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

/// Everything a fluid solver is told.
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
    /// Linear damping of the start; booked in the ledger.
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

/// Form of the viscous force of Eq. (4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViscousForm {
    /// Σ V_j 2μ (dW/dr)/r v_ij (Morris et al. 1997): a pair force that also damps velocities that alternate from
    /// particle to particle.
    Pairwise,
    /// Divergence of the stress of Eq. (4): the document's letter, blind to alternating velocities.
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

/// Linear damping −k v of all free particles until a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// k \[1/s\].
    pub rate: f64,
    /// Damping ends at this time \[s\].
    pub until: f64,
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

/// One wall of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct WallSetup {
    /// Name.
    pub name: String,
    /// Condition along the wall.
    pub condition: WallCondition,
    /// Prescribed motion; `None` for a wall at rest.
    pub motion: Option<Motion>,
    /// The wall ceases to act at this time \[s\].
    pub release_time: Option<f64>,
}

/// Condition along a wall, Eq. (27).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallCondition {
    /// Normal component mirrored, tangential kept.
    Slip,
    /// Both components mirrored.
    NoSlip,
}

/// Prescribed rigid motion; expressions of `t` \[s\].
///
/// The position is `pivot + R(angle)·(X − pivot) + displacement`, X the position at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Displacement components \[m\].
    pub displacement: [String; DIMENSIONS],
    /// Rotation angle, counter-clockwise \[rad\].
    pub angle: String,
    /// Centre of the rotation \[m\].
    pub pivot: Vector,
}

/// Wall particles, one entry per particle in each array.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallParticles {
    /// Index of the wall.
    pub wall: Vec<u32>,
    /// Position at the start \[m\].
    pub position: Vec<Vector>,
    /// Unit normal into the fluid \[-\]; zero where faces meet, where Eq. (27) reverses both components.
    pub normal: Vec<Vector>,
}

/// Which sides of the domain are open: x below, x above, y below, y above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outflow {
    /// Particles may leave through the lower side, by axis.
    pub lower: [bool; DIMENSIONS],
    /// Particles may leave through the upper side, by axis.
    pub upper: [bool; DIMENSIONS],
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

/// Everything a solid solver is told.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidSetup {
    /// Common part.
    pub run: RunSetup,
    /// Spacing of the particles Δx \[m\].
    pub particle_spacing: f64,
    /// Bodies; `SolidParticles::body` indexes them.
    pub bodies: Vec<BodySetup>,
    /// Particles of all bodies at the start.
    pub particles: SolidParticles,
    /// How bodies touch each other and walls.
    pub contact: ContactLaw,
    /// Walls as the solids meet them; `wall_particles.wall` indexes them.
    pub walls: Vec<WallSetup>,
    /// Wall particles that a solid can touch.
    pub wall_particles: WallParticles,
    /// Linear damping of the start; booked in the ledger.
    pub damping: Option<Damping>,
    /// How the solids advance within a step.
    pub stepping: SolidStepping,
    /// What to report at probe times.
    pub probes: Vec<SolidProbe>,
    /// The run stops when more particles than this leave the domain.
    pub lost_particle_limit: u64,
}

/// How the solids advance within one step of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidStepping {
    /// By the stage rule itself, Eq. (30)-(31). Weakly unstable without artificial viscosity.
    StageRule,
    /// By velocity-Verlet sub-steps under the frozen force of the fluid: half of them in the predictor, all in the
    /// corrector.
    Substeps(SubstepCount),
}

/// Number of sub-steps per step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubstepCount {
    /// This many, an even number.
    Fixed(u32),
    /// As many as the solid's own limit asks for.
    Automatic,
}

/// One body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySetup {
    /// Name.
    pub name: String,
    /// Elastic constants.
    pub material: ElasticMaterial,
    /// How the body is discretised.
    pub formulation: Formulation,
    /// Supports; `SolidParticles::support` indexes them from 1, 0 is free.
    pub supports: Vec<Support>,
    /// Expressions of `x`, `y`, `t` for an acceleration of this body alone, added to the run's \[m/s²\].
    pub acceleration: Option<[String; DIMENSIONS]>,
    /// Loads on its surface.
    pub loads: Vec<SurfaceLoad>,
}

/// A load on part of a body's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceLoad {
    /// Name.
    pub name: String,
    /// What acts there.
    pub law: LoadLaw,
    /// Particle of each loaded face: index within the body.
    pub particles: Vec<u32>,
    /// Outward area vector of each face of the undeformed body per depth \[m\].
    pub areas: Vec<Vector>,
}

/// What a surface load does; expressions of `x`, `y` (present position) and `t`.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadLaw {
    /// Pressure on the deformed surface, along its present normal \[Pa\].
    Pressure(String),
    /// Force per area of the undeformed surface, of given direction \[Pa\].
    Traction([String; DIMENSIONS]),
}

/// Isotropic elastic constants, Eq. (5)-(7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticMaterial {
    /// Rest density ρ₀ \[kg/m³\].
    pub density: f64,
    /// Bulk modulus K \[Pa\].
    pub bulk_modulus: f64,
    /// Shear modulus G \[Pa\].
    pub shear_modulus: f64,
}

impl ElasticMaterial {
    /// Speed of longitudinal waves c_L = √((K + 4G/3)/ρ₀) \[m/s\].
    pub fn longitudinal_speed(&self) -> f64 {
        ((self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus) / self.density).sqrt()
    }

    /// Young's modulus E = 9KG/(3K + G) \[Pa\].
    pub fn young_modulus(&self) -> f64 {
        9.0 * self.bulk_modulus * self.shear_modulus / (3.0 * self.bulk_modulus + self.shear_modulus)
    }

    /// First Lamé constant λ = K − 2G/3 \[Pa\].
    pub fn first_lame_constant(&self) -> f64 {
        self.bulk_modulus - 2.0 / 3.0 * self.shear_modulus
    }
}

/// How a body is discretised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Formulation {
    /// The document's: Eq. (5)-(8), (17), (25)-(26).
    UpdatedLagrangian(UpdatedLagrangian),
    /// Deformation gradient and nominal stress in the reference configuration.
    TotalLagrangian(TotalLagrangian),
    /// Moves with three degrees of freedom and takes no stress.
    Rigid,
}

/// Constants of the updated-Lagrangian formulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpdatedLagrangian {
    /// Smoothing length h \[m\].
    pub smoothing_length: f64,
    /// Whether the velocity gradient is corrected by L_i; without it the body cannot rotate.
    pub gradient_correction: bool,
    /// Artificial viscosity A of Eq. (23) \[-\].
    pub viscosity_a: f64,
    /// Artificial viscosity B of Eq. (23) \[-\].
    pub viscosity_b: f64,
    /// λ of Eq. (24) \[-\].
    pub lambda: f64,
    /// ε of the artificial stress, Eq. (25) \[-\]; zero leaves it out.
    pub artificial_stress: f64,
    /// n of Eq. (26) \[-\].
    pub artificial_stress_exponent: f64,
}

/// Constants of the total-Lagrangian formulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TotalLagrangian {
    /// Smoothing length h of the stencil in the reference configuration \[m\].
    pub smoothing_length: f64,
    /// Stress as a function of the deformation gradient.
    pub law: HyperelasticLaw,
    /// Hourglass coefficient ζ \[-\]; zero leaves the control out.
    pub hourglass: f64,
    /// Artificial viscosity A of Eq. (23) \[-\].
    pub viscosity_a: f64,
    /// Artificial viscosity B of Eq. (23) \[-\].
    pub viscosity_b: f64,
}

/// Stress as a function of the deformation gradient F, in plane strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HyperelasticLaw {
    /// S = λ tr(E) I + 2G E, E = ½(FᵀF − I): Hooke's law for large rotations and small strains.
    StVenantKirchhoff,
    /// σ = (G (FFᵀ − I) + λ ln J I)/J: resists compression to nothing.
    NeoHookean,
}

/// How held particles move.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Name, used by reaction probes.
    pub name: String,
    /// Components held: x, y.
    pub held: [bool; DIMENSIONS],
    /// Prescribed motion of the held components; `None` holds them at rest.
    pub motion: Option<Motion>,
    /// The support ceases to act at this time \[s\].
    pub release_time: Option<f64>,
}

/// Solid particles, one entry per particle in each array; particles of a body are contiguous, bodies in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolidParticles {
    /// Identity, unique among the solid's particles, ascending.
    pub id: Vec<u32>,
    /// Index of the body.
    pub body: Vec<u32>,
    /// 0 free, k the body's support k−1.
    pub support: Vec<u32>,
    /// Mass per depth \[kg/m\].
    pub mass: Vec<f64>,
    /// Position in the undeformed body \[m\]: displacements and material points refer to it.
    pub reference_position: Vec<Vector>,
    /// Position \[m\].
    pub position: Vec<Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Deviatoric stress s \[Pa\].
    pub deviatoric_stress: Vec<SymmetricTensor>,
}

/// How bodies touch each other and walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// Central repulsion that never pulls, between bodies and toward walls.
    Repulsion {
        /// Stiffness as a fraction of the softer bulk modulus \[-\].
        stiffness: f64,
        /// Distance at which it sets in, in particle spacings \[-\].
        distance: f64,
        /// Damping of the approach as a fraction of critical \[-\].
        damping: f64,
    },
    /// The document's: bodies meet in the sums (22), walls by section 4.1.
    Sums,
}

/// A named quantity of the solids to report at probe times; columns per kind are fixed by `columns`.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidProbe {
    /// Name of the probe.
    pub name: String,
    /// What it reports.
    pub kind: SolidProbeKind,
}

/// What a solid probe reports.
#[derive(Clone, Debug, PartialEq)]
pub enum SolidProbeKind {
    /// Displacement, velocity and stress of the material at a reference position \[m\] of a body (index).
    MaterialPoint {
        /// Index of the body.
        body: u32,
        /// Position in the undeformed body \[m\].
        reference_position: Vector,
    },
    /// Centre of mass, velocity, angle and angular velocity of a body (index).
    Motion(u32),
    /// Force of the fluid on a body (index) per metre of depth.
    BodyForce(u32),
    /// Reaction of a support (body index, support index) on the body per metre of depth.
    Reaction {
        /// Index of the body.
        body: u32,
        /// Index of the body's support.
        support: u32,
    },
    /// Mass, momentum, energies and second moments of a body (index), or of all (`None`).
    Sums(Option<u32>),
    /// Smallest distance from a particle of a body (index), or of any (`None`), to another body and to a wall.
    Gap(Option<u32>),
}

impl SolidProbeKind {
    /// Column suffixes `<quantity>_<unit>` in the order in which values are reported.
    pub fn columns(&self) -> &'static [&'static str] {
        match self {
            Self::MaterialPoint { .. } => &[
                "displacement_x_m",
                "displacement_y_m",
                "velocity_x_m_s",
                "velocity_y_m_s",
                "stress_xx_pa",
                "stress_yy_pa",
                "stress_xy_pa",
            ],
            Self::Motion(_) => &[
                "centre_x_m",
                "centre_y_m",
                "velocity_x_m_s",
                "velocity_y_m_s",
                "angle_rad",
                "angular_velocity_rad_s",
            ],
            Self::BodyForce(_) | Self::Reaction { .. } => &["force_x_n_per_m", "force_y_n_per_m"],
            Self::Sums(_) => &[
                "mass_kg_per_m",
                "momentum_x_kg_per_s",
                "momentum_y_kg_per_s",
                "angular_momentum_kg_m_per_s",
                "kinetic_energy_j_per_m",
                "potential_energy_j_per_m",
                "strain_energy_j_per_m",
                "centre_x_m",
                "centre_y_m",
                "second_moment_xx_m2",
                "second_moment_yy_m2",
                "second_moment_xy_m2",
            ],
            Self::Gap(_) => &["gap_body_m", "gap_wall_m"],
        }
    }
}

/// Set-up of either participant.
#[derive(Clone, Debug, PartialEq)]
pub enum ParticipantSetup {
    /// For a fluid solver.
    Fluid(FluidSetup),
    /// For a solid solver.
    Solid(SolidSetup),
}

impl ParticipantSetup {
    /// The part that both participants receive alike.
    pub fn run(&self) -> &RunSetup {
        match self {
            Self::Fluid(setup) => &setup.run,
            Self::Solid(setup) => &setup.run,
        }
    }
}
