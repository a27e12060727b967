//! Domain, forces, time, outputs, ledger and servers as a case file writes them.

use serde::Serialize;
use sph::setup::{BreachAction, LedgerPolicy, Motion, Outflow, OutputPlan, StepPolicy, TimePlan};
use sph::space::domain::Domain;
use sph::space::{DIMENSIONS, Vector};

use super::formula;
use crate::case::errors::{CaseError, Place};
use crate::case::reader::{Allowed, At, Choice, Table, Written};

/// Names of the axes in lists of directions.
pub const AXES: [(&str, usize); DIMENSIONS] = [("x", 0), ("y", 1)];

/// A side of a box: axis, and whether it is the upper one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// Axis.
    pub axis: usize,
    /// The upper side along the axis.
    pub upper: bool,
}

/// Names of the sides of a box.
pub const SIDES: [(&str, Side); 2 * DIMENSIONS] = [
    ("left", Side { axis: 0, upper: false }),
    ("right", Side { axis: 0, upper: true }),
    ("bottom", Side { axis: 1, upper: false }),
    ("top", Side { axis: 1, upper: true }),
];

/// `[domain]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // As for all tables here: the keys name quantity and unit.
pub struct DomainTable {
    pub lower_m: At<Vector>,
    pub upper_m: At<Vector>,
    pub periodic: Vec<Choice<usize>>,
    /// Corner of the one lattice on which all particles of the scene are laid.
    pub lattice_origin_m: Vector,
    /// Sides through which particles may leave; by default the open sides of containers that fill the domain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outflow_sides: Option<Vec<Choice<Side>>>,
    #[serde(skip)]
    pub intact: bool,
}

impl DomainTable {
    /// What stands in for a table that is missing; nothing is built from it.
    pub fn unwritten(place: &Place) -> Self {
        let corner = |value| At { value: Vector::repeat(value), place: place.clone() };
        Self {
            lower_m: corner(0.0),
            upper_m: corner(1.0),
            periodic: Vec::new(),
            lattice_origin_m: Vector::zeros(),
            outflow_sides: None,
            intact: false,
        }
    }

    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let lower_m = table.vector("lower_m");
        let upper_m = table.vector("upper_m");
        if table.intact() && !(lower_m.value.x < upper_m.value.x && lower_m.value.y < upper_m.value.y) {
            let error = CaseError::new(&upper_m.place, "does not lie above and to the right of `lower_m`");
            table.error(error.value(table.written(&upper_m.place)));
        }
        let periodic = table.words("periodic", &AXES).unwrap_or_default();
        let outflow_sides = table.words("outflow_sides", &SIDES);
        for side in outflow_sides.iter().flatten() {
            if periodic.iter().any(|axis| axis.value == side.value.axis) {
                table.error(CaseError::new(&side.place, "lies across a periodic direction").value(side.word));
            }
        }
        let lattice_origin_m = table.vector_or("lattice_origin_m", lower_m.value).value;
        Self { lower_m, upper_m, periodic, lattice_origin_m, outflow_sides, intact: table.finish() }
    }

    /// The box of the scene.
    pub fn domain(&self) -> Domain {
        let periodic = std::array::from_fn(|axis| self.periodic.iter().any(|choice| choice.value == axis));
        Domain { lower: self.lower_m.value, upper: self.upper_m.value, periodic }
    }

    /// Sides through which particles may leave.
    pub fn outflow(&self) -> Outflow {
        let sides = || self.outflow_sides.iter().flatten().map(|choice| choice.value);
        let open = |upper| std::array::from_fn(|axis| sides().any(|side| side == Side { axis, upper }));
        Outflow { lower: open(false), upper: open(true) }
    }
}

/// `[body_force]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct BodyForceTable {
    pub gravity_m_s2: Vector,
    /// Expressions of x, y, t added to gravity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_m_s2: Option<[At<Written>; 2]>,
}

