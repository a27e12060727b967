//! Area and moments of shapes, exact for straight and circular edges.

use super::Boundary;
use super::boundary::Edge;
use super::packing::Moments;
use crate::space::{Plane, Vector};

/// Nodes and weights of Gauss's rule of five points on [0, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// Longest arc that one rule takes, in radians: to round-off.
const LONGEST_ARC: f64 = 0.2;

impl Boundary {
    /// The faces in straight pieces of at most `length` \[m\]: middle \[m\] and outward area vector per depth \[m\] of each.
    pub fn pieces(&self, length: f64) -> Vec<(Vector, Vector)> {
        let mut pieces = Vec::new();
        for edge in self.edges() {
            let count = (edge.length() / length).ceil().max(1.0);
            for k in std::iter::successors(Some(0.5), |k| Some(k + 1.0)).take_while(|k| *k < count) {
                let (middle, normal) = edge.at(k / count);
                pieces.push((middle, normal * (edge.length() / count)));
            }
        }
        pieces
    }

    /// Area and moments of the shape by the divergence theorem:
    ///
    /// ```text
    /// ∫ dA = ½ ∮ x·n ds,  ∫ x_a dA = ½ ∮ x_a² n_a ds,  ∫ x_a² dA = ⅓ ∮ x_a³ n_a ds,  ∫ x y dA = ½ ∮ x² y n_x ds
    /// ```
    pub fn moments(&self) -> Moments<Plane> {
        // About a point of the shape's size away at most: no cancellation far from the origin.
        let origin = self.edges().first().map_or_else(Vector::zeros, |edge| edge.at(0.0).0);
        let (mut area, mut first, mut second) = (0.0, Vector::zeros(), [0.0; 3]);
        self.integrate(|x, n, ds| {
            let x = x - origin;
            area += 0.5 * x.dot(&n) * ds;
            first += x.component_mul(&x).component_mul(&n) * (0.5 * ds);
            second[0] += x.x.powi(3) * n.x * ds / 3.0;
            second[1] += x.x * x.x * x.y * n.x * ds / 2.0;
            second[2] += x.y.powi(3) * n.y * ds / 3.0;
        });
        let c = first / area;
        let [xx, xy, yy] =
            [second[0] - area * c.x * c.x, second[1] - area * c.x * c.y, second[2] - area * c.y * c.y];
        Moments { volume: area, centroid: origin + c, second: vec![xx, xy, xy, yy] }
    }
    /// Calls `add` with place \[m\], outward normal and length \[m\] at the nodes of a quadrature of the boundary: exact for
    /// polynomials of degree nine on straight edges, to round-off for such on circular ones.
    pub(super) fn integrate(&self, mut add: impl FnMut(Vector, Vector, f64)) {
        for edge in self.edges() {
            let pieces = match edge {
                Edge::Segment { .. } => 1.0,
                Edge::Arc { sweep, .. } => (sweep / LONGEST_ARC).ceil().max(1.0),
            };
            let length = edge.length() / pieces;
            for piece in std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(|k| *k < pieces) {
                for (node, weight) in GAUSS {
                    let (x, n) = edge.at((piece + node) / pieces);
                    add(x, n, weight * length);
                }
            }
        }
    }
}
