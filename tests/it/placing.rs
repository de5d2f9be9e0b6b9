//! Where a process deflects the arm least: against a plane arm solved by hand, a scan of self-motions, and `pose --wrench`.

use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Hold, InverseSettings, Placements, Target, Transform, solve};
use elastogeo::model::Model;
use nalgebra::Vector3;
use serde_json::Value;

use super::cli::run;
use crate::support::printed_json;

fn numbers(value: &Value) -> Vec<f64> {
    let number = |v: &Value| v.as_f64().expect("a number");
    match value {
        Value::Array(all) => all.iter().map(number).collect(),
        Value::Object(all) => all.values().map(number).collect(),
        _ => panic!("{value}"),
    }
}

const PLANE: &str = "units: {length: mm, angle: deg, force: N, rotational_stiffness: N.m/rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-170, 170]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 500, limits: [-170, 170]}
  E: {antecedent: 2, d: 400}
tool: {frame: E}
joint_stiffness:
  1: {kar: {value: 20000}}
  2: {kar: {value: 5000}}
";

/// Deflection (m) of the plane arm at a point (m) under a force (N), the elbow to one side; none where it does not reach.
fn by_hand(x: f64, y: f64, force: [f64; 2], side: f64) -> Option<f64> {
    let (a, b, r) = (0.5, 0.4, x.hypot(y));
    let cosine = (r * r - a * a - b * b) / (2.0 * a * b);
    if cosine.abs() > 1.0 {
        return None;
    }
    let q2 = side * cosine.acos();
    let q1 = y.atan2(x) - (b * q2.sin()).atan2(a + b * q2.cos());
    // How the point moves as each joint turns.
    let elbow = [a * q1.cos(), a * q1.sin()];
    let turns = [[-y, x], [-(y - elbow[1]), x - elbow[0]]];
    let by = turns.iter().zip([20000.0, 5000.0]).map(|(j, k)| {
        let angle = (j[0] * force[0] + j[1] * force[1]) / k;
        [j[0] * angle, j[1] * angle]
    });
    let [dx, dy] = by.fold([0.0; 2], |sum, d| [sum[0] + d[0], sum[1] + d[1]]);
    Some(dx.hypot(dy))
}

#[test]
fn a_plane_arm_is_placed_where_it_is_by_hand() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("arm.yaml"), PLANE).expect("written");
    std::fs::write(folder.path().join("path.csv"), "x,y,z,fx,fy,fz\n600,200,0,30,-100,0\n").expect("written");
    let place = ["place", "arm.yaml", "path.csv", "--hold", "x,y"];
    let least = |x: [f64; 2], y: [f64; 2], turn: [f64; 2]| {
        let at = |[low, high]: [f64; 2], k: usize, n: usize| low + (high - low) * k as f64 / n as f64;
        let n = if turn[0] == turn[1] { 0 } else { 360 };
        let (nx, ny) = if x[0] == x[1] { (1, 1) } else { (150, 150) };
        let mut least = f64::INFINITY;
        for (i, j, k) in (0..=nx).flat_map(|i| (0..=ny).flat_map(move |j| (0..=n).map(move |k| (i, j, k)))) {
            let (sine, cosine) = at(turn, k, n.max(1)).to_radians().sin_cos();
            let force = [30.0 * cosine + 100.0 * sine, 30.0 * sine - 100.0 * cosine];
            for side in [1.0, -1.0] {
                let found = by_hand(at(x, i, nx), at(y, j, ny), force, side);
                least = least.min(found.unwrap_or(f64::INFINITY));
            }
        }
        least
    };
    let cases: [(&str, f64); 3] = [
        ("", least([0.6; 2], [0.2; 2], [0.0; 2])),
        ("x=-200:100,y=-300:200", least([0.4, 0.7], [-0.1, 0.4], [0.0; 2])),
        ("rz=-60:60", least([0.6; 2], [0.2; 2], [-60.0, 60.0])),
    ];
    for (movement, expected) in cases {
        let own = if movement.is_empty() { vec![] } else { vec!["--move", movement] };
        let found = printed_json(folder.path(), &[&place[..], &own].concat());
        let best = found["best"]["rms"].as_f64().expect("a number");
        println!("{movement}: {:.6} mm, by hand {:.6}", 1e3 * best, 1e3 * expected);
        // The grid is coarse: what is found may be a little less.
        assert!(best <= expected * (1.0 + 1e-6) && best > expected * 0.98, "{movement}: {best} {expected}");
        let q = numbers(&found["points"][0]["joints"]);
        let pose = numbers(&found["points"][0]["pose"]);
        let wrench = numbers(&found["points"][0]["wrench"]);
        let again = by_hand(pose[0], pose[1], [wrench[0], wrench[1]], q[1].signum()).expect("reached");
        assert!((again / best - 1.0).abs() < 1e-9, "{again} {best}");
        assert!(movement.is_empty() || best < 0.98 * cases[0].1, "{movement}: {best}");
    }
    // The wrench turned with the workpiece, which turned about its one point.
    let found = printed_json(folder.path(), &[&place[..], &["--move", "rz=-60:60"]].concat());
    let turn = found["moved"]["turn"][2].as_f64().expect("a number");
    let wrench = numbers(&found["points"][0]["wrench"]);
    assert!((wrench[0] - (30.0 * turn.cos() + 100.0 * turn.sin())).abs() < 1e-9, "{turn} {wrench:?}");
    // Kept out of the best place, it is somewhere worse, and out of there.
    let shift = ["--move", "x=-200:100,y=-300:200"];
    let found = printed_json(folder.path(), &[&place[..], &shift].concat());
    let [x, y] = [0, 1].map(|k| 1e3 * numbers(&found["points"][0]["pose"])[k]);
    let keep_out = format!("{}:{},{}:{},:", x - 30.0, x + 30.0, y - 30.0, y + 30.0);
    let kept = printed_json(folder.path(), &[&place[..], &shift, &["--keep-out", &keep_out]].concat());
    let [u, v] = [0, 1].map(|k| 1e3 * numbers(&kept["points"][0]["pose"])[k]);
    assert!((u - x).abs() >= 30.0 - 1e-6 || (v - y).abs() >= 30.0 - 1e-6, "{x} {y} {u} {v}");
    assert!(kept["best"]["rms"].as_f64() > found["best"]["rms"].as_f64());
}

