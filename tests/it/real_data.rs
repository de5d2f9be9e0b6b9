//! Measured data of real robots, read in place where they are present.

use elastogeo::estimation::{Calibration, Settings, calibrate, split};
use elastogeo::files::load_campaign;
use elastogeo::math::median;

use crate::figures::recorded;

/// The folder of a set of measurements, or `None`; the test that skips what it would have checked is then counted by `tests/skipped.rs`.
pub fn folder(name: &str) -> Option<String> {
    let root =
        std::env::var("ELASTOGEO_DATA").unwrap_or_else(|_| format!("{}/../shared/data", env!("CARGO_MANIFEST_DIR")));
    let folder = format!("{root}/{name}");
    if std::path::Path::new(&folder).is_dir() {
        Some(folder)
    } else {
        // Where any measurements are, all of them have to be.
        assert!(!std::path::Path::new(&root).is_dir(), "{folder} is missing from {root}");
        let noted = concat!(env!("CARGO_TARGET_TMPDIR"), "/skipped");
        let test = std::thread::current().name().unwrap_or("a test").replace("::", ".");
        std::fs::create_dir_all(noted).and_then(|()| std::fs::write(format!("{noted}/{test}"), "")).expect("noted");
        println!("skipped: no data at {folder}");
        None
    }
}

fn calibrated(name: &str) -> Option<Calibration> {
    let loaded = load_campaign(&folder(name)?, None)
        .unwrap_or_else(|diagnostics| panic!("{}", elastogeo::render::diagnostics::render(&diagnostics, false)));
    let held_out = split(&loaded.campaign, 0.25, 1);
    Some(
        calibrate(&loaded.robot.model, &loaded.campaign, &held_out, &Settings::default(), &mut |_| {})
            .expect("calibrated"),
    )
}

/// Holds the record of an arm: its error (m) on held-out readings, registered and calibrated.
fn kept(arm: &str, what: &str, [registered, calibrated]: [f64; 2]) {
    let found = format!("{arm}: {what} {:.4} mm registered, {:.4} mm calibrated", 1e3 * registered, 1e3 * calibrated);
    recorded(&format!("measured-{arm}"), "cargo test real_data", &[found]);
}

#[test]
fn ur5_blind_poses() {
    let Some(found) = calibrated("ur5-jacobi") else { return };
    kept("UR5", "mean", [&found.registration, &found.after].map(|errors| errors.check.distance[0]));
    assert_eq!(found.identifiability.rank, 27);
    assert!(found.after.check.distance[0] <= 0.105e-3, "mean {}", found.after.check.distance[0]);
}

#[test]
fn ur10_held_out_poses() {
    let Some(found) = calibrated("ur10-landgraf") else { return };
    kept("UR10", "rms", [&found.registration, &found.after].map(|errors| errors.check.distance[1]));
    assert_eq!(found.identifiability.rank, 30);
    assert!(found.after.check.distance[1] <= 0.4255e-3, "rms {}", found.after.check.distance[1]);
}

/// The 0.421 mm reported elsewhere for this check set is below what these parameters leave when fitted on it.
#[test]
fn ur10_check_set_fitted_on_itself() {
    let Some(folder) = folder("ur10-landgraf") else { return };
    let loaded = load_campaign(&folder, None).expect("readable");
    let fit_instead: Vec<bool> = split(&loaded.campaign, 0.25, 1).into_iter().map(|check| !check).collect();
    let found = calibrate(&loaded.robot.model, &loaded.campaign, &fit_instead, &Settings::default(), &mut |_| {})
        .expect("calibrated");
    let rms = found.after.fit.distance[1];
    recorded("ur10-check-set", "cargo test ur10_check_set", &[format!("{:.4} mm rms fitted on itself", 1e3 * rms)]);
    assert!((0.4215e-3..0.4235e-3).contains(&rms), "rms {rms}");
}

#[test]
fn wam_random_poses() {
    let Some(found) = calibrated("wam-jacobi") else { return };
    kept("WAM", "rms", [&found.registration, &found.after].map(|errors| errors.check.distance[1]));
    assert!(found.after.check.distance[1] <= 3.295e-3, "rms {}", found.after.check.distance[1]);
}

