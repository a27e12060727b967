//! Bodies in water: a sphere let go under it, floats at their draught, and a plate under its weight.

use std::f64::consts::PI;

use super::common::judged_if;
use crate::validation::cases::floating::coupling;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// Water's rest density \[kg/m³\] and gravity \[m/s²\].
const DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.81;

/// A sphere that is let go in still water.
pub struct FallingSphere;

impl FallingSphere {
    const RADIUS: f64 = 0.02;
    /// Time of the release \[s\].
    const RELEASE: f64 = 0.05;
    /// Fit of the velocity, after the release \[s\]: sound has crossed four radii, and the sphere has fallen a tenth of one.
    const FIT: (f64, f64) = (0.005, 0.032);
    /// Half a side of the tank in radii.
    const TANK: f64 = 3.0;

    /// Acceleration \[m/s²\] of the sphere in a concentric shell of b radii, of twice the density of the water:
    ///
    /// ```text
    /// a = g (s − 1)/(s + C),  C = (b³ + 2)/(2 (b³ − 1))
    /// ```
    fn in_shell(b: f64) -> f64 {
        let cube = b.powi(3);
        GRAVITY / (2.0 + (cube + 2.0) / (2.0 * (cube - 1.0)))
    }

    /// Mean of the shells inside and around the cube, which are 1.8 % apart.
    fn exact() -> f64 {
        0.5 * (Self::in_shell(Self::TANK) + Self::in_shell(3.0_f64.sqrt() * Self::TANK))
    }
}

impl Case for FallingSphere {
    fn name(&self) -> &'static str {
        "falling_sphere"
    }

    fn about(&self) -> &'static str {
        "sphere of twice water's density let go in still water: acceleration at the start, with its added mass"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("falling_sphere", 0.004), Member::new("falling_sphere", 0.0025)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let velocity = run.history("sphere_velocity_z_m_s")?;
        let (from, to) = (Self::RELEASE + Self::FIT.0, Self::RELEASE + Self::FIT.1);
        let (_, slope) = series::line(&series::window(&velocity, from, to));
        let volume = 4.0 / 3.0 * PI * Self::RADIUS.powi(3);
        let held = series::mean(&run.history("load_force_z_n")?, 0.5 * Self::RELEASE, Self::RELEASE - 1e-3);
        // The goal is asked for at 8 particles in the radius.
        let judged = run.member.spacing < 0.003;
        let sideways = series::at(&run.history("sphere_velocity_x_m_s")?, to)
            .hypot(series::at(&run.history("sphere_velocity_y_m_s")?, to));
        let mut figures = vec![
            judged_if(judged, Figure::compared("acceleration downward [m/s2]", -slope, Self::exact(), 0.05)),
            Figure::compared("buoyancy while held [N]", held, DENSITY * GRAVITY * volume, 0.01).report_only(),
            Figure::reported("speed sideways over that downward", sideways / series::at(&velocity, to).abs()),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("velocity", "t [s]", "velocity along z [m/s]");
        let end = Self::RELEASE + Self::FIT.1;
        plot.line("with added mass", vec![(Self::RELEASE, 0.0), (end, -Self::exact() * Self::FIT.1)]);
        for run in runs {
            plot.line(format!("{} m", run.member.spacing), run.history("sphere_velocity_z_m_s")?);
        }
        Ok(vec![plot])
    }
}

/// A block and a sphere of half the density of water that float freely.
pub struct Floating3d;

/// Schemes of [`Floating3d`].
const BLOCK: &str = "block";
const SPHERE: &str = "sphere";

impl Floating3d {
    /// Sides of the tank and of the block \[m\], and its height.
    const TANK: f64 = 0.24;
    const SIDE: f64 = 0.12;
    const HEIGHT: f64 = 0.08;
    /// Radius of the sphere \[m\].
    const RADIUS: f64 = 0.05;

    /// Volume \[m³\] of the part of the float of `scheme` below its draught \[m\].
    fn immersed(scheme: &str, draught: f64) -> f64 {
        if scheme == BLOCK {
            Self::SIDE * Self::SIDE * draught
        } else {
            PI * draught * draught * (Self::RADIUS - draught / 3.0)
        }
    }

    /// Draught \[m\] of a float whose lowest point is at `bottom` \[m\] in `water` \[m³\] of the tank: the water level is
    /// where water and immersed part fill the tank.
    fn draught(scheme: &str, bottom: f64, water: f64) -> f64 {
        let area = Self::TANK * Self::TANK;
        let lacks = |draught: f64| area * (bottom + draught) - Self::immersed(scheme, draught) - water;
        // It grows with the draught, as the tank is wider than the float.
        let (mut low, mut high) = (0.0, if scheme == BLOCK { Self::HEIGHT } else { 2.0 * Self::RADIUS });
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if lacks(middle) > 0.0 { high = middle } else { low = middle }
        }
        0.5 * (low + high)
    }
}

