//! Tests of the background grid.

use sph::lanes::Arithmetic;
use sph::space::{Plane, Vector};

use super::*;

/// The nodes lie closer along periodic axes.
const SPACINGS: NodeSpacings = NodeSpacings { open: 0.013, periodic: 0.01 };

fn scattered(count: usize, lower: Vector, size: Vector) -> Vec<Vector> {
    // The fractions of multiples of two irrational numbers.
    let place = |k: usize, a: f64| (k as f64 * a).fract();
    (0..count)
        .map(|k| lower + Vector::new(place(k, 0.754_878), place(k, 0.569_840)).component_mul(&size))
        .collect()
}

fn sorted(domain: &Domain, positions: &[Vector]) -> (CellGrid, Vec<Vector>) {
    let cells = CellGrid::new(domain, positions, 0.026);
    let sorted = cells.order().iter().map(|k| positions[*k as usize]).collect();
    (cells, sorted)
}

fn grid(domain: &Domain, cells: &CellGrid) -> BackgroundGrid {
    let mut grid = BackgroundGrid::default();
    grid.place::<Plane>(domain, cells, SPACINGS, 0.005, 77);
    grid
}

/// Adds values 1, 2, ... of particles at `positions` to nodes, the first of which has the index `origin`.
fn spread(
    grid: &BackgroundGrid,
    positions: &[Vector],
    particles: Range<usize>,
    nodes: &mut [f64],
    origin: usize,
) {
    let particles = particles.map(|i| (positions[i], 1.0 + i as f64));
    grid.spread::<Plane>(Arithmetic::best(), particles, nodes, origin);
}

/// The mean of `nodes` at `x`.
fn read(grid: &BackgroundGrid, x: Vector, nodes: &[f64]) -> f64 {
    let mut mean = f64::NAN;
    grid.read::<Plane>(Arithmetic::best(), [x].into_iter(), nodes, [&mut mean].into_iter());
    mean
}

#[test]
fn bands_sum_what_one_particle_after_the_other_sums() {
    for periodic in [[false, false], [true, false], [false, true], [true, true]] {
        let domain = Domain { lower: Vector::new(-0.2, 0.1), upper: Vector::new(0.3, 0.8), periodic };
        let (cells, mut positions) = sorted(&domain, &scattered(700, domain.lower, domain.size()));
        let grid = grid(&domain, &cells);
        // Particles move by at most 0.005 m before the lists are rebuilt.
        for (k, x) in positions.iter_mut().enumerate() {
            let angle = k as f64;
            *x += Vector::new(angle.cos(), angle.sin()) * 0.0049;
        }
        let mut nodes = vec![0.0; grid.len()];
        grid.for_each_band(&mut nodes, &|particles, nodes, origin| {
            spread(&grid, &positions, particles, nodes, origin);
        });
        let mut expected = vec![0.0; grid.len()];
        spread(&grid, &positions, 0..positions.len(), &mut expected, 0);
        let total: f64 = nodes.iter().sum();
        assert!((total / (350.5 * 700.0) - 1.0).abs() < 1e-12, "{periodic:?}: {total}");
        let largest = nodes.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest < 1e-11, "{periodic:?}: {largest}");
    }
}

