//! Probes.

use sph::setup::{Argument, Probe, ProbeKind};
use sph::space::components::Components;

use super::{Convert, Path, WireError, finite, index, length, name, vector_from_wire};
use crate::limits::MAX_LIST;
use crate::wire;
use crate::wire::probe_argument::Value;

impl<K: ProbeKind> Convert for Probe<K> {
    type Wire = wire::Probe;

    fn to_wire(&self) -> wire::Probe {
        let argument = |(name, argument): (&'static str, Argument<K::In>)| {
            let value = match argument {
                Argument::Number(number) => Value::Number(number),
                Argument::Point(point) => {
                    Value::PointM(wire::Vector { components: point.row().as_ref().to_vec() })
                }
                Argument::Index(index) => Value::Index(index),
            };
            wire::ProbeArgument { name: name.to_owned(), value: Some(value) }
        };
        wire::Probe {
            name: self.name.clone(),
            kind: self.kind.word().to_owned(),
            arguments: self.kind.arguments().into_iter().map(argument).collect(),
            columns: self.kind.columns().iter().map(|&column| column.to_owned()).collect(),
        }
    }

    fn from_wire(wire: &wire::Probe, at: &Path<'_>) -> Result<Self, WireError> {
        length(wire.arguments.len(), MAX_LIST, &at.field("arguments"))?;
        let Some(spec) = K::SPECIFICATIONS.iter().find(|spec| spec.word == wire.kind) else {
            let words: Vec<&str> = K::SPECIFICATIONS.iter().map(|spec| spec.word).collect();
            let problem = format!("is {:?}, must be \"{}\"", wire.kind, words.join("\", \""));
            return Err(at.field("kind").error(problem));
        };
        let mut arguments = Vec::new();
        for wire::ProbeArgument { name, value } in &wire.arguments {
            let at = at.field(name);
            if !spec.arguments.iter().any(|argument| argument.name == name) {
                return Err(at.error(format!("is no argument of the kind `{}`", spec.word)));
            }
            let argument = match value {
                Some(Value::Number(number)) => Argument::Number(finite(*number, &at)?),
                Some(Value::PointM(point)) => Argument::Point(vector_from_wire(&Some(point.clone()), &at)?),
                Some(Value::Index(index)) => Argument::Index(*index),
                None => return Err(at.error("has no value, or one of a later version of the protocol")),
            };
            arguments.push((name.as_str(), argument));
        }
        let argument =
            |wanted: &str| arguments.iter().find(|(name, _)| *name == wanted).map(|(_, value)| *value);
        let kind = K::build(&wire.kind, argument)
            .map_err(|name| at.field(name).error("is missing or of another type"))?;
        if wire.columns != kind.columns() {
            let problem = format!("are {:?}, this solver reports {:?}", wire.columns, kind.columns());
            return Err(at.field("columns").error(problem));
        }
        Ok(Self { name: name(&wire.name, &at.field("name"))?, kind })
    }
}

/// Checks that the probes refer to what exists; `count` gives the length of the list that an argument points into, and
/// its name, from all arguments of the probe.
pub(super) fn check_references<K: ProbeKind>(
    probes: &[Probe<K>],
    at: &Path<'_>,
    count: impl Fn(&str, &[(&'static str, Argument<K::In>)]) -> (usize, &'static str),
) -> Result<(), WireError> {
    for (k, probe) in probes.iter().enumerate() {
        let arguments = probe.kind.arguments();
        for (name, argument) in &arguments {
            if let Argument::Index(value) = argument {
                let (len, list) = count(name, &arguments);
                index(*value, len, list, &at.item("probes", k).field(name))?;
            }
        }
    }
    Ok(())
}
