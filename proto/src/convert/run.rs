//! The part of a set-up that both participants receive.

use sph::coupling::solver::Role;
use sph::coupling::stage::Stage;
use sph::setup::{
    BodyForce, BreachAction, Coupling, CouplingKind, Damping, InterfaceLaw, LedgerPolicy, Motion, OutputPlan,
    ParameterSet, RunSetup, StepPolicy, TimePlan, WallCondition, WallParticles, WallSetup,
};
use sph::space::DIMENSIONS;
use sph::space::domain::Domain;

use super::arrays::{index_count, pack, pack_indices, unpack, unpack_indices_below};
use super::parameters::{parameters_from_wire, parameters_to_wire};
use super::{
    Choice, Convert, Path, WireError, choice, components, finite, flags_from_wire, flags_to_wire, fraction,
    name, not_negative, optional, positive, positive_or_infinite, required, text,
};
use crate::description::DIMENSION_COUNT;
use crate::wire;

choices!(Role = wire::Role { Fluid, Solid });

choices!(Stage = wire::Stage { Predictor, Corrector });

choices!(BreachAction = wire::BreachAction { Warn, Stop, StopAndCheckpoint });

choices!(InterfaceLaw = wire::InterfaceLaw { Wall, WallNoSlip, PlainSum });

choices!(WallCondition = wire::WallCondition { Slip, NoSlip });

impl Convert for RunSetup {
    type Wire = wire::RunSetup;

    fn to_wire(&self) -> wire::RunSetup {
        let Self { run_id, domain, time, body_force, outputs, ledger, coupling } = self;
        wire::RunSetup {
            run_id: run_id.clone(),
            dimensions: DIMENSION_COUNT,
            domain: Some(domain.to_wire()),
            time: Some(time.to_wire()),
            body_force: Some(body_force.to_wire()),
            outputs: Some(outputs.to_wire()),
            ledger: Some(ledger.to_wire()),
            coupling: coupling.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::RunSetup, at: &Path<'_>) -> Result<Self, WireError> {
        if wire.dimensions != DIMENSION_COUNT {
            let problem = format!("is {}, this program computes in {DIMENSIONS}", wire.dimensions);
            return Err(at.field("dimensions").error(problem));
        }
        Ok(Self {
            run_id: name(&wire.run_id, &at.field("run_id"))?,
            domain: required(&wire.domain, &at.field("domain"))?,
            time: required(&wire.time, &at.field("time"))?,
            body_force: required(&wire.body_force, &at.field("body_force"))?,
            outputs: required(&wire.outputs, &at.field("outputs"))?,
            ledger: required(&wire.ledger, &at.field("ledger"))?,
            coupling: optional(&wire.coupling, &at.field("coupling"))?,
        })
    }
}

impl Convert for Domain {
    type Wire = wire::Domain;

    fn to_wire(&self) -> wire::Domain {
        wire::Domain {
            lower_m: Some(self.lower.to_wire()),
            upper_m: Some(self.upper.to_wire()),
            periodic: flags_to_wire(self.periodic),
        }
    }

    fn from_wire(wire: &wire::Domain, at: &Path<'_>) -> Result<Self, WireError> {
        let domain = Self {
            lower: required(&wire.lower_m, &at.field("lower_m"))?,
            upper: required(&wire.upper_m, &at.field("upper_m"))?,
            periodic: flags_from_wire(&wire.periodic, &at.field("periodic"))?,
        };
        for axis in 0..DIMENSIONS {
            let (lower, upper) = (domain.lower[axis], domain.upper[axis]);
            if lower >= upper {
                let at = at.field("upper_m");
                return Err(at.error(format!("is {upper:?} on axis {axis}, must exceed lower_m {lower:?}")));
            }
            // Products of positions with the size must stay finite.
            positive(upper - lower, &at.field("upper_m"))?;
        }
        Ok(domain)
    }
}

impl Convert for TimePlan {
    type Wire = wire::TimePlan;

    fn to_wire(&self) -> wire::TimePlan {
        use wire::time_plan::Step;
        let step = match self.step {
            StepPolicy::Fixed { time_step } => Step::Fixed(wire::FixedStep { time_step_s: Some(time_step) }),
            StepPolicy::Adaptive { factor, maximum, growth } => Step::Adaptive(wire::AdaptiveStep {
                factor: Some(factor),
                maximum_s: Some(maximum),
                growth: Some(growth),
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
                }
            }
            None => return Err(at.field("step").error("is missing, must be `fixed` or `adaptive`")),
        };
        Ok(Self { start_time, end_time, step })
    }
}

/// One expression per dimension.
impl Convert for [String; DIMENSIONS] {
    type Wire = wire::Expressions;

