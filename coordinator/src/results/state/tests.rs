//! Final states that are good, damaged, and made to deceive.

use std::fs;

use super::*;

fn field(name: &str, components: usize, values: &[f64]) -> Field {
    Field { name: name.into(), unit: "m".into(), components, values: values.to_vec() }
}

fn state() -> ParticleFields {
    ParticleFields {
        step: 17,
        time: 0.1 + 0.2,
        id: vec![3, 1, 8],
        group: vec![0, 1, 1],
        group_names: vec!["water".into(), "Wand µ".into()],
        fields: vec![
            field("position", 2, &[0.1, -0.0, f64::MIN_POSITIVE, 4.0, 1.0 / 3.0, 1e300]),
            field("pressure", 1, &[f64::NAN, f64::INFINITY, -7.5]),
        ],
    }
}

fn saved(root: &tempfile::TempDir) -> (std::path::PathBuf, Vec<u8>) {
    let path = root.path().join("fluid.state");
    write(&path, &state()).unwrap();
    let bytes = fs::read(&path).unwrap();
    (path, bytes)
}

/// `bytes` with the right length and checksum for its body.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    bytes[12..20].copy_from_slice(&((body - 20) as u64).to_le_bytes());
    let mut crc = flate2::Crc::new();
    crc.update(&bytes[20..body]);
    bytes[body..].copy_from_slice(&crc.sum().to_le_bytes());
    bytes
}

#[test]
fn a_state_reads_back_bit_for_bit() {
    let root = tempfile::tempdir().unwrap();
    let (path, bytes) = saved(&root);
    let back = read(&path).unwrap();
    // NaN is not equal to itself: compare by bits.
    assert_eq!(digest(&back), digest(&state()));
    assert_eq!(back.group_names, state().group_names);
    assert_eq!((back.step, back.time.to_bits()), (17, state().time.to_bits()));
    assert_eq!(back.fields[0], state().fields[0]);
    assert_eq!(sealed(bytes.clone()), bytes);
}

#[test]
fn every_cut_and_every_flipped_bit_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let (path, bytes) = saved(&root);
    for length in 0..bytes.len() {
        fs::write(&path, &bytes[..length]).unwrap();
        assert!(read(&path).is_err(), "cut at {length}");
    }
    for k in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[k] ^= 0x10;
        fs::write(&path, &damaged).unwrap();
        let message = read(&path).unwrap_err();
        assert!(message.contains("fluid.state"), "{message}");
    }
}

#[test]
fn false_sizes_with_a_right_checksum_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let (path, bytes) = saved(&root);
    // Number of particles, number of groups, length of the first group's name.
    for (at, width) in [(36, 8), (44, 4), (48, 4)] {
        for value in [0u64, 2, u64::from(u32::MAX), u64::MAX] {
            let mut hostile = bytes.clone();
            hostile[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
            if hostile == bytes {
                continue;
            }
            fs::write(&path, sealed(hostile)).unwrap();
            assert!(read(&path).is_err(), "{value} at {at}");
        }
    }
    let mut longer = bytes.clone();
    longer.splice(bytes.len() - 4..bytes.len() - 4, [0; 8]);
    fs::write(&path, sealed(longer)).unwrap();
    assert!(read(&path).unwrap_err().contains("too many"));
}

#[test]
fn another_version_and_another_kind_of_file_are_named() {
    let root = tempfile::tempdir().unwrap();
    let (path, mut bytes) = saved(&root);
    bytes[8] = 9;
    fs::write(&path, &bytes).unwrap();
    assert!(read(&path).unwrap_err().contains("version 9"));
    fs::write(&path, "t_s,p1_pressure_pa\n0.0,1.0\n").unwrap();
    assert!(read(&path).unwrap_err().contains("no final state"));
    assert!(read(root.path()).is_err());
    assert!(read(&root.path().join("absent")).unwrap_err().contains("absent"));
}

#[test]
fn the_digest_sees_every_bit_but_not_the_order() {
    let reference = digest(&state());
    assert_eq!(reference.len(), 64);
    let mut turned = state();
    turned.id.rotate_left(1);
    turned.group.rotate_left(1);
    turned.fields[0].values.rotate_left(2);
    turned.fields[1].values.rotate_left(1);
    turned.fields.reverse();
    assert_eq!(digest(&turned), reference);
    let mut other = state();
    other.fields[0].values[1] = 0.0;
    assert_ne!(digest(&other), reference, "the sign of zero is a bit");
}

#[test]
fn arrays_that_do_not_fit_are_not_written() {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("x.state");
    let mut broken = state();
    broken.fields[1].values.pop();
    assert!(write(&path, &broken).unwrap_err().to_string().contains("pressure"));
    broken = state();
    broken.group[0] = 2;
    assert!(write(&path, &broken).is_err());
    assert!(!path.exists());
}

#[test]
fn a_pipe_is_refused_at_once_and_a_sparse_file_before_it_is_read() {
    let root = tempfile::tempdir().unwrap();
    let (path, mut bytes) = saved(&root);
    let pipe = root.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    assert!(read(&pipe).unwrap_err().contains("no regular file"));
    // 200 GB that take no room, of a right length by their header.
    let length: u64 = 200_000_000_000;
    bytes[12..20].copy_from_slice(&(length - FRAME).to_le_bytes());
    for particles in [3, 5_000_000, 12_000_000_000u64] {
        bytes[36..44].copy_from_slice(&particles.to_le_bytes());
        fs::write(&path, &bytes).unwrap();
        fs::File::options().write(true).open(&path).unwrap().set_len(length).unwrap();
        let message = read(&path).unwrap_err();
        assert!(message.contains("too large") && message.contains("fluid.state"), "{message}");
    }
}

#[test]
fn more_particles_than_a_case_may_have_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let (path, bytes) = saved(&root);
    let mut hostile = bytes.clone();
    hostile[36..44].copy_from_slice(&5_000_001u64.to_le_bytes());
    fs::write(&path, sealed(hostile)).unwrap();
    assert!(read(&path).unwrap_err().contains("more than 5000000 particles"));
}
