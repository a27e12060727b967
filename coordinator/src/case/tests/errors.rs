//! Every kind of error is found where it stands, with what is allowed or what to do.

use sph::coupling::solver::Role;

use super::*;

/// Reads [`TANK`] with `from` changed to `to`; the one error stands at `needle`, and its report holds all `words`.
fn expect(from: &str, to: &str, needle: &str, words: &[&str]) {
    let text = tank_with(&[(from, to)]);
    only_error(&text, needle);
    let report = bad(&text).to_string();
    for word in words {
        assert!(report.contains(word), "`{word}` is missing in\n{report}");
    }
}

#[test]
fn unknown_and_missing_keys() {
    expect(
        "sound_speed_m_s = 30.0",
        "sound_speed_m_s = 30.0\ngradient_corection = \"none\"",
        "gradient_corection",
        &["`fluid.gradient_corection` = \"none\": unknown key", "did you mean `gradient_correction`?"],
    );
    // A forgotten unit: the key that is missing is the one that is meant, and is not reported as well.
    expect("end_time_s = 0.1", "end_time = 0.1", "end_time", &["did you mean `end_time_s`?"]);
    expect(
        "young_modulus_pa",
        "young_modulus_mpa",
        "young_modulus_mpa",
        &["did you mean `young_modulus_pa`?"],
    );
    expect("end_time_s = 0.1\n", "", "[time]", &["`time.end_time_s`: missing", "add `end_time_s` here"]);
    expect(
        "[solid]\n",
        "[solid]\ncolour = 3\n",
        "colour",
        &["unknown key", "known here:", "lost_particle_limit"],
    );
    expect("[[wall]]", "[walls]\n[[wall]]", "walls", &["`walls`: unknown key"]);
    // What else a shape may have depends on the key that is missing.
    expect(
        "{ type = \"rectangle\", lower_m = [0.05",
        "{ tyPe = \"rectangle\", lower_m = [0.05",
        "tyPe",
        &["`solid.body[0].shape.tyPe` = \"rectangle\": unknown key", "did you mean `type`?"],
    );
    expect(
        "{ type = \"rectangle\", lower_m = [0.05",
        "{ lower_m = [0.05",
        "{ lower_m = [0.05",
        &["`solid.body[0].shape.type`: missing", "add `type` here"],
    );
}

#[test]
fn values_of_the_wrong_type_or_out_of_range() {
    expect("= 0.01\n", "= \"1 cm\"\n", "\"1 cm\"", &["wrong type: string", "a number above 0"]);
    expect(
        "1000.0",
        "-1000.0",
        "-1000.0",
        &["`fluid.rest_density_kg_m3` = -1000.0: out of range", "above 0"],
    );
    expect("30.0", "nan", "nan", &["out of range"]);
    expect("30.0", "inf", "inf", &["out of range"]);
    expect("30.0", "1e999", "1e999", &["out of range"]);
    expect(
        "poisson_ratio = 0.4",
        "poisson_ratio = 0.5",
        "0.5 }",
        &["below 0.5 (0.49 for nearly incompressible)"],
    );
    expect("at_m = [0.1, 0.05]", "at_m = [0.1]", "[0.1]", &["two finite numbers, [x, y]"]);
    expect("[solid]", "lost_particle_limit = 1.5\n[solid]", "lost_particle_limit", &["unknown key"]);
    expect("[solid]\n", "[solid]\nlost_particle_limit = -1\n", "-1\n", &["a whole number from 0"]);
    expect("[solid]\n", "[solid]\nkernel_ratio = 9\n", "9\n", &["from 0.8 to 4"]);
    expect("[[fluid.region]]", "[fluid.region]", "[fluid.region]", &["write [[fluid.region]] for each"]);
    expect("name = \"water\"", "name = \"wa ter\"", "\"wa ter\"", &["letters, digits, `_` or `-`"]);
}

#[test]
fn words_of_closed_lists() {
    expect("\"container\"", "\"contaner\"", "\"contaner\"", &["unknown word", "did you mean `container`?"]);
    expect("[\"top\"]", "[\"up\"]", "\"up\"", &["allowed: \"left\", \"right\", \"bottom\", \"top\""]);
    expect("[\"top\"]", "[\"top\", \"top\"]", "\"top\"]", &["named twice"]);
    expect(
        "type = \"fluid-point\"",
        "type = \"fluid-pint\"",
        "\"fluid-pint\"",
        &["did you mean `fluid-point`?"],
    );
    expect("{ type = \"fixed\", ", "{ type = \"fxed\", ", "\"fxed\"", &["did you mean `fixed`?"]);
}

