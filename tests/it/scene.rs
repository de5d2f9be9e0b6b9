//! The robot as it is drawn, and its stiffness over a slice of its workspace.

use elastogeo::kinematics::Placements;
use elastogeo::review::slice;
use elastogeo::state::{Loads, Mechanics};
use nalgebra::{Matrix2, Vector2};
use serde_json::Value;

use crate::cli::run;
use crate::support::{model_of, numbers};

fn view(arguments: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run(folder.path(), &[&["view", "--format", "json"], arguments].concat());
    assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
    serde_json::from_str(&ran.out).expect("JSON")
}

fn parts<'v>(view: &'v Value, kind: &str) -> Vec<&'v Value> {
    view["parts"].as_array().expect("parts").iter().filter(|part| part["kind"] == kind).collect()
}

/// Points of a part, m.
fn points(view: &Value, part: &Value) -> Vec<Vec<f64>> {
    let at = |k: &Value| numbers(&view["points"][k.as_u64().expect("an index") as usize]);
    part["points"].as_array().expect("points").iter().map(at).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn every_bundled_robot_is_drawn_where_pose_puts_it() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, joints) in [
        ("kuka-ir663", "q1=30,stroke2=800,stroke8=760,q5=40"),
        ("kuka-kr270", "q1=20,q2=-60,q3=80,q5=30"),
        ("universal-ur5", "q1=10,q2=-40,q3=50"),
        ("universal-ur10", "q2=-40"),
        ("barrett-wam", "q2=40,q4=60"),
        ("franka-panda", "q2=20,q4=-90,q6=90"),
        ("scara-rail", "rail=700,q1=30,q2=60,down=50"),
        ("palletiser", "q1=20,q2=30,q3=10"),
        ("five-bar", "q1=130,q2=70"),
        ("hexapod", "s1=120,s2=110,s3=130,s4=100,s5=120,s6=90"),
    ] {
        let shown = view(&[robot, "--joints", joints]);
        let pose = run(folder.path(), &["pose", robot, "--joints", joints, "--format", "json"]);
        let pose: Value = serde_json::from_str(&pose.out).expect("JSON");
        for part in parts(&shown, "joint").into_iter().chain(parts(&shown, "frame")) {
            let frame = &pose["frames"][part["name"].as_str().expect("a name")];
            if frame.is_null() {
                continue;
            }
            let origin: Vec<f64> = (0..3).map(|i| frame[i][3].as_f64().expect("a number")).collect();
            assert!(apart(&points(&shown, part)[0], &origin) < 1e-12, "{robot}: {}", part["words"]);
        }
        for link in parts(&shown, "link") {
            // A body's polyline is as long as its Khalil-Kleinfinger lengths, and ends where the next frame stands.
            assert!(points(&shown, link).len() >= 2, "{robot}");
        }
        for cut in parts(&shown, "cut") {
            let ends = points(&shown, cut);
            assert!(apart(&ends[0], &ends[1]) < 1e-9, "{robot}: the loop is closed");
        }
        for marker in parts(&shown, "marker") {
            let told = numbers(&pose["markers"][marker["name"].as_str().expect("a name")]);
            assert!(apart(&points(&shown, marker)[1], &told) < 1e-12, "{robot}");
        }
    }
}

#[test]
fn actuators_are_as_long_as_their_strokes_and_beams_as_wide_as_their_sections() {
    let shown = view(&["kuka-ir663", "--joints", "q1=30,stroke2=800,stroke8=760"]);
    for (actuator, length) in parts(&shown, "actuator").into_iter().zip([0.8, 0.76]) {
        let ends = points(&shown, actuator);
        assert!((apart(&ends[0], &ends[1]) - length).abs() < 1e-12, "{}", actuator["name"]);
    }
    let beams = parts(&shown, "beam");
    assert_eq!(beams.len(), 6);
    // The link, a box of 300 x 250 mm: width along local y, height along local z, from joint to joint 1047 mm.
    let corners = points(&shown, beams[1]);
    assert_eq!(corners.len(), 8);
    assert!((apart(&corners[0], &corners[1]) - 0.3).abs() < 1e-12);
    assert!((apart(&corners[1], &corners[2]) - 0.25).abs() < 1e-12);
    assert!((apart(&corners[0], &corners[4]) - 1.047).abs() < 1e-12);
}

