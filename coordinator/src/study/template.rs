//! Case files with values replaced.

/// The case file `text` with the values at the dotted paths replaced or added; comments are lost.
///
/// # Errors
/// When the text is no TOML, or a path leads through something that is no table or list.
pub fn instantiate(text: &str, changes: &[(String, toml::Value)]) -> Result<String, String> {
    let mut table: toml::Table = text.parse().map_err(|e| format!("{e}"))?;
    for (place, value) in changes {
        set(&mut table, place, value.clone())?;
    }
    toml::to_string(&table).map_err(|e| e.to_string())
}

/// Sets the value at `path`, a dotted path in which numbers index lists and a last `-` appends to one; tables on the
/// way are made.
///
/// # Errors
/// When the path leads through a number or text, or past the end of a list.
pub fn set(table: &mut toml::Table, path: &str, value: toml::Value) -> Result<(), String> {
    let mut steps: Vec<&str> = path.split('.').collect();
    let last = steps.pop().unwrap_or_default();
    let Some((first, rest)) = steps.split_first() else {
        table.insert(last.to_owned(), value);
        return Ok(());
    };
    let empty = || toml::Value::Table(toml::Table::new());
    let mut place = table.entry(*first).or_insert_with(empty);
    for step in rest {
        place = match place {
            toml::Value::Table(table) => table.entry(*step).or_insert_with(empty),
            toml::Value::Array(list) => step
                .parse::<usize>()
                .ok()
                .and_then(|k| list.get_mut(k))
                .ok_or_else(|| format!("`{path}`: the list has no entry `{step}`"))?,
            _ => return Err(format!("`{path}`: `{step}` lies below a plain value")),
        };
    }
    match place {
        toml::Value::Table(table) => {
            table.insert(last.to_owned(), value);
        }
        toml::Value::Array(list) if last == "-" => list.push(value),
        toml::Value::Array(list) => {
            let entry = last.parse::<usize>().ok().and_then(|k| list.get_mut(k));
            *entry.ok_or_else(|| format!("`{path}`: the list has no entry `{last}`"))? = value;
        }
        _ => return Err(format!("`{path}`: `{last}` lies below a plain value")),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_set_in_tables_and_lists() {
        let mut table: toml::Table = "[a]\nb = 1\n[[c]]\nd = [1, 2]\n".parse().unwrap();
        for (path, value) in [("a.b", 5), ("c.0.d.1", 7), ("a.new.deep", 9)] {
            set(&mut table, path, value.into()).unwrap();
        }
        assert_eq!(table["a"]["b"].as_integer(), Some(5));
        assert_eq!(table["c"][0]["d"][1].as_integer(), Some(7));
        assert_eq!(table["a"]["new"]["deep"].as_integer(), Some(9));
        set(&mut table, "c.0.d.-", 8.into()).unwrap();
        assert_eq!(table["c"][0]["d"].as_array().unwrap().len(), 3);
        assert!(set(&mut table, "c.1.d", 1.into()).unwrap_err().contains("no entry `1`"));
        assert!(set(&mut table, "a.b.c", 1.into()).unwrap_err().contains("plain value"));
    }
}
