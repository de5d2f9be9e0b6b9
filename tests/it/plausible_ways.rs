//! Mistakes of which several readings of the files are as good, or in conventions and units of a part of the readings.

use std::fs;
use std::path::Path;

use super::cli::run;
use super::plausibility::{Table, doubts, json, of_code, spoil, starter};

fn ok(at: &Path, arguments: &[&str]) {
    let ran = run(at, arguments);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
}

/// The refusal of a command, with words of it.
fn refuses(at: &Path, arguments: &[&str], code: &str, words: &[&str]) {
    let ran = run(at, &[arguments, &["--format", "json"]].concat());
    assert_eq!(ran.status, 2, "{}{}", ran.out, ran.err);
    let told = of_code(&json(&ran), code);
    let all = told.iter().map(ToString::to_string).collect::<String>();
    words.iter().for_each(|word| assert!(all.contains(word), "{word}: {} {}", ran.out, ran.err));
}

/// With axes 1, 4 and 6 counted the other way an arm is its mirror image: both are named, for only one is the mistake.
#[test]
fn an_arm_and_its_mirror_image_are_both_named() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t: &mut Table| t.scale(&["q1", "q4", "q6"], -1.0));
    let words = ["one axis of the readings mirrored", "with `q1` negated and `q4` negated and `q6` negated", "; or: "];
    refuses(at, &["identify", "c"], "misread", &words);
}

/// Orientations as angles in the reverse order, as inverse rotations, in gon.
#[test]
fn orientations_of_another_convention_are_named() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "40", "--seed", "4", "--observes", "pose"];
    ok(at, &[&arm[..], &["--unknown-base", "--unknown-tool", "--into", "sound"]].concat());
    let rotation = ["rx", "ry", "rz"];
    let number = |t: &Table, row: usize, name: &str| t.rows[row][t.column(name)].parse::<f64>().expect("deg");
    let changed = |into: &str, change: &dyn Fn(nalgebra::Vector3<f64>) -> nalgebra::Vector3<f64>| {
        copied(&at.join("sound"), &at.join(into));
        spoil(&at.join(into), |t: &mut Table| {
            for row in 0..t.rows.len() {
                let own = nalgebra::Vector3::from(rotation.map(|name| number(t, row, name)));
                let new = change(own);
                let columns = rotation.map(|name| t.column(name));
                columns.iter().zip(&new).for_each(|(&column, value)| t.rows[row][column] = value.to_string());
            }
        });
    };
    changed("inverse", &|own| -own);
    // Errors of positions and of orientations, each in its unit.
    refuses(at, &["identify", "inverse"], "misread", &["rotations inverted", " mm and ", " deg to "]);
    changed("gon", &|own| own / 0.9);
    refuses(at, &["identify", "gon"], "wrong-units", &["in gon, and declared in deg"]);
    changed("angles", &|own| {
        let (x, y, z) = nalgebra::Rotation3::new(own.map(f64::to_radians)).euler_angles();
        nalgebra::Vector3::new(z, y, x).map(f64::to_degrees)
    });
    refuses(at, &["identify", "angles"], "misread", &["angles about z, y', x''"]);
    let found = json(&run(at, &["identify", "sound", "--format", "json"]));
    assert!(of_code(&found, "misread").is_empty(), "{}", found["diagnostics"]);
}

fn copied(from: &Path, to: &Path) {
    fs::create_dir(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        if let (true, Some(name)) = (path.is_file(), path.file_name()) {
            fs::copy(&path, to.join(name)).expect("a copy");
        }
    }
}

