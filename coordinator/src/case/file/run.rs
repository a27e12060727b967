//! Domain, forces, time, outputs, ledger and servers as a case file writes them.

mod rows;

use serde::Serialize;
use sph::setup::{BreachAction, LedgerPolicy, Motion, Outflow, OutputPlan, StepPolicy, TimePlan};
use sph::space::components::Components;
use sph::space::domain::Domain;
use sph::space::{AXIS_NAMES, Space};

use super::formula;
use crate::case::errors::{CaseError, Place};
use crate::case::reader::{At, Choice, Coordinates, Table, Written};
pub use rows::{AXIS_WORDS, BODY_FORCE, DOMAIN, LEDGER, MOTION, OUTPUTS, SIDE_WORDS, TIME};

/// Names of the axes in lists of directions; the plane has the first two.
const AXES: [(&str, usize); 3] = [(AXIS_NAMES[0], 0), (AXIS_NAMES[1], 1), (AXIS_NAMES[2], 2)];

/// Names of the axes of a case of `dimensions` dimensions.
pub fn axes(dimensions: usize) -> &'static [(&'static str, usize)] {
    &AXES[..dimensions]
}

/// A side of a box: axis, and whether it is the upper one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// Axis.
    pub axis: usize,
    /// The upper side along the axis.
    pub upper: bool,
}

/// Names of the sides of a box in the plane.
const PLANE_SIDES: [(&str, Side); 4] = [
    ("left", Side { axis: 0, upper: false }),
    ("right", Side { axis: 0, upper: true }),
    ("bottom", Side { axis: 1, upper: false }),
    ("top", Side { axis: 1, upper: true }),
];

/// Names of the sides of a box in space, where gravity says what is up.
const SPATIAL_SIDES: [(&str, Side); 6] = [
    ("-x", Side { axis: 0, upper: false }),
    ("+x", Side { axis: 0, upper: true }),
    ("-y", Side { axis: 1, upper: false }),
    ("+y", Side { axis: 1, upper: true }),
    ("-z", Side { axis: 2, upper: false }),
    ("+z", Side { axis: 2, upper: true }),
];

/// Names of the sides of a box in a case of `dimensions` dimensions.
pub fn sides(dimensions: usize) -> &'static [(&'static str, Side)] {
    if dimensions == 2 { &PLANE_SIDES } else { &SPATIAL_SIDES }
}

/// `[domain]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)] // As for all tables here: the keys name quantity and unit.
pub struct DomainTable {
    pub lower_m: At<Coordinates>,
    pub upper_m: At<Coordinates>,
    pub periodic: Vec<Choice<usize>>,
    /// Corner of the one lattice on which all particles of the scene are laid.
    pub lattice_origin_m: Coordinates,
    /// Sides through which particles may leave; by default the open sides of containers that fill the domain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outflow_sides: Option<Vec<Choice<Side>>>,
    #[serde(skip)]
    pub intact: bool,
}

