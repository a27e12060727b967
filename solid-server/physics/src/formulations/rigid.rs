//! A body that keeps its shape: three degrees of freedom in the plane, six in space, no stress.

use std::ops::AddAssign;

use sph::coupling::ledger::{axial, scheme_moment};
use sph::coupling::stage::StageTime;
use sph::space::tensors::SpaceVector;
use sph::sums::ordered_sum;
use sph::tasks::for_each;

use crate::boundary::supports::Support;
use crate::formulations::formulation::{
    AngularImpulse, BodyConstants, BodyDrift, BodyFormulation, BodyKick, BodyStep, RigidInertia,
};
use crate::formulations::pair_law::PairSums;
use crate::neighbours::lists::{Rows, TASK};
use crate::particles::fields::{StressView, StressViewMut};
use crate::particles::forces::ParticleForces;
use crate::particles::variables::{ParticleView, ParticleViewMut, RigidState, image_offset};
use crate::space::SolidSpace;

/// A rigid body: M dV/dt = ΣF, d(Iω)/dt = Σ r × F, by the midpoint rule of Eq. (30)-(31).
///
/// ```text
/// M = Σ m,  I = Σ (I_r + I_c)
/// ```
/// I_r is [`SolidSpace::point_inertia`], I_c the [`SolidSpace::cell_inertia`] of the particle's own cell.
///
/// In space I turns with the body; the angular momentum Iω is what torques change, so that it is kept without.
///
/// A body with a pivot at p, at rest or moved, turns about it instead, with a = c − p from there to the centre:
///
/// ```text
/// d(I_p ω)/dt = Σ (x − p) × F − M a × dv_p/dt,  I_p = I + I_r(M, a),  V = v_p + ω × a
/// ```
///
/// Particles are placed by centre and rotation each time, so that the shape stays rigid to round-off however long the
/// run. Only forces from outside move it; neither stress nor density evolves.
pub struct RigidBody<S: SolidSpace> {
    /// Mass per depth \[kg/m\].
    mass: f64,
    /// Moment of inertia about the centre, without rotation.
    inertia: RigidInertia<S>,
    /// Particles relative to the centre at the start \[m\].
    arms: Vec<S::Vector>,
    /// For each support the origin of the centre, or of the pivot, see `PrescribedMotion::origin` \[m\].
    origins: Vec<S::Vector>,
    /// What turns about a pivot, where a support is one.
    hinge: Option<Hinge<S>>,
}

/// A body about its pivot.
#[derive(Clone, Copy)]
struct Hinge<S: SolidSpace> {
    /// Index of the support.
    support: usize,
    /// From the pivot to the centre, without rotation \[m\].
    arm: S::Vector,
    /// Moment of inertia about the pivot, without rotation.
    inertia: S::Inertia,
}

/// Resultant of the forces on a body.
#[derive(Clone, Copy, Default)]
struct Wrench<S: SolidSpace> {
    /// Force \[N/m\].
    force: S::Vector,
    /// Torque about the centre \[N\].
    torque: S::Spin,
}

impl<S: SolidSpace> AddAssign for Wrench<S> {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
    }
}

impl<S: SolidSpace> RigidBody<S> {
    /// A body of particles at `position` \[m\], connected across periodic sides, and its motion at the start: of equal
    /// momentum, and of the angular velocity Σ m r × v / Σ m |r|², in space (Σ I_r)⁻¹ Σ m r × v, which keeps a rotation that
    /// the velocities describe. A pivot that acts at `start_time` \[s\] has its own velocity then.
    pub fn new(
        constants: &BodyConstants<'_, S>,
        start_time: f64,
        position: &[S::Vector],
        velocity: &[S::Vector],
        density: &[f64],
    ) -> (Self, RigidState<S>) {
        let m = constants.mass;
        let n = position.len();
        let mass: f64 = ordered_sum(n, |i| m[i]);
        let centre = ordered_sum::<S::Vector, _>(n, |i| position[i] * m[i]) / mass;
        let mean_velocity = ordered_sum::<S::Vector, _>(n, |i| velocity[i] * m[i]) / mass;
        let arms: Vec<S::Vector> = position.iter().map(|x| *x - centre).collect();
        let of_places: S::Inertia = ordered_sum(n, |i| S::point_inertia(m[i], &arms[i]));
        let cells: S::Inertia = ordered_sum(n, |i| <S as SolidSpace>::cell_inertia(m[i], density[i]));
        let angular_momentum: S::Spin = ordered_sum(n, |i| S::cross(&arms[i], &velocity[i]) * m[i]);
        let bound = |support: &Support<S>| support.origin(&support.pivot.unwrap_or(centre));
        let origins: Vec<S::Vector> = constants.supports.iter().map(bound).collect();
        let inertia = RigidInertia { total: of_places + cells, cells };
        let angular_velocity = S::described_spin(of_places, inertia.total, angular_momentum);
        let hinge = constants.supports.iter().enumerate().find_map(|(support, of)| {
            let arm = centre - of.pivot?;
            Some(Hinge { support, arm, inertia: inertia.total + S::point_inertia(mass, &arm) })
        });
        let mut state = RigidState {
            centre,
            velocity: mean_velocity,
            rotation: S::Rotation::default(),
            angular_velocity,
        };
        let starts = |hinge: &Hinge<S>| constants.supports[hinge.support].release_time > start_time;
        if let Some(hinge) = hinge.filter(starts) {
            let target = constants.supports[hinge.support].target(start_time);
            let (_, v) = target.of(&origins[hinge.support], &S::Vector::zeros());
            state.velocity = v + S::spin_cross(angular_velocity, &hinge.arm);
        }
        (Self { mass, inertia, arms, origins, hinge }, state)
    }

