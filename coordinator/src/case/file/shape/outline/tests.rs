use std::f64::consts::{FRAC_PI_2, PI, TAU};

use sph::shapes::Shape;

use super::curves::{Curve, Point};
use super::{Placement, dxf, loops, pieces, shape};
use crate::case::file::shape::ShapeTable;

/// Pairs of a drawing with `entities`, given as "code value" separated by commas.
fn drawing(entities: &str) -> String {
    let all = format!(
        "0 SECTION,2 HEADER,9 $INSUNITS,70 4,0 ENDSEC,0 SECTION,2 ENTITIES,{entities},0 ENDSEC,0 EOF"
    );
    all.split(',').map(|pair| pair.trim().replacen(' ', "\n", 1) + "\n").collect()
}

fn closed(corners: &[(Point, f64)]) -> String {
    let corners: String =
        corners.iter().map(|([x, y], bulge)| format!(",10 {x},20 {y},42 {bulge}")).collect();
    format!("0 LWPOLYLINE,8 0,90 4,70 1{corners}")
}

fn square(from: f64, to: f64) -> String {
    closed(&[([from, from], 0.0), ([to, from], 0.0), ([to, to], 0.0), ([from, to], 0.0)])
}

fn line([x, y]: Point, [u, v]: Point) -> String {
    format!("0 LINE,8 0,10 {x},20 {y},30 0,11 {u},21 {v},31 0")
}

fn as_drawn() -> Placement {
    Placement { unit: 1.0, angle: 0.0, by: vec![0.0, 0.0].into() }
}

fn read_with(
    entities: &str,
    layer: Option<&str>,
    tolerance: Option<f64>,
    placement: &Placement,
) -> Result<Shape, String> {
    let (pieces, tolerance) = pieces(dxf::read(drawing(entities).as_bytes())?, layer, tolerance)?;
    shape(&loops::joined(pieces, tolerance)?, placement).map(|shape: ShapeTable| shape.to_plane())
}

fn read(entities: &str) -> Result<Shape, String> {
    read_with(entities, None, None, &as_drawn())
}

fn area(shape: &Shape) -> f64 {
    shape.validate().unwrap();
    shape.boundary().moments().volume
}

fn problem(entities: &str) -> String {
    read(entities).unwrap_err()
}

#[test]
fn lines_in_any_order_and_sense_make_one_loop() {
    let (a, b, c, d) = ([0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]);
    // Ends are off by less than 1e-4 of the side of 3.
    let entities = [line(a, b), line(d, [1e-4, -1e-4]), line(c, b), line(c, d)].join(",");
    let shape = read(&entities).unwrap();
    assert!((area(&shape) - 6.0).abs() < 1e-3, "{shape:?}");
    let Shape::Polygon { vertices } = &shape else { panic!("{shape:?}") };
    assert_eq!(vertices.len(), 4);
}

#[test]
fn circles_and_arcs_are_as_near_as_the_tolerance_says() {
    for tolerance in [1e-2, 1e-4] {
        let circle = "0 CIRCLE,8 0,10 1,20 2,40 0.5";
        let shape = read_with(circle, None, Some(tolerance), &as_drawn()).unwrap();
        let Shape::Polygon { vertices } = &shape else { panic!("{shape:?}") };
        let radii = vertices.iter().map(|x| (x.x - 1.0).hypot(x.y - 2.0));
        assert!(radii.into_iter().all(|radius| (radius - 0.5).abs() < 1e-12));
        // A chord that is off by t takes 2/3 t of its length from the area.
        let missing = PI * 0.25 - area(&shape);
        assert!(missing > 0.1 * tolerance && missing < 2.0 / 3.0 * PI * tolerance, "{tolerance}: {missing}");
    }
    // A half disc of an arc across 0 degrees and its chord.
    let half = format!("0 ARC,8 0,10 0,20 0,40 2,50 270,51 90,{}", line([0.0, 2.0], [0.0, -2.0]));
    assert!((area(&read(&half).unwrap()) / (2.0 * PI) - 1.0).abs() < 1e-3);
}

