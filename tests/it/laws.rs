//! Laws of the catalogue that depend on time, path, cables, encoders, beams and reflectors: simulated, and found by their
//! names or as one of a small group.

use std::sync::Arc;

use elastogeo::blind::without;
use elastogeo::description::campaign::{Campaign, Conditions};
use elastogeo::description::raw::{RawAmount, RawEffect};
use elastogeo::diagnosis::Level;
use elastogeo::effects::{
    Catalogue, Change, Changes, Effect, EffectParameter, Nonlinear, NonlinearValue, ReadingContext, Site, SiteKind,
};
use elastogeo::files::{Reader, load_robot};
use elastogeo::kinematics::Geometry;
use elastogeo::model::Model;
use elastogeo::observation::{DEFLECTION, POSITION};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, measure, simulate};
use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;

use super::cli::run;
use super::support::{KR270_MASSES, diagnosed, heavy_kr270, switch_on};

const SIGMA: f64 = 3e-5;

/// Effect, site, amounts.
type Case<'a> = (&'a str, &'a str, Vec<(&'a str, RawAmount)>);

/// A KR-270 with gear ratios, and with an effect.
pub fn arm(effect: &str, site: &str, parameters: &[(&str, RawAmount)]) -> (Model, Model) {
    let mut plain = load_robot("kuka-kr270").expect("bundled").model;
    plain.variables.iter_mut().for_each(|variable| variable.gear_ratio = Some(93.7));
    let parameters = parameters.iter().map(|(name, value)| ((*name).to_string(), value.clone())).collect();
    let raw = RawEffect { effect: Some(effect.into()), site: Some(site.into()), parameters, ..RawEffect::default() };
    let mut spoiled = plain.clone();
    spoiled.switch_on(plain.resolve_effect(&raw).unwrap_or_else(|fault| panic!("{effect}: {fault:?}")));
    (plain, spoiled)
}

/// Readings of an arm with errors, and an effect.
fn read(plain: &Model, spoiled: &Model, spread: f64) -> Campaign {
    read_at(120, plain, spoiled, spread)
}

