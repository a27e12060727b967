//! The acoustic relaxation of a stage.

use sph::coupling::stage::StageTime;
use sph::lanes::Lanes;
use sph::laws::acoustic_relaxation::{AcousticRelaxation, Relaxed};

use crate::rates::particle_rates::StagePart;

/// How the pressure q of the acoustic relaxation passes through a stage, with R of Eq. (17).
///
/// ```text
/// Eq. (30)-(31):          q      ← E q at the start + c_h² τ (1 − E) R over the stage
/// leapfrog, predictor:    qⁿ⁺¹ᐟ² = E qⁿ⁻¹ᐟ² + c_h² τ (1 − E) Rⁿ,  over Δt̄ between the middles of the steps
///           corrector:    qⁿ⁺¹   = E qⁿ⁺¹ᐟ² + c_h² τ (1 − E) Rⁿ,  over Δt/2, for what reads the boundary
/// ```
/// As with ρ, the predictor starts from qⁿ and replaces the part of Rⁿ⁻¹ in it.
#[derive(Clone, Copy, Debug)]
pub struct StageRelaxation {
    /// The law.
    pub law: AcousticRelaxation,
    /// Since the middle of the step before, with leapfrog.
    since: Relaxed,
    /// From the state that the stage starts from to the one that it ends with.
    ahead: Relaxed,
}

impl StageRelaxation {
    /// Of a stage that computes `part` of the rates; `density_age` \[s\] as in [`crate::system::state::FluidState`].
    pub fn new(law: AcousticRelaxation, part: StagePart, density_age: f64, time: &StageTime) -> Self {
        let duration = if part == StagePart::Whole { time.duration() } else { 0.5 * time.time_step };
        Self { law, since: law.after(density_age), ahead: law.after(duration) }
    }

    /// q \[Pa\] at the end from that before, at a density `rate` \[kg/(m³ s)\].
    #[inline(always)]
    pub fn advanced<L: Lanes>(&self, q: L, rate: L) -> L {
        self.ahead.pressure(q, rate)
    }

    /// The same in the predictor of leapfrog; `before` is the density rate at the start of the step before.
    #[inline(always)]
    pub fn predicted<L: Lanes>(&self, q: L, rate: L, before: L) -> L {
        self.advanced(self.corrected(q, rate, before), rate)
    }

    /// What the element loses in the stage on the way to [`Self::advanced`] \[J/m\]; `q`, `rate`, mass and density as
    /// in [`Relaxed::lost`].
    #[inline(always)]
    pub fn lost<L: Lanes>(&self, q: L, rate: L, mass: L, density: L) -> L {
        self.ahead.lost(q, rate, mass, density)
    }

    /// q of the predictor of leapfrog with the new rate in place of the one `before`, from which it is advanced.
    #[inline(always)]
    pub fn corrected<L: Lanes>(&self, q: L, rate: L, before: L) -> L {
        q + self.since.gain(rate - before)
    }

    /// `q` within its limit, where Eq. (3) gives `pressure` \[Pa\].
    #[inline(always)]
    pub fn limited<L: Lanes>(&self, q: L, pressure: L) -> L {
        self.law.limited(q, pressure)
    }
}
