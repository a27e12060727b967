//! The set-up of a participant, of the plane or of space: `RunSetup.dimensions` decides.

use prost::Message;
use sph::setup::ParticipantSetup;
use sph::space::AnySpace;

use super::run::dimensions_from_wire;
use super::{Convert, Path, WireError};
use crate::wire;
use crate::wire::open_request::Setup;

/// A set-up as it travels, whatever its space.
pub(crate) trait SetupMessage {
    /// The part that both participants receive.
    fn run(&self) -> Option<&wire::RunSetup>;
}

impl SetupMessage for wire::FluidSetup {
    fn run(&self) -> Option<&wire::RunSetup> {
        self.run.as_ref()
    }
}

impl SetupMessage for wire::SolidSetup {
    fn run(&self) -> Option<&wire::RunSetup> {
        self.run.as_ref()
    }
}

impl<P, S> Convert for AnySpace<P, S>
where
    P: Convert<Wire: SetupMessage>,
    S: Convert<Wire = P::Wire>,
{
    type Wire = P::Wire;

    fn to_wire(&self) -> P::Wire {
        match self {
            AnySpace::Plane(setup) => setup.to_wire(),
            AnySpace::Spatial(setup) => setup.to_wire(),
        }
    }

    fn from_wire(wire: &P::Wire, at: &Path<'_>) -> Result<Self, WireError> {
        let run = at.field("run");
        let message = wire.run().ok_or_else(|| run.error("is missing"))?;
        Ok(match dimensions_from_wire(message, &run)? {
            AnySpace::Plane(_) => AnySpace::Plane(P::from_wire(wire, at)?),
            AnySpace::Spatial(_) => AnySpace::Spatial(S::from_wire(wire, at)?),
        })
    }
}

/// The set-up of an `Open`.
pub(crate) fn decode_setup(setup: &Setup) -> Result<ParticipantSetup, WireError> {
    let root = Path::root("open");
    Ok(match setup {
        Setup::Fluid(fluid) => ParticipantSetup::Fluid(Convert::from_wire(fluid, &root.field("fluid"))?),
        Setup::Solid(solid) => ParticipantSetup::Solid(Convert::from_wire(solid, &root.field("solid"))?),
    })
}

/// `setup` as bytes, to be decoded by another process of the same solver.
pub fn encoded_setup(setup: &ParticipantSetup) -> Vec<u8> {
    let setup = Some(encode_setup(setup));
    wire::OpenRequest { setup, ..wire::OpenRequest::default() }.encode_to_vec()
}

/// The set-up of which `bytes` are those of [`encoded_setup`].
///
/// # Errors
/// When they are not.
pub fn decoded_setup(bytes: &[u8]) -> Result<ParticipantSetup, String> {
    let request = wire::OpenRequest::decode(bytes).map_err(|error| error.to_string())?;
    let setup = request.setup.ok_or("`open.setup`: is missing")?;
    decode_setup(&setup).map_err(|error| error.to_string())
}

/// The message of `setup` in an `Open`.
pub(crate) fn encode_setup(setup: &ParticipantSetup) -> Setup {
    match setup {
        ParticipantSetup::Fluid(fluid) => Setup::Fluid(fluid.to_wire()),
        ParticipantSetup::Solid(solid) => Setup::Solid(solid.to_wire()),
    }
}
