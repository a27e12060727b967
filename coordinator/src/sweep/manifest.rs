//! The manifest of a sweep: its members and how far each is.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::batch;
use crate::batch::member::{Record, State};
use crate::case::overrides::Override;
use crate::failure::Failure;
use crate::family::figures::Figure;
use crate::quote;
use crate::results::files::write_file;

/// Name of the manifest in the folder of a sweep.
pub const MANIFEST: &str = "manifest.json";
/// Version of its layout.
const FORMAT: u32 = 1;

/// What a sweep is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Layout of this file.
    pub format: u32,
    /// Name of the case.
    pub case: String,
    /// Keys that are varied, in their order.
    pub keys: Vec<String>,
    /// Key figures, in words.
    pub figures: Vec<String>,
    /// Members, by number from 1.
    pub members: Vec<Entry>,
}

/// A member of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Number, from 1.
    pub number: usize,
    /// Name of its folder.
    pub label: String,
    /// What it sets of what is varied.
    pub set: Vec<Override>,
    /// Digest of its resolved case and of the states that it starts from; `None` where its case is wrong.
    pub case_digest: Option<String>,
    /// What is wrong with its case.
    pub problem: Option<String>,
}

/// How far a member is, as its folder says.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// Its case is wrong.
    Wrong(String),
    /// It was not run, or from another case.
    Waiting,
    /// It runs, or was interrupted.
    Started,
    /// Its results are complete.
    Finished {
        /// Completed steps.
        steps: u64,
        /// Wall-clock time of its steps \[s\].
        wall_seconds: f64,
    },
    /// It ended before its end time.
    Failed(String),
}

impl Progress {
    /// In a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Wrong(_) => "wrong case",
            Self::Waiting => "not run",
            Self::Started => "unfinished",
            Self::Finished { .. } => "finished",
            Self::Failed(_) => "failed",
        }
    }

    /// Why it is not finished, in words.
    pub fn reason(&self) -> &str {
        match self {
            Self::Wrong(reason) | Self::Failed(reason) => reason,
            Self::Waiting => "not run yet",
            Self::Started => "it runs, or was interrupted",
            Self::Finished { .. } => "",
        }
    }
}

impl Manifest {
    /// A manifest of the layout of this program.
    pub fn new(case: String, keys: Vec<String>, figures: &[Figure], members: Vec<Entry>) -> Self {
        let figures = figures.iter().map(Figure::to_string).collect();
        Self { format: FORMAT, case, keys, figures, members }
    }

    /// Reads the manifest in the folder of a sweep.
    ///
    /// # Errors
    /// When there is none, or it has another layout.
    pub fn read(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(MANIFEST);
        let hint = "give the folder that `sweep CASE --out DIR` made";
        let bytes = std::fs::read(&path)
            .map_err(|e| Failure::input(format!("cannot read `{}`: {e}; {hint}", path.display())))?;
        let manifest: Self = serde_json::from_slice(&bytes)
            .map_err(|e| Failure::input(format!("`{}` is no manifest of a sweep: {e}", path.display())))?;
        // A folder is made of each label.
        let unsafe_label = |entry: &&Entry| label(&entry.label) != entry.label;
        if let Some(entry) = manifest.members.iter().find(unsafe_label) {
            let name = quote::quoted(&entry.label);
            return Err(Failure::input(format!("`{}`: `{name}` is no name of a member", path.display())));
        }
        match manifest.format {
            FORMAT => Ok(manifest),
            other => Err(Failure::input(format!(
                "`{}` has format {other}, this program reads {FORMAT}; use the program that made it",
                path.display()
            ))),
        }
    }

    /// Writes it into the folder of a sweep.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Failure> {
        let write = |out: &mut _| serde_json::to_writer_pretty(out, self).map_err(std::io::Error::from);
        Ok(write_file(&folder.join(MANIFEST), write)?)
    }

    /// The key figures.
    ///
    /// # Errors
    /// When one is none.
    pub fn figures(&self) -> Result<Vec<Figure>, Failure> {
        self.figures.iter().map(|text| text.parse().map_err(Failure::input)).collect()
    }

    /// The member with `number`.
    ///
    /// # Errors
    /// When there is none.
    pub fn member(&self, number: usize) -> Result<&Entry, Failure> {
        let found = self.members.iter().find(|entry| entry.number == number);
        found.ok_or_else(|| {
            Failure::input(format!("no member {number}; the sweep has members 1 to {}", self.members.len()))
        })
    }
}

impl Entry {
    /// How far it is in the `folder` of its sweep.
    pub fn progress(&self, folder: &Path) -> Progress {
        if let Some(problem) = &self.problem {
            return Progress::Wrong(problem.clone());
        }
        let record = Record::read(&batch::folder_of(folder, &self.label));
        match record.filter(|record| Some(&record.case_digest) == self.case_digest.as_ref()) {
            None => Progress::Waiting,
            Some(Record { state: State::Started, .. }) => Progress::Started,
            Some(Record { state: State::Finished { steps, wall_seconds }, .. }) => {
                Progress::Finished { steps, wall_seconds }
            }
            Some(Record { state: State::Failed { reason, .. }, .. }) => Progress::Failed(reason),
        }
    }
}

/// A name for a folder of `text`: letters, digits and `-_.=+`, at most 100.
pub fn label(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.=+".contains(c) { c } else { '-' };
    let label: String = text.chars().map(plain).take(100).collect();
    // No hidden folder, no way up.
    label.trim_start_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_name_folders_and_nothing_else() {
        assert_eq!(label("e=1e5_nu=0.3"), "e=1e5_nu=0.3");
        assert_eq!(label("../../a b/\"c\""), "-..-a-b--c-");
        assert_eq!(label(&"x".repeat(300)).len(), 100);
    }

    #[test]
    fn a_manifest_reads_back_and_a_foreign_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let entry = Entry {
            number: 1,
            label: "a=1".into(),
            set: vec![Override::new("a", 1)],
            case_digest: None,
            problem: Some("wrong".into()),
        };
        let manifest = Manifest::new("case".into(), vec!["a".into()], &[], vec![entry.clone()]);
        manifest.write(folder.path()).unwrap();
        assert_eq!(Manifest::read(folder.path()).unwrap(), manifest);
        assert_eq!(entry.progress(folder.path()), Progress::Wrong("wrong".into()));
        assert!(manifest.member(2).unwrap_err().message.contains("members 1 to 1"));

        let mut other = manifest.clone();
        other.format = 99;
        other.write(folder.path()).unwrap();
        assert!(Manifest::read(folder.path()).unwrap_err().message.contains("has format 99"));
        let mut climbing = manifest.clone();
        climbing.members[0].label = "../elsewhere".into();
        climbing.write(folder.path()).unwrap();
        assert!(Manifest::read(folder.path()).unwrap_err().message.contains("no name of a member"));
        std::fs::write(folder.path().join(MANIFEST), "{}").unwrap();
        assert!(Manifest::read(folder.path()).unwrap_err().message.contains("is no manifest of a sweep"));
    }
}
