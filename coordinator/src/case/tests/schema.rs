//! The rows of keys: schema, documents and reader say the same.

use std::collections::BTreeSet;

use super::shipped::{EVERYTHING, cases};
use super::spatial::TANK as SPATIAL;
use super::*;
use crate::case::errors::ErrorList;
use crate::case::file::{CASE, CaseFile};
use crate::case::notation;
use crate::case::reader::Table;
use crate::case::spec::read::Key;
use crate::case::spec::{TableSpec, document, read, schema};

/// Compares `page` with what the rows say, or writes it with `UPDATE_DOCS`.
fn is_current(path: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == text, "{} is not what the rows say: run the test with UPDATE_DOCS=1", path.display());
}

#[test]
fn the_schema_in_the_documents_is_that_of_the_program() {
    is_current("docs/case.schema.json", &schema::text(&CASE));
}

#[test]
fn the_format_page_has_the_tables_of_the_rows() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/FORMAT.md");
    let page = std::fs::read_to_string(path).unwrap();
    is_current("cases/FORMAT.md", &document::renewed(&page, &CASE).unwrap());
    // Every table of keys stands on the page, or its keys on that of the parameters.
    for name in document::names(&CASE) {
        assert!(page.contains(&format!("<!-- keys: {name} -->")), "`{name}` is not in cases/FORMAT.md");
    }
}

#[test]
fn every_shipped_case_names_the_schema() {
    for path in cases() {
        let text = std::fs::read_to_string(&path).unwrap();
        let named = text.lines().next().and_then(|line| line.strip_prefix("#:schema ")).unwrap_or_default();
        let schema = path.parent().unwrap().join(named);
        assert!(!named.is_empty() && schema.ends_with("docs/case.schema.json"), "{}", path.display());
        assert!(schema.is_file(), "{}", path.display());
    }
}

/// All keys that rows describe, with the words on which they depend; parameters and arguments of probes apart, whose
/// rows are read as they are.
fn described(spec: &'static TableSpec, found: &mut BTreeSet<Key>, seen: &mut Vec<&'static str>) {
    if seen.contains(&spec.name) {
        return;
    }
    seen.push(spec.name);
    let variants = || spec.variants.iter().flat_map(|variants| variants.rows);
    found.extend(spec.keys.iter().map(|row| (spec.name, None, row.key)));
    found.extend(
        variants()
            .flat_map(|variant| variant.keys.iter().map(|row| (spec.name, Some(variant.word), row.key))),
    );
    for row in spec.keys.iter().chain(variants().flat_map(|variant| variant.keys)) {
        if let crate::case::spec::Kind::Table(inner) | crate::case::spec::Kind::Tables(inner) = row.kind {
            described(inner, found, seen);
        }
    }
}

/// What no case above writes.
const OTHERS: [(&str, &str); 4] = [
    ("[domain]", "start_from = \"nowhere\"\npreset = \"paper\"\n[domain]"),
    ("name = \"block\"", "name = \"block\"\nlayout = \"fitted\""),
    (
        "[[wall]]",
        "[checkpoint]\nevery_steps = 5\nevery_wall_s = 60\nmax_restarts = 1\n[deadlines]\nsilence_s = 20\ncall_s = 30\n\
         open_s = 300\nstep_s = 60\ndisk_s = 60\n[servers]\nfluid_address = \"a:1\"\nsolid_address = \"a:2\"\n\
         fluid_command = [\"a\"]\nsolid_command = [\"a\"]\nca_file = \"a\"\ncert_file = \"b\"\nkey_file = \"c\"\n\
         token_file = \"d\"\n[[wall]]\nlayout = \"fitted\"",
    ),
    (
        "step = { type = \"fixed\", time_step_s = 1e-5 }",
        "step = { type = \"adaptive\", exact_outputs = true, exact_times_s = [0.1] }",
    ),
];

/// What no case in the plane with the recommended settings writes.
const PLANE: [(&str, &str); 2] = [
    ("[fluid]", "[interface]\nrepulsion = 1\n[fluid]"),
    (
        "{ type = \"rectangle\", lower_m = [0.05, 0.15], upper_m = [0.11, 0.21] }",
        "{ type = \"union\", parts = [{ type = \"polygon\", file = \"a.csv\" }, \
         { type = \"outline\", file = \"a.dxf\", unit = \"mm\", layer = \"0\", tolerance_m = 1e-5, angle_rad = 0, \
         by_m = [0, 0] }] }",
    ),
];

