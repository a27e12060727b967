//! What stays the same from frame to frame: window, groups, fields and colour scales.

use serde::Serialize;

use super::folder::CaseFacts;
use super::particles::{FIELDS, Group, Matter, Particles, Slot};
use crate::results::plots::scale::quantile;

/// Share of all values below and above a colour scale; they take the colours of its ends.
pub const OUTLIERS: f64 = 0.005;
/// Most values that a scale is found from.
const SAMPLED: usize = 400_000;
/// Share of what moves that may be outside of the window on either side.
const DROPS: f64 = 0.001;
/// Room around what moves, in parts of its size.
const MARGIN: f64 = 0.12;
/// A range whose negative end is beyond this part of the positive one is shown from −a to a.
const SIGNED: f64 = 0.5;

/// A field in words.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FieldFacts {
    /// Name in the frames.
    pub name: &'static str,
    /// Name on the page.
    pub label: &'static str,
    /// SI unit.
    pub unit: &'static str,
}

/// The fields that frames may have.
pub const FACTS: [FieldFacts; FIELDS.len()] = [
    FieldFacts { name: FIELDS[0], label: "pressure", unit: "Pa" },
    FieldFacts { name: FIELDS[1], label: "speed", unit: "m/s" },
    FieldFacts { name: FIELDS[2], label: "density", unit: "kg/m³" },
    FieldFacts { name: FIELDS[3], label: "von Mises stress", unit: "Pa" },
];

/// Colours of one field of one kind of matter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scale {
    /// Whose field.
    pub matter: Matter,
    /// The field.
    pub field: &'static str,
    /// Value of the first colour.
    pub lower: f64,
    /// Value of the last colour.
    pub upper: f64,
    /// Whether zero is in the middle, between two hues.
    pub signed: bool,
}

/// What all frames share.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    /// 2 or 3.
    pub dimensions: usize,
    /// Axis that points upward.
    pub up_axis: usize,
    /// Corners of what is shown \[m\].
    pub lower: [f64; 3],
    /// Likewise.
    pub upper: [f64; 3],
    /// Particle spacings of fluid and solids \[m\].
    pub spacings: [f64; 2],
    /// Groups of particles.
    pub groups: Vec<Group>,
    /// Fields in words.
    pub fields: [FieldFacts; FIELDS.len()],
    /// Colour scales.
    pub scales: Vec<Scale>,
    /// About one particle in so many is shown.
    pub every: u32,
}

impl Scene {
    /// Of `frames`.
    pub fn of(case: &CaseFacts, groups: Vec<Group>, frames: &[Particles], every: u32) -> Self {
        let (lower, upper) = window(frames, &groups);
        let of_groups = |matter: Matter| groups.iter().filter(move |group| group.matter == matter);
        let mut scales = Vec::new();
        for matter in [Matter::Fluid, Matter::Solid] {
            if of_groups(matter).next().is_some() {
                scales.extend(
                    FIELDS
                        .into_iter()
                        .enumerate()
                        .filter_map(|(k, field)| scale(frames, &groups, matter, k, field)),
                );
            }
        }
        let size = (0..3).map(|k| upper[k] - lower[k]).fold(0.0, f64::max);
        let [fluid, solid] = case.spacings;
        let any = fluid.or(solid).unwrap_or(0.01 * size);
        Self {
            dimensions: case.dimensions,
            up_axis: case.up_axis,
            lower,
            upper,
            spacings: [fluid.unwrap_or(any), solid.or(fluid).unwrap_or(any)],
            groups,
            fields: FACTS,
            scales,
            every,
        }
    }
}

/// Corners of what moves at any time, but for a few drops, and of the walls near it; of one frame alone, whose matter will
/// move, those of the walls.
fn window(frames: &[Particles], groups: &[Group]) -> ([f64; 3], [f64; 3]) {
    let is_wall =
        |slot: &Slot| groups.get(usize::from(slot.group)).is_some_and(|group| group.matter == Matter::Wall);
    let total: usize = frames.iter().map(|frame| frame.slots.len()).sum();
    let stride = total.div_ceil(SAMPLED).max(1);
    let range = |axis: usize, walls: bool, outside: f64| {
        let all = frames.iter().flat_map(|frame| frame.slots.iter().zip(&frame.columns[axis]));
        let wanted =
            all.filter(|(slot, x)| is_wall(slot) == walls && x.is_finite()).map(|(_, x)| f64::from(*x));
        let mut values: Vec<f64> = wanted.step_by(stride).collect();
        Some([quantile(&mut values, outside)?, quantile(&mut values, 1.0 - outside)?])
    };
    let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        let walls = range(axis, true, 0.0);
        let moving = range(axis, false, if frames.len() > 1 { DROPS } else { 0.0 });
        let [from, to] = match (walls, moving) {
            (Some(walls), Some(moving)) if frames.len() > 1 => {
                let room = MARGIN * (moving[1] - moving[0]);
                // Not beyond the walls, unless what moves is.
                let from = (moving[0] - room).max(walls[0]).min(moving[0]);
                let to = (moving[1] + room).min(walls[1]).max(moving[1]);
                // A wall that what moves rests on is shown.
                [if walls[0] > moving[0] - room { walls[0].min(from) } else { from }, to]
            }
            (Some(walls), Some(moving)) => [walls[0].min(moving[0]), walls[1].max(moving[1])],
            (one, other) => one.or(other).unwrap_or([0.0, 1.0]),
        };
        (lower[axis], upper[axis]) = (from, to);
    }
    (lower, upper)
}

fn scale(
    frames: &[Particles],
    groups: &[Group],
    matter: Matter,
    k: usize,
    field: &'static str,
) -> Option<Scale> {
    let total: usize = frames.iter().map(|frame| frame.slots.len()).sum();
    let stride = total.div_ceil(SAMPLED).max(1);
    let all = frames.iter().flat_map(|frame| frame.slots.iter().zip(&frame.columns[3 + k]));
    let mut values: Vec<f64> = all
        .filter(|(slot, value)| {
            value.is_finite()
                && groups.get(usize::from(slot.group)).is_some_and(|group| group.matter == matter)
        })
        .step_by(stride)
        .map(|(_, value)| f64::from(*value))
        .collect();
    let (lower, upper) = (quantile(&mut values, OUTLIERS)?, quantile(&mut values, 1.0 - OUTLIERS)?);
    if lower < 0.0 && upper > 0.0 && -lower > SIGNED * upper {
        let most = upper.max(-lower);
        return Some(Scale { matter, field, lower: -most, upper: most, signed: true });
    }
    // What counts from zero is shown from zero, unless all of it is far from there.
    let lower = if field != "density" && lower < 0.5 * upper { lower.min(0.0) } else { lower };
    let upper = if upper > lower { upper } else { lower + lower.abs().max(1.0) };
    Some(Scale { matter, field, lower, upper, signed: false })
}
