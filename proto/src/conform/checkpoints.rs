//! Checkpoint and Restore by replay: the only proof that a checkpoint holds everything.

use bytes::Bytes;
use sph::coupling::exchange::Extent;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use super::bench::{Bench, open_request};
use super::scene::Scene;
use super::{Finding, connect, not_offered, passed};
use crate::convert::{BatchItem, decode_batch, encode_command, link_to_wire};
use crate::description::{LinkPlan, Partner};
use crate::transport::security::SecuredChannel;
use crate::transport::token::Token;
use crate::wire;
use crate::wire::participant_client::ParticipantClient as WireClient;
use sph::coupling::driver::Command;

/// Step at which the checkpoint is taken, and steps of the whole run.
const SAVED: u64 = 10;
const STEPS: u32 = 20;
/// Epoch of the first run, and of the restored one.
const EPOCHS: [u32; 2] = [0, 1];

/// Raw calls for one run without partner.
struct Replay<'a> {
    bench: &'a Bench,
    client: WireClient<SecuredChannel>,
    scene: Scene,
    token: Token,
}

impl<'a> Replay<'a> {
    async fn at(bench: &'a Bench, address: &str) -> Result<Self, String> {
        let channel = connect(address, bench).await?;
        let scene = bench.fit(Scene {
            coupled: false,
            steps: STEPS,
            gravity: bench.vector([0.3, -9.81, 0.2]),
            compression: 0.01,
            ..bench.still()
        });
        let limit = crate::limits::MAX_MESSAGE_BYTES;
        let client = WireClient::new(channel).max_decoding_message_size(limit);
        Ok(Self { bench, client, scene, token: Token::fresh()? })
    }

    fn run_id(&self) -> String {
        self.scene.setup(self.bench.role).run_id().to_owned()
    }

    async fn open(&mut self) -> Result<f64, String> {
        let request = open_request(&self.scene.setup(self.bench.role), &self.token);
        let answer = self.bench.within("Open", self.client.open(request)).await?;
        let reply = answer.map_err(|status| format!("Open: {status}"))?;
        reply.time_step_limit_s.ok_or_else(|| "the reply to Open has no time-step limit".into())
    }

    async fn link(&mut self, first_limit: f64) -> Result<(), String> {
        let plan = LinkPlan {
            first_limit,
            partner_extent: Extent::default(),
            partner: Partner::Alone,
            partner_particles: None,
        };
        let request = wire::LinkRequest { run_id: self.run_id(), ..link_to_wire(&plan) };
        let answer = self.client.link(self.token.attach(request));
        self.bench.within("Link", answer).await?.map(drop).map_err(|status| format!("Link: {status}"))
    }

    /// Runs to the end; takes a checkpoint on the way when asked. Answers the data of the final snapshot.
    async fn run(&mut self, epoch: u32, save: bool) -> Result<(Vec<u8>, Vec<wire::CheckpointChunk>), String> {
        let request = self.token.attach(wire::SnapshotsRequest { run_id: self.run_id() });
        let answer = self.bench.within("Snapshots", self.client.snapshots(request)).await?;
        let mut snapshots = answer.map_err(|status| format!("Snapshots: {status}"))?;
        let (commands, stream) = mpsc::channel(4);
        let request = self.token.attach(ReceiverStream::new(stream));
        let answer = self.bench.within("Run", self.client.run(request)).await?;
        let mut events = answer.map_err(|status| format!("Run: {status}"))?;
        let run_id = self.run_id();
        let grant = |through| encode_command(&run_id, epoch, Command::GrantThrough(through));
        let gone = |_| "the server takes no commands".to_owned();
        let mut saved = Vec::new();
        if save {
            commands.send(grant(SAVED)).await.map_err(gone)?;
            self.until(
                &mut events,
                |item| matches!(item, BatchItem::Step(report) if report.step + 1 == SAVED),
            )
            .await?;
            saved = self.save(epoch).await?;
        }
        commands.send(grant(1 << 40)).await.map_err(gone)?;
        self.until(&mut events, |item| matches!(item, BatchItem::Finished { .. })).await?;
        let mut last = Vec::new();
        while let Ok(Some(chunk)) = snapshots.message().await {
            match chunk.part {
                Some(wire::snapshot_chunk::Part::Header(_)) => last.clear(),
                Some(wire::snapshot_chunk::Part::Data(data)) => last.extend_from_slice(&data),
                None => {}
            }
        }
        Ok((last, saved))
    }

    async fn until(
        &self,
        events: &mut tonic::Streaming<wire::EventBatch>,
        reached: impl Fn(&BatchItem) -> bool,
    ) -> Result<(), String> {
        loop {
            let batch = tokio::time::timeout(self.bench.deadline, events.message()).await;
            let batch = batch.map_err(|_| "no event in time")?.map_err(|status| format!("Run: {status}"))?;
            let Some(batch) = batch else { return Err("the events ended".into()) };
            for item in decode_batch(&batch).map_err(|e| e.to_string())? {
                if let BatchItem::Failed { fault, .. } = &item {
                    return Err(format!("the run failed: {fault}"));
                }
                if reached(&item) {
                    return Ok(());
                }
            }
        }
    }

