//! Laminar flow through a square duct and a round pipe.

use std::f64::consts::PI;

use super::common::judged_if;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// Flow through a square duct.
pub struct DuctFlow;

impl DuctFlow {
    const SIDE: f64 = 0.02;
    /// Largest velocity of the exact solution \[m/s\].
    const LARGEST: f64 = 0.117_874_2;

    /// Velocity \[m/s\] at distances y and z \[m\] from the middle:
    ///
    /// ```text
    /// u = (4 g a²/(π³ ν)) Σ_n odd (−1)^((n−1)/2)/n³ (1 − cosh(nπz/a)/cosh(nπ/2)) cos(nπy/a)
    /// ```
    fn exact(y: f64, z: f64) -> f64 {
        let a = Self::SIDE;
        let term = |k: u32| {
            let n = f64::from(2 * k + 1);
            let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            // cosh(b)/cosh(c) without overflow.
            let (b, c) = (n * PI * z.abs() / a, 0.5 * n * PI);
            let ratio = (b - c).exp() * (1.0 + (-2.0 * b).exp()) / (1.0 + (-2.0 * c).exp());
            sign / n.powi(3) * (1.0 - ratio) * (n * PI * y / a).cos()
        };
        4.0 * 0.4 * a * a / (PI.powi(3) * 1e-4) * (0..60).map(term).sum::<f64>()
    }
}

