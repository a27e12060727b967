//! The cases that come with the program, and reading back what `run` writes.

use std::path::PathBuf;

use sph::coupling::solver::Role;
use sph::setup::{FluidParameters, Formulation, FormulationKind, ParameterSet};

use super::*;
use crate::case::load;

/// A case that names every key.
pub(super) const EVERYTHING: &str = include_str!("../testdata/everything.toml");

pub(super) fn cases() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases");
    let entries = |folder: PathBuf| std::fs::read_dir(folder).unwrap();
    let mut found: Vec<PathBuf> = entries(folder.clone())
        .chain(entries(folder.join("validation")))
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    found.sort();
    found
}

fn shipped(name: &str) -> Case {
    let path = cases().into_iter().find(|path| path.file_stem().is_some_and(|stem| stem == name)).unwrap();
    load(&path, &|_| Err(String::new())).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Particles by kind and name, as `check` prints them.
fn count(case: &Case, name: &str) -> (usize, usize) {
    let counts = case.summary().counts;
    let count = counts.iter().find(|count| count.name == name).unwrap();
    (count.particles, count.held)
}

/// Shipped cases with one odd value on purpose: flows of unit density, and a drop at nearly the sound speed of water.
const ODD: [&str; 3] = ["taylor_green", "taylor_green_3d", "drop"];

#[test]
fn all_shipped_cases_load_and_are_named_after_their_files() {
    assert!(cases().len() >= 4);
    for path in cases() {
        let case = load(&path, &|_| Err(String::new())).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(path.file_stem().and_then(|stem| stem.to_str()), Some(case.name.as_str()));
        let summary = case.summary();
        assert!(summary.ratio_to_recommended <= 1.0, "{}", summary.ratio_to_recommended);
        assert!(summary.forecast() > 0.0);
        let odd = case.oddities();
        assert_eq!(odd.len(), usize::from(ODD.contains(&case.name.as_str())), "{}: {odd:#?}", case.name);
    }
}

#[test]
fn no_body_of_a_shipped_case_starts_within_the_contact_distance() {
    for path in cases() {
        let case = load(&path, &|_| Err(String::new())).unwrap_or_else(|errors| panic!("{errors}"));
        if case.has(Role::Solid) {
            let opened =
                crate::check::open(&case).unwrap_or_else(|failure| panic!("{}: {failure:?}", case.name));
            assert_eq!(opened.remarks, [""; 0], "{}", case.name);
        }
    }
}

#[test]
fn resolved_cases_read_back_as_the_same_case() {
    // Files that a case names stand in its folder.
    let of_file = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        (text, path.parent().unwrap().to_owned())
    };
    let mut texts: Vec<(String, PathBuf)> = cases().into_iter().map(of_file).collect();
    texts.extend([TANK, EVERYTHING].map(|text| (text.to_owned(), env!("CARGO_MANIFEST_DIR").into())));
    for (text, folder) in texts {
        let read = |text: &str| read_in(text, &folder).unwrap_or_else(|errors| panic!("{errors}"));
        let case = read(&text);
        let resolved = case.resolved_toml();
        let again = read(&resolved);
        assert_eq!(again.resolved_toml(), resolved);
        assert_eq!(again.fluid_setup(), case.fluid_setup());
        assert_eq!(again.solid_setup(), case.solid_setup());
        assert_eq!((again.servers, again.outputs), (case.servers, case.outputs));
    }
}

#[test]
fn counts_of_case_5_2_are_exact() {
    for name in ["drifting_body", "drifting_body_paper"] {
        let case = shipped(name);
        // 73 × 146 and 219 × 4 less 6 × 4: 11,510.
        assert_eq!(count(&case, "column"), (10_658, 0));
        assert_eq!(count(&case, "floor_water"), (852, 0));
        assert_eq!(count(&case, "body"), (324, 0));
        // 6 × 40, and three rows in the clamp.
        assert_eq!(count(&case, "plate"), (240, 18));
    }
    let coarse = shipped("drifting_body_coarse");
    // 36.5 columns are 37, 109.5 less round-off 109: 37 × 73; 109 × 2 less the four columns that meet the plate.
    assert_eq!(count(&coarse, "column"), (2701, 0));
    assert_eq!(count(&coarse, "floor_water"), (210, 0));
    assert_eq!((count(&coarse, "body"), count(&coarse, "plate")), ((81, 0), (60, 9)));
    assert_eq!(count(&shipped("still_water"), "water"), (16_700, 0));
}

