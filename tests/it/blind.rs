//! Withheld effects: a dozen sealed campaigns, and the sets that the docs show.

use elastogeo::blind::{
    Design, Drawn, Kind, Rate, Signals, Truth, calibrated, draw, examine, score, seal, without, workshop,
};
use elastogeo::diagnosis::Level;
use elastogeo::files::Reader;
use elastogeo::simulation::generator;
use rayon::prelude::*;

use crate::figures::recorded;

#[test]
fn withheld_effects_are_found_and_nulls_left_alone() {
    let robot = Reader::default().robot_leaving_out("kuka-kr270", &["compensator"]).expect("a bundled robot");
    let kinds = [Kind::Single, Kind::Single, Kind::Null, Kind::Pair];
    let all: Vec<_> = (0..12_usize)
        .into_par_iter()
        .map(|k| {
            let mut random = generator(5_000 + k as u64);
            let (is_deflection, poses) = if k % 3 == 1 { (true, 20) } else { (false, 45) };
            let design = Design { model: &robot.model, robot: "kuka-kr270", is_deflection, poses };
            let Drawn { campaign, fresh, truth } =
                draw(&design, "sealed", kinds[k % 4], &mut random).expect("a campaign");
            assert!((1.0..12.0).contains(&truth.gap), "{truth:?}");
            examine(&robot.model, &campaign, &fresh, 1).expect("a diagnosis").open(truth)
        })
        .collect();
    let found = score(&all);
    let class = |name: &str| found.classes.get(name).map_or((0, 0), |class| (class.count, class.right));
    let ((singles, hits), (nulls, silent)) = (class("single"), class("null"));
    assert_eq!((singles, nulls), (6, 3));
    assert_eq!(hits, singles, "{all:#?}");
    assert_eq!(silent, nulls, "{all:#?}");
}

/// Rows of the table of docs/accuracy.md.
fn scored(score: &serde_json::Value) -> Vec<String> {
    let rows = [
        ("nothing", "null"),
        ("one effect, gap above 1.5 times the noise", "single, above 1.5"),
        ("one effect, gap below", "single, below 1.5"),
        ("two effects, both", "pair"),
        ("three effects, all", "triple"),
        ("an effect outside the catalogue, not given a name", "unknown"),
    ];
    let class = |(row, name): (&str, &str)| {
        let of = |key: &str| score["classes"][name][key].as_u64().expect("a count");
        format!("{row}: {} campaigns, {} right, {} with the site", of("count"), of("right"), of("sites"))
    };
    let coverage = 100.0 * score["coverage"].as_f64().expect("a share");
    let outliers = |k: usize| score["outliers"][k].as_u64().expect("a count");
    let [hidden, found, marked] = [0, 1, 2].map(outliers);
    rows.into_iter()
        .map(class)
        .chain([
            format!("shrinkage within its interval: {coverage:.1} % of {} named causes", score["named"]),
            format!("outliers: {found} of {hidden} found, {} sound readings marked", marked - found),
        ])
        .collect()
}

/// The fixed set whose score README shows: drawn again, it has the truths that were sealed, and what is diagnosed is what
/// was recorded (`blind score F --format json --output tests/data/blind/score.json`).
#[test]
fn the_fixed_set_is_diagnosed_as_recorded() {
    const DRAWN: usize = 30;
    let folder = tempfile::tempdir().expect("a folder");
    let into = folder.path().join("sealed").display().to_string();
    let run = |arguments: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_elastogeo")).args(arguments).output();
        let output = output.expect("the program runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    let kinds = "single,single,pair,null,single,unknown,pair,single,triple,null";
    let (count, mut make) = (DRAWN.to_string(), vec!["blind", "make", "--seed", "7", "--kinds", kinds]);
    for plan in
        ["kuka-kr270:position:45", "kuka-kr270:deflection:20", "kuka-kr270:position:45", "kuka-ir663:deflection:63"]
    {
        make.extend(["--plan", plan]);
    }
    make.extend(["--count", &count, "--into", &into]);
    run(&make);
    let found: serde_json::Value =
        serde_json::from_slice(&run(&["blind", "score", &into, "--format", "json"])).expect("JSON");
    let record = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/blind/score.json");
    let record: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(record).expect("a record")).expect("JSON");
    assert_eq!(record["campaigns"].as_array().map(Vec::len), Some(300));
    recorded("blind", "cargo test the_fixed_set", &scored(&record["score"]));
    for k in 0..DRAWN {
        let [now, then] = [&found, &record].map(|all| &all["campaigns"][k]["said"]);
        for key in ["kind", "robot", "observes", "outliers"] {
            assert_eq!(now["truth"][key], then["truth"][key]);
        }
        let causes = |said: &serde_json::Value, list: &serde_json::Value| -> Vec<String> {
            let all = list.as_array().expect("causes").iter();
            all.map(|cause| format!("{}@{} of {}", cause["effect"], cause["site"], said["truth"]["name"])).collect()
        };
        assert_eq!(causes(now, &now["truth"]["causes"]), causes(then, &then["truth"]["causes"]));
        assert_eq!(causes(now, &now["named"]), causes(then, &then["named"]));
        assert_eq!(now["verdict"], then["verdict"]);
    }
}

