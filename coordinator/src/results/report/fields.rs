//! Pictures of the particles at the times of the case: pressure of the fluid, stress in the solids.

use sph::coupling::solver::ParticleFields;

use super::ReportData;
use super::page::{Section, png_figure};
use crate::results::plots::PlotError;
use crate::results::plots::colour::{ColourMap, ColourScale, Rgb, SOLID, WALL, WATER};
use crate::results::plots::field::{Dot, Sheet, View, draw, is_in_space, positions, spacing};
use crate::results::plots::gallery::PairedSnapshot;
use crate::results::plots::projection::{Place, Projection, SLICE, Views};
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
    let projection = views(data, &sizes).map_or(Projection::PLANE, |views| views.cut);
    let Some(view) = common_view(data, &projection, &sizes) else { return Ok(None) };
    let mut figures = Vec::new();
    for snapshot in &data.snapshots {
        let Some(fluid) = &snapshot.fluid else { continue };
        let colours = colours(fluid, &data.walls, components(fluid, "pressure", 0).map(|p| scale.colour(p)));
        let mut dots = dots(fluid, &projection, sizes.fluid, colours);
        if let Some(solid) = &snapshot.solid {
            let orange = std::iter::repeat_n(SOLID, solid.id.len());
            dots.extend(self::dots(solid, &projection, sizes.solid, orange));
        }
        let time = time_of(snapshot);
        let title = titled(&time, &projection, data.up_axis);
        let sheet = Sheet { title: &title, view, projection, scale: &scale };
        figures.push(png_figure(&draw(&sheet, &dots)?, &format!("pressure at {time}")));
    }
    let solids = if data.snapshots.iter().any(|s| s.solid.is_some()) { ", solids orange" } else { "" };
    Ok(Some(Section {
        id: "pressure",
        headline: "Pictures: pressure of the fluid",
        note: format!(
            "{}alls grey{solids}. All pictures share one colour scale; the lowest and the highest {:.1} % of all \
             values take the colours of its ends.",
            if projection.in_space { "In a cut, w" } else { "W" },
            100.0 * OUTLIERS
        ),
        figures,
    }))
}

/// A run in space seen from the side: water coloured by its speed, solids, no walls; `None` in the plane.
pub fn outside(data: &ReportData) -> Result<Option<Section>, PlotError> {
    let sizes = Sizes::of(data);
    let Some(Views { side: projection, .. }) = views(data, &sizes) else { return Ok(None) };
    let Some(view) = common_view(data, &projection, &sizes) else { return Ok(None) };
    let mut speeds: Vec<f64> = sides(data).filter_map(|(fluid, _)| fluid).flat_map(speeds).collect();
    let largest = quantile(&mut speeds, 1.0 - OUTLIERS).filter(|largest| *largest > 0.0).unwrap_or(1.0);
    let scale = ColourScale { unit: "m/s".into(), ..scale(ColourMap::Viridis, 0.0, largest, "speed") };
    let mut figures = Vec::new();
    for snapshot in &data.snapshots {
        let mut all = Vec::new();
        if let Some(fluid) = &snapshot.fluid {
            let colours = self::speeds(fluid).map(|speed| scale.colour(speed));
            let shown = dots(fluid, &projection, sizes.fluid, colours);
            let walls = is_wall(fluid, &data.walls);
            all.extend(shown.into_iter().zip(walls).filter(|(_, wall)| !wall).map(|(dot, _)| dot));
        }
        if let Some(solid) = &snapshot.solid {
            let orange = std::iter::repeat_n(SOLID, solid.id.len());
            all.extend(dots(solid, &projection, sizes.solid, orange));
        }
        let time = time_of(snapshot);
        let title = titled(&time, &projection, data.up_axis);
        let sheet = Sheet { title: &title, view, projection, scale: &scale };
        figures.push(png_figure(&draw(&sheet, &all)?, &format!("the scene at {time}")));
    }
    let note = "Water coloured by its speed, solids orange; walls are left out. All pictures share one colour scale.";
    Ok(Some(Section {
        id: "outside",
        headline: "Pictures: seen from outside",
        note: note.to_owned(),
        figures,
    }))
}

