//! `manifest.json`: what a checkpoint belongs to, and the digest of each of its files.

use proto::checkpoint::{CheckpointData, CheckpointHeader};
use proto::hex::hex;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use sph::coupling::solver::Role;

use super::RunCheckpoint;

/// Version of the layout of checkpoints. No other is read.
const FORMAT: u32 = 12;

/// A manifest. Times stand twice: to be read, and by their bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the layout.
    pub format: u32,
    /// SHA-256 of the case as far as it decides the bits of a run.
    pub case_digest: String,
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time_s: f64,
    /// Its bits, as hex.
    pub time_s_bits: String,
    /// Program that wrote it.
    pub coordinator: String,
    /// The solvers.
    pub sides: Vec<Side>,
    /// What the coordinator continues from.
    pub outputs: FileFacts,
    /// SHA-256 of this manifest with an empty text here.
    pub digest: String,
}

/// One solver's share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Side {
    /// Side.
    pub role: Role,
    /// Layout of its data.
    pub format: String,
    /// Name of the program.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Its build.
    pub build: String,
    /// How it sums.
    pub arithmetic: String,
    /// Bits of the size of its next step, as hex.
    pub next_time_step_s_bits: String,
    /// Its data.
    pub data: FileFacts,
}

/// Size and digest of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileFacts {
    /// Name in the checkpoint's folder.
    pub file: String,
    /// Size.
    pub bytes: u64,
    /// SHA-256, as hex.
    pub sha256: String,
}

/// SHA-256 of `data`, as hex.
pub(super) fn digest(data: &[u8]) -> String {
    hex(&Sha256::digest(data))
}

fn bits(number: f64) -> String {
    format!("{:016x}", number.to_bits())
}

fn number(bits: &str) -> Result<f64, String> {
    let parsed = u64::from_str_radix(bits, 16).map_err(|_| format!("`{bits}` are no bits of a number"))?;
    Ok(f64::from_bits(parsed))
}

impl FileFacts {
    pub(super) fn of(file: &str, data: &[u8]) -> Self {
        Self { file: file.to_owned(), bytes: data.len() as u64, sha256: digest(data) }
    }
}

/// Name of the data of `role`.
pub(super) fn data_file(role: Role) -> String {
    format!("{role}.bin")
}

/// The manifest in `text` with the digest that belongs to its content, for tests of its content.
///
/// # Errors
/// When `text` is no manifest.
pub fn seal(text: &str) -> Result<String, String> {
    let manifest: Manifest = serde_json::from_str(text).map_err(|e| e.to_string())?;
    let time_s = number(&manifest.time_s_bits)?;
    let mut bare = Manifest { digest: String::new(), time_s, ..manifest };
    bare.digest = digest(bare.text().as_bytes());
    Ok(bare.text())
}

impl Manifest {
    pub(super) fn of(checkpoint: &RunCheckpoint, outputs: FileFacts) -> Self {
        let side = |data: &CheckpointData| {
            let header = &data.header;
            Side {
                role: header.role,
                format: header.format.clone(),
                name: header.name.clone(),
                version: header.version.clone(),
                build: header.build.clone(),
                arithmetic: header.arithmetic.clone(),
                next_time_step_s_bits: bits(header.next_time_step),
                data: FileFacts {
                    file: data_file(header.role),
                    bytes: data.data.len() as u64,
                    sha256: hex(&data.sha256),
                },
            }
        };
        let mut manifest = Self {
            format: FORMAT,
            case_digest: digest(checkpoint.outputs.case.as_bytes()),
            step: checkpoint.step,
            time_s: checkpoint.time,
            time_s_bits: bits(checkpoint.time),
            coordinator: format!("coordinator {}", env!("CARGO_PKG_VERSION")),
            sides: checkpoint.sides.iter().map(side).collect(),
            outputs,
            digest: String::new(),
        };
        manifest.digest = digest(manifest.text().as_bytes());
        manifest
    }

    pub(super) fn text(&self) -> String {
        // The struct holds numbers, texts and lists only: JSON can say all of them.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// A manifest from its text.
    ///
    /// # Errors
    /// When it is of another format, or damaged.
    pub fn parse(text: &str) -> Result<Self, String> {
        /// What every format has.
        #[derive(Deserialize)]
        struct Head {
            format: u32,
        }
        let head: Head = serde_json::from_str(text).map_err(|e| format!("is no manifest: {e}"))?;
        if head.format != FORMAT {
            return Err(format!(
                "is of format {}, this build of the coordinator reads format {FORMAT}; continue with the build that wrote it",
                head.format
            ));
        }
        let manifest: Self = serde_json::from_str(text).map_err(|e| format!("is no manifest: {e}"))?;
        let bare = Self { digest: String::new(), time_s: number(&manifest.time_s_bits)?, ..manifest.clone() };
        if digest(bare.text().as_bytes()) != manifest.digest {
            return Err("is damaged: its digest does not fit its content".into());
        }
        Ok(bare)
    }

    /// What the data of `side` belong to.
    pub(super) fn header(&self, side: &Side) -> Result<CheckpointHeader, String> {
        Ok(CheckpointHeader {
            format: side.format.clone(),
            name: side.name.clone(),
            version: side.version.clone(),
            build: side.build.clone(),
            arithmetic: side.arithmetic.clone(),
            role: side.role,
            step: self.step,
            time: self.time_s,
            next_time_step: number(&side.next_time_step_s_bits)?,
        })
    }
}