impl DomainTable {
    /// What stands in for a table that is missing; nothing is built from it.
    pub fn unwritten(place: &Place) -> Self {
        let corner = |value| At { value: Coordinates::repeat(2, value), place: place.clone() };
        Self {
            lower_m: corner(0.0),
            upper_m: corner(1.0),
            periodic: Vec::new(),
            lattice_origin_m: Coordinates::repeat(2, 0.0),
            outflow_sides: None,
            intact: false,
        }
    }

    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let dimensions = table.dimensions;
        let lower_m = table.vector("lower_m");
        let upper_m = table.vector("upper_m");
        let mut sizes = lower_m.value.as_slice().iter().zip(upper_m.value.as_slice());
        if table.intact() && !sizes.all(|(lower, upper)| lower < upper) {
            let problem = match dimensions {
                2 => "does not lie above and to the right of `lower_m`",
                _ => "does not exceed `lower_m` along each axis",
            };
            let error = CaseError::new(&upper_m.place, problem);
            table.error(error.value(table.written(&upper_m.place)));
        }
        let periodic = table.words("periodic", axes(dimensions)).unwrap_or_default();
        let outflow_sides = table.words("outflow_sides", sides(dimensions));
        for side in outflow_sides.iter().flatten() {
            if periodic.iter().any(|axis| axis.value == side.value.axis) {
                table.error(CaseError::new(&side.place, "lies across a periodic direction").value(side.word));
            }
        }
        let lattice_origin_m = table.vector_or("lattice_origin_m", lower_m.value.clone()).value;
        Self { lower_m, upper_m, periodic, lattice_origin_m, outflow_sides, intact: table.finish() }
    }

    /// Number of dimensions of the case.
    pub fn dimensions(&self) -> usize {
        self.lower_m.value.as_slice().len()
    }

    /// Whether the scene repeats along `axis`.
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.periodic.iter().any(|choice| choice.value == axis)
    }

    /// The box of the scene.
    pub fn domain<S: Space>(&self) -> Domain<S> {
        let periodic = S::axes(|axis| self.is_periodic(axis));
        Domain { lower: self.lower_m.value.to::<S>(), upper: self.upper_m.value.to::<S>(), periodic }
    }

    /// Sides through which particles may leave.
    pub fn outflow<S: Space>(&self) -> Outflow<S> {
        let sides = || self.outflow_sides.iter().flatten().map(|choice| choice.value);
        let open = |upper| S::axes(|axis| sides().any(|side| side == Side { axis, upper }));
        Outflow { lower: open(false), upper: open(true) }
    }

    /// Where coordinates may lie, in words: `x from 0 to 1, y from 0 to 2`.
    pub fn extent_text(&self) -> String {
        let (lower, upper) = (self.lower_m.value.as_slice(), self.upper_m.value.as_slice());
        let spans = AXIS_NAMES.iter().zip(lower.iter().zip(upper));
        let spans: Vec<String> =
            spans.map(|(axis, (lower, upper))| format!("{axis} from {lower} to {upper}")).collect();
        spans.join(", ")
    }
}

/// `[body_force]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct BodyForceTable {
    pub gravity_m_s2: Coordinates,
    /// Expressions of x, y, in space z, and t, added to gravity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_m_s2: Option<Vec<At<Written>>>,
}

impl BodyForceTable {
    /// Reads the table; left out, nothing pulls.
    pub fn read(mut table: Table<'_>) -> Self {
        let zero = Coordinates::repeat(table.dimensions, 0.0);
        let gravity_m_s2 = table.vector_or("gravity_m_s2", zero).value;
        let acceleration_m_s2 = formula::read_components(&mut table, "acceleration_m_s2");
        table.finish();
        Self { gravity_m_s2, acceleration_m_s2 }
    }

