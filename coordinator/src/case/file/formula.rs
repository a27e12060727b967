//! Numbers or expressions as a case file writes them, checked where they are read.

use sph::expression::Expression;
use sph::space::Space;

use crate::case::errors::{CaseError, Place};
use crate::case::reader::{At, Table, Written};

/// Checks the expression; the error points at the character.
fn check(table: &Table<'_>, key: &str, written: &At<Written>) {
    let variables = table.variables(key);
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
pub fn read(table: &mut Table<'_>, key: &'static str) -> At<Written> {
    let zero = At { value: Written::Number(0.0), place: table.place_of(key) };
    let written = table.optional_written(key).unwrap_or(zero);
    check(table, key, &written);
    written
}

/// Checked expressions under `key`, one for each axis, if written.
pub fn read_components(table: &mut Table<'_>, key: &'static str) -> Option<Vec<At<Written>>> {
    let components = table.optional_written_components(key)?;
    components.iter().for_each(|written| check(table, key, written));
    Some(components)
}

/// A zero for each of `dimensions` axes at `place`.
pub fn zeros(dimensions: usize, place: &Place) -> Vec<At<Written>> {
    vec![At { value: Written::Number(0.0), place: place.clone() }; dimensions]
}

/// The texts of expressions in the space of the case; zeros where there are too few.
pub fn texts<S: Space>(components: &[At<Written>]) -> S::PerAxis<String> {
    S::per_axis(|axis| components.get(axis).map_or_else(|| "0".to_owned(), |written| written.value.text()))
}
