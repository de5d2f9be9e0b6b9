//! Noise of the instrument without the robot, against draws whose noise and motion are known and measured reflectors.

use crate::real_data::folder;
use std::fmt::Write as _;
use std::path::Path;

use elastogeo::description::campaign::{ReferenceReading, References};
use elastogeo::files::load_campaign;
use elastogeo::noise::{ReferenceNoise, reference_noise, rigid_markers};
use elastogeo::simulation::generator;
use nalgebra::{Rotation3, Vector3};
use rand_distr::{Distribution, StandardNormal};

use super::cli::run;

const SIGMA: f64 = 5e-6;

/// Four reflectors at 30 times; `drift` and `turn` are the motion from first to last.
fn drawn(seed: u64, drift: Vector3<f64>, turn: f64) -> References {
    let mut random = generator(seed);
    let mut normal = || Distribution::<f64>::sample(&StandardNormal, &mut random);
    let places = [[2.0, 0.5, -0.5], [2.9, 0.8, -0.5], [2.7, 0.0, -0.6], [2.2, -0.4, 0.1]]
        .map(|at| Vector3::from_column_slice(&at));
    let mut readings = Vec::new();
    for epoch in 0..30 {
        let part = epoch as f64 / 29.0;
        let rotation = Rotation3::new(Vector3::new(0.0, 0.0, turn * part));
        for (reflector, place) in places.iter().enumerate() {
            let position = rotation * place + part * drift + Vector3::from_fn(|_, _| SIGMA * normal());
            readings.push(ReferenceReading { epoch, reflector, position });
        }
    }
    References {
        reflectors: ["a", "b", "c", "d"].map(String::from).to_vec(),
        epochs: 30,
        readings,
        ..References::default()
    }
}

fn found(references: &References) -> ReferenceNoise {
    reference_noise(references).expect("measured thirty times")
}

#[test]
fn noise_is_told_from_motion() {
    let (mut alarms, mut squares) = (0, 0.0);
    for seed in 0..100 {
        let still = found(&drawn(seed, Vector3::zeros(), 0.0));
        alarms += usize::from(still.motion.expect("four reflectors").p < 0.05);
        let moved = found(&drawn(seed, Vector3::new(0.0, 30e-6, 0.0), 2e-5));
        squares += moved.noise.sigma.powi(2) / 100.0;
        let motion = moved.motion.expect("four reflectors");
        assert!(motion.p < 1e-6 && motion.drift > 20e-6, "{motion:?}");
    }
    // 5 of 100 by chance; and the noise is not the motion's: 4 x 30 readings of 3, less 12 places and 29 motions of 6.
    assert!((1..=12).contains(&alarms), "{alarms}");
    assert!((squares.sqrt() / SIGMA - 1.0).abs() < 0.02, "{}", squares.sqrt());
    assert_eq!(found(&drawn(0, Vector3::zeros(), 0.0)).noise.degrees_of_freedom, 360.0 - 12.0 - 29.0 * 6.0);
}

#[test]
fn one_reflector_cannot_tell() {
    let mut references = drawn(1, Vector3::zeros(), 0.0);
    references.readings.retain(|reading| reading.reflector == 0);
    let alone = found(&references);
    assert!(alone.motion.is_none() && (alone.noise.sigma / SIGMA - 1.0).abs() < 0.4, "{alone:?}");
    references.readings.truncate(1);
    assert_eq!(reference_noise(&references), None);
    assert_eq!(reference_noise(&References::default()), None);
}