#[test]
fn causes_that_readings_cannot_tell_apart_are_tied() {
    let robot = Reader::default().robot("kuka-ir663").expect("a bundled robot");
    let design = Design { model: &robot.model, robot: "kuka-ir663", is_deflection: true, poses: 20 };
    let drawn = |seed| draw(&design, "sealed", Kind::Single, &mut generator(seed)).expect("a campaign");
    let is_payload = |drawn: &Drawn| drawn.truth.causes[0].effect == "payload";
    let Drawn { campaign, truth, .. } = (0..200).map(drawn).find(is_payload).expect("a payload");
    let signals = Signals::new(&robot.model, &campaign, &truth).expect("signals");
    let is_tied = |effect: &str, site: &str| signals.are_reproduced_by(effect, site).expect("columns");
    assert!(is_tied("payload", "tool"));
    // Greater forces and greater lengths are the same in deflections.
    assert!(is_tied("instrument-scale", "instrument"));
    assert!(!is_tied("joint-stiffening", "joint:1"));
    assert!(!is_tied("payload", "joint:1"));
    let left_out = without(&robot.model, &campaign, "payload").expect("a catalogue");
    assert!(left_out.catalogue.get("payload").is_none() && robot.model.catalogue.get("payload").is_some());
    assert!(without(&robot.model, &campaign, "joint-compliance").is_none(), "it is calibrated");
}

#[test]
fn names_are_false_only_where_nothing_excuses_them() {
    let robot = Reader::default().robot_leaving_out("kuka-kr270", &["compensator"]).expect("a bundled robot");
    let design = Design { model: &robot.model, robot: "kuka-kr270", is_deflection: true, poses: 20 };
    let Drawn { campaign, fresh, truth } =
        draw(&design, "sealed", Kind::Single, &mut generator(3)).expect("a campaign");
    let mut one = examine(&robot.model, &campaign, &fresh, 1).expect("an answer").open(truth);
    assert!(!one.named.is_empty());
    one.named.truncate(1);
    one.named[0].rivals.clear();
    let (effect, site) = (one.truth.causes[0].effect.clone(), one.truth.causes[0].site.clone());
    (one.named[0].effect, one.named[0].site) = (effect, site);
    assert!(one.is_right() && one.is_at_site() && !one.has_false_name() && !one.is_open());
    one.named[0].effect = "gear-ratio".into();
    assert!(!one.is_right() && one.has_false_name());
    one.named[0].tied = true;
    assert!(!one.has_false_name());
    // Of what nobody knows, no law is right and a family is.
    one.truth.kind = Kind::Unknown;
    one.named[0].tied = false;
    assert!(!one.is_right());
    (one.named[0].effect, one.named[0].level) = ("family:elastic".into(), Level::Family);
    assert!(one.is_right() && one.is_open());
    // A curve is open at the right site only.
    (one.named[0].effect, one.named[0].level, one.named[0].is_free) = ("free-form".into(), Level::Site, true);
    assert!(one.is_open());
    one.named[0].site = "nowhere".into();
    assert!(!one.is_open() && !one.has_false_name());
}

const SCARA: &str = "
units: {length: mm, angle: deg, mass: kg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 400, limits: [-140, 140]}
  2: {antecedent: 1, joint: revolute, variable: q2, d: 325, limits: [-140, 140]}
  3: {antecedent: 2, joint: prismatic, variable: qz, d: 225, limits: [0, 200]}
  4: {antecedent: 3, joint: revolute, variable: q4, limits: [-180, 180]}
tool: {frame: 4}
";

const ON_A_RAIL: &str = "
units: {length: mm, angle: deg, mass: kg}
frames:
  rail: {antecedent: 0, joint: prismatic, variable: qx, alpha: 90, limits: [0, 3000]}
  1: {antecedent: rail, joint: revolute, variable: q1, alpha: -90, r: 500, limits: [-170, 170]}
  2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, d: 300, limits: [-130, 10]}
  3: {antecedent: 2, joint: revolute, variable: q3, d: 900, limits: [-60, 60]}
  4: {antecedent: 3, joint: revolute, variable: q4, alpha: -90, d: 100, r: 900, limits: [-170, 170]}
  5: {antecedent: 4, joint: revolute, variable: q5, alpha: 90, limits: [-110, 110]}
  6: {antecedent: 5, joint: revolute, variable: q6, alpha: -90, limits: [-180, 180]}
