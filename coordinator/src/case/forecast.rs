//! Forecast of the CPU time of a step: the work of both solvers, counted in what their time goes into, and the cost of
//! each unit of it.

use solid::limits::{automatic_substeps, total_lagrangian_substep, updated_lagrangian_substep};
use sph::setup::{
    DensityDiffusion, FluidScheme, FluidSetup, Formulation, GradientCorrection, HyperelasticLaw, SolidSetup,
    SolidStepping, SubstepCount,
};

/// What the time of a step goes into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A pair of fluid particles in the pass over gradients.
    GradientPair,
    /// The same, in addition where L_i, the density gradient or the viscosity need moments.
    MomentPair,
    /// The same, in addition with shifting or tensile control.
    RegularisationPair,
    /// A pair of fluid particles in the pass over forces.
    ForcePair,
    /// The same, in addition where neighbours read results of the pass over gradients.
    FieldPair,
    /// The same, in addition where the momentum equation takes tensors.
    TensorPair,
    /// A fluid particle in a half-step: movement, checks, lists.
    FluidParticle,
    /// A wall particle in a half-step.
    WallParticle,
    /// A pair of an updated-Lagrangian body in an evaluation of its forces.
    UpdatedPair,
    /// A pair of a total-Lagrangian body in an evaluation of its forces.
    ReferencePair,
    /// A particle of a neo-Hookean body in an evaluation of its forces.
    NeoHookeanParticle,
    /// A particle of a body that can touch a wall or another body, in an evaluation of forces.
    ContactParticle,
    /// A solid particle in a step: checks, sums, energies.
    SolidParticle,
    /// A solid particle that can meet the fluid, in a half-step.
    InterfaceParticle,
    /// A step, whatever its particles: frames and reports.
    Step,
}

impl Unit {
    /// All units, in the order of [`Work`].
    pub const ALL: [Self; 15] = [
        Self::GradientPair,
        Self::MomentPair,
        Self::RegularisationPair,
        Self::ForcePair,
        Self::FieldPair,
        Self::TensorPair,
        Self::FluidParticle,
        Self::WallParticle,
        Self::UpdatedPair,
        Self::ReferencePair,
        Self::NeoHookeanParticle,
        Self::ContactParticle,
        Self::SolidParticle,
        Self::InterfaceParticle,
        Self::Step,
    ];

    /// CPU time of one on the machine of docs/performance.md \[s\].
    fn cost(self) -> f64 {
        1e-9 * match self {
            Self::GradientPair => 2.0,
            Self::MomentPair => 1.0,
            Self::RegularisationPair => 1.0,
            Self::ForcePair => 3.0,
            Self::FieldPair => 1.0,
            Self::TensorPair => 1.0,
            Self::FluidParticle => 50.0,
            Self::WallParticle => 30.0,
            Self::UpdatedPair => 5.0,
            Self::ReferencePair => 5.0,
            Self::NeoHookeanParticle => 50.0,
            Self::ContactParticle => 100.0,
            Self::SolidParticle => 300.0,
            Self::InterfaceParticle => 200.0,
            Self::Step => 50000.0,
        }
    }
}

/// Amounts of work in a step, in the order of [`Unit::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work([f64; Unit::ALL.len()]);

impl Work {
    fn add(&mut self, unit: Unit, amount: f64) {
        self.0[unit as usize] += amount;
    }

    /// Amounts in the order of [`Unit::ALL`].
    pub fn amounts(&self) -> [f64; Unit::ALL.len()] {
        self.0
    }

    /// CPU time \[s\].
    pub fn seconds(&self) -> f64 {
        Unit::ALL.iter().zip(self.0).map(|(unit, amount)| unit.cost() * amount).sum()
    }
}

/// Particles within `reach` spacings of one on a square lattice.
fn neighbours(reach: f64) -> f64 {
    // At most some hundred: kernel ratios are bounded.
    let rows = reach.ceil() as i32;
    let squares = (-rows..=rows).flat_map(|y| (-rows..=rows).map(move |x| f64::from(x * x + y * y)));
    squares.filter(|square| square.sqrt() < reach).count() as f64 - 1.0
}

/// Work of a step of `time_step` \[s\].
pub fn work(fluid: Option<&FluidSetup>, solid: Option<&SolidSetup>, time_step: f64) -> Work {
    let mut work = Work::default();
    work.add(Unit::Step, 1.0);
    if let Some(setup) = fluid {
        fluid_work(&mut work, setup);
    }
    if let Some(setup) = solid {
        solid_work(&mut work, setup, time_step);
    }
    work
}

