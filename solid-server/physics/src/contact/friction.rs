//! Coulomb friction with stick between a particle and the patch of particles that it touches.

use sph::vector::{Vector, cross};

use crate::contact::density_field::DensityField;

/// What a particle touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// The body of this index.
    Body(u32),
    /// All walls.
    Walls,
}

/// Identity of a touch: the particle, or the number of particles plus the index of a wall particle, and what it touches.
pub type ContactKey = (u32, Owner);

/// Coulomb friction with stick, between a particle and the patch of particles that it touches.
///
/// ```text
/// u = t·(v_s − v̄ − ω̄ × (x_s − x̄)),  s' = u,  T = −clamp(κ s + c u, ±μ N) t
/// x̄, v̄: means over the patch by W_sj;  ω̄: its best-fit rotation;  N = p |∇D|,  t ⟂ ∇D
/// ```
///
/// s is held at μN/κ while the contact slides: a spring holds what sticks, so that it does not creep. The patch takes up
/// −T by the shares W_sj and the torque about x̄ as a rotation of the patch, so that force and torque cancel. This is the
/// dual of u: rigid motion of both makes no friction, and what slides never gains energy.
#[derive(Clone, Copy, Debug, Default)]
pub struct Friction {
    /// Elastic slip s \[m\].
    pub slip: f64,
    /// T on the particle \[N/m\].
    force: Vector,
    /// Torque of T about x̄ over the patch's Σ w (x − x̄)² \[N/m²\].
    couple: f64,
    /// x̄ − x_s \[m\].
    centre: Vector,
    /// Σ W_sj \[-\].
    weight: f64,
}

/// Elastic springs of all touches at one time, ascending by key.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TangentialSprings {
    /// Time that they belong to \[s\].
    pub time: f64,
    /// Slip s of each touch \[m\].
    pub entries: Vec<(ContactKey, f64)>,
}

/// A neighbour in the other body: x_sj, v_sj.
pub type RelativeState = (Vector, Vector);

/// What holds a particle that sticks.
#[derive(Clone, Copy, Debug)]
pub struct FrictionConstants {
    /// Stiffness κ \[Pa\].
    pub stiffness: f64,
    /// Dashpot c \[N s/m²\].
    pub dashpot: f64,
    /// μN \[N/m\].
    pub bound: f64,
}

impl Friction {
    /// Friction on a particle with the neighbours `near` and ∇D `gradient`, `dt` \[s\] after its slip was `slip` \[m\].
    pub fn new(
        level: &DensityField,
        grip: &FrictionConstants,
        near: impl Iterator<Item = RelativeState> + Clone,
        gradient: &Vector,
        (slip, dt): (f64, f64),
    ) -> Self {
        let weighted = || near.clone().map(|(x, v)| (level.weight(x.norm()), x, v));
        let weight: f64 = weighted().map(|(w, _, _)| w).sum();
        let centre: Vector = weighted().map(|(w, x, _)| x * (-w / weight)).sum();
        let drift: Vector = weighted().map(|(w, _, v)| v * (-w / weight)).sum();
        let inertia: f64 = weighted().map(|(w, x, _)| w / weight * (-x - centre).norm_squared()).sum();
        // A patch of one particle can bear no couple, and so no friction.
        if inertia <= 1e-6 * level.distance() * level.distance() {
            return Self::default();
        }
        let spin = weighted().map(|(w, x, v)| w / weight * cross(&(-x - centre), &(-v - drift))).sum::<f64>();
        let rotation = spin / inertia;
        let arm = -centre;
        let tangent = Vector::new(-gradient.y, gradient.x) / gradient.norm();
        let speed = tangent.dot(&(-drift - Vector::new(-arm.y, arm.x) * rotation));
        let FrictionConstants { stiffness, dashpot, bound } = *grip;
        let elastic = bound / stiffness;
        let slip = (slip + speed * dt).clamp(-elastic, elastic);
        let along = -(stiffness * slip + dashpot * speed).clamp(-bound, bound);
        let force = tangent * along;
        Self { slip, force, couple: cross(&arm, &force) / inertia, centre, weight }
    }

    /// Reaction \[N/m\] on a particle of the patch at x_sj \[m\], `r` \[m\] away.
    #[inline]
    pub fn reaction(&self, level: &DensityField, x_sj: &Vector, r: f64) -> Vector {
        if self.weight == 0.0 {
            return Vector::zeros();
        }
        let arm = -x_sj - self.centre;
        (self.force + Vector::new(-arm.y, arm.x) * self.couple) * (-level.weight(r) / self.weight)
    }
}

impl TangentialSprings {
    /// Slip of the touch `key` \[m\].
    pub fn of(&self, key: &ContactKey) -> f64 {
        self.entries.binary_search_by_key(key, |(key, _)| *key).map_or(0.0, |found| self.entries[found].1)
    }

    /// Takes over the springs of all touches, ascending by key, which hold at `time` \[s\].
    pub fn renew(&mut self, time: f64, touches: impl Iterator<Item = (ContactKey, f64)>) {
        self.time = time;
        self.entries.clear();
        self.entries.extend(touches);
    }
}