    /// Set-up of the solvers.
    pub fn to_setup<S: Space>(&self) -> sph::setup::BodyForce<S> {
        let expressions = self.acceleration_m_s2.as_deref().map(formula::texts::<S>);
        sph::setup::BodyForce { gravity: self.gravity_m_s2.to::<S>(), expressions }
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
    Fixed {
        time_step_s: At<f64>,
    },
    Adaptive {
        factor: At<f64>,
        maximum_s: f64,
        growth: f64,
        /// Steps are shortened so that boundaries meet the times of outputs and `exact_times_s`.
        exact_outputs: bool,
        /// `None` where outputs are not met.
        #[serde(skip_serializing_if = "Option::is_none")]
        exact_times_s: Option<Vec<f64>>,
    },
}

#[derive(Clone, Copy)]
enum StepKind {
    Fixed,
    Adaptive,
}

impl TimeTable {
    /// What stands in for a table that is missing; nothing is built from it.
    pub fn unwritten(place: &Place) -> Self {
        let one = At { value: 1.0, place: place.clone() };
        let step = StepTable::Fixed { time_step_s: one.clone() };
        Self { start_time_s: 0.0, end_time_s: one.clone(), step, limit_factor: one, intact: false }
    }

    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let start_time_s = table.number("start_time_s").value;
        let end_time_s = table.number("end_time_s");
        if table.intact() && end_time_s.value < start_time_s {
            let error = CaseError::new(&end_time_s.place, "lies before the start").value(end_time_s.value);
            table.error(error.allowed(format!("a time of {start_time_s} s or later")));
        }
        let span = (end_time_s.value - start_time_s).max(f64::MIN_POSITIVE);
        let limit_factor = table.number("limit_factor");
        let mut step = StepTable::Fixed { time_step_s: At { value: 1.0, place: end_time_s.place.clone() } };
        if let Some(mut inner) = table.required_table("step") {
            let kinds = [("fixed", StepKind::Fixed), ("adaptive", StepKind::Adaptive)];
            match inner.choice("type", &kinds).map(|choice| choice.value) {
                Some(StepKind::Fixed) => {
                    step = StepTable::Fixed { time_step_s: inner.number("time_step_s") };
                }
                Some(StepKind::Adaptive) => {
                    let exact_outputs = inner.flag("exact_outputs");
                    let exact_times_s =
                        exact_times(&mut inner, exact_outputs, start_time_s, end_time_s.value);
                    step = StepTable::Adaptive {
                        factor: inner.number("factor"),
                        maximum_s: inner.number_or("maximum_s", span).value,
                        growth: inner.number("growth").value,
                        exact_outputs,
                        exact_times_s,
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
            StepTable::Adaptive { factor, maximum_s, growth, exact_times_s, .. } => StepPolicy::Adaptive {
                factor: factor.value,
                maximum: *maximum_s,
                growth: *growth,
                exact: exact_times_s.clone(),
            },
        };
        TimePlan { start_time: self.start_time_s, end_time: self.end_time_s.value, step }
    }
}

/// `exact_times_s`: the end of the run where it is not written. A run that is continued beyond that end keeps it.
fn exact_times(table: &mut Table<'_>, exact_outputs: bool, start: f64, end: f64) -> Option<Vec<f64>> {
    let written = table.optional_numbers("exact_times_s");
    if !exact_outputs {
        if let Some(times) = written {
            table.error(CaseError::new(&times.place, "needs `exact_outputs = true`").allowed("no times"));
        }
        return None;
    }
    let Some(times) = written else { return Some(vec![end]) };
    if let Some(early) = times.value.iter().find(|time| **time < start) {
        let error = CaseError::new(&times.place, format!("{early} s is before the start"));
        table.error(error.allowed(format!("times of {start} s or later")));
    }
    Some(times.value)
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

/// Times of pictures when a case names none: of snapshots, about evenly from `start` to `end`.
fn default_pictures(start: f64, end: f64, snapshot_interval: Option<f64>) -> Vec<f64> {
    const PICTURES: u8 = 6;
    let Some(interval) = snapshot_interval else { return vec![start, end] };
    let last = f64::from(PICTURES - 1);
    let wanted = (0..PICTURES).map(|k| (end - start) * f64::from(k) / last);
    // Rounding must not put the last one beyond the end.
    let mut times: Vec<f64> =
        wanted.map(|time| (start + (time / interval).round() * interval).min(end)).collect();
    times[usize::from(PICTURES - 1)] = end;
    times.dedup();
    times
}

impl OutputsTable {
    /// Reads the table; times are checked against `time`.
    pub fn read(mut table: Table<'_>, time: &TimeTable) -> Self {
        let snapshot_interval_s = table.optional_number("snapshot_interval_s");
        let probe_interval_s = table.optional_number("probe_interval_s");
        let ledger_every_steps = table.count("ledger_every_steps").value;
        let (start, end) = (time.start_time_s, time.end_time_s.value);
        let pictures = table.optional_numbers("picture_times_s");
        if let Some(times) = pictures.as_ref().filter(|_| time.intact)
            && let Some(outside) = times.value.iter().find(|t| !(start..=end).contains(*t))
        {
            let error = CaseError::new(&times.place, format!("{outside} s is not within the run"));
            table.error(error.allowed(format!("times from {start} to {end} s")));
        }
        let spread = || default_pictures(start, end, snapshot_interval_s);
        let picture_times_s = pictures.map_or_else(spread, |times| times.value);
        table.finish();
        Self { snapshot_interval_s, probe_interval_s, ledger_every_steps, picture_times_s }
    }

    /// Whether the pictures are those of a case from `start` to `end` that names none.
    pub fn has_default_pictures(&self, start: f64, end: f64) -> bool {
        self.picture_times_s == default_pictures(start, end, self.snapshot_interval_s)
    }

    /// Takes the pictures of a case from `start` to `end` that names none.
    pub fn set_default_pictures(&mut self, start: f64, end: f64) {
        self.picture_times_s = default_pictures(start, end, self.snapshot_interval_s);
    }

    /// Set-up of the solvers.
    pub fn plan(&self) -> OutputPlan {
        OutputPlan {
            snapshot_interval: self.snapshot_interval_s,
            probe_interval: self.probe_interval_s,
            snapshot_times: self.picture_times_s.clone(),
        }
    }
}

/// Names of what a failed balance does.
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
        let read = Self {
            action: table.choice_or_default("action", &ACTIONS),
            balance_tolerance: table.number("balance_tolerance").value,
            momentum_tolerance: table.number("momentum_tolerance").value,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_z_m: Option<At<Written>>,
    pub angle_rad: At<Written>,
    /// Direction of the axis of rotation; the plane has but one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<Coordinates>,
    pub pivot_m: Coordinates,
}

impl MotionTable {
    /// Reads `motion`, which may be left out.
    pub fn read(parent: &mut Table<'_>) -> Option<Self> {
        let mut table = parent.optional_table("motion")?;
        let (turns, in_space) = (table.has("angle_rad"), table.dimensions == 3);
        let zero = Coordinates::repeat(table.dimensions, 0.0);
        let read = Self {
            displacement_x_m: formula::read(&mut table, "displacement_x_m"),
            displacement_y_m: formula::read(&mut table, "displacement_y_m"),
            displacement_z_m: in_space.then(|| formula::read(&mut table, "displacement_z_m")),
            angle_rad: formula::read(&mut table, "angle_rad"),
            axis: (in_space && turns).then(|| Self::read_axis(&mut table)),
            pivot_m: match turns {
                true => table.vector("pivot_m").value,
                false => table.vector_or("pivot_m", zero).value,
            },
        };
        table.finish();
        Some(read)
    }

    fn read_axis(table: &mut Table<'_>) -> Coordinates {
        let axis = table.vector("axis");
        if table.intact() && !axis.value.is_nonzero() {
            let error = CaseError::new(&axis.place, "has no direction").value(table.written(&axis.place));
            table.error(error.hint("give a direction such as [0.0, 0.0, 1.0]; its length does not matter"));
        }
        axis.value
    }

    /// The expressions of the displacement along the axes of the case, then that of the angle.
    pub fn formulas(&self) -> impl Iterator<Item = &At<Written>> {
        let displacement = [&self.displacement_x_m, &self.displacement_y_m].into_iter();
        displacement.chain(&self.displacement_z_m).chain([&self.angle_rad])
    }

    /// Set-up of the solvers.
    pub fn to_setup<S: Space>(&self) -> Motion<S> {
        let texts: Vec<String> = self.formulas().map(|written| written.value.text()).collect();
        Motion {
            displacement: S::per_axis(|axis| texts[axis].clone()),
            angle: self.angle_rad.value.text(),
            axis: axis_of::<S>(self.axis.as_ref()),
            pivot: self.pivot_m.to::<S>(),
        }
    }
}

/// The spin of unit magnitude about `axis`: in the plane counter-clockwise, in space about z where none is written.
fn axis_of<S: Space>(axis: Option<&Coordinates>) -> S::Spin {
    let mut row = vec![0.0; S::Spin::COUNT];
    match axis {
        Some(axis) if axis.as_slice().len() == row.len() => {
            let length = axis.as_slice().iter().map(|x| x * x).sum::<f64>().sqrt();
            row.iter_mut().zip(axis.as_slice()).for_each(|(row, x)| *row = x / length);
        }
        _ => row.iter_mut().last().into_iter().for_each(|last| *last = 1.0),
    }
    S::Spin::of_row(&row).unwrap_or_default()
}
