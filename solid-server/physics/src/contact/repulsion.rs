//! Repulsion by penetration depth: central forces, conservative apart from damping, never attractive.

use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::tasks::{PerTask, for_each, for_each_task};

use crate::boundary::walls::WallState;
use crate::contact::density_field::{DensityField, DensityFields, Spring};
use crate::contact::friction::{
    ContactKey, Friction, FrictionConstants, Owner, RelativeState, StartDepths, TangentialSprings,
};
use crate::formulations::body::Body;
use crate::neighbours::lists::{PairLists, TASK};
use crate::particles::constants::ParticleConstants;
use crate::particles::forces::ContactForces;
use crate::particles::variables::Particles;
use crate::space::SolidSpace;

/// Repulsion between particles of different bodies, of bodies and walls, and of distant parts of one body.
///
/// Each particle s with a penetration depth δ in another body o, see [`DensityField`], exerts forces on its particles j:
///
/// ```text
/// p_s = (f + clamp(c δ', ±f)) dδ/dD,  f = κ δ d/(d − δ);   f_sj = −p_s ΔX² (dW/dr)/r x_sj
/// κ = kK/2,  c = 2ζ √(κ m);  in space κ = kK Δx/2
/// ```
///
/// The forces are minus the derivative of Σ Ψ(D_s), plus damping. Each is along x_sj and has its opposite on j, so
/// momentum and angular momentum are kept; together they are normal to the smoothed face. κ is half of the given
/// fraction k of the softer body's bulk modulus, a wall being the stiffer side, since the particles of both sides
/// penetrate the other. ζ is a fraction of critical damping for the reduced mass m of the particle and the heaviest of the
/// other body. The force sets in without a jump and stiffens without bound up to where rows coincide, so that bodies do not
/// pass through each other. Friction is that of [`Friction`].
///
/// A particle that lies in another body or wall as they are laid out, by δ₀, has depth δ − δ₀ and contact distance d − δ₀.
#[derive(Clone, Debug)]
pub struct Repulsion {
    /// Stiffness k as a fraction of the bulk modulus \[-\].
    pub stiffness: f64,
    /// Damping ζ as a fraction of critical \[-\].
    pub damping: f64,
    /// Coulomb's coefficient of friction μ \[-\].
    pub friction: f64,
    pub fields: DensityFields,
    /// Spacing of the bodies' particles \[m\].
    pub spacing: f64,
    /// Whether water presses in gaps; see [`Film`](crate::contact::film::Film).
    pub wet: bool,
    /// Undeformed distance \[m\] from which parts of one body can be in contact; `None` without self-contact.
    pub self_contact_distance: Option<f64>,
    /// Depths of the bodies as they are laid out, from which forces are measured.
    pub start: StartDepths,
}

/// A particle that lies in a body or wall, or may within the step.
#[derive(Clone, Copy, Debug)]
struct Contact<S: SolidSpace> {
    key: ContactKey,
    /// Derivative p of the energy by the density, damping included \[N\].
    slope: f64,
    depth: f64,
    /// Bound of the stiffness over the gradient on one particle \[N\].
    stiffness: f64,
    friction: Friction<S>,
}

/// All contacts of an evaluation, and buffers in which tasks find them.
#[derive(Debug, Default)]
pub struct Contacts<S: SolidSpace> {
    /// Ascending by key.
    found: Vec<Contact<S>>,
    tasks: Vec<Vec<Contact<S>>>,
}

/// The state at which contact is evaluated.
#[derive(Clone, Copy)]
pub struct ContactStage<'a, S: SolidSpace> {
    pub domain: &'a Domain<S>,
    pub constants: &'a ParticleConstants<S>,
    pub bodies: &'a [Body<S>],
    /// Time of the state \[s\].
    pub at: f64,
    pub stage: &'a Particles<S>,
    pub lists: &'a PairLists,
    pub walls: &'a WallState<S>,
}

/// Stiffness κ \[Pa\], in space \[N/m\], and reduced mass \[kg/m\] of a contact.
#[derive(Clone, Copy)]
struct ContactConstants {
    stiffness: f64,
    mass: f64,
    /// Whether one of both is rigid, whose step has no limit but that by contact.
    rigid: bool,
}

