//! What sceptical users found: checks that accused sound data, figures that outliers ruled, files that were compared with what they do not
//! state.

use std::path::Path;

use super::cli::run;
use super::plausibility::{Table, doubts, json, of_code, refuses, simulated, spoil, starter};
use super::support::{KR270_MASSES, heavy_kr270};

/// An arm of which weights and a wrench show constants that nothing else does, and hardly.
const LOADED: &str = "robot: arm
units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 400, limits: [-170, 170]}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, d: 150, theta: -90, limits: [-80, 80]}
  3: {antecedent: 2, joint: revolute, variable: q3, d: 600, limits: [-70, 120]}
  4: {antecedent: 3, joint: revolute, variable: q4, alpha: -90, d: 120, r: 640, limits: [-180, 180]}
  5: {antecedent: 4, joint: revolute, variable: q5, alpha: 90, limits: [-115, 115]}
  6: {antecedent: 5, joint: revolute, variable: q6, alpha: -90, limits: [-300, 300]}
  E: {antecedent: 6, joint: fixed, r: 100}
tool: {frame: E}
bodies:
  1: {mass: 60, com: [30, -20, -120]}
  2: {mass: 45, com: [250, 10, 60]}
  3: {mass: 38, com: [60, 15, 20]}
  4: {mass: 14, com: [5, -10, -200]}
  5: {mass: 6, com: [0, -20, 10]}
  6: {mass: 3, com: [2, 1, 60]}
joint_stiffness:
  1: {kar: {value: 4.0e+5, identifiable: true}}
  2: {kar: {value: 3.0e+5, identifiable: true}}
  3: {kar: {value: 2.0e+5, identifiable: true}}
  4: {kar: {value: 5.0e+4, identifiable: true}}
  5: {kar: {value: 4.0e+4, identifiable: true}}
  6: {kar: {value: 2.0e+4, identifiable: true}}
";

const UNKNOWN: [&str; 2] = ["--unknown-base", "--unknown-tool"];

/// With a constant held a calibration leaves much, and one of the same robot with a wrist turned round and the last joint negated fits:
/// that is no wrong sign.
#[test]
fn held_constants_are_no_wrong_sign() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &[&UNKNOWN[..], &["--poses", "80", "--errors", "1", "--seed", "3"]].concat());
    let ran = run(at, &["identify", "s", "--hold", "3.d", "--format", "json"]);
    assert_eq!(ran.status, 0, "{}", ran.out);
    assert!(of_code(&json(&ran), "misread").is_empty(), "{}", ran.out);
}

/// Five wrong readings are no noise of the others: not of the intervals of configurations that are held out, nor of the ratio to the
/// stated noise.
#[test]
fn outliers_are_no_noise_after_a_robust_loss() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &[&UNKNOWN[..], &["--poses", "100", "--seed", "5"]].concat());
    let rows = [4, 20, 41, 63, 80];
    spoil(&at.join("s"), |table| {
        let (x, set) = (table.column("x"), table.column("set"));
        for row in rows {
            let value: f64 = table.rows[row][x].parse().expect("a number");
            table.rows[row][x] = (value + 20.0).to_string();
            table.rows[row][set] = "fit".into();
        }
    });
    for loss in ["huber", "cauchy", "tukey"] {
        let ran = run(at, &["identify", "s", "--loss", loss, "--format", "json"]);
        let found = json(&ran);
        let ratio = found["noise_ratio"].as_f64().expect("a ratio");
        assert!((0.8..1.4).contains(&ratio), "{loss}: {ratio}");
        let all = found["configurations"].as_array().expect("a list");
        let within = all.iter().filter(|own| own["within"] == true).count();
        assert!(10 * within >= 8 * all.len() && all.len() > 10, "{loss}: {within} of {}", all.len());
    }
}

/// Bases and tools of sessions are not in a description, and what it does not state has not moved.
#[test]
fn what_the_earlier_description_does_not_state_has_not_moved() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &[&UNKNOWN[..], &["--poses", "80", "--sessions", "a,b", "--seed", "5"]].concat());
    assert_eq!(run(at, &["identify", "s", "--save", "cal.yaml"]).status, 0);
    let found = json(&run(at, &["identify", "s", "--since", "cal.yaml", "--format", "json"]));
    assert_eq!(found["since"]["moved"].as_array().map(Vec::len), Some(0), "{}", found["since"]["moved"]);
    let names = found["since"]["not_compared"].as_array().expect("a list");
    assert!(names.iter().any(|name| name == "base@a.x") && names.iter().any(|name| name == "tool@b.z"), "{names:?}");
    assert!(found["since"]["parameters"].as_array().is_some_and(|all| all.len() > 15));
}

