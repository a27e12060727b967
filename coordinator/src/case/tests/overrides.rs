//! Values set over those of a case file.

use super::*;
use crate::case::overrides::Override;
use crate::case::read as read_source;
use crate::case::source::Source;

fn with(overrides: &[Override]) -> Result<Case, CaseErrors> {
    let source = Source::new(TANK, overrides.iter().map(Override::parts));
    read_source(source, "case.toml", Path::new("."), &|_| Err(String::new()))
}

fn refused(key: &str, value: &str) -> CaseErrors {
    let set = Override { key: key.to_owned(), value: value.to_owned() };
    match with(&[Override::new("time.end_time_s", 0.2), set]) {
        Err(errors) => errors,
        Ok(_) => panic!("{key} = {value} is taken"),
    }
}

#[test]
fn any_key_can_be_set_and_the_resolved_case_holds_it() {
    let set = [
        Override::new("fluid.sound_speed_m_s", 40.0),
        Override::parse("fluid.equation_of_state = linear").unwrap(),
        Override::parse("time.step={ type = \"adaptive\", factor = 0.25 }").unwrap(),
        // By number, by name, into a list of numbers, into a table that the file does not have.
        Override::parse("solid.body[0].material.poisson_ratio=0.3").unwrap(),
        Override::parse("solid.body.plate.material.density_kg_m3=1200").unwrap(),
        Override::parse("solid.body.1.support[0].shape.upper_m[1]=0.01").unwrap(),
        Override::parse("outputs.probe_interval_s=0.05").unwrap(),
        Override::parse("body_force.acceleration_m_s2=[\"sin(t)\", 0]").unwrap(),
        // The later one counts.
        Override::new("fluid.sound_speed_m_s", 50.0),
    ];
    let resolved = with(&set).unwrap_or_else(|e| panic!("{e}")).resolved_toml();
    let by_hand = tank_with(&[
        ("sound_speed_m_s = 30.0", "sound_speed_m_s = 50.0\nequation_of_state = \"linear\""),
        ("type = \"fixed\", time_step_s = 1e-5", "type = \"adaptive\", factor = 0.25"),
        ("poisson_ratio = 0.4", "poisson_ratio = 0.3"),
        ("density_kg_m3 = 1100.0, bulk_modulus_pa = 20e6", "density_kg_m3 = 1200.0, bulk_modulus_pa = 20e6"),
        ("lower_m = [0.2, -0.03], upper_m = [0.26, 0.0]", "lower_m = [0.2, -0.03], upper_m = [0.26, 0.01]"),
        ("[time]", "acceleration_m_s2 = [\"sin(t)\", 0]\n[outputs]\nprobe_interval_s = 0.05\n[time]"),
    ]);
    assert_eq!(resolved, good(&by_hand).resolved_toml());
}

#[test]
fn what_was_set_is_recorded_with_the_resolved_case_and_read_back() {
    let set = [
        Override::new("fluid.sound_speed_m_s", 40.0),
        Override::parse("fluid.equation_of_state = linear").unwrap(),
        Override::new("fluid.sound_speed_m_s", 50.0),
    ];
    let case = with(&set[..]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(case.overrides(), &set[1..], "the last value of a key");
    let recorded = case.recorded_toml();
    assert!(
        recorded.starts_with(
            "# set: fluid.equation_of_state = \"linear\"\n# set: fluid.sound_speed_m_s = 50.0\n"
        ),
        "{recorded}"
    );
    let again = good(&recorded);
    assert_eq!((again.overrides(), again.resolved_toml()), (case.overrides(), case.resolved_toml()));
    // A comment of the same words further down is a comment.
    assert!(good(&format!("{TANK}\n# set: a = b\n")).overrides().is_empty());
}

#[test]
fn an_error_names_the_override_its_value_and_what_is_allowed() {
    let errors = refused("fluid.sound_speed_m_s", "-3");
    let error = errors.list[0].clone();
    assert_eq!((error.place.key.as_str(), error.value.as_deref()), ("fluid.sound_speed_m_s", Some("-3")));
    // The second override, the value in its column.
    assert_eq!(error.position, Some(Position { line: 2, column: 25 }));
    let text = errors.to_string();
    for part in ["values set over the file:2:25", "fluid.sound_speed_m_s = -3", "allowed: a number above 0"] {
        assert!(text.contains(part), "{text}");
    }
    assert!(!text.contains("case.toml:"), "{text}");
}

#[test]
fn keys_that_lead_nowhere_are_refused_with_what_there_is() {
    for (key, value, problem, hint) in [
        ("fluid.kernel_rato", "1.2", "unknown key", "did you mean `kernel_ratio`?"),
        ("fluid.sound_sped_m_s", "1.2", "unknown key", "did you mean `sound_speed_m_s`?"),
        ("solid.body[2].name", "\"a\"", "the list has no entry `2`", "known here: block, plate"),
        ("solid.body.plat.name", "\"a\"", "the list has no entry `plat`", "did you mean `plate`?"),
        ("fluid.particle_spacing_m.x", "1", "`x` lies below a plain value", ""),
        ("fluid[0].particle_spacing_m", "1", "`[0]` follows what is no list", ""),
        ("domain.lower_m[2]", "1", "the list has no entry `2`", "its 2 entries are counted from 0"),
        ("fluid..x", "1", "no key of a case", "write a path"),
        ("fluid.kernel_ratio", "[1", "not TOML", "write a value as in the case file"),
    ] {
        let errors = refused(key, value);
        let error = &errors.list[0];
        assert!(error.problem.contains(problem), "{key}: {errors}");
        assert!(error.hint.as_deref().unwrap_or_default().contains(hint), "{key}: {errors}");
        assert_eq!(error.position.map(|position| position.line), Some(2), "{key}: {errors}");
    }
}

#[test]
fn text_of_any_kind_keeps_to_its_line() {
    let long = "9".repeat(70_000);
    for (key, value) in [("a\nb", "1\n2"), ("name", "\"a\u{1b}[31m\""), ("name", long.as_str()), ("é.é", "é")]
    {
        let errors = refused(key, value);
        assert!(errors.to_string().contains("values set over the file:2"), "{errors}");
    }
    assert!(Override::parse("no sign").unwrap_err().contains("KEY=VALUE"));
    assert!(Override::parse("=1").is_err() && Override::parse("a=").is_err());
    assert_eq!(Override::parse("a = \"b=c\"").unwrap().value, "\"b=c\"");
}
