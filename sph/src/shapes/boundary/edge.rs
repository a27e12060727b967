//! Straight and circular edges in the plane.

use std::f64::consts::TAU;

use super::ROUND_OFF;
use crate::space::{Vector, cross};

/// A part of a boundary with its outward normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::shapes) enum Edge {
    Segment {
        start: Vector,
        end: Vector,
        normal: Vector,
    },
    Arc {
        centre: Vector,
        radius: f64,
        /// Angle at which the arc begins; it runs counter-clockwise.
        begin: f64,
        sweep: f64,
        /// 1 when the shape lies on the centre's side, −1 when it lies outside.
        outward: f64,
    },
}

impl Edge {
    pub(super) fn segment(start: Vector, end: Vector) -> Self {
        let along = end - start;
        let normal = Vector::new(along.y, -along.x) / along.norm();
        Self::Segment { start, end, normal }
    }

    pub(super) fn circle(centre: Vector, radius: f64, outward: f64) -> Self {
        Self::Arc { centre, radius, begin: 0.0, sweep: TAU, outward }
    }

    pub(super) fn turned_round(self) -> Self {
        match self {
            Self::Segment { start, end, normal } => Self::Segment { start, end, normal: -normal },
            Self::Arc { centre, radius, begin, sweep, outward } => {
                Self::Arc { centre, radius, begin, sweep, outward: -outward }
            }
        }
    }

    /// Point at a fraction of the way along the edge, and the outward normal there.
    pub(in crate::shapes) fn at(&self, fraction: f64) -> (Vector, Vector) {
        match *self {
            Self::Segment { start, end, normal } => (start + (end - start) * fraction, normal),
            Self::Arc { centre, radius, begin, sweep, outward } => {
                let direction = direction_of(begin + fraction * sweep);
                (centre + direction * radius, direction * outward)
            }
        }
    }

    pub(in crate::shapes) fn length(&self) -> f64 {
        match *self {
            Self::Segment { start, end, .. } => (end - start).norm(),
            Self::Arc { radius, sweep, .. } => radius * sweep,
        }
    }

    /// The part between two fractions of the way along.
    pub(super) fn part(&self, from: f64, to: f64) -> Self {
        match *self {
            Self::Segment { start, end, normal } => {
                let along = end - start;
                Self::Segment { start: start + along * from, end: start + along * to, normal }
            }
            Self::Arc { centre, radius, begin, sweep, outward } => {
                Self::Arc { centre, radius, begin: begin + from * sweep, sweep: (to - from) * sweep, outward }
            }
        }
    }

