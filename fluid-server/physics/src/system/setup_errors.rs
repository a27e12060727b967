//! Errors of a set-up.

use sph::setup::{
    Contradiction, FluidParticles, FluidProbe, FluidProbeKind, FluidSetup, ParameterSet, ProbeKind,
    WallParticles,
};
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;
use sph::space::{AXIS_NAMES, Space};

use super::list_limits::skins;

/// Squares of sines, or lengths \[m\], up to which points count as one.
const LEAST_EXTENT: f64 = 1e-12;

/// Everything that would make the solver read outside its arrays or divide by zero.
pub fn setup_errors<S: Space>(setup: &FluidSetup<S>) -> Vec<String> {
    let mut errors = Vec::new();
    constants_errors(setup, &mut errors);
    particle_errors(&setup.particles, setup.regions.len(), &mut errors);
    wall_errors(&setup.wall_particles, setup.walls.len(), &mut errors);
    for probe in &setup.probes {
        probe_geometry_errors(probe, &mut errors);
        let (index, count, what) = match probe.kind {
            FluidProbeKind::Gauge(_, axis) => (axis, S::DIMENSIONS, "axis"),
            FluidProbeKind::Region(Some(region)) => (region, setup.regions.len(), "region"),
            FluidProbeKind::WallForce(wall) => (wall, setup.walls.len(), "wall"),
            _ => continue,
        };
        if index as usize >= count {
            errors.push(format!("probe `{}` names {what} {index}, but there are {count}", probe.name));
        }
    }
    errors
}

/// Probes of the other space, and those through nothing.
fn probe_geometry_errors<S: Space>(probe: &FluidProbe<S>, errors: &mut Vec<String>) {
    let (wanted, extent) = match probe.kind {
        FluidProbeKind::WaterLevel(_) => (2, 1.0),
        FluidProbeKind::FlowRate(from, to) => (2, (to - from).norm()),
        FluidProbeKind::SurfaceFlux(corner, first, second) => {
            let (a, b) = (first - corner, second - corner);
            // The square of the sine of the angle between the edges.
            (3, 1.0 - a.dot(&b).powi(2) / (a.norm_squared() * b.norm_squared()))
        }
        _ => return,
    };
    let (name, word) = (&probe.name, probe.kind.word());
    if wanted != S::DIMENSIONS {
        errors
            .push(format!("probe `{name}`: `{word}` needs {wanted} dimensions, there are {}", S::DIMENSIONS));
    } else if extent.is_nan() || extent <= LEAST_EXTENT {
        errors.push(format!("probe `{name}`: `{word}` has its points on one line or in one place"));
    }
}

/// Whether all components are finite.
fn is_finite<S: Space>(v: &S::Vector) -> bool {
    v.row().as_ref().iter().all(|c| c.is_finite())
}

fn constants_errors<S: Space>(setup: &FluidSetup<S>, errors: &mut Vec<String>) {
    let parameters = &setup.parameters;
    errors.extend(parameters.errors().iter().map(ToString::to_string));
    if let Some(Contradiction { key, problem, hint }) = parameters.contradiction() {
        errors.push(format!("`{key}`: {problem}; {hint}"));
    }
    let (domain, smallest) = (
        &setup.run.domain,
        4.0 * parameters.smoothing_length() + 2.0 * skins::<S>(parameters.particle_spacing).thickest,
    );
    for (axis, name) in AXIS_NAMES.into_iter().take(S::DIMENSIONS).enumerate() {
        let size = domain.size()[axis];
        if domain.periodic[axis] && size < smallest {
            errors.push(format!(
                "period along {name} = {size} m: must be at least {smallest} m (two support radii with skin), \
                 so that a pair meets through one image only"
            ));
        }
    }
}

fn particle_errors<S: Space>(p: &FluidParticles<S>, regions: usize, errors: &mut Vec<String>) {
    let n = p.id.len();
    let lengths = [p.region.len(), p.mass.len(), p.position.len(), p.velocity.len(), p.density.len()];
    if lengths.iter().any(|length| *length != n) {
        errors.push(format!("fluid arrays differ in length: {n} ids, others {lengths:?}"));
        return;
    }
    if !p.id.is_sorted_by(|a, b| a < b) {
        errors.push("fluid ids must be strictly ascending".into());
    }
    for i in 0..n {
        let id = p.id[i];
        if p.region[i] as usize >= regions {
            errors.push(format!("fluid particle {id} names region {}, but there are {regions}", p.region[i]));
        }
        let finite = |v: &S::Vector| is_finite::<S>(v);
        let positive = |v: f64| v > 0.0 && v.is_finite();
        if !(positive(p.mass[i])
            && positive(p.density[i])
            && finite(&p.position[i])
            && finite(&p.velocity[i]))
        {
            errors.push(format!(
                "fluid particle {id}: mass {} kg/m and density {} kg/m³ must be positive, position and velocity finite",
                p.mass[i], p.density[i]
            ));
        }
        if errors.len() > 10 {
            errors.push("more of the same is not listed".into());
            return;
        }
    }
}

fn wall_errors<S: Space>(p: &WallParticles<S>, walls: usize, errors: &mut Vec<String>) {
    let n = p.wall.len();
    if p.position.len() != n || p.normal.len() != n {
        let (positions, normals) = (p.position.len(), p.normal.len());
        errors.push(format!(
            "wall arrays differ in length: {n} walls, {positions} positions, {normals} normals"
        ));
        return;
    }
    if let Some(wall) = p.wall.iter().find(|wall| **wall as usize >= walls) {
        errors.push(format!("a wall particle names wall {wall}, but there are {walls}"));
    }
    if p.position.iter().chain(&p.normal).any(|v| !is_finite::<S>(v)) {
        errors.push("positions and normals of wall particles must be finite".into());
    }
}
