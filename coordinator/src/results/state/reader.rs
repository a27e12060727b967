//! Reading a final state: in pieces, its checksum first.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use sph::coupling::solver::{Field, ParticleFields};

use super::{FRAME, LONGEST_TEXT, MAGIC, VERSION, check};
use crate::case::MOST_PARTICLES;
use crate::results::files::open_regular;

/// Bytes before the body.
const HEAD: u64 = 8 + 4 + 8;
/// Most numbers of a particle, over all fields.
const MOST_COMPONENTS: u64 = 128;
/// Most groups, and most fields.
const MOST_NAMES: u32 = 1 << 16;
/// Values that are read at once.
const PIECE: usize = 1 << 13;

/// Longest body of a state of `particles` \[bytes\].
const fn longest_body(particles: u64) -> u64 {
    // A group has a name; a field has a name, a unit and a number of components.
    let names = MOST_NAMES as u64 * (3 * (LONGEST_TEXT as u64 + 4) + 4);
    names + particles * (4 + 4 + 8 * MOST_COMPONENTS)
}

/// Reads a state that [`write()`](super::write()) made. It is read in pieces; nothing is allocated for what does not come.
///
/// # Errors
/// When it cannot be read, is too large, or is no complete, undamaged final state; the message names the file and what is
/// wrong.
pub fn read(path: &Path) -> Result<ParticleFields, String> {
    let bad = |reason: String| format!("`{}`: {reason}", path.display());
    let cannot = |e: io::Error| bad(format!("cannot be read: {e}"));
    let (mut file, bytes) = open_regular(path).map_err(cannot)?;
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
    if length.checked_add(FRAME) != Some(bytes) {
        return Err(bad(format!("is cut off or damaged: {bytes} bytes for a body of {length}")));
    }
    // At most some millions.
    let most = longest_body(MOST_PARTICLES as u64);
    if length > most {
        return Err(bad(format!("is too large: a body of {length} bytes, at most {most} are read")));
    }
    if !checksum_fits(&mut file, length).map_err(cannot)? {
        return Err(bad("is damaged: its checksum does not fit its content".into()));
    }
    file.seek(SeekFrom::Start(HEAD)).map_err(cannot)?;
    let body = Body { from: BufReader::with_capacity(8 * PIECE, file), left: length };
    body.state().map_err(|reason| bad(format!("is no valid final state: {reason}")))
}

/// Whether the checksum behind the body of `length` bytes is that of the body.
fn checksum_fits(file: &mut File, length: u64) -> io::Result<bool> {
    let (mut crc, mut piece, mut left) = (flate2::Crc::new(), vec![0; 8 * PIECE], length);
    while left > 0 {
        let wanted = usize::try_from(left).map_or(piece.len(), |left| left.min(piece.len()));
        file.read_exact(&mut piece[..wanted])?;
        crc.update(&piece[..wanted]);
        // At most 64 KiB.
        left -= wanted as u64;
    }
    let mut checksum = [0; 4];
    file.read_exact(&mut checksum)?;
    Ok(crc.sum() == u32::from_le_bytes(checksum))
}

/// What is left of a body to read.
struct Body<R> {
    from: R,
    left: u64,
}

impl<R: Read> Body<R> {
    fn state(mut self) -> Result<ParticleFields, String> {
        let step = self.u64()?;
        let time = f64::from_bits(self.u64()?);
        let n = usize::try_from(self.u64()?).ok().filter(|n| *n <= MOST_PARTICLES);
        let n = n.ok_or_else(|| format!("more than {MOST_PARTICLES} particles"))?;
        let groups = self.names()?;
        let mut group_names = Vec::new();
        for _ in 0..groups {
            group_names.push(self.text()?);
        }
        let (id, group) = (self.values(n, u32::from_le_bytes)?, self.values(n, u32::from_le_bytes)?);
        let mut fields = Vec::new();
        for _ in 0..self.names()? {
            let (name, unit) = (self.text()?, self.text()?);
            let components = usize::try_from(self.u32()?).map_err(|e| e.to_string())?;
            if components == 0 {
                return Err(format!("field `{name}` has no components"));
            }
            let count = n.checked_mul(components).ok_or("a field is too large")?;
            fields.push(Field { name, unit, components, values: self.values(count, f64::from_le_bytes)? });
        }
        if self.left > 0 {
            return Err(format!("{} bytes too many", self.left));
        }
        let state = ParticleFields { step, time, id, group, group_names, fields };
        check(&state)?;
        Ok(state)
    }

    /// Takes `count` bytes off what is left.
    fn announce(&mut self, count: usize) -> Result<(), String> {
        // A usize fits in 64 bits on every platform that Rust supports.
        self.left = self
            .left
            .checked_sub(count as u64)
            .ok_or_else(|| format!("{count} bytes announced, {} left", self.left))?;
        Ok(())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.announce(N)?;
        let mut bytes = [0; N];
        self.from.read_exact(&mut bytes).map_err(|e| e.to_string())?;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    /// A number of groups or fields.
    fn names(&mut self) -> Result<u32, String> {
        let count = self.u32()?;
        if count > MOST_NAMES {
            Err(format!("{count} groups or fields, more than {MOST_NAMES}"))
        } else {
            Ok(count)
        }
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Result<String, String> {
        let length = usize::try_from(self.u32()?).ok().filter(|length| *length <= LONGEST_TEXT);
        let length = length.ok_or_else(|| format!("a name longer than {LONGEST_TEXT} bytes"))?;
        self.announce(length)?;
        let mut bytes = vec![0; length];
        self.from.read_exact(&mut bytes).map_err(|e| e.to_string())?;
        String::from_utf8(bytes).map_err(|_| "a name is no UTF-8".into())
    }

    /// So many values of `N` bytes each.
    fn values<T, const N: usize>(&mut self, count: usize, value: fn([u8; N]) -> T) -> Result<Vec<T>, String> {
        self.announce(count.checked_mul(N).ok_or("an array is too large")?)?;
        let mut values = Vec::new();
        let mut piece = vec![0; N * PIECE.min(count)];
        while values.len() < count {
            let bytes = &mut piece[..N * PIECE.min(count - values.len())];
            self.from.read_exact(bytes).map_err(|e| e.to_string())?;
            let (words, _) = bytes.as_chunks();
            values.extend(words.iter().map(|word| value(*word)));
        }
        Ok(values)
    }
}
