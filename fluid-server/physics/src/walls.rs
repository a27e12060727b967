//! Walls: prescribed motion, and the state that wall particles show to the fluid, Eq. (27)-(28).

use rayon::prelude::*;
use sph::domain::Domain;
use sph::geometry::Geometry;
use sph::motion::{MotionState, RigidMotion};
use sph::neighbours::CellGrid;
use sph::setup::{WallCondition, WallParticles, WallSetup};
use sph::vector::Vector;

use super::lists::Lists;
use super::model::FluidModel;
use super::record::Record;

/// Wall particles per task.
const TASK: usize = 64;

/// What is known of the walls before the run.
#[derive(Clone, Debug)]
pub struct WallModel {
    /// Name of each wall.
    pub names: Vec<String>,
    /// Wall of each particle.
    pub wall: Vec<u32>,
    /// Mass per depth of a wall particle, ρ₀Δx² \[kg/m\].
    pub mass: f64,
    /// Unit normal into the fluid by which crossings are told; zero where there is none.
    pub face_normal: Vec<Vector>,
    /// Whether a particle lies at the face, with no other wall particle in front of it.
    pub first_layer: Vec<bool>,
    start: Vec<Vector>,
    /// Unit normal of the mirror in Eq. (27); zero where both components are reversed.
    mirror_normal: Vec<Vector>,
    motion: Vec<Option<RigidMotion>>,
    release_time: Vec<Option<f64>>,
}

