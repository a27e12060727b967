//! The handshake in types of the program: what participants declare before a run.

use std::fmt;
use std::time::Duration;

use sph::coupling::audit::PartnerParticles;
use sph::coupling::exchange::{Extent, FrameContent};
use sph::coupling::solver::{Counts, Role};
pub use sph::setup::CouplingKind;
use sph::setup::{BodyForcePlan, Coupling, DomainPlan, InterfaceLaw, RunPlan, TimePlan};
use sph::space::{AnySpace, SymmetricTensor3};

/// Version of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ProtocolVersion {
    /// Peers of one major version understand each other.
    pub major: u32,
    /// Features of a higher minor version are used when both sides have it.
    pub minor: u32,
}

/// Version that this crate speaks.
pub const PROTOCOL: ProtocolVersion = ProtocolVersion { major: 2, minor: 0 };

impl fmt::Display for ProtocolVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// A field of interface states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameField {
    /// x \[m\].
    Position,
    /// v \[m/s\].
    Velocity,
    /// ρ \[kg/m³\].
    Density,
    /// p \[Pa\].
    Pressure,
    /// σ \[Pa\].
    Stress,
    /// Volume of a coupling point \[m³\].
    Volume,
    /// Force on a coupling point \[N\].
    Force,
}

impl FrameField {
    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Density => "density",
            Self::Pressure => "pressure",
            Self::Stress => "stress",
            Self::Volume => "volume",
            Self::Force => "force",
        }
    }

    /// SI unit as the protocol spells it.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Position => "m",
            Self::Velocity => "m/s",
            Self::Density => "kg/m3",
            Self::Pressure | Self::Stress => "Pa",
            Self::Volume => "m3",
            Self::Force => "N",
        }
    }

    /// The field as the protocol defines it for runs of `dimensions` dimensions.
    pub fn spec(self, dimensions: usize) -> FieldSpec {
        FieldSpec { field: self, unit: self.unit().into(), components: self.components(dimensions) }
    }

    /// Numbers per particle in runs of `dimensions` dimensions.
    pub fn components(self, dimensions: usize) -> u32 {
        let spatial = dimensions == 3;
        match self {
            Self::Position | Self::Velocity | Self::Force => 2 + u32::from(spatial),
            Self::Stress => 3 + 3 * u32::from(spatial),
            Self::Density | Self::Pressure | Self::Volume => 1,
        }
    }

    /// Fields that the frames of `role` carry under `law` and `kind`.
    pub fn sent_by(role: Role, law: InterfaceLaw, kind: CouplingKind) -> &'static [FrameField] {
        use FrameField::{Density, Force, Position, Pressure, Stress, Velocity, Volume};
        match (kind, role, law) {
            (CouplingKind::Loads, Role::Fluid, _) => &[Force],
            (CouplingKind::Loads, Role::Solid, _) => &[Position, Velocity, Volume],
            (CouplingKind::States, Role::Solid, InterfaceLaw::PlainSum) => {
                &[Position, Velocity, Density, Pressure, Stress]
            }
            (CouplingKind::States, ..) => &[Position, Velocity, Density, Pressure],
        }
    }

    /// Content of frames with these fields.
    pub fn content(fields: &[FrameField]) -> FrameContent {
        if fields.contains(&FrameField::Force) {
            FrameContent::Forces
        } else if fields.contains(&FrameField::Volume) {
            FrameContent::CouplingPoints
        } else {
            FrameContent::States
        }
    }
}

/// A field as a participant declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldSpec {
    /// Which field.
    pub field: FrameField,
    /// SI unit as the protocol spells it.
    pub unit: String,
    /// Numbers per particle.
    pub components: u32,
}

/// What a solver offers beyond the minimum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// Checkpoint and restore.
    pub checkpoint: bool,
    /// The same set-up gives the same bits on any number of threads.
    pub deterministic: bool,
    /// Steps of changing size.
    pub adaptive_step: bool,
    /// Steps that are shortened to meet exact times.
    pub exact_times: bool,
    /// Evaluates expressions.
    pub expressions: bool,
    /// Implicit coupling in its role.
    pub implicit_coupling: bool,
}

