//! Pair forces of a total-Lagrangian body one by one, and the frequency of its stiffest vibration.

use nalgebra::{DMatrix, DVector};
use sph::random::SplitMix64;
use sph::space::tensors::{SpaceTensor, SpaceVector};
use sph::sums::ordered_sum;
use sph::tasks::for_each;

use crate::neighbours::lists::TASK;
use crate::neighbours::reference::{PairKind, Reference, ReferencePair};
use crate::space::SolidSpace;

/// Units of pair forces.
///
/// They are sums in units of the hourglass modulus, so that an undeformed body at rest cancels to the last bit.
#[derive(Clone, Copy, Debug)]
pub struct ForceUnits {
    /// s: the modulus k of the hourglass control, or any other without it \[Pa\].
    pub modulus: f64,
    /// κ = k/s: 1 with hourglass control, 0 without \[-\].
    pub hourglass: f64,
}

impl ForceUnits {
    /// Units for hourglass control by `hourglass_modulus` \[Pa\] of a material of Young's modulus `young` \[Pa\].
    pub fn new(hourglass_modulus: f64, young: f64) -> Self {
        if hourglass_modulus > 0.0 {
            Self { modulus: hourglass_modulus, hourglass: 1.0 }
        } else {
            Self { modulus: young, hourglass: 0.0 }
        }
    }

    /// k \[Pa\].
    pub fn hourglass_modulus(&self) -> f64 {
        self.hourglass * self.modulus
    }
}

sph::constants! {
    /// Of a bar with a clamped end they give what a thousand rounds of power iteration give, to 1e-5.
    const ROUNDS: usize = 60, "solid.substeps.frequency_rounds",
        "rounds of the Lanczos iteration that finds the stiffest vibration of a body [-]";
}

impl<S: SolidSpace> Reference<S> {
    /// Tensor N_i of the pair forces \[-\] for particle `i` with deformation gradient `f` \[-\] and nominal stress `p` \[Pa\].
    ///
    /// ```text
    /// N = Q/s − κF,  Q_i = V_i P (Σ_j a_ij X_ij ⊗ X_ij)⁻¹
    /// ```
    /// Zero where the material is rigid, which has neither.
    #[inline]
    pub fn pair_tensor(&self, i: usize, f: &S::Tensor, p: &S::Tensor, units: &ForceUnits) -> S::Matrix<f64> {
        if self.anchored[i] {
            return S::zero_matrix();
        }
        let moment = *p * self.volume[i] * self.corrections[i].inverse / units.modulus;
        S::tensor_components(&(moment - *f * units.hourglass))
    }

    /// Contribution of the moment `moment` \[N\] about particle `i` to its N; zero where the material is rigid.
    #[inline]
    pub fn moment_pair_tensor(&self, i: usize, moment: &S::Tensor, units: &ForceUnits) -> S::Matrix<f64> {
        if self.anchored[i] {
            return S::zero_matrix();
        }
        S::tensor_components(&(*moment * self.corrections[i].inverse / units.modulus))
    }

    /// Largest angular frequency \[rad/s\] of small vibrations, for a linear stress law and masses `mass` \[kg/m\].
    ///
    /// Lanczos iteration from displacements without order, so that modes of every symmetry take part; with the bound of
    /// its error added, since a step beyond the limit makes energy without end.
    pub fn largest_frequency(
        &self,
        mass: &[f64],
        units: &ForceUnits,
        stress: impl Fn(&S::Tensor) -> S::Tensor + Sync,
    ) -> f64 {
        let n = mass.len();
        let product =
            |u: &[S::Vector], v: &[S::Vector]| ordered_sum::<f64, _>(n, |i| u[i].dot(&v[i]) * mass[i]);
        let mut random = SplitMix64(0);
        let mut u: Vec<S::Vector> = (0..n).map(|_| S::vector(S::axes(|_| random.symmetric()))).collect();
        u.iter_mut()
            .zip(&self.anchored)
            .filter(|(_, held)| **held)
            .for_each(|(u, _)| *u = S::Vector::zeros());
        let mut before = vec![S::Vector::zeros(); n];
        let mut length = product(&u, &u).sqrt();
        // Of the tridiagonal matrix; the first entry beside the diagonal belongs to no row.
        let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
        while length > 0.0 && diagonal.len() < ROUNDS {
            u.iter_mut().for_each(|u| *u = *u / length);
            let mut next = self.acceleration(&u, mass, units, &stress);
            beside.push(length);
            diagonal.push(-product(&u, &next));
            let (of_this, of_last) =
                (diagonal[diagonal.len() - 1], if diagonal.len() > 1 { length } else { 0.0 });
            for ((next, u), before) in next.iter_mut().zip(&u).zip(&before) {
                *next = -*next - *u * of_this - *before * of_last;
            }
            before = std::mem::replace(&mut u, next);
            length = product(&u, &u).sqrt();
            // What is left is round-off: the modes that take part are all found.
            if length <= f64::EPSILON * of_this.abs() {
                length = 0.0;
            }
        }
        if diagonal.is_empty() {
            return 0.0;
        }
        let mut matrix = DMatrix::from_diagonal(&DVector::from_vec(diagonal));
        for (k, entry) in beside.iter().enumerate().skip(1) {
            matrix[(k, k - 1)] = *entry;
            matrix[(k - 1, k)] = *entry;
        }
        let modes = matrix.symmetric_eigen();
        let stiffest = modes.eigenvalues.imax();
        let error = length * modes.eigenvectors[(modes.eigenvectors.nrows() - 1, stiffest)].abs();
        (modes.eigenvalues[stiffest] + error).max(0.0).sqrt()
    }

