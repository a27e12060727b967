//! Writes what a run leaves behind, as it happens.

mod pictures;

use std::fs::File;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sph::coupling::driver::{ProbeValues, TRACE};
use sph::coupling::ledger::LedgerVector;
use sph::coupling::solver::{Counts, Divergence, ParticleFields, Role};
use tracing::trace_span;

use crate::case::Case;
use crate::failure::Failure;
use crate::results::directory::OutputDirectory;
use crate::results::energy::{LedgerSide, SideEnergy};
use crate::results::error::OutputError;
use crate::results::ledger::{self, LedgerFile};
use crate::results::ledger_sums::{Extremes, LedgerSums, Work};
use crate::results::matched_step::MatchedStep;
use crate::results::names;
use crate::results::neighbourhood;
use crate::results::plots::gallery::{PairedSnapshot, Pictures};
use crate::results::probes::{self, ProbeFile};
use crate::results::progress::Progress;
use crate::results::snapshots::Snapshots;
use crate::results::state;
use crate::results::table::Changed;
use crate::results::table::{TableFile, TableMark};
use crate::results::tally::Tally;

pub use pictures::forget_others as forget_other_pictures;
use pictures::{picture_file, stored_pictures};

/// What a recorder continues from: everything before the outputs of one step boundary.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RecorderState {
    probes: TableMark,
    ledger_file: TableMark,
    ledger: LedgerSums,
    ledger_row_due: bool,
    /// File names and times of the fluid's and the solid's snapshots.
    snapshots: [Vec<(String, f64)>; 2],
    /// Snapshots that the report shows, by side and step; each is in a file of its own.
    pictures: [Vec<u64>; 2],
    tally: Tally,
    /// Impulse that crossed the interface so far, on the fluid and on the solid \[N s/m\].
    pub impulse: [LedgerVector; 2],
    /// Warnings about outputs that were found changed.
    warnings: Vec<String>,
}

/// Writes tables, snapshots and final states, and keeps what the report needs.
pub struct Recorder {
    directory: Arc<OutputDirectory>,
    probes: ProbeFile,
    ledger: LedgerFile,
    ledger_every_steps: u64,
    ledger_row_due: bool,
    snapshots: Snapshots,
    pictures: Pictures,
    progress: Progress,
    tally: Tally,
    impulse: [LedgerVector; 2],
    /// Steps of the pictures that are in files already.
    stored: [Vec<u64>; 2],
    warnings: Vec<String>,
}

/// What remains of a recorder when all files are complete.
pub struct Recorded {
    /// Figures of the run.
    pub tally: Tally,
    /// Largest imbalances.
    pub extremes: Extremes,
    /// Energy that crossed the interface.
    pub work: Work,
    /// Energy budget of fluid and solid.
    pub energy: [SideEnergy; 2],
    /// Snapshots for pictures, in time order.
    pub snapshots: Vec<PairedSnapshot>,
    /// Warnings about outputs that were found changed when the run continued.
    pub warnings: Vec<String>,
}

