//! Walls: constants and prescribed motion.

use std::sync::Arc;

use sph::neighbours::CellGrid;
use sph::prescribed::motion::{MotionState, RigidMotion};
use sph::setup::{WallCondition, WallParticles, WallSetup};
use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};

sph::constants! {
    const IN_FRONT_WIDTH: f64 = 0.6, "walls.in_front_width",
        "largest tangential distance of a wall particle that stands in front of another, in spacings [-]";
    const IN_FRONT_RADIUS: f64 = 2.0, "walls.in_front_radius",
        "distance within which such particles are sought, in spacings [-]";
    const LOWEST_IN_FRONT: f64 = 0.5, "walls.in_front_lowest",
        "least height over a wall particle, along its normal, at which another stands in front of it, in spacings [-]";
    const HIGHEST_IN_FRONT: f64 = 1.5, "walls.in_front_highest", "largest such height, in spacings [-]";
    const SEAM_RADIUS: f64 = 2.5, "walls.seam_radius",
        "distance within which the faces around a wall particle count, in spacings [-]";
    /// Deep in the edge of a box a twentieth of the normals nearby are those of the farther face. A round face counts as one
    /// from a radius of seven spacings on.
    const SEAM_SHARE: f64 = 0.02, "walls.seam_share",
        "share of the normals around a wall particle from which on the wall does not continue their way [-]";
}

/// Length below which a sum of unit normals has no direction \[-\].
const NO_DIRECTION: f64 = 1e-6;

/// Constants of the walls.
#[derive(Clone, Debug)]
pub struct WallModel<S: Space> {
    /// Name of each wall.
    pub names: Vec<String>,
    /// Wall of each particle.
    pub wall: Vec<u32>,
    /// Mass of a wall particle, ρ₀ times the volume of its cell \[kg\], in the plane per depth.
    pub mass: f64,
    /// Unit normal into the fluid, used to detect wall crossings; zero where there is none.
    pub face_normal: Arc<Vec<S::Vector>>,
    /// Whether a particle lies at the face, with no other wall particle in front of it.
    pub first_layer: Vec<bool>,
    /// Particles where several faces meet, in order, with the unit vector along which all of them continue, zero where none
    /// is.
    seams: Vec<(u32, S::Vector)>,
    /// Where each is before it moves \[m\]; inside the box where its wall does not.
    start: Arc<Vec<S::Vector>>,
    /// Unit normal of the mirror in Eq. (27); zero where all components are reversed.
    mirror_normal: Arc<Vec<S::Vector>>,
    motion: Vec<Option<RigidMotion<S>>>,
    release_time: Vec<Option<f64>>,
}

impl<S: Space> WallModel<S> {
    /// The walls of a set-up whose indices are in range; `mass` of a particle \[kg\], in the plane per depth.
    ///
    /// # Errors
    /// All expressions of motions that are wrong.
    pub fn new(
        walls: &[WallSetup<S>],
        particles: &WallParticles<S>,
        mass: f64,
        particle_spacing: f64,
        support_radius: f64,
        domain: &Domain<S>,
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
        let mirror_normal: Vec<_> = (0..particles.position.len())
            .map(|w| if slips(w) { particles.normal[w] } else { S::Vector::zeros() })
            .collect();
        let start = |(x, wall): (&S::Vector, &u32)| {
            if motion[*wall as usize].is_some() { *x } else { domain.wrapped(x) }
        };
        let mut model = Self {
            names: walls.iter().map(|wall| wall.name.clone()).collect(),
            wall: particles.wall.clone(),
            mass,
            first_layer: Vec::new(),
            face_normal: Arc::default(),
            seams: Vec::new(),
            start: Arc::new(particles.position.iter().zip(&particles.wall).map(start).collect()),
            mirror_normal: Arc::new(mirror_normal),
            motion,
            release_time: walls.iter().map(|wall| wall.release_time).collect(),
        };
        model.face_normal = Arc::new(model.face_normals(&particles.normal, support_radius, domain));
        model.first_layer = model.first_layers(particle_spacing, domain);
        model.seams = model.find_seams(&particles.normal, particle_spacing, domain);
        Ok(model)
    }

    /// Number of wall particles.
    pub fn len(&self) -> usize {
        self.wall.len()
    }

    /// Whether any wall has a prescribed motion.
    pub fn moves(&self) -> bool {
        self.motion.iter().any(Option::is_some)
    }

    /// Whether all walls act at their places throughout.
    pub fn stand(&self) -> bool {
        !self.moves() && self.release_time.iter().all(Option::is_none)
    }

