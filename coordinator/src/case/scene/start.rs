//! Velocity, pressure and density at the start.

use sph::expression::Expression;
use sph::kernel::CubicSpline;
use sph::laws::equation_of_state::Tait;
use sph::setup::{FluidParameters, GradientCorrection};
use sph::space::Space;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;

use super::point_text;
use crate::case::errors::{CaseError, ErrorList, Place};
use crate::case::file::fluid::{HydrostaticLattice, ParticleMass, StartTable};
use crate::case::reader::{At, Written, is_bounded};
use crate::case::spec::Variables;

/// Steps of work to evaluate the expression `text`: an instruction of some nanoseconds has two characters or more.
pub fn expression_steps(text: &str) -> f64 {
    2.0 * (1 + text.len()) as f64
}

/// Values of expressions of the coordinates, one for each axis, at `positions`.
pub fn field<S: Space>(
    components: &[At<Written>],
    positions: &[S::Vector],
    errors: &ErrorList,
) -> Vec<S::Vector> {
    let mut vectors = vec![S::Vector::zeros(); positions.len()];
    for (axis, written) in components.iter().enumerate() {
        for (vector, value) in vectors.iter_mut().zip(values::<S>(written, positions, errors)) {
            vector[axis] = value;
        }
    }
    vectors
}

/// Values of an expression of the coordinates at `positions`; an error where one is not finite.
pub fn values<S: Space>(written: &At<Written>, positions: &[S::Vector], errors: &ErrorList) -> Vec<f64> {
    let text = match &written.value {
        Written::Number(number) => return vec![*number; positions.len()],
        Written::Text(text) => text,
    };
    // A text that is no expression has been reported where it was read.
    let Ok(expression) = Expression::parse(text, Variables::Coordinates.names(S::DIMENSIONS)) else {
        return vec![0.0; positions.len()];
    };
    if !errors.spend(&written.place, expression_steps(text) * positions.len() as f64) {
        return vec![0.0; positions.len()];
    }
    let mut values: Vec<f64> = positions.iter().map(|x| expression.eval(x.row().as_ref())).collect();
    if let Some(k) = values.iter().position(|value| !is_bounded(*value)) {
        let problem = format!("is {:e} at {}", values[k], point_text::<S>(&positions[k]));
        let allowed = "finite values in the whole shape, of a magnitude of at most 1e30";
        errors.add(CaseError::new(&written.place, problem).value(text).allowed(allowed));
        values.fill(0.0);
    }
    values
}

/// Particles of a region at the start.
pub struct Started {
    /// Masses \[kg\], in the plane per depth.
    pub mass: Vec<f64>,
    /// Densities \[kg/m³\].
    pub density: Vec<f64>,
}

/// What decides masses and densities at the start.
pub struct Water<'a, S: Space> {
    /// Parameters of the fluid.
    pub constants: &'a FluidParameters,
    /// Gravity \[m/s²\].
    pub gravity: S::Vector,
    /// Volume (area in the plane) of the cell of each particle \[m³\]; `None` for those of the lattice.
    pub volume: Option<&'a [f64]>,
}

/// Gives the particles of a region their mass and density; a consistent hydrostatic start moves them too.
pub fn start<S: Space>(
    table: &StartTable,
    place: &Place,
    water: &Water<'_, S>,
    positions: &mut [S::Vector],
    errors: &ErrorList,
) -> Started {
    let &Water { constants, gravity, .. } = water;
    let cell = S::cell_volume(constants.particle_spacing);
    let volume = |k: usize| water.volume.map_or(cell, |volume| volume[k]);
    let count = positions.len();
    let rest_mass = || (0..count).map(|k| constants.rest_density * volume(k)).collect();
    let at_rest = || Started { mass: rest_mass(), density: vec![constants.rest_density; count] };
    let masses = |density: &[f64]| density.iter().enumerate().map(|(k, rho)| rho * volume(k)).collect();
    let tait = constants.equation_of_state();
    match table {
        StartTable::Rest => at_rest(),
        StartTable::Hydrostatic { surface_m, lattice } => {
            let Some(column) = Hydrostatics::<S>::new(constants, gravity, *surface_m, lattice.value) else {
                let error = CaseError::new(place, "a hydrostatic start needs gravity");
                errors.add(error.hint("set `body_force.gravity_m_s2`"));
                return at_rest();
            };
            if lattice.value == HydrostaticLattice::Consistent && column.confines(positions) {
                let density = column.in_place(&tait, positions);
                return Started { mass: masses(&density), density };
            }
            let density = column.settle(&tait, positions, lattice.value);
            Started { mass: rest_mass(), density }
        }
        StartTable::Pressure { pressure_pa, particle_mass } => {
            let pressure = values::<S>(pressure_pa, positions, errors);
            let density: Vec<f64> = pressure.iter().map(|p| tait.density(*p)).collect();
            // Beyond these the weakly compressible model has no meaning.
            let sound = |rho: &f64| (0.5..=2.0).contains(&(rho / constants.rest_density));
            if let Some(k) = density.iter().position(|rho| !sound(rho)) {
                let problem = format!(
                    "{} Pa at {} means a density of {} kg/m³",
                    pressure[k],
                    point_text::<S>(&positions[k]),
                    density[k]
                );
                let error = CaseError::new(&pressure_pa.place, problem);
                errors.add(error.hint("check the pressure, or raise `fluid.sound_speed_m_s`"));
            }
            let mass = match particle_mass.value {
                ParticleMass::Rest => rest_mass(),
                ParticleMass::FromDensity => masses(&density),
            };
            Started { mass, density }
        }
    }
}

