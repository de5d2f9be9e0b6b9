//! Planned measurements against random ones, against their own prediction, and against published intervals.

use elastogeo::estimation::{Settings, What, calibrate, errors_of};
use elastogeo::files::load_robot;
use elastogeo::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::math::median;
use elastogeo::model::Model;
use elastogeo::observation::{POSE, POSITION};
use elastogeo::parameter::{Group, Kind};
use elastogeo::planning::{self, Optimality, PlanningError, Request, Sight, plan};
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Loaded, Plan, draw_errors, draw_in_box, generator, joint_box, simulate};
use nalgebra::{DMatrix, Point3, Vector3};
use rand::RngExt;
use rayon::prelude::*;

use crate::cli::{PLANAR, run};
use crate::figures::recorded;

const GEOMETRIC: What = What { geometric: true, elastic: false };

pub fn request(model: &Model, count: usize) -> Request {
    Request {
        count,
        what: GEOMETRIC,
        observes: POSITION,
        markers: vec![None],
        loads: Vec::new(),
        repeats: 1,
        sigma: 30e-6,
        sigma_orientation: 50e-6,
        estimate: [true, true],
        criterion: Optimality::TestError,
        sight: None,
        within: joint_box(model, 1.0),
        workspace: None,
        apart: 0.0,
        tests: Vec::new(),
        tested_within: joint_box(model, 1.0),
        measured: None,
        design: None,
        hold: Vec::new(),
        scaling: Scaling::Norm,
        tolerance: Criterion::Relative(DEFAULT_TOLERANCE),
        seed: 1,
        settings: planning::Settings::default(),
    }
}

/// Configurations where a cell's work is done: ranges in deg (strokes in mm). Those below cover a workpiece of about
/// half a metre (UR5) to a metre, the tool tilted by some 20 deg.
fn work(model: &Model, ranges: &[[f64; 2]], count: usize, seed: u64) -> Vec<Loaded> {
    let geometry = Geometry::nominal(model).expect("assembled");
    let size = |k: usize| if model.variables[k].is_angle { 1f64.to_radians() } else { 1e-3 };
    let within: Vec<[f64; 2]> = ranges.iter().enumerate().map(|(k, range)| range.map(|v| v * size(k))).collect();
    let (drawn, _) = draw_in_box(&geometry, &within, count, &mut generator(seed), |_, _| true);
    drawn.into_iter().map(|q| (q, [0.0; 6])).collect()
}

const UR5: [[f64; 2]; 6] =
    [[-15.0, 15.0], [-105.0, -75.0], [75.0, 105.0], [-135.0, -105.0], [-100.0, -80.0], [-30.0, 30.0]];
const IR663: [[f64; 2]; 6] =
    [[-15.0, 15.0], [750.0, 850.0], [700.0, 800.0], [-20.0, 20.0], [75.0, 105.0], [-30.0, 30.0]];
const KR270: [[f64; 2]; 6] = [[-15.0, 15.0], [-98.0, -72.0], [72.0, 98.0], [-20.0, 20.0], [32.0, 58.0], [-30.0, 30.0]];

/// Position error (rms, m) at fresh working configurations after calibration at the given ones.
fn achieved(
    model: &Model,
    of: &Request,
    truth: &[f64],
    configurations: &[Vec<f64>],
    fresh: &[Vec<f64>],
    seed: u64,
) -> f64 {
    let mut random = generator(seed);
    let mut plan = Plan {
        configurations: configurations.to_vec(),
        markers: of.markers.clone(),
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: of.observes,
        sigma: of.sigma,
        sigma_orientation: of.sigma_orientation,
        estimate: of.estimate,
    };
    let campaign = simulate(model, truth, &plan, &mut random).expect("simulated");
    let held_out = vec![false; campaign.readings.len()];
    let settings = Settings { prior: of.settings.prior, ..Settings::default() };
    let found = calibrate(model, &campaign, &held_out, &settings, &mut |_| {}).expect("calibrated");
    (plan.configurations, plan.sigma, plan.sigma_orientation) = (fresh.to_vec(), 0.0, 0.0);
    let check = simulate(model, truth, &plan, &mut random).expect("simulated");
    let mut left = Linearised::default();
    let predictor = Predictor::new(model, &check, Vec::new()).expect("readings");
    predictor.linearise(&found.values, false, &mut left).expect("predicted");
    errors_of(&check, &left.residual, |_| true).distance[1]
}

