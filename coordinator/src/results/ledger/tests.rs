use sph::coupling::ledger::{
    Accounts, AngularBudget, EnergyEntry, EnergyReport, InterfaceSums, LedgerVector, StageBudget, axial,
};

use super::*;
use crate::results::energy::EnergySummary;
use crate::results::table::Table;

/// A step of 0.1 s under an interface force and gravity, whose budget balances; torques are the x-components.
fn report(step: u64, force: LedgerVector, weight: LedgerVector) -> StepReport {
    let budget = |duration: f64| {
        let mut accounts = Accounts::default();
        accounts.add_force(Account::BodyForce, weight);
        accounts.add_torque(Account::BodyForce, axial(weight.y));
        StageBudget {
            interface: InterfaceSums {
                force,
                torque: axial(force.x),
                gross_force: 9.0,
                power: 2.0,
                pairs: 7,
                ..Default::default()
            },
            accounts,
            duration,
            momentum_change: duration * (force + weight),
            gross_momentum: 10.0,
            angular: Some(AngularBudget { change: axial(duration * (force.x + weight.y)), gross: 10.0 }),
        }
    };
    let mut energies = EnergyReport::default();
    energies.set(EnergyAccount::Kinetic, EnergyEntry { value: 1.5, start: 0.5 });
    energies.set(EnergyAccount::Walls, EnergyEntry { value: 1.25, start: 0.0 });
    StepReport {
        step,
        end_time: 0.1 * (step + 1) as f64,
        time_step: 0.1,
        budgets: [budget(0.05), budget(0.1)],
        energies,
        ..StepReport::default()
    }
}

/// A side whose case could also have strain.
fn side(role: Role) -> LedgerSide {
    LedgerSide {
        role,
        dimensions: 2,
        accounts: vec![EnergyAccount::Kinetic, EnergyAccount::Strain, EnergyAccount::Walls],
    }
}

fn imbalance(force: f64) -> Imbalance {
    Imbalance { force, torque: 0.5 * force }
}

#[test]
fn rows_hold_the_worst_imbalance_and_the_impulse_of_all_steps() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("ledger.csv");
    let mut file = LedgerFile::create(&path, &[side(Role::Fluid), side(Role::Solid)]).unwrap();
    let (force, weight) = (LedgerVector::new(3.0, -1.0, 0.0), LedgerVector::new(0.0, -9.81, 0.0));
    for step in 0..5 {
        let worst = if step == 1 { 4e-14 } else { 1e-15 };
        let (mut fluid, mut solid) = (report(step, force, weight), report(step, -force, weight));
        fluid.iterations = 7 - step as u32;
        if step > 0 {
            solid.budgets[1].interface.power *= -1.0;
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
    let energy = EnergySummary::new(&file.energy());
    file.finish().unwrap();

    let table = Table::read(&path).unwrap();
    let column = |name: &str| table.column(name).unwrap_or_else(|| panic!("no column {name}"));
    assert_eq!(column("step"), [3.0, 5.0]);
    assert_eq!(column("imbalance_force"), [4e-14, 2e-15]);
    assert_eq!(column("most_iterations"), [7.0, 4.0]);
    assert_eq!(column("fluid_pairs"), [7.0, 7.0]);
    assert_eq!(column("solid_energy_kinetic_j_per_m"), [1.5, 1.5]);
    assert_eq!(column("fluid_energy_walls_j_per_m"), [1.25, 1.25]);
    assert_eq!(column("fluid_energy_residual_j_per_m"), [-0.25, -0.25]);
    assert!(column("fluid_energy_strain_j_per_m").iter().all(|value| value.is_nan()));
    assert!(energy.fluid.is_some_and(|fluid| fluid.residual_share == Some(0.25 / 1.25)));
    assert!((energy.residual_share.unwrap() - 0.5 / 1.25).abs() < 1e-15);
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
    let mut file = LedgerFile::create(&path, &[side(Role::Solid)]).unwrap();
    let mut report = report(0, LedgerVector::zeros(), LedgerVector::zeros());
    report.budgets.iter_mut().for_each(|budget| budget.angular = None);
    file.record(None, Some(&report), &[Imbalance::default(); 2]);
    assert_eq!(file.extremes().angular, [None; 2]);
    file.finish().unwrap();
    let table = Table::read(&path).unwrap();
    assert_eq!(table.columns().len(), columns(&[side(Role::Solid)]).len());
    assert!(table.columns().iter().all(|name| !name.starts_with("fluid")));
    assert_eq!(table.rows(), 1);
    assert!(table.column("solid_angular_momentum_change_n_s").unwrap()[0].is_nan());
}

#[test]
fn in_space_vectors_have_three_components_and_units_are_not_per_metre() {
    let side = LedgerSide { dimensions: 3, ..side(Role::Solid) };
    let names = columns(std::slice::from_ref(&side));
    for name in [
        "solid_force_z_n",
        "solid_torque_x_n_m",
        "solid_interface_impulse_z_n_s",
        "solid_body_force_angular_impulse_y_n_m_s",
        "solid_energy_kinetic_j",
    ] {
        assert!(names.iter().any(|known| known == name), "{name} is not in {names:?}");
    }
    assert!(!names.iter().any(|name| name.ends_with("_per_m")));
    let root = tempfile::tempdir().unwrap();
    let mut file = LedgerFile::create(&root.path().join("ledger.csv"), &[side]).unwrap();
    let step = report(0, LedgerVector::new(1.0, 2.0, 3.0), LedgerVector::new(0.0, -1.0, -4.0));
    file.record(None, Some(&step), &[imbalance(0.0); 2]);
    let table = Table::read(&file.finish().unwrap()).unwrap();
    let value = |name: &str| table.column(name).unwrap()[0];
    assert_eq!(["x", "y", "z"].map(|axis| value(&format!("solid_force_{axis}_n"))), [1.0, 2.0, 3.0]);
    // The torque of the report is about z, that of its force's x.
    assert_eq!(["x", "y", "z"].map(|axis| value(&format!("solid_torque_{axis}_n_m"))), [0.0, 0.0, 1.0]);
    let [impulse, weight, change] = ["interface_impulse", "body_force_impulse", "momentum_change"]
        .map(|name| value(&format!("solid_{name}_z_n_s")));
    assert!((impulse + weight - change).abs() < 1e-12, "{impulse} + {weight} is not {change}");
}
