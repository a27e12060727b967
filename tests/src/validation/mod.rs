//! The verification suite: cases with a known answer, run at several resolutions and judged by figures.
//!
//! A case is one file in [`cases`]: it names its members (runs of a case file of `cases/validation/` with some values
//! replaced) and says what to read off each. To add one, write the file and list it in [`cases::all`].

pub mod cases;
pub mod energy;
pub mod particles;
pub mod plot;
pub mod regression;
pub mod report;
pub mod runner;
pub mod snapshot;
pub mod template;

pub use coordinator::study::series;
pub use plot::Plot;
pub use runner::Run;

/// One verification case.
pub trait Case: Sync {
    /// Name on the command line and in outputs: letters, digits, `_`.
    fn name(&self) -> &'static str;

    /// What is compared with what, in one line.
    fn about(&self) -> &'static str;

    /// The runs, coarse before fine within a scheme.
    fn members(&self) -> Vec<Member>;

    /// Figures of one run.
    ///
    /// # Errors
    /// When the outputs of the run do not hold what is needed.
    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String>;

    /// Figures that need several runs; they are reported beside the last.
    ///
    /// # Errors
    /// When the outputs of the runs do not hold what is needed.
    fn comparison(&self, _runs: &[Run]) -> Result<Vec<Figure>, String> {
        Ok(Vec::new())
    }

    /// Plots over all runs.
    ///
    /// # Errors
    /// When the outputs of the runs do not hold what is needed.
    fn plots(&self, _runs: &[Run]) -> Result<Vec<Plot>, String> {
        Ok(Vec::new())
    }
}

/// One run of a case.
#[derive(Clone, Debug)]
pub struct Member {
    /// Case file from `cases/validation/` on, without ending.
    pub file: &'static str,
    /// Scheme or variant, such as `recommended`.
    pub scheme: &'static str,
    /// Particle spacing \[m\].
    pub spacing: f64,
    /// Values replaced in the case file: path such as `time.end_time_s` or `fluid.region.0.shape` and value.
    pub changes: Vec<(String, toml::Value)>,
    /// Whether `--quick` runs it.
    pub quick: bool,
    /// Whether it may stop before its end, if it says truly why.
    pub may_stop: bool,
}

impl Member {
    /// A member of the recommended settings at `spacing` \[m\].
    pub fn new(file: &'static str, spacing: f64) -> Self {
        Self { file, scheme: "recommended", spacing, changes: Vec::new(), quick: false, may_stop: false }
            .with("fluid.particle_spacing_m", spacing)
    }

    /// A member of a case without fluid at `spacing` \[m\].
    pub fn solid(file: &'static str, spacing: f64) -> Self {
        Self { file, scheme: "recommended", spacing, changes: Vec::new(), quick: false, may_stop: false }
            .with("solid.particle_spacing_m", spacing)
    }

    /// The same under another name of the scheme.
    #[must_use]
    pub fn scheme(self, scheme: &'static str) -> Self {
        Self { scheme, ..self }
    }

    /// The same with the value at `path` replaced.
    #[must_use]
    pub fn with(mut self, path: &str, value: impl Into<toml::Value>) -> Self {
        self.changes.push((path.to_owned(), value.into()));
        self
    }

    /// The same, also run by `--quick`.
    #[must_use]
    pub fn quick(self) -> Self {
        Self { quick: true, ..self }
    }

    /// The same, which may stop with a diagnosis.
    #[must_use]
    pub fn may_stop(self) -> Self {
        Self { may_stop: true, ..self }
    }

    /// Name of the case file without folder and ending.
    pub fn stem(&self) -> &'static str {
        self.file.rsplit('/').next().unwrap_or(self.file)
    }

    /// Name of its folder.
    pub fn label(&self) -> String {
        format!(
            "{}_{}_{}",
            self.stem(),
            self.scheme.replace(|c: char| !c.is_ascii_alphanumeric(), "-"),
            self.spacing
        )
    }
}

/// What a figure has to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Reported only.
    None,
    /// |value/reference − 1| at most this.
    Relative(f64),
    /// Value at most this.
    AtMost(f64),
    /// Value at least this.
    AtLeast(f64),
    /// Value between these.
    Between(f64, f64),
}

/// One number read off a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name with the unit.
    pub name: String,
    /// Value.
    pub value: f64,
    /// What it should be.
    pub reference: Option<f64>,
    /// What it has to meet.
    pub goal: Goal,
}

impl Figure {
    /// A figure that is only reported.
    pub fn reported(name: impl Into<String>, value: f64) -> Self {
        Self { name: name.into(), value, reference: None, goal: Goal::None }
    }

    /// A figure that has to meet `goal`.
    pub fn judged(name: impl Into<String>, value: f64, goal: Goal) -> Self {
        Self { name: name.into(), value, reference: None, goal }
    }

    /// A figure that has to lie within the fraction `tolerance` of `reference`.
    pub fn compared(name: impl Into<String>, value: f64, reference: f64, tolerance: f64) -> Self {
        Self { name: name.into(), value, reference: Some(reference), goal: Goal::Relative(tolerance) }
    }

    /// The same, only reported.
    #[must_use]
    pub fn report_only(self) -> Self {
        Self { goal: Goal::None, ..self }
    }

    /// value/reference − 1.
    pub fn error(&self) -> Option<f64> {
        self.reference.map(|reference| self.value / reference - 1.0)
    }

    /// Whether the goal is met; `None` without a goal. What is not a number meets none.
    pub fn passes(&self) -> Option<bool> {
        match self.goal {
            Goal::None => None,
            Goal::Relative(tolerance) => Some(self.error().is_some_and(|error| error.abs() <= tolerance)),
            Goal::AtMost(limit) => Some(self.value <= limit),
            Goal::AtLeast(limit) => Some(self.value >= limit),
            Goal::Between(low, high) => Some((low..=high).contains(&self.value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_judged_and_not_a_number_never_passes() {
        assert_eq!(Figure::compared("a", 1.009, 1.0, 0.01).passes(), Some(true));
        assert_eq!(Figure::compared("a", 1.011, 1.0, 0.01).passes(), Some(false));
        assert_eq!(Figure::judged("a", 2.0, Goal::Between(1.0, 2.0)).passes(), Some(true));
        assert_eq!(Figure::reported("a", 2.0).passes(), None);
        for goal in [Goal::Relative(1.0), Goal::AtMost(1.0), Goal::AtLeast(1.0), Goal::Between(0.0, 1.0)] {
            let figure = Figure { name: "a".into(), value: f64::NAN, reference: Some(1.0), goal };
            assert_eq!(figure.passes(), Some(false), "{goal:?}");
        }
    }
}
