//! A free compliance of a body against the springs of the elastic assembly, each of which is a part of one.

use elastogeo::blind::without;
use elastogeo::description::raw::{RawAmount, RawEffect};
use elastogeo::diagnosis::Level;
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::model::Model;
use elastogeo::observation::{DEFLECTION, POSE};
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, generator, simulate};
use elastogeo::state::{Loads, Mechanics};
use nalgebra::{Isometry3, Matrix6, Vector3, Vector6};

use super::support::diagnosed;

const DIRECTIONS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Twist of the origin of a body's frame, its axes: what turns about an axis of a frame that is placed in the body's.
fn turn(frame: &Isometry3<f64>, axis: Vector3<f64>) -> Vector6<f64> {
    let axis = frame.rotation * axis;
    let moved = frame.translation.vector.cross(&axis);
    Vector6::new(moved.x, moved.y, moved.z, axis.x, axis.y, axis.z)
}

fn entry(site: &str, compliance: &Matrix6<f64>) -> RawEffect {
    let mut parameters = Vec::new();
    for a in 0..6 {
        for b in a..6 {
            parameters.push((format!("{}_{}", DIRECTIONS[a], DIRECTIONS[b]), RawAmount::from(compliance[(a, b)])));
        }
    }
    RawEffect {
        effect: Some("free-compliance".into()),
        site: Some(site.into()),
        parameters: parameters.into_iter().collect(),
        ..RawEffect::default()
    }
}

/// One frame in the axes of another that carries it, wherever the joints before them stand.
fn placed(model: &Model, body: usize, frame: usize) -> Isometry3<f64> {
    let values = model.registry.nominal();
    let mechanics = Mechanics::new(model, &values, Loads { weight: false, wrench: false }, &[]).expect("mechanics");
    let mut state = mechanics.state();
    mechanics.place(&[0.3, -0.7, 0.9, 0.2, -0.4, 0.1], &mut state).expect("placed");
    let frames = &state.placements.frames;
    let inner = frames[body].inverse() * frames[frame];
    Isometry3::from_parts(inner.translation, inner.rotation.into())
}

/// Springs of a joint's drive, of its bearing and of the base show under own weight, in poses, and under wrenches, in deflections,
/// what the elastic assembly computes by virtual forces.
#[test]
fn it_holds_the_springs_of_the_assembly() {
    let model = load_robot("universal-ur5").expect("a robot").model;
    let frame = |name: &str| model.frames.iter().position(|frame| frame.name == name).expect("a frame");
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    let about = |body: &str, joint: &str, axes: &[Vector3<f64>]| {
        let at = placed(&model, if body == "base" { 0 } else { frame(body) }, frame(joint));
        axes.iter().map(|axis| turn(&at, *axis)).map(|twist| twist * twist.transpose()).sum::<Matrix6<f64>>()
    };
    let unit = |k: usize| Vector6::ith(k, 1.0) * Vector6::ith(k, 1.0).transpose();
    let cases = [
        ("joint4.kar", "link:3", about("3", "4", &[z])),
        ("joint3.krr", "link:2", about("2", "3", &[x, y])),
        ("joint1.krr", "base", about("base", "1", &[x, y])),
        ("base.krx", "base", unit(3)),
        ("base.kz", "base", unit(2)),
    ];
    let geometry = Geometry::nominal(&model).expect("a model");
    let mut random = generator(7);
    let drawn = draw_configurations(&geometry, 25, 0.8, &mut random).expect("configurations");
    for (observes, wrenches) in [
        (POSE, vec![[0.0; 6]]),
        (DEFLECTION, vec![[30.0, -20.0, -80.0, 4.0, 2.0, -3.0], [0.0, 60.0, 20.0, 0.0, 0.0, 5.0]]),
    ] {
        let plan = Plan {
            configurations: drawn.clone(),
            markers: vec![None],
            repeats: 1,
            wrenches,
            conditions: false,
            observes,
            sigma: 1e-12,
            sigma_orientation: 1e-12,
            estimate: [false; 2],
        };
        let nominal = model.registry.nominal();
        let campaign = simulate(&model, &nominal, &plan, &mut random).expect("simulated");
        let residual = |model: &Model, values: &[f64]| {
            let mut out = Linearised::default();
            let predictor = Predictor::new(model, &campaign, Vec::new()).expect("a predictor");
            predictor.linearise(values, false, &mut out).expect("predicted");
            out.residual
        };
        for (name, site, of_one) in &cases {
            let amount = 1e-9;
            let slot = model.registry.slot(name).expect("a parameter");
            assert_eq!(nominal[slot], 0.0, "{name} is rigid");
            let mut values = nominal.clone();
            values[slot] = amount;
            let mut with = model.clone();
            with.switch_on(model.resolve_effect(&entry(site, &(amount * of_one))).expect("an effect"));
            let (found, expected) = (residual(&with, &with.registry.nominal()), residual(&model, &values));
            let greatest = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            assert!(greatest > 1e-9, "{name}: {greatest}");
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-4 * greatest, "{name}: {found} {expected}");
            }
        }
    }
}

