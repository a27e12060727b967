//! The half-step driver with analytic participants, and properties of expressions and shapes.

mod driver;
mod expressions;
mod iterate;
mod shapes;