/// What no case in space writes.
const SPACE: [(&str, &str); 2] = [
    ("motion = { ", "motion = { displacement_z_m = 0, "),
    (
        "{ type = \"box\", lower_m = [0.3, 0.06, 0.0], upper_m = [0.38, 0.14, 0.08] }",
        "{ type = \"intersection\", parts = [\
         { type = \"cone\", from_m = [0, 0, 0], to_m = [0, 0, 1], radius_from_m = 1, radius_to_m = 0 }, \
         { type = \"half-space\", point_m = [0, 0, 0], normal = [0, 0, 1] }, \
         { type = \"placed\", axis = [0, 0, 1], angle_rad = 1, by_m = [0, 0, 0], shape = \
         { type = \"torus\", centre_m = [0, 0, 0], axis = [0, 0, 1], radius_m = 1, tube_radius_m = 0.1 } }, \
         { type = \"surface\", file = \"a.stl\", unit = \"m\", defects = \"refuse\" }] }",
    ),
];

/// Reads the tables of a case and lays nothing out.
fn read_rows(text: &str, folder: &Path) {
    let errors = ErrorList::default();
    let document = notation::parse(text, &errors).unwrap();
    drop(CaseFile::read(Table::root(&CASE, document.get_ref(), text, folder, &errors)));
}

#[test]
fn every_row_is_of_a_key_that_is_read() {
    let mut rows = BTreeSet::new();
    described(&CASE, &mut rows, &mut Vec::new());
    for path in cases() {
        read_rows(&std::fs::read_to_string(&path).unwrap(), path.parent().unwrap());
    }
    let (plane, space) = (tank_with(&PLANE), changed(SPATIAL, &SPACE));
    for text in [EVERYTHING, SPATIAL, &tank_with(&OTHERS), &plane, &space] {
        read_rows(text, Path::new(env!("CARGO_MANIFEST_DIR")));
    }
    // A key common to all words of a table counts for any of them.
    let read: BTreeSet<Key> = read::keys()
        .into_iter()
        .flat_map(|(table, word, key)| [(table, word, key), (table, None, key)])
        .collect();
    let unread: Vec<&Key> = rows.difference(&read).collect();
    assert!(unread.is_empty(), "no case of the tests writes, or the reader does not take: {unread:#?}");
    assert!(rows.len() > 120, "{}", rows.len());
}

#[test]
fn every_key_has_description_unit_default_and_range() {
    fn visit(value: &serde_json::Value, path: &str, count: &mut usize) {
        let serde_json::Value::Object(object) = value else { return };
        if let Some(serde_json::Value::Object(properties)) = object.get("properties") {
            for (key, schema) in properties {
                for word in ["description", "x-unit", "x-default", "x-range"] {
                    let text = schema.get(word).and_then(|text| text.as_str()).unwrap_or_default();
                    assert!(!text.trim_matches('.').is_empty(), "{path}.{key} has no {word}");
                }
                *count += 1;
            }
        }
        for (key, inner) in object {
            match inner {
                serde_json::Value::Array(list) => list.iter().for_each(|inner| visit(inner, path, count)),
                inner => visit(inner, &format!("{path}.{key}"), count),
            }
        }
    }
    let mut count = 0;
    visit(&schema::of(&CASE), "", &mut count);
    assert!(count > 250, "{count} keys");
}

#[test]
fn units_of_the_schema_are_those_that_parameters_state() {
    use sph::setup::{ElasticParameters, FluidParameters, ParameterSet, TotalLagrangian, UpdatedLagrangian};
    let rows = [
        FluidParameters::SPECIFICATIONS,
        ElasticParameters::SPECIFICATIONS,
        TotalLagrangian::SPECIFICATIONS,
        UpdatedLagrangian::SPECIFICATIONS,
    ];
    for row in rows.into_iter().flatten() {
        let meaning = row.meaning();
        let stated = meaning.split_once('[').and_then(|(_, rest)| rest.split_once(']')).map(|(unit, _)| unit);
        if let (Some(stated), sph::setup::Kind::Number(_)) = (stated, row.kind) {
            assert_eq!(crate::case::spec::unit(row.key), stated, "{}", row.key);
        }
    }
}
