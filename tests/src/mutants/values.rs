//! Good cases with one value replaced.

use super::Mutant;

/// Cases whose values are replaced: every key of the format, and a scene that runs in a moment.
const CASES: [(&str, &str); 3] = [
    ("everything", include_str!("../../../coordinator/src/case/testdata/everything.toml")),
    ("tank", include_str!("../tank.toml")),
    ("obstacle", include_str!("../../../cases/obstacle.toml")),
];

/// What stands in the place of a value.
const VALUES: [&str; 24] = [
    "nan",
    "inf",
    "-inf",
    "0",
    "-0.0",
    "-1",
    "1e308",
    "-1e308",
    "1e-300",
    "5e-324",
    "1e20",
    "1e-20",
    "9223372036854775807",
    "18446744073709551616",
    "\"\"",
    "\"nonsense\"",
    "\"1/t\"",
    "\"ln(-t)\"",
    "\"sqrt(0.0004-t)\"",
    "\"1e308*1e308\"",
    "\"../../x\"",
    "\"\\u001b[31m\\u0007\"",
    "[]",
    "{}",
];

/// Every case of [`CASES`] with each of its values replaced by each of [`VALUES`].
pub fn replaced() -> Vec<Mutant> {
    let mut mutants = Vec::new();
    for (name, text) in CASES {
        // With servers of its own a case is not examined by those of this workspace.
        let own = |line: &&str| !line.starts_with("fluid_address") && !line.starts_with("solid_command");
        let text: String = text.split_inclusive('\n').filter(own).collect();
        for (number, (from, to)) in values(&text).into_iter().enumerate() {
            for value in VALUES {
                let changed = [&text[..from], value, &text[to..]].concat();
                let name = format!("{name}, value {number} ({}) as {value}", &text[from..to]);
                mutants.push(Mutant { name, text: changed.into_bytes() });
            }
        }
    }
    mutants
}

/// Where the numbers and texts of `text` stand, in bytes.
fn values(text: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let code = line.find('#').map_or(line, |at| &line[..at]);
        if let Some(equals) = code.find('=').filter(|_| !code.starts_with('[')) {
            in_line(code, equals, start, &mut found);
        } else if !code.starts_with('[') || code.contains(',') {
            // A line of a list.
            in_line(code, 0, start, &mut found);
        }
        start += line.len();
    }
    found
}

fn in_line(code: &str, from: usize, start: usize, found: &mut Vec<(usize, usize)>) {
    let bytes = code.as_bytes();
    let part = |k: usize| bytes[k].is_ascii_alphanumeric() || b"_.+-".contains(&bytes[k]);
    let mut k = from;
    while k < bytes.len() {
        let end = if bytes[k] == b'"' {
            code[k + 1..].find('"').map_or(bytes.len(), |at| k + at + 2)
        } else if part(k) {
            (k..bytes.len()).find(|j| !part(*j)).unwrap_or(bytes.len())
        } else {
            k += 1;
            continue;
        };
        let is_key = code[end..].trim_start().starts_with('=');
        if !is_key {
            found.push((start + k, start + end));
        }
        k = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_and_keys_are_not() {
        let text = "name = \"a b\" # 5\n[table]\nx_m = [0.5, -1e3]\ns = { k = 7, t = \"u\" }\nlist = [\n  [1, 2],\n]\n";
        let found: Vec<&str> = values(text).into_iter().map(|(from, to)| &text[from..to]).collect();
        assert_eq!(found, ["\"a b\"", "0.5", "-1e3", "7", "\"u\"", "1", "2"]);
        assert!(replaced().len() > 1700);
    }
}
