//! Limits of the neighbour lists: how thick their skin is, and how far particles may move before they are rebuilt.

use sph::space::Space;

/// Skins around the support, in particle spacings. A thicker one would take more memory, in space 5 % more neighbours for
/// each twentieth of a spacing.
const SKINS: Skins = Skins { thinnest: 0.05, first: 0.1, thickest: 0.3 };
const SKINS_IN_SPACE: Skins = Skins { thickest: 0.15, ..SKINS };

/// Square of the optimal skin over the part of it that a step uses up, in particle spacings.
///
/// Sums cost a step as many pairs as there are within support and skin, c (2h + s)² in the plane, and lists B d/s, where d is
/// what a step uses up of the skin: least at s² = B d/2c(2h + s). In space a skin adds more pairs. Measured; the optimum is
/// flat.
pub fn skin_balance<S: Space>() -> f64 {
    if S::DIMENSIONS == 3 { 0.4 } else { 1.2 }
}

/// Largest displacement with which lists can last, in particle spacings. Two particles with three cells between them,
/// which are as wide as support and skin, can not come within support then.
const LARGEST_DISPLACEMENT: f64 = 0.5;

/// Largest move in a stage for which `Lists::near_walls` hold, in particle spacings.
pub const LARGEST_STAGE_MOVE: f64 = 0.1;

sph::constants! {
    /// Half the distance to the next particle of the layer, and a little more for curved layers.
    pub const PLANE_HALF_WIDTH: f64 = 0.55, "walls.half_width",
        "half-width of the plane of a wall particle that counts as wall, in spacings [-]";
}

/// Skins that lists can have.
#[derive(Clone, Copy, Debug)]
pub struct Skins {
    /// The thinnest.
    pub thinnest: f64,
    /// That of the first lists, whose lifetime is not known yet.
    pub first: f64,
    /// The thickest.
    pub thickest: f64,
}

/// Skins \[m\] for particles of `spacing` \[m\].
pub fn skins<S: Space>(spacing: f64) -> Skins {
    let Skins { thinnest, first, thickest } = if S::DIMENSIONS == 3 { SKINS_IN_SPACE } else { SKINS };
    Skins { thinnest: thinnest * spacing, first: first * spacing, thickest: thickest * spacing }
}

/// Largest displacement \[m\] with which lists can last, for particles of `spacing` \[m\].
pub fn farthest(spacing: f64) -> f64 {
    LARGEST_DISPLACEMENT * spacing
}