impl Case for DuctFlow {
    fn name(&self) -> &'static str {
        "duct_flow"
    }

    fn about(&self) -> &'static str {
        "laminar flow through a square duct, driven by a body force, against the exact series"
    }

    fn members(&self) -> Vec<Member> {
        let across = |n: f64| Member::new("duct_flow", Self::SIDE / n);
        let coarse = across(10.0)
            .with("domain.upper_m", vec![0.02, 0.02, 0.02])
            .with("fluid.region.0.shape.upper_m", vec![0.02, 0.02, 0.02]);
        vec![coarse, across(20.0), across(40.0)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let state = run.final_fluid()?;
        let field = |name: &str| state.field(name).ok_or_else(|| format!("no field `{name}`"));
        let (position, velocity) = (field("position")?, field("velocity")?);
        let (mut square, mut count) = (0.0, 0.0);
        for i in (0..state.group.len()).filter(|i| state.group[*i] == 0) {
            let [y, z] = [1, 2].map(|axis| position.values[3 * i + axis] - 0.5 * Self::SIDE);
            square += (velocity.values[3 * i] - Self::exact(y, z)).powi(2);
            count += 1.0;
        }
        let error = (square / count).sqrt() / Self::LARGEST;
        let length = if run.member.spacing > 0.0015 { 0.02 } else { 0.01 };
        // The body force on the water in the duct.
        let drive = 1000.0 * 0.4 * Self::SIDE * Self::SIDE * length;
        let shear = series::mean(&run.history("duct_force_x_n")?, 1.5, 2.0);
        let goals = (run.member.spacing < 0.0011).then_some((0.015, 0.03));
        let figure = Figure::judged("error of the velocity, L2 over u_max", error, Goal::AtMost(0.015));
        let force = Figure::compared("force along the walls [N]", shear, drive, 0.03);
        let report = |figure: Figure| if goals.is_some() { figure } else { figure.report_only() };
        Ok(vec![
            report(figure),
            report(force),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let mut errors = Vec::new();
        for run in runs {
            errors.push((run.member.spacing, self.figures(run)?[0].value));
        }
        let [.., (coarse, before), (fine, after)] = errors[..] else { return Ok(Vec::new()) };
        let order = (before / after).ln() / (coarse / fine).ln();
        Ok(vec![Figure::judged("order of the error of the velocity", order, Goal::AtLeast(1.0))])
    }
}

/// Flow through a round pipe.
pub struct PipeFlow;

impl PipeFlow {
    const RADIUS: f64 = 0.01;
    /// Largest velocity of the exact solution, g R²/(4 ν) \[m/s\].
    const LARGEST: f64 = 0.1;

    /// Distances from the axis \[m\] and velocities along it \[m/s\] of the water at the end.
    fn profile(run: &Run) -> Result<Vec<(f64, f64)>, String> {
        let state = run.final_fluid()?;
        let field = |name: &str| state.field(name).ok_or_else(|| format!("no field `{name}`"));
        let (position, velocity) = (field("position")?, field("velocity")?);
        let water = (0..state.group.len()).filter(|i| state.group[*i] == 0);
        let radius = |i: usize| position.values[3 * i + 1].hypot(position.values[3 * i + 2]);
        Ok(water.map(|i| (radius(i), velocity.values[3 * i])).collect())
    }

    fn exact(radius: f64) -> f64 {
        Self::LARGEST * (1.0 - (radius / Self::RADIUS).powi(2))
    }
}

impl Case for PipeFlow {
    fn name(&self) -> &'static str {
        "pipe_flow"
    }

    fn about(&self) -> &'static str {
        "laminar flow through a round pipe, driven by a body force, against the exact parabola"
    }

    fn members(&self) -> Vec<Member> {
        let across = |n: f64| Member::new("pipe_flow", 2.0 * Self::RADIUS / n);
        // Two supports long at the least.
        let coarse = |member: Member| {
            member
                .with("domain.lower_m", vec![0.0, -0.02, -0.02])
                .with("domain.upper_m", vec![0.02, 0.02, 0.02])
                .with("fluid.region.0.shape.to_m", vec![0.02, 0.0, 0.0])
                .with("wall.0.shape.to_m", vec![0.02, 0.0, 0.0])
        };
        let stairs = across(20.0).scheme("on the lattice").with("fluid.region.0.layout", "lattice");
        vec![coarse(across(10.0)), across(20.0), across(40.0), stairs]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let profile = Self::profile(run)?;
        let square: f64 = profile.iter().map(|(r, u)| (u - Self::exact(*r)).powi(2)).sum();
        let error = (square / profile.len() as f64).sqrt() / Self::LARGEST;
        let length = run.number("domain.upper_m.0")?;
        let area = PI * Self::RADIUS * Self::RADIUS;
        let shear = series::mean(&run.history("pipe_force_x_n")?, 1.5, 2.0);
        let flow = series::mean(&run.history("water_momentum_x_kg_m_per_s")?, 1.5, 2.0) / (1000.0 * length);
        let goal = if run.member.spacing < 0.0007 { 0.01 } else { 0.02 };
        let judged = run.member.spacing < 0.0011 && run.member.scheme == "recommended";
        let figure = |figure: Figure| judged_if(judged, figure);
        Ok(vec![
            figure(Figure::judged("error of the velocity, L2 over u_max", error, Goal::AtMost(goal))),
            // The body force on the water.
            figure(Figure::compared("force along the wall [N]", shear, 1000.0 * 0.4 * area * length, 0.03)),
            figure(Figure::compared("flow rate [m3/s]", flow, 0.5 * Self::LARGEST * area, 0.02)),
            Figure::reported(
                "mass of the water over that of the pipe's volume",
                series::at(&run.history("water_mass_kg")?, 0.0) / (1000.0 * area * length),
            ),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ])
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let mut errors = Vec::new();
        for run in runs.iter().filter(|run| run.member.scheme == "recommended") {
            errors.push((run.member.spacing, self.figures(run)?[0].value));
        }
        let [.., (coarse, before), (fine, after)] = errors[..] else { return Ok(Vec::new()) };
        let order = (before / after).ln() / (coarse / fine).ln();
        Ok(vec![Figure::judged("order of the error of the velocity", order, Goal::AtLeast(1.0))])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("profile", "distance from the axis [m]", "velocity [m/s]");
        plot.line(
            "exact",
            (0..=50).map(|k| f64::from(k) * Self::RADIUS / 50.0).map(|r| (r, Self::exact(r))).collect(),
        );
        for run in runs {
            let across = 2.0 * Self::RADIUS / run.member.spacing;
            plot.points(format!("{}, {across:.0} across", run.member.scheme), Self::profile(run)?);
        }
        Ok(vec![plot])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_profile_of_the_duct_has_its_known_values() {
        assert!((DuctFlow::exact(0.0, 0.0) - DuctFlow::LARGEST).abs() < 1e-6);
        assert!(DuctFlow::exact(0.01, 0.003).abs() < 1e-6 && DuctFlow::exact(0.003, 0.01).abs() < 1e-9);
    }
}
