//! Assembly branches: a loop never leaves the one on which it is declared without a word.

use elastogeo::kinematics::{AssemblyError, Geometry, Hold, InverseError, InverseSettings, Placements, Target, solve};
use elastogeo::model::Model;
use elastogeo::simulation::{draw_in_box, generator};

use super::cli::run;
use super::support::model_of;

/// A crank, a coupler and a follower (m) on a ground link of 1 m, declared with the crank at `at` (rad).
fn linkage([crank, coupler, follower]: [f64; 3], at: f64, [a2, b1]: [f64; 2]) -> Model {
    model_of(&format!(
        "
frames:
  a1: {{antecedent: 0, joint: revolute, variable: q1, limits: [-7, 7]}}
  a2: {{antecedent: a1, joint: revolute, passive: true, d: {crank}}}
  a3: {{antecedent: a2, d: {coupler}}}
  b0: {{antecedent: 0, d: 1.0}}
  b1: {{antecedent: b0, joint: revolute, passive: true}}
  b2: {{antecedent: b1, d: {follower}}}
loops:
  linkage: {{frames: [a3, b2], kind: planar, meet: origin, branch: {{a2: {a2}, b1: {b1}}}, at: {{q1: {at}}}}}
tool: {{frame: a3}}
"
    ))
}

/// The passive joints at a crank's angle.
fn passive(geometry: &Geometry, q: f64) -> Result<[f64; 2], AssemblyError> {
    let mut placements = Placements::default();
    geometry.place(&[q], &mut placements)?;
    Ok(["a2", "b1"].map(|name| placements.joints[geometry.model.frame(name).expect("a frame")]))
}

/// A parallelogram's coupler stays parallel to its ground link as far as the flat position; there and behind it the pose is
/// refused, whichever way it is asked for.
#[test]
fn a_parallelogram_is_followed_to_its_flat_position() {
    let model = linkage([0.4, 1.0, 0.4], 1.2, [-1.2, 1.2]);
    let geometry = Geometry::nominal(&model).expect("assembled");
    let (mut followed, mut refused) = (0, 0);
    for k in -90..=180 {
        let q = f64::from(k).to_radians();
        match passive(&geometry, q) {
            Ok([a2, b1]) => {
                assert!((a2 + q).abs() < 1e-9 && (b1 - q).abs() < 1e-9, "{k} deg: {a2} {b1}");
                assert!((4..=176).contains(&k), "{k} deg is nearly flat, or behind it");
                followed += 1;
            }
            Err(AssemblyError::Singular { name, inputs, passive, .. }) => {
                assert!(!(4..=176).contains(&k), "{k} deg is refused");
                assert_eq!((name.as_str(), inputs[0].joint.as_str(), passive.len()), ("linkage", "a1", 2));
                let flat = if k < 4 { 0.0 } else { 180.0 };
                assert!((inputs[0].value.to_degrees() - flat).abs() < 4.5, "{inputs:?}");
                refused += 1;
            }
            Err(other) => panic!("{k} deg: {other}"),
        }
    }
    assert_eq!(followed, 173);
    assert!(refused > 80);
}

/// Links that are a hair, or 0.2 %, off a parallelogram's turn into its mirror image within a few degrees: nobody knows whether the
/// real ones do.
#[test]
fn a_sharp_turn_next_to_flat_is_refused_as_well() {
    for follower in [0.39997, 0.40003, 0.3992, 0.4008] {
        let model = linkage([0.4, 1.0, follower], 1.2, [-1.2, 1.2]);
        let geometry = Geometry::nominal(&model).expect("assembled");
        for k in [-60.0, -30.0, -8.0, -1.0] {
            let found = passive(&geometry, f64::to_radians(k));
            // Next to flat a follower that is too short does not reach.
            let is_singular = matches!(found, Err(AssemblyError::Singular { .. }));
            assert!(if k < -1.0 { is_singular } else { found.is_err() }, "{follower} {k}: {found:?}");
        }
    }
}

/// A crank that may turn for ever: by the closed form on the side that is declared, in any number of turns.
#[test]
fn a_crank_rocker_is_followed_all_round() {
    let [crank, coupler, follower] = [0.3, 1.1, 0.7];
    let model = linkage([crank, coupler, follower], 0.5, [0.2, 1.4]);
    let geometry = Geometry::nominal(&model).expect("assembled");
    for k in -370..=370 {
        let q = f64::from(k).to_radians();
        let [_, b1] = passive(&geometry, q).unwrap_or_else(|error| panic!("{k}: {error}"));
        // The follower's pin sees the crank's end at this distance and angle.
        let (x, y) = (crank * q.cos() - 1.0, crank * q.sin());
        let distance = x.hypot(y);
        let cosine = (distance * distance + follower * follower - coupler * coupler) / (2.0 * distance * follower);
        let expected = y.atan2(x) - cosine.acos();
        let turn = std::f64::consts::TAU;
        let off = b1 - expected - turn * ((b1 - expected) / turn).round();
        assert!(off.abs() < 1e-8, "{k} deg: {b1} against {expected}");
    }
}

