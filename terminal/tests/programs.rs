//! How programs end: this test starts itself as a program with a fault, named by [`FAULT_OF`].
//!
//! It has no test harness, which would catch the panics.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output, Stdio};

use terminal::program;

/// Environment variable that makes this test a program with that fault.
const FAULT_OF: &str = "TERMINAL_TEST_FAULT_OF";

/// Name of a test, and the test.
type Test = (&'static str, fn());

const TESTS: [Test; 4] = [
    ("a_panic_is_printed_once_and_ends_with_70", a_panic_is_printed_once_and_ends_with_70),
    (
        "a_panic_ends_with_70_though_nothing_can_be_printed",
        a_panic_ends_with_70_though_nothing_can_be_printed,
    ),
    ("a_contained_panic_leaves_the_exit_code", a_contained_panic_leaves_the_exit_code),
    ("every_program_of_the_workspace_runs_so", every_program_of_the_workspace_runs_so),
];

fn main() -> ExitCode {
    if let Ok(fault) = std::env::var(FAULT_OF) {
        return program::run(|| faulty(&fault));
    }
    let filter = std::env::args().skip(1).find(|word| !word.starts_with('-')).unwrap_or_default();
    for (name, test) in TESTS.iter().filter(|(name, _)| name.contains(&filter)) {
        test();
        terminal::say(format_args!("test {name} ... ok"));
    }
    ExitCode::SUCCESS
}

/// Prints when it is dropped, also while the stack unwinds.
struct Speaks;

impl Drop for Speaks {
    fn drop(&mut self) {
        terminal::note("dropped");
    }
}

fn faulty(fault: &str) -> ExitCode {
    let thread = || drop(std::thread::spawn(|| panic!("on a thread")).join());
    match fault {
        "main" => {
            let _speaks = Speaks;
            panic!("in main")
        }
        "thread, then failure" => {
            thread();
            ExitCode::from(7)
        }
        "thread, then success" => {
            thread();
            ExitCode::SUCCESS
        }
        "contained" => {
            let outcome = program::contain(|| -> u32 { panic!("in {}", "its box") });
            assert_eq!(outcome, Err("in its box".to_owned()));
            assert_eq!(program::contain(|| 1), Ok(1));
            ExitCode::from(5)
        }
        _ => ExitCode::from(3),
    }
}

/// This test as a program with `fault`.
fn start(fault: &str, errors: Stdio) -> Output {
    let own = std::env::current_exe().unwrap();
    let mut command = Command::new(own);
    command.env(FAULT_OF, fault).env_remove("RUST_BACKTRACE").stderr(errors).stdout(Stdio::piped());
    command.spawn().unwrap().wait_with_output().unwrap()
}

fn a_panic_is_printed_once_and_ends_with_70() {
    for (fault, code, words) in [
        ("main", 70, "thread main panicked at terminal/tests/programs.rs:"),
        ("thread, then failure", 70, "thread without name panicked at terminal/tests/programs.rs:"),
        ("thread, then success", 0, "on a thread"),
        ("none", 3, ""),
    ] {
        let output = start(fault, Stdio::piped());
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{fault}: {errors}");
        assert!(errors.contains(words), "{fault}: {errors}");
        assert!(errors.matches("panicked").count() <= 1, "{fault}: {errors}");
    }
}

fn a_panic_ends_with_70_though_nothing_can_be_printed() {
    for fault in ["main", "thread, then failure"] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        assert_eq!(start(fault, full.into()).status.code(), Some(70), "{fault}");
    }
}

fn a_contained_panic_leaves_the_exit_code() {
    let output = start("contained", Stdio::piped());
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(5), "{errors}");
    assert!(errors.contains("in its box"), "{errors}");
}

/// Main functions of the workspace, by Cargo's places for them.
fn programs() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let crates: Vec<PathBuf> = entries(&root).filter(|path| path.join("Cargo.toml").exists()).collect();
    let mains = crates.iter().map(|path| path.join("src/main.rs")).filter(|path| path.exists());
    mains.chain(crates.iter().flat_map(|path| entries(&path.join("src/bin")))).collect()
}

fn every_program_of_the_workspace_runs_so() {
    let programs = programs();
    assert!(programs.len() >= 9, "{programs:?}");
    for path in programs {
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("terminal::program::run("), "{} ends with 101 when it panics", path.display());
    }
}
