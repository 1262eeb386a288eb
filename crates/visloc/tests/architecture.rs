//! The map of the code in `docs/architecture.md` is the one that holds: crates use only what their row allows, and inside of a crate
//! modules do not use each other in circles.

#![allow(clippy::unwrap_used)]

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

type Graph = BTreeMap<String, BTreeSet<String>>;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Crates by the names of their folders, with what each row of the table lets them use.
fn rows() -> Graph {
    let text = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let table = text.lines().skip_while(|line| !line.starts_with("| crate |")).skip(2);
    let rows = table.take_while(|line| line.starts_with('|')).map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let allowed = cells[2].split(", ").filter(|word| *word != "-");
        (cells[0].trim_matches('`').to_owned(), allowed.map(str::to_owned).collect())
    });
    rows.collect()
}

/// The crates of the project that a crate is built from.
fn dependencies(folder: &Path) -> BTreeSet<String> {
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let lines = manifest.lines().skip_while(|line| *line != "[dependencies]").skip(1);
    let names =
        lines.take_while(|line| !line.starts_with('[')).filter_map(|line| line.strip_prefix("visloc-"));
    names.filter_map(|rest| rest.split(['.', ' ']).next()).map(str::to_owned).collect()
}

#[test]
fn crates_use_what_their_row_allows() {
    let rows = rows();
    let folders = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let names: BTreeSet<String> =
        folders.map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    assert_eq!(rows.keys().cloned().collect::<BTreeSet<_>>(), names, "each crate has a row");
    for (name, allowed) in &rows {
        let used = dependencies(&root().join("crates").join(name));
        assert_eq!(&used, allowed, "what {name} uses, and what its row says");
    }
}

#[test]
fn the_guides_name_files_that_exist() {
    for guide in fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap().path()) {
        let Ok(text) = fs::read_to_string(&guide) else { continue };
        let named = text.split('`').skip(1).step_by(2);
        let is_path = |word: &&str| !word.contains([' ', '\n']) && word.contains("/src");
        for path in named.filter(is_path) {
            let exists = path.starts_with("crates/") && root().join(path).exists();
            assert!(exists, "{} names {path}; paths begin at the project's folder", guide.display());
        }
    }
}

/// All files of Rust below a folder.
fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// The text without comments and without modules of tests, which stand at the end.
fn product_code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let lines = text.lines().take_while(|line| *line != "#[cfg(test)]");
    lines.filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The first names of the paths behind a prefix: `a` of `a::b`, `a` and `c` of `{a::b, c}`.
fn first_names(text: &str, prefix: &str) -> Vec<String> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let name = |text: &str| -> String { text.trim_start().chars().take_while(|c| is_word(*c)).collect() };
    let mut names = Vec::new();
    for (at, _) in text.match_indices(prefix) {
        let rest = &text[at + prefix.len()..];
        if text[..at].ends_with(|c: char| is_word(c) || c == '$') {
            continue;
        }
        let Some(list) = rest.strip_prefix('{') else {
            names.push(name(rest));
            continue;
        };
        let mut depth = 0;
        names.push(name(list));
        for (i, c) in list.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => names.push(name(&list[i + 1..])),
                _ => {}
            }
        }
    }
    // Behind the last comma of a list.
    names.retain(|name| !name.is_empty());
    names
}

/// Which of the top-level modules of a crate use which others.
fn modules(source: &Path) -> Graph {
    let root_files = ["lib.rs", "main.rs"].map(|name| source.join(name));
    let root_file = root_files.into_iter().find(|path| path.exists()).unwrap();
    let mut files = Vec::new();
    sources(source, &mut files);
    files.retain(|path| *path != root_file && path.file_name().unwrap() != "tests.rs");
    let module_of = |path: &Path| -> String {
        let first = path.strip_prefix(source).unwrap().iter().next().unwrap();
        first.to_str().unwrap().trim_end_matches(".rs").to_owned()
    };
    let modules: BTreeSet<String> = files.iter().map(|path| module_of(path)).collect();
    // What the root passes on is named as if it stood there.
    let mut passed_on = BTreeMap::new();
    for statement in product_code(&root_file).split(';') {
        let path = statement.split_once("use ").and_then(|(_, path)| path.split_once("::"));
        if let Some((module, names)) = path {
            let words = names.split(|c: char| !c.is_alphanumeric() && c != '_');
            passed_on.extend(words.map(|word| (word.to_owned(), module.to_owned())));
        }
    }
    let mut graph = Graph::new();
    for path in &files {
        let (module, text) = (module_of(path), product_code(path));
        let mut names = first_names(&text, "crate::");
        if path.parent() == Some(source) {
            names.extend(first_names(&text, "super::"));
        }
        let modules_of = names.into_iter().map(|name| match modules.contains(&name) {
            true => name,
            false => passed_on.get(&name).cloned().unwrap_or(name),
        });
        let used = modules_of.filter(|name| modules.contains(name) && *name != module);
        graph.entry(module.clone()).or_default().extend(used);
    }
    graph
}

/// What can be reached from a module.
fn reachable(graph: &Graph, from: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut waiting = vec![from];
    while let Some(next) = waiting.pop() {
        for used in graph.get(next).into_iter().flatten() {
            if found.insert(used.clone()) {
                waiting.push(used);
            }
        }
    }
    found
}

#[test]
fn modules_do_not_use_each_other_in_circles() {
    let mut circles = Vec::new();
    // slam is next.
    for name in rows().keys().filter(|name| *name != "slam") {
        let graph = modules(&root().join("crates").join(name).join("src"));
        let inside: Vec<_> =
            graph.keys().filter(|module| reachable(&graph, module).contains(*module)).collect();
        if !inside.is_empty() {
            circles.push(format!("{name}: {inside:?}"));
        }
    }
    assert!(circles.is_empty(), "modules that use each other in a circle:\n{}", circles.join("\n"));
}

#[test]
fn names_behind_a_prefix_are_found() {
    let text = "use crate::{a::b, c::{d, e}, f}; let x = crate::g::h(); $crate::no; supercrate::no";
    assert_eq!(first_names(text, "crate::"), ["a", "c", "f", "g"]);
}
