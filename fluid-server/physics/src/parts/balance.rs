//! How much of the fluid each part gets, by what its particles cost.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Work of a particle beside that of its neighbours, in batches of neighbours.
pub const WORK_OF_PARTICLE: u64 = 8;

/// By how much what was measured last counts against what was measured before.
const NEWEST: f64 = 0.2;

/// By how much a part counts as slower or faster than the mean at most.
const LARGEST_SLOWNESS: f64 = 4.0;

/// By how much the largest work may exceed the mean before the parts are divided again.
const LARGEST_IMBALANCE: f64 = 0.05;

/// What a part has had to do since its lists were built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Its work, by the lengths of its lists.
    pub work: u64,
    /// Time in which it has computed \[s\]; `None` where that says nothing of its work.
    pub seconds: Option<f64>,
}

/// Largest over mean work of the parts, less one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Imbalance {
    sum: f64,
    count: u32,
    largest: f64,
}

impl Imbalance {
    fn add(&mut self, imbalance: f64) {
        self.sum += imbalance;
        self.count += 1;
        self.largest = self.largest.max(imbalance);
    }

    /// The mean of all builds of lists \[-\]; `None` before the second.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }

    /// The largest of them \[-\].
    pub fn largest(&self) -> Option<f64> {
        (self.count > 0).then_some(self.largest)
    }
}

/// What is known of the work of the parts.
///
/// The lengths of lists say at once how the work has moved. How fast each part does its work is measured where parts have cores
/// of their own, and averaged over many builds of lists, since other programs disturb it. Whatever is found, results have the
/// same bits.
#[derive(Clone, Debug, Default)]
pub struct Balance {
    /// Work of the present lists of this part.
    work: u64,
    /// How long it had computed when they were built.
    built_after: Duration,
    /// Time that each part takes for its work, over the mean of all.
    slowness: Vec<f64>,
    /// Whether the parts are to be divided again.
    is_lost: bool,
    imbalance: Imbalance,
}

impl Balance {
    /// Lists of `batches` batches for `particles` particles were built after this part had computed for `computing`.
    pub fn built(&mut self, particles: usize, batches: usize, computing: Duration) {
        self.work = batches as u64 + WORK_OF_PARTICLE * particles as u64;
        self.built_after = computing;
    }

    /// What this part has had to do with these lists, when it has computed for `computing`, if that is known.
    pub fn load(&self, computing: Option<Duration>) -> Load {
        let seconds = computing.map(|computing| computing.saturating_sub(self.built_after).as_secs_f64());
        Load { work: self.work, seconds }
    }

    /// The time that part `rank` takes for its work, over the mean of all, by the `loads` of all since the lists were built.
    pub fn slowness(&mut self, loads: &[Load], rank: usize) -> f64 {
        self.slowness.resize(loads.len(), 1.0);
        let work: u64 = loads.iter().map(|load| load.work).sum();
        if work == 0 {
            return self.slowness[rank];
        }
        // Far below 2^53.
        let (work, parts) = (work as f64, loads.len() as f64);
        let excess = |largest: f64, all: f64| largest * parts / all - 1.0;
        let largest = loads.iter().map(|load| load.work).max().unwrap_or_default();
        self.imbalance.add(excess(largest as f64, work));
        let seconds: Option<f64> = loads.iter().map(|load| load.seconds).sum();
        for (load, slowness) in loads.iter().zip(&mut self.slowness).filter(|(load, _)| load.work > 0) {
            if let (Some(own), Some(all)) = (load.seconds, seconds.filter(|seconds| *seconds > 0.0)) {
                let measured = own / all * work / load.work as f64;
                *slowness += NEWEST * (measured.clamp(1.0 / LARGEST_SLOWNESS, LARGEST_SLOWNESS) - *slowness);
            }
        }
        let costs = loads.iter().zip(&self.slowness).map(|(load, slowness)| load.work as f64 * slowness);
        let (largest, all) =
            costs.fold((0.0_f64, 0.0), |(largest, all), cost| (largest.max(cost), all + cost));
        self.is_lost = excess(largest, all) > LARGEST_IMBALANCE;
        self.slowness[rank]
    }

    /// Whether the parts are to be divided again.
    pub fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// How unequal the work of the parts was.
    pub fn imbalance(&self) -> Imbalance {
        self.imbalance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(work: u64, seconds: f64) -> Load {
        Load { work, seconds: Some(seconds) }
    }

    #[test]
    fn before_the_first_lists_nothing_is_known() {
        let mut balance = Balance::default();
        assert_eq!(balance.slowness(&[load(0, 0.0), load(0, 1.0)], 1), 1.0);
        assert!(!balance.is_lost() && balance.imbalance().mean().is_none());
    }

    #[test]
    fn balance_is_lost_by_work_and_by_time() {
        for (loads, mean, is_lost) in [
            ([load(100, 1.0), load(104, 1.04)], 104.0 / 102.0 - 1.0, false),
            // The mean is 200.
            ([load(100, 1.0), load(300, 3.0)], 0.5, true),
            // One is at least twice as slow, of which the first measurement shows a fifth.
            ([load(100, 2.0), load(100, 1.0)], 0.0, true),
        ] {
            let mut balance = Balance::default();
            balance.slowness(&loads, 0);
            assert!((balance.imbalance().mean().unwrap() - mean).abs() < 1e-12, "{loads:?}");
            assert_eq!(balance.is_lost(), is_lost, "{loads:?}");
        }
    }

    #[test]
    fn where_time_says_nothing_work_alone_decides() {
        let loads = |works: [u64; 2]| works.map(|work| Load { work, seconds: None });
        let mut balance = Balance::default();
        assert_eq!([0, 1].map(|rank| balance.slowness(&loads([100, 104]), rank)), [1.0; 2]);
        assert!(!balance.is_lost());
        balance.slowness(&loads([100, 300]), 0);
        // Once more than the mean of 200 by a half, in three builds.
        assert!(balance.is_lost() && balance.imbalance().largest() == Some(0.5));
    }

    #[test]
    fn a_slow_part_counts_as_slow_after_many_builds() {
        let mut balance = Balance::default();
        let loads = [load(100, 3.0), load(100, 1.0)];
        let mut slowness = [0.0; 2];
        for _ in 0..50 {
            slowness = [0, 1].map(|rank| balance.slowness(&loads, rank));
        }
        // The measured ratio, to what a hundred averages leave of the first guess.
        assert!((slowness[0] / slowness[1] - 3.0).abs() < 1e-6, "{slowness:?}");
    }
}
