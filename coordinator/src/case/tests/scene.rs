//! Particles of a scene: where they stand, what they are of, and what is said of odd scenes.

use sph::setup::{ContactLaw, Formulation, InterfaceLaw, StepPolicy, WallCondition};

use super::*;
use crate::case::file::solid::{SubstepsKey, SubstepsWord};

#[test]
fn the_tank_is_laid_out_on_one_lattice() {
    let case = good(TANK);
    let (fluid, solid) =
        (case.fluid_setup().unwrap().plane().unwrap(), case.solid_setup().unwrap().plane().unwrap());
    // 40 × 10 less 6 × 10 of the plate.
    assert_eq!(fluid.particles.id.len(), 340);
    assert_eq!(solid.particles.id.len(), 36 + 18 * 6);
    assert_eq!(solid.particles.support.iter().filter(|support| **support == 1).count(), 18);
    // Floor 40 × 4 less 18, two sides 30 × 4, corners of 16 without the three beyond 4 spacings.
    assert_eq!(fluid.wall_particles.wall.len(), 160 - 18 + 240 + 26);
    assert_eq!(fluid.run, solid.run);
    assert_eq!(fluid.wall_particles, solid.wall_particles);
    // The open rim of a container that fills the domain lets water out.
    assert_eq!((fluid.outflow.upper, fluid.outflow.lower), ([false, true], [false, false]));
    // Mass of a cell of 10 mm: 0.1 kg/m of water, 0.11 of the solid.
    assert!(fluid.particles.mass.iter().all(|m| (m - 0.1).abs() < 1e-12));
    assert!(solid.particles.mass.iter().all(|m| (m - 0.11).abs() < 1e-12));
    assert!(solid.particles.id.iter().zip(0u32..).all(|(id, k)| *id == k));
    assert!(fluid.wall_particles.normal.iter().all(|n| n.norm() < 1e-12 || (n.norm() - 1.0).abs() < 1e-12));
}

#[test]
fn moduli_may_be_given_either_way() {
    let solid = good(TANK).solid_setup().unwrap().plane().unwrap();
    let [block, plate] = [&solid.bodies[0].material, &solid.bodies[1].material];
    // E = 12 MPa, ν = 0.4: K = 20 MPa, G = 4.2857 MPa.
    assert!((block.bulk_modulus / 20e6 - 1.0).abs() < 1e-12);
    assert!((block.shear_modulus / 4.285714e6 - 1.0).abs() < 1e-6);
    assert_eq!((plate.bulk_modulus, plate.shear_modulus), (20e6, 4.27e6));
}

#[test]
fn a_body_may_have_a_lattice_of_its_own_and_water_keeps_clear_of_it() {
    let text = tank_with(&[(
        "lower_m = [0.05, 0.15], upper_m = [0.11, 0.21]",
        "lower_m = [0.054, 0.057], upper_m = [0.114, 0.117]",
    )]);
    let text = text.replace("name = \"block\"", "name = \"block\"\nlattice_origin_m = [0.054, 0.057]");
    let case = good(&text);
    let (fluid, solid) = (
        case.fluid_setup().unwrap().plane().unwrap().particles,
        case.solid_setup().unwrap().plane().unwrap().particles,
    );
    assert_eq!(solid.body.iter().filter(|body| **body == 0).count(), 36);
    let closest = fluid
        .position
        .iter()
        .flat_map(|x| solid.position.iter().map(move |s| (x - s).norm()))
        .fold(f64::INFINITY, f64::min);
    // Three quarters of a spacing are kept; a whole one is not possible everywhere.
    assert!((7.5e-3..11e-3).contains(&closest), "{closest}");
}

