//! Compensation: single predictions are those of campaigns, derivatives are those of differences, identified robots pass
//! where they should as far as they were identified, and what cannot be done is refused by number.

use std::path::Path;

use elastogeo::compensation::{Desired, Hold, Refusal, Settings, compensate, predict_path};
use elastogeo::description::campaign::Campaign;
use elastogeo::description::raw::RawEffect;
use elastogeo::files::{Reader, load_robot};
use elastogeo::kinematics::{Geometry, Transform, rotation_vector};
use elastogeo::model::Model;
use elastogeo::observation::POSE;
use elastogeo::prediction::SinglePredictor;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use nalgebra::{Rotation3, Vector3, Vector6};
use serde_json::Value;

use crate::cli::{PLANAR, run};
use crate::figures::recorded;
use crate::support::{KR270_MASSES, bundled, heavy_kr270, model_of, nominal_path, switch_on};

fn heavy() -> Model {
    let folder = tempfile::tempdir().expect("a folder");
    load_robot(&heavy_kr270(folder.path(), KR270_MASSES)).expect("a robot").model
}

const WRENCH: [f64; 6] = [300.0, -500.0, -1500.0, 100.0, -50.0, 80.0];

fn measured(model: &Model, values: &[f64], count: usize, seed: u64) -> Campaign {
    let mut random = generator(seed);
    let geometry = Geometry::new(model, values).expect("assembled");
    let plan = Plan {
        conditions: true,
        wrenches: vec![WRENCH],
        configurations: draw_configurations(&geometry, count, 0.5, &mut random).expect("drawn"),
        markers: vec![None, Some(0)],
        repeats: 1,
        observes: POSE,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    simulate(model, values, &plan, &mut random).expect("simulated")
}

/// Robots with what each could have: errors, load, own weight, a base elsewhere, effects.
fn cases() -> Vec<(Model, Vec<f64>)> {
    let mut kr270 = heavy();
    switch_on(&mut kr270, "gear-ratio", "joint:3", &[("ratio", 4e-4)]);
    switch_on(&mut kr270, "backlash", "joint:1", &[("half_width", 3e-4), ("changes_at", 0.0)]);
    let mut ir663 = bundled("kuka-ir663");
    switch_on(&mut ir663, "thermal-expansion", "link:3", &[("expansion", 2e-5)]);
    [kr270, ir663]
        .into_iter()
        .map(|model| {
            let mut values = draw_errors(&model, 0.3, 0.3, &mut generator(5));
            (0..6).for_each(|k| values[model.base + k] += 0.1 * (k + 1) as f64);
            (model, values)
        })
        .collect()
}

#[test]
fn single_predictions_are_those_of_campaigns() {
    for (model, values) in cases() {
        let campaign = measured(&model, &values, 12, 8);
        let predictor = SinglePredictor::new(&model, &values, &campaign).expect("assembled");
        let mut work = predictor.workspace();
        for (index, reading) in campaign.readings.iter().enumerate() {
            predictor.place(campaign.configuration(index), &mut work).expect("placed");
            let seen = predictor.see(index, &reading.wrench, &mut work).expect("seen");
            let found = predictor.geometry().base() * seen.real;
            let v = &reading.measured;
            let moved = found.translation.vector - Vector3::new(v[0], v[1], v[2]);
            let rotation = Rotation3::new(Vector3::new(v[3], v[4], v[5]));
            let turned = rotation_vector(&(rotation * found.rotation.inverse()));
            assert!(moved.norm() < 1e-12 && turned.norm() < 1e-12, "{}: {moved:?} {turned:?}", model.name);
            let sum = seen.rigid.translation.vector + seen.by_weight + seen.by_wrench + seen.by_effects();
            assert!((sum - seen.real.translation.vector).norm() < 1e-12);
            assert!(seen.by_wrench.norm() > 1e-4 && seen.by_weight.norm() > 1e-5 && seen.by_effects().norm() > 1e-7);
        }
    }
}

#[test]
fn derivatives_by_variables_are_those_of_differences() {
    for (mut model, values) in cases() {
        // Effects are no part of the derivative.
        model.effects.clear();
        let campaign = measured(&model, &values, 6, 9);
        let predictor = SinglePredictor::new(&model, &values, &campaign).expect("assembled");
        let mut work = predictor.workspace();
        for (index, reading) in campaign.readings.iter().enumerate() {
            let q = campaign.configuration(index).to_vec();
            let mut at = |q: &[f64]| {
                predictor.place(q, &mut work).expect("placed");
                predictor.see(index, &reading.wrench, &mut work).expect("seen").real
            };
            let step = 1e-5;
            let differences: Vec<Vector6<f64>> = (0..q.len())
                .map(|k| {
                    let [mut up, mut down] = [q.clone(), q.clone()];
                    up[k] += step;
                    down[k] -= step;
                    let (up, down) = (at(&up), at(&down));
                    let moved = up.translation.vector - down.translation.vector;
                    let turned = rotation_vector(&(up.rotation * down.rotation.inverse()));
                    Vector6::new(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z) / (2.0 * step)
                })
                .collect();
            predictor.place(&q, &mut work).expect("placed");
            let seen = predictor.see(index, &reading.wrench, &mut work).expect("seen");
            let mut away = [0.0_f64; 2];
            for (elastic, away) in [false, true].into_iter().zip(&mut away) {
                predictor.differentiate(index, &reading.wrench, &seen, elastic, &mut work);
                for (column, difference) in work.jacobian.iter().zip(&differences) {
                    *away = away.max((Vector6::from(*column) - difference).norm() / difference.norm());
                }
            }
            assert!(away[1] < 1e-7, "{}: {away:?}", model.name);
            assert!(away[0] > 1e-5, "the deflection counts: {away:?}");
        }
    }
}

#[test]
fn a_rigid_perfect_robot_is_left_alone_and_a_redundant_one_moves_least() {
    let ur5 = bundled("universal-ur5");
    let (path, desired) = nominal_path(&ur5, &[vec![0.3, -1.0, 1.2, 0.4, 0.9, 0.1]]);
    let settings = Settings::new(6);
    let found = compensate(&ur5, &ur5.registry.nominal(), &path, &desired, None, &settings).expect("assembled");
    let point = found.points[0].as_ref().expect("done");
    assert_eq!(&point.corrected.joints, &desired[0].as_ref().expect("a point").nominal);
    assert_eq!(point.corrected.iterations, 0);

    let wam = bundled("barrett-wam");
    let q = vec![0.1, 0.5, -0.2, 1.3, 0.2, 0.4, 0.3];
    let (path, desired) = nominal_path(&wam, std::slice::from_ref(&q));
    let values = draw_errors(&wam, 1.0, 0.0, &mut generator(3));
    let found = compensate(&wam, &values, &path, &desired, None, &Settings::new(7)).expect("assembled");
    let point = found.points[0].as_ref().expect("done");
    assert!(point.corrected.position < 1e-7 && point.corrected.orientation < 1e-7);
    assert!(point.corrected.joints.iter().zip(&q).all(|(a, b)| (a - b).abs() < 0.05));
}

/// What is not held stays free: a spindle turns as it likes, and the correction is smaller for it.
#[test]
fn less_is_corrected_where_less_is_held() {
    let (mut model, values) = cases().remove(0);
    model.effects.clear();
    let (path, desired) = nominal_path(&model, &[vec![0.3, -1.0, 1.2, 0.4, 0.9, 0.1]]);
    let mut moved = Vec::new();
    for hold in [Hold::POSE, Hold::AXIS, Hold::POSITION] {
        let settings = Settings { hold, ..Settings::new(6) };
        let mut values = values.clone();
        (0..6).for_each(|k| values[model.base + k] = 0.0);
        let found = compensate(&model, &values, &path, &desired, None, &settings).expect("assembled");
        let point = found.points[0].as_ref().expect("done");
        assert!(point.corrected.position < 1e-7, "{hold:?}");
        let nominal = &desired[0].as_ref().expect("a point").nominal;
        moved.push(point.corrected.joints.iter().zip(nominal).map(|(a, b)| (a - b).powi(2)).sum::<f64>());
    }
    assert!(moved[0] > moved[1] && moved[1] > moved[2], "{moved:?}");
}

/// The true robot of a simulated campaign, as `truth.json` records it.
fn true_arm(mut model: Model, truth: &Path) -> Model {
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(truth).expect("a file")).expect("JSON");
    for (name, value) in truth["parameters"].as_object().expect("parameters") {
        let slot = model.registry.slot(name).expect("a parameter");
        model.registry.all_mut()[slot].nominal = value["true"].as_f64().expect("a number");
    }
    let effects: Vec<RawEffect> = serde_json::from_value(truth["effects"].clone()).expect("effects");
    for raw in &effects {
        let entry = model.resolve_effect(raw).expect("an effect of this robot");
        model.switch_on(entry);
    }
    model
}

