//! The iterated half-step with two analytic participants: a mass, and a fluid that is a damper and a spring.

use std::sync::mpsc;

use sph::coupling::driver::{Command, Event, Link, StepReport, run};
use sph::coupling::exchange::{Column, Exchange, Extent, Frame, PeerError, StateColumns, in_process_pair};
use sph::coupling::ledger::{EnergyReport, InterfaceSums, StageBudget, lifted};
use sph::coupling::saved::{RestoreError, SavedState};
use sph::coupling::solver::{Counts, Divergence, NoLoads, NotUpdated, ParticleFields, Role, Solver};
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::interface::load_sums;
use sph::interface::states::InterfaceStates;
use sph::setup::{
    BodyForce, BreachAction, Coupling, CouplingKind, FluidParameters, GradientCorrection, ImplicitCoupling,
    InterfaceLaw, LedgerPolicy, NonConvergence, OutputPlan, Relaxation, RunSetup, StepPolicy, TimePlan,
};
use sph::space::Vector;
use sph::space::domain::Domain;

const MASS: f64 = 2.0;

/// F = −c v − k x on every coupling point.
#[derive(Clone, Copy)]
struct Law {
    damper: f64,
    spring: f64,
}

/// Either side: the fluid gives forces by the law, the solid is a mass that takes them.
struct Side {
    role: Role,
    law: Law,
    domain: Domain,
    extent: Extent,
    position: Vector,
    velocity: Vector,
    base: (Vector, Vector),
    force: Vector,
    sums: InterfaceSums,
    updates: bool,
}

impl Side {
    fn new(role: Role, law: Law, domain: &Domain) -> Self {
        Self {
            role,
            law,
            domain: *domain,
            extent: Extent { version: 1, boxes: Column::from_iter([[-9.0, -9.0, 9.0, 9.0]]) },
            position: Vector::new(0.1, 0.0),
            velocity: Vector::new(1.0, 0.5),
            base: (Vector::zeros(), Vector::zeros()),
            force: Vector::zeros(),
            sums: InterfaceSums::default(),
            updates: true,
        }
    }

    fn moved(&self, duration: f64) -> (Vector, Vector) {
        (self.base.0 + self.velocity * duration, self.base.1 + self.force * (duration / MASS))
    }
}

impl Solver for Side {
    fn role(&self) -> Role {
        self.role
    }

    fn begin_stage(&mut self, time: &StageTime) -> Result<(), Divergence> {
        if time.at.stage == Stage::Predictor {
            self.base = (self.position, self.velocity);
        }
        Ok(())
    }

    fn time_step_limit(&self) -> f64 {
        1.0
    }

    fn extent(&self) -> &Extent {
        &self.extent
    }

    fn interface(&mut self, _: &Extent, _: f64, states: &mut StateColumns) -> u64 {
        let mut own = <InterfaceStates>::default();
        if self.role == Role::Solid {
            own.id.push(0);
            own.group.push(0);
            own.mass.push(MASS);
            own.position.push(self.position);
            own.velocity.push(self.velocity);
            own.density.push(1.0);
            own.pressure.push(0.0);
        }
        own.write(states);
        1
    }

    fn covered_by(&self, _: &Extent, _: f64) -> Result<(), f64> {
        Ok(())
    }

    fn evaluate_own(&mut self, _: &StageTime) {}

    fn evaluate_cross(&mut self, _: &StageTime, _: &StateColumns, _: &StateColumns) {}

    fn reactions(
        &mut self,
        _: &StageTime,
        _: &StateColumns,
        points: &StateColumns,
        forces: &mut Column,
    ) -> Result<(), NoLoads> {
        let points = <InterfaceStates>::from(points);
        let force = |s: usize| -self.law.damper * points.velocity[s] - self.law.spring * points.position[s];
        let all: Vec<Vector> = (0..points.len()).map(force).collect();
        let on_points = load_sums(&self.domain, &points, &all);
        self.sums = InterfaceSums { force: -on_points.force, torque: -on_points.torque, ..on_points };
        forces.fill(all);
        Ok(())
    }

    fn evaluate_loads(&mut self, _: &StageTime, own: &StateColumns, forces: &Column) -> Result<(), NoLoads> {
        self.force = first(forces);
        self.sums = load_sums(&self.domain, &own.into(), &[self.force]);
        Ok(())
    }

