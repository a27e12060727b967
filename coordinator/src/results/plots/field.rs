//! Particle fields as PNG: equal axes, one colour bar, every particle as large as the matter it stands for.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use sph::coupling::solver::ParticleFields;
use sph::space::AXIS_NAMES;

use super::PlotError;
use super::colour::{ColourScale, Rgb};
use super::projection::{Place, Projection};
use super::scale::{Magnitude, label, text_width, ticks};
use crate::results::font;

/// Longest edge of the drawn region \[px\]; pictures are shown at about half of it, so that they stay crisp.
const LONGEST: f64 = 960.0;
/// Least width and height of the drawn region \[px\]: labels along x need room side by side.
const SHORTEST: [f64; 2] = [270.0, 150.0];
/// Least width of the drawn region's frame, so that title and colour bar have room \[px\].
const LEAST_WIDTH: u32 = 560;
/// Text sizes \[px\].
const TITLE: u32 = 36;
const TEXT: u32 = 29;
/// plotters centres texts by their line height, which leaves digits a little high \[px\].
const LOWER: i32 = 4;
/// Least distance of two labels side by side \[px\].
const GAP: i32 = 16;
/// Ink of frames and texts.
const INK: RGBColor = RGBColor(34, 34, 34);
/// Particles reach a little beyond their own square, so that strained matter shows no gaps.
const REACH: f64 = 0.8;
/// Light at the rim of a ball over that at its middle.
const DARKEST: f64 = 0.55;

/// A particle to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Position \[m\].
    pub position: [f64; 2],
    /// How near it is to the viewer \[m\]; of a view from outside only.
    pub nearness: f64,
    /// Particle spacing \[m\].
    pub spacing: f64,
    /// Colour.
    pub colour: Rgb,
}

/// What a picture shows, but for its particles.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// Title above it.
    pub title: &'a str,
    /// Part of the scene.
    pub view: View,
    /// How the scene is looked at.
    pub projection: Projection,
    /// The colour bar.
    pub scale: &'a ColourScale,
}

/// The part of the scene that a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Lower corner \[m\].
    pub lower: [f64; 2],
    /// Upper corner \[m\].
    pub upper: [f64; 2],
}

impl View {
    /// The smallest view that holds all finite `positions`, widened by `margin` \[m\] on each side.
    pub fn around(positions: impl Iterator<Item = [f64; 2]>, margin: f64) -> Option<Self> {
        let finite = positions.filter(|x| x.iter().all(|c| c.is_finite()));
        let bounds = finite.fold(None, |bounds: Option<View>, x| {
            let b = bounds.unwrap_or(View { lower: x, upper: x });
            Some(View {
                lower: [b.lower[0].min(x[0]), b.lower[1].min(x[1])],
                upper: [b.upper[0].max(x[0]), b.upper[1].max(x[1])],
            })
        })?;
        let margin = if margin > 0.0 { margin } else { 1e-9 };
        Some(View { lower: bounds.lower.map(|c| c - margin), upper: bounds.upper.map(|c| c + margin) })
    }

    fn size(&self, axis: usize) -> f64 {
        self.upper[axis] - self.lower[axis]
    }

    /// This view with its shorter edge widened so far that it can be drawn with [`SHORTEST`] edges.
    fn drawable(mut self) -> Self {
        let longest = self.size(0).max(self.size(1));
        for (axis, shortest) in SHORTEST.into_iter().enumerate() {
            let missing = 0.5 * (shortest / LONGEST * longest - self.size(axis)).max(0.0);
            self.lower[axis] -= missing;
            self.upper[axis] += missing;
        }
        self
    }
}

/// Positions of all particles \[m\]; empty without a `position` of at least two components.
pub fn positions(particles: &ParticleFields) -> impl Iterator<Item = Place> + '_ {
    let field = particles.field("position").filter(|field| field.components >= 2);
    let place = |x: &[f64]| [x[0], x[1], x.get(2).copied().unwrap_or(0.0)];
    field.into_iter().flat_map(move |field| field.values.chunks(field.components).map(place))
}

