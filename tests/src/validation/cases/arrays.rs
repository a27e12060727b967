//! Slow flow through arrays of cylinders and spheres: the force on a curved face without slip.

use std::f64::consts::PI;

use crate::validation::{Case, Figure, Member, Plot, Run};

/// An array of obstacles, one of them in a periodic cell of 1 m, through which a body force of 1 m/s² drives water.
pub struct Array {
    name: &'static str,
    about: &'static str,
    /// Case files of the obstacle as a wall and as a body.
    files: [&'static str; 2],
    spacings: &'static [f64],
    /// Share of the cell that the obstacle fills.
    filled: f64,
    /// ℓ \[-\], in space \[m\], of the reference force μUℓ, U the mean velocity over the cell, from the share `filled`.
    reference: fn(f64) -> f64,
    /// Force on an obstacle over the reference force.
    drag: f64,
    /// Error that the finest member may have.
    tolerance: f64,
}

/// Square array of cylinders; the value of Sangani & Acrivos (1982) for c = 0.2.
pub const CYLINDERS: Array = Array {
    name: "cylinder_array",
    about: "slow flow through a square array of cylinders against the drag of Sangani & Acrivos; wall and body",
    files: ["cylinder_array", "cylinder_array_body"],
    spacings: &[0.05, 0.025, 0.0125],
    filled: 0.2,
    reference: |_| 1.0,
    drag: 51.53,
    // The drag grows as the 2.4th power of the radius: the face is right to 0.08 of a spacing.
    tolerance: 0.01,
};

/// Simple cubic array of spheres; the value of Zick & Homsy (1982) for c = 0.125.
pub const SPHERES: Array = Array {
    name: "sphere_array",
    about: "slow flow through a cubic array of spheres against the drag of Zick & Homsy; wall and body",
    files: ["sphere_array", "sphere_array_body"],
    spacings: &[0.05, 0.03125],
    filled: 0.125,
    // 6πR.
    reference: |filled| 6.0 * PI * (3.0 * filled / (4.0 * PI)).cbrt(),
    drag: 4.292,
    // The drag grows as the third power of the radius: the face is right to 0.17 of a spacing.
    tolerance: 0.05,
};

impl Array {
    /// Times \[s\] and drag coefficients, from the momentum of the water.
    fn drags(&self, run: &Run) -> Result<Vec<(f64, f64)>, String> {
        let reference = run.number("fluid.dynamic_viscosity_pa_s")? * (self.reference)(self.filled);
        let mass = run.column("water_mass_kg_per_m").or_else(|_| run.column("water_mass_kg"))?;
        let momentum = run
            .history("water_momentum_x_kg_per_s")
            .or_else(|_| run.history("water_momentum_x_kg_m_per_s"))?;
        let drag = |((t, momentum), mass): ((f64, f64), f64)| {
            // Of water that fills the whole cell: a body force on obstacles too is a pressure gradient in the water.
            let density = mass / (1.0 - self.filled);
            (t, density / (reference * momentum / density))
        };
        // At the start the water is at rest.
        Ok(momentum.into_iter().zip(mass).map(drag).filter(|(_, drag)| drag.is_finite()).collect())
    }
}

impl Case for Array {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> &'static str {
        self.about
    }

    fn members(&self) -> Vec<Member> {
        let walls = self.spacings.iter().map(|spacing| Member::new(self.files[0], *spacing));
        let bodies = self.spacings.iter().map(|spacing| {
            Member::new(self.files[1], *spacing).with("solid.particle_spacing_m", *spacing).scheme("a body")
        });
        walls.chain(bodies).collect()
    }

    fn figures(&self, run: &Run) -> Result<Vec<Figure>, String> {
        let drags = self.drags(run)?;
        let (_, last) = drags.last().ok_or("the water has not moved")?;
        let change = |before: &(f64, f64)| last / before.1 - 1.0;
        let settled = drags.iter().rev().nth(4).map_or(f64::NAN, change);
        let finest = self.spacings.iter().copied().fold(f64::INFINITY, f64::min);
        let figure = Figure::compared("drag coefficient at the end", *last, self.drag, self.tolerance);
        Ok(vec![
            if run.member.spacing > finest { figure.report_only() } else { figure },
            Figure::reported("its change in the last 0.2 s", settled),
        ])
    }

    fn plots(&self, runs: &[Run]) -> Result<Vec<Plot>, String> {
        let mut plot = Plot::new("drag", "t [s]", "drag coefficient [-]");
        for run in runs {
            let mut drags = self.drags(run)?;
            // The start, where water has hardly moved, would hide the rest.
            drags.retain(|(_, drag)| *drag < 2.0 * self.drag);
            plot.line(format!("{} {} m", run.member.scheme, run.member.spacing), drags);
        }
        plot.line("reference", vec![(0.0, self.drag), (2.0, self.drag)]);
        Ok(vec![plot])
    }
}
