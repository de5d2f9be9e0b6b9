//! Content that cannot be meant: no command puts a figure at the head of it, and the mistake is named where it can be.

use std::path::Path;

use serde_json::Value;

use super::cli::{Ran, run};

/// A table of readings: its columns, and its cells by row.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn column(&self, name: &str) -> usize {
        self.names.iter().position(|known| known == name).unwrap_or_else(|| panic!("a column {name}"))
    }

    /// Multiplies columns.
    fn scale(&mut self, names: &[&str], factor: f64) {
        for name in names {
            let column = self.column(name);
            for row in &mut self.rows {
                let value: f64 = row[column].parse().expect("a number");
                row[column] = (value * factor).to_string();
            }
        }
    }

    fn swap(&mut self, a: &str, b: &str) {
        let (a, b) = (self.column(a), self.column(b));
        self.rows.iter_mut().for_each(|row| row.swap(a, b));
    }

    /// Moves the cells of columns up by one row, the first one to the end.
    fn shift(&mut self, names: &[&str]) {
        let all = self.rows.clone();
        for name in names {
            let column = self.column(name);
            for (k, row) in self.rows.iter_mut().enumerate() {
                row[column].clone_from(&all[(k + 1) % all.len()][column]);
            }
        }
    }
}

/// Changes the measurements of the campaign in a folder.
fn spoil(campaign: &Path, change: impl Fn(&mut Table)) {
    let path = campaign.join("measurements.csv");
    let text = std::fs::read_to_string(&path).expect("text");
    let cells = |line: &str| line.split(',').map(String::from).collect::<Vec<_>>();
    let mut lines = text.lines();
    let names = cells(lines.next().expect("a header"));
    let mut table = Table { names, rows: lines.map(cells).collect() };
    change(&mut table);
    let lines = std::iter::once(table.names.join(",")).chain(table.rows.iter().map(|row| row.join(",")));
    std::fs::write(&path, lines.collect::<Vec<_>>().join("\n") + "\n").expect("written");
}

/// A folder with the campaign that `init` makes in `c`.
fn starter() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "c"]).status, 0);
    folder
}

fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}:\n{}{}", ran.out, ran.err))
}

/// The diagnostics of a code.
fn of_code(found: &Value, code: &str) -> Vec<Value> {
    let all = found["diagnostics"].as_array().expect("a list");
    all.iter().filter(|diagnostic| diagnostic["code"] == code).cloned().collect()
}

/// A command refuses a campaign for one reason, and says these words.
fn refuses(folder: &Path, arguments: &[&str], code: &str, words: &[&str]) {
    let ran = run(folder, &[arguments, &["--format", "json"]].concat());
    assert_eq!(ran.status, 2, "{arguments:?}: {}{}", ran.out, ran.err);
    let found = of_code(&json(&ran), code);
    assert!(!found.is_empty(), "{arguments:?}: no {code}\n{}", ran.out);
    assert_eq!(found[0]["severity"], "error");
    let message = found[0]["message"].as_str().expect("words");
    words.iter().for_each(|word| assert!(message.contains(word), "`{word}`: {message}"));
}

/// A mistake, its code, and what is said of it.
type Mistake = (fn(&mut Table), &'static str, &'static [&'static str]);

/// Mistakes in the table of the starter, whose base and marker are unknown.
const MISTAKES: &[Mistake] = &[
    (|t| t.scale(&["x", "y", "z"], 1e-3), "wrong-units", &["readings times 1000", "in m, and declared in mm"]),
    (|t| t.scale(&["x", "y", "z"], 1e3), "wrong-units", &["readings times 0.001", "um, and declared in mm"]),
    (|t| t.scale(&["x", "y", "z"], 1.0 / 25.4), "wrong-units", &["readings times 25.4", "inches"]),
    (|t| t.scale(&["x", "y", "z"], 0.1), "wrong-units", &["readings times 10 ", "in cm"]),
    (
        |t| t.scale(&["q1", "q2", "q3", "q4", "q5", "q6"], std::f64::consts::PI / 180.0),
        "wrong-units",
        &["joint angles read as rad", "joint columns in rad"],
    ),
    (|t| t.scale(&["q4"], -1.0), "misread", &["with `q4` negated", "from 111 to 1.7", "wrong sign?"]),
    (|t| t.scale(&["q2"], -1.0), "misread", &["with `q2` negated"]),
    (|t| t.scale(&["q4", "q6"], -1.0), "misread", &["with `q4` negated and `q6` negated"]),
    (|t| t.swap("q4", "q6"), "misread", &["with `q4` and `q6` exchanged", "columns swapped?"]),
    (|t| t.scale(&["y"], -1.0), "misread", &["one axis of the readings mirrored", "left-handed"]),
    (|t| t.swap("x", "y"), "misread", &["one axis of the readings mirrored", "two axes exchanged"]),
    (|t| t.shift(&["x", "y", "z"]), "misread", &["joints of the row after", "rows shifted by one?"]),
];

#[test]
fn mistakes_in_a_table_are_named() {
    let sound = starter();
    for (change, code, words) in MISTAKES {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path().join("c");
        std::fs::create_dir(&at).expect("a folder");
        for name in ["campaign.yaml", "robot.yaml", "measurements.csv"] {
            std::fs::copy(sound.path().join("c").join(name), at.join(name)).expect("copied");
        }
        spoil(&at, change);
        refuses(folder.path(), &["check", "c"], code, words);
    }
}

/// Each command refuses; with `--force` the doubt stands before the figure, in text, JSON and report.
#[test]
fn every_command_refuses_what_cannot_be_meant() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |table| table.scale(&["q4"], -1.0));
    let words = ["with `q4` negated", "wrong sign?"];
    for arguments in [
        &["identify", "c", "--save", "i.yaml"][..],
        &["register", "c", "--save", "r.yaml"],
        &["diagnose", "c", "--apply", "d.yaml"],
        &["report", "c"],
    ] {
        refuses(at, arguments, "misread", &words);
    }
    for name in ["i.yaml", "r.yaml", "d.yaml", "report.html"] {
        assert!(!at.join(name).exists(), "{name}");
    }
    let forced = run(at, &["identify", "c", "--save", "i.yaml", "--force"]);
    assert_eq!(forced.status, 0, "{}", forced.err);
    let [doubt, headline] = ["DOUBTFUL (misread)", "mm calibrated"].map(|word| forced.out.find(word).expect("said"));
    assert!(doubt < headline && forced.err.contains("warning: with `q4` negated"), "{}{}", forced.out, forced.err);
    assert!(at.join("i.yaml").exists());
    let found = json(&run(at, &["identify", "c", "--force", "--format", "json"]));
    assert_eq!(of_code(&found, "misread")[0]["severity"], "warning");
    assert_eq!(run(at, &["report", "c", "--force"]).status, 0);
    let page = std::fs::read_to_string(at.join("report.html")).expect("a page");
    let [doubt, answer] = ["class=\"doubt\"", "id=\"answer\""].map(|word| page.find(word).expect("there"));
    assert!(doubt < answer);
}

