//! Content that cannot be meant: no command puts a figure at the head of it, and the mistake is named where it can be.

use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use serde_json::Value;

use super::cli::{Ran, run};

/// A table of readings: its columns, and its cells by row.
pub(super) struct Table {
    pub(super) names: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Table {
    pub(super) fn column(&self, name: &str) -> usize {
        self.names.iter().position(|known| known == name).unwrap_or_else(|| panic!("a column {name}"))
    }

    /// Multiplies columns.
    pub(super) fn scale(&mut self, names: &[&str], factor: f64) {
        for name in names {
            let column = self.column(name);
            for row in &mut self.rows {
                let value: f64 = row[column].parse().expect("a number");
                row[column] = (value * factor).to_string();
            }
        }
    }

    pub(super) fn swap(&mut self, a: &str, b: &str) {
        let (a, b) = (self.column(a), self.column(b));
        self.rows.iter_mut().for_each(|row| row.swap(a, b));
    }

    /// Leaves a column out.
    pub(super) fn remove(&mut self, name: &str) {
        let column = self.column(name);
        self.names.remove(column);
        self.rows.iter_mut().for_each(|row| drop(row.remove(column)));
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
pub(super) fn spoil(campaign: &Path, change: impl FnOnce(&mut Table)) {
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
pub(super) fn starter() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "c"]).status, 0);
    folder
}

pub(super) fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}:\n{}{}", ran.out, ran.err))
}

/// The diagnostics of a code.
pub(super) fn of_code(found: &Value, code: &str) -> Vec<Value> {
    let all = found["diagnostics"].as_array().expect("a list");
    all.iter().filter(|diagnostic| diagnostic["code"] == code).cloned().collect()
}

/// A command refuses a campaign for one reason, and says these words.
pub(super) fn refuses(folder: &Path, arguments: &[&str], code: &str, words: &[&str]) {
    let ran = run(folder, &[arguments, &["--format", "json"]].concat());
    assert_eq!(ran.status, 2, "{arguments:?}: {}{}", ran.out, ran.err);
    let mut found = of_code(&json(&ran), code);
    found.retain(|diagnostic| diagnostic["severity"] == "error");
    assert!(!found.is_empty(), "{arguments:?}: no {code}\n{}", ran.out);
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
    (|t| t.scale(&["y"], 0.1), "wrong-units", &["y of the readings times 10 ", "that column in another unit"]),
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

/// Two markers of three whose names are exchanged: named as that, although a tool that is estimated explains it as well.
#[test]
fn swapped_markers_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "kuka-kr270", &["--poses", "20", "--markers", "m1,m2,m3"]);
    let found = json(&run(at, &["check", "./s", "--format", "json"]));
    assert!(of_code(&found, "misread").is_empty(), "{}", found["diagnostics"]);
    spoil(&at.join("s"), |table| {
        let marker = table.column("marker");
        for row in &mut table.rows {
            row[marker] = match row[marker].as_str() {
                "m1" => "m2".into(),
                "m2" => "m1".into(),
                other => other.into(),
            };
        }
    });
    refuses(at, &["check", "./s"], "misread", &["the markers `m1` and `m2` exchanged", "markers swapped?"]);
}

/// A table of Denavit and Hartenberg that is declared in the other convention than it is written in.
#[test]
fn a_table_of_the_other_convention_is_named() {
    // theta, d, a, alpha of a UR5 in both conventions.
    let classical = ["d: 89, a: 0, alpha: 90", "d: 0, a: -425, alpha: 0", "d: 0, a: -392, alpha: 0"];
    let classical_wrist = ["d: 109, a: 0, alpha: 90", "d: 95, a: 0, alpha: -90", "d: 82, a: 0, alpha: 0"];
    let modified = ["d: 89, a: 0, alpha: 0", "d: 0, a: 0, alpha: 90", "d: 0, a: -425, alpha: 0"];
    let modified_wrist = ["d: 109, a: -392, alpha: 0", "d: 95, a: 0, alpha: 90", "d: 82, a: 0, alpha: -90"];
    let tables = [
        ("classical-dh", "modified-dh", classical, classical_wrist),
        ("modified-dh", "classical-dh", modified, modified_wrist),
    ];
    for (written, declared, arm, wrist) in tables {
        for more in [&[][..], &["--unknown-base", "--unknown-tool"]] {
            let folder = tempfile::tempdir().expect("a folder");
            let at = folder.path();
            let rows = arm.iter().chain(&wrist).enumerate().map(|(k, row)| {
                format!("  {0}: {{antecedent: {k}, joint: revolute, variable: q{0}, theta: 0, {row}}}\n", k + 1)
            });
            let text = format!("units: {{length: mm, angle: deg}}\nframes:\n{}", rows.collect::<String>());
            let write = |convention: &str| {
                let text = format!("convention: {convention}\n{text}tool: {{frame: 6, at: [20, 0, 60]}}\n");
                std::fs::write(at.join("arm.yaml"), text).expect("written");
            };
            write(written);
            simulated(at, "arm.yaml", &[&["--poses", "30"], more].concat());
            assert_eq!(run(at, &["check", "./s"]).status, 0);
            write(declared);
            let words = ["a table of another convention?", "alpha` and `d` of each frame at the frame"];
            refuses(at, &["check", "./s"], "misread", &words);
            let found = json(&run(at, &["check", "./s", "--format", "json"]));
            let remedy = of_code(&found, "misread")[0]["remedy"].to_string();
            assert!(remedy.contains(&format!("convention: {written}")), "{remedy}");
        }
    }
}

/// Calibration of a sound robot with few and noisy readings: what it fits is noise, and readings that were held out show it.
/// Told from 1.1 times on, refused from 1.5 times on (seeds at which it comes out so), and not with many readings.
#[test]
fn a_calibration_that_fits_noise_is_told_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = |poses: &str, seed: &str| {
        simulated(at, "universal-ur5", &["--poses", poses, "--seed", seed, "--noise", "1", "--errors", "0"]);
    };
    made("14", "2");
    let found =
        doubts(at, &["identify", "./s"], "worse-than-registered", &["worse, from 1.44 to 1.86 mm", "fits noise"]);
    let ratio = of_code(&found, "worse-than-registered")[0]["figures"]["ratio"].as_f64().expect("a ratio");
    assert!((1.1..1.5).contains(&ratio), "{ratio}");
    made("14", "1");
    // With what noise decides held as described, as is usual there, it is not that bad.
    let all = ["identify", "./s", "--tolerance", "6.1e-5", "--save", "x.yaml"];
    refuses(at, &all, "worse-than-registered", &["worse, from 1.79 to 3.97 mm"]);
    assert!(!at.join("x.yaml").exists());
    made("60", "1");
    let found = json(&run(at, &["identify", "./s", "--format", "json"]));
    assert!(of_code(&found, "worse-than-registered").is_empty(), "{}", found["diagnostics"]);
}

