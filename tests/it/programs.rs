//! Programs of controllers and streamed points: what a controller would read from them is what `compensate` found.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::cli::run;

const PATH: &str = "pose,q1,q2,q3,q4,q5,q6\n\
    first (1),10,20,30,5,30,0\n\
    \"second; END\",12,22,28,100,35,-95\n\
    third,-14,24,26,-20,40,10\n";

/// A calibrated robot, and a path of joints for it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "c"]).status, 0);
    assert_eq!(run(folder.path(), &["identify", "c", "--save", "fitted.yaml"]).status, 0);
    std::fs::write(folder.path().join("path 1.csv"), PATH).expect("written");
    folder
}

fn program(at: &Path, arguments: &[&str]) -> String {
    let all = [&["compensate", "fitted.yaml", "path 1.csv", "--nominal", "c/robot.yaml"], arguments].concat();
    let ran = run(at, &all);
    assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
    ran.out
}

/// What `compensate` found: joints (deg) and the controller's pose (mm, rotation) of each point.
fn found(at: &Path) -> Vec<(Vec<f64>, Vector3<f64>, Rotation3<f64>)> {
    let json: Value = serde_json::from_str(&program(at, &["--format", "json"])).expect("JSON");
    let numbers =
        |value: &Value| -> Vec<f64> { value.as_array().expect("a list").iter().filter_map(Value::as_f64).collect() };
    let one = |point: &Value| {
        let joints = point["joints"].as_object().expect("joints").values().filter_map(Value::as_f64);
        let pose = numbers(&point["pose"]);
        let rotation = Rotation3::new(Vector3::new(pose[3], pose[4], pose[5]));
        (joints.map(f64::to_degrees).collect(), 1e3 * Vector3::new(pose[0], pose[1], pose[2]), rotation)
    };
    json["points"].as_array().expect("points").iter().map(one).collect()
}

/// Numbers of the text after `start`, in order.
fn numbers(text: &str, start: &str) -> Vec<f64> {
    let (_, rest) = text.split_once(start).unwrap_or_else(|| panic!("`{start}` in {text}"));
    let is_number = |c: char| c.is_ascii_digit() || ".-".contains(c);
    let words = rest.split(|c: char| !(is_number(c) || c.is_ascii_alphabetic())).filter(|word| !word.is_empty());
    let bare = words.map(|word| word.trim_start_matches(|c: char| c.is_ascii_alphabetic()));
    bare.filter_map(|word| word.parse().ok()).collect()
}

/// Elementary rotations from their definition, deg.
fn about(axis: usize, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.to_radians().sin_cos();
    match axis {
        0 => Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c),
        1 => Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c),
        _ => Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
    }
}

