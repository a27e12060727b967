//! Shapes of the plane as regions.

use super::fitted::{along_lines, layers_within};
use super::packing::Moments;
use super::region::{Faces, LayerParticle, Region, ShapedSpace, Side};
use super::{Boundary, Shape, SurfacePoint};
use crate::space::{Plane, Vector};

impl ShapedSpace for Plane {
    type Shape = Shape;
}

impl Region<Plane> for Shape {
    type Boundary = Boundary;

    fn contains(&self, point: &Vector) -> bool {
        self.contains(point)
    }

    fn bounds(&self) -> (Vector, Vector) {
        self.bounds()
    }

    fn boundary(&self) -> Boundary {
        self.boundary()
    }

    fn layers_along(&self, boundary: &Boundary, spacing: f64, layers: u32, side: Side) -> Vec<LayerParticle> {
        along_lines(self, boundary, spacing, layers, side)
    }

    fn translated(&self, by: &Vector) -> Self {
        self.translated(by)
    }
}

impl Faces<Plane> for Boundary {
    fn surface(&self, point: &Vector) -> SurfacePoint {
        self.surface(point)
    }

    fn surface_within(&self, point: &Vector, tolerance: f64) -> SurfacePoint {
        self.surface_within(point, tolerance)
    }

    fn layers_within(&self, depth: f64, along: f64, layers: u32) -> Vec<Vector> {
        layers_within(self, depth, along, layers)
    }

    fn moments(&self) -> Moments<Plane> {
        self.moments()
    }
}
