//! The real solvers in one process, with doubles around their exchange.

use std::sync::mpsc;

use crate::bench;
use sph::coupling::driver::{self, Command, Event, Link, StepReport};
use sph::coupling::exchange::{Exchange, in_process_pair};
use sph::coupling::solver::{Fault, ParticleFields, Role, Solver};
use sph::coupling::stage::{Stage, StepStage};
use tests::doubles::StaleExchange;

/// What one side reported.
struct Side {
    steps: Vec<StepReport>,
    fault: Option<Fault>,
    state: ParticleFields,
}

/// Runs the tank with `margin` spacings of spare particles; `double` may wrap the exchange of a role.
fn couple(margin: &str, double: impl Fn(Role, Box<dyn Exchange>) -> Box<dyn Exchange>) -> [Side; 2] {
    let bench = bench();
    let case = bench.tank("case.toml", &[("margin_spacings = 1", &format!("margin_spacings = {margin}"))]);
    let case = coordinator::case::load(&case, &coordinator::results::state::read).unwrap();
    let fluid = fluid::plane_solver(case.fluid_setup().unwrap().plane().unwrap()).unwrap();
    let solid = solid::plane_solver(case.solid_setup().unwrap().plane().unwrap()).unwrap().solver;
    let first_limit = fluid.time_step_limit().min(solid.time_step_limit());
    let extents = [solid.extent().clone(), fluid.extent().clone()];
    let solvers: [Box<dyn Solver>; 2] = [fluid, solid];
    let (a, b) = in_process_pair();
    let exchanges: [Box<dyn Exchange>; 2] = [Box::new(a), Box::new(b)];
    let threads = solvers.into_iter().zip(exchanges).zip(extents).map(|((mut solver, exchange), extent)| {
        let exchange = double(solver.role(), exchange);
        let setup = case.run_plan();
        std::thread::spawn(move || {
            let link = Link { partner_extent: extent, first_limit, resume: None, partner_particles: None };
            let (commands, receiver) = mpsc::channel();
            commands.send(Command::GrantThrough(u64::MAX)).unwrap();
            let mut side = Side { steps: Vec::new(), fault: None, state: ParticleFields::default() };
            driver::run(&mut *solver, &setup, &link, Some(exchange), &receiver, &mut |event| match event {
                Event::Step(report) => side.steps.push(report),
                Event::Finished(report) => side.state = report.state,
                Event::Failed(report) => {
                    side.fault = Some(report.fault);
                    side.state = report.state;
                }
                Event::Probes(_) | Event::Snapshot(_) | Event::Checkpoint(_) | Event::Paused(_) => {}
            });
            side
        })
    });
    // All start before the first is waited for.
    let threads: Vec<_> = threads.collect();
    let sides: Vec<Side> = threads.into_iter().map(|thread| thread.join().unwrap()).collect();
    sides.try_into().unwrap_or_else(|_| unreachable!("two threads"))
}

#[test]
fn a_stale_frame_is_caught_at_its_half_step_by_the_side_that_sent_the_fresh_one() {
    for stage in Stage::BOTH {
        for (victim, witness) in [(Role::Fluid, Role::Solid), (Role::Solid, Role::Fluid)] {
            let stale = StepStage { step: 20, stage };
            let sides = couple("1", |role, exchange| {
                if role == victim { Box::new(StaleExchange::new(Boxed(exchange), stale)) } else { exchange }
            });
            let witness = &sides[witness.index()];
            match &witness.fault {
                Some(fault @ Fault::StaleFrame { at, sent, used }) => {
                    assert_eq!(*at, stale);
                    assert_ne!(sent, used);
                    let message = fault.to_string();
                    assert!(message.contains("stale") && message.contains("step 20"), "{message}");
                }
                other => panic!("{victim}, {stage:?}: {other:?}"),
            }
            // At most one half-step later: a stale corrector is detected with the next step's first frame.
            let steps = if stage == Stage::Predictor { 20 } else { 21 };
            assert_eq!(witness.steps.len(), steps, "{victim}, {stage:?}");
        }
    }
}

/// A boxed exchange as an exchange.
struct Boxed(Box<dyn Exchange>);

impl Exchange for Boxed {
    fn send(
        &mut self,
        frame: &sph::coupling::exchange::Frame,
    ) -> Result<(), sph::coupling::exchange::PeerError> {
        self.0.send(frame)
    }

    fn receive(
        &mut self,
        at: StepStage,
        frame: &mut sph::coupling::exchange::Frame,
    ) -> Result<(), sph::coupling::exchange::PeerError> {
        self.0.receive(at, frame)
    }
}

#[test]
fn a_wider_margin_sends_more_particles_and_the_same_bits_come_out() {
    let few = couple("1", |_, exchange| exchange);
    let many = couple("8", |_, exchange| exchange);
    for (few, many) in few.iter().zip(&many) {
        assert_eq!((few.fault.clone(), many.fault.clone()), (None, None));
        assert_eq!(few.state, many.state);
    }
    let sent = |sides: &[Side; 2]| sides[0].steps.last().unwrap().interface_particles;
    let ([water, solid], [more_water, more_solid]) = (sent(&few), sent(&many));
    assert!(more_water > water, "{water} and {more_water}");
    assert!(more_solid >= solid, "{solid} and {more_solid}");
}

#[test]
fn both_solvers_spell_units_alike() {
    let [fluid, solid] = couple("1", |_, exchange| exchange);
    let mut common = 0;
    for field in &fluid.state.fields {
        if let Some(other) = solid.state.field(&field.name) {
            assert_eq!(field.unit, other.unit, "{}", field.name);
            common += 1;
        }
    }
    assert!(common >= 5, "{common} common fields");
}
