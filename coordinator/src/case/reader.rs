//! Typed reading of TOML tables that collects every mistake instead of stopping at the first.
//!
//! A key that was asked for is known; [`Table::finish`] reports the others. A value that is missing or wrong is
//! reported and replaced by a fallback, so that reading goes on; nothing is built from such a table later.

use std::ops::Range;
use std::path::Path;

use serde::{Serialize, Serializer};
use sph::vector::Vector;
use toml::de::{DeTable, DeValue};

use super::mistakes::{Mistake, Mistakes, Place, suggest, suggestion};

/// Longest list read from a file; anything longer is refused before it is looked at.
pub const LONGEST_LIST: usize = 10_000;

/// A value with its place in the file.
#[derive(Clone, Debug)]
pub struct At<T> {
    /// The value.
    pub value: T,
    /// Where it stands, or where the table stands that leaves it out.
    pub place: Place,
}

impl<T: Serialize> Serialize for At<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value.serialize(serializer)
    }
}

/// A word of a closed list with its meaning.
#[derive(Clone, Debug)]
pub struct Choice<T> {
    /// The word as written.
    pub word: &'static str,
    /// What it means.
    pub value: T,
    /// Where it stands.
    pub place: Place,
}

impl<T> Serialize for Choice<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.word)
    }
}

/// A range of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    lowest: f64,
    highest: f64,
    includes: (bool, bool),
    fallback: f64,
    words: &'static str,
}

impl Allowed {
    /// Any finite number.
    pub const FINITE: Self = Self::new(f64::MIN, f64::MAX, (true, true), 0.0, "a finite number");
    /// Above zero.
    pub const POSITIVE: Self = Self::new(0.0, f64::MAX, (false, true), 1.0, "a number above 0");
    /// Zero or above.
    pub const NOT_NEGATIVE: Self = Self::new(0.0, f64::MAX, (true, true), 0.0, "a number of 0 or above");
    /// In (0, 1].
    pub const FRACTION: Self = Self::new(0.0, 1.0, (false, true), 1.0, "a number above 0 and at most 1");
    /// In [0, 1].
    pub const SHARE: Self = Self::new(0.0, 1.0, (true, true), 0.0, "a number from 0 to 1");
    /// Kernel ratio h/Δx: below, particles lose their neighbours; above, their number explodes.
    pub const KERNEL_RATIO: Self = Self::new(0.8, 4.0, (true, true), 1.2, "a number from 0.8 to 4 (h/Δx)");

    /// A range from `lowest` to `highest`, ends included or not, told as `words`.
    pub const fn new(
        lowest: f64,
        highest: f64,
        includes: (bool, bool),
        fallback: f64,
        words: &'static str,
    ) -> Self {
        Self { lowest, highest, includes, fallback, words }
    }

    fn holds(&self, value: f64) -> bool {
        let (low, high) = self.includes;
        (value > self.lowest || low && value == self.lowest)
            && (value < self.highest || high && value == self.highest)
    }
}

/// A table of the file while it is read.
pub struct Table<'t> {
    mistakes: &'t Mistakes,
    /// Folder of the case file, against which file names are resolved.
    pub directory: &'t Path,
    source: &'t str,
    entries: Option<&'t DeTable<'t>>,
    place: Place,
    known: Vec<&'static str>,
    missing: Vec<&'static str>,
    mistakes_before: usize,
    abandoned: bool,
}

impl<'t> Table<'t> {
    /// The whole file.
    pub fn root(
        entries: &'t DeTable<'t>,
        source: &'t str,
        directory: &'t Path,
        mistakes: &'t Mistakes,
    ) -> Self {
        // A missing key of the file itself is shown at its start.
        let place = Place { key: String::new(), span: Some(0..0) };
        Self::at(mistakes, directory, source, Some(entries), place)
    }

    fn at(
        mistakes: &'t Mistakes,
        directory: &'t Path,
        source: &'t str,
        entries: Option<&'t DeTable<'t>>,
        place: Place,
    ) -> Self {
        let mistakes_before = mistakes.count();
        Self {
            mistakes,
            directory,
            source,
            entries,
            place,
            known: Vec::new(),
            missing: Vec::new(),
            mistakes_before,
            abandoned: false,
        }
    }

    fn child(&self, entries: Option<&'t DeTable<'t>>, place: Place) -> Self {
        Self::at(self.mistakes, self.directory, self.source, entries, place)
    }

    /// Where the table stands.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Reports a mistake.
    pub fn mistake(&self, mistake: Mistake) {
        self.mistakes.add(mistake);
    }

    /// Whether nothing was wrong in this table so far.
    pub fn intact(&self) -> bool {
        self.missing.is_empty() && self.mistakes.count() == self.mistakes_before
    }

