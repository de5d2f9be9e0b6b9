//! Masses, gravity, springs, sides of approach and noise of other quantities that cannot be meant.

use std::path::Path;

use serde_json::Value;

use super::cli::{Ran, run};
use super::plausibility::{Table, doubts, json, of_code, spoil, starter};

/// The arm of `init` with masses and springs.
pub(super) const LOADED: &str = "gravity: [0, 0, -9.81]
bodies:
  1: {mass: 150, com: [50, 0, -100]}
  2: {mass: 90, com: [300, 0, 0]}
  3: {mass: 60, com: [60, 0, 50]}
  4: {mass: 30, com: [0, 0, -200]}
  5: {mass: 12, com: [0, 0, 0]}
  6: {mass: 5, com: [0, 0, 50]}
joint_stiffness:
  2: {kar: {value: 2e5, identifiable: true}}
  3: {kar: {value: 1e5, identifiable: true}}
  4: {kar: {value: 4e4, identifiable: true}}
  5: {kar: {value: 3e4, identifiable: true}}
";

/// A folder with the starter's campaign in `c`, and its robot with masses and springs, changed, as `arm.yaml`.
fn loaded(change: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = starter();
    write_arm(folder.path(), "arm.yaml", change);
    folder
}

fn write_arm(at: &Path, name: &str, change: &[(&str, &str)]) {
    let robot = std::fs::read_to_string(at.join("c/robot.yaml")).expect("text");
    let bare = robot.split("# Masses and springs").next().expect("a part");
    let text = change.iter().fold(format!("{bare}{LOADED}"), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    std::fs::write(at.join(name), text).expect("written");
}

fn ok(ran: &Ran) {
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
}

/// What `check` warns of.
fn warned(at: &Path, file: &str) -> String {
    let found = json(&run(at, &["check", file, "--format", "json"]));
    let all = found["diagnostics"].as_array().expect("a list").iter();
    all.filter_map(|d| d["message"].as_str()).collect::<Vec<_>>().join("\n")
}

#[test]
fn gravity_masses_and_springs_of_another_unit_are_doubted() {
    let cases: &[(&[(&str, &str)], &str)] = &[
        (&[], ""),
        (&[("-9.81]", "0]")], ""),
        (&[("[0, 0, -9.81]", "[0, -8.5, 4.9]")], ""),
        (&[("-9.81]", "-1]")], "gravity is 1 m/s2"),
        (&[("-9.81]", "-9810]")], "gravity is 9810 m/s2"),
        (&[("mass: 90", "mass: 9000")], "has a mass of 9.000e3 kg"),
        (
            &[
                ("com: [50, 0, -100]", "com: [0.05, 0, -0.1]"),
                ("com: [300, 0, 0]", "com: [0.3, 0, 0]"),
                ("com: [60, 0, 50]", "com: [0.06, 0, 0.05]"),
                ("com: [0, 0, -200]", "com: [0, 0, -0.2]"),
                ("com: [0, 0, 50]", "com: [0, 0, 0.05]"),
            ],
            "the centres of mass of all bodies lie within 0.300 mm",
        ),
        (&[("2e5", "2e2"), ("1e5", "1e2"), ("4e4", "4e1"), ("3e4", "3e1")], "softer than any arm of its size"),
        (&[("2e5", "2e9"), ("1e5", "1e9"), ("4e4", "4e8"), ("3e4", "3e8")], "stiffer than a bar of steel"),
    ];
    for (change, said) in cases {
        let folder = loaded(change);
        let warned = warned(folder.path(), "arm.yaml");
        assert!(if said.is_empty() { warned.is_empty() } else { warned.contains(said) }, "{change:?}: {warned}");
    }
    for robot in ["kuka-kr270", "kuka-ir663", "palletiser", "franka-panda", "hexapod", "five-bar", "scara-rail"] {
        assert_eq!(warned(Path::new("."), robot), "", "{robot}");
    }
}

/// An arm that hangs, described as standing: springs that would have to bend against their loads are not written.
#[test]
fn a_hanging_arm_described_as_standing_is_doubted() {
    let folder = loaded(&[]);
    let at = folder.path();
    write_arm(at, "hanging.yaml", &[("-9.81]", "9.81]")]);
    let errors = ["--errors", "1", "--elastic-errors", "1", "--unknown-base", "--unknown-tool", "--noise", "0.03"];
    ok(&run(at, &[&["simulate", "hanging.yaml", "--poses", "40", "--seed", "4", "--into", "h"], &errors[..]].concat()));
    let campaign = at.join("h/campaign.yaml");
    let text = std::fs::read_to_string(&campaign).expect("text");
    let refitted = "calibrate: [geometry, joint-offset, joint-compliance]\n";
    let lines = text.lines().filter(|line| !line.starts_with("calibrate") && !line.starts_with("- "));
    std::fs::write(&campaign, lines.collect::<Vec<_>>().join("\n") + "\n" + refitted).expect("written");
    let right = run(at, &["diagnose", "h", "--robot", "hanging.yaml", "--apply", "right.yaml"]);
    assert!(right.status == 0 && at.join("right.yaml").exists(), "{}{}", right.out, right.err);
    let arguments = ["diagnose", "h", "--robot", "arm.yaml", "--apply", "wrong.yaml"];
    let ran = run(at, &arguments);
    let words = "with `gravity: [0, 0, 9.81]` (180 deg from that of the description)";
    assert!(ran.status == 2 && ran.err.contains(words) && !at.join("wrong.yaml").exists(), "{}{}", ran.out, ran.err);
    // Springs that compete as causes are held at what is declared; for this they are fitted.
    let held = std::fs::read_to_string(&campaign).expect("text").replace(", joint-compliance]", "]");
    std::fs::write(&campaign, held).expect("written");
    let ran = run(at, &arguments);
    assert!(ran.status == 2 && ran.err.contains(words) && !at.join("wrong.yaml").exists(), "{}{}", ran.out, ran.err);
}

/// Weights that are not those of the robot are named, with the noise stated and not: springs take up part of them, and the rest was
/// saved.
#[test]
fn weights_that_are_not_the_robots_are_named() {
    let folder = loaded(&[]);
    let at = folder.path();
    write_arm(at, "sloping.yaml", &[("[0, 0, -9.81]", "[2.54, 0, -9.476]")]);
    write_arm(at, "other.yaml", &[("2: {mass: 90,", "2: {mass: 30,"), ("4: {mass: 30,", "4: {mass: 90,")]);
    let errors = ["--errors", "1", "--elastic-errors", "1", "--unknown-base", "--unknown-tool", "--noise", "0.03"];
    let named = |robot: &str, message: &str| {
        ok(&run(at, &[&["simulate", robot, "--poses", "60", "--seed", "4", "--into", "w"], &errors[..]].concat()));
        let text = std::fs::read_to_string(at.join("w/campaign.yaml")).expect("text");
        let lines = text.lines().filter(|line| !line.starts_with("calibrate") && !line.starts_with("- "));
        let fitted = "calibrate: [geometry, joint-offset, joint-compliance]\n";
        let text = lines.collect::<Vec<_>>().join("\n") + "\n" + fitted;
        std::fs::write(at.join("w/campaign.yaml"), text).expect("written");
        let ran = run(at, &["identify", "w", "--robot", "arm.yaml", "--save", "wrong.yaml"]);
        assert!(ran.status == 2 && ran.err.contains(message), "{}{}", ran.out, ran.err);
        assert!(!at.join("wrong.yaml").exists());
        ok(&run(at, &["identify", "w", "--robot", robot, "--save", "right.yaml"]));
        std::fs::remove_dir_all(at.join("w")).expect("removed");
        std::fs::remove_file(at.join("right.yaml")).expect("removed");
    };
    named("sloping.yaml", "(15 deg from that of the description) the error of calibration falls from");
    named("other.yaml", "with the masses of bodies `2` and `4` exchanged the error of calibration falls from");
}

/// Torques are judged by their own noise.
#[test]
fn torques_far_above_their_noise_are_told() {
    let folder = loaded(&[]);
    let at = folder.path();
    let text = "robot: arm.yaml
units: {length: mm, angle: deg}
observes: torque
instrument: {torque: 0.5}
payloads: {block: {mass: 20}}
measurements: h.csv
";
    std::fs::write(at.join("t.yaml"), text).expect("written");
    ok(&run(at, &["simulate", "t.yaml", "--poses", "40", "--seed", "5", "--into", "t"]));
    let right = json(&run(at, &["identify", "t", "--format", "json"]));
    assert!(of_code(&right, "noise-unlike-stated").is_empty(), "{}", right["diagnostics"]);
    spoil(&at.join("t"), |t: &mut Table| t.swap("torque.q2", "torque.q3"));
    doubts(
        at,
        &["identify", "t"],
        "noise-unlike-stated",
        &["residuals of torques and forces are", "times the stated noise"],
    );
}

/// Orientations and positions are each judged by their own noise.
#[test]
fn orientations_are_judged_by_their_own_noise() {
    let folder = starter();
    let at = folder.path();
    let poses = ["simulate", "universal-ur10", "--observes", "pose", "--poses", "60", "--seed", "4"];
    let noise = ["--noise", "0.05", "--orientation-noise", "0.01", "--unknown-base", "--unknown-tool", "--into", "p"];
    ok(&run(at, &[&poses[..], &noise].concat()));
    let campaign = at.join("p/campaign.yaml");
    let text = std::fs::read_to_string(&campaign).expect("text");
    let line = text.lines().find(|line| line.trim_start().starts_with("orientation:")).expect("stated");
    for (stated, is_identifiable) in [("0.01", false), ("10", true), ("0.0001", true)] {
        std::fs::write(&campaign, text.replace(line, &format!("  orientation: {stated}"))).expect("written");
        let found = json(&run(at, &["identify", "p", "--format", "json"]));
        let told = of_code(&found, "noise-unlike-stated");
        let words = told.iter().any(|d| d["message"].as_str().is_some_and(|m| m.contains("residuals of orientations")));
        assert_eq!(words, is_identifiable, "{stated}: {}", found["diagnostics"]);
    }
}

/// Sides of approach the other way round make a backlash below zero, which no gear has.
#[test]
fn a_backlash_below_zero_is_doubted() {
    let folder = starter();
    let at = folder.path();
    let robot = std::fs::read_to_string(at.join("c/robot.yaml")).expect("text");
    let slack = "effects:\n- {effect: backlash, site: joint:3, parameters: {half_width: 0.0005}}\n";
    std::fs::write(at.join("slack.yaml"), robot + slack).expect("written");
    let poses = ["simulate", "slack.yaml", "--poses", "80", "--seed", "5", "--conditions", "--errors", "0"];
    ok(&run(at, &[&poses[..], &["--unknown-base", "--unknown-tool", "--noise", "0.03", "--into", "b"]].concat()));
    let diagnose = ["diagnose", "b", "--robot", "c/robot.yaml"];
    let right = json(&run(at, &[&diagnose[..], &["--format", "json"]].concat()));
    assert_eq!(right["causes"][0]["effect"], "backlash", "{}", right["causes"]);
    assert!(of_code(&right, "implausible").is_empty());
    let sides: Vec<String> = (1..=6).map(|k| format!("approach.q{k}")).collect();
    let sides: Vec<&str> = sides.iter().map(String::as_str).collect();
    spoil(&at.join("b"), |t: &mut Table| t.scale(&sides, -1.0));
    doubts(at, &diagnose, "implausible", &["backlash@joint:3", "cannot be below 0"]);
    let ran = run(at, &[&diagnose[..], &["--apply", "d.yaml"]].concat());
    assert!(ran.status == 1 && !at.join("d.yaml").exists(), "{}", ran.out);
}

/// The calibrated description in the place of the controller's corrects with the wrong sign; the same one twice corrects nothing.
#[test]
fn descriptions_that_are_exchanged_are_told() {
    let folder = starter();
    let at = folder.path();
    ok(&run(at, &["identify", "c", "--save", "fitted.yaml"]));
    std::fs::write(at.join("path.csv"), "q1,q2,q3,q4,q5,q6\n10,20,30,5,30,0\n11,20,30,5,30,0\n").expect("written");
    for (robot, nominal, said) in [
        ("fitted.yaml", "c/robot.yaml", ""),
        ("c/robot.yaml", "fitted.yaml", "the wrong sign if they are exchanged"),
        ("c/robot.yaml", "c/robot.yaml", "are the same description"),
    ] {
        let ran = run(at, &["compensate", robot, "path.csv", "--nominal", nominal, "--format", "json"]);
        let all: Value = json(&ran);
        let told = all["diagnostics"].to_string();
        assert!(
            if said.is_empty() { all["diagnostics"] == Value::Array(vec![]) } else { told.contains(said) },
            "{told}"
        );
    }
}

/// What `identify` says of a calibration stands in the report's JSON too.
#[test]
fn reports_carry_every_warning() {
    let folder = starter();
    let at = folder.path();
    for campaign in ["kr270-no-compensator", "ir663-paper-poses"] {
        let codes = |found: &Value| -> Vec<String> {
            let mut all: Vec<String> =
                found["diagnostics"].as_array().expect("a list").iter().map(|d| d["code"].to_string()).collect();
            all.sort();
            all.dedup();
            all
        };
        let found = codes(&json(&run(at, &["identify", campaign, "--format", "json"])));
        ok(&run(at, &["report", campaign, "--json", "data.json", "--output", "page.html"]));
        let text = std::fs::read_to_string(at.join("data.json")).expect("text");
        let report = codes(&serde_json::from_str(&text).expect("JSON"));
        assert!(found.iter().all(|code| report.contains(code)), "{campaign}: {found:?} {report:?}");
        let page = std::fs::read_to_string(at.join("page.html")).expect("text");
        assert!(found.iter().all(|code| page.contains(code.trim_matches('"'))), "{campaign}");
    }
}

/// Springs, or masses, that are all declared off by one factor: neither command takes that for the joints'.
#[test]
fn springs_off_by_one_factor_are_doubted() {
    let folder = loaded(&[]);
    let at = folder.path();
    let errors = ["--errors", "1", "--elastic-errors", "0.2", "--unknown-base", "--unknown-tool", "--noise", "0.03"];
    ok(&run(at, &[&["simulate", "arm.yaml", "--poses", "60", "--seed", "4", "--into", "h"], &errors[..]].concat()));
    write_arm(at, "stiff.yaml", &[("2e5", "2e6"), ("1e5", "1e6"), ("4e4", "4e5"), ("3e4", "3e5")]);
    let light = [("mass: 150", "mass: 15.3"), ("mass: 90", "mass: 9.18"), ("mass: 60", "mass: 6.12")];
    let lighter = [("mass: 30", "mass: 3.06"), ("mass: 12", "mass: 1.22"), ("mass: 5", "mass: 0.51")];
    write_arm(at, "light.yaml", &[light, lighter].concat());
    for robot in ["stiff.yaml", "light.yaml"] {
        let both = ["--what", "geometric,elastic", "--save", "x.yaml"];
        for command in [&[&["identify", "h"], &both[..]].concat()[..], &["diagnose", "h", "--apply", "x.yaml"]] {
            let ran = run(at, &[command, &["--robot", robot]].concat());
            let words = ["DOUBTFUL (wrong-units)", "softer than declared", "off by that factor?"];
            words.iter().for_each(|word| assert!(ran.out.contains(word), "{robot} {word}: {}{}", ran.out, ran.err));
            assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{robot}: {}", ran.out);
        }
    }
    // Of the right description, and of one with single springs that are off, nothing is said.
    write_arm(at, "soft.yaml", &[("2e5", "2e6")]);
    for robot in ["arm.yaml", "soft.yaml"] {
        for command in ["identify", "diagnose"] {
            let ran = run(at, &[command, "h", "--robot", robot]);
            assert!(!ran.out.contains("off by that factor?"), "{robot}: {}", ran.out);
        }
    }
}

/// Forces in lbf that are declared in N: every spring comes out four times too soft, though each a little otherwise than declared.
#[test]
fn forces_in_pounds_are_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "kuka-kr270", "--poses", "40", "--observes", "deflection", "--seed", "3", "--into", "d"];
    let loads = ["--wrench", "0,0,-2500", "--wrench", "1500,800,0", "--noise", "0.02"];
    ok(&run(at, &[&arm[..], &loads, &["--elastic-errors", "1", "--errors", "0"]].concat()));
    let identify = ["identify", "d", "--save", "x.yaml"];
    let right = run(at, &identify);
    assert!(!right.out.contains("(wrong-units)") && at.join("x.yaml").exists(), "{}", right.out);
    std::fs::remove_file(at.join("x.yaml")).expect("removed");
    spoil(&at.join("d"), |t: &mut Table| t.scale(&["fx", "fy", "fz"], 1.0 / 4.4482216152605));
    let ran = run(at, &identify);
    assert!(ran.out.contains("DOUBTFUL (wrong-units)") && ran.out.contains("lbf"), "{}", ran.out);
    assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{}", ran.out);
}

