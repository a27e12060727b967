//! Set-up of a solid solver.

use super::parameters::{choices, parameters};
use super::{
    Allowed, Damping, Motion, ParameterSpec as Row, RunSetup, SolidParticles, SolidProbe, Value,
    WallParticles, WallSetup,
};
use crate::space::{Plane, Space};

use Value::{Choice, Flag, Number};

/// Below 0.6 the support does not reach past the nearest neighbours by a margin.
const STENCIL_RATIO: Allowed = Allowed::new(0.6, 3.0, (true, true), "a number from 0.6 to 3");

const STRESS_EXPONENT: Allowed = Allowed::new(0.0, 20.0, (false, true), "a number above 0 and at most 20");

/// Largest contact distance in particle spacings \[-\]: beyond, pairs in contact cost more than finer bodies would.
pub const LARGEST_CONTACT_DISTANCE: f64 = 10.0;

const DISTANCE: Allowed =
    Allowed::new(0.0, LARGEST_CONTACT_DISTANCE, (false, true), "a number above 0 and at most 10");

/// Set-up of a solid solver.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidSetup<S: Space = Plane> {
    /// Common part.
    pub run: RunSetup<S>,
    /// Spacing of the particles Δx \[m\].
    pub particle_spacing: f64,
    /// Bodies; `SolidParticles::body` indexes them.
    pub bodies: Vec<BodySetup<S>>,
    /// Particles of all bodies at the start.
    pub particles: SolidParticles<S>,
    /// How bodies touch each other and walls.
    pub contact: ContactLaw,
    /// Walls as the solids meet them; `wall_particles.wall` indexes them.
    pub walls: Vec<WallSetup<S>>,
    /// Wall particles that a solid can touch.
    pub wall_particles: WallParticles<S>,
    /// Linear damping of the start; an account of the ledger.
    pub damping: Option<Damping>,
    /// How the solids advance within a step.
    pub stepping: SolidStepping,
    /// What to report at probe times.
    pub probes: Vec<SolidProbe<S>>,
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
pub struct BodySetup<S: Space = Plane> {
    /// Name.
    pub name: String,
    /// Elastic constants.
    pub material: ElasticParameters,
    /// How the body is discretised.
    pub formulation: Formulation,
    /// Supports; `SolidParticles::support` indexes them from 1, 0 is free.
    pub supports: Vec<Support<S>>,
    /// Expressions of `x`, `y`, in space `z`, and `t` for an acceleration of this body alone, added to the run's \[m/s²\].
    pub acceleration: Option<S::PerAxis<String>>,
    /// Loads on its surface.
    pub loads: Vec<SurfaceLoad<S>>,
}

/// A load on part of a body's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceLoad<S: Space = Plane> {
    /// Name.
    pub name: String,
    /// What acts there.
    pub law: LoadLaw<S>,
    /// Particle of each loaded face: index within the body.
    pub particles: Vec<u32>,
    /// Outward area vector of each face of the undeformed body \[m²\], in the plane per depth.
    pub areas: Vec<S::Vector>,
}

/// What a surface load does; expressions of `x`, `y`, in space `z` (present position), and `t`.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadLaw<S: Space = Plane> {
    /// Pressure on the deformed surface, along its present normal \[Pa\].
    Pressure(String),
    /// Force per area of the undeformed surface, of given direction \[Pa\].
    Traction(S::PerAxis<String>),
}

parameters! {
    /// Isotropic elastic constants, Eq. (5)-(7).
    pub struct ElasticParameters {
        /// Rest density ρ₀ \[kg/m³\].
        density: f64 = 1000.0, "density_kg_m3", Row::number(Allowed::POSITIVE).stated();
        /// Bulk modulus K \[Pa\].
        bulk_modulus: f64 = 1e6, "bulk_modulus_pa", Row::number(Allowed::POSITIVE).stated();
        /// Shear modulus G \[Pa\].
        shear_modulus: f64 = 1e5, "shear_modulus_pa", Row::number(Allowed::POSITIVE).stated();
        /// What holds across the plane; in space there is no such axis, and no other choice than `strain`.
        plane: PlaneState = PlaneState::Strain, "plane", Row::choice::<PlaneState>().off(Choice("strain"));
    }
}

