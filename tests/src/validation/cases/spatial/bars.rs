//! Bars that bend in two planes and twist, against elasticity in three dimensions.

use std::f64::consts::PI;

use coordinator::study::references;

use super::common::{energy, judged_if};
use crate::validation::cases::beams::{cost, last};
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// A cantilever of square section that swings at 30 degrees between two planes of equal stiffness.
pub struct Cantilever3d;

/// Poisson's ratio, first frequency \[Hz\] and tip deflection under 0.1 m/s² \[m\] of the cantilever by finite elements in
/// three dimensions with its end held.
const CANTILEVER: [(f64, f64, f64); 3] = [
    (0.0, 3.588_687_66, 3.023_922_02e-4),
    (0.3, 3.599_747_73, 3.004_571_93e-4),
    (0.4, 3.611_465_89, 2.984_866_07e-4),
];

/// Schemes of the runs along one axis.
const ALONG: [&str; 2] = ["along y", "along z"];

impl Cantilever3d {
    /// Side of the section \[m\].
    const SIDE: f64 = 0.02;
    /// Angle from y toward z along which the tip swings \[deg\].
    const ANGLE: f64 = 30.0;

    /// A member at `across` particles over the side, with four held rows.
    fn member(file: &'static str, scheme: &'static str, across: f64) -> Member {
        let spacing = Self::SIDE / across;
        let lower = vec![-4.0 * spacing, -0.01, -0.01];
        Member::solid(file, spacing)
            .scheme(scheme)
            .with("solid.body.0.shape.lower_m", lower.clone())
            .with("solid.body.0.support.0.shape.lower_m", lower)
    }

    /// Displacements of the tip along y and z \[m\] with their times \[s\].
    fn track(run: &Run) -> Result<Vec<(f64, [f64; 2])>, String> {
        let [y, z] = [run.history("tip_displacement_y_m")?, run.history("tip_displacement_z_m")?];
        Ok(y.into_iter().zip(z).map(|((t, y), (_, z))| (t, [y, z])).collect())
    }

    /// Angle \[deg\] from y toward z of the longest axis of a track, and its width over its length.
    fn axis(track: &[[f64; 2]]) -> (f64, f64) {
        let sum = |i: usize, j: usize| track.iter().map(|x| x[i] * x[j]).sum::<f64>();
        let angle = 0.5 * (2.0 * sum(0, 1)).atan2(sum(0, 0) - sum(1, 1));
        let extent = |along: [f64; 2]| {
            let places = track.iter().map(|x| x[0] * along[0] + x[1] * along[1]);
            places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min)
        };
        let (sin, cos) = angle.sin_cos();
        (angle.to_degrees(), extent([-sin, cos]) / extent([cos, sin]))
    }

    fn swing(run: &Run, ratio: f64, frequency: f64) -> Result<Vec<Figure>, String> {
        let track = Self::track(run)?;
        let (sin, cos) = Self::ANGLE.to_radians().sin_cos();
        let along: Vec<(f64, f64)> = track.iter().map(|(t, [y, z])| (*t, cos * y + sin * z)).collect();
        let (rate, period) = references::swing(&along);
        let (_, width) = Self::axis(&track.iter().map(|row| row.1).collect::<Vec<_>>());
        let end = track.last().map_or(0.0, |row| row.0);
        // Of each period by itself: a split pair of frequencies turns the axis slowly.
        let mut turned = 0.0_f64;
        let mut from = 0.0;
        while from + period <= end {
            let rows: Vec<[f64; 2]> =
                track.iter().filter(|row| (from..from + period).contains(&row.0)).map(|row| row.1).collect();
            turned = turned.max((Self::axis(&rows).0 - Self::ANGLE).abs());
            from += period;
        }
        let fine = run.member.spacing < 0.0025;
        let total = energy(run, "bar")?;
        let mut figures = vec![
            Figure::reported("Poisson's ratio", ratio),
            Figure::compared("frequency [Hz]", 1.0 / period, frequency, if fine { 0.015 } else { 0.03 }),
            Figure::judged(
                "loss of amplitude per period",
                1.0 - (-rate * period).exp(),
                Goal::Between(-0.01, 0.01),
            ),
            Figure::reported("periods run", end / period),
            Figure::judged("largest turn of the axis of the track [deg]", turned, Goal::AtMost(1.0)),
            Figure::judged("width of the track over its length", width, Goal::AtMost(0.02)),
            Figure::reported(
                "largest energy over that of the start",
                series::largest(total.iter().map(|e| e / total[0])),
            ),
        ];
        figures.push(cost(run)?);
        Ok(figures)
    }
}

