//! The volume correction next to a solid.

use sph::coupling::exchange::StateColumns;
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::interface::states::InterfaceStates;
use sph::setup::{DensityDiffusion, GradientCorrection, InterfaceLaw};
use sph::space::Vector;

use super::coupling::{REACH, coupled, extent, part, solid};
use super::support::{add_block, solver, stage_time};
use crate::FluidSolver;

/// A block of water of `density` \[kg/m³\] whose rows slide past each other at 0.1 m/s, evaluated next to `solid`.
fn evaluated(
    law: InterfaceLaw,
    density: f64,
    volume_correction: f64,
    solid: &InterfaceStates,
) -> FluidSolver {
    let mut setup = coupled(law, GradientCorrection::Renormalised, DensityDiffusion::None);
    setup.particles = Default::default();
    add_block(&mut setup, Vector::new(0.2, 0.2), 12, 10);
    setup.parameters.volume_correction = volume_correction;
    let particles = &mut setup.particles;
    particles.density.fill(density);
    for i in 0..particles.id.len() {
        particles.velocity[i].x = if i / 12 % 2 == 0 { 0.05 } else { -0.05 };
    }
    let mut solver = solver(setup);
    let (mut own, partner) = (StateColumns::default(), StateColumns::from(solid));
    let time = stage_time(0, Stage::Predictor, 1e-4);
    solver.begin_stage(&time).unwrap();
    solver.interface(&extent(), REACH, &mut own);
    solver.evaluate_own(&time);
    solver.evaluate_cross(&time, &own, &partner);
    solver
}

/// The particle at the solid, half-way up.
fn at_solid(solver: &FluidSolver) -> usize {
    solver.state.id.iter().position(|id| *id == 5 * 12 + 11).unwrap()
}

#[test]
fn a_solid_stands_for_its_volume_in_the_volume_correction() {
    for law in [InterfaceLaw::Wall, InterfaceLaw::WallNoSlip, InterfaceLaw::PlainSum] {
        let rate = |density| {
            let of = |volume_correction| {
                let solver = evaluated(law, density, volume_correction, &solid());
                solver.workspace.rates[at_solid(&solver)].density
            };
            of(2.0) - of(0.0)
        };
        // ρ 2U/h; the lattice continues in the solid, which nodes of spacing 1.2 Δx read to some tenths of a percent. A
        // solid that is not there would read as the bound of −2 %.
        let scale = 1000.0 * 0.2 / 0.024;
        assert!(rate(1000.0).abs() < 0.004 * scale, "{law:?}: {}", rate(1000.0) / scale);
        // Of 1 % more volume in the fluid the particle sees more than half.
        let more = (rate(990.0) - rate(1000.0)) / scale;
        assert!((0.005..0.012).contains(&more), "{law:?}: {more}");
    }
}

#[test]
fn air_behind_a_thin_solid_is_not_missing_volume() {
    for layers in 1..=4 {
        // Columns of four particles; the block ends at x = 0.44 m.
        let thin = part(&solid(), |s| s % 4 < layers);
        assert_eq!(thin.len(), 12 * layers);
        let solver = evaluated(InterfaceLaw::Wall, 1000.0, 2.0, &thin);
        let excess = &solver.state.volume_excess;
        let least = excess.iter().copied().fold(f64::INFINITY, f64::min);
        // As much as the lattice reads next to a thick solid; air that counts as missing volume reads −2 %.
        assert!(least > -0.004, "{layers}: {least}");
        // Of 1 % more volume the middle of the block reads a part, as nodes near its three surfaces do not count; next to
        // four layers the particle at the face is, too.
        let solver = evaluated(InterfaceLaw::Wall, 990.0, 2.0, &thin);
        let middle = (0..solver.state.len())
            .filter(|i| (solver.state.position[*i] - Vector::new(0.33, 0.3)).norm() < 0.03)
            .map(|i| solver.state.volume_excess[i])
            .fold(f64::INFINITY, f64::min);
        assert!((0.003..0.01).contains(&middle), "{layers}: {middle}");
        let at_face = solver.state.volume_excess[at_solid(&solver)];
        assert!(layers < 4 || at_face > 0.003, "{layers}: {at_face}");
    }
}
