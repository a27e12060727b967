//! Implicit coupling: how a half-step is iterated.

/// An iterated half-step of a solid with force coupling: its state at n+½ is the one produced by the fluid's forces at
/// n+½, v½ = vₙ + ½Δt a(F(x½, v½)), in place of F(xₙ, vₙ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitCoupling {
    /// How forces are taken over from one iteration to the next.
    pub relaxation: Relaxation,
    /// Largest Σ|F − F'| of a body, over its largest Σ|F| since the start of the step, between the forces F that the fluid
    /// returns for its coupling points and F' that moved them there \[-\].
    pub tolerance: f64,
    /// Largest number of updates of the coupling points in a half-step, at least 1.
    pub limit: u32,
    /// Treatment of a half-step that has not converged by then.
    pub non_convergence: NonConvergence,
}

/// How forces are taken over from one iteration to the next: F' + ω (F − F').
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relaxation {
    /// ω in (0, 1].
    Fixed(f64),
    /// ω of each body from its last two iterations (Irons & Tuck 1969).
    Aitken,
}

/// Treatment of a half-step that has not converged at the limit of its iterations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NonConvergence {
    /// The run ends.
    Stop,
    /// The last iteration is accepted and counted.
    Accept,
}
