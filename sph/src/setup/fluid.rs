//! Set-up of a fluid solver.

use super::parameters::{choices, parameters};
use super::{
    Allowed, Damping, FluidProbe, Outflow, ParameterSpec as Row, RunSetup, Value, WallParticles, WallSetup,
};
use crate::kernel::CubicSpline;
use crate::laws::acoustic_relaxation::{AcousticRelaxation, LARGEST_TENSION};
use crate::laws::artificial_viscosity::ArtificialViscosity;
use crate::laws::equation_of_state::Tait;
use crate::space::{Plane, Space};

use Value::{Choice, Flag, Number};

/// Particles that may escape before a run stops.
pub(super) const MOST_ESCAPED: u64 = 1_000_000_000;

const EXPONENT: Allowed = Allowed::new(1.0, 20.0, (true, true), "a number from 1 to 20");

/// The stable step is by about this factor shorter.
const DAMPER: Allowed = Allowed::new(0.0, 1e6, (true, true), "a number from 0 to 1e6");

/// The stable step is by √(1 + r) shorter.
const RELAXATION: Allowed = Allowed::new(0.0, 100.0, (true, true), "a number from 0 to 100");

parameters! {
    /// Parameters of a fluid, Eq. (3)-(4), (17)-(24).
    pub struct FluidParameters {
        /// Particle spacing Δx \[m\].
        particle_spacing: f64 = 0.01, "particle_spacing_m", Row::number(Allowed::POSITIVE).stated().of_pair_law();
        /// Kernel ratio h/Δx \[-\]; the support radius of the kernel is 2h.
        kernel_ratio: f64 = 1.3, "kernel_ratio", Row::number(Allowed::KERNEL_RATIO).of_pair_law()
            .cost("at 1.2 a drop changes its area by 0.9 % instead of 0.03 %").paper(Number(1.2));
        /// Rest density ρ₀ \[kg/m³\].
        rest_density: f64 = 1000.0, "rest_density_kg_m3", Row::number(Allowed::POSITIVE).stated().of_pair_law();
        /// Artificial speed of sound c₀ \[m/s\]; at least 10 times the largest speed of the fluid.
        sound_speed: f64 = 20.0, "sound_speed_m_s", Row::number(Allowed::POSITIVE).stated().of_pair_law();
        /// Equation of state: pressure of a density.
        state_law: StateLaw = StateLaw::Tait, "equation_of_state",
            Row::choice::<StateLaw>().off(Choice("tait")).of_pair_law();
        /// Exponent γ of the equation of state `tait` \[-\].
        exponent: f64 = 7.0, "exponent", Row::number(EXPONENT).of_pair_law();
        /// Background pressure p_b, added to the pressure of the equation of state everywhere \[Pa\]: it pushes particles
        /// from crowded places in Eq. (22), and a free surface apart (Adami et al. 2012).
        background_pressure: f64 = 0.0, "background_pressure_pa",
            Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0)).of_pair_law();
        /// Dynamic viscosity μ of Eq. (4) \[Pa s\].
        dynamic_viscosity: f64 = 0.0, "dynamic_viscosity_pa_s",
            Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0)).of_pair_law();
        /// Form of the viscous force of Eq. (4).
        viscous_form: ViscousForm = ViscousForm::Pairwise, "viscous_form",
            Row::choice::<ViscousForm>().off(Choice("pairwise"))
                .paper(Choice("stress"));
        /// Correction of the kernel gradient in Eq. (17) and (22); fluid-solid pairs divide ∇W by the lattice moment
        /// M, unless it is `none`.
        correction: GradientCorrection = GradientCorrection::Renormalised, "gradient_correction",
            Row::choice::<GradientCorrection>().off(Choice("none")).of_pair_law().paper(Choice("none"))
                .cost("with `none` pressure at rest is 0.9 % high at h/Δx = 1.2; with \
                    `none` or `lattice-moment` a stretching drop gains 12 % of area; with all but `renormalised` a \
                    standing wave of 1 m depth oscillates 4 % too fast");
        /// Largest share of L_i in Eq. (22) with `renormalised` \[-\]; the rest is the plain sum, ∇W/M. Less than 1 keeps
        /// still water from contracting, which `volume_correction` does better.
        correction_share: f64 = 1.0, "gradient_correction_share", Row::number(Allowed::SHARE).off(Number(0.8))
            .cost("0.8 takes 0.8 % off the period of a standing wave and adds 2 % to its decay");
        /// Density diffusion, Eq. (18).
        density_diffusion: DensityDiffusion = DensityDiffusion::Renormalised, "density_diffusion",
            Row::choice::<DensityDiffusion>().off(Choice("none"));
        /// Coefficient δ of the density diffusion, Eq. (18) \[-\].
        density_diffusion_delta: f64 = 0.1, "density_diffusion_delta", Row::number(Allowed::POSITIVE);
        /// Artificial viscosity A of Eq. (23) \[-\].
        viscosity_a: f64 = 0.5, "artificial_viscosity_a",
            Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0)).of_pair_law().paper(Number(1.0));
        /// What A resists: with `residual` the part of the approach of two particles that the rates of strain of the fluid
        /// do not explain.
        viscosity_form: ViscosityForm = ViscosityForm::Residual, "artificial_viscosity_form",
            Row::choice::<ViscosityForm>().off(Choice("plain")).paper(Choice("plain"))
                .cost("`plain`, with A at 0.1, takes 4 % off the energy of a rotating patch in half a turn instead of 1.3 %");
        /// Share of A in pairs with particles of solids \[-\], whose form is always `plain`.
        viscosity_solid_share: f64 = 0.2, "artificial_viscosity_solid_share",
            Row::number(Allowed::SHARE).off(Number(1.0)).of_pair_law().paper(Number(1.0))
                .cost("a plate that a dam break strikes bends by 7 % more with 1 at 4 mm, by 4 % more at 2 mm, \
                    and by 1 % less with 0.04");
        /// Artificial viscosity B of Eq. (23) \[-\]. It acts where water strikes water at a good part of c₀.
        viscosity_b: f64 = 0.5, "artificial_viscosity_b",
            Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0)).of_pair_law().paper(Number(1.0));
        /// Fraction λ of h² in the denominators of Eq. (19) and (24) \[-\].
        lambda: f64 = 0.01, "lambda", Row::number(Allowed::SHARE).of_pair_law();
        /// Coefficient ε of the artificial pressure \[-\]: fluid and wall pairs under tension add
        /// ε (W/W(Δx))⁴ (\[−p_i\]₊ + \[−p_j\]₊) to p_i + p_j in Eq. (22), which keeps particles from clumping where
        /// `tensile_control` is off; 0.2 to 0.3 is usual (Monaghan 2000).
        artificial_pressure: f64 = 0.0, "artificial_pressure", Row::number(Allowed::SHARE).off(Number(0.0));
        /// Coefficient α of the acoustic damper \[-\]: each particle adds the pressure q = −α ρ c₀ h ∇·v to its own in
        /// Eq. (22), away from solids, and walls mirror it.
        acoustic_damping: f64 = 0.0, "acoustic_damping", Row::number(DAMPER).off(Number(0.0));
        /// Relaxation strength r = (c_h/c₀)² of sound \[-\]: each particle carries a pressure q beside Eq. (3), dq/dt = r c₀²
        /// dρ/dt − q/τ, which absorbs sound faster than τ. Sound is √(1 + r) times as fast, and steps as much shorter.
        /// A case that leaves it out gets less where its steps leave less room: 0.25 with adaptive steps.
        acoustic_relaxation: f64 = 1.0, "acoustic_relaxation",
            Row::number(RELAXATION).off(Number(0.0)).paper(Number(0.0))
                .cost("without it an impact rings: the load on a plate swings by as much as its mean");
        /// Relaxation time τ of sound \[s\]; a case that leaves it out takes V/(2 S c₀), V the volume of the fluid at the
        /// start and S the area of its faces.
        acoustic_relaxation_time: Option<f64> = None, "acoustic_relaxation_time_s",
            Row::number(Allowed::POSITIVE).optional();
        /// Coefficient k of the repulsion by wall faces \[-\]: a particle at height z over the first layer of a wall,
        /// z < D, gets the normal acceleration max(0, w²(D − z) − w min(1, 4(D − z)/D) v_n), w = √k c₀/Δx, D = 0.6 Δx,
        /// v_n its speed off the wall, shared among neighbouring wall particles by 1 − |tangential distance|/Δx.
        wall_repulsion: f64 = 1.0, "wall_repulsion",
            Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0)).paper(Number(0.0));
        /// Coefficient C of the shifting of particles \[-\]: δu = −C 2h U Σ V_j \[1 + 0.2 (W/W(Δx))⁴\] ∇W, |δu| ≤ U/2, U
        /// the largest |v_ij| of neighbours; along the free surface only at it, fading under high pressure.
        shifting: f64 = 2.0, "shifting", Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0)).paper(Number(0.0))
            .cost("without it a rotating patch has voids of 6 Δx and a Taylor-Green vortex stops");
        /// Whether p_i + p_j becomes p_j − p_i where p_i < 0, down to −ρ₀c₀²/1000, away from the free surface.
        tensile_control: bool = true, "tensile_control", Row::flag().off(Flag(false)).paper(Flag(false))
            .cost("shifting alone leaves voids");
        /// Coefficient k of the volume correction \[-\]: inside the fluid dρ/dt gains ρ ε min(k U, 0.2 c₀)/h, which ties
        /// the density to the volume that the particles fill, ε the share of its volume that a particle claims in
        /// excess, read on a background grid, U as in `shifting`.
        volume_correction: f64 = 30.0, "volume_correction",
            Row::number(Allowed::NOT_NEGATIVE).off(Number(0.0)).paper(Number(0.0))
                .cost("without it a full channel loses its pressure, and an oscillating drop 5 % of its \
                area");
        /// Largest tension t that the fluid bears \[Pa\]: p = max(Eq. (3), −t), beyond which cavities lower its density. A
        /// case that leaves it out takes the tension at 0.9 ρ₀.
        tension_limit: Option<f64> = None, "tension_limit_pa", Row::number(Allowed::POSITIVE).optional();
        /// Time integration.
        scheme: FluidScheme = FluidScheme::Leapfrog, "scheme", Row::choice::<FluidScheme>()
            .paper(Choice("predictor-corrector"));
        /// Particles that may cross a wall; the run ends when more have escaped.
        lost_particle_limit: u64 = 0, "lost_particle_limit", Row::count(0, MOST_ESCAPED);
    }
}