/// Sizes and times that a server keeps to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Runs at a time.
    pub runs: u32,
    /// Largest message of the control plane \[bytes\].
    pub max_message_bytes: u64,
    /// Largest half-step frame \[bytes\].
    pub max_frame_bytes: u64,
    /// A run that is not being stepped ends when no call came for this long.
    pub lease: Duration,
}

/// What a solver is and can do.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Name of the program.
    pub name: String,
    /// Its version.
    pub version: String,
    /// What else tells builds apart.
    pub build: String,
    /// Language in which it is written.
    pub language: String,
    /// Lowest and highest protocol version that it understands.
    pub protocols: [ProtocolVersion; 2],
    /// Roles that it can take.
    pub roles: Vec<Role>,
    /// Numbers of space dimensions of the runs that it takes.
    pub dimensions: Vec<u32>,
    /// Kinds of coupling that it offers.
    pub coupling_kinds: Vec<CouplingKind>,
    /// Interface laws that it offers.
    pub interface_laws: Vec<InterfaceLaw>,
    /// How floating-point sums are made.
    pub arithmetic: String,
    /// What it offers beyond the minimum.
    pub capabilities: Capabilities,
    /// Sizes and times that it keeps to.
    pub limits: Limits,
}

/// Constants that both sides must hold alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants {
    /// Name of the kernel.
    pub kernel: String,
    /// Acceleration acting on all matter.
    pub body_force: BodyForcePlan,
    /// Facts of the interface; `None` without a partner.
    pub coupling: Option<Coupling>,
    /// Box and periodic directions.
    pub domain: DomainPlan,
    /// Steps and end of the run.
    pub time: TimePlan,
}

impl Constants {
    /// Constants of a solver that takes every one from `run` unchanged.
    pub fn of(run: &RunPlan) -> Self {
        Self {
            kernel: sph::kernel::NAME.into(),
            body_force: run.body_force.clone(),
            coupling: run.coupling,
            domain: run.domain.clone(),
            time: run.time.clone(),
        }
    }
}

/// A number for the run header.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// SI unit.
    pub unit: String,
}

/// What a solver will really do in an opened run.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenReport {
    /// Run that was opened.
    pub run_id: String,
    /// Role that it takes.
    pub role: Role,
    /// Protocol version that it speaks.
    pub protocol: ProtocolVersion,
    /// Name of the program.
    pub name: String,
    /// Its version.
    pub version: String,
    /// How floating-point sums are made.
    pub arithmetic: String,
    /// Kind of coupling that it uses.
    pub coupling_kind: CouplingKind,
    /// Constants that it really uses.
    pub constants: Constants,
    /// Interface fields that it sends.
    pub fields_sent: Vec<FieldSpec>,
    /// Interface fields that it needs from its partner.
    pub fields_needed: Vec<FieldSpec>,
    /// Where its particles are at the start.
    pub extent: Extent,
    /// Largest stable first step \[s\].
    pub time_step_limit: f64,
    /// Particles at the start.
    pub counts: Counts,
    /// Further numbers for the run header.
    pub facts: Vec<Fact>,
    /// Mass and inertia of each body of a solid, in the order of its set-up; empty from a fluid.
    pub bodies: Vec<BodyReport>,
    /// What deserves a second look about the start, in words; 16 of them are read.
    pub remarks: Vec<String>,
}

/// Mass and inertia of a body as its equations of motion use them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyReport {
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia of a rigid body about its centre of mass \[kg m²\].
    pub inertia: Option<Inertia>,
}

/// A moment of inertia about an axis across the plane, or the tensor of inertia in space \[kg m²\].
pub type Inertia = AnySpace<f64, SymmetricTensor3>;

/// Where the partner of a participant is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Partner {
    /// There is none.
    Alone,
    /// It listens at this address.
    Dial(String),
    /// It will call.
    Listen,
}

/// What a participant learns of its partner.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkPlan {
    /// Smaller of both sides' limits for the first step \[s\].
    pub first_limit: f64,
    /// The partner's extent at the start; empty without partner.
    pub partner_extent: Extent,
    /// Set-up of a solid partner, for the audit of its frames; `None` for a solid and without partner.
    pub partner_particles: Option<PartnerParticles>,
    /// Where the partner is.
    pub partner: Partner,
}
