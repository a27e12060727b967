//! What sub-steps of the solids save in case 5.2, against lock-step at the time step of the source paper.
//!
//! Judged until the body has settled through the floor water: once it touches the floor its path is chaotic.

use super::floating::coupling;
use crate::validation::{Case, Figure, Goal, Member, Run, series};

/// See the module.
pub struct Substeps;

/// Just before the body comes to its touching distance from the floor \[s\].
const END: f64 = 0.06;

fn member() -> Member {
    Member::new("../drifting_body", 0.002)
        .with("time.end_time_s", END)
        .with("outputs.picture_times_s", vec![0.0, END])
}

impl Case for Substeps {
    fn name(&self) -> &'static str {
        "substeps"
    }

    fn about(&self) -> &'static str {
        "case 5.2 until the body touches the floor: sub-steps of the solids against lock-step at 1e-5 s"
    }

    fn members(&self) -> Vec<Member> {
        vec![member().with("time.step.time_step_s", 1e-5).scheme("lock-step"), member().scheme("recommended")]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let mut figures = coupling(run);
        let reached = run.history("body_centre_y_m")?.last().map_or(f64::NAN, |point| point.0);
        figures.push(Figure::judged("reached time [s]", reached, Goal::AtLeast(0.999 * END)));
        figures.push(Figure::reported("CPU time [s]", run.cpu_seconds));
        Ok(figures)
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let [lock_step, recommended] = runs else { return Ok(Vec::new()) };
        let height = |run: &Run| run.history("body_centre_y_m");
        let (reference, found) = (height(lock_step)?, height(recommended)?);
        let difference = reference.iter().map(|(t, y)| (series::at(&found, *t) / y - 1.0).abs());
        Ok(vec![
            Figure::judged(
                "CPU time of lock-step over that with sub-steps",
                lock_step.cpu_seconds / recommended.cpu_seconds,
                Goal::AtLeast(3.0),
            ),
            Figure::judged(
                "largest relative difference of the body's height",
                series::largest(difference),
                Goal::AtMost(0.01),
            ),
        ])
    }
}
