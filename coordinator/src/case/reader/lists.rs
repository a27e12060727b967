//! Reading of vectors, lists, expressions and tables within tables.

use toml::de::DeValue;

use super::{Allowed, At, Coordinates, LONGEST_LIST, SOUND, Table, Written, is_sound, plain_number};
use crate::case::errors::{CaseError, Place};

/// Names of the axes of a case, in order.
const AXIS_NAMES: [&str; 2] = ["[x, y]", "[x, y, z]"];

/// Numbers of components in words.
const COUNT_NAMES: [&str; 2] = ["two", "three"];

impl<'t> Table<'t> {
    /// Takes the number of dimensions of the case from the vector `key` of the table `owner`: three where it has three
    /// numbers, else two.
    pub fn take_dimensions(&mut self, owner: &str, key: &str) {
        let table =
            self.entries.and_then(|entries| entries.get(owner)).and_then(|value| value.get_ref().as_table());
        let vector = table.and_then(|table| table.get(key)).and_then(|value| value.get_ref().as_array());
        self.dimensions = if vector.is_some_and(|list| list.len() == 3) { 3 } else { 2 };
    }

    /// `[x, y]` or `[x, y, z]`, with their number.
    fn vector_words(&self, what: &str) -> String {
        let k = self.dimensions - 2;
        format!("{} {what}, {}", COUNT_NAMES[k], AXIS_NAMES[k])
    }

    /// A vector that must be written.
    pub fn vector(&mut self, key: &'static str) -> At<Coordinates> {
        let found = self.demand(key).and_then(|(value, place)| self.as_vector(value, &place));
        self.or_default(key, found, Coordinates::repeat(self.dimensions, 0.0))
    }

    /// A vector that may be left out.
    pub fn optional_vector(&mut self, key: &'static str) -> Option<At<Coordinates>> {
        let (value, place) = self.take(key)?;
        let value = self.as_vector(value, &place)?;
        Some(At { value, place })
    }

    /// A vector with a default.
    pub fn vector_or(&mut self, key: &'static str, default: Coordinates) -> At<Coordinates> {
        let found = self.optional_vector(key).map(|at| at.value);
        self.or_default(key, found, default)
    }

    fn as_vector(&self, value: &DeValue<'_>, place: &Place) -> Option<Coordinates> {
        let words = format!("{}, each {SOUND}", self.vector_words("finite numbers"));
        match value.as_array() {
            Some(list) if list.len() == self.dimensions => {
                let components: Option<Vec<f64>> =
                    list.iter().map(|item| plain_number(item.get_ref()).filter(|x| is_sound(*x))).collect();
                if let Some(components) = components {
                    return Some(components.into());
                }
                self.error(CaseError::new(place, "wrong value").value(self.written(place)).allowed(words));
            }
            Some(list) if list.len() == 5 - self.dimensions => {
                self.other_dimensions(list.len(), place, words)
            }
            _ => self.wrong_type(value, place, &words),
        }
        None
    }

    /// A vector of the other number of dimensions.
    fn other_dimensions(&self, count: usize, place: &Place, allowed: String) {
        let problem = format!("has {count} components, in a case of {} dimensions", self.dimensions);
        let error = CaseError::new(place, problem).value(self.written(place)).allowed(allowed);
        self.error(
            error.hint(
                "the number of dimensions is that of `domain.lower_m`; all vectors have as many numbers",
            ),
        );
    }

    /// A list of points that must be written.
    pub fn points(&mut self, key: &'static str) -> Option<At<Vec<Coordinates>>> {
        let (value, place) = self.demand(key)?;
        let items = self.as_list(value, &place)?;
        let points: Vec<Coordinates> =
            items.into_iter().filter_map(|(item, place)| self.as_vector(item, &place)).collect();
        Some(At { value: points, place })
    }

    /// A list of numbers.
    pub fn optional_numbers(&mut self, key: &'static str) -> Option<At<Vec<f64>>> {
        let allowed = &self.list_range(key);
        let (value, place) = self.take(key)?;
        let items = self.as_list(value, &place)?;
        let numbers =
            items.into_iter().filter_map(|(item, place)| self.as_number(item, &place, allowed)).collect();
        Some(At { value: numbers, place })
    }

