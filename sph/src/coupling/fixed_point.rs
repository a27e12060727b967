//! The fixed point of a half-step with implicit coupling: relaxed forces on the samples of each body.
//!
//! The forces F of a stage belong to samples that the forces F' have moved there. A body has settled when both agree.
//! Samples of different bodies do not feel each other within a stage, whose fluid is given: each body has a fixed point, and
//! a relaxation, of its own.

use crate::coupling::exchange::InterfaceStates;
use crate::setup::{Iterate, Relaxation};
use crate::space::Vector;

/// First factor of Aitken's relaxation in a half-step, before there are two residuals: enough for most bodies.
const FIRST_FACTOR: f64 = 1.0;

/// Bounds of Aitken's factor. Forces that resist motion ask for 1/(1 + λ) with λ > 0; outside of them two residuals that
/// happen to be alike, or a body that meets the fluid only now, make it meaningless.
const FACTORS: (f64, f64) = (1e-3, 1.0);

/// The fixed-point iteration of one half-step.
#[derive(Debug)]
pub(crate) struct FixedPoint {
    plan: Iterate,
    /// Ids of the samples, ascending.
    id: Vec<u32>,
    /// F' on each sample \[N/m\].
    applied: Vec<Vector>,
    /// F − F' of the latest iteration \[N/m\].
    residual: Vec<Vector>,
    /// By body.
    bodies: Vec<Body>,
}

/// The relaxation of one body.
#[derive(Clone, Copy, Debug, Default)]
struct Body {
    /// ω, once there is one.
    factor: Option<f64>,
    /// Largest Σ|F| so far, from the start of the step on \[N/m\].
    scale: f64,
    /// Σ|F| and Σ|F − F'| \[N/m\].
    gross: f64,
    off: f64,
    /// Σ r·Δr and Σ Δr² over two iterations \[N²/m²\].
    along: f64,
    change: f64,
}

impl FixedPoint {
    pub(crate) fn new(plan: Iterate) -> Self {
        Self { plan, id: Vec::new(), applied: Vec::new(), residual: Vec::new(), bodies: Vec::new() }
    }

    /// Begins a step, whose predictor has moved `samples` by `forces` \[N/m\]. Nothing of the step before is kept.
    pub(crate) fn begin(&mut self, samples: &InterfaceStates, forces: &[Vector]) {
        self.id.clone_from(&samples.id);
        self.applied.clear();
        self.applied.extend_from_slice(forces);
        self.residual.clear();
        self.bodies.clear();
        for (force, group) in forces.iter().zip(&samples.group) {
            body(&mut self.bodies, *group).scale += force.norm();
        }
    }

    /// Takes the `forces` \[N/m\] that came for `samples`; returns the largest Σ|F − F'| of a body over its
    /// largest Σ|F| since the start of the step \[-\].
    pub(crate) fn compare(&mut self, samples: &InterfaceStates, forces: &[Vector]) -> f64 {
        let first = self.residual.is_empty();
        self.align(&samples.id);
        for body in &mut self.bodies {
            *body = Body { factor: body.factor, scale: body.scale, ..Body::default() };
        }
        for (k, (force, group)) in forces.iter().zip(&samples.group).enumerate() {
            let body = body(&mut self.bodies, *group);
            let residual = force - self.applied[k];
            let change = residual - self.residual[k];
            body.gross += force.norm();
            body.off += residual.norm();
            body.along += self.residual[k].dot(&change);
            body.change += change.norm_squared();
            self.residual[k] = residual;
        }
        for body in &mut self.bodies {
            body.factor = Some(self.plan.relaxation.factor(body, first));
            body.scale = body.scale.max(body.gross);
        }
        let ratio = |body: &Body| if body.off == 0.0 { 0.0 } else { body.off / body.scale };
        // A NaN is the largest of all.
        self.bodies.iter().map(ratio).fold(0.0, |a, b| if b <= a { a } else { b })
    }

    /// Whether a half-step of this residual is done.
    pub(crate) fn settled(&self, residual: f64) -> bool {
        residual <= self.plan.tolerance
    }

    /// Forces to move the samples by in the next iteration \[N/m\], those of the last comparison in their order.
    pub(crate) fn relaxed(&mut self, samples: &InterfaceStates) -> &[Vector] {
        for (k, group) in samples.group.iter().enumerate() {
            let factor = body(&mut self.bodies, *group).factor.unwrap_or(1.0);
            self.applied[k] += self.residual[k] * factor;
        }
        &self.applied
    }

    /// Brings what is kept into the order of the samples `id`; new ones felt nothing so far.
    fn align(&mut self, id: &[u32]) {
        self.residual.resize(self.id.len(), Vector::zeros());
        if self.id == id {
            return;
        }
        let place = |id: &u32| self.id.binary_search(id).ok();
        let kept = |values: &[Vector]| -> Vec<Vector> {
            id.iter().map(|id| place(id).map_or_else(Vector::zeros, |k| values[k])).collect()
        };
        (self.applied, self.residual) = (kept(&self.applied), kept(&self.residual));
        self.id = id.to_vec();
    }
}

/// The body of `group`.
fn body(bodies: &mut Vec<Body>, group: u32) -> &mut Body {
    let k = group as usize;
    if bodies.len() <= k {
        bodies.resize(k + 1, Body::default());
    }
    &mut bodies[k]
}

