//! Particles of the solid bodies.

use sph::setup::SolidParticles;
use sph::shapes::Region;
use sph::space::domain::Domain;

use super::filling::{Cells, Filled, Filling, Otherwise, named};
use super::lattice::Lattice;
use super::loads::{faces, faces_of};
use super::overlap::first_clashes;
use super::space::SceneSpace;
use super::start::field;
use super::thickness::{Laid, check_thickness};
use super::{Scene, index, meets_itself, point_text, report_outside};
use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::CaseFile;
use crate::case::file::body::BodyTable;
use crate::case::file::material::FormulationTable;
use crate::case::file::solid::SolidTable;
use crate::case::file::support::SupportTable;
use crate::quote::quoted;

/// Lays out all bodies.
pub fn lay_out<S: SceneSpace>(
    file: &CaseFile,
    solid: &SolidTable,
    domain: &Domain<S>,
    lattice: &mut Lattice<'_, S>,
    scene: &mut Scene<S>,
) {
    scene.loads = vec![Vec::new(); solid.bodies.len()];
    scene.across = vec![None; solid.bodies.len()];
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
            format!(
                "overlaps the body `{}` at {}",
                quoted(&names[0].value),
                point_text::<S>(&clash.position)
            ),
        );
        errors.add(error.value(&names[1].value).hint("leave at least one particle spacing between bodies"));
    }
}

fn lay_out_body<S: SceneSpace>(
    file: &CaseFile,
    solid: &SolidTable,
    number: u32,
    body: &BodyTable,
    domain: &Domain<S>,
    lattice: &mut Lattice<'_, S>,
    scene: &mut Scene<S>,
) {
    let Some(shape) = &body.shape else { return };
    let region = S::shape(&shape.value);
    let spacing = solid.particle_spacing_m.value;
    let what = named("body", &body.name.value);
    let filled = Filled {
        what: &what,
        shape,
        spacing,
        origin: body.lattice_origin_m.as_ref(),
        layout: body.layout.value,
        otherwise: match body.formulation {
            // Its sums in the current configuration start quietest on the lattice.
            FormulationTable::UpdatedLagrangian(_) => Otherwise::Scaled,
            FormulationTable::TotalLagrangian(_) | FormulationTable::Rigid => Otherwise::Fitted,
        },
    };
    let Filling { mut positions, mut cells } = lattice.lay(&filled, &mut scene.adjusted);
    if meets_itself::<S>(&shape.place, &what, file, &positions, spacing, lattice.errors) {
        positions.clear();
        cells = Cells::Lattice;
    }
    let before = lattice.errors.count();
    let supports = assign_supports::<S>(body, &positions, lattice.errors);
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
    scene.loads[number as usize] = match cells {
        Cells::Lattice => faces::<S>(body, &positions, spacing, lattice.errors),
        _ => faces_of::<S>(body, &region, &positions, spacing, lattice.errors),
    };
    let laid = Laid::<S> { shape: &region, positions: &positions, cells: &cells, spacing };
    scene.across[number as usize] = check_thickness(body, &laid, lattice.errors, &mut scene.warnings);

    let material = body.material.parameters.values();
    let mut velocities = field::<S>(&body.velocity_m_s, &positions, lattice.errors);
    let centre = match cells.volume() {
        None => positions.iter().copied().sum::<S::Vector>() / positions.len().max(1) as f64,
        Some(volume) => {
            positions.iter().zip(volume).map(|(x, v)| *x * *v).sum::<S::Vector>() / volume.iter().sum::<f64>()
        }
    };
    let spin = body.rotation_speed_rad_s.to::<S>();
    for (velocity, x) in velocities.iter_mut().zip(&positions) {
        *velocity += S::spin_cross(spin, &(*x - centre));
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
    match cells.volume() {
        None => mass.extend(std::iter::repeat_n(material.density * S::cell_volume(spacing), count)),
        Some(volume) => mass.extend(volume.iter().map(|volume| material.density * volume)),
    }
    reference_position.extend_from_slice(&positions);
    position.extend(positions);
    velocity.extend(velocities);
    density.extend(std::iter::repeat_n(material.density, count));
    deviatoric_stress.extend(std::iter::repeat_n(S::SymmetricTensor::default(), count));
}

/// 0 for free particles, k for those that support k−1 holds.
fn assign_supports<S: SceneSpace>(body: &BodyTable, positions: &[S::Vector], errors: &ErrorList) -> Vec<u32> {
    let mut assigned = vec![0; positions.len()];
    for (k, support) in body.supports.iter().enumerate() {
        let Some(written) = &support.shape else { continue };
        let shape = S::shape(&written.value);
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
                let problem =
                    format!("holds the particle at {} that `{other}` holds already", point_text::<S>(x));
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
