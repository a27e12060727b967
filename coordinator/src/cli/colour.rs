//! Whether messages on standard error have colours.

use std::ffi::OsString;
use std::io::IsTerminal;

/// Whether standard error shows colours; the rules are those of the parser of the command line.
pub fn on_stderr() -> bool {
    wanted(|name| std::env::var_os(name), std::io::stderr().is_terminal())
}

/// `NO_COLOR` forbids colours, `CLICOLOR_FORCE` demands them, `CLICOLOR=0` leaves them out; otherwise a terminal that
/// is not dumb gets them.
fn wanted(variable: impl Fn(&str) -> Option<OsString>, is_terminal: bool) -> bool {
    let set = |name| variable(name).is_some_and(|value| !value.is_empty());
    let is = |name, value: &str| variable(name).is_some_and(|found| found == value);
    if set("NO_COLOR") {
        false
    } else if set("CLICOLOR_FORCE") && !is("CLICOLOR_FORCE", "0") {
        true
    } else {
        is_terminal && !is("CLICOLOR", "0") && set("TERM") && !is("TERM", "dumb")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(variables: &[(&str, &str)], is_terminal: bool) -> bool {
        let found = |name: &str| {
            let value = variables.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
            value.map(OsString::from)
        };
        wanted(found, is_terminal)
    }

    #[test]
    fn a_terminal_has_colours_and_a_file_has_none() {
        let term = ("TERM", "xterm-256color");
        assert!(with(&[term], true));
        assert!(!with(&[term], false));
        assert!(!with(&[("TERM", "dumb")], true) && !with(&[], true));
    }

    #[test]
    fn variables_decide_before_the_terminal_does() {
        let term = ("TERM", "xterm");
        assert!(!with(&[term, ("NO_COLOR", "1")], true));
        assert!(!with(&[term, ("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")], true));
        assert!(with(&[term, ("NO_COLOR", "")], true), "an empty value is none");
        assert!(with(&[("CLICOLOR_FORCE", "1")], false));
        assert!(!with(&[("CLICOLOR_FORCE", "0")], false));
        assert!(!with(&[term, ("CLICOLOR", "0")], true));
    }
}
