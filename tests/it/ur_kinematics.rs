//! Kinematics of the Universal Robots driver, in and out, against the product of the file's own displacements.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;
use std::process::Command;

use elastogeo::description::ur_kinematics::write;
use elastogeo::description::yaml;
use elastogeo::diagnostic::Diagnostic;
use elastogeo::files::{LoadedRobot, Reader, load_robot};
use elastogeo::model::with_values;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::support::nominal_pose;

/// The dimensions that the manufacturer prints; a quarter turn has nine decimals there.
#[allow(clippy::approx_constant)]
const PRINTED: [[f64; 6]; 6] = [
    [0.0, 0.0, 0.089159, 0.0, 0.0, 0.0],
    [0.0, 0.0, 0.0, 1.570796327, 0.0, 0.0],
    [-0.425, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-0.39225, 0.0, 0.10915, 0.0, 0.0, 0.0],
    [0.0, -0.09465, -1.9e-11, 1.570796327, 0.0, 0.0],
    [0.0, 0.0823, -1.7e-11, 1.570796326589793, PI, PI],
];
/// As of one machine: every number a little off.
const MACHINE: [[f64; 6]; 6] = [
    [0.0, 0.0, 0.0893, -0.0, 0.0, 1.2e-5],
    [-1.1e-4, 2.0e-5, 0.0, 1.5713, 0.0, -8.0e-6],
    [-0.42512, 0.0, 0.0, 3.1e-3, 3.13e-3, 2.2e-5],
    [-0.39198, -1.4e-3, 0.10957, 3.14e-3, -3.1e-3, -1.7e-5],
    [-2.7e-5, -0.0946, 9.0e-5, 1.5701, 0.0, -3.3e-7],
    [3.5e-5, 0.08231, 4.0e-5, 1.57112, PI, -3.14158],
];
const LINKS: [&str; 6] = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"];
const KEYS: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

fn file(rows: &[[f64; 6]; 6]) -> String {
    let links = LINKS.iter().zip(rows).map(|(link, row)| {
        let numbers = KEYS.iter().zip(row).map(|(key, value)| format!("    {key}: {value}\n"));
        format!("  {link}:\n{}", numbers.collect::<String>())
    });
    format!("kinematics:\n{}  hash: calib_1234567890123456789\n", links.collect::<String>())
}

/// The numbers of a file, read here by its indentation.
fn rows(text: &str) -> [[f64; 6]; 6] {
    let mut found: HashMap<(String, String), f64> = HashMap::new();
    let mut link = String::new();
    for line in text.lines() {
        match line.trim().split_once(':') {
            Some((key, "")) => link = key.to_owned(),
            Some((key, value)) => {
                if let Ok(value) = value.trim().parse() {
                    found.insert((link.clone(), key.to_owned()), value);
                }
            }
            None => {}
        }
    }
    LINKS.map(|link| KEYS.map(|key| found[&(link.to_owned(), key.to_owned())]))
}

/// Where the last link stands: each joint turns about z of its link.
fn reached(rows: &[[f64; 6]; 6], q: &[f64]) -> Isometry3<f64> {
    rows.iter().zip(q).fold(Isometry3::identity(), |pose, ([x, y, z, roll, pitch, yaw], q)| {
        let turn = UnitQuaternion::from_euler_angles(*roll, *pitch, *yaw);
        let joint = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *q);
        pose * Isometry3::from_parts(Translation3::new(*x, *y, *z), turn * joint)
    })
}

fn read(text: &str) -> Result<LoadedRobot, Vec<Diagnostic>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("kinematics.yaml");
    std::fs::write(&path, text).unwrap();
    load_robot(&path.display().to_string()).map_err(Into::into)
}

fn configurations() -> impl Iterator<Item = [f64; 6]> {
    (0..10_u8).map(|k| std::array::from_fn(|joint| 2.5 * (1.0 + 1.7 * f64::from(k) + 2.3 * joint as f64).sin()))
}

#[track_caller]
fn assert_reaches(loaded: &LoadedRobot, rows: &[[f64; 6]; 6], tolerance: f64) {
    for q in configurations() {
        let (ours, theirs) = (nominal_pose(&loaded.model, &q).to_homogeneous(), reached(rows, &q).to_homogeneous());
        let off = (ours - theirs).amax();
        assert!(off < tolerance, "{off:e}");
    }
}

