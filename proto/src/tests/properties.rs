//! Properties of conversions: whatever a message may hold goes through bytes and back with all its bits.

use proptest::prelude::*;
use sph::coupling::exchange::{Column, Extent, Frame, PreviousStage, StateColumns};
use sph::coupling::ledger::{InterfaceSums, LedgerVector};
use sph::coupling::solver::Role;
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{
    BodySetup, ContactLaw, CouplingKind, ElasticParameters, FluidParameters, FluidParticles, Formulation,
    InterfaceLaw, Kind, ParameterSet, ParameterSpec, ParticipantSetup, RepulsionParameters, SolidParticles,
    TotalLagrangian, UpdatedLagrangian, Value,
};
use sph::space::{SymmetricTensor, Vector};

use super::fake;
use crate::convert::{Convert, FrameReader, FrameWriter, Path, ReceivedFrame};
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

fn vectors() -> impl Strategy<Value = Vector> {
    (numbers(), numbers()).prop_map(|(x, y)| Vector::new(x, y))
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

fn fluid_particles() -> impl Strategy<Value = FluidParticles> {
    ids().prop_flat_map(|id| {
        let n = id.len();
        let each = prop::collection::vec((positive(), positive(), vectors(), vectors()), n);
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

fn solid_particles() -> impl Strategy<Value = SolidParticles> {
    fluid_particles().prop_flat_map(|fluid| {
        let n = fluid.id.len();
        let stress = prop::collection::vec((numbers(), numbers(), numbers()), n);
        let reference = prop::collection::vec(vectors(), n);
        (stress, reference).prop_map(move |(stress, reference_position)| SolidParticles {
            // The ids of a solid count its particles.
            id: (0..n as u32).collect(),
            body: vec![0; n],
            support: vec![0; n],
            mass: fluid.mass.clone(),
            reference_position,
            position: fluid.position.clone(),
            velocity: fluid.velocity.clone(),
            density: fluid.density.clone(),
            deviatoric_stress: stress
                .iter()
                .map(|(xx, yy, xy)| SymmetricTensor { xx: *xx, yy: *yy, xy: *xy })
                .collect(),
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

fn frames() -> impl Strategy<Value = Frame> {
    let row = (positive(), positive(), numbers(), [numbers(), numbers()], [numbers(), numbers()]);
    let stress = [numbers(), numbers(), numbers()];
    let rows = ids().prop_flat_map(move |id| {
        let n = id.len();
        (Just(id), prop::collection::vec((row.clone(), stress.clone(), 0..9u32), n))
    });
    (rows, any::<u64>(), positive(), numbers(), any::<u32>(), 0..1000u64).prop_map(
        |((id, rows), version, reach, sum, used_digest, step)| Frame {
            states: StateColumns {
                id,
                group: rows.iter().map(|(_, _, group)| *group).collect(),
                mass: rows.iter().map(|(row, ..)| row.0).collect(),
                density: rows.iter().map(|(row, ..)| row.1).collect(),
                pressure: rows.iter().map(|(row, ..)| row.2).collect(),
                position: rows.iter().map(|(row, ..)| row.3).collect(),
                velocity: rows.iter().map(|(row, ..)| row.4).collect(),
                stress: rows.iter().map(|(_, stress, _)| *stress).collect(),
            },
            set_version: version,
            extent: Extent { version: 7, boxes: Column::from_iter([[-1.0, -0.0, 1.0, 0.5]]) },
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn fluids_travel_bit_for_bit(parameters in sets::<FluidParameters>(), particles in fluid_particles()) {
        let ParticipantSetup::Fluid(mut setup) = fake::setup(Role::Fluid, "run", 3) else { panic!() };
        // The pair law states the same fluid.
        setup.run.coupling.as_mut().unwrap().fluid = parameters.of_pair_law();
        (setup.parameters, setup.particles) = (parameters, particles);
        prop_assert_eq!(carried(&setup), format!("{setup:?}"));
    }

    #[test]
    fn solids_travel_bit_for_bit(
        particles in solid_particles(),
        material in sets::<ElasticParameters>(),
        formulation in formulations(),
        contact in sets::<RepulsionParameters>(),
    ) {
        let ParticipantSetup::Solid(mut setup) = fake::setup(Role::Solid, "run", 3) else { panic!() };
        setup.bodies = vec![BodySetup { material, formulation, ..setup.bodies[0].clone() }];
        setup.contact = ContactLaw::Repulsion(contact);
        setup.particles = particles;
        prop_assert_eq!(carried(&setup), format!("{setup:?}"));
    }

    #[test]
    fn frames_travel_bit_for_bit(frame in frames()) {
        let fields = FrameField::sent_by(Role::Solid, InterfaceLaw::PlainSum, CouplingKind::States);
        let message = FrameWriter::new("run", 0, fields, 0).write(&frame);
        let encoded = prost::Message::encode_to_vec(&message);
        let message: wire::Frame = prost::Message::decode(encoded.as_slice()).unwrap();
        let mut received = Frame::empty(frame.time);
        let extent = Extent { version: 0, boxes: Column::default() };
        let read = FrameReader::new("run", 0, fields, extent).read(&message, frame.time.at, &mut received);
        prop_assert_eq!(read, Ok(ReceivedFrame::Frame));
        prop_assert_eq!(format!("{received:?}"), format!("{frame:?}"));
    }
}