/// A palletiser whose third zero is three degrees off: what its linkage tells there and not where it is a parallelogram is fitted too.
#[test]
fn a_zero_that_is_far_off_is_fitted_to_the_noise() {
    let folder = starter();
    let at = folder.path();
    let made = ["simulate", "palletiser", "--poses", "50", "--seed", "1", "--noise", "0.03", "--errors", "1"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", "p"]].concat());
    spoil(&at.join("p"), |t: &mut Table| {
        let column = t.column("q3");
        t.rows.iter_mut().for_each(|row| row[column] = (row[column].parse::<f64>().expect("deg") + 3.0).to_string());
    });
    let found = doubts(at, &["identify", "p"], "moved-far", &["crank.theta"]);
    let left = found["residuals"]["check_after"]["rms"].as_f64().expect("mm");
    assert!(left < 0.07, "{left} mm, where the noise is 0.052");
}

/// Parallelograms that are none: lengths that the described ones hide show, and are fitted, where the noise would tell that they are
/// missed.
#[test]
fn parallelograms_within_their_tolerances_are_fitted_to_the_noise() {
    let folder = starter();
    let at = folder.path();
    let made = ["simulate", "palletiser", "--poses", "200", "--seed", "24", "--noise", "0.01", "--markers", "ball"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", "p"]].concat());
    let found = json(&run(at, &["identify", "p", "--format", "json"]));
    let left = found["residuals"]["check_after"]["rms"].as_f64().expect("mm");
    assert!(left < 0.0195, "{left} mm, where the noise is 0.0173");
    let said = json(&run(at, &["diagnose", "p", "--format", "json"]));
    assert_eq!(said["verdict"], "no-gap", "{}", said["causes"]);
}

/// A gantry's readings, whose noise is 0.01 mm.
fn gantry(at: &Path, spoiled: impl Fn(&mut Table)) {
    let made = ["simulate", "scara-rail", "--poses", "50", "--seed", "1", "--noise", "0.01", "--errors", "1"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", "s"]].concat());
    spoil(&at.join("s"), spoiled);
}

/// What a cause explains is applied, however little calibration alone explains.
#[test]
fn a_cause_is_applied_where_calibration_explains_little() {
    let folder = starter();
    let at = folder.path();
    gantry(at, |t| t.scale(&["rail"], 1.02));
    let ran = run(at, &["diagnose", "s", "--apply", "x.yaml"]);
    assert!(ran.status == 0 && at.join("x.yaml").exists(), "{}{}", ran.out, ran.err);
    assert!(ran.out.contains("Explained: gear-ratio at joint:carriage"), "{}", ran.out);
}

/// One axis of the readings stretched: constants take up a part of it, and what is left is hundreds of times the noise.
#[test]
fn what_is_left_far_above_the_noise_is_not_saved() {
    let folder = starter();
    let at = folder.path();
    gantry(at, |t| t.scale(&["y"], 1.02));
    doubts(
        at,
        &["identify", "s"],
        "unlike-description",
        &["times the stated noise: no constants describe these readings"],
    );
    let ran = run(at, &["identify", "s", "--save", "x.yaml"]);
    assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{}{}", ran.out, ran.err);
}

/// Where nothing is re-fitted geometry competes as a cause; what a calibration then says of the readings is said.
#[test]
fn a_diagnosis_says_what_identify_refuses() {
    let folder = starter();
    let at = folder.path();
    spoil(&at.join("c"), |t: &mut Table| t.scale(&["x", "y", "z"], 1.05));
    let campaign = at.join("c/campaign.yaml");
    let text = fs::read_to_string(&campaign).expect("text");
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("calibrate:")).collect();
    fs::write(&campaign, lines.join("\n") + "\ncalibrate: []\n").expect("written");
    let ran = run(at, &["diagnose", "c", "--apply", "x.yaml"]);
    assert!(ran.out.contains("`identify` refuses this campaign (moved-far)"), "{}{}", ran.out, ran.err);
    assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{}{}", ran.out, ran.err);
}

/// What is done to a table, the code of what is said of it, and words of that.
type Mistake<'a> = (&'a dyn Fn(&mut Table), &'a str, &'a [&'a str]);

/// The joint columns of the starter in other orders, units and sums, and zeros of two joints.
#[test]
fn joint_columns_read_otherwise_are_named() {
    let sound = starter();
    let joints = ["q1", "q2", "q3", "q4", "q5", "q6"];
    let added = |t: &mut Table, to: &str, from: &str, factor: f64| {
        let [to, from] = [t.column(to), t.column(from)];
        for row in &mut t.rows {
            let value = |at: usize| row[at].parse::<f64>().expect("deg");
            row[to] = (value(to) + factor * value(from)).to_string();
        }
    };
    let turned = |t: &mut Table, name: &str, by: f64| {
        let column = t.column(name);
        t.rows.iter_mut().for_each(|row| row[column] = (row[column].parse::<f64>().expect("deg") + by).to_string());
    };
    let reversed = |t: &mut Table| {
        for (a, b) in [("q1", "q6"), ("q2", "q5"), ("q3", "q4")] {
            t.swap(a, b);
        }
    };
    let mistakes: [Mistake; 8] = [
        (
            &|t| {
                t.scale(&["q3"], -1.0);
                turned(t, "q3", 90.0);
            },
            "misread",
            &["`q3` negated", "+90 deg added to `q3`"],
        ),
        (&reversed, "misread", &["the joint columns in reverse order", "numbered from the tool?"]),
        (&|t| added(t, "q3", "q2", 1.0), "misread", &["`q3` replaced by `q3` - `q2`", "report the sum"]),
        (&|t| added(t, "q3", "q2", -1.0), "misread", &["`q3` replaced by `q3` + `q2`", "report the difference"]),
        (&|t| t.scale(&joints, 1.0 / 0.9), "wrong-units", &["in gon, and declared in deg"]),
        (&|t| t.scale(&joints, 1e3_f64.to_radians()), "wrong-units", &["in mrad, and declared in deg"]),
        (&|t| t.scale(&joints, 1.0 / 360.0), "wrong-units", &["in turns, and declared in deg"]),
        (
            &|t| {
                turned(t, "q2", 90.0);
                turned(t, "q4", 180.0);
            },
            "misread",
            &["-90 deg added to `q2`", "+180 deg added to `q4`"],
        ),
    ];
    for (change, code, words) in mistakes {
        let folder = tempfile::tempdir().expect("a folder");
        copied(&sound.path().join("c"), &folder.path().join("c"));
        spoil(&folder.path().join("c"), change);
        refuses(folder.path(), &["check", "c"], code, words);
    }
}

/// An external axis whose column stands at the other end.
#[test]
fn an_external_axis_at_the_other_end_is_named() {
    let folder = starter();
    let at = folder.path();
    gantry(at, |t| {
        let columns = ["rail", "q1", "q2", "down", "q4"].map(|name| t.column(name));
        for row in &mut t.rows {
            let old = columns.map(|column| row[column].clone());
            (0..5).for_each(|k| row[columns[k]].clone_from(&old[(k + 1) % 5]));
        }
    });
    refuses(
        at,
        &["check", "s"],
        "misread",
        &["`rail` read from the column `q4`", "an external axis at the other end?"],
    );
}

/// Names of three markers shifted by one.
#[test]
fn markers_that_are_moved_on_are_named() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "kuka-kr270", "--poses", "20", "--markers", "m1,m2,m3", "--seed", "1", "--into", "k"];
    ok(at, &[&arm[..], &["--unknown-base"]].concat());
    spoil(&at.join("k"), |t: &mut Table| {
        let marker = t.column("marker");
        for row in &mut t.rows {
            row[marker] = match row[marker].as_str() {
                "m1" => "m2".into(),
                "m2" => "m3".into(),
                _ => "m1".into(),
            };
        }
    });
    refuses(at, &["check", "k"], "misread", &["names of the markers shifted?"]);
}

/// A tool that is described without the radius of its reflector.
#[test]
fn a_missing_radius_is_told() {
    let folder = starter();
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "40", "--seed", "2", "--observes", "pose", "--unknown-base"];
    ok(at, &[&arm[..], &["--set", "tool.z=19.05", "--errors", "0.3", "--into", "r"]].concat());
    let words = ["with the tool estimated", "most of it along z: is the radius of a reflector missing?"];
    refuses(at, &["check", "r"], "misread", &words);
}

