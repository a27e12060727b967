//! What a shape must satisfy, in the words of a case file.

use super::{Shape, edges_of};
use crate::space::{Vector, cross};

/// Most corners of a polygon.
pub const MAXIMUM_VERTICES: usize = 10_000;

/// Deepest nesting of unions and differences.
pub const MAXIMUM_NESTING: usize = 16;

impl Shape {
    /// Checks that the shape encloses an area: finite numbers, positive sizes, a simple polygon, no empty part.
    ///
    /// # Errors
    /// What is wrong, with the value and what is allowed.
    pub fn validate(&self) -> Result<(), String> {
        validate(self, 0)
    }
}

fn validate(shape: &Shape, level: usize) -> Result<(), String> {
    if level > MAXIMUM_NESTING {
        return Err(format!("shapes are nested more than {MAXIMUM_NESTING} deep; use a polygon"));
    }
    let all = |kind: &str, parts: &[Shape]| {
        if parts.is_empty() {
            return Err(format!("{kind} has no parts; at least one shape is needed"));
        }
        parts.iter().enumerate().try_for_each(|(index, part)| {
            validate(part, level + 1).map_err(|error| format!("part {} of {kind}: {error}", index + 1))
        })
    };
    match shape {
        Shape::Rectangle { lower, upper } => {
            finite("lower corner", lower)?;
            finite("upper corner", upper)?;
            for (axis, name) in ["x", "y"].into_iter().enumerate() {
                if lower[axis] >= upper[axis] {
                    return Err(format!(
                        "rectangle: lower {name} = {} m, upper {name} = {} m: upper must lie above lower",
                        lower[axis], upper[axis]
                    ));
                }
            }
            finite_size(upper - lower)
        }
        Shape::Circle { centre, radius } => {
            finite("centre", centre)?;
            positive("radius", *radius)
        }
        Shape::Ring { centre, inner_radius, outer_radius } => {
            finite("centre", centre)?;
            positive("inner radius", *inner_radius)?;
            positive("outer radius", *outer_radius)?;
            if inner_radius >= outer_radius {
                return Err(format!(
                    "ring: inner radius = {inner_radius} m, outer radius = {outer_radius} m: inner must be below outer"
                ));
            }
            Ok(())
        }
        Shape::Polygon { vertices } => polygon(vertices),
        Shape::Union(parts) => all("union", parts),
        Shape::Difference(base, removed) => {
            validate(base, level + 1).map_err(|error| format!("first shape of difference: {error}"))?;
            all("difference", removed)
        }
    }
}

fn finite(what: &str, point: &Vector) -> Result<(), String> {
    if point.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(format!("{what} = ({}, {}) m: both must be finite numbers", point.x, point.y))
}

fn finite_size(size: Vector) -> Result<(), String> {
    if size.norm_squared().is_finite() {
        return Ok(());
    }
    Err(format!("size = ({}, {}) m: too large to compute with", size.x, size.y))
}

fn positive(what: &str, value: f64) -> Result<(), String> {
    if value > 0.0 && (value * value).is_finite() {
        return Ok(());
    }
    Err(format!("{what} = {value} m: must be a positive finite number"))
}

fn polygon(vertices: &[Vector]) -> Result<(), String> {
    let count = vertices.len();
    if !(3..=MAXIMUM_VERTICES).contains(&count) {
        return Err(format!("polygon has {count} vertices; 3 to {MAXIMUM_VERTICES} are allowed"));
    }
    for (index, vertex) in vertices.iter().enumerate() {
        finite(&format!("vertex {}", index + 1), vertex)?;
        finite_size(*vertex)?;
    }
    let edges: Vec<(Vector, Vector)> = edges_of(vertices).collect();
    let name = |index: usize| format!("{} ({}, {})", index + 1, vertices[index].x, vertices[index].y);
    for index in 0..count {
        let next = (index + 1) % count;
        let ((a, b), (_, c)) = (edges[index], edges[next]);
        if a == b {
            return Err(format!(
                "polygon: vertices {} and {} are the same point; leave one out",
                name(index),
                name(next)
            ));
        }
        if cross(&(b - a), &(c - b)) == 0.0 && (b - a).dot(&(c - b)) < 0.0 {
            return Err(format!("polygon: it turns straight back at vertex {}", name(next)));
        }
    }
    for i in 0..count {
        for j in i + 2..count {
            // The last edge ends where the first begins.
            if !(i == 0 && j == count - 1) && meet(edges[i], edges[j]) {
                return Err(format!(
                    "polygon: the edges after vertices {} and {} cross or touch; the outline must not meet itself",
                    name(i),
                    name(j)
                ));
            }
        }
    }
    Ok(())
}

/// Whether two closed segments have a point in common.
fn meet((a, b): (Vector, Vector), (c, d): (Vector, Vector)) -> bool {
    let apart = (0..2).any(|axis| {
        a[axis].max(b[axis]) < c[axis].min(d[axis]) || c[axis].max(d[axis]) < a[axis].min(b[axis])
    });
    if apart {
        return false;
    }
    let side = |p: Vector, q: Vector, r: Vector| cross(&(q - p), &(r - p));
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}
