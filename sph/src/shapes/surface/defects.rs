//! What is wrong with a surface: counts and places.

use std::collections::HashMap;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::Surface;
use super::triangle::{area_vector, meet};

crate::constants! {
    const FLAT: f64 = 1e-9, "surface.flat",
        "height of a facet over its longest side below which it has no area [-]";
    /// Round-off of positions of this size.
    const TOUCH: f64 = 1e-9, "surface.touch",
        "distance of facets that count as touching, in diagonals of the box around all [-]";
}

/// How far beside a facet its sides are examined, as a fraction of the size.
const BESIDE: f64 = 1e-6;

/// Components whose sense is examined.
const MOST_COMPONENTS: usize = 1000;

/// How often something is wrong, and where first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Defect {
    /// How often.
    pub count: usize,
    /// A place \[m\].
    pub place: Option<Vector3<f64>>,
}

impl Defect {
    fn of(places: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        places.into_iter().fold(Self::default(), |found, place| Self {
            count: found.count + 1,
            place: found.place.or(Some(place)),
        })
    }
}

/// An edge of a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Its vertices, the lower number first.
    pub ends: [u32; 2],
    pub facet: u32,
    /// From the corner of this number to the next.
    pub side: u8,
    /// Whether it runs from the lower number to the higher.
    pub forward: bool,
}

/// The edges of all facets that have three vertices, sorted by their ends.
pub(super) fn edges(facets: &[[u32; 3]]) -> Vec<Edge> {
    let mut edges: Vec<Edge> = (0_u32..)
        .zip(facets)
        .filter(|(_, facet)| !is_collapsed(facet))
        .flat_map(|(k, facet)| {
            [0_u8, 1, 2].map(|side| {
                let (a, b) = (facet[usize::from(side)], facet[usize::from(side + 1) % 3]);
                Edge { ends: [a.min(b), a.max(b)], facet: k, side, forward: a < b }
            })
        })
        .collect();
    edges.par_sort_unstable_by_key(|edge| (edge.ends, edge.facet, edge.side));
    edges
}

/// Whether two corners are the same vertex.
pub(super) fn is_collapsed(facet: &[u32; 3]) -> bool {
    facet[0] == facet[1] || facet[1] == facet[2] || facet[2] == facet[0]
}

