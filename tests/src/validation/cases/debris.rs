//! Floating debris on a bore against a plate: the impulse on the plate is what debris and water lose.
//!
//! Along x, from t₀ on:
//!
//! ```text
//! J_plate = −Δ(P_water + P_debris) + J_walls
//! ```
//! J_plate is what the plate passed on to its clamp and kept, J_walls what the tank's walls gave to water and debris, both
//! from the ledger; the momenta are sums over particles. What the stabilisers of the water add is left out: it must not
//! matter.

use super::floating::coupling;
use crate::validation::{Case, Figure, Goal, Member, Plot, Run, series};

/// See the module.
pub struct Debris;

/// The pieces.
const PIECES: [&str; 4] = ["board", "log", "wedge", "crate"];
/// Left face of the plate \[m\].
const PLATE: f64 = 0.46;

/// Sums over the run along x.
struct Sums {
    /// Impulse on the plate \[N s/m\].
    plate: Vec<(f64, f64)>,
    /// What debris and water have lost, and the walls have given \[N s/m\].
    lost: Vec<(f64, f64)>,
    /// Part of the stabilisers in the water's momentum \[N s/m\].
    stabilisers: Vec<(f64, f64)>,
}

fn sums(run: &Run) -> Result<Sums, String> {
    let impulse = |name: &str| run.ledger(&format!("{name}_impulse_x_n_s_per_m"));
    let clamp = impulse("solid_supports")?;
    let mut walls = impulse("fluid_walls")?;
    for (of_both, (_, of_solids)) in walls.iter_mut().zip(impulse("solid_wall_contact")?) {
        of_both.1 += of_solids;
    }
    let stabilisers = impulse("fluid_stabilisers")?;
    let water = run.history("water_momentum_x_kg_per_s")?;
    let solids = run.column("solids_momentum_x_kg_per_s")?;
    let plate = run.column("plate_momentum_x_kg_per_s")?;
    let (mut on_plate, mut lost) = (Vec::new(), Vec::new());
    for (((t, water), solids), plate) in water.into_iter().zip(solids).zip(plate) {
        on_plate.push((t, plate - series::at(&clamp, t)));
        lost.push((t, series::at(&walls, t) - (water + solids - plate)));
    }
    Ok(Sums { plate: on_plate, lost, stabilisers })
}

/// Gain of a history from `start` to `end` \[s\].
fn gain(history: &[(f64, f64)], start: f64, end: f64) -> f64 {
    series::at(history, end) - series::at(history, start)
}

impl Case for Debris {
    fn name(&self) -> &'static str {
        "debris"
    }

    fn about(&self) -> &'static str {
        "four floating pieces on a bore against a plate: impulse on the plate, closed books"
    }

    fn members(&self) -> Vec<Member> {
        vec![Member::new("debris", 0.004), Member::new("debris", 0.002)]
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let Sums { plate, lost, stabilisers } = sums(run)?;
        let times = run.column("t_s")?;
        let end = times[times.len() - 2];
        // The bore is there, when the tip has moved by a tenth of a millimetre; the debris follows.
        let arrival = series::first_reach(&run.history("tip_displacement_x_m")?, 1e-4);
        let struck: Vec<(f64, f64)> = run.history("struck_contact_bodies_x_n_per_m")?;
        let touch = struck.iter().find(|point| point.1 > 0.0).map_or(f64::NAN, |point| point.0);
        let spacing = run.member.spacing;
        let smallest = |name: &str| -> Result<f64, String> {
            Ok(run.column(name)?.into_iter().fold(f64::INFINITY, f64::min) / spacing)
        };
        let start = run.count("/fluid/counts/particles")? + run.count("/fluid/counts/outflow")? + run.lost();
        let immersed = series::largest(run.column("water_in_solids_immersed_count")?);
        let over = |window: (f64, f64)| gain(&plate, window.0, window.1) / gain(&lost, window.0, window.1);
        let blow = (touch - 0.02, touch + 0.1);
        let mut figures = vec![
            Figure::judged(
                "reached time [s]",
                times.last().copied().unwrap_or(f64::NAN),
                Goal::AtLeast(0.599),
            ),
            Figure::reported("bore at the plate [s]", arrival),
            Figure::reported("first piece at the plate [s]", touch),
            Figure::reported(
                "impulse on the plate from the bore's arrival on [N s/m]",
                gain(&plate, arrival, end),
            ),
            Figure::compared("the same over what debris and water lost", over((arrival, end)), 1.0, 0.01),
            Figure::reported(
                "impulse on the plate, 20 ms before to 100 ms after the first touch [N s/m]",
                gain(&plate, blow.0, blow.1),
            ),
            Figure::compared("the same over what debris and water lost then", over(blow), 1.0, 0.01),
            Figure::reported(
                "impulse of the stabilisers from the arrival on, over that on the plate",
                gain(&stabilisers, arrival, end) / gain(&plate, arrival, end),
            ),
            Figure::reported(
                "largest displacement of the tip [m]",
                series::largest(run.column("tip_displacement_x_m")?),
            ),
            Figure::judged(
                "closest pair of two bodies over spacing",
                smallest("closest_gap_body_m")?,
                Goal::AtLeast(0.5),
            ),
            Figure::judged(
                "closest pair of body and wall over spacing",
                smallest("closest_gap_wall_m")?,
                Goal::AtLeast(0.5),
            ),
            Figure::judged(
                "largest share of water inside solids [%]",
                100.0 * immersed / start,
                Goal::AtMost(0.2),
            ),
            Figure::judged("particles lost", run.lost(), Goal::AtMost(0.0)),
        ];
        for piece in PIECES {
            let x = series::largest(run.column(&format!("{piece}_centre_x_m"))?);
            figures.push(Figure::reported(
                format!("furthest centre of the {piece} before the plate [m]"),
                PLATE - x,
            ));
        }
        figures.extend(coupling(run));
        Ok(figures)
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut impulse = Plot::new("impulse", "t [s]", "impulse along x [N s/m]");
        let mut paths = Plot::new("paths", "x [m]", "y [m], centres of the pieces");
        for run in runs {
            let Sums { plate, lost, stabilisers } = sums(run)?;
            let start = lost.first().map_or(0.0, |point| point.1);
            impulse.line("on the plate", plate);
            impulse.line("lost by debris and water", lost.into_iter().map(|(t, j)| (t, j - start)).collect());
            impulse.line("stabilisers of the water", stabilisers);
            for piece in PIECES {
                let x = run.column(&format!("{piece}_centre_x_m"))?;
                let y = run.column(&format!("{piece}_centre_y_m"))?;
                paths.line(piece, x.into_iter().zip(y).collect());
            }
        }
        Ok(vec![impulse, paths])
    }
}
