//! Authentication and encryption: every combination of certificates and tokens.

mod secrets;

use std::path::Path;
use std::time::Duration;

use crate::{PROGRAM, bench};
use proto::RpcCode;
use proto::transport::client::{Deadlines, ParticipantClient};
use proto::transport::security::{ClientFiles, ClientSecurity};
use secrets::{Demands, Secrets, Shows};
use tests::bench::{digests, text};
use tests::nodes::Node;

/// A description, as the first call of every coordinator; a refusal with its words.
async fn describe(address: &str, files: &ClientFiles) -> Result<(), (RpcCode, String)> {
    let security = ClientSecurity::load(files).unwrap();
    let second = Duration::from_secs(1);
    // A caller without TLS at a server with TLS gets no answer that it understands.
    let deadlines = Deadlines { connect: 5 * second, describe: 5 * second, ..Deadlines::default() };
    let refused = |e: proto::RpcError| (e.code, e.message);
    let mut client =
        ParticipantClient::connect_secured(address, deadlines, &security).await.map_err(refused)?;
    client.describe().await.map(drop).map_err(refused)
}

#[tokio::test]
async fn every_wrong_combination_of_certificates_and_tokens_is_refused_and_the_right_ones_work() {
    let secrets = Secrets::new();
    let both = [false, true];
    let any = [None, Some(false), Some(true)];
    let (mut let_in, mut refused) = (0, 0);
    for (tls, certificate, with_token) in [
        (false, false, false),
        (false, false, true),
        (true, false, false),
        (true, false, true),
        (true, true, false),
        (true, true, true),
    ] {
        let demands = Demands { tls, certificate, token: with_token };
        let node = secrets.start("solid", demands);
        for (tls, token, (certificate, trusts)) in both.into_iter().flat_map(|tls| {
            any.into_iter().flat_map(move |token| {
                // Without TLS certificates have no meaning.
                let shown = if tls {
                    vec![(None, true), (Some(true), true), (Some(false), true), (Some(true), false)]
                } else {
                    vec![(None, true)]
                };
                shown.into_iter().map(move |c| (tls, token, c))
            })
        }) {
            let shows = Shows { tls, certificate, token, trusts };
            let right = tls == demands.tls
                && (!tls || trusts)
                && (!demands.certificate || certificate == Some(true))
                && (!demands.token || token == Some(true));
            let address = if tls { format!("https://{}", node.address) } else { node.address.clone() };
            let answer = describe(&address, &secrets.caller(shows)).await;
            assert_eq!(answer.is_ok(), right, "{demands:?} {shows:?}: {answer:?}");
            match answer {
                Ok(()) => let_in += 1,
                Err((code, message)) => {
                    refused += 1;
                    if code == RpcCode::PermissionDenied {
                        assert_eq!(message, "not allowed", "no word on what was wrong");
                    }
                    let secret = "a".repeat(20);
                    assert!(!message.contains(&secret), "{message}");
                }
            }
        }
    }
    // 6 kinds of servers, 15 kinds of callers.
    assert_eq!(let_in + refused, 90);
    assert!(let_in >= 12, "{let_in} were let in");
}

#[test]
fn a_run_by_mutual_tls_and_tokens_gives_the_same_bits() {
    let bench = bench();
    let secrets = Secrets::new();
    let demands = Demands { tls: true, certificate: true, token: true };
    let (fluid, solid) = (secrets.start("fluid", demands), secrets.start("solid", demands));
    let case = bench.tank("case.toml", &[]);
    let plain = bench.run(&case, "plain", &["--threads", "1"]);
    let [fluid, solid] = [fluid, solid].map(|node| (format!("https://{}", node.address), node));
    let (ca, cert, key) = (secrets.own.file("ca"), secrets.own.file("caller"), secrets.own.key("caller"));
    let (right, wrong) = (secrets.token(true), secrets.token(false));
    let with = |token: &Path| -> Vec<String> {
        let files = [("--tls-ca", &ca), ("--tls-cert", &cert), ("--tls-key", &key)];
        let mut words = vec!["--fluid".to_owned(), fluid.0.clone(), "--solid".into(), solid.0.clone()];
        words.extend(files.iter().flat_map(|(option, path)| [(*option).to_owned(), text(path).to_owned()]));
        words.extend(["--token-file".to_owned(), text(token).to_owned()]);
        words
    };
    bench.run_refused(&case, &borrow(&with(&wrong)), 4, &["not allowed"]);
    let secured = bench.run(&case, "secured", &borrow(&with(&right)));
    assert_eq!(digests(&secured), digests(&plain));

    // The same by the keys of the case, on the same servers.
    let keys = format!(
        "[servers]\nfluid_address = \"{}\"\nsolid_address = \"{}\"\nca_file = {ca:?}\ncert_file = {cert:?}\nkey_file = {key:?}\n\
         token_file = {right:?}\n[outputs]",
        fluid.0, solid.0
    );
    let case = bench.tank("keys.toml", &[("[outputs]", &keys)]);
    assert_eq!(digests(&bench.run(&case, "keys", &[])), digests(&plain));
    let written = std::fs::read_to_string(bench.path("keys").join("case.toml")).unwrap();
    assert!(!written.contains(&"a".repeat(20)), "the secret itself goes nowhere");
}

