//! Resolutions of a convergence study that names none.

use crate::case::Case;

/// Spacings, each over the next finer one. The steps are well apart (Celik et al. 2008 ask for 1.3), and all three runs
/// together cost half as much again as the finest.
const RATIO: f64 = 1.5;

/// Three spacings \[m\], the finest that of `case`. In a periodic domain the coarser ones divide its periods where such are
/// near.
pub fn spacings(case: &Case) -> Vec<f64> {
    let file = case.file();
    let fluid = file.fluid.as_ref().map(|fluid| fluid.parameters.particle_spacing);
    let solid = file.solid.as_ref().map(|solid| solid.particle_spacing_m.value);
    let Some(own) = fluid.or(solid) else { return Vec::new() };
    let periods: Vec<f64> = case.periods();
    vec![own, fitting(own * RATIO, &periods), fitting(own * RATIO * RATIO, &periods)]
}

/// Two sound speeds \[m/s\], the higher that of `case`; none where there is no water.
pub fn sound_speeds(case: &Case) -> Vec<f64> {
    let own = case.file().fluid.as_ref().map(|fluid| fluid.parameters.sound_speed);
    own.map_or(Vec::new(), |own| vec![own, rounded(own / RATIO)])
}

/// The spacing nearest to `wanted` that divides all `periods`, among those with about as many particles; `wanted` where none
/// does.
fn fitting(wanted: f64, periods: &[f64]) -> f64 {
    let Some(first) = periods.first() else { return rounded(wanted) };
    let count = (first / wanted).round();
    let candidates =
        (-4..=4).map(|k| count + f64::from(k)).filter(|count| *count >= 1.0).map(|count| first / count);
    // Round-off of a quotient, far below what a case would refuse.
    let divides = |spacing: &f64| {
        periods.iter().all(|p| ((p / spacing).round() - p / spacing).abs() < 1e-9 * p / spacing)
    };
    let nearest = |a: &f64, b: &f64| (a - wanted).abs().total_cmp(&(b - wanted).abs());
    candidates.filter(divides).min_by(nearest).unwrap_or_else(|| rounded(wanted))
}

/// Six digits: the name of a folder without the noise of the last bits.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spacings_divide_the_periods_where_they_can() {
        assert_eq!(fitting(0.002 * 2.25, &[]), 0.0045);
        // 80 particles across: 53 or 54 for 1.5 times the spacing.
        assert_eq!(fitting(0.015, &[0.8]), 0.8 / 53.0);
        // 80 and 40: the count along the first must be even.
        assert_eq!(fitting(0.015, &[0.8, 0.4]), 0.8 / 54.0);
        assert_eq!(fitting(0.015, &[0.8, 0.8 / std::f64::consts::PI]), 0.015, "no such spacing");
    }
}
