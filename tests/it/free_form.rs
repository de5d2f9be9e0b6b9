//! Free curves: declared, predicted, read back, refused.

use elastogeo::description::raw::{RawAmount, RawCurve, RawEffect, RawValidity};
use elastogeo::files::load_robot;
use elastogeo::math::NaturalSpline;
use elastogeo::observation::{POSE, POSITION};
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, generator, simulate};

use nalgebra::Vector3;

use super::cli::run;
use super::plausibility::{Table, json, spoil};

fn entry(follows: &str, at: &[f64], amount: &[f64]) -> RawEffect {
    RawEffect {
        effect: Some("free-form".into()),
        site: Some("joint:3".into()),
        follows: Some(follows.into()),
        curve: Some(RawCurve { at: at.to_vec(), amount: amount.to_vec() }),
        ..RawEffect::default()
    }
}

/// Knots 0, 1, 2 with 0, 1, 0: the only second derivative M solves (2/3) M = -2, so that the middle of the first half is
/// 1/2 - (1/2 - 1/8) M / 6 = 0.6875. A straight line is reproduced; beyond the ends the value stays.
#[test]
fn a_natural_spline_has_its_textbook_values() {
    let value = |at: &[f64], amounts: &[f64], x: f64| {
        let spline = NaturalSpline::new(at).expect("increasing");
        let mut sum = 0.0;
        spline.weights(x, |k, weight| sum += weight * amounts[k]);
        sum
    };
    assert!((value(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0], 0.5) - 0.6875).abs() < 1e-15);
    let knots = [-1.0, 0.5, 0.75, 3.0];
    let line = knots.map(|x| 2.0 - 3.0 * x);
    for x in [-1.0, -0.3, 0.6, 2.9] {
        assert!((value(&knots, &line, x) - (2.0 - 3.0 * x)).abs() < 1e-14);
    }
    assert_eq!(value(&knots, &line, 7.0), value(&knots, &line, 3.0));
    assert!(NaturalSpline::new(&[0.0, 0.0]).is_none());
}

/// A curve that follows the joint's own angle moves readings as a joint that stands elsewhere by the curve.
#[test]
fn a_curve_predicts_what_a_displaced_joint_shows() {
    let model = load_robot("universal-ur5").expect("a robot").model;
    let (at, amounts) = ([-3.0, -1.0, 1.0, 3.0], [1e-6, -2e-6, 3e-6, 1e-6]);
    let mut with = model.clone();
    with.switch_on(model.resolve_effect(&entry("q3", &at, &amounts)).expect("an effect"));
    let geometry = elastogeo::kinematics::Geometry::nominal(&model).expect("a model");
    let mut random = generator(3);
    let configurations = draw_configurations(&geometry, 20, 0.8, &mut random).expect("configurations");
    let plan = Plan {
        configurations,
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSE,
        sigma: 1e-12,
        sigma_orientation: 1e-12,
        estimate: [false; 2],
    };
    let campaign = simulate(&model, &model.registry.nominal(), &plan, &mut random).expect("simulated");
    let mut displaced = campaign.clone();
    let spline = NaturalSpline::new(&at).expect("increasing");
    for q in displaced.joints.chunks_exact_mut(6) {
        let angle = q[2];
        spline.weights(angle, |k, weight| q[2] += weight * amounts[k]);
    }
    let residual = |model: &elastogeo::model::Model, campaign: &elastogeo::description::campaign::Campaign| {
        let mut out = Linearised::default();
        let predictor = Predictor::new(model, campaign, Vec::new()).expect("a predictor");
        predictor.linearise(&model.registry.nominal(), false, &mut out).expect("predicted");
        out.residual
    };
    let (found, expected) = (residual(&with, &campaign), residual(&model, &displaced));
    let greatest = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    assert!(greatest > 1e-7, "{greatest}");
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-10, "{found} {expected}");
    }
}

