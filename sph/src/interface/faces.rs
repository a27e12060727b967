//! Faces of the solid: the waters that one of its states meets and what each of them feels there.
//!
//! A state in the midst of a thin plate meets the water on both sides. A mean over all of it would let the pressure of
//! one side act on the other through the plate; so each water has a dummy state of its own.

use crate::domain::Domain;
use crate::exchange::InterfaceStates;
use crate::vector::Vector;

use super::lists::{CrossPair, Rows};

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

/// Parts the water around states of the solid; buffers are reused.
#[derive(Debug, Default)]
struct Waters {
    separations: Vec<Vector>,
    stack: Vec<usize>,
    /// Pairs of the fluid's states, smaller index first, between which a state of the solid stands.
    parted: Vec<(u32, u32)>,
    /// States of the solid that see several waters on one side of them.
    doubtful: Vec<u32>,
}

/// Longer rows are not parted: water in a support is some thirty particles, and work grows with their square.
const LARGEST_ROW: usize = 256;

/// Water that has no face yet.
const OPEN: u32 = u32::MAX;

impl Waters {
    /// Numbers the faces of every state of the solid, each from 0 on, in the pairs of `rows`.
    ///
    /// Waters of a row are apart when no chain of its particles, each within `support` \[m\] of the next, joins them. A
    /// state parts those that lie around it on different sides. Those on one side of it, such as drops, are one, unless
    /// another state parts them: the foot of a plate that stands in the floor has both waters above it.
    fn part(
        &mut self,
        domain: &Domain,
        support: f64,
        [fluid, solid]: [&InterfaceStates; 2],
        rows: &mut Rows,
    ) {
        let square = support * support;
        self.parted.clear();
        self.doubtful.clear();
        for s in 0..rows.len() {
            let row = rows.of_mut(s);
            self.look(domain, fluid, &solid.position[s], row);
            let mean: Vector = self.separations.iter().sum();
            let one_sided = self.separations.iter().all(|x_fs| x_fs.dot(&mean) > 0.0);
            let waters = if self.is_one(square) { 1 } else { self.flood(square, row) };
            if one_sided && waters > 1 {
                // Exact, as indices of pairs are.
                self.doubtful.push(s as u32);
            }
            if one_sided || waters == 1 {
                row.iter_mut().for_each(|pair| pair.face = 0);
                continue;
            }
            for (k, a) in row.iter().enumerate() {
                let others = row[..k].iter().filter(|b| b.face != a.face);
                self.parted.extend(others.map(|b| (b.other, a.other)));
            }
        }
        if self.parted.is_empty() {
            return;
        }
        self.parted.sort_unstable();
        self.parted.dedup();
        for k in 0..self.doubtful.len() {
            let s = self.doubtful[k] as usize;
            let row = rows.of_mut(s);
            self.look(domain, fluid, &solid.position[s], row);
            let waters = self.flood(square, row);
            self.join(row, waters);
        }
    }

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

    /// Joins those of the `waters` of `row` that nothing parts, and numbers the rest anew.
    fn join(&self, row: &mut [CrossPair], waters: u32) {
        let apart = |a: u32, b: u32, row: &[CrossPair]| {
            let of = |face: u32| row.iter().filter(move |pair| pair.face == face).map(|pair| pair.other);
            of(a).any(|f| of(b).any(|g| self.parted.binary_search(&(f.min(g), f.max(g))).is_ok()))
        };
        let mut count = 0;
        for water in 0..waters {
            // To the first of those before that it is not parted from.
            let face = (0..count).find(|face| !apart(*face, water, row)).unwrap_or(count);
            row.iter_mut().filter(|pair| pair.face == water).for_each(|pair| pair.face = face);
            count = count.max(face + 1);
        }
    }
}

/// Faces of all states and what the fluid feels there.
#[derive(Debug, Default)]
pub struct Faces {
    dummies: Vec<Dummy>,
    waters: Waters,
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
        dummy: impl Fn(usize, &[CrossPair], u32) -> Dummy,
    ) {
        self.waters.part(domain, support, states, rows);
        self.dummies.clear();
        for s in 0..rows.len() {
            let first = self.dummies.len() as u32;
            let row = rows.of_mut(s);
            let count = row.iter().map(|pair| pair.face + 1).max().unwrap_or(0);
            row.iter_mut().for_each(|pair| pair.face += first);
            self.dummies.extend((first..first + count).map(|face| dummy(s, row, face)));
        }
    }
}
