//! Faces of the solid: the waters that one of its states meets and what each of them feels there.
//!
//! A state in the midst of a thin plate meets the water on both sides. A mean over all of it would let the pressure of
//! one side act on the other through the plate; so each water has a dummy state of its own.

use rayon::prelude::*;

use crate::coupling::exchange::InterfaceStates;
use crate::space::Vector;
use crate::space::domain::Domain;

use super::lists::{CrossPair, Rows, TASK, TaskRows};

/// State of an interface particle of the solid as the fluid on one of its faces feels it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dummy {
    /// Pressure \[Pa\].
    pub pressure: f64,
    /// Density that belongs to the pressure \[kg/m³\].
    pub density: f64,
    /// Mass per depth \[kg/m\].
    pub mass: f64,
}

/// The water around one state of the solid; buffers are reused.
#[derive(Debug, Default)]
struct Water {
    separations: Vec<Vector>,
    stack: Vec<usize>,
}

/// What the states of a task say of the water around them.
#[derive(Debug, Default)]
struct Around {
    water: Water,
    /// Faces of each state.
    counts: Vec<u32>,
    /// Pairs of the fluid's states, smaller index first, between which a state of the solid stands.
    parted: Vec<(u32, u32)>,
    /// States of the solid that see several waters on one side of them.
    doubtful: Vec<u32>,
}

/// Longer rows are not parted: water in a support is some thirty particles, and work grows with their square.
const LARGEST_ROW: usize = 256;

/// Water that has no face yet.
const OPEN: u32 = u32::MAX;

impl Around {
    /// Numbers the faces of every state of the task, each from 0 on, in the pairs of `rows`.
    fn part(
        &mut self,
        domain: &Domain,
        square: f64,
        [fluid, solid]: [&InterfaceStates; 2],
        rows: &mut TaskRows,
    ) {
        let Self { water, counts, parted, doubtful } = self;
        counts.clear();
        parted.clear();
        doubtful.clear();
        rows.each(|s, row| {
            water.look(domain, fluid, &solid.position[s], row);
            let mean: Vector = water.separations.iter().sum();
            let one_sided = water.separations.iter().all(|x_fs| x_fs.dot(&mean) > 0.0);
            let waters = if water.is_one(square) { 1 } else { water.flood(square, row) };
            if one_sided && waters > 1 {
                // Exact, as indices of pairs are.
                doubtful.push(s as u32);
            }
            if one_sided || waters == 1 {
                row.iter_mut().for_each(|pair| pair.face = 0);
                counts.push(u32::from(!row.is_empty()));
                return;
            }
            counts.push(waters);
            for (k, a) in row.iter().enumerate() {
                let others = row[..k].iter().filter(|b| b.face != a.face);
                parted.extend(others.map(|b| (b.other, a.other)));
            }
        });
    }
}

impl Water {
    /// Takes the separations of `row` from the state at `x_s`.
    fn look(&mut self, domain: &Domain, fluid: &InterfaceStates, x_s: &Vector, row: &[CrossPair]) {
        self.separations.clear();
        let separation = |pair: &CrossPair| domain.separation(&fluid.position[pair.other as usize], x_s);
        self.separations.extend(row.iter().map(separation));
    }

    /// Whether all water is around the particle nearest to the state, as it nearly always is, or is no water.
    fn is_one(&self, square: f64) -> bool {
        if self.separations.len() > LARGEST_ROW {
            return true;
        }
        let nearest = self.separations.iter().min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        nearest.is_none_or(|nearest| {
            self.separations.iter().all(|x_fs| (x_fs - nearest).norm_squared() < square)
        })
    }

    /// Numbers the waters of `row` that do not hang together; returns how many there are.
    fn flood(&mut self, square: f64, row: &mut [CrossPair]) -> u32 {
        let Self { separations, stack, .. } = self;
        row.iter_mut().for_each(|pair| pair.face = OPEN);
        let mut count = 0;
        for k in 0..row.len() {
            if row[k].face != OPEN {
                continue;
            }
            row[k].face = count;
            stack.push(k);
            while let Some(a) = stack.pop() {
                for b in 0..row.len() {
                    if row[b].face == OPEN && (separations[b] - separations[a]).norm_squared() < square {
                        row[b].face = count;
                        stack.push(b);
                    }
                }
            }
            count += 1;
        }
        count
    }
}

