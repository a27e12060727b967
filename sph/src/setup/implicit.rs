//! How a half-step is iterated.

/// An iterated half-step of a solid that is coupled by loads: its state at n+½ is that which the fluid's forces at n+½
/// make, v½ = vₙ + ½Δt a(F(x½, v½)), in place of F(xₙ, vₙ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iterate {
    /// How forces are taken over from one iteration to the next.
    pub relaxation: Relaxation,
    /// Largest Σ|F − F'| of a body, over its largest Σ|F| since the start of the step, between the forces F that the fluid
    /// returns for its samples and F' that moved them there \[-\].
    pub tolerance: f64,
    /// Most times that the samples of a half-step are revised, at least 1.
    pub limit: u32,
    /// What becomes of a half-step that has not settled by then.
    pub unsettled: Unsettled,
}

/// How forces are taken over from one iteration to the next: F' + ω (F − F').
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relaxation {
    /// ω in (0, 1].
    Fixed(f64),
    /// ω of each body from its last two iterations (Irons & Tuck 1969).
    Aitken,
}

/// What becomes of a half-step that has not settled at the limit of its iterations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsettled {
    /// The run ends.
    Stop,
    /// The last iterate is accepted and counted.
    Accept,
}
