//! Loads as they were measured: torques that deflect joints instead of what the description says, and wrenches at named points.

use std::fmt::Write as _;

use elastogeo::description::campaign::{Campaign, LoadPoint};
use elastogeo::files::{LoadedCampaign, load_campaign, load_robot};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::Model;
use elastogeo::observation::POSITION;
use elastogeo::plausibility::{Evidence, Limits, judge};
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{all_points, draw_configurations, generator};
use nalgebra::Point3;

use super::cli::run;

const ARM: &str = "robot: arm that gives\nunits: {length: mm, angle: deg, rotational_stiffness: N.m/rad}\nvariables: [q1, q2]\n\
                   gravity: [0, -9.81, 0]\nframes:\n\
                   \x20 1: {antecedent: 0, joint: revolute, variable: q1, limits: [-170, 170]}\n\
                   \x20 2: {antecedent: 1, joint: revolute, variable: q2, d: 500, limits: [-170, 170]}\n\
                   \x20 E: {antecedent: 2, d: 400}\ntool: {frame: E}\nmarkers: {ball: {frame: 1, at: [0, 80, 0]}}\n\
                   bodies:\n  1: {mass: 8, com: [250, 0, 0]}\n  2: {mass: 4, com: [150, 0, 0]}\n\
                   joint_stiffness: {1: {kar: {compliance: C1, identifiable: true}}, 2: {kar: {compliance: C2, identifiable: true}}}\n";

fn arm(compliances: [f64; 2]) -> String {
    let [one, two] = compliances.map(|compliance| format!("{compliance:e}"));
    ARM.replace("C1", &one).replace("C2", &two)
}

const HEAD: &str = "robot: arm.yaml\nunits: {length: mm, angle: deg}\ninstrument: {sigma: 0.01, torque: 0.1}\n";

fn predicted(loaded: &LoadedCampaign) -> Linearised {
    let mut found = Linearised::default();
    let values = loaded.robot.model.registry.nominal();
    let predictor = Predictor::new(&loaded.robot.model, &loaded.campaign, Vec::new()).expect("a predictor");
    predictor.linearise(&values, false, &mut found).expect("predicted");
    found
}

/// Readings of an arm that carries 20 kg of which nobody knows: positions and torques.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let joints = |k: i32| [f64::from(-150 + 9 * k), f64::from(-120 + 53 * k % 240)];
    let mut rows = "pose,q1,q2,x,y,z,torque.q1,torque.q2\n".to_string();
    for k in 0..30 {
        let [a, b] = joints(k);
        writeln!(rows, "p{k},{a},{b},0,0,0,0,0").expect("written");
    }
    write("arm.yaml", &arm([2e-5, 3e-5]));
    write("blank.csv", &rows);
    let truth = format!(
        "{HEAD}observes: [position, torque]\npayloads: {{block: {{mass: 20}}}}\n\
         measurements: {{file: blank.csv, payload: block}}\n"
    );
    write("truth.yaml", &truth);
    let loaded = load_campaign(&folder.path().join("truth.yaml").to_string_lossy(), None).expect("read");
    let found = predicted(&loaded);
    let mut rows = "pose,q1,q2,x,y,z,torque.q1,torque.q2\n".to_string();
    for (k, of) in (0..30).zip(found.predicted.chunks(3)) {
        let [a, b] = joints(k);
        let [x, y, z] = [of[0][0], of[0][1], of[0][2]].map(|value| value * 1e3);
        writeln!(rows, "p{k},{a},{b},{x:.9},{y:.9},{z:.9},{:.9},{:.9}", of[1][0], of[2][0]).expect("written");
    }
    write("readings.csv", &rows);
    write("arm.yaml", &arm([1e-5, 1e-5]));
    folder
}

