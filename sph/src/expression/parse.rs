//! Text to instructions, with the place of every mistake.

use std::ops::Range;

use super::jet::Number;
use super::{
    BinaryFunction, ExpressionError, Instruction, MAXIMUM_DEPTH, MAXIMUM_LENGTH, STACK_SIZE, UnaryFunction,
};

const UNARY_FUNCTIONS: [(&str, UnaryFunction); 16] = [
    ("sin", UnaryFunction::Sin),
    ("cos", UnaryFunction::Cos),
    ("tan", UnaryFunction::Tan),
    ("asin", UnaryFunction::Asin),
    ("acos", UnaryFunction::Acos),
    ("atan", UnaryFunction::Atan),
    ("sinh", UnaryFunction::Sinh),
    ("cosh", UnaryFunction::Cosh),
    ("tanh", UnaryFunction::Tanh),
    ("exp", UnaryFunction::Exp),
    ("ln", UnaryFunction::Ln),
    ("sqrt", UnaryFunction::Sqrt),
    ("abs", UnaryFunction::Abs),
    ("floor", UnaryFunction::Floor),
    ("step", UnaryFunction::Step),
    ("ramp", UnaryFunction::Ramp),
];

const LIST_FUNCTIONS: [(&str, BinaryFunction); 2] =
    [("min", BinaryFunction::Minimum), ("max", BinaryFunction::Maximum)];

const CONSTANTS: [(&str, f64); 1] = [("pi", std::f64::consts::PI)];

const OPERAND: &str = "a number, a name or `(`";
const OPERATOR: &str = "`+`, `-`, `*`, `/`, `^` or the end";

/// Longest piece of a text that a message repeats \[characters\].
const QUOTE_LENGTH: usize = 40;

/// `text`, cut when too long to repeat in a message.
pub(super) fn shortened(text: &str) -> String {
    if text.chars().count() <= QUOTE_LENGTH {
        return text.to_owned();
    }
    text.chars().take(QUOTE_LENGTH).chain(['…']).collect()
}

/// The instructions of `text`.
pub(super) fn compile(text: &str, variables: &[&str]) -> Result<Vec<Instruction>, ExpressionError> {
    if text.len() > MAXIMUM_LENGTH {
        return Err(ExpressionError::TooLong { length: text.len() });
    }
    if text.trim().is_empty() {
        return Err(ExpressionError::Empty);
    }
    let mut parser = Parser { text, variables, at: 0, depth: 0, operands: 0, program: Vec::new() };
    parser.sum()?;
    match parser.peek() {
        None => Ok(parser.program),
        Some(')') => Err(parser.unexpected("an operator or the end: no `(` is open")),
        Some(_) => Err(parser.unexpected(OPERATOR)),
    }
}

struct Parser<'a> {
    text: &'a str,
    variables: &'a [&'a str],
    /// Byte at which the unread text begins; always a character's first.
    at: usize,
    depth: usize,
    /// Operands on the stack after the instructions so far, ignoring that constants are folded.
    operands: usize,
    program: Vec<Instruction>,
}

