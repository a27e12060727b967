//! Rules for dependencies: allowed licences, Rust versions, and none that is unused. .ci/extended checks more by
//! cargo-deny.

use std::iter::Peekable;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The root of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn toml(file: &str) -> toml::Table {
    std::fs::read_to_string(root().join(file)).unwrap().parse().unwrap()
}

fn cargo(arguments: &[&str]) -> String {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(program).args(arguments).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// All packages that are built on this machine, as Cargo describes them: those of the workspace, then the others.
fn packages() -> [Vec<Value>; 2] {
    let version = cargo(&["-vV"]);
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    let words = ["metadata", "--format-version", "1", "--locked", "--offline", "--filter-platform", host];
    let mut metadata: Value = serde_json::from_str(&cargo(&words)).unwrap();
    let Value::Array(packages) = metadata["packages"].take() else { panic!("no packages") };
    let (own, others): (Vec<Value>, _) =
        packages.into_iter().partition(|package| package["source"].is_null());
    assert!(own.len() >= 7 && others.len() > 200, "{} and {}", own.len(), others.len());
    [own, others]
}

/// Whether a licence expression (SPDX, or the old form with a slash) can be met by `allowed` licences.
fn is_met(expression: &str, allowed: &[&str]) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let mut words = spaced.split_whitespace().peekable();
    let met = any(&mut words, allowed);
    assert_eq!(words.next(), None, "{expression}");
    met
}

fn any<'a>(words: &mut Peekable<impl Iterator<Item = &'a str>>, allowed: &[&str]) -> bool {
    let mut met = all(words, allowed);
    while words.next_if_eq(&"OR").is_some() {
        met |= all(words, allowed);
    }
    met
}

fn all<'a>(words: &mut Peekable<impl Iterator<Item = &'a str>>, allowed: &[&str]) -> bool {
    let mut met = one(words, allowed);
    while words.next_if_eq(&"AND").is_some() {
        met &= one(words, allowed);
    }
    met
}

fn one<'a>(words: &mut Peekable<impl Iterator<Item = &'a str>>, allowed: &[&str]) -> bool {
    let name = words.next().unwrap_or_default();
    if name == "(" {
        let met = any(words, allowed);
        assert_eq!(words.next(), Some(")"));
        return met;
    }
    match words.next_if_eq(&"WITH").and_then(|_| words.next()) {
        Some(exception) => allowed.contains(&format!("{name} WITH {exception}").as_str()),
        None => allowed.contains(&name),
    }
}

#[test]
fn licence_expressions_are_read_as_spdx_defines_them() {
    let allowed = ["MIT", "ISC"];
    for met in ["MIT", "GPL-3.0-only OR MIT", "Unlicense/MIT", "MIT AND ISC", "(BSL-1.0 OR MIT) AND ISC"] {
        assert!(is_met(met, &allowed), "{met}");
    }
    for not in ["GPL-3.0-only", "MIT AND GPL-3.0-only", "MIT WITH x", "ISC AND (BSL-1.0 OR Zlib)", ""] {
        assert!(!is_met(not, &allowed), "{not}");
    }
}

#[test]
fn every_dependency_has_an_allowed_licence() {
    let rules = toml("deny.toml");
    let allowed: Vec<&str> =
        rules["licenses"]["allow"].as_array().unwrap().iter().filter_map(|name| name.as_str()).collect();
    let [own, others] = packages();
    for package in own.iter().chain(&others) {
        let licence = package["license"].as_str().unwrap_or_default();
        assert!(is_met(licence, &allowed), "{} {}: licence {licence:?}", package["name"], package["version"]);
    }
}

#[test]
fn no_dependency_needs_a_newer_rust_than_the_workspace_promises() {
    let numbers =
        |version: &str| -> Vec<u32> { version.split('.').map(|part| part.parse().unwrap()).collect() };
    let workspace = &toml("Cargo.toml")["workspace"]["package"];
    let promised = workspace["rust-version"].as_str().unwrap();
    let [own, others] = packages();
    for package in &others {
        let needed = package["rust_version"].as_str().unwrap_or("1.0");
        assert!(numbers(needed) <= numbers(&format!("{promised}.0")), "{} needs {needed}", package["name"]);
    }
    for package in &own {
        assert_eq!(package["rust_version"], promised, "{}", package["name"]);
        assert!(package["description"].is_string(), "{} has no description", package["name"]);
    }
}

/// The code of `places` (files and folders) in the folder of a package, without lines of comment.
fn code(package: &Path, places: &[&str]) -> String {
    let mut open: Vec<PathBuf> = places.iter().map(|place| package.join(place)).collect();
    let mut code = String::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") && path.exists() {
            let text = std::fs::read_to_string(&path).unwrap();
            for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
                if let Some(other) =
                    line.strip_prefix("#[path = \"").and_then(|rest| rest.strip_suffix("\"]"))
                {
                    open.push(path.with_file_name(other));
                }
                code.push_str(line);
                code.push('\n');
            }
        }
    }
    code
}

/// Whether `code` names the crate `name` where a path begins.
fn names(code: &str, name: &str) -> bool {
    let begins = |at: usize| {
        let before = code[..at].chars().next_back();
        !before.is_some_and(|letter| letter.is_alphanumeric() || letter == '_' || letter == ':')
    };
    let path = |at: usize| [":", ";"].iter().any(|end| code[at + name.len()..].starts_with(end));
    code.match_indices(name).any(|(at, _)| begins(at) && path(at))
}

#[test]
fn every_declared_dependency_is_named_in_the_sources() {
    let mut unused = Vec::new();
    for package in &packages()[0] {
        let folder = Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap();
        for dependency in package["dependencies"].as_array().unwrap() {
            let places: &[&str] = match dependency["kind"].as_str() {
                None => &["src"],
                Some("build") => &["build.rs"],
                Some(_) => &["src", "tests", "benches"],
            };
            let name =
                dependency["rename"].as_str().or(dependency["name"].as_str()).unwrap().replace('-', "_");
            if !names(&code(folder, places), &name) {
                unused.push(format!("{}: {name}", package["name"]));
            }
        }
    }
    assert!(unused.is_empty(), "unused: {unused:?}");
    assert!(names("use serde::Serialize;", "serde"));
    assert!(!names("// serde\nuse my_serde::Serialize; crate::serde::x", "serde"));
}
