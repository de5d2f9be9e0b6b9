//! The inverse model: round trips, branches, limits, refusals.

use elastogeo::kinematics::{
    Geometry, Hold, InverseError, InverseSettings, Placements, Target, rotation_vector, solve,
};
use elastogeo::model::Model;
use nalgebra::{Point3, Rotation3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::support::{bundled, model_of};

fn target_at(geometry: &Geometry, q: &[f64]) -> Target {
    let mut placements = Placements::default();
    geometry.place(q, &mut placements).expect("placed");
    let end = placements.frames[geometry.model.tool.0] * geometry.tool();
    Target { position: end.translation.vector.into(), rotation: Some(end.rotation), hold: Hold::POSE }
}

/// Errors of a configuration, by the forward model alone.
fn miss(geometry: &Geometry, target: &Target, q: &[f64]) -> (f64, f64) {
    let found = target_at(geometry, q);
    let turned = |r: Rotation3<f64>| rotation_vector(&(r * found.rotation.expect("a rotation").inverse())).norm();
    ((found.position - target.position).norm(), target.rotation.map_or(0.0, turned))
}

/// Configurations inside the limits at which the robot can be put together.
fn configurations(geometry: &Geometry, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut placements = Placements::default();
    let mut draw = || -> Vec<f64> {
        let variables = geometry.model.variables.iter();
        variables
            .map(|variable| {
                let [low, high] = variable.limits.unwrap_or([-1.0, 1.0]);
                random.random_range(0.9 * low + 0.1 * high..0.1 * low + 0.9 * high)
            })
            .collect()
    };
    let mut found = Vec::new();
    while found.len() < count {
        let q = draw();
        if geometry.place(&q, &mut placements).is_ok() {
            found.push(q);
        }
    }
    found
}

fn within_limits(model: &Model, q: &[f64]) -> bool {
    model
        .variables
        .iter()
        .zip(q)
        .all(|(variable, value)| variable.limits.is_none_or(|[low, high]| (low..=high).contains(value)))
}

fn same(model: &Model, a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).zip(&model.variables).all(|((a, b), variable)| {
        let turn = std::f64::consts::TAU;
        let difference = a - b - if variable.is_angle { turn * ((a - b) / turn).round() } else { 0.0 };
        difference.abs() < 1e-6
    })
}

fn round_trips(geometry: &Geometry, count: usize, seed: u64) -> Vec<usize> {
    let mut branches = Vec::new();
    for q in configurations(geometry, count, seed) {
        let target = target_at(geometry, &q);
        let solutions = solve(geometry, &target, &InverseSettings::default()).expect("reachable");
        for solution in &solutions {
            assert!(within_limits(geometry.model, &solution.joints), "{solution:?}");
            let (position, orientation) = miss(geometry, &target, &solution.joints);
            assert!(position < 1e-11 && orientation < 1e-11, "{position:e} {orientation:e}");
            assert!((position - solution.position_error).abs() < 1e-12);
        }
        if solutions.iter().all(|solution| solution.self_motions == 0) {
            let known = solutions.iter().any(|solution| same(geometry.model, &solution.joints, &q));
            assert!(known, "{q:?} is not among {solutions:#?}");
            for (k, a) in solutions.iter().enumerate() {
                assert!(solutions[..k].iter().all(|b| !same(geometry.model, &a.joints, &b.joints)));
            }
        }
        branches.push(solutions.len());
    }
    branches
}

#[test]
fn an_elbow_robot_has_up_to_eight_branches() {
    let model = bundled("universal-ur5");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let target = target_at(&geometry, &[0.4, -1.2, 1.3, -0.7, 0.9, 0.2]);
    let solutions = solve(&geometry, &target, &InverseSettings::default()).expect("reachable");
    assert_eq!(solutions.len(), 8, "{solutions:#?}");
    assert!(solutions.iter().all(|s| s.joints.iter().all(|v| v.abs() <= std::f64::consts::PI)), "nearest 0");
    let branches = round_trips(&geometry, 30, 2);
    assert!(branches.iter().all(|count| count % 2 == 0 && *count <= 8), "{branches:?}");
}

