//! A case over values of its keys: a grid, values in pairs, a Latin hypercube, seeds.
//!
//! A sweep is planned first: every member's resolved case is written and checked, and the manifest lists them. Members are
//! then made here, several at a time, or by the scheduler of a cluster, one by one, from the same files ([`emit`]).
//! [`join`] reads what there is and writes the table and the page.

pub mod axes;
pub mod emit;
pub mod manifest;
mod results;
pub mod sampling;
mod scatter;

use std::path::{Path, PathBuf};

use self::axes::Axis;
use self::manifest::{Entry, Manifest, Progress};
use self::sampling::Sampling;
use crate::batch::member::{self, Maker};
use crate::batch::{self, Batch, Member};
use crate::case::file::member::MemberTable;
use crate::case::overrides::Override;
use crate::failure::{Failure, Kind};
use crate::family::figures::{self, Figure};
use crate::run::{RunOptions, RunRequest, default_folder, origin};

pub use results::{PAGE, TABLE, lines};

/// A sweep to be made.
#[derive(Clone, Debug)]
pub struct SweepRequest {
    /// What the members have in common: case, values set over it, and how it is run. `out` is the folder of the sweep, by
    /// default `results/` and the name of the case file with `_sweep`.
    pub run: RunRequest,
    /// What is varied.
    pub axes: Vec<Axis>,
    /// How points are chosen.
    pub sampling: Sampling,
    /// Seeds of the displacement of the water at each point; as the case says when empty.
    pub seeds: Vec<u64>,
    /// Key figures; largest, smallest and last value of every probe column when empty.
    pub figures: Vec<Figure>,
    /// Repeat all runs; otherwise those that this build has finished in that folder are kept.
    pub fresh: bool,
    /// Runs at a time.
    pub jobs: usize,
}

impl Default for SweepRequest {
    fn default() -> Self {
        Self {
            run: RunRequest::default(),
            axes: Vec::new(),
            sampling: Sampling::default(),
            seeds: Vec::new(),
            figures: Vec::new(),
            fresh: false,
            jobs: 1,
        }
    }
}

/// A sweep and how far its members are.
#[derive(Clone, Debug)]
pub struct Joined {
    /// Its folder.
    pub folder: PathBuf,
    /// Its members.
    pub manifest: Manifest,
    /// Key figures.
    pub figures: Vec<Figure>,
    /// How far each member is, and its key figures; `None` where it has no such value.
    pub members: Vec<(Progress, Vec<Option<f64>>)>,
}

impl Joined {
    /// Members that are not finished, each with its number, name and reason.
    pub fn unfinished(&self) -> impl Iterator<Item = (&Entry, &Progress)> {
        let pairs =
            self.manifest.members.iter().zip(&self.members).map(|(entry, (progress, _))| (entry, progress));
        pairs.filter(|(_, progress)| !matches!(progress, Progress::Finished { .. }))
    }
}

/// Folder of the sweep.
fn folder_of(request: &SweepRequest) -> PathBuf {
    request.run.out.clone().unwrap_or_else(|| default_folder(&request.run.case, "_sweep"))
}

/// The members of `request`, without their cases being read.
///
/// # Errors
/// When the axes have no points.
pub fn members(request: &SweepRequest) -> Result<Vec<Member>, Failure> {
    let points = sampling::points(&request.axes, request.sampling).map_err(Failure::input)?;
    let keys: Vec<&str> = request.axes.iter().map(|axis| axis.key.as_str()).collect();
    let common = &request.run.overrides;
    if let Some(twice) = common.iter().find(|set| keys.contains(&set.key.as_str())) {
        return Err(Failure::input(format!("`{}` is varied, and set for all by `--set`", twice.key)));
    }
    let mut seeds: Vec<Option<u64>> = request.seeds.iter().copied().map(Some).collect();
    if seeds.is_empty() {
        seeds.push(None);
    }
    let mut members = Vec::new();
    for point in &points {
        for seed in &seeds {
            let mut varied = point.clone();
            if let Some(seed) = seed {
                varied.push(Override { key: "run.seed".to_owned(), value: seed.to_string() });
            }
            let mut overrides = common.clone();
            if seed.is_some() && !common.iter().any(|set| set.key == "run.displacement_fraction") {
                overrides.push(Override::new("run.displacement_fraction", MemberTable::DEFAULT_DISPLACEMENT));
            }
            let label = label(&varied);
            overrides.extend(varied);
            members.push(Member { label, overrides });
        }
    }
    Ok(members)
}

/// Name of the folder of a member: the last words of its keys, and their values. Where that does not say all, a digest does.
fn label(varied: &[Override]) -> String {
    let last = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
    let part = |set: &Override| format!("{}={}", last(&set.key), set.value.trim_matches('"'));
    let text = varied.iter().map(part).collect::<Vec<_>>().join("_");
    let text = if text.is_empty() { "case".to_owned() } else { text };
    let name = manifest::label(&text);
    let mut words: Vec<String> = varied.iter().map(|set| last(&set.key)).collect();
    words.sort();
    let ambiguous = words.windows(2).any(|pair| pair[0] == pair[1]);
    if name == text && !ambiguous {
        return name;
    }
    let all: Vec<String> = varied.iter().map(|set| format!("{} = {}", set.key, set.value)).collect();
    let digest = crate::run::completion::digest(&all.join("\n"));
    let short: String = name.chars().take(80).collect();
    format!("{short}_{}", &digest[..8])
}

