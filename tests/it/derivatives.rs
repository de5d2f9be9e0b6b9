//! Analytic derivatives and closures against independent ones, on random robots.

use elastogeo::kinematics::{
    AssemblyError, By, ErrorColumns, Geometry, Placements, Rates, rotation_vector, slider_crank,
};
use elastogeo::model::Model;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::random_robots::{Draw, Sketch, planar, serial, spatial, two_loops};
use crate::support::{bundled, model_of};

/// A loop counts as too near a singularity when a passive joint moves faster than this (rad or m per rad or m):
/// the error of a central difference grows with the fifth power of it, to 2e-8 at steps of 1e-6 and rates of 10.
const FASTEST: f64 = 10.0;
const STEP: f64 = 1e-6;
/// Truncation as above; rounding 1e-16 * 10 / 1e-6 = 1e-9, and the closure's Newton step squared, 1e-16 / 1e-6.
const TOLERANCE: f64 = 1e-6;

fn configuration(model: &Model, sketch: &Sketch) -> Vec<f64> {
    let at = sketch.at();
    let value = |name: &str| at.iter().find(|(known, _)| known == name).expect("a variable").1;
    model.variables.iter().map(|variable| value(&variable.name)).collect()
}

fn fastest(model: &Model, rates: &Rates) -> f64 {
    let slots = (0..model.registry.all().len()).filter_map(|slot| rates.driver(slot));
    let drivers: Vec<usize> = (0..model.variables.len()).chain(slots).collect();
    let of_joint = |joint: usize| drivers.iter().map(move |_| joint).zip(drivers.clone());
    (0..model.frames.len())
        .flat_map(of_joint)
        .map(|(joint, driver)| rates.rate(joint, driver).abs())
        .fold(0.0, f64::max)
}

/// Checks every frame's columns by every variable and every slot. False where the configuration is singular.
pub fn columns_agree(model: &Model, q: &[f64]) -> bool {
    let nominal = model.registry.nominal();
    let Ok(geometry) = Geometry::new(model, &nominal) else { return false };
    let mut at = Placements::default();
    if geometry.place(q, &mut at).is_err() {
        return false;
    }
    let mut rates = Rates::new(model);
    rates.evaluate(&geometry, q, &at);
    let fastest = fastest(model, &rates);
    if fastest.is_nan() || fastest > FASTEST {
        return false;
    }
    let slots = (0..nominal.len()).map(By::Slot);
    let by: Vec<By> = (0..model.variables.len()).map(By::Variable).chain(slots).collect();
    let mut columns = vec![[0.0; 6]; by.len()];
    let analytic: Vec<Vec<[f64; 6]>> = (0..model.frames.len())
        .map(|frame| {
            ErrorColumns::new(&geometry, &rates, frame, &by).evaluate(&geometry, &at, &rates, &mut columns);
            columns.clone()
        })
        .collect();
    for (column, by) in by.iter().enumerate() {
        let moved = |step: f64| {
            let (mut values, mut q) = (nominal.clone(), q.to_vec());
            match *by {
                By::Variable(k) => q[k] += step,
                By::Slot(slot) => values[slot] += step,
            }
            let mut placements = Placements::default();
            Geometry::new(model, &values).expect("assembled").place(&q, &mut placements).expect("placed");
            placements
        };
        let (after, before) = (moved(STEP), moved(-STEP));
        for (frame, analytic) in analytic.iter().enumerate() {
            let (a, b) = (&after.frames[frame], &before.frames[frame]);
            let v = (a.translation.vector - b.translation.vector) / (2.0 * STEP);
            let w = rotation_vector(&(a.rotation * b.rotation.inverse())) / (2.0 * STEP);
            let found = analytic[column];
            let size = found.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for (k, expected) in v.iter().chain(w.iter()).enumerate() {
                let what = match *by {
                    By::Variable(k) => model.variables[k].name.clone(),
                    By::Slot(slot) => model.registry[slot].name.clone(),
                };
                assert!(
                    (found[k] - expected).abs() <= TOLERANCE * size,
                    "frame {} by {what}, component {k}: {} against {expected}",
                    model.frames[frame].name,
                    found[k]
                );
            }
        }
        for joint in 0..model.frames.len() {
            let difference = (after.joints[joint] - before.joints[joint]) / (2.0 * STEP);
            let driver = match *by {
                By::Variable(k) => Some(k),
                By::Slot(slot) => rates.driver(slot),
            };
            let rate = driver.map_or(0.0, |driver| rates.rate(joint, driver));
            assert!((rate - difference).abs() <= TOLERANCE * rate.abs().max(1.0), "{joint} {by:?} {rate} {difference}");
        }
    }
    true
}

