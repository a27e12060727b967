//! Contact of solids: sliding, resting, folding.

use super::beams::energy_ratio;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// A block that slides down an incline.
pub struct Incline;

/// Blocks that rest on each other.
pub struct Stack;

/// A plate that folds onto itself, one that is struck until it folds, and bodies of both formulations.
pub struct Fold;

/// Components of gravity along and across an incline of tangent ½ \[m/s²\].
const ALONG: f64 = 9.81 * 0.447_213_595_5;
const ACROSS: f64 = 9.81 * 0.894_427_191;

/// Deepest contact of the run in particle spacings.
fn deepest(run: &Run) -> Result<f64, String> {
    Ok(run.count("/solid/counts/deepest_contact_m")? / run.member.spacing)
}

impl Case for Incline {
    fn name(&self) -> &'static str {
        "incline"
    }

    fn about(&self) -> &'static str {
        "acceleration of a block down an incline of tangent 0.5 against g (sin a - mu cos a)"
    }

    fn members(&self) -> Vec<Member> {
        let member = |spacing| Member::solid("contact_incline", spacing);
        let damping: toml::Table = "rate_per_s = 1000.0\nuntil_s = 0.05".parse().unwrap_or_default();
        vec![
            member(0.004).scheme("friction 0.3").quick(),
            member(0.002).scheme("friction 0.3"),
            member(0.004).scheme("smooth").with("solid.contact.friction", 0.0),
            // An undamped block hops by micrometres when gravity sets in, and creeps while it does.
            member(0.004)
                .scheme("sticks")
                .with("solid.contact.friction", 0.6)
                .with("solid.body.0.velocity_m_s", vec![0.0, 0.0])
                .with("solid.damping", damping),
            Member::solid("contact_incline_tilted", 0.004).scheme("stairs"),
            Member::solid("contact_incline_tilted", 0.002).scheme("stairs"),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let friction = run.number("solid.contact.friction")?;
        let end = run.column("t_s")?.last().copied().unwrap_or(f64::NAN);
        let deepest = Figure::reported("deepest contact [dx]", deepest(run)?);
        if run.member.scheme == "sticks" {
            let path = run.history("block_centre_x_m")?;
            // From when it has settled on the face.
            let creep = (series::at(&path, end) - series::at(&path, 0.1)) / run.member.spacing;
            // Round-off; a slide would be of many spacings.
            return Ok(vec![
                Figure::judged("creep from 0.1 s [dx]", creep, Goal::Between(-1e-6, 1e-6)),
                deepest,
            ]);
        }
        let stairs = run.member.scheme == "stairs";
        let velocity = |axis: &str| run.history(&format!("block_velocity_{axis}_m_s"));
        let mut along = velocity("x")?;
        if stairs {
            // Along the face, which falls to the right.
            let down = velocity("y")?;
            along.iter_mut().zip(down).for_each(|(x, y)| x.1 = (2.0 * x.1 - y.1) / 5f64.sqrt());
        }
        let (_, acceleration) = series::line(&series::window(&along, 0.05, end));
        let figure = Figure::compared("acceleration [m/s2]", acceleration, ALONG - friction * ACROSS, 0.02);
        Ok(vec![if stairs { figure.report_only() } else { figure }, deepest])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("speed", "t [s]", "velocity of the block [m/s]");
        for run in runs {
            let name = format!("{}, {} m", run.member.scheme, run.member.spacing);
            plot.line(name, run.history("block_velocity_x_m_s")?);
        }
        Ok(vec![plot])
    }
}

impl Case for Stack {
    fn name(&self) -> &'static str {
        "stack"
    }

    fn about(&self) -> &'static str {
        "three blocks stacked on a floor stay where they are for 2 s"
    }

    fn members(&self) -> Vec<Member> {
        vec![
            Member::solid("contact_stack", 0.004),
            Member::solid("contact_stack", 0.002),
            Member::solid("contact_stack", 0.004).scheme("0.2 s").with("time.end_time_s", 0.2).quick(),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let spacing = run.member.spacing;
        let mut figures = Vec::new();
        for body in ["lower", "middle", "upper"] {
            let moved = |axis: &str| -> Result<f64, String> {
                let path = run.column(&format!("{body}_centre_{axis}_m"))?;
                Ok(series::largest(path.iter().map(|x| (x - path[0]).abs())) / spacing)
            };
            // Measured against the lattice: a locked-in or creeping block moves by whole spacings.
            figures.push(Figure::judged(
                format!("{body}: moved sideways [dx]"),
                moved("x")?,
                Goal::AtMost(0.05),
            ));
            figures.push(Figure::judged(format!("{body}: sank [dx]"), moved("y")?, Goal::AtMost(0.1)));
        }
        let weight = 9.81 * run.column("all_mass_kg_per_m")?[0];
        let floor = run.history("touch_contact_walls_y_n_per_m")?;
        let end = floor.last().map_or(f64::NAN, |(t, _)| *t);
        let carried = series::mean(&floor, 0.5 * end, end) / weight;
        figures.push(Figure::compared("force of the floor over the weight", carried, 1.0, 0.02));
        figures.push(Figure::reported("deepest contact [dx]", deepest(run)?));
        Ok(figures)
    }
}

impl Case for Fold {
    fn name(&self) -> &'static str {
        "fold"
    }

    fn about(&self) -> &'static str {
        "a plate folds onto itself or around a hammer, a document's block hits a clamped plate: no overlap, no energy made"
    }

    fn members(&self) -> Vec<Member> {
        let member = |file, spacing| Member::solid(file, spacing);
        vec![
            member("contact_fold", 0.002).scheme("onto itself").quick(),
            member("contact_fold", 0.001).scheme("onto itself").with("time.step.time_step_s", 5e-6),
            member("contact_strike", 0.002).scheme("hammer"),
            member("contact_mixed", 0.002).scheme("both formulations"),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let rise = energy_ratio(run, "all")? - 1.0;
        let deepest = deepest(run)?;
        // The hammer, rigid and at 0.44 of the sound speed, has to be kept out; the others may not overlap.
        let allowed = if run.member.file == "contact_strike" { 0.9 } else { 0.5 };
        Ok(vec![
            Figure::judged("deepest contact [dx]", deepest, Goal::Between(0.01, allowed)),
            Figure::judged("rise of energy over the start", rise, Goal::AtMost(0.001)),
            Figure::reported(
                "impulse of contact [N s/m]",
                run.count("/solid/counts/contact_impulse_n_s_per_m")?,
            ),
        ])
    }
}
