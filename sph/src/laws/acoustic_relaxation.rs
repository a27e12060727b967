//! Acoustic relaxation: a pressure with memory beside the equation of state, which absorbs sound.

use crate::lanes::Real;

crate::constants! {
    /// Without a limit a body that rebounds from water is held back by 21 kPa; with none at all a pool that has been
    /// struck rings on below p = 0, where q could not act. At 0.001 it rings no longer, and an impulse on a plate is as
    /// without relaxation.
    pub const LARGEST_TENSION: f64 = 0.001,
        "acoustic_relaxation.largest_tension", "largest tension that acoustic relaxation adds, over rho0 c0^2 [-]";
}

/// A Maxwell element of modulus ρ c_h² and relaxation time τ beside Eq. (3).
///
/// ```text
/// dq/dt = c_h² dρ/dt|₍₁₇₎ − q/τ = −ρ c_h² ∇·v − q/τ,   c_h² = r c₀²
/// ```
/// p + q takes the place of p wherever a pressure acts. Slow flow meets p alone, sound of ω ≫ 1/τ the stiffness ρ (1 + r) c₀².
/// A small r takes ½ r ω² τ/(1 + ω²τ²) per second off the amplitude of sound: all sound above 1/τ decays alike, whatever
/// its wavelength, where a bulk viscosity reaches the shortest waves alone. As an equation for ∇·v it is hyperbolic and
/// parabolic divergence cleaning (Fourtakas, Vacondio & Rogers 2025).
///
/// It is passive: the element stores Σ V q²/(2ρc_h²) and loses Σ V q²/(ρc_h²τ) ≥ 0 per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcousticRelaxation {
    square_speed: f64,
    time: f64,
    tension: f64,
}

impl AcousticRelaxation {
    /// Square c_h² of the speed of sound by the element alone \[m²/s²\], relaxation time τ \[s\]; it adds no tension.
    pub fn new(square_speed: f64, time: f64) -> Self {
        Self { square_speed, time, tension: 0.0 }
    }

    /// Adds a tension of at most `tension` t \[Pa\].
    pub fn bearing(self, tension: f64) -> Self {
        Self { tension, ..self }
    }

    /// q \[Pa\] within its limit where Eq. (3) gives `pressure` p \[Pa\]: tension would hold fluid back that leaves a
    /// wall.
    ///
    /// ```text
    /// max(q, −max(p, 0) − t)
    /// ```
    /// This only moves q toward zero: it loses energy.
    #[inline(always)]
    pub fn limited<R: Real>(&self, q: R, pressure: R) -> R {
        q.max(R::splat(-self.tension) - pressure.max(R::zero()))
    }

    /// The element after `duration` \[s\].
    pub fn after(&self, duration: f64) -> Relaxed {
        let exponent = -duration / self.time;
        let kept = exponent.exp();
        let gained = -self.square_speed * self.time * exponent.exp_m1();
        let steady = self.square_speed * self.time;
        // ∫ 1, 2 e⁻ᵗ, e⁻²ᵗ over the duration, over c_h² τ.
        let weights = [
            duration / steady,
            -2.0 * exponent.exp_m1() / self.square_speed,
            -0.5 * (2.0 * exponent).exp_m1() / self.square_speed,
        ];
        Relaxed { kept, gained, steady, weights }
    }

    /// Energy that the element stores in a particle of `mass` m per depth \[kg/m\] \[J/m\].
    ///
    /// ```text
    /// m q²/(2 ρ² c_h²)
    /// ```
    #[inline(always)]
    pub fn stored_energy<R: Real>(&self, q: R, mass: R, density: R) -> R {
        let strain = q / density;
        R::splat(0.5 / self.square_speed) * mass * (strain * strain)
    }

    /// Power that the element loses in a particle of `mass` m per depth \[kg/m\] \[W/m\]: 2/τ times what it stores.
    ///
    /// ```text
    /// m q²/(ρ² c_h² τ)
    /// ```
    #[inline(always)]
    pub fn loss<R: Real>(&self, q: R, mass: R, density: R) -> R {
        R::splat(2.0 / self.time) * self.stored_energy(q, mass, density)
    }
}

