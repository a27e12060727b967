//! What stands where water may not: which particles of a region make way, and the mass that stays.

use std::cell::OnceCell;

use sph::neighbours::CellGrid;
use sph::shapes::Region;
use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use super::filling::Filling;
use super::lattice::Lattice;
use super::overlap::Crowd;
use super::point_text;
use super::space::SceneSpace;
use super::wall::{Material, retain};
use crate::case::errors::{CaseError, ErrorList};
use crate::case::file::CaseFile;
use crate::case::file::fluid::RegionTable;
use crate::case::file::shape::ShapeTable;
use crate::case::file::solid::SolidTable;
use crate::case::reader::At;

sph::constants! {
    /// Beyond it the particles would be at odds with the room that they have.
    const LARGEST_SCALING: f64 = 0.1, "scene.largest_scaling",
        "largest relative change of the masses of a region that solids and walls cut [-]";
}

/// Points of a cell at which it is judged whether something covers it: a prime number.
const SAMPLES: usize = 101;
/// A generator of the rule that places them; its square is that of the third axis.
const GENERATOR: usize = 40;

/// Relative change of masses that is no more than round-off.
const EXACT: f64 = 1e-9;

/// What stands where fluid may not.
pub struct Obstacles<'a, S: SceneSpace> {
    domain: &'a Domain<S>,
    spacing: f64,
    solids: Option<Solids<'a, S>>,
    walls: Crowd<'a, S>,
    /// Particles of walls and solids, seen from twice as far.
    all: [Crowd<'a, S>; 2],
    /// Made when they are asked for: a wall may be a large surface.
    materials: OnceCell<Vec<Material<S>>>,
    file: &'a CaseFile,
}

/// The bodies of a case as fluid meets them.
struct Solids<'a, S: SceneSpace> {
    shapes: Vec<At<ShapeTable>>,
    particles: Crowd<'a, S>,
}

/// The shape of a body.
struct Body<S: SceneSpace> {
    shape: S::Shape,
    /// A box around it \[m\].
    lower: S::Vector,
    upper: S::Vector,
    /// Steps of work for a point.
    steps: f64,
}

impl<S: SceneSpace> Body<S> {
    /// Whether a cell of `side` \[m\] around `point` \[m\] may meet it.
    fn is_near(&self, point: &S::Vector, side: f64) -> bool {
        (0..S::DIMENSIONS).all(|k| (self.lower[k] - side..=self.upper[k] + side).contains(&point[k]))
    }
}

impl<'a, S: SceneSpace> Solids<'a, S> {
    fn of(solid: &SolidTable, spacing: f64, domain: &'a Domain<S>, positions: &'a [S::Vector]) -> Self {
        Self {
            shapes: solid.bodies.iter().filter_map(|body| body.shape.clone()).collect(),
            particles: Crowd::new(domain, positions, [spacing, solid.particle_spacing_m.value]),
        }
    }

