//! `probes.csv`: the probes of both sides, one row per probe time.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use sph::coupling::driver::ProbeValues;
use sph::coupling::solver::Role;
use sph::setup::{Probe, ProbeKind};

use super::error::OutputError;
use super::table::{Changed, Resumed, TableFile, TableMark};

/// Column names of one side: `<probe>_<quantity>_<unit>`.
pub fn columns_of<K: ProbeKind>(probes: &[Probe<K>]) -> Vec<String> {
    let named = |probe: &Probe<K>| {
        let (name, columns) = (probe.name.clone(), probe.kind.columns());
        columns.iter().map(move |quantity| format!("{name}_{quantity}"))
    };
    probes.iter().flat_map(named).collect()
}

/// Column names of `probes.csv`: `t_s`, then the fluid's before the solid's.
pub fn columns(fluid: &[String], solid: &[String]) -> Vec<String> {
    std::iter::once("t_s".to_string()).chain(fluid.iter().cloned()).chain(solid.iter().cloned()).collect()
}

/// One side's share of the rows.
#[derive(Debug, Default)]
struct Side {
    takes_part: bool,
    columns: usize,
    waiting: VecDeque<ProbeValues>,
}

/// Writer of `probes.csv`, which joins the values of both sides at the same step.
pub struct ProbeFile {
    path: PathBuf,
    file: TableFile,
    sides: [Side; 2],
    last_step: Option<u64>,
    row: Vec<f64>,
}

impl ProbeFile {
    /// Starts the file; a side that takes no part in the run is `None`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(
        path: &Path,
        fluid: Option<&[String]>,
        solid: Option<&[String]>,
    ) -> Result<Self, OutputError> {
        Self::open(path, fluid, solid, |columns| TableFile::create(path, columns))
    }

    /// Continues the file of an earlier run from what it held at `mark`; with a warning about it, if any.
    ///
    /// # Errors
    /// As [`TableFile::resume`].
    pub fn resume(
        path: &Path,
        fluid: Option<&[String]>,
        solid: Option<&[String]>,
        mark: &TableMark,
        changed: Changed,
    ) -> Result<(Self, Option<String>), OutputError> {
        let mut change = None;
        let file = Self::open(path, fluid, solid, |columns| {
            let Resumed { file, warning } = TableFile::resume(path, columns, mark, changed)?;
            change = warning;
            Ok(file)
        })?;
        Ok((file, change))
    }

    fn open(
        path: &Path,
        fluid: Option<&[String]>,
        solid: Option<&[String]>,
        open: impl FnOnce(&[String]) -> Result<TableFile, OutputError>,
    ) -> Result<Self, OutputError> {
        let columns = columns(fluid.unwrap_or_default(), solid.unwrap_or_default());
        let [of_fluid, of_solid] = [fluid, solid].map(|side| side.map_or(0, <[String]>::len));
        let side = |takes_part, columns| Side { takes_part, columns, waiting: VecDeque::new() };
        Ok(Self {
            path: path.to_path_buf(),
            file: open(&columns)?,
            sides: [side(fluid.is_some(), of_fluid), side(solid.is_some(), of_solid)],
            last_step: None,
            row: Vec::with_capacity(columns.len()),
        })
    }

    /// Takes the values of `role` and writes every row that they complete.
    ///
    /// # Errors
    /// When a row cannot be written, or the number of values is not that of the columns.
    pub fn take(&mut self, role: Role, values: ProbeValues) -> Result<(), OutputError> {
        let side = &mut self.sides[role.index()];
        if values.values.len() != side.columns || !side.takes_part {
            let (got, expected) = (values.values.len(), side.columns);
            let reason = format!("the {role} solver sent {got} probe values, the case asks for {expected}");
            return Err(OutputError::content(&self.path, reason));
        }
        side.waiting.push_back(values);
        while self.sides.iter().all(|side| !side.takes_part || !side.waiting.is_empty()) {
            self.write_earliest()?;
        }
        Ok(())
    }

    /// The file.
    pub fn file(&self) -> &TableFile {
        &self.file
    }

    /// What the file held before the row of `step` and those after it.
    pub fn mark_before(&self, step: u64) -> TableMark {
        if self.last_step == Some(step) { self.file.mark_before_last() } else { self.file.mark() }
    }

    /// Writes what is left, with NaN for a side that ended earlier, and gives the file its final name.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<PathBuf, OutputError> {
        while self.sides.iter().any(|side| !side.waiting.is_empty()) {
            self.write_earliest()?;
        }
        self.file.finish()
    }

    /// Writes the row of the earliest waiting step; a step that was written before is dropped.
    fn write_earliest(&mut self) -> Result<(), OutputError> {
        let fronts = self.sides.iter().filter_map(|side| side.waiting.front());
        let Some((step, time)) = fronts.map(|front| (front.step, front.time)).min_by_key(|front| front.0)
        else {
            return Ok(());
        };
        self.row.clear();
        self.row.push(time);
        for side in &mut self.sides {
            if side.waiting.front().is_some_and(|front| front.step == step) {
                self.row.extend(side.waiting.pop_front().into_iter().flat_map(|front| front.values));
            } else {
                self.row.extend(std::iter::repeat_n(f64::NAN, side.columns));
            }
        }
        // A run that is stopped at an output boundary reports that boundary twice.
        if self.last_step == Some(step) {
            return Ok(());
        }
        self.last_step = Some(step);
        self.file.push(&self.row)
    }
}

