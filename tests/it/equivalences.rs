//! Springs that readings see as one, against sums known beforehand; and springs that they do not see.

use elastogeo::description::campaign::Campaign;
use elastogeo::estimation::{CHANGED, Calibration, Network, Settings, Split, Together, calibrate};
use elastogeo::model::Model;
use elastogeo::observation::DEFLECTION;
use elastogeo::render::identification::identification;
use elastogeo::render::table::Screen;
use elastogeo::results::Identification;
use elastogeo::simulation::{Plan, generator, simulate};

use crate::support::model_of;

/// A slide along z with a spring in its drive and another between the same two bodies; rates in N/mm.
fn slide(drive: &str, spring: &str) -> Model {
    model_of(&format!(
        "units: {{length: m, angle: rad, stiffness: N/mm}}
gravity: [0, 0, 0]
frames: {{1: {{antecedent: 0, joint: prismatic, variable: q1, limits: [0.1, 0.5]}}, E: {{antecedent: 1, d: 0.3}}}}
tool: {{frame: E}}
joint_stiffness: {{1: {{ka: {{{drive}}}}}}}
springs: {{s: {{bodies: [0, 1], anchors: [[0, 0, -1], [0, 0, 0]], rate: {{{spring}}}}}}}
"
    ))
}

const FORCES: [f64; 3] = [500.0, -300.0, 900.0];

fn deflections(model: &Model, truth: &[(&str, f64)], along: &[usize], sigma: f64) -> (Campaign, Vec<f64>) {
    let mut values = model.registry.nominal();
    for (name, value) in truth {
        values[model.registry.slot(name).expect("a parameter")] = *value;
    }
    let plan = Plan {
        conditions: false,
        configurations: (0..20).map(|k| vec![0.1 + 0.02 * f64::from(k)]).collect(),
        observes: DEFLECTION,
        markers: vec![None],
        repeats: 1,
        sigma,
        sigma_orientation: 0.0,
        estimate: [false, false],
        wrenches: along
            .iter()
            .flat_map(|&along| FORCES.map(|force| std::array::from_fn(|k| if k == along { force } else { 0.0 })))
            .collect(),
    };
    (simulate(model, &values, &plan, &mut generator(3)).expect("simulated"), values)
}

fn fitted(model: &Model, campaign: &Campaign, split: Split) -> Calibration {
    let held_out = vec![false; campaign.readings.len()];
    calibrate(model, campaign, &held_out, &Settings { split, ..Settings::default() }, &mut |_| {}).expect("calibrated")
}

#[test]
fn a_spring_parallel_to_a_drive_is_one_with_it() {
    let (ka, rate, sigma) = (520e3, 90e3, 2e-6);
    // Declared as either, and off by factors; the order of the columns decides which of the two is kept.
    for (drive, spring) in [
        ("value: 400, identifiable: true", "value: 100, identifiable: true"),
        ("compliance: 0.0004, identifiable: true", "compliance: 1, identifiable: true"),
        ("value: 4e6, identifiable: true", "value: 20, identifiable: true"),
    ] {
        let model = slide(drive, spring);
        let (campaign, _) = deflections(&model, &[("joint1.ka", 1.0 / ka), ("s.stiffness", rate)], &[2], sigma);
        let mean = |force: usize| {
            let of = campaign.readings.iter().skip(force).step_by(FORCES.len());
            of.map(|reading| reading.measured[2]).sum::<f64>() / 20.0
        };
        for (k, force) in FORCES.iter().enumerate() {
            assert!((mean(k) - force / (ka + rate)).abs() < 4.0 * sigma / 20.0_f64.sqrt(), "{} {force}", mean(k));
        }
        // The estimate of 1/K of y = F/K + noise, and its interval, in closed form.
        let forces = |reading: usize| FORCES[reading % FORCES.len()];
        let readings: Vec<f64> = campaign.readings.iter().map(|reading| reading.measured[2]).collect();
        let square: f64 = (0..readings.len()).map(|i| forces(i).powi(2)).sum();
        let sum = square / (0..readings.len()).map(|i| forces(i) * readings[i]).sum::<f64>();
        for split in [Split::Prior, Split::MinimumNorm] {
            let found = fitted(&model, &campaign, split);
            assert!(found.converged(), "{}", found.ending);
            let [group] = &found.equivalences[..] else { panic!("{:?}", found.equivalences) };
            assert_eq!(group.springs.together, Together::Parallel);
            assert_eq!(group.springs.members.len(), 2);
            assert!(
                group.springs.members.iter().all(|(_, weight)| (weight - 1.0).abs() < 1e-6),
                "{:?}",
                group.springs.members
            );
            assert!((group.value / sum - 1.0).abs() < 1e-6, "{} {sum}", group.value);
            assert!((group.value - ka - rate).abs() < group.ci95 * 1.5, "{} +- {}", group.value, group.ci95);
            let degrees = 3.0 * readings.len() as f64 - 1.0;
            let t = 1.959_964 + (1.959_964_f64.powi(3) + 1.959_964) / (4.0 * degrees);
            let half = t * found.noise_ratio * sigma * sum * sum / square.sqrt();
            // Of independent readings; what those of a configuration seem to share, here by chance, makes it a little wider.
            let allowed = found.shared.map_or(1e-3, |shared| {
                assert!(shared.p > 0.05, "{shared:?}");
                1e-2
            });
            assert!((group.ci95 / half - 1.0).abs() < allowed, "{} {half}", group.ci95);
            // Split back they add up to it again, and predict the same.
            let value = |name: &str| found.values[model.registry.slot(name).expect("a parameter")];
            assert!(((1.0 / value("joint1.ka") + value("s.stiffness")) / sum - 1.0).abs() < 1e-6);
            assert!((found.noise_ratio - 1.0).abs() < 0.3, "{}", found.noise_ratio);
            if split == Split::MinimumNorm {
                assert!((value("joint1.ka") * value("s.stiffness") - 1.0).abs() < 1e-6, "halves");
            }
            let result = Identification::new(&model, &campaign, &found, 0.0);
            let group = &result.equivalences[0];
            assert_eq!((group.kind, group.unit), (Together::Parallel, "N/m"), "{group:?}");
            assert!(identification(&result, Screen::default()).contains("side by side"));
        }
    }
}