/// Draws of the noise over which a robot's error is averaged: its expectation is compared, not luck.
const DRAWS: u64 = 4;

/// Planned against random configurations from the whole box: medians of 20 seeds at fresh working configurations.
fn compared(of: &Request, model: &Model, ranges: &[[f64; 2]], count: usize) -> [f64; 3] {
    let planned = plan(model, of, &mut |_| {}).expect("planned");
    let configurations: Vec<Vec<f64>> = planned.stations.iter().map(|station| station.q.clone()).collect();
    let fresh: Vec<Vec<f64>> = work(model, ranges, 40, 78).into_iter().map(|(q, _)| q).collect();
    let pairs: Vec<[f64; 2]> = (0..20)
        .into_par_iter()
        .map(|seed| {
            let mut random = generator(1000 + seed);
            let mut truth = draw_errors(model, 0.3, 0.0, &mut random);
            if of.estimate[0] {
                (0..6).for_each(|k| truth[model.base + k] += 0.1 * (2.0 * random.random::<f64>() - 1.0));
            }
            // What the drawn robot can take.
            let geometry = Geometry::new(model, &truth).expect("assembled");
            let (random, _) = draw_in_box(&geometry, &of.within, count, &mut random, |_, _| true);
            [&configurations, &random].map(|measured| {
                let squares = (0..DRAWS).map(|k| achieved(model, of, &truth, measured, &fresh, seed + 100 * k).powi(2));
                (squares.sum::<f64>() / DRAWS as f64).sqrt()
            })
        })
        .collect();
    let of_kind = |k: usize| median(&mut pairs.iter().map(|pair| pair[k]).collect::<Vec<_>>()).expect("some");
    [of_kind(0), of_kind(1), planned.error]
}

#[test]
fn twenty_planned_do_as_well_as_forty_random() {
    let ur5 = load_robot("universal-ur5").expect("bundled").model;
    let ir663 = load_robot("kuka-ir663").expect("bundled").model;
    let kr270 = load_robot("kuka-kr270").expect("bundled").model;
    let cases = [
        (Request { tests: work(&ur5, &UR5, 200, 77), ..request(&ur5, 20) }, &ur5, &UR5),
        (
            Request {
                tests: work(&ir663, &IR663, 200, 77),
                observes: POSE,
                estimate: [false, false],
                ..request(&ir663, 20)
            },
            &ir663,
            &IR663,
        ),
        (
            Request {
                tests: work(&kr270, &KR270, 200, 77),
                markers: vec![Some(0), Some(1), Some(2)],
                ..request(&kr270, 20)
            },
            &kr270,
            &KR270,
        ),
    ];
    let mut lines = Vec::new();
    for (of, model, ranges) in &cases {
        let [planned, random, promised] = compared(of, model, *ranges, 40);
        assert!(planned <= random, "{}: {planned} against {random}", model.name);
        assert!((0.75..1.25).contains(&(planned / promised)), "{}: {planned}, promised {promised}", model.name);
        let [planned, random] = [planned, random].map(|error| 1e3 * error);
        lines.push(format!("{}: {planned:.5} mm at 20 planned, {random:.5} mm at 40 random", model.name));
    }
    recorded("twenty-planned", "cargo test twenty_planned", &lines);
}

