//! A run with a page: it gives the results of one without, and does what the buttons say.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::{PROGRAM, bench};
use tests::bench::{digests, soon, text};

/// Far more simulated time than a test waits for.
const LONG: (&str, &str) = ("end_time_s = 0.002", "end_time_s = 100.0");

/// A program that has printed the link of its page: address and token.
struct Viewed {
    program: Child,
    address: String,
    token: String,
    /// Stays open, as the program writes on.
    said: BufReader<Box<dyn Read + Send>>,
}

impl Viewed {
    fn start(arguments: &[&str], on_stdout: bool) -> Self {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut program = command.spawn().unwrap();
        let stream: Box<dyn Read + Send> = match on_stdout {
            true => Box::new(program.stdout.take().unwrap()),
            false => Box::new(program.stderr.take().unwrap()),
        };
        let mut said = BufReader::new(stream);
        let mut line = String::new();
        while !line.contains("http://") {
            line.clear();
            assert!(said.read_line(&mut line).unwrap() > 0, "no link");
        }
        let link = line.split("http://").nth(1).unwrap().trim();
        let (address, token) = link.split_once("/#token=").unwrap_or((link.trim_end_matches('/'), ""));
        Self { program, address: address.to_owned(), token: token.to_owned(), said }
    }

    fn ask(&self, line: &str, headers: &str) -> String {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        write!(stream, "{line} HTTP/1.1\r\nHost: localhost\r\n{headers}Connection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn end(&mut self) -> Option<i32> {
        let mut rest = String::new();
        self.said.read_to_string(&mut rest).unwrap();
        self.program.wait().unwrap().code()
    }
}

impl Drop for Viewed {
    fn drop(&mut self) {
        drop(self.program.kill());
    }
}

fn content(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap()
}

#[test]
fn a_run_with_a_page_and_a_browser_that_takes_nothing_has_the_same_results() {
    let bench = bench();
    let case = bench.tank("case.toml", &[("end_time_s = 0.002", "end_time_s = 0.02")]);
    let plain = bench.run(&case, "plain", &["--in-process"]);
    let out = bench.path("viewed");
    let mut run =
        Viewed::start(&["run", text(&case), "--in-process", "--quiet", "--view", "--out", text(&out)], false);
    let deaf: Vec<TcpStream> = ["/api/events", "/"]
        .iter()
        .map(|path| {
            let mut stream = TcpStream::connect(&run.address).unwrap();
            write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
            stream
        })
        .collect();
    assert_eq!(run.end(), Some(0));
    drop(deaf);
    let viewed = bench.summary("viewed");
    assert_eq!(digests(&plain), digests(&viewed));
    for name in ["probes.csv", "ledger.csv", "case.toml", "final/fluid.state", "final/solid.state"] {
        assert!(content(&bench.path("plain"), name) == content(&out, name), "{name} differs");
    }
}

#[test]
fn buttons_of_the_page_need_the_token_and_do_what_they_say() {
    let bench = bench();
    let out = bench.path("out");
    let case = bench.tank("case.toml", &[LONG]);
    let mut run = Viewed::start(&["run", text(&case), "--quiet", "--view", "--out", text(&out)], false);
    let status = |answer: &str| answer.split(' ').nth(1).unwrap().to_owned();
    assert_eq!(status(&run.ask("POST /api/stop", "")), "401");
    assert_eq!(status(&run.ask("POST /api/stop", "Authorization: Bearer 0123456789\r\n")), "403");
    let token = format!("Authorization: Bearer {}\r\n", run.token);
    // Before the first step there is nothing to be saved.
    soon("the first snapshot", || out.join("snapshots/fluid.pvd").is_file());
    let checkpoints = || {
        let entries = std::fs::read_dir(out.join("checkpoints")).into_iter().flatten();
        entries
            .filter(|entry| {
                entry.as_ref().is_ok_and(|e| e.file_name().to_string_lossy().starts_with("step_"))
            })
            .count()
    };
    soon("a checkpoint", || {
        if checkpoints() == 0 {
            assert!(["202", "409"].contains(&status(&run.ask("POST /api/checkpoint", &token)).as_str()));
        }
        checkpoints() > 0
    });
    let shown = run.ask("GET /api/frames/0", "");
    let run_message = run.ask("GET /", "");
    assert!(run_message.contains("data-live"), "{run_message:.600}");
    assert!(shown.starts_with("HTTP/1.1 200") && shown.contains("\"count\":"), "{shown:.300}");
    assert_eq!(status(&run.ask("POST /api/stop", &token)), "202");
    assert_eq!(run.end(), Some(8));
    assert_eq!(bench.summary("out")["verdict"], "stopped");
    // The folder afterwards, read-only.
    let view = Viewed::start(&["view", text(&out)], true);
    let page = view.ask("GET /", "");
    assert!(page.contains("class=\"frame\"") && page.contains("stopped"), "{page:.600}");
    assert_eq!(status(&view.ask("POST /api/stop", &token)), "409");
    let message: Value = {
        let text = page.split("id=\"run\">").nth(1).unwrap().split("</script>").next().unwrap();
        serde_json::from_str(text).unwrap()
    };
    assert_eq!(message["scene"]["dimensions"], 2);
}

#[test]
fn what_is_no_folder_of_a_run_is_refused() {
    let bench = bench();
    bench.refused(&["view", text(&bench.path("nothing"))], 2, &["no folder of a run", "case.toml"]);
}
