//! The observation matrix of a campaign and its reduction, without a fit.

use super::calibration::{CalibrationError, columns_about};
use super::problem::row_sigmas;
use super::registration::{arrangement, rough};
use crate::description::campaign::Campaign;
use crate::identifiability::{Criterion, Identifiability, Scaling, reduce};
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::{Linearised, Predictor};

/// What a campaign can tell, and about which parameters.
#[derive(Debug, Clone)]
pub struct Observation {
    /// Parameters in the order of columns.
    pub slots: Vec<Slot>,
    /// The reduction.
    pub identifiability: Identifiability,
}

/// Reduces the observation matrix of `campaign` at the description's values (base and tool roughly registered where the
/// campaign estimates them). `hold` names parameters to be held.
///
/// # Errors
/// As [`super::calibrate`].
pub fn observe(
    model: &Model,
    campaign: &Campaign,
    hold: &[String],
    scaling: Scaling,
    criterion: Criterion,
) -> Result<Observation, CalibrationError> {
    let mut slots = arrangement(model, campaign);
    slots.extend(model.free_slots().into_iter().filter(|slot| model.registry[*slot].group == Group::Geometry));
    if slots.is_empty() {
        return Err(CalibrationError::NothingFree);
    }
    let predictor = Predictor::new(model, campaign, slots.clone())?;
    let start = rough(model, campaign, &model.registry.nominal())?;
    let mut found = Linearised::default();
    predictor.linearise(&start, true, &mut found)?;
    for (row, sigma) in found.jacobian.chunks_mut(slots.len()).zip(row_sigmas(campaign)) {
        row.iter_mut().for_each(|value| *value /= sigma);
    }
    let held: Vec<Slot> = hold.iter().filter_map(|name| model.registry.slot(name)).collect();
    let identifiability = reduce(&found.jacobian, &columns_about(model, &slots, &held), scaling, criterion);
    Ok(Observation { slots, identifiability })
}
