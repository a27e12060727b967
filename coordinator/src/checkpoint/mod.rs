//! Checkpoints of a run: both sides and the outputs at one step boundary, under one manifest.
//!
//! | file in `checkpoints/step_<n>/` | content |
//! |---|---|
//! | `manifest.json` | what the checkpoint belongs to, and the size and digest of each file |
//! | `fluid.bin`, `solid.bin` | what the solver of that side saved; only the solver reads it |
//! | `coordinator.bin` | sums, lengths and digests of tables, names of snapshots, and the case |

mod disk;
mod manifest;
mod store;

pub use disk::{Disk, Files};
pub use manifest::{Manifest, seal};
pub use store::{NewestCheckpoint, Store, Written};

use proto::checkpoint::CheckpointData;
use serde::{Deserialize, Serialize};

use crate::results::recorder::RecorderState;

/// Digests of the states of fluid and solid from which a run started, where its case names such.
pub type OriginDigests = [Option<String>; 2];

/// A checkpoint of a whole run.
#[derive(Clone, Debug)]
pub struct RunCheckpoint {
    /// Completed steps.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// The fluid and the solid, as far as they take part.
    pub sides: Vec<CheckpointData>,
    /// Outputs and sums.
    pub outputs: OutputState,
}

/// What the coordinator itself continues from.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct OutputState {
    /// The case, as `Case::identity` gives it.
    pub case: String,
    /// Tables, snapshots, sums.
    pub recorder: RecorderState,
    /// Wall time of the run so far \[s\].
    pub wall_seconds: f64,
    /// Digests of the fluid's and the solid's state that the run started from, where it did.
    pub origin: OriginDigests,
}

impl OutputState {
    /// What `bytes` hold.
    ///
    /// # Errors
    /// When they are of another layout.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        postcard::from_bytes(bytes).map_err(|e| e.to_string())
    }

    /// These as bytes.
    ///
    /// # Errors
    /// Never, as far as is known: all of it has a layout.
    pub fn to_bytes(&self) -> Result<Vec<u8>, String> {
        postcard::to_stdvec(self).map_err(|e| e.to_string())
    }
}

impl RunCheckpoint {
    /// How its case differs from `case`: the first line that does.
    pub fn case_difference(&self, case: &str) -> Option<String> {
        let saved = &self.outputs.case;
        if saved == case {
            return None;
        }
        let end = "(the end of the case)";
        let (mut then, mut now) = (saved.lines(), case.lines());
        let mut table = String::new();
        loop {
            let (a, b) = (then.next(), now.next());
            if a != b {
                let (a, b) = (a.unwrap_or(end), b.unwrap_or(end));
                return Some(format!("in {table}: `{a}` in the checkpoint, `{b}` in the case"));
            }
            match a {
                Some(line) if line.starts_with('[') => line.clone_into(&mut table),
                Some(_) => {}
                None => return Some("in its line ends".into()),
            }
        }
    }
}
