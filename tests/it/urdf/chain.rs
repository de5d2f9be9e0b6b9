//! `urdf: {file, from, to, fixed}`: poses, masses and gravity of the chain against products of the URDF's own transforms.

use std::path::Path;

use elastogeo::description::raw::RawRobot;
use elastogeo::description::urdf::{export_into, import};
use elastogeo::diagnostic::Diagnostic;
use elastogeo::files::{LoadedRobot, Reader, load_robot};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::with_values;
use nalgebra::{Isometry3, Vector3};

use super::forward::{Values, apart, of_urdf};

const TORSO: &str = include_str!("../../data/urdf/torso.urdf");
const CHAIN: &str = "
urdf: {file: torso.urdf, from: shoulder_plate, to: tool0, fixed: {finger_joint1: 30, lean: 10}}
units: {length: mm, angle: deg}
markers:
  tip: {at: [10, 0, 5]}
  left: {frame: finger1, at: [0, 5, 40]}
  joint: {frame: strut, at: [1, 2, 3]}
";

/// The description with the URDF beside it.
fn read(text: &str) -> Result<LoadedRobot, Vec<Diagnostic>> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("torso.urdf"), TORSO).unwrap();
    Reader::default().robot_text(&folder.path().join("arm.yaml"), text).map_err(Into::into)
}

/// Values of every joint of the URDF at a configuration a1, a2, extend, a5 of the chain.
fn of_joints(q: &[f64]) -> Values {
    let held = [("lift", 0.1), ("lean", 10_f64.to_radians()), ("finger_joint1", 0.03), ("hip", 0.3)];
    let moving = ["a1", "a2", "extend", "a5"].into_iter().zip(q.iter().copied());
    held.into_iter().chain(moving).map(|(name, value)| (name.to_owned(), value)).collect()
}

fn configurations() -> impl Iterator<Item = [f64; 4]> {
    (0..12).map(|k| 0.7 * f64::from(k)).map(|s| [2.0 * s.sin(), 1.5 * s.cos(), 0.1 + 0.05 * s.sin(), s])
}

fn frames(loaded: &LoadedRobot, q: &[f64]) -> impl Fn(&str) -> Isometry3<f64> {
    let geometry = Geometry::nominal(&loaded.model).unwrap();
    let mut placements = Placements::default();
    geometry.place(q, &mut placements).unwrap();
    let names: Vec<String> = loaded.model.frames.iter().map(|frame| frame.name.clone()).collect();
    let tool = placements.frames[loaded.model.tool.0] * geometry.tool();
    move |name| {
        let at = if name == "tool" { tool } else { placements.frames[names.iter().position(|n| n == name).unwrap()] };
        Isometry3::from_parts(at.translation, nalgebra::UnitQuaternion::from_rotation_matrix(&at.rotation))
    }
}

#[test]
fn the_chain_reaches_what_the_urdf_reaches() {
    let loaded = read(CHAIN).unwrap();
    let names: Vec<&str> = loaded.model.variables.iter().map(|variable| variable.name.as_str()).collect();
    assert_eq!(names, ["a1", "a2", "extend", "a5"]);
    let frames_of: Vec<&str> = loaded.model.frames.iter().map(|frame| frame.name.as_str()).collect();
    assert_eq!(frames_of, ["0", "a1", "a2", "strut_joint", "extend", "a4", "a5", "tool0", "finger1", "strut"]);
    for q in configurations() {
        let (urdf, ours) = (of_urdf(TORSO, &of_joints(&q)), frames(&loaded, &q));
        let base = urdf["plate"].inverse();
        for (mine, theirs) in [
            ("tool", "flange-tool0"),
            ("tool0", "flange-tool0"),
            ("finger1", "finger_joint1"),
            ("strut", "strut_joint"),
        ] {
            let off = apart(&ours(mine), &(base * urdf[theirs]));
            assert!(off < 1e-12, "{mine}: {off:e} at {q:?}");
        }
    }
    // Nothing of gripper, strut and leg is calibrated, and a link's place in its body is not either.
    let registry = &loaded.model.registry;
    let free: Vec<&str> = loaded.model.free_slots().iter().map(|&slot| registry[slot].name.as_str()).collect();
    assert!(
        free.iter().all(|name| name.starts_with('a') || name.starts_with("extend") || name.starts_with("strut_joint"))
    );
    // That at which a joint mimics another is.
    assert!(free.contains(&"a5.theta") && free.contains(&"a4.theta"), "{free:?}");
}

