//! Neighbour lists in whole batches of lanes.

use sph::lanes::{Arithmetic, LanePass, Lanes, WIDTH};
use sph::neighbours::{CellGrid, Cells};
use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::geometry::Geometry;
use sph::tasks::PerTask;

use crate::system::tasks::{TASK, for_each_task};

/// The set bits of each number below 16, lowest first.
const SET_BITS: [[u32; WIDTH]; 16] = set_bits();

const fn set_bits() -> [[u32; WIDTH]; 16] {
    let mut table = [[0; WIDTH]; 16];
    let mut bits = 0;
    while bits < 16 {
        let (mut lane, mut count) = (0, 0);
        while lane < WIDTH {
            if bits >> lane & 1 == 1 {
                // Below WIDTH.
                table[bits][count] = lane as u32;
                count += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
}

/// Padding of the last batch of a row: a neighbour that adds nothing to a sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Padding {
    /// The target itself, which is left out of its own row; targets are the first sources.
    #[default]
    Target,
    /// This index, beyond the sources.
    Index(u32),
}

/// Indices of the sources.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// Those before they were binned.
    #[default]
    AsGiven,
    /// Those in the order of cells: the owner of the sources sorts them by it.
    ByCell,
}

/// Sources in the order of their cells.
#[derive(Debug, Default)]
pub struct Sources<S: Space> {
    kept: Order,
    grid: CellGrid<S>,
    /// Positions in that order \[m\], where the owner of the sources keeps another.
    position: Vec<S::Vector>,
    /// Place of each source in that order, where it is needed.
    places: Vec<u32>,
}

impl<S: Space> Sources<S> {
    /// No sources yet.
    pub fn new(kept: Order) -> Self {
        Self { kept, ..Self::default() }
    }

    /// Bins `positions` \[m\] for searches within `radius` \[m\].
    pub fn bin(&mut self, domain: &Domain<S>, positions: &[S::Vector], radius: f64) {
        self.grid.renew(domain, positions, radius);
    }

    /// Keeps the order of the sources from here on, which are binned again.
    pub fn keep(&mut self, kept: Order) {
        self.kept = kept;
    }

    /// Index of the source at `place` in the order of cells.
    #[inline(always)]
    pub fn given(&self, place: usize) -> usize {
        match self.kept {
            Order::AsGiven => self.grid.order()[place] as usize,
            Order::ByCell => place,
        }
    }

    /// Bins `positions` \[m\] into `cells`.
    pub fn bin_in(&mut self, cells: Cells<S>, domain: &Domain<S>, positions: &[S::Vector]) {
        self.grid.renew_in(cells, domain, positions);
    }

    /// Takes the positions \[m\] of the sources that were binned, unless their owner has sorted them.
    pub fn place(&mut self, domain: &Domain<S>, positions: &[S::Vector]) {
        let Self { kept, grid, position, .. } = self;
        if *kept == Order::AsGiven {
            position.clear();
            position.extend(grid.order().iter().map(|given| domain.wrapped(&positions[*given as usize])));
        }
    }

    /// Finds the places of the sources in the order of cells, for targets that are among them.
    pub fn find_places(&mut self) {
        self.places.resize(self.grid.order().len(), 0);
        for (place, given) in (0u32..).zip(self.grid.order()) {
            self.places[*given as usize] = place;
        }
    }

    /// The sources in the order of cells, of which `given` \[m\] are all, inside the box, where they are sorted.
    fn placed<'a>(&'a self, given: &'a [S::Vector]) -> &'a [S::Vector] {
        match self.kept {
            Order::AsGiven => &self.position,
            Order::ByCell => given,
        }
    }

    /// The cells.
    pub fn grid(&self) -> &CellGrid<S> {
        &self.grid
    }

    /// Bytes in use, without the cells.
    pub fn bytes(&self) -> usize {
        size_of::<S::Vector>() * self.position.capacity()
            + 4 * self.places.capacity()
            + 8 * self.order().len()
    }

    /// [`Sources::order`], and memory for as many numbers that is free until the next binning.
    pub fn order_and_spare(&mut self) -> (&[u32], &mut Vec<u32>) {
        self.grid.order_and_spare()
    }

    /// Old index of each source in the order of cells.
    pub fn order(&self) -> &[u32] {
        self.grid.order()
    }
}

/// Parameters of a neighbour search.
#[derive(Clone, Copy, Debug)]
pub struct Search<'a, G, S: Space> {
    /// Instructions.
    pub arithmetic: Arithmetic,
    /// Nearest images.
    pub geometry: G,
    /// The box.
    pub domain: &'a Domain<S>,
    /// Distance below which a source is a neighbour \[m\].
    pub radius: f64,
}

