//! Geometry against independent reference values (`tests/data/golden/golden.json`).

use elastogeo::kinematics::{By, ErrorColumns, Geometry, Placements, Rates};

use crate::support::{bundled, golden, numbers};

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} against {expected}");
}

#[test]
fn ir663_forward_model_and_closure() {
    let model = bundled("kuka-ir663");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut placements = Placements::default();
    let tolerance = 1e-10;
    for pose in golden()["ir663_fk"]["poses"].as_array().expect("poses") {
        geometry.place(&numbers(&pose["q"]), &mut placements).expect("placed");
        let joint = |name: &str| placements.joints[model.frame(name).expect("a frame")];
        for (frame, key) in [("2", "theta2"), ("8", "theta8"), ("3", "theta3"), ("9", "theta9"), ("10", "theta10")] {
            close(joint(frame), pose[key].as_f64().expect("a number"), tolerance, key);
        }
        let end = placements.frames[model.frame("E").expect("a frame")].to_homogeneous();
        for (k, expected) in numbers(&pose["T_0E"]).into_iter().enumerate() {
            close(end[(k / 4, k % 4)], expected, tolerance, "T_0E");
        }
    }
}

#[test]
fn ir663_error_jacobian() {
    let model = bundled("kuka-ir663");
    let golden = golden();
    let golden = &golden["ir663_error_jacobian"];
    let names: Vec<String> = numbers_as_names(&golden["columns"]);
    let slots: Vec<By> = names.iter().map(|name| By::Slot(model.registry.slot(name).expect(name))).collect();
    let mut free: Vec<String> = model.free_slots().iter().map(|&slot| model.registry[slot].name.clone()).collect();
    let mut expected = names.clone();
    free.sort();
    expected.sort();
    assert_eq!(free, expected, "the rule frees the paper's 43 parameters");
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut rates = Rates::new(&model);
    let plan = ErrorColumns::new(&geometry, &rates, model.tool.0, &slots);
    let mut placements = Placements::default();
    let mut columns = vec![[0.0; 6]; slots.len()];
    for config in golden["configs"].as_array().expect("configs") {
        let q = numbers(&config["q"]);
        geometry.place(&q, &mut placements).expect("placed");
        rates.evaluate(&geometry, &q, &placements);
        plan.evaluate(&geometry, &placements, &rates, &mut columns);
        let jacobian = numbers(&config["J"]);
        for (k, expected) in jacobian.into_iter().enumerate() {
            let (row, column) = (k / slots.len(), k % slots.len());
            close(columns[column][row], expected, 1e-8, &names[column]);
        }
    }
}

/// The reference calls `alpha1` what the registry calls `1.alpha`, and the screws' parameters `l12`, `r2p`.
fn numbers_as_names(value: &serde_json::Value) -> Vec<String> {
    let list = value.as_array().expect("a list");
    list.iter()
        .map(|name| match name.as_str().expect("a name") {
            "r2p" => "screw2.stroke".into(),
            "r8p" => "screw8.stroke".into(),
            "kappa2" => "screw2.kappa".into(),
            "kappa8" => "screw8.kappa".into(),
            "lam2" => "screw2.lambda".into(),
            "lam8" => "screw8.lambda".into(),
            "l12" => "screw2.l1".into(),
            "l32" => "screw2.l3".into(),
            "l18" => "screw8.l1".into(),
            "l38" => "screw8.l3".into(),
            name => {
                let at = name.find(|c: char| c.is_ascii_digit() || c == 'E').expect("a frame");
                format!("{}.{}", &name[at..], &name[..at])
            }
        })
        .collect()
}

/// The four-bar alone, both cranks driven directly.
const FOUR_BAR: &str = "
units: {angle: deg}
frames:
  2: {antecedent: 0, joint: revolute, variable: q2, theta: -90}
  3: {antecedent: 2, joint: revolute, passive: true, d: 1.047}
  10: {antecedent: 3, joint: revolute, passive: true, gamma: 90, d: 0.4, theta: -90}
  8: {antecedent: 0, joint: revolute, coaxial: 2, variable: q8}
  9: {antecedent: 8, joint: revolute, passive: true, d: 0.473}
  11: {antecedent: 9, d: 1.212}
loops: {bar: {frames: [10, 11], branch: {3: 20, 9: -129, 10: -20}, at: {q2: 0, q8: 40}}}
tool: {frame: 3}
";

