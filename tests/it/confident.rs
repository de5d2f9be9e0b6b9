//! Inputs of which a green figure was printed, found by an audit with some eighty spoiled campaigns: none of them is now.

use std::path::Path;

use super::cli::run;
use super::plausibility::{doubts, json, of_code, spoil};

/// A campaign simulated into `s`.
fn simulated(folder: &Path, arguments: &[&str]) {
    let ran = run(folder, &[&["simulate"], arguments, &["--into", "s", "-q"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
}

/// A folder with the arm and the campaign of the page on payload runs.
fn payload_runs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let book = include_str!("../../docs/payload-runs.md");
    for file in ["soft.yaml", "payloads.yaml"] {
        let after = book.split_once(&format!("file={file}")).expect("a block").1;
        let text = after.split_once('\n').expect("lines").1.split_once("```").expect("an end").0;
        std::fs::write(folder.path().join(file), text).expect("written");
    }
    folder
}

/// Changes a file by one replacement.
fn replaced(path: &Path, what: &str, by: &str) {
    let text = std::fs::read_to_string(path).expect("text");
    assert!(text.contains(what), "{what}: {text}");
    std::fs::write(path, text.replacen(what, by, 1)).expect("written");
}

/// A scale that is estimated takes any unit up: readings in m and in inches, and what is 3 % too short, are refused all the same; 50 ppm
/// are a scale.
#[test]
fn an_estimated_scale_hides_no_unit() {
    for (factor, words) in [(1e-3, "times 1000"), (1.0 / 25.4, "inches"), (0.97, "`scale` came out at -3.")] {
        let folder = tempfile::tempdir().expect("a folder");
        simulated(folder.path(), &["universal-ur5", "--poses", "45", "--seed", "51", "--unknown-base"]);
        let campaign = folder.path().join("s");
        replaced(&campaign.join("campaign.yaml"), "estimate:", "estimate:\n  scale: true");
        let sound = run(folder.path(), &["identify", "s", "--format", "json"]);
        assert_eq!((sound.status, of_code(&json(&sound), "wrong-units").len()), (0, 0), "{}", sound.err);
        spoil(&campaign, |table| table.scale(&["x", "y", "z"], factor));
        for command in ["identify", "diagnose"] {
            let flag = if command == "identify" { "--save" } else { "--apply" };
            let ran = run(folder.path(), &[command, "s", flag, "o.yaml"]);
            assert_eq!(ran.status, 2, "{command} {factor}: {}{}", ran.out, ran.err);
            assert!(ran.err.contains(words), "{command} {factor}: {}", ran.err);
            assert!(!folder.path().join("o.yaml").exists());
        }
    }
}

/// One file under two stations with a base each: copies, of which each base is known as well as by its own readings.
#[test]
fn copies_under_two_stations_have_finite_intervals() {
    let folder = tempfile::tempdir().expect("a folder");
    simulated(folder.path(), &["universal-ur5", "--poses", "40", "--seed", "3", "--unknown-base"]);
    let campaign = folder.path().join("s/campaign.yaml");
    replaced(&campaign, "base: true", "base: per-station");
    let file = "measurements: measurements.csv";
    let text = std::fs::read_to_string(&campaign).expect("text");
    let twice = "measurements:\n- {file: measurements.csv, station: front}\n- {file: measurements.csv, station: back}";
    std::fs::write(&campaign, text.replace(file, twice)).expect("written");
    let found = doubts(folder.path(), &["identify", "s"], "suspect-readings", &["copies"]);
    assert!(found["predicted_error"].is_object(), "{}", found["predicted_error"]);
    let parameters = found["parameters"].as_array().expect("a list");
    let of_bases: Vec<_> =
        parameters.iter().filter(|own| own["name"].as_str().is_some_and(|name| name.starts_with("base@"))).collect();
    assert_eq!(of_bases.len(), 12, "{parameters:?}");
    assert!(of_bases.iter().all(|own| own["ci95"].is_f64()), "{of_bases:?}");
}

/// Rotations of four readings that are 5 deg off: told by `identify`, which does not write what it fitted to them, and by `diagnose`, which
/// sets them aside.
#[test]
fn rotations_far_off_are_told_by_all_commands() {
    let folder = tempfile::tempdir().expect("a folder");
    let robot = ["universal-ur5", "--poses", "60", "--observes", "pose", "--seed", "62", "--unknown-base"];
    simulated(folder.path(), &robot);
    spoil(&folder.path().join("s"), |table| {
        let column = table.column("rx");
        for row in [3, 17, 40, 41] {
            let value: f64 = table.rows[row][column].parse().expect("a number");
            table.rows[row][column] = (value + 5.0).to_string();
        }
    });
    for command in ["identify", "diagnose", "report"] {
        let ran = run(folder.path(), &[command, "s", "--format", "json"]);
        let told = of_code(&json(&ran), "outlying-readings");
        let message = told.first().and_then(|told| told["message"].as_str()).unwrap_or_default();
        assert!(message.contains("of 60 readings are far off"), "{command}: {}", ran.err);
    }
    let ran = run(folder.path(), &["identify", "s", "--save", "o.yaml"]);
    assert_eq!(ran.status, 1, "{}{}", ran.out, ran.err);
    assert!(!folder.path().join("o.yaml").exists());
}

/// Deflections that follow other loads than the columns say: the error is a hundred times the stated noise, and no cause takes it away.
#[test]
fn deflections_under_exchanged_forces_are_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let loads = ["--wrench", "0,0,-1500", "--wrench", "500,300,-500", "--elastic-errors", "1"];
    let robot = [
        "palletiser",
        "--poses",
        "40",
        "--markers",
        "ball",
        "--observes",
        "deflection",
        "--noise",
        "0.02",
        "--seed",
        "97",
    ];
    simulated(folder.path(), &[&robot[..], &loads].concat());
    spoil(&folder.path().join("s"), |table| table.swap("fx", "fz"));
    doubts(folder.path(), &["diagnose", "s"], "noise-unlike-stated", &["times the stated noise"]);
}

/// A payload of 500 kg for 5 on an arm that weighs 12 kg is told by all commands, and what is fitted to it is not written.
#[test]
fn a_payload_heavier_than_the_arm_is_told() {
    let folder = payload_runs();
    simulated(folder.path(), &["payloads.yaml", "--poses", "40", "--seed", "4", "--elastic-errors", "1"]);
    let campaign = folder.path().join("s/campaign.yaml");
    let text = std::fs::read_to_string(&campaign).expect("text");
    let heavy: Vec<String> = text
        .lines()
        .map(|line| match line.trim_start().strip_prefix("mass: ") {
            Some(mass) if mass.parse::<f64>().is_ok() => {
                line.replace(mass, &format!("{}", 100.0 * mass.parse::<f64>().expect("a number")))
            }
            _ => line.to_string(),
        })
        .collect();
    assert!(heavy.join("\n") != text.trim_end(), "{text}");
    std::fs::write(&campaign, heavy.join("\n")).expect("written");
    let ran = run(folder.path(), &["check", "s"]);
    assert!(ran.err.contains("more than all bodies of the robot together"), "{}", ran.err);
    let ran = run(folder.path(), &["identify", "s", "--what", "geometric,elastic", "--save", "o.yaml"]);
    assert_ne!(ran.status, 0, "{}{}", ran.out, ran.err);
    assert!(ran.err.contains("more than all bodies of the robot together"), "{}", ran.err);
    assert!(!folder.path().join("o.yaml").exists());
}

/// One length that is off by more than its tolerances is named by itself: the others are as declared, and no common factor is told.
#[test]
fn one_wrong_length_is_no_common_factor() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "arm"]).status, 0);
    let robot = folder.path().join("arm/robot.yaml");
    simulated(folder.path(), &["arm/robot.yaml", "--poses", "60", "--seed", "7"]);
    replaced(&robot, "variable: q3, d: 600", "variable: q3, d: 560");
    let ran = run(folder.path(), &["identify", "s"]);
    assert!(ran.err.contains("`3.d` 560 -> "), "{}", ran.err);
    assert!(!ran.err.contains("times the declared ones"), "{}", ran.err);
}

