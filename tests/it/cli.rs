//! The command as its users meet it: exit status, streams, files left behind.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;

/// What a run came to.
pub struct Ran {
    pub status: i32,
    pub out: String,
    pub err: String,
}

pub fn run(folder: &Path, arguments: &[&str]) -> Ran {
    let output = Command::new(env!("CARGO_BIN_EXE_elastogeo"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("COLUMNS")
        .stdin(Stdio::null())
        .output()
        .expect("the command starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    let ran = Ran { status: output.status.code().unwrap_or(-1), out: text(output.stdout), err: text(output.stderr) };
    assert!(!ran.err.contains("panicked"), "{arguments:?}:\n{}", ran.err);
    ran
}

pub const PLANAR: &str = "units: {length: mm, angle: deg}
variables: [q1, q2]
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-90, 90]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 500, limits: [-90, 90]}
  E: {antecedent: 2, d: 400}
tool: {frame: E}
markers:
  tip: {frame: E, at: [10, 0, 0]}
";

/// A folder with a simulated campaign of the two-joint robot.
fn campaign() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("arm.yaml"), PLANAR).expect("written");
    let made = run(folder.path(), &["simulate", "arm.yaml", "--poses", "30", "--into", "c"]);
    assert_eq!(made.status, 0, "{}", made.err);
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn flags_are_refused_with_what_was_expected() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases: &[(&[&str], &str)] = &[
        (&["pose", "universal-ur5", "--joints", "q7=1"], "did you mean `q1`?"),
        (&["pose", "universal-ur5", "--joints", "q1=abc"], "`abc` is no finite number"),
        (&["pose", "universal-ur5", "--joints", "q1=NaN"], "`NaN` is no finite number"),
        (&["pose", "universal-ur5", "--joints", "q1=1e300"], "too great"),
        (&["pose", "universal-ur5", "--joints", "q1=1,q1=2"], "`q1` is given twice"),
        (&["pose", "universal-ur5", "--joints", "q1"], "name=value"),
        (&["pose", "universal-ur5"], "--joints <A=..,B=..>"),
        (&["pose", "universal-ur5", "--table", "none.csv"], "there is no file `none.csv`"),
        (&["pose", "universal-ur5", "--joints", "q1=20 q2=40"], "separate the variables by commas"),
        (&["pose", "universal-ur5", "--joints", "q1=20deg"], "write the number alone, in "),
        (&["plan", "universal-ur5", "--poses", "9", "--range", "q1=1:-1"], "low must be below high"),
        (&["plan", "universal-ur5", "--poses", "9", "--test-range", "q1=1:-1"], "write q1=-1:1"),
        (&["compensate", "universal-ur5", "ir663-strip", "--units", "length=yd"], "expected one of `m`, `cm`, `mm`"),
        (&["solve", "universal-ur5", "--target", "1,2,3,4"], "give 3 or 6 finite numbers"),
        (&["solve", "universal-ur5", "--target", "1e300,0,0"], "give 3 or 6 finite numbers"),
        (&["check", "universal-ur55"], "did you mean `universal-ur5`?"),
        (&["check", "none.yaml"], "there is no file `none.yaml`"),
        (&["check", "."], "is a folder"),
        (&["check", "universal-ur5", "--output", "nowhere/x.txt"], "there is no folder `nowhere`"),
        (&["identify", "none"], "there is no file"),
        (&["identify", "none", "--save", "x.txt"], "end the name in .yaml or .urdf"),
        (&["identify", "none", "--save", "nowhere/x.yaml"], "there is no folder `nowhere`"),
        (&["identify", "none", "--tolerance", "abc"], "give a fraction in [0, 1), or `noise`"),
        (&["identify", "none", "--what", "geometri"], "did you mean `geometric`?"),
        (&["convert", "universal-ur5", "x.txt"], "end the name in .yaml or .urdf, or say `--as yaml|urdf|mjcf|"),
        (&["convert", "universal-ur5", "x.xml"], "say `--as mjcf` or `--as urdf`"),
        (&["simulate", "universal-ur5", "--poses", "0", "--into", "c"], "at least one configuration"),
        (&["simulate", "universal-ur5", "--poses", "3", "--noise", "1e300", "--into", "c"], "out of range"),
        (&["simulate", "universal-ur5", "--poses", "3", "--set", "1.dd=1", "--into", "c"], "did you mean `1.d`?"),
        (&["simulate", "universal-ur5", "--poses", "3", "--markers", "tip", "--into", "c"], "unknown marker `tip`"),
        (&["chek", "universal-ur5"], "unrecognized subcommand"),
    ];
    for (arguments, expected) in cases {
        let ran = run(folder.path(), arguments);
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(expected), "{arguments:?}: {}", ran.err);
        assert_eq!(ran.out, "", "{arguments:?}");
    }
    assert!(names(folder.path()).is_empty(), "{:?}", names(folder.path()));
}

