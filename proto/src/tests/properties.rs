//! Properties of conversions: whatever a message may hold goes through bytes and back with all its bits.

use proptest::prelude::*;
use sph::coupling::exchange::{Column, Extent, Frame, PreviousStage, StateColumns};
use sph::coupling::ledger::{InterfaceSums, LedgerVector};
use sph::coupling::solver::Role;
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{
    BodySetup, ContactLaw, CouplingKind, ElasticParameters, FluidParameters, FluidParticles, FluidProbe,
    FluidProbeKind, Formulation, InterfaceLaw, Kind, ParameterSet, ParameterSpec, RepulsionParameters,
    SolidParticles, SolidProbe, SolidProbeKind, TotalLagrangian, UpdatedLagrangian, Value,
};
use sph::space::components::Components;
use sph::space::{Plane, Space, Spatial};

use super::fake;
use crate::convert::{
    Convert, FrameReader, FrameWriter, Layout, Path, ReceivedFrame, extent_from_wire, extent_to_wire,
};
use crate::description::FrameField;
use crate::wire;

/// Finite numbers of every size, both zeros and subnormal ones among them.
fn numbers() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |number| number.is_finite()),
        prop::sample::select(vec![0.0, -0.0, 5e-324, -f64::MAX, 0.1]),
    ]
}

/// Numbers above 0.
fn positive() -> impl Strategy<Value = f64> + Clone {
    numbers().prop_map(f64::abs).prop_filter("above 0", |number| *number > 0.0)
}

/// As many numbers as a vector or a symmetric tensor has.
fn quantities<C: Components + std::fmt::Debug>() -> impl Strategy<Value = C> {
    let row = prop::collection::vec(numbers(), C::COUNT);
    row.prop_map(|row| C::of_row(&row).unwrap())
}

/// A value that the row `spec` allows, by chance.
fn value_of(spec: &ParameterSpec) -> BoxedStrategy<Value<'static>> {
    match spec.kind {
        Kind::Number(allowed) => (0.0..=1.0f64, numbers())
            .prop_map(move |(share, any)| {
                let between = allowed.lowest + share * (allowed.highest.min(1e9) - allowed.lowest);
                let chosen = [any, any.abs(), between].into_iter().find(|number| allowed.holds(*number));
                Value::Number(chosen.unwrap_or(allowed.fallback()))
            })
            .boxed(),
        Kind::Flag => any::<bool>().prop_map(Value::Flag).boxed(),
        Kind::Count(first, last) => (first..=last).prop_map(Value::Count).boxed(),
        Kind::Choice(words) => (0..words.len()).prop_map(|k| Value::Choice(words[k].0)).boxed(),
    }
}

/// Sets of parameters with every value that their rows allow.
fn sets<T: ParameterSet>() -> impl Strategy<Value = T> {
    let values: Vec<_> = T::SPECIFICATIONS.iter().map(value_of).collect();
    values.prop_map(|values| {
        let mut set = T::default();
        for (spec, value) in T::SPECIFICATIONS.iter().zip(values) {
            set.set(spec.key, value).unwrap();
        }
        set
    })
}

/// Ids, strictly ascending.
fn ids() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::btree_set(any::<u32>(), 1..40).prop_map(|ids| ids.into_iter().collect())
}

fn fluid_particles<S: Space>() -> impl Strategy<Value = FluidParticles<S>> {
    ids().prop_flat_map(|id| {
        let n = id.len();
        let each = prop::collection::vec(
            (positive(), positive(), quantities::<S::Vector>(), quantities::<S::Vector>()),
            n,
        );
        let relaxation = prop_oneof![Just(Vec::new()), prop::collection::vec(numbers(), n)];
        (each, relaxation).prop_map(move |(rows, relaxation)| FluidParticles {
            id: id.clone(),
            region: vec![0; n],
            mass: rows.iter().map(|row| row.0).collect(),
            density: rows.iter().map(|row| row.1).collect(),
            position: rows.iter().map(|row| row.2).collect(),
            velocity: rows.iter().map(|row| row.3).collect(),
            relaxation,
        })
    })
}

