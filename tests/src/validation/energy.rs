//! The total energy of the fluid in a closed case.

use super::{Figure, Goal, Run, series};

/// Kinetic, potential and compression energy \[J/m\] over time \[s\] by the probe `probe` of type `fluid-sums`.
///
/// # Errors
/// When the case has no such probe.
pub fn total(run: &Run, probe: &str) -> Result<Vec<(f64, f64)>, String> {
    let parts = ["kinetic", "potential", "compression"].map(|kind| format!("{probe}_{kind}_energy_j_per_m"));
    let mut total = run.history(&parts[0])?;
    for part in &parts[1..] {
        total.iter_mut().zip(run.column(part)?).for_each(|(sum, e)| sum.1 += e);
    }
    Ok(total)
}

/// Largest rise of the total energy over an earlier minimum, of the start; at most 0.2 % where nothing does work on
/// the water.
///
/// # Errors
/// When the case has no such probe.
pub fn rise(run: &Run, probe: &str) -> Result<Figure, String> {
    let energies = total(run, probe)?;
    let rise = series::largest_rise(&energies.iter().map(|e| e.1).collect::<Vec<_>>());
    // A start from p = 0 on the floor has only potential energy, which counts from the origin.
    let start = energies.first().map_or(f64::NAN, |e| e.1);
    Ok(Figure::judged(
        "rise of energy over an earlier minimum, of the start",
        rise / start,
        Goal::AtMost(0.002),
    ))
}
