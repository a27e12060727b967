//! Results of earlier runs, through real processes: what is replaced, what a refusal leaves, what is found when a run is
//! resumed.

use std::collections::BTreeMap;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use crate::bench;
use tests::bench::{Bench, text};
use tests::kill::{same_files, same_results};

/// Every file below `root`, logs apart, with its content.
fn content(root: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(root).unwrap() {
        let path = entry.unwrap().path();
        if path.is_symlink() || path.is_file() {
            found.insert(path.clone(), std::fs::read(&path).unwrap_or_default());
        } else if !path.ends_with("logs") {
            found.extend(content(&path));
        }
    }
    found
}

/// Calls the program, which must fail with `code` and a message that holds every one of `words`, and leave `out` as it is.
fn refused_unchanged(bench: &Bench, out: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let before = content(out);
    bench.refused(arguments, code, words);
    let after = content(out);
    let names = |of: &BTreeMap<PathBuf, Vec<u8>>| of.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&before), names(&after), "{arguments:?}");
    assert!(before == after, "{arguments:?} changed a file");
}

/// Replaces `from` by `to` in the file at `path`.
fn change(path: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "no {from:?} in {}", path.display());
    std::fs::write(path, text.replacen(from, to, 1)).unwrap();
}

/// Resumes the run in `name`, which must succeed; what was said.
fn resume(bench: &Bench, name: &str, further: &[&str]) -> String {
    let out = bench.path(name);
    let mut arguments = vec!["resume", text(&out), "--quiet"];
    arguments.extend(further);
    let output = bench.call(&arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    said
}

#[test]
fn force_replaces_results_of_a_run_and_refuses_all_else() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let out = bench.path("out");
    let force = ["run", text(&case), "--quiet", "--force", "--out", text(&out)];
    std::fs::create_dir_all(out.join("checkpoints")).unwrap();
    std::fs::write(out.join("checkpoints/model.pt"), "mine").unwrap();
    let words = ["no results of a run", "so nothing was changed", "--out"];
    refused_unchanged(&bench, &out, &force, 3, &words);
    std::fs::write(out.join("summary.json"), "{\"loss\": 0.1}").unwrap();
    refused_unchanged(&bench, &out, &force, 3, &words);
    std::fs::remove_dir_all(&out).unwrap();
    // In results of a run it replaces these and leaves the rest.
    bench.run(&case, "out", &[]);
    bench.run(&case, "whole", &[]);
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    std::fs::write(out.join("checkpoints/model.pt"), "mine").unwrap();
    assert!(bench.call(&force).status.success());
    for mine in ["notes.txt", "checkpoints/model.pt"] {
        assert_eq!(std::fs::read_to_string(out.join(mine)).unwrap(), "mine");
        std::fs::remove_file(out.join(mine)).unwrap();
    }
    same_results(&bench.path("whole"), &out).unwrap();
    same_files(&bench.path("whole"), &out).unwrap();
    // Another program's file in the folder of a checkpoint.
    let theirs = out.join("checkpoints/step_000000000050/model.pt");
    std::fs::write(theirs, "mine").unwrap();
    refused_unchanged(&bench, &out, &force, 3, &["model.pt", "no run wrote", "move it elsewhere"]);
}

