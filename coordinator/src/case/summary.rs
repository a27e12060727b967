//! What `check` and the run header report about a case.

mod terms;

use std::collections::BTreeMap;

use solid::limits::{
    total_lagrangian_stage_rule, total_lagrangian_substep, updated_lagrangian_stage_rule,
    updated_lagrangian_substep,
};
use sph::constants::Constant;
use sph::coupling::solver::Role;
use sph::setup::{
    Choice, ContactLaw, FluidScheme, Formulation, ParameterSet, SolidStepping, StepPolicy, SubstepCount,
    Value,
};
use sph::space::Plane;

use super::Case;
use super::file::body::BodyTable;
use super::file::material::FormulationTable;
use super::file::solid::{ContactTable, SolidTable};
use super::forecast::{self, Work};
use super::limits::{self, StepLimit};
use super::scene::tally;

/// Fewest times the largest speed that the sound speed should be, so that density stays within 1 %.
const SOUND_SPEED_RATIO: f64 = 10.0;

/// What the updated-Lagrangian formulation costs; `docs/verification.md` has the measurements.
const UPDATED_LAGRANGIAN_COST: &str =
    "a cantilever of 6 particles across swings with a period 29 % too long, one of 10 with 19 %";

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
        let scene = &self.scene;
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
            cuts: scene.cuts.clone(),
            warnings: scene.warnings.clone(),
            limits,
        };
        summary.warnings.extend(self.step_warning(&summary));
        summary.warnings.extend(self.sound_speed_warning());
        summary.warnings.extend(self.iteration_warning());
        for body in self.separations() {
            let lines = if body.is_complete() { &mut summary.constants } else { &mut summary.warnings };
            lines.push(body.text());
        }
        summary
    }

    /// Limits of the time step of everything in the scene at the start.
    pub(super) fn step_limits(&self) -> Vec<StepLimit> {
        let mut found = Vec::new();
        let mut add = |origin: String, stability: f64, fraction: f64| {
            found.push(StepLimit { origin, stability, recommended: fraction * stability });
        };
        if let Some(fluid) = &self.file.fluid {
            let constants = fluid.parameters.values();
            let h = constants.smoothing_length();
            let speed = self.scene.fluid.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
            add(
                "fluid, acoustic h/(c0 + v)".to_owned(),
                constants.acoustic_limit(speed),
                limits::RECOMMENDED_FRACTION,
            );
            if constants.dynamic_viscosity > 0.0 {
                let viscosity = constants.dynamic_viscosity / constants.rest_density;
                add("fluid, viscous h²/(8 ν)".to_owned(), limits::viscous(h, viscosity), 1.0);
            }
            if let Some(damping) = &fluid.damping {
                add(
                    "fluid, damping 1/k".to_owned(),
                    limits::damping(damping.rate_per_s),
                    limits::RECOMMENDED_DAMPING_FRACTION,
                );
            }
        }
        if let Some(solid) = &self.file.solid {
            for body in &solid.bodies {
                if let Some((origin, limit, fraction)) = body_limit(solid, body) {
                    add(format!("body `{}`, {origin}", body.name.value), limit, fraction);
                }
            }
            if let Some(damping) = &solid.damping {
                add(
                    "solid, damping 1/k".to_owned(),
                    limits::damping(damping.rate_per_s),
                    limits::RECOMMENDED_DAMPING_FRACTION,
                );
            }
        }
        found
    }

    fn counts(&self) -> Vec<Count> {
        let mut counts = Vec::new();
        let mut add = |kind, name: &str, particles, held| {
            counts.push(Count { kind, name: name.to_owned(), particles, held });
        };
        let regions = self.file.fluid.as_ref().map_or(&[][..], |fluid| &fluid.regions);
        for (region, particles) in regions.iter().zip(tally(&self.scene.fluid.region, regions.len())) {
            add("fluid region", &region.name.value, particles, 0);
        }
        let bodies = self.file.solid.as_ref().map_or(&[][..], |solid| &solid.bodies);
        for (k, body) in (0u32..).zip(bodies) {
            let supports = &self.scene.solid.support[self.scene.body_range(k)];
            let held = supports.iter().filter(|support| **support > 0).count();
            add("body", &body.name.value, supports.len() - held, held);
        }
        let walls = &self.file.walls;
        for (wall, particles) in walls.iter().zip(tally(&self.scene.walls.wall, walls.len())) {
            add("wall", &wall.name.value, particles, 0);
        }
        counts
    }

    fn constants(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(fluid) = &self.file.fluid {
            lines.push(format!("fluid: {}", listed(&fluid.parameters.values())));
        }
        if let Some(solid) = &self.file.solid {
            let stepping = match solid.substeps.to_setup() {
                SolidStepping::StageRule => "advances by the stage rule, Eq. (30)-(31)".to_owned(),
                SolidStepping::Substeps(SubstepCount::Fixed(count)) => {
                    format!("{count} velocity-Verlet sub-steps per step")
                }
                SolidStepping::Substeps(SubstepCount::Automatic) => {
                    "as many velocity-Verlet sub-steps per step as its limit asks for".to_owned()
                }
            };
            lines.push(format!("solid: Δx = {} m, {stepping}", solid.particle_spacing_m.value));
            for body in &solid.bodies {
                let material = body.material.parameters.values();
                let formulation = match &body.formulation {
                    FormulationTable::Rigid => "rigid".to_owned(),
                    FormulationTable::UpdatedLagrangian(set) => {
                        format!("updated-lagrangian, {}", listed(&set.values()))
                    }
                    FormulationTable::TotalLagrangian(set) => {
                        format!("total-lagrangian, {}", listed(&set.values()))
                    }
                };
                lines.push(format!(
                    "body `{}`: {}, c_L = {:.2} m/s, {formulation}",
                    body.name.value,
                    listed(&material),
                    material.longitudinal_speed()
                ));
            }
            lines.push(match &solid.contact {
                ContactTable::Sums => "contact: sums".to_owned(),
                ContactTable::Repulsion(set) => format!("contact: repulsion, {}", listed(&set.values())),
            });
        }
        if let Some(interface) = &self.file.interface {
            lines.push(format!(
                "interface: law {}, margin {} Δx",
                interface.law.word, interface.margin_spacings
            ));
        }
        lines
    }

    /// Thresholds of the laws of this case that no case sets.
    pub fn fixed_constants(&self) -> impl Iterator<Item = &'static Constant> {
        let fluid = if self.has(Role::Fluid) { fluid::constants() } else { &[] };
        let solid = if self.has(Role::Solid) { solid::thresholds::constants() } else { &[] };
        sph::constants::constants().iter().chain(fluid).chain(solid)
    }

    /// Every parameter of fluid, bodies and contact by name, such as `fluid.artificial_viscosity_a`.
    pub fn parameters(&self) -> BTreeMap<String, serde_json::Value> {
        let mut all = BTreeMap::new();
        if let Some(fluid) = &self.file.fluid {
            list("fluid", &fluid.parameters.values(), &mut all);
        }
        let Some(solid) = &self.file.solid else { return all };
        for body in &solid.bodies {
            let name = &body.name.value;
            let formulation = body.formulation.to_setup();
            list(&format!("body.{name}.material"), &body.material.parameters.values(), &mut all);
            all.insert(format!("body.{name}.formulation"), formulation.kind().name().into());
            match &formulation {
                Formulation::TotalLagrangian(set) => list(&format!("body.{name}"), set, &mut all),
                Formulation::UpdatedLagrangian(set) => list(&format!("body.{name}"), set, &mut all),
                Formulation::Rigid => {}
            }
        }
        let contact = solid.contact.to_setup();
        all.insert("contact".to_owned(), contact.kind().name().into());
        if let ContactLaw::Repulsion(set) = &contact {
            list("contact", set, &mut all);
        }
        all
    }

    /// Parameters that are not at their recommended values.
    fn departures(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(fluid) = &self.file.fluid {
            for (spec, value) in fluid.parameters.values().values() {
                if let Some((recommended, cost)) = spec.recommended
                    && !recommended.is(&value)
                {
                    lines.push(format!("fluid.{} = {value}, recommended {recommended}: {cost}", spec.key));
                }
            }
        }
        for body in self.file.solid.iter().flat_map(|solid| &solid.bodies) {
            if matches!(body.formulation, FormulationTable::UpdatedLagrangian(_)) {
                lines.push(format!(
                    "formulation of body `{}` = updated-lagrangian, recommended total-lagrangian: \
                     {UPDATED_LAGRANGIAN_COST}",
                    body.name.value
                ));
            }
        }
        lines
    }

    fn step_warning(&self, summary: &Summary) -> Option<String> {
        // A step of exactly the recommended size must not warn.
        (summary.ratio_to_recommended > 1.0 + 1e-9).then(|| {
            format!(
                "the time step of {:.3e} s is {:.2} times the recommended one",
                summary.time_step, summary.ratio_to_recommended
            )
        })
    }

    /// Warns when half-steps are iterated that leave the fluid's forces as they are.
    fn iteration_warning(&self) -> Option<String> {
        let iterated = self.file.interface.as_ref().is_some_and(|interface| interface.iterate.is_some());
        let leapfrog = self.file.fluid.as_ref().is_some_and(|f| f.parameters.scheme == FluidScheme::Leapfrog);
        (iterated && leapfrog).then(|| {
            "[interface] iterate: with the fluid's scheme `leapfrog` its pressure in the corrector does not depend on the \
             solid's velocity of the same step, so that iterations change next to nothing; use `scheme = \
             \"predictor-corrector\"` in [fluid]"
                .to_owned()
        })
    }

    /// Warns when the fluid can move faster than a tenth of its sound speed.
    fn sound_speed_warning(&self) -> Option<String> {
        let fluid = self.file.fluid.as_ref()?;
        let gravity = self.file.body_force.gravity_m_s2;
        let heights = self.scene.fluid.position.iter().map(|x| -x.dot(&gravity));
        let (lowest, highest) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
        // g·height: a fall through all of the fluid gives √(2gH).
        let fall = (2.0 * (highest - lowest).max(0.0)).sqrt();
        let speed = self.scene.fluid.velocity.iter().map(|v| v.norm()).fold(fall, f64::max);
        let sound_speed = fluid.parameters.sound_speed;
        (sound_speed < SOUND_SPEED_RATIO * speed).then(|| {
            format!(
                "the sound speed of {sound_speed} m/s is {:.1} times the speed {speed:.2} m/s that the fluid can reach; \
                 below {SOUND_SPEED_RATIO} times its density varies by more than 1 %",
                sound_speed / speed
            )
        })
    }
}