/// The same in so many configurations.
pub fn read_at(count: usize, plain: &Model, spoiled: &Model, spread: f64) -> Campaign {
    let mut random = generator(11);
    let truth = spoiled.completed(&draw_errors(plain, 0.3, 0.0, &mut random));
    let geometry = Geometry::new(plain, &truth).expect("assembled");
    let plan = Plan {
        conditions: true,
        configurations: draw_configurations(&geometry, count, spread, &mut random).expect("drawn"),
        markers: (0..plain.markers.len()).map(Some).collect(),
        repeats: 1,
        wrenches: Vec::new(),
        observes: POSITION,
        sigma: SIGMA,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let mut campaign = simulate(spoiled, &truth, &plan, &mut random).expect("simulated");
    campaign.number_in_order();
    measure(spoiled, &truth, campaign, [SIGMA, 0.0], &mut random).expect("measured")
}

#[test]
fn laws_are_named_or_in_a_small_group() {
    let number = |value: f64| RawAmount::from(value);
    let word = |word: &str| RawAmount::from(word);
    let cases: Vec<Case> = vec![
        ("hysteresis", "joint:2", vec![("half_width", number(3e-4)), ("distance", number(0.3))]),
        ("joint-slip", "joint:3", vec![("offset", number(3e-4)), ("slip_at", number(4400.0))]),
        ("tool-slip", "tool", vec![("x", number(3e-4)), ("y", number(-2e-4)), ("slip_at", number(4400.0))]),
        ("cable-torque", "joint:5", vec![("pull", number(1e-3)), ("slack", number(0.6)), ("middle", number(0.0))]),
        (
            "encoder-quantisation",
            "joint:2",
            vec![("share", number(1.0)), ("step", number(std::f64::consts::TAU / 4096.0))],
        ),
        ("motor-eccentricity", "joint:1", vec![("cos", number(2e-4)), ("sin", number(1e-4)), ("order", number(93.7))]),
        ("link-warm-up", "link:2", vec![("growth", number(3e-4)), ("time_constant", number(1200.0))]),
        (
            "base-warm-up",
            "base",
            vec![
                ("z", number(3e-4)),
                ("rx", number(1e-4)),
                ("course", word("logarithmic")),
                ("time_constant", number(500.0)),
            ],
        ),
        (
            "thermal-expansion",
            "link:2",
            vec![("expansion", number(4e-5)), ("course", word("delayed")), ("time_constant", number(2500.0))],
        ),
        ("tool-warm-up", "tool", vec![("z", number(4e-4)), ("time_constant", number(1500.0))]),
        ("refraction", "instrument", vec![("curvature", number(5e-5))]),
        (
            "instrument-encoder",
            "instrument",
            vec![("cos", number(3e-5)), ("sin", number(5e-5)), ("angle", word("azimuth")), ("periods", number(2.0))],
        ),
        (
            "instrument-encoder",
            "instrument",
            vec![("cos", number(5e-5)), ("sin", number(3e-5)), ("angle", word("elevation")), ("periods", number(4.0))],
        ),
        ("incidence", "instrument", vec![("amount", number(4e-4)), ("axis", word("z"))]),
    ];
    let wrong: Vec<String> = cases
        .par_iter()
        .filter_map(|(effect, site, parameters)| {
            let (plain, spoiled) = arm(effect, site, parameters);
            let found = diagnosed(&plain, &read(&plain, &spoiled, 0.7));
            let said: Vec<String> = found
                .causes
                .iter()
                .map(|cause| {
                    let tied: Vec<String> = cause.rivals.iter().map(|e| format!("{}@{}", e.effect, e.site)).collect();
                    format!(
                        "{}@{} {:?} {:?} {:?} tied {tied:?}",
                        cause.effect, cause.site, cause.level, cause.stability, cause.support
                    )
                })
                .collect();
            println!("{effect}@{site}: {said:?}");
            // Readings between the true time and the nearest that is tried are outliers to the law.
            let causes: Vec<_> = found.causes.iter().filter(|cause| cause.effect != "outliers").collect();
            let first = causes.first();
            let is_named = first.is_some_and(|cause| {
                let itself = (cause.effect.as_str(), cause.site.as_str()) == (effect, site);
                let tied = cause.rivals.iter().any(|e| (e.effect.as_str(), e.site.as_str()) == (effect, site));
                cause.level == Level::Law && (itself || tied) && cause.rivals.len() <= 2
            });
            (!is_named || causes.len() > 1).then(|| format!("{effect}@{site}: {said:?}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// At an end of its parameter a law shows what another effect does: where the catalogue lacks that one, the law is not named for it.
#[test]
fn a_law_in_the_limit_of_another_is_not_named() {
    let drift = vec![("x", RawAmount::from(6e-9))];
    let cases: Vec<(Case, &str)> = vec![
        (("settling", "joint:2", vec![("share", RawAmount::from(1e-4))]), "hysteresis"),
        (("frame-drift", "base", drift), "base-warm-up"),
    ];
    for ((effect, site, parameters), other) in cases {
        let (plain, spoiled) = arm(effect, site, &parameters);
        let campaign = read(&plain, &spoiled, 0.7);
        let lacking = without(&plain, &campaign, effect).expect("a catalogue without it");
        let found = diagnosed(&lacking, &campaign);
        let said: Vec<String> =
            found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
        assert!(found.causes.iter().all(|cause| cause.effect != other), "{effect}: {said:?}");
        assert!(found.causes.iter().any(|cause| cause.site == site && cause.level != Level::Law), "{effect}: {said:?}");
    }
}

/// The time of a jump lies between the two configurations where it happened: any other makes sound readings outliers.
#[test]
fn a_jump_of_the_base_is_found_between_two_configurations() {
    let jump = |at: f64| {
        let number = |value: f64| RawAmount::from(value);
        let amounts =
            [("x", number(3e-4)), ("y", number(2e-4)), ("course", RawAmount::from("jump")), ("jump_at", number(at))];
        let (plain, spoiled) = arm("frame-drift", "base", &amounts);
        let campaign = read_at(50, &plain, &spoiled, 0.7);
        (plain, campaign)
    };
    let mut times = jump(0.0).1.conditions.time.expect("times");
    times.sort_by(f64::total_cmp);
    times.dedup();
    for after in [17, 31] {
        let [before, after] = [times[after - 1], times[after]];
        let (plain, campaign) = jump(0.5 * (before + after));
        let found = diagnosed(&plain, &campaign);
        let said: Vec<_> = found.causes.iter().map(|cause| (cause.effect.as_str(), &cause.entries)).collect();
        let [cause] = &found.causes[..] else { panic!("{said:?}") };
        let at = match cause.entries.first().map(|entry| entry.nonlinear.values()).as_deref() {
            Some([_, NonlinearValue::Real(at)]) => *at,
            _ => panic!("{said:?}"),
        };
        assert!(cause.effect == "frame-drift" && before < at && at <= after, "{said:?}: {before} to {after}");
    }
}

/// What the tool does with time in its own axes is no motion of the base, and what the base does none of the tool: free curves of both, neither
/// of which has a law.
#[test]
fn a_curve_in_time_stands_at_the_body_that_moves() {
    let numbers = |values: &[f64]| RawAmount::Numbers(values.to_vec());
    let (times, zigzag) = (numbers(&[0.0, 2000.0, 4000.0, 6000.0]), [4e-4, -3e-4, 5e-4, -4e-4]);
    let amounts = |symbol: &str| (1..=4).map(|k| format!("{symbol}{k}")).collect::<Vec<_>>();
    for site in ["tool", "base"] {
        let (along, across) = (amounts("x"), amounts("y"));
        let mut parameters = vec![("follows", RawAmount::from("time")), ("at", times.clone())];
        parameters.extend(along.iter().zip(zigzag).map(|(name, value)| (name.as_str(), RawAmount::from(value))));
        parameters
            .extend(across.iter().zip(zigzag).map(|(name, value)| (name.as_str(), RawAmount::from(-0.6 * value))));
        let (plain, spoiled) = arm("free-form", site, &parameters);
        let found = diagnosed(&plain, &read_at(60, &plain, &spoiled, 0.7));
        let said: Vec<String> =
            found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
        let [cause] = &found.causes[..] else { panic!("{site}: {said:?}") };
        assert!(cause.effect == "free-form" && cause.site == site && cause.level == Level::Site, "{site}: {said:?}");
        // Its curves by component: what was put in along x is 0.6 times as much, the other way, along y.
        let [x, y] = ["x", "y"].map(|component| &cause.curves[component]);
        assert!(x.is_certain() && x.amount_unit == "m" && cause.curve.is_none(), "{x:?}");
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let ratio = product(&x.amount, &y.amount) / product(&x.amount, &x.amount);
        assert!((ratio + 0.6).abs() < 0.15, "{site}: {ratio}");
    }
}

/// A base that walks with time as it likes: most of it may lie along a straight line, and is no drift.
#[test]
fn a_walk_of_the_base_is_no_drift() {
    // Up by 0.6 mm, and to and fro by 0.15 mm every 16 minutes: quicker than a curve with few knots follows.
    let amounts: Vec<f64> =
        (0..=20_i32).map(|k| 3e-5 * f64::from(k) + 1.6e-4 * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let times = (0..amounts.len()).map(|k| 480.0 * k as f64).collect();
    let names: Vec<String> = (1..=amounts.len()).map(|k| format!("x{k}")).collect();
    let mut parameters = vec![("follows", RawAmount::from("time")), ("at", RawAmount::Numbers(times))];
    parameters.extend(names.iter().zip(&amounts).map(|(name, value)| (name.as_str(), RawAmount::from(*value))));
    let (plain, spoiled) = arm("free-form", "base", &parameters);
    let found = diagnosed(&plain, &read(&plain, &spoiled, 0.7));
    let said: Vec<String> =
        found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
    assert!(said.iter().all(|cause| !cause.contains("Law")), "{said:?}");
}

/// The causes found of a UR5 with effects, by the robot without them: base and tool unknown, so many configurations, noise in mm.
pub fn causes_of_ur5(effects: &str, poses: &str, noise: &str) -> Vec<serde_json::Value> {
    causes_of_ur5_with(effects, poses, noise, &[])
}

/// The same with more options of `simulate`.
pub fn causes_of_ur5_with(effects: &str, poses: &str, noise: &str, more: &[&str]) -> Vec<serde_json::Value> {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let ok = |arguments: &[&str]| assert_eq!(run(at, arguments).status, 0, "{arguments:?}");
    ok(&["convert", "universal-ur5", "plain.yaml"]);
    let plain = std::fs::read_to_string(at.join("plain.yaml")).expect("read");
    std::fs::write(at.join("arm.yaml"), format!("{plain}effects:\n{effects}")).expect("written");
    let unknown = ["--errors", "0", "--unknown-base", "--unknown-tool", "--seed", "4"];
    ok(&[&["simulate", "arm.yaml", "--poses", poses, "--noise", noise, "--into", "c"][..], &unknown, more].concat());
    let ran = run(at, &["diagnose", "c", "--robot", "plain.yaml", "--format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    found["causes"].as_array().expect("a list").clone()
}

/// A joint's error that repeats several times a turn as a saw does: the swing of its period takes most of it, and is another shape. Nor is what
/// that leaves, of twice the order, a swing.
#[test]
fn a_saw_is_no_swing() {
    for order in [3.0, 6.0] {
        let harmonic = |k: i32| {
            let [order, sine] = [order * f64::from(k), 2e-4 / f64::from(k)];
            format!("- {{effect: transmission-error, site: joint:3, parameters: {{order: {order}, sin: {sine}}}}}\n")
        };
        let saw: String = (1..=8).map(harmonic).collect();
        let causes = causes_of_ur5(&saw, "100", "0.02");
        assert!(causes.iter().all(|cause| cause["level"] != "law"), "{order}: {causes:?}");
    }
}

/// A swing with another error that goes with the same angle: of any shape, and no swing.
#[test]
fn a_law_beside_a_curve_of_its_own_is_not_named() {
    let swing = "{effect: transmission-error, site: joint:3, parameters: {order: 1, cos: 0.001, sin: 0.0004}}";
    let knots = "follows: q3, at: [-2.6, -1.3, 0, 1.3, 2.6], k1: 2e-4, k2: -2e-4, k3: 2e-4, k4: -2e-4, k5: 2e-4";
    let both = format!("- {swing}\n- {{effect: free-form, site: joint:3, parameters: {{{knots}}}}}\n");
    let causes = causes_of_ur5(&both, "80", "0.03");
    let said: Vec<_> = causes.iter().map(|cause| ["effect", "site", "follows"].map(|key| cause[key].clone())).collect();
    assert_eq!(said, [["free-form", "joint:3", "q3"].map(serde_json::Value::from)], "{causes:?}");
}

/// Asserts that a curve of the first joint of a UR5 is known as a curve there and by no law.
fn assert_a_curve_alone(knots: &str, poses: &str, noise: &str) {
    let effect = format!("- {{effect: free-form, site: joint:1, parameters: {{follows: q1, {knots}}}}}\n");
    let causes = causes_of_ur5(&effect, poses, noise);
    let said: Vec<_> = causes.iter().map(|cause| ["effect", "site"].map(|key| cause[key].clone())).collect();
    assert_eq!(said, [["free-form", "joint:1"].map(serde_json::Value::from)], "{causes:?}");
}

/// A joint's error that goes smoothly from one value to another in the middle of its range: a gear ratio and a swing take most of it
/// together, and once the swing gives way to a curve the gear ratio does so too.
#[test]
fn a_smooth_step_is_no_gear_ratio() {
    let knots = "at: [-6, -0.2, 0, 0.2, 6], k1: -3e-4, k2: -3e-4, k3: 0, k4: 3e-4, k5: 3e-4";
    assert_a_curve_alone(knots, "60", "0.01");
}

/// A joint that runs true over half of its range and errs in proportion beyond: a gear ratio takes most of that, and is another shape.
#[test]
fn a_ramp_over_half_the_range_is_no_gear_ratio() {
    assert_a_curve_alone("at: [-6.2, 0.9, 1.1, 6.2], k1: 0, k2: 0, k3: 1.5e-5, k4: 7.8e-4", "40", "0.03");
}

/// A lag with another error that the same last move causes: a curve at the joint could do all that the law does, and is fitted to what that
/// leaves.
#[test]
fn a_law_keeps_its_amount_beside_a_curve_at_its_site() {
    let share = 8e-4;
    let (plain, mut spoiled) = arm("settling", "joint:4", &[("share", RawAmount::from(share))]);
    let numbers = |values: &[f64]| RawAmount::Numbers(values.to_vec());
    let amounts = [1.5e-4, -1.5e-4, 1.5e-4, -1.5e-4, 1.5e-4].map(RawAmount::from);
    let names = ["k1", "k2", "k3", "k4", "k5"].map(String::from);
    let knots = [("follows", RawAmount::from("move.q4")), ("at", numbers(&[-6.0, -3.0, 0.0, 3.0, 6.0]))];
    let parameters =
        knots.map(|(name, value)| (name.to_string(), value)).into_iter().chain(names.into_iter().zip(amounts));
    let raw = RawEffect {
        effect: Some("free-form".into()),
        site: Some("joint:4".into()),
        parameters: parameters.collect(),
        ..RawEffect::default()
    };
    spoiled.switch_on(plain.resolve_effect(&raw).expect("an effect"));
    let found = diagnosed(&plain, &read(&plain, &spoiled, 0.7));
    let said: Vec<String> = found.causes.iter().map(|cause| format!("{}@{}", cause.effect, cause.site)).collect();
    assert_eq!(said, ["settling@joint:4", "free-form@joint:4"]);
    let value = found.causes[0].parameters[0].value.clone();
    let RawAmount::Number(value) = value else { panic!("{value:?}") };
    assert!((value - share).abs() < 0.1 * share, "{value}");
}

/// What one marker alone does, the robot does not: its mount slipped. It is named, and no slip of the tool or of a joint. Without times
/// no law can be, and readings that share one displacement from one row on are no outliers.
#[test]
fn a_marker_that_slips_is_named_at_the_marker() {
    let number = |value: f64| RawAmount::from(value);
    let slip = [("x", number(3e-4)), ("y", number(-2e-4)), ("slip_at", number(4400.0))];
    let marker = load_robot("kuka-kr270").expect("bundled").model.markers[1].name.clone();
    let site = format!("marker:{marker}");
    let (plain, spoiled) = arm("marker-slip", &site, &slip);
    let mut slipped = read(&plain, &spoiled, 0.7);
    let found = diagnosed(&plain, &slipped);
    let said: Vec<String> = found.causes.iter().map(|cause| format!("{}@{}", cause.effect, cause.site)).collect();
    assert_eq!(said.first(), Some(&format!("marker-slip@{site}")), "{said:?}");
    let amount = |k: usize| match found.causes[0].parameters[k].value {
        RawAmount::Number(value) => value,
        ref other => panic!("{other:?}"),
    };
    assert!((amount(0) - 3e-4).abs() < 3e-5 && (amount(1) + 2e-4).abs() < 3e-5, "{} {}", amount(0), amount(1));
    // It is of that day. Readings between its time and the nearest tried are outliers to the law, and no others are.
    assert!(found.causes[0].entries[0].effect.is_of_the_measurement(&found.causes[0].entries[0].site));
    assert!(found.outliers.len() <= 2, "{:?}", found.outliers);
    // Early, so that it is the readings before that are the fewer.
    let early = [("z", number(4e-4)), ("slip_at", number(1500.0))];
    let (_, spoiled) = arm("marker-slip", &site, &early);
    slipped = read(&plain, &spoiled, 0.7);
    (slipped.conditions.time, slipped.conditions.session_time) = (None, None);
    let found = diagnosed(&plain, &slipped);
    let said: Vec<String> = found.causes.iter().map(|cause| format!("{}@{}", cause.effect, cause.site)).collect();
    assert!(found.gap.is_significant && said.iter().all(|cause| !cause.starts_with("outliers")), "{said:?}");
    assert!(found.outliers.is_empty(), "{:?}", found.outliers);
}

/// A joint that stands elsewhere beyond some angle: no sine is that, nor a series of them, and none is named.
#[test]
fn a_step_in_the_angle_of_a_joint_is_no_transmission_error() {
    let slip = [("offset", RawAmount::from(3e-4)), ("slip_at", RawAmount::from(0.0))];
    let (plain, beyond) = arm("joint-slip", "joint:3", &slip);
    let (mut mixed, other) = (read(&plain, &plain, 0.7), read(&plain, &beyond, 0.7));
    let middle = 0.5 * plain.variables[2].limits.expect("limits").iter().sum::<f64>();
    for index in 0..mixed.readings.len() {
        if mixed.configuration(index)[2] > middle + 0.2 {
            mixed.readings[index] = other.readings[index];
        }
    }
    let found = diagnosed(&plain, &mixed);
    let said: Vec<String> =
        found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
    assert!(found.causes.iter().all(|cause| cause.level != Level::Law), "{said:?}");
    assert!(found.causes.first().is_some_and(|cause| cause.site == "joint:3"), "{said:?}");
}

/// A cable that bends a joint by the angles of two joints together: what free errors at that joint take up is named at no other.
#[test]
fn an_error_of_two_angles_is_named_at_no_other_joint() {
    struct Cable;
    impl Effect for Cable {
        fn name(&self) -> &'static str {
            "cable-of-two"
        }
        fn sits_at(&self) -> SiteKind {
            SiteKind::Joint
        }
        fn signature(&self) -> &'static str {
            ""
        }
        fn remedy(&self) -> &'static str {
            ""
        }
        fn parameters(&self, _: &Model, _: &Site, _: &Nonlinear) -> Vec<EffectParameter> {
            vec![EffectParameter::new("pull", "rad", 1e-4)]
        }
        fn changes(&self, _: &Model, site: &Site, _: &Nonlinear) -> Changes {
            let own = site.coordinate.expect("a driven joint");
            Arc::new(move |context, out| {
                let beyond = (context.q[3].abs() - 1.2).max(0.0);
                out.push((0, Change::Deflection(own, beyond * context.q[2].sin())));
            })
        }
    }
    let plain = load_robot("kuka-kr270").expect("bundled").model;
    let mut spoiled = Model { catalogue: Arc::new(Catalogue::standard().with(Cable)), ..plain.clone() };
    super::support::switch_on(&mut spoiled, "cable-of-two", "joint:3", &[("pull", 5e-4)]);
    let mut said = Vec::new();
    for count in [50, 60, 70, 80, 90, 100, 110, 120] {
        let found = diagnosed(&plain, &read_at(count, &plain, &spoiled, 0.7));
        let named = found.causes.iter().filter(|cause| cause.level == Level::Law && cause.site != "joint:3");
        said.extend(named.map(|cause| format!("{count}: {}@{}", cause.effect, cause.site)));
    }
    assert!(said.is_empty(), "{said:?}");
}

/// A joint that gives beyond some load only: the reverse of one that winds up, which is not named for it.
#[test]
fn a_dead_zone_is_no_joint_that_winds_up() {
    struct DeadZone;
    impl Effect for DeadZone {
        fn name(&self) -> &'static str {
            "dead-zone"
        }
        fn sits_at(&self) -> SiteKind {
            SiteKind::Joint
        }
        fn signature(&self) -> &'static str {
            ""
        }
        fn remedy(&self) -> &'static str {
            ""
        }
        fn parameters(&self, _: &Model, _: &Site, _: &Nonlinear) -> Vec<EffectParameter> {
            vec![EffectParameter::new("gives", "rad/(N.m)", 1e-7)]
        }
        fn changes(&self, _: &Model, site: &Site, _: &Nonlinear) -> Changes {
            let own = site.coordinate.expect("a driven joint");
            Arc::new(move |context, out| {
                let beyond = |load: f64| load - load.clamp(-900.0, 900.0);
                out.push((0, Change::Deflection(own, context.of_load(own, beyond))));
            })
        }
    }
    let plain = load_robot("kuka-kr270").expect("bundled").model;
    let mut spoiled = Model { catalogue: Arc::new(Catalogue::standard().with(DeadZone)), ..plain.clone() };
    super::support::switch_on(&mut spoiled, "dead-zone", "joint:3", &[("gives", 8e-7)]);
    let mut random = generator(4);
    let truth = spoiled.completed(&plain.registry.nominal());
    let geometry = Geometry::new(&plain, &truth).expect("assembled");
    let plan = Plan {
        conditions: false,
        configurations: draw_configurations(&geometry, 60, 0.8, &mut random).expect("drawn"),
        markers: (0..plain.markers.len()).map(Some).collect(),
        repeats: 1,
        wrenches: vec![[500.0, 0.0, -1500.0, 0.0, 0.0, 0.0], [0.0, 900.0, 800.0, 0.0, 0.0, 0.0]],
        observes: DEFLECTION,
        sigma: SIGMA,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    let campaign = simulate(&spoiled, &truth, &plan, &mut random).expect("simulated");
    let diagnosis = diagnosed(&plain, &campaign);
    let named: Vec<(&str, &str, Level)> =
        diagnosis.causes.iter().map(|cause| (cause.effect.as_str(), cause.site.as_str(), cause.level)).collect();
    assert!(!named.is_empty(), "something gives");
    assert!(named.iter().all(|(effect, ..)| *effect != "joint-stiffening"), "{named:?}");
    assert!(named.iter().any(|(_, site, _)| *site == "joint:3"), "{named:?}");
}

/// A joint whose friction holds the flank of the approach until the load overcomes it, as sharply as friction does: no compliance.
#[test]
fn lost_motion_that_the_load_overcomes_is_no_compliance() {
    const FRICTION: f64 = 900.0;
    struct LostMotion;
    impl Effect for LostMotion {
        fn name(&self) -> &'static str {
            "lost-motion"
        }
        fn sits_at(&self) -> SiteKind {
            SiteKind::Joint
        }
        fn signature(&self) -> &'static str {
            ""
        }
        fn remedy(&self) -> &'static str {
            ""
        }
        fn parameters(&self, _: &Model, _: &Site, _: &Nonlinear) -> Vec<EffectParameter> {
            vec![EffectParameter::new("half", "rad", 1e-4)]
        }
        fn changes(&self, _: &Model, site: &Site, _: &Nonlinear) -> Changes {
            let own = site.coordinate.expect("a driven joint");
            Arc::new(move |context, out| {
                let load = context.load[own];
                let flank = if load.abs() > FRICTION { load.signum() } else { context.side[own] };
                out.push((0, Change::Joint(own, flank)));
            })
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let plain = load_robot(&heavy_kr270(folder.path(), KR270_MASSES)).expect("a robot").model;
    let mut spoiled = Model { catalogue: Arc::new(Catalogue::standard().with(LostMotion)), ..plain.clone() };
    switch_on(&mut spoiled, "lost-motion", "joint:3", &[("half", 4e-4)]);
    let found = diagnosed(&plain, &read(&plain, &spoiled, 0.7));
    let said: Vec<String> =
        found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
    let [cause] = &found.causes[..] else { panic!("{said:?}") };
    assert_eq!(
        (cause.effect.as_str(), cause.site.as_str(), cause.level),
        ("backlash", "joint:3", Level::Law),
        "{said:?}"
    );
    assert_eq!(cause.family, elastogeo::effects::Family::History);
    let by = cause.parameters.iter().find(|own| own.name == "by").map(|own| own.value.clone());
    let at = cause.parameters.iter().find(|own| own.name == "overcome_at").and_then(|own| own.value.number());
    assert_eq!(by, Some(RawAmount::from("friction")));
    assert!(at.is_some_and(|at| (at / FRICTION - 1.0).abs() < 0.2), "{at:?}");
}

/// A lag that grows a little less than the move is that of a joint read before it has come to rest, though a curve comes nearer; one that hardly grows
/// with the move is another law.
#[test]
fn a_law_that_is_a_little_off_is_named() {
    type Shape = fn(f64) -> f64;
    struct Lag(Shape);
    impl Effect for Lag {
        fn name(&self) -> &'static str {
            "lag"
        }
        fn sits_at(&self) -> SiteKind {
            SiteKind::Joint
        }
        fn signature(&self) -> &'static str {
            ""
        }
        fn remedy(&self) -> &'static str {
            ""
        }
        fn parameters(&self, _: &Model, _: &Site, _: &Nonlinear) -> Vec<EffectParameter> {
            vec![EffectParameter::new("share", "1", 1e-3)]
        }
        fn changes(&self, _: &Model, site: &Site, _: &Nonlinear) -> Changes {
            let (own, law) = (site.coordinate.expect("a driven joint"), self.0);
            Arc::new(move |context, out| out.push((0, Change::Joint(own, law(context.last_move[own])))))
        }
    }
    let shapes: [(Shape, Level); 2] =
        [(|moved| moved / (1.0 + 0.1 * moved.abs()), Level::Law), (|moved| (3.0 * moved).tanh(), Level::Site)];
    for (shape, level) in shapes {
        let mut plain = load_robot("kuka-kr270").expect("bundled").model;
        plain.variables.iter_mut().for_each(|variable| variable.gear_ratio = Some(93.7));
        let mut spoiled = Model { catalogue: Arc::new(Catalogue::standard().with(Lag(shape))), ..plain.clone() };
        super::support::switch_on(&mut spoiled, "lag", "joint:4", &[("share", 1e-3)]);
        let found = diagnosed(&plain, &read(&plain, &spoiled, 0.7));
        let said: Vec<String> =
            found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
        let first = found.causes.first().unwrap_or_else(|| panic!("nothing is found"));
        assert!(first.site == "joint:4" && first.level == level, "{level:?}: {said:?}");
        assert!((level == Level::Law) == (first.effect == "settling"), "{level:?}: {said:?}");
    }
}