#[cfg(test)]
mod tests {
    use sph::setup::{FluidProbe, FluidProbeKind, SolidProbe, SolidProbeKind};
    use sph::space::Vector;

    use super::*;
    use crate::results::table::Table;

    fn fluid_probes() -> Vec<String> {
        let probe = |name: &str, kind| FluidProbe { name: name.into(), kind };
        columns_of::<FluidProbeKind>(&[
            probe("p1", FluidProbeKind::Point(Vector::new(0.1, 0.2))),
            probe("gauge", FluidProbeKind::WaterLevel(0.3)),
        ])
    }

    fn solid_probes() -> Vec<String> {
        columns_of::<SolidProbeKind>(&[SolidProbe {
            name: "clamp".into(),
            kind: SolidProbeKind::Reaction(0, 0),
        }])
    }

    fn values(step: u64, values: &[f64]) -> ProbeValues {
        ProbeValues { step, time: step as f64 * 0.5, values: values.to_vec() }
    }

    #[test]
    fn columns_say_probe_quantity_and_unit() {
        let expected = [
            "t_s",
            "p1_pressure_pa",
            "p1_velocity_x_m_s",
            "p1_velocity_y_m_s",
            "gauge_level_m",
            "clamp_force_x_n_per_m",
            "clamp_force_y_n_per_m",
        ];
        assert_eq!(columns(&fluid_probes(), &solid_probes()), expected);
    }

    #[test]
    fn both_sides_of_a_step_become_one_row_whoever_is_ahead() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("probes.csv");
        let mut file = ProbeFile::create(&path, Some(&fluid_probes()), Some(&solid_probes())).unwrap();
        file.take(Role::Fluid, values(0, &[1.0, 2.0, 3.0, 4.0])).unwrap();
        file.take(Role::Fluid, values(1, &[1.1, 2.1, 3.1, 4.1])).unwrap();
        file.take(Role::Solid, values(0, &[5.0, 6.0])).unwrap();
        file.take(Role::Solid, values(1, &[5.1, 6.1])).unwrap();
        // Stopped at an output boundary: reported twice, written once.
        file.take(Role::Solid, values(1, &[5.1, 6.1])).unwrap();
        file.take(Role::Fluid, values(1, &[1.1, 2.1, 3.1, 4.1])).unwrap();
        // The solid fails before its next output.
        file.take(Role::Fluid, values(2, &[1.2, 2.2, 3.2, 4.2])).unwrap();
        file.finish().unwrap();
        let table = Table::read(&path).unwrap();
        assert_eq!(table.column("t_s").unwrap(), [0.0, 0.5, 1.0]);
        assert_eq!(table.column("gauge_level_m").unwrap(), [4.0, 4.1, 4.2]);
        let clamp = table.column("clamp_force_y_n_per_m").unwrap();
        assert_eq!(clamp[..2], [6.0, 6.1]);
        assert!(clamp[2].is_nan());
    }

    #[test]
    fn one_side_alone_needs_no_partner() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("probes.csv");
        let mut file = ProbeFile::create(&path, None, Some(&solid_probes())).unwrap();
        file.take(Role::Solid, values(0, &[5.0, 6.0])).unwrap();
        let wrong = file.take(Role::Solid, values(1, &[5.0])).unwrap_err().to_string();
        assert!(wrong.contains("1 probe values") && wrong.contains('2'), "{wrong}");
        file.finish().unwrap();
        assert_eq!(Table::read(&path).unwrap().rows(), 1);
    }
}
