//! The service around the solid solver of crate `solid`.

use std::ffi::OsString;
use std::process::ExitCode;

use proto::description::{BodyReport, Constants, Description, Fact, Inertia};
use proto::service::{Opened, SetupProblems, SolverFactory};
use solid::Built;
use sph::coupling::solver::Role;
use sph::in_space;
use sph::lanes::Arithmetic;
use sph::setup::{Coupling, ElasticParameters, ParticipantSetup, SolidSetup};
use sph::space::tensors::SpaceSymmetric;
use sph::space::{AnySpace, Space, SymmetricTensor3};

/// Numbers of dimensions of the runs that it takes.
const DIMENSIONS: [u32; 2] = [2, 3];

/// Makes solid solvers for the service.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolidFactory;

impl SolverFactory for SolidFactory {
    fn describe(&self) -> Description {
        let version = env!("CARGO_PKG_VERSION");
        let description = Description::of_solver(
            "solid-server",
            version,
            Role::Solid,
            &DIMENSIONS,
            Arithmetic::chosen().name(),
        );
        Description { build: env!("TIDELOCK_BUILD").into(), ..description }
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let ParticipantSetup::Solid(setup) = setup else {
            return Err(SetupProblems(vec!["`open.setup`: is for a fluid, must be for a solid".into()]));
        };
        let (run, solid_spacing) = in_space!(&setup, setup => (setup.run.plan(), setup.particle_spacing));
        let mut constants = Constants::of(&run);
        // The solid computes with its own spacing, whatever the coupling constants say.
        constants.coupling = constants.coupling.map(|coupling| Coupling { solid_spacing, ..coupling });
        let mut facts =
            vec![Fact { name: "particle_spacing".into(), value: solid_spacing, unit: "m".into() }];
        for (name, material) in in_space!(&setup, setup => materials(setup)) {
            facts.extend(
                [
                    ("density", material.density, "kg/m3"),
                    ("bulk_modulus", material.bulk_modulus, "Pa"),
                    ("shear_modulus", material.shear_modulus, "Pa"),
                    ("longitudinal_speed", material.longitudinal_speed(), "m/s"),
                ]
                .map(|(fact, value, unit)| Fact {
                    name: format!("{name}.{fact}"),
                    value,
                    unit: unit.into(),
                }),
            );
        }
        let (solver, bodies) = match setup {
            AnySpace::Plane(setup) => {
                let Built { solver, masses } = solid::plane_solver(setup).map_err(SetupProblems)?;
                (solver, reports(masses, AnySpace::Plane))
            }
            AnySpace::Spatial(setup) => {
                let Built { solver, masses } = solid::spatial_solver(setup).map_err(SetupProblems)?;
                let bodies = reports(masses, |inertia| AnySpace::Spatial(SymmetricTensor3::of(&inertia)));
                (solver, bodies)
            }
        };
        Ok(Opened { solver, constants, facts, bodies })
    }
}

/// Names and materials of the bodies.
fn materials<S: Space>(setup: &SolidSetup<S>) -> Vec<(String, ElasticParameters)> {
    setup.bodies.iter().map(|body| (body.name.clone(), body.material)).collect()
}

/// Masses and inertias as the equations of motion use them.
fn reports<I>(masses: Vec<(f64, Option<I>)>, inertia: impl Fn(I) -> Inertia) -> Vec<BodyReport> {
    masses.into_iter().map(|(mass, own)| BodyReport { mass, inertia: own.map(&inertia) }).collect()
}

/// Runs the server program on `args`, the program's name first; see [`proto::transport::node::NodeArgs`].
pub fn main_with(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    proto::transport::node::main_with(args, SolidFactory)
}