fn close(a: &[f64], b: &[f64], what: &str) {
    assert!(a.len() >= b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{what}: {a:?} {b:?}");
}

#[test]
fn programs_name_the_commands_that_were_found() {
    let folder = folder();
    let at = folder.path();
    let expected = found(at);
    for (language, start) in
        [("krl", "PTP {E6AXIS:"), ("rapid", "MoveAbsJ [["), ("urscript", "movej("), ("fanuc-ls", "UT : 1,")]
    {
        let text = program(at, &["--program", language]);
        let moves: Vec<&str> = text.split(start).skip(1).collect();
        assert_eq!(moves.len(), expected.len(), "{text}");
        for (own, (joints, _, _)) in moves.iter().zip(&expected) {
            let own = numbers(&format!("|{own}"), "|");
            // KRL and FANUC number their axes: A1 12.3 is 1 and 12.3, J1= 12.3 the same.
            let values: Vec<f64> = match language {
                "krl" | "fanuc-ls" => own.chunks(2).take(6).map(|pair| pair[1]).collect(),
                "urscript" => own.iter().take(6).map(|v| v.to_degrees()).collect(),
                _ => own,
            };
            close(&values, joints, language);
        }
    }
}

#[test]
fn programs_name_the_poses_that_the_controller_must_be_given() {
    let folder = folder();
    let at = folder.path();
    let expected = found(at);
    let same = |own: &Matrix3<f64>, rotation: &Rotation3<f64>, what: &str| {
        assert!((own - rotation.matrix()).amax() < 1e-7, "{what}: {own} {rotation}");
    };
    for (language, start) in [
        ("krl", "LIN {"),
        ("rapid", "MoveL [["),
        ("urscript", "movel(p["),
        ("fanuc-ls", "CONFIG : 'N U T, 0, 0, 0',"),
        ("gcode", "G1 "),
    ] {
        let text = program(at, &["--program", language, "--moves", "poses", "--speed", "80"]);
        let moves: Vec<&str> = text.split(start).skip(1).collect();
        assert_eq!(moves.len(), expected.len(), "{text}");
        for (own, (_, position, rotation)) in moves.iter().zip(&expected) {
            let own = numbers(&format!("|{own}"), "|");
            let scale = if language == "urscript" { 1e3 } else { 1.0 };
            close(&own[..3].iter().map(|v| scale * v).collect::<Vec<_>>(), position.as_slice(), language);
            let turned = match language {
                "krl" => about(2, own[3]) * about(1, own[4]) * about(0, own[5]),
                "fanuc-ls" | "gcode" => about(2, own[5]) * about(1, own[4]) * about(0, own[3]),
                "urscript" => Rotation3::new(Vector3::new(own[3], own[4], own[5])).into_inner(),
                _ => {
                    let q = UnitQuaternion::new_unchecked(Quaternion::new(own[3], own[4], own[5], own[6]));
                    q.to_rotation_matrix().into_inner()
                }
            };
            same(&turned, rotation, language);
        }
    }
    let speeds = [
        ("krl", "$VEL.CP = 0.0800"),
        ("rapid", "[80.000,"),
        ("urscript", "v=0.0800"),
        ("fanuc-ls", "80mm/sec"),
        ("gcode", "F4800.0"),
    ];
    for (language, speed) in speeds {
        let text = program(at, &["--program", language, "--moves", "poses", "--speed", "80"]);
        assert!(text.contains(speed), "{text}");
    }
}

/// Names of points cannot end a comment; the program's name is one that controllers take.
#[test]
fn names_stay_names() {
    let folder = folder();
    let krl = program(folder.path(), &["--program", "krl"]);
    assert!(krl.contains("DEF path_1()") && krl.contains("; second END\n") && krl.contains("; first 1\n"), "{krl}");
    let gcode = program(folder.path(), &["--program", "gcode", "--program-name", "7 of 9"]);
    assert!(gcode.contains("(first 1)\n"), "{gcode}");
    let named = program(folder.path(), &["--program", "rapid", "--program-name", "7 of 9"]);
    assert!(named.contains("PROC p_7_of_9()"), "{named}");
}

#[test]
fn a_template_of_ones_own_and_what_is_refused() {
    let folder = folder();
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("written");
    write("own.j2", "{% for p in points %}{{ p.name }}={{ p.axes[0]|fixed(3) }};{% endfor %}\n");
    let own = program(at, &["--program", "own.j2"]);
    let expected: Vec<String> = found(at).iter().map(|(joints, _, _)| format!("={:.3};", joints[0])).collect();
    assert!(expected.iter().all(|part| own.contains(part)), "{own}");
    let json: Value = serde_json::from_str(&program(at, &["--program", "json"])).expect("JSON");
    assert_eq!(json["points"].as_array().map(Vec::len), Some(3));
    let table = program(at, &["--program", "csv"]);
    assert!(table.starts_with("name,q1 [deg],") && table.contains("\nfirst (1),"), "{table}");
    let whole: Value = serde_json::from_str(&program(at, &["--program", "krl", "--format", "json"])).expect("JSON");
    assert!(
        whole["program"]["text"].as_str().is_some_and(|text| text.starts_with("&ACCESS")) && whole["points"].is_array()
    );

    write("faulty.j2", "line 1\n{{ points[0].nothing }}\n");
    write("open.j2", "{% for p in points %}\n");
    write("far.csv", "pose,q1,q2,q3,q4,q5,q6\na,10,20,30,5,30,0\nb,900,20,30,5,30,0\n");
    let refused: [(&[&str], i32, &str); 6] = [
        (&["path 1.csv", "--program", "klr"], 2, "krl, rapid"),
        (&["path 1.csv", "--program", "faulty.j2"], 2, "faulty.j2:2"),
        (&["path 1.csv", "--program", "open.j2"], 2, "open.j2"),
        (&["path 1.csv", "--program", "gcode", "--moves", "joints"], 2, "--moves poses"),
        (&["path 1.csv", "--program", "krl", "--speed", "0"], 2, "--speed 0"),
        (&["far.csv", "--program", "krl"], 1, ""),
    ];
    for (arguments, status, said) in refused {
        let ran = run(at, &[&["compensate", "fitted.yaml", "--nominal", "c/robot.yaml"], arguments].concat());
        assert!(ran.status == status && ran.err.contains(said), "{arguments:?}: {} {}", ran.status, ran.err);
        assert!(!ran.out.contains("&ACCESS"), "{}", ran.out);
    }
    let rest =
        ["compensate", "fitted.yaml", "far.csv", "--nominal", "c/robot.yaml", "--program", "krl", "--keep-going"];
    let ran = run(at, &rest);
    assert!(ran.status == 1 && ran.out.contains("; a\n") && !ran.out.contains("; b\n"), "{}", ran.out);
}

fn streamed(at: &Path, arguments: &[&str], input: impl AsRef<[u8]>) -> (i32, String, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_elastogeo"))
        .args([&["compensate", "fitted.yaml", "--nominal", "c/robot.yaml", "--stream"], arguments].concat())
        .current_dir(at)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    // One that refuses its arguments reads nothing.
    let _ = child.stdin.take().expect("a pipe").write_all(input.as_ref());
    let out = child.wait_with_output().expect("ended");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (out.status.code().unwrap_or(-1), text(out.stdout), text(out.stderr))
}

/// Line by line the same commands as the whole path, also where they depend on the side from which a joint comes.
#[test]
fn a_stream_answers_as_the_whole_path_does() {
    let folder = folder();
    let at = folder.path();
    let fitted = std::fs::read_to_string(at.join("fitted.yaml")).expect("text");
    let slack = "effects:\n- effect: backlash\n  site: joint:2\n  parameters: {half_width: 0.0005, changes_at: 0.0}\n";
    for text in [fitted.clone(), format!("{fitted}{slack}")] {
        std::fs::write(at.join("fitted.yaml"), text).expect("written");
        let expected = found(at);
        let (status, out, err) = streamed(at, &[], PATH);
        assert_eq!(status, 0, "{err}");
        let lines: Vec<&str> = out.lines().collect();
        assert_eq!(lines[0], "pose,status,q1,q2,q3,q4,q5,q6,x,y,z,rx,ry,rz");
        assert!(err.contains("3 points, 0 refused; from a line read to its answer written"), "{err}");
        let mut reader = csv::ReaderBuilder::new().from_reader(out.as_bytes());
        // Of the first point only the whole path knows how it will be left.
        for (row, (joints, position, _)) in reader.records().zip(&expected).skip(1) {
            let row = row.expect("a row");
            let own: Vec<f64> = row.iter().skip(2).filter_map(|cell| cell.parse().ok()).collect();
            close(&own, joints, "stream");
            close(&own[6..], position.as_slice(), "stream");
        }
    }
}

#[test]
fn a_stream_answers_what_it_cannot_read_and_goes_on() {
    let folder = folder();
    let at = folder.path();
    let (status, out, err) =
        streamed(at, &[], "pose,q1,q2,q3,q4,q5,q6\na,10,20,30,5,30,0\nb,ten,20,30,5,30,0\n\nc,11,20,30,5,30,0\n");
    let lines: Vec<&str> = out.lines().collect();
    assert!(status == 1 && lines.len() == 4, "{status} {out} {err}");
    assert!(lines[1].starts_with("a,ok,") && lines[2].contains("refused") && lines[2].contains("ten"), "{out}");
    assert!(lines[3].starts_with("c,ok,") && err.contains("3 points, 1 refused"), "{out} {err}");
    // The place of a refusal is that in the stream, and the point keeps its name; a header is answered before any point.
    assert!(lines[2].starts_with("b,") && lines[2].contains("line 3, column 3:"), "{out}");
    let (status, out, _) = streamed(at, &[], "q1,q2,q3,q4,q5,q6\n");
    assert!(status == 0 && out.lines().count() == 1 && out.starts_with("pose,"), "{out}");
    // Bytes that are no text, and points without names.
    let (status, out, _) =
        streamed(at, &[], b"q1,q2,q3,q4,q5,q6\n10,20,30,5,30,0\n\xff\xfe,20,30,5,30,0\n11,20,30,5,30,0\n");
    let lines: Vec<&str> = out.lines().collect();
    assert!(status == 1 && lines.len() == 4, "{status} {out}");
    assert!(
        lines[1].starts_with("row 1,ok,") && lines[2].starts_with("row 2,") && lines[3].starts_with("row 3,ok,"),
        "{out}"
    );
    // The word to spreadsheets is skipped; orientations are read as the option says, and answered as rotation vectors are.
    let (status, out, err) = streamed(at, &[], "sep=;\nq1;q2;q3;q4;q5;q6\n10;20;30;5;30;0\n");
    assert!(status == 0 && out.lines().nth(1).is_some_and(|line| line.starts_with("row 1,ok,")), "{out} {err}");
    let of = |columns: &str, angles: &str| format!("q1,q2,q3,q4,q5,q6,x,y,z,{columns}\n10,20,30,5,30,0,{angles}\n");
    let [vectors, abc] = ["rx,ry,rz", "A,B,C"].map(|columns| of(columns, "1000,100,900,0,60,0"));
    let (expected, own) = (streamed(at, &[], vectors), streamed(at, &["--orientation", "kuka-abc"], &abc));
    assert_eq!(own.1, expected.1, "{}", own.2);
    let (status, _, err) = streamed(at, &[], &abc);
    assert!(status == 2 && err.contains("--orientation kuka-abc"), "{err}");
    let (status, out, _) = streamed(at, &["--format", "json"], PATH);
    let first: Value = serde_json::from_str(out.lines().next().expect("a line")).expect("JSON");
    assert!(status == 0 && out.lines().count() == 3 && first["joints"]["q1"].is_number(), "{out}");
    for (arguments, input, said) in [
        (&[][..], "", "standard input is empty"),
        (&[], "pose,q1,q2\na,1,2\n", "joints"),
        (&[], "foo,bar\n", "unknown column `foo`"),
        (&[], "q1,q2,q3\n", "q4, q5, q6"),
        (&[], "{\"q1\":10,\"q2\":20}\n", "unknown column"),
        (&["--program", "krl"], PATH, "--program"),
        (&["--output", "x.csv"], PATH, "redirect"),
    ] {
        let (status, _, err) = streamed(at, arguments, input);
        assert!(status == 2 && err.contains(said), "{arguments:?} {status} {err}");
    }
}

/// Straight moves between points at which the wrist stands on other sides, and a program that stands where refused points would be written.
#[test]
fn straight_moves_through_a_turned_wrist_are_told() {
    let folder = folder();
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("written");
    write("flip.csv", "q1,q2,q3,q4,q5,q6\n10,20,30,5,-30,0\n10,20,30,5,30,0\n");
    write("same.csv", "q1,q2,q3,q4,q5,q6\n10,20,30,5,30,0\n12,20,32,5,35,0\n");
    let program = |path: &str, language: &str, moves: &str| {
        let of = ["compensate", "fitted.yaml", path, "--nominal", "c/robot.yaml", "--program", language];
        run(at, &[&of[..], &["--moves", moves]].concat())
    };
    for language in ["krl", "rapid", "urscript", "fanuc-ls"] {
        let told = program("flip.csv", language, "poses");
        assert!(told.status == 0 && told.err.contains("1 of 1 straight moves do not lead"), "{language}: {}", told.err);
        for (path, moves) in [("flip.csv", "joints"), ("same.csv", "poses")] {
            let ran = program(path, language, moves);
            assert!(ran.status == 0 && ran.err.is_empty(), "{language} {path} {moves}: {}", ran.err);
        }
    }
    // The first point is reached by its joints.
    let fanuc = program("same.csv", "fanuc-ls", "poses").out;
    assert!(fanuc.contains(":J P[3] 10% FINE ;") && fanuc.contains("P[3:\"start\"]"), "{fanuc}");

    write("far.csv", "x,y,z,rx,ry,rz\n9000,0,0,0,0,0\n");
    write("keep.src", "an old program");
    let of = ["compensate", "fitted.yaml", "far.csv", "--nominal", "c/robot.yaml", "--program", "krl"];
    let ran = run(at, &[&of[..], &["--output", "keep.src"]].concat());
    assert!(ran.status == 1 && ran.out.contains("no program is written"), "{}{}", ran.out, ran.err);
    assert_eq!(std::fs::read_to_string(at.join("keep.src")).expect("read"), "an old program");
}
