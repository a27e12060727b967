//! Interface law and servers as a case file writes them.

use std::path::{Path, PathBuf};

use proto::transport::security::ClientFiles;
use serde::Serialize;
use sph::setup::{CouplingKind, ImplicitCoupling, InterfaceLaw, NonConvergence, Relaxation};

use super::Preset;
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, Choice, Table};
use crate::case::spec::{Kind, TableSpec, key};

const MARGIN: Allowed = Allowed::new(0.0, 20.0, (false, true), "a number above 0 and at most 20");
const TOLERANCE: Allowed = Allowed::new(0.0, 1.0, (false, false), "a number above 0 and below 1");

/// Rows of `[interface]`.
pub static INTERFACE: TableSpec = TableSpec::new(
    "interface",
    "How fluid and solids act on each other.",
    &[
        key(
            "law",
            Kind::Word(&[
                ("wall", "a solid is a wall along which the fluid slides"),
                ("wall-no-slip", "the fluid has the velocity of the solid at its face"),
                ("plain-sum", "one sum over all particles, as in the source paper"),
            ]),
            "pair law between fluid and solids",
        )
        .or_else("\"wall\"; \"plain-sum\" with the preset \"paper\""),
        key(
            "kind",
            Kind::Word(&[
                ("states", "both sides evaluate the pair law"),
                ("loads", "the solid sends coupling points and receives the force on each; with wall laws only"),
            ]),
            "what the solid sends and receives",
        )
        .or_else("states if both servers offer it, else loads; loads with `iterate`"),
        key("iterate", Kind::Table(&ITERATE), "implicit coupling, for which `iterate = {}` suffices; implies loads")
            .or_else("explicit coupling"),
        key(
            "path",
            Kind::Word(&[
                ("direct", "from one server to the other"),
                ("relay", "through the coordinator; the results have the same bits"),
            ]),
            "path of the half-step frames",
        )
        .or_word("direct"),
        key(
            "repulsion",
            Kind::Number(Allowed::NOT_NEGATIVE),
            "coefficient of the repulsion of fluid particles lower than 0.6 Δx over the outer row of a solid, in the wall \
             laws; 0 switches it off",
        )
        .or(1.0),
        key(
            "margin_spacings",
            Kind::Number(MARGIN),
            "margin beyond the support radius up to which interface particles are sent",
        )
        .or(1.0),
    ],
);

/// Rows of `iterate`.
static ITERATE: TableSpec = TableSpec::new(
    "iterate",
    "Implicit coupling: half-steps are repeated until the forces on each body agree with those that moved it.",
    &[
        key(
            "relaxation",
            Kind::NumberOrWord(
                Allowed::FRACTION,
                &[("aitken", "a factor that follows from the last two updates")],
            ),
            "relaxation of the updates: a constant factor or a rule",
        )
        .or_word("aitken"),
        key(
            "tolerance",
            Kind::Number(TOLERANCE),
            "convergence tolerance, relative to the sum of magnitudes of the forces on a body",
        )
        .or(1e-6),
        key("limit", Kind::Count(1, 1000), "largest number of updates in a half-step").or_count(50),
        key(
            "unsettled",
            Kind::Word(&[
                ("stop", "the run ends"),
                ("accept", "the run continues and counts it in `summary.json`"),
            ]),
            "effect of a half-step that has not converged at the limit",
        )
        .or_word("stop"),
    ],
);

/// Rows of `[servers]`.
pub static SERVERS: TableSpec = TableSpec::new(
    "servers",
    "Where the solvers come from, see docs/operation.md; by default the built-in ones are started.",
    &[
        key("fluid_address", Kind::Text(ADDRESS), "address of a fluid server that already listens")
            .or_else("none"),
        key("solid_address", Kind::Text(ADDRESS), "address of a solid server that already listens")
            .or_else("none"),
        key("fluid_command", Kind::Texts(COMMAND), "program and arguments that start a fluid server")
            .or_else("none"),
        key("solid_command", Kind::Texts(COMMAND), "program and arguments that start a solid server")
            .or_else("none"),
        key(
            "ca_file",
            Kind::Text(FILE),
            "certificates (PEM) of the authorities that must have signed those of servers with TLS",
        )
        .or_else("none"),
        key(
            "cert_file",
            Kind::Text(FILE),
            "certificate (PEM) to present to servers; with `key_file` and `ca_file`",
        )
        .or_else("none"),
        key("key_file", Kind::Text(FILE), "private key (PEM) of `cert_file`").or_else("none"),
        key("token_file", Kind::Text(FILE), "text file with the access token of the servers").or_else("none"),
    ],
);

