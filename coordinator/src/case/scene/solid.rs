//! Particles of the solid bodies.

use sph::setup::SolidParticles;
use sph::space::domain::Domain;
use sph::space::{SymmetricTensor, Vector};

use super::lattice::Lattice;
use super::loads::faces;
use super::overlap::first_clashes;
use super::start::field;
use super::{Scene, index, meets_itself, point_text, report_outside};
use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::CaseFile;
use crate::case::file::body::BodyTable;
use crate::case::file::material::FormulationTable;
use crate::case::file::solid::SolidTable;
use crate::case::file::support::SupportTable;
use crate::quote::quoted;

/// Bodies with fewer particles across bend far too easily.
const ENOUGH_ACROSS: usize = 6;

/// Bodies with fewer particles across have no bending stiffness at all.
const LEAST_ACROSS: usize = 2;

/// Lays out all bodies.
pub fn lay_out(
    file: &CaseFile,
    solid: &SolidTable,
    domain: &Domain,
    lattice: &mut Lattice<'_>,
    scene: &mut Scene,
) {
    scene.loads = vec![Vec::new(); solid.bodies.len()];
    for (k, body) in solid.bodies.iter().enumerate() {
        if body.intact {
            lay_out_body(file, solid, index(k), body, domain, lattice, scene);
        }
    }
    let (particles, spacing) = (&scene.solid, &solid.particle_spacing_m);
    let errors = lattice.errors;
    let clashes =
        first_clashes(domain, &particles.position, &particles.body, spacing.value, &spacing.place, errors);
    for clash in clashes {
        let names = [clash.groups.0, clash.groups.1].map(|body| &solid.bodies[body as usize].name);
        let error = CaseError::new(
            &names[1].place,
            format!("overlaps the body `{}` at {}", quoted(&names[0].value), point_text(&clash.position)),
        );
        errors.add(error.value(&names[1].value).hint("leave at least one particle spacing between bodies"));
    }
}

fn lay_out_body(
    file: &CaseFile,
    solid: &SolidTable,
    number: u32,
    body: &BodyTable,
    domain: &Domain,
    lattice: &mut Lattice<'_>,
    scene: &mut Scene,
) {
    let Some(shape) = &body.shape else { return };
    let spacing = solid.particle_spacing_m.value;
    let mut positions = lattice.fill(shape, spacing, body.lattice_origin_m.as_ref());
    let what = format!("body `{}`", quoted(&body.name.value));
    if meets_itself(&shape.place, &what, file, &positions, spacing, lattice.errors) {
        positions.clear();
    }
    let before = lattice.errors.count();
    let supports = assign_supports(body, &positions, lattice.errors);
    if lattice.errors.count() == before {
        // A support that is released by then holds nothing.
        let start = file.time.start_time_s;
        let holds = |support: &SupportTable| support.release_time_s.is_none_or(|release| release > start);
        let is_held =
            |slot: u32| slot.checked_sub(1).and_then(|k| body.supports.get(k as usize)).is_some_and(holds);
        let free = positions.iter().zip(&supports).filter(|(_, slot)| !is_held(**slot)).map(|(x, _)| x);
        let error = CaseError::new(&shape.place, "").value(&body.name.value);
        report_outside(error, &format!("body `{}`", quoted(&body.name.value)), domain, free, lattice.errors);
    } else {
        scene.unsupported.insert(number);
    }
    scene.loads[number as usize] = faces(body, &positions, spacing, lattice.errors);
    check_thickness(body, &positions, spacing, lattice.errors, &mut scene.warnings);

    let material = body.material.parameters.values();
    let mut velocities = field(&body.velocity_m_s, &positions, lattice.errors);
    let centre = positions.iter().sum::<Vector>() / positions.len().max(1) as f64;
    for (velocity, x) in velocities.iter_mut().zip(&positions) {
        let r = x - centre;
        *velocity += body.rotation_speed_rad_s * Vector::new(-r.y, r.x);
    }
    let count = positions.len();
    let SolidParticles {
        id,
        body: bodies,
        support,
        mass,
        reference_position,
        position,
        velocity,
        density,
        deviatoric_stress,
    } = &mut scene.solid;
    id.extend((id.len()..id.len() + count).map(index));
    bodies.extend(std::iter::repeat_n(number, count));
    support.extend(supports);
    mass.extend(std::iter::repeat_n(material.density * spacing * spacing, count));
    reference_position.extend_from_slice(&positions);
    position.extend(positions);
    velocity.extend(velocities);
    density.extend(std::iter::repeat_n(material.density, count));
    deviatoric_stress.extend(std::iter::repeat_n(SymmetricTensor::default(), count));
}

