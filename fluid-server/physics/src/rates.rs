//! Rates of change of every fluid particle, Eq. (17)-(19), (22)-(24).

use std::marker::PhantomData;
use std::ops::AddAssign;

use sph::body_force::BodyForceAt;
use sph::geometry::Geometry;
use sph::lanes::{Kernel, Lanes, WIDTH};
use sph::stage::Stage;
use sph::vector::{Vector, cross};

use super::gradients::{Gradients, Scene, mirrored_stress, momentum_tensor};
use super::model::FluidModel;
use super::pair::{
    Found, Friction, IDENTITY, LawLanes, Matrix, Own, PairSums, PairTotals, Symmetric, Terms, With,
};
use super::record::{Batch, gather, gather_columns};
use super::shifting::{self, Control, nearest_surface};
use super::state::FluidState;
use super::tasks::{PerTask, for_each_task, per_task};
use super::walls::WallField;

/// Rates of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Acceleration \[m/s²\].
    pub acceleration: Vector,
    /// Velocity by which the position is shifted besides \[m/s\].
    pub shift: Vector,
    /// Density rate \[kg/(m³ s)\].
    pub density: f64,
}

/// Sums over the particles of one task: forces \[N/m\], and torques about the domain's torque origin \[N\].
#[derive(Clone, Copy, Debug, Default)]
pub struct OuterForces {
    /// Body force.
    pub body: Wrench,
    /// Force by walls.
    pub walls: Wrench,
    /// Force by stabilisers that are not antisymmetric.
    pub stabilisers: Wrench,
    /// Torque of the fluid's forces on itself, which do not all act along the line between two particles.
    pub own_torque: f64,
}

impl AddAssign for OuterForces {
    fn add_assign(&mut self, other: Self) {
        self.body += other.body;
        self.walls += other.walls;
        self.stabilisers += other.stabilisers;
        self.own_torque += other.own_torque;
    }
}

/// A force \[N/m\] and its torque \[N\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Wrench {
    /// Force.
    pub force: Vector,
    /// Torque.
    pub torque: f64,
}

impl Wrench {
    /// `force` that acts at `arm` \[m\] from the torque origin.
    #[inline(always)]
    fn at(arm: &Vector, force: Vector) -> Self {
        Self { force, torque: cross(arm, &force) }
    }
}

impl AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
    }
}

/// What the rates are computed from.
#[derive(Clone, Copy)]
pub struct StageFields<'a, G> {
    /// Fluid and walls.
    pub scene: Scene<'a, G>,
    /// State.
    pub state: &'a FluidState,
    /// Kinematics of the walls.
    pub field: &'a WallField,
    /// Results of the gradient pass.
    pub gradients: &'a Gradients,
    /// Time of the stage state \[s\].
    pub time: f64,
    /// Which rates.
    pub part: Part,
}

/// Which rates a stage computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// All, Eq. (30)-(31).
    #[default]
    Whole,
    /// The predictor of leapfrog: Eq. (17).
    Density,
    /// The corrector of leapfrog: Eq. (22), the diffusion of Eq. (18) and the order control.
    Momentum,
}

impl Part {
    /// What `stage` computes for `model`.
    pub fn of(model: &FluidModel, stage: Stage) -> Self {
        match (model.passes.leapfrog, stage) {
            (false, _) => Self::Whole,
            (true, Stage::Predictor) => Self::Density,
            (true, Stage::Corrector) => Self::Momentum,
        }
    }
}

