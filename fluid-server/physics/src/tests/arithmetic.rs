//! The passes in lanes against plain sums, one pair after another.

use sph::kernel::CubicSpline;
use sph::lanes::Arithmetic;
use sph::setup::{DensityDiffusion, FluidSetup, GradientCorrection, ViscousForm, WallCondition};
use sph::space::Vector;

use super::support::{Noise, ORDERED, add_floor, dam_break, evaluate, random_patch};
use crate::FluidSolver;
use crate::system::packed_particle::{Packed, PackedParticle};

/// The random patch with a floor under it, which reaches into the support.
fn patch(seed: u64) -> FluidSetup {
    let mut setup = random_patch(seed);
    add_floor(&mut setup, 0.36, 0.39, 13, WallCondition::NoSlip);
    setup.parameters.correction = GradientCorrection::Continuity;
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    setup
}

fn evaluated(setup: FluidSetup, arithmetic: Arithmetic) -> FluidSolver {
    let mut solver = FluidSolver::with_arithmetic(setup, arithmetic).unwrap();
    evaluate(&mut solver);
    solver
}

/// Acceleration and density rate of each particle by Eq. (17)-(24), from the records of `solver` alone.
struct Plain<'a> {
    solver: &'a FluidSolver,
    kernel: CubicSpline,
}

impl Plain<'_> {
    /// Everything within support of particle `i`: fluid, then walls, with x_ij and V_j (dW/dr)/r.
    fn pairs(&self, i: usize) -> Vec<(usize, bool, PackedParticle, Vector, f64)> {
        let workspace = &self.solver.workspace;
        let fluid = workspace.fluid.iter().enumerate().map(|(j, record)| (j, true, *record));
        let walls = workspace.walls.particles.iter().enumerate().map(|(w, record)| (w, false, *record));
        let own = workspace.fluid[i].position();
        fluid
            .chain(walls)
            .filter(|(j, is_fluid, _)| !(*is_fluid && *j == i))
            .map(|(j, is_fluid, other)| {
                let d = own - other.position();
                let factor = self.solver.model.gradient_scale * self.kernel.gradient_factor(d.norm());
                (j, is_fluid, other, d, other.volume() * factor)
            })
            .filter(|(.., weight)| *weight != 0.0)
            .collect()
    }

    fn inverse_moment(&self, i: usize) -> nalgebra::Matrix2<f64> {
        let moment: nalgebra::Matrix2<f64> =
            self.pairs(i).iter().map(|(.., d, weight)| -*weight * d * d.transpose()).sum();
        moment.try_inverse().unwrap()
    }

    fn density_gradient(&self, i: usize) -> Vector {
        let own = self.solver.workspace.fluid[i].density();
        let sum: Vector = self.pairs(i).iter().map(|(_, _, j, d, w)| d * (*w * (j.density() - own))).sum();
        self.inverse_moment(i) * sum
    }

    fn rates(&self, i: usize) -> (Vector, f64) {
        let model = &self.solver.model;
        let own = &self.solver.workspace.fluid[i];
        let gradient = self.density_gradient(i);
        let inverse = self.inverse_moment(i);
        // Below a determinant of 0.3 of the moments, L_i is the unit matrix.
        let correction =
            if inverse.determinant() * 0.3 > 1.0 { nalgebra::Matrix2::identity() } else { inverse };
        let h = model.constants.smoothing_length();
        let (mut force, mut density) = (Vector::zeros(), 0.0);
        for (j, is_fluid, other, d, weight) in self.pairs(i) {
            let v = own.velocity() - other.velocity();
            let (rho_i, rho_j) = (own.density(), other.density());
            let regular = d.norm_squared() + 0.01 * h * h;
            let theta = h * v.dot(&d).min(0.0) / regular;
            let (a, b) = (model.constants.viscosity_a, model.constants.viscosity_b);
            let mean = 0.5 * (rho_i + rho_j);
            let viscosity =
                rho_i * rho_j * (b * theta * theta - a * model.constants.sound_speed * theta) / mean;
            force -= d * (weight * (own.pressure() + other.pressure() + viscosity));
            density += rho_i * weight * v.dot(&(correction * d));
            let other_gradient = if is_fluid { self.density_gradient(j) } else { gradient };
            let psi =
                2.0 * (rho_i - rho_j) * d.norm_squared() / regular - (gradient + other_gradient).dot(&d);
            density += model.diffusion * weight * psi;
        }
        (force / own.density() + Vector::new(0.0, -9.81), density)
    }
}