fn solid_particles<S: Space>() -> impl Strategy<Value = SolidParticles<S>> {
    fluid_particles::<S>().prop_flat_map(|fluid| {
        let n = fluid.id.len();
        let stress = prop::collection::vec(quantities::<S::SymmetricTensor>(), n);
        let reference = prop::collection::vec(quantities::<S::Vector>(), n);
        (stress, reference).prop_map(move |(deviatoric_stress, reference_position)| SolidParticles {
            // The ids of a solid count its particles.
            id: (0..n as u32).collect(),
            body: vec![0; n],
            support: vec![0; n],
            mass: fluid.mass.clone(),
            reference_position,
            position: fluid.position.clone(),
            velocity: fluid.velocity.clone(),
            density: fluid.density.clone(),
            deviatoric_stress,
        })
    })
}

fn formulations() -> impl Strategy<Value = Formulation> {
    prop_oneof![
        Just(Formulation::Rigid),
        sets::<TotalLagrangian>().prop_map(Formulation::TotalLagrangian),
        sets::<UpdatedLagrangian>().prop_map(Formulation::UpdatedLagrangian),
    ]
}

/// Through bytes and back, as text: `Debug` of a finite float shows all its bits, and -0.0 from 0.0, unlike ==.
fn carried<T: Convert + std::fmt::Debug>(value: &T) -> String
where
    T::Wire: prost::Message + Default,
{
    let encoded = prost::Message::encode_to_vec(&value.to_wire());
    let message: T::Wire = prost::Message::decode(encoded.as_slice()).unwrap();
    format!("{:?}", T::from_wire(&message, &Path::root("open")).unwrap())
}

/// Frames of runs in `S`.
fn frames<S: Space>() -> impl Strategy<Value = Frame> {
    let rows = ids().prop_flat_map(|id| {
        let n = id.len();
        let vectors = (quantities::<S::Vector>(), quantities::<S::Vector>());
        let row = ((positive(), positive(), numbers()), vectors, quantities::<S::SymmetricTensor>(), 0..9u32);
        (Just(id), prop::collection::vec(row, n))
    });
    let corners = [vec![-1.0; S::DIMENSIONS], vec![-0.0; S::DIMENSIONS]].concat();
    let boxes = Column { components: 2 * S::DIMENSIONS, values: corners };
    (rows, any::<u64>(), positive(), numbers(), any::<u32>(), 0..1000u64).prop_map(
        move |((id, rows), version, reach, sum, used_digest, step)| Frame {
            states: StateColumns {
                id,
                group: rows.iter().map(|(.., group)| *group).collect(),
                mass: rows.iter().map(|(row, ..)| row.0).collect(),
                density: rows.iter().map(|(row, ..)| row.1).collect(),
                pressure: rows.iter().map(|(row, ..)| row.2).collect(),
                position: rows.iter().map(|(_, vectors, ..)| vectors.0).collect(),
                velocity: rows.iter().map(|(_, vectors, ..)| vectors.1).collect(),
                stress: rows.iter().map(|(_, _, stress, _)| *stress).collect(),
            },
            set_version: version,
            extent: Extent { version: 7, boxes: boxes.clone() },
            reach,
            time_step_limit: reach,
            previous: Some(PreviousStage {
                at: StepStage { step, stage: Stage::Predictor },
                sums: InterfaceSums { force: LedgerVector::new(sum, -0.0, 0.0), ..InterfaceSums::default() },
                used_digest,
                momentum: None,
            }),
            ..Frame::empty(StageTime {
                at: StepStage { step, stage: Stage::Corrector },
                step_start: sum,
                time_step: reach,
            })
        },
    )
}

/// What becomes of `frame` on its way to the partner.
fn received(frame: &Frame, dimensions: usize) -> String {
    let fields = FrameField::sent_by(Role::Solid, InterfaceLaw::PlainSum, CouplingKind::States);
    let layout = Layout { fields, dimensions };
    let message = FrameWriter::new("run", 0, layout, 0).write(frame);
    let encoded = prost::Message::encode_to_vec(&message);
    let message: wire::Frame = prost::Message::decode(encoded.as_slice()).unwrap();
    let mut received = Frame::empty(frame.time);
    let extent = Extent { version: 0, boxes: Column::default() };
    let read = FrameReader::new("run", 0, layout, extent).read(&message, frame.time.at, &mut received);
    assert_eq!(read, Ok(ReceivedFrame::Frame));
    format!("{received:?}")
}

