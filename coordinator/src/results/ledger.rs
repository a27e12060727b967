//! `ledger.csv`: what crossed the interface, what else changed each side's momentum, and whether it balances.
//!
//! A row stands for all steps since the row before it. Imbalances and residuals are the worst of these steps, so that
//! no half-step escapes, iterations the most of a half-step (0 where none is iterated); forces, torques and power are
//! those of the last corrector pass; impulses and work are sums over all accepted corrector passes since the start. So
//! `momentum_change = interface_impulse + Σ account impulses` holds in every row, check (b), and
//! `fluid_interface_impulse = −solid_interface_impulse`, check (a). The same holds of angular momentum and angular
//! impulses; these columns are NaN where a side has no such budget: in a periodic domain, and of solvers that report none.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sph::driver::StepReport;
use sph::ledger::{Account, Imbalance, StageBooks, TorqueAccount};
use sph::solver::Role;
use sph::stage::{Stage, StepStage};
use sph::vector::Vector;

use super::error::OutputError;
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

/// Columns of a side after the accounts of its angular momentum.
const ENERGIES: [&str; 3] = ["kinetic_energy_j_per_m", "potential_energy_j_per_m", "internal_energy_j_per_m"];

/// Column names of `ledger.csv` for the sides that take part.
pub fn columns(sides: &[Role]) -> Vec<String> {
    let mut names: Vec<String> = COMMON.map(String::from).into();
    for side in sides {
        names.extend(INTERFACE.iter().map(|name| format!("{side}_{name}")));
        for account in Account::ALL {
            names
                .extend(["x", "y"].map(|axis| format!("{side}_{}_impulse_{axis}_n_s_per_m", account.name())));
        }
        names.extend(ANGULAR.iter().map(|name| format!("{side}_{name}")));
        names.extend(
            TorqueAccount::ALL.map(|account| format!("{side}_{}_angular_impulse_n_s", account.name())),
        );
        names.extend(ENERGIES.iter().map(|name| format!("{side}_{name}")));
    }
    names
}

/// The largest value of a check and the half-step where it occurred; NaN is larger than everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Largest {
    /// The value \[-\].
    pub value: f64,
    /// Where; `None` when every value was zero.
    pub at: Option<StepStage>,
}

impl Largest {
    /// Takes `value` when it is larger.
    pub fn take(&mut self, value: f64, at: StepStage) {
        if value > self.value || (value.is_nan() && !self.value.is_nan()) {
            *self = Self { value, at: Some(at) };
        }
    }
}

/// Largest relative imbalances and residuals of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extremes {
    /// Force, check (a).
    pub force: Largest,
    /// Torque, check (a).
    pub torque: Largest,
    /// Momentum of the fluid and of the solid, check (b).
    pub momentum: [Largest; 2],
    /// Angular momentum of the fluid and of the solid, check (b); `None` for a side that reports no budget.
    pub angular: [Option<Largest>; 2],
}

/// Energy that crossed the interface since the start \[J/m\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Work that the fluid and the solid received.
    pub received: [f64; 2],
    /// Sum of |power| over time of the side where it is larger, which no to and fro cancels.
    pub passed: f64,
}

impl Work {
    /// What one side gave and the other did not receive: lost in viscosity and repulsion between them, and in squeezing
    /// the water at the face.
    pub fn drift(&self) -> f64 {
        self.received[0] + self.received[1]
    }
}

/// Sums of one side over the accepted corrector passes.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct SideSums {
    impulse: Vector,
    work: f64,
    /// Sum of |power| over time.
    passed: f64,
    momentum_change: Vector,
    accounts: [Vector; Account::ALL.len()],
    /// Worst residual since the last row.
    residual: Largest,
    angular: AngularSums,
}

/// Sums of the angular momentum of one side; NaN where it has no budget.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct AngularSums {
    impulse: f64,
    change: f64,
    accounts: [f64; TorqueAccount::ALL.len()],
    /// Worst residual since the last row.
    residual: Largest,
}

impl AngularSums {
    /// Adds an accepted corrector pass.
    fn add(&mut self, stage: &StageBooks) {
        let Some(budget) = &stage.angular else {
            (self.impulse, self.change) = (f64::NAN, f64::NAN);
            self.accounts = [f64::NAN; TorqueAccount::ALL.len()];
            return;
        };
        self.impulse += stage.duration * stage.interface.torque;
        self.change += budget.change;
        for (sum, account) in self.accounts.iter_mut().zip(TorqueAccount::ALL) {
            *sum += stage.duration * budget.torques.get(account);
        }
    }
}

