//! The half-step driver with two analytic participants: one mass on each side of a spring.

use std::sync::mpsc;

use sph::coupling::driver::{Command, Event, Link, run};
use sph::coupling::exchange::{Column, Exchange, Extent, Frame, PeerError, StateColumns, in_process_pair};
use sph::coupling::ledger::{EnergyReport, InterfaceSums, StageBudget, axial, lifted};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, Fault, ParticleFields, Role, Solver};
use sph::coupling::stage::{StageTime, StepStage};
use sph::interface::states::InterfaceStates;
use sph::setup::{
    BodyForce, BreachAction, Coupling, CouplingKind, FluidParameters, GradientCorrection, InterfaceLaw,
    LedgerPolicy, OutputPlan, RunSetup, StepPolicy, TimePlan,
};
use sph::space::domain::Domain;
use sph::space::{Vector, cross};

const STIFFNESS: f64 = 40.0;
const REST_LENGTH: f64 = 0.1;

/// A point mass that feels the partner's through a spring.
struct Mass {
    role: Role,
    mass: f64,
    extent: Extent,
    origin: Vector,
    position: Vector,
    velocity: Vector,
    base: (Vector, Vector),
    force: Vector,
    sums: InterfaceSums,
    /// Largest stable step \[s\], from that half-step on.
    limit: (StepStage, f64),
    now: StepStage,
}

impl Mass {
    fn new(role: Role, mass: f64, position: Vector, velocity: Vector, domain: &Domain) -> Self {
        Self {
            role,
            mass,
            extent: Extent { version: 1, boxes: whole(domain) },
            origin: domain.torque_origin(),
            position,
            velocity,
            base: (position, velocity),
            force: Vector::zeros(),
            sums: InterfaceSums::default(),
            limit: (StepStage::FIRST, 1.0),
            now: StepStage::FIRST,
        }
    }
}

/// One box around `domain`.
fn whole(domain: &Domain) -> Column {
    Column::from_iter([[domain.lower.x, domain.lower.y, domain.upper.x, domain.upper.y]])
}

impl Solver for Mass {
    fn role(&self) -> Role {
        self.role
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        self.now = time.at;
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        if self.now >= self.limit.0 { self.limit.1 } else { 1.0 }
    }

    fn extent(&self) -> &Extent {
        &self.extent
    }

    fn interface(&mut self, _partner: &Extent, _reach: f64, states: &mut StateColumns) -> u64 {
        let own: InterfaceStates = InterfaceStates {
            id: vec![0],
            group: vec![0],
            mass: vec![self.mass],
            position: vec![self.position],
            velocity: vec![self.velocity],
            density: vec![1.0],
            pressure: vec![0.0],
            stress: Vec::new(),
        };
        own.write(states);
        1
    }

    fn covered_by(&self, _extent: &Extent, _reach: f64) -> Result<(), f64> {
        Ok(())
    }

    fn evaluate_own(&mut self, _time: &StageTime) {}

    fn evaluate_cross(&mut self, _time: &StageTime, own: &StateColumns, partner: &StateColumns) {
        let (own, partner) = (<InterfaceStates>::from(own), <InterfaceStates>::from(partner));
        // Alone it feels nothing.
        let (Some(own), Some(partner)) = (own.position.first(), partner.position.first()) else { return };
        let separation = own - partner;
        let length = separation.norm();
        self.force = separation * (-STIFFNESS * (length - REST_LENGTH) / length);
        let arm = self.position - self.origin;
        self.sums = InterfaceSums {
            force: lifted(&self.force),
            gross_force: self.force.norm(),
            torque: axial(cross(&arm, &self.force)),
            gross_torque: arm.norm() * self.force.norm(),
            couple: axial(0.0),
            power: self.force.dot(&self.velocity),
            pairs: 1,
        };
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        if time.at.stage == sph::coupling::stage::Stage::Predictor {
            self.base = (self.position, self.velocity);
        }
        let duration = time.duration();
        self.position = self.base.0 + self.velocity * duration;
        self.velocity = self.base.1 + self.force * (duration / self.mass);
        Ok(StageBudget {
            interface: self.sums,
            duration,
            momentum_change: lifted(&(self.mass * (self.velocity - self.base.1))),
            gross_momentum: self.mass * (self.velocity.norm() + self.base.1.norm()),
            ..StageBudget::default()
        })
    }

    fn end_step(&mut self, _time: &StageTime) -> Result<(), Divergence> {
        Ok(())
    }

    fn energies(&self) -> EnergyReport {
        EnergyReport::default()
    }

    fn probes(&mut self, _time: f64, values: &mut Vec<f64>) {
        values.extend([self.position.x, self.position.y]);
    }

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        ParticleFields { step, time, id: vec![0], ..ParticleFields::default() }
    }

    fn counts(&self) -> Counts {
        Counts { particles: 1, ..Counts::default() }
    }

    fn save(&self, state: &mut SavedState) {
        state.put_quantities("motion", &[self.position, self.velocity]);
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), RestoreError> {
        let motion = state.quantities("motion", 2)?;
        (self.position, self.velocity) = (motion[0], motion[1]);
        Ok(())
    }
}