/// A drift of the base is left out of the description: its base is then where it was on the whole, and not where it was at first.
#[test]
fn without_a_drift_the_base_is_where_it_was_on_the_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let drift = ["--conditions", "--effect", "frame-drift@base:x=3e-8", "--poses", "60", "--seed", "4"];
    simulated(at, "universal-ur5", &[&UNKNOWN[..], &drift].concat());
    let ran = run(at, &["diagnose", "s", "--apply", "applied.yaml"]);
    assert!(ran.status == 0 && ran.err.contains("belongs to this session"), "{}{}", ran.out, ran.err);
    assert_eq!(run(at, &["identify", "s", "--save", "identified.yaml"]).status, 0);
    let left = |file: &str| {
        let found = json(&run(at, &["residuals", file, "s", "--format", "json"]));
        found["all"]["rms"].as_f64().unwrap_or_else(|| panic!("{found}"))
    };
    let [applied, identified] = ["applied.yaml", "identified.yaml"].map(left);
    assert!(applied < 1.1 * identified, "{applied} {identified}");
    // What is written leaves of these readings what is said.
    let found = json(&run(at, &["diagnose", "s", "--format", "json"]));
    let said = found["after_all"]["rms_of_robot"].as_f64().unwrap_or_else(|| panic!("{}", found["after_all"]));
    // Of readings that were not fitted, and those of the description were.
    let with_drift = found["after_all"]["rms"].as_f64().unwrap_or_else(|| panic!("{found}"));
    assert!((1.0..1.2).contains(&(said / applied)) && said > 1.15 * with_drift, "{said} {applied} {with_drift}");
    assert!(ran.out.contains(&format!("{said:.4} mm are left of these readings")), "{}", ran.out);
}

/// One reading with a noise of nothing outweighs all others.
#[test]
fn one_reading_without_noise_is_refused() {
    let folder = starter();
    spoil(&folder.path().join("c"), |table| {
        table.names.push("sigma".into());
        for (k, row) in table.rows.iter_mut().enumerate() {
            row.push(if k == 3 { "1e-9" } else { "0.03" }.into());
        }
    });
    refuses(folder.path(), &["identify", "c", "--save", "x.yaml"], "wrong-units", &["measurements.csv:5", "outweigh"]);
    assert!(!folder.path().join("x.yaml").exists());
}

/// A clock that counts down gives what drifts the wrong sign.
#[test]
fn a_clock_that_counts_down_is_doubted() {
    let folder = starter();
    spoil(&folder.path().join("c"), |table| {
        table.names.push("time".into());
        let count = table.rows.len();
        table.rows.iter_mut().enumerate().for_each(|(k, row)| row.push((60 * (count - k)).to_string()));
    });
    doubts(folder.path(), &["identify", "c"], "suspect-readings", &["`time` falls from each reading to the next"]);
}

/// Axes of an inclinometer that are mirrored or exchanged, where the campaign says how it is mounted.
#[test]
fn axes_of_an_inclinometer_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &["--poses", "40", "--observes", "inclination", "--seed", "3"]);
    assert_eq!(run(at, &["identify", "s"]).status, 0);
    let named = |words: &str| {
        let ran = run(at, &["identify", "s", "--format", "json"]);
        let found = of_code(&json(&ran), "misread");
        assert!(ran.status == 2 && !found.is_empty(), "{}", ran.out);
        assert!(found[0]["message"].as_str().is_some_and(|message| message.contains(words)), "{words}: {}", found[0]);
    };
    spoil(&at.join("s"), |table| table.scale(&["gz"], -1.0));
    named("z of the measured directions negated");
    spoil(&at.join("s"), |table| table.scale(&["gz"], -1.0));
    spoil(&at.join("s"), |table| table.swap("gx", "gy"));
    named("x and y of the measured directions exchanged");
}

