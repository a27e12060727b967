//! Particles that leave: over an open rim or outflow side, or through a wall.

use serde::{Deserialize, Serialize};
use sph::coupling::ledger::Energies;
use sph::coupling::solver::Divergence;
use sph::coupling::stage::StageTime;
use sph::prescribed::motion::MotionState;
use sph::space::Space;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;
use sph::tasks::any;

use crate::neighbours::lists::Lists;
use crate::report::probes::energies_of;
use crate::system::list_limits::PLANE_HALF_WIDTH;
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::FluidState;
use crate::time::energy_budget;

/// Particles per task.
const TASK: usize = 2048;

sph::constants! {
    /// Where walls line the domain, this is the depth of their first layer.
    const CLOSED_SIDE_DEPTH: f64 = 0.5, "walls.closed_side_depth",
        "distance outside a closed side of the domain from which a particle counts as escaped, in spacings [-]";
}

/// Why a particle is removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Departure {
    Outflow,
    Escaped,
}

/// A particle that is removed.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
struct Departed<S: Space> {
    /// Its [`FluidState::place`].
    place: u64,
    departure: Departure,
    id: u32,
    position: S::Vector,
    momentum: S::Vector,
    energies: Energies,
}

/// A step at its end.
#[derive(Clone, Copy, Debug)]
pub struct EndedStep<'a, S: FluidSpace, F> {
    /// Its times.
    pub time: &'a StageTime,
    /// Neighbours.
    pub lists: &'a Lists<S>,
    /// Square of the largest move in its last stage \[m²\].
    pub largest_square_move: f64,
    /// Whether a particle is outside the domain.
    pub outside: bool,
    /// Where a particle was at its start \[m\].
    pub start: F,
}

/// Removes the particles that left during `step`; returns whether there were any.
///
/// *Outflow*: the centre is outside the domain beyond an open side. *Escaped*: the centre is outside beyond a closed
/// side by half a spacing, or it passed between the particles of a wall layer in this step: from the front of a wall
/// particle's plane (through its centre, normal to the wall) to its back, at most [`PLANE_HALF_WIDTH`] beside it. For the
/// first layer that plane lies half a spacing behind the wall's face. Passing above the topmost particle of a rim is
/// no crossing. A released wall is none.
///
/// # Errors
/// When more particles have escaped than the case allows.
pub fn remove_departed<S: FluidSpace, F: Fn(&FluidState<S>, usize) -> S::Vector + Sync>(
    model: &FluidModel<S>,
    state: &mut FluidState<S>,
    step: &EndedStep<'_, S, F>,
) -> Result<bool, Box<Divergence>> {
    let time = step.time;
    (state.removed_momentum, state.removed_angular_momentum) = (S::Vector::zeros(), S::Spin::default());
    let watch = DepartureCheck {
        model,
        state,
        step,
        before: model.walls.motions_at(time.step_start),
        after: model.walls.motions_at(time.target_time()),
    };
    let leaves = |i: usize| watch.departure(i).is_some();
    let outside = |i: usize| !model.domain.contains(&state.position[i]);
    let some = match step.lists.near_walls(model, step.largest_square_move) {
        Some(near) => {
            near.iter().any(|i| leaves(*i as usize))
                || step.outside && any(state.len(), TASK, |i| outside(i) && leaves(i))
        }
        None => any(state.len(), TASK, leaves),
    };
    if !model.team.any(some) {
        return Ok(false);
    }
    let departed: Vec<Option<Departure>> = (0..state.len()).map(|i| watch.departure(i)).collect();
    let of_particle = |(i, departure): (usize, &Option<Departure>)| {
        departure.map(|departure| Departed {
            place: state.place(i),
            departure,
            id: state.id[i],
            position: state.position[i],
            momentum: state.velocity[i] * state.mass[i],
            energies: energies_of(model, state, &model.falling, i),
        })
    };
    let own: Vec<Departed<S>> = departed.iter().enumerate().filter_map(of_particle).collect();
    let mut all = model.team.join(own, Vec::extend);
    all.sort_by_key(|departed| departed.place);
    let mut offending = None;
    for Departed { departure, id, position, momentum, energies, .. } in all {
        match departure {
            Departure::Outflow => state.outflow += 1,
            Departure::Escaped => {
                state.escaped += 1;
                if state.escaped > model.escaped_particle_limit && offending.is_none() {
                    offending = Some((id, position));
                }
            }
        }
        state.removed_momentum += momentum;
        energy_budget::enter_removed(&mut state.energy.flows, &energies);
        state.removed_angular_momentum += S::cross(&(position - model.domain.torque_origin()), &momentum);
    }
    if let Some((id, x)) = offending {
        return Err(Box::new(Divergence {
            at: time.at,
            particle: Some(id),
            position: Some(x.row().as_ref().to_vec()),
            quantity: "lost fluid particles".into(),
            value: state.escaped as f64,
            allowed: format!("at most {}", model.escaped_particle_limit),
            hint: "the particle crossed a wall or a closed side of the domain; use a smaller time step, more wall \
                   layers, or declare the side as outflow"
                .into(),
        }));
    }
    state.retain(|i| departed[i].is_none());
    state.others = model.team.join(state.len(), |all, others| *all += others) - state.len();
    Ok(true)
}

