//! Quality figures of a run: what it says of its own answer, each with a threshold and what to do.
//!
//! They follow from the results alone, in the coordinator, so that they cost the solvers nothing and do not ask who made
//! the solvers: from the particles at the times of the report's pictures and at the end, from the probes, and from what
//! is counted anyway. They change no result.

mod loads;
mod nodes;
mod samples;
pub mod thresholds;
pub mod volume;

use serde::Serialize;

pub use samples::Sampler;

use self::thresholds::{
    LARGEST_CAVITY, LARGEST_DENSITY_VARIATION, LARGEST_ENERGY_GAIN, LARGEST_ENERGY_RESIDUAL, LARGEST_EXCESS,
    LARGEST_EXCESS_WHERE_FULL, LARGEST_LOAD_NOISE, LARGEST_MACH, LARGEST_STEP_RATIO, LEAST_ACROSS,
};

/// A figure of a run with its threshold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QualityFigure {
    /// Name, such as `volume_excess`.
    pub name: &'static str,
    /// Value; `null` where it is not known or has no meaning in this run.
    pub value: Option<f64>,
    /// What it should not exceed, or of `particles_across` not fall below.
    pub threshold: f64,
    /// Whether it keeps to that.
    pub verdict: Judgement,
    /// What it is.
    pub meaning: &'static str,
    /// What to do where it does not keep to its threshold.
    pub advice: &'static str,
}

/// What a figure says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// It keeps to its threshold.
    Good,
    /// It does not.
    Reservation,
    /// It has no value.
    NotJudged,
}

/// The side on which a threshold must be kept to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    AtMost,
    AtLeast,
}

impl QualityFigure {
    fn new(
        name: &'static str,
        value: Option<f64>,
        (side, threshold): (Side, f64),
        meaning: &'static str,
        advice: &'static str,
    ) -> Self {
        let keeps = |value: f64| match side {
            Side::AtMost => value.abs() <= threshold,
            Side::AtLeast => value >= threshold,
        };
        // What is no number keeps to nothing.
        let verdict = match value.map(keeps) {
            None => Judgement::NotJudged,
            Some(true) => Judgement::Good,
            Some(false) => Judgement::Reservation,
        };
        Self { name, value, threshold, verdict, meaning, advice }
    }

    /// The reservation in words, where there is one.
    pub fn reservation(&self) -> Option<String> {
        let value = self.value.filter(|_| self.verdict == Judgement::Reservation)?;
        let Self { name, threshold, meaning, advice, .. } = self;
        Some(format!("{name} = {value:.3e}, threshold {threshold}: {meaning}; {advice}"))
    }
}

/// What is known of a run at its end; what is not known is `None`.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    /// Largest part, in magnitude, by which densities claim more volume than the particles fill \[-\].
    pub volume_excess: Option<f64>,
    /// Largest distance from a point of the water to a particle, in spacings \[-\]; of water that fills its container.
    pub cavity: Option<f64>,
    /// Largest speed of the water over the sound speed \[-\].
    pub mach: Option<f64>,
    /// Largest |ρ/ρ₀ − 1| of the water \[-\].
    pub density_variation: Option<f64>,
    /// Largest noise of a load of the water over the load \[-\].
    pub load_noise: Option<f64>,
    /// Energy that no account explains, over the largest of kinetic and available energy at the start and work done \[-\].
    pub energy_residual: Option<f64>,
    /// Largest energy that the solids have gained from contact and the time scheme together, over the same of the
    /// solids \[-\].
    pub energy_gain: Option<f64>,
    /// Particles across the thinnest elastic body.
    pub particles_across: Option<f64>,
    /// Time step over its stability limit at the start \[-\].
    pub step_over_limit: Option<f64>,
    /// Particles that crossed a wall, of both sides.
    pub escaped: Option<f64>,
}

