//! Properties of expressions on random texts: what is printed reads back as the same value, derivatives are those of the
//! value, and no text makes the parser fail.

use proptest::prelude::*;
use sph::expression::Expression;

/// An expression of `x` and `t` that stays smooth and of order one where both lie in [0.2, 2].
#[derive(Clone, Debug)]
enum Tree {
    Number(f64),
    Variable(usize),
    Negated(Box<Tree>),
    Binary(char, Box<Tree>, Box<Tree>),
    Function(&'static str, Box<Tree>),
}

const VARIABLES: [&str; 2] = ["x", "t"];

fn trees() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![(0.1..3.0f64).prop_map(Tree::Number), (0..2usize).prop_map(Tree::Variable)];
    leaf.prop_recursive(5, 24, 2, |inner| {
        let operators = prop_oneof![Just('+'), Just('-'), Just('*')];
        let functions = prop_oneof![Just("sin"), Just("cos"), Just("tanh"), Just("atan")];
        prop_oneof![
            inner.clone().prop_map(|a| Tree::Negated(Box::new(a))),
            (operators, inner.clone(), inner.clone()).prop_map(|(sign, a, b)| Tree::Binary(
                sign,
                Box::new(a),
                Box::new(b)
            )),
            (functions, inner).prop_map(|(name, a)| Tree::Function(name, Box::new(a))),
        ]
    })
}

impl Tree {
    /// As text, with all parentheses, or with those alone that the rules of precedence ask for.
    fn text(&self, all: bool) -> String {
        match self {
            Self::Number(value) => format!("{value:e}"),
            Self::Variable(index) => VARIABLES[*index].to_owned(),
            Self::Negated(a) => format!("-({})", a.text(all)),
            Self::Binary(sign, a, b) => {
                let side = |tree: &Self, right: bool| match tree {
                    Self::Binary(inner, ..) if all || (*sign == '*' && *inner != '*') || right => {
                        format!("({})", tree.text(all))
                    }
                    _ => tree.text(all),
                };
                format!("{}{sign}{}", side(a, false), side(b, true))
            }
            Self::Function(name, a) => format!("{name}( {} )", a.text(all)),
        }
    }

    fn value(&self, at: [f64; 2]) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Variable(index) => at[*index],
            Self::Negated(a) => -a.value(at),
            Self::Binary('+', a, b) => a.value(at) + b.value(at),
            Self::Binary('-', a, b) => a.value(at) - b.value(at),
            Self::Binary(_, a, b) => a.value(at) * b.value(at),
            Self::Function("sin", a) => a.value(at).sin(),
            Self::Function("cos", a) => a.value(at).cos(),
            Self::Function("tanh", a) => a.value(at).tanh(),
            Self::Function(_, a) => a.value(at).atan(),
        }
    }
}

proptest! {
    #[test]
    fn a_text_has_the_value_of_its_tree(tree in trees(), x in 0.2..2.0f64, t in 0.2..2.0f64) {
        for all in [true, false] {
            let text = tree.text(all);
            let expression = Expression::parse(&text, &VARIABLES).unwrap();
            // The same operations in the same order: the same bits.
            prop_assert_eq!(expression.eval(&[x, t]).to_bits(), tree.value([x, t]).to_bits(), "{}", text);
        }
    }

    #[test]
    fn derivatives_are_those_of_the_value(tree in trees(), x in 0.2..2.0f64, t in 0.2..2.0f64) {
        let expression = Expression::parse(&tree.text(true), &VARIABLES).unwrap();
        let found = expression.derivatives(&[x, t], 1);
        prop_assert_eq!(found.value.to_bits(), expression.eval(&[x, t]).to_bits());
        let at = |t: f64| expression.derivatives(&[x, t], 1);
        let step = 1e-4;
        let (before, after) = (at(t - step), at(t + step));
        // Central differences err by step²/6 of a derivative two orders up. It is bounded by what the differences
        // themselves change over the step, plus round-off.
        let first = (after.value - before.value) / (2.0 * step);
        let second = (after.first - before.first) / (2.0 * step);
        let bend = (after.second - before.second).abs() * step + step * step * (1.0 + found.second.abs());
        prop_assert!((found.first - first).abs() <= 10.0 * bend + 1e-9 * (1.0 + found.value.abs()), "{first}");
        let scale = (after.second - before.second).abs() + step * (1.0 + found.second.abs());
        prop_assert!((found.second - second).abs() <= 10.0 * scale + 1e-8 * (1.0 + found.first.abs()), "{second}");
    }

    #[test]
    fn any_text_is_read_or_refused_at_a_place_inside_it(text in "[-+*/^(),. a-z0-9é]{0,40}") {
        match Expression::parse(&text, &VARIABLES) {
            Ok(expression) => drop(expression.eval(&[0.5, 0.5])),
            Err(error) => {
                prop_assert!(!error.to_string().is_empty());
                if let Some(span) = error.span() {
                    prop_assert!(span.start <= span.end && span.end <= text.len(), "{:?}", span);
                }
            }
        }
    }
}