choices! {
    /// Equation of state.
    pub enum StateLaw {
        /// p = ρ₀c₀²/γ·((ρ/ρ₀)^γ − 1), Eq. (3).
        Tait = "tait",
        /// p = c₀²(ρ − ρ₀) (Morris et al. 1997): Eq. (3) with γ = 1.
        Linear = "linear",
    }
}

choices! {
    /// Correction of the kernel gradient in the fluid's sums (17) and (22).
    pub enum GradientCorrection {
        /// ∇W divided by the lattice moment M, a constant.
        LatticeMoment = "lattice-moment",
        /// L_i of Eq. (21) in (17), ∇W divided by M in (22).
        Continuity = "continuity",
        /// L_i of Eq. (21) in (17), p_i L_i + p_j L_j in (22); fluid-solid pairs use M.
        Renormalised = "renormalised",
        /// None, as in the source paper.
        None = "none",
    }
}

choices! {
    /// Density diffusion of Eq. (18).
    pub enum DensityDiffusion {
        /// ψ of Eq. (19) with the renormalised gradients of Eq. (20) (Marrone et al. 2011).
        Renormalised = "renormalised",
        /// ψ without the gradient bracket (Molteni & Colagrossi 2009).
        Plain = "plain",
        /// None.
        None = "none",
    }
}

