//! Deflections against independent reference values (`tests/data/golden/golden.json`), and against the displacement
//! method with great and small numbers for rigid and passive.

use elastogeo::elastics::{Elastics, Response, Statics, shares};
use elastogeo::elements::{PerLength, SpringState};
use elastogeo::model::Model;
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};
use serde_json::Value;

use crate::loaded::{Assembly, Held, beam_stiffness, deflection, node, placed, respond};
use crate::support::{bundled, golden, numbers};

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} is a number"))
}

/// Largest difference against the largest entry of the expected block, 3x3 block by block: their units differ.
fn difference(found: &Matrix6<f64>, expected: &Matrix6<f64>) -> f64 {
    let mut worst = 0.0_f64;
    for (i, j) in [(0, 0), (0, 3), (3, 0), (3, 3)] {
        let (a, b) = (found.fixed_view::<3, 3>(i, j), expected.fixed_view::<3, 3>(i, j));
        worst = worst.max((a - b).amax() / b.amax());
    }
    worst
}

fn vector_difference(found: &Vector6<f64>, expected: &Vector6<f64>) -> f64 {
    let part =
        |k: usize| (found.fixed_rows::<3>(k) - expected.fixed_rows::<3>(k)).amax() / expected.fixed_rows::<3>(k).amax();
    part(0).max(part(3))
}

/// Stroke of a screw that turns its joint to an angle.
fn stroke(model: &Model, values: &[f64], actuator: usize, theta: f64) -> f64 {
    let slot = model.actuators[actuator].slot;
    let [zero, kappa, lambda, l1, l3] = std::array::from_fn(|k| values[slot + k]);
    (l1 * l1 + l3 * l3 + 2.0 * l1 * l3 * (kappa + lambda - theta).cos()).sqrt() - zero
}

const JOINTS: [&str; 5] = ["2", "8", "3", "9", "10"];

/// Values with what is rigid in the golden structure put in as the golden has it: finite.
fn finite(model: &Model, ka: f64, krr: f64) -> Vec<f64> {
    let mut values = model.registry.nominal();
    for joint in JOINTS {
        values[model.registry.slot(&format!("joint{joint}.ka")).expect("a slot")] = 1.0 / ka;
        values[model.registry.slot(&format!("joint{joint}.krr")).expect("a slot")] = 1.0 / krr;
    }
    values
}

fn configuration(model: &Model, values: &[f64], config: &Value) -> Vec<f64> {
    let angle = |key: &str| number(config, key).to_radians();
    let q = [0, 1].map(|k| stroke(model, values, k, angle(["theta2_deg", "theta8_deg"][k])));
    vec![angle("theta1_deg"), q[0], q[1], 0.3, 0.9, -0.4]
}

/// Compliance at the wrist, and its displacement under the beams' weight.
fn ours(model: &Model, values: &[f64], q: &[f64]) -> (Matrix6<f64>, Vector6<f64>) {
    let frame = model.frame("7").expect("a frame");
    let vertex = model.structure.carrier(frame, &Vector3::zeros());
    let (_, _, response) = respond(model, values, q, vertex, true).expect("no mechanism");
    let point = placed(model, values, q).frames[frame].translation.vector;
    let (d, r) = response.displacement(&point, &Vector3::zeros(), &Vector3::zeros(), true);
    (response.compliance_at(&point), Vector6::new(d.x, d.y, d.z, r.x, r.y, r.z))
}

#[test]
fn the_ir663_has_66_degrees_of_freedom_of_which_60_are_free() {
    assert_eq!(bundled("kuka-ir663").structure.freedom, [66, 60]);
}

