//! The source tree as text: which files import which, and what they say.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module as its path within the crate; the crate's root is empty.
type Module = Vec<String>;

/// The modules of a crate and what their files say, without comments, strings and tests.
pub struct Sources(BTreeMap<Module, String>);

impl Sources {
    /// All sources below `folder`, the `src` of a crate.
    ///
    /// # Panics
    /// When one cannot be read.
    pub fn read(folder: &Path) -> Self {
        let mut found = BTreeMap::new();
        let mut open = vec![folder.to_owned()];
        while let Some(folder_or_file) = open.pop() {
            if folder_or_file.is_dir() {
                let entries = std::fs::read_dir(&folder_or_file).expect("a folder of sources is readable");
                open.extend(entries.map(|entry| entry.expect("an entry is readable").path()));
            } else if folder_or_file.extension().is_some_and(|extension| extension == "rs") {
                let path = folder_or_file.strip_prefix(folder).expect("it is inside");
                let text = std::fs::read_to_string(&folder_or_file).expect("a source is readable");
                if let Some(module) = module_of(&path.to_string_lossy()) {
                    found.insert(module, without_tests(&code_of(&text)));
                }
            }
        }
        Self(found)
    }

    /// Sources given as path and text.
    ///
    /// # Panics
    /// When a path is that of a test.
    pub fn of<const N: usize>(files: [(&str, &str); N]) -> Self {
        let modules = files.map(|(path, text)| (module_of(path).unwrap(), without_tests(&code_of(text))));
        Self(BTreeMap::from(modules))
    }

    /// For every module those that it names, its ancestors and descendants apart.
    pub fn imports(&self) -> BTreeMap<String, BTreeSet<String>> {
        let exports: BTreeMap<&Module, Vec<(String, Module)>> =
            self.0.iter().map(|(module, text)| (module, self.exports(module, text))).collect();
        let mut imports = BTreeMap::new();
        for (module, text) in &self.0 {
            let mut of_module = BTreeSet::new();
            for path in paths_in(text) {
                let Some(target) = self.resolve(module, &path, &exports, 0) else { continue };
                if !target.starts_with(module) && !module.starts_with(&target) {
                    of_module.insert(target.join("::"));
                }
            }
            imports.insert(module.join("::"), of_module);
        }
        imports
    }

    /// Names that `module` makes public from elsewhere, with their paths from the crate's root.
    fn exports(&self, module: &Module, text: &str) -> Vec<(String, Module)> {
        let mut found = Vec::new();
        for statement in use_trees(text) {
            for (path, name) in statement {
                if let Some(absolute) = self.absolute(module, &path) {
                    found.push((name, absolute));
                }
            }
        }
        found
    }

    /// A path of `module` from the crate's root; nothing for other crates.
    fn absolute(&self, module: &Module, path: &[String]) -> Option<Module> {
        let (first, rest) = path.split_first()?;
        let mut absolute = match first.as_str() {
            "crate" => Vec::new(),
            "self" => module.clone(),
            "super" => module[..module.len().checked_sub(1)?].to_vec(),
            child => {
                let mut inner = module.clone();
                inner.push(child.to_owned());
                return self.0.contains_key(&inner).then(|| [module.as_slice(), path].concat());
            }
        };
        for segment in rest {
            match segment.as_str() {
                "super" => drop(absolute.pop()),
                "self" => {}
                other => absolute.push(other.to_owned()),
            }
        }
        Some(absolute)
    }

    /// The module whose file defines what `path`, seen from `module`, names.
    fn resolve(
        &self,
        module: &Module,
        path: &[String],
        exports: &BTreeMap<&Module, Vec<(String, Module)>>,
        depth: usize,
    ) -> Option<Module> {
        let absolute = self.absolute(module, path)?;
        let longest = (0..=absolute.len()).rev().find(|n| self.0.contains_key(&absolute[..*n]))?;
        let target = absolute[..longest].to_vec();
        let item = absolute.get(longest);
        let export = exports.get(&target).and_then(|names| names.iter().find(|(name, _)| Some(name) == item));
        match export {
            Some((_, from)) if depth < 8 => {
                let mut path = vec!["crate".to_owned()];
                path.extend(from.iter().cloned());
                self.resolve(&target, &path, exports, depth + 1).or(Some(target))
            }
            _ => Some(target),
        }
    }
}

/// The module that the file at `path` holds; nothing for files of tests and programs.
fn module_of(path: &str) -> Option<Module> {
    let mut module: Module = path.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if module.iter().any(|part| part == "tests" || part == "bin") {
        return None;
    }
    if matches!(module.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        module.pop();
    }
    Some(module)
}