/// With base and tool known each axis and each marker counts, and a base that is not where it is described is named.
#[test]
fn mistakes_with_a_known_base_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "universal-ur5", "--poses", "30", "--observes", "pose", "--into"];
    let mistakes: &[Mistake] = &[
        (|t| t.swap("x", "y"), "misread", &["x and y of the readings exchanged"]),
        (|t| t.scale(&["z"], -1.0), "misread", &["z of the readings negated"]),
        (|t| t.scale(&["x", "y", "z"], 1e-3), "wrong-units", &["readings times 1000"]),
        (
            |t| {
                let x = t.column("x");
                for row in &mut t.rows {
                    row[x] = (row[x].parse::<f64>().expect("a number") + 800.0).to_string();
                }
            },
            "misread",
            &["with the base estimated"],
        ),
    ];
    for (k, (change, code, words)) in mistakes.iter().enumerate() {
        let name = format!("c{k}");
        assert_eq!(run(at, &[&made[..], &[&name]].concat()).status, 0);
        spoil(&at.join(&name), change);
        refuses(at, &["check", &name], code, words);
    }
}

/// The units of the campaign file itself.
#[test]
fn readings_in_mm_that_are_declared_in_m() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "universal-ur5", "--poses", "40", "--observes", "pose", "--into", "p"];
    assert_eq!(run(at, &made).status, 0);
    let path = at.join("p/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("text");
    assert!(text.contains("length: mm"));
    std::fs::write(&path, text.replace("length: mm", "length: m")).expect("written");
    refuses(
        at,
        &["identify", "p", "--save", "x.yaml"],
        "wrong-units",
        &["readings times 0.001", "in mm, and declared in m"],
    );
    assert!(!at.join("x.yaml").exists());
}

/// A description that is another robot's is refused although nothing explains it.
#[test]
fn another_robot_is_unlike_its_description() {
    let folder = starter();
    let at = folder.path();
    let path = at.join("c/robot.yaml");
    let text = std::fs::read_to_string(&path).expect("text");
    let other = text.replace("d: 600", "d: 1100").replace("r: 640", "r: 300").replace("d: 150", "d: 410");
    assert_ne!(text, other);
    std::fs::write(&path, other).expect("written");
    refuses(at, &["identify", "c"], "unlike-description", &["none of", "other ways"]);
}

/// What is sound is never doubted: bundled campaigns, and those of practice.
#[test]
fn sound_campaigns_are_not_doubted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seen = 0;
    for folder in ["campaigns", "tests/data/practice"] {
        for entry in std::fs::read_dir(root.join(folder)).expect("a folder") {
            let path = entry.expect("an entry").path();
            if !path.join("campaign.yaml").exists() {
                continue;
            }
            let ran = run(root, &["check", &path.display().to_string(), "--format", "json"]);
            assert_eq!(ran.status, 0, "{}", ran.err);
            for code in CODES {
                assert!(of_code(&json(&ran), code).is_empty(), "{}: {}", path.display(), ran.err);
            }
            seen += 1;
        }
    }
    assert!(seen >= 14, "{seen} campaigns");
}

/// Codes of doubt.
const CODES: &[&str] = &["wrong-units", "misread", "unlike-description"];
