//! Lock-step as the coordinator sees it: who has completed what, whether the momentum budgets balance, what may be granted next.
//!
//! Pure bookkeeping without I/O: events in, matched steps out.

use std::collections::VecDeque;

use sph::coupling::driver::StepReport;
use sph::coupling::ledger::{
    Imbalance, LedgerVector, TorqueCheck, balance_breaches, budget_breaches, imbalance,
};
use sph::coupling::solver::Role;
use sph::coupling::stage::{Stage, StepStage};
use sph::setup::LedgerPolicy;

use crate::results::matched_step::MatchedStep;

/// Matches the step reports of the participants and checks their momentum budgets.
#[derive(Debug)]
pub struct LockStep {
    policy: LedgerPolicy,
    torque: TorqueCheck,
    participants: Vec<Role>,
    waiting: [VecDeque<StepReport>; 2],
    impulse: [LedgerVector; 2],
    completed: u64,
}

impl LockStep {
    /// Lock-step of `participants` under `policy`.
    pub fn new(participants: Vec<Role>, policy: LedgerPolicy, torque: TorqueCheck) -> Self {
        Self {
            policy,
            torque,
            participants,
            waiting: [VecDeque::new(), VecDeque::new()],
            impulse: [LedgerVector::zeros(); 2],
            completed: 0,
        }
    }

    /// Continues after `completed` steps, in which `impulse` \[N s/m\] crossed the interface.
    pub fn resume(&mut self, completed: u64, impulse: [LedgerVector; 2]) {
        (self.completed, self.impulse) = (completed, impulse);
    }

    /// Steps that all participants have completed.
    pub fn completed(&self) -> u64 {
        self.completed
    }

    /// Takes the report of `role` and returns the step that it completes, if it does.
    pub fn report(&mut self, role: Role, report: StepReport) -> Option<MatchedStep> {
        self.waiting[role.index()].push_back(report);
        if self.participants.iter().any(|role| self.waiting[role.index()].is_empty()) {
            return None;
        }
        let (fluid, solid) = (self.waiting[0].pop_front(), self.waiting[1].pop_front());
        let matched = self.matched(fluid, solid);
        self.completed += 1;
        Some(matched)
    }

