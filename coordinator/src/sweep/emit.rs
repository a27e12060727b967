//! Files that hand a sweep to a scheduler: one array job for Slurm, or a workflow for Snakemake.
//!
//! Both call the program once per member, which keeps what is finished and continues what was interrupted, so that a file
//! that is submitted again runs nothing twice.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::manifest::{MANIFEST, Manifest};
use crate::failure::Failure;
use crate::results::files::write_file;

/// A scheduler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduler {
    /// Slurm: one array job.
    Slurm,
    /// Snakemake: a workflow.
    Snakemake,
}

impl std::str::FromStr for Scheduler {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "slurm" => Ok(Self::Slurm),
            "snakemake" => Ok(Self::Snakemake),
            _ => Err("known are `slurm` and `snakemake`".to_owned()),
        }
    }
}

/// How the emitted files call the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// The program: a path, or a name on the PATH of the nodes.
    pub program: String,
    /// Compute threads of each member.
    pub threads: u16,
    /// Members at a time; the scheduler decides where `None`.
    pub jobs: Option<usize>,
}

/// Largest index that Slurm takes by default, one below its `MaxArraySize`.
const LARGEST_INDEX: usize = 1000;

/// Writes the file for `scheduler` into the `folder` of a sweep; its path, and the commands that start it.
///
/// # Errors
/// When it cannot be written, or the folder has no path of text.
pub fn emit(
    scheduler: Scheduler,
    manifest: &Manifest,
    folder: &Path,
    call: &Call,
) -> Result<(PathBuf, Vec<String>), Failure> {
    let folder = std::path::absolute(folder)
        .map_err(|e| Failure::output(format!("no full path of `{}`: {e}", folder.display())))?;
    let text = folder.to_str().filter(|text| !text.contains(['\n', '\r', '\0']));
    let text = text.ok_or_else(|| {
        Failure::output(format!("`{}` is no path for a script; choose another by `--out`", folder.display()))
    })?;
    let (name, content, commands) = match scheduler {
        Scheduler::Slurm => ("sweep.sbatch", slurm(manifest, text, call), slurm_commands(manifest, text)),
        Scheduler::Snakemake => {
            let cores =
                call.jobs.map_or(String::from("all"), |jobs| (jobs * usize::from(call.threads)).to_string());
            let command = format!(
                "snakemake --directory {0} --snakefile {1} --cores {cores} --keep-going",
                quoted(text),
                quoted(&format!("{text}/Snakefile"))
            );
            ("Snakefile", snakemake(manifest, call), vec![command])
        }
    };
    let path = folder.join(name);
    write_file(&path, |out| out.write_all(content.as_bytes()))?;
    if scheduler == Scheduler::Slurm {
        let logs = folder.join("slurm");
        std::fs::create_dir_all(&logs)
            .map_err(|e| Failure::output(format!("cannot create `{}`: {e}", logs.display())))?;
    }
    Ok((path, commands))
}

/// Commands that submit the array, in blocks where it has more members than an array has indices.
fn slurm_commands(manifest: &Manifest, folder: &str) -> Vec<String> {
    let script = quoted(&format!("{folder}/sweep.sbatch"));
    let count = manifest.members.len();
    if count <= LARGEST_INDEX {
        return vec![format!("sbatch {script}")];
    }
    let block = |start: usize| {
        let length = (count - start).min(LARGEST_INDEX);
        format!("sbatch --array=1-{length} --export=ALL,SWEEP_OFFSET={start} {script}")
    };
    (0..count).step_by(LARGEST_INDEX).map(block).collect()
}

/// The array job.
fn slurm(manifest: &Manifest, folder: &str, call: &Call) -> String {
    let name = super::manifest::label(&manifest.case);
    let last = manifest.members.len().clamp(1, LARGEST_INDEX);
    let at_once = call.jobs.map_or(String::new(), |jobs| format!("%{jobs}"));
    // Slurm takes no quoted words in these lines; a percent sign starts a pattern.
    let log = folder.replace('\\', "\\\\").replace('%', "%%").replace(' ', "\\ ");
    let (threads, program, folder) = (call.threads, quoted(&call.program), quoted(folder));
    format!(
        r#"#!/bin/bash
#SBATCH --job-name={name}
#SBATCH --array=1-{last}{at_once}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={threads}
#SBATCH --output={log}/slurm/%A_%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
# Two minutes before the time limit each member stops at a step boundary with a checkpoint; submitted again it continues.
#SBATCH --signal=B:TERM@120

# Add what your site asks for here or on the command line: --time, --partition, --account, --mem.
# Members that are finished are kept, so that the whole array can be submitted again.

set -eu
if [ -z "${{SLURM_ARRAY_TASK_ID:-}}" ]; then
  echo "submit this file with sbatch, or set SLURM_ARRAY_TASK_ID to the number of a member" >&2
  exit 2
fi
member=$((SLURM_ARRAY_TASK_ID + ${{SWEEP_OFFSET:-0}}))
exec {program} sweep --member "$member" --out {folder} --threads "${{SLURM_CPUS_PER_TASK:-{threads}}}"
"#
    )
}