impl BodyForceTable {
    /// Reads the table; left out, nothing pulls.
    pub fn read(mut table: Table<'_>) -> Self {
        let gravity_m_s2 = table.vector_or("gravity_m_s2", Vector::zeros()).value;
        let acceleration_m_s2 = formula::read_pair(&mut table, "acceleration_m_s2", &["x", "y", "t"]);
        table.finish();
        Self { gravity_m_s2, acceleration_m_s2 }
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> sph::setup::BodyForce {
        let expressions =
            self.acceleration_m_s2.as_ref().map(|pair| pair.each_ref().map(|written| written.value.text()));
        sph::setup::BodyForce { gravity: self.gravity_m_s2, expressions }
    }
}

/// `[time]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct TimeTable {
    pub start_time_s: f64,
    pub end_time_s: At<f64>,
    pub step: StepTable,
    /// A fixed step, or the factor of an adaptive one, may reach this fraction of the stability limit.
    pub limit_factor: At<f64>,
    #[serde(skip)]
    pub intact: bool,
}

/// `[time.step]`.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum StepTable {
    Fixed { time_step_s: At<f64> },
    Adaptive { factor: At<f64>, maximum_s: f64, growth: f64 },
}

#[derive(Clone, Copy)]
enum StepKind {
    Fixed,
    Adaptive,
}

impl TimeTable {
    /// Default of `time.step.factor`: half of the stated limit.
    const DEFAULT_FACTOR: f64 = 0.5;
    /// Default of `time.step.growth`.
    const DEFAULT_GROWTH: f64 = 1.05;

    /// What stands in for a table that is missing; nothing is built from it.
    pub fn unwritten(place: &Place) -> Self {
        let one = At { value: 1.0, place: place.clone() };
        let step = StepTable::Fixed { time_step_s: one.clone() };
        Self { start_time_s: 0.0, end_time_s: one.clone(), step, limit_factor: one, intact: false }
    }

    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        const GROWTH: Allowed = Allowed::new(1.0, 2.0, (false, true), "a number above 1 and at most 2");
        const LIMIT: Allowed = Allowed::new(0.0, 10.0, (false, true), "a number above 0 and at most 10");
        let start_time_s = table.number_or("start_time_s", &Allowed::FINITE, 0.0).value;
        let end_time_s = table.number("end_time_s", &Allowed::FINITE);
        if table.intact() && end_time_s.value < start_time_s {
            let error = CaseError::new(&end_time_s.place, "lies before the start").value(end_time_s.value);
            table.error(error.allowed(format!("a time of {start_time_s} s or later")));
        }
        let span = (end_time_s.value - start_time_s).max(f64::MIN_POSITIVE);
        let limit_factor = table.number_or("limit_factor", &LIMIT, 1.0);
        let mut step = StepTable::Fixed { time_step_s: At { value: 1.0, place: end_time_s.place.clone() } };
        if let Some(mut inner) = table.required_table("step") {
            let kinds = [("fixed", StepKind::Fixed), ("adaptive", StepKind::Adaptive)];
            match inner.choice("type", &kinds).map(|choice| choice.value) {
                Some(StepKind::Fixed) => {
                    step = StepTable::Fixed { time_step_s: inner.number("time_step_s", &Allowed::POSITIVE) };
                }
                Some(StepKind::Adaptive) => {
                    step = StepTable::Adaptive {
                        factor: inner.number_or("factor", &Allowed::FRACTION, Self::DEFAULT_FACTOR),
                        maximum_s: inner.number_or("maximum_s", &Allowed::POSITIVE, span).value,
                        growth: inner.number_or("growth", &GROWTH, Self::DEFAULT_GROWTH).value,
                    };
                }
                None => inner.abandon(),
            }
            inner.finish();
        }
        Self { start_time_s, end_time_s, step, limit_factor, intact: table.finish() }
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> TimePlan {
        let step = match &self.step {
            StepTable::Fixed { time_step_s } => StepPolicy::Fixed { time_step: time_step_s.value },
            StepTable::Adaptive { factor, maximum_s, growth } => {
                StepPolicy::Adaptive { factor: factor.value, maximum: *maximum_s, growth: *growth }
            }
        };
        TimePlan { start_time: self.start_time_s, end_time: self.end_time_s.value, step }
    }
}

/// `[outputs]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct OutputsTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub snapshot_interval_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe_interval_s: Option<f64>,
    pub ledger_every_steps: u64,
    pub picture_times_s: Vec<f64>,
}

