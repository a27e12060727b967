//! Solid solvers that compute one thing and say or show another: each is named at the first half-step where it shows.
//!
//! Each is a copy of `rigid_body.py` with a line replaced, in the case of `floating_body_python.toml` cut short. The
//! block turns at the start, so that the water exerts a torque at once: that on the shipped one, which lies in the middle
//! of the tank, is round-off.

use std::path::PathBuf;

use crate::bench;
use tests::bench::{Bench, text};
use tests::python::{Listening, folder, import_path, python_is_there};

const MASS: &str = "self.total = self._sums(setup.mass)";
const INERTIA: &str = "self.inertia = of_places + cells\n";
const TORQUE: &str = "torque = self._sums(cross(self._arms(stage), forces))";
const ACCELERATION: &str = "= stage[:, self.velocity], force / self.total[:, None]";
const SPINNING: &str = "rates[:, ANGLE], rates[:, SPIN] = stage[:, SPIN], torque / self.inertia";
const SHOWN: &str = "return state[self.body, self.centre] + arms, state[self.body, self.velocity] + turning";

/// A copy of `rigid_body.py` with lines replaced.
fn script_of(bench: &Bench, lines: &[(&str, &str)]) -> PathBuf {
    let mut code = std::fs::read_to_string(folder().join("rigid_body.py")).unwrap();
    for (line, other) in lines {
        assert_eq!(code.matches(line).count(), 1, "rigid_body.py has {line:?} once");
        code = code.replace(line, other);
    }
    bench.write("solver.py", &(import_path() + &code))
}

/// A case that runs a copy with `lines` replaced.
fn case_of(bench: &Bench, lines: &[(&str, &str)]) -> PathBuf {
    let script = script_of(bench, lines);
    let rigid = "formulation = { type = \"rigid\" }";
    bench.shipped(
        "floating_body_python",
        &[
            ("end_time_s = 1.0", "end_time_s = 0.01"),
            ("../solvers/python/rigid_body.py", text(&script)),
            (rigid, &format!("{rigid}\nrotation_speed_rad_s = 2.0")),
        ],
    )
}

/// Runs a copy with `lines` replaced; the run must end by `code` with a message that holds all `words`.
fn refused(test: &str, lines: &[(&str, &str)], code: i32, words: &[&str]) {
    if !python_is_there(test) {
        return;
    }
    let bench = bench();
    let case = case_of(&bench, lines);
    bench.refused(&["run", text(&case), "--quiet", "--out", text(&bench.path("out"))], code, words);
}

#[test]
fn an_honest_copy_runs_to_the_end() {
    if !python_is_there("an_honest_copy_runs_to_the_end") {
        return;
    }
    let bench = bench();
    let summary = bench.run(&case_of(&bench, &[]), "out", &[]);
    assert_eq!((&summary["verdict"], &summary["ledger"]["breaches"]), (&"completed".into(), &0.into()));
}

#[test]
fn more_torque_than_the_forces_give_is_named() {
    let more = format!("torque = 1.05 * {}", TORQUE.strip_prefix("torque = ").unwrap());
    refused(
        "more_torque_than_the_forces_give_is_named",
        &[(TORQUE, &more)],
        6,
        &["angular momentum", "solid", "step 0 predictor"],
    );
}

#[test]
fn more_inertia_than_the_particles_have_is_named() {
    let more = "self.inertia = (of_places + cells) * 1.05\n";
    refused(
        "more_inertia_than_the_particles_have_is_named",
        &[(INERTIA, more)],
        4,
        &["`block`", "moment of inertia", "kg m"],
    );
}

#[test]
fn more_inertia_than_is_said_is_named() {
    let more = SPINNING.replace("self.inertia", "(1.05 * self.inertia)");
    refused(
        "more_inertia_than_is_said_is_named",
        &[(SPINNING, &more)],
        6,
        &["angular momentum", "solid", "step 0 predictor"],
    );
}

#[test]
fn more_mass_than_the_set_up_has_is_named() {
    let more = format!("{MASS} * 1.01");
    refused("more_mass_than_the_set_up_has_is_named", &[(MASS, &more)], 4, &["`block`", "mass", "kg"]);
}

#[test]
fn more_mass_than_is_said_is_named() {
    // Its own momentum and its budget agree with each other.
    let lines = [
        (ACCELERATION, "= stage[:, self.velocity], force / (1.01 * self.total[:, None])"),
        ("return self.total @ state[:, self.velocity]", "return 1.01 * self.total @ state[:, self.velocity]"),
    ];
    refused("more_mass_than_is_said_is_named", &lines, 6, &["mass", "momentum", "step 0 corrector"]);
}

#[test]
fn samples_away_from_their_places_are_named() {
    let displaced = SHOWN.replace("+ arms", "+ arms + [0.002, 0.0]");
    refused(
        "samples_away_from_their_places_are_named",
        &[(SHOWN, &displaced)],
        6,
        &["`block`", "position", "2.000e-3 m", "step 0 predictor"],
    );
}

#[test]
fn velocities_shown_as_zero_are_named() {
    let still = SHOWN.replace("state[self.body, self.velocity] + turning", "0.0 * turning");
    refused(
        "velocities_shown_as_zero_are_named",
        &[(SHOWN, &still)],
        6,
        &["momentum", "velocities", "step 0 corrector"],
    );
}

#[test]
fn samples_shown_in_another_order_are_named() {
    let reverse =
        SHOWN.replace("state[self.body, self.centre] + arms", "(state[self.body, self.centre] + arms)[::-1]");
    refused(
        "samples_shown_in_another_order_are_named",
        &[(SHOWN, &reverse)],
        6,
        &["`block`", "place of particle", "another order", "step 0 predictor"],
    );
}

/// What `conform` says of a copy with `lines` replaced must hold all `words`.
fn found_out(test: &str, lines: &[(&str, &str)], words: &[&str]) {
    if !python_is_there(test) {
        return;
    }
    let bench = bench();
    let solver = Listening::start(&script_of(&bench, lines), &[]);
    let checks = ["body-masses", "angular-momentum"];
    for check in checks {
        let output = bench.call(&["conform", &solver.address, "--only", check]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        if output.status.code() == Some(9) {
            assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said}");
            return;
        }
        assert_eq!(output.status.code(), Some(0), "{said}");
    }
    panic!("{checks:?} find nothing");
}

#[test]
fn conform_names_each_lie() {
    let test = "conform_names_each_lie";
    let more = format!("torque = 1.05 * {}", TORQUE.strip_prefix("torque = ").unwrap());
    found_out(test, &[(TORQUE, &more)], &["angular momentum", "torque"]);
    let more = "self.inertia = (of_places + cells) * 1.05\n";
    found_out(test, &[(INERTIA, more)], &["moment of inertia of body `block`"]);
    let more = format!("{MASS} * 1.01");
    found_out(test, &[(MASS, &more)], &["mass of body `block`"]);
    let displaced = SHOWN.replace("+ arms", "+ arms + [0.002, 0.0]");
    found_out(test, &[(SHOWN, &displaced)], &["position", "beside its place"]);
    let still = SHOWN.replace("state[self.body, self.velocity] + turning", "0.0 * turning");
    found_out(test, &[(SHOWN, &still)], &["momentum", "velocities"]);
    let reverse =
        SHOWN.replace("state[self.body, self.centre] + arms", "(state[self.body, self.centre] + arms)[::-1]");
    found_out(test, &[(SHOWN, &reverse)], &["another order"]);
}