    /// Whether wall `wall` (index) acts at `time` \[s\].
    pub fn acts(&self, wall: u32, time: f64) -> bool {
        self.release_time[wall as usize].is_none_or(|release| time < release)
    }

    /// Motion of each wall at `time` \[s\], `None` for a wall at rest; nothing where no wall moves.
    pub fn motions_at(&self, time: f64) -> Vec<Option<MotionState<S>>> {
        if !self.moves() {
            return Vec::new();
        }
        self.motion.iter().map(|motion| motion.as_ref().map(|m| m.at(time))).collect()
    }

    /// The part of `direction` along which the wall continues around particle `w`, while the walls are as `motions` say and
    /// its face normal is `normal`.
    pub fn along(
        &self,
        w: usize,
        normal: &S::Vector,
        motions: &[Option<MotionState<S>>],
        direction: &S::Vector,
    ) -> S::Vector {
        let Ok(k) = self.seams.binary_search_by_key(&(w as u32), |seam| seam.0) else {
            return *direction - *normal * direction.dot(normal);
        };
        let seam = self.seams[k].1;
        let along = match motions.get(self.wall[w] as usize) {
            Some(Some(motion)) => motion.rotate(&seam),
            _ => seam,
        };
        along * direction.dot(&along)
    }

    /// Position \[m\] and face normal of particle `w` while the walls are as `motions` say.
    pub fn placed(&self, w: usize, motions: &[Option<MotionState<S>>]) -> (S::Vector, S::Vector) {
        match motions.get(self.wall[w] as usize) {
            None | Some(None) => (self.start[w], self.face_normal[w]),
            Some(Some(motion)) => (motion.position(&self.start[w]), motion.rotate(&self.face_normal[w])),
        }
    }

    /// The normals `given`; where faces meet, the mean direction of those nearby on the same wall.
    fn face_normals(&self, given: &[S::Vector], support_radius: f64, domain: &Domain<S>) -> Vec<S::Vector> {
        let Self { wall, start, .. } = self;
        let mut normals = given.to_vec();
        let at_corners: Vec<usize> = (0..wall.len()).filter(|w| given[*w].norm_squared() == 0.0).collect();
        let corners: Vec<S::Vector> = at_corners.iter().map(|w| start[*w]).collect();
        // A little farther, so that round-off decides nothing here.
        let radius = support_radius * (1.0 + 1e-9);
        let list = CellGrid::new(domain, start, radius).list(domain, &corners, start, radius);
        for (k, &w) in at_corners.iter().enumerate() {
            let mut nearby = list.of(k).to_vec();
            // In the order of the particles: the sum does not depend on that of the cells.
            nearby.sort_unstable();
            let near = |v: &usize| {
                wall[*v] == wall[w] && domain.separation(&start[w], &start[*v]).norm() < support_radius
            };
            normals[w] = nearby.iter().map(|v| *v as usize).filter(near).map(|v| given[v]).sum();
        }
        let unit = |normal: S::Vector| normal.try_normalize(NO_DIRECTION).unwrap_or_else(S::Vector::zeros);
        normals.into_iter().map(unit).collect()
    }

    /// Where faces of the normals `given` meet, and along what, zero where along nothing.
    fn find_seams(&self, given: &[S::Vector], spacing: f64, domain: &Domain<S>) -> Vec<(u32, S::Vector)> {
        let start = &self.start;
        let radius = SEAM_RADIUS * spacing;
        let list = CellGrid::new(domain, start, radius).list_among(domain, start, radius);
        let seam = |w: usize| {
            let mut nearby = list.of(w).to_vec();
            // In the order of the particles: the sum does not depend on that of the cells.
            nearby.sort_unstable();
            let normals = nearby.iter().map(|v| given[*v as usize]).filter(|n| n.norm_squared() > 0.0);
            let (count, sum) = normals.fold((0.0, S::Tensor::zeros()), |(count, sum), n| {
                (count + 1.0, sum + S::Tensor::outer(&n, &n))
            });
            let shares = S::SymmetricTensor::of(&(sum / f64::max(count, 1.0)));
            let free = shares.map_principal(|share| if share < SEAM_SHARE { 1.0 } else { 0.0 });
            let directions = free.full().trace().round();
            if directions >= S::DIMENSIONS as f64 - 1.0 {
                return None;
            }
            Some((w as u32, if directions > 0.0 { free.major_direction() } else { S::Vector::zeros() }))
        };
        (0..start.len()).filter_map(seam).collect()
    }