/// A base that comes out half a kilometre away: registration takes the shift up, and no instrument reaches there.
#[test]
fn a_base_out_of_reach_is_refused() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |table| {
        let x = table.column("x");
        for row in &mut table.rows {
            row[x] = (row[x].parse::<f64>().expect("a number") + 5e5).to_string();
        }
    });
    refuses(at, &["identify", "c", "--save", "x.yaml"], "implausible", &["`base.x` came out at 500 m"]);
    assert!(!at.join("x.yaml").exists());
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
            for command in ["check", "identify"] {
                let ran = run(root, &[command, &path.display().to_string(), "--format", "json"]);
                assert_eq!(ran.status, 0, "{}", ran.err);
                // Most hold an effect that their description lacks, and some so much of it that this is told.
                for code in CODES.iter().filter(|code| **code != "noise-unlike-stated") {
                    assert!(of_code(&json(&ran), code).is_empty(), "{}: {}", path.display(), ran.err);
                }
            }
            seen += 1;
        }
    }
    assert!(seen >= 14, "{seen} campaigns");
}

/// Codes of doubt.
const CODES: &[&str] = &[
    "wrong-units",
    "misread",
    "unlike-description",
    "moved-far",
    "worse-than-registered",
    "noise-unlike-stated",
    "too-little-data",
    "sessions-differ",
    "implausible",
    "outlying-readings",
    "moved-midway",
];

/// A campaign of a bundled robot, simulated.
pub(super) fn simulated(folder: &Path, robot: &str, more: &[&str]) {
    let ran = run(folder, &[&["simulate", robot, "--into", "s"], more].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
}

/// A command succeeds, and doubts its figures with a code in text, before all else, and in JSON.
pub(super) fn doubts(folder: &Path, arguments: &[&str], code: &str, words: &[&str]) -> Value {
    let ran = run(folder, arguments);
    assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
    let first = ran.out.lines().next().unwrap_or_default();
    assert!(ran.out.contains(&format!("DOUBTFUL ({code})")) && first.starts_with("DOUBTFUL"), "{}", ran.out);
    let found = json(&run(folder, &[arguments, &["--format", "json"]].concat()));
    let own = of_code(&found, code);
    assert!(!own.is_empty(), "{arguments:?}: no {code}: {}", found["diagnostics"]);
    assert_eq!(own[0]["severity"], "warning");
    let message = own[0]["message"].as_str().expect("words");
    words.iter().for_each(|word| assert!(message.contains(word), "`{word}`: {message}"));
    found
}

/// Readings that are 5 % too long make a robot that is 5 % too long, and fit.
#[test]
fn a_robot_of_another_size_is_refused() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |table| table.scale(&["x", "y", "z"], 1.05));
    refuses(at, &["identify", "c", "--save", "x.yaml"], "moved-far", &["1.05", "times the declared"]);
    refuses(at, &["diagnose", "c"], "moved-far", &["1.05", "times the declared"]);
    assert!(!at.join("x.yaml").exists());
}

/// A description whose own numbers moved: a zero that is a quarter turn off is named before anything is fitted, one that is
/// 2 degrees off and a length that is 30 mm off are told.
#[test]
fn constants_far_from_the_description_are_told() {
    let folder = starter();
    let at = folder.path();
    let path = at.join("c/robot.yaml");
    let sound = std::fs::read_to_string(&path).expect("text");
    std::fs::write(&path, sound.replace("theta: -90", "theta: 0")).expect("written");
    refuses(at, &["identify", "c"], "misread", &["-90 deg added to `q2`", "another zero"]);
    std::fs::write(&path, sound.replace("theta: -90", "theta: -87.5")).expect("written");
    doubts(at, &["identify", "c"], "moved-far", &["`2.theta` -87.50 -> -90."]);
}

/// A spring that comes out a thousand times softer than declared: units of stiffness.
#[test]
fn springs_of_another_unit_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(
        at,
        "kuka-kr270",
        &[
            "--observes",
            "deflection",
            "--poses",
            "30",
            "--wrench",
            "0,0,-2500,0,0,0",
            "--wrench",
            "1500,0,-1000,0,0,0",
            "--errors",
            "0",
        ],
    );
    assert_eq!(run(at, &["identify", "s"]).status, 0);
    // Forces in kN that are declared in N.
    spoil(&at.join("s"), |table| table.scale(&["fx", "fy", "fz"], 1e-3));
    refuses(
        at,
        &["identify", "s", "--save", "x.yaml"],
        "wrong-units",
        &["times greater than the declared springs allow for", "loads"],
    );
    assert!(!at.join("x.yaml").exists());
}

/// A noise that is stated fifty times too great.
#[test]
fn residuals_far_below_the_stated_noise_are_told() {
    let folder = starter();
    let at = folder.path();
    let path = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("text");
    std::fs::write(&path, text.replace("sigma: 0.03", "sigma: 1.5")).expect("written");
    doubts(at, &["identify", "c"], "noise-unlike-stated", &["0.02 times the stated noise"]);
}

/// One configuration forty times, and hardly more readings than parameters: no gap is denied.
#[test]
fn too_little_data_denies_no_gap() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |table| {
        let first = table.rows[0].clone();
        for (k, row) in table.rows.iter_mut().enumerate() {
            let name = row[0].clone();
            row.clone_from(&first);
            row[0] = name;
            let x: f64 = first[8].parse().expect("a number");
            row[8] = (x + 0.03 * ((k * 7 % 5) as f64 - 2.0)).to_string();
        }
    });
    let found = doubts(at, &["diagnose", "c"], "too-little-data", &["one configuration"]);
    assert_eq!(found["verdict"], "undecided");
    doubts(at, &["identify", "c"], "too-little-data", &["one configuration"]);
    assert_eq!(run(at, &["report", "c"]).status, 0);
    let page = std::fs::read_to_string(at.join("report.html")).expect("a page");
    assert!(page.contains("Undecided</b>") && page.contains("too-little-data"), "the report says so");

    simulated(at, "universal-ur5", &["--poses", "12", "--errors", "1"]);
    let found = doubts(at, &["diagnose", "s"], "too-little-data", &["residuals of different readings", "parameters"]);
    assert_ne!(found["verdict"], "no-gap");
}

/// Masses and centres that no robot has, metres in a file of mm, radians in a file of degrees: `check` shows masses and warns.
#[test]
fn a_description_with_impossible_numbers_is_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = "robot: arm\nunits: {length: mm, angle: deg, mass: kg}\nframes:\n  \
               1: {antecedent: 0, joint: revolute, variable: q1}\n  \
               2: {antecedent: 1, joint: revolute, variable: q2, d: 500, alpha: 90}\ntool: {frame: 2, at: [400, 0, 0]}\n\
               bodies:\n  2: {mass: 12.5, com: [200, 0, 0]}\n";
    let check = |text: &str| {
        std::fs::write(at.join("arm.yaml"), text).expect("written");
        run(at, &["check", "arm.yaml"])
    };
    let sound = check(arm);
    assert!(sound.status == 0 && sound.err.is_empty(), "{}", sound.err);
    assert!(
        sound.out.contains("12.500") && sound.out.contains("200.0") && sound.out.contains("kg in all"),
        "{}",
        sound.out
    );
    let cases = [
        ("mass: 12.5", "mass: 1.0e8", "mass of 1.000e8 kg"),
        ("com: [200", "com: [200000", "lies 200.00 m from its frame"),
        ("d: 500", "d: 0.5", "add up to 0.500 mm"),
        ("alpha: 90", "alpha: 1.5708", "a quarter turn in rad"),
    ];
    for (from, to, words) in cases {
        let ran = check(&arm.replace(from, to));
        assert!(ran.status == 0 && ran.err.contains(words), "{to}: {}", ran.err);
        assert!(ran.err.contains("arm.yaml:"), "{}", ran.err);
    }
}

