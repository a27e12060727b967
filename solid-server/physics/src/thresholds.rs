//! Thresholds of the solid's laws that were measured, space by space.

use sph::thresholds;

thresholds! {
    /// Smallest eigenvalue of the moment of Eq. (21) along which the velocity gradient is corrected \[-\]. In the bulk it
    /// is 1, at the corner of a lattice of h = 1.3 Δx about 0.3, in space 0.21. Below a third of that too few neighbours lie
    /// along that direction, and the gradient along it stays as summed.
    SMALLEST_MOMENT = 0.1, in space 0.07, "solid.correction.smallest_eigenvalue", "eigenvalue of the moment matrix below which L_i does not correct along its direction [-]";
    /// Courant number of the stage rule \[-\] with the artificial viscosity A = 1. The sums of a lattice in space are
    /// stiffer: a cube is stable at 0.7, not at 0.85.
    DAMPED_COURANT = 1.0, in space 0.65, "solid.stage_rule.damped_courant", "c_L dt/h of the stage rule with artificial viscosity A = 1 [-]";
    /// Smallest Courant number of the stage rule \[-\]: that without artificial viscosity.
    UNDAMPED_COURANT = 0.1, "solid.stage_rule.undamped_courant", "smallest c_L dt/h of the stage rule, without artificial viscosity [-]";
    /// Largest c_L Δt/h \[-\] of velocity Verlet for an updated-Lagrangian body. With A = 1 a block is stable at 1, not at 1.2. Without
    /// viscosity the energy of a small shaken block grows by 2.8 in 200 steps at 0.6 in the plane; in space by 2.0 at 0.3, by
    /// 3.8 at 0.45 and by 13 at 0.6.
    VERLET_COURANT = 0.6, in space 0.4, "solid.substeps.courant", "largest c_L dt/h of a sub-step of an updated-Lagrangian body [-]";
    /// Largest c_L Δt/h of the stage rule \[-\] for a total-Lagrangian body with A = 1 and h = 1.3 Δx. Measured on a
    /// cantilever with a stencil of h = 0.8 Δx: stable at 0.4, not at 0.59. In space, with the Courant number there, a cube is
    /// stable at 0.26, not at 0.3.
    REFERENCE_COURANT = 0.4, "solid.stage_rule.total_lagrangian_courant", "largest c_L dt/(1.3 dx) of the stage rule of a total-Lagrangian body with A = 1 [-]";
    /// Angular frequency of the stiffest vibration of a lattice of total-Lagrangian particles, in units of c_L/Δx \[-\]. For kernel
    /// ratios of 0.72 to 0.9 and Poisson's ratios of 0 to 0.45 it is 1.87 to 2.09 in the plane and 2.11 to 2.48 in space.
    STIFFEST_LATTICE = 2.0, in space 2.3, "solid.substeps.stiffest_lattice", "angular frequency of the stiffest vibration of a lattice over c_L/dx [-]";
    /// Part of 2/ω to which velocity Verlet is used \[-\]; the power iteration may miss some per cent of ω.
    VERLET_FRACTION = 0.9, "solid.substeps.frequency_fraction", "part of 2/omega to which a sub-step of a total-Lagrangian body goes [-]";
    /// Coefficient of the acceleration limit √(Δx/a) \[-\].
    ACCELERATION_COEFFICIENT = 0.25, "solid.acceleration_coefficient", "coefficient of the step limit sqrt(dx/a) [-]";
    /// Weight of a boundary point over that of the particle at twice its distance \[-\]. One-sided differences at ½ΔX and
    /// −ΔX are exact for quadratic fields with weights inverse to the cubed distance.
    BOUNDARY_WEIGHT = 8.0, "solid.clamp.boundary_weight", "weight of the boundary point of a clamp over that of the held particle [-]";
    /// Support radius of the density field of contact in spacings \[-\]: wide enough to smooth the corrugation of the
    /// lattice.
    CONTACT_REACH = 3.0, "solid.contact.reach", "support radius of the density field of contact in spacings [-]";
    /// Depth in contact distances beyond which the force grows linearly \[-\]; at 1 rows of particles coincide.
    STIFFEST_DEPTH = 0.95, "solid.contact.stiffest_depth", "depth in contact distances beyond which the contact force grows linearly [-]";
    /// Depth \[-\], in spacings of the fluid behind a particle, from which water counts as behind a thin body, not in the gap
    /// that the particle faces; and the one up to which it counts in full. Between them lies the second row of a body.
    BEHIND = -0.75, "solid.film.behind", "height in spacings below which water is not on the side of the gap [-]";
    /// See there \[-\].
    BESIDE = -0.25, "solid.film.beside", "height in spacings from which water is on the side of the gap [-]";
    /// Sum that a particle lacks along a gap, over that of a half-space, from which air is beside it \[-\]: disordered water
    /// lacks less; and the one from which it is air in full.
    OPEN_SIDE = 0.3, "solid.film.open_side", "lacking sum along a gap, over that of a half-space, from which air is beside it [-]";
    /// See there \[-\].
    AIR_SIDE = 0.7, "solid.film.air_side", "lacking sum along a gap, over that of a half-space, from which air fills that side [-]";
    /// Gap in spacings up to which pairs make up for all that its water lacks in the sums \[-\]; and from which for nothing, as
    /// particles fit in there and a gap without is a void.
    THIN_GAP = 0.6, "solid.film.thin_gap", "gap in spacings up to which water fills it without particles [-]";
    /// See there \[-\].
    OPEN_GAP = 1.0, "solid.film.open_gap", "gap in spacings from which it has no water but particles [-]";
    /// Cosine of the directions of two particles above which they belong to one face \[-\].
    SAME_FACE = 0.5, "solid.film.same_face", "cosine of directions above which particles belong to one face [-]";
    /// Undeformed distance from which parts of one body can be in contact, in support radii of the density field \[-\]: a
    /// body compressed by a third is not yet in contact with itself.
    SELF_CONTACT_DISTANCE = 1.5, "solid.contact.self_contact_distance", "undeformed distance from which parts of one body can be in contact, in support radii [-]";
    /// Smallest principal moment of inertia of a patch that bears friction, in squared contact distances \[-\]. In space a patch
    /// on one line bears no couple about it: with its particles less than a tenth of the contact distance off the line,
    /// the forces of that couple would be more than ten times the friction.
    SMALLEST_PATCH = 1e-6, in space 0.01, "solid.contact.smallest_patch", "smallest second moment of a patch that bears friction, in squared contact distances [-]";
    /// Distance from held particles within which walls are left out of the repulsion, in contact distances \[-\]: two
    /// lattice columns.
    CLAMP_CLEARANCE = 2.5, "solid.contact.clamp_clearance", "distance from held particles within which walls are left out of contact, in contact distances [-]";
}
