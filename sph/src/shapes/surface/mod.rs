//! Surfaces of triangles, as drawing programs write them.

pub(crate) mod defects;
mod repair;
mod report;
mod stl;
mod thin;
pub(crate) mod tree;
pub(crate) mod triangle;
pub(crate) mod weld;

use std::collections::HashMap;
use std::fmt::{Debug, Formatter};

use nalgebra::{Matrix3, Vector3};

pub use defects::Defect;
pub use repair::Repair;
pub use report::Report;
pub use stl::{Stl, StlError};
pub use thin::Thinnest;
use tree::Tree;
use triangle::{Feature, Triangle, area_vector};

use super::Moments;
use crate::space::Spatial;

/// No facet.
const NONE: u32 = u32::MAX;

/// A surface of triangular facets, corners counter-clockwise as seen from outside, lengths in \[m\].
///
/// What lies inside is decided by how often the surface winds around a point (Jacobson, Kavan & Sorkine-Hornung 2013), so
/// that a small hole does not let the outside in. [`Surface::report`] names its defects.
#[derive(Clone)]
pub struct Surface {
    vertices: Vec<Vector3<f64>>,
    facets: Vec<[u32; 3]>,
    tree: Tree,
    /// Unit normals; zero of facets without an area.
    normals: Vec<Vector3<f64>>,
    /// Normals of the vertices: the mean of the facets that meet by their angles (Bærentzen & Aanæs 2005).
    vertex_normals: Vec<Vector3<f64>>,
    /// The facet beyond each edge.
    beyond: Vec<[u32; 3]>,
    bounds: (Vector3<f64>, Vector3<f64>),
}

/// The nearest place of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Where it is \[m\].
    pub point: Vector3<f64>,
    /// Unit normal out of the surface: of a facet, or the mean of those that meet at an edge or a vertex by their angles.
    pub normal: Vector3<f64>,
    /// Number of the facet.
    pub facet: usize,
}

impl Debug for Surface {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (vertices, facets) = (self.vertices.len(), self.facets.len());
        f.debug_struct("Surface")
            .field("vertices", &vertices)
            .field("facets", &facets)
            .finish_non_exhaustive()
    }
}

impl PartialEq for Surface {
    fn eq(&self, other: &Self) -> bool {
        self.facets == other.facets && self.vertices == other.vertices
    }
}

impl Surface {
    /// The surface of `facets`, each given by its `corners` \[m\]; corners nearer to each other than a millionth of the size
    /// become one vertex.
    ///
    /// # Errors
    /// No facet, more than 2³² − 2, or a coordinate that is no finite number.
    pub fn new(corners: &[[Vector3<f64>; 3]]) -> Result<Self, String> {
        if corners.is_empty() {
            return Err("the surface has no facet".to_owned());
        }
        if u32::try_from(3 * corners.len()).is_err() {
            return Err(format!("the surface has {} facets: too many to number", corners.len()));
        }
        let sound = |t: &Triangle| t.iter().all(|x| x.norm_squared().is_finite());
        if let Some(k) = corners.iter().position(|t| !sound(t)) {
            return Err(format!(
                "facet {} has a coordinate that is no finite number: export the surface again",
                k + 1
            ));
        }
        let (vertices, facets) = weld::welded(corners);
        Ok(Self::of(vertices, facets))
    }

    /// The surface of `facets` between `vertices`.
    fn of(vertices: Vec<Vector3<f64>>, facets: Vec<[u32; 3]>) -> Self {
        let triangles: Vec<Triangle> = facets.iter().map(|f| f.map(|k| vertices[k as usize])).collect();
        let normal = |t: &Triangle| area_vector(t).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let normals: Vec<Vector3<f64>> = triangles.iter().map(normal).collect();
        let mut vertex_normals = vec![Vector3::zeros(); vertices.len()];
        for ((facet, t), normal) in facets.iter().zip(&triangles).zip(&normals) {
            for k in 0..3 {
                let (a, b) = (t[(k + 1) % 3] - t[k], t[(k + 2) % 3] - t[k]);
                vertex_normals[facet[k] as usize] += normal * a.angle(&b);
            }
        }
        let unit = |n: &mut Vector3<f64>| *n = n.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
        vertex_normals.iter_mut().for_each(unit);
        let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let bounds = triangles.iter().flatten().fold(none, |(a, b), x| (a.inf(x), b.sup(x)));
        let beyond = beyond(&facets);
        Self { tree: Tree::new(&triangles), vertices, facets, normals, vertex_normals, beyond, bounds }
    }

