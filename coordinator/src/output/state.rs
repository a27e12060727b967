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

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use flate2::CrcWriter;
use sha2::{Digest, Sha256};
use sph::solver::{Field, ParticleFields};

use super::directory::{OutputError, write_file};

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

/// Reads a state that [`write()`] made. Nothing is allocated beyond the size that the file really has.
///
/// # Errors
/// When it cannot be read or is no complete, undamaged final state; the message names the file and what is wrong.
pub fn read(path: &Path) -> Result<ParticleFields, String> {
    let bad = |reason: String| format!("`{}`: {reason}", path.display());
    let cannot = |e: io::Error| bad(format!("cannot be read: {e}"));
    let mut file = File::open(path).map_err(cannot)?;
    let metadata = file.metadata().map_err(cannot)?;
    if !metadata.is_file() {
        return Err(bad("is no file".into()));
    }
    let (mut magic, mut version, mut length) = ([0; 8], [0; 4], [0; 8]);
    let head =
        [&mut magic[..], &mut version, &mut length].into_iter().try_for_each(|part| file.read_exact(part));
    if head.is_err() || magic != MAGIC {
        return Err(bad("is no final state of a run (`final/fluid.state` or `final/solid.state`)".into()));
    }
    let version = u32::from_le_bytes(version);
    if version != VERSION {
        return Err(bad(format!("has format version {version}, this program reads version {VERSION}")));
    }
    let length = u64::from_le_bytes(length);
    if length.checked_add(FRAME) != Some(metadata.len()) {
        let reason = format!("is cut off or damaged: {} bytes for a body of {length}", metadata.len());
        return Err(bad(reason));
    }
    let length = usize::try_from(length).map_err(|_| bad(format!("is too large: {length} bytes")))?;
    let (mut body, mut checksum) = (vec![0; length], [0; 4]);
    file.read_exact(&mut body).and_then(|()| file.read_exact(&mut checksum)).map_err(cannot)?;
    let mut crc = flate2::Crc::new();
    crc.update(&body);
    if crc.sum() != u32::from_le_bytes(checksum) {
        return Err(bad("is damaged: its checksum does not fit its content".into()));
    }
    Body(&body).state().map_err(|reason| bad(format!("is no valid final state: {reason}")))
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
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
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

/// What is left of a body to read.
struct Body<'a>(&'a [u8]);

impl<'a> Body<'a> {
    fn state(mut self) -> Result<ParticleFields, String> {
        let step = self.u64()?;
        let time = f64::from_bits(self.u64()?);
        let n = usize::try_from(self.u64()?).map_err(|e| e.to_string())?;
        let groups = self.u32()?;
        // Pushed one by one: a false count ends at the end of the bytes, before memory does.
        let mut group_names = Vec::new();
        for _ in 0..groups {
            group_names.push(self.text()?);
        }
        let (id, group) = (self.u32s(n)?, self.u32s(n)?);
        let mut fields = Vec::new();
        for _ in 0..self.u32()? {
            let (name, unit) = (self.text()?, self.text()?);
            let components = usize::try_from(self.u32()?).map_err(|e| e.to_string())?;
            let count = n.checked_mul(components).ok_or("a field is too large")?;
            fields.push(Field { name, unit, components, values: self.f64s(count)? });
        }
        if !self.0.is_empty() {
            return Err(format!("{} bytes too many", self.0.len()));
        }
        let state = ParticleFields { step, time, id, group, group_names, fields };
        check(&state)?;
        Ok(state)
    }

