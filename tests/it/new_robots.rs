//! Bundled robots that are files and nothing else, each against formulas of its own: rail and SCARA, five-bar, seven axes,
//! palletiser, hexapod.

use elastogeo::estimation::{Settings, calibrate};
use elastogeo::identifiability::{Column, Criterion, Scaling, reduce};
use elastogeo::kinematics::{Geometry, Hold, InverseSettings, Target, rotation_vector, solve};
use elastogeo::model::Model;
use elastogeo::observation::POSE;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use elastogeo::state::{Loads, Mechanics};
use nalgebra::{IsometryMatrix3, Matrix6, Rotation3, Translation3, Vector3, Vector6};
use rand::RngExt;
use rayon::prelude::*;

use crate::derivatives::columns_agree;
use crate::identifiability::observation;
use crate::recovery::covered;
use crate::support::{bundled, nominal_pose};

type Pose = IsometryMatrix3<f64>;

/// A robot, and what is known of it without its description.
struct Case {
    name: &'static str,
    /// Pose of the tool at the variables, m and rad.
    forward: fn(&[f64]) -> Pose,
    /// Compliance along or about each variable, m/N or rad/(N.m).
    compliance: &'static [f64],
    /// Motions of the variables that leave the tool where it is.
    self_motions: usize,
    /// Parameters that poses of the tool tell: base and tool known, and unknown.
    ranks: [usize; 2],
}

/// Ranks with base and tool unknown: 4 R + 2 P + 6 for R revolute and P prismatic joints in series (Everett, Driels and
/// Mooring 1987), 42 for a hexapod (twelve centres of joints and six zeros); those of the two planar linkages are counts of
/// singular values, with nothing to compare them with.
const CASES: [Case; 5] = [
    Case {
        name: "scara-rail",
        forward: scara,
        compliance: &[1.0 / 2.0e7, 1.0 / 1.5e5, 1.0 / 6.0e4, 0.0, 0.0],
        self_motions: 1,
        ranks: [17, 4 * 3 + 2 * 2 + 6],
    },
    Case {
        name: "five-bar",
        forward: five_bar,
        compliance: &[1.0 / 8000.0, 1.0 / 8000.0],
        self_motions: 0,
        ranks: [14, 20],
    },
    Case {
        name: "franka-panda",
        forward: panda,
        compliance: &[1.0 / 14e3, 1.0 / 14e3, 1.0 / 14e3, 1.0 / 14e3, 1.0 / 9e3, 1.0 / 9e3, 1.0 / 9e3],
        self_motions: 1,
        ranks: [28, 4 * 7 + 6],
    },
    Case {
        name: "palletiser",
        forward: palletiser,
        compliance: &[1.0 / 2.0e6, 1.0 / 1.5e6, 1.0 / 1.2e6, 1.0 / 2.0e5],
        self_motions: 0,
        ranks: [23, 29],
    },
    Case { name: "hexapod", forward: hexapod, compliance: &[1.0 / 5.0e7; 6], self_motions: 0, ranks: [42, 42] },
];

fn pose(position: [f64; 3], rotation: Rotation3<f64>) -> Pose {
    Pose::from_parts(Translation3::from(Vector3::from(position)), rotation)
}

fn about_x(angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::x_axis(), angle)
}

fn about_z(angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), angle)
}

fn scara(q: &[f64]) -> Pose {
    let [rail, q1, q2, down, q4] = q.try_into().expect("five");
    let (x, y) = (0.325 * f64::cos(q1) + 0.275 * f64::cos(q1 + q2), 0.325 * f64::sin(q1) + 0.275 * f64::sin(q1 + q2));
    pose([rail + x, y, 0.42 - down - 0.03], about_z(q1 + q2) * about_x(std::f64::consts::PI) * about_z(q4))
}

/// Two circles about the elbows meet in the pin, above the line from elbow to elbow.
fn five_bar(q: &[f64]) -> Pose {
    let elbow = |x: f64, q: f64| Vector3::new(x + 0.24 * q.cos(), 0.24 * q.sin(), 0.0);
    let (left, right) = (elbow(-0.15, q[0]), elbow(0.15, q[1]));
    let (middle, half) = ((left + right) / 2.0, (right - left) / 2.0);
    let pin = middle + Vector3::z().cross(&half.normalize()) * (0.3 * 0.3 - half.norm_squared()).sqrt();
    let link = pin - left;
    pose(pin.into(), about_z(link.y.atan2(link.x)))
}

