//! A body that keeps its shape: three degrees of freedom, no stress.

use std::ops::AddAssign;

use rayon::prelude::*;

use sph::coupling::ledger::scheme_moment;
use sph::coupling::stage::StageTime;
use sph::space::{SymmetricTensor, Vector, cross};
use sph::sums::ordered_sum;

use crate::boundary::supports::Support;
use crate::formulations::formulation::{
    AngularImpulse, BodyConstants, BodyDrift, BodyFormulation, BodyKick, BodyStep, RigidInertia,
};
use crate::formulations::pair_law::PairSums;
use crate::neighbours::lists::{Rows, TASK};
use crate::particles::fields::{StressView, StressViewMut};
use crate::particles::variables::{ParticleView, ParticleViewMut, RigidState, image_offset};

/// A rigid body: M dV/dt = ΣF, I dω/dt = Σ r × F, by the midpoint rule of Eq. (30)-(31).
///
/// ```text
/// M = Σ m,  I = Σ m (|r|² + V/6)
/// ```
/// V/6 is the moment of inertia of a square cell of volume V about its own centre, per mass: without it a block of
/// 4 × 4 particles turns 6 % too easily.
///
/// Particles are placed by centre and angle each time, so that the shape stays rigid to round-off however long the
/// run. Only forces from outside move it; neither stress nor density evolves.
pub struct RigidBody {
    /// Mass per depth \[kg/m\].
    mass: f64,
    /// Moment of inertia about the centre.
    inertia: RigidInertia,
    /// Particles relative to the centre at the start \[m\].
    arms: Vec<Vector>,
    /// For each support the origin of the centre, see `PrescribedMotion::origin` \[m\].
    origins: Vec<Vector>,
}

/// Share of Σ m |r|² in the moment of inertia above which it is no round-off \[-\]: not of a single particle.
const SMALLEST_INERTIA: f64 = 1e-9;

/// Resultant of the forces on a body.
#[derive(Clone, Copy, Default)]
struct Wrench {
    /// Force \[N/m\].
    force: Vector,
    /// Torque about the centre \[N\].
    torque: f64,
}

impl AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
    }
}

impl RigidBody {
    /// A body of particles at `position` \[m\], connected across periodic sides, and its motion at the start: of equal
    /// momentum, and of the angular velocity Σ m r × v / Σ m |r|², which keeps a rotation that the velocities describe.
    pub fn new(
        constants: &BodyConstants<'_>,
        position: &[Vector],
        velocity: &[Vector],
        density: &[f64],
    ) -> (Self, RigidState) {
        let m = constants.mass;
        let n = position.len();
        let mass: f64 = ordered_sum(n, |i| m[i]);
        let centre = ordered_sum::<Vector, _>(n, |i| position[i] * m[i]) / mass;
        let mean_velocity = ordered_sum::<Vector, _>(n, |i| velocity[i] * m[i]) / mass;
        let arms: Vec<Vector> = position.iter().map(|x| x - centre).collect();
        let of_places: f64 = ordered_sum(n, |i| m[i] * arms[i].norm_squared());
        let cells: f64 = ordered_sum(n, |i| m[i] * m[i] / (6.0 * density[i]));
        let angular_momentum: f64 = ordered_sum(n, |i| m[i] * cross(&arms[i], &velocity[i]));
        let origins = constants.supports.iter().map(|support| support.origin(&centre)).collect();
        let inertia = RigidInertia { total: of_places + cells, cells };
        let turns = of_places > SMALLEST_INERTIA * inertia.total;
        let angular_velocity = if turns { angular_momentum / of_places } else { 0.0 };
        let state = RigidState { centre, velocity: mean_velocity, angle: 0.0, angular_velocity };
        (Self { mass, inertia, arms, origins }, state)
    }

    /// `motion` with the supports imposed that act in the step of `time`, at `target` \[s\].
    fn held(
        &self,
        supports: &[Support],
        time: &StageTime,
        target: f64,
        base: &RigidState,
        mut motion: RigidState,
    ) -> RigidState {
        for (support, origin) in supports.iter().zip(&self.origins).filter(|(support, _)| support.acts(time))
        {
            support.target(target).impose_on_rigid(origin, base, &mut motion);
        }
        motion
    }

    /// Resultant of `force` \[N/m\] on a body turned by `angle` \[rad\].
    fn wrench(&self, angle: f64, force: &[Vector]) -> Wrench {
        let (sine, cosine) = angle.sin_cos();
        ordered_sum(self.arms.len(), |i| Wrench {
            force: force[i],
            torque: cross(&turned(&self.arms[i], sine, cosine), &force[i]),
        })
    }

    /// Velocity and angular velocity gained in `duration` \[s\].
    fn gain(&self, wrench: &Wrench, duration: f64) -> (Vector, f64) {
        (wrench.force * (duration / self.mass), wrench.torque / self.inertia.total * duration)
    }

