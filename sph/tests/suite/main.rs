//! The half-step driver with analytic participants.

mod driver;
mod iterate;
