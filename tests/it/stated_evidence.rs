//! What a campaign states is used, shown and refused as its pages say: noise, order, sessions, sensors, places of contacts.

use std::path::Path;

use elastogeo::description::campaign::{InSession, Sessions, Sharing};
use elastogeo::diagnostic::{Code, Diagnostic};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::observation::POSITION;
use elastogeo::plausibility::{Evidence, Limits, judge};
use elastogeo::simulation::{Plan, draw_configurations, generator, measure, unmeasured};
use serde_json::Value;

use super::cli::run;
use crate::support::{number, printed_json};

const UR5: &str = "robot: universal-ur5\nunits: {length: mm, angle: deg}\n";

fn with(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("a file")
}

#[test]
fn predicted_errors_are_of_lengths_and_found_sensors_are_told() {
    let campaign = format!(
        "{UR5}observes: [position, torque]\nestimate: {{base: true}}\ninstrument: {{sigma: 0.05, torque: 5}}\n\
         torques: {{q2: {{gain: unknown, offset: unknown}}}}\nmeasurements: r.csv\n"
    );
    let folder = with(&[("c.yaml", &campaign)]);
    let at = folder.path();
    printed_json(at, &["simulate", "c.yaml", "--poses", "30", "--errors", "0", "--into", "m"]);
    let said = run(at, &["register", "m", "--save", "s.yaml", "--format", "json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(said.err.contains("torque.q2.gain") && said.err.contains("torque.q2.offset"), "{}", said.err);
    let found: Value = serde_json::from_str(&said.out).expect("JSON");
    let of = |name: &str| number(&found["predicted_error"][name]);
    let ratio = of("with_noise_rms") / of("observed_rms");
    assert!((0.4..2.5).contains(&ratio), "{}", found["predicted_error"]);
    // Fitted on all readings, then compared with its own.
    let found = printed_json(at, &["residuals", "s.yaml", "m"]);
    let fitted = found["fitted"].as_array().expect("a list");
    assert!(fitted.contains(&"torque.q2.gain".into()), "{fitted:?}");
    for reading in found["readings"].as_array().expect("a list") {
        let is_torque = !reading["load_error"].is_null();
        assert!(!(is_torque && reading.get("standard_uncertainty").is_some()), "{reading}");
        assert_eq!(reading["target"] == "torque.q2", is_torque, "{reading}");
    }
}

#[test]
fn stated_noise_of_orientations_is_used_and_shown() {
    let campaign = format!(
        "{UR5}estimate: {{base: true, tool: true}}\nmeasurements:\n\
         - {{file: r.csv, observes: pose, instrument: {{sigma: 0.05, orientation: 0.02}}}}\n"
    );
    let alone = format!("{UR5}observes: orientation\nestimate: {{base: true}}\ninstrument: {{orientation: 0.02}}\n");
    for (text, ratio) in [(campaign, 1.0), (alone, 1.0)] {
        let folder = with(&[("c.yaml", &text)]);
        let at = folder.path();
        printed_json(at, &["simulate", "c.yaml", "--poses", "30", "--errors", "0", "--into", "m"]);
        let checked = printed_json(at, &["check", "m"]);
        assert!((number(&checked["noise"]["orientation"]) - 0.02).abs() < 1e-12, "{}", checked["noise"]);
        let found = printed_json(at, &["register", "m"]);
        assert_eq!(found["noise_sources"]["orientation"], "stated", "{text}");
        assert!((number(&found["noise_ratio"]) / ratio - 1.0).abs() < 0.3, "{}", found["noise_ratio"]);
    }
}

#[test]
fn noise_grows_with_the_distance_as_makers_state_it() {
    let campaign = format!("{UR5}observes: position\ninstrument: {{sigma: 0.01, ppm: 10}}\nmeasurements: r.csv\n");
    let table = "q1,q2,q3,q4,q5,q6,x,y,z\n0,0,0,0,0,0,3000,4000,0\n1,0,0,0,0,0,3000,-4000,0\n";
    let folder = with(&[("c.yaml", &campaign), ("r.csv", table)]);
    let checked = run(folder.path(), &["check", "c.yaml", "--format", "json", "--force"]);
    let found: Value = serde_json::from_str(&checked.out).expect("JSON");
    assert!((number(&found["noise"]["position"][0]) - 0.06).abs() < 1e-9, "{}", found["noise"]);
}

/// Readings of two sessions on Monday's base and tool, but for how far Friday's differ (m and rad), as if all shared them.
fn told(base: [f64; 6], tool: f64) -> Option<Diagnostic> {
    let robot = load_robot("universal-ur5").expect("bundled");
    let geometry = Geometry::nominal(&robot.model).expect("assembled");
    let plan = Plan {
        configurations: draw_configurations(&geometry, 40, 0.7, &mut generator(11)).expect("drawn"),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSITION,
        sigma: 2e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let mut campaign = unmeasured(&robot.model, &plan);
    let names = ["monday", "friday"].map(String::from).to_vec();
    campaign.sessions = Sessions { names, base: Sharing::PerSession, tool: Sharing::PerSession, ..Sessions::default() };
    for (index, reading) in campaign.readings.iter_mut().enumerate() {
        reading.session = InSession { session: index % 2, station: 0 };
    }
    let model = robot.model.arranged(&campaign);
    let mut truth = model.registry.nominal();
    let friday = InSession { session: 1, station: 0 };
    base.iter().enumerate().for_each(|(k, value)| truth[model.base_slot(friday) + k] += value);
    truth[model.tool_slot(friday)] += tool;
    let mut campaign = measure(&model, &truth, campaign, [2e-5, 0.0], &mut generator(3)).expect("measured");
    (campaign.sessions.base, campaign.sessions.tool) = (Sharing::All, Sharing::All);
    let model = robot.model.arranged(&campaign);
    let found = judge(&Evidence::of(&model, &campaign), &Limits::default());
    found.into_iter().find(|diagnostic| diagnostic.code == Code::SessionsDiffer)
}

#[test]
fn sessions_are_as_far_apart_as_their_bases_and_tools() {
    let turned = [0.0, 0.0, 0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2];
    for (base, tool) in [([0.0; 6], 0.04), (turned, 0.0), ([0.019, 0.0, 0.0, 0.0, 0.0, 0.02], 0.04)] {
        let found = told(base, tool).expect("told");
        let figure = |name: &str| found.figures.get(name).copied();
        assert_eq!(figure("tool_mm").is_some(), tool > 0.0, "{}", found.message);
        assert_eq!(figure("base_mm").is_some(), base != [0.0; 6], "{}", found.message);
        if let Some(distance) = figure("tool_mm") {
            assert!((distance - 40.0).abs() < 0.2, "{}", found.message);
        }
        if let Some(angle) = figure("base_deg") {
            assert!((angle - base[5].to_degrees()).abs() < 0.02, "{}", found.message);
        }
    }
    assert_eq!(told([0.0; 6], 0.0), None);
}

#[test]
fn a_face_has_a_unit_normal_and_residuals_find_its_place() {
    let contact = |near: &str| {
        format!(
            "{UR5}observes: contact\nestimate: {{tool: true}}\ninstrument: {{sigma: 0.02}}\n\
             contacts: {{table: {{kind: plane{near}}}}}\nmeasurements: measurements.csv\n"
        )
    };
    let folder = with(&[("c.yaml", &contact(", near: [100, 400, 300]"))]);
    let at = folder.path();
    printed_json(at, &["simulate", "c.yaml", "--poses", "40", "--errors", "0", "--into", "m"]);
    std::fs::write(at.join("m/campaign.yaml"), contact("")).expect("written");
    let checked = printed_json(at, &["check", "m"]);
    let targets = checked["estimate"]["targets"].as_array().expect("a list");
    assert!(targets.contains(&"table.offset".into()), "{targets:?}");
    let found = printed_json(at, &["register", "m", "--save", "s.yaml", "--check", "0"]);
    let of = |name: &str| {
        let mut all = found["parameters"].as_array().expect("a list").iter();
        all.find(|own| own["name"] == name).unwrap_or_else(|| panic!("{name}"))
    };
    let normal = ["table.nx", "table.ny", "table.nz"].map(|name| {
        assert!(of(name)["nominal"].is_null() && number(&of(name)["ci95"]) > 0.0, "{}", of(name));
        number(&of(name)["value"])
    });
    assert!((normal.iter().map(|v| v * v).sum::<f64>() - 1.0).abs() < 1e-12, "{normal:?}");
    let shown = run(at, &["register", "m", "--check", "0"]).out;
    assert!(["table.nx", "table.ny", "table.nz"].iter().all(|name| shown.contains(&format!("\n {name}"))), "{shown}");
    let left = printed_json(at, &["residuals", "s.yaml", "m"]);
    assert!(left["fitted"].as_array().expect("a list").contains(&"table.nx".into()), "{}", left["fitted"]);
    assert!(number(&left["all"]["rms"]) < 0.04, "{}", left["all"]);
}

#[test]
fn campaigns_with_sessions_and_noise_in_columns_are_simulated() {
    let folder = with(&[(
        "c.yaml",
        &format!("{UR5}observes: position\nmeasurements:\n- {{file: a.csv, instrument: {{sigma: 0.03}}}}\n- b.csv\n"),
    )]);
    let at = folder.path();
    let sessions = ["--sessions", "monday,friday", "--unknown-base", "--into", "m"];
    printed_json(at, &[&["simulate", "universal-ur5", "--poses", "20"][..], &sessions].concat());
    printed_json(at, &["simulate", "m", "--poses", "10", "--into", "t"]);
    let table = text(at, "t/measurements.csv");
    assert!(table.contains("monday") && table.contains("friday"), "{table}");
    printed_json(at, &["simulate", "c.yaml", "--poses", "5", "--noise", "0.2", "--into", "u"]);
    assert!(text(at, "u/campaign.yaml").contains("0.2"));
}

#[test]
fn a_check_names_kinds_anchors_and_zeros() {
    let campaign = format!(
        "{UR5}instrument: {{sigma: 0.05, torque: 1}}\nanchors: {{w: {{at: unknown, zero: unknown, near: [1500, 0, 200]}}}}\n\
         measurements:\n- {{file: a.csv, observes: distance}}\n- {{file: b.csv, observes: [position, torque]}}\n"
    );
    let folder = with(&[("c.yaml", &campaign)]);
    let at = folder.path();
    printed_json(at, &["simulate", "c.yaml", "--poses", "10", "--into", "m"]);
    let said = run(at, &["check", "m"]);
    for word in ["distance 10, position 10, torque 60", "w.zero", "0.0500 mm, 1.0000 N.m"] {
        assert!(said.out.contains(word), "{word}: {}", said.out);
    }
}

const ARM: &str = "robot: arm\nunits: {length: mm, angle: deg}\nvariables: [q1, q2]\nframes:\n\
                   \x20 1: {antecedent: 0, joint: revolute, variable: q1}\n\
                   \x20 2: {antecedent: 1, joint: revolute, variable: q2, d: 500}\n\
                   \x20 E: {antecedent: 2, d: 400}\ntool: {frame: E}\nbodies:\n  2: {mass: 4, com: [150, 0, 0]}\n";
const HEAD: &str = "robot: arm.yaml\nunits: {length: mm, angle: deg}\n";
const ROWS: &str = "pose,q1,q2,x,y,z\np1,0,0,900,0,0\np2,90,0,0,900,0\np3,0,90,500,400,0\n";

/// A campaign (behind its head), a table in the place of the usual one, how many errors, and what is said.
type Refused = (&'static str, &'static str, usize, &'static [&'static str]);

const REFUSED: [Refused; 12] = [
    (
        "observes: position\nmeasurements: r.csv\n",
        "pose,q1,q2,x,y,z,approach.q1\np1,0,0,900,0,0,2\n",
        1,
        &["r.csv:2", "1 where the joint came from above"],
    ),
    (
        "observes: position\nmeasurements: r.csv\n",
        "pose,q1,q2,x,y,z,order\na,0,0,900,0,0,1\nb,90,0,0,900,0,2\nc,0,90,500,400,0,2\n",
        1,
        &["r.csv:3", "r.csv:4", "`2`", "column `session`"],
    ),
    (
        "observes: position\ninstrument: {sigma: 0.1, ppm: -3}\nmeasurements: r.csv\n",
        ROWS,
        1,
        &["`ppm: -3`", "million"],
    ),
    (
        "observes: position\npayloads: {a: {mass: 5}}\nmeasurements: {file: r.csv, payload: b}\n",
        ROWS,
        1,
        &["c.yaml:5:38", "unknown payload `b`", "`a`"],
    ),
    (
        "observes: position\nmeasurements: {file: r.csv, load_point: b}\n",
        ROWS,
        1,
        &["c.yaml:4", "no marker or frame is called `b`"],
    ),
    (
        "observes: position\npayloads: {a: {mass: 5, frame: 1}}\nmeasurements: {file: r.csv, payload: a}\n",
        ROWS,
        1,
        &["c.yaml:4", "which is not the tool's body", "`bodies:`"],
    ),
    (
        "observes: position\npayloads: {a: {mass: 5, frame: 9}}\nmeasurements: {file: r.csv, payload: a}\n",
        ROWS,
        1,
        &["unknown frame `9`"],
    ),
    (
        "observes: position\nloads: {joints: measured}\ntorques: {q2: {gain: unknown}}\nmeasurements: r.csv\n",
        "q1,q2,x,y,z,torque.q2\n0,0,900,0,0,5.9\n90,0,0,900,0,0\n",
        1,
        &["c.yaml:5", "`q2`", "[position, torque]"],
    ),
    (
        "observes: position\ntorques: {q1: {offset: unknown}}\nmeasurements: r.csv\n",
        ROWS,
        1,
        &["c.yaml:4", "the offset is unknown", "no file observes `torque.q1`"],
    ),
    (
        "observes: pose\ncolumns: {qx: a, qy: b, qz: c, qw: d}\nmeasurements: r.csv\n",
        "pose,q1,q2,x,y,z,a,b,c,d\np1,0,0,900,0,0,0,0,0,1\n",
        1,
        &["qx, qy, qz, qw hold an orientation", "orientation: {quaternion: xyzw}"],
    ),
    (
        "observes: contact\ncontacts: {fx: {kind: plane}}\nmeasurements: r.csv\n",
        "pose,q1,q2,x,contact\np1,0,0,900,fx\n",
        1,
        &["unknown column `x`", "list it under `ignore:`"],
    ),
    (
        "observes: inclination\nmeasurements: {file: r.csv, mount: yes}\n",
        "q1,q2,gx,gy,gz\n0,0,0,0,1\n",
        1,
        &["c.yaml:4", "or `unknown`, found `yes`"],
    ),
];

#[test]
fn faults_are_told_once_with_place_and_remedy() {
    for (campaign, table, errors, words) in REFUSED {
        let folder = with(&[("arm.yaml", ARM), ("c.yaml", &format!("{HEAD}{campaign}")), ("r.csv", table)]);
        let said = run(folder.path(), &["check", "c.yaml"]);
        assert_eq!(said.status, 2, "{campaign}\n{}", said.out);
        for word in words {
            assert!(said.err.contains(word), "`{word}` is not said of\n{campaign}\n{}", said.err);
        }
        assert!(said.err.contains(&format!("{errors} error")), "{campaign}\n{}", said.err);
        assert!(!said.err.contains("columns: {fx: x}"), "{}", said.err);
    }
    let weightless = ARM.replace("bodies:", "materials: {steel: {young: 210, poisson: 0.3, density: 0}}\nbodies:");
    let said = run(with(&[("arm.yaml", &weightless)]).path(), &["check", "arm.yaml"]);
    assert!(said.err.contains("`density` is 0") && said.err.contains("leave `density` out"), "{}", said.err);
}

#[test]
fn a_robot_of_few_axes_is_told_of_what_it_may_let_go() {
    let folder = with(&[("path.csv", "x,y,z,rx,ry,rz\n900,300,500,0,0,0\n")]);
    let said = run(folder.path(), &["compensate", "scara-rail", "path.csv"]);
    assert!(said.err.contains("--hold"), "{} {}", said.out, said.err);
}

const THREE_RRR: &str = "robot: 3-RRR
units: {length: mm, angle: deg}
variables: [q1, q2, q3]
frames:
  m1: {antecedent: 0, joint: revolute, variable: q1, gamma: -150, d: 400, theta: 150}
  e1: {antecedent: m1, joint: revolute, passive: true, d: 250}
  p: {antecedent: e1, joint: revolute, passive: true, d: 250}
  m2: {antecedent: 0, joint: revolute, variable: q2, gamma: -30, d: 400, theta: 30}
  e2: {antecedent: m2, joint: revolute, passive: true, d: 250}
  t2: {antecedent: e2, d: 250}
  m3: {antecedent: 0, joint: revolute, variable: q3, gamma: 90, d: 400, theta: -90}
  e3: {antecedent: m3, joint: revolute, passive: true, d: 250}
  t3: {antecedent: e3, d: 250}
  c2: {antecedent: p, d: 173.205081}
  c3: {antecedent: p, gamma: 60, d: 173.205081}
  C: {antecedent: p, gamma: 30, d: 100}
loops:
  l2: {frames: [c2, t2], kind: planar, meet: origin, branch: {e1: -60, p: 20, e2: -60}, at: {q1: 70, q2: 190, q3: 310}}
  l3: {frames: [c3, t3], kind: planar, meet: origin, branch: {e3: -60}, at: {q1: 70, q2: 190, q3: 310}}
tool: {frame: C}
";

#[test]
fn a_closed_robot_without_limits_reaches_its_targets() {
    let folder = with(&[("rrr.yaml", THREE_RRR)]);
    let found = printed_json(folder.path(), &["solve", "rrr.yaml", "--target", "20,10,0,0,0,60", "--restarts", "16"]);
    assert!(!found["solutions"].as_array().expect("a list").is_empty(), "{found}");
}
