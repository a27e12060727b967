//! Shapes as a case file writes them.

mod outline;
mod spatial;
mod surface;
mod table;

use std::path::Path;

use serde::Serialize;
use sph::shapes::{MAXIMUM_NESTING, MAXIMUM_VERTICES, Shape};
use sph::space::Plane;

use crate::case::errors::{CaseError, ErrorList, Place};
use crate::case::files::{LARGEST_FILE, read_text, resolved};
use crate::case::reader::{At, Coordinates, SOUND, Table, is_sound};
use crate::quote;
use spatial::SpatialKind;
use surface::SurfaceTable;
pub use table::SHAPE;

/// Most primitives and corners that one shape may have: the work per particle grows with them.
const MOST_PIECES: usize = 2 * MAXIMUM_VERTICES;

/// A shape, lengths in metres.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[allow(missing_docs)] // The keys are the documentation: each names its quantity and unit.
pub enum ShapeTable {
    Rectangle {
        lower_m: Coordinates,
        upper_m: Coordinates,
    },
    Circle {
        centre_m: Coordinates,
        radius_m: f64,
    },
    Ring {
        centre_m: Coordinates,
        inner_radius_m: f64,
        outer_radius_m: f64,
    },
    Polygon {
        vertices_m: Vec<Coordinates>,
    },
    Box {
        lower_m: Coordinates,
        upper_m: Coordinates,
    },
    Sphere {
        centre_m: Coordinates,
        radius_m: f64,
    },
    Cylinder {
        from_m: Coordinates,
        to_m: Coordinates,
        radius_m: f64,
        inner_radius_m: f64,
    },
    Cone {
        from_m: Coordinates,
        to_m: Coordinates,
        radius_from_m: f64,
        radius_to_m: f64,
    },
    Torus {
        centre_m: Coordinates,
        axis: Coordinates,
        radius_m: f64,
        tube_radius_m: f64,
    },
    Extrusion {
        origin_m: Coordinates,
        x_axis: Coordinates,
        y_axis: Coordinates,
        height_m: f64,
        section: Box<ShapeTable>,
    },
    Revolution {
        origin_m: Coordinates,
        axis: Coordinates,
        section: Box<ShapeTable>,
    },
    HalfSpace {
        point_m: Coordinates,
        normal: Coordinates,
    },
    Surface(SurfaceTable),
    Placed {
        axis: Coordinates,
        angle_rad: f64,
        by_m: Coordinates,
        shape: Box<ShapeTable>,
    },
    Union {
        parts: Vec<ShapeTable>,
    },
    Intersection {
        parts: Vec<ShapeTable>,
    },
    Difference {
        from: Box<ShapeTable>,
        minus: Vec<ShapeTable>,
    },
}

#[derive(Clone, Copy)]
enum Kind {
    Rectangle,
    Circle,
    Ring,
    Polygon,
    Outline,
    Spatial(SpatialKind),
    Union,
    Difference,
}

/// Words of the shapes of the plane.
const PLANE_KINDS: [(&str, Kind); 7] = [
    ("rectangle", Kind::Rectangle),
    ("circle", Kind::Circle),
    ("ring", Kind::Ring),
    ("polygon", Kind::Polygon),
    ("outline", Kind::Outline),
    ("union", Kind::Union),
    ("difference", Kind::Difference),
];

impl ShapeTable {
    /// Reads the shape under `key`, which must be written; `None` when it is wrong.
    pub fn read(parent: &mut Table<'_>, key: &'static str) -> Option<At<Self>> {
        let table = parent.required_table(key)?;
        Self::read_whole(table)
    }

    /// Reads the shape under `key`, which may be left out.
    pub fn read_optional(parent: &mut Table<'_>, key: &'static str) -> Option<At<Self>> {
        let table = parent.optional_table(key)?;
        Self::read_whole(table)
    }

    fn read_whole(mut table: Table<'_>) -> Option<At<Self>> {
        let place = table.place().clone();
        let shape = Self::read_table(&mut table, 0);
        let valid = match shape.as_ref().filter(|_| table.intact()) {
            Some(shape) => shape
                .check(&place, table.errors())
                .map_err(|problem| table.error(CaseError::new(&place, problem)))
                .is_ok(),
            None => false,
        };
        (table.finish() && valid).then_some(())?;
        Some(At { value: shape?, place })
    }

