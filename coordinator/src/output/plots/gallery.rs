//! Chooses the snapshots for the report while a run goes on, holding only a few of them in memory.

use std::collections::BTreeMap;

use sph::solver::{ParticleFields, Role};

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

/// Indices of about `wanted` of `times`, evenly spread, first and last among them.
pub fn choose_times(times: &[f64], wanted: usize) -> Vec<usize> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Vec::new() };
    if times.len() <= wanted {
        return (0..times.len()).collect();
    }
    if wanted <= 1 {
        return (0..wanted).map(|_| times.len() - 1).collect();
    }
    let mut chosen: Vec<usize> = (0..wanted)
        .filter_map(|k| {
            let target = first + (last - first) * k as f64 / (wanted - 1) as f64;
            let distance = |i: &usize| (times[*i] - target).abs();
            (0..times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
        .collect();
    chosen.dedup();
    chosen
}

/// Collects snapshots of both sides and thins them as they come, so that only some three times the wanted number is
/// ever held.
///
/// Held are the snapshots at evenly spread times of the planned run, and, for a run that ends early, every so many
/// of those that came.
#[derive(Debug)]
pub struct Gallery {
    wanted: usize,
    /// Planned times \[s\] that are still to come, last first.
    targets: Vec<f64>,
    /// What counts as reaching a planned time \[s\].
    tolerance: f64,
    /// Snapshots at planned times.
    pinned: Vec<usize>,
    /// Every how many of the others one is kept; doubles when too many are held.
    stride: usize,
    /// Snapshots that each side has sent.
    taken: [usize; 2],
    kept: BTreeMap<usize, PairedSnapshot>,
}

impl Gallery {
    /// A gallery of about `wanted` snapshots of a run from `start` to `end` \[s\].
    pub fn new(wanted: usize, start: f64, end: f64) -> Self {
        let wanted = wanted.max(2);
        let target = |k: usize| start + (end - start) * k as f64 / (wanted - 1) as f64;
        Self {
            wanted,
            targets: (0..wanted).rev().map(target).collect(),
            tolerance: 1e-9 * (end - start).abs(),
            pinned: Vec::new(),
            stride: 1,
            taken: [0; 2],
            kept: BTreeMap::new(),
        }
    }

    /// Takes the next snapshot of `role`; both sides send theirs in the same order.
    pub fn take(&mut self, role: Role, particles: ParticleFields) {
        let side = match role {
            Role::Fluid => 0,
            Role::Solid => 1,
        };
        let ordinal = self.taken[side];
        self.taken[side] += 1;
        if ordinal >= self.taken[1 - side] {
            self.pin(ordinal, particles.time);
        }
        let newest = self.kept.keys().next_back().copied();
        // The newest is kept whatever its number: it may be the last.
        if newest.is_none_or(|newest| ordinal >= newest) || self.lasting(ordinal) {
            let pair = self.kept.entry(ordinal).or_default();
            pair.time = particles.time;
            match role {
                Role::Fluid => pair.fluid = Some(particles),
                Role::Solid => pair.solid = Some(particles),
            }
        }
        if let Some(newest) = newest.filter(|newest| ordinal > *newest && !self.lasting(*newest)) {
            self.kept.remove(&newest);
        }
        while self.kept.len() > 2 * self.wanted + self.pinned.len() {
            self.stride *= 2;
            let mut kept = std::mem::take(&mut self.kept);
            let newest = kept.keys().next_back().copied();
            kept.retain(|ordinal, _| self.lasting(*ordinal) || Some(*ordinal) == newest);
            self.kept = kept;
        }
    }

    /// Pins `ordinal` when it is the first at or after a planned time.
    fn pin(&mut self, ordinal: usize, time: f64) {
        while self.targets.pop_if(|target| time >= *target - self.tolerance).is_some() {
            if self.pinned.last() != Some(&ordinal) {
                self.pinned.push(ordinal);
            }
        }
    }

    fn lasting(&self, ordinal: usize) -> bool {
        ordinal.is_multiple_of(self.stride) || self.pinned.contains(&ordinal)
    }

    /// The chosen snapshots in time order.
    pub fn finish(self) -> Vec<PairedSnapshot> {
        let mut pairs: Vec<PairedSnapshot> = self.kept.into_values().collect();
        let times: Vec<f64> = pairs.iter().map(|pair| pair.time).collect();
        let chosen = choose_times(&times, self.wanted);
        let mut index = 0;
        pairs.retain(|_| {
            index += 1;
            chosen.contains(&(index - 1))
        });
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_spread_evenly_with_both_ends() {
        let times: Vec<f64> = (0..=25).map(|k| 0.02 * f64::from(k)).collect();
        assert_eq!(choose_times(&times, 6), [0, 5, 10, 15, 20, 25]);
        assert_eq!(choose_times(&times[..3], 6), [0, 1, 2]);
        assert_eq!(choose_times(&[], 6), [0usize; 0]);
        assert_eq!(choose_times(&times, 1), [25]);
        // Unevenly spaced: nearest to the even times, none twice.
        assert_eq!(choose_times(&[0.0, 0.01, 0.02, 1.0], 3), [0, 2, 3]);
    }

    fn particles(k: usize) -> ParticleFields {
        ParticleFields { step: k as u64, time: k as f64, ..ParticleFields::default() }
    }

    #[test]
    fn few_are_held_and_the_last_is_always_there() {
        for count in [1usize, 2, 6, 7, 13, 26, 100, 1001] {
            // The run ends as planned, or after a tenth of its time.
            for planned in [count, 10 * count] {
                let mut gallery = Gallery::new(6, 0.0, (planned - 1) as f64);
                for k in 0..count {
                    // The fluid is one snapshot ahead of the solid.
                    gallery.take(Role::Fluid, particles(k));
                    if k > 0 {
                        gallery.take(Role::Solid, particles(k - 1));
                    }
                    assert!(gallery.kept.len() <= 19, "{}", gallery.kept.len());
                }
                gallery.take(Role::Solid, particles(count - 1));
                let chosen = gallery.finish();
                assert!(chosen.len() >= count.min(4) && chosen.len() <= 6, "{count}: {}", chosen.len());
                assert_eq!(chosen[0].time, 0.0);
                assert_eq!(chosen[chosen.len() - 1].time, (count - 1) as f64);
                for pair in &chosen {
                    let (fluid, solid) = (pair.fluid.as_ref().unwrap(), pair.solid.as_ref());
                    assert_eq!(solid.map(|s| s.step), Some(fluid.step), "{count}");
                }
            }
        }
    }

    #[test]
    fn a_run_to_its_planned_end_shows_evenly_spread_times() {
        let mut gallery = Gallery::new(6, 0.0, 0.5);
        for k in 0..=250 {
            gallery.take(
                Role::Fluid,
                ParticleFields { time: 0.002 * f64::from(k), ..ParticleFields::default() },
            );
        }
        let times: Vec<f64> = gallery.finish().iter().map(|pair| pair.time).collect();
        assert_eq!(times.len(), 6);
        for (k, time) in times.iter().enumerate() {
            assert!((time - 0.1 * k as f64).abs() < 1e-12, "{times:?}");
        }
    }
}