#[test]
fn a_refused_resume_changes_nothing() {
    let bench = bench();
    let case = bench.tank_to(0.002, None);
    bench.run(&case, "out", &["--checkpoint-every-steps", "20"]);
    let out = bench.path("out");
    let good = std::fs::read(out.join("case.toml")).unwrap();
    let resume = ["resume", text(&out), "--until", "0.003"];
    let with = |further: &[&'static str]| -> Vec<&str> {
        resume.iter().copied().chain(further.iter().copied()).collect()
    };
    // The case was changed.
    change(&out.join("case.toml"), "sound_speed_m_s = 25.0", "sound_speed_m_s = 26.0");
    for way in [&[][..], &["--in-process"]] {
        refused_unchanged(&bench, &out, &with(way), 2, &["sound_speed_m_s = 26.0"]);
    }
    std::fs::write(out.join("case.toml"), good).unwrap();
    // A server is away.
    refused_unchanged(&bench, &out, &with(&["--solid", "127.0.0.1:1"]), 4, &["127.0.0.1:1"]);
    // A solver refuses the state.
    let newest = out.join("checkpoints/step_000000000050");
    let manifest = std::fs::read_to_string(newest.join("manifest.json")).unwrap();
    let data = std::fs::read(newest.join("solid.bin")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let junk = b"junk".repeat(100);
    json["sides"][1]["data"]["bytes"] = junk.len().into();
    let digest = proto::checkpoint::digest(&junk);
    json["sides"][1]["data"]["sha256"] = proto::hex::hex(&digest).into();
    let sealed = coordinator::checkpoint::seal(&json.to_string()).unwrap();
    std::fs::write(newest.join("solid.bin"), &junk).unwrap();
    std::fs::write(newest.join("manifest.json"), sealed).unwrap();
    for way in [&[][..], &["--in-process"]] {
        let before = content(&out);
        let output = bench.call(&with(way));
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(matches!(output.status.code(), Some(2 | 4)), "{said}");
        // The same command would be refused again.
        assert!(!said.contains("continue from the last checkpoint"), "{said}");
        assert!(before == content(&out), "{way:?} changed the results: {said}");
    }
    std::fs::write(newest.join("solid.bin"), data).unwrap();
    std::fs::write(newest.join("manifest.json"), manifest).unwrap();
    // No case file, no good checkpoint, a damaged table.
    std::fs::rename(out.join("case.toml"), bench.path("kept")).unwrap();
    refused_unchanged(&bench, &out, &resume, 2, &["no such file"]);
    std::fs::rename(bench.path("kept"), out.join("case.toml")).unwrap();
    change(&out.join("probes.csv"), "t_s", "t_m");
    refused_unchanged(&bench, &out, &resume, 3, &["probes.csv", "line 1"]);
    change(&out.join("probes.csv"), "t_m", "t_s");
    assert!(bench.call(&resume).status.success());
    let whole = bench.tank_to(0.003, None);
    bench.run(&whole, "whole", &[]);
    same_results(&bench.path("whole"), &out).unwrap();
}

#[test]
fn a_start_from_the_folder_that_is_written_is_refused_by_any_name() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    bench.run(&case, "earlier", &[]);
    let out = bench.path("earlier");
    symlink(&out, bench.path("link")).unwrap();
    // A folder of links to the states.
    std::fs::create_dir_all(bench.path("linked/final")).unwrap();
    for side in ["fluid", "solid"] {
        let name = format!("final/{side}.state");
        symlink(out.join(&name), bench.path("linked").join(name)).unwrap();
    }
    for spelling in ["earlier", "link", "./linked/../earlier/", "linked"] {
        let tank = std::fs::read_to_string(&case).unwrap();
        let next = bench.write("next.toml", &format!("start_from = \"{spelling}\"\n{tank}"));
        for written in [out.clone(), bench.path("link")] {
            let force = ["run", text(&next), "--quiet", "--force", "--out", text(&written)];
            refused_unchanged(&bench, &out, &force, 2, &["start_from", "output folder", "--out"]);
        }
    }
}

#[test]
fn a_run_that_started_from_another_is_resumed_without_it() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    bench.run(&case, "earlier", &[]);
    let tank = std::fs::read_to_string(&case).unwrap();
    let longer = tank.replace("end_time_s = 0.002", "end_time_s = 0.004");
    let start = "start_from = \"earlier\"\n";
    let whole = bench.write("whole.toml", &format!("{start}{longer}"));
    let short = bench.write("short.toml", &format!("{start}{tank}"));
    bench.run(&whole, "whole", &[]);
    bench.run(&short, "out", &[]);
    std::fs::remove_dir_all(bench.path("earlier")).unwrap();
    let out = bench.path("out");
    let until = ["--until", "0.004"];
    // The copies are those of the checkpoint, or nothing is done.
    let kept = out.join("checkpoints/start_fluid.state");
    let good = std::fs::read(&kept).unwrap();
    let resume_it = ["resume", text(&out), "--until", "0.004"];
    std::fs::write(&kept, std::fs::read(out.join("final/fluid.state")).unwrap()).unwrap();
    refused_unchanged(
        &bench,
        &out,
        &resume_it,
        2,
        &["start_fluid.state", "another state", "put the file back"],
    );
    std::fs::remove_file(&kept).unwrap();
    refused_unchanged(&bench, &out, &resume_it, 2, &["start_fluid.state", "put the file back"]);
    std::fs::write(&kept, good).unwrap();
    resume(&bench, "out", &until);
    same_results(&bench.path("whole"), &out).unwrap();
}