#[test]
fn names_that_are_doubled_or_refer_to_nothing() {
    expect(
        "body = \"plate\"",
        "body = \"plat\"",
        "\"plat\"",
        &["no body has this name", "did you mean `plate`?"],
    );
    let text = tank_with(&[
        ("name = \"plate\"", "name = \"block\""),
        ("\"plate\"\nat_m = [0.23, 0.15]", "\"block\"\nat_m = [0.1, 0.2]"),
    ]);
    let second = "\"block\"\nshape = { type = \"rectangle\", lower_m = [0.2";
    assert!(only_error(&text, second).problem.contains("another body has this name"));
    expect("name = \"gauge\"", "name = \"tip\"", "\"tip\"\ntype = \"fluid", &["another probe has this name"]);
    let reaction =
        "\n[[probe]]\nname = \"r\"\ntype = \"support-reaction\"\nbody = \"plate\"\nsupport = \"foot\"\n";
    let text = format!("{TANK}{reaction}");
    assert!(only_error(&text, "\"foot\"").hint.is_some_and(|hint| hint.contains("clamp")));
    let force = "\n[[probe]]\nname = \"f\"\ntype = \"wall-force\"\nwall = \"bx\"\n";
    let text = format!("{TANK}{force}");
    assert!(only_error(&text, "\"bx\"").hint.is_some_and(|hint| hint.contains("`box`")));
    let sums = "\n[[probe]]\nname = \"f\"\ntype = \"fluid-sums\"\nregion = \"watr\"\n";
    let text = format!("{TANK}{sums}");
    assert!(only_error(&text, "\"watr\"").hint.is_some_and(|hint| hint.contains("`water`")));
}

#[test]
fn expressions_are_marked_at_the_character() {
    let region = "name = \"water\"";
    expect(
        region,
        "name = \"water\"\nvelocity_m_s = [\"sin(2*y\", 0]",
        "\", 0]",
        &["velocity_m_s[0]", "character 8", "an expression of x, y"],
    );
    expect(region, "name = \"water\"\nvelocity_m_s = [0, \"x + q\"]", "q\"]", &["unknown name `q`"]);
    expect(
        "open_sides = [\"top\"]",
        "open_sides = [\"top\"]\nmotion = { displacement_x_m = \"0.1*x\" }",
        "x\" }",
        &["an expression of t"],
    );
    expect(
        region,
        "name = \"water\"\nvelocity_m_s = [\"1/(x-0.105)^0.5\", 0]",
        "\"1/(x",
        &["is NaN at (0.005000, 0.005000) m", "finite values in the whole shape"],
    );
}

#[test]
fn shapes_that_are_no_shapes() {
    expect(
        "upper_m = [0.4, 0.1]",
        "upper_m = [0.0, 0.1]",
        "{ type = \"rectangle\", lower_m = [0.0",
        &["upper must lie"],
    );
    let polygon = "{ type = \"polygon\", vertices_m = [[0, 0], [0.1, 0.1], [0.1, 0], [0, 0.1]] }";
    expect(
        "{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.4, 0.1] }",
        polygon,
        polygon,
        &["cross or touch"],
    );
    let nothing = "{ type = \"union\", parts = [] }";
    expect(
        "{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.4, 0.1] }",
        nothing,
        "[] }",
        &["at least one"],
    );
    let file = "{ type = \"polygon\", file = \"no_such_points.csv\" }";
    expect(
        "{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.4, 0.1] }",
        file,
        "\"no_such_points.csv\"",
        &["no such file", "header `x_m,y_m`"],
    );
}

