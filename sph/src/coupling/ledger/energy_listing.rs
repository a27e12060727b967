//! Which energy accounts a case can have: solvers report these, and outputs list no others.

use super::energy::EnergyAccount as A;
use crate::in_space;
use crate::setup::{ContactLaw, FluidScheme, FluidSetup, Formulation, ParticipantSetup, SolidSetup};
use crate::space::Space;
use crate::space::tensors::SpaceVector;

/// The part of `gravity` \[m/s²\] that has a potential in a domain with these `periodic` directions.
pub fn potential_gravity<S: Space>(gravity: S::Vector, periodic: impl Fn(usize) -> bool) -> S::Vector {
    let mut kept = gravity;
    for axis in (0..S::DIMENSIONS).filter(|axis| periodic(*axis)) {
        kept[axis] = 0.0;
    }
    kept
}

impl A {
    /// The accounts that the run of `setup` can have.
    pub fn of(setup: &ParticipantSetup) -> Vec<Self> {
        match setup {
            ParticipantSetup::Fluid(setup) => in_space!(setup, setup => Self::of_fluid(setup)),
            ParticipantSetup::Solid(setup) => in_space!(setup, setup => Self::of_solid(setup)),
        }
    }

    /// The accounts that a fluid can have.
    pub fn of_fluid<S: Space>(setup: &FluidSetup<S>) -> Vec<Self> {
        let FluidSetup { run, parameters: p, walls, outflow, .. } = setup;
        let gravity = run.body_force.gravity;
        let falling = potential_gravity::<S>(gravity, |axis| run.domain.periodic[axis]);
        let relaxes = p.acoustic_relaxation().is_some();
        let leaves = p.lost_particle_limit > 0 || outflow.is_open();
        Self::all()
            .filter(|account| match account {
                A::Kinetic | A::Compression | A::CorrectedGradients => true,
                A::Potential => falling != S::Vector::zeros(),
                A::Relaxation | A::AcousticRelaxation => relaxes,
                A::BodyForce => run.body_force.expressions.is_some() || falling != gravity,
                A::Walls => walls.iter().any(|wall| wall.motion.is_some()),
                A::Interface => run.coupling.is_some(),
                A::ArtificialViscosity => p.viscosity_a > 0.0 || p.viscosity_b > 0.0,
                A::Viscosity => p.dynamic_viscosity > 0.0,
                A::Damping => setup.damping.is_some(),
                A::AcousticDamper => p.acoustic_damping > 0.0,
                A::DensityDiffusion => p.diffusivity() > 0.0,
                A::VolumeCorrection => p.volume_correction > 0.0,
                A::Shifting => p.shifting > 0.0,
                A::TensileControl => p.tensile_control,
                A::ArtificialPressure => p.artificial_pressure > 0.0,
                A::TimeScheme => p.scheme == FluidScheme::PredictorCorrector && falling != S::Vector::zeros(),
                A::Repulsion => p.wall_repulsion > 0.0 && !walls.is_empty(),
                A::Removed => leaves,
                A::Strain | A::Supports | A::Loads | A::Film | A::Contact | A::Friction => false,
            })
            .collect()
    }

    /// The accounts that solids can have.
    pub fn of_solid<S: Space>(setup: &SolidSetup<S>) -> Vec<Self> {
        let SolidSetup { run, bodies, walls, .. } = setup;
        let deformable = |body: &&crate::setup::BodySetup<S>| !matches!(body.formulation, Formulation::Rigid);
        let updated = |formulation: &Formulation| matches!(formulation, Formulation::UpdatedLagrangian(_));
        let viscous = |formulation: &Formulation| match formulation {
            Formulation::UpdatedLagrangian(law) => law.viscosity_a > 0.0 || law.viscosity_b > 0.0,
            Formulation::TotalLagrangian(law) => law.viscosity_a > 0.0 || law.viscosity_b > 0.0,
            Formulation::Rigid => false,
        };
        let pulls = |formulation: &Formulation| match formulation {
            Formulation::UpdatedLagrangian(law) => law.artificial_stress > 0.0,
            _ => false,
        };
        let falls = run.body_force.gravity != S::Vector::zeros();
        let any = |is: &dyn Fn(&Formulation) -> bool| bodies.iter().any(|body| is(&body.formulation));
        let elastic = bodies.iter().any(|body| deformable(&body));
        let (friction, wet) = match &setup.contact {
            ContactLaw::Repulsion(law) => (law.friction, law.wet),
            ContactLaw::Sums => (0.0, false),
        };
        let touches = bodies.len() > 1 || !walls.is_empty() || elastic;
        Self::all()
            .filter(|account| match account {
                A::Kinetic => true,
                A::Potential => falls,
                A::Strain => elastic,
                A::BodyForce => run.body_force.expressions.is_some(),
                A::Walls => walls.iter().any(|wall| wall.motion.is_some()),
                A::Supports => bodies.iter().any(|body| !body.supports.is_empty()),
                A::Loads => bodies.iter().any(|body| body.acceleration.is_some() || !body.loads.is_empty()),
                A::Interface => run.coupling.is_some(),
                A::Film => touches && wet && run.coupling.is_some_and(|coupling| coupling.has_wall_states()),
                A::ArtificialViscosity => any(&viscous),
                A::Damping => setup.damping.is_some(),
                A::ArtificialPressure => any(&pulls),
                A::CorrectedGradients => any(&updated),
                A::TimeScheme => {
                    falls || any(&|formulation| matches!(formulation, Formulation::TotalLagrangian(_)))
                }
                A::Contact => touches,
                A::Friction => touches && friction > 0.0,
                A::Compression
                | A::Relaxation
                | A::Viscosity
                | A::AcousticDamper
                | A::AcousticRelaxation
                | A::DensityDiffusion
                | A::VolumeCorrection
                | A::Shifting
                | A::TensileControl
                | A::Repulsion
                | A::Removed => false,
            })
            .collect()
    }
}