choices! {
    /// What the linear term of the artificial viscosity resists.
    pub enum ViscosityForm {
        /// v_ij·x_ij less x_ij·(D_i + D_j)·x_ij/2, D the rates of strain: smooth flow, such as shear and sound of long waves,
        /// is left alone.
        Residual = "residual",
        /// v_ij·x_ij, as in the source paper.
        Plain = "plain",
    }
}

choices! {
    /// Form of the viscous force of Eq. (4).
    pub enum ViscousForm {
        /// Σ V_j 2μ (dW/dr)/r v_ij (Morris et al. 1997): a pair force that also damps velocities that alternate from
        /// particle to particle.
        Pairwise = "pairwise",
        /// Divergence of the stress of Eq. (4): exactly as the source paper, blind to alternating velocities.
        Stress = "stress",
    }
}

choices! {
    /// How the fluid goes through the two stages of a step.
    pub enum FluidScheme {
        /// Density is advanced in the predictor and velocity in the corrector, half a step apart: one sum for each.
        Leapfrog = "leapfrog",
        /// All rates in both stages, exactly as Eq. (30)-(31).
        PredictorCorrector = "predictor-corrector",
    }
}

crate::constants! {
    /// The rule damps nothing itself. A dam break with A = 1, or with A = 0.1 and the acoustic damper at 0.4, ran at
    /// 1.0.
    const MIDPOINT_DAMPED_FRACTION: f64 = 1.0, "time_step.midpoint_damped",
        "fraction of h/(c0 + v) that the midpoint rule takes where sound is damped [-]";
    /// A dam break with A = 0.1 alone kept its energy at 0.6, gained 5 % at 0.7 and broke at 0.95.
    const MIDPOINT_FRACTION: f64 = 0.6, "time_step.midpoint", "the same where sound is nearly undamped [-]";
    /// Of it 0.8 is recommended. A breaking bore with 9 particles in its depth kept its energy to 6e-6 at 0.9 h/(c0 + v), with
    /// A = 0.1, 0.25, 0.5 and 1. At 0.92 its residual was up to 1.7 %, at 1.02 22 %: noise of particles at the edges of
    /// splashes, whose forces act with the artificial viscosity and diffusion of the start of the step.
    const LEAPFROG_FRACTION: f64 = 1.125, "time_step.leapfrog",
        "fraction of h/(c0 + v) that leapfrog takes without the acoustic damper [-]";
    /// A dam break kept its energy at 0.97, with A = 1.5, 2 and 4. At 1.3 noise took a third of it in the form `residual`, and all
    /// but half in the form `plain`.
    const VISCOUS_COURANT: f64 = 1.0, "time_step.artificial_viscosity",
        "largest A c0 dt/h of artificial viscosity [-]";
    const DAMPED_VISCOSITY: f64 = 0.5, "time_step.damped_viscosity",
        "plain artificial viscosity A from which on sound counts as damped in the midpoint rule [-]";
    const DAMPED_ACOUSTICS: f64 = 0.4, "time_step.damped_acoustics",
        "acoustic damping from which on sound counts as damped in the midpoint rule [-]";
}

