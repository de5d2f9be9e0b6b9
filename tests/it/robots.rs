//! Every description under `robots/`, found by itself: a snapshot of its meaning, and its way back to files.

use elastogeo::description::campaign::raw::{RawCampaign, RawEntry, RawKinds};
use elastogeo::description::raw::RawRobot;
use elastogeo::description::resolve::resolve;
use elastogeo::description::{urdf, yaml};
use elastogeo::effects::Catalogue;
use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::{Model, build, with_values};
use elastogeo::observation::{FAMILY, Kinds};
use elastogeo::simulation::{draw_configurations, draw_errors, generator};
use elastogeo::snapshot::snapshot;

use super::support::{KR270_MASSES, heavy_kr270};

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

/// Parameters are known by name, so that a marker cannot be called as the mass of a body is.
#[test]
fn a_marker_and_a_body_of_one_name_are_refused() {
    let text = "frames: {6: {antecedent: 0, joint: revolute, variable: q, d: 1}}\n\
                bodies: {6: {mass: 2, com: [0.1, 0.2, 0.3]}}\n\
                markers: {body6: {at: [1, 2, 3]}}\n";
    let raw: RawRobot = yaml::read("robot.yaml", text).0.expect("readable");
    let (refused, diagnostics) = resolve(&raw, &|_| None);
    assert!(refused.is_none());
    assert_eq!(diagnostics.len(), 1, "{diagnostics:?}");
    assert!(diagnostics[0].message.contains("two parameters would be called `body6.x`"), "{}", diagnostics[0]);
    assert!(diagnostics[0].remedy.as_ref().is_some_and(|remedy| remedy.contains("rename")), "{}", diagnostics[0]);
    let renamed: RawRobot = yaml::read("robot.yaml", &text.replace("body6", "ball")).0.expect("readable");
    assert!(resolve(&renamed, &|_| None).0.is_some());
}

/// A variable is a column of tables of measurements, and these have columns of their own.
#[test]
fn a_variable_with_the_name_of_a_column_is_refused() {
    let description = |name: &str| -> RawRobot {
        let text = format!("frames: {{1: {{antecedent: 0, joint: prismatic, variable: {name}}}}}\n");
        yaml::read("robot.yaml", &text).0.expect("readable")
    };
    let robot = resolve(&description("q"), &|_| None).0.expect("resolved");
    for observes in FAMILY {
        let raw = RawCampaign { observes: Some(RawKinds::one(observes)), ..Default::default() };
        let entry = raw.completed(&RawEntry::default());
        for column in elastogeo::description::campaign::expected_columns(&raw, &entry, &robot, &Kinds::standard()) {
            let is_other = observes.other_columns().iter().any(|other| other.name == column.name);
            if column.name != "q" && !is_other {
                let (refused, diagnostics) = resolve(&description(&column.name), &|_| None);
                assert!(refused.is_none(), "{}", column.name);
                assert!(diagnostics[0].message.contains("name of a column"), "{}", diagnostics[0]);
                assert!(diagnostics[0].remedy.is_some());
            }
        }
    }
    for name in ["zeta", "lift", "q1", "time_axis"] {
        assert!(resolve(&description(name), &|_| None).0.is_some(), "{name}");
    }
}

/// Every number of a description that means something is in its snapshot.
#[test]
fn a_snapshot_sees_every_change() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = heavy_kr270(
        folder.path(),
        &format!(
            "{KR270_MASSES}anchors: {{pole: [1000, 2000, 300]}}\nlimits: {{q3 - q2: [-10, 300]}}\n\
             effects: [{{effect: backlash, site: \"joint:4\", parameters: {{half_width: 1e-4}}}}]\n\
             calibration: {{tolerances: {{3.d: 0.5}}}}\n"
        ),
    );
    let text = std::fs::read_to_string(&path).expect("a file");
    let of = |text: &str| {
        std::fs::write(&path, text).expect("written");
        let loaded = load_robot(&path)
            .unwrap_or_else(|faults| panic!("{}", elastogeo::render::diagnostics::render(&faults, false)));
        snapshot(&loaded.model).expect("a snapshot")
    };
    let before = of(&text);
    assert_eq!(before, of(&text), "the same text of the same description");
    let changes = [
        ("compliance: 0.302e-6", "compliance: 0.902e-6"),
        ("free_length: 458", "free_length: 459"),
        ("[1000, 2000, 300]", "[1000, 2000, 301]"),
        ("[-10, 300]", "[-10, 301]"),
        ("half_width: 1e-4", "half_width: 2e-4"),
        ("joint:4", "joint:5"),
    ];
    for (old, new) in changes {
        assert!(text.contains(old), "{old}");
        assert_ne!(before, of(&text.replace(old, new)), "{old} -> {new}");
    }
    // Single numbers of what is declared in lists: markers, masses, centres, anchors of the compensator.
    let mut raw = load_robot(&path).expect("read").raw;
    let snapshot_of = |raw: &RawRobot| {
        let robot = resolve(raw, &|_| None).0.expect("resolved");
        snapshot(&build(&robot, Catalogue::standard()).expect("compiled")).expect("a snapshot")
    };
    let before = snapshot_of(&raw);
    let mut seen = |change: &dyn Fn(&mut RawRobot), what: &str| {
        let kept = raw.clone();
        change(&mut raw);
        assert_ne!(kept, raw, "{what}");
        assert_ne!(before, snapshot_of(&raw), "{what}");
        raw = kept;
    };
    seen(&|raw| raw.markers[0].at = raw.markers[0].at.map(|[x, y, z]| [x, y, z + 0.01]), "a marker");
    seen(&|raw| raw.markers[0].frame = Some("3".into()), "the frame of a marker");
    seen(&|raw| raw.bodies[0].mass = raw.bodies[0].mass.map(|mass| mass * 1.001), "a mass");
    seen(&|raw| raw.bodies[0].com = raw.bodies[0].com.map(|[x, y, z]| [x, y + 0.01, z]), "a centre");
    seen(&|raw| raw.springs[0].anchors = raw.springs[0].anchors.map(|[a, b]| [a, b.map(|v| v + 0.01)]), "an anchor");
    seen(&|raw| raw.springs[0].acts = Some(elastogeo::description::raw::SpringAction::Full), "what acts");
    seen(&|raw| raw.gravity = Some([0.0, 1.0, -9.7]), "gravity");
    seen(&|raw| raw.calibration.tolerances[0] *= 1.5, "a tolerance");
}