impl OutputsTable {
    /// Pictures of a report when a case names no times.
    const DEFAULT_PICTURES: u8 = 6;

    /// Steps between rows of the ledger: a row has some eighty numbers, and one a step would outgrow all other outputs.
    const DEFAULT_LEDGER_STEPS: u64 = 10;

    /// Reads the table; times are checked against `time`.
    pub fn read(mut table: Table<'_>, time: &TimeTable) -> Self {
        let snapshot_interval_s = table.optional_number("snapshot_interval_s", &Allowed::POSITIVE);
        let probe_interval_s = table.optional_number("probe_interval_s", &Allowed::POSITIVE);
        let ledger_every_steps =
            table.count_or("ledger_every_steps", 1..1_000_001, Self::DEFAULT_LEDGER_STEPS).value;
        let (start, end) = (time.start_time_s, time.end_time_s.value);
        let pictures = table.optional_numbers("picture_times_s", &Allowed::FINITE);
        if let Some(times) = pictures.as_ref().filter(|_| time.intact)
            && let Some(outside) = times.value.iter().find(|t| !(start..=end).contains(*t))
        {
            let error = CaseError::new(&times.place, format!("{outside} s is not within the run"));
            table.error(error.allowed(format!("times from {start} to {end} s")));
        }
        let spread = || {
            let last = f64::from(Self::DEFAULT_PICTURES - 1);
            (0..Self::DEFAULT_PICTURES).map(|k| start + (end - start) * f64::from(k) / last).collect()
        };
        let picture_times_s = pictures.map_or_else(spread, |times| times.value);
        table.finish();
        Self { snapshot_interval_s, probe_interval_s, ledger_every_steps, picture_times_s }
    }

    /// Set-up of the solvers.
    pub fn plan(&self) -> OutputPlan {
        OutputPlan { snapshot_interval: self.snapshot_interval_s, probe_interval: self.probe_interval_s }
    }
}

/// Names of what a failed balance does; the first is the default.
const ACTIONS: [(&str, BreachAction); 3] = [
    ("stop", BreachAction::Stop),
    ("warn", BreachAction::Warn),
    ("stop-and-checkpoint", BreachAction::StopAndCheckpoint),
];

/// `[ledger]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct LedgerTable {
    pub action: Choice<BreachAction>,
    pub balance_tolerance: f64,
    pub momentum_tolerance: f64,
}

impl LedgerTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let default = LedgerPolicy::default();
        let read = Self {
            action: table.choice_or_first("action", &ACTIONS),
            balance_tolerance: table
                .number_or("balance_tolerance", &Allowed::POSITIVE, default.balance_tolerance)
                .value,
            momentum_tolerance: table
                .number_or("momentum_tolerance", &Allowed::POSITIVE, default.momentum_tolerance)
                .value,
        };
        table.finish();
        read
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> LedgerPolicy {
        LedgerPolicy {
            action: self.action.value,
            balance_tolerance: self.balance_tolerance,
            momentum_tolerance: self.momentum_tolerance,
        }
    }
}

/// A prescribed motion, expressions of t.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct MotionTable {
    pub displacement_x_m: At<Written>,
    pub displacement_y_m: At<Written>,
    pub angle_rad: At<Written>,
    pub pivot_m: Vector,
}

impl MotionTable {
    /// Reads `motion`, which may be left out.
    pub fn read(parent: &mut Table<'_>) -> Option<Self> {
        let mut table = parent.optional_table("motion")?;
        let turns = table.has("angle_rad");
        let read = Self {
            displacement_x_m: formula::read(&mut table, "displacement_x_m", &["t"]),
            displacement_y_m: formula::read(&mut table, "displacement_y_m", &["t"]),
            angle_rad: formula::read(&mut table, "angle_rad", &["t"]),
            pivot_m: match turns {
                true => table.vector("pivot_m").value,
                false => table.vector_or("pivot_m", Vector::zeros()).value,
            },
        };
        table.finish();
        Some(read)
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> Motion {
        Motion {
            displacement: [self.displacement_x_m.value.text(), self.displacement_y_m.value.text()],
            angle: self.angle_rad.value.text(),
            axis: 1.0,
            pivot: self.pivot_m,
        }
    }
}
