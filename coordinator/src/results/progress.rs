//! Progress of a run: a bar on a terminal, lines elsewhere.

use std::fmt::Display;
use std::io::IsTerminal;
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sph::setup::TimePlan;

use super::tally::Tally;
use crate::messages::Messages;
use crate::page::live::Live;

/// Parts of the bar; finer than any terminal is wide.
const PARTS: u64 = 10_000;
/// Time between lines where no bar can be drawn.
const BETWEEN_LINES: Duration = Duration::from_secs(10);
/// Time between looks at the clock of the bar.
const BETWEEN_DRAWS: Duration = Duration::from_millis(100);

/// Shows how far a run is.
pub struct Progress {
    plan: TimePlan,
    kind: Kind,
    messages: Messages,
    started: Instant,
    shown: Instant,
    live: Option<Arc<Live>>,
}

enum Kind {
    Bar(ProgressBar),
    Lines,
    Silent,
}

impl Progress {
    /// Progress through the times of `plan`.
    pub fn new(plan: TimePlan, messages: Messages) -> Self {
        let kind = if messages < Messages::All {
            Kind::Silent
        } else if std::io::stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  left {eta}");
            if let Ok(style) = style {
                bar.set_style(style);
            }
            Kind::Bar(bar)
        } else {
            Kind::Lines
        };
        let now = Instant::now();
        Self { plan, kind, messages, started: now, shown: now, live: None }
    }

    /// Also tells the page of the run.
    pub fn with_live(self, live: Option<Arc<Live>>) -> Self {
        Self { live, ..self }
    }

    /// Prints a warning.
    pub fn warning(&self, text: impl Display) {
        self.messages.warning(text);
    }

    /// Takes the figures after a step.
    pub fn step(&mut self, tally: &Tally) {
        if let Some(live) = &self.live {
            live.step(tally.steps, tally.time, tally.breaches);
        }
        let between = match self.kind {
            Kind::Bar(_) => BETWEEN_DRAWS,
            Kind::Lines => BETWEEN_LINES,
            Kind::Silent => return,
        };
        if self.shown.elapsed() < between {
            return;
        }
        self.shown = Instant::now();
        let span = (self.plan.end_time - self.plan.start_time).max(f64::MIN_POSITIVE);
        let share = ((tally.time - self.plan.start_time) / span).clamp(0.0, 1.0);
        let elapsed = self.started.elapsed().as_secs_f64();
        let step = tally.step_sizes.map_or(0.0, |sizes| sizes.smallest_s);
        let text = format!(
            "t = {:.4} of {:.4} s, step {} (smallest {step:.2e} s)",
            tally.time, self.plan.end_time, tally.steps
        );
        match &self.kind {
            Kind::Bar(bar) => {
                // A share of PARTS is exact enough and positive.
                bar.set_position((share * PARTS as f64) as u64);
                bar.set_message(text);
            }
            Kind::Lines => {
                let left = if share > 0.0 { elapsed * (1.0 - share) / share } else { f64::INFINITY };
                terminal::note(format_args!(
                    "{:3.0} %  {text}, {elapsed:.0} s gone, {left:.0} s left",
                    100.0 * share
                ));
            }
            Kind::Silent => {}
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Kind::Bar(bar) = &self.kind {
            bar.finish_and_clear();
        }
    }
}
