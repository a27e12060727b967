//! Set-up that both participants share.

use super::{FluidParameters, ImplicitCoupling};
use crate::space::components::Components;
use crate::space::domain::Domain;
use crate::space::{Plane, Space};

/// Set-up that both participants of a run receive alike.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSetup<S: Space = Plane> {
    /// Name of the run; every message carries it.
    pub run_id: String,
    /// Box and periodic directions.
    pub domain: Domain<S>,
    /// Steps and end of the run.
    pub time: TimePlan,
    /// Acceleration acting on all matter.
    pub body_force: BodyForce<S>,
    /// When outputs are due.
    pub outputs: OutputPlan,
    /// How ledger checks are acted on.
    pub ledger: LedgerPolicy,
    /// Facts of the interface; `None` when the run has one participant.
    pub coupling: Option<Coupling>,
}

/// The set-up of a run in numbers alone, whatever its dimensions: what the driver, the handshake and messages need.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPlan {
    /// Name of the run; every message carries it.
    pub run_id: String,
    /// Box and periodic directions.
    pub domain: DomainPlan,
    /// Steps and end of the run.
    pub time: TimePlan,
    /// Acceleration acting on all matter.
    pub body_force: BodyForcePlan,
    /// When outputs are due.
    pub outputs: OutputPlan,
    /// How ledger checks are acted on.
    pub ledger: LedgerPolicy,
    /// Facts of the interface; `None` when the run has one participant.
    pub coupling: Option<Coupling>,
}

/// A [`Domain`] in numbers, one for each axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DomainPlan {
    /// Lower corner \[m\].
    pub lower: Vec<f64>,
    /// Upper corner \[m\].
    pub upper: Vec<f64>,
    /// Directions in which the scene repeats.
    pub periodic: Vec<bool>,
}

impl DomainPlan {
    /// The numbers of `domain`.
    pub fn of<S: Space>(domain: &Domain<S>) -> Self {
        Self {
            lower: domain.lower.row().as_ref().to_vec(),
            upper: domain.upper.row().as_ref().to_vec(),
            periodic: (0..S::DIMENSIONS).map(|axis| domain.periodic[axis]).collect(),
        }
    }

    /// Whether any direction is periodic.
    pub fn is_periodic(&self) -> bool {
        self.periodic.contains(&true)
    }
}

/// A [`BodyForce`] in numbers, one for each axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyForcePlan {
    /// Constant part g \[m/s²\].
    pub gravity: Vec<f64>,
    /// Expressions for the components added to gravity \[m/s²\].
    pub expressions: Option<Vec<String>>,
}

impl RunPlan {
    /// Number of dimensions.
    pub fn dimensions(&self) -> usize {
        self.domain.lower.len()
    }

    /// The set-up in the space `S`; `None` for a plan of another number of dimensions.
    pub fn to_setup<S: Space>(&self) -> Option<RunSetup<S>> {
        let vector = |row: &[f64]| <S::Vector as Components>::of_row(row);
        let expressions = self.body_force.expressions.as_ref();
        if self.domain.periodic.len() != S::DIMENSIONS
            || expressions.is_some_and(|expressions| expressions.len() != S::DIMENSIONS)
        {
            return None;
        }
        Some(RunSetup {
            run_id: self.run_id.clone(),
            domain: Domain {
                lower: vector(&self.domain.lower)?,
                upper: vector(&self.domain.upper)?,
                periodic: S::axes(|axis| self.domain.periodic[axis]),
            },
            time: self.time.clone(),
            body_force: BodyForce {
                gravity: vector(&self.body_force.gravity)?,
                expressions: expressions.map(|expressions| S::per_axis(|axis| expressions[axis].clone())),
            },
            outputs: self.outputs.clone(),
            ledger: self.ledger,
            coupling: self.coupling,
        })
    }
}

impl<S: Space> RunSetup<S> {
    /// The same in numbers alone.
    pub fn plan(&self) -> RunPlan {
        RunPlan {
            run_id: self.run_id.clone(),
            domain: DomainPlan::of(&self.domain),
            time: self.time.clone(),
            body_force: BodyForcePlan {
                gravity: self.body_force.gravity.row().as_ref().to_vec(),
                expressions: self.body_force.expressions.as_ref().map(|all| all.as_ref().to_vec()),
            },
            outputs: self.outputs.clone(),
            ledger: self.ledger,
            coupling: self.coupling,
        }
    }
}

