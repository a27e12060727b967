//! What the solvers would refuse at the start of a run is an error at its key, and what is accepted they open.

use crate::case::AnyScene;

use super::*;

/// Reads [`TANK`] with the changes; the one error stands at `needle`, and its report holds all `words`.
fn refused(changes: &[(&str, &str)], needle: &str, words: &[&str]) {
    let text = tank_with(changes);
    only_error(&text, needle);
    let report = bad(&text).to_string();
    for word in words {
        assert!(report.contains(word), "`{word}` is missing in\n{report}");
    }
}

fn opens(text: &str) {
    crate::check::open(&good(text)).unwrap();
}

#[test]
fn forces_without_a_value_at_the_start() {
    let force = |text: &str| format!("[body_force]\nacceleration_m_s2 = [\"{text}\", 0]");
    for (text, value) in
        [("1/t", "inf"), ("ln(-t)", "-inf"), ("sqrt(-1-t)", "NaN"), ("1e300*exp(t)", "1e300")]
    {
        refused(
            &[("[body_force]", &force(text))],
            &format!("\"{text}\""),
            &[
                "`body_force.acceleration_m_s2[0]`",
                &format!("is {value} at t = 0e0 s"),
                "finite values at the start",
            ],
        );
    }
    refused(
        &[("[body_force]", &force("1/(x-0.105)"))],
        "\"1/(x",
        &["is inf at (0.105000, 0.005000) m at t = 0e0 s"],
    );
    // It loses its value later: that is for the run to find.
    opens(&tank_with(&[("[body_force]", &force("sqrt(0.0004-t)"))]));
}

#[test]
fn accelerations_and_loads_of_bodies() {
    let block = "name = \"block\"";
    refused(
        &[(block, "name = \"block\"\nacceleration_m_s2 = [0, \"1/t\"]")],
        "\"1/t\"",
        &["`solid.body[0].acceleration_m_s2[1]`", "is inf"],
    );
    let load = "load = [{ name = \"push\", shape = { type = \"rectangle\", lower_m = [0.04, 0.15], upper_m = [0.051, 0.21] }, traction_pa = [\"1/t\", 0] }]";
    refused(&[(block, &format!("{block}\n{load}"))], "\"1/t\"", &["`solid.body[0].load[0].traction_pa[0]`"]);
}

#[test]
fn motions_without_a_place_speed_or_acceleration_at_the_start() {
    let moved = |text: &str| format!("name = \"box\"\nmotion = {{ displacement_x_m = \"{text}\" }}");
    for (text, words) in [
        ("1/t", "is inf"),
        ("sqrt(t)", "changes at a rate of inf"),
        ("t^1.5", "has a second derivative of inf"),
    ] {
        let changes = [("name = \"box\"", moved(text))];
        let changes = changes.each_ref().map(|(from, to)| (*from, to.as_str()));
        refused(&changes, &format!("\"{text}\""), &["`wall[0].motion.displacement_x_m`", words, "1-cos(t)"]);
    }
    let clamp = "name = \"clamp\"";
    refused(
        &[(clamp, "name = \"clamp\"\nmotion = { displacement_y_m = \"ln(t)\" }")],
        "\"ln(t)\"",
        &["`solid.body[1].support[0].motion.displacement_y_m`"],
    );
    opens(&tank_with(&[("name = \"box\"", &moved("0.001*(1-cos(t))"))]));
}

#[test]
fn states_beyond_the_limits_of_the_solvers() {
    refused(
        &[("name = \"water\"", "name = \"water\"\nvelocity_m_s = [30, 0]")],
        "30, 0]",
        &["region `water` starts at 3.000e1 m/s", "below `fluid.sound_speed_m_s` = 30 m/s", "10 times"],
    );
    refused(
        &[("name = \"water\"", "name = \"water\"\nstart = { type = \"hydrostatic\", surface_m = 1e6 }")],
        "\"water\"",
        &["starts with a density of", "check `start` of the region"],
    );
    // A support that is released at the start holds nothing outside the domain.
    refused(
        &[("name = \"clamp\"", "name = \"clamp\"\nrelease_time_s = 0.0")],
        "{ type = \"rectangle\", lower_m = [0.2, -0.03], upper_m = [0.26, 0.15]",
        &["body `plate` leaves the domain: 18 particles outside"],
    );
    opens(&tank_with(&[("name = \"clamp\"", "name = \"clamp\"\nrelease_time_s = 0.01")]));
    refused(
        &[("name = \"block\"", "name = \"block\"\nvelocity_m_s = [1e4, 0]")],
        "1e4, 0]",
        &["body `block` starts at 1.000e4 m/s", "waves in its material"],
    );
}

#[test]
fn laws_that_a_formulation_does_not_know() {
    let block = "name = \"block\"";
    let [updated, plate] = UPDATED;
    let load = "load = [{ name = \"push\", shape = { type = \"rectangle\", lower_m = [0.04, 0.15], upper_m = [0.051, 0.21] }, pressure_pa = 5 }]";
    refused(
        &[updated, plate, (block, &format!("{block}\n{load}"))],
        "5 }]",
        &["`solid.body[0].load[0].pressure_pa`", "only a total-lagrangian body knows", "`traction_pa`"],
    );
    refused(
        &[
            plate,
            (block, "name = \"block\"\nformulation = { type = \"rigid\" }"),
            ("[solid]", "[solid]\ncontact = { law = \"sums\" }"),
        ],
        "\"block\"",
        &["is not updated-lagrangian, which `solid.contact.law = \"sums\"` needs"],
    );
    refused(
        &[updated, plate, ("[solid]", "[interface]\nlaw = \"plain-sum\"\n[solid]\nsubsteps = 4")],
        "\"plain-sum\"",
        &["set `solid.substeps = \"none\"`"],
    );
    // A solver of another make may know more.
    let text = tank_with(&[
        updated,
        plate,
        (block, &format!("{block}\n{load}")),
        ("[time]", "[servers]\nsolid_address = \"localhost:7000\"\n[time]"),
    ]);
    good(&text);
}

#[test]
fn what_is_accepted_the_solvers_open() {
    opens(TANK);
    // The solvers' own examination is asked as well, whatever the case language knows.
    let mut case = good(TANK);
    let AnyScene::Plane(scene) = &mut case.scene else { panic!("of the plane") };
    scene.fluid.density[3] = 1e6;
    let refused = crate::check::open(&case).unwrap_err();
    assert!(refused.message.starts_with("the fluid solver refuses the case:"), "{refused}");
    assert_eq!(refused.kind, crate::failure::Kind::Input);
    case.servers.fluid = crate::case::Server::Address("localhost:7001".into());
    crate::check::open(&case).unwrap();
}