    /// `motion` with the supports imposed that act in the step of `time`, at `target` \[s\].
    fn held(
        &self,
        supports: &[Support<S>],
        time: &StageTime,
        target: f64,
        base: &RigidState<S>,
        mut motion: RigidState<S>,
    ) -> RigidState<S> {
        let acts = |support: &Support<S>| support.pivot.is_none() && support.acts(time);
        for (support, origin) in supports.iter().zip(&self.origins).filter(|(support, _)| acts(support)) {
            support.target(target).impose_on_rigid(origin, base, &mut motion);
        }
        motion
    }

    /// Resultant of `force` \[N/m\] on a body with the rotation `rotation`.
    fn wrench(&self, rotation: S::Rotation, force: &[S::Vector]) -> Wrench<S> {
        let rotation = S::rotation_matrix(rotation);
        ordered_sum(self.arms.len(), |i| Wrench {
            force: force[i],
            torque: S::cross(&(rotation * self.arms[i]), &force[i]),
        })
    }

    /// Velocity gained in `duration` \[s\].
    fn gain(&self, wrench: &Wrench<S>, duration: f64) -> S::Vector {
        wrench.force * (duration / self.mass)
    }

    /// The hinge, if it acts in the step of `time`.
    fn acting_hinge(&self, supports: &[Support<S>], time: &StageTime) -> Option<&Hinge<S>> {
        self.hinge.as_ref().filter(|hinge| supports[hinge.support].acts(time))
    }

    /// Place and velocity of the pivot of a body that was at `base` when the step began, at `time` \[s\].
    fn pivot(
        &self,
        hinge: &Hinge<S>,
        supports: &[Support<S>],
        base: &RigidState<S>,
        time: f64,
    ) -> (S::Vector, S::Vector) {
        let at_base = base.centre - S::rotation_matrix(base.rotation) * hinge.arm;
        supports[hinge.support].target(time).of(&self.origins[hinge.support], &at_base)
    }

    /// The motion about a pivot at `place` with `velocity`.
    fn about(
        &self,
        hinge: &Hinge<S>,
        (place, velocity): (S::Vector, S::Vector),
        (rotation, angular_velocity): (S::Rotation, S::Spin),
    ) -> RigidState<S> {
        let arm = S::rotation_matrix(rotation) * hinge.arm;
        let velocity = velocity + S::spin_cross(angular_velocity, &arm);
        RigidState { centre: place + arm, velocity, rotation, angular_velocity }
    }

    /// Angular velocity of a body about its pivot after the forces of `wrench`, which act at the rotation `acting`, for
    /// `duration` \[s\], while it turns between `rotations` and the pivot gains the velocity `gained` \[m/s\].
    fn spin_about(
        &self,
        hinge: &Hinge<S>,
        (wrench, acting): (&Wrench<S>, S::Rotation),
        rotations: [S::Rotation; 2],
        spin: S::Spin,
        (duration, gained): (f64, S::Vector),
    ) -> S::Spin {
        let arm = S::rotation_matrix(acting) * hinge.arm;
        let impulse = wrench.force * duration - gained * self.mass;
        let angular_impulse = wrench.torque * duration + S::cross(&arm, &impulse);
        S::spin_after(hinge.inertia, rotations, spin, angular_impulse, 1.0)
    }

    /// Velocity of the pivot of a body that moves as `motion`.
    fn pivot_velocity(&self, hinge: &Hinge<S>, motion: &RigidState<S>) -> S::Vector {
        let arm = S::rotation_matrix(motion.rotation) * hinge.arm;
        motion.velocity - S::spin_cross(motion.angular_velocity, &arm)
    }

