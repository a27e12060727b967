//! Contact by the depth of particles in other bodies: central, conservative but for its damping, never pulling.

use rayon::prelude::*;

use sph::stage::StageTime;
use sph::vector::{Vector, cross};

use super::contact_law::{Level, Spring};
use super::lists::{ContactLists, TASK};
use super::model::{Body, SolidModel};
use super::particles::Particles;
use super::walls::WallState;

/// Repulsion between particles of different bodies, of bodies and walls, and of parts of one body that meet.
///
/// Each particle s near another body o feels its depth δ in it, see [`Level`]:
///
/// ```text
/// p_s = (f + clamp(c δ', ±f)) dδ/dD,  f = κ δ d/(d − δ);   f_sj = −p_s ΔX² (dW/dr)/r x_sj
/// κ = kK/2,  c = 2ζ √(κ m)
/// ```
///
/// The forces are minus the derivative of Σ Ψ(D_s), plus damping. Each is along x_sj and has its opposite on j, so
/// momentum and angular momentum are kept; together they are normal to the smoothed face. κ is half of the given
/// fraction k of the softer body's bulk modulus, a wall being the stiffer side, since either side's particles feel
/// their depth in the other. ζ is a fraction of critical damping for the reduced mass m of two particles. The force sets
/// in without a jump and stiffens without bound up to where rows coincide, so that bodies do not pass through each
/// other. Friction is that of [`Friction`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Repulsion {
    /// Stiffness k as a fraction of the bulk modulus \[-\].
    pub stiffness: f64,
    /// Damping ζ as a fraction of critical \[-\].
    pub damping: f64,
    /// Coulomb's coefficient of friction μ \[-\].
    pub friction: f64,
    /// Level of bodies.
    pub bodies: Level,
    /// Level of walls, whose particles may have another spacing.
    pub walls: Level,
    /// Level of bodies as wall particles feel it.
    pub bodies_from_walls: Level,
    /// Undeformed distance \[m\] from which particles of one body can touch; `None` without self-contact.
    pub own_distance: Option<f64>,
}

/// One particle's contact in a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ContactSums {
    /// Force from other bodies, or from distant parts of its own \[N/m\].
    pub bodies: Vector,
    /// Force from walls \[N/m\].
    pub walls: Vector,
    /// Bound of the stiffness of all its contacts \[Pa\].
    pub stiffness: f64,
    /// Largest depth of its own in anything, or of a particle in what is around it \[m\].
    pub depth: f64,
}

/// What a particle touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Owner {
    /// The body of this index.
    Body(u32),
    /// All walls.
    Walls,
}

/// Identity of a touch: the particle, or the number of particles plus the index of a wall particle, and what it touches.
pub(super) type TouchKey = (u32, Owner);

/// A particle that lies in a body or wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub key: TouchKey,
    /// Derivative p of the energy by the level, damping included \[N\].
    slope: f64,
    depth: f64,
    /// Bound of the stiffness over the gradient on one particle \[N\].
    stiffness: f64,
    friction: Friction,
}

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
pub(super) struct Friction {
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

/// Elastic slips of all touches at one time, ascending by key.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Slips {
    /// Time that they belong to \[s\].
    pub time: f64,
    /// Slip s of each touch \[m\].
    pub entries: Vec<(TouchKey, f64)>,
}

/// The state at which contact is evaluated.
#[derive(Clone, Copy)]
pub(super) struct ContactStage<'a> {
    pub model: &'a SolidModel,
    pub time: &'a StageTime,
    /// Time of the state \[s\].
    pub at: f64,
    pub stage: &'a Particles,
    pub lists: &'a ContactLists,
    pub walls: &'a WallState,
}

/// A neighbour in the other body: x_sj, v_sj.
type Near = (Vector, Vector);

/// Stiffness κ \[Pa\] and reduced mass \[kg/m\] of a contact.
#[derive(Clone, Copy)]
struct Contact {
    stiffness: f64,
    mass: f64,
}

impl Touch {
    /// Force \[N/m\] of the particle on a particle at x_sj \[m\] of what it touches.
    #[inline]
    fn on_neighbour(&self, level: &Level, x_sj: &Vector) -> Vector {
        let r = x_sj.norm();
        let mut force = x_sj * (self.slope * level.gradient_factor(r));
        let friction = &self.friction;
        if friction.weight > 0.0 {
            let arm = -x_sj - friction.centre;
            let share = level.weight(r) / friction.weight;
            force -= (friction.force + Vector::new(-arm.y, arm.x) * friction.couple) * share;
        }
        force
    }

    /// Bound of what one neighbour at distance `r` \[m\] adds to the stiffness of its contact \[Pa\].
    fn stiffness_at(&self, level: &Level, r: f64) -> f64 {
        self.stiffness * level.gradient_factor(r).abs() * r
    }
}

