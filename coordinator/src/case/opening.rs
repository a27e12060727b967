//! What the solvers find at the start of a run: expressions without a value, states beyond their limits and laws that do
//! not go together are errors of the case, each at its key.

use solid::limits::LARGEST_SPEED;
use sph::expression::Expression;
use sph::laws::equation_of_state::LARGEST_COMPRESSION;
use sph::setup::{InterfaceLaw, PlaneState};
use sph::space::Space;
use sph::space::components::Components;
use sph::space::tensors::SpaceVector;

use super::errors::{CaseError, ErrorList, Place};
use super::file::body::BodyTable;
use super::file::material::FormulationTable;
use super::file::run::MotionTable;
use super::file::solid::{ContactTable, SubstepsKey, SubstepsWord};
use super::reader::{At, Written, is_bounded};
use super::scene::{Scene, expression_steps, point_text};
use super::spec::Variables;
use super::{Case, Server};
use crate::quote::quoted;

/// What expressions must give.
const BOUNDED: &str = "finite values at the start, of a magnitude of at most 1e30";

impl Case {
    /// Reports what the solvers would refuse; for a case without other errors.
    pub(super) fn check_opening(&self, errors: &ErrorList) {
        sph::in_space!(&self.scene, scene => {
            self.check_forces(scene, errors);
            self.check_fluid_state(scene, errors);
            self.check_solid_speeds(scene, errors);
        });
        self.check_motions(errors);
        self.check_planes(errors);
        self.check_pivots(errors);
        // Another solid solver may know more.
        if self.servers.solid == Server::BuiltIn {
            self.check_laws(errors);
        }
    }

    /// Evaluates body forces, accelerations of bodies and loads where they act.
    fn check_forces<S: Space>(&self, scene: &Scene<S>, errors: &ErrorList) {
        let (file, time) = (&self.file, self.file.time.start_time_s);
        for written in file.body_force.acceleration_m_s2.iter().flatten() {
            // The fluid's walls feel it as the fluid before them does.
            let walls = if file.fluid.is_some() { &scene.walls.position[..] } else { &[] };
            let all = [&scene.fluid.position[..], &scene.solid.position, walls];
            all.iter().all(|positions| has_values::<S>(written, positions, time, errors));
        }
        let bodies = file.solid.as_ref().map_or(&[][..], |solid| &solid.bodies);
        for (k, body) in (0u32..).zip(bodies) {
            let positions = &scene.solid.position[scene.body_range(k)];
            for written in body.acceleration_m_s2.iter().flatten() {
                has_values::<S>(written, positions, time, errors);
            }
            let loads = scene.loads.get(k as usize).map_or(&[][..], |loads| &loads[..]);
            // Each written load has its faces, in the same order.
            for (load, faces) in body.loads.iter().zip(loads) {
                let loaded: Vec<S::Vector> =
                    faces.particles.iter().filter_map(|i| positions.get(*i as usize)).copied().collect();
                for written in load.pressure_pa.iter().chain(load.traction_pa.iter().flatten()) {
                    has_values::<S>(written, &loaded, time, errors);
                }
            }
        }
    }

    /// Evaluates the motions of walls and supports with their first two derivatives.
    fn check_motions(&self, errors: &ErrorList) {
        let time = self.file.time.start_time_s;
        let bodies = self.file.solid.iter().flat_map(|solid| &solid.bodies);
        let supports = bodies.flat_map(|body| &body.supports).filter_map(|support| support.motion.as_ref());
        let walls = self.file.walls.iter().filter_map(|wall| wall.motion.as_ref());
        for written in walls.chain(supports).flat_map(MotionTable::formulas) {
            moves(written, time, errors);
        }
    }

    /// Where the state of the start comes from: an earlier run, or a key of this case.
    fn origin<'a>(&'a self, written: &'a Place) -> &'a Place {
        self.file.start_from.as_ref().map_or(written, |folder| &folder.place)
    }

