//! What `check` and the run header report about a case.

mod advice;
mod constants;
mod oddities;
mod terms;

use sph::setup::StepPolicy;
use sph::space::Space;

use super::Case;
use super::forecast::{self, Work};
use super::limits::{self, StepLimit};
use super::scene::{Scene, tally};

/// A named set of particles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Count {
    /// `fluid region`, `body` or `wall`.
    pub kind: &'static str,
    /// Name.
    pub name: String,
    /// Particles that move by their own equations, or all of a wall.
    pub particles: usize,
    /// Particles that supports hold.
    pub held: usize,
}

/// A term that a parameter switches on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ActiveTerm {
    /// What it acts on.
    pub owner: String,
    /// Parameter, value and meaning.
    pub text: String,
}

impl ActiveTerm {
    fn new(owner: &str, text: String) -> Self {
        Self { owner: owner.to_owned(), text }
    }
}

/// Facts of a case that are known before it runs.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Name of the case.
    pub name: String,
    /// Particles by region, body and wall.
    pub counts: Vec<Count>,
    /// Limits of the time step.
    pub limits: Vec<StepLimit>,
    /// Step of the run, or the first of an adaptive run \[s\].
    pub time_step: f64,
    /// Whether steps have one size.
    pub fixed: bool,
    /// Step over the smallest recommended one \[-\].
    pub ratio_to_recommended: f64,
    /// Step over the smallest stability limit \[-\].
    pub ratio_to_limit: f64,
    /// Allowed ratio when the case overrides it.
    pub limit_override: Option<f64>,
    /// Steps of the run, estimated when adaptive.
    pub steps: u64,
    /// Work of a step.
    pub work: Work,
    /// Constants that decide the answer, in words.
    pub constants: Vec<String>,
    /// Terms that parameters switch on, all stabilisers among them.
    pub active_terms: Vec<ActiveTerm>,
    /// Where the case departs from recommended values, and what that costs.
    pub departures: Vec<String>,
    /// How masses and spacings were adjusted to shapes off the lattice, in words.
    pub adjusted: Vec<String>,
    /// Particles left out where shapes meet, in words.
    pub cuts: Vec<String>,
    /// What deserves a second look.
    pub warnings: Vec<String>,
}

impl Summary {
    /// Forecast of the CPU time of the run \[s\], on the machine of docs/performance.md.
    pub fn forecast(&self) -> f64 {
        self.steps as f64 * self.work.seconds()
    }
}

impl Case {
    /// Facts of the case for `check` and the run header.
    pub fn summary(&self) -> Summary {
        let limits = self.step_limits();
        let stability =
            limits::governing(&limits, |limit| limit.stability).map_or(f64::INFINITY, |l| l.stability);
        let recommended =
            limits::governing(&limits, |limit| limit.recommended).map_or(f64::INFINITY, |l| l.recommended);
        let plan = self.file.time.to_setup();
        let (time_step, fixed) = match plan.step {
            StepPolicy::Fixed { time_step } => (time_step, true),
            StepPolicy::Adaptive { factor, maximum, .. } => ((factor * stability).min(maximum), false),
        };
        let steps = ((plan.end_time - plan.start_time) / time_step - 1e-6).ceil().max(0.0);
        let (adjusted, cuts, warnings) = sph::in_space!(&self.scene, scene => {
            (scene.adjusted.clone(), scene.cuts.clone(), scene.warnings.clone())
        });
        let mut summary = Summary {
            name: self.name.clone(),
            counts: self.counts(),
            time_step,
            fixed,
            ratio_to_recommended: time_step / recommended,
            ratio_to_limit: time_step / stability,
            limit_override: Some(self.file.time.limit_factor.value).filter(|factor| *factor != 1.0),
            // Saturates for absurd inputs.
            steps: steps as u64,
            work: forecast::work(self.fluid_setup().as_ref(), self.solid_setup().as_ref(), time_step),
            constants: self.constants(),
            active_terms: self.active_terms(),
            departures: self.departures(),
            adjusted,
            cuts,
            warnings,
            limits,
        };
        summary.warnings.extend(self.step_warning(&summary));
        summary.warnings.extend(self.offbeat_warnings());
        summary.constants.extend(self.missed_probes(time_step));
        summary.warnings.extend(self.sound_speed_warning());
        summary.warnings.extend(self.light_body_warnings());
        summary.warnings.extend(self.stiff_rigid_warnings(time_step));
        summary.warnings.extend(self.oddities());
        summary.warnings.extend(self.iteration_warning());
        for body in self.separations() {
            let lines = if body.is_complete() { &mut summary.constants } else { &mut summary.warnings };
            lines.push(body.text());
        }
        summary
    }

    fn counts(&self) -> Vec<Count> {
        sph::in_space!(&self.scene, scene => self.counts_in(scene))
    }

    fn counts_in<S: Space>(&self, scene: &Scene<S>) -> Vec<Count> {
        let mut counts = Vec::new();
        let mut add = |kind, name: &str, particles, held| {
            counts.push(Count { kind, name: name.to_owned(), particles, held });
        };
        let regions = self.file.fluid.as_ref().map_or(&[][..], |fluid| &fluid.regions);
        for (region, particles) in regions.iter().zip(tally(&scene.fluid.region, regions.len())) {
            add("fluid region", &region.name.value, particles, 0);
        }
        let bodies = self.file.solid.as_ref().map_or(&[][..], |solid| &solid.bodies);
        for (k, body) in (0u32..).zip(bodies) {
            let supports = &scene.solid.support[scene.body_range(k)];
            let held = supports.iter().filter(|support| **support > 0).count();
            add("body", &body.name.value, supports.len() - held, held);
        }
        let walls = &self.file.walls;
        for (wall, particles) in walls.iter().zip(tally(&scene.walls.wall, walls.len())) {
            add("wall", &wall.name.value, particles, 0);
        }
        counts
    }
}