impl FluidParameters {
    /// The fewest passes: gradients corrected by a constant, no particle regularisation, no volume correction and no
    /// acoustic relaxation.
    pub const PLAIN: Self = Self {
        kernel_ratio: 1.2,
        correction: GradientCorrection::LatticeMoment,
        viscosity_a: 0.1,
        viscosity_form: ViscosityForm::Plain,
        viscosity_solid_share: 1.0,
        viscosity_b: 0.0,
        shifting: 0.0,
        tensile_control: false,
        volume_correction: 0.0,
        acoustic_relaxation: 0.0,
        ..Self::DEFAULT
    };

    /// Smoothing length h \[m\].
    #[inline]
    pub fn smoothing_length(&self) -> f64 {
        self.kernel_ratio * self.particle_spacing
    }

    /// Factor of kernel gradients in fluid-solid pairs \[-\]: 1/M, or 1 without correction. These pairs never use L_i, which
    /// needs second neighbours.
    pub fn pair_gradient_scale<S: Space>(&self) -> f64 {
        match self.correction {
            GradientCorrection::None => 1.0,
            GradientCorrection::LatticeMoment
            | GradientCorrection::Continuity
            | GradientCorrection::Renormalised => {
                1.0 / CubicSpline::<S>::new(self.smoothing_length()).lattice_moment(self.particle_spacing)
            }
        }
    }

