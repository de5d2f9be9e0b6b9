//! Structures whose deflection is known: closed forms, energy and reciprocity, frames computed by PyNite.

use std::fmt::Write;

use elastogeo::elastics::{shares, spatial};
use elastogeo::model::Model;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use serde_json::Value;

use crate::loaded::{node, node_displacements, placed, respond};
use crate::random_robots::{Draw, serial};
use crate::support::{json, model_of, numbers};

const HEAD: &str = "units: {length: m, angle: rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-3, 3]}
  askew: {antecedent: 0, gamma: 0.4, alpha: 0.7}
  up: {antecedent: 0}
tool: {frame: 1}
materials: {steel: {young: 2.1e11, shear: 8.0e10, density: 7850}}
";
const E: f64 = 2.1e11;
const G: f64 = 8.0e10;

fn close(found: f64, expected: f64, relative: f64, what: &str) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{what}: {found:e} against {expected:e}");
}

fn at_tip(model: &Model, load: Vector6<f64>) -> Vector6<f64> {
    let all = node_displacements(model, &[0.0], &[("tip", load)], false);
    all.into_iter().find(|(name, _)| name == "tip").expect("the tip").1
}

#[test]
fn cantilever_by_all_six_loads() {
    let [a, iy, iz, j, asy, asz] = [3e-3, 2e-6, 5e-6, 4e-6, 1.5e-3, 2.0e-3];
    let tip = Vector3::new(0.5_f64, -0.7, 0.9);
    let l = tip.norm();
    for (theory, shear) in [("euler-bernoulli", 0.0), ("timoshenko", 1.0)] {
        for (from, to, elements) in [("root", "tip", 1), ("tip", "root", 1), ("root", "tip", 7), ("tip", "root", 7)] {
            let model = model_of(&format!(
                "{HEAD}sections: {{s: {{area: {a}, iy: {iy}, iz: {iz}, j: {j}, shear_y: {asy}, shear_z: {asz}}}}}
nodes: {{root: {{body: 1}}, tip: {{body: 1, point: [{}, {}, {}]}}}}
beams: {{b: {{from: {from}, to: {to}, section: s, material: steel, normal: askew, theory: {theory}, elements: {elements}}}}}
joint_stiffness: {{1: {{at: root}}}}
",
                tip.x, tip.y, tip.z
            ));
            let normal = *placed(&model, &model.registry.nominal(), &[0.0]).frames
                [model.frame("askew").expect("a frame")]
            .rotation
            .matrix();
            let x: Vector3<f64> = tip / l;
            let z = normal.column(2) - x * x.dot(&normal.column(2));
            let z = z / z.norm();
            let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
            let mut local = Matrix6::zeros();
            local[(0, 0)] = l / (E * a);
            local[(1, 1)] = l.powi(3) / (3.0 * E * iz) + shear * l / (G * asy);
            local[(2, 2)] = l.powi(3) / (3.0 * E * iy) + shear * l / (G * asz);
            local[(3, 3)] = l / (G * j);
            local[(4, 4)] = l / (E * iy);
            local[(5, 5)] = l / (E * iz);
            (local[(1, 5)], local[(5, 1)]) = (l * l / (2.0 * E * iz), l * l / (2.0 * E * iz));
            (local[(2, 4)], local[(4, 2)]) = (-l * l / (2.0 * E * iy), -l * l / (2.0 * E * iy));
            let mut turn = Matrix6::zeros();
            turn.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes);
            turn.fixed_view_mut::<3, 3>(3, 3).copy_from(&axes);
            let expected = turn * local * turn.transpose();
            for k in 0..6 {
                let mut load = Vector6::zeros();
                load[k] = 1.0;
                let off = (at_tip(&model, load) - expected.column(k)).amax() / expected.column(k).amax();
                assert!(off < 1e-13, "{theory} {from} {elements} load {k}: {off:e}");
            }
        }
    }
}

fn tapered(elements: usize) -> Model {
    model_of(&format!(
        "{HEAD}sections: {{big: {{shape: rectangle, width: 0.06, height: 0.1}}, small: {{shape: rectangle, width: 0.03, height: 0.04}}}}
nodes: {{root: {{body: 1}}, tip: {{body: 1, point: [1.5, 0, 0]}}}}
beams: {{b: {{from: root, to: tip, section: big, section_to: small, material: steel, normal: up, elements: {elements}}}}}
joint_stiffness: {{1: {{at: root}}}}
gravity: [0, 0, -9.81]
"
    ))
}

