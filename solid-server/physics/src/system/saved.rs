//! The solids' state as named arrays, and back.

use sph::coupling::ledger::EnergyTally;
use sph::coupling::saved::{RestoreError, SavedState};

use crate::contact::friction::{Owner, TangentialSprings};
use crate::particles::variables::{Particles, RigidState};
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::{BodyContact, LastStage, SolidState, StageMaxima};

/// Neighbour list builds and the largest set of interface particles, for reports.
pub const HISTORY: &str = "solid.history";

/// Owner of a saved tangential spring that stands for the walls.
const WALLS: u32 = u32::MAX;

/// The tangential springs that were saved.
fn restored_springs<S: SolidSpace>(saved: &SavedState) -> Result<TangentialSprings<S>, RestoreError> {
    let [time] = saved.numbers("solid.springs.time")?;
    let particles = saved.u32s("solid.springs.particle", None)?;
    let owners = saved.u32s("solid.springs.owner", Some(particles.len()))?;
    let elongations: Vec<S::Slide> = saved.quantities("solid.springs.elongation", particles.len())?;
    let owner = |of: u32| if of == WALLS { Owner::Walls } else { Owner::Body(of) };
    let keys = particles.iter().zip(owners).map(|(particle, of)| (*particle, owner(*of)));
    let entries: Vec<_> = keys.zip(elongations).collect();
    if entries.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
        return Err(RestoreError::new("solid.springs.particle", "contacts must ascend, each once"));
    }
    Ok(TangentialSprings { time, entries })
}

/// `part` of each of `values`.
fn each<T, C>(values: &[T], part: impl Fn(&T) -> C) -> Vec<C> {
    values.iter().map(part).collect()
}

impl<S: SolidSpace> SolidState<S> {
    /// Saves all of it. Lists are no part: their rows ascend by index, so that no sum depends on when they were built.
    pub fn save(&self, saved: &mut SavedState) {
        let Self { particles, rigid, image_counts, rotations, springs, energy, last } = self;
        energy.save("solid.energy", saved);
        saved.put_quantities("solid.position", &particles.position);
        saved.put_quantities("solid.velocity", &particles.velocity);
        saved.put_quantities("solid.density", &particles.density);
        saved.put_quantities("solid.deviatoric_stress", &particles.deviatoric_stress);
        saved.put_quantities("solid.rigid.centre", &each(rigid, |body| body.centre));
        saved.put_quantities("solid.rigid.velocity", &each(rigid, |body| body.velocity));
        saved.put_quantities("solid.rigid.rotation", &each(rigid, |body| body.rotation));
        saved.put_quantities("solid.rigid.angular_velocity", &each(rigid, |body| body.angular_velocity));
        let along_axes = |count: S::Of<i32>| (0..S::DIMENSIONS).map(move |axis| count[axis].cast_unsigned());
        saved.put_u32("solid.image_counts", image_counts.iter().copied().flat_map(along_axes));
        saved.put_quantities("solid.rotations", rotations);
        saved.put_quantities("solid.last.fluid_force", &last.fluid_force);
        saved.put_quantities("solid.last.reactions", &last.reactions.concat());
        let StageMaxima { largest_acceleration, contact_frequency, tangent_stiffness_ratio } = last.maxima;
        saved
            .put_f64("solid.last.maxima", [largest_acceleration, contact_frequency, tangent_stiffness_ratio]);
        saved.put_u64("solid.last.outside", [last.outside]);
        saved.put_u64("solid.last.substeps", [last.substeps]);
        saved.put_quantities("solid.last.contacts.bodies", &each(&last.contacts, |contact| contact.bodies));
        saved.put_quantities("solid.last.contacts.walls", &each(&last.contacts, |contact| contact.walls));
        saved.put_quantities("solid.last.contacts.deepest", &each(&last.contacts, |contact| contact.deepest));
        saved.put_quantities("solid.last.contacts.impulse", &each(&last.contacts, |contact| contact.impulse));
        saved.put_f64("solid.springs.time", [springs.time]);
        saved.put_u32("solid.springs.particle", springs.entries.iter().map(|((particle, _), _)| *particle));
        let owner = |owner: Owner| match owner {
            Owner::Body(body) => body,
            Owner::Walls => WALLS,
        };
        saved.put_u32("solid.springs.owner", springs.entries.iter().map(|((_, of), _)| owner(*of)));
        saved.put_quantities(
            "solid.springs.elongation",
            &each(&springs.entries, |(_, elongation)| *elongation),
        );
    }

    /// The state of a run of `model` that was saved; `start`, the state at its start, gives the array lengths.
    ///
    /// # Errors
    /// When arrays do not fit each other or the model.
    pub fn restored(model: &SolidModel<S>, start: &Self, saved: &SavedState) -> Result<Self, RestoreError> {
        let (n, bodies) = (model.len(), model.bodies.len());
        let centre = saved.quantities("solid.rigid.centre", bodies)?;
        let velocity = saved.quantities("solid.rigid.velocity", bodies)?;
        let rotation = saved.quantities("solid.rigid.rotation", bodies)?;
        let angular_velocity = saved.quantities("solid.rigid.angular_velocity", bodies)?;
        let rigid = |k: usize| RigidState {
            centre: centre[k],
            velocity: velocity[k],
            rotation: rotation[k],
            angular_velocity: angular_velocity[k],
        };
        let image_counts = saved.u32s("solid.image_counts", n.checked_mul(S::DIMENSIONS))?;
        let along_axes = |count: &[u32]| S::axes(|axis| count[axis].cast_signed());
        let counts: Vec<usize> = start.last.reactions.iter().map(Vec::len).collect();
        let mut reactions = saved.quantities("solid.last.reactions", counts.iter().sum())?.into_iter();
        let [largest_acceleration, contact_frequency, tangent_stiffness_ratio] =
            saved.numbers("solid.last.maxima")?;
        let [outside] = saved.u64s("solid.last.outside")?;
        let [substeps] = saved.u64s("solid.last.substeps")?;
        let of_bodies = saved.quantities("solid.last.contacts.bodies", bodies)?;
        let of_walls = saved.quantities("solid.last.contacts.walls", bodies)?;
        let deepest = saved.quantities("solid.last.contacts.deepest", bodies)?;
        let impulse = saved.quantities("solid.last.contacts.impulse", bodies)?;
        let contact = |k: usize| BodyContact {
            bodies: of_bodies[k],
            walls: of_walls[k],
            deepest: deepest[k],
            impulse: impulse[k],
        };
        Ok(Self {
            springs: restored_springs(saved)?,
            energy: EnergyTally::restored("solid.energy", saved)?,
            particles: Particles {
                position: saved.quantities("solid.position", n)?,
                velocity: saved.quantities("solid.velocity", n)?,
                density: saved.quantities("solid.density", n)?,
                deviatoric_stress: saved.quantities("solid.deviatoric_stress", n)?,
            },
            rigid: (0..bodies).map(rigid).collect(),
            image_counts: image_counts.chunks_exact(S::DIMENSIONS).map(along_axes).collect(),
            rotations: saved.quantities("solid.rotations", bodies)?,
            last: LastStage {
                fluid_force: saved.quantities("solid.last.fluid_force", bodies)?,
                reactions: counts.iter().map(|count| reactions.by_ref().take(*count).collect()).collect(),
                maxima: StageMaxima { largest_acceleration, contact_frequency, tangent_stiffness_ratio },
                outside,
                substeps,
                contacts: (0..bodies).map(contact).collect(),
            },
        })
    }
}
