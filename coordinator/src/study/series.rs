//! Reading numbers off histories.

/// Least-squares line through points: intercept and slope.
pub fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
        / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
    (y - slope * x, slope)
}

/// The points with first coordinate from `start` to `end`.
pub fn window(points: &[(f64, f64)], start: f64, end: f64) -> Vec<(f64, f64)> {
    points.iter().copied().filter(|p| (start..=end).contains(&p.0)).collect()
}

/// Mean over time of the points from `start` to `end`, by trapezia.
pub fn mean(points: &[(f64, f64)], start: f64, end: f64) -> f64 {
    let points = window(points, start, end);
    let area: f64 = points.windows(2).map(|p| 0.5 * (p[0].1 + p[1].1) * (p[1].0 - p[0].0)).sum();
    match points[..] {
        [first, .., last] => area / (last.0 - first.0),
        _ => f64::NAN,
    }
}

/// The value at `x` between points of ascending first coordinate; not a number outside.
pub fn at(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|p| p.0 < x);
    match (after.checked_sub(1).and_then(|k| points.get(k)), points.get(after)) {
        (_, Some(b)) if b.0 == x => b.1,
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
        _ => f64::NAN,
    }
}

/// The first x at which the points reach `level` from below; not a number if they never do.
pub fn first_reach(points: &[(f64, f64)], level: f64) -> f64 {
    let crossing = points.windows(2).find(|p| p[0].1 < level && p[1].1 >= level);
    crossing.map_or(f64::NAN, |p| p[0].0 + (p[1].0 - p[0].0) * (level - p[0].1) / (p[1].1 - p[0].1))
}

