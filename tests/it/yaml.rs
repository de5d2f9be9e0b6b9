//! Reading of YAML: every fault of a text in one run, each where it stands.

use elastogeo::description::yaml::{self, Document};
use elastogeo::diagnostic::Diagnostic;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;

#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
struct Robot {
    robot: Option<String>,
    units: BTreeMap<String, String>,
    frames: BTreeMap<String, Frame>,
    markers: Vec<Marker>,
    free: Vec<String>,
    gravity: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
struct Frame {
    antecedent: Option<String>,
    alpha: Option<f64>,
    d: Option<f64>,
    joint: Option<Joint>,
    passive: Option<bool>,
    turns: Option<u32>,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
struct Marker {
    name: Option<String>,
    at: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum Joint {
    Revolute,
    Prismatic,
    Screw { pitch: f64 },
}

const SAMPLE: &str = "\
# a robot
robot: two arms
units: {length: mm, angle: deg}
base: &stiff {alpha: 1.5}
frames:
  1: {antecedent: 0, alpha: 90, joint: revolute}
  3':
    antecedent: 1
    d: .inf
    joint: {screw: {pitch: 2e-3}}
  E: {<<: {alpha: 3}, antecedent: \"3'\", passive: true, turns: 3}
markers:
  - name: wrist
    at: 1.5
  - {name: 'el\u{e9}ment', at: -2}
free: [3.alpha, E.r]
gravity: [0, 0, -9.81]
";

fn read(text: &str) -> (Option<Robot>, Document, Vec<Diagnostic>) {
    yaml::read("robot.yaml", text)
}

/// Each diagnostic as `line:column message | remedy`, with its related places.
fn reported(text: &str) -> String {
    let mut told = String::new();
    for diagnostic in read(text).2 {
        let at = diagnostic.place.as_ref().map_or("?".into(), |place| format!("{}:{}", place.line, place.column));
        let _ = write!(told, "{at} {}", diagnostic.message);
        for (place, why) in &diagnostic.related {
            let _ = write!(told, " ({}:{} {why})", place.line, place.column);
        }
        let _ = writeln!(told, " | {}", diagnostic.remedy.unwrap_or_default());
    }
    told
}

fn sample() -> String {
    SAMPLE.lines().filter(|line| !line.starts_with("base:")).map(|line| format!("{line}\n")).collect()
}

#[test]
fn a_sound_text_reads_whole() {
    let (robot, document, diagnostics) = read(&sample());
    assert_eq!(diagnostics, []);
    let robot = robot.unwrap();
    let names: Vec<&str> = robot.frames.keys().map(String::as_str).collect();
    assert_eq!(names, ["1", "3'", "E"]);
    assert_eq!(robot.frames["1"].antecedent, Some(String::from("0")));
    assert_eq!(robot.frames["E"].alpha, Some(3.0));
    assert_eq!(robot.frames["3'"].d, Some(f64::INFINITY));
    let place = document.place_of_value(&["frames", "3'", "antecedent"]).unwrap();
    assert_eq!((place.line, place.column, &place.excerpt[place.highlight.clone()]), (7, 17, "1"));
    let place = document.place_of_key(&["frames", "3'"]).unwrap();
    assert_eq!((place.line, place.column, &place.excerpt[place.highlight.clone()]), (6, 3, "3'"));
    let place = document.place_of_value(&["frames", "3'", "joint", "screw", "pitch"]).unwrap();
    assert_eq!((place.line, place.column), (9, 28));
    let place = document.place_of_value(&["markers", "1", "at"]).unwrap();
    assert_eq!((place.line, place.column, &place.excerpt[place.highlight.clone()]), (14, 27, "-2"));
    // What is not there is shown at the nearest thing above it.
    let place = document.place_of_value(&["frames", "3'", "r", "x"]).unwrap();
    assert_eq!((place.line, place.column), (6, 3));
    assert!(document.has(&["frames", "E", "alpha"]), "through the merge key");
    assert!(!document.has(&["frames", "E", "beta"]));
}

#[test]
fn every_fault_is_found_in_one_run() {
    let text = "\
robt: x
units: {length: mm, length: m}
frames:
  1: {antecedent: [0], alpha: 90deg, joint: revolut}
  3':
    antecdent: 1
    d: 1,5
    joint:
      scrw: {pitch: 2e-3}
    passive: yes
    turns: -1
  E:
    alpha:
      - 3
    joint: {screw: {}}
  1: {d: 1_000}
markers:
  - name: wrist
    at: near
  - {nme: 3, at: inf}
  - 5
gravity: [0, 0]
";
    insta::assert_snapshot!(reported(text));
}

#[test]
fn blanking_one_entry_leaves_the_others() {
    let (robot, document, diagnostics) =
        read("frames:\n  1:\n    d: x\n  2: {d: y, alpha: 3, zz: [1,\n    2], turns: 4}\n");
    let robot = robot.unwrap();
    assert_eq!(diagnostics.len(), 3);
    assert_eq!(robot.frames["1"], Frame::default());
    assert_eq!(robot.frames["2"], Frame { alpha: Some(3.0), turns: Some(4), ..Frame::default() });
    assert!(document.is_faulty(&["frames", "2", "d"]) && !document.is_faulty(&["frames", "2", "alpha"]));
    assert!(document.has(&["frames", "1", "d"]), "what was replaced is still there to be pointed at");
}

#[test]
fn aliases_and_merges_are_seen_through() {
    assert_eq!(
        reported(
            "frames:\n  1: &a {d: 1, turns: 2}\n  2: {<<: *a, d: no}\n  3: *a\nrobot: &n x\nmarkers: [{at: *n}]\n"
        ),
        "3:18 `frames.2.d` must be a number, found `no` | \n6:16 `markers.0.at` must be a number, found `*n` (5:11 what is repeated stands here) | \n"
    );
    let (_, document, _) = read("frames:\n  1: &a {d: 1}\n  3: *a\n");
    assert_eq!(document.place_of_value(&["frames", "3", "d"]).unwrap().line, 2);
}

/// Runs on a small stack, as a thread of a pool would.
fn small_stack(job: impl FnOnce() + Send + 'static) {
    std::thread::Builder::new().stack_size(2 << 20).spawn(job).unwrap().join().unwrap();
}

#[test]
fn hostile_texts_are_refused_with_a_place() {
    small_stack(|| {
        let n = 10_000;
        let nested = |open: &str, close: &str| format!("a: {}1{}", open.repeat(n), close.repeat(n));
        let stairs = |step: &str| (0..n).map(|i| format!("{}{step}\n", " ".repeat(i))).collect::<String>();
        let bomb = (1..9).fold("a0: &a0 [1, 1]\n".to_owned(), |text, i| {
            format!("{text}a{i}: &a{i} [{}]\n", vec![format!("*a{}", i - 1); 9].join(", "))
        });
        let deep =
            [nested("[", "]"), nested("{a: ", "}"), stairs("a:"), "- ".repeat(n), "? ".repeat(n), nested("[", "")];
        for text in &deep {
            let told = reported(text);
            assert!(told.contains("nested more than 64 levels deep"), "{told}");
            assert_eq!(told.lines().count(), 1);
        }
        assert!(reported(&bomb).contains("with its aliases written out"), "{}", reported(&bomb));
        let lines: String = (0..20_000).map(|i| format!("k{i}: {i}\n")).collect();
        assert!(reported(&lines).contains("unknown key `k0`"));
        assert!(read(&lines).2.len() <= 101);
    });
}

#[test]
fn what_is_not_yaml_is_reported_once_where_it_stands() {
    let texts = [
        "",
        "# nothing\n",
        "---\n~\n",
        "robot: x\n---\nrobot: y\n",
        "robot: 'x\nframes: 3\n",
        "robot: \"x\n",
        "frames:\n\t1: {}\n",
        "frames: {1: {d: 3}\nrobot: x\n",
        "frames: [1}\n",
        "robot: a: b\n",
        "robot: @x\n",
        "  robot: x\nfree: [1]\n",
        "robot: *x\n",
        "free: &f [*f]\n",
        "robot\nfree: []\n",
        "robot: 'x' y\n",
        "robot: \"\\q\"\n",
        "gravity: !deg [1]\n",
        "5\n",
        "[1, 2]\n",
        "frames: {~: {}}\n",
        "frames: {[1]: {}}\n",
        "free: ]\n",
        "robot: x\r\nfree: {\r\n",
    ];
    let all: Vec<String> = texts.iter().map(|text| format!("{text:?}\n{}", reported(text))).collect();
    insta::assert_snapshot!(all.join(""));
}

#[test]
fn bytes_become_text_or_a_diagnostic() {
    let reported = |bytes: &[u8]| {
        let diagnostic = yaml::text_of("f", bytes).unwrap_err();
        let place = diagnostic.place.unwrap();
        format!("{}:{} {} | {}", place.line, place.column, diagnostic.message, diagnostic.remedy.unwrap())
    };
    assert_eq!(yaml::text_of("f", b"\xef\xbb\xbfa: 1\r\n").unwrap(), "a: 1\r\n");
    assert_eq!(reported(b"a: 1\n\xc3\xa9\xe9: 2\n"), "2:2 the byte 0xe9 is not UTF-8 | save the file as UTF-8");
    assert_eq!(reported(b"a: 1\nb\0"), "2:2 a NUL byte stands here; the file is not a text | save the file as UTF-8");
    assert!(reported(b"\xff\xfea\0").starts_with("1:1 the file is in UTF-16"));
    assert!(reported(b"a\0:\0").starts_with("1:1 the file is in UTF-16"));
    assert!(reported(b"ab\xc3").starts_with("1:3 the byte 0xc3"));
}

fn roundtrip<T: Serialize + serde::de::DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T) {
    let text = yaml::write(value).unwrap();
    let (back, _, diagnostics) = yaml::read::<T>("back", &text);
    assert_eq!(diagnostics, [], "{text}");
    assert_eq!(back.as_ref(), Some(value), "{text}");
}

#[test]
fn what_is_written_reads_back() {
    let odd = [
        "1",
        "3'",
        "yes",
        "no",
        "null",
        "~",
        "",
        " a",
        "a ",
        "1e5",
        ".inf",
        "-.inf",
        ".nan",
        "0x10",
        "0o7",
        "012",
        "1_000",
        "true",
        "a: b",
        "- x",
        "-",
        "?",
        ":",
        "#c",
        "a #c",
        "<<",
        "=",
        "2001-01-01",
        "1:30",
        "a\nb",
        "a\n",
        "\n",
        "\t",
        "a\tb",
        "*a",
        "&a",
        "!a",
        "%a",
        "@a",
        "`a",
        "{",
        "[a]",
        "'",
        "\"",
        "\\",
        "\u{1}",
        "\u{85}",
        "\u{2028}",
        "\u{feff}",
        "---",
        "...",
        "\u{e9}",
        "y",
    ];
    let frames = |name: &str| BTreeMap::from([(String::from(name), Frame::default())]);
    for text in odd {
        roundtrip(&Robot {
            robot: Some(text.into()),
            frames: frames(text),
            free: vec![text.into(), text.into()],
            ..Robot::default()
        });
    }
    let floats = [
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e300,
        f64::MAX,
        f64::MIN_POSITIVE,
        5e-324,
        0.1,
        1.0,
        -1e16,
        123_456_789.123_456_79,
    ];
    for d in floats {
        roundtrip(&Robot {
            gravity: Some([d, -d, 0.0]),
            markers: vec![Marker { at: Some(d), ..Marker::default() }],
            ..Robot::default()
        });
    }
    let screw =
        Frame { joint: Some(Joint::Screw { pitch: 2e-3 }), antecedent: Some(String::from("0")), ..Frame::default() };
    roundtrip(&Robot { frames: BTreeMap::from([(String::from("1"), screw)]), ..Robot::default() });
    assert_eq!(yaml::write(&BTreeMap::from([("d", 0.1 + 0.2)])).unwrap(), "d: 0.30000000000000004\n");
}

proptest! {
    #[test]
    fn any_text_and_number_reads_back(text in "\\PC*|[ -~\n\t]*", d in proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL) {
        let marker = Marker { name: Some(text.clone()), at: Some(d) };
        roundtrip(&Robot { robot: Some(text.clone()), markers: vec![marker], units: [(text.clone(), text)].into(), ..Robot::default() });
    }
}

#[test]
fn a_name_is_a_text_or_a_whole_number() {
    for (text, name) in
        [("antecedent: 01", "01"), ("antecedent: '1'", "1"), ("antecedent: E", "E"), ("antecedent: 3'", "3'")]
    {
        assert_eq!(yaml::read::<Frame>("f", text).0.unwrap().antecedent, Some(String::from(name)));
    }
    assert!(yaml::read::<Frame>("f", "antecedent: [1]").2.len() == 1);
}

#[test]
fn mutated_texts_are_read_or_refused_with_a_place() {
    small_stack(|| {
        let pieces = [
            ":", " ", "\n", "- ", "{", "}", "[", "]", ",", "'", "\"", "#", "&a ", "*a", "!x ", "|\n", "> ", "? ", "\t",
            "~", "3", "x", ".inf", "\u{e9}", "\r\n", "---\n", "%", "<<: ", "1: ", "\\", "\r", "\u{2028}",
        ];
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let base = [
            SAMPLE.to_owned(),
            sample(),
            "frames: {1: &a {d: 1}, 2: *a}\nmarkers: [{at: 1}, {<<: {at: 2}}]\n".to_owned(),
        ];
        let (mut sound, mut several) = (0, 0);
        for _ in 0..6_000 {
            let mut text = base[random.random_range(0..base.len())].clone();
            for _ in 0..random.random_range(1..5) {
                let boundaries: Vec<usize> = text.char_indices().map(|(at, _)| at).chain([text.len()]).collect();
                let start = random.random_range(0..boundaries.len());
                let end = (start + random.random_range(0..4)).min(boundaries.len() - 1);
                text.replace_range(boundaries[start]..boundaries[end], pieces[random.random_range(0..pieces.len())]);
            }
            let (robot, document, diagnostics) = read(&text);
            sound += usize::from(diagnostics.is_empty());
            several += usize::from(diagnostics.len() > 2);
            assert!(robot.is_some() || !diagnostics.is_empty(), "{text}");
            let lines = 1 + text.matches('\n').count();
            for diagnostic in &diagnostics {
                let place = diagnostic.place.as_ref().unwrap_or_else(|| panic!("no place: {diagnostic:?} in\n{text}"));
                assert!((1..=lines).contains(&place.line), "{diagnostic:?} in\n{text}");
            }
            for path in [&["frames", "E", "alpha"][..], &["markers", "1", "at"], &["gravity", "2"], &[]] {
                assert!(!document.has(path) || document.place_of_value(path).is_some());
                document.place_of_key(path);
            }
            elastogeo::render::diagnostics::render(&diagnostics, false);
        }
        assert!(sound > 100 && several > 100, "{sound} sound, {several} with several faults");
    });
}
