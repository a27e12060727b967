//! A solver of a row of masses, and what makes it.

use std::time::Duration;

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::{EnergyReport, InterfaceSums, StageBudget, axial, lifted};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, Field, ParticleFields, Role, Solver};
use sph::coupling::stage::{Stage, StageTime};
use sph::in_space;
use sph::interface::states::InterfaceStates;
use sph::setup::{FluidParticles, FluidSetup, ParticipantSetup, SolidParticles, SolidSetup};
use sph::space::Space;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;

use super::setups::{MASSES, RANGE};
use crate::description::{Constants, Description};
use crate::service::{Opened, SetupProblems, SolverFactory};

/// Stiffness of the repulsion \[N/m²\].
const STIFFNESS: f64 = 3000.0;

/// A row of masses that the partner's row repels.
struct Row<S: Space> {
    role: Role,
    run_id: String,
    states: InterfaceStates<S>,
    set_version: u64,
    position_start: Vec<S::Vector>,
    velocity_start: Vec<S::Vector>,
    force: Vec<S::Vector>,
    sums: InterfaceSums,
    extent: Extent,
}

/// The row of `setup`.
pub(crate) fn row(setup: &ParticipantSetup) -> Box<dyn Solver> {
    fn boxed<S: Space>(role: Role, run_id: &str, states: InterfaceStates<S>) -> Box<dyn Solver> {
        Box::new(Row::new(role, run_id, states))
    }
    let (role, run_id) = (setup.role(), setup.run_id());
    match setup {
        ParticipantSetup::Fluid(setup) => in_space!(setup, setup => boxed(role, run_id, fluid_states(setup))),
        ParticipantSetup::Solid(setup) => in_space!(setup, setup => boxed(role, run_id, solid_states(setup))),
    }
}

fn fluid_states<S: Space>(setup: &FluidSetup<S>) -> InterfaceStates<S> {
    let FluidParticles { id, mass, position, velocity, density, .. } = setup.particles.clone();
    InterfaceStates { id, mass, position, velocity, density, ..InterfaceStates::default() }
}

fn solid_states<S: Space>(setup: &SolidSetup<S>) -> InterfaceStates<S> {
    let SolidParticles { id, mass, position, velocity, density, .. } = setup.particles.clone();
    InterfaceStates { id, mass, position, velocity, density, ..InterfaceStates::default() }
}

impl<S: Space> Row<S> {
    fn new(role: Role, run_id: &str, mut states: InterfaceStates<S>) -> Self {
        let count = states.id.len();
        states.group = vec![0; count];
        states.pressure = (0..count).map(|k| k as f64).collect();
        let mut row = Self {
            role,
            run_id: run_id.to_owned(),
            position_start: states.position.clone(),
            velocity_start: states.velocity.clone(),
            force: vec![S::Vector::zeros(); count],
            states,
            set_version: 1,
            sums: InterfaceSums::default(),
            extent: Extent::default(),
        };
        row.update_extent();
        row
    }

    fn update_extent(&mut self) {
        let within = |corners: &[f64], x: &S::Vector| {
            let (lower, upper) = corners.split_at(S::DIMENSIONS);
            (0..S::DIMENSIONS).all(|axis| lower[axis] <= x[axis] && x[axis] <= upper[axis])
        };
        let inside = |corners: &[f64]| self.states.position.iter().all(|x| within(corners, x));
        if self.extent.boxes.rows().any(inside) {
            return;
        }
        let first = self.states.position[0];
        let slack = S::Vector::repeat(0.01);
        let lower = self.states.position.iter().fold(first, |a, b| a.inf(b)) - slack;
        let upper = self.states.position.iter().fold(first, |a, b| a.sup(b)) + slack;
        let values = [lower, upper].iter().flat_map(|x| x.row().as_ref().to_vec()).collect();
        let boxes = Column { components: 2 * S::DIMENSIONS, values };
        self.extent = Extent { version: self.extent.version + 1, boxes };
    }

    fn momentum(&self, velocities: &[S::Vector]) -> (S::Vector, f64) {
        let terms = || velocities.iter().zip(&self.states.mass).map(|(v, m)| *v * *m);
        (terms().sum(), terms().map(|p| p.norm()).sum())
    }
}

impl<S: Space> Drop for Row<S> {
    /// A solver of some size takes time to go.
    fn drop(&mut self) {
        if self.run_id == "slow-end" {
            std::thread::sleep(Duration::from_millis(300));
        }
    }
}

/// Force on a fluid mass by a solid mass, x_fs apart.
fn repulsion<V: SpaceVector>(x_fs: &V) -> Option<V> {
    let distance = x_fs.norm();
    (distance < RANGE).then(|| *x_fs * (STIFFNESS * (RANGE - distance).powi(2) / distance))
}