impl<S: SolidSpace> Contact<S> {
    /// Force \[N/m\] of the particle on a particle at x_sj \[m\] of its partner, and the part of it by friction.
    #[inline]
    fn on_neighbour(&self, field: &DensityField, x_sj: &S::Vector) -> [S::Vector; 2] {
        let r = x_sj.norm();
        let friction = self.friction.reaction(field, x_sj, r);
        [*x_sj * (self.slope * field.gradient_factor(r)) + friction, friction]
    }

    /// One with stiffness κ `stiffness` \[Pa\] that may set in during the step: it has no force yet, but the stiffness that it will
    /// have, for the step to resolve. `None` where no face is opposite.
    fn imminent(key: ContactKey, stiffness: f64, gradient: f64, reach: f64) -> Option<Self> {
        // As that of a contact, with a gain of 1/|∇D|, which depth has where it sets in.
        let stiffness = stiffness * (gradient + reach) / (gradient * gradient);
        (gradient > 0.0).then(|| Self {
            key,
            slope: 0.0,
            depth: 0.0,
            stiffness,
            friction: Friction::default(),
        })
    }

    /// Bound of the contribution of one neighbour at distance `r` \[m\] to the stiffness of its contact \[Pa\].
    fn stiffness_at(&self, field: &DensityField, r: f64) -> f64 {
        self.stiffness * field.gradient_factor(r).abs() * r
    }
}

impl<S: SolidSpace> ContactStage<'_, S> {
    fn near(&self, i: usize, j: usize) -> RelativeState<S> {
        let Particles { position, velocity, .. } = self.stage;
        (self.domain.separation(&position[i], &position[j]), velocity[i] - velocity[j])
    }

    fn near_wall(&self, i: usize, w: usize) -> RelativeState<S> {
        let x_iw = self.domain.separation(&self.stage.position[i], &self.walls.position[w]);
        (x_iw, self.stage.velocity[i] - self.walls.velocity[w])
    }

    /// The wall particles that can be in contact with particle `i`.
    fn walls_of(&self, i: usize) -> impl Iterator<Item = usize> + Clone + '_ {
        self.lists.walls.of(i).iter().map(|w| *w as usize)
    }

    /// Rows of neighbours by body.
    fn by_body<'a>(&'a self, row: &'a [u32]) -> impl Iterator<Item = (u32, &'a [u32])> + 'a {
        let body = |i: &u32| self.constants.body[*i as usize];
        row.chunk_by(move |a, b| body(a) == body(b)).map(move |group| (body(&group[0]), group))
    }
}

impl Repulsion {
    /// Contact forces on all particles, and the contacts that cause them; `springs` advance to the time of the stage.
    pub fn evaluate<S: SolidSpace>(
        &self,
        at: &ContactStage<'_, S>,
        springs: &mut TangentialSprings<S>,
        contacts: &mut Contacts<S>,
        sums: &mut [ContactForces<S>],
    ) {
        self.find_contacts(at, springs, contacts);
        let contacts: &[Contact<S>] = &contacts.found;
        let sticking = if self.friction > 0.0 { contacts } else { &[] };
        let touching = sticking.iter().filter(|contact| contact.depth > 0.0);
        springs.renew(at.at, touching.map(|contact| (contact.key, contact.friction.elongation)));
        if contacts.is_empty() {
            sums.fill(ContactForces::default());
            return;
        }
        for_each(sums, 8 * TASK, |i, sums| *sums = self.forces(at, contacts, i));
    }

    /// All particles that lie in something else, or may within the step, ascending.
    fn find_contacts<S: SolidSpace>(
        &self,
        at: &ContactStage<'_, S>,
        springs: &TangentialSprings<S>,
        contacts: &mut Contacts<S>,
    ) {
        let dt = at.at - springs.time;
        let count = at.constants.len();
        let active = &at.lists.active;
        let tasks = active.len().div_ceil(2 * TASK);
        if contacts.tasks.len() < tasks {
            contacts.tasks.resize_with(tasks, Vec::new);
        }
        let Contacts { found, tasks: buffers } = contacts;
        buffers.iter_mut().for_each(Vec::clear);
        for_each_task(active.len(), 2 * TASK, PerTask(&mut buffers[..tasks]), &|range, PerTask(found)| {
            let found = &mut found[0];
            for s in active[range].iter().map(|s| *s as usize) {
                match s.checked_sub(count) {
                    None => self.contacts_of(at, springs, dt, s, found),
                    Some(w) => self.contacts_of_wall(at, springs, dt, w, found),
                }
            }
        });
        found.clear();
        found.extend(buffers.iter().flatten());
    }