impl Case for Cantilever3d {
    fn name(&self) -> &'static str {
        "cantilever_3d"
    }

    fn about(&self) -> &'static str {
        "cantilever of square section in space against 3-D finite elements: frequency, sag, straight track of the tip"
    }

    fn members(&self) -> Vec<Member> {
        let mut members = Vec::new();
        for (k, (ratio, ..)) in CANTILEVER.iter().enumerate() {
            let swings = ["swing, nu 0", "swing, nu 0.3", "swing, nu 0.4"][k];
            let sags = ["sag, nu 0", "sag, nu 0.3", "sag, nu 0.4"][k];
            for across in [6.0, 10.0] {
                let of = |file, scheme| {
                    Self::member(file, scheme, across).with("solid.body.0.material.poisson_ratio", *ratio)
                };
                members.push(of("cantilever_3d", swings));
                let sag = of("cantilever_3d_static", sags);
                members.push(if k == 1 && across < 7.0 { sag.quick() } else { sag });
            }
        }
        // One period is enough to tell two directions apart.
        let shape = "0.01*0.5*(cosh(9.375520343559*ramp(x)) - cos(9.375520343559*ramp(x)) \
                     - 0.7340955137589*(sinh(9.375520343559*ramp(x)) - sin(9.375520343559*ramp(x))))";
        for (scheme, velocity) in ALONG.into_iter().zip([["0", shape, "0"], ["0", "0", shape]]) {
            members.push(
                Self::member("cantilever_3d", scheme, 6.0)
                    .with("solid.body.0.velocity_m_s", velocity.to_vec())
                    .with("time.end_time_s", 0.28),
            );
        }
        members
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let ratio = run.number("solid.body.0.material.poisson_ratio")?;
        let (_, frequency, sag) = *CANTILEVER
            .iter()
            .find(|row| (row.0 - ratio).abs() < 1e-9)
            .ok_or("no reference for this Poisson's ratio")?;
        if ALONG.contains(&run.member.scheme) {
            return Ok(vec![cost(run)?]);
        }
        if run.member.stem() == "cantilever_3d" {
            return Self::swing(run, ratio, frequency);
        }
        let goal = if run.member.spacing < 0.0025 { 0.015 } else { 0.03 };
        let weight = 1000.0 * 0.1 * 0.2 * Self::SIDE * Self::SIDE;
        Ok(vec![
            Figure::reported("Poisson's ratio", ratio),
            Figure::compared("sag of the tip [m]", -last(run, "tip_displacement_y_m")?, sag, goal),
            Figure::reported(
                "tip displacement along z over the sag",
                last(run, "tip_displacement_z_m")? / sag,
            ),
            // Four held rows weigh as well.
            Figure::reported("reaction of the clamp over the weight", last(run, "clamp_force_y_n")? / weight),
            cost(run)?,
        ])
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let along = ALONG.map(|scheme| runs.iter().find(|run| run.member.scheme == scheme));
        let [Some(y), Some(z)] = along else { return Ok(Vec::new()) };
        let (y, z) = (y.column("tip_displacement_y_m")?, z.column("tip_displacement_z_m")?);
        let largest = series::largest(y.iter().map(|d| d.abs()));
        let apart = series::largest(y.iter().zip(&z).map(|(y, z)| (y - z).abs()));
        Ok(vec![Figure::judged(
            "tips of the bars bent along y and z apart, over the largest displacement",
            apart / largest,
            Goal::AtMost(1e-9),
        )])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("track", "displacement along y [m]", "displacement along z [m]");
        for run in runs.iter().filter(|run| run.member.scheme.starts_with("swing")) {
            let track = Self::track(run)?.into_iter().map(|(_, [y, z])| (y, z)).collect();
            plot.line(format!("{}, {:.2} mm", run.member.scheme, 1e3 * run.member.spacing), track);
        }
        Ok(vec![plot])
    }
}

