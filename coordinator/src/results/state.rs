//! Final states: all particles of one side with full precision, from which another run can start.
//!
//! Everything is little-endian; text is a `u32` length in bytes and UTF-8.
//!
//! | part | content |
//! |---|---|
//! | magic | 8 bytes `TIDESTAT` |
//! | version | `u32`, now 1 |
//! | length | `u64`, bytes of the body |
//! | body | step `u64`; time \[s\] `f64`; particles `u64`; groups `u32`, each a text; ids `u32` each; group indices `u32` each; fields `u32`, each: name, unit, components `u32`, values `f64` particle by particle |
//! | checksum | CRC-32 (IEEE) of the body, `u32` |

mod reader;

use std::io::{self, Write};
use std::path::Path;

use flate2::CrcWriter;
use sha2::{Digest, Sha256};
use sph::coupling::solver::{Field, ParticleFields};

use super::error::OutputError;
use super::files::write_file;

pub use reader::read;

const MAGIC: [u8; 8] = *b"TIDESTAT";
const VERSION: u32 = 1;
/// Bytes before and after the body.
const FRAME: u64 = 8 + 4 + 8 + 4;
/// Longest text: names of groups, fields and units \[bytes\].
const LONGEST_TEXT: usize = 1 << 12;

/// Writes `state` to `path`.
///
/// # Errors
/// When the file cannot be written, or the arrays of `state` do not fit each other.
pub fn write(path: &Path, state: &ParticleFields) -> Result<(), OutputError> {
    check(state).map_err(|reason| OutputError::content(path, reason))?;
    write_file(path, |file| {
        file.write_all(&MAGIC)?;
        file.write_all(&VERSION.to_le_bytes())?;
        file.write_all(&body_length(state).to_le_bytes())?;
        let mut body = CrcWriter::new(file);
        write_body(&mut body, state)?;
        let checksum = body.crc().sum();
        body.into_inner().write_all(&checksum.to_le_bytes())
    })
}

/// SHA-256, as hex, of step, time, and the ids, groups and value bits of all particles in id order.
///
/// Fields enter in the order of their names. Equal digests mean equal bits.
pub fn digest(state: &ParticleFields) -> String {
    let mut hash = Sha256::new();
    hash.update(state.step.to_le_bytes());
    hash.update(state.time.to_le_bytes());
    let mut fields: Vec<&Field> = state.fields.iter().collect();
    fields.sort_by(|a, b| a.name.cmp(&b.name));
    for field in &fields {
        hash.update(field.name.as_bytes());
        hash.update([0]);
        hash.update((field.components as u64).to_le_bytes());
    }
    let mut order: Vec<usize> = (0..state.id.len()).collect();
    order.sort_by_key(|i| state.id[*i]);
    for i in order {
        hash.update(state.id[i].to_le_bytes());
        hash.update(state.group.get(i).copied().unwrap_or(u32::MAX).to_le_bytes());
        for field in &fields {
            let start = i.saturating_mul(field.components);
            for value in field.values.iter().skip(start).take(field.components) {
                hash.update(value.to_bits().to_le_bytes());
            }
        }
    }
    proto::hex::hex(&hash.finalize())
}

/// Whether all arrays have one entry per particle, and texts and indices are in range.
pub(super) fn check(state: &ParticleFields) -> Result<(), String> {
    let n = state.id.len();
    if state.group.len() != n {
        return Err(format!("{} group indices for {n} particles", state.group.len()));
    }
    if let Some(group) =
        state.group.iter().find(|g| !usize::try_from(**g).is_ok_and(|g| g < state.group_names.len()))
    {
        return Err(format!("group index {group} with {} groups", state.group_names.len()));
    }
    for field in &state.fields {
        let (name, m, components) = (&field.name, field.values.len(), field.components);
        if components == 0 || components.checked_mul(n) != Some(m) {
            return Err(format!("field `{name}`: {m} values for {n} particles of {components} components"));
        }
    }
    let texts = state.fields.iter().flat_map(|f| [&f.name, &f.unit]).chain(&state.group_names);
    match texts.map(String::len).max() {
        Some(longest) if longest > LONGEST_TEXT => {
            Err(format!("a name of {longest} bytes, longer than {LONGEST_TEXT}"))
        }
        _ => Ok(()),
    }
}

fn body_length(state: &ParticleFields) -> u64 {
    let text = |text: &String| 4 + text.len();
    let groups: usize = state.group_names.iter().map(text).sum();
    let fields = state.fields.iter().map(|f| text(&f.name) + text(&f.unit) + 4 + 8 * f.values.len());
    // A usize fits in 64 bits on every platform that Rust supports.
    (8 + 8 + 8 + 4 + groups + 8 * state.id.len() + 4 + fields.sum::<usize>()) as u64
}

fn write_body(to: &mut impl Write, state: &ParticleFields) -> io::Result<()> {
    let count = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let text = |to: &mut dyn Write, text: &str| {
        to.write_all(&count(text.len())?.to_le_bytes())?;
        to.write_all(text.as_bytes())
    };
    to.write_all(&state.step.to_le_bytes())?;
    to.write_all(&state.time.to_le_bytes())?;
    to.write_all(&(state.id.len() as u64).to_le_bytes())?;
    to.write_all(&count(state.group_names.len())?.to_le_bytes())?;
    state.group_names.iter().try_for_each(|name| text(to, name))?;
    state.id.iter().chain(&state.group).try_for_each(|number| to.write_all(&number.to_le_bytes()))?;
    to.write_all(&count(state.fields.len())?.to_le_bytes())?;
    for field in &state.fields {
        text(to, &field.name)?;
        text(to, &field.unit)?;
        to.write_all(&count(field.components)?.to_le_bytes())?;
        field.values.iter().try_for_each(|value| to.write_all(&value.to_le_bytes()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
