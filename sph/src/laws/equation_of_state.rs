//! Equation of state of a weakly compressible fluid, Eq. (3).

use std::ops::Mul;

use crate::lanes::Lanes;

crate::constants! {
    /// Jets that meet at a third of c₀ compress single particles by a third and more, for some steps.
    pub const LARGEST_COMPRESSION: f64 = 0.5, "density.largest_compression",
        "largest compression of a valid fluid, relative to rest density [-]";
    const LARGEST_EXPANSION: f64 = 0.3, "density.largest_expansion",
        "largest expansion of a valid fluid, and of wall and interface particles in tension, likewise [-]";
    /// Particles are some three spacings apart then; beyond that they do not meet.
    pub(crate) const LARGEST_CAVITY: f64 = 0.9, "density.largest_cavity",
        "largest share of cavities in the volume of a valid fluid with `tension_limit_pa` [-]";
}

/// Tait's equation of state.
///
/// ```text
/// p = p₀·[(ρ/ρ₀)^γ − 1],  p₀ = ρ₀c₀²/γ                             Eq. (3)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tait {
    rest_density: f64,
    stiffness: f64,
    exponent: f64,
    /// Lowest pressure \[Pa\], and the density at which Eq. (3) reaches it \[kg/m³\].
    lowest: (f64, f64),
    /// Background pressure \[Pa\].
    background: f64,
}

impl Tait {
    /// Rest density ρ₀ \[kg/m³\], sound speed c₀ \[m/s\], exponent γ \[-\].
    pub fn new(rest_density: f64, sound_speed: f64, exponent: f64) -> Self {
        let stiffness = rest_density * sound_speed * sound_speed / exponent;
        Self { rest_density, stiffness, exponent, lowest: (f64::NEG_INFINITY, 0.0), background: 0.0 }
    }

    /// The linear equation of state (Morris, Fox & Zhu 1997), Eq. (3) with γ = 1.
    ///
    /// ```text
    /// p = c₀²(ρ − ρ₀)
    /// ```
    /// ```
    /// // 100 · 10 Pa.
    /// let water = sph::laws::equation_of_state::Tait::linear(1000.0, 10.0);
    /// assert!((water.pressure(1010.0) - 1000.0).abs() < 1e-9);
    /// assert!((water.density(-500.0) - 995.0).abs() < 1e-9);
    /// ```
    pub fn linear(rest_density: f64, sound_speed: f64) -> Self {
        Self::new(rest_density, sound_speed, 1.0)
    }

    /// The same for a fluid that bears no more than `tension` \[Pa\]: beyond it cavities open.
    ///
    /// ```text
    /// p = max(Eq. (3), −tension)
    /// ```
    /// The density is then that of water with cavities. It keeps account of their volume, so that water feels pressure
    /// again when they have closed, not before.
    /// ```
    /// let water = sph::laws::equation_of_state::Tait::new(1000.0, 10.0, 1.0).bearing(2e3);
    /// assert!((water.pressure(990.0) + 1e3).abs() < 1e-9);
    /// assert_eq!(water.pressure(700.0), -2e3);
    /// ```
    #[must_use]
    pub fn bearing(self, tension: f64) -> Self {
        // Above zero, so that its inverse is a number where Eq. (3) bears less than the limit.
        Self { lowest: (-tension, self.density(-tension).max(f64::MIN_POSITIVE)), ..self }
    }