    /// The artificial viscosity of this fluid.
    pub fn artificial_viscosity(&self) -> ArtificialViscosity {
        self.artificial_viscosity_of(self.viscosity_a)
    }

    /// That of its pairs with solids.
    pub fn artificial_viscosity_at_solids(&self) -> ArtificialViscosity {
        self.artificial_viscosity_of(self.viscosity_a * self.viscosity_solid_share)
    }

    fn artificial_viscosity_of(&self, a: f64) -> ArtificialViscosity {
        ArtificialViscosity::new(self.smoothing_length(), a * self.sound_speed, self.viscosity_b, self.lambda)
    }

    /// Its equation of state, Eq. (3), with the limit of tension.
    pub fn equation_of_state(&self) -> Tait {
        let law = match self.state_law {
            StateLaw::Tait => Tait::new(self.rest_density, self.sound_speed, self.exponent),
            StateLaw::Linear => Tait::linear(self.rest_density, self.sound_speed),
        };
        let law = self.tension_limit.map_or(law, |tension| law.bearing(tension));
        law.under(self.background_pressure)
    }

    /// Its acoustic relaxation, if there is any.
    pub fn acoustic_relaxation(&self) -> Option<AcousticRelaxation> {
        let time = self.acoustic_relaxation_time.filter(|_| self.acoustic_relaxation > 0.0)?;
        let square = self.sound_speed.powi(2);
        let tension = LARGEST_TENSION * self.rest_density * square;
        Some(AcousticRelaxation::new(self.acoustic_relaxation * square, time).bearing(tension))
    }

    /// δ h c₀ of Eq. (18) \[m²/s\]; zero without diffusion.
    pub fn diffusivity(&self) -> f64 {
        match self.density_diffusion {
            DensityDiffusion::None => 0.0,
            _ => self.density_diffusion_delta * self.smoothing_length() * self.sound_speed,
        }
    }

    /// Shifting, tensile control and volume correction; `None` without any.
    pub fn order_control(&self) -> Option<OrderControl> {
        let Self { shifting, tensile_control, volume_correction, .. } = *self;
        let control = OrderControl { shifting, tensile_control, volume_correction };
        (shifting > 0.0 || tensile_control || volume_correction > 0.0).then_some(control)
    }

    /// Parameters that do not go together: the key of one, and why.
    pub fn contradiction(&self) -> Option<Contradiction> {
        let untimed = self.acoustic_relaxation > 0.0 && self.acoustic_relaxation_time.is_none();
        let contradiction = untimed.then_some(Contradiction {
            key: "acoustic_relaxation",
            problem: "the relaxation of sound needs a time",
            hint: "give `acoustic_relaxation_time_s`, about half the depth of the water over the sound speed",
        });
        contradiction.or_else(|| self.contradiction_of_forms())
    }

    /// The same among choices of forms, without what a case derives of its scene.
    pub fn contradiction_of_forms(&self) -> Option<Contradiction> {
        let stress_in_leapfrog =
            (self.scheme, self.viscous_form) == (FluidScheme::Leapfrog, ViscousForm::Stress);
        stress_in_leapfrog.then_some(Contradiction {
            key: "viscous_form",
            problem: "the viscous stress of Eq. (4) does not go with leapfrog, which sums no velocity gradient in the \
                      corrector",
            hint: "use `viscous_form = \"pairwise\"`, or `scheme = \"predictor-corrector\"`",
        })
    }