/// Positions under a load that are declared deflections.
#[test]
fn positions_declared_as_deflections_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "kuka-kr270", "--poses", "40", "--wrench", "0,0,-2500", "--noise", "0.02", "--into", "p"];
    ok(&run(at, &made));
    let file = at.join("p/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("text");
    std::fs::write(&file, text.replace("observes: position", "observes: deflection")).expect("written");
    let ran = run(at, &["identify", "p"]);
    let told = ["than the declared springs allow for", "are these positions (`observes: position`)?"];
    assert!(ran.status == 2 && told.iter().all(|words| ran.err.contains(words)), "{}{}", ran.out, ran.err);
}

/// Four orientations far off, beside an error that is greater than what they do at a tool's length.
#[test]
fn orientations_far_off_beside_a_gap_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    ok(&run(at, &["convert", "universal-ur10", "plain.yaml"]));
    let text = std::fs::read_to_string(at.join("plain.yaml")).expect("text");
    let ratio = "effects:\n- {effect: gear-ratio, site: joint:2, parameters: {ratio: 0.0005}}\n";
    std::fs::write(at.join("arm.yaml"), text + ratio).expect("written");
    let made = ["simulate", "arm.yaml", "--observes", "pose", "--poses", "160", "--seed", "4", "--errors", "0"];
    let noise = ["--noise", "0.03", "--orientation-noise", "0.003", "--unknown-base", "--unknown-tool", "--into", "p"];
    ok(&run(at, &[&made[..], &noise].concat()));
    spoil(&at.join("p"), |t: &mut Table| {
        let column = t.column("rx");
        for row in t.rows.iter_mut().skip(3).step_by(7).take(4) {
            let angle: f64 = row[column].parse().expect("a number");
            row[column] = (angle + 4.0).to_string();
        }
    });
    let identify = ["identify", "p", "--robot", "plain.yaml"];
    let ran = run(at, &identify);
    assert!(ran.out.contains("DOUBTFUL (outlying-readings): orientations of 4 of 160"), "{}", ran.out);
    let ran = run(at, &["diagnose", "p", "--robot", "plain.yaml"]);
    // As what explains a part of the gap, or as readings that explain none.
    let words = ["errors of orientations (rms) fall from", "orientations of 4 of 160"];
    assert!(words.iter().any(|word| ran.out.contains(word)) && !ran.out.contains("0 % less (0"), "{}", ran.out);
}