    /// The same under a background pressure p_b \[Pa\] (Adami, Hu & Adams 2012).
    ///
    /// ```text
    /// p = Eq. (3) + p_b
    /// ```
    /// In Eq. (22) it adds −2 p_b/ρ_i Σ V_j ∇W, which vanishes where particles are evenly distributed.
    /// ```
    /// let water = sph::laws::equation_of_state::Tait::new(1000.0, 10.0, 7.0).under(500.0);
    /// assert_eq!(water.pressure(1000.0), 500.0);
    /// assert!((water.density(500.0) - 1000.0).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn under(self, background: f64) -> Self {
        Self { background, ..self }
    }

    /// Exponent γ \[-\].
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Lowest density at which a fluid is taken for sound \[kg/m³\].
    ///
    /// Eq. (3) means nothing in strong tension. Cavities may take any room that particles can be apart and still meet.
    #[inline]
    pub fn lowest_density(&self) -> f64 {
        let share = if self.lowest.0.is_finite() { LARGEST_CAVITY } else { LARGEST_EXPANSION };
        (1.0 - share) * self.rest_density
    }

    /// Pressure \[Pa\] at `density` \[kg/m³\].
    ///
    /// ```
    /// // Linear limit γ = 1: p = c₀²(ρ − ρ₀) = 100 · 10 Pa.
    /// let water = sph::laws::equation_of_state::Tait::new(1000.0, 10.0, 1.0);
    /// assert!((water.pressure(1010.0) - 1000.0).abs() < 1e-9);
    /// ```
    #[inline]
    pub fn pressure(&self, density: f64) -> f64 {
        let ratio = density / self.rest_density;
        let power = if self.exponent == 7.0 {
            sixth_power(ratio) * ratio
        } else if self.exponent == 1.0 {
            ratio
        } else {
            ratio.powf(self.exponent)
        };
        (self.stiffness * (power - 1.0)).max(self.lowest.0) + self.background
    }

    /// [`Tait::pressure`] of four particles, to the same bits.
    #[inline(always)]
    pub fn pressures<L: Lanes>(&self, density: L) -> L {
        if self.exponent != 7.0 {
            return L::from_array(density.to_array().map(|density| self.pressure(density)));
        }
        let ratio = density / L::splat(self.rest_density);
        let power = sixth_power(ratio) * ratio;
        let pressure = (L::splat(self.stiffness) * (power - L::splat(1.0))).max(L::splat(self.lowest.0));
        pressure + L::splat(self.background)
    }

    /// Density \[kg/m³\] at `pressure` \[Pa\]: the inverse; a pressure below −p₀ gives density zero.
    #[inline]
    pub fn density(&self, pressure: f64) -> f64 {
        let pressure = pressure - self.background;
        self.rest_density * (pressure / self.stiffness + 1.0).max(0.0).powf(1.0 / self.exponent)
    }

    /// Density \[kg/m³\] that a wall or interface particle shows to the fluid at `pressure` \[Pa\].
    ///
    /// It follows the pressure down to the density at which a run stops: the inverse alone would reach zero, by which
    /// pair forces divide.
    #[inline]
    pub fn wall_density(&self, pressure: f64) -> f64 {
        self.density(pressure).max((1.0 - LARGEST_EXPANSION) * self.rest_density)
    }

    /// Compression energy per mass \[J/kg\]: ∫ p/ρ² dρ from ρ₀ to `density`.
    ///
    /// ```text
    /// e = p₀/ρ₀·[ (q^(γ−1) − 1)/(γ − 1) + 1/q − 1 ],  q = ρ/ρ₀
    /// ```
    /// Where cavities have opened the pressure is constant.
    #[inline]
    pub fn compression_energy(&self, density: f64) -> f64 {
        let (lowest, whole) = self.lowest;
        let cavities = if density < whole { lowest * (1.0 / whole - 1.0 / density) } else { 0.0 };
        let q = density.max(whole) / self.rest_density;
        let power = if (self.exponent - 1.0).abs() < 1e-12 {
            q.ln()
        } else if self.exponent == 7.0 {
            (sixth_power(q) - 1.0) / 6.0
        } else {
            (q.powf(self.exponent - 1.0) - 1.0) / (self.exponent - 1.0)
        };
        let background = self.background * (1.0 / self.rest_density - 1.0 / density);
        self.stiffness / self.rest_density * (power + 1.0 / q - 1.0) + cavities + background
    }

    /// [`Tait::compression_energy`] of four particles, to the same bits.
    #[inline(always)]
    pub fn compression_energies<L: Lanes>(&self, density: L) -> L {
        if self.exponent != 7.0 || self.background != 0.0 {
            return L::from_array(density.to_array().map(|density| self.compression_energy(density)));
        }
        let ((lowest, whole), one) = (self.lowest, L::splat(1.0));
        let q = density.max(L::splat(whole)) / L::splat(self.rest_density);
        let power = (sixth_power(q) - one) / L::splat(6.0);
        let of_water = L::splat(self.stiffness / self.rest_density) * (power + one / q - one);
        if lowest.is_infinite() {
            return of_water;
        }
        // Nothing without cavities.
        let torn = density.min(L::splat(whole));
        of_water + L::splat(lowest) * (L::splat(1.0 / whole) - one / torn)
    }
}

