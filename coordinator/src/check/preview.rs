//! A picture of a scene before it runs: every particle, coloured by what it belongs to.

use std::path::Path;

use plotters::backend::DrawingBackend;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use sph::setup::{Argument, ProbeKind};
use sph::space::Vector;

use crate::case::Case;
use crate::failure::Failure;
use crate::quote;
use crate::results::font;

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
    // The bitmap backend takes the format from the ending, and a half-written picture must not look complete.
    let partial = path.with_extension("partial.png");
    let groups = groups(case);
    paint(case, &groups, &partial).map_err(|e| failed("draw", &e))?;
    std::fs::rename(&partial, path).map_err(|e| failed("write", &e))
}

/// Particles of one colour.
struct Group {
    label: String,
    colour: RGBColor,
    spacing: f64,
    positions: Vec<Vector>,
}

fn groups(case: &Case) -> Vec<Group> {
    let (scene, file) = (case.scene(), case.file());
    let members = |groups: &[u32], positions: &[Vector], count: usize| {
        let mut of_group = vec![Vec::new(); count];
        for (group, x) in groups.iter().zip(positions) {
            of_group[*group as usize].push(*x);
        }
        of_group.into_iter()
    };
    let mut found = Vec::new();
    let mut add = |kind: &str, name: &str, colour: RGBColor, spacing: f64, positions: Vec<Vector>| {
        let label = format!("{kind}{name} ({})", positions.len());
        found.push(Group { label, colour, spacing, positions });
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
    let held: Vec<Vector> = held.map(|(x, _)| *x).collect();
    if !held.is_empty() {
        add("held by supports", "", HELD, 0.5 * spacing, held);
    }
    found
}

/// Outcome of the drawing library.
type Drawn = Result<(), DrawingAreaErrorKind<<BitMapBackend<'static> as DrawingBackend>::ErrorType>>;
type Picture<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;
type Chart<'a> = ChartContext<'a, BitMapBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn paint(case: &Case, groups: &[Group], path: &Path) -> Drawn {
    let (lower, upper) = frame(case, groups);
    let size = upper - lower;
    let scale = LONG_SIDE / size.amax();
    // Rounded and within a few thousand pixels.
    let pixels = |length: f64| (scale * length).max(LEAST_SIDE).round() as u32;
    let (width, height) = (pixels(size.x), pixels(size.y));
    // At most a few dozen.
    let rows = groups.len().min(MOST_ROWS) as u32;
    let legend_height = ROW.unsigned_abs() * (rows + 4) + 2 * MARGIN;
    let total = (width + LABELS + 2 * MARGIN + LEGEND, (height + LABELS + 3 * MARGIN).max(legend_height));
    let root = BitMapBackend::new(path, total).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(total.0 - LEGEND);
    let mut chart = ChartBuilder::on(&left)
        .margin(MARGIN)
        .x_label_area_size(LABELS)
        .y_label_area_size(LABELS)
        .caption(format!("{}: particles at the start", case.name), (font::FAMILY, 18))
        .build_cartesian_2d(lower.x..upper.x, lower.y..upper.y)?;
    chart
        .configure_mesh()
        .x_desc("x in m")
        .y_desc("y in m")
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 225, 225))
        .label_style((font::FAMILY, TEXT))
        .axis_desc_style((font::FAMILY, TEXT))
        .draw()?;
    let plotted = chart.plotting_area().dim_in_pixel();
    let scale = (f64::from(plotted.0) / size.x).min(f64::from(plotted.1) / size.y);
    for group in groups {
        draw_group(&mut chart, group, scale)?;
    }
    draw_domain(&mut chart, case)?;
    draw_probes(&mut chart, case)?;
    draw_legend(&right, groups, !probe_marks(case).is_empty())?;
    root.present()?;
    Ok(())
}

