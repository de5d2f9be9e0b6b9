//! A solution of the inverse model, moved to where the deflected robot meets the target.

use std::f64::consts::PI;

use super::{Desired, Refusal, Settings, correct};
use crate::kinematics::{Solution, Target, Transform};
use crate::prediction::{SinglePredictor, SingleWorkspace};

/// Residual up to which the loaded tool is brought to the target, m, and rad on a lever of 1 m: rounding.
const RESIDUAL: f64 = 2e-13;

/// The joints near a solution of the rigid robot at which the tool is at the target under own weight, preloads and effects.
/// The predictor's first point is the tool.
///
/// # Errors
/// [`Refusal`] if none are found.
pub fn deflected(
    predictor: &SinglePredictor,
    target: &Target,
    rigid: &Solution,
    work: &mut SingleWorkspace,
) -> Result<Solution, Refusal> {
    let settings = Settings { hold: target.hold, residual: RESIDUAL, largest: PI, ..Settings::new(rigid.joints.len()) };
    let pose = Transform::from_parts(target.position.coords.into(), target.rotation.unwrap_or_default());
    let desired = Desired { nominal: rigid.joints.clone(), target: pose };
    let corrected = correct(predictor, 0, &desired, &[0.0; 6], &settings, work)?;
    Ok(Solution {
        joints: corrected.joints,
        position_error: corrected.position,
        orientation_error: corrected.orientation,
        self_motions: rigid.self_motions,
    })
}
