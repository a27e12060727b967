//! `tidelock sweep`.

use std::path::{Path, PathBuf};

use clap::Args;
use terminal::say;

use super::many::{ManyRuns, ManyRunsArguments, progress};
use crate::PROGRAM;
use crate::failure::{Failure, Kind};
use crate::run::RunOptions;
use crate::sweep::axes::Axis;
use crate::sweep::emit::{Call, Scheduler, emit};
use crate::sweep::sampling::Sampling;
use crate::sweep::{self, Joined, PAGE, SweepRequest};

/// Arguments of `sweep`.
#[derive(Debug, Args)]
pub(super) struct SweepArguments {
    /// Case file, TOML; see cases/FORMAT.md.
    #[arg(required_unless_present_any = ["join", "member"], conflicts_with_all = ["join", "member"])]
    case: Option<PathBuf>,
    /// Vary a key: `KEY=A,B,C`, or a range `KEY=LOW..HIGH` or `KEY=LOW..HIGH:log` for `--latin`; repeat for several keys, which
    /// make a grid. Keys are written as for `--set`.
    #[arg(long, value_name = "KEY=VALUES")]
    over: Vec<Axis>,
    /// Take the values of all keys side by side, the first of each, the second of each, instead of all combinations.
    #[arg(long, conflicts_with = "latin")]
    list: bool,
    /// Take this many points of a Latin hypercube.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    latin: Option<u32>,
    /// Decides the points of the Latin hypercube.
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "latin")]
    latin_seed: u64,
    /// Run each point with seeds 1 to N, which displace the water a little at the start.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u64).range(..=10_000))]
    seeds: u64,
    /// Run nothing: check all members and write the files for a scheduler, `slurm` or `snakemake`. `--threads` and `--jobs`
    /// say what each member takes and how many run at a time.
    #[arg(long, value_name = "SCHEDULER", conflicts_with_all = ["join", "member"])]
    emit: Option<Scheduler>,
    /// Program that the emitted files call, as the nodes find it.
    #[arg(long, value_name = "PROGRAM", default_value = PROGRAM, requires = "emit")]
    program: String,
    /// Join the results of the sweep in this folder, finished or not.
    #[arg(long, value_name = "DIR", conflicts_with = "member")]
    join: Option<PathBuf>,
    /// Make this member, by its number from 1, of the planned sweep in the folder of `--out`; emitted files call this.
    #[arg(long, value_name = "N", requires = "out")]
    member: Option<usize>,
    #[command(flatten)]
    many: ManyRunsArguments,
}

impl SweepArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        if let Some(folder) = &self.join {
            return finish(&sweep::join(folder)?);
        }
        if let (Some(number), Some(folder)) = (self.member, self.many.out.clone()) {
            return make_member(&folder, number, self.many);
        }
        let case = self.case.ok_or_else(|| Failure::input("give a case file"))?;
        let threads = self.many.options.threads();
        let ManyRuns { run, figures, jobs, fresh } = self.many.of(case, "_sweep");
        let request = SweepRequest {
            run,
            axes: self.over,
            sampling: match (self.list, self.latin) {
                (_, Some(points)) => Sampling::Latin { points, seed: self.latin_seed },
                (true, None) => Sampling::Paired,
                (false, None) => Sampling::Grid,
            },
            seeds: (1..=self.seeds).collect(),
            figures,
            fresh,
            jobs,
        };
        if request.axes.is_empty() && request.seeds.is_empty() {
            let text = "nothing to vary; add `--over KEY=A,B,C`, or `--seeds N`";
            return Err(Failure::input(text));
        }
        let each = progress(&request.run.options);
        let Some(scheduler) = self.emit else { return finish(&sweep::run(&request, each)?) };
        let (folder, manifest) = sweep::plan(&request, each)?;
        let call = Call {
            program: full_path(self.program),
            threads: threads.unwrap_or(1),
            jobs: (jobs > 1).then_some(jobs),
        };
        let (path, commands) = emit(scheduler, &manifest, &folder, &call)?;
        say(format_args!("{} members planned in {}", manifest.members.len(), folder.display()));
        say(format_args!("written: {}", path.display()));
        commands.iter().for_each(|command| say(format_args!("start:   {command}")));
        say(format_args!("then:    {PROGRAM} sweep --join {}", folder.display()));
        Ok(())
    }
}

/// A program in a folder by its full path, since jobs run elsewhere; a name is sought on the PATH of the nodes.
fn full_path(program: String) -> String {
    let full = || Some(std::path::absolute(&program).ok()?.to_str()?.to_owned());
    if program.contains('/') { full().unwrap_or(program) } else { program }
}

fn make_member(folder: &Path, number: usize, many: ManyRunsArguments) -> Result<(), Failure> {
    let fresh = many.fresh;
    let options: RunOptions = many.options.into();
    let (label, made) = sweep::make_member(folder, number, &options, fresh)?;
    say(format_args!("member {number}, {label}: {}", crate::batch::line(&Ok(made))));
    Ok(())
}

/// Prints the table; a sweep with members that are not finished has the exit code of one that failed.
fn finish(joined: &Joined) -> Result<(), Failure> {
    sweep::lines(joined).iter().for_each(say);
    say(format_args!("page: {}", joined.folder.join(PAGE).display()));
    let numbers: Vec<String> = joined.unfinished().map(|(entry, _)| entry.number.to_string()).collect();
    if numbers.is_empty() {
        return Ok(());
    }
    let (count, all) = (numbers.len(), joined.members.len());
    Err(Failure::new(
        Kind::Incomplete,
        format!(
            "{count} of {all} members are not finished: {}; the table and the page hold the others",
            numbers.join(",")
        ),
    ))
}
