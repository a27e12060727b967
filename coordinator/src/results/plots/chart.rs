//! Quantities over time as SVG for a page: axes and texts take the page's colour, legends are left to the page.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::PlotError;
use super::colour::LINES;
use super::scale::{Magnitude, label, padded_range, superscript, text_width, ticks};
use crate::results::font;

/// Size of the drawing \[px\]; shown at about half of it.
const SIZE: (u32, u32) = (1200, 520);
const TEXT: u32 = 34;
/// Room above, right of and below the plot \[px\].
const TOP: i32 = 56;
const RIGHT: i32 = 34;
const BOTTOM: i32 = 98;
/// Longest number of points drawn per line.
const POINTS: usize = 1200;
/// plotters writes this ink as `#000000`, which is replaced by the page's own.
const INK: RGBColor = BLACK;

/// Kind of the vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vertical {
    /// Linear.
    Linear,
    /// Logarithmic; zero and what is no number leave gaps.
    Logarithmic,
}

/// A line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// Values, one per time; NaN leaves a gap.
    pub values: Vec<f64>,
}

/// A chart of one or more lines over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart<'a> {
    /// Times \[s\].
    pub times: &'a [f64],
    /// Lines; colours follow [`LINES`].
    pub lines: Vec<Line>,
    /// SI unit of the values; empty without.
    pub unit: &'a str,
    /// Kind of the vertical axis.
    pub vertical: Vertical,
    /// A level to mark by a dashed line, such as a tolerance.
    pub level: Option<f64>,
}

impl Chart<'_> {
    /// The chart as an SVG element; `None` when there is no value to draw.
    ///
    /// # Errors
    /// When the drawing library fails.
    pub fn svg(&self) -> Result<Option<String>, PlotError> {
        font::register();
        let drawable = |value: &f64| value.is_finite() && (self.vertical == Vertical::Linear || *value > 0.0);
        if !self.lines.iter().any(|line| line.values.iter().any(drawable)) {
            return Ok(None);
        }
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            self.draw(&Axes::new(self), &area)?;
            area.present().map_err(PlotError::new)?;
        }
        // The page decides on light or dark, and on the width.
        let svg = svg.replace("#000000", "currentColor");
        let start = svg.find("<svg").unwrap_or(0);
        let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
        Ok(Some(svg[start..].replacen(&size, "", 1)))
    }

    fn draw<DB: DrawingBackend>(
        &self,
        axes: &Axes,
        area: &DrawingArea<DB, plotters::coord::Shift>,
    ) -> Result<(), PlotError> {
        axes.draw(area)?;
        if let Some(y) = self.level.map(|level| axes.y(level)).filter(|y| (TOP..=axes.bottom).contains(y)) {
            for x in (axes.left..axes.right).step_by(24) {
                let dash = vec![(x, y), ((x + 14).min(axes.right), y)];
                area.draw(&PathElement::new(dash, INK.mix(0.7).stroke_width(2))).map_err(PlotError::new)?;
            }
        }
        for (line, [r, g, b]) in self.lines.iter().zip(LINES.into_iter().cycle()) {
            let style = RGBColor(r, g, b).stroke_width(3);
            for run in runs(self.times, &line.values, self.vertical) {
                let points: Vec<(i32, i32)> =
                    run.iter().map(|(t, value)| (axes.x(*t), axes.y(*value))).collect();
                match points[..] {
                    [point] => area.draw(&Circle::new(point, 5, style.filled())),
                    _ => area.draw(&PathElement::new(points, style)),
                }
                .map_err(PlotError::new)?;
            }
        }
        Ok(())
    }
}

