//! Events, commands and snapshots keep all they hold.

use bytes::Bytes;
use sph::coupling::driver::{Command, ProbeValues, StepReport};
use sph::coupling::ledger::{
    Account, Accounts, AngularBudget, Breach, Check, EnergyAccount, EnergyEntry, EnergyReport, InterfaceSums,
    LedgerVector, StageBudget,
};
use sph::coupling::solver::{Counts, Divergence, Fault, Field, PartCount, PartCounts, ParticleFields};
use sph::coupling::stage::{Stage, StepStage};

use crate::convert::{
    BatchItem, Beat, Phase, SnapshotAssembler, decode_batch, decode_command, encode_batch, encode_command,
    snapshot_chunks,
};
use crate::limits::CHUNK_BYTES;
use crate::wire;

const AT: StepStage = StepStage { step: 9, stage: Stage::Corrector };

fn budget(scale: f64) -> StageBudget {
    let mut accounts = Accounts::default();
    for account in Account::ALL {
        accounts.add_force(account, LedgerVector::new(f64::NAN, scale * account as u8 as f64, 5e-324));
        accounts.add_torque(account, LedgerVector::new(-1.0, 0.5, scale));
    }
    StageBudget {
        interface: InterfaceSums {
            force: LedgerVector::new(-0.0, scale, 0.0),
            gross_force: 2.0 * scale,
            torque: LedgerVector::new(-0.0, 5e-324, 3.0),
            gross_torque: 4.0,
            couple: LedgerVector::repeat(5.0),
            power: -0.0,
            pairs: 6,
        },
        accounts,
        duration: 1e-3,
        momentum_change: LedgerVector::new(5e-324, -0.0, f64::INFINITY),
        gross_momentum: f64::NAN,
        angular: Some(AngularBudget { change: LedgerVector::repeat(-0.0), gross: f64::INFINITY }),
    }
}

fn faults() -> Vec<Fault> {
    vec![
        Fault::Diverged(Divergence {
            at: AT,
            particle: Some(0),
            position: Some(vec![-0.0, f64::INFINITY]),
            quantity: "density [kg/m3]".into(),
            value: f64::NAN,
            allowed: "positive".into(),
            hint: "smaller steps".into(),
        }),
        Fault::Diverged(Divergence {
            at: AT,
            particle: None,
            position: None,
            quantity: "escaped particles".into(),
            value: 1.0,
            allowed: "0".into(),
            hint: "look".into(),
        }),
        Fault::Ledger(Breach { at: AT, check: Check::Torque, residual: f64::INFINITY, tolerance: 1e-12 }),
        Fault::StaleFrame { at: AT, sent: 1, used: u32::MAX },
        Fault::Coverage { at: AT, shortfall: 1e-3 },
        Fault::Clock { at: AT, difference: "time step".into() },
        Fault::Peer { at: AT, message: "lost".into() },
        Fault::Aborted { at: AT },
    ]
}

fn items() -> Vec<BatchItem> {
    let part = PartCount {
        particles: 1,
        copies: 2,
        computing_seconds: 3.0,
        waited_for_copies_seconds: 4.0,
        waited_for_agreement_seconds: 5.0,
        copy_messages: 6,
        copy_bytes: 7,
        other_messages: 8,
        other_bytes: 9,
    };
    let counts = Counts {
        particles: 1,
        wall_particles: 2,
        list_builds: 3,
        escaped: 4,
        outflow: 5,
        largest_interface: 6,
        deepest_contact_m: 7e-3,
        contact_impulse_n_s: 0.8,
        substeps: 9,
        parts: Some(PartCounts {
            each: vec![PartCount::default(), part],
            mean_imbalance: Some(0.1),
            largest_imbalance: None,
        }),
    };
    let mut items = vec![
        BatchItem::Step(Box::new(StepReport {
            step: 7,
            end_time: 0.1 + 0.2,
            time_step: 1e-5,
            budgets: [budget(1.0), budget(-0.1)],
            energies: energies(),
            interface_particles: [3, 4],
            elapsed: 0.5,
            waited: 0.25,
            breaches: 1,
            iterations: 3,
            unconverged: true,
        })),
        BatchItem::Probes(ProbeValues { step: 7, time: 0.3, values: vec![f64::NAN, -0.0, 5e-324] }),
        BatchItem::Snapshot { index: 2, step: 7, time: 0.3 },
        BatchItem::Beat(Beat {
            step: 7,
            phase: Phase::WaitingForPartner,
            since_last_step: 0.5,
            awaited: Some(sph::coupling::stage::StepStage::FIRST),
        }),
        BatchItem::Paused(sph::coupling::driver::Paused { step: 9, time: 0.25 }),
        BatchItem::Finished { step: 8, time: 0.4, reached_end: true, counts: counts.clone(), state_index: 3 },
    ];
    items.extend(faults().into_iter().map(|fault| BatchItem::Failed {
        fault: Box::new(fault),
        step: 8,
        time: 0.4,
        counts: counts.clone(),
        state_index: 3,
    }));
    items
}