/// Bodies that a loop joins to what comes before have none: what they carry is not known without the loop.
#[test]
fn bodies_of_loops_have_none() {
    let sites = |robot: &str| {
        let model = load_robot(robot).expect("a robot").model;
        let law = model.catalogue.get("free-compliance").expect("of the catalogue");
        law.sites(&model).into_iter().map(|site| site.name).collect::<Vec<_>>()
    };
    assert_eq!(sites("universal-ur5"), ["base", "link:1", "link:2", "link:3", "link:4", "link:5"]);
    let of_loop = sites("kuka-ir663");
    assert!(of_loop.contains(&"base".to_string()) && of_loop.contains(&"link:1".to_string()), "{of_loop:?}");
    assert!(!of_loop.contains(&"link:2".to_string()), "{of_loop:?}");
    assert_eq!(sites("five-bar"), ["base"]);
}

/// A foot that tilts about one axis only, which the catalogue lacks: the bearing of the first joint comes near, and is not named for
/// it. With the catalogue whole the foot is.
#[test]
fn what_the_catalogue_lacks_is_not_named_after_its_neighbour() {
    let plain = load_robot("kuka-kr270").expect("a robot").model;
    let mut spoiled = plain.clone();
    super::support::switch_on(&mut spoiled, "base-compliance", "base", &[("base.krx", 4e-8), ("base.kry", 1.2e-8)]);
    let mut random = generator(3);
    let geometry = Geometry::nominal(&plain).expect("a model");
    let plan = Plan {
        configurations: draw_configurations(&geometry, 60, 0.8, &mut random).expect("configurations"),
        markers: (0..plain.markers.len()).map(Some).collect(),
        repeats: 1,
        wrenches: vec![[500.0, 0.0, -1500.0, 0.0, 0.0, 0.0], [0.0, 900.0, 800.0, 0.0, 0.0, 0.0]],
        conditions: false,
        observes: DEFLECTION,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [false; 2],
    };
    let truth = spoiled.completed(&plain.registry.nominal());
    let campaign = simulate(&spoiled, &truth, &plan, &mut random).expect("simulated");
    let causes = |model: &Model| {
        diagnosed(model, &campaign)
            .causes
            .into_iter()
            .map(|cause| (cause.effect, cause.site, cause.level))
            .collect::<Vec<_>>()
    };
    let whole = causes(&plain);
    assert_eq!(whole, [("base-compliance".to_string(), "base".to_string(), Level::Law)]);
    let lacking = causes(&without(&plain, &campaign, "base-compliance").expect("a catalogue"));
    assert!(!lacking.is_empty() && lacking.iter().all(|(.., level)| *level == Level::Family), "{lacking:?}");
}