fn fluid_work(work: &mut Work, setup: &FluidSetup) {
    let parameters = &setup.parameters;
    let count = setup.particles.id.len() as f64;
    let pairs = count * neighbours(2.0 * parameters.kernel_ratio);
    // Leapfrog makes each pass in one of the two half-steps.
    let passes = match parameters.scheme {
        FluidScheme::Leapfrog => 1.0,
        FluidScheme::PredictorCorrector => 2.0,
    };
    let corrected =
        matches!(parameters.correction, GradientCorrection::Continuity | GradientCorrection::Renormalised);
    let viscous = parameters.dynamic_viscosity > 0.0;
    let density_gradient = parameters.density_diffusion == DensityDiffusion::Renormalised;
    let moments = corrected || viscous || density_gradient;
    let regularises = parameters.order_control().is_some();
    let fields = density_gradient || parameters.acoustic_damping > 0.0 || regularises;
    let tensors = viscous || parameters.correction == GradientCorrection::Renormalised;
    let gradients = moments || fields || parameters.scheme == FluidScheme::Leapfrog;
    for (unit, present) in [
        (Unit::GradientPair, gradients),
        (Unit::MomentPair, moments),
        (Unit::RegularisationPair, regularises),
        (Unit::ForcePair, true),
        (Unit::FieldPair, fields),
        (Unit::TensorPair, tensors),
    ] {
        if present {
            work.add(unit, passes * pairs);
        }
    }
    work.add(Unit::FluidParticle, 2.0 * count);
    work.add(Unit::WallParticle, 2.0 * setup.wall_particles.wall.len() as f64);
}

fn solid_work(work: &mut Work, setup: &SolidSetup, time_step: f64) {
    let count = substeps(setup, time_step);
    // Half of the sub-steps in the predictor, all in the corrector.
    let evaluations = count.map_or(2.0, |count| 1.5 * count);
    let mut particles = vec![0.0; setup.bodies.len()];
    for body in &setup.particles.body {
        if let Some(count) = particles.get_mut(*body as usize) {
            *count += 1.0;
        }
    }
    let touches = setup.bodies.len() > 1 || !setup.wall_particles.wall.is_empty();
    for (body, count) in setup.bodies.iter().zip(particles) {
        match &body.formulation {
            Formulation::Rigid => {}
            Formulation::UpdatedLagrangian(constants) => {
                let pairs = count * neighbours(2.0 * constants.kernel_ratio);
                work.add(Unit::UpdatedPair, evaluations * pairs);
            }
            Formulation::TotalLagrangian(constants) => {
                let pairs = count * neighbours(2.0 * constants.kernel_ratio);
                work.add(Unit::ReferencePair, evaluations * pairs);
                if constants.law == HyperelasticLaw::NeoHookean {
                    work.add(Unit::NeoHookeanParticle, evaluations * count);
                }
            }
        }
        if touches {
            work.add(Unit::ContactParticle, evaluations * count);
        }
        work.add(Unit::SolidParticle, count);
        if setup.run.coupling.is_some() {
            work.add(Unit::InterfaceParticle, 2.0 * count);
        }
    }
}

/// Sub-steps of a step, as the solid chooses them at rest; `None` for the stage rule.
fn substeps(setup: &SolidSetup, time_step: f64) -> Option<f64> {
    let count = match setup.stepping {
        SolidStepping::StageRule => return None,
        SolidStepping::Substeps(SubstepCount::Fixed(count)) => return Some(f64::from(count)),
        SolidStepping::Substeps(SubstepCount::Automatic) => setup.bodies.iter().filter_map(|body| {
            let speed = body.material.longitudinal_speed();
            match &body.formulation {
                Formulation::Rigid => None,
                Formulation::UpdatedLagrangian(constants) => Some(updated_lagrangian_substep(
                    constants.smoothing_length(setup.particle_spacing),
                    speed,
                    constants.viscosity_a,
                )),
                Formulation::TotalLagrangian(constants) => Some(total_lagrangian_substep(
                    2.0 * speed / setup.particle_spacing,
                    constants.viscosity_a,
                )),
            }
        }),
    };
    let limit = count.fold(f64::INFINITY, f64::min);
    Some(f64::from(automatic_substeps(time_step, limit)))
}
