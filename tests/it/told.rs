//! What was accepted, refused or left out without a word, and is told now.

use std::path::Path;

use serde_json::Value;

use super::cli::{Ran, run};
use crate::support::printed_json;

/// A folder with a simulated campaign of a UR5, 30 positions.
fn campaign() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let made = run(folder.path(), &["simulate", "universal-ur5", "--poses", "30", "--noise", "0.02", "--into", "c"]);
    assert_eq!(made.status, 0, "{}", made.err);
    folder
}

fn change(folder: &Path, name: &str, from: &str, to: &str) {
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path).expect("read");
    assert!(text.contains(from), "{name} has no `{from}`");
    std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
}

fn refused(ran: &Ran, words: &[&str]) {
    assert!(ran.status == 2 && ran.err.contains("1 error, "), "{}", ran.err);
    for word in words {
        assert!(ran.err.contains(word), "`{word}` is not in\n{}", ran.err);
    }
}

const MEASURED: &str = "measurements: measurements.csv\n";

#[test]
fn one_fault_is_one_error_with_its_value_and_what_may_stand_there() {
    for (to, words) in [
        (
            "anchors: {a: {at: [0, 0, 0], zero: unknwon}}\nmeasurements: measurements.csv\n",
            &["`anchors.a.zero` must be a number, or `unknown`, found `unknwon`", "campaign.yaml:23:"][..],
        ),
        (
            "anchors: {a: {at: unknwon}}\nmeasurements: measurements.csv\n",
            &["three numbers as `[0, 0, 90]`, or `unknown`, found `unknwon`"],
        ),
        (
            "payloads: {k: {mass: 3, com: [0, 0]}}\nmeasurements: {file: measurements.csv, payload: k}\n",
            &["`payloads.k.com` holds 2 values, expected 3 values"],
        ),
        ("measurements: {file: measurements.csv, format: point}\n", &["did you mean `points`?"]),
        ("measurements: {file: points.txt, format: point}\n", &["did you mean `points`?"]),
    ] {
        let folder = campaign();
        std::fs::write(folder.path().join("c/points.txt"), "1 2 3\n4 5 6\n").expect("written");
        change(folder.path(), "c/campaign.yaml", MEASURED, to);
        refused(&run(folder.path(), &["check", "c"]), words);
    }
}

#[test]
fn a_unit_in_a_header_is_declared_as_the_remedy_says() {
    let folder = campaign();
    change(folder.path(), "c/measurements.csv", "q1,", "q1 [deg],");
    let remedy = "`columns: {q1: \"q1 [deg]\"}`";
    refused(&run(folder.path(), &["check", "c"]), &["the column `q1` is missing", remedy, "`units:`"]);
    change(folder.path(), "c/campaign.yaml", MEASURED, "columns: {q1: \"q1 [deg]\"}\nmeasurements: measurements.csv\n");
    let ran = run(folder.path(), &["check", "c"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
}

#[test]
fn a_xacro_is_one_whatever_its_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "<?xml version=\"1.0\"?>\n<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\
                <xacro:arg name=\"a\" default=\"1\"/><link name=\"base\"/></robot>\n";
    for name in ["arm.xacro", "arm.urdf.xacro", "arm.urdf"] {
        std::fs::write(folder.path().join(name), text).expect("written");
        refused(&run(folder.path(), &["check", name]), &["this is a xacro file", "> arm.urdf`"]);
    }
}

#[test]
fn a_variable_that_moves_nothing_is_told_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let robot = |variables: &str| {
        format!(
            "robot: r\nunits: {{length: mm, angle: deg}}\nvariables: [{variables}]\nframes:\n  \
             1: {{antecedent: 0, joint: revolute, variable: q1, r: 340}}\n  \
             2: {{antecedent: 1, joint: revolute, variable: q2, alpha: -90}}\ntool: {{frame: 2}}\n"
        )
    };
    for (variables, words) in [
        ("q1, q2, q3", ["no joint and no actuator has the variable `q3`", "or remove it here"]),
        ("q1, qq2", ["no joint and no actuator has the variable `qq2`", "did you mean `q2`?"]),
    ] {
        std::fs::write(folder.path().join("robot.yaml"), robot(variables)).expect("written");
        refused(&run(folder.path(), &["check", "robot.yaml"]), &words);
    }
}

