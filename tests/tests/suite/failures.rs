//! What can go wrong outside the physics: each failure has its exit code, and words that name place, value, what is
//! allowed and what to do.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::{PROGRAM, bench};
use proto::description::ProtocolVersion;
use proto::testing::proxy::{Damage, Proxy};
use sph::coupling::stage::{Stage, StepStage};
use tests::bench::{Bench, digests, kept, text};
use tests::doubles::{Double, Wrong, serve};
use tests::nodes::Node;

#[test]
fn a_taken_port_is_named() {
    let holder = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = holder.local_addr().unwrap().to_string();
    for role in ["node-fluid", "node-solid"] {
        bench().refused(&[role, "--listen", &address], 3, &[&address, "in use", "choose another port"]);
    }
}

/// Listens, answers each connection with `answer` and keeps it open until the partner closes it.
fn listener(answer: &'static [u8]) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    // Ends with the test's process: a listener that waits is not closed.
    std::thread::spawn(move || {
        for connection in listener.incoming() {
            let mut connection = connection.unwrap();
            // The other side may be gone already.
            drop(connection.write_all(answer));
            if answer.is_empty() {
                drop(connection.read_to_end(&mut Vec::new()));
            }
        }
    });
    address
}

#[test]
fn something_that_is_no_solver_is_recognised() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    for answer in
        [&b""[..], b"SSH-2.0-OpenSSH_9.6\r\n", b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n"]
    {
        let address = listener(answer);
        bench.run_refused(&case, &["--solid", &address], 4, &[&address, "no solver", "--solid"]);
    }
}

#[test]
fn a_fluid_in_processes_needs_the_program_beside_this_one() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let alone = bench.path("alone");
    std::fs::copy(PROGRAM, &alone).unwrap();
    let words = [
        "fluid-server-mpi",
        "cargo build --release -p fluid-server-mpi --features mpi",
        "beside this program",
    ];
    Bench::new(text(&alone)).run_refused(&case, &["--fluid-ranks", "2"], 2, &words);
}

#[test]
fn a_server_with_another_version_is_refused() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let server = serve(Double(Wrong::Protocol(ProtocolVersion { major: 2, minor: 1 })));
    let address = server.address.to_string();
    let words = [&address, "protocol 2.1", "this coordinator 2.0", "use releases that share one"];
    bench.run_refused(&case, &["--solid", &address], 4, &words);
}

#[test]
fn a_server_with_other_constants_is_refused_with_both_values() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let server = serve(Double(Wrong::SoundSpeed(20.0)));
    let address = server.address.to_string();
    let words = ["sound_speed_m_s: 25 at the fluid, 20 at the solid"];
    bench.run_refused(&case, &["--solid", &address], 4, &words);
    // The refused run is closed: the server is free for the next one.
    bench.run_refused(&case, &["--solid", &address], 4, &words);
}

#[test]
fn a_server_of_the_other_role_is_refused() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let server = serve(solid_server::SolidFactory);
    let address = server.address.to_string();
    bench.run_refused(&case, &["--fluid", &address], 4, &[&address, "plays solid", "needed is fluid"]);
}

#[test]
fn stale_data_in_a_server_stop_the_run_at_that_half_step() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let server = serve(Double(Wrong::Stale(StepStage { step: 20, stage: Stage::Corrector })));
    let address = server.address.to_string();
    let out = bench.path("out");
    bench.refused(
        &["run", text(&case), "--quiet", "--out", text(&out), "--solid", &address],
        6,
        &["step 20", "corrector", "stale"],
    );
    let summary = bench.summary("out");
    assert_eq!(summary["verdict"], "failed");
    assert!(summary["reason"].as_str().unwrap().contains("stale"), "{}", summary["reason"]);
    assert!(!out.join("run.partial").exists(), "a diagnosed failure is complete");
}

#[test]
fn a_step_above_the_limit_is_refused() {
    let bench = bench();
    let case = bench.tank("case.toml", &[("time_step_s = 4e-5", "time_step_s = 4e-4")]);
    // A = 1: h/c_L = 1.3 · 10 mm / 152.83 m/s, the stiffest part.
    bench.case_refused(&case, &["case.toml:12", "0.0004", "at most 8.5061e-5 s", "elastic", "limit_factor"]);
}