/// Readings a fiftieth too long on a robot with a rail: its lengths and its rail by that much, or the instrument's scale.
#[test]
fn a_scale_is_not_named_as_a_rail() {
    let folder = starter();
    let at = folder.path();
    std::fs::write(at.join("railed.yaml"), RAILED).expect("written");
    let arm = ["simulate", "railed.yaml", "--poses", "60", "--seed", "3", "--noise", "0.05", "--markers", "a,b"];
    for (factor, begin) in [(1.001, "Explained: "), (1.005, "Explained: instrument-scale at instrument")] {
        ok(at, &[&arm[..], &["--unknown-base", "--unknown-tool", "--into", "s"]].concat());
        spoil(&at.join("s"), |t: &mut Table| t.scale(&["x", "y", "z"], factor));
        let ran = run(at, &["diagnose", "s"]);
        let finding = ran.out.lines().find(|line| line.starts_with("Explained")).unwrap_or_default();
        assert!(finding.starts_with(begin), "{factor}: {}", ran.out);
        for name in ["instrument-scale at instrument", "gear-ratio at joint:0r"] {
            assert!(finding.contains(name), "{factor}: {finding}");
        }
        std::fs::remove_dir_all(at.join("s")).expect("removed");
    }
    ok(at, &[&arm[..], &["--unknown-base", "--unknown-tool", "--into", "s"]].concat());
    spoil(&at.join("s"), |t: &mut Table| t.scale(&["x", "y", "z"], 1.03));
    doubts_or_refuses(at, "s", "wrong-units", "is the instrument's scale off by 3.0");
}

