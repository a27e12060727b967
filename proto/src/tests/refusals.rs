//! Everything wrong in a set-up is refused by name.

use bytes::Bytes;
use sph::setup::{AnyFluidSetup, AnySolidSetup, FluidSetup};
use sph::space::{Plane, Space, Spatial};

use super::setups::{fluid, solid};
use crate::convert::{Convert, Path};
use crate::wire;

fn fluid_refusal(spoil: impl FnOnce(&mut wire::FluidSetup)) -> String {
    fluid_refusal_in::<Plane>(spoil)
}

fn solid_refusal(spoil: impl FnOnce(&mut wire::SolidSetup)) -> String {
    solid_refusal_in::<Plane>(spoil)
}

fn fluid_refusal_in<S: Space>(spoil: impl FnOnce(&mut wire::FluidSetup)) -> String {
    let mut message = fluid::<S>().to_wire();
    spoil(&mut message);
    AnyFluidSetup::from_wire(&message, &Path::root("open")).unwrap_err().to_string()
}

fn solid_refusal_in<S: Space>(spoil: impl FnOnce(&mut wire::SolidSetup)) -> String {
    let mut message = solid::<S>().to_wire();
    spoil(&mut message);
    AnySolidSetup::from_wire(&message, &Path::root("open")).unwrap_err().to_string()
}

fn spoil_run(spoil: impl FnOnce(&mut wire::RunSetup)) -> String {
    fluid_refusal(|m| spoil(m.run.as_mut().unwrap()))
}

#[test]
fn wrong_numbers_are_refused_by_path() {
    let gravity = |spoil: fn(&mut Vec<f64>)| {
        spoil_run(|r| {
            spoil(&mut r.body_force.as_mut().unwrap().gravity_m_per_s2.as_mut().unwrap().components);
        })
    };
    let error = gravity(|components| components[1] = f64::NAN);
    assert_eq!(error, "`open.run.body_force.gravity_m_per_s2.components[1]`: is NaN, must be finite");
    let error = gravity(|components| components.push(0.0));
    let expected = "has 3 components, must have 2 in a run of 2 dimensions";
    assert_eq!(error, format!("`open.run.body_force.gravity_m_per_s2`: {expected}"));
    let error = spoil_run(|r| r.dimensions = 4);
    assert_eq!(error, "`open.run.dimensions`: is 4, must be 2 or 3");
    let error = spoil_run(|r| r.domain.as_mut().unwrap().periodic.as_mut().unwrap().components.clear());
    let expected = "has 0 components, must have 2 in a run of 2 dimensions";
    assert_eq!(error, format!("`open.run.domain.periodic`: {expected}"));
    let density = |number| wire::Parameter {
        name: "rest_density_kg_m3".into(),
        value: Some(wire::parameter::Value::Number(number)),
    };
    let error = fluid_refusal(|m| m.parameters[2] = density(0.0));
    assert_eq!(error, "`open.parameters.rest_density_kg_m3`: is 0.0, must be a number above 0");
    let error = fluid_refusal(|m| m.parameters.push(density(1.0)));
    assert_eq!(error, "`open.parameters.rest_density_kg_m3`: is stated twice");
    let error = fluid_refusal(|m| m.parameters[2].name = "surface_tension_n_m".into());
    assert!(error.starts_with("`open.parameters.surface_tension_n_m`: is not a parameter"), "{error}");
    let error = fluid_refusal(|m| m.parameters.clear());
    assert!(error.starts_with("`open.parameters.particle_spacing_m`: is missing"), "{error}");
    let error = spoil_run(|r| r.time.as_mut().unwrap().end_time_s = Some(-1.0));
    assert!(error.contains("`open.run.time.end_time_s`: is -1.0, must not lie before"), "{error}");
    let error = spoil_run(|r| {
        r.time.as_mut().unwrap().step = Some(wire::time_plan::Step::Adaptive(wire::AdaptiveStep {
            factor: Some(0.5),
            maximum_s: Some(1.0),
            growth: Some(1.0),
            exact: None,
        }));
    });
    assert!(error.contains("`open.run.time.adaptive.growth`: is 1.0, must be above 1"), "{error}");
    let error = spoil_run(|r| {
        r.time.as_mut().unwrap().step = Some(wire::time_plan::Step::Adaptive(wire::AdaptiveStep {
            factor: Some(0.5),
            maximum_s: Some(1.0),
            growth: Some(1.1),
            exact: Some(wire::ExactTimes { times_s: vec![0.1, f64::NAN] }),
        }));
    });
    assert!(error.contains("`open.run.time.adaptive.exact.times_s[1]`: is NaN"), "{error}");
    let error = spoil_run(|r| {
        r.domain.as_mut().unwrap().upper_m = Some(wire::Vector { components: vec![-1.0, 1.0] })
    });
    assert!(error.contains("must exceed lower_m"), "{error}");
    let error = spoil_run(|r| r.time.as_mut().unwrap().end_time_s = None);
    assert_eq!(error, "`open.run.time.end_time_s`: is missing, must be finite");
    assert!(spoil_run(|r| r.run_id.clear()).contains("`open.run.run_id`: is empty"));
    assert!(spoil_run(|r| r.run_id = "x".repeat(300)).contains("has 300 bytes, at most 256"));
    assert!(spoil_run(|r| r.ledger.as_mut().unwrap().action = 0).contains("is 0, must be one of"));
    assert!(spoil_run(|r| r.time = None).contains("`open.run.time`: is missing"));
    let error = solid_refusal(|m| m.bodies[1].supports[1].release_time_s = Some(f64::INFINITY));
    assert!(error.contains("`open.bodies[1].supports[1].release_time_s`: is inf"), "{error}");
    let fixed = |count| wire::Substeps { count: Some(wire::substeps::Count::Fixed(count)) };
    for count in [0, 3] {
        let error = solid_refusal(|m| m.substeps = Some(fixed(count)));
        assert_eq!(error, format!("`open.substeps.fixed`: is {count}, must be even and at least 2"));
    }
    let error = solid_refusal(|m| m.bodies[2].formulation = "shell".into());
    let allowed = "\"total-lagrangian\", \"updated-lagrangian\", \"rigid\"";
    assert_eq!(error, format!("`open.bodies[2].formulation`: is \"shell\", must be {allowed}"));
}

