//! Compiles the .proto files without a system `protoc`.

use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files = [
        "fsi/v1/types.proto",
        "fsi/v1/setup.proto",
        "fsi/v1/participant.proto",
        "fsi/v1/peer.proto",
        "fsi/v1/recording.proto",
    ];
    println!("cargo::rerun-if-changed=proto");
    let descriptors = protox::compile(files, ["proto"])?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("fsi.v1.bin"), prost::Message::encode_to_vec(&descriptors))?;
    tonic_prost_build::configure()
        // Particle arrays are taken from the receive buffer without a copy.
        .bytes(".fsi.v1")
        .compile_fds(descriptors)?;
    Ok(())
}
