//! One triangle.

use nalgebra::Vector3;

/// Corners of a triangle.
pub(crate) type Triangle = [Vector3<f64>; 3];

/// Where on a triangle a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// Off its edges.
    Inside,
    /// On the edge from the corner of this number to the next.
    Edge(usize),
    /// At the corner of this number.
    Corner(usize),
}

/// Area vector \[m²\]: along the normal by the right-hand rule, as long as the area.
pub(crate) fn area_vector([a, b, c]: &Triangle) -> Vector3<f64> {
    (b - a).cross(&(c - a)) * 0.5
}

/// The nearest point of the triangle as seen from `x`, by the region of barycentric coordinates it falls into.
pub(super) fn nearest([a, b, c]: &Triangle, x: &Vector3<f64>) -> (Vector3<f64>, Feature) {
    let (ab, ac, ax) = (b - a, c - a, x - a);
    let (d1, d2) = (ab.dot(&ax), ac.dot(&ax));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (*a, Feature::Corner(0));
    }
    let bx = x - b;
    let (d3, d4) = (ab.dot(&bx), ac.dot(&bx));
    if d3 >= 0.0 && d4 <= d3 {
        return (*b, Feature::Corner(1));
    }
    let of_c = d1 * d4 - d3 * d2;
    if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
    }
    let cx = x - c;
    let (d5, d6) = (ab.dot(&cx), ac.dot(&cx));
    if d6 >= 0.0 && d5 <= d6 {
        return (*c, Feature::Corner(2));
    }
    let of_b = d5 * d2 - d1 * d6;
    if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
    }
    let of_a = d3 * d6 - d5 * d4;
    if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        return (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), Feature::Edge(1));
    }
    let sum = of_a + of_b + of_c;
    (a + ab * (of_b / sum) + ac * (of_c / sum), Feature::Inside)
}

/// Solid angle of the triangle as seen from `x`, positive when `x` sees its back (van Oosterom & Strackee 1983).
pub(super) fn solid_angle(triangle: &Triangle, x: &Vector3<f64>) -> f64 {
    let [a, b, c] = triangle.map(|corner| corner - x);
    let (p, q, r) = (a.norm(), b.norm(), c.norm());
    let below = p * q * r + a.dot(&b) * r + b.dot(&c) * p + c.dot(&a) * q;
    2.0 * a.dot(&b.cross(&c)).atan2(below)
}

/// Distance from `x` along `direction`, in its lengths, at which a line meets the triangle (Möller & Trumbore 1997).
pub(super) fn along([a, b, c]: &Triangle, x: &Vector3<f64>, direction: &Vector3<f64>) -> Option<f64> {
    let (ab, ac, ax) = (b - a, c - a, x - a);
    let across = direction.cross(&ac);
    let determinant = ab.dot(&across);
    if determinant == 0.0 {
        return None;
    }
    let u = ax.dot(&across) / determinant;
    let other = ax.cross(&ab);
    let v = direction.dot(&other) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ac.dot(&other) / determinant)
}

/// Whether two triangles have a point in common, within `tolerance` \[m\]: no axis parts them.
pub(super) fn meet(a: &Triangle, b: &Triangle, tolerance: f64) -> bool {
    let edges = |t: &Triangle| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (of_a, of_b) = (edges(a), edges(b));
    let normals = [area_vector(a), area_vector(b)];
    let parts = |axis: &Vector3<f64>| {
        let Some(axis) = axis.try_normalize(1e-14 * normals[0].norm().max(normals[1].norm())) else {
            return false;
        };
        let range = |t: &Triangle| {
            let [x, y, z] = t.map(|corner| (corner - a[0]).dot(&axis));
            (x.min(y).min(z), x.max(y).max(z))
        };
        let (of_a, of_b) = (range(a), range(b));
        of_a.0 > of_b.1 + tolerance || of_b.0 > of_a.1 + tolerance
    };
    let across = of_a.iter().flat_map(|e| of_b.iter().map(|f| e.cross(f)));
    let beside = of_a.iter().map(|e| e.cross(&normals[0])).chain(of_b.iter().map(|e| e.cross(&normals[1])));
    !normals.iter().copied().chain(across).chain(beside).any(|axis| parts(&axis))
}
