//! The catalogue against its documentation, effects that are switched on, and an effect that only this file knows.

use std::sync::Arc;

use elastogeo::description::raw::{RawAmount, RawEffect};
use elastogeo::description::yaml;
use elastogeo::effects::{
    Catalogue, Change, Changes, Effect, EffectParameter, Nonlinear, NonlinearKind, NonlinearParameter, NonlinearValue,
    Site, SiteKind, Survey,
};
use elastogeo::estimation::{Settings, calibrate};
use elastogeo::files::{Reader, load_robot};
use elastogeo::kinematics::Geometry;
use elastogeo::model::{Model, with_values};
use elastogeo::observation::POSITION;
use elastogeo::prediction::{Linearised, Predictor};
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};

use super::cli::run;
use super::support::{diagnosed, switch_on};

fn site(kind: SiteKind) -> (&'static str, bool) {
    match kind {
        SiteKind::Frame => ("frame", true),
        SiteKind::Joint => ("joint", true),
        SiteKind::Link => ("link", true),
        SiteKind::Actuator => ("actuator", true),
        SiteKind::Base => ("base", false),
        SiteKind::Tool => ("tool", false),
        SiteKind::Marker => ("marker", true),
        SiteKind::Joints => ("joints", false),
        SiteKind::Instrument => ("instrument", false),
    }
}