#[test]
fn gravity_and_masses_are_those_of_the_whole_machine() {
    let loaded = read(CHAIN).unwrap();
    let urdf = urdf_rs::read_from_string(TORSO.trim_start()).unwrap();
    for q in configurations() {
        let (poses, ours) = (of_urdf(TORSO, &of_joints(&q)), frames(&loaded, &q));
        let base = poses["plate"].inverse();
        let down = base * Vector3::new(0.0, 0.0, -9.81);
        assert!((Vector3::from(loaded.raw.gravity.unwrap()) - down).norm() < 1e-12);
        let (mut mass, mut moment) = (0.0, Vector3::zeros());
        for joint in &urdf.joints {
            let link = urdf.links.iter().find(|link| link.name == joint.child.link).unwrap();
            let carried = !["lift", "lean", "plate", "hip"].contains(&joint.name.as_str());
            if carried {
                let [x, y, z] = link.inertial.origin.xyz.0;
                mass += link.inertial.mass.value;
                moment +=
                    link.inertial.mass.value * (base * poses[&joint.name] * nalgebra::Point3::new(x, y, z)).coords;
            }
        }
        let (mut found, mut turned) = (0.0, Vector3::zeros());
        for (name, body) in &loaded.raw.bodies {
            let com = nalgebra::Point3::from(body.com.unwrap_or_default().map(|mm| mm * 1e-3));
            found += body.mass.unwrap();
            turned += body.mass.unwrap() * (ours(name) * com).coords;
        }
        assert!((found - mass).abs() < 1e-12 && (turned - moment).norm() < 1e-12, "{found} {mass} {turned} {moment}");
    }
}

#[test]
fn a_link_that_the_description_weighs_is_not_weighed_twice() {
    let weighed = format!("{CHAIN}bodies:\n  finger1: {{mass: 5, com: [1, 2, 3]}}\n");
    let (before, after) = (read(CHAIN).unwrap().raw.bodies, read(&weighed).unwrap().raw.bodies);
    assert!((before["a5"].mass.unwrap() - 0.2).abs() < 1e-15);
    assert_eq!((after["a5"].mass, after["finger1"].mass), (Some(0.1), Some(5.0)));
}

#[test]
fn a_chain_of_part_of_the_arm_with_a_joint_of_it_held() {
    let text = "urdf: {file: torso.urdf, to: hand, fixed: {lift: 0.2, a2: 0.5}}";
    let loaded = read(text).unwrap();
    let names: Vec<&str> = loaded.model.variables.iter().map(|variable| variable.name.as_str()).collect();
    // a4 follows a2, and is held with it; the base is the file's own.
    assert_eq!(names, ["lean", "a1", "extend"]);
    assert_eq!(loaded.raw.gravity, None);
    for s in [-0.3, 0.2, 0.6] {
        let q = [s, -s, 0.1 + 0.1 * s];
        let values = [("lift", 0.2), ("a2", 0.5), ("lean", q[0]), ("a1", q[1]), ("extend", q[2])];
        let urdf = of_urdf(TORSO, &values.map(|(name, value)| (name.to_owned(), value)).into_iter().collect());
        let off = apart(&frames(&loaded, &q)("tool"), &urdf["a4"]);
        assert!(off < 1e-12, "{off:e}");
    }
}

