//! Thin curved bodies, whose particles stand in layers along their faces: a ring in two of its modes, and an arch.

use std::f64::consts::{FRAC_PI_4, TAU};

use coordinator::study::references;

use super::beams::{cost, energy_ratio, last};
use crate::validation::{Case, Figure, Goal, Member, Run};

/// A free ring in its inextensional mode of two waves and in its breathing mode.
pub struct Ring;

/// A quarter of a circle under a load at its end.
pub struct Arch;

/// Material of both: density \[kg/m³\], Young's modulus \[Pa\], Poisson's ratio \[-\].
const DENSITY: f64 = 1000.0;
const YOUNG: f64 = 1e6;
const POISSON: f64 = 0.4;

/// Thickness of the ring \[m\].
const THICKNESS: f64 = 0.02;

/// Inner and outer radius of the ring and of the arch \[m\].
const RING: [f64; 2] = [0.19, 0.21];
const ARCH: [f64; 2] = [0.095, 0.105];

/// Load at the end of the arch per depth \[N/m\]: 6.3 Pa on 10 mm.
const LOAD: f64 = 0.063;

/// Degree of the polynomials in r of [`ring_period`].
const DEGREE: i32 = 4;

/// Period \[s\] of the slowest mode with `waves` around the circumference of a ring in plane strain, of any thickness.
///
/// Ritz's method with polynomials in r for u_r cos nθ and u_θ sin nθ: exact plane elasticity to six digits at R/t = 10. For
/// n = 0 only u_r counts (the other is a turn of the ring as a whole).
///
/// ```
/// // Thin ring: ω² = n²(n² − 1)²/(n² + 1) E' I/(ρ A R⁴) and ω² = E'/(ρ R²), E' = E/(1 − ν²); corrections of order (t/R)².
/// use tests::validation::cases::curved::ring_period;
/// let e = 1e6 / (1.0 - 0.16);
/// let bending = (36.0 / 5.0 * e * 0.002_f64.powi(2) / 12.0 / (1000.0 * 0.2_f64.powi(4))).sqrt();
/// let breathing = (e / (1000.0 * 0.04_f64)).sqrt();
/// let thin = [0.199, 0.201];
/// assert!((ring_period(2, thin) * bending / std::f64::consts::TAU - 1.0).abs() < 2e-3);
/// assert!((ring_period(0, thin) * breathing / std::f64::consts::TAU - 1.0).abs() < 1e-4);
/// ```
pub fn ring_period(waves: u32, radii: [f64; 2]) -> f64 {
    let n = f64::from(waves);
    let g = YOUNG / (2.0 * (1.0 + POISSON));
    let lambda = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let (middle, half) = (0.5 * (radii[0] + radii[1]), 0.5 * (radii[1] - radii[0]));
    let fields = if waves == 0 { 1 } else { 2 };
    let size = fields * (DEGREE as usize + 1);
    // [u_r, u_θ], their slopes.
    let basis = |k: usize, s: f64| {
        let power = (k / fields) as i32;
        let (value, slope) =
            (s.powi(power), if power > 0 { f64::from(power) * s.powi(power - 1) / half } else { 0.0 });
        if k.is_multiple_of(fields) { ([value, 0.0], [slope, 0.0]) } else { ([0.0, value], [0.0, slope]) }
    };
    let (mut stiffness, mut mass) = (vec![vec![0.0; size]; size], vec![vec![0.0; size]; size]);
    // The midpoint rule with this many points is exact to 1e-7.
    let points = 4000;
    for point in 0..points {
        let s = (f64::from(point) + 0.5) / f64::from(points) * 2.0 - 1.0;
        let r = middle + half * s;
        let strain = |k: usize| {
            let ([u, v], [du, dv]) = basis(k, s);
            (du, (u + n * v) / r, dv - (n * u + v) / r)
        };
        for i in 0..size {
            for j in 0..size {
                let ((a_r, a_t, a_s), (b_r, b_t, b_s)) = (strain(i), strain(j));
                let energy =
                    lambda * (a_r + a_t) * (b_r + b_t) + 2.0 * g * (a_r * b_r + a_t * b_t) + g * a_s * b_s;
                let ((a, _), (b, _)) = (basis(i, s), basis(j, s));
                stiffness[i][j] += energy * r;
                mass[i][j] += DENSITY * (a[0] * b[0] + a[1] * b[1]) * r;
            }
        }
    }
    // Inverse iteration for the slowest mode.
    let times = |matrix: &[Vec<f64>], x: &[f64]| -> Vec<f64> {
        matrix.iter().map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
    };
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut x = vec![1.0; size];
    let mut square = 0.0;
    for _ in 0..60 {
        let next = solved(stiffness.clone(), times(&mass, &x));
        let weight = product(&next, &times(&mass, &next));
        square = product(&next, &times(&stiffness, &next)) / weight;
        x = next.into_iter().map(|value| value / weight.sqrt()).collect();
    }
    TAU / square.sqrt()
}