impl Friction {
    /// Friction at a contact of normal force `normal` \[N/m\] along ∇D `gradient`, `dt` \[s\] after `slip` \[m\].
    fn new(
        law: &Repulsion,
        level: &Level,
        contact: &Contact,
        near: impl Iterator<Item = Near> + Clone,
        (normal, gradient): (f64, &Vector),
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
        let bound = law.friction * normal;
        let elastic = bound / contact.stiffness;
        let slip = (slip + speed * dt).clamp(-elastic, elastic);
        let dashpot = 2.0 * law.damping * (contact.stiffness * contact.mass).sqrt();
        let along = -(contact.stiffness * slip + dashpot * speed).clamp(-bound, bound);
        let force = tangent * along;
        Self { slip, force, couple: cross(&arm, &force) / inertia, centre, weight }
    }
}

impl Slips {
    fn of(&self, key: &TouchKey) -> f64 {
        self.entries.binary_search_by_key(key, |(key, _)| *key).map_or(0.0, |found| self.entries[found].1)
    }

    /// Takes over the slips of `touches`, which hold at `time` \[s\].
    fn renew(&mut self, time: f64, touches: &[Touch]) {
        self.time = time;
        self.entries.clear();
        self.entries.extend(touches.iter().map(|touch| (touch.key, touch.friction.slip)));
    }
}

impl ContactStage<'_> {
    fn near(&self, i: usize, j: usize) -> Near {
        let Particles { position, velocity, .. } = self.stage;
        (self.model.domain.separation(&position[i], &position[j]), velocity[i] - velocity[j])
    }

    fn near_wall(&self, i: usize, w: usize) -> Near {
        let x_iw = self.model.domain.separation(&self.stage.position[i], &self.walls.position[w]);
        (x_iw, self.stage.velocity[i] - self.walls.velocity[w])
    }

    /// The wall particles that can touch particle `i`.
    fn walls_of(&self, i: usize) -> impl Iterator<Item = usize> + Clone + '_ {
        let row = self.lists.walls.of(i);
        let row = if row.is_empty() || !self.model.touches_walls(i, self.time) { &[] } else { row };
        let body = self.model.body_of(i);
        row.iter().map(|w| *w as usize).filter(move |w| self.model.wall_acts_on(body, *w, self.time))
    }

    /// The particles among `row` that wall particle `w` can touch.
    fn of_wall<'a>(&'a self, w: usize, row: &'a [u32]) -> impl Iterator<Item = usize> + Clone + 'a {
        let (model, time) = (self.model, self.time);
        let acts =
            move |i: &usize| model.touches_walls(*i, time) && model.wall_acts_on(model.body_of(*i), w, time);
        row.iter().map(|i| *i as usize).filter(acts)
    }

    /// Rows of neighbours by body.
    fn by_body<'a>(&'a self, row: &'a [u32]) -> impl Iterator<Item = (u32, &'a [u32])> + 'a {
        let body = |i: &u32| self.model.particles.body[*i as usize];
        row.chunk_by(move |a, b| body(a) == body(b)).map(move |group| (body(&group[0]), group))
    }
}

impl Repulsion {
    /// Contact forces on all particles, with the touches that make them; `slips` advance to the time of the stage.
    pub fn evaluate(
        &self,
        at: &ContactStage<'_>,
        slips: &mut Slips,
        touches: &mut Vec<Touch>,
        sums: &mut [ContactSums],
    ) {
        self.find_touches(at, slips, touches);
        slips.renew(at.at, if self.friction > 0.0 { touches } else { &[] });
        if touches.is_empty() {
            sums.fill(ContactSums::default());
            return;
        }
        let touches: &[Touch] = touches;
        sums.par_iter_mut().with_min_len(8 * TASK).enumerate().for_each(|(i, sums)| {
            *sums = self.forces(at, touches, i);
        });
    }

    /// All particles that lie in something else, ascending.
    fn find_touches(&self, at: &ContactStage<'_>, slips: &Slips, touches: &mut Vec<Touch>) {
        let dt = at.at - slips.time;
        let count = at.model.len();
        let find = |s: usize| -> Vec<Touch> {
            match s.checked_sub(count) {
                None => self.touches_of(at, slips, dt, s),
                Some(w) => self.touches_of_wall(at, slips, dt, w),
            }
        };
        touches.clear();
        touches.par_extend(
            (0..count + at.model.walls.len()).into_par_iter().with_min_len(8 * TASK).flat_map_iter(find),
        );
    }

    fn touches_of(&self, at: &ContactStage<'_>, slips: &Slips, dt: f64, i: usize) -> Vec<Touch> {
        let model = at.model;
        let (body, mass) = (model.body_of(i), model.particles.mass[i]);
        let mut found = Vec::new();
        for (other, group) in at.by_body(at.lists.bodies.of(i)) {
            let near = group.iter().map(|j| at.near(i, *j as usize));
            let other_mass = model.particles.mass[group[0] as usize];
            let contact = Contact {
                mass: mass * other_mass / (mass + other_mass),
                ..self.contact(body, Some(&model.bodies[other as usize]), mass)
            };
            let key = (i as u32, Owner::Body(other));
            found.extend(self.touch(key, &self.bodies, &contact, near, (slips.of(&key), dt)));
        }
        let near = at.walls_of(i).map(|w| at.near_wall(i, w));
        let key = (i as u32, Owner::Walls);
        let contact = self.contact(body, None, mass);
        found.extend(self.touch(key, &self.walls, &contact, near, (slips.of(&key), dt)));
        found
    }

