//! Saving and restoring over the wire.

use sph::coupling::driver::{Command, Event};
use sph::coupling::solver::{ParticleFields, Role};

use super::fake::{Pair, TestServer, alone, assert_usable, setup, soon};
use crate::checkpoint::{CheckpointData, CheckpointHeader, digest};
use crate::convert::decode_state;
use crate::description::{LinkPlan, Partner};
use crate::error::RpcCode;
use crate::transport::client::{EventReceiver, ParticipantClient, RunAccess};

const STEPS: u32 = 60;

/// Hears events until `step` steps are completed.
async fn hear_steps(events: &mut EventReceiver, step: u64) {
    soon("the step", async {
        loop {
            match events.recv().await.unwrap().unwrap() {
                Event::Step(report) if report.step + 1 == step => return,
                _ => {}
            }
        }
    })
    .await;
}

/// Grants all steps of both and returns their final states.
async fn to_the_end(fluid: &mut ParticipantClient, solid: &mut ParticipantClient) -> [ParticleFields; 2] {
    let (fluid_commands, mut fluid_events) = fluid.run().await.unwrap();
    let (solid_commands, mut solid_events) = solid.run().await.unwrap();
    for commands in [&fluid_commands, &solid_commands] {
        commands.send(Command::GrantThrough(1000)).unwrap();
    }
    let last = async |events: &mut EventReceiver| loop {
        if let Event::Finished(report) = events.recv().await.unwrap().unwrap() {
            return report.state;
        }
    };
    let (fluid, solid) =
        soon("the end", async { tokio::join!(last(&mut fluid_events), last(&mut solid_events)) }).await;
    [fluid, solid]
}

/// Checkpoints of both sides after 25 steps, with the run closed afterwards.
async fn saved(pair: &mut Pair) -> [CheckpointData; 2] {
    let (fluid_commands, mut fluid_events) = pair.fluid.run().await.unwrap();
    let (solid_commands, mut solid_events) = pair.solid.run().await.unwrap();
    for commands in [&fluid_commands, &solid_commands] {
        commands.send(Command::GrantThrough(25)).unwrap();
    }
    hear_steps(&mut fluid_events, 25).await;
    hear_steps(&mut solid_events, 25).await;
    let error = pair.fluid.checkpoint(24).await.unwrap_err();
    assert_eq!(error.code, RpcCode::FailedPrecondition);
    assert!(error.message.contains("is 24; expected: 25"), "{error}");
    let data = [pair.fluid.checkpoint(25).await.unwrap(), pair.solid.checkpoint(25).await.unwrap()];
    // Taking one changes nothing: the next is the same.
    assert_eq!(pair.fluid.checkpoint(25).await.unwrap(), data[0]);
    pair.fluid.close().await.unwrap();
    pair.solid.close().await.unwrap();
    data
}

#[tokio::test(flavor = "multi_thread")]
async fn a_restored_run_ends_with_the_bits_of_one_that_was_never_saved() {
    let mut whole = Pair::linked("run", STEPS).await;
    let expected = to_the_end(&mut whole.fluid, &mut whole.solid).await;
    let mut pair = Pair::linked("run", STEPS).await;
    let [fluid_data, solid_data] = saved(&mut pair).await;
    let servers = [TestServer::start(Role::Fluid), TestServer::start(Role::Solid)];
    let (mut fluid, mut solid) = (servers[0].client().await, servers[1].client().await);
    let access = RunAccess::new("a test").unwrap();
    fluid.open(&setup(Role::Fluid, "run", STEPS), &access).await.unwrap();
    solid.open(&setup(Role::Solid, "run", STEPS), &access).await.unwrap();
    let f = fluid.restore(&fluid_data, 1).await.unwrap();
    let s = solid.restore(&solid_data, 1).await.unwrap();
    assert_eq!((f.step, s.step), (25, 25));
    let plan = |extent: &sph::coupling::exchange::Extent, partner| LinkPlan {
        first_limit: 1.0,
        partner_extent: extent.clone(),
        partner,
        partner_particles: None,
    };
    solid.link(&plan(&f.extent, Partner::Listen)).await.unwrap();
    fluid.link(&plan(&s.extent, Partner::Dial(solid.address().into()))).await.unwrap();
    assert_eq!(to_the_end(&mut fluid, &mut solid).await, expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn checkpoints_that_do_not_belong_are_refused_and_leave_the_server_free() {
    let mut pair = Pair::linked("run", STEPS).await;
    let [_, good] = saved(&mut pair).await;
    assert!(decode_state(&good.data).is_ok());
    let with = |change: &dyn Fn(&mut CheckpointHeader)| {
        let mut data = good.clone();
        change(&mut data.header);
        data
    };
    let other_data = |data: Vec<u8>| CheckpointData {
        header: good.header.clone(),
        sha256: digest(&data),
        data: data.into(),
    };
    let mut shorter = decode_state(&good.data).unwrap();
    shorter.arrays.pop();
    let no_number = good.data.len() - 8;
    let mut not_finite = good.data.to_vec();
    not_finite[no_number..].copy_from_slice(&f64::NAN.to_le_bytes());
    let cases = [
        (with(&|h| h.arithmetic = "f64x8".into()), RpcCode::FailedPrecondition, "f64x8"),
        (with(&|h| h.build = "another".into()), RpcCode::FailedPrecondition, "another"),
        (with(&|h| h.role = Role::Fluid), RpcCode::FailedPrecondition, "role"),
        (with(&|h| h.step = 26), RpcCode::InvalidArgument, "step 26"),
        (with(&|h| h.time = f64::NAN), RpcCode::InvalidArgument, "time_s_bits"),
        (CheckpointData { sha256: [0; 32], ..good.clone() }, RpcCode::InvalidArgument, "sha256"),
        (other_data(vec![1; 64]), RpcCode::InvalidArgument, "no saved state"),
        (other_data(crate::convert::encode_state(shorter)), RpcCode::InvalidArgument, "is missing"),
        (other_data(not_finite), RpcCode::InvalidArgument, "must be finite"),
        (other_data(vec![0; 8 << 20]), RpcCode::InvalidArgument, "total_bytes"),
    ];
    let server = TestServer::start(Role::Solid);
    let mut client = server.client().await;
    for (data, code, words) in cases {
        let access = RunAccess::new("a test").unwrap();
        client.open(&alone(Role::Solid, "run", STEPS), &access).await.unwrap();
        let error = soon("the refusal", client.restore(&data, 1)).await.unwrap_err();
        assert_eq!(error.code, code, "{error}");
        assert!(error.message.contains(words), "no {words:?} in {error}");
        assert_usable(&mut server.client().await, Role::Solid).await;
    }
}
