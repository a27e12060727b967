//! Terms of a pair sum, chosen when it is compiled.

/// Optional terms of a pair sum, fixed at compile time.
pub trait PairTerms: Copy + Send + Sync {
    /// Results of the gradient pass that neighbours read: ψ of Eq. (19) has its bracket. Without them, ψ is that
    /// of Molteni & Colagrossi (2009).
    const NEIGHBOUR_FIELDS: bool;
    /// Each particle carries T = −σ·L instead of a pressure.
    const TENSOR: bool;
    /// Eq. (17), with L_i or the unit matrix.
    const CONTINUITY: bool;
    /// A viscous pair force.
    const VISCOUS: bool;
}

/// [`PairTerms`] by flags.
#[derive(Clone, Copy, Debug)]
struct CompiledTerms<
    const NEIGHBOUR_FIELDS: bool,
    const TENSOR: bool,
    const CONTINUITY: bool,
    const VISCOUS: bool,
>;

impl<const NEIGHBOUR_FIELDS: bool, const TENSOR: bool, const CONTINUITY: bool, const VISCOUS: bool> PairTerms
    for CompiledTerms<NEIGHBOUR_FIELDS, TENSOR, CONTINUITY, VISCOUS>
{
    const NEIGHBOUR_FIELDS: bool = NEIGHBOUR_FIELDS;
    const TENSOR: bool = TENSOR;
    const CONTINUITY: bool = CONTINUITY;
    const VISCOUS: bool = VISCOUS;
}

/// Optional terms of the momentum equation.
#[derive(Clone, Copy, Debug)]
pub struct ForceTerms {
    /// T = −σ·L instead of a pressure.
    pub tensor: bool,
    /// The viscous pair force.
    pub viscous: bool,
}

/// Optional terms of a pair sum.
#[derive(Clone, Copy, Debug)]
pub struct ActiveTerms {
    /// Results of the gradient pass that neighbours read.
    pub neighbour_fields: bool,
    /// Eq. (17).
    pub continuity: bool,
    /// Eq. (22).
    pub forces: ForceTerms,
}

/// A pass that is compiled for each combination of terms.
pub trait TermsPass {
    /// Its result.
    type Output;

    /// Runs the pass.
    fn call<T: PairTerms>(self) -> Self::Output;
}

impl ForceTerms {
    /// Runs `pass` with these terms alone.
    pub fn call<P: TermsPass>(self, pass: P) -> P::Output {
        self.with::<P, false, false>(pass)
    }

    fn with<P: TermsPass, const NEIGHBOUR_FIELDS: bool, const CONTINUITY: bool>(self, pass: P) -> P::Output {
        match (self.tensor, self.viscous) {
            (false, false) => pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, false, CONTINUITY, false>>(),
            (false, true) => pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, false, CONTINUITY, true>>(),
            (true, false) => pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, true, CONTINUITY, false>>(),
            (true, true) => pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, true, CONTINUITY, true>>(),
        }
    }
}

impl ActiveTerms {
    /// Runs `pass` with these terms.
    pub fn call<P: TermsPass>(self, pass: P) -> P::Output {
        let Self { neighbour_fields, continuity, forces } = self;
        match (neighbour_fields, continuity) {
            (false, false) => forces.with::<P, false, false>(pass),
            (false, true) => forces.with::<P, false, true>(pass),
            (true, false) => forces.with::<P, true, false>(pass),
            (true, true) => forces.with::<P, true, true>(pass),
        }
    }
}
