//! `divergence.csv`: the offending particle of a run that broke down, and those around it.

use std::path::Path;

use sph::coupling::solver::{Divergence, ParticleFields};

use super::error::OutputError;
use super::table::TableFile;

/// Particles that are listed: some three rows around the offending one.
const LISTED: usize = 50;

/// Writes the particles of `state` nearest to the place of `divergence`, nearest first; nothing where no place is known.
///
/// Columns are `id`, `group`, `distance_m`, then every field as `<field>_<unit>`, numbered where it has several
/// components.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, divergence: &Divergence, state: &ParticleFields) -> Result<(), OutputError> {
    let (Some(place), Some(position)) = (divergence.position.as_deref(), state.field("position")) else {
        return Ok(());
    };
    if position.components != place.len() {
        return Ok(());
    }
    let distance = |i: usize| {
        let x = position.values.iter().skip(i * place.len());
        x.zip(place).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let offending = |i: usize| divergence.particle == Some(state.id[i]);
    let mut nearest: Vec<usize> = (0..state.id.len()).collect();
    // The offending particle first, also where its place is no number; others without a place last.
    nearest.sort_by(|a, b| offending(*b).cmp(&offending(*a)).then(distance(*a).total_cmp(&distance(*b))));
    nearest.truncate(LISTED);
    let mut columns = ["id", "group", "distance_m"].map(String::from).to_vec();
    for field in &state.fields {
        let unit = field.unit.replace(['/', ' '], "_");
        match field.components {
            1 => columns.push(format!("{}_{unit}", field.name)),
            several => columns.extend((0..several).map(|k| format!("{}_{k}_{unit}", field.name))),
        }
    }
    let mut table = TableFile::create(path, &columns)?;
    for i in nearest {
        let mut row = vec![f64::from(state.id[i]), f64::from(state.group[i]), distance(i)];
        for field in &state.fields {
            row.extend_from_slice(&field.values[i * field.components..(i + 1) * field.components]);
        }
        table.push(&row)?;
    }
    table.finish().map(drop)
}

#[cfg(test)]
mod tests {
    use sph::coupling::solver::Field;
    use sph::coupling::stage::StepStage;

    use super::*;
    use crate::results::table::Table;

    #[test]
    fn the_offending_particle_comes_first_and_the_nearest_follow() {
        let n: u32 = 200;
        let along = |k: u32| [0.1 * f64::from(k), 0.0];
        let field = |name: &str, unit: &str, components, values| Field {
            name: name.into(),
            unit: unit.into(),
            components,
            values,
        };
        let state = ParticleFields {
            id: (0..n).collect(),
            group: vec![0; 200],
            group_names: vec!["water".into()],
            fields: vec![
                field("position", "m", 2, (0..n).flat_map(along).collect()),
                field("density", "kg/m3", 1, vec![1000.0; 200]),
            ],
            ..ParticleFields::default()
        };
        let divergence = Divergence {
            at: StepStage::FIRST,
            particle: Some(120),
            position: Some(vec![12.0, 0.0]),
            quantity: "speed [m/s]".into(),
            value: 99.0,
            allowed: "less".into(),
            hint: "a test".into(),
        };
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("divergence.csv");
        write(&path, &divergence, &state).unwrap();
        let table = Table::read(&path).unwrap();
        assert_eq!(table.rows(), LISTED);
        assert_eq!(table.columns()[3..], ["position_0_m", "position_1_m", "density_kg_m3"]);
        let ids = table.column("id").unwrap();
        assert_eq!(ids[0], 120.0);
        assert!(ids.iter().all(|id| (id - 120.0).abs() <= 25.0), "{ids:?}");
    }
}
