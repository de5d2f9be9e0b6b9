//! Own weight: whether it is in a predicted position is said by every command, and `pose`, `solve` and `simulate` agree
//! about it.

use std::path::Path;

use elastogeo::files::{Reader, load_robot};
use elastogeo::model::Model;
use elastogeo::observation::POSE;
use elastogeo::simulation::{Plan, generator, simulate};
use serde_json::Value;

use crate::cli::run;
use crate::support::{KR270_MASSES, heavy_kr270, printed_json};

/// A tenth of rounding of what is written: 1e-9 mm, in m.
const EXACT: f64 = 1e-12;

const GEAR_RATIO: &str = "effects:\n  - {effect: gear-ratio, site: 'joint:3', parameters: {ratio: 4e-4}}\n";

/// Poses of the tool (position, rotation vector) and the markers as `simulate` reads them at zero wrench, m and rad.
fn simulated(model: &Model, q: &[f64]) -> Vec<[f64; 6]> {
    let plan = Plan {
        conditions: false,
        wrenches: Vec::new(),
        configurations: vec![q.to_vec()],
        markers: std::iter::once(None).chain((0..model.markers.len()).map(Some)).collect(),
        repeats: 1,
        observes: POSE,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    let campaign = simulate(model, &model.registry.nominal(), &plan, &mut generator(1)).expect("simulated");
    campaign.readings.iter().map(|reading| std::array::from_fn(|k| reading.measured[k])).collect()
}

/// Joints given in mm and deg, in SI.
fn given(model: &Model, joints: &str) -> Vec<f64> {
    let of = |text: &str| -> f64 { text.rsplit('=').next().and_then(|v| v.parse().ok()).expect("a number") };
    let all = model.variables.iter().zip(joints.split(','));
    all.map(|(variable, text)| of(text) * if variable.is_angle { 1f64.to_radians() } else { 1e-3 }).collect()
}

fn position(homogeneous: &Value) -> [f64; 3] {
    std::array::from_fn(|k| homogeneous[k][3].as_f64().expect("a number"))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// A robot with masses, springs and an effect, and one with loops; each with joints in the description's units.
fn robots(folder: &Path) -> [(String, &'static str); 2] {
    [
        (heavy_kr270(folder, &format!("{KR270_MASSES}{GEAR_RATIO}")), "q1=10,q2=-60,q3=80,q4=20,q5=-40,q6=30"),
        ("kuka-ir663".into(), "q1=20,stroke2=850,stroke8=770,q4=10,q5=30,q7=-20"),
    ]
}

#[test]
fn a_pose_under_own_weight_is_the_simulated_one() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, joints) in robots(folder.path()) {
        let model = load_robot(&robot).expect("a robot").model;
        let rigid = printed_json(folder.path(), &["pose", &robot, "--joints", joints]);
        let loaded = printed_json(folder.path(), &["pose", &robot, "--joints", joints, "--weight"]);
        assert_eq!((&rigid["own_weight"], &loaded["own_weight"]), (&"left_out".into(), &"included".into()));
        let q = given(&model, joints);
        let readings = simulated(&model, &q);
        assert!(apart(&position(&loaded["tool"]), &readings[0][..3]) < EXACT);
        assert!(apart(&position(&rigid["tool"]), &readings[0][..3]) > 5e-4);
        for (marker, reading) in model.markers.iter().zip(&readings[1..]) {
            let at: Vec<f64> = serde_json::from_value(loaded["markers"][&marker.name].clone()).expect("numbers");
            assert!(apart(&at, &reading[..3]) < EXACT, "{}", marker.name);
        }
    }
}

#[test]
fn a_target_is_met_as_own_weight_deflects_the_tool() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, joints) in robots(folder.path()) {
        let model = load_robot(&robot).expect("a robot").model;
        let q = given(&model, joints);
        let [seen, ..] = simulated(&model, &q)[..] else { panic!("no reading") };
        // Both descriptions are in mm and deg or rad: what they make of the target is read back from them.
        let units = Reader::default().robot(&robot).expect("a robot").raw.units;
        let target: Vec<String> = seen
            .iter()
            .enumerate()
            .map(|(k, v)| format!("{:?}", v / if k < 3 { units.length.factor() } else { units.angle.factor() }))
            .collect();
        let target = target.join(",");
        let found = printed_json(folder.path(), &["solve", &robot, "--target", &target, "--from", joints, "--weight"]);
        assert_eq!(found["own_weight"], "included");
        let solution = &found["solutions"][0]["joints"];
        let solved: Vec<f64> = model.variables.iter().map(|v| solution[&v.name].as_f64().expect("rad")).collect();
        assert!(apart(&simulated(&model, &solved)[0], &seen) < EXACT, "{robot}");
        assert!(apart(&solved, &q) < 1e-6, "{solved:?} {q:?}");
        let rigid = printed_json(folder.path(), &["solve", &robot, "--target", &target, "--from", joints]);
        assert_eq!(rigid["own_weight"], "left_out");
        let solution = &rigid["solutions"][0]["joints"];
        let solved: Vec<f64> = model.variables.iter().map(|v| solution[&v.name].as_f64().expect("rad")).collect();
        assert!(apart(&solved, &q) > 1e-4);
    }
}

