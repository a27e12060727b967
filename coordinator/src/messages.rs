//! What a command prints on standard error while it works.

use std::fmt::Display;

use terminal::style::{Style, Tone};

/// Which messages are printed. A failure is never printed here: it is returned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Messages {
    /// None.
    #[default]
    None,
    /// Warnings, restarts of servers and stops.
    Warnings,
    /// Also the verdict of a run.
    Verdict,
    /// Also the run header, the progress and the results.
    All,
    /// Also all that decides the results.
    Details,
}

impl Messages {
    /// Prints a warning with its mark.
    pub fn warning(self, text: impl Display) {
        self.notice(format_args!("{} {text}", Style::of_errors().paint(Tone::Doubt, "warning:")));
    }

    /// Prints what concerns the user whether or not he follows the progress.
    pub fn notice(self, text: impl Display) {
        if self >= Messages::Warnings {
            terminal::note(text);
        }
    }

    /// Prints a line of the progress.
    pub fn progress(self, text: impl Display) {
        if self >= Messages::All {
            terminal::note(text);
        }
    }
}
