//! The interface between fluid and solid: cross lists, dummy states and pair forces, by the same code on both sides.
//!
//! Both solvers hold the same two sets of states, one own and one received, and evaluate the same pair function with
//! the fluid particle first; the solid negates. That makes action equal reaction bit for bit.

pub(crate) mod fluid_regions;
mod lists;
pub(crate) mod pair_law;
pub mod states;
pub(crate) mod velocity_gradients;

use crate::coupling::ledger::{InterfaceSums, LedgerVector, axial, lifted};
use crate::prescribed::body_force::BodyForceField;
use crate::setup::{Coupling, InterfaceLaw};
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};
use crate::sums::ordered_sum;
use crate::tasks::for_each;

pub use fluid_regions::Dummy;
use fluid_regions::FluidRegions;
use lists::{Rows, Search};
use pair_law::PairLaw;
use states::InterfaceStates;
use velocity_gradients::VelocityGradients;

/// Cross lists, dummy states and forces of one half-step; all buffers are reused.
#[derive(Debug)]
pub struct Interface<S: Space = Plane> {
    law: PairLaw<S>,
    domain: Domain<S>,
    body_force: BodyForceField<S>,
    search: Search<S>,
    of_fluid: Rows,
    of_solid: Rows,
    regions: FluidRegions<S>,
    gradients: VelocityGradients<S>,
    sums: Vec<ParticleSums<S>>,
    /// Repulsion of each fluid state by faces; see [`PairLaw::barrier`].
    barriers: Vec<f64>,
}

/// What one particle receives across the interface.
#[derive(Clone, Copy, Debug, Default)]
struct ParticleSums<S: Space> {
    force: S::Vector,
    gross_force: f64,
    couple: S::Spin,
    pairs: u64,
}

impl<S: Space> Interface<S> {
    /// An interface with the laws and constants of `coupling`.
    pub fn new(coupling: &Coupling, domain: &Domain<S>, body_force: BodyForceField<S>) -> Self {
        Self {
            law: PairLaw::new(coupling),
            domain: *domain,
            body_force,
            search: Search::default(),
            of_fluid: Rows::default(),
            of_solid: Rows::default(),
            regions: FluidRegions::default(),
            gradients: VelocityGradients::default(),
            sums: Vec::new(),
            barriers: Vec::new(),
        }
    }

    /// Builds the cross lists and the dummy states for states at `time` \[s\].
    ///
    /// The lists hold exactly the pairs within the support radius, in id order, whatever else was sent.
    pub fn update(&mut self, time: f64, fluid: &InterfaceStates<S>, solid: &InterfaceStates<S>) {
        let Self { law, domain, body_force, search, of_fluid, of_solid, regions, gradients, .. } = self;
        let support = law.support_radius();
        search.fill(domain, support, [fluid, solid], |_| true, of_fluid);
        of_solid.transpose(of_fluid, solid.len());
        match law.kind() {
            InterfaceLaw::PlainSum => regions.update_whole(of_solid, |s| Dummy {
                pressure: solid.pressure[s],
                density: solid.density[s],
                mass: solid.mass[s],
                velocity: solid.velocity[s],
            }),
            InterfaceLaw::Wall | InterfaceLaw::WallNoSlip => {
                if law.kind() == InterfaceLaw::WallNoSlip {
                    gradients.update(law, domain, solid, of_solid);
                }
                regions.update_disconnected(domain, support, [fluid, solid], of_solid, |s, row, region| {
                    let acceleration = body_force.acceleration(&solid.position[s], time);
                    let region = row.iter().filter(|pair| pair.region == region);
                    let region = region.map(|pair| pair.other as usize);
                    law.wall_dummy(domain, &acceleration, [fluid, solid], s, region, gradients.at(s))
                });
            }
        }
        of_fluid.take_regions(of_solid);
        self.barriers.clear();
        self.barriers.resize(fluid.len(), 0.0);
        let (law, domain, of_fluid) = (&self.law, &self.domain, &self.of_fluid);
        for_each(&mut self.barriers[..], lists::TASK, |f, barrier| {
            *barrier = law.barrier(domain, [fluid, solid], f, of_fluid.of(f));
        });
    }

    /// Whether any state of the solid is within support of fluid state `f`.
    pub fn meets(&self, f: usize) -> bool {
        !self.of_fluid.of(f).is_empty()
    }

    /// The solid's states within support of fluid state `f`, indices ascending, with what `f` feels of each.
    pub fn solids_near(&self, f: usize) -> impl Iterator<Item = (usize, &Dummy<S>)> {
        self.of_fluid.of(f).iter().map(|pair| (pair.other as usize, self.regions.dummy(pair)))
    }

