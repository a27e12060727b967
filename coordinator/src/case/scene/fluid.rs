//! Particles of the fluid regions.

use sph::neighbours::CellGrid;
use sph::shapes::{Region, displace};
use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use super::filling::{Filled, Filling, Otherwise, named};
use super::lattice::Lattice;
use super::overlap::{Crowd, first_clashes};
use super::space::SceneSpace;
use super::start::{Water, field, start};
use super::wall::retain;
use super::{Scene, index, meets_itself, point_text, report_outside};
use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::CaseFile;
use crate::case::file::fluid::{FluidTable, RegionTable};
use crate::case::file::shape::ShapeTable;
use crate::case::file::solid::SolidTable;
use crate::case::reader::At;
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
    let Scene { fluid: particles, solid, walls, adjusted, cuts, .. } = scene;
    let obstacles = Obstacles {
        solids: file
            .solid
            .as_ref()
            .filter(|solid| solid.intact)
            .map(|table| Solids::of(table, spacing, domain, &solid.position)),
        walls: Crowd::new(domain, &walls.position, [spacing; 2]),
    };
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
            let mut filling = lattice.lay(&filled, adjusted);
            let error = CaseError::new(&shape.place, "");
            if meets_itself::<S>(&shape.place, &what, file, &filling.positions, spacing, lattice.errors) {
                filling = Filling::default();
            }
            report_outside(error, &what, domain, filling.positions.iter(), lattice.errors);
            obstacles.cut(region, spacing, &mut filling, lattice, cuts);
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

/// What stands where fluid may not.
struct Obstacles<'a, S: SceneSpace> {
    solids: Option<Solids<'a, S>>,
    walls: Crowd<'a, S>,
}

/// The bodies of a case as fluid meets them.
struct Solids<'a, S: SceneSpace> {
    shapes: Vec<At<ShapeTable>>,
    particles: Crowd<'a, S>,
}

impl<'a, S: SceneSpace> Solids<'a, S> {
    fn of(solid: &SolidTable, spacing: f64, domain: &'a Domain<S>, positions: &'a [S::Vector]) -> Self {
        Self {
            shapes: solid.bodies.iter().filter_map(|body| body.shape.clone()).collect(),
            particles: Crowd::new(domain, positions, [spacing, solid.particle_spacing_m.value]),
        }
    }

    /// Which of `positions` \[m\] stand in a body.
    fn hold(
        &self,
        positions: &[S::Vector],
        spacing: f64,
        region: &RegionTable,
        errors: &ErrorList,
    ) -> Vec<bool> {
        let mut held = self.particles.touches(positions, &region.name.place, errors);
        // Cells of some spacings, so that a body meets few positions that are not near it.
        let open =
            Domain::<S> { lower: S::Vector::zeros(), upper: S::Vector::zeros(), periodic: S::splat(false) };
        let grid = CellGrid::new(&open, positions, 8.0 * spacing);
        for written in &self.shapes {
            let shape = S::shape(&written.value);
            let (lower, upper) = shape.bounds();
            let within = |x: &S::Vector| (0..S::DIMENSIONS).all(|k| (lower[k]..=upper[k]).contains(&x[k]));
            let mut looked_at = 1.0;
            for cell in cells_between(&grid, &lower, &upper) {
                for &k in &grid.order()[grid.of_cell(cell)] {
                    let (held, x) = (&mut held[k as usize], &positions[k as usize]);
                    looked_at += 1.0;
                    if !*held && within(x) {
                        looked_at += written.value.pieces() as f64;
                        *held = shape.contains(x);
                    }
                }
            }
            if !errors.spend(&region.name.place, looked_at) {
                break;
            }
        }
        held
    }
}

/// Cells of `grid`, which has no periodic direction, that meet a box: along x first, then along the other axes.
fn cells_between<S: Space>(
    grid: &CellGrid<S>,
    lower: &S::Vector,
    upper: &S::Vector,
) -> impl Iterator<Item = usize> {
    let counts = grid.counts();
    let (low, high) = (grid.cell(lower).place(), grid.cell(upper).place());
    let span = |axis: usize| {
        let count = counts[axis];
        let inside = |k: i32| usize::try_from(k).unwrap_or(0).min(count.saturating_sub(1));
        // Positions beyond the last whole cell are binned in it.
        let meets = high[axis] >= 0 && usize::try_from(low[axis]).map_or(true, |low| low <= count);
        if meets { inside(low[axis])..inside(high[axis]) + 1 } else { 0..0 }
    };
    let spans: Vec<_> = (0..S::DIMENSIONS).map(span).collect();
    let number: usize = spans.iter().map(ExactSizeIterator::len).product();
    (0..number).map(move |mut k| {
        let (mut cell, mut stride) = (0, 1);
        for (axis, span) in spans.iter().enumerate() {
            cell += (span.start + k % span.len()) * stride;
            k /= span.len();
            stride *= counts[axis];
        }
        cell
    })
}

impl<S: SceneSpace> Obstacles<'_, S> {
    /// Removes the particles of a region that stand in solids or walls, or reports them.
    fn cut(
        &self,
        region: &RegionTable,
        spacing: f64,
        filling: &mut Filling<S>,
        lattice: &Lattice<'_, S>,
        cuts: &mut Vec<String>,
    ) {
        let before = filling.positions.len();
        if let Some(solids) = self.solids.as_ref().filter(|_| before > 0) {
            let held = solids.hold(&filling.positions, spacing, region, lattice.errors);
            let kept: Vec<bool> = held.into_iter().map(|held| !held).collect();
            let obstacle = Obstacle { name: "solids", key: "cut_by_solids", cuts: region.cut_by_solids };
            obstacle.make_way(region, filling, &kept, lattice, cuts);
        }
        let held = self.walls.touches(&filling.positions, &region.name.place, lattice.errors);
        let kept: Vec<bool> = held.into_iter().map(|held| !held).collect();
        let obstacle = Obstacle { name: "walls", key: "cut_by_walls", cuts: region.cut_by_walls };
        obstacle.make_way(region, filling, &kept, lattice, cuts);
        if filling.positions.is_empty() && before > 0 {
            let error = CaseError::new(&region.name.place, "no particle is left beside solids and walls");
            lattice.errors.add(error.value(&region.name.value).hint("move or enlarge its shape"));
        }
    }
}

/// What fluid can not stand in.
struct Obstacle {
    name: &'static str,
    key: &'static str,
    cuts: bool,
}

impl Obstacle {
    /// Removes the particles that are not `kept` when the obstacle cuts the region; otherwise they are an error.
    fn make_way<S: SceneSpace>(
        &self,
        region: &RegionTable,
        filling: &mut Filling<S>,
        kept: &[bool],
        lattice: &Lattice<'_, S>,
        cuts: &mut Vec<String>,
    ) {
        let Some(first) = kept.iter().position(|kept| !kept) else { return };
        if !self.cuts {
            let problem = format!("overlaps {} at {}", self.name, point_text::<S>(&filling.positions[first]));
            let error = CaseError::new(&region.name.place, problem).value(&region.name.value);
            lattice.errors.add(error.hint(format!("set `{} = true` or change the shape", self.key)));
            return;
        }
        let cut = kept.iter().filter(|kept| !**kept).count();
        retain(&mut filling.positions, kept);
        if let Some(volume) = filling.cells.volume_mut() {
            retain(volume, kept);
        }
        cuts.push(format!("region `{}`: {cut} particles make way for {}", region.name.value, self.name));
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
