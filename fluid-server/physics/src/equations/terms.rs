//! Terms of a pair sum, chosen when it is compiled.

/// Optional terms of a pair sum, fixed at compile time.
pub trait PairTerms: Copy + Send + Sync {
    /// Results of the gradient pass that neighbours read: ψ of Eq. (19) has its bracket. Without them, ψ is that
    /// of Molteni & Colagrossi (2009).
    const NEIGHBOUR_FIELDS: bool;
    /// Each particle carries T = −σ·L instead of a pressure.
    const TENSOR: bool;
    /// Eq. (17).
    const CONTINUITY: bool;
    /// L_i in it.
    const CORRECTION: bool;
    /// A viscous pair force.
    const VISCOUS: bool;
}

/// [`PairTerms`] by flags.
#[derive(Clone, Copy, Debug)]
struct CompiledTerms<
    const NEIGHBOUR_FIELDS: bool,
    const TENSOR: bool,
    const CONTINUITY: bool,
    const CORRECTION: bool,
    const VISCOUS: bool,
>;

impl<
    const NEIGHBOUR_FIELDS: bool,
    const TENSOR: bool,
    const CONTINUITY: bool,
    const CORRECTION: bool,
    const VISCOUS: bool,
> PairTerms for CompiledTerms<NEIGHBOUR_FIELDS, TENSOR, CONTINUITY, CORRECTION, VISCOUS>
{
    const NEIGHBOUR_FIELDS: bool = NEIGHBOUR_FIELDS;
    const TENSOR: bool = TENSOR;
    const CONTINUITY: bool = CONTINUITY;
    const CORRECTION: bool = CORRECTION;
    const VISCOUS: bool = VISCOUS;
}

/// Eq. (17) in a pair sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Continuity {
    /// Absent.
    Absent,
    /// With the plain kernel gradient.
    Plain,
    /// With L_i.
    Corrected,
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
    pub continuity: Continuity,
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
        self.with::<P, false, false, false>(pass)
    }

    fn with<P: TermsPass, const NEIGHBOUR_FIELDS: bool, const CONTINUITY: bool, const CORRECTION: bool>(
        self,
        pass: P,
    ) -> P::Output {
        match (self.tensor, self.viscous) {
            (false, false) => {
                pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, false, CONTINUITY, CORRECTION, false>>()
            }
            (false, true) => {
                pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, false, CONTINUITY, CORRECTION, true>>()
            }
            (true, false) => {
                pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, true, CONTINUITY, CORRECTION, false>>()
            }
            (true, true) => {
                pass.call::<CompiledTerms<NEIGHBOUR_FIELDS, true, CONTINUITY, CORRECTION, true>>()
            }
        }
    }
}

impl ActiveTerms {
    /// Runs `pass` with these terms.
    pub fn call<P: TermsPass>(self, pass: P) -> P::Output {
        let Self { neighbour_fields, continuity, forces } = self;
        match (neighbour_fields, continuity) {
            (false, Continuity::Absent) => forces.with::<P, false, false, false>(pass),
            (false, Continuity::Plain) => forces.with::<P, false, true, false>(pass),
            (false, Continuity::Corrected) => forces.with::<P, false, true, true>(pass),
            (true, Continuity::Absent) => forces.with::<P, true, false, false>(pass),
            (true, Continuity::Plain) => forces.with::<P, true, true, false>(pass),
            (true, Continuity::Corrected) => forces.with::<P, true, true, true>(pass),
        }
    }
}