    fn contacts_of<S: SolidSpace>(
        &self,
        at: &ContactStage<'_, S>,
        springs: &TangentialSprings<S>,
        dt: f64,
        i: usize,
        found: &mut Vec<Contact<S>>,
    ) {
        let constants = at.constants;
        let (body, mass) = (&at.bodies[constants.body[i] as usize], constants.mass[i]);
        for (other, group) in at.by_body(at.lists.bodies.of(i)) {
            let near = group.iter().map(|j| at.near(i, *j as usize));
            let other_body = &at.bodies[other as usize];
            // Not that of a neighbour: which is listed first depends on when lists were built.
            let other_mass = other_body.largest_mass;
            let contact = ContactConstants {
                mass: mass * other_mass / (mass + other_mass),
                ..self.constants(body, Some(other_body), mass)
            };
            let key = (i as u32, Owner::Body(other));
            found.extend(self.contact(key, &self.fields.bodies, &contact, near, springs, dt));
        }
        let near = at.walls_of(i).map(|w| at.near_wall(i, w));
        let key = (i as u32, Owner::Walls);
        let contact = self.constants(body, None, mass);
        found.extend(self.contact(key, &self.fields.walls, &contact, near, springs, dt));
    }

    fn contacts_of_wall<S: SolidSpace>(
        &self,
        at: &ContactStage<'_, S>,
        springs: &TangentialSprings<S>,
        dt: f64,
        w: usize,
        found: &mut Vec<Contact<S>>,
    ) {
        for (body, group) in at.by_body(at.lists.of_walls.of(w)) {
            let near = group.iter().map(|i| {
                let (x, v) = at.near_wall(*i as usize, w);
                (-x, -v)
            });
            let key = ((at.constants.len() + w) as u32, Owner::Body(body));
            let owner = &at.bodies[body as usize];
            let contact = self.constants(owner, None, owner.largest_mass);
            found.extend(self.contact(key, &self.fields.bodies_from_walls, &contact, near, springs, dt));
        }
    }

    /// Depth of a contact as the bodies are laid out \[m\].
    fn start_depth(&self, key: &ContactKey) -> f64 {
        self.start.binary_search_by_key(key, |(key, _)| *key).map_or(0.0, |k| self.start[k].1)
    }

    /// Depths of all contacts, ascending by key \[m\].
    pub fn depths<S: SolidSpace>(&self, at: &ContactStage<'_, S>) -> StartDepths {
        let mut contacts = Contacts { found: Vec::new(), tasks: Vec::new() };
        self.find_contacts(at, &TangentialSprings::default(), &mut contacts);
        let touching = contacts.found.iter().filter(|contact| contact.depth > 0.0);
        touching.map(|contact| (contact.key, contact.depth)).collect()
    }

    /// Constants of the contact of `body` with `other` or a wall.
    fn constants<S: SolidSpace>(
        &self,
        body: &Body<S>,
        other: Option<&Body<S>>,
        mass: f64,
    ) -> ContactConstants {
        let softer = other.map_or(f64::INFINITY, |other| other.material.bulk_modulus);
        let pressure = 0.5 * self.stiffness * body.material.bulk_modulus.min(softer);
        let rigid = [Some(body), other].iter().flatten().any(|body| body.formulation.is_rigid());
        ContactConstants { stiffness: pressure * S::face_over_side(self.spacing), mass, rigid }
    }

