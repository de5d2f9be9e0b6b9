//! Autocorrelation of residuals: found where it is, not found in noise.

use elastogeo::description::campaign::Campaign;
use elastogeo::diagnosis::{Autocorrelation, AutocorrelationSettings, Settings, Verdict, autocorrelation, diagnose};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::model::Model;
use elastogeo::observation::POSITION;
use elastogeo::simulation::{Plan, draw_configurations, generator, simulate};
use nalgebra::DVector;
use rand::seq::SliceRandom;
use rand_distr::{Distribution, StandardNormal};

const LOADS: [[f64; 6]; 3] =
    [[0.0, 0.0, -1000.0, 0.0, 0.0, 0.0], [0.0, 0.0, -2000.0, 0.0, 0.0, 0.0], [800.0, 0.0, 0.0, 0.0, 0.0, 0.0]];

/// 60 configurations of the KR-270, two markers, three loads, with times.
fn campaign(model: &Model) -> Campaign {
    let mut random = generator(4);
    let geometry = Geometry::nominal(model).expect("assembled");
    let plan = Plan {
        wrenches: LOADS.to_vec(),
        conditions: true,
        configurations: draw_configurations(&geometry, 60, 0.6, &mut random).expect("drawn"),
        markers: vec![Some(0), Some(1)],
        repeats: 1,
        observes: POSITION,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    simulate(model, &model.registry.nominal(), &plan, &mut random).expect("made")
}

fn noise(rows: usize, seed: u64) -> DVector<f64> {
    let mut random = generator(seed);
    DVector::from_fn(rows, |_, _| StandardNormal.sample(&mut random))
}

fn tested(model: &Model, campaign: &Campaign, residual: &DVector<f64>, seed: u64) -> Vec<Autocorrelation> {
    autocorrelation(model, campaign, residual, &AutocorrelationSettings::default(), seed)
}

fn p(found: &[Autocorrelation], against: &str) -> f64 {
    found.iter().find(|test| test.against == against).expect("tested").p
}

const TESTS: [&str; 4] = ["configuration", "load", "time", "within a pose"];

/// Over 40 draws of noise the probabilities are spread evenly: mean 1/2 +- 0.29/sqrt(40), none at the end.
#[test]
fn noise_is_not_autocorrelated() {
    let model = load_robot("kuka-kr270").expect("a robot").model;
    let campaign = campaign(&model);
    let mut all = vec![Vec::new(); TESTS.len()];
    for seed in 0..40 {
        let found = tested(&model, &campaign, &noise(3 * campaign.readings.len(), seed), seed);
        assert_eq!(found.iter().map(|test| test.against).collect::<Vec<_>>(), TESTS);
        TESTS.iter().zip(&mut all).for_each(|(test, all)| all.push(p(&found, test)));
    }
    for (test, all) in TESTS.iter().zip(all) {
        let mean = all.iter().sum::<f64>() / 40.0;
        assert!((mean - 0.5).abs() < 3.0 * 0.289 / 40.0_f64.sqrt(), "{test}: {mean}");
        let low = all.iter().filter(|p| **p < 0.25).count();
        assert!((3..=18).contains(&low), "{test}: {low} of 40 below a quarter");
        assert!(all.iter().filter(|p| **p < 0.01).count() <= 2, "{test}: {all:?}");
    }
}

/// What follows a joint, a load or time is found by the test against it; readings mixed by pose have it no more.
#[test]
fn planted_autocorrelation_is_found() {
    let model = load_robot("kuka-kr270").expect("a robot").model;
    let campaign = campaign(&model);
    let times = campaign.conditions.time.as_ref().expect("recorded");
    let last = times.iter().copied().fold(0.0, f64::max);
    let planted = |of: &dyn Fn(usize) -> f64| {
        let mut left = noise(3 * campaign.readings.len(), 9);
        (0..campaign.readings.len()).for_each(|i| left[3 * i + 1] += of(i));
        left
    };
    // What differs between configurations shows within them too: all readings of one are off alike.
    let smooth = planted(&|i| 1.5 * (campaign.configuration(i)[1] + campaign.configuration(i)[2]).sin());
    let drifting = planted(&|i| 2.0 * (times[i] / last - 0.5));
    let loaded = planted(&|i| if campaign.readings[i].wrench == LOADS[2] { 0.7 } else { 0.0 });
    for (name, left) in [("configuration", &smooth), ("time", &drifting), ("load", &loaded)] {
        let found = tested(&model, &campaign, left, 1);
        assert!(p(&found, name) < 0.01, "{name}: {found:?}");
    }
    for left in [&smooth, &drifting] {
        assert!(p(&tested(&model, &campaign, left, 1), "within a pose") < 0.01);
    }
    // Whole configurations mixed: neighbours are no longer correlated.
    let mut order: Vec<usize> = (0..60).collect();
    order.shuffle(&mut generator(2));
    let per_pose = smooth.len() / 60;
    let mixed = DVector::from_fn(smooth.len(), |row, _| smooth[order[row / per_pose] * per_pose + row % per_pose]);
    let found = tested(&model, &campaign, &mixed, 1);
    assert!(p(&found, "configuration") > 0.05 && p(&found, "within a pose") < 0.01, "{found:?}");
}

#[test]
fn autocorrelation_does_not_depend_on_threads() {
    let model = load_robot("kuka-kr270").expect("a robot").model;
    let campaign = campaign(&model);
    let left = noise(3 * campaign.readings.len(), 3);
    let answers = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| tested(&model, &campaign, &left, 5))
    });
    assert_eq!(answers[0], answers[1]);
}

/// Where no noise is stated, what nothing explains shows by its autocorrelation alone.
#[test]
fn unstated_noise_does_not_hide_a_gap() {
    let model = load_robot("universal-ur5").expect("a robot").model;
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut random = generator(6);
    let plan = Plan {
        wrenches: Vec::new(),
        conditions: false,
        configurations: draw_configurations(&geometry, 150, 0.2, &mut random).expect("drawn"),
        markers: vec![None],
        repeats: 2,
        observes: POSITION,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let mut campaign = simulate(&model, &model.registry.nominal(), &plan, &mut random).expect("made");
    campaign.state_noise(None, None);
    let held_out = vec![false; campaign.readings.len()];
    let diagnosed = |campaign: &Campaign| {
        let found = diagnose(&model, campaign, &held_out, &Settings::new(campaign, 1), &mut |_| {}).expect("diagnosed");
        (found.verdict, found.autocorrelation)
    };
    assert_eq!(diagnosed(&campaign).0, Verdict::NoGap);
    // Ripples that no effect of the catalogue has, alike in both readings of a configuration.
    for index in 0..campaign.readings.len() {
        let q = campaign.configuration(index).to_vec();
        let ripple = 1e-4 * (29.0 * q[0] * q[1] + 17.0 * q[2] * q[3]).sin();
        campaign.readings[index].measured[2] += ripple;
    }
    let (verdict, tests) = diagnosed(&campaign);
    assert!(matches!(verdict, Verdict::Unexplained | Verdict::PartlyExplained), "{verdict:?} {tests:?}");
    assert!(p(&tests, "within a pose") < 0.01, "{tests:?}");
    // The same with its noise stated is judged by the noise, and the autocorrelation only reported.
    campaign.state_noise(Some([3e-5; 3]), None);
    assert_eq!(diagnosed(&campaign).0, Verdict::Unexplained);
}
