//! Texts, names and words of closed lists.

use toml::de::DeValue;

use super::{Table, join};
use crate::case::errors::{CaseError, Place, suggestion};
use crate::case::reader::value::{At, Choice};
use crate::case::spec::Fallback;

impl<'t> Table<'t> {
    /// Yes or no, with a constant default.
    pub fn flag(&mut self, key: &'static str) -> bool {
        let default = matches!(self.fallback(key), Fallback::Flag(true));
        self.optional_flag(key).unwrap_or(default)
    }

    /// Yes or no, where `key` is written.
    pub(super) fn optional_flag(&mut self, key: &'static str) -> Option<bool> {
        let (value, place) = self.take(key)?;
        let found = value.as_bool();
        if found.is_none() {
            self.wrong_type(value, &place, "true or false");
        }
        found
    }

    /// The text under `key`, which is read elsewhere.
    pub fn peek_text(&self, key: &str) -> Option<&'t str> {
        self.entries.and_then(|entries| entries.get(key)).and_then(|value| value.get_ref().as_str())
    }

    /// A text that may be left out.
    pub fn optional_text(&mut self, key: &'static str) -> Option<At<String>> {
        let (value, place) = self.take(key)?;
        self.as_text(value, place)
    }

    /// A text that must be written.
    pub fn text(&mut self, key: &'static str) -> At<String> {
        let found = self.demand(key).and_then(|(value, place)| self.as_text(value, place));
        found.unwrap_or_else(|| At { value: String::new(), place: self.place_of(key) })
    }

    pub(super) fn as_text(&self, value: &DeValue<'_>, place: Place) -> Option<At<String>> {
        let Some(text) = value.as_str() else {
            self.wrong_type(value, &place, "a text in quotes");
            return None;
        };
        Some(At { value: text.to_owned(), place })
    }

    /// A name that must be written: letters, digits, `_` and `-`.
    pub fn name(&mut self, key: &'static str) -> At<String> {
        let name = self.text(key);
        self.check_name(&name);
        name
    }

    /// A name that may be left out.
    pub fn optional_name(&mut self, key: &'static str) -> Option<At<String>> {
        let name = self.optional_text(key)?;
        self.check_name(&name);
        Some(name)
    }

    fn check_name(&self, name: &At<String>) {
        let good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let written = !self.missing.iter().any(|key| name.place.key == join(&self.place.key, key));
        if written && (name.value.is_empty() || name.value.len() > 64 || !name.value.chars().all(good)) {
            let error = CaseError::new(&name.place, "not a name").value(self.written(&name.place));
            self.error(error.allowed("1 to 64 letters, digits, `_` or `-`"));
        }
    }

    /// One of a list of words, which must be written.
    pub fn choice<T: Clone>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
    ) -> Option<Choice<T>> {
        self.check_options(key, options);
        let (value, place) = self.demand(key)?;
        let found = self.as_choice(value, place, options)?;
        self.select(key, found.word);
        Some(found)
    }

    /// One of a list of words with a constant default.
    pub fn choice_or_default<T: Clone>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
    ) -> Choice<T> {
        let default = self.default_choice(key, options);
        self.optional_choice(key, options).unwrap_or(default)
    }

    /// The choice that holds where `key` is left out.
    pub(super) fn default_choice<T: Clone>(&self, key: &str, options: &[(&'static str, T)]) -> Choice<T> {
        let default = if let Fallback::Word(word) = self.fallback(key) { word } else { "" };
        let (word, value) = options.iter().find(|(word, _)| *word == default).unwrap_or(&options[0]);
        Choice { word, value: value.clone(), place: self.place_of(key) }
    }

    /// One of a list of words; `default` is one of their values.
    pub fn choice_or<T: Clone + PartialEq>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
        default: T,
    ) -> Choice<T> {
        let word = options.iter().find(|(_, value)| *value == default).map_or("", |(word, _)| *word);
        self.select(key, word);
        let found = self.optional_choice(key, options);
        found.unwrap_or_else(|| Choice { word, value: default, place: self.place_of(key) })
    }

    /// One of `options`, where `key` is written.
    pub fn optional_choice<T: Clone>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
    ) -> Option<Choice<T>> {
        self.check_options(key, options);
        let found = self.optional_word(key, options)?;
        self.select(key, found.word);
        Some(found)
    }

    pub(super) fn optional_word<T: Clone>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
    ) -> Option<Choice<T>> {
        self.take(key).and_then(|(value, place)| self.as_choice(value, place, options))
    }

    pub(super) fn as_choice<T: Clone>(
        &self,
        value: &DeValue<'_>,
        place: Place,
        options: &[(&'static str, T)],
    ) -> Option<Choice<T>> {
        let words: Vec<&str> = options.iter().map(|(word, _)| *word).collect();
        let allowed = format!("\"{}\"", words.join("\", \""));
        let Some(text) = value.as_str() else {
            self.wrong_type(value, &place, &allowed);
            return None;
        };
        let found = options.iter().find(|(word, _)| *word == text);
        if found.is_none() {
            let error = CaseError::new(&place, "unknown word").value(self.written(&place)).allowed(allowed);
            let hint = suggestion(text, words.iter().copied()).map(|word| format!("did you mean `{word}`?"));
            self.error(match hint {
                Some(hint) => error.hint(hint),
                None => error,
            });
        }
        found.map(|(word, value)| Choice { word, value: value.clone(), place })
    }

    /// Words of a list, each at most once.
    pub fn words<T: Clone>(
        &mut self,
        key: &'static str,
        options: &[(&'static str, T)],
    ) -> Option<Vec<Choice<T>>> {
        self.check_options(key, options);
        let (value, place) = self.take(key)?;
        let items = self.as_list(value, &place)?;
        let mut found: Vec<Choice<T>> = Vec::new();
        for (item, place) in items {
            let Some(choice) = self.as_choice(item, place, options) else { continue };
            if found.iter().any(|earlier| earlier.word == choice.word) {
                self.error(CaseError::new(&choice.place, "named twice").value(self.written(&choice.place)));
            }
            found.push(choice);
        }
        Some(found)
    }
}
