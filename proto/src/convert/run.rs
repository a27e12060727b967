//! The part of a set-up that both participants receive.

use sph::coupling::solver::Role;
use sph::coupling::stage::Stage;
use sph::setup::{
    BodyForcePlan, BreachAction, Coupling, CouplingKind, Damping, DomainPlan, InterfaceLaw, LedgerPolicy,
    OutputPlan, ParameterSet, RunPlan, RunSetup, StepPolicy, TimePlan,
};
use sph::space::{SomeSpace, Space};

use super::parameters::{parameters_from_wire, parameters_to_wire};
use super::{
    Choice, Convert, Path, WireError, choice, components_to_wire, finite, flags_from_wire, flags_to_wire,
    fraction, name, not_negative, numbers_from_wire, one_for_each, optional, positive, positive_or_infinite,
    required, text,
};
use crate::wire;

choices!(Role = wire::Role { Fluid, Solid });

choices!(Stage = wire::Stage { Predictor, Corrector });

choices!(BreachAction = wire::BreachAction { Warn, Stop, StopAndCheckpoint });

choices!(InterfaceLaw = wire::InterfaceLaw { Wall, WallNoSlip, PlainSum });

/// The number of dimensions of a run, 2 or 3.
pub(super) fn dimensions_from_wire(wire: &wire::RunSetup, at: &Path<'_>) -> Result<SomeSpace, WireError> {
    let space = usize::try_from(wire.dimensions).ok().and_then(SomeSpace::of_dimensions);
    space.ok_or_else(|| at.field("dimensions").error(format!("is {}, must be 2 or 3", wire.dimensions)))
}

impl Convert for RunPlan {
    type Wire = wire::RunSetup;

    fn to_wire(&self) -> wire::RunSetup {
        let Self { run_id, domain, time, body_force, outputs, ledger, coupling } = self;
        wire::RunSetup {
            run_id: run_id.clone(),
            // Two or three.
            dimensions: u32::try_from(self.dimensions()).unwrap_or(u32::MAX),
            domain: Some(domain_to_wire(domain)),
            time: Some(time.to_wire()),
            body_force: Some(body_force_to_wire(body_force)),
            outputs: Some(outputs.to_wire()),
            ledger: Some(ledger.to_wire()),
            coupling: coupling.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::RunSetup, at: &Path<'_>) -> Result<Self, WireError> {
        let dimensions = dimensions_from_wire(wire, at)?.dimensions();
        Ok(Self {
            run_id: name(&wire.run_id, &at.field("run_id"))?,
            domain: domain_from_wire(&wire.domain, dimensions, &at.field("domain"))?,
            time: required(&wire.time, &at.field("time"))?,
            body_force: body_force_from_wire(&wire.body_force, dimensions, &at.field("body_force"))?,
            outputs: required(&wire.outputs, &at.field("outputs"))?,
            ledger: required(&wire.ledger, &at.field("ledger"))?,
            coupling: optional(&wire.coupling, &at.field("coupling"))?,
        })
    }
}

impl<S: Space> Convert for RunSetup<S> {
    type Wire = wire::RunSetup;

    fn to_wire(&self) -> wire::RunSetup {
        self.plan().to_wire()
    }