tool: {frame: 6}
bodies:
  2: {mass: 60, com: [400, 0, 0]}
  3: {mass: 50, com: [100, 100, 0]}
";

#[test]
fn a_workshop_measures_any_robot() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("scara.yaml", SCARA), ("on-a-rail.yaml", ON_A_RAIL)] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let plans = ["scara.yaml:position:20", "on-a-rail.yaml:position:20", "barrett-wam:position:20"];
    let mut make = vec!["blind", "make", "--at", "workshop", "--seed", "3", "--count", "18", "--into", "sealed"];
    plans.iter().for_each(|plan| make.extend(["--plan", plan]));
    let run = |arguments: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_elastogeo"))
            .current_dir(folder.path())
            .args(arguments)
            .output()
            .expect("the program runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(&make);
    let kinds = ["single", "unknown", "pair", "null", "mixture", "trap"];
    for k in 0..18 {
        let name = format!("sealed-{:03}", k + 1);
        let path = folder.path().join("sealed/truth").join(format!("{name}.json"));
        let text = std::fs::read_to_string(path).expect("a truth");
        let truth: Truth = serde_json::from_str(&text).expect("JSON");
        assert_eq!(
            (truth.kind.name(), truth.robot.as_str()),
            (kinds[k % 6], ["scara", "on-a-rail", "barrett-wam"][k / 6])
        );
        assert_eq!(truth.causes.len(), [1, 1, 2, 0, 2, 1][k % 6], "{truth:?}");
        let campaign = folder.path().join("sealed").join(&name).join("campaign.yaml");
        let loaded = Reader::default().campaign(&campaign.display().to_string(), None).expect("a campaign");
        assert_eq!(loaded.campaign.readings.len(), 60);
        // Where the files do not state it, the three markers of each tool show it.
        let is_stated = loaded.raw.instrument.is_some_and(|instrument| instrument.sigma.is_some());
        assert_eq!(is_stated, truth.instrument.expect("an instrument").is_stated);
        assert!(loaded.campaign.conditions.is_ordered());
        for cause in truth.causes.iter().filter(|_| k % 6 != 5) {
            assert_eq!(cause.adds.len(), 180);
        }
    }
}

#[test]
fn what_the_bench_calibrates_is_what_the_diagnosis_does() {
    for name in elastogeo::files::bundled_robots() {
        let model = Reader::default().robot(&name).expect("a bundled robot").model;
        for (is_difference, known) in [(false, &["geometry", "joint-offset"][..]), (true, &["joint-compliance"])] {
            let known: Vec<String> = known.iter().map(ToString::to_string).collect();
            let observes =
                if is_difference { elastogeo::observation::DEFLECTION } else { elastogeo::observation::POSITION };
            let campaign = elastogeo::description::campaign::Campaign { observes, ..Default::default() };
            let theirs = elastogeo::model::nuisance(&model, &campaign, &known);
            assert_eq!(calibrated(&model, is_difference), theirs, "{name}");
        }
    }
}

#[test]
fn noises_differ_and_are_as_large_as_the_truth_says() {
    let robot = Reader::default().robot_leaving_out("kuka-kr270", &["compensator"]).expect("a bundled robot");
    let design = Design { model: &robot.model, robot: "kuka-kr270", is_deflection: false, poses: 40 };
    let mut seen = std::collections::BTreeMap::new();
    for seed in 0..24 {
        let Drawn { truth, campaign, .. } =
            workshop::draw(&design, "sealed", Kind::Null, seed % 2 == 0, &mut generator(seed)).expect("a campaign");
        assert_eq!(campaign.sigma.is_some(), seed % 2 == 0);
        assert!(truth.causes.is_empty() && (truth.gap - 1.0).abs() < 1e-6, "{truth:?}");
        *seen.entry(truth.instrument.expect("an instrument").noise).or_insert(0) += 1;
        assert!((2e-5..8e-5).contains(&truth.noise));
    }
    assert_eq!(seen.len(), 5, "{seen:?}");
}

#[test]
fn a_rate_has_the_interval_of_wilson() {
    let rate = Rate::of((0..40).map(|k| k > 1));
    let [low, high] = rate.ci95;
    assert!((low - 0.83496).abs() < 1e-5 && (high - 0.98618).abs() < 1e-5, "{rate:?}");
    assert_eq!(Rate::of(std::iter::empty()).share, None);
}

#[test]
fn a_seal_is_the_sha_256_of_the_truth() {
    assert_eq!(seal("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}
