//! Errors of a case file: all of them at once, each with its place and its remedy.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

use super::effort::Effort;
use super::source::Source;
use crate::quote;

/// Errors beyond this number are counted, not kept: a hostile file must not fill the memory.
const KEPT: usize = 200;

/// Errors beyond this number are not printed.
const PRINTED: usize = 50;

/// Of lines of more bytes than these, a part around the error is shown.
const LONGEST_SHOWN: usize = 8000;

/// Stands for the file where a value set over that of the file is wrong.
const OVERRIDES: &str = "values set over the file";

/// Of a value that spans more lines than this, the first is shown.
const MOST_LINES: usize = 40;

/// Where a value stands in the case file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Path of the key, such as `solid.body[1].material.density_kg_m3`.
    pub key: String,
    /// Bytes of the file that hold it; `None` when the error has no place in the text.
    pub span: Option<Range<usize>>,
}

/// Line and column in the case file, both from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// One error of a case file.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseError {
    /// Where.
    pub place: Place,
    /// Line and column, of a value set over the file its number; `None` when the error has no place in the text.
    pub position: Option<Position>,
    /// The value as written.
    pub value: Option<String>,
    /// What is wrong.
    pub problem: String,
    /// What is allowed.
    pub allowed: Option<String>,
    /// What to do.
    pub hint: Option<String>,
}

impl CaseError {
    /// An error at `place`.
    pub fn new(place: &Place, problem: impl Into<String>) -> Self {
        Self {
            place: Place { key: quote::key(&place.key), span: place.span.clone() },
            position: None,
            value: None,
            problem: cleaned(problem),
            allowed: None,
            hint: None,
        }
    }

    /// Adds the value as written.
    pub fn value(mut self, value: impl fmt::Display) -> Self {
        self.value = Some(quote::quoted(&value.to_string()));
        self
    }

    /// Adds what is allowed.
    pub fn allowed(mut self, allowed: impl Into<String>) -> Self {
        self.allowed = Some(cleaned(allowed));
        self
    }

    /// Adds what to do.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(cleaned(hint));
        self
    }

    fn title(&self) -> String {
        match (&self.place.key, &self.value) {
            (key, _) if key.is_empty() => self.problem.clone(),
            (key, Some(value)) => format!("`{key}` = {value}: {}", self.problem),
            (key, None) => format!("`{key}`: {}", self.problem),
        }
    }
}

fn cleaned(text: impl Into<String>) -> String {
    quote::clean(&text.into()).into_owned()
}

/// Collects errors while a file is read, and bounds what reading it may cost.
#[derive(Debug, Default)]
pub struct ErrorList {
    kept: RefCell<Vec<CaseError>>,
    count: Cell<usize>,
    effort: Effort,
}

impl ErrorList {
    /// Adds one.
    pub fn add(&self, error: CaseError) {
        self.count.set(self.count.get() + 1);
        if self.count.get() <= KEPT {
            self.kept.borrow_mut().push(error);
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count.get()
    }

    /// Adds one error that stands for `count`.
    pub fn add_many(&self, error: CaseError, count: usize) {
        self.add(error);
        self.count.set(self.count.get().saturating_add(count.saturating_sub(1)));
    }

    /// Whether further errors are only counted, so that they need no words.
    pub fn is_full(&self) -> bool {
        self.count.get() >= KEPT
    }

    /// Takes `steps` of work, each about a nanosecond; whether there were enough left. The first time that there are
    /// not, it is an error of what stands at `place`.
    pub fn spend(&self, place: &Place, steps: f64) -> bool {
        if self.effort.take(steps) {
            return true;
        }
        if self.effort.is_first_refusal() {
            let problem = "the case takes too much work to lay out";
            let hint = "use a larger particle spacing, fewer corners of shapes, or fewer shapes on one spot";
            self.add(CaseError::new(place, problem).hint(hint));
        }
        false
    }

    /// The report on `source`, the text of `file` and what is set over it; in the order of the text.
    pub fn into_errors(self, file: String, source: Source) -> CaseErrors {
        let mut errors = self.kept.into_inner();
        errors.sort_by_key(|error| error.place.span.as_ref().map_or(usize::MAX, |span| span.start));
        let mut sweep = Sweep { source: source.text(), offset: 0, position: Position { line: 1, column: 1 } };
        for error in &mut errors {
            error.position = error.place.span.as_ref().map(|span| {
                let position = sweep.to(span.start);
                let line = source.override_at(span.start).unwrap_or(position.line);
                Position { line, ..position }
            });
        }
        CaseErrors { file: quote::path(file.as_ref()), source, list: errors, count: self.count.get() }
    }
}

/// Goes through a text once for all positions in it.
struct Sweep<'a> {
    source: &'a str,
    offset: usize,
    position: Position,
}

impl Sweep<'_> {
    /// Line and column at `offset`, which does not lie before the last one.
    fn to(&mut self, offset: usize) -> Position {
        let part = self.source.get(self.offset..offset).unwrap_or_default();
        for c in part.chars() {
            self.position = match (c, self.position) {
                ('\n', at) => Position { line: at.line + 1, column: 1 },
                (_, at) => Position { column: at.column + 1, ..at },
            };
        }
        self.offset += part.len();
        self.position
    }
}

/// All errors of one case file.
#[derive(Clone, Debug)]
pub struct CaseErrors {
    /// Path of the file as given.
    pub file: String,
    /// The errors in the order of the text; a long list is cut.
    pub list: Vec<CaseError>,
    /// How many there are, also those that were cut.
    pub count: usize,
    source: Source,
}

