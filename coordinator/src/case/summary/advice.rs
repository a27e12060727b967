//! Where a case departs from what is recommended, and what deserves a second look.

use solid::limits::{automatic_substeps, estimated_contact_substep};
use sph::coupling::stage::STEPS_PER_EXACT_PROBE;
use sph::setup::{FluidParameters, FluidScheme, ParameterSet, SolidStepping, StepPolicy, SubstepCount};
use sph::space::Space;
use sph::space::tensors::SpaceVector;

use super::Summary;
use crate::case::Case;
use crate::case::Scene;
use crate::case::file::material::FormulationTable;
use crate::case::file::run::StepTable;
use crate::case::file::solid::ContactTable;
use crate::case::scene::SceneSpace;

/// Fewest times the largest speed that the sound speed should be, so that density stays within 1 %.
const SOUND_SPEED_RATIO: f64 = 10.0;

/// Sub-steps of a step beyond which a rigid body is called stiff: those of a body of steel in a small tank, some hundred, take ten
/// times as long as the fluid.
const MANY_SUBSTEPS: u32 = 100;

/// What the updated-Lagrangian formulation costs; `docs/verification.md` has the measurements.
const UPDATED_LAGRANGIAN_COST: &str =
    "a cantilever of 6 particles across swings with a period 29 % too long, one of 10 with 19 %";

