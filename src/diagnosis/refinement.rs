//! Second pass over continuous nonlinear parameters: values between those offered at first.

use nalgebra::{DMatrix, DVector};

use super::inputs::Inputs;
use super::linear_problem::LinearProblem;
use crate::description::campaign::Campaign;
use crate::effects::{Nonlinear, Survey};
use crate::math::{least_squares, orthonormal, project_off};
use crate::model::Model;
use crate::prediction::{PredictionError, Term, effect_columns};

/// Refines the nonlinear parameters of the members in place, to what readings that span so much tell, fitted to all but the readings that
/// are `unused`.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn refine(
    inputs: &Inputs,
    values: &[f64],
    survey: &Survey,
    problem: &mut LinearProblem,
    members: &[usize],
    unused: &[bool],
) -> Result<(), PredictionError> {
    let settings = &inputs.settings.selection;
    let center = |problem: &LinearProblem, h: usize| problem.hypotheses[h].nonlinear.continuous();
    let continuous: Vec<(usize, f64)> = members.iter().filter_map(|&h| Some((h, center(problem, h)?))).collect();
    let rows: Vec<usize> = (0..problem.rows()).filter(|&row| unused.get(problem.reading[row]) != Some(&true)).collect();
    let residual = problem.residual.select_rows(&rows);
    let squares = |problem: &LinearProblem| {
        let span = orthonormal(&problem.design(members).select_rows(&rows), None);
        project_off(&residual, &span).norm_squared()
    };
    for &(h, center) in &continuous {
        let steps = -settings.refinements..=settings.refinements;
        let mut ratio = settings.refinement_ratio;
        let mut tried: Vec<f64> = steps.map(|k| center * ratio.powi(k)).collect();
        let mut best: Option<(f64, Nonlinear, DMatrix<f64>)> = None;
        // Weighted squares are chi-square: a value is known well enough where its neighbours are worse by less than one standard
        // deviation of it makes.
        loop {
            let before = best.as_ref().map(|known| known.0);
            let mut worst = before.unwrap_or(0.0);
            for (nonlinear, columns) in columns_of(inputs, values, survey, problem, h, &tried)? {
                problem.hypotheses[h].columns.copy_from(&columns);
                let left = squares(problem);
                worst = worst.max(left);
                if best.as_ref().is_none_or(|known| left < known.0) {
                    best = Some((left, nonlinear, columns));
                }
            }
            let Some((least, nonlinear, _)) = &best else { break };
            let is_known = before.is_some() && worst - least < settings.refined;
            ratio = ratio.sqrt();
            if is_known || ratio - 1.0 < FINEST {
                break;
            }
            let value = nonlinear.continuous().unwrap_or(center);
            tried = vec![value / ratio, value * ratio];
        }
        if let Some((_, nonlinear, columns)) = best {
            problem.hypotheses[h].nonlinear = nonlinear;
            problem.hypotheses[h].columns = columns;
        }
    }
    Ok(())
}

/// Relative distance of neighbouring values below which nothing is refined further: readings without noise would go on to rounding.
const FINEST: f64 = 1e-4;

/// Relative step by which derivatives are taken: the error of the difference is of its square.
const STEP: f64 = 1e-3;

/// Of each member with a continuous nonlinear parameter: how the weighted readings change with it, by its relative change, the amounts being
/// those of the linear fit.
///
/// # Errors
/// A configuration that cannot be assembled.
pub fn slopes(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    problem: &LinearProblem,
    members: &[usize],
) -> Result<Vec<Option<DVector<f64>>>, PredictionError> {
    let has_any = members.iter().any(|&h| problem.hypotheses[h].nonlinear.continuous().is_some());
    if !has_any {
        return Ok(vec![None; members.len()]);
    }
    let x = least_squares(&problem.design(members), &problem.residual);
    let mut first = problem.nuisance.ncols();
    let mut all = Vec::new();
    for &member in members {
        let hypothesis = &problem.hypotheses[member];
        let amounts = x.rows(first, hypothesis.columns.ncols());
        first += hypothesis.columns.ncols();
        let is_whole = hypothesis.columns.ncols() == hypothesis.parameters.len();
        let Some(value) = hypothesis.nonlinear.continuous().filter(|_| is_whole) else {
            all.push(None);
            continue;
        };
        let tried = [1.0 - STEP, 1.0 + STEP].map(|times| hypothesis.nonlinear.clone().with_continuous(times * value));
        let [less, more] = &weighted_columns(model, campaign, values, problem, member, &tried)?[..] else {
            all.push(None);
            continue;
        };
        all.push(Some((more - less) * amounts / (2.0 * STEP)));
    }
    Ok(all)
}

/// Columns of a hypothesis at values of its continuous nonlinear parameter, but at those that the readings do not span; the value that it
/// has now is never left out.
fn columns_of(
    inputs: &Inputs,
    values: &[f64],
    survey: &Survey,
    problem: &LinearProblem,
    h: usize,
    tried: &[f64],
) -> Result<Vec<(Nonlinear, DMatrix<f64>)>, PredictionError> {
    let hypothesis = &problem.hypotheses[h];
    let (effect, site, now) = (&hypothesis.effect, &hypothesis.site, hypothesis.nonlinear.continuous());
    let of = |&value: &f64| hypothesis.nonlinear.clone().with_continuous(value);
    let is_identifiable = |own: &Nonlinear| own.continuous() == now || effect.is_identifiable(site, survey, own);
    let tried: Vec<Nonlinear> = tried.iter().map(of).filter(is_identifiable).collect();
    let columns = weighted_columns(inputs.model, inputs.campaign, values, problem, h, &tried)?;
    Ok(tried.into_iter().zip(columns).collect())
}

/// Weighted columns of a hypothesis at some of its nonlinear values.
fn weighted_columns(
    model: &Model,
    campaign: &Campaign,
    values: &[f64],
    problem: &LinearProblem,
    h: usize,
    tried: &[Nonlinear],
) -> Result<Vec<DMatrix<f64>>, PredictionError> {
    let hypothesis = &problem.hypotheses[h];
    let terms = tried.iter().map(|own| Term::new(model, &hypothesis.effect, &hypothesis.site, own)).collect();
    let (all, width) = effect_columns(model, campaign, values, terms)?;
    let count = hypothesis.parameters.len();
    let columns = |k: usize| {
        DMatrix::from_fn(problem.rows(), count, |row, c| all[row * width + k * count + c] / problem.sigmas[row])
    };
    Ok((0..tried.len()).map(columns).collect())
}