#[test]
fn four_bar_closure_and_its_gradient() {
    let model = crate::support::model_of(FOUR_BAR);
    let geometry = Geometry::nominal(&model).expect("assembled");
    let mut rates = Rates::new(&model);
    let mut placements = Placements::default();
    let slot = |name: &str| model.registry.slot(name).expect("a slot");
    let frame = |name: &str| model.frame(name).expect("a frame");
    for sample in golden()["fourbar"]["samples"].as_array().expect("samples") {
        let number = |key: &str| sample[key].as_f64().expect("a number");
        let q = [number("theta2_deg").to_radians(), number("theta8_deg").to_radians()];
        geometry.place(&q, &mut placements).expect("placed");
        for (name, key) in [("3", "theta3"), ("9", "theta9"), ("10", "theta10")] {
            close(placements.joints[frame(name)], number(key), 1e-10, key);
        }
        rates.evaluate(&geometry, &q, &placements);
        let rate = |driver: usize| rates.rate(frame("3"), driver);
        let gradient = numbers(&sample["gradient_a3_b3_c3_d3_e3"]);
        close(rate(0), gradient[0], 1e-8, "a3");
        close(rate(1), -gradient[0], 1e-8, "-a3");
        for (k, name) in ["3.d", "9.d", "10.d", "11.d"].into_iter().enumerate() {
            close(rate(rates.driver(slot(name)).expect("a driver")), gradient[k + 1], 1e-8, name);
        }
    }
}

#[test]
fn slider_crank_and_its_gradient() {
    let golden = golden();
    let golden = &golden["slider_crank"];
    let constant = |key: &str| golden[key].as_f64().expect("a number");
    let values = [0.0, constant("kappa"), constant("lambda"), constant("l1"), constant("l3")];
    for sample in golden["samples"].as_array().expect("samples") {
        let (theta, by) =
            elastogeo::kinematics::slider_crank(sample["r"].as_f64().expect("a number"), &values).expect("closed");
        close(theta, sample["theta"].as_f64().expect("a number"), 1e-10, "theta");
        for (found, expected) in by.into_iter().zip(numbers(&sample["gradient_r_kappa_lambda_l1_l3"])) {
            close(found, expected, 1e-8, "gradient");
        }
    }
}

mod kr270 {
    use super::*;
    use elastogeo::model::Model;
    use nalgebra::{DMatrix, Matrix4, Rotation3, Translation3, Vector3};

    fn model() -> Model {
        let path = format!("{}/robots/kuka-kr270.yaml", env!("CARGO_MANIFEST_DIR"));
        elastogeo::files::load_robot(&path).expect("readable").model
    }

    /// Frame E has x up and z forward, the reference x forward and z up.
    fn turned() -> Matrix4<f64> {
        Rotation3::from_basis_unchecked(&[Vector3::z(), -Vector3::y(), Vector3::x()]).to_homogeneous()
    }

    #[test]
    fn forward_model() {
        let model = model();
        let geometry = Geometry::nominal(&model).expect("assembled");
        let golden = golden();
        let mut placements = Placements::default();
        for pose in golden["kr270_fk"]["poses"].as_array().expect("poses") {
            let degrees = numbers(&pose["q_deg"]);
            let tool = numbers(&pose["tool"]);
            for (signs, key) in [("signs_plus", "T_plus"), ("signs_kuka", "T_kuka")] {
                let signs = numbers(&golden["kr270_fk"][signs]);
                let q: Vec<f64> = degrees.iter().zip(signs).map(|(q, sign)| sign * q.to_radians()).collect();
                geometry.place(&q, &mut placements).expect("placed");
                let end = placements.frames[model.tool.0].to_homogeneous() * turned();
                let end = end * Translation3::new(tool[0], tool[1], tool[2]).to_homogeneous();
                for (k, expected) in numbers(&pose[key]).into_iter().enumerate() {
                    close(end[(k / 4, k % 4)], expected, 1e-10, key);
                }
                if let (Some(at), Some(expected)) = (pose.get("tool_xyz"), pose.get("T_plus_tool"))
                    && key == "T_plus"
                {
                    let at = numbers(at);
                    let point = end * Translation3::new(at[0], at[1], at[2]).to_homogeneous();
                    for (k, expected) in numbers(expected).into_iter().enumerate() {
                        close(point[(k / 4, k % 4)], expected, 1e-10, "T_plus_tool");
                    }
                }
            }
        }
    }

    /// The chain of the calibration paper's Table III, written out, with its 18 parameters.
    fn chain(q: &[f64], p: &[f64]) -> Matrix4<f64> {
        let t = |x: f64, y: f64, z: f64| Translation3::new(x, y, z).to_homogeneous();
        let r = |axis: Vector3<f64>| Rotation3::new(axis).to_homogeneous();
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let [d1, a1, a2, a3, d4, d6] = [0.75, 0.35, 1.25, -0.055, 1.1, 0.23];
        t(0.0, 0.0, d1)
            * r(z * q[0])
            * t(a1 + p[0], p[1], 0.0)
            * r(x * p[2])
            * r(y * (q[1] + p[3]))
            * t(a2 + p[4], 0.0, 0.0)
            * r(x * p[5])
            * r(z * p[6])
            * r(y * (q[2] + p[7]))
            * t(d4 + p[8], 0.0, a3 + p[9])
            * r(z * p[10])
            * r(x * (q[3] + p[11]))
            * t(0.0, p[12], p[13])
            * r(z * p[14])
            * r(y * (q[4] + p[15]))
            * t(0.0, 0.0, p[16])
            * r(z * p[17])
            * r(x * q[5])
            * t(d6, 0.0, 0.0)
    }

