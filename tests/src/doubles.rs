//! Doubles around the real solvers: one thing is wrong with each.

use std::net::SocketAddr;
use std::time::Duration;

use proto::description::{Description, ProtocolVersion};
use proto::service::{Opened, ServeOptions, Server, SetupProblems, SolverFactory};
use sph::coupling::exchange::{Column, Exchange, Extent, Frame, PeerError, StateColumns};
use sph::coupling::ledger::{EnergyReport, StageBudget};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, NoLoads, NotUpdated, ParticleFields, Role, Solver};
use sph::coupling::stage::{StageTime, StepStage};
use sph::in_space;
use sph::setup::ParticipantSetup;
use tokio::sync::oneshot;

/// What is wrong with a [`Double`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrong {
    /// It speaks this protocol version only.
    Protocol(ProtocolVersion),
    /// It computes with this sound speed of the fluid \[m/s\], whatever its set-up says.
    SoundSpeed(f64),
    /// It says that it uses the gravity of its set-up, and uses this multiple of it.
    Gravity(f64),
    /// It computes the forces of this half-step from the partner's states of the one before.
    Stale(StepStage),
    /// It reports this multiple of the interface force at this half-step.
    Force(StepStage, f64),
    /// It reports a force of the interface at this half-step that did not act, here and in its own sums.
    Skewed(StepStage),
    /// It sends a NaN at this half-step.
    NotANumber(StepStage),
    /// It takes this long over this half-step.
    Delay(StepStage, Duration),
    /// Its checkpoints hold nothing, and it restores as much.
    EmptyCheckpoint,
    /// It says at this half-step that no step as long as the present one is stable by far.
    Limit(StepStage),
    /// It breaks down at this half-step.
    Drop(StepStage),
    /// Its process ends at this half-step.
    Exit(StepStage),
    /// With implicit coupling it reports convergence without moving by the returned forces.
    Unmoved,
    /// It does not offer implicit coupling.
    NoIterations,
}

/// The real solid solver with one thing wrong.
#[derive(Clone, Copy, Debug)]
pub struct Double(pub Wrong);

impl SolverFactory for Double {
    fn describe(&self) -> Description {
        let mut description = solid_server::SolidFactory.describe();
        match self.0 {
            Wrong::Protocol(version) => description.protocols = [version; 2],
            Wrong::NoIterations => description.capabilities.implicit_coupling = false,
            _ => {}
        }
        description
    }

    fn open(&self, mut setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let prescribed = setup.plan().body_force;
        if let (Wrong::Gravity(factor), ParticipantSetup::Solid(solid)) = (self.0, &mut setup) {
            in_space!(solid, solid => solid.run.body_force.gravity *= factor);
        }
        let mut opened = solid_server::SolidFactory.open(setup)?;
        opened.constants.body_force = prescribed;
        if let (Wrong::SoundSpeed(speed), Some(coupling)) = (self.0, &mut opened.constants.coupling) {
            coupling.fluid.sound_speed = speed;
        }
        let solver = WrongSolver {
            solver: opened.solver,
            wrong: self.0,
            now: StepStage::FIRST,
            last: StateColumns::default(),
        };
        Ok(Opened { solver: Box::new(solver), ..opened })
    }
}

/// A server of this process; dropping it ends it.
#[derive(Debug)]
pub struct Served {
    /// Where it listens.
    pub address: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// Serves solvers of `factory` on a port of this machine.
pub fn serve(factory: impl SolverFactory) -> Served {
    let (stop, stopped) = oneshot::channel();
    let (sender, receiver) = std::sync::mpsc::channel();
    let thread = std::thread::spawn(move || {
        let runtime =
            tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
        runtime.block_on(async move {
            let server = Server::bind("127.0.0.1:0".parse().unwrap()).unwrap();
            sender.send(server.address()).unwrap();
            let stopped = async { drop(stopped.await) };
            server
                .serve(factory, ServeOptions { threads: 1, ..ServeOptions::default() }, stopped)
                .await
                .unwrap();
        });
    });
    Served { address: receiver.recv().unwrap(), stop: Some(stop), thread: Some(thread) }
}

impl Drop for Served {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking(), "the server panicked");
        }
    }
}

/// A solver that goes wrong during a run.
struct WrongSolver {
    solver: Box<dyn Solver>,
    wrong: Wrong,
    now: StepStage,
    /// The partner's states of the half-step before.
    last: StateColumns,
}

