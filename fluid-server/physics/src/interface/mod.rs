//! The solid partner.

pub mod fluid_interface;
pub mod selection;
