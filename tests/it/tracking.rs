//! Robots over time: simulated histories with a withheld event, and the command on files.

use elastogeo::description::campaign::Campaign;
use elastogeo::estimation;
use elastogeo::identifiability::Criterion;
use elastogeo::kinematics::Geometry;
use elastogeo::model::Model;
use elastogeo::observation::POSITION;
use elastogeo::parameter::{Group, Kind, Slot};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use elastogeo::tracking::{Calibrated, History, Measured, Settings, Shape, TrackingError, calibrated, monitor};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::cli::{PLANAR, run};
use crate::figures::recorded;

/// What is withheld.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Withheld {
    Nothing,
    /// The base is put down anew at one check.
    Clamped,
    /// The zero of a joint jumps by three deviations of its own estimate.
    Step,
    /// A length grows steadily, by three deviations of its own estimate within six checks at most.
    Drift,
}

/// A history of monthly checks.
struct Told {
    /// Check at which the change is there, and with a drift the one at which it has reached three deviations.
    at: [usize; 2],
    alarms: Vec<usize>,
    /// Whether a change is told after the first, one jump that turns out to be part of growth not counted.
    again: bool,
    /// Whether the first alarm names the parameter, alone or as one of those that it cannot be told from.
    named: bool,
    as_line: bool,
    /// Check at which the base is said to have moved.
    moved: Vec<usize>,
}

const CHECKS: usize = 12;

