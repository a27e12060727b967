//! The points of a sweep: all combinations, values in pairs, or a Latin hypercube.

use super::axes::{Axis, Values};
use crate::case::overrides::Override;

/// How points are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Every combination of values, the last key fastest.
    #[default]
    Grid,
    /// The first values of all keys, the second ones, and so on.
    Paired,
    /// As many points as given, each key in as many equal parts, each part once (McKay, Beckman & Conover 1979).
    Latin {
        /// Points.
        points: u32,
        /// Decides them.
        seed: u64,
    },
}

/// Most points of a sweep: each has a folder.
pub const MOST_POINTS: usize = 100_000;

/// The points of `axes`, each what it sets.
///
/// # Errors
/// When there is nothing to vary, a range has no sample, lists in pairs differ in length, or there are too many points.
pub fn points(axes: &[Axis], sampling: Sampling) -> Result<Vec<Vec<Override>>, String> {
    for (k, axis) in axes.iter().enumerate() {
        if axes[..k].iter().any(|other| other.key == axis.key) {
            return Err(format!("`{}` is varied twice; give all its values once", axis.key));
        }
    }
    let lists = || -> Result<Vec<&Vec<String>>, String> {
        axes.iter()
            .map(|axis| match &axis.values {
                Values::List(values) => Ok(values),
                Values::Range { .. } => Err(format!(
                    "`{}` has a range, whose values a Latin hypercube chooses; add `--latin N` or give its values",
                    axis.key
                )),
            })
            .collect()
    };
    let set = |axis: &Axis, value: &str| Override { key: axis.key.clone(), value: value.to_owned() };
    let points: Vec<Vec<Override>> = match sampling {
        Sampling::Grid => {
            let lists = lists()?;
            let count = lists.iter().try_fold(1_usize, |count, list| count.checked_mul(list.len()));
            must_be_few(count.unwrap_or(usize::MAX))?;
            let mut points = vec![Vec::new()];
            for (axis, list) in axes.iter().zip(lists) {
                let longer = |point: &Vec<Override>| {
                    let point = point.clone();
                    list.iter().map(move |value| [point.clone(), vec![set(axis, value)]].concat())
                };
                points = points.iter().flat_map(longer).collect();
            }
            points
        }
        Sampling::Paired => {
            let lists = lists()?;
            let count = lists.first().map_or(1, |list| list.len());
            if let Some((axis, list)) = axes.iter().zip(&lists).find(|(_, list)| list.len() != count) {
                return Err(format!(
                    "`{}` has {} values and `{}` has {count}; in pairs all keys have as many",
                    axis.key,
                    list.len(),
                    axes[0].key
                ));
            }
            must_be_few(count)?;
            let point = |k: usize| axes.iter().zip(&lists).map(|(axis, list)| set(axis, &list[k])).collect();
            (0..count).map(point).collect()
        }
        Sampling::Latin { points, seed } => {
            if axes.is_empty() {
                return Err("a Latin hypercube needs a key to vary; add `--over KEY=LOW..HIGH`".to_owned());
            }
            must_be_few(points as usize)?;
            let shares = latin_hypercube(axes.len(), points as usize, seed);
            let point = |shares: &Vec<f64>| {
                axes.iter().zip(shares).map(|(axis, share)| set(axis, &axis.values.at(*share))).collect()
            };
            shares.iter().map(point).collect()
        }
    };
    Ok(points)
}

fn must_be_few(count: usize) -> Result<(), String> {
    match count <= MOST_POINTS {
        true => Ok(()),
        false => {
            Err(format!("more than {MOST_POINTS} points; vary fewer keys, or sample them by `--latin N`"))
        }
    }
}

