//! Campaigns with loads from the files' side: geometry and stiffness from one absolute campaign, and identified stiffness
//! that goes back to a description and is read again.

use elastogeo::estimation::{Settings, What, calibrate};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::observation::POSITION;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use rand::RngExt;

use crate::cli::run;
use crate::support::{KR270_MASSES, heavy_kr270, printed_json};

#[test]
fn geometry_and_stiffness_come_from_one_absolute_campaign() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = heavy_kr270(folder.path(), KR270_MASSES);
    let loaded = load_robot(&path)
        .unwrap_or_else(|diagnostics| panic!("{}", elastogeo::render::diagnostics::render(&diagnostics, false)));
    let model = &loaded.model;
    assert!(!model.structure.masses.is_empty() && model.structure.gravity.norm() > 9.0);
    let mut random = generator(27);
    let mut truth = draw_errors(model, 1.0, 0.5, &mut random);
    for k in 0..6 {
        truth[model.base + k] += random.random::<f64>() - 0.5;
    }
    let geometry = Geometry::nominal(model).expect("assembled");
    let plan = Plan {
        conditions: false,
        wrenches: [[0.0, 0.0, 0.0], [0.0, 0.0, -2500.0], [0.0, 2500.0, 0.0], [2500.0, 0.0, 0.0]]
            .map(|[x, y, z]| [x, y, z, 0.0, 0.0, 0.0])
            .to_vec(),
        configurations: draw_configurations(&geometry, 60, 0.8, &mut random).expect("drawn"),
        markers: vec![Some(0), Some(1), Some(2)],
        repeats: 1,
        observes: POSITION,
        sigma: 30e-6,
        sigma_orientation: 0.0,
        estimate: [true, true],
    };
    let campaign = simulate(model, &truth, &plan, &mut random).expect("simulated");
    let held_out: Vec<bool> = campaign.readings.iter().map(|reading| reading.pose >= 40).collect();
    let what = Some(What { geometric: true, elastic: true });
    let found =
        calibrate(model, &campaign, &held_out, &Settings { what, ..Settings::default() }, &mut |_| {}).expect("fitted");
    let [fit, check] = [found.after.fit, found.after.check].map(|errors| errors.coordinate[0]);
    println!(
        "noise ratio {:.4}; coordinate rms {fit:.2e} m fitted, {check:.2e} m on poses not seen; kept {} of {}",
        found.noise_ratio,
        found.identifiability.kept.len(),
        found.slots.len()
    );
    assert!(found.converged() && (found.noise_ratio - 1.0).abs() < 0.03, "{} {}", found.ending, found.noise_ratio);
    assert!((check / 30e-6 - 1.0).abs() < 0.1, "{check:e}");
    let mut springs = 0;
    for estimate in &found.estimates {
        let parameter = &model.registry[estimate.slot];
        if model.elastic_slots().contains(&estimate.slot) {
            let away = (estimate.value - truth[estimate.slot]).abs();
            let ci95 = estimate.ci95.expect("identifiable");
            println!("{}: {:.4e} of {:.4e} +- {ci95:.1e}", parameter.name, estimate.value, truth[estimate.slot]);
            assert!(away < 2.0 * ci95, "{}", parameter.name);
            springs += 1;
        }
    }
    assert_eq!(springs, 7);
}

#[test]
fn identified_stiffness_goes_back_to_the_description_and_is_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let root = env!("CARGO_MANIFEST_DIR");
    let ir663 = std::fs::read_to_string(format!("{root}/robots/kuka-ir663.yaml")).expect("a file");
    // A beam's section to be found as well, in addition to springs declared as values.
    std::fs::write(at.join("ir663.yaml"), ir663.replace("calibration: {", "calibration: {free: [arm.width], "))
        .expect("written");
    heavy_kr270(at, "\ncalibration: {free: [compensator.free_length]}\n");
    let cases: [(&str, &str, &[&str]); 2] = [
        ("ir663.yaml", "wrist", &["--wrench=900,0,0", "--wrench=0,0,-900", "--wrench=0,900,0"]),
        ("heavy.yaml", "m1,m2,m3", &["--wrench=0,0,-2500", "--wrench=0,2500,0", "--wrench=2500,0,0"]),
    ];
    for (robot, markers, wrenches) in cases {
        let simulate = ["simulate", robot, "--poses", "30", "--observes", "deflection", "--markers", markers];
        let more = ["--noise", "0.03", "--errors", "0", "--elastic-errors", "0.5", "--share", "0.6", "--into", "c"];
        let ran = run(at, &[&simulate[..], &more, wrenches].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
        let first = printed_json(at, &["identify", "c", "--what", "elastic", "--save", "once.yaml"]);
        let kept: Vec<&str> = first["parameters"]
            .as_array()
            .expect("parameters")
            .iter()
            .filter(|p| p["identifiable"] == true)
            .map(|p| p["name"].as_str().expect("a name"))
            .collect();
        println!("{robot}: {kept:?}");
        let wanted = if robot == "ir663.yaml" { "arm.width" } else { "compensator.free_length" };
        assert!(kept.contains(&wanted), "{kept:?}");
        let [fit, check] =
            ["after", "check_after"].map(|which| first["residuals"][which]["rms"].as_f64().expect("rms"));
        let again = printed_json(at, &["residuals", "once.yaml", "c"]);
        for (which, expected) in [("fit", fit), ("check", check)] {
            let found = again[which]["rms"].as_f64().expect("rms");
            assert!((found / expected - 1.0).abs() < 1e-9, "{robot} {which}: {found} {expected}");
        }
        let second =
            printed_json(at, &["identify", "c", "--robot", "once.yaml", "--what", "elastic", "--save", "twice.yaml"]);
        assert!((second["residuals"]["after"]["rms"].as_f64().expect("rms") / fit - 1.0).abs() < 1e-6, "{robot}");
        let twice = printed_json(at, &["residuals", "twice.yaml", "c"]);
        assert!((twice["fit"]["rms"].as_f64().expect("rms") / fit - 1.0).abs() < 1e-6, "{robot}");
        let ran = run(at, &["check", "twice.yaml"]);
        assert_eq!(ran.status, 0, "{}", ran.err);
    }
}
