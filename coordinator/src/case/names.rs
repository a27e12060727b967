//! Names of regions, bodies, supports, walls and probes: each once, and every reference to one that exists.

use sph::setup::{FluidProbe, FluidProbeKind, SolidProbe, SolidProbeKind};
use sph::space::Vector;

use super::errors::{CaseError, ErrorList, Place, suggest};
use super::file::CaseFile;
use super::file::body::BodyTable;
use super::file::probe::{ProbeKind, ProbeTable};
use super::file::solid::SolidTable;
use super::reader::At;
use super::scene::Scene;
use crate::quote::quoted;

/// Probes of both solvers.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    /// For the fluid solver.
    pub fluid: Vec<FluidProbe>,
    /// For the solid solver.
    pub solid: Vec<SolidProbe>,
}

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
pub fn probes(file: &CaseFile, scene: &Scene, errors: &ErrorList) -> Probes {
    let mut probes = Probes::default();
    for table in file.probes.iter().filter(|probe| probe.intact) {
        let name = table.name.value.clone();
        let resolver = Resolver { file, scene, errors, table };
        if table.kind.value.of_fluid() {
            if let Some(kind) = resolver.fluid() {
                probes.fluid.push(FluidProbe { name, kind });
            }
        } else if let Some(kind) = resolver.solid() {
            probes.solid.push(SolidProbe { name, kind });
        }
    }
    probes
}

struct Resolver<'a> {
    file: &'a CaseFile,
    scene: &'a Scene,
    errors: &'a ErrorList,
    table: &'a ProbeTable,
}

impl Resolver<'_> {
    fn fluid(&self) -> Option<FluidProbeKind> {
        let Some(fluid) = &self.file.fluid else {
            self.without("fluid");
            return None;
        };
        match self.table.kind.value {
            ProbeKind::FluidPoint => {
                let point = self.table.at_m.as_ref()?;
                self.inside_domain(point.value, &point.place).then_some(FluidProbeKind::Point(point.value))
            }
            ProbeKind::WaterLevel => {
                let x = self.table.x_m.as_ref()?;
                let height = 0.5 * (self.file.domain.lower_m.value.y + self.file.domain.upper_m.value.y);
                self.inside_domain(Vector::new(x.value, height), &x.place)
                    .then_some(FluidProbeKind::WaterLevel(x.value))
            }
            ProbeKind::Front => Some(FluidProbeKind::Front),
            ProbeKind::Immersed if self.file.solid.is_none() => {
                self.without("solid");
                None
            }
            ProbeKind::Immersed => Some(FluidProbeKind::Immersed),
            ProbeKind::FluidSums => match &self.table.region {
                None => Some(FluidProbeKind::Region(None)),
                Some(region) => {
                    let names = fluid.regions.iter().map(|region| &region.name);
                    Some(FluidProbeKind::Region(Some(self.find("region", region, names)?)))
                }
            },
            ProbeKind::WallForce => {
                let names = self.file.walls.iter().map(|wall| &wall.name);
                Some(FluidProbeKind::WallForce(self.find("wall", self.table.wall.as_ref()?, names)?))
            }
            _ => None,
        }
    }

    fn solid(&self) -> Option<SolidProbeKind> {
        let Some(solid) = &self.file.solid else {
            self.without("solid");
            return None;
        };
        let body = match &self.table.body {
            Some(body) => Some(self.find("body", body, solid.bodies.iter().map(|body| &body.name))?),
            None => None,
        };
        match self.table.kind.value {
            ProbeKind::MaterialPoint => {
                let (body, at) = (body?, self.table.at_m.as_ref()?);
                self.inside_body(solid, body, at)
                    .then_some(SolidProbeKind::MaterialPoint { body, reference_position: at.value })
            }
            ProbeKind::BodyMotion => Some(SolidProbeKind::Motion(body?)),
            ProbeKind::BodyForce => Some(SolidProbeKind::BodyForce(body?)),
            ProbeKind::SupportReaction => {
                let body = body?;
                let BodyTable { supports, .. } = &solid.bodies[body as usize];
                let names = supports.iter().map(|support| &support.name);
                let support = self.find("support", self.table.support.as_ref()?, names)?;
                Some(SolidProbeKind::Reaction { body, support })
            }
            ProbeKind::BodySums => Some(SolidProbeKind::Sums(body)),
            ProbeKind::Gap => Some(SolidProbeKind::Gap(body)),
            ProbeKind::Contact => Some(SolidProbeKind::Contact(body)),
            _ => None,
        }
    }

    fn without(&self, owner: &str) {
        let error = CaseError::new(&self.table.kind.place, format!("the case has no `{owner}`"));
        self.errors.add(error.value(self.table.kind.word).hint("leave the probe out"));
    }

    fn find<'n>(
        &self,
        what: &str,
        wanted: &At<String>,
        names: impl Iterator<Item = &'n At<String>>,
    ) -> Option<u32> {
        let names: Vec<&str> = names.map(|name| name.value.as_str()).collect();
        let found = names.iter().position(|name| *name == wanted.value).and_then(|k| u32::try_from(k).ok());
        if found.is_none() {
            let error =
                CaseError::new(&wanted.place, format!("no {what} has this name")).value(&wanted.value);
            // Comparing with all names takes time.
            let hint = if self.errors.is_full() { String::new() } else { suggest(&wanted.value, &names) };
            self.errors.add(error.hint(hint));
        }
        found
    }

    fn inside_domain(&self, point: Vector, place: &Place) -> bool {
        let domain = self.file.domain.domain();
        let inside = !self.file.domain.intact || domain.contains(&point);
        if !inside {
            let allowed = format!(
                "x from {} to {}, y from {} to {}",
                domain.lower.x, domain.upper.x, domain.lower.y, domain.upper.y
            );
            self.errors.add(CaseError::new(place, "lies outside the domain").allowed(allowed));
        }
        inside
    }

    fn inside_body(&self, solid: &SolidTable, body: u32, at: &At<Vector>) -> bool {
        let own = &self.scene.solid.reference_position[self.scene.body_range(body)];
        if !self.errors.spend(&at.place, 3.0 * own.len() as f64) {
            return true;
        }
        let nearest = own.iter().map(|x| (x - at.value).norm()).min_by(f64::total_cmp);
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