/// Joins those of the `waters` of `row` that no pair of `parted` keeps apart, and numbers the rest anew; returns how many
/// there are.
fn join(parted: &[(u32, u32)], row: &mut [CrossPair], waters: u32) -> u32 {
    let apart = |a: u32, b: u32, row: &[CrossPair]| {
        let of = |face: u32| row.iter().filter(move |pair| pair.face == face).map(|pair| pair.other);
        of(a).any(|f| of(b).any(|g| parted.binary_search(&(f.min(g), f.max(g))).is_ok()))
    };
    let mut count = 0;
    for water in 0..waters {
        // To the first of those before that it is not parted from.
        let face = (0..count).find(|face| !apart(*face, water, row)).unwrap_or(count);
        row.iter_mut().filter(|pair| pair.face == water).for_each(|pair| pair.face = face);
        count = count.max(face + 1);
    }
    count
}

/// Faces of all states and what the fluid feels there.
#[derive(Debug, Default)]
pub struct Faces {
    dummies: Vec<Dummy>,
    around: Vec<Around>,
    parted: Vec<(u32, u32)>,
}

impl Faces {
    /// What the fluid of `pair` feels.
    pub fn dummy(&self, pair: &CrossPair) -> &Dummy {
        &self.dummies[pair.face as usize]
    }

    /// One face for every state of the solid, whatever the water around it.
    pub fn whole(&mut self, rows: &mut Rows, dummy: impl Fn(usize) -> Dummy) {
        self.dummies.clear();
        for s in 0..rows.len() {
            rows.of_mut(s).iter_mut().for_each(|pair| pair.face = s as u32);
            self.dummies.push(dummy(s));
        }
    }

    /// A face for every water around every state; `dummy` tells what those pairs of a state's row feel that have the face.
    pub fn parted(
        &mut self,
        domain: &Domain,
        support: f64,
        states: [&InterfaceStates; 2],
        rows: &mut Rows,
        dummy: impl Fn(usize, &[CrossPair], u32) -> Dummy + Sync,
    ) {
        self.part(domain, support * support, states, rows);
        let Self { dummies, around, .. } = self;
        let counts = |around: &Around| around.counts.iter().sum::<u32>();
        dummies.clear();
        dummies.resize(around.iter().map(counts).sum::<u32>() as usize, Dummy::default());
        let (mut rest, mut first) = (&mut dummies[..], 0);
        let each = rows.tasks().into_iter().zip(&*around).map(|(rows, around)| {
            let (own, others) = std::mem::take(&mut rest).split_at_mut(counts(around) as usize);
            let start = first;
            (rest, first) = (others, first + counts(around));
            (rows, around, own, start)
        });
        let each: Vec<_> = each.collect();
        each.into_par_iter().for_each(|(mut rows, around, own, mut first)| {
            let (mut own, mut counts) = (own.iter_mut(), around.counts.iter());
            rows.each(|s, row| {
                let count = counts.next().copied().unwrap_or(0);
                row.iter_mut().for_each(|pair| pair.face += first);
                (first..first + count).zip(&mut own).for_each(|(face, own)| *own = dummy(s, row, face));
                first += count;
            });
        });
    }

    /// Numbers the faces of every state of the solid, each from 0 on, in the pairs of `rows`.
    ///
    /// Waters of a row are apart when no chain of its particles, each nearer than the root of `square` \[m²\] to the next,
    /// joins them. A state parts those that lie around it on different sides. Those on one side of it, such as drops, are
    /// one, unless another state parts them: the foot of a plate that stands in the floor has both waters above it.
    fn part(&mut self, domain: &Domain, square: f64, states: [&InterfaceStates; 2], rows: &mut Rows) {
        let Self { around, parted, .. } = self;
        let tasks = rows.tasks();
        around.resize_with(tasks.len(), Around::default);
        tasks.into_par_iter().zip(&mut around[..]).for_each(|(mut rows, around)| {
            around.part(domain, square, states, &mut rows);
        });
        parted.clear();
        around.iter().for_each(|around| parted.extend(&around.parted));
        if parted.is_empty() {
            return;
        }
        parted.sort_unstable();
        parted.dedup();
        let [fluid, solid] = states;
        for (task, Around { water, counts, doubtful, .. }) in around.iter_mut().enumerate() {
            for s in doubtful.iter().map(|s| *s as usize) {
                let row = rows.of_mut(s);
                water.look(domain, fluid, &solid.position[s], row);
                let waters = water.flood(square, row);
                counts[s - task * TASK] = join(parted, row, waters);
            }
        }
    }
}