/// Whether `particles` have positions in space.
pub fn is_in_space(particles: &ParticleFields) -> bool {
    particles.field("position").is_some_and(|field| field.components > 2)
}

/// Distance between neighbouring particles \[m\].
///
/// The edge √(m/ρ), in space ∛(m/ρ), of the median particle; without `mass` and `density` the edge of an even share of the
/// area or volume.
pub fn spacing(particles: &ParticleFields) -> Option<f64> {
    let in_space = is_in_space(particles);
    let edge = |volume: f64| if in_space { volume.cbrt() } else { volume.sqrt() };
    let (mass, density) = (particles.field("mass"), particles.field("density"));
    let mut edges: Vec<f64> = match (mass, density) {
        (Some(mass), Some(density)) => {
            mass.values.iter().zip(&density.values).map(|(m, rho)| edge(m / rho)).collect()
        }
        _ => Vec::new(),
    };
    edges.retain(|edge| *edge > 0.0);
    super::scale::quantile(&mut edges, 0.5).or_else(|| {
        let size = |axis: usize| {
            let along = || positions(particles).map(|x| x[axis]).filter(|x| x.is_finite());
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let count = positions(particles).count() as f64;
        let axes = if in_space { 3 } else { 2 };
        (count > 0.0).then(|| edge((0..axes).map(size).product::<f64>() / count))
    })
}

/// The `dots` on `sheet`, as PNG.
///
/// # Errors
/// When the drawing library fails.
pub fn draw(sheet: &Sheet<'_>, dots: &[Dot]) -> Result<Vec<u8>, PlotError> {
    font::register();
    let &Sheet { title, view, projection, scale } = sheet;
    let layout = Layout::new(view);
    let (width, height) = layout.canvas;
    let mut pixels = vec![255u8; 3 * width as usize * height as usize];
    layout.paint(&mut pixels, dots, projection.is_from_outside());
    {
        let area = BitMapBackend::with_buffer(&mut pixels, layout.canvas).into_drawing_area();
        layout.axes(&area, [projection.right, projection.upward].map(|axis| AXIS_NAMES[axis]))?;
        layout.colour_bar(&area, title, scale)?;
        area.present().map_err(PlotError::new)?;
    }
    encode(&pixels, layout.canvas)
}

/// Where things are on the canvas \[px\].
struct Layout {
    view: View,
    /// Pixels per metre.
    zoom: f64,
    canvas: (u32, u32),
    /// Left and top of the drawn region.
    origin: (u32, u32),
    /// Size of the drawn region.
    plot: (u32, u32),
    /// Left and width of title and colour bar.
    head: (u32, u32),
}

/// Vertical places of the head \[px\].
const HEAD_TEXT: i32 = 34;
const BAR_TOP: i32 = 62;
const BAR_BOTTOM: i32 = 86;
const HEAD_HEIGHT: u32 = 146;
/// Room for labels left and right of, and below, the drawn region \[px\].
const LEFT: u32 = 148;
const RIGHT: u32 = 44;
const BOTTOM: u32 = 92;

impl Layout {
    fn new(view: View) -> Self {
        let view = view.drawable();
        let zoom = LONGEST / view.size(0).max(view.size(1));
        // Between SHORTEST and LONGEST by construction.
        let plot = (0..2).map(|axis| (view.size(axis) * zoom).round() as u32).collect::<Vec<_>>();
        let plot = (plot[0].max(1), plot[1].max(1));
        let head_width = plot.0.max(LEAST_WIDTH);
        Self {
            view,
            zoom,
            canvas: (LEFT + head_width + RIGHT, HEAD_HEIGHT + plot.1 + BOTTOM),
            origin: (LEFT + (head_width - plot.0) / 2, HEAD_HEIGHT),
            plot,
            head: (LEFT, head_width),
        }
    }

    /// Place of `position` \[m\] in the drawn region \[px\], y downward.
    fn place(&self, position: [f64; 2]) -> (f64, f64) {
        ((position[0] - self.view.lower[0]) * self.zoom, (self.view.upper[1] - position[1]) * self.zoom)
    }

    /// Gives every pixel within reach of a particle its colour: that of the nearest one in the picture, or, `from_outside`,
    /// that of the ball nearest to the viewer, shaded as if lit from there.
    fn paint(&self, pixels: &mut [u8], dots: &[Dot], from_outside: bool) {
        let (width, height) = (self.plot.0 as usize, self.plot.1 as usize);
        let stride = self.canvas.0 as usize;
        // Of what is there so far: squared distance in units of its reach, or how far it is from the viewer.
        let mut best = vec![if from_outside { f64::INFINITY } else { 1.0 }; width * height];
        for dot in dots {
            let (x, y) = self.place(dot.position);
            // A particle is never smaller than what the eye can find.
            let reach = (REACH * dot.spacing * self.zoom).max(1.5);
            let span = |centre: f64, size: usize| {
                // A cast of what is no number gives 0, and the distance test below then fails.
                let first = (centre - reach).floor().max(0.0) as usize;
                let last = (centre + reach).ceil().max(0.0) as usize;
                first..last.min(size)
            };
            for row in span(y, height) {
                for column in span(x, width) {
                    let (dx, dy) = (column as f64 + 0.5 - x, row as f64 + 0.5 - y);
                    let distance = (dx * dx + dy * dy) / (reach * reach);
                    let bulge = (1.0 - distance).max(0.0).sqrt();
                    let order = match from_outside {
                        true if distance < 1.0 => -dot.nearness - bulge * reach / self.zoom,
                        true => f64::INFINITY,
                        false => distance,
                    };
                    let at = row * width + column;
                    if order < best[at] {
                        best[at] = order;
                        let (left, top) = (self.origin.0 as usize, self.origin.1 as usize);
                        let pixel = 3 * ((top + row) * stride + left + column);
                        let light = if from_outside { DARKEST + (1.0 - DARKEST) * bulge } else { 1.0 };
                        let colour = dot.colour.map(|c| (f64::from(c) * light).round() as u8);
                        pixels[pixel..pixel + 3].copy_from_slice(&colour);
                    }
                }
            }
        }
    }

    fn axes<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, plotters::coord::Shift>,
        [right_name, upward_name]: [&str; 2],
    ) -> Result<(), PlotError> {
        let (left, top) = (self.origin.0 as i32, self.origin.1 as i32);
        let (right, bottom) = (left + self.plot.0 as i32, top + self.plot.1 as i32);
        let line = |points: Vec<(i32, i32)>| PathElement::new(points, INK.stroke_width(2));
        let frame = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        area.draw(&line(frame)).map_err(PlotError::new)?;
        let wanted = |pixels: u32| (pixels as usize / 130).clamp(2, 7);
        let below = text(HPos::Center, VPos::Top, TEXT);
        let (marks, step) = ticks(self.view.lower[0], self.view.upper[0], wanted(self.plot.0));
        let mut free_from = i32::MIN;
        for mark in marks {
            let x = left + self.place([mark, 0.0]).0.round() as i32;
            area.draw(&line(vec![(x, bottom), (x, bottom + 8)])).map_err(PlotError::new)?;
            let label = label(mark, step);
            let half = text_width(&label, TEXT) as i32 / 2;
            // In a narrow picture every second label or so fits.
            if x - half >= free_from {
                free_from = x + half + GAP;
                area.draw(&Text::new(label, (x, bottom + 17), below.clone())).map_err(PlotError::new)?;
            }
        }
        let middle = left + self.plot.0 as i32 / 2;
        area.draw(&Text::new(format!("{right_name} [m]"), (middle, bottom + 54), below))
            .map_err(PlotError::new)?;
        let beside = text(HPos::Right, VPos::Center, TEXT);
        let (marks, step) = ticks(self.view.lower[1], self.view.upper[1], wanted(self.plot.1));
        for mark in marks {
            let y = top + self.place([0.0, mark]).1.round() as i32;
            area.draw(&line(vec![(left - 8, y), (left, y)])).map_err(PlotError::new)?;
            area.draw(&Text::new(label(mark, step), (left - 14, y + LOWER), beside.clone()))
                .map_err(PlotError::new)?;
        }
        let upright = text(HPos::Center, VPos::Top, TEXT).transform(FontTransform::Rotate270);
        let middle = top + self.plot.1 as i32 / 2;
        area.draw(&Text::new(format!("{upward_name} [m]"), (left - 140, middle), upright))
            .map_err(PlotError::new)
    }

    fn colour_bar<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, plotters::coord::Shift>,
        title: &str,
        scale: &ColourScale,
    ) -> Result<(), PlotError> {
        let (left, width) = (self.head.0 as i32, self.head.1 as i32);
        let magnitude = Magnitude::of(scale.lower.abs().max(scale.upper.abs()), &scale.unit);
        let title_style = text(HPos::Left, VPos::Center, TITLE);
        area.draw(&Text::new(title, (left, HEAD_TEXT), title_style)).map_err(PlotError::new)?;
        let caption = format!("{} [{}]", scale.quantity, magnitude.unit);
        let caption_style = text(HPos::Right, VPos::Center, TEXT);
        area.draw(&Text::new(caption, (left + width, HEAD_TEXT), caption_style)).map_err(PlotError::new)?;
        for x in 0..width {
            let [r, g, b] = scale.map.at(f64::from(x) / f64::from(width - 1));
            let column = [(left + x, BAR_TOP), (left + x + 1, BAR_BOTTOM)];
            area.draw(&Rectangle::new(column, RGBColor(r, g, b).filled())).map_err(PlotError::new)?;
        }
        let frame = [(left, BAR_TOP), (left + width, BAR_BOTTOM)];
        area.draw(&Rectangle::new(frame, INK.stroke_width(1))).map_err(PlotError::new)?;
        let (lower, upper) = (scale.lower / magnitude.divisor, scale.upper / magnitude.divisor);
        let style = text(HPos::Center, VPos::Top, TEXT);
        let (marks, step) = ticks(lower, upper, 6);
        for mark in marks {
            let x = left + (f64::from(width) * (mark - lower) / (upper - lower)).round() as i32;
            let tick = PathElement::new(vec![(x, BAR_BOTTOM), (x, BAR_BOTTOM + 7)], INK.stroke_width(2));
            area.draw(&tick).map_err(PlotError::new)?;
            let label = label(mark, step);
            // Labels at the ends stay on the canvas, their first digits where they are wider than it.
            let half = text_width(&label, TEXT) as i32 / 2 + 2;
            let x = x.min(self.canvas.0 as i32 - half).max(half);
            area.draw(&Text::new(label, (x, BAR_BOTTOM + 14), style.clone())).map_err(PlotError::new)?;
        }
        Ok(())
    }
}

fn text(horizontal: HPos, vertical: VPos, size: u32) -> TextStyle<'static> {
    TextStyle::from((font::FAMILY, size).into_font()).color(&INK).pos(Pos::new(horizontal, vertical))
}

/// Pixels as PNG.
pub(crate) fn encode(pixels: &[u8], (width, height): (u32, u32)) -> Result<Vec<u8>, PlotError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // A third smaller than `Fast`.
    encoder.set_compression(png::Compression::Default);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let mut writer = encoder.write_header().map_err(PlotError::new)?;
    writer.write_image_data(pixels).map_err(PlotError::new)?;
    writer.finish().map_err(PlotError::new)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
