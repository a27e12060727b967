//! The partner that the kit plays: particles that move as prescribed and take part in the interface by the book.

use sph::coupling::exchange::{Extent, InterfaceStates};
use sph::coupling::ledger::{Account, Accounts, Energies, InterfaceSums, StageBooks};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, Field, NoLoads, NotRevised, ParticleFields, Role, Solver};
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::interface::{Interface, load_sums};
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{Coupling, ParticipantSetup};
use sph::space::Vector;
use sph::space::domain::Domain;

use super::scene::SOLID_DENSITY;
use crate::description::{Constants, Description};
use crate::service::{Opened, SetupProblems, SolverFactory};

/// What a dummy does apart from its set-up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Quirk {
    /// As a fluid that gives loads: pulls each sample toward a place `1` \[m\] to the left of where it began, with this
    /// angular frequency `0` \[1/s\], in place of the pair law.
    pub(super) spring: Option<(f64, f64)>,
    /// As a fluid that gives loads: slows each sample down at this rate \[1/s\], in place of the pair law.
    pub(super) damper: Option<f64>,
    /// Sends a NaN at this half-step.
    pub(super) not_a_number: Option<StepStage>,
}

/// Makes dummies of one role.
#[derive(Clone, Copy, Debug)]
pub(super) struct DummyFactory(pub(super) Role, pub(super) Quirk);

impl SolverFactory for DummyFactory {
    fn describe(&self) -> Description {
        Description::of_solver("conform", env!("CARGO_PKG_VERSION"), self.0, "f64")
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let constants = Constants::of(setup.run());
        let dummy = Dummy::new(&setup, self.1).map_err(|problem| SetupProblems(vec![problem]))?;
        Ok(Opened { solver: Box::new(dummy), constants, facts: Vec::new(), bodies: Vec::new() })
    }
}

struct Dummy {
    role: Role,
    domain: Domain,
    quirk: Quirk,
    interface: Interface,
    states: InterfaceStates,
    /// Positions at the start of the step \[m\].
    base: Vec<Vector>,
    /// Where the partner's samples began \[m\].
    anchors: Vec<Vector>,
    extent: Extent,
    sums: InterfaceSums,
    /// Whether the forces of this stage were prescribed.
    prescribes: bool,
}

