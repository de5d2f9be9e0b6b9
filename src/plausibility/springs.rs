//! Springs of a description against those of arms of its size.

use nalgebra::SymmetricEigen;

use super::evidence::{Evidence, Limits};
use super::hypothesis::total_length;
use crate::description::campaign::Reading;
use crate::diagnostic::Diagnostic;
use crate::model::Model;
use crate::parameter::Kind;
use crate::state::{Loads, Mechanics};

/// Stiffness of the tool in its softest direction, N/m, with every variable in the middle of its limits; `None` where nothing is
/// elastic or that configuration does not exist.
fn softest(model: &Model) -> Option<f64> {
    let loads = Loads { wrench: true, weight: false };
    let mechanics = Mechanics::new(model, &model.registry.nominal(), loads, &[]).ok()?;
    let mut state = mechanics.state();
    mechanics.place(&model.middle(), &mut state).ok()?;
    let found = mechanics.compliance(&state, &mechanics.point(&state, None, &[0.0; 6]));
    let translation = found.fixed_view::<3, 3>(0, 0);
    // Rules identified component by component are reciprocal only as far as the readings were.
    let most = SymmetricEigen::new(0.5 * (translation + translation.transpose())).eigenvalues.max();
    (most > 0.0 && most.is_finite()).then_some(most.recip())
}

/// The same of the robot of a campaign, where its readings are loaded or its bodies weigh something.
pub(super) fn as_declared(evidence: &Evidence, limits: &Limits) -> Vec<Diagnostic> {
    let (model, campaign) = (evidence.model, evidence.campaign);
    let is_bent = !model.structure.masses.is_empty() || campaign.readings.iter().any(Reading::is_loaded);
    as_stiff_as_arms(model, limits).filter(|_| is_bent).into_iter().collect()
}

/// Whether a compliance (m/N or rad/(N.m)) by itself makes an arm of this size softer than any.
pub(super) fn is_too_soft(model: &Model, kind: Kind, compliance: f64, limits: &Limits) -> bool {
    let size = total_length(model);
    let at_tool = match kind {
        Kind::LinearCompliance => compliance,
        Kind::RotationalCompliance => compliance * size.powi(2),
        _ => return false,
    };
    size > 0.0 && at_tool * limits.softest * size.powi(2) > 1.0
}

/// What to say of springs that hold an arm far worse or better than those of arms of its size do: a unit is wrong, or a power of ten.
pub fn as_stiff_as_arms(model: &Model, limits: &Limits) -> Option<Diagnostic> {
    let size = total_length(model);
    let stiffness = softest(model).filter(|_| size > 0.0)?;
    let than = if stiffness < limits.softest * size.powi(2) {
        "softer than any arm of its size"
    } else if stiffness > limits.stiffest * size {
        "stiffer than a bar of steel of its size"
    } else {
        return None;
    };
    let millimetres = 1e6 / stiffness;
    let message = format!(
        "1 kN displaces the tool of `{}` by {millimetres:.2e} mm where it is softest, in the middle of its limits: {than}",
        model.name
    );
    let remedy = "look at the units and powers of ten of stiffness and compliance";
    Some(Diagnostic::warning(message).figure("stiffness", stiffness).remedy(remedy))
}
