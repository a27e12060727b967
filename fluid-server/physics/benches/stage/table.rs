//! The machine, and the figures of the run as one table.

use std::path::Path;

use sph::space::{Plane, Spatial};

use super::scene;

/// Prints processor, cores and version.
pub fn machine() {
    let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = processor.lines().find_map(|line| line.strip_prefix("model name"));
    let model = model.map_or("unknown processor", |rest| rest.trim_start_matches([' ', '\t', ':']));
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    terminal::say(format_args!(
        "{model}, {cores} cores, arithmetic {}",
        sph::lanes::Arithmetic::chosen().name()
    ));
}

/// Prints the medians that criterion stored, per particle and over the fixed kernel's.
pub fn print() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../target");
    let target = std::env::var("CARGO_TARGET_DIR").unwrap_or_else(|_| beside.into());
    let folder = Path::new(&target).join("criterion");
    let median = |name: &str| -> Option<f64> {
        let text = std::fs::read_to_string(folder.join(name).join("new/estimates.json")).ok()?;
        let estimates: serde_json::Value = serde_json::from_str(&text).ok()?;
        estimates["median"]["point_estimate"].as_f64()
    };
    let Some(fixed) = median("fixed/kernel").map(|time| time / 4096.0) else { return };
    terminal::say(format_args!("\nCPU ns per particle-stage (times the {fixed:.2} ns of the fixed kernel)"));
    terminal::say(format_args!("{:28}{:>18}{:>18}{:>18}", "", "10k", "100k", "1M"));
    let (passes, builds) = (&super::PASSES[..], &super::BUILDS.map(|(name, ..)| name)[..]);
    let plane = super::BLOCKS.map(|(group, _)| (group, passes)).into_iter().chain([("build", builds)]);
    let space = super::CUBES.map(|(group, _)| (group, passes)).into_iter().chain([("space, build", builds)]);
    let of_plane =
        plane.map(|(group, passes)| (group, passes, scene::particles::<Plane> as fn(usize) -> usize));
    let of_space =
        space.map(|(group, passes)| (group, passes, scene::particles::<Spatial> as fn(usize) -> usize));
    for (group, passes, count) in of_plane.chain(of_space) {
        for pass in passes {
            let mut row = format!("{:28}", format!("{group} {pass}"));
            for particles in super::SIZES {
                match median(&format!("{group}/{pass}/{particles}")) {
                    Some(time) => {
                        // Two stages make a step.
                        let stages = if *pass == "stage" { 2.0 } else { 1.0 };
                        let time = time / (stages * count(particles) as f64);
                        row += &format!("{:>18}", format!("{time:.1} ({:.0})", time / fixed));
                    }
                    None => row += &format!("{:>18}", "-"),
                }
            }
            terminal::say(row);
        }
    }
    let whole = |k: usize| median(&format!("features/stage/{k}"));
    let Some(all) = whole(0) else { return };
    terminal::say(format_args!(
        "\nCPU time of a stage of {} particles at h/dx 1.3, over that of all recommended settings",
        super::FEATURE_PARTICLES
    ));
    for (k, (name, _)) in super::scene::FEATURES.iter().enumerate() {
        match whole(k) {
            Some(time) => terminal::say(format_args!("{name:24}{:>8.1} %", 100.0 * time / all)),
            None => terminal::say(format_args!("{name:24}{:>10}", "-")),
        }
    }
}
