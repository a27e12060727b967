//! Colours of what a program prints: on a terminal that shows them, nowhere else.

use std::ffi::OsString;
use std::fmt::Display;
use std::io::IsTerminal;

use anstyle::{AnsiColor, Effects};

/// What a text says, which decides its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// All is well.
    Good,
    /// It deserves a second look.
    Doubt,
    /// It failed.
    Bad,
    /// The name of what follows.
    Heading,
}

/// Whether texts get colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Style {
    coloured: bool,
}

impl Style {
    /// No colours.
    pub const PLAIN: Self = Self { coloured: false };

    /// What standard output shows; the rules are those of the parser of the command line.
    pub fn of_output() -> Self {
        Self::of(std::io::stdout().is_terminal())
    }

    /// What standard error shows, likewise.
    pub fn of_errors() -> Self {
        Self::of(std::io::stderr().is_terminal())
    }

    fn of(is_terminal: bool) -> Self {
        Self { coloured: wanted(|name| std::env::var_os(name), is_terminal) }
    }

    /// Whether there are colours.
    pub fn is_coloured(self) -> bool {
        self.coloured
    }

    /// `text` in the colour of `tone`.
    pub fn paint(self, tone: Tone, text: impl Display) -> String {
        if !self.coloured {
            return text.to_string();
        }
        let style = match tone {
            Tone::Good => AnsiColor::Green.on_default().effects(Effects::BOLD),
            Tone::Doubt => AnsiColor::Yellow.on_default().effects(Effects::BOLD),
            Tone::Bad => AnsiColor::Red.on_default().effects(Effects::BOLD),
            Tone::Heading => AnsiColor::Cyan.on_default(),
        };
        format!("{style}{text}{style:#}")
    }
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
    fn a_plain_style_leaves_texts_and_a_coloured_one_ends_what_it_begins() {
        assert_eq!(Style::PLAIN.paint(Tone::Bad, "failed"), "failed");
        let painted = Style { coloured: true }.paint(Tone::Bad, "failed");
        assert!(painted.starts_with("\u{1b}[") && painted.ends_with("\u{1b}[0m"), "{painted:?}");
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
