//! A swinging ball of water.

use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// A ball that swings under a central force.
pub struct Drop3d;

impl Drop3d {
    /// Semi-axes along x and z \[m\] from 0 to `end` \[s\] in steps of 5 ms, by the Runge-Kutta rule.
    ///
    /// ```text
    /// a_i' = A_i a_i,  A_i' = −A_i² − Ω² + 2P/a_i²,  P = (Σ A_i² + 3 Ω²)/(2 Σ 1/a_i²);  Ω = 1, A = (−½, −½, 1) at t = 0
    /// ```
    fn exact(end: f64) -> Vec<(f64, [f64; 2])> {
        const STEP: f64 = 5e-3;
        let rate = |[a, c, across, along]: [f64; 4]| {
            let p = (2.0 * across * across + along * along + 3.0) / (2.0 * (2.0 / (a * a) + 1.0 / (c * c)));
            [
                across * a,
                along * c,
                -across * across - 1.0 + 2.0 * p / (a * a),
                -along * along - 1.0 + 2.0 * p / (c * c),
            ]
        };
        let plus = |y: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
        let mut y = [1.0, 1.0, -0.5, 1.0];
        let mut found = vec![(0.0, [1.0, 1.0])];
        // Whole and small.
        for step in 1..=(end / STEP).round() as u32 {
            let k1 = rate(y);
            let k2 = rate(plus(y, k1, 0.5 * STEP));
            let k3 = rate(plus(y, k2, 0.5 * STEP));
            let k4 = rate(plus(y, k3, STEP));
            y = std::array::from_fn(|i| y[i] + STEP / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
            found.push((STEP * f64::from(step), [y[0], y[1]]));
        }
        found
    }

    /// Semi-axis \[m\] along `axis` in time, of an ellipsoid with the second moments of the particles.
    fn semi_axis(run: &Run, axis: &str) -> Result<Vec<(f64, f64)>, String> {
        let moments = run.history(&format!("drop_second_moment_{axis}{axis}_m2"))?;
        Ok(moments.into_iter().map(|(t, m)| (t, (5.0 * m).sqrt())).collect())
    }
}

/// Time and value at the largest of a series between two times, by the parabola through three points.
fn peak(points: &[(f64, f64)], from: f64, to: f64) -> (f64, f64) {
    let inside = |k: &usize| (from..=to).contains(&points[*k].0);
    let largest = (1..points.len().saturating_sub(1))
        .filter(inside)
        .max_by(|a, b| points[*a].1.total_cmp(&points[*b].1));
    let Some(k) = largest else { return (f64::NAN, f64::NAN) };
    let [(t, y0), (_, y1), (t2, y2)] = [points[k - 1], points[k], points[k + 1]];
    let half = 0.5 * (t2 - t);
    let offset = 0.5 * (y0 - y2) / (y0 - 2.0 * y1 + y2);
    (t + half + offset * half, y1 - 0.25 * (y0 - y2) * offset)
}

impl Case for Drop3d {
    fn name(&self) -> &'static str {
        "drop_3d"
    }

    fn about(&self) -> &'static str {
        "ball that swings under a central force: semi-axes, period, volume over one period against the exact solution"
    }

    fn members(&self) -> Vec<Member> {
        let short =
            Member::new("drop_3d", 0.1).scheme("to the first stretch").with("time.end_time_s", 1.4).quick();
        vec![short, Member::new("drop_3d", 0.1), Member::new("drop_3d", 0.05)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let [x, y, z] = [Self::semi_axis(run, "x")?, Self::semi_axis(run, "y")?, Self::semi_axis(run, "z")?];
        let end = z.last().map_or(0.0, |(t, _)| *t);
        let exact: Vec<(f64, f64)> = Self::exact(end).into_iter().map(|(t, [_, c])| (t, c)).collect();
        let ((_, largest), (_, reference)) = (peak(&z, 0.8, 1.6), peak(&exact, 0.8, 1.6));
        // An ellipsoid of these axes, over the ball.
        let volume = |t: f64| {
            [&x, &y, &z].map(|axis| series::at(axis, t)).iter().product::<f64>() / series::at(&x, 0.0).powi(3)
        };
        let drift = x.iter().map(|(t, _)| (volume(*t) - 1.0).abs()).fold(0.0, f64::max);
        let unround = x.iter().zip(&y).map(|((_, a), (_, b))| (a / b - 1.0).abs()).fold(0.0, f64::max);
        let judged = |figure: Figure| {
            // The goals are asked for at 20 particles in the radius.
            if run.member.spacing > 0.051 { figure.report_only() } else { figure }
        };
        let mut figures = vec![
            judged(Figure::compared("largest semi-axis along z [m]", largest, reference, 0.02)),
            judged(Figure::judged(
                "largest change of the volume by second moments",
                drift,
                Goal::AtMost(0.01),
            )),
            judged(Figure::judged("largest |a_x/a_y - 1|", unround, Goal::AtMost(0.005))),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        if end > 4.5 {
            // The least extent along z, once a period.
            let negative: Vec<(f64, f64)> = z.iter().map(|(t, c)| (*t, -c)).collect();
            let exact: Vec<(f64, f64)> = exact.iter().map(|(t, c)| (*t, -c)).collect();
            let ((time, least), (at, exact_least)) = (peak(&negative, 2.5, 4.5), peak(&exact, 2.5, 4.5));
            figures.push(judged(Figure::compared("time of the least semi-axis along z [s]", time, at, 0.01)));
            figures.push(
                Figure::compared("least semi-axis along z [m]", -least, -exact_least, 0.02).report_only(),
            );
        }
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("semi_axes", "t [s]", "semi-axis along z [m]");
        plot.line("exact", Self::exact(4.65).into_iter().map(|(t, [_, c])| (t, c)).collect());
        for run in runs {
            plot.line(format!("{}, {} m", run.member.scheme, run.member.spacing), Self::semi_axis(run, "z")?);
        }
        Ok(vec![plot])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_semi_axes_have_their_known_values() {
        let exact = Drop3d::exact(4.65);
        let along: Vec<(f64, f64)> = exact.iter().map(|(t, [_, c])| (*t, *c)).collect();
        let (time, largest) = peak(&along, 0.8, 1.6);
        assert!((time - 1.21988).abs() < 1e-4 && (largest - 1.84885).abs() < 1e-5, "{time} {largest}");
        assert!(exact.iter().all(|(_, [a, c])| (a * a * c - 1.0).abs() < 1e-9));
    }
}
