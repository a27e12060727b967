//! What the program says of its platform.

use std::process::Command;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let target = std::env::var("TARGET").unwrap_or_default();
    println!("cargo:rustc-env=TIDELOCK_TARGET={target}");
    // A program needs at most the C library that it was built with.
    let output = Command::new("getconf").arg("GNU_LIBC_VERSION").output().ok();
    let version = output.and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    let known = target.ends_with("-gnu") && version.starts_with("glibc");
    let libc = if known { format!(" with {}", version.trim()) } else { String::new() };
    println!("cargo:rustc-env=TIDELOCK_LIBC={libc}");
}
