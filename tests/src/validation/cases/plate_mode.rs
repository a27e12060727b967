//! The first bending mode of the plate of case 5.2, in air and in still water: what is meant for sound leaves it alone.

use std::f64::consts::TAU;

use crate::validation::cases::floating::coupling;
use crate::validation::{Case, Figure, Member, Plot, Run, series};

/// See the module.
pub struct PlateMode;

/// When the load ends \[s\].
const RELEASE: f64 = 0.3;
/// Start of what is fitted: the higher modes that the release excites have decayed \[s\].
const FITTED: f64 = 0.32;

/// Scheme with the defaults.
const WATER: &str = "in water";
/// Scheme without acoustic relaxation and volume correction.
const PLAIN: &str = "in water, without relaxation and volume correction";
/// Scheme without water.
const AIR: &str = "in air";

/// Displacement of the tip \[m\] over time.
fn tip(run: &Run) -> Result<Vec<(f64, f64)>, String> {
    run.history("tip_displacement_x_m")
}

/// Period \[s\] and decay per period, λT, of the tip.
fn swing(run: &Run) -> Result<(f64, f64), String> {
    let tip = tip(run)?;
    let free = series::window(&tip, FITTED, f64::INFINITY);
    let guess = TAU / series::mean_period(&free);
    let (_, rate, omega) = series::damped_oscillation(&free, (0.0, guess));
    let period = TAU / omega;
    Ok((period, rate * period))
}

impl Case for PlateMode {
    fn name(&self) -> &'static str {
        "plate_mode"
    }

    fn about(&self) -> &'static str {
        "a plate swings in still water as without relaxation of sound and volume correction, and slower than in air"
    }

    fn members(&self) -> Vec<Member> {
        let water = |scheme| Member::new("plate_mode", 0.002).scheme(scheme);
        vec![
            Member::solid("plate_mode_air", 0.002).scheme(AIR),
            water(WATER),
            water(PLAIN).with("fluid.acoustic_relaxation", 0.0).with("fluid.volume_correction", 0.0),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let (period, decay) = swing(run)?;
        let mut figures = vec![
            Figure::reported("tip at the release [m]", series::at(&tip(run)?, RELEASE)),
            Figure::reported("period [s]", period),
            Figure::reported("decay per period", decay),
        ];
        if run.member.scheme != AIR {
            figures.extend(coupling(run));
        }
        Ok(figures)
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let of = |scheme| runs.iter().find(|run| run.member.scheme == scheme).map(swing).transpose();
        let (Some(cured), Some(plain)) = (of(WATER)?, of(PLAIN)?) else { return Ok(Vec::new()) };
        // What acts on sound may not act on the plate.
        Ok(vec![
            Figure::compared("period in water over that without both", cured.0 / plain.0, 1.0, 0.01),
            Figure::compared(
                "decay per period in water over that without both",
                cured.1 / plain.1,
                1.0,
                0.10,
            ),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("tip", "t [s]", "displacement of the tip [m]");
        for run in runs {
            plot.line(run.member.scheme, tip(run)?);
        }
        Ok(vec![plot])
    }
}