#[test]
fn a_target_out_of_reach_is_a_failed_computation() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run(folder.path(), &["solve", "universal-ur5", "--target", "9000,0,0", "--restarts", "8"]);
    assert_eq!(ran.status, 1, "{}", ran.err);
    assert!(ran.err.contains("clos"), "the closest approach: {}", ran.err);
    assert_eq!(ran.out, "");
}

/// What `pose` prints is rounded, which robots with fewer than six axes cannot take up; a hundredth of a degree is no rounding.
#[test]
fn a_pose_as_printed_is_solved() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, joints) in [("scara-rail", "q1=10,q2=20"), ("palletiser", "q1=10")] {
        let printed = run(folder.path(), &["pose", robot, "--joints", joints]).out;
        let tool = printed.lines().find(|line| line.trim_start().starts_with("tool ")).expect("a tool");
        let mut of_tool: Vec<String> = tool.split_whitespace().skip(1).map(String::from).collect();
        let solved = |target: &[String]| {
            let target = target.join(",");
            run(folder.path(), &["solve", robot, "--target", &target, "--restarts", "16"])
        };
        let found = solved(&of_tool);
        assert_eq!(found.status, 0, "{robot}: {}", found.err);
        of_tool[3] = (of_tool[3].parse::<f64>().expect("a number") + 0.01).to_string();
        let missed = solved(&of_tool);
        assert!(missed.err.contains("out of reach"), "{robot}: {}", missed.err);
    }
}

#[test]
fn json_is_all_that_is_printed() {
    let folder = campaign();
    let cases: &[&[&str]] = &[
        &["check", "kuka-ir663"],
        &["pose", "universal-ur5", "--joints", "q1=10"],
        &["solve", "universal-ur5", "--target", "400,100,300", "--restarts", "4"],
        &["sensitivity", "arm.yaml", "c"],
        &["identifiability", "arm.yaml", "c"],
        &["identify", "c"],
        &["identify", "c", "--compare"],
        &["residuals", "arm.yaml", "c"],
        &["report", "c"],
        &["view", "arm.yaml"],
        &["convert", "arm.yaml", "other.yaml"],
        &["compensate", "kuka-ir663", "ir663-strip", "--process", "ir663-strip"],
        &["schema", "robot"],
        &["completions", "bash"],
    ];
    for arguments in cases {
        let ran = run(folder.path(), &[arguments, &["--format", "json"][..]].concat());
        assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
        let parsed: Result<Value, _> = serde_json::from_str(&ran.out);
        assert!(parsed.is_ok(), "{arguments:?}: {}", ran.out);
    }
    let ran = run(folder.path(), &["completions", "bash"]);
    assert!(ran.status == 0 && ran.out.contains("_elastogeo"), "{}", ran.out);
}

#[test]
fn files_are_written_together_or_not_at_all() {
    let folder = campaign();
    let before = names(folder.path());
    for output in ["nowhere/out.txt", "c"] {
        let ran = run(folder.path(), &["identify", "c", "--save", "fitted.yaml", "--output", output]);
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{}", ran.err);
        assert_eq!(names(folder.path()), before);
    }
    // A full device is found out only while writing.
    if Path::new("/dev/full").exists() {
        let ran = run(folder.path(), &["identify", "c", "--save", "fitted.yaml", "--output", "/dev/full"]);
        assert_eq!(ran.status, 1, "{}", ran.err);
        assert_eq!(names(folder.path()), before);
    }
    let ran = run(folder.path(), &["identify", "c", "--save", "fitted.yaml", "--output", "out.txt"]);
    assert_eq!((ran.status, ran.out.as_str()), (0, ""), "{}", ran.err);
    assert_eq!(run(folder.path(), &["check", "fitted.yaml"]).status, 0);
    assert!(!names(folder.path()).iter().any(|name| name.ends_with(".part")));
}

