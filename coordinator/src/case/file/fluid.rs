//! The fluid and its regions as a case file writes them.

use serde::Serialize;
use sph::setup::{Contradiction, Damping, FluidParameters};

use super::layout::Layout;
use super::layout::{LATTICE_ORIGIN, LAYOUT};
use super::member::LARGEST_SEED;
use super::shape::SHAPE;
use super::shape::ShapeTable;
use super::{Preset, formula};
use crate::case::errors::CaseError;
use crate::case::reader::{Allowed, At, Choice, Coordinates, Parameters, Table, Written};
use crate::case::spec::{KeySpec, Kind, SetSpec, TableSpec, Variables, Variant, Variants, key};

/// Rows of `[fluid]`.
pub static FLUID: TableSpec = TableSpec::new(
    "fluid",
    "The fluid: its parameters and where it is at the start.",
    &[
        DAMPING,
        key("region", Kind::Tables(&REGION), "water at the start, a table for each part of it")
            .or_else("none"),
    ],
)
.with_set(SetSpec::of::<FluidParameters>(&[
    (
        "acoustic_relaxation",
        "as much as steps leave room for: up to 1 with fixed steps, 0.25 with adaptive ones",
    ),
    (
        "acoustic_relaxation_time_s",
        "V/(2 S c₀), of the volume V and the area S of the faces of the fluid at the start",
    ),
    ("tension_limit_pa", "the tension at 0.9 ρ₀"),
]));

/// Row of `damping`.
pub const DAMPING: KeySpec =
    key("damping", Kind::Table(&DAMPING_TABLE), "acceleration −k v on all free particles until a time")
        .or_else("none");

static DAMPING_TABLE: TableSpec = TableSpec::new(
    "damping",
    "Acceleration −k v on all free particles until a time, to reach a state of rest.",
    &[
        key("rate_per_s", Kind::Number(Allowed::POSITIVE), "rate k"),
        key("until_s", Kind::Number(Allowed::FINITE), "time at which it ends"),
    ],
);

// Beyond half a spacing particles would change places.
const DISPLACEMENT: Allowed = Allowed::new(0.0, 0.5, (true, false), "a number from 0 to below 0.5");

/// Rows of `[[fluid.region]]`.
static REGION: TableSpec = TableSpec::new(
    "region",
    "Water at the start.",
    &[
        key("name", Kind::Name, "name of the region"),
        key("shape", Kind::Table(&SHAPE), "where the water is"),
        key("velocity_m_s", Kind::Expressions(Variables::Coordinates), "velocity at the start")
            .or_else("0 along each axis"),
        key("start", Kind::Table(&START), "pressure at the start").or_else("`{ type = \"rest\" }`"),
        key(
            "cut_by_solids",
            Kind::Flag,
            "remove particles inside solids; if false, such particles are an error",
        )
        .or_flag(true),
        key(
            "cut_by_walls",
            Kind::Flag,
            "remove particles inside walls; if false, such particles are an error",
        )
        .or_flag(true),
        LAYOUT,
        LATTICE_ORIGIN,
        key(
            "displacement_fraction",
            Kind::Number(DISPLACEMENT),
            "random displacement of the particles along each axis, at most this fraction of Δx",
        )
        .or(0.0),
        key("displacement_seed", Kind::Count(0, LARGEST_SEED), "seed of the displacement").or_count(1),
    ],
);