#[test]
fn every_effect_has_its_section() {
    let path = format!("{}/docs/effects.md", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a file");
    let sections: Vec<&str> = text.split("\n## ").skip(1).collect();
    let named: Vec<&str> = sections.iter().map(|s| s.lines().next().unwrap_or_default().trim_matches('`')).collect();
    let names: Vec<&str> = Catalogue::standard().names().collect();
    assert_eq!(named, names, "one section each, in the order of the catalogue");
    for (effect, section) in Catalogue::standard().iter().zip(sections) {
        let (kind, is_named) = site(effect.sits_at());
        let name = if matches!(kind, "actuator" | "marker") { "name" } else { "n" };
        let said = if is_named { format!("Site: `{kind}:<{name}>`") } else { format!("Site: `{kind}`") };
        assert!(section.contains(&said), "{}: {said}", effect.name());
        for part in ["* Pattern:", "* Separate from", "* On the machine:"] {
            assert!(section.contains(part), "{}: {part}", effect.name());
        }
        for parameter in effect.nonlinear_parameters() {
            let keys: Vec<String> = match parameter.kind {
                NonlinearKind::Choice(words) => {
                    words.iter().map(|word| format!("{}: {word}", parameter.name)).collect()
                }
                _ => vec![parameter.name.to_string()],
            };
            for key in keys {
                assert!(section.contains(&format!("`{key}`")), "{}: {key}", effect.name());
            }
        }
    }
}

/// Amounts of effects that are switched on are fitted with all else, and by derivatives that differences confirm.
#[test]
fn effects_switched_on_are_identified() {
    let mut model = load_robot("kuka-kr270").expect("a robot").model;
    type Amount<'a> = (&'a str, &'a str, &'a [(&'a str, f64)]);
    let amounts: [Amount; 3] = [
        ("gear-ratio", "joint:3", &[("ratio", 4e-4)]),
        ("backlash", "joint:1", &[("half_width", 3e-4), ("changes_at", 0.0)]),
        ("transmission-error", "joint:2", &[("cos", 3e-4), ("sin", -2e-4), ("order", 3.0)]),
    ];
    for (effect, site, parameters) in amounts {
        switch_on(&mut model, effect, site, parameters);
    }
    let mut random = generator(3);
    let truth = draw_errors(&model, 0.5, 0.0, &mut random);
    let plan = Plan {
        conditions: true,
        wrenches: vec![[0.0; 6]],
        configurations: draw_configurations(&Geometry::new(&model, &truth).expect("assembled"), 60, 0.8, &mut random)
            .expect("drawn"),
        markers: (0..model.markers.len()).map(Some).collect(),
        repeats: 1,
        observes: POSITION,
        sigma: 3e-5,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let campaign = simulate(&model, &truth, &plan, &mut random).expect("simulated");
    let names = [
        "gear-ratio@joint:3.ratio",
        "backlash@joint:1.half_width",
        "transmission-error@joint:2.cos",
        "transmission-error@joint:2.sin",
    ];
    let slots: Vec<usize> = names.iter().map(|name| model.registry.slot(name).expect("a parameter")).collect();

    let predictor = Predictor::new(&model, &campaign, slots.clone()).expect("a predictor");
    let (mut exact, mut up, mut down) = (Linearised::default(), Linearised::default(), Linearised::default());
    predictor.linearise(&truth, true, &mut exact).expect("linearised");
    for (column, &slot) in slots.iter().enumerate() {
        let mut moved = truth.clone();
        moved[slot] = truth[slot] + 1e-5;
        predictor.linearise(&moved, false, &mut up).expect("predicted");
        moved[slot] = truth[slot] - 1e-5;
        predictor.linearise(&moved, false, &mut down).expect("predicted");
        for row in 0..predictor.rows() {
            let difference = (down.residual[row] - up.residual[row]) / 2e-5;
            let ours = exact.jacobian[row * slots.len() + column];
            assert!((ours - difference).abs() < 1e-6 * (1.0 + ours.abs()), "{}: {ours} {difference}", names[column]);
        }
    }

    // What the description says of the amounts is wrong; the readings determine them.
    for &slot in &slots {
        model.registry.all_mut()[slot].nominal = 0.0;
    }
    let held_out = vec![false; campaign.readings.len()];
    let found = calibrate(&model, &campaign, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated");
    for (name, &slot) in names.iter().zip(&slots) {
        let estimate = found.estimates.iter().find(|estimate| estimate.slot == slot).expect("an estimate");
        let ci95 = estimate.ci95.expect("identifiable");
        let off = (estimate.value - truth[slot]).abs();
        assert!(off < 2.0 * ci95 && ci95 < 0.2 * truth[slot].abs(), "{name}: {estimate:?}");
    }
}

/// A hose that turns a joint as two other joints wind it up: with the square of their sum, or with its modulus.
struct Hose;

static WINDS: NonlinearParameter = NonlinearParameter {
    name: "winds",
    kind: NonlinearKind::Choice(&["modulus", "square"]),
    default: None,
    only_with: None,
    meaning: "`winds`: how the hose winds up",
};

impl Effect for Hose {
    fn name(&self) -> &'static str {
        "hose"
    }

    fn sits_at(&self) -> SiteKind {
        SiteKind::Joint
    }

    fn signature(&self) -> &'static str {
        "an angle of one joint that grows with how far the hose is wound up"
    }

    fn remedy(&self) -> &'static str {
        "lengthen the hose"
    }

    fn sites(&self, model: &Model) -> Vec<Site> {
        model.sites(SiteKind::Joint).into_iter().filter(|site| site.name == "joint:5").collect()
    }

    fn nonlinear_parameters(&self) -> Vec<&'static NonlinearParameter> {
        vec![&WINDS]
    }

    fn candidates(&self, _model: &Model, _site: &Site, _survey: &Survey) -> Vec<Nonlinear> {
        ["modulus", "square"].map(|word| Nonlinear::new([(&WINDS, NonlinearValue::Choice(word))])).to_vec()
    }

    fn parameters(&self, _model: &Model, _site: &Site, _nonlinear: &Nonlinear) -> Vec<EffectParameter> {
        vec![EffectParameter::new("pull", "1", 1e-4)]
    }

    fn changes(&self, _model: &Model, site: &Site, nonlinear: &Nonlinear) -> Changes {
        let Some(variable) = site.coordinate else { return Arc::new(|_, _| {}) };
        let is_square = nonlinear.values() == [NonlinearValue::Choice("square")];
        Arc::new(move |context, out| {
            let wound = context.q[3] + context.q[5];
            out.push((0, Change::Joint(variable, if is_square { wound * wound } else { wound.abs() })));
        })
    }
}

/// One file and one line of a catalogue make an effect: it is simulated, diagnosed, written into a description, read back,
/// predicted and recalibrated. A reader that does not know it refuses the description.
#[test]
fn an_effect_of_this_file_goes_all_the_way() {
    const PULL: f64 = 1e-3;
    const SIGMA: f64 = 3e-5;
    let reader = Reader::new(Catalogue::standard().with(Hose));
    let loaded = reader.robot("universal-ur5").expect("a bundled robot");
    let model = &loaded.model;

    // Simulated: the effect moves readings by several times their noise.
    let parameters = [("pull".to_string(), RawAmount::from(PULL)), ("winds".into(), "square".into())];
    let raw = RawEffect {
        effect: Some("hose".into()),
        site: Some("joint:5".into()),
        parameters: parameters.into_iter().collect(),
        ..RawEffect::default()
    };
    let mut true_model = model.clone();
    true_model.switch_on(model.resolve_effect(&raw).expect("an effect of the catalogue"));
    let mut random = generator(5);
    let truth = true_model.completed(&draw_errors(model, 0.5, 0.0, &mut random));
    let geometry = Geometry::new(model, &truth).expect("assembled");
    let plan = Plan {
        conditions: false,
        configurations: draw_configurations(&geometry, 60, 0.25, &mut random).expect("drawn"),
        markers: vec![None],
        repeats: 1,
        wrenches: Vec::new(),
        observes: POSITION,
        sigma: SIGMA,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let campaign = simulate(&true_model, &truth, &plan, &mut random).expect("simulated");

    // Diagnosed, with the right nonlinear value.
    let held_out = vec![false; campaign.readings.len()];
    let found = diagnosed(model, &campaign);
    let cause = found.causes.first().expect("a cause");
    assert_eq!((cause.effect.as_str(), cause.site.as_str(), found.causes.len()), ("hose", "joint:5", 1));
    let [pull, winds] = &cause.parameters[..] else { panic!("{cause:?}") };
    let ci95 = pull.ci95.expect("a fitted parameter");
    assert!((pull.value.number().expect("a number") - PULL).abs() < 2.0 * ci95 && ci95 < 0.2 * PULL, "{pull:?}");
    assert_eq!((winds.name.as_str(), &winds.value), ("winds", &RawAmount::from("square")));

    // Written and read back.
    let mut applied = with_values(&loaded.raw, model, &found.values);
    applied.effects.extend(found.entries().map(|entry| entry.raw(model)));
    let text = yaml::write(&applied).expect("YAML");
    assert!(text.contains("winds: square"), "{text}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("applied.yaml");
    std::fs::write(&path, text).expect("written");
    let path = path.display().to_string();
    let refusal = load_robot(&path).expect_err("the standard catalogue has no hose");
    assert!(refusal.to_string().contains("unknown effect `hose`"), "{refusal}");
    let mut back = reader.robot(&path).expect("readable").model;

    // Predicted: noise is left, and without the effect much more.
    let rms = |model: &Model| {
        let mut out = Linearised::default();
        let predictor = Predictor::new(model, &campaign, Vec::new()).expect("a predictor");
        predictor.linearise(&model.registry.nominal(), false, &mut out).expect("predicted");
        (out.residual.iter().map(|r| r * r).sum::<f64>() / out.residual.len() as f64).sqrt()
    };
    let mut without = back.clone();
    without.effects.clear();
    assert!(rms(&back) < 1.2 * SIGMA, "{}", rms(&back));
    assert!(rms(&without) > 2.0 * rms(&back), "{}", rms(&without));

    // Recalibrated from nothing.
    let slot = back.registry.slot("hose@joint:5.pull").expect("a parameter");
    back.registry.all_mut()[slot].nominal = 0.0;
    let found = calibrate(&back, &campaign, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated");
    let estimate = found.estimates.iter().find(|estimate| estimate.slot == slot).expect("an estimate");
    let ci95 = estimate.ci95.expect("identifiable");
    assert!((estimate.value - PULL).abs() < 2.0 * ci95 && ci95 < 0.2 * PULL, "{estimate:?}");
}

/// What versions up to 0.1 wrote with numbers for alternatives is read, and means the same.
#[test]
fn alternatives_written_as_numbers_are_read() {
    let model = load_robot("kuka-kr270").expect("a robot").model;
    let entry = |effect: &str, site: &str, parameters: &[(&str, RawAmount)]| {
        let parameters = parameters.iter().map(|(name, value)| ((*name).to_string(), value.clone())).collect();
        let raw =
            RawEffect { effect: Some(effect.into()), site: Some(site.into()), parameters, ..RawEffect::default() };
        model.resolve_effect(&raw).map(|entry| entry.raw(&model).parameters).map_err(|fault| fault.diagnostic.message)
    };
    let same = |effect: &str, site: &str, old: &[(&str, RawAmount)], new: &[(&str, RawAmount)]| {
        let [old, new] = [old, new].map(|parameters| entry(effect, site, parameters).expect("an effect"));
        assert_eq!(old, new, "{effect}");
    };
    let number = RawAmount::from;
    let word = |word: &str| RawAmount::from(word);
    let half_width = ("half_width", number(3e-4));
    let old = [half_width.clone(), ("changes_at", number(0.0))];
    same("backlash", "joint:1", &old, &[half_width.clone(), ("by", word("approach"))]);
    same("backlash", "joint:1", std::slice::from_ref(&half_width), &[half_width.clone(), ("by", word("approach"))]);
    let old = [half_width.clone(), ("changes_at", number(12.5))];
    same("backlash", "joint:1", &old, &[half_width.clone(), ("by", word("load")), ("changes_at", number(12.5))]);
    let gain = ("gain", number(0.02));
    same("payload", "tool", &[gain.clone(), ("of_wrench", number(1.0))], &[gain, ("misstated", word("wrench"))]);
    let drift = ("x", number(1e-8));
    same(
        "frame-drift",
        "base",
        &[drift.clone(), ("jump_at", number(-1.0))],
        &[drift.clone(), ("course", word("steady"))],
    );
    let jump = [drift.clone(), ("course", word("jump")), ("jump_at", number(630.0))];
    same("frame-drift", "base", &[drift, ("jump_at", number(630.0))], &jump);
    let ratio = ("ratio", number(1e-3));
    let other = model.variables[1].name.as_str();
    let old = [ratio.clone(), ("variable", number(1.0))];
    same("joint-coupling", "joint:3", &old, &[ratio.clone(), ("variable", word(other))]);

    for (effect, parameters, message) in [
        ("backlash", vec![half_width.clone(), ("by", word("aproach"))], "`by: aproach` of `backlash`"),
        ("backlash", vec![half_width, ("by", word("load"))], "`backlash` lacks `changes_at`"),
        ("backlash", vec![("half_width", word("3 mm"))], "`half_width: 3 mm` of `backlash`"),
        ("joint-coupling", vec![ratio.clone()], "`joint-coupling` lacks `variable`"),
        (
            "encoder-quantisation",
            vec![("share", number(1.0)), ("step", number(0.0))],
            "`step: 0` of `encoder-quantisation`",
        ),
        (
            "hysteresis",
            vec![("half_width", number(1e-4)), ("distance", number(-1.0))],
            "`distance: -1` of `hysteresis`",
        ),
        ("gear-ratio", vec![("ratio", number(f64::NAN))], "`NaN` where a finite number is needed"),
        ("gear-ratio", vec![ratio, ("order", number(1.0))], "`gear-ratio` has no parameter `order`"),
    ] {
        assert_eq!(entry(effect, "joint:3", &parameters), Err(message.to_string()), "{effect}");
    }
}

/// Joints that are read some time before they arrive together: the column of what is read is the command less what is still to come, computed
/// here. With shares of the moves of single joints something stays.
#[test]
fn joints_read_in_motion_are_one_cause() {
    let folder = tempfile::tempdir().expect("a folder");
    let simulate = ["simulate", "universal-ur5", "--poses", "150", "--noise", "0.05", "--errors", "0", "--seed", "5"];
    let made = run(folder.path(), &[&simulate[..], &["--unknown-base", "--into", "c"]].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let path = folder.path().join("c/measurements.csv");
    let mut table = csv::Reader::from_path(&path).expect("a table");
    let titles = table.headers().expect("titles").clone();
    let joints = ["q1", "q2", "q3", "q4", "q5", "q6"].map(|q| titles.iter().position(|t| t == q).expect("a column"));
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
    let q = |row: &csv::StringRecord, k: usize| row[joints[k]].parse::<f64>().expect("an angle");
    // Degrees, as the columns.
    let lags = [0.08, 0.07, 0.06, 0.05, 0.04, 0.03];
    let mut written = csv::Writer::from_path(&path).expect("a table");
    written.write_record(&titles).expect("written");
    for (at, row) in rows.iter().enumerate() {
        let moved = [0, 1, 2, 3, 4, 5].map(|k| if at == 0 { 0.0 } else { q(row, k) - q(&rows[at - 1], k) });
        let farthest = moved.iter().fold(0.0_f64, |most, moved| most.max(moved.abs()));
        let read = |(column, value): (usize, &str)| match joints.iter().position(|own| *own == column) {
            Some(k) if farthest > 0.0 => (q(row, k) - lags[k] * moved[k] / farthest).to_string(),
            _ => value.to_string(),
        };
        written.write_record(row.iter().enumerate().map(read)).expect("written");
    }
    written.flush().expect("written");
    let json = super::support::printed_json(folder.path(), &["diagnose", "c", "--robot", "universal-ur5"]);
    let causes = json["causes"].as_array().expect("a list");
    let [cause] = &causes[..] else { panic!("{causes:?}") };
    assert_eq!((&cause["effect"], &cause["site"]), (&"settling".into(), &"joints".into()), "{cause}");
    assert_eq!((&json["verdict"], &cause["level"]), (&"explained".into(), &"law".into()), "{json}");
    // The last joint turns about the axis on which the measured point is: its lag shows nowhere.
    let parameters = cause["parameters"].as_array().expect("a list");
    assert_eq!(parameters.len(), 5, "{parameters:?}");
    for (k, parameter) in parameters.iter().enumerate() {
        let [value, ci95] = ["value", "ci95"].map(|key| parameter[key].as_f64().expect("a number").to_degrees());
        assert_eq!(parameter["name"], format!("lag.{}", k + 1));
        assert!((value - lags[k]).abs() < 2.0 * ci95 && ci95 < 0.02, "{parameter}");
    }
}

/// A joint that is read before it stands still: simulated in order, written, read and named, with its share.
#[test]
fn settling_is_named_where_readings_are_numbered() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = |arguments: &[&str]| {
        let ran = run(folder.path(), arguments);
        assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
        ran.out
    };
    ran(&["convert", "universal-ur5", "late.yaml"]);
    let path = folder.path().join("late.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let effect = "effects: [{effect: settling, site: \"joint:2\", parameters: {share: 1.5e-3}}]\n";
    std::fs::write(&path, text + effect).expect("written");
    ran(&[
        "simulate",
        "late.yaml",
        "--poses",
        "60",
        "--noise",
        "0.05",
        "--errors",
        "0",
        "--unknown-base",
        "--into",
        "c",
    ]);
    let table = std::fs::read_to_string(folder.path().join("c/measurements.csv")).expect("read");
    assert!(table.lines().next().expect("a title").contains(",order"), "{table}");
    let said = ran(&["diagnose", "c", "--robot", "universal-ur5", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    let cause = &json["causes"][0];
    assert_eq!((&cause["effect"], &cause["site"]), (&"settling".into(), &"joint:2".into()), "{json}");
    let (value, ci95) = (cause["parameters"][0]["value"].as_f64(), cause["parameters"][0]["ci95"].as_f64());
    let (value, ci95) = (value.expect("a share"), ci95.expect("an interval"));
    assert!((value - 1.5e-3).abs() < 2.0 * ci95 && ci95 < 3e-4, "{value} +- {ci95}");
    // Where every tenth place in the order has no reading, laws of the last move know nothing of the one that follows: it is no outlier.
    let mut gaps = csv::Reader::from_reader(table.as_bytes());
    let titles = gaps.headers().expect("titles").clone();
    let order = titles.iter().position(|title| title == "order").expect("a column");
    let mut written = csv::Writer::from_path(folder.path().join("c/measurements.csv")).expect("a table");
    written.write_record(&titles).expect("written");
    for row in gaps.records().map(|row| row.expect("a row")) {
        let rank: usize = row[order].parse().expect("a number");
        let moved = (rank + rank / 10).to_string();
        written
            .write_record(row.iter().enumerate().map(|(k, own)| if k == order { &moved } else { own }))
            .expect("written");
    }
    written.flush().expect("written");
    let said = ran(&["diagnose", "c", "--robot", "universal-ur5", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    let named: Vec<&str> =
        json["causes"].as_array().expect("a list").iter().filter_map(|own| own["effect"].as_str()).collect();
    assert_eq!(named, ["settling"], "{}", json["causes"]);
    // Rows that have been sorted since are no evidence.
    let unordered = table.replacen(",order", ",number", 1).replacen(",time", ",clock", 1);
    std::fs::write(folder.path().join("c/measurements.csv"), unordered).expect("written");
    let campaign = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&campaign).expect("read");
    std::fs::write(&campaign, text + "ignore: [number, clock]\norder: unknown\n").expect("written");
    let said = ran(&["diagnose", "c", "--robot", "universal-ur5"]);
    assert!(!said.contains("settling at"), "{said}");
    assert!(said.contains("settling (configurations in the order in which they were measured"), "{said}");
}
