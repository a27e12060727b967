//! Cases that are hard to survive: they have to run to their end without losing a particle.

use crate::validation::{Case, Figure, Goal, Member, Run, energy, series};

/// See the module.
pub struct Hard;

/// Case files in which nothing does work on the water.
const CLOSED: [&str; 4] = ["dam_break", "hard_channel", "hard_drop_on_pool", "hard_wedge"];

/// Spacing of the dam breaks \[m\].
const SPACING: f64 = 0.008;

impl Case for Hard {
    fn name(&self) -> &'static str {
        "hard"
    }

    fn about(&self) -> &'static str {
        "hard cases run to their end and lose no particle; a tsunami-scale tank gives the same dimensionless result"
    }

    fn members(&self) -> Vec<Member> {
        let dam_break =
            |scheme| Member::new("dam_break", SPACING).scheme(scheme).with("time.end_time_s", 0.6);
        let step: toml::Table =
            "type = \"adaptive\"\nfactor = 0.95\nmaximum_s = 1.0".parse().unwrap_or_default();
        vec![
            Member::new("hard_channel", 0.01),
            Member::new("hard_jet", 0.01),
            Member::new("hard_drop_on_pool", 0.01),
            Member::new("hard_sloshing", 0.012),
            Member::new("hard_wedge", 0.004),
            Member::new("hard_wedge", 0.004).scheme("no-slip").with("wall.1.condition", "no-slip"),
            Member::new("hard_rotating_tank", 0.004),
            Member::new("hard_rotating_tank", 0.004).scheme("no-slip").with("wall.0.condition", "no-slip"),
            dam_break("thrown water to 2 s").with("time.end_time_s", 2.0),
            // 15 and 40 times sqrt(2gH) = 2.39 m/s.
            dam_break("c0 = 15 v").with("fluid.sound_speed_m_s", 35.9),
            dam_break("c0 = 40 v").with("fluid.sound_speed_m_s", 95.7),
            dam_break("h over dx 1.2").with("fluid.kernel_ratio", 1.2),
            dam_break("displaced lattice").with("fluid.region.0.displacement_fraction", 0.1),
            dam_break("step at 95 % of the limit").with("time.step", step),
            dam_break("metre scale"),
            tsunami_scale(dam_break("tsunami scale")),
            dam_break("h over dx 1.5").with("fluid.kernel_ratio", 1.5).may_stop(),
            dam_break("A = B = 0.01")
                .with("fluid.artificial_viscosity_a", 0.01)
                .with("fluid.artificial_viscosity_b", 0.01)
                .may_stop(),
            // 10 times sqrt(2gH): compression in the impact reaches percents.
            dam_break("c0 = 10 v, thrown water to 2 s")
                .with("fluid.sound_speed_m_s", 23.9)
                .with("time.end_time_s", 2.0)
                .may_stop(),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let end = run.column("t_s")?.last().copied().unwrap_or(f64::NAN);
        if let Some(reason) = run.stopped() {
            terminal::say(format_args!("  {} stopped: {reason}", run.member.label()));
            return Ok(vec![Figure::reported("stopped with a diagnosis at [s]", end)]);
        }
        let mut figures = vec![
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
            Figure::reported("reached time [s]", end),
        ];
        // Elsewhere walls or body forces do work.
        if CLOSED.contains(&run.member.file) {
            figures.push(energy::rise(run, "water")?);
        }
        Ok(figures)
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let find = |scheme: &str| runs.iter().find(|run| run.member.scheme == scheme);
        let (Some(metre), Some(tsunami)) = (find("metre scale"), find("tsunami scale")) else {
            return Ok(Vec::new());
        };
        // Time in units of the large run, ten times slower; lengths a hundred times larger.
        let fronts = |run: &Run, time: f64, length: f64| -> Result<Vec<(f64, f64)>, String> {
            let history = run.history("head_front_x_m")?;
            Ok(history.into_iter().map(|(t, x)| (t / time, x / length)).collect())
        };
        let (small, large) = (fronts(metre, 1.0, 1.0)?, fronts(tsunami, 10.0, 100.0)?);
        let difference = |t: &f64| (series::at(&large, *t) / series::at(&small, *t) - 1.0).abs();
        let worst = series::largest([0.1, 0.15, 0.2, 0.25].iter().map(difference));
        Ok(vec![Figure::judged(
            "largest difference of the front, tsunami over metre scale",
            worst,
            Goal::AtMost(0.01),
        )])
    }
}

/// `member` with lengths a hundred times and times ten times as large.
fn tsunami_scale(member: Member) -> Member {
    let shape: toml::Table =
        "type = \"rectangle\"\nlower_m = [0.0, 0.0]\nupper_m = [14.6, 29.2]".parse().unwrap_or_default();
    let start: toml::Table = "type = \"hydrostatic\"\nsurface_m = 29.2".parse().unwrap_or_default();
    Member { spacing: 100.0 * SPACING, ..member }
        .with("fluid.particle_spacing_m", 100.0 * SPACING)
        .with("domain.upper_m", vec![58.4, 58.4])
        .with("fluid.region.0.shape", shape)
        .with("fluid.region.0.start", start)
        .with("fluid.sound_speed_m_s", 240.0)
        .with("time.end_time_s", 6.0)
        .with("outputs.snapshot_interval_s", 0.1)
        .with("outputs.probe_interval_s", 0.02)
        .with("outputs.picture_times_s", vec![1.0, 2.0, 4.0, 6.0])
}
