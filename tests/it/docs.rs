//! The docs as a new user follows them: every command of their `console` blocks runs and prints what they show.
//!
//! A block ` ```yaml file=NAME ` is saved first; ` ```console norun ` is for what needs a machine or the network. Lines that
//! do not begin with `$` are looked for in what the command before them printed, whatever the spaces.

use std::path::{Path, PathBuf};

use crate::cli::run;

pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

pub fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Pages of the book, and the README.
pub fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> = std::fs::read_dir(root().join("docs"))
        .expect("docs")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    pages.push(root().join("README.md"));
    pages.push(root().join("campaigns/README.md"));
    pages.sort();
    pages
}

/// Fenced blocks: what stands behind the fence, and the lines inside.
fn blocks(page: &str) -> Vec<(String, Vec<String>)> {
    let mut blocks: Vec<(String, Vec<String>)> = Vec::new();
    let mut inside = false;
    for line in page.lines() {
        match (line.strip_prefix("```"), inside) {
            (Some(info), false) => {
                blocks.push((info.trim().into(), Vec::new()));
                inside = true;
            }
            (Some(_), true) => inside = false,
            (None, true) => blocks.last_mut().expect("a block").1.push(line.into()),
            (None, false) => {}
        }
    }
    blocks
}

fn plain(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn commands_of_the_docs_run_and_print_what_is_shown() {
    let (mut ran_in_all, mut compared) = (0, 0);
    for page in pages() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut printed = String::new();
        for (info, lines) in blocks(&text(&page)) {
            if let Some(name) = info.split_once("file=").map(|(_, name)| name.trim()) {
                std::fs::write(folder.path().join(name), lines.join("\n") + "\n").expect("written");
            }
            if info != "console" {
                continue;
            }
            let whole = lines.join("\n").replace("\\\n", " ");
            for line in whole.lines() {
                if let Some(command) = line.strip_prefix("$ ") {
                    let command = command.split(" #").next().unwrap_or_default();
                    let mut words = command.split_whitespace().map(|word| word.trim_matches('\''));
                    assert_eq!(words.next(), Some("elastogeo"), "{}: {line}", page.display());
                    let ran = run(folder.path(), &words.collect::<Vec<_>>());
                    assert_eq!(ran.status, 0, "{}: {line}\n{}", page.display(), ran.err);
                    printed = plain(&ran.out);
                    ran_in_all += 1;
                } else if !line.trim().is_empty() && line.trim() != "..." {
                    assert!(printed.contains(&plain(line)), "{}: `{line}` is not in\n{printed}", page.display());
                    compared += 1;
                }
            }
        }
    }
    assert!(ran_in_all > 20 && compared > 20, "{ran_in_all} commands, {compared} lines");
}

#[test]
fn every_page_is_in_the_book_and_every_link_leads_somewhere() {
    let docs = root().join("docs");
    let summary = text(&docs.join("SUMMARY.md"));
    let mut seen = 0;
    for page in pages() {
        let name = page.file_name().expect("a name").to_string_lossy().into_owned();
        if page.starts_with(&docs) && name != "SUMMARY.md" {
            assert_eq!(summary.matches(&format!("]({name})")).count(), 1, "{name} in SUMMARY.md");
        }
        for target in text(&page).split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap_or_default();
            if !file.is_empty() && !file.contains("://") {
                assert!(page.parent().expect("a folder").join(file).exists(), "{name}: {target}");
                seen += 1;
            }
        }
    }
    assert!(seen > 20, "{seen} links");
}