impl Dummy {
    fn new(setup: &ParticipantSetup, quirk: Quirk) -> Result<Self, String> {
        let run = setup.run();
        let coupling: &Coupling = run.coupling.as_ref().ok_or("a dummy needs a partner")?;
        let body_force = BodyForceField::new(&run.body_force).map_err(|e| e.to_string())?;
        let mut states = InterfaceStates::default();
        let role = match setup {
            ParticipantSetup::Fluid(fluid) => {
                let (particles, c) = (&fluid.particles, &fluid.parameters);
                let law = c.equation_of_state();
                states.id.clone_from(&particles.id);
                states.group.clone_from(&particles.region);
                states.mass.clone_from(&particles.mass);
                states.position.clone_from(&particles.position);
                states.velocity.clone_from(&particles.velocity);
                states.density.clone_from(&particles.density);
                states.pressure.extend(particles.density.iter().map(|density| law.pressure(*density)));
                Role::Fluid
            }
            ParticipantSetup::Solid(solid) => {
                let particles = &solid.particles;
                states.id.clone_from(&particles.id);
                states.group.clone_from(&particles.body);
                states.mass.clone_from(&particles.mass);
                states.position.clone_from(&particles.position);
                states.velocity.clone_from(&particles.velocity);
                states.density.clone_from(&particles.density);
                states.pressure.resize(particles.density.len(), 0.0);
                Role::Solid
            }
        };
        // The whole domain: the partner sends all it has.
        let extent = Extent { version: 1, boxes: vec![(run.domain.lower, run.domain.upper)] };
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

    /// Acceleration of sample `s` that is prescribed in place of the pair law \[m/s²\].
    fn prescribed(&mut self, samples: &InterfaceStates, s: usize) -> Option<Vector> {
        if let Some((rate, left)) = self.quirk.spring {
            if self.anchors.is_empty() {
                self.anchors.clone_from(&samples.position);
            }
            return Some(-rate * rate * (samples.position[s] - self.anchors[s] + Vector::new(left, 0.0)));
        }
        self.quirk.damper.map(|rate| -rate * samples.velocity[s])
    }

    /// Fills `forces` with prescribed ones on `samples`, and notes their reaction; whether there are any.
    fn prescribe(&mut self, samples: &InterfaceStates, forces: &mut Vec<Vector>) -> bool {
        forces.clear();
        for s in 0..samples.len() {
            let Some(acceleration) = self.prescribed(samples, s) else { return false };
            forces.push(SOLID_DENSITY * samples.volume(s) * acceleration);
        }
        let on_samples = load_sums(&self.domain, samples, forces);
        self.sums =
            InterfaceSums { force: -on_samples.force, torque: -on_samples.torque, power: 0.0, ..on_samples };
        self.prescribes = true;
        true
    }
}

impl Solver for Dummy {
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
            velocity.x = f64::NAN;
        }
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        f64::INFINITY
    }

    fn extent(&self) -> &Extent {
        &self.extent
    }

    fn interface(&mut self, _: &Extent, _: f64, states: &mut InterfaceStates) -> u64 {
        states.clone_from(&self.states);
        1
    }

    fn covered_by(&self, _: &Extent, _: f64) -> Result<(), f64> {
        // Particles that lie beyond the partner's reach meet nothing of it.
        Ok(())
    }

    fn evaluate_own(&mut self, _: &StageTime) {}

    fn evaluate_cross(&mut self, time: &StageTime, own: &InterfaceStates, partner: &InterfaceStates) {
        if std::mem::take(&mut self.prescribes) {
            return;
        }
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
        own: &InterfaceStates,
        samples: &InterfaceStates,
        forces: &mut Vec<Vector>,
    ) -> Result<(), NoLoads> {
        if !self.prescribe(samples, forces) {
            self.interface.update(time.state_time(), own, samples);
            self.interface.solid_forces(own, samples);
            forces.clear();
            forces.extend((0..samples.len()).map(|s| self.interface.force(s)));
        }
        if self.quirk.not_a_number == Some(time.at)
            && let Some(force) = forces.first_mut()
        {
            force.x = f64::NAN;
        }
        Ok(())
    }

    fn evaluate_loads(
        &mut self,
        _: &StageTime,
        own: &InterfaceStates,
        forces: &[Vector],
    ) -> Result<(), NoLoads> {
        self.sums = load_sums(&self.domain, own, forces);
        Ok(())
    }

    fn revise(&mut self, _: &StageTime, _: &InterfaceStates, _: &[Vector]) -> Result<(), NotRevised> {
        // Nothing moves a dummy but its own velocity.
        Ok(())
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBooks, Divergence> {
        let duration = time.duration();
        for (k, position) in self.states.position.iter_mut().enumerate() {
            *position = self.base[k] + duration * self.states.velocity[k];
        }
        let mut accounts = Accounts::default();
        // Whatever moves the dummy takes up the force.
        accounts.add(Account::Supports, -self.sums.force);
        let gross: f64 =
            (0..self.states.len()).map(|k| self.states.mass[k] * self.states.velocity[k].norm()).sum();
        Ok(StageBooks {
            interface: self.sums,
            accounts,
            duration,
            momentum_change: Vector::zeros(),
            gross_momentum: gross + duration * self.sums.gross_force,
            angular: None,
        })
    }

    fn end_step(&mut self, _: &StageTime) -> Result<(), Divergence> {
        Ok(())
    }

    fn energies(&self) -> Energies {
        Energies::default()
    }

    fn probes(&self, _: f64, _: &mut Vec<f64>) {}

    fn snapshot(&self, step: u64, time: f64) -> ParticleFields {
        ParticleFields {
            step,
            time,
            id: self.states.id.clone(),
            group: self.states.group.clone(),
            group_names: vec!["dummy".into()],
            fields: vec![Field {
                name: "position".into(),
                unit: "m".into(),
                components: 2,
                values: self.states.position.iter().flat_map(|x| [x.x, x.y]).collect(),
            }],
        }
    }

    fn counts(&self) -> Counts {
        Counts { particles: self.states.len() as u64, ..Counts::default() }
    }

    fn save(&self, state: &mut SavedState) {
        state.put_vectors("position", &self.states.position);
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError> {
        self.states.position = state.vectors("position", self.states.len())?;
        Ok(())
    }
}
