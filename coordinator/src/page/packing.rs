//! Frames of particles as few bytes: positions by 16 bits, fields by 8 or 16, differences, deflate.
//!
//! A number of the range [lower, upper] is the code `round((v − lower) / (upper − lower) · (2ᵇ − 2))`; the largest code,
//! 2ᵇ − 1, stands for no value: NaN, or a particle that is not there at this time. So a value that is read back is
//! within half a quantum, (upper − lower) / (2ᵇ − 2) / 2, of what was packed.
//!
//! A frame is a list of columns: a byte that names a forecast, then n codes. A code is stored as its difference, modulo
//! 2ᵇ, to the forecast, folded so that small ones of either sign are small (0, −1, 1, −2 … as 0, 1, 2, 3 …); first the
//! lower bytes of the column, then the upper. Of the forecasts that the frames before allow, a column takes the one whose
//! differences are shortest. With cᵢ the code of particle i in this frame, pᵢ in the one before and qᵢ two frames before,
//! and 0 for what is before the first particle, the forecasts of cᵢ are
//!
//! | name | forecast | fits |
//! |---|---|---|
//! | 0 | cᵢ₋₁ | a frame that stands alone |
//! | 1 | pᵢ | what rests |
//! | 2 | pᵢ + (cᵢ₋₁ − pᵢ₋₁) | what changes like its neighbour |
//! | 3 | 2pᵢ − qᵢ | what moves evenly |
//! | 4 | 2pᵢ − qᵢ + (cᵢ₋₁ − 2pᵢ₋₁ + qᵢ₋₁) | what is accelerated like its neighbour |
//!
//! A frame that brings its particles has before the columns their groups (16 bits) and ids (32 bits), each as differences
//! modulo 2ᵇ to the particle before, in bytes from the lowest.

use std::collections::VecDeque;
use std::io::{self, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

use super::particles::{FIELDS, Particles, Slot};

/// How a column is packed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// `x`, `y`, `z` or a field.
    pub name: &'static str,
    /// Bits of a code, 8 or 16.
    pub bits: u32,
    /// Value of code 0.
    pub lower: f64,
    /// Value of the largest code but one.
    pub upper: f64,
}

impl Column {
    /// Largest code: no value.
    fn none(&self) -> u16 {
        if self.bits == 8 { u16::from(u8::MAX) } else { u16::MAX }
    }

    /// Difference of two values whose codes are neighbours.
    pub fn quantum(&self) -> f64 {
        (self.upper - self.lower) / f64::from(self.none() - 1)
    }

    /// Code of a value; a value out of range takes the code of the end.
    pub fn code(&self, value: f32) -> u16 {
        if value.is_nan() {
            return self.none();
        }
        let share = (f64::from(value) - self.lower) / (self.upper - self.lower);
        // In range by the clamp; the range has a width.
        (share.clamp(0.0, 1.0) * f64::from(self.none() - 1)).round() as u16
    }

    /// Value of a code.
    pub fn value(&self, code: u16) -> f64 {
        if code == self.none() { f64::NAN } else { self.lower + f64::from(code) * self.quantum() }
    }
}

/// The columns of frames with the ranges of all of `particles`; a field is packed by `field_bits`.
pub fn columns<'a>(
    particles: impl Iterator<Item = &'a Particles> + Clone,
    in_space: bool,
    field_bits: u32,
) -> Vec<Column> {
    let axes = ["x", "y", "z"];
    let mut list = Vec::new();
    for (k, name) in axes.into_iter().chain(FIELDS).enumerate() {
        let all = particles.clone().flat_map(|p| p.columns[k].iter());
        let range = all.filter(|v| v.is_finite()).fold(None, |range: Option<(f32, f32)>, v| {
            Some(range.map_or((*v, *v), |(lower, upper)| (lower.min(*v), upper.max(*v))))
        });
        let Some((lower, upper)) = range.filter(|_| name != "z" || in_space) else { continue };
        let (lower, upper) = (f64::from(lower), f64::from(upper));
        let upper = if upper > lower { upper } else { lower + lower.abs().max(1.0) };
        list.push(Column { name, bits: if k < 3 { 16 } else { field_bits }, lower, upper });
    }
    list
}

/// Packs frames one after another.
#[derive(Debug)]
pub struct Packer {
    columns: Vec<Column>,
    slots: Vec<Slot>,
    /// Codes of the last two frames, the latest first, column after column.
    before: VecDeque<Vec<Vec<u16>>>,
    level: Compression,
}

