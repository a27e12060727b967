//! What a family writes: `members.csv`, a row per run, and `family.json`, all of it.

use std::io::Write as _;

use serde::{Serialize, Serializer};

use super::{Family, Finished, Member};
use crate::failure::Failure;
use crate::results::files::write_file;

/// Writes a value as its text.
pub fn text<S: Serializer>(value: &impl std::fmt::Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

/// Writes what a run gave, or why it gave nothing.
pub fn outcome<S: Serializer>(outcome: &Result<Finished, Failure>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    #[serde(rename_all = "kebab-case")]
    enum Outcome<'a> {
        Finished(&'a Finished),
        Failed(&'a str),
    }
    let outcome = match outcome {
        Ok(finished) => Outcome::Finished(finished),
        Err(failure) => Outcome::Failed(&failure.message),
    };
    outcome.serialize(serializer)
}

/// Writes both files into the folder of the family.
pub fn write(family: &Family) -> Result<(), Failure> {
    let csv = csv(family).map_err(|e| Failure::internal(format!("`members.csv`: {e}")))?;
    write_file(&family.folder.join("members.csv"), |out| out.write_all(&csv))?;
    write_file(&family.folder.join("family.json"), |out| {
        serde_json::to_writer_pretty(out, family).map_err(std::io::Error::from)
    })?;
    Ok(())
}

fn csv(family: &Family) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let figures = family.figures.iter().map(|result| result.figure.to_string());
    let head = ["run", "particle_spacing_m", "sound_speed_m_s", "seed", "steps", "wall_s"].map(str::to_owned);
    writer.write_record(head.into_iter().chain(figures).chain(["failure".to_owned()]))?;
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for Member { place, outcome, .. } in &family.members {
        let run = outcome.as_ref().ok();
        let mut cells = vec![
            place.label(),
            place.spacing.to_string(),
            number(place.sound_speed),
            place.seed.map_or(String::new(), |seed| seed.to_string()),
            run.map_or(String::new(), |run| run.steps.to_string()),
            number(run.map(|run| run.wall_seconds)),
        ];
        cells.extend((0..family.figures.len()).map(|k| number(run.and_then(|run| run.figures[k]))));
        cells.push(outcome.as_ref().err().map_or(String::new(), |failure| failure.message.clone()));
        writer.write_record(&cells)?;
    }
    writer.into_inner().map_err(|e| e.into_error())
}
