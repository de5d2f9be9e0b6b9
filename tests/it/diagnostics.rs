//! Diagnostics as they are shown.

use elastogeo::diagnostic::{Code, Diagnostic, Diagnostics, Place};
use elastogeo::render::diagnostics::render;

#[test]
fn diagnostics_look_like_a_compilers() {
    let text = "frames:\n  1: {antecedent: 0}\n  2: {antecedent: 33}\n\tx: \u{1b}[31m\n";
    let at = |word: &str| {
        let start = text.rfind(word).unwrap();
        Place::in_text("robot.yaml", text, start..start + word.len())
    };
    let diagnostics = [
        Diagnostic::error("unknown frame `33`").at(at("33")).suggest("33", ["1", "2", "3'"]),
        Diagnostic::error("`1` is given twice").at(at("2:")).related(Some(at("1:")), "first given here"),
        Diagnostic::warning("odd \u{1b}[0m text").at(at("\u{1b}[31m")),
        Diagnostic::error("no such file").remedy("check the path"),
        Diagnostic::warning("place only").at(Place { excerpt: String::new(), highlight: 3..9, ..at("33") }),
    ];
    insta::assert_snapshot!(render(&diagnostics, false));
    let colored = render(&diagnostics, true);
    assert!(colored.contains("\u{1b}["), "colours were asked for");
    assert!(!render(&diagnostics, false).contains('\u{1b}'), "no escape reaches a pipe");
    assert_eq!(render(&[], false), "");
}

#[test]
fn a_long_line_is_cut_around_what_is_meant() {
    let line = format!("{}needle{}", "\u{e9},".repeat(30_000), ";x".repeat(30_000));
    let start = line.find("needle").unwrap();
    let place = Place::in_text("long.csv", &line, start..start + 6);
    assert_eq!((place.line, place.column), (1, 60_001));
    assert_eq!(&place.excerpt[place.highlight.clone()], "needle");
    // A place that was not cut when made is cut when drawn.
    let whole = Place { excerpt: line.clone(), highlight: start..start + 6, ..place.clone() };
    for place in [place, whole] {
        let text = render(&[Diagnostic::error("found").at(place)], false);
        assert!(text.contains("long.csv:1:60001"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() < 220), "{text}");
        let shown = text.lines().find(|line| line.contains("needle")).unwrap();
        let marked = text.lines().find(|line| line.contains("^^^^^^")).unwrap();
        let column = |line: &str, word: &str| line.split(word).next().unwrap().chars().count();
        assert_eq!(column(shown, "needle"), column(marked, "^"));
    }
}

#[test]
fn no_place_breaks_the_drawing() {
    let excerpts = ["", "\n", "a", "\u{e9}\u{e9}\r\nb\n", "x\n\n\ny", "\t\tz", "\u{4f60}\u{597d}"];
    for excerpt in excerpts {
        for start in 0..8 {
            for end in 0..8 {
                let place =
                    Place { column: 2, excerpt: excerpt.into(), highlight: start..end, ..Place::line_of("f", 7) };
                let diagnostic = Diagnostic::error("m").at(place.clone()).related(Some(place), "why");
                assert!(render(&[diagnostic], false).contains("f:7:2"), "{excerpt:?} {start}..{end}");
                let _ = Place::in_text("f", excerpt, start..end);
            }
        }
    }
}

/// As an error of a user's program, and as data for another one.
#[test]
fn diagnostics_are_an_error_and_serialise() {
    let place = Place::in_text("robot.yaml", "frames:\n  2: {antecedent: 33}\n", 25..27);
    let unknown = Diagnostic::error("unknown frame `33`").at(place).suggest("33", ["3"]);
    let diagnostics: Diagnostics = [Diagnostic::warning("odd"), unknown].into_iter().collect();
    let error: Box<dyn std::error::Error> = diagnostics.clone().into_result().unwrap_err().into();
    let text = "warning: odd\nrobot.yaml:2:18: error: unknown frame `33` (did you mean `3`?)";
    assert_eq!(error.to_string(), text);
    let json = serde_json::to_value(&diagnostics).unwrap();
    assert_eq!(json[0]["code"], "doubtful");
    assert_eq!(json[1]["severity"], "error");
    assert_eq!((&json[1]["code"], &json[1]["at"]["line"]), (&"unknown".into(), &2.into()));
    assert!(Diagnostics::from(Diagnostic::warning("odd")).into_result().is_ok());
}

/// Each code has its section in the docs, which `explain` prints.
#[test]
fn every_code_is_explained() {
    let page = std::fs::read_to_string(format!("{}/docs/diagnostics.md", env!("CARGO_MANIFEST_DIR"))).expect("a page");
    let folder = tempfile::tempdir().expect("a folder");
    for code in Code::ALL {
        assert!(page.contains(&format!("\n## `{}`\n\n", code.name())), "{}", code.name());
        let ran = super::cli::run(folder.path(), &["explain", code.name()]);
        assert_eq!(ran.status, 0, "{}: {}", code.name(), ran.err);
    }
    assert_eq!(page.matches("\n## ").count(), Code::ALL.len());
}
