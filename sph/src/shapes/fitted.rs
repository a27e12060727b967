//! Wall particles in layers along the boundary of a shape, whatever its slope.
//!
//! On the square lattice a slanted or curved wall is a staircase: water meets its steps, not the face. Here each layer
//! is the boundary offset by its depth, with mitred corners, and particles stand along it at even distances as close to
//! the spacing as its length allows. Where the boundary runs along the lattice both ways give the same particles.

mod stations;

use std::collections::HashMap;

use super::boundary::{Boundary, CORNER_ANGLE};
use super::crowd::{Crowd, around, cell};
use super::lattice::face_normal;
use super::region::{LayerParticle, OpenSides, Region, Side};
use crate::shapes::Shape;
use crate::space::{Plane, Space, Vector};
use stations::{spread, stations_on_loop};

crate::constants! {
    const CLOSENESS: f64 = 0.75, "fitted.closest",
        "distance of fitted particles of two faces below which one of them is left out, in spacings [-]";
    /// Nearer ones belong to a face on the other side of a sharp corner.
    const SLACK: f64 = 0.15, "fitted.slack",
        "distance by which a fitted particle may lie nearer to the boundary than its layer, in spacings [-]";
    /// Behind sharper corners the layers end.
    const LONGEST_MITRE: f64 = 2.0, "fitted.longest_mitre",
        "longest mitre of fitted layers in units of their depth [-]";
}

/// Nearness of particles to a face that another wall covers, in units of the spacing: that wall's own stand half a
/// spacing behind the face.
const CLEARANCE: f64 = CLOSENESS - 0.5;

/// Particles of `layers` layers along the given `boundary` of `shape`, outer layer first.
///
/// Normals point away from the wall, as those of [`super::layers_around`] and [`super::wall_fill`]. In the plane layers have
/// mitred corners; in space they are all that is as far from the faces, rounded behind edges.
pub fn layers_along<S: Space, R: Region<S>>(
    shape: &R,
    boundary: &R::Boundary,
    spacing: f64,
    layers: u32,
    side: Side<S>,
) -> Vec<LayerParticle<S>> {
    shape.layers_along(boundary, spacing, layers, side)
}

/// [`layers_along`] in the plane.
pub(super) fn along_lines(
    shape: &Shape,
    boundary: &Boundary,
    spacing: f64,
    layers: u32,
    side: Side,
) -> Vec<LayerParticle> {
    let (lower, upper) = shape.bounds();
    let tolerance = 1e-6 * spacing;
    let open = match side {
        Side::Outside(open) => open,
        Side::Inside => OpenSides::default(),
    };
    let on_open_side = |edge: &[Vector]| {
        (0..2).any(|axis| {
            let at = |plane: f64| edge.iter().all(|x| (x[axis] - plane).abs() < tolerance);
            (open.lower[axis] && at(lower[axis])) || (open.upper[axis] && at(upper[axis]))
        })
    };
    let beyond_open_side = |x: &Vector| {
        (0..2).any(|axis| {
            (open.lower[axis] && x[axis] < lower[axis] - tolerance)
                || (open.upper[axis] && x[axis] > upper[axis] + tolerance)
        })
    };
    let into_wall = if side == Side::Inside { -1.0 } else { 1.0 };
    let thickness = f64::from(layers) * spacing;
    let whole = shape.boundary();
    let chord = 0.05 * spacing;
    let mut lines = polylines(boundary.traced(chord), tolerance, on_open_side);
    let edges = whole.traced(chord);
    lines.iter_mut().for_each(|line| line.end_at(&edges, tolerance));
    let mut crowd = Crowd::<Plane>::new(CLOSENESS * spacing);
    let mut particles = Vec::new();
    for layer in 0..layers {
        let depth = (f64::from(layer) + 0.5) * spacing;
        for position in lines.iter().flat_map(|line| line.stations(depth, into_wall, spacing)) {
            let (distance, outward) = face_normal(boundary, &position, spacing);
            let in_layers = distance >= depth - SLACK * spacing && distance < thickness + tolerance;
            let right_side = shape.contains(&position) == (side == Side::Inside);
            // A face that is covered has no layer, but another wall behind it.
            let clear = whole.surface(&position).distance.abs() >= CLEARANCE * spacing - tolerance;
            if in_layers && clear && right_side && !beyond_open_side(&position) && crowd.admit(&position) {
                particles.push(LayerParticle { position, normal: outward * -into_wall });
            }
        }
    }
    particles
}

