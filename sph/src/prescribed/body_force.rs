//! The acceleration that acts on all matter.

use crate::expression::{ComponentError, Expression};
use crate::setup::BodyForce;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};

/// Most variables of an expression: three coordinates and the time.
const MOST_VARIABLES: usize = 4;

/// Values of the variables of an expression of `position` \[m\] and `time` \[s\], in the order of
/// [`BodyForceField::VARIABLES`].
#[inline]
pub fn values_at<S: Space>(position: &S::Vector, time: f64) -> [f64; MOST_VARIABLES] {
    let mut values = [time; MOST_VARIABLES];
    for axis in 0..S::DIMENSIONS {
        values[axis] = position[axis];
    }
    values
}

/// Constant gravity plus, where a scene names them, expressions of `x`, `y` \[m\] and `t` \[s\].
#[derive(Clone, Debug, PartialEq)]
pub struct BodyForceField<S: Space = Plane> {
    gravity: S::Vector,
    /// One for each axis, or none.
    expressions: Vec<Expression>,
}

impl<S: Space> BodyForceField<S> {
    /// Names of the variables in the order of evaluation.
    pub const VARIABLES: &'static [&'static str] =
        if S::DIMENSIONS == 2 { &["x", "y", "t"] } else { &["x", "y", "z", "t"] };

    /// The field that `body_force` describes; empty texts and constants are cheap.
    ///
    /// # Errors
    /// When a text is no expression of the coordinates and `t`.
    pub fn new(body_force: &BodyForce<S>) -> Result<Self, ComponentError> {
        let mut field = Self { gravity: body_force.gravity, expressions: Vec::new() };
        let Some(texts) = &body_force.expressions else { return Ok(field) };
        let parse = |component, text: &str| {
            let text = if text.trim().is_empty() { "0" } else { text };
            Expression::parse_component(component, text, Self::VARIABLES)
        };
        let components = ["body force x", "body force y", "body force z"];
        let parsed = components.iter().zip(texts.as_ref()).map(|(component, text)| parse(component, text));
        let expressions = parsed.collect::<Result<Vec<_>, _>>()?;
        if expressions.iter().any(|expression| expression.constant() != Some(0.0)) {
            field.expressions = expressions;
        }
        Ok(field)
    }

    /// A field of gravity alone \[m/s²\].
    pub fn uniform(gravity: S::Vector) -> Self {
        Self { gravity, expressions: Vec::new() }
    }

    /// The constant part \[m/s²\].
    pub fn gravity(&self) -> S::Vector {
        self.gravity
    }

    /// Whether the acceleration is the constant part everywhere and always.
    pub fn is_uniform(&self) -> bool {
        self.expressions.is_empty()
    }

    /// The field at `time` \[s\], for use with many positions: what does not depend on them is evaluated here.
    pub fn at(&self, time: f64) -> BodyForceAt<'_, S> {
        let varies = |e: &Expression| (0..S::DIMENSIONS).any(|axis| e.uses(axis));
        if self.expressions.iter().any(varies) {
            BodyForceAt::Varying { field: self, time }
        } else {
            BodyForceAt::Uniform(self.acceleration(&S::Vector::zeros(), time))
        }
    }

    /// Acceleration \[m/s²\] at `position` \[m\] and `time` \[s\].
    #[inline]
    pub fn acceleration(&self, position: &S::Vector, time: f64) -> S::Vector {
        let mut acceleration = self.gravity;
        if self.is_uniform() {
            return acceleration;
        }
        let values = values_at::<S>(position, time);
        for (axis, expression) in self.expressions.iter().enumerate() {
            acceleration[axis] += expression.eval(&values);
        }
        acceleration
    }
}

/// A body force at one time; the same bits as [`BodyForceField::acceleration`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyForceAt<'a, S: Space = Plane> {
    /// The same acceleration everywhere \[m/s²\].
    Uniform(S::Vector),
    /// An acceleration that depends on the position.
    Varying {
        /// The field.
        field: &'a BodyForceField<S>,
        /// Time \[s\].
        time: f64,
    },
}

impl<S: Space> BodyForceAt<'_, S> {
    /// Acceleration \[m/s²\] at `position` \[m\].
    #[inline]
    pub fn acceleration(&self, position: &S::Vector) -> S::Vector {
        match self {
            Self::Uniform(acceleration) => *acceleration,
            Self::Varying { field, time } => field.acceleration(position, *time),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    fn field(x: &str, y: &str) -> BodyForceField {
        let expressions = Some([x.to_owned(), y.to_owned()]);
        BodyForceField::new(&BodyForce { gravity: Vector::new(0.0, -9.81), expressions })
            .expect("valid field")
    }

    #[test]
    fn expressions_add_to_gravity() {
        let sloshing = field("0.5*cos(t)", "x - y");
        assert!(!sloshing.is_uniform());
        let acceleration = sloshing.acceleration(&Vector::new(3.0, 1.0), 0.0);
        assert_eq!(acceleration, Vector::new(0.5, -9.81 + 2.0));
        assert_eq!(sloshing.gravity(), Vector::new(0.0, -9.81));
    }

    #[test]
    fn without_expressions_gravity_acts_alone() {
        let plain =
            BodyForceField::<Plane>::new(&BodyForce { gravity: Vector::new(0.1, -9.81), expressions: None });
        assert_eq!(plain, Ok(BodyForceField::uniform(Vector::new(0.1, -9.81))));
        let empty = field("", "0*2");
        assert!(empty.is_uniform());
        assert_eq!(empty.acceleration(&Vector::new(3.0, 1.0), 7.0), Vector::new(0.0, -9.81));
    }

    #[test]
    fn at_one_time_the_field_has_the_same_bits() {
        let position = Vector::new(0.3, -0.7);
        for (x, y, uniform) in [("sin(t)", "", true), ("t", "x*t", false), ("y", "1/3", false)] {
            let field = field(x, y);
            let at = field.at(0.9);
            assert_eq!(matches!(at, BodyForceAt::Uniform(_)), uniform, "{x}, {y}");
            assert_eq!(at.acceleration(&position), field.acceleration(&position, 0.9));
        }
    }

    #[test]
    fn errors_name_the_component() {
        let expressions = Some(["0".to_owned(), "2*z".to_owned()]);
        let error = BodyForceField::<Plane>::new(&BodyForce { gravity: Vector::zeros(), expressions })
            .expect_err("no z");
        assert!(error.to_string().starts_with("body force y = \"2*z\": character 3"), "{error}");
    }
}