    /// Change of the angular momentum about the centre from `from` to `to`.
    fn angular_gain(&self, from: &RigidState<S>, to: &RigidState<S>) -> S::Spin {
        let of = |motion: &RigidState<S>| (motion.rotation, motion.angular_velocity);
        S::angular_gain(self.inertia.total, of(from), of(to))
    }

    /// Change by supports of the angular momentum of a body whose forces act with its centre at `centre` \[m\], by
    /// changing its motion from `free` to `held` \[kg m/s\].
    fn held_moment(
        &self,
        constants: &BodyConstants<'_, S>,
        centre: &S::Vector,
        free: &RigidState<S>,
        held: &RigidState<S>,
    ) -> S::Spin {
        let arm = *centre - constants.domain.torque_origin();
        S::cross(&arm, &(held.velocity - free.velocity)) * self.mass + self.angular_gain(free, held)
    }

    /// Work of supports that change the motion of the body from `free` to `held`, where its forces alone took it from
    /// `start` to `free` \[J/m\].
    fn held_work(&self, start: &RigidState<S>, free: &RigidState<S>, held: &RigidState<S>) -> f64 {
        let mean = (start.velocity + held.velocity) * 0.5;
        let mean_spin = (start.angular_velocity + held.angular_velocity) * 0.5;
        let turned = self.angular_gain(free, held);
        (held.velocity - free.velocity).dot(&mean) * self.mass + axial(turned).dot(&axial(mean_spin))
    }

    /// Writes positions and velocities that belong to `motion`.
    pub fn place(
        &self,
        constants: &BodyConstants<'_, S>,
        motion: &RigidState<S>,
        image_counts: &[S::Of<i32>],
        particles: ParticleViewMut<'_, S>,
    ) {
        let rotation = S::rotation_matrix(motion.rotation);
        let omega = motion.angular_velocity;
        for_each((particles.position, particles.velocity), 8 * TASK, |i, (x, v)| {
            let arm = rotation * self.arms[i];
            *x = motion.centre + arm - image_offset(constants.domain, &image_counts[i]);
            *v = motion.velocity + S::spin_cross(omega, &arm);
        });
    }
}

impl<S: SolidSpace> BodyFormulation<S> for RigidBody<S> {
    fn update_stress(
        &self,
        _constants: &BodyConstants<'_, S>,
        _state: &ParticleView<'_, S>,
        stress: StressViewMut<'_, S>,
    ) {
        stress.pressure.fill(0.0);
        stress.cauchy.fill(S::SymmetricTensor::default());
        stress.artificial.fill(S::SymmetricTensor::default());
    }

    fn evaluate(
        &self,
        _constants: &BodyConstants<'_, S>,
        _stage: &ParticleView<'_, S>,
        _stress: &StressView<'_, S>,
        _neighbours: &Rows,
        sums: &mut [PairSums<S>],
    ) {
        sums.fill(PairSums::zero());
    }

    fn advance(
        &self,
        step: &BodyStep<'_, S>,
        next: ParticleViewMut<'_, S>,
        next_rigid: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        let (base, stage) = (step.base_rigid, step.stage_rigid);
        let duration = step.time.duration();
        let wrench = self.wrench(stage.rotation, step.force);
        let rotation = S::rotated(base.rotation, stage.angular_velocity, duration);
        let free = RigidState {
            centre: base.centre + stage.velocity * duration,
            velocity: base.velocity + self.gain(&wrench, duration),
            rotation,
            angular_velocity: S::spin_after(
                self.inertia.total,
                [base.rotation, rotation],
                base.angular_velocity,
                wrench.torque,
                duration,
            ),
        };
        let (supports, target) = (step.constants.supports, step.time.target_time());
        *next_rigid = match self.acting_hinge(supports, step.time) {
            Some(hinge) => {
                let pivot = self.pivot(hinge, supports, base, target);
                let gained = pivot.1 - self.pivot_velocity(hinge, base);
                let spin = self.spin_about(
                    hinge,
                    (&wrench, stage.rotation),
                    [base.rotation, rotation],
                    base.angular_velocity,
                    (duration, gained),
                );
                self.about(hinge, pivot, (rotation, spin))
            }
            None => self.held(supports, step.time, target, base, free),
        };
        next.density.copy_from_slice(step.base.density);
        next.deviatoric_stress.copy_from_slice(step.base.deviatoric_stress);
        let particles = ParticleViewMut { position: next.position, velocity: next.velocity, ..next };
        self.place(&step.constants, next_rigid, step.image_counts, particles);
        let (start, end) = ((&base.centre, &base.velocity), (&next_rigid.centre, &next_rigid.velocity));
        AngularImpulse {
            supports: self.held_moment(&step.constants, &stage.centre, &free, next_rigid),
            scheme: scheme_moment::<S>(start, &stage.centre, end) * self.mass,
            work: self.held_work(base, &free, next_rigid),
        }
    }