/// Gravity that is read upside down is half a turn off, in any rows: the residual is the angle and not its sine.
#[test]
fn reversed_inclinations_are_seen() {
    let folder = tempfile::tempdir().expect("a folder");
    let arm =
        ["universal-ur5", "--poses", "40", "--observes", "inclination", "--orientation-noise", "0.005", "--seed", "2"];
    simulated(folder.path(), &arm);
    let sound = run(folder.path(), &["identify", "s"]);
    assert_eq!(sound.status, 0, "{}{}", sound.out, sound.err);
    spoil(&folder.path().join("s"), |table| {
        let columns = ["gx", "gy", "gz"].map(|name| table.column(name));
        for row in table.rows.iter_mut().step_by(2) {
            for column in columns {
                row[column] = (-row[column].parse::<f64>().expect("a number")).to_string();
            }
        }
    });
    let ran = run(folder.path(), &["identify", "s", "--save", "o.yaml"]);
    assert_ne!(ran.status, 0, "{}{}", ran.out, ran.err);
    assert!(!folder.path().join("o.yaml").exists());
}

/// What an entry does not say of instrument and units the campaign says, in its own units.
#[test]
fn entries_state_what_differs_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    simulated(
        folder.path(),
        &["universal-ur5", "--poses", "40", "--observes", "pose", "--seed", "9", "--noise", "0.05"],
    );
    let campaign = folder.path().join("s/campaign.yaml");
    let text = std::fs::read_to_string(&campaign).expect("text");
    let left = |text: &str| {
        std::fs::write(&campaign, text).expect("written");
        let found = json(&run(folder.path(), &["identify", "s", "--format", "json"]));
        (found["residuals"]["after"]["rms"].as_f64(), found["noise_ratio"].as_f64())
    };
    let whole = left(&text);
    assert!(whole.0.is_some(), "{whole:?}");
    let entry = |more: &str| {
        text.replace("measurements: measurements.csv", &format!("measurements:\n- {{file: measurements.csv, {more}}}"))
    };
    // Named again, or left to the campaign: the same.
    assert_eq!(left(&entry("units: {angle: deg}")), whole);
    assert_eq!(left(&entry("instrument: {sigma: 0.05}")), whole);
}

