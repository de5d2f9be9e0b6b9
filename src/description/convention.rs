//! Tables of Denavit and Hartenberg: frames declared in one of their two conventions, as Khalil and Kleinfinger write them.
//!
//! * Modified (J. J. Craig, "Introduction to Robotics", 1986): frame i is placed in the one before by
//!   Rx(alpha) Tx(a) Rz(theta) Tz(d), where alpha and a are those that the book numbers i-1. It is the frame of Khalil and
//!   Kleinfinger with gamma = b = 0, `a` being their `d` and `d` their `r`.
//! * Classical (J. Denavit and R. S. Hartenberg, J. Applied Mechanics 22, 1955; as in the textbooks of Paul and of Spong):
//!   frame i is placed by Rz(theta) Tz(d) Tx(a) Rx(alpha), so that z of the frame before is the axis of joint i. The frame
//!   of Khalil and Kleinfinger with z on the axis of joint i stands before Tx(a) Rx(alpha), which places all that hangs on
//!   frame i: the next frames take `alpha` and `a` over, and points of the body are moved.

use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};

use super::khalil_kleinfinger::{Isometry, about_x};
use super::raw::{Convention, JointKind, RawFrame, RawRobot};
use crate::diagnostic::{Code, Diagnostic, Explained, Locate};

/// The description with its frames as Khalil and Kleinfinger write them, and what is wrong with the table. Of a description
/// that is declared so already, only keys that it cannot have are reported.
///
/// A modified table is remembered, so that [`as_declared`] writes it back.
pub fn khalil_kleinfinger(raw: &RawRobot, locate: Locate, explained: Explained) -> (RawRobot, Vec<Diagnostic>) {
    let convention = raw.convention.unwrap_or(Convention::KhalilKleinfinger);
    let mut diagnostics = Vec::new();
    for (name, frame) in &raw.frames {
        check_keys(convention, name, frame, &mut |key, message, remedy| {
            let missing = frame_key(frame, key).is_none();
            if !(missing && explained(&["frames", name, key])) {
                let code = if missing { Code::Missing } else { Code::Unknown };
                let diagnostic = Diagnostic::error(message).code(code).at(locate(&["frames", name, key]));
                diagnostics.push(diagnostic.remedy(remedy));
            }
        });
    }
    let mut written = RawRobot { convention: None, ..raw.clone() };
    match convention {
        Convention::KhalilKleinfinger => {
            // Once for the table: the convention is what is missing, or misspelt, which has been reported.
            diagnostics.truncate(if explained(&["convention"]) { 0 } else { 1 });
            written.frames.values_mut().for_each(|frame| frame.a = None);
        }
        Convention::ModifiedDh => {
            written.declared = Some(convention);
            written.frames.values_mut().for_each(|frame| (frame.a, frame.d, frame.r) = (None, frame.a, frame.d));
        }
        Convention::ClassicalDh => {
            check_sections(raw, locate, &mut diagnostics);
            from_classical(raw, &mut written);
        }
    }
    let start = raw.urdf.as_ref().map(|_| "urdf").or_else(|| raw.ur_kinematics.as_ref().map(|_| "ur_kinematics"));
    if let Some(start) = start.filter(|_| convention != Convention::KhalilKleinfinger) {
        let message = format!("frames of `{start}` are not those of a Denavit-Hartenberg table");
        let diagnostic = Diagnostic::error(message).at(locate(&["convention"]));
        diagnostics.push(diagnostic.remedy(format!("leave out `convention`, or `{start}`")));
    }
    (written, diagnostics)
}

/// The description in the convention in which it was declared, where any calibrated robot can be written in it: a modified
/// table (with `beta` in addition to its columns where an axis is near-parallel to the one before). A classical one cannot hold every
/// calibrated robot, and is written with the constants of Khalil and Kleinfinger.
#[must_use]
pub fn as_declared(raw: &RawRobot) -> RawRobot {
    let mut written = raw.clone();
    if written.declared.take() == Some(Convention::ModifiedDh) {
        written.convention = Some(Convention::ModifiedDh);
        for frame in written.frames.values_mut() {
            let (a, d) = (frame.d.unwrap_or(0.0), frame.r.unwrap_or(0.0));
            let shared = frame.coaxial.is_some();
            (frame.alpha, frame.a) = if shared { (None, None) } else { (frame.alpha.or(Some(0.0)), Some(a)) };
            (frame.theta, frame.d, frame.r) = (frame.theta.or(Some(0.0)), Some(d), None);
        }
    }
    written
}

/// Where a path of the description as Khalil and Kleinfinger write it stands in the one declared in `convention`;
/// `antecedent` is that of the frame.
pub fn declared_path<'p>(convention: Convention, path: &[&'p str], antecedent: Option<&'p str>) -> Vec<&'p str> {
    let mut path = path.to_vec();
    if let ["frames", name, key] = path.as_mut_slice() {
        let before = matches!(*key, "alpha" | "d") && convention == Convention::ClassicalDh;
        if convention != Convention::KhalilKleinfinger {
            *key = match *key {
                "d" => "a",
                "r" => "d",
                other => other,
            };
        }
        if let Some(antecedent) = antecedent.filter(|antecedent| before && *antecedent != "0") {
            *name = antecedent;
        }
    }
    path
}

fn frame_key(frame: &RawFrame, key: &str) -> Option<f64> {
    let RawFrame { beta, gamma, b, alpha, d, theta, r, a, .. } = *frame;
    let keys =
        [("beta", beta), ("gamma", gamma), ("b", b), ("alpha", alpha), ("d", d), ("theta", theta), ("r", r), ("a", a)];
    keys.into_iter().find(|(name, _)| *name == key).and_then(|(_, value)| value)
}