/// As written to `arm.yaml` and read again.
fn saved(raw: &RawRobot, folder: &Path) -> LoadedRobot {
    let path = folder.join("saved.yaml");
    let raw = elastogeo::files::moved_to(raw, &path);
    std::fs::write(&path, elastogeo::description::yaml::write(&raw).unwrap()).unwrap();
    load_robot(&path.display().to_string()).unwrap()
}

#[test]
fn a_saved_chain_is_the_same_robot_without_its_urdf() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("torso.urdf"), TORSO).unwrap();
    std::fs::write(folder.path().join("arm.yaml"), CHAIN).unwrap();
    let loaded = load_robot(&folder.path().join("arm.yaml").display().to_string()).unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    let again = saved(&loaded.raw, &inner);
    assert_eq!(again.robot, loaded.robot);
    assert_eq!(elastogeo::files::source_urdf(&again.raw).unwrap().1.unwrap(), TORSO);
    std::fs::remove_file(folder.path().join("torso.urdf")).unwrap();
    assert_eq!(saved(&again.raw, &inner).robot, loaded.robot);
}

/// What is written when every constant is a little off, and where the tool then is.
#[test]
fn a_calibrated_chain_is_written_into_its_urdf() {
    let loaded = read(CHAIN).unwrap();
    // Nothing has changed: nothing but the markers is added.
    let (text, said) = export_into(&loaded.raw, "torso.urdf", TORSO).unwrap();
    assert!(said.is_empty(), "{said:#?}");
    let lines = |text: &str| text.trim().lines().map(str::to_owned).collect::<Vec<_>>();
    let (before, after) = (lines(TORSO), lines(&text));
    assert_eq!(before[..before.len() - 1], after[..before.len() - 1]);

    let mut values = loaded.model.registry.nominal();
    let free = loaded.model.free_slots();
    for (k, &slot) in free.iter().enumerate() {
        values[slot] += 1e-3 * (1.0 + f64::from(u32::try_from(k).unwrap())).sin();
    }
    for k in 0..6 {
        values[loaded.model.tool.1 + k] += 2e-3;
    }
    let calibrated = with_values(&loaded.raw, &loaded.model, &values);
    let folder = tempfile::tempdir().unwrap();
    let again = saved(&calibrated, folder.path());
    let (text, said) = export_into(&calibrated, "torso.urdf", TORSO).unwrap();
    assert!(said.is_empty(), "{said:#?}");
    for q in configurations() {
        let urdf = of_urdf(&text, &of_joints(&q));
        let base = urdf["plate"].inverse();
        let ours = frames(&again, &q);
        for (marker, frame) in [("tip", "tool0"), ("left", "finger1"), ("joint", "strut")] {
            let at = again.robot.markers.iter().find(|known| known.name == marker).unwrap().position;
            let off = (ours(frame) * nalgebra::Point3::from(at)).coords - (base * urdf[marker]).translation.vector;
            assert!(off.norm() < 1e-12, "{marker}: {:e}", off.norm());
        }
        for (mine, theirs) in [("tool", "flange-tool0"), ("finger1", "finger_joint1"), ("strut", "strut_joint")] {
            let off = apart(&ours(mine), &(base * urdf[theirs]));
            assert!(off < 1e-12, "{mine}: {off:e}");
        }
    }
    // Only origins of the arm differ.
    let changed: Vec<String> = lines(&text)
        .into_iter()
        .zip(&before)
        .filter(|(a, b)| a != *b)
        .map(|(line, _)| line.trim().to_owned())
        .collect();
    let markers = changed.iter().position(|line| line.contains("name=\"tip\"")).unwrap();
    assert_eq!(markers, 7, "{changed:#?}");
    assert!(changed[..markers].iter().all(|line| line.starts_with("<origin xyz=")));
    let (read_again, _) = import("torso.urdf", &text).unwrap();
    assert_eq!(read_again.frames["a1"].limits, Some([-2.9, 2.9]));
}

