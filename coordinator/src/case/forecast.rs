//! Forecast of the CPU time of a step: the work of both solvers, counted in what their time goes into, and the cost of
//! each unit of it.

use solid::limits::{automatic_substeps, estimated_substep};
use solid::space::SolidSpace;
use sph::in_space;
use sph::neighbours::CellGrid;
use sph::setup::{
    AnyFluidSetup, AnySolidSetup, ContactLaw, FluidScheme, FluidSetup, Formulation, GradientCorrection,
    SolidSetup, SolidStepping, SubstepCount,
};
use sph::space::Space;

/// Distance beyond that of contact within which particles of two owners count as a pair of a contact, in spacings.
const CONTACT_MARGIN: f64 = 0.5;

/// Most particles of bodies and walls among which pairs are searched.
const MOST_SEARCHED: usize = 100_000;

/// What the time of a step goes into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A pair of fluid particles in both passes: gradients and forces.
    FluidPair,
    /// The same, in addition where the momentum equation takes tensors.
    TensorPair,
    /// A wall particle in a half-step.
    WallParticle,
    /// A pair of an updated-Lagrangian body in an evaluation of its forces.
    UpdatedPair,
    /// A pair of a total-Lagrangian body in an evaluation of its forces.
    ReferencePair,
    /// A particle of a body that can touch a wall or another body, in an evaluation of forces.
    ContactParticle,
    /// A pair of particles of two bodies, or of a body and a wall, that meet at the start, in an evaluation of forces.
    ContactPair,
    /// A solid particle in a step: checks, sums, energies.
    SolidParticle,
    /// A step, whatever its particles: frames and reports.
    Step,
}

impl Unit {
    /// All units, in the order of [`Work`].
    pub const ALL: [Self; 9] = [
        Self::FluidPair,
        Self::TensorPair,
        Self::WallParticle,
        Self::UpdatedPair,
        Self::ReferencePair,
        Self::ContactParticle,
        Self::ContactPair,
        Self::SolidParticle,
        Self::Step,
    ];

