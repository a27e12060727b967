//! Whole runs in space: a rigid ball and an elastic beam in water, in every way of running that must not matter.

use crate::bench;
use tests::bench::{digests, text};
use tests::kill::same_results;

#[test]
fn every_way_of_running_in_space_gives_the_same_bits_and_a_balanced_ledger() {
    let bench = bench();
    let case = bench.space_to(0.03);
    let split = bench.run(&case, "split", &[]);
    assert_eq!(digests(&bench.run(&case, "one", &["--in-process", "--threads", "1"])), digests(&split));
    assert_eq!(digests(&bench.run(&case, "four", &["--threads", "4"])), digests(&split));
    let ledger = &split["ledger"];
    assert_eq!((&split["verdict"], &ledger["breaches"]), (&"completed".into(), &0.into()));
    assert_eq!(split["dimensions"], 3);
    // The turning ball feels the water about all axes.
    let table = std::fs::read_to_string(bench.path("split/ledger.csv")).unwrap();
    let (head, last) = (table.lines().next().unwrap(), table.lines().last().unwrap());
    for column in ["solid_torque_x_n_m", "solid_torque_y_n_m", "solid_torque_z_n_m"] {
        let k = head.split(',').position(|name| name == column).unwrap_or_else(|| panic!("{column}"));
        let torque: f64 = last.split(',').nth(k).unwrap().parse().unwrap();
        assert!(torque != 0.0 && torque.is_finite(), "{column} = {torque}");
    }
    for file in ["report.html", "snapshots/fluid.pvd", "snapshots/solid.pvd"] {
        assert!(bench.path("split").join(file).is_file(), "{file}");
    }
}

#[test]
fn a_run_in_space_goes_on_to_a_later_end_with_the_bits_of_one_run() {
    let bench = bench();
    bench.run(&bench.space_to(0.03), "whole", &[]);
    // A time of a snapshot, which the steps of the whole run meet too.
    bench.run(&bench.space_to(0.01), "parts", &["--in-process"]);
    let output = bench.call(&["resume", text(&bench.path("parts")), "--quiet", "--until", "0.03"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    same_results(&bench.path("whole"), &bench.path("parts")).unwrap();
}