/// What readings hardly tell is held by `diagnose` as by `identify`, and both fit the springs of passive joints.
#[test]
fn springs_that_are_hardly_told_are_held_by_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "kuka-ir663", "--poses", "60", "--observes", "deflection", "--seed", "71", "--into", "d"];
    let loads = ["--wrench", "500,300,-1500,0,0,0", "--markers", "wrist", "--elastic-errors", "1", "--errors", "0"];
    ok(&run(at, &[&made[..], &loads].concat()));
    let identified = json(&run(at, &["identify", "d", "--format", "json", "--save", "i.yaml"]));
    let kept = identified["parameters"].as_array().expect("a list").iter();
    let kept: Vec<&Value> = kept.filter(|of| of["identifiable"] == true).map(|of| &of["name"]).collect();
    let diagnosed = json(&run(at, &["diagnose", "d", "--format", "json", "--apply", "d.yaml"]));
    assert_eq!(diagnosed["verdict"], "no-gap", "{}", diagnosed["causes"]);
    assert!(of_code(&diagnosed, "moved-far").is_empty(), "{}", diagnosed["diagnostics"]);
    let refitted: Vec<&Value> = diagnosed["refitted"]["parameters"].as_array().expect("a list").iter().collect();
    // Of those in series both take the same, one that the description has soft.
    for name in ["joint8.kr", "joint10.kr"] {
        let is_in = |all: &[&Value]| all.iter().any(|known| *known == name);
        assert_eq!([is_in(&refitted), is_in(&kept)], [name == "joint10.kr"; 2], "{name}: {refitted:?}, {kept:?}");
    }
}