#[test]
fn every_setting_reaches_the_solvers() {
    let text = tank_with(&[
        (
            "step = { type = \"fixed\", time_step_s = 1e-5 }",
            "step = { type = \"adaptive\", factor = 0.4, maximum_s = 2e-5, growth = 1.1 }",
        ),
        (
            "[time]",
            "[interface]\nlaw = \"wall-no-slip\"\nmargin_spacings = 2\n[ledger]\naction = \"warn\"\nbalance_tolerance = 1e-10\n[time]",
        ),
        ("[solid]\n", "[solid]\nparticle_spacing_m = 0.005\n[solid.contact]\nfriction = 0.25\n"),
        (
            "open_sides = [\"top\"]",
            "open_sides = [\"top\"]\ncondition = \"no-slip\"\nrelease_time_s = 0.05\nmotion = { angle_rad = \"0.1*sin(t)\", pivot_m = [0.2, 0.0] }",
        ),
        ("name = \"block\"", "name = \"block\"\nformulation = { type = \"rigid\" }"),
        (
            "name = \"clamp\"",
            "name = \"clamp\"\nheld = [\"y\"]\nrelease_time_s = 0.02\nmotion = { displacement_y_m = \"0.01*t\" }",
        ),
        (
            "sound_speed_m_s = 30.0",
            "sound_speed_m_s = 30.0\ndensity_diffusion = \"none\"\nlost_particle_limit = 3\ndamping = { rate_per_s = 5, until_s = 0.2 }",
        ),
    ]);
    let case = good(&text);
    let (fluid, solid) =
        (case.fluid_setup().unwrap().plane().unwrap(), case.solid_setup().unwrap().plane().unwrap());
    assert_eq!(
        fluid.run.time.step,
        StepPolicy::Adaptive { factor: 0.4, maximum: 2e-5, growth: 1.1, exact: Some(vec![0.1]) }
    );
    let coupling = fluid.run.coupling.unwrap();
    assert_eq!(
        (coupling.law, coupling.margin, coupling.solid_spacing),
        (InterfaceLaw::WallNoSlip, 0.02, 0.005)
    );
    assert_eq!(fluid.run.ledger.balance_tolerance, 1e-10);
    assert!(matches!(solid.contact, ContactLaw::Repulsion(set) if set.friction == 0.25));
    let wall = &fluid.walls[0];
    assert_eq!((wall.condition, wall.release_time), (WallCondition::NoSlip, Some(0.05)));
    assert_eq!(wall.motion.as_ref().map(|motion| motion.angle.as_str()), Some("0.1*sin(t)"));
    assert_eq!(solid.bodies[0].formulation, Formulation::Rigid);
    let support = &solid.bodies[1].supports[0];
    assert_eq!((support.held, support.release_time), ([false, true], Some(0.02)));
    assert_eq!(fluid.parameters.density_diffusion, sph::setup::DensityDiffusion::None);
    assert_eq!(
        (fluid.parameters.lost_particle_limit, fluid.damping.map(|damping| damping.rate)),
        (3, Some(5.0))
    );
    assert_eq!(solid.particles.id.len(), 4 * (36 + 108));
}

#[test]
fn a_polygon_may_come_from_a_file_and_the_resolved_case_needs_it_no_longer() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("block.csv"),
        "# corners\nx_m, y_m\n0.05,0.15\n0.11,0.15\n0.11,0.21\n0.05,0.21\n",
    )
    .unwrap();
    let text = tank_with(&[(
        "{ type = \"rectangle\", lower_m = [0.05, 0.15], upper_m = [0.11, 0.21] }",
        "{ type = \"polygon\", file = \"block.csv\" }",
    )]);
    let case = parse(&text, "case.toml", folder.path(), &|_| Err(String::new())).unwrap();
    assert_eq!(case.solid_setup(), good(TANK).solid_setup());
    assert_eq!(good(&case.resolved_toml()).solid_setup(), case.solid_setup());
    std::fs::write(folder.path().join("block.csv"), "x_m,y_m\n0.05,zero\n").unwrap();
    let errors = parse(&text, "case.toml", folder.path(), &|_| Err(String::new())).unwrap_err();
    assert!(errors.to_string().contains("block.csv line 2: `zero` is no finite number"), "{errors}");
}

