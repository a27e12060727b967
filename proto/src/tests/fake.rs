//! Small solvers: two rows of masses that repel each other across the interface, and servers that run them.

mod row;
mod servers;
mod setups;

pub(crate) use row::{RowFactory, row};
pub(crate) use servers::{Pair, TestServer, assert_usable, soon};
pub(crate) use setups::{
    IMPLICIT, MASSES, PLANE, SPATIAL, alone, fluid_setup, run_setup, setup, setup_in, solid_setup,
};
