//! Sums over the particles of bodies: mass, momentum, energies, moments, best-fit rotation.

use std::ops::{AddAssign, Range};

use sph::coupling::ledger::Energies;
use sph::space::{SymmetricTensor, Vector, cross};
use sph::sums::ordered_sum;

use crate::formulations::body::Body;
use crate::particles::variables::{Particles, image_offset};
use crate::space::nearest_branch;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;

/// Sums over a set of particles, per metre of depth.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodySums {
    /// \[kg/m\]
    pub mass: f64,
    /// \[kg/s\]
    pub momentum: Vector,
    /// About the domain's torque origin \[kg m/s\].
    pub angular_momentum: f64,
    /// \[J/m\]
    pub kinetic: f64,
    /// In constant gravity \[J/m\].
    pub potential: f64,
    /// \[J/m\]
    pub strain: f64,
    /// Σ m x \[kg\].
    pub first_moment: Vector,
}

impl AddAssign for BodySums {
    fn add_assign(&mut self, other: Self) {
        self.mass += other.mass;
        self.momentum += other.momentum;
        self.angular_momentum += other.angular_momentum;
        self.kinetic += other.kinetic;
        self.potential += other.potential;
        self.strain += other.strain;
        self.first_moment += other.first_moment;
    }
}

impl BodySums {
    /// Centre of mass \[m\].
    pub fn centre(&self) -> Vector {
        self.first_moment / self.mass
    }
}

/// Position of the material at particle `i` \[m\], periods that it crossed included.
pub fn material_position(model: &SolidModel, state: &SolidState, i: usize) -> Vector {
    state.particles.position[i] + image_offset(&model.domain, &state.image_counts[i])
}

/// Strain energy of particle `i` per undeformed volume \[J/m³\].
pub fn particle_energy_density(model: &SolidModel, state: &SolidState, i: usize) -> f64 {
    let body = model.body_of(i);
    let particles = state.particles.view(&body.range);
    let energy = body.formulation.strain_energy(&model.constants(body), &particles, i - body.range.start);
    energy * body.material.density / model.particles.mass[i]
}

/// Sums over the particles of `range`, one or more whole bodies; those of rigid bodies include the rotation of their cells.
pub fn body_sums(model: &SolidModel, state: &SolidState, range: &Range<usize>) -> BodySums {
    let origin = model.domain.torque_origin();
    let gravity = model.body_force.gravity();
    let mut sums: BodySums = ordered_sum(range.len(), |k| {
        let i = range.start + k;
        let body = model.body_of(i);
        let mass = model.particles.mass[i];
        let (x, v) = (material_position(model, state, i), state.particles.velocity[i]);
        BodySums {
            mass,
            momentum: v * mass,
            angular_momentum: mass * cross(&(x - origin), &v),
            kinetic: 0.5 * mass * v.norm_squared(),
            potential: -mass * gravity.dot(&x),
            strain: body.formulation.strain_energy(
                &model.constants(body),
                &state.particles.view(&body.range),
                i - body.range.start,
            ),
            first_moment: x * mass,
        }
    });
    let whole = |body: &Body| range.start <= body.range.start && body.range.end <= range.end;
    for (k, body) in model.bodies.iter().enumerate().filter(|(_, body)| whole(body)) {
        if let Some(inertia) = body.formulation.inertia() {
            let spin = state.rigid[k].angular_velocity;
            sums.angular_momentum += inertia.cells * spin;
            sums.kinetic += 0.5 * inertia.cells * spin * spin;
        }
    }
    sums
}

/// Energies of the particles of `range`.
pub fn energies(model: &SolidModel, state: &SolidState, range: &Range<usize>) -> Energies {
    let sums = body_sums(model, state, range);
    Energies { kinetic: sums.kinetic, potential: sums.potential, internal: sums.strain }
}

/// Second moments Σ m (x − c)⊗(x − c)/M \[m²\] of the particles of `range` about their centre `centre` \[m\].
pub fn second_moments(
    model: &SolidModel,
    state: &SolidState,
    range: &Range<usize>,
    sums: &BodySums,
) -> SymmetricTensor {
    let centre = sums.centre();
    let moment = |component: fn(&Vector) -> f64| {
        let total: f64 = ordered_sum(range.len(), |k| {
            let i = range.start + k;
            model.particles.mass[i] * component(&(material_position(model, state, i) - centre))
        });
        total / sums.mass
    };
    SymmetricTensor {
        xx: moment(|arm| arm.x * arm.x),
        yy: moment(|arm| arm.y * arm.y),
        xy: moment(|arm| arm.x * arm.y),
    }
}

/// Angle \[rad\] of the rotation that best fits the body's displacement from its reference, on the branch nearest to
/// `near`: the polar part of Σ m x'⊗X'.
pub fn best_fit_angle(
    model: &SolidModel,
    body: &Body,
    particles: &Particles,
    image_counts: &[[i32; 2]],
    near: f64,
) -> f64 {
    let range = &body.range;
    let mass = |k: usize| model.particles.mass[range.start + k];
    let now = |k: usize| {
        let i = range.start + k;
        particles.position[i] + image_offset(&model.domain, &image_counts[i])
    };
    let then = |k: usize| model.particles.reference_position[range.start + k];
    let total: f64 = ordered_sum(range.len(), mass);
    let centre_now = ordered_sum::<Vector, _>(range.len(), |k| now(k) * mass(k)) / total;
    let centre_then = ordered_sum::<Vector, _>(range.len(), |k| then(k) * mass(k)) / total;
    let arms = |k: usize| (then(k) - centre_then, now(k) - centre_now);
    let sine: f64 = ordered_sum(range.len(), |k| {
        let (before, after) = arms(k);
        mass(k) * cross(&before, &after)
    });
    let cosine: f64 = ordered_sum(range.len(), |k| {
        let (before, after) = arms(k);
        mass(k) * before.dot(&after)
    });
    nearest_branch(sine.atan2(cosine), near)
}
