//! What the page reads of a run: one message, in `report.html` and from a server alike.

use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use super::film::{Extreme, Film, Frame};
use super::folder::{CaseFacts, Culprit, culprit};
use super::packing::Column;
use super::plots::{self, PlotGroup};
use super::scene::Scene;
use super::story::{self, Budget, KeyFigure, plain};
use crate::PROGRAM;
use crate::results::names;
use crate::results::table::Table;

/// Rows of the table of key figures that are not folded away.
const FIRST_FIGURES: usize = 8;
/// Links of a page, where the file is there: name in the folder and what it is.
const FILES: [(&str, &str); 6] = [
    (names::PROBES, "probes over time"),
    (names::LEDGER, "interface and energy over time"),
    (names::SUMMARY, "verdict and figures for programs"),
    (names::CASE, "the case with every default"),
    (names::DIVERGENCE, "the particle that broke down and its neighbours"),
    ("snapshots/fluid.pvd", "particles for ParaView"),
];

/// Names and values in words.
pub type Facts = Vec<(String, String)>;

/// A table of names and values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FactTable {
    /// Anchor.
    pub id: &'static str,
    /// Headline.
    pub headline: &'static str,
    /// Rows.
    pub rows: Facts,
}

/// A file beside the page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Link {
    /// Address from the folder of the run.
    pub file: &'static str,
    /// What it is.
    pub meaning: &'static str,
}

/// A quality figure in words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quality {
    /// Name.
    pub name: String,
    /// Value in words; empty where it is not known.
    pub value: String,
    /// Threshold in words.
    pub threshold: String,
    /// `good`, `reservation` or `not-judged`.
    pub verdict: String,
    /// What it is.
    pub meaning: String,
    /// What to do where it does not keep to its threshold.
    pub advice: String,
}

/// How far a run is.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Status {
    /// What is happening, in words.
    pub doing: String,
    /// Whether the run has ended.
    pub ended: bool,
    /// Simulated time \[s\].
    pub time: f64,
    /// End time \[s\].
    pub end_time: f64,
    /// Part of the simulated time that is done \[-\].
    pub share: f64,
    /// Completed steps.
    pub steps: u64,
    /// Wall time since the start, in words.
    pub elapsed: String,
    /// Wall time to the end, in words; empty where it is not known yet.
    pub left: String,
    /// Further figures, by name: time step, balances, last checkpoint.
    pub figures: Facts,
}

/// Everything that the page shows.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RunPage {
    /// Title of the case.
    pub title: String,
    /// How the run ended, in words; `running` before.
    pub verdict: String,
    /// Why, in a sentence.
    pub reason: String,
    /// What came out, in a sentence.
    pub sentence: String,
    /// How far it is, while it runs.
    pub status: Option<Status>,
    /// What all frames share; `None` without frames.
    pub scene: Option<Scene>,
    /// How frames are packed that do not say so themselves.
    pub columns: Vec<Column>,
    /// Time, step and size of each frame.
    pub frames: Vec<Frame>,
    /// What is not shown as it is.
    pub notes: Vec<String>,
    /// Key figures, the weightiest first.
    pub figures: Vec<KeyFigure>,
    /// How many of them are not folded away.
    pub first_figures: usize,
    /// Quality figures; empty before the end.
    pub quality: Vec<Quality>,
    /// What speaks against trusting the answer.
    pub reservations: Vec<String>,
    /// Energy budgets.
    pub budgets: Vec<Budget>,
    /// Plots.
    pub plots: Vec<PlotGroup>,
    /// Tables of facts.
    pub tables: Vec<FactTable>,
    /// Things that the user should know of.
    pub warnings: Vec<String>,
    /// The particle that ended the run.
    pub culprit: Option<Culprit>,
    /// Files beside the page.
    pub links: Vec<Link>,
    /// How to continue, in words and commands.
    pub next: Vec<(String, String)>,
}

/// Where the figures of a page come from.
#[derive(Clone, Debug, Default)]
pub struct Sources<'a> {
    /// Content of `summary.json`; `None` before the end.
    pub summary: Option<&'a Value>,
    /// Probes over time.
    pub probes: Table,
    /// Interface ledger over time.
    pub ledger: Table,
    /// Largest values of particles.
    pub extremes: &'a [Extreme],
    /// Tables of facts.
    pub tables: Vec<FactTable>,
}

