//! Disposable buffers of a stage.

use sph::coupling::ledger::{EnergyValues, InterfaceSums};

use crate::boundary::walls::WallState;
use crate::contact::film::Film;
use crate::contact::friction::TangentialSprings;
use crate::contact::repulsion::Contacts;
use crate::formulations::formulation::AngularImpulse;
use crate::formulations::pair_law::PairSums;
use crate::interface::solid_interface::SolidInterface;
use crate::neighbours::lists::{ContactLists, OwnLists};
use crate::particles::fields::{Rates, StressFields};
use crate::particles::forces::{ContactForces, ParticleForces, ParticleTorques};
use crate::particles::variables::{Particles, RigidState};
use crate::space::SolidSpace;

/// Disposable buffers, reused from stage to stage.
#[derive(Debug)]
pub struct Workspace<S: SolidSpace> {
    /// State at which the stage evaluates.
    pub stage: Particles<S>,
    pub stage_rigid: Vec<RigidState<S>>,
    /// State that the stage makes.
    pub next: Particles<S>,
    pub next_rigid: Vec<RigidState<S>>,
    pub stress: StressFields<S>,
    /// Own-body sums, then all that belong in the rates.
    pub sums: Vec<PairSums<S>>,
    pub rates: Rates<S>,
    pub contact_forces: Vec<ContactForces<S>>,
    /// Contacts at the latest evaluation.
    pub contacts: Contacts<S>,
    /// Pressure of the water in gaps; `None` without a fluid or where contact is dry.
    pub film: Option<Film<S>>,
    /// Tangential springs at the latest evaluation, and those at the start of the step.
    pub springs: TangentialSprings<S>,
    pub start_springs: TangentialSprings<S>,
    /// Prescribed loads on each particle; empty where no body has any \[N/m\].
    pub loads: Vec<S::Vector>,
    /// Forces of the latest evaluation.
    pub forces: Vec<ParticleForces<S>>,
    /// Forces at the start of the step, from which each pass of sub-steps starts.
    pub start_forces: Vec<ParticleForces<S>>,
    /// Forces that moved the stage, means over its sub-steps.
    pub mean_forces: Vec<ParticleForces<S>>,
    /// Torques of these, at the places where they acted.
    pub mean_torques: Vec<ParticleTorques<S>>,
    /// Change of the angular momentum by supports and scheme in the stage.
    pub angular_impulse: AngularImpulse<S>,
    /// Positions at which the forces of the fluid were exchanged; with sub-steps only \[m\].
    pub exchange_position: Vec<S::Vector>,
    /// Velocities at the start of the change that the energy budget follows \[m/s\].
    pub kicked_from: Vec<S::Vector>,
    /// Works and losses of the stage \[J/m\].
    pub energy: EnergyValues,
    /// Force of the fluid on each particle in this stage \[N/m\].
    pub fluid_force: Vec<S::Vector>,
    /// Sum of all forces on each particle \[N/m\].
    pub total_force: Vec<S::Vector>,
    /// Velocity gained in the first half of a sub-step \[m/s\].
    pub velocity_gain: Vec<S::Vector>,
    /// Lists of each body; empty for formulations that need none.
    pub own_lists: Vec<Option<OwnLists<S>>>,
    pub contact_lists: ContactLists<S>,
    pub walls: WallState<S>,
    /// Pressure of wall particles toward solids \[Pa\].
    pub wall_pressure: Vec<f64>,
    /// Reactions of the stage, by body and support \[N/m\].
    pub reactions: Vec<Vec<S::Vector>>,
    /// Interface with the fluid; `None` when the run has one participant.
    pub fluid: Option<SolidInterface<S>>,
    /// Sums over pair forces with the fluid in this stage.
    pub interface_sums: InterfaceSums,
    pub list_builds: u64,
    /// Sub-steps of the stage; none under the stage rule.
    pub substeps: u32,
}