/// Two files of which the second was measured after the tracker had been moved by 19 mm, named as sessions and not.
#[test]
fn sessions_that_differ_are_told() {
    let folder = starter();
    let at = folder.path();
    let text = std::fs::read_to_string(at.join("c/measurements.csv")).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    let half = lines.len() / 2;
    let table = |rows: &[&str], by: f64| {
        let moved = rows.iter().map(|line| {
            let mut cells: Vec<String> = line.split(',').map(String::from).collect();
            cells[8] = (cells[8].parse::<f64>().expect("x") + by).to_string();
            cells.join(",")
        });
        std::iter::once(lines[0].to_string()).chain(moved).collect::<Vec<_>>().join("\n") + "\n"
    };
    let campaign = std::fs::read_to_string(at.join("c/campaign.yaml")).expect("text");
    let write = |by: f64, entries: &str| {
        std::fs::write(at.join("c/a.csv"), table(&lines[1..half], 0.0)).expect("written");
        std::fs::write(at.join("c/b.csv"), table(&lines[half..], by)).expect("written");
        let text = campaign.replace("measurements: measurements.csv", &format!("measurements: {entries}"));
        std::fs::write(at.join("c/campaign.yaml"), text).expect("written");
    };
    let named = "[{file: a.csv, session: monday}, {file: b.csv, session: friday}]";
    write(19.0, named);
    doubts(
        at,
        &["check", "c"],
        "sessions-differ",
        &["sessions differ by 18.5 mm", "in the base", "`monday` and `friday`", "base per session?"],
    );
    write(19.0, "[a.csv, b.csv]");
    doubts(at, &["check", "c"], "sessions-differ", &["files differ by 18.5 mm", "b.csv"]);
    for entries in [named, "[a.csv, b.csv]"] {
        write(0.0, entries);
        let found = json(&run(at, &["check", "c", "--format", "json"]));
        assert!(of_code(&found, "sessions-differ").is_empty(), "{}", found["diagnostics"]);
    }
}

/// Orientations have no lengths: two files of one arm agree, and two that are turned by a degree are said to differ by that.
#[test]
fn sessions_of_orientations_alone_are_compared_by_angles() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let header = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: orientation\nestimate: {base: true}\n\
                  instrument: {orientation: 0.004}\nmeasurements: ";
    std::fs::write(at.join("o.yaml"), format!("{header}none.csv\n")).expect("written");
    let made = run(at, &["simulate", "o.yaml", "--poses", "90", "--seed", "4", "--into", "t"]);
    assert_eq!(made.status, 0, "{}", made.err);
    let text = std::fs::read_to_string(at.join("t/measurements.csv")).expect("a table");
    let lines: Vec<&str> = text.lines().collect();
    let titles: Vec<&str> = lines[0].split(',').collect();
    let [rx, ry, rz] = ["rx", "ry", "rz"].map(|name| titles.iter().position(|own| *own == name).expect("a column"));
    let turned = |line: &&str, by: f64| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        let vector = Vector3::from([rx, ry, rz].map(|k| cells[k].parse::<f64>().expect("deg").to_radians()));
        let about_z = Rotation3::new(Vector3::z() * f64::to_radians(by)) * Rotation3::new(vector);
        let vector = about_z.scaled_axis();
        [rx, ry, rz].into_iter().zip(vector.iter()).for_each(|(k, v)| cells[k] = format!("{:.6}", v.to_degrees()));
        cells.join(",")
    };
    let half = lines.len() / 2;
    let table = |rows: &[&str], by: f64| {
        let rows = rows.iter().map(|line| turned(line, by));
        std::iter::once(lines[0].to_string()).chain(rows).collect::<Vec<_>>().join("\n") + "\n"
    };
    for (by, differs) in [(0.0, false), (1.0, true)] {
        std::fs::write(at.join("t/a.csv"), table(&lines[1..half], 0.0)).expect("written");
        std::fs::write(at.join("t/b.csv"), table(&lines[half..], by)).expect("written");
        let campaign = std::fs::read_to_string(at.join("t/campaign.yaml")).expect("text");
        let campaign = campaign.replace("measurements: measurements.csv", "measurements: [a.csv, b.csv]");
        std::fs::write(at.join("t/campaign.yaml"), campaign).expect("written");
        let found = json(&run(at, &["identify", "t", "--format", "json"]));
        let said = of_code(&found, "sessions-differ");
        assert_eq!(!said.is_empty(), differs, "{by}: {}", found["diagnostics"]);
        if let Some(said) = said.first() {
            let message = said["message"].as_str().expect("a message");
            assert!(
                message.contains("1.0") && message.contains("deg in the base") && message.contains("times the noise")
            );
            assert!(!message.contains(" mm"), "{message}");
        }
    }
}

