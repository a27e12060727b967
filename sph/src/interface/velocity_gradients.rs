//! Velocity gradients of bodies at their interface particles, which lie behind the face.

use super::lists::{Rows, Search, TASK};
use super::pair_law::PairLaw;
use super::states::InterfaceStates;
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};
use crate::tasks::for_each;

crate::constants! {
    /// Of a lattice of two rows the smaller moment is 0.55 of the larger one, of one row bent to a radius of five spacings 0.015.
    const LEAST_MOMENT: f64 = 0.1, "interface.least_moment",
        "second moment of the particles of a body around one of them, over the largest, from which on its velocity is fitted along that direction [-]";
}

/// Velocity gradients at the states of a solid, row = component of the velocity; buffers are reused.
///
/// ```text
/// A = Σ_t W_st x_ts ⊗ x_ts,   P = A⁺A,   N = 1 − P,   H = Σ_t W_st v_ts ⊗ x_ts A⁺,   G = H − Hᵀ N
/// ```
/// over the particles t of the same body that face the fluid too. The least-squares fit H is exact where the velocity is linear.
/// A plate of one row has no extent along its normal N: −Hᵀ N turns the normal with the plate.
#[derive(Debug, Default)]
pub struct VelocityGradients<S: Space> {
    search: Search<S>,
    rows: Rows,
    gradients: Vec<S::Tensor>,
}

impl<S: Space> VelocityGradients<S> {
    /// Fits the gradients of the states of `solid` whose row in `of_solid` is not empty; those of the others are zero.
    ///
    /// States without fluid within support are not used, as a partner need not have sent them.
    pub fn update(
        &mut self,
        law: &PairLaw<S>,
        domain: &Domain<S>,
        solid: &InterfaceStates<S>,
        of_solid: &Rows,
    ) {
        let Self { search, rows, gradients } = self;
        let faces_fluid = |s: usize| !of_solid.of(s).is_empty();
        search.fill(domain, law.support_radius(), [solid, solid], faces_fluid, rows);
        gradients.clear();
        gradients.resize(solid.len(), S::Tensor::zeros());
        let rows = &*rows;
        for_each(&mut gradients[..], TASK, |s, gradient| {
            if !faces_fluid(s) {
                return;
            }
            let (mut moments, mut products) = (S::Tensor::zeros(), S::Tensor::zeros());
            for t in rows.of(s).iter().map(|pair| pair.other as usize) {
                if solid.group[t] == solid.group[s] && faces_fluid(t) {
                    let x_ts = domain.separation(&solid.position[t], &solid.position[s]);
                    let weighted = x_ts * law.weight(x_ts.norm());
                    moments += S::Tensor::outer(&weighted, &x_ts);
                    products += S::Tensor::outer(&(solid.velocity[t] - solid.velocity[s]), &weighted);
                }
            }
            let moments = S::SymmetricTensor::of(&moments);
            let least = LEAST_MOMENT * moments.extremes()[0];
            let inverse = moments.map_principal(|moment| if moment > least { 1.0 / moment } else { 0.0 });
            let across = moments.map_principal(|moment| if moment > least { 0.0 } else { 1.0 });
            let fitted = products * inverse.full();
            *gradient = fitted - fitted.transpose() * across.full();
        });
    }

    /// Gradient at state `s` \[1/s\]; `None` where it was never asked for.
    pub fn at(&self, s: usize) -> Option<&S::Tensor> {
        self.gradients.get(s)
    }
}