#[test]
fn ur5_from_twenty_training_poses() {
    let Some(folder) = folder("ur5-jacobi") else { return };
    let loaded = load_campaign(&folder, None).expect("readable");
    let check = split(&loaded.campaign, 0.25, 1);
    let mut means: Vec<f64> = (0..10)
        .map(|seed| {
            use rand::seq::SliceRandom;
            let mut fit: Vec<usize> = (0..check.len()).filter(|&i| !check[i]).collect();
            fit.shuffle(&mut elastogeo::simulation::generator(seed));
            fit.truncate(20);
            let few = loaded.campaign.select(|i, _| check[i] || fit.contains(&i));
            let held_out = split(&few, 0.25, 1);
            let found =
                calibrate(&loaded.robot.model, &few, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated");
            found.after.check.distance[0]
        })
        .collect();
    let median = median(&mut means).expect("some");
    let found = format!("median of the mean errors of 10 draws {:.4} mm", 1e3 * median);
    recorded("ur5-twenty-poses", "cargo test ur5_from_twenty", &[found]);
    assert!(median <= 0.14e-3, "median {median}");
}

/// The first twenty readings of this run are of one posture; what a rigid model misses there is no step of a joint's zero.
#[test]
fn iiwa_in_one_posture_first_has_not_moved() {
    let Some(data) = folder("iiwa7-payload") else { return };
    let arguments = ["identify", &format!("{data}/unloaded.yaml")];
    let found = crate::support::printed_json(std::path::Path::new("."), &arguments);
    let told = found["diagnostics"].as_array().expect("a list").iter();
    let moved: Vec<&serde_json::Value> = told.filter(|one| one["code"] == "moved-midway").collect();
    assert!(moved.is_empty(), "{moved:?}");
}

/// What a diagnosis of the iiwa 7 without a payload writes predicts it with 5 kg, base and tool anew, whatever noise of the
/// instrument is stated; nominal 1.90 mm. The payload is outside the range of the campaign, which is said.
#[test]
fn iiwa_diagnosed_without_a_payload_predicts_it_with_one() {
    let Some(data) = folder("iiwa7-payload") else { return };
    let at = tempfile::tempdir().expect("a folder");
    let ran = |arguments: &[&str]| {
        let ran = crate::cli::run(at.path(), arguments);
        assert_eq!(ran.status, 0, "{arguments:?}: {}", ran.err);
        serde_json::from_str::<serde_json::Value>(&ran.out).expect("JSON")
    };
    let head = format!(
        "robot: {data}/robot.yaml\nunits: {{length: mm, angle: rad}}\nobserves: pose\nestimate: {{base: true, tool: true}}\n"
    );
    let torques: Vec<String> = (1..=7).map(|k| format!("torque.q{k}")).collect();
    let ignore = format!("ignore: [{}]\n", torques.join(", "));
    let loaded = format!(
        "{head}instrument: {{sigma: 0.3, orientation: 1.0e-3}}\ncalibrate: []\n{ignore}payloads: {{block: {{mass: 5, com: [0, 0, 50], frame: \"7\"}}}}\n\
         measurements: [{{file: {data}/payload-5kg.csv, payload: block}}]\n"
    );
    std::fs::write(at.path().join("loaded.yaml"), loaded).expect("written");
    let mut lines = Vec::new();
    for stated in ["", "instrument: {sigma: 0.05}\n", "instrument: {sigma: 0.3}\n"] {
        let unloaded =
            format!("{head}{stated}calibrate: [geometry, joint-offset]\n{ignore}measurements: {data}/unloaded.csv\n");
        std::fs::write(at.path().join("unloaded.yaml"), unloaded).expect("written");
        let said = ran(&["diagnose", "unloaded.yaml", "--apply", "applied.yaml", "--format", "json"]);
        let first = &said["causes"][0];
        let at = |name: &str| at.path().join(name).display().to_string();
        let loaded = elastogeo::files::load_campaign(&at("loaded.yaml"), Some(&at("applied.yaml"))).expect("readable");
        let (model, campaign) = (&loaded.robot.model, &loaded.campaign);
        // The curve bends where the payload pushes beyond it, so that the last digits of the fit may take long.
        let settings = Settings { only: Some(Vec::new()), ..Settings::default() };
        let found = calibrate(model, campaign, &split(campaign, 0.25, 1), &settings, &mut |_| {}).expect("registered");
        let rms = 1e3 * found.after.check.distance[1];
        assert!(loaded.outside().is_some() && rms <= 0.80, "{stated}: {rms} mm, {said}");
        lines.push(format!(
            "{}: first {} at {}, with 5 kg {rms:.4} mm",
            if stated.is_empty() { "no noise stated" } else { stated.trim() },
            first["effect"].as_str().expect("an effect"),
            first["site"].as_str().expect("a site"),
        ));
    }
    recorded("applied-iiwa7", "cargo test iiwa_diagnosed", &lines);
}

/// Where joints are what was commanded, the cause is known: compliances of joints under the arm's own weight, those of joints 2
/// and 3 most. Curves of the rest take no name from them, and nothing moves base, link or tool.
#[test]
fn commanded_joints_give_under_their_own_weight() {
    let Some(folder) = folder("irb120-faro") else { return };
    let ran = crate::cli::run(
        std::path::Path::new("."),
        &["diagnose", &format!("{folder}/commanded.yaml"), "--format", "json"],
    );
    let found: serde_json::Value = serde_json::from_str(&ran.out).expect("JSON");
    let causes = found["causes"].as_array().expect("a list");
    let named: Vec<(&str, &str)> = causes
        .iter()
        .map(|cause| (cause["effect"].as_str().expect("a name"), cause["site"].as_str().expect("a site")))
        .collect();
    assert_eq!(named[..2], [("joint-compliance", "joint:2"), ("joint-compliance", "joint:3")], "{named:?}");
    assert!(causes.iter().all(|cause| cause["family"] == "elastic"), "{named:?}");
    assert!(found["after_all"]["rms"].as_f64().is_some_and(|rms| rms < 0.107), "{}", found["after_all"]);
}

/// Where joints are what the controller had recorded, two causes are known: it was read before the arm had settled, and the joints give under the
/// arm's own weight. Each is one cause at several joints. The commanded joints, which the diagnosis does not see, show what each joint lacked: by
/// least squares of another program 1.27, 1.16 and 0.79 mrad at joints 1 to 3, times the move over the greatest of all joints.
#[test]
fn recorded_joints_lag_and_give() {
    let Some(folder) = folder("irb120-faro") else { return };
    let arguments = ["diagnose", &format!("{folder}/campaign.yaml")];
    let found = crate::support::printed_json(std::path::Path::new("."), &arguments);
    let causes = found["causes"].as_array().expect("a list");
    let of = |effect: &str| -> Vec<&str> {
        let own = causes.iter().filter(|cause| cause["effect"] == effect && cause["level"] == "law");
        own.map(|cause| cause["site"].as_str().expect("a site")).collect()
    };
    let [mut lags, mut springs] = [of("settling"), of("joint-compliance")];
    lags.sort_unstable();
    springs.sort_unstable();
    assert_eq!(lags, ["joints"], "{causes:?}");
    assert_eq!(springs, ["joint:2", "joint:3", "joint:4", "joint:5"], "{causes:?}");
    assert!(causes.iter().all(|cause| cause["effect"] != "link-compliance"), "{causes:?}");
    let lag = causes.iter().find(|cause| cause["effect"] == "settling").expect("the lag");
    for (parameter, shown) in lag["parameters"].as_array().expect("a list").iter().zip([1.27e-3, 1.16e-3, 0.79e-3]) {
        let value = parameter["value"].as_f64().expect("a number");
        assert!((value / shown - 1.0).abs() < 0.4, "{parameter}");
    }
    assert!(found["after_all"]["rms"].as_f64().is_some_and(|rms| rms < 0.31), "{}", found["after_all"]);
}
