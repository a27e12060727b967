//! What can go wrong outside the physics: each failure has its exit code, and words that name place, value, what is
//! allowed and what to do.

use std::io::{Read, Write};
use std::net::TcpListener;

use proto::description::ProtocolVersion;
use sph::stage::{Stage, StepStage};
use tests::bench::{Bench, text};
use tests::doubles::{Double, Wrong, serve};

fn bench() -> Bench {
    Bench::new(env!("CARGO_BIN_EXE_tidelock-node"))
}

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
    // Ends with the test's process: nobody closes a listener that waits.
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
fn something_that_is_no_solver_is_told_from_one() {
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
fn a_server_with_another_version_is_refused() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let server = serve(Double(Wrong::Protocol(ProtocolVersion { major: 2, minor: 1 })));
    let address = server.address.to_string();
    let words = [&address, "protocol 2.1", "this coordinator 1.1", "use releases that share one"];
    bench.run_refused(&case, &["--solid", &address], 4, &words);
}

#[test]
fn a_server_with_other_constants_is_refused_with_both_values() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let server = serve(Double(Wrong::SoundSpeed(20.0)));
    let address = server.address.to_string();
    let words = ["sound speed: 25.0 m/s at the fluid, 20.0 m/s at the solid"];
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
    // h/c_L = 1.3 · 10 mm / 152.83 m/s, the stiffest part.
    bench.case_refused(&case, &["case.toml:12", "0.0004", "at most 8.5061e-5 s", "elastic", "limit_factor"]);
}

#[test]
fn mistakes_of_the_scene_are_refused() {
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
        &["lost the solid solver after 12 completed steps", "completed no step for 2 s", "step_s"],
    );
    // The deadline, a look each second, and time for the fluid and the report to end; far below the delay.
    assert!(started.elapsed() < std::time::Duration::from_secs(15), "{:?}", started.elapsed());
}