/// Time that runs backwards, and a file that is listed twice.
#[test]
fn time_that_goes_back_and_copies_are_told() {
    let folder = starter();
    let at = folder.path();
    let path = at.join("c/campaign.yaml");
    let campaign = std::fs::read_to_string(&path).expect("text");
    let timed = |at: fn(usize) -> usize| {
        spoil(&folder.path().join("c"), |table| {
            if !table.names.iter().any(|name| name == "time") {
                table.names.push("time".into());
                table.rows.iter_mut().for_each(|row| row.push(String::new()));
            }
            let time = table.column("time");
            table.rows.iter_mut().enumerate().for_each(|(k, row)| row[time] = (60 * at(k)).to_string());
        });
    };
    timed(|k| k);
    assert!(run(at, &["check", "c"]).err.is_empty());
    timed(|k| if k == 20 { 3 } else { k });
    let ran = run(at, &["check", "c"]);
    assert!(ran.err.contains("`time` goes back by 960 s") && ran.err.contains("measurements.csv:22"), "{}", ran.err);
    doubts(at, &["identify", "c"], "suspect-readings", &["`time` goes back by 960 s"]);
    // Rows that are mixed are in no order of time, which is nothing to doubt; in a stated order they are.
    let numbered = || {
        spoil(&folder.path().join("c"), |table| {
            table.names.push("order".into());
            table.rows.iter_mut().enumerate().for_each(|(k, row)| row.push((37 * k % 60).to_string()));
        });
    };
    let mixed = std::fs::read_to_string(at.join("c/measurements.csv")).expect("text");
    timed(|k| 37 * k % 60);
    assert!(run(at, &["check", "c"]).err.is_empty());
    numbered();
    assert!(run(at, &["check", "c"]).err.is_empty(), "{}", run(at, &["check", "c"]).err);
    timed(|k| if k == 20 { 61 } else { 37 * k % 60 });
    assert!(run(at, &["check", "c"]).err.contains("`order` says which came first"));
    // Numbers that leave some out say that something was reached of which nothing is known.
    timed(|k| k);
    spoil(&folder.path().join("c"), |table| {
        let order = table.column("order");
        table.rows.iter_mut().enumerate().for_each(|(k, row)| row[order] = (k + k / 10).to_string());
    });
    let said = run(at, &["check", "c"]).err;
    assert!(said.contains("6 of 60 configurations have no known predecessor"), "{said}");
    std::fs::write(at.join("c/measurements.csv"), mixed).expect("written");
    timed(|k| k);
    let twice =
        campaign.replace("measurements: measurements.csv", "measurements: [measurements.csv, measurements.csv]");
    std::fs::write(&path, &twice).expect("written");
    let ran = run(at, &["check", "c"]);
    assert!(ran.err.contains("60 of 120 readings are copies"), "{}", ran.err);
    let ran = run(at, &["diagnose", "c"]);
    assert!(ran.out.contains("DOUBTFUL (suspect-readings): 60 of 120 readings are copies"), "{}", ran.out);
    // Exported once more, with fewer digits and other names.
    let table = std::fs::read_to_string(at.join("c/measurements.csv")).expect("a table");
    let cut = |(k, cell): (usize, &str)| match cell.parse::<f64>() {
        Ok(value) if k > 0 => format!("{value:.3}"),
        _ if k == 0 => format!("again-{cell}"),
        _ => cell.into(),
    };
    let mut lines = table.lines();
    let header = lines.next().expect("a header");
    let rows: Vec<String> =
        lines.map(|line| line.split(',').enumerate().map(cut).collect::<Vec<_>>().join(",")).collect();
    std::fs::write(at.join("c/again.csv"), format!("{header}\n{}\n", rows.join("\n"))).expect("written");
    std::fs::write(
        &path,
        campaign.replace("measurements: measurements.csv", "measurements: [measurements.csv, again.csv]"),
    )
    .expect("written");
    let ran = run(at, &["check", "c"]);
    assert!(ran.err.contains("are copies of others but for digits that were cut"), "{}", ran.err);
    std::fs::write(&path, twice).expect("written");
    // A report says it before its figures too.
    assert_eq!(run(at, &["report", "c", "--output", "r.html"]).status, 0);
    let page = std::fs::read_to_string(at.join("r.html")).expect("a report");
    assert!(page.contains("60 of 120 readings are copies"));
}

/// Values that were fitted to readings which are not what they should be are not written into a description, unless that is forced
/// or, of outliers, the loss bears them.
#[test]
fn doubted_values_are_not_saved() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |table| {
        let x = table.column("x");
        let cell = &mut table.rows[7][x];
        *cell = (50.0 + cell.parse::<f64>().expect("a number")).to_string();
    });
    let ran = run(at, &["identify", "c", "--save", "x.yaml"]);
    assert_eq!(ran.status, 1);
    assert!(ran.out.contains("not written: x.yaml (doubtful: outlying-readings; --force writes it)"), "{}", ran.out);
    assert!(!at.join("x.yaml").exists());
    for more in ["--force", "--loss=huber"] {
        assert_eq!(run(at, &["identify", "c", "--save", "x.yaml", more]).status, 0, "{more}");
        std::fs::remove_file(at.join("x.yaml")).expect("written");
    }
    // A diagnosis sets them aside.
    assert_eq!(run(at, &["diagnose", "c", "--apply", "x.yaml"]).status, 0);
    assert!(at.join("x.yaml").exists());
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |table| {
        let y = table.column("y");
        for row in table.rows.iter_mut().skip(30) {
            row[y] = (1.0 + row[y].parse::<f64>().expect("a number")).to_string();
        }
    });
    for command in [["identify", "c", "--save", "x.yaml"], ["diagnose", "c", "--apply", "x.yaml"]] {
        let ran = run(at, &command);
        assert_eq!(ran.status, 1, "{command:?}: {}", ran.out);
        assert!(ran.out.contains("not written: x.yaml (doubtful: moved-midway"), "{command:?}: {}", ran.out);
        assert!(!at.join("x.yaml").exists());
    }
}

/// A coordinate with a digit too many: named by its line, before and after calibration, and no unit is suspected.
#[test]
fn a_wrong_reading_is_named() {
    for (robot, line) in [("palletiser", 5), ("hexapod", 12), ("franka-panda", 30), ("kuka-kr270", 5)] {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        simulated(at, robot, &["--poses", "40", "--unknown-base", "--unknown-tool"]);
        spoil(&at.join("s"), |table| {
            let x = table.column("x");
            let cell = &mut table.rows[line - 2][x];
            *cell = (10.0 * cell.parse::<f64>().expect("a number")).to_string();
        });
        let found = json(&run(at, &["check", "./s", "--format", "json"]));
        let said = of_code(&found, "outlying-readings");
        assert_eq!(said.len(), 1, "{robot}: {}", found["diagnostics"]);
        let message = said[0]["message"].as_str().expect("words");
        assert!(message.contains("1 of 40") && message.contains(&format!("measurements.csv:{line} ")), "{message}");
        assert!(of_code(&found, "wrong-units").is_empty() && of_code(&found, "misread").is_empty(), "{robot}");
    }
}

/// One of the fitted readings is 3 mm off, below what tolerances allow: only calibration shows it.
#[test]
fn a_small_wrong_reading_is_named_after_calibration() {
    for row in [7, 20] {
        let folder = starter();
        let at = folder.path();
        spoil(&at.join("c"), |table| {
            let x = table.column("x");
            let cell = &mut table.rows[row][x];
            *cell = (3.0 + cell.parse::<f64>().expect("a number")).to_string();
        });
        let line = format!("measurements.csv:{} (3.", row + 2);
        let other = format!("measurements.csv:{} (2.", row + 2);
        let found = doubts(at, &["identify", "c"], "outlying-readings", &["1 of 60 readings is far off"]);
        let message = of_code(&found, "outlying-readings")[0]["message"].as_str().expect("words").to_owned();
        assert!(message.contains(&line) || message.contains(&other), "{message}");
    }
}

