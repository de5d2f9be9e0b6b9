//! Numbers that must hold whatever the campaign: no panic, no drift, no wrong answer with a green sign.

use std::path::Path;

use elastogeo::diagnostic::{Code, Diagnostic};
use elastogeo::estimation::{Settings, calibrate, split};
use elastogeo::math::quantiles::{f_tail, normal95, t95};
use elastogeo::plausibility::{Evidence, Limits, forced, judge};
use elastogeo::render::identification::identification;
use elastogeo::render::table::Screen;
use elastogeo::results::Identification;

use super::cli::run;

/// Two joints in a plane.
pub const TWO: &str = "robot: two
units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 400}
tool: {frame: 2, at: [350, 0, 0]}
";

#[test]
fn tails_and_quantiles_of_what_is_not_finite() {
    assert_eq!(f_tail(f64::INFINITY, 2.0, 5.0), 0.0);
    assert_eq!(f_tail(0.0, 2.0, 5.0), 1.0);
    for hopeless in [f64::NAN, f64::NEG_INFINITY, -1.0] {
        assert_eq!(f_tail(hopeless, 2.0, 5.0), 1.0);
    }
    for degrees in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!((f_tail(3.0, degrees, 5.0), f_tail(3.0, 2.0, degrees)), (1.0, 1.0));
    }
    assert!(f_tail(f64::MAX, 6.0, 1e4) < 1e-300);
    // F with 1 and d degrees is the square of Student's t: the tail at its 97.5 % point is 5 %.
    for degrees in [1.0, 2.5, 7.0, 300.0, 1e3, 1.001e3, 1e5] {
        assert!((f_tail(t95(degrees).powi(2), 1.0, degrees) - 0.05).abs() < 1e-9, "{degrees}");
    }
    // P(F > x) with 2 and 2 degrees is 1 / (1 + x).
    assert!((f_tail(3.0, 2.0, 2.0) - 0.25).abs() < 1e-12);
    assert_eq!(t95(f64::INFINITY), normal95());
    // However many, there is an answer.
    let mut before = t95(1.0);
    for degrees in (1..300).map(|k| 10.0_f64.powi(k)) {
        assert!(t95(degrees) <= before && t95(degrees) >= normal95(), "{degrees}");
        before = t95(degrees);
    }
    assert_eq!([t95(0.0), t95(-1.0), t95(f64::NAN)], [f64::INFINITY; 3]);
}

/// Nothing but the module of quantiles asks the library of distributions, which panics on what is not finite.
#[test]
fn distributions_are_asked_in_one_place() {
    fn walk(folder: &Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                walk(&path, found);
            } else if std::fs::read_to_string(&path).expect("text").contains("statrs::") {
                found.push(path.file_name().expect("a name").to_string_lossy().into_owned());
            }
        }
    }
    let mut found = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
    assert_eq!(found, ["quantiles.rs"]);
}

/// Two hypotheses fit four poses without a rest: the ratio of their gain to it is infinite.
#[test]
fn a_gain_over_nothing_is_diagnosed_without_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("two.yaml"), TWO).expect("written");
    for seed in ["1", "2", "3"] {
        let made = run(folder.path(), &["simulate", "two.yaml", "--poses", "4", "--seed", seed, "--into", seed]);
        assert_eq!(made.status, 0, "{}", made.err);
        let found = run(folder.path(), &["diagnose", seed]);
        assert!((0..=2).contains(&found.status), "{}", found.err);
    }
}

/// A folder with the campaign that `init` makes.
fn starter() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "c"]).status, 0);
    folder
}

/// The number before the words of a line.
fn figure_before(text: &str, words: &str) -> f64 {
    let line = text.lines().find(|line| line.contains(words)).unwrap_or_else(|| panic!("{words}:\n{text}"));
    let before = line.split(words).next().unwrap_or_default().split_whitespace().next_back().unwrap_or_default();
    before.parse().unwrap_or_else(|_| panic!("{line}"))
}