/// The campaign is doubted or refused, with these words.
fn doubts_or_refuses(at: &Path, campaign: &str, code: &str, words: &str) {
    let ran = run(at, &["check", campaign, "--format", "json"]);
    let told = of_code(&json(&ran), code);
    assert!(told.iter().any(|told| told.to_string().contains(words)), "{} {}", ran.out, ran.err);
}

/// An arm of six joints on a rail.
const RAILED: &str = "robot: arm on a rail
units: {length: mm, angle: deg}
variables: [rail, q1, q2, q3, q4, q5, q6]
frames:
  0r: {antecedent: 0, joint: prismatic, variable: rail, alpha: -90, limits: [0, 3000]}
  1: {antecedent: 0r, joint: revolute, variable: q1, alpha: 90, r: 450, limits: [-170, 170]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 150, alpha: -90, theta: -90, limits: [-90, 110]}
  3: {antecedent: 2, joint: revolute, variable: q3, d: 600, limits: [-120, 80]}
  4: {antecedent: 3, joint: revolute, variable: q4, d: 120, alpha: -90, r: 640, limits: [-180, 180]}
  5: {antecedent: 4, joint: revolute, variable: q5, alpha: 90, limits: [-120, 120]}
  6: {antecedent: 5, joint: revolute, variable: q6, alpha: -90, r: 100, limits: [-300, 300]}
tool: {frame: 6, at: [20, 0, 150]}
markers:
  a: {frame: 6, at: [80, 10, 60]}
  b: {frame: 6, at: [-60, 50, 80]}
";

/// A tool that was changed between two sessions which share it: a diagnosis that explains nothing writes no more than `identify` does.
#[test]
fn a_diagnosis_writes_nothing_that_identify_does_not() {
    let folder = starter();
    let at = folder.path();
    let made = ["simulate", "universal-ur10", "--poses", "60", "--seed", "3", "--sessions", "a,b", "--unknown-base"];
    ok(at, &[&made[..], &["--unknown-tool", "--into", "s"]].concat());
    let campaign = at.join("s/campaign.yaml");
    let text = fs::read_to_string(&campaign).expect("text");
    fs::write(&campaign, text.replace("tool: per-session", "tool: true")).expect("written");
    for command in [["identify", "s", "--save", "x.yaml"], ["diagnose", "s", "--apply", "x.yaml"]] {
        let ran = run(at, &command);
        assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{command:?}: {}{}", ran.out, ran.err);
        assert!(ran.out.contains("DOUBTFUL (moved-midway)"), "{command:?}: {}", ran.out);
    }
}

