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
use sph::coupling::ledger::{Account, EnergyAccount, Imbalance, LedgerVector};
use sph::coupling::solver::Role;
use sph::coupling::stage::{Stage, StepStage};

use super::energy::{LedgerSide, SideEnergy};
use super::error::OutputError;
use super::ledger_sums::{Extremes, Largest, LedgerSums, SideSums, Work};
use super::table::{Changed, Resumed, TableFile, TableMark};

/// Columns before those of the sides.
const COMMON: [&str; 6] =
    ["step", "t_s", "time_step_s", "imbalance_force", "imbalance_torque", "most_iterations"];

/// Names and values of the columns of one side; in the plane vectors have x and y, moments are about z, and all are per metre of depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layout {
    in_space: bool,
}

impl Layout {
    fn of(dimensions: usize) -> Self {
        Self { in_space: dimensions > 2 }
    }

    /// `unit` in space, `unit` per metre in the plane.
    fn per_depth(self, unit: &str) -> String {
        if self.in_space { unit.to_owned() } else { format!("{unit}_per_m") }
    }

    /// Columns of a vector of `unit` in space.
    fn vector(self, stem: &str, unit: &str) -> Vec<String> {
        let axes = if self.in_space { &["x", "y", "z"][..] } else { &["x", "y"] };
        axes.iter().map(|axis| format!("{stem}_{axis}_{}", self.per_depth(unit))).collect()
    }

    /// Columns of a moment of `unit` in space, of `plane_unit` in the plane.
    fn moment(self, stem: &str, unit: &str, plane_unit: &str) -> Vec<String> {
        match self.in_space {
            true => ["x", "y", "z"].map(|axis| format!("{stem}_{axis}_{unit}")).into(),
            false => vec![format!("{stem}_{plane_unit}")],
        }
    }

    /// Columns of a side before its accounts.
    fn interface(self) -> Vec<String> {
        let gross_torque = if self.in_space { "gross_torque_n_m" } else { "gross_torque_n" };
        [
            self.vector("force", "n"),
            vec![format!("gross_force_{}", self.per_depth("n"))],
            self.moment("torque", "n_m", "n"),
            vec![gross_torque.to_owned()],
            self.moment("couple", "n_m", "n"),
            vec![format!("power_{}", self.per_depth("w")), "pairs".to_owned()],
            self.vector("interface_impulse", "n_s"),
            vec![format!("interface_work_{}", self.per_depth("j"))],
            self.vector("momentum_change", "n_s"),
            vec!["momentum_residual".to_owned()],
        ]
        .concat()
    }

    /// Columns of a side after the accounts of its momentum.
    fn angular(self) -> Vec<String> {
        [
            self.moment("interface_angular_impulse", "n_m_s", "n_s"),
            self.moment("angular_momentum_change", "n_m_s", "n_s"),
            vec!["angular_momentum_residual".to_owned()],
        ]
        .concat()
    }

    /// Appends the components of a vector.
    fn push_vector(self, row: &mut Vec<f64>, vector: &LedgerVector) {
        row.extend(vector.iter().take(if self.in_space { 3 } else { 2 }));
    }

    /// Appends the components of a moment.
    fn push_moment(self, row: &mut Vec<f64>, moment: &LedgerVector) {
        row.extend(moment.iter().skip(if self.in_space { 0 } else { 2 }));
    }
}

/// Name of the column of an `account` of the energy of `side` in a run of so many `dimensions`.
pub fn energy_column(side: Role, account: EnergyAccount, dimensions: usize) -> String {
    format!("{side}_energy_{}_{}", account.name(), Layout::of(dimensions).per_depth("j"))
}

/// Name of the column of the residual of the energy of `side`.
pub fn energy_residual_column(side: Role, dimensions: usize) -> String {
    format!("{side}_energy_residual_{}", Layout::of(dimensions).per_depth("j"))
}

/// Column names of `ledger.csv` for the sides that take part.
pub fn columns(sides: &[LedgerSide]) -> Vec<String> {
    let mut names: Vec<String> = COMMON.map(String::from).into();
    for LedgerSide { role: side, dimensions, accounts } in sides {
        let layout = Layout::of(*dimensions);
        let own = |name: String| format!("{side}_{name}");
        names.extend(layout.interface().into_iter().map(own));
        for account in Account::with_force() {
            names.extend(layout.vector(&format!("{side}_{}_impulse", account.name()), "n_s"));
        }
        names.extend(layout.angular().into_iter().map(own));
        for account in Account::ALL {
            let stem = format!("{side}_{}_angular_impulse", account.name());
            names.extend(layout.moment(&stem, "n_m_s", "n_s"));
        }
        names.extend(accounts.iter().map(|account| energy_column(*side, *account, *dimensions)));
        names.push(energy_residual_column(*side, *dimensions));
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
                Some(report) => push_side(&mut self.row, report, &self.sums.sides[k], side),
                None => {
                    let width = columns(std::slice::from_ref(side)).len() - COMMON.len();
                    self.row.extend(std::iter::repeat_n(f64::NAN, width));
                }
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

/// Values in the order of [`columns`].
fn push_side(row: &mut Vec<f64>, report: &StepReport, sums: &SideSums, side: &LedgerSide) {
    let (interface, layout) = (&report.budgets[1].interface, Layout::of(side.dimensions));
    layout.push_vector(row, &interface.force);
    row.push(interface.gross_force);
    layout.push_moment(row, &interface.torque);
    row.push(interface.gross_torque);
    layout.push_moment(row, &interface.couple);
    // Exact: pair counts stay far below 2^53.
    row.extend([interface.power, interface.pairs as f64]);
    layout.push_vector(row, &sums.impulse);
    row.push(sums.work);
    layout.push_vector(row, &sums.momentum_change);
    row.push(sums.residual.value);
    Account::with_force().for_each(|account| layout.push_vector(row, &sums.accounts.get(account).force));
    layout.push_moment(row, &sums.angular.impulse);
    layout.push_moment(row, &sums.angular.change);
    row.push(sums.angular.residual.value);
    Account::ALL.iter().for_each(|account| layout.push_moment(row, &sums.accounts.get(*account).torque));
    let energies = &report.energies;
    let value = |account: &EnergyAccount| energies.get(*account).map_or(f64::NAN, |entry| entry.value);
    row.extend(side.accounts.iter().map(value));
    row.push(energies.residual().unwrap_or(f64::NAN));
}

#[cfg(test)]
mod tests;
