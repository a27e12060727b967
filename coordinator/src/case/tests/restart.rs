//! Starts from final states.

use sph::coupling::solver::{Field, ParticleFields};

use super::*;

fn field(name: &str, components: usize, values: Vec<f64>) -> Field {
    Field { name: name.into(), unit: String::new(), components, values }
}

/// Final states of the tank in which everything has moved by 1 cm and is a little denser.
fn states(case: &Case) -> (ParticleFields, ParticleFields) {
    let fluid = case.fluid_setup().unwrap().plane().unwrap().particles;
    let solid = case.solid_setup().unwrap().plane().unwrap().particles;
    let moved = |x: &[sph::space::Vector]| x.iter().flat_map(|x| [x.x + 0.01, x.y]).collect::<Vec<_>>();
    let fluid_state = ParticleFields {
        step: 10,
        time: 0.1,
        id: fluid.id.clone(),
        group: fluid.region.clone(),
        group_names: vec!["water".into()],
        fields: vec![
            field("position", 2, moved(&fluid.position)),
            field("velocity", 2, vec![0.5; 2 * fluid.id.len()]),
            field("density", 1, vec![1001.0; fluid.id.len()]),
            field("mass", 1, fluid.mass.clone()),
        ],
    };
    let count = solid.id.len();
    let solid_state = ParticleFields {
        step: 10,
        time: 0.1,
        id: solid.id.clone(),
        group: solid.body.clone(),
        group_names: vec!["block".into(), "plate".into()],
        fields: vec![
            field("position", 2, moved(&solid.position)),
            field("velocity", 2, vec![0.25; 2 * count]),
            field("density", 1, vec![1101.0; count]),
            field("deviatoric_stress", 3, (0..count).flat_map(|_| [1.0, 2.0, 3.0]).collect()),
        ],
    };
    (fluid_state, solid_state)
}

fn restart(text: &str, fluid: &ParticleFields, solid: &ParticleFields) -> Result<Case, CaseErrors> {
    parse(text, "case.toml", Path::new("."), &|path| {
        assert!(path.parent().is_some_and(|folder| folder.ends_with("earlier/final")));
        Ok(if path.ends_with("fluid.state") { fluid.clone() } else { solid.clone() })
    })
}

#[test]
fn matching_names_take_over_the_state_and_supports_stay() {
    let case = good(TANK);
    let (fluid, solid) = states(&case);
    let text = format!("start_from = \"earlier\"\n{TANK}");
    let again = restart(&text, &fluid, &solid).unwrap();
    let (water, bodies) = (
        again.fluid_setup().unwrap().plane().unwrap().particles,
        again.solid_setup().unwrap().plane().unwrap().particles,
    );
    assert_eq!(water.velocity[3], sph::space::Vector::repeat(0.5));
    assert_eq!(water.density[3], 1001.0);
    let before = case.solid_setup().unwrap().plane().unwrap().particles;
    assert_eq!(bodies.support, before.support);
    assert_eq!(bodies.reference_position, before.reference_position);
    assert!((bodies.position[5].x - before.position[5].x - 0.01).abs() < 1e-15);
    let stress = bodies.deviatoric_stress[5];
    assert_eq!((stress.xx, stress.yy, stress.xy), (1.0, 2.0, 3.0));
    // Where the case goes next, the state is found all the same.
    let resolved = again.resolved_toml();
    let line = resolved.lines().find(|line| line.starts_with("start_from")).unwrap();
    assert!(Path::new(line.split('"').nth(1).unwrap()).is_absolute(), "{line}");
}

#[test]
fn states_that_do_not_fit_are_refused() {
    let (fluid, solid) = states(&good(TANK));
    let text = format!("start_from = \"earlier\"\n{TANK}");
    let refused = |text: &str, fluid: &ParticleFields, solid: &ParticleFields, words: &str| {
        let errors = restart(text, fluid, solid).unwrap_err();
        assert_eq!(errors.list[0].position, Some(Position { line: 1, column: 14 }));
        assert!(errors.to_string().contains(words), "{errors}");
    };
    let larger = text.replace("upper_m = [0.11, 0.21]", "upper_m = [0.12, 0.21]");
    refused(&larger, &fluid, &solid, "body `block` has 36 particles there and 42 here");
    let mut broken = fluid.clone();
    broken.fields[0].values[7] = f64::NAN;
    refused(&text, &broken, &solid, "not finite");
    broken.fields.remove(3);
    broken.fields[0].values[7] = 0.0;
    refused(&text, &broken, &solid, "no field `mass`");
    let mut other = (fluid, solid);
    other.0.group_names = vec!["tea".into()];
    other.1.group_names = vec!["a".into(), "b".into()];
    refused(&text, &other.0, &other.1, "no region or body of this case has a name of that run");
    assert!(bad(&text).to_string().contains("no such file"));
}
