//! The case file as written: one struct per table, every default filled in, nothing checked across tables.
//!
//! The structs write themselves as TOML under the names of their fields, which are the keys of the format.

pub mod body;
pub mod fluid;
pub mod formula;
pub mod interface;
pub mod layout;
pub mod material;
pub mod member;
pub mod probe;
pub mod run;
pub mod safety;
pub mod shape;
pub mod solid;
pub mod support;
pub mod wall;

use serde::Serialize;
use sph::setup::ParameterSet;

use crate::case::errors::CaseError;
use crate::case::reader::{At, Table};
use fluid::FluidTable;
use interface::{InterfaceTable, ServersTable};
use member::MemberTable;
use probe::ProbeTable;
use run::{BodyForceTable, DomainTable, LedgerTable, OutputsTable, TimeTable};
use safety::{CheckpointTable, DeadlinesTable};
use solid::SolidTable;
use wall::WallTable;

/// Where the values come from that a case leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The recommended settings: the defaults of each key.
    Recommended,
    /// The settings of the source paper.
    Paper,
}

impl Preset {
    const NAMES: [(&str, Self); 2] = [("recommended", Self::Recommended), ("paper", Self::Paper)];

    /// The values of a set of parameters.
    pub fn values<S: ParameterSet>(self) -> S {
        match self {
            Self::Recommended => S::default(),
            Self::Paper => S::paper(),
        }
    }
}

/// A whole case file; every value of the preset is filled in.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct CaseFile {
    pub name: At<String>,
    /// Output folder of the run whose final state this one starts from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_from: Option<At<String>>,
    /// Which member of an ensemble the run is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<MemberTable>,
    pub domain: DomainTable,
    pub body_force: BodyForceTable,
    pub time: TimeTable,
    pub outputs: OutputsTable,
    pub ledger: LedgerTable,
    pub checkpoint: CheckpointTable,
    pub deadlines: DeadlinesTable,
    #[serde(skip_serializing_if = "ServersTable::is_empty")]
    pub servers: ServersTable,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interface: Option<InterfaceTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<FluidTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid: Option<SolidTable>,
    #[serde(rename = "wall")]
    pub walls: Vec<WallTable>,
    #[serde(rename = "probe")]
    pub probes: Vec<ProbeTable>,
}

impl CaseFile {
    /// Reads the whole file.
    pub fn read(mut root: Table<'_>) -> Self {
        root.take_dimensions("domain", "lower_m");
        let name = root.name("name");
        let start_from = root.optional_text("start_from").map(|mut folder| {
            let path = root.directory.join(&folder.value);
            // A case written out elsewhere must still find it.
            if let Some(full) =
                std::path::absolute(path).ok().and_then(|path| path.to_str().map(str::to_owned))
            {
                folder.value = full;
            }
            folder
        });
        let preset = root.choice_or_first("preset", &Preset::NAMES).value;
        let domain = root
            .required_table("domain")
            .map_or_else(|| DomainTable::unwritten(&root.place_of("domain")), DomainTable::read);
        let body_force = BodyForceTable::read(root.table_or_empty("body_force"));
        let time = root
            .required_table("time")
            .map_or_else(|| TimeTable::unwritten(&root.place_of("time")), TimeTable::read);
        let outputs = OutputsTable::read(root.table_or_empty("outputs"), &time);
        let ledger = LedgerTable::read(root.table_or_empty("ledger"));
        let checkpoint = CheckpointTable::read(root.table_or_empty("checkpoint"));
        let deadlines = DeadlinesTable::read(root.table_or_empty("deadlines"));
        let servers = ServersTable::read(root.table_or_empty("servers"));
        let run = MemberTable::read(&mut root);
        let fluid = root.optional_table("fluid").map(|table| FluidTable::read(table, preset));
        let solid = root.optional_table("solid").map(|table| SolidTable::read(table, fluid.as_ref(), preset));
        if run.is_some() && fluid.is_none() {
            let error = CaseError::new(&root.place_of("run"), "displaces water, of which the case has none");
            root.error(error.hint("leave the table out"));
        }
        let coupled = fluid.is_some() && solid.is_some();
        let interface = if coupled {
            Some(InterfaceTable::read(root.table_or_empty("interface"), preset))
        } else {
            if let Some(table) = root.optional_table("interface") {
                root.error(
                    CaseError::new(table.place(), "needs both a `fluid` and a `solid`").hint("leave it out"),
                );
            }
            None
        };
        if !root.has("fluid") && !root.has("solid") {
            let error = CaseError::new(root.place(), "the case has neither a `fluid` nor a `solid`");
            root.error(error.hint("add a table [fluid] or [solid]"));
        }
        let walls = root.tables("wall").into_iter().map(WallTable::read).collect();
        let probes = root.tables("probe").into_iter().filter_map(ProbeTable::read).collect();
        root.finish();
        Self {
            name,
            start_from,
            run,
            domain,
            body_force,
            time,
            outputs,
            ledger,
            checkpoint,
            deadlines,
            servers,
            interface,
            fluid,
            solid,
            walls,
            probes,
        }
    }
}
