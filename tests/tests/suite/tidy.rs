//! Rules of the source tree that no compiler holds.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use tests::source_tree::{files, root};
use tests::tidy::{Sources, circles_of};

/// The `src` folders of all crates.
fn crates() -> Vec<PathBuf> {
    let manifests = files("toml").into_iter().filter(|path| path.ends_with("Cargo.toml"));
    let found: Vec<PathBuf> =
        manifests.map(|path| path.with_file_name("src")).filter(|path| path.is_dir()).collect();
    assert!(found.len() >= 9, "{found:?}");
    found
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// `path` from the root of the repository.
fn short(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

#[test]
fn no_two_files_import_each_other_in_a_circle() {
    let mut circles = Vec::new();
    for folder in crates() {
        let of_crate = circles_of(&Sources::read(&folder).imports());
        circles
            .extend(of_crate.into_iter().map(|circle| format!("{}: {}", short(&folder), circle.join(", "))));
    }
    assert!(circles.is_empty(), "files that import each other in a circle:\n  {}", circles.join("\n  "));
}

#[test]
fn a_circle_is_found_behind_groups_renames_and_exports() {
    let sources = Sources::of([
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::{c::C, b::{self, B as Other}}; struct A;"),
        ("b.rs", "pub use inner::Deep; mod inner;"),
        ("b/inner.rs", "use super::super::c; pub struct Deep;"),
        ("c.rs", "// use crate::none;\nfn f() { crate::b::Deep::new() }"),
    ]);
    assert_eq!(circles_of(&sources.imports()), [["b::inner", "c"].map(String::from)]);
}

#[test]
fn tests_inside_a_file_and_its_children_make_no_circle() {
    let sources = Sources::of([
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "pub struct A; #[cfg(test)] mod tests { use crate::b::B; fn f() { '}'; \"}\"; } }"),
        ("b.rs", "use crate::a::A; mod child; pub struct B;"),
        ("b/child.rs", "use super::B;"),
    ]);
    assert_eq!(circles_of(&sources.imports()), [[""; 0]; 0]);
}

/// Lines below `folder` that contain one of `words`, comments apart, in files other than those of `allowed`.
fn lines_with(folder: &str, words: &[&str], allowed: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for path in files("rs").into_iter().filter(|path| path.starts_with(root().join(folder).join("src"))) {
        let name = short(&path);
        if allowed.iter().any(|part| name.contains(part)) {
            continue;
        }
        for (k, line) in read(&path).lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            if words.iter().any(|word| code.contains(word)) {
                found.push(format!("{name}:{}: {}", k + 1, line.trim()));
            }
        }
    }
    found
}

#[test]
fn physics_knows_no_transport_files_or_clocks() {
    let foreign = ["tokio", "tonic", "prost", "proto::", "std::fs", "std::net", "std::process", "SystemTime"];
    for folder in ["sph", "fluid-server/physics", "solid-server/physics"] {
        assert_eq!(lines_with(folder, &foreign, &[]), [""; 0], "{folder}");
        // The driver measures how long it waits, and so does each part of a fluid.
        assert_eq!(lines_with(folder, &["Instant"], &["coupling/driver", "src/team/"]), [""; 0], "{folder}");
    }
    // The rule can fail: the transport is full of it.
    assert!(lines_with("proto", &foreign, &[]).len() > 100);
}

#[test]
fn only_the_command_line_of_the_coordinator_knows_clap() {
    assert_eq!(lines_with("coordinator", &["clap"], &["src/cli/"]), [""; 0]);
    assert!(!lines_with("coordinator", &["clap"], &[]).is_empty());
}

#[test]
fn paths_that_the_architecture_names_exist() {
    let text = read(&root().join("ARCHITECTURE.md"));
    let names = text.split('`').skip(1).step_by(2).chain(text.split("](").skip(1).filter_map(link));
    let paths: BTreeSet<&str> = names.filter(|name| is_path(name)).collect();
    assert!(paths.len() > 20, "{paths:?}");
    let missing: Vec<_> = paths.into_iter().filter(|path| !root().join(path).exists()).collect();
    assert_eq!(missing, [""; 0]);
}

/// The target of a link whose text ended before `rest`, without its anchor.
fn link(rest: &str) -> Option<&str> {
    let target = &rest[..rest.find(')')?];
    Some(target.split('#').next().unwrap_or(target))
}

