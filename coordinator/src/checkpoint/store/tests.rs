//! Writing under faults: power cuts between any two operations, full disks, damaged files.

use std::io;

use proto::checkpoint::CheckpointHeader;
use sph::coupling::solver::Role;

use super::*;
use crate::checkpoint::Disk;
use crate::results::recorder::RecorderState;

fn checkpoint(step: u64) -> RunCheckpoint {
    let side = |role| {
        let data: Vec<u8> = (0..3000u64).map(|k| ((k * 31 + step) % 251) as u8).collect();
        let header = CheckpointHeader {
            format: "test/1".into(),
            name: "solver".into(),
            version: "1".into(),
            build: "b".into(),
            arithmetic: "f64".into(),
            role,
            step,
            time: 0.1 * step as f64,
            next_time_step: 0.1,
        };
        CheckpointData { header, sha256: proto::checkpoint::digest(&data), data: data.into() }
    };
    RunCheckpoint {
        step,
        time: 0.1 * step as f64,
        sides: vec![side(Role::Fluid), side(Role::Solid)],
        outputs: OutputState {
            case: "name = \"a\"\n[time]\nstep = 1\n".into(),
            recorder: RecorderState::default(),
            wall_seconds: 1.0 / 3.0,
            origin: [None, None],
        },
    }
}

fn store() -> (tempfile::TempDir, Store) {
    let root = tempfile::tempdir().unwrap();
    let store = Store::new(root.path().join("checkpoints"));
    (root, store)
}

fn newest_step(store: &Store) -> Option<u64> {
    store.newest().checkpoint.map(|checkpoint| checkpoint.step)
}

/// One file operation, paths relative to the root.
#[derive(Clone, Debug)]
enum Operation {
    CreateFolder(PathBuf),
    Write(PathBuf, Vec<u8>),
    Sync(PathBuf),
    Rename(PathBuf, PathBuf),
    RemoveFile(PathBuf),
    RemoveFolder(PathBuf),
}

/// The disk, with a record of what was asked of it; from operation `fails_at` on it is full.
struct Recording {
    root: PathBuf,
    operations: Vec<Operation>,
    fails_at: usize,
}

impl Recording {
    fn new(root: &Path) -> Self {
        Self { root: root.to_path_buf(), operations: Vec::new(), fails_at: usize::MAX }
    }

    fn note(&mut self, operation: impl FnOnce(&dyn Fn(&Path) -> PathBuf) -> Operation) -> io::Result<()> {
        let root = self.root.clone();
        let operation = operation(&|path: &Path| path.strip_prefix(&root).unwrap().to_path_buf());
        if self.operations.len() >= self.fails_at && matches!(operation, Operation::Write(..)) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.operations.push(operation);
        Ok(())
    }
}

impl Files for Recording {
    fn create_folder(&mut self, path: &Path) -> io::Result<()> {
        self.note(|at| Operation::CreateFolder(at(path)))?;
        Disk.create_folder(path)
    }

    fn write(&mut self, path: &Path, content: &[u8]) -> io::Result<()> {
        self.note(|at| Operation::Write(at(path), content.to_vec()))?;
        Disk.write(path, content)
    }

    fn sync(&mut self, path: &Path) -> io::Result<()> {
        self.note(|at| Operation::Sync(at(path)))?;
        Disk.sync(path)
    }

    fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        self.note(|at| Operation::Rename(at(from), at(to)))?;
        Disk.rename(from, to)
    }

    fn remove_file(&mut self, path: &Path) -> io::Result<()> {
        self.note(|at| Operation::RemoveFile(at(path)))?;
        Disk.remove_file(path)
    }

    fn remove_folder(&mut self, path: &Path) -> io::Result<()> {
        self.note(|at| Operation::RemoveFolder(at(path)))?;
        Disk.remove_folder(path)
    }
}

/// What a disk makes of operations whose effect was not asked to be on it when the power went.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Unsynced {
    /// All of it is there.
    Kept,
    /// Contents are half there; folders, files and names that are new are not, and what was removed is.
    Lost,
    /// Contents are half there, names are as they should.
    Half,
    /// Each effect is there or not by dice with this seed: a disk may bring them down in any order.
    Scattered(u64),
}

