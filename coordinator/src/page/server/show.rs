//! What the folder of a run shows at present: read again when files have changed.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Instant, SystemTime};

use hyper::body::Bytes;
use serde::Serialize;
use serde_json::Value;

use crate::page::document;
use crate::page::film::{Extreme, Film, Frame, single};
use crate::page::folder::{CaseFacts, Snapshots, is_unfinished, text};
use crate::page::live::Live;
use crate::page::particles::Group;
use crate::page::run::{FactTable, RunPage, Sources, Status, duration, facts_of};
use crate::page::scene::{Scale, Scene};
use crate::page::story::plain;
use crate::results::names;
use crate::results::table::Table;

/// Most particles of a frame of a running run.
const MOST_PARTICLES: usize = 200_000;
/// Frames that are kept packed.
const KEPT_FRAMES: usize = 8;

/// Size and time of each file that is shown.
type Stamp = Vec<Option<(u64, SystemTime)>>;

/// What the page shows of a folder.
pub(super) struct Show {
    folder: PathBuf,
    live: Option<Arc<Live>>,
    started: Instant,
    /// What was read. It is never held while files are read: answers do not wait for the disk.
    state: Mutex<State>,
    /// Tables, and a frame, are read by one at a time, so that many visitors cost the memory of one.
    reading_tables: Mutex<()>,
    reading_frame: Mutex<()>,
}

#[derive(Default)]
struct State {
    case: Option<CaseFacts>,
    stamp: Stamp,
    /// Counts the times that the folder was read.
    version: u64,
    page: Option<RunPage>,
    snapshots: Snapshots,
    groups: Vec<Group>,
    extremes: Vec<Extreme>,
    scene: Option<Scene>,
    packed: Vec<(usize, Bytes)>,
    /// Simulated time when this page first looked, and when that was.
    first: Option<(f64, Instant)>,
    /// Change of the mean volume of a mass of water since the first frame, by density \[-\].
    volume: Option<(f64, f64)>,
    ended: bool,
    /// The page of a run that has ended, and of which files it is.
    finished: Option<(Stamp, Bytes)>,
}

/// An event.
#[derive(Serialize)]
struct Message {
    version: u64,
    frames: usize,
    status: Status,
}

/// The answer to the request for a frame.
#[derive(Serialize)]
struct FrameMessage {
    #[serde(flatten)]
    frame: Frame,
    data: String,
    /// Colour scales of this frame alone.
    scales: Vec<Scale>,
}

