//! Contact by a central repulsion that never pulls.

use rayon::prelude::*;

use sph::stage::StageTime;
use sph::vector::Vector;

use super::lists::{ContactLists, TASK};
use super::model::SolidModel;
use super::particles::Particles;
use super::walls::WallState;

/// Repulsion between particles of different bodies, and of bodies and walls.
///
/// ```text
/// f = max(0, kK (d − r) d/r + w c u) n,  r < d
/// n = x_ab/r,  u = −v_ab·n,  c = 2ζ √(kK m),  w = min(1, 4 (d − r)/d)
/// ```
///
/// kK is the stiffness per metre of depth \[Pa\]: the given fraction k of the softer body's bulk modulus, a wall being
/// the stiffer side. It sets in without a jump at the distance d and grows without bound as the particles meet, so
/// that bodies do not pass through each other. ζ is the given fraction of critical damping for the pair's reduced
/// mass m; it acts in full from a depth of d/4, and where parting would make it pull it ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repulsion {
    /// Stiffness k as a fraction of the bulk modulus \[-\].
    pub stiffness: f64,
    /// Distance d at which it sets in \[m\].
    pub distance: f64,
    /// Damping ζ as a fraction of critical \[-\].
    pub damping: f64,
}

/// One particle's contact in a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ContactSums {
    /// Force from other bodies \[N/m\].
    pub bodies: Vector,
    /// Force from walls \[N/m\].
    pub walls: Vector,
    /// Sum of the stiffness of all its contacts \[Pa\].
    pub stiffness: f64,
}

/// Two particles in touch: the softer bulk modulus \[Pa\] and the reduced mass \[kg/m\].
#[derive(Clone, Copy)]
struct Contact {
    bulk_modulus: f64,
    reduced_mass: f64,
}

impl Repulsion {
    /// Force on a of the pair \[N/m\] and its stiffness \[Pa\], for x_ab and v_ab.
    #[inline]
    fn force(&self, contact: &Contact, x_ab: &Vector, v_ab: &Vector) -> (Vector, f64) {
        let r = x_ab.norm();
        // Coincident particles have no direction of their own to part in.
        if r >= self.distance || r == 0.0 {
            return (Vector::zeros(), 0.0);
        }
        let stiffness = self.stiffness * contact.bulk_modulus;
        let depth = self.distance - r;
        let ratio = self.distance / r;
        let closing = -v_ab.dot(x_ab) / r;
        let dashpot = 2.0 * self.damping * (stiffness * contact.reduced_mass).sqrt();
        let onset = (4.0 * depth / self.distance).min(1.0);
        let magnitude = (stiffness * depth * ratio + onset * dashpot * closing).max(0.0);
        (x_ab * (magnitude / r), stiffness * ratio * ratio)
    }

    /// Contact forces on all particles at the stage state.
    pub fn evaluate(
        &self,
        model: &SolidModel,
        time: &StageTime,
        stage: &Particles,
        lists: &ContactLists,
        walls: &WallState,
        sums: &mut [ContactSums],
    ) {
        sums.par_iter_mut().with_min_len(8 * TASK).enumerate().for_each(|(i, sums)| {
            *sums = ContactSums::default();
            for &j in lists.bodies.of(i) {
                let (force, stiffness) = self.between_bodies(model, stage, i, j as usize);
                sums.bodies += force;
                sums.stiffness += stiffness;
            }
            let row = lists.walls.of(i);
            if row.is_empty() || !model.touches_walls(i, time) {
                return;
            }
            let body = model.body_of(i);
            let contact =
                Contact { bulk_modulus: body.material.bulk_modulus, reduced_mass: model.particles.mass[i] };
            for w in row.iter().map(|w| *w as usize).filter(|w| model.wall_acts_on(body, *w, time)) {
                let x_iw = model.domain.separation(&stage.position[i], &walls.position[w]);
                let v_iw = stage.velocity[i] - walls.velocity[w];
                let (force, stiffness) = self.force(&contact, &x_iw, &v_iw);
                sums.walls += force;
                sums.stiffness += stiffness;
            }
        });
    }

    /// Force on i from j of another body \[N/m\], bit for bit the opposite of that on j from i, and its stiffness.
    fn between_bodies(&self, model: &SolidModel, stage: &Particles, i: usize, j: usize) -> (Vector, f64) {
        let (a, b) = (i.min(j), i.max(j));
        let modulus = |k: usize| model.body_of(k).material.bulk_modulus;
        let (m_a, m_b) = (model.particles.mass[a], model.particles.mass[b]);
        let contact =
            Contact { bulk_modulus: modulus(a).min(modulus(b)), reduced_mass: m_a * m_b / (m_a + m_b) };
        let x_ab = model.domain.separation(&stage.position[a], &stage.position[b]);
        let v_ab = stage.velocity[a] - stage.velocity[b];
        let (force, stiffness) = self.force(&contact, &x_ab, &v_ab);
        (if i == a { force } else { -force }, stiffness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Repulsion = Repulsion { stiffness: 0.5, distance: 0.01, damping: 0.3 };
    const CONTACT: Contact = Contact { bulk_modulus: 2e7, reduced_mass: 0.05 };

    #[test]
    fn repulsion_is_central_never_pulls_and_sets_in_without_a_jump() {
        for k in 1..=200 {
            let r = 1e-4 * f64::from(k);
            let x_ab = Vector::new(0.6, 0.8) * r;
            for u in [-50.0, -1.0, 0.0, 1.0, 50.0] {
                let v_ab = x_ab / r * u + Vector::new(-0.8, 0.6) * 3.0;
                let (force, _) = LAW.force(&CONTACT, &x_ab, &v_ab);
                let along = force.dot(&x_ab) / r;
                assert!(along >= 0.0, "pulls at {r} m, {u} m/s");
                assert!((force - x_ab * (along / r)).norm() <= 1e-12 * along);
                assert!(r < LAW.distance || along == 0.0);
            }
        }
        let near =
            |depth: f64| LAW.force(&CONTACT, &Vector::new(0.01 - depth, 0.0), &Vector::new(-1.0, 0.0)).0;
        // Stiffness 1e7 Pa and the onset of the dashpot: a depth of 1e-9 m gives about 0.01 N/m.
        assert!(near(1e-9).norm() < 0.1);
        assert!(near(1e-3).norm() > 1e4);
    }

    #[test]
    fn stiffness_is_the_slope_of_the_force_at_onset() {
        let force = |depth: f64| LAW.force(&CONTACT, &Vector::new(0.01 - depth, 0.0), &Vector::zeros()).0.x;
        let slope = force(1e-8) / 1e-8;
        assert!((slope / 1e7 - 1.0).abs() < 1e-5);
    }
}
