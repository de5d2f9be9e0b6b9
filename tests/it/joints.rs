//! Joints that are not simply driven: zeros on closing branches, limits of sums and of passive joints.

use elastogeo::kinematics::{Geometry, Hold, InverseError, InverseSettings, Placements, Target, solve};
use elastogeo::model::Model;
use serde_json::Value;

use super::cli::run;
use super::derivatives::columns_agree;
use super::support::{bundled, model_of, number, printed_json};

/// The parallelogram starter, in `pg`.
fn starter() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let made = run(folder.path(), &["init", "pg", "--kind", "parallelogram"]);
    assert_eq!(made.status, 0, "{}", made.err);
    folder
}

/// The starter's arm whose joint 3 follows joints 2 and 4, as `coupled.yaml`.
pub(super) fn coupled() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    assert_eq!(run(folder.path(), &["init", "arm"]).status, 0);
    let text = std::fs::read_to_string(folder.path().join("arm/robot.yaml")).expect("a description");
    let text = text.replace("variable: q3, d: 600, limits: [-70, 120]", "d: 600");
    let text = text.replace("\ntool:", "\ncouplings: [3 = 0.8 * 2 - 0.3 * 4]\ntool:");
    std::fs::write(folder.path().join("coupled.yaml"), text).expect("written");
    folder
}