impl WallModel {
    /// The walls of a set-up whose indices are in range; `mass` per depth of a particle \[kg/m\].
    ///
    /// # Errors
    /// All expressions of motions that are wrong.
    pub fn new(
        walls: &[WallSetup],
        particles: &WallParticles,
        mass: f64,
        particle_spacing: f64,
        support_radius: f64,
        domain: &Domain,
    ) -> Result<Self, Vec<String>> {
        let mut errors = Vec::new();
        let mut motion = Vec::with_capacity(walls.len());
        for wall in walls {
            match wall.motion.as_ref().map(RigidMotion::new).transpose() {
                Ok(parsed) => motion.push(parsed),
                Err(error) => errors.push(format!("motion of wall `{}`: {error}", wall.name)),
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        let slips = |w: usize| walls[particles.wall[w] as usize].condition == WallCondition::Slip;
        let mirror_normal = (0..particles.position.len())
            .map(|w| if slips(w) { particles.normal[w] } else { Vector::zeros() })
            .collect();
        let face_normal = face_normals(particles, support_radius, domain);
        Ok(Self {
            names: walls.iter().map(|wall| wall.name.clone()).collect(),
            wall: particles.wall.clone(),
            mass,
            first_layer: first_layers(particles, &face_normal, particle_spacing, domain),
            face_normal,
            start: particles.position.clone(),
            mirror_normal,
            motion,
            release_time: walls.iter().map(|wall| wall.release_time).collect(),
        })
    }

    /// Number of wall particles.
    pub fn len(&self) -> usize {
        self.wall.len()
    }

    /// Whether any wall has a prescribed motion.
    pub fn moves(&self) -> bool {
        self.motion.iter().any(Option::is_some)
    }

    /// Whether wall `wall` (index) acts at `time` \[s\].
    pub fn acts(&self, wall: u32, time: f64) -> bool {
        self.release_time[wall as usize].is_none_or(|release| time < release)
    }

    /// Motion of each wall at `time` \[s\], `None` for a wall at rest; nothing where no wall moves.
    pub fn motions_at(&self, time: f64) -> Vec<Option<MotionState>> {
        if !self.moves() {
            return Vec::new();
        }
        self.motion.iter().map(|motion| motion.as_ref().map(|m| m.at(time))).collect()
    }

    /// Position \[m\] and face normal of particle `w` while the walls are as `motions` say.
    pub fn placed(&self, w: usize, motions: &[Option<MotionState>]) -> (Vector, Vector) {
        match motions.get(self.wall[w] as usize) {
            None | Some(None) => (self.start[w], self.face_normal[w]),
            Some(Some(motion)) => (motion.position(&self.start[w]), motion.rotate(&self.face_normal[w])),
        }
    }
}

/// Given normals, and where faces meet the mean direction of the normals of the same wall nearby.
fn face_normals(particles: &WallParticles, support_radius: f64, domain: &Domain) -> Vec<Vector> {
    let mean_nearby = |w: usize| -> Vector {
        let near = |v: &usize| {
            particles.wall[*v] == particles.wall[w]
                && domain.separation(&particles.position[w], &particles.position[*v]).norm() < support_radius
        };
        (0..particles.wall.len()).filter(near).map(|v| particles.normal[v]).sum()
    };
    let given = |w: usize| {
        let normal = particles.normal[w];
        if normal.norm_squared() > 0.0 { normal } else { mean_nearby(w) }
    };
    (0..particles.wall.len()).map(|w| given(w).try_normalize(1e-6).unwrap_or_else(Vector::zeros)).collect()
}

/// Whether no wall particle stands in front of each one, between half and one and a half spacings along its normal.
fn first_layers(
    particles: &WallParticles,
    face_normal: &[Vector],
    particle_spacing: f64,
    domain: &Domain,
) -> Vec<bool> {
    let positions = &particles.position;
    let radius = 2.0 * particle_spacing;
    let list = CellGrid::new(domain, positions, radius).list(domain, positions, positions, radius, true);
    let stands_before = |w: usize, v: usize| {
        let d = domain.separation(&positions[v], &positions[w]) / particle_spacing;
        let height = d.dot(&face_normal[w]);
        (0.5..1.5).contains(&height) && (d - face_normal[w] * height).norm() < 0.6
    };
    let is_first = |w: usize| {
        face_normal[w].norm_squared() > 0.0 && !list.of(w).iter().any(|v| stands_before(w, *v as usize))
    };
    (0..positions.len()).map(is_first).collect()
}

/// Kinematics of the wall particles at one time.
#[derive(Clone, Debug, Default)]
pub struct WallField {
    /// Position \[m\].
    pub position: Vec<Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector>,
    /// Acceleration \[m/s²\].
    acceleration: Vec<Vector>,
    /// Normal of the mirror in Eq. (27), zero where both components are reversed.
    pub mirror_normal: Vec<Vector>,
    /// Unit normal of the face into the fluid.
    pub face_normal: Vec<Vector>,
}

impl WallField {
    /// Places the walls as they are at `time` \[s\].
    pub fn place(&mut self, walls: &WallModel, domain: &Domain, time: f64) {
        if self.position.len() != walls.len() {
            self.position = walls.start.iter().map(|x| domain.wrapped(x)).collect();
            self.velocity = vec![Vector::zeros(); walls.len()];
            self.acceleration = vec![Vector::zeros(); walls.len()];
            self.mirror_normal.clone_from(&walls.mirror_normal);
            self.face_normal.clone_from(&walls.face_normal);
        }
        if !walls.moves() {
            return;
        }
        let motions = walls.motions_at(time);
        for w in 0..walls.len() {
            if let Some(motion) = &motions[walls.wall[w] as usize] {
                let start = &walls.start[w];
                self.position[w] = domain.wrapped(&motion.position(start));
                self.velocity[w] = motion.velocity(start);
                self.acceleration[w] = motion.acceleration(start);
                self.mirror_normal[w] = motion.rotate(&walls.mirror_normal[w]);
                self.face_normal[w] = motion.rotate(&walls.face_normal[w]);
            }
        }
    }
}

/// The walls as the fluid meets them in one stage.
#[derive(Clone, Debug, Default)]
pub struct WallStates {
    /// Kinematics.
    pub field: WallField,
    /// State of each wall particle, volume zero where it does not act, and one more that never acts.
    pub records: Vec<Record>,
}

impl WallStates {
    /// Fills the state of each wall particle from the fluid around it at `time` \[s\].
    ///
    /// ```text
    /// p_w = Σ [p_j + ρ_j (f − a_w)·(x_w − x_j)] W_wj / Σ W_wj                                Eq. (28)
    /// v_w = v_f − 2 [(v_f − v_wall)·n] n   slip;   2 v_wall − v_f   no slip, corners         Eq. (27)
    /// ρ_w from p_w by the inverse of Eq. (3)
    /// ```
    /// v_f is the Shepard mean of the fluid's velocity, a_w the known acceleration of a moving wall. A particle
    /// without fluid in its support, or of a released wall, does not act. The density follows the pressure down to
    /// the density at which a run stops.
    pub fn extrapolate<G: Geometry>(
        &mut self,
        geometry: G,
        model: &FluidModel,
        lists: &Lists,
        fluid: &[Record],
        time: f64,
    ) {
        let Self { field, records } = self;
        // The last one does not act: it fills batches of neighbours.
        records.resize(model.walls.len() + 1, Record::default());
        let rest_density = model.constants.rest_density;
        let silent = |x: &Vector| Record::new(x, &Vector::zeros(), rest_density, 0.0, 0.0);
        records[model.walls.len()] = silent(&model.domain.lower);
        let body_force = model.body_force.at(time);
        let acting = &mut records[..model.walls.len()];
        acting.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(w, record)| {
            let x = &field.position[w];
            *record = silent(x);
            if !model.walls.acts(model.walls.wall[w], time) {
                return;
            }
            let drive = body_force.acceleration(x) - field.acceleration[w];
            let (mut weight, mut pressure, mut velocity) = (0.0, 0.0, Vector::zeros());
            for j in lists.fluid_of_walls.neighbours(w) {
                let j = &fluid[j];
                let d = geometry.separation(&record.position(), &j.position());
                let kernel = model.kernel.value(d.norm());
                weight += kernel;
                pressure += kernel * (j.pressure() + j.density() * drive.dot(&d));
                velocity += j.velocity() * kernel;
            }
            if weight > 0.0 {
                let velocity = mirrored(&(velocity / weight), &field.velocity[w], &field.mirror_normal[w]);
                let pressure = pressure / weight;
                let density = model.equation_of_state.wall_density(pressure);
                *record = Record::new(x, &velocity, density, pressure, model.walls.mass / density);
            }
        });
    }
}

/// Velocity of a wall particle toward the fluid, Eq. (27): mirrored along `normal`, or wholly where that is zero.
pub fn mirrored(fluid: &Vector, wall: &Vector, normal: &Vector) -> Vector {
    if normal.norm_squared() > 0.0 {
        fluid - normal * (2.0 * (fluid - wall).dot(normal))
    } else {
        2.0 * wall - fluid
    }
}