#[test]
fn all_that_is_wrong_with_an_effect_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let start = run(folder.path(), &["init", "r"]);
    assert_eq!(start.status, 0, "{}", start.err);
    let robot = std::fs::read_to_string(folder.path().join("r/robot.yaml")).expect("read");
    let joint = if robot.contains("\n  2:") { "joint:2" } else { "joint:j2" };
    let effect = format!(
        "\neffects:\n  - {{effect: transmission-error, site: '{joint}', parameters: {{cos: 1e-4, ordr: 1}}}}\n"
    );
    std::fs::write(folder.path().join("r/robot.yaml"), robot + &effect).expect("written");
    let ran = run(folder.path(), &["check", "r/robot.yaml"]);
    assert_eq!(ran.status, 2, "{}", ran.err);
    for words in ["lacks `order`", "has no parameter `ordr`", "did you mean `order`?", "2 errors, "] {
        assert!(ran.err.contains(words), "{words}\n{}", ran.err);
    }
}

#[test]
fn noise_and_loads_beyond_reason_are_doubted_and_noise_beyond_all_is_refused() {
    for (instrument, code, words) in [
        ("sigma: 50000", Some("doubtful"), "the stated noise of a coordinate is 50 m"),
        ("sigma: 0.02\n  ppm: 60000", Some("doubtful"), "`ppm: 60000` of the instrument"),
        ("sigma: 0.02\n  ppm: 900", None, ""),
    ] {
        let folder = campaign();
        change(folder.path(), "c/campaign.yaml", "sigma: 0.02", instrument);
        let ran = run(folder.path(), &["check", "c", "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let found: Value = serde_json::from_str(&ran.out).expect("JSON");
        let said = found["diagnostics"].as_array().expect("a list").iter();
        let said: Vec<&Value> = said.filter(|one| one["message"].to_string().contains("implausible")).collect();
        assert_eq!(said.first().map(|one| one["code"].as_str().unwrap_or_default()), code, "{instrument}: {said:?}");
        assert!(words.is_empty() || said[0]["message"].to_string().contains(words), "{said:?}");
    }
    let folder = campaign();
    change(folder.path(), "c/campaign.yaml", "sigma: 0.02", "sigma: 1e12");
    refused(&run(folder.path(), &["check", "c"]), &["more than 100 m is no measurement", "campaign.yaml:16:"]);
    let loaded = ["simulate", "universal-ur5", "--poses", "12", "--wrench", "1e9,0,0,0,0,0", "--into", "d"];
    assert_eq!(run(folder.path(), &loaded).status, 0);
    let ran = run(folder.path(), &["check", "d"]);
    assert!(ran.err.contains("a force on the tool is 1000000000 N at most, implausible in 12 of 12"), "{}", ran.err);
}

#[test]
fn sums_that_no_configuration_meets_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let arm = |sum: &str| {
        let text = format!(
            "units: {{length: mm, angle: deg}}\nframes:\n  2: {{antecedent: 0, joint: revolute, variable: q2, limits: [-30, 30]}}\n  \
             3: {{antecedent: 2, joint: revolute, variable: q3, d: 400, limits: [0, 60]}}\n  E: {{antecedent: 3, d: 400}}\n\
             limits: {{{sum}}}\ntool: {{frame: E}}\n"
        );
        std::fs::write(folder.path().join("arm.yaml"), text).expect("written");
        run(folder.path(), &["check", "arm.yaml"])
    };
    refused(&arm("q2 + q3: [200, 300]"), &["200 .. 300 deg", "it is -30 .. 90 deg", "arm.yaml:6:"]);
    refused(&arm("q3 - q2: [-90, -31]"), &["-90 .. -31 deg", "it is -30 .. 90 deg"]);
    refused(&arm("q2 - q2: [1, 2]"), &["names `q2` twice", "`2 * q2`"]);
    for sum in ["q2 + q3: [89, 300]", "q3 - q2: [-90, -30]"] {
        assert_eq!(arm(sum).status, 0, "{sum}");
    }
}

#[test]
fn whole_turns_in_a_branch_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let bundled = include_str!("../../robots/five-bar.yaml");
    let with = |from: &str, to: &str| {
        let text = bundled.replacen("passive: true, d: 240}", "passive: true, d: 240, limits: [-170, 0]}", 1);
        assert!(text.contains(from), "{from}");
        std::fs::write(folder.path().join("r.yaml"), text.replacen(from, to, 1)).expect("written");
        run(folder.path(), &["check", "r.yaml"]).err
    };
    assert_eq!(with("a2: -70", "a2: -70"), "");
    let said = with("a2: -70", "a2: 290");
    assert!(said.contains("`a2` = 290 deg of `branch` is whole turns beyond the limits"), "{said}");
    assert!(said.contains("take 360 deg off it") && said.contains("r.yaml:25:"), "{said}");
    let said = with("at: {q1: 120", "at: {q1: 480");
    assert!(said.contains("`q1` = 480 deg of `at`") && said.contains("60 .. 170 deg"), "{said}");
}

