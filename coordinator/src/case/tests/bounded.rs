//! What a hostile case may cost, and what it may send to a terminal.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use super::*;
use crate::case::load;

/// Far above what any of these takes, far below what the work with all pairs would.
const SOON: Duration = Duration::from_secs(10);

const HEAD: &str = "name = \"crowd\"\n[domain]\nlower_m = [0, 0]\nupper_m = [1, 1]\n[time]\nend_time_s = 0.1\n\
                    step = { type = \"fixed\", time_step_s = 1e-5 }\n";

/// The errors of `text`, found soon.
fn soon(text: &str) -> CaseErrors {
    let start = Instant::now();
    let errors = bad(text);
    assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    errors
}

fn crowd(head: &str, count: usize, one: impl Fn(usize) -> String) -> String {
    (0..count).fold(format!("{HEAD}{head}"), |text, k| text + &one(k))
}

fn body(k: usize) -> String {
    format!(
        "[[solid.body]]\nname = \"b{k}\"\n\
         shape = {{ type = \"rectangle\", lower_m = [0.1, 0.1], upper_m = [0.2, 0.2] }}\n\
         material = {{ density_kg_m3 = 1000, young_modulus_pa = 1e6, poisson_ratio = 0.3 }}\n"
    )
}

#[test]
fn overlaps_of_many_things_on_one_spot_are_found_soon_and_listed_in_part() {
    let solid = "[solid]\nparticle_spacing_m = 0.01\n";
    let errors = soon(&crowd(solid, 3000, body));
    // The first has its overlaps with twenty others listed.
    assert_eq!(errors.count, 20, "{errors}");
    assert!(errors.list[0].problem.contains("overlaps the body `b0`"), "{errors}");
    let fluid = "[fluid]\nparticle_spacing_m = 0.01\nrest_density_kg_m3 = 1000\nsound_speed_m_s = 20\n";
    let region = |k: usize| {
        format!(
            "[[fluid.region]]\nname = \"r{k}\"\n\
             shape = {{ type = \"rectangle\", lower_m = [0, 0], upper_m = [1, 0.5] }}\n"
        )
    };
    let errors = soon(&crowd(fluid, 400, region));
    assert_eq!(errors.count, 20, "{errors}");
    let wall = |k: usize| {
        format!(
            "[[wall]]\nname = \"w{k}\"\ntype = \"solid\"\n\
             shape = {{ type = \"rectangle\", lower_m = [0.5, 0.5], upper_m = [0.6, 0.6] }}\n"
        )
    };
    let errors = soon(&crowd(&format!("{solid}{}", body(0)), 3000, wall));
    assert!(errors.to_string().contains("overlaps the wall `w0`"), "{errors}");
}

#[test]
fn pairs_of_a_few_things_are_all_listed() {
    let solid = "[solid]\nparticle_spacing_m = 0.01\n";
    let errors = soon(&crowd(solid, 4, body));
    assert_eq!(errors.count, 6, "{errors}");
}

#[test]
fn more_work_than_a_case_is_worth_is_an_error() {
    let corners = (0..9_999).fold(String::new(), |mut text, k| {
        let angle = std::f64::consts::TAU * f64::from(k) / 9_999.0;
        write!(text, "[{}, {}],", 0.5 + 0.3 * angle.cos(), 0.5 + 0.3 * angle.sin()).unwrap();
        text
    });
    let fluid = "[fluid]\nparticle_spacing_m = 0.01\nrest_density_kg_m3 = 1000\nsound_speed_m_s = 20\n";
    let region = |k: usize| {
        format!(
            "[[fluid.region]]\nname = \"r{k}\"\nshape = {{ type = \"polygon\", vertices_m = [{corners}] }}\n"
        )
    };
    let errors = soon(&crowd(fluid, 25, region));
    assert!(errors.to_string().contains("takes too much work to lay out"), "{errors}");
    let hint = errors.list.iter().find_map(|error| error.hint.as_deref());
    assert!(hint.is_some_and(|hint| hint.contains("fewer corners")), "{errors}");
}

#[test]
fn names_that_act_on_a_terminal_or_never_end_are_escaped_and_shortened_everywhere() {
    let long = "n".repeat(500_000);
    let probe = |name: &str| format!("[[probe]]\nname = \"p\"\ntype = \"body-motion\"\nbody = \"{name}\"\n");
    for name in ["\\u001b[31mred\\u0007", "\\u009b31m", &long] {
        let texts = [
            // A list of known names, and a suggestion.
            format!("{}{}", tank_with(&[("name = \"block\"", &format!("name = \"{name}\""))]), probe("lost")),
            format!("{TANK}{}", probe(name)),
            format!("\"{name}\" = 1\n{TANK}"),
            format!("{TANK}[fluid.\"{name}\"]\nx = 1\n"),
            tank_with(&[("\"container\"", &format!("\"{name}\""))]),
            tank_with(&[("[body_force]", &format!("[body_force]\nacceleration_m_s2 = [\"{name}\", 0]"))]),
            format!("start_from = \"{name}\"\n{TANK}"),
            tank_with(&[(
                "{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.4, 0.1] }",
                &format!("{{ type = \"polygon\", file = \"{name}\" }}"),
            )]),
        ];
        for text in texts {
            let report = bad(&text).render(false);
            assert!(!report.contains(|c: char| c.is_control() && c != '\n'), "{report:?}");
            assert!(report.len() < 20_000, "{} bytes", report.len());
        }
    }
    let text =
        format!("{}{}", tank_with(&[("name = \"block\"", "name = \"\\u001b[31mred\"")]), probe("lost"));
    assert!(bad(&text).to_string().contains("known here: \\u{1b}[31mred, plate"), "{}", bad(&text));
}

