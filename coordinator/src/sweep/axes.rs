//! What a sweep varies: a key with values, or with a range.

use crate::case::overrides::Override;

/// A key of the case and what it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Path of the key, as for a value set over a case.
    pub key: String,
    /// What it takes.
    pub values: Values,
}

/// What a key takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// These, each in the notation of the file.
    List(Vec<String>),
    /// Numbers of a range.
    Range {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
        /// Whether equal ratios are equally likely, not equal differences.
        logarithmic: bool,
    },
}

impl Values {
    /// The value at `share` in [0, 1) of the way through, in the notation of the file.
    pub fn at(&self, share: f64) -> String {
        match self {
            Self::List(values) => {
                // A share below 1 of a short list.
                let place = (share * values.len() as f64) as usize;
                values[place.min(values.len() - 1)].clone()
            }
            Self::Range { low, high, logarithmic } => {
                let value = match logarithmic {
                    true => low * (high / low).powf(share),
                    false => low + share * (high - low),
                };
                toml::Value::from(value).to_string()
            }
        }
    }
}

impl std::str::FromStr for Axis {
    type Err = String;

    /// Reads `key=a,b,c`, `key=low..high` or `key=low..high:log`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = "write KEY=A,B,C, such as `fluid.sound_speed_m_s=20,40`, or a range KEY=LOW..HIGH or KEY=LOW..HIGH:log";
        let (key, values) = text.split_once('=').ok_or(wrong)?;
        let (key, values) = (key.trim().to_owned(), values.trim());
        if key.is_empty() || values.is_empty() {
            return Err(wrong.to_owned());
        }
        if let Some(range) = range(values) {
            return Ok(Self { key, values: range? });
        }
        let list = split(values).into_iter().map(|value| {
            let set = Override::parse(&format!("{key}={value}"));
            set.map(|set| set.value).map_err(|_| format!("`{text}` has an empty value; {wrong}"))
        });
        let list = list.collect::<Result<Vec<_>, _>>()?;
        if let Some((k, twice)) = list.iter().enumerate().find(|(k, value)| list[..*k].contains(value)) {
            return Err(format!("`{key}` takes {twice} twice (value {})", k + 1));
        }
        Ok(Self { key, values: Values::List(list) })
    }
}

/// A range, where `text` is one.
fn range(text: &str) -> Option<Result<Values, String>> {
    let (low, rest) = text.split_once("..")?;
    let (high, logarithmic) = match rest.strip_suffix(":log") {
        Some(high) => (high, true),
        None => (rest, false),
    };
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    // A text with two dots, such as a path, is a value.
    let (low, high) = (number(low)?, number(high)?);
    Some(match (low < high, logarithmic && low <= 0.0) {
        (false, _) => Err(format!("the range {text} does not go up; write LOW..HIGH")),
        (_, true) => Err(format!("the range {text} has no logarithm; both ends must be above 0")),
        _ => Ok(Values::Range { low, high, logarithmic }),
    })
}

/// The parts of `text` between commas outside of brackets and quotes.
fn split(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth, mut quote) = (Vec::new(), 0, 0_i32, None);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{' | '(') => depth += 1,
            (None, ']' | '}' | ')') => depth -= 1,
            (None, ',') if depth == 0 => {
                parts.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Vec<String> {
        match text.parse::<Axis>().unwrap_or_else(|e| panic!("{text}: {e}")).values {
            Values::List(values) => values,
            range => panic!("{range:?}"),
        }
    }

    #[test]
    fn values_are_split_at_commas_of_their_own_and_words_are_quoted() {
        assert_eq!(list("a.b=1,2e3, -4 "), ["1", "2e3", "-4"]);
        assert_eq!(list("a=linear,tait"), ["\"linear\"", "\"tait\""]);
        assert_eq!(list("a=[1, 2],[3, 4]"), ["[1, 2]", "[3, 4]"]);
        assert_eq!(list("a={ type = \"x\", y = 1 },{ type = \"z\" }").len(), 2);
        assert_eq!(list("a=\"b,c\""), ["\"b,c\""]);
        assert_eq!(list("a=max(t, 1)"), ["\"max(t, 1)\""], "an expression");
        assert_eq!(list("a=../shape.csv"), ["\"../shape.csv\""], "a path is no range");
    }

    #[test]
    fn ranges_go_up() {
        let range = |text: &str| text.parse::<Axis>().map(|axis| axis.values);
        assert_eq!(range("e=1e4..1e6:log"), Ok(Values::Range { low: 1e4, high: 1e6, logarithmic: true }));
        assert_eq!(range("e=-1..2"), Ok(Values::Range { low: -1.0, high: 2.0, logarithmic: false }));
        assert!(range("e=2..1").unwrap_err().contains("does not go up"));
        assert!(range("e=0..1:log").unwrap_err().contains("above 0"));
        let log = range("e=1..100:log").unwrap();
        assert_eq!((log.at(0.0).as_str(), log.at(0.5).as_str()), ("1.0", "10.0"));
        assert_eq!(range("e=1..3").unwrap().at(0.5), "2.0");
        assert_eq!(Values::List(vec!["a".into(), "b".into()]).at(0.999), "b");
    }

    #[test]
    fn what_is_no_axis_is_refused_with_how_to_write_one() {
        for wrong in ["a", "=1", "a=", "a=1,,2", "a=1,2,"] {
            assert!(wrong.parse::<Axis>().unwrap_err().contains("KEY=A,B,C"), "{wrong}");
        }
        assert!("a=1,2,1".parse::<Axis>().unwrap_err().contains("takes 1 twice"));
    }
}
