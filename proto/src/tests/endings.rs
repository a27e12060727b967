//! What a server says of the end of a run.

use std::io::Write;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use sph::coupling::driver::{Command, Event};
use sph::coupling::exchange::Extent;
use sph::coupling::solver::Role;
use tracing_subscriber::fmt::MakeWriter;

use super::fake::{TestServer, alone, soon};
use crate::description::{LinkPlan, Partner};
use crate::transport::client::{ParticipantClient, RunAccess};

/// A log in memory.
#[derive(Clone, Default)]
struct Log(Arc<Mutex<Vec<u8>>>);

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl<'a> MakeWriter<'a> for Log {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        self.clone()
    }
}

impl Log {
    /// The last line that reports an end, once there are `ends` of them.
    async fn end(&self, ends: usize) -> String {
        loop {
            let text = String::from_utf8(self.0.lock().unwrap().clone()).unwrap();
            let lines: Vec<&str> = text.lines().filter(|line| line.contains("run ended")).collect();
            if let Some(line) = lines.get(ends - 1) {
                return (*line).to_owned();
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }
}

async fn linked(client: &mut ParticipantClient) {
    let access = RunAccess::new("a test").unwrap();
    let report = client.open(&alone(Role::Solid, "slow-end", 3), &access).await.unwrap();
    let first_limit = report.time_step_limit;
    let plan = LinkPlan {
        first_limit,
        partner_extent: Extent::default(),
        partner: Partner::Alone,
        partner_particles: None,
    };
    client.link(&plan).await.unwrap();
}

// The log is that of this thread, on which all tasks of the server run.
#[tokio::test]
async fn a_run_closed_after_its_last_event_was_not_abandoned_and_one_closed_before_was() {
    let log = Log::default();
    let subscriber = tracing_subscriber::fmt().with_writer(log.clone()).with_ansi(false).finish();
    let _guard = tracing::subscriber::set_default(subscriber);
    let server = TestServer::start(Role::Solid);
    let mut client = server.client().await;

    linked(&mut client).await;
    let (commands, mut events) = client.run().await.unwrap();
    commands.send(Command::GrantThrough(10)).unwrap();
    while let Some(event) = soon("an event", events.recv()).await {
        if let Event::Finished(_) = event.unwrap() {
            break;
        }
    }
    // The solver is still going: as coordinators do, which wait for nothing more.
    soon("Close", client.close()).await.unwrap();
    let end = soon("the first end", log.end(1)).await;
    assert!(end.contains("abandoned=false"), "{end}");

    linked(&mut client).await;
    let _streams = client.run().await.unwrap();
    soon("Close", client.close()).await.unwrap();
    let end = soon("the second end", log.end(2)).await;
    assert!(end.contains("abandoned=true"), "{end}");
    server.end().await;
}
