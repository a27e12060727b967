//! `coordinator conform`: examines a participant, whoever wrote it.

use std::io::Write;
use std::path::Path;
use std::time::Duration;

use proto::conform::{Check, Options, Outcome, Report, Verdict, examine};
use proto::security::{ClientFiles, ClientSecurity};
use sph::setup::CouplingKind;
use terminal::say;

use crate::cli::ConformArguments;
use crate::failure::{Failure, Kind};
use crate::results::files::write_file;
use crate::run::participants::hints;

/// Examines the participant at the given address, prints a table and writes the JUnit file.
///
/// # Errors
/// When nothing answers there, a file cannot be written, or a check fails.
pub fn conform(arguments: &ConformArguments) -> Result<(), Failure> {
    if arguments.list {
        for check in Check::ALL {
            say(format_args!("{:22} {}", check.name(), check.what()));
        }
        return Ok(());
    }
    let Some(address) = &arguments.address else {
        return Err(Failure::input(
            "give the address of a running solver, such as 127.0.0.1:7001, or `--list`",
        ));
    };
    if let Some(only) = arguments.only.as_deref()
        && !Check::ALL.iter().any(|check| check.name().contains(only))
    {
        return Err(Failure::input(format!("no check has {only:?} in its name; `--list` shows all names")));
    }
    let options = Options {
        deadline: Duration::from_secs(arguments.deadline),
        kind: arguments.kind,
        fresh: arguments.fresh.clone(),
        only: arguments.only.clone(),
        security: ClientSecurity::load(&arguments.security.over(&ClientFiles::default()))
            .map_err(Failure::input)?,
    };
    for warning in options.security.warnings() {
        terminal::note(format_args!("warning: {warning}"));
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|e| Failure::internal(format!("cannot start the runtime: {e}")))?;
    let report = runtime.block_on(examine(address, &options, print));
    runtime.shutdown_background();
    let report = report.map_err(|error| {
        let remedy = hints::of_secrets(&error, &options.security).map(|remedy| format!("; {remedy}"));
        let failure = Failure::from(error);
        Failure { message: failure.message + &remedy.unwrap_or_default(), ..failure }
    })?;
    print_end(address, &report);
    if let Some(path) = &arguments.junit {
        write_junit(path, address, &report)?;
    }
    match report.failures() {
        0 => Ok(()),
        failures => Err(Failure::new(
            Kind::Nonconforming,
            format!("{address} fails {failures} of {} checks", report.outcomes.len()),
        )),
    }
}

/// The kind of coupling that a word on the command line names.
///
/// # Errors
/// Another word.
pub fn coupling_kind(word: &str) -> Result<CouplingKind, String> {
    let named = CouplingKind::ALL.into_iter().find(|kind| kind.name() == word);
    named.ok_or_else(|| "must be `states` or `loads`".into())
}

fn words(verdict: &Verdict) -> (&'static str, &str) {
    match verdict {
        Verdict::Passed(text) => ("passed", text),
        Verdict::Failed(text) => ("FAILED", text),
        Verdict::NotOffered(text) => ("not offered", text),
    }
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
        "\n{} {} at {address}, as {}, coupled by {}: {} passed, {} failed, {} not offered",
        description.name,
        description.version,
        report.role,
        report.kind.name(),
        count("passed"),
        count("FAILED"),
        count("not offered")
    ));
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
        .map(|letter| match letter {
            '&' => "&amp;".into(),
            '<' => "&lt;".into(),
            '>' => "&gt;".into(),
            '"' => "&quot;".into(),
            '\n' => "&#10;".into(),
            // Not allowed in XML at all.
            letter if letter.is_control() => " ".into(),
            letter => letter.to_string(),
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
