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
use crate::case::spec::{Kind, TableSpec, key};
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

/// Rows of a whole case file.
pub static CASE: TableSpec = TableSpec::new(
    "case",
    "A case of Tidelock: a fluid, solids or both, and a run of them. All numbers are SI, with the unit in the name of the \
     key.",
    &[
        key("name", Kind::Name, "name of the case"),
        key(
            "preset",
            Kind::Word(&[
                ("recommended", "the defaults of all keys"),
                (
                    "paper",
                    "the source paper: its column of docs/parameters.md, the laws `plain-sum` and `sums`, and \
                     updated-Lagrangian bodies",
                ),
            ]),
            "values of what the case leaves out",
        )
        .or_word("recommended"),
        key(
            "start_from",
            Kind::Text("the path of a folder, from the folder of the case"),
            "output folder of an earlier run whose final state is the initial state",
        )
        .or_else("none: the case is its own start"),
        key("run", Kind::Table(&member::RUN), "which member of an ensemble it is").or_else("none"),
        key("domain", Kind::Table(&run::DOMAIN), "the box that contains the scene"),
        key("body_force", Kind::Table(&run::BODY_FORCE), "gravity and other accelerations").or_else("nothing pulls"),
        key("time", Kind::Table(&run::TIME), "start, end and steps"),
        key("outputs", Kind::Table(&run::OUTPUTS), "what a run leaves behind").or_else(DEFAULTS),
        key("ledger", Kind::Table(&run::LEDGER), "audit of the balances").or_else(DEFAULTS),
        key("checkpoint", Kind::Table(&safety::CHECKPOINT), "when states are kept").or_else(DEFAULTS),
        key("deadlines", Kind::Table(&safety::DEADLINES), "longest waits for servers").or_else(DEFAULTS),
        key("servers", Kind::Table(&interface::SERVERS), "where the solvers come from").or_else("the built-in servers"),
        key("interface", Kind::Table(&interface::INTERFACE), "law between fluid and solids, in a case with both")
            .or_else(DEFAULTS),
        key("fluid", Kind::Table(&fluid::FLUID), "the fluid").or_else("none: there must be solids"),
        key("solid", Kind::Table(&solid::SOLID), "the solids").or_else("none: there must be a fluid"),
        key("wall", Kind::Tables(&wall::WALL), "the walls, a table for each").or_else("none"),
        key("probe", Kind::Tables(&probe::PROBE), "the probes, a table for each").or_else("none"),
    ],
);

const DEFAULTS: &str = "the defaults of its keys";

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
        let preset = root.choice_or_default("preset", &Preset::NAMES).value;
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
