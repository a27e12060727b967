//! Neighbours of a body in its undeformed configuration: fixed lists, weights and correction matrices.

use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::space::domain::Domain;
use sph::space::tensors::{SpaceTensor, SpaceVector};

use crate::neighbours::stencil::Stencils;
use crate::space::{SolidSpace, Span};

/// A neighbour in the reference configuration.
#[derive(Clone, Copy, Debug)]
pub struct ReferencePair<S: SolidSpace> {
    /// Index of the neighbour within the body.
    pub neighbour: u32,
    pub kind: PairKind,
    /// a_ij = −V_i V_j (dW/dr)/r at the reference distance \[-\], the same number from either side.
    pub weight: f64,
    /// X_ij \[m\]; X_ib of the boundary point where one particle is anchored.
    pub separation: S::Vector,
}

/// Kind of a pair, which decides the sums that it enters.
///
/// A particle that is held throughout the run is anchored: its material is rigid. The neighbour of a free particle is then
/// not the anchored particle but a boundary point half-way to it, which moves with the anchored ones: so a clamp acts at
/// the face midway between the last held and the first free row, not up to a spacing behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairKind {
    /// Both are free, or both anchored.
    Inner,
    /// The neighbour is anchored.
    ToAnchor,
    /// The particle is anchored, the neighbour free: a force alone.
    FromAnchor,
}

/// Correction of the gradient at a particle.
#[derive(Clone, Copy, Debug)]
pub struct Correction<S: SolidSpace> {
    /// Inverse of Σ_j a_ij X_ij ⊗ X_ij, zero along a direction without neighbours \[1/m²\].
    pub inverse: S::Tensor,
    /// The directions with neighbours.
    span: Span<S::Vector>,
}

/// The reference configuration of a body.
#[derive(Debug)]
pub struct Reference<S: SolidSpace> {
    offsets: Vec<u32>,
    pairs: Vec<ReferencePair<S>>,
    /// The pairs of [`PairKind::Inner`], for sums four at a time.
    pub stencils: Stencils<S>,
    /// Whether a particle has pairs of another kind.
    bordering: Vec<bool>,
    pub corrections: Vec<Correction<S>>,
    /// Whether each particle is held throughout the run.
    pub anchored: Vec<bool>,
    /// Reference volumes per depth V \[m²\].
    pub volume: Vec<f64>,
}

