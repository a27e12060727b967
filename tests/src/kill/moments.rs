//! The moments at which processes are killed.

use super::Victim;

/// When a kill comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// At a random time of this part of the run, in percent, from its first frame on.
    Part(u32),
    /// At a random time up to so many milliseconds after the process was started, or after the last kill.
    Within(u32),
    /// As soon as a checkpoint is half written.
    HalfCheckpoint,
    /// As soon as this file is there, or half written; `LAST` stands for the last step.
    Begun(&'static str),
    /// As soon as this file is there.
    Complete(&'static str),
}

/// One kill of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// When.
    pub aim: Aim,
    /// Who, if not the victim of the trial.
    pub victim: Option<Victim>,
}

/// A kind of trial.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// In words.
    pub name: &'static str,
    /// Victims, in turn.
    pub victims: &'static [Victim],
    /// Kills of a trial, in order.
    pub hits: &'static [Hit],
    /// Whether the frames are recorded.
    pub record: bool,
}

const fn at(aim: Aim) -> Hit {
    Hit { aim, victim: None }
}

const fn of(victim: Victim, aim: Aim) -> Hit {
    Hit { aim, victim: Some(victim) }
}

const fn moment(name: &'static str, victims: &'static [Victim], hits: &'static [Hit]) -> Moment {
    Moment { name, victims, hits, record: false }
}

const fn end(name: &'static str, hits: &'static [Hit]) -> Moment {
    moment(name, &[Victim::Coordinator], hits)
}

const ANYTIME: Aim = Aim::Part(100);

const EACH: &[Victim] = &Victim::EACH;

/// All kinds of trials.
pub const MOMENTS: [Moment; 14] = [
    moment("at a random time", EACH, &[at(ANYTIME)]),
    moment("0 to 80 ms after the start", EACH, &[at(Aim::Within(80))]),
    moment("while a checkpoint is written", EACH, &[at(Aim::HalfCheckpoint)]),
    moment("0 to 80 ms into a resume", EACH, &[of(Victim::Coordinator, Aim::Part(60)), at(Aim::Within(80))]),
    moment("twice in a row", EACH, &[at(Aim::Part(40)), at(Aim::Part(40))]),
    moment(
        "one server after the other",
        &[Victim::Fluid, Victim::Solid],
        &[of(Victim::Solid, Aim::Part(60)), at(Aim::Within(30)), of(Victim::Fluid, Aim::Within(30))],
    ),
    moment(
        "all, then the resume while it writes a checkpoint",
        &[Victim::Coordinator, Victim::All],
        &[of(Victim::All, Aim::Part(40)), at(Aim::HalfCheckpoint)],
    ),
    Moment { record: true, ..moment("with frames recorded", EACH, &[at(ANYTIME)]) },
    end("end: last snapshot and collection", &[at(Aim::Begun("snapshots/fluid_LAST.vtp"))]),
    end("end: final states", &[at(Aim::Begun("final/fluid.state"))]),
    end("end: last checkpoint", &[at(Aim::Begun("checkpoints/step_LAST"))]),
    end("end: tables", &[at(Aim::Complete("probes.csv"))]),
    end("end: summary", &[at(Aim::Begun("summary.json"))]),
    end("end: report", &[at(Aim::Begun("report.html"))]),
];
