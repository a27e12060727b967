//! What the particles of a snapshot tell about lattice order and pressure noise.

use sph::domain::Domain;
use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::vector::Vector;

use super::snapshot::Snapshot;

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
    let list = CellGrid::new(domain, positions, radius).list(domain, positions, positions, radius, true);
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
    let list = grid.list(domain, &points, positions, reach, false);
    let distance = |k: usize| {
        let to = |j: &u32| domain.separation(&points[k], &positions[*j as usize]).norm();
        list.of(k).iter().map(to).fold(reach, f64::min)
    };
    2.0 * (0..points.len()).map(distance).fold(0.0, f64::max)
}

/// Root mean square \[Pa\] of p_i minus the Shepard mean of p around i, over particles deeper than 4h.
///
/// Deeper than 4h: nowhere within 4h does the kernel sum of the fluid fall below 0.85 of its full value, and `walls`
/// says that no wall is nearer than 2h.
pub fn pressure_noise(
    domain: &Domain,
    snapshot: &Snapshot,
    smoothing_length: f64,
    walls: impl Fn(&Vector) -> bool,
) -> f64 {
    let kernel = CubicSpline::new(smoothing_length);
    let positions = &snapshot.position;
    let list_to = |radius: f64| {
        CellGrid::new(domain, positions, radius).list(domain, positions, positions, radius, false)
    };
    let near = list_to(2.0 * smoothing_length);
    let share = |i: usize, j: usize| {
        let r = domain.separation(&positions[i], &positions[j]).norm();
        snapshot.mass[j] / snapshot.density[j] * kernel.value(r)
    };
    let sums: Vec<(f64, f64)> = (0..positions.len())
        .map(|i| {
            near.of(i).iter().map(|j| *j as usize).fold((0.0, 0.0), |(weight, pressure), j| {
                let w = share(i, j);
                (weight + w, pressure + w * snapshot.pressure[j])
            })
        })
        .collect();
    let far = list_to(4.0 * smoothing_length);
    let deep = |i: &usize| {
        // The outermost row of a lattice has 0.785. Toward walls the sum is short too, without a surface.
        let covered = |j: &u32| sums[*j as usize].0 > 0.85 || walls(&positions[*j as usize]);
        !walls(&positions[*i]) && far.of(*i).iter().all(covered)
    };
    let squares: Vec<f64> = (0..positions.len())
        .filter(deep)
        .map(|i| (snapshot.pressure[i] - sums[i].1 / sums[i].0).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
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

    #[test]
    fn noise_is_told_from_a_smooth_field() {
        let position = lattice(40);
        let n = position.len();
        let alternating = |k: usize| if (k % 40 + k / 40).is_multiple_of(2) { 10.0 } else { -10.0 };
        let snapshot = |noisy: bool| Snapshot {
            pressure: (0..n)
                .map(|k| 5.0 * position[k].x + if noisy { alternating(k) } else { 0.0 })
                .collect(),
            mass: vec![1.0; n],
            density: vec![1.0; n],
            position: position.clone(),
            ..Snapshot::default()
        };
        let domain = domain_around(&position, 0.0);
        // A linear field has no noise up to round-off; an alternating one is seen almost whole.
        let smooth = pressure_noise(&domain, &snapshot(false), 1.2, |_| false);
        assert!(smooth < 1e-10, "{smooth}");
        let noise = pressure_noise(&domain, &snapshot(true), 1.2, |_| false);
        assert!((8.0..12.0).contains(&noise), "{noise}");
    }
}
