//! Set-ups travel bit for bit, and everything wrong in one is refused by name.

use bytes::Bytes;
use sph::coupling::solver::Role;
use sph::setup::{
    BodyForce, BodySetup, BreachAction, ContactLaw, CouplingKind, Damping, ElasticParameters,
    FluidParameters, FluidProbe, FluidProbeKind, FluidSetup, Formulation, GradientCorrection, InterfaceLaw,
    LoadLaw, Motion, Outflow, ParticipantSetup, RepulsionParameters, RunSetup, SolidProbe, SolidProbeKind,
    SolidSetup, SolidStepping, StepPolicy, SubstepCount, Support, SurfaceLoad, TotalLagrangian,
    UpdatedLagrangian, ViscousForm, WallCondition, WallParticles, WallSetup,
};
use sph::space::{SymmetricTensor, Vector};

use super::fake;
use crate::convert::{Convert, Path};
use crate::wire;

fn motion() -> Motion {
    Motion {
        displacement: ["0.1*sin(t)".into(), String::new()],
        angle: "t^2".into(),
        axis: 1.0,
        pivot: Vector::new(-0.0, 0.5),
    }
}

fn walls() -> Vec<WallSetup> {
    vec![
        WallSetup { name: "floor".into(), condition: WallCondition::Slip, motion: None, release_time: None },
        WallSetup {
            name: "gate".into(),
            condition: WallCondition::NoSlip,
            motion: Some(motion()),
            release_time: Some(-0.0),
        },
    ]
}

fn wall_particles() -> WallParticles {
    WallParticles {
        wall: vec![0, 1, 1],
        position: vec![Vector::new(0.1, -0.0), Vector::new(5e-324, 1e300), Vector::zeros()],
        normal: vec![Vector::new(0.0, 1.0), Vector::zeros(), Vector::new(-1.0, -0.0)],
    }
}

fn run(step: StepPolicy, law: InterfaceLaw, correction: GradientCorrection) -> RunSetup {
    let mut run = fake::run_setup("run", 3);
    run.time.step = step;
    run.domain.periodic = [true, false];
    run.ledger.action = BreachAction::Warn;
    run.outputs.probe_interval = None;
    run.body_force =
        BodyForce { gravity: Vector::new(-0.0, -9.81), expressions: Some(["x*t".into(), "0".into()]) };
    let coupling = run.coupling.as_mut().unwrap();
    coupling.law = law;
    coupling.fluid.correction = correction;
    if law == InterfaceLaw::WallNoSlip {
        coupling.kind = CouplingKind::Loads;
        coupling.implicit = Some(fake::IMPLICIT);
    }
    run
}

fn fluid() -> FluidSetup {
    let policy = StepPolicy::Adaptive { factor: 1.0, maximum: f64::INFINITY, growth: 1.05 };
    let run = run(policy, InterfaceLaw::WallNoSlip, GradientCorrection::Renormalised);
    let ParticipantSetup::Fluid(mut setup) = fake::fluid_setup(run) else { panic!() };
    setup.parameters = FluidParameters {
        wall_repulsion: 0.02,
        acoustic_damping: 0.3,
        viscosity_b: -0.0,
        viscous_form: ViscousForm::Stress,
        shifting: 0.7,
        tensile_control: true,
        tension_limit: Some(7e3),
        lost_particle_limit: 1_000_000_000,
        ..setup.parameters
    };
    setup.damping = Some(Damping { rate: 3.0, until: 0.1 });
    setup.regions.push("rest".into());
    setup.walls = walls();
    setup.wall_particles = wall_particles();
    setup.particles.velocity[0] = Vector::new(-0.0, 5e-324);
    setup.particles.region[5] = 1;
    let kinds = [
        FluidProbeKind::Point(Vector::new(0.1, -0.0)),
        FluidProbeKind::WaterLevel(-0.0),
        FluidProbeKind::Front,
        FluidProbeKind::Region(Some(1)),
        FluidProbeKind::Region(None),
        FluidProbeKind::WallForce(1),
        FluidProbeKind::Immersed,
    ];
    setup.probes = kinds
        .into_iter()
        .enumerate()
        .map(|(k, kind)| FluidProbe { name: format!("probe {k}"), kind })
        .collect();
    setup.outflow = Outflow { lower: [false, true], upper: [true, false] };
    setup
}

