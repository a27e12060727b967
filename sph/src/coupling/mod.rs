//! The coupling core: what steps a solver in lock-step with its partner and audits the momentum that they exchange.
//!
//! ```text
//! stage         half-steps, the clock, outputs that are due
//! ledger        momentum budget of a half-step and its checks
//! solver        what the core asks of a solver
//! exchange      frames and the trait that carries them        extent   where particles may meet the partner
//! audit         whether what a partner sends agrees with itself
//! fixed_point   relaxed forces of implicit coupling           role     who sends what
//! driver        the loop over half-steps                      saved    state as named arrays
//! ```

pub mod audit;
pub mod driver;
pub mod exchange;
pub mod extent;
pub(crate) mod fixed_point;
pub mod ledger;
mod role;
pub mod saved;
pub mod solver;
pub mod stage;
