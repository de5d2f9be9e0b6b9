//! Where every frame lies: the product of transforms of a URDF, and that of a description, by nalgebra's quaternions and
//! nothing of the library but its data types.

use std::collections::HashMap;

use elastogeo::description::raw::{JointKind, RawFrame, RawRobot};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::JointType;

/// Joint values by joint.
pub type Values = HashMap<String, f64>;

/// Pose of each joint's child link at these values of the joints that mimic nothing.
pub fn of_urdf(text: &str, values: &Values) -> HashMap<String, Isometry3<f64>> {
    let robot = urdf_rs::read_from_string(text.trim_start()).unwrap();
    let value = |name: &str| -> f64 {
        let (mut name, mut factor, mut offset) = (name.to_owned(), 1.0, 0.0);
        loop {
            let joint = robot.joints.iter().find(|joint| joint.name == name).unwrap();
            let Some(mimic) = &joint.mimic else { break };
            offset += factor * mimic.offset.unwrap_or(0.0);
            factor *= mimic.multiplier.unwrap_or(1.0);
            name = mimic.joint.clone();
        }
        factor * values.get(&name).copied().unwrap_or(0.0) + offset
    };
    let mut links: HashMap<String, Isometry3<f64>> = HashMap::new();
    for link in &robot.links {
        if robot.joints.iter().all(|joint| joint.child.link != link.name) {
            links.insert(link.name.clone(), Isometry3::identity());
        }
    }
    let mut joints = HashMap::new();
    while joints.len() < robot.joints.len() {
        for joint in &robot.joints {
            let Some(parent) = links.get(&joint.parent.link).copied() else { continue };
            let [roll, pitch, yaw] = joint.origin.rpy.0;
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw)
                * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), pitch)
                * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), roll);
            let origin = Isometry3::from_parts(Translation3::from(Vector3::from(joint.origin.xyz.0)), turn);
            let axis = Unit::new_normalize(Vector3::from(joint.axis.xyz.0));
            let motion = match joint.joint_type {
                JointType::Fixed => Isometry3::identity(),
                JointType::Prismatic => {
                    Isometry3::from_parts((axis.into_inner() * value(&joint.name)).into(), UnitQuaternion::identity())
                }
                _ => Isometry3::from_parts(
                    Translation3::identity(),
                    UnitQuaternion::from_axis_angle(&axis, value(&joint.name)),
                ),
            };
            let pose = parent * origin * motion;
            links.insert(joint.child.link.clone(), pose);
            joints.insert(joint.name.clone(), pose);
        }
    }
    joints
}

/// The six (seven) elementary transforms of a frame, `angle` and `length` being the SI value of the file's units.
pub fn elementary(frame: &RawFrame, q: f64, angle: f64, length: f64) -> Isometry3<f64> {
    let turn = |axis: Unit<Vector3<f64>>, value: f64| {
        Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&axis, value))
    };
    let shift =
        |axis: Unit<Vector3<f64>>, value: f64| Isometry3::translation(axis.x * value, axis.y * value, axis.z * value);
    let a = |value: Option<f64>| value.unwrap_or(0.0) * angle;
    let l = |value: Option<f64>| value.unwrap_or(0.0) * length;
    let (about, along) = match frame.joint.unwrap_or(JointKind::Fixed) {
        JointKind::Revolute => (q, 0.0),
        JointKind::Prismatic => (0.0, q),
        JointKind::Fixed => (0.0, 0.0),
    };
    let (x, y, z) = (Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis());
    turn(y, a(frame.beta))
        * turn(z, a(frame.gamma))
        * shift(z, l(frame.b))
        * turn(x, a(frame.alpha))
        * shift(x, l(frame.d))
        * turn(z, a(frame.theta) + about)
        * shift(z, l(frame.r) + along)
}

