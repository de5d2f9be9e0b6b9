//! Deflection of the IR663: condensed compliance with the derivatives by all springs, sections and moduli, compared with the same from a dense
//! assembled stiffness of 66 degrees of freedom (nalgebra's Cholesky, penalty numbers, central differences); deflection of
//! the tip, assembly of the linkage included, with derivatives by its seven springs and by every elastic parameter there
//! is (own weight counted); identification of seven springs from 126 readings. One thread.
//!
//! Its beams and hinges, joints rigid, are also given to PyNite (`pip install PyNiteFEA scipy`; ELASTOGEO_PYTHON names the
//! interpreter, `python3` by default), and the two times are printed next to each other. Where PyNite is not
//! installed that row says so.

use std::hint::black_box;
use std::time::Instant;

use elastogeo::description::campaign::Campaign;
use elastogeo::elastics::{ElasticColumns, Elastics, Load, LoadCase, Response, Statics, spatial};
use elastogeo::elements::{PerLength, Properties, beam_axes, properties};
use elastogeo::estimation::{Settings, calibrate};
use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::{Model, Spot};
use elastogeo::observation::DEFLECTION;
use elastogeo::parameter::{Group, Kind, Slot};
use elastogeo::simulation::{Plan, draw_errors, generator, simulate};
use nalgebra::{DMatrix, Matrix3, Matrix6, Point3, Vector3, Vector6};
use serde_json::{Value, json};

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    let case = Case::new();
    case.assert_agreement();
    divan::main();
    if std::env::args().any(|argument| argument == "--test" || argument == "--list") {
        return;
    }
    let row_of = |name: &str, here: f64, whose: &str, theirs: f64| {
        println!("{name:<44}{here:>10.2} us here{theirs:>12.1} us {whose}, ratio {:.0}", theirs / here);
    };
    let row = |name: &str, here: f64, naive: f64| row_of(name, here, "dense", naive);
    println!();
    let name = format!("compliance and {} derivatives of it/ir663", case.compliances.len());
    row(&name, time(case.derivatives()), time(case.dense_derivatives()));
    row("compliance/ir663", time(case.compliance()), time(case.dense()));
    let tip = |slots: &[Slot], weight: bool| time(case.tip(&case.model.registry.nominal(), slots, weight));
    println!("tip deflection with assembly: {:.2} us (target 20)", tip(&[], false));
    println!("the same with own weight: {:.2} us", tip(&[], true));
    println!("tip deflection with the derivatives by {} springs: {:.2} us", case.slots.len(), tip(&case.slots, false));
    println!(
        "tip deflection, own weight, with the derivatives by all {} elastic parameters: {:.2} us (target 100)",
        case.all.len(),
        tip(&case.all, true)
    );
    match case.pynite() {
        Ok((here, there)) => row_of("tip deflection of its beams/ir663", here, "PyNite", there),
        Err(why) => println!("compared with PyNite: skipped, {why}"),
    }
    println!("identification from 126 readings: {:.2} ms (target 30)", time(case.identification()) * 1e-3);
}

const SPRINGS: [&str; 7] =
    ["joint2.kar", "joint8.kar", "joint2.kr", "joint8.kr", "joint3.kr", "joint9.kr", "joint10.kr"];

struct Case {
    model: Model,
    q: Vec<f64>,
    slots: Vec<Slot>,
    /// Every parameter of compliance and load.
    all: Vec<Slot>,
    /// Those of them that the declared compliance depends on: springs, sections, moduli.
    compliances: Vec<Slot>,
    campaign: Campaign,
}

