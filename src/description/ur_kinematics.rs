//! Kinematics as the Universal Robots driver of ROS reads them (`kinematics_params_file`) and `ur_calibration` writes them:
//! where each of the six joints places its link, by position (m) and roll, pitch, yaw (rad).
//!
//! The joints turn about z of their links. Frame 0 is the link that the file's `shoulder` is placed in: the base as the
//! controller counts it, from which `base_link` of the driver's URDF differs by half a turn about z.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix4, Rotation3, Translation3};
use serde::Deserialize;

use super::khalil_kleinfinger::{Isometry, about_x, about_y, about_z, clean, khalil_kleinfinger, roll_pitch_yaw};
use super::raw::{JointKind, RawFrame, RawRobot, RawUrKinematics};
use super::robot::{Motion, Placement, Robot};
use super::yaml;
use crate::diagnostic::{Code, Diagnostic};

/// Links as the file names them, the joints that carry them, and the angle of each joint's axis to the one before.
const LINKS: [(&str, &str, f64); 6] = [
    ("shoulder", "shoulder_pan_joint", 0.0),
    ("upper_arm", "shoulder_lift_joint", FRAC_PI_2),
    ("forearm", "elbow_joint", 0.0),
    ("wrist_1", "wrist_1_joint", 0.0),
    ("wrist_2", "wrist_2_joint", FRAC_PI_2),
    ("wrist_3", "wrist_3_joint", FRAC_PI_2),
];

