use super::*;
use crate::setup::{BodyForce, CouplingKind, FluidParameters};
use crate::space::{SymmetricTensor, Vector};

const SPACING: f64 = 0.01;

fn coupling(law: InterfaceLaw) -> Coupling {
    Coupling {
        kind: CouplingKind::States,
        law,
        fluid: FluidParameters {
            dynamic_viscosity: 0.1,
            particle_spacing: SPACING,
            viscosity_a: 0.3,
            viscosity_b: 0.5,
            ..FluidParameters::PLAIN
        },
        solid_spacing: SPACING,
        repulsion: 0.5,
        margin: 0.5 * SPACING,
        implicit: None,
    }
}

fn domain() -> Domain {
    Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] }
}

fn gravity() -> BodyForceField {
    BodyForceField::new(&BodyForce { gravity: Vector::new(0.0, -9.81), expressions: None }).unwrap()
}

/// A disturbed lattice patch with random velocities, pressures and stresses.
fn patch(lower: Vector, columns: usize, rows: usize, seed: u64) -> InterfaceStates {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut states = <InterfaceStates>::default();
    for k in 0..columns * rows {
        let cell = Vector::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5);
        states.id.push(k as u32);
        states.group.push(0);
        states.mass.push(1000.0 * SPACING * SPACING);
        states.position.push(lower + (cell + 0.2 * Vector::new(next(), next())) * SPACING);
        states.velocity.push(Vector::new(next(), next()));
        states.density.push(1000.0 + 10.0 * next());
        states.pressure.push(1e4 * next());
        states.stress.push(SymmetricTensor { xx: 1e4 * next(), yy: 1e4 * next(), xy: 1e4 * next() });
    }
    states
}

fn append(states: &mut InterfaceStates, more: &InterfaceStates) {
    let first = states.len() as u32;
    states.id.extend(more.id.iter().map(|id| first + id));
    states.group.extend(&more.group);
    states.mass.extend(&more.mass);
    states.position.extend(&more.position);
    states.velocity.extend(&more.velocity);
    states.density.extend(&more.density);
    states.pressure.extend(&more.pressure);
    states.stress.extend(&more.stress);
}

fn facing_patches(seed: u64) -> (InterfaceStates, InterfaceStates) {
    (patch(Vector::new(0.2, 0.2), 8, 8, seed), patch(Vector::new(0.2 + 8.0 * SPACING, 0.2), 6, 8, seed + 7))
}

#[test]
fn action_equals_reaction_for_every_law_and_torque_for_central_ones() {
    for law in [InterfaceLaw::Wall, InterfaceLaw::WallNoSlip, InterfaceLaw::PlainSum] {
        for seed in [1, 2, 3] {
            let (fluid, solid) = facing_patches(seed);
            let mut interface = Interface::new(&coupling(law), &domain(), gravity());
            interface.update(0.0, &fluid, &solid);
            let on_fluid = interface.fluid_forces(&fluid, &solid);
            let on_solid = interface.solid_forces(&fluid, &solid);
            assert!(on_fluid.gross_force > 0.0 && on_fluid.pairs == on_solid.pairs);
            // Round-off of some hundred terms.
            assert!((on_fluid.force + on_solid.force).norm() < 1e-14 * on_fluid.gross_force);
            let net_torque = on_fluid.torque + on_solid.torque;
            assert!((net_torque - on_fluid.couple - on_solid.couple).norm() < 1e-14 * on_fluid.gross_torque);
            if law == InterfaceLaw::Wall {
                assert!(net_torque.norm() < 1e-14 * on_fluid.gross_torque);
            } else {
                assert!(net_torque.norm() > 1e-9 * on_fluid.gross_torque, "{law:?} is not central");
            }
        }
    }
}

#[test]
fn spare_particles_change_nothing() {
    let (fluid, solid) = facing_patches(4);
    let mut spare = fluid.clone();
    append(&mut spare, &patch(Vector::new(0.7, 0.7), 5, 5, 9));
    let forces = |fluid: &InterfaceStates| {
        let mut interface = Interface::new(&coupling(InterfaceLaw::Wall), &domain(), gravity());
        interface.update(0.0, fluid, &solid);
        interface.solid_forces(fluid, &solid);
        (0..solid.len()).map(|s| interface.force(s)).collect::<Vec<_>>()
    };
    assert_eq!(forces(&fluid), forces(&spare));
}

