//! What the particles of a snapshot tell about pressure noise; about their order, see [`coordinator::study::order`].

use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::space::Plane;
use sph::space::Vector;
use sph::space::domain::Domain;

use super::snapshot::Snapshot;
pub use coordinator::study::order::{domain_around, smallest_distance, surrounded, widest_gap};

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
    let kernel = CubicSpline::<Plane>::new(smoothing_length);
    let positions = &snapshot.position;
    let list_to =
        |radius: f64| CellGrid::new(domain, positions, radius).list(domain, positions, positions, radius);
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

/// Number of pieces that particles make of which two belong together when they are nearer than `reach` \[m\].
pub fn pieces(positions: &[Vector], reach: f64) -> usize {
    let domain = domain_around(positions, reach);
    let list = CellGrid::new(&domain, positions, reach).list_among(&domain, positions, reach);
    let mut seen = vec![false; positions.len()];
    let mut count = 0;
    for start in 0..positions.len() {
        let mut open = if seen[start] { Vec::new() } else { vec![start] };
        count += open.len();
        seen[start] = true;
        while let Some(i) = open.pop() {
            for j in list.of(i).iter().map(|j| *j as usize) {
                if !seen[j] && (positions[i] - positions[j]).norm() < reach {
                    seen[j] = true;
                    open.push(j);
                }
            }
        }
    }
    count
}

/// Largest distance \[m\] of a particle of `left` from the nearest mirror image, by x → −x, of one of `right`.
pub fn asymmetry(left: &[Vector], right: &[Vector]) -> f64 {
    let nearest = |x: &Vector| {
        let image = Vector::new(-x.x, x.y);
        right.iter().map(|other| (other - image).norm()).fold(f64::INFINITY, f64::min)
    };
    left.iter().map(nearest).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(n: i32) -> Vec<Vector> {
        (0..n * n).map(|k| Vector::new(f64::from(k % n), f64::from(k / n))).collect()
    }

    #[test]
    fn pieces_are_counted_and_mirror_images_compared() {
        let left: Vec<Vector> = lattice(4).iter().map(|x| Vector::new(x.x - 8.0, x.y)).collect();
        let mut right: Vec<Vector> = left.iter().map(|x| Vector::new(-x.x, x.y)).collect();
        let all: Vec<Vector> = left.iter().chain(&right).copied().collect();
        assert_eq!((pieces(&all, 1.5), pieces(&all, 10.5), pieces(&[], 1.0)), (2, 1, 0));
        assert_eq!(asymmetry(&left, &right), 0.0);
        // A corner breaks off; its neighbours are one away from where it was.
        right[12].x += 2.0;
        let broken: Vec<Vector> = left.iter().chain(&right).copied().collect();
        assert_eq!((pieces(&broken, 1.5), asymmetry(&left, &right)), (3, 1.0));
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