/// Position error of all readings of campaign `c`, rms in mm, by a description.
fn rms_of(folder: &Path, robot: &str) -> f64 {
    let ran = run(folder, &["residuals", robot, "c", "--format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    found["all"]["rms"].as_f64().expect("a number")
}

#[test]
fn every_loss_finds_the_robot_among_sound_readings() {
    let folder = starter();
    for loss in ["squares", "huber", "cauchy", "tukey"] {
        let ran = run(folder.path(), &["identify", "c", "--loss", loss]);
        let rms = figure_before(&ran.out, " mm calibrated");
        assert!(ran.status == 0 && rms < 0.075, "{loss}: {rms}");
    }
}

#[test]
fn robust_losses_find_the_robot_among_a_fifth_of_outliers() {
    let folder = starter();
    let at = folder.path();
    std::fs::create_dir(at.join("bad")).expect("a folder");
    for name in ["campaign.yaml", "robot.yaml"] {
        std::fs::copy(at.join("c").join(name), at.join("bad").join(name)).expect("copied");
    }
    let text = std::fs::read_to_string(at.join("c/measurements.csv")).expect("text");
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    let x = header.split(',').position(|name| name == "x").expect("a column");
    let spoiled = lines.enumerate().map(|(row, line)| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        // Every fifth is off by 5 to 60 mm, all to one side.
        if row % 5 == 0 {
            let value: f64 = cells[x].parse().expect("a number");
            cells[x] = (value + 5.0 + (row as f64 * 7.3) % 55.0).to_string();
        }
        cells.join(",")
    });
    let spoiled = std::iter::once(header.to_string()).chain(spoiled).collect::<Vec<_>>().join("\n");
    std::fs::write(at.join("bad/measurements.csv"), spoiled).expect("written");
    let calibrated = |loss: &str| {
        let name = format!("{loss}.yaml");
        // Without a robust loss the outliers keep it from being saved.
        let forced: &[&str] = if loss == "squares" { &["--force"] } else { &[] };
        let ran = run(at, &[&["identify", "bad", "--loss", loss, "--save", &name], forced].concat());
        assert_eq!(ran.status, 0, "{loss}: {}", ran.out);
        assert!(loss == "squares" || ran.out.contains("12 of 60 readings are far off"), "{loss}: {}", ran.out);
        rms_of(at, &name)
    };
    assert!(calibrated("squares") > 2.0);
    for loss in ["huber", "cauchy", "tukey"] {
        let rms = calibrated(loss);
        assert!(rms < 0.085, "{loss}: {rms}");
    }
}

#[test]
fn scales_of_losses_that_would_fit_nothing_are_refused() {
    let folder = starter();
    for (loss, scale) in [("huber", "1e-300"), ("tukey", "1"), ("cauchy", "1e9"), ("huber", "nan"), ("huber", "-1")] {
        let ran = run(folder.path(), &["identify", "c", "--loss", loss, &format!("--loss-scale={scale}")]);
        assert_eq!(ran.status, 2, "{loss} {scale}: {}", ran.out);
        assert!(ran.err.contains("--loss-scale") && ran.err.contains("1000"), "{}", ran.err);
    }
}

/// A four-bar whose closing lengths a campaign of twelve poses hardly determines.
const FOUR_BAR: &str = "robot: fourbar
units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q0, limits: [40, 100]}
  2: {antecedent: 1, joint: revolute, passive: true, d: 200}
  3: {antecedent: 2, joint: revolute, passive: true, d: 500}
  4: {antecedent: 0, joint: revolute, passive: true, gamma: 0, d: 450}
  5: {antecedent: 4, d: 300}
loops:
  bar:
    frames: [3, 5]
    branch: {2: -50, 4: 70}
tool: {frame: 3}
";

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}:\n{text}"))
}