#[test]
fn lanes_give_the_plain_sums_within_round_off_on_each_path() {
    for (arithmetic, seed) in Arithmetic::all().flat_map(|path| (20..24).map(move |seed| (path, seed))) {
        let solver = evaluated(patch(seed), arithmetic);
        let plain =
            Plain { solver: &solver, kernel: CubicSpline::new(solver.model.constants.smoothing_length()) };
        let scale = |f: &dyn Fn(usize) -> f64| (0..solver.state.len()).map(f).fold(0.0, f64::max);
        let rates = &solver.workspace.rates;
        let acceleration = scale(&|i| rates[i].acceleration.norm());
        let density = scale(&|i| rates[i].density.abs());
        for (i, found) in rates.iter().enumerate() {
            let (expected_acceleration, expected_density) = plain.rates(i);
            // Some 30 terms that cancel in part, each with a handful of roundings; L_i at the rim multiplies by 10.
            let allowed = 1e-12;
            let difference = (found.acceleration - expected_acceleration).norm();
            assert!(difference < allowed * acceleration, "{} {i}: {difference:e}", arithmetic.name());
            let difference = (found.density - expected_density).abs();
            assert!(difference < allowed * density, "{} {i}: {difference:e}", arithmetic.name());
        }
    }
}

#[test]
fn the_paths_differ_by_round_off_alone_with_every_term() {
    for form in [ViscousForm::Pairwise, ViscousForm::Stress] {
        let rates = |arithmetic| {
            let mut setup = patch(31);
            setup.parameters.dynamic_viscosity = 0.5;
            setup.parameters.viscous_form = form;
            (setup.parameters.shifting, setup.parameters.tensile_control) = ORDERED;
            setup.parameters.acoustic_damping = 1.0;
            setup.parameters.density_diffusion = DensityDiffusion::Renormalised;
            let solver = evaluated(setup, arithmetic);
            assert!(solver.workspace.rates.iter().any(|rates| rates.shift.norm() > 0.0));
            solver.workspace.rates.clone()
        };
        let mut of_paths = Arithmetic::all().map(rates);
        let first = of_paths.next().unwrap();
        let scale =
            |f: fn(&crate::rates::particle_rates::Rates) -> f64| first.iter().map(f).fold(0.0, f64::max);
        let (acceleration, shift) = (scale(|r| r.acceleration.norm()), scale(|r| r.shift.norm()));
        for (a, b) in of_paths.flat_map(|rates| first.iter().copied().zip(rates).collect::<Vec<_>>()) {
            // As above; the normal at the surface comes from a small difference of eigenvalues.
            assert!((a.acceleration - b.acceleration).norm() < 1e-11 * acceleration);
            assert!((a.shift - b.shift).norm() < 1e-10 * shift);
        }
    }
}

#[test]
fn lists_hold_every_pair_within_support_and_only_their_padding_besides() {
    let setup = dam_break();
    let mut noise = Noise(4);
    for arithmetic in Arithmetic::all() {
        let mut setup = setup.clone();
        setup.particles.position.iter_mut().for_each(|x| *x += noise.vector() * 0.004);
        let solver = evaluated(setup, arithmetic);
        let radius = 2.0 * 0.024 + solver.state.list_skin;
        let position = &solver.state.position;
        for i in 0..solver.state.len() {
            let mut found: Vec<usize> = solver.workspace.lists.fluid.neighbours(i).collect();
            found.sort_unstable();
            let near = |j: &usize| *j != i && (position[*j] - position[i]).norm() < radius;
            assert_eq!(found, (0..position.len()).filter(near).collect::<Vec<_>>());
        }
    }
}
