//! Repairs that leave no doubt about what was meant.

use std::collections::HashSet;

use super::Surface;
use super::defects::{components, edges, is_collapsed};

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repair {
    /// So many facets with two equal corners were left out.
    Collapsed(usize),
    /// So many facets that came again were left out.
    Duplicates(usize),
    /// So many facets were turned round to agree with the others of their part.
    Turned(usize),
    /// So many parts that were inside out were turned round.
    Inverted(usize),
}

impl std::fmt::Display for Repair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Collapsed(count) => write!(f, "{count} facets without an area left out"),
            Self::Duplicates(count) => write!(f, "{count} facets that came again left out"),
            Self::Turned(count) => write!(f, "{count} facets turned round to agree with their part"),
            Self::Inverted(count) => write!(f, "{count} parts that were inside out turned round"),
        }
    }
}

impl Surface {
    /// The surface without collapsed and repeated facets, all facing outward, and what was done; holes, and parts that cross
    /// or lie in each other, stay.
    pub fn repaired(&self) -> (Self, Vec<Repair>) {
        let mut done = Vec::new();
        let again: HashSet<usize> = self.duplicates().into_iter().collect();
        let collapsed = self.facets.iter().filter(|facet| is_collapsed(facet)).count();
        let mut facets: Vec<[u32; 3]> = self
            .facets
            .iter()
            .enumerate()
            .filter(|(k, facet)| !is_collapsed(facet) && !again.contains(k))
            .map(|(_, facet)| *facet)
            .collect();
        let turned = turn_alike(&mut facets);
        let mut surface = Self::of(self.vertices.clone(), facets);
        let (component, count) = components(&surface.facets, &edges(&surface.facets));
        let [inverted, _] = surface.senses(&component, count);
        if !inverted.is_empty() {
            let inverted: HashSet<usize> = inverted.iter().map(|(of, _)| *of).collect();
            let mut facets = surface.facets;
            facets
                .iter_mut()
                .zip(&component)
                .filter(|(_, of)| inverted.contains(of))
                .for_each(|(f, _)| f.swap(1, 2));
            surface = Self::of(surface.vertices, facets);
        }
        for (count, repair) in [
            (collapsed, Repair::Collapsed(collapsed)),
            (again.len(), Repair::Duplicates(again.len())),
            (turned, Repair::Turned(turned)),
            (inverted.len(), Repair::Inverted(inverted.len())),
        ] {
            if count > 0 {
                done.push(repair);
            }
        }
        (surface, done)
    }
}

/// Turns facets of each component round that do not agree with most of it; returns how many.
fn turn_alike(facets: &mut [[u32; 3]]) -> usize {
    let edges = edges(facets);
    // Per facet its neighbours across edges of two facets, and whether they face the same side.
    let mut neighbours: Vec<[Option<(u32, bool)>; 3]> = vec![[None; 3]; facets.len()];
    for same in edges.chunk_by(|a, b| a.ends == b.ends) {
        if let [a, b] = same {
            let alike = a.forward != b.forward;
            neighbours[a.facet as usize][usize::from(a.side)] = Some((b.facet, alike));
            neighbours[b.facet as usize][usize::from(b.side)] = Some((a.facet, alike));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; facets.len()];
    let mut changed = 0;
    for first in 0..facets.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let (mut reached, mut next) = (vec![first], 0);
        while next < reached.len() {
            let k = reached[next];
            next += 1;
            let own = turned[k].unwrap_or(false);
            for (other, alike) in neighbours[k].into_iter().flatten() {
                let other = other as usize;
                if turned[other].is_none() {
                    turned[other] = Some(own == alike);
                    reached.push(other);
                }
            }
        }
        let count = reached.iter().filter(|k| turned[**k] == Some(true)).count();
        // The sense of most.
        let minority = 2 * count <= reached.len();
        for k in reached.into_iter().filter(|k| turned[*k] == Some(minority)) {
            facets[k].swap(1, 2);
            changed += 1;
        }
    }
    changed
}