#[test]
fn a_load_that_only_the_torques_show_deflects_the_joints() {
    let folder = folder();
    let identified = |loads: &str| -> Vec<f64> {
        let text = format!("{HEAD}observes: position\n{loads}measurements: readings.csv\n");
        std::fs::write(folder.path().join("c.yaml"), text).expect("written");
        let ran = run(folder.path(), &["identify", "c.yaml", "--what", "elastic", "--force", "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let json: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
        let all = json["parameters"].as_array().expect("a list");
        let value = |name: &str| {
            let own = all.iter().find(|own| own["name"] == name).unwrap_or_else(|| panic!("{name}: {all:?}"));
            own["value"].as_f64().expect("a number")
        };
        ["joint1.kar", "joint2.kar"].map(value).to_vec()
    };
    let found = identified("loads: {joints: measured}\n");
    // The readings hold the truth to the rounding of the files.
    let expected = [2e-5, 3e-5];
    assert!(found.iter().zip(expected).all(|(found, truth)| (found / truth - 1.0).abs() < 1e-6), "{found:?}");
    let described = identified("ignore: [torque.q1, torque.q2]\n");
    assert!(described.iter().zip(expected).all(|(found, truth)| (found / truth - 1.0).abs() > 0.3), "{described:?}");
}

#[test]
fn derivatives_under_measured_loads_agree_with_differences() {
    let folder = folder();
    let text = format!(
        "{HEAD}observes: [position, torque]\nloads: {{joints: measured}}\n\
         torques: {{q1: {{gain: unknown, offset: unknown}}, q2: {{gain: unknown}}}}\nmeasurements: readings.csv\n"
    );
    std::fs::write(folder.path().join("c.yaml"), text).expect("written");
    let loaded = load_campaign(&folder.path().join("c.yaml").to_string_lossy(), None).expect("read");
    let model = &loaded.robot.model;
    let names = ["torque.q1.gain", "torque.q1.offset", "torque.q2.gain", "joint1.kar", "joint2.kar"];
    let slots = names.map(|name| model.registry.slot(name).unwrap_or_else(|| panic!("{name}"))).to_vec();
    agrees(model, &loaded.campaign, slots);
}

/// Derivatives of all rows by `slots` against central differences.
fn agrees(model: &Model, campaign: &Campaign, slots: Vec<usize>) {
    let predictor = Predictor::new(model, campaign, slots.clone()).expect("a predictor").with_sag();
    let (mut at, mut up, mut down) = (Linearised::default(), Linearised::default(), Linearised::default());
    let values = model.registry.nominal();
    predictor.linearise(&values, true, &mut at).expect("linearised");
    for (column, &slot) in slots.iter().enumerate() {
        let step = 1e-4 * model.registry[slot].tolerance;
        for (step, out) in [(step, &mut up), (-step, &mut down)] {
            let mut moved = values.clone();
            moved[slot] += step;
            predictor.linearise(&moved, false, out).expect("predicted");
        }
        let ours = (0..predictor.rows()).map(|row| at.jacobian[row * slots.len() + column]);
        let differences: Vec<f64> =
            up.residual.iter().zip(&down.residual).map(|(up, down)| -(up - down) / (2.0 * step)).collect();
        let greatest = differences.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        assert!(greatest > 0.0, "{} changes nothing", model.registry[slot].name);
        for (row, (ours, difference)) in ours.zip(&differences).enumerate() {
            let near = 1e-5 * greatest + 1e-14 / step;
            assert!((ours - difference).abs() < near, "{} row {row}: {ours} {difference}", model.registry[slot].name);
        }
    }
}

#[test]
fn a_wrench_at_a_named_point_is_its_moment_at_the_measured_one() {
    let robot = load_robot("kuka-kr270").expect("bundled");
    let model = &robot.model;
    let geometry = Geometry::nominal(model).expect("assembled");
    let mut campaign = all_points(model).select(|k, _| k == 0);
    (campaign.observes, campaign.readings[0].observes) = (POSITION, POSITION);
    campaign.joints = draw_configurations(&geometry, 1, 0.7, &mut generator(9)).expect("drawn").concat();
    let force = [900.0, -400.0, -3000.0, 50.0, 20.0, -80.0];
    campaign.readings[0].wrench = force;
    let mut by_hand = campaign.clone();
    let marker = (0..model.markers.len()).find(|marker| model.markers[*marker].frame == model.tool.0).expect("one");
    campaign.readings[0].load_point = LoadPoint::Marker(Some(marker));
    let mut placements = Placements::default();
    geometry.place(by_hand.configuration(0), &mut placements).expect("placed");
    let frame = placements.frames[model.tool.0];
    let tool = (frame * geometry.tool()).translation.vector;
    let arm = (frame * Point3::from(geometry.marker(marker).coords)).coords - tool;
    assert!(arm.norm() > 0.05, "{arm}");
    let moment = arm.cross(&nalgebra::Vector3::new(force[0], force[1], force[2]));
    (0..3).for_each(|k| by_hand.readings[0].wrench[3 + k] += moment[k]);
    let at = |campaign: &Campaign| {
        let mut found = Linearised::default();
        let predictor = Predictor::new(model, campaign, Vec::new()).expect("a predictor");
        predictor.linearise(&model.registry.nominal(), false, &mut found).expect("predicted");
        found.predicted[0]
    };
    let (ours, expected) = (at(&campaign), at(&by_hand));
    assert!(ours.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12), "{ours:?} {expected:?}");
    let slots = model.free_slots().into_iter().chain(model.elastic_slots());
    // What no reading of this configuration sees has nothing to be compared.
    let moves = |slot: &usize| {
        let mut found = Linearised::default();
        let predictor = Predictor::new(model, &campaign, vec![*slot]).expect("a predictor").with_sag();
        predictor.linearise(&model.registry.nominal(), true, &mut found).expect("linearised");
        found.jacobian.iter().any(|value| value.abs() > 1e-9)
    };
    agrees(model, &campaign, slots.filter(moves).collect());
}

/// Torques of other joints, in another unit, with another sign and of other rows; sound ones, and currents whose gain is unknown.
#[test]
fn measured_torques_that_hold_nothing_described_are_doubted() {
    let folder = folder();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    // What holds bodies and block, so that the description is right.
    let truth = "observes: [position, torque]\nmeasurements: {file: blank.csv}\n";
    write("truth.yaml", &format!("{HEAD}{truth}"));
    let loaded = load_campaign(&folder.path().join("truth.yaml").to_string_lossy(), None).expect("read");
    let torques: Vec<[f64; 2]> = predicted(&loaded).predicted.chunks(3).map(|of| [of[1][0], of[2][0]]).collect();
    let text = std::fs::read_to_string(folder.path().join("readings.csv")).expect("text");
    let [header, rows @ ..] = &text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
    let spoilt = |change: &dyn Fn(usize) -> [f64; 2]| {
        let row = |(k, row): (usize, &&str)| {
            let kept: Vec<&str> = row.split(',').take(6).collect();
            let [one, two] = change(k);
            format!("{},{one},{two}\n", kept.join(","))
        };
        format!("{header}\n{}", rows.iter().enumerate().map(row).collect::<String>())
    };
    let count = torques.len();
    let all = |gains: [f64; 2]| move |[one, two]: [f64; 2]| [gains[0] * one, gains[1] * two];
    for (change, known, said) in [
        (spoilt(&|k| torques[k]), "", ""),
        (spoilt(&|k| all([1.9, 0.6])(torques[k])), "", ""),
        (spoilt(&|k| all([12.0, 1.0])(torques[k])), "torques: {q1: {gain: 12}}\n", ""),
        (spoilt(&|k| all([1.0, 8.85])(torques[k])), "", "multiples of them: `torque.q2` 8.85 times"),
        (spoilt(&|k| all([-1.0, 1.0])(torques[k])), "", "`torque.q1` 1 times, with the other sign"),
        (spoilt(&|k| [torques[k][1], torques[k][0]]), "", "`torque.q1` follows the load of `torque.q2`"),
        (spoilt(&|k| torques[(k + 11) % count]), "", "do not follow the loads of the described masses"),
    ] {
        write("spoilt.csv", &change);
        for loads in ["observes: position\nloads: {joints: measured}\n", "observes: [position, torque]\n"] {
            write("c.yaml", &format!("{HEAD}{loads}{known}measurements: spoilt.csv\n"));
            let campaign = load_campaign(&folder.path().join("c.yaml").to_string_lossy(), None).expect("read");
            let found = judge(&Evidence::of(&campaign.robot.model, &campaign.campaign), &Limits::default());
            let found: Vec<&str> =
                found.iter().map(|of| of.message.as_str()).filter(|of| of.starts_with("measured torques")).collect();
            assert!(
                if said.is_empty() { found.is_empty() } else { found.join(" ").contains(said) },
                "{said}: {found:?}"
            );
        }
    }
}

#[test]
fn wrong_words_about_loads_are_refused() {
    let folder = folder();
    let rows = "pose,q1,q2,x,y,z,fy,load_point\na,0,0,900,0,0,-10,E\nb,90,0,0,900,0,-10,TCP\n";
    std::fs::write(folder.path().join("loaded.csv"), rows).expect("written");
    let check = |text: &str| {
        std::fs::write(folder.path().join("c.yaml"), HEAD.to_string() + text).expect("written");
        run(folder.path(), &["residuals", "arm.yaml", "c.yaml"])
    };
    let sound = check("observes: position\nmeasurements: loaded.csv\n");
    assert_eq!(sound.status, 0, "{}", sound.err);
    for (text, expected) in [
        (
            "observes: position\nloads: {joints: measured}\nmeasurements: loaded.csv\n",
            "no file has a column of torques",
        ),
        ("observes: position\nloads: {joints: guessed}\nmeasurements: loaded.csv\n", "guessed"),
        ("observes: position\nloads: {joint: measured}\nmeasurements: loaded.csv\n", "joints"),
        (
            "observes: deflection\nloads: {joints: measured}\nignore: [load_point, torque.q1, torque.q2]\n\
             measurements: loaded.csv\n",
            "holds only what the wrench adds",
        ),
        (
            "observes: position\nmeasurements: {file: readings.csv, load_point: grip, ignore: [torque.q1, torque.q2]}\n",
            "no marker or frame is called `grip`",
        ),
        (
            "observes: position\nmeasurements: {file: readings.csv, load_point: ball, ignore: [torque.q1, torque.q2]}\n",
            "is not on the body of the measured point",
        ),
    ] {
        let ran = check(text);
        assert!(ran.status == 2 && ran.err.contains(expected) && ran.err.contains("help: "), "{text}: {}", ran.err);
    }
}

/// Positions and torques of the same rows, the torques also as the load, and lengths that differ from the description's: what is saved predicts
/// what was fitted.
#[test]
fn lengths_fitted_under_measured_loads_are_saved() {
    let folder = folder();
    let at = folder.path();
    let campaign = format!(
        "{HEAD}calibrate: [geometry, joint-offset, joint-compliance]\nobserves: [position, torque]\nloads: {{joints: measured}}\n\
         payloads: {{block: {{mass: 20}}}}\nmeasurements: {{file: readings.csv, payload: block}}\n"
    );
    std::fs::write(at.join("c.yaml"), campaign).expect("written");
    let text = arm([2e-5, 3e-5]).replace("d: 500", "d: 499.2");
    std::fs::write(at.join("arm.yaml"), text).expect("written");
    let ran = run(at, &["identify", "c.yaml", "--save", "found.yaml", "--force", "--format", "json"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(!ran.err.contains("could not be used"), "{}", ran.err);
    let saved = load_robot(&at.join("found.yaml").to_string_lossy()).expect("saved").model;
    let length = saved.registry.nominal()[saved.registry.slot("2.d").expect("a length")];
    assert!((length - 0.5).abs() < 2e-4, "{length}");
}
