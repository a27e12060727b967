//! Particles of the fluid regions.

use sph::shapes::displace;
use sph::space::domain::Domain;

use super::filling::{Filled, Filling, Otherwise, named};
use super::lattice::Lattice;
use super::obstacles::Obstacles;
use super::overlap::first_clashes;
use super::space::SceneSpace;
use super::start::{Water, field, start};
use super::{Scene, index, meets_itself, point_text, report_outside};
use crate::case::errors::CaseError;
use crate::case::file::CaseFile;
use crate::case::file::fluid::FluidTable;
use crate::case::file::layout::Layout;
use crate::quote::quoted;

/// Lays out all regions, cut by solids and walls where they say so.
pub fn lay_out<S: SceneSpace>(
    file: &CaseFile,
    fluid: &FluidTable,
    domain: &Domain<S>,
    lattice: &mut Lattice<'_, S>,
    scene: &mut Scene<S>,
) {
    let spacing = fluid.parameters.particle_spacing;
    let mut laid: Vec<(usize, Filling<S>)> = Vec::new();
    let Scene { fluid: particles, solid, walls, adjusted, cuts, warnings, .. } = scene;
    let obstacles = Obstacles::of(file, spacing, domain, &solid.position, &walls.position);
    for (k, region) in fluid.regions.iter().enumerate() {
        if let Some(shape) = region.shape.as_ref().filter(|_| region.intact) {
            let what = named("region", &region.name.value);
            let filled = Filled {
                what: &what,
                shape,
                spacing,
                origin: region.lattice_origin_m.as_ref(),
                layout: region.layout.value,
                // Water arranges itself as it flows.
                otherwise: Otherwise::Scaled,
            };
            let known = adjusted.len();
            let mut filling = lattice.lay(&filled, adjusted);
            // On the lattice water would stand apart from walls along its faces. In space layers take long to lay out.
            if S::DIMENSIONS == 2
                && region.layout.value == Layout::Auto
                && !lattice.fits(&filled)
                && obstacles.walls_hold_any(region, &filling, lattice.errors)
            {
                adjusted.truncate(known);
                filling = lattice.lay(&Filled { layout: Layout::Fitted, ..filled }, adjusted);
            }
            let error = CaseError::new(&shape.place, "");
            if meets_itself::<S>(&shape.place, &what, file, &filling.positions, spacing, lattice.errors) {
                filling = Filling::default();
            }
            report_outside(error, &what, domain, filling.positions.iter(), lattice.errors);
            obstacles.cut(region, shape, &mut filling, lattice, (cuts, warnings));
            laid.push((k, filling));
        }
    }
    report_clashes(fluid, domain, &laid, lattice);
    for (k, Filling { mut positions, cells }) in laid {
        let region = &fluid.regions[k];
        if region.displacement_fraction > 0.0 {
            displace(
                &mut positions,
                region.displacement_fraction * spacing,
                region.displacement_seed,
                domain,
            );
        }
        let place = &region.name.place;
        let gravity = file.body_force.gravity_m_s2.to::<S>();
        let constants = fluid.parameters.values();
        let water = Water::<S> { constants: &constants, gravity, volume: cells.volume() };
        let started = start(&region.start, place, &water, &mut positions, lattice.errors);
        particles.id.extend((particles.id.len()..particles.id.len() + positions.len()).map(index));
        particles.region.extend(std::iter::repeat_n(index(k), positions.len()));
        particles.mass.extend(started.mass);
        particles.density.extend(started.density);
        particles.velocity.extend(field::<S>(&region.velocity_m_s, &positions, lattice.errors));
        particles.position.extend(positions);
    }
}

fn report_clashes<S: SceneSpace>(
    fluid: &FluidTable,
    domain: &Domain<S>,
    laid: &[(usize, Filling<S>)],
    lattice: &Lattice<'_, S>,
) {
    let positions: Vec<S::Vector> =
        laid.iter().flat_map(|(_, filling)| &filling.positions).copied().collect();
    let regions: Vec<u32> =
        laid.iter().flat_map(|(k, laid)| std::iter::repeat_n(index(*k), laid.positions.len())).collect();
    let (spacing, errors) = (&fluid.spacing(), lattice.errors);
    for clash in first_clashes(domain, &positions, &regions, spacing.value, &spacing.place, errors) {
        let names = [clash.groups.0, clash.groups.1].map(|region| &fluid.regions[region as usize].name);
        let problem = format!(
            "overlaps the region `{}` at {}",
            quoted(&names[0].value),
            point_text::<S>(&clash.position)
        );
        let error = CaseError::new(&names[1].place, problem).value(&names[1].value);
        errors.add(error.hint("make the shapes disjoint, for example with a difference"));
    }
}
