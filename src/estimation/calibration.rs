//! Calibration of a robot's geometry and stiffness from a campaign, stage by stage: base and tool are registered, what the
//! readings cannot separate is merged, the kept parameters are fitted, and the result is judged on readings held out.
//!
//! Sources: IR663 calibration paper (reduction, equivalent springs); KR-270 paper (weights by direction, predicted errors).

use super::covariance::Covariance;
use super::equivalence::Equivalence;
use super::estimated::Fitted;
use super::fit::Fit;
use super::problem::CampaignProblem;
use super::result::{Calibration, CalibrationError};
use super::selection::Selection;
use super::shared::Sharing;
use super::task::{Request, Selected, Task};
use nalgebra::{DMatrix, DVector};

use crate::description::campaign::Campaign;
use crate::least_squares::{Loss, Problem, Progress};

/// Calibrates as [`super::calibrate_as_weighed`] does, springs that end at a bound left there.
///
/// # Errors
/// As [`super::calibrate`].
pub(super) fn calibrate_as_asked(
    request: Request,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    calibrate_from(None, request, progress)
}

/// The same begun, and reduced, at other values (by slot) than those of the registered description.
///
/// # Errors
/// As [`super::calibrate`].
pub(super) fn calibrate_from(
    begin: Option<&[f64]>,
    request: Request,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Calibration, CalibrationError> {
    let Request { model, held_out, settings, .. } = request;
    let task = Task::new(request)?;
    let (before, _) = task.errors(&task.nominal)?;
    let mut start = task.registered()?;
    let (registration, registered) = task.errors(&start)?;
    if let Some(values) = begin {
        start = values.to_vec();
    }
    let mut selection = Selection::new(model, &task.fitted, &task.sigmas, &task.held, settings, &mut start)?;
    let Selected { problem, bounds } = task.problem(&selection, &mut start)?;
    let (found, history) = task.fit(&problem, &bounds, progress)?;
    let covariance = covariance(&task.fitted, &problem, &found, settings.loss);
    let ci95 = covariance.ci95();
    let mut values = problem.values(&found.x);
    let groups = selection.groups.iter().cloned().filter_map(|group| {
        let k = problem.slots().iter().position(|slot| *slot == group.members[0].0)?;
        Some(group.fitted(model, ci95[k], settings.split, &mut values))
    });
    let mut equivalences: Vec<Equivalence> = groups.collect();
    let free = task.back_to_nominal(&selection, &found, &mut values)?;
    equivalences.iter_mut().for_each(|group| group.value = group.springs.of(model, &values));
    let fitted = Fitted { covariance: &covariance, at_bound: &free, logarithms: problem.logarithms() };
    let (after, residual) = task.errors(&values)?;
    let direction_noise = task.direction_noise(&residual);
    let open = task.second_order(&mut selection, &values)?;
    let (predicted, configurations) = task.predicted_error(problem.slots(), &values, &covariance, &residual)?;
    Ok(Calibration {
        fit: task.carried(problem.slots(), &covariance, direction_noise),
        estimates: task.estimates(&selection, &values, &fitted, &open)?,
        predicted,
        configurations,
        slots: selection.predictor.slots,
        identifiability: selection.identifiability,
        values,
        equivalences,
        correlation: covariance.correlation(),
        before,
        registration,
        after,
        noise_ratio: covariance.noise_ratio,
        degrees_of_freedom: covariance.freedom,
        shared: covariance.shared,
        direction_noise,
        iterations: found.iterations,
        history,
        loss: settings.loss,
        ending: found.status,
        residual,
        registered,
        held_out: held_out.to_vec(),
    })
}

/// Covariance of a fit to `fitted`: copies of readings add nothing, readings of one configuration may share errors.
fn covariance(fitted: &Campaign, problem: &CampaignProblem, found: &Fit, loss: Loss) -> Covariance {
    let copies = fitted.copies();
    let is_copy = |index: usize| copies.get(index).is_some_and(Option::is_some);
    let once = fitted.select(|index, _| !is_copy(index));
    let losses: Vec<Loss> = match loss {
        Loss::Squares => Vec::new(),
        _ => (0..found.residual.len()).map(|row| loss.scaled(problem.tuning(row))).collect(),
    };
    let of = |residual: &DVector<f64>, jacobian: &DMatrix<f64>, weights: &DVector<f64>, losses: &[Loss]| {
        let plain = Covariance::new(residual, jacobian, weights, problem.priors());
        let shared = |of: Covariance| match Sharing::of(&once) {
            Some(sharing) => of.sharing(residual, jacobian, weights, &sharing),
            None => of,
        };
        if losses.is_empty() {
            return shared(plain);
        }
        let together = shared(plain.clone());
        plain.clone().robust(residual, jacobian, losses).as_wide(&plain, together)
    };
    if once.readings.len() == fitted.readings.len() {
        return of(&found.residual, &found.jacobian, &found.weights, &losses);
    }
    let readings = fitted.readings.iter().enumerate();
    let copied = readings.flat_map(|(index, reading)| std::iter::repeat_n(is_copy(index), reading.observes.rows()));
    let rows: Vec<usize> = copied
        .chain(std::iter::repeat(false))
        .take(found.residual.len())
        .enumerate()
        .filter_map(|(row, copied)| (!copied).then_some(row))
        .collect();
    let losses: Vec<Loss> = rows.iter().filter_map(|&row| losses.get(row).copied()).collect();
    let weights = found.weights.select_rows(&rows);
    of(&found.residual.select_rows(&rows), &found.jacobian.select_rows(&rows), &weights, &losses)
}