/// Craig's table: alpha and a of the body before, theta, d.
fn panda(q: &[f64]) -> Pose {
    let quarter = std::f64::consts::FRAC_PI_2;
    let table = [
        (0.0, 0.0, 0.333),
        (-quarter, 0.0, 0.0),
        (quarter, 0.0, 0.316),
        (quarter, 0.0825, 0.0),
        (-quarter, -0.0825, 0.384),
        (quarter, 0.0, 0.0),
        (quarter, 0.088, 0.0),
    ];
    let rows = table.into_iter().zip(q).map(|((alpha, a, d), q)| {
        pose([a, 0.0, 0.0], Rotation3::identity()) * pose([0.0; 3], about_x(alpha)) * pose([0.0, 0.0, d], about_z(*q))
    });
    rows.fold(Pose::identity(), |pose, row| pose * row) * pose([0.0, 0.0, 0.107], Rotation3::identity())
}

/// The crank's angle is the forearm's against the ground, and the flange stays level.
fn palletiser(q: &[f64]) -> Pose {
    let reach = 0.3 + 1.2 * q[1].sin() + 1.4 * q[2].cos() + 0.25;
    let height = 0.8 + 1.2 * q[1].cos() - 1.4 * q[2].sin() - 0.2;
    let down = about_x(std::f64::consts::PI);
    pose([reach * q[0].cos(), reach * q[0].sin(), height], about_z(q[0]) * down * about_z(q[3]))
}

const BASE: [f64; 6] = [10.0, 110.0, 130.0, 230.0, 250.0, 350.0];
const PLATFORM: [f64; 6] = [50.0, 70.0, 170.0, 190.0, 290.0, 310.0];

/// Vectors along the legs of a hexapod at a pose of the tool, and the joints of the platform from the tool centre point.
fn legs(tool: &Pose) -> [(Vector3<f64>, Vector3<f64>); 6] {
    let on_circle = |radius: f64, deg: f64| Vector3::new(deg.to_radians().cos(), deg.to_radians().sin(), 0.0) * radius;
    std::array::from_fn(|k| {
        let arm = tool.rotation * (on_circle(0.25, PLATFORM[k]) - Vector3::z() * 0.06);
        (tool.translation.vector + arm - on_circle(0.4, BASE[k]), arm)
    })
}

/// Newton's method on the lengths of the legs.
fn hexapod(q: &[f64]) -> Pose {
    let mut tool = pose([0.0, 0.0, 0.56], Rotation3::identity());
    for _ in 0..50 {
        let legs = legs(&tool);
        let short = Vector6::from_fn(|k, _| 0.45 + q[k] - legs[k].0.norm());
        let rates = Matrix6::from_fn(|k, j| {
            let along = legs[k].0.normalize();
            if j < 3 { along[j] } else { legs[k].1.cross(&along)[j - 3] }
        });
        let step = rates.lu().solve(&short).expect("regular");
        tool.translation.vector += step.fixed_rows::<3>(0);
        tool.rotation = Rotation3::new(step.fixed_rows::<3>(3).into_owned()) * tool.rotation;
    }
    tool
}

fn apart(a: &Pose, b: &Pose) -> f64 {
    (a.to_homogeneous() - b.to_homogeneous()).amax()
}

fn drawn(geometry: &Geometry, count: usize, seed: u64) -> Vec<Vec<f64>> {
    draw_configurations(geometry, count, 0.8, &mut generator(seed)).expect("drawn")
}

#[test]
fn new_robots_stand_where_formulas_put_them() {
    for case in &CASES {
        let model = bundled(case.name);
        let configurations = drawn(&Geometry::nominal(&model).expect("assembled"), 100, 1);
        let most = configurations.iter().map(|q| apart(&nominal_pose(&model, q), &(case.forward)(q)));
        let most = most.fold(0.0, f64::max);
        println!("{}: {most:.1e}", case.name);
        assert!(most < 1e-12, "{}: {most:e}", case.name);
    }
}