const ADDRESS: &str = "HOST:PORT, such as \"127.0.0.1:7001\", or https://HOST:PORT";
const COMMAND: &str = "a program and its arguments, such as [\"python3\", \"solver.py\"]";
const FILE: &str = "the path of a regular file, from the folder of the case";

/// Way of the half-step frames between the solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FramePath {
    /// From one to the other.
    Direct,
    /// Through the coordinator.
    Relay,
}

/// `[interface]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct InterfaceTable {
    pub law: Choice<InterfaceLaw>,
    /// What the solid sends and receives; left to what the servers offer when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<Choice<CouplingKind>>,
    /// Way of the half-step frames.
    pub path: Choice<FramePath>,
    /// Coefficient of the repulsion by faces of solids; only in the wall laws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repulsion: Option<f64>,
    /// Distance beyond the support radius at which particles are sent to spare, in spacings of the fluid.
    pub margin_spacings: f64,
    /// How half-steps are iterated; not at all when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterate: Option<IterateTable>,
}

/// `iterate` of `[interface]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct IterateTable {
    pub relaxation: RelaxationValue,
    pub tolerance: f64,
    pub limit: u64,
    pub unsettled: Choice<NonConvergence>,
}

/// A factor, or the word for Aitken's.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum RelaxationValue {
    /// A fixed factor.
    Factor(f64),
    /// Aitken's.
    Word(Choice<()>),
}

impl InterfaceTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>, preset: Preset) -> Self {
        const LAWS: [(&str, InterfaceLaw); 3] = [
            ("wall", InterfaceLaw::Wall),
            ("wall-no-slip", InterfaceLaw::WallNoSlip),
            ("plain-sum", InterfaceLaw::PlainSum),
        ];
        const PATHS: [(&str, FramePath); 2] = [("direct", FramePath::Direct), ("relay", FramePath::Relay)];
        let default = if preset == Preset::Paper { InterfaceLaw::PlainSum } else { InterfaceLaw::Wall };
        let law = table.choice_or("law", &LAWS, default);
        let path = table.choice_or_default("path", &PATHS);
        let kind = read_kind(&mut table, law.value);
        let iterate = table.has("iterate").then(|| IterateTable::read(table.table_or_empty("iterate")));
        check_iterated(&table, kind.as_ref(), law.value, iterate.is_some());
        let repels = law.value != InterfaceLaw::PlainSum;
        let read = Self {
            law,
            kind,
            path,
            repulsion: repels.then(|| table.number("repulsion").value),
            margin_spacings: table.number("margin_spacings").value,
            iterate,
        };
        table.finish();
        read
    }
}

/// The kind of coupling, where the case names one.
fn read_kind(table: &mut Table<'_>, law: InterfaceLaw) -> Option<Choice<CouplingKind>> {
    const KINDS: [(&str, CouplingKind); 2] =
        [("states", CouplingKind::States), ("loads", CouplingKind::Loads)];
    let kind = table.optional_choice("kind", &KINDS)?;
    if kind.value == CouplingKind::Loads && law == InterfaceLaw::PlainSum {
        let error = CaseError::new(
            &kind.place,
            "loads do not go with the law `plain-sum`, which needs the stress of the solid",
        );
        table.error(error.hint("use the law `wall` or `wall-no-slip`, or the kind `states`"));
    }
    Some(kind)
}

/// Only loads are iterated.
fn check_iterated(table: &Table<'_>, kind: Option<&Choice<CouplingKind>>, law: InterfaceLaw, iterated: bool) {
    let hint = match kind {
        _ if !iterated => return,
        Some(kind) if kind.value == CouplingKind::States => "use `kind = \"loads\"`, or leave `iterate` out",
        _ if law == InterfaceLaw::PlainSum => "use the law `wall` or `wall-no-slip`, or leave `iterate` out",
        _ => return,
    };
    let error = CaseError::new(&table.place_of("iterate"), "only a coupling by loads is iterated");
    table.error(error.hint(hint));
}

impl IterateTable {
    /// Reads the table.
    fn read(mut table: Table<'_>) -> Self {
        const UNSETTLED: [(&str, NonConvergence); 2] =
            [("stop", NonConvergence::Stop), ("accept", NonConvergence::Accept)];
        let relaxation = table.number_or_word("relaxation", &[("aitken", ())]);
        let read = Self {
            relaxation: relaxation.map_or_else(RelaxationValue::Word, RelaxationValue::Factor),
            tolerance: table.number("tolerance").value,
            limit: table.count("limit").value,
            unsettled: table.choice_or_default("unsettled", &UNSETTLED),
        };
        table.finish();
        read
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> ImplicitCoupling {
        ImplicitCoupling {
            relaxation: match &self.relaxation {
                RelaxationValue::Factor(factor) => Relaxation::Fixed(*factor),
                RelaxationValue::Word(_) => Relaxation::Aitken,
            },
            tolerance: self.tolerance,
            // At most 1000.
            limit: u32::try_from(self.limit).unwrap_or(u32::MAX),
            non_convergence: self.unsettled.value,
        }
    }
}

/// `[servers]`: addresses of running servers or commands that start them; by default the built-in ones.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[allow(missing_docs)]
pub struct ServersTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid_address: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid_command: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid_address: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solid_command: Option<Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ca_file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cert_file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key_file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub token_file: Option<String>,
}