#[test]
fn errors_of_the_scene_are_refused() {
    let bench = bench();
    let block = "lower_m = [0.04, 0.05], upper_m = [0.08, 0.09]";
    let plate = "lower_m = [0.14, -0.03], upper_m = [0.16, 0.06]";
    let cases = [
        (
            block,
            "lower_m = [0.12, 0.02], upper_m = [0.16, 0.06]",
            &["overlaps the body `block`", "plate"][..],
        ),
        (
            block,
            "lower_m = [0.19, 0.05], upper_m = [0.23, 0.09]",
            &["body `block` leaves the domain", "x from 0 to 0.2"],
        ),
        (
            plate,
            "lower_m = [0.10, -0.03], upper_m = [0.12, 0.06]",
            &["support `clamp` holds no particle of `plate`"],
        ),
        (
            "at_m = [0.1, 0.05]",
            "at_m = [0.1, 0.5]",
            &["probe[1].at_m", "outside the domain", "y from 0 to 0.2"],
        ),
    ];
    for (from, to, words) in cases {
        let case = bench.tank("case.toml", &[(from, to)]);
        bench.case_refused(&case, words);
        bench.case_refused(&case, &["case.toml:"]);
    }
}

#[test]
fn a_missing_case_is_named() {
    let bench = bench();
    bench.case_refused(
        &bench.path("no_such_case.toml"),
        &["no_such_case.toml", "give the path of a case file"],
    );
}

#[test]
fn an_output_folder_that_cannot_be_is_named() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    bench.write("file", "not a folder");
    // Not even a privileged user makes a folder below a file.
    for (out, words) in [("file", "is a file"), ("file/results", "a part of this path is a file")] {
        let out = bench.path(out);
        bench.refused(
            &["run", text(&case), "--quiet", "--out", text(&out)],
            3,
            &[text(&out), words, "choose another folder with `--out`"],
        );
    }
}

#[test]
fn a_server_that_gives_signs_of_life_but_completes_no_step_is_found() {
    let bench = bench();
    let at = StepStage { step: 12, stage: Stage::Corrector };
    let server = serve(Double(Wrong::Delay(at, std::time::Duration::from_secs(25))));
    let address = server.address.to_string();
    // Five times the least deadline stay for the first step; a step of the tank takes some 100 µs.
    let case = bench.tank("case.toml", &[("[outputs]", "[deadlines]\nstep_s = 2.0\n[outputs]")]);
    let started = std::time::Instant::now();
    let out = bench.path("out");
    bench.refused(
        &["run", text(&case), "--quiet", "--solid", &address, "--out", text(&out)],
        7,
        &["lost the solid solver after 12 completed steps", "completed no step for", "step_s"],
    );
    // The deadline, a look each second, and time for the fluid and the report to end; far below the delay.
    assert!(started.elapsed() < std::time::Duration::from_secs(15), "{:?}", started.elapsed());
}

/// Half-step at which frames are damaged.
const DAMAGED: StepStage = StepStage { step: 20, stage: Stage::Corrector };

