//! Which runs a family has, and what each changes of the case.

use serde::Serialize;

use super::FamilyRequest;
use super::figures::{self, Figure};
use crate::batch::Member;
use crate::case::Case;
use crate::case::file::run::StepTable;
use crate::case::overrides::Override;
use crate::failure::Failure;
use crate::run::load_with;

/// Where a run stands in its family.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Spacing of the fluid, or of the solid where there is no fluid \[m\].
    #[serde(rename = "spacing_m")]
    pub spacing: f64,
    /// Sound speed of the fluid \[m/s\]; `None` in a case without fluid.
    #[serde(rename = "sound_speed_m_s")]
    pub sound_speed: Option<f64>,
    /// Seed of the displacement; as the case says where `None`.
    pub seed: Option<u64>,
}

impl Place {
    /// Name of its folder.
    pub fn label(&self) -> String {
        let mut label = format!("dx_{}", self.spacing);
        if let Some(speed) = self.sound_speed {
            label.push_str(&format!("_c0_{speed}"));
        }
        if let Some(seed) = self.seed {
            label.push_str(&format!("_seed_{seed}"));
        }
        label
    }
}

/// The runs of a family.
pub struct Plan {
    /// Spacings \[m\], coarse before fine.
    pub spacings: Vec<f64>,
    /// Sound speeds \[m/s\], ascending; one `None` in a case without fluid.
    pub sound_speeds: Vec<Option<f64>>,
    /// Runs: spacings, then sound speeds, then seeds.
    pub places: Vec<Place>,
    /// Key figures.
    pub figures: Vec<Figure>,
    base: Base,
}

/// What the case says of what is varied.
struct Base {
    spacing: f64,
    sound_speed: Option<f64>,
    /// Spacing of solids \[m\].
    solid_spacing: Option<f64>,
    has_fluid: bool,
    /// Step, where it is fixed \[s\].
    time_step: Option<f64>,
    displacement_fraction: f64,
}

impl Plan {
    /// The runs that `request` asks for.
    ///
    /// # Errors
    /// When the case is wrong, a value is no spacing or sound speed, or a figure has no column of its own.
    pub fn of(request: &FamilyRequest) -> Result<Self, Failure> {
        let case = load_with(&request.run.case, &request.run.overrides)?;
        let base = Base::of(&case, request.displacement_fraction)?;
        let varies_water = !request.sound_speeds.is_empty() || !request.seeds.is_empty();
        if varies_water && !base.has_fluid {
            return Err(Failure::input("sound speeds and seeds vary the water, of which the case has none"));
        }
        let spacings = values("spacing", "m", &request.spacings, base.spacing)?;
        let sound_speeds = match base.sound_speed {
            Some(speed) => values("sound speed", "m/s", &request.sound_speeds, speed)?,
            None => Vec::new(),
        };
        let sound_speeds = match sound_speeds[..] {
            [] => vec![None],
            _ => sound_speeds.into_iter().rev().map(Some).collect(),
        };
        let mut seeds: Vec<Option<u64>> = request.seeds.iter().copied().map(Some).collect();
        if seeds.is_empty() {
            seeds.push(None);
        }
        let mut distinct = seeds.clone();
        distinct.sort_unstable();
        distinct.dedup();
        if distinct.len() < seeds.len() {
            return Err(Failure::input(
                "a seed is given twice; each run of an ensemble needs a seed of its own",
            ));
        }
        let mut places = Vec::new();
        for spacing in &spacings {
            for sound_speed in &sound_speeds {
                let place = |seed| Place { spacing: *spacing, sound_speed: *sound_speed, seed };
                places.extend(seeds.iter().copied().map(place));
            }
        }
        let figures = figures::of_case(&case, &request.figures)?;
        Ok(Self { spacings, sound_speeds, places, figures, base })
    }

    /// All pairs of spacing and sound speed, in the order of the runs.
    pub fn resolutions(&self) -> impl Iterator<Item = (f64, Option<f64>)> {
        self.spacings.iter().flat_map(|spacing| self.sound_speeds.iter().map(|speed| (*spacing, *speed)))
    }

    /// The run at `place`.
    pub fn member(&self, request: &FamilyRequest, place: &Place) -> Member {
        let mut overrides = request.run.overrides.clone();
        overrides.extend(self.changes(place));
        Member { label: place.label(), overrides }
    }

    /// What the run at `place` sets over the case. Spacings of fluid and solids keep their ratio. A fixed step shrinks and
    /// grows with the spacing, and shrinks as sound gets faster; slower sound leaves it, since the limit of solids and
    /// of viscosity does not grow with it. An adaptive step follows its limits anyway.
    pub fn changes(&self, place: &Place) -> Vec<Override> {
        let base = &self.base;
        let mut changes = Vec::new();
        let ratio = place.spacing / base.spacing;
        let mut step = 1.0;
        if ratio != 1.0 {
            step *= ratio;
            if base.has_fluid {
                changes.push(Override::new("fluid.particle_spacing_m", place.spacing));
            }
            if let Some(solid) = base.solid_spacing {
                changes.push(Override::new("solid.particle_spacing_m", solid * ratio));
            }
        }
        if let (Some(before), Some(speed)) = (base.sound_speed, place.sound_speed)
            && speed != before
        {
            step *= (before / speed).min(1.0);
            changes.push(Override::new("fluid.sound_speed_m_s", speed));
        }
        if let Some(size) = base.time_step.filter(|_| step != 1.0) {
            changes.push(Override::new("time.step.time_step_s", size * step));
        }
        if let Some(seed) = place.seed {
            // Seeds of more than 63 bits are refused where the key is read.
            changes.push(Override { key: "run.seed".to_owned(), value: seed.to_string() });
            changes.push(Override::new("run.displacement_fraction", base.displacement_fraction));
        }
        changes
    }
}

impl Base {
    fn of(case: &Case, displacement_fraction: f64) -> Result<Self, Failure> {
        let file = case.file();
        let solid_spacing = file.solid.as_ref().map(|solid| solid.particle_spacing_m.value);
        let fluid = file.fluid.as_ref().map(|fluid| &fluid.parameters);
        let spacing = fluid.map(|fluid| fluid.particle_spacing).or(solid_spacing);
        Ok(Self {
            spacing: spacing.ok_or_else(|| Failure::internal("a case without particles"))?,
            sound_speed: fluid.map(|fluid| fluid.sound_speed),
            solid_spacing,
            has_fluid: fluid.is_some(),
            time_step: match &file.time.step {
                StepTable::Fixed { time_step_s } => Some(time_step_s.value),
                StepTable::Adaptive { .. } => None,
            },
            displacement_fraction,
        })
    }
}

/// `asked` in descending order, `own` when there is none.
fn values(what: &str, unit: &str, asked: &[f64], own: f64) -> Result<Vec<f64>, Failure> {
    if let Some(wrong) = asked.iter().find(|value| !(value.is_finite() && **value > 0.0)) {
        return Err(Failure::input(format!("{what} {wrong} {unit}: must be above 0")));
    }
    let mut values = if asked.is_empty() { vec![own] } else { asked.to_vec() };
    values.sort_by(|a, b| b.total_cmp(a));
    if let Some(twice) = values.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Failure::input(format!("{what} {} {unit} is given twice", twice[0])));
    }
    Ok(values)
}