/// `words` as they are borrowed.
fn borrow(words: &[String]) -> Vec<&str> {
    words.iter().map(String::as_str).collect()
}

#[test]
fn secured_solvers_are_examined_as_all_others_by_those_who_may() {
    let bench = bench();
    let secrets = Secrets::new();
    let demands = Demands { tls: true, certificate: true, token: true };
    let [right, wrong] = [true, false].map(|right| secrets.options("caller", right));
    // Raw calls, whole runs with a dummy that dials the solid, and the relay between both.
    for (role, checks) in [("solid", "frame"), ("fluid", "state")] {
        let node = secrets.start(role, demands);
        let address = format!("https://{}", node.address);
        let conform = ["conform", &address, "--only", checks];
        let output = bench.call(&[&conform[..], &borrow(&right)].concat());
        let table = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{table}{}", String::from_utf8_lossy(&output.stderr));
        assert!(table.matches(" passed ").count() > 4, "{table}");
        bench.refused(&[&conform[..], &borrow(&wrong)].concat(), 4, &["not allowed"]);
        bench.refused(&conform, 4, &[&address, "no authority's certificate"]);
    }
}

#[test]
fn relayed_recorded_and_replayed_frames_of_a_secured_run_keep_its_bits() {
    let bench = bench();
    let secrets = Secrets::new();
    let case = bench.tank("case.toml", &[]);
    let plain = digests(&bench.run(&case, "plain", &["--threads", "1"]));
    let demands = Demands { tls: true, certificate: true, token: true };
    let nodes = ["fluid", "solid"].map(|role| secrets.start(role, demands));
    let [fluid, solid] = nodes.each_ref().map(|node| format!("https://{}", node.address));
    let servers = ["--fluid", &fluid, "--solid", &solid];
    let file = bench.path("frames");
    // The relay is a server too: its certificate must name this machine.
    let right = secrets.options("server", true);
    let recorded = [&servers[..], &borrow(&right), &["--record", text(&file)]].concat();
    assert_eq!(digests(&bench.run(&case, "relayed", &recorded)), plain);
    let page = std::fs::read_to_string(bench.path("relayed/report.html")).unwrap();
    assert!(page.contains("relayed by the coordinator at https://127.0.0.1:"));
    let other = secrets.options("caller", true);
    bench.run_refused(
        &case,
        &[&servers[..], &borrow(&other), &["--relay"]].concat(),
        4,
        &["Link", "certificate"],
    );
    let out = bench.path("replayed");
    let replay =
        ["replay", text(&case), text(&file), "--side", "solid", "--solid", &solid, "--out", text(&out)];
    let output = bench.call(&[&replay[..], &borrow(&right)].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    // A token alone leaves the frames on this machine in the clear, as everything else.
    let demands = Demands { tls: false, certificate: false, token: true };
    let nodes = ["fluid", "solid"].map(|role| secrets.start(role, demands));
    let token = secrets.token(true);
    let servers = ["--fluid", &nodes[0].address, "--solid", &nodes[1].address, "--token-file", text(&token)];
    assert_eq!(digests(&bench.run(&case, "token", &[&servers[..], &["--relay"]].concat())), plain);
    // Beyond this machine that needs a word.
    let elsewhere = [&servers[..], &["--relay-listen", "192.0.2.1:0"]].concat();
    bench.run_refused(&case, &elsewhere, 2, &["192.0.2.1:0", "in the clear", "--relay-insecure"]);
}

#[test]
fn a_partner_that_is_not_trusted_is_not_dialled() {
    let bench = bench();
    let secrets = Secrets::new();
    let demands = Demands { tls: true, certificate: false, token: false };
    let solid = secrets.start("solid", demands);
    // The coordinator knows the solid's authority; the fluid that it finds at work knows another.
    let other = secrets.other.file("ca");
    let fluid = Node::start(Path::new(PROGRAM), "fluid", &["--partner-ca", text(&other)]);
    let case = bench.tank("case.toml", &[]);
    let (address, ca) = (format!("https://{}", solid.address), secrets.own.file("ca"));
    let arguments = ["--fluid", &fluid.address, "--solid", &address, "--tls-ca", text(&ca)];
    bench.run_refused(&case, &arguments, 4, &["Link", "certificate"]);
    // A fluid server that it starts itself gets its authorities.
    let arguments = ["--solid", &address, "--tls-ca", text(&ca)];
    assert_eq!(bench.run(&case, "own", &arguments)["verdict"], "completed");
}

#[test]
fn a_server_beyond_this_machine_needs_certificate_and_token_or_a_word_that_names_the_risk() {
    let bench = bench();
    let secrets = Secrets::new();
    let all = Demands { tls: true, certificate: true, token: true };
    for (demands, words) in [
        (Demands { tls: false, certificate: false, token: false }, ["--tls-cert", "--token-file"]),
        (Demands { tls: false, certificate: false, token: true }, ["--tls-cert", "--insecure"]),
        (Demands { token: false, ..all }, ["--token-file", "--insecure"]),
    ] {
        let arguments = secrets.server(demands);
        let mut words_of = vec!["node-solid", "--listen", "0.0.0.0:0"];
        words_of.extend(arguments.iter().map(String::as_str));
        bench.refused(&words_of, 2, &words);
    }
    let arguments = secrets.server(all);
    let mut given: Vec<&str> = arguments.iter().map(String::as_str).collect();
    given.extend(["--listen", "0.0.0.0:0"]);
    assert!(Node::start(Path::new(PROGRAM), "solid", &given).address.starts_with("0.0.0.0:"));
    Node::start(Path::new(PROGRAM), "solid", &["--listen", "0.0.0.0:0", "--insecure"]);
}

#[test]
fn refusals_name_the_option_that_helps() {
    let bench = bench();
    let secrets = Secrets::new();
    let case = bench.tank("case.toml", &[]);
    let refused = |arguments: &[&str], words: &str| {
        bench.run_refused(&case, arguments, 4, &[words]);
        let said =
            bench.call(&[&["run", text(&case), "--out", text(&bench.path("refused"))], arguments].concat());
        let said = String::from_utf8_lossy(&said.stderr).into_owned();
        for wrong in ["start a solid server", "no solver of protocol"] {
            assert!(!said.contains(wrong), "{arguments:?}: {said}");
        }
    };
    let wrong = secrets.token(false);
    let node = secrets.start("solid", Demands { tls: false, certificate: false, token: true });
    refused(
        &["--solid", &node.address],
        "demands an access token; give the file that holds it by `--token-file`",
    );
    refused(
        &["--solid", &node.address, "--token-file", text(&wrong)],
        "is not the one that the server demands",
    );
    bench.refused(&["conform", &node.address], 4, &["not allowed", "`--token-file`"]);

    let node = secrets.start("solid", Demands { tls: true, certificate: true, token: false });
    let address = format!("https://{}", node.address);
    let (ca, other) = (secrets.own.file("ca"), secrets.other.file("ca"));
    refused(&["--solid", &address], "is needed; give it by `--tls-ca`");
    refused(&["--solid", &address, "--tls-ca", text(&other)], "is needed; give it by `--tls-ca`");
    refused(&["--solid", &address, "--tls-ca", text(&ca)], "give one by `--tls-cert` and `--tls-key`");
    let (cert, key) = (secrets.other.file("caller"), secrets.other.key("caller"));
    let shown = ["--tls-ca", text(&ca), "--tls-cert", text(&cert), "--tls-key", text(&key)];
    refused(
        &[&["--solid", &address], &shown[..]].concat(),
        "give one that its authority has signed by `--tls-cert`",
    );
}

#[test]
fn secrets_that_others_can_read_are_warned_of_by_server_and_coordinator() {
    let bench = bench();
    let secrets = Secrets::new();
    let case = bench.tank("case.toml", &[]);
    let token = secrets.token(true);
    for (mode, warned) in [("644", true), ("600", false)] {
        assert!(std::process::Command::new("chmod").args([mode, text(&token)]).status().unwrap().success());
        let out = bench.path("out");
        let options =
            ["run", text(&case), "--quiet", "--force", "--out", text(&out), "--token-file", text(&token)];
        let output = bench.call(&options);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{said}");
        assert_eq!(said.contains(&format!("run `chmod 600 {}`", text(&token))), warned, "{mode}: {said}");
        // A server says so in its log; with its address taken it ends by itself.
        let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let address = taken.local_addr().unwrap().to_string();
        let output = bench.call(&["node-solid", "--token-file", text(&token), "--listen", &address]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(said.contains("chmod 600"), warned, "{mode}: {said}");
    }
}
