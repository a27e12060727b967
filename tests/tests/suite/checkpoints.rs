//! Checkpoints, resumed runs, and servers that die or freeze, through real processes.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{PROGRAM, bench};
use tests::bench::{Bench, children_of, digests, kept, soon, text, wait_for_checkpoint};
use tests::kill::{MOMENTS, Tally, Trials, same_results, server_of};
use tests::nodes::Node;
use tests::random::RandomNumbers;

/// Resumes the run in `name`, which must succeed.
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
fn checkpoints_change_nothing_and_the_last_two_are_kept() {
    for substeps in [None, Some(4)] {
        let bench = bench();
        let case = bench.tank_to(0.004, substeps);
        let plain = bench.run(&case, "plain", &[]);
        let many = bench.run(&case, "many", &["--checkpoint-every-steps", "7"]);
        assert_eq!(digests(&plain), digests(&many));
        same_results(&bench.path("plain"), &bench.path("many")).unwrap();
        // Taking one must not rebuild a list: 14 in 100 steps would show.
        for side in ["fluid", "solid"] {
            assert_eq!(plain[side]["counts"], many[side]["counts"], "{side}");
        }
        // Multiples of 7 up to 98, and the end.
        assert_eq!(many["checkpoints"]["taken"], 15);
        assert_eq!(plain["checkpoints"]["taken"], 1);
        assert!(many["checkpoints"]["largest_bytes"].as_u64().unwrap() > 1000);
        assert_eq!(kept(&bench.path("many")), ["step_000000000098", "step_000000000100"]);
    }
}

#[test]
fn a_finished_run_goes_on_to_a_later_end_with_the_bits_of_one_run() {
    for (substeps, shorter) in [(None, "0.0019"), (Some(4), "0.0021")] {
        let bench = bench();
        let whole = bench.tank_to(0.004, substeps);
        bench.run(&whole, "whole", &["--threads", "2"]);
        let short = bench.tank_to(shorter.parse().unwrap(), substeps);
        // In one process first, then on servers with other numbers of threads.
        bench.run(&short, "parts", &["--in-process", "--threads", "1"]);
        resume(&bench, "parts", &["--until", "0.003", "--threads", "2"]);
        resume(&bench, "parts", &["--until", "0.004", "--threads", "1"]);
        same_results(&bench.path("whole"), &bench.path("parts")).unwrap();
        assert_eq!(bench.summary("parts")["verdict"], "completed");
    }
}

#[test]
fn a_stopped_run_goes_on_as_if_it_had_never_been_stopped() {
    let bench = bench();
    let case = bench.tank_to(0.1, None);
    bench.run(&case, "whole", &[]);
    let mut run = bench.start(&case, "stopped");
    run.signal("TERM");
    let (status, message) = run.end();
    assert_eq!(status.code(), Some(8), "{message}");
    assert!(message.contains("tidelock resume"), "{message}");
    run.servers_end();
    let steps = bench.summary("stopped")["steps"].as_u64().unwrap();
    assert!(steps < 2500, "the run was over before the signal");
    assert_eq!(kept(&bench.path("stopped")).last().unwrap(), &format!("step_{steps:012}"));
    resume(&bench, "stopped", &[]);
    same_results(&bench.path("whole"), &bench.path("stopped")).unwrap();
    assert_eq!(bench.summary("stopped")["checkpoints"]["resumed_from"], steps);
}