/// Deflections whose campaign names nothing to be re-fitted: `identify` fits the springs, and `diagnose` says that it does not.
#[test]
fn springs_that_are_not_named_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "kuka-kr270", "--poses", "40", "--observes", "deflection", "--seed", "3", "--into", "d"];
    let loads = ["--wrench", "0,0,-2500", "--wrench", "1500,800,0", "--noise", "0.02"];
    ok(&run(at, &[&arm[..], &loads, &["--elastic-errors", "1", "--errors", "0"]].concat()));
    let file = at.join("d/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("text");
    std::fs::write(&file, text.replace("calibrate:\n- joint-compliance\n", "calibrate: []\n")).expect("written");
    doubts(at, &["diagnose", "d"], "springs-held", &["declares to be identified", "nothing but noise"]);
    let ran = run(at, &["diagnose", "d"]);
    assert!(ran.err.contains("is empty: springs compete as causes"), "{}", ran.err);
}

/// A description as diagnosed leaves what the diagnosis says, also where readings hardly show some of what is calibrated: it is held there.
#[test]
fn what_a_diagnosis_calibrates_is_what_it_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let robot = "robot: loaded six-axis arm
units: {length: mm, angle: deg, mass: kg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 450, limits: [-170, 170]}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, d: 150, theta: -90, limits: [-60, 90]}
  3: {antecedent: 2, joint: revolute, variable: q3, d: 600, limits: [-70, 120]}
  4: {antecedent: 3, joint: revolute, variable: q4, alpha: -90, d: 120, r: 640, limits: [-180, 180]}
  5: {antecedent: 4, joint: revolute, variable: q5, alpha: 90, limits: [-110, 110]}
  6: {antecedent: 5, joint: revolute, variable: q6, alpha: -90, limits: [-180, 180]}
  flange: {antecedent: 6, r: 100}