/// A joint that never moved is said, and a path that moves it lies outside the range that `--save` writes.
#[test]
fn a_joint_that_never_moved_is_said() {
    let folder = starter();
    let at = folder.path();
    let made = ["simulate", "universal-ur10", "--poses", "40", "--seed", "3", "--range", "q5=40:40.001"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", "s"]].concat());
    let said = json(&run(at, &["identify", "s", "--save", "fitted.yaml", "--format", "json"]));
    let told = of_code(&said, "weak-direction");
    assert!(told.iter().any(|one| one.to_string().contains("never moved: `q5`")), "{}", said["diagnostics"]);
    for (q5, expected) in [("40", 0), ("-70", 1)] {
        let joints = format!("10,-60,60,20,{q5},10");
        let said = json(&run(at, &["pose", "fitted.yaml", "--joints", &joints, "--format", "json"]));
        assert_eq!(of_code(&said, "outside-validity").len(), expected, "q5 = {q5}: {}", said["diagnostics"]);
    }
}

/// What a diagnosis wrote, in the place of the controller's description; joints of a path in rad.
#[test]
fn what_compensate_is_given_by_mistake() {
    let folder = starter();
    let at = folder.path();
    ok(at, &["diagnose", "c", "--apply", "d.yaml"]);
    let said = |rows: &str, robot: &str, nominal: &str| {
        fs::write(at.join("path.csv"), format!("q1,q2,q3,q4,q5,q6\n{rows}")).expect("written");
        json(&run(at, &["compensate", robot, "path.csv", "--nominal", nominal, "--format", "json"]))
    };
    let degrees = "10,20,30,5,30,0\n11,20,30,5,30,0\n";
    let exchanged = said(degrees, "c/robot.yaml", "d.yaml")["diagnostics"].to_string();
    assert!(exchanged.contains("the wrong sign if they are exchanged"), "{exchanged}");
    assert!(of_code(&said(degrees, "d.yaml", "c/robot.yaml"), "wrong-units").is_empty());
    let radians = said("0.2,0.3,0.5,0.1,0.5,0\n0.3,0.3,0.5,0.1,0.5,0\n", "d.yaml", "c/robot.yaml");
    assert_eq!(of_code(&radians, "wrong-units").len(), 1, "{}", radians["diagnostics"]);
}

/// A compensator declared three times too stiff: the causes named are large, and the written description leaves what was claimed, or is
/// not written.
#[test]
fn a_written_description_leaves_what_was_claimed() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made =
        ["simulate", "kuka-kr270", "--poses", "30", "--seed", "4", "--markers", "m1,m2,m3", "--observes", "deflection"];
    let loads = ["--wrench", "0,0,-2500", "--wrench", "1000,0,-1500", "--errors", "0", "--elastic-errors", "1"];
    ok(at, &[&made[..], &loads, &["--noise", "0.03", "--into", "c"]].concat());
    let robots = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/robots"));
    fs::copy(robots.join("kuka-kr270.urdf"), at.join("c/kuka-kr270.urdf")).expect("copied");
    let text = fs::read_to_string(robots.join("kuka-kr270.yaml")).expect("text");
    let stiff = text.replace("compliance: 0.144e-6, identifiable: true", "compliance: 0.05e-6");
    assert_ne!(stiff, text);
    fs::write(at.join("c/r.yaml"), stiff).expect("written");
    let campaign = fs::read_to_string(at.join("c/campaign.yaml")).expect("text");
    fs::write(at.join("c/campaign.yaml"), campaign.replace("robot: kuka-kr270", "robot: r.yaml")).expect("written");
    let ran = run(at, &["diagnose", "c", "--apply", "c/a.yaml"]);
    if !at.join("c/a.yaml").exists() {
        assert!(ran.status == 1 && ran.out.starts_with("DOUBTFUL (unusable-result)"), "{}{}", ran.out, ran.err);
        return;
    }
    let left = json(&run(at, &["residuals", "c/a.yaml", "c", "--format", "json"]));
    let rms = left["all"]["rms"].as_f64().expect("a figure");
    assert!(rms < 0.1, "{rms} mm: {}", ran.out);
}