/// Deflection of an arm with springs in its joints alone: J K^-1 J^T F, J by central differences.
fn by_springs(model: &Model, geometry: &Geometry, q: &[f64], force: &Vector3<f64>) -> f64 {
    let mut placements = Placements::default();
    let mut at = |q: &[f64]| -> Vector3<f64> {
        geometry.place(q, &mut placements).expect("placed");
        (placements.frames[model.tool.0] * geometry.tool()).translation.vector
    };
    let stiffness = [14000.0, 14000.0, 14000.0, 14000.0, 9000.0, 9000.0, 9000.0];
    let columns = stiffness.iter().enumerate().map(|(k, stiffness)| {
        let [mut more, mut less] = [q.to_vec(), q.to_vec()];
        more[k] += 1e-5;
        less[k] -= 1e-5;
        let column = (at(&more) - at(&less)) / 2e-5;
        column * (column.dot(force) / stiffness)
    });
    columns.sum::<Vector3<f64>>().norm()
}

#[test]
fn the_elbow_of_a_seven_axis_arm_is_the_best_of_a_scan() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = load_robot("franka-panda").expect("bundled").model;
    let geometry = Geometry::nominal(&model).expect("assembled");
    let q: Vec<f64> = [10.0, 20.0, 15.0, -100.0, 10.0, 110.0, 20.0].map(f64::to_radians).to_vec();
    let text = "q1,q2,q3,q4,q5,q6,q7\n10,20,15,-100,10,110,20\n";
    std::fs::write(folder.path().join("path.csv"), text).expect("written");
    let command = ["place", "franka-panda", "path.csv", "--wrench", "20,0,-60,0,0,0"];
    let found = printed_json(folder.path(), &command);
    let [given, best] = ["given", "best"].map(|key| found[key]["rms"].as_f64().expect("a number"));
    let joints = numbers(&found["points"][0]["joints"]);

    let force = Vector3::new(20.0, 0.0, -60.0);
    let mut placements = Placements::default();
    geometry.place(&q, &mut placements).expect("placed");
    let pose: Transform = placements.frames[model.tool.0] * geometry.tool();
    let target = Target { position: pose.translation.vector.into(), rotation: Some(pose.rotation), hold: Hold::POSE };
    let near = |from: &[f64]| -> Option<Vec<f64>> {
        let settings = InverseSettings { restarts: 0, from: Some(from.to_vec()), ..InverseSettings::default() };
        solve(&geometry, &target, &settings).ok()?.pop().map(|solution| solution.joints)
    };
    // Samples of all branches, each followed along its self-motion both ways by half a degree: two configurations give the way.
    let settings = InverseSettings { samples: 24, restarts: 96, ..InverseSettings::default() };
    let starts = solve(&geometry, &target, &settings).expect("reached");
    let (mut least, mut seen) = (f64::INFINITY, 0);
    for start in starts {
        for sign in [1.0, -1.0] {
            let mut last = start.joints.clone();
            let mut ahead: Vec<f64> = (0..7).map(|k| if k == 2 { sign * 0.01 } else { 0.0 }).collect();
            for _ in 0..300 {
                least = least.min(by_springs(&model, &geometry, &last, &force));
                let next: Vec<f64> = last.iter().zip(&ahead).map(|(q, by)| q + by).collect();
                let Some(next) = near(&next) else { break };
                let by: Vec<f64> = next.iter().zip(&last).map(|(a, b)| a - b).collect();
                let size = by.iter().map(|v| v * v).sum::<f64>().sqrt();
                if size < 1e-4 {
                    break;
                }
                ahead = by.iter().map(|v| v * 0.01 / size).collect();
                last = next;
                seen += 1;
            }
        }
    }
    println!("given {:.5} mm, best {:.5} mm, scan of {seen} {:.5} mm", 1e3 * given, 1e3 * best, 1e3 * least);
    assert!(seen > 500, "{seen}");
    assert!((by_springs(&model, &geometry, &q, &force) / given - 1.0).abs() < 1e-6);
    assert!((by_springs(&model, &geometry, &joints, &force) / best - 1.0).abs() < 1e-6);
    assert!(best < 0.97 * given && best <= 1.0005 * least, "{given} {best} {least}");
    // `pose --wrench` says the same of the joints.
    let written: Vec<String> = joints.iter().map(|v| format!("{:?}", v.to_degrees())).collect();
    let pose = printed_json(
        folder.path(),
        &["pose", "franka-panda", "--joints", &written.join(","), "--wrench", "20,0,-60,0,0,0"],
    );
    let claimed = numbers(&found["points"][0]["deflection"]);
    let returned = numbers(&pose["deflection"]["tool"]);
    let size = claimed.iter().map(|v| v * v).sum::<f64>().sqrt();
    assert!(claimed.iter().zip(&returned).all(|(a, b)| (a - b).abs() < 1e-9 * size), "{claimed:?} {returned:?}");
}

