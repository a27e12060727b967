//! Snapshots, which travel in chunks beside the events.

use std::collections::VecDeque;

use bytes::{Buf, BufMut, Bytes, BytesMut};
use sph::coupling::solver::{Field, ParticleFields};

use super::arrays::{unpack_all, unpack_indices_below};
use super::{Path, WireError, count, finite, length, name, text};
use crate::limits::{CHUNK_BYTES, EAGER_BYTES, MAX_LIST, MAX_PARTICLES};
use crate::wire;
use crate::wire::snapshot_chunk::Part;

/// Most numbers of one field per particle: a full tensor in space.
const MAX_COMPONENTS: usize = 9;
/// Most fields of a snapshot.
const MAX_FIELDS: usize = 256;

/// Snapshot number `index` as the chunks that carry it, header first. Each is made when it is asked for, and each array
/// goes when it has been packed.
pub(crate) fn snapshot_chunks(
    run_id: &str,
    index: u64,
    snapshot: ParticleFields,
) -> impl Iterator<Item = wire::SnapshotChunk> + use<> {
    let header = wire::SnapshotHeader {
        index,
        step: snapshot.step,
        time_s_bits: snapshot.time.to_bits(),
        count: count(snapshot.id.len()),
        group_names: snapshot.group_names,
        fields: snapshot
            .fields
            .iter()
            .map(|field| wire::SnapshotField {
                name: field.name.clone(),
                unit: field.unit.clone(),
                // Components are few; a field beyond that is refused by the receiver.
                components: u32::try_from(field.components).unwrap_or(u32::MAX),
            })
            .collect(),
    };
    let indices = [snapshot.id, snapshot.group].into_iter().map(Numbers::Index);
    let numbers = snapshot.fields.into_iter().map(|field| Numbers::Real(field.values));
    let mut unsent: VecDeque<(Numbers, usize)> = indices.chain(numbers).map(|values| (values, 0)).collect();
    let run_id = run_id.to_owned();
    let pieces = std::iter::from_fn(move || next_piece(&mut unsent).map(Part::Data));
    std::iter::once(Part::Header(header))
        .chain(pieces)
        .map(move |part| wire::SnapshotChunk { run_id: run_id.clone(), part: Some(part) })
}

/// Numbers of a snapshot that are still to be sent.
enum Numbers {
    Index(Vec<u32>),
    Real(Vec<f64>),
}

impl Numbers {
    /// Packs numbers from number `start` on while `out` has room; answers the number of the next, `None` where all are packed.
    fn pack(&self, start: usize, out: &mut BytesMut) -> Option<usize> {
        let room = CHUNK_BYTES - out.len();
        let end = |count: usize, size: usize| count.min(start + room / size);
        let (end, count) = match self {
            Self::Index(values) => {
                let end = end(values.len(), size_of::<u32>());
                values[start..end].iter().for_each(|value| out.put_u32_le(*value));
                (end, values.len())
            }
            Self::Real(values) => {
                let end = end(values.len(), size_of::<f64>());
                values[start..end].iter().for_each(|value| out.put_f64_le(*value));
                (end, values.len())
            }
        };
        (end < count).then_some(end)
    }
}

/// The next piece of at most [`CHUNK_BYTES`]; each of `unsent` comes with the number of its first value that is.
fn next_piece(unsent: &mut VecDeque<(Numbers, usize)>) -> Option<Bytes> {
    let mut piece = BytesMut::new();
    while let Some((numbers, start)) = unsent.front_mut() {
        if piece.is_empty() {
            piece.reserve(CHUNK_BYTES);
        }
        match numbers.pack(*start, &mut piece) {
            Some(next) => {
                *start = next;
                break;
            }
            None => {
                unsent.pop_front();
            }
        }
    }
    (!piece.is_empty()).then(|| piece.freeze())
}

/// Puts snapshots together from their chunks.
#[derive(Default)]
pub(crate) struct SnapshotAssembler {
    current: Option<Partial>,
}

struct Partial {
    header: wire::SnapshotHeader,
    count: usize,
    total: usize,
    data: BytesMut,
}