/// Writes the resolved case of every member and the manifest, and calls `each` with a line about each member whose case is
/// wrong.
///
/// # Errors
/// When the axes have no points, no member has a right case, a figure has no column, or a file cannot be written.
pub fn plan(request: &SweepRequest, each: impl Fn(&str)) -> Result<(PathBuf, Manifest), Failure> {
    member::must_suit_many(&request.run.options)?;
    let folder = folder_of(request);
    let members = members(request)?;
    let common = request.run.overrides.len();
    let mut entries = Vec::new();
    let (mut first, mut wrong) = (None, None);
    for (k, Member { label, overrides }) in members.iter().enumerate() {
        let at = batch::folder_of(&folder, label);
        let (case_digest, problem) = match member::prepare(&request.run.case, overrides, &at) {
            Ok(digest) => {
                first.get_or_insert(at);
                (Some(digest), None)
            }
            Err(failure) if failure.kind == Kind::Input => {
                each(&format!("{label}: the case is wrong: {}", failure.message));
                let message = failure.message.clone();
                wrong.get_or_insert(failure);
                (None, Some(message))
            }
            Err(failure) => return Err(failure),
        };
        let set = overrides[common..].to_vec();
        entries.push(Entry { number: k + 1, label: label.clone(), set, case_digest, problem });
    }
    let Some(first) = first else {
        return Err(wrong.unwrap_or_else(|| Failure::internal("a sweep without members")));
    };
    let (case, _) = origin::load(&member::case_of(&first))?;
    let figures = figures::of_case(&case, &request.figures)?;
    let mut keys: Vec<String> = request.axes.iter().map(|axis| axis.key.clone()).collect();
    if !request.seeds.is_empty() {
        keys.push("run.seed".to_owned());
    }
    let manifest = Manifest::new(case.name.clone(), keys, &figures, entries);
    manifest.write(&folder)?;
    Ok((folder, manifest))
}

/// Plans a sweep, makes its members here, calls `each` with a line about each, and joins them.
///
/// # Errors
/// As [`plan`], and when a file cannot be written or the sweep is stopped from outside; what is finished is kept.
pub fn run(request: &SweepRequest, each: impl Fn(&str)) -> Result<Joined, Failure> {
    let (folder, manifest) = plan(request, &each)?;
    let good = |number: &usize| manifest.members[*number].problem.is_none();
    let all = members(request)?;
    let runs: Vec<Member> = (0..all.len()).filter(good).map(|k| all[k].clone()).collect();
    let batch = Batch {
        case: &request.run.case,
        options: &request.run.options,
        folder: &folder,
        jobs: request.jobs,
        fresh: request.fresh,
    };
    let mut done = 0;
    let made = batch.run(&runs, |place, outcome| {
        done += 1;
        each(&format!("[{done}/{}] {}: {}", runs.len(), runs[place].label, batch::line(outcome)));
    });
    match made {
        Ok(_) => join(&folder),
        Err(mut failure) => {
            failure.message.push_str("\nwhat is finished is kept; the same command continues the sweep");
            Err(failure)
        }
    }
}

/// Makes the member with `number` of the sweep in `folder`, or keeps it.
///
/// # Errors
/// When there is none, its case is wrong, and as a run.
pub fn make_member(
    folder: &Path,
    number: usize,
    options: &RunOptions,
    fresh: bool,
) -> Result<(String, member::Finished), Failure> {
    options.force_arithmetic()?;
    member::must_suit_many(options)?;
    let manifest = Manifest::read(folder)?;
    let entry = manifest.member(number)?;
    if let Some(problem) = &entry.problem {
        return Err(Failure::input(format!(
            "member {number}, {}: its case is wrong: {problem}",
            entry.label
        )));
    }
    let made = Maker::new(options, fresh).make(&batch::folder_of(folder, &entry.label));
    made.map(|finished| (entry.label.clone(), finished)).map_err(|mut failure| {
        failure.message = format!("member {number}, {}: {}", entry.label, failure.message);
        failure
    })
}

/// Reads what the members of the sweep in `folder` gave, and writes `sweep.csv` and `sweep.html`.
///
/// # Errors
/// When there is no manifest, results cannot be read, or a file cannot be written.
pub fn join(folder: &Path) -> Result<Joined, Failure> {
    let manifest = Manifest::read(folder)?;
    let figures = manifest.figures()?;
    let mut members = Vec::new();
    for entry in &manifest.members {
        let progress = entry.progress(folder);
        let values = match &progress {
            Progress::Finished { .. } => {
                let results = member::results_of(&batch::folder_of(folder, &entry.label));
                figures::of_results(&results, &figures)?
            }
            _ => vec![None; figures.len()],
        };
        members.push((progress, values));
    }
    let joined = Joined { folder: folder.to_owned(), manifest, figures, members };
    results::write(&joined)?;
    Ok(joined)
}

#[cfg(test)]
mod tests;
