use std::io::Write;

use sph::coupling::stage::Stage;
use tempfile::TempDir;

use super::*;
use crate::convert::Choice;
use crate::description::FrameField;

/// Particles of each frame.
const IDS: [u32; 3] = [4, 7, 9];

fn attempt(epoch: u32, first_step: u64) -> Attempt {
    Attempt {
        run_id: "run".into(),
        case_name: "case".into(),
        case_digest: "00ff".into(),
        solvers: ["fluid 1".into(), "solid 2".into()],
        coupling_kind: CouplingKind::Loads,
        epoch,
        first_step,
        first_limit: 0.1,
        extents: [Extent { version: 3, ..Extent::default() }, Extent::default()],
    }
}

/// The first frame of a half-step.
fn first_of(at: StepStage) -> Moment {
    Moment { at, iteration: 0, accepts: false }
}

/// A frame whose velocities begin with `velocity`.
fn frame(step: u64, stage: Stage, velocity: f64) -> wire::Frame {
    let pack = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let block = |field: FrameField, values: &[f64]| wire::Block {
        field: field.code(),
        components: field.components(2),
        data: pack(values).into(),
    };
    let ids = IDS.iter().flat_map(|id| id.to_le_bytes()).collect::<Vec<u8>>();
    let set = wire::ParticleSet { ids: ids.into(), ..wire::ParticleSet::default() };
    wire::Frame {
        run_id: "run".into(),
        step,
        stage: stage.code(),
        count: 3,
        set: (step == 0 && stage == Stage::Predictor).then_some(set),
        blocks: vec![
            block(FrameField::Position, &[0.0; 6]),
            block(FrameField::Velocity, &[0.0, 0.0, 0.0, velocity, 0.0, 0.0]),
        ],
        ..wire::Frame::default()
    }
}

/// Records two steps of both sides; `velocity` tells the solid's velocity by half-step, counted from 0.
fn record(path: &Path, velocity: impl Fn(u64) -> f64) {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    runtime.block_on(async {
        let writer = RecordingWriter::create(path).unwrap();
        writer.attempt(attempt(0, 0)).await;
        let queue = writer.queue();
        for step in 0..2 {
            for (k, stage) in [(0, Stage::Predictor), (1, Stage::Corrector)] {
                // Both orders of passing are possible.
                let solid = Box::new(frame(step, stage, velocity(2 * step + k)));
                queue.send(Record::Frame(Role::Solid, solid)).await.ok().unwrap();
                queue.send(Record::Frame(Role::Fluid, Box::new(frame(step, stage, 1.0)))).await.ok().unwrap();
            }
        }
        assert_eq!(writer.finish().await, Ok(8));
    });
}

fn bench() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames");
    (folder, path)
}

#[test]
fn what_was_written_is_read_bit_for_bit() {
    let (_folder, path) = bench();
    record(&path, |half| if half == 2 { -0.0 } else { 5e-324 });
    let mut recording = Recording::open(&path).unwrap();
    assert_eq!(recording.attempts(), [attempt(0, 0)]);
    assert!(recording.is_complete());
    let at = first_of(StepStage { step: 1, stage: Stage::Predictor });
    assert_eq!(recording.moments(Role::Solid).len(), 4);
    assert_eq!(recording.frame(at, Role::Solid).unwrap(), Some(frame(1, Stage::Predictor, -0.0)));
    let beyond = first_of(StepStage { step: 2, stage: Stage::Predictor });
    assert_eq!(recording.frame(beyond, Role::Solid).unwrap(), None);
    let again = RecordingWriter::create(&path).unwrap_err().to_string();
    assert!(again.contains("exists already") && again.contains("frames"), "{again}");
}

#[test]
fn the_first_difference_is_named_to_the_last_bit() {
    let (folder, path) = bench();
    record(&path, |_| 0.0);
    let open = |path: &Path| Recording::open(path).unwrap();
    let same = compare(&mut open(&path), &mut open(&path)).unwrap();
    assert_eq!((same.equal_half_steps, same.difference, same.alone), (4, None, None));
    let other = folder.path().join("other");
    // The smallest number there is, and later a large one.
    record(&other, |half| [0.0, 0.0, 5e-324, 8.0][usize::try_from(half).unwrap()]);
    let found = compare(&mut open(&path), &mut open(&other)).unwrap();
    assert_eq!(found.equal_half_steps, 2);
    let difference = found.difference.unwrap();
    assert_eq!(difference.at.at, StepStage { step: 1, stage: Stage::Predictor });
    assert_eq!((difference.side, difference.place), (Role::Solid, Some((1, Some(7)))));
    assert_eq!(difference.field, "component 1 of velocity [m/s]");
    assert_eq!(difference.values, ["0.0", "5e-324"]);
}

