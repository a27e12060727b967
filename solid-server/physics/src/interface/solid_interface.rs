//! Interface of the solids with the fluid.

use sph::coupling::exchange::{Column, Extent, StateColumns};
use sph::coupling::extent::{ExtentTracker, ReachMap};
use sph::coupling::ledger::InterfaceSums;
use sph::interface::states::InterfaceStates;
use sph::interface::{Interface, load_sums};
use sph::kernel::CubicSpline;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{Coupling, InterfaceLaw};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::tasks::for_each;

use crate::formulations::pair_law::PairSums;
use crate::particles::constants::ParticleConstants;
use crate::particles::fields::StressFields;
use crate::particles::variables::Particles;
use crate::space::SolidSpace;

/// Motion in particle spacings after which the extent is rebuilt \[-\].
const EXTENT_SLACK: f64 = 0.5;

/// State of the interface with the fluid on the side of the solids.
#[derive(Debug)]
pub struct SolidInterface<S: SolidSpace> {
    interface: Interface<S>,
    /// Own interface states of the stage, and the fluid's.
    states: [InterfaceStates<S>; 2],
    /// Forces that the fluid returned for the own states \[N\].
    loads: Vec<S::Vector>,
    domain: Domain<S>,
    /// The fluid's kernel, used for fluid-solid pairs on both sides.
    kernel: CubicSpline<S>,
    law: InterfaceLaw,
    tracker: ExtentTracker<S>,
    /// Distance by which particles may move before the extent is rebuilt \[m\].
    slack: f64,
    tracked_at: Vec<S::Vector>,
    reach_map: ReachMap<S>,
    /// Index of the particle of each interface state.
    sent: Vec<u32>,
    set_version: u64,
    pub largest_set: u64,
}

/// Pairs of solid and fluid of a stage.
#[derive(Clone, Copy)]
pub struct FluidPairs<'a, S: SolidSpace> {
    pub interface: &'a Interface<S>,
    pub fluid: &'a InterfaceStates<S>,
    /// Index of the particle of each interface state of the solid.
    pub sent: &'a [u32],
}

impl<S: SolidSpace> SolidInterface<S> {
    /// The link that `coupling` describes, for particles at `positions` \[m\].
    pub fn new(
        coupling: &Coupling,
        domain: &Domain<S>,
        body_force: &BodyForceField<S>,
        positions: &[S::Vector],
    ) -> Self {
        let kernel = CubicSpline::new(coupling.fluid.smoothing_length());
        let cell = kernel.support_radius();
        let mut link = Self {
            interface: Interface::new(coupling, domain, body_force.clone()),
            states: Default::default(),
            loads: Vec::new(),
            domain: *domain,
            kernel,
            law: coupling.law,
            tracker: ExtentTracker::new(domain, cell),
            slack: EXTENT_SLACK * coupling.solid_spacing,
            tracked_at: Vec::new(),
            reach_map: ReachMap::new(domain, cell),
            sent: Vec::new(),
            set_version: 0,
            largest_set: 0,
        };
        link.track(positions);
        link
    }

