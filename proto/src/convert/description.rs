//! The handshake.

use std::time::Duration;

use sph::coupling::solver::Role;
use sph::setup::InterfaceLaw;
use sph::space::components::Components;
use sph::space::{AnySpace, SomeSpace, SymmetricTensor3};

use super::run::{body_force_from_wire, body_force_to_wire, domain_from_wire, domain_to_wire};
use super::{
    Choice, Convert, Path, WireError, choice, components, extent_from_wire, extent_to_wire, finite, length,
    list, name, not_negative, optional, positive_or_infinite, required, text, wires,
};
use crate::description::{
    BodyReport, Capabilities, Constants, CouplingKind, Description, Fact, FieldSpec, FrameField, Limits,
    OpenReport, ProtocolVersion,
};
use crate::limits::{MAX_LIST, MAX_REMARKS};
use crate::wire;

choices!(CouplingKind = wire::CouplingKind { States, Loads });

choices!(FrameField = wire::Field { Position, Velocity, Density, Pressure, Stress, Volume, Force });

fn codes<T: Choice>(values: &[T]) -> Vec<i32> {
    values.iter().map(|value| value.code()).collect()
}

/// Choices that are known here; a later version may add others, which this one cannot use.
fn known<T: Choice>(codes: &[i32], at: &Path<'_>) -> Result<Vec<T>, WireError> {
    length(codes.len(), MAX_LIST, at)?;
    Ok(codes.iter().filter_map(|code| choice(*code, at).ok()).collect())
}

impl Convert for ProtocolVersion {
    type Wire = wire::ProtocolVersion;

    fn to_wire(&self) -> wire::ProtocolVersion {
        wire::ProtocolVersion { major: self.major, minor: self.minor }
    }

    fn from_wire(wire: &wire::ProtocolVersion, _at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self { major: wire.major, minor: wire.minor })
    }
}

impl Convert for FieldSpec {
    type Wire = wire::FieldSpec;

    fn to_wire(&self) -> wire::FieldSpec {
        wire::FieldSpec { field: self.field.code(), unit: self.unit.clone(), components: self.components }
    }

    fn from_wire(wire: &wire::FieldSpec, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            field: choice(wire.field, &at.field("field"))?,
            unit: name(&wire.unit, &at.field("unit"))?,
            components: wire.components,
        })
    }
}

impl Convert for Limits {
    type Wire = wire::Limits;

    fn to_wire(&self) -> wire::Limits {
        wire::Limits {
            runs: self.runs,
            max_message_bytes: self.max_message_bytes,
            max_frame_bytes: self.max_frame_bytes,
            lease_s: Some(self.lease.as_secs_f64()),
        }
    }

    fn from_wire(wire: &wire::Limits, at: &Path<'_>) -> Result<Self, WireError> {
        let seconds = not_negative(wire.lease_s, &at.field("lease_s"))?;
        Ok(Self {
            runs: wire.runs,
            max_message_bytes: wire.max_message_bytes,
            max_frame_bytes: wire.max_frame_bytes,
            lease: Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX),
        })
    }
}

impl Convert for Capabilities {
    type Wire = wire::Capabilities;

    fn to_wire(&self) -> wire::Capabilities {
        let Self { checkpoint, deterministic, adaptive_step, exact_times, expressions, implicit_coupling } =
            *self;
        wire::Capabilities {
            checkpoint,
            deterministic,
            adaptive_step,
            expressions,
            implicit_coupling,
            exact_times,
        }
    }

    fn from_wire(wire: &wire::Capabilities, _at: &Path<'_>) -> Result<Self, WireError> {
        let wire::Capabilities {
            checkpoint,
            deterministic,
            adaptive_step,
            expressions,
            implicit_coupling,
            exact_times,
        } = *wire;
        Ok(Self { checkpoint, deterministic, adaptive_step, exact_times, expressions, implicit_coupling })
    }
}

impl Convert for Description {
    type Wire = wire::Description;

