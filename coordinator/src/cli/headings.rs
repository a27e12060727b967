//! Headings of options in the help, for all commands.

pub(super) const CHECKPOINTS: &str = "Checkpoints";
pub(super) const COMPUTING: &str = "Computing";
pub(super) const FRAMES: &str = "Frames between the solvers";
pub(super) const RESULTS: &str = "Results";
pub(super) const SCREEN: &str = "Screen";
pub(super) const SECURITY: &str = "Security";
pub(super) const SOLVERS: &str = "Solvers";