tool: {frame: flange}
bodies:
  2: {mass: 80, com: [300, 0, 0]}
  3: {mass: 60, com: [60, 0, 100]}
  4: {mass: 25, com: [0, 0, -100]}
  6: {mass: 8, com: [0, 0, 50]}
joint_stiffness:
  2: {kar: {compliance: 1.0e-6, identifiable: true}}
  3: {kar: {compliance: 2.0e-6, identifiable: true}}
";
    let campaign = "robot: arm.yaml
units: {length: mm, angle: deg, mass: kg}
observes: position
instrument: {sigma: 0.03}
estimate: {base: true, tool: true}
calibrate: [geometry, joint-offset, joint-compliance]
payloads: {block: {mass: 60, com: [0, 0, 80]}}
measurements:
- {file: empty.csv}
- {file: laden.csv, payload: block}
";
    std::fs::write(at.join("arm.yaml"), robot).expect("written");
    std::fs::write(at.join("camp.yaml"), campaign).expect("written");
    for file in ["empty.csv", "laden.csv"] {
        let poses: String = (0..3).map(|k| format!("p{k},{k}0,10,{k}0,20,3{k},0,0,0,{k}\n")).collect();
        std::fs::write(at.join(file), format!("pose,q1,q2,q3,q4,q5,q6,x,y,z\n{poses}")).expect("written");
    }
    let made = ["simulate", "camp.yaml", "--poses", "40", "--elastic-errors", "1", "--seed", "2", "--into", "s"];
    ok(&run(at, &made));
    ok(&run(at, &["diagnose", "s", "--apply", "d.yaml"]));
    let found = json(&run(at, &["diagnose", "s", "--format", "json"]));
    assert!(of_code(&found, "unusable-result").is_empty(), "{}", found["diagnostics"]);
}

