//! What is constant during a run, checked once.

use sph::body_force::BodyForceField;
use sph::domain::Domain;
use sph::equation_of_state::Tait;
use sph::kernel::{CubicSpline, PairKernel};
use sph::lanes::Arithmetic;
use sph::repulsion::Repulsion;
use sph::setup::{
    Coupling, Damping, DensityDiffusion, FluidConstants, FluidParticles, FluidProbe, FluidProbeKind,
    FluidScheme, FluidSetup, GradientCorrection, OrderControl, Outflow, ViscousForm, WallParticles,
};
use sph::vector::Vector;

use super::lists::Lists;
use super::pair::PairLaw;
use super::state::FluidState;
use super::walls::WallModel;

/// What is constant during a run.
#[derive(Clone, Debug)]
pub struct FluidModel {
    /// Box and periodic directions.
    pub domain: Domain,
    /// Constants of the fluid.
    pub constants: FluidConstants,
    /// Pressure of a density, Eq. (3).
    pub equation_of_state: Tait,
    /// Smoothing kernel, Eq. (10)-(11).
    pub kernel: CubicSpline,
    /// Pair laws among the fluid and toward walls.
    pub law: PairLaw,
    /// Factor on the kernel gradient of own pairs: 1/M or 1 \[-\].
    pub gradient_scale: f64,
    /// Factor on the kernel gradient where L_i is not used though own pairs use it, as toward solids: 1/M or 1 \[-\].
    pub cross_gradient_scale: f64,
    /// δ h c₀ of Eq. (18) \[m²/s\]; zero without diffusion.
    pub diffusion: f64,
    /// α c₀ h of the acoustic damper \[m²/s\]; zero without it.
    pub acoustic_diffusivity: f64,
    /// How it is stepped.
    pub scheme: FluidScheme,
    /// How sums over neighbours are computed.
    pub arithmetic: Arithmetic,
    /// What the gradient pass makes.
    pub passes: Passes,
    /// Body force.
    pub body_force: BodyForceField,
    /// Linear damping of the start.
    pub damping: Option<Damping>,
    /// Names of the regions.
    pub regions: Vec<String>,
    /// Walls.
    pub walls: WallModel,
    /// Probes.
    pub probes: Vec<FluidProbe>,
    /// Open sides.
    pub outflow: Outflow,
    /// Lost particles allowed.
    pub lost_particle_limit: u64,
    /// Repulsion by wall faces.
    pub wall_repulsion: Repulsion,
    /// Shifting and tensile control.
    pub order: Option<OrderControl>,
    /// Facts of the interface.
    pub coupling: Option<Coupling>,
    /// Id of the first wall particle in snapshots: one beyond the fluid's largest.
    pub first_wall_id: u32,
}

/// What the scene needs from the pass over the neighbours before the rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passes {
    /// ∇ρ of Eq. (20), for Eq. (19).
    pub density_gradient: bool,
    /// L_i of Eq. (21) in Eq. (17).
    pub correction: bool,
    /// L_i in Eq. (22) too.
    pub momentum_correction: bool,
    /// Viscous stress of Eq. (4).
    pub viscosity: bool,
    /// Pressure of the acoustic damper.
    pub damper: bool,
    /// Viscous pair force.
    pub pair_viscosity: bool,
    /// Shifting or tensile control.
    pub order: bool,
    /// Leapfrog: the pass makes the density rates, in the predictor alone, and the corrector goes on with the rest.
    pub leapfrog: bool,
}

impl Passes {
    /// Whether the pass is needed at all.
    pub fn any(self) -> bool {
        self.moments() || self.velocity_gradient() || self.order || self.leapfrog
    }

    /// Whether neighbours read results of the pass.
    pub fn shown(self) -> bool {
        self.density_gradient || self.damper || self.order
    }

    /// Whether moments are needed.
    pub fn moments(self) -> bool {
        self.density_gradient || self.correction || self.pair_viscosity
    }

    /// Whether the velocity gradient is needed.
    pub fn velocity_gradient(self) -> bool {
        self.viscosity || self.pair_viscosity || self.damper || self.leapfrog
    }

    /// Whether momentum needs T = −σ·L as a tensor instead of a pressure.
    pub fn tensor(self) -> bool {
        self.momentum_correction || self.viscosity || self.pair_viscosity
    }
}

