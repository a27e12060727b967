//! Pressure along gaps: harmonic between the water that is there and the air.

use sph::space::tensors::SpaceVector;
use sph::tasks::{PerTask, for_each_task};

use crate::contact::film::{Film, FilmStage, NONE};
use crate::neighbours::lists::TASK;
use crate::space::SolidSpace;

/// A link of one node to another.
#[derive(Clone, Copy, Debug)]
struct Link {
    other: u32,
    /// w = V_i V_j W \[m²\].
    weight: f64,
    /// Pressure over that of the other at rest, ρ₀ b·x_ij \[Pa\].
    head: f64,
}

/// Links of the nodes of one task.
#[derive(Debug, Default)]
struct TaskLinks {
    ends: Vec<u32>,
    links: Vec<Link>,
}

/// Pressure at the nodes of the film.
///
/// A gap is thinner than what is solved for, so the water in it is taken to be at rest relative to the gap: its pressure, less
/// that of its height, is harmonic along the gap. With V_i w_i = V_i Σ_f V_f W toward the pressure p̂ of the water that the sums
/// of a node see, and V_i a_i toward the air, that is
///
/// ```text
/// Σ_j w_ij (p_i − p_j − ρ₀ b·x_ij) + V_i w_i (p_i − p̂_i) + V_i a_i p_i = 0
/// ```
/// j are the nodes of the same face and of the face opposite. Nodes that no such chain links with water are dry. So pressure
/// reaches everywhere below a body in water, and falls linearly to zero below one with water on one side, as the uplift below a
/// dam does. Solved by conjugate gradients, preconditioned by the diagonal.
#[derive(Debug, Default)]
pub struct FilmPressure {
    /// Linked with water.
    reached: Vec<bool>,
    pressure: Vec<f64>,
    offsets: Vec<u32>,
    links: Vec<Link>,
    tasks: Vec<TaskLinks>,
    stack: Vec<u32>,
    solver: Solver,
}

/// Vectors of the conjugate gradients.
#[derive(Debug, Default)]
struct Solver {
    diagonal: Vec<f64>,
    residual: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
}

sph::constants! {
    const TOLERANCE: f64 = 1e-9, "solid.film.tolerance",
        "residual of the film's pressure, over that at the start, at which its iteration ends [-]";
}

impl FilmPressure {
    /// Pressure at node `k` \[Pa\]; `None` where it is dry.
    pub fn of(&self, k: usize) -> Option<f64> {
        self.reached[k].then(|| self.pressure[k])
    }

    fn links(&self, k: usize) -> &[Link] {
        &self.links[self.offsets[k] as usize..self.offsets[k + 1] as usize]
    }

    /// Marks the nodes that links connect with the `wet` ones.
    fn reach(&mut self, count: usize, wet: impl Fn(usize) -> bool) {
        self.reached.clear();
        self.reached.extend((0..count).map(&wet));
        let mut stack = std::mem::take(&mut self.stack);
        stack.clear();
        stack.extend((0u32..).take(count).filter(|k| wet(*k as usize)));
        while let Some(k) = stack.pop() {
            for link in self.offsets[k as usize]..self.offsets[k as usize + 1] {
                let other = self.links[link as usize].other;
                if !std::mem::replace(&mut self.reached[other as usize], true) {
                    stack.push(other);
                }
            }
        }
        self.stack = stack;
    }