#[test]
fn a_closed_pipe_is_no_failure() {
    let folder = campaign();
    let mut child = Command::new(env!("CARGO_BIN_EXE_elastogeo"))
        .args(["identify", "c", "--format", "json"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn unknown_parameters_to_hold_are_refused() {
    let folder = campaign();
    let ran = run(folder.path(), &["identify", "c", "--hold", "2.dd"]);
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("did you mean `2.d`?"), "{}", ran.err);
}

/// `check` tells a campaign from a robot, and says what was measured and what will be estimated.
#[test]
fn a_campaign_is_checked_before_anything_is_fitted() {
    let folder = campaign();
    let path = folder.path();
    let json = |arguments: &[&str]| -> Value {
        let ran = run(path, &[arguments, &["--format", "json"]].concat());
        assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
        serde_json::from_str(&ran.out).expect("JSON")
    };
    let found = json(&["check", "c"]);
    assert_eq!(found, json(&["check", "c/campaign.yaml"]));
    let readings: Vec<Vec<String>> = std::fs::read_to_string(path.join("c/measurements.csv"))
        .expect("a file")
        .lines()
        .map(|line| line.split(',').map(ToString::to_string).collect())
        .collect();
    let column = |name: &str| readings[0].iter().position(|column| column == name).expect("a column");
    let of = |name: &str| readings[1..].iter().map(move |row| row[column(name)].clone()).collect::<Vec<_>>();
    assert_eq!(found["readings"], readings.len() - 1);
    assert_eq!((&found["configurations"], &found["markers"]["TCP"]), (&30.into(), &30.into()));
    assert_eq!(found["sets"]["check"], of("set").iter().filter(|set| *set == "check").count());
    let angles: Vec<f64> = of("q2").iter().map(|value| value.parse().expect("a number")).collect();
    let joint = &found["joints"]["q2"];
    for (key, expected) in [
        ("least", angles.iter().copied().fold(f64::INFINITY, f64::min)),
        ("most", angles.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
    ] {
        assert!((joint[key].as_f64().expect("deg") - expected).abs() < 1e-6, "{key}: {joint}");
    }
    assert_eq!((&joint["limits"][0], &joint["beyond"]), (&(-90.0).into(), &0.into()));
    assert!((found["noise"]["position"][0].as_f64().expect("mm") - 0.03).abs() < 1e-12);
    assert!(found["estimate"]["geometry"].as_array().expect("names").contains(&"2.d".into()), "{}", found["estimate"]);
    assert_eq!(found["estimate"]["base"].as_array().map(Vec::len), Some(0));
    // A row beyond the limits is counted, and warned of, in both forms.
    let mut rows = readings.clone();
    let at = column("q1");
    rows[1][at] = "95".into();
    let text: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(path.join("c/measurements.csv"), text.join("\n")).expect("written");
    let found = json(&["check", "c"]);
    assert_eq!(found["joints"]["q1"]["beyond"], 1);
    assert!(found["warnings"][0]["message"].as_str().expect("a message").contains("q1"), "{}", found["warnings"]);
    let ran = run(path, &["check", "c"]);
    assert!(ran.err.contains("warning") && ran.out.contains("noise stated, one sigma: 0.0300 mm"), "{}", ran.out);
    // A broken campaign is reported as one; a robot stays a robot.
    std::fs::write(path.join("c/campaign.yaml"), "observes: position\nmeasurements: none.csv\nrobot: ../arm.yaml\n")
        .expect("written");
    let ran = run(path, &["check", "c/campaign.yaml"]);
    assert!(ran.status == 2 && ran.err.contains("none.csv"), "{}", ran.err);
    assert_eq!(json(&["check", "arm.yaml"])["degrees_of_freedom"], 2);
    assert_eq!(json(&["check", "kr270-simulated"])["readings"], 270);
    assert_eq!(run(path, &["check", "arm.yaml", "--robot", "arm.yaml"]).status, 2);
    assert_eq!(run(path, &["check", "kr270-simulated", "--snapshot", "s"]).status, 2);
    // A snapshot holds the units in which commands take values; one of an earlier version has none.
    assert_eq!(run(path, &["check", "arm.yaml", "--snapshot", "s"]).status, 0);
    let arm = std::fs::read_to_string(path.join("arm.yaml")).expect("text");
    std::fs::write(path.join("arm.yaml"), arm.replace("units: {", "units: {force: kN, ")).expect("written");
    let ran = run(path, &["check", "arm.yaml", "--snapshot", "s"]);
    assert!(ran.status == 1 && ran.out.contains("\"force\":\"kN\""), "{}{}", ran.out, ran.err);
    let old = std::fs::read_to_string(path.join("s")).expect("a snapshot");
    let old: String = old.split("\nunits:").next().expect("a part").into();
    std::fs::write(path.join("s"), old).expect("written");
    let ran = run(path, &["check", "arm.yaml", "--snapshot", "s"]);
    assert_eq!(ran.status, 0, "{}", ran.out);
    // It holds what is declared apart from the model.
    let with = "payloads: {gripper: {mass: 5, com: [0, 0, 50]}}\ngear_ratios: {q1: 100}\n\
                combinations: {maker: {a2: {1.d: 1, 2.d: 1}}}\nvalidity: {joints: {q1: [-1, 1]}, time: [0, 60]}\n";
    let written = |text: &str| std::fs::write(path.join("arm.yaml"), format!("{arm}{text}")).expect("written");
    written(with);
    let said = run(path, &["check", "arm.yaml", "--snapshot", "apart"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(run(path, &["check", "arm.yaml", "--snapshot", "apart"]).status, 0);
    let changes = [("mass: 5", "mass: 6"), ("0, 50]", "0, 51]"), ("q1: 100", "q1: 101"), ("2.d: 1", "2.d: 2")];
    for (old, new) in changes.into_iter().chain([("[-1, 1]", "[-1, 2]"), ("[0, 60]", "[0, 61]")]) {
        written(&with.replace(old, new));
        let ran = run(path, &["check", "arm.yaml", "--snapshot", "apart"]);
        assert!(ran.status == 1 && ran.out.contains("differs"), "{new}: {}{}", ran.out, ran.err);
    }
}

/// Two results never go to one file, by whatever way it is named; a table does not end as a description.
#[test]
fn two_results_never_go_to_one_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    assert_eq!(run(at, &["init", "c"]).status, 0);
    for asked in [
        &["identify", "c", "--table", "s.csv", "--configurations", "./s.csv"][..],
        &["identify", "c", "--table", "s.csv", "--output", "c/../s.csv"],
        &["diagnose", "c", "--apply", "s.yaml", "--output", "s.yaml"],
    ] {
        let ran = run(at, asked);
        assert!(ran.status == 2 && ran.err.contains("two results would go to"), "{asked:?}: {}", ran.err);
        assert!(!at.join("s.csv").exists() && !at.join("s.yaml").exists(), "{asked:?}");
    }
    let ran = run(at, &["identify", "c", "--save", "s.yaml", "--table", "s.yaml"]);
    assert!(ran.status == 2 && ran.err.contains("a table is written"), "{}", ran.err);
    let ran = run(at, &["report", "c", "--output", "r.pdf"]);
    assert!(ran.status == 2 && ran.err.contains("end the name in .html"), "{}", ran.err);
}

/// A number below zero is refused as a value of its flag.
#[test]
fn numbers_below_zero_are_values() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "c"]).status, 0);
    for asked in
        [&["identify", "c", "--train", "-3"][..], &["simulate", "c", "--poses", "5", "--into", "d", "--seed", "-1"]]
    {
        let ran = run(folder.path(), asked);
        assert!(ran.status == 2 && ran.err.contains("invalid value '-"), "{asked:?}: {}", ran.err);
    }
}