impl Show {
    pub fn new(folder: &Path, live: Option<Arc<Live>>) -> Self {
        Self {
            folder: folder.to_owned(),
            live,
            started: Instant::now(),
            state: Mutex::default(),
            reading_tables: Mutex::default(),
            reading_frame: Mutex::default(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        held(&self.state)
    }

    /// The state, read once at least.
    fn looked_at(&self) -> MutexGuard<'_, State> {
        if self.state().page.is_none() {
            self.look(false);
        }
        self.state()
    }

    /// Whether the run has written all that it will.
    fn is_finished(&self) -> bool {
        self.live.is_none() && !is_unfinished(&self.folder)
    }

    /// The page: with all frames inside where the run has ended.
    pub fn page(&self) -> Result<Option<Bytes>, String> {
        if !self.is_finished() {
            self.look(false);
            let state = self.state();
            let empty = RunPage { title: "run".into(), verdict: "running".into(), ..RunPage::default() };
            let page = state.page.as_ref().unwrap_or(&empty);
            return Ok(Some(document::live(page).map_err(|e| e.to_string())?.into()));
        }
        let _reading = held(&self.reading_tables);
        let stamp = self.stamp();
        if let Some((_, page)) = self.state().finished.as_ref().filter(|(known, _)| *known == stamp) {
            return Ok(Some(page.clone()));
        }
        let case = CaseFacts::read(&self.folder)?;
        let film = Film::of(&case, &Snapshots::list(&self.folder, false))?;
        let extremes = film.as_ref().map_or(&[][..], |film| &film.extremes);
        let page = self.read(&case, extremes, true)?;
        let page = film.iter().fold(page, |page, film| page.with_film(film));
        let bytes: Bytes = document::report(&page, film.as_ref(), "").map_err(|e| e.to_string())?.into();
        self.state().finished = Some((stamp, bytes.clone()));
        Ok(Some(bytes))
    }

    /// The message of the page.
    pub fn run(&self) -> Result<Option<Bytes>, String> {
        let state = self.looked_at();
        let Some(page) = &state.page else { return Ok(None) };
        Ok(Some(serde_json::to_vec(page).map_err(|e| e.to_string())?.into()))
    }

    /// Frame `k`, standing alone.
    pub fn frame(&self, k: usize) -> Result<Option<Bytes>, String> {
        let _reading = held(&self.reading_frame);
        let (case, snapshots, mut groups, every) = {
            let state = self.looked_at();
            if let Some((_, bytes)) = state.packed.iter().find(|(kept, _)| *kept == k) {
                return Ok(Some(bytes.clone()));
            }
            let Some(case) = state.case.clone() else { return Ok(None) };
            let every = state.scene.as_ref().map_or(1, |scene| scene.every);
            (case, state.snapshots.clone(), state.groups.clone(), every)
        };
        let Some(moment) = snapshots.moments.get(k) else { return Ok(None) };
        let found = single(&case, &snapshots, moment, &mut groups, every)?;
        let scene = Scene::of(&case, groups.clone(), std::slice::from_ref(&found.particles), every);
        let data = found.frame.data.clone();
        let message = FrameMessage { frame: found.frame, data, scales: scene.scales };
        let bytes: Bytes = serde_json::to_vec(&message).map_err(|e| e.to_string())?.into();
        let mut state = self.state();
        if !state.snapshots.moments.starts_with(&snapshots.moments) {
            // The run took the snapshot back meanwhile.
            return Ok(Some(bytes));
        }
        state.groups = groups;
        for extreme in found.extremes {
            crate::page::film::keep(&mut state.extremes, extreme);
        }
        if let Some(volume) = found.specific_volume {
            let first = state.volume.map_or(volume, |(first, _)| first);
            state.volume = Some((first, volume));
        }
        state.packed.push((k, bytes.clone()));
        if state.packed.len() > KEPT_FRAMES {
            state.packed.remove(0);
        }
        Ok(Some(bytes))
    }

    /// Reads what has changed; answers the event to send.
    pub fn look(&self, ended: bool) -> String {
        let reading = held(&self.reading_tables);
        let finished = self.is_finished();
        let stamp = self.stamp();
        let (case, changed) = {
            let mut state = self.state();
            state.ended |= ended || finished;
            (state.case.clone(), ended || stamp != state.stamp || state.page.is_none())
        };
        if let Some(case) = case.or_else(|| CaseFacts::read(&self.folder).ok()) {
            self.state().case = Some(case.clone());
            if changed {
                self.refresh(&case, stamp);
            }
        }
        drop(reading);
        let mut state = self.state();
        let status = self.status(&mut state);
        let message = Message { version: state.version, frames: state.snapshots.moments.len(), status };
        serde_json::to_string(&message).unwrap_or_default()
    }

    fn stamp(&self) -> Stamp {
        let tables = [names::PROBES, names::LEDGER].map(|name| table_path(&self.folder, name));
        let snapshots = self.folder.join(names::SNAPSHOTS);
        let others = ["fluid.pvd", "solid.pvd"].map(|name| snapshots.join(name));
        let files = tables.into_iter().chain(others).chain([self.folder.join(names::SUMMARY)]);
        files
            .map(|path| {
                std::fs::metadata(path).ok().and_then(|facts| Some((facts.len(), facts.modified().ok()?)))
            })
            .collect()
    }

    /// Reads what the folder holds and publishes it; the caller holds `reading_tables`.
    fn refresh(&self, case: &CaseFacts, stamp: Stamp) {
        let (ended, known, extremes, mut groups, mut scene) = {
            let state = self.state();
            let known = state.snapshots.moments.clone();
            (state.ended, known, state.extremes.clone(), state.groups.clone(), state.scene.clone())
        };
        let snapshots = Snapshots::list(&self.folder, !ended);
        // A run that continues may have taken snapshots back.
        let taken_back = !snapshots.moments.starts_with(&known);
        if taken_back {
            scene = None;
        }
        if scene.is_none()
            && let Some(first) = snapshots.moments.first()
        {
            let mut found = Vec::new();
            // A file that is not there yet is there at the next look.
            let whole = snapshots.read(first, &case.walls, &mut found, 1, |_, _| {});
            if let Ok(mut particles) = whole {
                let mut every = 1u32;
                while particles.slots.len() / every as usize > MOST_PARTICLES {
                    every *= 2;
                }
                particles.thin(every);
                scene = Some(Scene::of(case, found.clone(), &[particles], every));
                groups = found;
            }
        }
        let page = self.read(case, &extremes, ended);
        let mut state = self.state();
        if taken_back {
            state.packed.clear();
        }
        // A frame that was read meanwhile may know more groups.
        if taken_back || groups.len() > state.groups.len() {
            state.groups = groups;
        }
        (state.snapshots, state.scene) = (snapshots, scene);
        let Ok(mut page) = page else { return };
        state.stamp = stamp;
        page.scene.clone_from(&state.scene);
        if let Some(scene) = &mut page.scene {
            scene.groups.clone_from(&state.groups);
            if scene.every > 1 {
                page.notes.push(format!("about one particle in {} is shown", scene.every));
            }
        }
        let frame = |time| Frame { time, step: 0, count: 0, columns: None, data: String::new() };
        page.frames = state.snapshots.moments.iter().map(|moment| frame(moment.time)).collect();
        state.page = Some(page);
        state.version += 1;
    }

    /// The message of the page, without frames.
    fn read(&self, case: &CaseFacts, extremes: &[Extreme], ended: bool) -> Result<RunPage, String> {
        // Before the end it is that of an earlier part of the run, if there is one.
        let read = || text(&self.folder.join(names::SUMMARY)).ok();
        let parse = |text: String| serde_json::from_str::<Value>(&text).ok();
        let summary = ended.then(read).flatten().and_then(parse);
        let table = |name: &str| Table::read(&table_path(&self.folder, name)).unwrap_or_default();
        let tables = match (&self.live, &summary) {
            (Some(live), _) => live.now().tables(),
            (None, Some(summary)) => {
                vec![FactTable { id: "facts", headline: "Run", rows: facts_of(summary) }]
            }
            (None, None) => Vec::new(),
        };
        let sources = Sources {
            summary: summary.as_ref(),
            probes: table(names::PROBES),
            ledger: table(names::LEDGER),
            extremes,
            tables,
        };
        let mut page = RunPage::new(&self.folder, case, sources);
        if summary.is_none() {
            page.next.clear();
        }
        Ok(page)
    }

    fn status(&self, state: &mut State) -> Status {
        let now = self.live.as_ref().map(|live| live.now());
        let case = state.case.clone().unwrap_or_default();
        let last = |name: &str| {
            let plots = state.page.iter().flat_map(|page| &page.plots).flat_map(|group| &group.plots);
            plots.flat_map(|plot| plot.lines.iter().map(move |line| (plot, line))).find_map(|(plot, line)| {
                (plot.title.starts_with(name)).then(|| line.values.last().copied()).flatten()
            })
        };
        let of_tables = state.page.as_ref().and_then(|page| {
            page.plots.iter().find(|group| group.id == "ledger")?.plots.first()?.times.last().copied()
        });
        let time = now.as_ref().and_then(|now| now.time).or(of_tables).unwrap_or(case.span[0]);
        let first = *state.first.get_or_insert((time, Instant::now()));
        let (from, since) = now.as_ref().and_then(|now| now.began).unwrap_or(first);
        let (done, seconds) = (time - from, since.elapsed().as_secs_f64());
        let left = if done > 0.0 { (case.span[1] - time) / done * seconds } else { f64::INFINITY };
        let started = now.as_ref().map_or(self.started, |now| now.started);
        let mut figures = Vec::new();
        let mut add = |name: &str, value: Option<String>| {
            if let Some(value) = value.filter(|value| !value.is_empty()) {
                figures.push((name.to_owned(), value));
            }
        };
        add("time step", last("Time step").map(|step| plain(step, "s")));
        add("limit of the step", now.as_ref().map(|now| now.limits.clone()));
        add(
            "ledger",
            now.as_ref().map(|now| match now.breaches {
                0 => "balances".to_owned(),
                some => format!("{some} breaches"),
            }),
        );
        add("imbalance", last("Action = reaction").map(|value| plain(value, "")));
        let residuals = state.page.iter().flat_map(|page| &page.budgets);
        let residual =
            residuals.flat_map(|budget| &budget.accounts).filter(|account| account.kind == "residual");
        let residual = residual.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        add("energy residual", residual.map(|account| account.text.clone()));
        add(
            "volume of the water by density",
            state.volume.map(|(first, now)| format!("{:+.3} %", 100.0 * (now / first - 1.0))),
        );
        add("last checkpoint", last_checkpoint(&self.folder).map(|step| format!("step {step}")));
        let doing = match (&now, state.ended) {
            (Some(now), _) => now.doing.clone(),
            (None, true) => "ended".to_owned(),
            (None, false) => format!(
                "running in another process, or ended without completing its files; looked at for {}",
                duration(self.started.elapsed().as_secs_f64())
            ),
        };
        let span = (case.span[1] - case.span[0]).max(f64::MIN_POSITIVE);
        Status {
            doing,
            ended: state.ended,
            time,
            end_time: case.span[1],
            share: ((time - case.span[0]) / span).clamp(0.0, 1.0),
            steps: now.as_ref().map_or(0, |now| now.steps),
            elapsed: if now.is_some() { duration(started.elapsed().as_secs_f64()) } else { String::new() },
            left: if state.ended { String::new() } else { duration(left) },
            figures,
        }
    }
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The table of that name, complete or growing.
fn table_path(folder: &Path, name: &str) -> PathBuf {
    let growing = folder.join(format!("{name}{}", names::PARTIAL));
    if growing.is_file() { growing } else { folder.join(name) }
}

/// Step of the newest complete checkpoint.
fn last_checkpoint(folder: &Path) -> Option<u64> {
    let entries = std::fs::read_dir(folder.join(names::CHECKPOINTS)).ok()?;
    entries.filter_map(|entry| names::checkpoint_step(&entry.ok()?.file_name().to_string_lossy())).max()
}