/// Friction keeps a joint behind: a positive half width is on the side from which it came.
#[test]
fn hysteresis_keeps_a_joint_on_the_side_from_which_it_came() {
    let half = 3e-4;
    let at_once = [("half_width", RawAmount::from(half)), ("distance", RawAmount::from(1e-9))];
    let of = |effect: &str, parameters: &[(&str, RawAmount)]| {
        let (plain, spoiled) = arm(effect, "joint:2", parameters);
        read(&plain, &spoiled, 0.7)
    };
    let slip = |offset: f64| [("offset", RawAmount::from(offset)), ("slip_at", RawAmount::from(0.0))];
    let shown = of("hysteresis", &at_once);
    let [below, above] = [-half, half].map(|offset| of("joint-slip", &slip(offset)));
    let mut sides = [0, 0];
    for (index, reading) in shown.readings.iter().enumerate() {
        let moved = shown.conditions.last_move[1][index];
        if moved.is_nan() || moved == 0.0 {
            continue;
        }
        let came_from_below = moved > 0.0;
        let expected = if came_from_below { &below } else { &above }.readings[index].measured;
        sides[usize::from(came_from_below)] += 1;
        assert!((0..3).all(|k| (reading.measured[k] - expected[k]).abs() < 1e-9), "{index}: moved {moved}");
    }
    assert!(sides.iter().all(|count| *count > 20), "{sides:?}");
}