#[test]
fn another_case_and_a_damaged_checkpoint_are_reported() {
    let bench = bench();
    let case = bench.tank_to(0.002, None);
    bench.run(&case, "whole", &["--checkpoint-every-steps", "20"]);
    bench.run(&case, "out", &["--checkpoint-every-steps", "20"]);
    let out = bench.path("out");
    let resolved = std::fs::read_to_string(out.join("case.toml")).unwrap();
    let other = resolved.replace("sound_speed_m_s = 25.0", "sound_speed_m_s = 26.0");
    assert_ne!(other, resolved);
    std::fs::write(out.join("case.toml"), other).unwrap();
    let words = ["sound_speed_m_s = 25.0", "sound_speed_m_s = 26.0", "[fluid]"];
    bench.refused(&["resume", text(&out)], 2, &words);
    std::fs::write(out.join("case.toml"), resolved).unwrap();
    // The newest is damaged: the one before is used.
    let data = out.join("checkpoints/step_000000000050/fluid.bin");
    let mut bytes = std::fs::read(&data).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&data, bytes).unwrap();
    let said = resume(&bench, "out", &[]);
    assert!(said.contains("skipped checkpoint") && said.contains("step_000000000050"), "{said}");
    assert_eq!(bench.summary("out")["checkpoints"]["resumed_from"], 40);
    same_results(&bench.path("whole"), &out).unwrap();
    // Neither is good.
    for step in kept(&out) {
        std::fs::write(out.join("checkpoints").join(step).join("manifest.json"), "{}").unwrap();
    }
    bench.refused(&["resume", text(&out)], 2, &["holds no good checkpoint", "manifest.json"]);
}

#[test]
fn other_builds_and_arithmetic_paths_are_refused_by_name() {
    let bench = bench();
    let case = bench.tank_to(0.002, None);
    bench.run(&case, "out", &[]);
    let out = bench.path("out");
    let manifest = out.join("checkpoints/step_000000000050/manifest.json");
    let text_of = std::fs::read_to_string(&manifest).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text_of).unwrap();
    let here = json["sides"][0]["build"].as_str().unwrap().to_owned();
    for (key, value, flag_helps) in
        [("build", "another", true), ("arithmetic", "f64x8", false), ("format", "other/9", false)]
    {
        let old = json["sides"][0][key].clone();
        json["sides"][0][key] = value.into();
        std::fs::write(&manifest, coordinator::checkpoint::seal(&json.to_string()).unwrap()).unwrap();
        bench.refused(&["resume", text(&out), "--until", "0.003"], 2, &[value, "fluid"]);
        if flag_helps {
            bench.refused(&["resume", text(&out), "--until", "0.003"], 2, &[&here, "--accept-other-build"]);
        } else {
            let flagged = ["resume", text(&out), "--until", "0.003", "--accept-other-build"];
            bench.refused(&flagged, 2, &[value]);
        }
        json["sides"][0][key] = old;
    }
    json["sides"][0]["build"] = "another".into();
    std::fs::write(&manifest, coordinator::checkpoint::seal(&json.to_string()).unwrap()).unwrap();
    resume(&bench, "out", &["--until", "0.003", "--accept-other-build"]);
    assert_eq!(bench.summary("out")["steps"], 75);
}

#[test]
fn killed_servers_and_coordinators_lose_nothing() {
    let mut random = RandomNumbers::new(7);
    // Each kind of moment once.
    let times = u32::try_from(MOMENTS.len()).unwrap();
    type Write = fn(&Bench) -> PathBuf;
    let scenes: [(Write, u32); 3] = [
        (|bench| bench.tank_to(0.02, None), times),
        (|bench| bench.tank_to(0.02, Some(4)), 5),
        (|bench| bench.space_to(0.3), 3),
    ];
    for (write, times) in scenes {
        let trials = Trials::new(Path::new(PROGRAM), write);
        let mut tally = Tally::default();
        trials.run(times, "", &mut random, &mut tally);
        assert_eq!(tally.sum().equal, times, "{tally}");
    }
}