/// Decides for each particle whether it left during a step.
struct DepartureCheck<'a, S: FluidSpace, F> {
    model: &'a FluidModel<S>,
    state: &'a FluidState<S>,
    step: &'a EndedStep<'a, S, F>,
    before: Vec<Option<MotionState<S>>>,
    after: Vec<Option<MotionState<S>>>,
}

impl<S: FluidSpace, F: Fn(&FluidState<S>, usize) -> S::Vector> DepartureCheck<'_, S, F> {
    fn departure(&self, i: usize) -> Option<Departure> {
        let x = &self.state.position[i];
        if !self.model.domain.contains(x)
            && let Some(departure) = self.beyond_a_side(x)
        {
            return Some(departure);
        }
        let crossed = |w: usize| self.crossed(i, w);
        self.step.lists.walls.neighbours(i).any(crossed).then_some(Departure::Escaped)
    }

    fn beyond_a_side(&self, x: &S::Vector) -> Option<Departure> {
        let (domain, outflow) = (&self.model.domain, &self.model.outflow);
        let depth = CLOSED_SIDE_DEPTH * self.model.constants.particle_spacing;
        let mut departure = None;
        for axis in (0..S::DIMENSIONS).filter(|axis| !domain.periodic[*axis]) {
            let below = domain.lower[axis] - x[axis];
            let above = x[axis] - domain.upper[axis];
            for (outside, open) in [(below, outflow.lower[axis]), (above, outflow.upper[axis])] {
                if outside > 0.0 && open {
                    // Over the rim first and past another side later is still outflow.
                    return Some(Departure::Outflow);
                }
                if outside > depth {
                    departure = Some(Departure::Escaped);
                }
            }
        }
        departure
    }

    /// Whether particle `i` passed the plane of wall particle `w` from front to back in this step.
    fn crossed(&self, i: usize, w: usize) -> bool {
        let Self { model, state, step, .. } = self;
        let walls = &model.walls;
        let (x_w, normal) = walls.placed(w, &self.after);
        let d = model.domain.separation(&state.position[i], &x_w);
        let height = d.dot(&normal);
        // Most are in front; without a normal there is no height.
        if height >= 0.0 {
            return false;
        }
        let beside = (d - normal * height).norm();
        if beside > PLANE_HALF_WIDTH * model.constants.particle_spacing
            || !walls.acts(walls.wall[w], step.time.step_start)
        {
            return false;
        }
        let (x_w, normal) = walls.placed(w, &self.before);
        model.domain.separation(&(step.start)(state, i), &x_w).dot(&normal) >= 0.0
    }
}