#[test]
fn words_and_all_effects_are_explained() {
    let folder = tempfile::tempdir().expect("a folder");
    let words = [
        "rank",
        "dropped",
        "shrinkage",
        "look-alike",
        "identifiable",
        "registration",
        "Partly Explained",
        "ppm",
        "socket",
        "inclination",
        "references",
        "scatter",
    ];
    let effects = elastogeo::effects::Catalogue::standard();
    for word in words.into_iter().chain(effects.names()).chain(["outliers"]) {
        let ran = run(folder.path(), &["explain", word]);
        assert!(ran.status == 0 && ran.out.len() > 100, "{word}: {}{}", ran.out, ran.err);
        assert!(!ran.out.contains("\n## "), "{word} holds the next page:\n{}", ran.out);
    }
    for column in ["approach", "approach.q1", "order", "session", "contact", "ry", "sigma", "U95", "load_point", "set"]
    {
        let ran = run(folder.path(), &["explain", column]);
        assert!(ran.status == 0 && ran.out.len() > 60, "{column}: {}{}", ran.out, ran.err);
    }
    let list = run(folder.path(), &["explain"]);
    assert!(list.out.contains("rank") && list.out.contains("outliers"), "{}", list.out);
    for (word, expected) in [("shrinkge", "did you mean `shrinkage`?"), ("zzzzzzzz", "`elastogeo explain` lists")] {
        let ran = run(folder.path(), &["explain", word]);
        assert!(ran.status == 2 && ran.err.contains(expected) && ran.out.is_empty(), "{word}: {}", ran.err);
    }
}

/// Rows of the table whose header begins with `| first`, as cells.
fn table(page: &str, first: &str) -> Vec<Vec<String>> {
    let header = format!("| {first} ");
    let rows = page.lines().skip_while(|line| !line.starts_with(&header)).take_while(|line| line.starts_with('|'));
    rows.skip(2).map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().into()).collect()).collect()
}

/// Code spans of a cell.
fn code(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

#[test]
fn the_house_is_drawn_as_it_is_built() {
    let page = text(&root().join("docs/design.md"));
    let rows = table(&page, "floor");
    let drawn: Vec<Vec<&str>> = rows.iter().rev().map(|row| code(&row[1])).collect();
    assert_eq!(drawn, crate::architecture::FLOORS, "the floors of docs/design.md, from the ground up");
    let module = |entry: std::fs::DirEntry| entry.file_name().to_string_lossy().trim_end_matches(".rs").to_string();
    for entry in std::fs::read_dir(root().join("src")).expect("a folder") {
        let module = module(entry.expect("an entry"));
        let known = drawn.iter().flatten().any(|name| *name == module);
        assert!(known || ["lib", "main"].contains(&module.as_str()), "{module} stands on no floor of docs/design.md");
    }
}

/// Names of all tests: `module::function`.
fn tests() -> Vec<String> {
    let mut names = Vec::new();
    let mut folders = vec![root().join("tests/it")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let module = path.file_stem().expect("a name").to_string_lossy().into_owned();
                let source = text(&path);
                let functions = source.split("fn ").skip(1).filter_map(|rest| rest.split('(').next());
                names.extend(functions.map(|name| format!("{module}::{name}")));
            }
        }
    }
    names
}

/// The tables of what to touch name files that exist and tests that do it.
#[test]
fn what_to_touch_to_add_something_exists() {
    let page = text(&root().join("docs/design.md"));
    let (rows, tests) = (table(&page, "to add"), tests());
    assert!(rows.len() > 4, "{} rows", rows.len());
    for row in rows {
        for file in code(&row[1]).into_iter().filter(|name| name.contains('/')) {
            let file = if file.contains("NAME") { file.rsplit_once('/').expect("a folder").0 } else { file };
            assert!(root().join(file).exists(), "{}: there is no {file}", row[0]);
        }
        let shown = code(&row[2]);
        assert!(!shown.is_empty(), "{}: no test shows it", row[0]);
        for command in shown {
            let name = command.strip_prefix("cargo test ").expect("a test");
            assert!(tests.iter().any(|test| test.contains(name)), "{}: no test is called {name}", row[0]);
        }
    }
}

/// Every `cargo test NAME` of the docs and of the records of figures finds a test.
#[test]
fn tests_that_the_docs_name_exist() {
    let tests = tests();
    let records = std::fs::read_dir(root().join("docs/figures")).expect("records");
    let records = records
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "txt"));
    let mut seen = 0;
    for page in pages().into_iter().chain(records) {
        for name in text(&page).split("cargo test ").skip(1) {
            let name: String = name.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
            if !name.is_empty() {
                assert!(tests.iter().any(|test| test.contains(&name)), "{}: no test is called {name}", page.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 15, "{seen} tests named");
}
