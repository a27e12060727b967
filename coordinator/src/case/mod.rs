//! Case files: what a user writes, checked once and turned into the set-up of the solvers.
//!
//! A file is read into [`file::CaseFile`], which holds what was written with every default filled in. [`load`] lays
//! out its particles and checks everything across tables; the [`Case`] that results is never checked again.
//! All errors of a file are reported at once, see [`CaseErrors`].

mod disturbance;
mod effort;
mod errors;
pub mod file;
mod files;
pub mod forecast;
pub mod limits;
mod names;
mod notation;
mod opening;
pub mod overrides;
mod reader;
mod relaxation;
mod restart;
mod scene;
mod separation;
mod setups;
mod source;
pub mod spec;
mod steps;
mod summary;
#[cfg(test)]
pub(crate) mod tests;

use std::path::Path;

use proto::transport::security::ClientFiles;
use sph::coupling::solver::Role;
use sph::setup::OutputPlan;
use sph::shapes::Region;
use sph::space::{AnySpace, Plane, Spatial};
use sph::{in_space, map_space};

pub use errors::{CaseError, CaseErrors, Place, Position, suggest};
pub use files::LARGEST_FILE;
pub use restart::Loader;
pub use scene::{AnyScene, MOST_PARTICLES, Probes, Scene, SceneSpace};
pub use summary::{ActiveTerm, Count, Summary};

use errors::ErrorList;
use file::CaseFile;
use file::interface::FramePath;
use file::run::{Side, StepTable, sides};
use file::wall::WallKind;
use overrides::Override;
use reader::{Choice, Table};
use source::Source;

/// A case as meant: everything in it fits together.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the case.
    pub name: String,
    /// Where the servers come from.
    pub servers: Servers,
    /// What a run leaves behind.
    pub outputs: Outputs,
    /// Values that were set over the file, now or when the resolved case that it is was made.
    overrides: Vec<Override>,
    file: CaseFile,
    scene: AnyScene,
}

/// Where both servers of a run come from; of no meaning where the case has no such participant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Servers {
    /// The fluid server.
    pub fluid: Server,
    /// The solid server.
    pub solid: Server,
    /// Certificates and token for servers elsewhere.
    pub files: ClientFiles,
}

/// Where a server comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Server {
    /// The one that belongs to this program.
    #[default]
    BuiltIn,
    /// One that listens already, at HOST:PORT.
    Address(String),
    /// A program to start, with its arguments; files of the case's folder stand as full paths.
    Command(Vec<String>),
}

impl Server {
    fn from_table(address: &Option<String>, command: &Option<Vec<String>>) -> Self {
        match (address, command) {
            (Some(address), _) => Self::Address(address.clone()),
            (None, Some(command)) => Self::Command(command.clone()),
            (None, None) => Self::BuiltIn,
        }
    }
}

/// What a run leaves behind, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    /// When snapshots and probe rows are due.
    pub plan: OutputPlan,
    /// A ledger row every so many steps.
    pub ledger_every_steps: u64,
    /// Times of the pictures in the report \[s\].
    pub picture_times: Vec<f64>,
}

/// Reads and checks the case file at `path`; `final_state` reads the final states that it may start from.
///
/// # Errors
/// All errors of the file.
pub fn load(path: &Path, final_state: Loader<'_>) -> Result<Case, CaseErrors> {
    load_with(path, &[], final_state)
}

/// As [`load`], with `overrides` set over the values of the file.
///
/// # Errors
/// All errors of the file and of the overrides.
pub fn load_with(path: &Path, overrides: &[Override], final_state: Loader<'_>) -> Result<Case, CaseErrors> {
    let name = path.display().to_string();
    let text = files::read_text(path).map_err(|problem| {
        CaseErrors::unreadable(name.clone(), problem, "give the path of a case file (TOML)")
    })?;
    let directory = path.parent().unwrap_or(Path::new(""));
    read(Source::new(&text, overrides.iter().map(Override::parts)), &name, directory, final_state)
}

/// Reads and checks the text of a case file; `name` stands for it in messages, file names in it are taken from
/// `directory`, and `final_state` reads the final states that it may start from.
///
/// # Errors
/// All errors of the text.
pub fn parse(text: &str, name: &str, directory: &Path, final_state: Loader<'_>) -> Result<Case, CaseErrors> {
    read(Source::new(text, []), name, directory, final_state)
}

fn read(source: Source, name: &str, directory: &Path, final_state: Loader<'_>) -> Result<Case, CaseErrors> {
    let errors = ErrorList::default();
    match build(&source, directory, final_state, &errors) {
        Some(case) if errors.count() == 0 => Ok(case),
        _ => Err(errors.into_errors(name.to_owned(), source)),
    }
}