    /// Acceleration of each particle over its displacement `u`, small beside the spacing \[1/s² times that of `u`\].
    fn acceleration(
        &self,
        u: &[S::Vector],
        mass: &[f64],
        units: &ForceUnits,
        stress: &(impl Fn(&S::Tensor) -> S::Tensor + Sync),
    ) -> Vec<S::Vector> {
        let n = mass.len();
        // Anchored particles and boundary points stay.
        let change = |i: usize, pair: &ReferencePair<S>| u[i] - u[pair.neighbour as usize];
        let mut gradients = vec![S::Tensor::zeros(); n];
        for_each(&mut gradients[..], TASK, |i, gradient| {
            *gradient = self.gradient(i, |pair| change(i, pair));
        });
        let pair_tensor: Vec<S::Matrix<f64>> =
            (0..n).map(|i| self.pair_tensor(i, &gradients[i], &stress(&gradients[i]), units)).collect();
        let mut acceleration = vec![S::Vector::zeros(); n];
        for_each(&mut acceleration[..], TASK, |i, acceleration| {
            if !self.anchored[i] {
                let change = |pair: &ReferencePair<S>| change(i, pair);
                *acceleration = self.force(i, self.of(i).iter(), &pair_tensor, units, change) / mass[i];
            }
        });
        acceleration
    }

    /// Force on particle `i` \[N/m\] by stresses and hourglass control, of `pairs` of it.
    ///
    /// ```text
    /// f_i = −Σ_j a_ij ((Q_i + Q_j) X_ij + k (2 x_ij − (F_i + F_j) X_ij)) = −s Σ_j a_ij ((N_i + N_j) X_ij + 2κ x_ij)
    /// ```
    ///
    /// It is minus the derivative of Σ V ψ(F) + ½ k Σ_ij a_ij |x_ij − F_i X_ij|² by x_i: the weights of the second sum
    /// are those of F, so that the derivative of F drops out of it (Silling 2017). Energy, momentum and angular
    /// momentum are therefore kept. `pair_tensor` holds N of [`Self::pair_tensor`]; between anchored and free particles
    /// x_ij counts once, as only one end has an F.
    #[inline]
    pub fn force<'a>(
        &self,
        i: usize,
        pairs: impl Iterator<Item = &'a ReferencePair<S>>,
        pair_tensor: &[S::Matrix<f64>],
        units: &ForceUnits,
        x_ij: impl Fn(&ReferencePair<S>) -> S::Vector,
    ) -> S::Vector {
        let mut force = S::Vector::zeros();
        for pair in pairs {
            let ends = match pair.kind {
                PairKind::Inner if self.anchored[i] => continue,
                PairKind::Inner => 2.0,
                PairKind::ToAnchor | PairKind::FromAnchor => 1.0,
            };
            let both = S::matrix_plus(pair_tensor[i], pair_tensor[pair.neighbour as usize]);
            force -=
                (S::tensor(both) * pair.separation + x_ij(pair) * (ends * units.hourglass)) * pair.weight;
        }
        force * units.modulus
    }

    /// Energy of the hourglass control of particle `i` \[J/m\]: ½ k Σ_j a_ij |x_ij − F_i X_ij|².
    pub fn hourglass_energy(
        &self,
        i: usize,
        deformation: &S::Tensor,
        hourglass_modulus: f64,
        x_ij: impl Fn(&ReferencePair<S>) -> S::Vector,
    ) -> f64 {
        let misfit: f64 = self
            .of(i)
            .iter()
            .map(|pair| pair.weight * (x_ij(pair) - *deformation * pair.separation).norm_squared())
            .sum();
        0.5 * hourglass_modulus * misfit
    }
}

#[cfg(test)]
mod tests;
