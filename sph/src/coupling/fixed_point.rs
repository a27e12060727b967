//! The fixed point of a half-step with implicit coupling: relaxed forces on the coupling points of each body.
//!
//! The forces F of a stage act on points that the forces F' have moved there. A body has converged when both agree.
//! Points of different bodies do not feel each other within a stage, whose fluid is given: each body has a fixed point, and
//! a relaxation, of its own.

use crate::coupling::exchange::{Column, StateColumns};
use crate::setup::{ImplicitCoupling, Relaxation};

crate::constants! {
    /// Enough for most bodies.
    const FIRST_FACTOR: f64 = 1.0, "implicit.first_factor",
        "first factor of Aitken relaxation in a half-step, before there are two residuals [-]";
    /// Forces that resist motion ask for 1/(1 + λ) with λ > 0; outside of the bounds two residuals that happen to be
    /// alike, or a body that meets the fluid only now, make the factor meaningless.
    const SMALLEST_FACTOR: f64 = 1e-3, "implicit.smallest_factor", "smallest factor of Aitken relaxation [-]";
    const LARGEST_FACTOR: f64 = 1.0, "implicit.largest_factor", "largest factor of Aitken relaxation [-]";
}

/// The fixed-point iteration of one half-step.
#[derive(Debug)]
pub(crate) struct FixedPoint {
    plan: ImplicitCoupling,
    /// Ids of the coupling points, ascending.
    id: Vec<u32>,
    /// F' on each point \[N\].
    applied: Column,
    /// F − F' of the latest iteration \[N\].
    residual: Column,
    /// By body.
    bodies: Vec<Body>,
}

/// The relaxation of one body.
#[derive(Clone, Copy, Debug, Default)]
struct Body {
    /// ω, once there is one.
    factor: Option<f64>,
    /// Largest Σ|F| so far, from the start of the step on \[N\].
    scale: f64,
    /// Σ|F| and Σ|F − F'| \[N\].
    gross: f64,
    off: f64,
    /// Σ r·Δr and Σ Δr² over two iterations \[N²\].
    along: f64,
    change: f64,
}

impl FixedPoint {
    pub(crate) fn new(plan: ImplicitCoupling) -> Self {
        let (applied, residual) = (Column::default(), Column::default());
        Self { plan, id: Vec::new(), applied, residual, bodies: Vec::new() }
    }

    /// Begins a step, whose predictor has moved `points` by `forces` \[N\]. Nothing of the step before is kept.
    pub(crate) fn begin(&mut self, points: &StateColumns, forces: &Column) {
        self.id.clone_from(&points.id);
        self.applied.clone_from(forces);
        self.residual.values.clear();
        self.bodies.clear();
        for (force, group) in forces.rows().zip(&points.group) {
            body(&mut self.bodies, *group).scale += dot(force, force).sqrt();
        }
    }

    /// Takes the `forces` \[N\] that came for `points`; returns the largest Σ|F − F'| of a body over its
    /// largest Σ|F| since the start of the step \[-\].
    pub(crate) fn compare(&mut self, points: &StateColumns, forces: &Column) -> f64 {
        let first = self.residual.is_empty();
        self.align(&points.id, forces.components);
        for body in &mut self.bodies {
            *body = Body { factor: body.factor, scale: body.scale, ..Body::default() };
        }
        let width = forces.components.max(1);
        let before = self.residual.values.chunks_exact_mut(width);
        for (((force, group), applied), before) in
            forces.rows().zip(&points.group).zip(self.applied.rows()).zip(before)
        {
            let body = body(&mut self.bodies, *group);
            let (mut off, mut along, mut change) = (0.0, 0.0, 0.0);
            for ((force, applied), before) in force.iter().zip(applied).zip(before) {
                let residual = force - applied;
                let difference = residual - *before;
                off += residual * residual;
                along += *before * difference;
                change += difference * difference;
                *before = residual;
            }
            body.gross += dot(force, force).sqrt();
            body.off += off.sqrt();
            body.along += along;
            body.change += change;
        }
        for body in &mut self.bodies {
            body.factor = Some(self.plan.relaxation.factor(body, first));
            body.scale = body.scale.max(body.gross);
        }
        let ratio = |body: &Body| if body.off == 0.0 { 0.0 } else { body.off / body.scale };
        // A NaN is the largest of all.
        self.bodies.iter().map(ratio).fold(0.0, |a, b| if b <= a { a } else { b })
    }

    /// Whether a half-step of this residual has converged.
    pub(crate) fn converged(&self, residual: f64) -> bool {
        residual <= self.plan.tolerance
    }

    /// Forces to move the points by in the next iteration \[N\], those of the last comparison in their order.
    pub(crate) fn relaxed(&mut self, points: &StateColumns) -> &Column {
        let applied = self.applied.values.chunks_exact_mut(self.applied.components.max(1));
        for ((applied, residual), group) in applied.zip(self.residual.rows()).zip(&points.group) {
            let factor = body(&mut self.bodies, *group).factor.unwrap_or(1.0);
            applied.iter_mut().zip(residual).for_each(|(applied, residual)| *applied += residual * factor);
        }
        &self.applied
    }