    fn update_stage(
        &mut self,
        time: &StageTime,
        _: &StateColumns,
        forces: &Column,
    ) -> Result<(), NotUpdated> {
        if !self.updates {
            return Err(NotUpdated::NotOffered);
        }
        self.force = first(forces);
        (self.position, self.velocity) = self.moved(0.5 * time.time_step);
        Ok(())
    }

    fn advance(&mut self, time: &StageTime) -> Result<StageBudget, Divergence> {
        let mut budget =
            StageBudget { interface: self.sums, duration: time.duration(), ..StageBudget::default() };
        if self.role == Role::Solid {
            (self.position, self.velocity) = self.moved(time.duration());
            budget.momentum_change = lifted(&(MASS * (self.velocity - self.base.1)));
            budget.gross_momentum = MASS * (self.velocity.norm() + self.base.1.norm());
        }
        Ok(budget)
    }

    fn end_step(&mut self, _: &StageTime) -> Result<(), Divergence> {
        Ok(())
    }

    fn energies(&self) -> EnergyReport {
        EnergyReport::default()
    }

    fn probes(&mut self, _: f64, values: &mut Vec<f64>) {
        values.extend([self.position.x, self.position.y, self.velocity.x, self.velocity.y]);
    }

    fn snapshot(&mut self, step: u64, time: f64) -> ParticleFields {
        ParticleFields { step, time, id: vec![0], ..ParticleFields::default() }
    }

    fn counts(&self) -> Counts {
        Counts { particles: 1, ..Counts::default() }
    }

    fn save(&self, _: &mut SavedState) {}

    fn restore(&mut self, _: &SavedState) -> Result<(), RestoreError> {
        Ok(())
    }
}

fn first(forces: &Column) -> Vector {
    Vector::new(forces.values[0], forces.values[1])
}

const AITKEN: ImplicitCoupling = ImplicitCoupling {
    relaxation: Relaxation::Aitken,
    tolerance: 1e-12,
    limit: 20,
    non_convergence: NonConvergence::Stop,
};

fn setup(time_step: f64, end_time: f64, implicit: Option<ImplicitCoupling>) -> RunSetup {
    RunSetup {
        run_id: "damper".into(),
        domain: Domain { lower: Vector::new(-9.0, -9.0), upper: Vector::new(9.0, 9.0), periodic: [false; 2] },
        time: TimePlan { start_time: 0.0, end_time, step: StepPolicy::Fixed { time_step } },
        body_force: BodyForce { gravity: Vector::zeros(), expressions: None },
        outputs: OutputPlan::default(),
        ledger: LedgerPolicy { action: BreachAction::Stop, ..LedgerPolicy::default() },
        coupling: Some(Coupling {
            kind: CouplingKind::Loads,
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
            repulsion: 0.0,
            margin: 0.05,
            implicit,
        }),
    }
}

/// Events of fluid and solid; `alter` may change the solid, `wrap` put a faulty exchange before its partner.
fn run_sides(
    setup: &RunSetup,
    law: Law,
    alter: impl FnOnce(&mut Side),
    wrap: impl FnOnce(Box<dyn Exchange>) -> Box<dyn Exchange>,
) -> [Vec<Event>; 2] {
    let plan = &setup.plan();
    let mut fluid = Side::new(Role::Fluid, law, &setup.domain);
    let mut solid = Side::new(Role::Solid, law, &setup.domain);
    alter(&mut solid);
    let (a, b) = in_process_pair();
    let link = Link {
        partner_extent: fluid.extent.clone(),
        first_limit: 1.0,
        resume: None,
        partner_particles: None,
    };
    let link = &link;
    let granted = || {
        let (sender, receiver) = mpsc::channel();
        sender.send(Command::GrantThrough(u64::MAX)).unwrap();
        (sender, receiver)
    };
    let (_fluid_sender, fluid_commands) = granted();
    let (_solid_sender, solid_commands) = granted();
    let to_fluid = wrap(Box::new(b));
    std::thread::scope(|scope| {
        let partner = scope.spawn(move || {
            let mut events = Vec::new();
            run(&mut solid, plan, link, Some(to_fluid), &solid_commands, &mut |e| events.push(e));
            events
        });
        let mut events = Vec::new();
        run(&mut fluid, plan, link, Some(Box::new(a)), &fluid_commands, &mut |e| events.push(e));
        [events, partner.join().unwrap()]
    })
}

