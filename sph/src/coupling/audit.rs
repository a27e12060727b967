//! Audit of a solid's frames against its set-up and against its own report.
//!
//! The ledger compares what each side reports of itself. A solver that integrates one motion and sends another would
//! pass it: see AUDIT OF THE SOLID'S FRAMES in `peer.proto`.

use nalgebra::{Matrix3, SymmetricEigen};

use crate::coupling::exchange::{Column, StateColumns};
use crate::coupling::ledger::{LedgerVector, MomentumReport, exceeds};
use crate::coupling::stage::{Stage, StageTime};
use crate::interface::states::InterfaceStates;
use crate::setup::{CouplingKind, DomainPlan, Formulation, SolidSetup};
use crate::space::domain::Domain;
use crate::space::{Space, Spatial};
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
    pub position: Column,
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
    pub fn of<S: Space>(setup: &SolidSetup<S>) -> Self {
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
            position: particles.position.iter().copied().collect(),
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
    drift: LedgerVector,
    /// Length of the way by either, the longer \[m\].
    way: f64,
}

/// Numbers of a vector of any space as a vector of three.
fn lifted(row: &[f64]) -> LedgerVector {
    LedgerVector::from_fn(|k, _| row.get(k).copied().unwrap_or(0.0))
}

/// States with the vectors of a plane lifted into space, where z is zero.
fn read(columns: &StateColumns, states: &mut InterfaceStates<Spatial>) {
    let lift = |column: &Column, vectors: &mut Vec<LedgerVector>| {
        vectors.clear();
        vectors.extend(column.rows().map(lifted));
    };
    states.id.clone_from(&columns.id);
    states.group.clone_from(&columns.group);
    states.mass.clone_from(&columns.mass);
    lift(&columns.position, &mut states.position);
    lift(&columns.velocity, &mut states.velocity);
}

/// Watches the frames of one solid over a run; in three dimensions always.
#[derive(Debug)]
pub struct Audit {
    particles: PartnerParticles,
    /// Places of the particles at the start \[m\].
    places: Vec<LedgerVector>,
    domain: Domain<Spatial>,
    /// Number of dimensions of the run.
    dimensions: usize,
    spacing: f64,
    tolerance: f64,
    /// Whether the momentum of what is shown is that of the bodies: they are particles of this kind, or rigid.
    carries_momentum: bool,
    shows_masses: bool,
    /// Whether the next frame is the first of a run from its start.
    first: bool,
    /// States of the latest frame.
    received: InterfaceStates<Spatial>,
    /// The state at the start of the step.
    start: Option<(StageTime, InterfaceStates<Spatial>, Option<Shown>)>,
    /// Velocities in the middle of the step.
    middle: Vec<LedgerVector>,
    predicted: Option<Shown>,
    tracks: Vec<Track>,
}

