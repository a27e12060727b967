//! Conversions of the partner's particles as its set-up has them.

use sph::coupling::audit::{PartnerBody, PartnerParticles};
use sph::coupling::exchange::Column;

use super::arrays::{
    index_count, pack, pack_indices, unpack_column, unpack_ids, unpack_indices_below, unpack_positive,
};
use super::{Convert, Path, WireError, list, name, not_negative, wires};
use crate::wire;

pub(super) fn partner_to_wire(particles: &PartnerParticles) -> wire::PartnerParticles {
    wire::PartnerParticles {
        ids: pack_indices(&particles.id),
        groups: pack_indices(&particles.body),
        masses_kg: pack(&particles.mass),
        positions_m: pack(&particles.position.values),
        bodies: wires(&particles.bodies),
    }
}

/// Particles of a run of `dimensions` dimensions.
pub(super) fn partner_from_wire(
    wire: &wire::PartnerParticles,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<PartnerParticles, WireError> {
    let bodies: Vec<PartnerBody> = list(&wire.bodies, at, "bodies")?;
    let count = index_count(&wire.ids, &at.field("ids"))?;
    let mut position = Column::default();
    unpack_column(&wire.positions_m, count, dimensions, &mut position, &at.field("positions_m"))?;
    Ok(PartnerParticles {
        id: unpack_ids(&wire.ids, count, &at.field("ids"))?,
        body: unpack_indices_below(&wire.groups, count, bodies.len(), "bodies", &at.field("groups"))?,
        mass: unpack_positive(&wire.masses_kg, count, &at.field("masses_kg"))?,
        position,
        bodies,
    })
}

impl Convert for PartnerBody {
    type Wire = wire::PartnerBody;

    fn to_wire(&self) -> wire::PartnerBody {
        wire::PartnerBody {
            name: self.name.clone(),
            cell_inertia_kg_m2: self.cell_inertia,
            driven: self.driven,
        }
    }

    fn from_wire(wire: &wire::PartnerBody, at: &Path<'_>) -> Result<Self, WireError> {
        let cells = at.field("cell_inertia_kg_m2");
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            cell_inertia: wire
                .cell_inertia_kg_m2
                .map(|value| not_negative(Some(value), &cells))
                .transpose()?,
            driven: wire.driven,
        })
    }
}