    /// Pairs of the stage with the fluid.
    pub fn pairs(&self) -> FluidPairs<'_, S> {
        FluidPairs { interface: &self.interface, fluid: &self.states[1], sent: &self.sent }
    }

    /// Rebuilds the extent when particles have moved too far.
    pub fn track(&mut self, positions: &[S::Vector]) {
        let moved = if self.tracked_at.len() == positions.len() {
            sph::neighbours::largest_displacement(&self.domain, positions, &self.tracked_at)
        } else {
            f64::INFINITY
        };
        if moved > self.slack {
            self.tracker.update(&self.tracker.occupied(positions), self.slack);
            self.tracked_at.clear();
            self.tracked_at.extend_from_slice(positions);
        }
    }

    /// Continues with particles restored to `positions` \[m\].
    pub fn restore(&mut self, positions: &[S::Vector], largest_set: u64) {
        self.tracked_at.clear();
        self.track(positions);
        self.largest_set = largest_set;
    }

    /// Extent of the own particles.
    pub fn extent(&self) -> &Extent {
        self.tracker.extent()
    }

    /// Whether a partner that sent all within `reach` \[m\] of `extent` covered all neighbours of `positions`.
    ///
    /// # Errors
    /// The shortfall \[m\].
    pub fn covered_by(&self, extent: &Extent, reach: f64, positions: &[S::Vector]) -> Result<(), f64> {
        self.tracker.shortfall(extent, positions, self.kernel.support_radius(), reach)
    }

    /// Fills `columns` with the particles within `reach` \[m\] of `partner`; returns the version of the set.
    pub fn select(
        &mut self,
        constants: &ParticleConstants<S>,
        stage: &Particles<S>,
        stress: &StressFields<S>,
        partner: &Extent,
        reach: f64,
        columns: &mut StateColumns,
    ) -> u64 {
        self.reach_map.update(partner, reach);
        let [states, _] = &mut self.states;
        states.clear();
        let mut changed = false;
        let mut count = 0;
        for i in (0..stage.len()).filter(|i| self.reach_map.contains(&stage.position[*i])) {
            states.id.push(constants.id[i]);
            states.group.push(constants.body[i]);
            states.mass.push(constants.mass[i]);
            states.position.push(stage.position[i]);
            states.velocity.push(stage.velocity[i]);
            states.density.push(stage.density[i]);
            states.pressure.push(stress.pressure[i]);
            if self.law == InterfaceLaw::PlainSum {
                states.stress.push(stress.cauchy[i]);
            }
            let index = i as u32;
            match self.sent.get_mut(count) {
                Some(sent) if *sent == index => {}
                Some(sent) => {
                    *sent = index;
                    changed = true;
                }
                None => {
                    self.sent.push(index);
                    changed = true;
                }
            }
            count += 1;
        }
        states.write(columns);
        changed |= count < self.sent.len();
        self.sent.truncate(count);
        self.largest_set = self.largest_set.max(count as u64);
        self.set_version += u64::from(changed || self.set_version == 0);
        self.set_version
    }

    /// Forces of the fluid at `time` \[s\], written to `forces` \[N\]; `own` as filled by
    /// [`SolidInterface::select`] in this stage.
    ///
    /// With the plain-sum law the fluid's particles enter the gradients of `sums` too.
    pub fn evaluate(
        &mut self,
        time: f64,
        own: &StateColumns,
        partner: &StateColumns,
        sums: &mut [PairSums<S>],
        forces: &mut [S::Vector],
    ) -> InterfaceSums {
        let [solid, fluid] = &mut self.states;
        solid.read(own);
        fluid.read(partner);
        self.interface.update(time, fluid, solid);
        let total = self.interface.solid_forces(fluid, solid);
        for_each(&mut *forces, 4096, |_, force| *force = S::Vector::zeros());
        for (s, i) in self.sent.iter().enumerate() {
            forces[*i as usize] = self.interface.force(s);
        }
        if self.law == InterfaceLaw::PlainSum {
            for (s, i) in self.sent.iter().enumerate() {
                self.add_gradient(s, &mut sums[*i as usize]);
            }
        }
        total
    }

    /// Takes the `loads` \[N\] that the fluid returned for each of the `own` coupling points as forces on their particles.
    pub fn apply(&mut self, own: &StateColumns, loads: &Column, forces: &mut [S::Vector]) -> InterfaceSums {
        let [points, _] = &mut self.states;
        points.read(own);
        loads.read_into(&mut self.loads);
        forces.fill(S::Vector::zeros());
        for (load, i) in self.loads.iter().zip(&self.sent) {
            forces[*i as usize] = *load;
        }
        load_sums(&self.domain, points, &self.loads)
    }

    fn add_gradient(&self, s: usize, sums: &mut PairSums<S>) {
        let [own, fluid] = &self.states;
        let mut foreign = PairSums::zero();
        for (f, _) in self.interface.fluids_near(s) {
            let x_sf = self.domain.separation(&own.position[s], &fluid.position[f]);
            let v_sf = own.velocity[s] - fluid.velocity[f];
            let gradient_factor = self.kernel.gradient_factor(x_sf.norm());
            let weight = fluid.mass[f] / fluid.density[f] * gradient_factor;
            foreign.add_gradient(weight, S::components(&x_sf), S::components(&v_sf));
        }
        sums.add_gradients_of(&foreign);
    }
}