#[test]
fn an_outline_of_a_drawing_becomes_a_polygon_of_the_resolved_case() {
    let folder = tempfile::tempdir().unwrap();
    let corners = [(0, 0), (60, 0), (60, 60), (0, 60)].map(|(x, y)| format!("10\n{x}\n20\n{y}\n")).concat();
    let polyline = format!("0\nLWPOLYLINE\n8\nBLOCK\n90\n4\n70\n1\n{corners}");
    let drawing = |entities: &str| format!("0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n");
    let path = folder.path().join("block.dxf");
    std::fs::write(&path, drawing(&polyline)).unwrap();
    let text = |layer: &str| {
        let outline = format!(
            "{{ type = \"outline\", file = \"block.dxf\", unit = \"mm\", layer = \"{layer}\", by_m = [0.05, 0.15] }}"
        );
        let drawn = "{ type = \"rectangle\", lower_m = [0.05, 0.15], upper_m = [0.11, 0.21] }";
        tank_with(&[(drawn, outline.as_str())])
    };
    let read = |layer: &str| parse(&text(layer), "case.toml", folder.path(), &|_| Err(String::new()));
    let case = read("block").unwrap();
    let (drawn, tank) =
        (case.solid_setup().unwrap().plane().unwrap(), good(TANK).solid_setup().unwrap().plane().unwrap());
    assert_eq!(drawn.particles.id, tank.particles.id);
    let pairs = drawn.particles.reference_position.iter().zip(&tank.particles.reference_position);
    assert!(pairs.into_iter().all(|(a, b)| (a - b).norm() < 1e-12));
    assert_eq!(good(&case.resolved_toml()).solid_setup(), case.solid_setup());
    let missing = read("hull").unwrap_err().to_string();
    assert!(missing.contains("has no lines on the layer `hull`; it has BLOCK"), "{missing}");
    std::fs::write(&path, drawing(&polyline.replace("70\n1\n", "70\n0\n"))).unwrap();
    let open = read("block").unwrap_err().to_string();
    assert!(open.contains("block.dxf: is open at (0, 0)") && open.contains("closed lines"), "{open}");
}

#[test]
fn bodies_state_whether_they_separate_fluid_regions() {
    let separation = |upper: &str| {
        let upper = format!("lower_m = [0.05, 0.15], upper_m = [{upper}, 0.21]");
        let case = good(&tank_with(&[("lower_m = [0.05, 0.15], upper_m = [0.11, 0.21]", upper.as_str())]));
        let summary = case.summary();
        (summary.constants.join("\n"), summary.warnings.join("\n"))
    };
    let (constants, warnings) = separation("0.11");
    assert!(
        constants.contains("body `block`, thick: fluid on one side does not interact with that on the other"),
        "{constants}"
    );
    assert!(!warnings.contains("interacts"), "{warnings}");
    let (constants, _) = separation("0.08");
    assert!(constants.contains("body `block`, 3 rows where thinnest"), "{constants}");
    assert!(constants.contains("dummy pressures are kept per face"), "{constants}");
}

#[test]
fn thin_bodies_and_slow_sound_are_warned_of() {
    let text = tank_with(&[(
        "lower_m = [0.05, 0.15], upper_m = [0.11, 0.21]",
        "lower_m = [0.05, 0.15], upper_m = [0.07, 0.21]",
    )]);
    let warnings = good(&text).summary().warnings;
    let thin =
        |warnings: &[String]| warnings.iter().any(|warning| warning.contains("about 2 particles across"));
    assert!(thin(&warnings), "{warnings:?}");
    // Three bend by 2 % too much.
    let warnings = good(&text.replace("upper_m = [0.07, 0.21]", "upper_m = [0.08, 0.21]")).summary().warnings;
    assert!(!warnings.iter().any(|warning| warning.contains("across its thin side")), "{warnings:?}");
    let text = tank_with(&[("sound_speed_m_s = 30.0", "sound_speed_m_s = 9.0")]);
    let warnings = good(&text).summary().warnings;
    assert!(warnings.iter().any(|warning| warning.contains("the sound speed of 9 m/s")), "{warnings:?}");
    // √(2 · 9.81 · 0.09 m) = 1.329 m/s.
    let text = tank_with(&[("sound_speed_m_s = 30.0", "sound_speed_m_s = 13.2")]);
    assert!(good(&text).summary().warnings.is_empty());
    assert!(good(TANK).summary().warnings.is_empty(), "{:?}", good(TANK).summary().warnings);
}