#[test]
fn check_tells_order_and_parts() {
    let folder = campaign();
    let found = printed_json(folder.path(), &["check", "c"]);
    assert_eq!(found["order"], serde_json::json!({"by": "rows", "stated": false}));
    assert_eq!(found["parts"], serde_json::json!([]));
    let rows = std::fs::read_to_string(folder.path().join("c/measurements.csv")).expect("read");
    let rows: Vec<&str> = rows.lines().collect();
    let numbered = |from: usize, to: usize| {
        let lines = (from..to).map(|k| format!("{},{}\n", rows[k], k - from + 1));
        format!("{},order\n", rows[0]) + &lines.collect::<String>()
    };
    std::fs::write(folder.path().join("c/a.csv"), numbered(1, 21)).expect("written");
    std::fs::write(folder.path().join("c/b.csv"), numbered(21, 31)).expect("written");
    let two = "measurements:\n- {file: a.csv, session: mon}\n- {file: b.csv, session: tue, payload: k}\npayloads: {k: {mass: 2}}\n";
    change(folder.path(), "c/campaign.yaml", MEASURED, two);
    let found = printed_json(folder.path(), &["check", "c"]);
    assert_eq!(found["order"]["by"], "order");
    let of = |part: &str, name: &str| {
        let parts = found["parts"].as_array().expect("a list");
        parts.iter().find(|own| own["part"] == part && own["name"] == name).map(|own| own["readings"].clone())
    };
    assert_eq!([of("session", "mon"), of("session", "tue")], [Some(20.into()), Some(10.into())]);
    assert_eq!([of("payload", "k"), of("payload", "none")], [Some(10.into()), Some(20.into())]);
    let text = run(folder.path(), &["check", "c"]).out;
    assert!(text.contains("readings by session (configurations): mon 20 (20), tue 10 (10)"), "{text}");
    assert!(text.contains("order of the readings: the column `order`"), "{text}");
}

#[test]
fn references_by_number_alone_are_told_where_they_do_not_count() {
    let folder = campaign();
    let rows = (0..9).map(|k| format!("{},{},{},0,{}\n", k / 3, ["a", "b", "c"][k % 3], 1000 + k % 3, k % 2));
    let text = "order,reflector,x,y,z\n".to_string() + &rows.collect::<String>();
    std::fs::write(folder.path().join("c/r.csv"), text).expect("written");
    let with = |to: &str| change(folder.path(), "c/campaign.yaml", MEASURED, to);
    with("references: r.csv\nmeasurements: {file: measurements.csv, session: a}\n");
    let quiet = run(folder.path(), &["check", "c"]);
    assert!(quiet.status == 0 && !quiet.err.contains("numbered by `order`"), "{}", quiet.err);
    change(folder.path(), "c/campaign.yaml", "base: false", "base: per-session");
    let ran = run(folder.path(), &["check", "c"]);
    assert!(ran.err.contains("9 rows of fixed reflectors are numbered by `order`"), "{}", ran.err);
    assert!(ran.status == 0 && ran.err.contains("campaign.yaml:23:"), "{}", ran.err);
}