#[test]
fn deflection_is_that_of_the_stiffness_command() {
    let folder = tempfile::tempdir().expect("a folder");
    for (robot, joints) in [("kuka-kr270", "q2=-60,q3=90,q5=20"), ("kuka-ir663", "stroke2=800,stroke8=760,q5=40")] {
        for weight in [&[][..], &["--weight"]] {
            let asked = [&["--joints", joints, "--wrench", "300,-200,-2500,10,20,30"], weight].concat();
            let shown = view(&[&[robot], asked.as_slice()].concat());
            let other = run(folder.path(), &[&["stiffness", robot, "--format", "json"], asked.as_slice()].concat());
            let other: Value = serde_json::from_str(&other.out).expect("JSON");
            let told = numbers(&other["deflection"]);
            for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
                let own = shown["deflection"][axis].as_f64().expect("a number");
                assert!((own - 1e3 * told[k]).abs() < 1e-9, "{robot} {weight:?} {axis}: {own} {}", told[k]);
            }
            // Nodes of beams move with the corners about them.
            if robot == "kuka-ir663" {
                let node = numbers(&other["nodes"]["n3"])[..3].to_vec();
                let beam = parts(&shown, "beam")[1];
                let far: Vec<Vec<f64>> = beam["points"].as_array().expect("points")[4..]
                    .iter()
                    .map(|k| numbers(&shown["moved"][k.as_u64().expect("an index") as usize]))
                    .collect();
                let mean: Vec<f64> = (0..3).map(|k| far.iter().map(|p| p[k]).sum::<f64>() / 4.0).collect();
                assert!(apart(&mean, &node) < 1e-12, "{mean:?} {node:?}");
            }
        }
    }
}

#[test]
fn pages_and_drawings_are_well_formed() {
    let folder = tempfile::tempdir().expect("a folder");
    for robot in ["kuka-ir663", "kuka-kr270", "barrett-wam"] {
        let ran = run(folder.path(), &["view", robot, "--output", "v.html", "--svg", "v.svg", "--look", "30,15"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
        let svg = read("v.svg");
        let document = roxmltree::Document::parse(&svg).expect("XML");
        let numbers = document.descendants().filter(|node| node.has_tag_name("line"));
        let inside = |value: &str| value.parse::<f64>().is_ok_and(|v| (-60.0..960.0).contains(&v));
        let lines: Vec<_> = numbers.collect();
        assert!(
            lines.len() > 15
                && lines.iter().all(|line| ["x1", "x2"].iter().all(|k| line.attribute(*k).is_some_and(inside)))
        );
        let html = read("v.html");
        for forbidden in ["http://", "https://", "<link", " src=", "url(", "class=\"fault\""] {
            assert!(!html.contains(forbidden), "{robot}: {forbidden}");
        }
        let data = html.split("id=\"scene\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("data");
        assert!(serde_json::from_str::<Value>(data).expect("JSON")["parts"].is_array());
    }
}

/// Two springs in a plane: at the tip, c1 u1 u1' + c2 u2 u2' with u the lever of each joint.
#[test]
fn the_slice_of_a_planar_arm_is_the_analytic_one() {
    let model = model_of(
        "units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, alpha: -90, limits: [-80, 80]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 500, limits: [20, 140]}
  E: {antecedent: 2, d: 400}
tool: {frame: E}
joint_stiffness:
  1: {kar: {compliance: 1.0e-6}}
  2: {kar: {compliance: 3.0e-6}}
",
    );
    let loads = Loads { weight: false, wrench: true };
    let mechanics = Mechanics::new(&model, &model.registry.nominal(), loads, &[]).expect("assembled");
    let geometry = &mechanics.geometry;
    let found = slice(&mechanics, &[0.3, 0.8]).expect("a slice");
    assert_eq!(found.swept, [0, 1]);
    let mut seen = 0;
    for node in found.nodes.iter().flatten().flatten() {
        let mut placements = Placements::default();
        geometry.place(&node.q, &mut placements).expect("assembled");
        let at = |frame: usize| placements.frames[frame].translation.vector;
        let tip = at(3);
        let mut sum = Matrix2::zeros();
        for (joint, compliance) in [(1, 1e-6), (2, 3e-6)] {
            let arm = tip - at(joint);
            let lever = Vector2::new(arm.z, -arm.x);
            sum += lever * lever.transpose() * compliance;
        }
        let (half, rest) = (0.5 * sum.trace(), (0.25 * sum.trace().powi(2) - sum.determinant()).max(0.0).sqrt());
        assert!((node.least * (half + rest) - 1.0).abs() < 1e-9, "{} {}", node.least, 1.0 / (half + rest));
        assert!((node.at[0] - tip.x.abs()).abs() < 1e-12 && (node.at[1] - tip.z).abs() < 1e-12);
        // The greater axis of the ellipse is the greatest compliance, of a force in the plane.
        let longest = node.ellipse.iter().map(|axis| axis[0].hypot(axis[1])).fold(0.0, f64::max);
        assert!((longest / (half + rest) - 1.0).abs() < 1e-9);
        seen += 1;
    }
    assert!(seen > 500, "{seen}");
    // A line of equal stiffness lies where neighbours lie on both sides of it.
    let level = found.nodes[12][12].as_ref().expect("a node").least * 1.01;
    assert!(!found.iso(level).is_empty());
}