impl Case {
    /// Parameters that are not at their recommended values.
    pub(super) fn departures(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(fluid) = &self.file.fluid {
            let recommended = FluidParameters::DEFAULT;
            for (spec, value) in fluid.parameters.values().values() {
                // What the case leaves to its step is no departure.
                let is_derived = spec.key == "acoustic_relaxation" && fluid.takes_relaxation_of_step;
                if let (Some(cost), Some(recommended)) = (spec.cost, recommended.get(spec.key))
                    && !is_derived
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

    pub(super) fn step_warning(&self, summary: &Summary) -> Option<String> {
        // A step of exactly the recommended size must not warn.
        (summary.ratio_to_recommended > 1.0 + 1e-9).then(|| {
            format!(
                "the time step of {:.3e} s is {:.2} times the recommended one",
                summary.time_step, summary.ratio_to_recommended
            )
        })
    }

    /// Warns of times that steps do not meet: what is due then comes up to a step late.
    pub(super) fn offbeat_warnings(&self) -> Vec<String> {
        // As the clock of a run, which absorbs the round-off of decimal times.
        const ROUND_OFF: f64 = 1e-6;
        let plan = self.file.time.to_setup();
        let StepPolicy::Fixed { time_step } = plan.step else { return Vec::new() };
        let intervals = [
            ("outputs.snapshot_interval_s", self.outputs.plan.snapshot_interval, "snapshots come"),
            ("outputs.probe_interval_s", self.outputs.plan.probe_interval, "rows of probes.csv come"),
            ("time.end_time_s", Some(plan.end_time - plan.start_time), "the run ends"),
        ];
        let mut warnings = Vec::new();
        for (key, interval, what) in intervals {
            let Some(interval) = interval.filter(|interval| *interval > 0.0) else { continue };
            let steps = interval / time_step;
            if (steps - steps.round()).abs() > ROUND_OFF {
                let fitting = interval / steps.ceil();
                warnings.push(format!(
                    "the fixed time step of {time_step:.4e} s does not divide `{key}` ({interval} s): {what} up to a step \
                     late; {fitting:.6e} s divides it"
                ));
            }
        }
        let late = |time: &&f64| {
            let steps = (**time - plan.start_time) / time_step;
            (steps - steps.round()).abs() > ROUND_OFF
        };
        if let Some(time) = self.outputs.picture_times.iter().find(late) {
            warnings.push(format!(
                "no multiple of the fixed time step of {time_step:.4e} s meets {time} s of `outputs.picture_times_s`: the \
                 picture comes up to a step late"
            ));
        }
        warnings
    }

    /// Says so where adaptive steps of about `time_step` \[s\] are too long to meet the times of probes.
    pub(super) fn missed_probes(&self, time_step: f64) -> Option<String> {
        let StepTable::Adaptive { exact_outputs: true, .. } = self.file.time.step else { return None };
        let interval = self.outputs.plan.probe_interval?;
        let least = STEPS_PER_EXACT_PROBE * time_step;
        (interval < least).then(|| {
            format!(
                "`outputs.probe_interval_s` = {interval} s is less than {STEPS_PER_EXACT_PROBE} steps of about {time_step:.2e} \
                 s: rows of probes.csv come up to a step late; from {least:.2e} s on they come at the exact times"
            )
        })
    }

    /// Warns when half-steps are iterated that leave the fluid's forces as they are.
    pub(super) fn iteration_warning(&self) -> Option<String> {
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
    pub(super) fn sound_speed_warning(&self) -> Option<String> {
        sph::in_space!(&self.scene, scene => self.sound_speed_warning_in(scene))
    }

    fn sound_speed_warning_in<S: Space>(&self, scene: &Scene<S>) -> Option<String> {
        let fluid = self.file.fluid.as_ref()?;
        let gravity = self.file.body_force.gravity_m_s2.to::<S>();
        let heights = scene.fluid.position.iter().map(|x| -x.dot(&gravity));
        let (lowest, highest) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
        // g·height: a fall through all of the fluid gives √(2gH).
        let fall = (2.0 * (highest - lowest).max(0.0)).sqrt();
        let speed = scene.fluid.velocity.iter().map(|v| v.norm()).fold(fall, f64::max);
        let sound_speed = fluid.parameters.sound_speed;
        // Ten times a speed that is rounded to three digits is meant as ten times.
        (sound_speed < 0.99 * SOUND_SPEED_RATIO * speed).then(|| {
            let reached = if speed > fall { "at the start" } else { "as it falls by its whole depth" };
            let quiet = if speed > fall { "" } else { "; water that stays at rest or sloshes does not reach it" };
            format!(
                "the sound speed of {sound_speed} m/s is {:.1} times the speed {speed:.2} m/s that the fluid has {reached}; \
                 below {SOUND_SPEED_RATIO} times its density varies by more than 1 %{quiet}",
                sound_speed / speed
            )
        })
    }

    /// Warns of rigid bodies whose modulus makes their contacts take many sub-steps of about `time_step` \[s\].
    pub(super) fn stiff_rigid_warnings(&self, time_step: f64) -> Vec<String> {
        sph::in_space!(&self.scene, scene => self.stiff_rigid_warnings_in(scene, time_step))
    }

    fn stiff_rigid_warnings_in<S: SceneSpace>(&self, scene: &Scene<S>, time_step: f64) -> Vec<String> {
        // Without water the sub-steps of rigid bodies take no time.
        let (Some(solid), Some(_)) = (&self.file.solid, &self.file.fluid) else { return Vec::new() };
        let ContactTable::Repulsion(contact) = &solid.contact else { return Vec::new() };
        if solid.substeps.to_setup() != SolidStepping::Substeps(SubstepCount::Automatic)
            || solid.bodies.len() < 2 && self.file.walls.is_empty()
        {
            return Vec::new();
        }
        let lines = (0u32..).zip(&solid.bodies).filter_map(|(k, body)| {
            let (particles, material) = (scene.body_range(k), body.material.parameters.values());
            let held = scene.solid.support[particles.clone()].iter().any(|support| *support > 0);
            if held || particles.is_empty() || !matches!(body.formulation, FormulationTable::Rigid) {
                return None;
            }
            let spacing = solid.particle_spacing_m.value;
            let limit =
                estimated_contact_substep::<S>(&material, contact.values().stiffness, spacing, particles.len());
            let count = automatic_substeps(time_step, limit);
            (count > MANY_SUBSTEPS).then(|| {
                // To half of that number.
                let factor = (2.0 * f64::from(count) / f64::from(MANY_SUBSTEPS)).powi(2);
                format!(
                    "body `{}`: each step in which it comes near a wall or another body takes about {count} sub-steps, and the run \
                     as much longer, for its bulk modulus of {:.1e} Pa; moduli of rigid bodies act in contact alone: divide them by \
                     {factor:.0} or more",
                    body.name.value, material.bulk_modulus,
                )
            })
        });
        lines.collect()
    }

    /// Warns of free bodies that are too light for explicit coupling.
    pub(super) fn light_body_warnings(&self) -> Vec<String> {
        sph::in_space!(&self.scene, scene => self.light_body_warnings_in(scene))
    }

    fn light_body_warnings_in<S: Space>(&self, scene: &Scene<S>) -> Vec<String> {
        let (Some(fluid), Some(solid), Some(interface)) =
            (&self.file.fluid, &self.file.solid, &self.file.interface)
        else {
            return Vec::new();
        };
        if interface.iterate.is_some() {
            return Vec::new();
        }
        let gravity = self.file.body_force.gravity_m_s2.to::<S>();
        let axes = || 0..S::DIMENSIONS;
        let Some(up) = axes().max_by(|a, b| gravity[*a].abs().total_cmp(&gravity[*b].abs())) else {
            return Vec::new();
        };
        let parameters = &fluid.parameters;
        let half_row = 0.5 * parameters.rest_density * parameters.particle_spacing;
        let mut lines = Vec::new();
        for (k, body) in (0u32..).zip(&solid.bodies) {
            let particles = scene.body_range(k);
            if particles.is_empty()
                || scene.solid.support[particles.clone()].iter().any(|support| *support > 0)
            {
                continue;
            }
            let mass: f64 = scene.solid.mass[particles.clone()].iter().sum();
            let extent = |axis: usize| {
                let values = scene.solid.position[particles.clone()].iter().map(|x| x[axis]);
                let (low, high) =
                    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
                high - low + solid.particle_spacing_m.value
            };
            let below: f64 = axes().filter(|axis| *axis != up).map(extent).product();
            if mass < half_row * below {
                let is_rigid = matches!(body.formulation, FormulationTable::Rigid);
                let remedy = if is_rigid {
                    "write `[interface] iterate = {}`"
                } else {
                    "take a smaller `fluid.particle_spacing_m`"
                };
                lines.push(format!(
                    "body `{}` weighs {:.2} of a row of water particles below it: below 0.5 the forces on it tremble, or grow \
                     without bound; {remedy}",
                    body.name.value,
                    mass / (2.0 * half_row * below)
                ));
            }
        }
        lines
    }
}
