use super::*;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space, Spatial, Vector};

#[test]
fn targets_beyond_the_sources_find_those_in_the_last_cell() {
    let domain: Domain = Domain { lower: Vector::zeros(), upper: Vector::repeat(1.0), periodic: [false; 2] };
    // 2.9 radii long: the last source lies past two whole cells and is binned in the second.
    let sources = [Vector::zeros(), Vector::new(0.29, 0.0)];
    let targets = [Vector::new(0.385, 0.0)];
    let grid = CellGrid::new(&domain, &sources, 0.1);
    assert_eq!(grid.list(&domain, &targets, &sources, 0.1).of(0), &[1]);
}

/// Pseudo-random positions over the box, some exactly on cell borders.
fn scatter<S: Space>(domain: &Domain<S>, n: usize, seed: u64) -> Vec<S::Vector> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let size = domain.size();
    (0..n)
        .map(|k| {
            let mut x = domain.lower;
            for axis in 0..S::DIMENSIONS {
                let u = next();
                x[axis] += size[axis] * if k % 3 == 0 { (u * 10.0).floor() / 10.0 } else { u };
            }
            x
        })
        .collect()
}

fn brute_force<S: Space>(
    domain: &Domain<S>,
    targets: &[S::Vector],
    sources: &[S::Vector],
    radius: f64,
    own: bool,
) -> Vec<Vec<u32>> {
    targets
        .iter()
        .enumerate()
        .map(|(i, x)| {
            (0..sources.len())
                .filter(|j| !(own && *j == i))
                .filter(|j| domain.separation(x, &sources[*j]).norm_squared() < radius * radius)
                .map(|j| j as u32)
                .collect()
        })
        .collect()
}

fn sorted_rows(list: &NeighbourList) -> Vec<Vec<u32>> {
    (0..list.targets())
        .map(|i| {
            let mut row = list.of(i).to_vec();
            row.sort_unstable();
            row
        })
        .collect()
}

fn lists_equal_brute_force<S: Space>(periodic: S::Of<bool>) {
    let lower = S::Vector::repeat(0.2);
    let domain = Domain::<S> { lower, upper: lower + S::Vector::repeat(1.0), periodic };
    for (seed, radius) in [(1, 0.1), (2, 0.23), (3, 0.49), (4, 0.03)] {
        let positions = scatter(&domain, 300, seed);
        let others = scatter(&domain, 150, seed + 100);
        let grid = CellGrid::new(&domain, &positions, radius);
        let list = grid.list_among(&domain, &positions, radius);
        assert_eq!(sorted_rows(&list), brute_force(&domain, &positions, &positions, radius, true));
        let list = grid.list(&domain, &others, &positions, radius);
        assert_eq!(sorted_rows(&list), brute_force(&domain, &others, &positions, radius, false));
    }
}

#[test]
fn lists_equal_brute_force_also_on_cell_borders_and_across_periodic_sides() {
    for sides in 0..8_u8 {
        let periodic = |axis: u32| sides & (1 << axis) != 0;
        lists_equal_brute_force::<Spatial>([periodic(0), periodic(1), periodic(2)]);
        if !periodic(2) {
            lists_equal_brute_force::<Plane>([periodic(0), periodic(1)]);
        }
    }
}

#[test]
fn targets_outside_the_sources_are_found() {
    let domain: Domain =
        Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] };
    let sources = [Vector::new(0.5, 0.5), Vector::new(0.55, 0.5)];
    let targets =
        [Vector::new(0.41, 0.5), Vector::new(0.64, 0.5), Vector::new(-9.0, 0.5), Vector::new(0.5, 7.0)];
    let grid = CellGrid::new(&domain, &sources, 0.1);
    let list = grid.list(&domain, &targets, &sources, 0.1);
    assert_eq!(sorted_rows(&list), brute_force(&domain, &targets, &sources, 0.1, false));
    assert_eq!(list.of(0), [0]);
}

