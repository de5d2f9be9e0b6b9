//! Torques of the joints: what a motor supplies, against the potential energy of masses and springs, and sensors with gain and
//! offset.

use crate::real_data::folder;
use std::fmt::Write as _;
use std::path::Path;

use elastogeo::files::{load_campaign, load_robot};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::simulation::{draw_configurations, generator};
use nalgebra::Point3;

use super::cli::run;

const ARM: &str = "robot: two-joint arm\nunits: {length: mm, angle: deg}\nvariables: [q1, q2]\ngravity: [0, -9.81, 0]\nframes:\n\
                   \x20 1: {antecedent: 0, joint: revolute, variable: q1, limits: [-120, 120]}\n\
                   \x20 2: {antecedent: 1, joint: revolute, variable: q2, d: 500, limits: [-120, 120]}\n\
                   \x20 E: {antecedent: 2, d: 400}\ntool: {frame: E}\n\
                   bodies:\n  1: {mass: 8, com: [250, 0, 0]}\n  2: {mass: 4, com: [150, 0, 0]}\n";

/// An arm in the plane: angles (deg), then torques that hold it, from the formula of a textbook, with a payload of 3 kg at the
/// tool in every second row.
fn held(q: [f64; 2], payload: f64, upper: f64) -> [f64; 2] {
    let [a, b] = [q[0].to_radians(), (q[0] + q[1]).to_radians()];
    let forearm = 9.81 * (4.0 * 0.15 + payload * 0.4) * b.cos();
    [9.81 * (8.0 * 0.25 + (4.0 + payload) * upper) * a.cos() + forearm, forearm]
}

fn campaign(folder: &Path, torques: &str) -> String {
    campaign_of(folder, torques, 0.5)
}

/// Readings of an arm whose upper arm has this length, m.
fn campaign_of(folder: &Path, torques: &str, upper: f64) -> String {
    std::fs::write(folder.join("arm.yaml"), ARM).expect("written");
    let mut table = "pose,q1,q2,torque.q1,torque.q2,x,y,z,payload\n".to_string();
    for k in 0..24 {
        let q = [-100.0 + 8.0 * f64::from(k), 90.0 - 37.0 * f64::from(k % 5)];
        let payload = if k % 2 == 0 { 0.0 } else { 3.0 };
        let [one, two] = held(q, payload, upper);
        let [a, b] = [q[0].to_radians(), (q[0] + q[1]).to_radians()];
        let length = 1e3 * upper;
        let (x, y) = (length * a.cos() + 400.0 * b.cos(), length * a.sin() + 400.0 * b.sin());
        let name = if k % 2 == 0 { "none" } else { "block" };
        // The first sensor is a motor current: 0.8 A per N.m, and 1.5 A without load.
        writeln!(table, "p{k},{},{},{:.9},{two:.9},{x:.6},{y:.6},0,{name}", q[0], q[1], 0.8 * one + 1.5)
            .expect("written");
    }
    std::fs::write(folder.join("readings.csv"), table).expect("written");
    let text = format!(
        "robot: arm.yaml\nunits: {{length: mm, angle: deg}}\nobserves: [position, torque]\n\
         instrument: {{sigma: 0.05, torque: 0.1}}\ncalibrate: [geometry]\n\
         payloads: {{block: {{mass: 3}}}}\n{torques}measurements: readings.csv\n"
    );
    let path = folder.join("campaign.yaml");
    std::fs::write(&path, text).expect("written");
    path.to_string_lossy().into_owned()
}

