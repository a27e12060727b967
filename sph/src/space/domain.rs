//! The box that holds a scene, and its periodic directions.

use serde::{Deserialize, Serialize};

use crate::space::{DIMENSIONS, Vector};

/// Axis-aligned box of the scene \[m\] with its periodic directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Domain {
    /// Lower corner \[m\].
    pub lower: Vector,
    /// Upper corner \[m\].
    pub upper: Vector,
    /// Directions in which the scene repeats with period `upper − lower`.
    pub periodic: [bool; DIMENSIONS],
}

impl Domain {
    /// Edge lengths \[m\].
    pub fn size(&self) -> Vector {
        self.upper - self.lower
    }

    /// Whether any direction is periodic.
    pub fn is_periodic(&self) -> bool {
        self.periodic.iter().any(|p| *p)
    }

    /// Separation x_i − x_j \[m\] of the nearest images.
    ///
    /// Valid for positions at most half a period outside the box.
    #[inline]
    pub fn separation(&self, x_i: &Vector, x_j: &Vector) -> Vector {
        let mut d = x_i - x_j;
        if self.is_periodic() {
            self.fold(&mut d);
        }
        d
    }

    /// Takes the nearest image of a separation; apart, so that open boxes pay one look.
    fn fold(&self, d: &mut Vector) {
        for axis in 0..DIMENSIONS {
            if self.periodic[axis] {
                let period = self.upper[axis] - self.lower[axis];
                d[axis] -= period * (d[axis] / period).round();
            }
        }
    }

    /// `position` moved back into the box along periodic directions.
    #[inline]
    pub fn wrapped(&self, position: &Vector) -> Vector {
        let mut x = *position;
        if !self.is_periodic() {
            return x;
        }
        for axis in 0..DIMENSIONS {
            if self.periodic[axis] {
                let period = self.upper[axis] - self.lower[axis];
                x[axis] -= period * ((x[axis] - self.lower[axis]) / period).floor();
                // A tiny negative offset rounds up to the period itself.
                if x[axis] >= self.upper[axis] {
                    x[axis] = self.lower[axis];
                }
            }
        }
        x
    }

    /// Whether `position` lies inside, periodic directions counting as inside.
    #[inline]
    pub fn contains(&self, position: &Vector) -> bool {
        // All comparisons and no jumps: nearly every position is inside.
        let along = |axis: usize| {
            self.periodic[axis]
                | ((position[axis] >= self.lower[axis]) & (position[axis] <= self.upper[axis]))
        };
        along(0) & along(1)
    }

    /// Fixed point about which the ledger takes torques \[m\]: the centre of the box.
    pub fn torque_origin(&self) -> Vector {
        0.5 * (self.lower + self.upper)
    }
}
