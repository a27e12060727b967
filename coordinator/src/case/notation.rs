//! The notation of a case file: TOML, of a size that can be held.

use toml::Spanned;
use toml::de::{DeTable, Error};

use super::errors::{CaseError, ErrorList, Place};

/// Most tables of a case file: each costs a thousand bytes, however short it is written.
const MOST_TABLES: usize = 100_000;

/// Of a larger text only the first error of notation is looked for: all of them could fill the memory.
const SEARCHED: usize = 64 << 10;

/// The table that `text` means; nothing when it is no TOML.
pub fn parse<'t>(text: &'t str, errors: &ErrorList) -> Option<Spanned<DeTable<'t>>> {
    let tables = tables_at_most(text);
    if tables > MOST_TABLES {
        let error = CaseError::new(&Place { key: String::new(), span: None }, "too many tables");
        errors.add(error.value(tables).allowed(format!("at most {MOST_TABLES} tables")));
        return None;
    }
    let problem = match DeTable::parse(text) {
        Ok(table) => return Some(table),
        Err(problem) => problem,
    };
    let problems = if text.len() <= SEARCHED { DeTable::parse_recoverable(text).1 } else { vec![problem] };
    for problem in &problems {
        report(problem, errors);
    }
    None
}

fn report(problem: &Error, errors: &ErrorList) {
    let place = Place { key: String::new(), span: Some(problem.span().unwrap_or(0..0)) };
    let error = CaseError::new(&place, format!("not TOML: {}", problem.message()));
    errors.add(error.hint("see https://toml.io for the notation"));
}

/// A number of tables that `text` does not exceed: each begins with a brace, a header or a dot in a key.
fn tables_at_most(text: &str) -> usize {
    let mut tables = 0;
    for line in text.lines() {
        let mut dots = 0;
        // A list of numbers has commas; a header has none outside quotes.
        if line.trim_start().starts_with('[') && (!line.contains(',') || line.contains(['"', '\''])) {
            tables += 1 + line.bytes().filter(|byte| *byte == b'.').count();
        }
        for byte in line.bytes() {
            match byte {
                b'.' => dots += 1,
                b'=' => tables += std::mem::take(&mut dots),
                b'{' => (tables, dots) = (tables + 1, 0),
                b',' | b'[' | b']' | b'}' => dots = 0,
                _ => {}
            }
        }
    }
    tables
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_counted_and_numbers_are_none() {
        assert_eq!(tables_at_most("[a]\nb = 1.5\nc = [0.1, 0.2]\n"), 1);
        assert_eq!(tables_at_most("a.b.c = 1\n[x.y]\nz = { p = 0.1, q.r = 2.5 }\n"), 6);
        assert_eq!(tables_at_most("points = [\n  0.5, 0.25,\n  [0.125, 0.5],\n]\n"), 0);
        assert_eq!(tables_at_most("[\"a,b\".c]\n"), 2);
    }

    #[test]
    fn a_text_of_tables_or_of_errors_alone_fills_no_memory() {
        let count = |text: &str| {
            let errors = ErrorList::default();
            assert!(parse(text, &errors).is_none());
            errors.count()
        };
        assert_eq!(count(&"x = [{a=1}]\n".repeat(200_000)), 1);
        assert_eq!(count(&format!("k{} = 1\n", ".a".repeat(70)).repeat(3000)), 1);
        assert_eq!(count(&"= \n".repeat(100_000)), 1);
        assert!(count("a = = 3\nb = \n") > 1, "a short text has all its errors listed");
    }
}