    fn to_wire(&self) -> wire::Description {
        let [lowest, highest] = self.protocols;
        wire::Description {
            name: self.name.clone(),
            version: self.version.clone(),
            build: self.build.clone(),
            language: self.language.clone(),
            lowest_protocol: Some(lowest.to_wire()),
            highest_protocol: Some(highest.to_wire()),
            roles: codes(&self.roles),
            dimensions: self.dimensions.clone(),
            coupling_kinds: codes(&self.coupling_kinds),
            interface_laws: codes(&self.interface_laws),
            arithmetic: self.arithmetic.clone(),
            capabilities: Some(self.capabilities.to_wire()),
            limits: Some(self.limits.to_wire()),
        }
    }

    fn from_wire(wire: &wire::Description, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            version: text(&wire.version, &at.field("version"))?,
            build: text(&wire.build, &at.field("build"))?,
            language: text(&wire.language, &at.field("language"))?,
            protocols: [
                required(&wire.lowest_protocol, &at.field("lowest_protocol"))?,
                required(&wire.highest_protocol, &at.field("highest_protocol"))?,
            ],
            roles: known::<Role>(&wire.roles, &at.field("roles"))?,
            dimensions: wire.dimensions.clone(),
            coupling_kinds: known(&wire.coupling_kinds, &at.field("coupling_kinds"))?,
            interface_laws: known::<InterfaceLaw>(&wire.interface_laws, &at.field("interface_laws"))?,
            arithmetic: text(&wire.arithmetic, &at.field("arithmetic"))?,
            capabilities: optional(&wire.capabilities, &at.field("capabilities"))?.unwrap_or_default(),
            limits: required(&wire.limits, &at.field("limits"))?,
        })
    }
}

impl Convert for Constants {
    type Wire = wire::Constants;

    fn to_wire(&self) -> wire::Constants {
        wire::Constants {
            kernel: self.kernel.clone(),
            body_force: Some(body_force_to_wire(&self.body_force)),
            coupling: self.coupling.as_ref().map(Convert::to_wire),
            domain: Some(domain_to_wire(&self.domain)),
            time: Some(self.time.to_wire()),
        }
    }

    fn from_wire(wire: &wire::Constants, at: &Path<'_>) -> Result<Self, WireError> {
        let lower = wire.domain.as_ref().and_then(|domain| domain.lower_m.as_ref());
        let lower = lower.map_or(0, |lower| lower.components.len());
        let Some(space) = SomeSpace::of_dimensions(lower) else {
            let problem =
                format!("has {lower} components, must have 2 or 3, as many as the run has dimensions");
            return Err(at.field("domain").field("lower_m").error(problem));
        };
        let dimensions = space.dimensions();
        Ok(Self {
            kernel: name(&wire.kernel, &at.field("kernel"))?,
            body_force: body_force_from_wire(&wire.body_force, dimensions, &at.field("body_force"))?,
            coupling: optional(&wire.coupling, &at.field("coupling"))?,
            domain: domain_from_wire(&wire.domain, dimensions, &at.field("domain"))?,
            time: required(&wire.time, &at.field("time"))?,
        })
    }
}

impl Convert for Fact {
    type Wire = wire::Fact;

    fn to_wire(&self) -> wire::Fact {
        wire::Fact { name: self.name.clone(), value: Some(self.value), unit: self.unit.clone() }
    }

    fn from_wire(wire: &wire::Fact, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            name: text(&wire.name, &at.field("name"))?,
            value: finite(wire.value, &at.field("value"))?,
            unit: text(&wire.unit, &at.field("unit"))?,
        })
    }
}

impl Convert for OpenReport {
    type Wire = wire::OpenReply;