/// A fluid of `particles`, and the same after its way.
fn fluids<S: Space>(parameters: FluidParameters, particles: FluidParticles<S>) -> [String; 2] {
    let mut setup = fake::fluid_setup(fake::run_setup::<S>("run", 3));
    // The pair law states the same fluid.
    setup.run.coupling.as_mut().unwrap().fluid = parameters.of_pair_law();
    (setup.parameters, setup.particles) = (parameters, particles);
    [carried(&setup), format!("{setup:?}")]
}

/// A solid of `particles` with the material and formulation of `body`, and the same after its way.
fn solids<S: Space>(
    particles: SolidParticles<S>,
    (material, formulation): (ElasticParameters, Formulation),
    contact: RepulsionParameters,
) -> [String; 2] {
    let mut setup = fake::solid_setup(fake::run_setup::<S>("run", 3));
    setup.bodies = vec![BodySetup { material, formulation, ..setup.bodies[0].clone() }];
    setup.contact = ContactLaw::Repulsion(contact);
    setup.particles = particles;
    [carried(&setup), format!("{setup:?}")]
}

/// Probes at a point of `S`, and the same after their way.
fn probes<S: Space>(point: S::Vector) -> [[String; 2]; 3] {
    let fluid = |kind| FluidProbe::<S> { name: "probe".into(), kind };
    let solid = SolidProbe::<S> { name: "probe".into(), kind: SolidProbeKind::MaterialPoint(3, point) };
    let there_and_back = |probe: &FluidProbe<S>| [carried(probe), format!("{probe:?}")];
    [
        there_and_back(&fluid(FluidProbeKind::Point(point))),
        there_and_back(&fluid(FluidProbeKind::FlowRate(point, point * 0.5))),
        [carried(&solid), format!("{solid:?}")],
    ]
}

/// An extent of one box from `lower`, and the same after its way.
fn extents<S: Space>(lower: S::Vector, version: u64) -> [String; 2] {
    let corners = [lower.row().as_ref(), &vec![f64::MAX; S::DIMENSIONS]].concat();
    let boxes = Column { components: 2 * S::DIMENSIONS, values: corners };
    let extent = Extent { version, boxes };
    let back = extent_from_wire(&Some(extent_to_wire(&extent)), S::DIMENSIONS, &Path::root("extent"));
    [format!("{:?}", back.unwrap()), format!("{extent:?}")]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn fluids_travel_bit_for_bit(
        parameters in sets::<FluidParameters>(),
        plane in fluid_particles::<Plane>(),
        spatial in fluid_particles::<Spatial>(),
    ) {
        for [back, setup] in [fluids(parameters, plane), fluids(parameters, spatial)] {
            prop_assert_eq!(back, setup);
        }
    }

    #[test]
    fn solids_travel_bit_for_bit(
        plane in solid_particles::<Plane>(),
        spatial in solid_particles::<Spatial>(),
        body in (sets::<ElasticParameters>(), formulations()),
        contact in sets::<RepulsionParameters>(),
    ) {
        for [back, setup] in [solids(plane, body, contact), solids(spatial, body, contact)] {
            prop_assert_eq!(back, setup);
        }
    }

    #[test]
    fn frames_travel_bit_for_bit(plane in frames::<Plane>(), spatial in frames::<Spatial>()) {
        prop_assert_eq!(received(&plane, 2), format!("{plane:?}"));
        prop_assert_eq!(received(&spatial, 3), format!("{spatial:?}"));
    }

    #[test]
    fn probes_and_extents_travel_bit_for_bit(
        plane in quantities::<<Plane as Space>::Vector>(),
        spatial in quantities::<<Spatial as Space>::Vector>(),
        version in any::<u64>(),
    ) {
        for [back, probe] in probes::<Plane>(plane).into_iter().chain(probes::<Spatial>(spatial)) {
            prop_assert_eq!(back, probe);
        }
        for [back, extent] in [extents::<Plane>(plane, version), extents::<Spatial>(spatial, version)] {
            prop_assert_eq!(back, extent);
        }
    }
}