choices! {
    /// What holds across the plane of an elastic body.
    pub enum PlaneState {
        /// No strain: a slice of a long body, or one between smooth walls.
        Strain = "strain",
        /// No stress: a thin sheet that is free to change its thickness. Masses and forces are per undeformed depth.
        Stress = "stress",
    }
}

impl ElasticParameters {
    /// Speed of longitudinal waves \[m/s\]: c_L = √((K + 4G/3)/ρ₀) in plane strain, √((λ' + 2G)/ρ₀) = √(E/((1 − ν²) ρ₀)) in
    /// plane stress, λ' of [`Self::plane_lame_constant`].
    pub fn longitudinal_speed(&self) -> f64 {
        let modulus = match self.plane {
            PlaneState::Strain => self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus,
            PlaneState::Stress => self.plane_lame_constant() + 2.0 * self.shear_modulus,
        };
        (modulus / self.density).sqrt()
    }

    /// Share β of a small change of area that remains as change of volume \[-\]: 1 in plane strain, 2G/(λ + 2G) in plane
    /// stress, where the thickness yields so that σ_zz = 0.
    pub fn volume_share(&self) -> f64 {
        match self.plane {
            PlaneState::Strain => 1.0,
            PlaneState::Stress => {
                2.0 * self.shear_modulus / (self.first_lame_constant() + 2.0 * self.shear_modulus)
            }
        }
    }

    /// First Lamé constant of Hooke's law within the plane \[Pa\]: λ in plane strain, λ' = 2Gλ/(λ + 2G) in plane stress.
    pub fn plane_lame_constant(&self) -> f64 {
        self.first_lame_constant() * self.volume_share()
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

choices! {
    /// How a body is discretised.
    pub enum FormulationKind {
        /// Deformation gradient and nominal stress in the reference configuration.
        TotalLagrangian = "total-lagrangian",
        /// That of the source paper: Eq. (5)-(8), (17), (25)-(26).
        UpdatedLagrangian = "updated-lagrangian",
        /// Keeps its shape and takes no stress: three degrees of freedom in the plane, six in space.
        Rigid = "rigid",
    }
}

/// How a body is discretised, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Formulation {
    /// Deformation gradient and nominal stress in the reference configuration.
    TotalLagrangian(TotalLagrangian),
    /// That of the source paper: Eq. (5)-(8), (17), (25)-(26).
    UpdatedLagrangian(UpdatedLagrangian),
    /// Keeps its shape and takes no stress: three degrees of freedom in the plane, six in space.
    Rigid,
}

impl Formulation {
    /// Its kind.
    pub fn kind(&self) -> FormulationKind {
        match self {
            Self::TotalLagrangian(_) => FormulationKind::TotalLagrangian,
            Self::UpdatedLagrangian(_) => FormulationKind::UpdatedLagrangian,
            Self::Rigid => FormulationKind::Rigid,
        }
    }
}

parameters! {
    /// Parameters of the updated-Lagrangian formulation, Eq. (5)-(8), (17), (25)-(26).
    pub struct UpdatedLagrangian {
        /// Kernel ratio h/Δx \[-\]; by default that of `[solid]`.
        kernel_ratio: f64 = 1.3, "kernel_ratio", Row::number(Allowed::KERNEL_RATIO);
        /// Whether the velocity gradient is corrected by L_i; without it the body cannot rotate.
        gradient_correction: bool = true, "gradient_correction", Row::flag().paper(Flag(false));
        /// Artificial viscosity A of Eq. (23) \[-\].
        viscosity_a: f64 = 1.0, "artificial_viscosity_a", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0));
        /// Artificial viscosity B of Eq. (23) \[-\].
        viscosity_b: f64 = 1.0, "artificial_viscosity_b", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0));
        /// Fraction λ of h² in the denominator of Eq. (24) \[-\].
        lambda: f64 = 0.01, "lambda", Row::number(Allowed::SHARE);
        /// Coefficient ε of the artificial stress, Eq. (25) \[-\].
        artificial_stress: f64 = 0.3, "artificial_stress", Row::number(Allowed::SHARE).off(Number(0.0));
        /// Exponent n of the artificial stress, Eq. (26) \[-\].
        artificial_stress_exponent: f64 = 4.0, "artificial_stress_exponent", Row::number(STRESS_EXPONENT);
    }
}

impl UpdatedLagrangian {
    /// Smoothing length h \[m\] of particles of `spacing` \[m\].
    pub fn smoothing_length(&self, spacing: f64) -> f64 {
        self.kernel_ratio * spacing
    }
}