/// Whose neighbours are sought.
#[derive(Clone, Copy, Debug)]
pub struct Targets<'a, S: Space> {
    /// Their positions \[m\].
    pub position: &'a [S::Vector],
    /// Which of them are asked for; `None` for all.
    pub asked: Option<&'a [bool]>,
}

/// For each target the indices of its neighbours, in batches.
#[derive(Debug, Default)]
pub struct Rows {
    chunks: Vec<Chunk>,
    padding: Padding,
}

/// Rows of [`TASK`] targets.
#[derive(Debug, Default)]
struct Chunk {
    /// End of each row, in batches.
    ends: Vec<u32>,
    /// Indices; there may be room at the end.
    indices: Vec<u32>,
}

impl Rows {
    /// The row of target `i`.
    #[inline(always)]
    pub fn of(&self, i: usize) -> &[[u32; WIDTH]] {
        self.chunks[i / TASK].row(i % TASK)
    }

    /// The neighbours of target `i` one by one.
    pub fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        let padding = match self.padding {
            Padding::Target => i,
            Padding::Index(index) => index as usize,
        };
        self.of(i).as_flattened().iter().map(|j| *j as usize).filter(move |j| *j != padding)
    }

    /// Whether target `i` has a neighbour whose index is `first` at least.
    #[inline]
    pub fn has_from(&self, i: usize, first: usize) -> bool {
        let padding = match self.padding {
            Padding::Target => i as u32,
            Padding::Index(index) => index,
        };
        let is_one = |j: &u32| (*j as usize >= first) & (*j != padding);
        self.of(i).as_flattened().iter().fold(false, |any, j| any | is_one(j))
    }

    /// Number of batches of target `i`; 0 where there is none.
    pub fn work(&self, i: usize) -> f64 {
        let chunk = self.chunks.get(i / TASK).filter(|chunk| i % TASK < chunk.ends.len());
        chunk.map_or(0.0, |chunk| chunk.row(i % TASK).len() as f64)
    }

    /// Number of batches.
    pub fn batches(&self) -> usize {
        self.chunks.iter().map(|chunk| chunk.ends.last().map_or(0, |end| *end as usize)).sum()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        self.chunks.iter().map(|chunk| 4 * (chunk.ends.capacity() + chunk.indices.capacity())).sum()
    }

    /// All sources, which are at `given` \[m\], closer than the radius of `search` to each of `targets`; none for those that
    /// are not asked for.
    ///
    /// Neighbours follow each other by cell, then as in [`Sources::order`].
    pub fn build<S: Space, G: Geometry<S>>(
        &mut self,
        search: &Search<G, S>,
        sources: &Sources<S>,
        given: &[S::Vector],
        targets: Targets<'_, S>,
        padding: Padding,
    ) {
        let positions = sources.placed(given);
        self.padding = padding;
        let Targets { position, asked } = targets;
        self.chunks.resize_with(position.len().div_ceil(TASK), Chunk::default);
        for_each_task(position.len(), PerTask(&mut self.chunks), &|particles, PerTask(chunk)| {
            let asked = asked.map(|asked| &asked[particles.clone()]);
            let (first, position, chunk) = (particles.start, &position[particles], &mut chunk[0]);
            let targets = Targets { position, asked };
            search.arithmetic.run(Fill { search, sources, positions, targets, first, padding, chunk });
        });
    }
}

impl Chunk {
    #[inline(always)]
    fn row(&self, k: usize) -> &[[u32; WIDTH]] {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        let indices = &self.indices[WIDTH * start as usize..WIDTH * self.ends[k] as usize];
        indices.as_chunks().0
    }
}