#[test]
fn gain_and_offset_of_a_current_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = campaign(folder.path(), "torques: {q1: {gain: unknown, offset: unknown}}\n");
    let loaded = load_campaign(&path, None).expect("read");
    let torques: Vec<_> =
        loaded.campaign.readings.iter().filter(|reading| reading.observes.name() == "torque").collect();
    assert_eq!((loaded.campaign.readings.len(), torques.len()), (72, 48));
    for pair in torques.chunks(2) {
        let q = loaded.campaign.configuration(pair[0].row * 3 - 2);
        let payload = pair[0].payload.map_or(0.0, |payload| payload.mass);
        let expected = held([q[0].to_degrees(), q[1].to_degrees()], payload, 0.5);
        for (reading, expected) in pair.iter().zip(expected) {
            assert!((reading.load - expected).abs() < 1e-9, "{} where {expected} holds", reading.load);
        }
    }
    let said = run(folder.path(), &["identify", &path, "--format", "json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let json: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let value = |name: &str| {
        let own = json["parameters"].as_array().expect("a list").iter().find(|parameter| parameter["name"] == name);
        own.and_then(|own| own["value"].as_f64()).unwrap_or_else(|| panic!("{name}"))
    };
    assert!((value("torque.q1.gain") - 0.8).abs() < 1e-6 && (value("torque.q1.offset") - 1.5).abs() < 1e-5);
    assert!(json["residuals"]["check_after"]["load"]["rms"].as_f64().expect("a figure") < 1e-6);
    // A diagnosis takes the positions alone.
    let said = run(folder.path(), &["diagnose", &path]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(!said.out.contains("torques and forces are"), "{}", said.out);
}

/// Loads are those of the lengths that the same fit finds: with those of the description the gain would be half a percent off.
#[test]
fn loads_are_those_of_the_fitted_lengths() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = campaign_of(folder.path(), "torques: {q1: {gain: unknown, offset: unknown}}\n", 0.505);
    let said = run(folder.path(), &["identify", &path, "--save", "found.yaml", "--format", "json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let json: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let all = json["parameters"].as_array().expect("a list");
    let value = |name: &str| {
        let own = all.iter().find(|own| own["name"] == name).and_then(|own| own["value"].as_f64());
        own.unwrap_or_else(|| panic!("{name}"))
    };
    assert!((value("torque.q1.gain") - 0.8).abs() < 1e-6, "{}", value("torque.q1.gain"));
    assert!((value("torque.q1.offset") - 1.5).abs() < 1e-5, "{}", value("torque.q1.offset"));
    // What is read back has the same lengths, and so the same loads.
    let said = run(folder.path(), &["identify", &path, "--robot", "found.yaml", "--format", "json"]);
    let again: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let own = again["parameters"].as_array().expect("a list").iter().find(|own| own["name"] == "torque.q1.gain");
    assert!((own.and_then(|own| own["value"].as_f64()).expect("a gain") - 0.8).abs() < 1e-6, "{}", said.out);
}

#[test]
fn wrong_torques_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (torques, what) in [
        ("torques: {q3: {gain: unknown}}\n", "no variable of the robot"),
        ("torques: {q1: {gain: 0}}\n", "and not 0"),
        ("torques: {q1: {gains: 1}}\n", "gains"),
        ("ignore: [torque.q1, torque.q2]\n", "no joint has a column"),
    ] {
        let said = run(folder.path(), &["check", &campaign(folder.path(), torques)]);
        assert!(said.status == 2 && said.err.contains(what), "{torques}: {}", said.err);
    }
    let said =
        run(folder.path(), &["simulate", "universal-ur5", "--poses", "5", "--observes", "torque", "--into", "t"]);
    assert_eq!(said.status, 2, "{}", said.out);
}

/// The KR-270 with its compensator: the holding torque is the slope of the potential energy.
#[test]
fn holding_torques_are_slopes_of_the_potential() {
    let robot = load_robot("kuka-kr270").expect("bundled");
    let model = &robot.model;
    let geometry = Geometry::nominal(model).expect("assembled");
    let values = model.registry.nominal();
    let value = |name: &str| values[model.registry.slot(name).unwrap_or_else(|| panic!("{name}"))];
    let mut placements = Placements::default();
    let mut potential = |q: &[f64]| {
        geometry.place(q, &mut placements).expect("placed");
        let mut energy = 0.0;
        for mass in &model.structure.masses {
            let own = &values[mass.slot..mass.slot + 4];
            let at = placements.frames[mass.frame] * Point3::new(own[1], own[2], own[3]);
            energy -= own[0] * model.structure.gravity.dot(&at.coords);
        }
        for spring in &model.structure.springs {
            let anchor = |k: usize| {
                let [x, y, z] = [0, 1, 2].map(|axis| values[spring.slots[2 + 3 * k + axis]]);
                placements.frames[spring.spring.bodies[k]] * Point3::new(x, y, z)
            };
            let length: f64 = (anchor(1) - anchor(0)).norm();
            energy += 0.5 * value("compensator.stiffness") * (length - value("compensator.free_length")).powi(2);
        }
        energy
    };
    let folder = tempfile::tempdir().expect("a folder");
    let drawn = draw_configurations(&geometry, 6, 0.7, &mut generator(4)).expect("drawn");
    let names: Vec<&str> = model.variables.iter().map(|variable| variable.name.as_str()).collect();
    let titles: Vec<String> = names.iter().map(|name| format!("torque.{name}")).collect();
    let mut table = format!("{},{}\n", names.join(","), titles.join(","));
    for q in &drawn {
        let row: Vec<String> = q.iter().map(|v| format!("{v:.15}")).collect();
        writeln!(table, "{},0,0,0,0,0,0", row.join(",")).expect("written");
    }
    std::fs::write(folder.path().join("t.csv"), table).expect("written");
    let text = "robot: kuka-kr270\nunits: {length: m, angle: rad}\nobserves: torque\nmeasurements: t.csv\n";
    let path = folder.path().join("c.yaml");
    std::fs::write(&path, text).expect("written");
    let loaded = load_campaign(&path.to_string_lossy(), None).expect("read");
    assert_eq!(loaded.campaign.readings.len(), 36);
    for (reading, of) in loaded.campaign.readings.iter().zip(0..) {
        let q = loaded.campaign.configuration(of).to_vec();
        let variable = of % 6;
        let slope = {
            let at = |step: f64, potential: &mut dyn FnMut(&[f64]) -> f64| {
                let mut moved = q.clone();
                moved[variable] += step;
                potential(&moved)
            };
            (at(1e-4, &mut potential) - at(-1e-4, &mut potential)) / 2e-4
        };
        assert!((reading.load - slope).abs() < 1e-4 * slope.abs().max(10.0), "{of}: {} {slope}", reading.load);
    }
}

/// Torques that an iiwa 7 measured: its own sensors have a gain near 1 against masses whose centres came from them.
#[test]
fn torques_of_a_real_arm() {
    let Some(data) = folder("iiwa7-payload") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let data = Path::new(&data).canonicalize().expect("a folder");
    let unknown: Vec<String> = (2..7).map(|k| format!("q{k}: {{gain: unknown, offset: unknown}}")).collect();
    let text = format!(
        "robot: {0}/robot.yaml\nunits: {{length: mm, angle: rad}}\nobserves: [pose, torque]\n\
         instrument: {{sigma: 0.3, orientation: 1.0e-3, torque: 1}}\nestimate: {{base: true, tool: true}}\ntorques: {{{1}}}\nmeasurements: {0}/unloaded.csv\n",
        data.display(),
        unknown.join(", ")
    );
    let path = folder.path().join("campaign.yaml");
    std::fs::write(&path, text).expect("written");
    let said = run(folder.path(), &["identify", &path.to_string_lossy(), "--format", "json"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let json: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert!(json["residuals"]["check_after"]["load"]["rms"].as_f64().expect("N.m") < 0.35);
    for k in 2..7 {
        let name = format!("torque.q{k}.gain");
        let own = json["parameters"].as_array().expect("a list").iter().find(|own| own["name"] == name.as_str());
        let gain = own.and_then(|own| own["value"].as_f64()).expect("estimated");
        // It reports what the load does to the joint.
        assert!((gain + 1.0).abs() < 0.02, "{name} {gain}");
    }
}

/// Torques say nothing of where a robot stands: they are not the scale of what is far off in its registration.
#[test]
fn torques_decide_nothing_of_a_registration() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = campaign(folder.path(), "torques: {q1: {gain: unknown, offset: unknown}}\n");
    let text = std::fs::read_to_string(&path).expect("read");
    let placed = |text: &str| text.replace("calibrate: [geometry]", "estimate: {base: true, tool: false}");
    std::fs::write(&path, placed(&text)).expect("written");
    let said = run(folder.path(), &["register", &path, "--format", "json"]);
    assert_eq!(said.status, 0, "{}{}", said.out, said.err);
    let json: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert!(!json["diagnostics"].to_string().contains("outlying-readings"), "{}", json["diagnostics"]);
}
