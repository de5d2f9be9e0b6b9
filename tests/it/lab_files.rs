//! Files as a laboratory writes them, with what goes wrong there: each is taken as meant, or told.

use std::path::Path;

use serde_json::Value;

use super::cli::{Ran, run};
use crate::support::{number, printed_json};

/// A simulated campaign in `c` of a folder.
fn simulated(arguments: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run(folder.path(), &[&["simulate"], arguments, &["--into", "c"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    folder
}

/// Header and rows of the campaign's measurements.
fn rows(folder: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(folder.join("c/measurements.csv")).expect("a table");
    let header = reader.headers().expect("a header").iter().map(String::from).collect();
    (header, reader.records().map(|row| row.expect("a row").iter().map(String::from).collect()).collect())
}

/// Writes other measurements for the campaign, whose file is changed too.
fn written(folder: &Path, header: &[String], rows: &[Vec<String>], change: impl Fn(String) -> String) {
    let mut writer = csv::Writer::from_path(folder.join("c/measurements.csv")).expect("a table");
    writer.write_record(header).expect("written");
    rows.iter().for_each(|row| writer.write_record(row).expect("written"));
    writer.flush().expect("written");
    let path = folder.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("a campaign");
    std::fs::write(path, change(text)).expect("written");
}

fn at(header: &[String], name: &str) -> usize {
    header.iter().position(|known| known == name).unwrap_or_else(|| panic!("no column {name}"))
}

fn codes(ran: &Ran) -> Vec<String> {
    let json: Value = serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}: {} {}", ran.out, ran.err));
    let all = json["diagnostics"].as_array().expect("a list");
    all.iter().map(|one| one["code"].as_str().expect("a code").to_string()).collect()
}

/// Bases of two sessions that are 1 mm apart hide behind the robot's own errors until it is calibrated.
#[test]
fn sessions_that_differ_by_less_than_the_robot_are_told_after_calibration() {
    let folder = simulated(&["universal-ur5", "--poses", "60", "--noise", "0.03", "--seed", "1", "--unknown-base"]);
    let (mut header, mut all) = rows(folder.path());
    let x = at(&header, "x");
    for (k, row) in all.iter_mut().enumerate() {
        let is_other = k % 2 == 1;
        if is_other {
            row[x] = (row[x].parse::<f64>().expect("a number") + 1.0).to_string();
        }
        row.push(if is_other { "tue" } else { "mon" }.into());
    }
    header.push("session".into());
    written(folder.path(), &header, &all, |text| text);
    let told = run(folder.path(), &["identify", "c", "--format", "json"]);
    assert!(codes(&told).contains(&"sessions-differ".to_string()), "{}", told.err);
    assert!(told.err.contains("in the base") && told.err.contains("estimate base per session?"), "{}", told.err);
    written(folder.path(), &header, &all, |text| text.replace("base: true", "base: per-session"));
    let quiet = run(folder.path(), &["identify", "c", "--format", "json"]);
    assert!(!codes(&quiet).contains(&"sessions-differ".to_string()), "{}", quiet.err);
}

/// A controller that is read before the arm stands still: the commanded joints beside are where it stood.
#[test]
fn the_other_column_of_joints_is_tried() {
    let folder = simulated(&["universal-ur5", "--poses", "60", "--noise", "0.02", "--seed", "2", "--unknown-base"]);
    let (mut header, mut all) = rows(folder.path());
    let joints: Vec<usize> = (1..=6).map(|k| at(&header, &format!("q{k}"))).collect();
    let mut last: Option<Vec<f64>> = None;
    for row in &mut all {
        let commanded: Vec<f64> = joints.iter().map(|&k| row[k].parse().expect("a number")).collect();
        let before = last.replace(commanded.clone()).unwrap_or_else(|| commanded.clone());
        for ((&k, now), before) in joints.iter().zip(&commanded).zip(before) {
            row[k] = (now - 2e-3 * (now - before)).to_string();
            row.push(now.to_string());
        }
    }
    header.extend((1..=6).map(|k| format!("commanded.q{k}")));
    written(folder.path(), &header, &all, |text| text);
    let told = run(folder.path(), &["identify", "c", "--format", "json"]);
    assert!(codes(&told).contains(&"other-joints".to_string()), "{}", told.err);
    written(folder.path(), &header, &all, |text| text + "joints: commanded\n");
    let quiet = run(folder.path(), &["identify", "c", "--format", "json"]);
    assert!(!codes(&quiet).contains(&"other-joints".to_string()), "{}", quiet.err);
}

/// Rows that state a noise of their own are no outliers for it.
#[test]
fn coarse_readings_that_say_so_are_no_outliers() {
    let folder = simulated(&["universal-ur5", "--poses", "80", "--repeats", "2", "--noise", "0.03", "--unknown-base"]);
    let (mut header, mut all) = rows(folder.path());
    let coordinates = ["x", "y", "z"].map(|name| at(&header, name));
    for (k, row) in all.iter_mut().enumerate() {
        let is_coarse = k % 6 == 0;
        if is_coarse {
            for (axis, &at) in coordinates.iter().enumerate() {
                let off = (1.7 * (k + 7 * axis) as f64).sin() * 1.4;
                row[at] = (row[at].parse::<f64>().expect("a number") + off).to_string();
            }
        }
        row.push(if is_coarse { "1" } else { "0.03" }.into());
    }
    header.push("sigma".into());
    written(folder.path(), &header, &all, |text| text);
    let said = run(folder.path(), &["identify", "c", "--format", "json"]);
    assert!(!codes(&said).contains(&"outlying-readings".to_string()), "{}", said.err);
}

/// Repeats in place show the noise of the instrument, stated or not.
#[test]
fn readings_repeated_in_place_show_the_noise() {
    let folder = simulated(&["universal-ur5", "--poses", "20", "--repeats", "3", "--noise", "0.05", "--unknown-base"]);
    let found = printed_json(folder.path(), &["check", "c"]);
    let repeats = &found["without_robot"]["repeats"];
    // 20 configurations, three readings of three coordinates.
    assert_eq!(number(&repeats["degrees_of_freedom"]), 120.0, "{repeats}");
    assert!((number(&repeats["sigma"]) / 0.05 - 1.0).abs() < 0.2, "{repeats}");
    let (header, all) = rows(folder.path());
    written(folder.path(), &header, &all, |text| text.replace("sigma: 0.05", "sigma: 0.01"));
    let told = run(folder.path(), &["check", "c"]);
    assert!(told.err.contains("readings repeated in place scatter by"), "{}", told.err);
}

/// Fixed reflectors of sessions with a base each stand still in each, wherever the instrument was set up.
#[test]
fn reflectors_of_sessions_are_compared_within_each() {
    let folder = simulated(&["universal-ur5", "--poses", "40", "--sessions", "mon,tue", "--unknown-base"]);
    let (header, all) = rows(folder.path());
    let (pose, session) = (at(&header, "pose"), at(&header, "session"));
    let mut table = String::from("pose,session,reflector,x,y,z\n");
    for (k, row) in all.iter().enumerate() {
        for (name, place) in
            [("a", [2000.0, 500.0, -500.0]), ("b", [2900.0, 800.0, -500.0]), ("c", [2700.0, 0.0, -600.0])]
        {
            let [x, y, z] = if row[session] == "tue" { [100.0 - place[1], place[0], place[2]] } else { place };
            let off = |axis: f64| 0.02 * (3.1 * k as f64 + axis + place[0]).sin();
            let [x, y, z] = [x + off(0.0), y + off(1.0), z + off(2.0)];
            table += &format!("{},{},{name},{x},{y},{z}\n", row[pose], row[session]);
        }
    }
    std::fs::write(folder.path().join("c/fixed.csv"), table).expect("written");
    let references = |text: String| text + "references: fixed.csv\n";
    written(folder.path(), &header, &all, |text| references(text.replace("base: true", "base: per-session")));
    let quiet = run(folder.path(), &["check", "c", "--format", "json"]);
    assert!(!codes(&quiet).contains(&"references-moved".to_string()), "{}", quiet.err);
    written(folder.path(), &header, &all, |text| text.replace("base: per-session", "base: true"));
    let told = run(folder.path(), &["check", "c", "--format", "json"]);
    assert!(codes(&told).contains(&"references-moved".to_string()), "{}", told.err);
}

/// Residuals of all kinds are in the table, each in a column of its own.
#[test]
fn residuals_of_directions_are_in_their_table() {
    let folder = simulated(&["universal-ur5", "--poses", "12", "--observes", "inclination", "--unknown-tool"]);
    let ran = run(folder.path(), &["residuals", "universal-ur5", "c", "--table", "r.csv"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let mut reader = csv::Reader::from_path(folder.path().join("r.csv")).expect("a table");
    let header: Vec<String> = reader.headers().expect("a header").iter().map(String::from).collect();
    let k = at(&header, "error.rx");
    for row in reader.records() {
        let row = row.expect("a row");
        assert!(row[k].parse::<f64>().is_ok(), "{row:?}");
        assert_eq!(&row[at(&header, "error")], "");
    }
}

/// Two anchors read at a configuration are two rows of a plan.
#[test]
fn a_plan_names_every_anchor() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: distance\ninstrument: {sigma: 0.05}\n\
                    estimate: {tool: true}\ncalibrate: [geometry, joint-offset]\nanchors:\n  a: {at: unknown, near: [1500, 0, 200]}\n  \
                    b: {at: unknown, near: [0, 1500, 200]}\nmeasurements: drawn.csv\n";
    std::fs::write(folder.path().join("wire.yaml"), campaign).expect("written");
    let ran = run(folder.path(), &["plan", "wire.yaml", "--poses", "40", "--table", "p.csv"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let table = std::fs::read_to_string(folder.path().join("p.csv")).expect("a table");
    let of = |anchor: &str| table.lines().filter(|line| line.split(',').any(|cell| cell == anchor)).count();
    assert_eq!((of("a"), of("b")), (40, 40), "{table}");
}

/// A wrench on the tool turns all that one flange carries alike.
#[test]
fn a_wrench_acts_at_the_tool_for_every_marker() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}\nframes:\n  1: {antecedent: 0, joint: revolute, variable: q1}\n  \
                2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, d: 300}\n  E: {antecedent: 2, d: 500}\n\
                joint_stiffness: {1: {kar: {value: 2.0e4}}, 2: {kar: {value: 1.0e4}}}\ntool: {frame: E}\n\
                markers: {a: {frame: E, at: [100, 0, 0]}, b: {frame: E, at: [0, 80, 200]}}\n";
    std::fs::write(folder.path().join("arm.yaml"), text).expect("written");
    let found = printed_json(folder.path(), &["pose", "arm.yaml", "--joints", "q1=20,q2=30", "--wrench", "0,0,-300"]);
    let rotation = |of: &str| -> [f64; 3] { std::array::from_fn(|k| number(&found["deflection"][of][3 + k])) };
    let tool = rotation("tool");
    // 300 N at 500 mm and 30 deg from the axis of joint 2, of 1e4 N.m/rad.
    let expected = 300.0 * 0.5 * 30f64.to_radians().cos() / 1e4;
    assert!((tool.iter().map(|v| v * v).sum::<f64>().sqrt() / expected - 1.0).abs() < 1e-9, "{tool:?}");
    for marker in ["marker a", "marker b"] {
        let own = rotation(marker);
        assert!((0..3).all(|k| (own[k] - tool[k]).abs() < 1e-12), "{marker}: {own:?} {tool:?}");
    }
}

/// What cannot be, and where nothing can be drawn, is said by `check` and `simulate`.
#[test]
fn impossible_rows_and_empty_ranges_are_told() {
    let folder = simulated(&["palletiser", "--poses", "20"]);
    let (header, mut all) = rows(folder.path());
    let (q2, q3) = (at(&header, "q2"), at(&header, "q3"));
    (all[3][q2], all[3][q3]) = ("-30".into(), "100".into());
    written(folder.path(), &header, &all, |text| text);
    let told = run(folder.path(), &["check", "c"]);
    assert!(told.err.contains("cannot stand at 1 of 20 readings"), "{}", told.err);
    let arm = "units: {length: mm, angle: deg}\nframes:\n  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-170, 170]}\n  \
               2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, d: 300, limits: [-170, 170]}\n  E: {antecedent: 2, d: 500}\n\
               limits: {q2 - q1: [-60, 60]}\ntool: {frame: E}\n";
    std::fs::write(folder.path().join("arm.yaml"), arm).expect("written");
    let ranges = ["--range", "q1=-100:-90", "--range", "q2=0:10"];
    let refused =
        run(folder.path(), &[&["simulate", "arm.yaml", "--poses", "10"][..], &ranges, &["--into", "d"]].concat());
    assert!(refused.status == 2 && refused.err.contains("no configuration in these ranges"), "{}", refused.err);
}

/// A URDF whose lengths are written in mm describes a robot of kilometres, one whose limits are in deg joints of thirty turns, and one whose masses
/// are in g an arm of tonnes.
#[test]
fn a_urdf_in_other_units_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    for (unit, limit, mass, told) in [
        (1.0, 3.1, 5.0, ""),
        (1e3, 3.1, 5.0, "is this one written in mm?"),
        (1.0, 180.0, 5.0, "written in deg?"),
        (1.0, 3.1, 5000.0, "has a mass of 5.000e3 kg"),
    ] {
        let text = format!(
            "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><link name=\"t\"/>\n<joint name=\"j\" type=\"revolute\">\
             <parent link=\"a\"/><child link=\"b\"/><origin xyz=\"0 0 {}\"/><axis xyz=\"0 0 1\"/><limit lower=\"-{limit}\" \
             upper=\"{limit}\" effort=\"1\" velocity=\"1\"/></joint>\n<joint name=\"f\" type=\"fixed\"><parent link=\"b\"/>\
             <child link=\"t\"/><origin xyz=\"{} 0 0\"/></joint></robot>\n",
            0.9 * unit,
            0.7 * unit
        );
        std::fs::write(folder.path().join("r.urdf"), text).expect("written");
        let said = run(folder.path(), &["check", "r.urdf"]);
        assert_eq!((said.status, said.err.contains("warning")), (0, !told.is_empty()), "{}", said.err);
        assert!(said.err.contains(told), "{}", said.err);
    }
}

/// Times say which configuration came before which, where no column `order` does; times that configurations share do not.
#[test]
fn times_stand_in_for_the_order() {
    let effect = "settling@joint:2:share=2e-3";
    let folder = simulated(&[
        "universal-ur5",
        "--poses",
        "40",
        "--noise",
        "0.02",
        "--errors",
        "0",
        "--conditions",
        "--effect",
        effect,
        "--unknown-base",
    ]);
    let (header, mut all) = rows(folder.path());
    let (order, time) = (at(&header, "order"), at(&header, "time"));
    let without = |all: &[Vec<String>]| -> Vec<Vec<String>> {
        all.iter()
            .map(|row| row.iter().enumerate().filter(|(k, _)| *k != order).map(|(_, cell)| cell.clone()).collect())
            .collect()
    };
    let titles: Vec<String> = header.iter().filter(|title| *title != "order").cloned().collect();
    // Sorted by their names, as a spreadsheet does.
    all.sort_by(|a, b| a[0].cmp(&b[0]));
    written(folder.path(), &titles, &without(&all), |text| text);
    let found = printed_json(folder.path(), &["diagnose", "c"]);
    let named = |found: &Value| format!("{} {}", found["causes"][0]["effect"], found["causes"][0]["site"]);
    assert_eq!(named(&found), "\"settling\" \"joint:2\"", "{}", found["causes"]);
    all.iter_mut().for_each(|row| row[time] = "60".into());
    written(folder.path(), &titles, &without(&all), |text| text);
    // Rows stand in order, but where the campaign says otherwise.
    all.sort_by_key(|row| row[order].parse::<usize>().expect("a number"));
    written(folder.path(), &titles, &without(&all), |text| text);
    assert_eq!(named(&printed_json(folder.path(), &["diagnose", "c"])), "\"settling\" \"joint:2\"");
    all.sort_by(|a, b| a[0].cmp(&b[0]));
    written(folder.path(), &titles, &without(&all), |text| format!("{text}\norder: unknown\n"));
    let mixed = run(folder.path(), &["diagnose", "c"]);
    assert!(mixed.out.contains("settling (configurations in the order in which they were measured"), "{}", mixed.out);
    written(folder.path(), &header, &all, |text| text);
    let both = run(folder.path(), &["check", "c"]);
    assert!(both.status == 2 && both.err.contains("a column `order` numbers them"), "{}", both.err);
}

/// Reflectors that stood still say that neither instrument nor base was moved.
#[test]
fn a_step_that_still_reflectors_exclude_is_not_told() {
    let drift = "frame-drift@base:x=1e-7,z=5e-8";
    let folder = simulated(&[
        "universal-ur5",
        "--poses",
        "60",
        "--noise",
        "0.02",
        "--errors",
        "0",
        "--conditions",
        "--effect",
        drift,
        "--unknown-base",
    ]);
    let (header, all) = rows(folder.path());
    written(folder.path(), &header, &all, |text| text);
    let told = run(folder.path(), &["identify", "c", "--format", "json"]);
    let named = run(folder.path(), &["diagnose", "c", "--format", "json"]);
    let mut table = String::from("pose,reflector,x,y,z\n");
    for (k, row) in all.iter().enumerate() {
        for (name, [x, y, z]) in
            [("a", [2000.0, 500.0, -500.0]), ("b", [2900.0, 800.0, -500.0]), ("c", [2700.0, 0.0, -600.0])]
        {
            let off = |axis: f64| 0.02 * (3.1 * k as f64 + axis + x).sin();
            table +=
                &format!("{},{name},{},{},{}\n", row[at(&header, "pose")], x + off(0.0), y + off(1.0), z + off(2.0));
        }
    }
    std::fs::write(folder.path().join("c/fixed.csv"), table).expect("written");
    written(folder.path(), &header, &all, |text| text + "references: fixed.csv\n");
    let still = run(folder.path(), &["identify", "c", "--format", "json"]);
    let is_moved = |ran: &Ran| codes(ran).contains(&"moved-midway".to_string());
    assert_eq!((is_moved(&told), is_moved(&still)), (true, false), "{} {}", told.err, still.err);
    // Where a drift is named as the cause it is not doubted once more.
    assert!(!is_moved(&named) && named.out.contains("frame-drift"), "{}", named.out);
}

/// What test poses do not depend on, the mount of a sensor on another link, is planned for as well.
#[test]
fn a_plan_for_two_sensors_determines_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: inclination\ninstrument: {orientation: 0.002}\n\
                    calibrate: [geometry, joint-offset]\nmeasurements:\n- {file: forearm.csv, body: \"3\", mount: unknown}\n- {file: flange.csv}\n";
    std::fs::write(folder.path().join("level.yaml"), campaign).expect("written");
    let ran = run(folder.path(), &["plan", "level.yaml", "--poses", "30", "--criterion", "D", "--table", "p.csv"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
}

/// Figures by session and marker are a table, the same as in JSON.
#[test]
fn figures_of_parts_are_a_table() {
    let folder = simulated(&[
        "kuka-kr270",
        "--poses",
        "40",
        "--markers",
        "m1,m2",
        "--sessions",
        "monday,tuesday",
        "--unknown-base",
        "--unknown-tool",
    ]);
    let at = folder.path();
    let found = printed_json(at, &["identify", "c", "--save", "s.yaml", "--parts", "parts.csv"]);
    let table = std::fs::read_to_string(at.join("parts.csv")).expect("a table");
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines[0].starts_with("part,name,readings,mean,rms,max"), "{}", lines[0]);
    let parts = found["parts"].as_array().expect("parts");
    assert_eq!(lines.len(), 1 + parts.len());
    for (line, part) in lines[1..].iter().zip(parts) {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!((cells[0], cells[1]), (part["part"].as_str().expect("text"), part["name"].as_str().expect("text")));
        let rms: f64 = cells[4].parse().expect("a number");
        assert!((rms - part["rms"].as_f64().expect("a number")).abs() < 1e-8, "{line}");
    }
    for name in ["session,monday", "session,tuesday", "marker,m1", "marker,m2"] {
        assert!(table.contains(name), "{name}: {table}");
    }
    assert!(run(at, &["identify", "c"]).out.contains("marker m2"));
    assert_eq!(run(at, &["residuals", "s.yaml", "c", "--parts", "of.csv"]).status, 0);
    assert!(std::fs::read_to_string(at.join("of.csv")).expect("a table").contains("marker,m2,"));
    let other = run(at, &["residuals", "s.yaml", "c", "--parts", "of.ods"]);
    assert!(other.status == 2 && !at.join("of.ods").exists(), "{}", other.err);
}

/// A file of joints with names of its own, in another order than the readings.
#[test]
fn files_with_names_of_their_own_are_joined() {
    let folder = simulated(&["universal-ur5", "--poses", "20", "--noise", "0.03"]);
    let (header, rows) = rows(folder.path());
    let table = |names: &[(&str, &str)], order: &mut dyn Iterator<Item = &Vec<String>>| -> String {
        let head: Vec<&str> = names.iter().map(|(_, theirs)| *theirs).collect();
        let cells =
            |row: &Vec<String>| names.iter().map(|(ours, _)| row[at(&header, ours)].clone()).collect::<Vec<_>>();
        let lines = order.map(|row| cells(row).join(","));
        std::iter::once(head.join(",")).chain(lines).map(|line| line + "\n").collect()
    };
    let joints =
        [("pose", "target"), ("q1", "J1"), ("q2", "J2"), ("q3", "J3"), ("q4", "J4"), ("q5", "J5"), ("q6", "J6")];
    let points = [("pose", "label"), ("x", "x"), ("y", "y"), ("z", "z")];
    std::fs::write(folder.path().join("joints.csv"), table(&joints, &mut rows.iter())).expect("written");
    std::fs::write(folder.path().join("points.csv"), table(&points, &mut rows.iter().rev())).expect("written");
    let campaign = |joint_columns: &str, more: &str| {
        format!(
            "robot: universal-ur5\nunits: {{length: mm, angle: deg}}\nobserves: position\n\
             measurements: {{file: points.csv, columns: {{pose: label}}, joint_columns: {{{joint_columns}}}{more}}}\n"
        )
    };
    let said = |text: String| {
        std::fs::write(folder.path().join("c.yaml"), text).expect("written");
        run(folder.path(), &["residuals", "universal-ur5", "c.yaml"])
    };
    let names = "pose: target, q1: J1, q2: J2, q3: J3, q4: J4, q5: J5, q6: J6";
    let ran = said(campaign(names, ", joints: joints.csv"));
    assert_eq!(ran.status, 0, "{}", ran.err);
    // Each row by its own joints, as in one file.
    let total = |text: &str| text.lines().find(|line| line.starts_with(" all ")).map(String::from);
    let one = run(folder.path(), &["residuals", "universal-ur5", "c"]);
    assert!(total(&one.out).is_some() && total(&ran.out) == total(&one.out), "{}{}", ran.out, one.out);
    // The place that the controller shows is no reading: it is left out, and said.
    let shown = [&joints[..], &[("x", "x"), ("y", "y"), ("z", "z")]].concat();
    std::fs::write(folder.path().join("shown.csv"), table(&shown, &mut rows.iter())).expect("written");
    let with = said(campaign(names, ", joints: shown.csv"));
    assert!(with.status == 0 && total(&with.out) == total(&one.out), "{}{}", with.out, with.err);
    assert!(with.err.contains("without its columns `x`, `y`, `z`"), "{}", with.err);
    for (columns, more, words) in [
        (names, "", "`joint_columns:` means nothing here"),
        ("pose: target, q9: J1", ", joints: joints.csv", "`joint_columns:` renames `q9`"),
        ("pose: goal, q1: J1, q2: J2, q3: J3, q4: J4, q5: J5, q6: J6", ", joints: joints.csv", "`target`"),
    ] {
        let ran = said(campaign(columns, more));
        assert!(ran.status == 2 && ran.err.contains(words), "{words}: {}", ran.err);
    }
}
