//! What has moved since an earlier description, and registration alone: against truths that are known.

use elastogeo::description::raw::RawRobot;
use elastogeo::effects::Catalogue;
use elastogeo::estimation::{Calibration, Settings, calibrate, changes, comparable, with_uncertainties};
use elastogeo::kinematics::Geometry;
use elastogeo::model::{Model, build, with_values};
use elastogeo::observation::POSITION;
use elastogeo::simulation::{Plan, draw_configurations, generator, simulate};
use serde_json::Value;

use crate::cli::{PLANAR, run};
use crate::support::printed_json;

fn compiled(raw: &RawRobot) -> Model {
    let (robot, diagnostics) = elastogeo::description::resolve::resolve(raw, &|_| None);
    build(&robot.unwrap_or_else(|| panic!("{diagnostics:#?}")), Catalogue::standard()).expect("a model")
}

/// A description calibrated on readings of a robot with the nominal values of `truth`.
fn calibrated(raw: &RawRobot, truth: &Model, seed: u64) -> (Model, Calibration) {
    let model = compiled(raw);
    let values = truth.registry.nominal();
    let mut random = generator(seed);
    let geometry = Geometry::new(truth, &values).expect("assembled");
    let plan = Plan {
        configurations: draw_configurations(&geometry, 20, 0.8, &mut random).expect("drawn"),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSITION,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let campaign = simulate(truth, &values, &plan, &mut random).expect("simulated");
    let held_out = vec![false; campaign.readings.len()];
    let settings = comparable(raw, &model, &campaign, Settings::default()).expect("candidates");
    let found = calibrate(&model, &campaign, &held_out, &settings, &mut |_| {}).expect("calibrated");
    (model, found)
}

/// Two campaigns of the same robot: something is said to have moved in at most 5 % of such pairs. Without the earlier
/// uncertainty it is said far more often, so that the test can fail.
#[test]
fn what_stands_still_is_seldom_said_to_have_moved() {
    let raw: RawRobot = serde_yaml::from_str(PLANAR).expect("readable");
    let truth = compiled(&raw);
    let pairs = 60;
    let mut named = [0, 0];
    let (mut covered, mut compared) = (0, 0);
    for seed in 0..pairs {
        let (model, found) = calibrated(&raw, &truth, 2 * seed);
        let exact = with_values(&raw, &model, &found.values);
        let first = with_uncertainties(&exact, &model, &found);
        let (model, found) = calibrated(&first, &truth, 2 * seed + 1);
        for (raw, named) in [&first, &exact].into_iter().zip(&mut named) {
            let all = changes(raw, &model, &found);
            assert!(all.len() > 3 && all.iter().all(|change| change.both == std::ptr::eq(raw, &first)), "{all:?}");
            if std::ptr::eq(raw, &first) {
                // The truth of both is the same: 0 lies within 95 % of the intervals of the differences.
                covered += all.iter().filter(|change| (change.now - change.before).abs() <= change.ci95).count();
                compared += all.len();
            }
            *named += usize::from(all.iter().any(elastogeo::estimation::Change::moved));
        }
    }
    // Of 60 pairs 3 are expected; 9 or more have a probability of 0.4 %.
    assert!(named[0] <= 8, "{named:?}");
    assert!(named[1] > 15, "{named:?}");
    let share = covered as f64 / compared as f64;
    assert!((0.93..0.98).contains(&share), "{share} of {compared}");
}

/// A length that grew is named, with what it grew by; what it can be confounded with is not.
#[test]
fn what_has_moved_is_named_with_how_far() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    std::fs::write(path.join("arm.yaml"), PLANAR).expect("written");
    let simulated = |into: &str, seed: &str, set: &str| {
        let made =
            ["simulate", "arm.yaml", "--poses", "40", "--errors", "0", "--into", into, "--seed", seed, "--set", set];
        assert_eq!(run(path, &made).status, 0);
    };
    simulated("monday", "1", "2.d=0.3");
    simulated("friday", "2", "2.d=0.55,2.theta=0.02");
    let first = printed_json(path, &["identify", "monday", "--save", "monday.yaml"]);
    let saved = std::fs::read_to_string(path.join("monday.yaml")).expect("a file");
    assert!(saved.contains("uncertainties:"), "{saved}");
    let found = printed_json(path, &["identify", "friday", "--since", "monday.yaml"]);
    let since = &found["since"];
    assert_eq!(since["moved"], serde_json::json!(["2.d", "2.theta"]), "{since:#}");
    let of = |list: &Value, name: &str| -> Value {
        list.as_array().expect("a list").iter().find(|p| p["name"] == name).expect("the parameter").clone()
    };
    for (name, moved) in [("2.d", 0.25), ("2.theta", 0.02)] {
        let change = of(&since["parameters"], name);
        let number = |key: &str| change[key].as_f64().expect("a number");
        assert!((number("difference") - moved).abs() < 4.0 * number("sigma"), "{change}");
        assert!((number("z") - number("difference") / number("sigma")).abs() < 1e-9 * number("z").abs());
        // Both campaigns are in its deviation: intervals are those of Student's t with more than 60 degrees of freedom.
        let width = |found: &Value| of(&found["parameters"], name)["ci95"].as_f64().expect("a number") / 1.98;
        let expected = width(&first).hypot(width(&found));
        assert!((number("sigma") / expected - 1.0).abs() < 0.02, "{change} {expected}");
    }
    // The description as drawn states no uncertainties, and that is said.
    let ran = run(path, &["identify", "friday", "--since", "arm.yaml"]);
    assert!(ran.status == 0 && ran.err.contains("states no uncertainty of"), "{}", ran.err);
    assert!(ran.out.contains("moved since arm.yaml: "), "{}", ran.out);
    let ran = run(path, &["identify", "friday", "--since", "monday.yaml", "--what", "fuzzy"]);
    assert_eq!(ran.status, 2, "{}", ran.err);
}