/// Greatest and rms distance (m) of the true robot from targets at commands.
fn passes(arm: &Model, commands: &Path, targets: &[Transform], wrench: [f64; 6], nominal: &str) -> [f64; 2] {
    let loaded = load_robot(nominal).expect("a robot");
    let path = Reader::default().path(&commands.display().to_string(), &loaded, loaded.raw.units).expect("a path");
    let mut campaign = path.campaign;
    campaign.readings.iter_mut().for_each(|reading| reading.wrench = wrench);
    // The true arm lies on the flank it came from, taken here from the commands' own steps: the upper one where they fall.
    for k in 0..campaign.variables {
        let step = |row: usize| campaign.configuration(row)[k] - campaign.configuration(row - 1)[k];
        let sides: Vec<f64> = (0..campaign.readings.len()).map(|row| -step(row.max(1)).signum()).collect();
        campaign.conditions.set_sides(k, sides);
    }
    let desired: Vec<Result<Desired, Refusal>> = targets
        .iter()
        .enumerate()
        .map(|(row, target)| Ok(Desired { nominal: campaign.configuration(row).to_vec(), target: *target }))
        .collect();
    let seen = predict_path(arm, &arm.registry.nominal(), &mut campaign, &desired, None, &Settings::new(6))
        .expect("assembled");
    let away: Vec<f64> = seen
        .into_iter()
        .zip(targets)
        .map(|(found, target)| (found.expect("seen").seen.real.translation.vector - target.translation.vector).norm())
        .collect();
    let rms = (away.iter().map(|a| a * a).sum::<f64>() / away.len() as f64).sqrt();
    [away.iter().copied().fold(0.0, f64::max), rms]
}

