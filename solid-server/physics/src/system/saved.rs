//! The solids' state as named arrays, and back.

use sph::coupling::saved::{RestoreError, SavedState};
use sph::space::Vector;

use crate::contact::friction::{Owner, TangentialSprings};
use crate::particles::variables::{Particles, RigidState};
use crate::system::model::SolidModel;
use crate::system::state::{BodyContact, LastStage, SolidState, StageMaxima};

/// Neighbour list builds and the largest set of interface particles, for reports.
pub const HISTORY: &str = "solid.history";

/// Owner of a saved tangential spring that stands for the walls.
const WALLS: u32 = u32::MAX;

/// The tangential springs that were saved.
fn restored_springs(saved: &SavedState) -> Result<TangentialSprings, RestoreError> {
    let [time] = saved.numbers("solid.slips.time")?;
    let springs = saved.f64s("solid.slips.slip", None)?;
    let particles = saved.u32s("solid.slips.particle", Some(springs.len()))?;
    let owners = saved.u32s("solid.slips.owner", Some(springs.len()))?;
    let owner = |of: u32| if of == WALLS { Owner::Walls } else { Owner::Body(of) };
    let keys = particles.iter().zip(owners).map(|(particle, of)| (*particle, owner(*of)));
    let entries: Vec<_> = keys.zip(springs.iter().copied()).collect();
    if entries.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
        return Err(RestoreError::new("solid.slips.particle", "contacts must ascend, each once"));
    }
    Ok(TangentialSprings { time, entries })
}

impl SolidState {
    /// Saves all of it. Lists are no part: their rows ascend by index, so that no sum depends on when they were built.
    pub fn save(&self, saved: &mut SavedState) {
        let Self { particles, rigid, image_counts, angles, springs, last } = self;
        saved.put_quantities("solid.position", &particles.position);
        saved.put_quantities("solid.velocity", &particles.velocity);
        saved.put_f64("solid.density", particles.density.iter().copied());
        saved.put_quantities("solid.deviatoric_stress", &particles.deviatoric_stress);
        let motion = |r: &RigidState| {
            [r.centre.x, r.centre.y, r.velocity.x, r.velocity.y, r.angle, r.angular_velocity]
        };
        saved.put_f64("solid.rigid", rigid.iter().flat_map(motion));
        saved.put_u32("solid.windings", image_counts.iter().flatten().map(|w| w.cast_unsigned()));
        saved.put_f64("solid.angles", angles.iter().copied());
        saved.put_quantities("solid.last.fluid_force", &last.fluid_force);
        let reactions: Vec<Vector> = last.reactions.iter().flatten().copied().collect();
        saved.put_quantities("solid.last.reactions", &reactions);
        let maxima = &last.maxima;
        let judged = [maxima.largest_acceleration, maxima.contact_frequency, maxima.tangent_stiffness_ratio];
        saved.put_f64("solid.last.judged", judged);
        saved.put_u64("solid.last.outside", [last.outside]);
        saved.put_u64("solid.last.substeps", [last.substeps]);
        let contact = |c: &BodyContact| [c.bodies.x, c.bodies.y, c.walls.x, c.walls.y, c.deepest, c.impulse];
        saved.put_f64("solid.last.contacts", last.contacts.iter().flat_map(contact));
        saved.put_f64("solid.slips.time", [springs.time]);
        saved.put_u32("solid.slips.particle", springs.entries.iter().map(|((particle, _), _)| *particle));
        let owner = |owner: Owner| match owner {
            Owner::Body(body) => body,
            Owner::Walls => WALLS,
        };
        saved.put_u32("solid.slips.owner", springs.entries.iter().map(|((_, of), _)| owner(*of)));
        saved.put_f64("solid.slips.slip", springs.entries.iter().map(|(_, slip)| *slip));
    }

    /// The state of a run of `model` that was saved; `start`, the state at its start, gives the array lengths.
    ///
    /// # Errors
    /// When arrays do not fit each other or the model.
    pub fn restored(model: &SolidModel, start: &Self, saved: &SavedState) -> Result<Self, RestoreError> {
        let n = model.len();
        let motion = |r: &[f64]| RigidState {
            centre: Vector::new(r[0], r[1]),
            velocity: Vector::new(r[2], r[3]),
            angle: r[4],
            angular_velocity: r[5],
        };
        let rigid = saved.f64s("solid.rigid", start.rigid.len().checked_mul(6))?;
        let image_counts = saved.u32s("solid.windings", n.checked_mul(2))?;
        let counts: Vec<usize> = start.last.reactions.iter().map(Vec::len).collect();
        let mut reactions = saved.quantities("solid.last.reactions", counts.iter().sum())?.into_iter();
        let [largest_acceleration, contact_frequency, tangent_stiffness_ratio] =
            saved.numbers("solid.last.judged")?;
        let [outside] = saved.u64s("solid.last.outside")?;
        let [substeps] = saved.u64s("solid.last.substeps")?;
        let contact = |c: &[f64]| BodyContact {
            bodies: Vector::new(c[0], c[1]),
            walls: Vector::new(c[2], c[3]),
            deepest: c[4],
            impulse: c[5],
        };
        let contacts = saved.f64s("solid.last.contacts", start.last.contacts.len().checked_mul(6))?;
        Ok(Self {
            springs: restored_springs(saved)?,
            particles: Particles {
                position: saved.quantities("solid.position", n)?,
                velocity: saved.quantities("solid.velocity", n)?,
                density: saved.f64s("solid.density", Some(n))?.to_vec(),
                deviatoric_stress: saved.quantities("solid.deviatoric_stress", n)?,
            },
            rigid: rigid.chunks_exact(6).map(motion).collect(),
            image_counts: image_counts
                .chunks_exact(2)
                .map(|w| [w[0].cast_signed(), w[1].cast_signed()])
                .collect(),
            angles: saved.f64s("solid.angles", Some(start.angles.len()))?.to_vec(),
            last: LastStage {
                fluid_force: saved.quantities("solid.last.fluid_force", start.last.fluid_force.len())?,
                reactions: counts.iter().map(|count| reactions.by_ref().take(*count).collect()).collect(),
                maxima: StageMaxima { largest_acceleration, contact_frequency, tangent_stiffness_ratio },
                outside,
                substeps,
                contacts: contacts.chunks_exact(6).map(contact).collect(),
            },
        })
    }
}
