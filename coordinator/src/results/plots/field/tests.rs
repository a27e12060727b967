use super::*;
use crate::results::plots::colour::ColourMap;
use sph::coupling::solver::Field;

fn scale() -> ColourScale {
    let (quantity, unit) = ("pressure".into(), "Pa".into());
    ColourScale { map: ColourMap::Viridis, lower: 0.0, upper: 1.0, quantity, unit }
}

/// A picture of the plane.
fn picture(title: &str, view: View, dots: &[Dot], scale: &ColourScale) -> Result<Vec<u8>, PlotError> {
    draw(&Sheet { title, view, projection: Projection::PLANE, scale }, dots)
}

fn decode(bytes: &[u8]) -> (Vec<u8>, png::OutputInfo) {
    let mut reader = png::Decoder::new(bytes).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (pixels, info)
}

#[test]
fn no_scale_and_no_view_is_too_extreme_to_draw() {
    let ends = [0.0, 1.0, -1e308, 1e308, f64::MAX, 1e-308, 5e-324, f64::NAN, f64::INFINITY];
    let dot = Dot { position: [0.5, 0.5], nearness: 0.0, spacing: 0.1, colour: [0; 3] };
    for lower in ends {
        for upper in ends {
            let unit = View { lower: [0.0; 2], upper: [1.0; 2] };
            let scale = ColourScale { lower, upper, ..scale() };
            let drawn = picture("t = 0 s", unit, &[dot], &scale);
            assert!(drawn.is_ok(), "{lower:e} to {upper:e}: {drawn:?}");
        }
    }
}

#[test]
fn a_label_wider_than_the_canvas_shows_its_first_digits() {
    // Steps of 1e-17 about 1e300: over 300 digits.
    let scale = ColourScale { lower: 1e300, upper: 1.000_000_000_000_001e300, ..scale() };
    let view = View { lower: [0.0; 2], upper: [1.0; 2] };
    assert!(picture("t = 0 s", view, &[], &scale).is_ok());
}

#[test]
fn a_square_of_particles_fills_a_square_without_gaps() {
    let red = [200, 10, 10];
    let dots: Vec<Dot> = (0..100)
        .map(|k| Dot {
            position: [0.05 + 0.1 * f64::from(k % 10), 0.05 + 0.1 * f64::from(k / 10)],
            nearness: 0.0,
            spacing: 0.1,
            colour: red,
        })
        .collect();
    // Twice as wide as high: the square must stay a square.
    let view = View { lower: [-0.5, -0.1], upper: [1.9, 1.1] };
    let (pixels, info) = decode(&picture("t = 0 s", view, &dots, &scale()).unwrap());
    let reds: Vec<(usize, usize)> = pixels
        .chunks(3)
        .enumerate()
        .filter(|(_, pixel)| *pixel == red)
        .map(|(k, _)| (k % info.width as usize, k / info.width as usize))
        .collect();
    let extent = |axis: fn(&(usize, usize)) -> usize| {
        let (low, high) = (reds.iter().map(axis).min().unwrap(), reds.iter().map(axis).max().unwrap());
        high - low + 1
    };
    let (wide, high) = (extent(|p| p.0), extent(|p| p.1));
    assert_eq!(wide, high, "equal axes");
    // 0.4 zoomed units of 960/2.4 px per metre, and the reach beyond the outermost squares.
    assert!((400..440).contains(&wide), "{wide}");
    let filled = reds.len() as f64 / (wide * high) as f64;
    assert!(filled > 0.97, "only the corners are round: {filled}");
}

#[test]
fn the_nearest_particle_colours_a_pixel_whatever_the_order() {
    let near = Dot { position: [0.3, 0.5], nearness: 0.0, spacing: 0.5, colour: [1, 2, 3] };
    let far = Dot { position: [0.7, 0.5], nearness: 0.0, spacing: 0.5, colour: [4, 5, 6] };
    let view = View { lower: [0.0, 0.0], upper: [1.0, 1.0] };
    let paint = |dots: &[Dot]| picture("", view, dots, &scale()).unwrap();
    assert_eq!(paint(&[near, far]), paint(&[far, near]));
}