    /// Distance of `point` from its nearest point of the edge, and the outward normal there.
    ///
    /// From the centre of an arc no direction is nearer than another: the normal is zero.
    pub(super) fn nearest(&self, point: &Vector) -> (f64, Vector) {
        match *self {
            Self::Segment { start, end, normal } => {
                let along = end - start;
                let fraction = ((point - start).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                ((point - (start + along * fraction)).norm(), normal)
            }
            Self::Arc { centre, radius, begin, sweep, outward } => {
                let from_centre = point - centre;
                let distance = from_centre.norm();
                if distance <= ROUND_OFF * radius {
                    return (radius, Vector::zeros());
                }
                let angle = (from_centre.y.atan2(from_centre.x) - begin).rem_euclid(TAU);
                if angle <= sweep {
                    return ((distance - radius).abs(), from_centre / distance * outward);
                }
                let fraction = if angle - sweep < TAU - angle { 1.0 } else { 0.0 };
                let (end, normal) = self.at(fraction);
                ((point - end).norm(), normal)
            }
        }
    }

    /// The nearest point of the edge as seen from `point`, and the outward normal there; zero from the centre of an arc.
    pub(in crate::shapes) fn closest(&self, point: &Vector) -> (Vector, Vector) {
        match *self {
            Self::Segment { start, end, normal } => {
                let along = end - start;
                let fraction = ((point - start).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (start + along * fraction, normal)
            }
            Self::Arc { centre, radius, begin, sweep, outward } => {
                let from_centre = point - centre;
                let distance = from_centre.norm();
                if distance <= ROUND_OFF * radius {
                    return (self.at(0.5).0, Vector::zeros());
                }
                let angle = (from_centre.y.atan2(from_centre.x) - begin).rem_euclid(TAU);
                if angle <= sweep {
                    let direction = from_centre / distance;
                    return (centre + direction * radius, direction * outward);
                }
                self.at(if angle - sweep < TAU - angle { 1.0 } else { 0.0 })
            }
        }
    }

    /// Fractions at which `other` crosses, touches or ends on this edge; `tolerance` \[m\] decides what touches.
    pub(super) fn cuts(&self, other: &Self, tolerance: f64, cuts: &mut Vec<f64>) {
        for (end, _) in [other.at(0.0), other.at(1.0)] {
            self.cut_at(&end, tolerance, cuts);
        }
        match (*self, *other) {
            (Self::Segment { start, end, .. }, Self::Segment { start: a, end: b, .. }) => {
                let (along, across) = (end - start, b - a);
                let determinant = cross(&along, &across);
                // Parallel edges meet at their ends only, which are dealt with above.
                if determinant.abs() > f64::EPSILON * along.norm() * across.norm() {
                    let fraction = cross(&(a - start), &across) / determinant;
                    let beside = cross(&(a - start), &along) / determinant;
                    if (0.0..=1.0).contains(&beside) {
                        cuts.push(fraction);
                    }
                }
            }
            (Self::Segment { start, end, .. }, Self::Arc { centre, radius, .. })
            | (Self::Arc { centre, radius, .. }, Self::Segment { start, end, .. }) => {
                let along = (end - start).normalize();
                let middle = start + along * (centre - start).dot(&along);
                let off_centre = (centre - middle).norm();
                if off_centre <= radius + tolerance {
                    // Where line and circle only touch, both points are the middle.
                    let half = along * (radius * radius - off_centre * off_centre).max(0.0).sqrt();
                    for point in [middle - half, middle, middle + half] {
                        if other.nearest(&point).0 <= tolerance {
                            self.cut_at(&point, tolerance, cuts);
                        }
                    }
                }
            }
            (Self::Arc { centre: a, radius: r, .. }, Self::Arc { centre: b, radius: s, .. }) => {
                let between = b - a;
                let distance = between.norm();
                if distance > tolerance
                    && distance <= r + s + tolerance
                    && distance >= (r - s).abs() - tolerance
                {
                    let along = (distance * distance + r * r - s * s) / (2.0 * distance);
                    let half = (r * r - along * along).max(0.0).sqrt();
                    let unit = between / distance;
                    let beside = Vector::new(-unit.y, unit.x) * half;
                    for point in [a + unit * along - beside, a + unit * along, a + unit * along + beside] {
                        self.cut_at(&point, tolerance, cuts);
                    }
                }
            }
        }
    }

    /// Adds the fraction at which `point` lies when it lies on this edge.
    fn cut_at(&self, point: &Vector, tolerance: f64, cuts: &mut Vec<f64>) {
        if self.nearest(point).0 > tolerance {
            return;
        }
        match *self {
            Self::Segment { start, end, .. } => {
                let along = end - start;
                cuts.push((point - start).dot(&along) / along.norm_squared());
            }
            Self::Arc { centre, begin, sweep, .. } => {
                let from_centre = point - centre;
                let angle = (from_centre.y.atan2(from_centre.x) - begin).rem_euclid(TAU);
                cuts.push(angle / sweep);
            }
        }
    }

    /// Points from one end to the other with the shape on the left, arcs in chords of at most `chord` \[m\].
    pub(in crate::shapes) fn traced(&self, chord: f64) -> Vec<Vector> {
        let (pieces, shape_on_left) = match *self {
            Self::Segment { start, end, normal } => (1.0, cross(&normal, &(end - start)) > 0.0),
            // In fours: the chords of a circle are its own mirror images.
            Self::Arc { outward, .. } => {
                (4.0 * (0.25 * self.length() / chord).ceil().max(3.0), outward > 0.0)
            }
        };
        let fractions = std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(|k| *k <= pieces);
        let mut points: Vec<Vector> = fractions.map(|k| self.at(k / pieces).0).collect();
        if !shape_on_left {
            points.reverse();
        }
        points
    }

    /// Box around the edge or more.
    pub(super) fn bounds(&self) -> (Vector, Vector) {
        match *self {
            Self::Segment { start, end, .. } => (start.inf(&end), start.sup(&end)),
            Self::Arc { centre, radius, .. } => {
                (centre - Vector::repeat(radius), centre + Vector::repeat(radius))
            }
        }
    }
}

fn direction_of(angle: f64) -> Vector {
    Vector::new(angle.cos(), angle.sin())
}
