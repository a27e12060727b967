//! What a run costs and where: CPU time of the solver's thread by pass, and a fixed loop to compare machines by.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use proto::trace::{self, Ended, Sink};
use sph::kernel::CubicSpline;
use sph::space::Plane;

/// CPU seconds by name of span, of all threads of this process; a run on one thread does all its work in its steps.
#[derive(Clone, Default)]
pub struct Totals {
    seconds: Arc<Mutex<BTreeMap<String, f64>>>,
}

/// Name of the span around a whole step.
pub const STEP: &str = "step";
/// Spans within a step that hold no others.
pub const PASSES: [&str; 5] = ["begin stage", "own sums", "cross sums", "advance", "end of step"];

impl Totals {
    /// The sums so far, which are then reset.
    pub fn take(&self) -> BTreeMap<String, f64> {
        std::mem::take(&mut self.seconds.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Sink for Totals {
    fn clock(&self) -> Duration {
        trace::thread_cpu()
    }

    fn ended(&self, span: &Ended<'_>) {
        let mut seconds = self.seconds.lock().unwrap_or_else(PoisonError::into_inner);
        let spent = span.end.saturating_sub(span.start).as_secs_f64();
        match seconds.get_mut(span.name) {
            Some(sum) => *sum += spent,
            None => {
                seconds.insert(span.name.to_owned(), spent);
            }
        }
    }
}

/// CPU time \[s\] of one evaluation of the kernel's gradient in a loop that never changes: the least of some tries, so
/// that costs of different machines, or of one machine in different moods, can be compared.
pub fn fixed_kernel() -> f64 {
    const LOOPS: u32 = 400;
    const DISTANCES: u32 = 4096;
    let kernel = CubicSpline::<Plane>::new(1.2);
    let distances: Vec<f64> = (0..DISTANCES).map(|k| 2.4 * f64::from(k * 1021 % 4096) / 4096.0).collect();
    let measured = (0..5).map(|_| {
        let before = trace::thread_cpu();
        for _ in 0..LOOPS {
            let sum = |sum, distance: &f64| sum + kernel.gradient_factor(*distance);
            black_box(distances.iter().fold(0.0, sum));
        }
        trace::thread_cpu().saturating_sub(before).as_secs_f64() / f64::from(LOOPS * DISTANCES)
    });
    measured.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_one_name_add_up_until_they_are_taken() {
        let totals = Totals::default();
        for (name, from, to) in [("step", 0, 5), ("own sums", 1, 3), ("step", 5, 6)] {
            let (start, end) = (Duration::from_secs(from), Duration::from_secs(to));
            totals.ended(&Ended { name, start, end, fields: "" });
        }
        let sums = totals.take();
        assert_eq!((sums["step"], sums["own sums"]), (6.0, 2.0));
        assert!(totals.take().is_empty());
    }
}
