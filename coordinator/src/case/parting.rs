//! Whether bodies that are wet on both sides keep their waters apart.

use sph::setup::InterfaceLaw;
use sph::shapes::local_thickness;

use super::Case;

/// Corners and tips have fewer particles than this; water feels water around them anyway.
const LEAST_PARTICLES: usize = 8;

/// Distance at which water is pressed to a body, from its face \[Δx of the fluid\]; half of one at rest.
const PRESSED: f64 = 0.4;

/// How a body parts the waters on its sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Parting {
    /// Name of the body.
    pub body: String,
    /// Rows of particles across its thinnest part; `None` where it is so thick that it does not matter.
    pub rows: Option<u32>,
    /// How.
    pub how: How,
}

/// What a body does to waters on both of its sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// No particle of it meets both.
    Thick,
    /// Some meet both, and have a dummy pressure for each.
    Faces,
    /// Both feel each other through it.
    Open,
}

impl Parting {
    /// Whether no water feels the other.
    pub fn holds(&self) -> bool {
        self.how != How::Open
    }

    /// The same in words.
    pub fn text(&self) -> String {
        let rows = match self.rows {
            None => "thick".to_owned(),
            Some(1) => "1 row where thinnest".to_owned(),
            Some(rows) => format!("{rows} rows where thinnest"),
        };
        let what = match self.how {
            How::Thick => "water on one side does not feel that on the other",
            How::Faces => {
                "water on one side does not feel that on the other: dummy pressures are kept per face"
            }
            How::Open => {
                "water on one side feels that on the other if both are wet; a thicker body or a smaller \
                 `particle_spacing_m` of both sides parts them"
            }
        };
        format!("body `{}`, {rows}: {what}", self.body)
    }
}

/// What a plate of `rows` does: lengths in \[m\], of the solid's and the fluid's spacing and the fluid's kernel.
fn how(rows: u32, solid_spacing: f64, fluid_spacing: f64, support: f64, law: InterfaceLaw) -> How {
    let pressed = PRESSED * fluid_spacing;
    // Of each row the distance to the farther water.
    let farther = |row: u32| f64::from((row + 1).max(rows - row)) * solid_spacing - 0.5 * solid_spacing;
    if f64::from(rows) * solid_spacing + 2.0 * pressed < support {
        How::Open
    } else if law == InterfaceLaw::PlainSum || (0..rows).all(|row| farther(row) + pressed >= support) {
        // The plain sum has the solid's own pressure.
        How::Thick
    } else {
        How::Faces
    }
}

impl Case {
    /// How each body parts the waters on its sides; nothing for a case of one side.
    pub fn parting(&self) -> Vec<Parting> {
        let (Some(fluid), Some(solid), Some(interface)) =
            (&self.file.fluid, &self.file.solid, &self.file.interface)
        else {
            return Vec::new();
        };
        let spacing = solid.particle_spacing_m.value;
        let (fluid_spacing, support) = (fluid.particle_spacing_m.value, 2.0 * fluid.smoothing_length());
        // Beyond twice the support a body is thick at any ratio of the spacings.
        let limit = 2.0 * support + spacing;
        let particles = &self.scene.solid;
        let mut found = Vec::new();
        for (k, body) in (0u32..).zip(&solid.bodies) {
            let Some(shape) = &body.shape else { continue };
            let points = &particles.reference_position[self.scene.body_range(k)];
            let mut thickness = local_thickness(&shape.value.to_shape(), points, spacing, limit);
            thickness.sort_by(f64::total_cmp);
            let Some(thin) = thickness.get(LEAST_PARTICLES.min(thickness.len()).saturating_sub(1)) else {
                continue;
            };
            // Whole and small: bounded by the limit.
            let rows = ((thin / spacing).round() as u32).max(1);
            let how = how(rows, spacing, fluid_spacing, support, interface.law.value);
            let rows = (*thin < limit - spacing).then_some(rows);
            found.push(Parting { body: body.name.value.clone(), rows, how });
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plates_part_by_rows_and_faces() {
        let wall = |rows, ratio: f64| how(rows, 1.0, 1.0, 2.0 * ratio, InterfaceLaw::Wall);
        for ratio in [1.2, 1.3] {
            let found = [1, 2, 3, 4, 5].map(|rows| wall(rows, ratio));
            assert_eq!(found, [How::Open, How::Faces, How::Faces, How::Thick, How::Thick]);
        }
        // A wide kernel reaches through two rows; the plain sum has no dummies.
        assert_eq!(wall(2, 1.5), How::Open);
        assert_eq!(how(3, 1.0, 1.0, 2.6, InterfaceLaw::PlainSum), How::Thick);
        // Four rows of half the spacing are as thin as two.
        assert_eq!(how(4, 0.5, 1.0, 2.6, InterfaceLaw::Wall), How::Faces);
    }
}