impl<S: Space> Solver for Row<S> {
    fn role(&self) -> Role {
        self.role
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        assert!(!(self.run_id == "panic" && time.at.step == 3), "seeded panic");
        if self.run_id == "diverge" && time.at.step == 3 {
            return Err(Divergence {
                at: time.at,
                particle: Some(6),
                position: Some(vec![0.0, 1.0]),
                quantity: "speed [m/s]".into(),
                value: f64::NAN,
                allowed: "finite".into(),
                hint: "seeded by a test".into(),
            });
        }
        if self.run_id == "slow" {
            std::thread::sleep(Duration::from_millis(20));
        }
        if time.at.stage == Stage::Predictor {
            self.position_start.clone_from(&self.states.position);
            self.velocity_start.clone_from(&self.states.velocity);
            // A new version of the same set: the wire must carry it again.
            self.set_version = 1 + time.at.step / 5;
        }
        self.update_extent();
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        match self.role {
            Role::Fluid => 2e-3,
            Role::Solid => f64::INFINITY,
        }
    }

    fn extent(&self) -> &Extent {
        &self.extent
    }

    fn interface(&mut self, _: &Extent, _: f64, states: &mut StateColumns) -> u64 {
        self.states.write(states);
        self.set_version
    }

    fn covered_by(&self, _: &Extent, _: f64) -> Result<(), f64> {
        Ok(())
    }

    fn evaluate_own(&mut self, _: &StageTime) {}

    fn evaluate_cross(&mut self, _: &StageTime, own: &StateColumns, partner: &StateColumns) {
        let (own, partner) = (InterfaceStates::<S>::from(own), InterfaceStates::<S>::from(partner));
        self.sums = InterfaceSums::default();
        self.force.fill(S::Vector::zeros());
        for i in 0..own.len() {
            for j in 0..partner.len() {
                let (sign, x_fs) = match self.role {
                    Role::Fluid => (1.0, own.position[i] - partner.position[j]),
                    Role::Solid => (-1.0, partner.position[j] - own.position[i]),
                };
                if let Some(force) = repulsion(&x_fs).map(|force| force * sign) {
                    self.force[i] += force;
                    let sums = &mut self.sums;
                    sums.force += lifted(&force);
                    sums.gross_force += force.norm();
                    sums.torque += axial(S::cross(&own.position[i], &force));
                    sums.gross_torque += own.position[i].norm() * force.norm();
                    sums.power += force.dot(&own.velocity[i]);
                    sums.pairs += 1;
                }
            }
        }
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        let duration = time.duration();
        let (before, gross_before) = self.momentum(&self.velocity_start);
        for k in 0..self.states.len() {
            let velocity = self.states.velocity[k];
            self.states.position[k] = self.position_start[k] + velocity * duration;
            self.states.velocity[k] =
                self.velocity_start[k] + self.force[k] * (duration / self.states.mass[k]);
        }
        let (after, gross_after) = self.momentum(&self.states.velocity);
        Ok(StageBudget {
            interface: self.sums,
            duration,
            momentum_change: lifted(&(after - before)),
            gross_momentum: gross_before + gross_after,
            ..StageBudget::default()
        })
    }

    fn end_step(&mut self, _: &StageTime) -> Result<(), Divergence> {
        Ok(())
    }

    fn energies(&self) -> EnergyReport {
        EnergyReport::default()
    }

    fn probes(&mut self, time: f64, values: &mut Vec<f64>) {
        values.extend([time, f64::NAN, self.states.position[0][0]]);
    }

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        let field = |name: &str, unit: &str, values: &[S::Vector]| Field {
            name: name.into(),
            unit: unit.into(),
            components: S::DIMENSIONS,
            values: Column::from_iter(values.iter().copied()).values,
        };
        ParticleFields {
            step,
            time,
            id: self.states.id.clone(),
            group: self.states.group.clone(),
            group_names: vec!["row".into()],
            fields: vec![
                field("position", "m", &self.states.position),
                field("velocity", "m/s", &self.states.velocity),
            ],
        }
    }

    fn counts(&self) -> Counts {
        Counts { particles: MASSES as u64, ..Counts::default() }
    }

    fn save(&self, state: &mut SavedState) {
        state.put_quantities("position", &self.states.position);
        state.put_quantities("velocity", &self.states.velocity);
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError> {
        self.states.position = state.quantities("position", MASSES)?;
        self.states.velocity = state.quantities("velocity", MASSES)?;
        self.update_extent();
        Ok(())
    }
}

/// Makes rows.
pub(crate) struct RowFactory(pub Role);

impl SolverFactory for RowFactory {
    fn describe(&self) -> Description {
        Description::of_solver("row", "0.0.1", self.0, &[2, 3], "f64 scalar")
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let problems = match setup.run_id() {
            "bad" => vec!["first problem".into(), "second problem".into()],
            "open-panic" => panic!("seeded panic in open"),
            "open-slow" => {
                std::thread::sleep(Duration::from_millis(300));
                Vec::new()
            }
            _ => Vec::new(),
        };
        if !problems.is_empty() {
            return Err(SetupProblems(problems));
        }
        let constants = Constants::of(&setup.plan());
        Ok(Opened { solver: row(&setup), constants, facts: Vec::new(), bodies: Vec::new() })
    }
}
