//! Limits on what clients can cost a server.

use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::Duration;

use crate::{PROGRAM, bench};
use proto::RpcCode;
use proto::testing::hostile::{CALLS, call, open_of_empty_bodies};
use proto::transport::client::{Deadlines, ParticipantClient};
use tests::bench::{Running, digests, soon, text};
use tests::nodes::Node;

/// A line of the status of a process, in KiB.
fn kilobytes(process: u32, key: &str) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(key)).unwrap();
    line.trim().strip_suffix("kB").unwrap().trim().parse().unwrap()
}

#[tokio::test]
async fn a_set_up_of_empty_entries_is_refused_by_name_in_little_memory() {
    let node = Node::start(Path::new(PROGRAM), "solid", &[]);
    let message = open_of_empty_bodies(30_000_000);
    let refused = call(&node.address, "/fsi.v2.Participant/Open", message).await.unwrap_err();
    assert_eq!(refused.code, RpcCode::TooLarge, "{refused}");
    for words in ["`SolidSetup.bodies`", "30000000 entries", "at most 65536"] {
        assert!(refused.message.contains(words), "{refused}");
    }
    let peak = kilobytes(node.process(), "VmHWM:") >> 10;
    terminal::say(format_args!("peak of the server: {peak} MiB"));
    assert!(peak < 300, "{peak} MiB");
    // Bytes that cost nothing were sent, and the server is as good as before.
    let mut client = ParticipantClient::connect(&node.address, Deadlines::default()).await.unwrap();
    client.describe().await.unwrap();
}

/// Whether `text` holds 64 hexadecimal digits in a row, as a token has them.
fn holds_a_token(text: &str) -> bool {
    text.split(|letter: char| !letter.is_ascii_hexdigit()).any(|word| word.len() == 64)
}

/// The address in the log of `role`.
fn address(out: &Path, role: &str) -> String {
    let log = out.join(format!("logs/{role}-server.log"));
    let mut found = None;
    soon("an address in the log", || {
        let text = std::fs::read_to_string(&log).unwrap_or_default();
        let rest = text.split_once("listening address=");
        found = rest.and_then(|(_, rest)| rest.split_whitespace().next().map(str::to_owned));
        found.is_some()
    });
    found.unwrap()
}

/// Every call at both servers of `run` must be refused; nothing that others can read holds the token.
fn all_others_are_refused(run: &Running, out: &Path) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let others =
        ["/grpc.health.v1.Health/Check", "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo"];
    for role in ["fluid", "solid"] {
        let address = address(out, role);
        for path in CALLS.into_iter().chain(others) {
            let refused = runtime.block_on(call(&address, path, Vec::new())).unwrap_err();
            assert_eq!(refused.code, RpcCode::PermissionDenied, "{role} {path}: {refused}");
        }
        assert!(!holds_a_token(
            &std::fs::read_to_string(out.join(format!("logs/{role}-server.log"))).unwrap()
        ));
    }
    for process in &run.servers {
        for file in ["cmdline", "environ"] {
            let bytes = std::fs::read(format!("/proc/{process}/{file}")).unwrap_or_default();
            assert!(!holds_a_token(&String::from_utf8_lossy(&bytes)), "{file} of {process}");
        }
    }
}

#[test]
fn servers_of_a_run_refuse_all_others_and_the_run_keeps_its_bits() {
    let bench = bench();
    let case = bench.tank_to(0.1, None);
    let whole = digests(&bench.run(&case, "whole", &[]));
    // Built-in ones, and a program that takes the token because it is announced to it.
    let end = "end_time_s = 0.002";
    let servers = format!("[servers]\nsolid_command = [{PROGRAM:?}, \"node-solid\"]\n[outputs]");
    let program = bench.tank("program.toml", &[(end, "end_time_s = 0.1"), ("[outputs]", &servers)]);
    for (case, name) in [(&case, "own"), (&program, "program")] {
        let mut run = bench.start(case, name);
        all_others_are_refused(&run, &bench.path(name));
        let (status, said) = run.end();
        assert_eq!(status.code(), Some(0), "{said}");
        assert_eq!(digests(&bench.summary(name)), whole, "{name}");
    }
}

#[test]
fn a_program_that_knows_nothing_of_tokens_takes_part_as_before() {
    let bench = bench();
    let whole = digests(&bench.run(&bench.tank("case.toml", &[]), "whole", &[]));
    let command = ["env", "-u", "TIDELOCK_TOKEN_STDIN", PROGRAM, "node-solid"];
    let servers = format!("[servers]\nsolid_command = {command:?}\n[outputs]");
    let case = bench.tank("unaware.toml", &[("[outputs]", &servers)]);
    assert_eq!(digests(&bench.run(&case, "unaware", &[])), whole);
}

/// CPU time of a process so far, in hundredths of a second.
fn ticks(process: u32) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    let rest = stat.rsplit_once(')').unwrap().1;
    // utime and stime are the fields 14 and 15, the state after the name is the third.
    rest.split_whitespace().skip(11).take(2).map(|field| field.parse::<u64>().unwrap()).sum()
}

#[test]
fn a_server_short_of_handles_waits_for_some_and_serves_again() {
    let bench = bench();
    let script = bench.write("short", &format!("#!/bin/sh\nulimit -n 40\nexec {PROGRAM} \"$@\"\n"));
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).unwrap();
    let node = Node::start(&script, "solid", &[]);
    let connections: Vec<TcpStream> = (0..80).map(|_| TcpStream::connect(&node.address).unwrap()).collect();
    std::thread::sleep(Duration::from_millis(500));
    let before = ticks(node.process());
    std::thread::sleep(Duration::from_secs(3));
    let used = ticks(node.process()) - before;
    assert!(used < 30, "{used} % of three seconds");
    // None lets go: those that bring no call are closed.
    let out = bench.path("report.xml");
    soon("an answer", || {
        let arguments = ["conform", &node.address, "--only", "description", "--junit", text(&out)];
        bench.call(&arguments).status.success()
    });
    drop(connections);
}

#[test]
fn a_second_client_learns_who_holds_the_server_and_since_when() {
    let bench = bench();
    let solid = Node::start(Path::new(PROGRAM), "solid", &[]);
    let address = format!("[servers]\nsolid_address = \"{}\"\n[time]\nend_time_s = 100.0", solid.address);
    let long = bench.tank("long.toml", &[("[time]\nend_time_s = 0.002", &address)]);
    let mut first = bench.start(&long, "long");
    let case = bench.tank("case.toml", &[]);
    bench.run_refused(
        &case,
        &["--solid", &solid.address],
        4,
        &["busy", "held by coordinator, process", " s, state RUNNING"],
    );
    // The first one continues undisturbed.
    first.signal("INT");
    let (status, message) = first.end();
    assert_eq!(status.code(), Some(8), "{message}");
    assert_eq!(bench.run(&case, "after", &["--solid", &solid.address])["verdict"], "completed");
}

#[test]
fn servers_survive_good_and_bad_clients_in_a_row() {
    let soak = tests::soak::Soak::new(Path::new(PROGRAM));
    let soaked = soak.run(std::time::Instant::now()).unwrap();
    assert!(soaked.good >= 2 * soaked.bad && soaked.bad >= 15, "{soaked:?}");
    assert!(soaked.base.iter().all(|base| base.memory > 0 && base.handles > 0 && base.threads > 1));
}