#[test]
fn a_later_attempt_replaces_the_frames_of_a_lost_one() {
    let (_folder, path) = bench();
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    runtime.block_on(async {
        let writer = RecordingWriter::create(&path).unwrap();
        for (epoch, velocity) in [(0, 1.0), (1, 2.0)] {
            writer.attempt(attempt(epoch, 0)).await;
            let solid = Box::new(frame(0, Stage::Predictor, velocity));
            writer.queue().send(Record::Frame(Role::Solid, solid)).await.ok().unwrap();
        }
        writer.finish().await.unwrap();
    });
    let mut recording = Recording::open(&path).unwrap();
    assert_eq!(recording.attempts().len(), 2);
    let kept = recording.frame(first_of(StepStage::FIRST), Role::Solid).unwrap();
    assert_eq!(kept, Some(frame(0, Stage::Predictor, 2.0)));
}

#[test]
fn a_recording_that_was_cut_off_keeps_what_it_has() {
    let (_folder, path) = bench();
    record(&path, |_| 0.0);
    let bytes = std::fs::read(&path).unwrap();
    // The end record has nine bytes; the cut goes into the last frame.
    std::fs::write(&path, &bytes[..bytes.len() - 15]).unwrap();
    let recording = Recording::open(&path).unwrap();
    assert!(!recording.is_complete());
    assert_eq!(recording.moments(Role::Fluid).len(), 3);
    assert_eq!(recording.moments(Role::Solid).len(), 4);
}

#[test]
fn what_is_no_sound_recording_is_refused_with_the_place() {
    let (_folder, path) = bench();
    record(&path, |_| 0.0);
    let bytes = std::fs::read(&path).unwrap();
    let refused = |change: &dyn Fn(&mut Vec<u8>), words: &[&str]| {
        let mut bytes = bytes.clone();
        change(&mut bytes);
        std::fs::File::create(&path).unwrap().write_all(&bytes).unwrap();
        let error = Recording::open(&path).unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word), "no {word:?} in {error}");
        }
    };
    refused(&|bytes| bytes[0] = b'X', &["is no recording", "--record"]);
    refused(&|bytes| bytes.truncate(5), &["is no recording"]);
    refused(&|bytes| bytes[6] = 1, &["version 1", "reads version 2"]);
    refused(&|bytes| bytes[8] = 77, &["damaged at byte 8", "kind of record 77"]);
    // A length that no memory should be set aside for.
    refused(&|bytes| bytes[9..13].fill(255), &["damaged at byte 8", "4294967295 bytes", "67108864"]);
    refused(&|bytes| bytes[20] ^= 1, &["damaged at byte 8", "checksum"]);
    refused(&|bytes| bytes.truncate(8), &["holds no run"]);
}

/// Records a corrector of two iterations and its acceptance with this residual.
fn record_implicit(path: &Path, residual: f64) {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    runtime.block_on(async {
        let writer = RecordingWriter::create(path).unwrap();
        writer.attempt(attempt(0, 0)).await;
        let word = wire::Acceptance { converged: true, residual: Some(residual) };
        for iteration in 0..2 {
            for role in [Role::Fluid, Role::Solid] {
                let frame = wire::Frame { iteration, ..frame(0, Stage::Corrector, f64::from(iteration)) };
                writer.queue().send(Record::Frame(role, Box::new(frame))).await.ok().unwrap();
            }
        }
        let accepts = wire::Frame {
            iteration: 1,
            acceptance: Some(word),
            blocks: Vec::new(),
            ..frame(0, Stage::Corrector, 0.0)
        };
        writer.queue().send(Record::Frame(Role::Solid, Box::new(accepts))).await.ok().unwrap();
        writer.finish().await.unwrap();
    });
}

#[test]
fn iterations_are_kept_apart_and_compared_each() {
    let (folder, path) = bench();
    record_implicit(&path, 1e-7);
    let mut recording = Recording::open(&path).unwrap();
    let moments: Vec<String> = recording.moments(Role::Solid).iter().map(Moment::to_string).collect();
    let expected =
        ["step 0 corrector", "step 0 corrector, iteration 1", "step 0 corrector, acceptance of iteration 1"];
    assert_eq!(moments, expected);
    let second = recording.moments(Role::Fluid)[1];
    let kept = recording.frame(second, Role::Fluid).unwrap().unwrap();
    assert_eq!(kept.blocks, frame(0, Stage::Corrector, 1.0).blocks);
    let open = || Recording::open(&path).unwrap();
    let same = compare(&mut open(), &mut open()).unwrap();
    assert_eq!((same.equal_half_steps, same.difference, same.alone), (1, None, None));
    let other = folder.path().join("other");
    record_implicit(&other, 2e-7);
    let found = compare(&mut open(), &mut Recording::open(&other).unwrap()).unwrap();
    assert_eq!(found.equal_half_steps, 0);
    let text = found.difference.unwrap().to_string();
    assert!(text.contains("acceptance of iteration 1, frame of the solid: residual"), "{text}");
}
