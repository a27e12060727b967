//! Filling shapes with particles within stated limits on count and work.

use sph::shapes::{Region, fill, lattice_points};
use sph::space::components::Components;

use super::space::SceneSpace;
use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::shape::ShapeTable;
use crate::case::reader::{At, Coordinates};

/// Most particles of a scene, walls included.
pub const MOST_PARTICLES: usize = 5_000_000;

/// Most lattice points in the box around a shape: a slender slanted shape has many more than particles.
const MOST_LATTICE_POINTS: f64 = 4.0 * MOST_PARTICLES as f64;

/// Most lattice points times pieces of one shape: a second of work.
const MOST_WORK: f64 = 1e9;

/// Farthest from the lattice origin, in spacings, that positions stay exact on the lattice.
const FARTHEST: f64 = 1e8;

/// The one lattice of a scene; counts what is laid on it.
pub struct Lattice<'a, S: SceneSpace> {
    /// Corner of the lattice \[m\].
    pub origin: S::Vector,
    /// Where errors go.
    pub errors: &'a ErrorList,
    left: usize,
}

impl<'a, S: SceneSpace> Lattice<'a, S> {
    /// An empty lattice.
    pub fn new(origin: S::Vector, errors: &'a ErrorList) -> Self {
        Self { origin, errors, left: MOST_PARTICLES }
    }

    /// Whether `shape` may be laid out with `spacing` \[m\]; `margin` \[m\] is examined around it.
    pub fn permits(&self, written: &At<ShapeTable>, shape: &S::Shape, spacing: f64, margin: f64) -> bool {
        let (lower, upper) = shape.bounds();
        let farthest =
            |x: S::Vector| (x - self.origin).row().as_ref().iter().fold(0.0, |far: f64, d| far.max(d.abs()));
        let reach = [lower, upper].into_iter().map(farthest).fold(margin, f64::max) / spacing;
        let points = lattice_points(shape, spacing, margin);
        let too_much = if exceeds(points, MOST_LATTICE_POINTS) {
            format!(
                "its box holds {points:.2e} lattice points; at most {MOST_LATTICE_POINTS:.0e} are examined"
            )
        } else if exceeds(points * written.value.pieces() as f64, MOST_WORK) {
            format!(
                "{} corners and parts are too many for {points:.2e} lattice points",
                written.value.pieces()
            )
        } else if exceeds(reach, FARTHEST) {
            format!("lies {reach:.2e} spacings from the lattice origin; at most {FARTHEST:.0e} are allowed")
        } else {
            return self.errors.spend(&written.place, points * (2 + written.value.pieces()) as f64);
        };
        let error = CaseError::new(&written.place, too_much);
        self.errors.add(error.hint(format!("check its size against the particle spacing of {spacing} m")));
        false
    }

    /// Particles of `shape`; none, with an error, when there are too many or none.
    pub fn fill(
        &mut self,
        written: &At<ShapeTable>,
        spacing: f64,
        origin: Option<&At<Coordinates>>,
    ) -> Vec<S::Vector> {
        let shape = S::shape(&written.value);
        if !self.permits(written, &shape, spacing, 0.0) {
            return Vec::new();
        }
        let positions = fill(&shape, spacing, origin.map_or(self.origin, |at| at.value.to::<S>()));
        if positions.is_empty() {
            let error = CaseError::new(&written.place, "holds no particle");
            self.errors.add(error.hint(format!("make it larger than the particle spacing of {spacing} m")));
        }
        if self.take(written, positions.len()) { positions } else { Vec::new() }
    }

    /// Counts `count` particles in; whether the scene may have them.
    pub fn take(&mut self, written: &At<ShapeTable>, count: usize) -> bool {
        let enough = count <= self.left;
        if !enough {
            let problem = "makes the scene too large".to_owned();
            let error = CaseError::new(&written.place, problem);
            self.errors.add(
                error
                    .allowed(format!("at most {MOST_PARTICLES} particles"))
                    .hint("use a larger particle spacing"),
            );
        }
        self.left = self.left.saturating_sub(count);
        enough
    }
}

/// NaN exceeds everything.
fn exceeds(value: f64, limit: f64) -> bool {
    value.is_nan() || value > limit
}
