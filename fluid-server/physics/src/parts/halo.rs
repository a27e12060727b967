//! The copies of particles of other parts that a part holds.
//!
//! Arrays of a part hold its own particles and its halo in the order of all particles; a part that is alone has no halo.

use std::ops::Range;

use sph::neighbours::Cells;
use sph::space::Space;
use sph::space::components::Components;

use super::partition::Partition;
use crate::team::Team;

/// Most components of a quantity.
const MOST_COMPONENTS: usize = 16;

/// Where copies lie, and who gets which.
#[derive(Clone, Debug, Default)]
pub struct Halo {
    /// Number of copies before the own particles.
    before: usize,
    /// Number of copies.
    copies: usize,
    /// Own particles that other parts hold copies of.
    outgoing: Vec<(usize, Vec<Range<usize>>)>,
    /// Places of the copies by their owners.
    incoming: Vec<(usize, Vec<Range<usize>>)>,
}

impl Halo {
    /// The halo of this part in `partition`, whose particles lie in `cells`.
    pub fn new<S: Space>(team: &Team, partition: &Partition, cells: &Cells<S>) -> Self {
        let (rank, own) = (team.rank(), partition.of_part(team.rank()));
        let mut halo = Self::default();
        let mut incoming: Vec<Vec<Range<usize>>> = vec![Vec::new(); team.size()];
        let mut place = 0;
        for range in partition.near(rank, cells) {
            for (owner, range) in partition.by_owner(range) {
                let end = place + range.len();
                if owner != rank {
                    halo.before += if range.end <= own.start { range.len() } else { 0 };
                    halo.copies += range.len();
                    incoming[owner].push(place..end);
                }
                place = end;
            }
        }
        halo.incoming = incoming.into_iter().enumerate().filter(|(_, places)| !places.is_empty()).collect();
        for part in (0..team.size()).filter(|part| *part != rank) {
            let of_own = |range: Range<usize>| range.start.max(own.start)..range.end.min(own.end);
            let ranges = partition.near(part, cells).into_iter().map(of_own);
            let ranges: Vec<_> = ranges
                .filter(|range| !range.is_empty())
                .map(|range| range.start - own.start..range.end - own.start)
                .collect();
            if !ranges.is_empty() {
                halo.outgoing.push((part, ranges));
            }
        }
        halo
    }

    /// Number of copies before the own particles, which is the place of the first of them.
    pub fn before(&self) -> usize {
        self.before
    }

    /// The places of the own particles among all `places`.
    #[inline(always)]
    pub fn own(&self, places: usize) -> Range<usize> {
        self.before..self.before + places - self.copies
    }

    /// Number of places for `own` particles and the copies.
    pub fn places(&self, own: usize) -> usize {
        own + self.copies
    }

    /// Sends what `write` appends for each own particle to the parts that hold copies of it.
    pub fn send(&self, team: &Team, write: impl Fn(usize, &mut Vec<u8>)) {
        for (part, ranges) in &self.outgoing {
            let mut message = Vec::new();
            ranges.iter().cloned().flatten().for_each(|i| write(i, &mut message));
            team.send(*part, message);
        }
    }

    /// Waits for what the others have sent, and calls `read` for the place of each copy with what comes next.
    pub fn receive(&self, team: &Team, mut read: impl FnMut(usize, &mut Bytes)) {
        for (part, places) in &self.incoming {
            let message = team.receive(*part);
            let mut bytes = Bytes(&message);
            places.iter().cloned().flatten().for_each(|place| read(place, &mut bytes));
        }
    }

    /// The values of `own` particles with those of the copies.
    pub fn with_copies<C: Components + Default>(&self, team: &Team, own: &[C]) -> Vec<C> {
        let mut values = vec![C::default(); self.places(own.len())];
        let places = self.own(values.len());
        values[places].copy_from_slice(own);
        self.send(team, |i, message| put(message, own[i]));
        self.receive(team, |place, bytes| values[place] = bytes.take());
        values
    }
}

/// Appends `quantity` to `message`.
pub fn put<C: Components>(message: &mut Vec<u8>, quantity: C) {
    quantity.row().as_ref().iter().for_each(|number| message.extend_from_slice(&number.to_le_bytes()));
}

/// What is left of a message.
#[derive(Clone, Copy, Debug)]
pub struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    /// The next quantity.
    pub fn take<C: Components + Default>(&mut self) -> C {
        let mut numbers = [0.0; MOST_COMPONENTS];
        for number in &mut numbers[..C::COUNT] {
            *number = self.number();
        }
        C::of_row(&numbers[..C::COUNT]).unwrap_or_default()
    }

    /// The next number.
    pub fn number(&mut self) -> f64 {
        let Some((number, rest)) = self.0.split_first_chunk() else {
            panic!("a message between parts of the fluid is too short")
        };
        self.0 = rest;
        f64::from_le_bytes(*number)
    }

    /// The next truth value.
    pub fn flag(&mut self) -> bool {
        let Some((flag, rest)) = self.0.split_first() else {
            panic!("a message between parts of the fluid is too short")
        };
        self.0 = rest;
        *flag != 0
    }
}
