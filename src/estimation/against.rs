//! A calibration against another set of parameters, on the same readings (KR-270 paper, Tables IX and XIII).
//!
//! Base, tool and markers are fitted anew to the readings that the calibration fitted, for both sets in the same way, so that
//! neither is judged by where it was calibrated.

use std::borrow::Borrow;

use super::result::{Calibration, CalibrationError};
use super::settings::Settings;
use super::since::{Change, differences};
use super::task::{Request, Task};
use super::weighing::weighed;
use crate::description::campaign::Campaign;
use crate::description::raw::RawRobot;
use crate::model::Model;
use crate::parameter::{Group, Slot};

/// The other set of parameters: a description, its model, and the same readings as this model sees them.
#[derive(Debug, Clone, Copy)]
pub struct OtherSet<'a> {
    /// The description.
    pub raw: &'a RawRobot,
    /// Its model.
    pub model: &'a Model,
    /// The readings, as many as those calibrated and in their order.
    pub campaign: &'a Campaign,
}

/// Both sets on all readings of a campaign; residuals as [`crate::prediction::Linearised::residual`].
#[derive(Debug, Clone, PartialEq)]
pub struct Against {
    /// With the calibrated parameters.
    pub identified: Vec<f64>,
    /// With those of the other set.
    pub other: Vec<f64>,
    /// The calibrated parameters of the robot less the other set's, where both have them.
    pub differences: Vec<Change>,
    /// Calibrated parameters of the robot that the other set does not have.
    pub alone: Vec<Slot>,
}

/// The calibration `found` (of `model` on `campaign`, with `settings`) against another set.
///
/// # Errors
/// As [`super::calibrate`].
pub fn against(
    model: &Model,
    campaign: &Campaign,
    found: &Calibration,
    settings: &Settings,
    other: &OtherSet,
) -> Result<Against, CalibrationError> {
    let (here, there) = (campaign.readings.len(), other.campaign.readings.len());
    if here != there {
        let message = format!("the other description reads {there} readings where this one reads {here}");
        return Err(CalibrationError::Malformed(message));
    }
    let weighed = weighed(model, campaign, &found.held_out, settings)?;
    let campaign: &Campaign = weighed.borrow();
    // The same weights for both.
    let mut theirs = other.campaign.clone();
    let noises = campaign.readings.iter().map(|reading| reading.noise);
    theirs.readings.iter_mut().zip(noises).for_each(|(reading, noise)| reading.noise = noise);
    let has = |name: &String| other.model.registry.slot(name).is_some();
    let hold = settings.hold.iter().filter(|name| has(name)).cloned().collect();
    let slot_there = |slot: Slot| {
        let own = &model.registry[slot];
        let slot = other.model.registry.slot(&own.name)?;
        Some((slot, &other.model.registry[slot])).filter(|(_, parameter)| parameter.kind == own.kind)
    };
    let is_robot = |slot: &Slot| !matches!(model.registry[*slot].group, Group::Base | Group::Tool | Group::Arrangement);
    let kept = found.estimates.iter().filter(|estimate| estimate.identifiable()).map(|estimate| estimate.slot);
    Ok(Against {
        identified: predicted(model, campaign, found, settings, &found.values)?,
        other: predicted(
            other.model,
            &theirs,
            found,
            &Settings { hold, ..settings.clone() },
            &other.model.registry.nominal(),
        )?,
        differences: differences(other.raw, model, found, |estimate| {
            let (slot, parameter) = slot_there(estimate.slot).filter(|_| is_robot(&estimate.slot))?;
            Some((parameter, other.model.registry[slot].nominal))
        }),
        alone: kept.filter(|slot| is_robot(slot) && slot_there(*slot).is_none()).collect(),
    })
}

/// Residuals of all readings with the robot as `values` say, and base, tool and markers fitted to the readings that `found` fitted.
fn predicted(
    model: &Model,
    campaign: &Campaign,
    found: &Calibration,
    settings: &Settings,
    values: &[f64],
) -> Result<Vec<f64>, CalibrationError> {
    let mut task = Task::new(Request { model, campaign, held_out: &found.held_out, settings })?;
    task.nominal = values.to_vec();
    let registered = task.registered()?;
    Ok(task.errors(&registered)?.1)
}
