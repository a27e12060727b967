//! Pressure of the water in gaps that are too thin for its particles.

mod pressure;

use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::prescribed::body_force::BodyForceAt;
use sph::setup::Coupling;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::tasks::for_each;

use crate::boundary::walls::WallState;
pub(crate) use crate::contact::film::pressure::CONSTANTS;
use crate::contact::film::pressure::FilmPressure;
use crate::interface::solid_interface::FluidPairs;
use crate::neighbours::lists::{PairLists, TASK};
use crate::particles::constants::ParticleConstants;
use crate::particles::variables::Particles;
use crate::space::SolidSpace;

/// Force of the water in gaps on one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmForce<S: SolidSpace> {
    /// Toward other bodies, or distant parts of its own \[N/m\].
    pub bodies: S::Vector,
    /// Toward walls \[N/m\].
    pub walls: S::Vector,
    /// Power of the force toward walls by the motion of these, Σ f·v_w \[W/m\].
    pub wall_power: f64,
}

/// A particle with another body or a wall within the support of the fluid's kernel.
#[derive(Clone, Copy, Debug, Default)]
struct Node<S: SolidSpace> {
    particle: u32,
    /// V \[m²\].
    volume: f64,
    /// Unit vector toward what it faces.
    toward: S::Vector,
    /// Factor g of its pairs, for the part of the gap that is empty \[-\].
    gain: f64,
    /// Weight of the water within the support, Σ V_f W \[-\].
    wet: f64,
    /// Mean pressure of that water at the particle \[Pa\].
    water_pressure: f64,
    /// Weight of the air beside it \[-\].
    air: f64,
    /// Acceleration by body forces \[m/s²\].
    acceleration: S::Vector,
}

/// Water between the faces of bodies, and of bodies and walls.
///
/// Where a face has another within the support of the fluid's kernel, its sums lack what lies behind the other. Pairs of
/// solid particles then act as pairs of fluid and wall do, at the pressure p of the water between them:
///
/// ```text
/// f_ij = −V_i V_j (g_i p_i + g_j p_j) ∇W/M,   p_w = p_i − ρ₀ b·x_iw for a particle w of a wall
/// ```
/// b is the body acceleration. With water in the gap, the pairs complete the sums, g = 1. In a gap too thin for particles of
/// water g makes up for what the sums of the particle's own body, the faces and the water lack along the gap. The pressure
/// follows from the water around; see [`FilmPressure`].
#[derive(Debug)]
pub struct Film<S: SolidSpace> {
    kernel: CubicSpline<S>,
    /// 1/M.
    gradient_scale: f64,
    rest_density: f64,
    /// Spacing of the fluid \[m\].
    spacing: f64,
    wall_volume: f64,
    /// |Σ V ∇W| \[1/m\] over half-spaces whose outer rows are 1, 1 + 1/[`STEPS`], … spacings away, down to zero.
    slopes: Vec<f64>,
    /// Σ V W over the same half-space \[-\].
    face_weight: f64,
    grid: CellGrid<S>,
    candidates: Vec<u32>,
    /// Interface state of each particle; `NONE` for those without.
    state_of: Vec<u32>,
    nodes: Vec<Node<S>>,
    /// Node of each particle; `NONE` for those without.
    node_of: Vec<u32>,
    pressure: FilmPressure,
    node_forces: Vec<FilmForce<S>>,
    /// Forces on all particles.
    pub forces: Vec<FilmForce<S>>,
}

/// Steps per spacing of the table of distances.
const STEPS: u32 = 16;

/// No index.
const NONE: u32 = u32::MAX;

/// The state at which the film is evaluated.
#[derive(Clone, Copy)]
pub struct FilmStage<'a, S: SolidSpace> {
    pub domain: &'a Domain<S>,
    pub constants: &'a ParticleConstants<S>,
    pub body_force: BodyForceAt<'a, S>,
    pub stage: &'a Particles<S>,
    pub lists: &'a PairLists,
    pub walls: &'a WallState<S>,
    pub pairs: FluidPairs<'a, S>,
    /// [`Film::self_distance`].
    pub self_distance: f64,
}

