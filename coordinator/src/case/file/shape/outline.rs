//! Outlines from DXF drawings as a case file names them.

mod curves;
mod dxf;
mod loops;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use sph::shapes::MAXIMUM_VERTICES;

use super::ShapeTable;
use super::surface::UNITS;
use crate::case::errors::CaseError;
use crate::case::files::{read_bytes, resolved};
use crate::case::reader::{Coordinates, SOUND, Table, is_sound};
use crate::quote;
use curves::{Curve, Point};
use dxf::Entity;
use loops::{Loop, Piece};

/// Largest drawing that is read \[bytes\]; its pairs take eight times as much memory.
const LARGEST_DRAWING: u64 = 16 << 20;

/// Steps of work for each byte of a drawing, each about a nanosecond.
const BYTE_STEPS: f64 = 20.0;

/// Steps of work to compare two edges.
const PAIR_STEPS: f64 = 10.0;

/// Share of the drawing's extent by which chords may miss curves, where the case does not say.
const TOLERANCE: f64 = 1e-4;

/// Where an outline stands: turned about the origin of the drawing, then moved.
struct Placement {
    /// Metres in a unit of the drawing.
    unit: f64,
    angle: f64,
    by: Coordinates,
}

/// Reads the keys and the drawing; `None` when either is wrong.
pub(super) fn read(table: &mut Table<'_>) -> Option<ShapeTable> {
    let file = table.text("file");
    let unit = table.choice("unit", &UNITS);
    let layer = table.optional_text("layer");
    let tolerance = table.optional_number("tolerance_m");
    let angle = table.number("angle_rad").value;
    let by = table.vector_or("by_m", Coordinates::repeat(2, 0.0)).value;
    let (unit, true) = (unit?, table.intact()) else { return None };
    let placement = Placement { unit: unit.value, angle, by };
    let path = resolved(table.directory, &file.value);
    // A file may be named any number of times.
    let bytes = std::fs::metadata(&path).map_or(0, |facts| facts.len().min(LARGEST_DRAWING));
    if !table.errors().spend(&file.place, BYTE_STEPS * bytes as f64) {
        return None;
    }
    let refuse = |problem: String| {
        let hint = "give an ASCII DXF file of closed lines; its path is taken from the case file's folder";
        table.error(CaseError::new(&file.place, problem).value(&file.value).hint(hint));
    };
    let wanted = layer.as_ref().map(|layer| layer.value.as_str());
    let outlines = read_bytes(&path, LARGEST_DRAWING).and_then(|bytes| {
        let of_file = |problem: String| format!("{}: {problem}", quote::path(&path));
        let entities = dxf::read(&bytes).map_err(of_file)?;
        let (pieces, tolerance) =
            pieces(entities, wanted, tolerance.map(|metres| metres / placement.unit)).map_err(of_file)?;
        let points = pieces.iter().map(|piece| piece.points.len()).sum::<usize>() as f64;
        // Ends and edges are compared in pairs.
        if !table.errors().spend(&file.place, PAIR_STEPS * points * points) {
            return Err("was not examined: those before it took too much work".into());
        }
        loops::joined(pieces, tolerance).and_then(|loops| shape(&loops, &placement)).map_err(of_file)
    });
    outlines.map_err(refuse).ok()
}

/// Chords of the entities on the layer that is `wanted`, with the tolerance in units of the drawing.
fn pieces(
    entities: Vec<Entity>,
    wanted: Option<&str>,
    tolerance: Option<f64>,
) -> Result<(Vec<Piece>, f64), String> {
    let mut layers = BTreeSet::new();
    let mut curves = Vec::new();
    for Entity { layer, line, curve } in entities {
        // Names of layers do not tell capitals apart.
        if wanted.is_none_or(|wanted| wanted.eq_ignore_ascii_case(&layer)) {
            curves.push(curve.map_err(|problem| format!("the entity on line {line} {problem}"))?);
        }
        layers.insert(layer);
    }
    if curves.is_empty() {
        return Err(match wanted {
            Some(wanted) if !layers.is_empty() => {
                let layers: Vec<&str> = layers.iter().map(String::as_str).collect();
                format!(
                    "has no lines on the layer `{}`; it has {}",
                    quote::quoted(wanted),
                    quote::listed(&layers)
                )
            }
            _ => "has no lines".into(),
        });
    }
    let tolerance = tolerance.unwrap_or_else(|| TOLERANCE * extent(&curves));
    let mut pieces = Vec::new();
    let mut count = 0;
    for curve in curves {
        let points = curve.points(tolerance);
        count += points.len();
        if count > MAXIMUM_VERTICES {
            return Err(format!(
                "needs more than {MAXIMUM_VERTICES} corners; a larger `tolerance_m` needs fewer"
            ));
        }
        if !points.is_empty() {
            pieces.push(Piece { points, closed: curve.closed });
        }
    }
    Ok((pieces, tolerance))
}

/// Longer side of a box around all curves.
fn extent(curves: &[Curve]) -> f64 {
    let boxes: Vec<(Point, Point)> = curves.iter().map(Curve::bounds).collect();
    let side = |axis: usize| {
        let low = boxes.iter().map(|(low, _)| low[axis]).fold(f64::INFINITY, f64::min);
        let high = boxes.iter().map(|(_, high)| high[axis]).fold(f64::NEG_INFINITY, f64::max);
        high - low
    };
    side(0).max(side(1))
}

/// What lies within an odd number of the outlines.
fn shape(loops: &[Loop], placement: &Placement) -> Result<ShapeTable, String> {
    let around = loops::around(loops)?;
    let polygon = |index: usize| placement.polygon(&loops[index]);
    let part = |index: usize| {
        // Its holes lie in it and in all that it lies in.
        let holes = (0..loops.len())
            .filter(|hole| around[*hole].contains(&index) && around[*hole].len() == around[index].len() + 1);
        let minus = holes.map(polygon).collect::<Result<Vec<_>, _>>()?;
        let from = polygon(index)?;
        Ok(if minus.is_empty() { from } else { ShapeTable::Difference { from: Box::new(from), minus } })
    };
    let solid = (0..loops.len()).filter(|index| around[*index].len() % 2 == 0);
    let mut parts = solid.map(part).collect::<Result<Vec<_>, String>>()?;
    match parts.len() {
        1 => Ok(parts.swap_remove(0)),
        _ => Ok(ShapeTable::Union { parts }),
    }
}

impl Placement {
    fn polygon(&self, points: &Loop) -> Result<ShapeTable, String> {
        let (sin, cos) = self.angle.sin_cos();
        let by = self.by.as_slice();
        let placed = points.iter().map(|[x, y]| {
            let (x, y) = (x * self.unit, y * self.unit);
            let vertex = vec![cos * x - sin * y + by[0], sin * x + cos * y + by[1]];
            match vertex.iter().all(|value| is_sound(*value)) {
                true => Ok(vertex.into()),
                false => {
                    Err(format!("has a corner at ({}, {}) m; allowed are {SOUND}", vertex[0], vertex[1]))
                }
            }
        });
        Ok(ShapeTable::Polygon { vertices_m: placed.collect::<Result<_, _>>()? })
    }
}
