//! The open questions of the calibration papers, answered by `diagnose` (`docs/questions.md`), and its
//! warnings where a campaign asks too little.

use serde_json::Value;

use super::cli::run;
use crate::support::{number, printed_json};

fn diagnosed(campaign: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    printed_json(folder.path(), &["diagnose", campaign])
}

/// Effect and site of each cause.
fn causes(found: &Value) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().expect("a name").to_string();
    let all = found["causes"].as_array().expect("causes");
    all.iter().map(|cause| (text(&cause["effect"]), text(&cause["site"]))).collect()
}

fn named(effect: &str, site: &str) -> (String, String) {
    (effect.into(), site.into())
}

/// The site with the greatest share.
fn first_site(found: &Value) -> &str {
    found["where"]["sites"][0]["site"].as_str().expect("a site")
}

#[test]
fn screws_described_as_joint_springs() {
    let found = diagnosed("ir663-axial-screws");
    let expected = [named("actuator-compliance", "actuator:screw8"), named("actuator-compliance", "actuator:screw2")];
    assert_eq!(causes(&found), expected);
    assert_eq!(found["verdict"], "explained");
    for cause in found["causes"].as_array().expect("causes") {
        let axial = &cause["parameters"][0];
        // The truth is 5e-8 m/N.
        assert!((number(&axial["value"]) - 5e-8).abs() < number(&axial["ci95"]), "{axial}");
    }
    assert_eq!(first_site(&found), "joint:8");
    assert!(number(&found["after_all"]["shrinkage"]) > 0.85, "{}", found["after_all"]);
    assert!(number(&found["after_all"]["rms"]) < 1.1 * number(&found["gap"]["noise"]));
    // Too stiff where the screw is far out and its lever short.
    let soft = &found["where"]["yielding"];
    assert!(soft["when"].as_str().expect("words").starts_with("stroke8 > "), "{soft}");
    assert!(number(&soft["excess"]) > 0.3 && number(&soft["elsewhere"]).abs() < 0.05, "{soft}");
    // The lever itself: for a given force the angle goes with one over its square, which is smallest out there.
    let model = super::support::bundled("kuka-ir663");
    let screw = model.variables.iter().position(|variable| variable.name == "stroke8").expect("a screw");
    let geometry = elastogeo::kinematics::Geometry::nominal(&model).expect("assembled");
    let turned = |stroke: f64| {
        let mut q = model.middle();
        let mut at = |stroke: f64| {
            q[screw] = stroke;
            let mut placements = elastogeo::kinematics::Placements::default();
            geometry.place(&q, &mut placements).expect("placed");
            placements.joints[model.frames.iter().position(|frame| frame.name == "8").expect("a frame")]
        };
        ((at(stroke + 1e-6) - at(stroke - 1e-6)) / 2e-6).abs()
    };
    assert!(turned(0.9) > 1.1 * turned(0.7), "{} {}", turned(0.9), turned(0.7));
}

#[test]
fn compensator_left_out() {
    let found = diagnosed("kr270-no-compensator");
    assert_eq!(causes(&found), [named("gravity-compensator", "joint:2")]);
    assert_eq!((found["verdict"].as_str(), first_site(&found)), (Some("explained"), "joint:2"));
    let all = &found["after_all"];
    assert!(number(&all["shrinkage"]) > 0.2 && number(&all["shrinkage_ci95"][0]) > 0.0, "{all}");
    assert!(number(&all["rms"]) < 1.1 * number(&found["gap"]["noise"]), "{all}");
}

#[test]
fn joint_one_described_rigid() {
    let found = diagnosed("kr270-rigid-joint-1");
    assert_eq!(causes(&found), [named("joint-compliance", "joint:1")]);
    assert_eq!((found["verdict"].as_str(), first_site(&found)), (Some("explained"), "joint:1"));
    // About the same axis the base cannot be distinguished from the joint.
    let rivals = &found["causes"][0]["indistinguishable_from"];
    assert_eq!(rivals.as_array().map(Vec::len), Some(1), "{rivals}");
    assert_eq!(rivals[0]["effect"], "base-compliance");
    // The arm points along x: joint 1 moves it along y.
    let by = |axis: &str| number(&found["where"]["directions"][axis]);
    assert!(by("y") > 3.0 * by("x") && by("y") > 3.0 * by("z"), "{}", found["where"]["directions"]);
    assert!(number(&found["after_all"]["shrinkage"]) > 0.85);
    let truth = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("campaigns/kr270-rigid-joint-1/truth.json"),
    );
    let truth: Value = serde_json::from_str(&truth.expect("a file")).expect("JSON");
    let own = &found["causes"][0]["parameters"][0];
    let difference = number(&own["value"]) - number(&truth["parameters"]["joint1.kar"]["true"]);
    assert!(difference.abs() < number(&own["ci95"]), "{own} {difference}");
}

