//! What a case prescribes as expressions: body forces and the motion of walls and supports.

pub mod body_force;
pub mod motion;
