//! Every description under `robots/`, found by itself: a snapshot of its meaning, and its way back to files.

use elastogeo::description::raw::RawRobot;
use elastogeo::description::resolve::resolve;
use elastogeo::description::{urdf, yaml};
use elastogeo::effects::Catalogue;
use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::{Model, build, with_values};
use elastogeo::simulation::{draw_configurations, draw_errors, generator};
use elastogeo::snapshot::snapshot;

fn descriptions() -> Vec<(String, String)> {
    let folder = format!("{}/robots", env!("CARGO_MANIFEST_DIR"));
    let mut found: Vec<(String, String)> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "yaml"))
        .map(|path| (path.file_stem().expect("a name").to_string_lossy().into_owned(), path.display().to_string()))
        .collect();
    found.sort();
    assert!(found.len() >= 5);
    found
}

#[test]
fn descriptions_mean_what_they_meant() {
    for (name, path) in descriptions() {
        let loaded = load_robot(&path)
            .unwrap_or_else(|diagnostics| panic!("{}", elastogeo::render::diagnostics::render(&diagnostics, false)));
        assert!(loaded.diagnostics.is_empty(), "{name}: {:?}", loaded.diagnostics);
        insta::assert_snapshot!(name, snapshot(&loaded.model).expect("a snapshot"));
    }
}

/// Greatest difference between the frames of two models that share names, at drawn configurations.
fn difference(a: &Model, b: &Model, configurations: &[Vec<f64>]) -> f64 {
    let (ga, gb) = (Geometry::nominal(a).expect("assembled"), Geometry::nominal(b).expect("assembled"));
    let (mut pa, mut pb) = (Placements::default(), Placements::default());
    let mut greatest = 0.0_f64;
    for q in configurations {
        ga.place(q, &mut pa).expect("placed");
        gb.place(q, &mut pb).expect("placed");
        for (index, frame) in a.frames.iter().enumerate() {
            let other = b.frame(&frame.name).unwrap_or_else(|| panic!("no frame {}", frame.name));
            greatest =
                greatest.max((pa.frames[index].to_homogeneous() - pb.frames[other].to_homogeneous()).abs().max());
        }
        let tools = (pa.frames[a.tool.0] * ga.tool(), pb.frames[b.tool.0] * gb.tool());
        greatest = greatest.max((tools.0.to_homogeneous() - tools.1.to_homogeneous()).abs().max());
        for m in 0..a.markers.len().min(b.markers.len()) {
            let points = (pa.frames[a.markers[m].frame] * ga.marker(m), pb.frames[b.markers[m].frame] * gb.marker(m));
            greatest = greatest.max((points.0 - points.1).norm());
        }
    }
    greatest
}

#[test]
fn a_calibrated_robot_written_as_yaml_and_urdf_is_the_same_robot() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, path) in descriptions() {
        let loaded = load_robot(&path).expect("readable");
        let mut values = draw_errors(&loaded.model, 1.0, 0.0, &mut generator(5));
        let (base, tool) = (loaded.model.base, loaded.model.tool.1);
        values[base..base + 6].iter_mut().enumerate().for_each(|(k, value)| *value += 0.1 + 0.01 * k as f64);
        values[tool..].iter_mut().for_each(|value| *value += 0.003);
        let mut calibrated = loaded.model.clone();
        for (parameter, value) in calibrated.registry.all_mut().iter_mut().zip(&values) {
            parameter.nominal = *value;
        }
        let configurations =
            draw_configurations(&Geometry::nominal(&calibrated).expect("assembled"), 20, 0.7, &mut generator(6))
                .expect("drawn");
        let raw = with_values(&loaded.raw, &loaded.model, &values);
        let yaml_path = folder.path().join(format!("{name}.yaml"));
        std::fs::write(&yaml_path, yaml::write(&raw).expect("YAML")).expect("written");
        let again = load_robot(&yaml_path.display().to_string())
            .unwrap_or_else(|r| panic!("{}", elastogeo::render::diagnostics::render(&r, false)));
        let away = difference(&calibrated, &again.model, &configurations);
        assert!(away < 1e-12, "{name} as YAML: {away:e}");
        let base = Geometry::nominal(&again.model).expect("assembled").base().to_homogeneous();
        let expected = Geometry::new(&loaded.model, &values).expect("assembled").base().to_homogeneous();
        assert!((base - expected).abs().max() < 1e-14, "{name}: the base");

        // URDF cannot hold what closes a loop or drives a joint through a screw.
        if loaded.raw.loops.is_empty() && loaded.raw.actuators.is_empty() {
            let (text, _) = urdf::export(&raw).expect("URDF");
            let urdf_path = folder.path().join(format!("{name}.urdf"));
            std::fs::write(&urdf_path, text).expect("written");
            let again = load_robot(&urdf_path.display().to_string())
                .unwrap_or_else(|r| panic!("{}", elastogeo::render::diagnostics::render(&r, false)));
            let away = difference(&calibrated, &again.model, &configurations);
            assert!(away < 1e-12, "{name} as URDF: {away:e}");
        }
    }
}

/// Parameters are distinguished by their owner: a marker may be called as the mass of a body is, and a calibration that
/// names the two alike is refused.
#[test]
fn a_marker_and_a_body_of_one_name_stay_two_things() {
    let text = "frames: {6: {antecedent: 0, joint: revolute, variable: q, d: 1}}\n\
                bodies: {6: {mass: 2, com: [0.1, 0.2, 0.3]}}\n\
                markers: {body6: {at: [1, 2, 3]}}\n";
    let raw: RawRobot = yaml::read("robot.yaml", text).0.expect("readable");
    let robot = resolve(&raw, &|_| None).0.expect("resolved");
    let model = build(&robot, Catalogue::standard()).expect("compiled");
    let mut values = model.registry.nominal();
    values[model.markers[0].slot + 1] = 7.0;
    let written = with_values(&raw, &model, &values);
    assert_eq!(written.markers["body6"].at, Some([1.0, 7.0, 3.0]));
    assert_eq!(written.bodies["6"].com, Some([0.1, 0.2, 0.3]));

    let mut raw = raw;
    raw.calibration.free.push("body6.x".into());
    let (refused, diagnostics) = resolve(&raw, &|_| None);
    assert!(refused.is_none());
    assert!(diagnostics[0].message.contains("names two parameters"), "{}", diagnostics[0]);
}
