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
    const CLOSEST: f64 = 0.75, "layers.closest",
        "distance of points of layers in space below which one of them is left out, likewise [-]";
}

/// Candidates along the distance of two points of a layer.
const CANDIDATES: f64 = 2.0;

/// Candidates along a block that is examined as a whole first.
const BLOCK: f64 = 8.0;

/// Distances at which candidates are taken in, one after the other until there are enough, in those of an even layer; what
/// is too close then spreads.
const DISTANCES: [f64; 4] = [0.9, 0.75, 0.6, 0.45];

/// Even layers at half, one and a half … of `depth` \[m\] from the faces.
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

/// A number from 0 to 2⁶⁴ for each place in an order that looks random.
fn shuffled(k: usize) -> u64 {
    SplitMix64((k as u64).wrapping_mul(SplitMix64::STEP)).bits()
}

/// Places on a layer, several for each point, and the volume \[m³\] that is nearest to it.
#[derive(Clone, Debug, Default)]
struct Candidates {
    places: Vec<Vector3<f64>>,
    volume: f64,
}

impl SpatialBoundary {
    /// The points of `layers`, outer layer first, as far as `keep` holds for them.
    pub(crate) fn layers(
        &self,
        layers: Layers,
        keep: impl Fn(&Vector3<f64>) -> bool + Sync,
    ) -> Vec<Vector3<f64>> {
        let mut crowd = Crowd::<Spatial>::new(CLOSEST * layers.depth.min(layers.along));
        let mut points = Vec::new();
        for (k, layer) in self.candidates_of(&layers, &keep).into_iter().enumerate() {
            let level = layers.side * (k as f64 + 0.5) * layers.depth;
            let chosen = chosen(&layer, &layers);
            let spread = self.spread(chosen, level, layers.along, &keep);
            points.extend(spread.into_iter().filter(|x| crowd.admit(x)));
        }
        points
    }

    /// Places on the layers.
    fn candidates_of(
        &self,
        layers: &Layers,
        keep: &(impl Fn(&Vector3<f64>) -> bool + Sync),
    ) -> Vec<Candidates> {
        let width = layers.along / CANDIDATES;
        let thickness = f64::from(layers.count) * layers.depth;
        let margin = if layers.side > 0.0 { thickness } else { 0.0 };
        let (lower, upper) = self.bounds();
        let lower = lower.add_scalar(-margin - width);
        let block = BLOCK * width;
        let blocks = ((upper - lower).add_scalar(margin + width) / block).map(|count| count.ceil().max(1.0));
        let steps =
            |count: f64| std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(move |k| *k < count);
        let corners: Vec<Vector3<f64>> = steps(blocks.z)
            .flat_map(|z| {
                steps(blocks.y).flat_map(move |y| steps(blocks.x).map(move |x| Vector3::new(x, y, z)))
            })
            .map(|index| lower + index * block)
            .collect();
        let reach = 0.5 * block * 3.0_f64.sqrt();
        let of_block = |corner: &Vector3<f64>| {
            let mut found: Vec<(usize, Option<Vector3<f64>>)> = Vec::new();
            let middle = layers.side * self.slope(&corner.add_scalar(0.5 * block)).0;
            if middle > thickness + reach || middle < -reach {
                return found;
            }
            for index in steps(BLOCK).flat_map(|z| {
                steps(BLOCK).flat_map(move |y| steps(BLOCK).map(move |x| Vector3::new(x, y, z)))
            }) {
                let x = corner + index.add_scalar(0.5) * width;
                let (distance, up) = self.slope(&x);
                let from_face = layers.side * distance / layers.depth;
                // The nearest layer, and how far off it is.
                let layer = (from_face - 0.5).round();
                if layer < 0.0 || layer >= f64::from(layers.count) {
                    continue;
                }
                let level = layers.side * (layer + 0.5) * layers.depth;
                let on_layer = x + up * (level - distance);
                // Of a face halfway between two rows of candidates both count: by round-off none would.
                let near = (level - distance).abs() <= (0.5 + 1e-6) * width && keep(&on_layer);
                if near || keep(&x) {
                    // Whole and small.
                    found.push((layer as usize, near.then_some(on_layer)));
                }
            }
            found
        };
        let found = tasks::flat_map(corners.len(), 1, |k| of_block(&corners[k]));
        let mut candidates = vec![Candidates::default(); layers.count as usize];
        for (layer, on_layer) in found {
            candidates[layer].volume += width.powi(3);
            candidates[layer].places.extend(on_layer);
        }
        candidates
    }

    /// Moves points of the layer at `level` \[m\] from the surface apart until they are spread evenly.
    fn spread(
        &self,
        mut points: Vec<Vector3<f64>>,
        level: f64,
        along: f64,
        keep: &(impl Fn(&Vector3<f64>) -> bool + Sync),
    ) -> Vec<Vector3<f64>> {
        let open =
            Domain::<Spatial> { lower: Vector3::zeros(), upper: Vector3::zeros(), periodic: [false; 3] };
        let reach = REACH * along;
        for _ in 0..STEPS {
            let list = CellGrid::new(&open, &points, reach).list(&open, &points, &points, reach);
            let moved = |k: usize| {
                let x = points[k];
                let push = |j: &u32| {
                    let d = x - points[*j as usize];
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
    let tolerance = 1e-6 * spacing;
    let (open, into_wall) = match side {
        Side::Outside(open) => (open, 1.0),
        Side::Inside => (OpenSides::default(), -1.0),
    };
    let beyond_open_side = |x: &Vector3<f64>| {
        (0..3).any(|axis| {
            (open.lower[axis] && x[axis] < lower[axis] - tolerance)
                || (open.upper[axis] && x[axis] > upper[axis] + tolerance)
        })
    };
    let keep = |x: &Vector3<f64>| shape.contains(x) == (side == Side::Inside) && !beyond_open_side(x);
    let outside = if side == Side::Inside { 0 } else { layers };
    let positions = match rows_of(shape, spacing, outside) {
        Some(rows) => {
            let thickness = f64::from(layers) * spacing;
            rows.points(|x| keep(x) && boundary.surface(x).distance.abs() < thickness)
        }
        None => {
            let layers = Layers { side: into_wall, depth: spacing, along: spacing, count: layers };
            boundary.layers(layers, keep)
        }
    };
    let particle = |position: Vector3<f64>| {
        let (_, outward) = face_normal(boundary, &position, spacing);
        LayerParticle { position, normal: outward * -into_wall }
    };
    tasks::map(positions.len(), 64, |k| particle(positions[k]))
}

/// Points among `candidates`, as many as the layer has room for, in no order.
fn chosen(candidates: &Candidates, layers: &Layers) -> Vec<Vector3<f64>> {
    let enough = candidates.volume / (layers.depth * layers.along * layers.along);
    let candidates = &candidates.places;
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    order.sort_unstable_by_key(|k| shuffled(*k));
    let mut points: Vec<Vector3<f64>> = Vec::new();
    for distance in DISTANCES {
        let mut crowd = Crowd::<Spatial>::new(distance * layers.along);
        points.iter().for_each(|x| crowd.take(x));
        for k in &order {
            if points.len() as f64 >= enough.round() {
                return points;
            }
            if crowd.admit(&candidates[*k]) {
                points.push(candidates[*k]);
            }
        }
    }
    points
}