/// The body that [`largest_body`] finds, by passing the lowest index along all links until none changes.
fn largest_by_labels<S: Space>(domain: &Domain<S>, positions: &[S::Vector], link: f64) -> Vec<u32> {
    let links = brute_force(domain, positions, positions, link, true);
    let mut labels: Vec<u32> = (0..positions.len() as u32).collect();
    loop {
        let lowest = |i: usize| links[i].iter().map(|j| labels[*j as usize]).fold(labels[i], u32::min);
        let next: Vec<u32> = (0..labels.len()).map(lowest).collect();
        if next == labels {
            break;
        }
        labels = next;
    }
    let of = |label: u32| (0..labels.len() as u32).filter(|i| labels[*i as usize] == label).collect();
    // Of equal sizes `max_by_key` takes the last.
    (0..labels.len() as u32).rev().map(of).max_by_key(|body: &Vec<u32>| body.len()).unwrap_or_default()
}

fn largest_body_equals_labels<S: Space>(link: f64) {
    for sides in [false, true] {
        let lower = S::Vector::repeat(0.2);
        let domain = Domain::<S> { lower, upper: lower + S::Vector::repeat(1.0), periodic: S::splat(sides) };
        for (seed, link) in [(1, 0.5 * link), (2, link), (3, 1.3 * link), (4, 2.0 * link)] {
            let positions = scatter(&domain, 300, seed);
            let mut body = largest_body(&domain, &positions, link);
            body.sort_unstable();
            assert_eq!(body, largest_by_labels(&domain, &positions, link), "{link}");
        }
    }
    assert!(largest_body(&unit_box::<S>(), &[], 0.1).is_empty());
}

#[test]
fn the_largest_body_is_what_links_connect() {
    // About the distance at which 300 points of a unit box become one body.
    largest_body_equals_labels::<Plane>(0.065);
    largest_body_equals_labels::<Spatial>(0.12);
}

/// A box of edge 1 m without periodic sides.
fn unit_box<S: Space>() -> Domain<S> {
    Domain { lower: S::Vector::zeros(), upper: S::Vector::repeat(1.0), periodic: S::splat(false) }
}

fn stray_particle_costs_no_memory<S: Space>() {
    let domain = unit_box::<S>();
    let mut positions = scatter(&domain, 100, 9);
    let mut stray = S::Vector::repeat(-1e9);
    stray[0] = 1e12;
    positions.push(stray);
    let grid = CellGrid::new(&domain, &positions, 0.05);
    let counts = grid.counts();
    assert!((0..S::DIMENSIONS).map(|axis| counts[axis]).product::<usize>() < 1000);
    let list = grid.list_among(&domain, &positions, 0.05);
    assert_eq!(sorted_rows(&list), brute_force(&domain, &positions, &positions, 0.05, true));
}

#[test]
fn a_stray_particle_does_not_cost_memory() {
    stray_particle_costs_no_memory::<Plane>();
    stray_particle_costs_no_memory::<Spatial>();
}

fn order_is_that_of_one_thread<S: Space>() {
    let mut domain = unit_box::<S>();
    domain.periodic[0] = true;
    let positions = scatter(&domain, 3000, 5);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| CellGrid::new(&domain, &positions, 0.05).list_among(&domain, &positions, 0.05))
    };
    assert_eq!(build(1), build(4));
}

#[test]
fn lists_have_the_same_order_on_any_number_of_threads() {
    order_is_that_of_one_thread::<Plane>();
    order_is_that_of_one_thread::<Spatial>();
}

fn cell_order_keeps_rows_together<S: Space>() {
    let positions = scatter(&unit_box::<S>(), 500, 6);
    let order = CellGrid::new(&unit_box::<S>(), &positions, 0.2).order().to_vec();
    let mut seen = order.clone();
    seen.sort_unstable();
    assert_eq!(seen, (0..500).collect::<Vec<_>>());
    // The last axis counts slowest.
    let last = S::DIMENSIONS - 1;
    let lower = positions.iter().map(|x| x[last]).fold(f64::INFINITY, f64::min);
    let rows: Vec<i64> = order
        .iter()
        .map(|k| ((positions[*k as usize][last] - lower) * (1.0 / 0.2)).floor().min(3.0) as i64)
        .collect();
    assert!(rows.is_sorted());
}

#[test]
fn cell_order_is_a_permutation_that_keeps_rows_together() {
    cell_order_keeps_rows_together::<Plane>();
    cell_order_keeps_rows_together::<Spatial>();
}
