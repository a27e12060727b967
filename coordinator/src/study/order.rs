//! How evenly particles are spread; shared with `validate`.

use std::collections::HashMap;

use sph::neighbours::CellGrid;
use sph::space::Vector;
use sph::space::domain::Domain;

/// A box around `positions`, open on all sides unless `periodic` gives one.
pub fn domain_around(positions: &[Vector], margin: f64) -> Domain {
    let mut lower = Vector::repeat(f64::INFINITY);
    let mut upper = Vector::repeat(f64::NEG_INFINITY);
    for x in positions {
        lower = lower.inf(x);
        upper = upper.sup(x);
    }
    Domain { lower: lower.add_scalar(-margin), upper: upper.add_scalar(margin), periodic: [false, false] }
}

/// Smallest distance of a pair \[m\].
pub fn smallest_distance(domain: &Domain, positions: &[Vector], spacing: f64) -> f64 {
    let radius = 1.5 * spacing;
    let list = CellGrid::new(domain, positions, radius).list_among(domain, positions, radius);
    let mut smallest = f64::INFINITY;
    for i in 0..positions.len() {
        for j in list.of(i) {
            smallest = smallest.min(domain.separation(&positions[i], &positions[*j as usize]).norm());
        }
    }
    smallest
}

/// Diameter \[m\] of the widest empty circle whose centre is a point of `inside`, which says whether a point belongs
/// to the bulk: the largest distance of such a point to its nearest particle, doubled.
///
/// On an undisturbed lattice of spacing Δx it is √2 Δx.
pub fn widest_gap(
    domain: &Domain,
    positions: &[Vector],
    spacing: f64,
    inside: impl Fn(&Vector) -> bool,
) -> f64 {
    let reach = 3.0 * spacing;
    let grid = CellGrid::new(domain, positions, reach);
    let step = 0.25 * spacing;
    let size = (domain.upper - domain.lower) / step;
    let count = |cells: f64| (0..).map(f64::from).take_while(move |k: &f64| *k < cells);
    let mut points = Vec::new();
    for row in count(size.y) {
        for column in count(size.x) {
            let x = domain.lower + Vector::new(column + 0.5, row + 0.5) * step;
            if inside(&x) {
                points.push(x);
            }
        }
    }
    let list = grid.list(domain, &points, positions, reach);
    let distance = |k: usize| {
        let to = |j: &u32| domain.separation(&points[k], &positions[*j as usize]).norm();
        list.of(k).iter().map(to).fold(reach, f64::min)
    };
    2.0 * (0..points.len()).map(distance).fold(0.0, f64::max)
}

/// Whether a point lies in the bulk: particles stand around it in each of eight directions.
///
/// A void is inside the fluid when the fluid surrounds it; the thin arms of the patch count no farther than their
/// particles.
pub fn surrounded(positions: &[Vector], spacing: f64) -> impl Fn(&Vector) -> bool {
    let radius = 6.0 * spacing;
    let cell = move |x: f64| (x / radius).floor() as i64;
    let mut cells: HashMap<(i64, i64), Vec<Vector>> = HashMap::new();
    for x in positions {
        cells.entry((cell(x.x), cell(x.y))).or_default().push(*x);
    }
    move |x| {
        let mut sectors = [false; 8];
        for column in -1..=1 {
            for row in -1..=1 {
                for p in cells.get(&(cell(x.x) + column, cell(x.y) + row)).into_iter().flatten() {
                    let d = p - x;
                    if d.norm() < radius {
                        let turn = d.y.atan2(d.x) / std::f64::consts::TAU + 0.5;
                        // In [0, 1], so the product is below 9.
                        sectors[(8.0 * turn) as usize % 8] = true;
                    }
                }
            }
        }
        sectors.iter().all(|s| *s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(n: i32) -> Vec<Vector> {
        (0..n * n).map(|k| Vector::new(f64::from(k % n), f64::from(k / n))).collect()
    }

    #[test]
    fn a_lattice_has_its_spacing_and_a_hole_is_a_gap() {
        let mut positions = lattice(20);
        let domain = domain_around(&positions, 0.0);
        let inside = |x: &Vector| x.x > 1.0 && x.x < 18.0 && x.y > 1.0 && x.y < 18.0;
        assert_eq!(smallest_distance(&domain, &positions, 1.0), 1.0);
        // Seen from points a quarter apart.
        let gap = widest_gap(&domain, &positions, 1.0, inside);
        assert!((gap - 2f64.sqrt()).abs() < 0.36, "{gap}");
        positions.remove(210);
        assert!(widest_gap(&domain, &positions, 1.0, inside) > 1.75);
    }
}