#[test]
fn free_bodies_that_are_too_light_for_explicit_coupling_are_named() {
    // 60 mm high: half a row of 10 mm weighs as much at 83 kg/m³.
    let block = |density: &str, more: &str| {
        let changes = [("density_kg_m3 = 1100.0, young", density), ("name = \"block\"", more)];
        let text = tank_with(&changes);
        good(&text).summary().warnings.into_iter().find(|warning| warning.contains("row of water particles"))
    };
    let rigid = "name = \"block\"\nformulation = { type = \"rigid\" }";
    assert_eq!(block("density_kg_m3 = 90.0, young", rigid), None);
    let light = block("density_kg_m3 = 80.0, young", rigid).unwrap();
    assert!(light.contains("`block` weighs 0.48") && light.contains("iterate"), "{light}");
    let soft = block("density_kg_m3 = 80.0, young", "name = \"block\"").unwrap();
    assert!(soft.contains("particle_spacing_m") && !soft.contains("iterate"), "{soft}");
}

#[test]
fn a_rigid_body_takes_substeps_and_one_of_steel_is_warned_of() {
    let with = |modulus: &str| {
        let material = format!(
            "young_modulus_pa = {modulus}, poisson_ratio = 0.4 }}\nformulation = {{ type = \"rigid\" }}"
        );
        let step = "type = \"adaptive\", factor = 0.8";
        good(&tank_with(&[
            ("young_modulus_pa = 12e6, poisson_ratio = 0.4 }", &material),
            ("type = \"fixed\", time_step_s = 1e-5", step),
        ]))
    };
    let warning = |modulus: &str| {
        with(modulus).summary().warnings.into_iter().find(|warning| warning.contains("sub-steps"))
    };
    assert_eq!(warning("1e7"), None);
    let steel = warning("2e11").unwrap();
    assert!(steel.contains("body `block`") && steel.contains("divide them by"), "{steel}");
    let stepping = |kind: &str| {
        let text = format!(
            "name = \"block\"\n[domain]\nlower_m = [0.0, 0.0]\nupper_m = [0.4, 0.3]\n[time]\nend_time_s = 0.1\n\
             step = {{ type = \"adaptive\" }}\n[solid]\nparticle_spacing_m = 0.01\n[[solid.body]]\nname = \"block\"\n\
             shape = {{ type = \"rectangle\", lower_m = [0.1, 0.1], upper_m = [0.2, 0.2] }}\n\
             material = {{ density_kg_m3 = 1100.0, young_modulus_pa = 12e6, poisson_ratio = 0.4 }}\n\
             formulation = {{ type = \"{kind}\" }}\n"
        );
        good(&text).file.solid.unwrap().substeps
    };
    assert_eq!(stepping("rigid"), SubstepsKey::Word(SubstepsWord::Auto));
    assert_eq!(stepping("updated-lagrangian"), SubstepsKey::Word(SubstepsWord::None));
}

/// A floor whose open sides end between two rows of the lattice fits the water as well as any.
#[test]
fn an_open_side_off_the_lattice_is_no_misfit() {
    let open = |sides: &str| {
        tank_with(&[("upper_m = [0.4, 0.3]", "upper_m = [0.404, 0.304]"), ("[\"top\"]", sides)])
    };
    let misfits =
        |text: &str| good(text).summary().warnings.iter().filter(|w| w.contains("off the lattice")).count();
    assert_eq!(misfits(&open("[\"top\", \"right\"]\nlayout = \"lattice\"")), 0);
    assert_eq!(misfits(&open("[\"top\"]\nlayout = \"lattice\"")), 1);
}

