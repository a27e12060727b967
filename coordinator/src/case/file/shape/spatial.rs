//! Shapes in space as a case file writes them.

use sph::shapes::{Frame, SpatialShape};
use sph::space::{Space, Spatial};

use super::surface::SurfaceTable;
use super::{Kind, ShapeTable};
use crate::case::errors::CaseError;
use crate::case::reader::{Coordinates, Table};

/// A kind of shape that the plane does not have.
#[derive(Clone, Copy)]
pub(super) enum SpatialKind {
    Box,
    Sphere,
    Cylinder,
    Cone,
    Torus,
    Extrusion,
    Revolution,
    HalfSpace,
    Placed,
    Surface,
    Intersection,
}

/// Words of the shapes in space.
pub(super) const KINDS: [(&str, Kind); 13] = [
    ("box", Kind::Spatial(SpatialKind::Box)),
    ("sphere", Kind::Spatial(SpatialKind::Sphere)),
    ("cylinder", Kind::Spatial(SpatialKind::Cylinder)),
    ("cone", Kind::Spatial(SpatialKind::Cone)),
    ("torus", Kind::Spatial(SpatialKind::Torus)),
    ("extrusion", Kind::Spatial(SpatialKind::Extrusion)),
    ("revolution", Kind::Spatial(SpatialKind::Revolution)),
    ("half-space", Kind::Spatial(SpatialKind::HalfSpace)),
    ("placed", Kind::Spatial(SpatialKind::Placed)),
    ("surface", Kind::Spatial(SpatialKind::Surface)),
    ("union", Kind::Union),
    ("intersection", Kind::Spatial(SpatialKind::Intersection)),
    ("difference", Kind::Difference),
];

/// Reads the keys of a shape of `kind`.
pub(super) fn read(kind: SpatialKind, table: &mut Table<'_>, depth: usize) -> Option<ShapeTable> {
    let length = |table: &mut Table<'_>, key| table.number(key).value;
    Some(match kind {
        SpatialKind::Box => {
            ShapeTable::Box { lower_m: table.vector("lower_m").value, upper_m: table.vector("upper_m").value }
        }
        SpatialKind::Sphere => ShapeTable::Sphere {
            centre_m: table.vector("centre_m").value,
            radius_m: length(table, "radius_m"),
        },
        SpatialKind::Cylinder => ShapeTable::Cylinder {
            from_m: table.vector("from_m").value,
            to_m: table.vector("to_m").value,
            radius_m: length(table, "radius_m"),
            inner_radius_m: table.number("inner_radius_m").value,
        },
        SpatialKind::Cone => ShapeTable::Cone {
            from_m: table.vector("from_m").value,
            to_m: table.vector("to_m").value,
            radius_from_m: table.number("radius_from_m").value,
            radius_to_m: table.number("radius_to_m").value,
        },
        SpatialKind::Torus => ShapeTable::Torus {
            centre_m: table.vector("centre_m").value,
            axis: direction(table, "axis", None),
            radius_m: length(table, "radius_m"),
            tube_radius_m: length(table, "tube_radius_m"),
        },
        SpatialKind::Extrusion => {
            let (x_axis, y_axis) = (
                direction(table, "x_axis", Some([1.0, 0.0, 0.0])),
                direction(table, "y_axis", Some([0.0, 1.0, 0.0])),
            );
            if Frame::new(Default::default(), &x_axis.to::<Spatial>(), &y_axis.to::<Spatial>()).is_none() {
                let error = CaseError::new(&table.place_of("y_axis"), "has the direction of `x_axis`");
                table.error(error.hint("give two directions that span the plane of the section"));
            }
            ShapeTable::Extrusion {
                origin_m: table.vector("origin_m").value,
                x_axis,
                y_axis,
                height_m: length(table, "height_m"),
                section: section(table, depth)?,
            }
        }
        SpatialKind::Revolution => ShapeTable::Revolution {
            origin_m: table.vector("origin_m").value,
            axis: direction(table, "axis", None),
            section: section(table, depth)?,
        },
        SpatialKind::HalfSpace => ShapeTable::HalfSpace {
            point_m: table.vector("point_m").value,
            normal: direction(table, "normal", None),
        },
        SpatialKind::Placed => {
            let turns = table.has("angle_rad");
            let shape = table.required_table("shape");
            ShapeTable::Placed {
                axis: direction(table, "axis", (!turns).then_some([0.0, 0.0, 1.0])),
                angle_rad: table.number("angle_rad").value,
                by_m: table.vector_or("by_m", Coordinates::repeat(3, 0.0)).value,
                shape: Box::new(ShapeTable::read_part(shape?, depth)?),
            }
        }
        SpatialKind::Surface => ShapeTable::Surface(SurfaceTable::read(table)?),
        SpatialKind::Intersection => {
            ShapeTable::Intersection { parts: ShapeTable::read_parts(table, "parts", depth) }
        }
    })
}