fn run_pair(setup: &RunSetup, law: Law) -> [Vec<Event>; 2] {
    run_sides(setup, law, |_| {}, |exchange| exchange)
}

fn steps(events: &[Event]) -> Vec<StepReport> {
    let step = |event: &Event| if let Event::Step(report) = event { Some(*report) } else { None };
    events.iter().filter_map(step).collect()
}

/// Position and velocity at the end.
fn end(events: &[Event]) -> (Vector, Vector) {
    assert!(matches!(events.last(), Some(Event::Finished(_))), "{:?}", events.last());
    let probes =
        |event: &Event| if let Event::Probes(probes) = event { Some(probes.values.clone()) } else { None };
    let values = events.iter().rev().find_map(probes).unwrap();
    (Vector::new(values[0], values[1]), Vector::new(values[2], values[3]))
}

fn failure(events: &[Event]) -> String {
    match events.last() {
        Some(Event::Failed(report)) => report.fault.to_string(),
        other => panic!("expected a failure, got {other:?}"),
    }
}

#[test]
fn a_stiff_damper_follows_the_implicit_midpoint_rule_where_one_exchange_diverges() {
    // z = dt c/m = 10: explicitly v grows by 1 - z + z²/2 = 41 a step, implicitly it is taken by (1 - z/2)/(1 + z/2).
    let law = Law { damper: 200.0, spring: 0.0 };
    let [_, explicit] = run_pair(&setup(0.1, 1.0, None), law);
    assert!(end(&explicit).1.norm() > 1e10);
    let [fluid, solid] = run_pair(&setup(0.1, 1.0, Some(AITKEN)), law);
    let expected = Vector::new(1.0, 0.5) * (-4.0f64 / 6.0).powi(10);
    let error = (end(&solid).1 - expected).norm();
    // Ten steps at a tolerance of 1e-12 of forces that give or take z/2 v each.
    assert!(error < 1e-10, "velocity is off by {error}");
    let (fluid, solid) = (steps(&fluid), steps(&solid));
    for (ours, theirs) in fluid.iter().zip(&solid) {
        assert_eq!((ours.iterations, ours.unconverged), (theirs.iterations, theirs.unconverged));
        // One direction: the second factor is exact but for round-off.
        assert!((1..=4).contains(&ours.iterations), "{} iterations", ours.iterations);
        // The momentum budget has the accepted forces alone, and they balance to the last bit.
        for stage in 0..2 {
            assert_eq!(ours.budgets[stage].interface.force, -theirs.budgets[stage].interface.force);
            assert!(theirs.budgets[stage].momentum_residual() < 1e-12);
        }
    }
}

#[test]
fn iterating_keeps_second_order() {
    let law = Law { damper: 3.0, spring: 80.0 };
    let end = |time_step: f64| end(&run_pair(&setup(time_step, 0.4, Some(AITKEN)), law)[1]).0;
    let (coarse, medium, fine) = (end(4e-3), end(2e-3), end(1e-3));
    let order = ((coarse - medium).norm() / (medium - fine).norm()).log2();
    assert!((order - 2.0).abs() < 0.05, "observed order {order}");
}

#[test]
fn a_loose_tolerance_leaves_the_bits_of_a_single_exchange() {
    let law = Law { damper: 3.0, spring: 80.0 };
    let loose = ImplicitCoupling { tolerance: 1e3, ..AITKEN };
    let [_, once] = run_pair(&setup(1e-3, 0.05, None), law);
    let [_, converged] = run_pair(&setup(1e-3, 0.05, Some(loose)), law);
    assert_eq!(end(&once), end(&converged));
    assert!(steps(&converged).iter().all(|report| report.iterations == 0 && !report.unconverged));
}

