//! Supports: particles whose motion is prescribed in some or all components.

use sph::coupling::stage::StageTime;
use sph::neighbours::CellGrid;
use sph::prescribed::motion::{MotionState, RigidMotion};
use sph::setup::BodySetup;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use crate::particles::variables::RigidState;
use crate::space::SolidSpace;

/// One support of a body.
pub struct Support<S: SolidSpace> {
    /// Components held.
    pub held: S::Of<bool>,
    /// Motion of the held components, or of the pivot; `None` holds them where they are.
    pub motion: Option<PrescribedMotion<S>>,
    /// Point of a rigid body about which it turns, at the start \[m\].
    pub pivot: Option<S::Vector>,
    /// Time from which the support no longer acts \[s\]; infinite if it always does.
    pub release_time: f64,
    /// Particles held.
    pub particles: Vec<HeldParticle<S>>,
}

/// A particle held by a support.
#[derive(Clone, Copy)]
pub struct HeldParticle<S: SolidSpace> {
    /// Index of the particle within its body.
    pub particle: usize,
    /// Point that the support's motion carries to the particle's position, see [`PrescribedMotion::origin`] \[m\].
    pub origin: S::Vector,
}

/// A prescribed rigid motion relative to the positions at the start of the run.
pub struct PrescribedMotion<S: SolidSpace> {
    motion: RigidMotion<S>,
    pivot: S::Vector,
    /// The motion at the start of the run.
    start: MotionState<S>,
}

/// Position and velocity that a support prescribes at one time.
pub struct SupportTarget<'a, S: SolidSpace> {
    support: &'a Support<S>,
    /// The motion at the start of the run and now.
    motion: Option<[MotionState<S>; 2]>,
}

sph::constants! {
    /// Absorbs the round-off of nΔt.
    const RELEASE_TOLERANCE: f64 = 1e-6, "solid.support.release_tolerance",
        "fraction of a step by which a release may come early [-]";
}

/// Whether a support or wall released at `release_time` \[s\] acts in the step of `time`.
///
/// Decided by the start of the step, so that both stages agree.
pub fn acts(release_time: f64, time: &StageTime) -> bool {
    time.step_start + RELEASE_TOLERANCE * time.time_step < release_time
}

impl<S: SolidSpace> Support<S> {
    /// Whether the support acts in the step of `time`.
    pub fn acts(&self, time: &StageTime) -> bool {
        (!self.particles.is_empty() || self.pivot.is_some()) && acts(self.release_time, time)
    }

    /// Whether it has a reaction along `axis`.
    pub fn binds(&self, axis: usize) -> bool {
        self.held[axis] || self.pivot.is_some()
    }

    /// Whether it holds all components.
    pub fn holds_fully(&self) -> bool {
        (0..S::DIMENSIONS).all(|axis| self.held[axis])
    }

    /// Reference point of a particle at `start` \[m\] for [`SupportTarget::of`].
    pub fn origin(&self, start: &S::Vector) -> S::Vector {
        self.motion.as_ref().map_or(*start, |motion| motion.origin(start))
    }

    /// Prescribed position and velocity at `time` \[s\].
    pub fn target(&self, time: f64) -> SupportTarget<'_, S> {
        SupportTarget {
            support: self,
            motion: self.motion.as_ref().map(|motion| [motion.start, motion.motion.at(time)]),
        }
    }
}

impl<S: SolidSpace> SupportTarget<'_, S> {
    /// Prescribed position \[m\] and velocity \[m/s\] of a held particle with reference point `origin`; at rest it stays
    /// at `base`.
    pub fn of(&self, origin: &S::Vector, base: &S::Vector) -> (S::Vector, S::Vector) {
        match &self.motion {
            Some([_, motion]) => (motion.position(origin), motion.velocity(origin)),
            None => (*base, S::Vector::zeros()),
        }
    }

    /// Imposes the held components on a particle with reference point `origin` that was at `base` when the step began.
    pub fn impose(
        &self,
        origin: &S::Vector,
        base: &S::Vector,
        position: &mut S::Vector,
        velocity: &mut S::Vector,
    ) {
        let (x, v) = self.of(origin, base);
        for axis in 0..S::DIMENSIONS {
            if self.support.held[axis] {
                position[axis] = x[axis];
                velocity[axis] = v[axis];
            }
        }
    }

    /// Imposes the support on a rigid body that was at `base` and whose centre has the reference point `origin`.
    ///
    /// Held components bind the centre of mass. A support that holds all components binds the rotation too; rollers
    /// leave it free.
    pub fn impose_on_rigid(&self, origin: &S::Vector, base: &RigidState<S>, next: &mut RigidState<S>) {
        self.impose(origin, &base.centre, &mut next.centre, &mut next.velocity);
        if self.support.holds_fully() {
            (next.rotation, next.angular_velocity) = match &self.motion {
                Some([start, now]) => {
                    (S::rotation_between(start, now, base.rotation), S::spin_of(now, origin))
                }
                None => (base.rotation, S::Spin::default()),
            };
        }
    }
}

