//! Points in even layers along the faces of a shape in space.

use nalgebra::Vector3;

use super::SpatialBoundary;
use super::box_rows::rows_of;
use crate::neighbours::CellGrid;
use crate::random::SplitMix64;
use crate::shapes::SpatialShape;
use crate::shapes::crowd::Crowd;
use crate::shapes::lattice::face_normal;
use crate::shapes::{Faces, LayerParticle, OpenSides, Region, Side};
use crate::space::Spatial;
use crate::space::domain::Domain;
use crate::tasks;

crate::constants! {
    /// The second neighbours of a hexagonal layer are farther.
    const REACH: f64 = 1.5, "layers.reach",
        "distance within which points of a layer in space push each other away, in that of an even layer [-]";
    const STEPS: usize = 40, "layers.steps",
        "steps in which the points of a layer in space spread [-]";
    const LARGEST_STEP: f64 = 0.1, "layers.largest_step",
        "largest move of a point of a layer in space in one step, in the distance of an even layer [-]";
    /// Behind edges they belong to another face.
    const OFF: f64 = 0.05, "layers.off",
        "distance off their layer in space of points that are left out, in the distance of an even layer [-]";
    const FROM_END: f64 = 0.2, "layers.from_end",
        "distance from the end of an open layer in space from which points are placed, likewise [-]";
    const CLOSEST: f64 = 0.75, "layers.closest",
        "distance of points of layers in space below which one of them is left out, likewise [-]";
    /// Candidates of one layer may coincide.
    const DISORDER: f64 = 0.3, "layers.disorder",
        "largest displacement along each axis of points of a layer in space before they spread, likewise [-]";
    const CURVATURE_STEP: f64 = 0.25, "layers.curvature_step",
        "half the way over which the curvature of a layer in space is taken, in the depth of a layer [-]";
    /// Near edges and in corners the curvature is not that of a face.
    const LARGEST_WAY: f64 = 0.1, "layers.largest_way",
        "largest distance of points of a layer in space from its middle, in the depth of a layer [-]";
}

/// Candidates along the distance of two points of a layer.
const CANDIDATES: f64 = 2.0;

/// Candidates along a block that is examined as a whole first, as a power of two.
const BLOCK_BITS: u32 = 3;

/// Even layers whose middles are at half, one and a half … of `depth` \[m\] from the faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layers {
    /// −1 inside the shape, 1 outside.
    pub side: f64,
    /// From layer to layer \[m\].
    pub depth: f64,
    /// Distance of points within a layer \[m\].
    pub along: f64,
    /// Number of layers.
    pub count: u32,
}

/// A plane across an axis at which layers end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    axis: usize,
    /// Place of the plane \[m\].
    at: f64,
    /// 1 when layers lie toward higher coordinates, −1 otherwise.
    inward: f64,
}

impl End {
    /// Distance of `x` \[m\] from the plane, positive where layers lie \[m\].
    fn depth(&self, x: &Vector3<f64>) -> f64 {
        self.inward * (x[self.axis] - self.at)
    }

    /// `x` \[m\] mirrored at the plane.
    fn image(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let mut image = *x;
        image[self.axis] = 2.0 * self.at - x[self.axis];
        image
    }
}

/// A place on a layer, and the volume \[m³\] for which it stands.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    place: Vector3<f64>,
    volume: f64,
}

impl SpatialBoundary {
    /// The points of `layers` at the centroids of their cells, outer layer first, as far as `keep` holds for them, up to `ends`.
    pub(crate) fn layers(
        &self,
        layers: Layers,
        ends: &[End],
        keep: impl Fn(&Vector3<f64>) -> bool + Sync,
    ) -> Vec<Vector3<f64>> {
        let mut crowd = Crowd::<Spatial>::new(CLOSEST * layers.depth.min(layers.along));
        let mut points = Vec::new();
        let ended = |x: &Vector3<f64>, depth: f64| ends.iter().any(|end| end.depth(x) < depth);
        let candidates = self.candidates_of(&layers, ends);
        for (k, layer) in candidates.into_iter().enumerate() {
            let level = layers.side * (k as f64 + 0.5) * layers.depth;
            // Not on an end, where a point and its image would not part.
            let chosen =
                self.chosen(&layer, &layers, level, &|x| keep(x) && !ended(x, FROM_END * layers.along));
            let spread = self.spread(chosen, level, layers.along, ends, &|x| keep(x) && !ended(x, 0.0));
            let centred = tasks::map(spread.len(), 64, |k| spread[k] + self.to_centroid(&spread[k], &layers));
            points.extend(centred.into_iter().filter(|x| crowd.admit(x)));
        }
        points
    }

