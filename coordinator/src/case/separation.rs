//! Whether bodies that are wet on both sides separate the fluid regions there.

use sph::shapes::{Faces, Region, local_thickness};

use super::Case;
use super::scene::{Scene, SceneSpace};
use sph::setup::InterfaceLaw;

/// Corners and tips have fewer particles than this; fluid interacts around them anyway.
const LEAST_PARTICLES: usize = 8;

/// Depth of a particle in a body over the thickness there, from which it says how thin the body is; 0.15 on the bisector of a
/// square corner, 0.25 in two rows.
const LEAST_DEPTH: f64 = 0.2;

/// Distance of fluid that is pressed to a body, from its face \[Δx of the fluid\]; half of one at rest.
const PRESSED: f64 = 0.4;

/// How a body separates the fluid regions on its sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// Name of the body.
    pub body: String,
    /// Rows of particles across its thinnest part; `None` where it is so thick that it does not matter.
    pub rows: Option<u32>,
    /// Thickness of that part \[m\].
    pub thickness: f64,
    /// Thickness from which it would separate them \[m\].
    pub needed: f64,
    /// Spacing of the fluid up to which it would separate them \[m\].
    pub coarsest: f64,
    /// By what.
    pub mechanism: Mechanism,
}

/// What separates the fluid regions on both sides of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mechanism {
    /// Its thickness: no particle of it interacts with both.
    Thick,
    /// A dummy pressure per face of each particle that interacts with both.
    DummyPressures,
    /// Nothing: both interact through it.
    None,
}

impl Separation {
    /// Whether the regions do not interact.
    pub fn is_complete(&self) -> bool {
        self.mechanism != Mechanism::None
    }

    /// The same in words.
    pub fn text(&self) -> String {
        let rows = match self.rows {
            None => "thick".to_owned(),
            Some(1) => "1 row where thinnest".to_owned(),
            Some(rows) => format!("{rows} rows where thinnest"),
        };
        let what = match self.mechanism {
            Mechanism::Thick => "fluid on one side does not interact with that on the other".to_owned(),
            Mechanism::DummyPressures => {
                "fluid on one side does not interact with that on the other: dummy pressures are kept per face".to_owned()
            }
            Mechanism::None => format!(
                "{:.2e} m: where both sides are wet, fluid on one side interacts with that on the other; a thickness of \
                 {:.2e} m or more separates them, or `fluid.particle_spacing_m` of at most {:.2e} m",
                self.thickness, self.needed, self.coarsest
            ),
        };
        format!("body `{}`, {rows}: {what}", self.body)
    }
}

/// Thickness from which a plate keeps the fluid on its sides apart: lengths in \[m\], the fluid's spacing and its kernel.
fn needed(fluid_spacing: f64, support: f64) -> f64 {
    support - 2.0 * PRESSED * fluid_spacing
}

/// What a plate of `rows` does: lengths in \[m\], of the solid's and the fluid's spacing and the fluid's kernel.
fn mechanism(
    rows: u32,
    solid_spacing: f64,
    fluid_spacing: f64,
    support: f64,
    law: InterfaceLaw,
) -> Mechanism {
    let pressed = PRESSED * fluid_spacing;
    // Of each row the distance to the farther fluid.
    let farther = |row: u32| f64::from((row + 1).max(rows - row)) * solid_spacing - 0.5 * solid_spacing;
    if f64::from(rows) * solid_spacing < needed(fluid_spacing, support) {
        Mechanism::None
    } else if law == InterfaceLaw::PlainSum || (0..rows).all(|row| farther(row) + pressed >= support) {
        // The plain sum has the solid's own pressure.
        Mechanism::Thick
    } else {
        Mechanism::DummyPressures
    }
}

impl Case {
    /// Particles across the thin side of the thinnest body that deforms and is not held as a whole; `None` where there is
    /// none.
    pub fn least_across(&self) -> Option<usize> {
        sph::in_space!(&self.scene, scene => {
            let across = (0u32..).zip(&scene.across).filter_map(|(k, across)| {
                let moves = scene.solid.support[scene.body_range(k)].contains(&0);
                across.filter(|_| moves)
            });
            across.min()
        })
    }