/// Points of `layers` layers inside the shape of `boundary`: `depth` \[m\] from layer to layer, the first half of it from the face, and
/// `along` \[m\] apart in a layer.
pub(super) fn layers_within(boundary: &Boundary, depth: f64, along: f64, layers: u32) -> Vec<Vector> {
    let lines = polylines(boundary.traced(0.05 * along), 1e-6 * along, |_| false);
    let mut crowd = Crowd::<Plane>::new(CLOSENESS * depth.min(along));
    let mut points = Vec::new();
    for layer in 0..layers {
        let below = (f64::from(layer) + 0.5) * depth;
        for x in lines.iter().flat_map(|line| line.stations(below, -1.0, along)) {
            let surface = boundary.surface(&x);
            if -surface.distance >= below - SLACK * depth && crowd.admit(&x) {
                points.push(x);
            }
        }
    }
    points
}

/// Whether every edge of `boundary` runs between two rows of the lattice of `spacing` \[m\] that starts at `origin` \[m\],
/// within a millionth of the spacing; edges for which `left_out` holds, given their points, do not count.
pub fn is_on_lattice(
    boundary: &Boundary,
    spacing: f64,
    origin: Vector,
    left_out: impl Fn(&[Vector]) -> bool,
) -> bool {
    let between_rows = |a: &Vector, b: &Vector| {
        (0..2).any(|axis| {
            let rows = (a[axis] - origin[axis]) / spacing;
            (a[axis] - b[axis]).abs() < 1e-6 * spacing && (rows - rows.round()).abs() < 1e-6
        })
    };
    boundary
        .traced(spacing)
        .iter()
        .filter(|edge| !left_out(edge))
        .all(|edge| edge.windows(2).all(|pair| between_rows(&pair[0], &pair[1])))
}

/// A connected part of the boundary, with the shape on its left.
struct Polyline {
    points: Vec<Vector>,
    closed: bool,
    /// Directions of the edges of the shape that lead to the start and away from the end and bear no layers, being
    /// covered or open.
    bare: [Option<Vector>; 2],
}

/// Joins `edges` end to start; those for which `leave_out` says so are not part of the wall.
fn polylines(
    edges: Vec<Vec<Vector>>,
    tolerance: f64,
    leave_out: impl Fn(&[Vector]) -> bool,
) -> Vec<Polyline> {
    let mut edges: Vec<Option<Vec<Vector>>> =
        edges.into_iter().filter(|edge| !leave_out(edge)).map(Some).collect();
    let ends = |edge: &[Vector]| (edge[0], edge[edge.len() - 1]);
    let mut starts: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut finishes: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (k, edge) in edges.iter().flatten().enumerate() {
        let (start, end) = ends(edge);
        starts.entry(cell::<Plane>(&start, tolerance)).or_default().push(k);
        finishes.entry(cell::<Plane>(&end, tolerance)).or_default().push(k);
    }
    let met = |x: &Vector, places: &HashMap<[i64; 3], Vec<usize>>| -> Vec<usize> {
        around::<Plane>(cell::<Plane>(x, tolerance))
            .filter_map(|c| places.get(&c))
            .flatten()
            .copied()
            .collect()
    };
    // Open lines first, from their free starts; what is left is closed.
    let free: Vec<usize> = (0..edges.len())
        .filter(|k| edges[*k].as_ref().is_some_and(|edge| met(&edge[0], &finishes).is_empty()))
        .collect();
    let mut lines = Vec::new();
    for first in free.into_iter().chain(0..edges.len()) {
        let Some(mut points) = edges[first].take() else { continue };
        loop {
            let end = points[points.len() - 1];
            let next = met(&end, &starts).into_iter().find(|k| edges[*k].is_some());
            let Some(edge) = next.and_then(|k| edges[k].take()) else { break };
            points.extend_from_slice(&edge[1..]);
        }
        let closed = (points[0] - points[points.len() - 1]).norm() < 2.0 * tolerance;
        if closed {
            points.pop();
        }
        lines.push(Polyline { points, closed, bare: [None; 2] });
    }
    lines
}

impl Polyline {
    /// Finds among all `edges` of the shape those that continue beyond a free end.
    fn end_at(&mut self, edges: &[Vec<Vector>], tolerance: f64) {
        if self.closed {
            return;
        }
        let (start, end) = (self.points[0], self.points[self.points.len() - 1]);
        let meets = |a: &Vector, b: &Vector| (a - b).norm() < 2.0 * tolerance;
        let direction = |a: Vector, b: Vector| (b - a).try_normalize(0.0);
        let before = edges.iter().find(|edge| meets(&edge[edge.len() - 1], &start));
        let after = edges.iter().find(|edge| meets(&edge[0], &end));
        self.bare = [
            before.and_then(|edge| direction(edge[edge.len() - 2], edge[edge.len() - 1])),
            after.and_then(|edge| direction(edge[0], edge[1])),
        ];
    }

