//! `ledger.csv`: what crossed the interface, what else changed each side's momentum, and whether it balances.
//!
//! A row stands for all steps since the row before it. Imbalances and residuals are the worst of these steps, so that
//! no half-step escapes, iterations the most of a half-step (0 where none is iterated); forces, torques and power are
//! those of the last corrector pass; impulses and work are sums over all accepted corrector passes since the start. So
//! `momentum_change = interface_impulse + Σ account impulses` holds in every row, check (b), and
//! `fluid_interface_impulse = −solid_interface_impulse`, check (a). The same holds of angular momentum and angular
//! impulses; these columns are NaN where a side has no such budget: in a periodic domain, and of solvers that report none.
//! Energies are those of the end of the last step: stores as they are, works and losses since the start of the run.

use std::path::{Path, PathBuf};

use sph::coupling::driver::StepReport;
use sph::coupling::ledger::{Account, EnergyAccount, Imbalance};
use sph::coupling::solver::Role;
use sph::coupling::stage::{Stage, StepStage};

use super::energy::{LedgerSide, SideEnergy};
use super::error::OutputError;
use super::ledger_sums::{Extremes, Largest, LedgerSums, SideSums, Work};
use super::table::{Changed, Resumed, TableFile, TableMark};

/// Columns before those of the sides.
const COMMON: [&str; 6] =
    ["step", "t_s", "time_step_s", "imbalance_force", "imbalance_torque", "most_iterations"];

/// Columns of a side before its accounts.
const INTERFACE: [&str; 14] = [
    "force_x_n_per_m",
    "force_y_n_per_m",
    "gross_force_n_per_m",
    "torque_n",
    "gross_torque_n",
    "couple_n",
    "power_w_per_m",
    "pairs",
    "interface_impulse_x_n_s_per_m",
    "interface_impulse_y_n_s_per_m",
    "interface_work_j_per_m",
    "momentum_change_x_n_s_per_m",
    "momentum_change_y_n_s_per_m",
    "momentum_residual",
];

/// Columns of a side after the accounts of its momentum.
const ANGULAR: [&str; 3] =
    ["interface_angular_impulse_n_s", "angular_momentum_change_n_s", "angular_momentum_residual"];

/// Name of the column of an `account` of the energy of `side`.
pub fn energy_column(side: Role, account: EnergyAccount) -> String {
    format!("{side}_energy_{}_j_per_m", account.name())
}

/// Name of the column of the residual of the energy of `side`.
pub fn energy_residual_column(side: Role) -> String {
    format!("{side}_energy_residual_j_per_m")
}

/// Column names of `ledger.csv` for the sides that take part.
pub fn columns(sides: &[LedgerSide]) -> Vec<String> {
    let mut names: Vec<String> = COMMON.map(String::from).into();
    for LedgerSide { role: side, accounts } in sides {
        names.extend(INTERFACE.iter().map(|name| format!("{side}_{name}")));
        for account in Account::with_force() {
            names
                .extend(["x", "y"].map(|axis| format!("{side}_{}_impulse_{axis}_n_s_per_m", account.name())));
        }
        names.extend(ANGULAR.iter().map(|name| format!("{side}_{name}")));
        names.extend(Account::ALL.map(|account| format!("{side}_{}_angular_impulse_n_s", account.name())));
        names.extend(accounts.iter().map(|account| energy_column(*side, *account)));
        names.push(energy_residual_column(*side));
    }
    names
}

/// Writer of `ledger.csv`.
pub struct LedgerFile {
    file: TableFile,
    sides: Vec<LedgerSide>,
    sums: LedgerSums,
    row: Vec<f64>,
}