struct Machine<'a> {
    arm: &'a str,
    robot: &'a str,
    markers: &'a str,
    /// Springs of the true arm against the description's.
    springs: &'a str,
    effect: &'a str,
    /// First point (mm), which way it goes, and the tool's rotation vector (deg).
    path: ([f64; 3], [f64; 3], [f64; 3]),
}

/// Springs from deflections, then geometry and one effect from poses, then the path: on the true arm, which the commands
/// have never seen, the error falls to what the identification leaves, below the noise of one coordinate (0.03 mm).
fn identified_then_compensated(machine: &Machine) {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    heavy_kr270(at, KR270_MASSES);
    let ran = |arguments: &[&str]| {
        let ran = run(at, arguments);
        assert_eq!(ran.status, 0, "{arguments:?}: {}{}", ran.out, ran.err);
        ran.out
    };
    let Machine { robot, markers, springs, effect, path: (first, way, axes), .. } = *machine;
    let set = ["--set", springs];
    let loads = ["--wrench=0,0,-2000", "--wrench=0,2000,0", "--wrench=2000,0,0"];
    let deflections = ["simulate", robot, "--poses", "40", "--observes", "deflection", "--errors", "0", "--into", "d"];
    ran(&[&deflections[..], &set, &loads, &["--share", "0.8", "--markers", markers]].concat());
    ran(&["identify", "d", "--what", "elastic", "--save", "springs.yaml"]);
    let poses = ["simulate", robot, "--poses", "70", "--observes", "pose", "--errors", "0.3", "--share", "0.6"];
    let more = ["--effect", effect, "--wrench=0,0,-1000", "--into", "p", "--seed", "4"];
    ran(&[&poses[..], &set, &more].concat());
    ran(&["diagnose", "p", "--robot", "springs.yaml", "--apply", "known.yaml"]);
    let wrench = [0.0, 200.0, -1000.0, 0.0, 0.0, 0.0];
    let mut text = String::from("x,y,z,rx,ry,rz,fx,fy,fz\n");
    let mut targets = Vec::new();
    for k in 0..25 {
        // There and back, so that each joint comes from both sides.
        let s = f64::from(if k < 13 { k } else { 25 - k }) / 12.0;
        let p: [f64; 3] = std::array::from_fn(|i| first[i] + s * way[i]);
        text += &format!("{},{},{},{},{},{},0,200,-1000\n", p[0], p[1], p[2], axes[0], axes[1], axes[2]);
        let rotation = Rotation3::new(Vector3::from(axes).map(f64::to_radians));
        targets.push(Transform::from_parts((Vector3::from(p) * 1e-3).into(), rotation));
    }
    std::fs::write(at.join("path.csv"), text).expect("written");
    ran(&["compensate", "known.yaml", "path.csv", "--nominal", robot, "--table", "corrected.csv"]);
    let nominal = at.join("nominal.csv");
    // Uncorrected commands: those of the nominal robot, rigid.
    let robot_file = if robot.ends_with(".yaml") { at.join(robot).display().to_string() } else { robot.to_string() };
    let bare = load_robot(&robot_file).expect("a robot");
    let path =
        Reader::default().path(&at.join("path.csv").display().to_string(), &bare, bare.raw.units).expect("a path");
    let geometry = Geometry::nominal(&bare.model).expect("assembled");
    let own: Vec<usize> = (0..bare.model.markers.len()).collect();
    let controller = elastogeo::compensation::Controller { geometry: &geometry, markers: &own };
    let asked = elastogeo::compensation::Asked { joints: false, position: true, orientation: true, hold: Hold::POSE };
    let desired =
        elastogeo::compensation::desire(&controller, &path.campaign, asked, &Transform::identity(), None, None);
    let units = &bare.raw.units;
    let names: Vec<&str> = bare.model.variables.iter().map(|v| v.name.as_str()).collect();
    let mut text = names.join(",") + "\n";
    for desired in &desired {
        let q = &desired.as_ref().expect("reached").nominal;
        let shown = q
            .iter()
            .zip(&bare.model.variables)
            .map(|(q, v)| format!("{:.9}", q / if v.is_angle { units.angle.factor() } else { units.length.factor() }));
        text += &(shown.collect::<Vec<_>>().join(",") + "\n");
    }
    std::fs::write(&nominal, text).expect("written");
    let arm = true_arm(bare.model.clone(), &at.join("p/truth.json"));
    let before = passes(&arm, &nominal, &targets, wrench, &robot_file);
    // The table has the controller's poses too; as a path its commands are what counts.
    let table = std::fs::read_to_string(at.join("corrected.csv")).expect("a table");
    let kept: Vec<String> =
        table.lines().map(|line| line.split(',').skip(1).take(names.len()).collect::<Vec<_>>().join(",")).collect();
    std::fs::write(at.join("commands.csv"), kept.join("\n")).expect("written");
    let after = passes(&arm, &at.join("commands.csv"), &targets, wrench, &robot_file);
    let [uncorrected, compensated] = [before, after].map(|error| 1e3 * error[1]);
    let found = format!("{}: {uncorrected:.4} mm uncorrected, {compensated:.4} mm compensated (rms)", machine.arm);
    let record = format!("compensated-{}", machine.arm);
    recorded(&record, "cargo test passes_where_it_should", &[found]);
    assert!(after[1] < 30e-6, "{after:?}");
    assert!(before[1] > 20.0 * after[1], "{before:?} {after:?}");
}

