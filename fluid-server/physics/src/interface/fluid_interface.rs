//! The fluid's side of the interface: who is sent, and what the solid's particles add.

use rayon::prelude::*;
use sph::body_force::BodyForceField;
use sph::domain::Domain;
use sph::exchange::{Extent, InterfaceStates};
use sph::extent::{ExtentTracker, ReachMap};
use sph::geometry::Geometry;
use sph::interface::Interface;
use sph::ledger::InterfaceSums;
use sph::setup::{Coupling, FluidProbeKind, InterfaceLaw};
use sph::vector::Vector;

use crate::equations::anti_pairing::pairing_of;
use crate::equations::neighbour_sums::NeighbourSums;
use crate::neighbours::scene::Scene;
use crate::rates::gradients::Gradients;
use crate::rates::particle_rates::{Part, Rates};
use crate::system::list_limits::farthest;
use crate::system::model::FluidModel;
use crate::system::packed_particle::Record;
use crate::system::state::FluidState;

/// Edge of the boxes that describe the fluid's extent, in support radii.
const EXTENT_CELL: f64 = 4.0;

/// Interface particles per task.
const TASK: usize = 32;

/// What a fluid with a partner keeps besides its own fields.
#[derive(Debug)]
pub struct Cross {
    coupling: Coupling,
    domain: Domain,
    interface: Interface,
    tracker: ExtentTracker,
    reach: ReachMap,
    /// What may come within reach until the lists are built anew.
    vicinity: ReachMap,
    /// The fluid particles there, ids ascending, and whether they are found yet.
    candidates: (Vec<u32>, bool),
    /// Whether each fluid particle is there.
    inside: Vec<bool>,
    /// Index of the fluid particle behind each interface state.
    members: Vec<u32>,
    known_ids: Vec<u32>,
    set_version: u64,
    largest: u64,
    sums: InterfaceSums,
    /// Interface states that meet particles of the partner, and the fluid particles behind them.
    meeting: [Vec<u32>; 2],
    moments: Vec<NeighbourSums>,
    density_rates: Vec<f64>,
    immersed: u32,
}

impl Cross {
    /// A side of `coupling` without particles.
    pub fn new(coupling: &Coupling, domain: &Domain, body_force: &BodyForceField) -> Self {
        let support = 2.0 * coupling.fluid.smoothing_length;
        Self {
            coupling: *coupling,
            domain: *domain,
            interface: Interface::new(coupling, domain, body_force.clone()),
            tracker: ExtentTracker::new(domain, EXTENT_CELL * support),
            reach: ReachMap::new(domain, support),
            vicinity: ReachMap::new(domain, support),
            candidates: (Vec::new(), false),
            inside: Vec::new(),
            members: Vec::new(),
            known_ids: Vec::new(),
            set_version: 0,
            largest: 0,
            sums: InterfaceSums::default(),
            meeting: Default::default(),
            moments: Vec::new(),
            density_rates: Vec::new(),
            immersed: 0,
        }
    }

    /// Describes where the fluid is until the lists are built anew.
    pub fn update_extent(&mut self, state: &FluidState) {
        // Lists are built anew before a particle has moved farther.
        self.tracker.update(&state.position, self.farthest());
        self.candidates.1 = false;
    }

    /// Largest displacement \[m\] of a particle between list builds.
    fn farthest(&self) -> f64 {
        farthest(self.coupling.fluid.particle_spacing)
    }

    /// What reports need of the evaluations so far: see [`Cross::restore`].
    pub fn history(&self) -> [u64; 2] {
        [self.largest, u64::from(self.immersed)]
    }

    /// Goes on from a restored `state`; `history` is what [`Cross::history`] gave.
    ///
    /// The extent is that of the last list build, whence particles may have moved by the slack.
    pub fn restore(&mut self, state: &FluidState, history: [u64; 2]) {
        let position = state.list_origin.as_ref().map_or(&state.position, |origin| &origin.position);
        self.tracker.update(position, self.farthest());
        self.candidates.1 = false;
        self.largest = history[0];
        self.immersed = u32::try_from(history[1]).unwrap_or(u32::MAX);
    }

    /// Where the fluid is.
    pub fn extent(&self) -> &Extent {
        self.tracker.extent()
    }

    /// Largest number of interface particles sent in a stage.
    pub fn largest(&self) -> u64 {
        self.largest
    }

