//! Case files to start from.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::case::file::CASE;
use crate::case::{spec, suggest};
use crate::failure::Failure;
use crate::quote;

/// A case file to start from.
#[derive(Debug)]
pub struct Template {
    /// Its name on a command line.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// The case file.
    pub text: &'static str,
}

/// All templates, the simplest first.
pub static TEMPLATES: [Template; 6] = [
    Template {
        name: "dam-break",
        about: "a column of water collapses and strikes a wall",
        text: include_str!("new/dam_break.toml"),
    },
    Template {
        name: "gate",
        about: "water bends an elastic gate and runs out below",
        text: include_str!("new/gate.toml"),
    },
    Template {
        name: "floating-body",
        about: "a rigid box heaves on still water",
        text: include_str!("new/floating_body.toml"),
    },
    Template {
        name: "channel",
        about: "a viscous flow, periodic, past a flexible flap",
        text: include_str!("new/channel.toml"),
    },
    Template {
        name: "impact",
        about: "a rubber ball falls into a pool",
        text: include_str!("new/impact.toml"),
    },
    Template {
        name: "tank-3d",
        about: "a dam break in space strikes a block",
        text: include_str!("new/tank_3d.toml"),
    },
];

/// Name of the schema beside a new case.
const SCHEMA: &str = "case.schema.json";

/// What [`write()`] has written.
#[derive(Debug)]
pub struct Written {
    /// The case file.
    pub case: PathBuf,
    /// The schema beside it.
    pub schema: PathBuf,
    /// The schema was there before, and was left as it is.
    pub schema_is_kept: bool,
}

impl Template {
    /// The template `name`.
    ///
    /// # Errors
    /// What there is, when there is none of that name.
    pub fn named(name: &str) -> Result<&'static Self, String> {
        let names = TEMPLATES.each_ref().map(|template| template.name);
        TEMPLATES.iter().find(|template| template.name == name).ok_or_else(|| {
            format!(
                "no template is named `{}`: {}; there are {}",
                quote::quoted(name),
                suggest(name, &names),
                names.join(", ")
            )
        })
    }

    /// Where it is written by default.
    pub fn file(&self) -> PathBuf {
        format!("{}.toml", self.name.replace('-', "_")).into()
    }

    /// The case named `name`, after the line by which editors find the schema.
    fn renamed(&self, name: &str) -> String {
        let own = format!("name = \"{}\"", self.name.replace('-', "_"));
        format!("#:schema {SCHEMA}\n{}", self.text.replacen(&own, &format!("name = \"{name}\""), 1))
    }
}

/// The JSON Schema of case files.
pub fn schema() -> String {
    spec::schema::text(&CASE)
}

/// Writes `template` to `path`, and the schema beside it unless it is there.
///
/// # Errors
/// When the file exists or cannot be written.
pub fn write(template: &Template, path: &Path) -> Result<Written, Failure> {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if stem.is_empty() || stem.len() > 64 || !stem.chars().all(good) {
        let problem =
            "its name without the ending becomes that of the case: 1 to 64 letters, digits, `_` or `-`";
        return Err(Failure::input(format!("{}: {problem}", quote::path(path))));
    }
    write_new(path, &template.renamed(stem))?;
    let schema = path.with_file_name(SCHEMA);
    let schema_is_kept = schema.exists();
    if !schema_is_kept {
        write_new(&schema, &self::schema())?;
    }
    Ok(Written { case: path.to_owned(), schema, schema_is_kept })
}

fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    let mut file = std::fs::File::create_new(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            Failure::output(format!("{} exists and is not overwritten: name another file", quote::path(path)))
        }
        _ => Failure::output(format!("{} cannot be written: {error}", quote::path(path))),
    })?;
    file.write_all(text.as_bytes())
        .map_err(|error| Failure::output(format!("{} cannot be written: {error}", quote::path(path))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::check;
    use crate::run::{RunOptions, RunRequest, run};

    #[test]
    fn templates_pass_check_without_a_word_and_take_their_first_steps() {
        let folder = tempfile::tempdir().unwrap();
        for template in &TEMPLATES {
            let path = folder.path().join(template.file());
            write(template, &path).unwrap();
            let checked = check(&path, &[]).unwrap_or_else(|failure| panic!("{}", failure.message));
            let empty: [&str; 0] = [];
            assert_eq!(checked.summary.warnings, empty, "{}", template.name);
            assert_eq!(checked.summary.departures, empty, "{}", template.name);
            assert_eq!(path.file_stem().unwrap().to_str(), Some(checked.case.name.as_str()));
            // Twenty steps.
            let end = 20.0 * checked.summary.time_step;
            let request = RunRequest {
                case: path,
                overrides: vec![crate::case::overrides::Override::new("time.end_time_s", end)],
                out: Some(folder.path().join(template.name)),
                options: RunOptions { threads: Some(1), ..RunOptions::default() },
                ..RunRequest::default()
            };
            let outcome = run(&request).and_then(|outcome| outcome.completed());
            let outcome = outcome.unwrap_or_else(|failure| panic!("{}: {}", template.name, failure.message));
            assert!(outcome.summary.steps >= 10, "{}", template.name);
        }
    }

    #[test]
    fn a_new_case_has_the_name_of_its_file_and_overwrites_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("my-tank.toml");
        let written = write(&TEMPLATES[0], &path).unwrap();
        assert!(!written.schema_is_kept && written.schema.exists());
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(
            text.starts_with("#:schema case.schema.json\n# A dam break")
                && text.contains("\nname = \"my-tank\"\n")
        );
        std::fs::write(&written.schema, "kept").unwrap();
        assert!(write(&TEMPLATES[1], &path).unwrap_err().message.contains("not overwritten"));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        let other = write(&TEMPLATES[1], &folder.path().join("other.toml")).unwrap();
        assert!(other.schema_is_kept);
        assert_eq!(std::fs::read_to_string(&other.schema).unwrap(), "kept");
        assert!(write(&TEMPLATES[0], &folder.path().join("my tank.toml")).is_err());
    }
}