    /// The contact of a particle with the neighbours `near`, if it lies in them; `dt` \[s\] after the time of `springs`.
    fn contact<S: SolidSpace>(
        &self,
        key: ContactKey,
        field: &DensityField,
        constants: &ContactConstants,
        near: impl Iterator<Item = RelativeState<S>> + Clone,
        springs: &TangentialSprings<S>,
        dt: f64,
    ) -> Option<Contact<S>> {
        let square = field.support * field.support;
        let near = near.filter(|(x, _)| x.norm_squared() < square);
        // Most rows of neighbours end here.
        let depth = field.depth(near.clone().map(|(x, _)| field.weight(x.norm())).sum());
        let onset = if constants.rigid { field.imminent } else { 0.0 };
        if depth <= onset {
            return None;
        }
        let start = self.start_depth(&key).min(S::STIFFEST_DEPTH * field.distance);
        let depth = depth - start;
        if depth <= onset {
            return None;
        }
        let (mut gradient, mut rate, mut reach) = (S::Vector::zeros(), 0.0, 0.0);
        for (x, v) in near.clone() {
            let part = x * field.gradient_factor(x.norm());
            gradient += part;
            rate += part.dot(&v);
            reach += part.norm();
        }
        if depth <= 0.0 {
            let sides = if self.friction > 0.0 { 2.0 } else { 1.0 };
            return Contact::imminent(key, sides * constants.stiffness, gradient.norm(), reach);
        }
        let (distance, gain) = (field.distance - start, field.gain);
        let spring = Spring::new::<S>(constants.stiffness, depth, distance);
        let dashpot = 2.0 * self.damping * (constants.stiffness * constants.mass).sqrt();
        // Within the spring's force: no jump at the onset, no attraction at the end, the same relative loss at any speed.
        let damping = (dashpot * gain * rate).clamp(-spring.force, spring.force);
        let slope = gain * (spring.force + damping);
        let normal = slope * gradient.norm();
        let has_friction = self.friction > 0.0 && normal > 0.0;
        let friction = if has_friction {
            let law =
                FrictionConstants { stiffness: constants.stiffness, dashpot, bound: self.friction * normal };
            Friction::new(field, &law, near, &gradient, springs.of(&key), dt)
        } else {
            Friction::default()
        };
        // Gershgorin's bound of the rows of p' ∇D ⊗ ∇D; a sticking contact is as stiff along the face.
        let sides = if has_friction { 2.0 } else { 1.0 };
        let stiffness = sides * gain * gain * spring.slope * (gradient.norm() + reach);
        Some(Contact { key, slope, depth, stiffness, friction })
    }

    /// Contact forces on particle `i`: reactions to its own contacts, and forces of the contacts of others with its body.
    fn forces<S: SolidSpace>(
        &self,
        at: &ContactStage<'_, S>,
        contacts: &[Contact<S>],
        i: usize,
    ) -> ContactForces<S> {
        let mut sums = ContactForces::default();
        let (mut of_bodies, mut of_walls) = (S::Vector::zeros(), S::Vector::zeros());
        let (mut wall_power, mut wall_friction_power) = (0.0, 0.0);
        let own = |key: ContactKey| {
            contacts.binary_search_by_key(&key, |contact| contact.key).ok().map(|k| &contacts[k])
        };
        let body = Owner::Body(at.constants.body[i]);
        // `sign` is 1 for the reaction to the particle's own contact, −1 for the force of another's.
        let mut add = |contact: &Contact<S>, field: &DensityField, x_ij: &S::Vector, sign: f64| {
            let (r, x_sj) = (x_ij.norm(), *x_ij * sign);
            if r >= field.support {
                return [S::Vector::zeros(); 2];
            }
            sums.stiffness += contact.stiffness_at(field, r);
            sums.depth = sums.depth.max(contact.depth);
            let [force, friction] = contact.on_neighbour(field, &x_sj).map(|force| force * -sign);
            sums.friction += friction;
            [force, friction]
        };
        for (other, group) in at.by_body(at.lists.bodies.of(i)) {
            let contact = own((i as u32, Owner::Body(other)));
            for &j in group {
                let x_ij = at.near(i, j as usize).0;
                if let Some(contact) = contact {
                    let [force, _] = add(contact, &self.fields.bodies, &x_ij, 1.0);
                    of_bodies += force;
                }
                if let Some(contact) = own((j, body)) {
                    let [force, _] = add(contact, &self.fields.bodies, &x_ij, -1.0);
                    of_bodies += force;
                }
            }
        }
        let contact = own((i as u32, Owner::Walls));
        for w in at.walls_of(i) {
            let (x_iw, v_w) = (at.near_wall(i, w).0, at.walls.velocity[w]);
            let mut take = |[force, friction]: [S::Vector; 2]| {
                of_walls += force;
                wall_power += force.dot(&v_w);
                wall_friction_power += friction.dot(&v_w);
            };
            if let Some(contact) = contact {
                take(add(contact, &self.fields.walls, &x_iw, 1.0));
            }
            if let Some(contact) = own(((at.constants.len() + w) as u32, body)) {
                take(add(contact, &self.fields.bodies_from_walls, &x_iw, -1.0));
            }
        }
        ContactForces { bodies: of_bodies, walls: of_walls, wall_power, wall_friction_power, ..sums }
    }
}