/// Equal amounts at all knots move the tool's point as a slip of the tool before the first reading: along the axes of the flange, which the
/// orientation of each pose gives.
#[test]
fn a_curve_at_the_tool_moves_along_the_axes_of_the_flange() {
    let model = load_robot("universal-ur5").expect("a robot").model;
    let geometry = elastogeo::kinematics::Geometry::nominal(&model).expect("a model");
    let mut random = generator(5);
    let plan = Plan {
        configurations: draw_configurations(&geometry, 20, 0.8, &mut random).expect("configurations"),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: true,
        observes: POSE,
        sigma: 1e-12,
        sigma_orientation: 1e-12,
        estimate: [false; 2],
    };
    let campaign = simulate(&model, &model.registry.nominal(), &plan, &mut random).expect("simulated");
    let residual = |effect: &str, parameters: &[(&str, RawAmount)]| {
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_string(), value.clone())).collect();
        let raw =
            RawEffect { effect: Some(effect.into()), site: Some("tool".into()), parameters, ..RawEffect::default() };
        let mut with = model.clone();
        with.switch_on(model.resolve_effect(&raw).expect("an effect"));
        let mut out = Linearised::default();
        let predictor = Predictor::new(&with, &campaign, Vec::new()).expect("a predictor");
        predictor.linearise(&with.registry.nominal(), false, &mut out).expect("predicted");
        out.residual
    };
    let number = |value: f64| RawAmount::from(value);
    let knots = [("follows", RawAmount::from("time")), ("at", RawAmount::Numbers(vec![0.0, 1000.0]))];
    let amounts = [("x1", 2e-6), ("x2", 2e-6), ("z1", -1e-6), ("z2", -1e-6)].map(|(name, value)| (name, number(value)));
    let curve = residual("free-form", &[&knots[..], &amounts].concat());
    let slip = residual("tool-slip", &[("x", number(2e-6)), ("z", number(-1e-6)), ("slip_at", number(-1.0))]);
    let greatest = slip.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    assert!(greatest > 1e-6, "{greatest}");
    for (found, expected) in curve.iter().zip(&slip) {
        assert!((found - expected).abs() < 1e-9 * greatest, "{found} {expected}");
    }
    let turned = RawEffect {
        parameters: [("rx1".to_string(), number(1e-4))].into_iter().collect(),
        follows: Some("time".into()),
        ..entry("time", &[0.0, 1000.0], &[0.0, 0.0])
    };
    let turned = RawEffect { site: Some("tool".into()), ..turned };
    assert!(model.resolve_effect(&turned).is_err());
}

/// A curve of the instrument lengthens what it reads by a part that goes with where the point is, from the instrument's place and level.
#[test]
fn a_curve_of_the_instrument_lengthens_what_it_reads() {
    let model = load_robot("universal-ur5").expect("a robot").model;
    let geometry = elastogeo::kinematics::Geometry::nominal(&model).expect("a model");
    let mut random = generator(6);
    let plan = Plan {
        configurations: draw_configurations(&geometry, 20, 0.8, &mut random).expect("configurations"),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSITION,
        sigma: 1e-12,
        sigma_orientation: 1e-12,
        estimate: [false; 2],
    };
    let campaign = simulate(&model, &model.registry.nominal(), &plan, &mut random).expect("simulated");
    let (at, amounts) = ([-0.5, 0.2, 0.9], [1e-5, -2e-5, 4e-5]);
    let spline = NaturalSpline::new(&at).expect("increasing");
    let mut values = model.registry.nominal();
    // The instrument stands beside and below the base, and its frame is turned about the vertical.
    for (name, value) in [("base.x", 1.5), ("base.y", -0.4), ("base.z", 0.3), ("base.rz", 0.7)] {
        values[model.registry.slot(name).expect("a parameter")] = value;
    }
    for (follows, of) in [("height", (|p| p.z) as fn(&Vector3<f64>) -> f64), ("range", |p| p.norm())] {
        let raw = RawEffect { site: Some("instrument".into()), ..entry(follows, &at, &amounts) };
        let mut with = model.clone();
        with.switch_on(model.resolve_effect(&raw).expect("an effect"));
        let predicted = |model: &elastogeo::model::Model| {
            let mut out = Linearised::default();
            let mut all = model.registry.nominal();
            all[..values.len()].copy_from_slice(&values);
            let predictor = Predictor::new(model, &campaign, Vec::new()).expect("a predictor");
            predictor.linearise(&all, false, &mut out).expect("predicted");
            out.predicted.iter().map(|rows| Vector3::new(rows[0], rows[1], rows[2])).collect::<Vec<_>>()
        };
        let (found, before) = (predicted(&with), predicted(&model));
        assert_eq!(found.len(), 20);
        for (found, before) in found.iter().zip(&before) {
            let mut part = 0.0;
            spline.weights(of(before), |k, weight| part += weight * amounts[k]);
            assert!((found - before * (1.0 + part)).norm() < 1e-12, "{follows}: {found} {before} {part}");
        }
    }
}