#[inline(always)]
fn sixth_power<T: Copy + Mul<Output = T>>(x: T) -> T {
    let cube = x * x * x;
    cube * cube
}

#[cfg(test)]
mod tests {
    use crate::lanes::{Arithmetic, LanePass};

    use super::*;

    #[test]
    fn density_inverts_pressure_and_energy_integrates_it() {
        for (exponent, background) in [(1.0, 0.0), (1.4, 0.0), (7.0, 0.0), (7.0, 2e3)] {
            let water = Tait::new(1000.0, 20.0, exponent).under(background);
            for rho in [960.0, 1000.0, 1003.0, 1080.0] {
                assert!((water.density(water.pressure(rho)) - rho).abs() < 1e-9);
                let step = 1e-2;
                let slope = (water.compression_energy(rho + step) - water.compression_energy(rho - step))
                    / (2.0 * step);
                // Central difference of a function of curvature ~1e-4 J m⁶/kg³: error below 1e-7.
                assert!((slope - water.pressure(rho) / (rho * rho)).abs() < 1e-6);
            }
            // dp/dρ at rest is c₀² = 400 m²/s².
            let slope = (water.pressure(1000.01) - water.pressure(999.99)) / 0.02;
            assert!((slope - 400.0).abs() < 1e-3);
        }
    }

    /// Pressures and energies of four densities.
    struct InLanes(Tait, [f64; 4]);

    impl LanePass for InLanes {
        type Output = [[f64; 4]; 2];

        #[inline(always)]
        fn run<L: Lanes>(self) -> [[f64; 4]; 2] {
            let density = L::from_array(self.1);
            [self.0.pressures(density).to_array(), self.0.compression_energies(density).to_array()]
        }
    }

    #[test]
    fn four_particles_have_the_bits_of_each_alone() {
        let densities = [460.0, 1000.0, 1003.7, 1080.3];
        for exponent in [1.0, 1.4, 7.0] {
            // Eq. (3) bears 57 kPa at most with the exponent 7.
            for water in [(1000.0, 0.0), (30e3, 0.0), (60e3, 0.0), (f64::INFINITY, 0.0), (f64::INFINITY, 3e3)]
                .map(|(tension, background)| {
                    Tait::new(1000.0, 20.0, exponent).bearing(tension).under(background)
                })
            {
                let alone = [
                    densities.map(|rho| water.pressure(rho)),
                    densities.map(|rho| water.compression_energy(rho)),
                ];
                for arithmetic in Arithmetic::all() {
                    assert_eq!(arithmetic.run(InLanes(water, densities)), alone, "{exponent}");
                }
            }
        }
    }

    #[test]
    fn cavities_open_at_the_largest_tension_and_keep_energy_and_pressure_in_step() {
        let water = Tait::new(1000.0, 20.0, 7.0).bearing(5e3);
        assert_eq!(water.pressure(500.0), -5e3);
        assert_eq!(water.pressure(1003.0), Tait::new(1000.0, 20.0, 7.0).pressure(1003.0));
        for rho in [300.0, 985.0, 1003.0] {
            let step = 1e-2;
            let slope =
                (water.compression_energy(rho + step) - water.compression_energy(rho - step)) / (2.0 * step);
            // Central difference; at 300 kg/m³ the third derivative of p/ρ² is 1e-7 of it.
            assert!((slope - water.pressure(rho) / (rho * rho)).abs() < 1e-6, "{rho}");
        }
        assert!((water.lowest_density() - 100.0).abs() < 1e-9);
        assert!((Tait::new(1000.0, 20.0, 7.0).lowest_density() - 700.0).abs() < 1e-9);
    }

    #[test]
    fn walls_show_a_density_in_any_tension() {
        let water = Tait::new(1000.0, 20.0, 7.0);
        // p₀ = ρ₀c₀²/γ = 57,143 Pa; at −p₀ and below the inverse is zero.
        for pressure in [-57_142.0, -57_143.0, -1e9] {
            assert_eq!(water.wall_density(pressure), 700.0, "{pressure} Pa");
        }
        // p(0.7 ρ₀) = −52,437 Pa: above it the inverse holds.
        for pressure in [-5e4, 0.0, 1e5] {
            assert_eq!(water.wall_density(pressure).to_bits(), water.density(pressure).to_bits());
        }
    }
}