/// The parallelogram starter with a joint box that holds its flat positions, at q2 - q3 = 90 and -90 deg.
fn flat_starter() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let made = run(folder.path(), &["init", "pg", "--kind", "parallelogram"]);
    assert_eq!(made.status, 0, "{}", made.err);
    let path = folder.path().join("pg/robot.yaml");
    let text = std::fs::read_to_string(&path).expect("a file");
    let wide = text.replace("[-40, 60]", "[-70, 70]").replace("[-30, 60]", "[-70, 70]");
    assert_ne!(text, wide);
    std::fs::write(folder.path().join("flat.yaml"), wide).expect("written");
    folder
}

#[test]
fn every_command_stays_on_the_declared_branch() {
    let folder = flat_starter();
    let pose = |q: &str| run(folder.path(), &["pose", "flat.yaml", "--joints", &format!("q2={q},q3=-{q}")]);
    assert_eq!(pose("42").status, 0);
    for q in ["43", "45", "46", "50", "60"] {
        let ran = pose(q);
        assert_eq!((ran.status, ran.out.as_str()), (1, ""), "{q}");
        for word in ["loop `parallelogram`", "singular position", "`2` = 4", "`6` = -4", "`3` ="] {
            assert!(ran.err.contains(word), "{word}: {}", ran.err);
        }
    }
    let apart = |file: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(folder.path().join(file)).expect("a file");
        let mut rows = csv::Reader::from_reader(text.as_bytes());
        let header = rows.headers().expect("a header").clone();
        let column = |name: &str| header.iter().position(|known| known == name).expect("a column");
        let (two, three) = (column("q2"), column("q3"));
        rows.records()
            .map(|row| row.expect("a row"))
            .map(|row| row[two].parse::<f64>().expect("a number") - row[three].parse::<f64>().expect("a number"))
            .collect()
    };
    let simulate = ["simulate", "flat.yaml", "--poses", "60", "--seed", "3", "--errors", "1", "--into", "c"];
    let made = run(folder.path(), &simulate);
    assert_eq!(made.status, 0, "{}", made.err);
    let drawn = apart("c/measurements.csv");
    assert!(drawn.len() >= 60 && drawn.iter().all(|apart| apart.abs() < 86.5), "{drawn:?}");
    assert!(drawn.iter().any(|apart| apart.abs() > 60.0), "the box holds the flat position");
    let model =
        elastogeo::files::load_robot(&folder.path().join("flat.yaml").display().to_string()).expect("read").model;
    let geometry = Geometry::nominal(&model).expect("assembled");
    // A target that only the other branch reaches is out of reach.
    let mut placements = Placements::default();
    let within = elastogeo::simulation::joint_box(&model, 1.0);
    let (configurations, _) = draw_in_box(&geometry, &within, 6, &mut generator(5), |_, _| true);
    for q in configurations {
        geometry.place(&q, &mut placements).expect("placed");
        let tool = placements.frames[model.tool.0] * geometry.tool();
        let target =
            Target { position: tool.translation.vector.into(), rotation: Some(tool.rotation), hold: Hold::POSE };
        let settings = InverseSettings { restarts: 24, ..InverseSettings::default() };
        match solve(&geometry, &target, &settings) {
            Ok(found) => {
                assert!(found.iter().all(|one| (one.joints[1] - one.joints[2]).to_degrees().abs() < 86.5), "{found:?}");
            }
            Err(error) => assert!(!matches!(error, InverseError::Assembly(_)), "{error}"),
        }
    }
}

const PARALLELOGRAM: &str = "robot: parallelogram
units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-170, 170]}
  c: {antecedent: 1, joint: revolute, passive: true, d: 300}
  d: {antecedent: c, d: 500}
  f: {antecedent: 0, joint: revolute, passive: true, d: 500}
  fe: {antecedent: f, d: 300}
loops:
  l: {frames: [d, fe], kind: planar, meet: origin, branch: {c: -60, f: 60}, at: {q1: 60}}
tool: {frame: d}
";

/// A branch that is not given, or read wrongly, may close as another assembly: that is told. A loop is planar where both its sides are.
#[test]
fn another_assembly_and_another_plane_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let checked = |find: &str, replace: &str| {
        assert!(PARALLELOGRAM.contains(find), "{find}");
        std::fs::write(folder.path().join("r.yaml"), PARALLELOGRAM.replace(find, replace)).expect("written");
        run(folder.path(), &["check", "r.yaml"])
    };
    let sound = checked("", "");
    assert!(sound.status == 0 && !sound.err.contains("more than one way"), "{}", sound.err);
    for (branch, words) in [
        ("", "its `branch` says nothing of it, which is taken for 0.0 deg"),
        ("branch: {c: -60, f: -60}, ", "its `branch` says -60.0 deg"),
    ] {
        let ran = checked("branch: {c: -60, f: 60}, ", branch);
        assert_eq!(ran.status, 0, "{}", ran.err);
        assert!(
            ran.err.contains("loop `l` closes with joint `c` at -133.2 deg") && ran.err.contains(words),
            "{}",
            ran.err
        );
    }
    for tilt in ["alpha: 30", "beta: 30"] {
        let ran = checked("passive: true, d: 500}", &format!("passive: true, d: 500, {tilt}}}"));
        assert_eq!(ran.status, 2, "{}", ran.err);
        assert!(ran.err.contains("loop `l` is not planar") && ran.err.contains("kind: spatial"), "{}", ran.err);
    }
}
