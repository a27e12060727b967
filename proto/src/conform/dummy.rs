//! The partner that the kit plays: particles that move as prescribed and take part in the interface by the book.

use std::time::Duration;

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{Account, Accounts, EnergyReport, InterfaceSums, LedgerVector, StageBudget};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, Field, NoLoads, NotUpdated, ParticleFields, Role, Solver};
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::in_space;
use sph::interface::states::InterfaceStates;
use sph::interface::{Interface, load_sums};
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{Coupling, FluidSetup, ParticipantSetup, RunSetup, SolidSetup};
use sph::space::Space;
use sph::space::components::Components;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use tokio::sync::oneshot;

use super::scene::SOLID_DENSITY;
use crate::description::{Constants, Description};
use crate::service::{Opened, ServeOptions, Server, SetupProblems, SolverFactory};
use crate::transport::security::{ClientSecurity, ServerSecurity};

/// What a dummy does apart from its set-up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Quirk {
    /// As a fluid with force coupling: pulls each coupling point toward a place `1` \[m\] to the left of where it began, with this
    /// angular frequency `0` \[1/s\], in place of the pair law.
    pub(super) spring: Option<(f64, f64)>,
    /// As a fluid with force coupling: slows each coupling point down at this rate \[1/s\], in place of the pair law.
    pub(super) damper: Option<f64>,
    /// Sends a NaN at this half-step.
    pub(super) not_a_number: Option<StepStage>,
}

/// Makes dummies of one role.
#[derive(Clone, Copy, Debug)]
struct DummyFactory(Role, Quirk);

impl SolverFactory for DummyFactory {
    fn describe(&self) -> Description {
        Description::of_solver("conform", env!("CARGO_PKG_VERSION"), self.0, &[2, 3], "f64")
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let constants = Constants::of(&setup.plan());
        let solver: Result<Box<dyn Solver>, String> = match &setup {
            ParticipantSetup::Fluid(setup) => {
                in_space!(setup, setup => Dummy::fluid(setup, self.1).map(boxed))
            }
            ParticipantSetup::Solid(setup) => {
                in_space!(setup, setup => Dummy::solid(setup, self.1).map(boxed))
            }
        };
        let solver = solver.map_err(|problem| SetupProblems(vec![problem]))?;
        Ok(Opened { solver, constants, facts: Vec::new(), bodies: Vec::new() })
    }
}

/// A server of dummies in this process.
pub(super) struct DummyServer {
    pub(super) address: String,
    _stop: oneshot::Sender<()>,
}

impl DummyServer {
    /// A dummy that calls its partner by `security`.
    pub(super) fn start(role: Role, quirk: Quirk, security: ClientSecurity) -> Result<Self, String> {
        let server = Server::bind(([127, 0, 0, 1], 0).into()).map_err(|e| e.to_string())?;
        let address = server.address().to_string();
        let (stop, stopped) = oneshot::channel::<()>();
        let options = ServeOptions {
            threads: 1,
            shutdown_limit: Duration::from_millis(100),
            security: ServerSecurity::calling(security),
            ..ServeOptions::default()
        };
        tokio::spawn(async move {
            // Its fate shows in the run.
            let stopped = async { drop(stopped.await) };
            drop(server.serve(DummyFactory(role, quirk), options, stopped).await);
        });
        Ok(Self { address, _stop: stop })
    }
}

fn boxed<S: Space>(dummy: Dummy<S>) -> Box<dyn Solver> {
    Box::new(dummy)
}

struct Dummy<S: Space> {
    role: Role,
    domain: Domain<S>,
    quirk: Quirk,
    interface: Interface<S>,
    states: InterfaceStates<S>,
    /// Positions at the start of the step \[m\].
    base: Vec<S::Vector>,
    /// Where the partner's coupling points began \[m\].
    anchors: Vec<S::Vector>,
    extent: Extent,
    sums: InterfaceSums,
    /// Whether the forces of this stage were prescribed.
    prescribes: bool,
}