    /// Whether the file names `key` here.
    pub fn has(&self, key: &str) -> bool {
        self.entries.is_some_and(|entries| entries.contains_key(key))
    }

    /// Place of `key`, whether it is written or not.
    pub fn place_of(&self, key: &str) -> Place {
        let span = self.entries.and_then(|entries| entries.get(key)).map(|value| value.span());
        Place { key: join(&self.place.key, key), span: span.or_else(|| self.place.span.clone()) }
    }

    /// The value of `key` as written.
    fn take(&mut self, key: &'static str) -> Option<(&'t DeValue<'t>, Place)> {
        self.known.push(key);
        let value = self.entries?.get(key)?;
        Some((value.get_ref(), Place { key: join(&self.place.key, key), span: Some(value.span()) }))
    }

    /// Gives up on the keys that are left: what they may be depends on one that is wrong.
    pub fn abandon(&mut self) {
        self.abandoned = true;
    }

    /// Like [`Table::take`], noting a key that is not written as missing.
    fn demand(&mut self, key: &'static str) -> Option<(&'t DeValue<'t>, Place)> {
        let found = self.take(key);
        if found.is_none() {
            self.missing.push(key);
        }
        found
    }

    fn or_default<T>(&self, key: &str, found: Option<T>, default: T) -> At<T> {
        At { value: found.unwrap_or(default), place: self.place_of(key) }
    }

    /// A number that must be written.
    pub fn number(&mut self, key: &'static str, allowed: &Allowed) -> At<f64> {
        let found = self.demand(key).and_then(|(value, place)| self.as_number(value, &place, allowed));
        self.or_default(key, found, allowed.fallback)
    }

    /// A number with a default.
    pub fn number_or(&mut self, key: &'static str, allowed: &Allowed, default: f64) -> At<f64> {
        let found = self.optional_number(key, allowed);
        self.or_default(key, found, default)
    }

    /// A number that may be left out.
    pub fn optional_number(&mut self, key: &'static str, allowed: &Allowed) -> Option<f64> {
        let (value, place) = self.take(key)?;
        self.as_number(value, &place, allowed)
    }

    fn as_number(&self, value: &DeValue<'_>, place: &Place, allowed: &Allowed) -> Option<f64> {
        let Some(number) = plain_number(value) else {
            self.wrong_type(value, place, allowed.words);
            return None;
        };
        if !number.is_finite() || !allowed.holds(number) {
            self.mistake(Mistake::new(place, "out of range").value(self.written(place)).allowed(allowed.words));
            return None;
        }
        Some(number)
    }

    /// A whole number with a default.
    pub fn count_or(&mut self, key: &'static str, allowed: Range<u64>, default: u64) -> At<u64> {
        let found = self.optional_count(key, allowed);
        self.or_default(key, found, default)
    }

