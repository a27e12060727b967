//! What reading and laying out a case may cost.

use std::cell::Cell;

/// Most steps of work, each about a nanosecond: a few seconds. The largest scene of rectangles takes an eighth of it, 70,000
/// particles in layers along faces all of it.
const MOST_STEPS: f64 = 3e9;

/// Counts work while a case is laid out, so that one that would take hours is refused within seconds.
#[derive(Debug, Default)]
pub struct Effort {
    spent: Cell<f64>,
    refused: Cell<bool>,
}

impl Effort {
    /// Takes `steps`; whether there were enough left.
    pub fn take(&self, steps: f64) -> bool {
        let spent = self.spent.get() + steps;
        // A sum that is not a number has passed every limit.
        if spent > MOST_STEPS || spent.is_nan() {
            return false;
        }
        self.spent.set(spent);
        true
    }

    /// Whether this is the first time that it is asked.
    pub fn is_first_refusal(&self) -> bool {
        !self.refused.replace(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_ends_at_its_limit_and_small_work_may_follow() {
        let effort = Effort::default();
        assert!(effort.take(0.75 * MOST_STEPS));
        assert!(!effort.take(0.5 * MOST_STEPS) && !effort.take(f64::NAN) && !effort.take(f64::INFINITY));
        assert!(effort.take(0.25 * MOST_STEPS));
        assert!(effort.is_first_refusal() && !effort.is_first_refusal());
    }
}
