//! Probes as a case file writes them.

use std::collections::BTreeMap;

use serde::Serialize;
use sph::coupling::solver::Role;
use sph::setup::{ArgumentKind, FluidProbeKind, ProbeKind, ProbeSpec, SolidProbeKind};

use crate::case::reader::{Allowed, At, Choice, Coordinates, Table};
use crate::case::spec::{Kind, TableSpec, Variants, key};

/// Rows of `[[probe]]`; the kinds have rows of their own.
pub static PROBE: TableSpec = TableSpec::new(
    "probe",
    "A quantity to report at probe times; its columns of `probes.csv` are named `<probe>_<quantity>_<unit>`.",
    &[key("name", Kind::Name, "name of the probe, the first part of the names of its columns")],
)
.by(Variants {
    probes: &[<FluidProbeKind>::SPECIFICATIONS, <SolidProbeKind>::SPECIFICATIONS],
    ..Variants::new("type", "what it reports", &[])
});

/// `[[probe]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct ProbeTable {
    pub name: At<String>,
    /// The row of the kind, and who reports it.
    #[serde(rename = "type")]
    pub kind: Choice<(Role, &'static ProbeSpec)>,
    /// Arguments that the case gives, by name.
    #[serde(flatten)]
    pub arguments: BTreeMap<&'static str, WrittenArgument>,
    #[serde(skip)]
    pub intact: bool,
}

/// An argument as written.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
#[allow(missing_docs)]
pub enum WrittenArgument {
    Number(At<f64>),
    Point(At<Coordinates>),
    /// Name of a region, wall, body or support.
    Name(At<String>),
}

impl ProbeTable {
    /// Reads the table; `None` when its type is wrong.
    pub fn read(mut table: Table<'_>) -> Option<Self> {
        let name = table.name("name");
        let fluid = <FluidProbeKind>::SPECIFICATIONS.iter().map(|spec| (spec.word, (Role::Fluid, spec)));
        let solid = <SolidProbeKind>::SPECIFICATIONS.iter().map(|spec| (spec.word, (Role::Solid, spec)));
        let kinds: Vec<_> = fluid.chain(solid).collect();
        let Some(kind) = table.choice("type", &kinds) else {
            table.abandon();
            table.finish();
            return None;
        };
        let mut arguments = BTreeMap::new();
        for argument in kind.value.1.arguments {
            let name = argument.name;
            let written = match argument.kind {
                ArgumentKind::Number => {
                    Some(WrittenArgument::Number(table.number_within(name, &Allowed::FINITE)))
                }
                ArgumentKind::Point => Some(WrittenArgument::Point(table.vector(name))),
                ArgumentKind::Index => Some(WrittenArgument::Name(table.name(name))),
                ArgumentKind::OptionalIndex => table.optional_name(name).map(WrittenArgument::Name),
            };
            arguments.extend(written.map(|written| (name, written)));
        }
        Some(Self { name, kind, arguments, intact: table.finish() })
    }
}