impl<S: SolidSpace> FilmStage<'_, S> {
    fn volume(&self, i: usize) -> f64 {
        self.constants.mass[i] / self.stage.density[i]
    }

    /// Whether `j` is of another body than `i`, or of a part of the same that is not beside it when undeformed.
    fn is_apart(&self, i: usize, j: usize) -> bool {
        let (body, reference) = (&self.constants.body, &self.constants.reference_position);
        body[i] != body[j] || self.domain.separation(&reference[i], &reference[j]).norm() > self.self_distance
    }

    /// Whether `i` can face `j`: distant parts of its own body count as another where bodies touch themselves.
    fn can_face(&self, i: usize, j: usize) -> bool {
        self.is_apart(i, j) && self.lists.bodies.of(i).binary_search(&(j as u32)).is_ok()
    }

    /// Particles that `i` can face, with the separations x_ij.
    fn bodies_near(&self, i: usize) -> impl Iterator<Item = (usize, S::Vector)> + '_ {
        let position = &self.stage.position;
        let separation = move |j: usize| (j, self.domain.separation(&position[i], &position[j]));
        let listed = self.lists.bodies.of(i).iter().map(|j| *j as usize);
        listed.filter(move |j| self.is_apart(i, *j)).map(separation)
    }

    /// Wall particles that `i` can face, with the separations x_iw.
    fn walls_near(&self, i: usize) -> impl Iterator<Item = (usize, S::Vector)> + '_ {
        let (position, walls) = (&self.stage.position[i], &self.walls.position);
        let separation = move |w: usize| (w, self.domain.separation(position, &walls[w]));
        self.lists.walls.of(i).iter().map(move |w| separation(*w as usize))
    }
}

impl<S: SolidSpace> Film<S> {
    /// The film between `particles` particles, and walls whose particles are `wall_spacing` \[m\] apart, in the fluid of
    /// `coupling`.
    pub fn new(coupling: &Coupling, wall_spacing: f64, particles: usize) -> Self {
        let spacing = coupling.fluid.particle_spacing;
        let kernel = CubicSpline::<S>::new(coupling.fluid.smoothing_length());
        let slope = |k: u32| {
            let (height, step) = (1.0 + f64::from(k) / f64::from(STEPS), 0.01);
            let filled = |height: f64| kernel.half_space_sum(spacing, height * spacing);
            (filled(height - step) - filled(height + step)) / (2.0 * step * spacing)
        };
        Self {
            kernel,
            gradient_scale: coupling.fluid.pair_gradient_scale::<S>(),
            rest_density: coupling.fluid.rest_density,
            spacing,
            wall_volume: S::cell_volume(wall_spacing),
            slopes: (0..).map(slope).take_while(|slope| *slope > 0.0).collect(),
            face_weight: kernel.half_space_sum(spacing, spacing),
            grid: CellGrid::default(),
            candidates: Vec::new(),
            state_of: Vec::new(),
            nodes: Vec::new(),
            node_of: Vec::new(),
            pressure: FilmPressure::default(),
            node_forces: Vec::new(),
            forces: vec![FilmForce::default(); particles],
        }
    }

    /// Undeformed distance from which parts of one body face each other \[m\].
    pub fn self_distance(&self) -> f64 {
        S::SELF_CONTACT_DISTANCE * self.reach()
    }

    /// Distance within which faces interact \[m\].
    pub fn reach(&self) -> f64 {
        self.kernel.support_radius()
    }

    /// Indices of the particles that face another body or a wall, with the forces on them; on all others there is none.
    pub fn forces_in_gaps(&self) -> impl Iterator<Item = (usize, &FilmForce<S>)> {
        self.nodes.iter().map(|node| node.particle as usize).map(|i| (i, &self.forces[i]))
    }

