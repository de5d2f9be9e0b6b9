//! Floors of the architecture: a module imports from lower floors only, never from a neighbour; and no files import from each
//! other in a circle, be it inside a folder.

mod imports;

use std::path::Path;

use imports::{Imports, circles};

/// Floors from the ground up; modules on one floor do not know each other. The same picture is in `docs/design.md`.
pub const FLOORS: &[&[&str]] = &[
    &["math", "parameter", "diagnostic", "settings"],
    &["least_squares", "observation"],
    &["description"],
    &["elements"],
    &["model", "process"],
    &["kinematics"],
    &["fuzzy"],
    &["elastics"],
    &["effects"],
    &["state"],
    &["prediction"],
    &["identifiability"],
    &["estimation"],
    &["simulation", "noise"],
    &["diagnosis", "compensation", "planning", "scene"],
    &["snapshot", "tracking", "error", "plausibility"],
    &["blind"],
    &["review"],
    &["results"],
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

fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

#[test]
fn modules_import_from_lower_floors_only() {
    let imports = Imports::of(&root());
    let (mut faults, mut seen) = (Vec::new(), 0);
    let module = |file: &str| file.trim_end_matches(".rs").replace('/', "::").trim_end_matches("::mod").to_string();
    for (file, others) in imports.edges() {
        if file == "lib.rs" || file == "main.rs" {
            continue;
        }
        let Some((floor, own)) = floor_of(&module(file)) else {
            faults.push(format!("src/{file} stands on no floor"));
            continue;
        };
        for other in others {
            let Some((below, its)) = floor_of(&module(other)) else { continue };
            seen += 1;
            if its != own && below >= floor {
                faults.push(format!("{file} (floor {floor}) uses {other} (floor {below})"));
            }
        }
    }
    assert!(seen > 300, "the imports were found: {seen}");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Of the blind bench only these may know what is judged: they put questions to the diagnosis, and score it.
const SCORING: &[&str] = &[
    "blind/examine.rs",
    "blind/examined.rs",
    "blind/reliability.rs",
    "blind/score.rs",
    "blind/tied.rs",
    "blind/mod.rs",
];

#[test]
fn what_is_sealed_is_drawn_without_effects_and_diagnosis() {
    let imports = Imports::of(&root());
    let edges = imports.edges();
    let is_judged = |file: &str| ["effects/", "diagnosis/", "plausibility/"].iter().any(|own| file.starts_with(own));
    let is_scoring = |file: &str| SCORING.contains(&file) && file != "blind/mod.rs";
    let drawn: Vec<_> =
        edges.iter().filter(|(file, _)| file.starts_with("blind/") && !SCORING.contains(file)).collect();
    assert!(drawn.iter().any(|(file, _)| file.starts_with("blind/workshop/")) && drawn.len() > 8, "{drawn:?}");
    for (file, others) in drawn {
        for other in others {
            assert!(!is_judged(other) && !is_scoring(other), "{file} uses {other}");
        }
        // The catalogue hangs on the model as well.
        let text = std::fs::read_to_string(root().join(file)).expect("a file");
        assert!(!text.contains(".catalogue"), "{file} looks into the catalogue");
    }
}

#[test]
fn no_files_import_from_each_other_in_a_circle() {
    for root in [root(), Path::new(env!("CARGO_MANIFEST_DIR")).join("python/src")] {
        let imports = Imports::of(&root);
        let edges = imports.edges();
        assert!(edges.values().any(|others| !others.is_empty()), "the imports were found: {}", root.display());
        let shown: Vec<String> = circles(&edges)
            .iter()
            .map(|circle| {
                let inside = |file: &&&str| circle.contains(*file);
                let arrows = circle.iter().map(|file| {
                    let to: Vec<&str> = edges[file].iter().filter(inside).copied().collect();
                    format!("  {file} -> {}", to.join(", "))
                });
                format!("{} files import from each other:\n{}", circle.len(), arrows.collect::<Vec<_>>().join("\n"))
            })
            .collect();
        assert!(shown.is_empty(), "{}", shown.join("\n"));
    }
}

#[test]
fn a_circle_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    std::fs::create_dir(folder.path().join("a")).expect("a folder");
    write("lib.rs", "pub mod a; pub mod c;");
    write("a/mod.rs", "mod x; mod y; pub use x::X; pub use y::Y;");
    write("a/x.rs", "use super::Y; pub struct X(Y);");
    write("a/y.rs", "pub struct Y; fn f() { let _ = crate::c::g(); }");
    write("c.rs", "pub fn g() {}");
    let imports = Imports::of(folder.path());
    assert!(circles(&imports.edges()).is_empty());
    write("c.rs", "pub fn g() -> crate::a::X { todo!() }");
    let imports = Imports::of(folder.path());
    assert_eq!(circles(&imports.edges()), [vec!["a/x.rs", "a/y.rs", "c.rs"]]);
}
