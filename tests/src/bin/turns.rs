//! Runs a case with two builds of the coordinator in turns and compares their wall times.
//!
//! On a machine whose speed changes by the minute only runs next to each other can be compared.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Parser;
use serde_json::Value;

/// Runs a case with two builds in turns, the second build first in every other round, and tells wall time of each, their
/// ratio, and whether the final states have the same bits. The median of the ratios counts.
#[derive(Debug, Parser)]
struct Arguments {
    /// Coordinator of the one build, with its servers beside it.
    #[arg(long)]
    before: PathBuf,
    /// Coordinator of the other build, likewise.
    #[arg(long)]
    after: PathBuf,
    /// Number of rounds.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Case file.
    case: PathBuf,
    /// Further arguments of `tidelock run`.
    #[arg(last = true)]
    further: Vec<String>,
}

/// What is compared of a run.
struct Ran {
    /// Wall time \[s\].
    wall: f64,
    /// Digests of the final states.
    digests: [Option<String>; 2],
}

fn main() -> ExitCode {
    terminal::program::run(|| match compare(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            terminal::note(format_args!("error: {message}"));
            ExitCode::FAILURE
        }
    })
}

fn compare(arguments: &Arguments) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|e| format!("no temporary folder: {e}"))?;
    let out = &folder.path().join("results");
    let (mut ratios, mut walls, mut same) = (Vec::new(), [Vec::new(), Vec::new()], true);
    terminal::say(format_args!("{:>8}{:>12}{:>12}{:>8}", "round", "before, s", "after, s", "ratio"));
    for round in 0..arguments.rounds {
        let run = |program: &Path| run(program, arguments, out);
        let (before, after) = if round % 2 == 0 {
            let before = run(&arguments.before)?;
            (before, run(&arguments.after)?)
        } else {
            let after = run(&arguments.after)?;
            (run(&arguments.before)?, after)
        };
        same &= before.digests == after.digests;
        ratios.push(after.wall / before.wall);
        walls[0].push(before.wall);
        walls[1].push(after.wall);
        terminal::say(format_args!(
            "{:>8}{:>12.2}{:>12.2}{:>8.3}",
            round + 1,
            before.wall,
            after.wall,
            after.wall / before.wall
        ));
    }
    let shortest = |walls: &[f64]| walls.iter().copied().fold(f64::INFINITY, f64::min);
    terminal::say(format_args!(
        "{:>8}{:>12.2}{:>12.2}{:>8.3}",
        "median",
        median(&walls[0]),
        median(&walls[1]),
        median(&ratios)
    ));
    terminal::say(format_args!(
        "{:>8}{:>12.2}{:>12.2}",
        "shortest",
        shortest(&walls[0]),
        shortest(&walls[1])
    ));
    terminal::say(format_args!("final states: {}", if same { "the same bits" } else { "not the same bits" }));
    Ok(())
}

/// Runs the case into `out`, which is empty afterwards.
fn run(program: &Path, arguments: &Arguments, out: &Path) -> Result<Ran, String> {
    let name = program.display();
    let mut command = Command::new(program);
    command.arg("run").arg(&arguments.case).arg("--out").arg(out).arg("--quiet").args(&arguments.further);
    let output = command.output().map_err(|e| format!("`{name}` can not be started: {e}"))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        return Err(format!("`{name}` ended with {}:\n{errors}", output.status));
    }
    let path = out.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let summary: Value = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let wall = summary["wall_seconds"].as_f64().ok_or("summary.json has no `wall_seconds`")?;
    let digest = |side: &str| summary[side]["state_digest"].as_str().map(String::from);
    let digests = [digest("fluid"), digest("solid")];
    if digests.iter().all(Option::is_none) {
        return Err(format!(
            "`{name}` tells no `state_digest` in summary.json: the build is too old to compare"
        ));
    }
    std::fs::remove_dir_all(out).map_err(|e| format!("{}: {e}", out.display()))?;
    Ok(Ran { wall, digests })
}

/// Median of at least one number.
fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}
