//! Calibrations of simulated campaigns: schemes, bounds, priors, outliers, weights, and the derivatives they rest on.

use elastogeo::description::campaign::Campaign;
use elastogeo::estimation::{Calibration, CalibrationError, Scheme, Settings, calibrate, compare, weighed};
use elastogeo::files::load_robot;
use elastogeo::identifiability::Why;
use elastogeo::kinematics::Geometry;
use elastogeo::least_squares::Loss;
use elastogeo::model::Model;
use elastogeo::observation::{DISTANCE, Observes, POSE, POSITION};
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use nalgebra::Vector3;

fn robot(name: &str) -> Model {
    load_robot(name).expect("bundled").model
}

/// A robot's campaign of so many configurations, and its truth.
fn campaign(model: &Model, observes: Observes, count: usize) -> (Campaign, Vec<f64>) {
    let mut random = generator(5);
    let geometry = Geometry::nominal(model).expect("assembled");
    let markers = match observes {
        _ if observes == POSITION && !model.markers.is_empty() => (0..model.markers.len()).map(Some).collect(),
        _ => vec![None],
    };
    let estimate = observes != DISTANCE;
    let plan = Plan {
        wrenches: Vec::new(),
        conditions: false,
        configurations: draw_configurations(&geometry, count, 0.6, &mut random).expect("drawn"),
        markers,
        repeats: 1,
        observes,
        sigma: 5e-5,
        sigma_orientation: 5e-5,
        estimate: [estimate, estimate],
    };
    let truth = draw_errors(model, 1.0, 0.0, &mut random);
    (simulate(model, &truth, &plan, &mut random).expect("simulated"), truth)
}

fn fitted(model: &Model, campaign: &Campaign, settings: &Settings) -> Calibration {
    let held_out = vec![false; campaign.readings.len()];
    calibrate(model, campaign, &held_out, settings, &mut |_| {}).expect("calibrated")
}

fn apart(a: &Calibration, b: &Calibration) -> f64 {
    let sigmas = a.estimates.iter().zip(&b.estimates).filter(|(a, _)| a.identifiable());
    sigmas.map(|(a, b)| (a.value - b.value).abs() / a.ci95.expect("identifiable")).fold(0.0, f64::max)
}

#[test]
fn schemes_reach_the_same_parameters() {
    for (name, observes) in [("kuka-kr270", POSITION), ("universal-ur5", POSE)] {
        let mut model = robot(name);
        // Hundreds of turns are needed; without own weight each is quick.
        model.structure.masses.clear();
        let (campaign, _) = campaign(&model, observes, 40);
        let batch = fitted(&model, &campaign, &Settings::default());
        for scheme in [Scheme::PoseByPose, Scheme::Alternating] {
            let found = fitted(&model, &campaign, &Settings { scheme, ..Settings::default() });
            let apart = apart(&batch, &found);
            println!("{name} {scheme:?}: {apart:e} after {}", found.iterations);
            assert!(found.converged() && apart < 1e-4, "{name} {scheme:?}: {apart} of the interval");
        }
    }
}

/// Turns that have not converged are no calibration: their limit is the setting's, and the result says that it was reached.
#[test]
fn turns_that_do_not_end_are_not_converged() {
    let mut model = robot("universal-ur5");
    model.structure.masses.clear();
    let (campaign, _) = campaign(&model, POSE, 40);
    let settings = Settings { scheme: Scheme::Alternating, max_iterations: Some(5), ..Settings::default() };
    let found = fitted(&model, &campaign, &settings);
    assert!(!found.converged() && found.iterations == 5, "{}", found.iterations);
    assert!(Scheme::Alternating.iterations() <= 1000);
}

#[test]
fn a_held_parameter_stays_nominal() {
    let model = robot("universal-ur5");
    let (campaign, _) = campaign(&model, POSE, 40);
    for name in ["3.d", "base.x"] {
        let found = fitted(&model, &campaign, &Settings { hold: vec![name.into()], ..Settings::default() });
        let column = found.slots.iter().position(|&slot| model.registry[slot].name == name).expect("a column");
        assert_eq!(found.estimates[column].value, found.estimates[column].nominal, "{name}");
        assert!(!found.estimates[column].identifiable());
        let why = found.identifiability.dropped.iter().find(|(k, _)| *k == column).map(|(_, why)| *why);
        assert!(why == Some(Why::Held) || (name == "base.x" && why == Some(Why::Exact)), "{name}: {why:?}");
    }
}

#[test]
fn too_few_readings_are_refused() {
    let model = robot("universal-ur5");
    for count in [1, 3] {
        let (campaign, _) = campaign(&model, POSE, count);
        let held_out = vec![false; count];
        let found = calibrate(&model, &campaign, &held_out, &Settings::default(), &mut |_| {});
        assert!(matches!(found, Err(CalibrationError::TooFew { .. })), "{count}: {:?}", found.map(|f| f.ending));
    }
}

