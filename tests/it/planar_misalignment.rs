//! Deflections of planar loops whose axes are a little off: they change by as little as the axes do.

use crate::loaded::deflection;
use crate::support::{bundled, model_of};

/// A parallelogram arm whose forearm is driven by a crank on the axis of the shoulder.
const PARALLELOGRAM: &str = "units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}
variables: [q1, q2, q3]
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 500}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 200, alpha: -90, theta: -90}
  3: {antecedent: 2, joint: revolute, passive: true, d: 900}
  crank: {antecedent: 1, joint: revolute, variable: q3, coaxial: 2, theta: -180}
  rod: {antecedent: crank, joint: revolute, passive: true, d: 300}
  rod-end: {antecedent: rod, d: 900}
  rear: {antecedent: 3, d: -300}
  E: {antecedent: 3, d: 1000}
loops:
  par: {frames: [rear, rod-end], kind: planar, meet: origin, branch: {3: 90, rod: 90}, at: {q2: 0, q3: 0}}
tool: {frame: E}
joint_stiffness:
  2: {kar: {value: 3.0e5}}
  crank: {kar: {value: 2.0e5}}
";

/// Three legs, one of which has bearings that give way in all directions.
const THREE_LEGS: &str = "units: {length: mm, angle: deg, rotational_stiffness: N.m/rad, stiffness: N/mm}
variables: [q1, q2, q3]
frames:
  a1: {antecedent: 0, joint: revolute, variable: q1, gamma: 210, d: 400}
  a2: {antecedent: a1, joint: revolute, passive: true, d: 250}
  a3: {antecedent: a2, joint: revolute, passive: true, d: 250}
  P: {antecedent: a3, d: 80}
  b1: {antecedent: 0, joint: revolute, variable: q2, gamma: 330, d: 400}
  b2: {antecedent: b1, joint: revolute, passive: true, d: 250}
  be: {antecedent: b2, d: 250}
  pb: {antecedent: P, gamma: -60, d: 80}
  c1: {antecedent: 0, joint: revolute, variable: q3, gamma: 90, d: 400}
  c2: {antecedent: c1, joint: revolute, passive: true, d: 250}
  ce: {antecedent: c2, d: 250}
  pc: {antecedent: P, gamma: 60, d: 80}
loops:
  lb: {frames: [be, pb], kind: planar, meet: origin, branch: {a2: 100, a3: -50, b2: 100}, at: {q1: 130, q2: 130, q3: 130}}
  lc: {frames: [ce, pc], kind: planar, meet: origin, branch: {c2: 100}, at: {q1: 130, q2: 130, q3: 130}}
tool: {frame: P}
joint_stiffness:
  a1: {kar: {value: 8000}}
  b1: {kar: {value: 8000}}
  c1: {kar: {value: 8000}}
  a2: {kr: {value: 2.0e4}, krr: {value: 3.0e4}}
";

/// N, N.m.
const WRENCH: [f64; 6] = [300.0, -200.0, -500.0, 20.0, -30.0, 40.0];
/// By how much a deflection may change, as a fraction of it, per rad or metre by which an axis is off: the axes' levers are a few
/// tenths of a metre, and out of the plane a joint sees its wrench by the sum of a few such changes.
const MOST: f64 = 20.0;

/// Every out-of-plane constant of every frame, changed by little and by more.
fn is_continuous(model: &elastogeo::model::Model, frame: &str, q: &[f64]) {
    let nominal = model.registry.nominal();
    let at = |values: &[f64]| deflection(model, values, q, (frame, [0.05, 0.03, 0.02]), &WRENCH, true);
    let aligned = at(&nominal);
    let size = [0, 3].map(|k| aligned.fixed_rows::<3>(k).norm());
    assert!(size[0] > 1e-5, "{}: nothing deflects", model.name);
    let mut tried = 0;
    for of in &model.frames[1..] {
        for symbol in ["alpha", "beta", "b", "r"] {
            let Some(slot) = model.registry.slot(&format!("{}.{symbol}", of.name)) else { continue };
            let unit = if matches!(symbol, "b" | "r") { 1e-3 } else { 1f64.to_radians() };
            for off in [1e-9, 1e-6, 1e-3, 0.02] {
                let mut values = nominal.clone();
                values[slot] += off * unit;
                let change = at(&values) - aligned;
                for (k, size) in size.into_iter().enumerate() {
                    let change = change.fixed_rows::<3>(3 * k).norm() / size;
                    assert!(
                        change <= MOST * off * unit + 1e-9,
                        "{}: {}.{symbol} by {off} changes the deflection by {change:e} of it",
                        model.name,
                        of.name
                    );
                }
                tried += 1;
            }
        }
    }
    assert!(tried > 40, "{}: {tried}", model.name);
}