    /// How each body separates the fluid regions on its sides; nothing for a case of one side.
    pub fn separations(&self) -> Vec<Separation> {
        sph::in_space!(&self.scene, scene => self.separations_in(scene))
    }

    fn separations_in<S: SceneSpace>(&self, scene: &Scene<S>) -> Vec<Separation> {
        let (Some(fluid), Some(solid), Some(interface)) =
            (&self.file.fluid, &self.file.solid, &self.file.interface)
        else {
            return Vec::new();
        };
        let spacing = solid.particle_spacing_m.value;
        let (fluid_spacing, support) =
            (fluid.parameters.particle_spacing, 2.0 * fluid.parameters.smoothing_length());
        // Beyond twice the support a body is thick at any ratio of the spacings.
        let limit = 2.0 * support + spacing;
        let particles = &scene.solid;
        let mut found = Vec::new();
        for (k, body) in (0u32..).zip(&solid.bodies) {
            let Some(shape) = &body.shape else { continue };
            let points = &particles.reference_position[scene.body_range(k)];
            let shape = S::shape(&shape.value);
            let boundary = shape.boundary();
            let mut thickness: Vec<f64> = points
                .iter()
                .zip(local_thickness(&shape, points, spacing, limit))
                // Of a plate of one row or two all particles are so deep; those in the corners of a thicker one are not, and
                // look thin.
                .filter(|(x, thickness)| -boundary.surface(x).distance > LEAST_DEPTH * thickness)
                .map(|(_, thickness)| thickness)
                .collect();
            thickness.sort_by(f64::total_cmp);
            let Some(thin) = thickness.get(LEAST_PARTICLES.min(thickness.len()).saturating_sub(1)) else {
                continue;
            };
            // Whole and small: bounded by the limit.
            let rows = ((thin / spacing).round() as u32).max(1);
            let mechanism = mechanism(rows, spacing, fluid_spacing, support, interface.law.value);
            let needed = needed(fluid_spacing, support);
            let rows = (*thin < limit - spacing).then_some(rows);
            found.push(Separation {
                body: body.name.value.clone(),
                rows,
                thickness: *thin,
                needed,
                coarsest: fluid_spacing * thin / needed,
                mechanism,
            });
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plates_separate_by_rows_and_faces() {
        let wall = |rows, ratio: f64| mechanism(rows, 1.0, 1.0, 2.0 * ratio, InterfaceLaw::Wall);
        for ratio in [1.2, 1.3] {
            let found = [1, 2, 3, 4, 5].map(|rows| wall(rows, ratio));
            assert_eq!(
                found,
                [
                    Mechanism::None,
                    Mechanism::DummyPressures,
                    Mechanism::DummyPressures,
                    Mechanism::Thick,
                    Mechanism::Thick
                ]
            );
        }
        // A wide kernel reaches through two rows; the plain sum has no dummies.
        assert_eq!(wall(2, 1.5), Mechanism::None);
        assert_eq!(mechanism(3, 1.0, 1.0, 2.6, InterfaceLaw::PlainSum), Mechanism::Thick);
        // Four rows of half the spacing are as thin as two.
        assert_eq!(mechanism(4, 0.5, 1.0, 2.6, InterfaceLaw::Wall), Mechanism::DummyPressures);
    }
    #[test]
    fn corners_of_a_plate_are_not_thinner_than_the_plate() {
        let plate = "lower_m = [0.2, -0.03], upper_m = [0.26, 0.15]";
        let tank = crate::case::tests::TANK.replace(plate, "lower_m = [0.22, -0.03], upper_m = [0.24, 0.15]");
        let tank = tank.replace("at_m = [0.23, 0.15]", "at_m = [0.23, 0.14]");
        for spacing in [0.01, 0.004, 0.002, 0.001] {
            let text = tank.replace("[solid]\n", &format!("[solid]\nparticle_spacing_m = {spacing}\n"));
            let found = crate::case::tests::good(&text).separations();
            let plate = &found[1];
            assert!((plate.thickness - 0.02).abs() < 0.1 * spacing, "{plate:?}");
            // 1.8 spacings of the water.
            assert!(plate.is_complete() && (plate.needed - 0.018).abs() < 1e-12, "{plate:?}");
        }
    }
}