#[test]
fn a_bound_that_cuts_off_the_truth_is_reached() {
    let mut model = robot("universal-ur5");
    let (campaign, truth) = campaign(&model, POSE, 40);
    let slot = model.registry.slot("3.d").expect("a slot");
    let nominal = model.registry[slot].nominal;
    let limit = nominal + 0.5 * (truth[slot] - nominal);
    let side = usize::from(limit > nominal);
    model.registry.all_mut()[slot].bounds[side] = limit;
    let found = fitted(&model, &campaign, &Settings::default());
    let estimate = found.estimates.iter().find(|estimate| estimate.slot == slot).expect("estimated");
    assert!(estimate.at_bound && (estimate.value - limit).abs() < 1e-12, "{estimate:?}, limit {limit}");
}

#[test]
fn robust_losses_survive_gross_outliers() {
    let model = robot("universal-ur5");
    let (mut campaign, _) = campaign(&model, POSE, 100);
    let clean = fitted(&model, &campaign, &Settings::default());
    campaign.readings.iter_mut().step_by(10).for_each(|reading| reading.measured[0] += 5e-3);
    let with = |loss| apart(&clean, &fitted(&model, &campaign, &Settings { loss, ..Settings::default() }));
    let [squares, huber, tukey] = [Loss::Squares, Loss::Huber(1.345), Loss::Tukey(4.685)].map(with);
    println!("squares {squares} huber {huber} tukey {tukey}");
    assert!(squares > 5.0 && huber < squares / 5.0 && tukey < 1.0, "{squares} {huber} {tukey}");
}

#[test]
fn weights_by_direction_narrow_the_intervals() {
    let model = robot("universal-ur5");
    let (mut campaign, _) = campaign(&model, POSE, 100);
    for (k, reading) in campaign.readings.iter_mut().enumerate() {
        reading.measured[2] += 2e-3 * (12.9898 * k as f64).sin();
    }
    let found = compare(&model, &campaign, &[false; 100], &Settings::default()).expect("calibrated");
    let mean = |c: &Calibration| c.estimates.iter().filter_map(|e| e.ci95).map(f64::ln).sum::<f64>();
    assert!(mean(&found.wls) < mean(&found.ols));
}

#[test]
fn derivatives_agree_with_differences() {
    for (name, observes) in [("kuka-kr270", POSITION), ("kuka-ir663", POSE), ("kuka-kr270", DISTANCE)] {
        let mut model = robot(name);
        for k in 0..3 {
            let at = Vector3::from_fn(|i, _| if i == k { 4.0 } else { -1.0 });
            model.anchors.insert(format!("anchor{k}"), at);
        }
        let (campaign, mut values) = campaign(&model, observes, 6);
        for k in 0..6 {
            values[model.base + k] += 0.3 + 0.1 * k as f64;
            values[model.tool.1 + k] += 0.05 * (k + 1) as f64;
        }
        let slots: Vec<usize> = (model.base..model.base + 6)
            .chain(model.tool.1..model.tool.1 + 6)
            .chain(model.markers.iter().flat_map(|marker| marker.slot..marker.slot + 3))
            .chain(model.free_slots())
            .collect();
        let predictor = Predictor::new(&model, &campaign, slots.clone()).expect("a predictor").with_sag();
        let (mut exact, mut up, mut down) = Default::default();
        predictor.linearise(&values, true, &mut exact).expect("linearised");
        for (column, &slot) in slots.iter().enumerate() {
            let at = |step: f64, out: &mut Linearised| {
                let mut moved = values.clone();
                moved[slot] += step;
                predictor.linearise(&moved, false, out).expect("predicted");
            };
            at(1e-6, &mut up);
            at(-1e-6, &mut down);
            for row in 0..predictor.rows() {
                // An orientation's residual is a logarithm, whose derivative is the turn only to first order.
                let turn = observes == POSE && row % 6 >= 3;
                if turn {
                    continue;
                }
                let difference = (down.residual[row] - up.residual[row]) / 2e-6;
                let ours = exact.jacobian[row * slots.len() + column];
                let name = &model.registry[slot].name;
                assert!((ours - difference).abs() < 1e-6 * (1.0 + ours.abs()), "{name}: {ours} {difference}");
            }
        }
    }
}

#[test]
fn threads_and_repetition_change_no_bit() {
    let model = robot("kuka-kr270");
    let (campaign, _) = campaign(&model, POSITION, 80);
    let reference = fitted(&model, &campaign, &Settings::default());
    for threads in [1, 2, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let found = pool.install(|| fitted(&model, &campaign, &Settings::default()));
        let bits = |c: &Calibration| c.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&reference), "{threads} threads");
    }
}

/// Geometry from draw-wire lengths alone, and a prior that keeps what few readings cannot determine.
mod distances_and_priors {
    use elastogeo::estimation::{Settings, calibrate, split};
    use elastogeo::files::load_robot;
    use elastogeo::kinematics::Geometry;
    use elastogeo::observation::{DISTANCE, Observes, POSITION};
    use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
    use nalgebra::Vector3;

