//! Particles of the walls.

use std::collections::{HashMap, HashSet};

use sph::shapes::{
    Faces, LayerParticle, OpenSides, Region, Side, layers_along, layers_around, local_thickness, wall_fill,
};
use sph::space::AXIS_NAMES;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

use super::lattice::Lattice;
use super::overlap::{Crowd, MOST_CLASHES, first_clashes};
use super::space::{BoundaryOf, SceneSpace};
use super::{Scene, index, point_text};
use crate::case::errors::CaseError;
use crate::case::file::CaseFile;
use crate::case::file::layout::Layout;
use crate::case::file::run::Side as DomainSide;
use crate::case::file::shape::ShapeTable;
use crate::case::file::wall::{WallKind, WallTable};
use crate::case::reader::At;
use crate::quote::quoted;

sph::constants! {
    /// Half a spacing on two sides of a corner is a slot through which water leaves.
    const COVERED: f64 = 0.25, "scene.wall_covered",
        "depth in a held body from which the centre of a wall particle makes way, in spacings [-]";
}

/// Lays out all walls, cut where held solids enter them.
pub fn lay_out<S: SceneSpace>(
    file: &CaseFile,
    domain: &Domain<S>,
    lattice: &mut Lattice<'_, S>,
    scene: &mut Scene<S>,
) {
    let Some(spacing) = file.wall_spacing() else { return };
    let materials = Material::all(file, domain);
    for (k, wall) in file.walls.iter().enumerate() {
        if wall.intact {
            let others = others(&materials, k, &file.walls);
            let particles = lay_out_wall(file, wall, spacing, domain, &others, lattice, scene);
            scene.walls.wall.extend(std::iter::repeat_n(index(k), particles.len()));
            scene.walls.position.extend(particles.iter().map(|particle| particle.position));
            scene.walls.normal.extend(particles.iter().map(|particle| particle.normal));
        }
    }
    let Some(first) = file.walls.first() else { return };
    let walls = &scene.walls;
    let place = &first.name.place;
    for clash in first_clashes(domain, &walls.position, &walls.wall, spacing, place, lattice.errors) {
        let names = [clash.groups.0, clash.groups.1].map(|wall| &file.walls[wall as usize].name);
        let problem = format!(
            "overlaps the wall `{}` at {}",
            quoted(&names[0].value),
            point_text::<S>(&clash.position)
        );
        let error = CaseError::new(&names[1].place, problem).value(&names[1].value);
        lattice.errors.add(error.hint("make the shapes disjoint, for example with a difference"));
    }
    cut_by_solids(file, spacing, domain, lattice, scene);
}

fn lay_out_wall<S: SceneSpace>(
    file: &CaseFile,
    wall: &WallTable,
    spacing: f64,
    domain: &Domain<S>,
    others: &[&Material<S>],
    lattice: &mut Lattice<'_, S>,
    scene: &mut Scene<S>,
) -> Vec<LayerParticle<S>> {
    let written = written_shape(wall, domain);
    let shape = S::shape(&written.value);
    let layers = wall.layers.map_or(1, |layers| u32::try_from(layers).unwrap_or(u32::MAX));
    let thickness = layers_of(wall) * spacing;
    if !lattice.permits(&written, &shape, spacing, thickness) {
        return Vec::new();
    }
    let origin = wall.lattice_origin_m.as_ref().map_or(lattice.origin, |at| at.value.to::<S>());
    let container = wall.kind.value == WallKind::Container;
    let open = open_sides(wall, shape.bounds(), domain);
    // A face against another wall is none: water never meets it, and it would bend the normals of corners.
    let covered = |point: &S::Vector| {
        let steps: f64 = others.iter().map(|other| other.steps).sum();
        lattice.errors.spend(&written.place, steps) && others.iter().any(|other| other.holds(point))
    };
    let boundary = S::uncovered(shape.boundary(), !container, 0.5 * spacing, covered);
    let on_lattice = match wall.layout.value {
        Layout::Auto => S::is_on_lattice(&shape, &boundary, spacing, origin, open),
        Layout::Fitted => false,
        Layout::Lattice => true,
    };
    if container && on_lattice {
        scene.warnings.extend(off_lattice::<S>(wall, &shape, spacing, origin, open));
    }
    let particles = match (container, on_lattice) {
        (true, true) => layers_around(&shape, &boundary, spacing, layers, origin, open),
        (true, false) => layers_along(&shape, &boundary, spacing, layers, Side::Outside(open)),
        (false, true) => skin::<S>(&shape, &boundary, spacing, origin, thickness),
        (false, false) => layers_along(&shape, &boundary, spacing, layers, Side::Inside),
    };
    if particles.is_empty() {
        let error = CaseError::new(&written.place, "the wall has no particle");
        lattice.errors.add(error.hint("make it larger, or close one of its sides"));
    }
    for choice in &file.domain.periodic {
        let axis = choice.value;
        let beyond = |x: &S::Vector| x[axis] < domain.lower[axis] || x[axis] >= domain.upper[axis];
        if let Some(particle) = particles.iter().find(|particle| beyond(&particle.position)) {
            let problem = format!(
                "wall `{}` reaches across the periodic side along {}, at {}",
                quoted(&wall.name.value),
                choice.word,
                point_text::<S>(&particle.position)
            );
            lattice
                .errors
                .add(CaseError::new(&written.place, problem).hint("end it at the side of the domain"));
        }
    }
    if let Some(needed) = file.fluid_layers() {
        let layers = match container {
            true => thickness / spacing,
            false => layers_across::<S>(&shape, &particles, spacing, needed).min(thickness / spacing),
        };
        scene.warnings.extend(thinner_than_the_kernel(wall, layers.round(), needed));
    }
    if lattice.take(&written, particles.len()) { particles } else { Vec::new() }
}

