//! The service around the solid solver of crate `solid`.

use std::ffi::OsString;
use std::process::ExitCode;

use proto::description::{BodyReport, Constants, Description, Fact};
use proto::service::{Opened, SetupProblems, SolverFactory};
use sph::coupling::solver::Role;
use sph::lanes::Arithmetic;
use sph::setup::{Coupling, ParticipantSetup};

/// Makes solid solvers for the service.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolidFactory;

impl SolverFactory for SolidFactory {
    fn describe(&self) -> Description {
        let version = env!("CARGO_PKG_VERSION");
        let description =
            Description::of_solver("solid-server", version, Role::Solid, Arithmetic::chosen().name());
        Description { build: env!("TIDELOCK_BUILD").into(), ..description }
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let ParticipantSetup::Solid(setup) = setup else {
            return Err(SetupProblems(vec!["`open.setup`: is for a fluid, must be for a solid".into()]));
        };
        let mut constants = Constants::of(&setup.run);
        // The solid computes with its own spacing, whatever the coupling constants say.
        let solid_spacing = setup.particle_spacing;
        constants.coupling = constants.coupling.map(|coupling| Coupling { solid_spacing, ..coupling });
        let mut facts =
            vec![Fact { name: "particle_spacing".into(), value: solid_spacing, unit: "m".into() }];
        for body in &setup.bodies {
            let material = &body.material;
            facts.extend(
                [
                    ("density", material.density, "kg/m3"),
                    ("bulk_modulus", material.bulk_modulus, "Pa"),
                    ("shear_modulus", material.shear_modulus, "Pa"),
                    ("longitudinal_speed", material.longitudinal_speed(), "m/s"),
                ]
                .map(|(name, value, unit)| Fact {
                    name: format!("{}.{name}", body.name),
                    value,
                    unit: unit.into(),
                }),
            );
        }
        let solver = solid::SolidSolver::new(setup).map_err(SetupProblems)?;
        let bodies = solver.masses().map(|(mass, inertia)| BodyReport { mass, inertia }).collect();
        Ok(Opened { solver: Box::new(solver), constants, facts, bodies })
    }
}

/// Runs the server program on `args`, the program's name first; see [`proto::transport::node::NodeArgs`].
pub fn main_with(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    proto::transport::node::main_with(args, SolidFactory)
}
