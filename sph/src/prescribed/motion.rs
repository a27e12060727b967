//! Prescribed rigid motion of walls and supports.

use crate::expression::{ComponentError, Derivatives, Expression};
use crate::setup::Motion;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};

/// A prescribed rigid motion: x = pivot + R(a)·(X − pivot) + d, with a(t) and d(t) given by expressions and R the rotation
/// by the angle a about a fixed axis.
///
/// Velocity and acceleration follow from exact derivatives; see [`crate::expression`] for jumps and kinks.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidMotion<S: Space = Plane> {
    /// One for each axis.
    displacement: Vec<Option<Expression>>,
    angle: Option<Expression>,
    /// Angular velocity of unit magnitude about the axis of rotation.
    axis: S::Spin,
    pivot: S::Vector,
}

/// A rigid motion at one time; evaluates any number of positions cheaply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionState<S: Space = Plane> {
    pivot: S::Vector,
    displacement: S::Vector,
    displacement_rate: S::Vector,
    displacement_acceleration: S::Vector,
    rotation: Option<Rotation<S>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Rotation<S: Space> {
    /// R.
    matrix: S::Tensor,
    /// ω \[rad/s\].
    rate: S::Spin,
    /// ω̇ \[rad/s²\].
    acceleration: S::Spin,
}

impl<S: Space> RigidMotion<S> {
    /// The motion that `motion` describes; an empty text means none.
    ///
    /// # Errors
    /// When a text is no expression of `t`.
    pub fn new(motion: &Motion<S>) -> Result<Self, ComponentError> {
        let parse = |component, text: &str| {
            if text.trim().is_empty() {
                return Ok(None);
            }
            let expression = Expression::parse_component(component, text, &["t"])?;
            // Left out rather than evaluated, so that positions at rest keep their bits.
            Ok(Some(expression).filter(|e| e.constant() != Some(0.0)))
        };
        let components = ["displacement x", "displacement y", "displacement z"];
        let texts = motion.displacement.as_ref();
        let displacement = components.iter().zip(texts).map(|(component, text)| parse(component, text));
        Ok(Self {
            displacement: displacement.collect::<Result<_, _>>()?,
            angle: parse("angle", &motion.angle)?,
            axis: motion.axis,
            pivot: motion.pivot,
        })
    }

    /// The motion at `time` \[s\].
    pub fn at(&self, time: f64) -> MotionState<S> {
        let mut state = MotionState::<S> {
            pivot: self.pivot,
            displacement: S::Vector::zeros(),
            displacement_rate: S::Vector::zeros(),
            displacement_acceleration: S::Vector::zeros(),
            rotation: None,
        };
        for (axis, expression) in self.displacement.iter().enumerate() {
            let d = expression.as_ref().map_or_else(Derivatives::default, |e| e.derivatives(&[time], 0));
            state.displacement[axis] = d.value;
            state.displacement_rate[axis] = d.first;
            state.displacement_acceleration[axis] = d.second;
        }
        state.rotation = self.angle.as_ref().map(|angle| {
            let a = angle.derivatives(&[time], 0);
            Rotation {
                matrix: S::rotation_matrix(S::rotated(S::Rotation::default(), self.axis, a.value)),
                rate: self.axis * a.first,
                acceleration: self.axis * a.second,
            }
        });
        state
    }
}

impl<S: Space> MotionState<S> {
    /// Position x = pivot + R·(X − pivot) + d \[m\] of the point `start` X \[m\].
    pub fn position(&self, start: &S::Vector) -> S::Vector {
        match &self.rotation {
            None => *start + self.displacement,
            Some(rotation) => self.pivot + rotation.matrix * (*start - self.pivot) + self.displacement,
        }
    }

    /// Velocity ω × r + ḋ \[m/s\] of the point `start` X \[m\], with r = R·(X − pivot).
    pub fn velocity(&self, start: &S::Vector) -> S::Vector {
        match &self.rotation {
            None => self.displacement_rate,
            Some(Rotation { matrix, rate, .. }) => {
                S::spin_cross(*rate, &(*matrix * (*start - self.pivot))) + self.displacement_rate
            }
        }
    }

    /// Difference of velocity \[m/s\] between two points carried along, of which the second lies by `offset` \[m\] from the
    /// first.
    pub fn velocity_difference(&self, offset: &S::Vector) -> S::Vector {
        self.rotation.as_ref().map_or_else(S::Vector::zeros, |rotation| S::spin_cross(rotation.rate, offset))
    }

    /// Velocity \[m/s\] with which the motion carries whatever is at `position` x \[m\] now.
    pub fn velocity_at(&self, position: &S::Vector) -> S::Vector {
        match &self.rotation {
            None => self.displacement_rate,
            Some(Rotation { rate, .. }) => {
                let arm = *position - self.pivot - self.displacement;
                S::spin_cross(*rate, &arm) + self.displacement_rate
            }
        }
    }

