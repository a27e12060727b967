//! The codec of all calls: counts the entries of lists in a message before they are decoded.
//!
//! An entry of two bytes may become a value of hundreds, so that a limit on bytes bounds no memory. The count walks tags and
//! lengths only and allocates nothing. It reads what the decoder reads, in the same order: where it stops at bytes that mean
//! nothing, so does the decoder, which then says what is wrong with them.

use std::marker::PhantomData;

use bytes::Buf;
use prost::Message;
use tonic::Status;
use tonic::codec::{BufferSettings, Codec, DecodeBuf, Decoder};
use tonic_prost::{ProstDecoder, ProstEncoder};

use crate::limits::{MAX_ACCOUNTS, MAX_DEPTH, MAX_ENERGIES, MAX_EVENTS, MAX_LIST};

// Made of the .proto files by `cargo run -p proto-generator`.
include!("../generated/shapes.rs");

/// A message of the protocol, whose lists can be counted.
pub(crate) trait Counted {
    /// Its place in [`SHAPES`].
    const SHAPE: usize;
}

/// What the count must know of a message.
pub(super) struct Shape {
    name: &'static str,
    /// Lists and messages among its fields, by ascending number.
    fields: &'static [Field],
}

/// A field that is a list or a message.
struct Field {
    number: u64,
    name: &'static str,
    /// Which list it is.
    list: Option<usize>,
    entry: Entry,
}

/// How an entry travels.
#[derive(Clone, Copy)]
enum Entry {
    /// A message, of the shape at this place.
    Message(usize),
    /// Text or bytes: one with each tag.
    Text,
    PackedVarint,
}

/// The codec; decodes no message with more entries in a list than allowed.
#[derive(Clone, Debug)]
pub(crate) struct Bounded<T, U>(PhantomData<(T, U)>);

impl<T, U> Default for Bounded<T, U> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<T, U> Codec for Bounded<T, U>
where
    T: Message + Send + 'static,
    U: Message + Default + Counted + Send + 'static,
{
    type Encode = T;
    type Decode = U;
    type Encoder = ProstEncoder<T>;
    type Decoder = BoundedDecoder<U>;

    fn encoder(&mut self) -> Self::Encoder {
        ProstEncoder::default()
    }

    fn decoder(&mut self) -> Self::Decoder {
        BoundedDecoder(ProstDecoder::default())
    }
}

/// Decodes messages whose lists are short enough.
#[derive(Clone, Debug)]
pub(crate) struct BoundedDecoder<U>(ProstDecoder<U>);

impl<U: Message + Default + Counted> Decoder for BoundedDecoder<U> {
    type Item = U;
    type Error = Status;

    fn decode(&mut self, message: &mut DecodeBuf<'_>) -> Result<Option<U>, Status> {
        // A message lies in one piece.
        let bytes = message.chunk();
        if bytes.len() < message.remaining() {
            return Err(Status::internal("a message came in pieces"));
        }
        check::<U>(bytes).map_err(Status::out_of_range)?;
        self.0.decode(message)
    }

    fn buffer_settings(&self) -> BufferSettings {
        self.0.buffer_settings()
    }
}

/// The message in `bytes`, whose lists are counted first.
///
/// # Errors
/// Which list is too long, or where `bytes` are no message.
pub(crate) fn decode<M: Message + Default + Counted>(bytes: impl Buf + AsRef<[u8]>) -> Result<M, String> {
    check::<M>(bytes.as_ref())?;
    M::decode(bytes).map_err(|e| e.to_string())
}

/// Whether no list of message `M` in `bytes` has more entries than allowed.
///
/// # Errors
/// Which one has, how many there are, and how many are allowed.
fn check<M: Counted>(bytes: &[u8]) -> Result<(), String> {
    let mut counts = [0; LISTS];
    // Bytes that are no message end the count; the decoder names them.
    let _ = count(M::SHAPE, bytes, MAX_DEPTH, &mut counts);
    for shape in SHAPES {
        for field in shape.fields {
            let Some(entries) = field.list.and_then(|list| counts.get(list).copied()) else { continue };
            let allowed = most(shape, field);
            if entries > allowed {
                return Err(format!(
                    "`{}.{}`: has {entries} entries in this message, at most {allowed} are allowed",
                    shape.name, field.name
                ));
            }
        }
    }
    Ok(())
}

