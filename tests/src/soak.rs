//! Good and bad clients in a row on one pair of servers, whose memory, handles and threads must return to the base.

use std::io::Write;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use proto::transport::client::{Deadlines, ParticipantClient, RunAccess};
use sph::setup::ParticipantSetup;

use crate::bench::{Bench, digests, text, wait_for_first_frame};
use crate::nodes::Node;

/// Lease of the servers \[s\]: a client that goes away without a word costs this much. A coordinator that does not get to run
/// for most of it is given up, so that it must bear a busy machine.
const LEASE: &str = "3";
/// A server that is not free by then has not survived its last client.
const FREE: Duration = Duration::from_secs(30);
/// Time between looks.
const LOOK: Duration = Duration::from_millis(50);
/// Rounds before the base is measured: allocators and the runtime's threads have their size then.
const WARM_ROUNDS: u32 = 2;

/// What a server process uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Use {
    /// Resident memory \[bytes\].
    pub memory: u64,
    /// Open handles.
    pub handles: usize,
    /// Threads.
    pub threads: usize,
}

impl Use {
    /// Figures of `process` now.
    pub fn of(process: u32) -> Self {
        let count = |folder: &str| {
            std::fs::read_dir(format!("/proc/{process}/{folder}"))
                .map_or(0, |entries| entries.flatten().count())
        };
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
        let memory = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kilobytes = memory.and_then(|text| text.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
        Self { memory: kilobytes.unwrap_or(0) << 10, handles: count("fd"), threads: count("task") }
    }
}

/// What a soak has shown.
#[derive(Clone, Debug, Default)]
pub struct Soaked {
    /// Good runs.
    pub good: u32,
    /// Bad clients.
    pub bad: u32,
    /// Fluid and solid server after the first rounds.
    pub base: [Use; 2],
    /// The same at the end.
    pub end: [Use; 2],
}

/// A pair of servers and what comes to them.
pub struct Soak {
    bench: Bench,
    program: PathBuf,
    nodes: [Node; 2],
    case: PathBuf,
    long: PathBuf,
    broken: PathBuf,
}

impl Soak {
    /// Starts a pair of servers of `program`.
    pub fn new(program: &Path) -> Self {
        let bench = Bench::new(text(program));
        let start = |role| Node::start(program, role, &["--lease", LEASE]);
        Self {
            nodes: [start("fluid"), start("solid")],
            case: bench.tank("case.toml", &[]),
            long: bench.tank("long.toml", &[("end_time_s = 0.002", "end_time_s = 100.0")]),
            // Far beyond what either solver can follow: it breaks down at once.
            broken: bench.tank("broken.toml", &[("[0.0, -9.81]", "[0.0, -1e9]")]),
            program: program.into(),
            bench,
        }
    }

    fn addresses(&self) -> [&str; 4] {
        ["--fluid", &self.nodes[0].address, "--solid", &self.nodes[1].address]
    }

    fn uses(&self) -> [Use; 2] {
        self.nodes.each_ref().map(|node| Use::of(node.process()))
    }

    /// A run of `case` on the servers into the folder `name`.
    fn run_of(&self, case: &Path, name: &str) -> Command {
        let mut command = Command::new(&self.program);
        command.args(["run", text(case), "--quiet", "--force", "--out", text(&self.bench.path(name))]);
        command.args(self.addresses());
        command
    }

    /// A run that must end well; its digests.
    fn good(&self) -> [serde_json::Value; 2] {
        let mut arguments = vec!["--force"];
        arguments.extend(self.addresses());
        digests(&self.bench.run(&self.case, "good", &arguments))
    }

    /// One bad client of kind `kind`.
    fn bad(&self, kind: u32) {
        match kind % 5 {
            0 => self.garbage(),
            1 => self.breaks_down(),
            2 => self.dies(),
            3 => self.goes_away(),
            _ => self.keeps_silent(),
        }
    }

    /// Bytes that are no HTTP/2.
    fn garbage(&self) {
        for node in &self.nodes {
            for bytes in [
                &b"GET / HTTP/1.1\r\n\r\n"[..],
                &[0xff; 4096],
                b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\xff\xff\xff",
            ] {
                let mut stream = TcpStream::connect(&node.address).unwrap();
                // The server may close before all of it is written.
                drop(stream.write_all(bytes));
            }
        }
    }

    /// Connections without a word.
    fn keeps_silent(&self) {
        let streams: Vec<_> = self
            .nodes
            .iter()
            .flat_map(|node| (0..20).map(|_| TcpStream::connect(&node.address).unwrap()))
            .collect();
        std::thread::sleep(LOOK);
        drop(streams);
    }