    fn bodies(&self) -> impl Iterator<Item = Body<S>> {
        self.shapes.iter().map(|written| {
            let shape = S::shape(&written.value);
            let (lower, upper) = shape.bounds();
            Body { shape, lower, upper, steps: 1.0 + written.value.pieces() as f64 }
        })
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

impl<'a, S: SceneSpace> Obstacles<'a, S> {
    /// Solids and walls of the case, whose particles are at `solids` and `walls` \[m\].
    pub fn of(
        file: &'a CaseFile,
        spacing: f64,
        domain: &'a Domain<S>,
        solids: &'a [S::Vector],
        walls: &'a [S::Vector],
    ) -> Self {
        let table = file.solid.as_ref().filter(|solid| solid.intact);
        let of_solids = table.map_or(spacing, |table| table.particle_spacing_m.value);
        Self {
            domain,
            spacing,
            solids: table.map(|table| Solids::of(table, spacing, domain, solids)),
            walls: Crowd::new(domain, walls, [spacing; 2]),
            all: [(walls, spacing), (solids, of_solids)]
                .map(|(positions, own)| Crowd::new(domain, positions, [2.0 * spacing, 2.0 * own])),
            materials: OnceCell::new(),
            file,
        }
    }

    /// Whether particles of a region stand in walls.
    pub fn walls_hold_any(&self, region: &RegionTable, filling: &Filling<S>, errors: &ErrorList) -> bool {
        self.walls.touches(&filling.positions, &region.name.place, errors).contains(&true)
    }

    /// Removes the particles of a region of `shape` that stand in solids or walls, or reports them. The mass that stays is
    /// that of what they do not cover.
    pub fn cut(
        &self,
        region: &RegionTable,
        shape: &At<ShapeTable>,
        filling: &mut Filling<S>,
        lattice: &Lattice<'_, S>,
        (cuts, warnings): (&mut Vec<String>, &mut Vec<String>),
    ) {
        let count = filling.positions.len();
        if count == 0 {
            return;
        }
        let (place, errors) = (&region.name.place, lattice.errors);
        let in_solids = match &self.solids {
            Some(solids) => solids.hold(&filling.positions, self.spacing, region, errors),
            None => vec![false; count],
        };
        let mut held = self.walls.touches(&filling.positions, place, errors);
        // Each particle makes way once.
        held.iter_mut().zip(&in_solids).for_each(|(held, in_solids)| *held &= !in_solids);
        let obstacles = [
            ("solids", "cut_by_solids", region.cut_by_solids, &in_solids),
            ("walls", "cut_by_walls", region.cut_by_walls, &held),
        ];
        let mut made_way: Vec<String> = Vec::new();
        for (name, key, cuts, held) in obstacles {
            let Some(first) = held.iter().position(|held| *held) else { continue };
            if !cuts {
                let problem = format!("overlaps {name} at {}", point_text::<S>(&filling.positions[first]));
                let error = CaseError::new(place, problem).value(&region.name.value);
                errors.add(error.hint(format!("set `{key} = true` or change the shape")));
                return;
            }
            let cut = held.iter().filter(|held| **held).count();
            made_way.push(format!("{cut} particles make way for {name}"));
        }
        if made_way.is_empty() {
            return;
        }
        let kept: Vec<bool> = held.iter().zip(&in_solids).map(|(a, b)| !(a | b)).collect();
        let left = self.uncovered(region, shape, filling, &kept, errors);
        retain(&mut filling.positions, &kept);
        if let Some(volume) = filling.cells.volume_mut() {
            retain(volume, &kept);
        }
        if filling.positions.is_empty() {
            let error = CaseError::new(place, "no particle is left beside solids and walls");
            errors.add(error.value(&region.name.value).hint("move or enlarge its shape"));
            return;
        }
        let name = &region.name.value;
        let volume = filling.volume(self.spacing);
        let change = left / volume - 1.0;
        let mut line = format!("region `{name}`: {}", made_way.join(", "));
        if change.abs() > LARGEST_SCALING {
            warnings.push(format!(
                "region `{name}` keeps {} of {count} particles beside solids and walls, with {:+.1} % of the mass that has room \
                 there: its faces lie between rows of particles; move them, or make the particles smaller",
                filling.positions.len(),
                100.0 * (volume / left - 1.0),
            ));
        } else if change.abs() > EXACT {
            filling.scale(1.0 + change, self.spacing);
            line +=
                &format!("; masses scaled by {:+.3} %, to that of the water which has room", 100.0 * change);
        }
        cuts.push(line);
    }

    /// Volume (area in the plane) of a region's cells \[m³\] that nothing covers.
    fn uncovered(
        &self,
        region: &RegionTable,
        written: &At<ShapeTable>,
        filling: &Filling<S>,
        kept: &[bool],
        errors: &ErrorList,
    ) -> f64 {
        let (place, positions) = (&region.name.place, &filling.positions);
        let near = self.all.each_ref().map(|crowd| crowd.touches(positions, place, errors));
        let shape = S::shape(&written.value);
        let materials = self.materials.get_or_init(|| Material::all(self.file, self.domain));
        let bodies: Vec<Body<S>> = self.solids.iter().flat_map(Solids::bodies).collect();
        let (samples, corners) = (samples::<S>(), corners::<S>());
        let mut covered = 0.0;
        for (k, x) in positions.iter().enumerate() {
            if kept[k] && !near[0][k] && !near[1][k] {
                continue;
            }
            let volume = filling.volume_of(k, self.spacing);
            let side = volume.powf(1.0 / S::DIMENSIONS as f64);
            let at = self.domain.wrapped(x);
            let bodies: Vec<&Body<S>> = bodies.iter().filter(|body| body.is_near(&at, side)).collect();
            let materials: Vec<&Material<S>> = materials.iter().filter(|wall| wall.is_near(&at)).collect();
            let is_covered = |sample: &&S::Vector| {
                let point = *x + **sample * side;
                let at = self.domain.wrapped(&point);
                shape.contains(&point)
                    && (bodies.iter().any(|body| body.shape.contains(&at))
                        || materials.iter().any(|material| material.holds(&at)))
            };
            let steps = 1.0
                + written.value.pieces() as f64
                + bodies.iter().map(|body| body.steps).sum::<f64>()
                + materials.iter().map(|material| material.steps()).sum::<f64>();
            if !errors.spend(place, corners.len() as f64 * steps) {
                break;
            }
            // Most cells lie wholly inside or wholly outside what is near.
            covered += volume
                * match corners.iter().filter(is_covered).count() {
                    0 if kept[k] => 0.0,
                    all if all == corners.len() => 1.0,
                    _ if !errors.spend(place, SAMPLES as f64 * steps) => 0.0,
                    _ => samples.iter().filter(is_covered).count() as f64 / SAMPLES as f64,
                };
        }
        (0..positions.len()).map(|k| filling.volume_of(k, self.spacing)).sum::<f64>() - covered
    }
}

/// Points of a cell of side 1 about its middle: a lattice rule, even along each axis and with none on a face.
fn samples<S: Space>() -> Vec<S::Vector> {
    let factors = [1, GENERATOR, GENERATOR * GENERATOR];
    let place = |k: usize| {
        let mut x = S::Vector::zeros();
        for (axis, factor) in factors.iter().enumerate().take(S::DIMENSIONS) {
            x[axis] = ((k * factor % SAMPLES) as f64 + 0.5) / SAMPLES as f64 - 0.5;
        }
        x
    };
    (0..SAMPLES).map(place).collect()
}

/// Corners of the box around [`samples`].
fn corners<S: Space>() -> Vec<S::Vector> {
    let end = 0.5 - 0.5 / SAMPLES as f64;
    let place = |k: usize| {
        let mut x = S::Vector::zeros();
        (0..S::DIMENSIONS).for_each(|axis| x[axis] = if k >> axis & 1 == 0 { -end } else { end });
        x
    };
    (0..1 << S::DIMENSIONS).map(place).collect()
}
