//! The kit of `tidelock conform`: sound solvers pass it, and each seeded fault is called by its name.

use std::time::Duration;

use crate::bench;
use proto::description::ProtocolVersion;
use proto::service::SolverFactory;
use sph::coupling::stage::{Stage, StepStage};
use tests::bench::text;
use tests::doubles::{Double, Wrong, serve};

const AT: StepStage = StepStage { step: 4, stage: Stage::Corrector };

/// Examines a server of `factory`; answers exit code and table.
fn examine(factory: impl SolverFactory + Clone, further: &[&str]) -> (Option<i32>, String) {
    let (server, fresh) = (serve(factory.clone()), serve(factory));
    let (address, fresh) = (server.address.to_string(), fresh.address.to_string());
    let mut arguments = vec!["conform", &address, "--fresh", &fresh];
    arguments.extend(further);
    let output = bench().call(&arguments);
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), table + &String::from_utf8_lossy(&output.stderr))
}

/// The line of `check` in a table.
fn line<'a>(table: &'a str, check: &str) -> &'a str {
    table.lines().find(|line| line.starts_with(&format!("{check} "))).unwrap_or_else(|| panic!("{table}"))
}

#[test]
fn the_servers_of_this_workspace_conform() {
    for (kind, dimensions) in [("states", "2"), ("loads", "2"), ("states", "3"), ("loads", "3")] {
        let options = ["--kind", kind, "--dimensions", dimensions];
        conforms(kind, examine(solid_server::SolidFactory, &options));
        conforms(kind, examine(fluid_server::FluidFactory::default(), &options));
    }
}

fn conforms(kind: &str, (code, table): (Option<i32>, String)) {
    let offered = ["large-frame", "order-oscillator", "iterated-half-step", "body-masses"];
    assert_eq!(code, Some(0), "{kind}: {table}");
    for line in table.lines().filter(|line| line.contains(" not offered ")) {
        assert!(offered.iter().any(|name| line.starts_with(name)), "{kind}: {line}");
    }
    for check in ["action-reaction", "angular-momentum"] {
        assert!(line(&table, check).contains(" passed "), "{table}");
    }
    let iterated = if kind == "loads" { " passed " } else { " not offered " };
    assert!(line(&table, "iterated-half-step").contains(iterated), "{table}");
}

#[test]
fn the_kit_names_each_seeded_fault() {
    let short = ["--deadline", "2"];
    for (wrong, check, words) in [
        (Wrong::Gravity(1.01), "gravity", &["the velocity is", "expected"][..]),
        (Wrong::SoundSpeed(21.0), "constants", &["sound_speed: 21.0"]),
        (Wrong::Stale(AT), "action-reaction", &["ledger breach", "stale", "step 4 corrector"]),
        (Wrong::Force(AT, 1.001), "action-reaction", &["ledger breach", "step 4 corrector"]),
        (Wrong::NotANumber(AT), "action-reaction", &["NaN", "step 4 corrector"]),
        (Wrong::Delay(AT, Duration::from_secs(5)), "rest", &["no event within 2 s after step 4"]),
        (Wrong::EmptyCheckpoint, "checkpoint-replay", &["another state"]),
        (Wrong::Drop(AT), "rest", &["broke off", "seeded at step 4 corrector"]),
    ] {
        let mut arguments = vec!["--only", check];
        arguments.extend(short);
        let (code, table) = examine(Double(wrong), &arguments);
        assert_eq!(code, Some(9), "{wrong:?}: {table}");
        let line = line(&table, check);
        assert!(line.contains(" FAILED "), "{wrong:?}: {line}");
        for word in words {
            assert!(line.contains(word), "{wrong:?}: no {word:?} in {line}");
        }
    }
}

#[test]
fn a_solid_that_settles_without_moving_is_found_out() {
    let (code, table) = examine(Double(Wrong::Unmoved), &["--kind", "loads", "--only", "iterated"]);
    assert_eq!(code, Some(9), "{table}");
    assert!(line(&table, "iterated-half-step").contains("do not satisfy the midpoint rule"), "{table}");
}

#[test]
fn a_lie_that_keeps_the_books_is_found_by_its_own_check_only() {
    let (code, table) = examine(Double(Wrong::Gravity(1.01)), &["--only", "a"]);
    assert_eq!(code, Some(9), "{table}");
    assert_eq!(table.lines().filter(|line| line.contains(" FAILED ")).count(), 1, "{table}");
}

#[test]
fn another_protocol_is_reported() {
    let version = ProtocolVersion { major: 3, minor: 0 };
    let (code, table) = examine(Double(Wrong::Protocol(version)), &["--only", "description"]);
    assert_eq!(code, Some(9), "{table}");
    assert!(line(&table, "description").contains("protocol"), "{table}");
}

#[test]
fn the_file_for_test_viewers_holds_every_check() {
    let bench = bench();
    let server = serve(Double(Wrong::Force(AT, 1.001)));
    let path = bench.path("conform.xml");
    let address = server.address.to_string();
    bench.refused(&["conform", &address, "--only", "or", "--junit", text(&path)], 9, &["fails 1 of"]);
    let file = std::fs::read_to_string(path).unwrap();
    assert!(file.contains("<testcase classname=\"conform\" name=\"order-convergence\""), "{file}");
    assert_eq!(file.matches("<failure ").count(), 1, "{file}");
    assert!(file.contains("<skipped "), "{file}");
}

#[test]
fn an_address_without_a_participant_is_named() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    bench().refused(&["conform", &free, "--deadline", "2"], 4, &[&free, "cannot be reached"]);
    bench().refused(&["conform"], 2, &["give the address of a running solver"]);
    bench().refused(&["conform", &free, "--only", "nonsense"], 2, &["no check has \"nonsense\"", "--list"]);
}

#[test]
fn the_ledger_and_the_frames_name_each_seeded_fault_of_a_run() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    for (k, (wrong, code, words)) in [
        (Wrong::Force(AT, 1.001), 6, &["ledger breach at step 4 corrector", "force"][..]),
        (Wrong::Stale(AT), 6, &["step 4 corrector", "stale"]),
        // The solid meets its own NaN first.
        (Wrong::NotANumber(AT), 5, &["step 4 corrector", "velocity", "NaN"]),
        (Wrong::Drop(AT), 7, &["seeded at step 4 corrector"]),
    ]
    .into_iter()
    .enumerate()
    {
        let server = serve(Double(wrong));
        let (out, address) = (bench.path(&format!("out{k}")), server.address.to_string());
        let arguments = ["run", text(&case), "--quiet", "--out", text(&out), "--solid", &address];
        bench.refused(&arguments, code, words);
    }
}