impl Evidence {
    /// The figures with their judgement.
    pub fn figures(&self) -> Vec<QualityFigure> {
        use Side::{AtLeast, AtMost};
        let figure = QualityFigure::new;
        vec![
            figure(
                "volume_excess",
                self.volume_excess,
                (AtMost, if self.cavity.is_some() { LARGEST_EXCESS_WHERE_FULL } else { LARGEST_EXCESS }),
                "volume that the densities claim beyond what the particles fill",
                "use a `[fluid] volume_correction` of at least its default, or refine",
            ),
            figure(
                "cavity_spacings",
                self.cavity,
                (AtMost, LARGEST_CAVITY),
                "farthest point of the water from a particle, in spacings, where water fills its container",
                "use a `[fluid] volume_correction` of at least its default, or raise the pressure of the water so that it \
                 does not tear",
            ),
            figure(
                "mach_number",
                self.mach,
                (AtMost, LARGEST_MACH),
                "largest speed of the water over the sound speed, at the times of the pictures",
                "raise `[fluid] sound_speed_m_s` to ten times the largest speed",
            ),
            figure(
                "density_variation",
                self.density_variation,
                (AtMost, LARGEST_DENSITY_VARIATION),
                "largest departure of a density from that at rest, at the times of the pictures",
                "raise `[fluid] sound_speed_m_s`, or look for an impact or a start that is not in balance",
            ),
            figure(
                "load_noise",
                self.load_noise,
                (AtMost, LARGEST_LOAD_NOISE),
                "swing of a load of the water while sound crosses it, over the load",
                "use means of loads, or a `[fluid] acoustic_relaxation` of at least its default",
            ),
            figure(
                "energy_residual",
                self.energy_residual,
                (AtMost, LARGEST_ENERGY_RESIDUAL),
                "energy that no account explains; what each term feeds or takes is in the energy budget",
                "use a smaller time step",
            ),
            figure(
                "energy_gain",
                self.energy_gain,
                (AtMost, LARGEST_ENERGY_GAIN),
                "energy that the solids have gained from contact and time scheme, over that spent",
                "use a smaller time step: vibrations grow that it does not resolve",
            ),
            figure(
                "particles_across",
                self.particles_across,
                (AtLeast, LEAST_ACROSS),
                "particles across the thinnest elastic body",
                "use a smaller `[solid] particle_spacing_m`",
            ),
            figure(
                "step_over_limit",
                self.step_over_limit,
                (AtMost, LARGEST_STEP_RATIO),
                "time step over its stability limit at the start",
                "use a smaller time step",
            ),
            figure(
                "escaped_particles",
                self.escaped,
                (AtMost, 0.0),
                "particles that crossed a wall or a closed side of the domain",
                "look for gaps in walls and for particles that start in them; use a smaller time step",
            ),
        ]
    }
}

/// The reservations among `figures`, in words.
pub fn reservations(figures: &[QualityFigure]) -> Vec<String> {
    figures.iter().filter_map(QualityFigure::reservation).collect()
}

/// All values that are known, in a line.
pub fn line(figures: &[QualityFigure]) -> String {
    let known = figures.iter().filter_map(|figure| Some(format!("{} {:.3e}", figure.name, figure.value?)));
    known.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_beyond_its_threshold_is_a_reservation_that_says_what_to_do() {
        let good = Evidence {
            volume_excess: Some(-0.004),
            particles_across: Some(3.0),
            escaped: Some(0.0),
            ..Evidence::default()
        };
        let verdicts: Vec<Judgement> = good.figures().iter().map(|figure| figure.verdict).collect();
        assert_eq!(verdicts.iter().filter(|verdict| **verdict == Judgement::Good).count(), 3);
        assert_eq!(verdicts.iter().filter(|verdict| **verdict == Judgement::NotJudged).count(), 7);
        let bad = Evidence {
            volume_excess: Some(-0.012),
            particles_across: Some(2.0),
            escaped: Some(1.0),
            mach: Some(f64::NAN),
            ..Evidence::default()
        };
        let texts = reservations(&bad.figures());
        assert_eq!(texts.len(), 4, "{texts:?}");
        assert!(texts[0].starts_with("volume_excess = -1.200e-2, threshold 0.01: "), "{texts:?}");
        assert!(
            texts[0].ends_with("use a `[fluid] volume_correction` of at least its default, or refine"),
            "{texts:?}"
        );
        assert!(line(&good.figures()).contains("particles_across 3.000e0"));
        // Where water fills its container the same excess is too much.
        let full = Evidence { cavity: Some(0.8), ..good };
        assert!(reservations(&full.figures())[0].starts_with("volume_excess = -4.000e-3, threshold 0.002: "));
    }
}