/// With gravity the wrong way round springs come out rigid, and what remains is not what springs below zero would leave.
#[test]
fn what_rigid_springs_leave_is_told() {
    let folder = starter();
    let at = folder.path();
    let robot = std::fs::read_to_string(at.join("c/robot.yaml")).expect("text");
    let springs = "bodies: {2: {mass: 80, com: [300, 0, 0]}, 3: {mass: 60, com: [60, 0, 100]}}
joint_stiffness: {2: {kar: {compliance: 1.0e-6, identifiable: true}}, 3: {kar: {compliance: 2.0e-6, identifiable: true}}}\n";
    std::fs::write(at.join("right.yaml"), format!("{robot}{springs}")).expect("written");
    std::fs::write(at.join("wrong.yaml"), format!("{robot}{springs}gravity: [0, 0, 9.81]\n")).expect("written");
    let made = [
        "simulate",
        "right.yaml",
        "--poses",
        "60",
        "--unknown-base",
        "--unknown-tool",
        "--noise",
        "0.03",
        "--into",
        "s",
    ];
    ok(&run(at, &made));
    let diagnose = ["diagnose", "s", "--robot", "wrong.yaml", "--force"];
    doubts(at, &diagnose, "unusable-result", &["read back, leaves"]);
    let right = json(&run(at, &["diagnose", "s", "--robot", "right.yaml", "--format", "json"]));
    assert!(of_code(&right, "unusable-result").is_empty(), "{}", right["diagnostics"]);
}