#[test]
fn no_branch_is_missed() {
    let model = bundled("universal-ur5");
    let geometry = Geometry::nominal(&model).expect("assembled");
    for q in configurations(&geometry, 12, 5) {
        let target = target_at(&geometry, &q);
        let usual = solve(&geometry, &target, &InverseSettings::default()).expect("reachable");
        let patient = InverseSettings { restarts: 1500, seed: 77, ..InverseSettings::default() };
        let patient = solve(&geometry, &target, &patient).expect("reachable");
        assert_eq!(patient.len(), usual.len(), "{q:?}");
    }
}

#[test]
fn a_wrist_that_stands_off_its_axes_is_no_obstacle() {
    let model = bundled("universal-ur10");
    let values: Vec<f64> = perturbed(&model, 3, 20.0);
    round_trips(&Geometry::new(&model, &values).expect("assembled"), 15, 3);
}

/// Nominal values, every free one off by up to `times` its common error.
fn perturbed(model: &Model, seed: u64, times: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut values = model.registry.nominal();
    for slot in model.free_slots() {
        values[slot] += times * model.registry[slot].tolerance * random.random_range(-1.0..1.0);
    }
    values
}

#[test]
fn strokes_and_loops_are_solved_through() {
    let model = bundled("kuka-ir663");
    round_trips(&Geometry::nominal(&model).expect("assembled"), 6, 11);
    let values = perturbed(&model, 4, 5.0);
    let branches = round_trips(&Geometry::new(&model, &values).expect("assembled"), 6, 12);
    assert!(branches.iter().all(|&count| count >= 1), "{branches:?}");
}

#[test]
fn a_redundant_robot_has_samples_or_the_nearest() {
    let model = bundled("barrett-wam");
    let geometry = Geometry::nominal(&model).expect("assembled");
    for q in configurations(&geometry, 10, 21) {
        let target = target_at(&geometry, &q);
        let samples = solve(&geometry, &target, &InverseSettings::default()).expect("reachable");
        assert!((2..=8).contains(&samples.len()));
        for sample in &samples {
            assert_eq!(sample.self_motions, 1);
            assert!(within_limits(&model, &sample.joints));
            assert!(sample.position_error < 1e-11 && sample.orientation_error < 1e-11);
        }
        let from: Vec<f64> = q.iter().map(|v| v + 0.01).collect();
        let settings = InverseSettings { from: Some(from.clone()), ..InverseSettings::default() };
        let nearest = solve(&geometry, &target, &settings).expect("reachable");
        let away = |a: &[f64]| a.iter().zip(&from).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        assert_eq!(nearest.len(), 1);
        assert!(away(&nearest[0].joints) < away(&q) + 1e-3, "{nearest:?} from {from:?}");
    }
}

#[test]
fn a_position_alone_leaves_motions_free() {
    let model = bundled("universal-ur5");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let target = Target { position: Point3::new(0.3, 0.4, 0.2), rotation: None, hold: Hold::POSE };
    let solutions = solve(&geometry, &target, &InverseSettings::default()).expect("reachable");
    assert_eq!(solutions.len(), 8);
    for solution in &solutions {
        assert_eq!((solution.self_motions, solution.orientation_error), (3, 0.0));
        assert!(miss(&geometry, &target, &solution.joints).0 < 1e-11);
    }
}

#[test]
fn from_a_configuration_the_branch_stays() {
    for name in ["universal-ur5", "kuka-ir663"] {
        let model = bundled(name);
        let geometry = Geometry::nominal(&model).expect("assembled");
        for q in configurations(&geometry, 10, 31) {
            let from: Vec<f64> = q.iter().map(|v| v + 1e-3).collect();
            let settings = InverseSettings { from: Some(from), restarts: 0, ..InverseSettings::default() };
            let solutions = solve(&geometry, &target_at(&geometry, &q), &settings).expect("reachable");
            assert_eq!(solutions.len(), 1);
            let off = solutions[0].joints.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6, "{name}: {q:?} became {:?}", solutions[0].joints);
        }
    }
}