#[test]
fn an_identified_kr270_passes_where_it_should() {
    identified_then_compensated(&Machine {
        arm: "KR-270",
        robot: "heavy.yaml",
        markers: "m1,m2,m3",
        springs: "joint2.kar=0.05e-6,joint3.kar=-0.06e-6,joint5.kar=0.5e-6",
        effect: "gear-ratio@joint:3:ratio=6e-4",
        path: ([1700.0, -400.0, 1300.0], [300.0, 800.0, 100.0], [0.0, 120.0, 0.0]),
    });
}

#[test]
fn an_identified_ir663_passes_where_it_should() {
    identified_then_compensated(&Machine {
        arm: "IR663",
        robot: "kuka-ir663",
        markers: "wrist",
        springs: "joint2.kar=3e8,joint8.kar=-3e8",
        effect: "backlash@joint:1:half_width=4e-4,changes_at=0",
        path: ([1650.0, -250.0, 1450.0], [200.0, 500.0, -50.0], [170.0, 20.0, 0.0]),
    });
}

#[test]
fn singular_unreachable_and_forbidden_points_are_refused_by_number() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let joints = "q1,q2,q3,q4,q5,q6,fz
0,-60,90,0,40,0,-1000
10,-60,90,30,0,0,-1000
0,-60,90,0,40,0,-900
184.9999,-60,90,0,40,0,-1000
0,-60,90,0,-0.03,0,-1000
";
    std::fs::write(at.join("path.csv"), joints).expect("written");
    let arguments = ["compensate", "kuka-kr270", "path.csv", "--table", "out.csv"];
    let ran = run(at, &arguments);
    assert_eq!(ran.status, 1, "{}", ran.err);
    assert!(ran.out.contains("point 2 (row 2) refused: singular"), "{}", ran.out);
    assert!(ran.out.contains("point 5 (row 5) refused: "), "{}", ran.out);
    assert!(ran.out.contains("out.csv is not written"), "{}", ran.out);
    assert!(!at.join("out.csv").exists());
    let ran = run(at, &[&arguments[..], &["--keep-going", "--format", "json"]].concat());
    assert_eq!(ran.status, 1);
    let json: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(json["points"][0]["status"], "ok");
    assert_eq!(json["points"][1]["index"], 1);
    assert!(json["points"][1]["status"].as_str().expect("a text").starts_with("refused: singular"), "{json:#}");
    assert!(json["points"][0]["residual"].as_f64().expect("a number") < 1e-7);
    assert_eq!(
        std::fs::read_to_string(at.join("out.csv")).expect("a table").lines().count(),
        1 + 5 - json["refused"].as_array().expect("a list").len()
    );

    let poses = "x,y,z,rx,ry,rz\n1700,0,1300,0,120,0\n9000,0,1300,0,120,0\n1700,100,1300,0,120,0\n";
    std::fs::write(at.join("poses.csv"), poses).expect("written");
    let ran = run(at, &["compensate", "kuka-kr270", "poses.csv"]);
    assert_eq!(ran.status, 1, "{}", ran.err);
    assert!(ran.out.contains("point 2 (row 2) refused: unreachable"), "{}", ran.out);
    assert!(ran.out.contains("2 of 3 points"), "{}", ran.out);
    // As the controller writes them, and undeclared.
    let abc = "x,y,z,A,B,C\n1700,0,1300,0,120,0\n9000,0,1300,0,120,0\n1700,100,1300,0,120,0\n";
    std::fs::write(at.join("abc.csv"), abc).expect("written");
    let own = run(at, &["compensate", "kuka-kr270", "abc.csv", "--orientation", "kuka-abc"]);
    assert_eq!((own.status, own.out.replace("abc.csv", "poses.csv")), (1, ran.out), "{}", own.err);
    let ran = run(at, &["compensate", "kuka-kr270", "abc.csv"]);
    assert!(ran.status == 2 && ran.err.contains("`--orientation kuka-abc`"), "{}", ran.err);
    // At the edge of a limit that the correction would pass.
    let model = model_of(&(PLANAR.to_string() + "joint_stiffness:\n  1: {kar: {value: 1e5}}\n"));
    let limit = 0.5 * std::f64::consts::PI;
    let (mut path, desired) = nominal_path(&model, &[vec![limit - 1e-6, 0.5]]);
    path.readings[0].wrench = [200.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let found = compensate(&model, &model.registry.nominal(), &path, &desired, None, &Settings::new(2));
    let found = found.expect("assembled").points.remove(0);
    assert!(matches!(&found, Err(Refusal::Limits(_) | Refusal::Stuck { .. })), "{found:?}");
}

