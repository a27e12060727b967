//! The server program as others start it: its one line, its signals, its exit codes.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        // Already ended in a test that passes.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

impl Program {
    fn start(args: &[&str]) -> Self {
        // The tests themselves may run where a signal is ignored.
        let child = Command::new("env")
            .args(["--default-signal=HUP", env!("CARGO_BIN_EXE_fluid-server")])
            .args(args)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        Self(child)
    }

    /// The first line of its output.
    fn line(&mut self) -> String {
        let mut line = String::new();
        BufReader::new(self.0.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        line
    }

    fn end(&mut self) -> ExitStatus {
        let deadline = Instant::now() + Duration::from_secs(20);
        while Instant::now() < deadline {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("the program does not end");
    }

    fn errors(&mut self) -> String {
        std::io::read_to_string(self.0.stderr.as_mut().unwrap()).unwrap()
    }
}

fn address(line: &str) -> SocketAddr {
    line.strip_prefix("LISTEN ").unwrap().trim_end().parse().unwrap()
}

#[test]
fn it_tells_its_address_and_ends_in_order_when_told() {
    for signal in ["TERM", "INT", "HUP"] {
        let mut program = Program::start(&["--threads", "1"]);
        let address = address(&program.line());
        assert!(address.ip().is_loopback() && address.port() != 0);
        std::net::TcpStream::connect(address).unwrap();
        let pid = program.0.id().to_string();
        assert!(Command::new("kill").args([&format!("-{signal}"), &pid]).status().unwrap().success());
        assert_eq!(program.end().code(), Some(0), "{signal}");
    }
}

#[test]
fn it_ends_with_the_program_that_started_it_when_asked_to() {
    let mut program = Program::start(&["--exit-with-parent", "--threads", "1"]);
    address(&program.line());
    drop(program.0.stdin.take());
    assert_eq!(program.end().code(), Some(0));
}

#[test]
fn wrong_usage_and_taken_ports_have_codes_and_words_of_their_own() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let holder = std::net::TcpListener::bind(&taken).unwrap();
    for (args, code, words) in [
        (vec!["--listen", "0.0.0.0:0"], 2, "--insecure"),
        (vec!["--listen", "nowhere"], 2, "--listen"),
        (vec!["--threads", "0"], 2, "--threads"),
        (vec!["--listen", &taken], 3, "choose another port"),
    ] {
        let mut program = Program::start(&args);
        assert_eq!(program.end().code(), Some(code), "{args:?}");
        let errors = program.errors();
        assert!(errors.contains(words), "{args:?}: {errors}");
    }
    drop(holder);
    let mut program = Program::start(&["--help"]);
    assert_eq!(program.end().code(), Some(0));
}

#[test]
fn it_has_a_name_and_a_version_of_its_own() {
    let mut program = Program::start(&["--version"]);
    assert_eq!(program.line(), concat!("fluid-server ", env!("CARGO_PKG_VERSION"), "\n"));
    assert_eq!(program.end().code(), Some(0));
}

#[test]
fn its_log_has_no_escape_sequences_where_it_goes_to_no_terminal() {
    let mut program = Program::start(&["--exit-with-parent", "--threads", "1"]);
    address(&program.line());
    drop(program.0.stdin.take());
    assert_eq!(program.end().code(), Some(0));
    let log = program.errors();
    assert!(log.contains("listening") && !log.contains('\u{1b}'), "{log:?}");
}

#[test]
fn a_token_that_is_announced_is_demanded_and_one_that_does_not_come_is_missed() {
    for sent in ["", "short\n"] {
        let mut program = Program::start(&["--token-stdin"]);
        let mut input = program.0.stdin.take().unwrap();
        std::io::Write::write_all(&mut input, sent.as_bytes()).unwrap();
        drop(input);
        assert_eq!(program.end().code(), Some(2));
        let errors = program.errors();
        assert!(errors.contains("access token"), "{errors}");
    }
}