    /// The chunks of a checkpoint at step [`SAVED`].
    async fn save(&mut self, epoch: u32) -> Result<Vec<wire::CheckpointChunk>, String> {
        let request =
            self.token.attach(wire::CheckpointRequest { run_id: self.run_id(), epoch, step: SAVED });
        let answer = self.bench.within("Checkpoint", self.client.checkpoint(request)).await?;
        let mut stream = answer.map_err(|status| format!("Checkpoint: {status}"))?;
        let mut chunks = Vec::new();
        while let Some(chunk) = stream.message().await.map_err(|status| format!("Checkpoint: {status}"))? {
            chunks.push(chunk);
        }
        let bytes: usize = chunks
            .iter()
            .map(|chunk| match &chunk.part {
                Some(wire::checkpoint_chunk::Part::Data(data)) => data.len(),
                _ => 0,
            })
            .sum();
        if bytes == 0 {
            return Err("the checkpoint is empty: it holds no data at all".into());
        }
        Ok(chunks)
    }

    async fn restore(&mut self, chunks: &[wire::CheckpointChunk]) -> Result<(f64, Bytes), String> {
        use wire::checkpoint_chunk::Part as From;
        use wire::restore_chunk::Part as To;
        let run_id = self.run_id();
        let messages: Vec<_> = chunks
            .iter()
            .map(|chunk| wire::RestoreChunk {
                run_id: run_id.clone(),
                epoch: EPOCHS[1],
                part: chunk.part.clone().map(|part| match part {
                    From::Header(header) => To::Header(header),
                    From::Data(data) => To::Data(data),
                    From::Trailer(trailer) => To::Trailer(trailer),
                }),
            })
            .collect();
        let request = self.token.attach(tokio_stream::iter(messages));
        let answer = self.bench.within("Restore", self.client.restore(request)).await?;
        let reply = answer.map_err(|status| format!("Restore: {status}"))?;
        if reply.step != SAVED {
            return Err(format!("after Restore it stands at step {}, saved was {SAVED}", reply.step));
        }
        let limit = reply.time_step_limit_s.ok_or("the reply to Restore has no time-step limit")?;
        Ok((limit, reply.sha256))
    }

    async fn close(&mut self) -> Result<(), String> {
        let request = self.token.attach(wire::CloseRequest { run_id: self.run_id() });
        self.bench
            .within("Close", self.client.close(request))
            .await?
            .map(drop)
            .map_err(|s| format!("Close: {s}"))
    }
}

/// SHA-256 that a checkpoint says of itself.
fn digest_of(chunks: &[wire::CheckpointChunk]) -> Bytes {
    chunks
        .iter()
        .find_map(|chunk| match &chunk.part {
            Some(wire::checkpoint_chunk::Part::Trailer(trailer)) => Some(trailer.sha256.clone()),
            _ => None,
        })
        .unwrap_or_default()
}

/// Saves at `bench.address`, restores at `address`, twice, and compares the ends.
async fn replay_at(bench: &Bench, address: &str) -> Finding {
    let mut original = Replay::at(bench, &bench.address).await?;
    bench.opens(&original.run_id(), &original.token);
    let limit = original.open().await?;
    original.link(limit).await?;
    let (end, saved) = original.run(EPOCHS[0], true).await?;
    original.close().await?;
    if end.is_empty() {
        return Err("the final snapshot has no data".into());
    }
    for time in ["first", "second"] {
        let mut again = Replay::at(bench, address).await?;
        if address == bench.address {
            bench.opens(&again.run_id(), &again.token);
        }
        again.open().await?;
        let (limit, digest) = again.restore(&saved).await?;
        if digest != digest_of(&saved) {
            return Err(format!("the {time} Restore holds another state than was saved: the digests differ"));
        }
        again.link(limit).await?;
        let (repeated, _) = again.run(EPOCHS[1], false).await?;
        again.close().await?;
        if repeated != end {
            let at = repeated.iter().zip(&end).position(|(a, b)| a != b).unwrap_or(repeated.len());
            return Err(format!(
                "the {time} replay ends in another state, first at byte {at} of the snapshot: the checkpoint is not complete"
            ));
        }
    }
    passed(format!("{STEPS} steps, saved at {SAVED}, restored twice: all bits"))
}

pub(super) async fn replay(bench: &Bench) -> Finding {
    if !bench.description.capabilities.checkpoint {
        return not_offered("the capability `checkpoint` is not declared");
    }
    replay_at(bench, &bench.address).await
}

pub(super) async fn fresh(bench: &Bench) -> Finding {
    if !bench.description.capabilities.checkpoint {
        return not_offered("the capability `checkpoint` is not declared");
    }
    match &bench.fresh {
        Some(address) => replay_at(bench, address).await,
        None => not_offered("needs the address of a fresh process: `--fresh ADDR`"),
    }
}