/// `count` points in the unit cube of `dimensions`: along each axis every part of width 1/count holds one point, at a random
/// place in it. The same seed gives the same points in every version.
pub fn latin_hypercube(dimensions: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = SplitMix64(seed);
    let mut points = vec![Vec::with_capacity(dimensions); count];
    for _ in 0..dimensions {
        let mut parts: Vec<usize> = (0..count).collect();
        // Fisher and Yates.
        for last in (1..count).rev() {
            // A share below 1 of a count far below 2^53.
            parts.swap(last, (random.share() * (last + 1) as f64) as usize);
        }
        for (point, part) in points.iter_mut().zip(parts) {
            point.push((part as f64 + random.share()) / count as f64);
        }
    }
    points
}

/// SplitMix64 (Steele, Lea & Flood 2014): its numbers never change, as those of a library may.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// A number in [0, 1).
    fn share(&mut self) -> f64 {
        // Exact: 53 bits fit the mantissa.
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(texts: &[&str]) -> Vec<Axis> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    fn shown(points: &[Vec<Override>]) -> Vec<String> {
        let point =
            |point: &Vec<Override>| point.iter().map(|set| set.value.as_str()).collect::<Vec<_>>().join(" ");
        points.iter().map(point).collect()
    }

    #[test]
    fn a_grid_has_all_combinations_and_pairs_go_side_by_side() {
        let axes = axes(&["a=1,2", "b=x,y"]);
        let grid = points(&axes, Sampling::Grid).unwrap();
        assert_eq!(shown(&grid), ["1 \"x\"", "1 \"y\"", "2 \"x\"", "2 \"y\""]);
        assert_eq!(shown(&points(&axes, Sampling::Paired).unwrap()), ["1 \"x\"", "2 \"y\""]);
        assert_eq!(points(&[], Sampling::Grid).unwrap(), [vec![]], "the case itself");
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_every_part_of_every_axis() {
        for (dimensions, count) in [(1, 1), (2, 7), (5, 40)] {
            let points = latin_hypercube(dimensions, count, 3);
            for axis in 0..dimensions {
                let mut parts: Vec<usize> =
                    points.iter().map(|p| (p[axis] * count as f64) as usize).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..count).collect::<Vec<_>>());
            }
        }
        assert_eq!(latin_hypercube(3, 9, 1), latin_hypercube(3, 9, 1));
        assert_ne!(latin_hypercube(3, 9, 1), latin_hypercube(3, 9, 2));
        // Axes are permuted apart: on a diagonal both parts of all points would be the same.
        assert!(latin_hypercube(2, 40, 1).iter().any(|p| (p[0] - p[1]).abs() > 0.5));
        // Fixed for ever: first output of seed 0 is 0xe220a8397b1dcdaf.
        assert_eq!(SplitMix64(0).next(), 0xe220_a839_7b1d_cdaf);
    }

    #[test]
    fn a_latin_sample_stays_within_its_ranges_and_uses_all_values_of_a_list() {
        let axes = axes(&["e=1e4..1e6:log", "law=linear,tait"]);
        let points = points(&axes, Sampling::Latin { points: 8, seed: 1 }).unwrap();
        let below = points.iter().filter(|p| p[0].value.parse::<f64>().unwrap() < 1e5).count();
        assert_eq!(below, 4, "half of the logarithmic range");
        assert_eq!(points.iter().filter(|p| p[1].value == "\"tait\"").count(), 4);
    }

    #[test]
    fn what_has_no_points_is_refused() {
        let refused = |texts: &[&str], sampling| points(&axes(texts), sampling).unwrap_err();
        assert!(refused(&["a=1..2"], Sampling::Grid).contains("--latin N"));
        assert!(refused(&["a=1,2", "b=1"], Sampling::Paired).contains("`b` has 1 values and `a` has 2"));
        assert!(refused(&["a=1", "a=2"], Sampling::Grid).contains("varied twice"));
        assert!(refused(&[], Sampling::Latin { points: 2, seed: 1 }).contains("needs a key"));
        let many = (0..400).map(|k| k.to_string()).collect::<Vec<_>>().join(",");
        let many = [format!("a={many}"), format!("b={many}")];
        assert!(refused(&[&many[0], &many[1]], Sampling::Grid).contains("more than 100000 points"));
    }
}