/// Layers across a solid wall, up to one more than `needed`: median over its particles.
fn layers_across<S: SceneSpace>(
    shape: &S::Shape,
    particles: &[LayerParticle<S>],
    spacing: f64,
    needed: f64,
) -> f64 {
    let positions: Vec<S::Vector> = particles.iter().map(|particle| particle.position).collect();
    let mut thickness = local_thickness(shape, &positions, spacing, (needed + 1.0) * spacing);
    thickness.sort_by(f64::total_cmp);
    thickness.get(thickness.len() / 2).map_or(f64::INFINITY, |median| median / spacing)
}

/// Warns of a wall through which the fluid's kernel reaches.
fn thinner_than_the_kernel(wall: &WallTable, layers: f64, needed: f64) -> Option<String> {
    (layers < needed).then(|| {
        format!(
            "wall `{}` is about {layers} layers thick, and the fluid's kernel reaches through: pressure sums at it lack a \
             part, and the volume correction takes what is missing behind it for missing fluid; make it at least {needed} \
             layers thick",
            wall.name.value
        )
    })
}

/// Where the stuff of a wall is.
pub struct Material<S: SceneSpace> {
    shape: S::Shape,
    boundary: BoundaryOf<S>,
    thickness: f64,
    container: bool,
    open: OpenSides<S>,
    /// A box around it and the points before its faces \[m\].
    lower: S::Vector,
    upper: S::Vector,
    /// Steps of work for a point.
    steps: f64,
}

impl<S: SceneSpace> Material<S> {
    /// Those of all walls of a case.
    pub fn all(file: &CaseFile, domain: &Domain<S>) -> Vec<Self> {
        let spacing = file.wall_spacing().unwrap_or_default();
        file.walls.iter().map(|wall| Self::of(wall, spacing, domain)).collect()
    }

    fn of(wall: &WallTable, spacing: f64, domain: &Domain<S>) -> Self {
        let written = written_shape(wall, domain);
        let shape = S::shape(&written.value);
        let thickness = layers_of(wall) * spacing;
        let (lower, upper) = shape.bounds();
        Self {
            boundary: shape.boundary(),
            shape,
            thickness,
            container: wall.kind.value == WallKind::Container,
            open: open_sides(wall, (lower, upper), domain),
            lower: lower + S::Vector::repeat(-thickness - spacing),
            upper: upper + S::Vector::repeat(thickness + spacing),
            steps: 10.0 * (1 + written.value.pieces()) as f64,
        }
    }

    /// Steps of work of [`Material::holds`].
    pub fn steps(&self) -> f64 {
        self.steps
    }

