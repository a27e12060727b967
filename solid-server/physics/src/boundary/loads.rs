//! Loads on the surface of bodies, prescribed as expressions.

use sph::expression::{ComponentError, Expression};
use sph::setup::{LoadLaw, SurfaceLoad};
use sph::space::tensors::SpaceTensor;
use sph::space::{Tensor, Vector};

/// A load on part of a body's surface.
pub struct Load {
    law: ParsedLaw,
    faces: Vec<LoadedFace>,
}

/// A face of a particle's cell.
struct LoadedFace {
    /// Index of the particle within its body.
    particle: usize,
    /// Outward area vector N A of the undeformed face per depth \[m\].
    area: Vector,
}

enum ParsedLaw {
    /// Pressure \[Pa\].
    Pressure(Expression),
    /// Force per undeformed area \[Pa\].
    Traction([Expression; 2]),
}

impl Load {
    /// Variables of the expressions in the order of evaluation: present position \[m\] and time \[s\].
    const VARIABLES: [&'static str; 3] = ["x", "y", "t"];

    /// The load that `setup` describes.
    ///
    /// # Errors
    /// When a text is no expression of x, y, t.
    pub fn new(setup: &SurfaceLoad) -> Result<Self, ComponentError> {
        let parse = |component, text: &str| Expression::parse_component(component, text, &Self::VARIABLES);
        let law = match &setup.law {
            LoadLaw::Pressure(text) => ParsedLaw::Pressure(parse("pressure", text)?),
            LoadLaw::Traction([x, y]) => {
                ParsedLaw::Traction([parse("traction x", x)?, parse("traction y", y)?])
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
        position: &[Vector],
        deformation: &[Tensor],
        mut add: impl FnMut(usize, Vector, Vector),
    ) {
        for face in &self.faces {
            let i = face.particle;
            let values = [position[i].x, position[i].y, time];
            let force = match &self.law {
                ParsedLaw::Pressure(p) => deformation[i].cofactor() * face.area * -p.eval(&values),
                ParsedLaw::Traction([x, y]) => {
                    Vector::new(x.eval(&values), y.eval(&values)) * face.area.norm()
                }
            };
            // Cells are squares: a face is as far from the middle as half its length.
            add(i, force, face.area * 0.5);
        }
    }
}