impl<S: Space> Dummy<S> {
    fn fluid(setup: &FluidSetup<S>, quirk: Quirk) -> Result<Self, String> {
        let (particles, law) = (&setup.particles, setup.parameters.equation_of_state());
        let states = InterfaceStates {
            id: particles.id.clone(),
            group: particles.region.clone(),
            mass: particles.mass.clone(),
            position: particles.position.clone(),
            velocity: particles.velocity.clone(),
            density: particles.density.clone(),
            pressure: particles.density.iter().map(|density| law.pressure(*density)).collect(),
            ..InterfaceStates::default()
        };
        Self::new(Role::Fluid, &setup.run, states, quirk)
    }

    fn solid(setup: &SolidSetup<S>, quirk: Quirk) -> Result<Self, String> {
        let particles = &setup.particles;
        let states = InterfaceStates {
            id: particles.id.clone(),
            group: particles.body.clone(),
            mass: particles.mass.clone(),
            position: particles.position.clone(),
            velocity: particles.velocity.clone(),
            density: particles.density.clone(),
            pressure: vec![0.0; particles.density.len()],
            ..InterfaceStates::default()
        };
        Self::new(Role::Solid, &setup.run, states, quirk)
    }

    fn new(role: Role, run: &RunSetup<S>, states: InterfaceStates<S>, quirk: Quirk) -> Result<Self, String> {
        let coupling: &Coupling = run.coupling.as_ref().ok_or("a dummy needs a partner")?;
        let body_force = BodyForceField::new(&run.body_force).map_err(|e| e.to_string())?;
        // The whole domain: the partner sends all it has.
        let corners = [run.domain.lower.row(), run.domain.upper.row()];
        let values = corners.iter().flat_map(|corner| corner.as_ref().iter().copied()).collect();
        let whole = Column { components: 2 * S::DIMENSIONS, values };
        let extent = Extent { version: 1, boxes: whole };
        Ok(Self {
            role,
            domain: run.domain,
            quirk,
            interface: Interface::new(coupling, &run.domain, body_force),
            base: states.position.clone(),
            states,
            anchors: Vec::new(),
            extent,
            sums: InterfaceSums::default(),
            prescribes: false,
        })
    }

    /// Acceleration of point `s` that is prescribed in place of the pair law \[m/s²\].
    fn prescribed(&mut self, points: &InterfaceStates<S>, s: usize) -> Option<S::Vector> {
        if let Some((rate, left)) = self.quirk.spring {
            if self.anchors.is_empty() {
                self.anchors.clone_from(&points.position);
            }
            let mut stretched = points.position[s] - self.anchors[s];
            stretched[0] += left;
            return Some(stretched * (-rate * rate));
        }
        self.quirk.damper.map(|rate| points.velocity[s] * -rate)
    }

    /// Prescribed forces on `points`, whose reaction becomes the own sums; `None` where the pair law holds.
    fn prescribe(&mut self, points: &InterfaceStates<S>) -> Option<Vec<S::Vector>> {
        let mut forces = Vec::with_capacity(points.len());
        for s in 0..points.len() {
            forces.push(self.prescribed(points, s)? * (SOLID_DENSITY * points.volume(s)));
        }
        let on_points = load_sums(&self.domain, points, &forces);
        self.sums =
            InterfaceSums { force: -on_points.force, torque: -on_points.torque, power: 0.0, ..on_points };
        self.prescribes = true;
        Some(forces)
    }
}

impl<S: Space> Solver for Dummy<S> {
    fn role(&self) -> Role {
        self.role
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        if time.at.stage == Stage::Predictor {
            self.base.clone_from(&self.states.position);
        }
        if self.quirk.not_a_number == Some(time.at)
            && let Some(velocity) = self.states.velocity.first_mut()
        {
            velocity[0] = f64::NAN;
        }
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        f64::INFINITY
    }