impl<S: SolidSpace> PrescribedMotion<S> {
    /// `motion` about `pivot` \[m\] from `start_time` \[s\] on.
    pub fn new(motion: RigidMotion<S>, pivot: S::Vector, start_time: f64) -> Self {
        let start = motion.at(start_time);
        Self { motion, pivot, start }
    }

    /// The point \[m\] that the motion has carried to `start` by the start of the run.
    ///
    /// So held particles do not jump at the start, also where a run continues another one.
    fn origin(&self, start: &S::Vector) -> S::Vector {
        let from_pivot = *start - self.start.position(&self.pivot);
        let mut origin = self.pivot;
        for axis in 0..S::DIMENSIONS {
            let mut unit = S::Vector::zeros();
            unit[axis] = 1.0;
            origin[axis] += self.start.rotate(&unit).dot(&from_pivot);
        }
        origin
    }
}

/// Supports of `body`, whose particles at `position` \[m\] belong to the supports `members`.
///
/// Expressions that do not parse are added to `errors`.
pub fn build_supports<S: SolidSpace>(
    body: &BodySetup<S>,
    members: &[u32],
    position: &[S::Vector],
    start_time: f64,
    errors: &mut Vec<String>,
) -> Vec<Support<S>> {
    let build = |(k, setup): (u32, &sph::setup::Support<S>)| {
        let motion = setup.motion.as_ref().and_then(|motion| match RigidMotion::new(motion) {
            Ok(parsed) => Some(PrescribedMotion::new(parsed, motion.pivot, start_time)),
            Err(error) => {
                errors.push(format!("support `{}` of body `{}`: {error}", setup.name, body.name));
                None
            }
        });
        let mut support = Support {
            held: S::axes(|axis| setup.held.as_ref()[axis]),
            motion,
            pivot: setup.pivot,
            release_time: setup.release_time.unwrap_or(f64::INFINITY),
            particles: Vec::new(),
        };
        support.particles = (0..members.len())
            .filter(|i| members[*i] == k)
            .map(|particle| HeldParticle { particle, origin: support.origin(&position[particle]) })
            .collect();
        support
    };
    (1u32..).zip(&body.supports).map(build).collect()
}

/// Gives held components the velocity of their support, so that the first step starts without a jump.
pub fn impose_velocities<S: SolidSpace>(
    supports: &[Support<S>],
    start_time: f64,
    velocity: &mut [S::Vector],
) {
    for support in supports.iter().filter(|support| support.release_time > start_time) {
        let target = support.target(start_time);
        for held in &support.particles {
            let mut place = held.origin;
            target.impose(&held.origin, &held.origin, &mut place, &mut velocity[held.particle]);
        }
    }
}

/// Time until which each wall particle is left out of the contact with a body, see `SolidModel::wall_acts_on`.
pub fn wall_exemption<S: SolidSpace>(
    domain: &Domain<S>,
    supports: &[Support<S>],
    position: &[S::Vector],
    walls: &[S::Vector],
    radius: f64,
) -> Vec<f64> {
    if supports.is_empty() {
        return Vec::new();
    }
    let mut until = vec![f64::NEG_INFINITY; walls.len()];
    for support in supports.iter().filter(|support| support.holds_fully()) {
        let held: Vec<S::Vector> = support.particles.iter().map(|held| position[held.particle]).collect();
        let near = CellGrid::new(domain, &held, radius).list(domain, walls, &held, radius);
        for w in (0..walls.len()).filter(|w| !near.of(*w).is_empty()) {
            until[w] = until[w].max(support.release_time);
        }
    }
    until
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::nearest_branch;

    #[test]
    fn angles_stay_continuous_over_turns() {
        let mut angle = 0.0;
        for k in 0..100 {
            let exact = 0.3 * f64::from(k);
            angle = nearest_branch(exact.sin().atan2(exact.cos()), angle);
            assert!((angle - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn a_release_takes_effect_at_the_step_boundary_of_its_time() {
        let at = |step_start| StageTime {
            at: sph::coupling::stage::StepStage::FIRST,
            step_start,
            time_step: 1e-3,
        };
        assert!(acts(0.1, &at(0.099)));
        // 0.1 may come out of n·Δt an ulp early.
        assert!(!acts(0.1, &at(0.1 - 1e-17)));
        assert!(acts(f64::INFINITY, &at(1e9)));
    }
}
