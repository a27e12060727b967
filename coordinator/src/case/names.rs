//! Names of regions, bodies, supports, walls and probes: each once, and every reference to one that exists.

use sph::coupling::solver::Role;
use sph::setup::{Argument, FluidProbe, FluidProbeKind, ProbeKind, SolidProbe};
use sph::space::AXIS_NAMES;
use sph::space::tensors::SpaceVector;

use super::errors::{CaseError, ErrorList, Place, suggest};
use super::file::CaseFile;
use super::file::probe::{ProbeTable, WrittenArgument};
use super::reader::{At, Coordinates};
use super::scene::{Probes, Scene, SceneSpace};
use crate::quote::quoted;

/// Reports names that are given twice.
pub fn check_unique(file: &CaseFile, errors: &ErrorList) {
    let fluid = file.fluid.iter().flat_map(|fluid| &fluid.regions).map(|region| &region.name);
    unique("region", fluid, errors);
    let bodies = || file.solid.iter().flat_map(|solid| &solid.bodies);
    unique("body", bodies().map(|body| &body.name), errors);
    for body in bodies() {
        unique("support", body.supports.iter().map(|support| &support.name), errors);
        unique("load", body.loads.iter().map(|load| &load.name), errors);
    }
    unique("wall", file.walls.iter().map(|wall| &wall.name), errors);
    unique("probe", file.probes.iter().map(|probe| &probe.name), errors);
}

fn unique<'a>(what: &str, names: impl Iterator<Item = &'a At<String>>, errors: &ErrorList) {
    let mut seen = std::collections::BTreeSet::new();
    for name in names {
        // A name that is missing has been reported as such.
        if !name.value.is_empty() && !seen.insert(&name.value) {
            let error =
                CaseError::new(&name.place, format!("another {what} has this name")).value(&name.value);
            errors.add(error.hint("give each its own name"));
        }
    }
}

/// Resolves the names in all probes and checks that points lie where they can be measured.
pub fn probes<S: SceneSpace>(file: &CaseFile, scene: &Scene<S>, errors: &ErrorList) -> Probes<S> {
    let mut probes = Probes::default();
    for table in file.probes.iter().filter(|probe| probe.intact) {
        let other = OF_ONE_SPACE
            .iter()
            .find(|(dimensions, word, _)| *dimensions != S::DIMENSIONS && *word == table.kind.word);
        if let Some((dimensions, word, instead)) = other {
            let problem = format!("is a probe of {dimensions} dimensions, in a case of {}", S::DIMENSIONS);
            let error = CaseError::new(&table.kind.place, problem).value(word);
            errors.add(error.hint(format!("use `{instead}`")));
            continue;
        }
        let name = table.name.value.clone();
        let resolver = Resolver { file, scene, errors, table };
        match table.kind.value.0 {
            Role::Fluid => {
                let kind = resolver.kind(file.fluid.is_some(), "fluid");
                let partner = file.solid.is_some() || kind != Some(FluidProbeKind::Immersed);
                if !partner {
                    resolver.without("solid");
                }
                probes.fluid.extend(kind.filter(|_| partner).map(|kind| FluidProbe { name, kind }));
            }
            Role::Solid => {
                let kind = resolver.kind(file.solid.is_some(), "solid");
                probes.solid.extend(kind.map(|kind| SolidProbe { name, kind }));
            }
        }
    }
    probes
}

/// Probes of one space alone: its dimensions, the probe, and what serves in the other. In space a level has no single place,
/// and nothing flows through a segment.
const OF_ONE_SPACE: [(usize, &str, &str); 3] =
    [(2, "water-level", "gauge"), (2, "flow-rate", "surface-flux"), (3, "surface-flux", "flow-rate")];

struct Resolver<'a, S: SceneSpace> {
    file: &'a CaseFile,
    scene: &'a Scene<S>,
    errors: &'a ErrorList,
    table: &'a ProbeTable,
}