    fn to_wire(&self) -> wire::OpenReply {
        wire::OpenReply {
            run_id: self.run_id.clone(),
            role: self.role.code(),
            protocol: Some(self.protocol.to_wire()),
            name: self.name.clone(),
            version: self.version.clone(),
            arithmetic: self.arithmetic.clone(),
            constants: Some(self.constants.to_wire()),
            fields_sent: wires(&self.fields_sent),
            fields_needed: wires(&self.fields_needed),
            extent: Some(extent_to_wire(&self.extent)),
            time_step_limit_s: Some(self.time_step_limit),
            counts: Some(self.counts.to_wire()),
            facts: wires(&self.facts),
            coupling_kind: self.coupling_kind.code(),
            bodies: wires(&self.bodies),
            remarks: self.remarks.clone(),
        }
    }

    fn from_wire(wire: &wire::OpenReply, at: &Path<'_>) -> Result<Self, WireError> {
        let constants: Constants = required(&wire.constants, &at.field("constants"))?;
        let dimensions = constants.domain.lower.len();
        let bodies: Vec<BodyReport> = list(&wire.bodies, at, "bodies")?;
        for (k, inertia) in bodies.iter().enumerate().filter_map(|(k, body)| Some((k, body.inertia?))) {
            if inertia.dimensions() != dimensions {
                let problem = format!(
                    "has an inertia of {} dimensions in a run of {dimensions} dimensions",
                    inertia.dimensions()
                );
                return Err(at.item("bodies", k).error(problem));
            }
        }
        let remark = |(k, remark): (usize, &String)| text(remark, &at.item("remarks", k));
        Ok(Self {
            run_id: name(&wire.run_id, &at.field("run_id"))?,
            role: choice(wire.role, &at.field("role"))?,
            protocol: required(&wire.protocol, &at.field("protocol"))?,
            name: name(&wire.name, &at.field("name"))?,
            version: text(&wire.version, &at.field("version"))?,
            arithmetic: text(&wire.arithmetic, &at.field("arithmetic"))?,
            coupling_kind: choice(wire.coupling_kind, &at.field("coupling_kind"))?,
            constants,
            fields_sent: list(&wire.fields_sent, at, "fields_sent")?,
            fields_needed: list(&wire.fields_needed, at, "fields_needed")?,
            extent: extent_from_wire(&wire.extent, dimensions, &at.field("extent"))?,
            time_step_limit: positive_or_infinite(wire.time_step_limit_s, &at.field("time_step_limit_s"))?,
            counts: required(&wire.counts, &at.field("counts"))?,
            facts: list(&wire.facts, at, "facts")?,
            bodies,
            remarks: wire
                .remarks
                .iter()
                .take(MAX_REMARKS)
                .enumerate()
                .map(remark)
                .collect::<Result<_, _>>()?,
        })
    }
}

/// Number and tensor have fields of their own.
impl Convert for BodyReport {
    type Wire = wire::BodyReport;

    fn to_wire(&self) -> wire::BodyReport {
        let (number, tensor) = match self.inertia {
            None => (None, Vec::new()),
            Some(AnySpace::Plane(number)) => (Some(number), Vec::new()),
            Some(AnySpace::Spatial(tensor)) => (None, tensor.row().to_vec()),
        };
        wire::BodyReport { mass_kg: Some(self.mass), inertia_kg_m2: number, inertia_tensor_kg_m2: tensor }
    }

    fn from_wire(wire: &wire::BodyReport, at: &Path<'_>) -> Result<Self, WireError> {
        let tensor = at.field("inertia_tensor_kg_m2");
        let inertia = match (wire.inertia_kg_m2, wire.inertia_tensor_kg_m2.as_slice()) {
            (None, []) => None,
            (Some(number), []) => Some(AnySpace::Plane(finite(number, &at.field("inertia_kg_m2"))?)),
            (None, numbers) => {
                let row: [f64; 6] = components(numbers, &tensor)?;
                for (k, number) in row.into_iter().enumerate() {
                    finite(number, &at.item("inertia_tensor_kg_m2", k))?;
                }
                Some(AnySpace::Spatial(SymmetricTensor3::from_row(row)))
            }
            (Some(_), _) => return Err(tensor.error("is given beside inertia_kg_m2")),
        };
        Ok(Self { mass: finite(wire.mass_kg, &at.field("mass_kg"))?, inertia })
    }
}
