//! Walls as a case file writes them.

use serde::Serialize;
use sph::setup::WallCondition;
use sph::space::Space;

use super::layout::Layout;
use super::layout::{LATTICE_ORIGIN, LAYOUT};
use super::run::{MOTION, SIDE_WORDS};
use super::run::{MotionTable, Side, sides};
use super::shape::SHAPE;
use super::shape::ShapeTable;
use crate::case::reader::{At, Choice, Coordinates, Table};
use crate::case::spec::{Kind, TableSpec, Variant, Variants, key};
use sph::setup::Allowed;

/// Rows of `[[wall]]`.
pub static WALL: TableSpec = TableSpec::new(
    "wall",
    "A wall: particles that do not move, or as prescribed.",
    &[
        key("name", Kind::Name, "name of the wall"),
        key("layers", Kind::Count(1, 100), "number of particle layers")
            .or_else("the support of the widest kernel, plus one"),
        LAYOUT,
        LATTICE_ORIGIN,
        key(
            "condition",
            Kind::Word(&[
                ("slip", "the fluid slides along it"),
                ("no-slip", "the fluid has the velocity of the wall at its face"),
            ]),
            "how the fluid flows along the wall",
        )
        .or_word("slip"),
        key("motion", Kind::Table(&MOTION), "prescribed motion").or_else("at rest"),
        key("release_time_s", Kind::Number(Allowed::FINITE), "time at which the wall is removed")
            .or_else("never"),
    ],
)
.by(Variants::new(
    "type",
    "where the particles of the wall lie",
    &[
        Variant::new(
            "container",
            "layers around the outside of a shape",
            &[
                key("shape", Kind::Table(&SHAPE), "inside of the container").or_else("the domain"),
                key(
                    "open_sides",
                    Kind::SomeWords(SIDE_WORDS),
                    "sides without a wall; where the shape reaches a periodic side of the domain it is open",
                )
                .or_else("`[]`"),
            ],
        ),
        Variant::new(
            "solid",
            "the outer layers inside a shape, at least three spacings thick",
            &[key("shape", Kind::Table(&SHAPE), "the wall itself")],
        ),
    ],
));

/// `[[wall]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct WallTable {
    pub name: At<String>,
    #[serde(rename = "type")]
    pub kind: Choice<WallKind>,
    /// Inside of a container, by default the domain; the body of a solid wall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<At<ShapeTable>>,
    /// Sides of a container without a wall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open_sides: Option<Vec<Choice<Side>>>,
    /// Rows of particles; by default enough for the widest kernel and one more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<u64>,
    pub layout: Choice<Layout>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice_origin_m: Option<At<Coordinates>>,
    pub condition: Choice<WallCondition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub release_time_s: Option<f64>,
    #[serde(skip)]
    pub intact: bool,
}

/// Where the particles of a wall lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallKind {
    /// In layers around the outside of a shape.
    Container,
    /// Inside a shape.
    Solid,
}

impl WallTable {
    /// Reads the table.
    pub fn read(mut table: Table<'_>) -> Self {
        let kinds = [("container", WallKind::Container), ("solid", WallKind::Solid)];
        let name = table.name("name");
        let found = table.choice("type", &kinds);
        let kind = found.unwrap_or_else(|| {
            table.abandon();
            Choice { word: "container", value: WallKind::Container, place: table.place_of("type") }
        });
        let dimensions = table.dimensions;
        let (shape, open_sides) = match kind.value {
            WallKind::Container => (
                ShapeTable::read_optional(&mut table, "shape"),
                Some(table.words("open_sides", sides(dimensions)).unwrap_or_default()),
            ),
            WallKind::Solid => (ShapeTable::read(&mut table, "shape"), None),
        };
        let layers = table.optional_count("layers");
        let layout = Layout::read(&mut table);
        let lattice_origin_m = table.optional_vector("lattice_origin_m");
        let condition = table.choice_or_default(
            "condition",
            &[("slip", WallCondition::Slip), ("no-slip", WallCondition::NoSlip)],
        );
        let motion = MotionTable::read(&mut table);
        let release_time_s = table.optional_number("release_time_s");
        Self {
            name,
            kind,
            shape,
            open_sides,
            layers,
            layout,
            lattice_origin_m,
            condition,
            motion,
            release_time_s,
            intact: table.finish(),
        }
    }

    /// Set-up of the solvers.
    pub fn to_setup<S: Space>(&self) -> sph::setup::WallSetup<S> {
        sph::setup::WallSetup {
            name: self.name.value.clone(),
            condition: self.condition.value,
            motion: self.motion.as_ref().map(MotionTable::to_setup::<S>),
            release_time: self.release_time_s,
        }
    }
}