/// Adds the values of a set under `owner`.
fn list(owner: &str, set: &impl ParameterSet, all: &mut BTreeMap<String, serde_json::Value>) {
    for (spec, value) in set.values() {
        let value = match value {
            Value::Number(number) => number.into(),
            Value::Flag(flag) => flag.into(),
            Value::Choice(word) => word.into(),
            Value::Count(count) => count.into(),
        };
        all.insert(format!("{owner}.{}", spec.key), value);
    }
}

/// Keys and values of a set.
fn listed(set: &impl ParameterSet) -> String {
    let values: Vec<String> = set.values().map(|(spec, value)| format!("{} = {value}", spec.key)).collect();
    values.join(", ")
}

/// What limits the step by the waves of `body`, by the formulas of the solver: origin, stability limit \[s\] and the
/// fraction of it to use.
fn body_limit(solid: &SolidTable, body: &BodyTable) -> Option<(String, f64, f64)> {
    let spacing = solid.particle_spacing_m.value;
    let speed = body.material.parameters.values().longitudinal_speed();
    let count = match solid.substeps.to_setup() {
        SolidStepping::StageRule => None,
        SolidStepping::Substeps(SubstepCount::Fixed(count)) => Some(f64::from(count)),
        // The solid takes as many as it needs.
        SolidStepping::Substeps(SubstepCount::Automatic) => return None,
    };
    let (limit, name) = match (&body.formulation, count) {
        (FormulationTable::Rigid, _) => return None,
        (FormulationTable::UpdatedLagrangian(set), count) => {
            let (h, a) = (set.smoothing_length(spacing), set.viscosity_a);
            let of_step = || updated_lagrangian_stage_rule::<Plane>(h, speed, a);
            (count.map_or_else(of_step, |n| n * updated_lagrangian_substep::<Plane>(h, speed, a)), "h/c_L")
        }
        (FormulationTable::TotalLagrangian(set), count) => {
            let a = set.viscosity_a;
            let of_step = || total_lagrangian_stage_rule::<Plane>(spacing, speed, a);
            // The stiffest vibration of a lattice, which the solver finds exactly.
            let frequency = 2.0 * speed / spacing;
            (count.map_or_else(of_step, |n| n * total_lagrangian_substep::<Plane>(frequency, a)), "Δx/c_L")
        }
    };
    let origin = match count {
        None => format!("elastic, of {name}"),
        Some(count) => format!("elastic, {count} sub-steps, each of {name}"),
    };
    let reference = count.is_some() && matches!(body.formulation, FormulationTable::TotalLagrangian(_));
    let fraction =
        if reference { limits::RECOMMENDED_REFERENCE_FRACTION } else { limits::RECOMMENDED_FRACTION };
    Some((origin, limit, fraction))
}