/// With tolerances taken for known, fewer readings than parameters do: robots off by their tolerances are found nearly as well as
/// promised, and far better than they are uncalibrated.
#[test]
fn fewer_readings_than_parameters_do_with_tolerances() {
    let model = load_robot("universal-ur5").expect("bundled").model;
    let without = Request { tests: work(&model, &UR5, 200, 77), ..request(&model, 8) };
    assert!(matches!(plan(&model, &without, &mut |_| {}), Err(PlanningError::TooFew { .. })));
    let of = Request { settings: planning::Settings { prior: true, ..without.settings.clone() }, ..without };
    let planned = plan(&model, &of, &mut |_| {}).expect("planned");
    assert!(planned.campaign.rows() < planned.deviations.len(), "{}", planned.deviations.len());
    let configurations: Vec<Vec<f64>> = planned.stations.iter().map(|station| station.q.clone()).collect();
    let fresh: Vec<Vec<f64>> = work(&model, &UR5, 40, 78).into_iter().map(|(q, _)| q).collect();
    let seeds = 40;
    let squares = (0..seeds).into_par_iter().map(|seed| {
        let truth = draw_errors(&model, 1.0, 0.0, &mut generator(1000 + seed));
        achieved(&model, &of, &truth, &configurations, &fresh, seed).powi(2)
    });
    let found = (squares.sum::<f64>() / seeds as f64).sqrt();
    println!("8 planned with tolerances: {:.4} mm, promised {:.4} mm", 1e3 * found, 1e3 * planned.error);
    assert!((0.75..1.5).contains(&(found / planned.error)), "{found}, promised {}", planned.error);
    let folder = tempfile::tempdir().expect("a folder");
    let command = ["plan", "universal-ur5", "--poses", "8", "--unknown-base", "--unknown-tool"];
    let ran = run(folder.path(), &command);
    assert!(ran.status != 0 && ran.err.contains("--prior"), "{}", ran.err);
    let ran = run(folder.path(), &[&command[..], &["--prior"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
}

/// The promised error, from the planned campaign's Jacobian by a pseudo-inverse.
#[test]
fn the_promise_is_that_of_the_covariance() {
    let model = load_robot("universal-ur5").expect("bundled").model;
    let of = Request { tests: work(&model, &UR5, 10, 77), ..request(&model, 12) };
    let planned = plan(&model, &of, &mut |_| {}).expect("planned");
    let kept: Vec<usize> = planned.deviations.iter().map(|(slot, _)| *slot).collect();
    let jacobian = |campaign| {
        let mut found = Linearised::default();
        let predictor = Predictor::new(&model, campaign, kept.clone()).expect("readings");
        predictor.linearise(&model.registry.nominal(), true, &mut found).expect("predicted");
        DMatrix::from_row_slice(found.residual.len(), kept.len(), &found.jacobian)
    };
    let j = jacobian(&planned.campaign);
    let norms: Vec<f64> = j.column_iter().map(|c| c.norm()).collect();
    let scaled = DMatrix::from_fn(j.nrows(), j.ncols(), |i, k| j[(i, k)] / norms[k]);
    let inverse = scaled.pseudo_inverse(1e-14).expect("inverse");
    let inverse = DMatrix::from_fn(inverse.nrows(), inverse.ncols(), |i, k| of.sigma * inverse[(i, k)] / norms[i]);
    let tests = Plan {
        configurations: of.tests.iter().map(|(q, _)| q.clone()).collect(),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSITION,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let tests = simulate(&model, &model.registry.nominal(), &tests, &mut generator(1)).expect("simulated");
    let error = (jacobian(&tests) * &inverse).norm() / (tests.readings.len() as f64).sqrt();
    assert!((planned.error / error - 1.0).abs() < 1e-6, "{} against {error}", planned.error);
    for (k, (_, sigma)) in planned.deviations.iter().enumerate() {
        assert!((sigma / inverse.row(k).norm() - 1.0).abs() < 1e-6);
    }
}

/// Each criterion's plan is at least as good by its own measure as the others'.
#[test]
fn each_criterion_is_best_at_what_it_asks() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("arm.yaml"), PLANAR).expect("written");
    let by = |criterion: &str| {
        let arguments = ["plan", "arm.yaml", "--poses", "6", "--format", "json", "--criterion", criterion];
        let ran = run(folder.path(), &arguments);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let json: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
        json["error"]["planned"].as_f64().expect("a number")
    };
    let best = by("test-error");
    for other in &Optimality::NAMES[1..] {
        assert!(best <= by(other) * 1.02, "{other}: {} against {best}", by(other));
    }
}

#[test]
fn rules_are_kept_and_what_is_measured_counts() {
    let model = load_robot("kuka-kr270").expect("bundled").model;
    let geometry = Geometry::nominal(&model).expect("assembled");
    let sight = Sight { instrument: Point3::new(5.0, 1.0, 1.0), cone: 50f64.to_radians(), facing: Vector3::z() };
    let workspace = [[0.5, 3.0], [-1.5, 1.5], [0.2, 2.5]];
    let of = Request {
        sight: Some(sight),
        workspace: Some(workspace),
        apart: 0.3,
        markers: vec![Some(0), Some(1), Some(2)],
        ..request(&model, 10)
    };
    let planned = plan(&model, &of, &mut |_| {}).expect("planned");
    let mut placements = Placements::default();
    for (k, station) in planned.stations.iter().enumerate() {
        geometry.place(&station.q, &mut placements).expect("placed");
        for &marker in &station.markers {
            let marker = marker.expect("a marker");
            let frame = &placements.frames[model.markers[marker].frame];
            let point = frame * geometry.marker(marker);
            let axis = frame.rotation * Vector3::z();
            assert!(axis.angle(&(sight.instrument - point)) <= sight.cone);
            assert!((0..3).all(|k| (workspace[k][0]..=workspace[k][1]).contains(&point[k])), "{point}");
        }
        let near = planned.stations[..k].iter().map(|other| (other.at - station.at).norm()).fold(9.0, f64::min);
        assert!(near >= 0.3, "{near}");
    }
    // What is measured already is kept, and lowers the error.
    let more = Request { measured: Some(planned.campaign.clone()), count: 5, ..of };
    let added = plan(&model, &more, &mut |_| {}).expect("planned");
    let before = added.before.expect("distinguished");
    assert!((before / planned.error - 1.0).abs() < 0.3, "{before} {}", planned.error);
    assert!(added.error < 0.9 * before, "{} {before}", added.error);
}

/// 18 configurations, three points nine times, 0.1 mm: the intervals of Tables I to III of the KR-270 paper.
#[test]
fn intervals_are_those_of_the_kr270_paper() {
    let model = load_robot("kuka-kr270").expect("bundled").model;
    let of = Request {
        markers: vec![Some(0), Some(1), Some(2)],
        repeats: 3,
        sigma: 0.1e-3,
        tolerance: Criterion::Noise,
        ..request(&model, 18)
    };
    let planned = plan(&model, &of, &mut |_| {}).expect("planned");
    let typical = |group: Group, kind: Kind, size: f64| {
        let of = planned.deviations.iter().filter(|(slot, _)| {
            let parameter = &model.registry[*slot];
            parameter.group == group && parameter.kind == kind
        });
        median(&mut of.map(|(_, sigma)| 1.96 * sigma / size).collect::<Vec<_>>()).expect("some")
    };
    let deg = 1f64.to_radians();
    // Medians of the printed intervals: lengths in mm, angles in deg.
    let cases = [
        ("base, mm", typical(Group::Base, Kind::Length, 1e-3), 0.049),
        ("base, deg", typical(Group::Base, Kind::Angle, deg), 0.0025),
        ("tool, mm", typical(Group::Tool, Kind::Length, 1e-3), 0.05),
        ("lengths, mm", typical(Group::Geometry, Kind::Length, 1e-3), 0.104),
        ("angles, deg", typical(Group::Geometry, Kind::Angle, deg), 0.0145),
    ];
    let line = |(what, ours, paper): (&str, f64, f64)| format!("{what}: {ours:.4}, paper {paper}");
    let geometry = [line(cases[3]), line(cases[4])];
    recorded("planned-intervals", "cargo test intervals_are_those_of_the_kr270_paper", &geometry);
    for (what, ours, paper) in cases {
        assert!((0.2..5.0).contains(&(ours / paper)), "{what}: {ours} against {paper}");
    }
}

#[test]
fn threads_change_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let with = |jobs: &str| {
        let ran = run(folder.path(), &["plan", "universal-ur5", "--poses", "12", "--jobs", jobs]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        ran.out
    };
    assert_eq!(with("1"), with("3"));
}

#[test]
fn a_plan_can_be_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = ["plan", "kuka-kr270", "--poses", "6", "--what", "elastic", "--wrench", "0,0,-2500", "--wrench"];
    let ran = run(folder.path(), &[&table[..], &["2000,0,0", "--table", "plan.csv"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let text = std::fs::read_to_string(folder.path().join("plan.csv")).expect("written");
    assert!(text.starts_with("pose,q1,q2,q3,q4,q5,q6,fx,fy,fz,mx,my,mz\np001,"), "{text}");
    let simulate = ["simulate", "kuka-kr270", "--poses", "plan.csv", "--observes", "deflection", "--into", "c"];
    let ran =
        run(folder.path(), &[&simulate[..], &["--errors", "0", "--elastic-errors", "1", "--check", "0"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.out.starts_with("6 readings at 6 configurations"), "{}", ran.out);
    assert_eq!(run(folder.path(), &["identify", "c"]).status, 0);
}

#[test]
fn wrong_plans_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases: &[(&[&str], &str)] = &[
        (&["--poses", "3"], "at least 9 are needed"),
        (&["--poses", "0"], "from 1 to 1000"),
        (&["--poses", "12", "--criterion", "test"], "valid here: `test-error`"),
        (&["--poses", "12", "--what", "elastc"], "did you mean `elastic`?"),
        (&["--poses", "12", "--what", "elastic"], "give --wrench"),
        (&["--poses", "12", "--what", "elastic", "--wrench", "0,0,-100"], "nothing"),
        (&["--poses", "12", "--test", "none.csv"], "there is no file `none.csv`"),
        (&["--poses", "12", "--cone", "20"], "--instrument"),
        (&["--poses", "12", "--instrument", "1,2"], "give 3 finite numbers"),
        (&["--poses", "12", "--instrument", "1,2,3", "--facing", "0,0,0"], "give a direction"),
        (&["--poses", "12", "--range", "q7=1:2"], "did you mean `q1`?"),
        (&["--poses", "12", "--range", "q1=2:1"], "low must be below high"),
        (&["--poses", "12", "--range", "q1=2:x"], "name=low:high"),
        (&["--poses", "12", "--range", "q1=400:500"], "outside the variable's limits"),
        (&["--poses", "12", "--range", "q1=0:90", "--test-range", "q1=-90:-10"], "goes from 0.0000 to 90.0000"),
        (&["--poses", "12", "--test-range", "q1"], "--test-range `q1`"),
        (&["--poses", "12", "--workspace", "5000,6000,0,1,0,1"], "widen"),
        (&["--poses", "12", "--apart", "5000"], "lower --apart"),
        (&["--poses", "12", "--noise", "0"], "above 0"),
        (&["--poses", "12", "--table", "nowhere/p.csv"], "there is no folder"),
        (&["--poses", "12", "--add-to", "none"], "there is no file"),
        (&["--poses", "12", "--hold", "2.dd"], "did you mean `2.d`?"),
    ];
    for (arguments, expected) in cases {
        let ran =
            run(folder.path(), &[&["plan", "universal-ur5", "--unknown-base", "--unknown-tool"], *arguments].concat());
        let clash = arguments.contains(&"--add-to");
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.err);
        assert!(
            ran.err.contains(expected) || clash && ran.err.contains("cannot be used"),
            "{arguments:?}: {}",
            ran.err
        );
        assert_eq!(ran.out, "", "{arguments:?}");
    }
}
