//! A key figure against a key of the case, as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::overlay::page::short;
use crate::results::font;
use crate::results::plots::PlotError;
use crate::results::plots::colour::LINES;
use crate::results::plots::scale::padded_range;

/// Size of the drawing \[px\].
const SIZE: (u32, u32) = (620, 330);
const INK: RGBColor = RGBColor(40, 44, 50);

/// Ratio of the largest to the smallest value of a key from which its axis is logarithmic.
const WIDE: f64 = 20.0;

/// A finished run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Value of the key.
    pub x: f64,
    /// Key figure.
    pub y: f64,
}

/// `points` over `key`; `None` where they have fewer than two places on its axis.
///
/// # Errors
/// When the drawing library fails.
pub fn scatter(key: &str, points: &[Point]) -> Result<Option<String>, PlotError> {
    let (low, high) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| (low.min(point.x), high.max(point.x)));
    if low.total_cmp(&high).is_ge() {
        return Ok(None);
    }
    font::register();
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(PlotError::new)?;
        if low > 0.0 && high / low >= WIDE {
            let logarithms: Vec<Point> = points.iter().map(|p| Point { x: p.x.log10(), y: p.y }).collect();
            draw(&area, key, &logarithms, |x| format!("{:.1e}", 10f64.powf(x)))?;
        } else {
            draw(&area, key, points, mark)?;
        }
        area.present().map_err(PlotError::new)?;
    }
    let start = svg.find("<svg").unwrap_or(0);
    let size = format!("width=\"{}\" height=\"{}\" ", SIZE.0, SIZE.1);
    Ok(Some(svg[start..].replacen(&size, "", 1)))
}

/// A mark of an axis, without the noise of its last bits.
fn mark(value: f64) -> String {
    let text = short(value);
    match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn draw<'a, DB: DrawingBackend + 'a>(
    area: &DrawingArea<DB, Shift>,
    key: &str,
    points: &[Point],
    label: impl Fn(f64) -> String,
) -> Result<(), PlotError> {
    let x = padded_range(points.iter().map(|point| point.x));
    let y = padded_range(points.iter().map(|point| point.y));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .margin_right(24)
        .x_label_area_size(46)
        .y_label_area_size(80)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)
        .map_err(PlotError::new)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(INK.mix(0.12))
        .x_desc(key)
        .x_labels(6)
        .y_labels(6)
        .x_label_formatter(&|x| label(*x))
        .y_label_formatter(&|y| mark(*y))
        .label_style((font::FAMILY, 14))
        .axis_desc_style((font::FAMILY, 15))
        .draw()
        .map_err(PlotError::new)?;
    let [r, g, b] = LINES[0];
    let disks = points.iter().map(|point| Circle::new((point.x, point.y), 5, RGBColor(r, g, b).filled()));
    chart.draw_series(disks).map_err(PlotError::new)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_run_is_a_point_and_a_single_value_is_no_picture() {
        let at = |x, y| Point { x, y };
        let svg = scatter("a.e_pa", &[at(1e4, 2.0), at(1e5, 1.0), at(1e6, 0.5)]).unwrap().unwrap();
        assert_eq!(svg.matches("<circle").count(), 3);
        assert!(svg.contains("a.e_pa") && svg.contains("1.0e5"), "{svg}");
        assert_eq!(scatter("a", &[at(1.0, 2.0), at(1.0, 3.0)]).unwrap(), None);
        assert_eq!(scatter("a", &[]).unwrap(), None);
    }

    #[test]
    fn marks_are_short() {
        assert_eq!([0.25, 20.0, 3e7].map(mark), ["0.25", "20", "3.0000e7"]);
    }
}