#[test]
fn the_summary_states_what_decides_the_run() {
    let summary = shipped("drifting_body").summary();
    assert_eq!((summary.steps, summary.fixed, summary.limit_override), (8_000, true, None));
    // 6.25e-5 s of 1.125 h/(√1.953 c₀) = 8.38e-5 s. The strength of relaxation, 0.953, is such that the step is 0.8 of the
    // limit at c₀/10. The solids take sub-steps.
    assert!((summary.ratio_to_limit - 0.7460).abs() < 1e-4, "{}", summary.ratio_to_limit);
    assert!((summary.ratio_to_recommended - 0.7460 / 0.8).abs() < 1e-4);
    let terms: Vec<String> =
        summary.active_terms.iter().map(|term| format!("{}: {}", term.owner, term.text)).collect();
    for words in [
        "fluid: density_diffusion = renormalised: Density diffusion, Eq. (18)",
        "body `plate`: hourglass = 0.3: Hourglass coefficient ζ [-], as a fraction of Young's modulus",
    ] {
        assert!(terms.iter().any(|text| text.starts_with(words)), "{terms:#?}");
    }
    let constants = summary.constants.join("\n");
    assert!(constants.contains("kernel_ratio = 1.3") && constants.contains("law wall"), "{constants}");
}

#[test]
fn presets_fill_in_what_a_case_leaves_out_and_departures_name_their_cost() {
    let with =
        |preset: &str| good(&TANK.replacen("[domain]", &format!("preset = \"{preset}\"\n[domain]"), 1));
    let (plain, recommended) = (good(TANK), with("recommended"));
    assert_eq!(plain.fluid_setup(), recommended.fluid_setup());
    assert_eq!(plain.summary().departures, [""; 0]);
    let departures = with("paper").summary().departures;
    assert!(
        departures[0].starts_with("fluid.kernel_ratio = 1.2, recommended 1.3: at 1.2"),
        "{departures:#?}"
    );
    let paper = with("paper");
    let (fluid, solid) =
        (paper.fluid_setup().unwrap().plane().unwrap(), paper.solid_setup().unwrap().plane().unwrap());
    // The limit of tension is the default of every preset: without it a run stops at 0.7 of the rest density.
    assert_eq!(
        fluid.parameters,
        FluidParameters {
            particle_spacing: 0.01,
            sound_speed: 30.0,
            tension_limit: plain.fluid_setup().unwrap().plane().unwrap().parameters.tension_limit,
            ..ParameterSet::paper()
        }
    );
    assert_eq!(fluid.run.coupling.unwrap().law, sph::setup::InterfaceLaw::PlainSum);
    assert!(solid.bodies.iter().all(|body| body.formulation.kind() == FormulationKind::UpdatedLagrangian));
    assert_eq!(solid.contact, sph::setup::ContactLaw::Sums);
    // Without a word on it, bodies are total-Lagrangian, with some damping in water.
    let Formulation::TotalLagrangian(body) =
        plain.solid_setup().unwrap().plane().unwrap().bodies[0].formulation
    else {
        panic!()
    };
    assert_eq!((body.viscosity_a, body.hourglass), (0.2, 0.3));
}

#[test]
fn every_key_of_the_format_is_documented() {
    let pages = ["../cases/FORMAT.md", "../docs/parameters.md"];
    let read = |page| std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(page)).unwrap();
    let documentation = pages.map(read).concat();
    let resolved = good(EVERYTHING).resolved_toml();
    let keys = resolved.lines().filter_map(|line| line.split_once(" = ").map(|(key, _)| key.to_owned()));
    let tables = resolved
        .lines()
        .filter(|line| line.starts_with('['))
        .flat_map(|line| line.trim_matches(['[', ']']).split('.').map(str::to_owned).collect::<Vec<_>>());
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words: std::collections::BTreeSet<&str> = documentation.split(|c| !is_word(c)).collect();
    let mut count = 0;
    for key in keys.chain(tables) {
        count += 1;
        assert!(
            words.contains(key.as_str()),
            "`{key}` is neither in cases/FORMAT.md nor in docs/parameters.md"
        );
    }
    // A change of the notation must not make the test look at nothing.
    assert!(count > 150, "{count} keys");
}

#[test]
fn the_page_lists_the_constants_that_no_case_sets() {
    let mut page = "# Fixed constants\n\nCoefficients that no case sets. `run --verbose` prints them, `summary.json` holds \
                    them under `constants`. Sizes of\ntasks and skins of neighbour lists change results by round-off alone \
                    and are left out.\n\n`UPDATE_DOCS=1 cargo test --release --workspace --lib the_page_lists` writes this \
                    page again.\n\n| name | value | meaning |\n|---|---|---|\n"
        .to_owned();
    for constant in good(TANK).fixed_constants() {
        let meaning = constant.meaning.replace('|', "\\|");
        page += &format!("| `{}` | {} | {meaning} |\n", constant.name, constant.value);
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/constants.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == page, "docs/constants.md is not what the lists say: run the test with UPDATE_DOCS=1");
    let names: std::collections::BTreeSet<_> = good(TANK).fixed_constants().map(|c| c.name).collect();
    assert_eq!(names.len(), good(TANK).fixed_constants().count(), "a name stands for two constants");
}
