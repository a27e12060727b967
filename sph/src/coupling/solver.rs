//! What the half-step driver requires of a solver, and what a solver reports.

use serde::{Deserialize, Serialize};

use crate::coupling::exchange::{Column, Extent, PeerError, StateColumns};
use crate::coupling::ledger::{Breach, EnergyReport, StageBudget};
use crate::coupling::saved::{RestoreError, SavedState};
use crate::coupling::stage::{StageTime, StepStage};

/// Part that a solver plays in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Owns the fluid and its walls.
    Fluid,
    /// Owns the solids.
    Solid,
}

impl Role {
    /// The role across the interface.
    pub fn partner(self) -> Self {
        match self {
            Role::Fluid => Role::Solid,
            Role::Solid => Role::Fluid,
        }
    }

    /// Place in arrays that hold one thing for each side: the fluid's first.
    pub fn index(self) -> usize {
        match self {
            Role::Fluid => 0,
            Role::Solid => 1,
        }
    }
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Role::Fluid => "fluid",
            Role::Solid => "solid",
        })
    }
}

/// A solver was asked for a side of force coupling that it does not play.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this solver does not offer force coupling in this role; choose another coupling kind")]
pub struct NoLoads;

/// Why a stage state was not updated.
#[derive(Clone, Debug, PartialEq)]
pub enum NotUpdated {
    /// The solver does not offer implicit coupling.
    NotOffered,
    /// The new state is not finite or breaks a limit.
    Diverged(Divergence),
}

/// A solver of either side, stepped by [`crate::coupling::driver::run`].
///
/// One half-step is `begin_stage`, `interface`, `evaluate_own`, `evaluate_cross`, `advance`, in this order. Nothing
/// moves before `advance`, and `advance` computes no force. The same calls on the same data give the same bits on
/// any number of threads.
pub trait Solver: Send {
    /// Which side this is.
    fn role(&self) -> Role;

    /// Updates what follows from the stage state alone: pressure or stress, walls' motion, neighbour lists.
    ///
    /// # Errors
    /// When the state is no longer finite or breaks a limit.
    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence>;

    /// Largest stable step \[s\] as judged from the present state.
    fn time_step_limit(&self) -> f64;

    /// The particle with the smallest limit of the step, and its position \[m\]; `None` where no single one does.
    ///
    /// Asked for only when a run breaks down over its step.
    fn limiting_particle(&self) -> Option<(u32, Vec<f64>)> {
        None
    }

    /// What deserves a second look about the state at the start, in words; shown by a check and at the start of a run.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// Where own particles are that can meet the partner.
    fn extent(&self) -> &Extent;

    /// Fills `states` with all own particles within `reach` \[m\] of the partner's `extent`, ids ascending.
    ///
    /// Returns the version of the set: it changes when ids, groups or masses do.
    fn interface(&mut self, partner: &Extent, reach: f64, states: &mut StateColumns) -> u64;

    /// Whether a partner that sent all within `reach` \[m\] of `extent` has covered all that own particles can meet.
    ///
    /// # Errors
    /// The shortfall \[m\].
    fn covered_by(&self, extent: &Extent, reach: f64) -> Result<(), f64>;

    /// Sums over own particles that need no partner data.
    fn evaluate_own(&mut self, time: &StageTime);

    /// Sums over the partner's particles and all that follows from them: completes the rates of this stage.
    ///
    /// `own` is what [`Solver::interface`] filled in this stage. Without a partner both are empty.
    fn evaluate_cross(&mut self, time: &StageTime, own: &StateColumns, partner: &StateColumns);

    /// The fluid's side of force coupling: fills `forces` with the force of own particles on each of the partner's
    /// coupling `points` \[N\], the exact reactions to what [`Solver::evaluate_cross`] adds for the same arguments.
    ///
    /// Needs [`Solver::begin_stage`] only, so that the partner waits for no other work.
    ///
    /// # Errors
    /// When the solver does not offer it.
    fn reactions(
        &mut self,
        _time: &StageTime,
        _own: &StateColumns,
        _points: &StateColumns,
        _forces: &mut Column,
    ) -> Result<(), NoLoads> {
        Err(NoLoads)
    }

    /// The solid's side of force coupling, in place of [`Solver::evaluate_cross`]: completes the rates with the forces
    /// \[N\] that the partner returned for each of the `own` coupling points.
    ///
    /// # Errors
    /// When the solver does not offer it.
    fn evaluate_loads(
        &mut self,
        _time: &StageTime,
        _own: &StateColumns,
        _forces: &Column,
    ) -> Result<(), NoLoads> {
        Err(NoLoads)
    }