impl Case {
    fn new() -> Self {
        let model = load_robot("kuka-ir663").expect("bundled").model;
        let slots = SPRINGS.iter().map(|name| model.registry.slot(name).expect("a spring")).collect();
        let configurations = (0..63)
            .map(|n| vec![0.0, 0.75 + 0.02 * f64::from(n % 9), 0.72 + 0.02 * f64::from(n / 9), 0.0, 0.0, 0.0])
            .collect();
        let plan = Plan {
            conditions: false,
            wrenches: vec![[900.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, -900.0, 0.0, 0.0, 0.0]],
            configurations,
            markers: vec![model.marker("wrist")],
            repeats: 1,
            observes: DEFLECTION,
            sigma: 35e-6,
            sigma_orientation: 0.0,
            estimate: [false, false],
        };
        let mut random = generator(663);
        let truth = draw_errors(&model, 0.0, 0.5, &mut random);
        let campaign = simulate(&model, &truth, &plan, &mut random).expect("simulated");
        let registry = model.registry.all().iter().enumerate();
        let all: Vec<Slot> =
            registry.filter(|(_, parameter)| parameter.group == Group::Elastic).map(|(slot, _)| slot).collect();
        let is_compliance = |slot: &&Slot| {
            let parameter = &model.registry[**slot];
            parameter.nominal != 0.0 && parameter.kind != Kind::Other("kg/m3")
        };
        let compliances = all.iter().filter(is_compliance).copied().collect();
        Self { compliances, all, model, q: vec![0.3, 0.85, 0.77, 0.0, 0.0, 0.0], slots, campaign }
    }

    fn placed(&self) -> (Geometry<'_>, Placements) {
        let geometry = Geometry::nominal(&self.model).expect("assembled");
        let mut placements = Placements::default();
        geometry.place(&self.q, &mut placements).expect("placed");
        (geometry, placements)
    }

    fn wrist(&self) -> usize {
        self.model.markers[self.model.marker("wrist").expect("a marker")].frame
    }

    fn compliance(&self) -> impl FnMut() -> f64 {
        let (_, placements) = self.placed();
        let elastics = Elastics::new(&self.model, &self.model.registry.nominal(), &[]);
        let mut statics = Statics::new(false);
        let mut response = Response::new(&elastics, self.model.structure.carrier(self.wrist(), &Vector3::zeros()));
        move || {
            elastics.prepare(black_box(&placements), &mut statics).expect("no mechanism");
            response.evaluate(&elastics, &mut statics);
            response.compliance[(0, 0)]
        }
    }

    fn derivatives(&self) -> impl FnMut() -> f64 {
        let (_, placements) = self.placed();
        let elastics = Elastics::new(&self.model, &self.model.registry.nominal(), &self.compliances);
        let columns = ElasticColumns::new(&elastics, &self.compliances);
        let mut statics = Statics::new(false);
        let mut response = Response::new(&elastics, self.model.structure.carrier(self.wrist(), &Vector3::zeros()));
        let mut out = vec![Vector6::zeros(); self.compliances.len()];
        move || {
            elastics.prepare(black_box(&placements), &mut statics).expect("no mechanism");
            response.evaluate(&elastics, &mut statics);
            for k in 0..6 {
                let unit = Vector6::ith(k, 1.0);
                let load = Load { wrench: unit, weight: false };
                columns.evaluate(&LoadCase::new(&elastics, &statics, &response, load), &placements, &mut out);
            }
            out[0][0] + response.compliance[(0, 0)]
        }
    }

    /// Deflection of the wrist under 900 N at slightly different configurations, the linkage assembled each time.
    fn tip(&self, values: &[f64], slots: &[Slot], weight: bool) -> impl FnMut() -> f64 {
        let (geometry, mut placements) = self.placed();
        let elastics = Elastics::new(&self.model, values, slots);
        let columns = ElasticColumns::new(&elastics, slots);
        let frame = self.wrist();
        let mut statics = Statics::new(weight);
        let mut response = Response::new(&elastics, self.model.structure.carrier(frame, &Vector3::zeros()));
        let mut out = vec![Vector6::zeros(); slots.len()];
        let (mut q, mut sign) = (self.q.clone(), 1e-3);
        move || {
            q[1] += sign;
            sign = -sign;
            geometry.place(black_box(&q), &mut placements).expect("placed");
            elastics.prepare(&placements, &mut statics).expect("no mechanism");
            response.evaluate(&elastics, &mut statics);
            let at = placements.frames[frame].translation.vector;
            let load = LOAD;
            if !out.is_empty() {
                let wrench = spatial(&at, &load, &Vector3::zeros());
                let case = LoadCase::new(&elastics, &statics, &response, Load { wrench, weight });
                columns.evaluate(&case, &placements, &mut out);
            }
            response.displacement(&at, &load, &Vector3::zeros(), weight).0.z + out.first().map_or(0.0, |o| o[0])
        }
    }