    /// Places on each of the layers, near ones after each other.
    fn candidates_of(&self, layers: &Layers, ends: &[End]) -> Vec<Vec<Candidate>> {
        let width = layers.along / CANDIDATES;
        let thickness = f64::from(layers.count) * layers.depth;
        let margin = if layers.side > 0.0 { thickness } else { 0.0 };
        let (lower, upper) = self.bounds();
        let lower = lower.add_scalar(-margin - width);
        let block = f64::from(1_u32 << BLOCK_BITS) * width;
        let blocks = ((upper - lower).add_scalar(margin + width) / block).map(|count| count.ceil().max(1.0));
        let steps =
            |count: f64| std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(move |k| *k < count);
        let corners: Vec<Vector3<f64>> = steps(blocks.z)
            .flat_map(|z| {
                steps(blocks.y).flat_map(move |y| steps(blocks.x).map(move |x| Vector3::new(x, y, z)))
            })
            .map(|index| lower + index * block)
            .collect();
        let reach = 0.5 * (block * 3.0_f64.sqrt() + width);
        // Shares of the cube of a candidate in the layers, as if it stood square to them.
        let shares = |from_face: f64| {
            let half = 0.5 * width / layers.depth;
            let first = (from_face - half).floor().max(0.0);
            steps(f64::from(layers.count)).skip_while(move |k| *k < first).map_while(move |k| {
                let share = ((from_face + half).min(k + 1.0) - (from_face - half).max(k)) / (2.0 * half);
                (share > 0.0).then_some((k, share))
            })
        };
        let of_block = |corner: &Vector3<f64>| {
            let mut found: Vec<(usize, Candidate)> = Vec::new();
            let middle = layers.side * self.slope(&corner.add_scalar(0.5 * block)).0;
            if middle > thickness + reach || middle < -reach {
                return found;
            }
            for index in (0..1_u32 << (3 * BLOCK_BITS)).map(along_curve) {
                let x = corner + index.add_scalar(0.5) * width;
                let (distance, up) = self.slope(&x);
                let before_ends: f64 =
                    ends.iter().map(|end| (end.depth(&x) / width + 0.5).clamp(0.0, 1.0)).product();
                for (layer, share) in shares(layers.side * distance / layers.depth) {
                    let level = layers.side * (layer + 0.5) * layers.depth;
                    let volume = share * before_ends * width.powi(3);
                    // Whole and small.
                    found.push((layer as usize, Candidate { place: x + up * (level - distance), volume }));
                }
            }
            found
        };
        let found = tasks::flat_map(corners.len(), 1, |k| of_block(&corners[k]));
        let mut candidates = vec![Vec::new(); layers.count as usize];
        for (layer, candidate) in found {
            candidates[layer].push(candidate);
        }
        candidates
    }

    /// Points among the `candidates` of the layer at `level` \[m\] for which `keep` holds, as many as it has room for, each
    /// with as much volume before it as the one before: patches of all sizes and slopes have their share.
    fn chosen(
        &self,
        candidates: &[Candidate],
        layers: &Layers,
        level: f64,
        keep: &impl Fn(&Vector3<f64>) -> bool,
    ) -> Vec<Vector3<f64>> {
        let volume: f64 = candidates.iter().map(|candidate| candidate.volume).sum();
        let enough = (volume / (layers.depth * layers.along * layers.along)).round();
        let mut random = SplitMix64(0);
        let (mut points, mut before) = (Vec::new(), 0.0);
        for Candidate { place, volume: own } in candidates {
            before += own;
            let due = (before / volume * enough - 0.5).floor() + 1.0;
            if (points.len() as f64) < due && keep(place) {
                let shift = Vector3::from_fn(|_, _| random.symmetric()) * (DISORDER * layers.along);
                let shifted = self.on_level(&(place + shift), level);
                points.push(if keep(&shifted) { shifted } else { *place });
            }
        }
        points
    }

    /// From a point of a layer to the centroid of its cell, which is thicker on the far side of a bend.
    ///
    /// Of a layer of depth d between curved faces, in cells a wide, the centroid lies (κ₁ + κ₂)(d²/12 − a²/24) from the middle,
    /// with κ₁ + κ₂ = ∇·n the curvatures.
    fn to_centroid(&self, x: &Vector3<f64>, layers: &Layers) -> Vector3<f64> {
        let step = CURVATURE_STEP * layers.depth;
        let up = |x: Vector3<f64>| self.slope(&x).1;
        let bend: f64 = (0..3)
            .map(|axis| {
                let along = Vector3::ith(axis, step);
                (up(x + along)[axis] - up(x - along)[axis]) / (2.0 * step)
            })
            .sum();
        let way = bend * (layers.depth.powi(2) / 12.0 - layers.along.powi(2) / 24.0);
        up(*x) * way.clamp(-LARGEST_WAY * layers.depth, LARGEST_WAY * layers.depth)
    }