/// `diagnose` fits again what a description states, and says which of it moved.
#[test]
fn what_has_moved_is_named_beside_a_diagnosis() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    assert_eq!(run(path, &["init", "c"]).status, 0);
    let simulated = |into: &str, more: &[&str]| {
        let made = [
            "simulate",
            "c/robot.yaml",
            "--poses",
            "60",
            "--markers",
            "ball",
            "--unknown-base",
            "--unknown-tool",
            "--errors",
            "0",
        ];
        assert_eq!(run(path, &[&made[..], more, &["--into", into]].concat()).status, 0);
    };
    simulated("monday", &["--seed", "1"]);
    simulated("friday", &["--seed", "2", "--set", "3.d=0.5"]);
    assert_eq!(run(path, &["identify", "monday", "--save", "monday.yaml"]).status, 0);
    let found = printed_json(path, &["diagnose", "friday", "--since", "monday.yaml"]);
    // Base and ball are drawn anew.
    let names = found["since"]["moved"].as_array().expect("names").iter().filter_map(Value::as_str);
    let of_robot = names.filter(|name| !name.starts_with("base.") && !name.starts_with("ball."));
    assert_eq!(of_robot.collect::<Vec<&str>>(), ["3.d"], "{:#}", found["since"]);
    let ran = run(path, &["diagnose", "friday", "--since", "monday.yaml"]);
    assert!(ran.out.contains("moved since monday.yaml: ") && ran.out.contains("3.d"), "{}", ran.out);
}

/// Base and tool alone, from readings without errors but for gross ones: the truth is found, saved and read back.
#[test]
fn a_robot_is_registered_in_spite_of_outliers() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let made = [
        "simulate",
        "universal-ur5",
        "--poses",
        "30",
        "--errors",
        "0",
        "--noise",
        "0.01",
        "--unknown-base",
        "--unknown-tool",
        "--into",
        "c",
        "--check",
        "0",
    ];
    assert_eq!(run(path, &made).status, 0);
    let truth: Value =
        serde_json::from_str(&std::fs::read_to_string(path.join("c/truth.json")).expect("a file")).expect("JSON");
    let file = path.join("c/measurements.csv");
    let text = std::fs::read_to_string(&file).expect("a file");
    let header: Vec<&str> = text.lines().next().expect("a header").split(',').collect();
    let x = header.iter().position(|name| *name == "x").expect("x");
    let spoilt = text.lines().enumerate().map(|(row, line)| {
        let mut cells: Vec<String> = line.split(',').map(ToString::to_string).collect();
        if [4, 11, 23].contains(&row) {
            cells[x] = format!("{}", cells[x].parse::<f64>().expect("a number") + 40.0);
        }
        cells.join(",")
    });
    let spoilt: Vec<String> = spoilt.collect();
    std::fs::write(&file, spoilt.join("\n")).expect("written");
    let off = |robust: &[&str]| -> f64 {
        let found = printed_json(path, &[&["register", "c", "--check", "0"], robust].concat());
        let parameters = found["parameters"].as_array().expect("a list");
        assert_eq!(parameters.len(), 9, "{parameters:?}");
        let off = |p: &Value| {
            let given = &truth["parameters"][p["name"].as_str().expect("a name")]["true"];
            let (value, size) =
                (p["value"].as_f64().expect("a number"), if p["unit"] == "mm" { 1e-3 } else { 1f64.to_radians() });
            (value * size - given.as_f64().expect("a number")).abs()
        };
        parameters.iter().map(off).fold(0.0, f64::max)
    };
    assert!(off(&["--loss", "squares"]) > 5e-4);
    // Without a flag readings that are far off count little too.
    assert!(off(&[]) < 1e-4, "{}", off(&[]));
    let refused = run(path, &["register", "c", "--check", "0", "--loss", "squares", "--save", "registered.yaml"]);
    assert!(refused.status == 1 && !path.join("registered.yaml").exists(), "{}", refused.out);
    let robust = ["--loss", "tukey", "--save", "registered.yaml"];
    assert!(off(&robust) < 5e-5, "{}", off(&robust));
    // What is saved predicts the good readings without any fit.
    let found = printed_json(path, &["residuals", "registered.yaml", "c"]);
    let errors = found["readings"].as_array().expect("a list").iter().map(|reading| {
        reading["error"].as_array().expect("xyz").iter().map(|v| v.as_f64().expect("mm").powi(2)).sum::<f64>().sqrt()
    });
    assert_eq!(errors.filter(|error| *error < 0.1).count(), 27);
    let nothing = run(path, &["register", "kr270-no-compensator"]);
    assert!(nothing.status == 2 && nothing.err.contains("do not determine the robot's base"), "{}", nothing.err);
}
