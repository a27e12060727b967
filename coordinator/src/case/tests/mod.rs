//! Tests of the case format as a whole.

mod bounded;
mod derived;
mod disturbance;
mod errors;
mod hostile;
mod iterated;
mod layout;
mod oddities;
mod opening;
mod overrides;
mod restart;
mod scene;
mod schema;
mod shipped;
mod spatial;
mod start;
mod walls;

use std::path::Path;

use super::{Case, CaseError, CaseErrors, Position, parse};

/// A small tank with water, a free block, a clamped plate and a probe of each solver.
pub(crate) const TANK: &str = r#"name = "tank"
[domain]
lower_m = [0.0, 0.0]
upper_m = [0.4, 0.3]
[body_force]
gravity_m_s2 = [0.0, -9.81]
[time]
end_time_s = 0.1
step = { type = "fixed", time_step_s = 1e-5 }
[fluid]
particle_spacing_m = 0.01
rest_density_kg_m3 = 1000.0
sound_speed_m_s = 30.0
[[fluid.region]]
name = "water"
shape = { type = "rectangle", lower_m = [0.0, 0.0], upper_m = [0.4, 0.1] }
[solid]
[[solid.body]]
name = "block"
shape = { type = "rectangle", lower_m = [0.05, 0.15], upper_m = [0.11, 0.21] }
material = { density_kg_m3 = 1100.0, young_modulus_pa = 12e6, poisson_ratio = 0.4 }
[[solid.body]]
name = "plate"
shape = { type = "rectangle", lower_m = [0.2, -0.03], upper_m = [0.26, 0.15] }
material = { density_kg_m3 = 1100.0, bulk_modulus_pa = 20e6, shear_modulus_pa = 4.27e6 }
[[solid.body.support]]
name = "clamp"
shape = { type = "rectangle", lower_m = [0.2, -0.03], upper_m = [0.26, 0.0] }
[[wall]]
name = "box"
type = "container"
open_sides = ["top"]
[[probe]]
name = "tip"
type = "material-point"
body = "plate"
at_m = [0.23, 0.15]
[[probe]]
name = "gauge"
type = "fluid-point"
at_m = [0.1, 0.05]
"#;

/// Changes of [`TANK`] that make its bodies updated-Lagrangian.
const UPDATED: [(&str, &str); 2] = [
    ("name = \"block\"", "name = \"block\"\nformulation = { type = \"updated-lagrangian\" }"),
    ("name = \"plate\"", "name = \"plate\"\nformulation = { type = \"updated-lagrangian\" }"),
];

/// [`TANK`] with each `from` replaced by its `to`.
fn tank_with(changes: &[(&str, &str)]) -> String {
    changed(TANK, changes)
}

/// `text` with the first place of each pattern replaced.
fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

fn read(text: &str) -> Result<Case, CaseErrors> {
    read_in(text, Path::new(env!("CARGO_MANIFEST_DIR")))
}

fn read_in(text: &str, folder: &Path) -> Result<Case, CaseErrors> {
    parse(text, "case.toml", folder, &|path| Err(format!("no such file: {}", path.display())))
}

pub(crate) fn good(text: &str) -> Case {
    read(text).unwrap_or_else(|errors| panic!("{errors}"))
}

fn bad(text: &str) -> CaseErrors {
    match read(text) {
        Err(errors) => errors,
        Ok(case) => panic!("no error found in\n{}", case.resolved_toml()),
    }
}

/// Line and column of the first `needle`.
fn place_of(text: &str, needle: &str) -> Position {
    let offset = text.find(needle).unwrap_or_else(|| panic!("{needle}"));
    let lines: Vec<&str> = text[..offset].split('\n').collect();
    let column = lines.last().map_or(0, |line| line.chars().count()) + 1;
    Position { line: lines.len(), column }
}

/// The one error of `text`, which must stand at the first `needle`.
fn only_error(text: &str, needle: &str) -> CaseError {
    let errors = bad(text);
    assert_eq!(errors.list.len(), 1, "{errors}");
    let error = errors.list[0].clone();
    assert_eq!(error.position, Some(place_of(text, needle)), "{errors}");
    error
}