parameters! {
    /// Parameters of the total-Lagrangian formulation.
    pub struct TotalLagrangian {
        /// Stress as a function of the deformation gradient.
        law: HyperelasticLaw = HyperelasticLaw::NeoHookean, "law", Row::choice::<HyperelasticLaw>();
        /// Kernel ratio h/Δx of the stencil in the undeformed body \[-\]; 0.75 has 8 neighbours in the plane, 18 in space.
        kernel_ratio: f64 = 0.75, "kernel_ratio", Row::number(STENCIL_RATIO);
        /// Hourglass coefficient ζ \[-\], as a fraction of Young's modulus.
        hourglass: f64 = 0.3, "hourglass", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0));
        /// Artificial viscosity A of Eq. (23) \[-\]; by default 0.2 where there is a fluid.
        viscosity_a: f64 = 0.0, "artificial_viscosity_a", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0));
        /// Artificial viscosity B of Eq. (23) \[-\].
        viscosity_b: f64 = 0.0, "artificial_viscosity_b", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0));
    }
}

impl TotalLagrangian {
    /// Smoothing length h \[m\] of the stencil of particles of `spacing` \[m\].
    pub fn smoothing_length(&self, spacing: f64) -> f64 {
        self.kernel_ratio * spacing
    }
}

choices! {
    /// Stress as a function of the deformation gradient F; σ_zz is that of plane strain or zero, see [`PlaneState`].
    pub enum HyperelasticLaw {
        /// σ = (G (FFᵀ − I) + λ ln J I)/J: resists compression to nothing.
        NeoHookean = "neo-hookean",
        /// S = λ tr(E) I + 2G E, E = ½(FᵀF − I): Hooke's law for large rotations and small strains.
        StVenantKirchhoff = "st-venant-kirchhoff",
    }
}

/// How held particles move.
#[derive(Clone, Debug, PartialEq)]
pub struct Support<S: Space = Plane> {
    /// Name, used by reaction probes.
    pub name: String,
    /// Components held: x, y and in space z.
    pub held: S::PerAxis<bool>,
    /// Prescribed motion of the held components, or of the pivot; `None` holds them at rest.
    pub motion: Option<Motion<S>>,
    /// A point of a rigid body, on it or off it, about which the body turns freely \[m\]; such a support holds no particles
    /// and no components, and is the only one of its body.
    pub pivot: Option<S::Vector>,
    /// The support ceases to act at this time \[s\].
    pub release_time: Option<f64>,
}

choices! {
    /// How bodies touch each other and walls.
    pub enum ContactKind {
        /// Repulsion by the depth in the other that never pulls, between bodies and toward walls.
        Repulsion = "repulsion",
        /// That of the source paper: bodies interact through the sums (22), walls by its section 4.1.
        Sums = "sums",
    }
}

/// How bodies touch each other and walls, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// Repulsion by the depth in the other that never pulls, between bodies and toward walls.
    Repulsion(RepulsionParameters),
    /// That of the source paper: bodies interact through the sums (22), walls by its section 4.1.
    Sums,
}

impl ContactLaw {
    /// Its kind.
    pub fn kind(&self) -> ContactKind {
        match self {
            Self::Repulsion(_) => ContactKind::Repulsion,
            Self::Sums => ContactKind::Sums,
        }
    }
}

parameters! {
    /// Parameters of the repulsion of bodies.
    pub struct RepulsionParameters {
        /// Stiffness as a fraction of the softer bulk modulus \[-\].
        stiffness: f64 = 1.0, "stiffness", Row::number(Allowed::POSITIVE);
        /// Distance d at which it sets in, in particle spacings \[-\].
        distance: f64 = 1.0, "distance", Row::number(DISTANCE);
        /// Damping of the approach as a fraction of critical \[-\].
        damping: f64 = 0.2, "damping", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0));
        /// Coulomb's coefficient of friction \[-\].
        friction: f64 = 0.0, "friction", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0));
        /// Whether the water around presses in gaps that are too thin for its particles.
        wet: bool = true, "wet", Row::flag().off(Flag(false));
        /// Whether total-Lagrangian bodies also touch themselves.
        self_contact: bool = true, "self_contact", Row::flag().off(Flag(false));
    }
}
