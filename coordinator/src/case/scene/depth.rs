//! The depth of the water at the start.

use std::collections::HashSet;

use sph::setup::FluidParticles;
use sph::space::Space;
use sph::space::domain::Domain;

/// Side of the boxes in particle spacings: no box inside water is empty, however its particles stand.
const BOX: f64 = 2.0;

/// Volume of the fluid over the area of its faces, at walls and free ones alike \[m\]: half the depth of a wide layer, a
/// quarter of the side of a square, a sixth of that of a cube. Half the shortest period where there are no faces; zero
/// without particles.
///
/// Faces are those of the boxes of two spacings that hold particles.
pub fn mean_depth<S: Space>(fluid: &FluidParticles<S>, domain: &Domain<S>, spacing: f64) -> f64 {
    let side = BOX * spacing;
    let count = |axis: usize| (domain.size()[axis] / side).ceil() as i64;
    // In the plane the third is 0.
    let cell = |x: &S::Vector| {
        let mut cell = [0; 3];
        for (axis, k) in cell.iter_mut().enumerate().take(S::DIMENSIONS) {
            *k = ((x[axis] - domain.lower[axis]) / side).floor() as i64;
        }
        cell
    };
    let filled: HashSet<[i64; 3]> = fluid.position.iter().map(cell).collect();
    let neighbour = |mut cell: [i64; 3], axis: usize, step: i64| {
        cell[axis] += step;
        if domain.periodic[axis] {
            cell[axis] = cell[axis].rem_euclid(count(axis));
        }
        cell
    };
    let is_face = |cell: &[i64; 3], axis: usize, step: i64| !filled.contains(&neighbour(*cell, axis, step));
    let sides = || (0..S::DIMENSIONS).flat_map(|axis| [(axis, -1), (axis, 1)]);
    let faces = filled
        .iter()
        .flat_map(|cell| sides().map(move |(axis, step)| (cell, axis, step)))
        .filter(|(cell, axis, step)| is_face(cell, *axis, *step))
        .count();
    if faces > 0 {
        return side * filled.len() as f64 / faces as f64;
    }
    let periods = (0..S::DIMENSIONS).filter(|axis| domain.periodic[*axis]).map(|axis| domain.size()[axis]);
    if filled.is_empty() { 0.0 } else { 0.5 * periods.fold(f64::INFINITY, f64::min) }
}

#[cfg(test)]
mod tests {
    use sph::space::{Spatial, Vector};

    use super::*;

    fn block(columns: usize, rows: usize, periodic: [bool; 2]) -> (FluidParticles, Domain) {
        let mut fluid = FluidParticles::default();
        for k in 0..columns * rows {
            let [i, j] = [k % columns, k / columns].map(|n| (n as f64 + 0.5) * 0.1);
            fluid.position.push(Vector::new(i, j));
        }
        let upper = Vector::new(columns as f64 * 0.1, 2.0 * rows as f64 * 0.1);
        (fluid, Domain { lower: Vector::zeros(), upper, periodic })
    }

    #[test]
    fn depth_is_volume_over_faces() {
        // 4 x 2 m: 8 m² over 12 m. Lattices and boxes agree, so that only round-off is left.
        let (fluid, domain) = block(40, 20, [false, false]);
        assert!((mean_depth(&fluid, &domain, 0.1) - 8.0 / 12.0).abs() < 1e-12);
        // A layer of 2 m that repeats along x has two faces.
        let (fluid, domain) = block(40, 20, [true, false]);
        assert!((mean_depth(&fluid, &domain, 0.1) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn water_without_faces_is_as_deep_as_half_its_shorter_period() {
        let (fluid, mut domain) = block(40, 20, [true, true]);
        domain.upper.y = 2.0;
        assert_eq!(mean_depth(&fluid, &domain, 0.1), 1.0);
        assert_eq!(mean_depth(&FluidParticles::default(), &domain, 0.1), 0.0);
    }

    #[test]
    fn a_cube_has_six_faces() {
        let mut fluid = FluidParticles::<Spatial>::default();
        for k in 0..8_000 {
            let place = [k % 20, k / 20 % 20, k / 400].map(|n| (f64::from(n) + 0.5) * 0.1);
            fluid.position.push(place.into());
        }
        let upper = [4.0; 3].into();
        let domain = Domain { lower: [0.0; 3].into(), upper, periodic: [false; 3] };
        assert!((mean_depth::<Spatial>(&fluid, &domain, 0.1) - 2.0 / 6.0).abs() < 1e-12);
    }
}
