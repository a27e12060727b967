//! The fluid's side of the interface with a solid partner.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::ledger::InterfaceSums;
use sph::interface::Interface;
use sph::interface::states::InterfaceStates;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{Coupling, FluidProbeKind, InterfaceLaw};
use sph::space::domain::Domain;
use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;
use sph::sums::ordered_sum;
use sph::tasks::for_each;

use super::selection::InterfaceSelection;
use crate::equations::anti_pairing::Ratio;
use crate::equations::continuity::density_rate;
use crate::equations::diffusion::{bracketed, plain};
use crate::equations::neighbour_sums::NeighbourSums;
use crate::equations::voids::{Void, lossy};
use crate::neighbours::scene::Scene;
use crate::rates::gradient_pass::PartnerDensity;
use crate::rates::gradients::Gradients;
use crate::rates::particle_rates::{Rates, StagePart};
use crate::system::model::{FluidModel, Probe};
use crate::system::packed_particle::{FluidSpace, NeighbourFields};
use crate::system::state::FluidState;
use crate::team::Team;

/// Interface particles per task.
const TASK: usize = 32;

/// Interface data of a fluid with a solid partner.
#[derive(Debug)]
pub struct FluidInterface<S: FluidSpace> {
    coupling: Coupling,
    domain: Domain<S>,
    interface: Interface<S>,
    /// Own interface states of the stage, and the partner's.
    states: [InterfaceStates<S>; 2],
    selection: InterfaceSelection<S>,
    /// Largest number of interface particles sent in a stage.
    largest: u64,
    sums: InterfaceSums,
    /// Interface states in contact with particles of the partner.
    states_in_contact: Vec<u32>,
    /// The fluid particles behind them.
    particles_in_contact: Vec<u32>,
    /// Sums of these over the partner's particles.
    neighbour_sums: Vec<NeighbourSums<S>>,
    /// Density rates by the solid: all, and by continuity alone \[kg/(m³ s)\].
    density_rates: Vec<[f64; 2]>,
    immersed: u32,
    /// Acceleration of each fluid particle by solids \[m/s²\].
    accelerations: Vec<S::Vector>,
    /// Power with which the approach of solids compresses the fluid \[W/m\].
    compression_power: f64,
}

impl<S: FluidSpace> FluidInterface<S> {
    /// A side of `coupling` without particles.
    pub fn new(coupling: &Coupling, domain: &Domain<S>, body_force: &BodyForceField<S>) -> Self {
        let support = 2.0 * coupling.fluid.smoothing_length();
        Self {
            coupling: *coupling,
            domain: *domain,
            interface: Interface::new(coupling, domain, body_force.clone()),
            states: Default::default(),
            selection: InterfaceSelection::new(domain, support, coupling.fluid.particle_spacing),
            largest: 0,
            sums: InterfaceSums::default(),
            states_in_contact: Vec::new(),
            particles_in_contact: Vec::new(),
            neighbour_sums: Vec::new(),
            density_rates: Vec::new(),
            immersed: 0,
            accelerations: Vec::new(),
            compression_power: 0.0,
        }
    }

    /// Describes where the fluid can be until the next list build.
    pub fn update_extent(&mut self, team: &Team, state: &FluidState<S>) {
        self.selection.update_extent(team, &state.position);
    }

    /// Figures of reports that a checkpoint keeps; see [`FluidInterface::restore`].
    pub fn history(&self) -> [u64; 2] {
        [self.largest, u64::from(self.immersed)]
    }

    /// Continues from a restored `state` and the `history` by [`FluidInterface::history`].
    ///
    /// The extent is that of the last list build.
    pub fn restore(&mut self, team: &Team, state: &FluidState<S>, history: [u64; 2]) {
        let position = state.list_origin.as_ref().map_or(&state.position, |origin| &origin.position);
        self.selection.update_extent(team, position);
        self.largest = history[0];
        self.immersed = u32::try_from(history[1]).unwrap_or(u32::MAX);
    }

    /// Where the fluid is.
    pub fn extent(&self) -> &Extent {
        self.selection.extent()
    }

    /// Largest number of interface particles sent in a stage.
    pub fn largest(&self) -> u64 {
        self.largest
    }

    /// Number of fluid particles inside solids as of the last evaluation; counted where a probe asks for it.
    pub fn immersed(&self) -> u32 {
        self.immersed
    }

    /// Counts the fluid particles inside solids, where a probe asks for it.
    fn count_immersed(&mut self, model: &FluidModel<S>) {
        if !model.probes.iter().any(|probe| matches!(probe, Probe::Plain(FluidProbeKind::Immersed))) {
            return;
        }
        let [own, partner] = &self.states;
        let share = |f: usize| -> f64 {
            let weight = |(s, _): (usize, _)| {
                let distance = self.domain.separation(&own.position[f], &partner.position[s]).norm();
                partner.volume(s) * model.kernel.value(distance)
            };
            self.interface.solids_near(f).map(weight).sum()
        };
        self.immersed = (0..own.len()).map(|f| u32::from(share(f) > S::IMMERSED_SHARE)).sum();
    }

