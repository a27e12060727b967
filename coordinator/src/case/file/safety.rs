//! Checkpoints and deadlines as a case file writes them.

use serde::Serialize;

use crate::case::reader::{Allowed, Table};

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
    /// Default of `every_wall_s`: what a killed run loses at most.
    const DEFAULT_WALL: f64 = 300.0;
    /// Default of `max_restarts`: a server that keeps dying has a reason.
    const DEFAULT_RESTARTS: u64 = 3;

    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        const WALL: Allowed = Allowed::new(0.0, 1e9, (false, true), "a number above 0 and at most 1e9");
        let read = Self {
            every_steps: table.optional_count("every_steps", 1..1_000_000_000),
            every_wall_s: table.number_or("every_wall_s", &WALL, Self::DEFAULT_WALL).value,
            max_restarts: table.count_or("max_restarts", 0..1001, Self::DEFAULT_RESTARTS).value,
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
        // Servers give a sign of life each second: less than a few of them is no silence.
        const SILENCE: Allowed = Allowed::new(3.0, 1e6, (true, true), "a number from 3 to 1e6");
        const WAIT: Allowed = Allowed::new(1.0, 1e6, (true, true), "a number from 1 to 1e6");
        let read = Self {
            silence_s: table.number_or("silence_s", &SILENCE, 20.0).value,
            call_s: table.number_or("call_s", &WAIT, 30.0).value,
            open_s: table.number_or("open_s", &WAIT, 300.0).value,
            step_s: table.number_or("step_s", &WAIT, 60.0).value,
            disk_s: table.number_or("disk_s", &WAIT, 60.0).value,
        };
        table.finish();
        read
    }
}
