//! Loads on the surface of bodies, prescribed as expressions.

use sph::expression::{ComponentError, Expression};
use sph::prescribed::body_force::{BodyForceField, values_at};
use sph::setup::{LoadLaw, SurfaceLoad};
use sph::space::tensors::{SpaceTensor, SpaceVector};

use crate::space::SolidSpace;

/// A load on part of a body's surface.
pub struct Load<S: SolidSpace> {
    law: ParsedLaw,
    faces: Vec<LoadedFace<S>>,
}

/// A face of a particle's cell.
struct LoadedFace<S: SolidSpace> {
    /// Index of the particle within its body.
    particle: usize,
    /// Outward area vector N A of the undeformed face per depth \[m\].
    area: S::Vector,
}

enum ParsedLaw {
    /// Pressure \[Pa\].
    Pressure(Expression),
    /// Force per undeformed area, one for each axis \[Pa\].
    Traction(Vec<Expression>),
}

impl<S: SolidSpace> Load<S> {
    /// The load that `setup` describes.
    ///
    /// # Errors
    /// When a text is no expression of x, y, in space z, and t: present position \[m\] and time \[s\].
    pub fn new(setup: &SurfaceLoad<S>) -> Result<Self, ComponentError> {
        let parse = |component, text: &str| {
            Expression::parse_component(component, text, BodyForceField::<S>::VARIABLES)
        };
        let law = match &setup.law {
            LoadLaw::Pressure(text) => ParsedLaw::Pressure(parse("pressure", text)?),
            LoadLaw::Traction(texts) => {
                let components = ["traction x", "traction y", "traction z"];
                let parsed =
                    components.iter().zip(texts.as_ref()).map(|(component, text)| parse(component, text));
                ParsedLaw::Traction(parsed.collect::<Result<_, _>>()?)
            }
        };
        let faces = setup.particles.iter().zip(&setup.areas);
        let faces = faces.map(|(i, area)| LoadedFace { particle: *i as usize, area: *area }).collect();
        Ok(Self { law, faces })
    }

    /// Whether the load turns with the surface.
    pub fn follows(&self) -> bool {
        matches!(self.law, ParsedLaw::Pressure(_))
    }

    /// Calls `add` with particle, force \[N/m\] and half-way vector X to the face \[m\] for each loaded face at `time`
    /// \[s\], for the body's particles at `position` \[m\] with deformation gradients `deformation`.
    ///
    /// ```text
    /// pressure: f = −p J F⁻ᵀ N A (Nanson);  traction: f = t A
    /// ```
    pub fn forces(
        &self,
        time: f64,
        position: &[S::Vector],
        deformation: &[S::Tensor],
        mut add: impl FnMut(usize, S::Vector, S::Vector),
    ) {
        for face in &self.faces {
            let i = face.particle;
            let values = values_at::<S>(&position[i], time);
            let force = match &self.law {
                ParsedLaw::Pressure(p) => deformation[i].cofactor() * face.area * -p.eval(&values),
                ParsedLaw::Traction(components) => {
                    S::vector(S::axes(|axis| components[axis].eval(&values))) * face.area.norm()
                }
            };
            add(i, force, S::to_face(&face.area));
        }
    }
}
