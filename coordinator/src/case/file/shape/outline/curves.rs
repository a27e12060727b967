//! Curves of drawings, and the chords that replace them.

use std::f64::consts::TAU;

/// A point of the drawing.
pub type Point = [f64; 2];

/// A piece of an outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pieces: Vec<Piece>,
    /// Whether it ends where it starts.
    pub closed: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Line(Point, Point),
    /// centre + cos t a + sin t b
    Ellipse {
        centre: Point,
        a: Point,
        b: Point,
        from: f64,
        to: f64,
    },
    Spline(Spline),
}

/// A rational B-spline.
#[derive(Clone, Debug, PartialEq)]
struct Spline {
    degree: usize,
    knots: Vec<f64>,
    /// Control points times their weights, and the weights.
    poles: Vec<[f64; 3]>,
}

/// Highest degree of a spline.
const HIGHEST_DEGREE: usize = 25;

/// Halvings after which a chord is taken as it is.
const MOST_HALVINGS: u32 = 14;

/// Chords of a whole turn at least.
const LEAST_CHORDS: f64 = 8.0;

fn add(a: Point, factor: f64, b: Point) -> Point {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

/// Distance of two points.
pub fn distance(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Distance of `point` from the chord of `a` and `b`.
fn off_chord(point: Point, a: Point, b: Point) -> f64 {
    let (along, to) = (add(b, -1.0, a), add(point, -1.0, a));
    let length = along[0].hypot(along[1]);
    if length > 0.0 { (along[0] * to[1] - along[1] * to[0]).abs() / length } else { to[0].hypot(to[1]) }
}

impl Curve {
    pub fn line(from: Point, to: Point) -> Self {
        Self { pieces: vec![Piece::Line(from, to)], closed: false }
    }

    pub fn circle(centre: Point, radius: f64) -> Self {
        let circle = Piece::Ellipse { centre, a: [radius, 0.0], b: [0.0, radius], from: 0.0, to: TAU };
        Self { pieces: vec![circle], closed: true }
    }

    /// The arc counterclockwise from one angle to another.
    pub fn arc(centre: Point, radius: f64, from: f64, to: f64) -> Self {
        Self::turning(centre, [radius, 0.0], [0.0, radius], from, to)
    }

    /// The part of an ellipse between two parameters; `ratio` of the axes is negative where it turns clockwise.
    pub fn ellipse(centre: Point, major: Point, ratio: f64, [from, to]: [f64; 2]) -> Self {
        Self::turning(centre, major, [-ratio * major[1], ratio * major[0]], from, to)
    }

    fn turning(centre: Point, a: Point, b: Point, from: f64, to: f64) -> Self {
        let turn = (to - from).rem_euclid(TAU);
        let whole = turn.min(TAU - turn) < 1e-9;
        let to = from + if whole { TAU } else { turn };
        Self { pieces: vec![Piece::Ellipse { centre, a, b, from, to }], closed: whole }
    }

    /// Corners, each with the bulge of the arc to the next: the tangent of a quarter of its angle.
    pub fn polyline(corners: &[(Point, f64)], closed: bool) -> Self {
        let next = corners.iter().skip(1).chain(corners.first().filter(|_| closed));
        let pieces = corners.iter().zip(next).map(|((from, bulge), (to, _))| bulged(*from, *to, *bulge));
        Self { pieces: pieces.collect(), closed }
    }

    /// A rational B-spline; no `weights` mean equal ones.
    ///
    /// # Errors
    /// Numbers of knots and control points that do not fit, or knots out of order.
    pub fn spline(
        degree: usize,
        knots: Vec<f64>,
        poles: Vec<Point>,
        weights: Vec<f64>,
    ) -> Result<Self, String> {
        let needed = poles.len() + degree + 1;
        if !(1..=HIGHEST_DEGREE).contains(&degree) || poles.len() <= degree || knots.len() != needed {
            return Err(format!(
                "is a spline of degree {degree} with {} control points and {} knots; a degree of 1 to {HIGHEST_DEGREE} \
                 and {needed} knots are allowed",
                poles.len(),
                knots.len()
            ));
        }
        let rise =
            knots.windows(2).all(|two| two[0] <= two[1]) && knots[poles.len() - 1] < knots[poles.len()];
        if !rise || !(weights.is_empty() || weights.len() == poles.len()) {
            return Err("is a spline whose knots fall, or whose weights are not as many as its points".into());
        }
        if weights.iter().any(|weight| *weight <= 0.0) {
            return Err("is a spline with a weight that is not above 0".into());
        }
        let weighted = poles.iter().enumerate().map(|(index, [x, y])| {
            let weight = weights.get(index).copied().unwrap_or(1.0);
            [weight * x, weight * y, weight]
        });
        let spline = Spline { degree, knots, poles: weighted.collect() };
        let (from, to) = spline.ends();
        // It ends where it starts to the digits of a file, which are six or more.
        let extent = poles.iter().map(|pole| distance(poles[0], *pole)).fold(0.0, f64::max);
        let closed = distance(spline.at(from), spline.at(to)) <= 1e-6 * extent;
        Ok(Self { pieces: vec![Piece::Spline(spline)], closed })
    }

    /// The same seen from below, when `facing` is -1: x is reversed.
    pub fn facing(mut self, facing: f64) -> Self {
        let turn = |[x, y]: Point| [facing * x, y];
        for piece in &mut self.pieces {
            *piece = match piece.clone() {
                Piece::Line(from, to) => Piece::Line(turn(from), turn(to)),
                Piece::Ellipse { centre, a, b, from, to } => {
                    Piece::Ellipse { centre: turn(centre), a: turn(a), b: turn(b), from, to }
                }
                spline @ Piece::Spline(_) => spline,
            };
        }
        self
    }

    /// Corners of a box around it.
    pub fn bounds(&self) -> (Point, Point) {
        let mut bounds = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut take = |[x, y]: Point| {
            let (low, high) = bounds;
            bounds = ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)]);
        };
        for piece in &self.pieces {
            match piece {
                Piece::Line(from, to) => [*from, *to].into_iter().for_each(&mut take),
                Piece::Ellipse { centre, a, b, .. } => {
                    let reach = [a[0].hypot(b[0]), a[1].hypot(b[1])];
                    [-1.0, 1.0].into_iter().for_each(|sign| take(add(*centre, sign, reach)));
                }
                Piece::Spline(spline) => spline.poles.iter().for_each(|[x, y, w]| take([x / w, y / w])),
            }
        }
        bounds
    }

    /// Points along it, of whose chords it is nowhere farther than `tolerance`; the last one of a closed curve is its first.
    pub fn points(&self, tolerance: f64) -> Vec<Point> {
        let mut points = Vec::new();
        for piece in &self.pieces {
            let first = points.len();
            match piece {
                Piece::Line(from, to) => points.extend([*from, *to]),
                Piece::Ellipse { centre, a, b, from, to } => {
                    let at = |t: f64| add(add(*centre, t.cos(), *a), t.sin(), *b);
                    let parts = ((to - from) / TAU * LEAST_CHORDS).ceil().max(1.0);
                    let marks: Vec<f64> =
                        (0..=parts as u32).map(|k| from + (to - from) * f64::from(k) / parts).collect();
                    chords(&at, &marks, tolerance, &mut points);
                }
                Piece::Spline(spline) => {
                    chords(&|t| spline.at(t), &spline.marks(), tolerance, &mut points);
                }
            }
            if first > 0 {
                points.remove(first);
            }
        }
        points
    }
}

