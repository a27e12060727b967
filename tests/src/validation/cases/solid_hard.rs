//! Solids that are hard to survive: nearly incompressible, thin, light, very stiff.

use std::f64::consts::TAU;

use super::beams::{cost, energy_ratio};
use crate::validation::{Case, Figure, Goal, Member, Run, series};

/// See the module.
pub struct SolidHard;

/// Thin-plate period of the cantilever over that of K = 3.25 MPa, G = 0.715 MPa, ρ = 1000 kg/m³ (finite elements
/// 0.2551 s): ω² ~ E/((1 − ν²) ρ).
fn period(young: f64, poisson: f64, density: f64) -> f64 {
    let gray: f64 = 1.998e6 / (1.0 - 0.3975 * 0.3975) / 1000.0;
    0.2551 * (gray * (1.0 - poisson * poisson) * density / young).sqrt()
}

/// Young's modulus \[Pa\], Poisson's ratio and density \[kg/m³\] of a scheme, and particles across.
fn material(scheme: &str) -> (f64, f64, f64) {
    match scheme {
        "nu = 0.49" => (2e6, 0.49, 1000.0),
        "steel" => (210e9, 0.3, 7800.0),
        "a tenth of water" => (2e6, 0.4, 100.0),
        _ => (1.998e6, 0.3975, 1000.0),
    }
}

impl Case for SolidHard {
    fn name(&self) -> &'static str {
        "solid_hard"
    }

    fn about(&self) -> &'static str {
        "four periods of a cantilever that is nearly incompressible, two or three particles thick, light, or of steel"
    }

    fn members(&self) -> Vec<Member> {
        let member = |scheme: &'static str, file, spacing| {
            let (young, poisson, density) = material(scheme);
            let mut table = toml::Table::new();
            table.insert("density_kg_m3".into(), density.into());
            table.insert("young_modulus_pa".into(), young.into());
            table.insert("poisson_ratio".into(), poisson.into());
            let time = 4.3 * period(young, poisson, density);
            let lower: toml::Value = vec![-4.0 * spacing, -0.01].into();
            Member::solid(file, spacing)
                .scheme(scheme)
                .with("solid.body.0.material", table)
                .with("solid.body.0.shape.lower_m", lower.clone())
                .with("solid.body.0.support.0.shape.lower_m", lower)
                .with("solid.substeps", "auto")
                .with("time.end_time_s", time)
                .with("time.step.time_step_s", time / 8000.0)
                .with("outputs.probe_interval_s", time / 2000.0)
                .with("outputs.snapshot_interval_s", time / 4.0)
        };
        vec![
            member("two across", "cantilever_4", 0.01).quick(),
            member("three across", "cantilever_4", 0.006_666_666_667),
            member("nu = 0.49", "cantilever_6", 0.003333333333),
            member("a tenth of water", "cantilever_6", 0.003333333333),
            member("steel", "cantilever_6", 0.003333333333),
        ]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let (young, poisson, density) = material(run.member.scheme);
        let expected = period(young, poisson, density);
        let tip = run.history("tip_displacement_y_m")?;
        let (_, rate, omega) = series::damped_oscillation(&tip, (0.0, TAU / series::mean_period(&tip)));
        let end = tip.last().map_or(f64::NAN, |(t, _)| *t);
        Ok(vec![
            Figure::judged("periods run", end / expected, Goal::AtLeast(4.0)),
            Figure::compared("period [s]", TAU / omega, expected, 0.0).report_only(),
            Figure::reported("loss of amplitude per period", 1.0 - (-rate * TAU / omega).exp()),
            Figure::judged(
                "rise of energy over the start",
                energy_ratio(run, "plate")? - 1.0,
                Goal::AtMost(0.01),
            ),
            cost(run)?,
        ])
    }
}
