//! Mistakes of a case file: all of them at once, each with its place and its remedy.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

/// Mistakes beyond this number are counted, not kept: a hostile file must not fill the memory.
const KEPT: usize = 200;

/// Mistakes beyond this number are not printed.
const PRINTED: usize = 50;

/// Where a value stands in the case file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Path of the key, such as `solid.body[1].material.density_kg_m3`.
    pub key: String,
    /// Bytes of the file that hold it; `None` when the mistake has no place in the text.
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

/// One mistake of a case file.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// Where.
    pub place: Place,
    /// Line and column; `None` when the mistake has no place in the text.
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

impl Mistake {
    /// A mistake at `place`.
    pub fn new(place: &Place, problem: impl Into<String>) -> Self {
        Self {
            place: place.clone(),
            position: None,
            value: None,
            problem: problem.into(),
            allowed: None,
            hint: None,
        }
    }

    /// Adds the value as written.
    pub fn value(mut self, value: impl fmt::Display) -> Self {
        self.value = Some(shortened(&value.to_string()));
        self
    }

    /// Adds what is allowed.
    pub fn allowed(mut self, allowed: impl Into<String>) -> Self {
        self.allowed = Some(allowed.into());
        self
    }

    /// Adds what to do.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
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

/// The first characters of a long value.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 60;
    let mut characters = text.chars();
    let start: String = characters.by_ref().take(LONGEST).collect();
    if characters.next().is_some() { format!("{start}…") } else { start }
}

/// Collects mistakes while a file is read.
#[derive(Debug, Default)]
pub struct Mistakes {
    kept: RefCell<Vec<Mistake>>,
    count: Cell<usize>,
}

impl Mistakes {
    /// Adds one.
    pub fn add(&self, mistake: Mistake) {
        self.count.set(self.count.get() + 1);
        if self.count.get() <= KEPT {
            self.kept.borrow_mut().push(mistake);
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count.get()
    }

    /// The report on `source`, the text of `file`; in the order of the text.
    pub fn into_errors(self, file: String, source: String) -> CaseErrors {
        let mut mistakes = self.kept.into_inner();
        mistakes.sort_by_key(|mistake| mistake.place.span.as_ref().map_or(usize::MAX, |span| span.start));
        for mistake in &mut mistakes {
            mistake.position = mistake.place.span.as_ref().map(|span| position(&source, span.start));
        }
        CaseErrors { file, source, mistakes, count: self.count.get() }
    }
}

fn position(source: &str, offset: usize) -> Position {
    let before = source.get(..offset).unwrap_or(source);
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    Position {
        line: before.matches('\n').count() + 1,
        column: before.get(line_start..).unwrap_or_default().chars().count() + 1,
    }
}

/// All mistakes of one case file.
#[derive(Clone, Debug)]
pub struct CaseErrors {
    /// Path of the file as given.
    pub file: String,
    /// The mistakes in the order of the text; a long list is cut.
    pub mistakes: Vec<Mistake>,
    /// How many there are, also those that were cut.
    pub count: usize,
    source: String,
}

impl CaseErrors {
    /// Errors of a file that cannot be read at all.
    pub(super) fn unreadable(file: String, problem: String, hint: &str) -> Self {
        let mistake = Mistake::new(&Place::default(), problem).hint(hint);
        Self { file, mistakes: vec![mistake], count: 1, source: String::new() }
    }

    /// The report as for a compiler; `styled` adds colours for a terminal.
    pub fn render(&self, styled: bool) -> String {
        let renderer = if styled { Renderer::styled() } else { Renderer::plain() };
        let mut text = String::new();
        for mistake in self.mistakes.iter().take(PRINTED) {
            text.push_str(&renderer.render(&self.groups(mistake)));
            text.push_str("\n\n");
        }
        let hidden = self.count.saturating_sub(PRINTED);
        if hidden > 0 {
            text.push_str(&format!("… and {hidden} more\n\n"));
        }
        let plural = if self.count == 1 { "mistake" } else { "mistakes" };
        text.push_str(&format!("{} {plural} in {}", self.count, self.file));
        text
    }

    fn groups<'a>(&'a self, mistake: &'a Mistake) -> Vec<Group<'a>> {
        let title = Level::ERROR.primary_title(mistake.title());
        let mut groups = Vec::new();
        match &mistake.place.span {
            Some(span) => {
                let annotation = AnnotationKind::Primary
                    .span(span.clone())
                    .label(mistake.allowed.as_ref().map(|allowed| format!("allowed: {allowed}")));
                groups.push(
                    title.element(Snippet::source(&self.source).path(&self.file).annotation(annotation)),
                );
            }
            None => {
                groups.push(title.element(annotate_snippets::Origin::path(&self.file)));
                if let Some(allowed) = &mistake.allowed {
                    groups
                        .push(Group::with_title(Level::NOTE.secondary_title(format!("allowed: {allowed}"))));
                }
            }
        }
        if let Some(hint) = &mistake.hint {
            groups.push(Group::with_title(Level::HELP.secondary_title(hint.as_str())));
        }
        groups
    }
}

impl fmt::Display for CaseErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for CaseErrors {}

/// The known word most like `word`, if any is like enough to be meant.
pub fn suggestion<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Comparing long words costs time in the square of their length.
    if word.chars().count() > 80 {
        return None;
    }
    let word = word.to_lowercase();
    let tolerance = (word.chars().count() / 3).max(2);
    known
        .into_iter()
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
        Some(candidate) => format!("did you mean `{candidate}`?"),
        None if known.is_empty() => "none is defined".to_owned(),
        None => format!("known here: {}", known.join(", ")),
    }
}
