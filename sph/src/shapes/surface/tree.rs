//! Triangles in a tree of boxes.

use crate::tasks;
use nalgebra::Vector3;

use super::triangle::{self, Feature, Triangle};

/// Most triangles of a leaf.
const LEAF: usize = 4;

crate::constants! {
    /// The winding number is off by less than 1 % then; one half decides.
    const FAR: f64 = 4.0, "surface.far",
        "distance of a group of facets in its radii beyond which its winding number is that of a dipole [-]";
}

/// Leaves that one task halves.
const TASK: usize = 1 << 12;

/// A part of the triangles.
#[derive(Clone, Copy, Debug)]
struct Node {
    lower: Vector3<f64>,
    upper: Vector3<f64>,
    /// Mean place, by area.
    middle: Vector3<f64>,
    /// Sum of area vectors.
    dipole: Vector3<f64>,
    area: f64,
    /// Radius about the middle that holds all of it.
    radius: f64,
}

/// A complete binary tree: node k has the children 2k + 1 and 2k + 2, and each leaf as many triangles as any but one.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// The triangles in the order of the leaves, and their numbers.
    triangles: Vec<Triangle>,
    numbers: Vec<u32>,
    levels: u32,
}

/// The nearest triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub number: u32,
    pub point: Vector3<f64>,
    pub feature: Feature,
    pub squared: f64,
}

impl Tree {
    pub fn new(all: &[Triangle]) -> Self {
        let levels = (all.len().div_ceil(LEAF)).next_power_of_two().trailing_zeros();
        let mut entries: Vec<(Vector3<f64>, u32)> =
            all.iter().zip(0_u32..).map(|(t, k)| ((t[0] + t[1] + t[2]) / 3.0, k)).collect();
        halve(&mut entries, 1 << levels);
        let numbers: Vec<u32> = entries.into_iter().map(|(_, k)| k).collect();
        let triangles: Vec<Triangle> = numbers.iter().map(|k| all[*k as usize]).collect();
        let empty = Node {
            lower: Vector3::repeat(f64::INFINITY),
            upper: Vector3::repeat(f64::NEG_INFINITY),
            middle: Vector3::zeros(),
            dipole: Vector3::zeros(),
            area: 0.0,
            radius: 0.0,
        };
        let mut tree = Self { nodes: vec![empty; (2 << levels) - 1], triangles, numbers, levels };
        let first_leaf = (1 << levels) - 1;
        let leaves = tasks::map(1 << levels, 16, |k| tree.leaf(k, empty));
        tree.nodes[first_leaf..].copy_from_slice(&leaves);
        for k in (0..first_leaf).rev() {
            tree.nodes[k] = joined(&tree.nodes[2 * k + 1], &tree.nodes[2 * k + 2]);
        }
        tree
    }

    /// Sum of the area vectors of all triangles.
    pub fn dipole(&self) -> Vector3<f64> {
        self.nodes[0].dipole
    }

    /// Numbers of the triangles of leaf `k` in the order of the leaves.
    fn range(&self, k: usize) -> std::ops::Range<usize> {
        let bound = |k: usize| (k * self.triangles.len()) >> self.levels;
        bound(k)..bound(k + 1)
    }

    fn leaf(&self, k: usize, empty: Node) -> Node {
        let mut node = empty;
        for t in &self.triangles[self.range(k)] {
            let vector = triangle::area_vector(t);
            let area = vector.norm();
            node.area += area;
            node.dipole += vector;
            node.middle += (t[0] + t[1] + t[2]) / 3.0 * area;
            for x in t {
                (node.lower, node.upper) = (node.lower.inf(x), node.upper.sup(x));
            }
        }
        node.middle = if node.area > 0.0 { node.middle / node.area } else { node.lower };
        let corners = self.triangles[self.range(k)].iter().flatten();
        node.radius = corners.map(|x| (x - node.middle).norm()).fold(0.0, f64::max);
        node
    }

