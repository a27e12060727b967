//! Values that follow from others where a case leaves them out.

use super::*;

#[test]
fn water_bears_the_tension_at_nine_tenths_of_rest_density_unless_the_case_says_otherwise() {
    let with = |more: &str| {
        let text = tank_with(&[("sound_speed_m_s = 30.0", &format!("sound_speed_m_s = 30.0\n{more}"))]);
        good(&text).fluid_setup().unwrap().plane().unwrap().parameters
    };
    let fluid = with("");
    let unbounded = sph::laws::equation_of_state::Tait::new(1000.0, 30.0, 7.0);
    assert_eq!(fluid.tension_limit, Some(-unbounded.pressure(900.0)));
    // Above, nothing changes.
    let law = fluid.equation_of_state();
    assert_eq!(law.pressure(901.0), unbounded.pressure(901.0));
    assert_eq!(law.pressure(500.0), unbounded.pressure(900.0));
    // The limit is that of Eq. (3) itself.
    assert_eq!(with("background_pressure_pa = 2e3").tension_limit, fluid.tension_limit);
    assert_eq!(with("tension_limit_pa = 5e3").tension_limit, Some(5e3));
}

#[test]
fn gaps_are_wet_only_where_the_solid_can_see_to_it() {
    let is_wet = |text: &str| {
        let terms = good(text).summary().active_terms;
        terms.iter().any(|term| term.text.starts_with("wet = true"))
    };
    assert!(is_wet(TANK));
    assert!(!is_wet(&tank_with(&[("[solid]\n", "[interface]\nkind = \"loads\"\n[solid]\n")])));
}

#[test]
fn a_gap_in_metres_takes_the_place_of_a_contact_distance_in_spacings() {
    let with = |contact: &str, spacing: &str| {
        let contact = format!("[solid]\ncontact = {{ {contact} }}\n");
        tank_with(&[
            ("[solid]\n", &contact),
            ("particle_spacing_m = 0.01", &format!("particle_spacing_m = {spacing}")),
        ])
    };
    let distance = |contact: &str, spacing: &str| match good(&with(contact, spacing))
        .solid_setup()
        .unwrap()
        .plane()
        .unwrap()
        .contact
    {
        sph::setup::ContactLaw::Repulsion(repulsion) => repulsion.distance,
        sph::setup::ContactLaw::Sums => f64::NAN,
    };
    // Rows lie half a spacing behind their faces.
    for (spacing, expected) in [("0.01", 1.5), ("0.005", 2.0), ("0.0025", 3.0)] {
        let found = distance("gap_m = 0.005", spacing);
        // Round-off of a ratio of two numbers of the case.
        assert!((found - expected).abs() < 1e-12, "{spacing}: {found}");
    }
    assert_eq!(distance("gap_m = 0.0", "0.01"), 1.0);
    assert_eq!(distance("distance = 1.5", "0.01"), 1.5);
    let report = |contact: &str| bad(&with(contact, "0.01")).to_string();
    let both = report("gap_m = 0.005, distance = 1.5");
    assert!(both.contains("`solid.contact.gap_m`") && both.contains("leave out one of the two"), "{both}");
    let wide = report("gap_m = 0.1");
    assert!(wide.contains("up to 0.09 m, nine spacings"), "{wide}");
}