/// Calls `fault` with key, message and remedy of every key that a frame has and its convention has not, and of every column
/// that a joint lacks: of theta (of d of a prismatic joint), to which the variable is added, nothing is asked.
fn check_keys(convention: Convention, name: &str, frame: &RawFrame, fault: &mut dyn FnMut(&str, String, String)) {
    let label = convention.name();
    let strange: &[&str] = match convention {
        Convention::KhalilKleinfinger => &["a"],
        Convention::ModifiedDh => &["r"],
        Convention::ClassicalDh => &["r", "beta", "gamma", "b"],
    };
    for key in strange.iter().filter(|key| frame_key(frame, key).is_some()) {
        let remedy = match (*key, convention) {
            ("a", _) => "write `d` for it, or `convention: modified-dh` or `classical-dh` if this is such a table",
            ("r", _) => "its columns are `theta`, `d` (along z), `a` (along x) and `alpha`: write `d`",
            _ => {
                "its columns are `theta`, `d`, `a` and `alpha`; what needs more is declared with `convention: khalil-kleinfinger`"
            }
        };
        fault(key, format!("`{key}` of frame `{name}` is not a key of the convention {label}"), remedy.to_owned());
    }
    if convention == Convention::KhalilKleinfinger {
        return;
    }
    let needed: &[&str] = match frame.joint {
        Some(JointKind::Revolute) => &["d", "a", "alpha"],
        Some(JointKind::Prismatic) => &["theta", "a", "alpha"],
        Some(JointKind::Fixed) | None => &[],
    };
    let shared = |key: &str| frame.coaxial.is_some() && matches!(key, "a" | "alpha");
    for key in needed.iter().filter(|key| frame_key(frame, key).is_none() && !shared(key)) {
        let message = format!("row `{name}` of the {label} table lacks `{key}`");
        fault(key, message, format!("write `{key}: 0` if it is zero"));
    }
}

/// Reports what a classical table cannot be read with.
fn check_sections(raw: &RawRobot, locate: Locate, diagnostics: &mut Vec<Diagnostic>) {
    let sections =
        [("loops", raw.loops.is_empty()), ("nodes", raw.nodes.is_empty()), ("springs", raw.springs.is_empty())];
    let coaxial = raw.frames.iter().filter(|(_, frame)| frame.coaxial.is_some());
    let paths = sections.into_iter().filter(|(_, empty)| !empty).map(|(section, _)| vec![section]);
    for path in paths.chain(coaxial.map(|(name, _)| vec!["frames", name, "coaxial"])) {
        let what = path.last().copied().unwrap_or_default();
        let message = format!("`{what}` cannot stand next to a classical-dh table");
        let remedy = "its frames lie at the far end of their bodies: `elastogeo convert` writes the robot without this, with frames \
                      on their joints; add it there";
        diagnostics.push(Diagnostic::error(message).at(locate(&path)).remedy(remedy));
    }
}

fn from_classical(raw: &RawRobot, written: &mut RawRobot) {
    let angle = raw.units.angle.factor();
    // The pose of the declared frame in the one on the joint, in the file's length unit.
    let beyond = |name: &str| {
        let frame = raw.frames.get(name);
        // What is not finite is reported of the frame, not of what hangs on it.
        let value = |key: fn(&RawFrame) -> Option<f64>| frame.and_then(key).filter(|v| v.is_finite()).unwrap_or(0.0);
        let along = Translation3::new(value(|frame| frame.a), 0.0, 0.0);
        Isometry::from_parts(along, about_x(value(|frame| frame.alpha) * angle))
    };
    for (name, frame) in &mut written.frames {
        let Some(row) = raw.frames.get(name) else { continue };
        let before = row.antecedent.as_ref().and_then(|antecedent| raw.frames.get(antecedent));
        (frame.alpha, frame.d) = before.map_or((None, None), |before| (before.alpha, before.a));
        (frame.r, frame.a) = (row.d, None);
    }
    let moved = |name: &str, at: Option<[f64; 3]>| {
        let pose = beyond(name);
        if pose == Isometry::identity() {
            return at;
        }
        let at = (pose * Point3::from(at.unwrap_or_default())).coords;
        (at != Vector3::zeros()).then_some([at.x, at.y, at.z])
    };
    let leaf = {
        let carries = |name: &str| raw.frames.values().any(|frame| frame.antecedent.as_deref() == Some(name));
        let mut leaves = raw.frames.keys().filter(|name| !carries(name));
        leaves.next().filter(|_| leaves.next().is_none())
    };
    let tool = raw.tool.frame.as_ref().or(leaf).map_or("0", String::as_str);
    let turn = UnitQuaternion::from_rotation_matrix(&beyond(tool).rotation);
    if turn != UnitQuaternion::identity() {
        let given = UnitQuaternion::from_scaled_axis(Vector3::from(raw.tool.rotation.unwrap_or_default()) * angle);
        let rotation = (turn * given).scaled_axis() / angle;
        written.tool.rotation = (rotation != Vector3::zeros()).then_some(rotation.into());
    }
    written.tool.at = moved(tool, raw.tool.at);
    if written.tool != raw.tool {
        written.tool.frame = Some(tool.to_owned());
    }
    for marker in written.markers.values_mut() {
        marker.at = moved(marker.frame.as_deref().unwrap_or(tool), marker.at);
    }
    for (name, body) in &mut written.bodies {
        body.com = moved(name, body.com);
    }
}
