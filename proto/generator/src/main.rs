//! Compiles the .proto files without a system `protoc`, and writes down which of their fields are lists.
//!
//! `cargo run -p proto-generator` rewrites `proto/src/generated`. The files are checked in, so that a build of the programs
//! compiles neither protox nor prost-build; a test says when they are out of date.

mod shapes;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

const FILES: [&str; 5] = [
    "fsi/v2/types.proto",
    "fsi/v2/setup.proto",
    "fsi/v2/participant.proto",
    "fsi/v2/peer.proto",
    "fsi/v2/recording.proto",
];

fn main() -> Result<(), Box<dyn Error>> {
    generate(&generated())
}

/// The folder of crate `proto`.
fn proto() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The folder of the checked-in files.
fn generated() -> PathBuf {
    proto().join("src/generated")
}

/// Writes messages and services, the table of lists, and the descriptors for reflection to the folder `out`.
fn generate(out: &Path) -> Result<(), Box<dyn Error>> {
    let descriptors = protox::compile(FILES, [proto().join("proto")])?;
    fs::create_dir_all(out)?;
    fs::write(out.join("fsi.v2.bin"), prost::Message::encode_to_vec(&descriptors))?;
    fs::write(out.join("shapes.rs"), shapes::shapes(&descriptors)?)?;
    tonic_prost_build::configure()
        .out_dir(out)
        // Particle arrays are taken from the receive buffer without a copy.
        .bytes(".fsi.v2")
        // Lists are counted before they are decoded.
        .codec_path("crate::transport::codec::Bounded")
        .compile_fds(descriptors)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn names(folder: &Path) -> BTreeSet<String> {
        let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    /// Files of one folder only, and those that differ.
    fn differences(fresh: &Path, kept: &Path) -> Vec<String> {
        let all = &names(fresh) | &names(kept);
        // A file that is missing is no file with the same bytes.
        let same = |name: &String| {
            fs::read(fresh.join(name)).is_ok_and(|bytes| fs::read(kept.join(name)).is_ok_and(|b| b == bytes))
        };
        all.into_iter().filter(|name| !same(name)).collect()
    }

    #[test]
    fn the_checked_in_files_are_what_the_proto_files_say() {
        let fresh = tempfile::tempdir().unwrap();
        generate(fresh.path()).unwrap();
        assert!(names(fresh.path()).len() >= 3);
        let stale: Vec<_> = differences(fresh.path(), &generated())
            .iter()
            .map(|name| format!("proto/src/generated/{name}"))
            .collect();
        assert!(
            stale.is_empty(),
            "not what the .proto files say: {}: run `cargo run -p proto-generator`, and remove files that it does \
             not write",
            stale.join(", ")
        );
    }

    #[test]
    fn a_file_that_differs_is_missing_or_is_too_many_is_found() {
        let (one, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let put = |folder: &tempfile::TempDir, name: &str, text: &str| {
            fs::write(folder.path().join(name), text).unwrap();
        };
        for folder in [&one, &other] {
            put(folder, "same", "a");
        }
        assert!(differences(one.path(), other.path()).is_empty());
        put(&one, "changed", "a");
        put(&other, "changed", "b");
        put(&one, "missing", "");
        put(&other, "extra", "");
        assert_eq!(differences(one.path(), other.path()), ["changed", "extra", "missing"]);
    }
}
