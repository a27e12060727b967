//! What laying out a scene needs of a space: its shapes, and how they are filled and surrounded.

use sph::shapes::{self, Boundary, OpenSides, Region, Shape, ShapedSpace, SpatialBoundary, SpatialShape};
use sph::space::{Plane, Spatial, Vector};

use super::Scene;
use crate::case::file::shape::ShapeTable;
use crate::case::reader::Coordinates;

/// The faces of a shape.
pub type BoundaryOf<S> = <<S as ShapedSpace>::Shape as Region<S>>::Boundary;

/// Middle \[m\] and outward area vector \[m²\] of each of the pieces of a boundary.
pub type Pieces<S> = Vec<(<S as sph::space::Space>::Vector, <S as sph::space::Space>::Vector)>;

/// A space in which scenes are laid out and solved.
pub trait SceneSpace: ShapedSpace + fluid::FluidSpace + solid::space::SolidSpace {
    /// The shape that `table` means.
    fn shape(table: &ShapeTable) -> Self::Shape;

    /// The box between two corners \[m\].
    fn box_table(lower: &Self::Vector, upper: &Self::Vector) -> ShapeTable;

    /// The corners \[m\] of a box whose sides run along the axes; `None` for another shape.
    fn box_corners(shape: &Self::Shape) -> Option<(Self::Vector, Self::Vector)>;

    /// Whether all faces lie between two rows of the lattice of `spacing` \[m\] that starts at `origin` \[m\], but for those
    /// in the `open` sides of the box around the shape.
    fn is_on_lattice(
        shape: &Self::Shape,
        boundary: &BoundaryOf<Self>,
        spacing: f64,
        origin: Self::Vector,
        open: OpenSides<Self>,
    ) -> bool;

    /// The boundary without the faces that other walls cover, see [`Boundary::uncovered`].
    fn uncovered(
        boundary: BoundaryOf<Self>,
        outside: bool,
        reach: f64,
        covered: impl Fn(&Self::Vector) -> bool,
    ) -> BoundaryOf<Self>;

    /// Steps of work of [`shapes::fill_fitted`] for a shape of this `volume` \[m³\] of so many `pieces`.
    fn fitted_steps(boundary: &BoundaryOf<Self>, volume: f64, spacing: f64, pieces: f64) -> f64;

    /// The faces of a body of particles of `spacing` \[m\] in small pieces.
    fn pieces(boundary: &BoundaryOf<Self>, spacing: f64) -> Pieces<Self>;

    /// What `scene` is where the space is not known.
    fn any(scene: Scene<Self>) -> super::AnyScene;
}

impl SceneSpace for Plane {
    fn shape(table: &ShapeTable) -> Shape {
        table.to_plane()
    }

    fn box_table(lower: &Vector, upper: &Vector) -> ShapeTable {
        ShapeTable::Rectangle { lower_m: Coordinates::from(lower), upper_m: Coordinates::from(upper) }
    }

    fn box_corners(shape: &Shape) -> Option<(Vector, Vector)> {
        let Shape::Rectangle { lower, upper } = shape else { return None };
        Some((*lower, *upper))
    }

    fn is_on_lattice(
        shape: &Shape,
        boundary: &Boundary,
        spacing: f64,
        origin: Vector,
        open: OpenSides,
    ) -> bool {
        let (lower, upper) = shape.bounds();
        let in_open_side = |edge: &[Vector]| {
            (0..2).any(|axis| {
                let in_plane = |plane: f64| edge.iter().all(|x| (x[axis] - plane).abs() < 1e-6 * spacing);
                (open.lower[axis] && in_plane(lower[axis])) || (open.upper[axis] && in_plane(upper[axis]))
            })
        };
        shapes::is_on_lattice(boundary, spacing, origin, in_open_side)
    }

    fn uncovered(
        boundary: Boundary,
        outside: bool,
        reach: f64,
        covered: impl Fn(&Vector) -> bool,
    ) -> Boundary {
        boundary.uncovered(outside, reach, covered)
    }

    fn fitted_steps(boundary: &Boundary, volume: f64, spacing: f64, pieces: f64) -> f64 {
        let steps = shapes::FITTED_STEPS + 100.0 * pieces;
        (volume / (spacing * spacing)).min(boundary.length() / spacing * 12.0) * steps
    }

    fn pieces(boundary: &Boundary, spacing: f64) -> Pieces<Self> {
        boundary.pieces(0.1 * spacing)
    }

    fn any(scene: Scene<Self>) -> super::AnyScene {
        super::AnyScene::Plane(scene)
    }
}

impl SceneSpace for Spatial {
    fn shape(table: &ShapeTable) -> SpatialShape {
        table.to_spatial()
    }

    fn box_table(lower: &Self::Vector, upper: &Self::Vector) -> ShapeTable {
        ShapeTable::Box { lower_m: Coordinates::from(lower), upper_m: Coordinates::from(upper) }
    }

    fn box_corners(shape: &SpatialShape) -> Option<(Self::Vector, Self::Vector)> {
        let SpatialShape::Box { lower, upper } = shape else { return None };
        Some((*lower, *upper))
    }

    fn is_on_lattice(
        shape: &SpatialShape,
        _boundary: &SpatialBoundary,
        spacing: f64,
        origin: Self::Vector,
        open: OpenSides<Self>,
    ) -> bool {
        let (lower, upper) = shape.bounds();
        is_lattice_shape(shape, &|axis, position| {
            let rows = (position - origin[axis]) / spacing;
            let in_open_side = |side: f64, is_open: bool| is_open && (position - side).abs() < 1e-6 * spacing;
            (rows - rows.round()).abs() < 1e-6
                || in_open_side(lower[axis], open.lower[axis])
                || in_open_side(upper[axis], open.upper[axis])
        })
    }

    fn uncovered(
        boundary: SpatialBoundary,
        outside: bool,
        reach: f64,
        covered: impl Fn(&Self::Vector) -> bool,
    ) -> SpatialBoundary {
        boundary.uncovered(outside, reach, covered)
    }

    fn fitted_steps(_boundary: &SpatialBoundary, volume: f64, spacing: f64, pieces: f64) -> f64 {
        volume / spacing.powi(3) * (shapes::FITTED_STEPS + 100.0 * pieces)
    }

    fn pieces(boundary: &SpatialBoundary, spacing: f64) -> Pieces<Self> {
        // 16 for the cell of a particle.
        boundary.pieces(0.25 * spacing)
    }

    fn any(scene: Scene<Self>) -> super::AnyScene {
        super::AnyScene::Spatial(scene)
    }
}

/// Whether `shape` is made of boxes alone, each face of which, at a position \[m\] along an axis, is between two rows.
fn is_lattice_shape(shape: &SpatialShape, between_rows: &impl Fn(usize, f64) -> bool) -> bool {
    let all = |parts: &[SpatialShape]| parts.iter().all(|part| is_lattice_shape(part, between_rows));
    match shape {
        SpatialShape::Box { lower, upper } => {
            (0..3).all(|axis| between_rows(axis, lower[axis]) && between_rows(axis, upper[axis]))
        }
        SpatialShape::Union(parts) | SpatialShape::Intersection(parts) => all(parts),
        SpatialShape::Difference(base, removed) => is_lattice_shape(base, between_rows) && all(removed),
        _ => false,
    }
}