/// Centres of mass in metres among others in millimetres: of heavy links, and of a payload.
#[test]
fn centres_of_mass_in_metres_are_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(format!("{}/robots/universal-ur5.yaml", env!("CARGO_MANIFEST_DIR")));
    let text = text.expect("a robot");
    let of = |old: &str, new: &str| {
        assert!(text.contains(old), "{old}");
        std::fs::write(folder.path().join("arm.yaml"), text.replace(old, new)).expect("written");
        run(folder.path(), &["check", "arm.yaml"]).err
    };
    assert_eq!(of("robot: ", "robot: "), "");
    let told = of("[-212.5, 0, 113.36]", "[-0.2125, 0, 0.11336]");
    assert!(told.contains("the centre of mass of body `2` lies within 0.241 mm"), "{told}");
    let payload = |com: &str| of("tool: {", &format!("payloads: {{block: {{mass: 8, com: {com}}}}}\ntool: {{"));
    let told = payload("[0, 0, 0.06]");
    assert!(told.contains("the centre of mass of payload `block` lies 0.060 mm"), "{told}");
    assert_eq!(payload("[0, 0, 60]"), "");
}

/// Compliances that are to be calibrated and that the description does not declare.
#[test]
fn compliances_that_are_not_declared_are_told() {
    let folder = starter();
    let path = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("text");
    let with = "calibrate: [geometry, joint-offset, joint-compliance]\n";
    let lines = text.lines().filter(|line| !line.starts_with("calibrate") && !line.starts_with("- "));
    std::fs::write(&path, lines.collect::<Vec<_>>().join("\n") + "\n" + with).expect("written");
    let told = run(Path::new(folder.path()), &["identify", "c"]).err;
    assert!(told.contains("`calibrate:` names `joint-compliance`"), "{told}");
}

