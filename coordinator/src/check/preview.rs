//! A picture of a scene before it runs: every particle, coloured by what it belongs to.

use std::path::Path;

use plotters::backend::DrawingBackend;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use sph::in_space;
use sph::setup::{Argument, Probe, ProbeKind};
use sph::space::components::Components;
use sph::space::{AXIS_NAMES, Space};

use crate::case::file::wall::WallKind;
use crate::case::{Case, Scene};
use crate::failure::Failure;
use crate::quote;
use crate::results::font;
use crate::results::plots::field::encode;
use crate::results::plots::projection::{Place, Projection, SLICE, Views, up_axis};

/// Colours of fluid regions.
const FLUIDS: [RGBColor; 4] =
    [RGBColor(70, 130, 200), RGBColor(120, 185, 225), RGBColor(40, 80, 150), RGBColor(90, 200, 200)];

/// Colours of bodies.
const BODIES: [RGBColor; 6] = [
    RGBColor(222, 120, 40),
    RGBColor(90, 160, 70),
    RGBColor(180, 80, 160),
    RGBColor(200, 170, 40),
    RGBColor(170, 60, 50),
    RGBColor(130, 110, 90),
];

/// Colours of walls.
const WALLS: [RGBColor; 3] = [RGBColor(120, 120, 120), RGBColor(170, 170, 170), RGBColor(80, 80, 95)];

/// Particles that supports hold.
const HELD: RGBColor = RGBColor(20, 20, 20);

/// Probes.
const PROBE: RGBColor = RGBColor(210, 0, 60);

/// Longer side of the plot and the least shorter one [pixels].
const LONG_SIDE: f64 = 1100.0;
const LEAST_SIDE: f64 = 260.0;

/// Space for axis labels, legend and title [pixels].
const LABELS: u32 = 60;
const LEGEND: u32 = 300;
const MARGIN: u32 = 16;

/// Most rows of the legend and most labels of probes: further ones would cover the picture.
const MOST_ROWS: usize = 40;
const MOST_LABELS: usize = 200;

/// Smallest radius at which a disc looks like one [pixels].
const LEAST_RADIUS: f64 = 3.0;

/// Height of a legend row and of text [pixels].
const ROW: i32 = 22;
const TEXT: i32 = 15;

/// Draws the particles of `case` at the start to a PNG at `path`.
///
/// # Errors
/// When the picture cannot be drawn or written.
pub fn draw(case: &Case, path: &Path) -> Result<(), Failure> {
    font::register();
    let failed = |action: &str, e: &dyn std::fmt::Display| {
        Failure::output(format!("cannot {action} `{}`: {e}", quote::path(path)))
    };
    let (pixels, size) = paint(case, &groups(case)).map_err(|e| failed("draw", &e))?;
    let picture = encode(&pixels, size).map_err(|e| failed("draw", &e))?;
    // A half-written picture must not look complete.
    let partial = path.with_extension("partial.png");
    std::fs::write(&partial, picture)
        .and_then(|()| std::fs::rename(&partial, path))
        .map_err(|e| failed("write", &e))
}

/// Particles of one colour.
struct Group {
    label: String,
    colour: RGBColor,
    spacing: f64,
    /// A container would hide what it holds from a view from outside.
    is_container: bool,
    positions: Vec<Place>,
}

/// `vector` with zeros for the axes that its space lacks.
fn lifted<V: Components>(vector: &V) -> Place {
    let row = vector.row();
    std::array::from_fn(|axis| row.as_ref().get(axis).copied().unwrap_or(0.0))
}

fn groups(case: &Case) -> Vec<Group> {
    in_space!(case.scene(), scene => groups_in(case, scene))
}

