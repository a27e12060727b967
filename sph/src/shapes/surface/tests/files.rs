//! Files, sound and spoilt.

use super::*;

fn words(facets: &[[Vector3<f64>; 3]], name: &str, end: &str) -> String {
    let mut text = format!("solid {name}{end}");
    for facet in facets {
        text += &format!("  facet normal 0 0 0{end}    outer loop{end}");
        for x in facet {
            text += &format!("      vertex {:e} {:e} {:e}{end}", x.x, x.y, x.z);
        }
        text += &format!("    endloop{end}  endfacet{end}");
    }
    text + &format!("endsolid {name}{end}")
}

fn binary(facets: &[[Vector3<f64>; 3]], header: &str) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..header.len()].copy_from_slice(header.as_bytes());
    bytes.extend(u32::try_from(facets.len()).expect("few").to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        for coordinate in facet.iter().flat_map(|x| x.iter()) {
            bytes.extend((*coordinate as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn volume(bytes: &[u8], scale: f64) -> f64 {
    Stl::read(bytes, scale).expect("sound").surface.report().volume
}

#[test]
fn both_forms_give_the_same_surface() {
    let facets = unit_cube();
    let file = Stl::read(words(&facets, "a cube", "\r\n").as_bytes(), 0.001).expect("sound");
    assert_eq!((file.binary, file.solids.as_slice()), (false, ["a cube".to_owned()].as_slice()));
    assert!((file.surface.report().volume / 1e-9 - 1.0).abs() < 1e-12 && file.surface.report().is_sound());
    // A header may begin like a file in words.
    for header in ["written by a program", "solid facet normal endsolid"] {
        let file = Stl::read(&binary(&facets, header), 1.0).expect("sound");
        assert!(file.binary && file.remarks.is_empty());
        assert_eq!(file.surface, Surface::new(&facets).expect("facets"));
    }
    let two = words(&facets, "first", "\n")
        + &words(&cube(Vector3::repeat(2.0), Vector3::repeat(3.0)), "second", "\n");
    let file = Stl::read(two.as_bytes(), 1.0).expect("sound");
    assert_eq!((file.solids.len(), file.surface.report().components), (2, 2));
    assert!((volume(two.as_bytes(), 1.0) - 2.0).abs() < 1e-12);
}

#[test]
fn corners_of_numbers_that_differ_by_round_off_become_one_vertex() {
    let mut facets = unit_cube();
    for (k, x) in facets.iter_mut().flatten().enumerate() {
        *x *= 1.0 + 1e-8 * (k as f64).sin();
    }
    let found = report(&facets);
    assert_eq!((found.vertices, found.open_edges.count), (8, 0));
}

#[test]
fn files_cut_off_or_miscounted_are_refused_or_remarked_upon() {
    let facets = unit_cube();
    let whole = binary(&facets, "");
    let refused = |bytes: &[u8]| Stl::read(bytes, 1.0).expect_err("spoilt").to_string();
    assert!(refused(&whole[..whole.len() - 20]).contains("states 12 facets, but it holds 11"));
    let mut many = whole.clone();
    many[80..84].copy_from_slice(&1000_u32.to_le_bytes());
    assert!(refused(&many).contains("states 1000 facets, but it holds 12"));
    let mut trailing = whole.clone();
    trailing.extend([7; 33]);
    let file = Stl::read(&trailing, 1.0).expect("sound");
    assert_eq!(file.remarks, ["33 bytes after the last facet are left out"]);
    for unknown in [0, u32::MAX] {
        let mut bytes = whole.clone();
        bytes[80..84].copy_from_slice(&unknown.to_le_bytes());
        let file = Stl::read(&bytes, 1.0).expect("sound");
        assert_eq!((file.surface.facets(), file.remarks.len()), (12, 1));
    }
    let text = words(&facets, "cube", "\n");
    assert!(refused(&text.as_bytes()[..text.len() - 14]).contains("cut off after line"));
    assert!(refused(&text.as_bytes()[..text.len() / 2]).contains("export it again"));
    for bytes in [&b""[..], b"solid", b"hello, world", &[0; 83], &[0xff; 300]] {
        assert!(!refused(bytes).is_empty());
    }
    assert!(refused(&whole[..84]).contains("cut off"));
    assert!(refused(&binary(&[], "")).contains("no facet"));
    assert!(Stl::read(&whole, 0.0).expect_err("scale").to_string().contains("scale = 0"));
}

#[test]
fn numbers_and_lines_that_are_none_are_named() {
    let mut facets = unit_cube();
    facets[4][1].y = f64::NAN;
    let error = Stl::read(&binary(&facets, ""), 1.0).expect_err("spoilt");
    assert_eq!(error, StlError::Number { facet: 5, byte: 84 + 4 * 50 });
    let text = words(&unit_cube(), "cube", "\n");
    for (from, to, problem) in [
        ("vertex 0e0 0e0 0e0", "vertex 0e0 nan 0e0", "line 4: the coordinate `nan` is no finite number"),
        ("vertex 0e0 0e0 0e0", "vertex 0e0 0,1 0e0", "line 4: the coordinate `0,1` is no number"),
        ("vertex 0e0 0e0 0e0", "vertex 0e0 0e0", "line 4: a vertex needs three coordinates"),
        ("      vertex 0e0 0e0 0e0\n", "", "the facet has 2 corners"),
        ("    endloop\n", "", "corners: make it of triangles"),
        ("outer loop", "inner loop", "line 3: `inner` is no word of the format"),
    ] {
        let spoilt = text.replacen(from, to, 1);
        let error = Stl::read(spoilt.as_bytes(), 1.0).expect_err(problem).to_string();
        assert!(error.contains(problem), "{error}");
    }
}