/// Von Mises stress in the solids, in one window for all times; `None` without solids.
pub fn stress(data: &ReportData) -> Result<Option<Section>, PlotError> {
    let solids = || sides(data).filter_map(|(_, solid)| solid);
    let mut values: Vec<f64> = solids().flat_map(|solid| components(solid, "von_mises", 0)).collect();
    let Some(largest) = quantile(&mut values, 1.0 - OUTLIERS) else { return Ok(None) };
    let largest = if largest > 0.0 { largest } else { 1.0 };
    let scale = scale(ColourMap::Viridis, 0.0, largest, "von Mises");
    let sizes = Sizes::of(data);
    let projection = views(data, &sizes).map_or(Projection::PLANE, |views| views.cut);
    let points = solids().flat_map(positions).map(|x| projection.point(&x));
    let Some(view) = View::around(points, SOLID_MARGIN * sizes.solid) else { return Ok(None) };
    let mut figures = Vec::new();
    for snapshot in &data.snapshots {
        let Some(solid) = &snapshot.solid else { continue };
        let mut all = match &snapshot.fluid {
            Some(fluid) => {
                let water = std::iter::repeat_n(WATER, fluid.id.len());
                dots(fluid, &projection, sizes.fluid, colours(fluid, &data.walls, water))
            }
            None => Vec::new(),
        };
        let stresses = components(solid, "von_mises", 0).map(|stress| scale.colour(stress));
        all.extend(dots(solid, &projection, sizes.solid, stresses));
        let time = time_of(snapshot);
        let title = titled(&time, &projection, data.up_axis);
        let sheet = Sheet { title: &title, view, projection, scale: &scale };
        figures.push(png_figure(&draw(&sheet, &all)?, &format!("von Mises stress at {time}")));
    }
    Ok(Some(Section {
        id: "stress",
        headline: "Pictures: von Mises stress in the solids",
        note: format!(
            "All pictures share one window and one colour scale; the largest {:.1} % of all values take the colour of its end.",
            100.0 * OUTLIERS
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

/// Particles that `projection` shows; the others are no numbers, which no picture has a place for.
fn dots(
    particles: &ParticleFields,
    projection: &Projection,
    spacing: f64,
    colours: impl Iterator<Item = Rgb>,
) -> Vec<Dot> {
    let dot = |(place, colour): (Place, Rgb)| {
        let position = if projection.shows(&place) { projection.point(&place) } else { [f64::NAN; 2] };
        Dot { position, nearness: projection.nearness(&place), spacing, colour }
    };
    positions(particles).zip(colours).map(dot).collect()
}

/// Speed of each particle \[m/s\].
fn speeds(particles: &ParticleFields) -> impl Iterator<Item = f64> + '_ {
    let field = particles.field("velocity");
    let speed = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    field.into_iter().flat_map(move |field| field.values.chunks(field.components.max(1)).map(speed))
}

/// The views of a run in space; `None` in the plane.
fn views(data: &ReportData, sizes: &Sizes) -> Option<Views> {
    let first = |of: fn(&PairedSnapshot) -> Option<&ParticleFields>| data.snapshots.iter().find_map(of);
    let (fluid, solid) = (first(|pair| pair.fluid.as_ref()), first(|pair| pair.solid.as_ref()));
    let inner = solid.or(fluid).filter(|particles| is_in_space(particles))?;
    let bounds = |places: &mut dyn Iterator<Item = Place>| {
        places.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(lower, upper), x| {
            (std::array::from_fn(|k| lower[k].min(x[k])), std::array::from_fn(|k| upper[k].max(x[k])))
        })
    };
    let (lower, upper) = bounds(&mut fluid.into_iter().chain(solid).flat_map(positions));
    // The cut goes through the middle of the solids, or of the water.
    let (first, last) = match solid {
        Some(_) => bounds(&mut positions(inner)),
        None => bounds(&mut water_of(inner, &data.walls)),
    };
    let middle = std::array::from_fn(|k| 0.5 * (first[k] + last[k]));
    Some(Views::of(data.up_axis, lower, upper, middle, SLICE * sizes.fluid.max(sizes.solid)))
}

/// `t = 0.1 s, cut at z = 0.2 m`; the time alone in the plane.
fn titled(time: &str, projection: &Projection, up_axis: usize) -> String {
    if projection.in_space { format!("{time}, {}", projection.title(up_axis)) } else { time.to_owned() }
}

/// One view for all times, so that pictures can be compared.
fn common_view(data: &ReportData, projection: &Projection, sizes: &Sizes) -> Option<View> {
    let everything = sides(data).flat_map(|(fluid, solid)| [fluid, solid]).flatten().flat_map(positions);
    let whole = View::around(everything.map(|x| projection.point(&x)), sizes.fluid)?;
    let walls = sides(data).filter_map(|(fluid, _)| fluid).flat_map(|fluid| walls_of(fluid, &data.walls));
    let walls = View::around(walls.map(|x| projection.point(&x)), sizes.fluid);
    Some(walls.map_or(whole, |walls| enclosing(walls, whole)))
}

/// Positions of the wall particles \[m\].
fn walls_of<'a>(fluid: &'a ParticleFields, walls: &[String]) -> impl Iterator<Item = Place> + 'a {
    positions(fluid).zip(is_wall(fluid, walls)).filter(|(_, wall)| *wall).map(|(position, _)| position)
}

/// Positions of the water particles \[m\].
fn water_of<'a>(fluid: &'a ParticleFields, walls: &[String]) -> impl Iterator<Item = Place> + 'a {
    positions(fluid).zip(is_wall(fluid, walls)).filter(|(_, wall)| !wall).map(|(position, _)| position)
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