#[test]
fn a_quiet_file_holds_the_warnings() {
    let folder = campaign();
    change(folder.path(), "c/campaign.yaml", "sigma: 0.02", "sigma: 0.02\n  ppm: 60000");
    let ran = run(folder.path(), &["check", "c", "--quiet", "--output", "said.txt"]);
    assert_eq!((ran.status, ran.out.as_str(), ran.err.as_str()), (0, "", ""));
    let said = std::fs::read_to_string(folder.path().join("said.txt")).expect("a file");
    assert!(said.contains("NOTE (doubtful): `ppm: 60000` of the instrument"), "{said}");
    run(folder.path(), &["check", "c", "--output", "said.txt"]);
    let said = std::fs::read_to_string(folder.path().join("said.txt")).expect("a file");
    assert!(!said.contains("NOTE"), "{said}");
}

#[test]
fn a_missing_urdf_is_told_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "robot: r\nurdf: {file: nothere.urdf, from: a, to: b}\n";
    std::fs::write(folder.path().join("robot.yaml"), text).expect("written");
    refused(
        &run(folder.path(), &["check", "robot.yaml"]),
        &["there is no file `nothere.urdf`", "relative to the description"],
    );
}

#[test]
fn a_marker_is_not_called_as_the_tool_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "robot: r\nunits: {length: mm, angle: deg}\nframes:\n  \
                1: {antecedent: 0, joint: revolute, variable: q1, r: 340}\n  \
                2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90}\ntool: {frame: 2, at: [350, 0, 0]}\n\
                markers: {TCP: {frame: 2, at: [300, 20, 30]}}\n";
    std::fs::write(folder.path().join("robot.yaml"), text).expect("written");
    refused(
        &run(folder.path(), &["check", "robot.yaml"]),
        &["`TCP` would be taken for the tool's own point", "another name"],
    );
}

#[test]
fn noise_that_no_reading_has_is_told() {
    let folder = campaign();
    let at = folder.path();
    let table = std::fs::read_to_string(at.join("c/measurements.csv")).expect("read");
    let inclined: String = table
        .lines()
        .enumerate()
        .map(|(k, line)| if k == 0 { format!("{line},gx,gy,gz,sigma\n") } else { format!("{line},0,0,-1,0.02\n") })
        .collect();
    std::fs::write(at.join("c/measurements.csv"), &inclined).expect("written");
    let path = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let of_angles = text.replace("observes: position", "ignore: [x, y, z]\nobserves: inclination");
    assert_ne!(of_angles, text);
    std::fs::write(&path, of_angles).expect("written");
    let ran = run(at, &["check", "c"]);
    assert_eq!(ran.status, 2, "{}", ran.err);
    assert!(
        ran.err.contains("column `sigma` is the noise of lengths, and readings of `inclination` hold none"),
        "{}",
        ran.err
    );
    std::fs::write(at.join("c/measurements.csv"), inclined.replace(",sigma\n", "\n").replace(",0.02\n", "\n"))
        .expect("written");
    let ran = run(at, &["check", "c"]);
    assert!(
        ran.err.contains("`sigma` of the instrument is the noise of lengths, and no reading holds any"),
        "{}",
        ran.err
    );
}

#[test]
fn a_refusal_says_why_even_when_quiet() {
    let folder = campaign();
    let at = folder.path();
    let rows = std::fs::read_to_string(at.join("c/measurements.csv")).expect("read");
    let few: String = rows.lines().take(10).map(|line| format!("{line}\n")).collect();
    std::fs::write(at.join("c/measurements.csv"), few).expect("written");
    let ran = run(at, &["identify", "c", "--save", "a.yaml", "--quiet"]);
    assert_eq!(ran.status, 1, "{}{}", ran.out, ran.err);
    assert!(
        ran.out.is_empty() && ran.err.contains("24 residuals of different readings for 21 fitted parameters"),
        "{}{}",
        ran.out,
        ran.err
    );
    assert!(!at.join("a.yaml").exists());
}
