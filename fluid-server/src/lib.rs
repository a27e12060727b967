//! The service around the fluid solver, whose physics is the crate `fluid`.

use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::Arc;

use proto::description::{Constants, Description, Fact};
use proto::service::{Opened, SetupProblems, SolverFactory};
use sph::coupling::solver::{Role, Solver};
use sph::in_space;
use sph::lanes::Arithmetic;
use sph::setup::{AnyFluidSetup, Coupling, ParameterSet, ParticipantSetup};
use sph::space::AnySpace;

/// Makes fluid solvers for the service.
#[derive(Clone, Default)]
pub struct FluidFactory {
    parts: Parts,
}

/// Makes the solver of a set-up, or says all that is wrong with it.
type Maker = dyn Fn(AnyFluidSetup) -> Result<Box<dyn Solver>, Vec<String>> + Send + Sync;

/// The parts in which a fluid is computed.
#[derive(Clone, Default)]
enum Parts {
    /// One.
    #[default]
    One,
    /// So many threads of this process.
    Threads(usize),
    /// Those of another program that serves fluids.
    Others(Arc<Maker>),
}

impl FluidFactory {
    /// Makes solvers in `parts` threads, each with its own particles; see [`fluid::in_threads`].
    pub fn in_threads(parts: usize) -> Self {
        Self { parts: if parts > 1 { Parts::Threads(parts) } else { Parts::One } }
    }

    /// Serves the solvers that `make` makes, such as those in several processes.
    pub fn made_by(
        make: impl Fn(AnyFluidSetup) -> Result<Box<dyn Solver>, Vec<String>> + Send + Sync + 'static,
    ) -> Self {
        Self { parts: Parts::Others(Arc::new(make)) }
    }
}

impl SolverFactory for FluidFactory {
    fn describe(&self) -> Description {
        let version = env!("CARGO_PKG_VERSION");
        let description = Description::of_solver(
            "fluid-server",
            version,
            Role::Fluid,
            &[2, 3],
            Arithmetic::chosen().name(),
        );
        Description { build: env!("TIDELOCK_BUILD").into(), ..description }
    }

    fn open(&self, setup: ParticipantSetup) -> Result<Opened, SetupProblems> {
        let ParticipantSetup::Fluid(setup) = setup else {
            return Err(SetupProblems(vec!["`open.setup`: is for a solid, must be for a fluid".into()]));
        };
        let (run, parameters) = in_space!(&setup, setup => (setup.run.plan(), setup.parameters));
        let fluid = parameters.of_pair_law();
        let mut constants = Constants::of(&run);
        // The fluid computes with its own constants, whatever the set-up of the interface says.
        constants.coupling = constants.coupling.map(|coupling| Coupling { fluid, ..coupling });
        let facts = [
            ("rest_density", fluid.rest_density, "kg/m3"),
            ("sound_speed", fluid.sound_speed, "m/s"),
            ("smoothing_length", fluid.smoothing_length(), "m"),
            ("particle_spacing", fluid.particle_spacing, "m"),
        ];
        let facts =
            facts.map(|(name, value, unit)| Fact { name: name.into(), value, unit: unit.into() }).into();
        let solver = match (&self.parts, setup) {
            (Parts::One, AnySpace::Plane(setup)) => fluid::plane_solver(setup),
            (Parts::One, AnySpace::Spatial(setup)) => fluid::spatial_solver(setup),
            (Parts::Threads(parts), setup) => fluid::in_threads(setup, *parts),
            (Parts::Others(make), setup) => make(setup),
        };
        let solver = solver.map_err(SetupProblems)?;
        Ok(Opened { solver, constants, facts, bodies: Vec::new() })
    }
}

/// Runs the server program on `args`, the program's name first; see [`proto::transport::node::NodeArgs`].
pub fn main_with(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    proto::transport::node::main_with(args, FluidFactory::default())
}