/// What the ledger has summed up, for a checkpoint.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LedgerSums {
    sides: [SideSums; 2],
    /// Worst imbalances since the last row: force, torque.
    since_row: [Largest; 2],
    /// Most iterations of a half-step since the last row.
    most_iterations: u32,
    extremes: Extremes,
    /// Reports of the last step, not yet in a row.
    pending: Option<[Option<StepReport>; 2]>,
}

/// Writer of `ledger.csv`.
pub struct LedgerFile {
    file: TableFile,
    sides: Vec<Role>,
    sums: LedgerSums,
    row: Vec<f64>,
}

impl LedgerFile {
    /// Starts the file for the sides that take part.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: &Path, sides: &[Role]) -> Result<Self, OutputError> {
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
        sides: &[Role],
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
            for (budget, stage) in report.books.iter().zip(Stage::BOTH) {
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
            let [_, corrector] = &report.books;
            sums.impulse += corrector.duration * corrector.interface.force;
            let work = corrector.duration * corrector.interface.power;
            sums.work += work;
            sums.passed += work.abs();
            sums.momentum_change += corrector.momentum_change;
            sums.angular.add(corrector);
            for (sum, account) in sums.accounts.iter_mut().zip(Account::ALL) {
                *sum += corrector.duration * corrector.accounts.get(account);
            }
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
            let k = side.index();
            match &reports[k] {
                Some(report) => push_side(&mut self.row, report, &self.sums.sides[k]),
                None => self.row.extend(std::iter::repeat_n(f64::NAN, side_width())),
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

    /// Writes the last steps and gives the file its final name.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(mut self) -> Result<PathBuf, OutputError> {
        self.write_row()?;
        self.file.finish()
    }
}

fn side_width() -> usize {
    INTERFACE.len() + 2 * Account::ALL.len() + ANGULAR.len() + TorqueAccount::ALL.len() + ENERGIES.len()
}

/// Values in the order of [`INTERFACE`], accounts, [`ANGULAR`], their accounts, [`ENERGIES`].
fn push_side(row: &mut Vec<f64>, report: &StepReport, sums: &SideSums) {
    let interface = &report.books[1].interface;
    row.extend([
        interface.force.x,
        interface.force.y,
        interface.gross_force,
        interface.torque,
        interface.gross_torque,
        interface.couple,
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
    row.extend(sums.accounts.iter().flat_map(|impulse| [impulse.x, impulse.y]));
    let angular = &sums.angular;
    row.extend([angular.impulse, angular.change, angular.residual.value]);
    row.extend(angular.accounts);
    row.extend([report.energies.kinetic, report.energies.potential, report.energies.internal]);
}

#[cfg(test)]
mod tests {
    use sph::ledger::{Accounts, AngularBudget, Energies, InterfaceSums, Torques};

    use super::*;
    use crate::results::table::Table;

    /// A step of 0.1 s under an interface force and gravity, whose budget balances; torques are the x-components.
    fn report(step: u64, force: Vector, weight: Vector) -> StepReport {
        let budget = |duration: f64| {
            let mut accounts = Accounts::default();
            accounts.add(Account::BodyForce, weight);
            let mut torques = Torques::default();
            torques.add(TorqueAccount::BodyForce, weight.y);
            StageBooks {
                interface: InterfaceSums {
                    force,
                    torque: force.x,
                    gross_force: 9.0,
                    power: 2.0,
                    pairs: 7,
                    ..Default::default()
                },
                accounts,
                duration,
                momentum_change: duration * (force + weight),
                gross_momentum: 10.0,
                angular: Some(AngularBudget {
                    torques,
                    change: duration * (force.x + weight.y),
                    gross: 10.0,
                }),
            }
        };
        StepReport {
            step,
            end_time: 0.1 * (step + 1) as f64,
            time_step: 0.1,
            books: [budget(0.05), budget(0.1)],
            energies: Energies { kinetic: 1.5, potential: 2.5, internal: 3.5 },
            ..StepReport::default()
        }
    }

    fn imbalance(force: f64) -> Imbalance {
        Imbalance { force, torque: 0.5 * force }
    }

    #[test]
    fn rows_hold_the_worst_imbalance_and_the_impulse_of_all_steps() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("ledger.csv");
        let mut file = LedgerFile::create(&path, &[Role::Fluid, Role::Solid]).unwrap();
        let (force, weight) = (Vector::new(3.0, -1.0), Vector::new(0.0, -9.81));
        for step in 0..5 {
            let worst = if step == 1 { 4e-14 } else { 1e-15 };
            let (mut fluid, mut solid) = (report(step, force, weight), report(step, -force, weight));
            fluid.iterations = 7 - step as u32;
            if step > 0 {
                solid.books[1].interface.power *= -1.0;
            }
            file.record(Some(&fluid), Some(&solid), &[imbalance(worst), imbalance(2e-15)]);
            if step == 2 {
                file.write_row().unwrap();
                file.write_row().unwrap();
            }
        }
        let extremes = *file.extremes();
        assert_eq!(extremes.force.value, 4e-14);
        assert_eq!(extremes.torque.at, Some(StepStage { step: 1, stage: Stage::Predictor }));
        assert!(extremes.angular.iter().all(|largest| largest.is_some_and(|largest| largest.value < 1e-15)));
        // Five correctors of 0.1 s at 2 W/m on the fluid, four of them given by the solid and one received.
        let work = file.work();
        assert!((work.received[0] - 1.0).abs() < 1e-14 && (work.received[1] + 0.6).abs() < 1e-14);
        assert!((work.passed - 1.0).abs() < 1e-14 && (work.drift() - 0.4).abs() < 1e-14);
        file.finish().unwrap();

        let table = Table::read(&path).unwrap();
        let column = |name: &str| table.column(name).unwrap_or_else(|| panic!("no column {name}"));
        assert_eq!(column("step"), [3.0, 5.0]);
        assert_eq!(column("imbalance_force"), [4e-14, 2e-15]);
        assert_eq!(column("most_iterations"), [7.0, 4.0]);
        assert_eq!(column("fluid_pairs"), [7.0, 7.0]);
        assert_eq!(column("solid_internal_energy_j_per_m"), [3.5, 3.5]);
        for axis in ["x", "y"] {
            let fluid = column(&format!("fluid_interface_impulse_{axis}_n_s_per_m"));
            let solid = column(&format!("solid_interface_impulse_{axis}_n_s_per_m"));
            assert!(fluid.iter().zip(&solid).all(|(f, s)| f + s == 0.0));
            let change = column(&format!("fluid_momentum_change_{axis}_n_s_per_m"));
            let weight = column(&format!("fluid_body_force_impulse_{axis}_n_s_per_m"));
            for k in 0..2 {
                // Sums of five numbers of order one.
                assert!((change[k] - fluid[k] - weight[k]).abs() < 1e-14);
            }
        }
        let change = column("fluid_angular_momentum_change_n_s");
        let impulse = column("fluid_interface_angular_impulse_n_s");
        let weight = column("fluid_body_force_angular_impulse_n_s");
        assert!((change[1] - impulse[1] - weight[1]).abs() < 1e-14 && impulse[1] > 1.0);
        assert!(column("solid_angular_momentum_residual").iter().all(|residual| *residual < 1e-15));
        // Five corrector passes of 0.1 s; the predictor's are not accepted.
        assert!((column("fluid_interface_impulse_x_n_s_per_m")[1] - 1.5).abs() < 1e-14);
        assert!((column("fluid_interface_work_j_per_m")[1] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_residual_that_is_no_number_is_the_largest() {
        let mut largest = Largest::default();
        for (step, value) in [1e-14, f64::NAN, 1.0].into_iter().enumerate() {
            largest.take(value, StepStage { step: step as u64, stage: Stage::Corrector });
        }
        assert!(largest.value.is_nan());
        assert_eq!(largest.at.map(|at| at.step), Some(1));
    }

    #[test]
    fn one_side_alone_has_its_own_columns_only() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("ledger.csv");
        let mut file = LedgerFile::create(&path, &[Role::Solid]).unwrap();
        let mut report = report(0, Vector::zeros(), Vector::zeros());
        report.books.iter_mut().for_each(|budget| budget.angular = None);
        file.record(None, Some(&report), &[Imbalance::default(); 2]);
        assert_eq!(file.extremes().angular, [None; 2]);
        file.finish().unwrap();
        let table = Table::read(&path).unwrap();
        assert_eq!(table.columns().len(), COMMON.len() + side_width());
        assert!(table.columns().iter().all(|name| !name.starts_with("fluid")));
        assert_eq!(table.rows(), 1);
        assert!(table.column("solid_angular_momentum_change_n_s").unwrap()[0].is_nan());
    }
}