    /// Number of fluid particles inside solids as of the last evaluation; counted where a probe asks for it.
    pub fn immersed(&self) -> u32 {
        self.immersed
    }

    /// Counts the fluid particles with more solid than not around them: Σ V_s W > ½, which is where the face is.
    fn count_immersed(&mut self, model: &FluidModel, own: &InterfaceStates, partner: &InterfaceStates) {
        if !model.probes.iter().any(|probe| probe.kind == FluidProbeKind::Immersed) {
            return;
        }
        let share = |f: usize| -> f64 {
            let weight = |(s, _): (usize, _)| {
                let distance = self.domain.separation(&own.position[f], &partner.position[s]).norm();
                partner.volume(s) * model.kernel.value(distance)
            };
            self.interface.solids_near(f).map(weight).sum()
        };
        self.immersed = (0..own.len()).map(|f| u32::from(share(f) > 0.5)).sum();
    }

    /// Interface sums of the last evaluation.
    pub fn sums(&self) -> InterfaceSums {
        self.sums
    }

    /// See [`sph::solver::Solver::covered_by`].
    ///
    /// # Errors
    /// The shortfall \[m\].
    pub fn covered_by(&self, state: &FluidState, extent: &Extent, reach: f64) -> Result<(), f64> {
        let support = 2.0 * self.coupling.fluid.smoothing_length;
        self.tracker.shortfall(extent, &state.position, support, reach)
    }

    /// Fills `states` with the particles within `reach` \[m\] of `partner`, ids ascending; returns the set's version.
    pub fn select(
        &mut self,
        state: &FluidState,
        fluid: &[Record],
        partner: &Extent,
        reach: f64,
        states: &mut InterfaceStates,
    ) -> u64 {
        self.reach.update(partner, reach);
        // Candidates may be found later than the lists: a particle then moves from one end of its way to the other.
        let changed = self.vicinity.update(partner, reach + 2.0 * self.farthest());
        if changed || !self.candidates.1 {
            self.find_candidates(state);
        }
        let within = |i: &u32| self.reach.contains(&state.position[*i as usize]);
        self.members.clear();
        self.members.extend(self.candidates.0.iter().copied().filter(within));
        states.clear();
        for &i in &self.members {
            let i = i as usize;
            states.id.push(state.id[i]);
            states.group.push(state.region[i]);
            states.mass.push(state.mass[i]);
            states.position.push(state.position[i]);
            states.velocity.push(fluid[i].velocity());
            states.density.push(state.density[i]);
            states.pressure.push(fluid[i].pressure());
        }
        self.largest = self.largest.max(states.len() as u64);
        if states.id != self.known_ids {
            self.known_ids.clone_from(&states.id);
            self.set_version += 1;
        }
        self.set_version
    }

    /// Finds the particles in the vicinity of the partner.
    fn find_candidates(&mut self, state: &FluidState) {
        let Self { vicinity, candidates: (candidates, known), inside, .. } = self;
        inside.resize(state.len(), false);
        inside.par_iter_mut().zip(&state.position).with_min_len(1024).for_each(|(inside, x)| {
            *inside = vicinity.contains(x);
        });
        candidates.clear();
        candidates.extend((0u32..).zip(&*inside).filter(|(_, inside)| **inside).map(|(i, _)| i));
        candidates.sort_unstable_by_key(|i| state.id[*i as usize]);
        *known = true;
    }

    /// Force on each of the partner's `samples` \[N/m\] at `time` \[s\], written to `forces`.
    pub fn reactions(
        &mut self,
        time: f64,
        own: &InterfaceStates,
        samples: &InterfaceStates,
        forces: &mut Vec<Vector>,
    ) {
        self.interface.update(time, own, samples);
        self.interface.solid_forces(own, samples);
        forces.clear();
        forces.extend((0..samples.len()).map(|s| self.interface.force(s)));
    }

    /// Cross lists, dummy states and pair forces of this stage.
    pub fn update(&mut self, time: f64, own: &InterfaceStates, partner: &InterfaceStates) {
        self.interface.update(time, own, partner);
        self.sums = self.interface.fluid_forces(own, partner);
    }

    /// Whether the solid's density means something to the fluid's density gradient and diffusion.
    ///
    /// In the plain sum it is that of another material.
    pub fn density_meets(&self) -> bool {
        self.coupling.law != InterfaceLaw::PlainSum
    }