    /// Whether a cell of the lattice around `point` \[m\] may meet it.
    pub fn is_near(&self, point: &S::Vector) -> bool {
        (0..S::DIMENSIONS).all(|k| (self.lower[k]..=self.upper[k]).contains(&point[k]))
    }

    /// Whether it is at `point` \[m\].
    pub fn holds(&self, point: &S::Vector) -> bool {
        let inside = self.shape.contains(point);
        if !self.container {
            return inside;
        }
        let (lower, upper) = self.shape.bounds();
        let beyond_open_side = (0..S::DIMENSIONS).any(|axis| {
            (self.open.lower[axis] && point[axis] < lower[axis])
                || (self.open.upper[axis] && point[axis] >= upper[axis])
        });
        !inside && !beyond_open_side && self.boundary.surface(point).distance < self.thickness
    }
}

/// The walls that may hold points near the faces of wall `k`.
fn others<'m, S: SceneSpace>(
    materials: &'m [Material<S>],
    k: usize,
    walls: &[WallTable],
) -> Vec<&'m Material<S>> {
    let own = &materials[k];
    let meets = |other: &Material<S>| {
        (0..S::DIMENSIONS)
            .all(|axis| own.lower[axis] <= other.upper[axis] && other.lower[axis] <= own.upper[axis])
    };
    let all = materials.iter().enumerate();
    all.filter(|(j, other)| *j != k && walls[*j].intact && meets(other)).map(|(_, other)| other).collect()
}

/// The shape of a wall; a container without one surrounds the domain.
fn written_shape<S: SceneSpace>(wall: &WallTable, domain: &Domain<S>) -> At<ShapeTable> {
    wall.shape.clone().unwrap_or_else(|| At {
        value: S::box_table(&domain.lower, &domain.upper),
        place: wall.name.place.clone(),
    })
}

/// Layers of a wall; they are filled in before the scene is built.
fn layers_of(wall: &WallTable) -> f64 {
    wall.layers.map_or(1.0, |layers| layers as f64)
}

/// The outer layers of a solid wall: what lies deeper is never met.
fn skin<S: SceneSpace>(
    shape: &S::Shape,
    boundary: &BoundaryOf<S>,
    spacing: f64,
    origin: S::Vector,
    thickness: f64,
) -> Vec<LayerParticle<S>> {
    let mut particles = wall_fill(shape, boundary, spacing, origin);
    particles.retain(|particle| -boundary.surface(&particle.position).distance < thickness);
    particles
}

/// Sides without a wall: those named, and those at which it meets itself across a periodic direction. `bounds` are those of its
/// shape \[m\].
fn open_sides<S: SceneSpace>(
    wall: &WallTable,
    (lower, upper): (S::Vector, S::Vector),
    domain: &Domain<S>,
) -> OpenSides<S> {
    let named = |axis, upper| {
        wall.open_sides.iter().flatten().any(|choice| choice.value == DomainSide { axis, upper })
    };
    // Round-off of a sum of coordinates, far below a spacing.
    let reaches = |axis, beyond: f64| domain.periodic[axis] && beyond > -1e-9 * domain.size()[axis];
    OpenSides {
        lower: S::axes(|axis| reaches(axis, domain.lower[axis] - lower[axis]) || named(axis, false)),
        upper: S::axes(|axis| reaches(axis, upper[axis] - domain.upper[axis]) || named(axis, true)),
    }
}

/// Warns of a box whose closed sides do not lie between two rows of the lattice.
fn off_lattice<S: SceneSpace>(
    wall: &WallTable,
    shape: &S::Shape,
    spacing: f64,
    origin: S::Vector,
    open: OpenSides<S>,
) -> Option<String> {
    let (lower, upper) = S::box_corners(shape)?;
    let offset = |position: f64, axis: usize| {
        let rows = (position - origin[axis]) / spacing;
        rows - rows.round()
    };
    let (axis, rows, position) = [(lower, open.lower), (upper, open.upper)]
        .into_iter()
        .flat_map(|(corner, open)| (0..S::DIMENSIONS).map(move |axis| (axis, corner[axis], open[axis])))
        .filter(|(_, _, is_open)| !is_open)
        .map(|(axis, position, _)| (axis, offset(position, axis), position))
        .find(|(_, rows, _)| rows.abs() > 1e-6)?;
    Some(format!(
        "wall `{}`: its side at {} = {position} m lies {:.2} spacings off the lattice; fluid will not fit against \
         it closely (sizes that are whole multiples of {spacing} m do, and so does `layout = \"fitted\"`)",
        wall.name.value,
        AXIS_NAMES[axis],
        rows.abs()
    ))
}