#[test]
fn two_springs_between_the_same_points_are_one() {
    let model = model_of(
        "units: {length: m, angle: rad, stiffness: N/mm}
gravity: [0, 0, 0]
frames: {1: {antecedent: 0, joint: revolute, variable: q1, limits: [0.1, 0.5]}, E: {antecedent: 1, d: 0.8}}
tool: {frame: E}
joint_stiffness: {1: {kar: {value: 5e4}}}
springs:
  a: {bodies: [0, 1], anchors: [[0, -0.5, 0], [0.4, 0, 0]], rate: {value: 100, identifiable: true}}
  b: {bodies: [0, 1], anchors: [[0, -0.5, 0], [0.4, 0, 0]], rate: {value: 300, identifiable: true}}
",
    );
    let (campaign, _) = deflections(&model, &[("a.stiffness", 2.2e5), ("b.stiffness", 0.5e5)], &[1], 1e-6);
    let found = fitted(&model, &campaign, Split::Prior);
    let [group] = &found.equivalences[..] else { panic!("{:?}", found.equivalences) };
    assert_eq!(group.springs.together, Together::Parallel);
    assert!((group.value - 2.7e5).abs() < 1.5 * group.ci95 && group.ci95 < 2e3, "{} {}", group.value, group.ci95);
    let value = |name: &str| found.values[model.registry.slot(name).expect("a parameter")];
    assert!((value("b.stiffness") / value("a.stiffness") - 3.0).abs() < 1e-9, "in the description's proportion");
}

/// Two drives about one axis, whose bodies are pinned together: torsional stiffnesses add, both held as compliances.
#[test]
fn two_drives_of_one_axis_are_side_by_side() {
    let model = model_of(
        "units: {length: m, angle: rad}
gravity: [0, 0, 0]
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, limits: [0.1, 0.5]}
  2: {antecedent: 0, joint: revolute}
  3: {antecedent: 1, joint: revolute, passive: true, d: 0.5}
  4: {antecedent: 2, d: 0.5}
  E: {antecedent: 1, d: 0.9}
couplings: [\"2 = 1 * 1\"]
loops: {pinned: {frames: [3, 4], kind: spatial, gap: 1e-6}}
tool: {frame: E}
joint_stiffness:
  1: {kar: {value: 4e4, identifiable: true}}
  2: {kar: {value: 9e4, identifiable: true}}
",
    );
    let truth = [("joint1.kar", 1.0 / 3e4), ("joint2.kar", 1.0 / 7e4)];
    let (campaign, _) = deflections(&model, &truth, &[1], 1e-6);
    let found = fitted(&model, &campaign, Split::Prior);
    let [group] = &found.equivalences[..] else { panic!("{:?}", found.equivalences) };
    assert_eq!(group.springs.together, Together::Parallel, "{:?}", group.springs.members);
    assert!(group.springs.members.iter().all(|(_, weight)| (weight - 1.0).abs() < 1e-6), "{:?}", group.springs.members);
    assert!((group.value - 1e5).abs() < 1.5 * group.ci95 && group.ci95 < 2e3, "{} {}", group.value, group.ci95);
}

