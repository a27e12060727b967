//! What a case may say and hardly means: units other than SI, signs, values of no known substance.

use sph::setup::ElasticParameters;

use crate::case::Case;
use crate::case::file::body::BodyTable;
use crate::case::file::material::FormulationTable;
use crate::case::file::wall::WallTable;

/// Magnitude of gravity above which a unit is suspected \[m/s²\]: ten times that on Earth.
const LARGEST_GRAVITY: f64 = 100.0;

/// Densities of liquids \[kg/m³\]: from liquid gases to mercury, with a margin.
const LIQUID_DENSITIES: std::ops::RangeInclusive<f64> = 300.0..=20_000.0;

/// Densities of solids \[kg/m³\]: from rigid foam to osmium.
const SOLID_DENSITIES: std::ops::RangeInclusive<f64> = 10.0..=23_000.0;

/// Young's moduli \[Pa\]: from the softest gels to diamond.
const YOUNG_MODULI: std::ops::RangeInclusive<f64> = 1e3..=1.3e12;

/// Above this ratio of Poisson pressure decides the step, and a body resists bending too much.
const LARGEST_POISSON_RATIO: f64 = 0.495;

/// Sound speed from which that of real liquids is suspected \[m/s\].
const REAL_SOUND_SPEED: f64 = 1000.0;

/// Dynamic viscosity above which a unit is suspected \[Pa s\]: that of honey is 10.
const LARGEST_VISCOSITY: f64 = 1000.0;

/// Extent of a scene from which millimetres are suspected \[m\].
const LARGEST_EXTENT: f64 = 200.0;

/// Extent of a scene below which larger units are suspected \[m\].
const SMALLEST_EXTENT: f64 = 1e-4;

/// Particles of water below which hardly any flow is resolved, in the plane and in space.
const FEWEST_PARTICLES: [usize; 2] = [50, 200];

/// What is odd, what is usual and what to do.
fn odd(what: String, usual: &str, remedy: &str) -> String {
    format!("{what}: {usual}; {remedy}")
}

impl Case {
    /// What the case says and hardly means.
    pub(in crate::case) fn oddities(&self) -> Vec<String> {
        let mut lines = Vec::new();
        lines.extend(self.odd_gravity());
        lines.extend(self.odd_lengths());
        lines.extend(self.odd_fluid());
        for body in self.file.solid.iter().flat_map(|solid| &solid.bodies) {
            lines.extend(odd_material(body));
        }
        lines
    }

    fn odd_gravity(&self) -> Vec<String> {
        let gravity = self.file.body_force.gravity_m_s2.as_slice();
        let written = format!("body_force.gravity_m_s2 = {gravity:?}");
        let magnitude = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let mut lines = Vec::new();
        if gravity.len() == 2 && gravity[1] > 0.0 {
            lines.push(odd(
                format!("{written} points upward"),
                "y points up, and gravity on Earth is [0.0, -9.81]",
                "reverse the sign unless things are meant to fall up",
            ));
        } else if let Some((wall, side)) = self.file.walls.iter().find_map(|wall| open_below(wall, gravity)) {
            lines.push(odd(
                format!("{written} points to the open side `{side}` of wall `{wall}`"),
                "a container is open above, against gravity",
                "reverse the sign of gravity, or open another side",
            ));
        }
        if magnitude > LARGEST_GRAVITY {
            lines.push(odd(
                format!("{written} has a magnitude of {magnitude} m/s²"),
                "on Earth it is 9.81 m/s², which is 981 cm/s² and 9810 mm/s²",
                "write it in m/s²",
            ));
        }
        lines
    }

    fn odd_lengths(&self) -> Option<String> {
        let domain = &self.file.domain;
        let corners = domain.lower_m.value.as_slice().iter().zip(domain.upper_m.value.as_slice());
        let extent = corners.map(|(lower, upper)| upper - lower).fold(0.0, f64::max);
        let spacing = match (&self.file.fluid, &self.file.solid) {
            (Some(fluid), _) => fluid.parameters.particle_spacing,
            (None, Some(solid)) => solid.particle_spacing_m.value,
            (None, None) => return None,
        };
        if extent >= LARGEST_EXTENT || spacing >= 1.0 {
            return Some(odd(
                format!("[domain] is {extent} m long, with particles of {spacing} m"),
                "lengths are in metres: a tank of 400 mm is 0.4",
                "divide lengths, speeds and accelerations by 1000 if they are in millimetres",
            ));
        }
        (extent < SMALLEST_EXTENT).then(|| {
            odd(
                format!("[domain] is {extent} m long"),
                "below 0.1 mm surface tension decides, which is not modelled",
                "give lengths in metres",
            )
        })
    }