    fn touches_of_wall(&self, at: &ContactStage<'_>, slips: &Slips, dt: f64, w: usize) -> Vec<Touch> {
        let mut found = Vec::new();
        for (body, group) in at.by_body(at.lists.of_walls.of(w)) {
            let near = at.of_wall(w, group).map(|i| {
                let (x, v) = at.near_wall(i, w);
                (-x, -v)
            });
            let key = ((at.model.len() + w) as u32, Owner::Body(body));
            let contact = self.contact(
                &at.model.bodies[body as usize],
                None,
                at.model.particles.mass[group[0] as usize],
            );
            found.extend(self.touch(key, &self.bodies_from_walls, &contact, near, (slips.of(&key), dt)));
        }
        found
    }

    /// Contact of `body` with `other` or a wall.
    fn contact(&self, body: &Body, other: Option<&Body>, mass: f64) -> Contact {
        let softer = other.map_or(f64::INFINITY, |other| other.material.bulk_modulus);
        Contact { stiffness: 0.5 * self.stiffness * body.material.bulk_modulus.min(softer), mass }
    }

    /// The touch of a particle with the neighbours `near`, if it lies in them.
    fn touch(
        &self,
        key: TouchKey,
        level: &Level,
        contact: &Contact,
        near: impl Iterator<Item = Near> + Clone,
        slip: (f64, f64),
    ) -> Option<Touch> {
        let (mut value, mut gradient, mut rate, mut reach) = (0.0, Vector::zeros(), 0.0, 0.0);
        for (x, v) in near.clone() {
            let r = x.norm();
            if r < level.support {
                let part = x * level.gradient_factor(r);
                value += level.weight(r);
                gradient += part;
                rate += part.dot(&v);
                reach += part.norm();
            }
        }
        let depth = level.depth(value);
        if depth <= 0.0 {
            return None;
        }
        let (distance, gain) = (level.distance(), level.gain());
        let spring = Spring::new(contact.stiffness, depth, distance);
        let dashpot = 2.0 * self.damping * (contact.stiffness * contact.mass).sqrt();
        // Within the spring's force: no jump at the onset, no pull at the end, and the same loss however light the touch.
        let damping = (dashpot * gain * rate).clamp(-spring.force, spring.force);
        let slope = gain * (spring.force + damping);
        let normal = slope * gradient.norm();
        let rubs = self.friction > 0.0 && normal > 0.0;
        let friction = if rubs {
            Friction::new(self, level, contact, near, (normal, &gradient), slip)
        } else {
            Friction::default()
        };
        // Gershgorin's bound of the rows of p' ∇D ⊗ ∇D; what sticks is held as stiffly along the face.
        let sides = if rubs { 2.0 } else { 1.0 };
        let stiffness = sides * gain * gain * spring.slope * (gradient.norm() + reach);
        Some(Touch { key, slope, depth, stiffness, friction })
    }

    /// Contact of particle `i`: the reactions to its own touches, and the touches of others in its body.
    fn forces(&self, at: &ContactStage<'_>, touches: &[Touch], i: usize) -> ContactSums {
        let mut sums = ContactSums::default();
        let own =
            |key: TouchKey| touches.binary_search_by_key(&key, |touch| touch.key).ok().map(|k| &touches[k]);
        let body = Owner::Body(at.model.particles.body[i]);
        let mut add = |touch: &Touch, level: &Level, x_ij: &Vector, walls: bool, sign: f64| {
            let (r, x_sj) = (x_ij.norm(), x_ij * sign);
            if r < level.support {
                let force = touch.on_neighbour(level, &x_sj) * -sign;
                *(if walls { &mut sums.walls } else { &mut sums.bodies }) += force;
                sums.stiffness += touch.stiffness_at(level, r);
                sums.depth = sums.depth.max(touch.depth);
            }
        };
        for (other, group) in at.by_body(at.lists.bodies.of(i)) {
            let touch = own((i as u32, Owner::Body(other)));
            for &j in group {
                let x_ij = at.near(i, j as usize).0;
                if let Some(touch) = touch {
                    add(touch, &self.bodies, &x_ij, false, 1.0);
                }
                if let Some(touch) = own((j, body)) {
                    add(touch, &self.bodies, &x_ij, false, -1.0);
                }
            }
        }
        let touch = own((i as u32, Owner::Walls));
        for w in at.walls_of(i) {
            let x_iw = at.near_wall(i, w).0;
            if let Some(touch) = touch {
                add(touch, &self.walls, &x_iw, true, 1.0);
            }
            if let Some(touch) = own(((at.model.len() + w) as u32, body)) {
                add(touch, &self.bodies_from_walls, &x_iw, true, -1.0);
            }
        }
        sums
    }
}
