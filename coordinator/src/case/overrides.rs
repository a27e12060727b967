//! Values set over those of a case file, by key.
//!
//! They are put into the parsed file before it is read, so that each is checked, completed and reported like a value of the
//! file.

use std::borrow::Cow;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::errors::{CaseError, ErrorList, Place, suggest};
use super::source::Source;

/// Longest override \[bytes\].
const LONGEST: usize = 64 << 10;

/// Most tables and lists that a key may lead through.
const DEEPEST: usize = 20;

/// A value set over that of a case file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Override {
    /// Path of the key, such as `fluid.sound_speed_m_s`. An entry of a list goes by its number from 0 or by its name:
    /// `solid.body[0].material.poisson_ratio`, `solid.body.plate.material.poisson_ratio`.
    pub key: String,
    /// The value in the notation of the file.
    pub value: String,
}

impl Override {
    /// Sets `key` to `value`.
    pub fn new(key: &str, value: impl Into<toml::Value>) -> Self {
        Self { key: key.to_owned(), value: value.into().to_string() }
    }

    /// Reads `key=value`. A value that is no TOML, such as a word without quotes, is a text.
    ///
    /// # Errors
    /// When there is no `=` or no key.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or("write KEY=VALUE, such as `fluid.sound_speed_m_s=40`")?;
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || value.is_empty() {
            return Err("write KEY=VALUE, with a key and a value".to_owned());
        }
        // A word, an expression.
        let is_text = DeValue::parse(value).is_err() && !value.starts_with(['[', '{', '"', '\'']);
        let value = if is_text { toml::Value::from(value).to_string() } else { value.to_owned() };
        Ok(Self { key: key.to_owned(), value })
    }

    /// Key and value.
    pub(super) fn parts(&self) -> (&str, &str) {
        (&self.key, &self.value)
    }
}

/// Starts a line of a resolved case that records a value set over the case file.
const RECORD: &str = "# set: ";

/// Comments for the head of a resolved case that record `overrides`, a line each; [`all`] reads them.
pub fn header(overrides: &[Override]) -> String {
    let line = |Override { key, value }: &Override| format!("{RECORD}{key} = {value}\n");
    overrides.iter().map(line).collect()
}

/// What was set over the file of `source`: recorded at its head where it is a resolved case, and set over it now. Of several
/// values of a key the last one is kept.
pub fn all(source: &Source) -> Vec<Override> {
    let recorded = source.file().lines().map_while(|line| line.strip_prefix(RECORD)?.split_once(" = "));
    let text = source.text();
    let now = source.overrides().iter().map(|(key, value)| (&text[key.clone()], &text[value.clone()]));
    let mut found: Vec<Override> = Vec::new();
    for (key, value) in recorded.chain(now) {
        found.retain(|earlier| earlier.key != key);
        found.push(Override { key: key.to_owned(), value: value.to_owned() });
    }
    found
}

/// Puts the overrides of `source` into the parsed `document` of its file; those that cannot be are errors.
pub fn apply<'t>(source: &'t Source, document: &mut DeTable<'t>, errors: &ErrorList) {
    for (key, value) in source.overrides() {
        let path = &source.text()[key.clone()];
        let place = Place { key: path.to_owned(), span: Some(key.clone()) };
        if let Err(error) = put(source, document, path, value.clone(), &place) {
            errors.add(error);
        }
    }
}

/// Sets what stands at `path` to the value at `span`.
fn put<'t>(
    source: &'t Source,
    document: &mut DeTable<'t>,
    path: &'t str,
    span: Range<usize>,
    place: &Place,
) -> Result<(), CaseError> {
    let steps = steps(path).ok_or_else(|| {
        let hint = "write a path such as `solid.body[0].material.poisson_ratio`";
        CaseError::new(place, "no key of a case").hint(hint)
    })?;
    let written = &source.text()[span.clone()];
    let at_value = Place { key: place.key.clone(), span: Some(span.clone()) };
    if path.len() + written.len() > LONGEST || steps.len() > DEEPEST {
        let allowed = format!("at most {LONGEST} bytes and {DEEPEST} steps");
        return Err(CaseError::new(&at_value, "too long").allowed(allowed));
    }
    let mut value = DeValue::parse(written).map_err(|problem| {
        let error = CaseError::new(&at_value, format!("not TOML: {}", problem.message()));
        error.hint("write a value as in the case file, a text in quotes")
    })?;
    shift(&mut value, span.start);
    let Some(((_, first), rest)) = steps.split_first() else { return Ok(()) };
    let key_span = place.span.clone().unwrap_or_default();
    let mut found = entry(document, first, &key_span, &span);
    for (indexed, step) in rest {
        let problem = |text: String| CaseError::new(place, text);
        found = match found.get_mut() {
            DeValue::Table(table) if !indexed => entry(table, step, &key_span, &span),
            DeValue::Array(list) => {
                let names: Vec<&str> = list.iter().filter_map(|entry| name_of(entry.get_ref())).collect();
                let by_name = (!indexed).then(|| names.iter().position(|name| name == step)).flatten();
                let index: Option<usize> = by_name.or_else(|| step.parse().ok());
                let hint = match names.is_empty() {
                    true => format!("its {} entries are counted from 0", list.len()),
                    false => suggest(step, &names),
                };
                let entry = index.and_then(|index| list.get_mut(index));
                entry.ok_or_else(|| problem(format!("the list has no entry `{step}`")).hint(hint))?
            }
            DeValue::Table(_) => return Err(problem(format!("`[{step}]` follows what is no list"))),
            _ => return Err(problem(format!("`{step}` lies below a plain value"))),
        };
    }
    *found = value;
    Ok(())
}

/// The entry of `key` in `table`, where there is none an empty table that stands at `span`, its key at `key_span`.
fn entry<'d, 't>(
    table: &'d mut DeTable<'t>,
    key: &'t str,
    key_span: &Range<usize>,
    span: &Range<usize>,
) -> &'d mut Spanned<DeValue<'t>> {
    table
        .entry(Spanned::new(key_span.clone(), Cow::Borrowed(key)))
        .or_insert_with(|| Spanned::new(span.clone(), DeValue::Table(DeTable::new())))
}

/// The steps of a path, each with whether it is a number in brackets.
fn steps(path: &str) -> Option<Vec<(bool, &str)>> {
    let is_key = |step: &str| {
        !step.is_empty() && step.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-".contains(&byte))
    };
    let mut steps = Vec::new();
    for part in path.split('.') {
        let mut pieces = part.split('[');
        steps.push((false, pieces.next()?));
        for piece in pieces {
            steps.push((true, piece.strip_suffix(']')?));
        }
    }
    steps.iter().all(|(_, step)| is_key(step)).then_some(steps)
}

fn name_of<'a>(entry: &'a DeValue<'_>) -> Option<&'a str> {
    entry.as_table()?.get("name")?.get_ref().as_str()
}

/// Moves all places within a value by `offset` bytes.
fn shift(value: &mut Spanned<DeValue<'_>>, offset: usize) {
    let span = value.span();
    let mut inner = std::mem::replace(value.get_mut(), DeValue::Boolean(false));
    match &mut inner {
        DeValue::Array(list) => list.iter_mut().for_each(|entry| shift(entry, offset)),
        DeValue::Table(table) => table.iter_mut().for_each(|(_, entry)| shift(entry, offset)),
        _ => {}
    }
    *value = Spanned::new(span.start + offset..span.end + offset, inner);
}