/// Effects of moves, times and temperatures are no part of a configuration: `pose` and `solve` say that they leave them out.
#[test]
fn effects_that_a_configuration_does_not_say_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["convert", "universal-ur5", "plain.yaml"]).status, 0);
    let plain = std::fs::read_to_string(folder.path().join("plain.yaml")).expect("read");
    let effects = "effects:\n- {effect: settling, site: 'joint:2', parameters: {share: 2e-3}}\n\
                   - {effect: gear-ratio, site: 'joint:3', parameters: {ratio: 4e-4}}\n";
    std::fs::write(folder.path().join("arm.yaml"), plain + effects).expect("written");
    let joints = "q1=10,q2=-80,q3=70,q4=-60,q5=-90,q6=0";
    let posed = run(folder.path(), &["pose", "arm.yaml", "--joints", joints, "--weight"]);
    let solved = run(folder.path(), &["solve", "arm.yaml", "--target", "400,200,400", "--weight"]);
    for ran in [posed, solved] {
        assert_eq!(ran.status, 0, "{}", ran.err);
        assert!(ran.err.contains("how great they are: settling@joint:2\n"), "{}", ran.err);
    }
    let rigid = run(folder.path(), &["pose", "arm.yaml", "--joints", joints]);
    assert!(rigid.status == 0 && !rigid.err.contains("settling"), "{}", rigid.err);
}

#[test]
fn every_command_that_predicts_says_whether_own_weight_is_in() {
    let folder = tempfile::tempdir().expect("a folder");
    let commands: [(&[&str], &str); 15] = [
        (&["pose", "kuka-ir663", "--joints", ""], "left_out"),
        (&["pose", "universal-ur5", "--joints", "", "--weight"], "none"),
        (&["solve", "kuka-ir663", "--target", "1900,0,900", "--from", ""], "left_out"),
        (&["simulate", "kuka-ir663", "--poses", "3", "--into", "positions"], "included"),
        (
            &["simulate", "kuka-ir663", "--poses", "3", "--observes", "deflection", "--wrench=0,0,-100", "--into", "d"],
            "left_out",
        ),
        (&["residuals", "kuka-ir663", "positions"], "included"),
        (&["residuals", "kuka-ir663", "d"], "left_out"),
        (&["identifiability", "kuka-ir663", "positions"], "included"),
        (&["sensitivity", "kuka-ir663", "d"], "left_out"),
        (&["diagnose", "kr270-simulated"], "included"),
        (&["diagnose", "ir663-simulated"], "included"),
        (&["plan", "kuka-ir663", "--poses", "12", "--observes", "deflection", "--wrench=0,0,-100"], "left_out"),
        (&["track", "kuka-ir663", "ir663-simulated", "ir663-axial-screws"], "included"),
        (&["stiffness", "kuka-ir663", "--joints", "", "--wrench=0,0,-100", "--weight"], "included"),
        (&["view", "kuka-ir663"], "left_out"),
    ];
    for (command, expected) in commands {
        let text = run(folder.path(), command);
        assert_eq!(text.status, 0, "{command:?}: {}", text.err);
        let words = expected.replace('_', " ");
        assert!(text.out.contains(&format!("own weight: {words}")), "{command:?}: {}", text.out);
        if let (Some(&"simulate"), Some(into)) = (command.first(), command.last()) {
            std::fs::remove_dir_all(folder.path().join(into)).expect("removed");
        }
        assert_eq!(printed_json(folder.path(), command)["own_weight"], expected, "{command:?}");
    }
}
