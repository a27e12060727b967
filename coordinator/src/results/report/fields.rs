//! Pictures of the particles: pressure of the fluid, stress in the solids.

use sph::coupling::solver::ParticleFields;

use super::ReportData;
use super::page::{Section, png_figure};
use crate::results::plots::PlotError;
use crate::results::plots::colour::{ColourMap, ColourScale, Rgb, SOLID, WALL, WATER};
use crate::results::plots::field::{Dot, View, picture, positions, spacing};
use crate::results::plots::gallery::PairedSnapshot;
use crate::results::plots::scale::quantile;

/// Shares of all values that lie below and above the colours; they take the colours of the ends.
const OUTLIERS: f64 = 0.005;
/// Room around the solids in their own pictures, in particle spacings.
const SOLID_MARGIN: f64 = 12.0;

/// Pressure of the fluid with walls and solids; `None` without fluid.
pub fn pressure(data: &ReportData) -> Result<Option<Section>, PlotError> {
    let mut values: Vec<f64> = Vec::new();
    for (fluid, _) in sides(data).filter_map(|(fluid, solid)| Some((fluid?, solid))) {
        let pressures = components(fluid, "pressure", 0);
        values.extend(pressures.zip(is_wall(fluid, &data.walls)).filter(|(_, wall)| !wall).map(|(p, _)| p));
    }
    let (Some(lower), Some(upper)) = (quantile(&mut values, OUTLIERS), quantile(&mut values, 1.0 - OUTLIERS))
    else {
        return Ok(None);
    };
    // Pressure counts from zero, at the free surface, unless all of the fluid is far from it.
    let lower = if lower > 0.0 && lower < 0.5 * upper { 0.0 } else { lower };
    let (lower, upper) = if lower < upper { (lower, upper) } else { (lower - 1.0, upper + 1.0) };
    let scale = scale(ColourMap::Viridis, lower, upper, "pressure");
    let sizes = Sizes::of(data);
    // One view for all times, so that pictures can be compared.
    let everything = sides(data).flat_map(|(fluid, solid)| [fluid, solid]).flatten().flat_map(positions);
    let Some(whole) = View::around(everything, sizes.fluid) else { return Ok(None) };
    let walls = sides(data).filter_map(|(fluid, _)| fluid).flat_map(|fluid| walls_of(fluid, &data.walls));
    let view = View::around(walls, sizes.fluid).map_or(whole, |walls| enclosing(walls, whole));
    let mut figures = Vec::new();
    for snapshot in &data.snapshots {
        let Some(fluid) = &snapshot.fluid else { continue };
        let colours = colours(fluid, &data.walls, components(fluid, "pressure", 0).map(|p| scale.colour(p)));
        let mut dots = dots(fluid, sizes.fluid, colours);
        if let Some(solid) = &snapshot.solid {
            dots.extend(self::dots(solid, sizes.solid, std::iter::repeat_n(SOLID, solid.id.len())));
        }
        let title = time_of(snapshot);
        figures.push(png_figure(&picture(&title, view, &dots, &scale)?, &format!("pressure at {title}")));
    }
    let solids = if data.snapshots.iter().any(|s| s.solid.is_some()) { ", solids orange" } else { "" };
    Ok(Some(Section {
        id: "pressure",
        headline: "Pressure of the fluid",
        note: format!(
            "Walls grey{solids}. All pictures share one colour scale; the lowest and the highest {:.1} % of all \
             values take the colours of its ends.",
            100.0 * OUTLIERS
        ),
        figures,
    }))
}

/// σ₂₂ in the solids, close up; `None` without solids.
pub fn stress(data: &ReportData) -> Result<Option<Section>, PlotError> {
    let solids = || sides(data).filter_map(|(_, solid)| solid);
    let mut values: Vec<f64> =
        solids().flat_map(|solid| components(solid, "stress", 1)).map(f64::abs).collect();
    let Some(largest) = quantile(&mut values, 1.0 - 2.0 * OUTLIERS) else { return Ok(None) };
    let largest = if largest > 0.0 { largest } else { 1.0 };
    let scale = scale(ColourMap::CoolWarm, -largest, largest, "σ₂₂");
    let sizes = Sizes::of(data);
    let mut figures = Vec::new();
    for snapshot in &data.snapshots {
        let Some(solid) = &snapshot.solid else { continue };
        let Some(view) = View::around(positions(solid), SOLID_MARGIN * sizes.solid) else { continue };
        let mut all = match &snapshot.fluid {
            Some(fluid) => {
                let water = std::iter::repeat_n(WATER, fluid.id.len());
                dots(fluid, sizes.fluid, colours(fluid, &data.walls, water))
            }
            None => Vec::new(),
        };
        let stresses = components(solid, "stress", 1).map(|stress| scale.colour(stress));
        all.extend(dots(solid, sizes.solid, stresses));
        let title = time_of(snapshot);
        figures.push(png_figure(&picture(&title, view, &all, &scale)?, &format!("sigma_22 at {title}")));
    }
    Ok(Some(Section {
        id: "stress",
        headline: "Stress σ₂₂ in the solids",
        note: format!(
            "Red is tension along y, blue is compression. Each picture is a close-up of the solids at its time; all \
             share one colour scale, and the largest {:.0} % of all magnitudes take the colours of its ends.",
            200.0 * OUTLIERS
        ),
        figures,
    }))
}