impl CaseErrors {
    /// Errors of a file that cannot be read at all.
    pub(super) fn unreadable(file: String, problem: String, hint: &str) -> Self {
        let error = CaseError::new(&Place::default(), problem).hint(hint);
        Self { file: quote::path(file.as_ref()), list: vec![error], count: 1, source: Source::empty() }
    }

    /// The report as for a compiler; `styled` adds colours for a terminal.
    pub fn render(&self, styled: bool) -> String {
        let renderer = if styled { Renderer::styled() } else { Renderer::plain() };
        let mut text = String::new();
        for error in self.list.iter().take(PRINTED) {
            text.push_str(&renderer.render(&self.groups(error)));
            text.push_str("\n\n");
        }
        let hidden = self.count.saturating_sub(PRINTED);
        if hidden > 0 {
            text.push_str(&format!("… and {hidden} more\n\n"));
        }
        let plural = if self.count == 1 { "error" } else { "errors" };
        text.push_str(&format!("{} {plural} in {}", self.count, self.file));
        text
    }

    fn groups<'a>(&'a self, error: &'a CaseError) -> Vec<Group<'a>> {
        let title = Level::ERROR.primary_title(error.title());
        let mut groups = Vec::new();
        match &error.place.span {
            Some(span) => {
                let position = error.position.unwrap_or(Position { line: 1, column: 1 });
                let path = self.source.override_at(span.start).map_or(self.file.as_str(), |_| OVERRIDES);
                let (mut lines, mut span) = self.lines_of(span);
                let is_long = lines.len() > LONGEST_SHOWN;
                if is_long {
                    (lines, span) = around(lines, &span);
                }
                let annotation = AnnotationKind::Primary
                    .span(span)
                    .label(error.allowed.as_ref().map(|allowed| format!("allowed: {allowed}")));
                let snippet = Snippet::source(lines).line_start(position.line).annotation(annotation);
                groups.push(if is_long {
                    // The column in the file is not that in the part.
                    let origin = Origin::path(path).line(position.line).char_column(position.column);
                    title.element(origin).element(snippet)
                } else {
                    title.element(snippet.path(path))
                });
            }
            None => {
                groups.push(title.element(Origin::path(&self.file)));
                if let Some(allowed) = &error.allowed {
                    groups
                        .push(Group::with_title(Level::NOTE.secondary_title(format!("allowed: {allowed}"))));
                }
            }
        }
        if let Some(hint) = &error.hint {
            groups.push(Group::with_title(Level::HELP.secondary_title(hint.as_str())));
        }
        groups
    }

    /// The lines that hold `span`, and the span in them: no more of a large file is looked at.
    fn lines_of(&self, span: &Range<usize>) -> (&str, Range<usize>) {
        let source = self.source.text();
        let before = source.get(..span.start).unwrap_or_default();
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        let line_end = |from: usize| {
            let rest = source.get(from..).unwrap_or_default();
            rest.find('\n').map_or(source.len(), |at| from + at)
        };
        let within = source.get(span.clone()).unwrap_or_default();
        let end = match within.matches('\n').nth(MOST_LINES) {
            Some(_) => line_end(span.start),
            None => span.end.min(source.len()),
        };
        let lines = source.get(start..line_end(end)).unwrap_or_default();
        (lines, span.start.saturating_sub(start)..end.saturating_sub(start))
    }
}

/// The part of `lines` around the start of `span`, and what of the span lies in it.
fn around<'a>(lines: &'a str, span: &Range<usize>) -> (&'a str, Range<usize>) {
    const MARGIN: usize = 60;
    let boundary = |at: usize| (0..=at.min(lines.len())).rfind(|at| lines.is_char_boundary(*at)).unwrap_or(0);
    let start = boundary(span.start.saturating_sub(MARGIN));
    let part_span = span.start..boundary(span.end.min(span.start + MARGIN)).max(span.start);
    let part = lines.get(start..boundary(part_span.end + MARGIN)).unwrap_or_default();
    // One line of them.
    let line_start =
        part.get(..part_span.start - start).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
    let end = part.get(part_span.start - start..).and_then(|rest| rest.find('\n'));
    let end = end.map_or(part.len(), |at| part_span.start - start + at);
    let part = part.get(line_start..end).unwrap_or_default();
    let moved = start + line_start;
    (part, part_span.start - moved..(part_span.end - moved).min(part.len()))
}

impl fmt::Display for CaseErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for CaseErrors {}

/// Known words beyond this number are not compared with a mistyped one.
const MOST_COMPARED: usize = 1000;

/// The known word most like `word`, if any is like enough to be meant.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Comparing long words costs time in the square of their length.
    const LONGEST: usize = 80;
    if word.chars().count() > LONGEST {
        return None;
    }
    let word = word.to_lowercase();
    let tolerance = (word.chars().count() / 3).max(2);
    known
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        .take(MOST_COMPARED)
        .map(|candidate| {
            // A forgotten or different unit at the end is the commonest slip.
            let unit =
                candidate.starts_with(&format!("{word}_")) || word.starts_with(&format!("{candidate}_"));
            let distance = if unit { 1 } else { strsim::damerau_levenshtein(&word, candidate) };
            (distance, candidate)
        })
        .filter(|(distance, _)| *distance <= tolerance)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// `did you mean` for a mistyped `word`, or else the list of what is known.
pub fn suggest(word: &str, known: &[&str]) -> String {
    match suggestion(word, known.iter().copied()) {
        Some(candidate) => format!("did you mean `{}`?", quote::quoted(candidate)),
        None if known.is_empty() => "none is defined".to_owned(),
        None => format!("known here: {}", quote::listed(known)),
    }
}
