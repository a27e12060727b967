//! What a set of runs shows together: which are worth their cost.

/// Which of the points (cost, error) lie on the Pareto front: no other is at least as good in both and better in one.
/// Points with anything that is no number lie on none.
pub fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    let numbers = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    points
        .iter()
        .map(|p| numbers(p) && !points.iter().any(|other| numbers(other) && beats(other, p)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [(1.0, 0.1), (2.0, 0.05), (2.0, 0.2), (3.0, 0.05), (4.0, 0.01), (0.5, f64::NAN)];
        assert_eq!(pareto(&points), [true, true, false, false, true, false]);
        // Two equal ones are both on it.
        assert_eq!(pareto(&[(1.0, 1.0), (1.0, 1.0)]), [true, true]);
    }
}