#[test]
fn tapered_cantilever() {
    let (l, n) = (1.5, 20_000);
    let width = |x: f64| 0.06 + (0.03 - 0.06) * x / l;
    let height = |x: f64| 0.1 + (0.04 - 0.1) * x / l;
    let integral =
        |f: &dyn Fn(f64) -> f64| -> f64 { (0..n).map(|k| f((k as f64 + 0.5) * l / n as f64) * l / n as f64).sum() };
    let iy = |x: f64| width(x) * height(x).powi(3) / 12.0;
    let iz = |x: f64| height(x) * width(x).powi(3) / 12.0;
    let expected = [
        integral(&|x| 1.0 / (E * width(x) * height(x))),
        integral(&|x| (l - x).powi(2) / (E * iz(x))),
        integral(&|x| (l - x).powi(2) / (E * iy(x))),
    ];
    let found = |elements: usize| -> [f64; 3] {
        let model = tapered(elements);
        std::array::from_fn(|k| {
            let mut load = Vector6::zeros();
            load[k] = 1.0;
            at_tip(&model, load)[k]
        })
    };
    let (coarse, fine, finest) = (found(8), found(64), found(128));
    for k in 0..3 {
        // The sections of the elements are those of their middles: the error falls with the square of their length.
        close(coarse[k], expected[k], 1.3e-2, "8 elements");
        let errors = [fine[k], finest[k]].map(|found| found / expected[k] - 1.0);
        assert!((errors[0] / errors[1] - 4.0).abs() < 0.02, "{k}: {errors:?}");
        close((4.0 * finest[k] - fine[k]) / 3.0, expected[k], 1e-7, "extrapolated");
    }
    let default = tapered(8).structure.tree.len();
    let unsaid = model_of(&format!(
        "{HEAD}sections: {{a: {{shape: rod, diameter: 0.06}}, b: {{shape: rod, diameter: 0.03}}}}
nodes: {{root: {{body: 1}}, tip: {{body: 1, point: [1.5, 0, 0]}}}}
beams: {{b: {{from: root, to: tip, section: a, section_to: b, material: steel, normal: up}}}}
"
    ));
    assert_eq!(unsaid.structure.tree.len(), default, "a taper is cut into 8 unless said otherwise");
    // Own weight of the taper: the tip sinks by the double integral of q over the beam beyond x.
    let q = |x: f64| 7850.0 * 9.81 * width(x) * height(x);
    let steps = 2000;
    let h = l / steps as f64;
    let (mut shear, mut moment, mut sinks) = (0.0, 0.0, 0.0);
    for k in (0..steps).rev() {
        let x = (k as f64 + 0.5) * h;
        let force = q(x) * h;
        // Bending moment at x by what lies beyond it, and by the half of this step.
        let here = moment + shear * h / 2.0 + force * h / 8.0;
        sinks += here * (l - x) / (E * iy(x)) * h;
        moment += shear * h + force * h / 2.0;
        shear += force;
    }
    let all = node_displacements(&tapered(128), &[0.0], &[], true);
    close(-all[1].1[2], sinks, 1e-4, "own weight");
}

#[test]
fn own_weight_of_straight_beams() {
    let (a, i, l) = (3e-3, 5e-6, 2.0_f64);
    let q = 7850.0 * a * 9.81;
    for (from, to, elements) in [("root", "tip", 1), ("tip", "root", 1), ("root", "tip", 5)] {
        for held in ["", ", support: fixed"] {
            let model = model_of(&format!(
                "{HEAD}sections: {{s: {{area: {a}, iy: {i}, iz: 4e-6, j: 4e-6}}}}
gravity: [0, 0, -9.81]
nodes: {{root: {{body: 1}}, middle: {{body: 1, point: [{}, 0, 0]}}, tip: {{body: 1, point: [{l}, 0, 0]{held}}}}}
beams:
  b: {{from: {}, to: middle, section: s, material: steel, normal: up, elements: {elements}}}
  c: {{from: middle, to: {}, section: s, material: steel, normal: up, elements: {elements}}}
joint_stiffness: {{1: {{at: root}}}}
",
                l / 2.0,
                from,
                to
            ));
            let all = node_displacements(&model, &[0.0], &[], true);
            let of = |name: &str| all.iter().find(|(known, _)| known == name).expect("a node").1;
            if held.is_empty() {
                close(of("tip")[2], -q * l.powi(4) / (8.0 * E * i), 1e-13, "tip");
                close(of("tip")[4], q * l.powi(3) / (6.0 * E * i), 1e-13, "slope");
            } else {
                close(of("middle")[2], -q * l.powi(4) / (384.0 * E * i), 1e-12, "middle");
                assert!(of("tip").amax() < 1e-18, "{}", of("tip"));
            }
        }
    }
}

