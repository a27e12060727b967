//! The state of wall particles as the fluid sees it, Eq. (27)-(28).

use sph::space::Space;
use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;

use crate::neighbours::lists::Lists;
use crate::neighbours::placement::Needs;
use crate::system::model::FluidModel;
use crate::system::packed_particle::{FluidSpace, Packed};
use crate::system::walls::WallField;

/// The walls as the fluid sees them in one stage.
#[derive(Clone, Debug, Default)]
pub struct WallStates<S: FluidSpace> {
    /// Kinematics.
    pub field: WallField<S>,
    /// State of each wall particle, zero volume where it does not act, and one more that never acts.
    pub particles: Vec<S::Particle>,
}

impl<S: FluidSpace> WallStates<S> {
    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        self.field.bytes() + size_of::<S::Particle>() * self.particles.capacity()
    }

    /// The state of each wall particle, in parts from the one that has all fluid around it; the first part gets them.
    pub fn of_all_parts(&self, model: &FluidModel<S>, lists: &Lists<S>) -> Vec<S::Particle> {
        let mut particles = self.particles.clone();
        if model.team.is_alone() {
            return particles;
        }
        let count = particles.len().min(self.field.position.len());
        let answered = (0..count).filter(|w| lists.placement().answers_for(model, &self.field.position[*w]));
        let state = |w: usize| {
            // Where no fluid is near, none has looked.
            let apart = inactive::<S>(model, &self.field.position[w]);
            let p = if lists.placement().of_wall(w).is_some() { &particles[w] } else { &apart };
            (w, (p.position(), p.velocity(), [p.density(), p.pressure(), p.volume()]))
        };
        let all = model.team.join_at_first(answered.map(state).collect::<Vec<_>>(), Vec::extend);
        for (w, (x, v, [density, pressure, volume])) in all {
            particles[w] = S::Particle::new(&x, &v, density, pressure, volume);
        }
        particles
    }

    /// Fills the state of each wall particle with such `needs` from the fluid around it at `time` \[s\].
    ///
    /// ```text
    /// p_w = Σ [p_j + ρ_j (f − a_w)·(x_w − x_j)] W_wj / Σ W_wj                                Eq. (28)
    /// v_w = v_f − 2 [(v_f − v_wall)·n] n   slip;   2 v_wall − v_f   no slip, corners         Eq. (27)
    /// ρ_w from p_w by the inverse of Eq. (3)
    /// ```
    /// v_f is the Shepard mean of the fluid's velocity, v_wall that of the wall half-way between the particle and the mean
    /// place of that fluid, a_w the known acceleration of a moving wall. A particle
    /// without fluid in its support, or of a released wall, does not act, and one above the fluid has a smaller volume or
    /// none. The density follows the pressure down to the floor of
    /// [`sph::laws::equation_of_state::Tait::wall_density`].
    pub fn extrapolate<G: Geometry<S>>(
        &mut self,
        geometry: G,
        model: &FluidModel<S>,
        lists: &Lists<S>,
        needs: Needs,
        fluid: &[S::Particle],
        time: f64,
    ) {
        let (placement, fluid_of_walls) = (lists.placement(), &lists.fluid_of_walls);
        let groups = placement.wall_groups_with(needs);
        let Self { field, particles } = self;
        // The last one does not act: it pads batches of neighbours.
        particles.resize(model.walls.len() + 1, S::Particle::default());
        particles[model.walls.len()] = inactive::<S>(model, &model.domain.lower);
        let body_force = model.body_force.at(time);
        let motions = model.walls.motions_at(time);
        let extrapolate = |w: usize, particle: &mut S::Particle| {
            if placement.of_wall(w) != Some(needs) {
                return;
            }
            let x = &field.position[w];
            *particle = inactive::<S>(model, x);
            if !model.walls.acts(model.walls.wall[w], time) {
                return;
            }
            let force = body_force.acceleration(x);
            let drive = force - field.acceleration(w);
            let (mut weight, mut pressure, mut velocity) = (0.0, 0.0, S::Vector::zeros());
            let mut offset = S::Vector::zeros();
            for j in fluid_of_walls.neighbours(w) {
                let j = &fluid[j];
                let d = geometry.separation(&particle.position(), &j.position());
                let kernel = model.kernel.value(d.norm());
                weight += kernel;
                pressure += kernel * (j.pressure() + j.density() * drive.dot(&d));
                velocity += j.velocity() * kernel;
                offset -= d * kernel;
            }
            if weight == 0.0 {
                return;
            }
            let (pressure, offset) = (pressure / weight, offset / weight);
            let along = model.walls.along(w, &field.face_normal[w], &motions, &force);
            let share = wet_share::<S>(model, &offset, pressure, &along);
            if share > 0.0 {
                let mut face = field.velocity(w);
                if let Some(Some(motion)) = motions.get(model.walls.wall[w] as usize) {
                    face += motion.velocity_difference(&(offset * 0.5));
                }
                let velocity = mirrored::<S>(&(velocity / weight), &face, &field.mirror_normal[w]);
                let density = model.equation_of_state.wall_density(pressure);
                let volume = share * model.walls.mass / density;
                *particle = S::Particle::new(x, &velocity, density, pressure, volume);
            }
        };
        let particles = &mut particles[..model.walls.len()];
        placement.wall_groups().for_each(groups, particles, &|walls, particles: &mut [S::Particle]| {
            walls.zip(particles).for_each(|(w, particle)| extrapolate(w, particle));
        });
    }
}

/// Share with which a wall particle acts \[-\] whose pressure is `pressure` \[Pa\], for the mean `offset` of the fluid near
/// it \[m\] and the part of the body force `along` the wall \[m/s²\].
///
/// ```text
/// the larger of clamp((0.6 − s/h)/0.3, 0, 1), s the offset along the force, and clamp(1 + 2p/(ρ₀ f Δx), 0, 1)
/// ```
/// A wall mirrors the fluid: beside the surface of still water it has to end where the water does. What stands above would
/// give the water at the wall other corrections L_i than the rest of the surface has. Water that strikes a wall presses on
/// what is above it too.
fn wet_share<S: FluidSpace>(
    model: &FluidModel<S>,
    offset: &S::Vector,
    pressure: f64,
    along: &S::Vector,
) -> f64 {
    let force = along.norm();
    if force == 0.0 {
        return 1.0;
    }
    let below = offset.dot(along) / (force * model.constants.smoothing_length());
    let beside = (S::DRY_OFFSET - below) / (S::DRY_OFFSET - S::WET_OFFSET);
    let of_half_a_row = 0.5 * model.constants.rest_density * force * model.constants.particle_spacing;
    beside.max(1.0 + pressure / of_half_a_row).clamp(0.0, 1.0)
}

/// A wall particle at `x` \[m\] that does not act.
fn inactive<S: FluidSpace>(model: &FluidModel<S>, x: &S::Vector) -> S::Particle {
    S::Particle::new(x, &S::Vector::zeros(), model.constants.rest_density, 0.0, 0.0)
}

/// Velocity of a wall particle toward the fluid, Eq. (27): mirrored along `normal`, or wholly where that is zero.
pub fn mirrored<S: Space>(fluid: &S::Vector, wall: &S::Vector, normal: &S::Vector) -> S::Vector {
    if normal.norm_squared() > 0.0 {
        *fluid - *normal * (2.0 * (*fluid - *wall).dot(normal))
    } else {
        *wall * 2.0 - *fluid
    }
}