#[test]
fn ir663_compliance_and_own_weight() {
    let model = bundled("kuka-ir663");
    let golden = golden();
    let golden = &golden["ir663_compliance"];
    let given = &golden["gamma_N_per_m_and_Nm_per_rad"];
    let values = finite(&model, number(given, "Ka"), number(given, "Krr"));
    for config in golden["configs"].as_array().expect("configurations") {
        let q = configuration(&model, &values, config);
        let wrist = placed(&model, &values, &q).frames[model.frame("7").expect("a frame")].translation.vector;
        assert!((wrist - Vector3::from_vec(numbers(&config["E_xyz"]))).amax() < 1e-12);
        let (compliance, weight) = ours(&model, &values, &q);
        let expected = Matrix6::from_row_slice(&numbers(&config["C_E"]));
        assert!(difference(&compliance, &expected) < 1e-12, "{:e}", difference(&compliance, &expected));
        let expected = Vector6::from_vec(numbers(&config["beam_weight_displacement_E"]));
        assert!(vector_difference(&weight, &expected) < 1e-12, "{:e}", vector_difference(&weight, &expected));
        // The wrench at the wrist that would do the same (eq. 27 of the IR663 paper); rows and columns of one size.
        let scale = Matrix6::from_diagonal(&compliance.diagonal().map(|c| c.sqrt().recip()));
        let even = (scale * compliance * scale).lu();
        let equivalent = scale * even.solve(&(scale * weight)).expect("regular");
        let expected = Vector6::from_vec(numbers(&config["beam_weight_F_eq_at_E"]));
        let off = vector_difference(&equivalent, &expected);
        assert!(off < 1e-11, "{off:e}");
    }
}

/// How the second way treats what is rigid and what is passive.
#[derive(Clone, Copy)]
enum Way {
    /// Springs of these stiffnesses (ka, krr, about a passive axis) between nodes with six unknowns each.
    Penalty([f64; 3]),
    /// Rigid directions have no unknowns, passive ones have some that nothing holds.
    Exact,
}

/// The structure of the paper, written out: 11 nodes, 6 beams, 5 joints; compliance and own weight at node E.
fn by_displacements(model: &Model, values: &[f64], q: &[f64], way: Way) -> (Matrix6<f64>, Vector6<f64>) {
    let golden = golden();
    let golden = &golden["ir663_compliance"];
    let at = placed(model, values, q);
    let frame = |name: &str| &at.frames[model.frame(name).expect("a frame")];
    let origin = |name: &str| frame(name).translation.vector;
    // 0 1 2 3 3' 10 E 8 9 9' 10'
    let points = ["0", "1", "2", "3", "3", "10", "4", "8", "9", "9", "11"].map(origin);
    let normal = frame("2").rotation.matrix().column(2).into_owned();
    let given = &golden["gamma_N_per_m_and_Nm_per_rad"];
    let key = |name: &str| number(given, name);
    let rows = [
        ([1, 2], "2", key("K12r"), Some(key("K12ar"))),
        ([1, 7], "8", key("K18r"), Some(key("K18ar"))),
        ([3, 4], "3", key("K33r"), None),
        ([8, 9], "9", key("K99r"), None),
        ([5, 10], "10", key("K1010r"), None),
    ];
    let axes = |joint: &str| *frame(joint).rotation.matrix();
    let slaves: Vec<(usize, usize, Matrix3<f64>, [Held; 6])> = match way {
        Way::Penalty(_) => Vec::new(),
        Way::Exact => rows
            .iter()
            .map(|&([a, b], joint, kr, kar)| {
                let about = kar.map_or(Held::Free, Held::By);
                let held = [Held::By(kr), Held::By(kr), Held::Rigid, Held::Rigid, Held::Rigid, about];
                (b, a, axes(joint), held)
            })
            .collect(),
    };
    let mut assembly = Assembly::new(11, &slaves);
    if let Way::Penalty([ka, krr, passive]) = way {
        for (ends, joint, kr, kar) in rows {
            assembly.springs(ends, &axes(joint), [kr, kr, ka, krr, krr, kar.unwrap_or(passive)]);
        }
    }
    for (name, ends) in
        [("b1", [0, 1]), ("b2", [2, 3]), ("b3", [4, 5]), ("b4", [5, 6]), ("b5", [7, 8]), ("b6", [9, 10])]
    {
        let of = &golden["sections_ASSUMED"][name];
        let along = points[ends[1]] - points[ends[0]];
        let length = along.norm();
        let x = along / length;
        let axes = Matrix3::from_columns(&[x, normal.cross(&x), normal]);
        let section = ["A", "Iy", "Iz", "J"].map(|key| number(of, key));
        let stiffness = beam_stiffness(number(of, "E"), number(of, "G"), section, [f64::INFINITY; 2], length);
        let weight = Vector3::new(0.0, 0.0, -9.81 * number(of, "rho") * section[0]);
        assembly.beam(ends, &axes, &stiffness, (length, weight));
    }
    assembly.solve(6)
}

