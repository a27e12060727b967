//! Saved states as bytes: the data of a checkpoint.
//!
//! | part | content |
//! |---|---|
//! | magic | 8 bytes `TIDESAVE` |
//! | version | `u32`, now 1 |
//! | arrays | `u32`, each: length of its name in bytes `u32`, name, kind `u32` (1 `f64`, 2 `u32`, 3 `u64`), count `u64`, values |
//!
//! All little-endian, without gaps. A checkpoint carries its digest beside it.

use sph::coupling::saved::{SavedState, Values};

use crate::limits::{MAX_ARRAYS, MAX_NAME_BYTES};

const MAGIC: [u8; 8] = *b"TIDESAVE";
const VERSION: u32 = 1;

/// The bytes of `state`, each of whose arrays goes as soon as it is written.
pub fn encode_state(state: SavedState) -> Vec<u8> {
    let size: usize = state.arrays.iter().map(|(name, values)| 16 + name.len() + 8 * values.len()).sum();
    let mut out = Vec::with_capacity(16 + size);
    out.extend_from_slice(&MAGIC);
    out.extend_from_slice(&VERSION.to_le_bytes());
    out.extend_from_slice(&small(state.arrays.len()).to_le_bytes());
    for (name, values) in state.arrays {
        out.extend_from_slice(&small(name.len()).to_le_bytes());
        out.extend_from_slice(name.as_bytes());
        let kind: u32 = match &values {
            Values::F64(_) => 1,
            Values::U32(_) => 2,
            Values::U64(_) => 3,
        };
        out.extend_from_slice(&kind.to_le_bytes());
        out.extend_from_slice(&super::count(values.len()).to_le_bytes());
        match values {
            Values::F64(values) => out.extend(values.iter().flat_map(|value| value.to_le_bytes())),
            Values::U32(values) => out.extend(values.iter().flat_map(|value| value.to_le_bytes())),
            Values::U64(values) => out.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        }
    }
    out
}

/// Numbers of arrays and lengths of names are far below 2^32.
fn small(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}

/// The state of [`encode_state`]'s bytes. Nothing is set aside beyond their own size.
///
/// # Errors
/// What is wrong with the bytes, and where.
pub fn decode_state(bytes: &[u8]) -> Result<SavedState, String> {
    let mut rest = Rest { bytes, length: bytes.len() };
    if rest.take(MAGIC.len())? != MAGIC {
        return Err("is no saved state: the first bytes are others".into());
    }
    let version = rest.u32()?;
    if version != VERSION {
        return Err(format!("has format version {version}, this program reads version {VERSION}"));
    }
    let arrays = rest.size_u32()?;
    if arrays > MAX_ARRAYS {
        return Err(format!("has {arrays} arrays, at most {MAX_ARRAYS} are allowed"));
    }
    let mut state = SavedState::default();
    for k in 0..arrays {
        let length = rest.size_u32()?;
        if length > MAX_NAME_BYTES {
            return Err(format!(
                "array {k} has a name of {length} bytes, at most {MAX_NAME_BYTES} are allowed"
            ));
        }
        let name =
            std::str::from_utf8(rest.take(length)?).map_err(|_| format!("array {k} has no valid name"))?;
        if state.has(name) {
            return Err(format!("has two arrays `{name}`"));
        }
        let kind = rest.u32()?;
        let count = usize::try_from(rest.u64()?).map_err(|_| format!("array `{name}` is too long"))?;
        let values = match kind {
            1 => Values::F64(rest.words(count)?.iter().map(|word| f64::from_le_bytes(*word)).collect()),
            2 => Values::U32(rest.words(count)?.iter().map(|word| u32::from_le_bytes(*word)).collect()),
            3 => Values::U64(rest.words(count)?.iter().map(|word| u64::from_le_bytes(*word)).collect()),
            _ => return Err(format!("array `{name}` is of kind {kind}, must be 1 to 3")),
        };
        state.arrays.push((name.to_owned(), values));
    }
    match rest.bytes.len() {
        0 => Ok(state),
        left => Err(format!("has {left} bytes after its last array")),
    }
}

/// Bytes not read yet.
struct Rest<'a> {
    bytes: &'a [u8],
    length: usize,
}

impl<'a> Rest<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.bytes.split_at_checked(count).ok_or_else(|| {
            let at = self.length - self.bytes.len();
            format!("is cut off: {count} bytes were expected at byte {at} of {}", self.length)
        })?;
        self.bytes = rest;
        Ok(taken)
    }

    fn words<const N: usize>(&mut self, count: usize) -> Result<&'a [[u8; N]], String> {
        let bytes = self.take(count.checked_mul(N).ok_or("has an array beyond all memory")?)?;
        Ok(bytes.as_chunks().0)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.words(1).map(|words| u32::from_le_bytes(words[0]))
    }

    fn size_u32(&mut self) -> Result<usize, String> {
        usize::try_from(self.u32()?).map_err(|_| "has a number beyond this machine's".to_owned())
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.words(1).map(|words| u64::from_le_bytes(words[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> SavedState {
        let mut state = SavedState::default();
        state.put_f64("x", [0.1, -0.0, f64::NAN]);
        state.put_u32("id", [3, u32::MAX]);
        state.put_u64("step", [7]);
        state.put_f64("none", []);
        state
    }

    #[test]
    fn a_state_comes_back_bit_for_bit() {
        let bytes = encode_state(state());
        let back = decode_state(&bytes).unwrap();
        assert_eq!(back.arrays[1..], state().arrays[1..]);
        assert_eq!(encode_state(back), bytes);
    }

    #[test]
    fn every_cut_and_every_false_size_is_refused() {
        let bytes = encode_state(state());
        for length in 0..bytes.len() {
            assert!(decode_state(&bytes[..length]).is_err(), "cut at {length}");
        }
        let longer = [bytes.as_slice(), &[0]].concat();
        assert!(decode_state(&longer).unwrap_err().contains("1 bytes after"));
        // The count of the first array: magic, version, number, length, "x", kind.
        let mut huge = bytes.clone();
        huge[25..33].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(decode_state(&huge).unwrap_err().contains("memory"));
        let mut version = bytes;
        version[8] = 9;
        assert!(decode_state(&version).unwrap_err().contains("version 9"));
    }
}
