//! What a case leaves out of its acoustic relaxation: the strength that costs its steps little, the time of its scene.

use sph::setup::FluidParameters;

use super::file::CaseFile;
use super::file::run::StepTable;
use super::limits::RECOMMENDED_FRACTION;
use super::scene::depth::mean_depth;
use super::scene::{Scene, SceneSpace};

sph::constants! {
    /// Steps at their limit are shorter by √(1 + r): 12 %.
    const ADAPTIVE_STRENGTH: f64 = 0.25, "acoustic_relaxation.adaptive_strength",
        "strength of the acoustic relaxation that a case with adaptive steps takes [-]";
    /// The sound speed is at least ten times the largest speed.
    const LARGEST_MACH_NUMBER: f64 = 0.1, "acoustic_relaxation.mach_number",
        "largest Mach number for which fixed steps leave room for acoustic relaxation [-]";
    const STRENGTHS: u32 = 20, "acoustic_relaxation.strengths",
        "a strength of the acoustic relaxation from the step is a whole multiple of the largest over this number [-]";
}

impl CaseFile {
    /// Fills in strength and time of the acoustic relaxation of a `scene`, as far as the case leaves them out.
    ///
    /// ```text
    /// r: fixed steps     the largest up to the recommended one of which Δt is at most 0.8 of the limit at |v| = c₀/10
    ///    adaptive steps  0.25
    /// τ = V/(2 S c₀)
    /// ```
    /// with the volume V of the water at the start and the area S of its faces. From 0.3 to 3 times this τ serve as well.
    pub fn fill_in_relaxation<S: SceneSpace>(&mut self, scene: &Scene<S>) {
        let domain = self.domain.domain::<S>();
        let Some(fluid) = self.fluid.as_mut().filter(|fluid| fluid.intact) else { return };
        if fluid.takes_relaxation_of_step {
            let strength = strength(&fluid.parameters.values(), &self.time.step);
            fluid.parameters.derive(|parameters| parameters.acoustic_relaxation = strength);
        }
        if fluid.parameters.acoustic_relaxation > 0.0 && fluid.parameters.acoustic_relaxation_time.is_none() {
            let depth = mean_depth(&scene.fluid, &domain, fluid.parameters.particle_spacing);
            let time = 0.5 * depth / fluid.parameters.sound_speed;
            fluid.parameters.derive(|parameters| parameters.acoustic_relaxation_time = Some(time));
        }
    }
}

/// The strength for `step`, at most that of `fluid`.
fn strength(fluid: &FluidParameters, step: &StepTable) -> f64 {
    let largest = fluid.acoustic_relaxation;
    match step {
        StepTable::Adaptive { .. } => ADAPTIVE_STRENGTH.min(largest),
        StepTable::Fixed { time_step_s } => {
            let fits = |strength: &f64| {
                let fluid = FluidParameters { acoustic_relaxation: *strength, ..*fluid };
                let limit = fluid.acoustic_limit(LARGEST_MACH_NUMBER * fluid.sound_speed);
                time_step_s.value <= RECOMMENDED_FRACTION * limit
            };
            let strengths = (1..=STRENGTHS).rev().map(|k| largest * f64::from(k) / f64::from(STRENGTHS));
            strengths.into_iter().find(fits).unwrap_or(0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::reader::At;

    #[test]
    fn strength_follows_from_the_room_that_the_step_leaves() {
        let fluid = FluidParameters {
            particle_spacing: 0.01,
            kernel_ratio: 1.0,
            sound_speed: 10.0,
            acoustic_relaxation: 1.0,
            ..FluidParameters::PLAIN
        };
        let of = |time_step_s: f64| {
            let step = At { value: time_step_s, place: Default::default() };
            strength(&fluid, &StepTable::Fixed { time_step_s: step })
        };
        // 0.8 · 1.125 h/((√(1 + r) + 0.1) c₀) = Δt at r = 0, 0.2 and 1.
        let at = |strength: f64| 0.8 * 1.125 * 0.01 / (((1.0 + strength).sqrt() + 0.1) * 10.0);
        assert_eq!(of(1.01 * at(0.0)), 0.0);
        assert!((of(0.999 * at(0.2)) - 0.2).abs() < 1e-12);
        assert_eq!(of(0.999 * at(1.0)), 1.0);
        assert_eq!(of(1e-9), 1.0);
    }
}
