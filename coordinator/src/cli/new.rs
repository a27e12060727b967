//! `tidelock new`.

use std::io::{BufRead, IsTerminal};
use std::path::PathBuf;

use clap::Args;
use terminal::{note, say};

use crate::PROGRAM;
use crate::failure::Failure;
use crate::new::{self, TEMPLATES, Template};
use crate::quote;

/// Arguments of `new`.
#[derive(Debug, Args)]
pub(super) struct NewArguments {
    /// File to write, TOML; its name becomes that of the case [default: the template's name].
    file: Option<PathBuf>,
    /// What to start from; `--list` says what there is.
    #[arg(long, short, value_name = "NAME", value_parser = Template::named)]
    template: Option<&'static Template>,
    /// List the templates.
    #[arg(long, conflicts_with_all = ["file", "template"])]
    list: bool,
}

impl NewArguments {
    pub(super) fn execute(&self) -> Result<(), Failure> {
        if self.list {
            for template in &TEMPLATES {
                say(format_args!("{:<14} {}", template.name, template.about));
            }
            return Ok(());
        }
        let asks = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
        let (template, file) = match (self.template, asks) {
            (Some(template), _) => (template, self.file.clone()),
            (None, true) => self.ask(&mut std::io::stdin().lock())?,
            (None, false) => {
                return Err(Failure::input(format!(
                    "name a template: `--template NAME`, one of {}",
                    names()
                )));
            }
        };
        let written = new::write(template, &file.unwrap_or_else(|| template.file()))?;
        let case = quote::path(&written.case);
        say(format_args!("{case} written"));
        match (&written.schema, written.schema_is_kept) {
            (schema, false) => {
                say(format_args!("{} written: editors complete and explain keys by it", quote::path(schema)))
            }
            (schema, true) => say(format_args!("{} was there and is kept", quote::path(schema))),
        }
        say(format_args!("\nnext:\n  {PROGRAM} check {case}\n  {PROGRAM} run {case}"));
        Ok(())
    }

    /// Asks for what the command line leaves open.
    fn ask(&self, answers: &mut impl BufRead) -> Result<(&'static Template, Option<PathBuf>), Failure> {
        for (k, template) in TEMPLATES.iter().enumerate() {
            note(format_args!("{:>3}  {:<14} {}", k + 1, template.name, template.about));
        }
        note(format_args!("template, by number or name:"));
        let word = answer(answers)?;
        let by_number = word.parse::<usize>().ok().and_then(|k| TEMPLATES.get(k.wrapping_sub(1)));
        let template = by_number.map_or_else(|| Template::named(&word), Ok).map_err(Failure::input)?;
        if self.file.is_some() {
            return Ok((template, self.file.clone()));
        }
        note(format_args!("file [{}]:", template.file().display()));
        let file = answer(answers)?;
        Ok((template, Some(file).filter(|file| !file.is_empty()).map(PathBuf::from)))
    }
}

fn answer(answers: &mut impl BufRead) -> Result<String, Failure> {
    let mut line = String::new();
    answers.read_line(&mut line).map_err(|error| Failure::input(format!("no answer: {error}")))?;
    Ok(line.trim().to_owned())
}

fn names() -> String {
    TEMPLATES.each_ref().map(|template| template.name).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(answers: &str) -> Result<(&'static str, Option<PathBuf>), String> {
        let arguments = NewArguments { file: None, template: None, list: false };
        let found = arguments.ask(&mut answers.as_bytes()).map_err(|failure| failure.message)?;
        Ok((found.0.name, found.1))
    }

    #[test]
    fn answers_are_numbers_or_names_and_may_leave_the_file_open() {
        assert_eq!(asked("2\n\n"), Ok(("gate", None)));
        assert_eq!(asked("impact\nball.toml\n"), Ok(("impact", Some("ball.toml".into()))));
        assert!(asked("7\n").unwrap_err().contains("tank-3d"));
        assert!(asked("gat\n").unwrap_err().contains("did you mean `gate`?"));
    }
}