/// Pose of every frame of a description at these values of the variables (in SI, by variable); couplings have one term.
pub fn of_description(robot: &RawRobot, values: &Values) -> HashMap<String, Isometry3<f64>> {
    let (angle, length) = (robot.units.angle.factor(), robot.units.length.factor());
    let mut follows: HashMap<&str, (f64, &str)> = HashMap::new();
    for coupling in &robot.couplings {
        let (name, rest) = coupling.split_once(" = ").unwrap();
        let (factor, master) = rest.split_once(" * ").unwrap();
        follows.insert(name, (factor.parse().unwrap(), master));
    }
    let joint = |name: &str| -> f64 {
        let (mut sum, mut factor, mut name) = (0.0, 1.0, name);
        loop {
            let frame = &robot.frames[name];
            let unit = if frame.joint == Some(JointKind::Prismatic) { length } else { angle };
            let value = frame.variable.as_ref().and_then(|variable| values.get(variable)).copied().unwrap_or(0.0);
            sum += factor * (frame.direction.unwrap_or(1.0) * value + frame.offset.unwrap_or(0.0) * unit);
            let Some(&(share, master)) = follows.get(name) else { break sum };
            factor *= share;
            name = master;
        }
    };
    let mut poses = HashMap::from([("0".to_owned(), Isometry3::identity())]);
    while poses.len() <= robot.frames.len() {
        for (name, frame) in &robot.frames {
            let Some(antecedent) = poses.get(frame.antecedent.as_ref().unwrap()).copied() else { continue };
            let mut placed = frame.clone();
            if let Some(other) = &frame.coaxial {
                let RawFrame { beta, gamma, b, alpha, d, .. } = robot.frames[other];
                placed = RawFrame { beta, gamma, b, alpha, d, ..placed };
            }
            poses.insert(name.clone(), antecedent * elementary(&placed, joint(name), angle, length));
        }
    }
    poses
}

/// Largest difference of the matrices of two poses, lengths being divided by 1 + the size of `b`.
pub fn apart(a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    let turn = (a.rotation.to_rotation_matrix().matrix() - b.rotation.to_rotation_matrix().matrix()).amax();
    let shift = (a.translation.vector - b.translation.vector).amax() / (1.0 + b.translation.vector.norm());
    turn.max(shift)
}

/// Asserts that a description is the URDF, at these values: same axes (for a slide: same direction), same fixed links,
/// same tool.
pub fn assert_same(text: &str, robot: &RawRobot, values: &Values, tolerance: f64) {
    let (urdf, ours) = (of_urdf(text, values), of_description(robot, values));
    let model = urdf_rs::read_from_string(text.trim_start()).unwrap();
    assert_eq!(model.joints.len(), robot.frames.len());
    for joint in &model.joints {
        let (theirs, mine) = (&urdf[&joint.name], &ours[&joint.name]);
        if joint.joint_type == JointType::Fixed {
            let apart = apart(mine, theirs);
            assert!(apart < tolerance, "{}: {apart:e} apart\n{mine}{theirs}", joint.name);
            continue;
        }
        let direction = robot.frames[&joint.name].direction.unwrap_or(1.0);
        let axis = theirs * Vector3::from(joint.axis.xyz.0).normalize() * direction;
        let turned = (mine * Vector3::z() - axis).amax();
        assert!(turned < tolerance, "{}: axis off by {turned:e}", joint.name);
        let between = mine.translation.vector - theirs.translation.vector;
        let off = between.cross(&axis).norm() / (1.0 + between.norm() + theirs.translation.vector.norm());
        assert!(joint.joint_type == JointType::Prismatic || off < tolerance, "{}: axis {off:e} aside", joint.name);
    }
    if let Some(frame) = &robot.tool.frame {
        let at =
            Isometry3::new(robot.tool.at.unwrap_or_default().into(), robot.tool.rotation.unwrap_or_default().into());
        let apart = apart(&(ours[frame] * at), &urdf[frame]);
        assert!(apart < tolerance, "tool: {apart:e} apart");
    }
}