    /// Brings what is kept into the order of the points `id`; new ones felt nothing so far.
    fn align(&mut self, id: &[u32], components: usize) {
        self.residual.components = components;
        self.residual.values.resize(self.id.len() * components, 0.0);
        if self.id == id {
            return;
        }
        let zeros = vec![0.0; components];
        let kept = |column: &Column| -> Column {
            let row = |id| self.id.binary_search(id).map_or(&*zeros, |k| column.row(k));
            Column { components, values: id.iter().flat_map(row).copied().collect() }
        };
        (self.applied, self.residual) = (kept(&self.applied), kept(&self.residual));
        self.id = id.to_vec();
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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
                (-before * body.along / body.change).clamp(SMALLEST_FACTOR, LARGEST_FACTOR)
            }
            (Self::Aitken, before) => before.unwrap_or(FIRST_FACTOR),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::NonConvergence;

    fn column(rows: impl IntoIterator<Item = [f64; 2]>) -> Column {
        rows.into_iter().collect()
    }

    /// A linear problem: the force on point k is aₖ − Σ_l Kₖₗ F'ₗ.
    struct Linear {
        points: StateColumns,
        free: Column,
        /// λ of each body.
        slope: Vec<f64>,
    }

    impl Linear {
        fn new(slopes: &[f64]) -> Self {
            let mut points = StateColumns::default();
            for k in 0..6u32 {
                points.id.push(10 * k);
                points.group.push(k % slopes.len() as u32);
            }
            let free = column((0..6).map(|k| [1.0 + f64::from(k), 0.3 * f64::from(k)]));
            Self { points, free, slope: slopes.to_vec() }
        }

        fn slope(&self, k: usize) -> f64 {
            self.slope[self.points.group[k] as usize]
        }

        fn forces(&self, applied: &Column) -> Column {
            let (free, applied) = (self.free.quantities(), applied.quantities());
            column(free.zip(applied).enumerate().map(
                |(k, ([x, y], [u, v])): (usize, ([f64; 2], [f64; 2]))| {
                    let slope = self.slope(k);
                    [x - u * slope, y - v * slope]
                },
            ))
        }

        /// a/(1 + λ).
        fn fixed_point(&self, k: usize) -> [f64; 2] {
            [0, 1].map(|axis| self.free.row(k)[axis] / (1.0 + self.slope(k)))
        }

        /// Number of updates until convergence, and the forces there.
        fn solve(&self, relaxation: Relaxation, limit: u32) -> Option<(u32, Column)> {
            let plan = ImplicitCoupling {
                relaxation,
                tolerance: 1e-10,
                limit,
                non_convergence: NonConvergence::Stop,
            };
            let mut fixed_point = FixedPoint::new(plan);
            let mut applied = column([[0.5, 0.0]; 6]);
            fixed_point.begin(&self.points, &applied);
            for k in 0..=limit {
                let forces = self.forces(&applied);
                let residual = fixed_point.compare(&self.points, &forces);
                if fixed_point.converged(residual) {
                    return Some((k, forces));
                }
                applied = fixed_point.relaxed(&self.points).clone();
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
        for (k, force) in forces.rows().enumerate() {
            for (value, expected) in force.iter().zip(problem.fixed_point(k)) {
                assert!((value - expected).abs() < 1e-8, "force {k} is {value}, not {expected}");
            }
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
    fn points_that_come_and_go_keep_their_forces() {
        let plan = ImplicitCoupling {
            relaxation: Relaxation::Fixed(0.5),
            tolerance: 1e-3,
            limit: 9,
            non_convergence: NonConvergence::Stop,
        };
        let points = |ids: &[u32]| StateColumns {
            id: ids.to_vec(),
            group: vec![0; ids.len()],
            ..StateColumns::default()
        };
        let forces = |x: [f64; 2]| column(x.map(|x| [x, 0.0]));
        let mut fixed_point = FixedPoint::new(plan);
        fixed_point.begin(&points(&[3, 5]), &forces([1.0, 2.0]));
        let next = points(&[4, 5]);
        // 4 is new and felt 0, 5 felt 2; the one that left counts no more.
        let residual = fixed_point.compare(&next, &forces([0.5, 3.0]));
        assert!((residual - 1.5 / 3.5).abs() < 1e-15, "{residual}");
        assert_eq!(fixed_point.relaxed(&next), &forces([0.25, 2.5]));
    }

    #[test]
    fn a_body_without_forces_has_converged_and_a_nan_never_has() {
        let problem = Linear::new(&[1.0]);
        let plan = ImplicitCoupling {
            relaxation: Relaxation::Aitken,
            tolerance: 1.0,
            limit: 9,
            non_convergence: NonConvergence::Stop,
        };
        let mut fixed_point = FixedPoint::new(plan);
        let none = column([[0.0; 2]; 6]);
        fixed_point.begin(&problem.points, &none);
        assert_eq!(fixed_point.compare(&problem.points, &none), 0.0);
        let mut broken = none;
        broken.values[4] = f64::NAN;
        let residual = fixed_point.compare(&problem.points, &broken);
        assert!(!fixed_point.converged(residual), "{residual}");
    }
}