impl Solver for WrongSolver {
    fn evaluate_cross(&mut self, time: &StageTime, own: &StateColumns, partner: &StateColumns) {
        let used = if self.wrong == Wrong::Stale(time.at) { &self.last } else { partner };
        self.solver.evaluate_cross(time, own, used);
        self.last.clone_from(partner);
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.now = time.at;
        match self.wrong {
            Wrong::Delay(at, duration) if at == time.at => std::thread::sleep(duration),
            Wrong::Drop(at) if at == time.at => panic!("seeded at {at}"),
            Wrong::Exit(at) if at == time.at => {
                terminal::say("this solver ends here");
                std::process::exit(3)
            }
            _ => {}
        }
        self.solver.begin_stage(time)
    }

    fn interface(&mut self, partner: &Extent, reach: f64, states: &mut StateColumns) -> u64 {
        let version = self.solver.interface(partner, reach, states);
        match self.wrong {
            Wrong::NotANumber(at) if at == self.now => {
                states.velocity.values.iter_mut().take(1).for_each(|number| *number = f64::NAN);
            }
            _ => {}
        }
        version
    }

    fn evaluate_loads(
        &mut self,
        time: &StageTime,
        own: &StateColumns,
        forces: &Column,
    ) -> Result<(), NoLoads> {
        self.solver.evaluate_loads(time, own, forces)
    }

    fn update_stage(
        &mut self,
        time: &StageTime,
        own: &StateColumns,
        forces: &Column,
    ) -> Result<(), NotUpdated> {
        if self.wrong == Wrong::Unmoved { Ok(()) } else { self.solver.update_stage(time, own, forces) }
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        let mut budget = self.solver.advance(time)?;
        match self.wrong {
            Wrong::Force(at, factor) if at == time.at => budget.interface.force *= factor,
            Wrong::Skewed(at) if at == time.at => {
                budget.interface.force.x += 1e-3 * budget.interface.gross_force;
            }
            _ => {}
        }
        Ok(budget)
    }

    fn role(&self) -> Role {
        self.solver.role()
    }

    fn time_step_limit(&self) -> f64 {
        let limit = self.solver.time_step_limit();
        if self.wrong == Wrong::Limit(self.now) { 1e-3 * limit } else { limit }
    }

    fn limiting_particle(&self) -> Option<(u32, Vec<f64>)> {
        self.solver.limiting_particle()
    }

    fn extent(&self) -> &Extent {
        self.solver.extent()
    }

    fn covered_by(&self, extent: &Extent, reach: f64) -> Result<(), f64> {
        self.solver.covered_by(extent, reach)
    }

    fn evaluate_own(&mut self, time: &StageTime) {
        self.solver.evaluate_own(time);
    }

    fn end_step(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.solver.end_step(time)
    }

    fn energies(&self) -> EnergyReport {
        self.solver.energies()
    }

    fn probes(&mut self, time: f64, values: &mut Vec<f64>) {
        self.solver.probes(time, values);
    }

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        self.solver.snapshot(step, time)
    }

    fn counts(&self) -> Counts {
        self.solver.counts()
    }

    fn save(&self, state: &mut SavedState) {
        if self.wrong != Wrong::EmptyCheckpoint {
            self.solver.save(state);
        }
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError> {
        if self.wrong == Wrong::EmptyCheckpoint { Ok(()) } else { self.solver.restore(state) }
    }
}

/// An exchange that delivers at one half-step what the partner sent for the one before, under the present time.
pub struct StaleExchange<E> {
    exchange: E,
    at: StepStage,
    last: StateColumns,
}

impl<E: Exchange> StaleExchange<E> {
    /// `exchange` with a stale frame at `at`.
    pub fn new(exchange: E, at: StepStage) -> Self {
        Self { exchange, at, last: StateColumns::default() }
    }
}

impl<E: Exchange> Exchange for StaleExchange<E> {
    fn send(&mut self, frame: &Frame) -> Result<(), PeerError> {
        self.exchange.send(frame)
    }

    fn receive(&mut self, at: StepStage, frame: &mut Frame) -> Result<(), PeerError> {
        self.exchange.receive(at, frame)?;
        let fresh = frame.states.clone();
        if at == self.at {
            frame.states.clone_from(&self.last);
        }
        self.last = fresh;
        Ok(())
    }
}
