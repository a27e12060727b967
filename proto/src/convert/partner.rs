//! Conversions of the partner's particles as its set-up has them.

use sph::coupling::audit::{PartnerBody, PartnerParticles};

use super::arrays::{
    index_count, pack, pack_indices, unpack, unpack_ids, unpack_indices_below, unpack_positive,
};
use super::{Convert, Path, WireError, list, name, not_negative, wires};
use crate::wire;

impl Convert for PartnerParticles {
    type Wire = wire::PartnerParticles;

    fn to_wire(&self) -> wire::PartnerParticles {
        wire::PartnerParticles {
            ids: pack_indices(&self.id),
            groups: pack_indices(&self.body),
            masses_kg: pack(&self.mass),
            positions_m: pack(&self.position),
            bodies: wires(&self.bodies),
        }
    }

    fn from_wire(wire: &wire::PartnerParticles, at: &Path<'_>) -> Result<Self, WireError> {
        let bodies: Vec<PartnerBody> = list(&wire.bodies, at, "bodies")?;
        let count = index_count(&wire.ids, &at.field("ids"))?;
        Ok(Self {
            id: unpack_ids(&wire.ids, count, &at.field("ids"))?,
            body: unpack_indices_below(&wire.groups, count, bodies.len(), "bodies", &at.field("groups"))?,
            mass: unpack_positive(&wire.masses_kg, count, &at.field("masses_kg"))?,
            position: unpack(&wire.positions_m, count, &at.field("positions_m"))?,
            bodies,
        })
    }
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