/// Against the solution for a ramp and for a sine, in steps of different lengths.
#[test]
fn a_delayed_temperature_solves_its_equation() {
    let (delay, rate, omega) = (800.0, 2e-3, 1e-3);
    let times: Vec<f64> = (0..2000_u32).map(|k| f64::from(k) * 5.0 + f64::from(k % 3)).collect();
    let felt = |shown: &dyn Fn(f64) -> f64| {
        let temperature = Some(times.iter().map(|time| shown(*time)).collect());
        let conditions = Conditions { time: Some(times.clone()), temperature, ..Conditions::default() };
        conditions.delayed_temperatures("2", delay).expect("times and temperatures")
    };
    let ramp = felt(&|time| 20.0 + rate * time);
    let sine = felt(&|time| 20.0 + 5.0 * (omega * time).sin());
    let lag = omega * delay;
    for ((time, ramp), sine) in times.iter().zip(ramp).zip(sine) {
        let left = (-time / delay).exp();
        assert!((ramp - (20.0 + rate * (time - delay * (1.0 - left)))).abs() < 1e-9, "{time}: {ramp}");
        let angle = omega * time;
        let exact = 20.0 + 5.0 * (angle.sin() - lag * angle.cos() + lag * left) / (1.0 + lag * lag);
        assert!((sine - exact).abs() < 1e-4, "{time}: {sine} {exact}");
    }
}