#[test]
fn nodes_that_were_shifted_are_where_nodes_are_placed() {
    for periodic in [[false, false], [true, false]] {
        let domain = Domain { lower: Vector::new(-0.2, 0.1), upper: Vector::new(0.3, 0.8), periodic };
        let (cells, positions) = sorted(&domain, &scattered(700, domain.lower, domain.size()));
        // Along the first axis the nodes have come back by a spacing in between.
        let (mut shifted, mut placed) = (grid(&domain, &cells), BackgroundGrid::default());
        shifted.shift::<Plane>(&domain, &cells, SPACINGS, 0.005, 103);
        placed.place::<Plane>(&domain, &cells, SPACINGS, 0.005, 103);
        let sums = |grid: &BackgroundGrid| -> Vec<f64> {
            let mut nodes = vec![0.0; grid.len()];
            grid.for_each_band(&mut nodes, &|particles, nodes, origin| {
                spread(grid, &positions, particles, nodes, origin);
            });
            grid.fold(&mut nodes, |a, b| a + b);
            positions.iter().map(|x| read(grid, *x, &nodes)).collect()
        };
        let pairs = sums(&shifted).into_iter().zip(sums(&placed));
        assert!(pairs.into_iter().all(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{periodic:?}");
    }
}

#[test]
fn marked_nodes_are_those_on_which_a_particle_has_a_weight() {
    let domain = Domain { lower: Vector::zeros(), upper: Vector::new(0.5, 0.4), periodic: [true, false] };
    let (cells, positions) = sorted(&domain, &scattered(500, domain.lower, domain.size()));
    let grid = grid(&domain, &cells);
    for x in &positions[..20] {
        let (mut weights, mut marks) = (vec![0.0; grid.len()], vec![false; grid.len()]);
        grid.spread::<Plane>(Arithmetic::best(), [(*x, 1.0)].into_iter(), &mut weights, 0);
        grid.mark::<Plane>([*x].into_iter(), &mut marks, 0);
        assert!(marks.iter().filter(|mark| **mark).count() == 16);
        assert!(weights.iter().zip(&marks).all(|(weight, mark)| (*weight > 0.0) == *mark));
    }
}

#[test]
fn images_of_a_node_have_the_same_sum() {
    let domain = Domain { lower: Vector::zeros(), upper: Vector::new(0.5, 0.4), periodic: [true, true] };
    let (cells, positions) = sorted(&domain, &scattered(500, domain.lower, domain.size()));
    let grid = grid(&domain, &cells);
    let mut nodes = vec![0.0; grid.len()];
    spread(&grid, &positions, 0..positions.len(), &mut nodes, 0);
    grid.fold(&mut nodes, |a, b| a + b);
    // Each particle reads the same sums through the opposite side.
    for x in &positions[..20] {
        let near = Vector::new(x.x * 0.01, x.y);
        let image = near + Vector::new(0.5, 0.0);
        assert!((read(&grid, near, &nodes) / read(&grid, image, &nodes) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_stray_particle_costs_no_memory() {
    let domain = Domain { lower: Vector::repeat(-1e4), upper: Vector::repeat(1e4), periodic: [false, false] };
    let mut positions = scattered(2000, Vector::zeros(), Vector::new(0.5, 0.4));
    let (cells, _) = sorted(&domain, &positions);
    let few = grid(&domain, &cells).len();
    positions.push(Vector::new(40.0, 0.7));
    let (cells, sorted) = sorted(&domain, &positions);
    let grid = grid(&domain, &cells);
    // Nodes for all of the box of the particles would be sixty times as many.
    assert!(grid.len() < 8 * few, "{} {few}", grid.len());
    let ones = vec![1.0; grid.len()];
    assert!(sorted.iter().all(|x| (read(&grid, *x, &ones) - 1.0).abs() < 1e-14));
    assert_eq!(read(&grid, Vector::new(20.0, 0.2), &ones), 0.0);
}

#[test]
fn what_has_a_weight_on_nodes_of_the_fluid_counts_wherever_it_lies() {
    // Boxes whose last cells are from once to twice as long as the others.
    for length in [0.26, 0.27, 0.28] {
        let size = Vector::new(length, 0.2);
        let domain = Domain { lower: Vector::zeros(), upper: size, periodic: [false, false] };
        let (cells, mut positions) = sorted(&domain, &scattered(900, Vector::zeros(), size));
        let grid = grid(&domain, &cells);
        // After the farthest moves, in all directions.
        for (k, x) in positions.iter_mut().enumerate() {
            let angle = k as f64;
            *x += Vector::new(angle.cos(), angle.sin()) * 0.0049;
        }
        let mut fluid = vec![0.0; grid.len()];
        spread(&grid, &positions, 0..positions.len(), &mut fluid, 0);
        // Others on a lattice all around, each of which has the weight one on all nodes together.
        let others: Vec<_> = (-100..200)
            .flat_map(|i| (-100..200).map(move |j| Vector::new(f64::from(i), f64::from(j)) * 0.0026))
            .collect();
        let mut all = vec![0.0; grid.len()];
        grid.spread::<Plane>(Arithmetic::best(), others.iter().map(|x| (*x, 1.0)), &mut all, 0);
        // Five to a spacing along each axis.
        let complete = |(fluid, all): (&f64, &f64)| *fluid == 0.0 || (all / 25.0 - 1.0).abs() < 1e-12;
        let missing = fluid.iter().zip(&all).filter(|(fluid, all)| !complete((fluid, all))).count();
        assert_eq!(missing, 0, "{length}");
    }
}