    fn matched(&mut self, fluid: Option<StepReport>, solid: Option<StepReport>) -> MatchedStep {
        let mut imbalances = [Imbalance::default(); 2];
        let mut breaches = Vec::new();
        let mut momentum_residual: f64 = 0.0;
        for (k, stage) in Stage::BOTH.into_iter().enumerate() {
            if let (Some(fluid), Some(solid)) = (&fluid, &solid) {
                let at = StepStage { step: fluid.step, stage };
                imbalances[k] =
                    imbalance(&fluid.budgets[k].interface, &solid.budgets[k].interface, self.torque);
                breaches.extend(
                    balance_breaches(at, &imbalances[k], &self.policy).into_iter().map(|b| (None, b)),
                );
            }
            for (role, report) in [(Role::Fluid, &fluid), (Role::Solid, &solid)] {
                let Some(report) = report else { continue };
                let at = StepStage { step: report.step, stage };
                momentum_residual = momentum_residual.max(report.budgets[k].momentum_residual());
                breaches.extend(
                    budget_breaches(at, &report.budgets[k], &self.policy)
                        .into_iter()
                        .map(|b| (Some(role), b)),
                );
            }
        }
        for (role, report) in [(Role::Fluid, &fluid), (Role::Solid, &solid)] {
            if let Some(report) = report {
                let corrector = &report.budgets[1];
                self.impulse[role.index()] += corrector.duration * corrector.interface.force;
            }
        }
        MatchedStep {
            fluid,
            solid,
            imbalance: imbalances,
            momentum_residual,
            breaches,
            impulse: self.impulse,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::coupling::ledger::{Account, AngularBudget, Check, InterfaceSums, StageBudget, axial};

    fn report(step: u64, force: LedgerVector) -> StepReport {
        let interface =
            InterfaceSums { force, gross_force: 10.0, gross_torque: 10.0, ..InterfaceSums::default() };
        let budget = |duration: f64| StageBudget {
            interface,
            duration,
            momentum_change: duration * force,
            gross_momentum: 1.0,
            ..StageBudget::default()
        };
        StepReport { step, time_step: 0.1, budgets: [budget(0.05), budget(0.1)], ..StepReport::default() }
    }

    fn coupled() -> LockStep {
        LockStep::new(vec![Role::Fluid, Role::Solid], LedgerPolicy::default(), TorqueCheck::Central)
    }

    #[test]
    fn a_step_is_complete_when_both_sides_are() {
        let mut lockstep = coupled();
        let force = LedgerVector::new(3.0, -1.0, 0.0);
        assert!(lockstep.report(Role::Fluid, report(0, force)).is_none());
        assert!(lockstep.report(Role::Fluid, report(1, force)).is_none());
        let matched = lockstep.report(Role::Solid, report(0, -force)).unwrap();
        assert!(matched.breaches.is_empty());
        assert_eq!(matched.any().step, 0);
        assert_eq!(lockstep.completed(), 1);
        let matched = lockstep.report(Role::Solid, report(1, -force)).unwrap();
        // Two corrector passes of 0.1 s.
        assert!((matched.impulse[0] - 0.2 * force).norm() < 1e-15);
        assert_eq!(matched.impulse[0], -matched.impulse[1]);
    }

    #[test]
    fn a_force_without_reaction_is_a_breach_of_both_stages() {
        let mut lockstep = coupled();
        lockstep.report(Role::Fluid, report(0, LedgerVector::new(3.0, 0.0, 0.0)));
        let matched = lockstep.report(Role::Solid, report(0, LedgerVector::new(-2.999, 0.0, 0.0))).unwrap();
        assert_eq!(matched.breaches.len(), 2);
        assert!(matched.breaches[0].1.to_string().contains("stale"), "{}", matched.breaches[0].1);
    }

    #[test]
    fn a_side_that_does_not_integrate_its_forces_is_named() {
        let mut lockstep = coupled();
        let force = LedgerVector::new(3.0, 0.0, 0.0);
        lockstep.report(Role::Fluid, report(0, force));
        let mut solid = report(0, -force);
        solid.budgets[1].momentum_change *= 1.01;
        let matched = lockstep.report(Role::Solid, solid).unwrap();
        assert_eq!(matched.breaches.len(), 1);
        assert_eq!(matched.breaches[0].0, Some(Role::Solid));
    }

    #[test]
    fn a_side_that_turns_more_than_its_torques_say_is_named() {
        let mut lockstep = LockStep::new(vec![Role::Solid], LedgerPolicy::default(), TorqueCheck::Central);
        let mut solid = report(0, LedgerVector::zeros());
        solid.budgets[1].accounts.add_torque(Account::BodyForce, axial(2.0));
        let budget = AngularBudget { change: axial(0.1 * 2.0), gross: 1.0 };
        solid.budgets[1].angular = Some(budget);
        assert!(lockstep.report(Role::Solid, solid).unwrap().breaches.is_empty());
        solid.budgets[1].angular = Some(AngularBudget { change: 1.05 * budget.change, ..budget });
        let matched = lockstep.report(Role::Solid, StepReport { step: 1, ..solid }).unwrap();
        let [(role, breach)] = matched.breaches.as_slice() else { panic!("{:?}", matched.breaches) };
        assert_eq!((*role, breach.check), (Some(Role::Solid), Check::AngularMomentum));
        assert!((breach.residual - 0.01).abs() < 1e-15);
    }

    #[test]
    fn one_participant_needs_no_partner() {
        let mut lockstep = LockStep::new(vec![Role::Solid], LedgerPolicy::default(), TorqueCheck::Central);
        assert!(lockstep.report(Role::Solid, report(0, LedgerVector::zeros())).is_some());
    }
}
