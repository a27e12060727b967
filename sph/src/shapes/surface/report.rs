//! What there is to know about a surface before it is filled.

use nalgebra::Vector3;

use super::defects::{Defect, components, edges};
use super::{Surface, Thinnest};

/// Size, volume and defects of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Number of facets.
    pub facets: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Parts that hang together by edges.
    pub components: usize,
    /// Volume inside \[m³\], of all facets as they are; of an open surface with the cone from its border to the origin.
    pub volume: f64,
    /// Area \[m²\].
    pub area: f64,
    /// Lower and upper corner of the box around it \[m\].
    pub bounds: (Vector3<f64>, Vector3<f64>),
    /// Edges of one facet: borders of holes.
    pub open_edges: Defect,
    /// Edges of more than two facets.
    pub crowded_edges: Defect,
    /// Edges whose two facets face opposite sides.
    pub turned_edges: Defect,
    /// Facets without an area.
    pub degenerate: Defect,
    /// Facets that come again.
    pub duplicates: Defect,
    /// Pairs of facets that cross or touch though they have no vertex in common.
    pub intersections: Defect,
    /// Components that are inside out.
    pub inverted: Defect,
    /// Components that lie in others and face outward, so that their inside counts twice.
    pub nested: Defect,
    /// The thinnest part.
    pub thinnest: Option<Thinnest>,
}

impl Surface {
    /// Size, volume and defects.
    pub fn report(&self) -> Report {
        let edges = edges(&self.facets);
        let (component, components) = components(&self.facets, &edges);
        // Of an open surface the volume depends on the point that its facets are joined to: here the origin.
        let middle = (self.bounds.0 + self.bounds.1) * 0.5;
        let [open_edges, crowded_edges, turned_edges] = self.edge_defects(&edges);
        let [inverted, nested] = self
            .senses(&component, components)
            .map(|found| Defect { count: found.len(), place: found.first().map(|(_, place)| *place) });
        Report {
            facets: self.facets(),
            vertices: self.vertices(),
            components,
            volume: self.moments().volume + middle.dot(&self.tree.dipole()) / 3.0,
            area: self.area(),
            bounds: self.bounds(),
            open_edges,
            crowded_edges,
            turned_edges,
            degenerate: self.degenerate(),
            duplicates: self.places(&self.duplicates()),
            intersections: self.intersections(),
            inverted,
            nested,
            thinnest: self.thinnest(),
        }
    }
}

impl Report {
    /// What is wrong, how often and where, and what to do about it; empty for a sound surface.
    pub fn problems(&self) -> Vec<String> {
        let [repair, unite] = ["allow repairs", "unite the parts in the program that made the surface"];
        [
            (
                &self.open_edges,
                ["open edge", "open edges"],
                "close the holes in the program that made the surface",
            ),
            (
                &self.crowded_edges,
                ["edge of more than two facets", "edges of more than two facets"],
                "separate the parts that meet there; if facets come again, allow repairs",
            ),
            (
                &self.turned_edges,
                ["edge whose facets face opposite sides", "edges whose facets face opposite sides"],
                repair,
            ),
            (&self.degenerate, ["facet without an area", "facets without an area"], repair),
            (&self.duplicates, ["facet that comes again", "facets that come again"], repair),
            (
                &self.intersections,
                ["pair of facets that cross or touch", "pairs of facets that cross or touch"],
                unite,
            ),
            (&self.inverted, ["part that is inside out", "parts that are inside out"], repair),
            (
                &self.nested,
                ["part that reaches into another", "parts that reach into others"],
                "unite the parts, or turn the inner one round to make it a cavity",
            ),
        ]
        .into_iter()
        .filter(|(defect, ..)| defect.count > 0)
        .map(|(defect, names, remedy)| {
            let name = names[usize::from(defect.count > 1)];
            let place =
                defect.place.map_or_else(String::new, |x| format!(" at ({}, {}, {}) m", x.x, x.y, x.z));
            let first = if defect.count == 1 { "" } else { ", the first" };
            format!("{} {name}{first}{place}: {remedy}", defect.count)
        })
        .collect()
    }

    /// Whether nothing is wrong.
    pub fn is_sound(&self) -> bool {
        self.problems().is_empty()
    }
}