/// A spring in series is distinguished from one in parallel: twice the compliance leaves the ratio of the columns.
#[test]
fn springs_in_series_stay_in_series() {
    let model = model_of(
        "units: {length: m, angle: rad}
gravity: [0, 0, 0]
frames:
  1: {antecedent: 0, joint: prismatic, variable: q1, limits: [0.1, 0.5]}
  2: {antecedent: 1, joint: prismatic, variable: q2, limits: [0, 0.1]}
tool: {frame: 2}
joint_stiffness: {1: {ka: {value: 4e5, identifiable: true}}, 2: {ka: {value: 9e5, identifiable: true}}}
",
    );
    let mut values = model.registry.nominal();
    values[model.registry.slot("joint1.ka").expect("a spring")] = 1.0 / 3e5;
    let plan = Plan {
        conditions: false,
        configurations: (0..20).map(|k| vec![0.1 + 0.02 * f64::from(k), 0.05]).collect(),
        observes: DEFLECTION,
        markers: vec![None],
        repeats: 1,
        sigma: 1e-6,
        sigma_orientation: 0.0,
        estimate: [false, false],
        wrenches: vec![[0.0, 0.0, 500.0, 0.0, 0.0, 0.0]],
    };
    let campaign = simulate(&model, &values, &plan, &mut generator(3)).expect("simulated");
    let found = fitted(&model, &campaign, Split::Prior);
    let [group] = &found.equivalences[..] else { panic!("{:?}", found.equivalences) };
    assert_eq!(group.springs.together, Together::Series);
    assert!((group.value - 1.0 / 3e5 - 1.0 / 9e5).abs() < 1.5 * group.ci95, "{}", group.value);
}

#[test]
fn a_spring_that_moves_nothing_is_reported() {
    // 900 N on 3e13 N/m: 3e-8 mm, and 9 mm on the other.
    let text = "units: {length: m, angle: rad}
gravity: [0, 0, 0]
frames: {1: {antecedent: 0, joint: prismatic, variable: q1, limits: [0.1, 0.5]}, E: {antecedent: 1, d: 0.3}}
tool: {frame: E}
joint_stiffness: {1: {ka: {value: 1e5, identifiable: true}, kr: {value: 3e13, identifiable: true}}}
";
    let model = model_of(text);
    let (campaign, values) = deflections(&model, &[], &[2, 0], 1e-6);
    let found = fitted(&model, &campaign, Split::Prior);
    let result = Identification::new(&model, &campaign, &found, 0.0);
    let of = |name: &str| {
        let found = result.parameters.iter().find(|p| p.name == name);
        found.unwrap_or_else(|| panic!("{name}")).insensitive
    };
    assert_eq!((of("joint1.kr"), of("joint1.ka")), (Some(true), Some(false)));
    let said = identification(&result, Screen::default());
    let row =
        said.lines().find(|line| line.contains("joint1.kr") && line.contains("no reading by more than")).expect("told");
    // Noise alone puts its fit anywhere between rigid and what readings show: it is held as declared.
    assert!(row.contains("any value as stiff or stiffer fits"), "{row}");
    let slot = model.registry.slot("joint1.kr").expect("a spring");
    assert_eq!(found.values[slot], model.registry[slot].nominal);
    assert!(values[slot] < 1e-13);
}

