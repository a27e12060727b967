//! Frames travel while each side computes its own sums.

use std::time::Duration;

use sph::coupling::solver::Role;
use tests::bench::Bench;
use tests::delay::DelayLine;
use tests::doubles::serve;
use tests::idle::Idle;

/// Mean wait of the fluid in a half-step \[s\] when frames are held back by `delay` and own sums take `own_sums`.
fn wait(delay: Duration, own_sums: Duration) -> f64 {
    let bench = Bench::new(env!("CARGO_BIN_EXE_tidelock-node"));
    let idle = |role| serve(Idle { role, particles: 300, own_sums });
    let (fluid, solid) = (idle(Role::Fluid), idle(Role::Solid));
    let line = DelayLine::start(solid.address, delay);
    let case = bench.tank_for_idle(0.0004);
    let (fluid, solid) = (fluid.address.to_string(), line.address.to_string());
    let summary = bench.run(&case, "out", &["--fluid", &fluid, "--solid", &solid]);
    let half_steps = 2.0 * summary["steps"].as_f64().unwrap();
    summary["fluid"]["waited_seconds"].as_f64().unwrap() / half_steps
}

#[test]
fn a_delay_shorter_than_the_own_sums_is_hidden_behind_them() {
    let delay = Duration::from_millis(20);
    let exposed = wait(delay, Duration::ZERO);
    assert!(exposed > delay.as_secs_f64(), "frames are held back: {exposed} s");
    let hidden = wait(delay, 3 * delay);
    // On a busy machine one side wakes later than the other, and is waited for.
    assert!(hidden < 0.5 * delay.as_secs_f64(), "of {delay:?} {hidden} s are exposed");
}
