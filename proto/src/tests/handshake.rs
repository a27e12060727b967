//! Descriptions and reports keep all they hold, and what does not fit together is named.

use sph::coupling::solver::{Counts, Role};
use sph::in_space;
use sph::setup::{AnySolidSetup, InterfaceLaw, RunPlan};
use sph::space::components::Components;
use sph::space::{AnySpace, Plane, Spatial, SymmetricTensor3};

use super::fake;
use crate::convert::{Convert, Path, link_from_wire, link_to_wire};
use crate::description::{
    BodyReport, Constants, CouplingKind, Description, Fact, FrameField, Inertia, LinkPlan, OpenReport,
    PROTOCOL, Partner,
};
use crate::handshake;
use crate::wire;

fn open_report(role: Role) -> OpenReport {
    report_of(&fake::run_setup::<Plane>("run", 5).plan(), role)
}

/// The report of a participant in `run`.
fn report_of(run: &RunPlan, role: Role) -> OpenReport {
    let (law, dimensions) = (InterfaceLaw::PlainSum, run.dimensions());
    let spec = |field: &FrameField| field.spec(dimensions);
    let fields = |role| FrameField::sent_by(role, law, CouplingKind::States).iter().map(spec).collect();
    let corners = [vec![0.0; dimensions], vec![1.0; dimensions]].concat();
    let inertia = match dimensions {
        2 => AnySpace::Plane(0.25),
        _ => AnySpace::Spatial(SymmetricTensor3::from_row([1.0, 2.0, 3.0, -0.0, 5e-324, -0.1])),
    };
    OpenReport {
        run_id: "run".into(),
        role,
        protocol: PROTOCOL,
        name: "row".into(),
        version: "1".into(),
        arithmetic: "f64 scalar".into(),
        coupling_kind: CouplingKind::States,
        constants: Constants::of(run),
        fields_sent: fields(role),
        fields_needed: fields(role.partner()),
        extent: sph::coupling::exchange::Extent {
            version: 3,
            boxes: sph::coupling::exchange::Column { components: 2 * dimensions, values: corners },
        },
        time_step_limit: f64::INFINITY,
        counts: Counts { particles: 5, ..Counts::default() },
        facts: vec![Fact { name: "c".into(), value: 20.0, unit: "m/s".into() }],
        bodies: vec![
            BodyReport { mass: 2.0, inertia: Some(inertia) },
            BodyReport { mass: 1.0, inertia: None },
        ],
        remarks: vec!["the first body starts in a wall".into()],
    }
}

fn spatial_report(role: Role) -> OpenReport {
    report_of(&fake::run_setup::<Spatial>("run", 5).plan(), role)
}

#[test]
fn the_hand_shake_survives() {
    let root = Path::root("reply");
    let description = Description::of_solver("row", "1.2", Role::Solid, &[2, 3], "f64 scalar");
    assert_eq!(Description::from_wire(&description.to_wire(), &root), Ok(description));
    for report in [open_report(Role::Solid), spatial_report(Role::Solid)] {
        let carried = OpenReport::from_wire(&report.to_wire(), &root).unwrap();
        assert_eq!(format!("{carried:?}"), format!("{report:?}"));
    }
    for partner in [Partner::Alone, Partner::Listen, Partner::Dial("localhost:1".into())] {
        let plan = LinkPlan {
            first_limit: 0.1,
            partner_extent: open_report(Role::Solid).extent,
            partner,
            partner_particles: None,
        };
        assert_eq!(link_from_wire(&link_to_wire(&plan), 2, &root), Ok(plan));
    }
    // Roles of a later version are left out, not refused.
    let mut later = Description::of_solver("row", "1.2", Role::Solid, &[2], "f64 scalar").to_wire();
    later.roles.push(99);
    assert_eq!(Description::from_wire(&later, &root).unwrap().roles, vec![Role::Solid]);
}

#[test]
fn sides_that_fit_have_no_mismatch_and_others_have_all_at_once() {
    let (fluid, mut solid) = (open_report(Role::Fluid), open_report(Role::Solid));
    assert_eq!(handshake::mismatches(&fluid, &solid), Vec::<String>::new());
    solid.constants.body_force.gravity[1] = -9.81;
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
    let mut run = fake::run_setup::<Plane>("run", 5).plan();
    run.time.step =
        sph::setup::StepPolicy::Adaptive { factor: 0.5, maximum: 1.0, growth: 1.1, exact: Some(vec![0.5]) };
    run.body_force.expressions = Some(vec!["x".into(), "t".into()]);
    let mut description = Description::of_solver("beam", "3", Role::Solid, &[2], "f64");
    assert_eq!(handshake::unfit(&description, Role::Solid, &run), Vec::<String>::new());
    let coupling = run.coupling.as_mut().unwrap();
    coupling.kind = CouplingKind::Loads;
    coupling.implicit = Some(fake::IMPLICIT);
    assert_eq!(handshake::unfit(&description, Role::Solid, &run), Vec::<String>::new());
    description.capabilities.exact_times = false;
    let reasons = handshake::unfit(&description, Role::Solid, &run);
    assert!(reasons.len() == 1 && reasons[0].contains("exact_outputs = false"), "{reasons:#?}");
    description.capabilities.exact_times = true;
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
    assert!(reasons[2].contains("computes in 3 dimensions, the case in 2"), "{reasons:#?}");
}