    /// Acceleration ω̇ × r + ω × (ω × r) + d̈ \[m/s²\] of the point `start` X \[m\], with r = R·(X − pivot).
    pub fn acceleration(&self, start: &S::Vector) -> S::Vector {
        match &self.rotation {
            None => self.displacement_acceleration,
            Some(Rotation { matrix, rate, acceleration }) => {
                let r = *matrix * (*start - self.pivot);
                S::spin_cross(*acceleration, &r) + S::centripetal(*rate, &r) + self.displacement_acceleration
            }
        }
    }

    /// A direction of the undisplaced body as it points now.
    pub fn rotate(&self, direction: &S::Vector) -> S::Vector {
        self.rotation.as_ref().map_or(*direction, |rotation| rotation.matrix * *direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn motion(x: &str, y: &str, angle: &str, pivot: Vector) -> RigidMotion {
        let displacement = [x.to_owned(), y.to_owned()];
        RigidMotion::new(&Motion { displacement, angle: angle.to_owned(), axis: 1.0, pivot })
            .expect("valid motion")
    }

    #[test]
    fn no_motion_keeps_every_bit() {
        let still = motion("", "0", " 0*1 ", Vector::new(0.1, 0.7));
        let start = Vector::new(0.3, 0.123_456_789);
        assert_eq!(still.at(5.0).position(&start), start);
        assert_eq!(still.at(5.0).velocity(&start), Vector::zeros());
        assert_eq!(still.at(5.0).acceleration(&start), Vector::zeros());
        assert_eq!(still.at(5.0).rotate(&start), start);
    }

    #[test]
    fn harmonic_displacement_has_its_known_rates() {
        let shaken = motion("0.1*sin(2*pi*t)", "-t^2", "", Vector::zeros());
        let start = Vector::new(1.0, 2.0);
        let quarter = 0.25;
        // Round-off of a few operations on numbers up to 4.
        let close = |a: Vector, b: Vector| assert!((a - b).norm() < 1e-14, "{a} {b}");
        close(shaken.at(quarter).position(&start), Vector::new(1.1, 2.0 - 0.0625));
        close(shaken.at(quarter).velocity(&start), Vector::new(0.0, -0.5));
        close(shaken.at(quarter).acceleration(&start), Vector::new(-0.1 * 4.0 * PI * PI, -2.0));
    }

    #[test]
    fn rotation_turns_counter_clockwise_about_the_pivot() {
        let pivot = Vector::new(1.0, 1.0);
        let turning = motion("", "", "pi/2*t", pivot);
        let close = |a: Vector, b: Vector| assert!((a - b).norm() < 1e-14, "{a} {b}");
        close(turning.at(0.7).position(&pivot), pivot);
        close(turning.at(1.0).position(&Vector::new(3.0, 1.0)), Vector::new(1.0, 3.0));
        close(turning.at(1.0).rotate(&Vector::x()), Vector::y());
        // Speed ω r along the tangent, acceleration ω² r toward the pivot.
        close(turning.at(1.0).velocity(&Vector::new(3.0, 1.0)), Vector::new(-2.0 * FRAC_PI_2, 0.0));
        close(
            turning.at(1.0).acceleration(&Vector::new(3.0, 1.0)),
            Vector::new(0.0, -2.0 * FRAC_PI_2.powi(2)),
        );
    }

    #[test]
    fn velocity_and_acceleration_are_the_derivatives_of_position() {
        let mixed = motion("0.3*t^2", "sin(3*t)", "0.5*cos(2*t) + t^3", Vector::new(-0.4, 0.2));
        let start = Vector::new(0.9, 0.5);
        for time in [0.0, 0.3, 1.1] {
            let h = 1e-4;
            let at = |t| mixed.at(t).position(&start);
            let velocity = (at(time + h) - at(time - h)) / (2.0 * h);
            let acceleration = (at(time + h) - at(time) * 2.0 + at(time - h)) / (h * h);
            // Truncation h²·(third and fourth derivatives, up to 1e3)/12; round-off 1e-16/h² = 1e-8.
            assert!((mixed.at(time).velocity(&start) - velocity).norm() < 1e-5);
            assert!((mixed.at(time).acceleration(&start) - acceleration).norm() < 1e-5);
        }
    }

    #[test]
    fn rigid_motion_keeps_distances() {
        let mixed = motion("t", "t^2", "3*t", Vector::new(0.3, 0.4));
        let (a, b) = (Vector::new(0.0, 0.0), Vector::new(0.6, 0.8));
        let distance = (mixed.at(0.77).position(&a) - mixed.at(0.77).position(&b)).norm();
        assert!((distance - 1.0).abs() < 1e-14);
    }

    #[test]
    fn errors_name_the_component() {
        let displacement = ["0".to_owned(), "x+1".to_owned()];
        let error = RigidMotion::<Plane>::new(&Motion {
            displacement,
            angle: String::new(),
            axis: 1.0,
            pivot: Vector::zeros(),
        })
        .expect_err("x is no variable of a motion");
        let message = error.to_string();
        assert!(message.starts_with("displacement y = \"x+1\": character 1: unknown name `x`"), "{message}");
    }
}