#[test]
fn angles_are_those_of_the_turn_nearest_the_start() {
    let model = bundled("universal-ur5");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let q = [5.5, -4.2, 1.3, -0.7, 0.9, -6.0];
    let settings = InverseSettings { from: Some(q.to_vec()), ..InverseSettings::default() };
    let solutions = solve(&geometry, &target_at(&geometry, &q), &settings).expect("reachable");
    let off = solutions[0].joints.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{solutions:?}");
}

const PLANE: &str = "
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-2.0, 2.0]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 1.0, limits: [0.5, 2.5]}
  E: {antecedent: 2, d: 1.0}
tool: {frame: E}
";

#[test]
fn limits_that_stop_are_named() {
    let model = model_of(PLANE);
    let geometry = Geometry::nominal(&model).expect("assembled");
    let at = |x: f64, y: f64| Target { position: Point3::new(x, y, 0.0), rotation: None, hold: Hold::POSE };
    let solve = |target| solve(&geometry, &target, &InverseSettings::default());
    let solutions = solve(at(1.0, 1.0)).expect("reachable");
    assert_eq!(solutions.len(), 1, "the other elbow is beyond its limits: {solutions:?}");
    match solve(at(1.999, 0.0)) {
        Err(InverseError::OutOfReach { position_error, limits, joints, .. }) => {
            assert_eq!(limits, ["q2"]);
            let expected = 1.999 - 2.0 * 0.25_f64.cos();
            assert!((position_error - expected).abs() < 1e-6, "{position_error} against {expected}");
            assert!((joints[1] - 0.5).abs() < 1e-9);
        }
        other => panic!("{other:?}"),
    }
    match solve(at(0.0, 3.0)) {
        Err(error @ InverseError::OutOfReach { .. }) => {
            assert!(!error.to_string().contains("limits"), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_stretched_arm_converges() {
    let model = bundled("universal-ur5");
    let geometry = Geometry::nominal(&model).expect("assembled");
    for q in [[0.3, -0.8, 0.0, 0.4, 1.0, 0.2], [0.3, -0.8, 1.1, 0.4, 0.0, 0.2]] {
        let target = target_at(&geometry, &q);
        let solutions = solve(&geometry, &target, &InverseSettings::default()).expect("reachable");
        let (position, orientation) = miss(&geometry, &target, &solutions[0].joints);
        assert!(position < 1e-9 && orientation < 1e-9);
    }
}

#[test]
fn unsound_input_is_refused() {
    let model = bundled("universal-ur5");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let sound = Target { position: Point3::new(0.3, 0.2, 0.4), rotation: None, hold: Hold::POSE };
    let nan = Target { position: Point3::new(f64::NAN, 0.2, 0.4), rotation: None, hold: Hold::POSE };
    let far = Target { position: Point3::new(1e300, 0.0, 0.0), rotation: None, hold: Hold::POSE };
    let settings = InverseSettings::default();
    assert!(matches!(solve(&geometry, &nan, &settings), Err(InverseError::Input(_))));
    assert!(matches!(solve(&geometry, &far, &settings), Err(InverseError::Input(_))));
    let short = InverseSettings { from: Some(vec![0.0; 3]), ..settings.clone() };
    assert!(matches!(solve(&geometry, &sound, &short), Err(InverseError::Input(_))));
    let none = InverseSettings { tolerance: 0.0, ..settings };
    assert!(matches!(solve(&geometry, &sound, &none), Err(InverseError::Input(_))));
}

#[test]
fn threads_change_nothing() {
    for name in ["universal-ur5", "barrett-wam", "kuka-ir663"] {
        let model = bundled(name);
        let geometry = Geometry::nominal(&model).expect("assembled");
        let target = target_at(&geometry, &configurations(&geometry, 1, 8)[0]);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| solve(&geometry, &target, &InverseSettings::default()))
        };
        let alone = with(1);
        assert!(alone.is_ok());
        assert_eq!(alone, with(2));
        assert_eq!(alone, with(5));
    }
}

#[test]
fn slides_followers_and_few_axes_are_inverted() {
    // Joint 3 follows joint 2 by a fraction: a whole turn of q2 is no whole turn of the hand.
    let model = model_of(
        "
frames:
  1: {antecedent: 0, joint: prismatic, variable: lift, limits: [0.0, 0.6]}
  2: {antecedent: 1, joint: revolute, variable: q1, limits: [-3.0, 3.0], offset: 0.1}
  3: {antecedent: 2, joint: revolute, variable: q2, d: 0.4, limits: [-6.0, 6.0], direction: -1}
  4: {antecedent: 3, joint: revolute, d: 0.3}
  E: {antecedent: 4, d: 0.1, r: -0.2}
couplings: [4 = 0.5 * 3]
tool: {frame: E, at: [0.01, 0.02, 0.03]}
",
    );
    let geometry = Geometry::nominal(&model).expect("assembled");
    // Three variables against six equations: reachable poses are met, and the wider turns of q2 are distinguished.
    let branches = round_trips(&geometry, 30, 41);
    assert!(branches.iter().all(|&count| count >= 1), "{branches:?}");
}

/// A five-bar with two variables.
const PLATFORM: &str = "
frames:
  a1: {antecedent: 0, joint: revolute, variable: q1, limits: [0.5, 3.1]}
  a2: {antecedent: a1, joint: revolute, passive: true, d: 0.5}
  p: {antecedent: a2, d: 0.7}
  b1: {antecedent: 0, joint: revolute, variable: q2, d: 0.4, limits: [0.0, 2.6]}
  b2: {antecedent: b1, joint: revolute, passive: true, d: 0.5}
  m: {antecedent: b2, d: 0.7}
loops:
  five-bar: {frames: [p, m], kind: planar, meet: origin, branch: {a2: -1.0, b2: 1.0}, at: {q1: 2.2, q2: 0.9}}
tool: {frame: p}
";

#[test]
fn limits_of_passive_joints_are_kept() {
    let free = model_of(PLATFORM);
    let limited = model_of(
        &PLATFORM.replace("passive: true, d: 0.5}\n  p:", "passive: true, d: 0.5, limits: [-1.5, -0.6]}\n  p:"),
    );
    let (free, limited) =
        (Geometry::nominal(&free).expect("assembled"), Geometry::nominal(&limited).expect("assembled"));
    let joint = limited.model.frame("a2").expect("a frame");
    let mut placements = Placements::default();
    let (mut kept, mut refused) = (0, 0);
    for q in configurations(&free, 40, 61) {
        let target = Target { rotation: None, ..target_at(&free, &q) };
        match solve(&limited, &target, &InverseSettings::default()) {
            Ok(solutions) => {
                for solution in solutions {
                    limited.place(&solution.joints, &mut placements).expect("placed");
                    assert!((-1.5 - 1e-8..=-0.6 + 1e-8).contains(&placements.joints[joint]));
                    kept += 1;
                }
            }
            Err(InverseError::OutOfReach { limits, .. }) => {
                assert!(limits.contains(&"a2".to_string()), "{limits:?}");
                refused += 1;
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(kept > 0 && refused > 0, "{kept} {refused}");
}

#[test]
fn a_platform_of_closed_legs_is_inverted() {
    // On the declared assembly branch only.
    let model = model_of(PLATFORM);
    let geometry = Geometry::nominal(&model).expect("assembled");
    for q in configurations(&geometry, 20, 51) {
        let target = Target { rotation: None, ..target_at(&geometry, &q) };
        let solutions = solve(&geometry, &target, &InverseSettings::default()).expect("reachable");
        assert!(solutions.iter().any(|s| same(&model, &s.joints, &q)), "{q:?} not among {solutions:?}");
        for solution in &solutions {
            assert!(miss(&geometry, &target, &solution.joints).0 < 1e-11);
        }
    }
}
