//! Plans beside what is measured, tables that say what is carried, and reports of angles and torques alone.

use std::path::Path;

use serde_json::Value;

use super::cli::run;
use crate::support::{number, printed_json};

const UR5: &str = "robot: universal-ur5\nunits: {length: mm, angle: deg}\n";

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("written");
}

/// What each planned row observes, and its file.
fn read(found: &Value) -> Vec<(String, String)> {
    let rows = found["poses"].as_array().expect("poses").iter();
    let readings = rows.flat_map(|row| row["readings"].as_array().expect("readings"));
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    readings.map(|own| (text(&own["observes"]), text(&own["file"]))).collect()
}

#[test]
fn what_is_not_measured_is_planned_beside_what_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made =
        run(at, &["simulate", "universal-ur5", "--poses", "20", "--noise", "0.02", "--unknown-base", "--into", "m"]);
    assert_eq!(made.status, 0, "{}", made.err);
    let campaign = format!(
        "{UR5}instrument: {{sigma: 0.02, orientation: 0.002}}\nestimate: {{base: per-session}}\nmeasurements:\n\
         - {{file: m/measurements.csv, observes: position, session: mon}}\n\
         - {{file: tue.csv, observes: position, session: tue}}\n- {{file: level.csv, observes: inclination, session: tue}}\n"
    );
    write(at, "c.yaml", &campaign);
    write(at, "level.csv", "pose,q1,q2,q3,q4,q5,q6,gx,gy,gz\n");
    let planned = |more: &[&str]| {
        let all = [&["plan", "c.yaml", "--poses", "6"][..], more].concat();
        printed_json(at, &all)
    };
    let found = planned(&[]);
    let rows = read(&found);
    assert!(rows.iter().all(|(_, file)| file == "tue.csv" || file == "level.csv"), "{rows:?}");
    assert!(rows.iter().all(|(kind, file)| (kind == "inclination") == (file == "level.csv")), "{rows:?}");
    assert!(found["poses"][0]["names"]["session"] == "tue", "{}", found["poses"][0]);
    let bases = found["parameters"].as_array().expect("parameters");
    assert!(bases.iter().any(|own| own["name"] == "base@tue.x"), "{bases:?}");
    let found = planned(&["--session", "mon"]);
    assert!(read(&found).iter().all(|(kind, file)| kind == "position" && file == "m/measurements.csv"));
    let text = run(at, &["plan", "c.yaml", "--poses", "6", "--table", "t.csv"]);
    assert!(text.out.contains("nothing is measured yet of tue.csv, level.csv"), "{}{}", text.out, text.err);
    assert!(text.out.contains("planned for session tue") && text.out.contains("file"), "{}", text.out);
    let table = std::fs::read_to_string(at.join("t.csv")).expect("a table");
    assert!(table.lines().next().is_some_and(|header| header.split(',').any(|name| name == "file")), "{table}");
}

#[test]
fn a_payload_that_no_row_carries_is_planned_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write(at, "arm.yaml", ARM);
    let held = "robot: arm.yaml\nunits: {length: mm, angle: deg}\nobserves: torque\ninstrument: {torque: 0.1}\n\
                torques: {q1: {gain: unknown}, q2: {}}\nmeasurements: measurements.csv\n";
    write(at, "held.yaml", held);
    printed_json(at, &["simulate", "held.yaml", "--poses", "12", "--into", "m"]);
    let path = at.join("m/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    std::fs::write(&path, text + "payloads: {block: {mass: 20}}\n").expect("written");
    let arguments = ["plan", "m", "--poses", "6", "--criterion", "D"];
    let found = printed_json(at, &arguments);
    let carried = |found: &Value| {
        let rows = found["poses"].as_array().expect("poses").iter();
        rows.filter(|row| row["names"]["payload"] == "block").count()
    };
    // A load of its own tells the gain of a sensor better than none.
    assert!(carried(&found) > 0, "{}", found["poses"]);
}

