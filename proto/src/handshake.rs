//! Comparison of what participants say, before step 1: all differences at once.

use sph::coupling::solver::Role;
use sph::lanes::Path;
use sph::setup::{
    AnySolidSetup, BodyParticles, BodySetup, Coupling, FluidParameters, Formulation, ParameterSet, RunPlan,
    SolidSetup, StepPolicy,
};
use sph::space::components::Components;
use sph::space::{AnySpace, Space};

use crate::description::{
    BodyReport, Constants, CouplingKind, Description, FieldSpec, Inertia, OpenReport, PROTOCOL,
};

/// The first of the kinds `acceptable` that every participant offers; the first of all when they share none, which
/// [`unfit`] then tells.
pub fn coupling_kind(acceptable: &[CouplingKind], descriptions: &[&Description]) -> CouplingKind {
    let shared = |kind: &&CouplingKind| {
        descriptions.iter().all(|description| description.coupling_kinds.contains(kind))
    };
    acceptable.iter().find(shared).or(acceptable.first()).copied().unwrap_or_default()
}

/// Why a server of `description` cannot play `role` in `run`; empty when it can.
pub fn unfit(description: &Description, role: Role, run: &RunPlan) -> Vec<String> {
    let who = format!("{} {}", description.name, description.version);
    let mut reasons = Vec::new();
    let [lowest, highest] = description.protocols;
    if PROTOCOL < lowest || lowest.major != PROTOCOL.major && highest.major != PROTOCOL.major {
        reasons.push(format!("{who} speaks protocol {lowest} to {highest}, this coordinator {PROTOCOL}; use releases that share one"));
    }
    if !description.roles.contains(&role) {
        let roles: Vec<String> = description.roles.iter().map(Role::to_string).collect();
        reasons.push(format!("{who} plays {}, needed is {role}", roles.join(" or ")));
    }
    let dimensions = run.dimensions();
    if !description.dimensions.iter().any(|offered| usize::try_from(*offered) == Ok(dimensions)) {
        let offered: Vec<String> = description.dimensions.iter().map(u32::to_string).collect();
        reasons.push(format!(
            "{who} computes in {} dimensions, the case in {dimensions}; use a solver that offers {dimensions}",
            offered.join(" or ")
        ));
    }
    if let Some(coupling) = &run.coupling {
        if !description.coupling_kinds.contains(&coupling.kind) {
            let kinds: Vec<&str> = description.coupling_kinds.iter().map(|kind| kind.name()).collect();
            reasons.push(format!(
                "{who} couples by {}, needed is {}; set `interface.kind` of the case to what both sides offer",
                kinds.join(" or "),
                coupling.kind.name()
            ));
        }
        if !description.interface_laws.contains(&coupling.law) {
            let laws = &description.interface_laws;
            reasons
                .push(format!("{who} offers interface laws {laws:?}, the case asks for {:?}", coupling.law));
        }
    }
    // A solver that does not compute in lanes has no path to choose.
    if let (Some(said), Some(forced)) = (Path::named(&description.arithmetic), sph::lanes::forced())
        && said != forced
    {
        let (said, forced) = (said.name(), forced.option());
        reasons.push(format!(
            "{who} computes with arithmetic {said}, the command line says `{forced}`; start it with `--arithmetic {forced}`"
        ));
    }
    if let StepPolicy::Adaptive { exact, .. } = &run.time.step {
        if !description.capabilities.adaptive_step {
            reasons.push(format!("{who} takes fixed time steps only, the case asks for adaptive ones"));
        } else if exact.is_some() && !description.capabilities.exact_times {
            reasons.push(format!(
                "{who} does not shorten adaptive steps to meet the times of outputs; set `exact_outputs = false` in the \
                 case's `[time] step`, or use a solver that does"
            ));
        }
    }
    let implicit = run.coupling.is_some_and(|coupling| coupling.implicit.is_some());
    if implicit && !description.capabilities.implicit_coupling {
        reasons.push(format!(
            "{who} does not offer implicit coupling, which the case needs; leave out `interface.iterate` and take a smaller \
             time step, or use a solver that offers it"
        ));
    }
    if run.body_force.expressions.is_some() && !description.capabilities.expressions {
        reasons.push(format!("{who} evaluates no expressions, the case's body force has them"));
    }
    reasons
}