/// Mean time between points where a history rises through its mean; not a number below two of them.
pub fn mean_period(points: &[(f64, f64)]) -> f64 {
    let mean = points.iter().map(|p| p.1).sum::<f64>() / points.len() as f64;
    let rises: Vec<f64> =
        points.windows(2).filter(|p| p[0].1 < mean && p[1].1 >= mean).map(|p| p[1].0).collect();
    match rises[..] {
        [first, .., last] => (last - first) / (rises.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// Largest value.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NAN, f64::max)
}

/// Largest rise of a history above its earlier minimum.
pub fn largest_rise(values: &[f64]) -> f64 {
    let mut lowest = f64::INFINITY;
    let mut rise = 0.0_f64;
    for value in values {
        rise = rise.max(value - lowest);
        lowest = lowest.min(*value);
    }
    rise
}

/// Mean, damping rate λ and angular frequency ω of `c + e^(−λt) (a cos ωt + b sin ωt)` fitted to points.
///
/// `guess` is λ and ω to start from; the linear part is solved exactly for each (λ, ω), which a shrinking pattern
/// search improves.
pub fn damped_oscillation(points: &[(f64, f64)], guess: (f64, f64)) -> (f64, f64, f64) {
    damped(points, guess, |_| 1.0)
}

/// Damping rate λ and angular frequency ω of `e^(−λt) (c + a cos ωt + b sin ωt)` fitted to points, as
/// [`damped_oscillation`] does: an energy that swings between two kinds and is lost.
pub fn damped_swings(points: &[(f64, f64)], guess: (f64, f64)) -> (f64, f64) {
    let (_, rate, omega) = damped(points, guess, |amplitude| amplitude);
    (rate, omega)
}

/// The fit whose mean is `mean` of e^(−λt) times a constant.
fn damped(points: &[(f64, f64)], guess: (f64, f64), mean: fn(f64) -> f64) -> (f64, f64, f64) {
    let (mut rate, mut omega) = guess;
    let (mut rate_step, mut omega_step) = (0.2 * omega, 0.05 * omega);
    let mut best = oscillation_residual(points, rate, omega, mean);
    for _ in 0..200 {
        let trials = [(rate_step, 0.0), (-rate_step, 0.0), (0.0, omega_step), (0.0, -omega_step)];
        let better = trials
            .into_iter()
            .map(|(r, w)| (rate + r, omega + w))
            .map(|(r, w)| (oscillation_residual(points, r, w, mean), r, w))
            .filter(|trial| trial.0.0 < best.0)
            .min_by(|a, b| a.0.0.total_cmp(&b.0.0));
        match better {
            Some((residual, r, w)) => (best, rate, omega) = (residual, r, w),
            None => (rate_step, omega_step) = (0.5 * rate_step, 0.5 * omega_step),
        }
    }
    (best.1, rate, omega)
}

/// Sum of squares that the best linear part leaves, and its mean c.
fn oscillation_residual(points: &[(f64, f64)], rate: f64, omega: f64, mean: fn(f64) -> f64) -> (f64, f64) {
    let basis = |t: f64| {
        let amplitude = (-rate * t).exp();
        [mean(amplitude), amplitude * (omega * t).cos(), amplitude * (omega * t).sin()]
    };
    // Normal equations, three by three, by elimination.
    let mut rows = [[0.0; 4]; 3];
    for (t, value) in points {
        let f = basis(*t);
        for (row, a) in rows.iter_mut().zip(f) {
            for (entry, b) in row.iter_mut().zip(f.into_iter().chain([*value])) {
                *entry += a * b;
            }
        }
    }
    for k in 0..3 {
        for i in 0..3 {
            if i != k {
                let factor = rows[i][k] / rows[k][k];
                let pivot = rows[k];
                rows[i].iter_mut().zip(pivot).for_each(|(entry, p)| *entry -= factor * p);
            }
        }
    }
    let solution: [f64; 3] = std::array::from_fn(|k| rows[k][3] / rows[k][k]);
    let model = |t: f64| basis(t).iter().zip(solution).map(|(f, c)| f * c).sum::<f64>();
    (points.iter().map(|(t, value)| (value - model(*t)).powi(2)).sum(), solution[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_and_its_window_are_recovered() {
        let points: Vec<(f64, f64)> = (0..50).map(|k| (f64::from(k), 3.0 - 0.5 * f64::from(k))).collect();
        let (intercept, slope) = line(&window(&points, 10.0, 20.0));
        // Round-off of sums of ten terms.
        assert!((intercept - 3.0).abs() < 1e-12 && (slope + 0.5).abs() < 1e-13);
        assert_eq!(at(&points, 1.5), 2.25);
        assert!(at(&points, -1.0).is_nan());
        assert_eq!(mean(&points, 0.0, 2.0), 2.5);
    }

    #[test]
    fn a_damped_oscillation_is_recovered() {
        let signal = |t: f64| 0.3 + (-0.07 * t).exp() * (0.05 * (1.76 * t).cos() - 0.01 * (1.76 * t).sin());
        let points: Vec<(f64, f64)> = (0..600).map(|k| 0.05 * f64::from(k)).map(|t| (t, signal(t))).collect();
        // Rises are found to one sample in eight periods.
        assert!((mean_period(&points) * 1.76 / std::f64::consts::TAU - 1.0).abs() < 0.01);
        let (mean, rate, omega) = damped_oscillation(&points, (0.1, 1.7));
        // The pattern search ends at steps of 1e-9.
        assert!((mean - 0.3).abs() < 1e-6 && (rate - 0.07).abs() < 1e-6 && (omega - 1.76).abs() < 1e-6);
    }

    #[test]
    fn swings_of_an_energy_that_is_lost_are_recovered() {
        let energy = |t: f64| (-0.4 * t).exp() * (1.0 + 0.9 * (2.0 * t).cos() - 0.1 * (2.0 * t).sin());
        let points: Vec<(f64, f64)> = (0..400).map(|k| 0.05 * f64::from(k)).map(|t| (t, energy(t))).collect();
        let (rate, omega) = damped_swings(&points, (0.1, 1.9));
        assert!((rate - 0.4).abs() < 1e-6 && (omega - 2.0).abs() < 1e-6, "{rate} {omega}");
        // About a mean that stays it is another one.
        let (_, _, otherwise) = damped_oscillation(&points, (0.1, 1.9));
        assert!((otherwise - 2.0).abs() > 0.01, "{otherwise}");
    }

    #[test]
    fn rises_and_crossings() {
        assert_eq!(largest_rise(&[5.0, 4.0, 4.5, 3.0, 3.2]), 0.5);
        assert_eq!(first_reach(&[(0.0, 1.0), (1.0, 3.0)], 2.0), 0.5);
        assert!(first_reach(&[(0.0, 1.0), (1.0, 3.0)], 4.0).is_nan());
    }
}