/// Tilts that few readings hardly show end where the loop is still a planar one, so that the description is read again.
#[test]
fn tilts_in_a_planar_loop_leave_it_planar() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("fourbar.yaml"), FOUR_BAR).expect("written");
    assert_eq!(run(at, &["simulate", "fourbar.yaml", "--poses", "12", "--seed", "3", "--into", "f"]).status, 0);
    let ran = run(at, &["identify", "f", "--tolerance", "6.1e-5", "--save", "f.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.out);
    let tilt = ran.out.lines().find(|line| line.starts_with(" 2.alpha") && line.contains("at its bound"));
    assert!(tilt.is_some(), "{}", ran.out);
    assert_eq!(run(at, &["check", "f.yaml"]).status, 0);
}

#[test]
fn without_convergence_there_is_no_headline() {
    let loaded = elastogeo::files::load_campaign("ir663-simulated", None).expect("a campaign");
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let held_out = split(campaign, 0.25, 1);
    let hasty = Settings { max_iterations: Some(1), ..Settings::default() };
    let found = calibrate(model, campaign, &held_out, &hasty, &mut |_| {}).expect("a calibration");
    let judged = judge(&Evidence::with(model, campaign, &found), &Limits::default());
    assert_eq!(judged.iter().map(|told| told.code).collect::<Vec<_>>(), [Code::NotConverged]);
    let remedy = judged[0].remedy.as_deref().unwrap_or_default();
    assert!(judged[0].is_error() && remedy.contains("--hold"), "{judged:?}");
    let mut result = Identification::new(model, campaign, &found, 0.0);
    assert!(identification(&result, Screen::new(None)).contains("mm calibrated"));
    result.refusals = judged;
    let text = identification(&result, Screen::new(None));
    assert!(text.contains("NO RESULT: the fit did not converge") && !text.contains("mm calibrated"), "{text}");
}

#[test]
fn force_weakens_plausibility_alone() {
    let told = |code| Diagnostic::error("told").code(code);
    let weaker = forced(vec![told(Code::Implausible), told(Code::NotConverged)]);
    assert_eq!(weaker.iter().map(Diagnostic::is_error).collect::<Vec<_>>(), [false, true]);
}

/// Springs that the readings do not hold end at a finite stiffness, and the description is read again.
#[test]
fn a_saved_stiffness_is_never_infinite() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let ran = run(at, &["identify", "kr270-simulated", "--what", "elastic", "--save", "cal.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(!std::fs::read_to_string(at.join("cal.yaml")).expect("text").contains("inf"));
    assert_eq!(run(at, &["check", "cal.yaml"]).status, 0);
}

/// A program that reads JSON learns why there is no result, whatever the exit status.
#[test]
fn refusals_are_json_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run(folder.path(), &["identify", "nothing-here", "--format", "json"]);
    assert_eq!(ran.status, 2);
    assert_eq!(json(&ran.out)["diagnostics"][0]["severity"], "error");
    assert_eq!(
        json(&run(folder.path(), &["check", "universal-ur5", "--format", "json"]).out)["diagnostics"],
        json("[]")
    );
    for jobs in ["0", "1000000"] {
        assert_eq!(run(folder.path(), &["check", "universal-ur5", "--jobs", jobs]).status, 2);
    }
}

/// A serial arm with four anchors about it, every joint's limits within `width` degrees of a middle.
fn arm(width: f64) -> String {
    let path = format!("{}/robots/universal-ur5.yaml", env!("CARGO_MANIFEST_DIR"));
    let mut middles = [20.0, -60.0, 80.0, -30.0, 60.0, 10.0].into_iter();
    let text = std::fs::read_to_string(path).expect("a file");
    let lines = text.lines().map(|line| match (line.find("limits: ["), middles.as_slice().first()) {
        (Some(at), Some(&middle)) if line.contains("variable") => {
            middles.next();
            format!("{}limits: [{}, {}]}}", &line[..at], middle - width, middle + width)
        }
        _ => line.to_string(),
    });
    let anchors = "anchors: {A: [1500, 0, 0], B: [0, 1500, 0], C: [-1200, -900, 300], D: [100, -200, 1900]}\n";
    lines.collect::<Vec<_>>().join("\n") + "\n" + anchors
}

/// Wherever the base stands and however it is turned, distances alone find it.
#[test]
fn distances_alone_place_a_base_far_from_its_description() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("arm.yaml"), arm(180.0)).expect("written");
    let placements = [["base.rz=170", "base.x=0", "base.ry=0"], ["base.x=8000", "base.rx=60", "base.ry=-100"]];
    for (k, set) in placements.iter().enumerate() {
        let into = format!("c{k}");
        let given: Vec<&str> = set.iter().flat_map(|value| ["--set", value]).collect();
        let asked =
            ["simulate", "arm.yaml", "--poses", "24", "--observes", "distance", "--unknown-base", "--into", &into];
        assert_eq!(run(at, &[&asked[..], &given].concat()).status, 0);
        let found = json(&run(at, &["identify", &into, "--format", "json"]).out);
        let rms = |stage: &str| found["residuals"][stage]["rms"].as_f64().expect("a number");
        assert!(rms("registration") < 6.0 && rms("check_after") < 0.1, "{set:?}: {}", found["residuals"]);
    }
}

/// A base about an axis that no reading shows stays as described.
#[test]
fn a_direction_without_effect_does_not_drift() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let robot = TWO.replace("at: [350, 0, 0]", "at: [0, 0, 0]")
        + "anchors: {A: [1000, 0, 0], B: [0, 1000, 0], C: [0, 0, 1500]}\n";
    std::fs::write(at.join("two.yaml"), robot.replace("d: 400", "")).expect("written");
    let asked = ["simulate", "two.yaml", "--poses", "12", "--observes", "distance", "--unknown-base", "--into", "d"];
    assert_eq!(run(at, &asked).status, 0);
    let ran = run(at, &["identify", "d", "--format", "json"]);
    for parameter in json(&ran.out)["parameters"].as_array().expect("a list") {
        assert!(parameter["value"].as_f64().expect("a number").abs() < 5000.0, "{parameter}");
    }
}

/// Joints moved by 0.1 degrees: base and tool stay within reach, their intervals within metres, and what is known
/// beforehand helps.
#[test]
fn narrow_poses_leave_base_and_tool_in_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("arm.yaml"), arm(0.05)).expect("written");
    let asked =
        ["simulate", "arm.yaml", "--poses", "16", "--unknown-base", "--unknown-tool", "--seed", "5", "--into", "c"];
    assert_eq!(run(at, &asked).status, 0);
    let with = |more: &[&str]| json(&run(at, &[&["identify", "c", "--format", "json"], more].concat()).out);
    let plain = with(&[]);
    assert_eq!(plain["diagnostics"][0]["code"], "weak-direction", "{}", plain["diagnostics"]);
    let placed = |name: &str| name.starts_with("base.") || name.starts_with("tool.") || name.starts_with("ball");
    let parameters = plain["parameters"].as_array().expect("a list");
    for parameter in parameters.iter().filter(|p| placed(p["name"].as_str().expect("a name"))) {
        let width = parameter["ci95"].as_f64().unwrap_or_default();
        assert!(width < 2000.0 && parameter["value"].as_f64().expect("a number").abs() < 3000.0, "{parameter}");
    }
    let rms = |found: &serde_json::Value| found["residuals"]["check_after"]["rms"].as_f64().expect("a number");
    for more in [&["--prior"][..], &["--tolerance", "noise"]] {
        assert!(rms(&with(more)) < 1.02 * rms(&plain), "{more:?}");
    }
}
