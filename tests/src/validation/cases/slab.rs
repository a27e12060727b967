//! Oscillating no-slip flow over an elastic slab, against the exact solution of both layers.

use std::f64::consts::TAU;
use std::path::Path;

use nalgebra::Complex;

use super::floating::rectangle;
use crate::validation::snapshot::{self, Snapshot};
use crate::validation::{Case, Figure, Goal, Member, Plot, Run};

/// See the module.
pub struct Slab;

/// Speed \[m/s\] and frequency \[1/s\] of the wall, which moves at V sin ωt.
const WALL_SPEED: f64 = 0.1;
const OMEGA: f64 = TAU;
/// Start and end of the last period \[s\].
const LAST_PERIOD: f64 = 9.0;
const END: f64 = 10.0;

/// Complex amplitudes of the velocity: v = Im(v̂ e^(iωt)).
///
/// ```text
/// fluid, 0 < y < H:    v̂ = (V̂ sinh κy + v̂₀ sinh κ(H − y))/sinh κH,    κ² = iω/ν
/// slab, −d < y < 0:    v̂ = v̂₀ sin k(y + d)/sin kd,                    k² = ω²ρ_s/G
/// face:                μ dv̂/dy = G/(iω) dv̂/dy
/// ```
struct Exact {
    /// κ \[1/m\].
    decay: Complex<f64>,
    /// k \[1/m\].
    wavenumber: f64,
    /// v̂₀ \[m/s\].
    face: Complex<f64>,
}

impl Exact {
    /// H and d are 1 m.
    fn new(run: &Run) -> Result<Self, String> {
        let viscosity = run.number("fluid.dynamic_viscosity_pa_s")?;
        let i = Complex::new(0.0, 1.0);
        let decay = (i * (OMEGA * run.number("fluid.rest_density_kg_m3")? / viscosity)).sqrt();
        let modulus = run.number("solid.body.0.material.shear_modulus_pa")?;
        let wavenumber = OMEGA * (run.number("solid.body.0.material.density_kg_m3")? / modulus).sqrt();
        let by_fluid = decay * viscosity;
        let by_slab = Complex::from(modulus * wavenumber / wavenumber.tan()) / (i * OMEGA);
        let face = by_fluid * WALL_SPEED / decay.sinh() / (by_fluid / decay.tanh() + by_slab);
        Ok(Self { decay, wavenumber, face })
    }

    /// Velocity \[m/s\] at height `y` \[m\] and time `t` \[s\].
    fn velocity(&self, y: f64, t: f64) -> f64 {
        let amplitude = if y > 0.0 {
            let shares = (self.decay * y).sinh() * WALL_SPEED + self.face * (self.decay * (1.0 - y)).sinh();
            shares / self.decay.sinh()
        } else {
            self.face * ((self.wavenumber * (y + 1.0)).sin() / self.wavenumber.sin())
        };
        (amplitude * Complex::from_polar(1.0, OMEGA * t)).im
    }
}

/// A time \[s\], and height \[m\] and velocity \[m/s\] of each free particle of one side.
type Row = (f64, Vec<[f64; 2]>);

/// The snapshots of one side in the last period.
fn last_period(run: &Run, side: &str) -> Result<Vec<Row>, String> {
    let files = snapshot::series(&run.folder.join("results/snapshots").join(Path::new(side)))?;
    let of = |(time, path): (f64, std::path::PathBuf)| -> Result<Row, String> {
        let state = Snapshot::read(&path, 1)?;
        let particles = state.position.iter().zip(&state.velocity).map(|(x, v)| [x.y, v.x]);
        Ok((time, particles.filter(|[y, _]| *y > -1.0).collect()))
    };
    files.into_iter().filter(|(time, _)| *time > LAST_PERIOD + 1e-6).map(of).collect()
}