#[test]
fn a_placed_path_is_compensated() {
    let folder = tempfile::tempdir().expect("a folder");
    let command = [
        "place",
        "kuka-ir663",
        "ir663-strip",
        "--process",
        "ir663-strip",
        "--move",
        "x=-150:150,z=-150:150",
        "--direction",
        "z",
        "--least",
        "max",
        "--table",
        "placed.csv",
    ];
    let ran = run(folder.path(), &command);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let one = printed_json(folder.path(), &[&command[..], &["--jobs", "1"]].concat());
    let two = printed_json(folder.path(), &[&command[..], &["--jobs", "2"]].concat());
    assert_eq!(one, two);
    let [given, posture, best] = ["given", "posture", "best"].map(|key| one[key]["max"].as_f64().expect("a number"));
    assert!(posture <= given && best < 0.95 * posture, "{given} {posture} {best}");
    let points = one["points"].as_array().expect("a list");
    let most = points.iter().map(|point| numbers(&point["deflection"])[2].abs()).fold(0.0, f64::max);
    assert!((most / best - 1.0).abs() < 1e-12, "{most} {best}");
    // The path is carried as a whole: distances between its points stay.
    let strip = std::fs::read_to_string(format!("{}/processes/ir663-strip/path.csv", env!("CARGO_MANIFEST_DIR")))
        .expect("a path");
    let given: Vec<Vec<f64>> =
        strip.lines().filter_map(|line| line.split(',').map(|v| v.parse().ok()).collect()).collect();
    let placed: Vec<Vec<f64>> = points.iter().map(|point| numbers(&point["pose"])).collect();
    assert_eq!(placed.len(), 26);
    let shift = numbers(&one["moved"]["shift"]);
    assert!(shift.iter().any(|v| v.abs() > 1e-3));
    if given.len() == placed.len() {
        let first = given[0].len() - 6;
        for (a, b) in given.iter().zip(&placed) {
            assert!((0..3).all(|k| (1e-3 * a[first + k] + shift[k] - b[k]).abs() < 1e-8), "{a:?} {b:?}");
        }
    }
    let ran = run(folder.path(), &["compensate", "kuka-ir663", "placed.csv", "--nominal", "kuka-ir663"]);
    assert_eq!(ran.status, 0, "{}\n{}", ran.out, ran.err);
}

