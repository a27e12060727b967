//! Rates of change of every fluid particle, Eq. (17)-(19), (22)-(24).

use rayon::prelude::*;
use sph::vector::Vector;

use super::gradients::{Gradients, mirrored_stress, momentum_tensor};
use super::lists::Lists;
use super::model::FluidModel;
use super::pair::{Geometry, IDENTITY, Matrix, PairSums, Record};
use super::state::FluidState;
use super::walls::WallStates;

/// Fluid particles per task.
pub const TASK: usize = 256;

/// Rates of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Acceleration \[m/s²\].
    pub acceleration: Vector,
    /// Part of it by walls \[m/s²\].
    pub walls: Vector,
    /// Part of it by the body force \[m/s²\].
    pub body: Vector,
    /// Density rate \[kg/(m³ s)\].
    pub density: f64,
}

/// What the rates are computed from.
#[derive(Clone, Copy)]
pub struct StageFields<'a> {
    /// Constants.
    pub model: &'a FluidModel,
    /// State.
    pub state: &'a FluidState,
    /// Neighbours.
    pub lists: &'a Lists,
    /// Fluid as neighbours read it.
    pub fluid: &'a [Record],
    /// Walls as neighbours read them.
    pub walls: &'a WallStates,
    /// Results of the gradient pass.
    pub gradients: &'a Gradients,
    /// Time of the stage state \[s\].
    pub time: f64,
}

impl StageFields<'_> {
    /// Rates by the fluid itself, walls, body force and damping into `rates`.
    pub fn rates<G: Geometry>(&self, geometry: G, rates: &mut Vec<Rates>) {
        let passes = self.model.passes;
        rates.resize(self.fluid.len(), Rates::default());
        match (passes.density_gradient, passes.tensor()) {
            (false, false) => self.gather::<G, false, false>(geometry, rates),
            (true, false) => self.gather::<G, true, false>(geometry, rates),
            (false, true) => self.gather::<G, false, true>(geometry, rates),
            (true, true) => self.gather::<G, true, true>(geometry, rates),
        }
    }

    fn gather<G: Geometry, const GRADIENT: bool, const TENSOR: bool>(
        &self,
        geometry: G,
        rates: &mut [Rates],
    ) {
        let Self { model, state, lists, fluid, gradients, .. } = self;
        let damping = model.damping_rate(self.time);
        let body_force = model.body_force.at(self.time);
        rates.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(i, rates)| {
            let own = &fluid[i];
            let mut sums = self.sums::<GRADIENT, TENSOR>(i);
            for &j in lists.fluid.of(i) {
                let j = j as usize;
                let gradient = if GRADIENT { gradients.density[j] } else { [0.0; 2] };
                let tensor = if TENSOR { gradients.tensor[j] } else { [0.0; 4] };
                sums.add(geometry.separation(own, &fluid[j]), &fluid[j], gradient, tensor);
            }
            let walls = self.wall_sums::<G, GRADIENT, TENSOR>(geometry, i, |_| true);
            let [by_fluid, by_walls] = [&sums, &walls].map(|sums| {
                let [x, y] = sums.stress_divergence;
                Vector::new(x, y) / -own.density
            });
            let body = body_force.acceleration(&state.position[i]);
            *rates = Rates {
                acceleration: by_fluid + by_walls + body - state.velocity[i] * damping,
                walls: by_walls,
                body,
                density: own.density * (sums.continuity + walls.continuity)
                    + model.diffusion * (sums.diffusion + walls.diffusion),
            };
        });
    }

    #[inline(always)]
    fn sums<const GRADIENT: bool, const TENSOR: bool>(&self, i: usize) -> PairSums<'_, GRADIENT, TENSOR> {
        let gradients = self.gradients;
        let gradient = if GRADIENT { gradients.density[i] } else { [0.0; 2] };
        let (tensor, correction) =
            if TENSOR { (gradients.tensor[i], gradients.correction[i]) } else { ([0.0; 4], IDENTITY) };
        PairSums::new(&self.model.law, &self.fluid[i], gradient, tensor, correction)
    }

    /// Sums of particle `i` over the wall particles for which `include` says so.
    ///
    /// A wall takes ∇ρ and L of the particle, and its viscous stress, mirrored where it slips.
    #[inline(always)]
    fn wall_sums<G: Geometry, const GRADIENT: bool, const TENSOR: bool>(
        &self,
        geometry: G,
        i: usize,
        include: impl Fn(usize) -> bool,
    ) -> PairSums<'_, GRADIENT, TENSOR> {
        let mut sums = self.sums::<GRADIENT, TENSOR>(i);
        let gradient = if GRADIENT { self.gradients.density[i] } else { [0.0; 2] };
        for &w in self.lists.walls.of(i) {
            let w = w as usize;
            let record = &self.walls.records[w];
            if record.volume > 0.0 && include(w) {
                let tensor = if TENSOR { self.wall_tensor(i, w) } else { [0.0; 4] };
                sums.add(geometry.separation(&self.fluid[i], record), record, gradient, tensor);
            }
        }
        sums
    }

    fn wall_tensor(&self, i: usize, w: usize) -> Matrix {
        let normal = &self.walls.field.mirror_normal[w];
        let stress = mirrored_stress(&self.gradients.viscous_stress[i], [normal.x, normal.y]);
        momentum_tensor(self.walls.records[w].pressure, &stress, &self.gradients.correction[i])
    }

    /// Force of the fluid on wall `wall` (index) \[N/m\].
    pub fn wall_force<G: Geometry>(&self, geometry: G, wall: u32) -> Vector {
        let part_of_wall = |w: usize| self.model.walls.wall[w] == wall;
        let force = |i: usize| {
            let volume = self.fluid[i].volume;
            let [x, y] = if self.model.passes.tensor() {
                self.wall_sums::<G, false, true>(geometry, i, part_of_wall).stress_divergence
            } else {
                self.wall_sums::<G, false, false>(geometry, i, part_of_wall).stress_divergence
            };
            Vector::new(x, y) * volume
        };
        sph::sums::ordered_sum(self.fluid.len(), force)
    }
}
