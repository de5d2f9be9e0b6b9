//! Joints that follow others: from the couplings of a description to what URDF calls mimic.

use std::collections::HashMap;

use crate::description::coupling::{is_of_controller, parse_coupling};
use crate::description::raw::{JointKind, RawFrame, RawRobot};
use crate::diagnostic::Diagnostic;

/// How the URDF value u of a joint stands to the frame's joint variable q and to the joint it mimics, if any:
/// q = direction u + constant, u = factor * (u of the master). SI.
pub(super) struct Follower<'a> {
    pub(super) constant: f64,
    pub(super) master: Option<(&'a str, f64)>,
}

/// How each moving joint follows another.
pub(super) type Followers<'a> = HashMap<&'a str, Follower<'a>>;

/// How each moving joint follows another, down chains of couplings, which form no circle.
pub(super) fn followers<'a>(robot: &'a RawRobot, diagnostics: &mut Vec<Diagnostic>) -> Followers<'a> {
    let single = single_terms(robot, diagnostics);
    let mut followers = HashMap::new();
    for (name, frame) in robot.frames.iter().filter(|(_, frame)| moves(frame)) {
        let sign = direction(frame);
        let mut is_commanded = false;
        // q = factor * q of `at` + constant, the master's own zero included.
        let (mut factor, mut constant, mut at) = (1.0, offset(robot, frame), name.as_str());
        while let Some((&(master, share, is_of_controller), next)) =
            single.get(at).and_then(|term| Some((term, robot.frames.get(term.0)?)))
        {
            let units = robot.frames.get(at).map_or(1.0, |frame| joint_unit(robot, frame)) / joint_unit(robot, next);
            factor *= share * units;
            // What the controller adds up are its commands, without any zero.
            is_commanded |= is_of_controller;
            if !is_commanded {
                constant += factor * offset(robot, next);
            }
            at = master;
        }
        let master = robot.frames.get(at).filter(|_| at != name);
        let master = master.map(|master| (at, sign * factor * direction(master)));
        followers.insert(name.as_str(), Follower { constant, master });
    }
    followers
}

/// The couplings of one term: the joint that follows, the joint it follows, the factor, and whether it is the controller's.
fn single_terms<'a>(robot: &'a RawRobot, diagnostics: &mut Vec<Diagnostic>) -> HashMap<&'a str, (&'a str, f64, bool)> {
    let mut single = HashMap::new();
    for coupling in &robot.couplings {
        let Ok((name, terms)) = parse_coupling(coupling) else { continue };
        match terms.as_slice() {
            &[(factor, master)] => {
                single.insert(name, (master, factor, is_of_controller(coupling)));
            }
            _ => {
                let message = format!("the joint `{name}` follows several others (`{coupling}`): a URDF cannot say so");
                diagnostics.push(Diagnostic::warning(message).remedy("it is written as a joint of its own"));
            }
        }
    }
    single
}

/// Calibrated zero of a joint, SI.
fn offset(robot: &RawRobot, frame: &RawFrame) -> f64 {
    frame.offset.unwrap_or(0.0) * joint_unit(robot, frame)
}

/// SI value of one unit of a joint's variable.
pub(super) fn joint_unit(robot: &RawRobot, frame: &RawFrame) -> f64 {
    match frame.joint {
        Some(JointKind::Prismatic) => robot.units.length.factor(),
        _ => robot.units.angle.factor(),
    }
}

/// Whether the frame is that of a joint.
fn moves(frame: &RawFrame) -> bool {
    matches!(frame.joint, Some(JointKind::Revolute | JointKind::Prismatic))
}

/// +1 or -1.
pub(super) fn direction(frame: &RawFrame) -> f64 {
    frame.direction.unwrap_or(1.0)
}