/// A point at azimuth 30 deg and elevation 40 deg, 2 m away: what each angle that is read too great by one shows.
#[test]
fn angles_of_the_instrument_move_points_across_the_line_of_sight() {
    let (azimuth, elevation, distance) = (30f64.to_radians(), 40f64.to_radians(), 2.0);
    let at = |a: f64, e: f64| Vector3::new(a.cos() * e.cos(), a.sin() * e.cos(), e.sin()) * distance;
    let (plain, _) = arm("refraction", "instrument", &[("curvature", RawAmount::from(1e-4))]);
    let law = plain.catalogue.get("instrument-encoder").expect("of the catalogue");
    let site = law.sites(&plain).remove(0);
    let step = 1e-6;
    let context = ReadingContext {
        q: &[],
        joints: &[],
        load: &[],
        own_load: &[],
        side: &[],
        last_move: &[],
        earlier_moves: &[],
        time: None,
        session_time: None,
        order: None,
        temperature: None,
        marker: None,
        position: at(azimuth, elevation),
        base: Vector3::zeros(),
        body: Rotation3::identity(),
        up: Vector3::z(),
        carried: &[],
        deflection: Vector3::zeros(),
        is_difference: false,
    };
    for (name, angle, across) in [
        ("azimuth", azimuth, (at(azimuth + step, elevation) - at(azimuth - step, elevation)) / (2.0 * step)),
        ("elevation", elevation, (at(azimuth, elevation + step) - at(azimuth, elevation - step)) / (2.0 * step)),
    ] {
        for periods in [1.0, 2.0] {
            let stated = [("cos", 1e-5.into()), ("angle", RawAmount::from(name)), ("periods", periods.into())];
            let parameters = stated.map(|(name, value)| (name.to_string(), value)).into();
            let raw = RawEffect {
                effect: Some("instrument-encoder".into()),
                site: Some("instrument".into()),
                parameters,
                ..RawEffect::default()
            };
            let entry = plain.resolve_effect(&raw).expect("an effect");
            let mut shown = Vec::new();
            law.changes(&plain, &site, &entry.nonlinear)(&context, &mut shown);
            let expected = [(periods * angle).cos(), (periods * angle).sin()].map(|share| across * share);
            for ((_, change), expected) in shown.iter().zip(expected) {
                let Change::Point(moved, _) = change else { panic!("{change:?}") };
                assert!((moved - expected).norm() < 1e-9, "{name} {periods}: {moved} and {expected}");
            }
            assert_eq!(shown.len(), 2);
        }
    }
}

