//! Derivatives of predictions under load by every parameter, against central differences.

use std::fmt::Write;

use elastogeo::description::campaign::Campaign;
use elastogeo::files::load_campaign;
use elastogeo::identifiability::{elastic_parameters, elastic_sensitivities};
use elastogeo::kinematics::{Geometry, Rates};
use elastogeo::model::Model;
use elastogeo::observation::{DEFLECTION, DEFLECTION_POSE, POSE, POSITION};
use elastogeo::parameter::{Group, Kind, Slot};
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, generator, simulate};

use crate::random_robots::{Draw, Sketch, placed, serial};
use crate::support::model_of;

/// Step of a parameter: some of its value, and at zero so little that loops still answer in proportion.
fn step(model: &Model, slot: Slot, value: f64) -> f64 {
    let parameter = &model.registry[slot];
    match (parameter.group, parameter.kind) {
        (Group::Elastic, Kind::LinearCompliance) => (1e-3 * value.abs()).max(1e-11),
        (Group::Elastic, Kind::RotationalCompliance) => (1e-3 * value.abs()).max(1e-10),
        (Group::Elastic, Kind::LinearStiffness | Kind::RotationalStiffness) => (1e-3 * value.abs()).max(1e3),
        (Group::Elastic, Kind::Other("1/(N.m2)")) => 1e-10,
        (Group::Elastic, Kind::Mass) => (1e-2 * value.abs()).max(0.1),
        (Group::Elastic, Kind::Other("kg/m3")) => (1e-2 * value.abs()).max(10.0),
        (Group::Elastic, Kind::Length) if value == 0.0 => 1e-4,
        (Group::Elastic, _) => 1e-3 * value.abs(),
        _ => 2e-4,
    }
}