/// A campaign of two markers on a flange, with reflectors beside it that have moved.
#[test]
fn a_campaign_says_what_its_reflectors_show() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let simulated = run(
        folder.path(),
        &["simulate", "universal-ur5", "--poses", "40", "--noise", "0.03", "--unknown-base", "--into", "c"],
    );
    assert_eq!(simulated.status, 0, "{}", simulated.err);
    let mut table = "pose;order;reflector;x;y;z\n".to_string();
    for reading in drawn(3, Vector3::new(40e-6, 0.0, 0.0), 0.0).readings {
        let [x, y, z] = [0, 1, 2].map(|k| 1e3 * reading.position[k]);
        let name = ["a", "b", "c", "d"][reading.reflector];
        writeln!(table, "p{0};{0};{name};{x:.5};{y:.5};{z:.5}", reading.epoch).expect("written");
    }
    std::fs::write(at("c/references.csv"), &table).expect("written");
    let text = std::fs::read_to_string(at("c/campaign.yaml")).expect("read");
    std::fs::write(at("c/campaign.yaml"), text.clone() + "references: [{file: references.csv}]\n").expect("written");
    for command in ["check", "identify", "diagnose"] {
        let said = run(folder.path(), &[command, "c", "--format", "json"]);
        assert_eq!(said.status, 0, "{}", said.err);
        let json: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
        let codes: Vec<&str> =
            json["diagnostics"].as_array().expect("a list").iter().filter_map(|d| d["code"].as_str()).collect();
        assert!(codes.contains(&"references-moved"), "{command}: {codes:?}");
        // 0.03 mm are stated, and 0.005 seen: an instrument is no worse for that.
        assert!(!codes.contains(&"noise-disagrees"), "{command}: {codes:?}");
        if command == "check" {
            let sigma = json["without_robot"]["references"]["sigma"].as_f64().expect("a figure");
            assert!((sigma / 5e-3 - 1.0).abs() < 0.15, "{sigma}");
        }
    }
    // References of another campaign.
    std::fs::write(at("c/references.csv"), table.replace("\np", "\nother")).expect("written");
    let said = run(folder.path(), &["check", "c"]);
    assert!(said.status == 0 && said.err.contains("references of another campaign?"), "{}", said.err);
    std::fs::write(at("c/references.csv"), &table).expect("written");
    let stated = text.replace("sigma: 0.03", "sigma: 0.001") + "references: references.csv\n";
    std::fs::write(at("c/campaign.yaml"), stated).expect("written");
    let said = run(folder.path(), &["check", "c"]);
    assert!(said.status == 0 && said.err.contains("where the campaign states 0.0010 mm"), "{}", said.err);
    for (from, to, what) in
        [("reflector", "mirror", "the column `reflector` is missing"), (";x;", ";u;", "the column `x` is missing")]
    {
        std::fs::write(at("c/references.csv"), table.replacen(from, to, 1)).expect("written");
        let said = run(folder.path(), &["check", "c"]);
        assert!(said.status == 2 && said.err.contains(what), "{to}: {}", said.err);
    }
    std::fs::remove_file(at("c/references.csv")).expect("removed");
    let said = run(folder.path(), &["check", "c"]);
    assert!(said.status == 2 && said.err.contains("references.csv"), "{}", said.err);
}

/// A base that creeps while a gear ratio is wrong: reflectors that creep with it speak for the drift, reflectors that stand still against it.
#[test]
fn reflectors_speak_for_a_drift_and_against_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    // From the start to the end it creeps by 0.25 mm.
    let creep = 4e-8;
    let effects = format!(
        "effects:\n- {{effect: gear-ratio, site: joint:2, parameters: {{ratio: 6e-4}}}}\n\
         - {{effect: frame-drift, site: base, parameters: {{x: {creep}}}}}\n"
    );
    let plain = run(folder.path(), &["convert", "universal-ur5", "plain.yaml"]);
    assert_eq!(plain.status, 0, "{}", plain.err);
    let text = std::fs::read_to_string(at("plain.yaml")).expect("read");
    std::fs::write(at("arm.yaml"), text + &effects).expect("written");
    let flags = ["--poses", "80", "--noise", "0.02", "--errors", "0", "--unknown-base", "--conditions", "--seed", "5"];
    let made = run(folder.path(), &[&["simulate", "arm.yaml", "--into", "c"][..], &flags].concat());
    assert_eq!(made.status, 0, "{}", made.err);
    let mut reader = csv::Reader::from_path(at("c/measurements.csv")).expect("a table");
    let column = reader.headers().expect("a header").iter().position(|name| name == "time").expect("times");
    let times: Vec<f64> = reader.records().map(|row| row.expect("a row")[column].parse().expect("a number")).collect();
    let campaign = std::fs::read_to_string(at("c/campaign.yaml")).expect("read");
    // On the pedestal reflectors that stand still do not speak against a robot that creeps on it.
    let pedestal = "{file: references.csv, on: pedestal}";
    for (moves, file, is_drift) in
        [(1.0, "references.csv", true), (0.0, "references.csv", false), (0.0, pedestal, true), (1.0, pedestal, true)]
    {
        std::fs::write(at("c/campaign.yaml"), format!("{campaign}references: {file}\n")).expect("written");
        let shift = |reading: &ReferenceReading| Vector3::new(1e3 * moves * creep * times[reading.epoch], 0.0, 0.0);
        let mut table = "pose;reflector;x;y;z\n".to_string();
        let all = (0..3).flat_map(|block| {
            let own = drawn(7 + block, Vector3::zeros(), 0.0).readings.into_iter();
            own.map(move |reading| ReferenceReading { epoch: reading.epoch + 30 * block as usize, ..reading })
        });
        for reading in all.filter(|own| own.epoch < times.len()) {
            let [x, y, z] = (1e3 * reading.position + shift(&reading)).into();
            let name = ["a", "b", "c", "d"][reading.reflector];
            writeln!(table, "p{:03};{name};{x:.5};{y:.5};{z:.5}", reading.epoch + 1).expect("written");
        }
        std::fs::write(at("c/references.csv"), &table).expect("written");
        let said = run(folder.path(), &["diagnose", "c", "--robot", "plain.yaml", "--format", "json"]);
        let json: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
        let is_in = |list: &str, site: &str| {
            let all = json[list].as_array().expect("a list").iter();
            all.into_iter().any(|one| one["effect"] == "frame-drift" && one["site"] == site)
        };
        assert_eq!(is_in("causes", "base"), is_drift, "{}", json["causes"]);
        assert_eq!(is_in("excluded", "base"), !is_drift, "{}", json["excluded"]);
        // What they do speak against is that the instrument moved; or for it, where they move as much.
        assert_eq!(is_in("excluded", "instrument"), file == pedestal && moves == 0.0, "{}", json["excluded"]);
        let remedies = json["causes"].to_string();
        let is_of_instrument = remedies.contains("reflectors beside the robot moved as much");
        assert_eq!(is_of_instrument, file == pedestal && moves > 0.0, "{remedies}");
    }
}

