//! Even stations along lines, and positions that keep their distance.

use crate::space::Vector;

/// Even stations along `line`: one on the corner where it starts, none on the one where it ends (the next line starts
/// there), half a step from free ends.
pub fn spread(line: &[Vector], from_corner: bool, to_corner: bool, spacing: f64) -> Vec<Vector> {
    let length = length(line);
    let spacings = length / spacing;
    let (count, step, first) = match (from_corner, to_corner) {
        (true, true) => {
            let n = spacings.round().max(1.0);
            (n, length / n, 0.0)
        }
        (false, false) => {
            let n = spacings.round().max(1.0);
            (n, length / n, 0.5)
        }
        (true, false) => {
            let n = (spacings + 0.5).round().max(1.0);
            (n, length / (n - 0.5), 0.0)
        }
        (false, true) => {
            let n = (spacings + 0.5).round().max(1.0);
            (n - 1.0, length / (n - 0.5), 0.5)
        }
    };
    stations(line, first, count, step)
}

/// Even stations along the closed `line`, an even number of them, so that a circle keeps its mirror symmetry.
pub fn stations_on_loop(line: &[Vector], spacing: f64, found: &mut Vec<Vector>) {
    let length = length(line);
    let n = 2.0 * (0.5 * length / spacing).round().max(1.0);
    found.extend(stations(line, 0.0, n, length / n));
}

fn length(line: &[Vector]) -> f64 {
    line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

/// Points of `line` at the lengths (first + k)·step, k below `count`.
fn stations(line: &[Vector], first: f64, count: f64, step: f64) -> Vec<Vector> {
    let mut found = Vec::new();
    let (mut k, mut passed) = (0.0, 0.0);
    for pair in line.windows(2) {
        let along = pair[1] - pair[0];
        let length = along.norm();
        while k < count && (first + k) * step <= passed + length * (1.0 + 1e-12) {
            if length > 0.0 {
                found.push(pair[0] + along * (((first + k) * step - passed) / length).clamp(0.0, 1.0));
            }
            k += 1.0;
        }
        passed += length;
    }
    found
}
