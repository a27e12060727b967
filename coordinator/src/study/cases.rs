//! What a study runs: cases with known answers, over resolution, scheme and step.

use toml::Value;

use super::references::{self, drop_semi_axes};
use super::results::Results;
use super::series;
use crate::results::table::Table;

/// Values to replace in a case file, by dotted path.
pub type Changes = Vec<(String, Value)>;

/// A case with a known answer.
pub struct Study {
    /// Name on the command line and of its folder.
    pub name: &'static str,
    /// Headline.
    pub title: &'static str,
    /// What the error is, and of what.
    pub about: &'static str,
    /// Case file.
    text: &'static str,
    /// Values that suit the case file to a spacing \[m\].
    resized: fn(f64) -> Changes,
    /// Spacings \[m\], coarse before fine.
    spacings: &'static [Chosen<f64>],
    /// Schemes; the first is the recommended one.
    schemes: &'static [Chosen<Scheme>],
    /// Relative error of a finished run; an `Err` says why the result is not valid.
    pub error: fn(&Results) -> Result<f64, String>,
    /// CPU time of the coarsest member at its own step \[s\], for the forecast.
    seconds: f64,
    /// Only in the full study.
    full: bool,
}

/// A choice that may be for the full study only.
#[derive(Clone, Copy)]
struct Chosen<T> {
    what: T,
    full: bool,
}

const fn quick<T>(what: T) -> Chosen<T> {
    Chosen { what, full: false }
}

const fn full<T>(what: T) -> Chosen<T> {
    Chosen { what, full: true }
}

/// A scheme, as what it changes of the recommended settings.
#[derive(Clone, Copy)]
struct Scheme {
    name: &'static str,
    changes: fn() -> Changes,
}

/// A step policy: the step of the case file times this.
#[derive(Clone, Copy)]
struct StepPolicy {
    name: &'static str,
    factor: f64,
}

const STEPS: [Chosen<StepPolicy>; 3] = [
    quick(StepPolicy { name: "step of the case", factor: 1.0 }),
    quick(StepPolicy { name: "half the step", factor: 0.5 }),
    full(StepPolicy { name: "a quarter of the step", factor: 0.25 }),
];

fn change(path: &str, value: impl Into<Value>) -> (String, Value) {
    (path.to_owned(), value.into())
}

const WATER: [Chosen<Scheme>; 4] = [
    quick(Scheme { name: "recommended", changes: Vec::new }),
    quick(Scheme {
        name: "lattice moment",
        changes: || {
            let gradient = change("fluid.gradient_correction", "lattice-moment");
            vec![gradient, change("fluid.density_diffusion", "plain")]
        },
    }),
    quick(Scheme {
        name: "no order control",
        changes: || vec![change("fluid.shifting", 0.0), change("fluid.tensile_control", false)],
    }),
    full(Scheme { name: "continuity", changes: || vec![change("fluid.gradient_correction", "continuity")] }),
];

const PLATE: [Chosen<Scheme>; 1] = [quick(Scheme { name: "recommended", changes: Vec::new })];

