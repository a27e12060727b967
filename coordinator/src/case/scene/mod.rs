//! The scene that a case means: all particles at the start, and every check that needs them.

pub(super) mod depth;
mod filling;
mod fluid;
mod lattice;
mod loads;
pub(super) mod obstacles;
pub(super) mod overlap;
mod solid;
mod space;
mod start;
mod thickness;
pub(super) mod wall;

use std::collections::BTreeSet;
use std::ops::Range;

use sph::setup::{FluidParticles, FluidProbe, SolidParticles, SolidProbe, SurfaceLoad, WallParticles};
use sph::space::components::Components;
use sph::space::domain::Domain;
use sph::space::{AXIS_NAMES, AnySpace, Plane, Space, Spatial};

use super::errors::{CaseError, ErrorList, Place};
use super::file::CaseFile;
use super::reader::Choice;
use crate::results::probes;
use lattice::Lattice;
pub use lattice::MOST_PARTICLES;
pub use space::SceneSpace;
pub use start::expression_steps;

/// All particles at the start.
#[derive(Clone, Debug, Default)]
pub struct Scene<S: Space = Plane> {
    /// Fluid.
    pub fluid: FluidParticles<S>,
    /// Walls.
    pub walls: WallParticles<S>,
    /// Solids.
    pub solid: SolidParticles<S>,
    /// Probes of both solvers.
    pub probes: Probes<S>,
    /// Loads on the surface of each body, in the order of the bodies.
    pub loads: Vec<Vec<SurfaceLoad<S>>>,
    /// Particles across the thin side of each body that deforms.
    pub across: Vec<Option<usize>>,
    /// How masses and spacings were adjusted to shapes that do not fit the lattice, in words.
    pub adjusted: Vec<String>,
    /// What was left out where shapes meet, in words.
    pub cuts: Vec<String>,
    /// What deserves a second look, in words.
    pub warnings: Vec<String>,
    /// Bodies whose supports are wrong: what stands where it may not could be meant to be held.
    unsupported: BTreeSet<u32>,
}

/// Probes of both solvers.
#[derive(Clone, Debug, Default)]
pub struct Probes<S: Space = Plane> {
    /// For the fluid solver.
    pub fluid: Vec<FluidProbe<S>>,
    /// For the solid solver.
    pub solid: Vec<SolidProbe<S>>,
}

impl<S: Space> Probes<S> {
    /// Names of the columns of the fluid's and of the solid's probes.
    pub fn columns(&self) -> [Vec<String>; 2] {
        [probes::columns_of(&self.fluid), probes::columns_of(&self.solid)]
    }
}

/// The scene of a case, of the plane or in space.
pub type AnyScene = AnySpace<Scene<Plane>, Scene<Spatial>>;

impl<S: Space> Scene<S> {
    /// Where the particles of body `k` stand among those of all bodies, which follow each other.
    pub fn body_range(&self, k: u32) -> Range<usize> {
        let bodies = &self.solid.body;
        bodies.partition_point(|body| *body < k)..bodies.partition_point(|body| *body <= k)
    }
}

/// How many of `groups` are of each of the first `count`.
pub fn tally(groups: &[u32], count: usize) -> Vec<usize> {
    let mut found = vec![0; count];
    for group in groups {
        if let Some(slot) = found.get_mut(*group as usize) {
            *slot += 1;
        }
    }
    found
}

/// Lays out everything that is written without errors; reports what does not fit together.
pub fn build<S: SceneSpace>(file: &CaseFile, errors: &ErrorList) -> Scene<S> {
    let mut scene = Scene::default();
    if !file.domain.intact || !spacings_fit(file, errors) {
        return scene;
    }
    let domain = file.domain.domain::<S>();
    let mut lattice = Lattice::new(file.domain.lattice_origin_m.to::<S>(), errors);
    if let Some(solid) = file.solid.as_ref().filter(|solid| solid.intact) {
        solid::lay_out(file, solid, &domain, &mut lattice, &mut scene);
    }
    wall::lay_out(file, &domain, &mut lattice, &mut scene);
    // The solid solver looks for walls near each support.
    let supports: usize =
        file.solid.iter().flat_map(|solid| &solid.bodies).map(|body| body.supports.len()).sum();
    errors.spend(&file.domain.lower_m.place, 5.0 * supports as f64 * scene.walls.wall.len() as f64);
    if let Some(fluid) = file.fluid.as_ref().filter(|fluid| fluid.intact) {
        fluid::lay_out(file, fluid, &domain, &mut lattice, &mut scene);
    }
    scene
}

