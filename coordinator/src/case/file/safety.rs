//! Checkpoints and deadlines as a case file writes them.

use serde::Serialize;

use crate::case::reader::{Allowed, Table};
use crate::case::spec::{Kind, TableSpec, key};

const WALL: Allowed = Allowed::new(0.0, 1e9, (false, true), "a number above 0 and at most 1e9");
// Servers give a sign of life each second: less than a few of them is no silence.
const SILENCE: Allowed = Allowed::new(3.0, 1e6, (true, true), "a number from 3 to 1e6");
const WAIT: Allowed = Allowed::new(1.0, 1e6, (true, true), "a number from 1 to 1e6");

/// Rows of `[checkpoint]`.
pub static CHECKPOINT: TableSpec = TableSpec::new(
    "checkpoint",
    "States from which an interrupted run continues, see docs/operation.md.",
    &[
        key("every_steps", Kind::Count(1, 999_999_999), "steps between checkpoints").or_else("off"),
        // What a killed run loses at most.
        key("every_wall_s", Kind::Number(WALL), "wall time between checkpoints").or(300.0),
        // A server that keeps dying has a reason.
        key("max_restarts", Kind::Count(0, 1000), "largest number of restarts of lost servers").or_count(3),
    ],
);

/// Rows of `[deadlines]`.
pub static DEADLINES: TableSpec = TableSpec::new(
    "deadlines",
    "Longest waits, after which a server counts as lost, see docs/operation.md.",
    &[
        key("silence_s", Kind::Number(SILENCE), "longest wait for a sign of life of a server").or(20.0),
        key("call_s", Kind::Number(WAIT), "longest wait for an answer of a server").or(30.0),
        key("open_s", Kind::Number(WAIT), "longest wait for a server's set-up").or(300.0),
        key("step_s", Kind::Number(WAIT), "shortest deadline of a step").or(60.0),
        key("disk_s", Kind::Number(WAIT), "longest wait for the disk to take outputs").or(60.0),
    ],
);

/// `[checkpoint]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // As for all tables here: the keys name quantity and unit.
pub struct CheckpointTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every_steps: Option<u64>,
    pub every_wall_s: f64,
    /// Times that servers are started again after one was lost.
    pub max_restarts: u64,
}

impl CheckpointTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let read = Self {
            every_steps: table.optional_count("every_steps"),
            every_wall_s: table.number("every_wall_s").value,
            max_restarts: table.count("max_restarts").value,
        };
        table.finish();
        read
    }
}

/// `[deadlines]`: longest waits for a server, see docs/operation.md.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct DeadlinesTable {
    pub silence_s: f64,
    pub call_s: f64,
    pub open_s: f64,
    /// Least deadline of a step.
    pub step_s: f64,
    /// Longest wait for the disk to take outputs.
    pub disk_s: f64,
}

impl DeadlinesTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let read = Self {
            silence_s: table.number("silence_s").value,
            call_s: table.number("call_s").value,
            open_s: table.number("open_s").value,
            step_s: table.number("step_s").value,
            disk_s: table.number("disk_s").value,
        };
        table.finish();
        read
    }
}