fn setup(time_step: f64, end_time: f64, action: BreachAction) -> RunSetup {
    RunSetup {
        run_id: "spring".into(),
        domain: Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] },
        time: TimePlan { start_time: 0.0, end_time, step: StepPolicy::Fixed { time_step } },
        body_force: BodyForce { gravity: Vector::zeros(), expressions: None },
        outputs: OutputPlan::default(),
        ledger: LedgerPolicy { action, ..LedgerPolicy::default() },
        coupling: Some(Coupling {
            kind: CouplingKind::States,
            law: InterfaceLaw::Wall,
            fluid: FluidParameters {
                rest_density: 1.0,
                sound_speed: 1.0,
                kernel_ratio: 1.0,
                particle_spacing: 0.1,
                viscosity_a: 0.0,
                correction: GradientCorrection::None,
                ..FluidParameters::PLAIN
            },
            solid_spacing: 0.1,
            repulsion: 0.5,
            margin: 0.05,
            implicit: None,
        }),
    }
}

fn masses(domain: &Domain) -> (Mass, Mass) {
    (
        Mass::new(Role::Fluid, 1.0, Vector::new(0.4, 0.5), Vector::new(0.0, 0.1), domain),
        Mass::new(Role::Solid, 3.0, Vector::new(0.55, 0.52), Vector::zeros(), domain),
    )
}

/// Runs both masses; `wrap` may put a faulty exchange between the fluid and its partner.
fn run_pair(
    setup: &RunSetup,
    wrap: impl FnOnce(Box<dyn Exchange>) -> Box<dyn Exchange>,
    commands: impl Fn(&mpsc::Sender<Command>),
) -> (Vec<Event>, Vec<Event>) {
    let plan = &setup.plan();
    let (mut fluid, mut solid) = masses(&setup.domain);
    let (a, b) = in_process_pair();
    let link = |partner: &Mass| Link {
        partner_extent: partner.extent.clone(),
        first_limit: 1.0,
        resume: None,
        partner_particles: None,
    };
    let (fluid_link, solid_link) = (link(&solid), link(&fluid));
    let channel = || {
        let (sender, receiver) = mpsc::channel();
        commands(&sender);
        (sender, receiver)
    };
    let (fluid_sender, fluid_receiver) = channel();
    let (solid_sender, solid_receiver) = channel();
    let fluid_exchange = wrap(Box::new(a));
    std::thread::scope(|scope| {
        let partner = scope.spawn(move || {
            let mut events = Vec::new();
            run(&mut solid, plan, &solid_link, Some(Box::new(b)), &solid_receiver, &mut |e| events.push(e));
            events
        });
        let mut events = Vec::new();
        run(&mut fluid, plan, &fluid_link, Some(fluid_exchange), &fluid_receiver, &mut |e| events.push(e));
        drop((fluid_sender, solid_sender));
        (events, partner.join().unwrap())
    })
}

fn granted(sender: &mpsc::Sender<Command>) {
    sender.send(Command::GrantThrough(u64::MAX)).unwrap();
}

fn last_probe(events: &[Event]) -> Vector {
    let values = events.iter().rev().find_map(|event| match event {
        Event::Probes(probes) => Some(&probes.values),
        _ => None,
    });
    let values = values.unwrap();
    Vector::new(values[0], values[1])
}

fn fault(events: &[Event]) -> Option<&Fault> {
    match events.last() {
        Some(Event::Failed(report)) => Some(&report.fault),
        _ => None,
    }
}

#[test]
fn the_exchange_at_both_stages_keeps_second_order() {
    let end = |time_step: f64| {
        let (fluid, solid) = run_pair(&setup(time_step, 0.4, BreachAction::Stop), |e| e, granted);
        assert!(matches!(fluid.last(), Some(Event::Finished(report)) if report.reached_end));
        assert!(matches!(solid.last(), Some(Event::Finished(report)) if report.reached_end));
        last_probe(&fluid)
    };
    let (coarse, medium, fine) = (end(1e-3), end(5e-4), end(2.5e-4));
    let order = ((coarse - medium).norm() / (medium - fine).norm()).log2();
    assert!((order - 2.0).abs() < 0.1, "observed order {order}");
}

#[test]
fn step_reports_balance_and_the_clocks_agree() {
    let (fluid, solid) = run_pair(&setup(1e-3, 0.05, BreachAction::Stop), |e| e, granted);
    let steps = |events: &[Event]| {
        events
            .iter()
            .filter_map(|event| match event {
                Event::Step(report) => Some(*report),
                _ => None,
            })
            .collect::<Vec<_>>()
    };
    let (fluid, solid) = (steps(&fluid), steps(&solid));
    assert_eq!((fluid.len(), solid.len()), (50, 50));
    for (a, b) in fluid.iter().zip(&solid) {
        assert_eq!(a.end_time.to_bits(), b.end_time.to_bits());
        for stage in 0..2 {
            assert_eq!(a.budgets[stage].interface.force, -b.budgets[stage].interface.force);
            assert!(a.budgets[stage].momentum_residual() < 1e-14);
        }
    }
}