fn build(source: &Source, directory: &Path, final_state: Loader<'_>, errors: &ErrorList) -> Option<Case> {
    let mut document = notation::parse(source.file(), errors)?;
    overrides::apply(source, document.get_mut(), errors);
    let mut file =
        CaseFile::read(Table::root(&file::CASE, document.get_ref(), source.text(), directory, errors));
    file.fill_in_defaults();
    names::check_unique(&file, errors);
    let scene = match file.domain.dimensions() {
        2 => build_scene::<Plane>(&mut file, final_state, errors),
        _ => build_scene::<Spatial>(&mut file, final_state, errors),
    };
    let case = Case {
        name: file.name.value.clone(),
        servers: Servers {
            fluid: Server::from_table(&file.servers.fluid_address, &file.servers.fluid_command),
            solid: Server::from_table(&file.servers.solid_address, &file.servers.solid_command),
            files: file.servers.security_files(),
        },
        outputs: Outputs {
            plan: file.outputs.plan(),
            ledger_every_steps: file.outputs.ledger_every_steps,
            picture_times: file.outputs.picture_times_s.clone(),
        },
        overrides: overrides::all(source),
        file,
        scene,
    };
    case.check_time_step(errors);
    if errors.count() == 0 {
        case.check_opening(errors);
    }
    Some(case)
}

/// All particles and probes of `file`, which takes over the relaxation that fits them.
fn build_scene<S: SceneSpace>(file: &mut CaseFile, final_state: Loader<'_>, errors: &ErrorList) -> AnyScene {
    let mut scene = scene::build::<S>(file, errors);
    if errors.count() == 0 {
        restart::apply(file, &mut scene, final_state, errors);
        disturbance::apply(file, &mut scene.fluid);
    }
    file.fill_in_relaxation(&scene);
    scene.probes = names::probes(file, &scene, errors);
    S::any(scene)
}

impl CaseFile {
    /// Defaults that depend on other tables: layers of walls and sides through which particles may leave.
    fn fill_in_defaults(&mut self) {
        let layers = self.default_layers();
        for wall in &mut self.walls {
            wall.layers.get_or_insert(layers);
        }
        if self.domain.outflow_sides.is_none() {
            self.domain.outflow_sides = Some(self.open_rims());
        }
    }

    /// Spacing of wall particles \[m\]: the fluid's where there is one.
    pub fn wall_spacing(&self) -> Option<f64> {
        match (&self.fluid, &self.solid) {
            (Some(fluid), _) => fluid.lattice_intact().then_some(fluid.parameters.particle_spacing),
            (None, Some(solid)) => solid.intact.then_some(solid.particle_spacing_m.value),
            (None, None) => None,
        }
    }

    /// Layers of a wall that fill the support of the fluid's kernel; `None` without fluid.
    fn fluid_layers(&self) -> Option<f64> {
        let (fluid, spacing) = (self.fluid.as_ref()?, self.wall_spacing()?);
        Some(rows(fluid.parameters.smoothing_length(), spacing))
    }

    /// Rows that fill the widest support behind a wall, and one more for fluid in violent flow.
    fn default_layers(&self) -> u64 {
        let Some(spacing) = self.wall_spacing() else { return 3 };
        let fluid = self.fluid_layers().map_or(0.0, |layers| layers + 1.0);
        let solid = self.solid.as_ref().filter(|solid| solid.intact);
        let solid = solid.map_or(0.0, |solid| rows(solid.smoothing_length(), spacing));
        // At most 100 by the ranges of kernel ratios, unless both spacings differ widely.
        fluid.max(solid).clamp(2.0, 100.0) as u64
    }

    /// Open sides of containers that coincide with sides of the domain.
    fn open_rims(&self) -> Vec<Choice<Side>> {
        match self.domain.dimensions() {
            2 => self.open_rims_in::<Plane>(),
            _ => self.open_rims_in::<Spatial>(),
        }
    }

    fn open_rims_in<S: SceneSpace>(&self) -> Vec<Choice<Side>> {
        let domain = self.domain.domain::<S>();
        let coincides = |wall: &file::wall::WallTable, side: Side| {
            let bounds = wall.shape.as_ref().map(|shape| S::shape(&shape.value).bounds());
            let (lower, upper) = bounds.unwrap_or((domain.lower, domain.upper));
            if side.upper {
                upper[side.axis] == domain.upper[side.axis]
            } else {
                lower[side.axis] == domain.lower[side.axis]
            }
        };
        let open = |side: Side| {
            !domain.periodic[side.axis]
                && self.walls.iter().filter(|wall| wall.kind.value == WallKind::Container).any(|wall| {
                    wall.open_sides.iter().flatten().any(|choice| choice.value == side)
                        && coincides(wall, side)
                })
        };
        let sides = sides(S::DIMENSIONS).iter().copied();
        sides
            .filter(|(_, side)| open(*side))
            .map(|(word, value)| Choice { word, value, place: self.domain.lower_m.place.clone() })
            .collect()
    }
}

/// Rows of particles `spacing` \[m\] apart within the support of a kernel.
fn rows(smoothing_length: f64, spacing: f64) -> f64 {
    (2.0 * smoothing_length / spacing - 0.5).ceil()
}

