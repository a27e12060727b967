//! Probes as a case file writes them.

use serde::Serialize;
use sph::space::Vector;

use crate::case::reader::{Allowed, At, Choice, Table};

/// `[[probe]]`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs)]
pub struct ProbeTable {
    pub name: At<String>,
    #[serde(rename = "type")]
    pub kind: Choice<ProbeKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_m: Option<At<Vector>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x_m: Option<At<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<At<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall: Option<At<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<At<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support: Option<At<String>>,
    #[serde(skip)]
    pub intact: bool,
}

/// What a probe reports; see [`sph::setup::FluidProbeKind`] and [`sph::setup::SolidProbeKind`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeKind {
    /// Pressure and velocity at a point.
    FluidPoint,
    /// Highest water at an x.
    WaterLevel,
    /// Foremost x of the connected fluid.
    Front,
    /// Sums over a region or all fluid.
    FluidSums,
    /// Force of the fluid on a wall.
    WallForce,
    /// Fluid particles inside solids.
    Immersed,
    /// Displacement, velocity and stress of a material point.
    MaterialPoint,
    /// Centre of mass, velocity and angle of a body.
    BodyMotion,
    /// Force of the fluid on a body.
    BodyForce,
    /// Reaction of a support.
    SupportReaction,
    /// Sums over a body or all solids.
    BodySums,
    /// Smallest distance of a body, or any, to others and to walls.
    Gap,
    /// Forces, penetration and impulse of contact.
    Contact,
}

/// Words for the kinds.
pub const KINDS: [(&str, ProbeKind); 13] = [
    ("fluid-point", ProbeKind::FluidPoint),
    ("water-level", ProbeKind::WaterLevel),
    ("front", ProbeKind::Front),
    ("fluid-sums", ProbeKind::FluidSums),
    ("wall-force", ProbeKind::WallForce),
    ("immersed-fluid", ProbeKind::Immersed),
    ("material-point", ProbeKind::MaterialPoint),
    ("body-motion", ProbeKind::BodyMotion),
    ("body-force", ProbeKind::BodyForce),
    ("support-reaction", ProbeKind::SupportReaction),
    ("body-sums", ProbeKind::BodySums),
    ("gap", ProbeKind::Gap),
    ("contact", ProbeKind::Contact),
];

impl ProbeKind {
    /// Whether the fluid solver reports it; the solid solver does otherwise.
    pub fn of_fluid(self) -> bool {
        matches!(
            self,
            Self::FluidPoint
                | Self::WaterLevel
                | Self::Front
                | Self::FluidSums
                | Self::WallForce
                | Self::Immersed
        )
    }
}

impl ProbeTable {
    /// Reads the table; `None` when its type is wrong.
    pub fn read(mut table: Table<'_>) -> Option<Self> {
        let name = table.name("name");
        let Some(kind) = table.choice("type", &KINDS) else {
            table.abandon();
            table.finish();
            return None;
        };
        let (mut at_m, mut x_m, mut region, mut wall, mut body, mut support) =
            (None, None, None, None, None, None);
        match kind.value {
            ProbeKind::FluidPoint => at_m = Some(table.vector("at_m")),
            ProbeKind::WaterLevel => x_m = Some(table.number("x_m", &Allowed::FINITE)),
            ProbeKind::Front | ProbeKind::Immersed => {}
            ProbeKind::FluidSums => region = table.optional_name("region"),
            ProbeKind::WallForce => wall = Some(table.name("wall")),
            ProbeKind::MaterialPoint => (body, at_m) = (Some(table.name("body")), Some(table.vector("at_m"))),
            ProbeKind::BodyMotion | ProbeKind::BodyForce => body = Some(table.name("body")),
            ProbeKind::SupportReaction => {
                (body, support) = (Some(table.name("body")), Some(table.name("support")));
            }
            ProbeKind::BodySums | ProbeKind::Gap | ProbeKind::Contact => body = table.optional_name("body"),
        }
        Some(Self { name, kind, at_m, x_m, region, wall, body, support, intact: table.finish() })
    }
}
