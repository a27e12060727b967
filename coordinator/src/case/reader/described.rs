//! What the rows of a table say of its keys.
//!
//! A key that is read without a row, or otherwise than its row says, is an error of every case: schema and documents
//! would lack it.

use sph::setup::Allowed;

use super::Table;
use crate::case::errors::CaseError;
use crate::case::spec::{Fallback, Kind, TableSpec, Variables, Words};

/// Stands in for the rows of a table that has none.
static NONE: TableSpec = TableSpec::new("none", "", &[]);

impl Table<'_> {
    fn undescribed(&self, key: &str) {
        let problem = format!("has no fitting row in the table `{}` of the program", self.spec.name);
        self.error(CaseError::new(&self.place_of(key), problem).hint("please report this"));
    }

    /// Notes a key that no row describes.
    pub(super) fn check_described(&self, key: &'static str) {
        if !self.spec.has(key, self.variant) {
            self.undescribed(key);
        }
        #[cfg(test)]
        if self.has(key) {
            crate::case::spec::read::note(self.spec.name, self.variant, key);
        }
    }

    /// What `pick` takes from the kind of `key`.
    fn picked<T>(&self, key: &str, pick: impl Fn(Kind) -> Option<T>) -> Option<T> {
        let row = self.spec.row(key, self.variant)?;
        let picked = pick(row.kind);
        if picked.is_none() {
            self.undescribed(key);
        }
        picked
    }

    /// What holds where `key` is left out.
    pub(super) fn fallback(&self, key: &str) -> Fallback {
        match &self.spec.variants {
            Some(variants) if variants.tag == key => variants.fallback,
            _ => self.spec.row(key, self.variant).map_or(Fallback::Required, |row| row.fallback),
        }
    }

    /// Range of a number.
    pub(super) fn range(&self, key: &str) -> Allowed {
        let allowed = self.picked(key, |kind| match kind {
            Kind::Number(allowed) | Kind::NumberOrWord(allowed, _) => Some(allowed),
            // In the plane.
            Kind::Spin => Some(Allowed::FINITE),
            _ => None,
        });
        allowed.unwrap_or(Allowed::FINITE)
    }

    /// Range of the numbers of a list.
    pub(super) fn list_range(&self, key: &str) -> Allowed {
        self.picked(key, |kind| if let Kind::Numbers(allowed) = kind { Some(allowed) } else { None })
            .unwrap_or(Allowed::FINITE)
    }

    /// First and last of a whole number.
    pub(super) fn count_range(&self, key: &str) -> (u64, u64) {
        let range = self.picked(key, |kind| match kind {
            Kind::Count(first, last) | Kind::CountOrWord(first, last, _) => Some((first, last)),
            _ => None,
        });
        range.unwrap_or((0, u64::MAX))
    }

    /// Variables of an expression.
    pub fn variables(&self, key: &str) -> &'static [&'static str] {
        let variables = self.picked(key, |kind| match kind {
            Kind::Expression(variables) | Kind::Expressions(variables) => Some(variables),
            _ => None,
        });
        variables.unwrap_or(Variables::Time).names(self.dimensions)
    }

    /// Rows of the table or of the tables under `key`.
    pub(super) fn inner(&self, key: &str) -> &'static TableSpec {
        let inner = self.picked(key, |kind| match kind {
            Kind::Table(spec) | Kind::Tables(spec) => Some(spec),
            _ => None,
        });
        inner.unwrap_or(&NONE)
    }

    /// Notes words that are read and not described.
    pub(super) fn check_options<T>(&self, key: &str, options: &[(&'static str, T)]) {
        let is_tag = self.spec.variants.is_some_and(|variants| variants.tag == key);
        let is_described = |word: &str| match is_tag {
            true => self.spec.has_variant(word),
            false => self.described_words(key).iter().any(|(known, _)| *known == word),
        };
        // Lists of axes, sides and shapes are longer than those of one number of dimensions.
        let is_whole =
            is_tag || self.is_of_dimensions(key) || self.described_words(key).len() == options.len();
        if !is_whole || !options.iter().all(|(word, _)| is_described(word)) {
            self.undescribed(key);
        }
    }

    fn is_of_dimensions(&self, key: &str) -> bool {
        self.spec.row(key, self.variant).is_some_and(|row| matches!(row.kind, Kind::SomeWords(_)))
    }

    fn described_words(&self, key: &str) -> Words {
        let words = self.picked(key, |kind| match kind {
            Kind::Word(words)
            | Kind::SomeWords(words)
            | Kind::NumberOrWord(_, words)
            | Kind::CountOrWord(_, _, words) => Some(words),
            _ => None,
        });
        words.unwrap_or_default()
    }

    /// Notes the word on which further keys depend.
    pub(super) fn select(&mut self, key: &str, word: &'static str) {
        if self.spec.variants.is_some_and(|variants| variants.tag == key) {
            self.variant = Some(word);
        }
    }
}