fn normal(random: &mut ChaCha8Rng) -> f64 {
    // Of twelve uniform ones: near enough for where a base is put.
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

fn campaign(model: &Model, values: &[f64], poses: usize, random: &mut ChaCha8Rng) -> Campaign {
    let geometry = Geometry::new(model, values).expect("assembled");
    let plan = Plan {
        configurations: draw_configurations(&geometry, poses, 0.8, random).expect("drawn"),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        conditions: false,
        observes: POSITION,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    simulate(model, values, &plan, random).expect("simulated")
}

/// `None` where a calibration does not converge: the command refuses such a history.
fn tracked(model: &Model, campaigns: &[Campaign]) -> Option<(Calibrated, History)> {
    let measured: Vec<Measured> = campaigns
        .iter()
        .enumerate()
        .map(|(k, campaign)| Measured {
            name: format!("check {}", k + 1),
            time: k as f64,
            model,
            campaign,
            held_out: vec![false; campaign.readings.len()],
        })
        .collect();
    let all = calibrated(&measured, None, &estimation::Settings::default(), &mut |_| {});
    let all = match all {
        Err(TrackingError::NotConverged { .. }) => return None,
        all => all.expect("calibrated"),
    };
    let history = monitor(&all.checks, &Settings::default()).expect("compared");
    Some((all, history))
}

/// The zero of a joint, or a length, with the standard deviation of its estimate from one campaign.
fn withheld(model: &Model, own: &Campaign, kind: Withheld, random: &mut ChaCha8Rng) -> (Slot, f64) {
    // Of what is compared.
    let criterion = Criterion::Noise;
    let settings = estimation::Settings { second_order: false, criterion, ..estimation::Settings::default() };
    let held_out = vec![false; own.readings.len()];
    let found = estimation::calibrate(model, own, &held_out, &settings, &mut |_| {}).expect("calibrated");
    let is_zero = |slot: Slot| model.frames.iter().any(|frame| frame.moves() && frame.moving_slot() == slot);
    let wanted = |slot: Slot| match kind {
        Withheld::Step => is_zero(slot),
        _ => model.registry[slot].kind == Kind::Length && !is_zero(slot),
    };
    let able: Vec<(Slot, f64)> = found
        .estimates
        .iter()
        .filter(|estimate| model.registry[estimate.slot].group == Group::Geometry && wanted(estimate.slot))
        .filter_map(|estimate| Some((estimate.slot, estimate.repeatability()?.0)))
        .collect();
    able[random.random_range(0..able.len())]
}

fn told(model: &Model, poses: usize, kind: Withheld, seed: u64) -> Option<Told> {
    let mut random = generator(seed);
    let mut values = draw_errors(model, 1.0, 0.0, &mut random);
    let first = campaign(model, &values, poses, &mut random);
    let (slot, sigma) = withheld(model, &first, kind, &mut random);
    let size = if random.random::<bool>() { 3.0 } else { -3.0 } * sigma;
    let (from, rise) = match kind {
        Withheld::Drift => (random.random_range(1..4), random.random_range(3..7)),
        _ => (random.random_range(3..CHECKS - 2), 1),
    };
    let start = values[slot];
    let placed = values[model.base..model.base + 6].to_vec();
    let campaigns: Vec<Campaign> = (0..CHECKS)
        .map(|k| {
            let steps = (k + 1).saturating_sub(from) as f64;
            match kind {
                Withheld::Nothing => {}
                Withheld::Clamped if k == from => (0..6).for_each(|axis| {
                    values[model.base + axis] += if axis < 3 { 0.02 } else { 0.01 } * normal(&mut random);
                }),
                Withheld::Clamped => {}
                Withheld::Step if k >= from => values[slot] = start + size,
                Withheld::Step => {}
                Withheld::Drift => values[slot] = start + size * steps / f64::from(rise),
            }
            if kind != Withheld::Clamped {
                // Each month the instrument stands elsewhere.
                (0..6).for_each(|axis| {
                    values[model.base + axis] = placed[axis] + if axis < 3 { 0.1 } else { 0.02 } * normal(&mut random);
                });
            }
            campaign(model, &values, poses, &mut random)
        })
        .collect();
    let (all, history) = tracked(model, &campaigns)?;
    let alarms: Vec<usize> = (0..CHECKS).filter(|&k| history.findings[k].alarm()).collect();
    let name = matches!(kind, Withheld::Step | Withheld::Drift).then(|| model.registry[slot].name.clone());
    let event = alarms.first().and_then(|&k| history.findings[k].event.clone());
    let names = &all.checks[0].robot.names;
    let named = event.as_ref().is_some_and(|event| {
        let own = event.changes.iter().map(|change| change.parameter).chain(event.rivals.iter().copied());
        own.map(|k| &names[k]).any(|known| Some(known) == name.as_ref())
    });
    let level = Settings::default().of_check();
    let standing = history.findings.iter().filter_map(|found| found.event.as_ref()).filter(|e| e.part_of.is_none());
    Some(Told {
        again: standing.count() > 1,
        at: [from, from + rise as usize - 1],
        named,
        as_line: event.is_some_and(|event| matches!(event.shape, Shape::Line { .. })),
        moved: (0..CHECKS).filter(|&k| history.findings[k].placed[0].is_some_and(|p| p < level)).collect(),
        alarms,
    })
}

/// Histories of one kind: how many, with a false alarm before the event, detected within three checks, named, the base alone moved
/// or growth told first, and with a change told more than once.
fn counted(model: &Model, poses: usize, kind: Withheld, count: u64) -> (usize, usize, usize, usize, usize, usize) {
    let all: Vec<Told> = (0..count).into_par_iter().filter_map(|seed| told(model, poses, kind, 1000 + seed)).collect();
    let is_silent = matches!(kind, Withheld::Nothing | Withheld::Clamped);
    let of = |holds: &dyn Fn(&Told) -> bool| all.iter().filter(|told| holds(told)).count();
    let false_alarm = of(&|told| told.alarms.iter().any(|k| is_silent || *k < told.at[0]));
    let in_time = |told: &Told| told.alarms.iter().any(|k| (told.at[0]..told.at[1] + 3).contains(k));
    let detected = of(&in_time);
    let named = of(&|told| in_time(told) && told.named);
    let last = match kind {
        Withheld::Clamped => of(&|told| told.moved == [told.at[0]]),
        _ => of(&|told| told.as_line),
    };
    (all.len(), false_alarm, detected, named, last, of(&|told| told.again))
}

/// Twelve monthly checks of a UR5, 30 positions each, the instrument put up anew: what a year says of nothing, of a base put
/// down anew, of the zero of a joint that jumps and of a length that grows.
#[test]
#[ignore = "hundreds of years of checks; minutes"]
fn years_of_checks() {
    let model = elastogeo::files::load_robot("universal-ur5").expect("a robot").model;
    let count = 200;
    let [nothing, clamped, step, drift] = [Withheld::Nothing, Withheld::Clamped, Withheld::Step, Withheld::Drift]
        .map(|kind| counted(&model, 30, kind, count));
    let percent = |part: usize, all: usize| format!("{:.1} %", 100.0 * part as f64 / all as f64);
    let quiet = nothing.0 + clamped.0;
    let refused = 4 * count as usize - nothing.0 - clamped.0 - step.0 - drift.0;
    let lines = [
        format!("years simulated: {}, refused since a calibration does not converge {refused}", 4 * count),
        format!("years without a change: {quiet}, with a false alarm {}", percent(nothing.1 + clamped.1, quiet)),
        format!(
            "years with a base put down anew: {}, said of the base alone {}",
            clamped.0,
            percent(clamped.4, clamped.0)
        ),
        format!(
            "years with a step of a joint zero of three sigmas: {}, shown within three checks {}, the joint named {}, a false alarm before {}, told again {}",
            step.0,
            percent(step.2, step.0),
            percent(step.3, step.0),
            percent(step.1, step.0),
            percent(step.5, step.0)
        ),
        format!(
            "years with a length that grows: {}, shown within three checks of three sigmas {}, the length named {}, a false alarm before {}, told again {}",
            drift.0,
            percent(drift.2, drift.0),
            percent(drift.3, drift.0),
            percent(drift.1, drift.0),
            percent(drift.5, drift.0)
        ),
    ];
    recorded("track", "cargo test --test it years_of_checks -- --ignored", &lines);
}

/// What a year of checks says of a length whose errors (mm) at the checks are given: at which check, whether as growth, by how much
/// (mm), and whether it turns out to be part of growth.
fn told_of(model: &Model, name: &str, errors: &dyn Fn(f64) -> f64, seed: u64) -> Vec<(usize, bool, f64, bool)> {
    let mut random = generator(seed);
    let mut values = draw_errors(model, 1.0, 0.0, &mut random);
    let slot = model.registry.slot(name).expect("a length");
    let (start, placed) = (values[slot], values[model.base..model.base + 6].to_vec());
    let campaigns: Vec<Campaign> = (0..CHECKS)
        .map(|k| {
            values[slot] = start + 1e-3 * errors(k as f64);
            (0..6).for_each(|axis| values[model.base + axis] = placed[axis] + 0.02 * normal(&mut random));
            campaign(model, &values, 40, &mut random)
        })
        .collect();
    let (all, history) = tracked(model, &campaigns).expect("converged");
    let names = &all.checks[0].robot.names;
    let events = history.findings.iter().enumerate().filter_map(|(k, found)| Some((k, found.event.as_ref()?)));
    events
        .map(|(k, event)| {
            let own = event.changes.iter().find(|change| names[change.parameter] == name);
            let change = own.map_or(f64::NAN, |change| 1e3 * change.change);
            (k, matches!(event.shape, Shape::Line { .. }), change, event.part_of.is_some())
        })
        .collect()
}

/// Steady growth is told as growth, once; at most one jump, which two checks cannot tell from it, is told before. A jump on top
/// of it is told as one, and so are two jumps of one length.
#[test]
fn growth_is_told_once() {
    let model = elastogeo::files::load_robot("universal-ur5").expect("a robot").model;
    let name = "3.d";
    for (seed, rate) in [(1, 0.02), (2, 0.03), (3, 0.05)] {
        let told = told_of(&model, name, &|k| rate * k, seed);
        let [jumps @ .., (_, true, slope, false)] = &told[..] else { panic!("{rate}: {told:?}") };
        assert!((slope - rate).abs() < 0.5 * rate, "{rate}: {told:?}");
        assert!(jumps.len() <= 1 && jumps.iter().all(|(_, grows, _, is_part)| !grows && *is_part), "{rate}: {told:?}");
    }
    let told = told_of(&model, name, &|k| 0.03 * k + if k >= 8.0 { 0.2 } else { 0.0 }, 4);
    let [.., (_, true, _, false), (8, false, jump, false)] = &told[..] else { panic!("{told:?}") };
    assert!((jump - 0.2).abs() < 0.1, "{told:?}");
    let told =
        told_of(&model, name, &|k| f64::from(u8::from(k >= 3.0)) * 0.15 + f64::from(u8::from(k >= 8.0)) * 0.2, 5);
    let [(3, false, _, false), (8, false, _, false)] = &told[..] else { panic!("{told:?}") };
}

/// A folder with monthly checks of the two-joint robot; `set` is what is off in each.
fn months(set: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("arm.yaml"), PLANAR).expect("written");
    for (k, set) in set.iter().enumerate() {
        let (seed, into) = ((k + 1).to_string(), format!("m{}", k + 1));
        let made =
            ["simulate", "arm.yaml", "--poses", "24", "--errors", "0", "--seed", &seed, "--into", &into, "--set", set];
        let ran = run(folder.path(), &made);
        assert_eq!(ran.status, 0, "{}", ran.err);
    }
    folder
}

/// A step at a joint's zero is told at the check that shows it, by name, with its size; the alarm is of the last check only.
#[test]
fn a_step_is_told_with_its_joint() {
    let folder = months(&["2.d=0.3", "2.d=0.3", "2.d=0.3", "2.d=0.3,2.theta=0.03", "2.d=0.3,2.theta=0.03"]);
    let at = folder.path();
    let asked = ["track", "arm.yaml", "m1", "m2", "m3", "m4"];
    let dates = ["--dates", "2026-01-12,2026-02-09,2026-03-09,2026-04-13"];
    let ran = run(at, &[&asked[..], &dates[..], &["--alarm"]].concat());
    assert_eq!(ran.status, 3, "{}{}", ran.out, ran.err);
    for words in ["m4 (step, since m4): the zero of joint 2 has jumped", "control charts: track.html", "next check: "] {
        assert!(ran.out.contains(words), "{words}: {}", ran.out);
    }
    let page = std::fs::read_to_string(at.join("track.html")).expect("a page");
    assert!(page.contains("the zero of joint 2 has jumped") && page.matches("<svg").count() >= 3, "{page}");
    assert!(!page.contains("class=\"fault\""), "{page}");
    let last = [&asked[..], &["m5"]].concat();
    for (alarm, status) in [("last", 0), ("any", 3)] {
        assert_eq!(run(at, &[&last[..], &["--alarm", alarm]].concat()).status, status, "{alarm}");
    }
    let ran = run(at, &[&last[..], &["--format", "json", "--change", "2.theta=0.02"]].concat());
    let found: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    assert!(found["checks"][1]["date"].is_null(), "{found:#}");
    // Without `--dates` those of the certificates count.
    for (month, date) in [("m1", "2026-01-12"), ("m2", "2026-02-09"), ("m3", "2026-03-09"), ("m4", "2026-04-13")] {
        let file =
            ["campaign.yaml", ".yaml"].map(|end| at.join(month).join(end)).into_iter().find(|file| file.exists());
        let file = file.unwrap_or_else(|| at.join(format!("{month}.yaml")));
        let text = std::fs::read_to_string(&file).expect("a campaign");
        std::fs::write(file, format!("{text}certificate: {{date: {date}}}\n")).expect("written");
    }
    let dated = run(at, &[&asked[..], &["--format", "json"]].concat());
    let dated: serde_json::Value = serde_json::from_str(&dated.out).expect("JSON");
    assert_eq!(dated["checks"][3]["date"], "2026-04-13", "{dated:#}");
    // Free text is no day, and it is said that none is used.
    let file =
        [at.join("m4/campaign.yaml"), at.join("m4.yaml")].into_iter().find(|file| file.exists()).expect("a campaign");
    let text = std::fs::read_to_string(&file).expect("a campaign");
    std::fs::write(file, text.replace("2026-04-13", "yesterday")).expect("written");
    let ran = run(at, &asked);
    assert!(ran.status == 0 && ran.err.contains("`yesterday` of `m4` is no day"), "{}", ran.err);
    let checks = found["checks"].as_array().expect("checks");
    let alarms: Vec<bool> = checks.iter().map(|check| check["alarm"] == true).collect();
    assert_eq!(alarms, [false, false, false, true, false], "{found:#}");
    let change = &checks[3]["event"]["changes"][0];
    assert_eq!((&change["name"], &change["unit"]), (&"2.theta".into(), &"deg".into()), "{found:#}");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    assert!((number(&change["change"]) - 0.03).abs() < 2.0 * number(&change["ci95"]), "{change}");
    assert!(number(&checks[3]["statistic"]) > 0.0 && number(&checks[3]["limit"]) > 0.0);
    assert!(number(&found["next"][0]["poses"]) >= 3.0, "{}", found["next"]);
}

/// A description that says how certain it is is the reference of the first check.
#[test]
fn a_saved_description_is_the_reference() {
    let folder = months(&["2.d=0.3", "2.d=0.3", "2.d=0.5"]);
    let at = folder.path();
    assert_eq!(run(at, &["identify", "m1", "--save", "saved.yaml"]).status, 0);
    let quiet = run(at, &["track", "saved.yaml", "m2", "--alarm"]);
    assert_eq!(quiet.status, 0, "{}{}", quiet.out, quiet.err);
    assert!(quiet.out.contains("compared with the description `saved.yaml`"), "{}", quiet.out);
    let twice = run(at, &["track", "saved.yaml", "m1", "m2"]);
    assert!(
        twice.err.contains("`m1` agrees with the reference to rounding") && !twice.err.contains("`m2`"),
        "{}",
        twice.err
    );
    let moved = run(at, &["track", "saved.yaml", "m3", "--alarm"]);
    assert_eq!(moved.status, 3, "{}{}", moved.out, moved.err);
    assert!(moved.out.contains("a length at frame 2 has jumped"), "{}", moved.out);
}

/// What cannot be compared is refused, in words.
#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = months(&["2.d=0.3", "2.d=0.3"]);
    let at = folder.path();
    std::fs::create_dir(at.join("copy")).expect("made");
    for file in std::fs::read_dir(at.join("m1")).expect("a folder") {
        let file = file.expect("an entry");
        std::fs::copy(file.path(), at.join("copy").join(file.file_name())).expect("copied");
    }
    let longer = PLANAR.replace("d: 500", "d: 700");
    std::fs::write(at.join("longer.yaml"), longer).expect("written");
    assert_eq!(run(at, &["simulate", "longer.yaml", "--poses", "24", "--into", "other"]).status, 0);
    let cases: &[(&[&str], &str)] = &[
        (&["m1"], "one check shows no changes"),
        (&["m1", "m1"], "`m1` is given twice"),
        (&["m1", "copy"], "`copy` holds the same readings as `m1`"),
        (&["m1", "other"], "`other` is of another robot than `arm.yaml`: `2.d` of its description is far off"),
        (&["m1", "m2", "--dates", "2026-01-12"], "--dates has 1 day for 2 campaigns"),
        (
            &["m1", "m2", "--dates", "2026-02-12,2026-02-11"],
            "`2026-02-11` of `m2` is not after the day of the campaign before it",
        ),
        (&["m1", "m2", "--dates", "2026-02-12,2026-02-30"], "`2026-02-30` is no day"),
        (&["m1", "m2", "--change", "2.theta"], "write NAME=VALUE"),
        (&["m1", "m2", "--change", "2.thta=1"], "did you mean `2.theta`?"),
        (&["m1", "kr270-simulated"], ""),
    ];
    for (campaigns, words) in cases {
        let ran = run(at, &[&["track", "arm.yaml"], *campaigns].concat());
        assert!(ran.status == 2 && ran.err.contains(words), "{campaigns:?}: {} {}", ran.status, ran.err);
        assert!(!at.join("track.html").exists());
    }
}