/// Particle spacings of both sides \[m\].
struct Sizes {
    fluid: f64,
    solid: f64,
}

impl Sizes {
    fn of(data: &ReportData) -> Self {
        // The first snapshot is the least strained.
        let fluid = sides(data).find_map(|(fluid, _)| fluid.and_then(spacing));
        let solid = sides(data).find_map(|(_, solid)| solid.and_then(spacing));
        let any = fluid.or(solid).unwrap_or(1.0);
        Self { fluid: fluid.unwrap_or(any), solid: solid.unwrap_or(any) }
    }
}

fn sides(data: &ReportData) -> impl Iterator<Item = (Option<&ParticleFields>, Option<&ParticleFields>)> {
    data.snapshots.iter().map(|snapshot| (snapshot.fluid.as_ref(), snapshot.solid.as_ref()))
}

fn scale(map: ColourMap, lower: f64, upper: f64, quantity: &str) -> ColourScale {
    ColourScale { map, lower, upper, quantity: quantity.into(), unit: "Pa".into() }
}

fn time_of(snapshot: &PairedSnapshot) -> String {
    match snapshot.time {
        0.0 => "t = 0 s".into(),
        time if time.abs() < 0.01 => format!("t = {time:.3e} s"),
        time => format!("t = {time:.4} s"),
    }
}

/// One component of a field, NaN where the field or the component is missing.
fn components<'a>(
    particles: &'a ParticleFields,
    name: &str,
    component: usize,
) -> impl Iterator<Item = f64> + 'a {
    let field = particles.field(name);
    (0..particles.id.len()).map(move |i| {
        let field = field.filter(|field| component < field.components);
        field
            .and_then(|field| field.values.get(i * field.components + component))
            .copied()
            .unwrap_or(f64::NAN)
    })
}

/// Whether each particle belongs to a wall.
fn is_wall<'a>(particles: &'a ParticleFields, walls: &[String]) -> impl Iterator<Item = bool> + 'a {
    let of_group: Vec<bool> = particles.group_names.iter().map(|name| walls.contains(name)).collect();
    particles.group.iter().map(move |group| {
        usize::try_from(*group).ok().and_then(|group| of_group.get(group)).copied().unwrap_or(false)
    })
}

/// Colours of fluid particles as given, and grey for walls.
fn colours<'a>(
    fluid: &'a ParticleFields,
    walls: &[String],
    colours: impl Iterator<Item = Rgb> + 'a,
) -> impl Iterator<Item = Rgb> + 'a {
    colours.zip(is_wall(fluid, walls)).map(|(colour, wall)| if wall { WALL } else { colour })
}

fn dots(particles: &ParticleFields, spacing: f64, colours: impl Iterator<Item = Rgb>) -> Vec<Dot> {
    positions(particles).zip(colours).map(|(position, colour)| Dot { position, spacing, colour }).collect()
}

/// Positions of the wall particles \[m\].
fn walls_of<'a>(fluid: &'a ParticleFields, walls: &[String]) -> impl Iterator<Item = [f64; 2]> + 'a {
    positions(fluid).zip(is_wall(fluid, walls)).filter(|(_, wall)| *wall).map(|(position, _)| position)
}

/// The walls, widened to what lies outside of them by at most their own height or width: a few drops that fly far
/// above an open tank must not shrink the picture.
fn enclosing(walls: View, whole: View) -> View {
    let mut view = whole;
    for axis in 0..2 {
        let size = walls.upper[axis] - walls.lower[axis];
        view.lower[axis] = whole.lower[axis].max(walls.lower[axis] - 0.3 * size);
        view.upper[axis] = whole.upper[axis].min(walls.upper[axis] + 0.3 * size);
    }
    view
}