/// Lengths from two anchors under each other's names.
#[test]
fn exchanged_anchors_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let robot =
        fs::read_to_string(format!("{}/robots/universal-ur5.yaml", env!("CARGO_MANIFEST_DIR"))).expect("a robot");
    let anchors = "anchors: {A: [1500, 0, 0], B: [0, 1500, 0], C: [-1200, -900, 300]}\n";
    fs::write(at.join("arm.yaml"), format!("{robot}\n{anchors}")).expect("written");
    ok(at, &["simulate", "arm.yaml", "--observes", "distance", "--poses", "40", "--seed", "5", "--into", "d"]);
    let found = json(&run(at, &["identify", "d", "--format", "json"]));
    assert!(of_code(&found, "misread").is_empty(), "{}", found["diagnostics"]);
    spoil(&at.join("d"), |t: &mut Table| {
        let anchor = t.column("anchor");
        for row in &mut t.rows {
            row[anchor] = match row[anchor].as_str() {
                "A" => "B".into(),
                "B" => "A".into(),
                other => other.into(),
            };
        }
    });
    refuses(at, &["identify", "d"], "misread", &["the anchors `A` and `B` exchanged"]);
}

/// Two sessions of which one is of another machine of the type: each is calibrated to its noise, and both together are not.
#[test]
fn sessions_of_two_machines_are_not_calibrated_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let simulate = |name: &str, seed: &str| {
        let arguments =
            ["simulate", "universal-ur5", "--poses", "50", "--noise", "0.03", "--unknown-base", "--unknown-tool"];
        ok(at, &[&arguments[..], &["--seed", seed, "--into", name]].concat());
    };
    simulate("one", "21");
    simulate("two", "22");
    let text = fs::read_to_string(at.join("one/campaign.yaml")).expect("a campaign");
    let pooled = |other: &str| {
        let files = format!(
            "measurements:\n- {{file: one/measurements.csv, session: monday}}\n- {{file: {other}, session: friday}}\n"
        );
        let text = text.replace("measurements: measurements.csv\n", &files).replace("base: true", "base: per-session");
        let text = text.replace("tool: true", "tool: per-session");
        fs::write(at.join("both.yaml"), text).expect("written");
    };
    pooled("two/measurements.csv");
    let arguments = ["identify", "both.yaml", "--format", "json", "--save", "pooled.yaml"];
    let ran = run(at, &arguments);
    let said = of_code(&json(&ran), "sessions-differ");
    assert!(said.iter().any(|own| own.to_string().contains("not of one robot")), "{}{}", ran.out, ran.err);
    assert!(ran.status != 0 && !at.join("pooled.yaml").exists(), "{}", ran.err);
    // The same machine on another day.
    let table = fs::read_to_string(at.join("one/measurements.csv")).expect("a table");
    let (head, rows) = table.split_once('\n').expect("a head");
    let rows: Vec<&str> = rows.lines().collect();
    let (first, second) = rows.split_at(rows.len() / 2);
    let write = |name: &str, rows: &[&str]| fs::write(at.join(name), format!("{head}\n{}\n", rows.join("\n")));
    write("two/measurements.csv", second).expect("written");
    write("one/measurements.csv", first).expect("written");
    let ran = run(at, &arguments);
    assert!(ran.status == 0 && of_code(&json(&ran), "sessions-differ").is_empty(), "{}{}", ran.out, ran.err);
}

/// A joint set anew half-way, and no noise stated by which its step could be judged.
#[test]
fn a_step_without_a_stated_noise_is_seen() {
    let folder = starter();
    let at = folder.path();
    let path = at.join("c/campaign.yaml");
    let text = fs::read_to_string(&path).expect("a campaign");
    let lines = text.lines().filter(|line| !line.starts_with("instrument:"));
    fs::write(&path, lines.map(|line| format!("{line}\n")).collect::<String>()).expect("written");
    let arguments = ["identify", "c", "--save", "s.yaml", "--format", "json"];
    let sound = run(at, &arguments);
    assert!(sound.status == 0 && of_code(&json(&sound), "moved-midway").is_empty(), "{}{}", sound.out, sound.err);
    fs::remove_file(at.join("s.yaml")).expect("a description");
    spoil(&at.join("c"), |t: &mut Table| {
        let (joint, count) = (t.column("q3"), t.rows.len());
        for row in &mut t.rows[count / 2..] {
            row[joint] = (row[joint].parse::<f64>().expect("deg") + 0.1).to_string();
        }
    });
    let ran = run(at, &arguments);
    assert_eq!(of_code(&json(&ran), "moved-midway").len(), 1, "{}{}", ran.out, ran.err);
    assert!(ran.status != 0 && !at.join("s.yaml").exists(), "{}", ran.err);
}