#[test]
fn odd_views_and_positions_that_are_no_numbers_do_no_harm() {
    let dot = |x: f64, y: f64| Dot { position: [x, y], nearness: 0.0, spacing: 1e-3, colour: [0, 0, 0] };
    let dots = [dot(f64::NAN, 0.0), dot(0.0, f64::INFINITY), dot(-1e9, 1e9), dot(0.1, 0.1)];
    for (lower, upper) in [([0.0, 0.0], [10.0, 0.001]), ([0.0, 0.0], [0.001, 10.0])] {
        let (_, info) = decode(&picture("t", View { lower, upper }, &dots, &scale()).unwrap());
        assert!(info.width >= LEAST_WIDTH && info.width < 1300 && info.height < 1300);
    }
    assert_eq!(View::around([[f64::NAN, 1.0]].into_iter(), 0.1), None);
}

#[test]
fn spacing_is_that_of_the_matter() {
    let field = |name: &str, components: usize, values: Vec<f64>| Field {
        name: name.into(),
        unit: String::new(),
        components,
        values,
    };
    let lattice: Vec<f64> =
        (0..400).flat_map(|k| [f64::from(k % 20) * 0.01, f64::from(k / 20) * 0.01]).collect();
    let mut particles = ParticleFields {
        id: (0..400).collect(),
        fields: vec![field("position", 2, lattice)],
        ..ParticleFields::default()
    };
    // An even share of the box through the outermost particles: 5 % low for a 20 x 20 lattice.
    assert!((spacing(&particles).unwrap() - 0.01).abs() < 6e-4);
    particles.fields.push(field("mass", 1, vec![0.1; 400]));
    particles.fields.push(field("density", 1, vec![1000.0; 400]));
    assert!((spacing(&particles).unwrap() - 0.01).abs() < 1e-15);
}

#[test]
fn seen_from_outside_the_ball_nearest_to_the_viewer_hides_the_others() {
    let ball = |nearness: f64, colour| Dot { position: [0.5, 0.5], nearness, spacing: 0.5, colour };
    let (near, far) = (ball(1.0, [200, 0, 0]), ball(0.0, [0, 200, 0]));
    let view = View { lower: [0.0; 2], upper: [1.0; 2] };
    let projection = Projection { in_space: true, right: 0, upward: 2, slice: None };
    let sheet = Sheet { title: "", view, projection, scale: &scale() };
    let [one, other] = [[near, far], [far, near]].map(|dots| draw(&sheet, &dots).unwrap());
    assert_eq!(one, other);
    let (pixels, _) = decode(&one);
    assert!(pixels.chunks(3).any(|pixel| pixel == [200, 0, 0]), "the middle of a ball has its colour");
    assert!(
        pixels.chunks(3).any(|pixel| (111..120).contains(&pixel[0]) && pixel[1] == 0),
        "its rim is darker"
    );
    assert!(
        !pixels.chunks(3).any(|pixel| pixel[1] > 100 && pixel[0] == 0 && pixel[2] == 0),
        "nothing behind it shows"
    );
}

#[test]
fn spacing_in_space_is_the_edge_of_a_cube() {
    let field = |name: &str, components: usize, values: Vec<f64>| Field {
        name: name.into(),
        unit: String::new(),
        components,
        values,
    };
    let particles = ParticleFields {
        id: vec![0],
        fields: vec![
            field("position", 3, vec![0.0; 3]),
            field("mass", 1, vec![1e-3]),
            field("density", 1, vec![1000.0]),
        ],
        ..ParticleFields::default()
    };
    assert!((spacing(&particles).unwrap() - 0.01).abs() < 1e-15);
}
