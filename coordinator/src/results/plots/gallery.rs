//! Keeps the snapshots for the report during a run, and only those.

use std::collections::VecDeque;

use sph::coupling::solver::{ParticleFields, Role};

/// Both sides' particles at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairedSnapshot {
    /// Time \[s\].
    pub time: f64,
    /// The fluid and its walls.
    pub fluid: Option<ParticleFields>,
    /// The solids.
    pub solid: Option<ParticleFields>,
}

/// Keeps the snapshots nearest after each wanted time, so that memory does not grow with the run.
pub struct Pictures {
    /// Times still wanted by fluid and solid, ascending.
    wanted: [VecDeque<f64>; 2],
    kept: Vec<PairedSnapshot>,
}

impl Pictures {
    /// Pictures for the given times \[s\].
    pub fn new(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        let wanted: VecDeque<f64> = times.into();
        Self { wanted: [wanted.clone(), wanted], kept: Vec::new() }
    }

    /// Takes the next snapshot of `role`; each side sends its own in time order.
    pub fn take(&mut self, role: Role, fields: ParticleFields) {
        let wanted = &mut self.wanted[role.index()];
        // Snapshot times are decimal only up to the size of a step.
        let reached = |time: &f64| fields.time >= time - 1e-9 * time.abs();
        if !wanted.front().is_some_and(reached) {
            return;
        }
        while wanted.front().is_some_and(reached) {
            wanted.pop_front();
        }
        let time = fields.time;
        let known = self.kept.iter().position(|pair| pair.time.to_bits() == time.to_bits());
        let index = known.unwrap_or_else(|| {
            let index = self.kept.partition_point(|pair| pair.time < time);
            self.kept.insert(index, PairedSnapshot { time, fluid: None, solid: None });
            index
        });
        match role {
            Role::Fluid => self.kept[index].fluid = Some(fields),
            Role::Solid => self.kept[index].solid = Some(fields),
        }
    }

    /// Snapshots kept so far.
    pub fn kept(&self) -> &[PairedSnapshot] {
        &self.kept
    }

    /// The snapshots in time order.
    pub fn finish(self) -> Vec<PairedSnapshot> {
        self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(time: f64) -> ParticleFields {
        ParticleFields { time, ..ParticleFields::default() }
    }

    #[test]
    fn one_snapshot_is_kept_for_each_wanted_time_and_sides_are_paired() {
        let mut pictures = Pictures::new(vec![0.3, 0.0, 0.1]);
        for k in 0..=40 {
            pictures.take(Role::Fluid, snapshot(0.01 * f64::from(k)));
        }
        for k in 0..=40 {
            pictures.take(Role::Solid, snapshot(0.01 * f64::from(k)));
        }
        let times: Vec<f64> = pictures.kept.iter().map(|pair| pair.time).collect();
        assert_eq!(times.len(), 3, "{times:?}");
        assert!((times[1] - 0.1).abs() < 1e-9 && (times[2] - 0.3).abs() < 1e-9);
        assert!(pictures.kept.iter().all(|pair| pair.fluid.is_some() && pair.solid.is_some()));
    }

    #[test]
    fn a_snapshot_that_serves_two_wanted_times_is_kept_once() {
        let mut pictures = Pictures::new(vec![0.1, 0.12]);
        pictures.take(Role::Solid, snapshot(0.0));
        pictures.take(Role::Solid, snapshot(0.2));
        pictures.take(Role::Solid, snapshot(0.4));
        assert_eq!(pictures.kept.len(), 1);
        assert!(pictures.kept[0].fluid.is_none());
    }
}