impl<S: SceneSpace> Resolver<'_, S> {
    /// The kind with its arguments; `owner` is who reports it, if the case has one.
    fn kind<K: ProbeKind<In = S>>(&self, has_owner: bool, owner: &str) -> Option<K> {
        if !has_owner {
            self.without(owner);
            return None;
        }
        let (mut found, mut body) = (Vec::new(), None);
        // A support is looked up in its body, and a point in its body.
        for argument in self.table.kind.value.1.arguments {
            let Some(written) = self.table.arguments.get(argument.name) else { continue };
            let value = match written {
                WrittenArgument::Name(name) => {
                    let index = self.find(argument.name, name, &self.names(argument.name, body))?;
                    if argument.name == "body" {
                        body = Some(index);
                    }
                    Argument::Index(index)
                }
                WrittenArgument::Point(at) => {
                    let inside = match body {
                        Some(body) => self.inside_body(body, at),
                        None => self.inside_domain(at.value.to::<S>(), &at.place),
                    };
                    inside.then_some(Argument::Point(at.value.to::<S>()))?
                }
                WrittenArgument::Number(x) => {
                    let domain = self.file.domain.domain::<S>();
                    let mut point = (domain.lower + domain.upper) * 0.5;
                    point[0] = x.value;
                    let inside = self.inside_domain(point, &x.place);
                    inside.then_some(Argument::Number(x.value))?
                }
            };
            found.push((argument.name, value));
        }
        let argument = |wanted: &str| found.iter().find(|(name, _)| *name == wanted).map(|(_, value)| *value);
        K::build(self.table.kind.word, argument).ok()
    }

    /// Names that the argument `what` may have.
    fn names(&self, what: &str, body: Option<u32>) -> Vec<&str> {
        let bodies = self.file.solid.as_ref().map_or(&[][..], |solid| &solid.bodies);
        if what == "axis" {
            return AXIS_NAMES[..S::DIMENSIONS].to_vec();
        }
        let names: Vec<&At<String>> = match (what, body) {
            ("region", _) => {
                self.file.fluid.iter().flat_map(|fluid| &fluid.regions).map(|region| &region.name).collect()
            }
            ("wall", _) => self.file.walls.iter().map(|wall| &wall.name).collect(),
            ("support", Some(body)) => {
                bodies[body as usize].supports.iter().map(|support| &support.name).collect()
            }
            _ => bodies.iter().map(|body| &body.name).collect(),
        };
        names.into_iter().map(|name| name.value.as_str()).collect()
    }

    fn without(&self, owner: &str) {
        let error = CaseError::new(&self.table.kind.place, format!("the case has no `{owner}`"));
        self.errors.add(error.value(self.table.kind.word).hint("leave the probe out"));
    }

    fn find(&self, what: &str, wanted: &At<String>, names: &[&str]) -> Option<u32> {
        let found = names.iter().position(|name| *name == wanted.value).and_then(|k| u32::try_from(k).ok());
        if found.is_none() {
            let error =
                CaseError::new(&wanted.place, format!("no {what} has this name")).value(&wanted.value);
            // Comparing with all names takes time.
            let hint = if self.errors.is_full() { String::new() } else { suggest(&wanted.value, names) };
            self.errors.add(error.hint(hint));
        }
        found
    }

    fn inside_domain(&self, point: S::Vector, place: &Place) -> bool {
        let domain = self.file.domain.domain::<S>();
        let inside = !self.file.domain.intact || domain.contains(&point);
        if !inside {
            let allowed = self.file.domain.extent_text();
            self.errors.add(CaseError::new(place, "lies outside the domain").allowed(allowed));
        }
        inside
    }

    fn inside_body(&self, body: u32, at: &At<Coordinates>) -> bool {
        let Some(solid) = &self.file.solid else { return false };
        let own = &self.scene.solid.reference_position[self.scene.body_range(body)];
        if !self.errors.spend(&at.place, 3.0 * own.len() as f64) {
            return true;
        }
        let point = at.value.to::<S>();
        let nearest = own.iter().map(|x| (*x - point).norm()).min_by(f64::total_cmp);
        // A body that could not be laid out has been reported.
        let Some(nearest) = nearest else { return true };
        let inside = nearest <= solid.particle_spacing_m.value;
        if !inside {
            let name = quoted(&solid.bodies[body as usize].name.value);
            let problem =
                format!("lies outside the body `{name}`: its nearest particle is {nearest:.3e} m away");
            let allowed = format!("within one particle spacing, {} m", solid.particle_spacing_m.value);
            self.errors.add(CaseError::new(&at.place, problem).allowed(allowed));
        }
        inside
    }
}