    /// Times (us) of the tip's deflection with its joints rigid, but for the passive ones: here, and by PyNite.
    fn pynite(&self) -> Result<(f64, f64), String> {
        let (_, placements) = self.placed();
        let mut values = self.model.registry.nominal();
        self.slots.iter().for_each(|&slot| values[slot] = 0.0);
        let value = |name: &str| values[self.model.registry.slot(name).expect("a parameter")];
        let young = value("steel.young");
        let shear = young / (2.0 * (1.0 + value("steel.poisson")));
        // Nodes that rigid and passive joints put on one point.
        let one = |node: &'static str| match node {
            "n2" | "n8" => "n1",
            other => other.trim_end_matches('\''),
        };
        let points: Vec<(&str, [f64; 3])> = ["n0", "n1", "n3", "n10", "nE", "n9"]
            .map(|name| {
                let vertex = self.model.structure.nodes.iter().find(|(known, _)| known == name).expect("a node").1;
                match self.model.structure.vertices[vertex].spot {
                    Spot::At(frame, local) => (name, (placements.frames[frame] * Point3::from(local)).into()),
                    Spot::Between(..) => unreachable!("no beam is cut"),
                }
            })
            .to_vec();
        let members: Vec<Value> = BEAMS
            .iter()
            .map(|&(from, to, section, normal)| {
                let section = self.section(&values, section);
                let frame = self.model.frame(normal).expect("a frame");
                let z: [f64; 3] = placements.frames[frame].rotation.matrix().column(2).into_owned().into();
                let hinges = [from, to].map(|end| end.ends_with('\''));
                json!({"from": one(from), "to": one(to), "local_z": z, "E": young, "G": shear, "A": section.area,
                       "Iy": section.iy, "Iz": section.iz, "J": section.j, "hinges": hinges})
            })
            .collect();
        let frame = json!({"nodes": points, "members": members, "held": "n0", "loaded": "nE",
                           "force": <[f64; 3]>::from(LOAD)});
        let found = run_pynite(&frame)?;
        let moved: Vec<f64> = found["moved"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
        let vertex = self.model.structure.carrier(self.wrist(), &Vector3::zeros());
        let elastics = Elastics::new(&self.model, &values, &[]);
        let (mut statics, mut response) = (Statics::new(false), Response::new(&elastics, vertex));
        elastics.prepare(&placements, &mut statics).map_err(|error| error.to_string())?;
        response.evaluate(&elastics, &mut statics);
        let end = Vector3::from(points[4].1);
        let here = response.displacement(&end, &LOAD, &Vector3::zeros(), false).0;
        let apart = (here - Vector3::from_vec(moved)).norm() / here.norm();
        assert!(apart < 1e-8, "PyNite's tip moves otherwise: {apart:e} of {here}");
        let there = found["seconds"].as_f64().ok_or("PyNite printed no time")?;
        Ok((time(self.tip(&values, &[], false)), there * 1e6))
    }

    fn section(&self, values: &[f64], name: &str) -> Properties<f64> {
        properties(Some(elastogeo::description::raw::SectionShape::Box), |symbol| {
            self.model.registry.slot(&format!("{name}.{symbol}")).map(|slot| values[slot])
        })
    }

    fn identification(&self) -> impl FnMut() -> f64 {
        let held_out = vec![false; self.campaign.readings.len()];
        move || {
            let found = calibrate(&self.model, &self.campaign, &held_out, &Settings::default(), &mut |_| {});
            found.expect("calibrated").noise_ratio
        }
    }

    fn dense(&self) -> impl FnMut() -> f64 {
        let (_, placements) = self.placed();
        let values = self.model.registry.nominal();
        move || self.assembled(black_box(&values), &placements)[(0, 0)]
    }

