//! Warnings of values that a case may have and hardly means.

use super::spatial::TANK as SPATIAL;
use super::*;

/// What is odd of [`TANK`] with `changes`.
fn odd(changes: &[(&str, &str)]) -> Vec<String> {
    good(&tank_with(changes)).oddities()
}

#[test]
fn odd_values_are_named_with_what_is_usual_and_what_to_do() {
    assert_eq!(odd(&[]), [""; 0]);
    // With the sound speed of water steps must be shorter.
    let short = ("time_step_s = 1e-5", "time_step_s = 1e-6");
    let rows: [(&[(&str, &str)], &str); 9] = [
        (
            &[("[0.0, -9.81]", "[0.0, 9.81]")],
            "body_force.gravity_m_s2 = [0.0, 9.81] points upward: y points up, and gravity on Earth is [0.0, -9.81]; \
             reverse the sign unless things are meant to fall up",
        ),
        (
            &[("[0.0, -9.81]", "[0.0, -981.0]")],
            "has a magnitude of 981 m/s²: on Earth it is 9.81 m/s², which is 981 cm/s²",
        ),
        (
            &[("rest_density_kg_m3 = 1000.0", "rest_density_kg_m3 = 1.0")],
            "fluid.rest_density_kg_m3 = 1 is the density of no liquid: water has 1000 kg/m³",
        ),
        (
            &[("sound_speed_m_s = 30.0", "sound_speed_m_s = 1500.0"), short],
            "fluid.sound_speed_m_s = 1500 is that of a real liquid: 10 times the largest speed",
        ),
        (
            &[("sound_speed_m_s = 30.0", "sound_speed_m_s = 30.0\ndynamic_viscosity_pa_s = 5000.0"), short],
            "fluid.dynamic_viscosity_pa_s = 5000 is thicker than honey",
        ),
        (
            &[("young_modulus_pa = 12e6", "young_modulus_pa = 1.0")],
            "Young's modulus of body `block` is 1 Pa: gels have 1e3 to 1e5",
        ),
        (&[("poisson_ratio = 0.4", "poisson_ratio = 0.499")], "Poisson's ratio of body `block` is 0.4990"),
        (&[("poisson_ratio = 0.4", "poisson_ratio = -0.3")], "Poisson's ratio of body `block` is -0.3000"),
        (
            &[("density_kg_m3 = 1100.0, young", "density_kg_m3 = 1.1, young")],
            "density_kg_m3 = 1.1 of body `block` is that of no solid",
        ),
    ];
    for (changes, words) in rows {
        let found = odd(changes);
        assert!(found.len() == 1 && found[0].contains(words), "{words}\n{found:#?}");
        assert!(good(&tank_with(changes)).summary().warnings.contains(&found[0]));
    }
}

#[test]
fn lengths_in_millimetres_and_a_handful_of_particles_are_odd() {
    let case = |extent: f64, spacing: f64| {
        format!(
            "name = \"box\"\n[domain]\nlower_m = [0.0, 0.0]\nupper_m = [{extent}, {extent}]\n[time]\nend_time_s = 1e-3\n\
             step = {{ type = \"adaptive\" }}\n[fluid]\nparticle_spacing_m = {spacing}\nrest_density_kg_m3 = 1000\n\
             sound_speed_m_s = 20\n[[fluid.region]]\nname = \"water\"\n\
             shape = {{ type = \"rectangle\", lower_m = [0.0, 0.0], upper_m = [{extent}, {}] }}\n\
             [[wall]]\nname = \"tank\"\ntype = \"container\"\nopen_sides = [\"top\"]\n",
            extent / 2.0
        )
    };
    let found = |extent, spacing| good(&case(extent, spacing)).oddities();
    assert_eq!(found(0.4, 0.01), [""; 0]);
    assert!(found(400.0, 10.0)[0].contains("a tank of 400 mm is 0.4"));
    assert!(found(5e-5, 1e-6)[0].contains("surface tension"));
    assert!(found(0.4, 0.1)[0].contains("leaves 8 particles of fluid"));
}

#[test]
fn gravity_toward_the_open_side_of_a_container_is_odd() {
    let text = SPATIAL.replacen("-9.81", "9.81", 1);
    assert_ne!(text, SPATIAL);
    let found = good(&text).oddities();
    assert!(found.iter().any(|line| line.contains("points to the open side `+")), "{found:#?}");
    assert_eq!(good(SPATIAL).oddities(), [""; 0]);
}