fn groups_in<S: Space>(case: &Case, scene: &Scene<S>) -> Vec<Group> {
    let file = case.file();
    let members = |groups: &[u32], positions: &[S::Vector], count: usize| {
        let mut of_group = vec![Vec::new(); count];
        for (group, x) in groups.iter().zip(positions) {
            of_group[*group as usize].push(lifted(x));
        }
        of_group.into_iter()
    };
    let mut found = Vec::new();
    let mut add = |kind: &str, name: &str, colour: RGBColor, spacing: f64, positions: Vec<Place>| {
        let label = format!("{kind}{name} ({})", positions.len());
        let is_container = kind == "wall "
            && file
                .walls
                .iter()
                .any(|wall| wall.name.value == name && wall.kind.value == WallKind::Container);
        found.push(Group { label, colour, spacing, is_container, positions });
    };
    let wall_spacing = file.wall_spacing().unwrap_or(1.0);
    let walls = members(&scene.walls.wall, &scene.walls.position, file.walls.len());
    for (k, (wall, positions)) in file.walls.iter().zip(walls).enumerate() {
        add("wall ", &wall.name.value, WALLS[k % WALLS.len()], wall_spacing, positions);
    }
    if let Some(fluid) = &file.fluid {
        let regions = members(&scene.fluid.region, &scene.fluid.position, fluid.regions.len());
        for (k, (region, positions)) in fluid.regions.iter().zip(regions).enumerate() {
            add(
                "fluid ",
                &region.name.value,
                FLUIDS[k % FLUIDS.len()],
                fluid.parameters.particle_spacing,
                positions,
            );
        }
    }
    let Some(solid) = &file.solid else { return found };
    let spacing = solid.particle_spacing_m.value;
    let bodies = members(&scene.solid.body, &scene.solid.position, solid.bodies.len());
    for (k, (body, positions)) in solid.bodies.iter().zip(bodies).enumerate() {
        add("body ", &body.name.value, BODIES[k % BODIES.len()], spacing, positions);
    }
    let held = scene.solid.position.iter().zip(&scene.solid.support).filter(|(_, support)| **support > 0);
    let held: Vec<Place> = held.map(|(x, _)| lifted(x)).collect();
    if !held.is_empty() {
        add("held by supports", "", HELD, 0.5 * spacing, held);
    }
    found
}

/// Outcome of the drawing library.
type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<<BitMapBackend<'static> as DrawingBackend>::ErrorType>>;
type Picture<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;
type Chart<'a> = ChartContext<'a, BitMapBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// What is shown: the plane as it is; of a scene in space a cut and views from the side and from above.
fn projections(case: &Case, groups: &[Group]) -> Vec<Projection> {
    if case.dimensions() == 2 {
        return vec![Projection::PLANE];
    }
    let (lower, upper) = extent(case, groups);
    // Through the bodies where there are any, else through the water.
    let shown = groups.iter().filter(|group| !group.is_container);
    let inner = shown.clone().filter(|group| group.label.starts_with("body "));
    let places: Vec<&Place> = match inner.clone().next() {
        Some(_) => inner.flat_map(|group| &group.positions).collect(),
        None => shown.clone().flat_map(|group| &group.positions).collect(),
    };
    let middle = std::array::from_fn(|axis| {
        let along = || places.iter().map(|x| x[axis]);
        0.5 * (along().fold(f64::INFINITY, f64::min) + along().fold(f64::NEG_INFINITY, f64::max))
    });
    let middle =
        if places.is_empty() { std::array::from_fn(|k| 0.5 * (lower[k] + upper[k])) } else { middle };
    // The slice holds a row of particles wherever it is.
    let thickness = SLICE * groups.iter().map(|group| group.spacing).fold(0.0, f64::max);
    let up = up_axis(case.file().body_force.gravity_m_s2.as_slice());
    let Views { side, above, cut } = Views::of(up, lower, upper, middle, thickness);
    vec![cut, side, above]
}

