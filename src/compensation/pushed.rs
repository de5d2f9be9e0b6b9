//! By how much what pushes on the tool moves it along a path: what a user varies parameters for.

use nalgebra::Vector3;

use super::path::predict_path;
use super::{Desired, Refusal, Settings};
use crate::description::campaign::Campaign;
use crate::kinematics::AssemblyError;
use crate::model::Model;
use crate::process::Process;

/// Displacement (m, base axes) of each point, uncorrected, by the wrenches of the path and by a process's strip and springs: how
/// much farther the tool is than with own weight and what the process carries alone. Of a process that only carries it is what
/// that does.
///
/// # Errors
/// As [`predict_path`].
pub fn pushed(
    model: &Model,
    values: &[f64],
    path: &Campaign,
    desired: &[Result<Desired, Refusal>],
    process: Option<&Process>,
    settings: &Settings,
) -> Result<Vec<Result<Vector3<f64>, Refusal>>, AssemblyError> {
    let mut free = path.clone();
    free.readings.iter_mut().for_each(|reading| reading.wrench = [0.0; 6]);
    let carries = process.filter(|process| process.strip.is_some() || !process.springs.is_empty());
    let carries = carries.map(|process| Process { strip: None, springs: Vec::new(), ..process.clone() });
    let loaded = predict_path(model, values, &mut path.clone(), desired, process, settings)?;
    let free = predict_path(model, values, &mut free, desired, carries.as_ref(), settings)?;
    let at = |found: Result<super::Balance, Refusal>| found.map(|found| found.seen.real.translation.vector);
    Ok(loaded.into_iter().zip(free).map(|(loaded, free)| Ok(at(loaded)? - at(free)?)).collect())
}
