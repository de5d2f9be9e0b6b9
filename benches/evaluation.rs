//! How long the forward model and the error Jacobian take, compared with a naive version: 4x4 `DMatrix` products
//! and central finite differences. Answers are asserted to agree before anything is timed. Everything runs on one thread.
//!
//! After divan's own table (`cargo bench`), a second one shows the time of each, of its naive counterpart, and their
//! ratio: how many times as long the naive version takes.

use std::hint::black_box;
use std::time::Instant;

use elastogeo::kinematics::{By, ErrorColumns, Geometry, Placements, Rates, rotation_vector};
use elastogeo::model::Model;
use elastogeo::simulation::generator;
use nalgebra::{DMatrix, Matrix3, Rotation3};
use rand::RngExt;

fn main() {
    let (serial, ir663) = (Case::new("universal-ur5"), Case::new("kuka-ir663"));
    for case in [&serial, &ir663] {
        case.assert_agreement();
    }
    divan::main();
    if std::env::args().any(|argument| argument == "--test" || argument == "--list") {
        return;
    }
    println!("\n{:<36}{:>12}{:>14}{:>10}", "", "here, us", "naive, us", "ratio");
    row("forward/serial-6", serial.time_forward(), serial.time_naive_forward());
    row("forward+error-jacobian/serial-6", serial.time_jacobian(), serial.time_naive_jacobian());
    row("forward/ir663", ir663.time_forward(), ir663.time_naive_forward());
    row("forward+error-jacobian/ir663", ir663.time_jacobian(), ir663.time_naive_jacobian());
    println!("{:<36}{:>12.3}   of {MANY} drawn configurations, each", "poses/serial-6", serial.time_poses());
    println!(
        "\n{:<36}{:>12}{:>14}{:>18}{:>10}",
        "every bundled robot", "forward, us", "errors, us", "differences, us", "ratio"
    );
    for name in bundled() {
        let case = Case::new(&name);
        let (forward, errors, differences) = (case.time_forward(), case.time_jacobian(), time(case.differences()));
        let columns = case.by.len();
        let name = format!("{name} ({columns} columns)");
        println!("{name:<36}{forward:>12.3}{errors:>14.3}{differences:>18.1}{:>10.1}", differences / errors);
    }
}

/// Names of the bundled robots.
fn bundled() -> Vec<String> {
    let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/robots")).expect("a folder");
    let files = folder.map(|entry| entry.expect("an entry").path());
    let descriptions = files.filter(|path| path.extension().is_some_and(|extension| extension == "yaml"));
    let mut names: Vec<String> =
        descriptions.filter_map(|path| Some(path.file_stem()?.to_str()?.to_string())).collect();
    names.sort();
    names
}

fn row(name: &str, here: f64, naive: f64) {
    println!("{name:<36}{here:>12.3}{naive:>14.3}{:>10.1}", naive / here);
}

/// Configurations of an array, as many as `python/benches/calls.py` has.
const MANY: u32 = 5_000;

/// A bundled robot, its free slots and a configuration.
struct Case {
    model: Model,
    q: Vec<f64>,
    by: Vec<By>,
}

impl Case {
    fn new(name: &str) -> Self {
        let model = elastogeo::files::load_robot(name).expect("a bundled robot").model;
        let q = match name {
            "universal-ur5" => vec![0.4, -1.2, 1.3, -0.7, 0.9, 0.2],
            "kuka-ir663" => vec![0.3, 0.85, 0.77, 0.4, 0.8, 0.5],
            _ => model.middle(),
        };
        let by = model.free_slots().into_iter().map(By::Slot).collect();
        Self { model, q, by }
    }

