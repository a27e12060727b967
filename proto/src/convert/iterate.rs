//! Iterated half-steps: how they are asked for, and the word that ends one.

use sph::coupling::exchange::Acceptance;
use sph::setup::{Iterate, Relaxation, Unsettled};

use super::{Choice, Convert, Path, WireError, choice, positive};
use crate::wire;

/// Most iterations that a set-up may ask for.
const MOST_ITERATIONS: u32 = 1000;

impl Choice for Unsettled {
    const ALL: &'static [Self] = &[Unsettled::Stop, Unsettled::Accept];

    fn code(self) -> i32 {
        let wire = match self {
            Unsettled::Stop => wire::Unsettled::Stop,
            Unsettled::Accept => wire::Unsettled::Accept,
        };
        wire.into()
    }
}

impl Convert for Iterate {
    type Wire = wire::Iterate;

    fn to_wire(&self) -> wire::Iterate {
        wire::Iterate {
            factor: match self.relaxation {
                Relaxation::Fixed(factor) => Some(factor),
                Relaxation::Aitken => None,
            },
            tolerance: Some(self.tolerance),
            limit: self.limit,
            unsettled: self.unsettled.code(),
        }
    }

    fn from_wire(wire: &wire::Iterate, at: &Path<'_>) -> Result<Self, WireError> {
        let factor = wire.factor.map(|factor| positive(factor, &at.field("factor"))).transpose()?;
        if let Some(factor) = factor.filter(|factor| *factor > 1.0) {
            return Err(at.field("factor").error(format!("is {factor:?}, must be above 0 and at most 1")));
        }
        if !(1..=MOST_ITERATIONS).contains(&wire.limit) {
            let problem = format!("is {}, must be 1 to {MOST_ITERATIONS}", wire.limit);
            return Err(at.field("limit").error(problem));
        }
        Ok(Self {
            relaxation: factor.map_or(Relaxation::Aitken, Relaxation::Fixed),
            tolerance: positive(wire.tolerance, &at.field("tolerance"))?,
            limit: wire.limit,
            unsettled: choice(wire.unsettled, &at.field("unsettled"))?,
        })
    }
}

impl Convert for Acceptance {
    type Wire = wire::Acceptance;

    fn to_wire(&self) -> wire::Acceptance {
        wire::Acceptance { settled: self.settled, residual: Some(self.residual) }
    }

    fn from_wire(wire: &wire::Acceptance, at: &Path<'_>) -> Result<Self, WireError> {
        let at = at.field("residual");
        let residual = wire.residual.ok_or_else(|| at.error("is missing"))?;
        if residual < 0.0 {
            return Err(at.error(format!("is {residual:?}, must not be negative")));
        }
        Ok(Self { settled: wire.settled, residual })
    }
}
