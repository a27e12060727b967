//! Curves in which the faces of a composed shape meet, and their corners.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::SpatialBoundary;
use crate::shapes::boundary::ROUND_OFF;
use crate::shapes::spatial::envelope;
use crate::tasks;

/// Samples along the diagonal of the shape by which curves are sought.
const ALONG: f64 = 64.0;

/// Steps in which a point moves onto two or three faces; each squares the distance.
const STEPS: usize = 24;

/// Rounds in which the nearest point of a curve is sought; each takes a twentieth of the interval of the one before.
const ROUNDS: usize = 4;

/// Curves and corners.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    curves: Vec<Curve>,
    corners: Vec<(Vector3<f64>, [usize; 3])>,
    /// Points of the boundary for when nothing else is known.
    spare: Vec<Vector3<f64>>,
}

/// Points of the curve in which two faces meet, so many that the nearest to any place is within `apart` along the curve.
#[derive(Clone, Debug)]
struct Curve {
    faces: [usize; 2],
    points: Vec<Vector3<f64>>,
    apart: f64,
}

/// The nearest place of the curves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub point: Vector3<f64>,
    normals: [Vector3<f64>; 3],
    count: usize,
}

impl Place {
    /// Outward normals of the faces that meet here.
    pub fn normals(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.normals.into_iter().take(self.count)
    }
}

/// Samples of a face with the box around them.
struct Samples {
    points: Vec<Vector3<f64>>,
    apart: f64,
    bounds: (Vector3<f64>, Vector3<f64>),
}

impl Curves {
    /// Those of `boundary`, the middle of whose box is `middle`.
    pub fn of(boundary: &SpatialBoundary, middle: &Vector3<f64>) -> Self {
        let size = boundary.size();
        let samples: Vec<Samples> = boundary
            .faces()
            .iter()
            .map(|face| {
                let (points, apart) = face.samples(size / ALONG, middle, 0.5 * size);
                let (lower, upper) = envelope(points.iter().map(|x| (*x, *x)));
                Samples { points, apart, bounds: (lower.add_scalar(-apart), upper.add_scalar(apart)) }
            })
            .collect();
        let pairs: Vec<[usize; 2]> = (0..samples.len())
            .flat_map(|i| (i + 1..samples.len()).map(move |j| [i, j]))
            .filter(|[i, j]| meet(&samples[*i].bounds, &samples[*j].bounds))
            .collect();
        let curves = tasks::flat_map(pairs.len(), 1, |k| curve(boundary, &samples, pairs[k]));
        let corners = tasks::flat_map(curves.len(), 1, |k| corners(boundary, &samples, &curves[k]));
        let spare = tasks::flat_map(samples.len(), 1, |k| {
            let face = &boundary.faces()[k];
            samples[k]
                .points
                .iter()
                .filter(|x| boundary.outward(x, &face.nearest(x).normal).is_some())
                .copied()
        });
        Self { curves, corners, spare }
    }

    /// The nearest places of curves and corners nearer than `nearest`, given the `distances` of all faces from `point`.
    pub fn nearest(
        &self,
        boundary: &SpatialBoundary,
        point: &Vector3<f64>,
        distances: &[f64],
        mut nearest: f64,
    ) -> Option<Place> {
        // A curve is no nearer than either of its faces.
        let may_be_nearer = |faces: &[usize], nearest: f64| faces.iter().all(|k| distances[*k] < nearest);
        let mut place = None;
        let mut consider = |x: Vector3<f64>, faces: &[usize], nearest: &mut f64| {
            let distance = (x - point).norm();
            if distance < *nearest {
                let found = place_of(boundary, x, faces);
                if found.count > 0 {
                    (*nearest, place) = (distance, Some(found));
                }
            }
        };
        for (x, faces) in &self.corners {
            if may_be_nearer(faces, nearest) {
                consider(*x, faces, &mut nearest);
            }
        }
        for curve in &self.curves {
            if !may_be_nearer(&curve.faces, nearest) {
                continue;
            }
            let squared = |x: &Vector3<f64>| (x - point).norm_squared();
            let seed = curve.points.iter().min_by(|a, b| squared(a).total_cmp(&squared(b)));
            let Some(seed) = seed.filter(|seed| (*seed - point).norm() < nearest + curve.apart) else {
                continue;
            };
            if let Some(x) = curve.along(boundary, point, seed) {
                consider(x, &curve.faces, &mut nearest);
            }
            consider(*seed, &curve.faces, &mut nearest);
        }
        if nearest.is_infinite() {
            let squared = |x: &Vector3<f64>| (x - point).norm_squared();
            let spare = self.spare.iter().min_by(|a, b| squared(a).total_cmp(&squared(b)));
            return spare.map(|x| {
                let normal = (point - x).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
                Place { point: *x, normals: [normal; 3], count: 1 }
            });
        }
        place
    }
}

impl Curve {
    /// The nearest point to `point` of the curve about `seed`, by parabolas through three points of the curve.
    fn along(
        &self,
        boundary: &SpatialBoundary,
        point: &Vector3<f64>,
        seed: &Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let squared = |x: &Vector3<f64>| (x - point).norm_squared();
        let (mut x, mut step) = (*seed, self.apart);
        for _ in 0..ROUNDS {
            let [a, b] = self.faces.map(|k| boundary.faces()[k].nearest(&x).normal);
            let along = a.cross(&b).try_normalize(1e-9)?;
            let at = |s: f64| onto(boundary, &self.faces, x + along * s, ROUND_OFF * boundary.size());
            let (Some(before), Some(after)) = (at(-step), at(step)) else { break };
            let (left, middle, right) = (squared(&before), squared(&x), squared(&after));
            let bend = left - 2.0 * middle + right;
            let shift = if bend > 0.0 { (0.5 * (left - right) / bend).clamp(-1.0, 1.0) } else { 0.0 };
            let tried = [at(shift * step), Some(before), Some(after)].into_iter().flatten();
            let best = tried.min_by(|a, b| squared(a).total_cmp(&squared(b)))?;
            if squared(&best) <= middle {
                x = best;
            }
            step *= 0.05;
        }
        Some(x)
    }
}