impl<S: SolidSpace> Reference<S> {
    /// Neighbours of particle `i`, ascending.
    #[inline]
    pub fn of(&self, i: usize) -> &[ReferencePair<S>] {
        &self.pairs[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Pairs of particle `i` between anchored and free particles.
    #[inline]
    pub fn across_border(&self, i: usize) -> impl Iterator<Item = &ReferencePair<S>> {
        let row = if self.bordering[i] { self.of(i) } else { &[] };
        row.iter().filter(|pair| pair.kind != PairKind::Inner)
    }

    /// Gradient at particle `i` of a field that changes by `change` from its neighbour or boundary point to itself.
    ///
    /// ```text
    /// (Σ_j a_ij u_ij ⊗ X_ij) (Σ_j a_ij X_ij ⊗ X_ij)⁻¹
    /// ```
    /// Exact for linear fields wherever the neighbours span the plane or space.
    #[inline]
    pub fn gradient(&self, i: usize, change: impl Fn(&ReferencePair<S>) -> S::Vector) -> S::Tensor {
        moment(self.of(i).iter(), change) * self.corrections[i].inverse
    }

    /// Deformation gradient F of particle `i` \[-\] when its neighbours are at `x_ij` \[m\].
    ///
    /// Along a direction without neighbours the material turns with the rest and is not strained.
    #[inline]
    pub fn deformation_gradient(&self, i: usize, x_ij: impl Fn(&ReferencePair<S>) -> S::Vector) -> S::Tensor {
        self.deformation_of(i, &moment(self.of(i).iter(), x_ij))
    }

    /// F of particle `i` \[-\] from Σ_j a_ij x_ij ⊗ X_ij.
    #[inline]
    fn deformation_of(&self, i: usize, moment: &S::Tensor) -> S::Tensor {
        S::completed(*moment * self.corrections[i].inverse, &self.corrections[i].span)
    }
}

impl<S: SolidSpace> Reference<S> {
    /// Particles at `position` \[m\] with volumes `volume` \[m²\] and a stencil of the support of `kernel`.
    pub fn new(
        domain: &Domain<S>,
        position: &[S::Vector],
        volume: Vec<f64>,
        anchored: Vec<bool>,
        kernel: &CubicSpline<S>,
    ) -> Self {
        let radius = kernel.support_radius();
        let list = CellGrid::new(domain, position, radius).list_among(domain, position, radius);
        let mut offsets = vec![0];
        let mut pairs = Vec::new();
        let mut corrections = Vec::new();
        let mut stencils = Stencils::new();
        let mut bordering = Vec::new();
        for i in 0..position.len() {
            let start = pairs.len();
            for &j in list.of(i) {
                let separation = domain.separation(&position[i], &position[j as usize]);
                let weight = -volume[i] * volume[j as usize] * kernel.gradient_factor(separation.norm());
                if weight > 0.0 {
                    let kind = PairKind::between(&anchored, i, j as usize);
                    pairs.push(ReferencePair::new(j, kind, weight, separation));
                }
            }
            pairs[start..].sort_unstable_by_key(|pair| pair.neighbour);
            // Pairs of one body stay far below 2^32.
            offsets.push(pairs.len() as u32);
            let row = &pairs[start..];
            corrections.push(Correction::of(row));
            let inner = row.iter().filter(|pair| pair.kind == PairKind::Inner);
            stencils.push(inner.map(|pair| (pair.neighbour, pair.weight, pair.separation)));
            bordering.push(row.iter().any(|pair| pair.kind != PairKind::Inner));
        }
        Self { offsets, pairs, stencils, bordering, corrections, anchored, volume }
    }

    /// The same from Σ_j a_ij x_ij ⊗ X_ij over the inner pairs alone, for particles at `position` \[m\].
    #[inline]
    pub fn completed(
        &self,
        domain: &Domain<S>,
        position: &[S::Vector],
        i: usize,
        inner: &S::Tensor,
    ) -> S::Tensor {
        let x_ij = |pair: &ReferencePair<S>| self.separation(domain, position, i, pair);
        self.deformation_of(i, &(*inner + moment(self.across_border(i), x_ij)))
    }

    /// x_ij \[m\] of `pair` of particle `i`, for particles at `position` \[m\].
    ///
    /// Boundary points turn with the anchored particles around theirs.
    #[inline]
    pub fn separation(
        &self,
        domain: &Domain<S>,
        position: &[S::Vector],
        i: usize,
        pair: &ReferencePair<S>,
    ) -> S::Vector {
        let j = pair.neighbour as usize;
        match pair.kind {
            PairKind::Inner => domain.separation(&position[i], &position[j]),
            PairKind::ToAnchor => self.boundary_separation(domain, position, i, j, &pair.separation),
            PairKind::FromAnchor => -self.boundary_separation(domain, position, j, i, &-pair.separation),
        }
    }

    /// x_ib \[m\] of free particle `i` for its boundary point with anchored particle `j`, `separation` X_ib \[m\].
    fn boundary_separation(
        &self,
        domain: &Domain<S>,
        position: &[S::Vector],
        i: usize,
        j: usize,
        separation: &S::Vector,
    ) -> S::Vector {
        let among_anchored =
            |pair: &ReferencePair<S>| domain.separation(&position[j], &position[pair.neighbour as usize]);
        let turn = self.deformation_gradient(j, among_anchored);
        domain.separation(&position[i], &position[j]) - turn * *separation
    }
}

/// Σ_j a_ij u_ij ⊗ X_ij of `pairs` with `change` u_ij; forces alone go from the anchored to the free.
#[inline]
fn moment<'a, S: SolidSpace>(
    pairs: impl Iterator<Item = &'a ReferencePair<S>>,
    change: impl Fn(&ReferencePair<S>) -> S::Vector,
) -> S::Tensor {
    pairs
        .filter(|pair| pair.kind != PairKind::FromAnchor)
        .map(|pair| S::Tensor::outer(&change(pair), &(pair.separation * pair.weight)))
        .sum()
}

impl PairKind {
    fn between(anchored: &[bool], i: usize, j: usize) -> Self {
        match (anchored[i], anchored[j]) {
            (false, true) => Self::ToAnchor,
            (true, false) => Self::FromAnchor,
            _ => Self::Inner,
        }
    }
}

impl<S: SolidSpace> ReferencePair<S> {
    fn new(neighbour: u32, kind: PairKind, weight: f64, separation: S::Vector) -> Self {
        let (factor, part) = if kind == PairKind::Inner { (1.0, 1.0) } else { (S::BOUNDARY_WEIGHT, 0.5) };
        Self { neighbour, kind, weight: weight * factor, separation: separation * part }
    }
}

impl<S: SolidSpace> Correction<S> {
    fn of(pairs: &[ReferencePair<S>]) -> Self {
        let moment = moment(pairs.iter(), |pair| pair.separation);
        let span = S::span(&moment);
        let inverse = match &span {
            Span::All => moment.cofactor().transpose() / moment.determinant(),
            // Regular with a part along the normal, which is taken out again.
            Span::Surface { normal, moment: size } => {
                let across = S::Tensor::outer(normal, normal);
                let regular = moment + across * *size;
                regular.cofactor().transpose() / regular.determinant() - across / *size
            }
            Span::Line { direction, moment } => S::Tensor::outer(direction, direction) / *moment,
            Span::None => S::Tensor::zeros(),
        };
        Self { inverse, span }
    }
}