    /// Forces on all particles.
    pub fn evaluate(&mut self, at: &FilmStage<'_, S>) {
        for node in &self.nodes {
            self.forces[node.particle as usize] = FilmForce::default();
        }
        self.nodes.clear();
        self.find_candidates(at);
        if self.candidates.is_empty() {
            return;
        }
        self.grid.renew(at.domain, &at.stage.position, self.reach());
        self.state_of.clear();
        self.state_of.resize(at.constants.len(), NONE);
        for (state, i) in (0u32..).zip(at.pairs.sent) {
            self.state_of[*i as usize] = state;
        }
        let mut nodes = std::mem::take(&mut self.nodes);
        nodes.clear();
        nodes.resize(self.candidates.len(), Node::default());
        for_each(&mut nodes[..], TASK, |k, node| *node = self.node(at, self.candidates[k] as usize));
        self.nodes = nodes;
        self.node_of.clear();
        self.node_of.resize(at.constants.len(), NONE);
        for (k, node) in (0u32..).zip(&self.nodes) {
            self.node_of[node.particle as usize] = k;
        }
        self.update_pressure(at);
        let mut forces = std::mem::take(&mut self.node_forces);
        forces.clear();
        forces.resize(self.nodes.len(), FilmForce::default());
        for_each(&mut forces[..], TASK, |k, force| *force = self.force(at, k));
        for (node, force) in self.nodes.iter().zip(&forces) {
            self.forces[node.particle as usize] = *force;
        }
        self.node_forces = forces;
    }

    /// Particles with another body or a wall within reach, ascending.
    fn find_candidates(&mut self, at: &FilmStage<'_, S>) {
        let Self { candidates, kernel, .. } = self;
        let near = |x: S::Vector| x.norm() < kernel.support_radius();
        let faces =
            |i: usize| at.bodies_near(i).any(|(_, x)| near(x)) || at.walls_near(i).any(|(_, x)| near(x));
        let particles = at.lists.active.iter().take_while(|i| (**i as usize) < at.constants.len());
        candidates.clear();
        candidates.extend(particles.filter(|i| faces(**i as usize)));
    }

    fn node(&self, at: &FilmStage<'_, S>, i: usize) -> Node<S> {
        let reach = self.reach();
        let gradient = |x: S::Vector, volume: f64| x * (volume * self.kernel.gradient_factor(x.norm()));
        let near = |x: &S::Vector| x.norm() < reach;
        let mut facing = S::Vector::zeros();
        for (j, x) in at.bodies_near(i).filter(|(_, x)| near(x)) {
            facing += gradient(x, at.volume(j));
        }
        for (_, x) in at.walls_near(i).filter(|(_, x)| near(x)) {
            facing += gradient(x, self.wall_volume);
        }
        let (position, body) = (at.stage.position[i], at.constants.body[i]);
        let mut own = S::Vector::zeros();
        self.each_near(at, &position, |j, x| {
            if j != i && at.constants.body[j] == body && !at.can_face(i, j) {
                own += gradient(x, at.volume(j));
            }
        });
        let mut filled = own + facing;
        let toward = facing / facing.norm().max(f64::MIN_POSITIVE);
        let acceleration = at.body_force.acceleration(&position);
        let (mut wet, mut weighted) = (0.0, 0.0);
        if self.state_of[i] != NONE {
            for (f, _) in at.pairs.interface.fluids_near(self.state_of[i] as usize) {
                let x = at.domain.separation(&position, &at.pairs.fluid.position[f]);
                let volume = at.pairs.fluid.volume(f);
                filled += gradient(x, volume);
                let weight = self.on_side(&toward, &x) * volume * self.kernel.value(x.norm());
                wet += weight;
                weighted +=
                    weight * (at.pairs.fluid.pressure[f] + at.pairs.fluid.density[f] * acceleration.dot(&x));
            }
        }
        let missing_ahead = -filled.dot(&toward);
        let missing_beside = (filled + toward * missing_ahead).norm() / self.slopes[0];
        // Without water the sums end at the other face: the gap is the difference of the distances at which they do.
        let (faced, needed) = (facing.norm(), -own.dot(&toward));
        let gap = self.distance(faced) - self.distance(needed);
        let empty = missing_ahead.max(0.0) / faced.max(f64::MIN_POSITIVE);
        Node {
            particle: i as u32,
            volume: at.volume(i),
            toward,
            gain: 1.0 + empty * ramp(gap, S::OPEN_GAP, S::THIN_GAP),
            wet,
            water_pressure: if wet > 0.0 { weighted / wet } else { 0.0 },
            air: ramp(missing_beside, S::OPEN_SIDE, S::AIR_SIDE),
            acceleration,
        }
    }

