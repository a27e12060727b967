//! Text of a user in messages: nothing of it reaches a terminal as a control sequence, and long text is shortened.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

/// Most characters of a quoted text.
const LONGEST_QUOTE: usize = 60;

/// Most characters of a line of a message.
const LONGEST_LINE: usize = 2000;

/// Most names of a list.
const LONGEST_LIST: usize = 20;

/// Whether a terminal would act on `c` instead of showing it: controls, and marks that turn the direction of text.
fn acts(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

fn push_escaped(shown: &mut String, c: char) {
    match c {
        '\n' => shown.push_str("\\n"),
        '\r' => shown.push_str("\\r"),
        '\t' => shown.push_str("\\t"),
        // Writing to a string cannot fail.
        c if acts(c) => drop(write!(shown, "\\u{{{:x}}}", u32::from(c))),
        c => shown.push(c),
    }
}

/// The first `longest` characters of `text`, escaped; an ellipsis stands for the rest.
fn start_of(text: &str, longest: usize) -> String {
    let mut characters = text.chars();
    let mut shown = String::new();
    characters.by_ref().take(longest).for_each(|c| push_escaped(&mut shown, c));
    if characters.next().is_some() {
        shown.push('…');
    }
    shown
}

/// A name or value of a user as a message quotes it: escaped, at most 60 characters.
pub fn quoted(text: &str) -> String {
    start_of(text, LONGEST_QUOTE)
}

/// The path of a key in a case file, whose words may be a user's own: escaped, at most 200 characters.
pub fn key(text: &str) -> String {
    const LONGEST: usize = 200;
    start_of(text, LONGEST)
}

/// A path as a message shows it: escaped; of a very long one the end.
pub fn path(path: &Path) -> String {
    const LONGEST: usize = 400;
    let text = path.to_string_lossy();
    match text.char_indices().rev().nth(LONGEST) {
        Some((at, _)) => format!("…{}", start_of(text.get(at..).unwrap_or_default(), LONGEST + 1)),
        None => start_of(&text, LONGEST),
    }
}

/// Names, separated by commas; of a long list the first 20 and how many follow.
pub fn listed(names: &[&str]) -> String {
    let first: Vec<String> = names.iter().take(LONGEST_LIST).map(|name| quoted(name)).collect();
    let more = names.len().saturating_sub(LONGEST_LIST);
    let rest = if more > 0 { format!(", … and {more} more") } else { String::new() };
    format!("{}{rest}", first.join(", "))
}

/// A whole message: lines stay lines, everything else that a terminal would act on is escaped, and long lines are cut.
pub fn clean(message: &str) -> Cow<'_, str> {
    let acts_inside = |c: char| c != '\n' && acts(c);
    let long = |line: &str| line.len() > LONGEST_LINE && line.chars().count() > LONGEST_LINE;
    if !message.contains(acts_inside) && !message.split('\n').any(long) {
        return Cow::Borrowed(message);
    }
    let lines: Vec<String> = message.split('\n').map(|line| start_of(line, LONGEST_LINE)).collect();
    Cow::Owned(lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_sequences_are_shown_and_not_sent() {
        assert_eq!(quoted("\u{1b}[31mred"), "\\u{1b}[31mred");
        assert_eq!(quoted("a\nb\tc\u{9b}d\u{202e}e"), "a\\nb\\tc\\u{9b}d\\u{202e}e");
        // What is no sequence stays as it was written.
        assert_eq!(quoted("水 \"x\" `y` é"), "水 \"x\" `y` é");
        assert_eq!(path(Path::new("/tmp/\u{7}bell\n")), "/tmp/\\u{7}bell\\n");
    }

    #[test]
    fn long_text_is_shortened() {
        let shown = quoted(&"水".repeat(500_000));
        assert_eq!(shown, format!("{}…", "水".repeat(60)));
        let long = format!("/{}/end", "x".repeat(4000));
        let shown = path(Path::new(&long));
        assert!(shown.starts_with('…') && shown.ends_with("/end") && shown.chars().count() < 450, "{shown}");
        let names: Vec<String> = (0..1000).map(|k| format!("name_{k}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let shown = listed(&names);
        assert!(shown.starts_with("name_0, name_1") && shown.ends_with("name_19, … and 980 more"), "{shown}");
        assert_eq!(listed(&["a", "b"]), "a, b");
    }

    #[test]
    fn messages_keep_their_lines() {
        assert!(matches!(clean("one\n  two"), Cow::Borrowed("one\n  two")));
        assert_eq!(clean("one\n\u{1b}]0;title\u{7}"), "one\n\\u{1b}]0;title\\u{7}");
        let cut = clean(&"x".repeat(100_000)).into_owned();
        assert_eq!(cut.chars().count(), LONGEST_LINE + 1);
    }
}