    /// Whether no wall particle stands in front of each one.
    fn first_layers(&self, particle_spacing: f64, domain: &Domain<S>) -> Vec<bool> {
        let Self { start, face_normal, .. } = self;
        let radius = IN_FRONT_RADIUS * particle_spacing;
        let list = CellGrid::new(domain, start, radius).list_among(domain, start, radius);
        let stands_before = |w: usize, v: usize| {
            let d = domain.separation(&start[v], &start[w]) / particle_spacing;
            let height = d.dot(&face_normal[w]);
            (LOWEST_IN_FRONT..HIGHEST_IN_FRONT).contains(&height)
                && (d - face_normal[w] * height).norm() < IN_FRONT_WIDTH
        };
        let is_first = |w: usize| {
            face_normal[w].norm_squared() > 0.0 && !list.of(w).iter().any(|v| stands_before(w, *v as usize))
        };
        (0..start.len()).map(is_first).collect()
    }
}

/// Kinematics of the wall particles at one time. Where no wall moves it shares the arrays of the [`WallModel`].
#[derive(Clone, Debug, Default)]
pub struct WallField<S: Space> {
    /// Position \[m\].
    pub position: Arc<Vec<S::Vector>>,
    /// Velocity and acceleration \[m/s, m/s²\]; empty where no wall moves.
    motion: Vec<[S::Vector; 2]>,
    /// Normal of the mirror in Eq. (27), zero where all components are reversed.
    pub mirror_normal: Arc<Vec<S::Vector>>,
    /// Unit normal of the face into the fluid.
    pub face_normal: Arc<Vec<S::Vector>>,
}

impl<S: Space> WallField<S> {
    /// Places the walls as they are at `time` \[s\].
    pub fn place(&mut self, walls: &WallModel<S>, domain: &Domain<S>, time: f64) {
        place(&mut self.position, walls, domain, time);
        if self.face_normal.len() != walls.len() {
            self.mirror_normal = Arc::clone(&walls.mirror_normal);
            self.face_normal = Arc::clone(&walls.face_normal);
        }
        if !walls.moves() {
            return;
        }
        self.motion.resize(walls.len(), [S::Vector::zeros(); 2]);
        let [mirror_normal, face_normal] =
            [&mut self.mirror_normal, &mut self.face_normal].map(Arc::make_mut);
        let motions = walls.motions_at(time);
        for w in 0..walls.len() {
            if let Some(motion) = &motions[walls.wall[w] as usize] {
                let start = &walls.start[w];
                self.motion[w] = [motion.velocity(start), motion.acceleration(start)];
                mirror_normal[w] = motion.rotate(&walls.mirror_normal[w]);
                face_normal[w] = motion.rotate(&walls.face_normal[w]);
            }
        }
    }

    /// Velocity of particle `w` \[m/s\].
    pub fn velocity(&self, w: usize) -> S::Vector {
        self.motion.get(w).map_or_else(S::Vector::zeros, |motion| motion[0])
    }

    /// Acceleration of particle `w` \[m/s²\].
    pub fn acceleration(&self, w: usize) -> S::Vector {
        self.motion.get(w).map_or_else(S::Vector::zeros, |motion| motion[1])
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        let own = [&self.position, &self.mirror_normal, &self.face_normal];
        own.into_iter().map(bytes_of_own::<S>).sum::<usize>()
            + size_of::<[S::Vector; 2]>() * self.motion.capacity()
    }
}

/// Moves the `position` \[m\] of each wall particle to where it is at `time` \[s\].
pub fn place<S: Space>(
    position: &mut Arc<Vec<S::Vector>>,
    walls: &WallModel<S>,
    domain: &Domain<S>,
    time: f64,
) {
    if position.len() != walls.len() {
        *position = Arc::clone(&walls.start);
    }
    if !walls.moves() {
        return;
    }
    let motions = walls.motions_at(time);
    for (w, position) in Arc::make_mut(position).iter_mut().enumerate() {
        if let Some(motion) = &motions[walls.wall[w] as usize] {
            *position = domain.wrapped(&motion.position(&walls.start[w]));
        }
    }
}

/// Bytes in use for `vectors`, unless they are shared.
pub fn bytes_of_own<S: Space>(vectors: &Arc<Vec<S::Vector>>) -> usize {
    if Arc::strong_count(vectors) > 1 { 0 } else { size_of::<S::Vector>() * vectors.capacity() }
}