#[test]
fn new_robots_are_solved_as_formulas_say() {
    for case in &CASES {
        let model = bundled(case.name);
        let geometry = Geometry::nominal(&model).expect("assembled");
        for q in drawn(&geometry, 6, 2) {
            let wanted = (case.forward)(&q);
            let target = Target {
                position: wanted.translation.vector.into(),
                rotation: Some(wanted.rotation),
                hold: Hold::POSE,
            };
            let settings = InverseSettings { restarts: 24, ..InverseSettings::default() };
            let solutions =
                solve(&geometry, &target, &settings).unwrap_or_else(|error| panic!("{} {q:?}: {error}", case.name));
            for solution in &solutions {
                assert_eq!(solution.self_motions, case.self_motions, "{} {q:?}", case.name);
                let away = apart(&(case.forward)(&solution.joints), &wanted);
                assert!(away < 1e-10, "{} {q:?}: {away:e}", case.name);
            }
            let turn = std::f64::consts::TAU;
            let same = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-7 || ((a - b).abs() - turn).abs() < 1e-7;
            let near = |found: &[f64]| found.iter().zip(&q).all(same);
            let known = solutions.iter().any(|solution| near(&solution.joints));
            assert!(case.self_motions > 0 || known, "{} {q:?} is not in {solutions:?}", case.name);
        }
    }
}

/// Lengths of a hexapod's legs at poses of its platform, by vectors alone.
#[test]
fn a_hexapod_is_solved_for_the_lengths_of_its_legs() {
    let model = bundled("hexapod");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut random = generator(3);
    for _ in 0..6 {
        let mut within = |most: f64| most * (2.0 * random.random::<f64>() - 1.0);
        let at = [within(0.05), within(0.05), 0.56 + within(0.03)];
        let rotation = Rotation3::new(Vector3::new(within(0.1), within(0.1), within(0.2)));
        let expected = legs(&pose(at, rotation)).map(|(leg, _)| leg.norm() - 0.45);
        let target = Target { position: at.into(), rotation: Some(rotation), hold: Hold::POSE };
        let settings = InverseSettings { restarts: 24, ..InverseSettings::default() };
        let solutions = solve(&geometry, &target, &settings).expect("reachable");
        assert_eq!(solutions.len(), 1, "{solutions:?}");
        let away = solutions[0].joints.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(away < 1e-9, "{away:e}");
    }
}

#[test]
fn error_jacobians_of_new_robots_are_differences() {
    for case in &CASES {
        let model = bundled(case.name);
        let configurations = drawn(&Geometry::nominal(&model).expect("assembled"), 6, 4);
        let regular = configurations.iter().filter(|q| columns_agree(&model, q)).count();
        println!("{}: {regular} of 6", case.name);
        assert!(regular >= 4, "{}: {regular}", case.name);
    }
}

/// By the library's reduction, and by the gap in the singular values of its columns at length one.
#[test]
fn new_robots_have_known_ranks() {
    for case in &CASES {
        let model = bundled(case.name);
        let geometry = Geometry::nominal(&model).expect("assembled");
        let (matrix, names) = observation(&geometry, &drawn(&geometry, 60, 5));
        let about = |name: &String| Column::about(&model.registry[model.registry.slot(name).expect("a slot")], false);
        let about: Vec<Column> = names.iter().map(about).collect();
        let rank = reduce(&matrix, &about, Scaling::Norm, Criterion::Relative(1e-8)).rank;
        assert_eq!(rank, case.ranks[0], "{}", case.name);
        let mut columns = nalgebra::DMatrix::from_row_slice(matrix.len() / names.len(), names.len(), &matrix);
        columns.column_iter_mut().for_each(|mut column| column /= column.norm().max(f64::MIN_POSITIVE));
        let mut singular: Vec<f64> = columns.singular_values().iter().copied().collect();
        singular.sort_by(|a, b| b.total_cmp(a));
        let last = singular[rank - 1] / singular[0];
        let next = singular.get(rank).map_or(0.0, |value| value / singular[0]);
        println!("{}: rank {rank} of {}, then {last:.1e} | {next:.1e}", case.name, names.len());
        assert!(last > 1e-5 && next < 1e-12, "{}: {last:e} {next:e}", case.name);
    }
}

fn plan(model: &Model) -> Plan {
    Plan {
        wrenches: Vec::new(),
        conditions: false,
        configurations: drawn(&Geometry::nominal(model).expect("assembled"), 40, 6),
        markers: vec![None],
        repeats: 1,
        observes: POSE,
        sigma: 20e-6,
        sigma_orientation: 50e-6,
        estimate: [true, true],
    }
}

