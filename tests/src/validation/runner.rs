//! Running a member through the coordinator, in this process, and what its folder holds afterwards.

use std::path::{Path, PathBuf};

use coordinator::failure::Kind;
use coordinator::results::names;
use coordinator::results::state;
use coordinator::results::table::Table;
use coordinator::run::RunOutcome;
use coordinator::study::runner;
use sph::coupling::solver::ParticleFields;

use super::template;
use super::{Case, Member, snapshot};

/// How members are run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder for everything.
    pub out: PathBuf,
    /// Compute threads; `None` for all cores.
    pub threads: Option<u16>,
    /// Further values replaced in every case file.
    pub changes: Vec<(String, toml::Value)>,
    /// Use results that are already in the folder.
    pub reuse: bool,
}

/// A finished run.
#[derive(Debug)]
pub struct Run {
    /// What was run.
    pub member: Member,
    /// Folder of its results.
    pub folder: PathBuf,
    /// The case as it was run, with every default.
    pub case: toml::Table,
    /// All probes.
    pub probes: Table,
    /// `summary.json`.
    pub summary: serde_json::Value,
    /// CPU time, user and system \[s\].
    pub cpu_seconds: f64,
}

/// Name of the file that keeps the CPU time of a run.
const CPU_FILE: &str = "cpu_seconds.txt";

impl Run {
    /// Runs `member` of `case`.
    ///
    /// # Errors
    /// When the case file is wrong or the run fails.
    pub fn of(case: &dyn Case, member: Member, options: &Options) -> Result<Self, String> {
        let folder = options.out.join(case.name()).join(member.label());
        let results = folder.join("results");
        let file = template::folder().join(member.file).with_extension("toml");
        let changes: Vec<_> = member.changes.iter().chain(&options.changes).cloned().collect();
        let text = template::instantiate(&file, &changes)?;
        let case_file = folder.join(member.stem()).with_extension("toml");
        let done = results.join(names::SUMMARY).exists()
            && std::fs::read_to_string(&case_file).is_ok_and(|before| before == text);
        if !(options.reuse && done) {
            std::fs::create_dir_all(&folder)
                .map_err(|e| format!("`{}` cannot be made: {e}", folder.display()))?;
            write(&case_file, &text)?;
            let run = runner::run(&case_file, &results, options.threads);
            match run.outcome.and_then(RunOutcome::completed) {
                Err(failure) if !(member.may_stop && failure.kind == Kind::Diverged) => {
                    return Err(format!("{}: {}", member.label(), failure.message));
                }
                _ => {}
            }
            write(&folder.join(CPU_FILE), &format!("{}\n", run.cpu_seconds))?;
        }
        Self::read(member, folder)
    }

    fn read(member: Member, folder: PathBuf) -> Result<Self, String> {
        let results = folder.join("results");
        let read = |path: PathBuf| {
            std::fs::read_to_string(&path).map_err(|e| format!("`{}` cannot be read: {e}", path.display()))
        };
        let probes = Table::read(&results.join(names::PROBES)).map_err(|e| e.to_string())?;
        let summary = serde_json::from_str(&read(results.join(names::SUMMARY))?)
            .map_err(|e| format!("{}: {e}", results.join(names::SUMMARY).display()))?;
        let case = read(results.join(names::CASE))?.parse().map_err(|e| format!("{e}"))?;
        let cpu_seconds = read(folder.join(CPU_FILE))?.trim().parse().unwrap_or(f64::NAN);
        Ok(Self { member, folder, case, probes, summary, cpu_seconds })
    }

    /// Values of the probe column `name`, one per row.
    ///
    /// # Errors
    /// When there is no such column.
    pub fn column(&self, name: &str) -> Result<Vec<f64>, String> {
        self.probes
            .column(name)
            .ok_or_else(|| format!("`{}` has no probe column `{name}`", self.folder.display()))
    }

    /// Rows of the probes as (time \[s\], value of the column `name`).
    ///
    /// # Errors
    /// When there is no such column.
    pub fn history(&self, name: &str) -> Result<Vec<(f64, f64)>, String> {
        Ok(self.column("t_s")?.into_iter().zip(self.column(name)?).collect())
    }

