//! `convention:`: tables of Denavit and Hartenberg against products of the textbooks' own 4x4 matrices.

use std::fmt::Write;
use std::path::Path;

use elastogeo::description::convention::as_declared;
use elastogeo::description::yaml;
use elastogeo::diagnostic::Diagnostic;
use elastogeo::files::{LoadedRobot, Reader, load_robot};
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::with_values;
use nalgebra::{Matrix4, UnitQuaternion, Vector3, Vector4};
use proptest::prelude::*;

/// theta, d, a, alpha; mm and degrees. The variable is added to d where the joint is prismatic.
type Row = ([f64; 4], bool);

fn read(text: &str) -> Result<LoadedRobot, Vec<Diagnostic>> {
    Reader::default().robot_text(Path::new("arm.yaml"), text).map_err(Into::into)
}

/// The textbook's matrix of a row: Spong, Hutchinson and Vidyasagar, equation (3.10).
fn classical([theta, d, a, alpha]: [f64; 4]) -> Matrix4<f64> {
    let ((s, c), (sa, ca)) = (theta.to_radians().sin_cos(), alpha.to_radians().sin_cos());
    #[rustfmt::skip]
    let matrix = Matrix4::new(
        c, -s * ca,  s * sa, a * c,
        s,  c * ca, -c * sa, a * s,
        0.0,    sa,      ca,     d,
        0.0,   0.0,     0.0,   1.0,
    );
    matrix
}

/// The textbook's matrix of a row: Craig, equation (3.6); alpha and a stand in the row of the joint.
fn modified([theta, d, a, alpha]: [f64; 4]) -> Matrix4<f64> {
    let ((s, c), (sa, ca)) = (theta.to_radians().sin_cos(), alpha.to_radians().sin_cos());
    #[rustfmt::skip]
    let matrix = Matrix4::new(
             c,      -s,  0.0,       a,
        s * ca,  c * ca,  -sa, -sa * d,
        s * sa,  c * sa,   ca,  ca * d,
           0.0,     0.0,  0.0,     1.0,
    );
    matrix
}

fn written(convention: &str, rows: &[Row], more: &str) -> String {
    let mut text = format!("convention: {convention}\nunits: {{length: mm, angle: deg, mass: kg}}\nframes:\n");
    for (k, ([theta, d, a, alpha], prismatic)) in rows.iter().enumerate() {
        let joint = if *prismatic { "prismatic" } else { "revolute" };
        let (name, constants) = (k + 1, format!("theta: {theta:?}, d: {d:?}, a: {a:?}, alpha: {alpha:?}"));
        writeln!(text, "  {name}: {{antecedent: {k}, joint: {joint}, variable: q{name}, {constants}}}").unwrap();
    }
    text + more
}

/// Poses of the declared frames, and of the last one the product of all rows; mm.
fn product(row: fn([f64; 4]) -> Matrix4<f64>, rows: &[Row], q: &[f64]) -> Vec<Matrix4<f64>> {
    let mut poses = vec![Matrix4::identity()];
    for (([theta, d, a, alpha], prismatic), q) in rows.iter().zip(q) {
        let (turn, slide) = if *prismatic { (0.0, *q) } else { (*q, 0.0) };
        poses.push(poses[poses.len() - 1] * row([theta + turn, d + slide, *a, *alpha]));
    }
    poses
}

/// Tool (matrix) and markers (points) of the compiled robot at variables in mm and degrees; mm.
fn reached(loaded: &LoadedRobot, q: &[f64]) -> (Matrix4<f64>, Vec<Vector3<f64>>) {
    let si: Vec<f64> = loaded
        .model
        .variables
        .iter()
        .zip(q)
        .map(|(variable, q)| if variable.is_angle { q.to_radians() } else { q * 1e-3 })
        .collect();
    let geometry = Geometry::nominal(&loaded.model).unwrap();
    let mut placements = Placements::default();
    geometry.place(&si, &mut placements).unwrap();
    let mut tool = (placements.frames[loaded.model.tool.0] * geometry.tool()).to_homogeneous();
    tool.fixed_view_mut::<3, 1>(0, 3).scale_mut(1e3);
    let markers = loaded.robot.markers.iter().map(|marker| {
        let at = placements.frames[marker.frame] * nalgebra::Point3::from(marker.position);
        at.coords * 1e3
    });
    (tool, markers.collect())
}

fn at(pose: &Matrix4<f64>, point: [f64; 3]) -> Vector3<f64> {
    (pose * Vector4::new(point[0], point[1], point[2], 1.0)).xyz()
}

