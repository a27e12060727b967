//! Coulomb friction with stick between a particle and the patch of particles that it is in contact with.

use sph::space::Space;
use sph::space::tensors::SpaceVector;

use crate::contact::density_field::DensityField;
use crate::space::SolidSpace;

/// The side opposite to a particle in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// The body of this index.
    Body(u32),
    /// All walls.
    Walls,
}

/// Identity of a contact: the particle, or the number of particles plus the index of a wall particle, and its partner.
pub type ContactKey = (u32, Owner);

/// Depths in contact of bodies as they are laid out, ascending by key \[m\].
pub type StartDepths = Vec<(ContactKey, f64)>;

/// Coulomb friction with stick, between a particle and the patch of particles that it is in contact with.
///
/// ```text
/// u = t·(v_s − v̄ − ω̄ × (x_s − x̄)),  s' = u,  T = −clamp(κ s + c u, ±μ N) t
/// x̄, v̄: means over the patch by W_sj;  ω̄: its best-fit rotation;  N = p |∇D|,  t ⟂ ∇D
/// ```
///
/// s is the elongation of a tangential spring, which prevents creep while the contact sticks; while it slides, s stays at
/// μN/κ. The patch takes up −T by the shares W_sj and the torque about x̄ as a rotation of the patch, so that force and
/// torque cancel. This is the dual of u: a rigid motion of both causes no friction, and sliding never adds energy.
///
/// In space u and s are vectors along the face, T = −(κ s + c u) with a length of at most μ N, and s turns with the face.
#[derive(Clone, Copy, Debug, Default)]
pub struct Friction<S: SolidSpace> {
    /// Elongation s of the tangential spring \[m\].
    pub elongation: S::Slide,
    /// T on the particle \[N/m\].
    force: S::Vector,
    /// Torque of T about x̄ over the patch's Σ w (x − x̄)² \[N/m²\].
    couple: S::Spin,
    /// x̄ − x_s \[m\].
    centre: S::Vector,
    /// Σ W_sj \[-\].
    weight: f64,
}

/// Elongations of the tangential springs of all contacts at one time, ascending by key.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TangentialSprings<S: SolidSpace> {
    /// Time that they belong to \[s\].
    pub time: f64,
    /// Elongation s for each contact \[m\].
    pub entries: Vec<(ContactKey, S::Slide)>,
}

/// A neighbour in the other body: x_sj \[m\], v_sj \[m/s\].
pub type RelativeState<S> = (<S as Space>::Vector, <S as Space>::Vector);

/// Constants of the friction of one contact.
#[derive(Clone, Copy, Debug)]
pub struct FrictionConstants {
    /// Stiffness κ \[Pa\].
    pub stiffness: f64,
    /// Dashpot c \[N s/m²\].
    pub dashpot: f64,
    /// μN \[N/m\].
    pub bound: f64,
}

impl<S: SolidSpace> Friction<S> {
    /// Friction on a particle with the neighbours `near` and ∇D `gradient`, `dt` \[s\] after its spring had the elongation
    /// `elongation` \[m\].
    pub fn new(
        field: &DensityField,
        law: &FrictionConstants,
        near: impl Iterator<Item = RelativeState<S>> + Clone,
        gradient: &S::Vector,
        elongation: S::Slide,
        dt: f64,
    ) -> Self {
        let weighted = || near.clone().map(|(x, v)| (field.weight(x.norm()), x, v));
        let weight: f64 = weighted().map(|(w, _, _)| w).sum();
        let centre: S::Vector = weighted().map(|(w, x, _)| x * (-w / weight)).sum();
        let drift: S::Vector = weighted().map(|(w, _, v)| v * (-w / weight)).sum();
        let inertia: S::Inertia =
            weighted().map(|(w, x, _)| S::point_inertia(w / weight, &(-x - centre))).sum();
        // A patch of one particle, in space of particles on one line, can bear no couple, and so no friction.
        if S::smallest_inertia(inertia) <= S::SMALLEST_PATCH * field.distance * field.distance {
            return Self::default();
        }
        let spin = weighted()
            .map(|(w, x, v)| S::cross(&(-x - centre), &(-v - drift)) * (w / weight))
            .sum::<S::Spin>();
        let rotation = S::angular_velocity(inertia, spin);
        let arm = -centre;
        let face = S::face(gradient);
        let speed = S::along(&face, &(-drift - S::spin_cross(rotation, &arm)));
        let FrictionConstants { stiffness, dashpot, bound } = *law;
        let elastic = bound / stiffness;
        let elongation = S::capped_slide(S::turned_slide(&face, elongation) + speed * dt, elastic);
        let along = -S::capped_slide(elongation * stiffness + speed * dashpot, bound);
        let force = S::slide_vector(&face, along);
        let couple = S::angular_velocity(inertia, S::cross(&arm, &force));
        Self { elongation, force, couple, centre, weight }
    }

    /// Reaction \[N/m\] on a particle of the patch at x_sj \[m\], `r` \[m\] away.
    #[inline]
    pub fn reaction(&self, field: &DensityField, x_sj: &S::Vector, r: f64) -> S::Vector {
        if self.weight == 0.0 {
            return S::Vector::zeros();
        }
        let arm = -*x_sj - self.centre;
        (self.force + S::spin_cross(self.couple, &arm)) * (-field.weight(r) / self.weight)
    }
}

impl<S: SolidSpace> TangentialSprings<S> {
    /// Elongation for the contact `key` \[m\]; zero where it is new.
    pub fn of(&self, key: &ContactKey) -> S::Slide {
        let found = self.entries.binary_search_by_key(key, |(key, _)| *key);
        found.map_or_else(|_| S::Slide::default(), |found| self.entries[found].1)
    }

    /// Takes over `other`, keeping the allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        self.entries.clone_from(&other.entries);
    }

    /// Replaces all by the elongations of `contacts`, ascending by key, at `time` \[s\].
    pub fn renew(&mut self, time: f64, contacts: impl Iterator<Item = (ContactKey, S::Slide)>) {
        self.time = time;
        self.entries.clear();
        self.entries.extend(contacts);
    }
}