impl SnapshotAssembler {
    /// Takes the next chunk; answers the snapshot and its number when it is complete.
    pub(crate) fn take(
        &mut self,
        chunk: wire::SnapshotChunk,
    ) -> Result<Option<(u64, ParticleFields)>, WireError> {
        let at = Path::root("snapshot");
        let mut partial = match (chunk.part, self.current.take()) {
            (Some(Part::Header(header)), None) => Partial::new(header, &at.field("header"))?,
            (Some(Part::Data(data)), Some(mut partial)) => {
                partial.add(&data, &at.field("data"))?;
                partial
            }
            (Some(Part::Header(_)), Some(_)) => {
                return Err(at.field("header").error("came before the snapshot in progress was complete"));
            }
            (Some(Part::Data(_)), None) => return Err(at.field("data").error("came before a header")),
            (None, _) => return Err(at.field("part").error("is missing")),
        };
        if partial.data.len() < partial.total {
            self.current = Some(partial);
            return Ok(None);
        }
        let index = partial.header.index;
        partial.finish(&at).map(|snapshot| Some((index, snapshot)))
    }
}

impl Partial {
    fn new(header: wire::SnapshotHeader, at: &Path<'_>) -> Result<Self, WireError> {
        length(header.fields.len(), MAX_FIELDS, &at.field("fields"))?;
        length(header.group_names.len(), MAX_LIST, &at.field("group_names"))?;
        let Some(count) = usize::try_from(header.count).ok().filter(|count| *count <= MAX_PARTICLES) else {
            let problem = format!("is {}, at most {MAX_PARTICLES} are allowed", header.count);
            return Err(at.field("count").error(problem));
        };
        let mut components = 0;
        for (k, field) in header.fields.iter().enumerate() {
            let at = at.item("fields", k);
            name(&field.name, &at.field("name"))?;
            text(&field.unit, &at.field("unit"))?;
            components += usize::try_from(field.components)
                .ok()
                .filter(|c| (1..=MAX_COMPONENTS).contains(c))
                .ok_or_else(|| {
                    let problem = format!("is {}, must be 1 to {MAX_COMPONENTS}", field.components);
                    at.field("components").error(problem)
                })?;
        }
        // At most 2^26 particles of 2 + 256 * 9 numbers: no overflow in 64 bits.
        let total = count * 8 * (1 + components);
        Ok(Self { header, count, total, data: BytesMut::with_capacity(total.min(EAGER_BYTES)) })
    }

    fn add(&mut self, data: &Bytes, at: &Path<'_>) -> Result<(), WireError> {
        let left = self.total - self.data.len();
        if data.is_empty() || data.len() > left {
            return Err(at.error(format!("has {} bytes where 1 to {left} were expected", data.len())));
        }
        self.data.extend_from_slice(data);
        Ok(())
    }

    fn finish(&mut self, at: &Path<'_>) -> Result<ParticleFields, WireError> {
        let count = self.count;
        let mut data = std::mem::take(&mut self.data).freeze();
        let names = &self.header.group_names;
        let id = unpack_indices_below(&data.split_to(4 * count), count, usize::MAX, "ids", &at.field("ids"))?;
        let groups = data.split_to(4 * count);
        let group = unpack_indices_below(&groups, count, names.len(), "groups", &at.field("groups"))?;
        let mut fields = Vec::with_capacity(self.header.fields.len());
        for field in &self.header.fields {
            let components = usize::try_from(field.components).unwrap_or(usize::MAX);
            let values = unpack_all(&data.split_to(8 * count * components), &at.field("values"))?;
            fields.push(Field { name: field.name.clone(), unit: field.unit.clone(), components, values });
        }
        debug_assert!(!data.has_remaining(), "the total is the sum of the parts");
        Ok(ParticleFields {
            step: self.header.step,
            time: finite(f64::from_bits(self.header.time_s_bits), &at.field("time_s_bits"))?,
            id,
            group,
            group_names: names.clone(),
            fields,
        })
    }
}
