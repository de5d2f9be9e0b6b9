//! Files as laboratories have them, each wrong in one way: refused with the place and what to do.

use std::path::Path;

use super::cli::{PLANAR, run};

const CAMPAIGN: &str = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: pose
orientation: {quaternion: xyzw}
measurements: {file: readings.csv, joints: joints.csv}
";
const READINGS: &str =
    "pose,x,y,z,qx,qy,qz,qw\na,900,0,0,0,0,0,1\nb,0,900,0,0,0,0.7071067811865476,0.7071067811865476\n";
const JOINTS: &str = "pose,q1,q2\nb,90,0\na,0,0\n";
const LIST: &str = "// exported\nlab\ttip\ta\t910\t0\t0\nlab\ttip\tb\t0\t910\t0\n";

/// A file, a piece of it, and what takes its place.
type Change = (&'static str, &'static str, &'static str);

/// The files, one of them changed.
fn files(change: (&str, &str, &str)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("arm.yaml", PLANAR);
    let (file, from, to) = change;
    for (name, text) in [("c.yaml", CAMPAIGN), ("readings.csv", READINGS), ("joints.csv", JOINTS), ("list.txt", LIST)] {
        assert!(name != file || text.contains(from), "{change:?}");
        write(name, &if name == file { text.replacen(from, to, 1) } else { text.into() });
    }
    folder
}

fn refused(folder: &Path, change: &(&str, &str, &str), expected: &[&str]) {
    let ran = run(folder, &["residuals", "arm.yaml", "c.yaml"]);
    assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{change:?}\n{}", ran.err);
    for word in expected {
        assert!(ran.err.contains(word), "`{word}` is not said of {change:?}\n{}", ran.err);
    }
    assert!(ran.err.contains("1 error, "), "one fault, one error: {change:?}\n{}", ran.err);
    assert!(ran.err.contains("help: "), "no remedy: {change:?}\n{}", ran.err);
}

#[test]
fn the_sound_files_are_read() {
    let sound = files(("c.yaml", "robot", "robot"));
    let ran = run(sound.path(), &["residuals", "arm.yaml", "c.yaml", "--format", "json"]);
    assert_eq!((ran.status, ran.err.as_str()), (0, ""));
    let found: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let error = |pointer: &str| found.pointer(pointer).and_then(serde_json::Value::as_f64).expect("a number").abs();
    for row in 0..2 {
        for axis in 0..3 {
            assert!(error(&format!("/readings/{row}/error/{axis}")) < 1e-9);
            assert!(error(&format!("/readings/{row}/orientation_error_deg/{axis}")) < 1e-9);
        }
    }
}

#[test]
fn wrong_files_are_refused_with_place_and_remedy() {
    let either = "`orientation: {quaternion: xyzw}` or `orientation: {quaternion: wxyz}`";
    let cases: [(Change, &[&str]); 17] = [
        (("c.yaml", "orientation: {quaternion: xyzw}\n", ""), &["readings.csv:1:12", "how is not declared", either]),
        (("c.yaml", "{quaternion: xyzw}", "kuka-abc"), &["readings.csv:1:12", "hold an orientation", either]),
        (("c.yaml", "quaternion: xyzw", "quaternion: zyxw"), &["c.yaml:4:", "zyxw", "xyzw"]),
        (
            ("c.yaml", "joints: joints.csv", "join: order"),
            &["c.yaml:5:", "`join:` means nothing here", "add `joints:`"],
        ),
        (("c.yaml", "joints: joints.csv", "joints: joint.csv"), &["c.yaml:5:", "no file", "joints.csv`"]),
        (("c.yaml", "joints.csv}", "joints.csv, points: {pose: name}}"), &["c.yaml:5:", "add `format: points`"]),
        (
            ("c.yaml", "joints.csv}", "joints.csv, columns: {q3: A3}}"),
            &["c.yaml:5:", "`q3`, which is no column", "`q1`"],
        ),
        (
            ("readings.csv", "0,0,0,1\n", "0,0,0.1,1\n"),
            &["readings.csv:2:11", "the length 1.004988", "correct the row"],
        ),
        (("readings.csv", "\nb,0", "\nc,0"), &["readings.csv:3:1", "`c` has readings, and", "joints.csv"]),
        (
            ("joints.csv", "b,90,0\n", "b,90,0\nb,91,0\n"),
            &["joints.csv:3:1", "has two rows of joints", "joints.csv:2:1"],
        ),
        (("joints.csv", "b,90,0", "b,90"), &["joints.csv:2:5", "2 fields in this row, expected 3"]),
        (
            ("joints.csv", "pose,q1,q2\n", "pose,q1,q2\n,mm,deg\n"),
            &["joints.csv:2:2", "`q1` holds angles", "correct the unit"],
        ),
        (("joints.csv", "q2\n", "q2\n-,furlong,deg\n"), &["joints.csv:2:3", "`furlong` is no unit of angles"]),
        (("joints.csv", "90,0", "9O,0"), &["joints.csv:2:3", "found `9O`"]),
        (("joints.csv", "q1,q2", "q1,Q2"), &["joints.csv:1:9", "the column `q2` is missing"]),
        (
            ("readings.csv", "pose,x", "sep=;\npose,x"),
            &["readings.csv:2:5", "is `,` the delimiter?", "correct the first line"],
        ),
        (("readings.csv", "pose,x", "name,x"), &["readings.csv:1:1", "unknown column `name`"]),
    ];
    for (change, expected) in &cases {
        refused(files(*change).path(), change, expected);
    }
}

#[test]
fn lists_of_points_are_refused_where_they_could_mean_something_else() {
    let position = "observes: position\nmeasurements: {file: list.txt, format: points, points: {pose: name, marker: group}, joints: joints.csv}\n";
    let campaign = CAMPAIGN.split("observes").next().expect("a part").to_owned() + position;
    let cases: [(&str, &str, &[&str]); 5] = [
        ("tip\tb\t0\t910\t0", "tip\tc\t0\t910\t0", &["list.txt:3:9", "`c` has readings"]),
        (
            "lab\ttip\ta\t910\t0\t0",
            "lab\ttip\ta\t910\t0\t0\t0.012",
            &["list.txt:2:1", "this is no point as expected", "fields: ["],
        ),
        (
            "lab\ttip\ta\t910\t0\t0\nlab\ttip\tb\t0\t910\t0",
            "a\t910\t0\t0\nb\t0\t910\t0",
            &["takes `marker` from the field `group`", "they have name"],
        ),
        ("tip\tb\t0", "SMR\tb\t0", &["list.txt:3:5", "unknown marker `SMR`"]),
        ("b\t0\t910\t0", "b\t0\t910", &["list.txt:3:", "5 fields in this row, expected 6"]),
    ];
    for (from, to, expected) in cases {
        let folder = files(("list.txt", from, to));
        std::fs::write(folder.path().join("c.yaml"), &campaign).expect("written");
        refused(folder.path(), &("list.txt", from, to), expected);
    }
    // A collection is a session where that is said, and its name one of sessions.
    let by_collection = campaign.replace("{pose: name,", "{session: collection, pose: name,");
    let folder = files(("list.txt", "lab\ttip\tb", "lab 2\ttip\tb"));
    std::fs::write(folder.path().join("c.yaml"), &by_collection).expect("written");
    refused(
        folder.path(),
        &("list.txt", "lab", "lab 2"),
        &["list.txt:3:1", "`lab 2` is no name of a session", "letters, digits"],
    );
    let folder = files(("list.txt", "lab\ttip\tb", "lab2\ttip\tb"));
    std::fs::write(folder.path().join("c.yaml"), by_collection).expect("written");
    let ran = run(folder.path(), &["residuals", "arm.yaml", "c.yaml"]);
    assert!(ran.status == 0 && ran.out.contains("session lab2"), "{}{}", ran.out, ran.err);
    let folder = files(("list.txt", "//", "//"));
    std::fs::write(folder.path().join("c.yaml"), &campaign).expect("written");
    let ran = run(folder.path(), &["residuals", "arm.yaml", "c.yaml"]);
    assert!(
        ran.status == 0 && ran.out.contains("all                2    0.0000   0.0000   0.0000"),
        "{}{}",
        ran.out,
        ran.err
    );
}