/// Rows of `start`.
static START: TableSpec =
    TableSpec::new("start", "Pressure and density at the start.", &[]).by(Variants::new(
        "type",
        "pressure at the start",
        &[
            Variant::new("rest", "no pressure, the rest density", &[]),
            Variant::new(
                "hydrostatic",
                "in equilibrium under its weight",
                &[
                    key(
                        "surface_m",
                        Kind::Number(Allowed::FINITE),
                        "height of the free surface, measured against gravity from the origin",
                    ),
                    key(
                        "lattice",
                        Kind::Word(&[
                            (
                                "consistent",
                                "the water is at rest: rows drawn together as the pressure requires, or, with a surface more than a spacing above the whole region, as in a full vessel, rows kept, with the mass of their pressure",
                            ),
                            ("uniform", "the rows are kept, and the column oscillates"),
                        ]),
                        "where the rows lie",
                    )
                    .or_word("consistent"),
                ],
            ),
            Variant::new(
                "pressure",
                "the pressure of an expression",
                &[
                    key("pressure_pa", Kind::Expression(Variables::Coordinates), "pressure").or(0.0),
                    key(
                        "particle_mass",
                        Kind::Word(&[
                            (
                                "from-density",
                                "the masses fill the lattice cells at the density of the pressure",
                            ),
                            ("rest", "all particles have ρ₀ Δx², in space ρ₀ Δx³"),
                        ]),
                        "masses of the particles",
                    )
                    .or_word("from-density"),
                ],
            ),
        ],
    ));

/// `[fluid]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct FluidTable {
    #[serde(flatten)]
    pub parameters: Parameters<FluidParameters>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping: Option<DampingTable>,
    #[serde(rename = "region")]
    pub regions: Vec<RegionTable>,
    /// Whether the strength of the acoustic relaxation is left to the room that the time step leaves.
    #[serde(skip)]
    pub takes_relaxation_of_step: bool,
    #[serde(skip)]
    pub intact: bool,
}

sph::constants! {
    /// No flow that a weakly compressible fluid stands for gets there. Eq. (3) bears hardly more tension below, so that what
    /// tears beside an edge would stretch without bound.
    const LEAST_DENSITY: f64 = 0.9, "density.least_without_cavities",
        "density below which cavities open where a case sets no limit of tension, over that at rest [-]";
}

impl FluidTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>, preset: Preset) -> Self {
        let mut parameters = table.parameters(preset.values::<FluidParameters>(), &[]);
        let takes_relaxation_of_step =
            !table.has("acoustic_relaxation") && parameters.acoustic_relaxation > 0.0;
        if let Some(Contradiction { key, problem, hint }) = parameters.contradiction_of_forms() {
            table.error(CaseError::new(&table.place_of(key), problem).hint(hint));
        }
        let damping = DampingTable::read(&mut table);
        let intact = table.intact();
        if intact && parameters.tension_limit.is_none() {
            let fluid = FluidParameters { background_pressure: 0.0, ..parameters.values() };
            let tension = -fluid.equation_of_state().pressure(LEAST_DENSITY * fluid.rest_density);
            parameters.derive(|parameters| parameters.tension_limit = Some(tension));
        }
        let regions = table.tables("region").into_iter().map(RegionTable::read).collect();
        table.finish();
        Self { parameters, damping, regions, takes_relaxation_of_step, intact }
    }

    /// Whether spacing and kernel ratio can be relied on.
    pub fn lattice_intact(&self) -> bool {
        ["particle_spacing_m", "kernel_ratio"].into_iter().all(|key| self.parameters.is_sound(key))
    }

    /// Particle spacing Δx \[m\] with its place.
    pub fn spacing(&self) -> At<f64> {
        At { value: self.parameters.particle_spacing, place: self.parameters.place("particle_spacing_m") }
    }
}

/// `damping`: −k v on all free particles of one side until a time.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct DampingTable {
    pub rate_per_s: f64,
    pub until_s: f64,
}

impl DampingTable {
    /// Reads `damping`, which may be left out.
    pub fn read(parent: &mut Table<'_>) -> Option<Self> {
        let mut table = parent.optional_table("damping")?;
        let read =
            Self { rate_per_s: table.number("rate_per_s").value, until_s: table.number("until_s").value };
        table.finish();
        Some(read)
    }

    /// Set-up of the solvers.
    pub fn to_setup(&self) -> Damping {
        Damping { rate: self.rate_per_s, until: self.until_s }
    }
}

