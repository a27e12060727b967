//! Bodies that stand within the contact distance of each other or of walls when they are laid out.

use sph::coupling::stage::StageTime;
use sph::space::tensors::SpaceVector;

use crate::boundary::walls::WallState;
use crate::contact::friction::{Owner, StartDepths};
use crate::contact::repulsion::{ContactStage, Repulsion};
use crate::neighbours::lists::{ContactFilter, ContactLists};
use crate::particles::variables::Particles;
use crate::space::SolidSpace;
use crate::system::model::{ContactModel, SolidModel};

sph::constants! {
    /// Faces of curved bodies that touch are not rows side by side.
    const REMARKABLE: f64 = 0.03, "solid.contact.remarkable",
        "depth at the start, in contact distances, from which a check names it [-]";
}

/// Depths in contact of the bodies of `model` as they are laid out, undeformed, in the step of `time`.
///
/// Contact forces are measured from these: bodies that are drawn touching neither attract nor repel each other until
/// they approach further.
pub fn start_depths<S: SolidSpace>(model: &SolidModel<S>, law: &Repulsion, time: &StageTime) -> StartDepths {
    let domain = &model.domain;
    let n = model.len();
    let position: Vec<S::Vector> =
        model.particles.reference_position.iter().map(|x| domain.wrapped(x)).collect();
    let stage = Particles {
        velocity: vec![S::Vector::zeros(); n],
        density: vec![0.0; n],
        deviatoric_stress: vec![S::SymmetricTensor::default(); n],
        position,
    };
    let walls: WallState<S> = model.walls.at_start();
    let radii = model.contact.radii();
    let mut lists = ContactLists::new(model.spacing, radii, radii, n, model.walls.len());
    let filter = ContactFilter {
        particles: model.has_contact().then_some(|i, j| model.may_be_in_contact(i, j)),
        walls: |i, w| model.wall_acts_on(i, w, time),
        released: model.released(time),
    };
    lists.refresh(domain, &stage.position, model.walls.places(&walls), &filter);
    let at = ContactStage {
        domain,
        constants: &model.particles,
        bodies: &model.bodies,
        at: time.step_start,
        stage: &stage,
        lists: &lists.near,
        walls: &walls,
    };
    law.depths(&at)
}

/// Pairs that are described; the rest are counted.
const DESCRIBED: usize = 8;

/// The deepest overlap at the start of each body with each other and with walls, in words, the deepest ones first.
pub fn remarks<S: SolidSpace>(model: &SolidModel<S>) -> Vec<String> {
    let ContactModel::Repulsion(law) = &model.contact else { return Vec::new() };
    let n = model.len();
    let mut deepest: Vec<(u32, Owner, f64, usize)> = Vec::new();
    for ((k, owner), depth) in &law.start {
        let k = *k as usize;
        // A wall particle in a body and a particle of the body in the wall are one pair.
        let (body, owner) = match owner {
            Owner::Body(other) if k < n => {
                let own = model.particles.body[k];
                (own.min(*other), Owner::Body(own.max(*other)))
            }
            Owner::Body(other) => (*other, Owner::Walls),
            Owner::Walls => (model.particles.body[k], Owner::Walls),
        };
        match deepest.iter_mut().find(|found| (found.0, found.1) == (body, owner)) {
            Some(found) if found.2 < *depth => (found.2, found.3) = (*depth, k),
            Some(_) => {}
            None => deepest.push((body, owner, *depth, k)),
        }
    }
    let distance = law.fields.bodies.distance;
    deepest.retain(|(_, _, depth, _)| *depth > REMARKABLE * distance);
    deepest.sort_by(|a, b| b.2.total_cmp(&a.2));
    let more = deepest.len().saturating_sub(DESCRIBED);
    let others = (more > 0).then(|| {
        format!("{more} more pairs of bodies, or bodies and walls, start within the contact distance")
    });
    deepest
        .into_iter()
        .take(DESCRIBED)
        .map(|(body, owner, depth, k)| {
            let other = match owner {
                Owner::Walls => "a wall".to_owned(),
                Owner::Body(other) => format!("body `{}`", model.bodies[other as usize].name),
            };
            let x = match k.checked_sub(n) {
                None => model.particles.reference_position[k],
                Some(w) => model.walls.start[w],
            };
            let place: Vec<String> = (0..S::DIMENSIONS).map(|axis| format!("{:.6}", x[axis])).collect();
            format!(
                "body `{}` starts {depth:.2e} m ({:.2} particle spacings) within the contact distance of {other}, at ({}) m: \
                 they count as touching, and cannot come nearer to each other; where they are to be free, state the \
                 gap that they keep as `solid.contact.gap_m`, move the body or give it a `lattice_origin_m`",
                model.bodies[body as usize].name,
                depth / model.spacing,
                place.join(", ")
            )
        })
        .chain(others)
        .collect()
}
