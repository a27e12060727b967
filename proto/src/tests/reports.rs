//! Events, commands, snapshots and descriptions keep all they hold.

use bytes::Bytes;
use sph::coupling::driver::{Command, ProbeValues, StepReport};
use sph::coupling::ledger::{
    Account, Accounts, AngularBudget, Breach, Check, EnergyAccount, EnergyEntry, EnergyReport, InterfaceSums,
    LedgerVector, StageBudget,
};
use sph::coupling::solver::{Counts, Divergence, Fault, Field, ParticleFields, Role};
use sph::coupling::stage::{Stage, StepStage};
use sph::setup::InterfaceLaw;

use super::fake;
use crate::convert::{
    BatchItem, Beat, Convert, Path, Phase, SnapshotAssembler, decode_batch, decode_command, encode_batch,
    encode_command, snapshot_chunks,
};
use crate::description::{
    BodyReport, Constants, CouplingKind, Description, Fact, FrameField, LinkPlan, OpenReport, PROTOCOL,
    Partner,
};
use crate::handshake;
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
        BatchItem::Finished { step: 8, time: 0.4, reached_end: true, counts, state_index: 3 },
    ];
    items.extend(faults().into_iter().map(|fault| BatchItem::Failed {
        fault: Box::new(fault),
        step: 8,
        time: 0.4,
        counts,
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
        let chunks: Vec<_> = snapshot_chunks("run", 4, &sent).collect();
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
    let chunks: Vec<_> = snapshot_chunks("run", 0, &snapshot(3)).collect();
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

fn open_report(role: Role) -> OpenReport {
    let run = fake::run_setup("run", 5);
    let law = InterfaceLaw::PlainSum;
    let fields =
        |role| FrameField::sent_by(role, law, CouplingKind::States).iter().map(|f| f.spec()).collect();
    OpenReport {
        run_id: "run".into(),
        role,
        protocol: PROTOCOL,
        name: "row".into(),
        version: "1".into(),
        arithmetic: "f64 scalar".into(),
        coupling_kind: CouplingKind::States,
        constants: Constants::of(&run),
        fields_sent: fields(role),
        fields_needed: fields(role.partner()),
        extent: sph::coupling::exchange::Extent {
            version: 3,
            boxes: sph::coupling::exchange::Column::from_iter([[0.0, 0.0, 1.0, 2.0]]),
        },
        time_step_limit: f64::INFINITY,
        counts: Counts { particles: 5, ..Counts::default() },
        facts: vec![Fact { name: "c".into(), value: 20.0, unit: "m/s".into() }],
        bodies: vec![BodyReport { mass: 2.0, inertia: Some(0.25) }, BodyReport { mass: 1.0, inertia: None }],
    }
}

#[test]
fn the_hand_shake_survives() {
    let root = Path::root("reply");
    let description = Description::of_solver("row", "1.2", Role::Solid, "f64 scalar");
    assert_eq!(Description::from_wire(&description.to_wire(), &root), Ok(description));
    let report = open_report(Role::Solid);
    assert_eq!(OpenReport::from_wire(&report.to_wire(), &root), Ok(report));
    for partner in [Partner::Alone, Partner::Listen, Partner::Dial("localhost:1".into())] {
        let plan = LinkPlan {
            first_limit: 0.1,
            partner_extent: open_report(Role::Solid).extent,
            partner,
            partner_particles: None,
        };
        assert_eq!(LinkPlan::from_wire(&plan.to_wire(), &root), Ok(plan));
    }
    // Roles of a later version are left out, not refused.
    let mut later = Description::of_solver("row", "1.2", Role::Solid, "f64 scalar").to_wire();
    later.roles.push(99);
    assert_eq!(Description::from_wire(&later, &root).unwrap().roles, vec![Role::Solid]);
}

#[test]
fn sides_that_fit_have_no_mismatch_and_others_have_all_at_once() {
    let (fluid, mut solid) = (open_report(Role::Fluid), open_report(Role::Solid));
    assert_eq!(handshake::mismatches(&fluid, &solid), Vec::<String>::new());
    solid.constants.body_force.gravity.y = -9.81;
    solid.constants.kernel = "wendland".into();
    let coupling = solid.constants.coupling.as_mut().unwrap();
    coupling.fluid.rest_density = 998.0;
    coupling.solid_spacing = 0.02;
    coupling.law = InterfaceLaw::Wall;
    solid.constants.time.end_time = 9.0;
    solid.fields_sent[1].unit = "cm/s".into();
    solid.fields_sent.retain(|spec| spec.field != FrameField::Stress);
    let found = handshake::mismatches(&fluid, &solid);
    for expected in [
        "kernel: \"cubic-spline\" at the fluid, \"wendland\" at the solid",
        "gravity y: 0.0 m/s2 at the fluid, -9.81 m/s2 at the solid",
        "rest_density_kg_m3: 1000 at the fluid, 998 at the solid",
        "solid particle spacing: 0.01 m at the fluid, 0.02 m at the solid",
        "interface law: Wall at the fluid, Wall at the solid",
        "end time:",
        "field velocity: the fluid needs 2 numbers in m/s, the solid sends 2 in cm/s",
        "field stress: the fluid needs it, the solid does not send it",
    ] {
        let expected_is_equal = expected.starts_with("interface law");
        assert_eq!(
            found.iter().any(|line| line.contains(expected)),
            !expected_is_equal,
            "{expected}: {found:#?}"
        );
    }
    assert_eq!(found.len(), 7, "{found:#?}");
    let swapped = handshake::mismatches(&solid, &fluid);
    assert!(swapped[0].contains("roles: solid and fluid"), "{swapped:?}");
}

#[test]
fn a_server_that_cannot_play_is_told_why() {
    let mut run = fake::run_setup("run", 5);
    run.time.step = sph::setup::StepPolicy::Adaptive { factor: 0.5, maximum: 1.0, growth: 1.1 };
    run.body_force.expressions = Some(["x".into(), "t".into()]);
    let mut description = Description::of_solver("beam", "3", Role::Solid, "f64");
    assert_eq!(handshake::unfit(&description, Role::Solid, &run), Vec::<String>::new());
    let coupling = run.coupling.as_mut().unwrap();
    coupling.kind = CouplingKind::Loads;
    coupling.implicit = Some(fake::IMPLICIT);
    assert_eq!(handshake::unfit(&description, Role::Solid, &run), Vec::<String>::new());
    description.capabilities.implicit_coupling = false;
    let reasons = handshake::unfit(&description, Role::Solid, &run);
    assert!(reasons.len() == 1 && reasons[0].contains("leave out `interface.iterate`"), "{reasons:#?}");
    run.coupling.as_mut().unwrap().kind = CouplingKind::States;
    description.dimensions = vec![3];
    description.coupling_kinds = vec![CouplingKind::Loads];
    description.interface_laws.clear();
    description.capabilities = Default::default();
    description.protocols = [crate::description::ProtocolVersion { major: 3, minor: 0 }; 2];
    let reasons = handshake::unfit(&description, Role::Fluid, &run);
    assert_eq!(reasons.len(), 8, "{reasons:#?}");
    assert!(reasons[0].contains("beam 3 speaks protocol 3.0 to 3.0, this coordinator 2.0"), "{reasons:#?}");
    assert!(reasons[1].contains("plays solid, needed is fluid"), "{reasons:#?}");
}