impl LedgerFile {
    /// Starts the file for the sides that take part.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path, sides: &[LedgerSide]) -> Result<Self, OutputError> {
        let file = TableFile::create(path, &columns(sides))?;
        Ok(Self { file, sides: sides.to_vec(), sums: LedgerSums::default(), row: Vec::new() })
    }

    /// Continues the file of an earlier run from what it held at `mark`, with what it had summed up then; and what must be
    /// said of it.
    ///
    /// # Errors
    /// As [`TableFile::resume`].
    pub fn resume(
        path: &Path,
        sides: &[LedgerSide],
        mark: &TableMark,
        sums: LedgerSums,
        changed: Changed,
    ) -> Result<(Self, Option<String>), OutputError> {
        let Resumed { file, warning } = TableFile::resume(path, &columns(sides), mark, changed)?;
        Ok((Self { file, sides: sides.to_vec(), sums, row: Vec::new() }, warning))
    }

    /// The file.
    pub fn file(&self) -> &TableFile {
        &self.file
    }

    /// What it has summed up.
    pub fn sums(&self) -> &LedgerSums {
        &self.sums
    }

    /// Accounts for a completed step; `imbalance` is that of predictor and corrector.
    pub fn record(
        &mut self,
        fluid: Option<&StepReport>,
        solid: Option<&StepReport>,
        imbalance: &[Imbalance; 2],
    ) {
        let reports = [fluid, solid];
        let Some(step) = reports.iter().flatten().map(|report| report.step).next() else { return };
        for (imbalance, stage) in imbalance.iter().zip(Stage::BOTH) {
            let at = StepStage { step, stage };
            for largest in [&mut self.sums.since_row[0], &mut self.sums.extremes.force] {
                largest.take(imbalance.force, at);
            }
            for largest in [&mut self.sums.since_row[1], &mut self.sums.extremes.torque] {
                largest.take(imbalance.torque, at);
            }
        }
        for (k, report) in reports.into_iter().enumerate() {
            let Some(report) = report else { continue };
            let LedgerSums { sides, extremes, most_iterations, .. } = &mut self.sums;
            *most_iterations = report.iterations.max(*most_iterations);
            let sums = &mut sides[k];
            for (budget, stage) in report.budgets.iter().zip(Stage::BOTH) {
                let residual = budget.momentum_residual();
                for largest in [&mut sums.residual, &mut extremes.momentum[k]] {
                    largest.take(residual, StepStage { step, stage });
                }
                if budget.angular.is_some() {
                    let residual = budget.angular_residual();
                    let extreme = extremes.angular[k].get_or_insert_default();
                    for largest in [&mut sums.angular.residual, extreme] {
                        largest.take(residual, StepStage { step, stage });
                    }
                }
            }
            let [_, corrector] = &report.budgets;
            sums.add(corrector);
            sums.energy.take(&report.energies);
        }
        self.sums.pending = Some([fluid.copied(), solid.copied()]);
    }

    /// Writes a row for the steps since the last one; none when there are none.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write_row(&mut self) -> Result<(), OutputError> {
        let Some(reports) = self.sums.pending.take() else { return Ok(()) };
        let Some(any) = reports.iter().flatten().next() else { return Ok(()) };
        self.row.clear();
        // Exact: step counts stay far below 2^53.
        let completed = (any.step + 1) as f64;
        self.row.extend([completed, any.end_time, any.time_step]);
        self.row.extend(self.sums.since_row.map(|largest| largest.value));
        self.row.push(self.sums.most_iterations.into());
        for side in &self.sides {
            let k = side.role.index();
            match &reports[k] {
                Some(report) => push_side(&mut self.row, report, &self.sums.sides[k], &side.accounts),
                None => self.row.extend(std::iter::repeat_n(f64::NAN, side_width(side))),
            }
            self.sums.sides[k].residual = Largest::default();
            self.sums.sides[k].angular.residual = Largest::default();
        }
        self.sums.since_row = [Largest::default(); 2];
        self.sums.most_iterations = 0;
        self.file.push(&self.row)
    }

    /// Largest imbalances and residuals so far.
    pub fn extremes(&self) -> &Extremes {
        &self.sums.extremes
    }

    /// Energy that has crossed the interface so far.
    pub fn work(&self) -> Work {
        let [fluid, solid] = &self.sums.sides;
        Work { received: [fluid.work, solid.work], passed: fluid.passed.max(solid.passed) }
    }

    /// Energy of both sides.
    pub fn energy(&self) -> [SideEnergy; 2] {
        let [fluid, solid] = &self.sums.sides;
        [fluid.energy, solid.energy]
    }

    /// Writes the last steps and gives the file its final name.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(mut self) -> Result<PathBuf, OutputError> {
        self.write_row()?;
        self.file.finish()
    }
}

fn side_width(side: &LedgerSide) -> usize {
    let momentum = INTERFACE.len() + 2 * Account::with_force().count();
    momentum + ANGULAR.len() + Account::ALL.len() + side.accounts.len() + 1
}

/// Values in the order of [`INTERFACE`], accounts, [`ANGULAR`], their accounts, accounts of `energy` and its residual.
fn push_side(row: &mut Vec<f64>, report: &StepReport, sums: &SideSums, energy: &[EnergyAccount]) {
    let interface = &report.budgets[1].interface;
    row.extend([
        interface.force.x,
        interface.force.y,
        interface.gross_force,
        interface.torque.z,
        interface.gross_torque,
        interface.couple.z,
        interface.power,
        // Exact: pair counts stay far below 2^53.
        interface.pairs as f64,
        sums.impulse.x,
        sums.impulse.y,
        sums.work,
        sums.momentum_change.x,
        sums.momentum_change.y,
        sums.residual.value,
    ]);
    let impulses = Account::with_force().map(|account| sums.accounts.get(account).force);
    row.extend(impulses.flat_map(|impulse| [impulse.x, impulse.y]));
    let angular = &sums.angular;
    row.extend([angular.impulse.z, angular.change.z, angular.residual.value]);
    row.extend(Account::ALL.map(|account| sums.accounts.get(account).torque.z));
    let energies = &report.energies;
    let value = |account: &EnergyAccount| energies.get(*account).map_or(f64::NAN, |entry| entry.value);
    row.extend(energy.iter().map(value));
    row.push(energies.residual().unwrap_or(f64::NAN));
}

#[cfg(test)]
mod tests;
