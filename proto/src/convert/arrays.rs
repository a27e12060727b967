//! Packed little-endian arrays.

use bytes::{BufMut, Bytes, BytesMut};
use sph::coupling::exchange::Column;
use sph::space::components::Components;

use super::{Path, WireError};
use crate::limits::MAX_PARTICLES;

const NUMBER_BYTES: usize = 8;
const INDEX_BYTES: usize = 4;

/// The number of eight bytes; the caller has cut them.
fn number(bytes: &[u8]) -> f64 {
    let mut raw = [0; NUMBER_BYTES];
    raw.copy_from_slice(bytes);
    f64::from_le_bytes(raw)
}

/// Packs `values`.
pub(super) fn pack<C: Components>(values: &[C]) -> Bytes {
    let mut out = BytesMut::with_capacity(values.len() * C::COUNT * NUMBER_BYTES);
    for value in values {
        value.row().as_ref().iter().for_each(|number| out.put_f64_le(*number));
    }
    out.freeze()
}

/// Unpacks `components` finite numbers for each of `count` particles into `column`, replacing what it held.
pub(super) fn unpack_column(
    bytes: &[u8],
    count: usize,
    components: usize,
    column: &mut Column,
    at: &Path<'_>,
) -> Result<(), WireError> {
    check_size(bytes, count, components, at)?;
    let numbers = bytes.chunks_exact(NUMBER_BYTES).map(number);
    column.components = components;
    column.values.clear();
    column.values.extend(numbers);
    match column.values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(k) => {
            let row: Vec<String> =
                column.row(k / components).iter().map(|value| format!("{value:?}")).collect();
            let problem =
                format!("of particle number {} is {}, must be finite", k / components, row.join(", "));
            Err(at.error(problem))
        }
    }
}

/// Whether `bytes` are `components` numbers for each of `count` particles.
fn check_size(bytes: &[u8], count: usize, components: usize, at: &Path<'_>) -> Result<(), WireError> {
    if count > MAX_PARTICLES || bytes.len() != count * components * NUMBER_BYTES {
        return Err(at.error(format!(
            "has {} bytes, must have {count} particles x {components} numbers x 8 bytes",
            bytes.len()
        )));
    }
    Ok(())
}

/// Unpacks `count` finite values.
pub(super) fn unpack<C: Components>(bytes: &[u8], count: usize, at: &Path<'_>) -> Result<Vec<C>, WireError> {
    let mut column = Column::default();
    unpack_column(bytes, count, C::COUNT, &mut column, at)?;
    Ok(column.quantities().collect())
}

/// Unpacks all values, of any bits, that `bytes` holds.
pub(super) fn unpack_all(bytes: &[u8], at: &Path<'_>) -> Result<Vec<f64>, WireError> {
    check_size(bytes, bytes.len() / NUMBER_BYTES, 1, at)?;
    Ok(bytes.chunks_exact(NUMBER_BYTES).map(number).collect())
}

/// Unpacks `count` positive values.
pub(super) fn unpack_positive(bytes: &[u8], count: usize, at: &Path<'_>) -> Result<Vec<f64>, WireError> {
    let values: Vec<f64> = unpack(bytes, count, at)?;
    match values.iter().position(|value| *value <= 0.0) {
        None => Ok(values),
        Some(k) => Err(at.error(format!("of particle number {k} is {:?}, must be positive", values[k]))),
    }
}

/// Packs 32-bit indices or ids.
pub(super) fn pack_indices(values: &[u32]) -> Bytes {
    let mut out = BytesMut::with_capacity(values.len() * INDEX_BYTES);
    for value in values {
        out.put_u32_le(*value);
    }
    out.freeze()
}

/// Unpacks `count` 32-bit indices or ids.
pub(super) fn unpack_indices(bytes: &[u8], count: usize, at: &Path<'_>) -> Result<Vec<u32>, WireError> {
    if count > MAX_PARTICLES || bytes.len() != count * INDEX_BYTES {
        return Err(at.error(format!("has {} bytes, must have {count} particles x 4 bytes", bytes.len())));
    }
    Ok(bytes
        .chunks_exact(INDEX_BYTES)
        .map(|chunk| {
            let mut raw = [0; INDEX_BYTES];
            raw.copy_from_slice(chunk);
            u32::from_le_bytes(raw)
        })
        .collect())
}

/// Number of 32-bit values in `bytes`, within the limit of particles.
pub(super) fn index_count(bytes: &[u8], at: &Path<'_>) -> Result<usize, WireError> {
    let count = bytes.len() / INDEX_BYTES;
    if !bytes.len().is_multiple_of(INDEX_BYTES) || count > MAX_PARTICLES {
        return Err(at.error(format!(
            "has {} bytes, must be a multiple of 4 for at most {MAX_PARTICLES} particles",
            bytes.len()
        )));
    }
    Ok(count)
}

/// Unpacks ids, which must ascend strictly.
pub(super) fn unpack_ids(bytes: &[u8], count: usize, at: &Path<'_>) -> Result<Vec<u32>, WireError> {
    let ids = unpack_indices(bytes, count, at)?;
    match ids.windows(2).position(|pair| pair[0] >= pair[1]) {
        None => Ok(ids),
        Some(k) => Err(at.error(format!(
            "must ascend strictly, but particle number {k} has id {} and the next {}",
            ids[k],
            ids[k + 1]
        ))),
    }
}

/// Unpacks indices into a list of `len` entries called `list`.
pub(super) fn unpack_indices_below(
    bytes: &[u8],
    count: usize,
    len: usize,
    list: &str,
    at: &Path<'_>,
) -> Result<Vec<u32>, WireError> {
    let values = unpack_indices(bytes, count, at)?;
    match values.iter().position(|value| usize::try_from(*value).map_or(true, |v| v >= len)) {
        None => Ok(values),
        Some(k) => {
            Err(at.error(format!("of particle number {k} is {}, but there are {len} {list}", values[k])))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::space::Vector;

    #[test]
    fn all_bits_of_finite_numbers_survive_and_others_are_refused_by_particle() {
        let at = Path::root("densities");
        let values = [-0.0, 5e-324, f64::MAX, -1.0 / 3.0, f64::MIN_POSITIVE / 8.0];
        let bytes = pack(&values);
        assert_eq!(&bytes[..8], &[0, 0, 0, 0, 0, 0, 0, 0x80]);
        let back: Vec<f64> = unpack(&bytes, values.len(), &at).unwrap();
        assert!(back.iter().zip(&values).all(|(a, b)| a.to_bits() == b.to_bits()));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let vectors = [Vector::new(0.0, 1.0), Vector::new(2.0, bad)];
            let error = unpack::<Vector>(&pack(&vectors), 2, &at).unwrap_err();
            assert!(error.to_string().contains("of particle number 1 is 2.0"), "{error}");
        }
    }

    #[test]
    fn wrong_lengths_orders_and_indices_are_refused() {
        let at = Path::root("ids");
        assert!(unpack::<f64>(&[0; 15], 2, &at).unwrap_err().to_string().contains("has 15 bytes"));
        assert!(unpack::<f64>(&[0; 16], usize::MAX, &at).is_err());
        assert!(index_count(&[0; 6], &at).is_err());
        assert!(unpack_ids(&pack_indices(&[1, 3, 3]), 3, &at).unwrap_err().to_string().contains("ascend"));
        let error = unpack_indices_below(&pack_indices(&[0, 2]), 2, 2, "walls", &at).unwrap_err();
        assert!(error.to_string().contains("is 2, but there are 2 walls"));
        assert!(unpack_positive(&pack(&[1.0, 0.0]), 2, &at).is_err());
    }
}