/// Solution of a symmetric positive system by Gauss's elimination.
fn solved(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for k in 0..n {
        for i in k + 1..n {
            let factor = matrix[i][k] / matrix[k][k];
            let above = matrix[k].clone();
            matrix[i].iter_mut().zip(&above).for_each(|(own, above)| *own -= factor * above);
            right[i] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}

/// Deflection \[m\] of the arch's end along its load by curved-beam theory with shear (Winkler; Timoshenko 1956).
///
/// ```text
/// δ = ¼π P (R² A_m/(E' A (R A_m − A)) − R/(E' A) + 6R/(5 G A)),  A_m = ln(r_o/r_i), A = r_o − r_i
/// ```
fn arch_deflection() -> f64 {
    let [inner, outer] = ARCH;
    let (radius, area, log) = (0.5 * (inner + outer), outer - inner, (outer / inner).ln());
    let plane = YOUNG / (1.0 - POISSON * POISSON);
    let shear = YOUNG / (2.0 * (1.0 + POISSON));
    let bending = radius * radius * log / (plane * area * (radius * log - area));
    FRAC_PI_4 * LOAD * (bending - radius / (plane * area) + 1.2 * radius / (shear * area))
}

impl Case for Ring {
    fn name(&self) -> &'static str {
        "thin_ring"
    }

    fn about(&self) -> &'static str {
        "periods of a thin elastic ring, inextensional and breathing, against plane elasticity"
    }

    fn members(&self) -> Vec<Member> {
        let bending = |across: f64| {
            Member::solid("ring_inextensional", THICKNESS / across)
                .with("time.step.time_step_s", 0.002 / across)
        };
        let breathing = |across: f64| {
            Member::solid("ring_breathing", THICKNESS / across).with("time.step.time_step_s", 0.0008 / across)
        };
        vec![bending(4.0).quick(), bending(8.0), breathing(4.0).quick(), breathing(8.0)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let (_, period) = references::swing(&run.history("side_displacement_x_m")?);
        let waves = if run.member.file == "ring_breathing" { 0 } else { 2 };
        let goal = if THICKNESS / run.member.spacing < 6.0 { 0.08 } else { 0.03 };
        Ok(vec![
            Figure::compared("period [s]", period, ring_period(waves, RING), goal),
            // A free ring has no loss: the sub-steps conserve energy to some 1e-4.
            Figure::judged(
                "largest energy over that of the start",
                energy_ratio(run, "sums")?,
                Goal::Between(0.99, 1.001),
            ),
            cost(run)?,
        ])
    }
}

impl Case for Arch {
    fn name(&self) -> &'static str {
        "arch"
    }

    fn about(&self) -> &'static str {
        "deflection of a clamped quarter arch under a load at its end against curved-beam theory"
    }

    fn members(&self) -> Vec<Member> {
        let member = |across: f64| Member::solid("arch", 0.01 / across);
        vec![member(4.0), member(6.0).quick(), member(10.0)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let goal = if 0.01 / run.member.spacing < 5.0 { 0.06 } else { 0.03 };
        let reaction = last(run, "foot_force_y_n_per_m")?;
        Ok(vec![
            Figure::compared(
                "deflection of the end [m]",
                -last(run, "tip_displacement_y_m")?,
                arch_deflection(),
                goal,
            ),
            // Equilibrium: what is left after damping is below a thousandth.
            Figure::compared("reaction of the foot [N/m]", reaction, LOAD, 0.002),
            cost(run)?,
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_those_of_thin_theory_with_small_corrections() {
        let plane = YOUNG / (1.0 - POISSON * POISSON);
        let bending =
            TAU / (36.0 / 5.0 * plane * THICKNESS.powi(2) / 12.0 / (DENSITY * 0.2_f64.powi(4))).sqrt();
        // Shear and rotation of the sections: 12 terms of order (t/R)²/12 each.
        let ratio = ring_period(2, RING) / bending;
        assert!(ratio > 1.003 && ratio < 1.03, "{ratio}");
        let breathing = TAU * 0.2 * (DENSITY / plane).sqrt();
        assert!((ring_period(0, RING) / breathing - 1.0).abs() < 2e-3);
        let arch = FRAC_PI_4 * LOAD * 0.1_f64.powi(3) / (plane * 0.01_f64.powi(3) / 12.0);
        assert!((arch_deflection() / arch - 1.0).abs() < 0.01);
    }
}
