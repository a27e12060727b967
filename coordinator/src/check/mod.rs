//! A case without a run.

mod preview;

pub use preview::draw;

use std::path::Path;

use proto::service::{SetupProblems, SolverFactory, open_checked};
use sph::coupling::solver::Role;
use sph::setup::ParticipantSetup;

use crate::case::overrides::Override;
use crate::case::{Case, Server, Summary};
use crate::failure::Failure;
use crate::quote;

/// A case that a run accepts.
pub struct Checked {
    /// The case.
    pub case: Case,
    /// What a run of it would do.
    pub summary: Summary,
}

/// Checks the case file at `path` with `overrides` set over its values, as a run does before its first step.
///
/// # Errors
/// All errors of the file and of the overrides, and all that a built-in solver refuses.
pub fn check(path: &Path, overrides: &[Override]) -> Result<Checked, Failure> {
    let case = crate::run::load_with(path, overrides)?;
    crate::run::memory::check(&case)?;
    let opened = open(&case)?;
    for (role, limit) in opened.limits {
        case.check_stated_limit(role, limit)?;
    }
    let mut summary = case.summary();
    summary.warnings.extend(opened.remarks);
    summary.warnings.extend(opened.left_out);
    Ok(Checked { case, summary })
}

/// Memory of the solvers for each particle \[bytes\], measured; solids keep the pairs of their reference.
const FLUID_BYTES: usize = 130;
const SOLID_BYTES: usize = 1000;

/// Most memory that a check takes for a solver \[bytes\].
const MOST_BYTES: usize = 400 << 20;

/// What the solvers of this program say of a case.
#[derive(Clone, Debug, Default)]
pub struct Opened {
    /// Largest step \[s\] that each states for the start.
    pub limits: Vec<(Role, f64)>,
    /// What deserves a second look about the start, in words.
    pub remarks: Vec<String>,
    /// Solvers that were not asked, in words.
    pub left_out: Vec<String>,
}

/// Builds the solvers of this program for `case` as `Open` does at the start of a run; solvers that the case names are
/// left out, and those of scenes so large that a check would need much memory.
///
/// # Errors
/// All that a solver refuses.
pub fn open(case: &Case) -> Result<Opened, Failure> {
    let Opened { mut limits, mut remarks, mut left_out } = Opened::default();
    let [fluid, solid] = case.particles();
    let walls = case.wall_particles();
    let mut asked = |role: Role, server: &Server, bytes: usize| {
        let small = bytes <= MOST_BYTES;
        if *server == Server::BuiltIn && !small {
            let size = bytes >> 20;
            left_out.push(format!(
                "the {role} solver is asked when a run starts, not now: it needs some {size} MiB"
            ));
        }
        *server == Server::BuiltIn && small
    };
    // One after the other: each needs memory.
    if case.has(Role::Fluid) && asked(Role::Fluid, &case.servers.fluid, FLUID_BYTES * (fluid + walls)) {
        let setup = case.fluid_setup().map(ParticipantSetup::Fluid);
        limits.extend(try_open(Role::Fluid, &fluid_server::FluidFactory, setup, &mut remarks)?);
    }
    if case.has(Role::Solid)
        && asked(Role::Solid, &case.servers.solid, SOLID_BYTES * solid + FLUID_BYTES * walls)
    {
        let setup = case.solid_setup().map(ParticipantSetup::Solid);
        limits.extend(try_open(Role::Solid, &solid_server::SolidFactory, setup, &mut remarks)?);
    }
    Ok(Opened { limits, remarks, left_out })
}

fn try_open(
    role: Role,
    factory: &impl SolverFactory,
    setup: Option<ParticipantSetup>,
    remarks: &mut Vec<String>,
) -> Result<Option<(Role, f64)>, Failure> {
    let Some(setup) = setup else { return Ok(None) };
    let (opened, limit) = open_checked(factory, setup).map_err(|SetupProblems(problems)| {
        Failure::input(format!("the {role} solver refuses the case:\n  {}", problems.join("\n  ")))
    })?;
    remarks.extend(opened.solver.remarks());
    Ok(Some((role, limit)))
}

impl Checked {
    /// Counts, time steps, constants and warnings, in lines.
    pub fn text(&self) -> String {
        let summary = &self.summary;
        let mut text = format!("{}: no errors\n", summary.name);
        for Override { key, value } in self.case.overrides() {
            text.push_str(&quote::clean(&format!("  set: {key} = {value}\n")));
        }
        text.push_str("\nparticles\n");
        // Writing to a string cannot fail.
        let mut line = |line: String| {
            text.push_str(&quote::clean(&line));
            text.push('\n');
        };
        for count in &summary.counts {
            let held = if count.held > 0 { format!("  (and {} held)", count.held) } else { String::new() };
            line(format!("  {:>9}  {} {}{held}", count.particles, count.kind, count.name));
        }
        summary.adjusted.iter().for_each(|adjusted| line(format!("  {adjusted}")));
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
        line(format!("  {} steps; about {} on one core", summary.steps, duration(summary.forecast()),));
        line("\nconstants".into());
        summary.constants.iter().flat_map(|constant| broken(constant)).for_each(&mut line);
        if !summary.active_terms.is_empty() {
            line("\nactive terms".into());
            summary.active_terms.iter().for_each(|s| line(format!("  {}: {}", s.owner, s.text)));
        }
        if !summary.departures.is_empty() {
            line("\ndepartures from the recommended settings (docs/method.md)".into());
            summary.departures.iter().for_each(|departure| line(format!("  {departure}")));
        }
        if !summary.warnings.is_empty() {
            line("\nwarnings".into());
            summary.warnings.iter().for_each(|warning| line(format!("  {warning}")));
        }
        text
    }
}

/// `text` in lines of about 100 characters, broken after commas, all but the first indented further.
fn broken(text: &str) -> Vec<String> {
    let mut lines = vec!["  ".to_owned()];
    for part in text.split_inclusive(", ") {
        match lines.last_mut() {
            Some(line) if line.chars().count() + part.chars().count() <= 102 => line.push_str(part),
            _ => lines.push(format!("    {part}")),
        }
    }
    lines.iter().map(|line| line.trim_end().to_owned()).collect()
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 1e6 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.2e} days", s / 86_400.0),
    }
}