/// How far an axis may be from square to, or from parallel with, the one before (3 deg): robots are built to 0.1 deg, and
/// what is farther off is another kind of robot.
const SKEW: f64 = 0.052;

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct File {
    kinematics: Option<Kinematics>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Kinematics {
    shoulder: Option<Origin>,
    upper_arm: Option<Origin>,
    forearm: Option<Origin>,
    wrist_1: Option<Origin>,
    wrist_2: Option<Origin>,
    wrist_3: Option<Origin>,
    hash: Option<String>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Origin {
    x: Option<f64>,
    y: Option<f64>,
    z: Option<f64>,
    roll: Option<f64>,
    pitch: Option<f64>,
    yaw: Option<f64>,
}

/// Whether a text is such a file and no description: `kinematics` is its outermost key.
pub fn is_ur_kinematics(text: &str) -> bool {
    text.lines().any(|line| line.strip_prefix("kinematics").is_some_and(|rest| rest.trim_start().starts_with(':')))
}

/// Reads such a file as a description in SI units: six frames by the names of the joints, each moved by a variable of its
/// name. Link frames are kept as they are. The tool is the last link's frame.
///
/// # Errors
/// Every fault of the file, located.
pub fn read(file: &str, text: &str) -> Result<(RawRobot, Vec<Diagnostic>), Vec<Diagnostic>> {
    let (found, document, mut diagnostics) = yaml::read::<File>(file, text);
    let Some(found) = found else { return Err(diagnostics) };
    let mut missing = |path: &[&str], around: &[&str]| {
        if !document.explains_absence(path) {
            let key = path.last().copied().unwrap_or_default();
            let diagnostic =
                Diagnostic::error(format!("`{}` lacks `{key}`", around.last().copied().unwrap_or("the file")));
            let remedy = "a file of `ur_calibration` has x, y, z, roll, pitch and yaw of six links below `kinematics`";
            diagnostics.push(diagnostic.code(Code::Missing).at(document.place_of_key(around)).remedy(remedy));
        }
    };
    if found.kinematics.is_none() {
        missing(&["kinematics"], &[]);
    }
    let Kinematics { shoulder, upper_arm, forearm, wrist_1, wrist_2, wrist_3, hash } =
        found.kinematics.unwrap_or_default();
    let mut robot = RawRobot { ur_kinematics: Some(RawUrKinematics { file: None, hash }), ..RawRobot::default() };
    let mut antecedent = "0";
    let mut faulty = Vec::new();
    for ((link, joint, _), origin) in LINKS.iter().zip([shoulder, upper_arm, forearm, wrist_1, wrist_2, wrist_3]) {
        let path = ["kinematics", *link];
        let Some(Origin { x, y, z, roll, pitch, yaw }) = origin else {
            missing(&path, &["kinematics"]);
            continue;
        };
        let mut number = |key: &'static str, value: Option<f64>| match value {
            Some(value) if value.is_finite() => value,
            Some(value) => {
                faulty.push((["kinematics", *link, key], value));
                0.0
            }
            None => {
                missing(&["kinematics", *link, key], &path);
                0.0
            }
        };
        let at = Translation3::new(number("x", x), number("y", y), number("z", z));
        let (roll, pitch, yaw) = (number("roll", roll), number("pitch", pitch), number("yaw", yaw));
        let pose = Isometry::from_parts(at, about_z(yaw) * about_y(pitch) * about_x(roll));
        let [beta, gamma, b, alpha, d, theta, r] =
            khalil_kleinfinger(&pose).values().map(|value| (value != 0.0).then_some(value));
        let joint_kind = Some(JointKind::Revolute);
        let frame = RawFrame { antecedent: Some(antecedent.into()), joint: joint_kind, ..RawFrame::default() };
        let variable = Some((*joint).into());
        robot.frames.insert((*joint).into(), RawFrame { variable, beta, gamma, b, alpha, d, theta, r, ..frame });
        antecedent = joint;
    }
    for (path, value) in faulty {
        let diagnostic = Diagnostic::error(format!("`{value}` where a finite number is needed"));
        diagnostics.push(diagnostic.at(document.place_of_value(&path)));
    }
    if diagnostics.iter().any(Diagnostic::is_error) { Err(diagnostics) } else { Ok((robot, diagnostics)) }
}

/// Writes a robot as such a file: link frames are its frames, z along the joints, at joint values zero; frames that do not
/// move are merged into the next one that does. `hash` is that by which the driver identifies the robot.
///
/// The tool, and where the robot stands, are no part of the file. A warning says so of a tool, and of a missing hash.
///
/// # Errors
/// Where the robot is no chain of six revolute joints of that build, each moved by a variable of its own in the positive
/// sense: the axes of joints 2 to 4 parallel, all others square to the one before.
pub fn write(robot: &Robot, hash: Option<&str>) -> Result<(String, Vec<Diagnostic>), Diagnostic> {
    let (origins, tail) = origins(robot)?;
    for (at, (pose, (link, _, wanted))) in origins.iter().zip(LINKS).enumerate().skip(1) {
        let axis = pose.rotation.matrix().column(2).into_owned();
        let angle = axis.x.hypot(axis.y).atan2(axis.z.abs());
        if (angle - wanted).abs() > SKEW {
            let word = if wanted == 0.0 { "parallel with" } else { "square to" };
            let found = angle.to_degrees();
            let message = format!(
                "joint {} (`{link}`) is not {word} the joint before: {found:.1} deg between their axes",
                at + 1
            );
            return Err(refused(message));
        }
    }
    let mut diagnostics = Vec::new();
    let Placement { position, rotation } = robot.tool.placement;
    let tool = tail * Isometry::from_parts(position.into(), Rotation3::from_scaled_axis(rotation));
    if (tool.to_homogeneous() - Matrix4::identity()).amax() > 1e-9 {
        let message = "the tool is not written: the file ends at the last joint's frame";
        diagnostics.push(Diagnostic::warning(message).remedy("give the driver the tool as a frame of its own"));
    }
    let mut text = String::from("kinematics:\n");
    for (pose, (link, ..)) in origins.iter().zip(LINKS) {
        let scale = 1.0 + pose.translation.vector.norm();
        let at = pose.translation.vector.map(|length| clean(length, scale));
        let turn = roll_pitch_yaw(&pose.rotation);
        let values = [("x", at.x), ("y", at.y), ("z", at.z), ("roll", turn.x), ("pitch", turn.y), ("yaw", turn.z)];
        text.push_str(&format!("  {link}:\n"));
        values.iter().for_each(|(key, value)| text.push_str(&format!("    {key}: {}\n", with_point(value + 0.0))));
    }
    match hash {
        // Quoted where it would be no text in YAML.
        Some(hash) => text.push_str(&format!("  hash: {}\n", yaml::write(&hash).unwrap_or_default().trim_end())),
        None => {
            text.push_str("  hash: calib_unknown\n");
            let message = "the robot's hash is not known; `calib_unknown` is written, and the driver will warn of it";
            let remedy = "take `hash` from the file that `ur_calibration` wrote: `ur_kinematics: {hash: calib_...}`";
            diagnostics.push(Diagnostic::warning(message).remedy(remedy));
        }
    }
    Ok((text, diagnostics))
}

fn refused(message: String) -> Diagnostic {
    let remedy = "such a file holds six revolute joints in series, each with a variable of its own, joints 2 to 4 parallel \
                  and all others square to the one before; write a .urdf or .yaml instead";
    Diagnostic::error(format!("this robot cannot be written as UR kinematics: {message}")).remedy(remedy)
}

/// Where each joint places its frame in that of the joint before, at zero; and what follows the last.
fn origins(robot: &Robot) -> Result<(Vec<Isometry>, Isometry), Diagnostic> {
    let mut path: Vec<usize> =
        std::iter::successors(Some(robot.tool.frame), |&frame| Some(robot.frames.get(frame)?.antecedent))
            .take_while(|&frame| frame != 0)
            .collect();
    path.reverse();
    let (mut origins, mut pose) = (Vec::new(), Isometry::identity());
    for frame in path.into_iter().filter_map(|frame| robot.frames.get(frame)) {
        let mut constants = frame.constants;
        match (frame.joint, frame.motion) {
            (JointKind::Fixed, _) => {
                pose *= constants.isometry();
                continue;
            }
            (JointKind::Revolute, Motion::Variable { direction, .. }) if direction > 0.0 => {
                constants.theta += frame.offset
            }
            (JointKind::Revolute, Motion::Variable { .. }) => {
                return Err(refused(format!("the joint `{}` is counted backwards", frame.name)));
            }
            (JointKind::Prismatic, _) => return Err(refused(format!("the joint `{}` slides", frame.name))),
            (JointKind::Revolute, _) => {
                return Err(refused(format!("the joint `{}` has no variable of its own", frame.name)));
            }
        }
        origins.push(pose * constants.isometry());
        pose = Isometry::identity();
    }
    match origins.len() {
        6 => Ok((origins, pose)),
        count => Err(refused(format!("{count} joints carry its tool"))),
    }
}

/// A number with a decimal point, without which readers of YAML 1.1 take `1e-5` for text.
fn with_point(value: f64) -> String {
    let text = format!("{value:?}");
    match text.split_once('e') {
        Some((digits, exponent)) if !digits.contains('.') => format!("{digits}.0e{exponent}"),
        _ => text,
    }
}