/// Networks of which only parts taken by their springs are shown are found again: they predict the same at other values.
#[test]
fn networks_of_springs_are_found_by_what_their_members_take_part() {
    let spring = Network::Spring;
    let series = |parts: Vec<(f64, Network)>| Network::Group(Together::Series, parts);
    let parallel = |parts: Vec<(f64, Network)>| Network::Group(Together::Parallel, parts);
    for truth in [
        series(vec![(1.0, spring(0)), (1.0, parallel(vec![(1.0, spring(1)), (1.0, spring(2))]))]),
        parallel(vec![(1.0, spring(0)), (0.3, series(vec![(1.0, spring(1)), (2.25, spring(2)), (1.0, spring(3))]))]),
        series(vec![
            (1.0, spring(3)),
            (
                0.5,
                parallel(vec![
                    (1.0, spring(0)),
                    (1.0, series(vec![(1.0, spring(1)), (4.0, spring(4))])),
                    (2.0, spring(2)),
                ]),
            ),
            (1.0, parallel(vec![(1.0, spring(5)), (1.0, spring(6))])),
        ]),
    ] {
        let springs = truth.springs();
        let of = |slot: usize| 0.7 + 0.31 * slot as f64;
        let parts = |changed: &[usize]| -> Result<Vec<f64>, ()> {
            let of = |slot: usize| if changed.contains(&slot) { CHANGED * of(slot) } else { of(slot) };
            // Readings are known but for a factor.
            Ok(springs.iter().map(|&slot| -3.7 * truth.derivative(&of, slot)).collect())
        };
        let found = Network::of(&springs, &of, parts).expect("parts").expect("a network");
        assert!(found.is_nested() && found.springs().len() == springs.len());
        let factor = found.compliance(&of) / truth.compliance(&of);
        for seed in 1..5 {
            let other = |slot: usize| 0.1 + ((slot * 7 + seed * 13) % 11) as f64;
            assert!((found.compliance(&other) / truth.compliance(&other) / factor - 1.0).abs() < 1e-12, "{found:?}");
        }
    }
    // A bridge is no such network: the part that a spring takes changes with each other one in its own way.
    let bridge = |changed: &[usize]| -> Result<Vec<f64>, ()> {
        Ok((0..5)
            .map(|slot| (1.0 + slot as f64) * 1.1_f64.powi(changed.iter().map(|k| (k * slot) as i32).sum()))
            .collect())
    };
    assert_eq!(Network::of(&[0, 1, 2, 3, 4], &|_| 1.0, bridge), Ok(None));
}

/// A slide whose drive has a spring beside it, on a pedestal that gives: series of which one part is itself parallel.
#[test]
fn a_parallel_group_in_series_is_merged_as_a_whole() {
    let model = model_of(
        "units: {length: m, angle: rad, stiffness: N/mm}
gravity: [0, 0, 0]
frames: {1: {antecedent: 0, joint: prismatic, variable: q1, limits: [0.1, 0.5]}, E: {antecedent: 1, d: 0.3}}
tool: {frame: E}
base_stiffness: {kz: {value: 900, identifiable: true}}
joint_stiffness: {1: {ka: {value: 400, identifiable: true}}}
springs: {s: {bodies: [0, 1], anchors: [[0, 0, -1], [0, 0, 0]], rate: {value: 100, identifiable: true}}}
",
    );
    let (kz, ka, rate) = (700e3, 520e3, 90e3);
    let truth = [("base.kz", 1.0 / kz), ("joint1.ka", 1.0 / ka), ("s.stiffness", rate)];
    let (campaign, _) = deflections(&model, &truth, &[2], 1e-7);
    for split in [Split::Prior, Split::MinimumNorm] {
        let found = fitted(&model, &campaign, split);
        assert!(found.converged(), "{}", found.ending);
        let [group] = &found.equivalences[..] else { panic!("{:?}", found.equivalences) };
        let condensed = 1.0 / (1.0 / kz + 1.0 / (ka + rate));
        assert!((group.value * condensed - 1.0).abs() < 1.5 * group.ci95 * condensed, "{} {condensed}", group.value);
        assert!(group.ci95 > 0.0 && group.ci95 * condensed < 1e-3, "{}", group.ci95);
        // Split back, the members predict what the equivalent does.
        let value = |name: &str| found.values[model.registry.slot(name).expect("a parameter")];
        let members = value("base.kz") + 1.0 / (1.0 / value("joint1.ka") + value("s.stiffness"));
        assert!(
            (members / group.value - 1.0).abs() < 1e-9 && (value("joint1.ka") / value("base.kz") - 2.25).abs() < 1e-6
        );
        assert!((found.noise_ratio - 1.0).abs() < 0.3, "{}", found.noise_ratio);
        let result = Identification::new(&model, &campaign, &found, 0.0);
        let shown = &result.equivalences[0];
        let inner = ["joint1.ka + s.stiffness", "s.stiffness + joint1.ka"].map(|sum| format!("1/({sum})"));
        assert!(
            shown.formula.contains("1/base.kz") && inner.iter().any(|sum| shown.formula.contains(sum)),
            "{}",
            shown.formula
        );
        assert!(
            (shown.equivalent / condensed - 1.0).abs() < 1e-3 && shown.unit == "N/m" && shown.kind == Together::Series
        );
        let text = identification(&result, Screen::default());
        assert!(text.contains(&shown.formula), "{text}");
    }
}
