//! Straight moves: where a controller arrives that moves the tool on a line from one point to the next.

use nalgebra::Point3;

use crate::kinematics::{Geometry, Hold, InverseSettings, Placements, Target, Transform, solve};

/// Parts of a move, after each of which the joints are followed: a wrist that turns over does so within one of them.
const PARTS: usize = 16;
/// Joints (rad, or a part of a metre) up to which the end is the one meant.
const SAME: f64 = 1e-3;

/// Joints (rad, m) at which a straight move of the tool from `from` arrives at the pose of `to`, where these are others than
/// `to`, and none of them where it cannot be followed there: it would pass a singular configuration or a limit. `None` where it
/// arrives at `to`, and for robots with more variables than a pose has, whose controllers choose.
///
/// ```
/// use elastogeo::compensation::astray;
/// use elastogeo::kinematics::Geometry;
///
/// let robot = elastogeo::files::load_robot("universal-ur5")?;
/// let geometry = Geometry::nominal(&robot.model)?;
/// let from = [0.1, -1.0, 1.2, 0.2, 0.5, 0.3];
/// assert_eq!(astray(&geometry, &from, &[0.2, -1.0, 1.2, 0.2, 0.6, 0.3]), None);
/// // The wrist would have to turn over on the way.
/// assert!(astray(&geometry, &from, &[0.1, -1.0, 1.2, 0.2, -0.5, 0.3]).is_some());
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn astray(geometry: &Geometry, from: &[f64], to: &[f64]) -> Option<Vec<f64>> {
    if to.len() > 6 {
        return None;
    }
    let hold = Hold::of(to.len());
    let tool = geometry.tool();
    let mut placements = Placements::default();
    let mut pose = |q: &[f64]| -> Option<Transform> {
        geometry.place(q, &mut placements).ok()?;
        Some(placements.frames.get(geometry.model.tool.0)? * tool)
    };
    let [first, last] = [pose(from)?, pose(to)?];
    let mut joints = from.to_vec();
    for part in 1..=PARTS {
        let share = part as f64 / PARTS as f64;
        let position = first.translation.vector.lerp(&last.translation.vector, share);
        let turn = (last.rotation * first.rotation.inverse()).powf(share);
        let target = Target { position: Point3::from(position), rotation: Some(turn * first.rotation), hold };
        let settings = InverseSettings { restarts: 0, from: Some(joints), ..InverseSettings::default() };
        match solve(geometry, &target, &settings).map(|found| found.into_iter().next()) {
            Ok(Some(next)) => joints = next.joints,
            _ => return Some(Vec::new()),
        }
    }
    let is_same = joints.iter().zip(to).all(|(end, meant)| (end - meant).abs() < SAME);
    (!is_same).then_some(joints)
}
