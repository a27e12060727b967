//! Error against CPU time, both logarithmic: one panel per case, as SVG for the page and as one PNG.

use plotters::coord::Shift;
use plotters::coord::combinators::LogCoord;
use plotters::prelude::*;

use super::Row;
use crate::results::font;
use crate::results::plots::PlotError;
use crate::results::plots::colour::LINES;

/// Size of a panel \[px\].
const PANEL: (u32, u32) = (620, 430);
/// Panels side by side in the PNG.
const COLUMNS: u32 = 2;
const INK: RGBColor = RGBColor(40, 44, 50);

/// The runs of one case, ready to be drawn.
pub struct Panel<'a> {
    /// Headline.
    pub title: &'a str,
    /// Names of schemes, in the order of their colours.
    pub schemes: Vec<&'static str>,
    /// Names of step policies, in the order of their marks.
    pub steps: Vec<&'static str>,
    /// The runs.
    pub rows: Vec<&'a Row>,
}

/// One panel as an SVG element; `None` when no run has an error to show.
///
/// # Errors
/// When the drawing library fails.
pub fn svg(panel: &Panel<'_>) -> Result<Option<String>, PlotError> {
    font::register();
    if panel.points().next().is_none() {
        return Ok(None);
    }
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, PANEL).into_drawing_area();
        area.fill(&WHITE).map_err(PlotError::new)?;
        panel.draw(&area)?;
        area.present().map_err(PlotError::new)?;
    }
    let start = svg.find("<svg").unwrap_or(0);
    let size = format!("width=\"{}\" height=\"{}\" ", PANEL.0, PANEL.1);
    Ok(Some(svg[start..].replacen(&size, "", 1)))
}

/// All panels as one picture: red, green and blue of each pixel, with its size.
///
/// # Errors
/// When the drawing library fails.
pub fn pixels(panels: &[Panel<'_>]) -> Result<(Vec<u8>, (u32, u32)), PlotError> {
    font::register();
    let drawn: Vec<&Panel<'_>> = panels.iter().filter(|panel| panel.points().next().is_some()).collect();
    // A study has a handful of cases.
    let rows = u32::try_from(drawn.len()).unwrap_or(u32::MAX).div_ceil(COLUMNS).max(1);
    let size = (PANEL.0 * COLUMNS, PANEL.1 * rows);
    let mut pixels = vec![255; 3 * size.0 as usize * size.1 as usize];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        area.fill(&WHITE).map_err(PlotError::new)?;
        for (place, panel) in area.split_evenly((rows as usize, COLUMNS as usize)).iter().zip(drawn) {
            panel.draw(place)?;
        }
        area.present().map_err(PlotError::new)?;
    }
    Ok((pixels, size))
}