#[test]
fn lists_hold_exactly_the_pairs_within_support_in_order() {
    let (fluid, solid) = facing_patches(5);
    let mut interface = Interface::new(&coupling(InterfaceLaw::Wall), &domain(), gravity());
    interface.update(0.0, &fluid, &solid);
    let support = 2.4 * SPACING;
    for f in 0..fluid.len() {
        let expected: Vec<u32> = (0..solid.len())
            .filter(|s| (fluid.position[f] - solid.position[*s]).norm() < support)
            .map(|s| s as u32)
            .collect();
        let found: Vec<u32> = interface.solids_near(f).map(|(s, _)| s as u32).collect();
        assert_eq!(found, expected);
    }
    for s in 0..solid.len() {
        let expected: Vec<u32> = (0..fluid.len())
            .filter(|f| (fluid.position[*f] - solid.position[s]).norm() < support)
            .map(|f| f as u32)
            .collect();
        let found: Vec<u32> = interface.fluids_near(s).map(|(f, _)| f as u32).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn the_dummy_pressure_continues_a_hydrostatic_field() {
    let (mut fluid, solid) = facing_patches(6);
    for f in 0..fluid.len() {
        fluid.density[f] = 1000.0;
        fluid.pressure[f] = 1000.0 * 9.81 * (1.0 - fluid.position[f].y);
    }
    let mut interface = Interface::new(&coupling(InterfaceLaw::Wall), &domain(), gravity());
    interface.update(0.0, &fluid, &solid);
    let mut pairs = 0;
    for s in 0..solid.len() {
        let exact = 1000.0 * 9.81 * (1.0 - solid.position[s].y);
        for (_, dummy) in interface.fluids_near(s) {
            // Eq. (28) is exact for a linear field of constant density: round-off only.
            assert!((dummy.pressure - exact).abs() < 1e-9 * exact);
            pairs += 1;
        }
    }
    assert!(pairs > 50);
}

/// Forces on the left of two fluid regions with a plate of `rows` between them, the right one under `excess` \[Pa\].
fn forces_left_of_a_plate(rows: usize, kernel_ratio: f64, excess: f64) -> Vec<Vector> {
    let mut fluid = patch(Vector::new(0.2, 0.2), 4, 12, 11);
    let left = fluid.len();
    let plate = patch(Vector::new(0.2 + 4.0 * SPACING, 0.2), rows, 12, 12);
    let right = patch(Vector::new(0.2 + (4.0 + rows as f64) * SPACING, 0.2), 4, 12, 13);
    append(&mut fluid, &right);
    fluid.pressure[left..].iter_mut().for_each(|p| *p += excess);
    let mut coupling = coupling(InterfaceLaw::Wall);
    coupling.fluid.kernel_ratio = kernel_ratio;
    let mut interface = Interface::new(&coupling, &domain(), gravity());
    interface.update(0.0, &fluid, &plate);
    let on_plate = interface.solid_forces(&fluid, &plate);
    let on_fluid = interface.fluid_forces(&fluid, &plate);
    assert!((on_fluid.force + on_plate.force).norm() < 1e-14 * on_fluid.gross_force);
    (0..left).map(|f| interface.force(f)).collect()
}

#[test]
fn water_does_not_feel_water_through_a_plate_of_two_rows_or_more() {
    for kernel_ratio in [1.2, 1.3] {
        for rows in [2, 3, 4] {
            let forces = forces_left_of_a_plate(rows, kernel_ratio, 0.0);
            assert!(forces.iter().any(|force| force.norm() > 1.0));
            assert_eq!(forces, forces_left_of_a_plate(rows, kernel_ratio, 1e4), "{rows} rows");
        }
        // Fluid on both sides of a single row interacts with the other side as well as with the row.
        assert_ne!(
            forces_left_of_a_plate(1, kernel_ratio, 0.0),
            forces_left_of_a_plate(1, kernel_ratio, 1e4)
        );
    }
}

#[test]
fn water_that_goes_around_an_edge_is_one() {
    let mut fluid = patch(Vector::new(0.2, 0.2), 4, 12, 14);
    append(&mut fluid, &patch(Vector::new(0.2 + 6.0 * SPACING, 0.2), 4, 12, 15));
    append(&mut fluid, &patch(Vector::new(0.2, 0.2 + 12.0 * SPACING), 10, 3, 16));
    let plate = patch(Vector::new(0.2 + 4.0 * SPACING, 0.2), 2, 12, 17);
    let mut interface = Interface::new(&coupling(InterfaceLaw::Wall), &domain(), gravity());
    interface.update(0.0, &fluid, &plate);
    for s in 0..plate.len() {
        // The two top rows have the water above within their support, and through it both sides.
        assert_eq!(faces(&interface, s), if s / 2 >= 10 { 1 } else { 2 }, "state {s} of the plate");
    }
}

/// Different dummy states that the fluid feels of solid state `s`.
fn faces(interface: &Interface, s: usize) -> usize {
    let pressures = interface.fluids_near(s).map(|(_, dummy)| dummy.pressure.to_bits());
    pressures.collect::<std::collections::BTreeSet<_>>().len()
}

#[test]
fn drops_on_one_side_of_a_body_are_one_water() {
    // Three apart by more than the support of 2.4 spacings, the outer ones within that of the same states.
    let mut fluid = patch(Vector::new(0.2, 0.2), 1, 1, 18);
    for (k, seed) in [(1.0, 23), (2.0, 24)] {
        append(&mut fluid, &patch(Vector::new(0.2 + 3.0 * k * SPACING, 0.2), 1, 1, seed));
    }
    let body = patch(Vector::new(0.2 - 2.0 * SPACING, 0.2 + SPACING), 12, 4, 19);
    let mut interface = Interface::new(&coupling(InterfaceLaw::Wall), &domain(), gravity());
    interface.update(0.0, &fluid, &body);
    let met: Vec<usize> = (0..body.len()).filter(|s| interface.fluids_near(*s).count() > 1).collect();
    assert!(!met.is_empty());
    assert!(met.iter().all(|s| faces(&interface, *s) == 1));
}

#[test]
fn a_plate_parts_waters_at_its_foot_too() {
    // It continues for three rows below the fluid.
    let mut fluid = patch(Vector::new(0.2, 0.2), 4, 8, 20);
    append(&mut fluid, &patch(Vector::new(0.2 + 6.0 * SPACING, 0.2), 4, 8, 21));
    let plate = patch(Vector::new(0.2 + 4.0 * SPACING, 0.2 - 3.0 * SPACING), 2, 11, 22);
    let mut interface = Interface::new(&coupling(InterfaceLaw::Wall), &domain(), gravity());
    interface.update(0.0, &fluid, &plate);
    let below = |s: &usize| plate.position[*s].y < 0.2 && interface.fluids_near(*s).any(|(f, _)| f < 32);
    let both = |s: &usize| interface.fluids_near(*s).any(|(f, _)| f >= 32);
    let foot: Vec<usize> = (0..plate.len()).filter(below).filter(both).collect();
    assert!(!foot.is_empty());
    assert!(foot.iter().all(|s| faces(&interface, *s) == 2));
}

/// Repulsion \[N\] of a fluid particle that moves at `velocity` \[m/s\], `height` spacings over the outer row of a solid and
/// `phase` spacings along it.
fn repelled(height: f64, phase: f64, velocity: Vector) -> Vector {
    let at = |k: i32, row: i32| Vector::new(0.5 + f64::from(k) * SPACING, 0.4 - f64::from(row) * SPACING);
    let mut solid = patch(Vector::zeros(), 21, 6, 32);
    solid.position = (0..6).flat_map(|row| (-10..=10).map(move |k| at(k, row))).collect();
    solid.velocity.fill(Vector::zeros());
    solid.density.fill(1100.0);
    solid.mass.fill(1100.0 * SPACING * SPACING);
    let mut fluid = patch(Vector::zeros(), 1, 1, 33);
    fluid.position = vec![Vector::new(0.5 + phase * SPACING, 0.4 + height * SPACING)];
    fluid.velocity = vec![velocity];
    fluid.density = vec![1000.0];
    // Neither pressure nor viscosity: all is repulsion.
    fluid.pressure = vec![0.0];
    let mut coupling = coupling(InterfaceLaw::Wall);
    (coupling.fluid.viscosity_a, coupling.fluid.viscosity_b) = (0.0, 0.0);
    let mut interface = Interface::new(&coupling, &domain(), BodyForceField::uniform(Vector::zeros()));
    interface.update(0.0, &fluid, &solid);
    let on_solid = interface.solid_forces(&fluid, &solid).force;
    let on_fluid = interface.fluid_forces(&fluid, &solid).force;
    assert!((on_solid + on_fluid).norm() <= 1e-14 * on_fluid.norm());
    interface.force(0) / fluid.mass[0]
}

#[test]
fn faces_of_solids_repel_along_their_normal_wherever_water_meets_them() {
    let rest = Vector::zeros();
    let frequency_squared = 0.5 * (20.0f64 / SPACING).powi(2);
    for phase in [0.0, 0.2, 0.5] {
        // The height varies by 0.004 spacings along the row.
        assert_eq!(repelled(0.61, phase, rest), Vector::zeros());
        assert_eq!(repelled(1.0, phase, Vector::new(0.0, -1.0)), Vector::zeros());
        for (height, allowed) in [(0.4, 0.05), (0.2, 0.15), (0.0, 0.35)] {
            let found = repelled(height, phase, rest);
            let expected = frequency_squared * (0.6 - height) * SPACING;
            // Toward the outer row the sums flatten: the force there is lower, not the energy of a particle that reaches it.
            assert!((found.y / expected - 1.0).abs() < allowed, "{height} {phase}: {}", found.y / expected);
            assert!(found.x.abs() < 0.02 * found.y, "{height} {phase}: {found}");
        }
    }
    // In a hollow behind the outer row pairs would let it pass.
    assert!(repelled(-0.5, 0.5, rest).y > 0.1 * frequency_squared * SPACING);
    let approaching = repelled(0.4, 0.0, Vector::new(0.0, -1e-3)).y;
    let parting = repelled(0.4, 0.0, Vector::new(0.0, 1e-3)).y;
    assert!(approaching > repelled(0.4, 0.0, rest).y && parting < repelled(0.4, 0.0, rest).y);
    assert_eq!(repelled(0.4, 0.0, Vector::new(0.0, 1e3)), Vector::zeros(), "never pulls");
}

/// Three columns of a solid right of a lattice of fluid, and the particle at half its height in each.
fn straight_face() -> (InterfaceStates, InterfaceStates, [usize; 3]) {
    let lattice = |lower: Vector, columns: usize| {
        let mut states = patch(lower, columns, 9, 1);
        for (k, x) in states.position.iter_mut().enumerate() {
            *x = lower + Vector::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5) * SPACING;
        }
        states
    };
    let corner = Vector::new(0.2, 0.2);
    (lattice(corner, 4), lattice(corner + Vector::new(4.0 * SPACING, 0.0), 3), [12, 13, 14])
}

#[test]
fn a_solid_shows_the_mean_velocity_mirrored_at_its_face() {
    let (mut fluid, mut solid, middle) = straight_face();
    let (flow, motion) = (Vector::new(0.3, -0.2), Vector::new(0.1, 0.5));
    fluid.velocity.fill(flow);
    solid.velocity.fill(motion);
    for (law, expected) in [
        // The face is at right angles to x.
        (InterfaceLaw::Wall, Vector::new(2.0 * motion.x - flow.x, flow.y)),
        (InterfaceLaw::WallNoSlip, 2.0 * motion - flow),
        (InterfaceLaw::PlainSum, motion),
    ] {
        let mut interface = Interface::new(&coupling(law), &domain(), gravity());
        interface.update(0.0, &fluid, &solid);
        // The third column lies beyond the support.
        for s in &middle[..2] {
            let shown: Vec<Vector> = interface.fluids_near(*s).map(|(_, dummy)| dummy.velocity).collect();
            // Round-off of a mean.
            assert!(
                shown.len() > 2 && shown.iter().all(|shown| (shown - expected).norm() < 1e-14),
                "{law:?}"
            );
        }
    }
}

#[test]
fn a_row_amid_one_water_shows_its_own_velocity() {
    // Fluid on both sides of a row, that interacts across it: no side is that of the face.
    let (mut fluid, mut row, [middle, ..]) = straight_face();
    let mut right = fluid.clone();
    right.position.iter_mut().for_each(|x| x.x += 5.0 * SPACING);
    append(&mut fluid, &right);
    let columns = 3;
    let keep: Vec<usize> = (0..row.len()).step_by(columns).collect();
    row = InterfaceStates {
        id: (0..keep.len() as u32).collect(),
        group: vec![0; keep.len()],
        mass: keep.iter().map(|k| row.mass[*k]).collect(),
        position: keep.iter().map(|k| row.position[*k]).collect(),
        velocity: vec![Vector::new(0.1, 0.5); keep.len()],
        density: keep.iter().map(|k| row.density[*k]).collect(),
        pressure: keep.iter().map(|k| row.pressure[*k]).collect(),
        stress: Vec::new(),
    };
    fluid.velocity.fill(Vector::new(0.3, -0.2));
    let mut interface = Interface::new(&coupling(InterfaceLaw::Wall), &domain(), gravity());
    interface.update(0.0, &fluid, &row);
    let shown: Vec<Vector> =
        interface.fluids_near(middle / columns).map(|(_, dummy)| dummy.velocity).collect();
    // Round-off leaves a direction, but no side.
    assert!(shown.len() > 5 && shown.iter().all(|v| (v - Vector::new(0.1, 0.5)).norm() < 1e-12), "{shown:?}");
}

#[test]
fn both_sides_of_a_no_slip_interface_evaluate_the_same_bits() {
    let (fluid, solid) = facing_patches(26);
    let mut spare_fluid = fluid.clone();
    append(&mut spare_fluid, &patch(Vector::new(0.7, 0.7), 5, 5, 27));
    let mut spare_solid = solid.clone();
    append(&mut spare_solid, &patch(Vector::new(0.2, 0.7), 5, 5, 28));
    // Each side may hold particles that the other does not.
    let pairs = |fluid: &InterfaceStates, solid: &InterfaceStates| {
        let mut interface = Interface::new(&coupling(InterfaceLaw::WallNoSlip), &domain(), gravity());
        interface.update(0.0, fluid, solid);
        let mut pairs = Vec::new();
        for f in 0..fluid.len() {
            for (s, dummy) in interface.solids_near(f) {
                let x_fs = fluid.position[f] - solid.position[s];
                let shown = (dummy, interface.gradients.at(s));
                let force =
                    interface.law.force_on_fluid(&x_fs, [fluid, solid], [f, s], shown, interface.barriers[f]);
                pairs.push((f, s, dummy.velocity.map(f64::to_bits), force.map(f64::to_bits)));
            }
        }
        pairs
    };
    let of_fluid = pairs(&fluid, &spare_solid);
    assert!(of_fluid.len() > 50);
    assert_eq!(of_fluid, pairs(&spare_fluid, &solid));
}

#[test]
fn fluid_beyond_a_plate_is_not_part_of_the_mean_velocity() {
    // Rows of fluid, two of the plate, and fluid again; the right one moves.
    let mut fluid = patch(Vector::new(0.2, 0.2), 4, 12, 29);
    let left = fluid.len();
    append(&mut fluid, &patch(Vector::new(0.2 + 6.0 * SPACING, 0.2), 4, 12, 30));
    fluid.velocity.fill(Vector::zeros());
    fluid.velocity[left..].fill(Vector::new(0.0, 1.0));
    let mut plate = patch(Vector::new(0.2 + 4.0 * SPACING, 0.2), 2, 12, 31);
    plate.velocity.fill(Vector::zeros());
    let mut interface = Interface::new(&coupling(InterfaceLaw::WallNoSlip), &domain(), gravity());
    interface.update(0.0, &fluid, &plate);
    for s in 0..plate.len() {
        for (f, dummy) in interface.fluids_near(s) {
            let expected = if f < left { 0.0 } else { -1.0 };
            // Round-off of a mean.
            assert!((dummy.velocity.y - expected).abs() < 1e-14, "fluid {f}, solid {s}");
        }
    }
}

/// `states` at the indices `keep`, with new identities.
fn part(states: &InterfaceStates, keep: &[usize]) -> InterfaceStates {
    let pick = |column: &[f64]| keep.iter().map(|k| column[*k]).collect();
    InterfaceStates {
        id: (0..keep.len() as u32).collect(),
        group: keep.iter().map(|k| states.group[*k]).collect(),
        mass: pick(&states.mass),
        position: keep.iter().map(|k| states.position[*k]).collect(),
        velocity: keep.iter().map(|k| states.velocity[*k]).collect(),
        density: pick(&states.density),
        pressure: pick(&states.pressure),
        stress: keep.iter().filter_map(|k| states.stress.get(*k).copied()).collect(),
    }
}

#[test]
fn fluid_that_moves_with_a_body_is_at_rest_beside_it() {
    let (mut fluid, mut solid) = facing_patches(32);
    let column: Vec<usize> = (0..solid.len()).step_by(6).collect();
    let turning = nalgebra::Matrix2::new(0.0, -3.0, 3.0, 0.0);
    let any = nalgebra::Matrix2::new(2.0, -3.0, 0.5, 1.0);
    // One column has no extent across it, so that only its turn is known.
    let straight = {
        let mut column = part(&solid, &column);
        column.position.iter_mut().for_each(|x| x.x = 0.2 + 8.5 * SPACING);
        column
    };
    for (mut body, motion, turns) in
        [(solid.clone(), turning, true), (solid.clone(), any, false), (straight, turning, true)]
    {
        let moves = |x: &Vector| Vector::new(0.3, -0.1) + motion * x;
        fluid.velocity = fluid.position.iter().map(moves).collect();
        body.velocity = body.position.iter().map(moves).collect();
        let mut interface = Interface::new(&coupling(InterfaceLaw::WallNoSlip), &domain(), gravity());
        interface.update(0.0, &fluid, &body);
        let mut met = 0;
        for s in 0..body.len() {
            for (_, dummy) in interface.fluids_near(s) {
                // Round-off of a fit.
                assert!((dummy.velocity - body.velocity[s]).norm() < 1e-12, "particle {s}");
                met += 1;
            }
        }
        assert!(met > 50);
        if turns {
            // Pressure and repulsion are central: no force has a part that is not along the line of centres but for round-off of
            // a term of the size of 1e-3 N/m.
            for f in 0..fluid.len() {
                for (s, dummy) in interface.solids_near(f) {
                    let x_fs = fluid.position[f] - body.position[s];
                    let shown = (dummy, interface.gradients.at(s));
                    let force = interface.law.force_on_fluid(
                        &x_fs,
                        [&fluid, &body],
                        [f, s],
                        shown,
                        interface.barriers[f],
                    );
                    assert!(x_fs.normalize().perp(&force).abs() < 1e-14, "pair {f}, {s}");
                }
            }
        }
    }
    // A body beside it that moves otherwise is not part of it.
    let dummies = |solid: &InterfaceStates| {
        let mut interface = Interface::new(&coupling(InterfaceLaw::WallNoSlip), &domain(), gravity());
        interface.update(0.0, &fluid, solid);
        let met: Vec<usize> =
            (0..solid.len()).filter(|s| interface.fluids_near(*s).next().is_some()).collect();
        let shown = |s: &usize| interface.fluids_near(*s).map(|(_, dummy)| *dummy).collect::<Vec<_>>();
        let shown: Vec<_> = met.iter().map(shown).collect();
        (met, shown)
    };
    let (met, shown) = dummies(&solid);
    // A partner sends the particles near the fluid only.
    assert!(met.len() < solid.len());
    assert_eq!(dummies(&part(&solid, &met)).1, shown);
    let half = solid.len() / 2;
    solid.group[half..].fill(1);
    let (both, one) = (dummies(&solid).1, dummies(&part(&solid, &(0..half).collect::<Vec<_>>())).1);
    let own = met.iter().filter(|s| **s < half - 6).count();
    assert!(own > 3);
    assert_eq!(both[..own], one[..own]);
}