#[test]
fn walls_make_way_for_the_foot_of_a_plate_where_it_stands() {
    let count = |left: f64, right: f64| {
        let from = "lower_m = [0.2, -0.03], upper_m = [0.26, ";
        let to = format!("lower_m = [{left:?}, -0.03], upper_m = [{right:?}, ");
        let tip = format!("at_m = [{:?}, 0.149]", 0.5 * (left + right));
        let text = TANK.replace(from, &to).replace("at_m = [0.23, 0.15]", &tip);
        // A fine plate between two columns of the wall, or on the line between them.
        let text = text.replace("[solid]\n", "[solid]\nparticle_spacing_m = 0.002\n");
        let text = text.replace("name = \"plate\"", "name = \"plate\"\nlayout = \"fitted\"");
        good(&text).fluid_setup().unwrap().plane().unwrap().wall_particles.wall.len()
    };
    let without = 160 + 240 + 26;
    // Centres of the wall at 0.235, 0.245, …; three rows of it are as deep as the plate.
    assert_eq!(count(0.236, 0.244), without);
    assert_eq!(count(0.231, 0.239), without - 3);
    assert_eq!(count(0.232, 0.248), without - 6);
    // Faces through or near the centres of a column would leave a slot beside the plate.
    assert_eq!(count(0.235, 0.245), without);
    assert_eq!(count(0.233, 0.247), without);
}

#[test]
fn walls_make_way_on_both_sides_of_a_periodic_direction() {
    let count = |left: f64, right: f64, periodic: bool| {
        let from = "lower_m = [0.2, -0.03], upper_m = [0.26, ";
        let text = TANK.replace(from, &format!("lower_m = [{left:?}, -0.03], upper_m = [{right:?}, "));
        let text = text.replace("at_m = [0.23, 0.15]", &format!("at_m = [{:?}, 0.15]", 0.5 * (left + right)));
        let along =
            if periodic { "upper_m = [0.4, 0.3]\nperiodic = [\"x\"]" } else { "upper_m = [0.4, 0.3]" };
        let text = text.replace("upper_m = [0.4, 0.3]", along);
        good(&text).fluid_setup().unwrap().plane().unwrap().wall_particles.wall.len()
    };
    assert_eq!(count(0.37, 0.43, true), count(0.2, 0.26, true));
    assert!(count(0.2, 0.26, true) < count(0.2, 0.26, false));
}

#[test]
fn a_support_that_does_not_move_with_its_wall_is_named() {
    let motion = "motion = { displacement_x_m = \"0.01*t^2\" }";
    let parts = |changes: &[(&str, &str)]| {
        good(&tank_with(changes)).summary().warnings.into_iter().find(|warning| warning.contains("will part"))
    };
    let wall = ("name = \"box\"", format!("name = \"box\"\n{motion}"));
    let clamp = ("name = \"clamp\"", format!("name = \"clamp\"\n{motion}"));
    let (wall, clamp) = ((wall.0, wall.1.as_str()), (clamp.0, clamp.1.as_str()));
    assert!(parts(&[wall]).is_some_and(|text| text.contains("`clamp` of body `plate` is at rest")));
    assert!(parts(&[clamp]).is_some_and(|text| text.contains("`clamp` of body `plate` moves")));
    assert_eq!(parts(&[wall, clamp]), None);
}

#[test]
fn a_rigid_body_needs_no_moduli() {
    let bare =
        ("density_kg_m3 = 1100.0, young_modulus_pa = 12e6, poisson_ratio = 0.4", "density_kg_m3 = 1100.0");
    let rigid = ("name = \"block\"", "name = \"block\"\nformulation = { type = \"rigid\" }");
    let case = good(&tank_with(&[bare, rigid]));
    let material = case.solid_setup().unwrap().plane().unwrap().bodies[0].material;
    // E = 1e7 Pa and ν = 0.3.
    assert!((material.shear_modulus / (1e7 / 2.6) - 1.0).abs() < 1e-12, "{material:?}");
    let text = tank_with(&[bare]);
    assert!(bad(&text).to_string().contains("young_modulus_pa"));
}