#[test]
fn portal_frame() {
    let (h, l, ic, ig) = (3.0_f64, 4.0, 6e-5, 8e-5);
    let model = model_of(&format!(
        "{HEAD}sections: {{c: {{area: 1e7, iy: {ic}, iz: {ic}, j: 1e-4}}, g: {{area: 1e7, iy: {ig}, iz: {ig}, j: 1e-4}}}}
nodes:
  foot: {{body: 1}}
  knee: {{body: 1, point: [0, 0, {h}]}}
  other: {{body: 1, point: [{l}, 0, {h}]}}
  end: {{body: 1, point: [{l}, 0, 0], support: fixed}}
beams:
  left: {{from: foot, to: knee, section: c, material: steel, normal: askew}}
  girder: {{from: knee, to: other, section: g, material: steel, normal: askew}}
  right: {{from: other, to: end, section: c, material: steel, normal: askew}}
joint_stiffness: {{1: {{at: foot}}}}
"
    ));
    let p = 1000.0;
    let load = Vector6::new(p, 0.0, 0.0, 0.0, 0.0, 0.0);
    let all = node_displacements(&model, &[0.0], &[("knee", load)], false);
    let k = ig * h / (ic * l);
    let sway = p * h.powi(3) / (12.0 * E * ic) * (3.0 * k + 2.0) / (6.0 * k + 1.0);
    // With columns and girder that all but cannot stretch; 1e7 m2 leaves some 1e-11.
    close(all[1].1[0], sway, 1e-9, "knee");
    close(all[2].1[0], sway, 1e-9, "other");
    // Knees turn alike: by the girder's moment 3 k P h / (2 (6 k + 1)) on l / (6 E I).
    let turn = p * h / 2.0 * 3.0 * k / (6.0 * k + 1.0) * l / (6.0 * E * ig);
    close(all[1].1[4], turn, 1e-9, "knee turns");
}

/// A quarter ring of radius r in the x-y plane from (r, 0) to (0, r), of n straight pieces.
fn ring_sector(n: usize, r: f64, [i, j]: [f64; 2]) -> Model {
    let mut text = format!("{HEAD}sections: {{s: {{area: 1e3, iy: {i}, iz: {i}, j: {j}}}}}\nnodes:\n");
    for k in 0..=n {
        let angle = std::f64::consts::FRAC_PI_2 * k as f64 / n as f64;
        let name = if k == n { "tip".to_string() } else { format!("n{k}") };
        let _ = writeln!(text, "  {name}: {{body: 1, point: [{:?}, {:?}, 0]}}", r * angle.cos(), r * angle.sin());
    }
    text += "beams:\n";
    for k in 0..n {
        let to = if k + 1 == n { "tip".to_string() } else { format!("n{}", k + 1) };
        let _ = writeln!(text, "  b{k}: {{from: n{k}, to: {to}, section: s, material: steel, normal: up}}");
    }
    model_of(&(text + "joint_stiffness: {1: {at: n0}}\n"))
}

#[test]
fn ring_sector_in_and_out_of_its_plane() {
    let (r, i, j) = (0.7_f64, 4e-6, 6e-6);
    let models = [32, 64].map(|n| ring_sector(n, r, [i, j]));
    let extrapolated = |load: usize, at: usize| {
        let mut unit = Vector6::zeros();
        unit[load] = 1.0;
        let [coarse, fine] = [0, 1].map(|k| at_tip(&models[k], unit)[at]);
        (4.0 * fine - coarse) / 3.0
    };
    let pi = std::f64::consts::PI;
    // Bending moment of a force at the tip, angle s from it: out of plane F r sin s (and torque F r (1 - cos s)), along
    // the tip's tangent F r (1 - cos s), across it F r sin s.
    close(extrapolated(2, 2), r.powi(3) * (pi / 4.0 / (E * i) + (0.75 * pi - 2.0) / (G * j)), 1e-6, "out of plane");
    close(extrapolated(0, 0), r.powi(3) * (0.75 * pi - 2.0) / (E * i), 1e-6, "tangential");
    close(extrapolated(1, 1), r.powi(3) * pi / 4.0 / (E * i), 1e-6, "radial");
    close(extrapolated(0, 1), r.powi(3) * 0.5 / (E * i), 1e-6, "across by along");
    close(extrapolated(5, 5), r * pi / 2.0 / (E * i), 1e-6, "moment in the plane");
}

