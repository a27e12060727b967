//! Terms of a pair sum, chosen when it is compiled.

/// Optional terms of a pair sum, fixed at compile time.
pub trait PairTerms: Copy + Send + Sync {
    /// Results of the gradient pass that neighbours read: ψ of Eq. (19) has its bracket. Without them, ψ is that
    /// of Molteni & Colagrossi (2009).
    const NEIGHBOUR_FIELDS: bool;
    /// Each particle carries T = −σ·L instead of a pressure.
    const TENSOR: bool;
    /// T is a pressure times a symmetric tensor, and made of both pair by pair.
    const SYMMETRIC: bool;
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
    const SYMMETRIC: bool,
    const CONTINUITY: bool,
    const VISCOUS: bool,
>;

impl<
    const NEIGHBOUR_FIELDS: bool,
    const TENSOR: bool,
    const SYMMETRIC: bool,
    const CONTINUITY: bool,
    const VISCOUS: bool,
> PairTerms for CompiledTerms<NEIGHBOUR_FIELDS, TENSOR, SYMMETRIC, CONTINUITY, VISCOUS>
{
    const NEIGHBOUR_FIELDS: bool = NEIGHBOUR_FIELDS;
    const TENSOR: bool = TENSOR;
    const SYMMETRIC: bool = SYMMETRIC;
    const CONTINUITY: bool = CONTINUITY;
    const VISCOUS: bool = VISCOUS;
}

/// What each particle carries in the momentum equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceTerms {
    /// A pressure.
    Pressure,
    /// T = −σ·L of a pressure alone, which is symmetric and made of both pair by pair.
    SymmetricTensor,
    /// T = −σ·L.
    Tensor,
    /// T = −σ·L, and there is a viscous pair force.
    TensorAndDrag,
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
        match self {
            Self::Pressure => pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, false, false, CONTINUITY, false>>(),
            Self::SymmetricTensor => {
                pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, true, true, CONTINUITY, false>>()
            }
            Self::Tensor => pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, true, false, CONTINUITY, false>>(),
            Self::TensorAndDrag => {
                pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, true, false, CONTINUITY, true>>()
            }
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