fn solid() -> SolidSetup {
    let policy = StepPolicy::Fixed { time_step: 1e-5 };
    let run = run(policy, InterfaceLaw::PlainSum, GradientCorrection::None);
    let ParticipantSetup::Solid(mut setup) = fake::solid_setup(run) else { panic!() };
    setup.bodies.push(BodySetup {
        name: "plate".into(),
        material: ElasticParameters {
            density: 1100.0,
            bulk_modulus: 2e7,
            shear_modulus: 1.0,
            plane: sph::setup::PlaneState::Strain,
        },
        formulation: Formulation::UpdatedLagrangian(UpdatedLagrangian {
            viscosity_b: 2.0,
            lambda: -0.0,
            ..UpdatedLagrangian::default()
        }),
        supports: vec![
            Support { name: "root".into(), held: [true, true], motion: None, release_time: None },
            Support {
                name: "hand".into(),
                held: [false, true],
                motion: Some(motion()),
                release_time: Some(0.2),
            },
        ],
        acceleration: Some(["0".into(), "-9.81*t".into()]),
        loads: vec![
            SurfaceLoad {
                name: "wind".into(),
                law: LoadLaw::Pressure("1000*sin(t)".into()),
                particles: vec![0],
                areas: vec![Vector::new(-0.0, 0.01)],
            },
            SurfaceLoad {
                name: "rope".into(),
                law: LoadLaw::Traction(["1".into(), "t*x".into()]),
                particles: Vec::new(),
                areas: Vec::new(),
            },
        ],
    });
    setup.bodies.push(BodySetup {
        name: "ring".into(),
        material: ElasticParameters {
            density: 900.0,
            bulk_modulus: 1e7,
            shear_modulus: 3e6,
            plane: sph::setup::PlaneState::Strain,
        },
        formulation: Formulation::TotalLagrangian(TotalLagrangian {
            viscosity_b: 0.7,
            ..TotalLagrangian::default()
        }),
        supports: Vec::new(),
        acceleration: None,
        loads: Vec::new(),
    });
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(4));
    let last = fake::MASSES - 1;
    setup.particles.body[last] = 1;
    setup.particles.support[last] = 2;
    setup.particles.deviatoric_stress[last] = SymmetricTensor { xx: -0.0, yy: 5e-324, xy: -1.0 / 3.0 };
    setup.particles.reference_position[last] = Vector::new(-0.0, 7.0);
    setup.contact = ContactLaw::Repulsion(RepulsionParameters {
        stiffness: 0.1,
        damping: 0.0,
        friction: 0.3,
        ..RepulsionParameters::default()
    });
    setup.walls = walls();
    setup.wall_particles = wall_particles();
    let kinds = [
        SolidProbeKind::MaterialPoint(1, Vector::new(-0.0, 1.0)),
        SolidProbeKind::Motion(0),
        SolidProbeKind::BodyForce(1),
        SolidProbeKind::Reaction(1, 1),
        SolidProbeKind::Sums(Some(0)),
        SolidProbeKind::Sums(None),
        SolidProbeKind::Gap(Some(1)),
        SolidProbeKind::Gap(None),
        SolidProbeKind::Contact(Some(0)),
        SolidProbeKind::Contact(None),
    ];
    setup.probes = kinds
        .into_iter()
        .enumerate()
        .map(|(k, kind)| SolidProbe { name: format!("probe {k}"), kind })
        .collect();
    setup
}

/// Through bytes and back.
fn carried<T: Convert>(value: &T) -> T
where
    T::Wire: prost::Message + Default,
{
    let encoded = prost::Message::encode_to_vec(&value.to_wire());
    let message: T::Wire = prost::Message::decode(encoded.as_slice()).unwrap();
    T::from_wire(&message, &Path::root("open")).unwrap()
}

/// Equality of texts that shows the first difference only.
fn assert_same(what: &str, ours: &impl std::fmt::Debug, theirs: &impl std::fmt::Debug) {
    let (a, b) = (format!("{ours:?}"), format!("{theirs:?}"));
    let same = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
    let shown = |text: &str| text.chars().skip(same.saturating_sub(60)).take(120).collect::<String>();
    assert!(a == b, "{what}: ...{} is not ...{}", shown(&a), shown(&b));
}

