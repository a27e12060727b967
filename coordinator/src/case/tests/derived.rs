//! Values that follow from others where a case leaves them out.

use super::*;

#[test]
fn water_bears_the_tension_at_nine_tenths_of_rest_density_unless_the_case_says_otherwise() {
    let with = |more: &str| {
        let text = tank_with(&[("sound_speed_m_s = 30.0", &format!("sound_speed_m_s = 30.0\n{more}"))]);
        good(&text).fluid_setup().unwrap().parameters
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