const POINTS: &str = "
tool: {at: [10, -20, 30], rotation: [20, -35, 50]}
markers:
  end: {at: [1, 2, 3]}
  first: {frame: 1, at: [4, 5, 6]}
  ground: {frame: 0, at: [7, 8, 9]}
bodies:
  1: {mass: 2, com: [11, 12, 13]}
";

fn assert_table(convention: &str, row: fn([f64; 4]) -> Matrix4<f64>, rows: &[Row], q: &[f64]) {
    let loaded = read(&written(convention, rows, POINTS)).unwrap();
    let poses = product(row, rows, q);
    let (tool, markers) = reached(&loaded, q);
    let last = poses[rows.len()];
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(20.0, -35.0, 50.0).map(f64::to_radians));
    let wanted = last * Matrix4::new_translation(&Vector3::new(10.0, -20.0, 30.0)) * turn.to_homogeneous();
    assert!((tool - wanted).amax() < 1e-9, "{tool}{wanted}");
    for (found, wanted) in
        markers.iter().zip([at(&last, [1.0, 2.0, 3.0]), at(&poses[1], [4.0, 5.0, 6.0]), Vector3::new(7.0, 8.0, 9.0)])
    {
        assert!((found - wanted).norm() < 1e-9, "{found} {wanted}");
    }
    // The body moves with joint 1; at its zero its centre is where the table's first frame has it.
    let com = loaded.raw.bodies["1"].com.unwrap_or_default();
    let mut moved = loaded.raw.clone();
    moved.markers.clear();
    moved
        .markers
        .insert("com".into(), elastogeo::description::raw::RawMarker { frame: Some("1".into()), at: Some(com) });
    let again = read(&yaml::write(&as_declared(&moved)).unwrap()).unwrap();
    let wanted = at(&poses[1], [11.0, 12.0, 13.0]);
    assert!((reached(&again, q).1[0] - wanted).norm() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn both_tables_are_the_products_of_their_matrices(
        rows in prop::collection::vec((
            prop::array::uniform4(prop_oneof![Just(0.0), Just(90.0), Just(-90.0), -170.0..170.0_f64]), any::<bool>()
        ), 1..8),
        q in prop::array::uniform8(-150.0..150.0_f64),
    ) {
        assert_table("classical-dh", classical, &rows, &q);
        assert_table("modified-dh", modified, &rows, &q);
    }
}

/// The table that manufacturers print.
const UR5: [Row; 6] = [
    ([0.0, 89.159, 0.0, 90.0], false),
    ([0.0, 0.0, -425.0, 0.0], false),
    ([0.0, 0.0, -392.25, 0.0], false),
    ([0.0, 109.15, 0.0, 90.0], false),
    ([0.0, 94.65, 0.0, -90.0], false),
    ([0.0, 82.3, 0.0, 0.0], false),
];
const UR5_MASSES: &str = "
tool: {frame: 6}
bodies:
  1: {mass: 3.7, com: [0, -25.61, 1.93]}
  2: {mass: 8.393, com: [212.5, 0, 113.36]}
  3: {mass: 2.275, com: [150, 0, 26.5]}
  4: {mass: 1.219, com: [0, -1.8, 16.34]}
  5: {mass: 1.219, com: [0, 1.8, 16.34]}
  6: {mass: 0.1879, com: [0, 0, -1.159]}
";

#[test]
fn a_printed_table_is_the_bundled_robot() {
    let (table, bundled) =
        (read(&written("classical-dh", &UR5, UR5_MASSES)).unwrap(), load_robot("universal-ur5").unwrap());
    let of = |loaded: &LoadedRobot| {
        let frames = loaded
            .raw
            .frames
            .values()
            .map(|frame| [frame.alpha, frame.d, frame.theta, frame.r].map(|value| value.unwrap_or(0.0)));
        frames.collect::<Vec<_>>()
    };
    assert_eq!(of(&table), of(&bundled));
    for (name, body) in &bundled.raw.bodies {
        let (mine, theirs) = (table.raw.bodies[name].com.unwrap_or_default(), body.com.unwrap_or_default());
        let off = (Vector3::from(mine) - Vector3::from(theirs)).norm();
        assert!(off < 1e-12, "{name}: {mine:?} {theirs:?}");
    }
    assert_eq!(table.model.free_slots().len(), bundled.model.free_slots().len());
}

