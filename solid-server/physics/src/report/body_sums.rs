//! Sums over the particles of bodies: mass, momentum, energies, moments, best-fit rotation.

use std::ops::{AddAssign, Range};

use sph::coupling::ledger::axial;
use sph::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};
use sph::sums::ordered_sum;

use crate::formulations::body::Body;
use crate::particles::variables::{Particles, image_offset};
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;

/// Sums over a set of particles, per metre of depth.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodySums<S: SolidSpace> {
    /// \[kg/m\]
    pub mass: f64,
    /// \[kg/s\]
    pub momentum: S::Vector,
    /// About the domain's torque origin \[kg m/s\].
    pub angular_momentum: S::Spin,
    /// \[J/m\]
    pub kinetic: f64,
    /// In constant gravity \[J/m\].
    pub potential: f64,
    /// \[J/m\]
    pub strain: f64,
    /// Σ m x \[kg\].
    pub first_moment: S::Vector,
}

impl<S: SolidSpace> AddAssign for BodySums<S> {
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

impl<S: SolidSpace> BodySums<S> {
    /// Centre of mass \[m\].
    pub fn centre(&self) -> S::Vector {
        self.first_moment / self.mass
    }
}

/// Position of the material at particle `i` \[m\], periods that it crossed included.
pub fn material_position<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>, i: usize) -> S::Vector {
    state.particles.position[i] + image_offset(&model.domain, &state.image_counts[i])
}

/// Strain energy of particle `i` per undeformed volume \[J/m³\].
pub fn particle_energy_density<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>, i: usize) -> f64 {
    let body = model.body_of(i);
    let particles = state.particles.view(&body.range);
    let energy = body.formulation.strain_energy(&model.constants(body), &particles, i - body.range.start);
    energy * body.material.density / model.particles.mass[i]
}

/// Sums over the particles of `range`, one or more whole bodies; those of rigid bodies include the rotation of their cells.
pub fn body_sums<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    range: &Range<usize>,
) -> BodySums<S> {
    let origin = model.domain.torque_origin();
    let gravity = model.body_force.gravity();
    let mut sums: BodySums<S> = ordered_sum(range.len(), |k| {
        let i = range.start + k;
        let body = model.body_of(i);
        let mass = model.particles.mass[i];
        let (x, v) = (material_position(model, state, i), state.particles.velocity[i]);
        BodySums {
            mass,
            momentum: v * mass,
            angular_momentum: S::cross(&(x - origin), &v) * mass,
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
    let whole = |body: &Body<S>| range.start <= body.range.start && body.range.end <= range.end;
    for (k, body) in model.bodies.iter().enumerate().filter(|(_, body)| whole(body)) {
        if let Some(inertia) = body.formulation.inertia() {
            let spin = state.rigid[k].angular_velocity;
            let of_cells = S::angular_momentum(inertia.cells, spin);
            sums.angular_momentum += of_cells;
            sums.kinetic += 0.5 * axial(of_cells).dot(&axial(spin));
        }
    }
    sums
}

/// Second moments Σ m (x − c)⊗(x − c)/M \[m²\] of the particles of `range` about their centre `centre` \[m\].
pub fn second_moments<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    range: &Range<usize>,
    sums: &BodySums<S>,
) -> S::SymmetricTensor {
    let centre = sums.centre();
    let total: S::Tensor = ordered_sum(range.len(), |k| {
        let i = range.start + k;
        let arm = material_position(model, state, i) - centre;
        S::Tensor::outer(&arm, &arm) * model.particles.mass[i]
    });
    S::SymmetricTensor::of(&(total / sums.mass))
}

/// The rotation nearest to `near` that best fits the body's displacement from its reference.
pub fn best_fit_rotation<S: SolidSpace>(
    model: &SolidModel<S>,
    body: &Body<S>,
    particles: &Particles<S>,
    image_counts: &[S::Of<i32>],
    near: S::Rotation,
) -> S::Rotation {
    let range = &body.range;
    let mass = |k: usize| model.particles.mass[range.start + k];
    let now = |k: usize| {
        let i = range.start + k;
        particles.position[i] + image_offset(&model.domain, &image_counts[i])
    };
    let then = |k: usize| model.particles.reference_position[range.start + k];
    let total: f64 = ordered_sum(range.len(), mass);
    let centre_now = ordered_sum::<S::Vector, _>(range.len(), |k| now(k) * mass(k)) / total;
    let centre_then = ordered_sum::<S::Vector, _>(range.len(), |k| then(k) * mass(k)) / total;
    let particle = |k: usize| (mass(k), then(k) - centre_then, now(k) - centre_now);
    S::best_fit_rotation(range.len(), particle, near)
}