const ARM: &str = "units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}
variables: [q1, q2]
gravity: [0, -9.81, 0]
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-120, 120]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 500, limits: [-120, 120]}
  E: {antecedent: 2, d: 400}
tool: {frame: E}
bodies:
  1: {mass: 8, com: [250, 0, 0]}
joint_stiffness:
  2: {kar: {value: 1e4}}
payloads: {block: {mass: 10}}
";

/// By hand: 10 kg at 0.4 m turn a spring of 1e4 N.m/rad, and the tool sinks by 0.4 m times that angle.
#[test]
fn a_table_says_what_the_tool_carries() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    write(at, "arm.yaml", ARM);
    write(at, "t.csv", "q1,q2,payload\n0,0,none\n0,0,block\n");
    let found = printed_json(at, &["pose", "arm.yaml", "--table", "t.csv"]);
    let height = |row: usize| number(&found["poses"][row]["tool"][1][3]);
    let expected = -10.0 * 9.81 * 0.4 / 1e4 * 0.4;
    assert!(
        (height(1) - expected).abs() < 1e-4 * expected.abs() && height(0).abs() < 1e-12,
        "{} {}",
        height(0),
        height(1)
    );
    write(at, "t.csv", "q1,q2,payload\n0,0,blok\n");
    let ran = run(at, &["pose", "arm.yaml", "--table", "t.csv"]);
    assert!(
        ran.status == 2 && ran.err.contains("unknown payload `blok`") && ran.err.contains("t.csv:2:"),
        "{}",
        ran.err
    );
    assert!(ran.err.contains("did you mean `block`?"), "{}", ran.err);
}

#[test]
fn angles_and_torques_alone_have_a_report() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let level = format!(
        "{UR5}observes: inclination\ninstrument: {{orientation: 0.002}}\ncalibrate: [joint-offset]\nmeasurements: l.csv\n"
    );
    write(at, "level.yaml", &level);
    write(at, "arm.yaml", ARM);
    let held = "robot: arm.yaml\nunits: {length: mm, angle: deg}\nobserves: torque\ninstrument: {torque: 0.1}\n\
                torques: {q1: {gain: unknown, offset: unknown}, q2: {}}\nmeasurements: h.csv\n";
    write(at, "held.yaml", held);
    for (campaign, unit, key) in [("level.yaml", "deg", "orientation"), ("held.yaml", "N.m", "load")] {
        let made = run(at, &["simulate", campaign, "--poses", "40", "--seed", "3", "--into", "trial"]);
        assert_eq!(made.status, 0, "{}", made.err);
        let ran = run(at, &["report", "trial", "--output", "r.html", "--json", "r.json"]);
        assert_eq!(ran.status, 0, "{campaign}: {}", ran.err);
        let html = std::fs::read_to_string(at.join("r.html")).expect("a page");
        assert!(!html.contains("class=\"fault\""), "{campaign}: a template failed");
        for section in ["errors", "parameters", "conditioning"] {
            assert!(html.contains(&format!("<details class=\"section\" id=\"{section}\"")), "{campaign}: {section}");
        }
        let found: Value =
            serde_json::from_str(&std::fs::read_to_string(at.join("r.json")).expect("data")).expect("JSON");
        assert_eq!(found["campaign"]["unit"], unit);
        let after = number(&found["identify"]["residuals"]["check_after"][key]["rms"]);
        let answer = found["answer"].as_str().expect("an answer");
        assert!(answer.contains(&format!("to {after:.4} {unit}")) && answer.contains("Not diagnosed"), "{answer}");
        assert!(ran.out.contains(answer), "{}", ran.out);
        let alone = printed_json(at, &["identify", "trial"]);
        assert_eq!(alone["residuals"], found["identify"]["residuals"], "{campaign}");
        std::fs::remove_dir_all(at.join("trial")).expect("removed");
    }
}