impl FluidModel {
    /// Model and first state of `setup`.
    ///
    /// # Errors
    /// Everything in the set-up that can not be run.
    pub fn new(setup: FluidSetup, arithmetic: Arithmetic) -> Result<(Self, FluidState), Vec<String>> {
        let mut errors = setup_errors(&setup);
        if !errors.is_empty() {
            return Err(errors);
        }
        let FluidSetup { run, constants, particles, .. } = setup;
        let kernel = CubicSpline::new(constants.smoothing_length);
        let lattice_scale = 1.0 / kernel.lattice_moment(constants.particle_spacing);
        let (gradient_scale, cross_gradient_scale) = match constants.correction {
            GradientCorrection::None => (1.0, 1.0),
            GradientCorrection::LatticeMoment | GradientCorrection::Continuity => {
                (lattice_scale, lattice_scale)
            }
            GradientCorrection::Renormalised => (1.0, lattice_scale),
        };
        let h = constants.smoothing_length;
        let delta = match setup.diffusion {
            DensityDiffusion::None => 0.0,
            DensityDiffusion::Plain { delta } | DensityDiffusion::Renormalised { delta } => delta,
        };
        let mass = constants.rest_density * constants.particle_spacing.powi(2);
        let walls = WallModel::new(
            &setup.walls,
            &setup.wall_particles,
            mass,
            constants.particle_spacing,
            kernel.support_radius(),
            &run.domain,
        );
        let body_force = BodyForceField::new(&run.body_force).map_err(|e| vec![e.to_string()]);
        let (walls, body_force) = match (walls, body_force) {
            (Ok(walls), Ok(body_force)) => (walls, body_force),
            (walls, body_force) => {
                errors.extend(walls.err().unwrap_or_default());
                errors.extend(body_force.err().unwrap_or_default());
                return Err(errors);
            }
        };
        let water = Tait::new(constants.rest_density, constants.sound_speed, constants.exponent);
        let model = Self {
            domain: run.domain,
            constants,
            equation_of_state: match setup.tension_limit {
                Some(tension) => water.bearing(tension),
                None => water,
            },
            kernel,
            law: PairLaw {
                kernel: PairKernel::new(&kernel, gradient_scale),
                smoothing_length: h,
                regularisation: constants.lambda * h * h,
                viscosity_a: constants.viscosity_a * constants.sound_speed,
                viscosity_b: constants.viscosity_b,
            },
            gradient_scale,
            cross_gradient_scale,
            diffusion: delta * h * constants.sound_speed,
            acoustic_diffusivity: setup.acoustic_damping * h * constants.sound_speed,
            scheme: setup.scheme,
            arithmetic,
            passes: Passes {
                density_gradient: matches!(setup.diffusion, DensityDiffusion::Renormalised { .. }),
                correction: matches!(
                    constants.correction,
                    GradientCorrection::Continuity | GradientCorrection::Renormalised
                ),
                momentum_correction: constants.correction == GradientCorrection::Renormalised,
                viscosity: constants.dynamic_viscosity > 0.0 && setup.viscous_form == ViscousForm::Stress,
                damper: setup.acoustic_damping > 0.0,
                pair_viscosity: constants.dynamic_viscosity > 0.0
                    && setup.viscous_form == ViscousForm::Pairwise,
                order: setup.order.is_some(),
                leapfrog: setup.scheme == FluidScheme::Leapfrog,
            },
            body_force,
            damping: setup.damping,
            regions: setup.regions,
            walls,
            probes: setup.probes,
            outflow: setup.outflow,
            wall_repulsion: Repulsion::new(
                setup.wall_repulsion,
                constants.particle_spacing,
                constants.particle_spacing,
                constants.sound_speed,
            ),
            lost_particle_limit: setup.lost_particle_limit,
            order: setup.order,
            coupling: run.coupling,
            first_wall_id: particles.id.iter().max().map_or(0, |id| id.saturating_add(1)),
        };
        let state = model.first_state(particles, run.time.start_time);
        Ok((model, state))
    }

    fn first_state(&self, particles: FluidParticles, time: f64) -> FluidState {
        let FluidParticles { id, region, mass, position, velocity, density } = particles;
        let body_force = self.body_force.at(time);
        // No stage has been evaluated yet: the body force stands in for the acceleration.
        let largest_acceleration =
            position.iter().map(|x| body_force.acceleration(x).norm()).fold(0.0, f64::max);
        let kept = if self.passes.leapfrog { id.len() } else { 0 };
        FluidState {
            density_rate: vec![0.0; kept],
            acceleration: vec![Vector::zeros(); kept],
            id,
            region,
            mass,
            position,
            velocity,
            density,
            list_skin: Lists::skins(self.constants.particle_spacing).first,
            largest_acceleration,
            ..FluidState::default()
        }
    }

    /// Rate k of the linear damping at `time` \[1/s\].
    pub fn damping_rate(&self, time: f64) -> f64 {
        self.damping.filter(|damping| time < damping.until).map_or(0.0, |damping| damping.rate)
    }

    /// ρ₀ c₀² \[Pa\].
    pub fn bulk_modulus(&self) -> f64 {
        self.constants.rest_density * self.constants.sound_speed * self.constants.sound_speed
    }