impl ServersTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let read = Self {
            fluid_address: read_address(&mut table, "fluid_address"),
            fluid_command: read_command(&mut table, "fluid_command"),
            solid_address: read_address(&mut table, "solid_address"),
            solid_command: read_command(&mut table, "solid_command"),
            ca_file: read_file_name(&mut table, "ca_file"),
            cert_file: read_file_name(&mut table, "cert_file"),
            key_file: read_file_name(&mut table, "key_file"),
            token_file: read_file_name(&mut table, "token_file"),
        };
        for (given, needed) in
            [("cert_file", "key_file"), ("key_file", "cert_file"), ("cert_file", "ca_file")]
        {
            if table.has(given) && !table.has(needed) {
                let error =
                    CaseError::new(&table.place_of(given), format!("has no effect without `{needed}`"));
                table.error(error.hint("give both, or neither"));
            }
        }
        for (address, command) in [("fluid_address", "fluid_command"), ("solid_address", "solid_command")] {
            if table.has(address) && table.has(command) {
                let error = CaseError::new(&table.place_of(command), format!("`{address}` is given as well"));
                table
                    .error(error.hint("keep the address of a running server or the command that starts one"));
            }
        }
        table.finish();
        read
    }

    /// A table without a word.
    pub fn none() -> Self {
        Self::default()
    }

    /// Files by which servers are known, and by which they know this program.
    pub fn security_files(&self) -> ClientFiles {
        let path = |name: &Option<String>| name.as_ref().map(PathBuf::from);
        ClientFiles {
            authority: path(&self.ca_file),
            identity: path(&self.cert_file).zip(path(&self.key_file)),
            token: path(&self.token_file),
        }
    }

    /// Whether anything is written.
    pub fn is_empty(&self) -> bool {
        *self == Self::none()
    }
}

fn read_address(table: &mut Table<'_>, key: &'static str) -> Option<String> {
    let text = table.optional_text(key)?;
    let schemes = ["http://", "https://"];
    let bare = schemes.iter().find_map(|scheme| text.value.strip_prefix(scheme)).unwrap_or(&text.value);
    let good = bare.rsplit_once(':').is_some_and(|(host, port)| {
        let plain = host.chars().all(|c| c.is_ascii_alphanumeric() || "-._:[]".contains(c));
        !host.is_empty() && plain && port.parse::<u16>().is_ok_and(|port| port > 0)
    });
    if !good {
        let error = CaseError::new(&text.place, "not an address").value(table.written(&text.place));
        table.error(error.allowed(ADDRESS));
    }
    Some(text.value)
}

/// The full path of a file beside the case.
fn read_file_name(table: &mut Table<'_>, key: &'static str) -> Option<String> {
    let name = table.optional_text(key)?;
    let path = absolute(table.directory, &name.value);
    if !Path::new(&path).is_file() {
        let what = if Path::new(&path).exists() { "is not a regular file" } else { "no such file" };
        let error = CaseError::new(&name.place, what).value(table.written(&name.place));
        table.error(error.allowed(FILE));
    }
    Some(path)
}

/// A command line; a word that names a file of the case's folder becomes its full path.
fn read_command(table: &mut Table<'_>, key: &'static str) -> Option<Vec<String>> {
    let words = table.optional_texts(key)?;
    if words.value.first().is_none_or(String::is_empty) {
        let error = CaseError::new(&words.place, "names no program").value(table.written(&words.place));
        table.error(error.allowed(COMMAND));
    }
    Some(words.value.iter().map(|word| absolute(table.directory, word)).collect())
}

/// The full path of `word` when it names a file in `directory`, otherwise `word`.
fn absolute(directory: &Path, word: &str) -> String {
    let path = directory.join(word);
    if word.is_empty() || !path.is_file() {
        return word.to_owned();
    }
    std::path::absolute(&path)
        .ok()
        .and_then(|path| path.to_str().map(str::to_owned))
        .unwrap_or_else(|| word.to_owned())
}
