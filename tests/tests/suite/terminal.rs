//! What a user sees: on a terminal of 80 columns, in pipes, in the help.

use std::path::Path;
use std::process::Command;

use crate::{PROGRAM, bench};
use tests::bench::text;
use tests::streams::Terminal;

/// Columns of a terminal that does not say.
const WIDTH: usize = 80;

/// `shown` without escape sequences.
fn plain(shown: &str) -> String {
    let mut text = String::new();
    let mut characters = shown.chars();
    while let Some(c) = characters.next() {
        if c == '\u{1b}' {
            // The letter ends a sequence.
            characters.by_ref().find(char::is_ascii_alphabetic);
        } else {
            text.push(c);
        }
    }
    text
}

/// Standard output and standard error of the program, which must succeed.
fn called(arguments: &[&str]) -> [String; 2] {
    let output = bench().call(arguments);
    assert!(output.status.success(), "{output:?}");
    [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap())
}

#[test]
fn a_run_on_a_terminal_fits_it_and_shows_physics() {
    let bench = bench();
    let case = bench.tank_to(0.05, None);
    let mut command = Command::new(PROGRAM);
    command.env_clear().env("TERM", "xterm").args(["run", text(&case), "--out", text(&bench.path("out"))]);
    let (terminal, mut run) = Terminal::start(&mut command);
    let shown = terminal.wait_for("results in ");
    assert_eq!(run.end(), Some(0));
    assert!(shown.contains("\u{1b}[") && shown.contains("completed"), "{shown:?}");
    let shown = plain(&shown);
    let lines: Vec<&str> = shown.split(['\n', '\r']).filter(|line| !line.trim().is_empty()).collect();
    for (line, name) in
        lines.iter().zip(["case ", "particles ", "time step ", "interface ", "solvers ", "results "])
    {
        assert!(line.starts_with(name), "{name:?} is not in {line:?}");
    }
    let bar = lines.iter().find(|line| line.contains(" left  t = ")).unwrap();
    assert!(bar.contains(" %  ") && bar.contains(" kinetic "), "{bar:?}");
    // Paths have no spaces to break at.
    for line in lines.iter().filter(|line| !line.contains(text(&bench.path("out")))) {
        assert!(line.trim_end().chars().count() <= WIDTH, "{line:?}");
    }
}

#[test]
fn a_quiet_run_prints_its_verdict_alone_and_a_verbose_one_all_constants() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    let run = |more: &str, out: &str| {
        let output = bench.call(&["run", text(&case), more, "--out", text(&bench.path(out))]);
        assert!(output.status.success());
        assert!(output.stdout.is_empty());
        String::from_utf8(output.stderr).unwrap()
    };
    let quiet = run("--quiet", "quiet");
    assert_eq!(quiet.lines().count(), 1, "{quiet}");
    assert!(quiet.contains(": completed") && quiet.contains("the end time was reached"), "{quiet}");
    let verbose = run("--verbose", "verbose");
    for words in ["constants ", "term of fluid", "fluid solver", "sound_speed_m_s = 25"] {
        assert!(verbose.contains(words), "no {words:?} in {verbose}");
    }
    assert!(!verbose.contains('\u{1b}'), "{verbose:?}");
    let report = std::fs::read_to_string(bench.path("quiet").join("report.html")).unwrap();
    assert!(report.contains("sound_speed_m_s = 25"));
}

#[test]
fn help_groups_commands_and_options_and_names_the_codes_once() {
    let [help, _] = called(&["--help"]);
    for words in ["\nRun:\n", "\nLook:\n", "\nSet up:\n", "\nExit codes:\n"] {
        assert!(help.contains(words), "no {words:?} in {help}");
    }
    let [long, _] = called(&["run", "--help"]);
    for words in ["\nCheckpoints:\n", "\nScreen:\n", "--relay-listen"] {
        assert!(long.contains(words), "no {words:?} in {long}");
    }
    assert!(!long.contains("a fault of this program"), "{long}");
    let [short, _] = called(&["run", "-h"]);
    assert!(short.contains("--threads") && !short.contains("--relay-listen"), "{short}");
    for help in [help, long, short] {
        assert!(!help.contains('\u{1b}'), "{help:?}");
    }
}

#[test]
fn servers_are_commands_with_the_options_of_their_programs() {
    for role in ["fluid", "solid"] {
        let [help, _] = called(&[&format!("{role}-server"), "--help"]);
        assert!(help.contains("--token-stdin") && help.contains("3 the address is taken"), "{help}");
    }
}

#[test]
fn completions_and_man_pages_know_every_command() {
    for shell in ["bash", "zsh", "fish"] {
        let [script, _] = called(&["completions", shell]);
        assert!(
            script.contains("--checkpoint-every-steps") || script.contains("checkpoint-every-steps"),
            "{script}"
        );
        assert!(script.contains("ensemble"), "{script}");
    }
    let bench = bench();
    let folder = bench.path("pages");
    assert!(bench.call(&["man", text(&folder)]).status.success());
    for page in ["tidelock.1", "tidelock-run.1", "tidelock-fluid-server.1"] {
        assert!(folder.join(page).is_file(), "{page}");
    }
    bench.refused(&["man", text(&bench.write("file", ""))], 3, &["cannot write pages to "]);
}

/// What `bash` offers after `words`, by the script of `completions bash`.
fn offered(words: &str) -> String {
    let [script, _] = called(&["completions", "bash"]);
    let bench = bench();
    let path = bench.write("completions", &script);
    let ask = format!(
        "source {}; COMP_WORDS=({words}); COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 )); \
         _tidelock tidelock \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD-1]}}\"; echo \"${{COMPREPLY[*]}}\"",
        path.display()
    );
    let output = Command::new("bash").args(["--norc", "-c", &ask]).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn bash_completes_commands_and_options() {
    if !Path::new("/bin/bash").exists() {
        return;
    }
    assert_eq!(offered("tidelock conv").trim(), "converge");
    let options = offered("tidelock run --checkpoint");
    assert!(options.contains("--checkpoint-every-wall"), "{options}");
}
