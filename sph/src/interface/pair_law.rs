//! The pair law of fluid and solid particles, and the dummy state of a solid particle.

use super::fluid_regions::Dummy;
use super::lists::CrossPair;
use super::states::InterfaceStates;
use crate::kernel::CubicSpline;
use crate::laws::artificial_viscosity::ArtificialViscosity;
use crate::laws::equation_of_state::Tait;
use crate::laws::repulsion::Repulsion;
use crate::setup::{Coupling, InterfaceLaw};
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::{SpaceSymmetric, SpaceTensor, SpaceVector};

crate::constants! {
    /// At an edge of a plate of one row water all around cancels out, and a direction from round-off is none. At the edge of a box
    /// the share is 0.3 in the plane and 0.24 in space, at a face 0.6 and more.
    const CLEAR_SIDE: f64 = 0.2, "interface.clear_side",
        "mean offset of the fluid around a particle of a solid that slips, over the mean distance, from which on it has a side [-]";
}

/// Constants of the pair law.
#[derive(Clone, Copy, Debug)]
pub struct PairLaw<S: Space> {
    law: InterfaceLaw,
    kernel: CubicSpline<S>,
    equation_of_state: Tait,
    /// 1/M or 1: fluid-solid pairs never use L_i, which needs second neighbours.
    gradient_scale: f64,
    rest_density: f64,
    artificial_viscosity: ArtificialViscosity,
    dynamic_viscosity: f64,
    /// Repulsion by faces, against the height over the outer row of a solid.
    repulsion: Repulsion,
    faces: Faces,
}

/// Height over the outer row of a half-space of a solid, from the share of a kernel that it fills.
///
/// ```text
/// φ_f = Σ_s V_s W_fs,   y_f = D − g (φ_f − φ(D)),   g = −dy/dφ between 0.4 Δx and D
/// ```
/// φ(y) is the sum at height y over the outer row of a half-space on a lattice. y_f is right to 0.03 Δx between 0 and D, and
/// φ varies by 0.004 Δx along the row, so that a face does not hold particles in place along it.
#[derive(Clone, Copy, Debug)]
struct Faces {
    /// φ at the height where the repulsion sets in \[-\].
    onset: f64,
    /// g \[m\].
    gain: f64,
    /// Distance from the nearest particle above which a height is beyond the onset \[m\].
    nearest: f64,
}

impl<S: Space> PairLaw<S> {
    /// The law with the constants of `coupling`.
    pub fn new(coupling: &Coupling) -> Self {
        let fluid = &coupling.fluid;
        let kernel = CubicSpline::<S>::new(fluid.smoothing_length());
        let spacing = 0.5 * (fluid.particle_spacing + coupling.solid_spacing);
        let repulsion =
            Repulsion::new(coupling.repulsion, spacing, fluid.particle_spacing, fluid.sound_speed);
        Self {
            law: coupling.law,
            kernel,
            equation_of_state: fluid.equation_of_state(),
            gradient_scale: fluid.pair_gradient_scale::<S>(),
            rest_density: fluid.rest_density,
            artificial_viscosity: fluid.artificial_viscosity_at_solids(),
            dynamic_viscosity: fluid.dynamic_viscosity,
            faces: Faces::new(&kernel, spacing, repulsion.distance()),
            repulsion,
        }
    }

    /// Which law it is.
    pub fn kind(&self) -> InterfaceLaw {
        self.law
    }

    /// Distance from which particles do not interact \[m\].
    pub fn support_radius(&self) -> f64 {
        self.kernel.support_radius()
    }

    /// W \[1/m³\] at a `distance` \[m\], in the plane 1/m².
    pub fn weight(&self, distance: f64) -> f64 {
        self.kernel.value(distance)
    }

    /// Dummy state of solid state `s` toward `region`, that of a wall: pressure by Eq. (28), without the solid's acceleration,
    /// which would make light solids unstable, and velocity by Eq. (27).
    ///
    /// ```text
    /// n = Σ_f W_fs x_fs / |Σ_f W_fs x_fs|,   u_s = ū − 2 [(ū − v_s)·n] n   slip;   2 (v_s + G x̄/2) − ū   no slip
    /// ```
    /// ū and x̄ are the means of the velocity of the region and of its separation from s, weighted by the kernel, and G is the
    /// `gradient` of the velocity of the body at s: s lies behind the face, which is half-way to x̄. Where the fluid lies around s,
    /// on no side of it, u_s fades to v_s.
    ///
    /// `region` are the indices of the region's particles within support of s.
    pub fn wall_dummy(
        &self,
        domain: &Domain<S>,
        body_force: &S::Vector,
        [fluid, solid]: [&InterfaceStates<S>; 2],
        s: usize,
        region: impl Iterator<Item = usize>,
        gradient: Option<&S::Tensor>,
    ) -> Dummy<S> {
        let (mut pressure, mut weight, mut distance) = (0.0, 0.0, 0.0);
        let (mut flow, mut offset) = (S::Vector::zeros(), S::Vector::zeros());
        for f in region {
            let x_fs = domain.separation(&fluid.position[f], &solid.position[s]);
            let r = x_fs.norm();
            let w = self.kernel.value(r);
            pressure += w * (fluid.pressure[f] - fluid.density[f] * body_force.dot(&x_fs));
            weight += w;
            flow += fluid.velocity[f] * w;
            offset += x_fs * w;
            distance += w * r;
        }
        if weight > 0.0 {
            pressure /= weight;
        }
        let v_s = solid.velocity[s];
        let velocity = if weight == 0.0 {
            v_s
        } else if let Some(gradient) = gradient {
            v_s * 2.0 + *gradient * (offset / weight) - flow / weight
        } else {
            let relative = flow / weight - v_s;
            let clear = (offset.norm() / (CLEAR_SIDE * distance).max(f64::MIN_POSITIVE)).min(1.0);
            let n = offset / offset.norm().max(f64::MIN_POSITIVE);
            v_s + (relative - n * (2.0 * relative.dot(&n))) * clear
        };
        Dummy {
            pressure,
            density: self.equation_of_state.wall_density(pressure),
            // In this order: coupling points of a solid with force coupling carry the volume alone.
            mass: self.rest_density * solid.volume(s),
            velocity,
        }
    }

