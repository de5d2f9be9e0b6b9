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

/// What is said of a change.
type Case = (Change, &'static [&'static str]);

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

/// Orientations that are written twice, components that are called as joints, and columns under the names of instruments.
#[test]
fn columns_of_other_names_are_refused_with_what_they_may_be() {
    let cases: [(&str, &str, &str, &[&str]); 5] = [
        (
            "xyzw",
            "pose,x,y,z,qx,qy,qz,qw,rx,ry,rz",
            "a,900,0,0,0,0,0,1,0,0,0",
            &["the orientation is read from qx, qy, qz, qw: list rx, ry, rz under `ignore:`"],
        ),
        (
            "",
            "pose,x,y,z,rx,ry,rz,qx,qy,qz,qw",
            "a,900,0,0,0,0,0,0,0,0,1",
            &["the orientation is read from rx, ry, rz: list qx, qy, qz, qw under `ignore:`", "{quaternion: ..}`"],
        ),
        (
            "xyzw",
            "pose,sequence,x,y,z,qx,qy,qz,qw",
            "a,1,900,0,0,0,0,0,1",
            &["unknown column `sequence`", "if it is `order`, add `columns: {order: sequence}`"],
        ),
        (
            "",
            "pose,q1,q2,q3,x,y,z,q0,q1,q2,q3",
            "a,0,0,0,900,0,0,0,0,0,1",
            &[
                "q0, q1, q2, q3 look like a quaternion, and joints are called so",
                "name its components qx, qy, qz and qw",
            ],
        ),
        (
            "xyzw",
            "pose,j1,j2,j3,x,y,z,q0,q1,q2,q3",
            "a,0,0,0,900,0,0,0,0,0,1",
            &["q0, q1, q2, q3 look like a quaternion, and joints are called so", "`{quaternion: wxyz}`"],
        ),
    ];
    for (declared, header, row, expected) in cases {
        let folder = files(("c.yaml", "robot", "robot"));
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
        let declared = if declared.is_empty() { "" } else { "orientation: {quaternion: xyzw}" };
        let text = CAMPAIGN.replace("orientation: {quaternion: xyzw}", declared);
        let joints = header.contains("q2");
        let text = if joints { text.replace(", joints: joints.csv", "") } else { text };
        let renamed = if header.contains("j1") { "columns: {q1: j1, q2: j2, q3: j3}\n" } else { "" };
        write("c.yaml", &(text + renamed));
        write("readings.csv", &format!("{header}\n{row}\n"));
        let ran = run(folder.path(), &["residuals", "arm.yaml", "c.yaml"]);
        assert_eq!(ran.status, 2, "{}", ran.err);
        expected.iter().for_each(|word| assert!(ran.err.contains(word), "`{word}`: {}", ran.err));
        assert!(!["`rx` is missing", "`qx` is missing"].iter().any(|word| ran.err.contains(word)), "{}", ran.err);
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
    // What differs and is not used is told.
    let folder = files(("list.txt", "tip\tb", "SMR\tb"));
    std::fs::write(folder.path().join("c.yaml"), campaign.replace("{pose: name, marker: group}", "{pose: name}"))
        .expect("written");
    let ran = run(folder.path(), &["residuals", "arm.yaml", "c.yaml"]);
    assert!(ran.err.contains("the field `group` of the points is not used, and differs: `tip`, `SMR`"), "{}", ran.err);
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

const TOUCHED: &str = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: contact
estimate: {tool: true}
contacts: {s0: {kind: socket, group: placement}, s1: {kind: socket, group: placement}}
distances: {s0-s1: 50}
measurements: touched.csv
";
const TOUCHES: &str =
    "pose,q1,q2,placement,contact\na,10,20,left,s0\nb,20,30,left,s1\nc,30,50,left,s0\nd,45,10,left,s1\n";
const SESSIONS: &str = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: position
estimate: {base: per session}
payloads: {heavy: {mass: 5, com: [0, 0, 50], frame: \"2\"}}
measurements: [{file: monday.csv, session: monday}, {file: friday.csv, session: friday}]
";
const MONDAY: &str = "pose,q1,q2,x,y,z,order,payload\na,90,0,0,900,0,1,heavy\nb,0,0,900,0,0,2,heavy\n";

/// Evidence besides positions of one session: contacts, sessions, order, payloads, uncertainties, commanded joints, torques.
#[test]
fn wrong_evidence_is_refused_with_place_and_remedy() {
    let refused = |files: [(&str, &str); 3], change: (&str, &str, &str), expected: &[&str]| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("arm.yaml"), PLANAR).expect("written");
        let (file, from, to) = change;
        for (name, text) in files {
            assert!(name != file || text.contains(from), "{change:?}");
            let text = if name == file { text.replace(from, to) } else { text.into() };
            std::fs::write(folder.path().join(name), text).expect("written");
        }
        // Readings that no arm has made are forced; what is wrong with the files is not.
        let ran = run(folder.path(), &["check", "c.yaml", "--force"]);
        if from == to {
            return assert_eq!(ran.status, 0, "{change:?}\n{}", ran.err);
        }
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{change:?}\n{}", ran.err);
        expected
            .iter()
            .for_each(|word| assert!(ran.err.contains(word), "`{word}` is not said of {change:?}\n{}", ran.err));
        let faults = ran.err.lines().filter(|line| line.starts_with("error: ")).count();
        assert_eq!(faults, ran.err.matches("help: ").count(), "{change:?}\n{}", ran.err);
    };
    let touched = [("c.yaml", TOUCHED), ("touched.csv", TOUCHES), ("none.csv", "")];
    let contacts: [Case; 12] = [
        (("c.yaml", "robot", "robot"), &[]),
        (("c.yaml", "s0: {kind: socket", "s0: {kind: hole"), &["c.yaml:5:", "`hole`", "`socket`, `plane`, `sphere`"]),
        (("c.yaml", "s0-s1", "s0-s7"), &["c.yaml:6:", "names no two contacts"]),
        (("c.yaml", "distances: {s0-s1: 50}", "distances: {s0-s1: -5}"), &["c.yaml:6:"]),
        (("touched.csv", "placement", "plate"), &["touched.csv:1:", "unknown column `plate`"]),
        (("touched.csv", "left,s1", "left,s2"), &["touched.csv:3:", "unknown contact `s2`", "did you mean"]),
        (("touched.csv", ",contact", ",socket"), &["touched.csv:1:", "unknown column `socket`", "`columns:`"]),
        (
            (
                "c.yaml",
                "contacts: {s0: {kind: socket, group: placement}, s1: {kind: socket, group: placement}}\ndistances: {s0-s1: 50}\n",
                "",
            ),
            &["contacts are observed, and none is declared"],
        ),
        (("c.yaml", "group: placement", "group: plate"), &["`plate`, which names none", "add the column"]),
        (("c.yaml", "s1: {kind: socket", "s1: {normal: [0, 0, 1], kind: socket"), &["c.yaml:5:", "no normal"]),
        (
            (
                "c.yaml",
                "{kind: socket, group: placement}, s1: {kind: socket",
                "{kind: socket, at: [0, 0, 0], group: placement}, s1: {kind: socket, at: [60, 0, 0]",
            ),
            &["c.yaml:6:", "the distance is 50, and the points given are 60.0000 apart"],
        ),
        (("c.yaml", "observes: contact", "observes: []"), &["c.yaml:", "`observes` names no kind"]),
    ];
    contacts.iter().for_each(|(change, expected)| refused(touched, *change, expected));
    let friday = MONDAY.replace("a,90", "c,90").replace("b,0", "d,0").replace("900", "901");
    let measured = [("c.yaml", SESSIONS), ("monday.csv", MONDAY), ("friday.csv", friday.as_str())];
    let sessions: [Case; 18] = [
        (("c.yaml", "robot", "robot"), &[]),
        (("c.yaml", "per session", "per sesion"), &["c.yaml:4:", "did you mean `per-session`?"]),
        (
            ("c.yaml", "session: friday", "session: \"last friday\""),
            &["c.yaml:6:", "`last friday` is no name of a session"],
        ),
        (("c.yaml", "file: friday.csv", "file: sunday.csv"), &["c.yaml:6:", "no file `sunday.csv`"]),
        (("c.yaml", "frame: \"2\"", "frame: \"9\""), &["c.yaml:5:", "`9`"]),
        (("c.yaml", "mass: 5", "mass: -5"), &["c.yaml:5:"]),
        (("c.yaml", "file: friday.csv, ", ""), &["c.yaml:6:", "no file is named"]),
        (
            ("c.yaml", "session: friday", "session: friday, mount: [0, 0, 0]"),
            &["c.yaml:6:", "`body:` and `mount:` are of inclinations"],
        ),
        (
            ("c.yaml", "session: friday", "session: friday, on: pedestal"),
            &["c.yaml:6:", "`on:` says what fixed reflectors stand on"],
        ),
        (
            ("c.yaml", "position\n", "[position, torque]\n"),
            &["c.yaml:3:", "torques are observed, and no joint has a column"],
        ),
        (("c.yaml", "position\n", "position\njoints: commanded\n"), &["monday.csv:1:", "`commanded.q1` is missing"]),
        (("c.yaml", "position\n", "position\ninstrument: {sigma: 0.05, ppm: -3}\n"), &["c.yaml:4:", "-3"]),
        (("c.yaml", "position\n", "position\nreferences: r.csv\n"), &["c.yaml:4:", "no file `r.csv`"]),
        (
            ("monday.csv", "heavy", "light"),
            &["monday.csv:2:", "unknown payload `light`", "valid here: `heavy`, `none`"],
        ),
        (
            ("monday.csv", ",order,payload\na,90,0,0,900,0,1,", ",sigma,payload\na,90,0,0,900,0,-1,"),
            &["monday.csv:2:", "`-1` where a finite noise above 0 is needed"],
        ),
        (("monday.csv", "900,0,1,heavy", "900,0,first,heavy"), &["monday.csv:2:", "`order`", "`first`"]),
        (
            ("monday.csv", "b,0,0,900,0,0,2,heavy\n", "b,0,0,900,0,0,2\n"),
            &["monday.csv:3:", "7 fields in this row, expected 8"],
        ),
        (
            ("friday.csv", "\nc,90,0,0,901,0,1,heavy\nd,0,0,901,0,0,2,heavy", ""),
            &["friday.csv:1:1", "a header and no rows"],
        ),
    ];
    sessions.iter().for_each(|(change, expected)| refused(measured, *change, expected));
    for (kind, declared, said) in [
        ("distance", "", "none is declared"),
        ("torque", "torques: {q9: {gain: unknown}}\n", "`q9`, which is no variable"),
        ("inclination", "", "inclination needs the columns"),
    ] {
        let campaign = format!("robot: arm.yaml\nobserves: {kind}\n{declared}measurements: m.csv\n");
        let files = [("c.yaml", campaign.as_str()), ("m.csv", "pose,q1,q2\na,0,0\n"), ("none.csv", "")];
        refused(files, ("c.yaml", "arm.yaml\n", "arm.yaml\n\n"), &[said]);
    }
}

/// What an instrument states of torques and of the distance, and the version of the format.
#[test]
fn impossible_noises_and_formats_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "c"]).status, 0);
    let path = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let with = |instrument: &str| {
        let lines = text.lines().map(|line| if line.starts_with("instrument:") { instrument } else { line });
        std::fs::write(&path, lines.map(|line| format!("{line}\n")).collect::<String>()).expect("written");
        run(folder.path(), &["check", "c"])
    };
    assert_eq!(with("instrument: {sigma: 0.05}\nformat: 2").status, 0);
    for (instrument, expected) in [
        ("instrument: {torque: -0.1}", "noise is -0.1, and must be a finite number above 0"),
        ("instrument: {torque: 0}", "noise is 0, and must be a finite number above 0"),
        ("instrument: {sigma: 0.03, ppm: 1e9}", "`ppm: 1000000000` of the instrument"),
        ("instrument: {sigma: 0.05}\nformat: 3", "format 3 is not known"),
    ] {
        let ran = with(instrument);
        assert!(ran.status == 2 && ran.err.contains(expected), "{instrument}: {} {}", ran.status, ran.err);
        assert!(ran.err.contains("campaign.yaml:"), "{}", ran.err);
    }
    let kinds = text.replacen("observes: position", "observes: [position, position]", 1);
    std::fs::write(&path, kinds).expect("written");
    let ran = run(folder.path(), &["check", "c"]);
    assert!(ran.status == 2 && ran.err.contains("`observes` names `position` twice"), "{}", ran.err);
}