/// Checks a robot where its loops are known to close and near there; how many configurations were regular. None counts
/// where the first, from which the loops are followed, is near a dead point: moved a little, they may not close there.
fn robot_agrees(sketch: &Sketch, seed: u64) -> usize {
    let model = model_of(&sketch.yaml());
    let known = configuration(&model, sketch);
    let draw = &mut Draw::new(seed);
    if !columns_agree(&model, &known) {
        return 0;
    }
    let near: Vec<f64> = known.iter().map(|v| v + draw.within(-0.03, 0.03)).collect();
    1 + usize::from(columns_agree(&model, &near))
}

/// At the known configuration the tree written anew places every frame as the library does.
fn known_configuration_is_found(sketch: &Sketch) {
    let model = model_of(&sketch.yaml());
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut at = Placements::default();
    geometry.place(&configuration(&model, sketch), &mut at).expect("placed");
    for part in sketch.parts.iter().filter(|_| !sketch.loops.is_empty() && sketch.couplings.is_empty()) {
        let frame = model.frame(&part.name).expect("a frame");
        let difference = (at.frames[frame].to_homogeneous() - sketch.pose(&part.name).to_homogeneous()).amax();
        assert!(difference < 1e-9, "{}: {difference:e}", part.name);
    }
}

/// The same robots each time; others by `PROPTEST_RNG_SEED=n`.
fn settings() -> ProptestConfig {
    let own = ProptestConfig::default();
    let rng_seed = if own.rng_seed == RngSeed::Random { RngSeed::Fixed(1) } else { own.rng_seed };
    ProptestConfig { cases: 96, failure_persistence: None, rng_seed, ..own }
}

proptest! {
    #![proptest_config(settings())]

    #[test]
    fn open_chains(seed: u64) {
        // Followers of followers may move faster than the limit, too.
        prop_assume!(robot_agrees(&serial(seed), seed) > 0);
    }

    #[test]
    fn planar_loops(seed: u64) {
        let sketch = planar(seed);
        prop_assume!(robot_agrees(&sketch, seed) > 0);
        known_configuration_is_found(&sketch);
    }

    #[test]
    fn loops_that_share_joints(seed: u64) {
        let sketch = two_loops(seed);
        prop_assume!(robot_agrees(&sketch, seed) > 0);
        known_configuration_is_found(&sketch);
    }

    #[test]
    fn loops_in_space(seed: u64) {
        prop_assume!(robot_agrees(&spatial(seed), seed) > 0);
    }

    #[test]
    fn planar_and_spatial_closure_agree(seed: u64) {
        let mut sketch = planar(seed);
        prop_assume!(sketch.loops[0].3 == "frame" && sketch.part("b1").constants[3] == 0.0);
        let flat = model_of(&sketch.yaml());
        sketch.loops[0].2 = "spatial";
        let space = model_of(&sketch.yaml());
        let q = configuration(&flat, &sketch);
        let q: Vec<f64> = q.iter().map(|v| v + 0.01).collect();
        let (flat, space) = (Geometry::nominal(&flat), Geometry::nominal(&space));
        prop_assume!(flat.is_ok() && space.is_ok());
        let (flat, space) = (flat.expect("flat"), space.expect("space"));
        let (mut a, mut b) = (Placements::default(), Placements::default());
        prop_assume!(flat.place(&q, &mut a).is_ok());
        let mut rates = [Rates::new(flat.model), Rates::new(space.model)];
        rates[0].evaluate(&flat, &q, &a);
        prop_assume!(fastest(flat.model, &rates[0]) < FASTEST);
        space.place(&q, &mut b).expect("placed");
        rates[1].evaluate(&space, &q, &b);
        for (joint, (a, b)) in a.joints.iter().zip(&b.joints).enumerate() {
            prop_assert!((a - b).abs() < 1e-9, "{} {a} {b}", flat.model.frames[joint].name);
            for k in 0..q.len() {
                prop_assert!((rates[0].rate(joint, k) - rates[1].rate(joint, k)).abs() < 1e-7);
            }
        }
    }
}

#[test]
fn most_random_robots_are_regular() {
    for (generate, least) in [(serial as fn(u64) -> Sketch, 110), (planar, 60), (two_loops, 40), (spatial, 40)] {
        let regular = (0..120).filter(|&seed| robot_agrees(&generate(seed), seed) > 0).count();
        assert!(regular >= least, "{regular} of 120, {least} expected");
    }
}

