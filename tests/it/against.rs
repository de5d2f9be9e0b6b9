//! The identified parameters against another set, on the same held-out readings: against what other commands say of each set alone.

use std::path::Path;

use serde_json::Value;

use crate::cli::{PLANAR, run};
use crate::support::{number, printed_json};

/// Adds a line to the campaign file of a folder.
fn declare(folder: &Path, campaign: &str, line: &str) {
    let path = folder.join(campaign).join("campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("a file");
    std::fs::write(path, text + line).expect("written");
}

/// KR-270 paper, Tables IX and XIII, simulated: a set without the gravity compensator, found on another plan of experiments, and
/// one with it, on the same validation readings. For deflections each alone is what `residuals` and `identify` say.
#[test]
fn a_set_without_the_compensator_against_one_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let made = "simulate kuka-kr270 --observes deflection --poses 16 --markers m1,m2,m3 --wrench 0,0,-2500,0,0,0 --noise 0.01 \
        --errors 0 --check 0.4";
    for own in ["--seed 1 --range q2=-30:-1 --into before", "--seed 2 --into now"] {
        let arguments: Vec<&str> = made.split_whitespace().chain(own.split_whitespace()).collect();
        assert_eq!(run(path, &arguments).status, 0);
    }
    declare(path, "before", "\nwithout: [compensator]\n");
    printed_json(path, &["identify", "before", "--save", "before.yaml"]);
    let found = printed_json(path, &["identify", "now", "--against", "before.yaml"]);
    let against = &found["against"];
    assert_eq!((&against["judged_by"], &against["before_is"]), (&"check".into(), &"measured".into()));
    // Each set alone.
    let alone = printed_json(path, &["residuals", "before.yaml", "now"]);
    for figure in ["mean", "rms", "max"] {
        let [other, identified] = [&against["other"][figure], &against["identified"][figure]].map(number);
        assert!((other - number(&alone["check"][figure])).abs() < 1e-9, "{figure}: {against:#}");
        assert!((identified - number(&found["residuals"]["check_after"][figure])).abs() < 1e-9, "{figure}");
        assert!(identified < other, "{figure}: {identified} {other}");
    }
    let rms = |set: &str| number(&against[set]["rms"]);
    assert!(rms("before") > 10.0 * rms("other") && rms("other") > 1.5 * rms("identified"), "{against:#}");
    // The three directions and the three markers make up the whole.
    for set in ["before", "other", "identified"] {
        let directions = against[set]["directions"].as_array().expect("a list");
        let sum: f64 = directions.iter().map(|axis| number(&axis["rms"]).powi(2)).sum();
        assert!((sum.sqrt() - rms(set)).abs() < 1e-9, "{set}: {directions:?}");
        let parts = against[set]["parts"].as_array().expect("a list");
        let mean = parts.iter().map(|part| number(&part["rms"]).powi(2)).sum::<f64>() / 3.0;
        assert!(parts.len() == 3 && (mean.sqrt() - rms(set)).abs() < 1e-9, "{parts:?}");
    }
    let closer = &against["closer"];
    assert_eq!([&closer["configurations"], &closer["identified_closer"]], [6, 6], "{closer}");
    assert!((number(&closer["chance"]) - 2.0 / 64.0).abs() < 1e-12, "{closer}");
    // What makes up for the compensator differs; the compensator itself is not there.
    let parameters = against["parameters"].as_array().expect("a list");
    let of = |name: &str| parameters.iter().find(|p| p["name"] == name).expect("the parameter");
    assert_eq!(of("joint2.kar")["differs"], true, "{against:#}");
    for p in parameters {
        let [other, identified, difference] = ["other", "identified", "difference"].map(|key| number(&p[key]));
        assert!((identified - other - difference).abs() <= 1e-12 * identified.abs(), "{p}");
        assert!(number(&p["ci95"]) > 0.0 && p["both"] == true, "{p}");
    }
    assert_eq!(against["alone"], serde_json::json!(["compensator.stiffness"]));
    let ran = run(path, &["identify", "now", "--against", "before.yaml"]);
    assert!(ran.status == 0 && ran.out.contains("not in before.yaml: compensator.stiffness"), "{}", ran.out);
}

