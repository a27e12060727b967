//! The faces of a shape in space in small pieces.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::face::Form;
use super::faces::SpatialBoundary;
use crate::shapes::surface::triangle::area_vector;

/// Fewest pieces around an axis.
const FEWEST_AROUND: f64 = 6.0;

/// Middle \[m\] and area vector \[m²\].
type Piece = (Vector3<f64>, Vector3<f64>);

impl SpatialBoundary {
    /// The faces in pieces of about `length` \[m\]: middle \[m\] and outward area vector \[m²\] of each. Where parts of a composed
    /// shape cut each other, a piece counts when its middle is on the surface.
    pub fn pieces(&self, length: f64) -> Vec<Piece> {
        let (lower, upper) = self.bounds();
        let (middle, reach) = ((lower + upper) * 0.5, 0.5 * self.size());
        let mut pieces = Vec::new();
        for (k, face) in self.faces().iter().enumerate() {
            if self.is_left_out(k) {
                continue;
            }
            let own = face.form.pieces(length, &face.frame.local(&middle), reach);
            let own = own.into_iter().map(|(x, area)| (face.frame.point(&x), face.frame.vector(&area)));
            if self.shape().is_composed() {
                pieces.extend(own.filter_map(|(x, area)| {
                    let normal = area.try_normalize(0.0)?;
                    Some((x, area * self.outward(&x, &normal)?))
                }));
            } else {
                pieces.extend(own);
            }
        }
        pieces
    }
}

impl Form {
    /// Pieces of about `length` \[m\]; those of a plane within `reach` \[m\] of `middle`.
    fn pieces(&self, length: f64, middle: &Vector3<f64>, reach: f64) -> Vec<Piece> {
        match self {
            Self::Cap { section, height, outward } => {
                let (lower, upper) = section.0.bounds();
                let size = upper - lower;
                let [columns, rows] = [size.x, size.y].map(|size| count(size, length));
                let places = middles(columns).flat_map(|u| middles(rows).map(move |v| (u, v)));
                let inside: Vec<_> = places
                    .map(|(u, v)| lower + nalgebra::Vector2::new(u * size.x, v * size.y))
                    .filter(|x| section.0.contains(x))
                    .collect();
                // Together they are as large as the face.
                let area = section.1.moments().volume / (inside.len() as f64).max(1.0);
                let area = Vector3::z() * (area * outward);
                inside.into_iter().map(|x| (x.push(*height), area)).collect()
            }
            Self::Swept { edge, height } => {
                let [along, up] = [edge.length(), *height].map(|size| count(size, length));
                let area = edge.length() / along * height / up;
                let places = middles(along).flat_map(|u| middles(up).map(move |v| (u, v)));
                places
                    .map(|(u, v)| {
                        let (x, normal) = edge.at(u);
                        (x.push(v * height), normal.push(0.0) * area)
                    })
                    .collect()
            }
            Self::Turned { edge } => {
                let along = count(edge.length(), length);
                let ring = |u: f64| {
                    let (x, normal) = edge.at(u);
                    let around = count(TAU * x.x, length).max(FEWEST_AROUND);
                    let area = edge.length() / along * TAU * x.x / around;
                    middles(around).map(move |v| {
                        let (sin, cos) = (v * TAU).sin_cos();
                        let turned = |r: f64, z: f64| Vector3::new(cos * r, sin * r, z);
                        (turned(x.x, x.y), turned(normal.x, normal.y) * area)
                    })
                };
                middles(along).flat_map(ring).collect()
            }
            Self::Plane => {
                let side = count(2.0 * reach, length);
                let area = Vector3::z() * (2.0 * reach / side).powi(2);
                let place = |u: f64| (2.0 * u - 1.0) * reach;
                let row = |v: f64| {
                    middles(side).map(move |u| {
                        ((middle.xy() + nalgebra::Vector2::new(place(u), place(v))).push(0.0), area)
                    })
                };
                middles(side).flat_map(row).collect()
            }
            Self::Triangles(surface) => {
                (0..surface.facets()).flat_map(|k| of_triangle(&surface.corners(k), length)).collect()
            }
        }
    }
}

/// The triangle in equal ones.
fn of_triangle(corners: &[Vector3<f64>; 3], length: f64) -> Vec<Piece> {
    let [a, b, c] = corners;
    let (to_b, to_c) = (b - a, c - a);
    let longest = to_b.norm().max(to_c.norm()).max((c - b).norm());
    let count = count(longest, length);
    let area = area_vector(corners) / (count * count);
    let whole = |end: f64| std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(move |k| *k < end);
    let mut pieces = Vec::new();
    for i in whole(count) {
        for j in whole(count - i) {
            // The middle of the one that points as the whole does, and of its neighbour that points the other way.
            let at = |third: f64| a + to_b * ((i + third) / count) + to_c * ((j + third) / count);
            pieces.push((at(1.0 / 3.0), area));
            if i + j + 1.5 < count {
                pieces.push((at(2.0 / 3.0), area));
            }
        }
    }
    pieces
}

/// Number of pieces of about `length` of `size`.
fn count(size: f64, length: f64) -> f64 {
    (size / length).ceil().max(1.0)
}

/// Middles of `count` equal parts of 0 to 1.
fn middles(count: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(0.5), |k| Some(k + 1.0))
        .take_while(move |k| *k < count)
        .map(move |k| k / count)
}