impl<G: Geometry> StageFields<'_, G> {
    /// Rates by the fluid itself, walls, body force, damping and order control into `rates`; `outer` gets the sums of
    /// each task.
    pub fn rates(&self, rates: &mut Vec<Rates>, outer: &mut Vec<OuterForces>) {
        let passes = self.scene.model.passes;
        rates.resize(self.scene.fluid.len(), Rates::default());
        if self.part == Part::Density {
            // The gradient pass has made them.
        } else if passes.pair_viscosity {
            self.choose::<true>(rates, outer);
        } else {
            self.choose::<false>(rates, outer);
        }
    }

    fn choose<const VISCOUS: bool>(&self, rates: &mut [Rates], outer: &mut Vec<OuterForces>) {
        let passes = self.scene.model.passes;
        let (shown, tensor) = (passes.shown(), passes.tensor());
        if self.part == Part::Momentum {
            return match (shown, tensor) {
                (false, false) => self.gather(With::<false, false, false, false, VISCOUS>, rates, outer),
                (true, false) => self.gather(With::<true, false, false, false, VISCOUS>, rates, outer),
                (false, true) => self.gather(With::<false, true, false, false, VISCOUS>, rates, outer),
                (true, true) => self.gather(With::<true, true, false, false, VISCOUS>, rates, outer),
            };
        }
        match (shown, tensor, passes.correction) {
            (false, false, false) => self.gather(With::<false, false, true, false, VISCOUS>, rates, outer),
            (true, false, false) => self.gather(With::<true, false, true, false, VISCOUS>, rates, outer),
            (false, false, true) => self.gather(With::<false, false, true, true, VISCOUS>, rates, outer),
            (true, false, true) => self.gather(With::<true, false, true, true, VISCOUS>, rates, outer),
            (false, true, _) => self.gather(With::<false, true, true, true, VISCOUS>, rates, outer),
            (true, true, _) => self.gather(With::<true, true, true, true, VISCOUS>, rates, outer),
        }
    }

    fn gather<T: Terms>(&self, _: T, rates: &mut [Rates], outer: &mut Vec<OuterForces>) {
        let model = self.scene.model;
        let body_force = &model.body_force.at(self.time);
        let results = (rates, per_task(outer, self.scene.fluid.len()));
        for_each_task(self.scene.fluid.len(), results, &|particles, (rates, PerTask(outer))| {
            let first = particles.start;
            model.arithmetic.run(Evaluate {
                fields: self,
                terms: PhantomData::<T>,
                body_force,
                first,
                rates,
                outer: &mut outer[0],
            });
        });
    }

    #[inline(always)]
    fn own<L: Lanes, T: Terms>(&self, i: usize) -> Own<L> {
        let (fluid, gradients) = (&self.scene.fluid[i], self.gradients);
        let [damper, _, g_x, g_y] = if T::FOUND { gradients.shown[i] } else { [0.0; 4] };
        let corrected = T::CORRECTION && self.scene.model.passes.correction;
        let l = if corrected { gradients.correction[i] } else { IDENTITY };
        Own {
            motion: L::splat_each(fluid.motion),
            density: L::splat(fluid.density()),
            twice_density: L::splat(2.0 * fluid.density()),
            pressure: L::splat(fluid.pressure() + damper),
            density_gradient: [L::splat(g_x), L::splat(g_y)],
            tensor: if T::TENSOR { L::splat_each(gradients.tensor[i]) } else { [L::zero(); 4] },
            correction: [L::splat(l[0]), L::splat(l[1]), L::splat(l[2])],
        }
    }

    /// Sums of particle `i` over its fluid neighbours, and r² of the nearest of them at the free surface \[m²\].
    #[inline(always)]
    fn fluid_sums<L: Lanes, T: Terms>(&self, law: &LawLanes<L>, i: usize, own: &Own<L>) -> (PairSums<L>, L) {
        let Scene { geometry, lists, fluid, .. } = self.scene;
        let gradients = self.gradients;
        // The same length, as one check of an index then serves both.
        let shown = if T::FOUND { &gradients.shown[..fluid.len()] } else { &[] };
        let (mut sums, mut nearest) = (PairSums::zero(), L::splat(f64::INFINITY));
        for indices in lists.fluid.of(i) {
            let indices = *indices;
            let mut batch = Batch::gather(geometry, &own.motion, fluid, indices);
            let mut found = Found::nothing();
            if T::FOUND {
                let [damper, mark, g_x, g_y] = gather_columns(indices, shown);
                batch.pressure = batch.pressure + damper;
                found.density_gradient = [g_x, g_y];
                nearest = nearest_surface(nearest, mark, batch.square);
            }
            if T::TENSOR {
                found.tensor = gather_columns(indices, &gradients.tensor);
            }
            if T::VISCOUS {
                let viscosity = L::splat(gradients.viscosity[i]) + gather(indices, &gradients.viscosity);
                found.friction = Friction { viscosity, slip: [batch.v_x, batch.v_y] };
            }
            sums.add::<T>(law, own, &batch, &found);
        }
        (sums, nearest)
    }

    /// Sums of particle `i` over the particles of `wall`, or of all walls.
    ///
    /// A wall takes ∇ρ, L and damper of the particle, and its viscous stress, mirrored where it slips.
    #[inline(always)]
    fn wall_sums<L: Lanes, T: Terms>(
        &self,
        law: &LawLanes<L>,
        i: usize,
        own: &Own<L>,
        wall: Option<u32>,
    ) -> PairSums<L> {
        let Scene { geometry, model, lists, walls, .. } = self.scene;
        let damper = L::splat(self.damper(i));
        let correction = if T::TENSOR { self.gradients.in_momentum(model, i) } else { IDENTITY };
        let mut sums = PairSums::zero();
        for indices in lists.walls.of(i) {
            let indices = *indices;
            let mut batch = Batch::gather(geometry, &own.motion, walls, indices);
            if let Some(wall) = wall {
                let included = |w: u32| f64::from(u8::from(model.walls.wall.get(w as usize) == Some(&wall)));
                batch.volume = batch.volume * L::from_array(indices.map(included));
            }
            batch.pressure = batch.pressure + damper;
            let mut found = Found { density_gradient: own.density_gradient, ..Found::nothing() };
            if T::TENSOR {
                let [a, b, c, d] = indices.map(|w| self.wall_tensor(i, w as usize, &correction));
                found.tensor = L::columns([&a, &b, &c, &d]);
            }
            if T::VISCOUS {
                let viscosity = L::splat(2.0 * self.gradients.viscosity[i]);
                found.friction = Friction { viscosity, slip: self.resisted(indices, &batch) };
            }
            sums.add::<T>(law, own, &batch, &found);
        }
        sums
    }

    /// q of the acoustic damper of particle `i` \[Pa\].
    fn damper(&self, i: usize) -> f64 {
        self.gradients.damper(i)
    }

    /// The part of the velocity relative to walls that viscosity resists: all of it, or where they slip that along
    /// their normal.
    #[inline(always)]
    fn resisted<L: Lanes>(&self, indices: [u32; WIDTH], batch: &Batch<L>) -> [L; 2] {
        let normals = indices.map(|w| self.mirror_normal(w as usize));
        let (n_x, n_y) = (L::from_array(normals.map(|n| n.x)), L::from_array(normals.map(|n| n.y)));
        let slips = (n_x * n_x).plus_product(n_y, n_y);
        let across = (batch.v_x * n_x).plus_product(batch.v_y, n_y);
        let along = L::splat(1.0) - slips;
        [(along * batch.v_x).plus_product(across, n_x), (along * batch.v_y).plus_product(across, n_y)]
    }

    /// Normal of the mirror of wall particle `w`; none for the one that does not act.
    fn mirror_normal(&self, w: usize) -> Vector {
        self.field.mirror_normal.get(w).copied().unwrap_or_default()
    }

    /// T that wall particle `w` shows to particle `i`, with L_i as (22) takes it.
    fn wall_tensor(&self, i: usize, w: usize, correction: &Symmetric) -> Matrix {
        let normal = self.mirror_normal(w);
        let stress = self.gradients.viscous_stress.get(i);
        let stress = stress.map_or(Matrix::default(), |stress| mirrored_stress(stress, [normal.x, normal.y]));
        momentum_tensor(self.scene.walls[w].pressure() + self.damper(i), &stress, correction)
    }

    /// Repulsion \[m/s²\] of particle `i` by the faces of `wall`, or of all walls.
    ///
    /// ```text
    /// a = Σ_w (1 − |t_w|/Δx)₊ · a(z_w, v_n) · n_w
    /// ```
    /// a is [`sph::repulsion::Repulsion`], v_n the normal velocity relative to the wall, z_w the height over a particle
    /// w of the first layer, half a spacing behind the face, and t_w the distance beside it. The weights add up to one
    /// along a face, so that it is smooth; a particle at rest on the lattice (z = Δx) feels nothing. The pair forces
    /// vanish where a particle meets a wall particle, so that they alone can not hold a particle that has been pressed
    /// into the layer.
    fn wall_repulsion(&self, i: usize, wall: Option<u32>) -> Vector {
        let Scene { geometry, model, lists, fluid, walls } = self.scene;
        if !model.wall_repulsion.acts() {
            return Vector::zeros();
        }
        let spacing = model.constants.particle_spacing;
        let velocity = fluid[i].velocity();
        let mut acceleration = Vector::zeros();
        for w in lists.walls.neighbours(i) {
            let included = wall.is_none_or(|wall| model.walls.wall[w] == wall);
            // A wall particle without volume does not act.
            if !model.walls.first_layer[w] || walls[w].volume() == 0.0 || !included {
                continue;
            }
            let d = geometry.separation(&fluid[i].position(), &walls[w].position());
            let normal = &self.field.face_normal[w];
            let height = d.dot(normal);
            let beside = (d - normal * height).norm() / spacing;
            // Deeper than a layer it is the next face that counts, such as the far side of a thin wall.
            if height >= model.wall_repulsion.distance() || height < -spacing || beside >= 1.0 {
                continue;
            }
            let leaving = (velocity - self.field.velocity[w]).dot(normal);
            let repulsion = model.wall_repulsion.acceleration(height, leaving);
            acceleration += normal * ((1.0 - beside) * repulsion);
        }
        acceleration
    }

    /// Force of the fluid on each wall \[N/m\].
    pub fn wall_forces(&self) -> Vec<Vector> {
        let passes = self.scene.model.passes;
        match (passes.tensor(), passes.pair_viscosity) {
            (false, false) => self.sum_wall_forces(With::<false, false, false, false, false>),
            (false, true) => self.sum_wall_forces(With::<false, false, false, false, true>),
            (true, false) => self.sum_wall_forces(With::<false, true, false, false, false>),
            (true, true) => self.sum_wall_forces(With::<false, true, false, false, true>),
        }
    }

    fn sum_wall_forces<T: Terms>(&self, _: T) -> Vec<Vector> {
        let Scene { model, lists, fluid, .. } = self.scene;
        let walls = &model.walls;
        let mut forces: PerWall = sph::sums::ordered_sum(fluid.len(), |i| {
            // Most particles are near no wall, and few near more than one.
            let mut near: Vec<u32> = Vec::new();
            for w in lists.walls.neighbours(i) {
                if !near.contains(&walls.wall[w]) {
                    near.push(walls.wall[w]);
                }
            }
            let mut forces = PerWall::default();
            for wall in near {
                let kernel = WallForce { fields: self, terms: PhantomData::<T>, i, wall };
                let divergence = model.arithmetic.run(kernel);
                let repulsion = self.wall_repulsion(i, Some(wall));
                *forces.of(wall as usize) = divergence * fluid[i].volume() - repulsion * self.state.mass[i];
            }
            forces
        });
        forces.0.resize(walls.names.len(), Vector::zeros());
        forces.0
    }
}

