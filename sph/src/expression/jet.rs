//! The numbers an expression is evaluated in: plain values, and values with two derivatives.

use super::{BinaryFunction, UnaryFunction};

/// What the stack machine computes with.
pub(super) trait Number: Copy {
    fn constant(value: f64) -> Self;
    fn unary(self, function: UnaryFunction) -> Self;
    fn binary(self, other: Self, function: BinaryFunction) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    #[inline]
    fn unary(self, function: UnaryFunction) -> Self {
        match function {
            UnaryFunction::Negate => -self,
            UnaryFunction::Sin => self.sin(),
            UnaryFunction::Cos => self.cos(),
            UnaryFunction::Tan => self.tan(),
            UnaryFunction::Asin => self.asin(),
            UnaryFunction::Acos => self.acos(),
            UnaryFunction::Atan => self.atan(),
            UnaryFunction::Sinh => self.sinh(),
            UnaryFunction::Cosh => self.cosh(),
            UnaryFunction::Tanh => self.tanh(),
            UnaryFunction::Exp => self.exp(),
            UnaryFunction::Ln => self.ln(),
            UnaryFunction::Sqrt => self.sqrt(),
            UnaryFunction::Abs => self.abs(),
            UnaryFunction::Floor => self.floor(),
            // NaN stays NaN: a wrong value must not come out as a plausible one.
            UnaryFunction::Step if self.is_nan() => self,
            UnaryFunction::Step => {
                if self < 0.0 {
                    0.0
                } else {
                    1.0
                }
            }
            UnaryFunction::Ramp => {
                if self < 0.0 {
                    0.0
                } else {
                    self
                }
            }
        }
    }

    #[inline]
    fn binary(self, other: Self, function: BinaryFunction) -> Self {
        match function {
            BinaryFunction::Add => self + other,
            BinaryFunction::Subtract => self - other,
            BinaryFunction::Multiply => self * other,
            BinaryFunction::Divide => self / other,
            BinaryFunction::Power => self.powf(other),
            BinaryFunction::Minimum if takes_first(self, other, self < other) => self,
            BinaryFunction::Maximum if takes_first(self, other, self > other) => self,
            BinaryFunction::Minimum | BinaryFunction::Maximum => other,
        }
    }
}

/// Whether `min` or `max` gives its first argument; NaN on either side comes out as NaN.
fn takes_first(first: f64, second: f64, wins: bool) -> bool {
    first.is_nan() || (wins && !second.is_nan())
}

/// A value with its first and second derivative with respect to one variable.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub(super) value: f64,
    pub(super) first: f64,
    pub(super) second: f64,
}

impl Jet {
    /// f(u) from f, f′ and f″ at u: (f∘u)′ = f′ u′, (f∘u)″ = f″ u′² + f′ u″.
    fn chain(self, value: f64, slope: f64, curvature: f64) -> Self {
        if self.first == 0.0 && self.second == 0.0 {
            // Keeps 0·∞ out of what does not vary, e.g. `sqrt(0)`.
            return Self::constant(value);
        }
        Self {
            value,
            first: slope * self.first,
            second: curvature * self.first * self.first + slope * self.second,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value + 2.0 * self.first * other.first + self.value * other.second,
        }
    }

    fn power(self, exponent: Self) -> Self {
        let (a, b) = (self.value, exponent.value);
        let value = a.powf(b);
        if exponent.first == 0.0 && exponent.second == 0.0 {
            // b a^(b−1) without 0·∞ at a = 0 for the small whole exponents.
            let slope = if b == 0.0 { 0.0 } else { b * a.powf(b - 1.0) };
            let curvature = if b == 0.0 || b == 1.0 { 0.0 } else { b * (b - 1.0) * a.powf(b - 2.0) };
            return self.chain(value, slope, curvature);
        }
        // a^b = exp(b ln a); the value itself comes from the same function as without derivatives.
        let log = self.unary(UnaryFunction::Ln).times(exponent);
        log.chain(value, value, value)
    }
}

impl Number for Jet {
    fn constant(value: f64) -> Self {
        Self { value, first: 0.0, second: 0.0 }
    }

    fn unary(self, function: UnaryFunction) -> Self {
        let u = self.value;
        let value = u.unary(function);
        let (slope, curvature) = match function {
            UnaryFunction::Negate => (-1.0, 0.0),
            UnaryFunction::Sin => (u.cos(), -value),
            UnaryFunction::Cos => (-u.sin(), -value),
            UnaryFunction::Tan => (1.0 + value * value, 2.0 * value * (1.0 + value * value)),
            UnaryFunction::Asin => (1.0 / (1.0 - u * u).sqrt(), u / (1.0 - u * u).powf(1.5)),
            UnaryFunction::Acos => (-1.0 / (1.0 - u * u).sqrt(), -u / (1.0 - u * u).powf(1.5)),
            UnaryFunction::Atan => {
                let slope = 1.0 / (1.0 + u * u);
                (slope, -2.0 * u * slope * slope)
            }
            UnaryFunction::Sinh => (u.cosh(), value),
            UnaryFunction::Cosh => (u.sinh(), value),
            UnaryFunction::Tanh => (1.0 - value * value, -2.0 * value * (1.0 - value * value)),
            UnaryFunction::Exp => (value, value),
            UnaryFunction::Ln => (1.0 / u, -1.0 / (u * u)),
            UnaryFunction::Sqrt => (0.5 / value, -0.25 / (value * value * value)),
            UnaryFunction::Abs | UnaryFunction::Ramp if u >= 0.0 => (1.0, 0.0),
            UnaryFunction::Abs => (-1.0, 0.0),
            UnaryFunction::Ramp | UnaryFunction::Floor | UnaryFunction::Step => (0.0, 0.0),
        };
        self.chain(value, slope, curvature)
    }

    fn binary(self, other: Self, function: BinaryFunction) -> Self {
        let exact = self.value.binary(other.value, function);
        let jet = match function {
            BinaryFunction::Add => self.plus(other),
            BinaryFunction::Subtract => self.plus(other.unary(UnaryFunction::Negate)),
            BinaryFunction::Multiply => self.times(other),
            BinaryFunction::Divide => {
                let v = other.value;
                self.times(other.chain(1.0 / v, -1.0 / (v * v), 2.0 / (v * v * v)))
            }
            BinaryFunction::Power => self.power(other),
            BinaryFunction::Minimum if takes_first(self.value, other.value, self.value < other.value) => self,
            BinaryFunction::Maximum if takes_first(self.value, other.value, self.value > other.value) => self,
            BinaryFunction::Minimum | BinaryFunction::Maximum => other,
        };
        // a·(1/b) rounds otherwise than a/b: the value is the same bits with and without derivatives.
        Self { value: exact, ..jet }
    }
}