/// Relative difference that sums of the same masses may have \[-\].
const SAME_MASS: f64 = 1e-9;

/// All differences between the bodies of `setup` and those that the solid says it moves, each with both values; empty
/// when they fit, and for a solver of a version that does not say.
pub fn other_bodies(setup: &AnySolidSetup, report: &OpenReport) -> Vec<String> {
    if report.bodies.is_empty() {
        return Vec::new();
    }
    let expected = match setup {
        AnySpace::Plane(setup) => bodies(setup, |particles| AnySpace::Plane(particles.inertia())),
        AnySpace::Spatial(setup) => bodies(setup, |particles| AnySpace::Spatial(particles.inertia())),
    };
    if report.bodies.len() != expected.len() {
        return vec![format!("it has {} bodies, the set-up {}", report.bodies.len(), expected.len())];
    }
    let mut differences = Vec::new();
    for ((body, expected), said) in expected.iter().zip(&report.bodies) {
        // Relative to `scale`, as a component of a tensor may be zero.
        let mut compare = |what: &str, unit: &str, said: f64, expected: f64, scale: f64| {
            let error = (said - expected).abs();
            if error.is_nan() || error > SAME_MASS * scale {
                differences.push(format!(
                    "{what} of body `{body}`: {said:e} {unit}, the particles of the set-up have {expected:e} {unit}"
                ));
            }
        };
        compare("mass", "kg", said.mass, expected.mass, expected.mass);
        match (said.inertia, expected.inertia) {
            (Some(AnySpace::Plane(said)), Some(AnySpace::Plane(expected))) => {
                compare("moment of inertia", "kg m2", said, expected, expected);
            }
            (Some(AnySpace::Spatial(said)), Some(AnySpace::Spatial(expected))) => {
                let (said, expected) = (said.row(), expected.row());
                let scale = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
                for ((name, said), expected) in TENSOR.iter().zip(said).zip(expected) {
                    compare(&format!("moment of inertia {name}"), "kg m2", said, expected, scale);
                }
            }
            (Some(said), Some(expected)) => differences.push(format!(
                "moment of inertia of body `{body}`: is of {} dimensions, the set-up of {}",
                said.dimensions(),
                expected.dimensions()
            )),
            (None, _) | (_, None) => {}
        }
    }
    differences
}

/// Components of a symmetric tensor in space.
const TENSOR: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "xz"];

