//! Checkpoints on the disk and in the solvers: what a damaged one must come to.

use std::path::{Path, PathBuf};

use coordinator::checkpoint::{RunCheckpoint, Store};
use coordinator::failure::Kind;
use coordinator::run::participants::News;
use coordinator::run::participants::in_process;
use coordinator::run::participants::threads::Threads;
use proto::checkpoint::CheckpointData;
use sph::coupling::driver::{Command, Event};
use sph::setup::{AnyFluidSetup, AnySolidSetup};

/// Two good checkpoints of a run of the tank, and its set-ups.
pub(super) struct Kept {
    store: Store,
    newest: RunCheckpoint,
    older: RunCheckpoint,
    /// Files of the newest.
    files: Vec<(PathBuf, Vec<u8>)>,
    setups: (Option<AnyFluidSetup>, Option<AnySolidSetup>),
}

/// Steps that solvers take from a damaged state.
const STEPS: u64 = 2;
/// Events that may wait for the reader.
const PENDING_EVENTS: usize = 256;

impl Kept {
    /// The checkpoints of the results in `results`, of a run of the case `text`.
    pub(super) fn of(results: &Path, text: &str) -> Self {
        let folder = results.join("checkpoints");
        let store = Store::new(folder.clone());
        let newest = store.newest().checkpoint.expect("the run left a checkpoint");
        let named =
            |entry: std::fs::DirEntry| entry.file_name().to_str()?.strip_prefix("step_")?.parse::<u64>().ok();
        let steps = std::fs::read_dir(&folder).unwrap().flatten().filter_map(named);
        let older = steps.filter(|step| *step < newest.step).max().expect("the run left two checkpoints");
        let place = folder.join(format!("step_{:012}", newest.step));
        let paths = std::fs::read_dir(place).unwrap().flatten().map(|entry| entry.path());
        let mut files: Vec<_> = paths.map(|path| (path.clone(), std::fs::read(path).unwrap())).collect();
        files.sort();
        let case = super::read_case(text).expect("the case is good");
        let older = store.load(older).unwrap();
        Self { store, newest, older, files, setups: (case.fluid_setup(), case.solid_setup()) }
    }

    /// Files of the newest checkpoint.
    pub(super) fn files(&self) -> Vec<Vec<u8>> {
        self.files.iter().map(|(_, content)| content.clone()).collect()
    }

    /// States of both solvers, from which there are steps to go.
    pub(super) fn states(&self) -> Vec<Vec<u8>> {
        self.older.sides.iter().map(|side| side.data.to_vec()).collect()
    }

    /// Puts `input` in the place of a file of the newest checkpoint; whether that is still as it was. The one before must be
    /// found otherwise, and the damage reported.
    pub(super) fn find(&self, input: &[u8]) -> bool {
        // Every second one in its own place, as far as that is known, others in any.
        let alike = |good: &[u8]| good.iter().zip(input).take_while(|(a, b)| a == b).count();
        let own = (0..self.files.len()).max_by_key(|k| alike(&self.files[*k].1)).unwrap_or(0);
        let place = if input.len().is_multiple_of(2) { own } else { input.len() % self.files.len() };
        let (path, good) = &self.files[place];
        std::fs::write(path, input).unwrap();
        let found = self.store.newest();
        std::fs::write(path, good).unwrap();
        let checkpoint = found.checkpoint.expect("the checkpoint before is good");
        if checkpoint.step == self.newest.step {
            assert!(same(&checkpoint, &self.newest), "damage to {} is not found", path.display());
            return true;
        }
        assert!(same(&checkpoint, &self.older), "the checkpoint before is another");
        let name = format!("step_{:012}", self.newest.step);
        assert!(found.skipped.len() == 1 && found.skipped[0].contains(&name), "{:?}", found.skipped);
        false
    }

    /// Gives `input`, with a digest that fits, to the solver whose state it seems to be, and lets both solvers step; whether
    /// they took it.
    pub(super) fn take_over(&self, input: &[u8]) -> bool {
        let sha256 = proto::checkpoint::digest(input);
        let mut checkpoint = self.older.clone();
        let Some(side) = checkpoint.sides.iter_mut().find(|side| {
            let names = format!("{}.", side.header.role);
            let data = CheckpointData { header: side.header.clone(), data: input.to_vec().into(), sha256 };
            data.state().is_ok_and(|state| state.arrays.iter().any(|(name, _)| name.starts_with(&names)))
        }) else {
            return false;
        };
        (side.data, side.sha256) = (input.to_vec().into(), sha256);
        let (fluid, solid) = self.setups.clone();
        let (events, mut received) = tokio::sync::mpsc::channel(PENDING_EVENTS);
        let each = Threads::each(1);
        let Ok(threads) = in_process::start(fluid, solid, each, Some(&checkpoint), &events) else {
            return false;
        };
        drop(events);
        for thread in &threads {
            for command in [Command::GrantThrough(checkpoint.step + STEPS), Command::Stop] {
                // It may have ended already.
                let _ = thread.commands.send(command);
            }
        }
        let (mut steps, mut broken) = (0, None);
        while let Some((_, news)) = received.blocking_recv() {
            match news {
                Ok(News::Event(event)) => steps += usize::from(matches!(*event, Event::Step(_))),
                Err(failure) if failure.kind == Kind::Internal => broken = Some(failure.message),
                Ok(News::Checkpoint(_)) | Err(_) => {}
            }
        }
        threads.into_iter().for_each(in_process::ThreadParticipant::join);
        assert!(broken.is_none(), "{broken:?}");
        steps > 0
    }
}

fn same(one: &RunCheckpoint, other: &RunCheckpoint) -> bool {
    one.sides == other.sides
        && one.time.to_bits() == other.time.to_bits()
        && one.outputs.to_bytes() == other.outputs.to_bytes()
}