#[test]
fn bulges_are_arcs_to_the_right_of_a_polyline() {
    // The tangent of a quarter of a half turn is 1.
    for (bulge, caps) in [(1.0, PI), (-1.0, -PI)] {
        let stadium = [([0.0, 0.0], 0.0), ([4.0, 0.0], bulge), ([4.0, 2.0], 0.0), ([0.0, 2.0], bulge)];
        let found = area(&read(&closed(&stadium)).unwrap());
        assert!((found - 8.0 - caps).abs() < 2e-3, "{bulge}: {found}");
    }
    let older = "0 POLYLINE,8 0,66 1,70 1,0 VERTEX,10 0,20 0,42 1,0 VERTEX,10 2,20 0,42 1,0 SEQEND,8 0";
    assert!((area(&read(older).unwrap()) - PI).abs() < 1e-3);
}

#[test]
fn ellipses_and_splines_have_their_areas() {
    let ellipse = "0 ELLIPSE,8 0,10 0,20 0,11 3,21 4,40 0.5";
    assert!((area(&read(ellipse).unwrap()) / (PI * 12.5) - 1.0).abs() < 1e-3);
    // A quarter circle as a rational spline of degree 2.
    let quarter = format!(
        "0 SPLINE,8 0,70 4,71 2,40 0,40 0,40 0,40 1,40 1,40 1,41 1,41 {},41 1,10 1,20 0,10 1,20 1,10 0,20 1,{},{}",
        0.5_f64.sqrt(),
        line([0.0, 1.0], [0.0, 0.0]),
        line([0.0, 0.0], [1.0, 0.0])
    );
    assert!((area(&read(&quarter).unwrap()) / (0.25 * PI) - 1.0).abs() < 1e-3);
    let cubic = Curve::spline(
        3,
        vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
        vec![[0.0, 0.0], [0.0, 1.0], [2.0, 1.0], [2.0, 0.0]],
        Vec::new(),
    )
    .unwrap();
    // By Bernstein's polynomials at 1/2.
    assert!(cubic.points(1e-6).iter().any(|[x, y]| (x - 1.0).abs() < 1e-12 && (y - 0.75).abs() < 1e-12));
}

#[test]
fn what_lies_within_an_outline_is_a_hole_and_what_lies_in_the_hole_is_not() {
    let nested = [square(0.0, 10.0), square(1.0, 9.0), square(2.0, 8.0), square(20.0, 21.0)].join(",");
    let shape = read(&nested).unwrap();
    assert!((area(&shape) - (100.0 - 64.0 + 36.0 + 1.0)).abs() < 1e-9, "{shape:?}");
    for (x, inside) in [(0.5, true), (1.5, false), (5.0, true), (20.5, true), (15.0, false)] {
        assert_eq!(shape.contains(&[x, x].into()), inside, "{x}");
    }
}

#[test]
fn an_outline_is_scaled_turned_about_its_origin_and_moved() {
    let placement = Placement { unit: 0.001, angle: FRAC_PI_2, by: vec![1.0, 2.0].into() };
    let shape = read_with(&square(0.0, 10.0), None, None, &placement).unwrap();
    let (low, high) = shape.bounds();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(near(low.x, 0.99) && near(high.x, 1.0) && near(low.y, 2.0) && near(high.y, 2.01), "{low} {high}");
}

#[test]
fn one_layer_is_taken_and_notes_are_left_out() {
    let other = square(2.0, 3.0).replace("8 0", "8 Other");
    let entities = format!("{},{other},0 TEXT,8 Other,10 0,20 0,1 a note", square(0.0, 1.0));
    let on = |layer| read_with(&entities, layer, None, &as_drawn());
    assert!((area(&on(Some("OTHER")).unwrap()) - 1.0).abs() < 1e-12);
    assert!((area(&on(None).unwrap()) - 2.0).abs() < 1e-12);
    let missing = on(Some("hull")).unwrap_err();
    assert!(missing.contains("has no lines on the layer `hull`; it has 0, Other"), "{missing}");
    // What is not in the model, or not shown, is left out too.
    let hidden = format!("{},60 1,{},67 1,{}", square(5.0, 6.0), square(7.0, 8.0), square(0.0, 1.0));
    assert!((area(&read(&hidden).unwrap()) - 1.0).abs() < 1e-12);
}

