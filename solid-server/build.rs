//! Names the build for checkpoints: another build may give other bits.

#[path = "../build/sources.rs"]
mod sources;

fn main() {
    sources::emit(
        &["src", "physics/src", "../sph/src"],
        &["physics/Cargo.toml", "../Cargo.lock", "../Cargo.toml"],
    );
}