/// A marker that slips on its body, and an instrument that is knocked, by 1 mm before row 30: told apart.
#[test]
fn what_moves_midway_is_told() {
    let moved = |code: &str, words: &[&str], change: &dyn Fn(&mut Table)| {
        let folder = starter();
        spoil(&folder.path().join("c"), change);
        doubts(folder.path(), &["identify", "c"], code, words);
    };
    // The reading of line 32 is held out.
    moved("moved-midway", &["measurements.csv:33", "the instrument or the robot's base"], &|table| {
        let y = table.column("y");
        for row in table.rows.iter_mut().skip(30) {
            row[y] = (1.0 + row[y].parse::<f64>().expect("a number")).to_string();
        }
    });
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = |into: &str, more: &[&str]| {
        let arguments =
            ["simulate", "universal-ur5", "--poses", "60", "--unknown-base", "--unknown-tool", "--into", into];
        assert_eq!(run(at, &[&arguments[..], more].concat()).status, 0);
        std::fs::read_to_string(at.join(into).join("measurements.csv")).expect("text")
    };
    let sound = made("s", &[]);
    let found = json(&run(at, &["identify", "./s", "--format", "json"]));
    assert!(of_code(&found, "moved-midway").is_empty(), "{}", found["diagnostics"]);
    // The same robot with a marker 1 mm further out.
    let other = made("t", &["--set", "tool.y=1.0"]);
    let lines = |text: &str| text.lines().map(String::from).collect::<Vec<_>>();
    let both: Vec<String> = lines(&sound).into_iter().take(31).chain(lines(&other).into_iter().skip(31)).collect();
    std::fs::write(at.join("s/measurements.csv"), both.join("\n") + "\n").expect("written");
    doubts(at, &["identify", "./s"], "moved-midway", &["measurements.csv:3", "the marker moved"]);
}

