//! Laws of the fluid, tested on whole solvers.

mod arithmetic;
mod artificial_pressure;
mod artificial_viscosity;
mod conservation;
mod coupling;
mod damper;
mod departures;
mod dry_walls;
mod energy;
mod invariance;
mod lists;
mod no_slip;
mod parts;
mod relaxation;
mod reports;
mod scheme;
mod settling;
mod shifting;
mod spatial;
mod support;
mod turned;
mod voids;
mod volume;
mod volume_at_solids;
mod walls;
