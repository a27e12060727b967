//! Bodies that spin: what rotation in space conserves.

use std::f64::consts::TAU;

use super::common::{dot, energy, norm, unwrapped, vectors};
use crate::validation::cases::beams::cost;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// A free elastic cube that spins about an oblique axis.
pub struct SpinningCube;

impl SpinningCube {
    /// Angular speed \[rad/s\].
    const SPIN: f64 = 50.0;
    /// Sides and mass \[m, kg\].
    const SIDE: f64 = 0.1;
    const MASS: f64 = 1.1;
}

impl Case for SpinningCube {
    fn name(&self) -> &'static str {
        "spinning_cube"
    }

    fn about(&self) -> &'static str {
        "free elastic cube at 50 rad/s about (1, 2, 3): momenta and energy per turn"
    }

    fn members(&self) -> Vec<Member> {
        vec![
            Member::solid("spinning_cube", 0.02).quick(),
            Member::solid("spinning_cube", 0.01),
            Member::solid("spinning_cube", 0.005),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let turns = run.column("t_s")?.last().copied().unwrap_or(f64::NAN) * Self::SPIN / TAU;
        let spin = vectors(run, "cube_angular_momentum", "kg_m2_per_s")?;
        let momentum = vectors(run, "cube_momentum", "kg_m_per_s")?;
        let total = energy(run, "cube")?;
        // A lattice of n particles across has this much less than the cube.
        let lattice = 1.0 - (run.member.spacing / Self::SIDE).powi(2);
        let exact = lattice * Self::MASS * Self::SIDE.powi(2) / 6.0 * Self::SPIN;
        let changed =
            |k: usize| series::largest(spin.iter().map(|l| (l[k] - spin[0][k]).abs())) / norm(spin[0]);
        let direction = |l: &[f64; 3]| {
            // Accurate for small angles, unlike the arc cosine.
            let unit = |l: [f64; 3]| l.map(|c| c / norm(l));
            let (a, b) = (unit(*l), unit(spin[0]));
            norm(std::array::from_fn(|k| a[k] - b[k]))
        };
        let speed = Self::SPIN * Self::SIDE;
        let mut figures = vec![
            Figure::reported("revolutions", turns),
            Figure::compared("angular momentum at the start [kg m2/s]", norm(spin[0]), exact, 1e-9),
        ];
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let name = format!("change of the angular momentum along {axis} per turn, over its magnitude");
            figures.push(Figure::judged(name, changed(k) / turns, Goal::AtMost(1e-6)));
        }
        figures.extend([
            Figure::judged(
                "turn of the axis of the angular momentum [rad]",
                series::largest(spin.iter().map(direction)),
                Goal::AtMost(1e-4),
            ),
            // Round-off of sums that vanish.
            Figure::judged(
                "momentum over mass, spin and side",
                series::largest(momentum.iter().map(|p| norm(*p))) / (Self::MASS * speed),
                Goal::AtMost(1e-12),
            ),
            Figure::judged(
                "change of kinetic and strain energy per turn",
                series::largest(total.iter().map(|e| (e / total[0] - 1.0).abs())) / turns,
                Goal::AtMost(5e-3),
            ),
            cost(run)?,
        ]);
        Ok(figures)
    }
}

/// A spinning top under gravity.
pub struct HeavyTop;

impl HeavyTop {
    /// Spin about the axis \[rad/s\] and gravity \[m/s²\].
    const SPIN: f64 = 100.0;
    const GRAVITY: f64 = 9.81;
    /// Cosine and sine of the angle between axis and vertical.
    const TILT: (f64, f64) = (0.866_025_403_784_438_6, 0.5);

    /// Moments of inertia about the axis and across it about the pivot, and distance of the centre from it, per mass, of a
    /// cube whose pivot is half a `spacing` \[m\] above the middle of a face \[m², m², m\].
    fn body(spacing: f64) -> (f64, f64, f64) {
        let (axis, arm) = (0.07 * 0.07 / 6.0, 0.5 * (0.07 - spacing));
        (axis, axis + arm * arm, arm)
    }

    /// Rates of precession \[rad/s\]: to first order, m g l/(I₃ ω), and the slow root of
    ///
    /// ```text
    /// I₁ Ω² cos θ − I₃ ω Ω + m g l = 0
    /// ```
    fn exact(spacing: f64) -> (f64, f64) {
        let (axis, across, arm) = Self::body(spacing);
        let (a, b, c) = (across * Self::TILT.0, axis * Self::SPIN, Self::GRAVITY * arm);
        (c / b, 0.5 * (b - (b * b - 4.0 * a * c).sqrt()) / a)
    }

    /// Times \[s\], angles of the axis about the vertical and from it \[rad\].
    fn motion(run: &Run) -> Result<Vec<(f64, f64, f64)>, String> {
        let up = [Self::TILT.1, 0.0, Self::TILT.0];
        // Across, in the plane of the axis at the start, and along the turn.
        let (first, second) = ([-Self::TILT.0, 0.0, Self::TILT.1], [0.0, -1.0, 0.0]);
        let centre = vectors(run, "top_centre", "m")?;
        let about = unwrapped(centre.iter().map(|x| dot(*x, second).atan2(dot(*x, first))));
        let from = centre.iter().map(|x| (dot(*x, up) / norm(*x)).acos());
        Ok(run.column("t_s")?.into_iter().zip(about).zip(from).map(|((t, a), f)| (t, a, f)).collect())
    }
}

impl Case for HeavyTop {
    fn name(&self) -> &'static str {
        "heavy_top"
    }

    fn about(&self) -> &'static str {
        "steady precession of a rigid cube about a pivot, against the exact rate"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::solid("heavy_top", 0.01)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let motion = Self::motion(run)?;
        let (_, rate) = series::line(&motion.iter().map(|(t, about, _)| (*t, *about)).collect::<Vec<_>>());
        let (first, exact) = Self::exact(run.member.spacing);
        let tilt = Self::TILT.1.asin();
        let nod = series::largest(motion.iter().map(|row| (row.2 - tilt).abs()));
        let spin = vectors(run, "motion_angular_velocity", "rad_s")?;
        Ok(vec![
            Figure::compared("rate of precession [rad/s]", rate.abs(), exact, 0.01),
            Figure::compared("the same over m g l/(I spin) [rad/s]", rate.abs(), first, 0.0).report_only(),
            Figure::reported("largest nod of the axis [deg]", nod.to_degrees()),
            Figure::reported(
                "angular speed at the end over that at the start",
                norm(*spin.last().ok_or("no probe row")?) / norm(spin[0]),
            ),
            cost(run)?,
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("precession", "t [s]", "angle of the axis about the vertical [rad]");
        for run in runs {
            let motion = Self::motion(run)?.into_iter();
            plot.line("computed", motion.map(|(t, about, _)| (t, about.abs())).collect());
            let (_, rate) = Self::exact(run.member.spacing);
            plot.line("exact", vec![(0.0, 0.0), (1.62, 1.62 * rate)]);
        }
        Ok(vec![plot])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_case_file_starts_at_the_exact_rate() {
        let (first, exact) = HeavyTop::exact(0.01);
        assert!((first - 3.60367).abs() < 1e-5 && (exact - 3.87735).abs() < 1e-5, "{first} {exact}");
    }
}