/// Fills the rows of one chunk.
struct Fill<'a, G, S: Space> {
    search: &'a Search<'a, G, S>,
    sources: &'a Sources<S>,
    /// The sources in the order of cells \[m\].
    positions: &'a [S::Vector],
    targets: Targets<'a, S>,
    first: usize,
    padding: Padding,
    chunk: &'a mut Chunk,
}

/// Bit l is set where position l of `batch` lies within a distance whose square is `square_radius` \[m²\] of `centre`
/// \[m\].
///
/// No closure: it would not be compiled for the path's instructions where it is not inlined.
#[inline(always)]
fn near<S: Space, L: Lanes, G: Geometry<S>>(
    geometry: G,
    centre: S::Of<L>,
    square_radius: L,
    batch: [&S::Vector; WIDTH],
) -> u8 {
    let d = geometry.nearest(S::minus(centre, S::lanes(batch)));
    S::dot(d, d).below(square_radius)
}

impl<S: Space, G: Geometry<S>> LanePass for Fill<'_, G, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { search, sources, positions, targets, first, padding, chunk } = self;
        let Search { geometry, domain, radius, .. } = *search;
        let square_radius = L::splat(radius * radius);
        let Chunk { ends, indices } = chunk;
        ends.clear();
        let mut used = 0;
        // Most targets lie in the cell of the one before.
        let mut around = None;
        for (k, target) in targets.position.iter().enumerate() {
            if targets.asked.is_some_and(|asked| !asked[k]) {
                ends.push((used / WIDTH) as u32);
                continue;
            }
            let target = domain.wrapped(target);
            let centre = S::splat_vector::<L>(&target);
            // Its place in the order of cells.
            let own = match (padding, sources.kept) {
                (Padding::Target, Order::ByCell) => first + k,
                (Padding::Target, Order::AsGiven) => sources.places[first + k] as usize,
                (Padding::Index(_), _) => usize::MAX,
            };
            let start = used;
            let cell = sources.grid.cell(&target);
            if around.as_ref().is_none_or(|(known, _)| *known != cell) {
                around = Some((cell, sources.grid.ranges(cell)));
            }
            for range in around.iter().flat_map(|(_, ranges)| ranges.iter()) {
                let room = used + range.len() + 2 * WIDTH;
                if indices.len() < room {
                    indices.resize(room, 0);
                }
                // Leaves the target itself out and keeps the indices of the set `bits`.
                let mut keep = |mut bits: u8, at: usize| {
                    let itself = own.wrapping_sub(at);
                    if itself < WIDTH {
                        bits &= !(1 << itself);
                    }
                    // Below 2^32, as the entries of the grid are.
                    let base = at as u32;
                    let lanes = SET_BITS[usize::from(bits)];
                    indices[used..used + WIDTH].copy_from_slice(&lanes.map(|lane| base + lane));
                    used += bits.count_ones() as usize;
                };
                let (batches, rest) = positions[range.clone()].as_chunks::<WIDTH>();
                let mut at = range.start;
                for batch in batches {
                    keep(near::<S, L, G>(geometry, centre, square_radius, batch.each_ref()), at);
                    at += WIDTH;
                }
                if let [first, others @ ..] = rest {
                    let last =
                        [first, others.first().unwrap_or(first), others.get(1).unwrap_or(first), first];
                    let bits = near::<S, L, G>(geometry, centre, square_radius, last);
                    keep(bits & ((1 << rest.len()) - 1), at);
                }
            }
            let fill = match padding {
                Padding::Target => (first + k) as u32,
                Padding::Index(index) => index,
            };
            if let Order::AsGiven = sources.kept {
                let order = sources.order();
                indices[start..used].iter_mut().for_each(|k| *k = order[*k as usize]);
            }
            while used % WIDTH > 0 {
                indices[used] = fill;
                used += 1;
            }
            ends.push((used / WIDTH) as u32);
        }
        // Room for some growth, not for more.
        if indices.capacity() > used + used / 4 + 64 * WIDTH {
            indices.truncate(used + used / 16 + 16 * WIDTH);
            indices.shrink_to_fit();
        }
    }
}
