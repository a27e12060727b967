//! Thresholds of the fluid's laws that were measured, space by space. Those without a value for space are the plane's there
//! until they are measured.

use sph::thresholds;

thresholds! {
    /// Determinant of the moment matrix below which the density gradient counts as zero: too few neighbours define it
    /// \[-\].
    SMALLEST_GRADIENT_DETERMINANT = 1e-3, "correction.density_gradient.smallest_determinant",
        "determinant of the moment matrix below which the density gradient counts as zero [-]";
    /// Determinant of the moment matrix below which L_i is the unit matrix: in spray a large L_i does more harm than
    /// good \[-\]. At the face of a lattice it is 0.39 in the plane and 0.29 in space, at its edge 0.14 and 0.08.
    SMALLEST_CORRECTION_DETERMINANT = 0.3, in space 0.22, "correction.smallest_determinant",
        "determinant of the moment matrix below which L_i is the unit matrix [-]";
    /// Determinant up to which L_i does not act in Eq. (22) \[-\]. At a surface few neighbours on one side define it:
    /// pressure forces with it tear splashes apart, and raise the frequency of sound above the stability limit of the
    /// time step. Just above that at the face of a lattice.
    LEAST_MOMENTUM_DETERMINANT = 0.4, in space 0.3, "correction.momentum.least_determinant",
        "determinant up to which L_i does not act in Eq. (22) [-]";
    /// Determinant from which on L_i acts in Eq. (22) with its largest share \[-\]. In the second row of a lattice it is 0.90
    /// in the plane and 0.88 in space.
    FULL_MOMENTUM_DETERMINANT = 0.7, in space 0.65, "correction.momentum.full_determinant",
        "determinant from which on L_i acts in Eq. (22) with its largest share [-]";
    /// Lower bound of the mean moment by which the viscous pair force is divided \[-\]: at a free surface half of the
    /// neighbours are missing rightly.
    SMALLEST_MEAN_MOMENT = 0.9, "viscosity.smallest_mean_moment",
        "lower bound of the mean moment by which the viscous pair force is divided [-]";
    /// Upper bound of the same \[-\].
    LARGEST_MEAN_MOMENT = 1.1, "viscosity.largest_mean_moment",
        "upper bound of the mean moment by which the viscous pair force is divided [-]";
    /// Distance up to which artificial viscosity resists all of an approach, in spacings \[-\]. With 0.4 a rotating patch brings
    /// particles to 0.46 spacings; with 0.6 a drop that is stretched to this distance loses 0.5 % of its area.
    PLAIN_DISTANCE = 0.55, "artificial_viscosity.plain_distance",
        "distance up to which artificial viscosity resists all of an approach, in spacings [-]";
    /// The same from which on it resists the residual alone \[-\].
    RESIDUAL_DISTANCE = 0.6, "artificial_viscosity.residual_distance",
        "the same from which on it resists what the rates of strain do not explain [-]";
    /// Factor on the share of solids by which the damper fades \[-\].
    SOLID_FADING = 4.0, "damper.solid_fading",
        "factor on the share of solids in the support by which the acoustic damper fades [-]";
    /// R of the anti-pairing term R (W/W(Δx))⁴ (Monaghan 2000).
    PAIRING = 0.2, "shifting.anti_pairing",
        "factor R of the anti-pairing term R (W/W(dx))^4 of shifting (Monaghan 2000) [-]";
    /// How far, in h, the fluid near a wall particle lies below it on average, up to which the particle is beside the fluid.
    /// Level with the first row below a surface it is 0.22.
    WET_OFFSET = 0.3, "walls.wet_offset",
        "mean distance below a wall particle of the fluid near it, up to which it acts in full, in h [-]";
    /// The same from which on the particle is above the fluid. One row higher it is 0.78.
    DRY_OFFSET = 0.6, "walls.dry_offset", "the same from which on it does not act [-]";
    /// Smallest eigenvalue of the moment matrix below which a particle may lie at the free surface \[-\].
    SURFACE_EIGENVALUE = 0.75, "surface.largest_eigenvalue",
        "smallest eigenvalue of the moment matrix below which a particle may lie at the free surface [-]";
    /// Smallest eigenvalue of the moment matrix below which a particle is spray: with so few neighbours a shift has
    /// no meaning \[-\].
    SPRAY_EIGENVALUE = 0.3, "surface.spray_eigenvalue",
        "smallest eigenvalue of the moment matrix below which a particle is spray and is not shifted [-]";
    /// k of p/(k ρ U_i²): up to 1 a particle is shifted in full, from 2 on not at all \[-\]. Such a pressure orders
    /// particles by itself, and the two would work against each other: shifting moves particles at constant density,
    /// pressure moves them back and changes it, so that fluid with pressure waves would contract.
    ORDERED_BY_PRESSURE = 100.0, "shifting.ordered_by_pressure",
        "p/(rho U^2) up to which shifting acts in full; from twice that on it does not act [-]";
    /// The same k with the volume correction \[-\], which keeps the volume when both work against each other.
    ORDERED_BY_PRESSURE_AT_VOLUME = 1000.0, "shifting.ordered_by_pressure_at_volume",
        "the same with volume_correction [-]";
    /// Least claim of the fluid on a node that counts in the volume correction, over that of walls and solids \[-\].
    /// Reached about a spacing and a half behind a face; walls of few layers do not fill what has a weight on nodes much
    /// farther behind.
    LEAST_FLUID_CLAIM = 0.02, "volume_correction.least_claim",
        "least claim of the fluid on a node of the background grid, over that of walls and solids [-]";
    /// Least mean claim around a particle of a solid that is surrounded \[-\]: the first row at a face that nothing
    /// touches has 0.68, the second 0.92.
    LEAST_CLAIM_AROUND_SOLIDS = 0.85, "volume_correction.least_claim_around_solids",
        "least claim around a particle of a solid, below which volume next to it counts as void [-]";
    /// Largest |ε| that the volume correction takes \[-\]: beyond, voids open and no density is right.
    LARGEST_VOLUME_EXCESS = 0.02, "volume_correction.largest_excess",
        "largest excess of volume that the volume correction takes [-]";
    /// Largest speed k U of the volume correction, in c₀ \[-\]: slow against sound, and a small part of ε in a step.
    LARGEST_VOLUME_SPEED = 0.2, "volume_correction.largest_speed",
        "largest speed k U of the volume correction, over c0 [-]";
    /// Smallest eigenvalue of the moment matrix up to which the volume correction does not act \[-\]: nodes read the gaps of
    /// strongly stretched particles, by 0.3 % at a stretch of 1.6 and 2 % at 1.9, and void counts as missing volume.
    LEAST_VOLUME_EIGENVALUE = 0.87, "volume_correction.least_eigenvalue",
        "smallest eigenvalue of the moment matrix up to which the volume correction does not act [-]";
    /// The same from which on it acts in full \[-\]. Of disordered water 99 % is above, as is a lattice that is stretched 1.5
    /// times.
    FULL_VOLUME_EIGENVALUE = 0.93, "volume_correction.full_eigenvalue",
        "smallest eigenvalue of the moment matrix from which on the volume correction acts in full [-]";
    /// Σ_j V_j W over fluid neighbours up to which a particle is alone \[-\]. One at a distance of Δx gives 0.12.
    LONE_SHARE = 0.02, "volume_correction.lone_share",
        "weight of the fluid around a particle up to which it is alone: only walls and solids change its density [-]";
    /// The same from which on it is not alone at all \[-\].
    ACCOMPANIED_SHARE = 0.1, "volume_correction.accompanied_share",
        "weight of the fluid around a particle from which on it is not alone at all [-]";
    /// |ρ/ρ₀ − 1| of a lone particle up to which it is left alone \[-\]: what rest and waves do to density.
    LONE_COMPRESSION = 0.01, "volume_correction.lone_compression",
        "relative change of the density of a lone particle that is not relaxed [-]";
    /// h |Σ V_j ∇W| of a particle up to which the neighbours surround it \[-\]. It is 0.16 where a row faces another across a gap
    /// of a quarter of a spacing, 0.31 at half a spacing and 0.58 at a free surface, in the plane as in space. With 0.05 disorder
    /// under a jet on a plate counts as void and feeds energy to the water, with 0.1 that of a stretched lattice that buckles.
    LEAST_VOID_GRADIENT = 0.2, "voids.least_gradient",
        "h times the sum of V grad W of a particle, up to which its neighbours surround it [-]";
    /// The same from which on what lies beyond a void does not count in Eq. (17) \[-\].
    FULL_VOID_GRADIENT = 0.4, "voids.full_gradient",
        "the same from which on neighbours beyond the void do not count in Eq. (17) [-]";
    /// Cosine of the angle to the direction of a void from which on a neighbour lies beyond it \[-\].
    VOID_COSINE = 0.5, "voids.beyond_cosine",
        "cosine of the angle to the direction of a void, from which on a neighbour lies beyond it [-]";
    /// Largest tension −p that the tensile control removes, in ρ₀c₀² \[-\]. It is not conservative: the tension of a
    /// closing void would return as motion. Flows of a tenth of c₀ stay below a few thousandths.
    LARGEST_TENSION = 1e-3, "tensile_control.largest_tension",
        "largest tension that tensile control removes, over rho0 c0^2 [-]";
    /// Share of solids Σ V_s W around a fluid particle above which it counts as immersed: that at a solid's face
    /// \[-\].
    IMMERSED_SHARE = 0.5, "interface.immersed_share",
        "share of solids around a fluid particle above which it counts as immersed [-]";
    /// Factor on √(h/|a|) in the time-step limit \[-\].
    ACCELERATION_FACTOR = 0.25, "time_step.acceleration_factor",
        "factor on sqrt(h/|a|) in the time-step limit [-]";
    /// Factor on h²/ν in the time-step limit \[-\].
    VISCOUS_FACTOR = 0.125, "time_step.viscous_factor",
        "factor on h^2/nu in the time-step limit [-]";
}