    /// Acoustic limit of the time step \[s\] at the largest speed `speed` \[m/s\].
    ///
    /// ```text
    /// s h/(c + |v|),   c = √(1 + r) c₀
    /// at most h/(A c₀)
    /// leapfrog: s = √(α² + 1.125²) − α,  α in units of c h
    /// predictor-corrector: s = 1 for plain A ≥ 0.5 or α ≥ 0.4, else 0.6; at most h/(α c₀)
    /// ```
    /// c is the speed of sound that is too fast for the acoustic relaxation. Leapfrog takes the damper from the start of the step, which is stable for (ωΔt)² (1/4 + α/(2s)) < 1.
    pub fn acoustic_limit(&self, speed: f64) -> f64 {
        let (h, c0, alpha) = (self.smoothing_length(), self.sound_speed, self.acoustic_damping);
        let stiffening = (1.0 + self.acoustic_relaxation).sqrt();
        let fastest = stiffening * c0 + speed;
        let over = |rate: f64| if rate > 0.0 { h / rate } else { f64::INFINITY };
        let by_sound = match self.scheme {
            FluidScheme::Leapfrog => {
                let alpha = alpha / stiffening;
                (alpha.hypot(LEAPFROG_FRACTION) - alpha) * h / fastest
            }
            FluidScheme::PredictorCorrector => {
                let resists_sound = self.viscosity_form == ViscosityForm::Plain;
                let is_damped =
                    resists_sound && self.viscosity_a >= DAMPED_VISCOSITY || alpha >= DAMPED_ACOUSTICS;
                let fraction = if is_damped { MIDPOINT_DAMPED_FRACTION } else { MIDPOINT_FRACTION };
                over(alpha * c0).min(fraction * h / fastest)
            }
        };
        by_sound.min(VISCOUS_COURANT * over(self.viscosity_a * c0))
    }
}

/// Parameters that do not go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// Key of one of them.
    pub key: &'static str,
    /// Why they do not.
    pub problem: &'static str,
    /// What to do.
    pub hint: &'static str,
}

/// Control of the order of fluid particles, off at and near the free surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderControl {
    /// Coefficient C of the shifting \[-\] (Lind et al. 2012; Sun et al. 2017).
    pub shifting: f64,
    /// Whether pairs of negative pressure push apart instead of pulling together (Sun et al. 2018).
    pub tensile_control: bool,
    /// Coefficient k of the volume correction \[-\].
    pub volume_correction: f64,
}

/// Set-up of a fluid solver.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidSetup<S: Space = Plane> {
    /// Common part.
    pub run: RunSetup<S>,
    /// Parameters of the fluid.
    pub parameters: FluidParameters,
    /// Linear damping of the start; an account of the ledger.
    pub damping: Option<Damping>,
    /// Names of the fluid regions; `FluidParticles::region` indexes them.
    pub regions: Vec<String>,
    /// Walls; `WallParticles::wall` indexes them.
    pub walls: Vec<WallSetup<S>>,
    /// Fluid particles at the start.
    pub particles: FluidParticles<S>,
    /// Wall particles at the start.
    pub wall_particles: WallParticles<S>,
    /// What to report at probe times.
    pub probes: Vec<FluidProbe<S>>,
    /// Sides of the domain through which particles may leave; other crossings count as escaped.
    pub outflow: Outflow<S>,
}

/// Fluid particles, one entry per particle in each array.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FluidParticles<S: Space = Plane> {
    /// Identity, unique among the fluid's particles, ascending.
    pub id: Vec<u32>,
    /// Index of the region.
    pub region: Vec<u32>,
    /// Mass \[kg\], in the plane per depth.
    pub mass: Vec<f64>,
    /// Position \[m\].
    pub position: Vec<S::Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<S::Vector>,
    /// Density \[kg/m³\].
    pub density: Vec<f64>,
    /// Pressure q of the acoustic relaxation \[Pa\]; empty where all particles start without.
    pub relaxation: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn artificial_viscosity_shortens_steps_where_it_is_faster_than_sound() {
        for scheme in [FluidScheme::Leapfrog, FluidScheme::PredictorCorrector] {
            let limit = |viscosity_a: f64| {
                FluidParameters { scheme, viscosity_a, ..FluidParameters::DEFAULT }.acoustic_limit(2.0)
            };
            assert_eq!(limit(0.5), limit(0.0), "{scheme:?}");
            // h = 1.3 × 0.01 m, c₀ = 20 m/s.
            assert!((limit(4.0) - 0.013 / 80.0).abs() < 1e-15, "{scheme:?}");
        }
    }
}