/// Few years, in the normal suite: what stands still is left alone, also where its base is put down anew, and a step is shown.
#[test]
fn a_few_years_of_checks() {
    let model = elastogeo::files::load_robot("universal-ur5").expect("a robot").model;
    let quiet = counted(&model, 30, Withheld::Clamped, 4);
    // At 5 % a year two of four have a probability of 1.4 %.
    assert!(quiet.1 <= 1 && quiet.4 >= 3, "{quiet:?}");
    let step = counted(&model, 30, Withheld::Step, 4);
    assert!(step.2 >= 3 && step.1 <= 1, "{step:?}");
}

/// A robot that is as described has nothing to calibrate; its checks are compared all the same, and raise no alarm.
#[test]
fn a_robot_that_is_as_described_is_tracked() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (name, seed) in [("a", "11"), ("b", "12"), ("c", "13")] {
        let made = ["simulate", "universal-ur5", "--poses", "30", "--errors", "0", "--unknown-base", "--unknown-tool"];
        let ran = run(at, &[&made[..], &["--seed", seed, "--into", name]].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
    }
    let ran = run(at, &["track", "universal-ur5", "a", "b", "c", "--alarm"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
}

/// What appears at a check and is no change of a constant is shown by its residuals, and named by the diagnosis.
#[test]
fn effects_that_appear_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let effects = [
        ("gear-ratio", "gear-ratio@joint:2:ratio=5e-4"),
        ("link-warm-up", "link-warm-up@link:2:growth=2e-3,time_constant=1500"),
    ];
    for (name, effect) in effects {
        let months: Vec<String> = (1..=3).map(|k| format!("{name}{k}")).collect();
        for (k, month) in months.iter().enumerate() {
            let seed = (20 + k).to_string();
            let made = [
                "simulate",
                "universal-ur5",
                "--poses",
                "60",
                "--noise",
                "0.05",
                "--errors",
                "0",
                "--seed",
                &seed,
                "--into",
                month,
            ];
            let unknown = ["--unknown-base", "--unknown-tool", "--conditions"];
            let on = if k == 2 { &["--effect", effect][..] } else { &[] };
            let ran = run(at, &[&made[..], &unknown, on].concat());
            assert_eq!(ran.status, 0, "{}", ran.err);
        }
        let asked = ["track", "universal-ur5", &months[0], &months[1], &months[2], "--format", "json"];
        let found: serde_json::Value = serde_json::from_str(&run(at, &asked).out).expect("JSON");
        let checks = found["checks"].as_array().expect("checks");
        let alarms: Vec<bool> = checks.iter().map(|check| check["alarm"] == true).collect();
        assert_eq!(alarms, [false, false, true], "{name}: {found:#}");
        let told = checks[2]["event"]["diagnosis"].as_str().unwrap_or_default();
        assert!(told.contains(name), "{name}: {}", checks[2]["event"]);
    }
}