/// The solution over some time at a constant density rate R: exact, so that any τ goes with any step.
///
/// ```text
/// q ← E q + c_h² τ (1 − E) R,   E = exp(−Δt/τ)
/// ```
/// ```
/// // Slow compression meets a bulk viscosity ρ c_h² τ: q = c_h² τ R = 100 · 0.01 · 3 Pa.
/// let element = sph::laws::acoustic_relaxation::AcousticRelaxation::new(100.0, 0.01);
/// assert!((element.after(1.0).pressure(7.0, 3.0) - 3.0).abs() < 1e-12);
/// // Fast compression by 1 kg/m³ meets the stiffness c_h² = 100 m²/s².
/// assert!((element.after(1e-9).pressure(0.0, 1e9) - 100.0).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxed {
    kept: f64,
    gained: f64,
    /// q at rest over R: c_h² τ \[m²/s\].
    steady: f64,
    weights: [f64; 3],
}

impl Relaxed {
    /// q \[Pa\] from that before, at a density rate of `rate` \[kg/(m³ s)\].
    #[inline(always)]
    pub fn pressure<R: Real>(&self, q: R, rate: R) -> R {
        q * R::splat(self.kept) + self.gain(rate)
    }

    /// What the element loses on the way from q = `q` \[Pa\] at a density rate of `rate` \[kg/(m³ s)\], in a particle of
    /// `mass` m per depth \[kg/m\] \[J/m\].
    ///
    /// ```text
    /// m/(ρ² c_h² τ) ∫ q² dt,   q = q_R + (q₀ − q_R) e⁻ᵗᐟᵀ,   q_R = c_h² τ R
    /// ```
    #[inline(always)]
    pub fn lost<R: Real>(&self, q: R, rate: R, mass: R, density: R) -> R {
        let [whole, linear, square] = self.weights.map(R::splat);
        let rest = rate * R::splat(self.steady);
        let excess = q - rest;
        let integral = whole * (rest * rest) + linear * (rest * excess) + square * (excess * excess);
        mass * integral / (density * density)
    }

    /// The part of it that the density rate causes \[Pa\].
    #[inline(always)]
    pub fn gain<R: Real>(&self, rate: R) -> R {
        rate * R::splat(self.gained)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_parts_of_a_step_make_the_whole() {
        let element = AcousticRelaxation::new(400.0, 2e-3);
        let [half, whole] = [1e-3, 2e-3].map(|duration| element.after(duration));
        let (q, rate) = (50.0, -7.0);
        // Round-off of a few operations.
        assert!((half.pressure(half.pressure(q, rate), rate) - whole.pressure(q, rate)).abs() < 1e-12);
    }

    #[test]
    fn what_relaxes_is_lost() {
        // At rest dE/dt = −loss; central difference over 2e-7 of τ.
        let element = AcousticRelaxation::new(400.0, 2e-3);
        let energy = |time: f64| element.stored_energy(element.after(time).pressure(80.0, 0.0), 0.1, 1000.0);
        let (time, step) = (1e-3, 2e-10);
        let rate = (energy(time + step) - energy(time - step)) / (2.0 * step);
        let loss = element.loss(element.after(time).pressure(80.0, 0.0), 0.1, 1000.0);
        assert!((rate / loss + 1.0).abs() < 1e-6, "{rate} {loss}");
    }

    #[test]
    fn the_loss_of_a_step_is_the_integral_of_the_power() {
        let element = AcousticRelaxation::new(400.0, 2e-3);
        let (q, rate, duration, parts) = (80.0, -90.0, 3e-3, 20_000);
        let part = duration / f64::from(parts);
        let power = |k: u32| {
            let q = element.after(part * (f64::from(k) + 0.5)).pressure(q, rate);
            element.loss(q, 0.1, 1000.0)
        };
        let sum = (0..parts).map(power).sum::<f64>() * part;
        let lost = element.after(duration).lost(q, rate, 0.1, 1000.0);
        // The midpoint rule with parts of 7.5e-5 τ.
        assert!((lost / sum - 1.0).abs() < 1e-7, "{lost} {sum}");
        // With the work of compression R/ρ·∫(−q) dt it makes up the change of the store.
        let end = element.after(duration).pressure(q, rate);
        let work = rate * 2e-3 * (400.0 * rate * duration - (end - q)) * 0.1 / 1e6;
        let stored = |q: f64| element.stored_energy(q, 0.1, 1000.0);
        // Round-off.
        assert!((stored(end) - stored(q) - work + lost).abs() < 1e-14 * lost.abs().max(1.0), "{work}");
    }

    #[test]
    fn the_limit_leaves_little_tension() {
        let element = AcousticRelaxation::new(400.0, 2e-3).bearing(1.0);
        for (q, p, expected) in [(-5.0, 3.0, -4.0), (-2.0, 3.0, -2.0), (-5.0, -3.0, -1.0), (4.0, -3.0, 4.0)] {
            assert_eq!(element.limited(q, p), expected);
        }
    }
}