impl Panel<'_> {
    /// Rows with cost \[s\] and error of those that can be shown.
    fn points(&self) -> impl Iterator<Item = (&Row, (f64, f64))> {
        let shown = |row: &&Row| row.measured.cpu_seconds > 0.0 && row.error() > 0.0;
        self.rows.iter().copied().filter(shown).map(|row| (row, (row.measured.cpu_seconds, row.error())))
    }

    fn range(&self, pick: fn((f64, f64)) -> f64) -> std::ops::Range<f64> {
        let values = || self.points().map(|(_, point)| pick(point));
        // At least a decade for the labels, and room for marks at the border.
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
        let middle = (low * high).sqrt();
        low.min(middle / 3.2) / 1.5..high.max(middle * 3.2) * 1.5
    }

    fn draw<'a, DB: DrawingBackend + 'a>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), PlotError> {
        let (x, mut y) = (self.range(|p| p.0), self.range(|p| p.1));
        // Room for the legend.
        y.end *= (y.end / y.start).powf(0.55);
        let mut chart = ChartBuilder::on(area)
            .margin(12)
            .caption(self.title, (font::FAMILY, 20))
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(x.log_scale(), y.log_scale())
            .map_err(PlotError::new)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(INK.mix(0.12))
            .x_desc("CPU time of the steps [s]")
            .y_desc("relative error")
            .x_label_formatter(&|x| decimal(*x))
            .y_label_formatter(&|y| percent(*y))
            .label_style((font::FAMILY, 14))
            .axis_desc_style((font::FAMILY, 15))
            .draw()
            .map_err(PlotError::new)?;
        let front = staircase(self.points().filter(|(row, _)| row.on_front).map(|(_, p)| p).collect());
        chart
            .draw_series(LineSeries::new(front, INK.mix(0.75).stroke_width(2)))
            .map_err(PlotError::new)?
            .label("Pareto front")
            .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 14, y)], INK.mix(0.75).stroke_width(2)));
        for (scheme, [r, g, b]) in self.schemes.iter().zip(LINES.into_iter().cycle()) {
            let colour = RGBColor(r, g, b);
            for (mark, step) in self.steps.iter().enumerate() {
                let rows = self.points().filter(|(row, _)| row.scheme == *scheme && row.step == *step);
                marks(&mut chart, rows.map(|(_, place)| place).collect(), colour, mark, None)?;
            }
            if self.points().any(|(row, _)| row.scheme == *scheme) {
                marks(&mut chart, Vec::new(), colour, 0, Some(scheme))?;
            }
        }
        for (mark, step) in self.steps.iter().enumerate() {
            if self.points().any(|(row, _)| row.step == *step) {
                marks(&mut chart, Vec::new(), INK, mark, Some(step))?;
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .label_font((font::FAMILY, 13))
            .background_style(WHITE.mix(0.85))
            .border_style(INK.mix(0.25))
            .draw()
            .map_err(PlotError::new)
    }
}

type LogChart<'a, DB> = ChartContext<'a, DB, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// Draws points as disks, rings or crosses, and their entry in the legend.
fn marks<'a, DB: DrawingBackend + 'a>(
    chart: &mut LogChart<'a, DB>,
    places: Vec<(f64, f64)>,
    colour: RGBColor,
    mark: usize,
    label: Option<&str>,
) -> Result<(), PlotError> {
    let places = places.into_iter();
    let (full, line) = (colour.filled(), colour.stroke_width(2));
    let drawn = match mark {
        0 => chart.draw_series(places.map(|p| Circle::new(p, 5, full))),
        1 => chart.draw_series(places.map(|p| Circle::new(p, 6, line))),
        _ => chart.draw_series(places.map(|p| Cross::new(p, 5, line))),
    };
    let drawn = drawn.map_err(PlotError::new)?;
    if let Some(label) = label {
        let entry = drawn.label(label);
        match mark {
            0 => entry.legend(move |(x, y)| Circle::new((x + 7, y), 5, full)),
            1 => entry.legend(move |(x, y)| Circle::new((x + 7, y), 6, line)),
            _ => entry.legend(move |(x, y)| Cross::new((x + 7, y), 5, line)),
        };
    }
    Ok(())
}

/// The smallest error that can be had for each cost, as corners of a line through the points of a front.
fn staircase(mut front: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let corners = front.windows(2).flat_map(|pair| [(pair[1].0, pair[0].1), pair[1]]);
    front.first().copied().into_iter().chain(corners).collect()
}

/// A mark of an axis, without the noise of its last bits.
fn decimal(value: f64) -> String {
    // The smallest marks that occur are thousandths.
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn percent(value: f64) -> String {
    format!("{} %", decimal(100.0 * value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_axes_are_short() {
        assert_eq!([0.2 + 0.1, 10.0, 0.001].map(decimal), ["0.3", "10", "0.001"]);
        assert_eq!(percent(0.02), "2 %");
    }

    #[test]
    fn the_front_is_a_staircase_of_what_can_be_had_for_a_cost() {
        assert_eq!(staircase(vec![(4.0, 1.0), (1.0, 3.0)]), [(1.0, 3.0), (4.0, 3.0), (4.0, 1.0)]);
    }
}
