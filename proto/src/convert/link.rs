//! What a participant learns of its partner. The number of dimensions comes from the run.

use sph::coupling::exchange::{Column, Extent};

use super::arrays::{pack, unpack_all};
use super::partner::{partner_from_wire, partner_to_wire};
use super::{Path, WireError, length, name, positive_or_infinite};
use crate::description::{LinkPlan, Partner};
use crate::limits::MAX_BOXES;
use crate::wire;

pub(crate) fn extent_to_wire(extent: &Extent) -> wire::Extent {
    wire::Extent { version: extent.version, boxes_m: pack(&extent.boxes.values) }
}

/// An extent of a run of `dimensions` dimensions.
pub(crate) fn extent_from_wire(
    wire: &Option<wire::Extent>,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<Extent, WireError> {
    let Some(wire) = wire else { return Err(at.error("is missing")) };
    let at = at.field("boxes_m");
    let (components, bytes) = (2 * dimensions, wire.boxes_m.len());
    if !bytes.is_multiple_of(8 * components) {
        let problem = format!(
            "has {bytes} bytes, must have {} for each box in a run of {dimensions} dimensions",
            8 * components
        );
        return Err(at.error(problem));
    }
    length(bytes / (8 * components), MAX_BOXES, &at)?;
    if bytes == 0 {
        return Ok(Extent { version: wire.version, ..Extent::default() });
    }
    let boxes = Column { components, values: unpack_all(&wire.boxes_m, &at)? };
    for (k, corners) in boxes.rows().enumerate() {
        let (lower, upper) = corners.split_at(dimensions);
        let ordered = lower.iter().zip(upper).all(|(lower, upper)| lower <= upper);
        if !(ordered && corners.iter().all(|value| value.is_finite())) {
            let problem = format!("of box number {k} are {corners:?}, must be finite with lower <= upper");
            return Err(at.error(problem));
        }
    }
    Ok(Extent { version: wire.version, boxes })
}

/// A link request belongs to a run, which the caller names.
pub(crate) fn link_to_wire(plan: &LinkPlan) -> wire::LinkRequest {
    use wire::link_request::Partner as Wire;
    let partner = match &plan.partner {
        Partner::Alone => Wire::Alone(wire::Unit {}),
        Partner::Dial(address) => Wire::Dial(address.clone()),
        Partner::Listen => Wire::Listen(wire::Unit {}),
    };
    wire::LinkRequest {
        run_id: String::new(),
        first_limit_s: Some(plan.first_limit),
        partner_extent: Some(extent_to_wire(&plan.partner_extent)),
        partner: Some(partner),
        partner_particles: plan.partner_particles.as_ref().map(partner_to_wire),
    }
}

/// What is to be known in a run of `dimensions` dimensions, whose name the caller compares.
pub(crate) fn link_from_wire(
    wire: &wire::LinkRequest,
    dimensions: usize,
    at: &Path<'_>,
) -> Result<LinkPlan, WireError> {
    use wire::link_request::Partner as Wire;
    let partner = match &wire.partner {
        Some(Wire::Alone(_)) => Partner::Alone,
        Some(Wire::Dial(address)) => Partner::Dial(name(address, &at.field("dial"))?),
        Some(Wire::Listen(_)) => Partner::Listen,
        None => return Err(at.field("partner").error("is missing, must be `alone`, `dial` or `listen`")),
    };
    let alone = partner == Partner::Alone && wire.partner_extent.is_none();
    let extent = || extent_from_wire(&wire.partner_extent, dimensions, &at.field("partner_extent"));
    let particles = at.field("partner_particles");
    Ok(LinkPlan {
        first_limit: positive_or_infinite(wire.first_limit_s, &at.field("first_limit_s"))?,
        partner_extent: if alone { Extent::default() } else { extent()? },
        partner,
        partner_particles: wire
            .partner_particles
            .as_ref()
            .map(|wire| partner_from_wire(wire, dimensions, &particles))
            .transpose()?,
    })
}
