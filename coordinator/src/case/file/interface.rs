//! Interface law and servers as a case file writes them.

use std::path::{Path, PathBuf};

use proto::transport::security::ClientFiles;
use serde::Serialize;
use sph::setup::{CouplingKind, ImplicitCoupling, InterfaceLaw, NonConvergence, Relaxation};

use super::Preset;
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, Choice, Table};

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
        const MARGIN: Allowed = Allowed::new(0.0, 20.0, (false, true), "a number above 0 and at most 20");
        const PATHS: [(&str, FramePath); 2] = [("direct", FramePath::Direct), ("relay", FramePath::Relay)];
        let default = if preset == Preset::Paper { InterfaceLaw::PlainSum } else { InterfaceLaw::Wall };
        let law = table.choice_or("law", &LAWS, default);
        let path = table.choice_or_first("path", &PATHS);
        let kind = read_kind(&mut table, law.value);
        let iterate = table.has("iterate").then(|| IterateTable::read(table.table_or_empty("iterate")));
        check_iterated(&table, kind.as_ref(), law.value, iterate.is_some());
        let repels = law.value != InterfaceLaw::PlainSum;
        let read = Self {
            law,
            kind,
            path,
            repulsion: repels.then(|| table.number_or("repulsion", &Allowed::NOT_NEGATIVE, 1.0).value),
            margin_spacings: table.number_or("margin_spacings", &MARGIN, 1.0).value,
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
        const TOLERANCE: Allowed = Allowed::new(0.0, 1.0, (false, false), "a number above 0 and below 1");
        let relaxation = table.number_or_word("relaxation", &Allowed::FRACTION, &[("aitken", ())]);
        let read = Self {
            relaxation: relaxation.map_or_else(RelaxationValue::Word, RelaxationValue::Factor),
            tolerance: table.number_or("tolerance", &TOLERANCE, 1e-6).value,
            limit: table.count_or("limit", 1..1001, 50).value,
            unsettled: table.choice_or_first("unsettled", &UNSETTLED),
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
        table.error(error.allowed("HOST:PORT, such as \"127.0.0.1:7001\", or https://HOST:PORT"));
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
        table.error(error.allowed("the path of a regular file, from the folder of the case"));
    }
    Some(path)
}

/// A command line; a word that names a file of the case's folder becomes its full path.
fn read_command(table: &mut Table<'_>, key: &'static str) -> Option<Vec<String>> {
    let words = table.optional_texts(key)?;
    if words.value.first().is_none_or(String::is_empty) {
        let error = CaseError::new(&words.place, "names no program").value(table.written(&words.place));
        table.error(error.allowed("a program and its arguments, such as [\"python3\", \"solver.py\"]"));
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