impl Case for Floating3d {
    fn name(&self) -> &'static str {
        "draught_3d"
    }

    fn about(&self) -> &'static str {
        "a block and a sphere, free to move and turn, settle at the draught of Archimedes"
    }

    fn members(&self) -> Vec<Member> {
        let sphere = |member: Member| {
            let mut shape = toml::Table::new();
            shape.insert("type".into(), "sphere".into());
            shape.insert("centre_m".into(), vec![0.12, 0.12, 0.105].into());
            shape.insert("radius_m".into(), Self::RADIUS.into());
            member.scheme(SPHERE).with("solid.body.0.shape", shape)
        };
        let block = |spacing: f64| Member::new("draught_3d", spacing).scheme(BLOCK);
        vec![block(0.01), block(0.005), sphere(block(0.01)), sphere(block(0.005))]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let scheme = run.member.scheme;
        let (half, draught, density) = if scheme == BLOCK {
            (0.5 * Self::HEIGHT, 0.5 * Self::HEIGHT, 500.0)
        } else {
            (Self::RADIUS, Self::RADIUS, 500.0)
        };
        let centre = run.history("float_centre_z_m")?;
        let end = centre.last().map_or(f64::NAN, |row| row.0);
        let water = series::at(&run.history("water_mass_kg")?, 0.0) / DENSITY;
        let found = Self::draught(scheme, series::mean(&centre, 0.9, end) - half, water);
        let late = series::window(&centre, 0.9, end);
        let span =
            series::largest(late.iter().map(|row| row.1)) + series::largest(late.iter().map(|row| -row.1));
        let weight = density * GRAVITY * 2.0 * Self::immersed(scheme, draught);
        let load = series::mean(&run.history("load_force_z_n")?, 0.9, end);
        let upright = 2.0 * series::mean(&run.history("float_quaternion_w")?, 0.9, end).abs().min(1.0).acos();
        let judged = run.member.spacing < 0.007;
        let mut figures = vec![
            judged_if(
                judged,
                Figure::compared("draught, mean over the last 0.3 s [m]", found, draught, 0.02),
            ),
            Figure::reported("span of the heave then, over the draught", span / draught),
            Figure::compared("force of the water over the weight", load / weight, 1.0, 0.02).report_only(),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        if scheme == BLOCK {
            // Half a degree.
            figures.push(Figure::judged("angle from upright [rad]", upright, Goal::AtMost(0.009)));
        }
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("height", "t [s]", "centre of the float [m]");
        for run in runs {
            plot.line(
                format!("{}, {} m", run.member.scheme, run.member.spacing),
                run.history("float_centre_z_m")?,
            );
        }
        Ok(vec![plot])
    }
}

/// A water column on a clamped elastic disc.
pub struct HydrostaticPlate3d;

impl HydrostaticPlate3d {
    const THICKNESS: f64 = 0.02;
    /// Deflection of the middle by finite elements in three dimensions \[m\].
    const DEFLECTION: f64 = 0.490_708_532e-3;
    /// Water over the disc: π R² H \[m³\].
    const WATER: f64 = PI * 0.01 * 0.2;
}

impl Case for HydrostaticPlate3d {
    fn name(&self) -> &'static str {
        "hydrostatic_plate_3d"
    }

    fn about(&self) -> &'static str {
        "water column on a clamped elastic disc: deflection against 3-D finite elements, load against the weight"
    }

    fn members(&self) -> Vec<Member> {
        // Water at twice the spacing of the disc.
        let across = |n: f64| {
            let spacing = Self::THICKNESS / n;
            Member::new("hydrostatic_plate_3d", 2.0 * spacing).with("solid.particle_spacing_m", spacing)
        };
        vec![across(4.0), across(6.0)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let late =
            |column: &str| -> Result<f64, String> { Ok(series::mean(&run.history(column)?, 0.4, 0.5)) };
        let judged = run.member.spacing < 0.007;
        let weight = DENSITY * GRAVITY * Self::WATER;
        let deflection = -late("middle_displacement_z_m")?;
        let load = -late("disc_force_z_n")?;
        let mut figures = vec![
            judged_if(
                judged,
                Figure::compared("deflection of the middle [m]", deflection, Self::DEFLECTION, 0.03),
            ),
            judged_if(judged, Figure::compared("force of the water on the disc [N]", load, weight, 0.01)),
            // 1962 Pa bend it in proportion.
            Figure::compared(
                "deflection over force [m/N]",
                deflection / load,
                Self::DEFLECTION / weight,
                0.03,
            )
            .report_only(),
            Figure::reported("force on the side along z over the weight", late("side_force_z_n")? / weight),
            Figure::compared(
                "weight of the water [N]",
                GRAVITY * series::at(&run.history("water_mass_kg")?, 0.0),
                weight,
                0.01,
            )
            .report_only(),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("deflection", "t [s]", "displacement of the middle [m]");
        for run in runs {
            plot.line(
                format!("water {:.2} mm", 1e3 * run.member.spacing),
                run.history("middle_displacement_z_m")?,
            );
        }
        Ok(vec![plot])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shells_and_draughts_have_their_known_values() {
        assert!((FallingSphere::in_shell(3.0) / GRAVITY - 0.390_977_444).abs() < 1e-9);
        assert!((FallingSphere::in_shell(8.0) / GRAVITY - 0.399_530_884).abs() < 1e-9);
        // A level of 0.1 m: the lowest point of each float is its draught below.
        for (scheme, draught) in [(BLOCK, 0.04), (SPHERE, 0.05)] {
            let water = 0.1 * Floating3d::TANK.powi(2) - Floating3d::immersed(scheme, draught);
            let found = Floating3d::draught(scheme, 0.1 - draught, water);
            assert!((found - draught).abs() < 1e-9, "{scheme} {found}");
        }
    }
}