#[test]
fn numbers_of_another_space_are_refused_by_name() {
    let refusal = |spoil: fn(&mut wire::OpenReply)| {
        let mut reply = spatial_report(Role::Solid).to_wire();
        spoil(&mut reply);
        OpenReport::from_wire(&reply, &Path::root("reply")).unwrap_err().to_string()
    };
    let error = refusal(|reply| {
        let domain = reply.constants.as_mut().unwrap().domain.as_mut().unwrap();
        domain.lower_m.as_mut().unwrap().components.push(-1.0);
    });
    let expected = "has 4 components, must have 2 or 3, as many as the run has dimensions";
    assert_eq!(error, format!("`reply.constants.domain.lower_m`: {expected}"));
    let error = refusal(|reply| {
        let domain = reply.constants.as_mut().unwrap().domain.as_mut().unwrap();
        domain.upper_m.as_mut().unwrap().components.truncate(2);
    });
    let expected = "has 2 components, must have 3 in a run of 3 dimensions";
    assert_eq!(error, format!("`reply.constants.domain.upper_m`: {expected}"));
    let error = refusal(|reply| reply.extent.as_mut().unwrap().boxes_m = vec![0; 32].into());
    assert!(error.contains("`reply.extent.boxes_m`: has 32 bytes, must have 48 for each box"), "{error}");
    let error = refusal(|reply| reply.bodies[0].inertia_tensor_kg_m2.truncate(3));
    assert_eq!(error, "`reply.bodies[0].inertia_tensor_kg_m2`: has 3 components, must have 6");
    let error = refusal(|reply| reply.bodies[0].inertia_kg_m2 = Some(1.0));
    assert_eq!(error, "`reply.bodies[0].inertia_tensor_kg_m2`: is given beside inertia_kg_m2");
    let error = refusal(|reply| {
        reply.bodies[0].inertia_tensor_kg_m2.clear();
        reply.bodies[0].inertia_kg_m2 = Some(1.0);
    });
    assert_eq!(error, "`reply.bodies[0]`: has an inertia of 2 dimensions in a run of 3 dimensions");
    let plan = LinkPlan {
        first_limit: 0.1,
        partner_extent: open_report(Role::Solid).extent,
        partner: Partner::Listen,
        partner_particles: None,
    };
    let error = link_from_wire(&link_to_wire(&plan), 3, &Path::root("link")).unwrap_err().to_string();
    assert!(error.contains("`link.partner_extent.boxes_m`: has 32 bytes, must have 48"), "{error}");
}

#[test]
fn differences_in_space_are_named_by_axis() {
    let (fluid, mut solid) = (spatial_report(Role::Fluid), spatial_report(Role::Solid));
    assert_eq!(handshake::mismatches(&fluid, &solid), Vec::<String>::new());
    solid.constants.body_force.gravity[2] = -9.81;
    solid.constants.domain.lower[2] = -2.0;
    let found = handshake::mismatches(&fluid, &solid);
    assert_eq!(
        found,
        [
            "gravity z: 0.0 m/s2 at the fluid, -9.81 m/s2 at the solid",
            "domain lower z: -1.0 m at the fluid, -2.0 m at the solid",
        ]
    );
    let found = handshake::mismatches(&fluid, &open_report(Role::Solid));
    assert_eq!(found[0], "dimensions: 3 at the fluid, 2 at the solid");
    assert!(found.iter().any(|line| line.contains("field stress: the fluid needs 6 numbers")), "{found:#?}");
}

/// What a rigid solver says of the bodies of `setup`, whose inertia is `inertia`.
fn says(setup: &AnySolidSetup, mass: f64, inertia: Inertia) -> Vec<String> {
    let run = in_space!(setup, setup => setup.run.plan());
    let bodies = vec![BodyReport { mass, inertia: Some(inertia) }];
    handshake::other_bodies(setup, &OpenReport { bodies, ..report_of(&run, Role::Solid) })
}

#[test]
fn bodies_are_compared_by_all_their_inertia() {
    let plane = fake::solid_setup(fake::run_setup::<Plane>("run", 5));
    let mass = plane.particles.of_body(0).mass();
    let inertia = plane.particles.of_body(0).inertia();
    let plane = AnySpace::Plane(plane);
    assert_eq!(says(&plane, mass, AnySpace::Plane(inertia)), Vec::<String>::new());
    let found = says(&plane, 2.0 * mass, AnySpace::Plane(1.01 * inertia));
    assert!(found[0].starts_with("mass of body `row`") && found[1].starts_with("moment of inertia of body"));

    let spatial = fake::solid_setup(fake::run_setup::<Spatial>("run", 5));
    let tensor = spatial.particles.of_body(0).inertia();
    let spatial = AnySpace::Spatial(spatial);
    assert_eq!(says(&spatial, mass, AnySpace::Spatial(tensor)), Vec::<String>::new());
    for (k, name) in ["xx", "yy", "zz", "xy", "yz", "xz"].into_iter().enumerate() {
        let mut row = tensor.row();
        row[k] += 1e-6 * tensor.xx;
        let found = says(&spatial, mass, AnySpace::Spatial(SymmetricTensor3::from_row(row)));
        assert!(
            found.len() == 1 && found[0].starts_with(&format!("moment of inertia {name} of body `row`: "))
        );
    }
    let found = says(&spatial, mass, AnySpace::Plane(inertia));
    assert_eq!(found, ["moment of inertia of body `row`: is of 2 dimensions, the set-up of 3"]);
}
