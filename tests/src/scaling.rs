//! What a step of a fluid in parts costs: a model of a cube of water in space, divided as the solver divides it.

use std::ops::Range;

/// Bytes of a particle as pair sums read it: position, velocity, density, pressure and volume.
const STATE_BYTES: f64 = 8.0 * 9.0;
/// Bytes of its results of the gradient pass that neighbours read: damper, eigenvalue, ∇ρ and L, and whether it lies at the
/// surface.
const GRADIENT_BYTES: f64 = 8.0 * (2.0 + 3.0 + 6.0) + 1.0;
/// Bytes for the reading of the volume: the excess, and whether it lies at the surface.
const VOLUME_BYTES: f64 = 8.0 + 1.0;
/// Steps from one reading of the volume to the next.
const READING_STEPS: f64 = 4.0;
/// Messages to each neighbour in a step: two with particles, one with gradients, and two for a reading.
const MESSAGES: f64 = 3.0 + 2.0 / READING_STEPS;
/// What all parts find together in a step: budgets of both stages, and whether particles have left.
const AGREEMENTS: f64 = 3.0;
/// Calls of the first part in a step: four in each stage, the end of the step, and its energies.
const CALLS: f64 = 10.0;

/// Most particles of a run of cells along x.
const RUN: f64 = 128.0;

/// A box of a part, in particle spacings.
#[derive(Clone, Debug, PartialEq)]
pub struct Brick {
    /// Along each axis.
    bounds: [Range<f64>; 3],
    /// Area of the steps in its faces, on average.
    steps: f64,
    /// Along which axis its rows follow each other of the layer that it was last cut through, by axis of the cut.
    across: [Option<usize>; 3],
}

/// A cube of water that is divided among parts.
#[derive(Clone, Copy, Debug)]
pub struct Cube {
    /// Particles along an edge.
    pub across: f64,
    /// Edge of a cell over the particle spacing.
    pub cell: f64,
    /// Number of parts.
    pub parts: usize,
}

/// What a part, or all of them, exchange in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Exchange {
    /// Particles.
    pub particles: f64,
    /// Particles whose sums need no copies.
    pub inner: f64,
    /// Copies.
    pub copies: f64,
    /// Messages with copies.
    pub messages: f64,
    /// Their bytes.
    pub bytes: f64,
}

impl Cube {
    /// The bricks of the parts.
    pub fn bricks(&self) -> Vec<Brick> {
        let mut bricks = Vec::with_capacity(self.parts);
        let bounds = [0, 1, 2].map(|_| 0.0..self.across);
        self.divide(Brick { bounds, steps: 0.0, across: [None; 3] }, self.parts, &mut bricks);
        bricks
    }

    /// Thickness of a layer that a cut across `axis` goes through: a run of cells along x, or a cell.
    fn layer(&self, axis: usize) -> f64 {
        let run = if axis == 0 { (RUN / self.cell.powi(3)).floor().max(1.0) } else { 1.0 };
        (run * self.cell).min(self.across)
    }

    /// Cuts a box in two again and again, across the axis along which it is longest; of equal ones where layers are thin.
    fn divide(&self, brick: Brick, parts: usize, bricks: &mut Vec<Brick>) {
        if parts <= 1 {
            bricks.push(brick);
            return;
        }
        let length = |axis: usize| brick.bounds[axis].end - brick.bounds[axis].start;
        let most = |axes: &mut dyn Iterator<Item = usize>, of: &dyn Fn(usize) -> f64| {
            axes.fold(None, |best, axis| best.filter(|best| of(*best) >= of(axis)).or(Some(axis)))
        };
        let axis = most(&mut [1, 2, 0].into_iter(), &length).unwrap_or(0);
        let rows = |axis: usize| length(axis) / self.layer(axis);
        let across = most(&mut [1, 2, 0].into_iter().filter(|other| *other != axis), &rows).unwrap_or(0);
        // The step lies in one of the parts of either side.
        let step = self.layer(axis) * length(3 - axis - across);
        let below = parts / 2;
        let at = brick.bounds[axis].start + length(axis) * below as f64 / parts as f64;
        let (mut first, mut second) = (brick.clone(), brick);
        (first.across[axis], second.across[axis]) = (Some(across), Some(across));
        (first.bounds[axis].end, second.bounds[axis].start) = (at, at);
        first.steps += step / below as f64;
        second.steps += step / (parts - below) as f64;
        self.divide(first, below, bricks);
        self.divide(second, parts - below, bricks);
    }

    /// Largest gap along an axis.
    fn distance(&self, a: &Brick, b: &Brick) -> f64 {
        let is_before = |a: &Brick, b: &Brick, axis: usize| a.bounds[axis].end == b.bounds[axis].start;
        let gap = |a: &Brick, b: &Brick, axis: usize| {
            // The last rows of a layer belong to its upper side, the first rows of that in the next brick to its lower side.
            let has_layer_between = |across| is_before(a, b, axis) && is_before(a, b, across);
            if a.across[axis].is_some_and(has_layer_between) {
                self.layer(axis)
            } else {
                b.bounds[axis].start - a.bounds[axis].end
            }
        };
        (0..3).map(|axis| gap(a, b, axis).max(gap(b, a, axis))).fold(0.0, f64::max)
    }

