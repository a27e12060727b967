//! The fluid server in several processes, which `mpirun` or another launcher of MPI programs starts. Started alone it is one
//! process.
//!
//! The first process is the server: it speaks with the coordinator and the partner. Each set-up that it opens goes to the
//! others, which compute their parts of the fluid until the run is over, see [`fluid::first_part`].

mod launch;
mod pause;
mod pieces;
mod transport;

use std::path::PathBuf;
use std::process::ExitCode;

use fluid::Team;
use fluid_server::FluidFactory;
use proto::service::SolverFactory;
use proto::transport::node::NodeArgs;
use serde::{Deserialize, Serialize};
use sph::coupling::solver::Solver;
use sph::lanes::Arithmetic;
use sph::setup::{AnyFluidSetup, ParticipantSetup};

use launch::Launched;
use pause::Patience;
use transport::MpiTransport;

/// Exit code of a process that can not take part.
const EXIT_FAILED: u8 = 1;

/// What the first process wants of the others.
#[derive(Debug, Serialize, Deserialize)]
enum Order {
    /// Compute a part of the fluid of the `setup`, as [`proto::encoded_setup`] gives it, with this arithmetic.
    Compute {
        /// The set-up.
        setup: Vec<u8>,
        /// Name of the arithmetic.
        arithmetic: String,
    },
    /// End.
    End,
}

fn main() -> ExitCode {
    terminal::program::run(|| {
        let factory = FluidFactory::default();
        match NodeArgs::of_program(&factory.describe(), std::env::args_os()) {
            Ok(args) => {
                launch::launched().map_or_else(|| args.serve(factory), |launched| serve(&args, launched))
            }
            Err(code) => code,
        }
    })
}

/// Serves as one of the processes that were `launched`.
fn serve(args: &NodeArgs, launched: Launched) -> ExitCode {
    let threads = args.threads.map_or_else(|| threads_of(launched), usize::from);
    match MpiTransport::start(Patience::default()) {
        Ok(transport) => {
            let team = Team::new(Box::new(transport));
            if team.rank() > 0 {
                return of_other_process(args, threads, &team);
            }
            // Threads are counted in 16 bits.
            let args = NodeArgs { threads: Some(threads.min(1024) as u16), ..args.clone() };
            let of_server = team.clone();
            let code = args.serve(FluidFactory::made_by(move |setup| lead(setup, &of_server)));
            team.call(&Order::End);
            code
        }
        Err(error) => {
            terminal::note(format_args!("error: {error}"));
            ExitCode::from(EXIT_FAILED)
        }
    }
}

/// A solver of `setup` in the processes of `team`, of which this is the first.
///
/// # Errors
/// Everything in the set-up that can not be run.
fn lead(setup: AnyFluidSetup, team: &Team) -> Result<Box<dyn Solver>, Vec<String>> {
    let turn = team.turn();
    let arithmetic = Arithmetic::chosen().name().to_owned();
    let setup = ParticipantSetup::Fluid(setup);
    team.call(&Order::Compute { setup: proto::encoded_setup(&setup), arithmetic });
    let ParticipantSetup::Fluid(setup) = setup else { unreachable!("it is for a fluid") };
    fluid::first_part(setup, team, turn)
}

/// Compute threads of each process: those that it was given, or its share of the cores of the machine.
fn threads_of(launched: Launched) -> usize {
    if let Some(given) = launched.cores {
        return given.max(1);
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let here = launched.here.or(launched.processes).unwrap_or(1);
    (cores / here.max(1)).max(1)
}

/// Computes parts of fluids until the first process ends, with a part of the trace of its own.
fn of_other_process(args: &NodeArgs, threads: usize, team: &Team) -> ExitCode {
    let own_trace = |path: &PathBuf| {
        let mut path = path.clone().into_os_string();
        path.push(format!("-{}", team.rank()));
        path.into()
    };
    let args = NodeArgs { trace: args.trace.as_ref().map(own_trace), ..args.clone() };
    // A batch system asks all processes to end; the first one does so when the run is over.
    if let Err(problem) = terminal::stop::ignore() {
        terminal::note(format_args!("process {} of the fluid cannot ignore signals: {problem}", team.rank()));
    }
    let ended = args.record(&format!("fluid, process {}", team.rank())).and_then(|part| {
        compute(&args, threads, team)?;
        let complete = part.map_or(Ok(()), |part| part.flush());
        complete.map_err(|problem| format!("the trace is not complete: {problem}"))
    });
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            terminal::note(format_args!("error: process {} of the fluid: {problem}", team.rank()));
            ExitCode::from(EXIT_FAILED)
        }
    }
}

fn compute(args: &NodeArgs, threads: usize, team: &Team) -> Result<(), String> {
    if let Some(chosen) = args.arithmetic.map(sph::lanes::force) {
        chosen.map_err(|problem| problem.to_string())?;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    pool.map_err(|problem| problem.to_string())?;
    loop {
        match team.next_call() {
            Order::Compute { setup, arithmetic } => {
                let own = Arithmetic::chosen().name();
                if own != arithmetic {
                    return Err(format!(
                        "its arithmetic is {own}, that of the first process {arithmetic}; start all with the same \
                         `--arithmetic`"
                    ));
                }
                match proto::decoded_setup(&setup).map_err(|problem| problem.to_string())? {
                    ParticipantSetup::Fluid(setup) => fluid::other_part(setup, team),
                    ParticipantSetup::Solid(_) => return Err("the set-up is for a solid".into()),
                }
            }
            Order::End => return Ok(()),
        }
    }
}
