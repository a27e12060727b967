//! The acceleration that acts on all matter.

use crate::expression::{ComponentError, Expression};
use crate::setup::BodyForce;
use crate::space::Vector;

/// Constant gravity plus, where a scene names them, expressions of `x`, `y` \[m\] and `t` \[s\].
#[derive(Clone, Debug, PartialEq)]
pub struct BodyForceField {
    gravity: Vector,
    expressions: Option<[Expression; 2]>,
}

impl BodyForceField {
    /// Names of the variables in the order of evaluation.
    pub const VARIABLES: [&'static str; 3] = ["x", "y", "t"];

    /// The field that `body_force` describes; empty texts and constants are cheap.
    ///
    /// # Errors
    /// When a text is no expression of `x`, `y`, `t`.
    pub fn new(body_force: &BodyForce) -> Result<Self, ComponentError> {
        let mut field = Self { gravity: body_force.gravity, expressions: None };
        let Some(texts) = &body_force.expressions else { return Ok(field) };
        let parse = |component, text: &str| {
            let text = if text.trim().is_empty() { "0" } else { text };
            Expression::parse_component(component, text, &Self::VARIABLES)
        };
        let [x, y] = [parse("body force x", &texts[0])?, parse("body force y", &texts[1])?];
        if (x.constant(), y.constant()) != (Some(0.0), Some(0.0)) {
            field.expressions = Some([x, y]);
        }
        Ok(field)
    }

    /// A field of gravity alone \[m/s²\].
    pub fn uniform(gravity: Vector) -> Self {
        Self { gravity, expressions: None }
    }

    /// The constant part \[m/s²\].
    pub fn gravity(&self) -> Vector {
        self.gravity
    }

    /// Whether the acceleration is the constant part everywhere and always.
    pub fn is_uniform(&self) -> bool {
        self.expressions.is_none()
    }

    /// The field at `time` \[s\], for use with many positions: what does not depend on them is evaluated here.
    pub fn at(&self, time: f64) -> BodyForceAt<'_> {
        match &self.expressions {
            Some(expressions) if expressions.iter().any(|e| e.uses(0) || e.uses(1)) => {
                BodyForceAt::Varying { gravity: self.gravity, expressions, time }
            }
            _ => BodyForceAt::Uniform(self.acceleration(&Vector::zeros(), time)),
        }
    }

    /// Acceleration \[m/s²\] at `position` \[m\] and `time` \[s\].
    #[inline]
    pub fn acceleration(&self, position: &Vector, time: f64) -> Vector {
        match &self.expressions {
            None => self.gravity,
            Some(expressions) => sum(&self.gravity, expressions, position, time),
        }
    }
}

/// A body force at one time; the same bits as [`BodyForceField::acceleration`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyForceAt<'a> {
    /// The same acceleration everywhere \[m/s²\].
    Uniform(Vector),
    /// An acceleration that depends on the position.
    Varying {
        /// Constant part \[m/s²\].
        gravity: Vector,
        /// What is added to it \[m/s²\].
        expressions: &'a [Expression; 2],
        /// Time \[s\].
        time: f64,
    },
}

impl BodyForceAt<'_> {
    /// Acceleration \[m/s²\] at `position` \[m\].
    #[inline]
    pub fn acceleration(&self, position: &Vector) -> Vector {
        match self {
            Self::Uniform(acceleration) => *acceleration,
            Self::Varying { gravity, expressions, time } => sum(gravity, expressions, position, *time),
        }
    }
}

fn sum(gravity: &Vector, [x, y]: &[Expression; 2], position: &Vector, time: f64) -> Vector {
    let values = [position.x, position.y, time];
    gravity + Vector::new(x.eval(&values), y.eval(&values))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let plain = BodyForceField::new(&BodyForce { gravity: Vector::new(0.1, -9.81), expressions: None });
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
        let error =
            BodyForceField::new(&BodyForce { gravity: Vector::zeros(), expressions }).expect_err("no z");
        assert!(error.to_string().starts_with("body force y = \"2*z\": character 3"), "{error}");
    }
}
