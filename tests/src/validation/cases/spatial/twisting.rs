//! A column that is twisted to large strains and turns back.

use std::collections::BTreeMap;

use super::common::{energy, unwrapped};
use crate::validation::cases::beams::cost;
use crate::validation::snapshot::Arrays;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// Twisting column of Lee, Gil & Bonet (2014), and one nearly four times as fast.
pub struct TwistingColumn;

/// Scheme of the fast one.
const FAST: &str = "400 rad/s";

impl TwistingColumn {
    /// Twist \[rad\] near the free end in time.
    fn twist(run: &Run) -> Result<Vec<(f64, f64)>, String> {
        let (y, z) = (run.column("edge_displacement_y_m")?, run.column("edge_displacement_z_m")?);
        let angle = unwrapped(y.into_iter().zip(z).map(|(y, z)| z.atan2(0.4 + y)));
        Ok(run.column("t_s")?.into_iter().zip(angle).collect())
    }

    /// Largest distance \[m\] of the middle of a section from the axis, and least ratio of volumes, over all snapshots.
    fn sections(run: &Run) -> Result<(f64, f64), String> {
        let (mut off, mut least) = (0.0_f64, f64::INFINITY);
        for (_, path) in run.solid_snapshots()? {
            let arrays = Arrays::open(&path)?;
            let (now, before) = (arrays.numbers("Points")?, arrays.numbers("reference_position")?);
            let mut sections: BTreeMap<i64, [f64; 3]> = BTreeMap::new();
            for (x, from) in now.chunks_exact(3).zip(before.chunks_exact(3)) {
                // Rows are whole spacings apart.
                let row = sections.entry((from[0] / run.member.spacing).floor() as i64).or_default();
                *row = [row[0] + 1.0, row[1] + x[1], row[2] + x[2]];
            }
            off = sections.values().fold(off, |off, [n, y, z]| off.max(y.hypot(*z) / n));
            let densities = arrays.numbers("density")?;
            least = densities.iter().fold(least, |least, density| least.min(1100.0 / density));
        }
        Ok((off, least))
    }
}

impl Case for TwistingColumn {
    fn name(&self) -> &'static str {
        "twisting_column"
    }

    fn about(&self) -> &'static str {
        "column twisted by its initial velocity, out and back: energy, volumes, straight axis"
    }

    fn members(&self) -> Vec<Member> {
        let slow = |across: f64| Member::solid("twisting_column", 1.0 / across).scheme("105 rad/s");
        let fast = |across: f64| {
            slow(across)
                .scheme(FAST)
                .with("solid.body.0.material.poisson_ratio", 0.45)
                .with(
                    "solid.body.0.velocity_m_s",
                    vec!["0", "400*sin(pi*ramp(x)/12)*z", "-400*sin(pi*ramp(x)/12)*y"],
                )
                // The stress comes to more than twice Young's modulus, of which hourglass control is a part: with the
                // default of 0.3 the column folds between its particles.
                .with("solid.body.0.formulation.hourglass", 1.0)
                // Shear brings parts of the column nearer to each other than contact permits while it does not fold.
                .with("solid.contact.self_contact", false)
                .with("domain.lower_m", vec![-2.0, -4.0, -4.0])
                .with("domain.upper_m", vec![12.0, 4.0, 4.0])
        };
        let rows = |member: Member| {
            let lower = vec![-4.0 * member.spacing, -0.5, -0.5];
            member
                .with("solid.body.0.shape.lower_m", lower.clone())
                .with("solid.body.0.support.0.shape.lower_m", lower)
        };
        vec![
            rows(slow(6.0)).with("time.end_time_s", 0.3).quick(),
            rows(slow(8.0)),
            rows(slow(12.0)),
            rows(fast(8.0)),
            rows(fast(12.0)),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let twist = Self::twist(run)?;
        let (mut turn, mut largest) = (0.0, 0.0_f64);
        for (t, angle) in &twist {
            if angle.abs() > largest {
                (turn, largest) = (*t, angle.abs());
            }
        }
        let sign = if run.member.scheme == FAST { -1.0 } else { 1.0 };
        let back =
            twist.iter().find(|(t, angle)| *t > turn && sign * angle <= 0.0).map_or(f64::NAN, |row| row.0);
        let total = energy(run, "column")?;
        let end = twist.last().map_or(f64::NAN, |row| row.0);
        let (off, least) = Self::sections(run)?;
        let rise = series::largest(total.iter().map(|e| e / total[0] - 1.0));
        let lost = 1.0 - total.last().copied().unwrap_or(f64::NAN) / total[0];
        Ok(vec![
            Figure::reported("largest twist near the end [rad]", largest),
            Figure::reported("time of the largest twist [s]", turn),
            Figure::judged("time of the way back through zero twist [s]", back, Goal::AtMost(end)),
            // Round-off of the sums.
            Figure::judged("rise of kinetic and strain energy over the start", rise, Goal::AtMost(1e-9)),
            Figure::judged("loss of energy per 0.1 s", lost * 0.1 / end, Goal::AtMost(0.01)),
            Figure::judged(
                "least ratio of volumes J of the snapshots",
                least,
                Goal::AtLeast(f64::MIN_POSITIVE),
            ),
            Figure::judged("middle of a section off the axis, over the side", off, Goal::AtMost(0.01)),
            cost(run)?,
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut twist = Plot::new("twist", "t [s]", "twist near the end [rad]");
        let mut total = Plot::new("energy", "t [s]", "kinetic and strain energy over those of the start");
        for run in runs {
            let label = format!("{}, {:.0} across", run.member.scheme, 1.0 / run.member.spacing);
            twist.line(label.clone(), Self::twist(run)?);
            let energy = energy(run, "column")?;
            let times = run.column("t_s")?.into_iter();
            total.line(label, times.zip(energy.iter().map(|e| e / energy[0])).collect());
        }
        Ok(vec![twist, total])
    }
}