impl Relaxation {
    /// ω of `body` in its first or a later iteration.
    ///
    /// ```text
    /// ωₖ = −ωₖ₋₁ rₖ₋₁ · (rₖ − rₖ₋₁) / |rₖ − rₖ₋₁|²
    /// ```
    fn factor(self, body: &Body, first: bool) -> f64 {
        match (self, body.factor) {
            (Self::Fixed(factor), _) => factor,
            (Self::Aitken, Some(before)) if !first && body.change > 0.0 => {
                (-before * body.along / body.change).clamp(FACTORS.0, FACTORS.1)
            }
            (Self::Aitken, before) => before.unwrap_or(FIRST_FACTOR),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::Unsettled;

    /// A linear problem: the force on sample k is aₖ − Σ_l Kₖₗ F'ₗ.
    struct Linear {
        samples: InterfaceStates,
        free: Vec<Vector>,
        /// λ of each body.
        slope: Vec<f64>,
    }

    impl Linear {
        fn new(slopes: &[f64]) -> Self {
            let mut samples = InterfaceStates::default();
            let mut free = Vec::new();
            for k in 0..6u32 {
                samples.id.push(10 * k);
                samples.group.push(k % slopes.len() as u32);
                free.push(Vector::new(1.0 + f64::from(k), 0.3 * f64::from(k)));
            }
            Self { samples, free, slope: slopes.to_vec() }
        }

        fn forces(&self, applied: &[Vector]) -> Vec<Vector> {
            let slope = |k: usize| self.slope[self.samples.group[k] as usize];
            (0..applied.len()).map(|k| self.free[k] - applied[k] * slope(k)).collect()
        }

        /// a/(1 + λ).
        fn fixed_point(&self, k: usize) -> Vector {
            self.free[k] / (1.0 + self.slope[self.samples.group[k] as usize])
        }

        /// Number of revisions until settled, and the forces there.
        fn solve(&self, relaxation: Relaxation, limit: u32) -> Option<(u32, Vec<Vector>)> {
            let plan = Iterate { relaxation, tolerance: 1e-10, limit, unsettled: Unsettled::Stop };
            let mut fixed_point = FixedPoint::new(plan);
            let mut applied = vec![Vector::new(0.5, 0.0); self.free.len()];
            fixed_point.begin(&self.samples, &applied);
            for k in 0..=limit {
                let forces = self.forces(&applied);
                let residual = fixed_point.compare(&self.samples, &forces);
                if fixed_point.settled(residual) {
                    return Some((k, forces));
                }
                applied = fixed_point.relaxed(&self.samples).to_vec();
            }
            None
        }
    }

    #[test]
    fn aitken_finds_the_fixed_point_where_plain_iteration_diverges() {
        // The plain fixed point grows by λ = 5 each time; a factor below 2/(1 + λ) converges slowly.
        let problem = Linear::new(&[5.0]);
        assert!(problem.solve(Relaxation::Fixed(1.0), 100).is_none());
        let (slow, _) = problem.solve(Relaxation::Fixed(0.25), 100).expect("0.25 < 2/6");
        let (count, forces) = problem.solve(Relaxation::Aitken, 100).expect("linear problem");
        // Along one direction the second factor is exact; round-off takes one more.
        assert!(count <= 3 && count < slow, "{count} against {slow} iterations");
        for (k, force) in forces.iter().enumerate() {
            let error = (force - problem.fixed_point(k)).norm();
            assert!(error < 1e-8, "force {k} is off by {error}");
        }
    }

    #[test]
    fn each_body_has_a_relaxation_of_its_own() {
        // One factor for both would be bounded by the stiff body and leave 1 - 1/21 of the other's error each time.
        let problem = Linear::new(&[20.0, 0.1]);
        let (count, _) = problem.solve(Relaxation::Aitken, 100).expect("linear problem");
        assert!(count <= 3, "{count} iterations");
    }

    #[test]
    fn samples_that_come_and_go_keep_their_forces() {
        let plan = Iterate {
            relaxation: Relaxation::Fixed(0.5),
            tolerance: 1e-3,
            limit: 9,
            unsettled: Unsettled::Stop,
        };
        let samples = |ids: &[u32]| InterfaceStates {
            id: ids.to_vec(),
            group: vec![0; ids.len()],
            ..InterfaceStates::default()
        };
        let force = |x: f64| Vector::new(x, 0.0);
        let mut fixed_point = FixedPoint::new(plan);
        fixed_point.begin(&samples(&[3, 5]), &[force(1.0), force(2.0)]);
        let next = samples(&[4, 5]);
        // 4 is new and felt 0, 5 felt 2; the one that left counts no more.
        let residual = fixed_point.compare(&next, &[force(0.5), force(3.0)]);
        assert!((residual - 1.5 / 3.5).abs() < 1e-15, "{residual}");
        assert_eq!(fixed_point.relaxed(&next), [force(0.25), force(2.5)]);
    }

    #[test]
    fn a_body_without_forces_has_settled_and_a_nan_never_has() {
        let problem = Linear::new(&[1.0]);
        let plan =
            Iterate { relaxation: Relaxation::Aitken, tolerance: 1.0, limit: 9, unsettled: Unsettled::Stop };
        let mut fixed_point = FixedPoint::new(plan);
        let none = vec![Vector::zeros(); 6];
        fixed_point.begin(&problem.samples, &none);
        assert_eq!(fixed_point.compare(&problem.samples, &none), 0.0);
        let mut broken = none;
        broken[2].x = f64::NAN;
        let residual = fixed_point.compare(&problem.samples, &broken);
        assert!(!fixed_point.settled(residual), "{residual}");
    }
}