/// Poses in a small region, and a zero off by many of its tolerances: what the noise would hide of an arm as described is needed. What is
/// fitted to the noise is not given up for what is not, and `identify` and `diagnose` say the same.
#[test]
fn a_zero_that_is_far_off_in_a_small_region_is_fitted() {
    let folder = starter();
    let at = folder.path();
    let simulate =
        ["simulate", "c/robot.yaml", "--poses", "40", "--markers", "ball", "--share", "0.05", "--seed", "21"];
    let made = run(at, &[&simulate[..], &UNKNOWN[..], &["--set", "2.theta=2", "--into", "s"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let found = json(&run(at, &["identify", "s", "--format", "json"]));
    let rms = found["residuals"]["after"]["rms"].as_f64().expect("a number");
    assert!(rms < 0.08, "{rms} mm");
    assert_eq!(of_code(&found, "moved-far").len(), 1, "{}", found["diagnostics"]);
    let found = json(&run(at, &["diagnose", "s", "--apply", "x.yaml", "--format", "json"]));
    assert!(of_code(&found, "unusable-result").is_empty(), "{}", found["diagnostics"]);
}

/// One joint in gon over a small region: lengths of the arm take it up, by less than is refused.
#[test]
fn one_joint_in_gon_in_a_small_region_is_named() {
    let folder = starter();
    let at = folder.path();
    let simulate = ["simulate", "c/robot.yaml", "--poses", "40", "--markers", "ball", "--share", "0.1", "--seed", "21"];
    let made = run(at, &[&simulate[..], &UNKNOWN[..], &["--into", "s"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    spoil(&at.join("s"), |t: &mut Table| t.scale(&["q5"], 10.0 / 9.0));
    for command in ["identify", "diagnose"] {
        let found = json(&run(at, &[command, "s", "--format", "json"]));
        let said = of_code(&found, "wrong-units");
        assert!(
            said.len() == 1 && said[0]["message"].as_str().is_some_and(|text| text.contains("`q5` alone read as gon")),
            "{}",
            found["diagnostics"]
        );
    }
    let saved = run(at, &["identify", "s", "--save", "x.yaml"]);
    assert!(saved.status == 1 && !at.join("x.yaml").exists(), "{}{}", saved.out, saved.err);
}

/// Masses that gravity pulls the wrong way: springs take the sag up or end at their bounds.
#[test]
fn gravity_that_points_elsewhere_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let heavy = heavy_kr270(at, KR270_MASSES);
    let made = run(
        at,
        &["simulate", &heavy, "--poses", "40", "--markers", "m1", "--unknown-base", "--seed", "3", "--into", "s"],
    );
    assert_eq!(made.status, 0, "{}", made.err);
    let text = std::fs::read_to_string(&heavy).expect("text");
    for wrong in ["gravity: [0, 0, 9.81]", "gravity: [0, 9.81, 0]"] {
        std::fs::write(at.join("wrong.yaml"), text.replace("gravity: [0, 0, -9.81]", wrong)).expect("written");
        let ran = run(at, &["identify", "s", "--robot", "wrong.yaml"]);
        assert!(
            ran.status == 2 && ran.err.contains("with `gravity: [") && ran.err.contains("from that of the description"),
            "{}{}",
            ran.out,
            ran.err
        );
    }
}

/// One visit four times over, joints and values scattered in the last digits: intervals are those of the visits.
#[test]
fn copies_in_other_digits_do_not_narrow_intervals() {
    let folder = starter();
    let at = folder.path();
    let width = |folder: &str| {
        let found = json(&run(at, &["identify", folder, "--format", "json"]));
        let own = found["parameters"].as_array().expect("parameters").iter().find(|one| one["name"] == "2.d");
        own.and_then(|one| one["ci95"].as_f64()).expect("an interval")
    };
    let once = width("c");
    spoil(&at.join("c"), |t: &mut Table| {
        let columns: Vec<usize> = ["q1", "q2", "q3", "q4", "q5", "q6", "x", "y", "z"].map(|name| t.column(name)).into();
        let rows = t.rows.clone();
        for copy in 1..4 {
            for (k, row) in rows.iter().enumerate() {
                let mut row = row.clone();
                row[t.column("pose")] = format!("{}-{copy}", row[t.column("pose")]);
                for (j, &column) in columns.iter().enumerate() {
                    let by = 0.002 * f64::sin((7 * k + 3 * j + 11 * copy) as f64);
                    let value: f64 = row[column].parse().expect("a number");
                    row[column] = (value + by).to_string();
                }
                t.rows.push(row);
            }
        }
    });
    let four = width("c");
    assert!(four > 0.8 * once, "{four} of four copies, {once} of one");
}

/// A marker that is not where the description says, taken as known: an axis turns for it, by less than is refused.
#[test]
fn a_marker_taken_as_known_is_looked_at_where_an_axis_turns_for_it() {
    let folder = starter();
    let at = folder.path();
    let simulate = ["simulate", "c/robot.yaml", "--poses", "60", "--markers", "ball", "--unknown-base", "--seed", "4"];
    let made = run(at, &[&simulate[..], &["--set", "ball.y=2.5", "--into", "s"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let said = run(at, &["identify", "s"]);
    assert!(
        said.out.contains("DOUBTFUL (moved-far)") && said.out.contains("with the tool and the markers estimated"),
        "{}{}",
        said.out,
        said.err
    );
}

/// With five repeats that share an error, intervals of robust losses are as wide as those of squares.
#[test]
fn intervals_of_robust_losses_count_errors_that_readings_share() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(
        at,
        "universal-ur5",
        &["--unknown-base", "--poses", "40", "--noise", "0.01", "--repeats", "5", "--seed", "7"],
    );
    spoil(&at.join("s"), |table| {
        let (pose, columns) = (table.column("pose"), ["x", "y", "z"].map(|name| table.column(name)));
        let mut shared = std::collections::HashMap::new();
        for row in &mut table.rows {
            let count = shared.len() as f64;
            // A fixed sequence that looks like noise of 0.05 mm.
            let own = *shared
                .entry(row[pose].clone())
                .or_insert_with(|| [1.0, 2.0, 3.0].map(|c: f64| 0.07 * (12.9898 * (count + c) + 78.233 * c).sin()));
            for (column, by) in columns.into_iter().zip(own) {
                let value: f64 = row[column].parse().expect("a number");
                row[column] = (value + by).to_string();
            }
        }
    });
    let half = |loss: &str| {
        let found = json(&run(at, &["identify", "s", "--loss", loss, "--format", "json"]));
        let all = found["parameters"].as_array().expect("a list").clone();
        all.iter().filter_map(|own| own["ci95"].as_f64()).filter(|half| *half > 0.0).map(f64::ln).collect::<Vec<f64>>()
    };
    let mean = |of: Vec<f64>| of.iter().sum::<f64>() / of.len() as f64;
    let squares = mean(half("squares"));
    for loss in ["huber", "tukey"] {
        let ratio = (mean(half(loss)) - squares).exp();
        assert!((0.85..1.3).contains(&ratio), "{loss}: {ratio}");
    }
}

/// A variable with the name of a parameter of the base, or of a column.
#[test]
fn variables_with_names_of_other_things_are_refused() {
    let folder = starter();
    let at = folder.path();
    let path = at.join("c/robot.yaml");
    let text = std::fs::read_to_string(&path).expect("text");
    for (wrong, other) in [("base.x", "call it `qbase_x`"), ("fx", "call it `qfx`")] {
        std::fs::write(&path, text.replace("variable: q6", &format!("variable: {wrong}"))).expect("written");
        let ran = run(at, &["check", "c/robot.yaml"]);
        assert!(ran.status == 2 && ran.err.contains(other), "{}{}", ran.out, ran.err);
    }
}

/// A tenth of the orientations wrong by thirty times their noise: plain squares spread that over all, a robust fit shows which.
#[test]
fn orientations_that_hide_each_other_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    simulated(at, "universal-ur5", &[&UNKNOWN[..], &["--poses", "60", "--observes", "pose", "--seed", "31"]].concat());
    spoil(&at.join("s"), |t: &mut Table| {
        let column = t.column("rz");
        for row in [3, 11, 20, 34, 43, 55] {
            let value: f64 = t.rows[row][column].parse().expect("deg");
            t.rows[row][column] = (value + 0.1).to_string();
        }
    });
    doubts(at, &["identify", "s"], "outlying-readings", &["orientations of 6 of 60 readings"]);
}

/// Only how a horizontal load acts tells the turn of the base about the vertical from that of the first joint: a fit that creeps along such
/// constants is made again without what the noise hides.
#[test]
fn a_fit_that_creeps_along_what_loads_hardly_show_is_made_without_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("arm.yaml"), LOADED).expect("written");
    let made = ["simulate", "arm.yaml", "--poses", "60", "--noise", "0.03", "--errors", "0", "--into", "c"];
    let loaded = ["--wrench=0,0,0", "--wrench=500,0,0", "--set", "base.x=1200,base.y=-300,base.z=100,base.rz=40"];
    let ran = run(at, &[&made[..], &loaded].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let path = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let open = text.replace("  base: false", "  base: true").replace("  tool: false", "  tool: true");
    assert_ne!(open, text);
    std::fs::write(&path, open).expect("written");
    let ran = run(at, &["identify", "c", "--format", "json"]);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
    let found = json(&ran);
    assert_eq!(found["converged"], true);
    let left = found["residuals"]["check_after"]["rms"].as_f64().expect("a figure");
    assert!((0.04..0.065).contains(&left), "{left} mm where the noise is 0.052");
}

/// Orientations that are wrong where positions are right are told as such, in degrees.
#[test]
fn wrong_orientations_are_told_in_degrees() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made =
        ["--poses", "160", "--observes", "pose", "--noise", "0.05", "--orientation-noise", "0.005", "--errors", "0"];
    simulated(at, "universal-ur10", &[&made[..], &["--seed", "6"]].concat());
    spoil(&at.join("s"), |table| {
        let ry = table.column("ry");
        for row in [9, 30, 51, 72, 93, 114, 135, 156] {
            let value: f64 = table.rows[row][ry].parse().expect("a number");
            table.rows[row][ry] = (value + 0.5).to_string();
        }
    });
    for command in ["identify", "diagnose"] {
        let found = json(&run(at, &[command, "s", "--format", "json"]));
        let told = of_code(&found, "outlying-readings");
        let message =
            told.first().and_then(|one| one["message"].as_str()).unwrap_or_else(|| panic!("{command}: {found}"));
        assert!(
            message.contains("orientations of 8 of 160 readings") && message.contains(" deg)"),
            "{command}: {message}"
        );
    }
}

/// A noise that is stated a hundred times too great: what `diagnose` writes leaves what it says.
#[test]
fn a_noise_far_too_great_hides_nothing_from_what_is_applied() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made =
        ["--poses", "60", "--observes", "pose", "--noise", "0.05", "--orientation-noise", "0.01", "--errors", "1"];
    simulated(at, "universal-ur10", &[&UNKNOWN[..], &made, &["--seed", "5"]].concat());
    let path = at.join("s/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let great = text.replace("sigma: 0.05", "sigma: 5").replace("orientation: 0.01", "orientation: 1");
    assert_ne!(great, text);
    std::fs::write(&path, great).expect("written");
    let ran = run(at, &["diagnose", "s", "--apply", "a.yaml", "--format", "json"]);
    let found = json(&ran);
    assert!(!of_code(&found, "noise-unlike-stated").is_empty(), "{}", ran.out);
    let said = found["gap"]["rms"].as_f64().expect("a figure");
    let ran = run(at, &["residuals", "a.yaml", "s", "--format", "json"]);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
    let left = json(&ran)["all"]["rms"].as_f64().unwrap_or_else(|| panic!("{}", ran.out));
    assert!(left < 1.5 * said && said < 0.2, "{left} mm where {said} mm are said");
}