/// Most entries of a list in one message.
fn most(shape: &Shape, field: &Field) -> usize {
    match (shape.name, field.name) {
        ("EventBatch", "events") => MAX_EVENTS,
        // Two budgets in each event, with all accounts.
        ("StageBudget", "accounts") => 2 * MAX_ACCOUNTS * MAX_EVENTS,
        ("StepReport", "energy_accounts") => MAX_ENERGIES * MAX_EVENTS,
        // One for each dimension.
        (_, "components") => 3 * MAX_LIST,
        _ => MAX_LIST,
    }
}

/// Adds the entries of the lists in a message of `shape` to `counts`; `None` where the bytes mean nothing.
fn count(shape: usize, mut bytes: &[u8], depth: usize, counts: &mut [usize; LISTS]) -> Option<()> {
    let depth = depth.checked_sub(1)?;
    let fields = SHAPES.get(shape)?.fields;
    // A group is skipped with all in it, and its numbers are its own.
    let mut groups = 0_usize;
    while !bytes.is_empty() {
        let key = varint(&mut bytes)?;
        let (number, wire_type) = (key >> 3, key & 7);
        let field = fields.iter().find(|field| field.number == number).filter(|_| groups == 0);
        let mut entries = 1;
        match wire_type {
            0 => drop(varint(&mut bytes)?),
            1 => drop(take(&mut bytes, 8)?),
            2 => {
                let length = usize::try_from(varint(&mut bytes)?).ok()?;
                let inner = take(&mut bytes, length)?;
                match field.map(|field| field.entry) {
                    Some(Entry::Message(shape)) => count(shape, inner, depth, counts)?,
                    Some(Entry::PackedVarint) => {
                        entries = inner.iter().filter(|byte| **byte < 0x80).count();
                    }
                    Some(Entry::Text) | None => {}
                }
            }
            3 => groups += 1,
            4 => groups = groups.checked_sub(1)?,
            5 => drop(take(&mut bytes, 4)?),
            _ => return None,
        }
        if let Some(entry) = field.and_then(|field| field.list).and_then(|list| counts.get_mut(list)) {
            *entry = entry.saturating_add(entries);
        }
    }
    Some(())
}

/// Takes a number of at most ten bytes off the front.
fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for shift in 0..10 {
        let (byte, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << (7 * shift);
        if *byte < 0x80 {
            return Some(value);
        }
    }
    None
}