/// A column of fluid at rest under its own weight.
///
/// ```text
/// p = ρ₀ g d / M',  d = depth below the surface, counted in rest volume
/// ```
/// M' is the lattice moment where the kernel gradient is not corrected: the sums (17) and (22) are adjoint, so they
/// balance this pressure and no other. It is 1 otherwise.
struct Hydrostatics<S: Space> {
    up: S::Vector,
    surface: f64,
    /// dp/dd \[Pa/m\].
    slope: f64,
    /// dp/dd over the stiffness p₀ \[1/m\].
    steepness: f64,
    exponent: f64,
    spacing: f64,
}

impl<S: Space> Hydrostatics<S> {
    fn new(
        constants: &FluidParameters,
        gravity: S::Vector,
        surface: f64,
        lattice: HydrostaticLattice,
    ) -> Option<Self> {
        let g = gravity.norm();
        let moment = match (lattice, constants.correction) {
            (HydrostaticLattice::Consistent, GradientCorrection::None) => {
                CubicSpline::<S>::new(constants.smoothing_length()).lattice_moment(constants.particle_spacing)
            }
            _ => 1.0,
        };
        let slope = constants.rest_density * g / moment;
        let exponent = constants.equation_of_state().exponent();
        let stiffness = constants.rest_density * constants.sound_speed.powi(2) / exponent;
        (g > 0.0).then(|| Self {
            up: -gravity / g,
            surface,
            slope,
            steepness: slope / stiffness,
            exponent,
            spacing: constants.particle_spacing,
        })
    }

    /// Height of the compressed fluid \[m\] whose rest height is `depth` \[m\]: ∫ ρ₀/ρ dd with ρ/ρ₀ = (1 + kd)^(1/γ).
    fn compressed(&self, depth: f64) -> f64 {
        let (k, gamma) = (self.steepness, self.exponent);
        if depth <= 0.0 {
            depth
        } else if gamma == 1.0 {
            (k * depth).ln_1p() / k
        } else {
            let power = 1.0 - 1.0 / gamma;
            (power * (k * depth).ln_1p()).exp_m1() / (k * power)
        }
    }

    /// Rest height of the fluid \[m\] that is `height` \[m\] deep: inverse of [`Hydrostatics::compressed`].
    fn at_rest(&self, height: f64) -> f64 {
        let (k, gamma) = (self.steepness, self.exponent);
        if height <= 0.0 {
            height
        } else if gamma == 1.0 {
            (k * height).exp_m1() / k
        } else {
            let power = 1.0 - 1.0 / gamma;
            ((k * power * height).ln_1p() / power).exp_m1() / k
        }
    }

    /// Whether the surface lies above the whole region, by more than a row that did not fit in: something confines it.
    fn confines(&self, positions: &[S::Vector]) -> bool {
        let highest = positions.iter().map(|x| x.dot(&self.up)).fold(f64::NEG_INFINITY, f64::max);
        self.surface - highest > 1.5 * self.spacing
    }

    /// Densities of water that stays in its place, since it can not be drawn together.
    fn in_place(&self, tait: &Tait, positions: &[S::Vector]) -> Vec<f64> {
        let pressure = |x: &S::Vector| self.slope * self.at_rest((self.surface - x.dot(&self.up)).max(0.0));
        positions.iter().map(|x| tait.density(pressure(x))).collect()
    }

    /// Densities; on the consistent lattice, rows move down onto those below.
    fn settle(&self, tait: &Tait, positions: &mut [S::Vector], lattice: HydrostaticLattice) -> Vec<f64> {
        let lowest = positions.iter().map(|x| x.dot(&self.up)).fold(f64::INFINITY, f64::min);
        let base = lowest - 0.5 * self.spacing;
        let whole = self.compressed(self.surface - base);
        positions
            .iter_mut()
            .map(|x| {
                let height = x.dot(&self.up);
                let depth = self.surface - height;
                if lattice == HydrostaticLattice::Consistent {
                    *x += self.up * (base + whole - self.compressed(depth) - height);
                }
                tait.density(self.slope * depth.max(0.0))
            })
            .collect()
    }
}