/// From one half-step on, hands the receiver the states of the half-step before.
struct Stale {
    inner: Box<dyn Exchange>,
    from: StepStage,
    before: Option<StateColumns>,
}

impl Exchange for Stale {
    fn send(&mut self, frame: &Frame) -> Result<(), PeerError> {
        self.inner.send(frame)
    }

    fn receive(&mut self, at: StepStage, frame: &mut Frame) -> Result<(), PeerError> {
        self.inner.receive(at, frame)?;
        let fresh = frame.states.clone();
        if at >= self.from
            && let Some(before) = self.before.take()
        {
            frame.states = before;
        }
        self.before = Some(fresh);
        Ok(())
    }
}

#[test]
fn a_stale_frame_is_caught_at_its_half_step_and_called_stale() {
    let from = StepStage { step: 7, stage: sph::coupling::stage::Stage::Corrector };
    let stale = |inner| Box::new(Stale { inner, from, before: None }) as Box<dyn Exchange>;
    let (fluid, solid) = run_pair(&setup(1e-3, 0.05, BreachAction::Stop), stale, granted);
    // The partner of the deceived side learns from the digest that its frame was not the one used.
    let faults: Vec<&Fault> = [fault(&fluid), fault(&solid)].into_iter().flatten().collect();
    assert!(!faults.is_empty());
    let named = faults.iter().find(|f| f.to_string().contains("stale")).expect("a message that says stale");
    let at = match named {
        Fault::StaleFrame { at, .. } => *at,
        Fault::Ledger(breach) => breach.at,
        other => panic!("unexpected fault {other}"),
    };
    assert_eq!(at, from);
    // Both stop at most one half-step later.
    for events in [&fluid, &solid] {
        let Some(Event::Failed(report)) = events.last() else { panic!("both sides stop") };
        assert!(report.step <= 8, "stopped after step {}", report.step);
    }
}

#[test]
fn a_breach_is_only_counted_when_the_policy_warns() {
    let from = StepStage { step: 7, stage: sph::coupling::stage::Stage::Predictor };
    let stale = |inner| Box::new(Stale { inner, from, before: None }) as Box<dyn Exchange>;
    let (fluid, solid) = run_pair(&setup(1e-3, 0.05, BreachAction::Warn), stale, granted);
    assert!(fault(&fluid).is_none() && fault(&solid).is_none());
    let breaches: u64 = solid
        .iter()
        .map(|event| match event {
            Event::Step(report) => report.breaches,
            _ => 0,
        })
        .sum();
    assert!(breaches > 0);
}

#[test]
fn a_stop_ends_both_sides_at_the_granted_step_with_outputs_complete() {
    let stop_at_twelve = |sender: &mpsc::Sender<Command>| {
        sender.send(Command::GrantThrough(12)).unwrap();
        sender.send(Command::Stop).unwrap();
    };
    let (fluid, solid) = run_pair(&setup(1e-3, 0.05, BreachAction::Stop), |e| e, stop_at_twelve);
    for events in [&fluid, &solid] {
        let Some(Event::Finished(report)) = events.last() else { panic!("ends in order") };
        assert_eq!((report.step, report.reached_end), (12, false));
        assert!(matches!(events[events.len() - 2], Event::Probes(ref probes) if probes.step == 12));
    }
}

#[test]
fn a_fixed_step_far_above_its_limit_ends_the_run_at_that_half_step() {
    let setup = setup(1e-3, 0.05, BreachAction::Stop);
    let plan = &setup.plan();
    let from = StepStage { step: 7, stage: sph::coupling::stage::Stage::Corrector };
    for (limit, stops) in [(3.5e-5, false), (3.2e-5, true), (f64::NAN, true)] {
        let (mut fluid, _) = masses(&setup.domain);
        fluid.limit = (from, limit);
        let (sender, receiver) = mpsc::channel::<Command>();
        sender.send(Command::GrantThrough(u64::MAX)).unwrap();
        let mut events = Vec::new();
        let link = Link {
            partner_extent: Extent::default(),
            first_limit: 1.0,
            resume: None,
            partner_particles: None,
        };
        run(&mut fluid, plan, &link, None, &receiver, &mut |e| events.push(e));
        match fault(&events) {
            Some(Fault::Diverged(divergence)) if stops => {
                assert_eq!(divergence.at, from);
                assert!(divergence.quantity.contains("time step"), "{divergence}");
            }
            None if !stops => {}
            other => panic!("limit {limit}: {other:?}"),
        }
    }
}

#[test]
fn a_coordinator_that_is_gone_ends_the_run() {
    let setup = setup(1e-3, 0.05, BreachAction::Stop);
    let plan = &setup.plan();
    let (mut fluid, _) = masses(&setup.domain);
    let (sender, receiver) = mpsc::channel::<Command>();
    drop(sender);
    let mut events = Vec::new();
    let link =
        Link { partner_extent: Extent::default(), first_limit: 1.0, resume: None, partner_particles: None };
    run(&mut fluid, plan, &link, None, &receiver, &mut |e| events.push(e));
    assert!(matches!(fault(&events), Some(Fault::Aborted { .. })));
}
