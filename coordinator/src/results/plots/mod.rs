//! Pictures of a run: particle fields as PNG, and what pictures and the page share.

pub mod chart;
pub mod colour;
pub mod field;
pub mod gallery;
pub mod projection;
pub mod quantities;
pub mod scale;

/// A picture that could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot draw a picture: {0}")]
pub struct PlotError(pub String);

impl PlotError {
    /// A failure of the drawing library.
    pub fn new(cause: impl ToString) -> Self {
        Self(cause.to_string())
    }
}