    /// The fluid's states within support of solid state `s`, indices ascending, with what each feels of `s`.
    pub fn fluids_near(&self, s: usize) -> impl Iterator<Item = (usize, &Dummy<S>)> {
        self.of_solid.of(s).iter().map(|pair| (pair.other as usize, self.regions.dummy(pair)))
    }

    /// Whether solid state `s` stands between disconnected regions of the fluid.
    pub fn separates(&self, s: usize) -> bool {
        let row = self.of_solid.of(s);
        row.iter().any(|pair| pair.region != row[0].region)
    }

    /// Force on state `k` of the side summed last \[N\].
    pub fn force(&self, k: usize) -> S::Vector {
        self.sums[k].force
    }

    /// Forces on the fluid's states; read them by [`Interface::force`].
    pub fn fluid_forces(&mut self, fluid: &InterfaceStates<S>, solid: &InterfaceStates<S>) -> InterfaceSums {
        let (law, domain, rows, regions) = (&self.law, &self.domain, &self.of_fluid, &self.regions);
        let (gradients, barriers) = (&self.gradients, &self.barriers);
        self.sums.clear();
        self.sums.resize(fluid.len(), ParticleSums::default());
        for_each(&mut self.sums[..], lists::TASK, |f, sums| {
            for pair in rows.of(f) {
                let s = pair.other as usize;
                let x_fs = domain.separation(&fluid.position[f], &solid.position[s]);
                let shown = (regions.dummy(pair), gradients.at(s));
                let force = law.force_on_fluid(&x_fs, [fluid, solid], [f, s], shown, barriers[f]);
                sums.add(&x_fs, force);
            }
        });
        self.total(fluid)
    }

    /// Forces on the solid's states; read them by [`Interface::force`].
    pub fn solid_forces(&mut self, fluid: &InterfaceStates<S>, solid: &InterfaceStates<S>) -> InterfaceSums {
        let (law, domain, rows, regions) = (&self.law, &self.domain, &self.of_solid, &self.regions);
        let (gradients, barriers) = (&self.gradients, &self.barriers);
        self.sums.clear();
        self.sums.resize(solid.len(), ParticleSums::default());
        for_each(&mut self.sums[..], lists::TASK, |s, sums| {
            for pair in rows.of(s) {
                let f = pair.other as usize;
                let x_fs = domain.separation(&fluid.position[f], &solid.position[s]);
                let shown = (regions.dummy(pair), gradients.at(s));
                let force = law.force_on_fluid(&x_fs, [fluid, solid], [f, s], shown, barriers[f]);
                sums.add(&-x_fs, -force);
            }
        });
        self.total(solid)
    }

    fn total(&self, states: &InterfaceStates<S>) -> InterfaceSums {
        let origin = self.domain.torque_origin();
        ordered_sum(states.len(), |k| {
            let sums = &self.sums[k];
            let arm = states.position[k] - origin;
            InterfaceSums {
                force: lifted(&sums.force),
                gross_force: sums.gross_force,
                torque: axial(S::cross(&arm, &sums.force)),
                gross_torque: arm.norm() * sums.gross_force,
                couple: axial(sums.couple),
                power: sums.force.dot(&states.velocity[k]),
                pairs: sums.pairs,
            }
        })
    }
}

/// Sums of the `forces` \[N\] that act on the coupling `points`: what a solid with force coupling reports.
pub fn load_sums<S: Space>(
    domain: &Domain<S>,
    points: &InterfaceStates<S>,
    forces: &[S::Vector],
) -> InterfaceSums {
    let origin = domain.torque_origin();
    ordered_sum(forces.len(), |s| {
        let (force, arm) = (forces[s], points.position[s] - origin);
        InterfaceSums {
            force: lifted(&force),
            gross_force: force.norm(),
            torque: axial(S::cross(&arm, &force)),
            gross_torque: arm.norm() * force.norm(),
            // Only the fluid knows where its particles are.
            couple: LedgerVector::zeros(),
            power: force.dot(&points.velocity[s]),
            pairs: u64::from(force != S::Vector::zeros()),
        }
    })
}

impl<S: Space> ParticleSums<S> {
    fn add(&mut self, separation: &S::Vector, force: S::Vector) {
        self.force += force;
        self.gross_force += force.norm();
        self.couple += S::cross(separation, &force) * 0.5;
        self.pairs += 1;
    }
}

#[cfg(test)]
mod tests;
