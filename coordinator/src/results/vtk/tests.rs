use std::fs;

use flate2::read::ZlibDecoder;

use super::*;

fn particles(n: u32) -> ParticleFields {
    let field = |name: &str, unit: &str, components: u32| Field {
        name: name.into(),
        unit: unit.into(),
        components: components as usize,
        values: (0..n * components).map(|k| f64::from(k).sin() / f64::from(components)).collect(),
    };
    ParticleFields {
        step: 42,
        time: 0.125,
        id: (0..n).rev().collect(),
        group: (0..n).map(|k| k % 2).collect(),
        group_names: vec!["water".into(), "a<b".into()],
        fields: vec![
            field("position", "m", 2),
            field("velocity", "m/s", 2),
            field("pressure", "Pa", 1),
            field("stress", "Pa", 3),
        ],
    }
}

/// Decoded bytes of the appended array called `name`, and its element.
fn decode(file: &[u8], name: &str) -> (Vec<u8>, String) {
    let marker = b"encoding=\"raw\">\n    _";
    let data = file.windows(marker.len()).position(|w| w == marker).unwrap() + marker.len();
    let xml = String::from_utf8(file[..data].to_vec()).unwrap();
    let element = xml.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap().to_string();
    let offset = element.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
    let data = &file[data + offset.parse::<usize>().unwrap()..];
    let word = |k: usize| u64::from_le_bytes(data[8 * k..8 * k + 8].try_into().unwrap()) as usize;
    let (blocks, block, partial) = (word(0), word(1), word(2));
    let mut at = 8 * (3 + blocks);
    let mut bytes = Vec::new();
    for k in 0..blocks {
        let before = bytes.len();
        io::Read::read_to_end(&mut ZlibDecoder::new(&data[at..at + word(3 + k)]), &mut bytes).unwrap();
        let expected = if k + 1 == blocks && partial > 0 { partial } else { block };
        assert_eq!(bytes.len() - before, expected);
        at += word(3 + k);
    }
    (bytes, element)
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn arrays_decode_to_what_was_written() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("fluid.vtp");
    // 20,000 particles: several blocks, the last one partial.
    for n in [0, 5, 20_000] {
        let particles = particles(n);
        write_particles(&path, &particles).unwrap();
        let file = fs::read(&path).unwrap();
        let (pressure, element) = decode(&file, "pressure");
        assert_eq!(floats(&pressure), particles.fields[2].values);
        assert!(element.contains(">Pa<") && element.contains("NumberOfComponents=\"1\""), "{element}");
        let (velocity, element) = decode(&file, "velocity");
        assert!(element.contains("NumberOfComponents=\"3\""));
        let expected: Vec<f64> =
            particles.fields[1].values.chunks(2).flat_map(|v| [v[0], v[1], 0.0]).collect();
        assert_eq!(floats(&velocity), expected);
        assert!(decode(&file, "stress").1.contains("ComponentName2=\"xy\""));
        assert_eq!(decode(&file, "Points").0.len(), 24 * n as usize);
        let ids: Vec<u8> = particles.id.iter().flat_map(|id| id.to_le_bytes()).collect();
        assert_eq!(decode(&file, "id").0, ids);
        assert_eq!(floats(&decode(&file, "TimeValue").0), [0.125]);
    }
}

#[test]
fn a_block_border_leaves_no_partial_block() {
    let mut appended = Appended::default();
    appended.add(std::iter::repeat_n(7u8, 2 * BLOCK)).unwrap();
    let word = |k: usize| u64::from_le_bytes(appended.bytes[8 * k..8 * k + 8].try_into().unwrap());
    assert_eq!((word(0), word(2)), (2, 0));
}

#[test]
fn the_collection_names_every_snapshot_once_with_its_time() {
    let root = tempfile::tempdir().unwrap();
    let mut series = Series::new(root.path(), "fluid");
    let mut particles = particles(3);
    for (step, time) in [(0, 0.0), (10, 0.1 + 0.2), (10, 0.1 + 0.2)] {
        (particles.step, particles.time) = (step, time);
        series.write(&particles).unwrap();
    }
    let collection = fs::read_to_string(root.path().join("fluid.pvd")).unwrap();
    assert_eq!(collection.matches("<DataSet").count(), 2);
    assert!(collection.contains("timestep=\"0.30000000000000004\""));
    assert!(collection.contains("file=\"fluid_00000010.vtp\""));
    assert!(root.path().join("fluid_00000000.vtp").exists());
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 3);
}

#[test]
fn particles_without_position_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let mut particles = particles(3);
    particles.fields.remove(0);
    let message = write_particles(&root.path().join("x.vtp"), &particles).unwrap_err().to_string();
    assert!(message.contains("position"), "{message}");
}
