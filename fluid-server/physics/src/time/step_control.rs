//! Notices a step that is too long for what the water does.
//!
//! The stability limit is that of particles in order. Next to a void that closes, clumps and thin sheets vibrate up to 1.6 times
//! as fast. Beyond their own limit the pressure there alternates from step to step and doubles each time, and with it the
//! change of the residual of energy, long before the energy itself matters.

use serde::{Deserialize, Serialize};
use sph::coupling::ledger::EnergyReport;
use sph::coupling::saved::{RestoreError, SavedState};

sph::constants! {
    /// Steps that are stable alternate too, by amounts that stay alike.
    const GROWTH: f64 = 1.2, "time_step.control.growth",
        "ratio of the changes of the residual of energy in two steps, of opposite sign, that counts as growth [-]";
    /// Two happen by chance.
    const GROWTHS: u32 = 3, "time_step.control.growths",
        "steps of growth in a row that shorten the steps to come [-]";
    /// A ten-thousandth of what the quality figures allow in all, and above round-off.
    const LEAST_CHANGE: f64 = 1e-7, "time_step.control.least_change",
        "change of the residual in a step that counts, over the energy that was there to be spent [-]";
    /// The fastest clump that was found, at 1.6 times the frequency of a lattice, is stable at 0.7 of the limit and not at 0.8.
    const SHORTENING: f64 = 0.8, "time_step.control.shortening",
        "factor by which steps become shorter [-]";
    /// Back in 45 steps. Where the water is as stiff then as before, the growth is noticed again before it matters.
    const RECOVERY: f64 = 1.005, "time_step.control.recovery",
        "factor by which the limit recovers in a step [-]";
    /// Beyond, something else is wrong, which the residual then shows.
    const LEAST_SHARE: f64 = 0.4, "time_step.control.least_share",
        "least share of its limit to which a step is shortened [-]";
}

/// What the steps so far say of the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepControl {
    /// Residual of energy at the last step boundary \[J\].
    residual: f64,
    /// Its change in the last step \[J\].
    change: f64,
    /// Largest [`EnergyReport::scale`] so far \[J\].
    scale: f64,
    /// Steps of growth in a row.
    growths: u32,
    /// Share of the stability limit \[-\].
    share: f64,
}

impl Default for StepControl {
    fn default() -> Self {
        Self { residual: 0.0, change: 0.0, scale: 0.0, growths: 0, share: 1.0 }
    }
}

impl StepControl {
    /// Share of its stability limit that the next step may take \[-\].
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Takes the energies at the end of a step.
    pub fn take(&mut self, report: &EnergyReport) {
        let Some(residual) = report.residual() else { return };
        let (change, last) = (residual - self.residual, self.change);
        self.scale = self.scale.max(report.scale());
        let grows = change * last < 0.0
            && change.abs() > GROWTH * last.abs()
            && change.abs() > LEAST_CHANGE * self.scale;
        (self.residual, self.change) = (residual, change);
        self.growths = if grows { self.growths + 1 } else { 0 };
        self.share = (self.share * RECOVERY).min(1.0);
        if self.growths >= GROWTHS {
            self.growths = 0;
            self.share = (self.share * SHORTENING).max(LEAST_SHARE);
        }
    }

    /// Saves it as the array `name`, unless it is that of the start: a checkpoint of before there was one stays what it is.
    pub fn save(&self, name: &str, saved: &mut SavedState) {
        if *self == Self::default() {
            return;
        }
        let Self { residual, change, scale, growths, share } = *self;
        saved.put_f64(name, [residual, change, scale, growths.into(), share]);
    }

    /// The control that was saved as `name`, or that of the start.
    ///
    /// # Errors
    /// When the array has another length or the share is none.
    pub fn restored(name: &str, saved: &SavedState) -> Result<Self, RestoreError> {
        if !saved.has(name) {
            return Ok(Self::default());
        }
        let [residual, change, scale, growths, share] = saved.numbers(name)?;
        if !(LEAST_SHARE..=1.0).contains(&share) {
            let problem = format!("holds a share of {share}, must lie between {LEAST_SHARE} and 1");
            return Err(RestoreError::new(name, problem));
        }
        // Fewer than `GROWTHS`.
        let growths = if growths > 0.0 { growths as u32 } else { 0 };
        Ok(Self { residual, change, scale, growths, share })
    }
}

#[cfg(test)]
mod tests {
    use sph::coupling::ledger::{EnergyAccount, EnergyEntry};

    use super::*;

    /// A report of 1 J that was there, and a `residual` \[J\].
    fn report(residual: f64) -> EnergyReport {
        let mut report = EnergyReport::default();
        report.set(EnergyAccount::Kinetic, EnergyEntry { value: 1.0 + residual, start: 1.0 });
        report.set(EnergyAccount::Interface, EnergyEntry { value: 0.0, start: 0.0 });
        report
    }

    /// The control after steps whose changes of the residual are `changes` \[J\].
    fn after(changes: &[f64]) -> StepControl {
        let (mut control, mut residual) = (StepControl::default(), 0.0);
        for change in changes {
            residual += change;
            control.take(&report(residual));
        }
        control
    }

    #[test]
    fn a_residual_that_alternates_and_doubles_shortens_the_step_until_it_has_calmed() {
        let mut control = after(&[1e-7, -2e-7, 4e-7]);
        assert_eq!(control.share(), 1.0);
        control = after(&[1e-7, -2e-7, 4e-7, -8e-7]);
        assert_eq!(control.share(), SHORTENING);
        let residual = 1e-7 - 2e-7 + 4e-7 - 8e-7;
        for _ in 0..44 {
            control.take(&report(residual));
        }
        assert!(control.share() < 1.0);
        control.take(&report(residual));
        assert_eq!(control.share(), 1.0);
    }

    #[test]
    fn growth_to_one_side_swings_that_stay_alike_and_round_off_shorten_nothing() {
        // An impact, a stable oscillation, and an unstable one far below what matters.
        for changes in [[1e-7, 2e-7, 4e-7, 8e-7], [1e-6, -1e-6, 1e-6, -1e-6], [1e-10, -2e-10, 4e-10, -8e-10]]
        {
            assert_eq!(after(&changes).share(), 1.0, "{changes:?}");
        }
    }

    #[test]
    fn what_never_calms_stops_at_the_least_share() {
        let changes: Vec<f64> = (0..40).map(|k| 1e-7 * (-1.5f64).powi(k)).collect();
        assert_eq!(after(&changes).share(), LEAST_SHARE);
    }

    #[test]
    fn a_saved_control_goes_its_way_and_a_checkpoint_without_one_starts_it() -> Result<(), RestoreError> {
        let control = after(&[1e-7, -2e-7, 4e-7, -8e-7, 1.6e-6]);
        let mut saved = SavedState::default();
        StepControl::default().save("control", &mut saved);
        assert!(!saved.has("control"));
        assert_eq!(StepControl::restored("control", &saved)?, StepControl::default());
        control.save("control", &mut saved);
        assert_eq!(StepControl::restored("control", &saved)?, control);
        let mut wrong = SavedState::default();
        StepControl { share: 0.0, ..control }.save("control", &mut wrong);
        assert!(StepControl::restored("control", &wrong).is_err());
        Ok(())
    }
}