    /// Speeds and densities of the fluid are those of weakly compressible flow.
    fn check_fluid_state<S: Space>(&self, scene: &Scene<S>, errors: &ErrorList) {
        let Some(fluid) = &self.file.fluid else { return };
        let (constants, particles) = (fluid.parameters.values(), &scene.fluid);
        let c0 = constants.sound_speed;
        let water = constants.equation_of_state();
        let (lowest, highest) =
            (water.lowest_density(), (1.0 + LARGEST_COMPRESSION) * constants.rest_density);
        let mut reported = None;
        for k in 0..particles.id.len() {
            let (x, v, density) = (&particles.position[k], &particles.velocity[k], particles.density[k]);
            let region = &fluid.regions[particles.region[k] as usize];
            // One of a region is enough.
            if reported == Some(particles.region[k]) {
                continue;
            }
            let too_fast = v.norm_squared() >= c0.powi(2);
            let error = if too_fast {
                let problem = format!(
                    "region `{}` starts at {:.3e} m/s at {}",
                    region.name.value,
                    v.norm(),
                    point_text::<S>(x)
                );
                let error = CaseError::new(self.origin(&region.velocity_m_s[0].place), problem);
                error
                    .allowed(format!("below `fluid.sound_speed_m_s` = {c0} m/s"))
                    .hint("lower the velocity, or raise the sound speed to 10 times the largest speed")
            } else if !(density > lowest && density < highest) {
                let problem = format!(
                    "region `{}` starts with a density of {density:.6e} kg/m³ at {}",
                    region.name.value,
                    point_text::<S>(x)
                );
                let error = CaseError::new(self.origin(&region.name.place), problem);
                error
                    .allowed(format!("above {lowest} and below {highest} kg/m³"))
                    .hint("check `start` of the region, or raise `fluid.sound_speed_m_s`")
            } else {
                continue;
            };
            reported = Some(particles.region[k]);
            errors.add(error);
        }
    }

    /// No body starts much faster than its waves.
    fn check_solid_speeds<S: Space>(&self, scene: &Scene<S>, errors: &ErrorList) {
        let bodies = self.file.solid.as_ref().map_or(&[][..], |solid| &solid.bodies);
        for (k, body) in (0u32..).zip(bodies) {
            let waves = body.material.parameters.values().longitudinal_speed();
            let velocities = &scene.solid.velocity[scene.body_range(k)];
            let speed = velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
            if speed > LARGEST_SPEED * waves {
                let problem = format!("body `{}` starts at {speed:.3e} m/s", body.name.value);
                let error = CaseError::new(self.origin(&body.velocity_m_s[0].place), problem);
                errors.add(
                    error
                        .allowed(format!(
                            "at most {LARGEST_SPEED} times the speed {waves:.4e} m/s of waves in its material"
                        ))
                        .hint(
                            "lower `velocity_m_s` or `rotation_speed_rad_s`, or check the elastic constants",
                        ),
                );
            }
        }
    }

    /// A rigid body has no stress for `plane` to act on.
    fn check_planes(&self, errors: &ErrorList) {
        for body in self.file.solid.iter().flat_map(|solid| &solid.bodies) {
            let material = &body.material.parameters;
            if matches!(body.formulation, FormulationTable::Rigid) && material.plane != PlaneState::Strain {
                let error = CaseError::new(&material.place("plane"), "a rigid body bears no stress");
                errors.add(error.hint("leave `plane` out, or use another formulation"));
            }
        }
    }

    /// A pivot is the only support of a rigid body.
    fn check_pivots(&self, errors: &ErrorList) {
        for body in self.file.solid.iter().flat_map(|solid| &solid.bodies) {
            let Some(pivot) = body.supports.iter().find_map(|support| support.pivot_m.as_ref()) else {
                continue;
            };
            if !matches!(body.formulation, FormulationTable::Rigid) {
                let error = CaseError::new(&pivot.place, "is a pivot of a body that is not rigid");
                errors.add(
                    error.hint("set `formulation = { type = \"rigid\" }`, or hold particles by a `shape`"),
                );
            } else if body.supports.len() > 1 {
                let error = CaseError::new(&pivot.place, "is a pivot beside other supports of its body");
                errors
                    .add(error.hint("leave the others out: a rigid body with a pivot has no other support"));
            }
        }
    }