/// Of a whole URDF, too, the frames and the tool come back where they were, with markers among the ends.
#[test]
fn a_calibrated_whole_is_written_into_its_urdf() {
    let folder = tempfile::tempdir().unwrap();
    for robot in ["kuka-kr270", "torso"] {
        let loaded = match robot {
            "torso" => read("urdf: torso.urdf\nmarkers: {tip: {frame: hand, at: [0.01, 0.02, 0.03]}}\n").unwrap(),
            bundled => load_robot(bundled).unwrap(),
        };
        let mut values = loaded.model.registry.nominal();
        for (k, slot) in
            loaded.model.free_slots().into_iter().chain(loaded.model.tool.1..loaded.model.tool.1 + 6).enumerate()
        {
            values[slot] += 1e-3 * (1.0 + f64::from(u32::try_from(k).unwrap())).sin();
        }
        let calibrated = with_values(&loaded.raw, &loaded.model, &values);
        let mut plain = calibrated.clone();
        plain.effects.clear();
        let source = if robot == "torso" {
            TORSO.to_owned()
        } else {
            elastogeo::files::source_urdf(&loaded.raw).unwrap().1.unwrap()
        };
        let (text, said) = export_into(&plain, "source.urdf", &source).unwrap();
        assert!(said.iter().all(|diagnostic| !diagnostic.message.contains("not kept")), "{said:#?}");
        let path = folder.path().join("written.urdf");
        std::fs::write(&path, &text).unwrap();
        let again = load_robot(&path.display().to_string()).unwrap();
        let direct = saved(&calibrated, folder.path());
        for k in 0..5 {
            let q: Vec<f64> =
                (0..loaded.model.variables.len()).map(|j| 0.2 + 0.1 * f64::from(k) * (1.0 + j as f64).sin()).collect();
            let off = apart(&frames(&again, &q)("tool"), &frames(&direct, &q)("tool"));
            assert!(off < 1e-11, "{robot}: {off:e}");
        }
    }
}

#[test]
fn masses_and_limits_that_differ_are_written() {
    let changed = format!(
        "{CHAIN}bodies:\n  a1: {{mass: 6, com: [10, 20, 30]}}\n  finger2: {{mass: 0.3}}\nframes:\n  a1: {{limits: [-90, 100]}}\n"
    );
    let raw = read(&changed).unwrap().raw;
    let (text, said) = export_into(&raw, "torso.urdf", TORSO).unwrap();
    assert!(said.is_empty(), "{said:#?}");
    let urdf = urdf_rs::read_from_string(&text).unwrap();
    let link = |name: &str| &urdf.links.iter().find(|link| link.name == name).unwrap().inertial;
    assert_eq!((link("upper").mass.value, link("finger2").mass.value), (6.0, 0.3));
    assert_eq!((link("upper").inertia.ixy, link("fore").mass.value), (0.01, 2.5));
    let limit = &urdf.joints.iter().find(|joint| joint.name == "a1").unwrap().limit;
    assert!((limit.lower + 90_f64.to_radians()).abs() < 1e-12 && (limit.upper - 100_f64.to_radians()).abs() < 1e-12);
    assert_eq!((limit.effort, limit.velocity), (150.0, 2.5));
    assert_eq!(text.matches(".stl").count(), 2);
}

#[test]
fn a_description_that_moves_otherwise_is_written_by_itself_with_a_warning() {
    let mut raw = read(CHAIN).unwrap().raw;
    raw.frames["a5"].antecedent = Some("extend".to_owned());
    let (text, said) = export_into(&raw, "torso.urdf", TORSO).unwrap();
    assert!(!text.contains(".stl"));
    assert!(
        said.iter().any(|diagnostic| diagnostic.message.contains("`a5` is not placed or moved as in the file")),
        "{said:#?}"
    );
}