/// Unbroken runs of drawable points, thinned to the lowest and highest of each stretch.
fn runs(times: &[f64], values: &[f64], vertical: Vertical) -> Vec<Vec<(f64, f64)>> {
    let points: Vec<(f64, f64)> = times.iter().copied().zip(values.iter().copied()).collect();
    let stretch = points.len().div_ceil(POINTS / 2).max(1);
    let thinned = points.chunks(stretch).flat_map(|stretch| {
        if let [point] = stretch {
            return vec![*point];
        }
        let finite = || stretch.iter().enumerate().filter(|(_, point)| point.1.is_finite());
        let order = |a: &(usize, &(f64, f64)), b: &(usize, &(f64, f64))| a.1.1.total_cmp(&b.1.1);
        match (finite().min_by(order), finite().max_by(order)) {
            (Some(low), Some(high)) if low.0 < high.0 => vec![*low.1, *high.1],
            (Some(low), Some(high)) if low.0 > high.0 => vec![*high.1, *low.1],
            (Some(low), _) => vec![*low.1],
            _ => vec![(f64::NAN, f64::NAN)],
        }
    });
    let mut runs = vec![Vec::new()];
    for (t, value) in thinned {
        // Zero is common where nothing touches: it is no point of a logarithmic axis, but no end of a line either.
        if vertical == Vertical::Logarithmic && value == 0.0 {
            continue;
        }
        if t.is_finite() && value.is_finite() && (vertical == Vertical::Linear || value > 0.0) {
            if let Some(run) = runs.last_mut() {
                run.push((t, value));
            }
        } else {
            runs.push(Vec::new());
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// Where values are on the drawing.
struct Axes {
    left: i32,
    right: i32,
    bottom: i32,
    times: (f64, f64),
    /// Range of the values, or of their decimal logarithms.
    values: (f64, f64),
    vertical: Vertical,
    magnitude: Magnitude,
    /// Ticks of the vertical axis: value and label.
    marks: Vec<(f64, String)>,
}

impl Axes {
    fn new(chart: &Chart) -> Self {
        let all = || chart.lines.iter().flat_map(|line| line.values.iter().copied());
        let (first, last) = chart
            .times
            .iter()
            .filter(|t| t.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
        let times = if last > first { (first, last) } else { padded_range(chart.times.iter().copied()) };
        let (values, magnitude, marks) = match chart.vertical {
            Vertical::Linear => {
                let (lower, upper) = padded_range(all());
                let magnitude = Magnitude::of(lower.abs().max(upper.abs()), chart.unit);
                let (marks, step) = ticks(lower / magnitude.divisor, upper / magnitude.divisor, 6);
                let marks: Vec<_> =
                    marks.into_iter().map(|m| (m * magnitude.divisor, label(m, step))).collect();
                ((lower, upper), magnitude, marks)
            }
            Vertical::Logarithmic => {
                let positive = all().chain(chart.level).filter(|v| *v > 0.0 && v.is_finite());
                let decades =
                    positive.map(f64::log10).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| {
                        (a.min(d.floor()), b.max(d.ceil()))
                    });
                let (lower, upper) =
                    if decades.0 < decades.1 { decades } else { (decades.0 - 1.0, decades.0 + 1.0) };
                // Decades of finite f64 lie within ±324.
                let (lower, upper) = (lower as i32, upper as i32);
                let step = usize::try_from((upper - lower + 5) / 6).unwrap_or(1).max(1);
                let marks = (lower..=upper)
                    .rev()
                    .step_by(step)
                    .map(|decade| (10f64.powi(decade), format!("10{}", superscript(decade))))
                    .collect();
                let magnitude = Magnitude { divisor: 1.0, unit: chart.unit.to_string() };
                ((f64::from(lower), f64::from(upper)), magnitude, marks)
            }
        };
        let widest =
            marks.iter().map(|(_, label): &(f64, String)| text_width(label, TEXT)).max().unwrap_or(0);
        Self {
            // Label widths are a few hundred pixels at most; other fonts of a page may be a little wider.
            left: 34 + (f64::from(widest) * 1.06) as i32,
            right: SIZE.0 as i32 - RIGHT,
            bottom: SIZE.1 as i32 - BOTTOM,
            times,
            values,
            vertical: chart.vertical,
            magnitude,
            marks,
        }
    }

    fn x(&self, time: f64) -> i32 {
        let share = (time - self.times.0) / (self.times.1 - self.times.0);
        self.left + (share * f64::from(self.right - self.left)).round() as i32
    }

    fn y(&self, value: f64) -> i32 {
        let value = if self.vertical == Vertical::Logarithmic { value.log10() } else { value };
        let share = (value - self.values.0) / (self.values.1 - self.values.0);
        self.bottom - (share * f64::from(self.bottom - TOP)).round() as i32
    }

    fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, plotters::coord::Shift>,
    ) -> Result<(), PlotError> {
        let grid = |points: Vec<(i32, i32)>| PathElement::new(points, INK.mix(0.15).stroke_width(2));
        let axis = |points: Vec<(i32, i32)>| PathElement::new(points, INK.mix(0.6).stroke_width(2));
        let style = |horizontal, vertical| {
            TextStyle::from((font::FAMILY, TEXT).into_font()).color(&INK).pos(Pos::new(horizontal, vertical))
        };
        let (below, beside) = (style(HPos::Center, VPos::Top), style(HPos::Right, VPos::Center));
        for (value, label) in &self.marks {
            let y = self.y(*value);
            area.draw(&grid(vec![(self.left, y), (self.right, y)])).map_err(PlotError::new)?;
            let place = (self.left - 14, y);
            area.draw(&Text::new(label.clone(), place, beside.clone())).map_err(PlotError::new)?;
        }
        let (marks, step) = ticks(self.times.0, self.times.1, 6);
        for mark in marks {
            let x = self.x(mark);
            area.draw(&axis(vec![(x, self.bottom), (x, self.bottom + 10)])).map_err(PlotError::new)?;
            let place = (x, self.bottom + 16);
            area.draw(&Text::new(label(mark, step), place, below.clone())).map_err(PlotError::new)?;
        }
        area.draw(&axis(vec![(self.left, TOP), (self.left, self.bottom), (self.right, self.bottom)]))
            .map_err(PlotError::new)?;
        let place = (self.right, SIZE.1 as i32 - 40);
        area.draw(&Text::new("t [s]", place, style(HPos::Right, VPos::Top))).map_err(PlotError::new)?;
        if self.magnitude.unit.is_empty() {
            return Ok(());
        }
        let unit = format!("[{}]", self.magnitude.unit);
        area.draw(&Text::new(unit, (8, 6), style(HPos::Left, VPos::Top))).map_err(PlotError::new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart<'a>(times: &'a [f64], values: &[f64], vertical: Vertical) -> Chart<'a> {
        let lines = vec![Line { name: "a".into(), values: values.to_vec() }];
        Chart { times, lines, unit: "Pa", vertical, level: None }
    }

    #[test]
    fn gaps_break_a_line_and_lone_points_stay_visible() {
        let times: Vec<f64> = (0..7).map(f64::from).collect();
        let values = [1.0, 2.0, f64::NAN, 3.0, f64::NAN, 4.0, 5.0];
        let runs = runs(&times, &values, Vertical::Linear);
        assert_eq!(runs.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1, 2]);
        let svg = chart(&times, &values, Vertical::Linear).svg().unwrap().unwrap();
        assert_eq!(svg.matches("<circle").count(), 1);
        assert!(svg.starts_with("<svg") && svg.contains("currentColor") && svg.contains("[Pa]"));
    }

    #[test]
    fn thinning_keeps_every_peak() {
        let times: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut values = vec![0.0; times.len()];
        (values[54_321], values[77_777]) = (9.0, -8.0);
        let runs = runs(&times, &values, Vertical::Linear);
        assert!(runs[0].len() <= POINTS + 2);
        assert!(runs[0].contains(&(54_321.0, 9.0)) && runs[0].contains(&(77_777.0, -8.0)));
    }

    #[test]
    fn a_logarithmic_axis_passes_over_zeros_and_marks_the_level() {
        let times: Vec<f64> = (0..4).map(f64::from).collect();
        let mut chart = chart(&times, &[0.0, 1e-16, 0.0, 3e-15], Vertical::Logarithmic);
        chart.level = Some(1e-12);
        let svg = chart.svg().unwrap().unwrap();
        assert!(svg.contains("10⁻¹²") && svg.contains("10⁻¹⁶"), "{svg}");
        assert_eq!(runs(&times, &chart.lines[0].values, Vertical::Logarithmic)[0].len(), 2);
        chart.lines[0].values = vec![0.0; 4];
        assert_eq!(chart.svg().unwrap(), None);
    }

    #[test]
    fn higher_values_are_drawn_higher() {
        let times = [0.0, 1.0];
        let axes = Axes::new(&chart(&times, &[-2e5, 7e5], Vertical::Linear));
        assert!(axes.y(7e5) < axes.y(-2e5) && axes.y(7e5) >= TOP && axes.y(-2e5) <= axes.bottom);
        assert_eq!(axes.magnitude.unit, "kPa");
        assert_eq!((axes.x(0.0), axes.x(1.0)), (axes.left, axes.right));
    }

    #[test]
    fn one_row_or_none_is_no_failure() {
        assert!(chart(&[0.0], &[5.0], Vertical::Linear).svg().unwrap().is_some());
        assert!(chart(&[], &[], Vertical::Linear).svg().unwrap().is_none());
        assert!(chart(&[0.0], &[f64::NAN], Vertical::Linear).svg().unwrap().is_none());
    }
}
