//! Coupled runs over real connections.

use sph::coupling::driver::{Command, Event, FinalReport, Link};
use sph::coupling::exchange::{Exchange, Extent, Frame, PeerError, in_process_pair};
use sph::coupling::solver::{Fault, Role};
use sph::coupling::stage::StepStage;
use sph::space::SomeSpace;

use super::fake::{PLANE, Pair, SPATIAL, alone, assert_usable, row, setup, setup_in, soon};
use crate::description::{LinkPlan, Partner};
use crate::transport::client::{EventReceiver, RunAccess};

/// All events until the last.
async fn collect(events: &mut EventReceiver) -> Vec<Event> {
    let mut all = Vec::new();
    while let Some(event) = events.recv().await {
        all.push(event.unwrap());
    }
    all
}

/// Events without wall times, which differ from run to run.
fn timeless(events: &[Event]) -> Vec<String> {
    let timeless = |event: &Event| match event {
        Event::Step(report) => {
            let report = sph::coupling::driver::StepReport { elapsed: 0.0, waited: 0.0, ..*report };
            format!("{report:?}")
        }
        other => format!("{other:?}"),
    };
    events.iter().map(timeless).collect()
}

/// Equality that shows the first difference, not all of both.
fn assert_same(ours: &[String], theirs: &[String]) {
    for (k, (a, b)) in ours.iter().zip(theirs).enumerate() {
        let same = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
        let shown = |text: &str| text.chars().skip(same.saturating_sub(60)).take(300).collect::<String>();
        assert!(a == b, "event {k}: ...{} is not ...{}", shown(a), shown(b));
    }
    assert_eq!(ours.len(), theirs.len());
}

fn final_report(events: &[Event]) -> &FinalReport {
    match events.last() {
        Some(Event::Finished(report)) => report,
        other => {
            let text = format!("{other:?}");
            panic!("did not finish: {}", text.chars().take(300).collect::<String>())
        }
    }
}