#[test]
fn shapes_that_do_not_fit_together() {
    let block = "lower_m = [0.05, 0.15], upper_m = [0.11, 0.21]";
    let shape = "{ type = \"rectangle\", lower_m = [0.";
    let blocks_shape =
        |text: &str| text.find("name = \"block\"").and_then(|at| text[at..].find(shape).map(|k| at + k));
    let text = tank_with(&[(block, "lower_m = [0.05, 0.25], upper_m = [0.11, 0.31]")]);
    let error = only_error(&text, &text[blocks_shape(&text).unwrap()..]);
    assert!(error.problem.contains("body `block` leaves the domain: 6 particles outside"), "{error:?}");
    assert!(error.hint.is_some_and(|hint| hint.contains("enlarge `domain`")));

    let text = tank_with(&[(block, "lower_m = [0.16, 0.12], upper_m = [0.22, 0.18]")]);
    let error = only_error(&text, "\"plate\"\nshape");
    assert!(error.problem.contains("overlaps the body `block`"), "{error:?}");

    // A block that is not held sinks into the floor.
    let text = tank_with(&[
        (block, "lower_m = [0.05, 0.0], upper_m = [0.11, 0.06]"),
        (
            "[[solid.body.support]]",
            "[[wall]]
name = \"sill\"
type = \"solid\"
shape = { type = \"rectangle\", lower_m = [0.05, 0.0], upper_m = [0.11, 0.02] }
[[solid.body.support]]",
        ),
    ]);
    let error = only_error(&text, "\"block\"");
    assert!(error.problem.contains("overlaps the wall `sill`"), "{error:?}");
    assert!(error.hint.is_some_and(|hint| hint.contains("hold the part inside with a support")));

    expect(
        "name = \"water\"",
        "name = \"water\"\ncut_by_solids = false",
        "\"water\"",
        &["overlaps solids", "set `cut_by_solids = true`"],
    );
    expect(
        "[solid]",
        "[[fluid.region]]\nname = \"more\"\nshape = { type = \"circle\", centre_m = [0.1, 0.11], radius_m = 0.03 }\n[solid]",
        "\"more\"",
        &["overlaps the region `water`", "difference"],
    );
    expect(
        "[[probe]]",
        "[[wall]]\nname = \"sill\"\ntype = \"solid\"\nshape = { type = \"rectangle\", lower_m = [0.35, 0.15], upper_m = [0.45, 0.2] }\n[[probe]]",
        "\"sill\"",
        &["overlaps the wall `box`"],
    );
}

#[test]
fn shapes_that_hold_nothing() {
    let clamp = "lower_m = [0.2, -0.03], upper_m = [0.26, 0.0]";
    let text = tank_with(&[(clamp, "lower_m = [0.3, -0.03], upper_m = [0.36, 0.0]")]);
    let error = only_error(&text, "{ type = \"rectangle\", lower_m = [0.3, -0.03]");
    assert!(error.problem.contains("support `clamp` holds no particle of `plate`"));

    expect(
        "upper_m = [0.4, 0.1]",
        "upper_m = [0.004, 0.1]",
        "{ type = \"rectangle\", lower_m = [0.0, 0.0]",
        &["holds no particle", "larger than the particle spacing of 0.01 m"],
    );
    expect(
        "lower_m = [0.0, 0.0], upper_m = [0.4, 0.1]",
        "lower_m = [0.21, 0.02], upper_m = [0.25, 0.1]",
        "\"water\"",
        &["no particle is left beside solids and walls"],
    );
    // One particle across has no bending stiffness.
    let thin = tank_with(&[(
        "lower_m = [0.05, 0.15], upper_m = [0.11, 0.21]",
        "lower_m = [0.05, 0.15], upper_m = [0.06, 0.21]",
    )]);
    assert!(only_error(&thin, "\"block\"").problem.contains("1 particle across"));
}

#[test]
fn two_supports_of_one_particle() {
    let second = "[[solid.body.support]]\nname = \"roller\"\nheld = [\"x\"]\nshape = { type = \"rectangle\", lower_m = [0.19, -0.01], upper_m = [0.3, 0.01] }\n[[wall]]";
    let text = tank_with(&[("[[wall]]", second)]);
    let error = only_error(&text, "{ type = \"rectangle\", lower_m = [0.19");
    assert!(error.problem.contains("`clamp` holds already"), "{error:?}");
    let text = tank_with(&[("[[wall]]", &second.replace("[\"x\"]", "[]"))]);
    assert!(bad(&text).to_string().contains("holds no component"));
}

#[test]
fn probes_outside() {
    expect(
        "at_m = [0.1, 0.05]",
        "at_m = [0.1, -0.05]",
        "[0.1, -0.05]",
        &["lies outside the domain", "x from 0 to 0.4"],
    );
    expect(
        "at_m = [0.23, 0.15]",
        "at_m = [0.23, 0.2]",
        "[0.23, 0.2]",
        &["outside the body `plate`", "0.01 m"],
    );
    let text = format!("{TANK}\n[[probe]]\nname = \"level\"\ntype = \"water-level\"\nx_m = 0.5\n");
    assert!(only_error(&text, "0.5\n").problem.contains("outside the domain"));
}

#[test]
fn probes_of_a_side_that_is_not_there() {
    let fluid_only = &TANK[..TANK.find("[solid]").unwrap()];
    let text = format!("{fluid_only}[[probe]]\nname = \"m\"\ntype = \"body-motion\"\nbody = \"plate\"\n");
    let error = only_error(&text, "\"body-motion\"");
    assert!(error.problem.contains("the case has no `solid`"), "{error:?}");
}

#[test]
fn a_fixed_step_above_the_limit_that_a_solver_states_is_refused() {
    let case = good(&tank_with(&[]));
    let failure = case.check_stated_limit(Role::Solid, 9e-6).unwrap_err();
    for word in ["`time.step.time_step_s` = 1e-5", "9.0000e-6", "solid", "7.20e-6", "time.limit_factor"] {
        assert!(failure.message.contains(word), "no {word} in {}", failure.message);
    }
    assert!(case.check_stated_limit(Role::Solid, 1e-5).is_ok());
    let at_own_risk =
        good(&tank_with(&[("time_step_s = 1e-5 }", "time_step_s = 1e-5 }\nlimit_factor = 2.0")]));
    assert!(at_own_risk.check_stated_limit(Role::Solid, 6e-6).is_ok());
}

#[test]
fn a_step_beyond_what_automatic_substeps_reach_is_refused() {
    // A = 1e12 narrows the sub-step so far that the largest number of them does not fill the step.
    let stiff = "formulation = { type = \"total-lagrangian\", artificial_viscosity_a = 1e12 }";
    let text = TANK.replacen("[solid]\n", "[solid]\nsubsteps = \"auto\"\n", 1).replacen(
        "[[solid.body]]\nname = \"plate\"",
        &format!("{stiff}\n[[solid.body]]\nname = \"plate\""),
        1,
    );
    let error = only_error(&text, "1e-5");
    assert!(error.allowed.is_some_and(|allowed| allowed.contains("body `block`")));
}

#[test]
fn time_step_above_the_limit() {
    // c_L = √((20 + 4/3·4.27) MPa/1100) = 152.8 m/s, h = 13 mm: 8.506e-5 s.
    let [block, plate] = UPDATED;
    let text = tank_with(&[block, plate, ("time_step_s = 1e-5", "time_step_s = 1e-4")]);
    let error = only_error(&text, "1e-4");
    assert!(
        error.allowed.as_ref().is_some_and(|text| text.contains("8.50") && text.contains("h/c_L")),
        "{error:?}"
    );
    assert!(error.hint.is_some_and(|hint| hint.contains("time.limit_factor")));
    // The case may take the responsibility; then the header says so.
    let text = text.replace("[time]", "[time]\nlimit_factor = 1.2");
    let summary = good(&text).summary();
    assert_eq!(summary.limit_override, Some(1.2));
    assert!(summary.warnings.iter().any(|warning| warning.contains("times the recommended")));
}

#[test]
fn tables_that_contradict_each_other() {
    expect(
        "bulk_modulus_pa = 20e6",
        "bulk_modulus_pa = 20e6, poisson_ratio = 0.4",
        "{ density_kg_m3 = 1100.0, bulk",
        &["elastic constants of both pairs"],
    );
    expect(
        "[time]",
        "[servers]\nfluid_address = \"localhost:70000\"\n[time]",
        "\"localhost:70000\"",
        &["not an address", "HOST:PORT"],
    );
    expect(
        "[time]",
        "[servers]\nsolid_address = \"localhost:7000\"\nsolid_command = [\"beam\"]\n[time]",
        "[\"beam\"]",
        &["`solid_address` is given as well"],
    );
    expect("end_time_s = 0.1", "end_time_s = -1.0", "-1.0", &["lies before the start", "0 s or later"]);
    expect(
        "[fluid]",
        "[outputs]\npicture_times_s = [0.0, 0.2]\n[fluid]",
        "[0.0, 0.2]",
        &["0.2 s is not within the run"],
    );
    expect(
        "upper_m = [0.4, 0.3]",
        "upper_m = [0.4, 0.3]\nperiodic = [\"x\"]\noutflow_sides = [\"left\"]",
        "\"left\"",
        &["periodic"],
    );
    let region = "name = \"water\"";
    let text = tank_with(&[
        ("[0.0, -9.81]", "[0.0, 0.0]"),
        (region, "name = \"water\"\nstart = { type = \"hydrostatic\", surface_m = 0.1 }"),
    ]);
    assert!(only_error(&text, "\"water\"").hint.is_some_and(|hint| hint.contains("gravity_m_s2")));
}

#[test]
fn a_period_must_fit_the_lattice() {
    let text = tank_with(&[("upper_m = [0.4, 0.3]", "upper_m = [0.405, 0.3]\nperiodic = [\"x\"]")]);
    let errors = bad(&text);
    assert!(errors.to_string().contains("does not divide the period of 0.405 m along x"), "{errors}");
}

#[test]
fn nothing_meets_itself_through_a_periodic_side() {
    let periodic = ("upper_m = [0.4, 0.3]", "upper_m = [0.4, 0.3]\nperiodic = [\"x\"]");
    let water = "lower_m = [0.0, 0.0], upper_m = [0.4, 0.1]";
    let text = tank_with(&[periodic, (water, "lower_m = [0.0, 0.0], upper_m = [0.41, 0.1]")]);
    let error = only_error(&text, "{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [0.41");
    assert!(error.problem.contains("region `water` is wider than the period of 0.4 m along x"), "{error:?}");
    good(&tank_with(&[periodic]));
    let text = tank_with(&[
        periodic,
        ("lower_m = [0.05, 0.15], upper_m = [0.11", "lower_m = [0.05, 0.15], upper_m = [0.6"),
    ]);
    assert!(bad(&text).to_string().contains("body `block` is wider than the period"), "{}", bad(&text));
}

#[test]
fn all_errors_are_reported_at_once_in_the_order_of_the_text() {
    let text = tank_with(&[
        ("end_time_s", "endtime_s"),
        ("1000.0", "-1"),
        ("\"rectangle\", lower_m = [0.05", "\"rectange\", lower_m = [0.05"),
        ("lower_m = [0.2, -0.03], upper_m = [0.26, 0.0]", "lower_m = [0.3, -0.03], upper_m = [0.36, 0.0]"),
        ("body = \"plate\"", "body = \"plat\""),
    ]);
    let errors = bad(&text);
    let keys: Vec<&str> = errors.list.iter().map(|error| error.place.key.as_str()).collect();
    assert_eq!(
        keys,
        [
            "time.endtime_s",
            "fluid.rest_density_kg_m3",
            "solid.body[0].shape.type",
            "solid.body[1].support[0].shape",
            "probe[0].body"
        ],
        "{errors}"
    );
    assert!(errors.to_string().ends_with("5 errors in case.toml"));
}

#[test]
fn the_report_looks_like_a_compilers() {
    let text = tank_with(&[("end_time_s = 0.1", "end_time = 0.1")]);
    let report = bad(&text).render(false);
    let expected = "error: `time.end_time` = 0.1: unknown key
 --> case.toml:8:1
  |
8 | end_time = 0.1
  | ^^^^^^^^
  |
help: did you mean `end_time_s`?

1 error in case.toml";
    assert_eq!(report, expected);
    assert!(bad(&text).render(true).contains("\u{1b}["), "a terminal gets colours");
}

#[test]
fn notation_that_is_not_toml() {
    let text = "name = \"a\nfoo = = 3\nfoo = 4\n";
    let errors = bad(text);
    assert!(errors.list.iter().all(|error| error.problem.contains("not TOML")), "{errors}");
    assert_eq!(errors.list[0].position.map(|position| position.line), Some(1));
    let text = TANK.replace("name = \"tank\"", "name = \"tank\"\nname = \"tank\"");
    assert!(bad(&text).to_string().contains("duplicate key"));
}
