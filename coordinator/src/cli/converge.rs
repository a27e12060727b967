//! `tidelock converge` and `tidelock ensemble`.

use std::path::PathBuf;

use clap::Args;
use terminal::say;

use super::many::{ManyRuns, ManyRunsArguments, progress};
use crate::failure::{Failure, Kind};
use crate::family::verdict::{self, TOLERANCE};
use crate::family::{self, Family, FamilyRequest, by_probe, defaults, page};
use crate::messages::Messages;
use crate::overlay::output::aligned;
use crate::run::load_with;

/// Most key figures that are printed each in a line of its own; of more there is a line for each probe.
const MOST_READ: usize = 24;

/// Arguments of `converge`.
#[derive(Debug, Args)]
pub(super) struct ConvergeArguments {
    /// Case file, TOML; see cases/FORMAT.md.
    case: PathBuf,
    /// Spacings in metres, at least three for an order [default: that of the case, 1.5 and 2.25 times it].
    #[arg(long, value_delimiter = ',', value_name = "M,M,M")]
    spacings: Vec<f64>,
    /// Sound speeds of the water in m/s [default: that of the case and 2/3 of it].
    #[arg(long, value_delimiter = ',', value_name = "C,C")]
    sound_speeds: Vec<f64>,
    /// Seeds 1 to N at every resolution, where the motion is chaotic: differences within their spread are chance.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u64).range(..=10_000))]
    seeds: u64,
    /// Largest estimated error over the value at which a key figure counts as converged.
    #[arg(long, value_name = "SHARE", default_value_t = TOLERANCE)]
    tolerance: f64,
    #[command(flatten)]
    many: ManyRunsArguments,
}

/// Arguments of `ensemble`.
#[derive(Debug, Args)]
pub(super) struct EnsembleArguments {
    /// Case file, TOML; see cases/FORMAT.md.
    case: PathBuf,
    /// Members, with seeds 1 to N: each starts with its water particles displaced by a little.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(2..=10_000))]
    seeds: u64,
    /// Largest displacement along each axis over the spacing.
    #[arg(long, value_name = "SHARE", default_value_t = FamilyRequest::default().displacement_fraction)]
    displacement_fraction: f64,
    #[command(flatten)]
    many: ManyRunsArguments,
}

fn request(many: ManyRuns) -> FamilyRequest {
    let ManyRuns { run, figures, jobs, fresh } = many;
    FamilyRequest { run, figures, jobs, fresh, ..FamilyRequest::default() }
}

impl ConvergeArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        let tolerance = self.tolerance;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Failure::input("`--tolerance` must be a number above 0, such as 0.05"));
        }
        let mut request = request(self.many.of(self.case, "_convergence"));
        request.seeds = (1..=self.seeds).collect();
        (request.spacings, request.sound_speeds) = (self.spacings, self.sound_speeds);
        let case = load_with(&request.run.case, &request.run.overrides)?;
        if request.spacings.is_empty() {
            request.spacings = defaults::spacings(&case);
        }
        if request.sound_speeds.is_empty() {
            request.sound_speeds = defaults::sound_speeds(&case);
        }
        let family = family::run(&request, progress(&request.run.options))?;
        let verdicts = verdict::verdicts(&family, tolerance);
        let mut spacings = request.spacings.clone();
        spacings.sort_by(|a, b| b.total_cmp(a));
        let groups = match verdicts.len() > MOST_READ {
            true => {
                let probes: Vec<&str> =
                    case.file().probes.iter().map(|probe| probe.name.value.as_str()).collect();
                by_probe::groups(&verdicts, &probes)
            }
            false => Vec::new(),
        };
        let mut rows = Vec::new();
        if groups.is_empty() || request.run.options.messages >= Messages::Details {
            rows.push(page::convergence_heads(&spacings));
            rows.extend(verdicts.iter().map(page::convergence_row));
        } else {
            rows.push(page::PROBE_HEADS.map(str::to_owned).to_vec());
            rows.extend(groups.iter().map(page::probe_row));
        }
        aligned(&rows).iter().for_each(say);
        let left_out = family.figures.len() - verdicts.len();
        if left_out > 0 {
            say(format_args!("{left_out} key figures are the same at all resolutions, or as another"));
        }
        say(verdict::sentence(&verdicts, tolerance));
        let page = page::write_convergence(&family, &verdicts, &groups, &spacings, tolerance)?;
        let hint = if groups.is_empty() { "" } else { " (every key figure; here with `-v`)" };
        say(format_args!("page: {}{hint}", page.display()));
        finish(&family)
    }
}

impl EnsembleArguments {
    pub(super) fn execute(self) -> Result<(), Failure> {
        let mut request = request(self.many.of(self.case, "_ensemble"));
        request.seeds = (1..=self.seeds).collect();
        request.displacement_fraction = self.displacement_fraction;
        let family = family::run(&request, progress(&request.run.options))?;
        let mut rows = vec![page::ENSEMBLE_HEADS.map(str::to_owned).to_vec()];
        rows.extend(family.figures.iter().filter_map(page::ensemble_row));
        aligned(&rows).iter().for_each(say);
        say(format_args!("page: {}", page::write_ensemble(&family)?.display()));
        finish(&family)
    }
}

/// Names the members that failed; the exit code is that of the first.
fn finish(family: &Family) -> Result<(), Failure> {
    let mut failed = Vec::new();
    let mut kind = None;
    for member in &family.members {
        if let Err(failure) = &member.outcome {
            kind.get_or_insert(failure.kind);
            failed.push(format!("{}: {}", member.place.label(), failure.message));
        }
    }
    let Some(kind) = kind else { return Ok(()) };
    let hint = match kind {
        Kind::Input => "\nchoose other resolutions by `--spacings` and `--sound-speeds`, or correct the case",
        _ => "",
    };
    let (count, all) = (failed.len(), family.members.len());
    Err(Failure::new(kind, format!("{count} of {all} runs failed\n  {}{hint}", failed.join("\n  "))))
}
