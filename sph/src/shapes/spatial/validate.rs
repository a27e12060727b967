//! What a shape in space must satisfy, in the words of a case file.

use nalgebra::Vector3;

use super::SpatialShape;
use crate::shapes::{MAXIMUM_NESTING, Region};

impl SpatialShape {
    /// Checks that the shape encloses a volume: finite numbers, positive sizes, sound sections, no empty part, bounded.
    ///
    /// # Errors
    /// What is wrong, with the value and what is allowed.
    pub fn validate(&self) -> Result<(), String> {
        validate(self, 0)?;
        let (lower, upper) = self.bounds();
        if !(upper - lower).norm_squared().is_finite() {
            return Err("the shape is unbounded: intersect the half-space with a box".to_owned());
        }
        if (0..3).any(|axis| lower[axis] >= upper[axis]) {
            return Err("the shape is empty: its parts have no point in common".to_owned());
        }
        Ok(())
    }
}

fn validate(shape: &SpatialShape, level: usize) -> Result<(), String> {
    if level > MAXIMUM_NESTING {
        return Err(format!("shapes are nested more than {MAXIMUM_NESTING} deep; use a surface"));
    }
    let all = |kind: &str, parts: &[SpatialShape]| {
        if parts.is_empty() {
            return Err(format!("{kind} has no parts; at least one shape is needed"));
        }
        parts.iter().enumerate().try_for_each(|(index, part)| {
            validate(part, level + 1).map_err(|error| format!("part {} of {kind}: {error}", index + 1))
        })
    };
    match shape {
        SpatialShape::Box { lower, upper } => {
            finite("lower corner", lower)?;
            finite("upper corner", upper)?;
            for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                if lower[axis] >= upper[axis] {
                    return Err(format!(
                        "box: lower {name} = {} m, upper {name} = {} m: upper must lie above lower",
                        lower[axis], upper[axis]
                    ));
                }
            }
            Ok(())
        }
        SpatialShape::Sphere { centre, radius } => {
            finite("centre", centre)?;
            positive("radius", *radius)
        }
        SpatialShape::Cylinder { from, to, radius, inner_radius } => {
            ends(from, to)?;
            positive("radius", *radius)?;
            if !(0.0..*radius).contains(inner_radius) {
                return Err(format!(
                    "cylinder: inner radius = {inner_radius} m, radius = {radius} m: inner must be zero or more and \
                     below outer"
                ));
            }
            Ok(())
        }
        SpatialShape::Cone { from, to, radii } => {
            ends(from, to)?;
            if radii.iter().all(|radius| *radius >= 0.0 && radius.is_finite()) && radii[0] + radii[1] > 0.0 {
                return Ok(());
            }
            Err(format!(
                "cone: radii = [{}, {}] m: must be finite and not negative, one above zero",
                radii[0], radii[1]
            ))
        }
        SpatialShape::Torus { centre, axis, radius, tube_radius } => {
            finite("centre", centre)?;
            direction("axis", axis)?;
            positive("radius", *radius)?;
            positive("tube radius", *tube_radius)?;
            if tube_radius >= radius {
                return Err(format!(
                    "torus: tube radius = {tube_radius} m, radius = {radius} m: the tube must not reach the axis"
                ));
            }
            Ok(())
        }
        SpatialShape::Extrusion { section, frame, height } => {
            finite("origin", &frame.origin())?;
            positive("height", *height)?;
            section.validate().map_err(|error| format!("section: {error}"))
        }
        SpatialShape::Revolution { section, frame } => {
            finite("origin", &frame.origin())?;
            section.validate().map_err(|error| format!("section: {error}"))?;
            let least = section.bounds().0.x;
            if least < 0.0 {
                return Err(format!(
                    "revolution: the section reaches x = {least} m: it must not cross the axis, x = 0"
                ));
            }
            Ok(())
        }
        SpatialShape::HalfSpace { point, normal } => {
            finite("point", point)?;
            direction("normal", normal)
        }
        SpatialShape::Union(parts) => all("union", parts),
        SpatialShape::Intersection(parts) => all("intersection", parts),
        SpatialShape::Difference(base, removed) => {
            validate(base, level + 1).map_err(|error| format!("first shape of difference: {error}"))?;
            all("difference", removed)
        }
        SpatialShape::Placed { shape, frame } => {
            finite("origin", &frame.origin())?;
            validate(shape, level + 1)
        }
        // What is wrong with a surface is known where it is made, and so is whether that is accepted.
        SpatialShape::Surface(_) => Ok(()),
    }
}

fn finite(what: &str, point: &Vector3<f64>) -> Result<(), String> {
    if point.norm_squared().is_finite() {
        return Ok(());
    }
    Err(format!("{what} = ({}, {}, {}) m: all must be finite numbers", point.x, point.y, point.z))
}

fn positive(what: &str, value: f64) -> Result<(), String> {
    if value > 0.0 && (value * value * value).is_finite() {
        return Ok(());
    }
    Err(format!("{what} = {value} m: must be a positive finite number"))
}

fn direction(what: &str, vector: &Vector3<f64>) -> Result<(), String> {
    if vector.norm() > 0.0 && vector.norm_squared().is_finite() {
        return Ok(());
    }
    Err(format!("{what} = ({}, {}, {}): must be finite and not zero", vector.x, vector.y, vector.z))
}

fn ends(from: &Vector3<f64>, to: &Vector3<f64>) -> Result<(), String> {
    finite("one end", from)?;
    finite("other end", to)?;
    direction("axis from one end to the other", &(to - from))
}
