use super::*;
use crate::space::Vector;

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
fn scatter(domain: &Domain, n: usize, seed: u64) -> Vec<Vector> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let size = domain.size();
    (0..n)
        .map(|k| {
            let (u, v) = (next(), next());
            let snap = |u: f64| if k % 3 == 0 { (u * 10.0).floor() / 10.0 } else { u };
            domain.lower + Vector::new(snap(u) * size.x, snap(v) * size.y)
        })
        .collect()
}

fn brute_force(
    domain: &Domain,
    targets: &[Vector],
    sources: &[Vector],
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

#[test]
fn lists_equal_brute_force_also_on_cell_borders_and_across_periodic_sides() {
    for periodic in [[false, false], [true, false], [false, true], [true, true]] {
        let domain: Domain = Domain { lower: Vector::new(-0.3, 0.2), upper: Vector::new(0.7, 1.2), periodic };
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

#[test]
fn a_stray_particle_does_not_cost_memory() {
    let domain: Domain =
        Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] };
    let mut positions = scatter(&domain, 100, 9);
    positions.push(Vector::new(1e12, -1e9));
    let grid = CellGrid::new(&domain, &positions, 0.05);
    let [columns, rows] = grid.counts();
    assert!(columns * rows < 1000);
    let list = grid.list_among(&domain, &positions, 0.05);
    assert_eq!(sorted_rows(&list), brute_force(&domain, &positions, &positions, 0.05, true));
}

#[test]
fn lists_have_the_same_order_on_any_number_of_threads() {
    let domain: Domain =
        Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [true, false] };
    let positions = scatter(&domain, 3000, 5);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| CellGrid::new(&domain, &positions, 0.05).list_among(&domain, &positions, 0.05))
    };
    assert_eq!(build(1), build(4));
}

#[test]
fn cell_order_is_a_permutation_that_keeps_rows_together() {
    let domain: Domain =
        Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] };
    let positions = scatter(&domain, 500, 6);
    let order = CellGrid::new(&domain, &positions, 0.2).order().to_vec();
    let mut seen = order.clone();
    seen.sort_unstable();
    assert_eq!(seen, (0..500).collect::<Vec<_>>());
    let lower = positions.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    let rows: Vec<i64> = order
        .iter()
        .map(|k| ((positions[*k as usize].y - lower) * (1.0 / 0.2)).floor().min(3.0) as i64)
        .collect();
    assert!(rows.is_sorted());
}