#[test]
fn a_path_is_the_same_whatever_the_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let with = |jobs: &str| {
        let arguments =
            ["compensate", "kuka-ir663", "ir663-strip", "--process", "ir663-strip", "--format", "json", "--jobs", jobs];
        let ran = run(folder.path(), &arguments);
        assert_eq!(ran.status, 0, "{}", ran.err);
        ran.out
    };
    let one = with("1");
    assert_eq!(one, with("3"));
    let json: Value = serde_json::from_str(&one).expect("JSON");
    for point in json["points"].as_array().expect("points") {
        assert!(point["settled"].as_f64().expect("a number") < 1e-6, "{point}");
    }
}

#[test]
fn mistakes_of_new_users_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("written");
    write("good.csv", "q1,q2,q3,q4,q5,q6\n0,-60,90,0,40,0\n");
    write("some.csv", "q1,q2,q3\n0,-60,90\n");
    write("none.csv", "fx,fy,fz\n0,0,1\n");
    write("turns.csv", "q1,q2,q3,q4,q5,q6,rx,ry,rz\n0,-60,90,0,40,0,0,0,0\n");
    write("strange.csv", "q1,q2,q3,q4,q5,q6,speed\n0,-60,90,0,40,0,3\n");
    write("side.csv", "q1,q2,q3,q4,q5,q6,approach.q2\n0,-60,90,0,40,0,5\n");
    write("marked.csv", "marker,q1,q2,q3,q4,q5,q6\nm9,0,-60,90,0,40,0\n");
    write("nan.csv", "q1,q2,q3,q4,q5,q6\n0,-60,90,0,abc,0\n");
    write("points.csv", "x,y,z\n1700,0,1300\n");
    write("empty.csv", "q1,q2,q3,q4,q5,q6\n");
    write("idle.yaml", "process: nothing\n");
    write(
        "soft.yaml",
        "units: {length: mm, pressure: GPa}\nstrip: {clamp: [0, 0, 0], along: [1, 0, 0], push: [1, 0, 0], length: 585, width: -5, height: 14, young: 70}\n",
    );
    write("typo.yaml", "units: {length: mm}\nstrips: {length: 3}\n");
    let kr = "kuka-kr270";
    let cases: &[(&[&str], &str)] = &[
        (&[kr, "missing.csv"], "there is no file `missing.csv`"),
        (&[kr, "ir663-strp"], "did you mean the bundled `ir663-strip`?"),
        (&[kr, "some.csv"], "some columns of the joints, but not q4, q5, q6"),
        (&[kr, "none.csv"], "neither joints nor positions"),
        (&[kr, "turns.csv"], "orientations without positions"),
        (&[kr, "strange.csv"], "speed"),
        (&[kr, "side.csv"], "must be 1 or -1"),
        (&[kr, "marked.csv"], "unknown marker `m9`"),
        (&[kr, "nan.csv"], "nan.csv:2"),
        (&[kr, "empty.csv"], "empty.csv"),
        (&[kr, "points.csv"], "compensate --from"),
        (&[kr, "good.csv", "--at", "m7"], "no marker is called `m7`"),
        (&[kr, "good.csv", "--nominal", "kuka-ir663"], "has the variables q1, stroke2"),
        (&[kr, "good.csv", "--units", "lenght=mm"], "did you mean `length`?"),
        (&[kr, "good.csv", "--units", "length=furlong"], "furlong"),
        (&[kr, "good.csv", "--residual", "0"], "--residual is above 0"),
        (&[kr, "good.csv", "--largest", "-3"], "--largest"),
        (&[kr, "good.csv", "--table", "nowhere/t.csv"], "there is no folder `nowhere`"),
        (&[kr, "good.csv", "--keep-going"], "--table"),
        (&[kr, "good.csv", "--process", "idle.yaml"], "does nothing to the tool"),
        (&[kr, "good.csv", "--process", "soft.yaml"], "`width` of the strip is -5"),
        (&[kr, "good.csv", "--process", "soft.yaml"], "`push` is parallel to `along`"),
        (&[kr, "good.csv", "--process", "typo.yaml"], "did you mean `strip`?"),
        (&[kr, "good.csv", "--process", "ir663-strop"], "did you mean the bundled `ir663-strip`?"),
        (&["kuka-kr27", "good.csv"], "did you mean `kuka-kr270`?"),
    ];
    let before = std::fs::read_dir(at).expect("a folder").count();
    for (arguments, expected) in cases {
        let ran = run(at, &[&["compensate"], *arguments].concat());
        assert_eq!(ran.status, 2, "{arguments:?}: {}{}", ran.out, ran.err);
        assert!(ran.err.contains(expected), "{arguments:?}: {}", ran.err);
        assert_eq!(ran.out, "", "{arguments:?}");
    }
    for (more, expected) in [
        (&["--observes", "distance"][..], "positions or poses"),
        (&["--wrench", "0,0,1"], "--process with --wrench"),
        (&["--markers", "m1,m2"], "one point"),
    ] {
        let simulate = ["simulate", kr, "--process", "ir663-strip", "--poses", "good.csv", "--into", "c"];
        let ran = run(at, &[&simulate[..], more].concat());
        assert_eq!(ran.status, 2, "{more:?}: {}", ran.err);
        assert!(ran.err.contains(expected), "{more:?}: {}", ran.err);
    }
    assert_eq!(std::fs::read_dir(at).expect("a folder").count(), before);
}