/// The workflow. Marks of members are files of their own, since Snakemake removes the outputs of a rule before it runs it.
fn snakemake(manifest: &Manifest, call: &Call) -> String {
    let program = python(&call.program);
    let (threads, count) = (call.threads, manifest.members.len());
    let wrong: Vec<String> =
        manifest.members.iter().filter(|m| m.problem.is_some()).map(|m| m.number.to_string()).collect();
    let left_out = if wrong.is_empty() {
        String::new()
    } else {
        format!("# Left out, since their cases are wrong: {}.\n", wrong.join(", "))
    };
    format!(
        r#"# {count} members, listed in {MANIFEST}. Start it with: snakemake --directory THIS_FOLDER --cores N --keep-going
# Members that are finished are kept.
{left_out}
import json

with open("{MANIFEST}") as file:
    MEMBERS = [m["number"] for m in json.load(file)["members"] if m["problem"] is None]

PROGRAM = {program}


rule all:
    input:
        "sweep.csv",


rule member:
    output:
        touch("snakemake/{{number}}.done"),
    params:
        program=PROGRAM,
    wildcard_constraints:
        number=r"\d+",
    threads: {threads}
    shell:
        "{{params.program:q}} sweep --member {{wildcards.number}} --out . --threads {{threads}}"


rule join:
    input:
        expand("snakemake/{{number}}.done", number=MEMBERS),
    output:
        "sweep.csv",
    params:
        program=PROGRAM,
    shell:
        "{{params.program:q}} sweep --join ."
"#
    )
}

/// A word of a shell.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// A text of Python.
fn python(text: &str) -> String {
    // JSON's texts are texts of Python.
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::super::manifest::Entry;
    use super::*;

    fn manifest(count: usize) -> Manifest {
        let entry = |number| Entry {
            number,
            label: format!("m{number}"),
            set: Vec::new(),
            case_digest: None,
            problem: (number == 2).then(|| "wrong".to_owned()),
        };
        Manifest::new("a case".into(), Vec::new(), &[], (1..=count).map(entry).collect())
    }

    fn call() -> Call {
        Call { program: "/opt/my tools/it's".into(), threads: 4, jobs: Some(3) }
    }

    #[test]
    fn the_array_job_calls_the_program_for_each_member() {
        let text = slurm(&manifest(12), "/data/a sweep", &call());
        assert!(text.contains("#SBATCH --array=1-12%3\n") && text.contains("--cpus-per-task=4\n"), "{text}");
        assert!(text.contains("--job-name=a-case\n") && text.contains("=/data/a\\ sweep/slurm/%A_%a.log\n"));
        let exec = r#"exec '/opt/my tools/it'\''s' sweep --member "$member" --out '/data/a sweep' --threads"#;
        assert!(text.contains(exec), "{text}");
    }

    #[test]
    fn long_arrays_are_submitted_in_blocks() {
        assert_eq!(slurm_commands(&manifest(3), "/d"), ["sbatch /d/sweep.sbatch"]);
        let commands = slurm_commands(&manifest(2500), "/d");
        assert_eq!(commands.len(), 3);
        assert!(commands[2].contains("--array=1-500 --export=ALL,SWEEP_OFFSET=2000 "), "{commands:?}");
    }

    #[test]
    fn the_workflow_names_members_that_are_left_out() {
        let text = snakemake(&manifest(3), &call());
        assert!(text.contains("their cases are wrong: 2.\n"), "{text}");
        assert!(
            text.contains("PROGRAM = \"/opt/my tools/it's\"\n") && text.contains("threads: 4\n"),
            "{text}"
        );
        assert!(text.contains("--member {wildcards.number} --out . --threads {threads}"), "{text}");
    }
}