/// A robot that could not stand as the files are read: the way in which it can is named.
#[test]
fn a_way_in_which_loops_close_is_named() {
    for (robot, change, words) in [
        ("palletiser", (|t: &mut Table| t.scale(&["q2"], -1.0)) as fn(&mut Table), "with `q2` negated"),
        ("hexapod", |t: &mut Table| t.scale(&["s2"], -1.0), "with `s2` negated"),
        ("five-bar", |t: &mut Table| t.scale(&["q2"], -1.0), "with `q2` negated"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        simulated(at, robot, &["--poses", "30", "--unknown-base", "--unknown-tool"]);
        spoil(&at.join("s"), change);
        refuses(at, &["identify", "./s"], "misread", &[words]);
    }
}

/// Readings that hardly scatter are no robot in other units.
#[test]
fn readings_of_one_point_are_no_robot_in_other_units() {
    for robot in ["palletiser", "barrett-wam", "hexapod"] {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        simulated(at, robot, &["--poses", "40", "--unknown-base", "--unknown-tool"]);
        spoil(&at.join("s"), |table| {
            let columns = ["x", "y", "z"].map(|name| table.column(name));
            let first = table.rows[0].clone();
            table.rows.iter_mut().for_each(|row| columns.iter().for_each(|&k| row[k].clone_from(&first[k])));
        });
        refuses(at, &["check", "./s"], "unlike-description", &["none of"]);
    }
}

/// Mistakes of the table that no other way to read it explains: none of them ends with a sound figure.
#[test]
fn mistakes_in_a_row_are_never_sound() {
    type Spoiled = fn(&mut Table);
    fn changed(table: &mut Table, change: impl Fn(usize, Vec<f64>) -> Vec<f64>, names: [&str; 3]) {
        let columns = names.map(|name| table.column(name));
        for (k, row) in table.rows.iter_mut().enumerate() {
            let values = columns.iter().map(|&column| row[column].parse().expect("a number")).collect();
            for (&column, value) in columns.iter().zip(change(k, values)) {
                row[column] = value.to_string();
            }
        }
    }
    // Roll, pitch and yaw in the place of the rotation vector.
    let angles: Spoiled = |t| {
        let change = |_: usize, v: Vec<f64>| {
            let turn = Rotation3::new(Vector3::from_vec(v) * std::f64::consts::PI / 180.0);
            let (roll, pitch, yaw) = turn.euler_angles();
            [roll, pitch, yaw].map(f64::to_degrees).to_vec()
        };
        changed(t, change, ["rx", "ry", "rz"]);
    };
    let inverse: Spoiled = |t| changed(t, |_, v| v.iter().map(|v| -v).collect(), ["rx", "ry", "rz"]);
    let other_robot: Spoiled = |t| {
        let change = |k: usize, v: Vec<f64>| if k.is_multiple_of(2) { v } else { vec![v[1], v[0], v[2]] };
        changed(t, change, ["q1", "q2", "q3"]);
    };
    let pasted: Spoiled = |t| {
        let columns = ["x", "y", "z", "rx", "ry", "rz"].map(|name| t.column(name));
        let half = t.rows.len() / 2;
        for k in 0..half {
            columns.iter().for_each(|&column| t.rows[half + k][column] = t.rows[k][column].clone());
        }
    };
    let rounded: Spoiled = |t| {
        changed(t, |_, v| v.iter().map(|v| v.round()).collect(), ["q1", "q2", "q3"]);
        changed(t, |_, v| v.iter().map(|v| v.round()).collect(), ["q4", "q5", "q6"]);
    };
    for (what, spoiled, code, words) in [
        ("angles", angles, "misread", "roll, pitch and yaw"),
        ("inverse", inverse, "misread", "rotations inverted"),
        ("other robot", other_robot, "unlike-description", "none of"),
        ("pasted", pasted, "unlike-description", "none of"),
        ("rounded", rounded, "noise-unlike-stated", ""),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let at = folder.path();
        simulated(at, "universal-ur5", &["--poses", "30", "--observes", "pose"]);
        assert_eq!(run(at, &["identify", "./s"]).status, 0, "sound");
        spoil(&at.join("s"), spoiled);
        if code == "noise-unlike-stated" {
            doubts(at, &["identify", "./s"], code, &[]);
        } else {
            refuses(at, &["identify", "./s", "--save", "i.yaml"], code, &[words]);
            assert!(!at.join("i.yaml").exists(), "{what}");
        }
    }
}

/// The page of what is caught shows each mistake with the code and the words that the tests look for.
#[test]
fn the_page_of_trust_shows_what_is_said() {
    let page = std::fs::read_to_string(format!("{}/docs/trust.md", env!("CARGO_MANIFEST_DIR"))).expect("a page");
    for (_, code, words) in MISTAKES {
        assert!(page.contains(&format!("`{code}`")), "{code}");
        words.iter().for_each(|word| assert!(page.contains(word.trim()), "`{word}` is not in docs/trust.md"));
    }
    for code in CODES {
        assert!(page.contains(&format!("`{code}`")), "{code}");
    }
    let sources = std::fs::read_dir(format!("{}/tests/it", env!("CARGO_MANIFEST_DIR"))).expect("tests");
    let sources: String = sources.filter_map(|entry| std::fs::read_to_string(entry.ok()?.path()).ok()).collect();
    // Each case of the second table has its command, which names a test that is here.
    let (_, cases) = page.split_once("## Everything else").expect("a section");
    let (cases, _) = cases.split_once("## What is not caught").expect("a section");
    let rows: Vec<&str> = cases.lines().filter(|line| line.starts_with("| ")).skip(2).collect();
    assert!(rows.len() >= 14, "{} cases", rows.len());
    for row in rows {
        let commands = row.split('|').nth(2).unwrap_or_default().split(", ");
        for command in commands.map(|command| command.trim().trim_matches('`')) {
            let test = command.strip_prefix("cargo test ").unwrap_or_else(|| panic!("no command: {row}"));
            assert!(sources.contains(&format!("fn {test}")), "no test `{test}`");
        }
    }
    let (_, cases) = page.split_once("## Numbers, files and screens").expect("a section");
    let (cases, _) = cases.split_once("## Spoiled files").expect("a section");
    let rows: Vec<&str> = cases.lines().filter(|line| line.starts_with("| ")).skip(2).collect();
    assert!(rows.len() >= 19, "{} cases", rows.len());
    for row in rows {
        let commands = row.split('|').nth(3).unwrap_or_default().split(", ");
        for command in commands.map(|command| command.trim().trim_matches('`')) {
            let test = command.strip_prefix("cargo test ").unwrap_or_else(|| panic!("no command: {row}"));
            assert!(sources.contains(&format!("fn {test}")), "no test `{test}`");
        }
    }
}

/// Deflections go with their loads: a mirrored axis and reversed wrenches are named, on campaigns of two robots.
#[test]
fn deflections_against_their_loads_are_named() {
    let mistakes: &[(&[&str], &str)] = &[
        (&["y"], "with y of the readings negated the error of the fitted springs falls from"),
        (&["z"], "with z of the readings negated the error of the fitted springs falls from"),
        (
            &["fx", "fy", "fz", "mx", "my", "mz"],
            "with the wrenches reversed the error of the fitted springs falls from",
        ),
    ];
    for name in ["ir663-axial-screws", "kr270-no-compensator"] {
        for (k, (columns, words)) in mistakes.iter().enumerate() {
            let folder = tempfile::tempdir().expect("a folder");
            let at = folder.path().join("c");
            std::fs::create_dir(&at).expect("a folder");
            let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("campaigns").join(name);
            for file in ["campaign.yaml", "measurements.csv"] {
                std::fs::copy(own.join(file), at.join(file)).expect("copied");
            }
            // Once each whether all commands say so, and whether sound readings pass.
            let commands = if k == 0 { &["check", "identify", "diagnose"][..] } else { &["identify"] };
            assert!(k > 0 || run(folder.path(), &["check", "c"]).status == 0, "{name}");
            spoil(&at, |table| table.scale(columns, -1.0));
            for command in commands {
                refuses(folder.path(), &[*command, "c"], "misread", &[words]);
            }
            if k > 0 {
                continue;
            }
            let ran = run(folder.path(), &["identify", "c", "--format", "json"]);
            let [from, to] =
                ["before_mm", "after_mm"].map(|key| of_code(&json(&ran), "misread")[0]["figures"][key].as_f64());
            assert!(to.is_some() && from > to.map(|to| 4.0 * to), "{name} {columns:?} {from:?} {to:?}");
        }
    }
}

/// Deflections that were zeroed under load are shifted alike, and springs fitted to them are wrong.
#[test]
fn deflections_that_are_shifted_alike_are_told() {
    let folder = starter();
    let at = folder.path();
    simulated(
        at,
        "kuka-kr270",
        &[
            "--poses",
            "30",
            "--seed",
            "3",
            "--markers",
            "m1,m2,m3",
            "--observes",
            "deflection",
            "--wrench",
            "0,0,-2500",
            "--wrench",
            "1000,0,-1500",
            "--errors",
            "0",
            "--elastic-errors",
            "1",
        ],
    );
    let sound = run(at, &["identify", "s", "--save", "x.yaml"]);
    assert!(sound.status == 0 && at.join("x.yaml").exists(), "{}{}", sound.out, sound.err);
    std::fs::remove_file(at.join("x.yaml")).expect("written");
    spoil(&at.join("s"), |table| {
        let z = table.column("z");
        table.rows.iter_mut().for_each(|row| row[z] = (row[z].parse::<f64>().expect("mm") + 0.4).to_string());
    });
    let found = doubts(at, &["identify", "s"], "misread", &["all deflections are shifted alike"]);
    let shift = of_code(&found, "misread")[0]["figures"]["shift_mm"].as_f64().expect("mm");
    assert!((shift - 0.4).abs() < 0.1, "{shift}");
    assert_eq!(run(at, &["identify", "s", "--save", "x.yaml"]).status, 1);
    assert!(!at.join("x.yaml").exists());
}

const DEFLECTIONS: [&str; 8] = [
    "--observes",
    "deflection",
    "--wrench",
    "1500,0,-2000,0,0,0",
    "--wrench",
    "0,1500,-500,0,300,0",
    "--elastic-errors",
    "1",
];

/// Deflections or forces in another unit, also where springs then end at their bounds and nothing says how soft they came out.
#[test]
fn deflections_in_other_units_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "kuka-ir663", &[&DEFLECTIONS[..], &["--poses", "40", "--errors", "0"]].concat());
    let table = std::fs::read_to_string(at.join("s/measurements.csv")).expect("text");
    for (names, factor, commands) in [
        (&["x", "y", "z"][..], 1e-3, &["identify", "report"][..]),
        (&["fx", "fy", "fz", "mx", "my", "mz"], 1e3, &["identify"]),
        (&["fx", "fy", "fz", "mx", "my", "mz"], 1e-3, &["diagnose"]),
    ] {
        std::fs::write(at.join("s/measurements.csv"), &table).expect("written");
        spoil(&at.join("s"), |t| t.scale(names, factor));
        for command in commands {
            refuses(at, &[command, "s"], "wrong-units", &["deflections are", "in another unit"]);
        }
    }
    std::fs::write(at.join("s/measurements.csv"), &table).expect("written");
    spoil(&at.join("s"), |t| t.scale(&["fx", "fy", "fz", "mx", "my", "mz"], 9.81));
    doubts(at, &["identify", "s"], "wrong-units", &["times smaller than the declared springs"]);
}

/// All springs of a simulated robot are off: what `identify` fits, `diagnose` fits too, and what no reading shows stays as declared.
#[test]
fn springs_that_are_off_are_no_cause() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "kuka-ir663", &[&DEFLECTIONS[..], &["--poses", "40", "--errors", "0", "--seed", "1"]].concat());
    let found = json(&run(at, &["diagnose", "s", "--format", "json"]));
    assert_eq!(found["verdict"], "no-gap", "{found}");
    let identified = json(&run(at, &["identify", "s", "--format", "json"]));
    let spring = identified["parameters"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|p| p["name"] == "joint3.kr")
        .expect("joint3.kr");
    assert_eq!(spring["value"], spring["nominal"], "{spring}");
    let file = at.join("s/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("text");
    let (head, tail) = text.split_once("calibrate:\n").expect("what is re-fitted");
    let tail: Vec<&str> = tail.lines().skip_while(|line| line.starts_with("- ")).collect();
    std::fs::write(&file, format!("{head}calibrate: [joint-compliance]\n{}\n", tail.join("\n"))).expect("written");
    doubts(at, &["diagnose", "s"], "springs-held", &["declares to be identified", "nothing but noise"]);
}

