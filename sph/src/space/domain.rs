//! The box that holds a scene, and its periodic directions.

use serde::{Deserialize, Serialize};

use crate::space::{Plane, Space};

/// Axis-aligned box of the scene \[m\] with its periodic directions.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "S::Of<bool>: Serialize",
    deserialize = "S::Of<bool>: serde::de::DeserializeOwned"
))]
pub struct Domain<S: Space = Plane> {
    /// Lower corner \[m\].
    pub lower: S::Vector,
    /// Upper corner \[m\].
    pub upper: S::Vector,
    /// Directions in which the scene repeats with period `upper − lower`.
    pub periodic: S::Of<bool>,
}

impl<S: Space> PartialEq for Domain<S> {
    fn eq(&self, other: &Self) -> bool {
        let periodic = (0..S::DIMENSIONS).all(|axis| self.periodic[axis] == other.periodic[axis]);
        periodic && self.lower == other.lower && self.upper == other.upper
    }
}

impl<S: Space> Domain<S> {
    /// Edge lengths \[m\].
    pub fn size(&self) -> S::Vector {
        self.upper - self.lower
    }

    /// Whether any direction is periodic.
    pub fn is_periodic(&self) -> bool {
        (0..S::DIMENSIONS).any(|axis| self.periodic[axis])
    }

    /// Separation x_i − x_j \[m\] of the nearest images.
    ///
    /// Valid for positions at most half a period outside the box.
    #[inline]
    pub fn separation(&self, x_i: &S::Vector, x_j: &S::Vector) -> S::Vector {
        let mut d = *x_i - *x_j;
        if self.is_periodic() {
            self.fold(&mut d);
        }
        d
    }

    /// Takes the nearest image of a separation; apart, so that open boxes pay one look.
    fn fold(&self, d: &mut S::Vector) {
        for axis in 0..S::DIMENSIONS {
            let period = self.upper[axis] - self.lower[axis];
            // Rounding is a call, and few pairs are on two sides of a box.
            if self.periodic[axis] && d[axis].abs() >= 0.5 * period {
                d[axis] -= period * (d[axis] / period).round();
            }
        }
    }

    /// `position` moved back into the box along periodic directions.
    #[inline]
    pub fn wrapped(&self, position: &S::Vector) -> S::Vector {
        let mut x = *position;
        if !self.is_periodic() {
            return x;
        }
        for axis in 0..S::DIMENSIONS {
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
    pub fn contains(&self, position: &S::Vector) -> bool {
        // All comparisons and no jumps: nearly every position is inside.
        (0..S::DIMENSIONS).fold(true, |inside, axis| {
            let within = (position[axis] >= self.lower[axis]) & (position[axis] <= self.upper[axis]);
            inside & (self.periodic[axis] | within)
        })
    }

    /// Fixed point about which the ledger takes torques \[m\]: the centre of the box.
    pub fn torque_origin(&self) -> S::Vector {
        (self.lower + self.upper) * 0.5
    }
}