impl Audit {
    /// An audit of `particles` in a run over `domain` that is coupled by `kind`; `spacing` \[m\] is the solid's, `tolerance`
    /// that of the momentum check, and `first` tells a run from its start from one that continues.
    pub fn new(
        particles: PartnerParticles,
        domain: &DomainPlan,
        kind: CouplingKind,
        [spacing, tolerance]: [f64; 2],
        first: bool,
    ) -> Self {
        let all_rigid = particles.bodies.iter().all(|body| body.cell_inertia.is_some());
        Self {
            carries_momentum: kind == CouplingKind::States || all_rigid,
            shows_masses: kind == CouplingKind::States,
            tracks: vec![Track::default(); particles.bodies.len()],
            places: particles.position.rows().map(lifted).collect(),
            particles,
            domain: Domain {
                lower: lifted(&domain.lower),
                upper: lifted(&domain.upper),
                periodic: std::array::from_fn(|axis| domain.periodic.get(axis).copied().unwrap_or(false)),
            },
            dimensions: domain.lower.len(),
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
        read(states, &mut received);
        let result = self.compare(time, &received, report);
        self.received = received;
        result
    }

    fn compare(
        &mut self,
        time: &StageTime,
        states: &InterfaceStates<Spatial>,
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
        self.middle.clear();
        self.middle.extend(states.velocity.rows().map(lifted));
    }

    /// Compares the state at a step boundary with the one before.
    fn end_step(
        &mut self,
        states: &InterfaceStates<Spatial>,
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
    fn compare_places(&self, states: &InterfaceStates<Spatial>) -> Result<(), String> {
        let all = &self.particles;
        for (i, id) in states.id.iter().enumerate() {
            let Ok(k) = all.id.binary_search(id) else {
                return Err(format!("particle {id} is shown, which the set-up does not have"));
            };
            let distance = |k: usize| self.domain.separation(&states.position[i], &self.places[k]).norm();
            let allowed = PLACE_TOLERANCE * self.spacing;
            let within = |distance: f64| distance <= allowed;
            if !within(distance(k)) {
                let (x, place) = (self.text(&states.position[i]), self.text(&self.places[k]));
                let other = (0..all.id.len()).find(|k| within(distance(*k)));
                let cause = match other {
                    Some(other) => format!(
                        "that is the place of particle {}: particles are shown in another order than the set-up's",
                        all.id[other]
                    ),
                    None => format!("the position is {:.3e} m beside its place", distance(k)),
                };
                return Err(format!(
                    "particle {id} of body `{}` is shown at {x} m, the set-up has it at {place} m; {cause}",
                    all.body_name(all.body[k])
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

    /// The components of `vector` that the run has.
    fn text(&self, vector: &LedgerVector) -> String {
        let row: Vec<String> = vector.iter().take(self.dimensions).map(|x| format!("{x:.6}")).collect();
        format!("({})", row.join(", "))
    }

    /// The same for momenta, which may be of any magnitude.
    fn momentum_text(&self, vector: &LedgerVector) -> String {
        let row: Vec<String> = vector.iter().take(self.dimensions).map(|x| format!("{x:.6e}")).collect();
        format!("({})", row.join(", "))
    }

    /// The components of a moment that the run has: in the plane that about z.
    fn axial_text(&self, moment: &LedgerVector) -> String {
        if self.dimensions < 3 { format!("{:.6e}", moment.z) } else { self.momentum_text(moment) }
    }

    /// Momentum of all particles, where all are shown and carry it.
    fn shown(&self, states: &InterfaceStates<Spatial>) -> Option<Shown> {
        let all = &self.particles;
        if !self.carries_momentum || states.id != all.id {
            return None;
        }
        let origin = self.domain.torque_origin();
        let term = |i: usize| {
            let (m, v) = (all.mass[i], states.velocity[i]);
            let arm = states.position[i] - origin;
            let (gross, momentum) = (m * v.norm(), v * m);
            Shown { momentum, angular: arm.cross(&momentum), gross, gross_angular: arm.norm() * gross }
        };
        let mut shown: Shown = ordered_sum(all.id.len(), term);
        shown.angular += self.spins(states);
        Some(shown)
    }

    /// Angular momentum of the cells of rigid bodies about their own centres \[kg m²/s\].
    fn spins(&self, states: &InterfaceStates<Spatial>) -> LedgerVector {
        let all = &self.particles;
        let rigid = (0u32..).zip(&all.bodies).filter_map(|(k, body)| Some((k, body.cell_inertia?)));
        rigid
            .map(|(k, cells)| {
                let own: Vec<usize> = (0..all.id.len()).filter(|i| all.body[*i] == k).collect();
                let mass: f64 = own.iter().map(|i| all.mass[*i]).sum();
                let mean = |values: &[LedgerVector]| {
                    own.iter().map(|i| values[*i] * all.mass[*i]).sum::<LedgerVector>() / mass
                };
                let (centre, velocity) = (mean(&states.position), mean(&states.velocity));
                let (mut moment, mut inertia) = (LedgerVector::zeros(), Matrix3::zeros());
                for &i in &own {
                    let arm = states.position[i] - centre;
                    moment += arm.cross(&(states.velocity[i] - velocity)) * all.mass[i];
                    let square = Matrix3::from_diagonal_element(arm.norm_squared());
                    inertia += (square - arm * arm.transpose()) * all.mass[i];
                }
                spin_of(moment, inertia, cells) * cells
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
                "it reports that its momentum changed by {} kg m/s, the velocities it shows and the masses of the set-up \
                 give {} kg m/s, a ratio of {ratio:.6}: its mass is not that of the set-up, or the velocities shown are \
                 not those of its motion",
                self.momentum_text(&report.change),
                self.momentum_text(&change)
            ));
        }
        let Some(reported) = report.angular.filter(|_| !self.domain.is_periodic()) else { return Ok(()) };
        let change = now.angular - before.angular;
        let scale = reported.gross + now.gross_angular + before.gross_angular;
        if exceeds((change - reported.change).norm(), self.tolerance * scale) {
            return Err(format!(
                "it reports that its angular momentum changed by {} kg m2/s, the motion it shows and the masses of the \
                 set-up give {} kg m2/s: its moment of inertia is not that of the set-up, or what is shown is not its \
                 motion",
                self.axial_text(&reported.change),
                self.axial_text(&change)
            ));
        }
        Ok(())
    }

    /// Check 3: bodies go where their velocities lead.
    fn follow(&mut self, states: &InterfaceStates<Spatial>) -> Result<(), String> {
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
                .sum::<LedgerVector>()
                / count;
            // Simpson's rule over the step.
            let velocity = own()
                .map(|i| (before.velocity[i] + self.middle[i] * 4.0 + states.velocity[i]) / 6.0)
                .sum::<LedgerVector>()
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

/// The spin of particles whose angular momentum is `moment` and whose tensor of inertia is `inertia`; none about axes
/// about which they have no more inertia than round-off, measured by that of their cells.
fn spin_of(moment: LedgerVector, inertia: Matrix3<f64>, cells: f64) -> LedgerVector {
    let eigen = SymmetricEigen::new(inertia);
    let part = |(k, value): (usize, &f64)| {
        let axis = eigen.eigenvectors.column(k);
        if *value > 1e-9 * cells { axis * (axis.dot(&moment) / value) } else { LedgerVector::zeros() }
    };
    eigen.eigenvalues.iter().enumerate().map(part).sum()
}

impl std::ops::AddAssign for Shown {
    fn add_assign(&mut self, other: Self) {
        self.momentum += other.momentum;
        self.angular += other.angular;
        self.gross += other.gross;
        self.gross_angular += other.gross_angular;
    }
}

#[cfg(test)]
mod tests;