const ARM: &str = "
robot: Arm
units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 400, limits: [-150, 150]}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, limits: [-60, 60]}
  3: {antecedent: 2, joint: revolute, variable: q3, d: 600, limits: [-90, 90]}
  flange: {antecedent: 3, d: 500}
tool: {frame: flange}
";

/// Without `calibrate:` what `identify` fits is re-fitted, and listed; where that is to be nothing, the campaign is warned of what
/// competes.
#[test]
fn campaign_without_calibrate_is_calibrated_as_identify_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("arm.yaml"), ARM).expect("written");
    let made = ["simulate", "arm.yaml", "--poses", "40", "--check", "0", "--errors", "0.2", "--into", "own"];
    assert_eq!(run(at, &made).status, 0);
    let with = run(at, &["diagnose", "own"]);
    assert!(with.status == 0 && !with.err.contains("calibrate"), "{}", with.err);
    let file = at.join("own/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("a file");
    let replaced = |by: &str| {
        let without = text.replace("calibrate:\n- geometry\n- joint-offset\n", by);
        assert_ne!(text, without);
        std::fs::write(&file, without).expect("written");
    };
    replaced("");
    let json = |arguments: &[&str]| crate::support::printed_json(at, arguments);
    let (found, fitted) = (json(&["diagnose", "own"]), json(&["identify", "own"]));
    assert_eq!(found["verdict"], "no-gap", "{}", found["where"]);
    assert_eq!(found["refitted"]["effects"], serde_json::json!(["geometry", "joint-offset"]));
    assert_eq!(
        found["refitted"]["parameters"].as_array().map(Vec::len),
        fitted["kept"].as_u64().map(|kept| kept as usize)
    );
    let left = |value: &serde_json::Value| value.as_f64().expect("a number");
    let ratio = left(&found["gap"]["rms"]) / left(&fitted["residuals"]["after"]["rms"]);
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
    assert!(run(at, &["diagnose", "own"]).out.contains("refitted with each hypothesis: geometry, joint-offset ("));
    replaced("calibrate: []\n");
    let bare = run(at, &["diagnose", "own"]);
    assert_eq!(bare.status, 0, "{}", bare.err);
    assert!(bare.err.contains("`calibrate:` of the campaign is empty: geometry competes"), "{}", bare.err);
}

/// What was diagnosed stays in the description when the campaign leaves out what its own robot declares, and nothing is
/// reported of elements that are gone already.
#[test]
fn applied_description_keeps_the_cause_despite_without() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let effect = "effects: [{effect: transmission-error, site: \"joint:2\", parameters: {cos: 4.0e-4, sin: 2.0e-4, order: 2}}]\n";
    std::fs::write(at.join("arm.yaml"), format!("{ARM}{effect}")).expect("written");
    let made = ["simulate", "arm.yaml", "--poses", "60", "--errors", "0.2", "--check", "0", "--into", "own"];
    let ran = run(at, &made);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let file = at.join("own/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("a file");
    std::fs::write(&file, format!("{text}without: [transmission-error]\n")).expect("written");
    let found = printed_json(at, &["diagnose", "own", "--apply", "found.yaml"]);
    assert_eq!(causes(&found), [named("transmission-error", "joint:2")]);
    let held = run(at, &["residuals", "found.yaml", "own", "--format", "json"]);
    assert!(held.status == 0 && !held.err.contains("leaves nothing out"), "{}", held.err);
    let rms = number(&serde_json::from_str::<Value>(&held.out).expect("JSON")["all"]["rms"]);
    let promised = number(&found["after_all"]["rms"]);
    assert!((0.75..1.05).contains(&(rms / promised)), "{rms} mm where {promised} mm was promised");
    let applied = run(at, &["diagnose", "kr270-no-compensator", "--apply", "kr.yaml"]);
    assert_eq!(applied.status, 0, "{}", applied.err);
    let again = run(at, &["residuals", "kr.yaml", "kr270-no-compensator"]);
    assert!(again.status == 0 && !again.err.contains("leaves nothing out"), "{}", again.err);
    // A name that no robot has is still reported.
    let text = std::fs::read_to_string(&file).expect("a file").replace("[transmission-error]", "[springg]");
    std::fs::write(&file, text).expect("written");
    let wrong = run(at, &["residuals", "found.yaml", "own"]);
    assert!(wrong.err.contains("`without: springg` leaves nothing out"), "{}", wrong.err);
}