    /// Visits the tree from the root: `enter` decides on each node, `found` gets the triangles of the leaves with their place.
    fn visit(&self, mut enter: impl FnMut(&Node) -> bool, mut found: impl FnMut(usize, &Triangle)) {
        let first_leaf = (1 << self.levels) - 1;
        let mut stack = [0_usize; 64];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let k = stack[height];
            if !enter(&self.nodes[k]) {
                continue;
            }
            if k >= first_leaf {
                self.range(k - first_leaf).for_each(|place| found(place, &self.triangles[place]));
            } else {
                stack[height] = 2 * k + 2;
                stack[height + 1] = 2 * k + 1;
                height += 2;
            }
        }
    }

    /// The triangle nearest to `x`, if it lies within the root of `squared`.
    pub fn nearest(&self, x: &Vector3<f64>, squared: f64) -> Option<Nearest> {
        let first_leaf = (1 << self.levels) - 1;
        let mut best = Nearest { number: u32::MAX, point: *x, feature: Feature::Inside, squared };
        let mut stack = [(0_usize, 0.0); 64];
        stack[0] = (0, to_box(&self.nodes[0], x));
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (k, distance) = stack[height];
            if distance > best.squared {
                continue;
            }
            if k >= first_leaf {
                for place in self.range(k - first_leaf) {
                    let (point, feature) = triangle::nearest(&self.triangles[place], x);
                    let squared = (point - x).norm_squared();
                    let number = self.numbers[place];
                    // The lower number among equals, so that the tree does not matter.
                    if squared < best.squared || (squared == best.squared && number < best.number) {
                        best = Nearest { number, point, feature, squared };
                    }
                }
                continue;
            }
            let children = [2 * k + 1, 2 * k + 2].map(|k| (k, to_box(&self.nodes[k], x)));
            let nearer = usize::from(children[1].1 < children[0].1);
            stack[height] = children[1 - nearer];
            stack[height + 1] = children[nearer];
            height += 2;
        }
        (best.number != u32::MAX).then_some(best)
    }

    /// Numbers of all triangles within the root of `squared` of `x`.
    pub fn within(&self, x: &Vector3<f64>, squared: f64) -> Vec<u32> {
        let mut found = Vec::new();
        self.visit(
            |node| to_box(node, x) <= squared,
            |place, t| {
                if (triangle::nearest(t, x).0 - x).norm_squared() <= squared {
                    found.push(self.numbers[place]);
                }
            },
        );
        found.sort_unstable();
        found
    }

    /// Numbers of the triangles whose boxes come within `margin` of the box from `lower` to `upper`.
    pub fn about(&self, lower: &Vector3<f64>, upper: &Vector3<f64>, margin: f64, found: &mut Vec<u32>) {
        found.clear();
        let near = |a: &Vector3<f64>, b: &Vector3<f64>| {
            (0..3).all(|k| a[k] <= upper[k] + margin && b[k] >= lower[k] - margin)
        };
        self.visit(
            |node| near(&node.lower, &node.upper),
            |place, t| {
                if near(&t[0].inf(&t[1]).inf(&t[2]), &t[0].sup(&t[1]).sup(&t[2])) {
                    found.push(self.numbers[place]);
                }
            },
        );
    }

    /// The first triangle that a ray from `x` along `direction` meets beyond `least`: its distance and number.
    pub fn first_along(&self, x: &Vector3<f64>, direction: &Vector3<f64>, least: f64) -> Option<(f64, u32)> {
        let best = std::cell::Cell::new((f64::INFINITY, u32::MAX));
        self.visit(
            |node| {
                let (mut from, mut to) = (least, best.get().0);
                for k in 0..3 {
                    let ends = [node.lower[k], node.upper[k]].map(|end| (end - x[k]) / direction[k]);
                    // Minimum and maximum leave out what is no number: along a face of the box.
                    (from, to) = (from.max(ends[0].min(ends[1])), to.min(ends[0].max(ends[1])));
                }
                from <= to
            },
            |place, t| {
                let distance = triangle::along(t, x, direction);
                if distance.is_some_and(|distance| distance > least && distance < best.get().0) {
                    best.set((distance.unwrap_or_default(), self.numbers[place]));
                }
            },
        );
        Some(best.get()).filter(|(distance, _)| distance.is_finite())
    }

    /// Times that the surface winds around `x`, far facets in groups (Barill et al. 2018): one inside of a sound surface,
    /// zero outside.
    pub fn winding(&self, x: &Vector3<f64>) -> f64 {
        let (mut far, mut near) = (0.0, 0.0);
        self.visit(
            |node| {
                let d = node.middle - x;
                let squared = d.norm_squared();
                let reach = FAR * node.radius;
                if squared <= reach * reach {
                    return true;
                }
                far += d.dot(&node.dipole) / (squared * squared.sqrt());
                false
            },
            |_, t| near += triangle::solid_angle(t, x),
        );
        (far + near) / (4.0 * std::f64::consts::PI)
    }
}

/// Halves `entries` along the longest side of their box until there is a part for each of the `leaves`.
fn halve(entries: &mut [(Vector3<f64>, u32)], leaves: usize) {
    if leaves < 2 || entries.is_empty() {
        return;
    }
    let (mut lower, mut upper) = (entries[0].0, entries[0].0);
    for (x, _) in entries.iter() {
        (lower, upper) = (lower.inf(x), upper.sup(x));
    }
    let axis = (upper - lower).imax();
    let middle = entries.len() / 2;
    entries.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (before, after) = entries.split_at_mut(middle);
    if leaves >= TASK {
        tasks::join(|| halve(before, leaves / 2), || halve(after, leaves / 2));
    } else {
        halve(before, leaves / 2);
        halve(after, leaves / 2);
    }
}

fn joined(a: &Node, b: &Node) -> Node {
    let area = a.area + b.area;
    let middle = if area > 0.0 { (a.middle * a.area + b.middle * b.area) / area } else { a.middle };
    let reach = |node: &Node| (node.middle - middle).norm() + node.radius;
    Node {
        lower: a.lower.inf(&b.lower),
        upper: a.upper.sup(&b.upper),
        middle,
        dipole: a.dipole + b.dipole,
        area,
        radius: if b.area > 0.0 { reach(a).max(reach(b)) } else { reach(a) },
    }
}

/// Square of the distance of `x` from the box of `node`.
fn to_box(node: &Node, x: &Vector3<f64>) -> f64 {
    let mut squared = 0.0;
    for k in 0..3 {
        let beyond = (node.lower[k] - x[k]).max(x[k] - node.upper[k]).max(0.0);
        squared += beyond * beyond;
    }
    squared
}