    fn dense_derivatives(&self) -> impl FnMut() -> f64 {
        let (_, placements) = self.placed();
        let mut values = self.model.registry.nominal();
        move || {
            let mut sum = self.assembled(black_box(&values), &placements)[(0, 0)];
            for &slot in &self.compliances {
                let (nominal, step) = (values[slot], 1e-3 * values[slot]);
                values[slot] = nominal + step;
                let up = self.assembled(&values, &placements);
                values[slot] = nominal - step;
                let down = self.assembled(&values, &placements);
                values[slot] = nominal;
                sum += ((up - down) / (2.0 * step))[(0, 0)];
            }
            sum
        }
    }

    /// Compliance at the wrist from the assembled stiffness matrix; rigid and passive are big and small numbers.
    fn assembled(&self, values: &[f64], placements: &Placements) -> Matrix6<f64> {
        let structure = &self.model.structure;
        let names: Vec<&str> = structure.nodes.iter().map(|(name, _)| name.as_str()).collect();
        let node = |name: &str| names.iter().position(|known| *known == name).expect("a node");
        let points: Vec<Vector3<f64>> = structure
            .nodes
            .iter()
            .map(|(_, vertex)| match structure.vertices[*vertex].spot {
                Spot::At(frame, local) => (placements.frames[frame] * Point3::from(local)).coords,
                Spot::Between(..) => unreachable!("no beam is cut"),
            })
            .collect();
        let frame = |name: &str| *placements.frames[self.model.frame(name).expect("a frame")].rotation.matrix();
        let value = |name: &str| values[self.model.registry.slot(name).expect("a parameter")];
        let n = 6 * names.len();
        let mut stiffness = DMatrix::<f64>::zeros(n, n);
        let mut add = |i: usize, j: usize, block: &Matrix6<f64>| {
            let mut view = stiffness.fixed_view_mut::<6, 6>(6 * i, 6 * j);
            view += block;
        };
        let young = value("steel.young");
        let shear = young / (2.0 * (1.0 + value("steel.poisson")));
        for (from, to, section, normal) in BEAMS {
            let (i, j) = (node(from), node(to));
            let section = self.section(values, section);
            let (axes, length) = beam_axes(&points[i], &points[j], &frame(normal).column(2).into_owned());
            let flexibility = PerLength::of_section(&section, young, shear, false).flexibility(length);
            let local = flexibility.apply_all(&Matrix6::identity()).try_inverse().expect("regular");
            let turn = both(&axes);
            let far = turn * local * turn.transpose();
            let mut carry = Matrix6::identity();
            carry.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(points[j] - points[i]).cross_matrix());
            add(j, j, &far);
            add(i, j, &(-carry.transpose() * far));
            add(j, i, &(-far * carry));
            add(i, i, &(carry.transpose() * far * carry));
        }
        let joints =
            [("n1", "n2", "2"), ("n1", "n8", "8"), ("n3", "n3'", "3"), ("n9", "n9'", "9"), ("n10", "n10'", "10")];
        for (from, to, joint) in joints {
            let (i, j) = (node(from), node(to));
            let kr = 1.0 / value(&format!("joint{joint}.kr"));
            let kar = if joint == "2" || joint == "8" { 1.0 / value(&format!("joint{joint}.kar")) } else { 1e-4 };
            let turn = both(&frame(joint));
            let diagonal = Vector6::new(kr, kr, RIGID, RIGID, RIGID, kar);
            let block = turn * Matrix6::from_diagonal(&diagonal) * turn.transpose();
            add(i, i, &block);
            add(j, j, &block);
            add(i, j, &-block);
            add(j, i, &-block);
        }
        let first = node("n0");
        (0..6).for_each(|k| stiffness[(6 * first + k, 6 * first + k)] += RIGID);
        let end = 6 * node("nE");
        let mut right = DMatrix::zeros(n, 6);
        (0..6).for_each(|k| right[(end + k, k)] = 1.0);
        let moved = stiffness.cholesky().expect("positive").solve(&right);
        Matrix6::from_fn(|i, k| moved[(end + i, k)])
    }

    fn assert_agreement(&self) {
        let (_, placements) = self.placed();
        let values = self.model.registry.nominal();
        let elastics = Elastics::new(&self.model, &values, &[]);
        let mut statics = Statics::new(false);
        let vertex = self.model.structure.carrier(self.wrist(), &Vector3::zeros());
        let mut response = Response::new(&elastics, vertex);
        elastics.prepare(&placements, &mut statics).expect("no mechanism");
        response.evaluate(&elastics, &mut statics);
        let here = response.compliance_at(&placements.frames[self.wrist()].translation.vector);
        let dense = self.assembled(&values, &placements);
        let (here, dense) = (here.fixed_view::<3, 3>(0, 0), dense.fixed_view::<3, 3>(0, 0));
        let apart = (here - dense).norm() / here.norm();
        assert!(apart < 1e-3, "penalty numbers cost some digits, no more: {apart:e}");
    }
}