#[test]
fn effects_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (entry, expected) in [
        ("{effect: hose-pull, site: \"joint:2\", parameters: {pull: 1}}", "hose-pull"),
        ("{effect: gear-ratio, site: \"joint:flange\", parameters: {ratio: 1e-4}}", "cannot sit at `joint:flange`"),
        ("{effect: gear-ratio, site: \"joint:2\", parameters: {raito: 1e-4}}", "no parameter `raito`"),
        ("{effect: link-weight, site: \"link:2\", parameters: {body2.mass: 1}}", "cannot sit at `link:2`"),
        ("{effect: outliers, site: instrument}", "of single readings, and nothing of a robot"),
        (
            "{effect: joint-coupling, site: \"joint:2\", parameters: {ratio: 1e-3, variable: q2}}",
            "`variable: q2` of `joint-coupling` at `joint:2`",
        ),
        (
            "{effect: transmission-error, site: \"joint:2\", parameters: {cos: 1e-4, order: -3}}",
            "write a number above 0",
        ),
    ] {
        std::fs::write(at.join("arm.yaml"), format!("{ARM}effects: [{entry}]\n")).expect("written");
        let ran = run(at, &["check", "arm.yaml"]);
        assert_eq!(ran.status, 2, "{entry}: {}", ran.out);
        assert!(ran.err.contains(expected) && ran.err.contains("help"), "{entry}: {}", ran.err);
    }
}

/// Amounts in another unit than SI, and ranges of validity of no variable or the wrong way round.
#[test]
fn amounts_and_ranges_beyond_reason_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let check = |more: &str| {
        std::fs::write(at.join("arm.yaml"), format!("{ARM}{more}\n")).expect("written");
        run(at, &["check", "arm.yaml"])
    };
    let far = check("effects: [{effect: gear-ratio, site: \"joint:2\", parameters: {ratio: 50}}]");
    assert!(far.status == 0 && far.err.contains("times what such an effect usually is"), "{}", far.err);
    let near = check("effects: [{effect: gear-ratio, site: \"joint:2\", parameters: {ratio: 5e-4}}]");
    assert!(near.status == 0 && !near.err.contains("usually"), "{}", near.err);
    for (validity, expected) in [
        ("{joints: {q9: [0, 1]}}", "unknown variable `q9`"),
        ("{joints: {q2: [1, 0]}}", "a range from 1 to 0"),
        ("{loads: {torque: [0, 1]}}", "unknown load `torque`"),
        ("{time: [5, 1]}", "a range from 5 to 1"),
    ] {
        let ran = check(&format!("validity: {validity}"));
        assert_eq!(ran.status, 2, "{validity}: {}", ran.out);
        assert!(ran.err.contains(expected) && ran.err.contains("arm.yaml:"), "{validity}: {}", ran.err);
    }
}

#[test]
fn ranges_and_rigid_joints_of_simulated_campaigns() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "kuka-kr270", "--poses", "30", "--range", "q1=-10:10,q2=-60:-40", "--into", "own"];
    assert_eq!(run(at, &made).status, 0);
    let mut table = csv::Reader::from_path(at.join("own/measurements.csv")).expect("a table");
    let header = table.headers().expect("a header").clone();
    let column = |name: &str| header.iter().position(|known| known == name).expect("a column");
    for row in table.records() {
        let row = row.expect("a row");
        let at = |name: &str| row[column(name)].parse::<f64>().expect("a number");
        assert!(at("q1").abs() <= 10.0 && (-60.0..=-40.0).contains(&at("q2")), "{row:?}");
    }
    for (flag, value) in [("--range", "q9=0:1"), ("--range", "q1=5:1"), ("--set", "joint2.kar=-inf")] {
        let ran = run(at, &["simulate", "kuka-kr270", "--poses", "3", flag, value, "--into", "other"]);
        assert_eq!(ran.status, 2, "{flag} {value}");
        assert!(!at.join("other").exists());
    }
}

/// Of more readings than the hypotheses have memory for, configurations are drawn, the same for a seed, and the cause is found in them.
#[test]
fn a_diagnosis_of_many_readings_draws_configurations() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let effect = "gear-ratio@joint:3:ratio=4e-4";
    let made =
        ["simulate", "kuka-kr270", "--poses", "1500", "--markers", "m1,m2,m3", "--unknown-base", "--unknown-tool"];
    let ran = run(at, &[&made[..], &["--effect", effect, "--seed", "4", "--into", "many"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let found = crate::support::printed_json(at, &["diagnose", "many"]);
    let drawn: Vec<u64> = serde_json::from_value(found["drawn_from"].clone()).expect("two numbers");
    assert!(drawn[1] == 1500 && (100..1500).contains(&drawn[0]), "{drawn:?}");
    assert_eq!(found["causes"][0]["effect"], "gear-ratio", "{}", found["causes"]);
    assert_eq!(found["causes"][0]["site"], "joint:3");
    assert!(run(at, &["diagnose", "many"]).out.contains(&format!("{} of 1500 configurations were drawn", drawn[0])));
}