    /// Distance, in spacings of the fluid, of the outer row of a half-space whose sum |Σ V ∇W| is `slope` \[1/m\]; at least 1.
    fn distance(&self, slope: f64) -> f64 {
        let k = self.slopes.partition_point(|of_step| *of_step > slope);
        let after = self.slopes.get(k).copied().unwrap_or(0.0);
        let part = k
            .checked_sub(1)
            .map_or(0.0, |before| (self.slopes[before] - slope) / (self.slopes[before] - after) - 1.0);
        1.0 + (k as f64 + part) / f64::from(STEPS)
    }

    /// Share of the water at −`x` \[m\] from a particle that lies on the side of the gap \[-\]: not behind a thin body.
    fn on_side(&self, toward: &S::Vector, x: &S::Vector) -> f64 {
        ramp(-x.dot(toward) / self.spacing, S::BEHIND, S::BESIDE)
    }

    /// Calls `take` with each particle of all bodies within reach of `position` \[m\], and the separation from it.
    fn each_near(&self, at: &FilmStage<'_, S>, position: &S::Vector, mut take: impl FnMut(usize, S::Vector)) {
        let cell = self.grid.cell(&at.domain.wrapped(position));
        for j in self.grid.ranges(cell).iter().cloned().flatten().map(|k| self.grid.order()[k] as usize) {
            let x = at.domain.separation(position, &at.stage.position[j]);
            if x.norm() < self.reach() {
                take(j, x);
            }
        }
    }

    fn force(&self, at: &FilmStage<'_, S>, k: usize) -> FilmForce<S> {
        let node = &self.nodes[k];
        let mut force = FilmForce::default();
        let (i, reach) = (node.particle as usize, self.reach());
        let pair = |x: S::Vector, volume: f64, pressures: f64| {
            let factor = self.gradient_scale * self.kernel.gradient_factor(x.norm());
            x * (-node.volume * volume * pressures * factor)
        };
        let loaded = |k: usize| self.nodes[k].gain * self.pressure.of(k).unwrap_or(0.0);
        for (j, x) in at.bodies_near(i).filter(|(_, x)| x.norm() < reach) {
            // The last bit of a distance may depend on the side from which it is seen.
            if let Some(other) = self.nodes.get(self.node_of[j] as usize) {
                force.bodies += pair(x, other.volume, loaded(k) + loaded(self.node_of[j] as usize));
            }
        }
        let Some(pressure) = self.pressure.of(k) else { return force };
        for (w, x) in at.walls_near(i).filter(|(_, x)| x.norm() < reach) {
            let head = self.rest_density * node.acceleration.dot(&x);
            let of_wall = pair(x, self.wall_volume, node.gain * (2.0 * pressure - head));
            force.walls += of_wall;
            force.wall_power += of_wall.dot(&at.walls.velocity[w]);
        }
        force
    }
}

/// 0 up to `start`, 1 from `end` on, linear between.
fn ramp(x: f64, start: f64, end: f64) -> f64 {
    ((x - start) / (end - start)).clamp(0.0, 1.0)
}
