//! Particles of the fluid regions.

use sph::domain::Domain;
use sph::shapes::{Shape, displace};
use sph::vector::Vector;

use super::lattice::Lattice;
use super::overlap::{first_clashes, overlaps};
use super::start::{field, start};
use super::wall::retain;
use super::{Scene, index, report_outside, shown};
use crate::case::file::CaseFile;
use crate::case::file::fluid::{FluidTable, RegionTable};
use crate::case::mistakes::Mistake;

/// Lays out all regions, cut by solids and walls where they say so.
pub fn lay_out(
    file: &CaseFile,
    fluid: &FluidTable,
    domain: &Domain,
    lattice: &mut Lattice<'_>,
    scene: &mut Scene,
) {
    let spacing = fluid.particle_spacing_m.value;
    let mut laid: Vec<(usize, Vec<Vector>)> = Vec::new();
    for (k, region) in fluid.regions.iter().enumerate() {
        if let Some(shape) = region.shape.as_ref().filter(|_| region.intact) {
            let mut positions = lattice.fill(shape, spacing, region.lattice_origin_m.as_ref());
            let mistake = Mistake::new(&shape.place, "");
            let what = format!("region `{}`", region.name.value);
            report_outside(mistake, &what, domain, positions.iter(), lattice.mistakes);
            cut(file, fluid, region, domain, &mut positions, lattice, scene);
            laid.push((k, positions));
        }
    }
    report_clashes(fluid, domain, &laid, lattice);
    for (k, mut positions) in laid {
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
        let gravity = file.body_force.gravity_m_s2;
        let started =
            start(&region.start, place, &fluid.constants(), gravity, &mut positions, lattice.mistakes);
        let particles = &mut scene.fluid;
        particles.id.extend((particles.id.len()..particles.id.len() + positions.len()).map(index));
        particles.region.extend(std::iter::repeat_n(index(k), positions.len()));
        particles.mass.extend(started.mass);
        particles.density.extend(started.density);
        particles.velocity.extend(field(&region.velocity_m_s, &positions, lattice.mistakes));
        particles.position.extend(positions);
    }
}

/// Removes the particles of a region that stand in solids or walls, or reports them.
fn cut(
    file: &CaseFile,
    fluid: &FluidTable,
    region: &RegionTable,
    domain: &Domain,
    positions: &mut Vec<Vector>,
    lattice: &Lattice<'_>,
    scene: &mut Scene,
) {
    let spacing = fluid.particle_spacing_m.value;
    let before = positions.len();
    if let Some(solid) = file.solid.as_ref().filter(|solid| solid.intact) {
        let shapes: Vec<Shape> =
            solid.bodies.iter().filter_map(|body| Some(body.shape.as_ref()?.value.to_shape())).collect();
        let boxes: Vec<(Vector, Vector)> = shapes.iter().map(Shape::bounds).collect();
        let inside = |x: &Vector| {
            let near =
                |(lower, upper): &(Vector, Vector)| (0..2).all(|k| (lower[k]..=upper[k]).contains(&x[k]));
            shapes.iter().zip(&boxes).any(|(shape, around)| near(around) && shape.contains(x))
        };
        let list =
            overlaps(domain, positions, &scene.solid.position, [spacing, solid.particle_spacing_m.value]);
        let kept: Vec<bool> =
            (0..positions.len()).map(|k| list.of(k).is_empty() && !inside(&positions[k])).collect();
        let obstacle = Obstacle { name: "solids", key: "cut_by_solids", cuts: region.cut_by_solids };
        obstacle.make_way(region, positions, &kept, lattice, scene);
    }
    let list = overlaps(domain, positions, &scene.walls.position, [spacing; 2]);
    let kept: Vec<bool> = (0..positions.len()).map(|k| list.of(k).is_empty()).collect();
    let obstacle = Obstacle { name: "walls", key: "cut_by_walls", cuts: region.cut_by_walls };
    obstacle.make_way(region, positions, &kept, lattice, scene);
    if positions.is_empty() && before > 0 {
        let mistake = Mistake::new(&region.name.place, "no particle is left beside solids and walls");
        lattice.mistakes.add(mistake.value(&region.name.value).hint("move or enlarge its shape"));
    }
}

/// What fluid can not stand in.
struct Obstacle {
    name: &'static str,
    key: &'static str,
    cuts: bool,
}

impl Obstacle {
    /// Removes the particles that are not `kept` when the obstacle cuts the region; otherwise they are a mistake.
    fn make_way(
        &self,
        region: &RegionTable,
        positions: &mut Vec<Vector>,
        kept: &[bool],
        lattice: &Lattice<'_>,
        scene: &mut Scene,
    ) {
        let Some(first) = kept.iter().position(|kept| !kept) else { return };
        if !self.cuts {
            let problem = format!("overlaps {} at {}", self.name, shown(&positions[first]));
            let mistake = Mistake::new(&region.name.place, problem).value(&region.name.value);
            lattice.mistakes.add(mistake.hint(format!("set `{} = true` or change the shape", self.key)));
            return;
        }
        let cut = kept.iter().filter(|kept| !**kept).count();
        retain(positions, kept);
        scene
            .cuts
            .push(format!("region `{}`: {cut} particles make way for {}", region.name.value, self.name));
    }
}

fn report_clashes(fluid: &FluidTable, domain: &Domain, laid: &[(usize, Vec<Vector>)], lattice: &Lattice<'_>) {
    let positions: Vec<Vector> = laid.iter().flat_map(|(_, positions)| positions).copied().collect();
    let regions: Vec<u32> =
        laid.iter().flat_map(|(k, positions)| std::iter::repeat_n(index(*k), positions.len())).collect();
    for clash in first_clashes(domain, &positions, &regions, fluid.particle_spacing_m.value) {
        let names = [clash.groups.0, clash.groups.1].map(|region| &fluid.regions[region as usize].name);
        let problem = format!("overlaps the region `{}` at {}", names[0].value, shown(&clash.position));
        let mistake = Mistake::new(&names[1].place, problem).value(&names[1].value);
        lattice.mistakes.add(mistake.hint("make the shapes disjoint, for example with a difference"));
    }
}