/// The four-bar by the formula in the literature (with its signs put right): an independent function. The angle, and a
/// measure of how far the linkage is from flat, where it is zero.
fn printed_four_bar(theta_2: f64, theta_8: f64) -> Option<(f64, f64)> {
    let (d3, d9, d10, d11) = (1.047, 0.473, 0.4, 1.212);
    let delta = theta_2 - theta_8;
    let (x, y, z, w) = (d9 * delta.cos(), d3 - d9 * delta.sin(), -d10, -d11);
    let (b1, b2, b3) = (2.0 * z * y, 2.0 * z * x, w * w - x * x - y * y - z * z);
    let n = b1 * b1 + b2 * b2;
    let root = (n - b3 * b3).sqrt();
    (!root.is_nan()).then(|| ((b1 * b3 + b2 * root).atan2(b2 * b3 - b1 * root), root / n.sqrt()))
}

#[test]
fn the_declared_branch_stays_over_the_whole_range() {
    let model = bundled("kuka-ir663");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut placements = Placements::default();
    let [two, eight] = [1, 2].map(|k| model.variables[k].limits.expect("limits"));
    let steps = 120;
    let (mut closed, mut open, mut flat) = (0, 0, 0);
    for i in 0..=steps {
        for j in 0..=steps {
            let along = |[low, high]: [f64; 2], k: usize| low + (high - low) * k as f64 / steps as f64;
            let q = [0.0, along(two, i), along(eight, j), 0.3, 0.4, 0.5];
            let angle = |screw: usize, stroke: f64| {
                let slot = model.actuators[screw].slot;
                slider_crank(stroke, &geometry.values()[slot..slot + 5]).expect("a triangle").0
            };
            match (printed_four_bar(angle(0, q[1]), angle(1, q[2])), geometry.place(&q, &mut placements)) {
                (Some((expected, _)), Ok(())) => {
                    let found = placements.joints[model.frame("3").expect("a frame")];
                    let turn = std::f64::consts::TAU;
                    let difference = found - expected - turn * ((found - expected) / turn).round();
                    assert!(difference.abs() < 1e-7, "{q:?}: {found} against {expected}");
                    closed += 1;
                }
                // A linkage within 5 deg or so of flat is refused (7 % of the determinant where it is declared), and no other.
                (Some((_, apart)), Err(AssemblyError::Singular { name, .. })) => {
                    assert_eq!(name, "four-bar");
                    assert!(apart < 0.1, "{q:?}: {apart}");
                    flat += 1;
                }
                (None, Err(AssemblyError::Loop { name, gap, .. })) => {
                    assert_eq!(name, "four-bar");
                    assert!(gap.greatest() > 0.0 && gap.greatest() < 2.0, "{gap}");
                    open += 1;
                }
                (expected, found) => panic!("{q:?}: {expected:?} against {found:?}"),
            }
        }
    }
    assert!(closed > 1000 && flat < closed / 20, "{closed} {open} {flat}");
}

#[test]
fn a_loop_out_of_reach_is_named_with_its_gap() {
    let model = model_of(
        "
frames:
  a1: {antecedent: 0, joint: revolute, variable: q1}
  a2: {antecedent: a1, joint: revolute, passive: true, d: 1.0}
  a3: {antecedent: a2, d: 1.2}
  b0: {antecedent: 0, d: 2.0}
  b1: {antecedent: b0, joint: revolute, passive: true}
  b2: {antecedent: b1, d: 1.2}
loops:
  linkage: {frames: [a3, b2], kind: planar, meet: origin, branch: {a2: -1, b1: 2}, at: {q1: 0.8}}
tool: {frame: a3}
",
    );
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut placements = Placements::default();
    geometry.place(&[1.0], &mut placements).expect("placed");
    let q = 3.0_f64;
    let distance = (2.0 - q.cos()).hypot(q.sin());
    match geometry.place(&[q], &mut placements) {
        Err(AssemblyError::Loop { name, gap, .. }) => {
            assert_eq!(name, "linkage");
            let least = distance - 2.4;
            assert!(gap.length > 0.5 * least && gap.length < 3.0 * least, "{gap} against {least}");
            assert!(gap.to_string().ends_with(" m") && gap.angle == 0.0, "{gap}");
        }
        other => panic!("{other:?}"),
    }
}
