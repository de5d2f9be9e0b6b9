//! Campaign files of which nothing is measured yet: simulated with known truth, planned for, identified.

use std::path::Path;

use serde_json::Value;

use super::cli::run;
use crate::support::printed_json;

const SOCKETS: &str = "robot: universal-ur5
units: {length: mm, angle: deg}
observes: contact
instrument: {sigma: 0.05}
estimate: {tool: true}
contacts:
  left: {kind: socket, group: placement}
  right: {kind: socket, group: placement}
distances: {left-right: 50}
measurements: touched.csv
";

fn folder(file: &str, text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join(file), text).expect("written");
    folder
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("a file")).expect("JSON")
}

/// Every identified value within so many half widths of its interval from the truth; how many there were.
fn agrees(found: &Value, truth: &Value, units: impl Fn(&str) -> f64, widths: f64) -> usize {
    let mut compared = 0;
    for parameter in found["parameters"].as_array().expect("a list") {
        let Some(ci95) = parameter["ci95"].as_f64() else { continue };
        // A normal has any length and either side.
        if parameter["name"].as_str().is_some_and(|name| name.starts_with("table.")) {
            continue;
        }
        let (name, unit) = (parameter["name"].as_str().expect("a name"), parameter["unit"].as_str().expect("a unit"));
        let known = &truth["parameters"][name];
        let (value, nominal) = (parameter["value"].as_f64().expect("a number"), parameter["nominal"].as_f64());
        let truth = known["true"].as_f64().map_or(nominal.expect("a number"), |si| si / units(unit));
        assert!((value - truth).abs() < widths * ci95, "{name}: {value} +- {ci95}, and the truth is {truth}");
        compared += 1;
    }
    compared
}

fn factor(unit: &str) -> f64 {
    match unit {
        "mm" => 1e-3,
        "deg" => 1f64.to_radians(),
        _ => 1.0,
    }
}

#[test]
fn sockets_are_simulated_and_identified_with_their_truth() {
    let folder = folder("sockets.yaml", SOCKETS);
    let simulate = ["simulate", "sockets.yaml", "--poses", "120", "--placements", "2", "--into", "c"];
    // What is dropped is as described, so that what is kept is the truth itself.
    let off = ["--errors", "0", "--set", "3.alpha=0.1,4.theta=-0.2,4.r=0.3,5.theta=0.1", "--check", "0"];
    printed_json(folder.path(), &[&simulate[..], &off].concat());
    let found = printed_json(folder.path(), &["identify", "c"]);
    let truth = read(&folder.path().join("c/truth.json"));
    // Of some forty independent draws none is beyond twice a 95 % interval but once in hundreds of campaigns.
    assert!(agrees(&found, &truth, factor, 2.2) > 30);
    let ratio = found["noise_ratio"].as_f64().expect("a number");
    assert!((0.8..1.2).contains(&ratio), "{ratio}");
    let told = printed_json(folder.path(), &["identifiability", "universal-ur5", "c"]);
    let dropped: Vec<&str> =
        told["dropped"].as_array().expect("a list").iter().filter_map(|d| d["name"].as_str()).collect();
    for name in ["1.d", "1.r", "1.theta", "6.r", "6.theta"] {
        assert!(dropped.contains(&name), "{name} shows in no socket: {dropped:?}");
    }
    // Written again from the same seed it is the same, and edited files are not replaced.
    let rows = std::fs::read_to_string(folder.path().join("c/measurements.csv")).expect("a file");
    printed_json(folder.path(), &[&simulate[..], &off].concat());
    assert_eq!(rows, std::fs::read_to_string(folder.path().join("c/measurements.csv")).expect("a file"));
    std::fs::write(folder.path().join("c/measurements.csv"), rows.replace("fit", "check")).expect("written");
    let refused = run(folder.path(), &[&simulate[..], &off].concat());
    assert!(refused.status == 2 && refused.err.contains("was edited"), "{}", refused.err);
}

#[test]
fn planned_configurations_touch_and_serve_better_than_random_ones() {
    let folder = folder("sockets.yaml", SOCKETS);
    let plan = ["plan", "sockets.yaml", "--poses", "20", "--placements", "1", "--hold", "5.theta", "--table", "p.csv"];
    let planned = printed_json(folder.path(), &plan);
    let bought = planned["bought"].as_array().expect("a list");
    let own = bought.iter().find(|bought| bought["poses"] == 20).expect("that many");
    let [best, random] = ["planned", "random"].map(|key| own[key].as_f64().expect("a number"));
    assert!(best < 0.8 * random, "{best} {random}");
    let table = std::fs::read_to_string(folder.path().join("p.csv")).expect("a file");
    assert_eq!(table.lines().next(), Some("pose,q1,q2,q3,q4,q5,q6,contact,placement"));
    assert_eq!(table.lines().count(), 21);
    // Both sockets are where all their configurations put the ball: pivoting at the planned rows finds the ball where it is
    // described, and leaves nothing.
    let campaign = SOCKETS.replace("touched.csv", "p.csv");
    std::fs::write(folder.path().join("exact.yaml"), campaign).expect("written");
    let found = printed_json(folder.path(), &["register", "exact.yaml", "--check", "0"]);
    let left = found["residuals"]["after"]["rms"].as_f64().expect("a number");
    assert!(left < 0.02, "{left}");
    for name in ["tool.x", "tool.y", "tool.z"] {
        let all = found["parameters"].as_array().expect("a list");
        let own = all.iter().find(|parameter| parameter["name"] == name).expect("it");
        assert!(own["value"].as_f64().expect("a number").abs() < 0.05, "{own}");
    }
    // A robot simulated at the planned rows.
    let simulate = ["simulate", "sockets.yaml", "--poses", "p.csv", "--check", "0", "--into", "m"];
    assert_eq!(printed_json(folder.path(), &simulate)["readings"], 20);
    let more = printed_json(folder.path(), &["plan", "m", "--poses", "6", "--hold", "5.theta"]);
    let names = &more["poses"][0]["names"];
    assert!(
        names["placement"] == "1" && ["left", "right"].contains(&names["contact"].as_str().expect("a name")),
        "{names}"
    );
    let error = &more["error"];
    assert!(error["planned"].as_f64() < error["before"].as_f64(), "{error}");
}