/// Runs both rows in threads of this process, over the channel exchange.
fn in_process(space: SomeSpace, steps: u32) -> [Vec<Event>; 2] {
    let setups = [Role::Fluid, Role::Solid].map(|role| setup_in(space, role, "run", steps));
    let rows = setups.each_ref().map(row);
    let extents = rows.each_ref().map(|row| row.extent().clone());
    let first_limit = rows[0].time_step_limit().min(rows[1].time_step_limit());
    let (a, b) = in_process_pair();
    let mut exchanges = [Some(a), Some(b)];
    std::thread::scope(|scope| {
        let mut threads = Vec::new();
        for (k, mut row) in rows.into_iter().enumerate() {
            let link = Link {
                partner_extent: extents[1 - k].clone(),
                first_limit,
                resume: None,
                partner_particles: None,
            };
            let run = setups[k].plan();
            let exchange = exchanges[k].take().map(|e| Box::new(e) as Box<dyn Exchange>);
            threads.push(scope.spawn(move || {
                let (commands, ordered) = std::sync::mpsc::channel();
                commands.send(Command::GrantThrough(u64::from(steps))).unwrap();
                let mut events = Vec::new();
                sph::coupling::driver::run(&mut *row, &run, &link, exchange, &ordered, &mut |event| {
                    events.push(event)
                });
                events
            }));
        }
        let mut results = threads.into_iter().map(|thread| thread.join().unwrap());
        [results.next().unwrap(), results.next().unwrap()]
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn two_processes_and_one_give_the_same_bits() {
    for space in [PLANE, SPATIAL] {
        compare_processes(space).await;
    }
}

async fn compare_processes(space: SomeSpace) {
    const STEPS: u32 = 60;
    let mut pair = Pair::linked_in(space, "run", STEPS).await;
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, mut solid_events) = pair.solid.run().await.unwrap();
    // Several grants, the last beyond the end.
    for granted in [1, 7, 1000] {
        fluid_commands.send(Command::GrantThrough(granted)).unwrap();
        solid_commands.send(Command::GrantThrough(granted)).unwrap();
    }
    let (fluid, solid) =
        soon("the run", async { tokio::join!(collect(&mut fluid_events), collect(&mut solid_events)) }).await;
    let expected = in_process(space, STEPS);
    assert_same(&timeless(&fluid), &timeless(&expected[0]));
    assert_same(&timeless(&solid), &timeless(&expected[1]));
    let bits = |events: &[Event]| -> Vec<u64> {
        final_report(events).state.fields.iter().flat_map(|f| &f.values).map(|v| v.to_bits()).collect()
    };
    assert_eq!(bits(&fluid), bits(&expected[0]));
    let position = final_report(&fluid).state.field("position").unwrap();
    assert_eq!(position.components, space.dimensions());
    // The rows really met: the solid's has lost speed.
    let slowed = final_report(&solid).state.field("velocity").unwrap().values[0];
    assert!(slowed > -0.4, "{slowed}");
    assert!(final_report(&fluid).reached_end);
    pair.fluid.close().await.unwrap();
    pair.solid.close().await.unwrap();
    assert_usable(&mut pair.fluid, Role::Fluid).await;
    for server in pair.servers {
        server.end().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stop_ends_both_sides_at_the_end_of_the_grant() {
    let mut pair = Pair::linked("run", 100_000).await;
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, mut solid_events) = pair.solid.run().await.unwrap();
    for commands in [&fluid_commands, &solid_commands] {
        commands.send(Command::GrantThrough(12)).unwrap();
        commands.send(Command::Stop).unwrap();
    }
    let (fluid, solid) =
        soon("the run", async { tokio::join!(collect(&mut fluid_events), collect(&mut solid_events)) }).await;
    assert_eq!((final_report(&fluid).step, final_report(&solid).step), (12, 12));
    assert!(!final_report(&fluid).reached_end);
    assert!(fluid_commands.send(Command::GrantThrough(13)).is_err());
    // Ended, not yet closed: still held.
    let access = RunAccess::new("another").unwrap();
    let error = pair.fluid.open(&alone(Role::Fluid, "other", 1), &access).await.unwrap_err();
    assert!(error.message.contains("ENDED"), "{error}");
    pair.fluid.close().await.unwrap();
    assert_usable(&mut pair.fluid, Role::Fluid).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_divergence_is_told_to_both_and_carries_its_state() {
    let mut pair = Pair::linked("diverge", 50).await;
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, mut solid_events) = pair.solid.run().await.unwrap();
    fluid_commands.send(Command::GrantThrough(50)).unwrap();
    solid_commands.send(Command::GrantThrough(50)).unwrap();
    let (fluid, _) =
        soon("the run", async { tokio::join!(collect(&mut fluid_events), collect(&mut solid_events)) }).await;
    match fluid.last() {
        Some(Event::Failed(report)) => {
            assert_eq!(report.step, 3);
            assert_eq!(report.state.id.len(), super::fake::MASSES);
            let Fault::Diverged(divergence) = &report.fault else { panic!("{:?}", report.fault) };
            assert!(divergence.value.is_nan());
            assert_eq!(divergence.particle, Some(6));
        }
        other => panic!("{other:?}"),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_aborted_partner_says_farewell_with_its_reason() {
    let mut pair = Pair::linked("run", 1000).await;
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, mut solid_events) = pair.solid.run().await.unwrap();
    // The solid is granted more and waits for the fluid, which then ends.
    solid_commands.send(Command::GrantThrough(20)).unwrap();
    fluid_commands.send(Command::GrantThrough(5)).unwrap();
    fluid_commands.send(Command::Stop).unwrap();
    let (fluid, solid) =
        soon("the run", async { tokio::join!(collect(&mut fluid_events), collect(&mut solid_events)) }).await;
    assert_eq!(final_report(&fluid).step, 5);
    let Some(Event::Failed(report)) = solid.last() else { panic!("{:?}", solid.last()) };
    let text = report.fault.to_string();
    assert!(text.contains("finished at step 5") && text.contains("step 5 predictor"), "{text}");
}

#[tokio::test(flavor = "multi_thread")]
async fn one_participant_runs_alone_with_complete_snapshots() {
    let server = super::fake::TestServer::start(Role::Solid);
    let mut client = server.client().await;
    let access = RunAccess::new("a test").unwrap();
    let report = client.open(&alone(Role::Solid, "alone", 20), &access).await.unwrap();
    assert!(report.constants.coupling.is_none() && report.fields_sent.is_empty());
    let plan = LinkPlan {
        first_limit: f64::INFINITY,
        partner_extent: Extent::default(),
        partner: Partner::Alone,
        partner_particles: None,
    };
    client.link(&plan).await.unwrap();
    let (commands, mut events) = client.run().await.unwrap();
    commands.send(Command::GrantThrough(20)).unwrap();
    // The receiver alone keeps the run.
    drop(commands);
    let events = soon("the run", collect(&mut events)).await;
    let snapshots = events
        .iter()
        .filter(|event| matches!(event, Event::Snapshot(s) if s.id.len() == super::fake::MASSES));
    // At 0, at the listed 3 ms, at 10 ms, and at the end.
    assert_eq!(snapshots.count(), 4);
    assert_eq!(final_report(&events).step, 20);
    client.close().await.unwrap();
}

/// An exchange that is never met.
struct Never;

impl Exchange for Never {
    fn send(&mut self, _: &Frame) -> Result<(), PeerError> {
        Ok(())
    }

    fn receive(&mut self, _: StepStage, _: &mut Frame) -> Result<(), PeerError> {
        Err(PeerError::Cancelled)
    }
}

#[test]
fn the_driver_calls_a_cancelled_wait_an_abort() {
    let setup = setup(Role::Fluid, "run", 5);
    let mut row = row(&setup);
    let link =
        Link { partner_extent: Extent::default(), first_limit: 1.0, resume: None, partner_particles: None };
    let (commands, ordered) = std::sync::mpsc::channel();
    commands.send(Command::GrantThrough(5)).unwrap();
    let mut last = None;
    sph::coupling::driver::run(
        &mut *row,
        &setup.plan(),
        &link,
        Some(Box::new(Never)),
        &ordered,
        &mut |event| last = Some(event),
    );
    let Some(Event::Failed(report)) = last else { panic!("{last:?}") };
    assert!(matches!(report.fault, Fault::Aborted { .. }));
}
