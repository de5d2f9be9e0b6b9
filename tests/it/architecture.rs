//! The floors of the house: a module imports from lower floors only, never from a neighbour.

use std::path::Path;

/// Floors from the ground up; modules on one floor do not know each other. The same picture is in `docs/design.md`.
const FLOORS: &[&[&str]] = &[
    &["math", "parameter", "diagnostic"],
    &["least_squares", "observation"],
    &["description"],
    &["elements"],
    &["model", "process"],
    &["kinematics"],
    &["elastics"],
    &["fuzzy"],
    &["effects"],
    &["prediction"],
    &["identifiability"],
    &["estimation"],
    &["simulation"],
    &["diagnosis", "compensation", "planning", "scene"],
    &["blind", "review"],
    &["snapshot", "error"],
    &["render", "files"],
    &["cli"],
];

fn floor_of(path: &str) -> Option<(usize, &'static str)> {
    let mut best: Option<(usize, &'static str)> = None;
    for (floor, modules) in FLOORS.iter().enumerate() {
        for module in *modules {
            let inside = path == *module || path.starts_with(&format!("{module}::"));
            if inside && best.is_none_or(|(_, known)| module.len() > known.len()) {
                best = Some((floor, module));
            }
        }
    }
    best
}

fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn modules_import_from_lower_floors_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut diagnostics = Vec::new();
    let mut seen = 0;
    for file in files {
        let relative = file.strip_prefix(&root).expect("inside").with_extension("");
        let module = relative.to_string_lossy().replace('/', "::").replace("::mod", "");
        if module == "lib" || module == "main" {
            continue;
        }
        let Some((floor, own)) = floor_of(&module) else {
            diagnostics.push(format!("src/{} stands on no floor", relative.display()));
            continue;
        };
        let text = std::fs::read_to_string(&file).expect("a file");
        let code: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
        for piece in code.join("\n").split("crate::").skip(1) {
            let used: String = piece.chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c)).collect();
            let Some((below, other)) = floor_of(used.trim_end_matches(':')) else { continue };
            seen += 1;
            if other != own && below >= floor {
                diagnostics.push(format!("{module} (floor {floor}) uses {used} (floor {below})"));
            }
        }
    }
    assert!(seen > 100, "the uses were found: {seen}");
    assert!(diagnostics.is_empty(), "{}", diagnostics.join("\n"));
}
