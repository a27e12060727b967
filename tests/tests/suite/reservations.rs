//! Runs that reach their end with reservations about their answer, through the program.

use crate::bench;
use tests::bench::{Bench, text};
use tests::kill::same_results;

/// Calls `run` on `case` into the folder `name`; exit code and what was said.
fn run(bench: &Bench, case: &str, name: &str, further: &[&str]) -> (Option<i32>, String) {
    let out = bench.path(name);
    let mut arguments = vec!["run", case, "--out", text(&out)];
    arguments.extend(further);
    let output = bench.call(&arguments);
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_run_with_reservations_succeeds_and_says_so_and_fails_with_strict_alone() {
    let bench = bench();
    // The tank's plate is two particles across.
    let case = bench.tank("case.toml", &[]);
    let (code, said) = run(&bench, text(&case), "out", &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("completed, with reservations: the end time was reached"), "{said}");
    let summary = bench.summary("out");
    assert_eq!(summary["verdict"], "completed");
    let reservations = summary["reservations"].as_array().unwrap();
    assert_eq!(reservations.len(), 1, "{reservations:?}");
    let only = reservations[0].as_str().unwrap();
    assert!(only.starts_with("particles_across = 2.000e0, threshold 3: "), "{only}");
    let figure = |name: &str| {
        let figures = summary["quality"].as_array().unwrap();
        figures.iter().find(|figure| figure["name"] == name).unwrap_or_else(|| panic!("{name}")).clone()
    };
    assert_eq!(figure("particles_across")["verdict"], "reservation");
    assert_eq!(figure("escaped_particles")["value"], 0.0);
    assert_eq!(figure("volume_excess")["verdict"], "good");
    assert_eq!(figure("energy_residual")["verdict"], "good");
    // Water with a surface has no full container.
    assert_eq!(figure("cavity_spacings")["verdict"], "not-judged");
    let page = std::fs::read_to_string(bench.path("out/report.html")).unwrap();
    assert!(page.contains("completed, with reservations"));

    let (code, said) = run(&bench, text(&case), "strict", &["--strict"]);
    assert_eq!(code, Some(11), "{said}");
    assert!(said.contains("error: completed, with reservations") && said.contains(only), "{said}");
    same_results(&bench.path("out"), &bench.path("strict")).unwrap();

    // Three across there is nothing to say.
    let thicker = (
        "lower_m = [0.14, -0.03], upper_m = [0.16, 0.06]",
        "lower_m = [0.13, -0.03], upper_m = [0.16, 0.06]",
    );
    let clamp =
        ("lower_m = [0.14, -0.03], upper_m = [0.16, 0.0]", "lower_m = [0.13, -0.03], upper_m = [0.16, 0.0]");
    let case = bench.tank("thick.toml", &[thicker, clamp]);
    let (code, said) = run(&bench, text(&case), "thick", &["--strict"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("completed: the end time was reached"), "{said}");
    assert_eq!(bench.summary("thick")["reservations"].as_array().map(Vec::len), Some(0));
}

#[test]
fn a_resumed_run_has_the_figures_of_one_that_was_not_stopped() {
    let bench = bench();
    let case = bench.tank("case.toml", &[]);
    bench.run(&case, "whole", &[]);
    let half = bench.tank("half.toml", &[("end_time_s = 0.002", "end_time_s = 0.0008")]);
    bench.run(&half, "half", &[]);
    let out = bench.path("half");
    let resume = ["resume", text(&out), "--until", "0.002", "--quiet"];
    assert!(bench.call(&resume).status.success());
    let [whole, resumed] = ["whole", "half"].map(|name| bench.summary(name));
    assert_eq!(whole["reservations"], resumed["reservations"]);
    let strict = ["resume", text(&out), "--until", "0.002", "--quiet", "--strict"];
    let output = bench.call(&strict);
    assert_eq!(output.status.code(), Some(11), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn what_a_solver_remarks_about_the_start_is_said_and_kept() {
    let bench = bench();
    let on_the_floor =
        ("lower_m = [0.04, 0.05], upper_m = [0.08, 0.09]", "lower_m = [0.04, 0.0], upper_m = [0.08, 0.04]");
    let case = bench.tank("case.toml", &[on_the_floor]);
    for (name, further) in [("servers", &[][..]), ("threads", &["--in-process"][..])] {
        let (code, said) = run(&bench, text(&case), name, further);
        assert_eq!(code, Some(0), "{said}");
        let words: Vec<&str> = said.split_whitespace().collect();
        assert!(words.join(" ").contains("warning: body `block` starts"), "{said}");
        let summary = bench.summary(name);
        let warnings: Vec<&str> =
            summary["warnings"].as_array().unwrap().iter().filter_map(|text| text.as_str()).collect();
        let about: Vec<&&str> = warnings.iter().filter(|text| text.contains("contact distance")).collect();
        assert!(matches!(about[..], [text] if text.contains("a wall")), "{warnings:?}");
    }
    let free = bench.tank("free.toml", &[]);
    let (_, said) = run(&bench, text(&free), "free", &[]);
    assert!(!said.contains("within the contact distance"), "{said}");
}
