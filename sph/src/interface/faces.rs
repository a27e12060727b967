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
pub struct Waters {
    separations: Vec<Vector>,
    stack: Vec<usize>,
}

/// Water that has no face yet.
const OPEN: u32 = u32::MAX;

impl Waters {
    /// Numbers the faces of solid state `s` from `first` on in its `row` of pairs; returns how many there are.
    ///
    /// Waters are parted that do not feel each other: no chain of particles in the row, each within `support` \[m\] of the
    /// next, joins them.
    pub fn part(
        &mut self,
        domain: &Domain,
        support: f64,
        [fluid, solid]: [&InterfaceStates; 2],
        s: usize,
        row: &mut [CrossPair],
        first: u32,
    ) -> u32 {
        let Self { separations, stack } = self;
        separations.clear();
        separations.extend(
            row.iter()
                .map(|pair| domain.separation(&fluid.position[pair.other as usize], &solid.position[s])),
        );
        let square = support * support;
        let together = |a: &Vector, b: &Vector| (a - b).norm_squared() < square;
        // Nearly always all water is around the nearest particle.
        let nearest = separations.iter().min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        let whole = nearest.is_none_or(|nearest| separations.iter().all(|x_fs| together(nearest, x_fs)));
        row.iter_mut().for_each(|pair| pair.face = if whole { first } else { OPEN });
        if whole {
            return u32::from(!row.is_empty());
        }
        let mut count = 0;
        for k in 0..row.len() {
            if row[k].face != OPEN {
                continue;
            }
            row[k].face = first + count;
            stack.push(k);
            while let Some(a) = stack.pop() {
                for b in 0..row.len() {
                    if row[b].face == OPEN && together(&separations[a], &separations[b]) {
                        row[b].face = first + count;
                        stack.push(b);
                    }
                }
            }
            count += 1;
        }
        count
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
        self.dummies.clear();
        for s in 0..rows.len() {
            let first = self.dummies.len() as u32;
            let count = self.waters.part(domain, support, states, s, rows.of_mut(s), first);
            self.dummies.extend((first..first + count).map(|face| dummy(s, rows.of(s), face)));
        }
    }
}
