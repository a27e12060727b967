//! Reading of vectors, lists, expressions and tables within tables.

use sph::space::Vector;
use toml::de::DeValue;

use super::{Allowed, At, LONGEST_LIST, SOUND, Table, Written, is_sound, plain_number};
use crate::case::errors::{CaseError, Place};

impl<'t> Table<'t> {
    /// Two numbers, x and y, which must be written.
    pub fn vector(&mut self, key: &'static str) -> At<Vector> {
        let found = self.demand(key).and_then(|(value, place)| self.as_vector(value, &place));
        self.or_default(key, found, Vector::zeros())
    }

    /// Two numbers, x and y, that may be left out.
    pub fn optional_vector(&mut self, key: &'static str) -> Option<At<Vector>> {
        let (value, place) = self.take(key)?;
        let value = self.as_vector(value, &place)?;
        Some(At { value, place })
    }

    /// Two numbers, x and y, with a default.
    pub fn vector_or(&mut self, key: &'static str, default: Vector) -> At<Vector> {
        let found = self.optional_vector(key).map(|at| at.value);
        self.or_default(key, found, default)
    }

    fn as_vector(&self, value: &DeValue<'_>, place: &Place) -> Option<Vector> {
        let words = format!("two finite numbers, [x, y], each {SOUND}");
        match value.as_array() {
            Some(list) if list.len() == 2 => {
                let mut components = list.iter().map(|item| plain_number(item.get_ref()));
                if let (Some(Some(x)), Some(Some(y))) = (components.next(), components.next())
                    && is_sound(x)
                    && is_sound(y)
                {
                    return Some(Vector::new(x, y));
                }
                self.error(CaseError::new(place, "wrong value").value(self.written(place)).allowed(words));
            }
            _ => self.wrong_type(value, place, &words),
        }
        None
    }

    /// A list of points that must be written.
    pub fn points(&mut self, key: &'static str) -> Option<At<Vec<Vector>>> {
        let (value, place) = self.demand(key)?;
        let items = self.as_list(value, &place)?;
        let points: Vec<Vector> =
            items.into_iter().filter_map(|(item, place)| self.as_vector(item, &place)).collect();
        Some(At { value: points, place })
    }

    /// A list of numbers.
    pub fn optional_numbers(&mut self, key: &'static str, allowed: &Allowed) -> Option<At<Vec<f64>>> {
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

    /// A pair of numbers or expressions in quotes that may be left out.
    pub fn optional_written_pair(&mut self, key: &'static str) -> Option<[At<Written>; 2]> {
        let (value, place) = self.take(key)?;
        let items = match value.as_array() {
            Some(list) if list.len() == 2 => self.as_list(value, &place)?,
            _ => {
                self.wrong_type(value, &place, "two numbers or expressions in quotes, [x, y]");
                return None;
            }
        };
        let mut found = items.into_iter().filter_map(|(item, place)| self.as_written(item, place));
        Some([found.next()?, found.next()?])
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
            self.child(None, place)
        })
    }

    /// A table that may be left out.
    pub fn optional_table(&mut self, key: &'static str) -> Option<Table<'t>> {
        let (value, place) = self.take(key)?;
        self.as_table(value, place)
    }

    /// A table that must be written.
    pub fn required_table(&mut self, key: &'static str) -> Option<Table<'t>> {
        let (value, place) = self.demand(key)?;
        self.as_table(value, place)
    }

    fn as_table(&self, value: &'t DeValue<'t>, place: Place) -> Option<Table<'t>> {
        match value.as_table() {
            Some(entries) => Some(self.child(Some(entries), place)),
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
        items.into_iter().filter_map(|(item, place)| self.as_table(item, place)).collect()
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