/// A calibrated description is read back as the same robot, and says in which convention it is written.
#[test]
fn a_saved_table_is_read_back_as_the_same_robot() {
    for (convention, kept) in [("modified-dh", true), ("classical-dh", false), ("khalil-kleinfinger", false)] {
        let text = written("classical-dh", &UR5, POINTS).replace("classical-dh", convention);
        let text = if convention == "khalil-kleinfinger" { text.replace(" a:", " r:") } else { text };
        let loaded = read(&text).unwrap();
        let mut values = loaded.model.registry.nominal();
        for (k, slot) in loaded.model.free_slots().into_iter().enumerate() {
            values[slot] += 1e-3 * (1.0 + f64::from(u32::try_from(k).unwrap())).sin();
        }
        let calibrated = with_values(&loaded.raw, &loaded.model, &values);
        let saved = yaml::write(&as_declared(&calibrated)).unwrap();
        assert_eq!(saved.contains("convention: modified-dh\n"), kept, "{saved}");
        let again = read(&saved).unwrap();
        assert_eq!(again.robot, elastogeo::description::resolve::resolve(&calibrated, &|_| None).0.unwrap());
        for slot in loaded.model.free_slots() {
            let (parameter, value) = (&again.model.registry[slot], values[slot]);
            let off = (parameter.nominal - value).abs();
            assert!(off < 1e-12 * (1.0 + value.abs()), "{convention} {}: {off:e}", parameter.name);
        }
        // A second way through changes nothing.
        assert_eq!(yaml::write(&as_declared(&again.raw)).unwrap(), saved);
    }
}

#[test]
fn resolving_by_hand_reads_the_table_too() {
    let text = written("classical-dh", &UR5, UR5_MASSES);
    let (raw, _, _) = yaml::read::<elastogeo::description::raw::RawRobot>("arm.yaml", &text);
    let (robot, said) = elastogeo::description::resolve::resolve(&raw.unwrap(), &|_| None);
    assert_eq!(said, []);
    assert_eq!(robot.unwrap(), read(&text).unwrap().robot);
}

/// What is said of this text, where, and what to do.
#[track_caller]
fn refused(text: &str, line: usize, at: &str, message: &str, remedy: &str) {
    let said = read(text).unwrap_err();
    let errors: Vec<_> = said.iter().filter(|diagnostic| diagnostic.is_error()).collect();
    assert_eq!(errors.len(), 1, "{said:#?}");
    let (diagnostic, place) = (errors[0], errors[0].place.as_ref().unwrap());
    assert!(diagnostic.message.contains(message), "{diagnostic:#?}");
    assert!(diagnostic.remedy.as_deref().unwrap_or("").contains(remedy), "{diagnostic:#?}");
    assert_eq!((place.line, &place.excerpt[place.highlight.clone()]), (line, at), "{diagnostic:#?}");
}

#[test]
fn tables_that_are_none_are_refused() {
    let (table, crags) = (written("classical-dh", &UR5, UR5_MASSES), written("modified-dh", &UR5, UR5_MASSES));
    refused(&table.replace("classical-dh", "clasical-dh"), 1, "clasical-dh", "clasical-dh", "classical-dh");
    refused(&table.replace(", a: -425.0", ""), 5, "2", "row `2` of the classical-dh table lacks `a`", "write `a: 0`");
    refused(&crags.replace("d: 109.15, ", ""), 7, "4", "row `4` of the modified-dh table lacks `d`", "write `d: 0`");
    refused(&table.replace("a: -425.0", "a: -425.0, r: 3"), 5, "3", "`r` of frame `2`", "write `d`");
    refused(&table.replace("a: -425.0", "a: -425.0, beta: 0.1"), 5, "0.1", "`beta` of frame `2`", "khalil-kleinfinger");
    refused(&table.replace("convention: classical-dh", ""), 4, "0.0", "`a` of frame `1`", "write `d`");
    let spring = "springs:\n  s: {bodies: [1, 2], anchors: [[0, 0, 0], [1, 0, 0]], rate: {value: 1}, free_length: 1}\n";
    refused(
        &format!("{table}{spring}"),
        20,
        spring.lines().nth(1).unwrap().trim(),
        "`springs` cannot stand",
        "elastogeo convert",
    );
    refused(&table.replace("a: -425.0", "a: .nan"), 5, ".nan", "finite number", "");
    refused(&crags.replace("d: 109.15", "d: .inf"), 7, ".inf", "finite number", "");
    refused(
        "convention: modified-dh\nurdf: {file: arm.urdf, merged: true}\nframes:\n  1: {antecedent: 0, joint: revolute, variable: q, alpha: 0, a: 0, d: 1}\n",
        1,
        "modified-dh",
        "frames of `urdf`",
        "leave out",
    );
}
