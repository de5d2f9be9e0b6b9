//! Compensated points per second, one thread: KR-270 with masses (elastic, own weight, wrench) and IR663 (loop, beams,
//! springs, own weight, wrench), compared with the same inverse written naively: Newton with a new Jacobian by central differences
//! at every step, solved by a general LU. Geometry and springs are off nominal, so that everything is corrected.

use std::hint::black_box;
use std::time::Instant;

use elastogeo::compensation::{Desired, Settings, correct};
use elastogeo::description::campaign::Campaign;
use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::Model;
use elastogeo::observation::POSE;
use elastogeo::prediction::{SinglePredictor, SingleWorkspace};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use nalgebra::{Matrix6, Vector6};

const MASSES: &str = include_str!("../tests/data/kr270-masses.yaml");
const ROBOTS: [&str; 2] = ["kuka-kr270", "kuka-ir663"];
const POINTS: usize = 100;
const WRENCH: [f64; 6] = [300.0, -500.0, -1500.0, 100.0, -50.0, 80.0];

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    for name in ROBOTS {
        Case::new(name).assert_agreement();
    }
    divan::main();
    if std::env::args().any(|argument| argument == "--test" || argument == "--list") {
        return;
    }
    println!();
    for name in ROBOTS {
        let case = Case::new(name);
        let predictor = case.predictor();
        let (here, naive) = (time(case.analytic(&predictor)), time(case.naive(&predictor)));
        let a_second = 1e6 / here;
        println!(
            "compensated point/{name:<14}{here:>8.1} us here (target 100){naive:>9.1} us naive, ratio {:.1}; {a_second:.0} a second",
            naive / here
        );
    }
}

struct Case {
    model: Model,
    values: Vec<f64>,
    campaign: Campaign,
    desired: Vec<Desired>,
}

impl Case {
    fn new(name: &str) -> Self {
        let model = model(name);
        let mut random = generator(270);
        let values = draw_errors(&model, 0.3, 0.3, &mut random);
        let geometry = Geometry::nominal(&model).expect("assembled");
        let mut placements = Placements::default();
        let settings = Settings::new(model.variables.len());
        let (mut configurations, mut desired) = (Vec::new(), Vec::new());
        while configurations.len() < POINTS {
            let q = draw_configurations(&geometry, 1, 0.5, &mut random).expect("drawn").remove(0);
            geometry.place(&q, &mut placements).expect("placed");
            let target = placements.frames[model.tool.0] * geometry.tool();
            let point = Desired { nominal: q.clone(), target };
            // Singular ones would be refused, and are no work.
            let campaign = path(&model, std::slice::from_ref(&q));
            let predictor = SinglePredictor::new(&model, &values, &campaign).expect("assembled");
            if correct(&predictor, 0, &point, &WRENCH, &settings, &mut predictor.workspace()).is_ok() {
                configurations.push(q);
                desired.push(point);
            }
        }
        let campaign = path(&model, &configurations);
        Self { model, values, campaign, desired }
    }

    fn predictor(&self) -> SinglePredictor<'_> {
        SinglePredictor::new(&self.model, &self.values, &self.campaign).expect("assembled")
    }

    /// One point after the other.
    fn analytic<'a>(&'a self, predictor: &'a SinglePredictor) -> impl FnMut() -> f64 {
        let settings = Settings::new(self.model.variables.len());
        let (mut work, mut next) = (predictor.workspace(), 0);
        move || {
            let index = next % POINTS;
            next += 1;
            let point = black_box(&self.desired[index]);
            correct(predictor, index, point, &WRENCH, &settings, &mut work).expect("compensated").joints[0]
        }
    }

    fn naive<'a>(&'a self, predictor: &'a SinglePredictor) -> impl FnMut() -> f64 {
        let (mut work, mut next) = (predictor.workspace(), 0);
        move || {
            let index = next % POINTS;
            next += 1;
            naive(predictor, index, black_box(&self.desired[index]), &mut work)[0]
        }
    }

    fn assert_agreement(&self) {
        let predictor = self.predictor();
        let settings = Settings::new(self.model.variables.len());
        let mut work = predictor.workspace();
        for (index, point) in self.desired.iter().enumerate() {
            let here = correct(&predictor, index, point, &WRENCH, &settings, &mut work).expect("compensated").joints;
            let there = naive(&predictor, index, point, &mut work);
            let apart = here.iter().zip(&there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-5, "{index}: {apart:e}");
        }
    }
}

/// To the same residual.
fn naive(predictor: &SinglePredictor, index: usize, point: &Desired, work: &mut SingleWorkspace) -> Vec<f64> {
    let mut q = point.nominal.clone();
    let mut error = |q: &[f64]| -> Vector6<f64> {
        predictor.place(q, work).expect("placed");
        predictor.see(index, &WRENCH, work).expect("seen").to(&point.target)
    };
    for _ in 0..20 {
        let now = error(&q);
        if now.norm() < 1e-7 {
            break;
        }
        let columns: Vec<Vector6<f64>> = (0..6)
            .map(|k| {
                let (mut up, mut down) = (q.clone(), q.clone());
                up[k] += 1e-6;
                down[k] -= 1e-6;
                (error(&down) - error(&up)) / 2e-6
            })
            .collect();
        let step = Matrix6::from_columns(&columns).lu().solve(&now).expect("regular");
        q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q += step);
    }
    q
}

fn model(name: &str) -> Model {
    if name != "kuka-kr270" {
        return load_robot(name).expect("bundled").model;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let root = env!("CARGO_MANIFEST_DIR");
    std::fs::copy(format!("{root}/robots/kuka-kr270.urdf"), folder.path().join("kuka-kr270.urdf")).expect("copied");
    let text = std::fs::read_to_string(format!("{root}/robots/kuka-kr270.yaml")).expect("a file");
    let file = folder.path().join("heavy.yaml");
    std::fs::write(&file, text + MASSES).expect("written");
    load_robot(&file.display().to_string()).expect("a robot").model
}

fn path(model: &Model, configurations: &[Vec<f64>]) -> Campaign {
    let plan = Plan {
        conditions: false,
        wrenches: vec![WRENCH],
        configurations: configurations.to_vec(),
        markers: vec![None],
        repeats: 1,
        observes: POSE,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    simulate(model, &model.registry.nominal(), &plan, &mut generator(1)).expect("simulated")
}

/// Median time of a call, us, over a second.
fn time(mut call: impl FnMut() -> f64) -> f64 {
    let mut times = Vec::new();
    let started = Instant::now();
    while started.elapsed().as_secs_f64() < 1.0 {
        let from = Instant::now();
        (0..POINTS).for_each(|_| {
            black_box(call());
        });
        times.push(from.elapsed().as_secs_f64() * 1e6 / POINTS as f64);
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

#[divan::bench(args = ROBOTS, max_time = 1, threads = 1)]
fn compensated_point(bencher: divan::Bencher, name: &str) {
    let case = Case::new(name);
    let predictor = case.predictor();
    bencher.bench_local(case.analytic(&predictor));
}

#[divan::bench(args = ROBOTS, max_time = 1, threads = 1)]
fn compensated_point_naive(bencher: divan::Bencher, name: &str) {
    let case = Case::new(name);
    let predictor = case.predictor();
    bencher.bench_local(case.naive(&predictor));
}
