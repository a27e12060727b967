//! Which particles a part owns, and which it holds copies of.
//!
//! A part holds copies of all particles that lie within [`RINGS`] cells of its own. Then it finds the states of all walls
//! that its particles meet, and what all particles spread on the nodes that they read, as one fluid would.

use std::ops::Range;

use sph::neighbours::Cells;
use sph::space::Space;

use crate::system::tasks::TASK;
use crate::team::Team;

/// Cells between a particle and those whose copies its part holds. A particle and one that spreads on a node which it reads are
/// two supports apart at most, and lists last until they may have approached by a spacing: with two cells between them,
/// each wider than the support, they could.
const RINGS: usize = 3;

/// The particles of `part` among `total`, which `size` parts divide in equal numbers of whole tasks.
pub fn share(total: usize, part: usize, size: usize) -> Range<usize> {
    let cut = |part: usize| total.min(total.div_ceil(TASK) * part / size * TASK);
    cut(part)..cut(part + 1)
}

/// Number of particles in each cell that has any, by cell.
pub type Occupancy = Vec<(u32, u32)>;

/// The occupancy by particles whose cells are `cells`, in order.
pub fn occupancy(cells: impl Iterator<Item = u32>) -> Occupancy {
    let mut occupancy = Occupancy::new();
    for cell in cells {
        match occupancy.last_mut() {
            Some((last, count)) if *last == cell => *count += 1,
            _ => occupancy.push((cell, 1)),
        }
    }
    occupancy
}

/// Particles of one cell that one part has brought along.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Their cell.
    pub cell: u32,
    /// The part.
    pub part: usize,
    /// The number of the first among all particles.
    pub first: usize,
    /// How many there are.
    pub count: usize,
}

/// The order of the particles of all parts: by cell, within a cell as before.
#[derive(Clone, Debug, Default)]
pub struct Partition {
    pieces: Vec<Piece>,
    /// Number of the first particle of each part among all, and that of all particles.
    cuts: Vec<usize>,
}

impl Partition {
    /// The order of particles of which each part has those in `occupancy`, divided among the parts in equal numbers of
    /// whole tasks.
    pub fn of(team: &Team, occupancy: Occupancy) -> Self {
        let (pieces, total) = pieces(team.all(occupancy));
        let cuts = (0..=team.size()).map(|part| share(total, part, team.size()).start).collect();
        Self { pieces, cuts }
    }

    /// The order of particles that lie in it already, of which each part keeps those that it has.
    pub fn as_it_is(team: &Team, occupancy: Occupancy) -> Self {
        let all = team.all(occupancy);
        let count = |occupancy: &Occupancy| occupancy.iter().map(|(_, count)| *count as usize).sum::<usize>();
        let cuts = std::iter::once(0).chain(all.iter().scan(0, |end, part| {
            *end += count(part);
            Some(*end)
        }));
        let cuts = cuts.collect();
        Self { pieces: pieces(all).0, cuts }
    }

    /// Number of particles.
    pub fn total(&self) -> usize {
        self.cuts.last().copied().unwrap_or_default()
    }

    /// The particles by cell and by the part that has brought them along.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The particles of `part`, by their numbers among all.
    pub fn of_part(&self, part: usize) -> Range<usize> {
        self.cuts[part]..self.cuts[part + 1]
    }

    /// The part that owns the particle `number`.
    pub fn owner(&self, number: usize) -> usize {
        self.cuts.partition_point(|cut| *cut <= number).saturating_sub(1)
    }

    /// `range` of the numbers of particles by owners.
    pub fn by_owner(&self, range: Range<usize>) -> impl Iterator<Item = (usize, Range<usize>)> + '_ {
        let mut rest = range;
        std::iter::from_fn(move || {
            if rest.is_empty() {
                return None;
            }
            let owner = self.owner(rest.start);
            let own = rest.start..rest.end.min(self.cuts[owner + 1]);
            rest.start = own.end;
            Some((owner, own))
        })
    }

    /// The part in whose cells `cell` lies: it holds all particles near it.
    pub fn owner_of_cell(&self, cell: u32) -> usize {
        let last = self.total().saturating_sub(1);
        self.owner(self.first_of_cells_from(cell as usize).min(last))
    }

    /// Number of the first particle in the cells from `cell` on.
    fn first_of_cells_from(&self, cell: usize) -> usize {
        let piece = self.pieces.partition_point(|piece| (piece.cell as usize) < cell);
        self.pieces.get(piece).map_or(self.total(), |piece| piece.first)
    }

    /// Cell of the particle `number`.
    fn cell_of(&self, number: usize) -> usize {
        let piece = self.pieces.partition_point(|piece| piece.first <= number);
        self.pieces[piece - 1].cell as usize
    }

    /// The cells of `part`, including those without particles before its own; none without particles.
    fn cells_of(&self, part: usize, cells: usize) -> Option<Range<usize>> {
        let own = self.of_part(part);
        if own.is_empty() {
            return None;
        }
        let first = match own.start {
            0 => 0,
            start => self.cell_of(start).min(self.cell_of(start - 1) + 1),
        };
        let end = if own.end == self.total() { cells } else { self.cell_of(own.end - 1) + 1 };
        Some(first..end)
    }

    /// Numbers of the particles near those of `part`, which lie in `cells`, in ascending ranges, with its own ones.
    pub fn near<S: Space>(&self, part: usize, cells: &Cells<S>) -> Vec<Range<usize>> {
        let Some(own) = self.cells_of(part, cells.number()) else { return Vec::new() };
        let (counts, periodic, number) = (cells.counts(), cells.periodic(), cells.number());
        // Cells of a row follow each other, then rows: all that is near lies in a range, or in one across the last cell.
        let (mut reach, mut stride) = (0, 1);
        for axis in 0..S::DIMENSIONS {
            let last = axis + 1 == S::DIMENSIONS;
            let steps = if periodic[axis] && !last { counts[axis] - 1 } else { RINGS.min(counts[axis] - 1) };
            reach += steps * stride;
            stride *= counts[axis];
        }
        let (start, end) = (own.start.saturating_sub(reach), (own.end + reach).min(number));
        let (mut before, mut after) = (0, 0);
        if periodic[S::DIMENSIONS - 1] {
            before = reach.saturating_sub(own.start).min(number);
            after = (own.end + reach).saturating_sub(number).min(number);
        }
        let near = [start..end, number - before..number, 0..after];
        joined(
            near.into_iter()
                .map(|cells| self.first_of_cells_from(cells.start)..self.first_of_cells_from(cells.end)),
        )
    }
}

/// Pieces of the particles of which each part has brought along those of its occupancy, and their number.
fn pieces(by_part: Vec<Occupancy>) -> (Vec<Piece>, usize) {
    let mut pieces: Vec<Piece> = Vec::new();
    for (part, occupancy) in by_part.into_iter().enumerate() {
        pieces.extend(occupancy.iter().map(|(cell, count)| Piece {
            cell: *cell,
            part,
            first: 0,
            count: *count as usize,
        }));
    }
    pieces.sort_by_key(|piece| (piece.cell, piece.part));
    let mut total = 0;
    for piece in &mut pieces {
        piece.first = total;
        total += piece.count;
    }
    (pieces, total)
}

/// Ranges in ascending order, those that touch joined to one.
fn joined(ranges: impl Iterator<Item = Range<usize>>) -> Vec<Range<usize>> {
    let mut ranges: Vec<_> = ranges.filter(|range| !range.is_empty()).collect();
    ranges.sort_by_key(|range| range.start);
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => joined.push(range),
        }
    }
    joined
}