impl Unsynced {
    /// Says of one effect after the other whether it is there.
    fn dice(self) -> impl FnMut() -> bool {
        let mut state = match self {
            Self::Scattered(seed) => seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1,
            Self::Kept | Self::Lost | Self::Half => 0,
        };
        move || match self {
            Self::Kept | Self::Half => true,
            Self::Lost => false,
            Self::Scattered(_) => {
                state ^= state >> 12;
                state ^= state << 25;
                state ^= state >> 27;
                state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 63 == 1
            }
        }
    }
}

/// Repeats `operations` under `root`, as a disk holds them after a cut.
fn replay(root: &Path, operations: &[Operation], unsynced: Unsynced) {
    let synced = |after: usize, path: &Path| {
        operations[after..].iter().any(|later| matches!(later, Operation::Sync(at) if at == path))
    };
    let mut there = unsynced.dice();
    for (k, operation) in operations.iter().enumerate() {
        let mut named = |path: &Path| synced(k, path.parent().unwrap()) || there();
        // What builds on an effect that is lost is lost with it; a folder that keeps a file stays.
        match operation {
            Operation::CreateFolder(path) => {
                if named(path) {
                    drop(std::fs::create_dir(root.join(path)));
                }
            }
            Operation::Write(path, content) => {
                let (named, whole) = (named(path), synced(k, path) || unsynced == Unsynced::Kept);
                let there = if whole { content.as_slice() } else { &content[..content.len() / 2] };
                if named {
                    drop(std::fs::write(root.join(path), there));
                }
            }
            Operation::Sync(_) => {}
            Operation::Rename(from, to) => {
                if named(to) {
                    drop(std::fs::rename(root.join(from), root.join(to)));
                }
            }
            Operation::RemoveFile(path) => {
                if named(path) {
                    drop(std::fs::remove_file(root.join(path)));
                }
            }
            Operation::RemoveFolder(path) => {
                if named(path) {
                    drop(std::fs::remove_dir(root.join(path)));
                }
            }
        }
    }
}

/// The newest good step after each cut from `first` on, under every fate of what was not synced.
fn after_all_cuts(
    operations: &[Operation],
    first: usize,
    mut look: impl FnMut(usize, Unsynced, Option<u64>),
) {
    let fates = [Unsynced::Kept, Unsynced::Lost, Unsynced::Half];
    for cut in first..=operations.len() {
        for unsynced in fates.into_iter().chain((0..20).map(Unsynced::Scattered)) {
            let copy = tempfile::tempdir().unwrap();
            replay(copy.path(), &operations[..cut], unsynced);
            let store = Store::new(copy.path().join("checkpoints"));
            let found = store.newest().checkpoint;
            if let Some(found) = &found {
                assert_eq!(found.sides, checkpoint(found.step).sides, "{cut}, {unsynced:?}");
            }
            look(cut, unsynced, found.map(|found| found.step));
            // The next run cleans up and continues; bringing each to the disk takes its time.
            if !matches!(unsynced, Unsynced::Scattered(_)) {
                store.write(&mut Disk, &checkpoint(50)).unwrap();
                assert_eq!(newest_step(&store), Some(50));
            }
        }
    }
}

#[test]
fn after_a_cut_between_any_two_operations_there_is_a_good_checkpoint() {
    let (root, store) = store();
    let mut files = Recording::new(root.path());
    let mut done = Vec::new();
    for step in [10, 20, 30, 40] {
        store.write(&mut files, &checkpoint(step)).unwrap();
        done.push((files.operations.len(), step));
    }
    assert!(files.operations.len() > 40, "{}", files.operations.len());
    after_all_cuts(&files.operations, done[0].0, |cut, unsynced, newest| {
        // One that was reported as written is not lost any more.
        let reported = done.iter().filter(|(operations, _)| *operations <= cut).map(|(_, step)| *step).max();
        assert!(
            newest >= reported,
            "{newest:?} after {cut} operations, {unsynced:?}, {reported:?} was written"
        );
    });
}