    /// The partner's particles in this stage.
    pub fn partner(&self) -> &InterfaceStates<S> {
        &self.states[1]
    }

    /// Whether particle `s` of the partner stands between disconnected regions of the fluid.
    pub fn separates(&self, s: usize) -> bool {
        self.interface.separates(s)
    }

    /// Interface sums of the last evaluation.
    pub fn sums(&self) -> InterfaceSums {
        self.sums
    }

    /// See [`sph::coupling::solver::Solver::covered_by`].
    ///
    /// # Errors
    /// The shortfall \[m\].
    pub fn covered_by(
        &self,
        team: &Team,
        state: &FluidState<S>,
        extent: &Extent,
        reach: f64,
    ) -> Result<(), f64> {
        let support = 2.0 * self.coupling.fluid.smoothing_length();
        self.selection.covered_by(team, state, support, extent, reach)
    }

    /// Fills `columns` with the particles of all parts within `reach` \[m\] of `partner`, ids ascending; returns the set's
    /// version. `fluid` are the own particles.
    pub fn select(
        &mut self,
        team: &Team,
        state: &FluidState<S>,
        fluid: &[S::Particle],
        partner: &Extent,
        reach: f64,
        columns: &mut StateColumns,
    ) -> u64 {
        let [own, _] = &mut self.states;
        let version = self.selection.select(team, state, fluid, partner, reach, own);
        self.largest = self.largest.max(own.len() as u64);
        own.write(columns);
        version
    }

    /// Force on each of the partner's coupling `points` \[N\] at `time` \[s\], written to `forces`.
    pub fn reactions(&mut self, time: f64, own: &StateColumns, points: &StateColumns, forces: &mut Column) {
        let Self { interface, states: [fluid, solid], .. } = self;
        fluid.read(own);
        solid.read(points);
        interface.update(time, fluid, solid);
        interface.solid_forces(fluid, solid);
        forces.fill((0..solid.len()).map(|s| interface.force(s)));
    }

    /// Takes over the states of both sides; updates cross-owner lists, dummy states and pair forces of this stage.
    pub fn update(&mut self, time: f64, own: &StateColumns, partner: &StateColumns) {
        let Self { interface, states: [fluid, solid], sums, .. } = self;
        fluid.read(own);
        solid.read(partner);
        interface.update(time, fluid, solid);
        *sums = interface.fluid_forces(fluid, solid);
    }

    /// Acceleration of each own particle by solids in this stage \[m/s²\].
    pub fn accelerations(&mut self, state: &FluidState<S>) -> &[S::Vector] {
        let Self { interface, selection, accelerations, .. } = self;
        accelerations.clear();
        accelerations.resize(state.len(), S::Vector::zeros());
        for (k, i) in selection.members() {
            accelerations[i] = interface.force(k) / state.mass[i];
        }
        accelerations
    }

    /// Power of the solids' forces on the fluid \[W/m\] at the mean velocities of a step, v + ½Δt a with v the
    /// `start_velocity` \[m/s\] and ½Δt = `half` \[s\], once `rates` are complete; and the power with which their
    /// approach compresses it.
    pub fn powers(
        &self,
        team: &Team,
        start_velocity: &[S::Vector],
        half: f64,
        rates: &[Rates<S>],
    ) -> [f64; 2] {
        let power = self.sum_over_states(team, |k, i| {
            self.interface.force(k).dot(&(start_velocity[i] + rates[i].acceleration * half))
        });
        [power, self.compression_power]
    }

    /// Sum of a `term` of each interface state and the particle behind it.
    fn sum_over_states(&self, team: &Team, term: impl Fn(usize, usize) -> f64 + Sync) -> f64 {
        let [states, _] = &self.states;
        let own = |k: usize| self.selection.member(k).map(|i| term(k, i));
        if team.is_alone() {
            return ordered_sum(states.len(), |k| own(k).unwrap_or_default());
        }
        let all = team.complete((0..states.len()).map(own).collect());
        ordered_sum(all.len(), |k| all[k])
    }

    /// Meaning of the solid's density in the fluid's density gradient and diffusion.
    fn partner_density(&self) -> PartnerDensity {
        match self.coupling.law {
            InterfaceLaw::PlainSum => PartnerDensity::OtherMaterial,
            InterfaceLaw::Wall | InterfaceLaw::WallNoSlip => PartnerDensity::FluidEquivalent,
        }
    }

