//! Audit of a solid's frames against its set-up and against its own report.
//!
//! The ledger compares what each side reports of itself. A solver that integrates one motion and sends another would
//! pass it: see AUDIT OF THE SOLID'S FRAMES in `peer.proto`.

use crate::coupling::exchange::StateColumns;
use crate::coupling::ledger::{LedgerVector, MomentumReport, axial, exceeds, lifted};
use crate::coupling::stage::{Stage, StageTime};
use crate::interface::states::InterfaceStates;
use crate::setup::{CouplingKind, Formulation, SolidSetup};
use crate::space::domain::Domain;
use crate::space::{Vector, cross};
use crate::sums::ordered_sum;

crate::constants! {
    /// Far above round-off, far below what changes a result.
    const PLACE_TOLERANCE: f64 = 1e-6, "audit.position",
        "largest error of a shown position at the start, in spacings [-]";
    /// A sum over round-off.
    const MASS_TOLERANCE: f64 = 1e-12, "audit.mass",
        "largest relative error of a shown mass [-]";
    const DRIFT_SPACINGS: f64 = 0.1, "audit.drift",
        "distance by which the mean position of a body may part from its mean velocity, in spacings [-]";
    /// Velocities within a step are known at its ends and its middle alone.
    const DRIFT_SHARE: f64 = 0.05, "audit.drift_share",
        "the same over the length of the path [-]";
}

/// Particles of a solid as its set-up has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartnerParticles {
    /// Identity, strictly ascending.
    pub id: Vec<u32>,
    /// Index of the body.
    pub body: Vec<u32>,
    /// Mass \[kg\].
    pub mass: Vec<f64>,
    /// Position at the start \[m\].
    pub position: Vec<Vector>,
    /// Bodies.
    pub bodies: Vec<PartnerBody>,
}

/// A body of [`PartnerParticles`].
#[derive(Clone, Debug, PartialEq)]
pub struct PartnerBody {
    /// Name.
    pub name: String,
    /// Of a rigid body the moment of inertia of its cells about their own centres, Σ m V/6 \[kg m²\]; `None` for others.
    pub cell_inertia: Option<f64>,
    /// Whether supports move it, by expressions that may jump.
    pub driven: bool,
}

impl PartnerParticles {
    /// Those of the solid of `setup`.
    pub fn of(setup: &SolidSetup) -> Self {
        let particles = &setup.particles;
        let bodies = (0u32..).zip(&setup.bodies).map(|(k, body)| {
            let rigid = matches!(body.formulation, Formulation::Rigid);
            PartnerBody {
                name: body.name.clone(),
                cell_inertia: rigid.then(|| particles.of_body(k).cell_inertia()),
                driven: body.supports.iter().any(|support| support.motion.is_some()),
            }
        });
        Self {
            id: particles.id.clone(),
            body: particles.body.clone(),
            mass: particles.mass.clone(),
            position: particles.position.clone(),
            bodies: bodies.collect(),
        }
    }

    fn body_name(&self, k: u32) -> &str {
        usize::try_from(k).ok().and_then(|k| self.bodies.get(k)).map_or("?", |body| &body.name)
    }
}

/// Momentum that follows from what a frame shows.
#[derive(Clone, Copy, Debug, Default)]
struct Shown {
    momentum: LedgerVector,
    angular: LedgerVector,
    gross: f64,
    gross_angular: f64,
}

/// Mean motion of the shown particles of one body since they were first shown.
#[derive(Clone, Copy, Debug, Default)]
struct Track {
    /// Mean displacement minus mean of the velocities over time \[m\].
    drift: Vector,
    /// Length of the way by either, the longer \[m\].
    way: f64,
}

/// Watches the frames of one solid over a run.
#[derive(Debug)]
pub struct Audit {
    particles: PartnerParticles,
    domain: Domain,
    spacing: f64,
    tolerance: f64,
    /// Whether the momentum of what is shown is that of the bodies: they are particles of this kind, or rigid.
    carries_momentum: bool,
    shows_masses: bool,
    /// Whether the next frame is the first of a run from its start.
    first: bool,
    /// States of the latest frame.
    received: InterfaceStates,
    /// The state at the start of the step.
    start: Option<(StageTime, InterfaceStates, Option<Shown>)>,
    /// Velocities in the middle of the step.
    middle: Vec<Vector>,
    predicted: Option<Shown>,
    tracks: Vec<Track>,
}

impl Audit {
    /// An audit of `particles` in a run over `domain` that is coupled by `kind`; `spacing` \[m\] is the solid's, `tolerance`
    /// that of the momentum check, and `first` tells a run from its start from one that continues.
    pub fn new(
        particles: PartnerParticles,
        domain: Domain,
        kind: CouplingKind,
        [spacing, tolerance]: [f64; 2],
        first: bool,
    ) -> Self {
        let all_rigid = particles.bodies.iter().all(|body| body.cell_inertia.is_some());
        Self {
            carries_momentum: kind == CouplingKind::States || all_rigid,
            shows_masses: kind == CouplingKind::States,
            tracks: vec![Track::default(); particles.bodies.len()],
            particles,
            domain,
            spacing,
            tolerance,
            first,
            received: InterfaceStates::default(),
            start: None,
            middle: Vec::new(),
            predicted: None,
        }
    }

