//! Names of the files and folders of a run, and which names a run may have given.

/// Suffix of a file that is still being written.
pub const PARTIAL: &str = ".partial";

/// Present, and locked, while a run writes into the folder; removed when all outputs are complete.
pub const MARKER: &str = "run.partial";

/// Verdict and figures of the run.
pub const SUMMARY: &str = "summary.json";
/// Probe values over time.
pub const PROBES: &str = "probes.csv";
/// Interface ledger over time.
pub const LEDGER: &str = "ledger.csv";
/// Particles around the offending one.
pub const DIVERGENCE: &str = "divergence.csv";
/// The case as resolved.
pub const CASE: &str = "case.toml";
/// Pictures and facts.
pub const REPORT: &str = "report.html";
/// Folder of particle files.
pub const SNAPSHOTS: &str = "snapshots";
/// Folder of checkpoints.
pub const CHECKPOINTS: &str = "checkpoints";
/// Folder of final states.
pub const FINAL: &str = "final";
/// Folder of server logs.
pub const LOGS: &str = "logs";

/// Files of a run at the top of its folder.
pub const TOP_FILES: [&str; 6] = [SUMMARY, PROBES, LEDGER, CASE, REPORT, DIVERGENCE];
/// Sides as they appear in file names.
pub const SIDES: [&str; 2] = ["fluid", "solid"];

/// What a checkpoint belongs to, and the size and digest of each of its files.
pub const MANIFEST: &str = "manifest.json";
/// The coordinator's own file of a checkpoint.
pub const COORDINATOR_FILE: &str = "coordinator.bin";
/// Files of a checkpoint, in the order in which they are removed: without its manifest the rest counts for nothing.
pub const CHECKPOINT_FILES: [&str; 4] = [MANIFEST, "fluid.bin", "solid.bin", COORDINATOR_FILE];

/// Name of the folder of the checkpoint at `step` completed steps.
pub fn checkpoint_name(step: u64) -> String {
    format!("step_{step:012}")
}

/// Step of the checkpoint whose folder has this name.
pub fn checkpoint_step(name: &str) -> Option<u64> {
    let digits = name.strip_prefix("step_")?;
    (digits.len() == 12 && digits.bytes().all(|b| b.is_ascii_digit())).then(|| digits.parse().ok())?
}

/// Whether a run gives this name to the folder of a checkpoint, complete or not.
pub fn is_checkpoint(name: &str) -> bool {
    checkpoint_step(name.strip_suffix(PARTIAL).unwrap_or(name)).is_some()
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether a run gives this name to a final state.
pub(super) fn is_final(name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    name.strip_suffix(".state").is_some_and(|side| SIDES.contains(&side))
}

/// Whether a run gives this name to a server's log.
pub(super) fn is_log(name: &str) -> bool {
    SIDES
        .iter()
        .filter_map(|side| name.strip_prefix(side)?.strip_prefix("-server")?.strip_suffix(".log"))
        .any(|number| number.is_empty() || number.strip_prefix('-').is_some_and(is_number))
}

/// Whether a run gives this name to a file in the folder of its checkpoints: a picture of the report, or the state it started from.
pub(super) fn is_beside_checkpoints(name: &str) -> bool {
    let start = name.strip_suffix(PARTIAL).unwrap_or(name).strip_prefix("start_");
    is_picture(name) || start.is_some_and(is_final)
}

/// Whether a run gives this name to the particles of a picture of the report.
pub(super) fn is_picture(name: &str) -> bool {
    let name = name.strip_suffix(PARTIAL).unwrap_or(name);
    let picture = name.strip_prefix("picture_").and_then(|rest| rest.strip_suffix(".state"));
    let step = |side| picture?.strip_prefix(side)?.strip_prefix('_');
    SIDES.into_iter().filter_map(step).any(is_number)
}