/// The line from one corner to the next, or the arc of its bulge.
fn bulged(from: Point, to: Point, bulge: f64) -> Piece {
    let half = [0.5 * (to[0] - from[0]), 0.5 * (to[1] - from[1])];
    if bulge == 0.0 || half == [0.0, 0.0] {
        return Piece::Line(from, to);
    }
    // From the middle of the chord to the centre, to its left for a bulge to its right.
    let lift = 0.5 * (1.0 / bulge - bulge);
    let middle = add(from, 1.0, half);
    let centre = add(middle, lift, [-half[1], half[0]]);
    let a = add(from, -1.0, centre);
    let sense = bulge.signum();
    let b = [-sense * a[1], sense * a[0]];
    Piece::Ellipse { centre, a, b, from: 0.0, to: 4.0 * bulge.abs().atan() }
}

/// Points of a curve at `marks` and between them, until chords are near enough.
fn chords(at: &impl Fn(f64) -> Point, marks: &[f64], tolerance: f64, points: &mut Vec<Point>) {
    points.push(at(marks[0]));
    for two in marks.windows(2) {
        between(at, [two[0], two[1]], [at(two[0]), at(two[1])], tolerance, MOST_HALVINGS, points);
    }
}

fn between(
    at: &impl Fn(f64) -> Point,
    [t0, t1]: [f64; 2],
    [a, b]: [Point; 2],
    tolerance: f64,
    halvings: u32,
    points: &mut Vec<Point>,
) {
    let middle = 0.5 * (t0 + t1);
    let off = [0.25, 0.5, 0.75].map(|share| off_chord(at(t0 + share * (t1 - t0)), a, b));
    if halvings == 0 || off.iter().all(|off| *off <= tolerance) {
        points.push(b);
        return;
    }
    let half = at(middle);
    between(at, [t0, middle], [a, half], tolerance, halvings - 1, points);
    between(at, [middle, t1], [half, b], tolerance, halvings - 1, points);
}

impl Spline {
    fn ends(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.poles.len()])
    }

    /// Knots between its ends, and the middles between them.
    fn marks(&self) -> Vec<f64> {
        let mut inner = self.knots[self.degree..=self.poles.len()].to_vec();
        inner.dedup();
        let mut marks: Vec<f64> =
            inner.windows(2).flat_map(|two| [two[0], 0.5 * (two[0] + two[1])]).collect();
        marks.extend(inner.last());
        marks
    }

    /// Point at the parameter `t`, by de Boor's algorithm.
    fn at(&self, t: f64) -> Point {
        let degree = self.degree;
        let inner = &self.knots[degree + 1..self.poles.len()];
        let span = degree + inner.partition_point(|knot| *knot <= t);
        let mut d = self.poles[span - degree..=span].to_vec();
        for level in 1..=degree {
            for j in (level..=degree).rev() {
                let left = self.knots[span - degree + j];
                let right = self.knots[span + 1 + j - level];
                let share = (t - left) / (right - left);
                d[j] = std::array::from_fn(|axis| (1.0 - share) * d[j - 1][axis] + share * d[j][axis]);
            }
        }
        let [x, y, weight] = d[degree];
        [x / weight, y / weight]
    }
}