/// Targets in the measurement frame are those in the base frame, moved by the calibrated base.
#[test]
fn paths_in_the_measurement_frame_are_those_of_the_base_moved() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let base = ([1500.0, -300.0, 200.0], [5.0, -3.0, 40.0]);
    let placed = format!("base: {{at: {:?}, rotation: {:?}}}\n", base.0, base.1);
    heavy_kr270(at, &(KR270_MASSES.to_string() + &placed));
    let measured = Transform::from_parts(
        (Vector3::from(base.0) * 1e-3).into(),
        Rotation3::new(Vector3::from(base.1).map(f64::to_radians)),
    );
    let mut texts = ["x,y,z,rx,ry,rz,fz\n".to_string(), "x,y,z,rx,ry,rz,fz\n".to_string()];
    for k in 0..4 {
        let own = Transform::from_parts(
            Vector3::new(1.7, -0.3 + 0.2 * f64::from(k), 1.3).into(),
            Rotation3::new(Vector3::new(0.1, 2.1, 0.0)),
        );
        for (text, pose) in texts.iter_mut().zip([own, measured * own]) {
            let (p, r) = (pose.translation.vector * 1e3, rotation_vector(&pose.rotation).map(f64::to_degrees));
            *text += &format!("{:.10},{:.10},{:.10},{:.12},{:.12},{:.12},-1000\n", p.x, p.y, p.z, r.x, r.y, r.z);
        }
    }
    let commands = |name: &str, text: &str, more: &[&str]| -> Value {
        std::fs::write(at.join(name), text).expect("written");
        let ran = run(at, &[&["compensate", "heavy.yaml", name, "--format", "json"], more].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
        serde_json::from_str(&ran.out).expect("JSON")
    };
    let own = commands("own.csv", &texts[0], &[]);
    let moved = commands("moved.csv", &texts[1], &["--frame", "measurement"]);
    for (a, b) in own["points"].as_array().expect("points").iter().zip(moved["points"].as_array().expect("points")) {
        for (name, q) in a["joints"].as_object().expect("joints") {
            let away = q.as_f64().expect("a number") - b["joints"][name].as_f64().expect("a number");
            assert!(away.abs() < 1e-7, "{name}: {away:e}");
        }
        assert!(a["before"]["weight"][2].as_f64().expect("a number") < -1e-4, "{a}");
    }
}

/// A marker, not the tool centre point, passes along the path, under own weight and load.
#[test]
fn markers_pass_along_a_path_of_positions() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let file = heavy_kr270(at, KR270_MASSES);
    let wanted = [[1700.0, -300.0, 1300.0], [1750.0, 0.0, 1250.0], [1700.0, 300.0, 1300.0]];
    let mut text = "marker,x,y,z,fx,fz\n".to_string();
    for (k, p) in wanted.iter().enumerate() {
        text += &format!("m{},{},{},{},200,-1500\n", k + 1, p[0], p[1], p[2]);
    }
    std::fs::write(at.join("path.csv"), text).expect("written");
    let from = ["--from", "0,-60,90,0,40,0", "--table", "out.csv", "--residual", "1e-5"];
    let ran = run(at, &[&["compensate", "heavy.yaml", "path.csv"], &from[..]].concat());
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
    let model = load_robot(&file).expect("a robot").model;
    let values = model.registry.nominal();
    let table = std::fs::read_to_string(at.join("out.csv")).expect("a table");
    assert_eq!(table.lines().count(), 1 + wanted.len());
    let header: Vec<&str> = table.lines().next().expect("a header").split(',').collect();
    let first = header.iter().position(|name| *name == "q1").expect("joints");
    for (row, line) in table.lines().skip(1).enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let joints = cells[first..first + 6].iter();
        let q: Vec<f64> = joints.map(|cell| cell.parse::<f64>().expect("a number").to_radians()).collect();
        let (mut path, _) = nominal_path(&model, std::slice::from_ref(&q));
        path.readings[0].wrench = [200.0, 0.0, -1500.0, 0.0, 0.0, 0.0];
        path.readings[0].marker = Some(model.marker(&format!("m{}", row + 1)).expect("a marker"));
        let predictor = SinglePredictor::new(&model, &values, &path).expect("assembled");
        let mut work = predictor.workspace();
        predictor.place(&q, &mut work).expect("placed");
        let seen = predictor.see(0, &path.readings[0].wrench, &mut work).expect("seen");
        let away = (seen.real.translation.vector * 1e3 - Vector3::from(wanted[row])).norm();
        assert!(away < 1e-3, "point {row}: {away} mm");
        assert!(seen.by_wrench.norm() > 1e-4 && seen.by_weight.norm() > 1e-5);
    }
}