    /// A whole number that may be left out.
    pub fn optional_count(&mut self, key: &'static str, allowed: Range<u64>) -> Option<u64> {
        let (value, place) = self.take(key)?;
        let number = match value {
            DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        let number = number.filter(|number| allowed.contains(number));
        if number.is_none() {
            let words = format!("a whole number from {} to {}", allowed.start, allowed.end - 1);
            self.mistake(Mistake::new(&place, "out of range").value(self.written(&place)).allowed(words));
        }
        number
    }

    /// Yes or no, with a default.
    pub fn flag_or(&mut self, key: &'static str, default: bool) -> bool {
        let Some((value, place)) = self.take(key) else { return default };
        let found = value.as_bool();
        if found.is_none() {
            self.wrong_type(value, &place, "true or false");
        }
        found.unwrap_or(default)
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

    fn as_text(&self, value: &DeValue<'_>, place: Place) -> Option<At<String>> {
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
            let mistake = Mistake::new(&name.place, "not a name").value(self.written(&name.place));
            self.mistake(mistake.allowed("1 to 64 letters, digits, `_` or `-`"));
        }
    }

    /// One of a list of words, which must be written.
    pub fn choice<T: Clone>(&mut self, key: &'static str, options: &[(&'static str, T)]) -> Option<Choice<T>> {
        let (value, place) = self.demand(key)?;
        self.as_choice(value, place, options)
    }

    /// One of a list of words; the first is the default.
    pub fn choice_or_first<T: Clone>(&mut self, key: &'static str, options: &[(&'static str, T)]) -> Choice<T> {
        let found = self.take(key).and_then(|(value, place)| self.as_choice(value, place, options));
        let (word, value) = &options[0];
        found.unwrap_or_else(|| Choice { word, value: value.clone(), place: self.place_of(key) })
    }

    fn as_choice<T: Clone>(
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
            let mistake = Mistake::new(&place, "unknown word").value(self.written(&place)).allowed(allowed);
            let hint = suggestion(text, words.iter().copied()).map(|word| format!("did you mean `{word}`?"));
            self.mistake(match hint {
                Some(hint) => mistake.hint(hint),
                None => mistake,
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
        let (value, place) = self.take(key)?;
        let items = self.as_list(value, &place)?;
        let mut found: Vec<Choice<T>> = Vec::new();
        for (item, place) in items {
            let Some(choice) = self.as_choice(item, place, options) else { continue };
            if found.iter().any(|earlier| earlier.word == choice.word) {
                self.mistake(Mistake::new(&choice.place, "named twice").value(self.written(&choice.place)));
            }
            found.push(choice);
        }
        Some(found)
    }

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
        let words = "two finite numbers, [x, y]";
        match value.as_array() {
            Some(list) if list.len() == 2 => {
                let mut components = list.iter().map(|item| plain_number(item.get_ref()));
                if let (Some(Some(x)), Some(Some(y))) = (components.next(), components.next())
                    && x.is_finite()
                    && y.is_finite()
                {
                    return Some(Vector::new(x, y));
                }
                self.mistake(Mistake::new(place, "wrong value").value(self.written(place)).allowed(words));
            }
            _ => self.wrong_type(value, place, words),
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
        let texts = items.into_iter().filter_map(|(item, place)| Some(self.as_text(item, place)?.value)).collect();
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
            self.mistake(Mistake::new(&place, "must be a list of tables").hint(hint));
            return Vec::new();
        }
        let items = self.as_list(value, &place).unwrap_or_default();
        items.into_iter().filter_map(|(item, place)| self.as_table(item, place)).collect()
    }

    fn as_list(&self, value: &'t DeValue<'t>, place: &Place) -> Option<Vec<(&'t DeValue<'t>, Place)>> {
        let Some(list) = value.as_array() else {
            self.wrong_type(value, place, "a list");
            return None;
        };
        if list.len() > LONGEST_LIST {
            let mistake = Mistake::new(place, format!("has {} entries", list.len()));
            self.mistake(mistake.allowed(format!("at most {LONGEST_LIST} entries")));
            return None;
        }
        let entry = |(index, item): (usize, &'t toml::Spanned<DeValue<'t>>)| {
            let place = Place { key: format!("{}[{index}]", place.key), span: Some(item.span()) };
            (item.get_ref(), place)
        };
        Some(list.iter().enumerate().map(entry).collect())
    }

    fn wrong_type(&self, value: &DeValue<'_>, place: &Place, allowed: &str) {
        let problem = format!("wrong type: {}", value.type_str());
        self.mistake(Mistake::new(place, problem).value(self.written(place)).allowed(allowed));
    }

    /// The text of the file at `place`.
    pub fn written(&self, place: &Place) -> &'t str {
        place.span.clone().and_then(|span| self.source.get(span)).unwrap_or_default()
    }

    /// Ends reading: reports missing and unknown keys. Whether nothing was wrong in this table or its children.
    pub fn finish(self) -> bool {
        let mut meant = Vec::new();
        for (key, value) in self.entries.filter(|_| !self.abandoned).into_iter().flat_map(DeTable::iter) {
            let word: &str = key.get_ref();
            if self.known.contains(&word) {
                continue;
            }
            let unused: Vec<&str> = self.known.iter().copied().filter(|known| !self.has(known)).collect();
            meant.extend(suggestion(word, unused.iter().copied()));
            let place = Place { key: join(&self.place.key, word), span: Some(key.span()) };
            let mistake = Mistake::new(&place, "unknown key").hint(suggest(word, &unused));
            let is_table = value.get_ref().is_table();
            self.mistake(if is_table { mistake } else { mistake.value(self.written(&self.place_of(word))) });
        }
        for key in self.missing.iter().filter(|key| !meant.contains(key)) {
            let place = Place { key: join(&self.place.key, key), span: self.place.span.clone() };
            self.mistake(Mistake::new(&place, "missing").hint(format!("add `{key}` here")));
        }
        self.mistakes.count() == self.mistakes_before
    }
}

/// A number, or the text of an expression.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Written {
    /// A number.
    Number(f64),
    /// An expression.
    Text(String),
}

impl Written {
    /// The text of the expression; a number is written without an exponent and reads back to the same bits.
    pub fn text(&self) -> String {
        match self {
            Written::Number(number) => format!("{number}"),
            Written::Text(text) => text.clone(),
        }
    }
}

fn plain_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}

fn join(parent: &str, key: &str) -> String {
    if parent.is_empty() { key.to_owned() } else { format!("{parent}.{key}") }
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
