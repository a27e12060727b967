//! Layout of walls.

use sph::setup::WallParticles;
use sph::space::Vector;

use super::*;

/// The tank with a block on its floor, in place of its solids, and `more` about the block.
fn tank(shape: &str, more: &str) -> String {
    let (head, _) = TANK.split_once("[solid]").expect("the tank has solids");
    format!(
        "{head}[[wall]]\nname = \"box\"\ntype = \"container\"\nopen_sides = [\"top\"]\n\
         [[wall]]\nname = \"block\"\ntype = \"solid\"\nshape = {shape}\n{more}\n"
    )
}

/// Particles of the block.
fn block(shape: &str, layout: &str) -> WallParticles {
    let walls = tank(shape, &format!("layout = \"{layout}\""));
    let mut particles = good(&walls).fluid_setup().unwrap().plane().unwrap().wall_particles;
    let mut own = particles.wall.clone().into_iter().map(|wall| wall == 1);
    particles.position.retain(|_| own.next().unwrap());
    let mut own = particles.wall.clone().into_iter().map(|wall| wall == 1);
    particles.normal.retain(|_| own.next().unwrap());
    particles.wall.retain(|wall| *wall == 1);
    particles
}

const RECTANGLE: &str = "{ type = \"rectangle\", lower_m = [0.2, 0.0], upper_m = [0.26, 0.15] }";
const WEDGE: &str = "{ type = \"polygon\", vertices_m = [[0.2, 0.0], [0.3, 0.0], [0.25, 0.1]] }";

fn nearest(particles: &WallParticles, x: f64, y: f64) -> usize {
    let distance = |k: &usize| (particles.position[*k] - Vector::new(x, y)).norm();
    (0..particles.wall.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
}

#[test]
fn a_face_on_the_floor_of_the_tank_is_none() {
    let particles = block(RECTANGLE, "auto");
    // Beside the foot of the block, equally near its left face and the floor: the left face alone counts.
    let foot = nearest(&particles, 0.205, 0.005);
    assert!((particles.position[foot] - Vector::new(0.205, 0.005)).norm() < 1e-12);
    assert!((particles.normal[foot] - Vector::new(-1.0, 0.0)).norm() < 1e-12, "{}", particles.normal[foot]);
    // At the free corners above faces meet as before.
    assert_eq!(particles.normal[nearest(&particles, 0.205, 0.145)], Vector::zeros());
}

#[test]
fn a_wedge_has_layers_along_its_faces_down_to_the_floor() {
    let fitted = block(WEDGE, "auto");
    assert_eq!(fitted, block(WEDGE, "fitted"));
    // Half a spacing under the left face, whose normal is (−2, 1)/√5, all the way down.
    let normal = Vector::new(-2.0, 1.0).normalize();
    let depth = |k: &usize| -(fitted.position[*k] - Vector::new(0.2, 0.0)).dot(&normal);
    let outer: Vec<usize> = (0..fitted.wall.len()).filter(|k| (depth(k) - 0.005).abs() < 1e-9).collect();
    // Its length is √0.0125 m = 11.2 spacings.
    assert!((10..=11).contains(&outer.len()), "{}", outer.len());
    let lowest = outer.iter().map(|k| fitted.position[*k].y).fold(f64::INFINITY, f64::min);
    // The first stands half a step up the face from where its layer leaves the floor; steps are even to 5 %.
    assert!(lowest < 1.05 * 0.5 * 0.01 * normal.x.abs(), "{lowest}");
    // The particle under the tip is equally near both faces.
    let slanted = outer.iter().filter(|k| (fitted.normal[**k] - normal).norm() < 1e-9).count();
    assert!(slanted + 1 >= outer.len());
    // A staircase has particles at whole and a half spacings only.
    let stairs = block(WEDGE, "lattice");
    let off_lattice = |x: f64| (x / 0.01 - 0.5 - (x / 0.01 - 0.5).round()).abs() > 1e-6;
    assert!(!stairs.position.iter().any(|x| off_lattice(x.x) || off_lattice(x.y)));
    assert!(fitted.position.iter().any(|x| off_lattice(x.x)));
}

#[test]
fn a_wall_through_which_the_kernel_reaches_is_warned_of() {
    let warning = |shape: &str, more: &str| {
        let warnings = good(&tank(shape, more)).summary().warnings;
        warnings.into_iter().find(|warning| warning.contains("kernel reaches through"))
    };
    // h/dx = 1.3: the kernel reaches over three layers.
    let wide = |layers: f64| {
        format!("{{ type = \"rectangle\", lower_m = [0.2, 0.0], upper_m = [{}, 0.15] }}", 0.2 + 0.01 * layers)
    };
    for layers in [1.0, 2.0] {
        let warning = warning(&wide(layers), "").expect("it is thin");
        assert!(warning.contains(&format!("`block` is about {layers} layers thick")), "{warning}");
        assert!(warning.contains("at least 3 layers"), "{warning}");
    }
    assert_eq!(warning(&wide(3.0), ""), None);
    assert_eq!(warning(RECTANGLE, "layers = 3"), None);
    assert!(warning(RECTANGLE, "layers = 2").is_some(), "layers that the case sets count");
    assert_eq!(warning(WEDGE, ""), None, "tips are thin everywhere");
}