/// `--wrench` is a column of one wrench; a load under which nothing is compliant is reported.
#[test]
fn a_constant_load_need_not_stand_in_the_path() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("written");
    write("with.csv", "q1,q2,q3,q4,q5,q6,fx,fz\n0,-60,90,0,40,0,200,-1000\n10,-60,90,0,40,0,200,-1000\n");
    write("bare.csv", "q1,q2,q3,q4,q5,q6\n0,-60,90,0,40,0\n10,-60,90,0,40,0\n");
    let joints = |arguments: &[&str]| -> Value {
        let ran = run(at, &[&["compensate", "kuka-kr270"], arguments, &["--format", "json"]].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
        serde_json::from_str(&ran.out).expect("JSON")
    };
    assert_eq!(joints(&["with.csv"])["points"], joints(&["bare.csv", "--wrench", "200,0,-1000"])["points"]);
    let both = run(at, &["compensate", "kuka-kr270", "with.csv", "--wrench", "200,0,-1000"]);
    assert!(both.status == 2 && both.err.contains("wrenches of its own"), "{}", both.err);
    write("arm.yaml", PLANAR);
    write("planar.csv", "q1,q2\n0.3,0.5\n");
    let rigid = run(at, &["compensate", "arm.yaml", "planar.csv", "--wrench", "0,10,0"]);
    assert!(rigid.status == 0 && rigid.err.contains("nothing that gives"), "{}", rigid.err);
}

/// A SCARA robot: two links that lie, a spindle that slides and turns.
const SCARA: &str = "units: {length: mm, angle: deg}
robot: SCARA
variables: [q1, q2, s3, q4]
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 400, limits: [-130, 130]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 350, limits: [-145, 145]}
  3: {antecedent: 2, joint: prismatic, variable: s3, d: 300, limits: [-200, 0]}
  4: {antecedent: 3, joint: revolute, variable: q4, limits: [-360, 360]}
tool: {frame: 4, at: [60, 0, -50]}
";

/// A SCARA robot holds the position and the rotation about its spindle; the tilt of a bent column stays, and is told.
#[test]
fn a_scara_robot_holds_its_position_and_one_rotation() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("nominal.yaml", SCARA);
    // Links off by tenths of mm, a zero by 0.1 deg, and the second axis tilted by 0.2 deg.
    let bent = SCARA
        .replace("d: 350,", "d: 350.4, alpha: 0.2, theta: 0.1,")
        .replace("at: [60, 0, -50]", "at: [60.2, 0.1, -50]");
    write("real.yaml", &bent);
    let points = "x,y,z,rx,ry,rz\n400,200,300,0,0,30\n350,-250,260,0,0,75\n500,50,340,0,0,-20\n";
    write("path.csv", points);
    let command = ["compensate", "real.yaml", "path.csv", "--nominal", "nominal.yaml", "--hold", "position,rz"];
    let text = run(folder.path(), &command);
    assert_eq!(text.status, 0, "{}{}", text.out, text.err);
    assert!(text.out.contains("held x, y, z, rz; let go, off by at most: rx 0."), "{}", text.out);
    let ran = run(folder.path(), &[&command[..], &["--format", "json"]].concat());
    let found: Value = serde_json::from_str(&ran.out).expect("JSON");
    let real =
        Reader::default().robot(folder.path().join("real.yaml").to_str().expect("UTF-8")).expect("a robot").model;
    for (point, row) in found["points"].as_array().expect("points").iter().zip(points.lines().skip(1)) {
        let wanted: Vec<f64> = row.split(',').map(|v| v.parse().expect("a number")).collect();
        let q: Vec<f64> = real.variables.iter().map(|v| point["joints"][&v.name].as_f64().expect("a number")).collect();
        let pose = crate::support::nominal_pose(&real, &q);
        let missed = pose.translation.vector * 1e3 - Vector3::new(wanted[0], wanted[1], wanted[2]);
        assert!(missed.norm() < 1e-4, "{missed}");
        let target = Rotation3::from_axis_angle(&Vector3::z_axis(), wanted[5].to_radians());
        let off = target.inverse() * rotation_vector(&(target * pose.rotation.inverse()));
        assert!(off.z.abs() < 1e-7, "{off}");
        // The column's tilt, as it is seen along the target's axes.
        let tilt = (off.x * off.x + off.y * off.y).sqrt().to_degrees();
        assert!((tilt - 0.2).abs() < 1e-3, "{tilt}");
        for (name, value) in [("rx", off.x), ("ry", off.y)] {
            assert!((point["let_go"][name].as_f64().expect("a number") - value).abs() < 1e-9, "{name}");
        }
    }
    // With the position alone the spindle turns as it likes, and by how much is told too.
    let ran = run(folder.path(), &[&command[..6], &["position", "--format", "json"]].concat());
    let found: Value = serde_json::from_str(&ran.out).expect("JSON");
    let turned = |point: &Value| point["let_go"]["rz"].as_f64().expect("a number").abs();
    assert!(found["points"].as_array().expect("points").iter().any(|point| turned(point) > 1e-4));
    let ran = run(folder.path(), &[&command[..6], &["position,rw"]].concat());
    assert!(ran.status == 2 && ran.err.contains("`rw` is no direction"), "{}", ran.err);
}

