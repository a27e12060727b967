//! Noise of the loads of the water on walls and bodies.

/// Rows that a window must have for its trend and what departs from it.
const LEAST_ROWS: usize = 6;

/// Windows under load from which a median is taken.
const LEAST_WINDOWS: usize = 5;

/// Windows in which the load is below this part of its mean do not count: there a ratio to the load has no meaning.
const LEAST_LOAD: f64 = 0.5;

/// How much a load swings faster than a time `window` \[s\], over the load itself \[-\].
///
/// Over each window: root mean square of what is left of all components when their straight line in time is taken off,
/// over the magnitude of their mean. Of these the median: impacts, which are short, have no say; ringing, which stays,
/// has. `None` where rows are too far apart or the load acts too shortly. `rows` are times with components \[N\].
pub fn noise(rows: &[(f64, Vec<f64>)], window: f64) -> Option<f64> {
    let start = rows.first()?.0;
    // Windows are counted from the start, so that one more row at the end shifts none.
    let number = |row: &(f64, Vec<f64>)| ((row.0 - start) / window).floor();
    let windows: Vec<(f64, f64)> = rows
        .chunk_by(|a, b| number(a) == number(b))
        .filter(|rows| rows.len() >= LEAST_ROWS)
        .map(swing)
        .filter(|(swing, load)| swing.is_finite() && load.is_finite())
        .collect();
    // Counts far below 2^53. A mean of nothing is no number, and no window is above it.
    let mean = windows.iter().map(|(_, load)| *load).sum::<f64>() / windows.len() as f64;
    let mut ratios: Vec<f64> = windows
        .iter()
        .filter(|(_, load)| *load > LEAST_LOAD * mean)
        .map(|(swing, load)| swing / load)
        .collect();
    ratios.sort_by(f64::total_cmp);
    (ratios.len() >= LEAST_WINDOWS).then(|| ratios[ratios.len() / 2])
}

/// Root mean square about the straight line, and magnitude of the mean.
fn swing(rows: &[(f64, Vec<f64>)]) -> (f64, f64) {
    // Counts far below 2^53.
    let n = rows.len() as f64;
    let time = rows.iter().map(|row| row.0).sum::<f64>() / n;
    let spread: f64 = rows.iter().map(|row| (row.0 - time).powi(2)).sum();
    let (mut square, mut load) = (0.0, 0.0);
    for k in 0..rows[0].1.len() {
        let mean = rows.iter().map(|row| row.1[k]).sum::<f64>() / n;
        let slope = rows.iter().map(|row| (row.0 - time) * row.1[k]).sum::<f64>() / spread;
        square += rows.iter().map(|row| (row.1[k] - mean - slope * (row.0 - time)).powi(2)).sum::<f64>() / n;
        load += mean * mean;
    }
    (square.sqrt(), load.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(of: impl Fn(f64) -> f64) -> Vec<(f64, Vec<f64>)> {
        (0..2000).map(|k| 1e-3 * f64::from(k)).map(|t| (t, vec![of(t), 0.5 * of(t)])).collect()
    }

    #[test]
    fn ringing_is_noise_and_slow_change_and_one_impact_are_not() {
        let ringing = load(|t| 10.0 + 4.0 * (std::f64::consts::TAU * 200.0 * t).sin());
        // A sine has 1/√2 of its amplitude; windows of four periods keep it up to what their line takes off.
        let noise_of_it = noise(&ringing, 0.02).unwrap();
        assert!((noise_of_it - 0.4 / 2f64.sqrt()).abs() < 0.01, "{noise_of_it}");
        let slow = load(|t| 10.0 + 5.0 * (std::f64::consts::TAU * t).sin());
        assert!(noise(&slow, 0.02).unwrap() < 0.002);
        let struck = load(|t| 10.0 + if (1.0..1.01).contains(&t) { 300.0 } else { 0.0 });
        assert!(noise(&struck, 0.02).unwrap() < 1e-9);
        // Silence after a load says nothing about the load.
        let brief = load(|t| if t < 0.05 { 10.0 } else { 1e-9 * (1000.0 * t).sin() });
        assert_eq!(noise(&brief, 0.02), None);
        assert_eq!(noise(&ringing, 0.004), None, "rows are too far apart");
        assert_eq!(noise(&[], 0.01), None);
    }
}
