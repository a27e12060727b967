//! The rows as a JSON Schema, by which editors complete, explain and check case files.
//!
//! Draft 7, which all language servers for TOML read. What spans several tables, such as names and the number of
//! dimensions, is left to `check`.

use serde_json::{Map, Value, json};
use sph::setup::Allowed;

use super::{Fallback, Kind, Row, TableSpec, Variant, Variants};

/// The schema of a file whose tables are those of `root`.
pub fn of(root: &'static TableSpec) -> Value {
    let mut definitions = Definitions::default();
    let Value::Object(mut schema) = definitions.table(root) else { return Value::Null };
    let mut finished = Map::new();
    while let Some(spec) = definitions.next() {
        let table = definitions.table(spec);
        finished.insert(spec.name.to_owned(), table);
    }
    schema.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
    schema.insert("title".to_owned(), json!("Tidelock case file"));
    schema.insert("definitions".to_owned(), Value::Object(finished));
    Value::Object(schema)
}

/// The schema as text, as `docs/case.schema.json` holds it.
pub fn text(root: &'static TableSpec) -> String {
    // Maps of texts, numbers and lists only.
    serde_json::to_string_pretty(&of(root)).unwrap_or_default() + "\n"
}

/// Tables that others name.
#[derive(Default)]
struct Definitions {
    named: Vec<&'static TableSpec>,
    written: usize,
}

impl Definitions {
    /// A table that is named and not yet written.
    fn next(&mut self) -> Option<&'static TableSpec> {
        let next = self.named.get(self.written).copied();
        self.written += usize::from(next.is_some());
        next
    }

    fn reference(&mut self, spec: &'static TableSpec) -> Value {
        if !self.named.iter().any(|named| named.name == spec.name) {
            self.named.push(spec);
        }
        json!({ "$ref": format!("#/definitions/{}", spec.name) })
    }

    fn table(&mut self, spec: &'static TableSpec) -> Value {
        let common = spec.described();
        let Some(variants) = &spec.variants else {
            let mut object = self.object(&common, spec.either);
            if spec.or_none
                && let Some(Value::Array(groups)) = object.get_mut("oneOf")
            {
                let any: Vec<Value> =
                    spec.either.concat().iter().map(|key| json!({ "required": [key] })).collect();
                groups.push(json!({ "not": { "anyOf": any } }));
            }
            object.insert("description".to_owned(), json!(spec.about));
            return Value::Object(object);
        };
        let mut options: Vec<Value> =
            variants.rows.iter().map(|variant| self.variant(variants, &common, variant)).collect();
        for probe in variants.probes.iter().copied().flatten() {
            let rows: Vec<Row> =
                common.iter().cloned().chain(probe.arguments.iter().map(Row::from)).collect();
            let about = probe.meaning();
            options.push(self.tagged(variants, probe.word, &about, &rows, &[]));
        }
        // Without the word several may be meant.
        let combined = if matches!(variants.fallback, Fallback::Else(_)) { "anyOf" } else { "oneOf" };
        json!({ "description": spec.about, "type": "object", combined: options })
    }

    fn variant(&mut self, variants: &Variants, common: &[Row], variant: &Variant) -> Value {
        let rows: Vec<Row> = common.iter().cloned().chain(variant.described()).collect();
        self.tagged(variants, variant.word, variant.about, &rows, variant.either)
    }

    fn tagged(
        &mut self,
        variants: &Variants,
        word: &str,
        about: &str,
        rows: &[Row],
        either: &[&[&str]],
    ) -> Value {
        let mut object = self.object(rows, either);
        object.insert("title".to_owned(), json!(word));
        object.insert("description".to_owned(), json!(about));
        let tag = Row {
            key: variants.tag,
            about: format!("{}: {word}, {about}", variants.about.trim_end_matches('.')),
            kind: Kind::Word(&[]),
            fallback: variants.fallback,
        };
        let mut described = described(&tag);
        described.insert("const".to_owned(), json!(word));
        described.insert("x-range".to_owned(), json!(format!("\"{word}\"")));
        described.insert("description".to_owned(), json!(tag.about));
        if let Some(Value::Object(properties)) = object.get_mut("properties") {
            properties.insert(variants.tag.to_owned(), Value::Object(described));
        }
        let may_be_left_out = match variants.fallback {
            Fallback::Required => false,
            Fallback::Word(default) => default == word,
            _ => true,
        };
        if !may_be_left_out && let Some(Value::Array(required)) = object.get_mut("required") {
            required.insert(0, json!(variants.tag));
        }
        Value::Object(object)
    }

    fn object(&mut self, rows: &[Row], either: &[&[&str]]) -> Map<String, Value> {
        let is_alternative = |row: &Row| either.iter().any(|group| group.contains(&row.key));
        let required: Vec<&str> = rows
            .iter()
            .filter(|row| matches!(row.fallback, Fallback::Required) && !is_alternative(row))
            .map(|row| row.key)
            .collect();
        let properties: Map<String, Value> =
            rows.iter().map(|row| (row.key.to_owned(), self.key(row))).collect();
        let mut object = Map::new();
        object.insert("type".to_owned(), json!("object"));
        object.insert("additionalProperties".to_owned(), json!(false));
        object.insert("properties".to_owned(), Value::Object(properties));
        object.insert("required".to_owned(), json!(required));
        if !either.is_empty() {
            let groups: Vec<Value> = either.iter().map(|group| json!({ "required": group })).collect();
            object.insert("oneOf".to_owned(), json!(groups));
        }
        object
    }

    fn key(&mut self, row: &Row) -> Value {
        let mut schema = described(row);
        let form = match row.kind {
            Kind::Table(spec) => json!({ "allOf": [self.reference(spec)] }),
            Kind::Tables(spec) => json!({ "type": "array", "items": self.reference(spec) }),
            kind => form(kind),
        };
        if let Value::Object(form) = form {
            schema.extend(form);
        }
        Value::Object(schema)
    }
}