/// Largest and rms error of the velocity over the speed of the wall in the last period.
fn errors(run: &Run, exact: &Exact, side: &str) -> Result<[f64; 2], String> {
    let (mut worst, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
    for (time, particles) in last_period(run, side)? {
        for [y, v] in particles {
            let error = (v - exact.velocity(y, time)) / WALL_SPEED;
            worst = worst.max(error.abs());
            squares += error * error;
            count += 1.0;
        }
    }
    Ok([worst, f64::sqrt(squares / count)])
}

/// Complex amplitude of the velocity of the face \[m/s\] in the last period, by its displacement.
fn face(run: &Run) -> Result<Complex<f64>, String> {
    let history = run.history("face_displacement_x_m")?;
    // Rows come at steps, up to a step after their time, every 0.02 s.
    let last: Vec<_> = history.into_iter().filter(|(t, _)| *t > LAST_PERIOD + 0.01).collect();
    let sum: Complex<f64> = last.iter().map(|(t, x)| Complex::from_polar(*x, -OMEGA * t)).sum();
    // x = Im(x̂ e^(iωt)) has the mean product −i x̂/2 with e^(−iωt); v̂ = iω x̂.
    Ok(sum * (-2.0 * OMEGA / last.len() as f64))
}

impl Case for Slab {
    fn name(&self) -> &'static str {
        "slab"
    }

    fn about(&self) -> &'static str {
        "oscillating no-slip flow over an elastic slab against diffusion and shear wave"
    }

    fn members(&self) -> Vec<Member> {
        // Nothing depends on x: eight columns are enough.
        let of = |spacing: f64| {
            let width = 8.0 * spacing;
            Member::new("slab", spacing)
                .with("domain.upper_m", vec![width, 1.6])
                .with("fluid.region.0.shape", rectangle([0.0, 0.0], [width, 1.0]))
                .with("wall.0.shape", rectangle([0.0, 1.0], [width, 1.5]))
                .with("solid.body.0.shape", rectangle([0.0, -1.5], [width, 0.0]))
                .with("solid.body.0.support.0.shape", rectangle([0.0, -1.5], [width, -1.0]))
                .with("probe.1.at_m", vec![0.5 * width, 0.0])
        };
        vec![of(0.1).quick(), of(0.05), of(0.025)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let exact = Exact::new(run)?;
        let [fluid, fluid_rms] = errors(run, &exact, "fluid.pvd")?;
        let [slab, slab_rms] = errors(run, &exact, "solid.pvd")?;
        let face = face(run)?;
        let goal = if run.member.spacing > 0.06 { 0.04 } else { 0.02 };
        Ok(vec![
            Figure::judged("largest error of the fluid's velocity, of the wall's", fluid, Goal::AtMost(goal)),
            Figure::reported("rms error of the fluid's velocity, of the wall's", fluid_rms),
            Figure::judged("largest error of the slab's velocity, of the wall's", slab, Goal::AtMost(goal)),
            Figure::reported("rms error of the slab's velocity, of the wall's", slab_rms),
            Figure::compared("amplitude of the face [m/s]", face.norm(), exact.face.norm(), goal),
            Figure::reported("phase of the face after the exact one [rad]", (face / exact.face).arg()),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let order = |pair: &[Run]| -> Result<[Figure; 2], String> {
            let (coarse, fine) = (&pair[0], &pair[1]);
            let of = |side| -> Result<f64, String> {
                let rms = |run| Ok::<_, String>(errors(run, &Exact::new(run)?, side)?[1]);
                let refinement = coarse.member.spacing / fine.member.spacing;
                Ok((rms(coarse)? / rms(fine)?).ln() / refinement.ln())
            };
            let name = |side| format!("order of the rms error of the {side} to {} m", fine.member.spacing);
            // The layer of the slab that does not shear is of first order and shows in the finest fluid.
            let goal = if fine.member.spacing > 0.03 { Goal::AtLeast(1.5) } else { Goal::None };
            Ok([
                Figure::judged(name("fluid"), of("fluid.pvd")?, goal),
                Figure::reported(name("slab"), of("solid.pvd")?),
            ])
        };
        Ok(runs.windows(2).map(order).collect::<Result<Vec<_>, _>>()?.concat())
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("profile", "velocity at the end [m/s]", "y [m]");
        for (k, run) in runs.iter().enumerate() {
            if k == 0 {
                let exact = Exact::new(run)?;
                let heights = (-100..=100).map(|k| f64::from(k) / 100.0);
                plot.line("exact", heights.map(|y| (exact.velocity(y, END), y)).collect());
            }
            let last = |side| -> Result<Vec<[f64; 2]>, String> {
                Ok(last_period(run, side)?.pop().map(|(_, particles)| particles).unwrap_or_default())
            };
            let particles = [last("fluid.pvd")?, last("solid.pvd")?].concat();
            let points = particles.into_iter().map(|[y, v]| (v, y)).collect();
            plot.points(format!("{} m", run.member.spacing), points);
        }
        Ok(vec![plot])
    }
}
