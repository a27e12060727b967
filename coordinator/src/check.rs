//! `coordinator check`: a case without a run.

use terminal::say;

use crate::case::Summary;
use crate::cli::CheckArguments;
use crate::failure::Failure;
use crate::preview;

/// Checks a case file and prints what a run would do.
///
/// # Errors
/// All mistakes of the file; a picture that cannot be written.
pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let case = crate::run::load(&arguments.case)?;
    if arguments.resolved {
        say(case.resolved_toml().trim_end());
    } else {
        say(text(&case.summary()).trim_end());
    }
    if let Some(picture) = &arguments.picture {
        preview::draw(&case, picture)
            .map_err(|e| Failure::output(format!("cannot draw `{}`: {e:#}", picture.display())))?;
        terminal::note(format_args!("initial particles drawn to {}", picture.display()));
    }
    Ok(())
}

fn text(summary: &Summary) -> String {
    let mut text = format!("{}: no mistakes\n\nparticles\n", summary.name);
    // Writing to a string cannot fail.
    let mut line = |line: String| {
        text.push_str(&line);
        text.push('\n');
    };
    for count in &summary.counts {
        let held = if count.held > 0 { format!("  (and {} held)", count.held) } else { String::new() };
        line(format!("  {:>9}  {} {}{held}", count.particles, count.kind, count.name));
    }
    summary.cuts.iter().for_each(|cut| line(format!("  {cut}")));
    line("\ntime step".into());
    for limit in &summary.limits {
        line(format!(
            "  {:.3e} s stable, {:.3e} s recommended  ({})",
            limit.stability, limit.recommended, limit.origin
        ));
    }
    let kind = if summary.fixed { "fixed" } else { "first of an adaptive run" };
    line(format!(
        "  {:.3e} s chosen ({kind}): {:.2} of the stability limit, {:.2} of the recommended step",
        summary.time_step, summary.ratio_to_limit, summary.ratio_to_recommended
    ));
    if let Some(factor) = summary.limit_override {
        line(format!("  the case overrides the limit by a factor of {factor}"));
    }
    line(format!(
        "  {} steps; about {} on one core, at {}",
        summary.steps,
        duration(summary.forecast),
        summary.forecast_basis
    ));
    line("\nconstants".into());
    summary.constants.iter().for_each(|constant| line(format!("  {constant}")));
    if !summary.stabilisers.is_empty() {
        line("\nstabilisers".into());
        summary.stabilisers.iter().for_each(|s| line(format!("  {}: {}", s.owner, s.text)));
    }
    if !summary.warnings.is_empty() {
        line("\nwarnings".into());
        summary.warnings.iter().for_each(|warning| line(format!("  {warning}")));
    }
    text
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