    /// Solves (L + held) p = source for the reached nodes, L the sums over links; p of the others is zero.
    fn solve(&mut self, held: impl Fn(usize) -> f64, source: impl Fn(usize, &[Link]) -> f64) {
        let count = self.reached.len();
        let mut solver = std::mem::take(&mut self.solver);
        let mut pressure = std::mem::take(&mut self.pressure);
        let Solver { diagonal, residual, direction, image } = &mut solver;
        diagonal.clear();
        residual.clear();
        for k in 0..count {
            let linked: f64 = self.links(k).iter().map(|link| link.weight).sum();
            diagonal.push(if self.reached[k] { held(k) + linked } else { 1.0 });
            residual.push(if self.reached[k] { source(k, self.links(k)) } else { 0.0 });
        }
        pressure.clear();
        pressure.resize(count, 0.0);
        direction.clear();
        direction.extend(residual.iter().zip(&*diagonal).map(|(r, d)| r / d));
        let norm = |residual: &[f64], diagonal: &[f64]| -> f64 {
            residual.iter().zip(diagonal).map(|(r, d)| r * r / d).sum()
        };
        let mut square = norm(residual, diagonal);
        let goal = square * TOLERANCE * TOLERANCE;
        // In exact arithmetic it ends after `count`.
        for _ in 0..2 * count {
            if square <= goal {
                break;
            }
            image.clear();
            image.extend((0..count).map(|k| {
                let linked: f64 =
                    self.links(k).iter().map(|link| link.weight * direction[link.other as usize]).sum();
                diagonal[k] * direction[k] - linked
            }));
            let along: f64 = direction.iter().zip(&*image).map(|(d, a)| d * a).sum();
            let step = square / along;
            for k in 0..count {
                pressure[k] += step * direction[k];
                residual[k] -= step * image[k];
            }
            let next = norm(residual, diagonal);
            let share = next / square;
            square = next;
            for k in 0..count {
                direction[k] = residual[k] / diagonal[k] + share * direction[k];
            }
        }
        self.pressure = pressure;
        self.solver = solver;
    }
}

impl<S: SolidSpace> Film<S> {
    /// Pressure at all nodes.
    pub(super) fn update_pressure(&mut self, at: &FilmStage<'_, S>) {
        let mut pressure = std::mem::take(&mut self.pressure);
        pressure.tasks.resize_with(self.nodes.len().div_ceil(TASK), TaskLinks::default);
        for_each_task(self.nodes.len(), TASK, PerTask(&mut pressure.tasks), &|nodes, PerTask(found)| {
            let found = &mut found[0];
            found.ends.clear();
            found.links.clear();
            for k in nodes {
                self.link(at, k, &mut found.links);
                found.ends.push(found.links.len() as u32);
            }
        });
        pressure.links.clear();
        pressure.offsets.clear();
        pressure.offsets.push(0);
        for task in &pressure.tasks {
            let before = pressure.links.len() as u32;
            pressure.offsets.extend(task.ends.iter().map(|end| before + end));
            pressure.links.extend_from_slice(&task.links);
        }
        pressure.reach(self.nodes.len(), |k| self.nodes[k].wet > 0.0);
        let water = |k: usize| self.nodes[k].volume * self.nodes[k].wet;
        let air = |k: usize| self.nodes[k].volume * self.face_weight * self.nodes[k].air;
        let held = |k: usize| water(k) + air(k);
        let of_heads = |k: usize, links: &[Link]| {
            let heads: f64 = links.iter().map(|link| link.weight * link.head).sum();
            water(k) * self.nodes[k].water_pressure + heads
        };
        pressure.solve(held, of_heads);
        self.pressure = pressure;
    }

    /// Links of node `k`: to nodes of its own face, and to those of the face opposite.
    fn link(&self, at: &FilmStage<'_, S>, k: usize, links: &mut Vec<Link>) {
        let node = &self.nodes[k];
        let i = node.particle as usize;
        self.each_near(at, &at.stage.position[i], |j, x| {
            let other = self.node_of[j];
            if j == i || other == NONE {
                return;
            }
            let neighbour = &self.nodes[other as usize];
            let opposite = at.can_face(i, j);
            let sense = if opposite { -1.0 } else { 1.0 };
            if sense * node.toward.dot(&neighbour.toward) <= S::SAME_FACE {
                return;
            }
            links.push(Link {
                other,
                weight: node.volume * neighbour.volume * self.kernel.value(x.norm()),
                head: 0.5 * self.rest_density * (node.acceleration + neighbour.acceleration).dot(&x),
            });
        });
    }
}