#[test]
fn rigid_and_passive_are_no_penalties() {
    let model = bundled("kuka-ir663");
    let golden = golden();
    let golden = &golden["ir663_compliance"];
    let nominal = model.registry.nominal();
    let given = &golden["gamma_N_per_m_and_Nm_per_rad"];
    let (ka, krr, passive) = (number(given, "Ka"), number(given, "Krr"), number(given, "Kpas"));
    let soft = finite(&model, ka, krr);
    let (mut moderate, mut extreme, mut both) = (0.0_f64, 0.0_f64, 0.0_f64);
    for config in golden["configs"].as_array().expect("configurations") {
        let q = configuration(&model, &nominal, config);
        // The golden's own numbers, put into a double-precision displacement method.
        let expected = Matrix6::from_row_slice(&numbers(&config["C_E"]));
        let penalty = by_displacements(&model, &soft, &q, Way::Penalty([ka, krr, passive]));
        moderate = moderate.max(difference(&penalty.0, &expected));
        // What is rigid is rigid: the same method without penalties, and with them.
        let exact = by_displacements(&model, &nominal, &q, Way::Exact);
        let (compliance, weight) = ours(&model, &nominal, &q);
        both = both.max(difference(&compliance, &exact.0)).max(vector_difference(&weight, &exact.1));
        let penalty = by_displacements(&model, &nominal, &q, Way::Penalty([1e15, 1e15, 1e-10]));
        extreme = extreme.max(difference(&penalty.0, &compliance));
    }
    // Measured: 4e-13 without penalties, 8e-11 with the golden's, 1.3e-8 with 1e15 and 1e-10 (180 and 30 000 times).
    assert!(both < 2e-12, "{both:e}");
    assert!(moderate > 50.0 * both && extreme > 5e3 * both, "{moderate:e} {extreme:e} {both:e}");
}

#[test]
fn beam_matrices() {
    let golden = golden();
    let golden = &golden["beam"];
    let of = |key: &str| number(golden, key);
    let (e, g, l) = (of("E"), of("G"), of("L"));
    let section = ["A", "Iy", "Iz", "J"].map(of);
    let areas = [of("Asy"), of("Asz")];
    for (key, areas) in [("K_euler_bernoulli", [f64::INFINITY; 2]), ("K_timoshenko", areas)] {
        let expected = SMatrix::<f64, 12, 12>::from_row_slice(&numbers(&golden[key]));
        let mut scale = SMatrix::<f64, 12, 1>::from_element(1.0);
        (0..12).for_each(|k| scale[k] = expected[(k, k)].sqrt());
        let close = |found: &SMatrix<f64, 12, 12>, what: &str| {
            for i in 0..12 {
                for j in 0..12 {
                    let off = (found[(i, j)] - expected[(i, j)]).abs() / (scale[i] * scale[j]);
                    assert!(off < 1e-13, "{key} {what} {i} {j}: {off:e}");
                }
            }
        };
        close(&beam_stiffness(e, g, section, areas, l), "textbook");
        // What the flexibility of the far end implies: K = B' F^-1 B with B = [-T 1], T the near end's rigid motion.
        let [a, iy, iz, j] = section;
        let inverse = [e * a, g * areas[0], g * areas[1], e * iy, e * iz, g * j].map(f64::recip);
        let flexibility = PerLength { compliance: inverse, mass: 0.0 }.flexibility(l).apply_all(&Matrix6::identity());
        let mut carried = Matrix6::identity();
        (carried[(1, 5)], carried[(2, 4)]) = (l, -l);
        let mut b = SMatrix::<f64, 6, 12>::zeros();
        b.fixed_view_mut::<6, 6>(0, 0).copy_from(&-carried);
        b.fixed_view_mut::<6, 6>(0, 6).copy_from(&Matrix6::identity());
        close(&(b.transpose() * flexibility.try_inverse().expect("regular") * b), "from the flexibility");
    }
}