fn is_path(name: &str) -> bool {
    let top =
        ["sph/", "proto/", "fluid-server/", "solid-server/", "coordinator/", "tests/", "docs/", "terminal/"];
    let place = top.iter().any(|folder| name.starts_with(folder)) || name.ends_with(".md");
    place && !name.contains(' ')
}

#[test]
fn the_page_on_one_half_step_names_ten_functions_that_exist() {
    let folder = root().join("docs");
    let text = read(&folder.join("half_step.md"));
    let functions = linked_functions(&text);
    assert!((5..=10).contains(&functions.len()), "{functions:?}");
    let missing: Vec<_> =
        functions.into_iter().filter(|(name, target)| !defines(&folder.join(target), name)).collect();
    assert!(missing.is_empty(), "names without their function: {missing:?}");
}

/// Names and targets of the links to sources in `text`, each written ``[`name`](target)``.
fn linked_functions(text: &str) -> BTreeSet<(&str, &str)> {
    let ends = text.match_indices("](").map(|(at, end)| (&text[..at], &text[at + end.len()..]));
    let links = ends.filter_map(|(before, rest)| Some((before, link(rest)?)));
    let to_sources = links.filter(|(_, target)| target.ends_with(".rs"));
    let named = to_sources.map(|(before, target)| {
        let name = before.strip_suffix('`').and_then(|before| before.rsplit_once("[`"));
        (name.unwrap_or_else(|| panic!("the link to `{target}` names no function")).1, target)
    });
    named.collect()
}

/// Whether the file at `path` defines the function that `name` ends with.
fn defines(path: &Path, name: &str) -> bool {
    let definition = format!("fn {}", name.rsplit("::").next().unwrap_or(name));
    let source = if path.is_file() { read(path) } else { String::new() };
    source.split(&definition).skip(1).any(|rest| rest.starts_with(['(', '<']))
}

#[test]
fn a_link_to_a_function_that_does_not_exist_is_found() {
    let text = "[`Runner::step`](../a.rs), [page](b.md), [`run`](../c.rs#L1) and [`run`](../c.rs)";
    let expected = BTreeSet::from([("Runner::step", "../a.rs"), ("run", "../c.rs")]);
    assert_eq!(linked_functions(text), expected);
    let here = root().join("tests/tests/suite/tidy.rs");
    assert!(defines(&here, "Type::defines"));
    // Part of a name is no name.
    assert!(!defines(&here, "define"));
    assert!(!defines(&here.with_extension("none"), "defines"));
}

/// Documents for readers, beside comments and messages in sources.
fn documents() -> Vec<PathBuf> {
    let kinds = ["md", "proto", "py", "toml", "rs"];
    let found: Vec<PathBuf> = kinds.into_iter().flat_map(files).collect();
    assert!(found.len() > 300);
    found
}

#[test]
fn every_equation_that_is_cited_is_one_of_the_source_paper() {
    let (mut cited, mut unknown) = (0, Vec::new());
    for path in documents() {
        for (k, line) in read(&path).lines().enumerate() {
            for (at, _) in line.match_indices("Eq. (") {
                let number = line[at + 5..].split(')').next().unwrap_or_default();
                cited += 1;
                // Where the tag itself is explained.
                let tag = number == "n";
                if !tag && !number.parse().is_ok_and(|n: u32| (1..=33).contains(&n)) {
                    unknown.push(format!("{}:{}: {number}", short(&path), k + 1));
                }
            }
        }
    }
    // This file quotes the tag itself.
    unknown.retain(|place| !place.contains("suite/tidy.rs"));
    assert!(cited > 100, "{cited}");
    assert_eq!(unknown, [""; 0]);
}

/// Words that say less than the field's own, or lean on a source that readers do not know.
const AVOIDED: [&str; 13] = [
    "tells of",
    " told ",
    " anew",
    "goes on",
    "dearer",
    "guilty",
    " waters",
    "booked",
    "the document's",
    "the document ",
    "by the letter",
    "nobody",
    "the letter of",
];

#[test]
fn documents_help_and_messages_use_the_words_of_the_field() {
    let mut found = Vec::new();
    for path in documents() {
        let name = short(&path);
        if name.ends_with("suite/tidy.rs") {
            continue;
        }
        for (k, line) in read(&path).lines().enumerate() {
            let lower = format!(" {} ", line.to_lowercase());
            found.extend(
                AVOIDED
                    .iter()
                    .filter(|word| lower.contains(**word))
                    .map(|word| format!("{name}:{}: `{}`", k + 1, word.trim())),
            );
        }
    }
    assert!(found.is_empty(), "{} places:\n  {}", found.len(), found.join("\n  "));
}
