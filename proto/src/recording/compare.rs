//! Where two recordings differ first.

use std::collections::BTreeSet;
use std::fmt;

use sph::coupling::ledger::{InterfaceSums, LedgerVector};
use sph::coupling::solver::Role;

use super::{Moment, Recording, RecordingError};
use crate::convert::{self, Convert, choice};
use crate::description::FrameField;
use crate::wire;

/// Sides in the order in which frames of one half-step are compared.
const SIDES: [Role; 2] = [Role::Fluid, Role::Solid];

/// The first thing in which two frames of one half-step differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Which frames.
    pub at: Moment,
    /// Side that sent them.
    pub side: Role,
    /// What differs, with its unit.
    pub field: String,
    /// Number of the value in its field, and id of its particle where the frame tells it.
    pub place: Option<(usize, Option<u32>)>,
    /// What stands in the first and in the second.
    pub values: [String; 2],
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, frame of the {}: {}", self.at, self.side, self.field)?;
        match self.place {
            Some((number, Some(id))) => write!(f, " of particle {id} (number {number})")?,
            Some((number, None)) => write!(f, " of number {number}")?,
            None => {}
        }
        write!(f, " is {} in the first and {} in the second", self.values[0], self.values[1])
    }
}

/// What a comparison found.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Half-steps that both have and that are equal to the last bit, before the first difference.
    pub equal_half_steps: u64,
    /// The first difference.
    pub difference: Option<Difference>,
    /// The first frame that only one of them has, and which one (0 or 1).
    pub alone: Option<(Moment, usize)>,
}

/// Compares two recordings half-step by half-step up to the first difference.
///
/// Run ids and epochs may differ. Within a half-step the fluid's frame comes first, within a frame the clock, then the
/// sums of the half-step before, the set, the fields in the order of the protocol, limit and extent.
///
/// # Errors
/// When one of them cannot be read.
pub fn compare(first: &mut Recording, second: &mut Recording) -> Result<Comparison, RecordingError> {
    let mut moments: BTreeSet<Moment> = BTreeSet::new();
    for recording in [&*first, &*second] {
        SIDES.iter().for_each(|role| moments.extend(recording.moments(*role)));
    }
    let mut comparison = Comparison { equal_half_steps: 0, difference: None, alone: None };
    let mut ids = [Ids::default(), Ids::default()];
    let mut half_step = None;
    for at in moments {
        // One that has begun is equal once the next has.
        comparison.equal_half_steps +=
            u64::from(half_step.replace(at.at).is_some_and(|before| before != at.at));
        for side in SIDES {
            let frames = (first.frame(at, side)?, second.frame(at, side)?);
            match frames {
                (Some(a), Some(b)) => {
                    ids[side.index()].note(&a);
                    comparison.difference = difference(at, side, &a, &b, &ids[side.index()]);
                }
                (Some(_), None) => comparison.alone = Some((at, 0)),
                (None, Some(_)) => comparison.alone = Some((at, 1)),
                (None, None) => {}
            }
            if comparison.difference.is_some() || comparison.alone.is_some() {
                return Ok(comparison);
            }
        }
    }
    comparison.equal_half_steps += u64::from(half_step.is_some());
    Ok(comparison)
}

/// Ids of the particles of the last set of a side.
#[derive(Debug, Default)]
pub(crate) struct Ids(Vec<u32>);