#[test]
fn entities_seen_from_below_are_mirrored() {
    let arc = "0 ARC,8 0,10 1,20 0,40 1,50 0,51 180,210 0,220 0,230 -1";
    let shape = read(&format!("{arc},{}", line([0.0, 0.0], [-2.0, 0.0]))).unwrap();
    let (low, high) = shape.bounds();
    assert!(low.x > -2.0 - 1e-9 && high.x < 1e-9 && high.y > 0.99 && low.y > -1e-9, "{low} {high}");
    let tilted = "0 CIRCLE,8 0,10 0,20 0,40 1,210 0,220 0.5,230 0.5";
    assert!(problem(tilted).contains("line 15 does not lie in the plane"), "{}", problem(tilted));
}

#[test]
fn what_is_no_closed_outline_is_refused_with_its_place() {
    let (a, b, c) = ([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]);
    let open = problem(&[line(a, b), line(b, c)].join(","));
    assert!(open.contains("is open at (0, 0): the next end is 1.000e0 away"), "{open}");
    let gap = problem(&[line(a, b), line(b, c), line(c, [0.0, 0.01])].join(","));
    assert!(gap.contains("is open at (0, 0): the next end is 1.000e-2 away"), "{gap}");
    let twice = problem(&[line(a, b), line(b, c), line(c, a), line(a, b)].join(","));
    assert!(twice.contains("more than two lines meet at (0, 0), or one lies on another"), "{twice}");
    let crossed = problem(&[square(0.0, 2.0), square(1.0, 3.0)].join(","));
    assert!(crossed.contains("cross or touch"), "{crossed}");
    let touching = problem(&[square(0.0, 1.0), square(1.0, 2.0)].join(","));
    assert!(touching.contains("cross or touch"), "{touching}");
    let block = problem("0 INSERT,8 0,2 hull,10 0,20 0");
    assert!(block.contains("line 15 is an inserted block: explode"), "{block}");
    let solid = problem("0 3DSOLID,8 0");
    assert!(solid.contains("3DSOLID is not read"), "{solid}");
    let fitted = problem("0 SPLINE,8 0,71 3,11 0,21 0,11 1,21 1");
    assert!(fitted.contains("without control points"), "{fitted}");
    let knots = problem("0 SPLINE,8 0,71 2,40 0,40 1,10 0,20 0,10 1,20 0,10 0,20 1");
    assert!(knots.contains("degree 2 with 3 control points and 2 knots"), "{knots}");
    assert_eq!(problem("0 TEXT,8 0,1 a note"), "has no lines");
}

#[test]
fn files_that_are_no_drawings_are_refused() {
    let of = |bytes: &[u8]| dxf::read(bytes).unwrap_err();
    assert!(of(b"AutoCAD Binary DXF\r\n\x1a\0").contains("save the drawing as ASCII DXF"));
    assert!(of(b"solid cube\nfacet normal 0 0 1\n").contains("line 1: no group code"));
    assert!(of(b"0\nSECTION\n2\nHEADER\n0\nENDSEC\n0\nEOF\n").contains("no section ENTITIES"));
    assert!(of(b"0\nSECTION\n2\nENTITIES\n0\nLINE\n").contains("ends within its entities"));
    assert!(of(b"0\nSECTION\n2").contains("line 3: ends after a group code"));
    let bad = drawing("0 LINE,8 0,10 one,20 0,11 1,21 1");
    assert!(of(bad.as_bytes()).contains("line 20: no finite number in group 10"), "{}", of(bad.as_bytes()));
    let short = drawing("0 CIRCLE,8 0,10 0,20 0");
    assert!(of(short.as_bytes()).contains("line 15: CIRCLE has no group 40"), "{}", of(short.as_bytes()));
}

#[test]
fn a_whole_turn_is_closed_and_a_drawing_of_too_many_corners_is_refused() {
    let turn = Curve::arc([0.0, 0.0], 1.0, 0.3, 0.3 + TAU);
    assert!(turn.closed && turn.points(1e-3).len() > 8);
    let fine = read_with("0 CIRCLE,8 0,10 0,20 0,40 1", None, Some(1e-9), &as_drawn()).unwrap_err();
    assert!(fine.contains("needs more than 10000 corners; a larger `tolerance_m`"), "{fine}");
}
