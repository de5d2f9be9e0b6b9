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