/// Whether periods hold whole numbers of spacings, and enough of them.
fn spacings_fit(file: &CaseFile, errors: &ErrorList) -> bool {
    // Pairs must meet through one image only: twice the support radius and a skin.
    const LEAST_SMOOTHING_LENGTHS: f64 = 5.0;
    let before = errors.count();
    let size = |axis: usize| file.domain.upper_m.value[axis] - file.domain.lower_m.value[axis];
    let fluid = file.fluid.as_ref().filter(|fluid| fluid.lattice_intact());
    let solid = file.solid.as_ref().filter(|solid| solid.intact);
    let lengths = [
        fluid.map(|fluid| ("fluid", fluid.spacing(), fluid.parameters.smoothing_length())),
        solid.map(|solid| ("solid", solid.particle_spacing_m.clone(), solid.smoothing_length())),
    ];
    for (owner, spacing, smoothing_length) in lengths.into_iter().flatten() {
        for choice in &file.domain.periodic {
            let period = size(choice.value);
            let count = (period / spacing.value).round();
            if (period / spacing.value - count).abs() > 1e-6 * count.max(1.0) {
                let problem = format!(
                    "the {owner}'s spacing of {} m does not divide the period of {period} m along {}",
                    spacing.value, choice.word
                );
                let hint = format!("{} m is the nearest that does", period / count.max(1.0));
                errors.add(CaseError::new(&spacing.place, problem).hint(hint));
            } else if period < LEAST_SMOOTHING_LENGTHS * smoothing_length {
                let problem =
                    format!("the period of {period} m along {} is too short for the {owner}", choice.word);
                let least = LEAST_SMOOTHING_LENGTHS * smoothing_length;
                errors
                    .add(CaseError::new(&choice.place, problem).allowed(format!("at least 5 h = {least} m")));
            }
        }
    }
    errors.count() == before
}

/// Index for a particle, body, region or wall; counts are limited far below 2³².
fn index(k: usize) -> u32 {
    u32::try_from(k).unwrap_or(u32::MAX)
}

/// `(x, y) m`, in space `(x, y, z) m`.
pub fn point_text<S: Space>(x: &S::Vector) -> String {
    let row = x.row();
    let is_small = row.as_ref().iter().all(|x| x.abs() < 1e7);
    let text = |x: &f64| if is_small { format!("{x:.6}") } else { format!("{x:e}") };
    let components: Vec<String> = row.as_ref().iter().map(text).collect();
    format!("({}) m", components.join(", "))
}

/// Whether `positions`, a row of `spacing` \[m\] or more, meet themselves through a periodic side; then that is an error.
fn meets_itself<S: Space>(
    shape: &Place,
    what: &str,
    file: &CaseFile,
    positions: &[S::Vector],
    spacing: f64,
    errors: &ErrorList,
) -> bool {
    let domain = file.domain.domain::<S>();
    let beyond = |choice: &&Choice<usize>| {
        let along = || positions.iter().map(|x| x[choice.value]);
        let (low, high) = (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
        high - low > domain.size()[choice.value] - 0.5 * spacing
    };
    let Some(choice) = file.domain.periodic.iter().find(beyond) else { return false };
    let period = domain.size()[choice.value];
    let problem = format!("{what} is wider than the period of {period} m along {}", choice.word);
    errors.add(CaseError::new(shape, problem).hint("end it one spacing before it meets itself"));
    true
}

/// Reports the first of `outside`, the particles of `what` that lie outside the domain.
fn report_outside<'a, S: SceneSpace>(
    error: CaseError,
    what: &str,
    domain: &Domain<S>,
    outside: impl Iterator<Item = &'a S::Vector>,
    errors: &ErrorList,
) {
    let mut outside = outside.filter(|x| !domain.contains(x)).peekable();
    if let Some(first) = outside.peek().copied() {
        let count = outside.count();
        let problem =
            format!("{what} leaves the domain: {count} particles outside, one at {}", point_text::<S>(first));
        let spans = (0..S::DIMENSIONS)
            .map(|k| format!("{} from {} to {}", AXIS_NAMES[k], domain.lower[k], domain.upper[k]))
            .collect::<Vec<String>>();
        errors.add(
            CaseError { problem, ..error }
                .allowed(spans.join(", "))
                .hint("move the shape or enlarge `domain`"),
        );
    }
}