#[test]
fn joint_springs_of_random_serial_robots() {
    let mut seen = 0;
    for seed in 0..60 {
        let draw = &mut Draw::new(seed + 400);
        let sketch = serial(seed);
        let mut text = sketch.yaml();
        text += "joint_stiffness:\n";
        let mut springs = Vec::new();
        for part in sketch.parts.iter().filter(|part| !part.joint.is_empty()) {
            // Along and about x, y, z, of which some are rigid; of every second robot x and y are alike.
            let mut c: [f64; 6] = std::array::from_fn(|k| {
                if draw.chance(0.3) { 0.0 } else { draw.within(1.0, 9.0) * if k < 3 { 1e-8 } else { 1e-6 } }
            });
            let symbols: &[(&str, usize)] = if seed % 2 == 0 {
                (c[1], c[4]) = (c[0], c[3]);
                &[("kr", 0), ("ka", 2), ("krr", 3), ("kar", 5)]
            } else {
                &[("krx", 0), ("kry", 1), ("ka", 2), ("krrx", 3), ("krry", 4), ("kar", 5)]
            };
            let row = symbols.iter().map(|&(symbol, k)| format!("{symbol}: {{compliance: {:?}}}", c[k]));
            let _ = writeln!(text, "  {}: {{{}}}", part.name, row.collect::<Vec<_>>().join(", "));
            springs.push((part.name.clone(), c));
        }
        let model = model_of(&text);
        let values = model.registry.nominal();
        let known = sketch.at();
        let q: Vec<f64> = model
            .variables
            .iter()
            .map(|variable| known.iter().find(|(name, _)| *name == variable.name).expect("a variable").1)
            .collect();
        let at = placed(&model, &values, &q);
        let tool = at.frames[model.tool.0].translation.vector;
        let path = model.path(model.tool.0);
        let mut expected = Matrix6::zeros();
        for (name, c) in &springs {
            let frame = model.frame(name).expect("a frame");
            if !path.contains(&frame) {
                continue;
            }
            let placed = &at.frames[frame];
            for (k, c) in c.iter().enumerate() {
                let axis = placed.rotation.matrix().column(k % 3).into_owned();
                let (d, turn) = if k < 3 {
                    (axis, Vector3::zeros())
                } else {
                    (axis.cross(&(tool - placed.translation.vector)), axis)
                };
                let column = Vector6::new(d.x, d.y, d.z, turn.x, turn.y, turn.z);
                expected += column * column.transpose() * *c;
            }
        }
        let vertex = model.structure.carrier(model.tool.0, &Vector3::zeros());
        let (elastics, statics, response) = respond(&model, &values, &q, vertex, false).expect("no mechanism");
        let found = response.compliance_at(&tool);
        assert!((found - expected).amax() < 1e-13 * expected.amax(), "{seed}: {found} {expected}");
        // Virtual work, and shares that add up.
        let load = Vector6::from_fn(|_, _| draw.within(-100.0, 100.0));
        let wrench = spatial(&tool, &load.fixed_rows::<3>(0).into_owned(), &load.fixed_rows::<3>(3).into_owned());
        let parts = shares(&elastics, &statics, &response, &wrench, false);
        let work = 0.5 * load.dot(&(expected * load));
        if work > 0.0 {
            close(parts.total, work, 1e-12, "strain energy");
            close(parts.energy.values().sum::<f64>(), 1.0, 1e-12, "shares");
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn energy_and_reciprocity_of_a_frame_with_closed_cycles() {
    let frames = pynite();
    let model = model_of(&description(&frames["structures"][2], "0"));
    let loads: Vec<Vector6<f64>> = {
        let draw = &mut Draw::new(5);
        (0..3).map(|_| Vector6::from_fn(|k, _| draw.within(-1.0, 1.0) * if k < 3 { 500.0 } else { 60.0 })).collect()
    };
    let names = ["n111", "n011", "n101"];
    for (i, a) in names.iter().enumerate() {
        let by_a = node_displacements(&model, &[0.0], &[(a, loads[i])], false);
        let of = |all: &[(String, Vector6<f64>)], name: &str| all.iter().find(|(n, _)| n == name).expect("a node").1;
        for (j, b) in names.iter().enumerate().skip(i) {
            let by_b = node_displacements(&model, &[0.0], &[(b, loads[j])], false);
            let works = [of(&by_a, b).dot(&loads[j]), of(&by_b, a).dot(&loads[i])];
            close(works[0], works[1], 1e-11, "Maxwell and Betti");
        }
        let values = model.registry.nominal();
        let (elastics, statics, response) = respond(&model, &values, &[0.0], node(&model, a), false).expect("held");
        let (force, moment) = (loads[i].fixed_rows::<3>(0).into_owned(), loads[i].fixed_rows::<3>(3).into_owned());
        let wrench = spatial(&statics.points[response.vertex], &force, &moment);
        let parts = shares(&elastics, &statics, &response, &wrench, false);
        close(parts.total, 0.5 * loads[i].dot(&of(&by_a, a)), 1e-11, "strain energy");
    }
}

/// Beams whose ends are released carry force along themselves alone: the apex moves by the sum of E A / L x x'.
#[test]
fn a_tripod_of_hinged_beams_is_a_truss() {
    let feet = [[1.0, 0.2, 0.0], [-0.6, 0.9, 0.1], [-0.3, -0.8, -0.2]];
    let (apex, areas) = (Vector3::new(0.1_f64, -0.05, 1.3), [2e-4, 3e-4, 5e-4]);
    for elements in [1, 3] {
        let (mut nodes, mut beams, mut sections) = (String::new(), String::new(), String::new());
        let mut stiffness = Matrix3::zeros();
        for (k, (foot, area)) in feet.iter().zip(areas).enumerate() {
            let _ = writeln!(nodes, "  foot{k}: {{body: 0, point: {foot:?}, support: fixed}}");
            let _ = writeln!(sections, "  s{k}: {{area: {area:?}, iy: 2e-6, iz: 5e-6, j: 4e-6}}");
            // The third holds the apex from turning.
            let at_apex = if k == 2 { "" } else { "rx, ry, rz" };
            let ends =
                if k == 1 { ["tip", "foot1"] } else { ["foot_", "tip"] }.map(|end| end.replace('_', &k.to_string()));
            let released = if k == 1 { [at_apex, "ry, rz"] } else { ["ry, rz", at_apex] };
            let _ = writeln!(
                beams,
                "  b{k}: {{from: {}, to: {}, section: s{k}, material: steel, normal: askew, elements: {elements}, release: {{from: [{}], to: [{}]}}}}",
                ends[0], ends[1], released[0], released[1]
            );
            let along = apex - Vector3::from(*foot);
            stiffness += along * along.transpose() * (E * area / along.norm().powi(3));
        }
        let [x, y, z] = [apex.x, apex.y, apex.z];
        let model = model_of(&format!(
            "{HEAD}sections:\n{sections}nodes:\n  tip: {{body: 0, point: [{x}, {y}, {z}]}}\n{nodes}beams:\n{beams}"
        ));
        let expected = stiffness.try_inverse().expect("held");
        for k in 0..3 {
            let found = at_tip(&model, Vector6::ith(k, 1.0)).fixed_rows::<3>(0).into_owned();
            assert!((found - expected.column(k)).amax() < 1e-12 * expected.amax(), "{elements} {k} {found}");
        }
    }
}

/// Clamped beams with a hinge or a slide: closed forms.
#[test]
fn cantilevers_held_through_a_released_end() {
    let (a, iy, iz, l) = (3e-3, 2e-6, 5e-6, 1.4_f64);
    let tip = |release: &str, elements: usize, load: Vector6<f64>| {
        let model = model_of(&format!(
            "{HEAD}sections: {{s: {{area: {a}, iy: {iy}, iz: {iz}, j: 4e-6}}}}
nodes:
  root: {{body: 0, support: fixed}}
  tip: {{body: 0, point: [{l}, 0, 0]}}
  end: {{body: 0, point: [{}, 0, 0], support: fixed}}
beams:
  b: {{from: root, to: tip, section: s, material: steel, normal: up, elements: {elements}, release: {release}}}
  c: {{from: tip, to: end, section: s, material: steel, normal: up}}
",
            2.0 * l
        ));
        assert_eq!(model.structure.freedom[1], model_of(&format!(
            "{HEAD}sections: {{s: {{area: {a}, iy: {iy}, iz: {iz}, j: 4e-6}}}}
nodes: {{root: {{body: 0, support: fixed}}, tip: {{body: 0, point: [1, 0, 0]}}, end: {{body: 0, point: [2, 0, 0], support: fixed}}}}
beams: {{b: {{from: root, to: tip, section: s, material: steel, elements: {elements}}}, c: {{from: tip, to: end, section: s, material: steel}}}}
"
        ))
        .structure
        .freedom[1] + release.matches(',').count() + 1, "a hinge is one degree of freedom more");
        at_tip(&model, load)
    };
    let across = Vector6::new(0.0, 0.0, 1000.0, 0.0, 0.0, 0.0);
    let along = Vector6::new(1000.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let (bend, stretch) = (1000.0 * l.powi(3) / (E * iy), 1000.0 * l / (E * a));
    for elements in [1, 4] {
        // Two cantilevers whose tips meet in a hinge; each takes half.
        close(tip("{to: [ry]}", elements, across)[2], bend / 6.0, 1e-12, "hinged");
        // Clamped at both ends, loaded in the middle of 2 l.
        close(tip("{to: [rz]}", elements, across)[2], bend / 24.0, 1e-12, "hinged the other way");
        // A slide carries moment alone: the tip is a cantilever's, k = 3 EI/l^3 and a moment spring EI/l at its end.
        close(tip("{to: [z]}", elements, across)[2], bend * 5.0 / 24.0, 1e-12, "slides across");
        close(tip("{to: [x]}", elements, along)[0], stretch, 1e-12, "slides along");
        close(tip("{from: [x, ry]}", elements, along)[0], stretch, 1e-12, "slides along, hinged");
        // Hinged at its root: 3 EI/l^3 against the bend of a clamped one, which the joint of both makes 7/96.
        close(tip("{from: [ry]}", elements, across)[2], bend * 7.0 / 96.0, 1e-12, "hinged at the root");
    }
}

#[test]
fn a_release_too_many_is_a_mechanism() {
    let said = |release: &str, tip: &str| {
        let model = model_of(&format!(
            "{HEAD}sections: {{s: {{area: 1e-3, iy: 2e-6, iz: 3e-6, j: 4e-6}}}}
nodes: {{root: {{body: 0, support: fixed}}, tip: {{body: 0, point: [1, 0, 0]{tip}}}}}
beams: {{b: {{from: root, to: tip, section: s, material: steel, normal: up, release: {release}}}}}
"
        ));
        let values = model.registry.nominal();
        match respond(&model, &values, &[0.0], node(&model, "tip"), false) {
            Ok(_) => String::new(),
            Err(mechanism) => mechanism.to_string(),
        }
    };
    let beam = "beam `b` can";
    let why = "it is released there and nothing else holds it";
    assert_eq!(said("{from: [ry]}", ""), format!("{beam} spin about its y axis at node `root`: {why}"));
    assert_eq!(said("{to: [x]}", ""), format!("{beam} slide along its x axis at node `tip`: {why}"));
    let spin = said("{from: [rx], to: [rx]}", ", support: fixed");
    assert!(spin.starts_with(&format!("{beam} spin about its x axis at node")), "{spin}");
    assert_eq!(said("{from: [ry, rz], to: [rx, ry, rz]}", ", support: fixed"), "");
}

fn pynite() -> Value {
    json("pynite/frames.json")
}

/// A structure of `frames.json` as a description whose nodes are of one body.
fn description(structure: &Value, body: &str) -> String {
    let list = |key: &str| structure[key].as_array().expect("a list").clone();
    let word = |value: &Value| value.as_str().expect("a word").to_string();
    let number = |value: &Value, key: &str| value[key].as_f64().unwrap_or(0.0);
    let mut text = String::from("units: {length: m, angle: rad}\ngravity: [0, 0, -9.80665]\nframes:\n");
    text += "  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-3, 3]}\n";
    let (mut materials, mut sections, mut beams) = (String::new(), String::new(), String::new());
    for (k, member) in list("members").iter().enumerate() {
        let z = Vector3::from_vec(numbers(&member["local_z"])).normalize();
        let _ = writeln!(text, "  z{k}: {{antecedent: 0, gamma: {:?}, alpha: {:?}}}", z.x.atan2(-z.y), z.z.acos());
        let of = |key: &str| number(member, key);
        let density = if of("rho") > 0.0 { format!(", density: {:?}", of("rho")) } else { String::new() };
        let _ = writeln!(materials, "  m{k}: {{young: {:?}, shear: {:?}{density}}}", of("E"), of("G"));
        let [a, iy, iz, j] = ["A", "Iy", "Iz", "J"].map(of);
        let _ = writeln!(sections, "  s{k}: {{area: {a:?}, iy: {iy:?}, iz: {iz:?}, j: {j:?}}}");
        let (from, to) = (word(&member["from"]), word(&member["to"]));
        let release = match &member["release"] {
            Value::Null => String::new(),
            hinge => format!(", release: {{{}: [r{}]}}", word(&hinge["end"]), word(&hinge["about"])),
        };
        let _ =
            writeln!(beams, "  b{k}: {{from: {from}, to: {to}, section: s{k}, material: m{k}, normal: z{k}{release}}}");
    }
    let _ = writeln!(text, "tool: {{frame: 1}}\nmaterials:\n{materials}sections:\n{sections}beams:\n{beams}nodes:");
    let supports = list("supports");
    for node in list("nodes") {
        let held = supports.iter().find(|support| support["node"] == node["name"]).map(|support| {
            let held: Vec<bool> = support["held"].as_array().expect("a list").iter().map(|h| *h == true).collect();
            if held[5] { ", support: fixed" } else { ", support: pinned" }
        });
        let point = numbers(&node["xyz"]);
        let _ = writeln!(
            text,
            "  {}: {{body: {body}, at: 0, point: {point:?}{}}}",
            word(&node["name"]),
            held.unwrap_or_default()
        );
    }
    if body == "1" {
        // The joint holds what the base holds already.
        let _ = writeln!(text, "joint_stiffness: {{1: {{at: {}}}}}", word(&supports[0]["node"]));
    }
    text
}

#[test]
fn frames_computed_by_pynite() {
    let frames = pynite();
    let mut seen = Vec::new();
    for structure in frames["structures"].as_array().expect("structures") {
        let name = structure["name"].as_str().expect("a name");
        for body in ["0", "1"] {
            let model = model_of(&description(structure, body));
            for case in structure["load_cases"].as_array().expect("cases") {
                let loads: Vec<(&str, Vector6<f64>)> = case["node_loads"]
                    .as_array()
                    .expect("loads")
                    .iter()
                    .map(|load| (load["node"].as_str().expect("a name"), Vector6::from_vec(numbers(&load["load"]))))
                    .collect();
                let weight = !case["member_loads"].as_array().expect("loads").is_empty();
                let found = node_displacements(&model, &[0.0], &loads, weight);
                let expected: Vec<(String, Vector6<f64>)> = case["displacements"]
                    .as_array()
                    .expect("displacements")
                    .iter()
                    .map(|row| {
                        (row["node"].as_str().expect("a name").to_string(), Vector6::from_vec(numbers(&row["u"])))
                    })
                    .collect();
                for half in [0, 3] {
                    let size = expected.iter().map(|(_, u)| u.fixed_rows::<3>(half).amax()).fold(0.0, f64::max);
                    for (node, u) in &expected {
                        let own = found.iter().find(|(known, _)| known == node).expect("a node").1;
                        let off = (own.fixed_rows::<3>(half) - u.fixed_rows::<3>(half)).amax() / size;
                        assert!(off < 1e-10, "{name} on {body}, {}, {node}: {off:e}", case["name"]);
                    }
                }
                seen.push(format!("{name} {body} {}", case["name"]));
            }
        }
    }
    assert_eq!(seen.len(), 12, "{seen:?}");
}

/// A boom that slides out of a sleeve along the base's x: `0.2 m + q2` of it are out.
const BOOM: &str = "units: {length: m, angle: rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-3, 3]}
  mouth: {antecedent: 1, b: 0.5, gamma: 1.5707963267948966, alpha: 1.5707963267948966}
  2: {antecedent: mouth, joint: prismatic, variable: q2, r: 0.2, limits: [0, 1.5]}
tool: {frame: 2}
materials: {steel: {young: 2.1e11, shear: 8.0e10, density: 7850}}
sections: {s: {area: 3e-3, iy: 2e-6, iz: 5e-6, j: 4e-6}}
nodes: {sleeve: {body: 2, at: mouth}, tip: {body: 2}}
beams: {boom: {from: sleeve, to: tip, section: s, material: steel, normal: 1}}
gravity: [0, 0, -9.81]
";

/// The tool's compliance and sag by the closed form of a cantilever as long as the boom is out: length declared plus joint.
#[test]
fn a_boom_bends_as_far_as_it_is_out() {
    let (a, iy, iz, j) = (3e-3, 2e-6, 5e-6, 4e-6);
    for (more, tilt) in [("", 0.0), ("joint_stiffness: {2: {krr: {compliance: 4e-7}}}\n", 4e-7)] {
        for (parts, least) in [("", 1e-12), ("elements: 3, ", 1e-11)] {
            let text = BOOM.replace("section: s,", &format!("{parts}section: s,")) + more;
            let model = model_of(&text);
            let loads = elastogeo::state::Loads { weight: true, wrench: true };
            let mechanics =
                elastogeo::state::Mechanics::new(&model, &model.registry.nominal(), loads, &[]).expect("assembled");
            let mut state = mechanics.state();
            for q in [0.0, 0.3, 0.75, 1.5] {
                mechanics.place(&[0.0, q], &mut state).expect("placed");
                let point = mechanics.point(&state, None, &[0.0; 6]);
                assert!((point.position - Vector3::new(0.2 + q, 0.0, 0.5)).norm() < 1e-12, "{}", point.position);
                let l = 0.2 + q;
                let found = mechanics.compliance(&state, &point);
                let of = |row: usize, column: usize, expected: f64| {
                    close(found[(row, column)], expected, least, &format!("{q} [{row}, {column}]"));
                };
                // Iy resists bending in the plane of x and z: the base's z is the beam's own.
                of(0, 0, l / (E * a));
                of(1, 1, l.powi(3) / (3.0 * E * iz) + tilt * l * l);
                of(2, 2, l.powi(3) / (3.0 * E * iy) + tilt * l * l);
                of(3, 3, l / (G * j));
                of(4, 4, l / (E * iy) + tilt);
                of(2, 4, -l * l / (2.0 * E * iy) - tilt * l);
                of(1, 5, l * l / (2.0 * E * iz) + tilt * l);
                let weight = 7850.0 * a * 9.81;
                let sag = weight * l.powi(4) / (8.0 * E * iy) + tilt * weight * l * l / 2.0 * l;
                close(mechanics.deflection(&state, &point).displacement.z, -sag, 1e-9, "sag");
                // Strain energies of a cantilever under its own weight, and of the spring at its root.
                let [bent, turned] =
                    [weight.powi(2) * l.powi(5) / (40.0 * E * iy), tilt * (weight * l * l / 2.0).powi(2) / 2.0];
                let shares = mechanics.shares(&state, &point);
                close(shares.energy["beam:boom"], bent / (bent + turned), 1e-9, "share of the beam");
                close(shares.total, bent + turned, 1e-9, "energy");
            }
            let drawn_in = mechanics.place(&[0.0, -0.3], &mut state).expect_err("nothing is out");
            assert!(drawn_in.to_string().contains("`boom` is drawn into its sleeve"), "{drawn_in}");
        }
    }
}

/// With nothing out at joint zero the boom has a length by its limits, and without these it is refused.
#[test]
fn a_boom_that_slides_in_entirely() {
    let model = model_of(&BOOM.replace("r: 0.2, limits: [0, 1.5]", "limits: [0.1, 1.5]"));
    let loads = elastogeo::state::Loads { weight: false, wrench: true };
    let mechanics = elastogeo::state::Mechanics::new(&model, &model.registry.nominal(), loads, &[]).expect("assembled");
    let mut state = mechanics.state();
    mechanics.place(&[0.4, 0.9], &mut state).expect("placed");
    let point = mechanics.point(&state, None, &[0.0; 6]);
    close(mechanics.compliance(&state, &point)[(2, 2)], 0.9_f64.powi(3) / (3.0 * E * 2e-6), 1e-12, "bending");
    let unlimited = BOOM.replace("r: 0.2, limits: [0, 1.5]", "r: 0");
    let raw: elastogeo::description::raw::RawRobot = serde_yaml::from_str(&unlimited).expect("readable");
    let robot = elastogeo::description::resolve::resolve(&raw, &|_| None).0.expect("resolved");
    let faults = elastogeo::model::build(&robot, elastogeo::effects::Catalogue::standard()).expect_err("no length");
    assert!(faults[0].diagnostic.message.contains("beam `boom` has no length"), "{:?}", faults[0]);
    assert!(faults[0].diagnostic.remedy.as_ref().is_some_and(|remedy| remedy.contains("limits")));
}