/// Red, green and blue of each pixel, and how many there are along each side.
fn paint(case: &Case, groups: &[Group]) -> Drawn<(Vec<u8>, (u32, u32))> {
    let projections = projections(case, groups);
    let frames: Vec<([f64; 2], [f64; 2])> =
        projections.iter().map(|projection| frame(case, groups, projection)).collect();
    let size = |(lower, upper): &([f64; 2], [f64; 2])| [upper[0] - lower[0], upper[1] - lower[1]];
    // One scale for all.
    let longest = frames.iter().flat_map(size).fold(0.0, f64::max);
    let scale = LONG_SIDE / longest;
    // Rounded and within a few thousand pixels.
    let pixels = |length: f64| (scale * length).max(LEAST_SIDE).round() as u32;
    let width = frames.iter().map(|frame| pixels(size(frame)[0])).max().unwrap_or_default();
    let heights: Vec<u32> = frames.iter().map(|frame| pixels(size(frame)[1]) + LABELS + 3 * MARGIN).collect();
    // At most a few dozen.
    let rows = groups.len().min(MOST_ROWS) as u32;
    let legend_height = ROW.unsigned_abs() * (rows + 4) + 2 * MARGIN;
    let total = (width + LABELS + 2 * MARGIN + LEGEND, heights.iter().sum::<u32>().max(legend_height));
    let mut pixels = vec![255; 3 * total.0 as usize * total.1 as usize];
    let root = BitMapBackend::with_buffer(&mut pixels, total).into_drawing_area();
    root.fill(&WHITE)?;
    let (mut left, right) = root.split_horizontally(total.0 - LEGEND);
    let up = up_axis(case.file().body_force.gravity_m_s2.as_slice());
    for (k, (projection, height)) in projections.iter().zip(heights).enumerate() {
        let (panel, rest) = left.split_vertically(height);
        left = rest;
        let mut title = match k {
            0 => format!("{}: particles at the start", case.name),
            _ => String::new(),
        };
        if case.dimensions() == 3 {
            let view = projection.title(up);
            title = if title.is_empty() { view } else { format!("{title}, {view}") };
        }
        draw_panel(&panel, case, groups, (projection, frames[k]), &title)?;
    }
    draw_legend(&right, groups, !probe_marks(case).is_empty())?;
    root.present()?;
    drop((left, right, root));
    Ok((pixels, total))
}

fn draw_panel(
    area: &Picture<'_>,
    case: &Case,
    groups: &[Group],
    (projection, (lower, upper)): (&Projection, ([f64; 2], [f64; 2])),
    title: &str,
) -> Drawn {
    // A frame of the proportions of the scene, from the left.
    let size = [upper[0] - lower[0], upper[1] - lower[1]];
    let room = area.dim_in_pixel();
    let plot = [room.0 - LABELS - 2 * MARGIN, room.1 - LABELS - 3 * MARGIN].map(f64::from);
    let scale = (plot[0] / size[0]).min(plot[1] / size[1]);
    let spare = (plot[0] - scale * size[0]).max(0.0) as u32;
    let (area, _) = area.split_horizontally(room.0 - spare);
    let mut chart = ChartBuilder::on(&area)
        .margin(MARGIN)
        .x_label_area_size(LABELS)
        .y_label_area_size(LABELS)
        .caption(title, (font::FAMILY, 18))
        .build_cartesian_2d(lower[0]..upper[0], lower[1]..upper[1])?;
    chart
        .configure_mesh()
        .x_desc(format!("{} in m", AXIS_NAMES[projection.right]))
        .y_desc(format!("{} in m", AXIS_NAMES[projection.upward]))
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 225, 225))
        .label_style((font::FAMILY, TEXT))
        .axis_desc_style((font::FAMILY, TEXT))
        .draw()?;
    let plotted = chart.plotting_area().dim_in_pixel();
    let scale = (f64::from(plotted.0) / size[0]).min(f64::from(plotted.1) / size[1]);
    draw_groups(&mut chart, case, groups, projection, scale)?;
    draw_domain(&mut chart, case, projection)?;
    draw_probes(&mut chart, case, projection)
}

/// Darkest shade of the particles that are farthest from the viewer.
const FARTHEST_SHADE: f64 = 0.45;