#[test]
fn nothing_of_the_iterations_is_kept_for_the_next_step() {
    let law = Law { damper: 200.0, spring: 80.0 };
    // Loose, so that where iterations begin shows in where they end.
    let loose = Some(ImplicitCoupling { tolerance: 1e-2, relaxation: Relaxation::Fixed(0.2), ..AITKEN });
    let [_, whole] = run_pair(&setup(0.1, 0.2, loose), law);
    let [_, first] = run_pair(&setup(0.1, 0.1, loose), law);
    let begin = |side: &mut Side| (side.position, side.velocity) = end(&first);
    let [_, second] = run_sides(&setup(0.1, 0.1, loose), law, begin, |exchange| exchange);
    assert_eq!(end(&whole), end(&second));
    assert!(steps(&second)[0].iterations > 1);
}

#[test]
fn the_limit_of_iterations_ends_the_run_or_is_counted() {
    let law = Law { damper: 200.0, spring: 0.0 };
    let short = ImplicitCoupling { limit: 1, ..AITKEN };
    let [fluid, solid] = run_pair(&setup(0.1, 1.0, Some(short)), law);
    let text = failure(&solid);
    for part in ["step 0 corrector", "after 1 iterations", "tolerance", "1e-12", "time step"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(failure(&fluid).contains("exchange failed"), "{}", failure(&fluid));
    let accepting = ImplicitCoupling { non_convergence: NonConvergence::Accept, ..short };
    let events = run_pair(&setup(0.1, 0.3, Some(accepting)), law);
    for events in &events {
        let unconverged: Vec<bool> = steps(events).iter().map(|report| report.unconverged).collect();
        assert_eq!(unconverged, [true; 3]);
    }
}

/// Changes a frame.
type Spoil = fn(&mut Frame);

/// Spoils the frames of one half-step on their way to the fluid.
struct Spoiled {
    inner: Box<dyn Exchange>,
    spoil: Spoil,
}

impl Exchange for Spoiled {
    fn send(&mut self, frame: &Frame) -> Result<(), PeerError> {
        let mut frame = frame.clone();
        if frame.time.at == (StepStage { step: 2, stage: Stage::Corrector }) {
            (self.spoil)(&mut frame);
        }
        self.inner.send(&frame)
    }

    fn receive(&mut self, at: StepStage, frame: &mut Frame) -> Result<(), PeerError> {
        self.inner.receive(at, frame)
    }
}

#[test]
fn frames_out_of_sequence_are_refused_with_what_was_expected() {
    let law = Law { damper: 200.0, spring: 0.0 };
    let setup = setup(0.1, 1.0, Some(AITKEN));
    let cases: [(Spoil, &str); 4] = [
        (
            |frame| frame.iteration += u32::from(frame.iteration > 0),
            "expected iteration 1 of step 2 corrector, got iteration 2",
        ),
        (|frame| frame.iteration = 0, "expected iteration 1 of step 2 corrector, got iteration 0"),
        (|frame| frame.iteration += u32::from(frame.acceptance.is_some()), "got the acceptance of iteration"),
        (
            |frame| frame.time.at.step += u64::from(frame.iteration == 1),
            "expected a frame of step 2 corrector",
        ),
    ];
    for (spoil, expected) in cases {
        let [fluid, _] = run_sides(&setup, law, |_| {}, |inner| Box::new(Spoiled { inner, spoil }));
        let text = failure(&fluid);
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn a_solid_that_never_accepts_is_stopped_at_the_limit() {
    let law = Law { damper: 200.0, spring: 0.0 };
    let patient = ImplicitCoupling { limit: 1, non_convergence: NonConvergence::Accept, ..AITKEN };
    let spoil = |frame: &mut Frame| {
        frame.iteration += u32::from(frame.acceptance.is_some());
        frame.acceptance = None;
    };
    let [fluid, _] =
        run_sides(&setup(0.1, 1.0, Some(patient)), law, |_| {}, |inner| Box::new(Spoiled { inner, spoil }));
    let text = failure(&fluid);
    assert!(text.contains("expected the acceptance of iteration 1 of step 2 corrector"), "{text}");
}

#[test]
fn a_solver_without_implicit_coupling_says_so() {
    let law = Law { damper: 200.0, spring: 0.0 };
    let [_, solid] = run_sides(&setup(0.1, 1.0, Some(AITKEN)), law, |side| side.updates = false, |e| e);
    let text = failure(&solid);
    assert!(
        text.contains("does not offer implicit coupling") && text.contains("interface.iterate"),
        "{text}"
    );
}