/// All cases, quick ones first.
pub static ALL: [Study; 6] = [
    Study {
        name: "drop",
        title: "Stretching drop",
        about: "root mean square of the relative errors of both semi-axes, over those of the start, at 7.6 ms; exact: the \
                ordinary differential equation of Monaghan (1994)",
        text: include_str!("../../../cases/validation/drop.toml"),
        resized: water_spacing,
        spacings: &[quick(0.1), quick(0.05), quick(0.025), full(0.0125)],
        schemes: &WATER,
        error: drop_error,
        seconds: 0.03,
        full: false,
    },
    Study {
        name: "square_patch",
        title: "Rotating square patch",
        about: "largest departure of the kinetic energy from that of the start until ωt = 2, which an ideal fluid keeps; \
                a patch with a void wider than 2.5 Δx in its middle counts as torn",
        text: include_str!("../../../cases/validation/square_patch.toml"),
        resized: water_spacing,
        spacings: &[quick(0.04), quick(0.02), full(0.01), full(0.005)],
        schemes: &WATER,
        error: patch_error,
        seconds: 0.17,
        full: false,
    },
    Study {
        name: "taylor_green",
        title: "Taylor-Green vortices, Re 100",
        about: "relative error of the rate at which ln of the kinetic energy falls, 0.2 to 1.5 s; exact: −16π²/Re",
        text: include_str!("../../../cases/validation/taylor_green.toml"),
        resized: water_spacing,
        spacings: &[quick(0.04), quick(0.02), full(0.01)],
        schemes: &WATER,
        error: taylor_green_error,
        seconds: 0.2,
        full: false,
    },
    Study {
        name: "dam_break",
        title: "Dam break, front",
        about: "root mean square of the relative error of the 99.5 % front, 0.05 to 0.12 s; reference: the recommended \
                settings at 1 mm, not the continuum",
        text: include_str!("../../../cases/validation/dam_break.toml"),
        resized: dam_break,
        spacings: &[quick(0.008), quick(0.004), full(0.002)],
        schemes: &WATER,
        error: dam_break_error,
        seconds: 0.18,
        full: false,
    },
    Study {
        name: "cantilever",
        title: "Swinging cantilever",
        about: "relative error of the period over two swings; reference: 0.2551 s by plane finite elements",
        text: include_str!("../../../cases/validation/cantilever_6.toml"),
        resized: cantilever,
        spacings: &[quick(0.005), quick(0.01 / 3.0), full(0.002), full(0.001)],
        schemes: &PLATE,
        error: cantilever_error,
        seconds: 1.2,
        full: false,
    },
    Study {
        name: "standing_wave",
        title: "Standing wave, Re 250",
        about: "root mean square of the relative errors of decay rate and period over eight periods; exact: linear theory",
        text: include_str!("../../../cases/validation/standing_wave.toml"),
        resized: water_spacing,
        spacings: &[full(0.08), full(0.04), full(0.02)],
        schemes: &WATER,
        error: standing_wave_error,
        seconds: 1.5,
        full: true,
    },
];

/// One run of a study.
pub struct Member {
    /// Place of its case in [`ALL`].
    pub study: usize,
    /// Spacing \[m\].
    pub spacing: f64,
    /// Name of the scheme.
    pub scheme: &'static str,
    /// Name of the step policy.
    pub step: &'static str,
    /// Case file, ready to run.
    pub text: String,
    /// Expected CPU time \[s\].
    pub expected: f64,
}

impl Member {
    /// Name of its folder below that of the case.
    pub fn label(&self) -> String {
        let name = format!("{}_{}_{:.5}", self.scheme, self.step, self.spacing);
        name.replace(' ', "-")
    }
}

impl Study {
    /// Whether the study of this extent has it.
    pub fn chosen(&self, full: bool) -> bool {
        full || !self.full
    }

    /// Names of all its schemes.
    pub fn schemes(&self) -> impl Iterator<Item = &'static str> {
        self.schemes.iter().map(|scheme| scheme.what.name)
    }

    /// Names of all step policies.
    pub fn steps() -> impl Iterator<Item = &'static str> {
        STEPS.iter().map(|step| step.what.name)
    }

    /// The runs of the case at `index` in [`ALL`]: schemes, then steps, then spacings, coarse before fine.
    ///
    /// # Errors
    /// When its case file does not hold what is to be replaced.
    pub fn members(index: usize, full: bool) -> Result<Vec<Member>, String> {
        let study = &ALL[index];
        let mut members = Vec::new();
        for scheme in chosen(study.schemes, full) {
            for step in chosen(&STEPS, full) {
                for spacing in chosen(study.spacings, full) {
                    let text = study.text(spacing, &scheme, step)?;
                    // Particles grow as Δx⁻², steps as Δx⁻¹.
                    let work = (study.spacings[0].what / spacing).powi(3) / step.factor;
                    members.push(Member {
                        study: index,
                        spacing,
                        scheme: scheme.name,
                        step: step.name,
                        text,
                        expected: study.seconds * work,
                    });
                }
            }
        }
        Ok(members)
    }

    fn text(&self, spacing: f64, scheme: &Scheme, step: StepPolicy) -> Result<String, String> {
        let mut changes = (self.resized)(spacing);
        changes.extend((scheme.changes)());
        let text = super::template::instantiate(self.text, &changes)?;
        let table: toml::Table = text.parse().map_err(|e| format!("{e}"))?;
        let number =
            |table: &toml::Table, path: [&str; 2]| table.get(path[0])?.get(path[1]).and_then(Value::as_float);
        let time = table.get("time").and_then(Value::as_table).ok_or("the case has no `[time]`")?;
        // What a report does not look at is not written.
        let mut changes = vec![change("outputs.ledger_every_steps", 100_000)];
        if let Some(end) = time.get("end_time_s").and_then(Value::as_float) {
            changes.push(change("outputs.snapshot_interval_s", end));
            changes.push(change("outputs.picture_times_s", vec![end]));
        }
        for key in ["factor", "time_step_s"] {
            if let Some(size) = number(time, ["step", key]) {
                changes.push(change(&format!("time.step.{key}"), size * step.factor));
            }
        }
        super::template::instantiate(&text, &changes)
    }
}

