//! The verification suite: runs cases with known answers, writes tables and plots, exits with 1 when a goal is missed.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use terminal::say;
use tests::validation::report::{self, Row};
use tests::validation::runner::Options;
use tests::validation::{Case, Member, Run, cases, regression, template};

/// Runs the verification suite: cases with known answers at several resolutions, judged by figures.
///
/// Writes `validation.csv`, `validation.md` and a plot per case into the output folder, and each run into a folder of
/// its own below it. Exit code: 0 all goals met, 1 a goal missed or a run failed, 2 a mistake on the command line.
#[derive(Debug, Parser)]
#[command(name = "validate", version)]
struct Arguments {
    /// Cases to run; all when left out.
    cases: Vec<String>,
    /// Only the short members.
    #[arg(long)]
    quick: bool,
    /// Only members at this particle spacing, in metres.
    #[arg(long, value_name = "METRES")]
    spacing: Option<f64>,
    /// Only members of this scheme.
    #[arg(long)]
    scheme: Option<String>,
    /// Folder for the results.
    #[arg(long, value_name = "DIR", default_value = "results/validation")]
    out: PathBuf,
    /// Do not run again what is in the folder already from the same case file.
    #[arg(long)]
    reuse: bool,
    /// Compute threads [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<u16>,
    /// Replace a value in every case file, such as `fluid.artificial_viscosity_a=0.2`.
    #[arg(long, value_name = "PATH=VALUE", value_parser = change)]
    set: Vec<(String, toml::Value)>,
    /// Store the figures of the short members as those of the regression test.
    #[arg(long, requires = "quick", conflicts_with_all = ["spacing", "scheme", "set"])]
    store: bool,
    /// List the cases and their members.
    #[arg(long)]
    list: bool,
}

fn change(text: &str) -> Result<(String, toml::Value), String> {
    let (path, value) = text.split_once('=').ok_or("expected PATH=VALUE")?;
    let mut table: toml::Table = format!("value = {value}").parse().map_err(|e| format!("{e}"))?;
    table.remove("value").map(|value| (path.to_owned(), value)).ok_or_else(|| "no value".into())
}

impl Arguments {
    fn takes(&self, member: &Member) -> bool {
        (member.quick || !self.quick)
            && self.spacing.is_none_or(|spacing| spacing == member.spacing)
            && self.scheme.as_ref().is_none_or(|scheme| scheme == member.scheme)
    }
}

fn main() -> ExitCode {
    terminal::program::run(|| run(Arguments::parse()))
}

fn run(arguments: Arguments) -> ExitCode {
    let all = cases::all();
    if let Some(unknown) = arguments.cases.iter().find(|name| !all.iter().any(|case| case.name() == **name)) {
        let names: Vec<&str> = all.iter().map(|case| case.name()).collect();
        terminal::note(format_args!("error: no case `{unknown}`; there are {}", names.join(", ")));
        return ExitCode::from(2);
    }
    let chosen =
        |case: &&dyn Case| arguments.cases.is_empty() || arguments.cases.iter().any(|n| n == case.name());
    if arguments.list {
        list(all.iter().copied().filter(chosen), &arguments);
        return ExitCode::SUCCESS;
    }
    let options = Options {
        out: arguments.out.clone(),
        threads: arguments.threads,
        changes: arguments.set.clone(),
        reuse: arguments.reuse,
    };
    let mut rows: Vec<Row> = Vec::new();
    let mut failed = false;
    for case in all.iter().copied().filter(chosen) {
        match run_case(case, &arguments, &options) {
            Ok(found) => rows.extend(found),
            Err(reason) => {
                terminal::note(format_args!("{}: {reason}", case.name()));
                failed = true;
            }
        }
        if let Err(reason) = std::fs::create_dir_all(&options.out)
            .map_err(|e| e.to_string())
            .and_then(|()| report::write(&options.out, &rows))
        {
            terminal::note(format_args!("error: {reason}"));
            return ExitCode::from(1);
        }
    }
    let judged = || rows.iter().filter_map(|row| row.figure.passes());
    let (met, missed) = (judged().filter(|met| *met).count(), judged().filter(|met| !*met).count());
    say(format_args!(
        "{met} goals met, {missed} missed; table in {}",
        options.out.join("validation.md").display()
    ));
    ExitCode::from(u8::from(failed || missed > 0))
}

fn list<'a>(cases: impl Iterator<Item = &'a dyn Case>, arguments: &Arguments) {
    for case in cases {
        say(format_args!("{}: {}", case.name(), case.about()));
        for member in case.members().iter().filter(|member| arguments.takes(member)) {
            let file = template::folder().join(member.file).with_extension("toml");
            let quick = if member.quick { "  (quick)" } else { "" };
            say(format_args!("    {} {} m{quick}  {}", member.scheme, member.spacing, file.display()));
        }
    }
}

/// Runs the members of `case`, prints and returns its rows and draws its plots.
fn run_case(case: &dyn Case, arguments: &Arguments, options: &Options) -> Result<Vec<Row>, String> {
    say(format_args!("{}: {}", case.name(), case.about()));
    let mut runs = Vec::new();
    let mut failures = Vec::new();
    for member in case.members().into_iter().filter(|member| arguments.takes(member)) {
        let started = Instant::now();
        let label = member.label();
        match Run::of(case, member, options) {
            Ok(run) => {
                say(format_args!("  ran {label} in {:.1} s", started.elapsed().as_secs_f64()));
                for doubt in run.doubts() {
                    say(format_args!("    {doubt}"));
                }
                runs.push(run);
            }
            Err(reason) => failures.push(reason),
        }
    }
    let mut results = Vec::new();
    for run in &runs {
        results.push((run, case.figures(run)?));
    }
    let compared = case.comparison(&runs)?;
    if arguments.store {
        for (run, figures) in &results {
            regression::store(case.name(), &run.member.label(), figures)?;
        }
        if !compared.is_empty() {
            regression::store(case.name(), regression::COMPARISON, &compared)?;
        }
    }
    if let Some((_, figures)) = results.last_mut() {
        figures.extend(compared);
    }
    let rows = report::rows(case.name(), &results);
    report::print(&rows);
    std::fs::create_dir_all(&options.out).map_err(|e| e.to_string())?;
    for plot in case.plots(&runs)? {
        plot.write(&options.out.join(format!("{}_{}.svg", case.name(), plot.name)))?;
    }
    if failures.is_empty() {
        Ok(rows)
    } else {
        report::write(&options.out, &rows)?;
        Err(failures.join("\n"))
    }
}
