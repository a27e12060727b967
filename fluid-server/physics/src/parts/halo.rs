//! The copies of particles of other parts that a part holds.
//!
//! Arrays of a part hold its own particles, then the copies by their owners; a part that is alone has no copies.

use sph::space::components::Components;

use super::bricks::Bricks;
use super::lattice::Lattice;
use super::reach::Reach;
use crate::system::packed_particle::FluidSpace;
use crate::team::Team;
use crate::team::transport::Channel;

/// Most components of a quantity.
const MOST_COMPONENTS: usize = 16;

/// Where copies lie, and who gets which.
#[derive(Clone, Debug, Default)]
pub struct Halo {
    /// Number of own particles, which come before the copies.
    own: usize,
    /// Cells between each copy and what this part owns, at least 1.
    rings: Vec<u8>,
    /// By [`Reach`].
    routes: [Routes; 3],
}

/// Ways of copies from and to other parts.
#[derive(Clone, Debug, Default)]
struct Routes {
    /// Own particles that other parts hold copies of.
    outgoing: Vec<(usize, Vec<u32>)>,
    /// Places of the copies by their owners.
    incoming: Vec<(usize, Vec<u32>)>,
}

impl Halo {
    /// The halo of this part, whose own particles lie in `cells` of `lattice`, among parts that own what `bricks` say.
    pub fn new<S: FluidSpace>(team: &Team, lattice: &Lattice<S>, bricks: &Bricks<S>, cells: &[u32]) -> Self {
        let shape = lattice.cells();
        let own_cells = bricks.cells(lattice, team.rank());
        let mut halo = Self { own: cells.len(), ..Self::default() };
        // Both of two parts find that they are near.
        let near: Vec<_> = (0..team.size())
            .filter(|part| *part != team.rank())
            .map(|part| (part, bricks.cells(lattice, part)))
            .filter(|(_, other)| {
                own_cells.distance(other).is_some_and(|distance| distance <= Reach::FARTHEST.rings())
            })
            .collect();
        for (part, other) in &near {
            let mut given: Vec<(u32, u8)> = Vec::new();
            let mut last: Option<(u32, Option<usize>)> = None;
            for (i, cell) in (0u32..).zip(cells) {
                let distance = match last {
                    Some((known, distance)) if known == *cell => distance,
                    _ => other.distance_to_cell(shape.place(*cell)),
                };
                last = Some((*cell, distance));
                if let Some(distance) = distance.filter(|distance| *distance <= Reach::FARTHEST.rings()) {
                    // At most three.
                    given.push((i, distance as u8));
                }
            }
            team.send(*part, Channel::Copies, given.iter().map(|(_, ring)| *ring).collect());
            for reach in Reach::ALL {
                let within = given.iter().filter(|(_, ring)| usize::from(*ring) <= reach.rings());
                let outgoing: Vec<u32> = within.map(|(i, _)| *i).collect();
                if !outgoing.is_empty() {
                    halo.routes[reach.rings() - 1].outgoing.push((*part, outgoing));
                }
            }
        }
        for (part, _) in &near {
            let taken = team.receive(*part, Channel::Copies);
            for reach in Reach::ALL {
                // Indices of particles are of 32 bits.
                let places = (halo.places() as u32..).zip(&taken);
                let within = places.filter(|(_, ring)| usize::from(**ring) <= reach.rings());
                let incoming: Vec<u32> = within.map(|(place, _)| place).collect();
                if !incoming.is_empty() {
                    halo.routes[reach.rings() - 1].incoming.push((*part, incoming));
                }
            }
            halo.rings.extend(taken);
        }
        halo
    }

    /// Number of own particles, which come before the copies.
    pub fn own(&self) -> usize {
        self.own
    }

    /// Number of copies.
    pub fn copies(&self) -> usize {
        self.rings.len()
    }

    /// Number of own particles and copies.
    pub fn places(&self) -> usize {
        self.own + self.rings.len()
    }

    /// Whether the particle at `place` is an own one or a copy within `reach`.
    #[inline(always)]
    pub fn is_within(&self, reach: Reach, place: usize) -> bool {
        place < self.own || usize::from(self.rings[place - self.own]) <= reach.rings()
    }

    fn routes(&self, reach: Reach) -> &Routes {
        &self.routes[reach.rings() - 1]
    }

    /// Sends what `write` appends for each own particle to the parts that hold copies of it within `reach`.
    pub fn send(&self, team: &Team, reach: Reach, write: impl Fn(usize, &mut Vec<u8>)) {
        for (part, particles) in &self.routes(reach).outgoing {
            let mut message = Vec::new();
            for (k, i) in particles.iter().enumerate() {
                write(*i as usize, &mut message);
                if k == 0 {
                    // All particles take the same room.
                    message.reserve_exact((particles.len() - 1) * message.len());
                }
            }
            team.send(*part, Channel::Copies, message);
        }
    }

    /// Waits for what the others have sent, and calls `read` for the place of each copy with what comes next.
    pub fn receive(&self, team: &Team, reach: Reach, mut read: impl FnMut(usize, &mut Bytes)) {
        for (part, places) in &self.routes(reach).incoming {
            let message = team.receive(*part, Channel::Copies);
            let mut bytes = Bytes(&message);
            places.iter().for_each(|place| read(*place as usize, &mut bytes));
        }
    }

    /// The values of `own` particles with those of all copies.
    pub fn with_copies<C: Components + Default>(&self, team: &Team, own: &[C]) -> Vec<C> {
        let mut values = vec![C::default(); self.places()];
        values[..own.len()].copy_from_slice(own);
        self.send(team, Reach::FARTHEST, |i, message| put(message, own[i]));
        self.receive(team, Reach::FARTHEST, |place, bytes| values[place] = bytes.take());
        values
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        let ways = self.routes.iter().flat_map(|routes| routes.outgoing.iter().chain(&routes.incoming));
        self.rings.capacity() + ways.map(|(_, particles)| 4 * particles.capacity()).sum::<usize>()
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
