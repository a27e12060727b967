//! The rows as tables of `cases/FORMAT.md`.
//!
//! Parameters of solvers and kinds of probes have their own page, `docs/parameters.md`.

use super::{Fallback, KeySpec, Kind, Row, TableSpec, Variant, Variants};

/// Comments around a table that is made of rows: `<!-- keys: NAME -->` and this one.
const END: &str = "<!-- end -->";

/// The page with the tables between its marks made again.
///
/// # Errors
/// The mark that names no table, or that nothing ends.
pub fn renewed(page: &str, root: &'static TableSpec) -> Result<String, String> {
    const START: &str = "<!-- keys: ";
    let (mut made, mut rest) = (String::new(), page);
    while let Some(at) = rest.find(START) {
        let name = rest[at + START.len()..].split(" -->").next().unwrap_or_default();
        let spec = found(root, name, &mut Vec::new()).ok_or(format!("no table is named `{name}`"))?;
        let end = rest[at..].find(END).ok_or(format!("nothing ends the table `{name}`"))?;
        made += &format!("{}{START}{name} -->\n\n{}\n{END}", &rest[..at], table(spec));
        rest = &rest[at + end + END.len()..];
    }
    Ok(made + rest)
}

/// The table `name` in `spec` or in those that it names.
fn found(spec: &'static TableSpec, name: &str, seen: &mut Vec<&'static str>) -> Option<&'static TableSpec> {
    if spec.name == name {
        return Some(spec);
    }
    if seen.contains(&spec.name) {
        return None;
    }
    seen.push(spec.name);
    let of_variants =
        spec.variants.iter().flat_map(|variants| variants.rows).flat_map(|variant| variant.keys);
    spec.keys.iter().chain(of_variants).find_map(|row| match row.kind {
        Kind::Table(inner) | Kind::Tables(inner) => found(inner, name, seen),
        _ => None,
    })
}

/// The tables of all `spec` that `root` names, itself among them.
pub fn names(root: &'static TableSpec) -> Vec<&'static str> {
    let mut seen = Vec::new();
    // No table has this name, so that all are looked at.
    found(root, "", &mut seen);
    seen
}

fn table(spec: &TableSpec) -> String {
    let mut text = String::new();
    let tag = spec.variants.as_ref().map(tag_row);
    if !spec.keys.is_empty() || tag.is_some() {
        text += "| key | meaning | unit | default | range |\n|---|---|---|---|---|\n";
    }
    for row in tag.into_iter().chain(spec.keys.iter().map(Row::from)) {
        text += &line(&row, spec.either);
    }
    match &spec.variants {
        Some(variants) if !variants.rows.is_empty() => text + &variant_table(variants),
        _ => text,
    }
}

fn tag_row(variants: &Variants) -> Row {
    Row {
        key: variants.tag,
        about: variants.about.to_owned(),
        kind: Kind::Text(if variants.rows.is_empty() { "a kind of docs/parameters.md" } else { "see below" }),
        fallback: variants.fallback,
    }
}

/// A line of a table in which exactly one group of `either` is written.
fn line(row: &Row, either: &[&[&str]]) -> String {
    let words: Vec<String> =
        row.words().iter().map(|(word, meaning)| format!("`\"{word}\"`: {}", meaning.trim())).collect();
    let about =
        if words.is_empty() { row.about.clone() } else { format!("{}. {}", row.about, words.join("; ")) };
    let range = if words.is_empty() { row.range() } else { short_range(row) };
    let instead = either.iter().any(|group| group.contains(&row.key)).then(|| {
        let others = either.iter().filter(|group| !group.contains(&row.key));
        others.map(|group| format!(", or `{}`", group.join("` and `"))).collect::<String>()
    });
    let default = match row.fallback {
        Fallback::Required => format!("**req.**{}", instead.unwrap_or_default()),
        _ => row.default(),
    };
    format!("| `{}` | {} | {} | {} | {} |\n", row.key, cell(&about), row.unit(), cell(&default), cell(&range))
}

/// The range of a row whose words stand in its meaning.
fn short_range(row: &Row) -> String {
    match row.kind {
        Kind::NumberOrWord(..) | Kind::CountOrWord(..) => row.range(),
        Kind::SomeWords(_) => "a list of these words".to_owned(),
        _ => "one of these words".to_owned(),
    }
}

fn variant_table(variants: &Variants) -> String {
    let mut text = format!("\n| `{}` | meaning | its keys |\n|---|---|---|\n", variants.tag);
    for variant in variants.rows {
        text += &format!("| `\"{}\"` | {} | {} |\n", variant.word, cell(variant.about), cell(&keys(variant)));
    }
    text
}

/// The keys of a variant in one cell.
fn keys(variant: &Variant) -> String {
    let mut lines: Vec<String> = variant.keys.iter().map(inner_key).collect();
    if variant.set.is_some() {
        lines.push("parameters of docs/parameters.md".to_owned());
    }
    let either = variant.either.iter().map(|group| format!("`{}`", group.join("`, `")));
    let either: Vec<String> = either.collect();
    if !either.is_empty() {
        lines.push(format!("either {}", either.join(" or ")));
    }
    lines.join("; ")
}

fn inner_key(spec: &KeySpec) -> String {
    let row = Row::from(spec);
    let unit = if row.unit() == "-" { String::new() } else { format!(" [{}]", row.unit()) };
    let words: Vec<String> =
        row.words().iter().map(|(word, meaning)| format!("`\"{word}\"` {}", meaning.trim())).collect();
    let words = if words.is_empty() { String::new() } else { format!(" ({})", words.join(", ")) };
    let range = if matches!(row.kind, Kind::Number(_) | Kind::Count(..)) {
        format!(", {}", row.range())
    } else {
        String::new()
    };
    let default = match row.fallback {
        Fallback::Required => String::new(),
        _ => format!(", default {}", row.default()),
    };
    format!("`{}`{unit}: {}{words}{range}{default}", row.key, row.about)
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