    fn bytes(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (bytes, rest) = self
            .0
            .split_at_checked(count)
            .ok_or_else(|| format!("{count} bytes announced, {} left", self.0.len()))?;
        self.0 = rest;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.bytes(N)?.try_into().map_err(|_| "too short".to_string())
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Result<String, String> {
        let length = usize::try_from(self.u32()?).map_err(|e| e.to_string())?;
        String::from_utf8(self.bytes(length)?.to_vec()).map_err(|_| "a name is no UTF-8".into())
    }

    fn u32s(&mut self, count: usize) -> Result<Vec<u32>, String> {
        let bytes = self.bytes(count.checked_mul(4).ok_or("an array is too large")?)?;
        let (words, _) = bytes.as_chunks();
        Ok(words.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    fn f64s(&mut self, count: usize) -> Result<Vec<f64>, String> {
        let bytes = self.bytes(count.checked_mul(8).ok_or("an array is too large")?)?;
        let (words, _) = bytes.as_chunks();
        Ok(words.iter().map(|word| f64::from_le_bytes(*word)).collect())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn field(name: &str, components: usize, values: &[f64]) -> Field {
        Field { name: name.into(), unit: "m".into(), components, values: values.to_vec() }
    }

    fn state() -> ParticleFields {
        ParticleFields {
            step: 17,
            time: 0.1 + 0.2,
            id: vec![3, 1, 8],
            group: vec![0, 1, 1],
            group_names: vec!["water".into(), "Wand µ".into()],
            fields: vec![
                field("position", 2, &[0.1, -0.0, f64::MIN_POSITIVE, 4.0, 1.0 / 3.0, 1e300]),
                field("pressure", 1, &[f64::NAN, f64::INFINITY, -7.5]),
            ],
        }
    }

    fn saved(root: &tempfile::TempDir) -> (std::path::PathBuf, Vec<u8>) {
        let path = root.path().join("fluid.state");
        write(&path, &state()).unwrap();
        let bytes = fs::read(&path).unwrap();
        (path, bytes)
    }

    /// `bytes` with the right length and checksum for its body.
    fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
        let body = bytes.len() - 4;
        bytes[12..20].copy_from_slice(&((body - 20) as u64).to_le_bytes());
        let mut crc = flate2::Crc::new();
        crc.update(&bytes[20..body]);
        bytes[body..].copy_from_slice(&crc.sum().to_le_bytes());
        bytes
    }

    #[test]
    fn a_state_reads_back_bit_for_bit() {
        let root = tempfile::tempdir().unwrap();
        let (path, bytes) = saved(&root);
        let back = read(&path).unwrap();
        // NaN is not equal to itself: compare by bits.
        assert_eq!(digest(&back), digest(&state()));
        assert_eq!(back.group_names, state().group_names);
        assert_eq!((back.step, back.time.to_bits()), (17, state().time.to_bits()));
        assert_eq!(back.fields[0], state().fields[0]);
        assert_eq!(sealed(bytes.clone()), bytes);
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_refused() {
        let root = tempfile::tempdir().unwrap();
        let (path, bytes) = saved(&root);
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            assert!(read(&path).is_err(), "cut at {length}");
        }
        for k in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[k] ^= 0x10;
            fs::write(&path, &damaged).unwrap();
            let message = read(&path).unwrap_err();
            assert!(message.contains("fluid.state"), "{message}");
        }
    }

    #[test]
    fn false_sizes_with_a_right_checksum_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let (path, bytes) = saved(&root);
        // Number of particles, number of groups, length of the first group's name.
        for (at, width) in [(36, 8), (44, 4), (48, 4)] {
            for value in [0u64, 2, u64::from(u32::MAX), u64::MAX] {
                let mut hostile = bytes.clone();
                hostile[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
                if hostile == bytes {
                    continue;
                }
                fs::write(&path, sealed(hostile)).unwrap();
                assert!(read(&path).is_err(), "{value} at {at}");
            }
        }
        let mut longer = bytes.clone();
        longer.splice(bytes.len() - 4..bytes.len() - 4, [0; 8]);
        fs::write(&path, sealed(longer)).unwrap();
        assert!(read(&path).unwrap_err().contains("too many"));
    }

    #[test]
    fn another_version_and_another_kind_of_file_are_named() {
        let root = tempfile::tempdir().unwrap();
        let (path, mut bytes) = saved(&root);
        bytes[8] = 9;
        fs::write(&path, &bytes).unwrap();
        assert!(read(&path).unwrap_err().contains("version 9"));
        fs::write(&path, "t_s,p1_pressure_pa\n0.0,1.0\n").unwrap();
        assert!(read(&path).unwrap_err().contains("no final state"));
        assert!(read(root.path()).is_err());
        assert!(read(&root.path().join("absent")).unwrap_err().contains("absent"));
    }

    #[test]
    fn the_digest_sees_every_bit_but_not_the_order() {
        let reference = digest(&state());
        assert_eq!(reference.len(), 64);
        let mut turned = state();
        turned.id.rotate_left(1);
        turned.group.rotate_left(1);
        turned.fields[0].values.rotate_left(2);
        turned.fields[1].values.rotate_left(1);
        turned.fields.reverse();
        assert_eq!(digest(&turned), reference);
        let mut other = state();
        other.fields[0].values[1] = 0.0;
        assert_ne!(digest(&other), reference, "the sign of zero is a bit");
    }

    #[test]
    fn arrays_that_do_not_fit_are_not_written() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("x.state");
        let mut broken = state();
        broken.fields[1].values.pop();
        assert!(write(&path, &broken).unwrap_err().to_string().contains("pressure"));
        broken = state();
        broken.group[0] = 2;
        assert!(write(&path, &broken).is_err());
        assert!(!path.exists());
    }
}
