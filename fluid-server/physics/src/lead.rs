//! A fluid in parts as one solver: the first part plays the solver, and the others do what it does.

use std::borrow::Cow;
use std::thread::JoinHandle;

use serde::{Deserialize, Serialize};
use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{EnergyReport, StageBudget};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, NoLoads, ParticleFields, Role, Solver};
use sph::coupling::stage::StageTime;
use sph::in_space;
use sph::lanes::Arithmetic;
use sph::setup::AnyFluidSetup;

use crate::solver::FluidSolver;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::FluidState;
use crate::team::threads::ThreadTransport;
use crate::team::{Team, Turn, Working};

/// A call of the solver in which all parts take part, with what the others need.
#[derive(Debug, Serialize, Deserialize)]
enum Call<'a> {
    BeginStage(StageTime),
    LimitingParticle,
    Interface { partner: Cow<'a, Extent>, reach: f64 },
    CoveredBy { extent: Cow<'a, Extent>, reach: f64 },
    EvaluateOwn(StageTime),
    EvaluateCross(Box<CrossInput<'a>>),
    Advance(StageTime),
    EndStep(StageTime),
    Energies,
    Counts,
    Probes { time: f64 },
    Snapshot { step: u64, time: f64 },
    Save,
    TakeOver,
    End,
}

/// Input of [`Solver::evaluate_cross`].
#[derive(Debug, Serialize, Deserialize)]
struct CrossInput<'a> {
    time: StageTime,
    own: Cow<'a, StateColumns>,
    partner: Cow<'a, StateColumns>,
}

/// The first part of a fluid.
#[derive(Debug)]
struct Leader<S: FluidSpace> {
    solver: FluidSolver<S>,
    /// The other parts, where they are threads of this process.
    threads: Vec<JoinHandle<()>>,
    _turn: Turn,
}

/// A solver at the start of the run that `setup` describes, in `parts` threads.
///
/// Each holds a part of the particles, as processes on several machines do. What it computes does not depend on their
/// number. On one machine the threads of a fluid in one part are the faster way.
///
/// # Errors
/// Everything in the set-up that can not be run.
pub fn in_threads(setup: AnyFluidSetup, parts: usize) -> Result<Box<dyn Solver>, Vec<String>> {
    let mut ends = ThreadTransport::of_parts(parts.max(1)).into_iter();
    let first = ends.next();
    let spawned = ends.map(|end| {
        let setup = setup.clone();
        std::thread::spawn(move || other_part(setup, &Team::new(Box::new(end))))
    });
    let threads = spawned.collect();
    let team = first.map_or_else(Team::default, |end| Team::new(Box::new(end)));
    lead(setup, &team, team.turn(), threads)
}

/// The same in the parts that `team` joins, of which this is the first, in its `turn`; each of the others calls [`other_part`].
///
/// # Errors
/// Everything in the set-up that can not be run; then the others return.
pub fn first_part(setup: AnyFluidSetup, team: &Team, turn: Turn) -> Result<Box<dyn Solver>, Vec<String>> {
    lead(setup, team, turn, Vec::new())
}

/// Computes the part of this member of `team`, which is not the first, until the solver of [`first_part`] is dropped.
pub fn other_part(setup: AnyFluidSetup, team: &Team) {
    // The first part has the same errors.
    in_space!(setup, setup => drop(FluidSolver::part(setup, Arithmetic::chosen(), team.clone()).map(follow)));
}

fn lead(
    setup: AnyFluidSetup,
    team: &Team,
    turn: Turn,
    threads: Vec<JoinHandle<()>>,
) -> Result<Box<dyn Solver>, Vec<String>> {
    Ok(in_space!(setup, setup => {
        let solver = FluidSolver::part(setup, Arithmetic::chosen(), team.clone())?;
        Box::new(Leader { solver, threads, _turn: turn })
    }))
}

impl<S: FluidSpace> Leader<S> {
    /// Makes the others do what `call` says; this part does it while the answer lives.
    fn call(&self, call: &Call<'_>) -> Working {
        let team = &self.solver.model.team;
        team.call(call);
        team.work()
    }
}

impl<S: FluidSpace> Drop for Leader<S> {
    fn drop(&mut self) {
        // Where another part has failed, none is left to listen.
        if !std::thread::panicking() {
            drop(self.call(&Call::End));
            // One that has panicked has said so.
            self.threads.drain(..).for_each(|thread| drop(thread.join()));
        }
    }
}

/// Makes every call that the first part makes, until that ends.
fn follow<S: FluidSpace>(mut part: FluidSolver<S>) {
    // What all parts find together, such as an error, is for the first one to tell.
    loop {
        let call = part.model.team.next_call();
        let _working = part.model.team.work();
        match call {
            Call::BeginStage(time) => drop(part.begin_stage(&time)),
            Call::LimitingParticle => drop(part.limiting_particle()),
            Call::Interface { partner, reach } => {
                part.interface(&partner, reach, &mut StateColumns::default());
            }
            Call::CoveredBy { extent, reach } => drop(part.covered_by(&extent, reach)),
            Call::EvaluateOwn(time) => part.evaluate_own(&time),
            Call::EvaluateCross(input) => part.evaluate_cross(&input.time, &input.own, &input.partner),
            Call::Advance(time) => drop(part.advance(&time)),
            Call::EndStep(time) => drop(part.end_step(&time)),
            Call::Energies => drop(part.energies()),
            Call::Counts => drop(part.counts()),
            Call::Probes { time } => part.probes(time, &mut Vec::new()),
            Call::Snapshot { step, time } => drop(part.snapshot(step, time)),
            Call::Save => part.save(&mut SavedState::default()),
            Call::TakeOver => drop(part.take_over(FluidState::default(), [0; 2])),
            Call::End => return,
        }
    }
}

impl<S: FluidSpace> Solver for Leader<S> {
    fn role(&self) -> Role {
        self.solver.role()
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        let _working = self.call(&Call::BeginStage(*time));
        self.solver.begin_stage(time)
    }

    fn time_step_limit(&self) -> f64 {
        self.solver.time_step_limit()
    }

    fn limiting_particle(&self) -> Option<(u32, Vec<f64>)> {
        let _working = self.call(&Call::LimitingParticle);
        self.solver.limiting_particle()
    }

    fn extent(&self) -> &Extent {
        self.solver.extent()
    }

    fn interface(&mut self, partner: &Extent, reach: f64, states: &mut StateColumns) -> u64 {
        let _working = self.call(&Call::Interface { partner: Cow::Borrowed(partner), reach });
        self.solver.interface(partner, reach, states)
    }

    fn covered_by(&self, extent: &Extent, reach: f64) -> Result<(), f64> {
        let _working = self.call(&Call::CoveredBy { extent: Cow::Borrowed(extent), reach });
        self.solver.covered_by(extent, reach)
    }

    fn evaluate_own(&mut self, time: &StageTime) {
        let _working = self.call(&Call::EvaluateOwn(*time));
        self.solver.evaluate_own(time);
    }

    fn evaluate_cross(&mut self, time: &StageTime, own: &StateColumns, partner: &StateColumns) {
        let input = CrossInput { time: *time, own: Cow::Borrowed(own), partner: Cow::Borrowed(partner) };
        let _working = self.call(&Call::EvaluateCross(Box::new(input)));
        self.solver.evaluate_cross(time, own, partner);
    }

    fn reactions(
        &mut self,
        time: &StageTime,
        own: &StateColumns,
        points: &StateColumns,
        forces: &mut Column,
    ) -> Result<(), NoLoads> {
        // Of what all parts have: the others are not needed.
        let _working = self.solver.model.team.work();
        self.solver.reactions(time, own, points, forces)
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        let _working = self.call(&Call::Advance(*time));
        self.solver.advance(time)
    }

    fn end_step(&mut self, time: &StageTime) -> Result<(), Divergence> {
        let _working = self.call(&Call::EndStep(*time));
        self.solver.end_step(time)
    }

    fn energies(&self) -> EnergyReport {
        let _working = self.call(&Call::Energies);
        self.solver.energies()
    }

    fn probes(&mut self, time: f64, values: &mut Vec<f64>) {
        let _working = self.call(&Call::Probes { time });
        self.solver.probes(time, values);
    }

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        let _working = self.call(&Call::Snapshot { step, time });
        self.solver.snapshot(step, time)
    }

    fn counts(&self) -> Counts {
        let _working = self.call(&Call::Counts);
        self.solver.counts()
    }

    fn save(&self, saved: &mut SavedState) {
        let _working = self.call(&Call::Save);
        self.solver.save(saved);
    }

    fn restore(&mut self, saved: &SavedState) -> Result<(), RestoreError> {
        let (state, history) = self.solver.restored(saved)?;
        let _working = self.call(&Call::TakeOver);
        self.solver.take_over(state, history)
    }
}
