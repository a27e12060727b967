//! Implicit coupling: a solid that diverges with one exchange per half-step, and a fluid that answers repeatedly.

use sph::coupling::driver::StepReport;
use sph::coupling::solver::Role;
use sph::setup::{CouplingKind, ImplicitCoupling, NonConvergence, Relaxation};

use super::bench::Bench;
use super::dummy::Quirk;
use super::scene::Scene;
use super::{Finding, not_offered, passed};

const PLAN: ImplicitCoupling = ImplicitCoupling {
    relaxation: Relaxation::Aitken,
    tolerance: 1e-9,
    limit: 100,
    non_convergence: NonConvergence::Stop,
};

/// Time step times the rate of the damper: a single exchange would multiply the speed by 1 - z + z²/2 = 2.5 a step, and plain
/// repetition each error of it by z/2.
const STIFFNESS: f64 = 3.0;

pub(super) async fn iterated(bench: &Bench) -> Finding {
    if !bench.description.capabilities.implicit_coupling {
        return not_offered("the capability `implicit_coupling` is not declared");
    }
    if bench.kind != CouplingKind::Loads {
        return not_offered("implicit coupling goes with force coupling only");
    }
    match bench.role {
        Role::Fluid => answers(bench).await,
        Role::Solid if bench.takes_free_bodies => converges(bench).await,
        Role::Solid => not_offered("it takes clamped bodies only, whose speed is not visible"),
    }
}

/// Largest number of iterations in a step of `own`, which must be those of its partner.
fn iterations(own: &[StepReport], partner: &[StepReport]) -> Result<u32, String> {
    let count = |reports: &[StepReport]| -> Vec<_> {
        reports.iter().map(|report| (report.iterations, report.unconverged)).collect()
    };
    if count(own) != count(partner) {
        return Err("its step reports state other iterations than those of its partner".into());
    }
    match own.iter().map(|report| report.iterations).max() {
        None | Some(0) => Err("no half-step was iterated".into()),
        Some(most) => Ok(most),
    }
}

/// A stiff damper slows a solid by (1 - z/2)/(1 + z/2) a step, which is the implicit midpoint rule.
async fn converges(bench: &Bench) -> Finding {
    let velocity = bench.vector([0.7, -0.3, 0.2]);
    let scene = Scene { velocity, steps: 4, implicit: Some(PLAN), ..bench.still() };
    let quirk = Quirk { damper: Some(STIFFNESS / scene.time_step), ..Quirk::default() };
    let [own, dummy] = bench.completed(scene, quirk).await?;
    let most = iterations(&own.reports, &dummy.reports)?;
    let factor = (1.0 - 0.5 * STIFFNESS) / (1.0 + 0.5 * STIFFNESS);
    let expected = velocity * (0..scene.steps).map(|_| factor).product::<f64>();
    // A step's forces may be off by the tolerance, which is z/2 of it in velocity; ten times that over four steps.
    let allowed = 10.0 * STIFFNESS * PLAN.tolerance * velocity.norm();
    for (i, found) in own.field(bench.space, "velocity")?.iter().enumerate() {
        let error = (found - expected).norm();
        if error.is_nan() || error > allowed {
            return Err(format!(
                "particle {i} has the velocity {found:?} m/s after {} steps, expected {expected:?}: its accepted states do \
                 not satisfy the midpoint rule with the forces at n+1/2",
                scene.steps
            ));
        }
    }
    passed(format!("midpoint rule at dt c/m = {STIFFNESS}, at most {most} iterations"))
}

/// A fluid whose coupling points stay where they are ends in the state of a run with explicit coupling.
async fn answers(bench: &Bench) -> Finding {
    let scene = bench.pushing();
    let [once, _] = bench.completed(scene, Quirk::default()).await?;
    let [own, dummy] = bench.completed(Scene { implicit: Some(PLAN), ..scene }, Quirk::default()).await?;
    let most = iterations(&own.reports, &dummy.reports)?;
    // Debug of a float shows all its bits but those of a NaN.
    if format!("{:?}", once.state) != format!("{:?}", own.state) {
        return Err("the same coupling points, sent again, lead to another state".into());
    }
    passed(format!("at most {most} iterations leave all bits as they are"))
}