#[test]
fn a_frozen_server_is_named_within_the_deadline_and_replaced() {
    for frozen in ["solid", "fluid"] {
        let bench = bench();
        let case = bench.tank_to(0.4, None);
        let out = bench.path("out");
        let mut run = Command::new(PROGRAM)
            .args(["run", text(&case), "--quiet", "--threads", "1", "--out", text(&out)])
            .args(["--silence", "3", "--checkpoint-every-steps", "100"])
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        wait_for_checkpoint(&out);
        let server = server_of(run.id(), &format!("node-{frozen}")).unwrap();
        assert!(Command::new("kill").args(["-STOP", &server.to_string()]).status().unwrap().success());
        soon("another server", || {
            children_of(run.id()).iter().all(|child| *child != server)
                && server_of(run.id(), &format!("node-{frozen}")).is_some()
        });
        assert!(Command::new("kill").args(["-TERM", &run.id().to_string()]).status().unwrap().success());
        let status = run.wait().unwrap();
        let said = std::io::read_to_string(run.stderr.take().unwrap()).unwrap();
        assert!(said.contains(&format!("lost the {frozen} solver")), "{said}");
        assert!(said.contains("no sign of life for 3 s") && said.contains("in step"), "{said}");
        // The run may have ended by itself before the signal came.
        assert!(matches!(status.code(), Some(0 | 8)), "{said}");
    }
}

#[test]
fn a_server_that_the_run_did_not_start_is_not_replaced_and_the_remedy_is_named() {
    let bench = bench();
    let case = bench.tank_to(0.4, None);
    let out = bench.path("out");
    let start = || Node::start(Path::new(PROGRAM), "solid", &[]);
    let server = start();
    let mut run = Command::new(PROGRAM)
        .args(["run", text(&case), "--quiet", "--threads", "1", "--out", text(&out)])
        .args(["--solid", &server.address])
        .args(["--checkpoint-every-steps", "100"])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    wait_for_checkpoint(&out);
    drop(server);
    let status = run.wait().unwrap();
    let said = std::io::read_to_string(run.stderr.take().unwrap()).unwrap();
    assert_eq!(status.code(), Some(7), "{said}");
    assert!(said.contains("lost the solid solver") && said.contains("tidelock resume"), "{said}");
    // On another port it continues.
    let server = start();
    resume(&bench, "out", &["--solid", &server.address, "--until", "0.05"]);
    assert_eq!(bench.summary("out")["verdict"], "completed");
}

#[test]
fn a_coordinator_frozen_beyond_the_lease_loses_its_servers_to_others_and_says_so_when_it_wakes() {
    let bench = bench();
    let case = bench.tank_to(0.4, None);
    bench.run(&case, "whole", &["--threads", "1"]);
    let short = bench.tank("short.toml", &[]);
    let nodes = ["fluid", "solid"].map(|role| Node::start(Path::new(PROGRAM), role, &["--lease", "6"]));
    let servers = ["--fluid", &nodes[0].address, "--solid", &nodes[1].address];
    let out = bench.path("out");
    let mut run = Command::new(PROGRAM)
        .args(["run", text(&case), "--quiet", "--out", text(&out), "--checkpoint-every-steps", "100"])
        .args(servers)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let signal = |name: &str, process: u32| {
        assert!(Command::new("kill").args([name, &process.to_string()]).status().unwrap().success());
    };
    wait_for_checkpoint(&out);
    signal("-STOP", run.id());
    let frozen = std::time::Instant::now();
    bench.run_refused(&short, &servers, 4, &["busy", "held by coordinator, process"]);
    loop {
        let other = bench.path("other");
        let mut arguments = vec!["run", text(&short), "--quiet", "--force", "--out", text(&other)];
        arguments.extend(servers);
        let output = bench.call(&arguments);
        if output.status.success() {
            break;
        }
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains("busy"), "{said}");
        // The lease, and time for the run itself on a busy machine; without a lease it takes 30 s.
        assert!(frozen.elapsed() < std::time::Duration::from_secs(20), "{said}");
    }
    // Far longer than any two looks at the clock.
    soon("the time that a coordinator takes for a pause", || frozen.elapsed().as_secs() > 7);
    signal("-CONT", run.id());
    let status = run.wait().unwrap();
    let said = std::io::read_to_string(run.stderr.take().unwrap()).unwrap();
    assert_eq!(status.code(), Some(7), "{said}");
    for words in ["lost the ", "this coordinator did not run for", "tidelock resume"] {
        assert!(said.contains(words), "no {words:?} in {said}");
    }
    resume(&bench, "out", &servers);
    same_results(&bench.path("whole"), &out).unwrap();
}

