//! What `check` prints.

use std::path::Path;

use terminal::lines::wrap;
use terminal::style::Tone;

use super::Checked;
use crate::PROGRAM;
use crate::brief::{self, Layout};
use crate::case::overrides::Override;
use crate::quote;

/// Width of long lines where no terminal says.
const USUAL_WIDTH: usize = 100;

impl Checked {
    /// The verdict, what a run would be and cost, in six lines, and the warnings; `path` is the file of the case.
    pub fn brief(&self, path: &Path, layout: Layout) -> String {
        let Self { case, summary } = self;
        let (tone, verdict) = match summary.warnings.len() {
            0 => (Tone::Good, "ready to run".to_owned()),
            1 => (Tone::Doubt, "ready to run, with 1 warning".to_owned()),
            count => (Tone::Doubt, format!("ready to run, with {count} warnings")),
        };
        let set = match case.overrides().len() {
            0 => String::new(),
            count => format!("; {count} set over the file"),
        };
        let settings = match summary.departures.len() {
            0 => "as recommended".to_owned(),
            count => format!("as recommended but for {count}"),
        };
        let verdict = layout.style.paint(tone, verdict);
        let mut lines = vec![format!("{}: {verdict}", quote::clean(&summary.name))];
        for (name, text) in [
            ("particles", brief::particles(case, summary)),
            ("time step", brief::time_step(summary)),
            ("cost", brief::cost(case, summary)),
            ("settings", settings + &set),
            ("next", format!("`{PROGRAM} run {}`; more: `check -v`", quote::path(path))),
        ] {
            lines.push(layout.fact(name, &text, 0));
        }
        lines.extend(summary.warnings.iter().map(|warning| layout.warning(warning)));
        lines.join("\n")
    }

    /// Counts, time steps, constants and active terms: what [`Self::brief`] leaves out.
    pub fn details(&self, layout: Layout) -> String {
        let summary = &self.summary;
        let mut text = String::new();
        let mut part = |title: &str, lines: Vec<String>| {
            if lines.is_empty() {
                return;
            }
            text.push_str(&format!("\n{}\n", layout.style.paint(Tone::Heading, title)));
            for line in lines {
                let line = quote::clean(&line).into_owned();
                let width = layout.width.or(Some(USUAL_WIDTH));
                text.push_str(&format!("  {}\n", wrap(&line, 2, 4, width).join("\n")));
            }
        };
        let set = self.case.overrides().iter();
        part("set over the file", set.map(|Override { key, value }| format!("{key} = {value}")).collect());
        part("particles", self.particles());
        part("time step", self.time_step());
        part("constants", summary.constants.clone());
        let terms = summary.active_terms.iter();
        part("active terms", terms.map(|term| format!("{}: {}", term.owner, term.text)).collect());
        part("departures from the recommended settings (docs/method.md)", summary.departures.clone());
        text
    }

    fn particles(&self) -> Vec<String> {
        let summary = &self.summary;
        let counts = summary.counts.iter().map(|count| {
            let held = if count.held > 0 { format!(" (and {} held)", count.held) } else { String::new() };
            format!("{} {}: {}{held}", count.kind, count.name, count.particles)
        });
        counts.chain(summary.adjusted.iter().cloned()).chain(summary.cuts.iter().cloned()).collect()
    }

    fn time_step(&self) -> Vec<String> {
        let summary = &self.summary;
        let limits = summary.limits.iter().map(|limit| {
            format!(
                "{:.3e} s stable, {:.3e} s recommended ({})",
                limit.stability, limit.recommended, limit.origin
            )
        });
        let mut lines: Vec<String> = limits.collect();
        let kind = if summary.fixed { "fixed" } else { "first of an adaptive run" };
        let recommended = match summary.ratio_to_recommended {
            0.0 => String::new(),
            ratio => format!(", {ratio:.2} of the recommended step"),
        };
        lines.push(format!(
            "{:.3e} s chosen ({kind}): {}{recommended}",
            summary.time_step,
            brief::of_limit(summary.ratio_to_limit)
        ));
        if let Some(factor) = summary.limit_override {
            lines.push(format!("the case overrides the limit by a factor of {factor}"));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use terminal::style::Style;

    use super::*;

    const PLAIN: Layout = Layout { style: Style::PLAIN, width: None };

    fn checked(set: &[&str]) -> (std::path::PathBuf, Checked) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/drifting_body_coarse.toml");
        let overrides: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
        let checked = crate::check::check(&path, &overrides).unwrap();
        (path, checked)
    }

    #[test]
    fn the_answer_has_six_lines_and_one_for_each_warning() {
        let (path, checked) = checked(&["interface.margin_spacings=1.5", "fluid.sound_speed_m_s=20"]);
        let text = checked.brief(Path::new("case.toml"), PLAIN);
        let warnings = checked.summary.warnings.len();
        assert!(warnings > 0 && path.exists());
        assert_eq!(text.lines().count(), 6 + warnings, "{text}");
        for words in [
            ": ready to run, with ",
            "2911 fluid, 141 solid and 9 held, 1772 wall",
            "5000 steps to 0.5 s, about ",
            "2 set",
        ] {
            assert!(text.contains(words), "no {words:?} in {text}");
        }
        let narrow = checked.brief(Path::new("case.toml"), Layout { width: Some(80), ..PLAIN });
        for line in narrow.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }

    #[test]
    fn details_hold_every_constant_and_term() {
        let (_, checked) = checked(&[]);
        let text = checked.details(PLAIN);
        for words in
            ["body plate: 60 (and 9 held)", "scheme = leapfrog", "hourglass = 0.3", "s chosen (fixed)"]
        {
            assert!(text.contains(words), "no {words:?} in {text}");
        }
    }
}
