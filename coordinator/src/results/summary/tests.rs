use sph::coupling::stage::Stage;

use super::*;
use crate::case::overrides::Override;
use crate::results::quality::Evidence;

fn summary() -> Summary {
    let mut fluid = Participant { solver: "fluid-server 0.1.0".into(), ..Participant::default() };
    fluid.counts = Counts { particles: 100, wall_particles: 20, escaped: 1, outflow: 2, ..Counts::default() };
    fluid.set_waits(4.0, 1.0);
    let extremes = Extremes {
        force: Largest { value: 3e-15, at: Some(StepStage { step: 7, stage: Stage::Corrector }) },
        torque: Largest { value: f64::INFINITY, at: Some(StepStage::FIRST) },
        ..Extremes::default()
    };
    Summary {
        format: FORMAT,
        case: "still water".into(),
        run_id: "r-1".into(),
        dimensions: 2,
        verdict: Verdict::Failed,
        reservations: vec!["a reservation".into()],
        quality: Evidence { mach: Some(0.5), ..Evidence::default() }.figures(),
        reason: "ledger breach".into(),
        steps: 10,
        simulated: Span { start_s: 0.0, end_s: 0.1 },
        wall_seconds: 5.0,
        time_step: Some(StepSizes::with(Some(StepSizes::with(None, 2e-5)), 1e-5)),
        particle_stages_per_second: Some(1e6),
        ledger: LedgerSummary::new(
            1,
            vec!["a breach".into()],
            &extremes,
            Work { received: [-2.0, 1.5], passed: 10.0 },
        ),
        energy: EnergySummary::default(),
        iterations: Some(IterationSummary { mean: Some(2.5), largest: 4, unsettled_steps: 1 }),
        fluid: Some(fluid),
        solid: None,
        coordinator: Process { peak_memory_bytes: Some(1 << 20), cpu_seconds: None },
        checkpoints: Checkpoints::default(),
        restarts: vec![],
        in_process: false,
        case_digest: "00".into(),
        set: vec![Override::new("fluid.sound_speed_m_s", 40.0)],
        parameters: BTreeMap::from([("fluid.exponent".to_string(), 7.0.into())]),
        constants: BTreeMap::new(),
        versions: BTreeMap::from([("coordinator".to_string(), "0.1.0".to_string())]),
        warnings: vec![],
    }
}

#[test]
fn programs_find_every_figure_under_its_key() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("summary.json");
    summary().write(&path).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let expect = |pointer: &str, value: serde_json::Value| {
        assert_eq!(json.pointer(pointer), Some(&value), "{pointer}");
    };
    expect("/verdict", "failed".into());
    expect("/reservations/0", "a reservation".into());
    expect("/quality/2/name", "mach_number".into());
    expect("/quality/2/value", 0.5.into());
    expect("/quality/2/threshold", 0.3.into());
    expect("/quality/2/verdict", "reservation".into());
    expect("/quality/0/value", serde_json::Value::Null);
    expect("/quality/0/verdict", "not-judged".into());
    assert_eq!(summary().verdict_text(), "failed, with reservations");
    expect("/set/0/key", "fluid.sound_speed_m_s".into());
    expect("/set/0/value", "40.0".into());
    expect("/time_step/smallest_s", 1e-5.into());
    expect("/time_step/largest_s", 2e-5.into());
    expect("/fluid/waited_share", 0.25.into());
    expect("/fluid/counts/particles", 100.into());
    expect("/fluid/counts/outflow", 2.into());
    expect("/ledger/largest_force_imbalance/value", 3e-15.into());
    expect("/ledger/largest_force_imbalance/at/step", 7.into());
    expect("/ledger/largest_force_imbalance/at/stage", "corrector".into());
    expect("/ledger/interface_energy/solid_received_j_per_m", 1.5.into());
    expect("/ledger/interface_energy/drift_j_per_m", (-0.5).into());
    expect("/ledger/interface_energy/drift_share", (-0.05).into());
    expect("/energy/residual_j_per_m", serde_json::Value::Null);
    expect("/ledger/largest_torque_imbalance/value", serde_json::Value::Null);
    expect("/ledger/largest_torque_imbalance/at/stage", "predictor".into());
    expect("/coordinator/peak_memory_bytes", (1 << 20).into());
    expect("/iterations/mean", 2.5.into());
    expect("/iterations/largest", 4.into());
    expect("/iterations/unsettled_steps", 1.into());
    assert!(json.get("solid").is_none(), "a side that took no part has no entry");
}

#[test]
fn a_side_without_steps_has_no_share_of_waiting() {
    let mut side = Participant::default();
    side.set_waits(0.0, 0.0);
    assert_eq!(side.waited_share, None);
}
