//! `iterate` of `[interface]`.

use sph::setup::{CouplingKind, NonConvergence, Relaxation};

use super::*;

fn tank(interface: &str) -> String {
    tank_with(&[("[solid]\n", &format!("[interface]\n{interface}\n[solid]\n"))])
}

#[test]
fn iterated_half_steps_have_ranges_and_go_with_loads() {
    let cases: [(&str, &str, &[&str]); 6] = [
        ("iterate = { limit = 0 }", "0 }\n[solid]", &["a whole number from 1 to 1000"]),
        ("iterate = { tolerance = 0.0 }", "0.0 }\n[solid]", &["above 0 and below 1"]),
        ("iterate = { relaxation = 1.5 }", "1.5 }\n[solid]", &["above 0 and at most 1"]),
        ("iterate = { relaxation = \"aitkin\" }", "\"aitkin\"", &["did you mean `aitken`?"]),
        ("kind = \"states\"\niterate = {}", "{}", &["only a coupling by loads", "use `kind = \"loads\"`"]),
        ("law = \"plain-sum\"\niterate = {}", "{}", &["only a coupling by loads", "use the law `wall`"]),
    ];
    for (interface, needle, words) in cases {
        let text = tank(interface);
        only_error(&text, needle);
        let report = bad(&text).to_string();
        words.iter().for_each(|word| assert!(report.contains(word), "`{word}` is missing in\n{report}"));
    }
}

#[test]
fn iterating_alone_chooses_loads_and_has_defaults() {
    assert_eq!(good(&tank("kind = \"loads\"")).run_plan().coupling.unwrap().implicit, None);
    let coupling = good(&tank("iterate = {}")).run_plan().coupling.unwrap();
    assert_eq!(coupling.kind, CouplingKind::Loads);
    let implicit = coupling.implicit.unwrap();
    assert_eq!((implicit.relaxation, implicit.non_convergence), (Relaxation::Aitken, NonConvergence::Stop));
    assert_eq!((implicit.tolerance, implicit.limit), (1e-6, 50));
}
