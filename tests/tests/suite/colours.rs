//! Colours of error messages reach a terminal and only a terminal.

use std::fs::File;
use std::io::Read;
use std::process::{Command, Output, Stdio};

use crate::{PROGRAM, bench};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use tests::bench::Bench;

/// `check` of a case with an error, in an environment of `variables` alone.
fn check(bench: &Bench, variables: &[(&str, &str)]) -> Command {
    let case = bench.tank("bad.toml", &[("end_time_s", "end_time")]);
    let mut command = Command::new(PROGRAM);
    command.arg("check").arg(case).env_clear().envs(variables.iter().copied()).stdin(Stdio::null());
    command
}

fn through_pipes(variables: &[(&str, &str)]) -> Output {
    let bench = bench();
    check(&bench, variables).output().unwrap()
}

/// What reaches a terminal as standard error.
fn on_terminal(variables: &[(&str, &str)]) -> String {
    let terminal = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&terminal).unwrap();
    unlockpt(&terminal).unwrap();
    let name = ptsname(&terminal, Vec::new()).unwrap();
    let slave = File::options().read(true).write(true).open(name.to_str().unwrap()).unwrap();
    let bench = bench();
    let mut child = {
        let mut command = check(&bench, variables);
        command.stdout(Stdio::null()).stderr(slave).spawn().unwrap()
    };
    let (mut shown, mut part) = (Vec::new(), [0; 4096]);
    let mut terminal = File::from(terminal);
    // When the last writer is gone, reading a terminal fails.
    while let Ok(count @ 1..) = terminal.read(&mut part) {
        shown.extend_from_slice(&part[..count]);
    }
    assert_eq!(child.wait().unwrap().code(), Some(2));
    String::from_utf8(shown).unwrap()
}

#[test]
fn a_terminal_gets_colours_unless_they_are_not_wanted() {
    let shown = on_terminal(&[("TERM", "xterm")]);
    assert!(shown.contains("\u{1b}[") && shown.contains("unknown key"), "{shown:?}");
    for variables in [
        &[("TERM", "xterm"), ("NO_COLOR", "1")][..],
        &[("TERM", "dumb")],
        &[("TERM", "xterm"), ("CLICOLOR", "0")],
    ] {
        let shown = on_terminal(variables);
        assert!(!shown.contains('\u{1b}') && shown.contains("unknown key"), "{variables:?} {shown:?}");
    }
}

#[test]
fn a_pipe_gets_no_colours_unless_they_are_demanded() {
    let plain = through_pipes(&[("TERM", "xterm")]);
    assert_eq!(plain.status.code(), Some(2));
    let text = String::from_utf8(plain.stderr).unwrap();
    assert!(text.starts_with("error: `time.end_time`") && !text.contains('\u{1b}'), "{text:?}");
    let forced = through_pipes(&[("CLICOLOR_FORCE", "1")]);
    assert!(String::from_utf8(forced.stderr).unwrap().contains("\u{1b}["));
}