#[test]
fn after_a_cut_while_a_damaged_one_is_replaced_there_is_a_good_checkpoint() {
    let (root, store) = store();
    let mut files = Recording::new(root.path());
    for step in [10, 20] {
        store.write(&mut files, &checkpoint(step)).unwrap();
    }
    let first = files.operations.len();
    let data = root.path().join("checkpoints").join(checkpoint_name(20)).join("fluid.bin");
    files.write(&data, b"damaged").unwrap();
    files.sync(&data).unwrap();
    store.clear(&mut files, 10).unwrap();
    for step in [20, 30] {
        store.write(&mut files, &checkpoint(step)).unwrap();
    }
    after_all_cuts(&files.operations, first, |cut, unsynced, newest| {
        assert!(newest.is_some(), "nothing good after {cut} operations, {unsynced:?}");
    });
}

#[test]
fn the_same_state_of_another_build_leaves_the_checkpoint_as_it_is() {
    let (root, store) = store();
    store.write(&mut Disk, &checkpoint(10)).unwrap();
    let mut files = Recording::new(root.path());
    let mut other = checkpoint(10);
    other.sides.iter_mut().for_each(|side| side.header.build = "other".into());
    store.write(&mut files, &other).unwrap();
    // To replace the only one would take it away for a moment.
    assert!(files.operations.is_empty(), "{:?}", files.operations);
}

#[test]
fn a_full_disk_leaves_the_last_checkpoint_and_says_what_to_do() {
    let (root, store) = store();
    store.write(&mut Disk, &checkpoint(10)).unwrap();
    for fails_at in 0..8 {
        let mut files = Recording { fails_at, ..Recording::new(root.path()) };
        let Err(error) = store.write(&mut files, &checkpoint(20)) else { continue };
        assert!(error.to_string().contains("free some space"), "{error}");
        assert_eq!(newest_step(&store), Some(10), "failing at {fails_at}");
        assert_eq!(std::fs::read_dir(root.path().join("checkpoints")).unwrap().count(), 1, "remains");
    }
    store.write(&mut Disk, &checkpoint(20)).unwrap();
    assert_eq!(newest_step(&store), Some(20));
}

#[test]
fn two_are_kept_and_come_back_as_they_were() {
    let (_root, store) = store();
    for step in [10, 20, 30] {
        store.write(&mut Disk, &checkpoint(step)).unwrap();
    }
    assert_eq!(store.steps(), [30, 20]);
    let back = store.load(30).unwrap();
    assert_eq!(back.sides, checkpoint(30).sides);
    assert_eq!(back.outputs.wall_seconds.to_bits(), (1.0f64 / 3.0).to_bits());
    assert_eq!(back.time.to_bits(), checkpoint(30).time.to_bits());
}

#[test]
fn every_damage_is_found_and_the_one_before_is_used() {
    let (root, store) = store();
    store.write(&mut Disk, &checkpoint(10)).unwrap();
    store.write(&mut Disk, &checkpoint(20)).unwrap();
    let folder = root.path().join("checkpoints").join(checkpoint_name(20));
    for name in ["fluid.bin", "solid.bin", COORDINATOR_FILE, MANIFEST] {
        let path = folder.join(name);
        let good = std::fs::read(&path).unwrap();
        let places = [0, good.len() / 3, good.len() - 1];
        let flipped = places.map(|k| {
            let mut bad = good.clone();
            bad[k] ^= 0x04;
            bad
        });
        let cut = good[..good.len() - 1].to_vec();
        for bad in flipped.into_iter().chain([cut, Vec::new()]) {
            std::fs::write(&path, bad).unwrap();
            let found = store.newest();
            assert_eq!(found.checkpoint.map(|checkpoint| checkpoint.step), Some(10), "{name}");
            assert!(found.skipped[0].contains("step_000000000020"), "{:?}", found.skipped);
        }
        std::fs::remove_file(&path).unwrap();
        assert_eq!(newest_step(&store), Some(10), "{name} is missing");
        std::fs::write(&path, good).unwrap();
        assert_eq!(newest_step(&store), Some(20));
    }
}