impl Packer {
    /// A packer of frames of these particles, ascending.
    pub fn new(columns: Vec<Column>, slots: Vec<Slot>, level: Compression) -> Self {
        Self { columns, slots, before: VecDeque::new(), level }
    }

    /// How columns are packed.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The next frame: compressed by zlib. The first brings the particles and stands alone.
    ///
    /// # Errors
    /// None that a buffer in memory has.
    pub fn pack(&mut self, particles: &Particles) -> io::Result<Vec<u8>> {
        let mut raw = Vec::new();
        if self.before.is_empty() {
            let groups = differences(self.slots.iter().map(|slot| u32::from(slot.group)));
            planes(&mut raw, &groups, 2);
            let ids = differences(self.slots.iter().map(|slot| slot.id));
            planes(&mut raw, &ids, 4);
        }
        // Where each slot is in this frame; both ascend.
        let mut places = Vec::with_capacity(self.slots.len());
        let mut next = 0;
        for slot in &self.slots {
            while particles.slots.get(next).is_some_and(|other| other < slot) {
                next += 1;
            }
            places.push((particles.slots.get(next) == Some(slot)).then_some(next));
        }
        let mut all = Vec::with_capacity(self.columns.len());
        for (c, column) in self.columns.iter().enumerate() {
            let values = &particles.columns[index(column.name)];
            let codes: Vec<u16> =
                places.iter().map(|place| place.map_or(column.none(), |i| column.code(values[i]))).collect();
            let before: Vec<&[u16]> = self.before.iter().map(|frame| frame[c].as_slice()).collect();
            let (name, folded) = shortest(&codes, &before, column.bits);
            raw.push(name);
            planes(&mut raw, &folded, column.bits.div_ceil(8));
            all.push(codes);
        }
        self.before.push_front(all);
        self.before.truncate(2);
        let mut encoder = ZlibEncoder::new(Vec::new(), self.level);
        encoder.write_all(&raw)?;
        encoder.finish()
    }
}

/// Bytes as text of a page.
pub fn as_text(bytes: &[u8]) -> String {
    STANDARD.encode(bytes)
}

fn index(name: &str) -> usize {
    ["x", "y", "z"].into_iter().chain(FIELDS).position(|known| known == name).unwrap_or(0)
}

/// Name of the forecast with the shortest differences, and these folded; `before` are the codes of frames before, the
/// latest first.
fn shortest(codes: &[u16], before: &[&[u16]], bits: u32) -> (u8, Vec<u32>) {
    let folded = |forecast: &dyn Fn(usize) -> u16, beside: bool| -> Vec<u32> {
        let mut left = 0u16;
        let difference = |(i, code): (usize, &u16)| {
            let own = code.wrapping_sub(forecast(i));
            let left = std::mem::replace(&mut left, own);
            fold(if beside { own.wrapping_sub(left) } else { own }, bits)
        };
        codes.iter().enumerate().map(difference).collect()
    };
    let candidates = match *before {
        [] => vec![(0, folded(&|_| 0, true))],
        [p] => vec![(1, folded(&|i| p[i], false)), (2, folded(&|i| p[i], true))],
        [p, q, ..] => {
            let evenly = |i: usize| p[i].wrapping_mul(2).wrapping_sub(q[i]);
            vec![
                (1, folded(&|i| p[i], false)),
                (2, folded(&|i| p[i], true)),
                (3, folded(&evenly, false)),
                (4, folded(&evenly, true)),
            ]
        }
    };
    let length = |folded: &[u32]| folded.iter().map(|number| u32::BITS - number.leading_zeros()).sum::<u32>();
    candidates.into_iter().min_by_key(|(_, folded)| length(folded)).unwrap_or_default()
}

/// A difference modulo 2ᵇ as a number that is small where the difference is near zero.
fn fold(difference: u16, bits: u32) -> u32 {
    if bits == 8 {
        // The lower byte is the difference modulo 256.
        let signed = i16::from(difference.to_le_bytes()[0].cast_signed());
        u32::from(((signed << 1) ^ (signed >> 15)).cast_unsigned())
    } else {
        let signed = difference.cast_signed();
        u32::from(((signed << 1) ^ (signed >> 15)).cast_unsigned())
    }
}

fn differences(numbers: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut before = 0u32;
    numbers.map(|number| number.wrapping_sub(std::mem::replace(&mut before, number))).collect()
}

/// Appends the lowest bytes of all numbers, then the next, `count` in all.
fn planes(to: &mut Vec<u8>, numbers: &[u32], count: u32) {
    for byte in 0..count {
        to.extend(numbers.iter().map(|number| (number >> (8 * byte)).to_le_bytes()[0]));
    }
}

#[cfg(test)]
mod tests;