/// What is said of this `urdf:`, where it stands and what to do.
#[track_caller]
fn refused(keys: &str, at: &str, message: &str, remedy: &str) {
    let said = read(&format!("units: {{length: mm, angle: deg}}\nurdf: {keys}\n")).unwrap_err();
    let errors: Vec<_> = said.iter().filter(|diagnostic| diagnostic.is_error()).collect();
    assert_eq!(errors.len(), 1, "{said:#?}");
    let (diagnostic, place) = (errors[0], errors[0].place.as_ref().unwrap());
    assert!(diagnostic.message.contains(message), "{diagnostic:#?}");
    assert!(diagnostic.remedy.as_deref().unwrap_or("").contains(remedy), "{diagnostic:#?}");
    assert_eq!((place.line, &place.excerpt[place.highlight.clone()]), (2, at), "{diagnostic:#?}");
}

#[test]
fn names_that_are_neither_joint_nor_link_are_refused() {
    let said = read(&CHAIN.replace("frame: finger1", "frame: finger")).unwrap_err();
    assert!(said.len() == 1 && said[0].message.contains("unknown frame `finger`"), "{said:#?}");
    assert_eq!(said[0].remedy.as_deref(), Some("did you mean `finger1`?"));
    assert_eq!(said[0].place.as_ref().unwrap().line, 6);
}

#[test]
fn chains_that_are_none_are_refused() {
    refused(
        "{file: torso.urdf, from: shoulder_plat, to: tool0}",
        "shoulder_plat",
        "no link `shoulder_plat`",
        "`shoulder_plate`",
    );
    refused("{file: torso.urdf, to: a5}", "a5", "no link `a5`", "the link that it carries is `flange`");
    refused(
        "{file: torso.urdf, from: tool0, to: chest}",
        "tool0",
        "`tool0` does not carry the link `chest`",
        "from: chest, to: tool0",
    );
    refused("{file: torso.urdf, from: leg, to: tool0}", "leg", "does not carry", "carries both is `pedestal`");
    refused("{file: torso.urdf, from: flange, to: tool0}", "tool0", "no joint moves between", "two ends of the arm");
    let arm = |fixed: &str| format!("{{file: torso.urdf, to: tool0, fixed: {{{fixed}}}}}");
    refused(&arm("finger_joint: 1"), "1", "no joint `finger_joint`", "`finger_joint1`");
    refused(&arm("finger_joint1: 50"), "50", "`finger_joint1: 50` is outside", "0 to 40");
    refused(&arm("finger_joint2: 5"), "5", "follows `finger_joint1`", "give the value of `finger_joint1`");
    refused(&arm("plate: 0"), "0", "cannot move anyway", "leave it out");
    refused(&arm("lean: .nan"), ".nan", "finite number", "");
    refused("{from: chest, to: tool0}", "urdf", "names no file", "urdf: {file:");
    refused("{file: torso.urdf, form: chest}", "form", "unknown key `form`", "`from`");
    refused("{file: toso.urdf, to: tool0}", "{file: toso.urdf, to: tool0}", "there is no file", "torso.urdf");
    refused("[torso.urdf]", "urdf", "must be the name of a file, or a mapping with `file`", "");
}

/// A fixed joint beyond the chain has the name of its link: frames are named by the link all the same.
#[test]
fn a_link_whose_name_a_joint_has_is_a_frame() {
    let own = TORSO.replace("flange-tool0", "tool0");
    assert_ne!(own, TORSO);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("torso.urdf"), &own).unwrap();
    let text = "urdf: {file: torso.urdf, from: shoulder_plate, to: flange}\nunits: {length: mm, angle: deg}\n\
                markers: {own: {frame: tool0, at: [1, 2, 3]}}\n";
    let read = |text: &str| Reader::default().robot_text(&folder.path().join("arm.yaml"), text);
    let loaded = read(text).unwrap();
    std::fs::write(folder.path().join("torso.urdf"), TORSO).unwrap();
    let other = read(text).unwrap();
    let places = [&loaded, &other].map(|loaded| {
        let marker = loaded.model.markers.iter().find(|marker| marker.name == "own").unwrap();
        (loaded.model.frames[marker.frame].name.clone(), marker.frame)
    });
    assert_eq!(format!("{:?}", places[0]), format!("{:?}", places[1]));
}