    fn plan(configurations: Vec<Vec<f64>>, observes: Observes) -> Plan {
        Plan {
            wrenches: Vec::new(),
            conditions: false,
            configurations,
            markers: vec![None],
            repeats: 1,
            observes,
            sigma: 5e-5,
            sigma_orientation: 0.0,
            estimate: [false, false],
        }
    }

    #[test]
    fn distances_from_four_anchors_calibrate() {
        let mut model = load_robot("universal-ur5").expect("bundled").model;
        for (name, at) in
            [("a", [2.0, 0.0, 0.0]), ("b", [0.0, 2.0, 0.1]), ("c", [-1.5, -1.5, 0.0]), ("d", [0.3, 0.2, 2.5])]
        {
            model.anchors.insert(name.into(), Vector3::from(at));
        }
        let mut random = generator(4);
        let values = draw_errors(&model, 1.0, 0.0, &mut random);
        let drawn =
            draw_configurations(&Geometry::nominal(&model).expect("assembled"), 80, 0.5, &mut random).expect("drawn");
        let campaign = simulate(&model, &values, &plan(drawn, DISTANCE), &mut random).expect("simulated");
        let held_out = split(&campaign, 0.25, 1);
        let found = calibrate(&model, &campaign, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated");
        assert!(found.before.check.distance[1] > 1e-3, "{:?}", found.before.check);
        assert!(found.after.check.distance[1] < 1.3 * 5e-5, "noise is 5e-5: {:?}", found.after.check);
        assert!((0.85..1.15).contains(&found.noise_ratio), "{}", found.noise_ratio);
    }

    #[test]
    fn a_prior_helps_where_readings_are_few() {
        let model = load_robot("universal-ur5").expect("bundled").model;
        let (mut with, mut without) = (0.0, 0.0);
        for seed in 0..10 {
            let mut random = generator(seed);
            let values = draw_errors(&model, 1.0, 0.0, &mut random);
            let geometry = Geometry::nominal(&model).expect("assembled");
            let drawn = draw_configurations(&geometry, 72, 0.6, &mut random).expect("drawn");
            let mut campaign = simulate(&model, &values, &plan(drawn, POSITION), &mut random).expect("simulated");
            campaign.state_noise(Some([1e-3; 3]), None); // an instrument as bad as the tolerances
            for (index, reading) in campaign.readings.iter_mut().enumerate() {
                // Only what is fitted is disturbed; the check stays clean.
                reading.measured[0] += if index >= 12 { 0.0 } else { 1e-3 * if index % 2 == 0 { 1.0 } else { -1.0 } };
                reading.check = Some(index >= 12);
            }
            let held_out = split(&campaign, 0.25, 1);
            let error = |prior| {
                let settings = Settings { prior, ..Settings::default() };
                calibrate(&model, &campaign, &held_out, &settings, &mut |_| {})
                    .expect("calibrated")
                    .after
                    .check
                    .distance[1]
            };
            with += error(true);
            without += error(false);
        }
        // 0.80 of the error without it when this was written.
        assert!(with < 0.9 * without, "{with} against {without}");
    }
}

/// Where the noise of orientations is not stated, it is what the readings show beside their lengths; outliers do not decide.
#[test]
fn angles_weigh_as_they_scatter() {
    let model = load_robot("universal-ur5").expect("bundled").model;
    let geometry = Geometry::nominal(&model).expect("assembled");
    for (seed, orientation) in [(1, 2e-4), (2, 2e-6)] {
        let mut random = generator(seed);
        let plan = Plan {
            wrenches: Vec::new(),
            conditions: false,
            configurations: draw_configurations(&geometry, 60, 0.8, &mut random).expect("drawn"),
            markers: vec![None],
            repeats: 1,
            observes: POSE,
            sigma: 2e-5,
            sigma_orientation: orientation,
            estimate: [true, true],
        };
        let truth = draw_errors(&model, 0.1, 0.0, &mut random);
        let stated = simulate(&model, &truth, &plan, &mut random).expect("simulated");
        let held_out = vec![false; stated.readings.len()];
        let as_stated = weighed(&model, &stated, &held_out, &Settings::default()).expect("calibrated");
        assert_eq!(*as_stated, stated, "what is stated stays");
        let mut unstated = stated.clone();
        unstated.state_noise(stated.sigma, None);
        unstated.readings[7].measured[0] += 0.01;
        let found = weighed(&model, &unstated, &held_out, &Settings::default()).expect("calibrated");
        let ratio = found.readings[0].noise.orientation / orientation;
        // Medians of 180 sizes scatter by a tenth.
        assert!((ratio - 1.0).abs() < 0.3, "{ratio} of {orientation}");
        // Where angles alone are stated, these stay, and lengths are weighed against them.
        let mut of_angles = stated.clone();
        of_angles.state_noise(None, Some(orientation));
        let found = weighed(&model, &of_angles, &held_out, &Settings::default()).expect("calibrated");
        let noise = found.readings[0].noise;
        assert_eq!(noise.orientation, orientation);
        assert!((noise.position[0] / 2e-5 - 1.0).abs() < 0.3, "{:?}", noise.position);
    }
}
