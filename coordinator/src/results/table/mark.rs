//! What a table held at a checkpoint, so that a later change of rows that were written is found.

use std::io::{self, Read, Write};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Places that are kept at most; when there are as many, every second one goes.
const MOST_PLACES: usize = 64;
/// Bytes that are read at once.
const PIECE: usize = 1 << 16;

/// A table up to the end of one of its rows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Place {
    /// Bytes.
    length: u64,
    /// Rows, without the line of names.
    rows: u64,
    /// SHA-256 of these bytes.
    sha256: [u8; 32],
}

/// What a table held at a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TableMark {
    end: Place,
    /// First value of the last row; minus infinity without rows.
    last: f64,
    /// Places before, which confine a change.
    places: Vec<Place>,
    /// Rows between them.
    every: u64,
}

/// How a file differs from a mark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Difference {
    /// It has this many bytes, fewer than then.
    Shorter(u64),
    /// Lines from the first to the last of these, the line of names being 1, are not those that were written.
    Changed(u64, u64),
}

impl TableMark {
    /// Bytes of the table.
    pub fn length(&self) -> u64 {
        self.end.length
    }

    /// First value of the last row; minus infinity without rows.
    pub(super) fn last(&self) -> f64 {
        self.last
    }

    /// Compares what `file`, read from its start, holds with this mark. What comes after it does not count.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub(super) fn compare(&self, file: &mut impl Read) -> io::Result<Result<Before, Difference>> {
        let (mut hash, mut read, mut before) = (Sha256::new(), 0, 0);
        let mut piece = vec![0; PIECE];
        for place in self.places.iter().chain([&self.end]) {
            while read < place.length {
                let wanted = usize::try_from(place.length - read).map_or(PIECE, |left| left.min(PIECE));
                match file.read(&mut piece[..wanted]) {
                    Ok(0) => return Ok(Err(Difference::Shorter(read))),
                    Ok(count) => {
                        hash.update(&piece[..count]);
                        // At most 64 KiB.
                        read += count as u64;
                    }
                    Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                    Err(e) => return Err(e),
                }
            }
            if <[u8; 32]>::from(hash.clone().finalize()) != place.sha256 {
                let from = if before == 0 { 1 } else { before + 2 };
                return Ok(Err(Difference::Changed(from, place.rows + 1)));
            }
            before = place.rows;
        }
        Ok(Ok(Before { hash, length: read, rows: self.end.rows, last: self.last }))
    }
}

/// Writes to `to` and keeps count and digest of it.
#[derive(Debug)]
pub(super) struct Marked<W> {
    pub(super) to: W,
    hash: Sha256,
    length: u64,
    rows: u64,
    last: f64,
    places: Vec<Place>,
    every: u64,
}

/// A digest, count and last value to which a table may be taken back.
#[derive(Clone, Debug)]
pub(super) struct Before {
    hash: Sha256,
    length: u64,
    rows: u64,
    last: f64,
}

impl<W> Marked<W> {
    /// An empty table, or one of which `to` holds nothing yet that counts.
    pub fn new(to: W) -> Self {
        let (hash, last) = (Sha256::new(), f64::NEG_INFINITY);
        Self { to, hash, length: 0, rows: 0, last, places: Vec::new(), every: 1 }
    }

    /// The table of `mark`, which `to` holds up to there.
    pub fn resumed(to: W, at: Before, mark: &TableMark) -> Self {
        let Before { hash, length, rows, last } = at;
        Self { to, hash, length, rows, last, places: mark.places.clone(), every: mark.every.max(1) }
    }

    /// The same table, written to `to` from here on.
    pub fn over<V>(self, to: V) -> Marked<V> {
        let Self { to: _, hash, length, rows, last, places, every } = self;
        Marked { to, hash, length, rows, last, places, every }
    }

    /// Bytes so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Rows so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Takes in bytes that `to` holds already.
    pub fn take_in(&mut self, bytes: &[u8]) {
        self.hash.update(bytes);
        // A usize fits in 64 bits on every platform that Rust supports.
        self.length += bytes.len() as u64;
    }

    /// Notes that a row which begins with `first` is complete.
    pub fn row_ends(&mut self, first: f64) {
        self.rows += 1;
        self.last = first;
        if !self.rows.is_multiple_of(self.every) {
            return;
        }
        if self.places.len() == MOST_PLACES {
            self.every *= 2;
            let every = self.every;
            self.places.retain(|place| place.rows.is_multiple_of(every));
        }
        if self.rows.is_multiple_of(self.every) {
            self.places.push(self.place(&self.now()));
        }
    }

    /// How it stands.
    pub fn now(&self) -> Before {
        Before { hash: self.hash.clone(), length: self.length, rows: self.rows, last: self.last }
    }

    fn place(&self, at: &Before) -> Place {
        Place { length: at.length, rows: at.rows, sha256: at.hash.clone().finalize().into() }
    }

    /// The mark of how it stood `at` that moment.
    pub fn mark(&self, at: &Before) -> TableMark {
        TableMark {
            end: self.place(at),
            last: at.last,
            places: self.places.iter().filter(|place| place.rows <= at.rows).cloned().collect(),
            every: self.every,
        }
    }
}

impl<W: Write> Write for Marked<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.to.write(bytes)?;
        self.take_in(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}