/// Steps and end of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct TimePlan {
    /// Time at which the run starts \[s\].
    pub start_time: f64,
    /// The run ends at the first step boundary at or after this time \[s\].
    pub end_time: f64,
    /// How a step's size is chosen.
    pub step: StepPolicy,
}

/// How a step's size is chosen; both sides apply the same rule to the same bits.
#[derive(Clone, Debug, PartialEq)]
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
        /// Times that a step boundary meets exactly \[s\], in addition to those of snapshots, and of probes where their
        /// interval is at least [`STEPS_PER_EXACT_PROBE`](crate::coupling::stage::STEPS_PER_EXACT_PROBE) steps. `None` shortens no step.
        exact: Option<Vec<f64>>,
    },
}

/// When outputs are due: at the first step boundary at or after each time, and at the first and last boundary.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputPlan {
    /// Time between snapshots \[s\]; `None` for the first and last only.
    pub snapshot_interval: Option<f64>,
    /// Time between probe rows \[s\]; `None` for the first and last only.
    pub probe_interval: Option<f64>,
    /// Further times of snapshots \[s\].
    pub snapshot_times: Vec<f64>,
}

/// What to do when a ledger check fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreachAction {
    /// Count and report it, and continue.
    Warn,
    /// Stop the run.
    Stop,
    /// Stop the run at the end of the step, with a checkpoint.
    StopAndCheckpoint,
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

impl LedgerPolicy {
    /// Stop at 1e-12 of gross: round-off of sums of some 10⁴ pair forces is near 1e-14.
    pub const DEFAULT: Self =
        Self { action: BreachAction::Stop, balance_tolerance: 1e-12, momentum_tolerance: 1e-12 };
}

impl Default for LedgerPolicy {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Acceleration acting on all matter: constant gravity plus optional expressions of the coordinates and t.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyForce<S: Space = Plane> {
    /// Constant part g \[m/s²\].
    pub gravity: S::Vector,
    /// Expressions of `x`, `y`, in space `z`, and `t` for the components added to gravity \[m/s²\].
    pub expressions: Option<S::PerAxis<String>>,
}

/// What a solid sends to the fluid and receives from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CouplingKind {
    /// State coupling: both sides receive the other's interface states and evaluate the same pair law on their own
    /// particles.
    #[default]
    States,
    /// Force coupling: the solid sends coupling points; the fluid evaluates the pair law and returns the force on each.
    Loads,
}

impl CouplingKind {
    /// All kinds, the preferred one first.
    pub const ALL: [CouplingKind; 2] = [CouplingKind::States, CouplingKind::Loads];

    /// Name in case files and messages.
    pub fn name(self) -> &'static str {
        match self {
            CouplingKind::States => "states",
            CouplingKind::Loads => "loads",
        }
    }
}

/// Law between fluid particles and interface particles of a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterfaceLaw {
    /// Interface particles act on the fluid as wall particles with the dummy pressure of Eq. (28), and the exact
    /// reaction acts on the solid. Slip.
    Wall,
    /// As `Wall`, with viscous friction against the solid's velocity.
    WallNoSlip,
    /// One sum over all particles of either owner, Eq. (17), (22), (25): closest to the source paper.
    PlainSum,
}

/// Facts of the interface that both sides must hold alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// What the solid sends and receives.
    pub kind: CouplingKind,
    /// Pair law.
    pub law: InterfaceLaw,
    /// Parameters of the fluid for fluid-solid pairs, the same on both sides: [`ParameterSet::of_pair_law`](super::ParameterSet::of_pair_law).
    pub fluid: FluidParameters,
    /// Spacing of the solid's particles \[m\].
    pub solid_spacing: f64,
    /// Repulsion of fluid particles lower than 0.6 of the mean spacing over the outer row of a solid \[-\]; zero leaves it out.
    pub repulsion: f64,
    /// Largest distance beyond the support radius at which particles are sent to spare \[m\].
    pub margin: f64,
    /// Implicit coupling, with force coupling only; `None` for explicit coupling, one evaluation per half-step.
    pub implicit: Option<ImplicitCoupling>,
}

impl Coupling {
    /// Whether both sides hold the states of the other and meet as fluid and wall.
    pub fn has_wall_states(&self) -> bool {
        self.kind == CouplingKind::States && self.law != InterfaceLaw::PlainSum
    }
}

/// Linear damping −k v of all free particles until a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// k \[1/s\].
    pub rate: f64,
    /// Damping ends at this time \[s\].
    pub until: f64,
}
