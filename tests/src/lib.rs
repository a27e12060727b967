//! Tests across real server processes; the program that they start is `tidelock-node`, the coordinator under a name of
//! its own. [`validation`] holds the verification suite that the program `validate` runs.

pub mod bench;
pub mod certificates;
pub mod delay;
pub mod doubles;
pub mod first_steps;
pub mod fuzz;
pub mod idle;
pub mod kill;
pub mod mutants;
pub mod nodes;
pub mod python;
pub mod random;
pub mod scaling;
pub mod soak;
pub mod source_tree;
pub mod streams;
pub mod tidy;
pub mod validation;