#[test]
fn wrong_arrays_are_refused_by_path() {
    let particles = |m: &mut wire::FluidSetup| m.particles.clone().unwrap();
    let error = fluid_refusal(|m| {
        let mut p = particles(m);
        p.velocities_m_per_s = p.velocities_m_per_s.slice(8..);
        m.particles = Some(p);
    });
    assert!(
        error.contains("`open.particles.velocities_m_per_s`: has 632 bytes, must have 40 particles"),
        "{error}"
    );
    let error = fluid_refusal(|m| {
        let mut p = particles(m);
        p.ids = Bytes::from(vec![0; 160]);
        m.particles = Some(p);
    });
    assert!(error.contains("`open.particles.ids`: must ascend strictly"), "{error}");
    let error = fluid_refusal(|m| m.regions.truncate(1));
    assert!(error.contains("there are 1 regions"), "{error}");
    let error = fluid_refusal(|m| {
        m.walls.truncate(1);
        m.probes.clear();
    });
    assert!(error.contains("`open.wall_particles.walls`: of particle number 1 is 1"), "{error}");
    let error = solid_refusal(|m| m.particles.as_mut().unwrap().supports = Bytes::from(vec![1; 160]));
    assert!(error.contains("but body 0 has 0 supports"), "{error}");
    let error = solid_refusal(|m| {
        let mut bodies = vec![0_u8; 160];
        bodies[0] = 1;
        m.particles.as_mut().unwrap().bodies = bodies.into();
    });
    assert!(error.contains("must be in the order of bodies"), "{error}");
}

#[test]
fn probes_must_point_at_what_exists() {
    use wire::probe_argument::Value;
    let index = |k| Some(Value::Index(k));
    let error = fluid_refusal(|m| m.probes[3].arguments[0].value = index(2));
    assert!(error.contains("`open.probes[3].region`: is 2, but there are 2 regions"), "{error}");
    let error = fluid_refusal(|m| m.probes[5].arguments[0].value = index(2));
    assert!(error.contains("`open.probes[5].wall`"), "{error}");
    let error = fluid_refusal(|m| m.probes[7].arguments[1].value = index(2));
    assert!(error.contains("`open.probes[7].axis`: is 2, but there are 2 axes"), "{error}");
    let error = fluid_refusal(|m| m.probes[0].kind = "depth".into());
    assert!(error.contains("`open.probes[0].kind`: is \"depth\", must be \"fluid-point\""), "{error}");
    let error = fluid_refusal(|m| m.probes[0].arguments.clear());
    assert!(error.contains("`open.probes[0].at_m`: is missing"), "{error}");
    let error = fluid_refusal(|m| m.probes[0].arguments[0].name = "z_m".into());
    assert!(error.contains("`open.probes[0].z_m`: is no argument of the kind `fluid-point`"), "{error}");
    let error = fluid_refusal(|m| m.probes[0].columns.truncate(1));
    assert!(error.contains("`open.probes[0].columns`"), "{error}");
    for (probe, argument, value) in [(1, 0, 3), (4, 0, u32::MAX), (3, 1, 3), (3, 0, 0)] {
        let error = solid_refusal(|m| m.probes[probe].arguments[argument].value = index(value));
        assert!(error.contains(&format!("`open.probes[{probe}].")), "{error}");
    }
}

#[test]
fn the_dimensions_of_the_run_decide_its_space() {
    let space = |message: &wire::FluidSetup| {
        AnyFluidSetup::from_wire(message, &Path::root("open")).map(|setup| setup.dimensions())
    };
    assert_eq!(space(&fluid::<Plane>().to_wire()), Ok(2));
    assert_eq!(space(&fluid::<Spatial>().to_wire()), Ok(3));
    // A set-up of one space is none of the other.
    let message = fluid::<Spatial>().to_wire();
    let error = FluidSetup::<Plane>::from_wire(&message, &Path::root("open")).unwrap_err().to_string();
    assert_eq!(error, "`open.run.dimensions`: is 3, must be 2");
    let error = fluid_refusal_in::<Spatial>(|m| m.run = None);
    assert_eq!(error, "`open.run`: is missing");
    let error = fluid_refusal_in::<Plane>(|m| m.run.as_mut().unwrap().dimensions = 3);
    let expected = "has 2 components, must have 3 in a run of 3 dimensions";
    assert_eq!(error, format!("`open.run.domain.lower_m`: {expected}"));
}