    /// CPU time of one \[s\], fitted to the shipped cases by the program `forecast --work`, on a machine on which a stage of a particle
    /// of the benchmark in the plane takes 270 to 360 ns (docs/performance.md).
    fn cost(self) -> f64 {
        1e-9 * match self {
            Self::FluidPair => 17.0,
            Self::TensorPair => 13.0,
            Self::WallParticle => 88.0,
            Self::UpdatedPair => 6.1,
            Self::ReferencePair => 20.0,
            Self::ContactParticle => 150.0,
            Self::ContactPair => 1500.0,
            Self::SolidParticle => 570.0,
            Self::Step => 76000.0,
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

/// Particles within `reach` spacings of one on a square (cubic) lattice.
fn neighbours<S: Space>(reach: f64) -> f64 {
    // At most some thousand: kernel ratios are bounded.
    let rows = reach.ceil() as i32;
    let squares = || (-rows..=rows).map(|k| f64::from(k * k));
    let within = |square: f64| square.sqrt() < reach;
    let plane = || squares().flat_map(|y| squares().map(move |x| x + y));
    let count = match S::DIMENSIONS {
        2 => plane().filter(|square| within(*square)).count(),
        _ => squares().map(|z| plane().filter(|square| within(square + z)).count()).sum(),
    };
    count as f64 - 1.0
}

/// Work of a step of `time_step` \[s\].
pub fn work(fluid: Option<&AnyFluidSetup>, solid: Option<&AnySolidSetup>, time_step: f64) -> Work {
    let mut work = Work::default();
    work.add(Unit::Step, 1.0);
    if let Some(setup) = fluid {
        in_space!(setup, setup => fluid_work(&mut work, setup));
    }
    if let Some(setup) = solid {
        in_space!(setup, setup => solid_work(&mut work, setup, time_step));
    }
    work
}

fn fluid_work<S: Space>(work: &mut Work, setup: &FluidSetup<S>) {
    let parameters = &setup.parameters;
    let count = setup.particles.id.len() as f64;
    // In space a pair has three components for two.
    let components = S::DIMENSIONS as f64 / 2.0;
    let pairs = components * count * neighbours::<S>(2.0 * parameters.kernel_ratio);
    // Leapfrog makes each pass in one of the two half-steps.
    let passes = match parameters.scheme {
        FluidScheme::Leapfrog => 1.0,
        FluidScheme::PredictorCorrector => 2.0,
    };
    work.add(Unit::FluidPair, passes * pairs);
    if parameters.dynamic_viscosity > 0.0 || parameters.correction == GradientCorrection::Renormalised {
        work.add(Unit::TensorPair, passes * pairs);
    }
    work.add(Unit::WallParticle, 2.0 * setup.wall_particles.wall.len() as f64);
}

fn solid_work<S: SolidSpace>(work: &mut Work, setup: &SolidSetup<S>, time_step: f64) {
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
    // In space a pair has tensors of nine components for four.
    let components = (S::DIMENSIONS as f64 / 2.0).powi(2);
    for (body, count) in setup.bodies.iter().zip(particles) {
        match &body.formulation {
            Formulation::Rigid => {}
            Formulation::UpdatedLagrangian(constants) => {
                let pairs = components * count * neighbours::<S>(2.0 * constants.kernel_ratio);
                work.add(Unit::UpdatedPair, evaluations * pairs);
            }
            Formulation::TotalLagrangian(constants) => {
                let pairs = components * count * neighbours::<S>(2.0 * constants.kernel_ratio);
                work.add(Unit::ReferencePair, evaluations * pairs);
            }
        }
        if touches {
            work.add(Unit::ContactParticle, evaluations * count);
        }
        work.add(Unit::SolidParticle, count);
    }
    if let (true, ContactLaw::Repulsion(contact)) = (touches, &setup.contact) {
        let reach = (contact.distance + CONTACT_MARGIN) * setup.particle_spacing;
        work.add(Unit::ContactPair, evaluations * contact_pairs(setup, reach));
    }
}

/// Pairs of particles of two bodies, or of a body that no support holds and a wall, within `reach` \[m\]; none in large
/// scenes, where their count would take long and means little.
fn contact_pairs<S: Space>(setup: &SolidSetup<S>, reach: f64) -> f64 {
    let (particles, walls) = (&setup.particles, &setup.wall_particles.position);
    if particles.position.len() + walls.len() > MOST_SEARCHED {
        return 0.0;
    }
    let domain = &setup.run.domain;
    let grid = CellGrid::new(domain, &particles.position, reach);
    let near = grid.list_among(domain, &particles.position, reach);
    let body = |i: usize| particles.body[i];
    let others = |i: usize| near.of(i).iter().filter(|j| body(**j as usize) != body(i)).count();
    let between: usize = (0..particles.position.len()).map(others).sum();
    let near = grid.list(domain, walls, &particles.position, reach);
    let is_free =
        |j: &u32| setup.bodies.get(body(*j as usize) as usize).is_some_and(|body| body.supports.is_empty());
    let toward_walls: usize =
        (0..walls.len()).map(|w| near.of(w).iter().filter(|j| is_free(j)).count()).sum();
    (between + toward_walls) as f64
}

/// Sub-steps of a step, as the solid chooses them at rest; `None` for the stage rule.
fn substeps<S: SolidSpace>(setup: &SolidSetup<S>, time_step: f64) -> Option<f64> {
    let limits = match setup.stepping {
        SolidStepping::StageRule => return None,
        SolidStepping::Substeps(SubstepCount::Fixed(count)) => return Some(f64::from(count)),
        SolidStepping::Substeps(SubstepCount::Automatic) => setup.bodies.iter().filter_map(|body| {
            estimated_substep::<S>(&body.formulation, &body.material, setup.particle_spacing)
        }),
    };
    let limit = limits.fold(f64::INFINITY, f64::min);
    Some(f64::from(automatic_substeps(time_step, limit)))
}

#[cfg(test)]
mod tests {
    use sph::space::{Plane, Spatial};

    use super::*;

    #[test]
    fn neighbours_are_those_of_the_square_lattice() {
        // 8 of a total-Lagrangian stencil, 20 of the kernel ratios 1.2 and 1.3.
        assert_eq!([1.5, 2.4, 2.6].map(neighbours::<Plane>), [8.0, 20.0, 20.0]);
        // 6 + 12 beside it and on edges of a total-Lagrangian stencil; those of a cube within 2.6 spacings.
        assert_eq!([1.5, 2.6].map(neighbours::<Spatial>), [18.0, 80.0]);
    }
}