/// Takes `length` bytes off the front.
fn take<'a>(bytes: &mut &'a [u8], length: usize) -> Option<&'a [u8]> {
    let (taken, rest) = bytes.split_at_checked(length)?;
    *bytes = rest;
    Some(taken)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire;

    fn solid(setup: wire::SolidSetup) -> wire::OpenRequest {
        wire::OpenRequest { setup: Some(wire::open_request::Setup::Solid(setup)), ..Default::default() }
    }

    /// What is said of `message`, encoded.
    fn refusal<M: Message + Counted>(message: &M) -> String {
        check::<M>(&message.encode_to_vec()).unwrap_err()
    }

    #[test]
    fn a_list_of_as_many_entries_as_allowed_passes_and_one_more_is_named_with_both_numbers() {
        let bodies =
            |n| solid(wire::SolidSetup { bodies: vec![Default::default(); n], ..Default::default() });
        assert_eq!(check::<wire::OpenRequest>(&bodies(MAX_LIST).encode_to_vec()), Ok(()));
        assert_eq!(
            refusal(&bodies(MAX_LIST + 1)),
            "`SolidSetup.bodies`: has 65537 entries in this message, at most 65536 are allowed"
        );
        let events = |n| wire::EventBatch { events: vec![Default::default(); n], ..Default::default() };
        assert_eq!(check::<wire::EventBatch>(&events(MAX_EVENTS).encode_to_vec()), Ok(()));
        assert!(refusal(&events(MAX_EVENTS + 1)).starts_with("`EventBatch.events`: has 4097 entries"));
    }

    #[test]
    fn entries_of_nested_lists_count_together_and_texts_and_packed_numbers_count_too() {
        let body = wire::BodySetup { supports: vec![Default::default(); 1000], ..Default::default() };
        let nested = solid(wire::SolidSetup { bodies: vec![body; 66], ..Default::default() });
        assert!(refusal(&nested).starts_with("`BodySetup.supports`: has 66000 entries"));
        let regions = wire::FluidSetup { regions: vec![String::new(); 70_000], ..Default::default() };
        assert!(refusal(&regions).starts_with("`FluidSetup.regions`: has 70000 entries"));
        // One byte on the wire, four in memory.
        let roles = wire::Description { roles: vec![300; 70_000], ..Default::default() };
        assert!(refusal(&roles).starts_with("`Description.roles`: has 70000 entries"));
        // The same, one tag for each.
        let unpacked = [0x38, 0x01].repeat(70_000);
        assert_eq!(wire::Description::decode(&unpacked[..]).unwrap().roles.len(), 70_000);
        assert!(check::<wire::Description>(&unpacked).unwrap_err().contains("has 70000 entries"));
    }

    #[test]
    fn lists_in_fields_that_are_not_known_do_not_count() {
        // Field 99 as text, and a group with a field in it that has the number of `bodies`.
        let bodies = [0x1a, 0x00].repeat(MAX_LIST + 1);
        let mut text = vec![0x9a, 0x06];
        prost::encoding::encode_varint(bodies.len() as u64, &mut text);
        text.extend(&bodies);
        assert_eq!(check::<wire::SolidSetup>(&text), Ok(()));
        let group = [&[0x9b, 0x06][..], &bodies, &[0x9c, 0x06]].concat();
        assert_eq!(check::<wire::SolidSetup>(&group), Ok(()));
        assert_eq!(wire::SolidSetup::decode(&group[..]).unwrap(), Default::default());
        assert!(check::<wire::SolidSetup>(&bodies).is_err());
    }

    /// Numbers that look random; the same each time.
    fn numbers() -> impl FnMut(usize) -> usize {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        move |below| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            usize::try_from(state >> 33).unwrap() % below
        }
    }

    #[test]
    fn the_count_stops_only_where_the_decoder_does() {
        let body = wire::BodySetup {
            name: "body".into(),
            supports: vec![wire::Support { name: "a".into(), ..Default::default() }; 3],
            material: vec![wire::Parameter {
                name: "a".into(),
                value: Some(wire::parameter::Value::Number(1.0)),
            }],
            ..Default::default()
        };
        let good = solid(wire::SolidSetup { bodies: vec![body; 4], ..Default::default() }).encode_to_vec();
        let mut next = numbers();
        let (mut stopped, mut whole) = (0, 0);
        for _ in 0..200_000 {
            let mut bytes = good.clone();
            for _ in 0..1 + next(4) {
                let at = next(bytes.len());
                bytes[at] = u8::try_from(next(256)).unwrap();
            }
            bytes.truncate(1 + next(2 * bytes.len()));
            let mut counts = [0; LISTS];
            let counted = count(wire::OpenRequest::SHAPE, &bytes, MAX_DEPTH, &mut counts).is_some();
            match wire::OpenRequest::decode(&bytes[..]) {
                Ok(message) => {
                    assert!(counted, "the decoder reads on where the count stops: {bytes:?}");
                    if let Some(wire::open_request::Setup::Solid(solid)) = message.setup {
                        let field = SHAPES[wire::SolidSetup::SHAPE].fields.iter().find(|f| f.number == 3);
                        let list = field.and_then(|field| field.list).unwrap();
                        assert!(counts[list] >= solid.bodies.len(), "{bytes:?}");
                    }
                    whole += 1;
                }
                Err(_) => stopped += 1,
            }
        }
        assert!(stopped > 10_000 && whole > 10_000, "{stopped} {whole}");
    }

    #[test]
    fn every_list_of_the_protocol_is_in_the_table_once() {
        let mut seen = vec![0; LISTS];
        for field in SHAPES.iter().flat_map(|shape| shape.fields) {
            field.list.into_iter().for_each(|list| seen[list] += 1);
        }
        assert!(LISTS > 15 && seen.iter().all(|times| *times == 1), "{seen:?}");
    }
}