/// Checks every column of a campaign at `values`, but of the slots that `skip` names.
fn columns_agree(model: &Model, campaign: &Campaign, values: &[f64], tolerance: f64) -> usize {
    let slots: Vec<Slot> = (0..values.len()).collect();
    let predictor = Predictor::new(model, campaign, slots.clone()).expect("readings");
    let mut at = Linearised::default();
    predictor.linearise(values, true, &mut at).expect("predicted");
    let residual = |slot: Slot, change: f64| {
        let mut moved = values.to_vec();
        moved[slot] += change;
        let mut found = Linearised::default();
        predictor.linearise(&moved, false, &mut found).expect("predicted");
        found.residual
    };
    let mut told = 0;
    let mut wrong = String::new();
    for &slot in &slots {
        let h = step(model, slot, values[slot]);
        let difference = |h: f64| -> Vec<f64> {
            let (plus, minus) = (residual(slot, h), residual(slot, -h));
            minus.iter().zip(&plus).map(|(minus, plus)| (minus - plus) / (2.0 * h)).collect()
        };
        // Truncation of the second order taken out.
        let (coarse, fine) = (difference(h), difference(0.5 * h));
        let expected: Vec<f64> = fine.iter().zip(&coarse).map(|(fine, coarse)| (4.0 * fine - coarse) / 3.0).collect();
        let analytic: Vec<f64> = (0..expected.len()).map(|row| at.jacobian[row * slots.len() + slot]).collect();
        let size = analytic.iter().chain(&expected).fold(0.0_f64, |m, v| m.max(v.abs()));
        told += usize::from(size > 0.0 && model.registry[slot].group == Group::Elastic);
        // What is left of a subtraction of metres, or of a deflection of millimetres.
        let rounding = if campaign.observes == DEFLECTION { 1e-16 } else { 2e-14 };
        for (row, (found, expected)) in analytic.iter().zip(&expected).enumerate() {
            if (found - expected).abs() > tolerance * size + rounding / h {
                let _ = writeln!(
                    wrong,
                    "{:?} by {} row {row}: {found:e} against {expected:e} (of {size:e})",
                    campaign.observes, model.registry[slot].name
                );
                break;
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    told
}

/// Campaigns of each kind at the same configurations, each reading under two wrenches; how many elastic parameters
/// showed.
fn all_agree(model: &Model, configurations: Vec<Vec<f64>>, values: &[f64], tolerance: f64) -> usize {
    let mut told = 0;
    for observes in [DEFLECTION, POSE, POSITION] {
        let mut markers: Vec<Option<usize>> = vec![None];
        if observes != POSE {
            markers.extend((0..model.markers.len()).map(Some));
        }
        let plan = Plan {
            conditions: false,
            configurations: configurations.clone(),
            observes,
            markers,
            repeats: 1,
            sigma: 0.0,
            sigma_orientation: 0.0,
            estimate: [true, true],
            wrenches: vec![[300.0, -200.0, -500.0, 40.0, -70.0, 90.0], [0.0; 6]],
        };
        // The truth itself: where a rotation is off, its residual's derivative is not the prediction's.
        let campaign = simulate(model, values, &plan, &mut generator(1)).expect("simulated");
        let own = columns_agree(model, &campaign, values, tolerance);
        told = told.max(own);
    }
    told
}

/// Nominal values with base and tool somewhere, so that nothing is zero by chance.
fn moved(model: &Model, seed: u64) -> Vec<f64> {
    let mut values = model.registry.nominal();
    let draw = &mut Draw::new(seed);
    for (slot, parameter) in model.registry.all().iter().enumerate() {
        if matches!(parameter.group, Group::Base | Group::Tool) {
            values[slot] += draw.within(-0.2, 0.2);
        }
    }
    values
}

fn drawn(model: &Model, count: usize, seed: u64) -> Vec<Vec<f64>> {
    let geometry = Geometry::nominal(model).expect("assembled");
    draw_configurations(&geometry, count, 0.7, &mut generator(seed)).expect("drawn")
}

fn robot(name: &str, change: &[(&str, &str)], more: &str) -> Model {
    let folder = tempfile::tempdir().expect("a folder");
    for end in ["yaml", "urdf"] {
        let path = format!("{}/robots/{name}.{end}", env!("CARGO_MANIFEST_DIR"));
        if let Ok(mut text) = std::fs::read_to_string(path) {
            if end == "yaml" {
                for (from, to) in change {
                    assert!(text.contains(from), "{from}");
                    text = text.replace(from, to);
                }
                text += more;
            }
            std::fs::write(folder.path().join(format!("{name}.{end}")), text).expect("written");
        }
    }
    let path = folder.path().join(format!("{name}.yaml"));
    match elastogeo::files::load_robot(path.to_str().expect("a name")) {
        Ok(loaded) => loaded.model,
        Err(said) => panic!("{}", elastogeo::render::diagnostics::render(&said, false)),
    }
}

#[test]
fn ir663() {
    let model = robot("kuka-ir663", &[], "");
    let told = all_agree(&model, drawn(&model, 2, 1), &moved(&model, 1), 1e-7);
    assert!(told >= 40, "{told}");
}

#[test]
fn ir663_with_soft_screws() {
    for path in ["pins", "joint"] {
        let axial = format!("axial: {{value: 1.2e5, identifiable: true}}, path: {path}");
        let bodies = "bodies: {3: {mass: 300, com: [200, 100, 0]}, 9: {mass: 80, com: [300, 0, 50]}, E: {mass: 60}}\n";
        let model = robot("kuka-ir663", &[("axial: {value: .inf}", &axial)], bodies);
        let told = all_agree(&model, drawn(&model, 2, 2), &moved(&model, 2), 1e-7);
        assert!(told >= 45, "{path} {told}");
        assert!(model.registry.slot("screw2.axial").is_some());
    }
}

#[test]
fn kr270() {
    let weights = "base_stiffness: {kz: {value: 2e8}, krx: {value: 1e9}, kry: {compliance: 2e-9}}\n";
    for (acts, rate) in [("stiffness", "0.144e-6"), ("full", "0.9e-5")] {
        let change = [
            ("acts: stiffness", format!("acts: {acts}")),
            ("rate: {compliance: 0.144e-6", format!("rate: {{compliance: {rate}")),
        ];
        let change = change.each_ref().map(|(from, to)| (*from, to.as_str()));
        let model = robot("kuka-kr270", &change, weights);
        let told = all_agree(&model, drawn(&model, 2, 3), &moved(&model, 3), 1e-7);
        assert!(told >= 40, "{acts} {told}");
    }
}

#[test]
fn timoshenko_beams_with_a_taper() {
    for change in [
        &[][..],
        // Hinges and a slide at ends of beams, in cycles and in a chain.
        &[("section: rod, material: steel,", "section: rod, material: steel, release: {from: [ry, rz], to: [x]},")],
        &[
            ("section: rod, material: steel,", "section: rod, material: steel, release: {to: [rx, rz]},"),
            ("normal: 1, elements: 3", "normal: 1, elements: 3, release: {from: [rz]}"),
            ("section: rect, material: steel,", "section: rect, material: steel, release: {from: [ry]},"),
        ],
    ] {
        let mut text = TIMOSHENKO.to_string();
        for (from, to) in change {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let model = model_of(&text);
        let told = all_agree(&model, drawn(&model, 2, 4), &moved(&model, 4), 1e-7);
        assert!(told >= 40, "{told}");
    }
}

const TIMOSHENKO: &str = "units: {length: m, angle: rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 0.5, limits: [-3, 3]}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: -1.2, d: 0.6, limits: [-2, 2]}
  3: {antecedent: 2, joint: revolute, variable: q3, alpha: 0.7, d: 0.7, r: 0.2, limits: [-2, 2]}
  E: {antecedent: 3, d: 0.3}
tool: {frame: E}
markers: {ball: {frame: E, at: [0.1, 0.2, -0.1]}, mid: {frame: 2, at: [0.3, 0.1, 0.0]}}
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}, alu: {young: 7e10, shear: 2.6e10, density: 2700}}
sections:
  box: {shape: box, width: 0.12, height: 0.09, wall: 0.006}
  tube: {shape: tube, diameter: 0.1, wall: 0.005}
  rect: {shape: rectangle, width: 0.05, height: 0.07}
  rod: {shape: rod, diameter: 0.06}
  i: {shape: i, width: 0.1, height: 0.15, wall: 0.008, flange: 0.01}
  given: {area: 2e-3, iy: 3e-6, iz: 5e-6, j: 4e-6, shear_y: 1.1e-3, shear_z: 1.3e-3}
nodes:
  a: {body: 1}
  b: {body: 1, at: 2, point: [0, 0, 0.05]}
  c: {body: 2}
  d: {body: 2, at: 3}
  side: {body: 2, point: [0.3, 0.2, 0.1]}
  e: {body: 3}
  f: {body: 3, at: E}
beams:
  column: {from: a, to: b, section: i, material: steel, theory: timoshenko, elements: 2}
  upper: {from: c, to: d, section: box, section_to: given, material: alu, theory: timoshenko, normal: 1, elements: 3}
  lower: {from: side, to: d, section: rect, material: steel, theory: timoshenko}
  left: {from: side, to: c, section: rod, material: steel, theory: timoshenko}
  hand: {from: f, to: e, section: tube, material: alu, theory: timoshenko, normal: 2}
joint_stiffness:
  2: {kar: {value: 1e5}, krr: {value: 1e6}, kr: {value: 1e8}, ka: {value: 3e8}}
base_stiffness: {kx: {value: 1e8}, krz: {value: 1e6}}
bodies: {3: {mass: 30, com: [0.1, 0.1, 0.2]}}
";

/// A random serial robot with springs in its joints, masses, beams and a compliant pedestal.
fn with_elastics(sketch: &Sketch, seed: u64) -> String {
    let draw = &mut Draw::new(seed ^ 77);
    let mut text = sketch.yaml();
    text += "base_stiffness: {kx: {value: 3e7}, krz: {value: 1e6}}\njoint_stiffness:\n";
    let (mut bodies, mut beams) = (String::new(), String::new());
    let moving: Vec<_> = sketch.parts.iter().filter(|part| !part.joint.is_empty()).collect();
    for part in &moving {
        let springs = ["ka", "kr", "kar", "krr"].iter().enumerate().filter_map(|(k, key)| {
            let size = if k < 2 { 1e-8 } else { 1e-6 };
            (!draw.chance(0.3)).then(|| format!("{key}: {{compliance: {:?}}}", size * draw.within(1.0, 9.0)))
        });
        let springs = springs.collect::<Vec<_>>().join(", ");
        if !springs.is_empty() {
            let _ = writeln!(text, "  {}: {{{springs}}}", part.name);
        }
        let com: [f64; 3] = std::array::from_fn(|_| draw.within(-0.2, 0.2));
        let _ = writeln!(bodies, "  {}: {{mass: {:?}, com: {com:?}}}", part.name, draw.within(1.0, 50.0));
        let carried = sketch.part(&part.name).constants;
        let far = placed(&carried, "", 0.0).translation.vector.norm() > 0.1;
        let inner = moving.iter().any(|other| other.name == part.antecedent);
        let single = sketch.parts.iter().filter(|other| other.antecedent == part.antecedent).count() == 1;
        if far && inner && single && part.joint == "revolute" && part.coaxial.is_none() && draw.chance(0.6) {
            let theory = if draw.chance(0.5) { "timoshenko" } else { "euler-bernoulli" };
            let _ = writeln!(
                beams,
                "  b{}: {{from: {}, to: {}, section: box, material: steel, theory: {theory}, elements: {}}}",
                part.name,
                part.antecedent,
                part.name,
                1 + draw.below(2)
            );
        }
    }
    let _ = writeln!(text, "bodies:\n{bodies}gravity: [0.5, -1, -9.6]");
    if !beams.is_empty() {
        let _ = writeln!(
            text,
            "materials: {{steel: {{young: 2e11, poisson: 0.3, density: 7850}}}}
sections: {{box: {{shape: box, width: 0.1, height: 0.14, wall: 0.01}}}}
beams:\n{beams}"
        );
    }
    text
}

#[test]
fn random_serial_robots() {
    let (mut regular, mut beams) = (0, 0);
    for seed in 0..40 {
        let sketch = serial(seed);
        let model = model_of(&with_elastics(&sketch, seed));
        let known = sketch.at();
        let q: Vec<f64> = model
            .variables
            .iter()
            .map(|variable| known.iter().find(|(name, _)| *name == variable.name).expect("a variable").1)
            .collect();
        // Slider-cranks near the end of their travel turn their joints fast.
        let geometry = Geometry::nominal(&model).expect("assembled");
        let (mut rates, mut at) = (Rates::new(&model), Default::default());
        geometry.place(&q, &mut at).expect("placed");
        rates.evaluate(&geometry, &q, &at);
        let fastest = (0..model.frames.len())
            .flat_map(|joint| (0..q.len()).map(move |k| (joint, k)))
            .map(|(joint, k)| rates.rate(joint, k).abs())
            .fold(0.0, f64::max);
        if fastest > 10.0 {
            continue;
        }
        beams += usize::from(model.structure.tree.iter().any(|edge| edge.name.starts_with("beam")));
        all_agree(&model, vec![q], &moved(&model, seed), 1e-7);
        regular += 1;
    }
    assert!(regular > 30 && beams > 8, "{regular} {beams}");
}

const BOOM: &str = "units: {length: m, angle: rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-3, 3]}
  mouth: {antecedent: 1, b: 0.5, gamma: 1.2, alpha: 1.3}
  2: {antecedent: mouth, joint: prismatic, variable: q2, r: 0.2, limits: [0, 1.5]}
  3: {antecedent: 2, joint: revolute, variable: q3, alpha: 0.7, d: 0.1, limits: [-3, 3]}
  E: {antecedent: 3, d: 0.3, r: 0.1}
tool: {frame: E}
materials: {steel: {young: 2.1e11, shear: 8.0e10, density: 7850}}
sections: {s: {area: 3e-3, iy: 2e-6, iz: 5e-6, j: 4e-6, shear_y: 1.5e-3, shear_z: 2e-3}}
nodes: {sleeve: {body: 2, at: mouth}, tip: {body: 2, point: [0.02, 0, 0.05]}}
beams: {boom: {from: sleeve, to: tip, section: s, material: steel, normal: 1, theory: timoshenko, elements: 2}}
joint_stiffness: {2: {krx: {compliance: 2e-8}, kry: {compliance: 3e-8}, krrx: {compliance: 4e-7}, krry: {compliance: 5e-7}}}
bodies: {2: {mass: 12, com: [0.1, 0, -0.2]}, 3: {mass: 7, com: [0.1, 0.1, 0]}}
gravity: [0.5, -1, -9.6]
";

/// A boom out of its sleeve: its length follows the joint, its zero and its frame's constants.
#[test]
fn a_boom_out_of_its_sleeve() {
    let model = model_of(BOOM);
    let configurations = vec![vec![0.3, 0.1, 0.8], vec![-0.7, 1.2, -0.4]];
    assert!(all_agree(&model, configurations, &moved(&model, 3), 1e-7) >= 12);
}

/// What a description is refused for.
fn refused(text: &str) -> Option<String> {
    let found = elastogeo::files::Reader::default().robot_text(std::path::Path::new("boom.yaml"), text);
    found.err().map(|found| Vec::from(found).iter().map(|one| format!("{} {:?}\n", one.message, one.remedy)).collect())
}

/// Limits within which nothing of the boom is out of its sleeve, and a sleeve at a frame far from the joint.
#[test]
fn booms_drawn_into_their_sleeves_are_refused() {
    // At the middle of the limits the tip is 0.2 + 0.75 + 0.05 m from the mouth.
    for (limits, words) in
        [("[-0.3, 1.8]", "drawn into its sleeve within the limits of joint `2`: at -0.3000 m"), ("[-0.2, 1.7]", "")]
    {
        let text = BOOM.replace("[0, 1.5]", limits);
        let said = refused(&text);
        assert!(
            said.is_some() != words.is_empty() && said.as_ref().is_none_or(|said| said.contains(words)),
            "{limits}: {said:?}"
        );
    }
    let said = refused(&BOOM.replace("at: mouth", "at: 0")).expect("refused");
    assert!(said.contains("node `sleeve` lies at `0`") && said.contains("`mouth`"), "{said}");
}

/// Springs across an axis that differ between x and y.
#[test]
fn springs_of_each_lateral_direction() {
    let stiffness = "{kar: {compliance: 0.302e-6, identifiable: true}}";
    let lateral = "{kar: {compliance: 0.302e-6}, krx: {compliance: 3e-9, identifiable: true}, kry: {value: 2e8}, \
                   krrx: {value: 4e6, identifiable: true}, krry: {compliance: 0}}";
    let model = robot("kuka-kr270", &[(stiffness, lateral)], "");
    for name in ["krx", "kry", "krrx", "krry"] {
        assert!(model.registry.slot(&format!("joint2.{name}")).is_some(), "{name}");
    }
    assert!(model.registry.slot("joint2.kr").is_none() && model.registry.slot("joint3.kr").is_some());
    all_agree(&model, drawn(&model, 2, 5), &moved(&model, 4), 1e-7);
}

/// Against differences of what is predicted, reading by reading: nothing of the derivatives is used.
#[test]
fn elastic_sensitivities_are_differences_of_the_deflection() {
    for name in ["ir663-axial-screws", "ir663-simulated", "kr270-rigid-joint-1", "kr270-simulated"] {
        let campaign_name = name;
        let loaded = load_campaign(name, None).expect("bundled");
        let (model, nominal) = (&loaded.robot.model, loaded.robot.model.registry.nominal());
        let mut campaign = loaded.campaign;
        let is_difference = campaign.is_difference();
        let slots = elastic_parameters(model);
        let found = elastic_sensitivities(model, &campaign, &slots).expect("predicted");
        // The tool in every configuration and under every load, once.
        let seen = std::cell::RefCell::new(Vec::new());
        campaign = campaign.select(|_, reading| {
            let own = (reading.pose, reading.wrench.map(f64::to_bits));
            let is_new = !seen.borrow().contains(&own);
            seen.borrow_mut().push(own);
            is_new
        });
        for reading in &mut campaign.readings {
            (reading.observes, reading.marker) = (if is_difference { DEFLECTION_POSE } else { POSE }, None);
            reading.measured = [0.0; 6];
        }
        // Rotations are compared near zero: measured is what is predicted.
        let mut found_at = Linearised::default();
        Predictor::new(model, &campaign, Vec::new())
            .expect("readings")
            .linearise(&nominal, false, &mut found_at)
            .expect("predicted");
        for (reading, own) in campaign.readings.iter_mut().zip(found_at.residual.chunks(6)).filter(|_| !is_difference) {
            (3..6).for_each(|k| reading.measured[k] -= own[k]);
        }
        let predictor = Predictor::new(model, &campaign, Vec::new()).expect("readings");
        let residual = |slot: Slot, change: f64| {
            let (mut moved, mut found) = (nominal.clone(), Linearised::default());
            moved[slot] += change;
            predictor.linearise(&moved, false, &mut found).expect("predicted");
            found.residual
        };
        let mut compared = 0;
        for (slot, own) in slots.iter().zip(&found) {
            let h = step(model, *slot, nominal[*slot]);
            let difference = |h: f64| -> Vec<f64> {
                let (plus, minus) = (residual(*slot, h), residual(*slot, -h));
                minus.iter().zip(&plus).map(|(minus, plus)| (minus - plus) / (2.0 * h)).collect()
            };
            let (coarse, fine) = (difference(h), difference(0.5 * h));
            let by: Vec<f64> = fine.iter().zip(&coarse).map(|(fine, coarse)| (4.0 * fine - coarse) / 3.0).collect();
            let norms = |from: usize| {
                by.chunks(6).map(move |rows| rows[from..from + 3].iter().map(|v| v * v).sum::<f64>().sqrt())
            };
            for (from, mu) in [(0, own.position), (3, own.orientation)] {
                let expected = [norms(from).sum::<f64>() / (by.len() / 6) as f64, norms(from).fold(0.0, f64::max)];
                // Rounding of metres over the step.
                let rounding = 1e-14 / h;
                for (mu, expected) in mu.into_iter().zip(expected) {
                    let name = &model.registry[*slot].name;
                    assert!(
                        (mu - expected).abs() <= 1e-6 * expected + rounding,
                        "{campaign_name} {name}: {mu} {expected}"
                    );
                    compared += usize::from(expected > 1e3 * rounding);
                }
            }
        }
        assert!(compared >= 8, "{name}: {compared}");
    }
}