#[test]
fn misalignments_change_deflections_of_planar_loops_by_as_much() {
    let degrees = |q: &[f64]| -> Vec<f64> { q.iter().map(|v| v.to_radians()).collect() };
    is_continuous(&bundled("five-bar"), "a3", &degrees(&[120.0, 60.0]));
    is_continuous(&bundled("palletiser"), "flange", &degrees(&[10.0, 20.0, 30.0, 5.0]));
    is_continuous(&model_of(PARALLELOGRAM), "E", &degrees(&[10.0, 15.0, 5.0]));
    is_continuous(&model_of(THREE_LEGS), "P", &degrees(&[125.0, 130.0, 135.0]));
    let ir663 = bundled("kuka-ir663");
    let turned = degrees(&[20.0, 30.0, 60.0, 40.0]);
    is_continuous(&ir663, "E", &[turned[0], 0.8, 0.75, turned[1], turned[2], turned[3]]);
}

/// Displacement (m) of the pin of the five-bar of 300, 240 and 300 mm under a force: J J' f / k.
fn by_circles(q: [f64; 2], force: [f64; 2], stiffness: f64) -> [f64; 2] {
    let pin = |q: [f64; 2]| -> [f64; 2] {
        let elbow = |at: f64, q: f64| [at + 0.24 * q.cos(), 0.24 * q.sin()];
        let [a, b] = [elbow(-0.15, q[0]), elbow(0.15, q[1])];
        let between = [b[0] - a[0], b[1] - a[1]];
        let length = between[0].hypot(between[1]);
        let height = (0.3f64.powi(2) - 0.25 * length * length).sqrt() / length;
        [0, 1].map(|k| 0.5 * (a[k] + b[k]) + height * [-between[1], between[0]][k])
    };
    let step = 1e-6;
    let by = [0, 1].map(|k| {
        let moved = |sign: f64| {
            let mut q = q;
            q[k] += sign * step;
            pin(q)
        };
        let (plus, minus) = (moved(1.0), moved(-1.0));
        [0, 1].map(|axis| (plus[axis] - minus[axis]) / (2.0 * step))
    });
    let torque = by.map(|column| column[0] * force[0] + column[1] * force[1]);
    [0, 1].map(|axis| (by[0][axis] * torque[0] + by[1][axis] * torque[1]) / stiffness)
}

/// What the tilt of an elbow leaves of the compliance of a five-bar: all of it.
#[test]
fn a_tilted_axis_does_not_stiffen_a_five_bar() {
    let model = bundled("five-bar");
    let q = [120f64.to_radians(), 60f64.to_radians()];
    let nominal = model.registry.nominal();
    let slot = model.registry.slot("a2.beta").expect("a tilt");
    let at = |beta: f64| {
        let mut values = nominal.clone();
        values[slot] = beta;
        deflection(&model, &values, &q, ("a3", [0.0; 3]), &[100.0, 50.0, 0.0, 0.0, 0.0, 0.0], false)
    };
    // Two motors of 8000 N.m/rad: compliance J J' / k of the tool, J by differences of where the two arms' circles meet.
    let expected = by_circles(q, [100.0, 50.0], 8000.0);
    for beta in [0.0, 1e-11, 1e-6, 1e-4] {
        let found = at(beta);
        for k in 0..2 {
            assert!(
                (found[k] - expected[k]).abs() < 2e-4 * expected[k] + 10.0 * beta * expected[1],
                "{beta:e}: {found}"
            );
        }
    }
}