/// A round rod that twists back and forth.
pub struct TorsionRod;

impl TorsionRod {
    /// Shear modulus over density, 1e6/(2·1.3·1000), to the root \[m/s\].
    const SHEAR_SPEED: f64 = 19.611_613_513;
    /// Length \[m\].
    const LENGTH: f64 = 0.1;
    /// Distance of the probe from the axis \[m\].
    const ARM: f64 = 0.0075;

    /// Twist of the end \[rad\] in time.
    fn twist(run: &Run) -> Result<Vec<(f64, f64)>, String> {
        let (y, z) = (run.column("end_displacement_y_m")?, run.history("end_displacement_z_m")?);
        Ok(z.into_iter().zip(y).map(|((t, z), y)| (t, z.atan2(Self::ARM + y))).collect())
    }
}

impl Case for TorsionRod {
    fn name(&self) -> &'static str {
        "torsion_rod"
    }

    fn about(&self) -> &'static str {
        "first torsional mode of a round rod, free and clamped: frequency against the exact one"
    }

    fn members(&self) -> Vec<Member> {
        let free = |across: f64| Member::solid("torsion_rod", 0.02 / across).scheme("free");
        let clamped = |across: f64| {
            let spacing = 0.02 / across;
            Member::solid("torsion_rod_clamped", spacing)
                .scheme("clamped")
                .with("solid.body.0.shape.from_m", vec![-4.0 * spacing, 0.0, 0.0])
                .with("solid.body.0.support.0.shape.lower_m", vec![-4.0 * spacing, -0.02, -0.02])
        };
        let stairs =
            |across: f64| free(across).scheme("free, on the lattice").with("solid.body.0.layout", "lattice");
        vec![free(8.0).quick(), free(12.0), clamped(8.0), clamped(12.0), stairs(8.0), stairs(12.0)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let free = run.member.stem() == "torsion_rod";
        let exact = Self::SHEAR_SPEED / (if free { 2.0 } else { 4.0 } * Self::LENGTH);
        let twist = Self::twist(run)?;
        let (rate, period) = references::swing(&twist);
        let goal = if run.member.spacing < 0.002 { 0.01 } else { 0.02 };
        let judged = !run.member.scheme.contains("lattice");
        let total = energy(run, "rod")?;
        let mut figures = vec![
            judged_if(judged, Figure::compared("frequency [Hz]", 1.0 / period, exact, goal)),
            Figure::reported("largest twist [rad]", series::largest(twist.iter().map(|row| row.1))),
            Figure::reported("loss of amplitude per period", 1.0 - (-rate * period).exp()),
            Figure::reported(
                "largest energy over that of the start",
                series::largest(total.iter().map(|e| e / total[0])),
            ),
        ];
        if free {
            // What the ends have at the start: half the rod times R^2/2 times the mean of the rate.
            let mass = 1000.0 * PI * 0.01_f64.powi(2) * Self::LENGTH;
            let scale = 0.5 * mass * 0.5 * 0.01_f64.powi(2) * 12.3223 * 2.0 / PI;
            let spin = run.column("rod_angular_momentum_x_kg_m2_per_s")?;
            let change = series::largest(spin.iter().map(|l| (l - spin[0]).abs())) / scale;
            figures.push(Figure::judged(
                "change of the angular momentum about the axis, over that of one half at the start",
                change,
                Goal::AtMost(1e-9),
            ));
        }
        figures.push(cost(run)?);
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("twist", "t [s]", "twist of the end [rad]");
        for run in runs {
            plot.line(
                format!("{}, {:.2} mm", run.member.scheme, 1e3 * run.member.spacing),
                Self::twist(run)?,
            );
        }
        Ok(vec![plot])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_of_an_ellipse_is_found() {
        let (sin, cos) = 20.0_f64.to_radians().sin_cos();
        let ellipse: Vec<[f64; 2]> = (0..360)
            .map(|k| f64::from(k).to_radians())
            .map(|a| [cos * a.cos() - 0.1 * sin * a.sin(), sin * a.cos() + 0.1 * cos * a.sin()])
            .collect();
        let (angle, width) = Cantilever3d::axis(&ellipse);
        assert!((angle - 20.0).abs() < 1e-9 && (width - 0.1).abs() < 1e-4, "{angle} {width}");
    }
}