/// A joint that turns under the load of another one is in no catalogue, and two laws that cancel one another are no names for it.
#[test]
fn laws_that_cancel_one_another_are_not_named() {
    struct Crossed;
    impl Effect for Crossed {
        fn name(&self) -> &'static str {
            "crossed"
        }
        fn sits_at(&self) -> SiteKind {
            SiteKind::Joint
        }
        fn signature(&self) -> &'static str {
            ""
        }
        fn remedy(&self) -> &'static str {
            ""
        }
        fn parameters(&self, _: &Model, _: &Site, _: &Nonlinear) -> Vec<EffectParameter> {
            vec![EffectParameter::new("amount", "rad/(N.m)", 1e-7)]
        }
        fn changes(&self, _: &Model, site: &Site, _: &Nonlinear) -> Changes {
            let Some(own) = site.coordinate else { return Arc::new(|_, _| {}) };
            Arc::new(move |context, out| out.push((0, Change::Joint(own, context.own_load[own + 1]))))
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let heavy = heavy_kr270(folder.path(), KR270_MASSES);
    let plain = load_robot(&heavy).expect("a robot").model;
    let mut spoiled = Reader::new(Catalogue::standard().with(Crossed)).robot(&heavy).expect("a robot").model;
    switch_on(&mut spoiled, "crossed", "joint:2", &[("amount", 3e-7)]);
    let found = diagnosed(&plain, &read(&plain, &spoiled, 0.9));
    let said: Vec<String> =
        found.causes.iter().map(|cause| format!("{}@{} {:?}", cause.effect, cause.site, cause.level)).collect();
    println!("{said:?} {} {}", found.gap.rms, found.rms_after);
    assert!(found.gap.is_significant, "{}", found.gap.rms);
    assert!(found.causes.iter().all(|cause| cause.level != Level::Law), "{said:?}");
}

/// Without times, but in an order that is stated, what moves in the course of the campaign goes with the order, and not with a temperature
/// that rises a little meanwhile.
#[test]
fn what_moves_in_the_course_goes_with_the_order() {
    let (plain, spoiled) = arm("frame-drift", "base", &[("x", RawAmount::from(5e-8)), ("z", RawAmount::from(-8e-8))]);
    let mut campaign = read(&plain, &spoiled, 0.7);
    let count = campaign.readings.len() as f64;
    (campaign.conditions.time, campaign.conditions.session_time) = (None, None);
    campaign.conditions.temperature =
        Some(campaign.readings.iter().map(|reading| 20.0 + (reading.row as f64 / count * 9.0).sin()).collect());
    let found = diagnosed(&plain, &campaign);
    let follows: Vec<(&str, Option<&str>)> =
        found.causes.iter().map(|cause| (cause.site.as_str(), cause.follows.as_deref())).collect();
    assert_eq!(follows.first(), Some(&("base", Some("order"))), "{follows:?}");
}