    /// Force of solid state `s` on fluid state `f` \[N\], Eq. (22) with the fluid's h and c₀, and its part of the repulsion of
    /// `f`, see [`PairLaw::barrier`]; `gradient` is that of the velocity of the body at `s`.
    ///
    /// Without slip it adds friction: toward the mirrored velocity in the pairwise form of Morris, Fox & Zhu 1997, and the rest of
    /// the viscous stress, T = μ ((∇v)ᵀ − ∇·v 1), whose traction at a face follows from the motion of the face alone.
    ///
    /// ```text
    /// V_f V_s 2 μ (x_fs·∇W)/(r² + λh²) (v_f − u_s + Gᵀ x_fs − tr G x_fs)
    /// ```
    /// A body and the fluid that turns with it exert none on each other.
    #[inline]
    pub fn force_on_fluid(
        &self,
        x_fs: &S::Vector,
        [fluid, solid]: [&InterfaceStates<S>; 2],
        [f, s]: [usize; 2],
        (dummy, gradient): (&Dummy<S>, Option<&S::Tensor>),
        barrier: f64,
    ) -> S::Vector {
        let distance = x_fs.norm();
        let gradient_factor = self.gradient_scale * self.kernel.gradient_factor(distance);
        let (rho_f, rho_s) = (fluid.density[f], dummy.density);
        let masses = fluid.mass[f] * dummy.mass;
        let square = distance * distance;
        let viscous_v_fs = fluid.velocity[f] - dummy.velocity;
        // Π_fs of Eq. (23).
        let viscosity =
            self.artificial_viscosity.pressure(viscous_v_fs.dot(x_fs), square) / (0.5 * (rho_f + rho_s));
        let central = -barrier * solid.volume(s) * self.kernel.gradient_factor(distance)
            - masses * ((fluid.pressure[f] + dummy.pressure) / (rho_f * rho_s) + viscosity) * gradient_factor;
        match self.law {
            InterfaceLaw::Wall => *x_fs * central,
            InterfaceLaw::WallNoSlip => {
                let softened = self.artificial_viscosity.softened(square);
                let friction = masses * 2.0 * self.dynamic_viscosity * square * gradient_factor
                    / (rho_f * rho_s * softened);
                let along_face = gradient.map_or(S::Vector::zeros(), |gradient| {
                    gradient.transpose() * *x_fs - *x_fs * gradient.trace()
                });
                *x_fs * central + (viscous_v_fs + along_face) * friction
            }
            InterfaceLaw::PlainSum => {
                let stress = S::SymmetricTensor::isotropic(-fluid.pressure[f]).plus(&solid.stress[s]);
                let factor = masses * gradient_factor;
                stress.dot(x_fs) * (factor / (rho_f * rho_s)) - *x_fs * (factor * viscosity)
            }
        }
    }

    /// Repulsion of fluid state `f` by the faces of the solid in its `row`: the force over −Σ V_s ∇W \[N m\].
    ///
    /// Pressure alone can not keep out a particle that is squeezed against a face: pair forces vanish as particles meet.
    pub(super) fn barrier(
        &self,
        domain: &Domain<S>,
        [fluid, solid]: [&InterfaceStates<S>; 2],
        f: usize,
        row: &[CrossPair],
    ) -> f64 {
        if !self.repulsion.acts() {
            return 0.0;
        }
        let square = self.faces.nearest * self.faces.nearest;
        let separation =
            |pair: &CrossPair| domain.separation(&fluid.position[f], &solid.position[pair.other as usize]);
        if row.iter().all(|pair| separation(pair).norm_squared() > square) {
            return 0.0;
        }
        let (mut filled, mut parting) = (0.0, 0.0);
        for pair in row {
            let (s, x_fs) = (pair.other as usize, separation(pair));
            let (r, volume) = (x_fs.norm(), solid.volume(s));
            filled += volume * self.kernel.value(r);
            parting -=
                volume * self.kernel.gradient_factor(r) * x_fs.dot(&(fluid.velocity[f] - solid.velocity[s]));
        }
        let Faces { onset, gain, .. } = self.faces;
        let height = self.repulsion.distance() - gain * (filled - onset);
        fluid.mass[f] * gain * self.repulsion.acceleration(height, gain * parting)
    }
}

impl Faces {
    /// Faces of solids whose particles, and those of the fluid, are a mean of `spacing` \[m\] apart; the repulsion sets in at
    /// the height `onset` \[m\].
    fn new<S: Space>(kernel: &CubicSpline<S>, spacing: f64, onset: f64) -> Self {
        let filled = |height: f64| kernel.half_space_sum(spacing, height);
        let lower = 0.4 * spacing;
        Self {
            onset: filled(onset),
            gain: (onset - lower) / (filled(lower) - filled(onset)),
            // Below the onset a particle of a lattice is nearer than this.
            nearest: spacing,
        }
    }
}
