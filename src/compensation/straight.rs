//! Straight moves: where a controller arrives that moves the tool on a line from one point to the next.

use nalgebra::{Matrix6, Point3};

use crate::kinematics::{
    By, ErrorColumns, Geometry, Hold, InverseSettings, Placements, Rates, Target, Transform, solve,
};

/// Parts of a move, after each of which the joints are followed: a wrist that turns over does so within one of them.
const PARTS: usize = 16;
/// Joints (rad, or a part of a metre) up to which the end is the one meant.
const SAME: f64 = 1e-3;

/// Whether a straight move of the tool from joints `from` (rad, m) to the pose of `to` does not lead to the joints `to`: it arrives
/// at others, cannot be followed, or passes a singular configuration, on the other side of which these lie (the determinant of
/// the Jacobian has another sign). Never for robots with more variables than a pose has, whose controllers choose.
///
/// ```
/// use elastogeo::compensation::astray;
/// use elastogeo::kinematics::Geometry;
///
/// let robot = elastogeo::files::load_robot("universal-ur5")?;
/// let geometry = Geometry::nominal(&robot.model)?;
/// let from = [0.1, -1.0, 1.2, 0.2, 0.5, 0.3];
/// assert!(!astray(&geometry, &from, &[0.2, -1.0, 1.2, 0.2, 0.6, 0.3]));
/// // The wrist would have to turn over on the way.
/// assert!(astray(&geometry, &from, &[0.1, -1.0, 1.2, 0.2, -0.5, 0.3]));
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn astray(geometry: &Geometry, from: &[f64], to: &[f64]) -> bool {
    if to.len() > 6 {
        return false;
    }
    if side(geometry, from) * side(geometry, to) < 0.0 {
        return true;
    }
    let hold = Hold::of(to.len());
    let tool = geometry.tool();
    let mut placements = Placements::default();
    let mut pose = |q: &[f64]| -> Option<Transform> {
        geometry.place(q, &mut placements).ok()?;
        Some(placements.frames.get(geometry.model.tool.0)? * tool)
    };
    let (Some(first), Some(last)) = (pose(from), pose(to)) else { return true };
    let mut joints = from.to_vec();
    for part in 1..=PARTS {
        let share = part as f64 / PARTS as f64;
        let position = first.translation.vector.lerp(&last.translation.vector, share);
        let turn = (last.rotation * first.rotation.inverse()).powf(share);
        let target = Target { position: Point3::from(position), rotation: Some(turn * first.rotation), hold };
        let settings = InverseSettings { restarts: 0, from: Some(joints), ..InverseSettings::default() };
        match solve(geometry, &target, &settings).map(|found| found.into_iter().next()) {
            Ok(Some(next)) => joints = next.joints,
            _ => return true,
        }
    }
    joints.iter().zip(to).any(|(end, meant)| (end - meant).abs() >= SAME)
}

/// Sign of the determinant of the Jacobian of the tool by six variables, which changes only at singular configurations; 0 for fewer.
fn side(geometry: &Geometry, q: &[f64]) -> f64 {
    if q.len() != 6 {
        return 0.0;
    }
    let (mut placements, mut rates) = (Placements::default(), Rates::new(geometry.model));
    if geometry.place(q, &mut placements).is_err() {
        return 0.0;
    }
    rates.evaluate(geometry, q, &placements);
    let by: Vec<By> = (0..6).map(By::Variable).collect();
    let plan = ErrorColumns::new(geometry, &rates, geometry.model.tool.0, &by);
    let mut columns = [[0.0; 6]; 6];
    plan.evaluate(geometry, &placements, &rates, &mut columns);
    Matrix6::from_fn(|row, column| columns[column][row]).determinant().signum()
}
