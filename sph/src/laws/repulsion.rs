//! Repulsion of particles that come too close to a face for their pair forces, which vanish where particles meet.

/// A spring with a dashpot that sets in below a distance and never pulls.
///
/// ```text
/// a = [ω² (D − y) − 2 ζ ω w u]₊ for y < D,  ω = √k c₀/Δx,  D = 0.6 Δx,  ζ = ½,  w = min(1, 4 (D − y)/D)
/// ```
/// y is the height over the outer row of the face, u the speed at which the two part. The dashpot keeps water from bouncing; it sets in with w, so that the
/// acceleration is continuous, and acts in full from a depth of D/4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repulsion {
    /// Distance D at which it sets in \[m\].
    distance: f64,
    /// Frequency ω \[1/s\].
    frequency: f64,
}

crate::constants! {
    pub(crate) const DAMPING: f64 = 0.5, "repulsion.damping",
        "share of critical damping of the repulsion by faces [-]";
    pub(crate) const DISTANCE: f64 = 0.6, "repulsion.distance",
        "height over the outer row of a face at which it repels, in mean spacings of the two [-]";
}

impl Repulsion {
    /// A repulsion of coefficient k \[-\] between particles a mean of `spacing` \[m\] apart, in a fluid of spacing Δx
    /// \[m\] and sound speed c₀ \[m/s\].
    pub fn new(coefficient: f64, spacing: f64, fluid_spacing: f64, sound_speed: f64) -> Self {
        Self { distance: DISTANCE * spacing, frequency: coefficient.sqrt() * sound_speed / fluid_spacing }
    }

    /// Whether it acts at all.
    pub fn acts(&self) -> bool {
        self.frequency > 0.0
    }

    /// Distance D within which it acts \[m\].
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// Acceleration away from the other \[m/s²\] at `distance` \[m\], parting at `parting` \[m/s\].
    #[inline]
    pub fn acceleration(&self, distance: f64, parting: f64) -> f64 {
        let depth = self.distance - distance;
        if depth <= 0.0 {
            return 0.0;
        }
        let onset = (4.0 * depth / self.distance).min(1.0);
        let spring = self.frequency * self.frequency * depth;
        (spring - 2.0 * DAMPING * self.frequency * onset * parting).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn never_pulls_sets_in_without_a_jump_and_takes_energy_out() {
        let law = Repulsion::new(0.25, 0.02, 0.02, 20.0);
        // ω = ½·20/0.02 = 500 1/s: at depth 2 mm and at rest ω²·2 mm.
        assert!((law.acceleration(0.01, 0.0) - 500.0).abs() < 1e-9);
        assert_eq!(law.acceleration(0.012, -3.0), 0.0);
        assert!(law.acceleration(0.012 * (1.0 - 1e-9), -3.0) < 1e-4);
        assert_eq!(law.acceleration(0.01, 100.0), 0.0);
        // A particle that falls in at 1 m/s leaves more slowly.
        let (mut r, mut v, dt) = (0.012, -1.0, 1e-6);
        while r < 0.012 || v < 0.0 {
            v += dt * law.acceleration(r, v);
            r += dt * v;
        }
        assert!(v > 0.1 && v < 0.7, "{v}");
    }
}