    fn geometry(&self) -> Geometry<'_> {
        Geometry::nominal(&self.model).expect("assembled")
    }

    /// A closure that places the robot at slightly different configurations.
    fn forward(&self) -> impl FnMut() -> f64 {
        let (geometry, mut q, mut placements) = (self.geometry(), self.q.clone(), Placements::default());
        let mut sign = 1e-3;
        move || {
            q[1] += sign;
            sign = -sign;
            geometry.place(black_box(&q), &mut placements).expect("placed");
            placements.frames[geometry.model.tool.0].translation.x
        }
    }

    fn jacobian(&self) -> impl FnMut() -> f64 {
        let (geometry, mut q, mut placements) = (self.geometry(), self.q.clone(), Placements::default());
        let mut rates = Rates::new(&self.model);
        let plan = ErrorColumns::new(&geometry, &rates, self.model.tool.0, &self.by);
        let mut columns = vec![[0.0; 6]; plan.columns];
        let mut sign = 1e-3;
        move || {
            q[1] += sign;
            sign = -sign;
            geometry.place(black_box(&q), &mut placements).expect("placed");
            if plan.needs_rates() {
                rates.evaluate(&geometry, &q, &placements);
            }
            plan.evaluate(&geometry, &placements, &rates, &mut columns);
            columns[0][0]
        }
    }

    fn naive_forward(&self) -> impl FnMut() -> f64 {
        let values = self.model.registry.nominal();
        move || naive_pose(&self.model, black_box(&values), &self.q)[(0, 3)]
    }

    fn naive_jacobian(&self) -> impl FnMut() -> f64 {
        let values = self.model.registry.nominal();
        move || naive_columns(&self.model, black_box(&values), &self.q, &self.by)[0][0]
    }

    /// The columns by central differences of the library's own forward model.
    fn differences(&self) -> impl FnMut() -> f64 {
        let (mut values, mut placements) = (self.model.registry.nominal(), Placements::default());
        move || {
            let mut sum = 0.0;
            for by in &self.by {
                let By::Slot(slot) = *by else { continue };
                let nominal = values[slot];
                for step in [1e-6, -1e-6] {
                    values[slot] = nominal + step;
                    let geometry = Geometry::new(&self.model, black_box(&values)).expect("assembled");
                    geometry.place(&self.q, &mut placements).expect("placed");
                    sum += step.signum() * placements.frames[self.model.tool.0].translation.x;
                }
                values[slot] = nominal;
            }
            sum
        }
    }

    fn assert_agreement(&self) {
        let geometry = self.geometry();
        let mut placements = Placements::default();
        geometry.place(&self.q, &mut placements).expect("placed");
        let end = placements.frames[self.model.tool.0].to_homogeneous();
        let naive = naive_pose(&self.model, geometry.values(), &self.q);
        assert!(naive.iter().zip(end.iter()).all(|(a, b)| (a - b).abs() < 1e-9), "{naive} {end}");
        let mut rates = Rates::new(&self.model);
        rates.evaluate(&geometry, &self.q, &placements);
        let plan = ErrorColumns::new(&geometry, &rates, self.model.tool.0, &self.by);
        let mut columns = vec![[0.0; 6]; plan.columns];
        plan.evaluate(&geometry, &placements, &rates, &mut columns);
        for (a, b) in columns.iter().zip(naive_columns(&self.model, geometry.values(), &self.q, &self.by)) {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
        }
    }

    fn time_forward(&self) -> f64 {
        time(self.forward())
    }
    /// Of a configuration where each is another, with its pose written as a matrix: what the Python package does for an array.
    fn time_poses(&self) -> f64 {
        let (geometry, mut placements) = (self.geometry(), Placements::default());
        let mut random = generator(1);
        let variables = self.q.len();
        let drawn = (0..MANY as usize * variables).map(|k| self.q[k % variables] + random.random_range(-1.0..1.0));
        let (drawn, tool) = (drawn.collect::<Vec<f64>>(), geometry.tool());
        let mut poses = vec![0.0; 16 * MANY as usize];
        let all = time(|| {
            for (q, out) in black_box(&drawn).chunks(variables).zip(poses.chunks_mut(16)) {
                geometry.place(q, &mut placements).expect("placed");
                let pose = (placements.frames[self.model.tool.0] * tool).to_homogeneous();
                out.copy_from_slice(pose.transpose().as_slice());
            }
            poses[3]
        });
        all / f64::from(MANY)
    }
    fn time_jacobian(&self) -> f64 {
        time(self.jacobian())
    }
    fn time_naive_forward(&self) -> f64 {
        time(self.naive_forward())
    }
    fn time_naive_jacobian(&self) -> f64 {
        time(self.naive_jacobian())
    }
}

/// Time of one call, us: the best of several runs of at least 20 ms.
fn time(mut call: impl FnMut() -> f64) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..10 {
        let start = Instant::now();
        let mut calls = 0;
        while start.elapsed().as_millis() < 20 {
            for _ in 0..50 {
                black_box(call());
            }
            calls += 50;
        }
        best = best.min(start.elapsed().as_secs_f64() / f64::from(calls));
    }
    best * 1e6
}

/// The tool frame as a product of 4x4 matrices.
fn naive_pose(model: &Model, values: &[f64], q: &[f64]) -> DMatrix<f64> {
    let joints = naive_joints(model, values, q);
    let mut pose = DMatrix::identity(4, 4);
    for frame in model.path(model.tool.0) {
        let [beta, gamma, b, alpha, d, theta, r] = model.frames[frame].slots.map(|slot| values[slot]);
        let theta = joints[frame].unwrap_or(theta);
        pose = pose * turn(1, beta) * turn(2, gamma) * slide(2, b) * turn(0, alpha) * slide(0, d);
        pose = pose * turn(2, theta) * slide(2, r);
    }
    pose
}

fn turn(axis: usize, angle: f64) -> DMatrix<f64> {
    let mut matrix = DMatrix::identity(4, 4);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (sine, cosine) = angle.sin_cos();
    (matrix[(i, i)], matrix[(j, j)], matrix[(i, j)], matrix[(j, i)]) = (cosine, cosine, -sine, sine);
    matrix
}