/// Force on each wall \[N/m\]; zero on those beyond the end.
#[derive(Debug, Default)]
struct PerWall(Vec<Vector>);

impl PerWall {
    fn of(&mut self, wall: usize) -> &mut Vector {
        if self.0.len() <= wall {
            self.0.resize(wall + 1, Vector::zeros());
        }
        &mut self.0[wall]
    }
}

impl AddAssign for PerWall {
    fn add_assign(&mut self, other: Self) {
        for (wall, force) in other.0.into_iter().enumerate() {
            *self.of(wall) += force;
        }
    }
}

/// Σ V_w [...]·∇W of particle `i` over one wall \[Pa/m\].
struct WallForce<'a, G, T> {
    fields: &'a StageFields<'a, G>,
    terms: PhantomData<T>,
    i: usize,
    wall: u32,
}

impl<G: Geometry, T: Terms> Kernel for WallForce<'_, G, T> {
    type Output = Vector;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vector {
        let mut own = self.fields.own::<L, T>(self.i);
        own.pressure = own.pressure + L::splat(self.fields.damper(self.i));
        let law = self.fields.scene.model.law.lanes();
        self.fields.wall_sums::<L, T>(&law, self.i, &own, Some(self.wall)).total().stress_divergence
    }
}

/// The rates of the particles of one task.
struct Evaluate<'a, G, T> {
    fields: &'a StageFields<'a, G>,
    terms: PhantomData<T>,
    body_force: &'a BodyForceAt<'a>,
    first: usize,
    rates: &'a mut [Rates],
    outer: &'a mut OuterForces,
}