    /// Moves points of the layer at `level` \[m\] from the surface apart until they are spread evenly. Beyond `ends` their
    /// images continue the layer.
    fn spread(
        &self,
        mut points: Vec<Vector3<f64>>,
        level: f64,
        along: f64,
        ends: &[End],
        keep: &(impl Fn(&Vector3<f64>) -> bool + Sync),
    ) -> Vec<Vector3<f64>> {
        let open =
            Domain::<Spatial> { lower: Vector3::zeros(), upper: Vector3::zeros(), periodic: [false; 3] };
        let reach = REACH * along;
        for _ in 0..STEPS {
            let images = ends
                .iter()
                .flat_map(|end| points.iter().filter(|x| end.depth(x) < reach).map(|x| end.image(x)));
            let others: Vec<Vector3<f64>> = points.iter().copied().chain(images).collect();
            let list = CellGrid::new(&open, &others, reach).list(&open, &points, &others, reach);
            let moved = |k: usize| {
                let x = points[k];
                let push = |j: &u32| {
                    let d = x - others[*j as usize];
                    let r = d.norm();
                    if r > 0.0 { d * ((1.0 - r / reach).max(0.0).powi(2) / r) } else { Vector3::zeros() }
                };
                let push: Vector3<f64> = list.of(k).iter().map(push).sum();
                let step = (push * along).cap_magnitude(LARGEST_STEP * along);
                let tried = self.on_level(&(x + step), level);
                if keep(&tried) { tried } else { x }
            };
            points = tasks::map(points.len(), 64, moved);
        }
        let off = |x: &Vector3<f64>| (self.slope(x).0 - level).abs();
        tasks::flat_map(points.len(), 64, |k| Some(points[k]).filter(|x| off(x) <= OFF * along))
    }

    /// `x` moved straight to or from the nearest face until it is `level` \[m\] from it.
    fn on_level(&self, x: &Vector3<f64>, level: f64) -> Vector3<f64> {
        let (distance, up) = self.slope(x);
        x + up * (level - distance)
    }
}

/// Wall particles in layers along the faces of `boundary`, normals out of the wall.
pub(in crate::shapes::spatial) fn along(
    shape: &SpatialShape,
    boundary: &SpatialBoundary,
    spacing: f64,
    layers: u32,
    side: Side<Spatial>,
) -> Vec<LayerParticle<Spatial>> {
    let (lower, upper) = shape.bounds();
    let (open, into_wall) = match side {
        Side::Outside(open) => (open, 1.0),
        Side::Inside => (OpenSides::default(), -1.0),
    };
    let end = |axis: usize, at: f64, inward: f64| End { axis, at, inward };
    let lower_ends = (0..3).filter(|axis| open.lower[*axis]).map(|axis| end(axis, lower[axis], 1.0));
    let upper_ends = (0..3).filter(|axis| open.upper[*axis]).map(|axis| end(axis, upper[axis], -1.0));
    let ends: Vec<End> = lower_ends.chain(upper_ends).collect();
    let on_side = |x: &Vector3<f64>| shape.contains(x) == (side == Side::Inside);
    let outside = if side == Side::Inside { 0 } else { layers };
    let positions = match rows_of(shape, spacing, outside) {
        Some(rows) => {
            let thickness = f64::from(layers) * spacing;
            let ended = |x: &Vector3<f64>| ends.iter().any(|end| end.depth(x) < -1e-6 * spacing);
            rows.points(|x| on_side(x) && !ended(x) && boundary.surface(x).distance.abs() < thickness)
        }
        None => {
            let layers = Layers { side: into_wall, depth: spacing, along: spacing, count: layers };
            boundary.layers(layers, &ends, on_side)
        }
    };
    let particle = |position: Vector3<f64>| {
        let (_, outward) = face_normal(boundary, &position, spacing);
        LayerParticle { position, normal: outward * -into_wall }
    };
    tasks::map(positions.len(), 64, |k| particle(positions[k]))
}

/// Coordinates of the candidates of a block along a curve on which near ones follow each other (Morton 1966).
fn along_curve(k: u32) -> Vector3<f64> {
    let coordinate = |axis: u32| (0..BLOCK_BITS).map(|bit| (k >> (3 * bit + axis) & 1) << bit).sum::<u32>();
    Vector3::new(0, 1, 2).map(|axis| f64::from(coordinate(axis)))
}
