//! Tables of Denavit and Hartenberg's parameters and of offsets of zeros, put together again by hand and held against the description.

use std::path::Path;

use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Placements};
use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Vector3};
use rand::RngExt;

use super::cli::run;
use super::plausibility::starter;

type Row = std::collections::HashMap<String, String>;

fn rows(file: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(file).expect("a table");
    reader.deserialize().map(|row| row.expect("a row")).collect()
}

fn number(row: &Row, key: &str) -> f64 {
    row[key].parse().unwrap_or_else(|_| panic!("{key}: {row:?}"))
}

/// A rotation about an axis and a shift along it.
fn screw(axis: Vector3<f64>, degrees: f64, millimetres: f64) -> IsometryMatrix3<f64> {
    let rotation = Rotation3::from_scaled_axis(axis * degrees.to_radians());
    IsometryMatrix3::from_parts(Translation3::from(axis * (1e-3 * millimetres)), rotation)
}

fn end(row: &Row) -> IsometryMatrix3<f64> {
    let [x, y, z] = ["x_mm", "y_mm", "z_mm"].map(|key| 1e-3 * number(row, key));
    let turned = Vector3::from(["rx_deg", "ry_deg", "rz_deg"].map(|key| number(row, key).to_radians()));
    IsometryMatrix3::from_parts(Translation3::new(x, y, z), Rotation3::from_scaled_axis(turned))
}

/// Where a table puts the tool.
fn by_table(rows: &[Row], names: &[String], q: &[f64], modified: bool) -> IsometryMatrix3<f64> {
    let mut pose = end(&rows[0]);
    let joints = &rows[1..rows.len() - 1];
    for row in joints {
        let variable = names.iter().position(|name| *name == row["variable"]).expect("a variable");
        let (mut turn, mut slide) = (number(row, "theta_deg"), number(row, "d_mm"));
        let is_angle = !["rail", "down"].contains(&row["variable"].as_str());
        if is_angle {
            turn += q[variable].to_degrees()
        } else {
            slide += 1e3 * q[variable]
        }
        let own = screw(Vector3::z(), turn, slide);
        let link = screw(Vector3::x(), number(row, "alpha_deg"), number(row, "a_mm"));
        pose *= if modified { link * own } else { own * link };
    }
    pose * end(&rows[rows.len() - 1])
}

/// Arms in series, as bundled and with errors in every constant: both tables place the tool where the description does.
#[test]
fn tables_of_denavit_and_hartenberg_place_the_tool() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let mut random = elastogeo::simulation::generator(5);
    for robot in ["universal-ur5", "universal-ur10", "kuka-kr270", "franka-panda", "scara-rail", "barrett-wam"] {
        let changed = calibrated(at, robot);
        for description in [robot, changed.as_str()] {
            let named =
                if description == robot { robot.to_string() } else { at.join(description).display().to_string() };
            let model = load_robot(&named).expect("a description").model;
            let geometry = Geometry::nominal(&model).expect("assembled");
            let names: Vec<String> = model.variables.iter().map(|variable| variable.name.clone()).collect();
            for (of, modified) in [("dh", false), ("dh-modified", true)] {
                let ran = run(at, &["convert", description, "dh.csv", "--as", of]);
                assert_eq!(ran.status, 0, "{description}: {}", ran.err);
                let rows = rows(&at.join("dh.csv"));
                for _ in 0..5 {
                    let q: Vec<f64> = names.iter().map(|_| random.random_range(-1.0..1.0)).collect();
                    let mut placed = Placements::default();
                    geometry.place(&q, &mut placed).expect("placed");
                    let expected = placed.frames[model.tool.0] * geometry.tool();
                    let found = by_table(&rows, &names, &q, modified);
                    let apart = (found.to_homogeneous() - expected.to_homogeneous()).amax();
                    // Axes nearly parallel stand on normals some kilometres away.
                    assert!(apart < 1e-8, "{description} {of}: {apart:e}");
                }
            }
        }
    }
}

/// A description with other values of every free constant: one that was calibrated on readings of such an arm.
fn calibrated(at: &Path, robot: &str) -> String {
    let _ = std::fs::remove_dir_all(at.join("s"));
    let made = ["simulate", robot, "--poses", "60", "--errors", "2", "--noise", "0.01", "--seed", "3", "--into", "s"];
    let ran = run(at, &made);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let ran = run(at, &["identify", "s", "--what", "geometric", "--check", "0", "--save", "changed.yaml", "--force"]);
    assert_eq!(ran.status, 0, "{robot}: {}{}", ran.out, ran.err);
    "changed.yaml".into()
}