    fn check(&self, place: &Place, errors: &ErrorList) -> Result<(), String> {
        let pieces = self.pieces();
        if pieces > MOST_PIECES {
            return Err(format!("has {pieces} corners and parts; at most {MOST_PIECES} are allowed"));
        }
        // Edges of a polygon are compared in pairs.
        if !errors.spend(place, 2.5 * (pieces * pieces) as f64) {
            return Err("was not examined: those before it took too much work".into());
        }
        self.validate()
    }

    fn read_table(table: &mut Table<'_>, depth: usize) -> Option<Self> {
        if depth > MAXIMUM_NESTING {
            let problem = format!("shapes are nested more than {MAXIMUM_NESTING} deep");
            table.error(CaseError::new(table.place(), problem).hint("draw a polygon instead"));
            return None;
        }
        let (kinds, others, space) = match table.dimensions {
            2 => (&PLANE_KINDS[..], &spatial::KINDS[..], "in space"),
            _ => (&spatial::KINDS[..], &PLANE_KINDS[..], "of the plane"),
        };
        let word = table.peek_text("type").unwrap_or_default();
        let known = |kinds: &[(&str, Kind)]| kinds.iter().any(|(kind, _)| *kind == word);
        if known(others) && !known(kinds) {
            let place = table.place_of("type");
            let words: Vec<String> = kinds.iter().map(|(word, _)| format!("\"{word}\"")).collect();
            let problem = format!("is a shape {space}, in a case of {} dimensions", table.dimensions);
            table.error(CaseError::new(&place, problem).value(word).allowed(words.join(", ")));
            table.abandon();
            return None;
        }
        let Some(kind) = table.choice("type", kinds) else {
            table.abandon();
            return None;
        };
        Some(match kind.value {
            Kind::Rectangle => Self::Rectangle {
                lower_m: table.vector("lower_m").value,
                upper_m: table.vector("upper_m").value,
            },
            Kind::Circle => Self::Circle {
                centre_m: table.vector("centre_m").value,
                radius_m: table.number("radius_m").value,
            },
            Kind::Ring => Self::Ring {
                centre_m: table.vector("centre_m").value,
                inner_radius_m: table.number("inner_radius_m").value,
                outer_radius_m: table.number("outer_radius_m").value,
            },
            Kind::Polygon => Self::Polygon { vertices_m: read_polygon(table)? },
            Kind::Outline => outline::read(table)?,
            Kind::Spatial(kind) => spatial::read(kind, table, depth)?,
            Kind::Union => Self::Union { parts: Self::read_parts(table, "parts", depth) },
            Kind::Difference => {
                let from = table.required_table("from");
                let minus = Self::read_parts(table, "minus", depth);
                Self::Difference { from: Box::new(Self::read_part(from?, depth)?), minus }
            }
        })
    }

    fn read_parts(table: &mut Table<'_>, key: &'static str, depth: usize) -> Vec<Self> {
        let parts = table.tables(key);
        if parts.is_empty() && table.intact() {
            let place = table.place_of(key);
            table.error(CaseError::new(&place, "needs at least one shape"));
        }
        parts.into_iter().filter_map(|part| Self::read_part(part, depth)).collect()
    }

    fn read_part(mut table: Table<'_>, depth: usize) -> Option<Self> {
        let shape = Self::read_table(&mut table, depth + 1);
        if table.finish() { shape } else { None }
    }