/// Of a joint that lags by its backlash the command goes beyond where the joint is wanted, by the half width in the sense of the move:
/// whether the sides are derived from the path, stated in it, or come line by line.
#[test]
fn a_joint_with_backlash_is_led() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("written");
    write("nominal.yaml", PLANAR);
    let slack = "effects:\n- {effect: backlash, site: \"joint:2\", parameters: {half_width: 0.001, by: approach}}\n";
    write("arm.yaml", &format!("{PLANAR}{slack}"));
    let (commands, sides) = ([10.0, 50.0, 80.0, 40.0, 20.0], [-1, -1, -1, 1, 1]);
    let rows = commands.iter().zip(sides);
    let derived: String = commands.iter().map(|q| format!("0,{q}\n")).collect();
    let stated: String = rows.map(|(q, side)| format!("0,{q},{side}\n")).collect();
    write("derived.csv", &format!("q1,q2\n{derived}"));
    write("stated.csv", &format!("q1,q2,approach.q2\n{stated}"));
    let half_width = 0.001_f64.to_degrees();
    for path in ["derived.csv", "stated.csv"] {
        let asked = ["compensate", "arm.yaml", path, "--nominal", "nominal.yaml", "--format", "json"];
        let ran = run(at, &asked);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let found: Value = serde_json::from_str(&ran.out).expect("JSON");
        assert_ne!(found["sides"], "unsettled", "{path}");
        let points = found["points"].as_array().expect("points");
        for (point, (q, side)) in points.iter().zip(commands.iter().zip(sides)) {
            let command = point["joints"]["q2"].as_f64().expect("a command").to_degrees();
            // A half width is what the first point needs too, to second order.
            assert!((command - (q - f64::from(side) * half_width)).abs() < 5e-4, "{path}: {command} for {q}");
        }
    }
}

/// An arm of four joints, of which three are enough to place its tip: one stands at its limit, and would be lifted beyond it against the
/// sag.
#[test]
fn a_joint_at_its_limit_stays_there_where_others_can_make_up_for_it() {
    let arm = "robot: four joints
units: {length: mm, angle: deg, mass: kg, rotational_stiffness: N.m/rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-170, 170]}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: 90, limits: [-170, 10]}
  3: {antecedent: 2, joint: revolute, variable: q3, d: 500, limits: [-150, 150]}
  4: {antecedent: 3, joint: revolute, variable: q4, d: 400, limits: [-150, 150]}
  E: {antecedent: 4, d: 300}
tool: {frame: E}
bodies: {4: {mass: 20, com: [200, 0, 0]}}
joint_stiffness: {2: {kar: {value: 20000}}}
";
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("arm.yaml"), arm).expect("written");
    std::fs::write(at.join("path.csv"), "pose,q1,q2,q3,q4\na,20,10,30,40\nb,20,9.99,-50,70\n").expect("written");
    let arguments =
        ["compensate", "arm.yaml", "path.csv", "--nominal", "arm.yaml", "--hold", "position", "--table", "out.csv"];
    let ran = run(at, &arguments);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let table = std::fs::read_to_string(at.join("out.csv")).expect("a table");
    let joints = |line: &str| -> Vec<f64> {
        line.split(',').skip(1).take(4).map(|cell| cell.parse().expect("a number")).collect()
    };
    let found: Vec<Vec<f64>> = table.lines().skip(1).map(joints).collect();
    // Without limits q2 would be 10.438 and 10.399 deg.
    assert!(found.len() == 2 && found.iter().all(|q| (q[1] - 10.0).abs() < 1e-9), "{found:?}");
    // The commanded tip, sagging, is where the nominal one is: the sag of joint 2 under 20 kg is its torque over 20000 N.m/rad.
    let tip = |q: &[f64], sag: f64| {
        let angles = [q[1] + sag, q[1] + sag + q[2], q[1] + sag + q[2] + q[3]].map(f64::to_radians);
        let lengths = [500.0, 400.0, 300.0];
        [0, 1].map(|axis| {
            (0..3).map(|k| lengths[k] * if axis == 0 { angles[k].cos() } else { angles[k].sin() }).sum::<f64>()
        })
    };
    for (q, wanted) in found.iter().zip([[20.0, 10.0, 30.0, 40.0], [20.0, 9.99, -50.0, 70.0]]) {
        let angle = |k: usize| q[1..=k].iter().sum::<f64>().to_radians();
        let arm = 0.5 * angle(1).cos() + 0.4 * angle(2).cos() + 0.2 * angle(3).cos();
        let sag = (-20.0 * 9.80665 * arm / 20000.0).to_degrees();
        let [reached, wanted] = [tip(q, sag), tip(&wanted, 0.0)];
        // Deflections are of first order: what the sag moves, it moves along the tangent.
        assert!(reached.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 0.05), "{reached:?} {wanted:?}");
    }
}