#[test]
fn set_ups_travel_bit_for_bit() {
    // `Debug` of a float tells all its bits but those of NaN, and -0.0 from 0.0, unlike ==.
    let (fluid, solid) = (fluid(), solid());
    assert_same("fluid", &carried(&fluid), &fluid);
    assert_same("solid", &carried(&solid), &solid);
    for role in [Role::Fluid, Role::Solid] {
        match fake::alone(role, "alone", 1) {
            ParticipantSetup::Fluid(setup) => assert_eq!(carried(&setup), setup),
            ParticipantSetup::Solid(setup) => assert_eq!(carried(&setup), setup),
        }
    }
}

fn fluid_refusal(spoil: impl FnOnce(&mut wire::FluidSetup)) -> String {
    let mut message = fluid().to_wire();
    spoil(&mut message);
    FluidSetup::from_wire(&message, &Path::root("open")).unwrap_err().to_string()
}

fn solid_refusal(spoil: impl FnOnce(&mut wire::SolidSetup)) -> String {
    let mut message = solid().to_wire();
    spoil(&mut message);
    SolidSetup::from_wire(&message, &Path::root("open")).unwrap_err().to_string()
}

fn spoil_run(spoil: impl FnOnce(&mut wire::RunSetup)) -> String {
    fluid_refusal(|m| spoil(m.run.as_mut().unwrap()))
}

#[test]
fn wrong_numbers_are_refused_by_path() {
    let gravity = |spoil: fn(&mut Vec<f64>)| {
        spoil_run(|r| {
            spoil(&mut r.body_force.as_mut().unwrap().gravity_m_per_s2.as_mut().unwrap().components);
        })
    };
    let error = gravity(|components| components[1] = f64::NAN);
    assert_eq!(error, "`open.run.body_force.gravity_m_per_s2.components[1]`: is NaN, must be finite");
    let error = gravity(|components| components.push(0.0));
    assert_eq!(error, "`open.run.body_force.gravity_m_per_s2`: has 3 components, must have 2");
    let error = spoil_run(|r| r.dimensions = 3);
    assert_eq!(error, "`open.run.dimensions`: is 3, this program computes in 2");
    let error = spoil_run(|r| r.domain.as_mut().unwrap().periodic.as_mut().unwrap().components.clear());
    assert_eq!(error, "`open.run.domain.periodic`: has 0 components, must have 2");
    let density = |number| wire::Parameter {
        name: "rest_density_kg_m3".into(),
        value: Some(wire::parameter::Value::Number(number)),
    };
    let error = fluid_refusal(|m| m.parameters[2] = density(0.0));
    assert_eq!(error, "`open.parameters.rest_density_kg_m3`: is 0.0, must be a number above 0");
    let error = fluid_refusal(|m| m.parameters.push(density(1.0)));
    assert_eq!(error, "`open.parameters.rest_density_kg_m3`: is stated twice");
    let error = fluid_refusal(|m| m.parameters[2].name = "surface_tension_n_m".into());
    assert!(error.starts_with("`open.parameters.surface_tension_n_m`: is not a parameter"), "{error}");
    let error = fluid_refusal(|m| m.parameters.clear());
    assert!(error.starts_with("`open.parameters.particle_spacing_m`: is missing"), "{error}");
    let error = spoil_run(|r| r.time.as_mut().unwrap().end_time_s = Some(-1.0));
    assert!(error.contains("`open.run.time.end_time_s`: is -1.0, must not lie before"), "{error}");
    let error = spoil_run(|r| {
        r.time.as_mut().unwrap().step = Some(wire::time_plan::Step::Adaptive(wire::AdaptiveStep {
            factor: Some(0.5),
            maximum_s: Some(1.0),
            growth: Some(1.0),
        }));
    });
    assert!(error.contains("`open.run.time.adaptive.growth`: is 1.0, must be above 1"), "{error}");
    let error = spoil_run(|r| {
        r.domain.as_mut().unwrap().upper_m = Some(wire::Vector { components: vec![-1.0, 1.0] })
    });
    assert!(error.contains("must exceed lower_m"), "{error}");
    let error = spoil_run(|r| r.time.as_mut().unwrap().end_time_s = None);
    assert_eq!(error, "`open.run.time.end_time_s`: is missing, must be finite");
    assert!(spoil_run(|r| r.run_id.clear()).contains("`open.run.run_id`: is empty"));
    assert!(spoil_run(|r| r.run_id = "x".repeat(300)).contains("has 300 bytes, at most 256"));
    assert!(spoil_run(|r| r.ledger.as_mut().unwrap().action = 0).contains("is 0, must be one of"));
    assert!(spoil_run(|r| r.time = None).contains("`open.run.time`: is missing"));
    let error = solid_refusal(|m| m.bodies[1].supports[1].release_time_s = Some(f64::INFINITY));
    assert!(error.contains("`open.bodies[1].supports[1].release_time_s`: is inf"), "{error}");
    let fixed = |count| wire::Substeps { count: Some(wire::substeps::Count::Fixed(count)) };
    for count in [0, 3] {
        let error = solid_refusal(|m| m.substeps = Some(fixed(count)));
        assert_eq!(error, format!("`open.substeps.fixed`: is {count}, must be even and at least 2"));
    }
    let error = solid_refusal(|m| m.bodies[2].formulation = "shell".into());
    let allowed = "\"total-lagrangian\", \"updated-lagrangian\", \"rigid\"";
    assert_eq!(error, format!("`open.bodies[2].formulation`: is \"shell\", must be {allowed}"));
}