/// Which properties a description's beam enters with, by its theory.
#[test]
fn sections_of_the_ir663_are_the_assumed_ones() {
    let model = bundled("kuka-ir663");
    let golden = golden();
    let sections = &golden["ir663_compliance"]["sections_ASSUMED"];
    let mut seen = 0;
    let nominal = model.registry.nominal();
    let value = |name: &str| nominal[model.registry.slot(name).expect("a parameter")];
    let young = value("steel.young");
    let shear = young / (2.0 * (1.0 + value("steel.poisson")));
    for edge in model.structure.edges() {
        let Some(name) = edge.name.strip_prefix("beam:") else { continue };
        let of = edge.element.per_length(&nominal).expect("a beam").compliance;
        assert_eq!([of[1], of[2]], [0.0; 2], "no shear");
        let expected = &sections[name];
        for (found, key) in [(young * of[0], "A"), (young * of[3], "Iy"), (young * of[4], "Iz"), (shear * of[5], "J")] {
            assert!((found * number(expected, key) - 1.0).abs() < 1e-14, "{name} {key}");
        }
        seen += 1;
    }
    assert_eq!(seen, 6);
}

mod kr270 {
    use super::*;

    fn model(acts: &str) -> Model {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["kuka-kr270.yaml", "kuka-kr270.urdf"] {
            let text = std::fs::read_to_string(format!("{}/robots/{name}", env!("CARGO_MANIFEST_DIR"))).expect("read");
            std::fs::write(folder.path().join(name), text.replace("acts: stiffness", &format!("acts: {acts}")))
                .expect("written");
        }
        let path = folder.path().join("kuka-kr270.yaml");
        elastogeo::files::load_robot(path.to_str().expect("a name")).expect("readable").model
    }

    #[test]
    fn deflection_of_the_flange() {
        let model = model("stiffness");
        let golden = golden();
        let mut without = model.registry.nominal();
        without[model.registry.slot("compensator.stiffness").expect("a slot")] = 0.0;
        for sample in golden["kr270_deflection"]["samples"].as_array().expect("samples") {
            let q: Vec<f64> = numbers(&sample["q_deg"]).iter().map(|q| q.to_radians()).collect();
            let wrench = numbers(&sample["wrench"]);
            for (key, values) in [("dS_with", &model.registry.nominal()), ("dS_without", &without)] {
                let found = deflection(&model, values, &q, ("E", [0.0; 3]), &wrench, false);
                let expected = Vector6::from_vec(numbers(&sample[key]));
                let off = vector_difference(&found, &expected);
                assert!(off < 1e-12, "{key} {off:e}");
            }
        }
    }

