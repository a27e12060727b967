//! What a run in this process says of itself to its page while it runs: cheap to write, read by the page's own thread.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::run::{FactTable, Facts};

/// State of a run, written by the run and read by its page.
#[derive(Debug)]
pub struct Live {
    now: Mutex<Now>,
}

/// How far the run is.
#[derive(Clone, Debug)]
pub struct Now {
    /// What is happening, in words.
    pub doing: String,
    /// Completed steps.
    pub steps: u64,
    /// Simulated time \[s\]; `None` before the first step.
    pub time: Option<f64>,
    /// Time at the first step that this process made \[s\], and when that was.
    pub began: Option<(f64, Instant)>,
    /// When the run was started.
    pub started: Instant,
    /// Breaches of the ledger.
    pub breaches: u64,
    /// Limits of the time step, in words.
    pub limits: String,
    /// What was agreed before the run.
    pub agreed: Facts,
}

impl Default for Live {
    fn default() -> Self {
        let now = Now {
            doing: "starting the solvers".into(),
            steps: 0,
            time: None,
            began: None,
            started: Instant::now(),
            breaches: 0,
            limits: String::new(),
            agreed: Facts::new(),
        };
        Self { now: Mutex::new(now) }
    }
}

impl Live {
    /// The state now.
    pub fn now(&self) -> Now {
        self.now.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What is happening, in words.
    pub fn doing(&self, words: &str) {
        self.change(|now| words.clone_into(&mut now.doing));
    }

    /// A completed step: how many there are, the time \[s\] and the breaches of the ledger so far.
    pub fn step(&self, steps: u64, time: f64, breaches: u64) {
        self.change(|now| {
            if now.began.is_none() {
                now.began = Some((time, Instant::now()));
                "computing".clone_into(&mut now.doing);
            }
            (now.steps, now.time, now.breaches) = (steps, Some(time), breaches);
        });
    }

    /// What the solvers agreed on, and the limits of the time step, before the first step.
    pub fn agreed(&self, facts: &Facts, limits: String) {
        self.change(|now| {
            now.agreed.clone_from(facts);
            now.limits = limits;
        });
    }

    fn change(&self, change: impl FnOnce(&mut Now)) {
        change(&mut self.now.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Now {
    /// The facts as a table of the page.
    pub fn tables(&self) -> Vec<FactTable> {
        let rows = self.agreed.clone();
        vec![FactTable { id: "negotiated", headline: "Agreed before the run", rows }]
    }
}