#[test]
fn wrong_arrays_are_refused_by_path() {
    let particles = |m: &mut wire::FluidSetup| m.particles.clone().unwrap();
    let error = fluid_refusal(|m| {
        let mut p = particles(m);
        p.velocities_m_per_s = p.velocities_m_per_s.slice(8..);
        m.particles = Some(p);
    });
    assert!(
        error.contains("`open.particles.velocities_m_per_s`: has 632 bytes, must have 40 particles"),
        "{error}"
    );
    let error = fluid_refusal(|m| {
        let mut p = particles(m);
        p.ids = Bytes::from(vec![0; 160]);
        m.particles = Some(p);
    });
    assert!(error.contains("`open.particles.ids`: must ascend strictly"), "{error}");
    let error = fluid_refusal(|m| m.regions.truncate(1));
    assert!(error.contains("there are 1 regions"), "{error}");
    let error = fluid_refusal(|m| {
        m.walls.truncate(1);
        m.probes.clear();
    });
    assert!(error.contains("`open.wall_particles.walls`: of particle number 1 is 1"), "{error}");
    let error = solid_refusal(|m| m.particles.as_mut().unwrap().supports = Bytes::from(vec![1; 160]));
    assert!(error.contains("but body 0 has 0 supports"), "{error}");
    let error = solid_refusal(|m| {
        let mut bodies = vec![0_u8; 160];
        bodies[0] = 1;
        m.particles.as_mut().unwrap().bodies = bodies.into();
    });
    assert!(error.contains("must be in the order of bodies"), "{error}");
}

#[test]
fn probes_must_point_at_what_exists() {
    use wire::probe_argument::Value;
    let index = |k| Some(Value::Index(k));
    let error = fluid_refusal(|m| m.probes[3].arguments[0].value = index(2));
    assert!(error.contains("`open.probes[3].region`: is 2, but there are 2 regions"), "{error}");
    let error = fluid_refusal(|m| m.probes[5].arguments[0].value = index(2));
    assert!(error.contains("`open.probes[5].wall`"), "{error}");
    let error = fluid_refusal(|m| m.probes[0].kind = "depth".into());
    assert!(error.contains("`open.probes[0].kind`: is \"depth\", must be \"fluid-point\""), "{error}");
    let error = fluid_refusal(|m| m.probes[0].arguments.clear());
    assert!(error.contains("`open.probes[0].at_m`: is missing"), "{error}");
    let error = fluid_refusal(|m| m.probes[0].arguments[0].name = "z_m".into());
    assert!(error.contains("`open.probes[0].z_m`: is no argument of the kind `fluid-point`"), "{error}");
    let error = fluid_refusal(|m| m.probes[0].columns.truncate(1));
    assert!(error.contains("`open.probes[0].columns`"), "{error}");
    for (probe, argument, value) in [(1, 0, 3), (4, 0, u32::MAX), (3, 1, 2), (3, 0, 0)] {
        let error = solid_refusal(|m| m.probes[probe].arguments[argument].value = index(value));
        assert!(error.contains(&format!("`open.probes[{probe}].")), "{error}");
    }
}