    fn odd_fluid(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let Some(fluid) = &self.file.fluid else { return lines };
        let density = fluid.parameters.rest_density;
        if !LIQUID_DENSITIES.contains(&density) {
            lines.push(odd(
                format!("fluid.rest_density_kg_m3 = {density} is the density of no liquid"),
                "water has 1000 kg/m³, which is 1 g/cm³",
                "write it in kg/m³; forces and pressures scale with it",
            ));
        }
        let sound_speed = fluid.parameters.sound_speed;
        if sound_speed >= REAL_SOUND_SPEED {
            lines.push(odd(
                format!("fluid.sound_speed_m_s = {sound_speed} is that of a real liquid"),
                "10 times the largest speed of the fluid keeps its density within 1 %, and steps are as much longer as c₀ \
                 is less",
                "take 10 to 20 times the largest speed, √(2 g H) where water of depth H falls, unless sound itself is wanted",
            ));
        }
        let viscosity = fluid.parameters.dynamic_viscosity;
        if viscosity > LARGEST_VISCOSITY {
            lines.push(odd(
                format!("fluid.dynamic_viscosity_pa_s = {viscosity} is thicker than honey"),
                "water has 0.001 Pa s, oil 0.1 Pa s, honey 10 Pa s",
                "write it in Pa s, which is 1000 mPa s",
            ));
        }
        let count = sph::in_space!(&self.scene, scene => scene.fluid.position.len());
        let dimensions = self.file.domain.dimensions();
        if count < FEWEST_PARTICLES[usize::from(dimensions == 3)] {
            lines.push(odd(
                format!(
                    "fluid.particle_spacing_m = {} leaves {count} particles of fluid",
                    fluid.parameters.particle_spacing
                ),
                "a flow needs ten particles across its narrowest part",
                "take a smaller spacing",
            ));
        }
        lines
    }
}

/// The wall and its open side that `gravity` points to.
fn open_below<'a>(wall: &'a WallTable, gravity: &[f64]) -> Option<(&'a str, &'static str)> {
    let strongest = gravity.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let (axis, pull) = strongest.filter(|(_, pull)| **pull != 0.0)?;
    let sides = || wall.open_sides.iter().flatten();
    let open = sides().find(|side| side.value.axis == axis && side.value.upper == (*pull > 0.0))?;
    // A case may let water fall through: then the side above is open, too.
    let opposite = sides().any(|side| side.value.axis == axis && side.value.upper != (*pull > 0.0));
    (!opposite).then_some((wall.name.value.as_str(), open.word))
}

fn odd_material(body: &BodyTable) -> Vec<String> {
    let material: ElasticParameters = body.material.parameters.values();
    let name = &body.name.value;
    let mut lines = Vec::new();
    if !SOLID_DENSITIES.contains(&material.density) {
        lines.push(odd(
            format!("density_kg_m3 = {} of body `{name}` is that of no solid", material.density),
            "wood has 500, rubber 1100, steel 7850 kg/m³; 1 g/cm³ is 1000 kg/m³",
            "write it in kg/m³",
        ));
    }
    if matches!(body.formulation, FormulationTable::Rigid) {
        return lines;
    }
    let young = material.young_modulus();
    // Without the round-off of the way through K and G.
    let young: f64 = format!("{young:.6e}").parse().unwrap_or(young);
    if !YOUNG_MODULI.contains(&young) {
        lines.push(odd(
            format!("Young's modulus of body `{name}` is {young} Pa"),
            "gels have 1e3 to 1e5, rubber 1e6 to 1e8, wood 1e10, steel 2.1e11 Pa",
            "write elastic constants in Pa: 1 MPa is 1e6, 1 GPa is 1e9",
        ));
    }
    let (bulk, shear) = (material.bulk_modulus, material.shear_modulus);
    let poisson = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear));
    if !(-1e-9..=LARGEST_POISSON_RATIO).contains(&poisson) {
        lines.push(odd(
            format!("Poisson's ratio of body `{name}` is {poisson:.4}"),
            "metals have 0.3, rubber 0.49; below 0 a body that is stretched gets thicker, and near 0.5 steps get short and \
             thin bodies bend too little",
            "take a value from 0 to 0.49",
        ));
    }
    lines
}
