//! Springs fitted by their logarithms: the same optimum, values above 0, intervals of factors.

use elastogeo::estimation::{Calibration, Scheme, Settings, calibrate};
use elastogeo::model::Model;
use elastogeo::observation::DEFLECTION;
use elastogeo::simulation::{Plan, generator, simulate};

use crate::cli::run;
use crate::support::model_of;

/// Three joints that give, with the stiffnesses (N.m/rad) of the description.
fn arm(stiffness: [f64; 3]) -> Model {
    let [a, b, c] = stiffness;
    model_of(&format!(
        "units: {{length: m, angle: deg}}
variables: [q1, q2, q3]
frames:
  1: {{antecedent: 0, joint: revolute, variable: q1, limits: [-150, 150]}}
  2: {{antecedent: 1, joint: revolute, variable: q2, alpha: -90, limits: [-120, 60]}}
  3: {{antecedent: 2, joint: revolute, variable: q3, d: 0.8, limits: [-100, 100]}}
  E: {{antecedent: 3, d: 0.7}}
tool: {{frame: E}}
joint_stiffness:
  1: {{kar: {{value: {a:e}, identifiable: true}}}}
  2: {{kar: {{value: {b:e}, identifiable: true}}}}
  3: {{kar: {{value: {c:e}, identifiable: true}}}}
"
    ))
}

const TRUTH: [f64; 3] = [4e5, 9e5, 2e5];

fn fitted(described: [f64; 3], sigma: f64, logarithms: bool) -> (Calibration, Vec<f64>) {
    let model = arm(described);
    let mut values = model.registry.nominal();
    let slots = ["joint1.kar", "joint2.kar", "joint3.kar"].map(|name| model.registry.slot(name).expect("a spring"));
    slots.iter().zip(TRUTH).for_each(|(&slot, stiffness)| values[slot] = 1.0 / stiffness);
    let angles = |k: usize| (0..3).map(|j| ((k * (2 * j + 3)) as f64 * 0.37).sin()).collect();
    let plan = Plan {
        conditions: false,
        configurations: (0..12).map(angles).collect(),
        observes: DEFLECTION,
        markers: vec![None],
        repeats: 1,
        sigma,
        sigma_orientation: 0.0,
        estimate: [false, false],
        wrenches: vec![[0.0, 0.0, -800.0, 0.0, 0.0, 0.0], [300.0, 300.0, 0.0, 0.0, 0.0, 0.0]],
    };
    let campaign = simulate(&model, &values, &plan, &mut generator(5)).expect("simulated");
    let settings = Settings { logarithms, ..Settings::default() };
    let held_out = vec![false; campaign.readings.len()];
    let found = calibrate(&model, &campaign, &held_out, &settings, &mut |_| {}).expect("calibrated");
    assert!(found.converged(), "{}", found.ending);
    let own = slots.iter().map(|&slot| found.values[slot]).collect();
    (found, own)
}

#[test]
fn logarithms_have_the_same_optimum_from_near_and_far() {
    let (_, linear) = fitted(TRUTH, 2e-5, false);
    for described in [TRUTH, [3e3, 8e8, 1e3], [1e9, 1e3, 5e8]] {
        let (found, own) = fitted(described, 2e-5, true);
        for ((value, linear), truth) in own.iter().zip(&linear).zip(TRUTH) {
            assert!(*value > 0.0 && (value / linear - 1.0).abs() < 1e-6, "{described:?}: {own:?} {linear:?}");
            assert!((value * truth - 1.0).abs() < 0.2, "{value} {truth}");
        }
        // To first order the same width; its ends are as far by factor.
        for estimate in found.estimates.iter().filter(|estimate| estimate.identifiable()) {
            let ([low, high], ci95) = (estimate.interval.expect("of factors"), estimate.ci95.expect("a width"));
            assert!(low > 0.0 && (low * high / estimate.value.powi(2) - 1.0).abs() < 1e-9);
            assert!(((high / low).ln() * estimate.value / (2.0 * ci95) - 1.0).abs() < 1e-9);
        }
    }
    let (found, _) = fitted(TRUTH, 2e-5, false);
    assert!(found.estimates.iter().all(|estimate| estimate.interval.is_none()));
}

/// Noise that outweighs a joint nearly rigid: its compliance comes out above 0 all the same, and its interval too.
#[test]
fn no_logarithm_ends_at_or_below_zero() {
    let (found, own) = fitted(TRUTH, 3e-3, true);
    assert!(own.iter().all(|value| *value > 0.0), "{own:?}");
    assert!(found.estimates.iter().flat_map(|estimate| estimate.interval).all(|[low, _]| low > 0.0));
}

#[test]
fn the_command_takes_logarithms_and_refuses_them_in_turns() {
    let folder = tempfile::tempdir().expect("a folder");
    let made =
        ["simulate", "kuka-kr270", "--poses", "20", "--observes", "deflection", "--wrench=0,0,-2500", "--into", "d"];
    assert_eq!(run(folder.path(), &made).status, 0);
    let identify = ["identify", "d", "--what", "elastic", "--logarithms"];
    let ran = run(folder.path(), &[&identify[..], &["--format", "json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let parameters = json["parameters"].as_array().expect("parameters");
    let ends = |of: &serde_json::Value| Some([of["interval"][0].as_f64()?, of["interval"][1].as_f64()?]);
    let found: Vec<_> = parameters.iter().filter_map(|of| Some((ends(of)?, of["value"].as_f64()?))).collect();
    assert!(!found.is_empty() && found.iter().all(|([low, high], value)| 0.0 < *low && low < value && value < high));
    let ran = run(folder.path(), &[&identify[..], &["--scheme", "alternating"]].concat());
    assert!(ran.status != 0 && ran.err.contains("need the batch scheme"), "{}", ran.err);
    assert!(Settings::default().scheme == Scheme::Batch);
}