    /// The solid's side of implicit coupling: computes the stage state of the corrector of `time` again, from the start of
    /// the step by Δt/2, with `forces` \[N\] on the `own` coupling points in place of those of the predictor; then what
    /// [`Solver::begin_stage`] does with it. Forces that are not the partner's stay those of the predictor.
    ///
    /// Called before [`Solver::evaluate_own`] of the corrector, as often as it takes.
    ///
    /// # Errors
    /// When the solver does not offer it, or the new state is not finite or breaks a limit.
    fn update_stage(
        &mut self,
        _time: &StageTime,
        _own: &StateColumns,
        _forces: &Column,
    ) -> Result<(), NotUpdated> {
        Err(NotUpdated::NotOffered)
    }

    /// Moves the state from the start of the step by the stage's duration and the rates: Eq. (30) or (31), or what the
    /// solver's own scheme makes of the two stages.
    ///
    /// # Errors
    /// When the new state is not finite or breaks a limit.
    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence>;

    /// Removes particles that left, at the end of a step.
    ///
    /// # Errors
    /// When more escape than the case allows.
    fn end_step(&mut self, time: &StageTime) -> Result<(), Divergence>;

    /// The energy budget at the present step boundary: stores, and works and losses since the start of the run.
    fn energies(&self) -> EnergyReport;

    /// Values of all probes in the order of the set-up, columns as the probe kinds list them.
    ///
    /// What is evaluated for it changes no bit of the state.
    fn probes(&mut self, time: f64, values: &mut Vec<f64>);

    /// All own particles with their fields.
    ///
    /// What is evaluated for it changes no bit of the state.
    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields;

    /// Facts of the run so far.
    fn counts(&self) -> Counts;

    /// Saves the complete state at a step boundary: all that decides the bits of what follows. Changes nothing.
    fn save(&self, state: &mut SavedState);

    /// Takes over a state that [`Solver::save`] made for the same set-up; the end time alone may differ.
    ///
    /// # Errors
    /// When an array is missing, does not fit the set-up or holds values that cannot be; the solver is then of no
    /// further use.
    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError>;
}

/// Facts of a solver's run so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Particles that move by their own equations.
    pub particles: u64,
    /// Wall particles.
    pub wall_particles: u64,
    /// Neighbour list builds.
    pub list_builds: u64,
    /// Particles that crossed a wall.
    #[serde(rename = "lost")]
    pub escaped: u64,
    /// Particles that left over an open rim or through an outflow side.
    pub outflow: u64,
    /// Largest number of own interface particles sent in a frame.
    pub largest_interface: u64,
    /// Deepest penetration of a solid particle into another body, a wall or a distant part of its own \[m\].
    pub deepest_contact_m: f64,
    /// Sum over solid particles and time of the magnitudes of contact forces \[N s\].
    #[serde(rename = "contact_impulse_n_s_per_m")]
    pub contact_impulse_n_s: f64,
    /// Sub-steps that the solids have taken from step boundary to step boundary; those of predictors do not count.
    #[serde(default)]
    pub substeps: u64,
    /// The parts of a solver that computes in several, each with its own particles.
    #[serde(default)]
    pub parts: Option<PartCounts>,
}

/// Facts of the parts of a solver since it was opened.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartCounts {
    /// Each part, by its number.
    pub each: Vec<PartCount>,
    /// Largest over mean work of the parts, less one: mean over the builds of neighbour lists \[-\].
    pub mean_imbalance: Option<f64>,
    /// The largest of them \[-\].
    pub largest_imbalance: Option<f64>,
}

/// Facts of one part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartCount {
    /// Its particles.
    pub particles: u64,
    /// Copies of particles of other parts that it holds.
    pub copies: u64,
    /// Time in which it has computed \[s\].
    pub computing_seconds: f64,
    /// Time in which it has waited for copies \[s\].
    pub waited_for_copies_seconds: f64,
    /// Time in which it has waited for what all parts find together, such as sums \[s\].
    pub waited_for_agreement_seconds: f64,
    /// Messages that it has sent with copies.
    pub copy_messages: u64,
    /// Their bytes.
    pub copy_bytes: u64,
    /// Other messages that it has sent.
    pub other_messages: u64,
    /// Their bytes.
    pub other_bytes: u64,
}

/// Name of the field of q, the pressure of the acoustic relaxation \[Pa\]. The field `pressure` includes it.
pub const RELAXATION_PRESSURE: &str = "relaxation_pressure";

/// Particles with named fields, as written to snapshots and final states.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticleFields {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Identity among the owner's particles; wall particles follow, with ids beyond the owner's largest.
    pub id: Vec<u32>,
    /// Index into `group_names`.
    pub group: Vec<u32>,
    /// Names of regions, bodies or walls.
    pub group_names: Vec<String>,
    /// Fields; `position` is always present.
    pub fields: Vec<Field>,
}

impl ParticleFields {
    /// The field called `name`.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// One named field of a particle set.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, a standard term of the field such as `pressure`.
    pub name: String,
    /// SI unit, such as `Pa`.
    pub unit: String,
    /// Numbers per particle.
    pub components: usize,
    /// Values, particle by particle.
    pub values: Vec<f64>,
}

