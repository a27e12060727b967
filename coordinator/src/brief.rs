//! A case in a few lines: for `check` and for the start of a run.

use std::fmt::Display;

use terminal::lines::wrap;
use terminal::style::{Style, Tone};

use crate::case::{Case, Summary};
use crate::quote;
use crate::run::memory;

/// Columns for the names of facts.
const NAMES: usize = 11;

/// Particles by kind, and their space.
pub fn particles(case: &Case, summary: &Summary) -> String {
    let of = |kind: &str| {
        let counts = summary.counts.iter().filter(|count| count.kind == kind);
        counts.fold((0, 0), |(moving, held), count| (moving + count.particles, held + count.held))
    };
    let mut parts = Vec::new();
    for (kind, name) in [("fluid region", "fluid"), ("body", "solid"), ("wall", "wall")] {
        match of(kind) {
            (0, 0) => {}
            (moving, 0) => parts.push(format!("{moving} {name}")),
            (moving, held) => parts.push(format!("{moving} {name} and {held} held")),
        }
    }
    let space = if case.dimensions() == 2 { "in the plane" } else { "in space" };
    format!("{}, {space}", parts.join(", "))
}

/// The size of a step against the limit of stability.
pub fn time_step(summary: &Summary) -> String {
    let kind = if summary.fixed { "fixed" } else { "at first, adaptive" };
    format!("{:.3e} s {kind}, {}", summary.time_step, of_limit(summary.ratio_to_limit))
}

/// A step over the stability limit in words; it has none where nothing but solids moves, in sub-steps of their own.
pub fn of_limit(ratio: f64) -> String {
    match ratio {
        0.0 => "in stable sub-steps of the solids".to_owned(),
        ratio => format!("{ratio:.2} of the stability limit"),
    }
}

/// Steps, time and memory of a run.
pub fn cost(case: &Case, summary: &Summary) -> String {
    let about = if summary.fixed { "" } else { "about " };
    let memory = match memory::needed(case) {
        // Servers elsewhere.
        0 => String::new(),
        bytes => format!(", {} of memory", size(bytes)),
    };
    format!(
        "{about}{} steps to {} s, about {} on one core{memory}",
        summary.steps,
        case.run_plan().time.end_time,
        duration(summary.forecast())
    )
}

fn size(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    if mebibytes < 1000.0 {
        format!("{:.0} MiB", mebibytes.ceil())
    } else {
        format!("{:.1} GiB", mebibytes / 1024.0)
    }
}

/// A time span in words.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 1e6 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.2e} days", s / 86_400.0),
    }
}

/// How facts are laid out on a stream.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Colours.
    pub style: Style,
    /// Width of lines; `None` leaves them whole.
    pub width: Option<usize>,
}

impl Layout {
    /// That of standard output.
    pub fn of_output() -> Self {
        Self { style: Style::of_output(), width: terminal::lines::output_width() }
    }

    /// That of standard error.
    pub fn of_errors() -> Self {
        Self { style: Style::of_errors(), width: terminal::lines::errors_width() }
    }

    /// A named fact in lines, the text beside the name; `names` is the width of the names of all facts together.
    pub fn fact(&self, name: &str, text: &str, names: usize) -> String {
        let (name, text) = (quote::clean(name), quote::clean(text));
        let indent = names.max(NAMES);
        let padding = " ".repeat(indent.saturating_sub(name.chars().count()));
        let lines = wrap(&text, indent, indent, self.width);
        format!("{}{padding}{}", self.style.paint(Tone::Heading, name), lines.join("\n"))
    }

    /// A warning in lines.
    pub fn warning(&self, text: impl Display) -> String {
        const MARK: &str = "warning:";
        let text = quote::clean(&text.to_string()).into_owned();
        let lines = wrap(&text, MARK.len() + 1, 2, self.width);
        format!("{} {}", self.style.paint(Tone::Doubt, MARK), lines.join("\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_and_sizes_have_units_that_fit() {
        assert_eq!([1.4, 600.0, 10_800.0].map(duration), ["1 s", "10 min", "3.0 h"]);
        assert_eq!([1, 3 << 20, 5 << 30].map(size), ["1 MiB", "3 MiB", "5.0 GiB"]);
    }

    #[test]
    fn facts_keep_to_the_width_and_stay_whole_without_one() {
        let text = "wall with reaction, slip; states; stop above 1e-12 of gross, and some more words that do not fit";
        let narrow = Layout { style: Style::PLAIN, width: Some(60) };
        let lines = narrow.fact("interface", text, 0);
        assert_eq!(lines.lines().count(), 3, "{lines}");
        for line in lines.lines() {
            assert!(line.chars().count() <= 60, "{line}");
            assert!(line.starts_with("interface  wall") || line.starts_with("           "), "{lines}");
        }
        let whole = Layout { width: None, ..narrow };
        assert_eq!(whole.fact("interface", text, 0), format!("interface  {text}"));
        assert_eq!(whole.warning("bent"), "warning: bent");
    }
}
