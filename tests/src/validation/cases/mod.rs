//! The cases, one file each.

use super::Case;

mod arrays;
mod beams;
mod bore;
mod channel;
mod circular_couette;
mod confined;
mod contact;
pub mod curved;
mod dam_break;
mod dam_break_pressure;
mod debris;
mod drifting_body;
mod drop;
mod elastic;
mod floating;
mod free_solids;
mod hard;
mod jet;
mod near_floor;
mod plate_mode;
mod slab;
mod solid_hard;
mod spatial;
mod square_patch;
mod standing_wave;
mod still_water;
mod substeps;
mod taylor_green;
mod thin_plate;
mod wall_impact;

/// All cases, in the order in which they are run.
pub fn all() -> Vec<&'static dyn Case> {
    vec![
        &channel::COUETTE,
        &channel::POISEUILLE,
        &circular_couette::CircularCouette,
        &arrays::CYLINDERS,
        &drop::Drop,
        &square_patch::SquarePatch,
        &taylor_green::TaylorGreen,
        &still_water::StillWater,
        &dam_break::DamBreak,
        &dam_break_pressure::DamBreakPressure,
        &wall_impact::WallImpact,
        &jet::Jet,
        &bore::Bore,
        &standing_wave::StandingWave,
        &confined::ClosedChannel,
        &confined::FullTank,
        &confined::FullVessel,
        &confined::FullVesselInSpace,
        &confined::FullPoiseuille,
        &confined::MeetingPatches,
        &confined::OscillatingDrop,
        &hard::Hard,
        &beams::Cantilever,
        &beams::StaticCantilever,
        &beams::PlateStiffness,
        &beams::TurekHron,
        &beams::ElasticBar,
        &curved::Ring,
        &curved::Arch,
        &free_solids::SpinningSquare,
        &free_solids::Rings,
        &contact::Incline,
        &contact::Stack,
        &contact::Fold,
        &solid_hard::SolidHard,
        &drifting_body::DriftingBody,
        &plate_mode::PlateMode,
        &substeps::Substeps,
        &floating::DensityRatio,
        &floating::Draught,
        &near_floor::Approach,
        &near_floor::Lift,
        &floating::LightFloat,
        &floating::HydrostaticPlate,
        &thin_plate::ThinPlate,
        &slab::Slab,
        &elastic::Gate,
        &elastic::Obstacle,
        &debris::Debris,
        &spatial::StillWater3d,
        &spatial::StillWaterSphere,
        &spatial::SlabDamBreak,
        &spatial::DuctFlow,
        &spatial::PipeFlow,
        &arrays::SPHERES,
        &spatial::Drop3d,
        &spatial::StandingWave3d,
        &spatial::TaylorGreen3d,
        &spatial::DamBreakBox,
        &spatial::Cantilever3d,
        &spatial::TorsionRod,
        &spatial::SpinningCube,
        &spatial::HeavyTop,
        &spatial::TwistingColumn,
        &spatial::FallingSphere,
        &spatial::Floating3d,
        &spatial::HydrostaticPlate3d,
        &spatial::Debris3d,
    ]
}