impl Case {
    /// Whether the case has a participant of `role`.
    pub fn has(&self, role: Role) -> bool {
        match role {
            Role::Fluid => self.file.fluid.is_some(),
            Role::Solid => self.file.solid.is_some(),
        }
    }

    /// The written case behind this one, with every default filled in.
    pub fn file(&self) -> &CaseFile {
        &self.file
    }

    /// Number of dimensions.
    pub fn dimensions(&self) -> usize {
        self.scene.dimensions()
    }

    /// Probes of both solvers.
    pub fn probes(&self) -> AnySpace<&Probes<Plane>, &Probes<Spatial>> {
        map_space!(&self.scene, scene => &scene.probes)
    }

    /// Names of the columns of `probes.csv` that the fluid's and the solid's probes fill.
    pub fn probe_columns(&self) -> [Vec<String>; 2] {
        in_space!(&self.scene, scene => scene.probes.columns())
    }

    /// All particles at the start.
    pub(crate) fn scene(&self) -> &AnyScene {
        &self.scene
    }

    /// Whether the half-step frames go through the coordinator.
    pub fn is_relayed(&self) -> bool {
        self.file.interface.as_ref().is_some_and(|interface| interface.path.value == FramePath::Relay)
    }

    /// Lengths of the periodic directions \[m\].
    pub fn periods(&self) -> Vec<f64> {
        let domain = &self.file.domain;
        let length = |axis: usize| domain.upper_m.value[axis] - domain.lower_m.value[axis];
        (0..domain.dimensions()).filter(|axis| domain.is_periodic(*axis)).map(length).collect()
    }

    /// Particles that move, of fluid and solids.
    pub fn particles(&self) -> [usize; 2] {
        in_space!(&self.scene, scene => [scene.fluid.id.len(), scene.solid.id.len()])
    }

    /// Particles of walls.
    pub fn wall_particles(&self) -> usize {
        in_space!(&self.scene, scene => scene.walls.wall.len())
    }

    /// What decides the bits of a run: the case as resolved, without its end time, servers, checkpoints, deadlines and
    /// pictures. A run may continue from a checkpoint of the same identity.
    pub fn identity(&self) -> String {
        let mut file = self.file.clone();
        // Steps that are shortened toward pictures depend on their times; default ones are those of snapshots or the end.
        let exact = matches!(file.time.step, StepTable::Adaptive { exact_outputs: true, .. });
        let default = file.outputs.has_default_pictures(file.time.start_time_s, file.time.end_time_s.value);
        file.time.end_time_s.value = file.time.start_time_s;
        if !exact || default {
            file.outputs.picture_times_s = Vec::new();
        }
        file.servers = file::interface::ServersTable::none();
        if let Some(interface) = &mut file.interface {
            interface.path = Choice { word: "direct", value: FramePath::Direct, ..interface.path.clone() };
        }
        let text = toml::to_string(&file).unwrap_or_else(|error| format!("# {error}\n"));
        let mut kept = String::new();
        let mut leaving_out = false;
        for line in text.lines() {
            if line.starts_with('[') {
                leaving_out = matches!(line, "[checkpoint]" | "[deadlines]");
            }
            if !leaving_out {
                kept.push_str(line);
                kept.push('\n');
            }
        }
        kept
    }

    /// When checkpoints are taken and how often servers are started again.
    pub fn checkpoint(&self) -> &file::safety::CheckpointTable {
        &self.file.checkpoint
    }

    /// Longest waits for a server.
    pub fn deadlines(&self) -> proto::transport::client::Deadlines {
        let table = &self.file.deadlines;
        let seconds = std::time::Duration::from_secs_f64;
        proto::transport::client::Deadlines {
            silence: seconds(table.silence_s),
            call: seconds(table.call_s),
            open: seconds(table.open_s),
            ..Default::default()
        }
    }

    /// Least deadline of a step.
    pub fn step_deadline(&self) -> std::time::Duration {
        std::time::Duration::from_secs_f64(self.file.deadlines.step_s)
    }

    /// Longest wait for the disk to take outputs.
    pub fn disk_deadline(&self) -> std::time::Duration {
        std::time::Duration::from_secs_f64(self.file.deadlines.disk_s)
    }

    /// Values that were set over the case file, in the order in which they were set; the resolved case holds them.
    pub fn overrides(&self) -> &[Override] {
        &self.overrides
    }

    /// The resolved case with the values that were set over its file as comments at its head, as a run leaves it.
    pub fn recorded_toml(&self) -> String {
        overrides::header(&self.overrides) + &self.resolved_toml()
    }

    /// The case file with every default written out and nothing left in other files but final states and programs,
    /// which stand as full paths; it reads back as the same case.
    pub fn resolved_toml(&self) -> String {
        // The structs hold numbers, texts, lists and tables only: TOML can say all of them.
        toml::to_string(&self.file)
            .unwrap_or_else(|error| format!("# the case cannot be written out: {error}\n"))
    }
}