    /// What each part exchanges in a step in which no lists are built.
    pub fn exchanges(&self) -> Vec<Exchange> {
        let bricks = self.bricks();
        let of = |brick: &Brick| {
            let [one, two, three] = [1.0, 2.0, 3.0].map(|rings| {
                let around = brick.bounds.clone().map(|along| {
                    (along.start - rings * self.cell).max(0.0)
                        ..(along.end + rings * self.cell).min(self.across)
                });
                // Around a step there are as many rows more.
                volume(&around) - volume(&brick.bounds) + rings * self.cell * brick.steps
            });
            let near = |rings: f64| {
                let others = bricks
                    .iter()
                    .filter(|other| *other != brick && self.distance(brick, other) < rings * self.cell);
                others.count() as f64
            };
            // Three of four correctors take copies from as far as predictors do.
            let farther = 1.0 / READING_STEPS;
            Exchange {
                particles: volume(&brick.bounds),
                inner: volume(&brick.bounds.clone().map(|along| {
                    let start = if along.start > 0.0 { along.start + self.cell } else { 0.0 };
                    let end = if along.end < self.across { along.end - self.cell } else { along.end };
                    start..end.max(start)
                })),
                copies: three,
                messages: near(2.0) * (2.0 - farther)
                    + near(3.0) * (farther + 2.0 / READING_STEPS)
                    + near(1.0),
                bytes: STATE_BYTES * (two * (2.0 - farther) + three * farther)
                    + GRADIENT_BYTES * one
                    + VOLUME_BYTES / READING_STEPS * three,
            }
        };
        bricks.iter().map(of).collect()
    }
}

/// What particles, copies and messages cost.
#[derive(Clone, Copy, Debug)]
pub struct Costs {
    /// CPU time of a particle in a step \[s\].
    pub particle: f64,
    /// CPU time of a copy in a step \[s\].
    pub copy: f64,
    /// Time of a message from one part to another \[s\].
    pub message: f64,
    /// Bytes that a part can send in a second.
    pub bandwidth: f64,
}

/// Time of a step, with one core for each part \[s\].
#[derive(Clone, Copy, Debug)]
pub struct StepTime {
    /// Own particles.
    pub particles: f64,
    /// Copies.
    pub copies: f64,
    /// Transfer that no sums hide.
    pub transfer: f64,
    /// What all parts find together, and calls.
    pub agreement: f64,
}

impl StepTime {
    /// The slowest of the parts of `cube`.
    pub fn of(cube: &Cube, costs: &Costs) -> Self {
        // Messages go along a tree.
        let hops = (cube.parts as f64).log2().ceil();
        let times = cube.exchanges().into_iter().map(|exchange| {
            let transfer =
                exchange.messages.min(MESSAGES * 26.0) * costs.message + exchange.bytes / costs.bandwidth;
            Self {
                particles: costs.particle * exchange.particles,
                copies: costs.copy * exchange.copies,
                transfer: (transfer - costs.particle * exchange.inner).max(0.0),
                agreement: (2.0 * AGREEMENTS + CALLS) * hops * costs.message,
            }
        });
        let slowest = times.max_by(|a, b| a.total().total_cmp(&b.total()));
        slowest.unwrap_or(Self { particles: 0.0, copies: 0.0, transfer: 0.0, agreement: 0.0 })
    }

    /// The whole step.
    pub fn total(&self) -> f64 {
        self.particles + self.copies + self.transfer + self.agreement
    }
}

fn volume(bounds: &[Range<f64>; 3]) -> f64 {
    bounds.iter().map(|along| along.end - along.start).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bricks_fill_the_cube_and_eight_have_each_other_as_neighbours() {
        for parts in [1, 2, 3, 5, 8, 64] {
            let exchanges = Cube { across: 96.0, cell: 3.0, parts }.exchanges();
            assert_eq!(exchanges.len(), parts);
            let particles: f64 = exchanges.iter().map(|exchange| exchange.particles).sum();
            assert!((particles - 96.0_f64.powi(3)).abs() < 1e-6, "{parts}");
        }
        let eight = Cube { across: 96.0, cell: 3.0, parts: 8 }.exchanges();
        // 48 particles across each, with copies beyond three faces. The steps: of the first cut a quarter of 96, of the second
        // a half, both of cells; of the third, across x, 48 of a run of four cells.
        let steps = 3.0 * (96.0 / 4.0 + 96.0 / 2.0 + 4.0 * 48.0);
        let copies = 57.0_f64.powi(3) - 48.0_f64.powi(3) + 9.0 * steps;
        assert!(eight.iter().all(|exchange| (exchange.copies - copies).abs() < 1e-6), "{eight:?}");
        // Of 56 pairs all are near but some across an edge or a corner, which a layer separates.
        let messages: f64 = eight.iter().map(|exchange| exchange.messages).sum();
        assert!((40.0 * MESSAGES..56.0 * MESSAGES).contains(&messages), "{messages}");
        let two = Cube { across: 96.0, cell: 3.0, parts: 2 }.exchanges();
        assert!(two.iter().all(|exchange| exchange.messages == MESSAGES));
        assert_eq!(Cube { across: 96.0, cell: 3.0, parts: 1 }.exchanges()[0].bytes, 0.0);
    }

    #[test]
    fn a_step_is_as_long_as_its_slowest_part() {
        let costs = Costs { particle: 1e-6, copy: 0.0, message: 0.0, bandwidth: f64::INFINITY };
        let time = |parts| StepTime::of(&Cube { across: 96.0, cell: 3.0, parts }, &costs).total();
        assert!((time(1) / time(2) - 2.0).abs() < 1e-9);
        assert!((time(1) / time(3) - 3.0).abs() < 1e-9, "{}", time(1) / time(3));
        let slow = Costs { message: 1e-3, ..costs };
        let time = StepTime::of(&Cube { across: 96.0, cell: 3.0, parts: 4 }, &slow);
        assert!((time.agreement - 32.0 * 1e-3).abs() < 1e-12, "{time:?}");
    }
}