fn slide(axis: usize, length: f64) -> DMatrix<f64> {
    let mut matrix = DMatrix::identity(4, 4);
    matrix[(axis, 3)] = length;
    matrix
}

/// Full angle of each moving frame. Loops by the four-bar's formula, not generically.
fn naive_joints(model: &Model, values: &[f64], q: &[f64]) -> Vec<Option<f64>> {
    let mut joints = vec![None; model.frames.len()];
    let value = |name: &str| values[model.registry.slot(name).expect("a parameter")];
    let of = |name: &str| model.frame(name).expect("a frame");
    if model.actuators.is_empty() {
        for (k, frame) in model.path(model.tool.0).into_iter().enumerate() {
            joints[frame] = Some(q[k] + values[model.frames[frame].moving_slot()]);
        }
        return joints;
    }
    let crank = |name: &str, stroke: f64| {
        let [zero, kappa, lambda, l1, l3] =
            ["stroke", "kappa", "lambda", "l1", "l3"].map(|symbol| value(&format!("{name}.{symbol}")));
        let r = stroke + zero;
        kappa + lambda - ((r * r - l1 * l1 - l3 * l3) / (2.0 * l1 * l3)).acos()
    };
    let (theta_2, theta_8) = (crank("screw2", q[1]), crank("screw8", q[2]));
    let delta = theta_2 - theta_8;
    let (d3, d9, d10, d11) = (value("3.d"), value("9.d"), value("10.d"), value("11.d"));
    let (x, y, z, w) = (d9 * delta.cos(), d3 - d9 * delta.sin(), -d10, -d11);
    let (b1, b2, b3) = (2.0 * z * y, 2.0 * z * x, w * w - x * x - y * y - z * z);
    let root = (b1 * b1 + b2 * b2 - b3 * b3).sqrt();
    let theta_3 = (b1 * b3 + b2 * root).atan2(b2 * b3 - b1 * root);
    let five = q[4] + value("5.theta");
    let angles = [
        ("1", q[0] + value("1.theta")),
        ("2", theta_2 + value("2.theta")),
        ("3", theta_3),
        ("4", q[3] + value("4.theta")),
        ("5", five),
        ("6", -five),
        ("7", q[5] + value("7.theta")),
    ];
    for (name, angle) in angles {
        joints[of(name)] = Some(angle);
    }
    joints
}

/// Columns by central finite differences.
fn naive_columns(model: &Model, values: &[f64], q: &[f64], by: &[By]) -> Vec<[f64; 6]> {
    let step = 1e-6;
    let mut values = values.to_vec();
    let rotation = |pose: &DMatrix<f64>| Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| pose[(i, j)]));
    by.iter()
        .map(|by| {
            let By::Slot(slot) = *by else { return [0.0; 6] };
            let nominal = values[slot];
            values[slot] = nominal + step;
            let after = naive_pose(model, &values, q);
            values[slot] = nominal - step;
            let before = naive_pose(model, &values, q);
            values[slot] = nominal;
            let w = rotation_vector(&(rotation(&after) * rotation(&before).inverse()));
            let v = |k: usize| (after[(k, 3)] - before[(k, 3)]) / (2.0 * step);
            let w = w / (2.0 * step);
            [v(0), v(1), v(2), w.x, w.y, w.z]
        })
        .collect()
}

#[divan::bench_group(name = "forward", max_time = 1, threads = 1)]
mod forward {
    use super::Case;

    #[divan::bench(name = "serial-6", args = ["universal-ur5"])]
    fn serial(bencher: divan::Bencher, name: &str) {
        let case = Case::new(name);
        bencher.bench_local(case.forward());
    }

    #[divan::bench(args = ["kuka-ir663"])]
    fn ir663(bencher: divan::Bencher, name: &str) {
        let case = Case::new(name);
        bencher.bench_local(case.forward());
    }
}

#[divan::bench_group(name = "forward+error-jacobian", max_time = 1, threads = 1)]
mod error_jacobian {
    use super::Case;

    #[divan::bench(name = "serial-6", args = ["universal-ur5"])]
    fn serial(bencher: divan::Bencher, name: &str) {
        let case = Case::new(name);
        bencher.bench_local(case.jacobian());
    }

    #[divan::bench(name = "serial-6, naive", args = ["universal-ur5"])]
    fn serial_naive(bencher: divan::Bencher, name: &str) {
        let case = Case::new(name);
        bencher.bench_local(case.naive_jacobian());
    }

    #[divan::bench(args = ["kuka-ir663"])]
    fn ir663(bencher: divan::Bencher, name: &str) {
        let case = Case::new(name);
        bencher.bench_local(case.jacobian());
    }

    #[divan::bench(name = "ir663, naive", args = ["kuka-ir663"])]
    fn ir663_naive(bencher: divan::Bencher, name: &str) {
        let case = Case::new(name);
        bencher.bench_local(case.naive_jacobian());
    }
}
