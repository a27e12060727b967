//! Bodies of a solid: the constants by which they move, and their angular momentum.

use sph::coupling::solver::Role;
use sph::setup::ParticipantSetup;

use super::bench::{Bench, Record};
use super::dummy::Quirk;
use super::scene::Scene;
use super::{Finding, not_offered, passed};
use crate::handshake;

/// Relative round-off of sums over some hundred particles and steps.
const ROUND_OFF: f64 = 1e-12;
/// Smallest change of angular momentum over its gross at which an error of a percent shows.
const TURNS: f64 = 1e-8;

/// Both formulations that a solid may be given, a rigid body first: its motion has to follow from its mass and inertia.
fn scenes(bench: &Bench) -> [Scene; 2] {
    let scene = Scene { rise: 3, ..bench.pushing() };
    [Scene { rigid: true, clamped: false, ..scene }, scene]
}

pub(super) async fn masses(bench: &Bench) -> Finding {
    if bench.role == Role::Fluid {
        return not_offered("a fluid has no bodies");
    }
    let mut compared = 0;
    for scene in scenes(bench) {
        let setup = scene.setup(Role::Solid);
        // Not every solver takes both formulations.
        let Ok((mut client, report)) = bench.open(&setup).await else { continue };
        client.close().await.map_err(|e| e.to_string())?;
        let ParticipantSetup::Solid(solid) = &setup else { continue };
        let differences = handshake::other_bodies(solid, &report);
        if !differences.is_empty() {
            return Err(differences.join("; "));
        }
        compared += report.bodies.len();
    }
    if compared == 0 {
        return not_offered("`OpenReply.bodies` is empty");
    }
    passed(format!("mass and inertia of {compared} bodies"))
}

pub(super) async fn angular_momentum(bench: &Bench) -> Finding {
    let mut problem = "it takes no set-up of the kit".to_owned();
    for scene in scenes(bench) {
        if let Ok((mut client, _)) = bench.open(&scene.setup(bench.role)).await {
            client.close().await.map_err(|e| e.to_string())?;
            let [own, _] = bench.completed(scene, Quirk::default()).await?;
            match residual(&own)? {
                Some(text) => return passed(text),
                None => problem = "it reports no budget of the angular momentum".into(),
            }
        }
    }
    not_offered(problem)
}

/// Compares the angular momentum of all half-steps with the torques; `None` without a budget.
fn residual(record: &Record) -> Result<Option<String>, String> {
    let budgets = || record.reports.iter().flat_map(|report| &report.budgets);
    if budgets().any(|budget| budget.angular.is_none()) {
        return Ok(None);
    }
    let (mut worst, mut turned) = (0.0f64, 0.0f64);
    for budget in budgets() {
        let residual = budget.angular_residual();
        if residual.is_nan() {
            return Err("the budget of the angular momentum holds NaN".into());
        }
        worst = worst.max(residual);
        let interface = (budget.duration * budget.interface.torque).norm();
        turned = turned.max(budget.angular.map_or(0.0, |budget| interface / budget.gross));
    }
    if worst > ROUND_OFF {
        return Err(format!(
            "the change of angular momentum is off by {worst:.1e} of gross from the torques, allowed {ROUND_OFF:e}: torque or \
             moment of inertia are not those of the forces and particles"
        ));
    }
    if turned < TURNS {
        return Err(format!(
            "the water presses beside the centre, but the torque is {turned:.1e} of gross only"
        ));
    }
    Ok(Some(format!("torques and angular momentum agree to {worst:.1e} of gross")))
}