    fn at(&self, k: usize) -> Vector {
        self.points[k % self.points.len()]
    }

    /// Directions of the segments that meet at point `k`, before and after it; one is missing at a free end.
    fn directions(&self, k: usize) -> (Option<Vector>, Option<Vector>) {
        let n = self.points.len();
        let k = k % n;
        let unit = |a: Vector, b: Vector| (b - a).try_normalize(0.0);
        let before = (k > 0 || self.closed).then(|| unit(self.at(k + n - 1), self.at(k))).flatten();
        let after = (k + 1 < n || self.closed).then(|| unit(self.at(k), self.at(k + 1))).flatten();
        (before, after)
    }

    fn is_corner(&self, k: usize) -> bool {
        match self.directions(k) {
            (Some(before), Some(after)) => before.dot(&after) < CORNER_ANGLE.cos(),
            _ => false,
        }
    }

    /// Point `k` moved by `depth` \[m\] into the wall, on the line of the segment after it, or before it.
    ///
    /// Offset lines of two segments meet at d (m₁ + m₂)/(1 + m₁·m₂) from their common point, m their normals.
    fn offset(&self, k: usize, depth: f64, into_wall: f64, of_segment_before: bool) -> Vector {
        let normal = |t: Vector| Vector::new(t.y, -t.x) * into_wall;
        let x = self.at(k);
        match self.directions(k) {
            (Some(before), Some(after)) => {
                let (m, n) = (normal(before), normal(after));
                let (own, other, along) = if of_segment_before { (m, n, before) } else { (n, m, -after) };
                let mitre = other.dot(&along) / (1.0 + m.dot(&n)).max(1e-9);
                x + own * depth + along * (depth * mitre.min(LONGEST_MITRE))
            }
            // On the line of the bare edge, where there is one.
            (Some(t), None) => x + beside(t, normal(t), self.bare[1]) * depth,
            (None, Some(t)) => x + beside(t, normal(t), self.bare[0]) * depth,
            (None, None) => x,
        }
    }

    /// Where particles of the layer at `depth` \[m\] stand.
    fn stations(&self, depth: f64, into_wall: f64, spacing: f64) -> Vec<Vector> {
        let n = self.points.len();
        let corners: Vec<usize> = (0..n).filter(|k| self.is_corner(*k)).collect();
        let mut stations = Vec::new();
        let mut run = |from: usize, to: usize, from_corner: bool, to_corner: bool| {
            let line: Vec<Vector> = (from..=to).map(|k| self.offset(k, depth, into_wall, k == to)).collect();
            // A run that a corner on each side has used up points backwards.
            let (chord, inset) = (self.at(to) - self.at(from), line[line.len() - 1] - line[0]);
            if to == from + 1 && chord.dot(&inset) < 0.0 {
                return;
            }
            stations.extend(spread(&line, from_corner, to_corner, spacing));
        };
        match (corners.first(), self.closed) {
            (None, true) => stations_on_loop(
                &(0..=n).map(|k| self.offset(k, depth, into_wall, false)).collect::<Vec<_>>(),
                spacing,
                &mut stations,
            ),
            (Some(&first), true) => {
                let ends = corners.iter().skip(1).copied().chain([first + n]);
                corners.iter().zip(ends).for_each(|(from, to)| run(*from, to, true, true));
            }
            (_, false) => {
                let starts = std::iter::once(0).chain(corners.iter().copied());
                let ends = corners.iter().copied().chain([n - 1]);
                for (from, to) in starts.zip(ends) {
                    run(from, to, from != 0, to != n - 1);
                }
            }
        }
        stations
    }
}

/// From the end of a line of direction `t` to that of its layer at unit depth, which lies on the line of direction `bare`.
fn beside(t: Vector, into_wall: Vector, bare: Option<Vector>) -> Vector {
    let skew = bare.map_or(0.0, |c| c.dot(&t) / c.dot(&into_wall));
    // A bare edge that goes straight on has no place at that depth.
    into_wall + if skew.abs() < LONGEST_MITRE { t * skew } else { Vector::zeros() }
}

impl Boundary {
    /// The edges as chains of points with the shape on their left; arcs in chords of at most `chord` \[m\].
    fn traced(&self, chord: f64) -> Vec<Vec<Vector>> {
        self.edges().iter().map(|edge| edge.traced(chord)).collect()
    }
}

#[cfg(test)]
mod tests;