    /// Number of corners and primitives.
    pub fn pieces(&self) -> usize {
        let sum = |parts: &[Self]| parts.iter().map(Self::pieces).sum::<usize>();
        match self {
            Self::Rectangle { .. } => 4,
            Self::Circle { .. } | Self::Sphere { .. } | Self::HalfSpace { .. } | Self::Torus { .. } => 1,
            Self::Ring { .. } => 2,
            Self::Cone { .. } => 3,
            Self::Cylinder { .. } => 4,
            Self::Box { .. } => 6,
            Self::Extrusion { section, .. } => section.pieces() + 2,
            Self::Revolution { section, .. } => section.pieces(),
            Self::Placed { shape, .. } => shape.pieces(),
            Self::Surface(surface) => surface.pieces(),
            Self::Polygon { vertices_m } => vertices_m.len(),
            Self::Union { parts } | Self::Intersection { parts } => sum(parts),
            Self::Difference { from, minus } => from.pieces() + sum(minus),
        }
    }

    fn validate(&self) -> Result<(), String> {
        if self.is_spatial() { self.to_spatial().validate() } else { self.to_plane().validate() }
    }

    /// Whether it is a shape in space.
    fn is_spatial(&self) -> bool {
        match self {
            Self::Rectangle { .. } | Self::Circle { .. } | Self::Ring { .. } | Self::Polygon { .. } => false,
            Self::Union { parts } => parts.iter().any(Self::is_spatial),
            Self::Difference { from, .. } => from.is_spatial(),
            _ => true,
        }
    }

    /// The region of the plane that it means; none for a shape in space, which is refused where a case is read.
    pub fn to_plane(&self) -> Shape {
        let all = |parts: &[Self]| parts.iter().map(Self::to_plane).collect();
        let vector = Coordinates::to::<Plane>;
        match self {
            Self::Rectangle { lower_m, upper_m } => {
                Shape::Rectangle { lower: vector(lower_m), upper: vector(upper_m) }
            }
            Self::Circle { centre_m, radius_m } => {
                Shape::Circle { centre: vector(centre_m), radius: *radius_m }
            }
            Self::Ring { centre_m, inner_radius_m, outer_radius_m } => Shape::Ring {
                centre: vector(centre_m),
                inner_radius: *inner_radius_m,
                outer_radius: *outer_radius_m,
            },
            Self::Polygon { vertices_m } => {
                Shape::Polygon { vertices: vertices_m.iter().map(vector).collect() }
            }
            Self::Union { parts } => Shape::Union(all(parts)),
            Self::Difference { from, minus } => Shape::Difference(Box::new(from.to_plane()), all(minus)),
            _ => Shape::Union(Vec::new()),
        }
    }
}

/// Corners of a polygon, written inline or in a CSV file with columns `x_m` and `y_m`.
fn read_polygon(table: &mut Table<'_>) -> Option<Vec<Coordinates>> {
    if !table.has("file") {
        return Some(table.points("vertices_m")?.value);
    }
    let file = table.text("file");
    let path = resolved(table.directory, &file.value);
    // A file may be named any number of times.
    let steps = std::fs::metadata(&path).map_or(0.0, |facts| 20.0 * facts.len().min(LARGEST_FILE) as f64);
    if !table.errors().spend(&file.place, steps) {
        return None;
    }
    read_points(&path)
        .map_err(|problem| {
            let error = CaseError::new(&file.place, problem).value(&file.value);
            table.error(error.hint(
                "give a CSV file with the header `x_m,y_m`; its path is taken from the case file's folder",
            ));
        })
        .ok()
}

fn read_points(path: &Path) -> Result<Vec<Coordinates>, String> {
    let text = read_text(path)?;
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let column = |name: &str| {
        header
            .iter()
            .position(|cell| cell == name)
            .ok_or_else(|| format!("{} has no column `{name}`", quote::path(path)))
    };
    let (x, y) = (column("x_m")?, column("y_m")?);
    let mut points = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |index: usize| {
            let cell = record.get(index).unwrap_or_default();
            let bad = || {
                format!(
                    "{} line {line}: `{}` is no finite number, {SOUND}",
                    quote::path(path),
                    quote::quoted(cell)
                )
            };
            cell.parse().ok().filter(|value: &f64| is_sound(*value)).ok_or_else(bad)
        };
        points.push(vec![number(x)?, number(y)?].into());
        if points.len() > MAXIMUM_VERTICES {
            return Err(format!("{} has more than {MAXIMUM_VERTICES} points", quote::path(path)));
        }
    }
    Ok(points)
}