    /// Adds the solid's particles to the sums of the gradient pass, once for each fluid particle, so that a solid's
    /// face is not detected as free surface.
    pub fn add_neighbour_sums<G: Geometry<S>>(
        &mut self,
        scene: &Scene<G, S>,
        gradients: &mut Gradients<S>,
        rates: &mut [Rates<S>],
    ) {
        let model = scene.model;
        if !model.needs_gradient_pass() {
            return;
        }
        let partner_density = self.partner_density();
        let ratio = Ratio::new(model);
        let Self { interface, domain, states: [own, partner], neighbour_sums, selection, .. } = self;
        let (states, particles) = (&mut self.states_in_contact, &mut self.particles_in_contact);
        states.clear();
        particles.clear();
        for (k, i) in selection.members().filter(|(k, _)| interface.meets(*k)) {
            // Indices of particles are of 32 bits.
            states.push(k as u32);
            particles.push(i as u32);
        }
        neighbour_sums.resize(states.len(), NeighbourSums::default());
        for_each(&mut neighbour_sums[..], TASK, |k, sums| {
            let k = states[k] as usize;
            *sums = NeighbourSums::default();
            for (s, dummy) in interface.solids_near(k) {
                let d = domain.separation(&own.position[k], &partner.position[s]);
                let r = d.norm();
                let v_sf = dummy.velocity - own.velocity[k];
                let density = match partner_density {
                    PartnerDensity::FluidEquivalent => dummy.density - own.density[k],
                    PartnerDensity::OtherMaterial => 0.0,
                };
                let volume = dummy.mass / dummy.density;
                let gradient_factor = model.gradient_scale * model.kernel.gradient_factor(r);
                let r_over_h = r / model.constants.smoothing_length();
                let pairing = ratio.pairing(S::PAIRING, r_over_h);
                sums.add_pair(&d, volume * gradient_factor, density, &v_sf, pairing);
            }
        });
        gradients.merge(scene, particles, neighbour_sums, partner_density, rates);
    }

    /// Adds the solid's part to the rates, once for each fluid particle: continuity, diffusion and force, as far as
    /// `part` has them; that of continuity also to its own rates, where a stage computes all rates.
    ///
    /// ```text
    /// ρ_f Σ V_s v_fs·∇W  +  δ h c₀ Σ V_s [2 (ρ_f − ρ_s) x²/(x² + λh²) − 2 ∇ρ_f·x_fs] (dW/dr)/r
    /// ```
    /// The second sum is left out in the plain sum, where ρ_s is that of another material.
    pub fn add_rates<G: Geometry<S>>(
        &mut self,
        scene: &Scene<G, S>,
        state: &FluidState<S>,
        part: StagePart,
        gradients: &Gradients<S>,
        (rates, by_continuity): (&mut [Rates<S>], &mut [f64]),
    ) {
        let model = scene.model;
        self.count_immersed(model);
        let diffusion =
            if self.partner_density() == PartnerDensity::FluidEquivalent && part != StagePart::Density {
                model.diffusion
            } else {
                0.0
            };
        let flux = if part == StagePart::Momentum { 0.0 } else { 1.0 };
        let Self { interface, domain, states: [own, partner], selection, density_rates, .. } = self;
        density_rates.resize(own.len(), [0.0; 2]);
        for_each(&mut density_rates[..], TASK, |k, rate| {
            let Some(i) = selection.member(k) else { return };
            let rho = own.density[k];
            let gradient = if model.needs_density_gradient() {
                gradients.neighbour_fields[i].density_gradient()
            } else {
                S::splat(0.0)
            };
            let sums = gradients.regularisation.get(i);
            let void = sums.and_then(|sums| Void::shown_by(model, &sums.concentration));
            let (mut continuity, mut near, mut exchange) = (0.0, 0.0, 0.0);
            for (s, dummy) in interface.solids_near(k) {
                let d = domain.separation(&own.position[k], &partner.position[s]);
                let square = d.norm_squared();
                let gradient_factor =
                    model.cross_gradient_scale * model.kernel.gradient_factor(square.sqrt());
                let weight = dummy.mass / dummy.density * gradient_factor;
                let divergence = weight * (own.velocity[k] - dummy.velocity).dot(&d);
                continuity += divergence;
                if let Some(void) = &void {
                    near += void.of_solid(&d, divergence);
                }
                let share = square / model.law.viscosity.softened(square);
                let psi = plain(2.0 * rho, dummy.density, share);
                exchange += weight * bracketed::<S, f64>(psi, S::scaled(gradient, 2.0), S::components(&d));
            }
            let mut flow = density_rate(rho, -continuity);
            if void.is_some() {
                flow += lossy(density_rate(rho, -near) - flow, own.pressure[k]);
            }
            let flow = flux * flow;
            *rate = [flow + diffusion * exchange, flow];
        });
        if part != StagePart::Momentum {
            let [own, _] = &self.states;
            // V p/ρ dρ/dt
            self.compression_power = self.sum_over_states(&model.team, |k, _| {
                let rho = own.density[k];
                own.mass[k] * own.pressure[k] * self.density_rates[k][1] / (rho * rho)
            });
        }
        for (k, i) in self.selection.members() {
            let [density, continuity] = self.density_rates[k];
            rates[i].density += density;
            if let Some(own) = by_continuity.get_mut(i) {
                *own += continuity;
            }
            if part != StagePart::Density {
                rates[i].acceleration += self.interface.force(k) / state.mass[i];
            }
        }
    }
}
