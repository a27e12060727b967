//! Solvers that compute nothing: what is left of a run is the coupling.

use std::time::Duration;

use proto::description::Description;
use proto::service::{Opened, SetupProblems, SolverFactory};
use sph::coupling::exchange::{Extent, StateColumns};
use sph::coupling::ledger::{EnergyReport, StageBudget};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, ParticleFields, Role, Solver};
use sph::coupling::stage::StageTime;
use sph::setup::ParticipantSetup;

/// A solver of either role with so many particles at the interface, none of which moves.
#[derive(Clone, Copy, Debug)]
pub struct Idle {
    /// Side that it plays.
    pub role: Role,
    /// Interface particles.
    pub particles: u32,
    /// Wall time of its own sums in each half-step, which need no partner.
    pub own_sums: Duration,
}

impl SolverFactory for Idle {
    fn describe(&self) -> Description {
        match self.role {
            Role::Fluid => fluid_server::FluidFactory::default().describe(),
            Role::Solid => solid_server::SolidFactory.describe(),
        }
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let opened = match self.role {
            Role::Fluid => fluid_server::FluidFactory::default().open(setup)?,
            Role::Solid => solid_server::SolidFactory.open(setup)?,
        };
        let mut states = StateColumns::default();
        for id in 0..self.particles {
            states.id.push(id);
            states.group.push(0);
            states.mass.push(0.1);
            states.density.push(1000.0);
            states.pressure.push(f64::from(id));
        }
        let places = (0..self.particles).map(|id| 1e-3 * f64::from(id));
        states.position = places.clone().map(|x| [x, 0.1]).collect();
        states.velocity = places.map(|v| [0.0, v]).collect();
        let solver = IdleSolver { solver: opened.solver, states, own_sums: self.own_sums };
        Ok(Opened { solver: Box::new(solver), ..opened })
    }
}

/// A real solver for all that is asked of it at rest.
struct IdleSolver {
    solver: Box<dyn Solver>,
    states: StateColumns,
    own_sums: Duration,
}

impl Solver for IdleSolver {
    fn role(&self) -> Role {
        self.solver.role()
    }

    fn begin_stage(&mut self, _time: &StageTime) -> Result<(), Divergence> {
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        self.solver.time_step_limit()
    }

    fn extent(&self) -> &Extent {
        self.solver.extent()
    }

    fn interface(&mut self, _partner: &Extent, _reach: f64, states: &mut StateColumns) -> u64 {
        states.clone_from(&self.states);
        1
    }

    fn covered_by(&self, _extent: &Extent, _reach: f64) -> Result<(), f64> {
        Ok(())
    }

    fn evaluate_own(&mut self, _time: &StageTime) {
        std::thread::sleep(self.own_sums);
    }

    fn evaluate_cross(&mut self, _time: &StageTime, _own: &StateColumns, _partner: &StateColumns) {}

    fn advance(&mut self, _time: &StageTime) -> Result<StageBudget, Divergence> {
        Ok(StageBudget::default())
    }

    fn end_step(&mut self, _time: &StageTime) -> Result<(), Divergence> {
        Ok(())
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
        self.solver.save(state);
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError> {
        self.solver.restore(state)
    }
}
