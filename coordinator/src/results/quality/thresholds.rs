//! Thresholds of the quality figures. docs/verification.md lists the runs that justify them.

sph::constants! {
    /// Runs that lose their volume have 1.8 % and more, a splash of 30 particles across 0.9 %, the strongest stretch of a
    /// lattice 0.6 %.
    pub const LARGEST_EXCESS: f64 = 0.01, "quality.volume_excess",
        "largest part by which densities may claim another volume than the particles fill [-]";
    /// Where nothing is left out at a surface, disorder alone has 0.1 %, a channel without volume correction 0.3 %.
    pub const LARGEST_EXCESS_WHERE_FULL: f64 = 0.002, "quality.volume_excess_where_full",
        "the same where water fills its container [-]";
    /// Disorder leaves 1.1; a void that opens grows on.
    pub const LARGEST_CAVITY: f64 = 1.5, "quality.cavity",
        "largest distance from a point of water that fills its container to a particle, in spacings [-]";
    /// The usual limit of a flow that counts as incompressible: densities change by Ma²/2 = 4.5 %.
    pub const LARGEST_MACH: f64 = 0.3, "quality.mach", "largest speed over the sound speed [-]";
    /// Ma²/2 = 4.5 % by that speed, and 0.5 % by the rule c₀ ≥ 10 √(gH) for still water of mean depth H/2.
    pub const LARGEST_DENSITY_VARIATION: f64 = 0.05, "quality.density_variation",
        "largest departure of a density from that at rest, over it [-]";
    /// Loads that ring have 0.3 to 1.5; a light body in the air, which carries next to no load, 0.2 at most.
    pub const LARGEST_LOAD_NOISE: f64 = 0.3, "quality.load_noise",
        "largest median swing of a load, within the time that sound takes across the water, over the load [-]";
    pub const LARGEST_ENERGY_RESIDUAL: f64 = 0.001, "quality.energy_residual",
        "largest energy that no account explains, over the largest of those at hand [-]";
    /// A bar that is loaded suddenly has 1 %; an unstable step makes many times what there is.
    pub const LARGEST_ENERGY_GAIN: f64 = 0.05, "quality.energy_gain",
        "largest energy that solids may gain from contact and time scheme, over that spent [-]";
    /// Two particles across bend 0.7 times as easily as they should, three and more within 2 %.
    pub const LEAST_ACROSS: f64 = 3.0, "quality.particles_across",
        "least particles across the thin side of an elastic body [-]";
    pub const LARGEST_STEP_RATIO: f64 = 1.0, "quality.step_over_limit", "largest time step over its stability limit [-]";
}
