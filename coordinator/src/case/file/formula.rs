//! Numbers or expressions as a case file writes them, checked where they are read.

use sph::expression::Expression;

use crate::case::errors::{CaseError, Place};
use crate::case::reader::{At, Table, Written};

/// Checks the expression; the error points at the character.
fn check(table: &Table<'_>, written: &At<Written>, variables: &[&str]) {
    let Written::Text(text) = &written.value else { return };
    if let Err(error) = Expression::parse(text, variables) {
        let mut place = written.place.clone();
        let raw = table.written(&place);
        // Positions in the text are positions in the file only where the quotes hold it unchanged.
        if let (Some(inside), Some(span)) = (error.span(), place.span.clone())
            && raw.get(1..raw.len().saturating_sub(1)) == Some(text)
        {
            place.span = Some(span.start + 1 + inside.start..span.start + 1 + inside.end);
        }
        let error = CaseError::new(&place, error.to_string()).value(raw);
        table.error(error.allowed(format!("an expression of {}", variables.join(", "))));
    }
}

/// A checked expression under `key`, or the number 0.
pub fn read(table: &mut Table<'_>, key: &'static str, variables: &[&str]) -> At<Written> {
    let zero = At { value: Written::Number(0.0), place: table.place_of(key) };
    let written = table.optional_written(key).unwrap_or(zero);
    check(table, &written, variables);
    written
}

/// A checked pair of expressions under `key`, if written.
pub fn read_pair(table: &mut Table<'_>, key: &'static str, variables: &[&str]) -> Option<[At<Written>; 2]> {
    let pair = table.optional_written_pair(key)?;
    pair.iter().for_each(|written| check(table, written, variables));
    Some(pair)
}

/// A pair of zeros at `place`.
pub fn zeros(place: &Place) -> [At<Written>; 2] {
    [0.0, 0.0].map(|zero| At { value: Written::Number(zero), place: place.clone() })
}