    /// Change by supports of the angular momentum of a body whose forces act with its centre at `centre` \[m\], by
    /// changing its motion from `free` to `held` \[kg m/s\].
    fn held_moment(
        &self,
        constants: &BodyConstants<'_>,
        centre: &Vector,
        free: &RigidState,
        held: &RigidState,
    ) -> f64 {
        let arm = centre - constants.domain.torque_origin();
        self.mass * cross(&arm, &(held.velocity - free.velocity))
            + self.inertia.total * (held.angular_velocity - free.angular_velocity)
    }

    /// Writes positions and velocities that belong to `motion`.
    pub fn place(
        &self,
        constants: &BodyConstants<'_>,
        motion: &RigidState,
        image_counts: &[[i32; 2]],
        particles: ParticleViewMut<'_>,
    ) {
        let (sine, cosine) = motion.angle.sin_cos();
        let omega = motion.angular_velocity;
        particles
            .position
            .par_iter_mut()
            .zip(particles.velocity)
            .with_min_len(8 * TASK)
            .enumerate()
            .for_each(|(i, (x, v))| {
                let arm = turned(&self.arms[i], sine, cosine);
                *x = motion.centre + arm - image_offset(constants.domain, &image_counts[i]);
                *v = motion.velocity + Vector::new(-omega * arm.y, omega * arm.x);
            });
    }
}

/// `arm` turned by the angle of this sine and cosine.
#[inline]
fn turned(arm: &Vector, sine: f64, cosine: f64) -> Vector {
    Vector::new(cosine * arm.x - sine * arm.y, sine * arm.x + cosine * arm.y)
}

impl BodyFormulation for RigidBody {
    fn update_stress(
        &self,
        _constants: &BodyConstants<'_>,
        _state: &ParticleView<'_>,
        stress: StressViewMut<'_>,
    ) {
        stress.pressure.fill(0.0);
        stress.cauchy.fill(SymmetricTensor::default());
        stress.artificial.fill(SymmetricTensor::default());
    }

    fn evaluate(
        &self,
        _constants: &BodyConstants<'_>,
        _stage: &ParticleView<'_>,
        _stress: &StressView<'_>,
        _neighbours: &Rows,
        sums: &mut [PairSums],
    ) {
        sums.fill(PairSums::zero());
    }

    fn advance(
        &self,
        step: &BodyStep<'_>,
        next: ParticleViewMut<'_>,
        next_rigid: &mut RigidState,
    ) -> AngularImpulse {
        let (base, stage) = (step.base_rigid, step.stage_rigid);
        let duration = step.time.duration();
        let (gain, spin) = self.gain(&self.wrench(stage.angle, step.force), duration);
        let free = RigidState {
            centre: base.centre + stage.velocity * duration,
            velocity: base.velocity + gain,
            angle: base.angle + stage.angular_velocity * duration,
            angular_velocity: base.angular_velocity + spin,
        };
        *next_rigid = self.held(step.constants.supports, step.time, step.time.target_time(), base, free);
        next.density.copy_from_slice(step.base.density);
        next.deviatoric_stress.copy_from_slice(step.base.deviatoric_stress);
        let particles = ParticleViewMut { position: next.position, velocity: next.velocity, ..next };
        self.place(&step.constants, next_rigid, step.image_counts, particles);
        let (start, end) = ((&base.centre, &base.velocity), (&next_rigid.centre, &next_rigid.velocity));
        AngularImpulse {
            supports: self.held_moment(&step.constants, &stage.centre, &free, next_rigid),
            scheme: self.mass * scheme_moment(start, &stage.centre, end),
        }
    }

    fn kick(
        &self,
        kick: &BodyKick<'_>,
        particles: ParticleViewMut<'_>,
        motion: &mut RigidState,
    ) -> AngularImpulse {
        let (gain, spin) = self.gain(&self.wrench(motion.angle, kick.force), kick.duration);
        motion.velocity += gain;
        motion.angular_velocity += spin;
        let held = self.held(kick.constants.supports, kick.time, kick.target, kick.base_rigid, *motion);
        let supports = self.held_moment(&kick.constants, &motion.centre, motion, &held);
        motion.velocity = held.velocity;
        motion.angular_velocity = held.angular_velocity;
        self.place(&kick.constants, motion, kick.image_counts, particles);
        AngularImpulse { supports, scheme: 0.0 }
    }

    fn drift(
        &self,
        drift: &BodyDrift<'_>,
        particles: ParticleViewMut<'_>,
        motion: &mut RigidState,
    ) -> AngularImpulse {
        motion.centre += motion.velocity * drift.duration;
        motion.angle += motion.angular_velocity * drift.duration;
        let held = self.held(drift.constants.supports, drift.time, drift.target, drift.base_rigid, *motion);
        let scheme = self.mass * cross(&(held.centre - motion.centre), &motion.velocity);
        motion.centre = held.centre;
        motion.angle = held.angle;
        self.place(&drift.constants, motion, drift.image_counts, particles);
        AngularImpulse { supports: 0.0, scheme }
    }

    fn inertia(&self) -> Option<RigidInertia> {
        Some(self.inertia)
    }

    fn strain_energy(&self, _constants: &BodyConstants<'_>, _state: &ParticleView<'_>, _i: usize) -> f64 {
        0.0
    }
}