/// `[[fluid.region]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct RegionTable {
    pub name: At<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    /// Expressions of the coordinates.
    pub velocity_m_s: Vec<At<Written>>,
    pub start: StartTable,
    /// Particles that would overlap a solid or a wall are left out; otherwise an overlap is an error.
    pub cut_by_solids: bool,
    pub cut_by_walls: bool,
    pub layout: Choice<Layout>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice_origin_m: Option<At<Coordinates>>,
    /// Largest random displacement along each axis as a fraction of the spacing.
    pub displacement_fraction: f64,
    pub displacement_seed: u64,
    #[serde(skip)]
    pub intact: bool,
}

/// Pressure and density at the start.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum StartTable {
    /// p = 0, rest density.
    Rest,
    /// p = ρ₀g·depth below a level.
    Hydrostatic {
        /// Height of the free surface, measured against gravity.
        surface_m: f64,
        lattice: Choice<HydrostaticLattice>,
    },
    /// Pressure by an expression of the coordinates.
    Pressure { pressure_pa: At<Written>, particle_mass: Choice<ParticleMass> },
}

/// Where the particles of a hydrostatic start lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HydrostaticLattice {
    /// Rows drawn together by ρ₀/ρ, all particles with rest mass, pressure as the kernel sums balance it: at rest. Water that its
    /// surface lies above stays in its place, with the mass of its pressure.
    Consistent,
    /// The lattice of a region at rest: particles' volumes do not fill it, and the start rings.
    Uniform,
}

/// Mass of particles that start under pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParticleMass {
    /// ρ Δx²: every particle fills its lattice cell.
    FromDensity,
    /// ρ₀ Δx².
    Rest,
}

#[derive(Clone, Copy)]
enum StartKind {
    Rest,
    Hydrostatic,
    Pressure,
}

impl RegionTable {
    fn read(mut table: Table<'_>) -> Self {
        let name = table.name("name");
        let shape = ShapeTable::read(&mut table, "shape");
        let dimensions = table.dimensions;
        let velocity_m_s = formula::read_components(&mut table, "velocity_m_s")
            .unwrap_or_else(|| formula::zeros(dimensions, &table.place_of("velocity_m_s")));
        let start = StartTable::read(&mut table);
        let cut_by_solids = table.flag("cut_by_solids");
        let cut_by_walls = table.flag("cut_by_walls");
        let layout = Layout::read(&mut table);
        let lattice_origin_m = table.optional_vector("lattice_origin_m");
        let displacement_fraction = table.number("displacement_fraction").value;
        let displacement_seed = table.count("displacement_seed").value;
        Self {
            name,
            shape,
            velocity_m_s,
            start,
            cut_by_solids,
            cut_by_walls,
            layout,
            lattice_origin_m,
            displacement_fraction,
            displacement_seed,
            intact: table.finish(),
        }
    }
}

impl StartTable {
    fn read(parent: &mut Table<'_>) -> Self {
        let Some(mut table) = parent.optional_table("start") else { return Self::Rest };
        let kinds = [
            ("rest", StartKind::Rest),
            ("hydrostatic", StartKind::Hydrostatic),
            ("pressure", StartKind::Pressure),
        ];
        let read = match table.choice("type", &kinds).map(|choice| choice.value) {
            Some(StartKind::Hydrostatic) => Self::Hydrostatic {
                surface_m: table.number("surface_m").value,
                lattice: table.choice_or_default(
                    "lattice",
                    &[
                        ("consistent", HydrostaticLattice::Consistent),
                        ("uniform", HydrostaticLattice::Uniform),
                    ],
                ),
            },
            Some(StartKind::Pressure) => Self::Pressure {
                pressure_pa: formula::read(&mut table, "pressure_pa"),
                particle_mass: table.choice_or_default(
                    "particle_mass",
                    &[("from-density", ParticleMass::FromDensity), ("rest", ParticleMass::Rest)],
                ),
            },
            Some(StartKind::Rest) => Self::Rest,
            None => {
                table.abandon();
                Self::Rest
            }
        };
        table.finish();
        read
    }
}
