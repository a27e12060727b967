//! One plot per comparison, as SVG.

use std::path::Path;

use coordinator::results::font;
use plotters::prelude::*;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Connected.
    Line,
    /// Dots, for measurements and exact values.
    Points,
}

/// One series of a plot.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

/// A plot of series over one abscissa.
#[derive(Clone, Debug)]
pub struct Plot {
    /// File name without ending, after that of the case.
    pub name: String,
    /// Label of the abscissa with its unit.
    pub x: String,
    /// Label of the ordinate with its unit.
    pub y: String,
    /// What is drawn.
    pub series: Vec<Series>,
}

impl Plot {
    /// An empty plot.
    pub fn new(name: &str, x: &str, y: &str) -> Self {
        Self { name: name.into(), x: x.into(), y: y.into(), series: Vec::new() }
    }

    /// Adds a connected series.
    pub fn line(&mut self, name: impl Into<String>, points: Vec<(f64, f64)>) {
        self.series.push(Series { name: name.into(), mark: Mark::Line, points });
    }

    /// Adds dots.
    pub fn points(&mut self, name: impl Into<String>, points: Vec<(f64, f64)>) {
        self.series.push(Series { name: name.into(), mark: Mark::Points, points });
    }

    /// Writes the plot; nothing where there is nothing to draw.
    ///
    /// # Errors
    /// When it cannot be drawn or written.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        font::register();
        let points = || self.series.iter().flat_map(|series| &series.points);
        let finite = || points().filter(|p| p.0.is_finite() && p.1.is_finite());
        let range = |pick: fn(&(f64, f64)) -> f64| {
            let low = finite().map(pick).fold(f64::INFINITY, f64::min);
            let high = finite().map(pick).fold(f64::NEG_INFINITY, f64::max);
            let pad = if high > low { 0.04 * (high - low) } else { 0.5 };
            low - pad..high + pad
        };
        if finite().next().is_none() {
            return Ok(());
        }
        self.draw(path, range(|p| p.0), range(|p| p.1))
            .map_err(|e| format!("`{}` cannot be drawn: {e}", path.display()))
    }

    fn draw(
        &self,
        path: &Path,
        x: std::ops::Range<f64>,
        y: std::ops::Range<f64>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let area = SVGBackend::new(path, (900, 560)).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .margin(14)
            .x_label_area_size(48)
            .y_label_area_size(84)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_desc(&self.x)
            .y_desc(&self.y)
            .label_style((font::FAMILY, 15))
            .axis_desc_style((font::FAMILY, 17))
            .draw()?;
        for (k, Series { name, mark, points }) in self.series.iter().enumerate() {
            let colour = Palette99::pick(k).to_rgba();
            let finite = points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite());
            let drawn = match mark {
                Mark::Line => chart.draw_series(LineSeries::new(finite, colour.stroke_width(2)))?,
                Mark::Points => chart.draw_series(finite.map(|p| Circle::new(p, 4, colour.filled())))?,
            };
            drawn
                .label(name)
                .legend(move |(x, y)| Rectangle::new([(x, y - 3), (x + 16, y + 3)], colour.filled()));
        }
        chart
            .configure_series_labels()
            .label_font((font::FAMILY, 15))
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        area.present()?;
        Ok(())
    }
}