/// 0 for free particles, k for those that support k−1 holds.
fn assign_supports(body: &BodyTable, positions: &[Vector], errors: &ErrorList) -> Vec<u32> {
    let mut assigned = vec![0; positions.len()];
    for (k, support) in body.supports.iter().enumerate() {
        let Some(written) = &support.shape else { continue };
        let shape = written.value.to_shape();
        if !errors.spend(&written.place, positions.len() as f64 * (2 + written.value.pieces()) as f64) {
            break;
        }
        let mut held = 0_usize;
        for (slot, x) in assigned.iter_mut().zip(positions).filter(|(_, x)| shape.contains(x)) {
            held += 1;
            if *slot == 0 {
                *slot = index(k + 1);
            } else if *slot <= index(k) {
                let other = quoted(&body.supports[*slot as usize - 1].name.value);
                let problem = format!("holds the particle at {} that `{other}` holds already", point_text(x));
                errors.add(
                    CaseError::new(&written.place, problem).hint("make the shapes of the supports disjoint"),
                );
                break;
            }
        }
        if held == 0 && !positions.is_empty() {
            let (name, of) = (quoted(&support.name.value), quoted(&body.name.value));
            let problem = format!("support `{name}` holds no particle of `{of}`");
            let error = CaseError::new(&written.place, problem);
            errors
                .add(error.hint(
                    "its shape must contain centres of particles of the body as laid out at the start",
                ));
        }
    }
    assigned
}

/// Warns of bodies that are too thin to bend as they should, refuses those without thickness.
fn check_thickness(
    body: &BodyTable,
    positions: &[Vector],
    spacing: f64,
    errors: &ErrorList,
    warnings: &mut Vec<String>,
) {
    if positions.is_empty() || matches!(body.formulation, FormulationTable::Rigid) {
        return;
    }
    let across = particles_across(positions, spacing);
    if across < LEAST_ACROSS {
        let error = CaseError::new(&body.name.place, format!("is {across} particle across its thin side"));
        errors.add(
            error
                .value(&body.name.value)
                .allowed(format!("at least {LEAST_ACROSS}"))
                .hint("use a smaller `solid.particle_spacing_m` or a thicker shape"),
        );
    } else if across < ENOUGH_ACROSS {
        let compliance = bending_compliance(&body.formulation, across);
        warnings.push(format!(
            "body `{}` is about {across} particles across its thin side; below {ENOUGH_ACROSS} its bending is no longer \
             resolved: it bends about {compliance:.2} times as easily as it should",
            body.name.value
        ));
    }
}

/// Bending compliance of a plate of few particles across over that of its material \[-\], measured at ν = 0.4.
fn bending_compliance(formulation: &FormulationTable, across: usize) -> f64 {
    match formulation {
        // Static cantilevers in a linear model of the sums: 0.70 at 2 across, 1.02, 1.01 and 1.015 at 3, 4 and 5.
        FormulationTable::TotalLagrangian(_) if across == 2 => 0.7,
        FormulationTable::TotalLagrangian(_) => 1.02,
        // Cantilever of Gray et al. (2001): periods 29 % too long at 6 across, 19 % at 10.
        _ => (1.0 + 1.8 / across as f64).powi(2),
    }
}

/// Particles across the thin side: median over the particles of the shorter of the two rows they stand in.
pub fn particles_across(positions: &[Vector], spacing: f64) -> usize {
    let mut shorter = row_lengths(positions, spacing, 0);
    for (a, b) in shorter.iter_mut().zip(row_lengths(positions, spacing, 1)) {
        *a = (*a).min(b);
    }
    shorter.sort_unstable();
    shorter[shorter.len() / 2]
}

/// For every particle the number of particles in its unbroken row along `axis`.
fn row_lengths(positions: &[Vector], spacing: f64, axis: usize) -> Vec<usize> {
    let across = 1 - axis;
    let mut order: Vec<usize> = (0..positions.len()).collect();
    let row = |k: usize| (positions[k][across] / spacing).round();
    order.sort_by(|&a, &b| row(a).total_cmp(&row(b)).then(positions[a][axis].total_cmp(&positions[b][axis])));
    let mut lengths = vec![0; positions.len()];
    let unbroken = |a: &usize, b: &usize| {
        row(*a) == row(*b) && (positions[*b][axis] - positions[*a][axis]).abs() < 1.5 * spacing
    };
    for run in order.chunk_by(unbroken) {
        for &k in run {
            lengths[k] = run.len();
        }
    }
    lengths
}
