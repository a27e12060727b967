//! Examines a participant of any make.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use proto::conform::{Check, Options, Outcome, Report, Verdict, examine};
use proto::transport::security::{ClientFiles, ClientSecurity};
use sph::setup::CouplingKind;

use crate::failure::Failure;
use crate::messages::Messages;
use crate::results::files::write_file;
use crate::run::participants::hints;

/// A participant to examine, and how.
#[derive(Clone, Debug)]
pub struct ConformRequest {
    /// Its address.
    pub address: String,
    /// File for the outcome as JUnit XML.
    pub junit: Option<PathBuf>,
    /// Kind of coupling to examine, `None` for the first that the solver offers.
    pub kind: Option<CouplingKind>,
    /// Number of dimensions of the runs of the examination, 2 or 3.
    pub dimensions: u32,
    /// Only checks with this in their name.
    pub only: Option<String>,
    /// Address of another process of the same solver, into which checkpoints are restored.
    pub fresh: Option<String>,
    /// Certificates and token.
    pub security: ClientFiles,
    /// Longest wait for any one answer.
    pub deadline: Duration,
    /// What is printed.
    pub messages: Messages,
}

impl ConformRequest {
    /// All checks of the participant at `address`.
    pub fn new(address: impl Into<String>) -> Self {
        Self {
            address: address.into(),
            junit: None,
            kind: None,
            dimensions: 2,
            only: None,
            fresh: None,
            security: ClientFiles::default(),
            deadline: Duration::from_secs(10),
            messages: Messages::None,
        }
    }
}

/// Examines a participant, calls `each` after each check and writes the JUnit file. The report says which checks failed.
///
/// # Errors
/// When nothing answers at the address, or a file cannot be written.
pub fn conform(request: &ConformRequest, each: impl FnMut(&Outcome)) -> Result<Report, Failure> {
    let address = &request.address;
    if let Some(only) = request.only.as_deref()
        && !Check::ALL.iter().any(|check| check.name().contains(only))
    {
        return Err(Failure::input(format!("no check has {only:?} in its name; `--list` shows all names")));
    }
    let options = Options {
        deadline: request.deadline,
        kind: request.kind,
        dimensions: request.dimensions,
        fresh: request.fresh.clone(),
        only: request.only.clone(),
        security: ClientSecurity::load(&request.security).map_err(Failure::input)?,
    };
    for warning in options.security.warnings() {
        request.messages.warning(warning);
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|e| Failure::internal(format!("cannot start the runtime: {e}")))?;
    let report = runtime.block_on(examine(address, &options, each));
    runtime.shutdown_background();
    let report = report.map_err(|error| {
        let remedy = hints::of_secrets(&error, &options.security).map(|remedy| format!("; {remedy}"));
        let failure = Failure::from(error);
        Failure { message: failure.message + &remedy.unwrap_or_default(), ..failure }
    })?;
    if let Some(path) = &request.junit {
        write_junit(path, address, &report)?;
    }
    Ok(report)
}

/// A verdict in words, and its reason.
pub(crate) fn words(verdict: &Verdict) -> (&'static str, &str) {
    match verdict {
        Verdict::Passed(text) => ("passed", text),
        Verdict::Failed(text) => ("FAILED", text),
        Verdict::NotOffered(text) => ("not offered", text),
    }
}

/// Writes the report in the form that test viewers read.
fn write_junit(path: &Path, address: &str, report: &Report) -> Result<(), Failure> {
    write_file(path, |file| file.write_all(junit(address, report).as_bytes()))?;
    Ok(())
}

fn junit(address: &str, report: &Report) -> String {
    let suite = escaped(&format!("conform {} {address}", report.description.name));
    let skipped = report.outcomes.iter().filter(|o| matches!(o.verdict, Verdict::NotOffered(_))).count();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite name=\"{suite}\" tests=\"{}\" failures=\"{}\" \
         skipped=\"{skipped}\">\n",
        report.outcomes.len(),
        report.failures()
    );
    for outcome in &report.outcomes {
        let inner = match &outcome.verdict {
            Verdict::Passed(text) => format!("<system-out>{}</system-out>", escaped(text)),
            Verdict::Failed(text) => format!("<failure message=\"{}\"/>", escaped(text)),
            Verdict::NotOffered(text) => format!("<skipped message=\"{}\"/>", escaped(text)),
        };
        text.push_str(&format!(
            "<testcase classname=\"conform\" name=\"{}\" time=\"{:.3}\">{inner}</testcase>\n",
            outcome.check.name(),
            outcome.elapsed.as_secs_f64()
        ));
    }
    text.push_str("</testsuite>\n</testsuites>\n");
    text
}

/// `text` as the value of an XML attribute or as content.
fn escaped(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '&' => "&amp;".into(),
            '<' => "&lt;".into(),
            '>' => "&gt;".into(),
            '"' => "&quot;".into(),
            '\n' => "&#10;".into(),
            // Not allowed in XML at all.
            c if c.is_control() => " ".into(),
            c => c.to_string(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_participant_says_cannot_break_the_file() {
        assert_eq!(escaped("a<b & \"c\"\n\u{1}"), "a&lt;b &amp; &quot;c&quot;&#10; ");
    }

    #[test]
    fn names_of_checks_are_told_apart() {
        let mut names: Vec<&str> = Check::ALL.iter().map(|check| check.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Check::ALL.len());
        assert!(names.iter().all(|name| name.len() <= 22), "the table's column");
    }
}
