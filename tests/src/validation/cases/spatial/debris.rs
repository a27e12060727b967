//! Case 5.2 in a tank of finite width, and as wide as the tank against the plane.

use super::common::judged_if;
use crate::validation::cases::floating::coupling;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct Debris3d;

/// Schemes of the pair that is compared with each other.
const PLANE: &str = "plane";
const PERIODIC: &str = "as wide as the tank";
/// Period of the latter along z, more than the 36 mm that contact needs, and middle plane of the tank \[m\].
const PERIOD: f64 = 0.04;
const MIDDLE: f64 = 0.06;
/// Depth of the water column \[m\].
const COLUMN: f64 = 0.292;
/// Time to which impulses are compared \[s\].
const UNTIL: f64 = 0.3;
/// Columns along x of the water's force on body and plate, without the unit.
const LOADS: [&str; 2] = ["body_load_force_x", "plate_load_force_x"];

impl Debris3d {
    /// The case with body and plate as wide as a tank that repeats along z, with the spacings of `drifting_body_coarse`.
    fn periodic() -> Member {
        let corners = |member: Member, at: &str, lower: [f64; 2], upper: [f64; 2]| {
            member
                .with(&format!("{at}.lower_m"), vec![lower[0], lower[1], 0.0])
                .with(&format!("{at}.upper_m"), vec![upper[0], upper[1], PERIOD])
        };
        let mut member = Member::new("../debris_3d", 0.004)
            .scheme(PERIODIC)
            .with("solid.particle_spacing_m", 0.004)
            .with("domain.upper_m", vec![0.584, 0.584, PERIOD])
            .with("domain.periodic", vec!["z"])
            .with("time.end_time_s", UNTIL + 0.01)
            .with("outputs.picture_times_s", vec![0.0, 0.1, 0.2, 0.25, 0.3])
            .with("solid.body.0.lattice_origin_m", vec![0.234, 0.008, 0.0])
            .with("solid.body.1.lattice_origin_m", vec![0.398, 0.0, 0.0])
            .with("probe.0.at_m", vec![0.404, 0.078, 0.5 * PERIOD]);
        for (at, lower, upper) in [
            ("fluid.region.0.shape", [0.0, 0.0], [0.146, COLUMN]),
            ("fluid.region.1.shape", [0.146, 0.0], [0.584, 0.008]),
            ("solid.body.0.shape", [0.234, 0.008], [0.270, 0.044]),
            ("solid.body.1.shape", [0.398, -0.012], [0.410, 0.080]),
            ("solid.body.1.support.0.shape", [0.398, -0.012], [0.410, 0.0]),
        ] {
            member = corners(member, at, lower, upper);
        }
        member
    }

    /// Impulse along x of the water on body and plate to [`UNTIL`] \[N s\], in the plane per metre.
    fn impulse(run: &Run) -> Result<f64, String> {
        let unit = if run.member.scheme == PLANE { "n_per_m" } else { "n" };
        let mut sum = 0.0;
        for load in LOADS {
            sum += UNTIL * series::mean(&run.history(&format!("{load}_{unit}"))?, 0.0, UNTIL);
        }
        Ok(sum)
    }
}

impl Case for Debris3d {
    fn name(&self) -> &'static str {
        "debris_3d"
    }

    fn about(&self) -> &'static str {
        "case 5.2 in a tank of finite width: symmetry, impulse at two spacings, and against the plane"
    }

    fn members(&self) -> Vec<Member> {
        vec![
            Member::new("../debris_3d_coarse", 0.008),
            Member::new("../debris_3d", 0.005),
            Member::new("../debris_3d", 0.004),
            Member::new("../drifting_body_coarse", 0.004)
                .scheme(PLANE)
                .with("time.end_time_s", UNTIL + 0.01)
                .with("outputs.picture_times_s", vec![0.0, 0.1, 0.2, 0.25, 0.3]),
            Self::periodic(),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let scheme = run.member.scheme;
        let name = format!(
            "impulse of the water along x to {UNTIL} s [N s{}]",
            if scheme == PLANE { "/m" } else { "" }
        );
        let mut figures = vec![
            Figure::reported(name, Self::impulse(run)?),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        if scheme != PLANE {
            let middle = if scheme == PERIODIC { 0.5 * PERIOD } else { MIDDLE };
            // The body reaches the plate between 0.18 and 0.26 s.
            let before = series::first_reach(&run.history("body_centre_x_m")?, 0.398 - 0.020);
            let until = if before.is_finite() { before } else { UNTIL };
            let off = |column: &str, at: f64| -> Result<f64, String> {
                let rows = series::window(&run.history(column)?, 0.0, until);
                Ok(series::largest(rows.iter().map(|row| (row.1 - at).abs())) / COLUMN)
            };
            figures.push(Figure::reported("body near the plate at [s]", before));
            figures.push(judged_if(
                scheme != PERIODIC,
                Figure::judged(
                    "body off the middle plane until then, over the height of the column",
                    off("body_centre_z_m", middle)?,
                    Goal::AtMost(0.01),
                ),
            ));
            figures.push(judged_if(
                scheme != PERIODIC,
                Figure::judged(
                    "water's centre off the middle plane until then, likewise",
                    off("water_centre_z_m", middle)?,
                    Goal::AtMost(0.01),
                ),
            ));
        }
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn comparison(&self, runs: &[Run]) -> Result<Vec<Figure>, String> {
        let of = |scheme: &str, spacing: f64| {
            runs.iter().find(|run| run.member.scheme == scheme && run.member.spacing == spacing)
        };
        let mut figures = Vec::new();
        if let Some(fine) = of("recommended", 0.004) {
            for spacing in [0.008, 0.005] {
                let Some(coarse) = of("recommended", spacing) else { continue };
                let name = format!("impulse at {} mm over that at 4 mm", 1e3 * spacing);
                figures.push(Figure::compared(name, Self::impulse(coarse)? / Self::impulse(fine)?, 1.0, 0.1));
            }
        }
        if let (Some(plane), Some(wide)) = (of(PLANE, 0.004), of(PERIODIC, 0.004)) {
            let name = "impulse as wide as the tank over that in the plane";
            figures.push(Figure::compared(
                name,
                Self::impulse(wide)? / PERIOD / Self::impulse(plane)?,
                1.0,
                0.05,
            ));
        }
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("path", "x [m]", "y [m], centre of the body");
        for run in runs {
            let path = run.column("body_centre_x_m")?.into_iter().zip(run.column("body_centre_y_m")?);
            plot.line(format!("{}, {} mm", run.member.scheme, 1e3 * run.member.spacing), path.collect());
        }
        Ok(vec![plot])
    }
}
