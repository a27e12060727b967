//! Closed lines out of pieces that meet end to end, and which of them lie within which.

use super::curves::{Point, distance};

/// Share of the tolerance within which two points of a line are one.
const SAME: f64 = 1e-3;

/// A piece of an outline: its points in order, and whether the last is the first.
pub struct Piece {
    pub points: Vec<Point>,
    pub closed: bool,
}

/// A closed line, its first point not repeated.
pub type Loop = Vec<Point>;

/// Joins pieces whose ends lie within `tolerance` of each other.
///
/// # Errors
/// An end that meets no other, or several.
pub fn joined(pieces: Vec<Piece>, tolerance: f64) -> Result<Vec<Loop>, String> {
    let (closed, mut open): (Vec<_>, Vec<_>) = pieces.into_iter().partition(|piece| piece.closed);
    open.retain(|piece| piece.points.iter().any(|point| distance(*point, piece.points[0]) > tolerance));
    let mut loops: Vec<Loop> = closed.into_iter().map(|piece| piece.points).collect();
    let partners = partners(&open, tolerance)?;
    let mut used = vec![false; open.len()];
    for first in 0..open.len() {
        let mut points = Vec::new();
        // Enter each piece at one end and leave it at the other.
        let mut entry = 2 * first;
        while !used[entry / 2] {
            used[entry / 2] = true;
            let piece = &open[entry / 2].points;
            // Its end is the start of the next.
            let most = piece.len() - 1;
            match entry % 2 {
                0 => points.extend_from_slice(&piece[..most]),
                _ => points.extend(piece.iter().rev().take(most)),
            }
            entry = partners[entry ^ 1];
        }
        if !points.is_empty() {
            loops.push(points);
        }
    }
    for points in &mut loops {
        single(points, tolerance);
    }
    Ok(loops)
}

/// Takes repeated points out.
fn single(points: &mut Loop, tolerance: f64) {
    let near = |a: Point, b: Point| distance(a, b) <= SAME * tolerance;
    points.dedup_by(|next, kept| near(*next, *kept));
    while points.len() > 1 && points.last().is_some_and(|last| near(*last, points[0])) {
        points.pop();
    }
}

/// For each end, numbered twice its piece and one more at the last point, the end that it meets.
fn partners(open: &[Piece], tolerance: f64) -> Result<Vec<usize>, String> {
    let ends: Vec<Point> =
        open.iter().filter_map(|piece| Some([piece.points[0], *piece.points.last()?])).flatten().collect();
    let mut found = Vec::with_capacity(ends.len());
    for (index, end) in ends.iter().enumerate() {
        let others = || ends.iter().enumerate().filter(|(other, _)| *other != index);
        let mut meeting = others().filter(|(_, other)| distance(*end, **other) <= tolerance);
        let [x, y] = end;
        match (meeting.next(), meeting.next()) {
            (Some((partner, _)), None) => found.push(partner),
            (Some(_), Some(_)) => {
                return Err(format!(
                    "more than two lines meet at ({x}, {y}), or one lies on another; coordinates of the drawing"
                ));
            }
            (None, _) => {
                let nearest = others().map(|(_, other)| distance(*end, *other)).fold(f64::INFINITY, f64::min);
                return Err(format!(
                    "is open at ({x}, {y}): the next end is {nearest:.3e} away, where ends within {tolerance:.3e} are \
                     joined; coordinates of the drawing"
                ));
            }
        }
    }
    Ok(found)
}

/// The loops that each loop lies in; none of them cross.
///
/// # Errors
/// Where two loops cross or touch.
pub fn around(loops: &[Loop]) -> Result<Vec<Vec<usize>>, String> {
    for (index, one) in loops.iter().enumerate() {
        for other in &loops[index + 1..] {
            if let Some([x, y]) = crossing(one, other) {
                return Err(format!(
                    "two outlines cross or touch near ({x}, {y}); coordinates of the drawing"
                ));
            }
        }
    }
    let around = |index: usize| {
        let holds = |other: &usize| *other != index && encloses(&loops[*other], loops[index][0]);
        (0..loops.len()).filter(holds).collect()
    };
    Ok((0..loops.len()).map(around).collect())
}

fn edges(points: &Loop) -> impl Iterator<Item = (Point, Point)> {
    points.iter().copied().zip(points.iter().copied().cycle().skip(1))
}

/// Whether a ray from the point crosses the loop an odd number of times.
fn encloses(points: &Loop, [x, y]: Point) -> bool {
    let crossed = |(a, b): &(Point, Point)| {
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    edges(points).filter(crossed).count() % 2 == 1
}

/// A point near which edges of both loops have a point in common.
fn crossing(one: &Loop, other: &Loop) -> Option<Point> {
    let bounds = |points: &Loop| {
        points.iter().fold(([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]), |(low, high), point| {
            ([low[0].min(point[0]), low[1].min(point[1])], [high[0].max(point[0]), high[1].max(point[1])])
        })
    };
    let apart = |(low, high): ([f64; 2], [f64; 2]), (from, to): ([f64; 2], [f64; 2])| {
        (0..2).any(|axis| high[axis] < from[axis] || low[axis] > to[axis])
    };
    let whole = bounds(other);
    if apart(bounds(one), whole) {
        return None;
    }
    let side = |a: Point, b: Point, c: Point| {
        let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if cross == 0.0 { 0.0 } else { cross.signum() }
    };
    let boxed = |a: Point, b: Point| ([a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])]);
    for (a, b) in edges(one).filter(|(a, b)| !apart(boxed(*a, *b), whole)) {
        for (c, d) in edges(other).filter(|(c, d)| !apart(boxed(*c, *d), boxed(a, b))) {
            if side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 {
                return Some(c);
            }
        }
    }
    None
}