    /// A run whose physics break down.
    fn breaks_down(&self) {
        let output = self.run_of(&self.broken, "broken").output().unwrap();
        assert!(!output.status.success(), "a broken case must not end well");
    }

    /// A coordinator that is killed in its run.
    fn dies(&self) {
        let out = self.bench.path("dies");
        // A frame of an earlier run must not be taken for one of this.
        drop(std::fs::remove_dir_all(&out));
        let mut run = self.run_of(&self.long, "dies").stderr(Stdio::null()).spawn().unwrap();
        wait_for_first_frame(&out, &mut run, LOOK);
        drop(run.kill());
        drop(run.wait());
    }

    /// A client that opens a run and is never heard again.
    fn goes_away(&self) {
        let case = coordinator::case::load(&self.case, &coordinator::results::state::read).unwrap();
        let setup = ParticipantSetup::Solid(case.solid_setup().unwrap());
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let mut client =
                ParticipantClient::connect(&self.nodes[1].address, Deadlines::default()).await.unwrap();
            client.open(&setup, &RunAccess::new("one that goes away").unwrap()).await.unwrap();
        });
    }

    /// Waits until a good run is taken again; servers of a client that died are free after their lease at the latest.
    fn wait_until_free(&self) {
        let started = Instant::now();
        loop {
            let output = self.run_of(&self.case, "probe").output().unwrap();
            if output.status.success() {
                return;
            }
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(started.elapsed() < FREE && message.contains("busy"), "not free: {message}");
            std::thread::sleep(LOOK);
        }
    }

    /// Rounds of ten good runs and five bad clients, until `until`, at least the rounds that warm up and one more.
    ///
    /// # Errors
    /// What has not returned to the base.
    pub fn run(&self, until: Instant) -> Result<Soaked, String> {
        let mut soaked = Soaked::default();
        let expected = self.good();
        let mut round = 0;
        while round <= WARM_ROUNDS || Instant::now() < until {
            for kind in 0..5 {
                self.bad(kind);
                soaked.bad += 1;
                self.wait_until_free();
                if self.good() != expected {
                    return Err(format!("another result after bad client {kind} of round {round}"));
                }
                soaked.good += 2;
            }
            round += 1;
            if round == WARM_ROUNDS {
                soaked.base = self.settled(None);
            }
        }
        soaked.end = self.settled(Some(soaked.base));
        compare(&soaked)?;
        Ok(soaked)
    }

    /// Figures when the last connections are closed: at those of `base`, or the least ones within some seconds.
    fn settled(&self, base: Option<[Use; 2]>) -> [Use; 2] {
        let wait = if base.is_some() { FREE } else { Duration::from_secs(3) };
        let started = Instant::now();
        let mut least = self.uses();
        while started.elapsed() < wait {
            let now = self.uses();
            for (least, now) in least.iter_mut().zip(now) {
                least.handles = least.handles.min(now.handles);
                least.threads = least.threads.min(now.threads);
                least.memory = now.memory;
            }
            let back = base.is_some_and(|base| {
                least.iter().zip(base).all(|(l, b)| l.handles <= b.handles && l.threads <= b.threads)
            });
            if back {
                break;
            }
            std::thread::sleep(LOOK);
        }
        least
    }
}

/// Whether `soaked` ended as it began.
fn compare(soaked: &Soaked) -> Result<(), String> {
    for (name, (base, end)) in ["fluid", "solid"].iter().zip(soaked.base.iter().zip(&soaked.end)) {
        if end.handles > base.handles || end.threads > base.threads {
            return Err(format!("the {name} server has {end:?}, at the base {base:?}"));
        }
        // Freed memory comes back to the system in pieces, by thread: a leak of one run of the tank (1 MiB) in each
        // client is above this after some dozen of them.
        if end.memory > base.memory + (16 << 20) {
            return Err(format!("the {name} server has grown from {} to {} bytes", base.memory, end.memory));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_handle_a_thread_or_much_memory_more_than_at_the_base_is_told() {
        let base = Use { memory: 50 << 20, handles: 20, threads: 6 };
        let with = |end: Use| compare(&Soaked { base: [base; 2], end: [base, end], ..Soaked::default() });
        assert!(with(base).is_ok());
        assert!(with(Use { handles: 21, ..base }).unwrap_err().contains("solid"));
        assert!(with(Use { threads: 7, ..base }).is_err());
        assert!(with(Use { memory: 70 << 20, ..base }).unwrap_err().contains("grown"));
    }
}