    fn extent(&self) -> &Extent {
        &self.extent
    }

    fn interface(&mut self, _: &Extent, _: f64, states: &mut StateColumns) -> u64 {
        self.states.write(states);
        1
    }

    fn covered_by(&self, _: &Extent, _: f64) -> Result<(), f64> {
        // Particles that lie beyond the partner's reach meet nothing of it.
        Ok(())
    }

    fn evaluate_own(&mut self, _: &StageTime) {}

    fn evaluate_cross(&mut self, time: &StageTime, own: &StateColumns, partner: &StateColumns) {
        if std::mem::take(&mut self.prescribes) {
            return;
        }
        let (own, partner) = (&InterfaceStates::from(own), &InterfaceStates::from(partner));
        let at = time.state_time();
        self.sums = match self.role {
            Role::Fluid => {
                self.interface.update(at, own, partner);
                self.interface.fluid_forces(own, partner)
            }
            Role::Solid => {
                self.interface.update(at, partner, own);
                self.interface.solid_forces(partner, own)
            }
        };
    }

    fn reactions(
        &mut self,
        time: &StageTime,
        own: &StateColumns,
        points: &StateColumns,
        forces: &mut Column,
    ) -> Result<(), NoLoads> {
        let (own, points) = (&InterfaceStates::from(own), &InterfaceStates::from(points));
        match self.prescribe(points) {
            Some(prescribed) => forces.fill(prescribed),
            None => {
                self.interface.update(time.state_time(), own, points);
                self.interface.solid_forces(own, points);
                forces.fill((0..points.len()).map(|s| self.interface.force(s)));
            }
        }
        if self.quirk.not_a_number == Some(time.at)
            && let Some(force) = forces.values.first_mut()
        {
            *force = f64::NAN;
        }
        Ok(())
    }

    fn evaluate_loads(&mut self, _: &StageTime, own: &StateColumns, forces: &Column) -> Result<(), NoLoads> {
        let mut loads = Vec::new();
        forces.read_into(&mut loads);
        self.sums = load_sums(&self.domain, &own.into(), &loads);
        Ok(())
    }

    fn update_stage(&mut self, _: &StageTime, _: &StateColumns, _: &Column) -> Result<(), NotUpdated> {
        // Nothing moves a dummy but its own velocity.
        Ok(())
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        let duration = time.duration();
        for (k, position) in self.states.position.iter_mut().enumerate() {
            *position = self.base[k] + self.states.velocity[k] * duration;
        }
        let mut accounts = Accounts::default();
        // Whatever moves the dummy takes up the force.
        accounts.add_force(Account::Supports, -self.sums.force);
        let gross: f64 =
            (0..self.states.len()).map(|k| self.states.mass[k] * self.states.velocity[k].norm()).sum();
        Ok(StageBudget {
            interface: self.sums,
            accounts,
            duration,
            momentum_change: LedgerVector::zeros(),
            gross_momentum: gross + duration * self.sums.gross_force,
            angular: None,
        })
    }

    fn end_step(&mut self, _: &StageTime) -> Result<(), Divergence> {
        Ok(())
    }

    fn energies(&self) -> EnergyReport {
        EnergyReport::default()
    }

    fn probes(&mut self, _: f64, _: &mut Vec<f64>) {}

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        ParticleFields {
            step,
            time,
            id: self.states.id.clone(),
            group: self.states.group.clone(),
            group_names: vec!["dummy".into()],
            fields: vec![Field {
                name: "position".into(),
                unit: "m".into(),
                components: S::DIMENSIONS,
                values: Column::from_iter(self.states.position.iter().copied()).values,
            }],
        }
    }

    fn counts(&self) -> Counts {
        Counts { particles: self.states.len() as u64, ..Counts::default() }
    }

    fn save(&self, state: &mut SavedState) {
        state.put_quantities("position", &self.states.position);
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError> {
        self.states.position = state.quantities("position", self.states.len())?;
        Ok(())
    }
}
