//! `compensate --equilibrium`: deflections at the deflected pose, and how far the linear ones are off.

use nalgebra::Vector3;

use crate::cli::run;
use crate::support::{number, printed_json};

/// A soft arm: a bar of 1 m on a torsional spring, bent far.
const SOFT: &str = "units: {length: mm, angle: deg, stiffness: N/mm, rotational_stiffness: N.mm/rad}
variables: [q1, q2]
gravity: [0, 0, 0]
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-90, 90]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 600, limits: [-120, 120]}
  E: {antecedent: 2, d: 400}
tool: {frame: E}
joint_stiffness:
  1: {kar: {value: 2e6}}
";

/// Moment and turn of the only spring, F (0.6 cos a + 0.4 cos (a + q2)) = k (a - q1): the tool is where a robot without loads
/// would be at a.
#[test]
fn commands_at_equilibrium_turn_the_soft_joint_to_where_it_should_be() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("soft.yaml"), SOFT).expect("written");
    std::fs::write(folder.path().join("path.csv"), "q1,q2\n10,20\n-20,40\n").expect("written");
    let compensate = ["compensate", "soft.yaml", "path.csv", "--nominal", "soft.yaml", "--wrench=0,200,0,0,0,0"];
    let compensate = [&compensate[..], &["--largest", "30"]].concat();
    let found = printed_json(folder.path(), &[&compensate[..], &["--equilibrium"]].concat());
    for (point, [q1, q2]) in
        found["points"].as_array().expect("points").iter().zip([[10.0_f64, 20.0_f64], [-20.0, 40.0]])
    {
        let [a, b] = [q1, q2].map(f64::to_radians);
        let turned = 200.0 * (0.6 * a.cos() + 0.4 * (a + b).cos()) / 2e3;
        assert!((number(&point["joints"]["q1"]) - (a - turned)).abs() < 1e-6, "{point}");
        assert!((number(&point["joints"]["q2"]) - b).abs() < 1e-6 && point["linear_error"].is_null());
    }
    // Linear commands are off by what is stated of them: at the equilibrium from them the tool misses by as much.
    let linear = printed_json(folder.path(), &compensate);
    for point in linear["points"].as_array().expect("points") {
        let joints = ["q1", "q2"].map(|name| number(&point["joints"][name]).to_degrees());
        let joints = format!("q1={},q2={}", joints[0], joints[1]);
        let pose = |more: &[&str]| -> Vector3<f64> {
            let pose = ["pose", "soft.yaml", "--joints", &joints, "--wrench=0,200,0,0,0,0", "--weight"];
            let found = printed_json(folder.path(), &[&pose[..], more].concat());
            let own = &found["deflection"]["tool"];
            Vector3::from_fn(|k, _| number(&own[k]))
        };
        let apart = (pose(&["--equilibrium"]) - pose(&[])).norm();
        assert!(apart > 1e-3 && (apart - number(&point["linear_error"])).abs() < 1e-9, "{apart} {point}");
    }
    let most = number(&linear["linear_error"]["max"]);
    let text = run(folder.path(), &compensate);
    assert!(text.out.contains("the linear deflection is off the equilibrium") && text.err.is_empty(), "{}", text.err);
    let warned = run(folder.path(), &[&compensate[..], &["--residual", "0.01"]].concat());
    assert!(warned.err.contains(&format!("by up to {:.4} mm", 1e3 * most)) && warned.err.contains("--equilibrium"));
    let met = run(folder.path(), &[&compensate[..], &["--residual", "0.01", "--equilibrium"]].concat());
    assert!(met.status == 0 && met.err.is_empty(), "{}", met.err);
}

/// The bundled forming path: arm and strip in balance at the deflected pose.
#[test]
fn a_process_is_met_at_equilibrium() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = "pose,x,y,z,rx,ry,rz\na,1650,0,1410,180,0,0\nb,1700,0,1400,180,0,0\nc,1850,0,1400,180,0,0\n";
    std::fs::write(folder.path().join("path.csv"), path).expect("written");
    let compensate = ["compensate", "kuka-ir663", "path.csv", "--process", "ir663-strip"];
    let found = printed_json(folder.path(), &[&compensate[..], &["--equilibrium"]].concat());
    for point in found["points"].as_array().expect("points") {
        assert!(number(&point["settled"]) < 1e-6 && number(&point["residual"]) <= 1e-7, "{point}");
    }
    let linear = printed_json(folder.path(), &compensate);
    let error = &linear["linear_error"];
    println!("IR663 under the strip: linear deflections are off by {error} m");
    assert!(number(&error["max"]) > 1e-7 && number(&error["max"]) < 1e-4, "{error}");
}

#[test]
fn rules_have_no_equilibrium_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let robot = format!(
        "{SOFT}fuzzy: {{inputs: [q1], components: {{x.fx: {{modes: [[0, 10]], conclusions: [1e-3, 2e-3]}}}}}}\n"
    );
    std::fs::write(folder.path().join("rules.yaml"), robot).expect("written");
    std::fs::write(folder.path().join("path.csv"), "q1,q2\n10,20\n").expect("written");
    let compensate = ["compensate", "rules.yaml", "path.csv", "--wrench=0,200,0,0,0,0"];
    let ran = run(folder.path(), &[&compensate[..], &["--equilibrium"]].concat());
    assert!(ran.status == 2 && ran.err.contains("linear in the load"), "{}", ran.err);
}

/// A bar on a torsional spring k, pulled at its end by F: it turns by t with k t = 0.5 F cos(q + t), and so does every marker of it, beside
/// the bar or not; a marker's lever is that of the deflected body.
#[test]
fn a_force_elsewhere_on_the_body_turns_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let robot = "units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}
variables: [q1]
gravity: [0, 0, 0]
frames: {1: {antecedent: 0, joint: revolute, variable: q1}}
tool: {frame: 1, at: [500, 0, 0]}
markers: {m: {frame: 1, at: [500, 300, 0]}}
joint_stiffness: {1: {kar: {value: 10000}}}
";
    std::fs::write(folder.path().join("bar.yaml"), robot).expect("written");
    std::fs::write(folder.path().join("path.csv"), "q1,fy,load_point,marker\n0,1000,TCP,m\n").expect("written");
    let turn = |q: f64| (0..60).fold(0.0, |t: f64, _| 0.05 * (q + t).cos());
    let arguments = ["pose", "bar.yaml", "--joints", "q1=0", "--weight", "--equilibrium", "--wrench=0,1000,0,0,0,0"];
    let found = printed_json(folder.path(), &arguments);
    for of in ["tool", "marker m"] {
        let turned = number(&found["deflection"][of][5]);
        assert!((turned - turn(0.0)).abs() < 1e-9, "{of} {turned}");
    }
    let [sin, cos] = [turn(0.0).sin(), turn(0.0).cos()];
    let at = |k: usize| number(&found["markers"]["m"][k]);
    assert!((at(0) - 0.5 * cos + 0.3 * sin).abs() < 1e-9 && (at(1) - 0.5 * sin - 0.3 * cos).abs() < 1e-9, "{found}");
    let arguments = ["compensate", "bar.yaml", "path.csv", "--nominal", "bar.yaml", "--equilibrium", "--hold", "y"];
    let found = printed_json(folder.path(), &arguments);
    let q = number(&found["points"][0]["joints"]["q1"]);
    let all = q + turn(q);
    assert!((0.5 * all.sin() + 0.3 * all.cos() - 0.3).abs() < 1e-8, "{found}");
}
