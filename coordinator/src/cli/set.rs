//! Values set over a case file by a command line.

use clap::Args;

use crate::case::overrides::Override;

/// Values set over a case file.
#[derive(Debug, Default, Args)]
pub(super) struct SetArguments {
    /// Set a value over the case file, as the file would write it; repeat for several. Entries of lists go by their name or
    /// by their number from 0: `fluid.sound_speed_m_s=40`, `solid.body.plate.material.poisson_ratio=0.3`,
    /// `domain.upper_m[1]=0.5`.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Override::parse)]
    pub(super) overrides: Vec<Override>,
}
