//! The half-step driver with analytic participants, and the page that lists all parameters.

mod driver;
mod iterate;
mod parameters;
