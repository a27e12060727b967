//! Cases in space, one file per subject.

mod bars;
mod bodies;
mod channel;
mod common;
mod dam_break_box;
mod debris;
mod drop;
mod rotation;
mod twisting;
mod vortex;
mod water;

pub use bars::{Cantilever3d, TorsionRod};
pub use bodies::{FallingSphere, Floating3d, HydrostaticPlate3d};
pub use channel::{DuctFlow, PipeFlow};
pub use dam_break_box::DamBreakBox;
pub use debris::Debris3d;
pub use drop::Drop3d;
pub use rotation::{HeavyTop, SpinningCube};
pub use twisting::TwistingColumn;
pub use vortex::TaylorGreen3d;
pub use water::{SlabDamBreak, StandingWave3d, StillWater3d, StillWaterSphere};

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use super::*;
    use crate::validation::{Case, template};

    #[test]
    #[ignore = "lays out all cases in space, which takes half a minute and more: run it when these cases change"]
    fn solvers_accept_the_coarsest_member_of_every_scheme() {
        let cases: [&dyn Case; 10] = [
            &Cantilever3d,
            &TorsionRod,
            &SpinningCube,
            &HeavyTop,
            &TwistingColumn,
            &PipeFlow,
            &FallingSphere,
            &Floating3d,
            &HydrostaticPlate3d,
            &Debris3d,
        ];
        let mut seen = BTreeSet::new();
        for member in cases.iter().flat_map(|case| case.members()) {
            if !seen.insert((member.file, member.scheme)) {
                continue;
            }
            let path = template::folder().join(member.file).with_extension("toml");
            let text = template::instantiate(&path, &member.changes).unwrap();
            let none = |path: &Path| Err(format!("no state: {}", path.display()));
            let accepted = coordinator::case::parse(&text, member.file, &template::folder(), &none)
                .map_err(|errors| errors.to_string())
                .and_then(|case| coordinator::check::open(&case).map_err(|failure| failure.message));
            assert!(accepted.is_ok(), "{}: {}", member.label(), accepted.err().unwrap_or_default());
        }
    }
}