#[test]
fn events_keep_all_they_hold() {
    let sent = items();
    let encoded = prost::Message::encode_to_vec(&encode_batch("run", 2, &sent));
    let batch: wire::EventBatch = prost::Message::decode(encoded.as_slice()).unwrap();
    assert_eq!((batch.run_id.as_str(), batch.epoch), ("run", 2));
    let received = decode_batch(&batch).unwrap();
    // NaN is not equal to itself; its text is.
    assert_eq!(format!("{received:?}"), format!("{sent:?}"));
}

#[test]
fn an_event_of_a_later_version_is_named() {
    let batch = wire::EventBatch { events: vec![wire::Event { body: None }], ..encode_batch("run", 0, &[]) };
    let error = decode_batch(&batch).unwrap_err().to_string();
    assert!(error.contains("`batch.events[0]`") && error.contains("later version"), "{error}");
}

#[test]
fn commands_survive() {
    for command in [Command::GrantThrough(u64::MAX), Command::Stop, Command::Abort] {
        assert_eq!(decode_command(&encode_command("run", 0, command)), Ok(command));
    }
    let none = wire::Command { run_id: "run".into(), epoch: 0, order: None };
    assert!(decode_command(&none).is_err());
}

/// A store, a work and a loss; others are not known.
fn energies() -> EnergyReport {
    let mut report = EnergyReport::default();
    report.set(EnergyAccount::Kinetic, EnergyEntry { value: -0.0, start: 1.5 });
    report.set(EnergyAccount::Interface, EnergyEntry { value: f64::INFINITY, start: 0.0 });
    report.set(EnergyAccount::Friction, EnergyEntry { value: -2.0, start: 0.0 });
    report
}

fn snapshot(count: usize) -> ParticleFields {
    ParticleFields {
        step: 5,
        time: 0.1,
        id: (0..count as u32).collect(),
        group: (0..count as u32).map(|k| k % 2).collect(),
        group_names: vec!["a".into(), "b".into()],
        fields: vec![
            Field {
                name: "position".into(),
                unit: "m".into(),
                components: 2,
                values: (0..2 * count).map(|k| -(k as f64)).collect(),
            },
            Field {
                name: "pressure".into(),
                unit: "Pa".into(),
                components: 1,
                values: (0..count).map(|k| if k == 1 { f64::NAN } else { 0.1 * k as f64 }).collect(),
            },
        ],
    }
}

#[test]
fn snapshots_of_any_size_come_together_again() {
    // None; few; more than two chunks.
    for count in [0, 3, 100_000] {
        let sent = snapshot(count);
        let chunks: Vec<_> = snapshot_chunks("run", 4, sent.clone()).collect();
        assert_eq!(chunks.len(), 1 + (count * 32).div_ceil(CHUNK_BYTES));
        let mut assembler = SnapshotAssembler::default();
        let mut received = None;
        for chunk in chunks {
            assert!(received.is_none(), "complete before the last chunk");
            received = assembler.take(chunk).unwrap();
        }
        let (index, received) = received.unwrap();
        assert_eq!(index, 4);
        assert!(format!("{received:?}") == format!("{sent:?}"), "{count} particles differ");
    }
}

#[test]
fn broken_snapshots_are_refused() {
    let chunks: Vec<_> = snapshot_chunks("run", 0, snapshot(3)).collect();
    let header = |spoil: &dyn Fn(&mut wire::SnapshotHeader)| {
        let mut chunk = chunks[0].clone();
        let Some(wire::snapshot_chunk::Part::Header(header)) = chunk.part.as_mut() else { panic!() };
        spoil(header);
        let mut assembler = SnapshotAssembler::default();
        assembler.take(chunk).and_then(|_| assembler.take(chunks[1].clone())).unwrap_err().to_string()
    };
    assert!(SnapshotAssembler::default().take(chunks[1].clone()).is_err());
    assert!(header(&|h| h.count = u64::MAX).contains("`snapshot.header.count`"));
    assert!(header(&|h| h.count = 2).contains("where 1 to 64 were expected"));
    assert!(header(&|h| h.fields[1].components = 0).contains("`snapshot.header.fields[1].components`"));
    assert!(header(&|h| h.fields[1].components = u32::MAX).contains("components"));
    assert!(header(&|h| h.group_names.truncate(1)).contains("`snapshot.groups`: of particle number 1 is 1"));
    assert!(header(&|h| h.time_s_bits = f64::NAN.to_bits()).contains("time_s_bits"));
    let empty = wire::SnapshotChunk {
        run_id: "run".into(),
        part: Some(wire::snapshot_chunk::Part::Data(Bytes::new())),
    };
    let mut assembler = SnapshotAssembler::default();
    assembler.take(chunks[0].clone()).unwrap();
    assert!(assembler.take(empty).is_err());
}