impl RunPage {
    /// The page of the run in `folder`, without frames.
    pub fn new(folder: &Path, case: &CaseFacts, sources: Sources<'_>) -> Self {
        let Sources { summary, probes, ledger, extremes, tables } = sources;
        let text = |key: &str| summary.and_then(|s| s.get(key)?.as_str()).unwrap_or("").to_owned();
        let texts = |key: &str| -> Vec<String> {
            let list = summary.and_then(|s| s.get(key)?.as_array());
            list.map_or_else(Vec::new, |list| {
                list.iter().filter_map(|v| Some(v.as_str()?.to_owned())).collect()
            })
        };
        let reservations = texts("reservations");
        let verdict = match (summary, text("verdict")) {
            (None, _) => "running".to_owned(),
            (_, verdict) if verdict == "completed" && !reservations.is_empty() => {
                format!("{verdict}, with reservations")
            }
            (_, verdict) => verdict,
        };
        let figures = story::key_figures(extremes, &probes, case.dimensions);
        let last = |name: &str| ledger.column(name).and_then(|values| values.last().copied());
        let simulated = summary.and_then(|s| s.get("simulated")?.get("end_s")?.as_f64()).or(last("t_s"));
        let steps = summary.and_then(|s| s.get("steps")?.as_u64());
        // Steps of a ledger are whole numbers far below 2^53.
        let steps = steps.or(last("step").map(|step| step as u64 + 1)).unwrap_or(0);
        let mut plots = plots::probes(&probes);
        plots.extend(plots::energies(&ledger));
        plots.extend(plots::ledger(&ledger, case.tolerance));
        Self {
            title: case.title.clone(),
            sentence: story::sentence(&figures, simulated.unwrap_or(case.span[0]) - case.span[0], steps),
            verdict,
            reason: text("reason"),
            figures,
            first_figures: FIRST_FIGURES,
            quality: quality(summary),
            reservations,
            budgets: story::budgets(&ledger),
            plots,
            tables,
            warnings: texts("warnings"),
            culprit: culprit(folder).filter(|_| text("verdict") == "failed"),
            links: FILES
                .into_iter()
                .filter(|(file, _)| folder.join(file).is_file())
                .map(|(file, meaning)| Link { file, meaning })
                .collect(),
            next: next(folder, &text("verdict")),
            ..Self::default()
        }
    }

    /// Adds the frames of `film`; their data go beside this message.
    pub fn with_film(mut self, film: &Film) -> Self {
        self.scene = Some(film.scene.clone());
        self.columns.clone_from(&film.columns);
        self.frames.clone_from(&film.frames);
        self.notes.clone_from(&film.notes);
        self
    }
}

/// The quality figures of a summary, in words.
fn quality(summary: Option<&Value>) -> Vec<Quality> {
    let list = summary.and_then(|s| s.get("quality")?.as_array());
    let figure = |figure: &Value| {
        let text = |key: &str| figure.get(key).and_then(Value::as_str).unwrap_or("").to_owned();
        let number = |key: &str| figure.get(key).and_then(Value::as_f64);
        let name = text("name");
        let bound = if name == "particles_across" { "at least" } else { "at most" };
        Quality {
            value: number("value").map_or(String::new(), |value| plain(value, "")),
            threshold: number("threshold")
                .map_or(String::new(), |value| format!("{bound} {}", plain(value, ""))),
            verdict: text("verdict"),
            meaning: text("meaning"),
            advice: text("advice"),
            name: name.replace('_', " "),
        }
    };
    list.map_or_else(Vec::new, |list| list.iter().map(figure).collect())
}

/// What one may do with the results.
fn next(folder: &Path, verdict: &str) -> Vec<(String, String)> {
    let shown = crate::quote::path(folder).to_string();
    let mut list =
        vec![("open the particles in ParaView".to_owned(), format!("paraview {shown}/snapshots/*.pvd"))];
    match verdict {
        "completed" => {
            list.push(("let it run longer".to_owned(), format!("{PROGRAM} resume {shown} --until T")))
        }
        "" => {}
        _ => list.push(("continue from the last checkpoint".to_owned(), format!("{PROGRAM} resume {shown}"))),
    }
    list
}

/// Facts of a finished run by its summary alone.
pub fn facts_of(summary: &Value) -> Facts {
    let number = |path: &[&str]| path.iter().try_fold(summary, |at, key| at.get(key)).and_then(Value::as_f64);
    let mut facts = Facts::new();
    let mut add = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            facts.push((name.to_owned(), value));
        }
    };
    add("steps", number(&["steps"]).map(|n| format!("{n}")));
    add("simulated", number(&["simulated", "end_s"]).map(|t| plain(t, "s")));
    add("wall time", number(&["wall_seconds"]).map(duration));
    let sizes = number(&["time_step", "smallest_s"]).zip(number(&["time_step", "largest_s"]));
    add(
        "time step",
        sizes.map(
            |(a, b)| if a == b { plain(a, "s") } else { format!("{} to {}", plain(a, "s"), plain(b, "s")) },
        ),
    );
    for side in ["fluid", "solid"] {
        add(&format!("particles, {side}"), number(&[side, "counts", "particles"]).map(|n| format!("{n}")));
    }
    add("breaches of the ledger", number(&["ledger", "breaches"]).map(|n| format!("{n}")));
    facts
}

/// Seconds as a person writes them.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return String::new();
    }
    // Far below 2^63 for any run.
    let whole = seconds.round() as u64;
    match whole {
        0..10 => format!("{seconds:.1}\u{a0}s"),
        10..120 => format!("{whole}\u{a0}s"),
        120..7200 => format!("{}\u{a0}min {:02}\u{a0}s", whole / 60, whole % 60),
        _ => format!("{}\u{a0}h {:02}\u{a0}min", whole / 3600, whole / 60 % 60),
    }
}