    #[test]
    fn compensator() {
        let model = model("full");
        let golden = golden();
        let golden = &golden["kr270_compensator"];
        let nominal = model.registry.nominal();
        let mut stiff = nominal.clone();
        stiff[model.registry.slot("joint1.kar").expect("a slot")] = 0.0;
        let mut weightless = stiff.clone();
        for mass in &model.structure.masses {
            weightless[mass.slot] = 0.0;
        }
        for sample in golden["samples"].as_array().expect("samples") {
            let q = [0.4, number(sample, "q2_deg").to_radians(), 0.0, 0.0, 0.0, 0.0];
            let at = placed(&model, &nominal, &q);
            let axis = at.frames[model.frame("2").expect("a frame")].rotation.matrix().column(2).into_owned();
            let state = SpringState::new(&model.structure.springs[0], &nominal, &at.frames);
            let stiffness = (axis.transpose() * state.stiffness().fixed_view::<3, 3>(3, 3) * axis).x;
            let moment = axis.dot(&state.wrench().fixed_rows::<3>(3));
            let about = |found: f64, key: &str, size: f64| {
                let off = (found - number(sample, key)).abs() / size;
                assert!(off < 1e-13, "{key}: {off:e}");
            };
            about(state.length, "s", 1.0);
            about(stiffness, "stiffness", 6e5);
            about(moment, "Mc", 6e5);
            // One joint, turned by a moment about its axis: 1/k2 = 1/k2_0 + stiffness.
            let load = [0.0, 0.0, 0.0, axis.x, axis.y, axis.z];
            let turn = deflection(&model, &stiff, &q, ("2", [0.0; 3]), &load, false);
            assert!(turn.fixed_rows::<3>(0).amax() < 1e-20);
            let found = axis.dot(&turn.fixed_rows::<3>(3));
            assert!((found / number(sample, "k2") - 1.0).abs() < 1e-12, "{found}");
            // Its own force turns it by Mc k2 where nothing has weight.
            let turn = deflection(&model, &weightless, &q, ("2", [0.0; 3]), &[0.0; 6], true);
            let found = axis.dot(&turn.fixed_rows::<3>(3));
            let expected = number(sample, "Mc") * number(sample, "k2");
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    }
}

#[test]
fn responses_of_two_vertices_are_reciprocal() {
    let model = bundled("kuka-ir663");
    let values = model.registry.nominal();
    let q = configuration(&model, &values, &golden()["ir663_compliance"]["configs"][2]);
    let elastics = Elastics::new(&model, &values, &[]);
    let mut statics = Statics::new(false);
    elastics.prepare(&placed(&model, &values, &q), &mut statics).expect("no mechanism");
    let names = ["n1", "n2", "n3", "n3'", "n10", "nE", "n8", "n9", "n9'", "n10'"];
    // Back to the origin of the base, where wrenches are counted.
    let spatial_of = |displacement: [f64; 6], at: &Vector3<f64>| {
        let (d, r) = (Vector3::from_column_slice(&displacement[..3]), Vector3::from_column_slice(&displacement[3..]));
        let v = d - r.cross(at);
        Vector6::new(v.x, v.y, v.z, r.x, r.y, r.z)
    };
    let mut all = Vec::new();
    for name in names {
        let mut response = Response::new(&elastics, node(&model, name));
        response.evaluate(&elastics, &mut statics);
        let c = response.compliance;
        assert!((c - c.transpose()).amax() < 1e-13 * c.amax(), "{name}");
        all.push(response);
    }
    let moves = |of: usize, wrench: &Vector6<f64>, other: &str| {
        let found = shares(&elastics, &statics, &all[of], wrench, false);
        spatial_of(found.nodes[other], &statics.points[node(&model, other)])
    };
    for (i, a) in names.iter().enumerate() {
        for (j, b) in names.iter().enumerate().skip(i) {
            for (k, m) in [(0, 2), (1, 4), (5, 3), (2, 2)] {
                let (mut at_a, mut at_b) = (Vector6::zeros(), Vector6::zeros());
                (at_a[k], at_b[m]) = (1.0, 1.0);
                let b_by_a = moves(i, &at_a, b)[m];
                let a_by_b = moves(j, &at_b, a)[k];
                assert!((b_by_a - a_by_b).abs() < 1e-18, "{a} {b}: {b_by_a:e} {a_by_b:e}");
            }
        }
    }
}
