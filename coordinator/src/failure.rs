//! Failures of a command, by kind; the kind decides the exit code.

use std::process::ExitCode;

use crate::case::CaseErrors;
use crate::quote;

/// Kind of failure; each has an exit code of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The command line or the case is wrong.
    Input,
    /// An output cannot be written, or would overwrite something.
    Output,
    /// A server cannot be started or reached, or is not a fitting solver.
    Server,
    /// The physics broke down: not finite, a limit broken, particles lost.
    Diverged,
    /// The ledger does not balance, or frames were stale.
    Ledger,
    /// The partner or the connection was lost during the run.
    Lost,
    /// The run was stopped from outside before its end.
    Stopped,
    /// A participant fails a check of `conform`.
    Nonconforming,
    /// Recordings differ, or a replay from its recording.
    Different,
    /// The run reached its end with reservations that were to fail it.
    Reserved,
    /// Members of a sweep are not finished.
    Incomplete,
    /// A fault of this program.
    Internal,
}

impl Kind {
    /// All kinds, for the table in the help.
    pub const ALL: [Kind; 12] = [
        Kind::Input,
        Kind::Output,
        Kind::Server,
        Kind::Diverged,
        Kind::Ledger,
        Kind::Lost,
        Kind::Stopped,
        Kind::Nonconforming,
        Kind::Different,
        Kind::Reserved,
        Kind::Incomplete,
        Kind::Internal,
    ];

    /// All exit codes with their meaning, success first.
    pub fn codes() -> impl Iterator<Item = (u8, &'static str)> {
        std::iter::once((0, "success")).chain(Self::ALL.iter().map(|kind| (kind.code(), kind.meaning())))
    }

    /// Exit code; 0 is success and 2 is also what the command-line parser uses.
    pub fn code(self) -> u8 {
        match self {
            Kind::Input => 2,
            Kind::Output => 3,
            Kind::Server => 4,
            Kind::Diverged => 5,
            Kind::Ledger => 6,
            Kind::Lost => 7,
            Kind::Stopped => 8,
            Kind::Nonconforming => 9,
            Kind::Different => 10,
            Kind::Reserved => 11,
            Kind::Incomplete => 12,
            Kind::Internal => terminal::program::FAULT,
        }
    }

    /// Meaning in the help.
    pub fn meaning(self) -> &'static str {
        match self {
            Kind::Input => "the command line or the case file is wrong",
            Kind::Output => "an output cannot be written or would overwrite something",
            Kind::Server => "a server cannot be started or reached, or does not fit",
            Kind::Diverged => "the physics broke down, with the offending particle named",
            Kind::Ledger => "the ledger does not balance or a frame was stale",
            Kind::Lost => "a partner or a connection was lost during the run",
            Kind::Stopped => "stopped from outside before the end, outputs complete; `resume` continues",
            Kind::Nonconforming => "a participant fails a check of `conform`",
            Kind::Different => "two recordings differ, or a replay from its recording",
            Kind::Reserved => "completed with reservations, and `--strict` was given; outputs complete",
            Kind::Incomplete => "members of a sweep failed or are not finished, the others are complete",
            Kind::Internal => "a fault of this program",
        }
    }
}

/// A failed command: what happened and which kind it is.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    /// Kind, for the exit code.
    pub kind: Kind,
    /// What happened, where, what is allowed and what to do; nothing in it acts on a terminal.
    pub message: String,
    /// The same with the colours of a terminal, where there is such a form.
    pub styled: Option<String>,
}

impl Failure {
    /// A failure of `kind`.
    pub fn new(kind: Kind, message: impl Into<String>) -> Self {
        Self { kind, message: quote::clean(&message.into()).into_owned(), styled: None }
    }

    /// Errors of a case file.
    pub fn case_errors(errors: &CaseErrors) -> Self {
        // Both forms are clean already, and a list of errors may have long lines.
        Self { kind: Kind::Input, message: errors.to_string(), styled: Some(errors.render(true)) }
    }

    /// The message, with colours if there are and `colours` are wanted.
    pub fn text(&self, colours: bool) -> &str {
        self.styled.as_deref().filter(|_| colours).unwrap_or(&self.message)
    }

    /// The command line or the case is wrong.
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(Kind::Input, message)
    }

    /// An output cannot be written.
    pub fn output(message: impl Into<String>) -> Self {
        Self::new(Kind::Output, message)
    }

    /// A server cannot be started or reached, or does not fit.
    pub fn server(message: impl Into<String>) -> Self {
        Self::new(Kind::Server, message)
    }

    /// A fault of this program.
    pub fn internal(message: impl Into<String>) -> Self {
        Self::new(Kind::Internal, message)
    }

    /// Exit code of the process.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.kind.code())
    }
}