    /// Rows of the ledger as (time \[s\], value of the column `name`).
    ///
    /// # Errors
    /// When it cannot be read, or there is no such column.
    pub fn ledger(&self, name: &str) -> Result<Vec<(f64, f64)>, String> {
        let ledger =
            Table::read(&self.folder.join("results").join(names::LEDGER)).map_err(|e| e.to_string())?;
        let missing = |name: &str| format!("the ledger has no column `{name}`");
        let times = ledger.column("t_s").ok_or_else(|| missing("t_s"))?;
        Ok(times.into_iter().zip(ledger.column(name).ok_or_else(|| missing(name))?).collect())
    }

    /// All fluid and wall particles at the end.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn final_fluid(&self) -> Result<ParticleFields, String> {
        state::read(&self.folder.join("results/final/fluid.state"))
    }

    /// All solid particles at the end.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn final_solid(&self) -> Result<ParticleFields, String> {
        state::read(&self.folder.join("results/final/solid.state"))
    }

    /// Times \[s\] and files of the fluid's snapshots, in order.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn fluid_snapshots(&self) -> Result<Vec<(f64, PathBuf)>, String> {
        snapshot::series(&self.folder.join("results/snapshots/fluid.pvd"))
    }

    /// Times \[s\] and files of the solid's snapshots, in order.
    ///
    /// # Errors
    /// When they cannot be read.
    pub fn solid_snapshots(&self) -> Result<Vec<(f64, PathBuf)>, String> {
        snapshot::series(&self.folder.join("results/snapshots/solid.pvd"))
    }

    /// The number at `path` of the case, such as `fluid.sound_speed_m_s`.
    ///
    /// # Errors
    /// When the case does not hold it.
    pub fn number(&self, path: &str) -> Result<f64, String> {
        let mut steps = path.split('.');
        let first = steps.next().and_then(|key| self.case.get(key));
        let entry = |value: Option<&'_ toml::Value>, key: &str| match key.parse::<usize>() {
            Ok(index) => value?.get(index).cloned(),
            Err(_) => value?.get(key).cloned(),
        };
        let value = steps.fold(first.cloned(), |value, key| entry(value.as_ref(), key));
        let value = value.and_then(|v| v.as_float().or(v.as_integer().map(|n| n as f64)));
        value.ok_or_else(|| format!("the case holds no number `{path}`"))
    }

    /// Settings of the fluid in one line: c0, h/Δx, A, B, correction, diffusion, regularisation, relaxation, step.
    pub fn settings(&self) -> String {
        let Some(fluid) = self.case.get("fluid").and_then(toml::Value::as_table) else {
            return String::new();
        };
        let shown = ["sound_speed_m_s", "kernel_ratio", "artificial_viscosity_a", "artificial_viscosity_b"]
            .into_iter()
            .chain(["dynamic_viscosity_pa_s", "gradient_correction", "density_diffusion_delta"])
            .chain(["gradient_correction_share", "shifting", "tensile_control", "volume_correction"])
            .chain(["acoustic_relaxation", "acoustic_relaxation_time_s"]);
        let mut parts: Vec<String> =
            shown.filter_map(|key| fluid.get(key).map(|value| format!("{key} = {value}"))).collect();
        parts.extend(self.case.get("time").and_then(|t| t.get("step")).map(|step| format!("step = {step}")));
        parts.join("; ").replace('\n', " ")
    }

    /// Warnings and reservations of the run, one per line.
    pub fn doubts(&self) -> Vec<String> {
        let listed = |key: &'static str, kind: &'static str| {
            let texts = self.summary.get(key).and_then(serde_json::Value::as_array).into_iter().flatten();
            texts.filter_map(|text| text.as_str()).map(move |text| format!("{kind}: {text}"))
        };
        listed("warnings", "warning").chain(listed("reservations", "reservation")).collect()
    }

    /// The number at the JSON pointer `place` of `summary.json`.
    ///
    /// # Errors
    /// When there is none.
    pub fn count(&self, place: &str) -> Result<f64, String> {
        let value = self.summary.pointer(place).and_then(serde_json::Value::as_f64);
        value.ok_or_else(|| format!("`{}`: the summary holds no number `{place}`", self.folder.display()))
    }

    /// Why the run stopped before its end; `None` when it did not.
    pub fn stopped(&self) -> Option<&str> {
        let text = |place: &str| self.summary.pointer(place).and_then(serde_json::Value::as_str);
        (text("/verdict") != Some("completed")).then(|| text("/reason").unwrap_or("no reason given"))
    }

    /// Fluid particles lost.
    pub fn lost(&self) -> f64 {
        self.summary.pointer("/fluid/counts/lost").and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN)
    }
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|e| format!("`{}` cannot be written: {e}", path.display()))
}