#[test]
fn intervals_that_a_fixed_step_does_not_divide_are_named() {
    let with = |outputs: &str| tank_with(&[("[time]", &format!("[outputs]\n{outputs}\n[time]"))]);
    let warnings = good(&with("probe_interval_s = 2.5e-5\nsnapshot_interval_s = 3e-5")).summary().warnings;
    let [only] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(only.contains("`outputs.probe_interval_s`") && only.contains("8.333333e-6 s divides"), "{only}");
    // An adaptive step has no such word.
    let adaptive = with("probe_interval_s = 2.5e-5")
        .replace("type = \"fixed\", time_step_s = 1e-5", "type = \"adaptive\"");
    assert!(good(&adaptive).summary().warnings.is_empty());
}

#[test]
fn water_that_is_cut_has_the_mass_of_what_nothing_covers() {
    let scene = |shape: &str, further: &str| {
        let text = format!(
            "name = \"cut\"\n[domain]\nlower_m = [-0.3, -0.3]\nupper_m = [0.3, 0.3]\n\
             [time]\nend_time_s = 1\nstep = {{ type = \"adaptive\" }}\n\
             [fluid]\nparticle_spacing_m = 0.01\nrest_density_kg_m3 = 1000\nsound_speed_m_s = 20\n\
             [[fluid.region]]\nname = \"water\"\nshape = {shape}\n{further}"
        );
        let fluid = good(&text).fluid_setup().unwrap().plane().unwrap();
        (fluid.particles.mass.iter().sum::<f64>(), fluid.particles.mass)
    };
    let circle = |radius: f64| format!("{{ type = \"circle\", centre_m = [0.0, 0.0], radius_m = {radius} }}");
    let body = |shape: &str| {
        format!(
            "[solid]\nparticle_spacing_m = 0.01\n[[solid.body]]\nname = \"body\"\nshape = {shape}\n\
             material = {{ density_kg_m3 = 500 }}\nformulation = {{ type = \"rigid\" }}\n"
        )
    };
    let tank = format!("[[wall]]\nname = \"tank\"\ntype = \"container\"\nshape = {}\n", circle(0.1));
    // Particles at the wall make way; none of the water does.
    let (mass, _) = scene(&circle(0.1), &tank);
    let disc = |radius: f64| 1000.0 * std::f64::consts::PI * radius * radius;
    assert!((mass / disc(0.1) - 1.0).abs() < 1e-9, "{mass} {}", disc(0.1));
    // A body that lies askew, and one on the lattice; a sample of a cell stands for 1 % of it.
    let block = "{ type = \"rectangle\", lower_m = [-0.2, -0.2], upper_m = [0.2, 0.2] }";
    let (mass, _) = scene(block, &body(&circle(0.083)));
    assert!((mass - (160.0 - disc(0.083))).abs() < 2e-4 * 160.0, "{mass} {}", 160.0 - disc(0.083));
    let square = "{ type = \"rectangle\", lower_m = [-0.05, -0.05], upper_m = [0.05, 0.05] }";
    let (_, masses) = scene(block, &body(square));
    assert_eq!(masses.len(), 1500);
    assert!(masses.iter().all(|mass| (mass - 0.1).abs() < 1e-15));
    // In a wall half way through a row of cells.
    let wall = "[[wall]]\nname = \"floor\"\ntype = \"solid\"\n\
                shape = { type = \"rectangle\", lower_m = [-0.25, -0.25], upper_m = [0.25, -0.195] }\n";
    let (mass, _) = scene(block, wall);
    assert!((mass - (160.0 - 1000.0 * 0.4 * 0.005)).abs() < 2e-4 * 160.0, "{mass}");
}