    /// Laws of interface, contact and loads that the formulation of a body cannot serve.
    fn check_laws(&self, errors: &ErrorList) {
        let Some(solid) = &self.file.solid else { return };
        let plain_sum =
            self.file.interface.as_ref().filter(|interface| interface.law.value == InterfaceLaw::PlainSum);
        if let Some(interface) = plain_sum
            && solid.substeps != SubstepsKey::Word(SubstepsWord::None)
        {
            let problem = "the law `plain-sum` takes part in the stress of the solid, which sub-steps freeze";
            let error = CaseError::new(&interface.law.place, problem);
            errors.add(error.hint("set `solid.substeps = \"none\"`, or use another law"));
        }
        let sums = matches!(solid.contact, ContactTable::Sums);
        for body in &solid.bodies {
            check_loads(body, errors);
            let used = match (sums, plain_sum.is_some()) {
                _ if body.kernel_ratio().is_some() => continue,
                (true, _) => "`solid.contact.law = \"sums\"`",
                (false, true) => "`interface.law = \"plain-sum\"`",
                (false, false) => continue,
            };
            let problem = format!("is not updated-lagrangian, which {used} needs");
            let error = CaseError::new(&body.name.place, problem).value(&body.name.value);
            errors.add(error.hint("use the formulation `updated-lagrangian`, or another law"));
        }
        if sums {
            check_kernels(&solid.bodies, errors);
        }
    }
}

/// A pressure follows the surface of the body as it deforms.
fn check_loads(body: &BodyTable, errors: &ErrorList) {
    if matches!(body.formulation, FormulationTable::TotalLagrangian(_)) {
        return;
    }
    for pressure in body.loads.iter().filter_map(|load| load.pressure_pa.as_ref()) {
        let problem = "a pressure follows the deformed surface, which only a total-lagrangian body knows";
        let error = CaseError::new(&pressure.place, problem).value(pressure.value.text());
        errors.add(error.hint("give `traction_pa`, or use the formulation `total-lagrangian`"));
    }
}

/// Contact through the sums compares particles of two bodies by one kernel.
fn check_kernels(bodies: &[BodyTable], errors: &ErrorList) {
    let law = |body: &BodyTable| match &body.formulation {
        FormulationTable::UpdatedLagrangian(set) => {
            Some((set.kernel_ratio, set.artificial_stress, set.artificial_stress_exponent))
        }
        _ => None,
    };
    let Some(first) = bodies.iter().find_map(law) else { return };
    for body in bodies.iter().filter(|body| law(body).is_some_and(|own| own != first)) {
        let problem = "differs in `kernel_ratio`, `artificial_stress` or `artificial_stress_exponent` from the first \
                       body, which contact through the sums does not allow";
        let error = CaseError::new(&body.name.place, problem).value(&body.name.value);
        errors.add(error.hint("use the same values in all bodies, or `solid.contact.law = \"repulsion\"`"));
    }
}

/// Whether an expression of the coordinates and t has bounded values at `positions` \[m\] and `time` \[s\]; an error where not.
fn has_values<S: Space>(
    written: &At<Written>,
    positions: &[S::Vector],
    time: f64,
    errors: &ErrorList,
) -> bool {
    let Written::Text(text) = &written.value else { return true };
    let variables = Variables::CoordinatesAndTime.names(S::DIMENSIONS);
    let Ok(expression) = Expression::parse(text, variables) else { return true };
    let varies = (0..S::DIMENSIONS).any(|axis| expression.uses(axis));
    let positions = if varies { positions } else { positions.get(..1).unwrap_or_default() };
    if !errors.spend(&written.place, expression_steps(text) * positions.len() as f64) {
        return false;
    }
    let value = |x: &S::Vector| {
        let row = x.row();
        let values: Vec<f64> = row.as_ref().iter().copied().chain([time]).collect();
        expression.eval(&values)
    };
    let Some(x) = positions.iter().find(|x| !is_bounded(value(x))) else { return true };
    let place = if varies { format!(" at {}", point_text::<S>(x)) } else { String::new() };
    let problem = format!("is {:e}{place} at t = {time:e} s", value(x));
    errors.add(CaseError::new(&written.place, problem).value(quoted(text)).allowed(BOUNDED));
    false
}

/// A motion by an expression of t has a bounded place, speed and acceleration at `time` \[s\]; an error where not.
fn moves(written: &At<Written>, time: f64, errors: &ErrorList) {
    let Written::Text(text) = &written.value else { return };
    let Ok(expression) = Expression::parse(text, &["t"]) else { return };
    let at = expression.derivatives(&[time], 0);
    let found =
        [("is", at.value), ("changes at a rate of", at.first), ("has a second derivative of", at.second)];
    if let Some((what, value)) = found.into_iter().find(|(_, value)| !is_bounded(*value)) {
        let problem = format!("{what} {value:e} at t = {time:e} s");
        let error = CaseError::new(&written.place, problem).value(quoted(text)).allowed(BOUNDED);
        errors.add(error.hint("begin with a motion that has a speed and an acceleration, such as 1-cos(t)"));
    }
}