/// `text` with comments, strings and characters left out.
fn code_of(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        if rest.starts_with("//") {
            rest = rest.find('\n').map_or("", |end| &rest[end..]);
        } else if let Some(inner) = rest.strip_prefix("/*") {
            rest = inner.find("*/").map_or("", |end| &inner[end + 2..]);
        } else if c == '"' {
            rest = after_string(&rest[1..]);
        } else if rest.starts_with("r\"") || rest.starts_with("r#\"") {
            let hashes = usize::from(rest.starts_with("r#"));
            let close = if hashes == 1 { "\"#" } else { "\"" };
            let inner = &rest[2 + hashes..];
            rest = inner.find(close).map_or("", |end| &inner[end + close.len()..]);
        } else if c == '\'' {
            // A character, unless it is a lifetime.
            let mut characters = rest[1..].char_indices();
            let (first, second) = (characters.next(), characters.next());
            match (first, second) {
                (Some((_, '\\')), _) => rest = rest[3..].find('\'').map_or("", |end| &rest[end + 4..]),
                (Some(_), Some((at, '\''))) => rest = &rest[at + 2..],
                _ => rest = &rest[1..],
            }
        } else {
            code.push(c);
            rest = &rest[c.len_utf8()..];
        }
    }
    code
}

/// What follows the end of a string.
fn after_string(mut rest: &str) -> &str {
    loop {
        match rest.find(['"', '\\']) {
            None => return "",
            Some(at) if rest[at..].starts_with('"') => return &rest[at + 1..],
            Some(at) => rest = rest.get(at + 2..).unwrap_or(""),
        }
    }
}

/// `code` without items for tests.
fn without_tests(code: &str) -> String {
    let mut kept = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find("#[cfg(test)]") {
        kept.push_str(&rest[..at]);
        let item = &rest[at..];
        let end = match item.find(['{', ';']) {
            Some(open) if item[open..].starts_with('{') => open + closing(&item[open..]),
            Some(semicolon) => semicolon + 1,
            None => item.len(),
        };
        rest = &item[end..];
    }
    kept + rest
}

/// Where the brace that opens `text` is closed.
fn closing(text: &str) -> usize {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    text.len()
}

/// Every path that `code` names: those of `use` and those in expressions and types.
fn paths_in(code: &str) -> Vec<Vec<String>> {
    let mut paths: Vec<Vec<String>> = use_trees(code).into_iter().flatten().map(|(path, _)| path).collect();
    for keyword in ["crate::", "super::", "self::"] {
        for (at, _) in code.match_indices(keyword) {
            if code[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != ':') {
                paths.push(path_at(&code[at..]));
            }
        }
    }
    paths
}

fn path_at(text: &str) -> Vec<String> {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').unwrap_or(text.len());
    text[..end].split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

/// The paths of each `use`, groups spread, with the name by which each is known.
fn use_trees(code: &str) -> Vec<Vec<(Vec<String>, String)>> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("use ") {
        let before = code[..at].trim_end().chars().next_back();
        if code[..at].chars().next_back().is_none_or(|c| c.is_whitespace() || c == ';' || c == '}')
            && before.is_none_or(|c| ";}])bew{,".contains(c) || c.is_alphanumeric())
            && let Some(end) = code[at..].find(';')
        {
            let mut paths = Vec::new();
            spread(&code[at + 4..at + end], &[], &mut paths);
            found.push(paths);
        }
    }
    found
}

fn spread(tree: &str, prefix: &[String], paths: &mut Vec<(Vec<String>, String)>) {
    let tree = tree.trim();
    if let Some(open) = tree.find('{') {
        let mut inner = prefix.to_vec();
        inner.extend(path_at(tree[..open].trim()));
        let (mut depth, mut start) = (0, open + 1);
        let body = &tree[..tree.rfind('}').unwrap_or(tree.len())];
        for (at, c) in body.char_indices().skip_while(|(at, _)| *at <= open) {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    spread(&body[start..at], &inner, paths);
                    start = at + 1;
                }
                _ => {}
            }
        }
        spread(&body[start..], &inner, paths);
    } else if !tree.is_empty() {
        let (path, name) = tree.split_once(" as ").map_or((tree, None), |(path, name)| (path, Some(name)));
        let mut full = prefix.to_vec();
        full.extend(path_at(path.trim()));
        if full.last().is_some_and(|last| last == "self") && full.len() > 1 {
            full.pop();
        }
        let own = full.last().cloned().unwrap_or_default();
        paths.push((full, name.map_or(own, |name| name.trim().to_owned())));
    }
}

/// Groups of more than one module that reach each other.
pub fn circles_of(imports: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reached: BTreeMap<&String, BTreeSet<&String>> = imports
        .keys()
        .map(|start| {
            let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
            while let Some(module) = open.pop() {
                for next in imports.get(module).into_iter().flatten() {
                    if seen.insert(next) {
                        open.push(next);
                    }
                }
            }
            (start, seen)
        })
        .collect();
    let mut circles: Vec<Vec<String>> = Vec::new();
    for (module, seen) in &reached {
        if seen.contains(module) && !circles.iter().flatten().any(|known| known == *module) {
            let together =
                reached.iter().filter(|(other, back)| seen.contains(**other) && back.contains(*module));
            circles.push(together.map(|(other, _)| (*other).clone()).collect());
        }
    }
    circles
}