    /// Takes the frame of `time`, with implicit coupling that of iteration 0; `report` is what the solid reports of the half-step
    /// before.
    ///
    /// # Errors
    /// What does not agree, in words.
    pub fn observe(
        &mut self,
        time: &StageTime,
        states: &StateColumns,
        report: Option<&MomentumReport>,
    ) -> Result<(), String> {
        let mut received = std::mem::take(&mut self.received);
        received.read(states);
        let result = self.compare(time, &received, report);
        self.received = received;
        result
    }

    fn compare(
        &mut self,
        time: &StageTime,
        states: &InterfaceStates,
        report: Option<&MomentumReport>,
    ) -> Result<(), String> {
        if std::mem::take(&mut self.first) {
            self.compare_places(states)?;
        }
        let shown = self.shown(states);
        match time.at.stage {
            Stage::Predictor => {
                let result = self.end_step(states, shown.as_ref(), report);
                let mut kept = self.start.take().map(|(_, states, _)| states).unwrap_or_default();
                kept.clone_from(states);
                self.start = Some((*time, kept, shown));
                self.middle.clear();
                self.predicted = None;
                result
            }
            Stage::Corrector => {
                self.middle.clone_from(&states.velocity);
                self.predicted = shown;
                let before = self.start.as_ref().and_then(|(_, _, shown)| shown.as_ref());
                match (before, &self.predicted, report) {
                    (Some(before), Some(now), Some(report)) => self.compare_momenta(before, now, report),
                    _ => Ok(()),
                }
            }
        }
    }

    /// Takes the `states` of a further iteration of the corrector.
    pub fn update(&mut self, states: &StateColumns) {
        states.velocity.read_into(&mut self.middle);
    }

    /// Compares the state at a step boundary with the one before.
    fn end_step(
        &mut self,
        states: &InterfaceStates,
        shown: Option<&Shown>,
        report: Option<&MomentumReport>,
    ) -> Result<(), String> {
        let Some((_, _, before)) = &self.start else { return Ok(()) };
        if let (Some(before), Some(now), Some(report)) = (before, shown, report) {
            self.compare_momenta(before, now, report)?;
        }
        self.follow(states)
    }

    /// Check 1: particles are where the set-up has them.
    fn compare_places(&self, states: &InterfaceStates) -> Result<(), String> {
        let all = &self.particles;
        for (i, id) in states.id.iter().enumerate() {
            let Ok(k) = all.id.binary_search(id) else {
                return Err(format!("particle {id} is shown, which the set-up does not have"));
            };
            let distance = |k: usize| self.domain.separation(&states.position[i], &all.position[k]).norm();
            let allowed = PLACE_TOLERANCE * self.spacing;
            let within = |distance: f64| distance <= allowed;
            if !within(distance(k)) {
                let (x, place) = (states.position[i], all.position[k]);
                let other = (0..all.id.len()).find(|k| within(distance(*k)));
                let cause = match other {
                    Some(other) => format!(
                        "that is the place of particle {}: particles are shown in another order than the set-up's",
                        all.id[other]
                    ),
                    None => format!("the position is {:.3e} m beside its place", distance(k)),
                };
                return Err(format!(
                    "particle {id} of body `{}` is shown at ({:.6}, {:.6}) m, the set-up has it at ({:.6}, {:.6}) m; {cause}",
                    all.body_name(all.body[k]),
                    x.x,
                    x.y,
                    place.x,
                    place.y
                ));
            }
            let (mass, expected) = (states.mass[i], all.mass[k]);
            if self.shows_masses && (mass - expected).abs() > MASS_TOLERANCE * expected {
                return Err(format!(
                    "particle {id} of body `{}` is shown with the mass {mass:e} kg, the set-up has {expected:e} kg",
                    all.body_name(all.body[k])
                ));
            }
        }
        Ok(())
    }

    /// Momentum of all particles, where all are shown and carry it.
    fn shown(&self, states: &InterfaceStates) -> Option<Shown> {
        let all = &self.particles;
        if !self.carries_momentum || states.id != all.id {
            return None;
        }
        let origin = self.domain.torque_origin();
        let term = |i: usize| {
            let (m, v) = (all.mass[i], states.velocity[i]);
            let arm = states.position[i] - origin;
            let (gross, momentum) = (m * v.norm(), v * m);
            [momentum.x, momentum.y, cross(&arm, &momentum), gross, arm.norm() * gross]
        };
        let sums: Sums = ordered_sum(all.id.len(), |i| Sums(term(i)));
        let [x, y, angular, gross, gross_angular] = sums.0;
        let spins = self.spins(states);
        let momentum = lifted(&Vector::new(x, y));
        Some(Shown { momentum, angular: axial(angular + spins), gross, gross_angular })
    }