/// A tracker whose scale grows with the height of the reflector, which no law of the catalogue is: the instrument is named, and what
/// the error goes with, and no bent beam. None of it is written into the robot.
#[test]
fn an_instrument_without_a_law_is_named_by_its_site() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "kuka-kr270", "--poses", "60", "--markers", "m1,m2,m3", "--seed", "12", "--noise", "0.03"];
    let ran = run(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", "c"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    spoil(&at.join("c"), |table: &mut Table| {
        let columns = ["x", "y", "z"].map(|name| table.column(name));
        for row in &mut table.rows {
            let read = columns.map(|column| row[column].parse::<f64>().expect("a number"));
            let part = 1.5e-4 * read[2] / 1000.0;
            columns.iter().zip(read).for_each(|(&column, value)| row[column] = (value * (1.0 + part)).to_string());
        }
    });
    let ran = run(at, &["diagnose", "c", "--apply", "a.yaml", "--format", "json"]);
    let found = json(&ran);
    let causes: Vec<String> = found["causes"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|cause| format!("{} {} {}", cause["effect"], cause["site"], cause["follows"]).replace('"', ""))
        .collect();
    assert_eq!(causes, ["free-form instrument height"], "{}", ran.err);
    let applied = std::fs::read_to_string(at.join("a.yaml")).expect("written");
    assert!(!applied.contains("free-form"), "{applied}");
    let ran = run(at, &["report", "c", "--output", "r.html"]);
    let page = std::fs::read_to_string(at.join("r.html")).unwrap_or_else(|_| panic!("{}", ran.err));
    assert!(page.contains("aria-label=\"Curve at instrument against height, with its 95 % band\""), "no chart");
}

#[test]
fn a_curve_is_written_as_it_was_read() {
    let model = load_robot("universal-ur5").expect("a robot").model;
    for follows in ["q1", "own-load.q3", "load.q3", "move.q3", "time", "session-time", "temperature", "height", "range"]
    {
        let mut raw = entry(follows, &[-1.0, 0.0, 2.0], &[1e-4, 0.0, -1e-4]);
        if ["height", "range"].contains(&follows) {
            raw.site = Some("instrument".into());
        }
        assert_eq!(model.resolve_effect(&raw).expect("an effect").raw(&model), raw);
    }
}

#[test]
fn curves_that_cannot_be_are_refused() {
    let model = load_robot("universal-ur5").expect("a robot").model;
    let message = |raw: &RawEffect| model.resolve_effect(raw).expect_err("refused").diagnostic.message;
    assert!(message(&entry("q3", &[0.0, 1.0], &[1e-4])).contains("1 amounts at 2 values"));
    assert!(message(&entry("q3", &[1.0, 0.0], &[1e-4, 0.0])).contains("`at: [1.0, 0.0]`"));
    assert!(message(&entry("q9", &[0.0, 1.0], &[1e-4, 0.0])).contains("`follows: q9`"));
    assert!(message(&entry("q3", &[0.0, f64::INFINITY], &[1e-4, 0.0])).contains("finite"));
    let mut without = entry("q3", &[0.0, 1.0], &[1e-4, 0.0]);
    without.follows = None;
    assert!(message(&without).contains("lacks `follows`"));
    let mut word = entry("q3", &[0.0, 1.0], &[1e-4, 0.0]);
    word.parameters.insert("k1".into(), RawAmount::from("much"));
    word.curve = None;
    assert!(message(&word).contains("lacks `at`"));
    // Where the point is from the instrument moves no joint.
    let fault = model.resolve_effect(&entry("height", &[0.0, 1.0], &[1e-4, 0.0])).expect_err("refused").diagnostic;
    assert!(fault.message.contains("`follows: height`"), "{fault:?}");
    assert!(fault.remedy.iter().any(|remedy| remedy.contains("site: instrument")), "{fault:?}");
}

/// Commands outside the range in which effects were found say so; inside they do not.
#[test]
fn commands_heed_the_range_of_validity() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.yaml");
    let mut raw = load_robot("universal-ur5").expect("a robot").raw;
    raw.validity = Some(RawValidity {
        joints: [("q1".to_string(), [-0.5, 0.5])].into_iter().collect(),
        loads: [("force".to_string(), [0.0, 50.0])].into_iter().collect(),
        ..RawValidity::default()
    });
    std::fs::write(&path, elastogeo::description::yaml::write(&raw).expect("YAML")).expect("written");
    let said = |joints: &str, wrench: &str| {
        let arguments = ["pose", "robot.yaml", "--joints", joints, "--wrench", wrench, "--format", "json"];
        let ran = run(folder.path(), &arguments);
        let found: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
        let all = found["diagnostics"].as_array().expect("a list").clone();
        all.into_iter().filter(|one| one["code"] == "outside-validity").map(|one| one["message"].to_string()).collect()
    };
    let none: Vec<String> = said("0.1,0,0,0,0,0", "0,0,-40");
    assert!(none.is_empty(), "{none:?}");
    let both: Vec<String> = said("80,0,0,0,0,0", "0,0,-90");
    assert!(both.len() == 1 && both[0].contains("q1, force"), "{both:?}");
    // Readings with a payload that the readings before did not have.
    raw.validity = Some(RawValidity {
        loads: [("payload".to_string(), [0.0, 0.0])].into_iter().collect(),
        ..RawValidity::default()
    });
    std::fs::write(&path, elastogeo::description::yaml::write(&raw).expect("YAML")).expect("written");
    let made = run(folder.path(), &["simulate", "universal-ur5", "--poses", "30", "--unknown-base", "--into", "c"]);
    assert_eq!(made.status, 0, "{}", made.err);
    let file = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("text");
    for (payload, expected) in [("none", 0), ("block", 1)] {
        let entry =
            format!("payloads: {{block: {{mass: 5}}}}\nmeasurements: [{{file: measurements.csv, payload: {payload}}}]");
        std::fs::write(&file, text.replace("measurements: measurements.csv", &entry)).expect("written");
        for arguments in [&["residuals", "robot.yaml", "c"][..], &["register", "c", "--robot", "robot.yaml"]] {
            let ran = run(folder.path(), &[arguments, &["--format", "json", "--force"]].concat());
            let found: serde_json::Value = serde_json::from_str(&ran.out).unwrap_or_else(|_| panic!("{}", ran.err));
            let all = found["diagnostics"].as_array().expect("a list").clone();
            let told = all.iter().filter(|one| one["code"] == "outside-validity").count();
            assert_eq!(told, expected, "{arguments:?} with {payload}: {all:?}");
        }
    }
}