/// Two per cent too long is more than tolerances of a millimetre make of all lengths together.
#[test]
fn a_robot_of_a_doubtful_size_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "franka-panda", &["--poses", "60", "--unknown-base"]);
    spoil(&at.join("s"), |t| t.scale(&["x", "y", "z"], 1.015));
    doubts(at, &["identify", "s"], "moved-far", &["times the declared ones"]);
}

/// What befell one session does not hide behind the others.
#[test]
fn one_session_in_metres_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &["--poses", "60", "--unknown-base", "--sessions", "mon,tue"]);
    spoil(&at.join("s"), |t| {
        let session = t.column("session");
        for name in ["x", "y", "z"] {
            let column = t.column(name);
            for row in t.rows.iter_mut().filter(|row| row[session] == "tue") {
                let value: f64 = row[column].parse().expect("a number");
                row[column] = (value / 1000.0).to_string();
            }
        }
    });
    for command in ["identify", "diagnose", "register"] {
        refuses(at, &[command, "s"], "wrong-units", &["in session `tue`", "times 1000"]);
    }
}

/// One reading that bends the whole fit is named alone, by each command, also where the fit then breaks down.
#[test]
fn one_reading_that_bends_the_fit_is_named_alone() {
    let off = |by: f64| {
        move |t: &mut Table| {
            let column = t.column("x");
            let value: f64 = t.rows[10][column].parse().expect("a number");
            t.rows[10][column] = (value + by).to_string();
        }
    };
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), off(50.0));
    let found =
        doubts(at, &["identify", "c"], "outlying-readings", &["1 of 60 readings is far off", "measurements.csv:12"]);
    assert!(of_code(&found, "moved-midway").is_empty());
    let hexapod = tempfile::tempdir().expect("a folder");
    let at = hexapod.path();
    simulated(at, "hexapod", &["--poses", "60", "--unknown-base", "--noise", "0.05"]);
    spoil(&at.join("s"), off(30.0));
    for command in ["identify", "diagnose", "report"] {
        let ran = run(at, &[command, "s", "--format", "json"]);
        let told = of_code(&json(&ran), "outlying-readings");
        assert!(ran.status == 2 && told.len() == 1, "{command}: {}", ran.err);
        assert!(told[0]["message"].as_str().is_some_and(|said| said.contains("measurements.csv:12")), "{told:?}");
    }
}

/// Commands that fit nothing say it before their figures.
#[test]
fn commands_that_fit_nothing_doubt_too() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t| t.scale(&["x", "y", "z"], 1e-3));
    doubts(at, &["residuals", "c/robot.yaml", "c"], "wrong-units", &["times 1000"]);
    doubts(at, &["plan", "c", "--poses", "8"], "wrong-units", &["times 1000"]);
}

/// Loads too small to tell a spring from none leave it as declared: neither free nor rigid, and nothing like it is saved.
#[test]
fn springs_that_small_loads_do_not_tell_stay_as_declared() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let cases = [
        ("kuka-kr270", "12", "0,0,-100,0,0,0", "1"),
        ("kuka-kr270", "12", "0,0,-100,0,0,0", "2"),
        ("kuka-kr270", "24", "0,0,-1000,0,0,0", "5"),
        ("kuka-kr270", "16", "0,0,-100,0,0,0", "3"),
        ("kuka-ir663", "16", "0,0,-100,0,0,0", "1"),
        ("kuka-ir663", "16", "0,0,-100,0,0,0", "2"),
        ("kuka-ir663", "16", "0,0,-100,0,0,0", "3"),
    ];
    for (robot, poses, wrench, seed) in cases {
        let load = ["--poses", poses, "--observes", "deflection", "--wrench", wrench, "--elastic-errors", "1"];
        simulated(at, robot, &[&load[..], &["--errors", "0", "--noise", "0.05", "--seed", seed]].concat());
        let found = json(&run(at, &["identify", "s", "--what", "elastic", "--format", "json"]));
        let springs = found["parameters"].as_array().expect("a list");
        for spring in springs.iter().filter(|own| own["nominal"].as_f64().is_some_and(|nominal| nominal > 0.0)) {
            let number = |key: &str| spring[key].as_f64().expect("a number");
            let ratio = number("value") / number("nominal");
            // Rigid is an estimate like others.
            assert!(ratio == 0.0 || (1.0 / 30.0..30.0).contains(&ratio), "{robot}, seed {seed}: {spring}");
        }
    }
}

/// Joints of deflections: units and signs are named, before any cause.
#[test]
fn joints_of_deflections_are_read_otherwise() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "kuka-kr270", &[&DEFLECTIONS[..], &["--poses", "40", "--errors", "0", "--seed", "1"]].concat());
    let table = std::fs::read_to_string(at.join("s/measurements.csv")).expect("text");
    let all = ["q1", "q2", "q3", "q4", "q5", "q6"];
    let cases: [(&[&str], f64, &str, &str); 2] = [
        (&all, std::f64::consts::PI / 180.0, "wrong-units", "joint angles read as rad"),
        (&["q3"], -1.0, "misread", "`q3` negated"),
    ];
    for (names, factor, code, words) in cases {
        std::fs::write(at.join("s/measurements.csv"), &table).expect("written");
        spoil(&at.join("s"), |t| t.scale(names, factor));
        for command in ["identify", "diagnose"] {
            refuses(at, &[command, "s"], code, &[words]);
        }
    }
    // A robot with loops.
    let loads = ["--wrench", "0,0,-900,0,0,0", "--wrench", "600,300,0,0,0,0", "--errors", "0", "--elastic-errors", "1"];
    std::fs::remove_dir_all(at.join("s")).expect("removed");
    let few = ["--observes", "deflection", "--poses", "40", "--noise", "0.03", "--seed", "1"];
    simulated(at, "kuka-ir663", &[&few[..], &loads].concat());
    spoil(&at.join("s"), |t| t.scale(&["q1", "q4", "q5", "q7"], std::f64::consts::PI / 180.0));
    refuses(at, &["identify", "s"], "wrong-units", &["joint angles read as rad"]);
}

/// A base some millimetres from where the description has it is less than tolerances allow registration to leave, and is named by
/// what calibration leaves.
#[test]
fn a_base_that_is_a_little_elsewhere_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    assert_eq!(run(at, &["init", "p", "--kind", "parallelogram"]).status, 0);
    let noise = ["--poses", "60", "--markers", "ball", "--noise", "0.03", "--errors", "0.3", "--set", "base.y=5"];
    simulated(at, "p/robot.yaml", &noise);
    for command in ["identify", "diagnose"] {
        refuses(at, &[command, "s"], "misread", &["with the base estimated the error of calibration falls"]);
    }
}