#[test]
fn a_file_is_the_product_of_its_displacements() {
    for rows in [PRINTED, MACHINE] {
        let loaded = read(&file(&rows)).unwrap();
        assert_eq!(loaded.diagnostics, []);
        assert_reaches(&loaded, &rows, 1e-13);
        let names: Vec<&str> = loaded.model.variables.iter().map(|variable| variable.name.as_str()).collect();
        assert_eq!(names[..3], ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"]);
    }
    // The printed dimensions are those of the bundled robot; roll is printed with nine decimals.
    assert_reaches(&load_robot("universal-ur5").unwrap(), &PRINTED, 1e-8);
}

#[test]
fn a_calibrated_robot_is_written_and_read_back() {
    let loaded = read(&file(&MACHINE)).unwrap();
    let mut values = loaded.model.registry.nominal();
    for (k, slot) in loaded.model.free_slots().into_iter().enumerate() {
        values[slot] += 1e-3 * (1.0 + f64::from(u32::try_from(k).unwrap())).sin();
    }
    let saved = yaml::write(&with_values(&loaded.raw, &loaded.model, &values)).unwrap();
    let calibrated = Reader::default().robot_text(Path::new("saved.yaml"), &saved).unwrap();
    let hash = calibrated.raw.ur_kinematics.clone().unwrap().hash.unwrap();
    let (text, said) = write(&calibrated.robot, Some(&hash)).unwrap();
    assert_eq!(said, []);
    assert!(text.ends_with("  hash: calib_1234567890123456789\n"), "{text}");
    assert_reaches(&calibrated, &rows(&text), 1e-12);
    let again = read(&text).unwrap();
    assert_reaches(&again, &rows(&text), 1e-12);
    // What has not been calibrated comes back to the last digit but for round-off.
    let (text, _) = write(&loaded.robot, Some(&hash)).unwrap();
    let off = configurations()
        .map(|q| (reached(&rows(&text), &q).to_homogeneous() - reached(&MACHINE, &q).to_homogeneous()).amax());
    assert!(off.fold(0.0, f64::max) < 1e-13);
}

#[test]
fn a_description_lays_more_over_a_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.yaml"), file(&MACHINE)).unwrap();
    let text = "
ur_kinematics: machine.yaml
units: {length: mm, angle: deg, mass: kg}
frames:
  elbow_joint: {limits: [-150, 150]}
tool: {at: [0, 0, 100]}
bodies:
  elbow_joint: {mass: 2.3, com: [-150, 0, 26]}
";
    let loaded = Reader::default().robot_text(&folder.path().join("arm.yaml"), text).unwrap();
    for q in configurations() {
        let wanted = reached(&MACHINE, &q) * Isometry3::translation(0.0, 0.0, 0.1);
        assert!((nominal_pose(&loaded.model, &q).to_homogeneous() - wanted.to_homogeneous()).amax() < 1e-13);
    }
    assert_eq!(loaded.model.variables[2].limits, Some([-150_f64, 150.0].map(f64::to_radians)));
    // Saved, it is whole without the file, and knows its hash.
    let again = Reader::default().robot_text(Path::new("saved.yaml"), &yaml::write(&loaded.raw).unwrap()).unwrap();
    assert_eq!(again.robot, loaded.robot);
    let (_, said) = write(&again.robot, Some("calib_1")).unwrap();
    assert!(said.len() == 1 && said[0].message.contains("the tool is not written"), "{said:#?}");
}

/// What is said of this robot when it is to be written.
#[track_caller]
fn not_written(robot: &str, message: &str) {
    let loaded = load_robot(robot).unwrap();
    let said = write(&loaded.robot, None).unwrap_err();
    assert!(said.message.contains(message), "{said:#?}");
    assert!(said.remedy.unwrap().contains("six revolute joints"));
}

#[test]
fn other_robots_are_not_written() {
    not_written("kuka-kr270", "joint 4 (`wrist_1`) is not parallel with the joint before: 90.0 deg");
    not_written("barrett-wam", "7 joints carry its tool");
    not_written("kuka-ir663", "no variable of its own");
    let (text, said) = write(&load_robot("universal-ur10").unwrap().robot, None).unwrap();
    assert!(text.contains("hash: calib_unknown") && said.len() == 1, "{said:#?}");
    assert!(said[0].remedy.as_deref().unwrap().contains("ur_calibration"));
}

/// What is said of a file with a mistake, and where.
#[track_caller]
fn refused(find: &str, replace: &str, line: usize, at: &str, message: &str) {
    let text = file(&PRINTED);
    assert!(text.contains(find));
    let said = read(&text.replacen(find, replace, 1)).unwrap_err();
    assert_eq!(said.len(), 1, "{said:#?}");
    let place = said[0].place.as_ref().unwrap();
    assert!(said[0].message.contains(message), "{said:#?}");
    assert_eq!((place.line, &place.excerpt[place.highlight.clone()]), (line, at), "{said:#?}");
}

#[test]
fn files_with_mistakes_are_refused() {
    refused("    roll: 1.570796327\n", "", 9, "upper_arm", "`upper_arm` lacks `roll`");
    refused("  forearm:\n", "  foreram:\n", 16, "foreram", "foreram");
    refused("x: -0.425", "x: .nan", 17, ".nan", "finite number");
    refused("x: -0.425", "x: far", 17, "far", "");
    refused("    yaw: 0\n", "    yaw: 0\n    yav: 0\n", 9, "yav", "yav");
}

#[test]
fn the_command_converts_both_ways() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.yaml"), file(&MACHINE)).unwrap();
    let run = |arguments: &[&str]| {
        let command =
            Command::new(env!("CARGO_BIN_EXE_elastogeo")).current_dir(folder.path()).args(arguments).output().unwrap();
        (command.status.code(), String::from_utf8(command.stderr).unwrap())
    };
    assert_eq!(run(&["convert", "machine.yaml", "arm.yaml"]).0, Some(0));
    assert_eq!(run(&["convert", "arm.yaml", "back.yaml", "--as", "ur-kinematics"]), (Some(0), String::new()));
    let back = rows(&std::fs::read_to_string(folder.path().join("back.yaml")).unwrap());
    for q in configurations() {
        assert!((reached(&back, &q).to_homogeneous() - reached(&MACHINE, &q).to_homogeneous()).amax() < 1e-12);
    }
    let (status, said) = run(&["convert", "barrett-wam", "back.yaml", "--as", "ur-kinematics"]);
    assert!(status == Some(2) && said.contains("cannot be written as UR kinematics"), "{said}");
    std::fs::write(folder.path().join("two.yaml"), "urdf: a.urdf\nur_kinematics: machine.yaml\n").unwrap();
    let (status, said) = run(&["check", "two.yaml"]);
    assert!(status == Some(2) && said.contains("both give frames") && said.contains("two.yaml:2"), "{said}");
    std::fs::write(folder.path().join("gone.yaml"), "ur_kinematics: machin.yaml\n").unwrap();
    let (status, said) = run(&["check", "gone.yaml"]);
    assert!(status == Some(2) && said.contains("there is no file") && said.contains("machine.yaml"), "{said}");
}