    /// Largest stable step \[s\] for the given largest speed \[m/s\] and acceleration \[m/s²\].
    ///
    /// ```text
    /// min( acoustic limit,  ¼ √(h/|a|),  ⅛ h²/ν )
    /// ```
    /// with [`FluidConstants::acoustic_limit`].
    pub fn time_step_limit(&self, speed: f64, acceleration: f64) -> f64 {
        let (c, h) = (&self.constants, self.constants.smoothing_length);
        let mut limit = c.acoustic_limit(speed, self.acoustic_diffusivity / (c.sound_speed * h), self.scheme);
        if acceleration > 0.0 {
            limit = limit.min(0.25 * (h / acceleration).sqrt());
        }
        if c.dynamic_viscosity > 0.0 {
            limit = limit.min(0.125 * h * h * c.rest_density / c.dynamic_viscosity);
        }
        limit
    }
}

/// Everything that would make the solver read outside its arrays or divide by nothing.
fn setup_errors(setup: &FluidSetup) -> Vec<String> {
    let mut errors = Vec::new();
    constants_errors(setup, &mut errors);
    particle_errors(&setup.particles, setup.regions.len(), &mut errors);
    wall_errors(&setup.wall_particles, setup.walls.len(), &mut errors);
    for probe in &setup.probes {
        let (index, count, what) = match probe.kind {
            FluidProbeKind::Region(Some(region)) => (region, setup.regions.len(), "region"),
            FluidProbeKind::WallForce(wall) => (wall, setup.walls.len(), "wall"),
            _ => continue,
        };
        if index as usize >= count {
            errors.push(format!("probe `{}` names {what} {index}, but there are {count}", probe.name));
        }
    }
    errors
}

fn constants_errors(setup: &FluidSetup, errors: &mut Vec<String>) {
    let c = &setup.constants;
    for (name, value) in [
        ("rest density [kg/m³]", c.rest_density),
        ("sound speed [m/s]", c.sound_speed),
        ("exponent", c.exponent),
        ("smoothing length [m]", c.smoothing_length),
        ("particle spacing [m]", c.particle_spacing),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            errors.push(format!("{name} = {value}: must be positive and finite"));
        }
    }
    for (name, value) in [
        ("dynamic viscosity [Pa s]", c.dynamic_viscosity),
        ("artificial viscosity A", c.viscosity_a),
        ("artificial viscosity B", c.viscosity_b),
        ("lambda", c.lambda),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            errors.push(format!("{name} = {value}: must be finite and not negative"));
        }
    }
    if setup.scheme == FluidScheme::Leapfrog && setup.viscous_form == ViscousForm::Stress {
        errors.push(
            "the viscous stress of Eq. (4) needs both stages: scheme must be predictor-corrector".into(),
        );
    }
    let (domain, smallest) =
        (&setup.run.domain, 4.0 * c.smoothing_length + 2.0 * Lists::skins(c.particle_spacing).thickest);
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let size = domain.size()[axis];
        if domain.periodic[axis] && size < smallest {
            errors.push(format!(
                "period along {name} = {size} m: must be at least {smallest} m (two support radii with skin), \
                 so that a pair meets through one image only"
            ));
        }
    }
}

fn particle_errors(p: &FluidParticles, regions: usize, errors: &mut Vec<String>) {
    let n = p.id.len();
    let lengths = [p.region.len(), p.mass.len(), p.position.len(), p.velocity.len(), p.density.len()];
    if lengths.iter().any(|length| *length != n) {
        errors.push(format!("fluid arrays differ in length: {n} ids, others {lengths:?}"));
        return;
    }
    if !p.id.is_sorted_by(|a, b| a < b) {
        errors.push("fluid ids must be strictly ascending".into());
    }
    for i in 0..n {
        let id = p.id[i];
        if p.region[i] as usize >= regions {
            errors.push(format!("fluid particle {id} names region {}, but there are {regions}", p.region[i]));
        }
        let finite = |v: &Vector| v.iter().all(|c| c.is_finite());
        let positive = |v: f64| v > 0.0 && v.is_finite();
        if !(positive(p.mass[i])
            && positive(p.density[i])
            && finite(&p.position[i])
            && finite(&p.velocity[i]))
        {
            errors.push(format!(
                "fluid particle {id}: mass {} kg/m and density {} kg/m³ must be positive, position and velocity finite",
                p.mass[i], p.density[i]
            ));
        }
        if errors.len() > 10 {
            errors.push("more of the same is not listed".into());
            return;
        }
    }
}

fn wall_errors(p: &WallParticles, walls: usize, errors: &mut Vec<String>) {
    let n = p.wall.len();
    if p.position.len() != n || p.normal.len() != n {
        let (positions, normals) = (p.position.len(), p.normal.len());
        errors.push(format!(
            "wall arrays differ in length: {n} walls, {positions} positions, {normals} normals"
        ));
        return;
    }
    if let Some(wall) = p.wall.iter().find(|wall| **wall as usize >= walls) {
        errors.push(format!("a wall particle names wall {wall}, but there are {walls}"));
    }
    if p.position.iter().chain(&p.normal).any(|v| !v.iter().all(|c| c.is_finite())) {
        errors.push("positions and normals of wall particles must be finite".into());
    }
}
