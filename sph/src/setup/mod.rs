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
mod walls;

pub use fluid::*;
pub use implicit::*;
pub use parameter_spec::{Allowed, Choice, Kind, ParameterError, ParameterSpec, Value};
pub use parameters::{ParameterSet, ParameterType};
pub use probes::*;
pub use run::*;
pub use solid::*;
pub use walls::*;

pub(crate) use parameters::choices;

/// Set-up of either participant.
#[derive(Clone, Debug, PartialEq)]
pub enum ParticipantSetup {
    /// For a fluid solver.
    Fluid(FluidSetup),
    /// For a solid solver.
    Solid(SolidSetup),
}

impl ParticipantSetup {
    /// The part that both participants receive alike.
    pub fn run(&self) -> &RunSetup {
        match self {
            Self::Fluid(setup) => &setup.run,
            Self::Solid(setup) => &setup.run,
        }
    }

    /// Chooses the kind of coupling; changes nothing in a run with one participant.
    pub fn set_coupling_kind(&mut self, kind: CouplingKind) {
        let run = match self {
            Self::Fluid(setup) => &mut setup.run,
            Self::Solid(setup) => &mut setup.run,
        };
        if let Some(coupling) = &mut run.coupling {
            coupling.kind = kind;
        }
    }
}
