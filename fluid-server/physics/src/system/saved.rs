//! The checkpoint form of the state: named arrays.

use sph::coupling::ledger::EnergyTally;
use sph::coupling::saved::{RestoreError, SavedState};
use sph::space::Space;
use sph::space::components::Components;

use super::list_limits::{Skins, skins};
use super::model::FluidModel;
use super::state::{FluidState, ListOrigin};
use crate::time::step_control::StepControl;

/// Figures of the interface for reports: see `FluidInterface::history`.
pub const INTERFACE: &str = "fluid.interface";

impl<S: Space> FluidState<S> {
    /// Saves all of it.
    pub fn save(&self, saved: &mut SavedState) {
        let Self {
            id,
            region,
            mass,
            position,
            velocity,
            density,
            list_origin,
            density_rate,
            density_correction,
            acceleration,
            relaxation,
            volume_excess,
            ..
        } = self;
        saved.put_u32("fluid.id", id.iter().copied());
        saved.put_u32("fluid.region", region.iter().copied());
        saved.put_f64("fluid.mass", mass.iter().copied());
        saved.put_quantities("fluid.position", position);
        saved.put_quantities("fluid.velocity", velocity);
        saved.put_f64("fluid.density", density.iter().copied());
        saved.put_f64("fluid.list_skin", [self.list_skin]);
        if let Some(origin) = list_origin {
            saved.put_f64("fluid.list_origin.time", [origin.time]);
            saved.put_quantities("fluid.list_origin.position", &origin.position);
        }
        let mut last_step = self.removed_momentum.row().as_ref().to_vec();
        last_step.extend_from_slice(self.removed_angular_momentum.row().as_ref());
        last_step.extend([self.largest_acceleration, self.density_age]);
        saved.put_f64("fluid.last_step", last_step);
        saved.put_f64("fluid.density_rate", density_rate.iter().copied());
        saved.put_f64("fluid.density_correction", density_correction.iter().copied());
        saved.put_quantities("fluid.acceleration", acceleration);
        if !relaxation.is_empty() {
            saved.put_f64("fluid.relaxation", relaxation.iter().copied());
        }
        if !volume_excess.is_empty() {
            saved.put_f64("fluid.volume_excess", volume_excess.iter().copied());
        }
        self.energy.save("fluid.energy", saved);
        self.control.save("fluid.step_control", saved);
        saved.put_u64("fluid.counts", [self.escaped, self.outflow, self.list_builds]);
    }

    /// The state of a run of `model` that was saved.
    ///
    /// # Errors
    /// When arrays do not fit each other or the model.
    pub fn restored(model: &FluidModel<S>, saved: &SavedState) -> Result<Self, RestoreError> {
        let id = saved.u32s("fluid.id", None)?;
        let n = id.len();
        let mut sorted = id.to_vec();
        sorted.sort_unstable();
        if sorted.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(RestoreError::new("fluid.id", "names a particle twice"));
        }
        if sorted.last().is_some_and(|last| *last >= model.first_wall_id) {
            let problem = format!("names a particle beyond the {} of the case", model.first_wall_id);
            return Err(RestoreError::new("fluid.id", problem));
        }
        let region = saved.u32s("fluid.region", Some(n))?;
        if region.iter().any(|region| usize::try_from(*region).is_ok_and(|k| k >= model.regions.len())) {
            let problem = format!("names a region beyond the {} of the case", model.regions.len());
            return Err(RestoreError::new("fluid.region", problem));
        }
        let positive = |name: &str| -> Result<Vec<f64>, RestoreError> {
            let values = saved.f64s(name, Some(n))?;
            match values.iter().find(|value| **value <= 0.0) {
                Some(value) => Err(RestoreError::new(name, format!("holds {value}, must be positive"))),
                None => Ok(values.to_vec()),
            }
        };
        let list_origin = match saved.has("fluid.list_origin.time") {
            true => {
                let [time] = saved.numbers("fluid.list_origin.time")?;
                Some(ListOrigin { time, position: saved.quantities("fluid.list_origin.position", n)? })
            }
            false => None,
        };
        let [list_skin] = saved.numbers("fluid.list_skin")?;
        let Skins { thinnest, thickest, .. } = skins::<S>(model.constants.particle_spacing);
        if !(thinnest..=thickest).contains(&list_skin) {
            let problem = format!("holds {list_skin} m, must lie between {thinnest} and {thickest} m");
            return Err(RestoreError::new("fluid.list_skin", problem));
        }
        let removed_numbers = S::DIMENSIONS + S::Spin::COUNT;
        let last_step = saved.f64s("fluid.last_step", Some(removed_numbers + 2))?;
        let (momentum, angular_momentum) = last_step[..removed_numbers].split_at(S::DIMENSIONS);
        let (largest_acceleration, density_age) =
            (last_step[removed_numbers], last_step[removed_numbers + 1]);
        if density_age < 0.0 {
            return Err(RestoreError::new(
                "fluid.last_step",
                format!("holds a negative time, {density_age} s"),
            ));
        }
        let kept = if model.is_leapfrog() { n } else { 0 };
        let relaxation = match model.acoustic_relaxation {
            Some(_) => saved.f64s("fluid.relaxation", Some(n))?.to_vec(),
            None => Vec::new(),
        };
        let volume_excess = match model.corrects_volume() {
            true => saved.f64s("fluid.volume_excess", Some(n))?.to_vec(),
            false => Vec::new(),
        };
        let [escaped, outflow, list_builds] = saved.u64s("fluid.counts")?;
        Ok(Self {
            order: Vec::new(),
            others: 0,
            id: id.to_vec(),
            region: region.to_vec(),
            mass: positive("fluid.mass")?,
            position: saved.quantities("fluid.position", n)?,
            velocity: saved.quantities("fluid.velocity", n)?,
            density: positive("fluid.density")?,
            list_origin,
            list_skin,
            removed_momentum: S::Vector::of_row(momentum).unwrap_or_default(),
            removed_angular_momentum: S::Spin::of_row(angular_momentum).unwrap_or_default(),
            largest_acceleration,
            density_rate: saved.f64s("fluid.density_rate", Some(kept))?.to_vec(),
            density_correction: saved.f64s("fluid.density_correction", Some(kept))?.to_vec(),
            acceleration: saved.quantities("fluid.acceleration", kept)?,
            density_age,
            relaxation,
            volume_excess,
            energy: EnergyTally::restored("fluid.energy", saved)?,
            control: StepControl::restored("fluid.step_control", saved)?,
            escaped,
            outflow,
            list_builds,
        })
    }
}
