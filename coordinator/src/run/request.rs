//! What is run, and how.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use proto::transport::security::ClientFiles;

use crate::case::overrides::Override;
use crate::failure::Failure;
use crate::messages::Messages;
use crate::results::directory::Existing;
use crate::run::participants::launch::Source;

/// A run from the start of its case.
#[derive(Clone, Debug, Default)]
pub struct RunRequest {
    /// Case file, TOML.
    pub case: PathBuf,
    /// Values set over those of the file; the results hold the case with them.
    pub overrides: Vec<Override>,
    /// Folder for the results; by default `results/` and the name of the case file.
    pub out: Option<PathBuf>,
    /// What becomes of the results of an earlier run in that folder.
    pub existing: Existing,
    /// How it is run.
    pub options: RunOptions,
}

/// How a case is run, whether from its start or from a checkpoint. By default both solvers are threads of this process,
/// and nothing is printed.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Where the solvers run.
    pub solvers: Placement,
    /// Compute threads of each built-in solver, `None` for all cores, shared by numbers of particles. The results do not
    /// depend on it.
    pub threads: Option<u16>,
    /// Arithmetic path of built-in solvers, `None` for the fastest of this machine. It decides the last bits of results,
    /// and holds for the whole process.
    pub arithmetic: Option<sph::lanes::Path>,
    /// Steps that solvers may take before they wait for the coordinator; 1 is strict lock-step.
    pub window: u64,
    /// Steps between checkpoints, over the case's `[checkpoint]`.
    pub checkpoint_every_steps: Option<u64>,
    /// Wall time between checkpoints, likewise.
    pub checkpoint_every_wall: Option<Duration>,
    /// Most restarts of lost servers, likewise.
    pub max_restarts: Option<u64>,
    /// File for a trace of all processes.
    pub trace: Option<PathBuf>,
    /// What becomes of a run that reaches its end with reservations.
    pub reservations: OnReservations,
    /// Serve a page on this machine that shows the run, and print its address.
    pub view: bool,
    /// What is printed.
    pub messages: Messages,
}

/// What becomes of a run that reaches its end with reservations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnReservations {
    /// It succeeds; they are reported.
    #[default]
    Report,
    /// It fails with an exit code of its own; its results are complete.
    Fail,
}

impl Default for RunOptions {
    fn default() -> Self {
        Self {
            solvers: Placement::default(),
            threads: None,
            arithmetic: None,
            window: 64,
            checkpoint_every_steps: None,
            checkpoint_every_wall: None,
            max_restarts: None,
            trace: None,
            reservations: OnReservations::default(),
            view: false,
            messages: Messages::default(),
        }
    }
}

impl RunOptions {
    /// How servers are started and reached, unless the solvers are threads.
    pub fn servers(&self) -> Option<&ServerOptions> {
        match &self.solvers {
            Placement::Threads => None,
            Placement::Servers(options) => Some(options),
        }
    }

    /// Makes this process compute by the arithmetic path asked for.
    ///
    /// # Errors
    /// When the machine cannot.
    pub(crate) fn force_arithmetic(&self) -> Result<(), Failure> {
        self.arithmetic.map_or(Ok(()), |path| sph::lanes::force(path).map_err(Failure::input))
    }
}

/// Where the solvers of a run compute; the results have the same bits.
#[derive(Clone, Debug, Default)]
pub enum Placement {
    /// In threads of this process.
    #[default]
    Threads,
    /// In processes of their own. Built-in servers and guards of other programs are this executable, run again with a
    /// hidden sub-command: it must be `coordinator` or call [`crate::cli::main`].
    Servers(Box<ServerOptions>),
}

/// How servers are started and reached.
#[derive(Clone, Debug, Default)]
pub struct ServerOptions {
    /// Where the fluid server comes from, over the case's `[servers]`.
    pub fluid: Option<Source>,
    /// Where the solid server comes from, likewise.
    pub solid: Option<Source>,
    /// Certificates and token for servers elsewhere, likewise.
    pub security: ClientFiles,
    /// A server that gives no sign of life for this long is lost, over the case's `[deadlines]`.
    pub silence: Option<Duration>,
    /// How the half-step frames pass the coordinator, `None` for directly between the servers unless the case says
    /// otherwise.
    pub relay: Option<RelayOptions>,
}

/// How the half-step frames pass the coordinator.
#[derive(Clone, Debug, Default)]
pub struct RelayOptions {
    /// Address at which the coordinator waits for the fluid server, `None` for any free port of 127.0.0.1.
    pub listen: Option<SocketAddr>,
    /// Accept an address beyond this machine without certificate: everyone on the way can read the frames.
    pub insecure: bool,
    /// File to which the frames are recorded.
    pub record: Option<PathBuf>,
}

impl ServerOptions {
    /// The files of these options, those of the case where none is given.
    pub(super) fn files(&self, case: &ClientFiles) -> ClientFiles {
        let ClientFiles { authority, identity, token } = self.security.clone();
        ClientFiles {
            authority: authority.or_else(|| case.authority.clone()),
            identity: identity.or_else(|| case.identity.clone()),
            token: token.or_else(|| case.token.clone()),
        }
    }
}