#[test]
fn a_coordinator_that_was_stopped_itself_takes_no_server_for_lost() {
    let bench = bench();
    let case = bench.tank_to(0.1, None);
    bench.run(&case, "whole", &[]);
    let mut run = bench.start(&case, "out");
    run.signal("STOP");
    // Longer than servers may be silent below, shorter than they keep a coordinator that does not answer.
    std::thread::sleep(std::time::Duration::from_secs(21));
    run.signal("CONT");
    let (status, said) = run.end();
    assert_eq!(status.code(), Some(0), "{said}");
    assert!(!said.contains("lost"), "{said}");
    same_results(&bench.path("whole"), &bench.path("out")).unwrap();
}

#[test]
fn a_full_disk_ends_the_run_with_its_checkpoint_and_the_rest_follows_when_there_is_room() {
    let bench = bench();
    let case = bench.tank_to(0.02, None);
    bench.run(&case, "whole", &[]);
    let out = bench.path("out");
    // Files may grow to 40 KiB: that of the ledger reaches it in the middle of the run, no checkpoint does.
    let limited = format!(
        "ulimit -f 40; exec {PROGRAM} run {} --quiet --out {} --checkpoint-every-steps 50",
        text(&case),
        text(&out)
    );
    let output = Command::new("bash").args(["-c", &limited]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("ledger.csv") && said.contains("ulimit -f"), "{said}");
    assert!(said.contains("tidelock resume"), "{said}");
    assert!(!kept(&out).is_empty());
    resume(&bench, "out", &[]);
    assert!(bench.summary("out")["checkpoints"]["resumed_from"].as_u64().unwrap() > 0);
    same_results(&bench.path("whole"), &out).unwrap();
}

#[test]
fn a_run_that_breaks_down_keeps_its_checkpoint_and_shows_the_offending_particle() {
    let bench = bench();
    // A push after 1 ms, at step 25, that no step can follow.
    let broken = ("name = \"block\"", "name = \"block\"\nacceleration_m_s2 = [\"step(t - 0.001)*1e9\", 0]");
    let case = bench.tank("case.toml", &[broken]);
    let out = bench.path("out");
    let arguments = ["run", text(&case), "--quiet", "--out", text(&out), "--checkpoint-every-steps", "10"];
    bench.refused(&arguments, 5, &["diverged at step", "particle"]);
    assert_eq!(kept(&out).last().unwrap(), "step_000000000020");
    let table = std::fs::read_to_string(out.join("divergence.csv")).unwrap();
    assert!(table.starts_with("id,group,distance_m,position_0_m"), "{table:.100}");
    assert!(table.lines().count() > 10);
}

#[test]
fn a_broken_balance_may_stop_the_run_with_a_checkpoint() {
    let bench = bench();
    let end = "end_time_s = 0.002";
    let case = bench.tank(
        "case.toml",
        &[("[interface]", "[ledger]\naction = \"stop-and-checkpoint\"\n\n[interface]"), (end, end)],
    );
    let served = tests::doubles::serve(tests::doubles::Double(tests::doubles::Wrong::Skewed(
        sph::coupling::stage::StepStage { step: 20, stage: sph::coupling::stage::Stage::Corrector },
    )));
    let out = bench.path("out");
    let address = served.address.to_string();
    let arguments = ["run", text(&case), "--quiet", "--out", text(&out), "--solid", &address];
    bench.refused(&arguments, 6, &["step 20 corrector", "tidelock resume"]);
    // Reported with the next step's first frame, stopped at its end.
    assert_eq!(kept(&out).last().unwrap(), "step_000000000022");
    assert_eq!(bench.summary("out")["steps"], 22);
}