    fn kick(
        &self,
        kick: &BodyKick<'_, S>,
        particles: ParticleViewMut<'_, S>,
        motion: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        let start = *motion;
        let wrench = self.wrench(motion.rotation, kick.force);
        motion.velocity += self.gain(&wrench, kick.duration);
        motion.angular_velocity = S::spin_after(
            self.inertia.total,
            [motion.rotation; 2],
            motion.angular_velocity,
            wrench.torque,
            kick.duration,
        );
        let supports = kick.constants.supports;
        let held = match self.acting_hinge(supports, kick.time) {
            Some(hinge) => {
                let pivot = self.pivot(hinge, supports, kick.base_rigid, kick.target);
                let gained = pivot.1 - self.pivot_velocity(hinge, &start);
                let spin = self.spin_about(
                    hinge,
                    (&wrench, start.rotation),
                    [start.rotation; 2],
                    start.angular_velocity,
                    (kick.duration, gained),
                );
                self.about(hinge, pivot, (start.rotation, spin))
            }
            None => self.held(supports, kick.time, kick.target, kick.base_rigid, *motion),
        };
        // A kick turns nothing.
        let held = RigidState { rotation: motion.rotation, ..held };
        let by_supports = self.held_moment(&kick.constants, &motion.centre, motion, &held);
        let work = self.held_work(&start, motion, &held);
        motion.velocity = held.velocity;
        motion.angular_velocity = held.angular_velocity;
        self.place(&kick.constants, motion, kick.image_counts, particles);
        AngularImpulse { supports: by_supports, scheme: S::Spin::default(), work }
    }

    fn drift(
        &self,
        drift: &BodyDrift<'_, S>,
        particles: ParticleViewMut<'_, S>,
        motion: &mut RigidState<S>,
    ) -> AngularImpulse<S> {
        let supports = drift.constants.supports;
        if let Some(hinge) = self.acting_hinge(supports, drift.time) {
            let start = *motion;
            let turned = S::coasted(hinge.inertia, start.rotation, start.angular_velocity, drift.duration);
            let (place, _) = self.pivot(hinge, supports, drift.base_rigid, drift.target);
            *motion = self.about(hinge, (place, self.pivot_velocity(hinge, &start)), turned);
            self.place(&drift.constants, motion, drift.image_counts, particles);
            let origin = drift.constants.domain.torque_origin();
            let moment = |motion: &RigidState<S>| S::cross(&(motion.centre - origin), &motion.velocity);
            return AngularImpulse {
                supports: (moment(motion) - moment(&start)) * self.mass + self.angular_gain(&start, motion),
                scheme: S::Spin::default(),
                work: self.held_work(&start, &start, motion),
            };
        }
        motion.centre += motion.velocity * drift.duration;
        (motion.rotation, motion.angular_velocity) =
            S::coasted(self.inertia.total, motion.rotation, motion.angular_velocity, drift.duration);
        let held = self.held(supports, drift.time, drift.target, drift.base_rigid, *motion);
        let held = RigidState { angular_velocity: motion.angular_velocity, ..held };
        let scheme = S::cross(&(held.centre - motion.centre), &motion.velocity) * self.mass
            + self.angular_gain(motion, &held);
        motion.centre = held.centre;
        motion.rotation = held.rotation;
        self.place(&drift.constants, motion, drift.image_counts, particles);
        AngularImpulse { supports: S::Spin::default(), scheme, work: 0.0 }
    }

    fn inertia(&self) -> Option<RigidInertia<S>> {
        Some(self.inertia)
    }

    /// 2 Σ k (1/M + |r|²/I) with the smallest principal moment of inertia I: the trace of stiffness over mass, doubled for a
    /// partner that moves as well. A pivot only stiffens the body.
    fn contact_rate(&self, forces: &[ParticleForces<S>]) -> Option<f64> {
        let smallest = S::smallest_inertia(self.inertia.total);
        let of_particle = |i: usize| {
            let softness = 1.0 / self.mass + self.arms[i].norm_squared() / smallest;
            forces[i].contact_stiffness * softness
        };
        Some(2.0 * ordered_sum::<f64, _>(self.arms.len(), of_particle))
    }

    fn strain_energy(
        &self,
        _constants: &BodyConstants<'_, S>,
        _state: &ParticleView<'_, S>,
        _i: usize,
    ) -> f64 {
        0.0
    }
}