fn chosen<T: Copy>(all: &[Chosen<T>], full: bool) -> impl Iterator<Item = T> {
    all.iter().filter(move |choice| full || !choice.full).map(|choice| choice.what)
}

fn water_spacing(spacing: f64) -> Changes {
    vec![change("fluid.particle_spacing_m", spacing)]
}

fn dam_break(spacing: f64) -> Changes {
    let mut changes = water_spacing(spacing);
    changes.push(change("time.end_time_s", DAM_BREAK_SPAN.1 + 0.004));
    changes
}

/// The plate of 20 mm, held by four columns, with the step in proportion.
fn cantilever(spacing: f64) -> Changes {
    let lower: Value = vec![-4.0 * spacing, -0.01].into();
    vec![
        change("solid.particle_spacing_m", spacing),
        change("solid.body.0.shape.lower_m", lower.clone()),
        change("solid.body.0.support.0.shape.lower_m", lower),
        change("time.step.time_step_s", 1e-4 * spacing / 0.005),
        change("time.end_time_s", 0.55),
    ]
}

fn root_mean_square(errors: &[f64]) -> f64 {
    // Counts far below 2^53.
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

fn drop_error(run: &Results) -> Result<f64, String> {
    let axis = |name: &str, exact: fn([f64; 2]) -> f64| -> Result<f64, String> {
        let history = run.history(&format!("drop_second_moment_{name}_m2"))?;
        let ends = history.first().zip(history.last()).ok_or("no probe row")?;
        let ((_, start), (time, end)) = ends;
        // The lattice's drop misses the circle at its start by the steps of its edge.
        Ok((end / start).sqrt() / exact(drop_semi_axes(*time)) - 1.0)
    };
    Ok(root_mean_square(&[axis("xx", |axes| axes[0])?, axis("yy", |axes| axes[1])?]))
}

fn patch_error(run: &Results) -> Result<f64, String> {
    let energy = run.history("patch_kinetic_energy_j_per_m")?;
    let start = energy.first().ok_or("no probe row")?.1;
    let gap = run.widest_void()?;
    if gap > 2.5 {
        return Err(format!("torn: a void of {gap:.1} Δx"));
    }
    Ok(series::largest(energy.iter().map(|(_, e)| (e / start - 1.0).abs())))
}

fn taylor_green_error(run: &Results) -> Result<f64, String> {
    let slope = references::slope_of_logarithm(&run.history("water_kinetic_energy_j_per_m")?);
    Ok((slope / references::taylor_green_slope() - 1.0).abs())
}

/// Times over which fronts are compared \[s\].
const DAM_BREAK_SPAN: (f64, f64) = (0.05, 0.12);

fn dam_break_error(run: &Results) -> Result<f64, String> {
    // `tidelock run` of cases/validation/dam_break.toml with particle_spacing_m = 0.001 and end_time_s = 0.15.
    let fine = Table::parse(include_bytes!("../../reference/dam_break_front_1mm.csv").as_slice())?;
    let fine: Vec<(f64, f64)> = fine.column_at(0).into_iter().zip(fine.column_at(1)).collect();
    let front = series::window(&run.history("head_front_x_m")?, DAM_BREAK_SPAN.0, DAM_BREAK_SPAN.1);
    let errors: Vec<f64> = front.iter().map(|(t, x)| x / series::at(&fine, *t) - 1.0).collect();
    Ok(root_mean_square(&errors))
}

fn cantilever_error(run: &Results) -> Result<f64, String> {
    let (_, period) = references::swing(&run.history("tip_displacement_y_m")?);
    Ok((period / references::CANTILEVER_PERIOD - 1.0).abs())
}

fn standing_wave_error(run: &Results) -> Result<f64, String> {
    let (decay, period) = references::STANDING_WAVE;
    let history = series::window(&run.history("antinode_level_m")?, 0.0, 8.0 * period);
    let (_, rate, omega) = series::damped_oscillation(&history, (decay, std::f64::consts::TAU / period));
    Ok(root_mean_square(&[rate / decay - 1.0, std::f64::consts::TAU / omega / period - 1.0]))
}

#[cfg(test)]
mod tests;