    fn from_wire(wire: &wire::RunSetup, at: &Path<'_>) -> Result<Self, WireError> {
        let plan = RunPlan::from_wire(wire, at)?;
        plan.to_setup().ok_or_else(|| {
            at.field("dimensions").error(format!("is {}, must be {}", wire.dimensions, S::DIMENSIONS))
        })
    }
}

pub(super) fn domain_to_wire(domain: &DomainPlan) -> wire::Domain {
    wire::Domain {
        lower_m: components_to_wire(&domain.lower),
        upper_m: components_to_wire(&domain.upper),
        periodic: flags_to_wire(&domain.periodic),
    }
}

/// The box of a run of `dimensions` dimensions.
pub(super) fn domain_from_wire(
    wire: &Option<wire::Domain>,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<DomainPlan, WireError> {
    let Some(wire) = wire else { return Err(at.error("is missing")) };
    let domain = DomainPlan {
        lower: numbers_from_wire(&wire.lower_m, dimensions, &at.field("lower_m"))?,
        upper: numbers_from_wire(&wire.upper_m, dimensions, &at.field("upper_m"))?,
        periodic: flags_from_wire(&wire.periodic, dimensions, &at.field("periodic"))?,
    };
    for (axis, (lower, upper)) in domain.lower.iter().zip(&domain.upper).enumerate() {
        if lower >= upper {
            let at = at.field("upper_m");
            return Err(at.error(format!("is {upper:?} on axis {axis}, must exceed lower_m {lower:?}")));
        }
        // Products of positions with the size must stay finite.
        positive(upper - lower, &at.field("upper_m"))?;
    }
    Ok(domain)
}

pub(super) fn body_force_to_wire(body_force: &BodyForcePlan) -> wire::BodyForce {
    wire::BodyForce {
        gravity_m_per_s2: components_to_wire(&body_force.gravity),
        expressions_m_per_s2: body_force.expressions.as_deref().and_then(expressions_to_wire),
    }
}

/// The body force of a run of `dimensions` dimensions.
pub(super) fn body_force_from_wire(
    wire: &Option<wire::BodyForce>,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<BodyForcePlan, WireError> {
    let Some(wire) = wire else { return Err(at.error("is missing")) };
    let gravity = numbers_from_wire(&wire.gravity_m_per_s2, dimensions, &at.field("gravity_m_per_s2"))?;
    let at = at.field("expressions_m_per_s2");
    let expressions = wire.expressions_m_per_s2.as_ref();
    Ok(BodyForcePlan {
        gravity,
        expressions: expressions.map(|texts| expressions_from_wire(texts, dimensions, &at)).transpose()?,
    })
}

/// One expression for each dimension.
pub(super) fn expressions_to_wire(texts: &[String]) -> Option<wire::Expressions> {
    Some(wire::Expressions { components: texts.to_vec() })
}

/// The expressions of a vector of a run of `dimensions` dimensions.
pub(super) fn expressions_from_wire(
    wire: &wire::Expressions,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<Vec<String>, WireError> {
    one_for_each(dimensions, wire.components.len(), at)?;
    let checked = |(k, expression): (usize, &String)| text(expression, &at.item("components", k));
    wire.components.iter().enumerate().map(checked).collect()
}

/// The expressions of a vector of `S`.
pub(super) fn expressions_of<S: Space>(
    wire: &wire::Expressions,
    at: &Path<'_>,
) -> Result<S::PerAxis<String>, WireError> {
    let texts = expressions_from_wire(wire, S::DIMENSIONS, at)?;
    Ok(S::per_axis(|axis| texts[axis].clone()))
}

impl Convert for TimePlan {
    type Wire = wire::TimePlan;

    fn to_wire(&self) -> wire::TimePlan {
        use wire::time_plan::Step;
        let step = match &self.step {
            StepPolicy::Fixed { time_step } => Step::Fixed(wire::FixedStep { time_step_s: Some(*time_step) }),
            StepPolicy::Adaptive { factor, maximum, growth, exact } => Step::Adaptive(wire::AdaptiveStep {
                factor: Some(*factor),
                maximum_s: Some(*maximum),
                growth: Some(*growth),
                exact: exact.as_ref().map(|times| wire::ExactTimes { times_s: times.clone() }),
            }),
        };
        wire::TimePlan {
            start_time_s: Some(self.start_time),
            end_time_s: Some(self.end_time),
            step: Some(step),
        }
    }

    fn from_wire(wire: &wire::TimePlan, at: &Path<'_>) -> Result<Self, WireError> {
        use wire::time_plan::Step;
        let start_time = finite(wire.start_time_s, &at.field("start_time_s"))?;
        let end_time = finite(wire.end_time_s, &at.field("end_time_s"))?;
        if end_time < start_time {
            let problem = format!("is {end_time:?}, must not lie before start_time_s {start_time:?}");
            return Err(at.field("end_time_s").error(problem));
        }
        let step = match &wire.step {
            Some(Step::Fixed(step)) => {
                let at = at.field("fixed");
                StepPolicy::Fixed { time_step: positive(step.time_step_s, &at.field("time_step_s"))? }
            }
            Some(Step::Adaptive(step)) => {
                let at = at.field("adaptive");
                let growth = positive_or_infinite(step.growth, &at.field("growth"))?;
                if growth <= 1.0 {
                    return Err(at.field("growth").error(format!("is {growth:?}, must be above 1")));
                }
                StepPolicy::Adaptive {
                    factor: fraction(step.factor, &at.field("factor"))?,
                    maximum: positive_or_infinite(step.maximum_s, &at.field("maximum_s"))?,
                    growth,
                    exact: step
                        .exact
                        .as_ref()
                        .map(|exact| times(&exact.times_s, &at.field("exact"), "times_s"))
                        .transpose()?,
                }
            }
            None => return Err(at.field("step").error("is missing, must be `fixed` or `adaptive`")),
        };
        Ok(Self { start_time, end_time, step })
    }
}

impl Convert for OutputPlan {
    type Wire = wire::OutputPlan;

    fn to_wire(&self) -> wire::OutputPlan {
        wire::OutputPlan {
            snapshot_interval_s: self.snapshot_interval,
            probe_interval_s: self.probe_interval,
            snapshot_times_s: self.snapshot_times.clone(),
        }
    }

    fn from_wire(wire: &wire::OutputPlan, at: &Path<'_>) -> Result<Self, WireError> {
        let interval = |value: Option<f64>, name| value.map(|v| positive(v, &at.field(name))).transpose();
        Ok(Self {
            snapshot_interval: interval(wire.snapshot_interval_s, "snapshot_interval_s")?,
            probe_interval: interval(wire.probe_interval_s, "probe_interval_s")?,
            snapshot_times: times(&wire.snapshot_times_s, at, "snapshot_times_s")?,
        })
    }
}

/// A list of times, all finite.
fn times(wire: &[f64], at: &Path<'_>, field: &str) -> Result<Vec<f64>, WireError> {
    wire.iter().enumerate().map(|(k, time)| finite(*time, &at.item(field, k))).collect()
}

impl Convert for LedgerPolicy {
    type Wire = wire::LedgerPolicy;

    fn to_wire(&self) -> wire::LedgerPolicy {
        wire::LedgerPolicy {
            action: self.action.code(),
            balance_tolerance: Some(self.balance_tolerance),
            momentum_tolerance: Some(self.momentum_tolerance),
        }
    }

    fn from_wire(wire: &wire::LedgerPolicy, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            action: choice(wire.action, &at.field("action"))?,
            balance_tolerance: not_negative(wire.balance_tolerance, &at.field("balance_tolerance"))?,
            momentum_tolerance: not_negative(wire.momentum_tolerance, &at.field("momentum_tolerance"))?,
        })
    }
}

impl Convert for Coupling {
    type Wire = wire::Coupling;

    fn to_wire(&self) -> wire::Coupling {
        wire::Coupling {
            kind: self.kind.code(),
            law: self.law.code(),
            fluid: parameters_to_wire(self.fluid.stated().filter(|(spec, _)| spec.is_of_pair_law)),
            solid_spacing_m: Some(self.solid_spacing),
            margin_m: Some(self.margin),
            repulsion: Some(self.repulsion),
            implicit: self.implicit.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::Coupling, at: &Path<'_>) -> Result<Self, WireError> {
        let law = choice(wire.law, &at.field("law"))?;
        let kind = choice(wire.kind, &at.field("kind"))?;
        if kind == CouplingKind::Loads && law == InterfaceLaw::PlainSum {
            let problem =
                "is COUPLING_KIND_LOADS, which has no stress for INTERFACE_LAW_PLAIN_SUM; use a wall law";
            return Err(at.field("kind").error(problem));
        }
        if kind == CouplingKind::States && wire.implicit.is_some() {
            return Err(at
                .field("implicit")
                .error("is given with COUPLING_KIND_STATES, must go with COUPLING_KIND_LOADS"));
        }
        Ok(Self {
            kind,
            law,
            fluid: parameters_from_wire(&wire.fluid, |spec| spec.is_of_pair_law, &at.field("fluid"))?,
            solid_spacing: positive(wire.solid_spacing_m, &at.field("solid_spacing_m"))?,
            margin: not_negative(wire.margin_m, &at.field("margin_m"))?,
            repulsion: not_negative(wire.repulsion.or(Some(0.0)), &at.field("repulsion"))?,
            implicit: optional(&wire.implicit, &at.field("implicit"))?,
        })
    }
}

impl Convert for Damping {
    type Wire = wire::Damping;

    fn to_wire(&self) -> wire::Damping {
        wire::Damping { rate_per_s: Some(self.rate), until_s: Some(self.until) }
    }

    fn from_wire(wire: &wire::Damping, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            rate: not_negative(wire.rate_per_s, &at.field("rate_per_s"))?,
            until: finite(wire.until_s, &at.field("until_s"))?,
        })
    }
}