fn meet(a: &(Vector3<f64>, Vector3<f64>), b: &(Vector3<f64>, Vector3<f64>)) -> bool {
    (0..3).all(|axis| a.0[axis] <= b.1[axis] && b.0[axis] <= a.1[axis])
}

/// The place `x` of `faces` with the normals of those that nothing covers there.
fn place_of(boundary: &SpatialBoundary, x: Vector3<f64>, faces: &[usize]) -> Place {
    let mut place = Place { point: x, normals: [Vector3::zeros(); 3], count: 0 };
    for k in faces {
        let normal = boundary.faces()[*k].nearest(&x).normal;
        if let Some(sign) = boundary.outward(&x, &normal) {
            place.normals[place.count] = normal * sign;
            place.count += 1;
        }
    }
    place
}

/// The point near `x` that lies on all of two or three `faces`, by Newton's method.
fn onto(
    boundary: &SpatialBoundary,
    faces: &[usize],
    mut x: Vector3<f64>,
    tolerance: f64,
) -> Option<Vector3<f64>> {
    for _ in 0..STEPS {
        let mut directions = [Vector3::zeros(); 3];
        let mut missing = Vector3::zeros();
        let mut farthest: f64 = 0.0;
        for (k, face) in faces.iter().enumerate() {
            let near = boundary.faces()[*face].nearest(&x);
            let to_face = near.point - x;
            let distance = to_face.norm();
            // Beside the edge of a face the way to it is not along its normal.
            (directions[k], missing[k]) = if distance > tolerance {
                (to_face / distance, distance)
            } else {
                (near.normal, to_face.dot(&near.normal))
            };
            farthest = farthest.max(distance);
        }
        if farthest <= 1e-3 * tolerance {
            return Some(x);
        }
        let [a, b, c] = directions;
        let step = if faces.len() == 2 {
            let cosine = a.dot(&b);
            let parts =
                Matrix2::new(1.0, cosine, cosine, 1.0).try_inverse()? * Vector2::new(missing.x, missing.y);
            a * parts.x + b * parts.y
        } else {
            Matrix3::from_rows(&[a.transpose(), b.transpose(), c.transpose()]).try_inverse()? * missing
        };
        if !step.norm().is_finite() || step.norm() > boundary.size() {
            return None;
        }
        let still = step.norm() <= 1e-6 * tolerance;
        x += step;
        if still {
            return (farthest <= tolerance).then_some(x);
        }
    }
    let off = |k: &usize| (boundary.faces()[*k].nearest(&x).point - x).norm();
    faces.iter().all(|k| off(k) <= tolerance).then_some(x)
}

/// The curve in which two faces meet, as far as it belongs to the boundary.
fn curve(boundary: &SpatialBoundary, samples: &[Samples], faces: [usize; 2]) -> Option<Curve> {
    let tolerance = ROUND_OFF * boundary.size();
    let mut points: Vec<Vector3<f64>> = Vec::new();
    let apart = faces.map(|k| samples[k].apart);
    let apart = apart[0].min(apart[1]);
    for (own, other) in [(faces[0], faces[1]), (faces[1], faces[0])] {
        let (reach, bounds) = (samples[own].apart, &samples[other].bounds);
        for x in &samples[own].points {
            let beyond =
                (0..3).any(|axis| x[axis] < bounds.0[axis] - reach || x[axis] > bounds.1[axis] + reach);
            if beyond || (boundary.faces()[other].nearest(x).point - x).norm() > reach {
                continue;
            }
            let Some(x) = onto(boundary, &faces, *x, tolerance) else { continue };
            let known = points.iter().any(|y| (x - y).norm() < 0.3 * apart);
            if !known && place_of(boundary, x, &faces).count > 0 {
                points.push(x);
            }
        }
    }
    let apart = samples[faces[0]].apart.max(samples[faces[1]].apart);
    (!points.is_empty()).then_some(Curve { faces, points, apart })
}

/// Corners in which a curve meets a third face.
fn corners(
    boundary: &SpatialBoundary,
    samples: &[Samples],
    curve: &Curve,
) -> Vec<(Vector3<f64>, [usize; 3])> {
    let tolerance = ROUND_OFF * boundary.size();
    let [i, j] = curve.faces;
    let mut found: Vec<(Vector3<f64>, [usize; 3])> = Vec::new();
    for k in (0..samples.len()).filter(|k| *k != i && *k != j) {
        let faces = [i, j, k];
        for x in &curve.points {
            if (boundary.faces()[k].nearest(x).point - x).norm() > 2.0 * curve.apart {
                continue;
            }
            let Some(x) = onto(boundary, &faces, *x, tolerance) else { continue };
            let known = found.iter().any(|(y, of)| *of == faces && (x - y).norm() < 10.0 * tolerance);
            if !known && place_of(boundary, x, &faces).count > 0 {
                found.push((x, faces));
            }
        }
    }
    found
}