/// Published parameters: Universal Robots, *Parameters for calculations of kinematics and dynamics* (UR5, without e).
#[test]
fn a_ur5_has_its_published_parameters() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    assert_eq!(run(at, &["convert", "universal-ur5", "dh.csv", "--as", "dh"]).status, 0);
    let published = [
        [0.0, 89.159, 0.0, 90.0],
        [0.0, 0.0, -425.0, 0.0],
        [0.0, 0.0, -392.25, 0.0],
        [0.0, 109.15, 0.0, 90.0],
        [0.0, 94.65, 0.0, -90.0],
        [0.0, 82.3, 0.0, 0.0],
    ];
    for (row, expected) in rows(&at.join("dh.csv")).iter().skip(1).zip(published) {
        let found = ["theta_deg", "d_mm", "a_mm", "alpha_deg"].map(|key| number(row, key));
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}

/// The offset of a zero makes up for it: commands less the offset of the calibrated arm reach what the nominal one shows.
#[test]
fn offsets_of_zeros_are_those_of_the_description() {
    let folder = starter();
    let at = folder.path();
    let robot = std::fs::read_to_string(at.join("c/robot.yaml")).expect("text");
    let turned = robot.replace("d: 150, theta: -90", "d: 150, theta: -89.7");
    assert_ne!(turned, robot);
    std::fs::write(at.join("turned.yaml"), turned).expect("written");
    let ran = run(at, &["convert", "turned.yaml", "zeros.csv", "--as", "mastering", "--nominal", "c/robot.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let found: Vec<f64> = rows(&at.join("zeros.csv")).iter().map(|row| number(row, "offset")).collect();
    assert!(found.iter().zip([0.0, 0.3, 0.0, 0.0, 0.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    let ran = run(at, &["convert", "turned.yaml", "dh.csv", "--as", "dh", "--nominal", "c/robot.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let second = &rows(&at.join("dh.csv"))[2];
    assert!((number(second, "theta_deg.change") - 0.3).abs() < 1e-9, "{second:?}");
    // Of a joint that a coupling moves no variable has the zero.
    let coupled = |zero: f64| {
        format!(
            "units: {{length: mm, angle: deg}}\nframes:\n  1: {{antecedent: 0, joint: revolute, variable: q1}}\n  \
             k: {{antecedent: 1, joint: revolute, d: 300, offset: {zero}}}\n  E: {{antecedent: k, d: 400}}\n\
             couplings: [k = -1 * 1]\ntool: {{frame: E}}\n"
        )
    };
    for (name, zero) in [("nominal.yaml", 0.0), ("own.yaml", 0.3)] {
        std::fs::write(at.join(name), coupled(zero)).expect("written");
    }
    for (own, is_told) in [("own.yaml", true), ("nominal.yaml", false)] {
        let ran = run(at, &["convert", own, "k.csv", "--as", "mastering", "--nominal", "nominal.yaml"]);
        let told = ran.err.contains("does not hold the zero of `k`, which a coupling moves");
        assert!(ran.status == 0 && told == is_told, "{}", ran.err);
    }
    for (arguments, said) in [
        (&["convert", "turned.yaml", "zeros.csv", "--as", "mastering"][..], "--nominal"),
        (&["convert", "turned.yaml", "dh.yaml", "--as", "dh"], ".csv or .xlsx"),
        (&["convert", "turned.yaml", "x.urdf", "--nominal", "c/robot.yaml"], "--as dh"),
        (&["convert", "palletiser", "dh.csv", "--as", "dh"], "has no variable of its own"),
        (&["convert", "turned.yaml", "dh.csv", "--as", "dh", "--nominal", "scara-rail"], "the same robot"),
    ] {
        let ran = run(at, arguments);
        assert!(ran.status == 2 && ran.err.contains(said), "{arguments:?}: {}", ran.err);
    }
}

/// Angles about half a turn differ by what lies between them, not by a turn.
#[test]
fn changes_of_angles_are_within_half_a_turn() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let text = "robot: r\nunits: {length: mm, angle: deg}\nframes:\n\
                \x20 1: {antecedent: 0, joint: revolute, variable: q1, r: 400}\n\
                \x20 2: {antecedent: 1, joint: revolute, variable: q2, d: 50, alpha: 90}\n\
                \x20 3: {antecedent: 2, joint: revolute, variable: q3, d: 350, alpha: 180}\ntool: {frame: 3}\n";
    std::fs::write(at.join("nominal.yaml"), text).expect("written");
    std::fs::write(at.join("own.yaml"), text.replace("alpha: 180", "alpha: 180.03")).expect("written");
    let ran = run(at, &["convert", "own.yaml", "dh.csv", "--as", "dh-modified", "--nominal", "nominal.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let rows = rows(&at.join("dh.csv"));
    let changes: Vec<f64> = rows.iter().skip(1).take(3).map(|row| number(row, "alpha_deg.change")).collect();
    assert!(changes.iter().zip([0.0, 0.0, 0.03]).all(|(a, b)| (a - b).abs() < 1e-9), "{changes:?}");
}