/// A direction of any length; the `default` where it may be left out.
fn direction(table: &mut Table<'_>, key: &'static str, default: Option<[f64; 3]>) -> Coordinates {
    let found = match default {
        Some(default) => table.vector_or(key, default.to_vec().into()),
        None => table.vector(key),
    };
    if table.intact() && !found.value.is_nonzero() {
        let error = CaseError::new(&found.place, "has no direction").value(table.written(&found.place));
        table.error(error.hint("give a direction such as [0.0, 0.0, 1.0]; its length does not matter"));
    }
    found.value
}

/// The plane shape under `section`.
fn section(table: &mut Table<'_>, depth: usize) -> Option<Box<ShapeTable>> {
    let mut section = table.required_table("section")?;
    section.dimensions = 2;
    Some(Box::new(ShapeTable::read_part(section, depth)?))
}

impl ShapeTable {
    /// The region of space that it means; none for a shape of the plane, which is refused where a case is read.
    pub fn to_spatial(&self) -> SpatialShape {
        let all = |parts: &[Self]| parts.iter().map(Self::to_spatial).collect();
        let vector = Coordinates::to::<Spatial>;
        let nothing = || SpatialShape::Union(Vec::new());
        match self {
            Self::Box { lower_m, upper_m } => {
                SpatialShape::Box { lower: vector(lower_m), upper: vector(upper_m) }
            }
            Self::Sphere { centre_m, radius_m } => {
                SpatialShape::Sphere { centre: vector(centre_m), radius: *radius_m }
            }
            Self::Cylinder { from_m, to_m, radius_m, inner_radius_m } => SpatialShape::Cylinder {
                from: vector(from_m),
                to: vector(to_m),
                radius: *radius_m,
                inner_radius: *inner_radius_m,
            },
            Self::Cone { from_m, to_m, radius_from_m, radius_to_m } => SpatialShape::Cone {
                from: vector(from_m),
                to: vector(to_m),
                radii: [*radius_from_m, *radius_to_m],
            },
            Self::Torus { centre_m, axis, radius_m, tube_radius_m } => SpatialShape::Torus {
                centre: vector(centre_m),
                axis: vector(axis),
                radius: *radius_m,
                tube_radius: *tube_radius_m,
            },
            Self::Extrusion { origin_m, x_axis, y_axis, height_m, section } => {
                let frame = Frame::new(vector(origin_m), &vector(x_axis), &vector(y_axis));
                frame.map_or_else(nothing, |frame| SpatialShape::Extrusion {
                    section: section.to_plane(),
                    frame,
                    height: *height_m,
                })
            }
            Self::Revolution { origin_m, axis, section } => {
                let frame = Frame::along(vector(origin_m), &vector(axis));
                frame.map_or_else(nothing, |frame| SpatialShape::Revolution {
                    section: section.to_plane(),
                    frame,
                })
            }
            Self::HalfSpace { point_m, normal } => {
                SpatialShape::HalfSpace { point: vector(point_m), normal: vector(normal) }
            }
            Self::Placed { axis, angle_rad, by_m, shape } => {
                let axis = vector(axis);
                let rotation = Spatial::rotated(Default::default(), axis / axis.norm() * *angle_rad, 1.0);
                shape.to_spatial().placed(Frame::placed(&rotation, vector(by_m)))
            }
            Self::Surface(surface) => SpatialShape::Surface(surface.surface.clone()),
            Self::Union { parts } => SpatialShape::Union(all(parts)),
            Self::Intersection { parts } => SpatialShape::Intersection(all(parts)),
            Self::Difference { from, minus } => {
                SpatialShape::Difference(Box::new(from.to_spatial()), all(minus))
            }
            Self::Rectangle { .. } | Self::Circle { .. } | Self::Ring { .. } | Self::Polygon { .. } => {
                nothing()
            }
        }
    }
}