/// A run that cannot continue, with the offending particle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Divergence {
    /// Half-step.
    pub at: StepStage,
    /// Particle id among the owner's, where one is the cause.
    pub particle: Option<u32>,
    /// Where it is \[m\].
    pub position: Option<Vec<f64>>,
    /// Quantity that broke its limit, with unit.
    pub quantity: String,
    /// Its value.
    pub value: f64,
    /// What is allowed, in words.
    pub allowed: String,
    /// What to do about it.
    pub hint: String,
}

impl std::fmt::Display for Divergence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "diverged at {}: {} = {:.6e}", self.at, self.quantity, self.value)?;
        if let Some(particle) = self.particle {
            write!(f, " of particle {particle}")?;
        }
        if let Some(position) = &self.position {
            let numbers: Vec<String> = position.iter().map(|x| format!("{x:.4}")).collect();
            write!(f, " at ({}) m", numbers.join(", "))?;
        }
        write!(f, "; allowed: {}; ", self.allowed)?;
        if self.at.step == 0 && self.particle.is_some() {
            // A step that is too long takes more than one to break a limit.
            f.write_str("look for a fault of the start, such as particles that overlap or lie in walls; without one, ")?;
        }
        f.write_str(&self.hint)
    }
}

/// Why a participant ended its run before the end time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "detail")]
pub enum Fault {
    /// The physics broke down.
    Diverged(Divergence),
    /// A check of the ledger failed.
    Ledger(Breach),
    /// The partner computed a half-step from another frame than the one sent for it.
    StaleFrame {
        /// Half-step that was computed from it.
        at: StepStage,
        /// Digest of the frame sent for that half-step.
        sent: u32,
        /// Digest of the frame that the partner used.
        used: u32,
    },
    /// The partner's frame did not cover what own particles can interact with.
    Coverage {
        /// Half-step.
        at: StepStage,
        /// Missing reach \[m\].
        shortfall: f64,
    },
    /// Both sides hold different times or steps.
    Clock {
        /// Half-step.
        at: StepStage,
        /// What differs.
        difference: String,
    },
    /// The partner is lost or was refused.
    Peer {
        /// Half-step.
        at: StepStage,
        /// What happened.
        message: String,
    },
    /// The partner's frames contradict its set-up or its own report.
    Contradiction {
        /// Half-step of the frame.
        at: StepStage,
        /// What does not agree.
        message: String,
    },
    /// The run was aborted by the coordinator.
    Aborted {
        /// Half-step.
        at: StepStage,
    },
}

impl Fault {
    /// The fault of a half-step whose frame did not arrive.
    pub(crate) fn of_peer(at: StepStage, error: PeerError) -> Self {
        match error {
            PeerError::Cancelled => Self::Aborted { at },
            other => Self::Peer { at, message: other.to_string() },
        }
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fault::Diverged(divergence) => divergence.fmt(f),
            Fault::Ledger(breach) => breach.fmt(f),
            Fault::StaleFrame { at, sent, used } => write!(
                f,
                "stale frame at {at}: the partner computed this half-step from a frame of digest {used:08x}, \
                 but the one sent for it has digest {sent:08x}; it used an older or altered state"
            ),
            Fault::Coverage { at, shortfall } => write!(
                f,
                "incomplete frame at {at}: the partner's particles cover {shortfall:.3e} m too little of the \
                 interface; it moved further in one half-step than the margin allows"
            ),
            Fault::Clock { at, difference } => write!(f, "clocks differ at {at}: {difference}"),
            Fault::Peer { at, message } => write!(f, "exchange failed at {at}: {message}"),
            Fault::Contradiction { at, message } => write!(f, "at {at}: {message}"),
            Fault::Aborted { at } => write!(f, "aborted by the coordinator at {at}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_particle_that_fails_in_the_first_step_points_to_the_start() {
        let late = Divergence {
            at: StepStage { step: 1, ..StepStage::FIRST },
            particle: Some(7),
            position: Some(vec![0.5, 0.25]),
            quantity: "velocity [m/s]".into(),
            value: f64::NAN,
            allowed: "finite values".into(),
            hint: "reduce the time step".into(),
        };
        let text = late.to_string();
        assert_eq!(
            text,
            "diverged at step 1 predictor: velocity [m/s] = NaN of particle 7 at (0.5000, 0.2500) m; allowed: \
             finite values; reduce the time step"
        );
        let first = Divergence { at: StepStage::FIRST, ..late };
        let text = first.to_string();
        assert!(text.contains("; look for a fault of the start"), "{text}");
        assert!(text.ends_with("without one, reduce the time step"), "{text}");
        // What no particle did, such as an iteration that does not converge, says nothing of the start.
        let iteration = Divergence { particle: None, ..first };
        assert!(!iteration.to_string().contains("start"), "{iteration}");
    }
}