/// What a row says beside the form of its value.
fn described(row: &Row) -> Map<String, Value> {
    let mut schema = Map::new();
    let mut insert = |key: &str, value: Value| schema.insert(key.to_owned(), value);
    insert("description", json!(row.text()));
    insert("x-unit", json!(row.unit()));
    insert("x-default", json!(row.default()));
    insert("x-range", json!(row.range()));
    match row.fallback {
        Fallback::Number(number) => drop(insert("default", json!(number))),
        Fallback::Count(count) => drop(insert("default", json!(count))),
        Fallback::Flag(flag) => drop(insert("default", json!(flag))),
        Fallback::Word(word) => drop(insert("default", json!(word))),
        Fallback::Required | Fallback::Else(_) => {}
    }
    schema
}

/// The form of a value that is no table.
fn form(kind: Kind) -> Value {
    let enumeration = |words: super::Words| -> Value {
        let words: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        json!({ "type": "string", "enum": words })
    };
    let count = |first: u64, last: u64| json!({ "type": "integer", "minimum": first, "maximum": last });
    let vector = json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 3 });
    let expression = json!({ "type": ["number", "string"] });
    match kind {
        Kind::Number(allowed) => number(allowed),
        Kind::NumberOrWord(allowed, words) => json!({ "anyOf": [number(allowed), enumeration(words)] }),
        Kind::Count(first, last) => count(first, last),
        Kind::CountOrWord(first, last, words) => {
            json!({ "anyOf": [count(first, last), enumeration(words)] })
        }
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Word([]) => json!({ "type": "string" }),
        Kind::Word(words) => enumeration(words),
        Kind::SomeWords(words) => {
            json!({ "type": "array", "items": enumeration(words), "uniqueItems": true })
        }
        Kind::Name => json!({ "type": "string", "pattern": "^[A-Za-z0-9_-]{1,64}$" }),
        Kind::Text(_) => json!({ "type": "string" }),
        Kind::Texts(_) => json!({ "type": "array", "items": { "type": "string" } }),
        Kind::Numbers(allowed) => json!({ "type": "array", "items": number(allowed) }),
        Kind::Vector => vector,
        Kind::Points => json!({ "type": "array", "items": vector }),
        Kind::Spin => json!({ "anyOf": [number(Allowed::FINITE), vector] }),
        Kind::Expression(_) => expression,
        Kind::Expressions(_) => {
            json!({ "type": "array", "items": expression, "minItems": 2, "maxItems": 3 })
        }
        // They are referred to where they stand.
        Kind::Table(_) | Kind::Tables(_) => json!({}),
    }
}

fn number(allowed: Allowed) -> Value {
    let mut schema = Map::from_iter([("type".to_owned(), json!("number"))]);
    let (low, high) = allowed.includes();
    if allowed.lowest > f64::MIN {
        let key = if low { "minimum" } else { "exclusiveMinimum" };
        schema.insert(key.to_owned(), json!(allowed.lowest));
    }
    if allowed.highest < f64::MAX {
        let key = if high { "maximum" } else { "exclusiveMaximum" };
        schema.insert(key.to_owned(), json!(allowed.highest));
    }
    Value::Object(schema)
}