/// For each facet the component that it belongs to, by shared edges, and the number of these; collapsed facets are in none.
pub(super) fn components(facets: &[[u32; 3]], edges: &[Edge]) -> (Vec<usize>, usize) {
    let mut parent: Vec<u32> = (0_u32..).take(facets.len()).collect();
    for same in edges.chunk_by(|a, b| a.ends == b.ends) {
        for pair in same.windows(2) {
            let (a, b) = (root(&mut parent, pair[0].facet), root(&mut parent, pair[1].facet));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut numbers = HashMap::new();
    let component = (0_u32..).zip(facets).map(|(k, facet)| {
        if is_collapsed(facet) {
            return usize::MAX;
        }
        let next = numbers.len();
        *numbers.entry(root(&mut parent, k)).or_insert(next)
    });
    let component = component.collect();
    (component, numbers.len())
}

fn root(parent: &mut [u32], mut k: u32) -> u32 {
    while parent[k as usize] != k {
        parent[k as usize] = parent[parent[k as usize] as usize];
        k = parent[k as usize];
    }
    k
}

impl Surface {
    fn middle_of(&self, edge: &Edge) -> Vector3<f64> {
        (self.vertices[edge.ends[0] as usize] + self.vertices[edge.ends[1] as usize]) * 0.5
    }

    fn centroid(&self, k: usize) -> Vector3<f64> {
        let [a, b, c] = self.corners(k);
        (a + b + c) / 3.0
    }

    /// Edges of one facet; of more than two; of two that run the same way along it.
    pub(super) fn edge_defects(&self, edges: &[Edge]) -> [Defect; 3] {
        let mut found = [const { Vec::new() }; 3];
        for same in edges.chunk_by(|a, b| a.ends == b.ends) {
            let kind = match same {
                [_] => Some(0),
                [a, b] => (a.forward == b.forward).then_some(2),
                _ => Some(1),
            };
            if let Some(kind) = kind {
                found[kind].push(self.middle_of(&same[0]));
            }
        }
        found.map(Defect::of)
    }

    /// Facets without an area.
    pub(super) fn degenerate(&self) -> Defect {
        let flat = |k: &usize| {
            let t = self.corners(*k);
            let longest = (t[1] - t[0]).norm().max((t[2] - t[1]).norm()).max((t[0] - t[2]).norm());
            2.0 * area_vector(&t).norm() <= FLAT * longest * longest
        };
        Defect::of((0..self.facets()).filter(flat).map(|k| self.centroid(k)))
    }

    /// Numbers of facets between the same vertices as an earlier one.
    pub(super) fn duplicates(&self) -> Vec<usize> {
        let mut sorted: Vec<([u32; 3], usize)> = self
            .facets
            .iter()
            .enumerate()
            .filter(|(_, facet)| !is_collapsed(facet))
            .map(|(k, facet)| {
                let mut key = *facet;
                key.sort_unstable();
                (key, k)
            })
            .collect();
        sorted.par_sort_unstable();
        let mut again: Vec<usize> =
            sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1).collect();
        again.sort_unstable();
        again
    }

    pub(super) fn places(&self, facets: &[usize]) -> Defect {
        Defect::of(facets.iter().map(|k| self.centroid(*k)))
    }

    /// Pairs of facets that cross or touch though they have no vertex in common.
    pub(super) fn intersections(&self) -> Defect {
        let margin = TOUCH * self.size();
        let found: Vec<Vector3<f64>> = (0..self.facets())
            .into_par_iter()
            .with_min_len(256)
            .map_init(Vec::new, |near, k| {
                let t = self.corners(k);
                let (lower, upper) = (t[0].inf(&t[1]).inf(&t[2]), t[0].sup(&t[1]).sup(&t[2]));
                self.tree.about(&lower, &upper, margin, near);
                near.sort_unstable();
                let others: Vec<Vector3<f64>> = near
                    .iter()
                    .map(|other| *other as usize)
                    .filter(|other| {
                        *other > k && !self.facets[*other].iter().any(|v| self.facets[k].contains(v))
                    })
                    .filter(|other| meet(&t, &self.corners(*other), margin))
                    .map(|other| {
                        let o = self.corners(other);
                        let (a, b) = (o[0].inf(&o[1]).inf(&o[2]), o[0].sup(&o[1]).sup(&o[2]));
                        (lower.sup(&a) + upper.inf(&b)) * 0.5
                    })
                    .collect();
                others
            })
            .flatten_iter()
            .collect();
        Defect::of(found)
    }

    /// Components that are inside out, and those that lie in another: numbers of each, and places.
    ///
    /// The largest facet of each is examined: outside of it a sound surface winds around nothing.
    pub(super) fn senses(&self, component: &[usize], count: usize) -> [Vec<(usize, Vector3<f64>)>; 2] {
        let mut largest: Vec<Option<(f64, usize)>> = vec![None; count.min(MOST_COMPONENTS)];
        for (k, of) in component.iter().enumerate() {
            if let Some(known) = largest.get_mut(*of) {
                let area = area_vector(&self.corners(k)).norm();
                if known.is_none_or(|(other, _)| area > other) {
                    *known = Some((area, k));
                }
            }
        }
        let mut found = [const { Vec::new() }; 2];
        for (of, (_, k)) in largest.into_iter().enumerate().filter_map(|(of, known)| Some((of, known?))) {
            let place = self.centroid(k);
            let outside = self.winding_number(&(place + self.normals[k] * (BESIDE * self.size())));
            // Half a turn off: holes and the far field change it by less.
            if outside < -0.5 {
                found[0].push((of, place));
            } else if outside > 0.5 {
                found[1].push((of, place));
            }
        }
        found
    }
}
