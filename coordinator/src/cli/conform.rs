//! `tidelock conform`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use proto::conform::{Check, Outcome, Report};
use sph::setup::CouplingKind;
use terminal::say;

use super::security::SecurityArguments;
use crate::conform::{self, ConformRequest, words};
use crate::failure::{Failure, Kind};
use crate::messages::Messages;

/// Arguments of `conform`.
#[derive(Debug, Args)]
pub(super) struct ConformArguments {
    /// Address of the solver.
    #[arg(value_name = "HOST:PORT")]
    address: Option<String>,
    /// Write the outcome to this file as JUnit XML.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Kind of coupling to examine [default: the first that the solver offers].
    #[arg(long, value_name = "KIND", value_parser = coupling_kind)]
    kind: Option<CouplingKind>,
    /// Number of dimensions of the runs of the examination, 2 or 3.
    #[arg(long, value_name = "D", default_value_t = 2, value_parser = clap::value_parser!(u32).range(2..=3))]
    dimensions: u32,
    /// Only checks with this in their name.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Address of another process of the same solver, into which checkpoints are restored.
    #[arg(long, value_name = "HOST:PORT")]
    fresh: Option<String>,
    /// TLS and token settings for remote solvers.
    #[command(flatten)]
    security: SecurityArguments,
    /// Longest wait for any one answer, in seconds.
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=600))]
    deadline: u64,
    /// List the checks.
    #[arg(long)]
    list: bool,
}

impl ConformArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        if self.list {
            for check in Check::ALL {
                say(format_args!("{:22} {}", check.name(), check.what()));
            }
            return Ok(());
        }
        let Some(address) = self.address else {
            return Err(Failure::input(
                "give the address of a running solver, such as 127.0.0.1:7001, or `--list`",
            ));
        };
        let request = ConformRequest {
            address,
            junit: self.junit,
            kind: self.kind,
            dimensions: self.dimensions,
            only: self.only,
            fresh: self.fresh,
            security: self.security.into(),
            deadline: Duration::from_secs(self.deadline),
            messages: Messages::All,
        };
        let report = conform::conform(&request, print)?;
        let address = &request.address;
        print_end(address, &report);
        match report.failures() {
            0 => Ok(()),
            failures => Err(Failure::new(
                Kind::Nonconforming,
                format!("{address} fails {failures} of {} checks", report.outcomes.len()),
            )),
        }
    }
}

/// The kind of coupling of that name.
fn coupling_kind(word: &str) -> Result<CouplingKind, String> {
    let named = CouplingKind::ALL.into_iter().find(|kind| kind.name() == word);
    named.ok_or_else(|| "must be `states` or `loads`".into())
}

fn print(outcome: &Outcome) {
    let (word, text) = words(&outcome.verdict);
    let seconds = outcome.elapsed.as_secs_f64();
    say(format_args!("{:22} {word:12} {seconds:6.2} s  {text}", outcome.check.name()));
}

fn print_end(address: &str, report: &Report) {
    let count = |word: &str| report.outcomes.iter().filter(|o| words(&o.verdict).0 == word).count();
    let description = &report.description;
    say(format_args!(
        "\n{} {} at {address}, as {} in {} dimensions, coupled by {}: {} passed, {} failed, {} not offered",
        description.name,
        description.version,
        report.role,
        report.dimensions,
        report.kind.name(),
        count("passed"),
        count("FAILED"),
        count("not offered")
    ));
}
