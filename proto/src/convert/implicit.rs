//! Implicit coupling: its parameters, and the message that ends the iterations of a half-step.

use sph::coupling::exchange::Acceptance;
use sph::setup::{ImplicitCoupling, NonConvergence, Relaxation};

use super::{Choice, Convert, Path, WireError, choice, positive};
use crate::wire;

/// Most iterations that a set-up may ask for.
const MOST_ITERATIONS: u32 = 1000;

choices!(NonConvergence = wire::NonConvergence { Stop, Accept });

impl Convert for ImplicitCoupling {
    type Wire = wire::ImplicitCoupling;

    fn to_wire(&self) -> wire::ImplicitCoupling {
        wire::ImplicitCoupling {
            factor: match self.relaxation {
                Relaxation::Fixed(factor) => Some(factor),
                Relaxation::Aitken => None,
            },
            tolerance: Some(self.tolerance),
            limit: self.limit,
            non_convergence: self.non_convergence.code(),
        }
    }

    fn from_wire(wire: &wire::ImplicitCoupling, at: &Path<'_>) -> Result<Self, WireError> {
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
            non_convergence: choice(wire.non_convergence, &at.field("non_convergence"))?,
        })
    }
}

impl Convert for Acceptance {
    type Wire = wire::Acceptance;

    fn to_wire(&self) -> wire::Acceptance {
        wire::Acceptance { converged: self.converged, residual: Some(self.residual) }
    }

    fn from_wire(wire: &wire::Acceptance, at: &Path<'_>) -> Result<Self, WireError> {
        let at = at.field("residual");
        let residual = wire.residual.ok_or_else(|| at.error("is missing"))?;
        if residual < 0.0 {
            return Err(at.error(format!("is {residual:?}, must not be negative")));
        }
        Ok(Self { converged: wire.converged, residual })
    }
}