    /// Columns of the chain's tool pose error by a change of its parameters, base and tool, by central differences.
    fn chain_columns(q: &[f64], with_arrangement: bool) -> DMatrix<f64> {
        let h = 1e-6;
        let pose = |p: &[f64], base: &[f64], tool: &[f64]| {
            let placed = |v: &[f64]| {
                Translation3::new(v[0], v[1], v[2]).to_homogeneous()
                    * Rotation3::new(Vector3::new(v[3], v[4], v[5])).to_homogeneous()
            };
            placed(base) * chain(q, p) * placed(tool)
        };
        let n = if with_arrangement { 30 } else { 18 };
        let at = |column: usize, change: f64| {
            let mut all = vec![0.0; 30];
            all[column] = change;
            pose(&all[..18], &all[18..24], &all[24..])
        };
        DMatrix::from_fn(6, n, |row, column| {
            let (plus, minus) = (at(column, h), at(column, -h));
            if row < 3 {
                (plus[(row, 3)] - minus[(row, 3)]) / (2.0 * h)
            } else {
                let turn = plus.fixed_view::<3, 3>(0, 0) * minus.fixed_view::<3, 3>(0, 0).transpose();
                let (i, j) = [(2, 1), (0, 2), (1, 0)][row - 3];
                (turn[(i, j)] - turn[(j, i)]) / (4.0 * h)
            }
        })
    }

    #[test]
    fn the_papers_18_parameters_span_the_same_errors_as_the_derived_ones() {
        let golden = golden();
        for config in golden["kr270_error_jacobian"]["configs"].as_array().expect("configs") {
            let q: Vec<f64> = numbers(&config["q_deg"]).iter().map(|q| q.to_radians()).collect();
            let columns = chain_columns(&q, false);
            for (k, expected) in numbers(&config["J"]).into_iter().enumerate() {
                close(columns[(k / 18, k % 18)], expected, 1e-8, "the chain written out here, against the reference");
            }
        }
        let model = model();
        let geometry = Geometry::nominal(&model).expect("assembled");
        let configurations =
            elastogeo::simulation::draw_configurations(&geometry, 40, 0.8, &mut elastogeo::simulation::generator(3))
                .expect("drawn");
        let by: Vec<By> = model.free_slots().into_iter().map(By::Slot).collect();
        let mut rates = Rates::new(&model);
        let plan = ErrorColumns::new(&geometry, &rates, model.tool.0, &by);
        let (mut placements, mut columns) = (Placements::default(), vec![[0.0; 6]; by.len()]);
        let mut ours = DMatrix::zeros(240, by.len() + 12);
        let mut theirs = DMatrix::zeros(240, 30);
        for (at, q) in configurations.iter().enumerate() {
            geometry.place(q, &mut placements).expect("placed");
            rates.evaluate(&geometry, q, &placements);
            plan.evaluate(&geometry, &placements, &rates, &mut columns);
            let chain = chain_columns(q, true);
            for row in 0..6 {
                (0..30).for_each(|k| theirs[(6 * at + row, k)] = chain[(row, k)]);
                (0..by.len()).for_each(|k| ours[(6 * at + row, k)] = columns[k][row]);
                (0..12).for_each(|k| ours[(6 * at + row, by.len() + k)] = chain[(row, 18 + k)]);
            }
        }
        let rank = |m: &DMatrix<f64>| m.clone().svd(false, false).rank(1e-6);
        let mut both = DMatrix::zeros(240, ours.ncols() + 30);
        both.columns_mut(0, ours.ncols()).copy_from(&ours);
        both.columns_mut(ours.ncols(), 30).copy_from(&theirs);
        assert_eq!((rank(&ours), rank(&theirs), rank(&both)), (30, 30, 30));
        // The description declares the paper's parameters as sums of its own: but for base and tool they move the tool alike.
        let declared = elastogeo::files::load_robot("kuka-kr270").expect("readable").robot.calibration.combinations;
        let sums = &declared["table-iii"];
        assert_eq!(sums.len(), 18);
        let mut left = ours.columns(0, by.len()).into_owned();
        for (k, slot) in model.free_slots().into_iter().enumerate() {
            for (p, sum) in sums.values().enumerate() {
                let factor =
                    sum.of.iter().filter(|(name, _)| *name == model.registry[slot].name).map(|(_, factor)| factor);
                left.column_mut(k).axpy(-factor.sum::<f64>(), &theirs.column(p), 1.0);
            }
        }
        let arranged = theirs.columns(18, 12).into_owned().svd(true, true);
        let base_and_tool = theirs.columns(18, 12) * arranged.solve(&left, 1e-9).expect("solved");
        assert!((left - base_and_tool).amax() < 1e-8, "sums of the description are not the paper's parameters");
    }
}