impl Recorder {
    /// A recorder into `directory` for a run of `case` by `roles`.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn create(
        directory: &Arc<OutputDirectory>,
        case: &Case,
        roles: &[Role],
        progress: Progress,
    ) -> Result<Self, Failure> {
        let [fluid, solid] = case.probe_columns();
        let snapshots = directory.file(names::SNAPSHOTS);
        let fluid = roles.contains(&Role::Fluid).then_some(fluid.as_slice());
        let solid = roles.contains(&Role::Solid).then_some(solid.as_slice());
        Ok(Self {
            directory: directory.clone(),
            probes: ProbeFile::create(&directory.file(names::PROBES), fluid, solid)?,
            ledger: LedgerFile::create(&directory.file(names::LEDGER), &LedgerSide::of(case, roles))?,
            ledger_every_steps: case.outputs.ledger_every_steps.max(1),
            ledger_row_due: false,
            // A lost attempt that took no checkpoint may have left its last frame.
            snapshots: Snapshots::create(&snapshots, case, roles)?,
            pictures: Pictures::new(case.outputs.picture_times.clone()),
            progress,
            tally: Tally { time: case.run_plan().time.start_time, ..Tally::default() },
            impulse: [LedgerVector::zeros(); 2],
            stored: [Vec::new(), Vec::new()],
            warnings: Vec::new(),
        })
    }

    /// That `directory` holds what a run of `case` had written there at `state`. Nothing is changed.
    ///
    /// # Errors
    /// When a table or a snapshot is missing or is not as it was.
    pub fn examine(
        directory: &OutputDirectory,
        case: &Case,
        roles: &[Role],
        state: &RecorderState,
    ) -> Result<(), Failure> {
        let [fluid, solid] = case.probe_columns();
        let takes_part = |role: Role| roles.contains(&role);
        let columns = probes::columns(
            if takes_part(Role::Fluid) { &fluid } else { &[] },
            if takes_part(Role::Solid) { &solid } else { &[] },
        );
        TableFile::examine(&directory.file(names::PROBES), &columns, &state.probes)?;
        let columns = ledger::columns(&LedgerSide::of(case, roles));
        TableFile::examine(&directory.file(names::LEDGER), &columns, &state.ledger_file)?;
        Ok(Snapshots::examine(&directory.file(names::SNAPSHOTS), &state.snapshots)?)
    }

    /// A recorder that continues from `state`: what was written after it goes.
    ///
    /// # Errors
    /// When a table is missing or is not as it was and `changed` says to refuse that, or a file cannot be written.
    pub fn resume(
        directory: &Arc<OutputDirectory>,
        case: &Case,
        roles: &[Role],
        progress: Progress,
        state: &RecorderState,
        changed: Changed,
    ) -> Result<Self, Failure> {
        let [fluid, solid] = case.probe_columns();
        let folder = directory.file(names::SNAPSHOTS);
        let fluid = roles.contains(&Role::Fluid).then_some(fluid.as_slice());
        let solid = roles.contains(&Role::Solid).then_some(solid.as_slice());
        let (snapshots, missing) = Snapshots::resume(&folder, case, roles, &state.snapshots)?;
        let mut news: Vec<String> =
            missing.iter().map(|name| format!("the snapshot `{name}` was missing")).collect();
        let path = directory.file(names::PROBES);
        let (probes, warning) = ProbeFile::resume(&path, fluid, solid, &state.probes, changed)?;
        news.extend(warning);
        let path = directory.file(names::LEDGER);
        let (ledger, warning) = LedgerFile::resume(
            &path,
            &LedgerSide::of(case, roles),
            &state.ledger_file,
            state.ledger.clone(),
            changed,
        )?;
        news.extend(warning);
        let (pictures, stored) = stored_pictures(directory, case, state, &mut news);
        for text in &news {
            progress.warning(text);
        }
        Ok(Self {
            directory: directory.clone(),
            probes,
            ledger,
            ledger_every_steps: case.outputs.ledger_every_steps.max(1),
            ledger_row_due: state.ledger_row_due,
            snapshots,
            pictures,
            progress,
            tally: state.tally.clone(),
            impulse: state.impulse,
            stored,
            warnings: state.warnings.iter().cloned().chain(news).collect(),
        })
    }

    /// What a recorder continues from at the boundary of `step` completed steps, whether or not the outputs that are due
    /// there have come; and the handles of the tables, to be brought to the disk.
    ///
    /// # Errors
    /// When a picture cannot be written.
    pub fn state(&mut self, step: u64) -> Result<(RecorderState, [File; 2]), Failure> {
        let folder = self.directory.file(names::CHECKPOINTS);
        std::fs::create_dir_all(&folder).map_err(|e| OutputError::file("create folder", &folder, e))?;
        for pair in self.pictures.kept() {
            for (role, fields) in [(Role::Fluid, &pair.fluid), (Role::Solid, &pair.solid)] {
                let stored = &mut self.stored[role.index()];
                if let Some(fields) = fields.as_ref().filter(|f| f.step < step && !stored.contains(&f.step)) {
                    state::write(&picture_file(&self.directory, role, fields.step), fields)?;
                    stored.push(fields.step);
                }
            }
        }
        let saved = RecorderState {
            probes: self.probes.mark_before(step),
            ledger_file: self.ledger.file().mark(),
            ledger: self.ledger.sums().clone(),
            ledger_row_due: self.ledger_row_due,
            snapshots: self.snapshots.files_before(step),
            pictures: self.stored.clone(),
            tally: self.tally.clone(),
            impulse: self.impulse,
            warnings: self.warnings.clone(),
        };
        Ok((saved, [self.probes.file().handle()?, self.ledger.file().handle()?]))
    }

    /// Takes a step that all participants have completed.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn step(&mut self, step: &MatchedStep) -> Result<(), Failure> {
        let _span = trace_span!(target: TRACE, "write step").entered();
        self.ledger.record(step.fluid.as_ref(), step.solid.as_ref(), &step.imbalance);
        self.impulse = step.impulse;
        self.tally.add(step);
        self.ledger_row_due = true;
        if self.tally.steps.is_multiple_of(self.ledger_every_steps) || !step.breaches.is_empty() {
            self.ledger.write_row()?;
            self.ledger_row_due = false;
        }
        self.progress.step(&self.tally, step);
        Ok(())
    }

    /// Takes probe values.
    ///
    /// # Errors
    /// When a row cannot be written or does not fit.
    pub fn probes(&mut self, role: Role, values: ProbeValues) -> Result<(), Failure> {
        let _span = trace_span!(target: TRACE, "write probes").entered();
        self.progress.probes(role, &values);
        Ok(self.probes.take(role, values)?)
    }

    /// Takes a snapshot.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn snapshot(&mut self, role: Role, fields: ParticleFields) -> Result<(), Failure> {
        let _span = trace_span!(target: TRACE, "write snapshot").entered();
        self.snapshots.write(role, &fields)?;
        self.pictures.take(role, fields);
        Ok(())
    }

    /// Lists the particles around the offending one.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn divergence(&self, divergence: &Divergence, fields: &ParticleFields) -> Result<(), Failure> {
        Ok(neighbourhood::write(&self.directory.file(names::DIVERGENCE), divergence, fields)?)
    }

    /// Takes the final state of a participant.
    ///
    /// # Errors
    /// When the final state cannot be written.
    pub fn final_state(
        &mut self,
        role: Role,
        fields: &ParticleFields,
        counts: Counts,
    ) -> Result<(), Failure> {
        let side = &mut self.tally.sides[role.index()];
        side.counts = counts;
        side.state_digest = state::digest(fields);
        Ok(state::write(&self.directory.final_state(&role.to_string()), fields)?)
    }

    /// Completes all tables.
    ///
    /// # Errors
    /// When one cannot be written.
    pub fn finish(mut self) -> Result<Recorded, Failure> {
        self.progress.finish();
        if self.ledger_row_due {
            self.ledger.write_row()?;
        }
        let (extremes, work, energy) = (*self.ledger.extremes(), self.ledger.work(), self.ledger.energy());
        self.probes.finish()?;
        self.ledger.finish()?;
        let (snapshots, warnings) = (self.pictures.finish(), self.warnings);
        Ok(Recorded { tally: self.tally, extremes, work, energy, snapshots, warnings })
    }
}