    /// Angular momentum of the cells of rigid bodies about their own centres \[kg m²/s\].
    fn spins(&self, states: &InterfaceStates) -> f64 {
        let all = &self.particles;
        let rigid = (0u32..).zip(&all.bodies).filter_map(|(k, body)| Some((k, body.cell_inertia?)));
        rigid
            .map(|(k, cells)| {
                let own: Vec<usize> = (0..all.id.len()).filter(|i| all.body[*i] == k).collect();
                let mass: f64 = own.iter().map(|i| all.mass[*i]).sum();
                let mean =
                    |values: &[Vector]| own.iter().map(|i| values[*i] * all.mass[*i]).sum::<Vector>() / mass;
                let (centre, velocity) = (mean(&states.position), mean(&states.velocity));
                let (mut moment, mut inertia) = (0.0, 0.0);
                for &i in &own {
                    let arm = states.position[i] - centre;
                    moment += all.mass[i] * cross(&arm, &(states.velocity[i] - velocity));
                    inertia += all.mass[i] * arm.norm_squared();
                }
                // Of a single particle nothing but round-off is left to divide.
                if inertia > 1e-9 * cells { cells * moment / inertia } else { 0.0 }
            })
            .sum()
    }

    /// Check 2: what is shown has the momentum that is reported.
    fn compare_momenta(&self, before: &Shown, now: &Shown, report: &MomentumReport) -> Result<(), String> {
        let change = now.momentum - before.momentum;
        let scale = report.gross + now.gross + before.gross;
        if exceeds((change - report.change).norm(), self.tolerance * scale) {
            let ratio = report.change.norm() / change.norm();
            return Err(format!(
                "it reports that its momentum changed by ({:.6e}, {:.6e}) kg m/s, the velocities it shows and the masses of the \
                 set-up give ({:.6e}, {:.6e}) kg m/s, a ratio of {ratio:.6}: its mass is not that of the set-up, or the \
                 velocities shown are not those of its motion",
                report.change.x, report.change.y, change.x, change.y
            ));
        }
        let Some(reported) = report.angular.filter(|_| !self.domain.is_periodic()) else { return Ok(()) };
        let change = now.angular - before.angular;
        let scale = reported.gross + now.gross_angular + before.gross_angular;
        if exceeds((change - reported.change).norm(), self.tolerance * scale) {
            return Err(format!(
                "it reports that its angular momentum changed by {:.6e} kg m2/s, the motion it shows and the masses of \
                 the set-up give {:.6e} kg m2/s: its moment of inertia is not that of the set-up, or what is shown \
                 is not its motion",
                reported.change.z, change.z
            ));
        }
        Ok(())
    }

    /// Check 3: bodies go where their velocities lead.
    fn follow(&mut self, states: &InterfaceStates) -> Result<(), String> {
        let Some((time, before, _)) = &self.start else { return Ok(()) };
        if before.id != states.id || self.middle.len() != states.len() {
            return Ok(());
        }
        for (k, track) in (0u32..).zip(&mut self.tracks) {
            let driven =
                usize::try_from(k).ok().and_then(|k| self.particles.bodies.get(k)).is_none_or(|b| b.driven);
            let own = || (0..states.len()).filter(|i| states.group[*i] == k && !driven);
            let count = own().count() as f64;
            if count == 0.0 {
                continue;
            }
            let moved = own()
                .map(|i| self.domain.separation(&states.position[i], &before.position[i]))
                .sum::<Vector>()
                / count;
            // Simpson's rule over the step.
            let velocity = own()
                .map(|i| (before.velocity[i] + self.middle[i] * 4.0 + states.velocity[i]) / 6.0)
                .sum::<Vector>()
                / count;
            let led = velocity * time.time_step;
            track.drift += moved - led;
            track.way += moved.norm().max(led.norm());
            let allowed = (DRIFT_SPACINGS * self.spacing).max(DRIFT_SHARE * track.way);
            if exceeds(track.drift.norm(), allowed) {
                return Err(format!(
                    "the particles shown of body `{}` are on average {:.3e} m from where the velocities shown lead, after a way \
                     of {:.3e} m; allowed: {allowed:.3e} m; positions and velocities are not those of one motion",
                    self.particles.body_name(k),
                    track.drift.norm(),
                    track.way
                ));
            }
        }
        Ok(())
    }
}

/// Sums over particles in a fixed order.
#[derive(Clone, Copy, Default)]
struct Sums([f64; 5]);

impl std::ops::AddAssign for Sums {
    fn add_assign(&mut self, other: Self) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum += value;
        }
    }
}

#[cfg(test)]
mod tests;