#[test]
fn components_that_space_needs_are_asked_for_by_name() {
    let three = |path: &str| format!("`open.{path}`: has 2 components, must have 3 in a run of 3 dimensions");
    let cut = |vector: &mut Option<wire::Vector>| vector.as_mut().unwrap().components.truncate(2);
    let run =
        |spoil: fn(&mut wire::RunSetup)| fluid_refusal_in::<Spatial>(|m| spoil(m.run.as_mut().unwrap()));
    let error = run(|r| {
        let force = r.body_force.as_mut().unwrap();
        force.gravity_m_per_s2.as_mut().unwrap().components.truncate(2);
    });
    assert_eq!(error, three("run.body_force.gravity_m_per_s2"));
    let error = run(|r| {
        let force = r.body_force.as_mut().unwrap();
        force.expressions_m_per_s2.as_mut().unwrap().components.truncate(2);
    });
    assert_eq!(error, three("run.body_force.expressions_m_per_s2"));
    let error = run(|r| {
        r.domain.as_mut().unwrap().periodic.as_mut().unwrap().components.truncate(2);
    });
    assert_eq!(error, three("run.domain.periodic"));
    let error = fluid_refusal_in::<Spatial>(|m| {
        m.outflow.as_mut().unwrap().upper.as_mut().unwrap().components.truncate(2);
    });
    assert_eq!(error, three("outflow.upper"));
    let error = fluid_refusal_in::<Spatial>(|m| {
        use wire::probe_argument::Value;
        m.probes[0].arguments[0].value = Some(Value::PointM(wire::Vector { components: vec![0.0; 2] }));
    });
    assert_eq!(error, three("probes[0].at_m"));
    let error = fluid_refusal_in::<Spatial>(|m| m.probes[0].columns.truncate(3));
    assert!(error.contains("`open.probes[0].columns`") && error.contains("velocity_z_m_s"), "{error}");
    let motion = |spoil: fn(&mut wire::Motion)| {
        fluid_refusal_in::<Spatial>(|m| spoil(m.walls[1].motion.as_mut().unwrap()))
    };
    let error = motion(|m| m.displacement_m.as_mut().unwrap().components.truncate(2));
    assert_eq!(error, three("walls[1].motion.displacement_m"));
    let error = fluid_refusal_in::<Spatial>(|m| cut(&mut m.walls[1].motion.as_mut().unwrap().pivot_m));
    assert_eq!(error, three("walls[1].motion.pivot_m"));
    let error = solid_refusal_in::<Spatial>(|m| {
        m.bodies[1].supports[0].held.as_mut().unwrap().components.truncate(2);
    });
    assert_eq!(error, three("bodies[1].supports[0].held"));
    let error = solid_refusal_in::<Spatial>(|m| {
        m.bodies[1].acceleration_m_per_s2.as_mut().unwrap().components.truncate(2);
    });
    assert_eq!(error, three("bodies[1].acceleration_m_per_s2"));
    let plane = solid::<Plane>().to_wire();
    let error = solid_refusal_in::<Spatial>(|m| {
        let stresses = plane.particles.clone().unwrap().deviatoric_stresses_pa;
        m.particles.as_mut().unwrap().deviatoric_stresses_pa = stresses;
    });
    let expected = "has 960 bytes, must have 40 particles x 6 numbers x 8 bytes";
    assert_eq!(error, format!("`open.particles.deviatoric_stresses_pa`: {expected}"));
}

#[test]
fn an_axis_of_rotation_is_a_unit_vector_in_space_and_none_in_the_plane() {
    let axis = |components: Vec<f64>| Some(wire::Vector { components });
    let motion = |axis: Option<wire::Vector>| {
        solid_refusal_in::<Spatial>(|m| m.bodies[1].supports[1].motion.as_mut().unwrap().axis = axis)
    };
    let path = "`open.bodies[1].supports[1].motion.axis`";
    assert_eq!(motion(None), format!("{path}: is missing"));
    assert!(motion(axis(vec![0.0, 0.0, 1.1])).contains("of length 1.1, must be a unit vector"));
    assert!(motion(axis(vec![0.0; 3])).contains("of length 0.0, must be a unit vector"));
    assert!(motion(axis(vec![f64::NAN; 3])).contains("axis.components[0]`: is NaN, must be finite"));
    assert!(motion(axis(vec![1.0, 0.0])).contains("has 2 components, must have 3"));
    let error = solid_refusal_in::<Plane>(|m| {
        m.bodies[1].supports[1].motion.as_mut().unwrap().axis = axis(vec![0.0, 0.0, 1.0]);
    });
    assert_eq!(error, format!("{path}: is given, must be absent in a run of 2 dimensions"));
}