    /// Adds the solid's particles to the sums of the gradient pass, each particle's once: toward them is no surface.
    ///
    /// The velocity gradient feels the whole velocity of the solid, or with slip only the approach along x_ij.
    pub fn add_moments<G: Geometry>(
        &mut self,
        scene: &Scene<G>,
        own: &InterfaceStates,
        partner: &InterfaceStates,
        gradients: &mut Gradients,
        rates: &mut [Rates],
    ) {
        let model = scene.model;
        if !model.passes.any() {
            return;
        }
        let meets = self.density_meets();
        let slips = self.coupling.law == InterfaceLaw::Wall;
        let at_spacing = model.kernel.value(model.constants.particle_spacing);
        let Self { interface, domain, moments, meeting: [states, particles], members, .. } = self;
        states.clear();
        states.extend((0u32..).take(own.len()).filter(|k| interface.meets(*k as usize)));
        particles.clear();
        particles.extend(states.iter().map(|k| members[*k as usize]));
        moments.resize(states.len(), NeighbourSums::default());
        moments.par_iter_mut().zip(&*states).with_min_len(TASK).for_each(|(sums, k)| {
            let k = *k as usize;
            *sums = NeighbourSums::default();
            for (s, dummy) in interface.solids_near(k) {
                let d = domain.separation(&own.position[k], &partner.position[s]);
                let r = d.norm();
                let mut v_sf = partner.velocity[s] - own.velocity[k];
                if slips {
                    v_sf = d * (v_sf.dot(&d) / d.norm_squared().max(f64::MIN_POSITIVE));
                }
                let density = if meets { dummy.density - own.density[k] } else { 0.0 };
                let volume = dummy.mass / dummy.density;
                let gradient_factor = model.gradient_scale * model.kernel.gradient_factor(r);
                let pairing = pairing_of(model.kernel.value(r) / at_spacing);
                sums.add_pair(&d, volume * gradient_factor, density, &v_sf, pairing);
            }
        });
        gradients.merge(scene, particles, moments, meets, rates);
    }

    /// Adds the solid's part to the rates, each particle's once: continuity, diffusion and force, as far as `part` asks
    /// for them.
    ///
    /// ```text
    /// ρ_f Σ V_s v_fs·∇W  +  δ h c₀ Σ V_s [2 (ρ_f − ρ_s) x²/(x² + λh²) − 2 ∇ρ_f·x_fs] (dW/dr)/r
    /// ```
    /// The second sum is left out in the plain sum, where ρ_s is that of another material.
    pub fn add_rates(
        &mut self,
        model: &FluidModel,
        state: &FluidState,
        part: Part,
        [own, partner]: [&InterfaceStates; 2],
        gradients: &Gradients,
        rates: &mut [Rates],
    ) {
        self.count_immersed(model, own, partner);
        let diffusion = if self.density_meets() && part != Part::Density { model.diffusion } else { 0.0 };
        let flux = if part == Part::Momentum { 0.0 } else { 1.0 };
        let Self { interface, domain, members, density_rates, .. } = self;
        density_rates.resize(own.len(), 0.0);
        density_rates.par_iter_mut().with_min_len(TASK).enumerate().for_each(|(k, rate)| {
            let rho = own.density[k];
            let gradient = if model.passes.density_gradient {
                let [.., x, y] = gradients.shown[members[k] as usize];
                [x, y]
            } else {
                [0.0; 2]
            };
            let (mut continuity, mut exchange) = (0.0, 0.0);
            for (s, dummy) in interface.solids_near(k) {
                let d = domain.separation(&own.position[k], &partner.position[s]);
                let square = d.norm_squared();
                let gradient_factor =
                    model.cross_gradient_scale * model.kernel.gradient_factor(square.sqrt());
                let weight = dummy.mass / dummy.density * gradient_factor;
                continuity += weight * (own.velocity[k] - partner.velocity[s]).dot(&d);
                let psi = 2.0 * (rho - dummy.density) * square / (square + model.law.regularisation)
                    - 2.0 * (gradient[0] * d.x + gradient[1] * d.y);
                exchange += weight * psi;
            }
            *rate = flux * rho * continuity + diffusion * exchange;
        });
        for (k, i) in self.members.iter().enumerate() {
            let i = *i as usize;
            rates[i].density += self.density_rates[k];
            if part != Part::Density {
                rates[i].acceleration += self.interface.force(k) / state.mass[i];
            }
        }
    }
}