#[test]
fn another_case_is_named_by_its_first_different_line() {
    let saved = checkpoint(10);
    assert_eq!(saved.case_difference(&saved.outputs.case), None);
    let other = saved.outputs.case.replace("step = 1", "step = 2");
    let difference = saved.case_difference(&other).unwrap();
    assert_eq!(difference, "in [time]: `step = 1` in the checkpoint, `step = 2` in the case");
}

#[test]
fn a_half_written_checkpoint_goes_and_links_are_not_followed() {
    let (root, store) = store();
    let folder = root.path().join("checkpoints");
    for step in [10, 20, 30] {
        store.write(&mut Disk, &checkpoint(step)).unwrap();
    }
    let elsewhere = root.path().join("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    std::fs::write(elsewhere.join("manifest.json"), "mine").unwrap();
    let partial = |step| folder.join(format!("{}{PARTIAL}", checkpoint_name(step)));
    std::fs::rename(folder.join(checkpoint_name(30)), partial(30)).unwrap();
    std::os::unix::fs::symlink(&elsewhere, partial(40)).unwrap();
    store.clear(&mut Disk, 20).unwrap();
    assert!(!partial(30).exists() && !partial(40).is_symlink());
    assert_eq!(newest_step(&store), Some(20));
    // One in the place of the checkpoint that is being written.
    std::os::unix::fs::symlink(&elsewhere, partial(40)).unwrap();
    store.write(&mut Disk, &checkpoint(40)).unwrap();
    assert_eq!(newest_step(&store), Some(40));
    assert_eq!(std::fs::read_to_string(elsewhere.join("manifest.json")).unwrap(), "mine");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
}

#[test]
fn what_a_kill_left_of_an_old_checkpoint_goes() {
    let (root, store) = store();
    for step in [10, 20, 30] {
        store.write(&mut Disk, &checkpoint(step)).unwrap();
    }
    // Killed while the oldest was being removed: its manifest goes first.
    let old = root.path().join("checkpoints").join(checkpoint_name(10));
    std::fs::create_dir(&old).unwrap();
    std::fs::write(old.join("fluid.bin"), "").unwrap();
    store.clear(&mut Disk, 30).unwrap();
    assert_eq!(store.steps(), [30, 20]);
}

#[test]
fn what_no_run_wrote_stays_in_a_checkpoint_s_folder() {
    let (root, store) = store();
    store.write(&mut Disk, &checkpoint(10)).unwrap();
    let mine = root.path().join("checkpoints").join(checkpoint_name(10)).join("mine");
    std::fs::write(&mine, "mine").unwrap();
    for step in [20, 30, 40] {
        store.write(&mut Disk, &checkpoint(step)).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&mine).unwrap(), "mine");
    assert_eq!(newest_step(&store), Some(40));
    assert!(store.load(10).is_err());
}

#[test]
fn pipes_and_sparse_files_are_refused_at_once() {
    let (root, store) = store();
    store.write(&mut Disk, &checkpoint(10)).unwrap();
    let folder = root.path().join("checkpoints").join(checkpoint_name(10));
    for name in CHECKPOINT_FILES {
        let path = folder.join(name);
        let good = std::fs::read(&path).unwrap();
        std::fs::File::options().write(true).open(&path).unwrap().set_len(200_000_000_000).unwrap();
        assert!(store.load(10).unwrap_err().contains("200000000000 bytes"), "{name}");
        std::fs::remove_file(&path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        assert!(store.load(10).unwrap_err().contains("no regular file"), "{name}");
        std::fs::remove_file(&path).unwrap();
        std::fs::write(&path, good).unwrap();
    }
    assert_eq!(newest_step(&store), Some(10));
}

#[test]
fn a_checkpoint_of_another_format_names_both() {
    let (root, store) = store();
    store.write(&mut Disk, &checkpoint(10)).unwrap();
    let manifest = root.path().join("checkpoints").join(checkpoint_name(10)).join(MANIFEST);
    let text = std::fs::read_to_string(&manifest).unwrap();
    std::fs::write(&manifest, text.replace("\"format\": 12", "\"format\": 11")).unwrap();
    let said = store.newest().skipped.remove(0);
    for words in ["is of format 11", "reads format 12", "with the build that wrote it"] {
        assert!(said.contains(words), "{said}");
    }
}