#[test]
fn a_file_whose_name_acts_on_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("\u{1b}[31mred.toml");
    let missing = load(&path, &|_| Err(String::new())).unwrap_err().to_string();
    assert!(missing.contains("\\u{1b}[31mred.toml") && !missing.contains('\u{1b}'), "{missing:?}");
    std::fs::write(&path, "name = 5").unwrap();
    let wrong = load(&path, &|_| Err(String::new())).unwrap_err();
    assert!(!wrong.to_string().contains('\u{1b}'));
}

#[test]
fn numbers_beyond_any_meaning_are_refused_at_their_key() {
    for (from, to, key) in [
        ("sound_speed_m_s = 30.0", "sound_speed_m_s = 1e300", "`fluid.sound_speed_m_s` = 1e300"),
        ("[0.0, -9.81]", "[0.0, -1e300]", "`body_force.gravity_m_s2` = [0.0, -1e300]"),
        ("end_time_s = 0.1", "end_time_s = 1e308", "`time.end_time_s` = 1e308"),
        ("time_step_s = 1e-5", "time_step_s = 1e-300", "`time.step.time_step_s` = 1e-300"),
        ("bulk_modulus_pa = 20e6", "bulk_modulus_pa = 1e308", "bulk_modulus_pa` = 1e308"),
        ("upper_m = [0.4, 0.3]", "upper_m = [1e308, 0.3]", "`domain.upper_m` = [1e308, 0.3]"),
    ] {
        let report = bad(&tank_with(&[(from, to)])).to_string();
        assert!(report.contains(key) && report.contains("a magnitude from 1e-30 to 1e30"), "{report}");
        assert!(report.ends_with("1 error in case.toml"), "{report}");
    }
}

#[test]
fn a_run_that_never_ends_names_both_keys_and_the_number_of_steps() {
    let refused = |text: &str, words: &[&str]| {
        let error = only_error(text, text.split_once("end_time_s = ").unwrap().1);
        let report = bad(text).to_string();
        assert_eq!(error.place.key, "time.end_time_s");
        assert!(words.iter().all(|word| report.contains(word)), "{report}");
        assert!(report.contains("at most 1e12 steps"), "{report}");
    };
    refused(
        &tank_with(&[("end_time_s = 0.1", "end_time_s = 1e20")]),
        &["1e20", "`time.step.time_step_s` = 1e-5 s", "1.0e25 steps", "lower `time.end_time_s` or raise"],
    );
    refused(
        &tank_with(&[("time_step_s = 1e-5", "time_step_s = 1e-20")]),
        &["`time.step.time_step_s` = 1e-20 s", "1.0e19 steps"],
    );
    let fixed = "{ type = \"fixed\", time_step_s = 1e-5 }";
    refused(
        &tank_with(&[(fixed, "{ type = \"adaptive\", maximum_s = 1e-20 }")]),
        &["`time.step.maximum_s` = 1e-20 s", "1.0e19 steps"],
    );
    refused(
        &tank_with(&[(fixed, "{ type = \"adaptive\", factor = 1e-20 }")]),
        &["`time.step.factor` = 1e-20 of the stable step", "change what makes the stable step so short"],
    );
    refused(
        &tank_with(&[("end_time_s = 0.1", "start_time_s = 1e10\nend_time_s = 10000000001.0")]),
        &["a step is lost in the rounding of times"],
    );
    let mut case = good(TANK);
    let problem = case.set_end_time(1e20).unwrap_err();
    assert!(problem.contains("1.0e25 steps") && problem.contains("at most 1e12"), "{problem}");
    assert!(case.set_end_time(1e308).unwrap_err().len() < 300);
    assert!(case.set_end_time(1e5).is_ok());
}

#[test]
fn of_a_long_line_the_part_around_the_error_is_shown() {
    let keys = (0..100_000).fold(String::new(), |mut text, k| {
        write!(text, "k{k} = 1, ").unwrap();
        text
    });
    let text = format!("name = \"line\"\ndomain = {{ {keys}upper_m = [1, 1] }}\n");
    let errors = soon(&text);
    let report = errors.to_string();
    let first = errors.list.iter().find(|error| error.place.key == "domain.k0");
    assert_eq!(first.and_then(|error| error.position), Some(place_of(&text, "k0 =")), "{errors}");
    assert!(report.contains("case.toml:2:12\n"), "{report}");
    assert!(report.contains("k1 = 1, k2 = 1") && report.contains("^^"), "{report}");
    assert!(report.lines().all(|line| line.len() < 400), "{report}");
}