impl<G: Geometry, T: Terms> Kernel for Evaluate<'_, G, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { fields, body_force, first, rates, outer, .. } = self;
        let StageFields { scene, state, gradients, time, .. } = fields;
        let model = scene.model;
        let (damping, origin) = (model.damping_rate(*time), model.domain.torque_origin());
        let law = model.law.lanes::<L>();
        for (k, rates) in rates.iter_mut().enumerate() {
            let i = first + k;
            let own = fields.own::<L, T>(i);
            let (sums, nearest) = fields.fluid_sums::<L, T>(&law, i, &own);
            let (sums, rho) = (sums.total(), scene.fluid[i].density());
            let by_fluid = sums.stress_divergence / -rho;
            // Most particles are far from walls.
            let (mut walls, mut by_walls) = (PairTotals::default(), Vector::zeros());
            if !scene.lists.walls.of(i).is_empty() {
                walls = fields.wall_sums::<L, T>(&law, i, &own, None).total();
                by_walls = walls.stress_divergence / -rho + fields.wall_repulsion(i, None);
            }
            let body = body_force.acceleration(&state.position[i]);
            let mut control = Control::default();
            if let (true, Some(order)) = (T::FOUND, &model.order) {
                let nearest = nearest.to_array().into_iter().fold(f64::INFINITY, f64::min);
                let local = &gradients.order[i];
                control = shifting::control::<L, G>(order, scene, i, &gradients.shown, nearest, local);
            }
            *rates = Rates {
                acceleration: by_fluid + by_walls + body - scene.fluid[i].velocity() * damping
                    + control.acceleration,
                shift: control.shift,
                density: rho * (sums.continuity + walls.continuity)
                    + model.diffusion * (sums.diffusion + walls.diffusion),
            };
            let (m, arm) = (state.mass[i], state.position[i] - origin);
            *outer += OuterForces {
                body: Wrench::at(&arm, body * m),
                walls: Wrench::at(&arm, by_walls * m),
                stabilisers: Wrench::at(&arm, control.acceleration * m),
                own_torque: cross(&arm, &(by_fluid * m)),
            };
        }
    }
}