/// Name, mass and, of a rigid one, inertia of each body of `setup`.
fn bodies<S: Space>(
    setup: &SolidSetup<S>,
    inertia: impl Fn(BodyParticles<'_, S>) -> Inertia,
) -> Vec<(String, BodyReport)> {
    let report = |(k, body): (u32, &BodySetup<S>)| {
        let particles = setup.particles.of_body(k);
        let mass = particles.mass();
        let rigid = matches!(body.formulation, Formulation::Rigid);
        (body.name.clone(), BodyReport { mass, inertia: rigid.then(|| inertia(particles)) })
    };
    (0u32..).zip(&setup.bodies).map(report).collect()
}

/// All differences between the two sides of a coupled run, each with both values; empty when they fit.
pub fn mismatches(fluid: &OpenReport, solid: &OpenReport) -> Vec<String> {
    let mut found = Differences(Vec::new());
    if fluid.role != Role::Fluid || solid.role != Role::Solid {
        found.0.push(format!("roles: {} and {}, must be fluid and solid", fluid.role, solid.role));
    }
    found.compare("run id", &fluid.run_id, &solid.run_id);
    found.compare("protocol major version", &fluid.protocol.major, &solid.protocol.major);
    found.compare("coupling kind", &fluid.coupling_kind, &solid.coupling_kind);
    found.constants(&fluid.constants, &solid.constants);
    found.fields("fluid", &fluid.fields_needed, "solid", &solid.fields_sent);
    found.fields("solid", &solid.fields_needed, "fluid", &fluid.fields_sent);
    found.0
}

struct Differences(Vec<String>);

impl Differences {
    fn compare<T: PartialEq + std::fmt::Debug>(&mut self, what: &str, fluid: &T, solid: &T) {
        if fluid != solid {
            self.0.push(format!("{what}: {fluid:?} at the fluid, {solid:?} at the solid"));
        }
    }

    /// Compares by bits: both sides must compute with the same number.
    fn number(&mut self, what: &str, unit: &str, fluid: f64, solid: f64) {
        if fluid.to_bits() != solid.to_bits() {
            self.0.push(format!("{what}: {fluid:?} {unit} at the fluid, {solid:?} {unit} at the solid"));
        }
    }

    /// Compares vectors along the axes that both have.
    fn axes(&mut self, what: &str, unit: &str, fluid: &[f64], solid: &[f64]) {
        for ((name, fluid), solid) in ["x", "y", "z"].into_iter().zip(fluid).zip(solid) {
            self.number(&format!("{what} {name}"), unit, *fluid, *solid);
        }
    }

    fn constants(&mut self, fluid: &Constants, solid: &Constants) {
        self.compare("kernel", &fluid.kernel, &solid.kernel);
        self.compare("dimensions", &fluid.domain.lower.len(), &solid.domain.lower.len());
        let (f, s) = (&fluid.domain, &solid.domain);
        self.axes("gravity", "m/s2", &fluid.body_force.gravity, &solid.body_force.gravity);
        self.axes("domain lower", "m", &f.lower, &s.lower);
        self.axes("domain upper", "m", &f.upper, &s.upper);
        self.compare("body force", &fluid.body_force.expressions, &solid.body_force.expressions);
        self.compare("periodic directions", &fluid.domain.periodic, &solid.domain.periodic);
        self.number("start time", "s", fluid.time.start_time, solid.time.start_time);
        self.number("end time", "s", fluid.time.end_time, solid.time.end_time);
        self.compare("time step", &fluid.time.step, &solid.time.step);
        match (&fluid.coupling, &solid.coupling) {
            (Some(fluid), Some(solid)) => self.coupling(fluid, solid),
            (fluid, solid) => self.compare("coupling present", &fluid.is_some(), &solid.is_some()),
        }
    }

    fn coupling(&mut self, fluid: &Coupling, solid: &Coupling) {
        self.compare("coupling kind of the set-up", &fluid.kind, &solid.kind);
        self.compare("interface law", &fluid.law, &solid.law);
        self.compare("implicit coupling", &fluid.implicit, &solid.implicit);
        self.number("solid particle spacing", "m", fluid.solid_spacing, solid.solid_spacing);
        self.number("margin", "m", fluid.margin, solid.margin);
        for spec in FluidParameters::SPECIFICATIONS.iter().filter(|spec| spec.is_of_pair_law) {
            let (f, s) = (fluid.fluid.get(spec.key), solid.fluid.get(spec.key));
            if let (Some(f), Some(s)) = (f, s)
                && !f.is(&s)
            {
                self.0.push(format!("{}: {f} at the fluid, {s} at the solid", spec.key));
            }
        }
    }

    fn fields(&mut self, receiver: &str, needed: &[FieldSpec], sender: &str, sent: &[FieldSpec]) {
        for need in needed {
            let name = need.field.name();
            match sent.iter().find(|spec| spec.field == need.field) {
                None => self
                    .0
                    .push(format!("field {name}: the {receiver} needs it, the {sender} does not send it")),
                Some(spec) if spec != need => self.0.push(format!(
                    "field {name}: the {receiver} needs {} numbers in {}, the {sender} sends {} in {}",
                    need.components, need.unit, spec.components, spec.unit
                )),
                Some(_) => {}
            }
        }
    }
}
