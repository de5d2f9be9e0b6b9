//! Inclinations: what an inclinometer on a body reads, its derivatives, and what it can calibrate.

use std::fmt::Write as _;
use std::path::Path;

use elastogeo::files::{load_campaign, load_robot};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::prediction::Predictor;
use elastogeo::simulation::{draw_configurations, generator};
use nalgebra::{Rotation3, Vector3};
use rand_distr::{Distribution, StandardNormal};

use super::cli::run;
use crate::support::assert_derivatives_agree;

const NOISE: f64 = 1e-5;

/// Files of inclinometers on the forearm (mounted askew) and on the tool, of a UR5 whose second and third joint have wrong
/// zeros; from placements of the frames and a rotation of gravity, nothing else.
fn campaign(folder: &Path, angles: bool) -> String {
    let robot = load_robot("universal-ur5").expect("bundled");
    let model = &robot.model;
    let mut truth = model.registry.nominal();
    for (name, error) in [("2.theta", 2e-3), ("3.theta", -3e-3), ("5.alpha", 1e-3)] {
        truth[model.registry.slot(name).expect("a parameter")] += error;
    }
    let geometry = Geometry::new(model, &truth).expect("assembled");
    let mut random = generator(3);
    let drawn = draw_configurations(&geometry, 40, 0.6, &mut random).expect("drawn");
    let askew = Rotation3::new(Vector3::new(0.3, -0.2, 0.5));
    let mut placements = Placements::default();
    let title = if angles { "pitch,roll" } else { "gx,gy,gz" };
    let joints: Vec<&str> = model.variables.iter().map(|variable| variable.name.as_str()).collect();
    let mut files = [format!("pose,{},gx,gy,gz\n", joints.join(",")), format!("pose,{},{title}\n", joints.join(","))];
    for (pose, q) in drawn.iter().enumerate() {
        geometry.place(q, &mut placements).expect("placed");
        let forearm = model.frames.iter().position(|frame| frame.name == "3").expect("a frame");
        for (k, frame, mount) in [(0, forearm, askew), (1, model.tool.0, Rotation3::identity())] {
            let onto = placements.frames[frame].rotation * mount;
            let noise = Vector3::from_fn(|_, _| NOISE * Distribution::<f64>::sample(&StandardNormal, &mut random));
            let g = onto.inverse() * Vector3::new(0.0, 0.0, -1.0) + noise;
            let row: Vec<String> = q.iter().map(|value| format!("{:.9}", value.to_degrees())).collect();
            let read = if k == 1 && angles {
                // Rz(any) Ry(pitch) Rx(roll): the direction upwards is (-sin p, cos p sin r, cos p cos r).
                let pitch = g.x.atan2(g.y.hypot(g.z));
                format!("{:.9},{:.9}", pitch.to_degrees(), (-g.y).atan2(-g.z).to_degrees())
            } else {
                // An accelerometer's counts have any length.
                format!("{:.9},{:.9},{:.9}", 9.81 * g.x, 9.81 * g.y, 9.81 * g.z)
            };
            writeln!(files[k], "p{pose},{},{read}", row.join(",")).expect("written");
        }
    }
    std::fs::write(folder.join("forearm.csv"), &files[0]).expect("written");
    std::fs::write(folder.join("tool.csv"), &files[1]).expect("written");
    let text = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: inclination\n\
                instrument: {sigma: 0.1, orientation: 0.000573}\nestimate: {base: false, tool: false}\n\
                calibrate: [geometry]\nmeasurements:\n\
                - {file: forearm.csv, body: '3', mount: unknown}\n- {file: tool.csv}\n";
    let path = folder.join("campaign.yaml");
    std::fs::write(&path, text).expect("written");
    path.to_string_lossy().into_owned()
}

#[test]
fn zeros_of_joints_and_the_mounting_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    for angles in [false, true] {
        let path = campaign(folder.path(), angles);
        let said = run(folder.path(), &["identify", &path, "--format", "json"]);
        assert_eq!(said.status, 0, "{}", said.err);
        let json: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
        let of = |name: &str| {
            let all = json["parameters"].as_array().expect("a list");
            let own = all.iter().find(|parameter| parameter["name"] == name).unwrap_or_else(|| panic!("{name}"));
            (own["value"].as_f64().expect("a number"), own["ci95"].as_f64().expect("identified"))
        };
        let (value, ci95) = of("5.alpha");
        assert!((value - 90.0 - 1e-3_f64.to_degrees()).abs() < 2.0 * ci95 && ci95 < 0.01, "{value} +- {ci95}");
        // Turning the mounting about the forearm's joint is a zero of that joint: only the joint's axis in the sensor shows.
        let mount = |x: f64, y: f64, z: f64| Rotation3::new(Vector3::new(x, y, z)).inverse() * Vector3::z();
        let [x, y, z] = ["rx", "ry", "rz"].map(|axis| {
            let name = format!("inclinometer@3.{axis}");
            let own = json["parameters"].as_array().expect("a list").iter().find(|own| own["name"] == name.as_str());
            own.and_then(|own| own["value"].as_f64()).expect("a value").to_radians()
        });
        let off = (mount(x, y, z) - mount(0.3, -0.2, 0.5)).norm();
        assert!(off < 4.0 * NOISE, "{off}");
        let ratio = json["noise_ratio"].as_f64().expect("a number");
        assert!((0.7..1.3).contains(&ratio), "{ratio}");
    }
}

#[test]
fn derivatives_agree_with_differences() {
    let folder = tempfile::tempdir().expect("a folder");
    let loaded = load_campaign(&campaign(folder.path(), false), None).expect("read");
    let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
    let slots: Vec<usize> = (0..model.registry.all().len()).collect();
    let slots: Vec<usize> =
        slots.into_iter().filter(|&slot| model.registry[slot].group != elastogeo::parameter::Group::Elastic).collect();
    let predictor = Predictor::new(model, campaign, slots.clone()).expect("a predictor");
    let mut values = model.registry.nominal();
    // Away from the identity and from what was measured.
    for (k, &slot) in slots.iter().enumerate() {
        values[slot] += 0.05 * (k as f64).sin();
    }
    assert_eq!(predictor.rows(), 160);
    assert_derivatives_agree(model, campaign, &values, &slots);
}

#[test]
fn files_that_cannot_be_meant_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = campaign(folder.path(), false);
    let text = std::fs::read_to_string(&path).expect("read");
    for (from, to, what) in [
        ("body: '3'", "body: '33'", "the robot has no such frame"),
        ("{file: tool.csv}", "{file: tool.csv, columns: {gx: qx}}", "gx"),
    ] {
        std::fs::write(&path, text.replace(from, to)).expect("written");
        let said = run(folder.path(), &["check", &path]);
        assert_eq!(said.status, 2, "{to}: {}", said.out);
        assert!(said.err.contains(what), "{to}: {}", said.err);
    }
    std::fs::write(&path, &text).expect("written");
    let table = std::fs::read_to_string(folder.path().join("tool.csv")).expect("read");
    std::fs::write(folder.path().join("tool.csv"), table.replace("gx,gy,gz", "gx,gy,gw")).expect("written");
    let said = run(folder.path(), &["check", &path]);
    assert_eq!(said.status, 2, "{}", said.out);
    std::fs::write(
        folder.path().join("tool.csv"),
        table.lines().next().expect("a title").to_string() + "\np0,0,0,0,0,0,0,0,0,0\n",
    )
    .expect("written");
    let said = run(folder.path(), &["check", &path]);
    assert!(said.status == 2 && said.err.contains("all zero"), "{}", said.err);
}
