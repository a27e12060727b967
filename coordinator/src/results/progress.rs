//! Progress of a run: a bar on a terminal, lines elsewhere.

use std::fmt::Display;
use std::io::IsTerminal;
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use sph::coupling::driver::ProbeValues;
use sph::coupling::ledger::EnergyAccount;
use sph::coupling::solver::Role;
use sph::setup::TimePlan;

use super::matched_step::MatchedStep;
use super::tally::Tally;
use crate::case::Case;
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
    /// Share of the plan at the first step that this process made.
    began: Option<f64>,
    shown: Instant,
    live: Option<Arc<Live>>,
    watched: Watched,
}

enum Kind {
    Bar(ProgressBar),
    Lines,
    Silent,
}

/// The physics beside the bar.
#[derive(Clone, Debug, Default)]
struct Watched {
    /// Unit of energies.
    energy_unit: &'static str,
    /// Kinetic energy of all sides.
    kinetic: f64,
    /// Side and name of the first column of the probes; those of a solid tell more.
    column: Option<(Role, String)>,
    /// Its last value.
    value: Option<f64>,
}

impl Watched {
    fn of(case: &Case) -> Self {
        let [fluid, solid] = case.probe_columns();
        let first = |role, columns: Vec<String>| columns.into_iter().next().map(|name| (role, name));
        Self {
            energy_unit: if case.dimensions() == 2 { "J/m" } else { "J" },
            column: first(Role::Solid, solid).or_else(|| first(Role::Fluid, fluid)),
            ..Self::default()
        }
    }

    /// Energy and, where `room` characters hold it as well, the probe.
    fn text(&self, room: usize) -> String {
        let mut text = format!("kinetic {:.2e} {}", self.kinetic, self.energy_unit);
        if let (Some((_, name)), Some(value)) = (&self.column, self.value) {
            let probe = format!(", {} {value:.2e}", crate::quote::clean(name));
            if text.chars().count() + probe.chars().count() <= room {
                text.push_str(&probe);
            }
        }
        text
    }
}

/// The bar; what does not fit beside it is cut off at the edge of the terminal.
const BAR: &str = "{bar:10} {percent:>3} %  {wide_msg}";

/// Columns before the message of the bar.
const BEFORE_MESSAGE: usize = 18;

impl Progress {
    /// Progress of a run of `case`.
    pub fn new(case: &Case, messages: Messages) -> Self {
        let errors = std::io::stderr();
        let is_dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
        let kind = if messages < Messages::All {
            Kind::Silent
        } else if errors.is_terminal() && !is_dumb {
            let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template(BAR) {
                bar.set_style(style);
            }
            Kind::Bar(bar)
        } else {
            Kind::Lines
        };
        let now = Instant::now();
        Self {
            plan: case.run_plan().time,
            kind,
            messages,
            started: now,
            began: None,
            shown: now,
            live: None,
            watched: Watched::of(case),
        }
    }

    /// Also tells the page of the run.
    pub fn with_live(self, live: Option<Arc<Live>>) -> Self {
        Self { live, ..self }
    }

    /// Prints a warning.
    pub fn warning(&self, text: impl Display) {
        self.messages.warning(text);
    }

    /// Takes probe values of `role`.
    pub fn probes(&mut self, role: Role, values: &ProbeValues) {
        if self.watched.column.as_ref().is_some_and(|(side, _)| *side == role) {
            self.watched.value = values.values.first().copied();
        }
    }

    /// Takes the figures after `step`.
    pub fn step(&mut self, tally: &Tally, step: &MatchedStep) {
        if let Some(live) = &self.live {
            live.step(tally.steps, tally.time, tally.breaches);
        }
        let between = match self.kind {
            Kind::Bar(_) => BETWEEN_DRAWS,
            Kind::Lines => BETWEEN_LINES,
            Kind::Silent => return,
        };
        let span = (self.plan.end_time - self.plan.start_time).max(f64::MIN_POSITIVE);
        let share = ((tally.time - self.plan.start_time) / span).clamp(0.0, 1.0);
        let began = *self.began.get_or_insert(share);
        if self.shown.elapsed() < between {
            return;
        }
        self.shown = Instant::now();
        let sides = [&step.fluid, &step.solid].into_iter().flatten();
        self.watched.kinetic = sides
            .filter_map(|report| report.energies.get(EnergyAccount::Kinetic))
            .map(|entry| entry.value)
            .sum();
        let left = left(self.started.elapsed(), share - began, 1.0 - share);
        let time = format!("t = {:.4} of {} s", tally.time, self.plan.end_time);
        match &self.kind {
            Kind::Bar(bar) => {
                // A share of PARTS is exact enough and positive.
                bar.set_position((share * PARTS as f64) as u64);
                let message = format!("{left} left  {time}  ");
                let width = terminal::lines::errors_width().unwrap_or(0);
                let room = width.saturating_sub(BEFORE_MESSAGE + message.chars().count());
                bar.set_message(message + &self.watched.text(room));
            }
            Kind::Lines => {
                let (percent, physics) = (100.0 * share, self.watched.text(usize::MAX));
                terminal::note(format_args!(
                    "{percent:3.0} %  {time}, step {}, {left} left, {physics}",
                    tally.steps
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

/// Time left, in words, when the share `done` took `elapsed` and `open` remains.
fn left(elapsed: Duration, done: f64, open: f64) -> String {
    if done <= 0.0 {
        return "?".to_owned();
    }
    // Rounded, and far below 2^64.
    let seconds = (elapsed.as_secs_f64() * open / done).round() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{}:{:02} min", seconds / 60, seconds % 60),
        _ => format!("{}:{:02} h", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_follows_from_what_this_process_has_done() {
        let after = |seconds| Duration::from_secs(seconds);
        assert_eq!(left(after(10), 0.5, 0.5), "10 s");
        // A run that continues at 80 % and has done 10 % since.
        assert_eq!(left(after(75), 0.1, 0.1), "1:15 min");
        assert_eq!(left(after(36), 0.01, 0.99), "59:24 min");
        assert_eq!(left(after(360), 0.01, 0.99), "9:54 h");
        assert_eq!(left(after(1), 0.0, 1.0), "?");
    }

    #[test]
    fn the_physics_beside_the_bar_are_a_probe_and_the_energy() {
        let mut watched = Watched { energy_unit: "J/m", kinetic: 12.34, ..Watched::default() };
        assert_eq!(watched.text(80), "kinetic 1.23e1 J/m");
        watched.column = Some((Role::Solid, "tip_x_m".to_owned()));
        watched.value = Some(0.0191);
        assert_eq!(watched.text(80), "kinetic 1.23e1 J/m, tip_x_m 1.91e-2");
        assert_eq!(watched.text(30), "kinetic 1.23e1 J/m");
    }
}