#[test]
fn frames_damaged_on_the_way_end_the_run_by_name_or_cost_a_restart() {
    let bench = bench();
    // A step of the tank takes some 100 µs.
    let case = bench.tank("case.toml", &[("[outputs]", "[deadlines]\nstep_s = 2.0\n[outputs]")]);
    let whole = digests(&bench.run(&case, "whole", &[]));
    let solid = Node::start(Path::new(PROGRAM), "solid", &[]);
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(3).enable_all().build().unwrap();
    let (second, mut wrong) = (Duration::from_secs(1), Vec::new());
    let out = bench.path("out");
    for (damage, words) in [
        (Damage::Cut, ["exchange failed at step 2", "lost the partner"]),
        (Damage::Truncate, ["step 20 corrector", "bytes"]),
        (Damage::Duplicate, ["step 21 predictor", "expected"]),
        (Damage::Reorder, ["step 21 predictor", "expected"]),
        (Damage::Withhold, ["lost each other after 20 completed steps", "frame of step 20 corrector"]),
        // It holds back the solid's signs of life as well.
        (Damage::Delay(6 * second), ["after 20 completed steps", "the deadline by the steps before"]),
    ] {
        for to_solid in [false, true] {
            let proxy = runtime.block_on(Proxy::start(&solid.address, DAMAGED, to_solid, damage)).unwrap();
            let address = proxy.address.to_string();
            let started = Instant::now();
            let arguments =
                ["run", text(&case), "--quiet", "--force", "--out", text(&out), "--solid", &address];
            let arguments = [&arguments[..], &["--max-restarts", "0"]].concat();
            let output = bench.call(&arguments);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let ends = if to_solid { ["solid", "fluid"] } else { ["fluid", "solid"] };
            let way = format!("the {} has not got the {}'s frame", ends[0], ends[1]);
            let named = !words[0].contains("each other") || said.contains(&way);
            if output.status.code() != Some(7) || !words.iter().all(|word| said.contains(word)) || !named {
                wrong
                    .push(format!("{damage:?}, to the solid: {to_solid}: {:?} {said}", output.status.code()));
            }
            // The deadline of a step, and time for both sides and the report to end.
            assert!(started.elapsed() < 20 * second, "{damage:?}: {:?}", started.elapsed());
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    // Slow is not lost; and what was damaged once comes right when the run starts again.
    for damage in [Damage::Delay(second), Damage::Truncate] {
        let proxy = runtime.block_on(Proxy::start(&solid.address, DAMAGED, true, damage)).unwrap();
        let further = ["--force", "--solid", &proxy.address.to_string()];
        let summary = bench.run(&case, "out", &further);
        assert_eq!(digests(&summary), whole, "{damage:?}");
        let restarts = summary["restarts"].as_array().map_or(0, Vec::len);
        assert_eq!(restarts, usize::from(damage == Damage::Truncate), "{summary}");
    }
    runtime.shutdown_background();
}

/// Runs `case`, which must end with `code` and `words` in a step of `steps`; the checkpoint before must be left, and a last frame of
/// each side.
fn stops(
    bench: &Bench,
    case: &Path,
    further: &[&str],
    code: i32,
    words: &[&str],
    steps: RangeInclusive<u64>,
) {
    let out = bench.path("out");
    let run =
        ["run", text(case), "--quiet", "--force", "--out", text(&out), "--checkpoint-every-steps", "10"];
    bench.refused(&[&run[..], further].concat(), code, words);
    let summary = bench.summary("out");
    assert_eq!(summary["verdict"], "failed");
    let ended = summary["steps"].as_u64().unwrap();
    assert_eq!(kept(&out).last().unwrap(), &format!("step_{:012}", ended / 10 * 10), "{words:?}");
    assert!(steps.contains(&ended), "{words:?}: ended after {ended} steps");
    for side in ["fluid", "solid"] {
        let step = |entry: std::fs::DirEntry| {
            entry
                .file_name()
                .to_str()?
                .strip_prefix(side)?
                .strip_prefix('_')?
                .strip_suffix(".vtp")?
                .parse()
                .ok()
        };
        let last: Option<u64> =
            std::fs::read_dir(out.join("snapshots")).unwrap().flatten().filter_map(step).max();
        // Every tenth step has a frame anyway; the last one is of the step that broke.
        assert!(
            last.is_some_and(|last| steps.contains(&last)),
            "{words:?}: last frame of the {side}: {last:?}"
        );
    }
}

/// The tank with the block's `acceleration` [m/s²].
fn pushed(bench: &Bench, further: &[(&str, &str)], acceleration: &str) -> PathBuf {
    let block = format!("name = \"block\"\nacceleration_m_s2 = {acceleration}");
    bench.tank("case.toml", &[&[("name = \"block\"", block.as_str())], further].concat())
}

#[test]
fn every_way_to_break_down_stops_at_once_with_a_last_frame_and_the_last_checkpoint() {
    let bench = bench();
    let table = bench.path("out/divergence.csv");
    let offending = || std::fs::read_to_string(&table).unwrap().lines().count() > 10;
    // Root of a negative number from 1 ms on, at step 25.
    let case = pushed(&bench, &[], "[\"sqrt(0.001 - t)\", 0]");
    stops(&bench, &case, &[], 5, &["velocity [m/s] of body `block` = NaN", "particle"], 25..=26);
    assert!(offending());
    // A push that no step can follow.
    let case = pushed(&bench, &[], "[\"step(t - 0.001)*1e9\", 0]");
    stops(&bench, &case, &[], 5, &["speed [m/s] of body `block`", "particle"], 25..=26);
    assert!(offending());
    // A push that throws the block, 2 cm below the open top, out of the domain at 40 m/s: 13 steps of 1.6 mm.
    let above =
        ("lower_m = [0.04, 0.05], upper_m = [0.08, 0.09]", "lower_m = [0.04, 0.14], upper_m = [0.08, 0.18]");
    let case = pushed(&bench, &[above], "[0, \"step(t - 0.001)*step(0.00104 - t)*1e6\"]");
    stops(&bench, &case, &[], 5, &["outside the domain", "of body `block`", "at most 0"], 28..=45);
    assert!(offending());

    let case = bench.tank("case.toml", &[]);
    let at = StepStage { step: 24, stage: Stage::Corrector };
    for (wrong, code, words) in [
        (Wrong::Limit(at), 5, ["step 24 corrector: time step over its stability limit", "of particle"]),
        (Wrong::Skewed(at), 6, ["step 24 corrector", "ledger breach"]),
        (Wrong::Stale(at), 6, ["step 24 corrector", "stale"]),
    ] {
        let server = serve(Double(wrong));
        let address = server.address.to_string();
        stops(&bench, &case, &["--solid", &address], code, &words, 24..=25);
        assert_eq!(table.exists(), code == 5, "{words:?}");
    }
}
