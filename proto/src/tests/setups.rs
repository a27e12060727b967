//! Set-ups travel bit for bit.

use sph::coupling::solver::Role;
use sph::setup::{
    BodyForce, BodySetup, BreachAction, ContactLaw, CouplingKind, Damping, ElasticParameters,
    FluidParameters, FluidProbe, FluidProbeKind, FluidSetup, Formulation, GradientCorrection, InterfaceLaw,
    LoadLaw, Motion, Outflow, ParticipantSetup, RepulsionParameters, RunSetup, SolidProbe, SolidProbeKind,
    SolidSetup, SolidStepping, StepPolicy, SubstepCount, Support, SurfaceLoad, TotalLagrangian,
    UpdatedLagrangian, ViscousForm, WallCondition, WallParticles, WallSetup,
};
use sph::space::components::Components;
use sph::space::{Plane, Space, Spatial};

use super::fake;
use crate::convert::{Convert, Path};

/// The components that `S` has.
fn vector<S: Space>(components: [f64; 3]) -> S::Vector {
    S::vector(S::axes(|axis| components[axis]))
}

fn texts<S: Space>(components: [&str; 3]) -> S::PerAxis<String> {
    S::per_axis(|axis| components[axis].to_owned())
}

fn motion<S: Space>() -> Motion<S> {
    let axis = if S::DIMENSIONS == 2 { vec![1.0] } else { vec![0.6, -0.0, -0.8] };
    Motion {
        displacement: texts::<S>(["0.1*sin(t)", "", "t^2"]),
        angle: "t^2".into(),
        axis: S::Spin::of_row(&axis).unwrap(),
        pivot: vector::<S>([-0.0, 0.5, 5e-324]),
    }
}

fn walls<S: Space>() -> Vec<WallSetup<S>> {
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

fn wall_particles<S: Space>() -> WallParticles<S> {
    let vectors = |all: [[f64; 3]; 3]| all.map(vector::<S>).to_vec();
    WallParticles {
        wall: vec![0, 1, 1],
        position: vectors([[0.1, -0.0, 0.2], [5e-324, 1e300, -1.0], [0.0; 3]]),
        normal: vectors([[0.0, 1.0, -0.0], [0.0; 3], [-1.0, -0.0, 0.0]]),
    }
}

fn run<S: Space>(step: StepPolicy, law: InterfaceLaw, correction: GradientCorrection) -> RunSetup<S> {
    let mut run = fake::run_setup::<S>("run", 3);
    run.time.step = step;
    run.domain.periodic = S::axes(|axis| axis != 1);
    run.ledger.action = BreachAction::Warn;
    run.outputs.probe_interval = None;
    run.body_force = BodyForce {
        gravity: vector::<S>([-0.0, -9.81, 5e-324]),
        expressions: Some(texts::<S>(["x*t", "0", "z"])),
    };
    let coupling = run.coupling.as_mut().unwrap();
    coupling.law = law;
    coupling.fluid.correction = correction;
    if law == InterfaceLaw::WallNoSlip {
        coupling.kind = CouplingKind::Loads;
        coupling.implicit = Some(fake::IMPLICIT);
    }
    run
}

pub(super) fn fluid<S: Space>() -> FluidSetup<S> {
    let policy = StepPolicy::Adaptive {
        factor: 1.0,
        maximum: f64::INFINITY,
        growth: 1.05,
        exact: Some(vec![0.25, 1.0]),
    };
    let run = run(policy, InterfaceLaw::WallNoSlip, GradientCorrection::Renormalised);
    let mut setup = fake::fluid_setup::<S>(run);
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
    setup.particles.velocity[0] = vector::<S>([-0.0, 5e-324, -1.0]);
    setup.particles.region[5] = 1;
    let kinds = [
        FluidProbeKind::Point(vector::<S>([0.1, -0.0, 0.3])),
        FluidProbeKind::WaterLevel(-0.0),
        FluidProbeKind::Front,
        FluidProbeKind::Region(Some(1)),
        FluidProbeKind::Region(None),
        FluidProbeKind::WallForce(1),
        FluidProbeKind::Immersed,
        FluidProbeKind::Gauge(vector::<S>([0.1, -0.0, 0.3]), 1),
    ];
    setup.probes = kinds
        .into_iter()
        .enumerate()
        .map(|(k, kind)| FluidProbe { name: format!("probe {k}"), kind })
        .collect();
    setup.outflow = Outflow { lower: S::axes(|axis| axis == 1), upper: S::axes(|axis| axis != 1) };
    setup
}

pub(super) fn solid<S: Space>() -> SolidSetup<S> {
    let policy = StepPolicy::Fixed { time_step: 1e-5 };
    let run = run(policy, InterfaceLaw::PlainSum, GradientCorrection::None);
    let mut setup = fake::solid_setup::<S>(run);
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
            Support {
                name: "root".into(),
                held: S::per_axis(|_| true),
                motion: None,
                pivot: None,
                release_time: None,
            },
            Support {
                name: "hand".into(),
                held: S::per_axis(|axis| axis == 1),
                motion: Some(motion()),
                pivot: None,
                release_time: Some(0.2),
            },
            Support {
                name: "hinge".into(),
                held: S::per_axis(|_| false),
                motion: None,
                pivot: Some(vector::<S>([0.1, -0.0, 0.3])),
                release_time: None,
            },
        ],
        acceleration: Some(texts::<S>(["0", "-9.81*t", "z"])),
        loads: vec![
            SurfaceLoad {
                name: "wind".into(),
                law: LoadLaw::Pressure("1000*sin(t)".into()),
                particles: vec![0],
                areas: vec![vector::<S>([-0.0, 0.01, 0.02])],
            },
            SurfaceLoad {
                name: "rope".into(),
                law: LoadLaw::Traction(texts::<S>(["1", "t*x", "0"])),
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
    let stress = [-0.0, 5e-324, -1.0 / 3.0, 4.0, -5.0, 0.1 + 0.2];
    setup.particles.deviatoric_stress[last] =
        S::SymmetricTensor::of_row(&stress[..S::SymmetricTensor::COUNT]).unwrap();
    setup.particles.reference_position[last] = vector::<S>([-0.0, 7.0, 8.0]);
    setup.contact = ContactLaw::Repulsion(RepulsionParameters {
        stiffness: 0.1,
        damping: 0.0,
        friction: 0.3,
        ..RepulsionParameters::default()
    });
    setup.walls = walls();
    setup.wall_particles = wall_particles();
    let kinds = [
        SolidProbeKind::MaterialPoint(1, vector::<S>([-0.0, 1.0, 0.5])),
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

fn set_ups_travel<S: Space>() {
    let (fluid, solid) = (fluid::<S>(), solid::<S>());
    assert_same("fluid", &carried(&fluid), &fluid);
    assert_same("solid", &carried(&solid), &solid);
}

#[test]
fn set_ups_travel_bit_for_bit() {
    // `Debug` of a float tells all its bits but those of NaN, and -0.0 from 0.0, unlike ==.
    set_ups_travel::<Plane>();
    set_ups_travel::<Spatial>();
    for role in [Role::Fluid, Role::Solid] {
        let setup = fake::alone(role, "alone", 1);
        assert_same("as bytes", &crate::decoded_setup(&crate::encoded_setup(&setup)).unwrap(), &setup);
        match setup {
            ParticipantSetup::Fluid(setup) => assert_eq!(carried(&setup), setup),
            ParticipantSetup::Solid(setup) => assert_eq!(carried(&setup), setup),
        }
    }
}
