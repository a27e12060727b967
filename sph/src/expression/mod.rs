//! Arithmetic expressions of named variables, as case files and set-up messages hold them.
//!
//! Grammar, spaces free:
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = signed  { ("*" | "/") signed }
//! signed  = { "+" | "-" } power
//! power   = primary [ "^" signed ]
//! primary = number | constant | variable | "(" sum ")" | function "(" sum { "," sum } ")"
//! number  = 12 | 0.5 | .5 | 1e-3 | 2.5E6
//! ```
//!
//! A sign binds less than a power (`-x^2` is −(x²)) and powers group from the right (`2^3^2` = 512), as in print.
//! The one constant is `pi`. Functions of one argument: `sin`, `cos`, `tan`, `asin`, `acos`, `atan`, `sinh`, `cosh`,
//! `tanh`, `exp`, `ln`, `sqrt`, `abs`, `floor` and, to put pieces together, `step(a)` (0 for a < 0, else 1) and
//! `ramp(a)` (0 for a < 0, else a). Functions of two or more arguments: `min`, `max`. Angles are in radians.
//!
//! A text has at most [`MAXIMUM_LENGTH`] bytes and nests at most [`MAXIMUM_DEPTH`] deep, so that no text can exhaust
//! time or stack. Outside its range a function gives NaN or an infinity, never a panic.
//!
//! Derivatives are exact: they are carried along with the value (truncated Taylor arithmetic) instead of being formed
//! as text. At a jump or kink the derivatives are those of the side to the right of it in the function's argument;
//! a jump contributes no spike.

mod jet;
mod parse;

use std::ops::Range;

use jet::{Jet, Number};

/// Longest text of an expression \[bytes\].
pub const MAXIMUM_LENGTH: usize = 4096;

/// Deepest nesting of parentheses, function calls and powers.
pub const MAXIMUM_DEPTH: usize = 32;

/// Most operands that wait at one time while an expression is evaluated.
const STACK_SIZE: usize = 32;

/// A checked expression, ready to be evaluated any number of times from any thread.
///
/// ```
/// use sph::expression::Expression;
/// let wave = Expression::parse("0.1*sin(2*pi*x) - t^2", &["x", "t"])?;
/// assert!((wave.eval(&[0.25, 0.5]) - (0.1 - 0.25)).abs() < 1e-15);
/// # Ok::<(), sph::expression::ExpressionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    program: Vec<Instruction>,
    variables: usize,
}

/// Value of an expression and its first two derivatives with respect to one variable.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// f, in the expression's unit.
    pub value: f64,
    /// f′, per unit of the variable.
    pub first: f64,
    /// f″, per square unit of the variable.
    pub second: f64,
}

/// One instruction of the stack machine, operands before operators.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Instruction {
    Constant(f64),
    Variable(usize),
    Unary(UnaryFunction),
    Binary(BinaryFunction),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UnaryFunction {
    Negate,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Sqrt,
    Abs,
    Floor,
    Step,
    Ramp,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BinaryFunction {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Minimum,
    Maximum,
}

/// Why a text is no expression; positions count characters from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExpressionError {
    /// Nothing but spaces.
    #[error("the expression is empty; write `0` for none")]
    Empty,
    /// Longer than [`MAXIMUM_LENGTH`].
    #[error("the expression has {length} bytes; at most {MAXIMUM_LENGTH} are allowed")]
    TooLong {
        /// Length of the text \[bytes\].
        length: usize,
    },
    /// Nested deeper than [`MAXIMUM_DEPTH`], or with too many operands waiting.
    #[error(
        "character {position}: nested too deeply; at most {MAXIMUM_DEPTH} levels of parentheses, functions and powers are allowed"
    )]
    TooDeep {
        /// Character at which the limit is passed.
        position: usize,
        /// Bytes of the text.
        span: Range<usize>,
    },
    /// A character or the end where something else must stand.
    #[error("character {position}: found {found}, expected {expected}")]
    Unexpected {
        /// What stands there.
        found: String,
        /// Its first character.
        position: usize,
        /// What may stand there.
        expected: &'static str,
        /// Bytes of the text.
        span: Range<usize>,
    },
    /// A name that is neither variable, constant nor function.
    #[error("character {position}: unknown name `{name}`; allowed are {allowed}")]
    UnknownName {
        /// The name.
        name: String,
        /// Its first character.
        position: usize,
        /// Variables, constants and functions that are known here.
        allowed: String,
        /// Bytes of the text.
        span: Range<usize>,
    },
    /// A function with too few or too many arguments.
    #[error("character {position}: `{function}` has {given} argument(s), needs {needed}")]
    Arguments {
        /// Name of the function.
        function: String,
        /// Its first character.
        position: usize,
        /// Number of arguments found.
        given: usize,
        /// Number of arguments that it takes.
        needed: &'static str,
        /// Bytes of the text.
        span: Range<usize>,
    },
}