#[test]
fn a_lost_picture_costs_a_warning() {
    let bench = bench();
    let wanted = "probe_interval_s = 0.0004\npicture_times_s = [0.0, 0.001]";
    let pictures = ("probe_interval_s = 0.0004", wanted);
    let case = bench.tank("case.toml", &[pictures]);
    bench.run(&case, "out", &["--checkpoint-every-steps", "20"]);
    let longer = bench.tank("longer.toml", &[pictures, ("end_time_s = 0.002", "end_time_s = 0.003")]);
    bench.run(&longer, "whole", &[]);
    let out = bench.path("out");
    let pictures = || -> Vec<PathBuf> {
        let entries = std::fs::read_dir(out.join("checkpoints")).unwrap().flatten().map(|entry| entry.path());
        let mut found: Vec<PathBuf> =
            entries.filter(|path| path.extension().is_some_and(|e| e == "state")).collect();
        found.sort();
        found
    };
    let stored = pictures();
    assert_eq!(stored.len(), 4, "{stored:?}");
    std::fs::remove_file(&stored[0]).unwrap();
    std::fs::write(&stored[3], "damaged").unwrap();
    let said = resume(&bench, "out", &["--until", "0.003"]);
    for path in [&stored[0], &stored[3]] {
        assert!(said.contains("warning") && said.contains(text(path)), "{said}");
    }
    let warnings = bench.summary("out")["warnings"].to_string();
    assert!(warnings.contains("lacks its picture"), "{warnings}");
    same_results(&bench.path("whole"), &out).unwrap();
}

#[test]
fn changed_rows_and_missing_snapshots_are_found_and_may_be_accepted() {
    let bench = bench();
    let case = bench.tank_to(0.002, None);
    bench.run(&case, "out", &["--checkpoint-every-steps", "20"]);
    let out = bench.path("out");
    let until = ["--until", "0.003"];
    let command: Vec<&str> = ["resume", text(&out)].into_iter().chain(until).collect();
    for (table, file) in [("probes.csv", "line"), ("ledger.csv", "line")] {
        let path = out.join(table);
        let good = std::fs::read_to_string(&path).unwrap();
        // One digit of the second row, at the same length.
        let start = good.lines().take(2).map(|line| line.len() + 1).sum::<usize>();
        let digit = start + good[start..].find(['1', '2', '3']).unwrap();
        let mut bad = good.clone().into_bytes();
        bad[digit] += 1;
        std::fs::write(&path, &bad).unwrap();
        let words = [table, file, "--accept-changed-outputs", "run --force", "put it back"];
        refused_unchanged(&bench, &out, &command, 3, &words);
        std::fs::write(&path, good).unwrap();
    }
    let snapshot = out.join("snapshots/fluid_00000000.vtp");
    let kept = std::fs::read(&snapshot).unwrap();
    std::fs::remove_file(&snapshot).unwrap();
    refused_unchanged(&bench, &out, &command, 3, &["fluid_00000000.vtp", "--accept-changed-outputs"]);
    // A changed number and a missing snapshot are accepted, and said.
    let probes = out.join("probes.csv");
    let rows = std::fs::read_to_string(&probes).unwrap();
    let second = rows.lines().nth(2).unwrap().to_owned();
    let other_digit = if second.ends_with('7') { '3' } else { '7' };
    let changed = format!("{}{other_digit}", &second[..second.len() - 1]);
    change(&probes, &second, &changed);
    let accept: Vec<&str> = until.into_iter().chain(["--accept-changed-outputs"]).collect();
    let said = resume(&bench, "out", &accept);
    assert!(said.contains("probes.csv") && said.contains("fluid_00000000.vtp"), "{said}");
    let warnings = bench.summary("out")["warnings"].to_string();
    assert!(warnings.contains("probes.csv") && warnings.contains("fluid_00000000.vtp"), "{warnings}");
    assert!(std::fs::read_to_string(&probes).unwrap().contains(&changed));
    // All else is that of one run; the warning stays with the results.
    let whole = bench.tank_to(0.003, None);
    bench.run(&whole, "whole", &[]);
    std::fs::write(&snapshot, kept).unwrap();
    change(&probes, &changed, &second);
    // The collections do not name the snapshot that was missing.
    for collection in ["fluid.pvd", "all.pvd"] {
        let whole = bench.path("whole/snapshots").join(collection);
        std::fs::copy(whole, out.join("snapshots").join(collection)).unwrap();
    }
    same_results(&bench.path("whole"), &out).unwrap();
}

#[test]
fn half_written_remains_of_a_killed_run_are_removed() {
    let bench = bench();
    let case = bench.tank_to(0.002, None);
    bench.run(&case, "out", &["--checkpoint-every-steps", "20"]);
    let out = bench.path("out");
    let before = content(&out);
    let checkpoints = out.join("checkpoints");
    for step in ["step_000000000050.partial", "step_000000000060.partial"] {
        std::fs::create_dir(checkpoints.join(step)).unwrap();
        std::fs::write(checkpoints.join(step).join("fluid.bin"), "half").unwrap();
    }
    for file in ["picture_fluid_33.state", "picture_solid_33.state.partial"] {
        std::fs::write(checkpoints.join(file), "half").unwrap();
    }
    resume(&bench, "out", &[]);
    let names = |of: BTreeMap<PathBuf, Vec<u8>>| of.into_keys().collect::<Vec<_>>();
    assert_eq!(names(content(&out)), names(before));
}