/// Beams: nodes, section, frame whose z is the local z.
const BEAMS: [(&str, &str, &str, &str); 6] = [
    ("n0", "n1", "column", "2"),
    ("n2", "n3", "link", "2"),
    ("n3'", "n10", "link", "3"),
    ("n10", "nE", "arm", "3"),
    ("n8", "n9", "crank", "8"),
    ("n9'", "n10'", "coupler", "9"),
];

/// Force on the wrist, N.
const LOAD: Vector3<f64> = Vector3::new(0.0, 0.0, -900.0);

/// What `pynite.py` makes of a frame: `moved`, m, and `seconds` for one analysis.
fn run_pynite(frame: &Value) -> Result<Value, String> {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let python = std::env::var("ELASTOGEO_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut child = Command::new(&python)
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/benches/pynite.py"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("`{python}` does not start: {error}"))?;
    let mut input = child.stdin.take().ok_or("no way to tell it the frame")?;
    // A child that ended before it read its input explains itself on stderr.
    let _ = input.write_all(frame.to_string().as_bytes());
    drop(input);
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    let printed = String::from_utf8_lossy(&output.stderr);
    match printed.lines().last() {
        Some(last) if !output.status.success() => Err(format!(
            "`{python}`: {last} (pip install PyNiteFEA scipy, and name its interpreter in ELASTOGEO_PYTHON)"
        )),
        _ => serde_json::from_slice(&output.stdout).map_err(|error| error.to_string()),
    }
}

/// Stands for rigid in the dense assembly.
const RIGID: f64 = 1e13;

fn both(axes: &Matrix3<f64>) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(axes);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(axes);
    matrix
}

/// Time of one call, us: the best of several runs of at least 20 ms.
fn time(mut call: impl FnMut() -> f64) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..10 {
        let start = Instant::now();
        let mut calls = 0;
        while start.elapsed().as_millis() < 20 {
            black_box(call());
            calls += 1;
        }
        best = best.min(start.elapsed().as_secs_f64() / f64::from(calls));
    }
    best * 1e6
}

#[divan::bench_group(max_time = 1, threads = 1)]
mod ir663 {
    use super::Case;

    #[divan::bench]
    fn compliance_with_derivatives(bencher: divan::Bencher) {
        let case = Case::new();
        bencher.bench_local(case.derivatives());
    }

    #[divan::bench]
    fn compliance_with_derivatives_dense(bencher: divan::Bencher) {
        let case = Case::new();
        bencher.bench_local(case.dense_derivatives());
    }

    #[divan::bench]
    fn tip_deflection(bencher: divan::Bencher) {
        let case = Case::new();
        bencher.bench_local(case.tip(&case.model.registry.nominal(), &[], false));
    }

    #[divan::bench]
    fn tip_deflection_with_all_derivatives(bencher: divan::Bencher) {
        let case = Case::new();
        bencher.bench_local(case.tip(&case.model.registry.nominal(), &case.all, true));
    }

    #[divan::bench]
    fn identification_126_readings(bencher: divan::Bencher) {
        let case = Case::new();
        bencher.bench_local(case.identification());
    }
}