/// Particles as discs, or as their cells where discs would be a few pixels only, the farthest first; `scale` in pixels per
/// metre.
fn draw_groups(
    chart: &mut Chart<'_>,
    case: &Case,
    groups: &[Group],
    projection: &Projection,
    scale: f64,
) -> Drawn {
    let from_outside = case.dimensions() == 3 && projection.slice.is_none();
    let mut shown: Vec<(f64, &Group, &Place)> = groups
        .iter()
        .filter(|group| !(from_outside && group.is_container))
        .flat_map(|group| group.positions.iter().map(move |x| (group, x)))
        .filter(|(_, x)| projection.shows(x))
        .map(|(group, x)| (projection.nearness(x), group, x))
        .collect();
    let (mut nearest, mut farthest) = (f64::NEG_INFINITY, f64::INFINITY);
    if from_outside {
        shown.sort_by(|a, b| a.0.total_cmp(&b.0));
        nearest = shown.last().map_or(0.0, |last| last.0);
        farthest = shown.first().map_or(0.0, |first| first.0);
    }
    for (nearness, group, x) in shown {
        let [x, y] = projection.point(x);
        let far = if nearest > farthest { (nearest - nearness) / (nearest - farthest) } else { 0.0 };
        let shade = 1.0 - (1.0 - FARTHEST_SHADE) * far;
        let RGBColor(red, green, blue) = group.colour;
        let [red, green, blue] = [red, green, blue].map(|c| (f64::from(c) * shade).round() as u8);
        let style = RGBColor(red, green, blue).filled();
        let radius = 0.45 * scale * group.spacing;
        if radius >= LEAST_RADIUS {
            chart.draw_series(std::iter::once(Circle::new((x, y), radius.round() as i32, style)))?;
        } else {
            // At least a pixel wide.
            let half = (0.5 * group.spacing).max(0.5 / scale);
            let cell = Rectangle::new([(x - half, y - half), (x + half, y + half)], style);
            chart.draw_series(std::iter::once(cell))?;
        }
    }
    Ok(())
}

/// The corners \[m\] of the domain.
fn domain_of(case: &Case) -> (Place, Place) {
    let domain = &case.file().domain;
    let place = |row: &[f64]| std::array::from_fn(|axis| row.get(axis).copied().unwrap_or(0.0));
    (place(domain.lower_m.value.as_slice()), place(domain.upper_m.value.as_slice()))
}

/// Box around the domain and all particles \[m\].
fn extent(case: &Case, groups: &[Group]) -> (Place, Place) {
    let (mut lower, mut upper) = domain_of(case);
    for x in groups.iter().flat_map(|group| &group.positions) {
        for axis in 0..3 {
            lower[axis] = lower[axis].min(x[axis]);
            upper[axis] = upper[axis].max(x[axis]);
        }
    }
    (lower, upper)
}

/// That box in the picture, and a little more; square pixels.
fn frame(case: &Case, groups: &[Group], projection: &Projection) -> ([f64; 2], [f64; 2]) {
    let spacing = groups.iter().map(|group| group.spacing).fold(0.0, f64::max);
    let (lower, upper) = extent(case, groups);
    let (mut lower, mut upper) = (projection.point(&lower), projection.point(&upper));
    let longer = (upper[0] - lower[0]).max(upper[1] - lower[1]);
    let margin = (0.02 * longer).max(spacing);
    // A slender scene gets at least the least side, at the same scale in both directions.
    let least = (longer + 2.0 * margin) * LEAST_SIDE / LONG_SIDE;
    for axis in 0..2 {
        lower[axis] -= margin;
        upper[axis] += margin;
        let missing = (least - (upper[axis] - lower[axis])).max(0.0);
        lower[axis] -= 0.5 * missing;
        upper[axis] += 0.5 * missing;
    }
    (lower, upper)
}

fn draw_domain(chart: &mut Chart<'_>, case: &Case, projection: &Projection) -> Drawn {
    let (lower, upper) = domain_of(case);
    let corners = [projection.point(&lower), projection.point(&upper)].map(|[x, y]| (x, y));
    chart.draw_series(std::iter::once(Rectangle::new(corners, BLACK.mix(0.35).stroke_width(1))))?;
    Ok(())
}

