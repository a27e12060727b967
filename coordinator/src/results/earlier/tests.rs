//! What `--force` removes, and what it leaves.

use std::os::unix::fs::symlink;

use super::*;
use crate::results::directory::{Existing, OutputDirectory};

const OLD: [&str; 14] = [
    "summary.json",
    "probes.csv.partial",
    "report.html",
    "snapshots/fluid_000001.vtp",
    "snapshots/solid.pvd.partial",
    "final/solid.state",
    "checkpoints/step_000000000040/manifest.json",
    "checkpoints/step_000000000040/fluid.bin",
    "checkpoints/step_000000000060.partial/coordinator.bin",
    "checkpoints/picture_fluid_40.state",
    "checkpoints/picture_solid_0.state.partial",
    "checkpoints/start_solid.state",
    "logs/fluid-server.log",
    "logs/solid-server-2.log",
];

fn put(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

/// Results of a killed run.
fn results() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    drop(OutputDirectory::create(root.path(), Existing::Refuse).unwrap());
    for name in OLD {
        put(&root.path().join(name), "x");
    }
    root
}

/// All files under `root`, with their content.
fn content(root: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(content(&path));
        } else {
            found.push((path.clone(), fs::read_to_string(&path).unwrap_or_default()));
        }
    }
    found.sort();
    found
}

#[test]
fn replacing_removes_what_a_run_wrote_and_nothing_else() {
    let mine = [
        "notes.txt",
        "snapshots/fluid_mean.vtp",
        "snapshots/solid_.vtp",
        "final/other.state",
        "checkpoints/model.pt",
        "checkpoints/step_40/manifest.json",
        "checkpoints/picture_fluid.state",
        "logs/other.log",
    ];
    let root = results();
    for name in mine {
        put(&root.path().join(name), "mine");
    }
    OutputDirectory::create(root.path(), Existing::Replace).unwrap().begin().unwrap();
    let mut left: Vec<PathBuf> = content(root.path()).into_iter().map(|(path, _)| path).collect();
    left.retain(|path| !path.ends_with(MARKER));
    let mut expected: Vec<PathBuf> = mine.iter().map(|name| root.path().join(name)).collect();
    expected.sort();
    assert_eq!(left, expected);
    // Nothing of anybody else: the folders go.
    let root = results();
    OutputDirectory::create(root.path(), Existing::Replace).unwrap().begin().unwrap();
    assert!(!root.path().join(CHECKPOINTS).exists() && !root.path().join(LOGS).exists());
}

#[test]
fn results_stay_until_the_next_run_begins() {
    let root = results();
    let before = content(root.path());
    drop(OutputDirectory::create(root.path(), Existing::Replace).unwrap());
    let is_log = |path: &Path| path.starts_with(root.path().join(LOGS));
    let kept: Vec<_> = before.into_iter().filter(|(path, _)| !is_log(path)).collect();
    assert_eq!(content(root.path()), kept);
}

#[test]
fn what_only_has_the_name_of_a_run_s_file_is_refused_and_left() {
    for (name, hint) in [
        ("checkpoints/step_000000000040/model.pt", "no run wrote"),
        ("checkpoints/step_000000000060.partial/fluid.bin/x", "is no file"),
        ("ledger.csv/x", "is no file"),
        ("snapshots/solid_000001.vtp/x", "is no file"),
    ] {
        let root = results();
        put(&root.path().join(name), "mine");
        let before = content(root.path());
        let message = OutputDirectory::create(root.path(), Existing::Replace).unwrap_err().to_string();
        assert!(message.contains(hint) && message.contains("move it elsewhere"), "{message}");
        assert_eq!(content(root.path()), before);
    }
}

#[test]
fn links_are_removed_or_refused_but_never_followed() {
    let elsewhere = tempfile::tempdir().unwrap();
    let theirs = elsewhere.path().join("step_000000000010");
    put(&theirs.join("manifest.json"), "theirs");
    put(&elsewhere.path().join("fluid_000001.vtp"), "theirs");
    let before = content(elsewhere.path());
    // A link in the place of a file or a checkpoint goes, its target stays.
    let root = results();
    symlink(&theirs, root.path().join("checkpoints/step_000000000010.partial")).unwrap();
    symlink(theirs.join("manifest.json"), root.path().join("report.html.partial")).unwrap();
    OutputDirectory::create(root.path(), Existing::Replace).unwrap().begin().unwrap();
    assert!(!root.path().join(CHECKPOINTS).exists());
    assert!(!root.path().join("report.html.partial").is_symlink());
    // One in the place of a folder is refused.
    for name in [SNAPSHOTS, CHECKPOINTS, FINAL, LOGS] {
        let root = results();
        fs::remove_dir_all(root.path().join(name)).unwrap();
        symlink(elsewhere.path(), root.path().join(name)).unwrap();
        let message = OutputDirectory::create(root.path(), Existing::Replace).unwrap_err().to_string();
        assert!(message.contains("is no folder") && message.contains(name), "{message}");
    }
    assert_eq!(content(elsewhere.path()), before);
}

#[test]
fn only_a_summary_of_a_run_marks_its_folder() {
    let root = tempfile::tempdir().unwrap();
    let summary = root.path().join(SUMMARY);
    let digest = "0".repeat(64);
    let of_a_run = format!(
        "{{\"format\": 1, \"run_id\": \"a\", \"verdict\": \"stopped\", \"steps\": 3, \"case_digest\": \"{digest}\"}}"
    );
    for (text, marks) in [
        (of_a_run.as_str(), true),
        (&of_a_run.replace("stopped", "fine"), false),
        (&of_a_run.replace("run_id", "id"), false),
        (&of_a_run.replace(&digest, "0"), false),
        ("{}", false),
        ("", false),
    ] {
        put(&summary, text);
        assert_eq!(carries_mark(root.path()), marks, "{text}");
    }
    fs::remove_file(&summary).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(&summary).status().unwrap().success());
    assert!(!carries_mark(root.path()));
}
