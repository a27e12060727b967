//! The half-step driver with analytic participants, properties of expressions and shapes, and the page that lists all
//! parameters.

mod driver;
mod expressions;
mod iterate;
mod parameters;
mod shapes;