/// A gantry whose beam sags between its ends: geometry that is calibrated stands for a straight line in it, and only what stays off that line can be
/// known. The curve is found, and shown as that.
#[test]
fn a_sagging_beam_is_a_curve_without_its_line() {
    const GANTRY: &str = "robot: gantry
units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: prismatic, variable: q1, alpha: 90, theta: 90, limits: [0, 2400]}
  2: {antecedent: 1, joint: prismatic, variable: q2, alpha: 90, theta: 90, limits: [0, 1500]}
  3: {antecedent: 2, joint: prismatic, variable: q3, alpha: 90, limits: [0, 800]}
  4: {antecedent: 3, joint: revolute, variable: q4, r: 120, limits: [-170, 170]}
  5: {antecedent: 4, joint: revolute, variable: q5, alpha: 90, limits: [-110, 110]}
tool: {frame: 5, at: [60, 0, 80]}
";
    let at = [0.0, 0.375, 0.75, 1.125, 1.5];
    let sag = [0.0, -6e-4, -8e-4, -6e-4, 0.0];
    let effect = format!(
        "effects:\n- {{effect: free-form, site: \"joint:3\", parameters: {{follows: q2, at: {at:?}, k1: {}, k2: {}, k3: {}, k4: {}, k5: {}}}}}\n",
        sag[0], sag[1], sag[2], sag[3], sag[4]
    );
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("gantry.yaml"), GANTRY).expect("written");
    std::fs::write(folder.path().join("sagging.yaml"), format!("{GANTRY}{effect}")).expect("written");
    let simulate =
        ["simulate", "sagging.yaml", "--poses", "120", "--noise", "0.02", "--errors", "0.2", "--unknown-base"];
    let made = run(folder.path(), &[&simulate[..], &["--seed", "3", "--into", "s"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let found = json(&run(folder.path(), &["diagnose", "s", "--robot", "gantry.yaml", "--format", "json"]));
    let causes = found["causes"].as_array().expect("a list");
    let cause = causes.iter().find(|cause| cause["follows"] == "q2").unwrap_or_else(|| panic!("{causes:?}"));
    let curve = &cause["curve"];
    assert_eq!(curve["without_line"], true, "{curve}");
    let list = |key: &str| -> Vec<f64> {
        curve[key].as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
    };
    let [knots, amounts, band] = ["at", "amount", "band"].map(list);
    // The sag at the knots found, less its own straight line by least squares.
    let spline = NaturalSpline::new(&at).expect("increasing");
    let truth = |x: f64| {
        let mut sum = 0.0;
        spline.weights(x, |k, weight| sum += weight * sag[k]);
        sum
    };
    let (count, middle) = (knots.len() as f64, knots.iter().sum::<f64>() / knots.len() as f64);
    let mean = knots.iter().map(|x| truth(*x)).sum::<f64>() / count;
    let slope = knots.iter().map(|x| (x - middle) * truth(*x)).sum::<f64>()
        / knots.iter().map(|x| (x - middle).powi(2)).sum::<f64>();
    for ((x, amount), band) in knots.iter().zip(&amounts).zip(&band) {
        let expected = truth(*x) - mean - slope * (x - middle);
        assert!((amount - expected).abs() < 2.0 * band + 2e-5 && *band < 1e-4, "{x}: {amount} +- {band}, {expected}");
    }
}
