//! Runs a case at several spacings, sound speeds and seeds, and prints spread and trend of key figures.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use coordinator::case::overrides::Override;
use coordinator::family::figures::Figure;
use coordinator::family::{Family, FamilyRequest, FigureResult, Resolution};
use coordinator::run::{RunOptions, RunRequest};
use terminal::say;

/// Runs a case at several spacings, sound speeds and seeds, one after another, and prints mean and spread of each key
/// figure at each resolution, and what they do under refinement. Finished runs in the folder are kept.
#[derive(Debug, Parser)]
struct Arguments {
    /// Case file.
    case: PathBuf,
    /// Spacings \[m\]; that of the case when left out.
    #[arg(long, value_delimiter = ',')]
    spacings: Vec<f64>,
    /// Sound speeds \[m/s\]; that of the case when left out.
    #[arg(long, value_delimiter = ',')]
    sound_speeds: Vec<f64>,
    /// Seeds of the displacement of the water: 1 to this number. None when left out.
    #[arg(long, default_value_t = 0)]
    seeds: u64,
    /// Key figure, such as `body_centre_y_m at 0.15 s`; repeat for several.
    #[arg(long = "figure", value_name = "FIGURE")]
    figures: Vec<Figure>,
    /// Value set over the case, `KEY=VALUE`; repeat for several.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Override::parse)]
    overrides: Vec<Override>,
    /// Compute threads of each solver; all cores when left out.
    #[arg(long)]
    threads: Option<u16>,
    /// Folder of the family.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Repeat finished runs.
    #[arg(long)]
    fresh: bool,
}

fn main() -> ExitCode {
    terminal::program::run(|| match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            terminal::note(message);
            ExitCode::FAILURE
        }
    })
}

fn run(arguments: Arguments) -> Result<(), String> {
    let request = FamilyRequest {
        run: RunRequest {
            case: arguments.case,
            overrides: arguments.overrides,
            out: arguments.out,
            options: RunOptions { threads: arguments.threads, ..RunOptions::default() },
            ..RunRequest::default()
        },
        spacings: arguments.spacings,
        sound_speeds: arguments.sound_speeds,
        seeds: (1..=arguments.seeds).collect(),
        figures: arguments.figures,
        fresh: arguments.fresh,
        ..FamilyRequest::default()
    };
    let family = coordinator::family::run(&request, |line| say(line)).map_err(|failure| failure.message)?;
    print(&family);
    match family.members.iter().filter(|member| member.outcome.is_err()).count() {
        0 => Ok(()),
        failed => Err(format!("{failed} of {} runs failed", family.members.len())),
    }
}

fn print(family: &Family) {
    for FigureResult { figure, values, over_spacing, over_sound_speed } in &family.figures {
        say(format_args!("{figure}"));
        for value in values {
            say(format_args!("  {}", line(value)));
        }
        for (speed, trend) in over_spacing {
            let at = speed.map_or(String::new(), |speed| format!(" at c0 {speed} m/s"));
            say(format_args!("  over spacing{at}: {trend}"));
        }
        for (spacing, trend) in over_sound_speed {
            say(format_args!("  over sound speed at {spacing} m: {trend}"));
        }
    }
    say(format_args!("results in {}", family.folder.display()));
}

/// One resolution.
fn line(at: &Resolution) -> String {
    let mut line = format!("{} m", at.spacing_m);
    if let Some(speed) = at.sound_speed_m_s {
        line.push_str(&format!(", c0 {speed} m/s"));
    }
    match &at.spread {
        None => line.push_str(": no value"),
        Some(spread) => {
            line.push_str(&format!(": {:.5e}", spread.mean));
            if let Some(deviation) = spread.deviation {
                let (from, to) = (spread.smallest, spread.largest);
                line.push_str(&format!(" +- {deviation:.1e}, {from:.5e} to {to:.5e}, {} runs", spread.count));
            }
        }
    }
    if at.missing > 0 {
        line.push_str(&format!(", {} without a value", at.missing));
    }
    line
}
