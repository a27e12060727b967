use super::*;

/// All operations on numbers that need no rounding, and so must agree on every path.
struct Operations;

impl LanePass for Operations {
    type Output = Vec<f64>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<f64> {
        let (a, b) = (L::from_array([1.0, 2.0, 3.0, 4.0]), L::from_array([16.0, 4.0, 1.0, 0.25]));
        let rows =
            [[0.0, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 7.0], [8.0, 9.0, 10.0, 11.0], [12.0, 13.0, 14.0, 15.0]];
        let columns = L::columns([&rows[0], &rows[1], &rows[2], &rows[3]]);
        let mut results: Vec<L> =
            vec![a + b, a - b, a * b, a / b, b.sqrt(), a.max(b), a.min(b), L::splat(7.0)];
        results.extend([a.plus_product(a, b), a.minus_product(a, b), a.choose_below(b, a, b), L::zero()]);
        results.extend(columns);
        results.extend(L::halves([&[0.0, 1.0], &[2.0, 3.0], &[4.0, 5.0], &[6.0, 7.0]]));
        let mut numbers: Vec<f64> = results.into_iter().flat_map(L::to_array).collect();
        numbers.push(f64::from(a.below(b)));
        numbers.extend(L::sums(columns));
        numbers
    }
}

#[test]
fn every_path_does_what_its_operations_say() {
    let expected: Vec<f64> = [
        [17.0, 6.0, 4.0, 4.25],
        [-15.0, -2.0, 2.0, 3.75],
        [16.0, 8.0, 3.0, 1.0],
        [0.0625, 0.5, 3.0, 16.0],
        [4.0, 2.0, 1.0, 0.5],
        [16.0, 4.0, 3.0, 4.0],
        [1.0, 2.0, 1.0, 0.25],
        [7.0; 4],
        [17.0, 10.0, 6.0, 5.0],
        [-15.0, -6.0, 0.0, 3.0],
        [1.0, 2.0, 1.0, 0.25],
        [0.0; 4],
        [0.0, 4.0, 8.0, 12.0],
        [1.0, 5.0, 9.0, 13.0],
        [2.0, 6.0, 10.0, 14.0],
        [3.0, 7.0, 11.0, 15.0],
        [0.0, 2.0, 4.0, 6.0],
        [1.0, 3.0, 5.0, 7.0],
    ]
    .into_iter()
    .flatten()
    .chain([3.0, 24.0, 28.0, 32.0, 36.0])
    .collect();
    for arithmetic in Arithmetic::all() {
        assert_eq!(arithmetic.run(Operations), expected, "{}", arithmetic.name());
    }
}

/// 1 − (1 − ε)(1 + ε) is ε² when fused, and zero when the product is rounded first.
struct Fused;

impl LanePass for Fused {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let (a, b) = (L::splat(1.0 - f64::EPSILON), L::splat(1.0 + f64::EPSILON));
        L::splat(1.0).minus_product(a, b).to_array()[0]
    }
}

#[test]
fn the_paths_round_as_their_names_say() {
    let fused = f64::EPSILON * f64::EPSILON;
    for arithmetic in Arithmetic::all() {
        let expected = if arithmetic.name().ends_with("fma") { fused } else { 0.0 };
        assert_eq!(arithmetic.run(Fused), expected, "{}", arithmetic.name());
    }
}

#[test]
fn sums_group_the_lanes_in_pairs() {
    struct Sum;
    impl LanePass for Sum {
        type Output = f64;
        #[inline(always)]
        fn run<L: Lanes>(self) -> f64 {
            L::sums([L::from_array([1e16, 1.0, -1e16, 1.0]); 4])[0]
        }
    }
    // 1e16 + 1 rounds to 1e16 and −1e16 + 1 to −1e16 + 2: the grouping shows.
    let expected = (1e16 + 1.0) + (-1e16 + 1.0);
    for arithmetic in Arithmetic::all() {
        assert_eq!(arithmetic.run(Sum), expected);
    }
}

#[test]
fn an_unknown_path_is_refused_with_the_choices() {
    assert_eq!("avx2".parse(), Ok(Path::Avx2));
    let error = "sse".parse::<Path>().unwrap_err();
    assert!(error.contains("`sse`") && error.contains("`portable` or `avx2`"), "{error}");
    assert_eq!(Arithmetic::of(Path::Portable).unwrap().name(), "f64x4-portable");
}

#[test]
fn a_path_is_forced_once_for_the_whole_process() {
    assert_eq!((forced(), Arithmetic::chosen()), (None, Arithmetic::best()));
    force(Path::Portable).unwrap();
    force(Path::Portable).unwrap();
    assert_eq!((forced(), Arithmetic::chosen().name()), (Some(Path::Portable), "f64x4-portable"));
    if Arithmetic::of(Path::Avx2).is_ok() {
        assert!(force(Path::Avx2).unwrap_err().contains("this process takes `portable`"));
    }
}