/// A real arm: reflectors on the base crept by some 50 um over the run, and distances between those of the tool scatter by 4
/// to 7 um; see the data's notes.
#[test]
fn reflectors_of_a_real_cell() {
    let Some(data) = folder("irb120-faro") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let data = Path::new(&data).canonicalize().expect("a folder");
    let text = format!(
        "robot: {0}/robot.yaml\nunits: {{length: mm, angle: deg}}\nobserves: position\nestimate: {{base: true, tool: true}}\n\
         measurements: {0}/measurements.csv\nreferences: {0}/base-reflectors.csv\n",
        data.display()
    );
    let path = folder.path().join("campaign.yaml");
    std::fs::write(&path, text).expect("written");
    let loaded = load_campaign(&path.to_string_lossy(), None).expect("read");
    let scatter =
        2.0_f64.sqrt() * rigid_markers(&loaded.robot.model, &loaded.campaign).expect("three on the tool").sigma;
    assert!((4e-6..7e-6).contains(&scatter), "{scatter}");
    let motion = found(&loaded.campaign.references).motion.expect("three on the base");
    assert!((45e-6..60e-6).contains(&motion.drift) && motion.p < 1e-9, "{motion:?}");
}

/// Where noise is not stated, what is used instead is said by `identify`, in text and JSON, and by `check`.
#[test]
fn noise_that_is_not_stated_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "universal-ur5", "--poses", "40", "--observes", "pose", "--into", "c"];
    assert_eq!(run(at, &made).status, 0);
    let file = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&file).expect("text");
    let said = |text: &str| -> (String, serde_json::Value, String) {
        std::fs::write(&file, text).expect("written");
        let json = run(at, &["identify", "c", "--format", "json"]).out;
        let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        (run(at, &["identify", "c"]).out, json["noise_sources"].clone(), run(at, &["check", "c"]).out)
    };
    let (told, sources, checked) = said(&text);
    assert!(!told.contains("not stated") && !checked.contains("weighed by what a fit leaves"), "{told}");
    assert_eq!((&sources["position"], &sources["orientation"]), (&"stated".into(), &"stated".into()));
    let without: Vec<&str> = text.lines().filter(|line| !line.starts_with("  orientation:")).collect();
    assert_ne!(without.len(), text.lines().count());
    let (told, sources, checked) = said(&(without.join("\n") + "\n"));
    assert!(
        told.contains("noise of orientations not stated") && checked.contains("weighed by what a fit leaves"),
        "{told}"
    );
    assert_eq!((&sources["position"], &sources["orientation"]), (&"stated".into(), &"residuals".into()));
}