/// Particles as discs, or as their cells where discs would be a few pixels only; `scale` in pixels per metre.
fn draw_group(chart: &mut Chart<'_>, group: &Group, scale: f64) -> Drawn {
    let style = group.colour.filled();
    let radius = 0.45 * scale * group.spacing;
    if radius >= LEAST_RADIUS {
        let discs = group.positions.iter().map(|x| Circle::new((x.x, x.y), radius.round() as i32, style));
        chart.draw_series(discs)?;
    } else {
        // At least a pixel wide.
        let half = (0.5 * group.spacing).max(0.5 / scale);
        let cells = group
            .positions
            .iter()
            .map(|x| Rectangle::new([(x.x - half, x.y - half), (x.x + half, x.y + half)], style));
        chart.draw_series(cells)?;
    }
    Ok(())
}

/// Box around the domain and all particles, and a little more; square pixels.
fn frame(case: &Case, groups: &[Group]) -> (Vector, Vector) {
    let domain = case.file().domain.domain();
    let spacing = groups.iter().map(|group| group.spacing).fold(0.0, f64::max);
    let mut lower = domain.lower;
    let mut upper = domain.upper;
    for x in groups.iter().flat_map(|group| &group.positions) {
        lower = lower.inf(x);
        upper = upper.sup(x);
    }
    let margin = (0.02 * (upper - lower).amax()).max(spacing);
    lower.add_scalar_mut(-margin);
    upper.add_scalar_mut(margin);
    // A slender scene gets at least the least side, at the same scale in both directions.
    let least = (upper - lower).amax() * LEAST_SIDE / LONG_SIDE;
    for axis in 0..2 {
        let missing = (least - (upper[axis] - lower[axis])).max(0.0);
        lower[axis] -= 0.5 * missing;
        upper[axis] += 0.5 * missing;
    }
    (lower, upper)
}

fn draw_domain(chart: &mut Chart<'_>, case: &Case) -> Drawn {
    let domain = case.file().domain.domain();
    let corners = [(domain.lower.x, domain.lower.y), (domain.upper.x, domain.upper.y)];
    chart.draw_series(std::iter::once(Rectangle::new(corners, BLACK.mix(0.35).stroke_width(1))))?;
    Ok(())
}

/// Names and positions of the probes that have one.
fn probe_marks(case: &Case) -> Vec<(String, Vector)> {
    let probes = case.probes();
    let domain = case.file().domain.domain();
    let fluid = probes.fluid.iter().map(|probe| (&probe.name, probe.kind.arguments()));
    let solid = probes.solid.iter().map(|probe| (&probe.name, probe.kind.arguments()));
    let marks = fluid.chain(solid).flat_map(|(name, arguments)| {
        let place = move |(_, argument)| match argument {
            Argument::Point(x) => Some(x),
            Argument::Number(x) => Some(Vector::new(x, domain.upper.y)),
            Argument::Index(_) => None,
        };
        arguments.into_iter().filter_map(place).map(|x| (name.clone(), x))
    });
    marks.collect()
}

fn draw_probes(chart: &mut Chart<'_>, case: &Case) -> Drawn {
    let marks = probe_marks(case);
    chart.draw_series(marks.iter().map(|(_, x)| Cross::new((x.x, x.y), 6, PROBE.stroke_width(2))))?;
    // Labels climb until they are clear of those before.
    let mut taken: Vec<(i32, i32, i32)> = Vec::new();
    for (name, x) in marks.iter().take(MOST_LABELS) {
        let (left, centre) = chart.backend_coord(&(x.x, x.y));
        // About the width of a character; names have at most 64.
        let width = name.chars().map(|_| TEXT / 2 + 1).sum::<i32>();
        let clashes =
            |y: i32| taken.iter().any(|(l, w, t)| left < l + w && *l < left + width && (y - t).abs() < TEXT);
        let mut y = centre - TEXT;
        while clashes(y) {
            y -= TEXT / 2;
        }
        taken.push((left, width, y));
        let style = (font::FAMILY, TEXT - 2).into_font().color(&PROBE);
        chart.draw_series(std::iter::once(
            EmptyElement::at((x.x, x.y)) + Text::new(name.clone(), (9, y - centre), style),
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
        assert!(error.message.contains("cannot draw"), "{error}");
    }
}