/// Names and positions of the probes that have one.
fn probe_marks(case: &Case) -> Vec<(String, Place)> {
    let top = domain_of(case).1;
    in_space!(case.probes(), probes => marks(&probes.fluid, top).chain(marks(&probes.solid, top)).collect())
}

fn marks<K: ProbeKind>(probes: &[Probe<K>], top: Place) -> impl Iterator<Item = (String, Place)> + '_ {
    let place = move |argument| match argument {
        Argument::Point(x) => Some(lifted(&x)),
        Argument::Number(x) => Some([x, top[1], top[2]]),
        Argument::Index(_) => None,
    };
    probes.iter().flat_map(move |probe| {
        let arguments = probe.kind.arguments().into_iter();
        arguments.filter_map(move |(_, argument)| Some((probe.name.clone(), place(argument)?)))
    })
}

fn draw_probes(chart: &mut Chart<'_>, case: &Case, projection: &Projection) -> Drawn {
    let marks = probe_marks(case);
    let marks: Vec<(String, [f64; 2])> =
        marks.into_iter().map(|(name, place)| (name, projection.point(&place))).collect();
    chart.draw_series(marks.iter().map(|(_, [x, y])| Cross::new((*x, *y), 6, PROBE.stroke_width(2))))?;
    // Labels climb until they are clear of those before.
    let mut taken: Vec<(i32, i32, i32)> = Vec::new();
    for (name, [x, y]) in marks.into_iter().take(MOST_LABELS) {
        let (left, centre) = chart.backend_coord(&(x, y));
        // About the width of a character; names have at most 64.
        let width = name.chars().map(|_| TEXT / 2 + 1).sum::<i32>();
        let clashes =
            |y: i32| taken.iter().any(|(l, w, t)| left < l + w && *l < left + width && (y - t).abs() < TEXT);
        let mut row = centre - TEXT;
        while clashes(row) {
            row -= TEXT / 2;
        }
        taken.push((left, width, row));
        let style = (font::FAMILY, TEXT - 2).into_font().color(&PROBE);
        chart.draw_series(std::iter::once(
            EmptyElement::at((x, y)) + Text::new(name, (9, row - centre), style),
        ))?;
    }
    Ok(())
}

fn draw_legend(area: &Picture<'_>, groups: &[Group], probes: bool) -> Drawn {
    let style = (font::FAMILY, TEXT).into_font();
    let mut y = 3 * ROW;
    for group in groups.iter().take(MOST_ROWS) {
        area.draw(&Circle::new((10, y), 6, group.colour.filled()))?;
        area.draw(&Text::new(group.label.clone(), (24, y - TEXT / 2), style.clone()))?;
        y += ROW;
    }
    if groups.len() > MOST_ROWS {
        let more = format!("and {} more", groups.len() - MOST_ROWS);
        area.draw(&Text::new(more, (24, y - TEXT / 2), style.clone()))?;
        y += ROW;
    }
    if probes {
        area.draw(&Cross::new((10, y), 6, PROBE.stroke_width(2)))?;
        area.draw(&Text::new("probes", (24, y - TEXT / 2), style))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_shows_every_group_in_its_colour_and_replaces_no_half_picture() {
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/drifting_body_coarse.toml");
        let case = crate::case::load(&case, &|_| Err(String::new())).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.png");
        draw(&case, &path).unwrap();
        let entries = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(entries, 1, "the partial picture is renamed");
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
        // Drawn in memory once more to look at its pixels.
        let groups = groups(&case);
        assert_eq!(groups.len(), 6);
        assert!(bytes.len() > 10_000, "{} bytes", bytes.len());
        let labels: Vec<&str> = groups.iter().map(|group| group.label.as_str()).collect();
        assert!(labels.contains(&"body body (81)") && labels.contains(&"held by supports (9)"), "{labels:?}");
    }

    #[test]
    fn a_folder_that_does_not_exist_is_reported() {
        let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/drifting_body_coarse.toml");
        let case = crate::case::load(&case, &|_| Err(String::new())).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let error = draw(&case, &folder.path().join("no/such/scene.png")).unwrap_err();
        assert!(error.message.contains("cannot write"), "{error}");
    }
}
