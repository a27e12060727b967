//! Lost servers: how each ended, and whether it helps to start them again.

use sph::coupling::solver::Role;

use super::attempt::EndedAttempt;
use super::control::ending::Ending;
use super::participants::remote::End;
use crate::failure::Failure;

/// So many equal losses in a row are no accident: what ends a solver is in the run or in the solver.
const ENOUGH: usize = 3;

/// A loss of servers, or of the connection between them.
#[derive(Clone, Debug, PartialEq)]
struct Loss {
    roles: Vec<Role>,
    /// Step in which they were missed.
    step: u64,
    /// How their processes ended, as far as they have.
    ends: Vec<(Role, String)>,
}

impl Loss {
    /// Whether it is the loss `before` again. What a process sent last may have been lost on the way, so that it is missed in
    /// one step or the next.
    fn repeats(&self, before: &Self) -> bool {
        self.roles == before.roles && self.ends == before.ends && self.step.abs_diff(before.step) <= 1
    }
}

/// The losses of a run.
#[derive(Debug, Default)]
pub(super) struct Losses(Vec<Loss>);

impl Losses {
    /// Adds a loss; answers whether it is one too many of its kind.
    fn add(&mut self, loss: Loss) -> bool {
        self.0.push(loss);
        let last = self.0.rchunks(ENOUGH).next().filter(|last| last.len() == ENOUGH);
        last.is_some_and(|last| last.windows(2).all(|pair| pair[1].repeats(&pair[0])))
    }
}

impl EndedAttempt {
    /// Notes in `losses` what was lost, says in the failure how it ended, and returns it where a restart may help:
    /// below `most` times.
    pub(super) async fn lost(&mut self, losses: &mut Losses, most: u64) -> Option<(Vec<Role>, Failure)> {
        let Ending::Lost { roles, step, failure } = &mut self.ending else { return None };
        let ends = match self.solvers.remote_mut() {
            Some(remote) => remote.ends(roles).await,
            None => Vec::new(),
        };
        let mut last_words = String::new();
        for End { role, status, last_words: of_role } in &ends {
            failure.message.push_str(&format!("; the process of the {role} solver ended by {status}"));
            last_words.push_str(of_role);
        }
        let ends = ends.into_iter().map(|end| (end.role, end.status)).collect();
        // Of two that are lost at once either may be missed first.
        roles.sort_unstable();
        let restarts = u64::try_from(losses.0.len()).unwrap_or(u64::MAX);
        let in_vain = losses.add(Loss { roles: roles.clone(), step: *step, ends });
        let may_restart = restarts < most && self.solvers.may_restart(roles);
        if may_restart && in_vain {
            failure.message.push_str(&format!(
                "; this has happened {ENOUGH} times in a row at step {step}, so that it is not started again; look for the cause \
                 in its log"
            ));
        }
        failure.message.push_str(&last_words);
        (may_restart && !in_vain).then(|| (roles.clone(), failure.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss(role: Role, step: u64, end: &str) -> Loss {
        Loss { roles: vec![role], step, ends: vec![(role, end.into())] }
    }

    #[test]
    fn three_equal_losses_in_a_row_are_enough() {
        let same = loss(Role::Solid, 100, "exit status: 3");
        let added = |losses: &[Loss]| {
            let mut all = Losses::default();
            losses.iter().map(|loss| all.add(loss.clone())).collect::<Vec<_>>()
        };
        assert_eq!(added(&[same.clone(), same.clone(), same.clone()]), [false, false, true]);
        // The neighbouring step is the same end; any other difference is not.
        let beside = loss(Role::Solid, 101, "exit status: 3");
        assert_eq!(added(&[same.clone(), beside, same.clone()]), [false, false, true]);
        for other in [
            loss(Role::Solid, 102, "exit status: 3"),
            loss(Role::Fluid, 100, "exit status: 3"),
            loss(Role::Solid, 100, "signal: 9 (SIGKILL)"),
        ] {
            let mixed = [same.clone(), other, same.clone(), same.clone(), same.clone()];
            assert_eq!(added(&mixed), [false, false, false, false, true]);
        }
    }
}