impl Ids {
    /// Takes up the set of `frame`, if it has one.
    pub(crate) fn note(&mut self, frame: &wire::Frame) {
        if let Some(set) = &frame.set {
            self.0 = words(&set.ids);
        }
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn numbers(bytes: &[u8]) -> impl Iterator<Item = f64> {
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
}

/// The first thing in which frames `a` and `b` differ.
pub(crate) fn difference(
    at: Moment,
    side: Role,
    a: &wire::Frame,
    b: &wire::Frame,
    ids: &Ids,
) -> Option<Difference> {
    let found = clock(a, b)
        .or_else(|| acceptance(a, b))
        .or_else(|| previous(a, b))
        .or_else(|| set(a, b))
        .or_else(|| blocks(a, b, ids));
    let found = found.or_else(|| rest(a, b))?;
    Some(Difference { at, side, field: found.0, place: found.1, values: found.2 })
}

/// Field, place and both values.
type Found = (String, Option<(usize, Option<u32>)>, [String; 2]);

fn whole(field: &str, a: impl fmt::Debug, b: impl fmt::Debug) -> Option<Found> {
    Some((field.to_owned(), None, [format!("{a:?}"), format!("{b:?}")]))
}

fn bits(field: &str, a: f64, b: f64) -> Option<Found> {
    (a.to_bits() != b.to_bits()).then(|| whole(field, a, b)).flatten()
}

fn clock(a: &wire::Frame, b: &wire::Frame) -> Option<Found> {
    let value = f64::from_bits;
    bits("start of the step [s]", value(a.step_start_s_bits), value(b.step_start_s_bits))
        .or_else(|| bits("time step [s]", value(a.time_step_s_bits), value(b.time_step_s_bits)))
}

fn acceptance(a: &wire::Frame, b: &wire::Frame) -> Option<Found> {
    let residual = |frame: &wire::Frame| frame.acceptance.and_then(|word| word.residual).unwrap_or_default();
    bits("residual of the iterations [-]", residual(a), residual(b))
}

fn previous(a: &wire::Frame, b: &wire::Frame) -> Option<Found> {
    let sums = |frame: &wire::Frame| frame.previous.as_ref().and_then(|previous| previous.sums.clone());
    let (Some(a), Some(b)) = (sums(a), sums(b)) else { return None };
    if a == b {
        return None;
    }
    let read = |sums: &wire::InterfaceSums| InterfaceSums::from_wire(sums, &convert::Path::root("sums")).ok();
    let (Some(a), Some(b)) = (read(&a), read(&b)) else {
        return whole("interface sums of the half-step before", a, b);
    };
    let name = |what: &str| format!("{what} of the interface in the half-step before");
    let axes = |what: &str, a: LedgerVector, b: LedgerVector| {
        (0..3).find_map(|k| bits(&name(&what.replace('_', ["x", "y", "z"][k])), a[k], b[k]))
    };
    axes("force _ [N]", a.force, b.force)
        .or_else(|| axes("torque _ [N m]", a.torque, b.torque))
        .or_else(|| bits(&name("power [W]"), a.power, b.power))
        .or_else(|| whole("interface sums of the half-step before", a, b))
}

fn set(a: &wire::Frame, b: &wire::Frame) -> Option<Found> {
    if a.count != b.count {
        return whole("number of particles", a.count, b.count);
    }
    let (Some(a), Some(b)) = (&a.set, &b.set) else {
        return (a.set.is_some() != b.set.is_some())
            .then(|| whole("presence of a new set", a.set.is_some(), b.set.is_some()))
            .flatten();
    };
    let (first, second) = (words(&a.ids), words(&b.ids));
    if let Some(i) = (0..first.len().min(second.len())).find(|i| first[*i] != second[*i]) {
        let values = [first[i].to_string(), second[i].to_string()];
        return Some(("id".into(), Some((i, None)), values));
    }
    numbers_differ("mass [kg]", 1, &a.masses_kg, &b.masses_kg, &first)
        .or_else(|| (a.groups != b.groups).then(|| whole("groups", "these", "others")).flatten())
}

fn blocks(a: &wire::Frame, b: &wire::Frame, ids: &Ids) -> Option<Found> {
    let named = |block: &wire::Block| choice::<FrameField>(block.field, &convert::Path::root("block")).ok();
    for own in &a.blocks {
        let Some(field) = named(own) else { continue };
        let Some(other) = b.blocks.iter().find(|other| other.field == own.field) else {
            return whole(field.name(), "there", "missing");
        };
        let components = usize::try_from(own.components).unwrap_or(1);
        let name = format!("{} [{}]", field.name(), field.unit());
        if let Some(found) = numbers_differ(&name, components, &own.data, &other.data, &ids.0) {
            return Some(found);
        }
    }
    (a.blocks.len() != b.blocks.len())
        .then(|| whole("number of fields", a.blocks.len(), b.blocks.len()))
        .flatten()
}

fn numbers_differ(name: &str, components: usize, a: &[u8], b: &[u8], ids: &[u32]) -> Option<Found> {
    if a == b {
        return None;
    }
    let (first, second): (Vec<f64>, Vec<f64>) = (numbers(a).collect(), numbers(b).collect());
    let Some(k) = (0..first.len().min(second.len())).find(|k| first[*k].to_bits() != second[*k].to_bits())
    else {
        return whole(&format!("size of {name}"), a.len(), b.len());
    };
    let particle = k / components.max(1);
    let name =
        if components > 1 { format!("component {} of {name}", k % components) } else { name.to_owned() };
    let values = [format!("{:?}", first[k]), format!("{:?}", second[k])];
    Some((name, Some((particle, ids.get(particle).copied())), values))
}

fn rest(a: &wire::Frame, b: &wire::Frame) -> Option<Found> {
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    bits("limit of the time step [s]", number(a.time_step_limit_s), number(b.time_step_limit_s))
        .or_else(|| (a.extent != b.extent).then(|| whole("extent", "one", "another")).flatten())
        .or_else(|| bits("reach [m]", number(a.reach_m), number(b.reach_m)))
        .or_else(|| (a.digest != b.digest).then(|| whole("digest", a.digest, b.digest)).flatten())
}