/// Simulates with one zero off by 0.3 deg and nothing else, and identifies: the error left (mm), and the zero's change (deg).
fn found(folder: &std::path::Path, robot: &str, zero: &str, observes: &str) -> (f64, f64) {
    let set = format!("{zero}=0.3");
    let simulate = ["simulate", robot, "--poses", "60", "--observes", observes, "--noise", "0.03", "--errors", "0"];
    let made = run(folder, &[&simulate[..], &["--set", &set, "--into", "z"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let ran = run(folder, &["identify", "z", "--format", "json"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let json: Value = serde_json::from_str(&ran.out).expect("JSON");
    std::fs::remove_dir_all(folder.join("z")).expect("removed");
    let rms = json["residuals"]["after"]["rms"].as_f64().expect("a number");
    let parameters = json["parameters"].as_array().expect("a list");
    let of = parameters.iter().find(|parameter| parameter["name"] == zero).unwrap_or_else(|| panic!("no {zero}"));
    let number = |key: &str| of[key].as_f64().expect("a number");
    (rms, number("value") - number("nominal"))
}

#[test]
fn the_third_motor_of_a_palletiser_has_a_zero() {
    let folder = starter();
    let (rms, change) = found(folder.path(), "pg/robot.yaml", "6.theta", "position");
    // 0.03 mm in each coordinate.
    assert!(rms < 0.06, "{rms} mm left");
    assert!((change - 0.3).abs() < 0.02, "{change} deg");
}

/// A five-bar: two motors, one of them on the branch that closes.
const FIVE_BAR: &str = "units: {length: mm, angle: deg}
frames:
  a1: {antecedent: 0, joint: revolute, variable: q1, limits: [70, 150]}
  a2: {antecedent: a1, joint: revolute, passive: true, d: 300}
  p: {antecedent: a2, d: 400}
  b1: {antecedent: 0, joint: revolute, variable: q2, d: 250, limits: [20, 100]}
  b2: {antecedent: b1, joint: revolute, passive: true, d: 300}
  m: {antecedent: b2, d: 400}
loops:
  five-bar: {frames: [p, m], kind: planar, meet: origin, branch: {a2: -60, b2: 60}, at: {q1: 120, q2: 50}}
tool: {frame: p}
";

/// A platform on three legs, each with a motor at the ground (3-RRR).
const THREE_LEGS: &str = "units: {length: mm, angle: deg}
frames:
  a1: {antecedent: 0, joint: revolute, variable: q1, limits: [-30, 30]}
  a2: {antecedent: a1, joint: revolute, passive: true, d: 300}
  a3: {antecedent: a2, joint: revolute, passive: true, d: 300}
  b1: {antecedent: 0, joint: revolute, variable: q2, d: 800, limits: [90, 150]}
  b2: {antecedent: b1, joint: revolute, passive: true, d: 300}
  b3: {antecedent: b2, d: 300}
  c0: {antecedent: 0, gamma: 60, d: 800, theta: -60}
  c1: {antecedent: c0, joint: revolute, variable: q3, limits: [-150, -90]}
  c2: {antecedent: c1, joint: revolute, passive: true, d: 300}
  c3: {antecedent: c2, d: 300}
  pb: {antecedent: a3, d: 200}
  pc: {antecedent: a3, gamma: 60, d: 200}
  tcp: {antecedent: a3, gamma: 30, d: 115.47}
loops:
  b: {frames: [pb, b3], kind: planar, meet: origin, branch: {a2: 60, a3: -60, b2: 60}, at: {q1: 0, q2: 120, q3: -120}}
  c: {frames: [pc, c3], kind: planar, meet: origin, branch: {c2: 60}, at: {q1: 0, q2: 120, q3: -120}}
tool: {frame: tcp}
";

#[test]
fn motors_of_parallel_robots_have_zeros() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text, zeros) in [("five", FIVE_BAR, &["b1.theta"][..]), ("legs", THREE_LEGS, &["b1.theta", "c1.theta"])]
    {
        let file = format!("{name}.yaml");
        std::fs::write(folder.path().join(&file), text).expect("written");
        for zero in zeros {
            let (rms, change) = found(folder.path(), &file, zero, "pose");
            assert!(rms < 0.06, "{name} {zero}: {rms} mm left");
            assert!((change - 0.3).abs() < 0.03, "{name} {zero}: {change} deg");
        }
    }
}

/// Passive joints, and joints that actuators turn, have no zero of their own.
#[test]
fn the_ir663_keeps_its_candidates() {
    let model = bundled("kuka-ir663");
    assert_eq!(model.free_slots().len(), 43);
}

/// Whether a five-bar keeps `q1 - q2` and its passive joint, as declared by `limits`.
fn within(model: &Model, geometry: &Geometry, q: &[f64]) -> bool {
    let mut placements = Placements::default();
    geometry.place(q, &mut placements).expect("placed");
    let elbow = placements.joints[model.frame("a2").expect("a frame")].to_degrees();
    let apart = (q[0] - q[1]).to_degrees();
    (39.9..=90.1).contains(&apart) && (-100.1..=-39.9).contains(&elbow)
}

#[test]
fn limits_of_sums_and_of_passive_joints_are_heeded() {
    let folder = tempfile::tempdir().expect("a folder");
    let limited = FIVE_BAR.replace("passive: true, d: 300}\n  p:", "passive: true, d: 300, limits: [-100, -40]}\n  p:")
        + "limits: {q1 - q2: [40, 90]}\n";
    assert_eq!(limited.matches("limits").count(), 4);
    std::fs::write(folder.path().join("five.yaml"), &limited).expect("written");
    let model = model_of(&limited);
    let geometry = Geometry::nominal(&model).expect("assembled");
    let read = |file: &str, [a, b]: [&str; 2]| -> Vec<[f64; 2]> {
        let text = std::fs::read_to_string(folder.path().join(file)).expect("a file");
        let mut rows = csv::Reader::from_reader(text.as_bytes());
        let header = rows.headers().expect("a header").clone();
        let columns = [a, b].map(|name| header.iter().position(|known| known == name).expect("a column"));
        rows.records()
            .map(|row| row.expect("a row"))
            .map(|row| columns.map(|k| row[k].parse::<f64>().expect("a number").to_radians()))
            .collect()
    };

    let pose = |q: &str| run(folder.path(), &["pose", "five.yaml", "--joints", q]);
    assert_eq!(pose("120,50").err, "");
    let sum = pose("100,80").err;
    assert!(sum.contains("`q1 - q2` = 20 deg is beyond its limits 40 .. 90 deg"), "{sum}");
    let passive = pose("75,30").err;
    assert!(passive.contains("`a2` = ") && passive.contains("is beyond its limits -100 .. -40 deg"), "{passive}");

    let made = run(folder.path(), &["simulate", "five.yaml", "--poses", "40", "--errors", "0", "--into", "c"]);
    assert_eq!(made.status, 0, "{}", made.err);
    let drawn = read("c/measurements.csv", ["q1", "q2"]);
    assert!(drawn.len() >= 40 && drawn.iter().all(|q| within(&model, &geometry, q)), "{drawn:?}");
    let planned = run(folder.path(), &["plan", "five.yaml", "--poses", "8", "--observes", "pose", "--table", "p.csv"]);
    assert_eq!(planned.status, 0, "{}", planned.err);
    let planned = read("p.csv", ["q1", "q2"]);
    assert!(planned.len() == 8 && planned.iter().all(|q| within(&model, &geometry, q)), "{planned:?}");

    let free = model_of(FIVE_BAR);
    let open = Geometry::nominal(&free).expect("assembled");
    let settings = InverseSettings { restarts: 24, ..InverseSettings::default() };
    let mut placements = Placements::default();
    for (q, keeps) in [([120.0, 50.0], true), ([100.0, 80.0], false), ([145.0, 25.0], false)] {
        open.place(&q.map(f64::to_radians), &mut placements).expect("placed");
        let tool = placements.frames[free.tool.0] * open.tool();
        let target = Target { position: tool.translation.vector.into(), rotation: None, hold: Hold::POSE };
        match solve(&geometry, &target, &settings) {
            Ok(found) => {
                assert!(keeps, "{q:?}: {found:?}");
                assert!(found.iter().all(|one| within(&model, &geometry, &one.joints)));
            }
            Err(InverseError::OutOfReach { limits, .. }) => {
                assert!(!keeps && limits.iter().any(|name| name == "q1 - q2" || name == "a2"), "{q:?}: {limits:?}");
            }
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn limits_that_cannot_be_read_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = [
        ("{q1-q2: [0, 1]}", "unknown joint `q1-q2`"),
        ("{q1 - q9: [0, 1]}", "unknown joint `q9`"),
        ("{q1 - p: [0, 1]}", "frame `p` does not move"),
        ("{q1 - q2: [1, 0]}", "write [0, 1]"),
        ("{two * q1: [0, 1]}", "`two` is no factor"),
        ("{q1 + a2 x: [0, 1]}", "is no joint name"),
    ];
    for (limits, expected) in cases {
        std::fs::write(folder.path().join("five.yaml"), format!("{FIVE_BAR}limits: {limits}\n")).expect("written");
        let ran = run(folder.path(), &["check", "five.yaml"]);
        assert_eq!(ran.status, 2, "{limits}: {}", ran.err);
        assert!(ran.err.contains(expected) && ran.err.contains("five.yaml:12"), "{limits}: {}", ran.err);
    }
    std::fs::write(folder.path().join("five.yaml"), format!("{FIVE_BAR}limits: {{2 * q1 - a2: [0, 400]}}\n"))
        .expect("written");
    let ran = run(folder.path(), &["check", "five.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.out.contains("(2 * q1 - a2)") && ran.out.contains("0.00 .. 400.00 deg"), "{}", ran.out);
}

/// A carriage on a guide that is softer one way than the other.
const GUIDE: &str = "units: {length: mm, angle: deg, stiffness: N/m, rotational_stiffness: N.m/rad}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 400, limits: [-90, 90]}
  2: {antecedent: 1, joint: prismatic, variable: q2, alpha: 90, d: 100, limits: [100, 900]}
  3: {antecedent: 2, joint: revolute, variable: q3, alpha: -90, d: 50, limits: [-90, 90]}
  E: {antecedent: 3, d: 300, r: 100}
tool: {frame: E}
joint_stiffness:
  2: {krx: {value: 1e7, identifiable: true}, kry: {value: 1e7, identifiable: true}, krrx: {value: 1e6, identifiable: true}, krry: {value: 1e6, identifiable: true}}
";

#[test]
fn springs_of_each_lateral_direction_are_identified_and_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = [("krx", 1e7, 2e7), ("kry", 1e7, 5e6), ("krrx", 1e6, 3e6), ("krry", 1e6, 7e5)];
    let mut real = GUIDE.to_owned();
    for (symbol, from, to) in truth {
        let (old, new) = (format!("{symbol}: {{value: {from:e}"), format!("{symbol}: {{value: {to:e}"));
        assert!(real.contains(&old), "{old}");
        real = real.replace(&old, &new);
    }
    std::fs::write(folder.path().join("model.yaml"), GUIDE).expect("written");
    std::fs::write(folder.path().join("real.yaml"), real).expect("written");
    let loads = ["--wrench", "500,0,0,0,0,0", "--wrench", "0,500,0,0,0,0", "--wrench", "0,0,500,0,0,0"];
    let simulate = ["simulate", "real.yaml", "--poses", "20", "--observes", "deflection", "--errors", "0"];
    let made = run(folder.path(), &[&simulate[..], &loads, &["--noise", "0.0001", "--into", "c"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let campaign = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&campaign).expect("a file");
    assert!(text.contains("real.yaml"), "{text}");
    std::fs::write(&campaign, text.replace("real.yaml", "model.yaml")).expect("written");
    let identify = ["identify", "c", "--what", "elastic", "--save", "calibrated.yaml"];
    let ran = run(folder.path(), &identify);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let saved = folder.path().join("calibrated.yaml");
    let model = elastogeo::files::load_robot(&saved.display().to_string()).expect("read").model;
    for (symbol, _, expected) in truth {
        let parameter = &model.registry[model.registry.slot(&format!("joint2.{symbol}")).expect("a spring")];
        let found = parameter.shown(parameter.nominal);
        assert!((found - expected).abs() < 0.02 * expected, "{symbol}: {found:e} against {expected:e}");
    }
    let both = GUIDE.replace("kry: {value: 1e7, identifiable: true}", "kr: {value: 1e7}");
    std::fs::write(folder.path().join("both.yaml"), both).expect("written");
    let ran = run(folder.path(), &["check", "both.yaml"]);
    assert_eq!(ran.status, 2);
    assert!(ran.err.contains("`krx`") && ran.err.contains("give `kr`, or `krx` and `kry`"), "{}", ran.err);
}

/// A bearing that a loop moves gives as its spring says, whether the description or an effect has it.
#[test]
fn effects_sit_at_joints_that_nothing_drives() {
    // Were the other leg rigid, it would carry everything.
    let text = format!("{FIVE_BAR}joint_stiffness: {{b1: {{krr: {{value: 1e6}}}}, b2: {{krr: {{value: 1e6}}}}}}\n");
    let coupled = "frames:\n  1: {antecedent: 0, joint: revolute, variable: q1}\n  \
                   2: {antecedent: 1, joint: revolute, d: 0.4, alpha: 1}\n  E: {antecedent: 2, d: 0.3}\n\
                   couplings: [2 = -1 * 1]\ntool: {frame: E}\n";
    let cases = [
        (text.as_str(), "bearing-compliance", "joint:a2", "jointa2.krr", [2.0, 1.0]),
        (coupled, "bearing-compliance", "joint:2", "joint2.krr", [0.3, 0.0]),
        (coupled, "joint-compliance", "joint:2", "joint2.kar", [0.3, 0.0]),
    ];
    for (text, effect, site, spring, q) in cases {
        let plain = model_of(text);
        let mut with_effect = plain.clone();
        super::support::switch_on(&mut with_effect, effect, site, &[(spring, 2e-6)]);
        let q = &q[..plain.variables.len()];
        let plan = |observes| elastogeo::simulation::Plan {
            conditions: false,
            wrenches: vec![[100.0, 50.0, -200.0, 10.0, 20.0, -30.0]],
            configurations: vec![q.to_vec()],
            markers: vec![None],
            repeats: 1,
            observes,
            sigma: 0.0,
            sigma_orientation: 0.0,
            estimate: [false, false],
        };
        let reading = |model: &Model, values: &[f64]| {
            let plan = plan(elastogeo::observation::DEFLECTION);
            let random = &mut elastogeo::simulation::generator(1);
            elastogeo::simulation::simulate(model, values, &plan, random).expect("simulated").readings[0].measured
        };
        let mut values = plain.registry.nominal();
        let before = reading(&plain, &values);
        values[plain.registry.slot(spring).expect("a spring")] = 2e-6;
        let (declared, found) = (reading(&plain, &values), reading(&with_effect, &with_effect.registry.nominal()));
        assert!(declared.iter().zip(&before).any(|(a, b)| (a - b).abs() > 1e-6), "{spring}: {declared:?}");
        for (a, b) in declared.iter().zip(&found) {
            assert!((a - b).abs() < 1e-12, "{spring}: {declared:?} {found:?}");
        }
    }
    let folder = starter();
    let ran = run(
        folder.path(),
        &["simulate", "pg/robot.yaml", "--poses", "5", "--effect", "joint-offset@joint:3:3.theta=1e-3", "--into", "c"],
    );
    assert_eq!(ran.status, 2, "what a loop moves has no zero: {}", ran.err);
}

/// A joint that follows others errs by its own value, load and move, and alone: as its zero would by as much in that reading.
#[test]
fn effects_sit_at_joints_that_follow_others() {
    let text = "gravity: [0, 0, -9.81]\nframes:\n  1: {antecedent: 0, joint: revolute, variable: q1, limits: [-2, 2]}\n  \
                2: {antecedent: 1, joint: revolute, variable: q2, alpha: 1.2, d: 0.3, direction: -1, limits: [-2, 2]}\n  \
                3: {antecedent: 2, joint: revolute, alpha: 0.4, d: 0.5}\n  E: {antecedent: 3, d: 0.4, r: 0.1}\n\
                couplings: [3 = 0.7 * 2 - 0.5 * 1]\nbodies: {3: {mass: 20, com: [0.3, 0.1, 0]}}\ntool: {frame: E}\n";
    let plain = model_of(text);
    let values = plain.registry.nominal();
    let geometry = Geometry::new(&plain, &values).expect("a robot");
    let random = &mut elastogeo::simulation::generator(5);
    let plan = elastogeo::simulation::Plan {
        conditions: true,
        wrenches: vec![[0.0; 6]],
        configurations: elastogeo::simulation::draw_configurations(&geometry, 12, 0.9, random).expect("drawn"),
        markers: vec![None],
        repeats: 1,
        observes: elastogeo::observation::POSITION,
        sigma: 0.0,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    let mut campaign = elastogeo::simulation::simulate(&plain, &values, &plan, random).expect("simulated");
    campaign.number_in_order();
    let zero = plain.frames[3].moving_slot();
    // The load on the joint is what its zero changes in the potential of the mass.
    let placed = |by: f64, q: &[f64]| {
        let mut values = values.clone();
        values[zero] += by;
        let geometry = Geometry::new(&plain, &values).expect("a robot");
        let mut placements = Placements::default();
        geometry.place(q, &mut placements).expect("placed");
        let at = |frame: usize, x: [f64; 3]| placements.frames[frame].transform_point(&x.into()).coords;
        (at(4, [0.0; 3]), at(3, [0.3, 0.1, 0.0]).z)
    };
    let load = |q: &[f64]| -20.0 * 9.81 * (placed(1e-6, q).1 - placed(-1e-6, q).1) / 2e-6;
    // By its value, its load, its side and its last move.
    type Shift<'a> = &'a dyn Fn(f64, f64, f64, f64) -> f64;
    type Case<'a> = (&'a str, &'a [(&'a str, f64)], Shift<'a>);
    let cases: [Case; 7] = [
        ("gear-ratio", &[("ratio", 1e-6)], &|q, _, _, _| 1e-6 * q),
        ("transmission-error", &[("cos", 1e-6), ("order", 2.0)], &|q, _, _, _| 1e-6 * (2.0 * q).cos()),
        ("cable-torque", &[("pull", 1e-6), ("slack", 0.2)], &|q, _, _, _| {
            -1e-6 * q.signum() * (q.abs() - 0.2).max(0.0)
        }),
        ("joint-stiffening", &[("wind_up", 1e-6), ("wound_up_at", 30.0)], &|_, load, _, _| 1e-6 * (load / 30.0).tanh()),
        ("backlash", &[("half_width", 1e-6)], &|_, _, side, _| 1e-6 * side),
        ("settling", &[("share", 1e-6)], &|_, _, _, moved| 1e-6 * moved),
        ("hysteresis", &[("half_width", 1e-6), ("distance", 1e-9)], &|_, _, _, moved| -1e-6 * moved.signum()),
    ];
    for (effect, parameters, shift) in cases {
        let mut with_effect = plain.clone();
        super::support::switch_on(&mut with_effect, effect, "joint:3", parameters);
        let values = with_effect.registry.nominal();
        let predictor =
            elastogeo::prediction::Predictor::new(&with_effect, &campaign, Vec::new()).expect("a predictor");
        let mut found = elastogeo::prediction::Linearised::default();
        predictor.linearise(&values, false, &mut found).expect("predicted");
        for (index, predicted) in found.predicted.iter().enumerate().skip(1) {
            let (q, before) = (campaign.configuration(index), campaign.configuration(index - 1));
            let follows = |q: &[f64]| 0.7 * -q[1] - 0.5 * q[0];
            let sides: Vec<f64> = (0..2).map(|k| campaign.conditions.sides(k).expect("sides")[index]).collect();
            let moved = follows(q) - follows(before);
            let by = shift(follows(q), load(q), follows(&sides).signum(), moved);
            let (there, _) = placed(by, q);
            for k in 0..3 {
                assert!((predicted[k] - there[k]).abs() < 2e-12, "{effect} at {index}: {predicted:?} {there:?}");
            }
            assert!(
                (there - placed(0.0, q).0).norm() > 1e-9 || by.abs() < 1e-8,
                "{effect} at {index} changes something"
            );
        }
    }
}

/// A diagnosis finds an effect at a joint that follows others, and says what it is.
#[test]
fn a_gear_error_of_a_coupled_joint_is_found() {
    let folder = coupled();
    let effect = "transmission-error@joint:3:cos=8e-4,order=2";
    let simulate = ["simulate", "coupled.yaml", "--poses", "80", "--noise", "0.05", "--effect", effect, "--seed", "3"];
    let made = run(folder.path(), &[&simulate[..], &["--into", "s"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let json = super::support::printed_json(folder.path(), &["diagnose", "s"]);
    assert_eq!(json["verdict"], "explained", "{json}");
    let causes = json["causes"].as_array().expect("a list");
    let [cause] = &causes[..] else { panic!("{causes:?}") };
    assert_eq!((&cause["effect"], &cause["site"]), (&"transmission-error".into(), &"joint:3".into()), "{cause}");
    // Within less than a turn the order and the size go together.
    let of = |name: &str| {
        let own = cause["parameters"].as_array().expect("a list").iter().find(|own| own["name"] == name);
        own.expect("a parameter")["value"].as_f64().expect("a number")
    };
    let (amount, order) = (of("cos"), of("order"));
    assert!((amount / 8e-4 - 1.0).abs() < 0.2 && (order - 2.0).abs() < 0.3, "{amount} {order}");
}

/// A compensator's rate is identified against a length that is held: said, and no more once the length is free.
#[test]
fn a_held_free_length_is_said() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = super::support::heavy_kr270(folder.path(), super::support::KR270_MASSES);
    let loads = ["--observes", "deflection", "--wrench", "0,0,-2000,0,0,0", "--poses", "30", "--noise", "0.001"];
    let made = run(folder.path(), &[&["simulate", path.as_str()], &loads[..], &["--into", "c"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let ran = run(folder.path(), &["identify", "c", "--what", "elastic"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    for word in ["`compensator.free_length` is held at 458 mm", "free: [compensator.free_length]"] {
        assert!(ran.err.contains(word), "{word}: {}", ran.err);
    }
    let text = std::fs::read_to_string(&path).expect("a file") + "calibration: {free: [compensator.free_length]}\n";
    std::fs::write(&path, text).expect("written");
    let ran = run(folder.path(), &["identify", "c", "--what", "elastic"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(!ran.err.contains("is held at") && ran.out.contains("compensator.free_length"), "{}{}", ran.err, ran.out);
}

/// Readings at which a sum of joints or a passive joint is beyond its limits are told by whatever reads the campaign.
#[test]
fn campaigns_beyond_limits_of_sums_and_passive_joints_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |file: &str, text: &str| std::fs::write(folder.path().join(file), text).expect("written");
    write("free.yaml", FIVE_BAR);
    let limited = FIVE_BAR.replace("passive: true, d: 300}\n  p:", "passive: true, d: 300, limits: [-80, -60]}\n  p:")
        + "limits: {q1 - q2: [50, 70]}\n";
    write("limited.yaml", &limited);
    let made = run(folder.path(), &["simulate", "free.yaml", "--poses", "40", "--errors", "0", "--into", "c"]);
    assert_eq!(made.status, 0, "{}", made.err);
    for command in [&["check", "c"][..], &["identify", "c"], &["diagnose", "c"]] {
        assert!(!run(folder.path(), command).err.contains("beyond its limits"), "{command:?}");
    }
    let text = std::fs::read_to_string(folder.path().join("c/campaign.yaml")).expect("a campaign");
    write("c/limited.yaml", &text.replace("free.yaml", "limited.yaml"));
    let of = "c/limited.yaml";
    for command in [&["check", of][..], &["identify", of], &["diagnose", of], &["residuals", "limited.yaml", "c"]] {
        let said = run(folder.path(), command);
        for what in ["`q1 - q2` is beyond its limits 50 .. 70 deg", "`a2` is beyond its limits -80 .. -60 deg"] {
            assert!(said.err.contains(what), "{command:?} {what}: {}", said.err);
        }
    }
}

/// A cylinder that turns an arm: its loop has three equations and two passive joints, and closes in the least-squares sense
/// whatever its constants are off by, so that they are calibrated.
#[test]
fn a_loop_with_a_cylinder_is_calibrated() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "robot: cylinder arm
units: {length: mm, angle: deg}
frames:
  arm: {antecedent: 0, joint: revolute, passive: true}
  fore: {antecedent: arm, joint: revolute, variable: q2, d: 700, limits: [-100, 100]}
  E: {antecedent: fore, d: 500}
  lug: {antecedent: arm, d: 300}
  pivot: {antecedent: 0, joint: revolute, passive: true, gamma: -36.869898, d: 500}
  rod: {antecedent: pivot, joint: prismatic, variable: s, alpha: -90, limits: [480, 720]}
  rodend: {antecedent: rod, alpha: 90}
loops:
  l: {frames: [lug, rodend], kind: spatial, meet: origin, branch: {arm: 60, pivot: 61}, at: {s: 613, q2: 0}}
tool: {frame: E}
";
    std::fs::write(folder.path().join("arm.yaml"), text).expect("written");
    let (rms, change) = found(folder.path(), "arm.yaml", "fore.theta", "pose");
    assert!(rms < 0.06, "{rms} mm left");
    assert!((change - 0.3).abs() < 0.03, "{change} deg");
    // A description whose loop is off by more than its constants may be is told, or refused.
    for (length, status) in [("alpha: 90, r: 3}", 0), ("alpha: 90, r: 30}", 2)] {
        let open =
            text.replace("rodend: {antecedent: rod, alpha: 90}", &format!("rodend: {{antecedent: rod, {length}"));
        std::fs::write(folder.path().join("open.yaml"), open).expect("written");
        let said = run(folder.path(), &["check", "open.yaml"]);
        assert_eq!(said.status, status, "{}", said.err);
        assert!(said.err.contains("loop `l`"), "{}", said.err);
    }
}

/// A bearing that a loop moves competes with the spring of the spindle in whose leg it is: both give along the leg, and neither is named.
#[test]
fn bearings_of_passive_joints_compete() {
    let folder = starter();
    let at = folder.path();
    assert_eq!(run(at, &["convert", "hexapod", "plain.yaml"]).status, 0);
    let plain = std::fs::read_to_string(at.join("plain.yaml")).expect("read");
    let soft = plain.replacen("joint_stiffness:\n", "joint_stiffness:\n  v4: {kr: {value: 20000}}\n", 1);
    std::fs::write(at.join("soft.yaml"), soft).expect("written");
    let simulate = ["simulate", "soft.yaml", "--poses", "60", "--observes", "pose", "--noise", "0.01", "--into", "c"];
    let more = ["--orientation-noise", "0.001", "--wrench=0,0,0", "--wrench=300,0,-500", "--wrench=0,300,200"];
    assert_eq!(run(at, &[&simulate[..], &more[..]].concat()).status, 0);
    let campaign = std::fs::read_to_string(at.join("c/campaign.yaml")).expect("read");
    std::fs::write(at.join("c/campaign.yaml"), campaign.replace("soft.yaml", "plain.yaml")).expect("written");
    let said = run(at, &["diagnose", "c"]).out;
    let nearest = said.lines().find(|line| line.trim_start().starts_with("nearest")).unwrap_or_default();
    for of_leg in ["joint-compliance at joint:p4", "bearing-compliance at joint:v4"] {
        assert!(nearest.contains(of_leg), "{said}");
    }
}

/// An arm whose third joint is commanded against the horizontal: joint k turns back what joint 2 turns.
const LEVEL: &str = "units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 525}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, d: 150, theta: -90}
  k: {antecedent: 2, joint: revolute, d: 790}
  3: {antecedent: k, joint: revolute, variable: q3}
  4: {antecedent: 3, joint: revolute, variable: q4, alpha: -90, d: 250, r: 835}
couplings: [k = -1 * 2]
tool: {frame: 4, at: [0, 50, 100]}
effects: []
";

/// A zero of joint 2 moves joint 2 alone where the controller couples joint k, as its gear does; with rods both turn. By a zero that is
/// declared, by an effect, and in the derivatives.
#[test]
fn zeros_pass_on_by_mechanisms_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let tool = |text: &str| {
        std::fs::write(folder.path().join("arm.yaml"), text).expect("written");
        let pose = ["pose", "arm.yaml", "--weight", "--joints", "q2=30,q3=0"];
        let found = printed_json(folder.path(), &pose);
        [0, 1].map(|k| number(&found["tool"][k][3]))
    };
    let arm = |coupled: &str, zero: &str, effects: &str| {
        format!(
            "units: {{length: mm, angle: deg}}
variables: [q2, q3]
frames:
  2: {{antecedent: 0, joint: revolute, variable: q2{zero}}}
  k: {{antecedent: 2, joint: revolute, d: 500}}
  3: {{antecedent: k, joint: revolute, variable: q3}}
couplings: [\"k = -1 * 2{coupled}\"]
tool: {{frame: 3, at: [400, 0, 0]}}
{effects}"
        )
    };
    let shift = 1_f64.to_radians();
    let effect = format!("effects: [{{effect: joint-offset, site: 'joint:2', parameters: {{2.theta: {shift}}}}}]");
    let at = |k: f64| {
        let [two, all] = [31.0_f64, 31.0 + k].map(f64::to_radians);
        [0.5 * two.cos() + 0.4 * all.cos(), 0.5 * two.sin() + 0.4 * all.sin()]
    };
    for (coupled, k) in [(" (controller)", -30.0), ("", -31.0)] {
        for text in [arm(coupled, ", offset: 1", ""), arm(coupled, "", &effect)] {
            let (found, expected) = (tool(&text), at(k));
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-9), "{text}{found:?} {expected:?}");
        }
        assert!(columns_agree(&model_of(&arm(coupled, ", offset: 1", "")), &[0.5, -0.2]));
    }
}

/// With rods an error of joint 2 turns joint k back as well, which is another angle of `q2`; where the controller couples them the link beyond
/// turns with joint 2, which is another angle of `q3` in addition.
#[test]
fn errors_pass_on_by_mechanisms_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let error = 1e-4_f64;
    let effect = format!(
        "effects: [{{effect: transmission-error, site: 'joint:2', parameters: {{cos: {error}, sin: 0, order: 1}}}}]"
    );
    std::fs::write(at.join("plain.yaml"), LEVEL).expect("written");
    let left = |campaign: &str| {
        let ran = run(at, &["residuals", "plain.yaml", campaign, "--format", "json"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let json: Value = serde_json::from_str(&ran.out).expect("JSON");
        json["all"]["rms"].as_f64().expect("a number")
    };
    let controller = LEVEL.replace("* 2]", "* 2 (controller)]");
    for (name, text, passes_on) in [("rods", LEVEL, true), ("sum", controller.as_str(), false)] {
        std::fs::write(at.join("arm.yaml"), text.replace("effects: []", &effect)).expect("written");
        let simulate = ["simulate", "arm.yaml", "--poses", "30", "--noise", "0", "--errors", "0", "--into", name];
        let made = run(at, &simulate);
        assert_eq!(made.status, 0, "{}", made.err);
        assert!(left(name) > 1e-2, "{} mm", left(name));
        // The joints at which an arm without the error would be where this one is.
        let file = at.join(name).join("measurements.csv");
        let mut reader = csv::Reader::from_path(&file).expect("a file");
        let header = reader.headers().expect("a header").clone();
        let column = |name: &str| header.iter().position(|known| known == name).expect("a column");
        let (two, three) = (column("q2"), column("q3"));
        let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
        let mut writer = csv::Writer::from_path(&file).expect("a file");
        writer.write_record(&header).expect("written");
        for row in rows {
            let value = |k: usize| row[k].parse::<f64>().expect("a number");
            let by = (error * value(two).to_radians().cos()).to_degrees();
            let moved = row.iter().enumerate().map(|(k, text)| match k {
                k if k == two || k == three && !passes_on => format!("{:.12}", value(k) + by),
                _ => text.to_owned(),
            });
            writer.write_record(moved).expect("written");
        }
        writer.flush().expect("written");
        // The error counts to first order: its square is 1e-8 rad over 2 m.
        assert!(left(name) < 1e-4, "{name}: {} mm", left(name));
    }
    // A joint without a gear of its own has no error.
    let at_k = controller.replace("effects: []", &effect.replace("joint:2", "joint:k"));
    let wrong = LEVEL.replace("* 2]", "* 2 (robot)]");
    for (text, said) in [(at_k, "cannot sit at `joint:k`"), (wrong, "(controller)")] {
        std::fs::write(at.join("arm.yaml"), text).expect("written");
        let ran = run(at, &["check", "arm.yaml"]);
        assert!(ran.status != 0 && ran.err.contains(said), "{}", ran.err);
    }
}
