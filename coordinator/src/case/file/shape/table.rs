//! Rows of shapes.

use crate::case::reader::Allowed;
use crate::case::spec::{KeySpec, Kind, TableSpec, Variant, Variants, key};

const CENTRE: KeySpec = key("centre_m", Kind::Vector, "centre");
const ORIGIN: KeySpec = key("origin_m", Kind::Vector, "origin of the section's coordinates");

const UNIT: KeySpec = key(
    "unit",
    Kind::Word(&[
        ("m", "metre"),
        ("dm", "0.1 m"),
        ("cm", "0.01 m"),
        ("mm", "0.001 m"),
        ("in", "0.0254 m"),
        ("ft", "0.3048 m"),
    ]),
    "unit of length of the file",
);

/// The shapes that are combined. A constant cannot name the table in which it stands.
const fn parts(inner: &'static TableSpec) -> KeySpec {
    key("parts", Kind::Tables(inner), "the shapes, at least one")
}

/// The shape of the plane that makes one in space.
const fn section(inner: &'static TableSpec) -> KeySpec {
    key("section", Kind::Table(inner), "a shape of the plane")
}

/// A length above 0.
const fn length(name: &'static str, about: &'static str) -> KeySpec {
    key(name, Kind::Number(Allowed::POSITIVE), about)
}

/// A length of 0 or above.
const fn length_or_none(name: &'static str, about: &'static str) -> KeySpec {
    key(name, Kind::Number(Allowed::NOT_NEGATIVE), about)
}

/// Rows of shapes: four kinds for the plane, others for space, and combinations.
pub static SHAPE: TableSpec =
    TableSpec::new("shape", "A shape, of the plane or in space as the case is.", &[]).by(Variants::new(
        "type",
        "kind of the shape",
        &[
            Variant::new("rectangle", "a rectangle along the axes, in the plane", &[
                key("lower_m", Kind::Vector, "lower left corner"),
                key("upper_m", Kind::Vector, "upper right corner"),
            ]),
            Variant::new("circle", "a disc, in the plane", &[CENTRE, length("radius_m", "radius")]),
            Variant::new("ring", "what lies between two circles, in the plane", &[
                CENTRE,
                length("inner_radius_m", "inner radius"),
                length("outer_radius_m", "outer radius"),
            ]),
            Variant::new("polygon", "a polygon, in the plane", &[
                key("vertices_m", Kind::Points, "corners in order, either way around"),
                key(
                    "file",
                    Kind::Text("the path of a CSV file, from the folder of the case"),
                    "file of the corners, with columns `x_m` and `y_m`",
                ),
            ])
            .either(&[&["vertices_m"], &["file"]]),
            Variant::new(
                "outline",
                "what closed lines of a drawing enclose, less what lines within them enclose, in the plane",
                &[
                    key(
                        "file",
                        Kind::Text("the path of a DXF file, from the folder of the case"),
                        "DXF file in words (ASCII); lines, arcs, circles, ellipses, splines and polylines of the model are \
                         read, notes and dimensions are not",
                    ),
                    UNIT,
                    key("layer", Kind::Text("a name"), "the layer that has the lines").or_else("all layers"),
                    length(
                        "tolerance_m",
                        "largest distance of a curve from the chords that replace it, and of ends that are joined",
                    )
                    .or_else("1e-4 of the longer side of the drawing"),
                    key("angle_rad", Kind::Number(Allowed::FINITE), "turn about the origin of the drawing, counterclockwise")
                        .or(0.0),
                    key("by_m", Kind::Vector, "displacement after the turn").or_else("0 along each axis"),
                ],
            ),
            Variant::new("box", "a box along the axes, in space", &[
                key("lower_m", Kind::Vector, "corner toward lower coordinates"),
                key("upper_m", Kind::Vector, "corner toward higher coordinates"),
            ]),
            Variant::new("sphere", "a ball, in space", &[CENTRE, length("radius_m", "radius")]),
            Variant::new("cylinder", "a cylinder or a tube, in space", &[
                key("from_m", Kind::Vector, "centre of one end"),
                key("to_m", Kind::Vector, "centre of the other end"),
                length("radius_m", "radius"),
                length_or_none("inner_radius_m", "inner radius of a tube").or(0.0),
            ]),
            Variant::new("cone", "a cone or a part of one, in space; one of the radii may be 0", &[
                key("from_m", Kind::Vector, "centre of one end"),
                key("to_m", Kind::Vector, "centre of the other end"),
                length_or_none("radius_from_m", "radius at the one end"),
                length_or_none("radius_to_m", "radius at the other end"),
            ]),
            Variant::new("torus", "a torus, in space", &[
                CENTRE,
                key("axis", Kind::Vector, "direction of its axis, of any length"),
                length("radius_m", "radius of the circle along which the tube runs"),
                length("tube_radius_m", "radius of the tube"),
            ]),
            Variant::new(
                "extrusion",
                "a shape of the plane, in x and y of its axes, moved along their third by a height, in space",
                &[
                    ORIGIN,
                    key("x_axis", Kind::Vector, "direction of x of the section, of any length")
                        .or_else("[1.0, 0.0, 0.0]"),
                    key("y_axis", Kind::Vector, "direction of y of the section, of any length")
                        .or_else("[0.0, 1.0, 0.0]"),
                    length("height_m", "height"),
                    section(&SHAPE),
                ],
            ),
            Variant::new(
                "revolution",
                "a shape of the plane turned about an axis, in space: x of the section is the distance from the axis, y \
                 the height along it",
                &[ORIGIN, key("axis", Kind::Vector, "direction of the axis, of any length"), section(&SHAPE)],
            ),
            Variant::new("half-space", "what lies behind a plane, to cut other shapes by, in space", &[
                key("point_m", Kind::Vector, "a point of the plane"),
                key("normal", Kind::Vector, "direction away from what lies behind, of any length"),
            ]),
            Variant::new("placed", "a shape turned about an axis through the origin, then moved, in space", &[
                key("axis", Kind::Vector, "direction of the axis, of any length; must be written with `angle_rad`")
                    .or_else("[0.0, 0.0, 1.0]"),
                key("angle_rad", Kind::Number(Allowed::FINITE), "angle, right-handed about the axis").or(0.0),
                key("by_m", Kind::Vector, "displacement after the turn").or_else("0 along each axis"),
                key("shape", Kind::Table(&SHAPE), "the shape that is placed"),
            ]),
            Variant::new("surface", "what a surface of triangles encloses, in space", &[
                key(
                    "file",
                    Kind::Text("the path of an STL file, from the folder of the case"),
                    "STL file, in words or binary",
                ),
                UNIT,
                key(
                    "defects",
                    Kind::Word(&[
                        ("refuse", "they are errors"),
                        ("repair", "facets are turned or left out where there is no doubt; what stays is an error"),
                        (
                            "accept",
                            "the same, and the inside is where the surface winds around at least half a time, whatever \
                             else is wrong",
                        ),
                    ]),
                    "what to do with holes, and with facets that cross, come again or face inward",
                )
                .or_word("refuse"),
            ]),
            Variant::new("union", "what lies in any of several shapes", &[parts(&SHAPE)]),
            Variant::new("intersection", "what lies in all of several shapes, in space", &[parts(&SHAPE)]),
            Variant::new("difference", "a shape without others", &[
                key("from", Kind::Table(&SHAPE), "the shape that is cut"),
                key("minus", Kind::Tables(&SHAPE), "the shapes that are taken away, at least one"),
            ]),
        ],
    ));