impl Parser<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    /// Skips spaces and gives the next character.
    fn peek(&mut self) -> Option<char> {
        self.at = self.text.len() - self.rest().trim_start().len();
        self.rest().chars().next()
    }

    /// Takes the next character if it is one of `wanted`, all of which are ASCII.
    fn take(&mut self, wanted: &[char]) -> Option<char> {
        let found = self.peek().filter(|c| wanted.contains(c))?;
        self.at += found.len_utf8();
        Some(found)
    }

    /// Character number, from 1, of a byte.
    fn position(&self, byte: usize) -> usize {
        self.text[..byte].chars().count() + 1
    }

    fn unexpected(&mut self, expected: &'static str) -> ExpressionError {
        let (found, length) = match self.peek() {
            None => ("the end".to_owned(), 0),
            Some(c) => (format!("`{c}`"), c.len_utf8()),
        };
        let span = self.at..self.at + length;
        ExpressionError::Unexpected { found, position: self.position(self.at), expected, span }
    }

    fn too_deep(&self) -> ExpressionError {
        ExpressionError::TooDeep { position: self.position(self.at), span: self.at..self.at }
    }

    /// Runs `part` one level deeper.
    fn nested(
        &mut self,
        part: impl FnOnce(&mut Self) -> Result<(), ExpressionError>,
    ) -> Result<(), ExpressionError> {
        if self.depth == MAXIMUM_DEPTH {
            return Err(self.too_deep());
        }
        self.depth += 1;
        part(self)?;
        self.depth -= 1;
        Ok(())
    }

    fn operand(&mut self, instruction: Instruction) -> Result<(), ExpressionError> {
        if self.operands == STACK_SIZE {
            return Err(self.too_deep());
        }
        self.operands += 1;
        self.program.push(instruction);
        Ok(())
    }

    fn unary(&mut self, function: UnaryFunction) {
        // Constants at the end of the instructions are the function's operands.
        if let Some(Instruction::Constant(value)) = self.program.last_mut() {
            *value = value.unary(function);
        } else {
            self.program.push(Instruction::Unary(function));
        }
    }

    fn binary(&mut self, function: BinaryFunction) {
        self.operands -= 1;
        if let [.., Instruction::Constant(a), Instruction::Constant(b)] = self.program.as_mut_slice() {
            *a = a.binary(*b, function);
            self.program.pop();
        } else {
            self.program.push(Instruction::Binary(function));
        }
    }

    fn sum(&mut self) -> Result<(), ExpressionError> {
        self.product()?;
        while let Some(sign) = self.take(&['+', '-']) {
            self.product()?;
            self.binary(if sign == '+' { BinaryFunction::Add } else { BinaryFunction::Subtract });
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), ExpressionError> {
        self.signed()?;
        while let Some(sign) = self.take(&['*', '/']) {
            self.signed()?;
            self.binary(if sign == '*' { BinaryFunction::Multiply } else { BinaryFunction::Divide });
        }
        Ok(())
    }

    fn signed(&mut self) -> Result<(), ExpressionError> {
        let mut negative = false;
        while let Some(sign) = self.take(&['+', '-']) {
            negative ^= sign == '-';
        }
        self.power()?;
        if negative {
            self.unary(UnaryFunction::Negate);
        }
        Ok(())
    }

    fn power(&mut self) -> Result<(), ExpressionError> {
        self.primary()?;
        if self.take(&['^']).is_some() {
            self.nested(Self::signed)?;
            self.binary(BinaryFunction::Power);
        }
        Ok(())
    }

    fn primary(&mut self) -> Result<(), ExpressionError> {
        match self.peek() {
            Some('(') => {
                self.at += 1;
                self.nested(Self::sum)?;
                self.close()
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.name(),
            _ => Err(self.unexpected(OPERAND)),
        }
    }

    fn close(&mut self) -> Result<(), ExpressionError> {
        match self.take(&[')']) {
            Some(_) => Ok(()),
            None => Err(self.unexpected("an operator or `)`")),
        }
    }

    fn number(&mut self) -> Result<(), ExpressionError> {
        let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
        let rest = self.rest();
        let mut length = digits(rest);
        if rest[length..].starts_with('.') {
            length += 1 + digits(&rest[length + 1..]);
        }
        if let Some(exponent) = rest[length..].strip_prefix(['e', 'E']) {
            let unsigned = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
            if digits(unsigned) > 0 {
                length += 1 + (exponent.len() - unsigned.len()) + digits(unsigned);
            }
        }
        match rest[..length].parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.at += length;
                self.operand(Instruction::Constant(value))
            }
            _ => Err(ExpressionError::Unexpected {
                found: format!("`{}`", shortened(&rest[..length])),
                position: self.position(self.at),
                expected: "a finite number such as `0.5` or `1e-3`",
                span: self.at..self.at + length,
            }),
        }
    }

    fn name(&mut self) -> Result<(), ExpressionError> {
        let length = self.rest().bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
        let span = self.at..self.at + length;
        let text = self.text;
        let name = &text[span.clone()];
        if let Some(index) = self.variables.iter().position(|variable| *variable == name) {
            self.at = span.end;
            return self.operand(Instruction::Variable(index));
        }
        if let Some((_, value)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            self.at = span.end;
            return self.operand(Instruction::Constant(*value));
        }
        if let Some((_, function)) = UNARY_FUNCTIONS.iter().find(|(known, _)| *known == name) {
            let given = self.arguments(&span, |_| ())?;
            if given != 1 {
                return Err(self.wrong_arguments(span, given, "1"));
            }
            self.unary(*function);
            return Ok(());
        }
        if let Some((_, function)) = LIST_FUNCTIONS.iter().find(|(known, _)| *known == name) {
            let given = self.arguments(&span, |parser| parser.binary(*function))?;
            if given < 2 {
                return Err(self.wrong_arguments(span, given, "2 or more"));
            }
            return Ok(());
        }
        Err(ExpressionError::UnknownName {
            name: shortened(name),
            position: self.position(span.start),
            allowed: self.allowed(),
            span,
        })
    }

    /// Reads `(a, b, ...)` after a function's name and gives the number of arguments; `fold` follows each but the
    /// first.
    fn arguments(&mut self, name: &Range<usize>, fold: impl Fn(&mut Self)) -> Result<usize, ExpressionError> {
        self.at = name.end;
        if self.take(&['(']).is_none() {
            return Err(self.unexpected("`(` after the name of a function"));
        }
        let mut given = 1;
        self.nested(Self::sum)?;
        while self.take(&[',']).is_some() {
            self.nested(Self::sum)?;
            fold(self);
            given += 1;
        }
        match self.take(&[')']) {
            Some(_) => Ok(given),
            None => Err(self.unexpected("an operator, `,` or `)`")),
        }
    }

    fn wrong_arguments(&self, span: Range<usize>, given: usize, needed: &'static str) -> ExpressionError {
        ExpressionError::Arguments {
            function: self.text[span.clone()].to_owned(),
            position: self.position(span.start),
            given,
            needed,
            span,
        }
    }

    fn allowed(&self) -> String {
        let variables = if self.variables.is_empty() {
            "no variables".to_owned()
        } else {
            format!("the variables {}", self.variables.join(", "))
        };
        let names = |names: Vec<&str>| names.join(", ");
        format!(
            "{variables}; the constant {}; the functions {}, {}",
            names(CONSTANTS.iter().map(|(name, _)| *name).collect()),
            names(UNARY_FUNCTIONS.iter().map(|(name, _)| *name).collect()),
            names(LIST_FUNCTIONS.iter().map(|(name, _)| *name).collect()),
        )
    }
}
