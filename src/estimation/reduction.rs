//! Which parameters a campaign can determine: the candidates, and the reduction of their observation matrix.

use std::borrow::Cow;

use super::problem::row_sigmas;
use super::registration::{arrangement, registered, rough};
use super::result::CalibrationError;
use super::settings::{RegistrationSettings, What};
use crate::description::campaign::{Campaign, Target};
use crate::identifiability::{Column, Criterion, Identifiability, Scaling, reduce};
use crate::model::Model;
use crate::parameter::{Group, Slot};
use crate::prediction::{PredictionError, Predictor, declared, seated};

/// Candidates and the reduction of their columns.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// Parameters in the order of columns.
    pub slots: Vec<Slot>,
    /// The reduction.
    pub identifiability: Identifiability,
}

/// Reduces the observation matrix of `campaign` at the description's values (base, tool and contacts registered where the
/// campaign estimates them). `hold` names parameters to be held.
///
/// # Errors
/// As [`super::calibrate`].
///
/// ```
/// use elastogeo::estimation::observe;
/// use elastogeo::identifiability::{Criterion, DEFAULT_TOLERANCE, Scaling};
///
/// let loaded = elastogeo::files::load_campaign("ir663-paper-poses", None)?;
/// let criterion = Criterion::Relative(DEFAULT_TOLERANCE);
/// let found = observe(&loaded.robot.model, &loaded.campaign, &[], Scaling::Norm, criterion, None)?.identifiability;
/// assert_eq!((found.columns, found.rank, found.kept.len()), (43, 39, 37)); // as in the IR663 paper
/// # Ok::<(), elastogeo::Error>(())
/// ```
pub fn observe(
    model: &Model,
    campaign: &Campaign,
    hold: &[String],
    scaling: Scaling,
    criterion: Criterion,
    what: Option<What>,
) -> Result<Reduction, CalibrationError> {
    let what = what.unwrap_or_else(|| What::usual(model, campaign));
    let (nominal, settings) = (model.registry.nominal(), RegistrationSettings::default());
    // What contacts tell depends on where they are: a ball off its place would show more, or less, than it does.
    let start = match campaign.targets.iter().any(Target::is_to_be_sought) {
        true => registered(model, campaign, &nominal, &settings)?.0,
        false => rough(model, campaign, &nominal, &settings)?,
    };
    let held: Vec<Slot> = hold.iter().filter_map(|name| model.registry.slot(name)).collect();
    let predictor = Predictor::new(model, campaign, candidates(model, campaign, what)?)?;
    Ok(reduced(&predictor, &start, &row_sigmas(campaign), &held, scaling, criterion)?)
}

/// What is to be estimated: base, tool and markers where the campaign asks for them, then the geometry that the
/// description frees, the springs that it declares identifiable, and the amounts of the effects that it has switched on.
///
/// # Errors
/// [`CalibrationError::NothingElastic`], [`CalibrationError::NothingFree`].
pub fn candidates(model: &Model, campaign: &Campaign, what: What) -> Result<Vec<Slot>, CalibrationError> {
    let mut slots = arrangement(model, campaign);
    if what.geometric {
        slots.extend(model.free_slots().into_iter().filter(|slot| model.registry[*slot].group == Group::Geometry));
    }
    if what.elastic {
        let elastic = model.elastic_slots();
        if elastic.is_empty() && !what.geometric {
            return Err(CalibrationError::NothingElastic);
        }
        slots.extend(elastic);
    }
    // Effects that the description has switched on are as uncertain as all other values of it.
    slots.extend(declared(model).amounts.into_iter().flatten());
    if slots.is_empty() { Err(CalibrationError::NothingFree) } else { Ok(slots) }
}

/// Reduces the observation matrix of the predictor's slots at `values`, its rows divided by `sigmas` (m, rad).
pub(super) fn reduced(
    predictor: &Predictor,
    values: &[f64],
    sigmas: &[f64],
    held: &[Slot],
    scaling: Scaling,
    criterion: Criterion,
) -> Result<Reduction, PredictionError> {
    let identifiability = reduce(&weighted(predictor, values, sigmas)?, &columns(predictor, held), scaling, criterion);
    Ok(Reduction { slots: predictor.slots.clone(), identifiability })
}

/// The observation matrix of the predictor's slots at `values`, row-major, its rows divided by `sigmas` (m, rad); with balls in
/// sockets seated there, off which they would show what the noise alone shows.
pub(super) fn weighted(predictor: &Predictor, values: &[f64], sigmas: &[f64]) -> Result<Vec<f64>, PredictionError> {
    let mut found = match seated(predictor.model, predictor.campaign, values)? {
        Cow::Borrowed(_) => predictor.linearised(values)?,
        Cow::Owned(seated) => Predictor::new(predictor.model, &seated, predictor.slots.clone())?.linearised(values)?,
    };
    for (row, sigma) in found.jacobian.chunks_mut(predictor.slots.len().max(1)).zip(sigmas) {
        row.iter_mut().for_each(|value| *value /= sigma);
    }
    Ok(found.jacobian)
}

/// What its columns are.
pub(super) fn columns(predictor: &Predictor, held: &[Slot]) -> Vec<Column> {
    let about = |slot: &Slot| Column::about(&predictor.model.registry[*slot], held.contains(slot));
    predictor.slots.iter().map(about).collect()
}