#[test]
fn sensors_of_unknown_gain_mount_place_and_zero_are_simulated_and_found() {
    let wire = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: distance\ninstrument: {sigma: 0.05}\n\
                anchors: {out: {at: unknown, zero: unknown, near: [1500, 0, 200]}}\nestimate: {tool: true}\n";
    let level = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: inclination\n\
                 instrument: {orientation: 0.002}\nmeasurements:\n- {file: a.csv, body: \"3\", mount: unknown}\n- b.csv\n";
    let torque = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: torque\ninstrument: {torque: 0.1}\n\
                  torques: {q2: {gain: unknown, offset: unknown}, q3: {gain: unknown}}\npayloads: {block: {mass: 3}}\n";
    let several = "robot: universal-ur5\nunits: {length: m, angle: rad}\nestimate: {base: true, tool: true}\n\
                   instrument: {sigma: 2e-5, orientation: 1e-4, torque: 0.1}\nmeasurements:\n\
                   - {file: a.csv, observes: [pose, torque]}\n- {file: b.csv, observes: contact}\n\
                   contacts: {hole: {kind: socket}, table: {kind: plane}, ball: {kind: sphere}}\n";
    for (k, text) in [wire, level, torque, several].into_iter().enumerate() {
        let folder = folder("c.yaml", text);
        let made =
            printed_json(folder.path(), &["simulate", "c.yaml", "--poses", "60", "--errors", "0", "--into", "c"]);
        assert!(made["readings"].as_u64() >= Some(60), "{text}");
        let verb = if text.contains("observes: torque") || k == 3 { "register" } else { "identify" };
        let found = printed_json(folder.path(), &[verb, "c", "--check", "0"]);
        let truth = read(&folder.path().join("c/truth.json"));
        assert!(agrees(&found, &truth, factor, 2.5) > 2, "{text}");
    }
}

#[test]
fn a_session_is_planned_for() {
    let folder = folder(
        "two.yaml",
        "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: position\ninstrument: {sigma: 0.03}\n\
         estimate: {base: per-session}\nmeasurements:\n- {file: a.csv, session: monday}\n- {file: b.csv, session: friday}\n",
    );
    printed_json(folder.path(), &["simulate", "two.yaml", "--poses", "25", "--into", "c"]);
    for (session, base) in [("monday", "base@monday.x"), ("friday", "base@friday.x"), ("sunday", "base@sunday.x")] {
        let planned = printed_json(folder.path(), &["plan", "c", "--poses", "6", "--session", session]);
        assert_eq!(planned["poses"][0]["names"]["session"], session);
        let named = |name: &str| planned["parameters"].as_array().expect("a list").iter().any(|p| p["name"] == name);
        assert!(named(base), "{session}");
    }
    let text = run(folder.path(), &["plan", "c", "--poses", "6", "--session", "monday"]);
    assert!(text.out.contains("planned for session monday"), "{}", text.out);
}

#[test]
fn what_a_campaign_says_the_command_must_not() {
    let folder = folder("sockets.yaml", SOCKETS);
    for (arguments, expected) in [
        (&["simulate", "sockets.yaml", "--poses", "9", "--into", "c", "--observes", "pose"][..], "--observes"),
        (&["simulate", "sockets.yaml", "--poses", "9", "--into", "c", "--unknown-base"], "--unknown-base"),
        (&["simulate", "sockets.yaml", "--poses", "9", "--into", "c", "--placements", "0"], "--placements 0"),
        (&["simulate", "universal-ur5", "--poses", "9", "--into", "c", "--placements", "3"], "is no campaign"),
        (&["simulate", "sockets.yaml", "--poses", "none.csv", "--into", "c"], "none.csv"),
        (&["plan", "sockets.yaml", "--poses", "9", "--session", "monday"], "nothing is measured yet"),
        (&["plan", "sockets.yaml", "--poses", "9", "--unknown-tool"], "--unknown-tool"),
        (&["plan", "universal-ur5", "--poses", "9", "--session", "monday"], "is no campaign"),
        (&["plan", "universal-ur5", "--poses", "9", "--placement", "1"], "is no campaign"),
        (&["plan", "kr270-simulated", "--poses", "9", "--session", "monday"], "name no sessions"),
    ] {
        let ran = run(folder.path(), arguments);
        assert!(ran.status == 2 && ran.err.contains(expected), "{arguments:?}: {}", ran.err);
    }
    let far = SOCKETS.replace("left: {kind: socket,", "left: {kind: socket, near: [9000, 0, 0],");
    std::fs::write(folder.path().join("far.yaml"), far).expect("written");
    let ran = run(folder.path(), &["simulate", "far.yaml", "--poses", "9", "--into", "c"]);
    assert!(ran.status == 2 && ran.err.contains("cannot be brought there") && ran.err.contains("near:"), "{}", ran.err);
}