/// A session's name misspelt in two rows gets a base of its own, which fits whatever they hold.
#[test]
fn a_session_of_two_rows_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &["--poses", "40", "--sessions", "A,B", "--unknown-base"]);
    spoil(&at.join("s"), |t| {
        let session = t.column("session");
        [3, 8].into_iter().for_each(|row| t.rows[row][session] = "a".into());
    });
    let found = doubts(at, &["identify", "s"], "too-little-data", &["session `a` has 6 residuals"]);
    assert!(of_code(&found, "too-little-data")[0]["remedy"].as_str().is_some_and(|said| said.contains("`A`")));
}

/// Loads in kgf make springs ten times too soft: told, and not written.
#[test]
fn implausible_values_are_not_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "kuka-kr270", &[&DEFLECTIONS[..], &["--poses", "40", "--errors", "0", "--seed", "1"]].concat());
    spoil(&at.join("s"), |t| t.scale(&["fx", "fy", "fz", "mx", "my", "mz"], 1.0 / 9.80665));
    let ran = run(at, &["identify", "s", "--save", "x.yaml"]);
    assert_eq!(ran.status, 1, "{}", ran.out);
    assert!(ran.out.contains("not written: x.yaml (doubtful: wrong-units; --force writes it)"), "{}", ran.out);
    assert!(!at.join("x.yaml").exists());
}

/// Springs a thousand times too soft: the linear answer does not apply.
#[test]
fn deflections_that_are_not_small_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = |compliance: &str| {
        let text = format!(
            "robot: arm
units: {{length: mm, angle: deg}}
frames:
  1: {{antecedent: 0, joint: revolute, variable: q1, limits: [-90, 90]}}
  E: {{antecedent: 1, d: 1000}}
tool: {{frame: E}}
joint_stiffness: {{1: {{kar: {{compliance: {compliance}}}}}}}
"
        );
        std::fs::write(folder.path().join("arm.yaml"), text).expect("written");
        let ran = run(folder.path(), &["stiffness", "arm.yaml", "--joints", "q1=0", "--wrench", "0,1000,0"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        (ran.out + &ran.err).contains("displaced by 1000 mm and turns by 57.3 deg")
    };
    assert!(!told("1e-6"));
    assert!(told("1e-3"));
}

/// Copies of readings are no cause: what is named must take something away for certain.
#[test]
fn readings_pasted_twice_have_no_cause() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t| {
        let copies = t.rows.clone();
        t.rows.extend(copies);
    });
    let found = json(&run(at, &["diagnose", "c", "--format", "json", "--force"]));
    assert_eq!(found["causes"].as_array().map(Vec::len), Some(0), "{}", found["causes"]);
}

/// Many wrong readings are no step of the instrument, however they are weighed.
#[test]
fn many_wrong_readings_are_no_step() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t| {
        let columns = ["x", "y", "z"].map(|name| t.column(name));
        for (k, row) in t.rows.iter_mut().enumerate().filter(|(k, _)| k % 5 == 2) {
            let column = columns[k % 3];
            let value: f64 = row[column].parse().expect("a number");
            row[column] = (value + if k % 2 == 0 { 40.0 } else { -40.0 }).to_string();
        }
    });
    for loss in ["squares", "huber", "tukey"] {
        let ran = run(at, &["identify", "c", "--loss", loss, "--format", "json"]);
        let found = json(&ran);
        assert!(of_code(&found, "moved-midway").is_empty(), "{loss}: {found}");
        assert!(!ran.out.contains("1/inf"), "{loss}");
    }
}

/// A robust loss that fits two thirds of the readings does not hide that the others are of something else.
#[test]
fn a_robust_loss_hides_no_third_of_the_readings() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t| {
        let z = t.column("z");
        for row in t.rows.iter_mut().step_by(3) {
            row[z] = (row[z].parse::<f64>().expect("a number") + 40.0).to_string();
        }
    });
    for loss in ["huber", "tukey"] {
        let command = ["identify", "c", "--loss", loss];
        // Whoever asked for it is not told to ask for it.
        assert!(!run(at, &command).out.contains("--loss huber"), "{loss}");
        doubts(at, &command, "unlike-description", &["20 of 60 readings", "is of something else"]);
        assert_eq!(run(at, &[&command[..], &["--save", "x.yaml"]].concat()).status, 1);
        assert!(!at.join("x.yaml").exists());
    }
}

/// A fit of hardly more rows than parameters says nothing of readings that it did not see.
#[test]
fn held_out_readings_of_a_thin_fit_are_not_called_wrong() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &["--poses", "12", "--unknown-base", "--unknown-tool", "--check", "0.25"]);
    let found = json(&run(at, &["identify", "s", "--format", "json"]));
    assert!(of_code(&found, "outlying-readings").is_empty(), "{}", found["diagnostics"]);
}

/// One wrong reading: a robust loss is advised only where none was asked for.
#[test]
fn a_robust_loss_is_advised_once() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t| {
        let z = t.column("z");
        t.rows[7][z] = (t.rows[7][z].parse::<f64>().expect("a number") + 40.0).to_string();
    });
    for (loss, is_advised) in [("squares", true), ("huber", false), ("tukey", false)] {
        let ran = run(at, &["identify", "c", "--loss", loss]);
        assert!(ran.out.contains("outlying-readings"), "{loss}: {}", ran.out);
        assert_eq!(ran.out.contains("(`--loss huber`)"), is_advised, "{loss}: {}", ran.out);
    }
}

/// The error of readings that were held out counts for little where these are of one configuration or two.
#[test]
fn few_configurations_held_out_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (share, configurations) in [("0.025", Some(1.0)), ("0.05", Some(2.0)), ("0.1", None)] {
        simulated(at, "universal-ur5", &["--poses", "40", "--unknown-base", "--unknown-tool", "--check", share]);
        let found = json(&run(at, &["identify", "s", "--format", "json"]));
        let all = found["diagnostics"].as_array().expect("a list").iter();
        let told = all.filter(|one| one["message"].as_str().is_some_and(|text| text.contains("did not see come from")));
        let told: Vec<Option<f64>> = told.map(|one| one["figures"]["configurations"].as_f64()).collect();
        assert_eq!(told, configurations.map(Some).into_iter().collect::<Vec<_>>(), "{share}: {}", found["diagnostics"]);
    }
}

/// Tolerances as wide as the links are long do not make readings in metres plausible.
#[test]
fn metres_are_named_whatever_the_tolerances() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t| t.scale(&["x", "y", "z"], 1e-3));
    let robot = std::fs::read_to_string(at.join("c/robot.yaml")).expect("text");
    std::fs::write(at.join("c/robot.yaml"), robot + "\ncalibration: {length_tolerance: 100}\n").expect("written");
    for command in ["identify", "diagnose"] {
        refuses(at, &[command, "c"], "wrong-units", &["times 1000"]);
    }
    // A description that is off by what its tolerances say is no mistake.
    spoil(&at.join("c"), |t| t.scale(&["x", "y", "z"], 1e3));
    let far = std::fs::read_to_string(at.join("c/robot.yaml")).expect("text").replace("d: 600", "d: 680");
    std::fs::write(at.join("c/robot.yaml"), far).expect("written");
    let ran = run(at, &["identify", "c"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
}
