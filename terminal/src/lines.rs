//! How wide a terminal is, and text broken to its width.

use std::io::IsTerminal;
use std::os::fd::AsFd;

/// Width of a terminal that does not say, in columns.
const USUAL_WIDTH: usize = 80;

/// Widest lines of running text; longer ones are hard to read.
const WIDEST: usize = 100;

/// Narrowest lines: below this a word would get a line of its own.
const NARROWEST: usize = 30;

/// Width for text on standard output; `None` where it is no terminal, whose lines stay whole for other programs.
pub fn output_width() -> Option<usize> {
    width(std::io::stdout())
}

/// Width for text on standard error, likewise.
pub fn errors_width() -> Option<usize> {
    width(std::io::stderr())
}

fn width(stream: impl AsFd + IsTerminal) -> Option<usize> {
    stream.is_terminal().then(|| {
        let columns = rustix::termios::tcgetwinsize(stream).map_or(0, |size| usize::from(size.ws_col));
        if columns == 0 { USUAL_WIDTH } else { columns.clamp(NARROWEST, WIDEST) }
    })
}

/// `text` in lines of at most `width` characters, broken at spaces; all but the first are indented by `indent` spaces, and
/// the first has `taken` characters already. Words that are longer stay whole.
pub fn wrap(text: &str, taken: usize, indent: usize, width: Option<usize>) -> Vec<String> {
    let Some(width) = width else { return vec![text.to_owned()] };
    let mut lines = vec![String::new()];
    let mut used = taken;
    for word in text.split(' ') {
        let length = word.chars().count();
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if used + 1 + length <= width => {
                line.push(' ');
                line.push_str(word);
                used += 1;
            }
            _ => {
                lines.push(format!("{:indent$}{word}", ""));
                used = indent;
            }
        }
        used += length;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_at_spaces_and_no_word_is_lost() {
        let text = "time-step limit of the fluid, acoustic";
        assert_eq!(wrap(text, 0, 2, None), [text]);
        assert_eq!(
            wrap(text, 0, 2, Some(20)),
            ["time-step limit of", "  the fluid,", "  acoustic"].map(String::from)
        );
        assert_eq!(
            wrap(text, 14, 0, Some(20)),
            ["time-step", "limit of the fluid,", "acoustic"].map(String::from)
        );
        assert_eq!(wrap("abcdefghij k", 0, 1, Some(4)), ["abcdefghij", " k"].map(String::from));
    }
}