/// Shares of intervals that hold the truth and their standard error, and the mean squared noise ratio, over some seeds.
fn shares(case: &Case, second_order: bool) -> [f64; 3] {
    let model = bundled(case.name);
    let plan = plan(&model);
    let settings = Settings { second_order, ..Settings::default() };
    let share = |seed: u64| {
        let truth = draw_errors(&model, 1.0, 0.0, &mut generator(seed));
        let campaign = simulate(&model, &truth, &plan, &mut generator(1_000_000 + seed)).expect("simulated");
        let none = vec![false; campaign.readings.len()];
        let found = calibrate(&model, &campaign, &none, &settings, &mut |_| {}).expect("calibrated");
        assert!(found.converged(), "{} {seed}: {} after {}", case.name, found.ending, found.iterations);
        // Closed loops that are off their description may tell more than it does.
        assert!(found.identifiability.rank >= case.ranks[1], "{} {seed}", case.name);
        let held = covered(&truth, &found);
        [held.iter().filter(|held| **held).count() as f64 / held.len() as f64, found.noise_ratio.powi(2)]
    };
    let trials: Vec<[f64; 2]> = (0..SEEDS).into_par_iter().map(share).collect();
    let n = SEEDS as f64;
    let mean = |k: usize| trials.iter().map(|trial| trial[k]).sum::<f64>() / n;
    let variance = trials.iter().map(|trial| (trial[0] - mean(0)).powi(2)).sum::<f64>() / (n - 1.0);
    [mean(0), (variance / n).sqrt(), mean(1)]
}

const SEEDS: u64 = 20;

/// What dropped parameters do in second order matters to the palletiser and widens the hexapod's intervals beyond need: its
/// share is nominal without it.
#[test]
fn intervals_of_new_robots_hold_the_truth() {
    for case in &CASES {
        let [all, first] = [true, false].map(|second_order| shares(case, second_order));
        let line = format!(
            "{}: {:.3} +- {:.3} of the intervals hold the truth over {SEEDS} seeds; {:.3} +- {:.3} with the second order left out",
            case.name, all[0], all[1], first[0], first[1]
        );
        let [share, deviation, noise] = if case.name == "hexapod" { first } else { all };
        assert!((share - 0.95).abs() < 3.0 * deviation && deviation < 0.02, "{line}");
        assert!(all[0] > 0.95 - 3.0 * all[1] && (noise - 1.0).abs() < 0.05, "{line} {noise}");
        println!("{line}");
    }
}

/// Springs at the variables give J c J^T, J being the formula's differences; of the hexapod that is the inverse of the sum
/// of its legs' stiffnesses.
#[test]
fn new_robots_yield_as_their_springs_do() {
    const STEP: f64 = 1e-5;
    for case in &CASES {
        let model = bundled(case.name);
        let loads = Loads { weight: false, wrench: true };
        let mechanics = Mechanics::new(&model, &model.registry.nominal(), loads, &[]).expect("assembled");
        let mut state = mechanics.state();
        for q in drawn(&Geometry::nominal(&model).expect("assembled"), 10, 7) {
            let mut expected = Matrix6::zeros();
            for (k, compliance) in case.compliance.iter().enumerate() {
                let at = |step: f64| {
                    let mut q = q.clone();
                    q[k] += step;
                    (case.forward)(&q)
                };
                let (after, before) = (at(STEP), at(-STEP));
                let moved = after.translation.vector - before.translation.vector;
                let turned = rotation_vector(&(after.rotation * before.rotation.inverse()));
                let column = Vector6::from_fn(|i, _| if i < 3 { moved[i] } else { turned[i - 3] } / (2.0 * STEP));
                expected += column * column.transpose() * *compliance;
            }
            mechanics.place(&q, &mut state).expect("placed");
            let point = mechanics.point(&state, None, &[0.0; 6]);
            let found = mechanics.compliance(&state, &point);
            let off = (found - expected).amax() / expected.amax();
            assert!(off < 1e-7, "{} {q:?}: {off:e}", case.name);
            if case.name == "hexapod" {
                let mut stiffness = Matrix6::zeros();
                for (leg, arm) in legs(&(case.forward)(&q)) {
                    let (along, about) = (leg.normalize(), arm.cross(&leg.normalize()));
                    let row = Vector6::new(along.x, along.y, along.z, about.x, about.y, about.z);
                    stiffness += row * row.transpose() * 5.0e7;
                }
                let off = (found * stiffness - Matrix6::identity()).amax();
                assert!(off < 1e-9, "{q:?}: {off:e}");
            }
        }
    }
}
