//! The text that a case is read from: a file, and values set over it.

use std::ops::Range;

/// The text of a case file, followed by the values set over it, a line each.
#[derive(Clone, Debug)]
pub struct Source {
    text: String,
    /// Bytes of the file.
    file_length: usize,
    /// Bytes of each key, and of its value.
    overrides: Vec<(Range<usize>, Range<usize>)>,
}

impl Source {
    /// The text of a file, and keys with values that are set over it.
    pub fn new<'a>(file: &str, overrides: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let (mut text, file_length) = (file.to_owned(), file.len());
        // A line break within would shift the lines of those after it.
        let mut add = |part: &str| {
            let start = text.len();
            text.extend(part.chars().map(|c| if c.is_control() && c != '\n' { ' ' } else { c }));
            start..text.len()
        };
        let mut found = Vec::new();
        for (key, value) in overrides {
            add("\n");
            let key = add(&key.replace('\n', " "));
            add(" = ");
            found.push((key, add(&value.replace('\n', " "))));
        }
        Self { text, file_length, overrides: found }
    }

    /// No text.
    pub fn empty() -> Self {
        Self::new("", [])
    }

    /// File and overrides.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file.
    pub fn file(&self) -> &str {
        &self.text[..self.file_length]
    }

    /// Places of the keys that are set over the file, each with that of its value.
    pub fn overrides(&self) -> &[(Range<usize>, Range<usize>)] {
        &self.overrides
    }

    /// Number, from 1, of the override that holds the byte `offset`.
    pub fn override_at(&self, offset: usize) -> Option<usize> {
        (offset > self.file_length).then(|| self.overrides.partition_point(|(key, _)| key.start <= offset))
    }
}
