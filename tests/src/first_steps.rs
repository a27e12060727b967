//! The first steps of a case, both solvers as threads of this process, without outputs.

use std::path::Path;

use coordinator::case::Case;
use coordinator::results::state;
use coordinator::run::participants::News;
use coordinator::run::participants::in_process;
use coordinator::run::participants::threads::Threads;
use sph::coupling::driver::{Command, Event};
use sph::coupling::solver::Role;

/// Events that may wait for the reader.
const PENDING_EVENTS: usize = 256;

/// Where one side stands after its first steps.
#[derive(Clone, Debug, PartialEq)]
pub struct SideState {
    /// Which side it is.
    pub role: Role,
    /// Completed steps: fewer than asked for where the case ends before.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Digest of all particles, see [`state::digest`].
    pub digest: String,
}

/// Takes `steps` steps of the case file at `path`, or all that it has, and says where each side stands.
///
/// # Errors
/// When the case is refused or a side fails; the message names the side.
pub fn first_steps(path: &Path, steps: u64) -> Result<Vec<SideState>, String> {
    let case = coordinator::run::load(path).map_err(|failure| failure.to_string())?;
    run(&case, steps).map_err(|message| format!("{}: {message}", path.display()))
}

fn run(case: &Case, steps: u64) -> Result<Vec<SideState>, String> {
    let (events, mut received) = tokio::sync::mpsc::channel(PENDING_EVENTS);
    let threads = Threads::each(1);
    let solvers = in_process::start(case.fluid_setup(), case.solid_setup(), threads, None, &events)
        .map_err(|failure| failure.to_string())?;
    drop(events);
    for solver in &solvers {
        for command in [Command::GrantThrough(steps), Command::Stop] {
            // A side that has failed takes no commands; its last event says why.
            let _ = solver.commands.send(command);
        }
    }
    let (mut states, mut failure) = (Vec::new(), None);
    while let Some((role, news)) = received.blocking_recv() {
        match news {
            Ok(News::Event(event)) => match *event {
                Event::Finished(report) => states.push(SideState {
                    role,
                    step: report.step,
                    time: report.time,
                    digest: state::digest(&report.state),
                }),
                Event::Failed(report) => failure = Some(format!("{role}: {report:?}")),
                _ => {}
            },
            Ok(News::Checkpoint(_)) => {}
            Err(lost) => failure = Some(format!("{role}: {lost}")),
        }
    }
    solvers.into_iter().for_each(in_process::ThreadParticipant::join);
    states.sort_by_key(|side| side.role.to_string());
    failure.map_or(Ok(states), Err)
}