impl ExpressionError {
    /// Bytes of the text that the error is about; `None` when it is about the whole.
    pub fn span(&self) -> Option<Range<usize>> {
        match self {
            Self::Empty | Self::TooLong { .. } => None,
            Self::TooDeep { span, .. }
            | Self::Unexpected { span, .. }
            | Self::UnknownName { span, .. }
            | Self::Arguments { span, .. } => Some(span.clone()),
        }
    }
}

/// An expression of a set-up that is wrong, with the name of the component it stands for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{component} = \"{}\": {source}", parse::shortened(.text))]
pub struct ComponentError {
    /// Which component, e.g. `angle`.
    pub component: &'static str,
    /// The text.
    pub text: String,
    /// What is wrong with it.
    pub source: ExpressionError,
}

impl Expression {
    /// Checks `text` and makes it ready; `variables` are the names it may use, in the order of the values later.
    ///
    /// # Errors
    /// When the text does not follow the grammar of this module or uses other names.
    pub fn parse(text: &str, variables: &[&str]) -> Result<Self, ExpressionError> {
        let program = parse::compile(text, variables)?;
        Ok(Self { program, variables: variables.len() })
    }

    /// [`Expression::parse`], with the name of the component in the error.
    ///
    /// # Errors
    /// As [`Expression::parse`].
    pub fn parse_component(
        component: &'static str,
        text: &str,
        variables: &[&str],
    ) -> Result<Self, ComponentError> {
        Self::parse(text, variables).map_err(|source| ComponentError {
            component,
            text: text.to_owned(),
            source,
        })
    }

    /// Value at `values`, one per variable in the order given to [`Expression::parse`].
    ///
    /// # Panics
    /// When there are fewer values than variables.
    #[inline]
    pub fn eval(&self, values: &[f64]) -> f64 {
        self.check(values);
        self.run(|index| values[index])
    }

    /// Value and derivatives at `values` with respect to the variable number `variable`.
    ///
    /// ```
    /// use sph::expression::Expression;
    /// let f = Expression::parse("t^3", &["t"])?;
    /// let at_2 = f.derivatives(&[2.0], 0);
    /// assert_eq!((at_2.value, at_2.first, at_2.second), (8.0, 12.0, 12.0));
    /// # Ok::<(), sph::expression::ExpressionError>(())
    /// ```
    ///
    /// # Panics
    /// When there are fewer values than variables.
    pub fn derivatives(&self, values: &[f64], variable: usize) -> Derivatives {
        self.check(values);
        let jet = self.run(|index| Jet {
            value: values[index],
            first: if index == variable { 1.0 } else { 0.0 },
            second: 0.0,
        });
        Derivatives { value: jet.value, first: jet.first, second: jet.second }
    }

    /// The value when the expression names no variable.
    pub fn constant(&self) -> Option<f64> {
        // Constant parts are folded while parsing: without a variable one instruction is left.
        match self.program.as_slice() {
            [Instruction::Constant(value)] => Some(*value),
            _ => None,
        }
    }

    /// Whether the value can depend on the variable number `variable`.
    pub fn uses(&self, variable: usize) -> bool {
        self.program.contains(&Instruction::Variable(variable))
    }

    fn check(&self, values: &[f64]) {
        assert!(
            values.len() >= self.variables,
            "an expression of {} variables has no values",
            self.variables
        );
    }

    #[inline]
    fn run<N: Number>(&self, variable: impl Fn(usize) -> N) -> N {
        let mut stack = [N::constant(0.0); STACK_SIZE];
        let mut top = 0;
        // The parser has checked that operands are there and that they fit the stack.
        for instruction in &self.program {
            match *instruction {
                Instruction::Constant(value) => {
                    stack[top] = N::constant(value);
                    top += 1;
                }
                Instruction::Variable(index) => {
                    stack[top] = variable(index);
                    top += 1;
                }
                Instruction::Unary(function) => stack[top - 1] = stack[top - 1].unary(function),
                Instruction::Binary(function) => {
                    top -= 1;
                    stack[top - 1] = stack[top - 1].binary(stack[top], function);
                }
            }
        }
        stack[0]
    }
}

#[cfg(test)]
mod tests;