    fn to_wire(&self) -> wire::Expressions {
        wire::Expressions { components: self.to_vec() }
    }

    fn from_wire(wire: &wire::Expressions, at: &Path<'_>) -> Result<Self, WireError> {
        for (k, expression) in wire.components.iter().enumerate() {
            text(expression, &at.item("components", k))?;
        }
        components(&wire.components, at)
    }
}

impl Convert for BodyForce {
    type Wire = wire::BodyForce;

    fn to_wire(&self) -> wire::BodyForce {
        wire::BodyForce {
            gravity_m_per_s2: Some(self.gravity.to_wire()),
            expressions_m_per_s2: self.expressions.as_ref().map(Convert::to_wire),
        }
    }

    fn from_wire(wire: &wire::BodyForce, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            gravity: required(&wire.gravity_m_per_s2, &at.field("gravity_m_per_s2"))?,
            expressions: optional(&wire.expressions_m_per_s2, &at.field("expressions_m_per_s2"))?,
        })
    }
}

impl Convert for OutputPlan {
    type Wire = wire::OutputPlan;

    fn to_wire(&self) -> wire::OutputPlan {
        wire::OutputPlan {
            snapshot_interval_s: self.snapshot_interval,
            probe_interval_s: self.probe_interval,
        }
    }

    fn from_wire(wire: &wire::OutputPlan, at: &Path<'_>) -> Result<Self, WireError> {
        let interval = |value: Option<f64>, name| value.map(|v| positive(v, &at.field(name))).transpose();
        Ok(Self {
            snapshot_interval: interval(wire.snapshot_interval_s, "snapshot_interval_s")?,
            probe_interval: interval(wire.probe_interval_s, "probe_interval_s")?,
        })
    }
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

impl Convert for Motion {
    type Wire = wire::Motion;

    fn to_wire(&self) -> wire::Motion {
        wire::Motion {
            displacement_m: Some(self.displacement.to_wire()),
            angle_rad: self.angle.clone(),
            pivot_m: Some(self.pivot.to_wire()),
        }
    }

    fn from_wire(wire: &wire::Motion, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            displacement: required(&wire.displacement_m, &at.field("displacement_m"))?,
            angle: text(&wire.angle_rad, &at.field("angle_rad"))?,
            axis: 1.0,
            pivot: required(&wire.pivot_m, &at.field("pivot_m"))?,
        })
    }
}

/// A time of release, which may be absent.
pub(super) fn release_time(wire: Option<f64>, at: &Path<'_>) -> Result<Option<f64>, WireError> {
    wire.map(|time| finite(time, &at.field("release_time_s"))).transpose()
}

impl Convert for WallSetup {
    type Wire = wire::WallSetup;

    fn to_wire(&self) -> wire::WallSetup {
        wire::WallSetup {
            name: self.name.clone(),
            condition: self.condition.code(),
            motion: self.motion.as_ref().map(Convert::to_wire),
            release_time_s: self.release_time,
        }
    }

    fn from_wire(wire: &wire::WallSetup, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            condition: choice(wire.condition, &at.field("condition"))?,
            motion: optional(&wire.motion, &at.field("motion"))?,
            release_time: release_time(wire.release_time_s, at)?,
        })
    }
}

pub(super) fn wall_particles_to_wire(particles: &WallParticles) -> wire::WallParticles {
    wire::WallParticles {
        walls: pack_indices(&particles.wall),
        positions_m: pack(&particles.position),
        normals: pack(&particles.normal),
    }
}

/// Wall particles of `walls` walls; an absent message has none.
pub(super) fn wall_particles_from_wire(
    wire: &Option<wire::WallParticles>,
    walls: usize,
    at: &Path<'_>,
) -> Result<WallParticles, WireError> {
    let Some(wire) = wire else { return Ok(WallParticles::default()) };
    let count = index_count(&wire.walls, &at.field("walls"))?;
    Ok(WallParticles {
        wall: unpack_indices_below(&wire.walls, count, walls, "walls", &at.field("walls"))?,
        position: unpack(&wire.positions_m, count, &at.field("positions_m"))?,
        normal: unpack(&wire.normals, count, &at.field("normals"))?,
    })
}