/// Payloads of the robot are known by their names in every campaign of it; a campaign's own of the same name replaces one.
#[test]
fn payloads_of_a_robot_are_its_campaigns() {
    let folder = payload_runs();
    simulated(folder.path(), &["payloads.yaml", "--poses", "40", "--seed", "4"]);
    let left = || {
        let ran = run(folder.path(), &["identify", "s", "--what", "geometric,elastic", "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        json(&ran)["residuals"]["after"]["rms"].as_f64().expect("a number")
    };
    let of_campaign = left();
    let campaign = folder.path().join("s/campaign.yaml");
    let text = std::fs::read_to_string(&campaign).expect("text");
    let from = text.find("payloads:").expect("payloads");
    let rest = &text[from + 9..];
    let until = rest.find("\n").map(|first| {
        let lines = rest[first + 1..].lines().take_while(|line| line.starts_with([' ', '-']));
        first + 1 + lines.map(|line| line.len() + 1).sum::<usize>()
    });
    let block = &text[from..from + 9 + until.expect("a block")];
    let robot = std::fs::read_to_string(folder.path().join("soft.yaml")).expect("text");
    std::fs::write(folder.path().join("soft.yaml"), format!("{robot}\n{block}")).expect("written");
    std::fs::write(&campaign, text.replace(block, "")).expect("written");
    assert!((left() - of_campaign).abs() < 1e-12, "{} {of_campaign}", left());
    let wrong = format!("{robot}\npayloads: {{block: {{mass: 5, frame: nowhere}}}}\n");
    std::fs::write(folder.path().join("wrong.yaml"), wrong).expect("written");
    let ran = run(folder.path(), &["check", "wrong.yaml"]);
    assert!(ran.status == 2 && ran.err.contains("unknown frame `nowhere`"), "{}", ran.err);
}

/// The angle at which a joint is coupled to others is calibrated as the zero of an encoder is.
#[test]
fn the_zero_of_a_coupled_joint_is_calibrated() {
    let folder = super::joints::coupled();
    simulated(
        folder.path(),
        &["coupled.yaml", "--poses", "50", "--noise", "0.02", "--errors", "0", "--set", "3.theta=0.3", "--seed", "3"],
    );
    let found = json(&run(folder.path(), &["identify", "s", "--format", "json"]));
    let own = found["parameters"].as_array().expect("a list").iter().find(|own| own["name"] == "3.theta");
    let own = own.unwrap_or_else(|| panic!("{}", found["parameters"]));
    let change = own["value"].as_f64().expect("a number") - own["nominal"].as_f64().expect("a number");
    assert!((change - 0.3).abs() < 0.02, "{own}");
}