    /// A list of texts.
    pub fn optional_texts(&mut self, key: &'static str) -> Option<At<Vec<String>>> {
        let (value, place) = self.take(key)?;
        let items = self.as_list(value, &place)?;
        let texts =
            items.into_iter().filter_map(|(item, place)| Some(self.as_text(item, place)?.value)).collect();
        Some(At { value: texts, place })
    }

    /// A number or an expression in quotes that may be left out.
    pub fn optional_written(&mut self, key: &'static str) -> Option<At<Written>> {
        let (value, place) = self.take(key)?;
        self.as_written(value, place)
    }

    /// Numbers or expressions in quotes, one for each axis, that may be left out.
    pub fn optional_written_components(&mut self, key: &'static str) -> Option<Vec<At<Written>>> {
        let (value, place) = self.take(key)?;
        let words = self.vector_words("numbers or expressions in quotes");
        let items = match value.as_array() {
            Some(list) if list.len() == self.dimensions => self.as_list(value, &place)?,
            Some(list) if list.len() == 5 - self.dimensions => {
                self.other_dimensions(list.len(), &place, words);
                return None;
            }
            _ => {
                self.wrong_type(value, &place, &words);
                return None;
            }
        };
        items.into_iter().map(|(item, place)| self.as_written(item, place)).collect()
    }

    fn as_written(&self, value: &DeValue<'_>, place: Place) -> Option<At<Written>> {
        if let Some(text) = value.as_str() {
            return Some(At { value: Written::Text(text.to_owned()), place });
        }
        if plain_number(value).is_none() {
            self.wrong_type(value, &place, "a number or an expression in quotes");
            return None;
        }
        let number = self.as_number(value, &place, &Allowed::FINITE)?;
        Some(At { value: Written::Number(number), place })
    }

    /// A table that may be left out; left out, it reads as empty.
    pub fn table_or_empty(&mut self, key: &'static str) -> Table<'t> {
        self.optional_table(key).unwrap_or_else(|| {
            let place = self.place_of(key);
            self.child(self.inner(key), None, place)
        })
    }

    /// A table that may be left out.
    pub fn optional_table(&mut self, key: &'static str) -> Option<Table<'t>> {
        let (value, place) = self.take(key)?;
        self.as_table(key, value, place)
    }

    /// A table that must be written.
    pub fn required_table(&mut self, key: &'static str) -> Option<Table<'t>> {
        let (value, place) = self.demand(key)?;
        self.as_table(key, value, place)
    }

    fn as_table(&self, key: &str, value: &'t DeValue<'t>, place: Place) -> Option<Table<'t>> {
        match value.as_table() {
            Some(entries) => Some(self.child(self.inner(key), Some(entries), place)),
            None => {
                self.wrong_type(value, &place, "a table");
                None
            }
        }
    }

    /// All tables of a list.
    pub fn tables(&mut self, key: &'static str) -> Vec<Table<'t>> {
        let Some((value, place)) = self.take(key) else { return Vec::new() };
        if value.is_table() {
            let hint = format!("write [[{}]] for each", without_indices(&place.key));
            self.error(CaseError::new(&place, "must be a list of tables").hint(hint));
            return Vec::new();
        }
        let items = self.as_list(value, &place).unwrap_or_default();
        items.into_iter().filter_map(|(item, place)| self.as_table(key, item, place)).collect()
    }

    pub(super) fn as_list(
        &self,
        value: &'t DeValue<'t>,
        place: &Place,
    ) -> Option<Vec<(&'t DeValue<'t>, Place)>> {
        let Some(list) = value.as_array() else {
            self.wrong_type(value, place, "a list");
            return None;
        };
        if list.len() > LONGEST_LIST {
            let error = CaseError::new(place, format!("has {} entries", list.len()));
            self.error(error.allowed(format!("at most {LONGEST_LIST} entries")));
            return None;
        }
        let entry = |(index, item): (usize, &'t toml::Spanned<DeValue<'t>>)| {
            let place = Place { key: format!("{}[{index}]", place.key), span: Some(item.span()) };
            (item.get_ref(), place)
        };
        Some(list.iter().enumerate().map(entry).collect())
    }
}

/// `a.b[3]` as it stands in a header: `a.b`.
fn without_indices(key: &str) -> String {
    let mut depth = 0;
    let outside = |c: &char| {
        match c {
            '[' => depth += 1,
            ']' => depth -= 1,
            _ => return depth == 0,
        }
        false
    };
    key.chars().filter(outside).collect()
}
