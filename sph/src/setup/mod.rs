//! Set-up of a run: plain data in SI units, mirrored by the set-up messages of the protocol.
//!
//! The coordinator makes these from a case file; nothing in here is checked again by the solvers beyond what the
//! conversion from the wire enforces. In two dimensions masses and forces are per metre of depth.

mod fluid;
mod implicit;
mod parameter_spec;
mod parameters;
mod probes;
mod run;
mod solid;
mod solid_particles;
mod walls;

pub use fluid::*;
pub use implicit::*;
pub use parameter_spec::{Allowed, Choice, Kind, ParameterError, ParameterSpec, Value};
pub use parameters::{ParameterSet, ParameterType};
pub use probes::*;
pub use run::*;
pub use solid::*;
pub use solid_particles::*;
pub use walls::*;

pub(crate) use parameters::choices;

use crate::in_space;
use crate::space::{AnySpace, Plane, Spatial};

/// Set-up of a fluid solver, of the plane or of space.
pub type AnyFluidSetup = AnySpace<FluidSetup<Plane>, FluidSetup<Spatial>>;

/// Set-up of a solid solver, of the plane or of space.
pub type AnySolidSetup = AnySpace<SolidSetup<Plane>, SolidSetup<Spatial>>;

/// Set-up of either participant.
#[derive(Clone, Debug, PartialEq)]
pub enum ParticipantSetup {
    /// For a fluid solver.
    Fluid(AnyFluidSetup),
    /// For a solid solver.
    Solid(AnySolidSetup),
}

impl ParticipantSetup {
    /// The part that both participants receive alike.
    pub fn plan(&self) -> RunPlan {
        match self {
            Self::Fluid(setup) => in_space!(setup, setup => setup.run.plan()),
            Self::Solid(setup) => in_space!(setup, setup => setup.run.plan()),
        }
    }

    /// Name of the run.
    pub fn run_id(&self) -> &str {
        match self {
            Self::Fluid(setup) => in_space!(setup, setup => &setup.run.run_id),
            Self::Solid(setup) => in_space!(setup, setup => &setup.run.run_id),
        }
    }

    /// Number of dimensions.
    pub fn dimensions(&self) -> usize {
        match self {
            Self::Fluid(setup) => setup.dimensions(),
            Self::Solid(setup) => setup.dimensions(),
        }
    }

    /// Chooses the kind of coupling; changes nothing in a run with one participant.
    pub fn set_coupling_kind(&mut self, kind: CouplingKind) {
        let coupling = match self {
            Self::Fluid(setup) => in_space!(setup, setup => &mut setup.run.coupling),
            Self::Solid(setup) => in_space!(setup, setup => &mut setup.run.coupling),
        };
        if let Some(coupling) = coupling {
            coupling.kind = kind;
        }
    }
}