#[test]
fn wrong_questions_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    std::fs::write(path.join("arm.yaml"), PLANE).expect("written");
    std::fs::write(path.join("rigid.yaml"), PLANE.split("joint_stiffness").next().expect("text")).expect("written");
    std::fs::write(path.join("path.csv"), "x,y,z,fx,fy,fz\n600,200,0,30,-100,0\n").expect("written");
    std::fs::write(path.join("free.csv"), "x,y,z\n600,200,0\n").expect("written");
    std::fs::write(path.join("far.csv"), "x,y,z,fx,fy,fz\n-800,200,0,0,-9,0\n1200,200,0,30,-100,0\n").expect("written");
    std::fs::write(path.join("empty.csv"), "x,y,z\n").expect("written");
    let cases: &[(&str, &str, &[&str], i32, &str)] = &[
        ("arm.yaml", "path.csv", &["--move", "w=0:1"], 2, "is no direction"),
        ("arm.yaml", "path.csv", &["--move", "x=1"], 2, "name=low:high"),
        ("arm.yaml", "path.csv", &["--move", "x=10:20"], 2, "let the range hold 0"),
        ("arm.yaml", "path.csv", &["--move", "x=20:-10"], 2, "let the range hold 0"),
        ("arm.yaml", "path.csv", &["--move", "x=-1:1,x=-2:2"], 2, "given twice"),
        ("arm.yaml", "path.csv", &["--move", "rz=-200:200"], 2, "half a turn"),
        ("arm.yaml", "path.csv", &["--move", "x=nan:1"], 2, "name=low:high"),
        ("arm.yaml", "path.csv", &["--hold", "w"], 2, "is no direction"),
        ("arm.yaml", "path.csv", &["--direction", "w"], 2, "possible values"),
        ("arm.yaml", "path.csv", &["--condition", "1"], 2, "above 1"),
        ("arm.yaml", "path.csv", &["--table", "none/t.csv"], 2, "there is no folder"),
        ("arm.yaml", "path.csv", &["--keep-out", "1:2"], 2, "from and to along"),
        ("arm.yaml", "none.csv", &[], 2, "none.csv"),
        ("arm.yaml", "free.csv", &[], 2, "nothing loads the robot"),
        ("arm.yaml", "empty.csv", &[], 2, "empty.csv"),
        ("rigid.yaml", "path.csv", &[], 1, "declares nothing elastic"),
        ("arm.yaml", "far.csv", &[], 1, "point 2 of the path"),
        ("arm.yaml", "path.csv", &["--keep-out", "500:700,100:300,:"], 1, "keep_out"),
    ];
    for (robot, file, arguments, status, expected) in cases {
        let mut all = vec!["place", robot, file];
        if !arguments.contains(&"--hold") {
            all.extend(["--hold", "x,y"]);
        }
        all.extend(*arguments);
        let ran = run(path, &all);
        assert!(ran.status == *status && ran.err.contains(expected), "{all:?}: {} {}", ran.status, ran.err);
        assert_eq!(ran.out, "", "{all:?}");
    }
    // Out of reach as it is given, and not where it may go.
    let ran = run(path, &["place", "arm.yaml", "far.csv", "--hold", "x,y", "--move", "x=-1200:0"]);
    assert_eq!(ran.status, 1, "{}", ran.err);
    std::fs::write(path.join("away.csv"), "x,y,z,fx,fy,fz\n1500,200,0,30,-100,0\n").expect("written");
    let found = printed_json(path, &["place", "arm.yaml", "away.csv", "--hold", "x,y", "--move", "x=-1200:0"]);
    assert!(found["given"].is_null() && found["posture"].is_null());
    assert!(found["best"]["rms"].as_f64().is_some_and(|best| best > 0.0));
}