/// Where base and tool are unknown both are fitted anew for each set, as `register` does with the other alone.
#[test]
fn base_and_tool_are_fitted_anew_for_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let made = "simulate universal-ur5 --poses 40 --errors 0 --noise 0.02 --unknown-base --unknown-tool --check 0.25 \
        --set 3.d=0.4,3.theta=0.05";
    for own in ["--seed 1 --into monday", "--seed 2 --into friday"] {
        let arguments: Vec<&str> = made.split_whitespace().chain(own.split_whitespace()).collect();
        assert_eq!(run(path, &arguments).status, 0);
    }
    printed_json(path, &["identify", "monday", "--save", "monday.yaml"]);
    for other in ["monday.yaml", "universal-ur5"] {
        let found = printed_json(path, &["identify", "friday", "--against", other]);
        let against = &found["against"];
        assert_eq!(against["before_is"], "registration");
        let registered = printed_json(path, &["register", "friday", "--robot", other]);
        for figure in ["mean", "rms", "max"] {
            let [theirs, own] = [&against["other"][figure], &against["identified"][figure]].map(number);
            let alone = number(&registered["residuals"]["check_after"][figure]);
            assert!((theirs / alone - 1.0).abs() < 1e-3, "{other} {figure}: {theirs} {alone}");
            // Of the identified set base and tool were fitted with it: anew they stay where they are.
            let fitted = number(&found["residuals"]["check_after"][figure]);
            assert!((own / fitted - 1.0).abs() < 0.02, "{figure}: {own} {fitted}");
        }
        let names: Vec<&str> =
            against["parameters"].as_array().expect("a list").iter().filter_map(|p| p["name"].as_str()).collect();
        assert!(names.contains(&"3.d") && !names.iter().any(|name| name.starts_with("base")), "{names:?}");
        let differs = against["parameters"].as_array().expect("a list").iter().filter(|p| p["differs"] == true).count();
        let rms = |set: &str| number(&against[set]["rms"]);
        match other {
            // Two calibrations of one robot.
            "monday.yaml" => assert!(differs == 0 && rms("other") < 1.5 * rms("identified"), "{against:#}"),
            _ => assert!(differs > 0 && rms("other") > 5.0 * rms("identified"), "{against:#}"),
        }
    }
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    std::fs::write(path.join("arm.yaml"), PLANAR).expect("written");
    assert_eq!(run(path, &["simulate", "arm.yaml", "--poses", "20", "--into", "c"]).status, 0);
    let cases: &[(&[&str], &str)] = &[
        (&["--against", "none.yaml"], "none.yaml"),
        (&["--against", "universal-ur5"], "q3"),
        (&["--against", "arm.yaml", "--what", "fuzzy"], "--against, and rules are identified"),
        (&["--against", "arm.yaml", "--compare"], "cannot be used with"),
    ];
    for (flags, expected) in cases {
        let ran = run(path, &[&["identify", "c"], *flags].concat());
        assert!(ran.status == 2 && ran.err.contains(expected) && ran.out.is_empty(), "{flags:?}: {}", ran.err);
    }
    let ran = run(path, &["identify", "c", "--against", "arm.yaml"]);
    assert!(ran.status == 0 && ran.out.contains("against arm.yaml"), "{}{}", ran.out, ran.err);
}

/// The report shows what `identify --against` prints; another robot is refused in one sentence.
#[test]
fn a_report_shows_both_sets() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let report = ["report", "kr270-simulated", "--against", "kuka-kr270", "--output", "r.html", "--json", "r.json"];
    let ran = run(path, &report);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let page = std::fs::read_to_string(path.join("r.html")).expect("written");
    assert!(page.contains("id=\"against\"") && page.contains("/identify/against/identified/rms"), "no section");
    let shown: Value =
        serde_json::from_str(&std::fs::read_to_string(path.join("r.json")).expect("written")).expect("JSON");
    let identify = ["identify", "kr270-simulated", "--against", "kuka-kr270", "--format", "json"];
    let printed: Value = serde_json::from_str(&run(path, &identify).out).expect("JSON");
    assert_eq!(shown["identify"]["against"], printed["against"]);
    for command in ["identify", "report"] {
        let ran = run(path, &[command, "kr270-simulated", "--against", "universal-ur5"]);
        assert!(ran.status != 0 && ran.err.matches("error:").count() == 1, "{}", ran.err);
    }
    let ran = run(path, &["identify", "kr270-simulated", "--against", "kuka-ir663"]);
    assert!(ran.status == 2 && ran.err.contains("its variables are q1, stroke2"), "{}", ran.err);
}