/// Removes wall particles where held particles of a solid stand; a free one there is an error.
fn cut_by_solids<S: SceneSpace>(
    file: &CaseFile,
    spacing: f64,
    domain: &Domain<S>,
    lattice: &Lattice<'_, S>,
    scene: &mut Scene<S>,
) {
    let Some(solid) = &file.solid else { return };
    let mut reported = HashSet::new();
    let mut kept = Vec::with_capacity(scene.walls.position.len());
    let mut cut = vec![0_usize; file.walls.len()];
    let crowd = Crowd::new(domain, &scene.solid.position, [spacing, solid.particle_spacing_m.value]);
    let mut near = Vec::new();
    let mut bodies = HashMap::new();
    let mut astray = HashSet::new();
    for (x, &wall) in scene.walls.position.iter().zip(&scene.walls.wall) {
        crowd.around(x, &mut near, &solid.particle_spacing_m.place, lattice.errors);
        // A particle less than three quarters inside the body stays: water would enter the slot that it left.
        let is_cut = near.iter().any(|&s| {
            let body = scene.solid.body[s];
            let boundary = bodies.entry(body).or_insert_with(|| {
                solid.bodies[body as usize].shape.as_ref().map(|shape| S::shape(&shape.value).boundary())
            });
            // The image beside the body, whose shape may reach over a periodic side.
            let beside = &scene.solid.position[s];
            let image = *beside + domain.separation(x, beside);
            boundary.as_ref().is_none_or(|face| face.surface(&image).distance < -COVERED * spacing)
        });
        kept.push(!is_cut);
        cut[wall as usize] += usize::from(is_cut);
        for &s in near.iter().filter(|_| is_cut) {
            let Some(slot) = scene.solid.support[s].checked_sub(1) else { continue };
            let (number, wall) = (scene.solid.body[s], &file.walls[wall as usize]);
            let body = &solid.bodies[number as usize];
            let support = &body.supports[slot as usize];
            if support.motion.is_some() != wall.motion.is_some() && astray.insert((number, slot)) {
                let does = |moves: bool| if moves { "moves" } else { "is at rest" };
                scene.warnings.push(format!(
                    "support `{}` of body `{}` {}, and wall `{}`, in which it stands, {}: the body will part from the wall; \
                     give both the same `motion`",
                    support.name.value,
                    body.name.value,
                    does(support.motion.is_some()),
                    wall.name.value,
                    does(wall.motion.is_some())
                ));
            }
        }
        let held = |s: &usize| scene.solid.support[*s] > 0;
        let Some(&free) = near.iter().find(|s| !held(s)) else { continue };
        let clash = (scene.solid.body[free], wall);
        // Next to a held particle a free one may stand slightly inside the wall: the support's edge lies there.
        if near.iter().any(held) || scene.unsupported.contains(&clash.0) || reported.len() >= MOST_CLASHES {
            continue;
        }
        if reported.insert(clash) {
            let (body, wall) = (&solid.bodies[clash.0 as usize].name, &file.walls[wall as usize].name);
            let problem = format!("overlaps the wall `{}` at {}", quoted(&wall.value), point_text::<S>(x));
            let error = CaseError::new(&body.place, problem).value(&body.value);
            let hint = "move it out of the wall, or hold the part inside with a support";
            lattice.errors.add(error.hint(hint));
        }
    }
    for (wall, cut) in file.walls.iter().zip(cut).filter(|(_, cut)| *cut > 0) {
        scene.cuts.push(format!("wall `{}`: {cut} particles make way for held solids", wall.name.value));
    }
    let walls = &mut scene.walls;
    retain(&mut walls.wall, &kept);
    retain(&mut walls.position, &kept);
    retain(&mut walls.normal, &kept);
}

/// Keeps the entries of `list` for which `kept` says so.
pub fn retain<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    list.retain(|_| kept.next().copied().unwrap_or(true));
}