    /// Number of facets.
    pub fn facets(&self) -> usize {
        self.facets.len()
    }

    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        self.vertices.len()
    }

    /// Corners \[m\] of facet `k`.
    pub fn corners(&self, k: usize) -> [Vector3<f64>; 3] {
        self.facets[k].map(|vertex| self.vertices[vertex as usize])
    }

    /// Lower and upper corner \[m\] of the smallest box around the surface.
    pub fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        self.bounds
    }

    /// Diagonal of the box around the surface \[m\].
    pub fn size(&self) -> f64 {
        (self.bounds.1 - self.bounds.0).norm()
    }

    /// Times that the surface winds around `point` \[m\], within 0.01: one inside of a sound surface, zero outside.
    pub fn winding_number(&self, point: &Vector3<f64>) -> f64 {
        self.tree.winding(point)
    }

    /// Whether `point` \[m\] lies inside: the surface winds around it at least half a time.
    pub fn contains(&self, point: &Vector3<f64>) -> bool {
        let (lower, upper) = self.bounds;
        let in_box = (0..3).all(|axis| lower[axis] <= point[axis] && point[axis] <= upper[axis]);
        in_box && self.winding_number(point) > 0.5
    }

    /// The nearest place of the surface as seen from `point` \[m\].
    pub fn nearest(&self, point: &Vector3<f64>) -> Foot {
        let Some(found) = self.tree.nearest(point, f64::INFINITY) else {
            return Foot { point: *point, normal: Vector3::zeros(), facet: 0 };
        };
        let facet = found.number as usize;
        let own = self.normals[facet];
        let normal = match found.feature {
            Feature::Inside => own,
            Feature::Edge(k) => match self.beyond[facet][k] {
                NONE => own,
                other => (own + self.normals[other as usize]).try_normalize(1e-9).unwrap_or(own),
            },
            Feature::Corner(k) => {
                let normal = self.vertex_normals[self.facets[facet][k] as usize];
                if normal == Vector3::zeros() { own } else { normal }
            }
        };
        Foot { point: found.point, normal, facet }
    }

    /// Normals of the facets that are at most `tolerance` \[m\] farther from `point` than `distance` \[m\].
    pub(super) fn normals_within(
        &self,
        point: &Vector3<f64>,
        distance: f64,
        tolerance: f64,
    ) -> Vec<Vector3<f64>> {
        let reach = distance + tolerance;
        let normals = self.tree.within(point, reach * reach).into_iter().map(|k| self.normals[k as usize]);
        normals.filter(|normal| *normal != Vector3::zeros()).collect()
    }

    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        (0..self.facets()).map(|k| area_vector(&self.corners(k)).norm()).sum()
    }

    /// Volume and moments of what the surface encloses, by the divergence theorem: exact for a closed surface of plane facets.
    pub fn moments(&self) -> Moments<Spatial> {
        // About the middle: no cancellation far from the origin.
        let middle = (self.bounds.0 + self.bounds.1) * 0.5;
        let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for k in 0..self.facets() {
            // The tetrahedron from the middle to the facet.
            let [a, b, c] = self.corners(k).map(|x| x - middle);
            let part = a.dot(&b.cross(&c)) / 6.0;
            let sum = a + b + c;
            volume += part;
            first += sum * (part / 4.0);
            let outer = |x: &Vector3<f64>| x * x.transpose();
            second += (outer(&sum) + outer(&a) + outer(&b) + outer(&c)) * (part / 20.0);
        }
        let centroid = if volume == 0.0 { Vector3::zeros() } else { first / volume };
        let second = second - centroid * centroid.transpose() * volume;
        Moments { volume, centroid: middle + centroid, second: second.iter().copied().collect() }
    }

    /// Points of the surface at most `step` \[m\] apart.
    pub(super) fn samples(&self, step: f64) -> Vec<Vector3<f64>> {
        let mut points = Vec::new();
        for k in 0..self.facets() {
            let [a, b, c] = self.corners(k);
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            let count = (longest / step).ceil().clamp(1.0, 256.0);
            let along = |count: f64| {
                std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(move |k| *k <= count)
            };
            points.extend(along(count).flat_map(|i| {
                along(count - i).map(move |j| a + (b - a) * (i / count) + (c - a) * (j / count))
            }));
        }
        points
    }
}

/// For each facet the one beyond each of its edges, none where there is not exactly one.
fn beyond(facets: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut beyond = vec![[NONE; 3]; facets.len()];
    for edge in defects::edges(facets).chunk_by(|a, b| a.ends == b.ends) {
        if let [a, b] = edge {
            beyond[a.facet as usize][a.side as usize] = b.facet;
            beyond[b.facet as usize][b.side as usize] = a.facet;
        }
    }
    beyond
}

/// Vertices numbered in the order in which they come.
type Numbers = HashMap<[u64; 3], u32>;

#[cfg(test)]
mod tests;