/// Springs that are fitted to an arm with another forearm: the length is told, and nothing is written.
#[test]
fn a_length_behind_wrong_springs_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("arm.yaml"), SPRINGY).expect("written");
    let loads =
        ["--wrench=0,0,-150", "--wrench=80,60,0", "--elastic-errors", "0.5", "--errors", "0", "--noise", "0.03"];
    let made = ["simulate", "arm.yaml", "--poses", "30", "--observes", "deflection", "--seed", "41", "--into", "c"];
    let ran = run(at, &[&made[..], &loads].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let sound = run(at, &["identify", "c", "--save", "sound.yaml", "--format", "json"]);
    assert_eq!(sound.status, 0, "{}{}", sound.out, sound.err);
    assert!(of_code(&json(&sound), "unlike-description").is_empty(), "{}", sound.out);
    // A great error leaves more than the noise, a small one does not, and is significant.
    for length in ["512", "652"] {
        let other = SPRINGY.replace("d: 612", &format!("d: {length}"));
        assert_ne!(other, SPRINGY);
        std::fs::write(at.join("arm.yaml"), other).expect("written");
        let instead = format!("instead of {length}");
        let found = doubts(at, &["identify", "c"], "unlike-description", &["with `3.d` of 6", &instead]);
        let figures = &of_code(&found, "unlike-description")[0]["figures"];
        assert!(figures["ratio_with"].as_f64() < Some(1.2), "{figures}");
        assert_eq!(run(at, &["identify", "c", "--save", "found.yaml"]).status, 1);
        assert!(!at.join("found.yaml").exists());
    }
}

/// Loads three hundred times too small for the noise: a calibration leaves the springs as declared, and a diagnosis says that it knows none.
#[test]
fn loads_within_the_noise_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("arm.yaml"), SPRINGY).expect("written");
    let loads =
        ["--wrench=0,0,-0.45", "--wrench=0.24,0.18,0", "--elastic-errors", "0.5", "--errors", "0", "--noise", "0.03"];
    let made = ["simulate", "arm.yaml", "--poses", "30", "--observes", "deflection", "--seed", "41", "--into", "c"];
    let ran = run(at, &[&made[..], &loads].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert_eq!(json(&run(at, &["identify", "c", "--format", "json"]))["kept"], 0);
    let ran = run(at, &["diagnose", "c", "--apply", "a.yaml", "--format", "json"]);
    let told = of_code(&json(&ran), "too-little-data");
    let words = told.first().and_then(|one| one["message"].as_str()).unwrap_or_else(|| panic!("{}", ran.out));
    assert!(words.contains("no spring is known to better than its own size"), "{words}");
    assert!(ran.status == 1 && !at.join("a.yaml").exists(), "{}", ran.err);
}

/// An arm as long as a UR10, with springs in its joints.
const SPRINGY: &str = "robot: springy
units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 128, limits: [-170, 170]}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: 90, limits: [-170, -10]}
  3: {antecedent: 2, joint: revolute, variable: q3, d: 612, limits: [-150, 150]}
  4: {antecedent: 3, joint: revolute, variable: q4, d: 572, r: 164, limits: [-170, 170]}
  5: {antecedent: 4, joint: revolute, variable: q5, alpha: 90, r: 116, limits: [-170, 170]}
  6: {antecedent: 5, joint: revolute, variable: q6, alpha: -90, r: 92, limits: [-170, 170]}
tool: {frame: 6, at: [0, 0, 60]}
joint_stiffness:
  1: {kar: {value: 4.0e+4, identifiable: true}}
  2: {kar: {value: 3.0e+4, identifiable: true}}
  3: {kar: {value: 2.0e+4, identifiable: true}}
  4: {kar: {value: 1.0e+4, identifiable: true}}
  5: {kar: {value: 8.0e+3, identifiable: true}}
  6: {kar: {value: 6.0e+3, identifiable: true}}
";
